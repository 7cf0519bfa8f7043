/**
 * The step test in one button: manual at the present value, wait until the process value rests, one step, wait until it rests again.
 */

import { ask } from "tool/engine.js";
import { presentOutput } from "tool/run.js";
import { controlledValue } from "tool/signals.js";
import { store, variable } from "tool/store.js";

/** How many calls are made at once. */
const CHUNK = 100;
/** A plant that has not come to rest in this many calls does not, or integrates. */
const MOST_CALLS = 100_000;
/** Rest: the mean of the last quarter of what is looked at differs from that of the quarter before by this part of the movement. */
const STILL = 0.005;
const SHORTEST = 40;

/** Whether a controller has what the test needs: a manual value. @param {import("tool/store.js").Work} loop */
export function canStep(loop) {
  return loop.description.roles.manual !== null;
}

/**
 * Makes the test.
 *
 * @param {number} size of the step, in units of the manipulated value
 * @param {boolean} isIntegrating whether the plant comes to no rest
 * @param {(sentence: string) => void} tell what is being done
 * @throws {Error} why there is no step to identify from
 */
export async function stepTest(size, isIntegrating, tell) {
  const loop = store.loop;
  const manual = loop?.description.roles.manual;
  const output = loop?.description.roles.manipulated_value;
  const processValue = loop && (await controlledValue(loop));
  if (!loop || !manual || !output || !processValue)
    throw new Error("A step test needs a manual value and a process value.");
  if (loop.members.length === 0) throw new Error("Nothing answers the controller: take a plant first.");
  const [isManual, value] = manual;
  store.emit("pause");
  if (!store.isLive()) await store.begin();
  if ((store.state?.calls ?? 0) === 0) await store.calls(1);
  const before = Number(await presentOutput(loop, variable(loop, output)));
  await store.now({ [value]: before, [isManual]: true });
  tell("In manual mode: waiting until the process value rests.");
  await rest(processValue, isIntegrating);
  const { high, low } = limits(loop, output);
  const to = before + size > high || before + size < low ? before - size : before + size;
  await store.now({ [value]: to });
  tell(
    `Stepped from ${Number(before.toPrecision(5))} to ${Number(to.toPrecision(5))}: waiting until the process value rests.`,
  );
  await rest(processValue, isIntegrating);
}

/** The limits of the manipulated value: the settings that are named as it, with its limits. @param {import("tool/store.js").Work} loop @param {string} output */
function limits(loop, output) {
  const of = (/** @type {string} */ end, /** @type {number} */ otherwise) =>
    Number(loop.settings[`${output}_${end}`]?.sent ?? otherwise);
  return { high: of("HLM", 100), low: of("LLM", 0) };
}

/**
 * Makes calls until a signal rests.
 *
 * @param {string} signal
 * @param {boolean} isIntegrating
 */
async function rest(signal, isIntegrating) {
  const step = store.state?.step ?? 1;
  const from = store.state?.time ?? 0;
  const most = (store.state?.calls ?? 0) + MOST_CALLS;
  for (let length = SHORTEST; (store.state?.calls ?? 0) < most; length = Math.ceil(length * 1.25)) {
    const target = Math.round(from / step) + length;
    while ((store.state?.calls ?? 0) < target) {
      const state = await store.calls(Math.min(CHUNK, target - (store.state?.calls ?? 0)));
      if (state.failure) throw new Error(`The run has ended: ${state.failure}`);
      await new Promise((done) => setTimeout(done, 0));
    }
    const { values } = await ask({ do: "view", variables: [signal], from, points: 4000 });
    const there = values[0].flatMap((one) => one ?? []);
    if (isStill(there) || (isIntegrating && length > 4 * SHORTEST)) return;
  }
  throw new Error(`The process value has not come to rest in ${MOST_CALLS} calls: if the plant integrates, say so.`);
}

/** @param {number[]} values since the last change */
function isStill(values) {
  const quarter = Math.floor(values.length / 4);
  if (quarter < 5) return false;
  const mean = (/** @type {number[]} */ part) => part.reduce((sum, one) => sum + one, 0) / part.length;
  const [before, last] = [values.slice(-2 * quarter, -quarter), values.slice(-quarter)];
  const moved = Math.max(...values) - Math.min(...values);
  const round = Math.max(...values.map(Math.abs)) * 1e-6;
  const sway = Math.max(...last) - Math.min(...last);
  // Noise sways as much as ever; what still moves, more from quarter to quarter.
  const noise = (sway - Math.abs(last[last.length - 1] - last[0])) / Math.sqrt(quarter);
  return Math.abs(mean(last) - mean(before)) <= Math.max(STILL * moved, round, noise / 4);
}
