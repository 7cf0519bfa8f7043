/**
 * Repeats a run from its setup and its events: after a reload, from a link, or for a loop opened from a description.
 *
 * @typedef {object} Made
 * @property {import("./messages").Setup} setup
 * @property {import("./messages").Event[]} events
 * @property {number} calls
 */

import { ask } from "tool/engine.js";
import { store } from "tool/store.js";

/** The number of calls per request. Between requests, the page can respond to the user. */
const CHUNK = 5000;

/**
 * Repeats a run of a loop, which becomes the engine's current run.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {Made} made
 */
export async function remake(loop, { setup, events, calls }) {
  let state = await ask({ do: "start", ...setup });
  store.live = loop;
  store.state = state;
  loop.runs.push(state.run);
  const until = async (/** @type {number} */ target) => {
    while (state.calls < target && !state.failure) {
      state = await ask({ do: "run", calls: Math.min(CHUNK, target - state.calls) });
      if (state.calls < target) await new Promise((done) => setTimeout(done, 0));
    }
  };
  for (let at = 0; at < events.length; ) {
    const { call } = events[at];
    await until(Math.min(call, calls));
    // Send consecutive events of the same kind together.
    const { act = "set" } = events[at];
    const values = /** @type {import("./messages").Values} */ ({});
    for (; at < events.length && events[at].call === call && (events[at].act ?? "set") === act; at += 1)
      values[events[at].variable] = events[at].value;
    state = await ask(act === "set" ? { do: "send", values } : { do: "force", act, values });
  }
  await until(calls);
  await store.take(Promise.resolve(state));
  store.emit("run", setup);
  store.emit("plant");
}
