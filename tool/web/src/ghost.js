/**
 * What-if curves: while a setting is being edited, the test of the current run, repeated with the values in the fields,
 * is drawn dashed behind the run. Once the values are applied, the curves stay until the run continues or restarts. The
 * engine computes them without disturbing the run.
 */

import { ask } from "tool/engine.js";
import { glanceText } from "tool/figures.js";
import { isZoomed, range } from "tool/moment.js";
import { drawnOfEarlier } from "tool/overlay.js";
import { programOf } from "tool/program.js";
import { units } from "tool/signals.js";
import { isEdited, split, store, variable } from "tool/store.js";
import { same, shown } from "tool/values.js";

/** The pause in typing before a trial, in milliseconds. */
const PAUSE = 150;
/** A run longer than this is not repeated on every keystroke. */
const MOST_CALLS = 20_000;
const POINTS = 1500;

let timer = 0;
/** The number of the last trial: an earlier one still pending is obsolete. */
let asked = 0;

/** Starts to draw trials. */
export function mount() {
  for (const what of ["settings", "loop", "run", "pause", "range"]) store.on(what, soon);
}

function soon() {
  clearTimeout(timer);
  if (edits() === undefined) {
    if (!isApplied()) hide();
  } else timer = setTimeout(make, PAUSE);
}

/** The edited settings, by their names in the engine; `undefined` if there is nothing to try. */
function edits() {
  const loop = store.loop;
  const calls = store.state?.calls ?? 0;
  // No trials for a program: its lines show the values of the current run.
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
