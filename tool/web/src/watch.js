/**
 * The watch table: variables chosen by the user, with their values now or at the cursor. Each can be set once, or
 * forced in every call. The choice is stored with the loop.
 *
 * @typedef {import("./messages").Value} Value
 * @typedef {import("tool/signals.js").Signal} Signal
 * @typedef {import("tool/store.js").Work} Work
 */

import { breakpointField } from "tool/breakpoint.js";
import { attribute, choice, element, fill, tableHead, text } from "tool/dom.js";
import { force, forced, isForced, release, write } from "tool/force.js";
import { onceAFrame } from "tool/frame.js";
import { cursorTime, momentText, momentValues } from "tool/moment.js";
import { programOf } from "tool/program.js";
import { called, isSwitch, signals, unitText } from "tool/signals.js";
import { isSettable, split, store } from "tool/store.js";
import { plcText, read, shown } from "tool/values.js";

/** The maximum number of names offered in the list. */
const MOST_OFFERED = 300;

/** @type {HTMLElement} */
let body;
/** @type {HTMLElement} */
let head;
/** @type {HTMLButtonElement} */
let releaseAll;
/** @type {HTMLInputElement} */
let adding;
/** @type {HTMLElement} */
let offers;
/** All variables of the loop. @type {Signal[]} */
let available = [];
/** Functions that update each row. @type {(() => void)[]} */
let rows = [];

/** @param {HTMLElement} content */
export function mount(content) {
  offers = element("datalist", { id: "watch-names" });
  adding = element("input", {
    ...{ id: "watch-add", list: "watch-names", placeholder: "Add a variable", "aria-label": "Add a variable" },
    ...{ autocomplete: "off", spellcheck: "false" },
  });
  adding.addEventListener("change", add);
  releaseAll = element("button.release-all", { onclick: () => release().catch(store.say) });
  head = element("span.faint");
  body = element("div.wide");
  fill(content, element("div.row", adding, offers, releaseAll, breakpointField(), head), body);
  for (const what of ["loop", "plant"]) store.on(what, build);
  for (const what of ["state", "moment", "forced"]) store.on(what, refresh);
  build();
}

/** The watched names, in order. @param {Work} loop @returns {string[]} */
function watched(loop) {
  return loop.notes.watch ?? [];
}

/** @param {string[]} names */
function keep(names) {
  if (store.loop) store.loop.notes.watch = names;
  store.emit("settings", []);
  build();
}

function add() {
  const loop = store.loop;
  const wanted = adding.value.trim().toUpperCase();
  const found = available.find(({ name }) =>
    [name, loop && called(loop, name)].some((one) => one?.toUpperCase() === wanted),
  );
  if (!loop || !wanted) return;
  adding.setCustomValidity(found ? "" : `${adding.value} is not a variable: choose one from the list.`);
  adding.reportValidity();
  if (!found) return;
  adding.value = "";
  if (!watched(loop).includes(found.name)) keep([...watched(loop), found.name]);
}

/** Builds the table for the current loop. */
async function build() {
  const loop = store.loop;
  if (!loop || !programOf(loop)) return;
  available = await signals(loop).catch(() => []);
  if (store.loop !== loop) return;
  fill(
    offers,
    available.slice(0, MOST_OFFERED).map(({ name }) => element("option", { value: called(loop, name) })),
  );
  rows = [];
  const shownRows = watched(loop).flatMap((name) => {
    const signal = available.find((one) => one.name === name);
    return signal ? row(loop, signal) : [];
  });
  fill(
    body,
    shownRows.length === 0
      ? element("p.faint", "Lists program variables with their values; each can be set or forced.")
      : element(
          "table.watch",
          tableHead(["Variable", "Value", "Unit", "New value", ""], (column) => column === 1),
          element("tbody", shownRows),
        ),
  );
  refresh();
}

const refresh = onceAFrame(() => {
  for (const show of rows) show();
  const count = Object.keys(forced()).length;
  text(releaseAll, `Release all ${count}`);
  releaseAll.hidden = count === 0;
  text(head, cursorTime() === undefined ? "" : `Values ${momentText()}`);
});

/** @param {Work} loop @param {Signal} signal */
function row(loop, { name, member, variable }) {
  const value = element("td.number.value");
  const field = isSwitch(variable)
    ? choice({}, [["FALSE"], ["TRUE"]])
    : element("input.number", { size: 9, autocomplete: "off" });
  attribute(field, "aria-label", `New value of ${called(loop, name)}`);
  const wire = loop.connections.find(([, to]) => to === name)?.[0];
  const given = () => {
    const got = read(field.value, variable);
    field.setCustomValidity("why" in got ? got.why : "");
    field.reportValidity();
    return "value" in got ? { [name]: got.value } : undefined;
  };
  const set = () => {
    const values = given();
    if (!values) return;
    // A tunable setting is set like in its own field, so that the field and the next run have the value, too.
    const isInput = isSettable(variable) && variable.is_tunable && !wire && !isForced(name);
    const own = member === loop.member ? { [split(name)[1]]: values[name] } : values;
    (isInput ? store.now(own) : write(values)).catch(store.say);
  };
  const hold = () => {
    const values = given();
    if (values) force(values).catch(store.say);
  };
  field.addEventListener("keydown", (event) => {
    if (event instanceof KeyboardEvent && event.key === "Enter") set();
  });
  const setting = element("button", { onclick: set, title: "Once, before the next cycle" }, "Set");
  const holding = element("button", { onclick: hold, title: "In every cycle, until it is released" }, "Force");
  const releasing = element("button", { onclick: () => release([name]).catch(store.say) }, "Release");
  const remove = () => keep(watched(loop).filter((one) => one !== name));
  const made = element(
    "tr",
    { "data-watch": name },
    element(
      "td",
      { title: variable.description },
      element(
        "button.plain.name",
        { "aria-label": `Why ${called(loop, name)}?`, onclick: () => store.emit("why", name) },
        called(loop, name),
      ),
    ),
    value,
    element("td.faint", unitText(variable.unit)),
    element("td", element("div.row", field, setting, holding, releasing)),
    element("td", element("button.plain", { "aria-label": `Remove ${name}`, onclick: remove }, "×")),
  );
  rows.push(() => {
    const now = momentValues()[name];
    const isHeld = isForced(name);
    text(value, plcText(now, variable.kind));
    attribute(value, "title", now === undefined ? undefined : shown(now, variable.kind));
    made.classList.toggle("is-forced", isHeld);
    releasing.hidden = !isHeld;
    setting.disabled = isHeld || wire !== undefined;
    attribute(
      setting,
      "title",
      wire ? `${wire} sets it in every cycle: force it instead` : "Once, before the next cycle",
    );
  });
  return made;
}
