/**
 * The visible part of the run, and the displayed moment: at the cursor, or now. Curves, timing diagram, inputs and
 * source share both.
 *
 * @typedef {import("./messages").Values} Values
 *
 * @typedef {object} Notes view settings kept with a loop
 * @property {string[]} chosen
 * @property {string[]} hidden
 * @property {number} window in seconds; 0 shows everything
 */

import { ask } from "tool/engine.js";
import { programOf } from "tool/program.js";
import { split, store } from "tool/store.js";
import { rounded } from "tool/values.js";

/**
 * The part of the run to which the user has zoomed; by default, the latest part is visible.
 *
 * @type {[number, number] | undefined}
 */
let zoomed;
/**
 * The part shown for a step. When the run continues after the step, it is followed again.
 *
 * @type {[number, number] | undefined}
 */
let ofStep;
/** The cursor position in seconds; `undefined` is now. @type {number | undefined} */
let cursor;
/**
 * All values at the cursor; `key` identifies the run and the time of the call.
 *
 * @type {{ key: string, values: Values } | undefined}
 */
let got;
let isAsking = false;
/** All current values, and the state they belong to. @type {{ state: typeof store.state, values: Values }} */
let present = { state: undefined, values: {} };

store.on("loop", () => {
  zoomed = cursor = got = undefined;
});
store.on("run", () => {
  zoomed = got = undefined;
  lookAt(undefined);
});

/** @returns {Notes | undefined} */
export function notes() {
  const loop = store.loop;
  if (!loop) return undefined;
  loop.notes.curves ??= { chosen: [], hidden: [], window: 0 };
  return loop.notes.curves;
}

/** The time at the cursor, if there is one. */
export function cursorTime() {
  return cursor;
}

/**
 * Moves the cursor.
 *
 * @param {number | undefined} time in seconds; `undefined` is now
 */
export function lookAt(time) {
  if (time === cursor) return;
  cursor = time;
  store.emit("cursor");
  fetchValues();
}

/**
 * All values at the cursor, or now. After the cursor has moved, the previous values are returned until the new ones
 * arrive.
 *
 * @returns {Values}
 */
export function momentValues() {
  return (cursor !== undefined && got?.values) || presentValues();
}

/** All current values. They are collected only once per state, because every source line needs them. */
function presentValues() {
  const state = store.isLive() ? store.state : undefined;
  if (present.state !== state) {
    const late = Object.entries(state?.after ?? {}).filter(([name]) => isLate(name));
    present = { state, values: { ...state?.values, ...Object.fromEntries(late) } };
  }
  return present.values;
}

/**
 * Whether a variable's value after a call is in the row of the next call: it is a result of the loop's program in a run
 * with parallel exchange.
 *
 * @param {string} name
 */
export function isLate(name) {
  const loop = store.loop;
  const [member, own] = split(name);
  return member === loop?.member && !(own in loop.settings) && !!store.state?.after && !!programOf(loop);
}

/** The time at the cursor as text, `at 12.3 s`; empty for now. */
export function momentText() {
  return cursor === undefined ? "" : `at ${rounded(cursor, "REAL", 9)} s`;
}

/**
 * Fetches the values at the cursor. Only one request is pending at a time; if the cursor has moved meanwhile, another
 * one follows.
 */
async function fetchValues() {
  const state = store.isLive() ? store.state : undefined;
  if (isAsking || !state || cursor === undefined || state.calls === 0) {
    if (cursor === undefined) store.emit("moment");
    return;
  }
  const call = callAt(cursor);
  const time = timeOf(call);
  const key = `${state.run} ${time}`;
  if (got?.key !== key) {
    isAsking = true;
    try {
      got = { key, values: await valuesAt(call) };
    } catch (error) {
      store.say(error);
    }
    isAsking = false;
    if (cursor !== undefined && timeOf(callAt(cursor)) !== time) {
      fetchValues();
      return;
    }
  }
  store.emit("moment");
}

/** All values after a call. @param {number} call @returns {Promise<Values>} */
export async function valuesAt(call) {
  const { calls = 0, values: now = {}, after } = store.state ?? {};
  const names = Object.keys(now);
  const late = names.filter(isLate);
  const found = await row(call, late.length > 0 ? names.filter((name) => !isLate(name)) : names);
  if (late.length === 0) return found;
  if (call + 1 < calls) return { ...found, ...(await row(call + 1, late)) };
  return { ...found, ...Object.fromEntries(late.map((name) => [name, after?.[name] ?? "NaN"])) };
}

/** Values in the row of a call. @param {number} call @param {string[]} variables @returns {Promise<Values>} */
async function row(call, variables) {
  const time = timeOf(call);
  const { values } = await ask({ do: "view", variables, from: time, to: time, points: 2 });
  const typed = (/** @type {number | null} */ value, /** @type {string} */ name) =>
    typeof store.state?.values[name] === "boolean" ? value === 1 : (value ?? "NaN");
  return Object.fromEntries(variables.map((name, at) => [name, typed(values[at][0], name)]));
}

/** The time of the first call, in seconds. */
function start() {
  const { time, calls, step } = store.state ?? { time: 0, calls: 1, step: 1 };
  const first = time - Math.max(calls - 1, 0) * step;
  return Math.abs(first) < step * 1e-6 ? 0 : first;
}

/** The 0-based index of the call whose values hold at a time. @param {number} time */
export function callAt(time) {
  const { calls, step } = store.state ?? { calls: 1, step: 1 };
  return Math.min(Math.max(Math.floor((time - start()) / step + 1e-6), 0), Math.max(calls - 1, 0));
}

/** The time of a call, in seconds. @param {number} call */
export function timeOf(call) {
  // Remove the rounding error that accumulates in sums of a step such as 0.1.
  return Number((start() + call * (store.state?.step ?? 1)).toPrecision(12));
}

/**
 * The visible part of the run.
 *
 * @returns {[number, number]}
 */
export function range() {
  if (zoomed) return zoomed;
  const last = store.isLive() ? (store.state?.time ?? 0) : 0;
  const length = notes()?.window ?? 0;
  const { origin, curves: ahead } = store.prediction ?? {};
  const predicted = origin ? origin.time + (ahead?.times.at(-1) ?? 0) : 0;
  // A prediction extends beyond the run, but at least half of the window is kept for measured values.
  const end = Math.max(last, length === 0 ? predicted : Math.min(predicted, last + length / 2));
  const step = store.state?.step ?? 1;
  const whole = round(Math.max(end, 20 * step));
  if (length === 0) return [0, whole];
  return end <= length ? [0, Math.min(length, whole)] : [end - length, end];
}

/** Whether the user has zoomed. */
export function isZoomed() {
  return zoomed !== undefined;
}

/**
 * Repeats the current run and keeps the zoom.
 *
 * @param {"same_bits" | "same_test"} what
 */
export async function repeated(what) {
  const kept = zoomed;
  await store.repeat(what);
  zoomed = kept;
  store.emit("range");
}

/** Rounds a length in seconds up, so that the axis does not move while the run fills it. @param {number} seconds */
function round(seconds) {
  const decade = 10 ** Math.floor(Math.log10(seconds));
  return decade * ([1, 1.5, 2, 3, 4, 6, 8].find((factor) => factor * decade >= seconds) ?? 10);
}

/**
 * Shows the latest part of the run and follows it.
 *
 * @param {number} [length] length of the visible part in seconds, 0 for all; unchanged by default
 */
export function follow(length) {
  const kept = notes();
  if (kept && length !== undefined) kept.window = length;
  zoomed = undefined;
  lookAt(undefined);
  store.emit("range");
}

/**
 * @param {number} from
 * @param {number} to
 */
export function zoom(from, to) {
  const step = store.state?.step ?? 1;
  if (to - from < 2 * step) [from, to] = [(from + to) / 2 - step, (from + to) / 2 + step];
  zoomed = [Math.max(from, 0), Math.max(to, 2 * step)];
  store.emit("range");
}

/**
 * Zooms to a step that is about to run, until the run is continued after it.
 *
 * @param {number} from
 * @param {number} to
 */
export function zoomToStep(from, to) {
  zoom(from, to);
  ofStep = zoomed;
}

/** Ends the zoom to a step, so that the run is followed again; a zoom by the user remains. */
export function leaveStep() {
  if (isZoomed() && zoomed === ofStep) follow();
}

/** @param {number} factor */
export function zoomBy(factor) {
  const [from, to] = range();
  const last = store.isLive() ? (store.state?.time ?? 0) : 0;
  const middle = Math.min(Math.max(cursor ?? Math.min(to, last), from), to);
  if (factor > 1 && from <= 0 && to >= last) return;
  zoom(middle - (middle - from) * factor, middle + (to - middle) * factor);
}
