/**
 * Determines the setpoint step to predict: the step that the user has just made, or is about to make.
 *
 * @typedef {import("tool/store.js").Work} Work
 */

import { ask } from "tool/engine.js";
import { SETTLED } from "tool/figures.js";
import { controlledValue, manualSwitch, presentOutput, pulsePeriod } from "tool/signals.js";
import { source, store, variable, wiredTo } from "tool/store.js";
import { number, same } from "tool/values.js";

/** The smallest step, as a fraction of the larger of its start and target. */
const LEAST = 1e-3;

/** A process value below this fraction of the setpoint counts as 0. */
const NOTHING = 1e-6;

/**
 * The step to predict, which begins in automatic mode in steady state, and the origin of its curve in the picture of
 * the run.
 *
 * @param {Work} loop
 * @param {{ from: string, to: string }} typed process value before the step and setpoint after it, as typed; if empty,
 * taken from the run
 * @param {import("./messages").Model} model
 * @returns {Promise<{ step: import("./messages").Step, band: number | null, origin: import("tool/overlay.js").Origin, same: string }>}
 *   `band` is the recovery band of a run of the loop, regardless of the typed values; `same` is the typed target if it
 *   equals the start, else empty
 */
export async function userStep(loop, typed, model) {
  const { setpoint } = loop.description.roles;
  const aim = setpoint ? loop.settings[setpoint] : undefined;
  // A setpoint at its start value, such as 0 degC for a furnace, is not a target.
  const goal = aim && source(aim) !== "start" ? number(aim.sent) : Number.NaN;
  const to = typed.to === "" ? goal : Number(typed.to);
  // A step to the current setpoint may already have been made; a step to any other target starts from the current
  // state. The typed target may have more digits than the block holds.
  const isNext = typed.to !== "" && !(aim && same(aim.variable.kind, to, goal));
  const before = await restBefore(loop, goal, isNext);
  // A process value that settles at 0 never quite reaches it.
  const rest = Math.abs(before.processValue) < NOTHING * Math.abs(to) ? 0 : before.processValue;
  const from = typed.from === "" ? rest : Number(typed.from);
  const isFar = (/** @type {number} */ one, /** @type {number} */ other) =>
    Math.abs(one - other) > LEAST * Math.max(Math.abs(one), Math.abs(other));
  const isStep = isFar(to, from);
  const isSame = typed.to !== "" && !isStep && Number.isFinite(to) && Number.isFinite(from);
  // To hold the plant at a start value that the user entered, the manipulated value must be different, too.
  const moved = typed.from === "" || model.is_integrating ? 0 : (from - before.processValue) / model.gain;
  const manual = before.manipulatedValue + moved;
  const step = {
    from: Number.isFinite(from) ? from : null,
    size: isStep ? to - from : null,
    manual: Number.isFinite(manual) ? manual : null,
  };
  const { processValue: start } = isNext ? await restBefore(loop, goal, false) : before;
  const band = isFar(goal, start) ? SETTLED * Math.abs(goal - start) : null;
  const origin = typed.from === "" ? before : { ...before, processValue: Number.NaN };
  return { step, band, origin, same: isSame ? typed.to : "" };
}

/**
 * The state of the loop before the last setpoint step in automatic mode; the current state if there is none, or if
 * `isNext`.
 *
 * @param {Work} loop
 * @param {number} goal the setpoint, or NaN
 * @param {boolean} isNext
 * @returns {Promise<import("tool/overlay.js").Origin>}
 */
async function restBefore(loop, goal, isNext) {
  const { state } = store;
  if (!store.isLive() || !state) return { time: 0, processValue: Number.NaN, manipulatedValue: Number.NaN };
  const { setpoint, manual, manipulated_value: output } = loop.description.roles;
  const manualOn = manualSwitch(loop);
  const isManual = manualOn !== undefined && loop.settings[manualOn]?.sent === true;
  const processValue = await controlledValue(loop);
  if (state.calls === 0) {
    // The first step of a run begins at the plant's initial value, with a controller that has not acted yet.
    const source = wiredTo(loop, loop.description.roles.process_value ?? "") ?? processValue;
    const begun = isManual && manual ? number(loop.settings[manual[1]]?.sent) : 0;
    return { time: 0, processValue: number(state.values[source ?? ""]), manipulatedValue: begun };
  }
  const now = {
    time: state.time + state.step,
    processValue: number(state.values[processValue ?? ""]),
    manipulatedValue: output ? number(await presentOutput(loop, variable(loop, output))) : Number.NaN,
  };
  if (isManual || !processValue) return now;
  // In automatic mode, the loop settles at its setpoint.
  const rests = Number.isFinite(goal) ? { ...now, processValue: goal } : now;
  if (isNext) return rests;
  const { events } = await ask({ do: "events" });
  const isSwitch = (/** @type {import("./messages").Event} */ { variable: name }) =>
    manualOn !== undefined && name === variable(loop, manualOn);
  const switched = events.findLastIndex(isSwitch);
  // The switch to automatic mode has not taken effect yet: the loop is where manual mode holds it.
  if (switched >= 0 && events[switched].call >= state.calls) return now;
  const automatic = events.slice(switched + 1);
  const steps = automatic.filter(({ variable: name }) => setpoint && name === variable(loop, setpoint));
  // A ramp sets a value before each call: find its first one.
  let at = steps.length - 1;
  while (at > 0 && steps[at].call - steps[at - 1].call <= 1) at -= 1;
  const first = steps[at];
  // The setpoint was set after the last call, so it has not taken effect yet.
  if (first && first.call >= state.calls) return now;
  if (!first || first.call === 0) return rests;
  const rest = first.time - state.step;
  const manipulated = output ? [variable(loop, output)] : [];
  const period = pulsePeriod(loop);
  const means = period === undefined ? {} : Object.fromEntries(manipulated.map((name) => [name, period]));
  const variables = [processValue, ...manipulated];
  const { values } = await ask({ do: "view", variables, from: rest, to: rest, points: 2, means });
  return {
    time: first.time,
    processValue: number(values[0][0] ?? undefined),
    manipulatedValue: number(values[1]?.[0] ?? undefined),
  };
}
