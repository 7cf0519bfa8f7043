/**
 * Saves and restores the session: loops, values, and the events of the run. It is saved in sessionStorage, which
 * survives a reload but not the closing of the tab, and less often in the list of the last sessions, which survives
 * both.
 */

import { ask } from "tool/engine.js";
import { keepSession, takeUp } from "tool/kept.js";
import { admit, programs } from "tool/program.js";
import { remake } from "tool/remake.js";
import { runsOf } from "tool/runs.js";
import { store } from "tool/store.js";

const KEY = "plcfmu";
const VERSION = 2;
/** A run with more calls than this is not repeated after a reload. */
const MOST_CALLS = 200_000;
/** Nor is a run with more events than this: a long ramp sets a value before each call. */
const MOST_EVENTS = 5000;
/**
 * The delay before a change is saved, and the minimum interval between saves to the list of the last sessions, in
 * milliseconds.
 */
const [SOON, OFTEN] = [300, 3000];
let keptLast = 0;
/** Whether another session is about to replace this one; its data must not be overwritten. */
let isLeaving = false;

/** The setup of the current run. @type {import("./messages").Setup | undefined} */
let setup;
/** @type {import("./messages").Event[]} */
let events = [];

/** Whether a value may have been set since the events were read. */
let isSet = false;

/** Starts saving the session on every change. */
export function keep() {
  let [timer, due] = [0, 0];
  const within = (/** @type {number} */ pause) => {
    // During a run, something changes all the time, which must not postpone a pending save.
    if (timer !== 0 && due <= Date.now() + pause) return;
    clearTimeout(timer);
    due = Date.now() + pause;
    timer = setTimeout(async () => {
      timer = 0;
      await readEvents();
      save();
    }, pause);
  };
  store.on("run", (begun) => {
    setup = begun;
    events = [];
  });
  for (const what of ["settings", "plant", "run"]) {
    store.on(what, () => {
      isSet = true;
    });
  }
  for (const what of ["files", "loops", "loop", "settings", "plant", "run"]) store.on(what, () => within(SOON));
  // Of the data to be saved, calls change only their own number, which is less urgent.
  store.on("state", () => within(OFTEN));
  addEventListener("pagehide", () => {
    keptLast = 0;
    save();
  });
}

async function readEvents() {
  if (!store.live || store.isLost || !isSet || events.length > MOST_EVENTS) return;
  isSet = false;
  try {
    events = (await ask({ do: "events" })).events;
  } catch (error) {
    store.say(error);
  }
}

function save() {
  if (isLeaving) return;
  const loops = store.loops.map((loop) => ({
    name: loop.name,
    member: loop.member,
    fmu: loop.description.name,
    file: loop.file,
    warnings: loop.warnings,
    members: loop.members,
    connections: loop.connections,
    step: loop.step,
    exchange: loop.exchange,
    notes: loop.notes,
    undo: loop.undo,
    redo: loop.redo,
    settings: Object.entries(loop.settings).map(([name, one]) => {
      const { file, origin, sent, opened, value, wrong, why } = one;
      return { name, file, origin, sent, opened, value, wrong, why };
    }),
  }));
  const live = store.live && setup && store.state && store.state.calls <= MOST_CALLS && events.length <= MOST_EVENTS;
  const run = live
    ? { of: store.loops.indexOf(/** @type {any} */ (store.live)), setup, events, calls: store.state?.calls }
    : undefined;
  const kept = {
    version: VERSION,
    programs: programs(),
    shown: store.loops.indexOf(/** @type {any} */ (store.loop)),
    loops,
    run,
  };
  // If the files are too large, as with thousands of loops, save only the open loops; the user must then reopen the
  // files.
  for (const files of [store.files.filter(({ isRefused }) => !isRefused), []]) {
    try {
      const content = JSON.stringify({ ...kept, files });
      sessionStorage.setItem(KEY, content);
      if (loops.length > 0 && Date.now() - keptLast > OFTEN) {
        keptLast = Date.now();
        keepSession(loops.map(({ name }) => name).join(", "), content);
      }
      return;
    } catch {
      // The storage is full or not available.
    }
  }
}

/** Restores a saved session by reloading the page. @param {import("tool/kept.js").KeptSession} session */
export function goOn(session) {
  isLeaving = true;
  takeUp(session, KEY);
  location.reload();
}

/** Restores the session from before the reload. */
export async function resume() {
  let kept;
  try {
    kept = JSON.parse(sessionStorage.getItem(KEY) ?? "null");
  } catch {
    return;
  }
  if (kept?.version !== VERSION) return;
  // If they are translated in the original order, the programs get the names to which the loops refer.
  for (const program of kept.programs ?? []) await admit(program).catch(store.say);
  store.files = kept.files;
  store.emit("files");
  for (const one of kept.loops) await resumeLoop(one).catch(store.say);
  const shown = store.loops[kept.shown];
  if (shown) store.show(shown);
  // Remove the runs of loops whose runs will not be repeated.
  for (const [at, loop] of store.loops.entries()) if (at !== kept.run?.of) delete loop.notes.runs;
  if (kept.run && store.loops[kept.run.of]) await resumeRun(kept.run).catch(store.say);
}

/** @param {any} one */
async function resumeLoop(one) {
  const loop = await store.add(one.name, one.fmu, undefined, one.file);
  Object.assign(loop, { member: one.member, warnings: one.warnings, notes: one.notes });
  Object.assign(loop, { members: one.members, connections: one.connections, step: one.step, exchange: one.exchange });
  for (const { name, ...values } of one.settings) {
    if (loop.settings[name]) Object.assign(loop.settings[name], values);
  }
  Object.assign(loop, { undo: one.undo ?? [], redo: one.redo ?? [] });
  store.emit("loop");
  store.emit("plant");
  // Update the fields, which were drawn with the start values.
  store.emit("settings", Object.keys(loop.settings));
  await store.check();
}

/** @param {{ of: number } & import("tool/remake.js").Made} run */
async function resumeRun(run) {
  const loop = store.loops[run.of];
  // The new engine numbers the runs anew.
  const before = runsOf(loop).splice(0);
  for (const kept of before.slice(0, -1)) {
    if (kept.calls > MOST_CALLS) continue;
    await remake(loop, kept);
    Object.assign(runsOf(loop).at(-1) ?? {}, { name: kept.name, colour: kept.colour, isShown: kept.isShown });
  }
  await remake(loop, run);
  Object.assign(runsOf(loop).at(-1) ?? {}, { name: before.at(-1)?.name, colour: before.at(-1)?.colour });
}
