/**
 * Lets the user overwrite variables: once, or in every call until they are released. A forced variable is marked
 * wherever it is shown.
 *
 * @typedef {import("./messages").Value} Value
 * @typedef {import("./messages").Values} Values
 */

import { ask } from "tool/engine.js";
import { split, store, wiredTo } from "tool/store.js";

/**
 * The periods in which variables were forced in the current run, by name: the first call, and the call after the last
 * (infinite while it is still forced).
 * @type {Map<string, [number, number][]>}
 */
let spans = new Map();
/** Identifies the run and the forced values for which `spans` was fetched. */
let known = "";

for (const what of ["state", "run", "loop"]) store.on(what, follow);

/** The variables forced in the current loop. @returns {Values} */
export function forced() {
  const loop = store.loop;
  return store.isLive() ? (store.state?.forced ?? {}) : (loop?.notes.forced ?? {});
}

/** @param {string} name */
export function isForced(name) {
  return name in forced();
}

/**
 * The periods in which a variable was forced: the first call, and the call after the last, which is infinite while it
 * is still forced.
 *
 * @param {string} name
 */
export function forcedSpans(name) {
  return spans.get(name) ?? [];
}

/**
 * Forces variables, by `MEMBER.VARIABLE`. If there is no run, starts one without making a call.
 *
 * @param {Values} values
 */
export function force(values) {
  return act("force", values);
}

/** Writes variables once, before the next call. @param {Values} values */
export function write(values) {
  return act("write", values);
}

/**
 * Releases variables. An unconnected input or parameter returns to the value that is set for it.
 *
 * @param {string[]} names by default, all forced variables
 */
export async function release(names = Object.keys(forced())) {
  const loop = store.loop;
  if (loop && !store.isLive()) {
    // The next run starts without them.
    const kept = Object.entries(forced()).filter(([name]) => !names.includes(name));
    loop.notes.forced = Object.fromEntries(kept);
    store.emit("forced");
    store.emit("settings", []);
    return;
  }
  await act("release", Object.fromEntries(names.map((name) => [name, forced()[name]])));
  /** @type {Values} */
  const values = {};
  for (const name of names) {
    const [member, own] = split(name);
    const setting = member === loop?.member ? loop.settings[own] : undefined;
    if (setting?.variable.is_tunable && loop && !wiredTo(loop, own)) values[name] = setting.sent;
  }
  if (Object.keys(values).length > 0) await store.take(ask({ do: "send", values }));
}

/**
 * @param {import("./messages").Act} how
 * @param {Values} values
 */
async function act(how, values) {
  const loop = store.loop;
  if (!loop || Object.keys(values).length === 0) return;
  if (!store.isLive()) await store.begin();
  await store.take(ask({ do: "force", act: how, values }));
  store.emit("settings", []);
}

/** Stores the forced variables with the loop and updates the periods. */
async function follow() {
  const loop = store.loop;
  if (!loop || !store.isLive() || !store.state) return;
  const now = store.state.forced;
  const key = JSON.stringify([loop.id, store.state.run, now]);
  if (key === known) return;
  known = key;
  loop.notes.forced = now;
  try {
    const { events } = await ask({ do: "events" });
    if (known !== key) return;
    spans = new Map();
    for (const { variable, call, act: how } of events) {
      const own = spans.get(variable) ?? [];
      const open = own.at(-1)?.[1] === Infinity ? own.at(-1) : undefined;
      if (how === "force" && !open) own.push([call, Infinity]);
      if (how === "release" && open) open[1] = call;
      spans.set(variable, own);
    }
    store.emit("forced");
  } catch (error) {
    store.say(error);
  }
}
