/**
 * The signals of a timing diagram: which are shown, how each is drawn, and the list in which the user chooses them. The
 * choice is stored with the loop.
 *
 * @typedef {import("tool/signals.js").Signal} Signal
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Shown a signal in the diagram
 * @property {"lane" | "band" | "panel"} kind
 * @property {string} name `TankFilling.step`
 * @property {string} label
 * @property {string} type PLC type
 * @property {string} unit
 * @property {Map<number, string>} names names of its values; empty if they are not steps
 * @property {number} colour index in the palette
 * @property {boolean} isDashed
 * @property {boolean} isStepped whether each value holds until the next one
 */

import { element, fill } from "tool/dom.js";
import { programNamed } from "tool/program.js";
import { called, isSwitch, roles, signals, unitText } from "tool/signals.js";
import { steps } from "tool/steps.js";
import { store } from "tool/store.js";
import { number, plcText, shown } from "tool/values.js";

/** The maximum number of signals shown by default, and of signals listed. */
const [MOST_FIRST, MOST_LISTED] = [24, 200];
/** The index of the first free colour, after those of setpoint, process value and manipulated value. */
const FIRST_COLOUR = 3;
const BITS = /^(BYTE|WORD|DWORD)$/;

/**
 * The steps of programs, by name in the catalogue. They never change: changed sources get a new name.
 *
 * @type {Map<string, ReturnType<typeof steps>>}
 */
const found = new Map();

/** @param {string} fmu */
function stepsOf(fmu) {
  const of = programNamed(fmu);
  if (!of) return new Map();
  const made = found.get(fmu) ?? steps(of.compiled, of.program);
  found.set(fmu, made);
  return made;
}

/**
 * The names of a variable's values, if they are steps.
 *
 * @param {Work} loop
 * @param {Signal} of
 * @returns {Map<number, string> | undefined}
 */
function namesOf(loop, { member, variable }) {
  const fmu = member === loop.member ? loop.description.name : loop.members.find(({ name }) => name === member)?.fmu;
  return fmu ? stepsOf(fmu).get(variable.name.replaceAll("'", "").toUpperCase()) : undefined;
}

/**
 * The signals shown for a loop: the user's choice; by default, the program's inputs, outputs, steps and setpoint.
 *
 * @param {Work} loop
 * @returns {Promise<Shown[]>}
 */
export async function shownSignals(loop) {
  const all = await signals(loop);
  const { setpoint, processValue, manipulatedValue } = roles(loop);
  const places = [setpoint, processValue, manipulatedValue];
  let colour = FIRST_COLOUR;
  return chosen(loop, all).map((signal) => {
    const { name, variable } = signal;
    const names = namesOf(loop, signal);
    const isBand = names !== undefined || BITS.test(variable.kind);
    const kind = isSwitch(variable) ? "lane" : isBand ? "band" : "panel";
    const place = places.indexOf(name);
    return {
      ...{ kind, name, label: called(loop, name), type: variable.kind, unit: unitText(variable.unit) },
      ...{ names: names ?? new Map(), colour: place >= 0 ? place : kind === "panel" ? colour++ : 0 },
      ...{ isDashed: place === 0, isStepped: variable.kind !== "REAL" },
    };
  });
}

/**
 * @param {Work} loop
 * @param {Signal[]} all
 */
function chosen(loop, all) {
  /** @type {string[] | undefined} */
  const kept = loop.notes.timing?.shown;
  if (kept) return kept.flatMap((name) => all.find((one) => one.name === name) ?? []);
  const isOwn = (/** @type {Signal} */ { member }) => member === loop.member;
  const terminals = all.filter((one) => isOwn(one) && ["input", "output"].includes(one.variable.role));
  const own = all.filter((one) => isOwn(one) && one.variable.role === "local" && namesOf(loop, one));
  const { setpoint } = roles(loop);
  const goal = all.filter((one) => one.name === setpoint && !terminals.includes(one));
  return [...terminals, ...own, ...goal].slice(0, MOST_FIRST);
}

/**
 * A value in PLC notation; a step with its name, if `isNamed`.
 *
 * @param {import("./messages").Value} value
 * @param {Shown} of
 * @param {boolean} [isNamed]
 */
export function valueText(value, { type, kind, names }, isNamed = true) {
  const name = isNamed && names.get(number(value));
  if (name) return `${shown(value, type)} ${name}`;
  if (kind === "lane") return shown(number(value) === 1, "BOOL");
  return plcText(value, type, 5);
}

/**
 * Creates the list for choosing signals, initially folded.
 *
 * @param {() => void} changed
 */
export function chooser(changed) {
  const search = element("input", { type: "search", placeholder: "Part of a name", "aria-label": "Search signals" });
  const list = element("div.choices");
  const form = element("div.chooser-form", search, list);
  const summary = element("summary.button", "Signals");
  const fold = element("details.options.signals-chooser", summary, form);
  const show = async () => {
    const loop = store.loop;
    if (!loop || !fold.open) return;
    const all = await signals(loop);
    const now = new Set(chosen(loop, all).map(({ name }) => name));
    const wanted = search.value.trim().toUpperCase();
    const fitting = all.filter(({ name, variable }) =>
      [name, variable.description].some((of) => of.toUpperCase().includes(wanted)),
    );
    // Signals in the diagram come first.
    const sorted = [...fitting.filter(({ name }) => now.has(name)), ...fitting.filter(({ name }) => !now.has(name))];
    const choice = (/** @type {Signal} */ { name, variable }) => {
      const box = element("input", { type: "checkbox", checked: now.has(name) });
      box.addEventListener("change", () => {
        const names = chosen(loop, all).map((one) => one.name);
        const next = box.checked ? [...names, name] : names.filter((one) => one !== name);
        loop.notes.timing = { ...loop.notes.timing, shown: next };
        changed();
        // Have the session saved with the choice.
        store.emit("settings", []);
      });
      const unit = unitText(variable.unit);
      const about = [variable.kind, unit].filter(Boolean).join(", ");
      return element(
        "label",
        { title: variable.description },
        box,
        element("span.name", called(loop, name)),
        element("span.faint", about),
      );
    };
    const left = sorted.length - MOST_LISTED;
    fill(
      list,
      sorted.slice(0, MOST_LISTED).map(choice),
      sorted.length === 0 && element("p.faint", "No signal has this text in its name or comment."),
      left > 0 && element("p.faint", `${left} more: type part of the name.`),
    );
  };
  search.addEventListener("input", show);
  fold.addEventListener("toggle", () => {
    show();
    if (fold.open) search.focus();
  });
  fold.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    fold.open = false;
    summary.focus();
  });
  document.addEventListener("pointerdown", (event) => {
    if (event.target instanceof Node && !fold.contains(event.target)) fold.open = false;
  });
  const follow = (/** @type {Work} */ loop) => {
    const count = loop.notes.timing?.shown?.length;
    summary.textContent = count === undefined ? "Signals" : `Signals (${count})`;
  };
  return { fold, follow };
}
