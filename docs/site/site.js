// What the pages of the site do beyond showing themselves: search, copy buttons, headings that link, menus that close. It works from a disk as
// from a server, and asks nobody.
"use strict";

/** How many places a search shows. */
const MOST = 12;
/** How much of a text is shown around a word that was found. */
const BEFORE = 40, AROUND = 150;

/** How well an entry of the index fits the words: 0 if one of them is missing. */
function score([page, , heading, text], words, pages) {
    const title = pages[page][1].toLowerCase(), head = heading.toLowerCase(), body = text.toLowerCase();
    // The words beside each other count more than apart, and a page more than a section of another one.
    const phrase = words.join(" ");
    let sum = head === phrase ? 100 : words.length > 1 && head.includes(phrase) ? 40 : 0;
    if (head === title) sum += 10;
    for (const word of words) {
        const isWord = new RegExp(`(^|[^a-z0-9_])${word.replace(/[^a-z0-9_]/g, "\\$&")}`);
        const best = Math.max(
            head === word ? 100 : 0,
            isWord.test(head) ? 40 : head.includes(word) ? 15 : 0,
            title === word ? 30 : isWord.test(title) ? 12 : 0,
            isWord.test(body) ? 5 : body.includes(word) ? 1 : 0,
        );
        if (best === 0) return 0;
        sum += best;
    }
    return sum;
}

/** The places that fit a query best. */
function find(query, {pages, entries}) {
    const words = query.toLowerCase().split(/\s+/).filter(Boolean);
    if (words.length === 0) return [];
    const found = entries.map((entry) => ({entry, score: score(entry, words, pages)})).filter((one) => one.score > 0);
    found.sort((a, b) => b.score - a.score);
    return found.slice(0, MOST).map(({entry: [page, anchor, heading, text]}) => {
        const at = Math.max(0, ...words.map((word) => text.toLowerCase().indexOf(word)));
        const from = at > BEFORE ? text.indexOf(" ", at - BEFORE) + 1 : 0;
        const address = pages[page][0] + (anchor && `#${encodeURIComponent(anchor)}`);
        const isLong = text.length > from + AROUND;
        const said = text.slice(from, isLong ? text.lastIndexOf(" ", from + AROUND) : undefined);
        return {address, title: pages[page][1], heading, text: (from ? "… " : "") + said + (isLong ? " …" : "")};
    });
}

function element(name, content, className = "") {
    const made = document.createElement(name);
    made.textContent = content;
    if (className) made.className = className;
    return made;
}

function search(form) {
    const root = form.dataset.root, input = form.querySelector("input"), list = form.querySelector(".found");
    let loading;
    // The index is large: it is loaded by who searches.
    const load = () => loading ??= new Promise((resolve, reject) => {
        const script = document.createElement("script");
        script.onload = () => resolve(window.plcfmuIndex);
        script.onerror = () => reject(new Error("search.js cannot be loaded"));
        script.src = `${root}search.js`;
        document.head.append(script);
    });
    const show = async () => {
        const query = input.value.trim();
        list.hidden = query.length < 2;
        if (list.hidden) return;
        const places = find(query, await load());
        if (query !== input.value.trim()) return;
        list.replaceChildren(...places.map(({address, title, heading, text}) => {
            const link = element("a", "");
            link.href = root + address;
            link.append(element("strong", heading), heading === title ? "" : ` ${title}`, element("span", text));
            return link;
        }));
        if (places.length === 0) list.append(element("p", `Nothing has all words of “${query}”.`));
    };
    const move = (by) => {
        const stops = [input, ...list.querySelectorAll("a")];
        stops[(stops.indexOf(document.activeElement) + by + stops.length) % stops.length].focus();
    };
    input.addEventListener("focus", load);
    input.addEventListener("input", show);
    form.addEventListener("submit", (event) => {
        event.preventDefault();
        list.querySelector("a")?.click();
    });
    form.addEventListener("keydown", (event) => {
        const step = {ArrowDown: 1, ArrowUp: -1}[event.key];
        if (event.key === "Escape") {
            list.hidden = true;
            input.focus();
        } else if (step && !list.hidden) {
            event.preventDefault();
            move(step);
        }
    });
    // A result may be on this page.
    list.addEventListener("click", () => { list.hidden = true; });
    document.addEventListener("click", (event) => { if (!form.contains(event.target)) list.hidden = true; });
    document.addEventListener("keydown", (event) => {
        const isTyping = document.activeElement.matches("input, textarea, select");
        if (event.key === "/" && !isTyping && !event.ctrlKey && !event.metaKey && !event.altKey) {
            event.preventDefault();
            input.focus();
        }
    });
    form.hidden = false;
}

/** Copies a text, also where the browser gives the clipboard to pages of a server only. */
async function copy(text) {
    try {
        await navigator.clipboard.writeText(text);
    } catch {
        const area = document.createElement("textarea");
        area.value = text;
        document.body.append(area);
        area.select();
        document.execCommand("copy");
        area.remove();
    }
}

for (const sample of document.querySelectorAll("main pre:has(> code)")) {
    const frame = element("div", "", "sample"), button = element("button", "Copy");
    button.type = "button";
    sample.replaceWith(frame);
    frame.append(sample, button);
    button.addEventListener("click", async () => {
        await copy(sample.textContent);
        button.textContent = "Copied";
        setTimeout(() => { button.textContent = "Copy"; }, 2000);
    });
}

// A heading is a link to itself, for who wants to pass its address on. Those who use the keyboard have the contents.
for (const heading of document.querySelectorAll("main :is(h2, h3)[id]")) {
    if (heading.querySelector("a")) continue;
    const link = element("a", "", "here");
    link.href = `#${heading.id}`;
    link.tabIndex = -1;
    link.append(...heading.childNodes);
    heading.append(link);
}

const menus = [...document.querySelectorAll("details.menu")];
document.addEventListener("click", (event) => {
    for (const menu of menus) if (!menu.contains(event.target)) menu.open = false;
});
document.addEventListener("keydown", (event) => {
    const open = menus.find((menu) => menu.open);
    if (event.key === "Escape" && open) {
        open.open = false;
        open.querySelector("summary").focus();
    }
});
document.querySelectorAll("form.search").forEach(search);
