/** The settings that differ from the loop's file or, for a new loop, from the block's start values. */

import { byId, element, fill, tableHead } from "tool/dom.js";
import { toggleDrawer } from "tool/panels.js";
import { goTo } from "tool/parameters.js";
import { store } from "tool/store.js";
import { same, shown } from "tool/values.js";

/** @param {HTMLElement} content */
export function mount(content) {
  const update = () => {
    if (!byId("compare").hidden) show(content);
  };
  for (const what of ["loop", "settings", "open-compare"]) store.on(what, update);
}

/** @param {HTMLElement} content */
function show(content) {
  const loop = store.loop;
  const close = element("button.close", { onclick: () => toggleDrawer("compare", false) }, "Close");
  if (!loop) return fill(content, close);
  const settings = Object.entries(loop.settings);
  const base = (/** @type {import("./store.js").Setting} */ one) => one.file ?? one.start;
  const different = settings.filter(
    ([, one]) => !same(one.variable.kind, one.value, base(one)) || !same(one.variable.kind, one.sent, base(one)),
  );
  const what = loop.file ? `the file ${loop.file}` : "the block's start values";
  const title = document.getElementById("compare-title");
  if (title) title.textContent = `Compare with ${what}`;
  if (different.length === 0) return fill(content, close, element("p", `Nothing differs from ${what}.`));
  const takeAll = () => store.edit(Object.fromEntries(different.map(([name, one]) => [name, base(one)])));
  const back = element("span.visually-hidden", "Back");
  const columns = ["Setting", loop.file ? "File" : "Start", "Field", "In force", "Unit", back];
  fill(
    content,
    close,
    element("p", `${different.length} of ${settings.length} settings differ from ${what}.`),
    element(
      "div.wide",
      element(
        "table",
        tableHead(columns, (at) => at > 0 && at < 4),
        element(
          "tbody",
          different.map(([name, one]) => row(name, one, base(one))),
        ),
      ),
    ),
    element(
      "button",
      { onclick: takeAll },
      loop.file ? "Restore all values from the file" : "Restore all start values",
    ),
  );
}

/**
 * @param {string} name
 * @param {import("./store.js").Setting} one
 * @param {import("./messages").Value} base
 */
function row(name, one, base) {
  const { kind, unit } = one.variable;
  const isFromFile = one.file !== undefined;
  const take = () => store.edit({ [name]: base });
  const title = isFromFile ? one.origin : "the block's start value";
  return element(
    "tr",
    element("td", element("button.plain.name", { onclick: () => goTo(name) }, name)),
    element("td.number", { title }, shown(base, kind)),
    element("td.number", shown(one.value, kind)),
    element("td.number", shown(one.sent, kind)),
    element("td", unit ?? (kind === "TIME" ? "s" : "")),
    element(
      "td",
      element("button.plain", { "aria-label": `Restore ${shown(base, kind)} in ${name}`, onclick: take }, "Restore"),
    ),
  );
}
