/** The figures of the run for the last setpoint step and the last disturbance. Remarks explain missing figures. */

import { byId, element, fill, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { roles, units, unitText } from "tool/signals.js";
import { store } from "tool/store.js";
import { rounded } from "tool/values.js";

/** The minimum interval between requests for the figures during a run, in milliseconds. */
const INTERVAL = 300;

/** @typedef {import("./messages").Figures} Figures */

/** @type {HTMLElement} */
let body;
/** @type {HTMLElement} */
let heading;
/** @type {HTMLElement} */
let remarks;
/** The element of each figure's value, by the figure's key. @type {Map<string, HTMLElement>} */
const places = new Map();
let isWaiting = false;
let isAgain = false;
/** The run whose figures the run bar shows. @type {number | undefined} */
let shownRun;

/** @param {HTMLElement} content */
export function mount(content) {
  heading = element("p.faint");
  remarks = element("ul.remarks.faint");
  body = element("dl.figures");
  fill(content, heading, body, remarks);
  for (const what of ["state", "run", "loop"]) store.on(what, update);
  show(undefined);
}

/**
 * The figures of a run.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {number} [run] by default, the current run
 */
export async function figuresOf(loop, run) {
  const { processValue, manipulatedValue } = await units(loop);
  return ask({ do: "figures", run, unit: processValue, travel_unit: manipulatedValue });
}

/** Requests and shows the figures, at most once per interval. */
async function update() {
  // Clear the figures of the previous run.
  if (store.state?.run !== shownRun) glance(undefined);
  shownRun = store.state?.run;
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
    show(undefined, `${loop.description.block} lacks a setpoint or a process value, so no metrics are available.`);
  } else {
    try {
      const figures = await figuresOf(loop);
      if (store.loop === loop && store.isLive()) {
        show(figures);
        store.emit("figures", figures);
      }
    } catch (error) {
      show(undefined, error instanceof Error ? error.message : String(error));
    }
  }
  // In a long run, requests take longer, so send them less often.
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
  text(heading, figures ? headingOf(figures) : (why ?? "No run yet."));
  const all = figures?.figures ?? [];
  // Keep existing elements: an element recreated under the pointer would lose its tooltip.
  if (all.length !== places.size || all.some(({ key }) => !places.has(key))) {
    places.clear();
    for (const { key } of all) places.set(key, element("dd"));
    fill(
      body,
      all.map(({ key, title, meaning }) =>
        element("div", { title: meaning }, element("dt", title), /** @type {HTMLElement} */ (places.get(key))),
      ),
    );
  }
  glance(figures);
  for (const { key, value, unit } of all) {
    const place = /** @type {HTMLElement} */ (places.get(key));
    text(place, value === null ? "–" : valueText(value, unit));
    place.title = value === null ? "" : String(value);
  }
  const sentences = figures?.remarks ?? [];
  if (remarks.textContent !== sentences.join("")) {
    fill(
      remarks,
      sentences.map((remark) => element("li", remark)),
    );
  }
}

/**
 * The events that the figures describe: the last step and the last disturbance.
 *
 * @param {Figures} figures
 */
function headingOf({ from, to, step, disturbance }) {
  const of = step ? stepText(step) : `From ${rounded(from, "REAL")} s to ${rounded(to, "REAL")} s`;
  if (!disturbance) return of;
  const by = disturbance.by.map(({ variable, value }) => {
    return value === null ? variable : `${variable} ${rounded(value, "REAL")}`;
  });
  return `${of}; disturbance at ${rounded(disturbance.start, "REAL")} s: ${by.join(", ")}`;
}

/**
 * A step in short form: `20 to 60, 0 s to 599 s`.
 *
 * @param {import("./messages").Happened} step
 */
export function stepText({ from, to, start, duration }) {
  const [begin, goal] = [rounded(from, "LREAL", 4), rounded(to, "LREAL", 4)];
  return `${begin} to ${goal}, ${rounded(start, "REAL")} s to ${rounded(start + duration, "REAL")} s`;
}

/** The settling band as a fraction of the step, and the resolution with which steps are compared. */
export const SETTLED = 0.02;

/**
 * Whether the figures of two steps are comparable: both steps start and end at the same values and cover the same time,
 * within the resolution.
 *
 * @param {import("./messages").Happened | null | undefined} one
 * @param {import("./messages").Happened | null | undefined} other
 */
export function areComparable(one, other) {
  if (!one || !other) return false;
  const least = SETTLED * Math.abs(one.to - one.from);
  return (
    Math.abs(one.from - other.from) <= least &&
    Math.abs(one.to - other.to) <= least &&
    Math.abs(one.duration - other.duration) <= 0.001 * one.duration
  );
}

/** The figures in the run bar after a step: key and short name. @type {[string, string][]} */
const GLANCE = [
  ["overshoot", "overshoot"],
  ["settling", "settles"],
  ["rise", "rise"],
  ["iae", "IAE"],
];
/** The figures in the run bar after a disturbance: key and short name. @type {[string, string][]} */
const AFTER_DISTURBANCE = [
  ["disturbed_peak", "deviation"],
  ["recovery", "recovers"],
  ["disturbed_iae", "IAE"],
];

/** A figure with its unit. @param {number} value @param {string | null} unit */
export function valueText(value, unit) {
  return `${rounded(value, "LREAL", 3)} ${shownUnit(unit)}`.trimEnd();
}

/**
 * The most important figures that have values: of the last step, or of a disturbance after it.
 *
 * @param {Figures | null | undefined} figures
 */
function glanced(figures) {
  const { figures: all = [], step, disturbance } = figures ?? {};
  const isDisturbed = disturbance && !(step && step.start > disturbance.start);
  return (isDisturbed ? AFTER_DISTURBANCE : GLANCE).flatMap(([key, name]) => {
    const figure = all.find((one) => one.key === key);
    return figure && figure.value !== null ? [{ ...figure, name, value: figure.value }] : [];
  });
}

/** The most important figures on one line. @param {Figures | null | undefined} figures */
export function glanceText(figures) {
  return glanced(figures)
    .map(({ name, value, unit }) => `${name} ${valueText(value, unit)}`)
    .join(", ");
}

/** Shows the most important figures in the run bar. @param {Figures | undefined} figures */
function glance(figures) {
  const manual = store.loop && store.isLive() && roles(store.loop).manual;
  const isManual = manual && store.state?.values[manual] === true;
  // In manual mode, nothing drives the error to zero, so its integral says nothing about the controller.
  const found = glanced(figures).filter(({ key }) => !(isManual && key === "iae"));
  fill(
    byId("glance"),
    found.map(({ name, title, meaning, value, unit }) =>
      element(
        "div",
        { title: `${title}: ${meaning}` },
        element("dt", name),
        element("dd", { "data-full": String(value) }, valueText(value, unit)),
      ),
    ),
  );
}

/**
 * Formats a unit: `degC^2 s` becomes `°C²·s`.
 *
 * @param {string | null} unit
 */
export function shownUnit(unit) {
  // The square of a dimensionless number has no unit either.
  const parts = (unit ?? "")
    .split(" ")
    .map(unitText)
    .filter((part) => part && part !== "^2");
  return parts.join("·").replace("^2", "²");
}
