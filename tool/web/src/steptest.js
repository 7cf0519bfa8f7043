/**
 * The step that a user makes: from where the loop is, or was before the last step of the run, to the setpoint.
 *
 * @typedef {import("tool/store.js").Work} Work
 */

import { ask } from "tool/engine.js";
import { SETTLED } from "tool/figures.js";
import { controlledValue, manualSwitch, presentOutput, pulsePeriod } from "tool/signals.js";
import { source, store, variable, wiredTo } from "tool/store.js";
import { number, same } from "tool/values.js";

/** A setpoint that is nearer to the process value, as a part of both, is no step. */
const LEAST = 1e-3;

/** A part of a setpoint that is as good as 0. */
const NOTHING = 1e-6;

/**
 * The step to predict, and where its curve begins in the picture of the run. It begins in automatic mode, at rest.
 *
 * @param {Work} loop
 * @param {{ from: string, to: string }} typed process value before and setpoint after it; empty for those of the run
 * @param {import("./messages").Model} model
 * @returns {Promise<{ step: import("./messages").Step, band: number | null, origin: import("tool/overlay.js").Origin, same: string }>}
 *   `band` is the one in which a run of the loop has recovered, which what is typed does not change; `same` is what start and target both
 *   are, if they are typed so, else empty
 */
export async function userStep(loop, typed, model) {
  const { setpoint } = loop.description.roles;
  const aim = setpoint ? loop.settings[setpoint] : undefined;
  // A setpoint that was never set is not a target: 0 degC in a furnace.
  const goal = aim && source(aim) !== "start" ? number(aim.sent) : Number.NaN;
  const to = typed.to === "" ? goal : Number(typed.to);
  // The step to where the setpoint is has been made, or is about to be; another one begins where the loop is now.
  // What is typed may have more digits than the block holds.
  const isNext = typed.to !== "" && !(aim && same(aim.variable.kind, to, goal));
  const before = await restBefore(loop, goal, isNext);
  // A process value that comes to rest at 0 never quite reaches it.
  const rest = Math.abs(before.processValue) < NOTHING * Math.abs(to) ? 0 : before.processValue;
  const from = typed.from === "" ? rest : Number(typed.from);
  const isFar = (/** @type {number} */ one, /** @type {number} */ other) =>
    Math.abs(one - other) > LEAST * Math.max(Math.abs(one), Math.abs(other));
  const isStep = isFar(to, from);
  const isSame = typed.to !== "" && !isStep && Number.isFinite(to) && Number.isFinite(from);
  // Where the user lets it begin, another manipulated value holds the plant.
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
 * The loop before the last step of the setpoint in automatic mode; else, or for the next step, the loop of now.
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
    // The run that begins is the step: from where the plant begins, which no call has shown yet, with a controller that has done nothing.
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
  // In automatic mode the loop rests at its setpoint.
  const rests = Number.isFinite(goal) ? { ...now, processValue: goal } : now;
  if (isNext) return rests;
  const { events } = await ask({ do: "events" });
  const isSwitch = (/** @type {import("./messages").Event} */ { variable: name }) =>
    manualOn !== undefined && name === variable(loop, manualOn);
  const switched = events.findLastIndex(isSwitch);
  // Automatic mode is still to come: the loop is where manual mode held it.
  if (switched >= 0 && events[switched].call >= state.calls) return now;
  const automatic = events.slice(switched + 1);
  const steps = automatic.filter(({ variable: name }) => setpoint && name === variable(loop, setpoint));
  // A ramp sets a value in each call: it begins with the first of them.
  let at = steps.length - 1;
  while (at > 0 && steps[at].call - steps[at - 1].call <= 1) at -= 1;
  const first = steps[at];
  // A value that was just set takes effect later.
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
