/**
 * After a program change, repeats the last run with the same events and compares both runs, call by call.
 *
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Compared
 * @property {number} run
 * @property {number} of the run with which it is compared
 * @property {string} name name of the other run
 * @property {number} calls number of calls that both runs have
 * @property {Map<string, number>} first the first call in which the runs differ, by variable
 */

import { ask } from "tool/engine.js";
import { remake } from "tool/remake.js";
import { runsOf } from "tool/runs.js";
import { descriptions } from "tool/signals.js";
import { split, store } from "tool/store.js";

/** The maximum number of values requested at a time. */
const MOST_VALUES = 200_000;

/** @type {Compared | undefined} */
let result;

store.on("loop", () => {
  result = undefined;
});

/** The comparison of the current run with an earlier one, if any. */
export function compared() {
  return store.isLive() && result?.run === store.state?.run ? result : undefined;
}

/** Whether the loop has a run that can be repeated. @param {Work | undefined} loop */
export function hasRun(loop) {
  return (runsOf(loop).at(-1)?.calls ?? 0) > 0;
}

/** Repeats the last run of the current loop with the current program and plant. */
export async function sameAgain() {
  const loop = store.loop;
  const last = runsOf(loop).at(-1);
  if (!loop || !last) return;
  store.emit("pause");
  const { setup, events, calls } = await ask({ do: "events", run: last.run });
  const [own, ...others] = setup.members;
  const isThere = (/** @type {string} */ name) => name in loop.settings;
  const values = Object.fromEntries(Object.entries(own.values).filter(([name]) => isThere(name)));
  const members = [
    { name: loop.member, fmu: loop.description.name, values },
    ...others.map((member) => ({
      ...member,
      fmu: loop.members.find(({ name }) => name === member.name)?.fmu ?? member.fmu,
    })),
  ];
  const known = new Set(loop.description.variables.map(({ name }) => `${loop.member}.${name}`));
  const isKnown = (/** @type {string} */ name) => split(name)[0] !== loop.member || known.has(name);
  // Leave out events and connections of variables that the changed program no longer has.
  const connections = setup.connections.filter((wire) => wire.every(isKnown));
  const done = events.filter(({ variable }) => isKnown(variable));
  await remake(loop, { setup: { ...setup, members, connections }, events: done, calls });
  await compare(loop, last);
}

/**
 * @param {Work} loop
 * @param {import("tool/runs.js").Kept} other
 */
async function compare(loop, other) {
  const state = store.state;
  if (!state) return;
  const before = new Set();
  for (const { name, fmu } of other.setup.members)
    for (const variable of (await store.describe(fmu)).variables) before.add(`${name}.${variable.name}`);
  const now = (await descriptions(loop)).flatMap(([member, { variables }]) =>
    variables.map(({ name }) => `${member}.${name}`),
  );
  const variables = now.filter((name) => before.has(name) && name in state.values);
  const calls = Math.min(state.calls, other.calls);
  const start = state.time - (state.calls - 1) * state.step;
  const count = Math.max(Math.floor(MOST_VALUES / Math.max(variables.length, 1)), 2);
  /** @type {Map<string, number>} */
  const first = new Map();
  for (let call = 0; call < calls; call += count) {
    const [from, to] = [call, Math.min(call + count, calls) - 1].map((at) => start + at * state.step);
    const part = { variables, from, to, points: count };
    const one = await ask({ do: "view", run: state.run, ...part });
    const two = await ask({ do: "view", run: other.run, ...part });
    for (const [at, name] of variables.entries()) {
      const different = one.values[at].findIndex((value, row) => !Object.is(value, two.values[at][row]));
      if (different >= 0 && !first.has(name)) first.set(name, call + different);
    }
  }
  result = { run: state.run, of: other.run, name: other.name, calls, first };
  store.emit("compared");
}

/**
 * The comparison in words, naming the variable that is the first to differ.
 *
 * @param {Compared} of
 * @param {(call: number) => number} timeOf
 */
export function comparedText({ name, first, calls }, timeOf) {
  if (first.size === 0) return `Same as ${name}: every variable, in ${calls} cycles`;
  const [earliest, call] = [...first].reduce((one, two) => (two[1] < one[1] ? two : one));
  return `Differs from ${name} from ${timeOf(call)} s onward: ${split(earliest)[1]}${first.size > 1 ? ` and ${first.size - 1} more` : ""}`;
}
