/** What the run comes to since the setpoint was changed, in figures with units. What cannot be said says why. */

import { element, fill, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { units, unitText } from "tool/signals.js";
import { store } from "tool/store.js";
import { rounded } from "tool/values.js";

/** While calls are made, the figures are asked for so often, in milliseconds. */
const INTERVAL = 300;

/** @typedef {import("./messages").Figures} Figures */

/** What is shown: name, meaning, value and unit. @type {[string, string, (of: Figures) => [number | null, string]][]} */
const SHOWN = [
  ["rise", "From 10 % to 90 % of the step", (of) => [of.rise, "s"]],
  ["overshoot", "Beyond the setpoint, in percent of the step", (of) => [of.overshoot, "%"]],
  ["settled", "From then on within 2 % of the step", (of) => [of.settled, "s"]],
  ["IAE", "Integral of the deviation's amount", (of) => [of.iae, product(of.unit, "s")]],
  ["ISE", "Integral of the deviation's square", (of) => [of.ise, product(of.unit ? `${unitText(of.unit)}²` : "", "s")]],
  ["peak", "Largest deviation", (of) => [of.peak, unitText(of.unit)]],
  ["travel", "How far the manipulated value moves in all", (of) => [of.travel, unitText(of.travel_unit)]],
  ["pulses", "How many pulses begin", (of) => [of.pulses, ""]],
];

/** @type {HTMLElement} */
let body;
/** @type {HTMLElement} */
let heading;
/** @type {HTMLElement} */
let remarks;
/** @type {Map<string, HTMLElement>} */
const places = new Map();
let isWaiting = false;
let isAgain = false;

/** @param {HTMLElement} content */
export function mount(content) {
  heading = element("p", { class: "faint" });
  remarks = element("ul", { class: "remarks faint" });
  body = element(
    "dl",
    { class: "figures" },
    SHOWN.map(([name, title]) => {
      const place = element("dd", {}, "–");
      places.set(name, place);
      return element("div", { title }, element("dt", {}, name), place);
    }),
  );
  fill(content, heading, body, remarks);
  for (const what of ["state", "run", "loop"]) store.on(what, update);
  show(undefined);
}

/** Asks for the figures, not more often than anyone can read them. */
async function update() {
  if (isWaiting) {
    isAgain = true;
    return;
  }
  isWaiting = true;
  isAgain = false;
  const loop = store.loop;
  const begun = performance.now();
  if (!loop || !store.isLive() || (store.state?.calls ?? 0) === 0) show(undefined);
  else if (loop.description.roles.setpoint === null || loop.description.roles.process_value === null) {
    show(undefined, `${loop.description.block} has no setpoint and no process value, so there are no figures.`);
  } else {
    try {
      const figures = await ask({ do: "figures" });
      const { processValue, manipulatedValue } = await units(loop);
      figures.unit ??= processValue;
      figures.travel_unit ??= manipulatedValue;
      if (store.loop === loop && store.isLive()) show(figures);
    } catch (error) {
      show(undefined, error instanceof Error ? error.message : String(error));
    }
  }
  // A request that takes long, of a long run, is made less often.
  const took = performance.now() - begun;
  setTimeout(
    () => {
      isWaiting = false;
      if (isAgain) update();
    },
    Math.max(INTERVAL, 10 * took),
  );
}

/**
 * @param {Figures | undefined} figures
 * @param {string} [why]
 */
function show(figures, why) {
  text(
    heading,
    figures ? `From ${rounded(figures.from, "REAL")} s to ${rounded(figures.to, "REAL")} s` : (why ?? "No run yet."),
  );
  for (const [name, , of] of SHOWN) {
    const [value, unit] = figures ? of(figures) : [null, ""];
    const place = /** @type {HTMLElement} */ (places.get(name));
    text(place, value === null || value === undefined ? "–" : `${rounded(value, "LREAL", 4)}${unit ? ` ${unit}` : ""}`);
    place.title = value === null || value === undefined ? "" : String(value);
  }
  const sentences = figures?.remarks ?? [];
  if (remarks.textContent !== sentences.join("")) {
    fill(
      remarks,
      sentences.map((remark) => element("li", {}, remark)),
    );
  }
}

/**
 * @param {string | null} unit
 * @param {string} by
 */
function product(unit, by) {
  const first = unitText(unit);
  return first ? `${first}·${by}` : by;
}
