/**
 * The first page: a live loop, and cards for the examples, each with a small curve.
 *
 * The engine has only one current run, so the live loop stops when a loop is opened.
 *
 * @typedef {import("./messages").KnownLoop} KnownLoop
 */

import { theme } from "tool/charts.js";
import { element, fill, svg, text } from "tool/dom.js";
import { ask, whereIsTheEngine } from "tool/engine.js";
import { outline } from "tool/outline.js";
import { openExample } from "tool/program_example.js";
import { EVERY, FIRST, MANIPULATED_VALUE, PROCESS_VALUE, SETPOINT } from "tool/recorded.js";
import { store } from "tool/store.js";
import { number, rounded } from "tool/values.js";

/** The names of the examples by task, best first. @type {[string, string[]][]} */
const TASKS = [
  ["Temperature", ["furnace", "zone", "furnace_pulses", "chamber", "chamber_mean"]],
  ["Level", ["level", "level_pulses"]],
  ["Valve", ["positioner", "valve", "valve_mean"]],
  ["Drive", ["speed"]],
  ["Any process", ["process", "process_integrating", "process_pulses", "sensor"]],
];
/** The examples that are not folded away, each with the question that it answers. @type {[string, string][]} */
const QUESTIONS = [
  ["furnace", "How do I tune a temperature?"],
  ["level", "Does my level hold when the load doubles?"],
  ["valve", "How does a step controller move a valve?"],
  ["furnace_pulses", "What do heating pulses do?"],
  ["speed", "Is my ramp slow enough for the drive?"],
];
const LIVING = "furnace";
/** The repeating setpoint profile of the live loop: start time in seconds and setpoint. @type {[number, number][]} */
const SETPOINTS = [
  [0, 60],
  [240, 90],
  [480, 60],
];
const ROUND = 720;
/** The speed of the live loop, as a multiple of real time, and its update interval in milliseconds. */
const [FACTOR, INTERVAL] = [10, 100];
/** The length of the live loop's visible part, in seconds, and the number of calls made before it is first shown. */
const [WINDOW, BEFORE] = [360, 150];
const [WIDTH, HEIGHT] = [640, 300];
const MARGIN = 12;
const [SMALL_WIDTH, SMALL_HEIGHT] = [168, 48];
const CHUNK = 2000;
const POINTS = 160;

/**
 * The examples as cards, by task.
 *
 * @param {(known: KnownLoop) => void} open
 */
export function cards(open) {
  const loops = store.catalogue.loops;
  const named = new Set(TASKS.flatMap(([, names]) => names));
  const others = loops.filter(({ name }) => !named.has(name)).map(({ name }) => name);
  const tasks = [...TASKS, /** @type {[string, string[]]} */ (["Other", others])];
  const isFirst = (/** @type {string} */ name) => QUESTIONS.some(([one]) => one === name);
  const all = tasks.flatMap(([task, names]) =>
    names.flatMap((name) => {
      if (isFirst(name)) return [];
      const known = loops.find((one) => one.name === name);
      return known ? [card(task, known, open)] : [];
    }),
  );
  const first = QUESTIONS.flatMap(([name, question]) => {
    const known = loops.find((one) => one.name === name);
    return known ? [card(question, known, open, question)] : [];
  });
  return element(
    "div",
    element("ul.cards", first, programCard()),
    element("details.all-examples", element("summary", `${all.length} more examples`), element("ul.cards", all)),
  );
}

/** The card for the user's own program. A click on it runs an example program. */
function programCard() {
  const line = (/** @type {string} */ path, /** @type {Record<string, any>} */ ink) =>
    svg("path", { d: path, fill: "none", stroke: "currentColor", ...ink });
  const picture = svg(
    "svg",
    { viewBox: `0 0 ${SMALL_WIDTH} ${SMALL_HEIGHT}`, "aria-hidden": "true", preserveAspectRatio: "none" },
    line("M4 10h60M12 20h74M12 30h46M4 40h30", { "stroke-opacity": 0.35, "stroke-width": 3 }),
    line("M100 42h12L140 14h26", { "stroke-width": 2 }),
  );
  const about = {
    title: "Drop your .scl file anywhere, or click to run an oven with a ramp and a trip",
    onclick: () => openExample().catch(store.say),
  };
  return element(
    "li",
    element(
      "button.card",
      { id: "program-card", ...about },
      element("span.spark", picture),
      element("strong.card-question", "Does my own program work?"),
      element("span.card-title", "Your own program (.scl)"),
      element("span.faint", "SCL + HEATER"),
    ),
  );
}

/**
 * @param {string} task
 * @param {KnownLoop} known
 * @param {(known: KnownLoop) => void} open
 * @param {string} [question]
 */
function card(task, known, open, question) {
  const title = known.title.replace(/^(The|An?) /, "").replace(/^./, (one) => one.toUpperCase());
  const about = { title: [`${task}: ${known.title}`, known.about].join(". "), onclick: () => open(known) };
  return element(
    "li",
    element(
      "button.card",
      { ...about },
      element("span.spark", { "data-known": known.name }, pictures.get(known.name)?.cloneNode(true) ?? null),
      question && element("strong.card-question", question),
      element("span.card-title", title),
      element("span.faint", known.setup.members.map(({ fmu }) => fmu).join(" + ")),
    ),
  );
}

/** The small curves drawn so far, by example. @type {Map<string, Node>} */
const pictures = new Map();

/** Whether the first page is shown and no run uses the page's engine. */
function isFree() {
  return store.loops.length === 0 && store.live === undefined && whereIsTheEngine() === "page";
}

/**
 * Shows the live loop's beginning, runs each example for its small curve, then runs the live loop until a loop is
 * opened.
 *
 * @param {HTMLElement} place element that shows the live loop
 */
export async function live(place) {
  const living = store.catalogue.loops.find(({ name }) => name === LIVING);
  if (living && isFree()) await begin(place, living);
  for (const known of store.catalogue.loops) {
    if (!isFree()) return;
    const made = await small(known);
    if (!made) return;
    pictures.set(known.name, made);
    for (const spark of document.querySelectorAll(`[data-known="${known.name}"]`)) fill(spark, made.cloneNode(true));
  }
  if (living && isFree()) await run(place, living);
}

/** The drawn signals of an example: setpoint, process value, manipulated value. @param {KnownLoop} known */
async function signalsOf({ setup: { members } }) {
  const [controller, ...others] = members;
  const { roles } = await store.describe(controller.fmu);
  const named = (/** @type {string | null} */ name) => (name ? `${controller.name}.${name}` : undefined);
  const plants = await Promise.all(
    others.map(async ({ name, fmu }) => ({ name, of: (await store.describe(fmu)).roles })),
  );
  const plant = plants.find(({ of }) => of.process_value);
  const output = plant ? `${plant.name}.${plant.of.process_value}` : undefined;
  // With pulses, the manipulated value is either on or off in each call, so it gives no readable curve.
  const isMean = roles.pulses.length > 0;
  return [
    roles.shown_process_value ? named(roles.setpoint) : undefined,
    named(roles.shown_process_value) ?? output,
    isMean ? undefined : named(roles.manipulated_value),
  ];
}

/**
 * Runs an example to the end of its description and draws its small curve; `undefined` if a loop was opened meanwhile.
 *
 * @param {KnownLoop} known
 */
async function small(known) {
  const step = known.setup.step ?? 1;
  const calls = Math.max(Math.round((known.stop ?? 100 * step) / step), 1);
  const names = await signalsOf(known);
  if (!isFree()) return undefined;
  await ask({ do: "start", ...known.setup });
  for (let at = 0; at < calls; ) {
    const due = known.events.filter(([time]) => Math.round(time / step) === at);
    for (const [, variable, value] of due) {
      if (!isFree()) return undefined;
      await ask({ do: "send", values: { [variable]: value } });
    }
    const next = Math.min(
      calls,
      at + CHUNK,
      ...known.events.map(([time]) => Math.round(time / step)).filter((one) => one > at),
    );
    if (!isFree()) return undefined;
    await ask({ do: "run", calls: next - at });
    at = next;
    await new Promise((done) => setTimeout(done, 0));
  }
  if (!isFree()) return undefined;
  const variables = names.flatMap((name) => name ?? []);
  const view = await ask({ do: "view", variables, points: POINTS });
  return picture(
    view,
    variables.map((name) => names.indexOf(name)),
    [SMALL_WIDTH, SMALL_HEIGHT],
    2,
  );
}

/**
 * Draws curves without axes. Setpoint and process value share a scale.
 *
 * @param {import("./messages").Curves} view
 * @param {number[]} which role of each curve: 0 setpoint, 1 process value, 2 manipulated value
 * @param {[number, number]} size
 * @param {number} margin
 * @param {[number, number]} [range] time range
 */
function picture(view, which, [width, height], margin, range = [view.times[0] ?? 0, view.times.at(-1) ?? 1]) {
  const { curves } = theme();
  // The first call is left out: a plant may not have a value yet.
  const there = (/** @type {number} */ at) => view.values[at].slice(2).filter((value) => value !== null);
  const together = which.flatMap((role, at) => (role < 2 ? there(at) : []));
  const x = (/** @type {number} */ time) => ((time - range[0]) / (range[1] - range[0] || 1)) * width;
  const drawn = which.map((role, at) => {
    const values = role < 2 ? together : there(at);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const span = high - low || 1;
    const y = (/** @type {number} */ value) => height - margin - ((value - low) / span) * (height - 2 * margin);
    const how = { isExact: view.is_exact, isStepped: role !== 1 };
    const { stroke, fill: area } = outline(view.times.slice(2), view.values[at].slice(2), how, x, y);
    const ink = { stroke: curves[role], "stroke-dasharray": role === 0 ? "4 3" : null, fill: "none" };
    const colour = { fill: curves[role], "fill-opacity": 0.3 };
    return [
      area ? svg("path", { d: area, ...colour }) : null,
      svg("path", { d: stroke, "stroke-width": role === 1 ? 2 : 1.3, ...ink }),
    ];
  });
  // Draw the process value on top.
  const order = drawn
    .map((_, at) => at)
    .sort((one, other) => (which[one] === 1 ? 1 : 0) - (which[other] === 1 ? 1 : 0));
  return svg(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true", preserveAspectRatio: "none" },
    ...order.flatMap((at) => drawn[at]),
  );
}

/**
 * Starts the live loop and runs it far enough for a meaningful picture.
 *
 * @param {HTMLElement} place
 * @param {KnownLoop} known
 */
async function begin(place, known) {
  await ask({ do: "start", ...known.setup });
  if (!isFree()) return;
  await ask({ do: "run", calls: BEFORE });
  if (isFree()) await show(place, known);
}

/**
 * @param {HTMLElement} place
 * @param {KnownLoop} known
 */
async function run(place, known) {
  await begin(place, known);
  const step = known.setup.step ?? 1;
  let time = BEFORE * step;
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
  const setpoint = (await signalsOf(known))[0] ?? "";
  while (isFree()) {
    await new Promise((done) => setTimeout(done, INTERVAL));
    // Pause while the page is not visible.
    if (document.hidden) continue;
    const calls = Math.max(Math.round((FACTOR * INTERVAL) / 1000 / step), 1);
    const now = SETPOINTS.findLast(([from]) => time % ROUND >= from)?.[1];
    if (!isFree()) return;
    if (now !== undefined) await ask({ do: "send", values: { [setpoint]: now } });
    if (!isFree()) return;
    await ask({ do: "run", calls });
    time += calls * step;
    if (isFree()) await show(place, known);
  }
}

/**
 * @param {HTMLElement} place
 * @param {KnownLoop} known
 */
async function show(place, known) {
  const names = await signalsOf(known);
  if (!isFree()) return;
  const state = await ask({ do: "state" });
  const from = Math.max(state.time - WINDOW, 0);
  const variables = names.flatMap((name) => name ?? []);
  if (!isFree()) return;
  const view = await ask({ do: "view", variables, from, points: 2 * WIDTH });
  const which = variables.map((name) => names.indexOf(name));
  paint(place, view, which, { time: state.time, from, values: variables.map((name) => number(state.values[name])) });
}

/**
 * @param {HTMLElement} place
 * @param {import("./messages").Curves} view
 * @param {number[]} which role of each curve: 0 setpoint, 1 process value, 2 manipulated value
 * @param {{ time: number, from: number, values: number[] }} now
 */
function paint(place, view, which, { time, from, values }) {
  const { curves } = theme();
  const titles = ["SP", "PV", "LMN"];
  const units = ["°C", "°C", "%"];
  const told = which.map((role, at) => {
    const dot = element("i.dot");
    dot.style.background = curves[role];
    const value = element("strong");
    text(value, rounded(values[at], "LREAL", 3));
    return element("span", dot, `${titles[role]} `, value, ` ${units[role]}`);
  });
  const together = which.flatMap((role, at) => (role < 2 ? view.values[at].slice(2) : [])).filter((of) => of !== null);
  const [low, high] = [Math.min(...together), Math.max(...together)];
  const mark = (/** @type {string} */ where, /** @type {string} */ label) =>
    element("span", { class: `mark is-${where} faint` }, label);
  fill(
    place,
    element("figcaption", told, element("span.faint", `${Math.round(time)} s`)),
    element(
      "div.plot",
      picture(view, which, [WIDTH, HEIGHT], MARGIN, [from, from + WINDOW]),
      mark("high", `${rounded(high, "LREAL", 3)} ${units[0]}`),
      mark("low", `${rounded(low, "LREAL", 3)} ${units[0]}`),
    ),
    element(
      "div.times.faint",
      [0, 1, 2, 3].map((part) => element("span", `${Math.round(from + (part * WINDOW) / 3)} s`)),
    ),
  );
}

/**
 * Shows a recording of the live loop's beginning until the engine is ready.
 *
 * @param {HTMLElement} place
 */
export function showRecorded(place) {
  const curves = [PROCESS_VALUE.map(() => SETPOINT), PROCESS_VALUE, MANIPULATED_VALUE];
  // `picture` skips the first two rows, so they can be empty.
  const times = [0, 0, ...PROCESS_VALUE.map((_, at) => FIRST + EVERY * at)];
  const view = { times, values: curves.map((values) => [null, null, ...values]), units: [], is_exact: true };
  const values = curves.map((of) => of[of.length - 1]);
  paint(place, view, [0, 1, 2], { time: times[times.length - 1], from: 0, values });
}
