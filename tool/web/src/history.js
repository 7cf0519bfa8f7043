/**
 * The history of signals in a run: the calls in which each value changed, so that edges are drawn at the exact call
 * however long the run is. Only calls that are not known yet are requested.
 *
 * @typedef {object} Track
 * @property {number[]} calls calls in which the value changed, beginning with the first call
 * @property {number[]} values value from each of these calls onward; NaN for an invalid number
 * @property {number} until number of calls known
 */

import { ask } from "tool/engine.js";
import { isLate } from "tool/moment.js";

/** The maximum number of values in a request: more would block the page. */
const MOST_VALUES = 200_000;
/** The number of runs that the engine keeps, including the current one. */
const MOST_RUNS = 6;

/** The tracks, by run, then by name. @type {Map<number, Map<string, Track>>} */
const runs = new Map();

/** Forgets all tracks: a new engine restarts the numbering of runs. */
export function forgetTracks() {
  runs.clear();
}

/**
 * The tracks of signals in a run, up to its last call.
 *
 * @param {string[]} names
 * @param {{ run: number, calls: number, step: number, time: number, after?: import("./messages").Values | null }} of
 *   `time` is the time of the last call, and `after` the results of a program in it, which belong in the row of the
 *   next call
 * @returns {Promise<Map<string, Track>>}
 */
export async function tracks(names, { run, calls, step, time, after }) {
  const known = runs.get(run) ?? new Map();
  runs.delete(run);
  runs.set(run, known);
  for (const other of runs.keys()) if (runs.size > MOST_RUNS) runs.delete(other);
  for (const name of names) if (!known.has(name)) known.set(name, { calls: [], values: [], until: 0 });
  const start = time - (calls - 1) * step;
  for (;;) {
    const waiting = names.filter((name) => known.get(name).until < calls);
    if (waiting.length === 0) return known;
    // Request signals together that are known up to the same call and whose next value is in the same row.
    const first = Math.min(...waiting.map((name) => known.get(name).until));
    const rowOf = (/** @type {string} */ name) => first + (after && isLate(name) ? 1 : 0);
    const behind = waiting.filter((name) => known.get(name).until === first);
    const row = rowOf(behind[0]);
    const variables = behind.filter((name) => rowOf(name) === row);
    if (row === calls) {
      // The row after the last call does not exist yet; for an earlier run, it never will.
      for (const name of variables) {
        const value = after?.[name];
        extend(known.get(name), value === undefined ? [] : [first], [value === "NaN" ? null : Number(value)], calls);
      }
      continue;
    }
    const ends = waiting.map((name) => known.get(name).until).filter((until) => until > first);
    const next = Math.min(...ends, calls + first - row);
    const count = Math.min(next - first, Math.max(Math.floor(MOST_VALUES / variables.length), 1));
    const [from, to] = [start + row * step, start + (row + count - 1) * step];
    const { times, values } = await ask({ do: "view", run, variables, from, to, points: Math.max(count, 2) });
    const numbers = times.map((one) => Math.round((one - start) / step) + first - row);
    for (const [at, name] of variables.entries()) extend(known.get(name), numbers, values[at], first + count);
  }
}

/**
 * @param {Track} track
 * @param {number[]} calls
 * @param {(number | null)[]} values
 * @param {number} until
 */
function extend(track, calls, values, until) {
  for (const [at, call] of calls.entries()) {
    const value = values[at] ?? Number.NaN;
    if (track.calls.length > 0 && Object.is(track.values.at(-1), value)) continue;
    track.calls.push(call);
    track.values.push(value);
  }
  track.until = until;
}

/**
 * The index of the last change in or before a call; -1 if there is none.
 *
 * @param {Track} track
 * @param {number} call
 */
export function placeOf(track, call) {
  let [low, high] = [0, track.calls.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (track.calls[middle] <= call) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/**
 * Divides an interval of calls into parts: a constant value, or a band in which changes are too dense to be drawn, with
 * their number.
 *
 * @param {Track} track
 * @param {number} first
 * @param {number} end the call after the last one
 * @param {number} dense changes fewer than this many calls apart cannot be distinguished in the drawing
 * @returns {{ from: number, to: number, value: number, changes: number }[]} `changes` is 0 for a constant value
 */
export function parts({ calls, values, until }, first, end, dense) {
  const parts = [];
  const stop = Math.min(end, until);
  let at = Math.max(placeOf({ calls, values, until }, first), 0);
  while (at < calls.length && calls[at] < stop) {
    // A series of changes, each close to the previous one, becomes one part.
    let last = at;
    while (last + 1 < calls.length && calls[last + 1] < stop && calls[last + 1] - calls[last] < dense) last += 1;
    const isBand = last - at >= FEWEST;
    const from = Math.max(calls[at], first);
    const to = Math.min(calls[(isBand ? last : at) + 1] ?? until, stop);
    // The value after the last change of a band is a separate part, which is visible if it is long enough.
    if (isBand) parts.push({ from, to: calls[last], value: values[last], changes: last - at });
    parts.push({ from: isBand ? calls[last] : from, to, value: values[isBand ? last : at], changes: 0 });
    at = (isBand ? last : at) + 1;
  }
  return parts;
}

/** If a series has fewer intervals than this, its changes are drawn individually, however close together they are. */
const FEWEST = 4;
