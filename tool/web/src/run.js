/**
 * Runs the loop, in real time, ten times as fast, or as fast as possible; offers controls for setpoint, disturbance,
 * noise and manual value; and lists the events of the run.
 *
 * @typedef {import("./messages").Value} Value
 */

import { attribute, byId, choice, element, fill, numberInput, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { leaveStep, repeated } from "tool/moment.js";
import { numberField } from "tool/number_field.js";
import { disturbances, sensorOf } from "tool/plant.js";
import { againButtons, isAnotherTest } from "tool/runs.js";
import { called, faults, isSwitch, manualSwitch, presentOutput, unitText } from "tool/signals.js";
import { split, store, variable, wiredTo } from "tool/store.js";
import { download } from "tool/takeaway.js";
import { testMaker } from "tool/test_case.js";
import { number, read, rounded, shown } from "tool/values.js";

/** How long calls are made without a break, in milliseconds. In the breaks, the page can respond to the user. */
const CHUNK = 20;
/** The duration of a screen frame, in milliseconds. Calls that are due within a frame are made together. */
const FRAME = 16;
const MOST_CALLS = 20_000;
/**
 * The maximum lag behind real time that is made up for, in milliseconds: a page in the background is woken only once a
 * minute.
 */
const MOST_BEHIND = 120_000;
/** The lag is displayed only if it exceeds this time, in milliseconds. */
const WORTH_TELLING = 1000;
const MOST_EVENTS = 500;
/** How a value was set, as appended to it in the log. @type {Record<string, string>} */
const TOLD = { force: ", forced", write: ", written once" };

/** @typedef {1 | 10 | typeof Infinity} Speed */

/** @type {Speed} */
let speed = 1;
const SPEED = "plcfmu-speed";
/**
 * Identifies the current loop of calls, which ends when another token replaces it; `undefined` while paused.
 *
 * @type {{} | undefined}
 */
let running;
/** The reference for determining due calls: a time in milliseconds, and the number of calls made by then. */
let clock = { wall: 0, calls: 0 };
/** The number of calls per request. */
let chunk = 1;
/** The lag of the run behind real time, in milliseconds. */
let behind = 0;

/** The number of calls at which the run pauses automatically, if it has a duration. @type {number | undefined} */
let end;
/** Why the run paused automatically; empty if it did not, or at the end of its duration. */
let ended = "";
/** The maximum number of calls of a run at speed max until the loop has settled. */
const MOST_UNRESTING = 20_000;

/** @type {HTMLButtonElement} */
let runButton;
/** Repeats the test with the settings that have been applied since it began. @type {HTMLButtonElement} */
let againButton;
/**
 * When settings were last applied, and when the step or disturbance measured by the metrics in the bar began, both in
 * seconds of the run.
 */
let [applied, stepped] = [0, 0];
/** Whether settings applied since the run began would change its result. */
let isOffered = false;
/** How long to run, in seconds. @type {HTMLInputElement} */
let duration;
/** @type {HTMLElement} */
let status;
/** @type {HTMLElement} */
let controls;
/** The setpoint, in the same row as Run. @type {HTMLElement} */
let goal;
/** @type {HTMLElement} */
let done;
/** @type {Map<Speed, HTMLButtonElement>} */
const speeds = new Map();

/** @param {HTMLElement} content */
export function mount(content) {
  runButton = element("button.primary", { id: "run-go", onclick: runOrPause, title: "Space" }, "Run");
  const again = { class: "primary", hidden: true, id: "run-again", "aria-label": "Run again with these values" };
  againButton = element(
    "button",
    {
      ...again,
      onclick: () => runAgain().catch(store.say),
      title: "The same test from the start, for the same time, with the new settings",
    },
    "Run again",
    element("span.long", " with these values"),
  );
  status = element("span.status");
  const aboutDuration = "How long to run; if empty, until Pause, or at speed max until the loop has settled";
  duration = numberInput({ id: "run-for", placeholder: "–", title: aboutDuration, oninput: checkDuration });
  duration.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && !running) runOrPause();
  });
  controls = element("div.row.controls");
  for (const [name, factor] of /** @type {[string, Speed][]} */ ([
    ["×1", 1],
    ["×10", 10],
    ["max", Infinity],
  ])) {
    const title = factor === 1 ? "Real time" : factor === 10 ? "Ten times real time" : "As fast as this computer can";
    speeds.set(
      factor,
      element("button", { title, "aria-pressed": String(factor === speed), onclick: () => setSpeed(factor) }, name),
    );
  }
  const more = element("button.more", { "aria-expanded": "false", "aria-controls": "run-more" }, "More");
  more.addEventListener("click", () => {
    const isOpen = byId("run").classList.toggle("is-open");
    attribute(more, "aria-expanded", String(isOpen));
  });
  goal = element("span.goal");
  fill(
    content,
    element(
      "div.row.run-main",
      againButton,
      runButton,
      element("button.rare", { onclick: oneCall, title: "." }, "One cycle"),
      element("span.speeds", { role: "group", "aria-label": "Speed" }, ...speeds.values()),
      element("label.run-for", { for: "run-for" }, "for ", duration, element("span.faint", " s")),
      element("button.rare.reset", { onclick: reset, title: "Start a new run; this one stays in the list" }, "Reset"),
      status,
      goal,
      more,
    ),
    element("div.row.run-more", { id: "run-more" }, controls, element("dl", { id: "glance" })),
  );
  done = byId("done").querySelector(".content") ?? content;
  store.on("loop", () => {
    pause();
    ended = "";
    showControls();
    showStatus();
    showDone();
  });
  store.on("plant", showControls);
  for (const what of ["loop", "plant"]) store.on(what, findFaults);
  store.on("run", showControls);
  store.on("settings", followSettings);
  store.on("settings", showAgain);
  store.on("applied", async (/** @type {string[]} */ names) => {
    const { loop, state } = store;
    const isSetting = names.some((name) => loop?.settings[name]?.variable.is_stimulus === false);
    if (!loop || !isSetting || !store.isLive() || made() === 0) return;
    const time = store.state?.time ?? 0;
    const isOther = await isAnotherTest(loop);
    if (store.loop !== loop || store.state?.run !== state?.run) return;
    applied = time;
    offerAgain(isOther);
  });
  store.on("figures", (/** @type {import("./messages").Figures} */ { from, step, disturbance }) => {
    // The bar shows the metrics of the later event.
    stepped = Math.max(step?.start ?? from, disturbance?.start ?? from);
    showFormer();
  });
  for (const what of ["run", "loop"]) store.on(what, () => offerAgain(false));
  store.on("run", () => {
    clock = { wall: performance.now(), calls: store.state?.calls ?? 0 };
    showDone();
  });
  store.on("state", showStatus);
  store.on("state", followRun);
  store.on("failure", () => {
    pause();
    store.say(
      `The run has ended (${store.state?.failure}). The controller and the curves are kept: choose another plant and continue, or reset.`,
    );
  });
  store.on("home", pause);
  store.on("pause", pause);
  store.on("run-to-rest", () => {
    duration.value = "";
    setSpeed(Infinity);
    run();
  });
  store.on("key-run", runOrPause);
  store.on("key-call", oneCall);
  store.on("key-manual", () => {
    const manual = store.loop && manualSwitch(store.loop);
    if (manual && store.loop) now({ [manual]: !store.loop.settings[manual]?.sent });
  });
  setSpeed(keptSpeed());
  showControls();
  showStatus();
  showDone();
}

/** Stops making calls. */
export function pause() {
  if (!running) return;
  running = undefined;
  store.isRunning = false;
  behind = 0;
  showButton();
  showStatus();
  showDone();
}

async function runOrPause() {
  if (running) pause();
  else if (await isApplied()) {
    leaveStep();
    run();
  }
}

/**
 * Applies edits, because a run with values other than the visible ones would be misleading. Returns whether all were
 * applied; if not, reports why.
 */
async function isApplied() {
  if (store.edited().length === 0 || (await store.send())) return true;
  const wrong = store.edited().filter((name) => store.loop?.settings[name].wrong !== undefined);
  if (wrong.length > 0) store.say(`${wrong.join(", ")} cannot be applied. Correct the value, or discard it with Esc.`);
  return false;
}

/**
 * Makes calls until the user pauses, the duration has passed or, at speed max without a duration, the loop has settled.
 */
async function run() {
  if (!store.loop) return;
  const seconds = checkDuration();
  if (seconds === null) {
    duration.reportValidity();
    return;
  }
  const mine = {};
  running = mine;
  store.isRunning = true;
  ended = "";
  showButton();
  try {
    if (!store.isLive()) await store.begin();
    startClock();
    let begun = Number.NEGATIVE_INFINITY;
    end = seconds === undefined ? undefined : made() + Math.max(Math.round(seconds / step()), 1);
    while (running === mine) {
      const isUntilRest = end === undefined && speed === Infinity;
      const left = (isUntilRest ? clock.calls + MOST_UNRESTING : (end ?? Infinity)) - made();
      if (left <= 0) {
        ended = isUntilRest ? "paused, not settled" : "";
        pause();
        return;
      }
      const due = Math.min(dueCalls(), left);
      if (due <= 0) {
        await until(Math.max(clock.wall + ((made() - clock.calls) * step() * 1000) / speed, begun + FRAME));
        continue;
      }
      const calls = Math.max(Math.min(due, chunk, MOST_CALLS), 1);
      begun = performance.now();
      if (isUntilRest && !store.loop?.notes.breakpoint) {
        const rests = await store.settle(calls, clock.calls * step());
        if (rests && running === mine) {
          ended = rests;
          pause();
          return;
        }
      } else await store.calls(calls);
      const took = Math.max(performance.now() - begun, 0.05);
      // The chunk at most doubles, but shrinks immediately.
      const fitting = Math.floor((calls * CHUNK) / took);
      chunk = Math.max(1, Math.min(fitting, calls * 2, MOST_CALLS));
      await breath();
    }
  } catch (error) {
    if (running === mine) pause();
    store.say(error);
  }
}

/** The duration in the field, in seconds: `undefined` if the field is empty, `null` if its text is invalid. */
function checkDuration() {
  if (duration.value.trim() === "") {
    attribute(duration, "aria-invalid", undefined);
    duration.setCustomValidity("");
    return undefined;
  }
  const got = read(duration.value, { name: "the duration", kind: "LREAL" });
  const isGood = "value" in got && number(got.value) > 0;
  const why = "why" in got ? got.why : "Run for more than 0 s.";
  attribute(duration, "aria-invalid", isGood ? undefined : "true");
  duration.setCustomValidity(isGood ? "" : why);
  return isGood ? number(got.value) : null;
}

function startClock() {
  clock = { wall: performance.now(), calls: made() };
  chunk = 1;
  behind = 0;
}

function made() {
  return store.state?.calls ?? 0;
}

function step() {
  return store.state?.step || 1;
}

/** The number of calls due now. The first call is due immediately, because a call shows the state at its own time. */
function dueCalls() {
  if (speed === Infinity) return MOST_CALLS;
  let elapsed = performance.now() - clock.wall;
  const reached = ((made() - clock.calls) * step() * 1000) / speed;
  if (elapsed - reached > MOST_BEHIND) {
    const left = Math.round((elapsed - reached - MOST_BEHIND) / 1000);
    store.say(`The page could not run for a while: ${left} s were skipped.`);
    clock.wall += elapsed - reached - MOST_BEHIND;
    elapsed = reached + MOST_BEHIND;
  }
  behind = Math.max(elapsed - reached, 0);
  return Math.floor((elapsed * speed) / 1000 / step()) + 1 - (made() - clock.calls);
}

/**
 * Waits until a time on the clock of `performance.now()`.
 *
 * @param {number} moment
 */
function until(moment) {
  return new Promise((done) => setTimeout(done, Math.max(moment - performance.now(), 0)));
}

const channel = new MessageChannel();
/** @type {(() => void)[]} */
const waiting = [];
channel.port1.onmessage = () => waiting.shift()?.();

/** Lets the page handle input and draw. A timer would take at least 4 ms, or a second in the background. */
function breath() {
  return new Promise((done) => {
    waiting.push(() => done(undefined));
    channel.port2.postMessage(0);
  });
}

async function oneCall() {
  if (!store.loop) return;
  pause();
  await store.calls(1).catch(store.say);
}

/** @param {boolean} next whether applied settings would change the result of the run */
function offerAgain(next) {
  isOffered = next;
  showFormer();
  showAgain();
}

/** Shows or hides the button Run again. It is also shown while there are edits, which it applies. */
function showAgain() {
  const { loop } = store;
  const isSetting = (/** @type {string} */ name) => loop?.settings[name]?.variable.is_stimulus === false;
  const isShown = isOffered || (store.isLive() && made() > 0 && store.edited(loop).some(isSetting));
  againButton.hidden = !isShown;
  runButton.classList.toggle("primary", !isShown);
  showButton();
}

/**
 * Marks the metrics in the bar as outdated if other settings were applied after the step or disturbance to which they
 * belong.
 */
function showFormer() {
  byId("glance").classList.toggle("is-former", isOffered && stepped <= applied);
}

async function runAgain() {
  pause();
  // "These values" on the button include edits.
  if (!(await isApplied())) return;
  await repeated("same_test");
  if (byId("run").contains(document.activeElement) || document.activeElement === document.body) runButton.focus();
}

async function reset() {
  if (!store.loop) return;
  pause();
  await store.begin().catch(store.say);
}

/** The speed that this tab had before a reload; 1 by default. @returns {Speed} */
function keptSpeed() {
  try {
    const kept = Number(sessionStorage.getItem(SPEED) ?? 1);
    return kept === 10 || kept === Infinity ? kept : 1;
  } catch {
    return 1;
  }
}

/** @param {Speed} next */
function setSpeed(next) {
  speed = next;
  try {
    sessionStorage.setItem(SPEED, String(next));
  } catch {
    // Without storage, the speed is lost on a reload.
  }
  duration.placeholder = next === Infinity ? "auto" : "–";
  for (const [factor, button] of speeds) attribute(button, "aria-pressed", String(factor === next));
  if (running) startClock();
  showStatus();
}

function showButton() {
  const goOn = store.edited().length > 0 ? "Apply, resume" : "Resume";
  text(runButton, running ? "Pause" : againButton.hidden ? "Run" : goOn);
}

function showStatus() {
  const state = store.isLive() ? store.state : undefined;
  if (!state) {
    text(status, store.loop ? "no run yet" : "");
    return;
  }
  const late =
    running && speed !== Infinity && behind > WORTH_TELLING ? `, ${(behind / 1000).toFixed(1)} s behind the clock` : "";
  const why = state.failure ? "failed" : running ? "" : ended;
  const stopped = faultNames.filter((name) => state.values[name] === true).map((name) => `${name}: stopped`);
  status.classList.toggle("error", stopped.length > 0);
  const calls = `${state.calls} ${state.calls === 1 ? "cycle" : "cycles"}`;
  const shown = [...stopped, `t = ${seconds(state.time, state.step)} s`, why, calls].filter(Boolean).join(", ");
  text(status, shown + late);
  // The bar may be too narrow for the whole text.
  attribute(status, "title", shown);
}

/** Finds the outputs that report a stopped plant. */
async function findFaults() {
  const loop = store.loop;
  faultNames = [];
  const found = loop ? await faults(loop).catch(() => []) : [];
  if (store.loop === loop) faultNames = found;
  showStatus();
}

/**
 * A time in the run, with as many digits as the step needs.
 *
 * @param {number} time
 * @param {number} step
 */
function seconds(time, step) {
  const digits = Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 6);
  return time.toFixed(digits);
}

/** @param {import("./messages").Values} values */
async function now(values, isEvent = false) {
  try {
    await store.now(values, isEvent);
    scheduleDone();
    return true;
  } catch (error) {
    store.say(error);
    return false;
  }
}

/**
 * Functions that show a new value in a field of the bar, by the name of its setting.
 *
 * @type {Map<string, (value: Value) => void>}
 */
const fields = new Map();
let shownControls = "";
/** The number of calls made when the fields were last updated from the run. */
let followed = 0;

/** Shows the controls for this loop: setpoint, disturbance, noise and manual value, as far as it has them. */
async function showControls() {
  const loop = store.loop;
  if (!loop) {
    shownControls = "";
    fill(controls);
    fill(goal);
    return;
  }
  const disturbing = await disturbances(loop).catch(() => []);
  if (store.loop !== loop) return;
  const { setpoint, manual, manual_pulses: manualPulses } = loop.description.roles;
  const sensor = sensorOf(loop);
  const what = JSON.stringify([loop.id, loop.connections, disturbing.map(({ name }) => name), sensor?.fmu]);
  if (what === shownControls) {
    for (const { name, value } of disturbing) fields.get(name)?.(value);
    if (sensor?.values.NOISE !== undefined) fields.get(`${sensor.name}.NOISE`)?.(sensor.values.NOISE);
    return;
  }
  shownControls = what;
  fields.clear();
  fill(goal, setpoint ? setpointControl(loop, setpoint) : null);
  fill(
    controls,
    disturbing.length > 0 ? disturbanceControl(disturbing) : null,
    sensor ? await noiseControl(sensor) : null,
    manual ? manualControl(loop, manual) : null,
    manualPulses ? pulseControl(loop, manualPulses) : null,
  );
}

/** Updates the fields after settings have changed elsewhere. @param {string[]} names */
function followSettings(names) {
  for (const name of names) {
    const setting = store.loop?.settings[name];
    // A disturbance's field is found by its full name, with the member.
    if (store.loop && setting) (fields.get(name) ?? fields.get(variable(store.loop, name)))?.(setting.sent);
  }
  scheduleDone();
}

/** Updates the fields after calls, because repeated events may have changed values. */
function followRun() {
  const state = store.isLive() ? store.state : undefined;
  if (!state || state.calls === followed) return;
  followed = state.calls;
  for (const [name, follow] of fields) {
    const value = state.values[name];
    if (value !== undefined) follow(value);
  }
}

/**
 * @param {import("tool/store.js").Work} loop
 * @param {string} name
 */
function setpointControl(loop, name) {
  const setting = loop.settings[name];
  if (!setting) return null;
  const source = wiredTo(loop, name);
  if (source) return element("span.control.faint", `${name} comes from ${called(loop, source)}`);
  const field = numberField("SP", "setpoint", setting.variable, setting.sent, (value) => now({ [name]: value }));
  fields.set(name, field.follow);
  const duration = numberField("in", "ramp-time", { name: "the ramp", kind: "LREAL", unit: "s" }, 10, () => ramp());
  const ramp = () => {
    const [to, seconds] = [field.check(), duration.check()];
    if (to === undefined || seconds === undefined) {
      (to === undefined ? field : duration).input.reportValidity();
      return;
    }
    store.ramp(name, to, seconds).then(scheduleDone).catch(store.say);
  };
  return element(
    "span.control",
    field.row,
    element("button", { onclick: field.enter, title: "Set it immediately (Enter)" }, "Step"),
    element("button", { onclick: ramp, title: "Move it linearly" }, "Ramp"),
    duration.row,
  );
}

/** @param {Awaited<ReturnType<typeof disturbances>>} disturbing */
function disturbanceControl(disturbing) {
  const place = element("span");
  // A check box needs this label; beside a number field, the button Disturb serves as one.
  const word = element("span", "Disturbance ");
  let at = 0;
  const names = disturbing.map(({ name }, number) => {
    const isOnly = disturbing.every((one) => one.name === name || split(one.name)[1] !== split(name)[1]);
    return [String(number), isOnly ? split(name)[1] : name];
  });
  const list = choice({ "aria-label": "Disturbance", title: "Disturbance" }, names, "0", (number) => {
    at = Number(number);
    showOne();
  });
  /** @type {(value: Value) => void} */
  let follow = () => {};
  for (const one of disturbing) {
    fields.set(one.name, (next) => {
      one.value = next;
      if (one === disturbing[at]) follow(next);
    });
  }
  const showOne = () => {
    const { name, variable, value } = disturbing[at];
    word.hidden = !isSwitch(variable);
    if (isSwitch(variable)) {
      const box = element("input", { type: "checkbox", id: "disturbance", checked: value === true });
      box.addEventListener("change", () => now({ [name]: box.checked }, true));
      follow = (next) => {
        box.checked = next === true;
      };
      fill(place, element("label", { for: "disturbance" }, box, " on"));
      return;
    }
    const field = numberField("", "disturbance", variable, value, (next) => now({ [name]: next }, true));
    attribute(field.input, "aria-label", `Disturbance ${name}`);
    follow = field.follow;
    fill(place, field.row, element("button", { onclick: field.enter, title: "Set it immediately (Enter)" }, "Disturb"));
  };
  showOne();
  return element("span.control", word, list, place);
}

/** @param {import("./messages").Member} sensor */
async function noiseControl(sensor) {
  const { variables } = await store.describe(sensor.fmu);
  const noise = variables.find((one) => one.name === "NOISE");
  if (!noise) return null;
  const name = `${sensor.name}.${noise.name}`;
  const field = numberField("Noise", "noise", noise, sensor.values[noise.name] ?? noise.start, (value) =>
    now({ [name]: value }),
  );
  fields.set(name, field.follow);
  return element("span.control", field.row);
}

/**
 * A check box for a Boolean setting.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {string} name
 * @param {string} word
 * @param {string} title
 */
function switchBox(loop, name, word, title) {
  const box = element("input", {
    type: "checkbox",
    checked: loop.settings[name]?.sent === true,
    disabled: wiredTo(loop, name) !== undefined,
  });
  box.addEventListener("change", () => now({ [name]: box.checked }));
  fields.set(name, (next) => {
    box.checked = next === true;
  });
  return element("label", { title }, box, ` ${word}`);
}

/**
 * The controls for the manual mode of a step controller: the motor runs while Up or Down is on.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {[string, [string, string]]} manual
 */
function pulseControl(loop, [onName, [up, down]]) {
  return element(
    "span.control",
    switchBox(loop, onName, "Manual", "M"),
    switchBox(loop, up, "Up", up),
    switchBox(loop, down, "Down", down),
  );
}

/**
 * @param {import("tool/store.js").Work} loop
 * @param {[string, string]} manual
 */
function manualControl(loop, [onName, valueName]) {
  const value = loop.settings[valueName];
  if (!loop.settings[onName] || !value) return null;
  const field = numberField(
    valueName.slice(valueName.lastIndexOf(".") + 1),
    "manual-value",
    value.variable,
    value.sent,
    (next) => now({ [valueName]: next }),
  );
  field.input.disabled = wiredTo(loop, valueName) !== undefined;
  fields.set(valueName, field.follow);
  const output = loop.description.roles.manipulated_value;
  const take = async () => {
    if (output === null || !store.isLive()) return;
    const present = await presentOutput(loop, variable(loop, output)).catch(store.say);
    if (present !== undefined) now({ [valueName]: present });
  };
  return element(
    "span.control",
    switchBox(loop, onName, "Manual", "M"),
    field.row,
    element("button", { onclick: field.enter, title: "Set it immediately (Enter)" }, "Set"),
    output &&
      element("button", { onclick: take, title: `Uses the current ${output}, so that nothing jumps` }, `= ${output}`),
  );
}

/** The names of outputs that are TRUE while a plant has stopped, such as a tripped drive. @type {string[]} */
let faultNames = [];
let isDoneScheduled = false;

/** Redraws the list of events soon, so that a ramp does not redraw it in each call. */
function scheduleDone() {
  if (isDoneScheduled) return;
  isDoneScheduled = true;
  setTimeout(() => {
    isDoneScheduled = false;
    showDone();
  }, 150);
}

/** Shows the list of events of the run, with buttons to repeat and save it. */
async function showDone() {
  const loop = store.loop;
  if (!loop || !store.isLive()) {
    store.emit("marks", []);
    fill(done, element("p.faint", "Lists what you set while the loop runs; the list can be repeated and saved."));
    return;
  }
  let events;
  try {
    ({ events } = await ask({ do: "events" }));
  } catch (error) {
    store.say(error);
    return;
  }
  if (store.loop !== loop || !store.isLive()) return;
  const lines = summed(events);
  const maker = testMaker();
  const kinds = new Map(Object.entries(loop.settings).map(([name, one]) => [variable(loop, name), one.variable]));
  store.emit(
    "marks",
    lines.map(({ variable: name, value, time }) => {
      const written = typeof value === "number" ? rounded(value, "REAL") : shown(value, "BOOL");
      return { time, text: `${called(loop, name)} ${written}` };
    }),
  );
  fill(
    done,
    element(
      "div.row",
      element(
        "span",
        lines.length === 0
          ? "Nothing was set in this run."
          : `${lines.length} ${lines.length === 1 ? "change" : "changes"} in this run.`,
      ),
      againButtons(),
      element("button", { onclick: () => download({ what: "description" }) }, "Save as TOML"),
      maker.button,
    ),
    maker.place,
    lines.length > 0 &&
      element(
        "ol.done-list",
        { tabindex: 0, "aria-label": "Events" },
        lines.slice(-MOST_EVENTS).map((line) => {
          const of = kinds.get(line.variable);
          const unit = unitText(of?.unit);
          const value = `${shown(line.value, of?.kind ?? "LREAL")}${unit ? ` ${unit}` : ""}`;
          const when =
            line.count > 1
              ? `${rounded(line.time, "REAL")} s to ${rounded(line.until, "REAL")} s`
              : `at ${rounded(line.time, "REAL")} s`;
          return element(
            "li",
            element("span.name", called(loop, line.variable)),
            ` ${line.count > 1 ? "moved to " : ""}${line.act === "release" ? "released" : value} ${when}${TOLD[line.act] ?? ""}`,
          );
        }),
      ),
  );
}

/**
 * Events as a list, with one line per ramp.
 *
 * @param {import("./messages").Event[]} events
 */
function summed(events) {
  /**
   * @type {{ variable: string, value: Value, act: string, time: number, until: number, last: number, count: number }[]}
   */
  const lines = [];
  /** @type {Map<string, typeof lines[number]>} */
  const open = new Map();
  for (const event of events) {
    const line = open.get(event.variable);
    if (line && line.act === (event.act ?? "set") && event.call - line.last === 1 && typeof event.value === "number") {
      Object.assign(line, { value: event.value, until: event.time, last: event.call, count: line.count + 1 });
      continue;
    }
    const made = {
      variable: event.variable,
      value: event.value,
      act: event.act ?? "set",
      time: event.time,
      until: event.time,
      last: event.call,
      count: 1,
    };
    open.set(event.variable, made);
    lines.push(made);
  }
  return lines;
}
