/** Help on each field, from the FMU's documentation; and a panel that describes the keys and the block. */

import { assetOf, html } from "tool/assets.js";
import { attribute, element, fill } from "tool/dom.js";
import { toggleDrawer } from "tool/panels.js";
import { store } from "tool/store.js";
import { isTime, shown } from "tool/values.js";

/** @type {[string, string][]} */
const KEYS = [
  ["Enter", "in a field: applies all edits"],
  ["Esc", "in a field: discards the edit; closes help and comparison"],
  ["F1 or ?", "in a field: opens its help; elsewhere: this page"],
  ["Ctrl+Z, Ctrl+Y", "undo, redo"],
  ["Ctrl+Enter", "applies all edits"],
  ["Space", "runs, pauses"],
  [".", "runs one cycle"],
  ["M", "switches manual mode on and off"],
  ["Left, Right", "move the cursor in curves and timing diagram; ten times as far with Shift"],
  ["Page Up, Page Down", "move the cursor 50 points in the curves, and to the next change in the timing diagram"],
  ["Home, End", "move the cursor to the beginning or the end"],
  ["+, -", "zoom curves and timing diagram"],
  ["Esc", "in curves and timing diagram: follows the run again"],
];

/** @param {HTMLElement} content */
export function mount(content) {
  const about = element("div.about");
  content.append(
    element("button.close", { onclick: () => toggleDrawer("help", false) }, "Close"),
    element("h3", "Keys"),
    element("p.faint", "Keys without Ctrl work only outside fields, unless stated otherwise."),
    element(
      "table.keys",
      element(
        "tbody",
        KEYS.map(([key, what]) => element("tr", element("th", { scope: "row" }, key), element("td", what))),
      ),
    ),
    about,
  );
  const show = async () => {
    const loop = store.loop;
    fill(about);
    if (!loop) return;
    const asset = await assetOf(loop.description.name);
    if (loop !== store.loop) return;
    fill(about, element("h3", loop.description.block), element("p", loop.description.summary));
    if (asset?.about) about.append(html(asset.about));
  };
  store.on("loop", show);
}

/**
 * Opens or closes the help on one or more settings, below their field.
 *
 * @param {string | string[]} names
 * @param {HTMLElement} row
 * @param {HTMLElement} field gets the focus back
 */
export async function fieldHelp(names, row, field) {
  const button = row.querySelector(".ask");
  const close = () => {
    box?.remove();
    if (button) attribute(button, "aria-expanded", "false");
    field.focus();
  };
  let box = row.nextElementSibling?.classList.contains("field-help") ? row.nextElementSibling : null;
  if (box) return close();
  const loop = store.loop;
  if (!loop) return;
  for (const other of document.querySelectorAll(".field-help")) other.remove();
  for (const other of document.querySelectorAll('.ask[aria-expanded="true"]'))
    attribute(other, "aria-expanded", "false");
  const asset = await assetOf(loop.description.name);
  const texts = [names].flat().map((name) => {
    const { variable } = loop.settings[name];
    const of = element("div", element("h4", element("span.name", name), ` ${variable.kind}`));
    of.append(element("p", variable.description || "No description."));
    if (asset?.help[name]) of.append(html(asset.help[name]));
    of.append(element("p.faint", limits(variable)));
    return of;
  });
  box = element(
    "div.field-help",
    { role: "region", "aria-label": `Help on ${[names].flat().join(", ")}` },
    texts,
    element("button", { onclick: () => close() }, "Close"),
  );
  box.addEventListener("keydown", (event) => {
    if (/** @type {KeyboardEvent} */ (event).key !== "Escape") return;
    event.stopPropagation();
    close();
  });
  row.after(box);
  if (button) attribute(button, "aria-expanded", "true");
  box.scrollIntoView({ block: "nearest" });
}

/**
 * Start value and range of a variable.
 *
 * @param {import("./messages").Variable} variable
 */
function limits({ kind, start, min, max, unit }) {
  const written = (/** @type {import("./messages").Value | null} */ value) =>
    `${shown(value, kind)}${unit ? ` ${unit}` : isTime(kind) ? " s" : ""}`;
  const range =
    min === null && max === null
      ? ""
      : ` Range ${min === null ? "" : written(min)} ... ${max === null ? "" : written(max)}.`;
  return `Start value ${written(start)}.${range}`;
}
