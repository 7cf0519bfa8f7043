/**
 * The step that a user makes: from where the loop is, or was before the last step of the run, to the setpoint.
 *
 * @typedef {import("tool/store.js").Work} Work
 */

import { ask } from "tool/engine.js";
import { controlledValue } from "tool/signals.js";
import { runValue, source, store, variable, wiredTo } from "tool/store.js";
import { number } from "tool/values.js";

/** A setpoint that is nearer to the process value, as a part of both, is no step. */
const LEAST = 1e-3;

/**
 * The step to predict, and where its curve begins in the picture of the run.
 *
 * @param {Work} loop
 * @param {{ from: string, to: string }} typed process value before and setpoint behind it; empty for those of the run
 * @returns {Promise<{ step: import("./messages").Step, origin: import("tool/overlay.js").Origin }>}
 */
export async function userStep(loop, typed) {
  const { setpoint } = loop.description.roles;
  const before = await restBefore(loop);
  const aim = setpoint ? loop.settings[setpoint] : undefined;
  // A setpoint that nobody has set is no goal: 0 degC in a furnace.
  const goal = aim && source(aim) !== "start" ? number(aim.sent) : Number.NaN;
  const from = typed.from === "" ? before.processValue : Number(typed.from);
  const to = typed.to === "" ? goal : Number(typed.to);
  const isStep = Math.abs(to - from) > LEAST * Math.max(Math.abs(from), Math.abs(to));
  // Another step than the typed one is none that the user wants to see.
  if (typed.to !== "" && !isStep && Number.isFinite(to) && Number.isFinite(from))
    throw new Error(`The step would begin at ${typed.to}, where it is to go: type another goal, or where it begins.`);
  const step = {
    from: Number.isFinite(from) ? from : null,
    size: isStep ? to - from : null,
    manual: Number.isFinite(before.manipulatedValue) ? before.manipulatedValue : null,
    is_takeover: before.isTakeover,
  };
  return { step, origin: typed.from === "" ? before : { ...before, processValue: Number.NaN } };
}

/**
 * The loop before the last step of the setpoint, or before it was last switched to automatic mode; in manual mode the loop of now.
 *
 * @param {Work} loop
 * @returns {Promise<import("tool/overlay.js").Origin & { isTakeover: boolean }>} and whether the step ends manual mode
 */
async function restBefore(loop) {
  const { state } = store;
  if (!store.isLive() || !state)
    return { time: 0, processValue: Number.NaN, manipulatedValue: Number.NaN, isTakeover: false };
  const { setpoint, manual, manipulated_value: output } = loop.description.roles;
  const isManual = manual !== null && loop.settings[manual[0]]?.sent === true;
  const processValue = await controlledValue(loop);
  if (state.calls === 0) {
    // The run that begins is the step: from where the plant begins, which no call has shown yet, with a controller that has done nothing.
    const source = wiredTo(loop, loop.description.roles.process_value ?? "") ?? processValue;
    const begun = isManual && manual ? number(loop.settings[manual[1]]?.sent) : 0;
    return {
      ...{ time: 0, processValue: number(state.values[source ?? ""]), manipulatedValue: begun },
      isTakeover: isManual,
    };
  }
  const now = {
    time: state.time + state.step,
    processValue: number(state.values[processValue ?? ""]),
    manipulatedValue: number(runValue(loop, output ?? "")),
    isTakeover: isManual,
  };
  if (isManual) return now;
  const { events } = await ask({ do: "events" });
  const steps = events.filter(
    ({ variable: name, value }) =>
      (setpoint && name === variable(loop, setpoint)) || (manual && name === variable(loop, manual[0]) && !value),
  );
  // A ramp sets a value in each call: it begins with the first of them.
  let at = steps.length - 1;
  while (at > 0 && steps[at].call - steps[at - 1].call <= 1) at -= 1;
  const first = steps[at];
  const isSwitch = (/** @type {import("./messages").Event} */ { variable: name }) =>
    manual !== null && name === variable(loop, manual[0]);
  const isTakeover = steps.slice(at).some(isSwitch);
  // What was just set is still to come: it is the same step as before it was set.
  if (first && first.call >= state.calls) return { ...now, isTakeover };
  if (!first || !processValue || first.call === 0) return now;
  const rest = first.time - state.step;
  const variables = [processValue, ...(output ? [variable(loop, output)] : [])];
  const { values } = await ask({ do: "view", variables, from: rest, to: rest, points: 2 });
  return {
    isTakeover,
    // What is predicted has the new setpoint a call before automatic mode.
    time: isSwitch(first) ? rest : first.time,
    processValue: number(values[0][0] ?? undefined),
    manipulatedValue: number(values[1]?.[0] ?? undefined),
  };
}
