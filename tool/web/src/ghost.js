/**
 * What-if curves: while settings are being edited, the engine repeats the test of the current run with the values in
 * the fields, without disturbing the run, and the result is drawn dashed behind it. After the values are applied, these
 * curves stay until the run continues or restarts.
 */

import { ask } from "tool/engine.js";
import { glanceText } from "tool/figures.js";
import { isZoomed, range } from "tool/moment.js";
import { drawnOfEarlier } from "tool/overlay.js";
import { programOf } from "tool/program.js";
import { units } from "tool/signals.js";
import { isEdited, split, store, variable } from "tool/store.js";
import { same, shown } from "tool/values.js";

/** The time without typing after which a trial starts, in milliseconds. */
const PAUSE = 150;
/** Runs with more calls than this are not repeated while the user types. */
const MOST_CALLS = 20_000;
const POINTS = 1500;

let timer = 0;
/** The number of the last trial. Pending trials with a lower number are obsolete. */
let asked = 0;

/** Starts drawing trials. */
export function mount() {
  for (const what of ["settings", "loop", "run", "pause", "range"]) store.on(what, soon);
}

function soon() {
  clearTimeout(timer);
  if (edits() === undefined) {
    if (!isApplied()) hide();
  } else timer = setTimeout(make, PAUSE);
}

/** The edited settings by `MEMBER.VARIABLE`; `undefined` if there is nothing to try. */
function edits() {
  const loop = store.loop;
  const calls = store.state?.calls ?? 0;
  // For a program there are no trials, since its lines show the values of the current run.
  if (!loop || !store.isLive() || calls < 2 || calls > MOST_CALLS || programOf(loop)) return undefined;
  const edited = Object.entries(loop.settings).filter(
    ([, one]) => isEdited(one) && one.wrong === undefined && !one.variable.is_stimulus,
  );
  if (edited.length === 0) return undefined;
  return Object.fromEntries(edited.map(([name, one]) => [variable(loop, name), one.value]));
}

/** Whether the values of the trial have been applied and no call has been made since. */
function isApplied() {
  const { ghost, loop, state } = store;
  if (!ghost || !loop || state?.run !== ghost.of.run || state.calls !== ghost.of.calls) return false;
  return Object.entries(ghost.values).every(([name, value]) => {
    const setting = loop.settings[split(name)[1]];
    return setting !== undefined && same(setting.variable.kind, setting.sent, value);
  });
}

function hide() {
  asked += 1;
  if (store.ghost === undefined) return;
  store.ghost = undefined;
  store.emit("prediction");
}

async function make() {
  const values = edits();
  const loop = store.loop;
  const of = store.state;
  if (!values || !loop || !of) return hide();
  asked += 1;
  const mine = asked;
  try {
    const { processValue: unit, manipulatedValue: travel_unit } = await units(loop);
    const [from, to] = range();
    const view = { variables: drawnOfEarlier(loop), points: POINTS, ...(isZoomed() ? { from, to } : {}) };
    const tried = await ask({ do: "try", values, view, figures: { unit, travel_unit } });
    if (mine !== asked) return;
    store.ghost = { ...tried, values, of };
  } catch {
    // A problem with a value is reported beside its field.
    if (mine !== asked) return;
    store.ghost = undefined;
  }
  store.emit("prediction");
}

/** The values and figures of the trial: `GAIN 0.5: overshoot 3 %, settles 90 s`. Empty if there is no trial. */
export function ghostText() {
  const { ghost, loop } = store;
  if (!ghost || !loop) return "";
  const told = Object.entries(ghost.values).map(([name, value]) => {
    const [, own] = split(name);
    return `${own} ${shown(value, loop.settings[own]?.variable.kind ?? "REAL")}`;
  });
  return [told.join(", "), glanceText(ghost.figures)].filter(Boolean).join(": ");
}
