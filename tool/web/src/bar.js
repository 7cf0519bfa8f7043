/** The bar at the top, and the messages to the user below it. */

import { attribute, byId, element, fill, text } from "tool/dom.js";
import { ask, EngineError, goOnInThePage, hasEngineInPage, listenToNewEngine, whereIsTheEngine } from "tool/engine.js";
import { forced, release } from "tool/force.js";
import { forgetTracks } from "tool/history.js";
import { toggleDrawer } from "tool/panels.js";
import { source, store } from "tool/store.js";
import { shown } from "tool/values.js";

const MOST_NOTICES = 4;
/** How long a note is shown, in milliseconds. Errors stay. */
const NOTE = 8000;

export function mount() {
  const command = (
    /** @type {string} */ title,
    /** @type {() => void} */ onclick,
    id = `${title.toLowerCase()}-button`,
  ) => element("button", { id, onclick }, title);
  const undo = command("Undo", () => store.undo());
  const redo = command("Redo", () => store.redo());
  const compare = command("Compare", () => toggleDrawer("compare"));
  const away = command("Export", () => toggleDrawer("takeaway"), "away-button");
  const open = command("Open or new", () => toggleDrawer("opening"), "open-button");
  const help = command("Help", () => toggleDrawer("help"));
  byId("commands").append(undo, redo, compare, open, away, help);
  const update = () => {
    const loop = store.loop;
    attribute(undo, "disabled", !loop?.undo.length);
    attribute(redo, "disabled", !loop?.redo.length);
    for (const one of [compare, away]) one.hidden = !loop;
    for (const one of [undo, redo, open]) one.hidden = !loop;
    showWhat();
  };
  for (const what of ["loop", "loops", "settings", "plant"]) store.on(what, update);
  store.on("forced", showWhat);
  update();
  store.on("say", notice);
  // Reserve space for the messages, so that they do not cover the content.
  const notices = byId("notices");
  new ResizeObserver(() => {
    const { offsetHeight: height } = notices;
    document.body.style.setProperty("--notices", height > 0 ? `${height + 20}px` : "0px");
  }).observe(notices);
  // A note refers to the last action, so the next change removes it. Errors stay until they are closed or other files
  // are opened.
  const end = (/** @type {string} */ which) => {
    for (const note of byId("notices").querySelectorAll(which)) note.remove();
  };
  for (const what of ["loop", "settings"]) store.on(what, () => end(".notice.is-note"));
  store.on("opening", () => end(".notice.is-error"));
  store.on("home", showLost);
  store.on("question", question);
  listenToNewEngine(() => {
    store.live = undefined;
    forgetTracks();
    for (const loop of store.loops) delete loop.notes.runs;
    store.say("The engine has restarted, and its run is lost. Values are kept; start a new run.");
  });
  store.on("failure", () => store.say(new EngineError(store.state?.failure ?? "")));
}

/** Shows the loop's name, block, cycle and file, and the numbers of changed and forced values. */
function showWhat() {
  const loop = store.loop;
  const what = byId("what");
  document.title = loop ? `${loop.name} (${loop.description.block}) - plcfmu` : "plcfmu: parameter tool";
  if (!loop) {
    delete what.dataset.key;
    return text(what, "");
  }
  const { cycle } = loop.description;
  const held = Object.keys(forced()).length;
  const changed = Object.values(loop.settings).filter((one) => source(one, "sent") === "changed").length;
  const parts = [
    element("strong.loop-name", loop.name || "(no name)"),
    loop.notes.title && element("span.loop-title", { title: loop.notes.title }, loop.notes.title),
    // A loop named after its block needs no second mention of the block.
    loop.name !== loop.description.block && element("span", loop.description.block),
    cycle &&
      loop.settings[cycle] &&
      element("span", `${cycle} ${shown(loop.settings[cycle].sent, loop.settings[cycle].variable.kind)} s`),
    element("span.faint", loop.file ? `from ${loop.file}` : "new"),
    element("span", { class: changed > 0 ? "note" : "faint" }, changed > 0 ? `${changed} changed` : "unchanged"),
    held > 0 &&
      element(
        "button.is-forced",
        { title: "Release all", onclick: () => release().catch(store.say) },
        `${held} forced`,
      ),
  ];
  const key = parts.map((part) => (part ? part.textContent : "")).join("|");
  if (what.dataset.key === key) return;
  what.dataset.key = key;
  fill(what, parts);
}

/** @param {import("./store.js").Said} said */
function notice({ text: sentence, isError }) {
  const notices = byId("notices");
  const same = [...notices.querySelectorAll(".notice")].find(
    (one) => one.querySelector(".sentence")?.textContent === sentence,
  );
  if (same) return;
  const made = element(
    "div",
    { class: isError ? "notice row is-error" : "notice row is-note" },
    element("span.kind", isError ? "Error" : "Note"),
    element("span.sentence", sentence),
    element("button.plain", { "aria-label": "Close this message", onclick: () => made.remove() }, "Close"),
  );
  notices.append(made);
  if (!isError) setTimeout(() => made.remove(), NOTE);
  for (const old of [...notices.querySelectorAll(".notice")].slice(0, -MOST_NOTICES)) old.remove();
}

/** @param {{ text: string, yes: string, no?: string, act: () => Promise<void> }} asked */
function question({ text: sentence, yes, no = "No", act }) {
  const answer = () => {
    made.remove();
    act().catch(store.say);
  };
  const made = element(
    "div.notice.row",
    { role: "group", "aria-label": "Question" },
    element("span.kind", "Question"),
    element("span.sentence", sentence),
    element("button.primary", { onclick: answer }, yes),
    element("button", { onclick: () => made.remove() }, no),
  );
  byId("notices").append(made);
  made.querySelector("button")?.focus();
}

/** If the server does not respond, offers to try again or, if possible, to continue with the page's own engine. */
function showLost() {
  document.getElementById("lost")?.remove();
  if (!store.isLost) return;
  const again = () => ask({ do: "catalogue" }).then(found).catch(store.say);
  const found = () => {
    store.isLost = false;
    store.live = undefined;
    store.emit("home");
  };
  const goOn = async () => {
    goOnInThePage();
    store.descriptions.clear();
    found();
    try {
      store.catalogue = await ask({ do: "catalogue" });
      store.emit("catalogue");
      const missing = store.loops.filter(
        (loop) => !store.catalogue.fmus.some((one) => one.name === loop.description.name),
      );
      for (const loop of missing) store.say(`${loop.name}: the page has no built-in block ${loop.description.name}.`);
    } catch (error) {
      store.say(error);
    }
  };
  byId("notices").prepend(
    element(
      "div.row.is-error",
      { id: "lost" },
      element("span", "plcfmu tool is not responding. Everything shown is kept."),
      element("button", { onclick: again }, "Try again"),
      hasEngineInPage() &&
        whereIsTheEngine() === "server" &&
        element("button.primary", { onclick: goOn }, "Continue in the page without FMUs"),
    ),
  );
}
