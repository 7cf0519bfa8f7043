/**
 * The curves of a run: setpoint and process value on the left axis, manipulated value on the right, curves that the
 * user adds, and Booleans in lanes below. Earlier runs have their own colours, predicted curves are dashed, and a
 * cursor shows all values.
 *
 * All values come from the engine's `view`, thinned to the width of the picture: each pixel column shows the band from
 * the lowest to the highest value of its calls.
 *
 * @typedef {import("tool/signals.js").Signal} Signal
 * @typedef {import("./messages").Curves} View
 *
 * @typedef {object} Curve
 * @property {string} name `TIC101.LMN`
 * @property {string} label `LMN`
 * @property {string} kind the PLC type
 * @property {string} unit
 * @property {string} scale
 * @property {number} colour
 * @property {boolean} isStepped whether a value holds until the next
 * @property {boolean} isSwitch
 * @property {boolean} isDashed
 * @property {boolean} isMain setpoint, process value, manipulated value
 * @property {number | undefined} period averaging period of pulses, in seconds
 * @property {boolean} isOfChoice whether the user added the curve and can remove it
 */

import { onTheme, paperTheme, swatch, theme } from "tool/charts.js";
import { attribute, byId, element, fill, press, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { onceAFrame } from "tool/frame.js";
import { ghostText } from "tool/ghost.js";
import { cursorTime, follow, isZoomed, lookAt, momentText, notes, range, zoom, zoomBy } from "tool/moment.js";
import { copyInFull, drawnOfEarlier, ofCalls, overlays } from "tool/overlay.js";
import { CHAIN, choose as takePlant } from "tool/plant.js";
import { laneValues, makePlot } from "tool/plot.js";
import { programOf } from "tool/program.js";
import { makeReadout } from "tool/readout.js";
import { runsOf } from "tool/runs.js";
import {
  called,
  controlledValue,
  faults,
  isSwitch,
  manualSwitch,
  pulsePeriod,
  roles,
  signals,
  units,
  unitText,
} from "tool/signals.js";
import { store } from "tool/store.js";
import { hexadecimal, number, rounded, shown } from "tool/values.js";

const WINDOWS = /** @type {[string, number][]} */ ([
  ["1 min", 60],
  ["5 min", 300],
  ["15 min", 900],
  ["1 h", 3600],
  ["8 h", 28800],
  ["all", 0],
]);
const MOST_CHOSEN = 4;
const MOST_LANES = 8;
/** The minimum width and height of the picture, in CSS pixels. */
const [NARROWEST, LOWEST] = [200, 120];

/** @type {HTMLElement} */
let place;
/** @type {HTMLElement} */
let sheet;
/** @type {HTMLElement} */
let thinned;
/** The hint shown while there is no run. @type {HTMLElement} */
let nothing;
/** The legend of the drawn earlier runs and of the trial. @type {HTMLElement} */
let legend;
/** @type {HTMLElement} */
let readout;
/** @type {ReturnType<typeof makeReadout>} */
let showReadout = () => {};
/** @type {HTMLElement} */
let spoken;
/** @type {HTMLSelectElement} */
let adding;
/** @type {HTMLSelectElement} */
let windowing;
/** @type {HTMLButtonElement} */
let following;

/** All variables that can be drawn. @type {Signal[]} */
let available = [];
/** @type {Curve[]} */
let curves = [];
/** @type {uPlot | undefined} */
let plot;
/** The base line of each lane. @type {(at: number) => number} */
let base = () => 0;
/** The events of the run. @type {import("tool/plot.js").Mark[]} */
let marks = [];
/** @type {View} */
let view = { times: [], values: [], units: [], is_exact: true };
/**
 * The fetched curves of earlier runs, by run; `key` identifies the part and the variables fetched.
 *
 * @type {Map<number, { key: string, view: View }>}
 */
const earlier = new Map();

/** @param {HTMLElement} content */
export function mount(content) {
  build(content);
  new ResizeObserver(() => {
    if (!plot || (Math.abs(width() - plot.width) < 1 && Math.abs(height() - plot.height) < 1)) return;
    make();
    refresh();
  }).observe(place);
  onTheme(() => make());
  store.on("loop", () => {
    marks = [];
    earlier.clear();
    view = { times: [], values: [], units: [], is_exact: true };
    choose();
  });
  store.on("plant", choose);
  for (const what of ["run", "state", "runs", "range"]) store.on(what, refresh);
  store.on("cursor", () => {
    // While the pointer is over the chart, uPlot places the cursor itself.
    if (!isPointed) placeCursor();
    showValues();
  });
  store.on("marks", (/** @type {typeof marks} */ done) => {
    marks = done;
    refresh();
  });
  store.on("prediction", refresh);
  const isThere = () => place.offsetParent !== null;
  store.on("key-left", () => isThere() && move(-1));
  store.on("key-right", () => isThere() && move(1));
  store.on("key-home", () => isThere() && moveTo(view.times[0]));
  store.on("key-end", () => isThere() && moveTo(view.times.at(-1)));
  store.on("key-zoom-in", () => zoomBy(0.5));
  store.on("key-zoom-out", () => zoomBy(2));
}

/** Updates the curves even though the timing diagram hides them, for a picture. */
export async function bringUpToDate() {
  if (isInSight()) return;
  await fetchCurves();
  show();
}

/** The visible curves, for a picture. @param {boolean} [isRunOnly] without trial or predicted curves */
export function shownPicture(isRunOnly = false) {
  const visible = curves.filter(isShown);
  return {
    plot,
    view,
    curves: visible,
    values: visible.map(drawnValues),
    behind: behind(paperTheme(), isRunOnly),
    runs: drawnRuns(),
    ghost: isRunOnly ? "" : ghostText(),
    marks,
    base,
  };
}

/** The names of the visible curves, `MEMBER.VARIABLE`. */
export function shownNames() {
  return curves.filter(isShown).map((curve) => curve.name);
}

/** @param {HTMLElement} content */
function build(content) {
  windowing = element(
    "select",
    { onchange: () => follow(Number(windowing.value)) },
    WINDOWS.map(([name, seconds]) => element("option", { value: seconds }, name)),
  );
  following = element("button", { onclick: () => follow() }, "Follow");
  adding = element("select", { onchange: add });
  sheet = element("div.plot");
  thinned = element("span.thinned.faint");
  nothing = element("div.no-run");
  legend = element("div.earlier.faint", { "aria-label": "Earlier runs" });
  spoken = element("p.visually-hidden", { role: "status", "aria-live": "polite" });
  place = element(
    "div.chart",
    {
      ...{ tabindex: 0, role: "slider", "aria-label": "Cursor in the curves", "aria-valuemin": 0 },
      ...{ "aria-valuemax": 0, "aria-valuenow": 0, "aria-valuetext": "no run yet", onkeydown: key },
      "aria-describedby": "curves-keys",
    },
    sheet,
    legend,
  );
  readout = element("div.readout");
  readout.addEventListener("copy", copyInFull);
  fill(
    content,
    element(
      "div.curves-head",
      readout,
      element(
        "div.row.curves-bar",
        element("label", element("span.visually-hidden", "Window "), windowing),
        following,
        element("button", { title: "Zoom out (-)", onclick: () => zoomBy(2) }, "−"),
        element("button", { title: "Zoom in (+)", onclick: () => zoomBy(0.5) }, "+"),
        element("label.adding", element("span.visually-hidden", "Add "), adding),
      ),
    ),
    place,
    nothing,
    thinned,
    element(
      "p.visually-hidden",
      { id: "curves-keys" },
      "Drag to zoom, double-click to follow again. Keys: ← → cursor (ten times as far with Shift), Home, End, + −, Esc.",
    ),
    spoken,
  );
  choose();
}

/** @param {Curve} curve */
function isShown(curve) {
  return !notes()?.hidden.includes(curve.name);
}

/** Determines which curves the current loop has, and redraws them. */
async function choose() {
  const loop = store.loop;
  if (!loop) {
    curves = [];
    make();
    return;
  }
  const found = await signals(loop).catch((error) => {
    store.say(error);
    return [];
  });
  const knownUnits = await units(loop).catch(() => ({ processValue: "", manipulatedValue: "" }));
  if (store.loop !== loop) return;
  available = found;
  const kept = /** @type {import("tool/moment.js").Notes} */ (notes());
  kept.chosen = kept.chosen.filter((name) => found.some((signal) => signal.name === name));
  const { setpoint, manipulatedValue, pulses, processValue: own } = roles(loop);
  const processValue = await controlledValue(loop);
  const stopped = await faults(loop);
  if (store.loop !== loop) return;
  const main = [setpoint, processValue, manipulatedValue].filter((name) => name !== undefined);
  const outputs = found.filter(({ member, variable }) => member === loop.member && variable.role === "output");
  const shownFirst = main.length > 1 ? main : [...main, ...outputs.slice(0, 2).map((signal) => signal.name)];
  const names = new Set([...shownFirst, ...kept.chosen, ...pulses, ...stopped]);
  // The setpoint has the unit of the controller's own process value. The displayed process value may belong to another
  // block and have another unit.
  const left = own ? unitText(knownUnits.processValue) || unitOf(own) : unitOf(setpoint ?? processValue);
  const right = unitText(knownUnits.manipulatedValue);
  let colour = 3;
  curves = [...names].flatMap((name) => {
    const signal = found.find((one) => one.name === name);
    if (!signal) return [];
    const isLeft = name === setpoint || name === own;
    const unit = isLeft ? left : name === manipulatedValue ? right : unitText(signal.variable.unit);
    // One axis per unit; but process value and manipulated value without a unit are different quantities.
    const isSame = unit === left && (unit !== "" || !own || name !== manipulatedValue);
    const other = name === manipulatedValue || unit === right ? "right" : `unit ${unit}`;
    const scale = isLeft || isSame ? "left" : other;
    const place = [setpoint, processValue, manipulatedValue].indexOf(name);
    const isStepped = name === setpoint || name === manipulatedValue || signal.variable.kind !== "REAL";
    return {
      ...{
        name,
        label: brief(loop, name),
        kind: signal.variable.kind,
        unit,
        scale: isSwitch(signal.variable) ? "lane" : scale,
      },
      ...{ colour: place >= 0 ? place : colour++, isStepped, isSwitch: isSwitch(signal.variable) },
      ...{ isMain: place >= 0, isDashed: name === setpoint },
      isOfChoice: kept.chosen.includes(name),
      period: name === manipulatedValue ? pulsePeriod(loop) : undefined,
    };
  });
  offer();
  make();
  refresh();
}

/** @param {string | undefined} name */
function unitOf(name) {
  return unitText(available.find((signal) => signal.name === name)?.variable.unit);
}

/** Fills the list of variables that can be added. */
function offer() {
  const kept = notes();
  const loop = store.loop;
  if (!kept || !loop) return;
  windowing.value = String(kept.window);
  const numbers = kept.chosen.filter((name) => !curves.find((curve) => curve.name === name)?.isSwitch);
  const switches = curves.filter((curve) => curve.isSwitch);
  const members = [...new Set(available.map((signal) => signal.member))];
  fill(
    adding,
    element("option", { value: "" }, "Add a curve"),
    members.map((member) =>
      element(
        "optgroup",
        { label: member },
        available
          .filter((signal) => signal.member === member && !curves.some((curve) => curve.name === signal.name))
          .map(({ name, variable }) => {
            const isFull = isSwitch(variable) ? switches.length >= MOST_LANES : numbers.length >= MOST_CHOSEN;
            const unit = unitText(variable.unit);
            return element("option", { value: name, disabled: isFull }, `${variable.name}${unit ? ` in ${unit}` : ""}`);
          }),
      ),
    ),
  );
}

function add() {
  const kept = notes();
  if (!kept || !adding.value) return;
  kept.chosen.push(adding.value);
  choose();
}

/** @param {Curve} curve */
function remove(curve) {
  const kept = notes();
  if (!kept) return;
  kept.chosen = kept.chosen.filter((name) => name !== curve.name);
  choose();
  adding.focus();
}

/** @param {Curve} curve */
function toggle(curve) {
  const kept = notes();
  if (!kept) return;
  kept.hidden = isShown(curve) ? [...kept.hidden, curve.name] : kept.hidden.filter((name) => name !== curve.name);
  make();
}

function width() {
  return Math.max(place?.clientWidth ?? 0, NARROWEST);
}

function height() {
  return Math.max(place?.clientHeight ?? 0, LOWEST);
}

/** Recreates the picture after a change in curves, size or colours. */
function make() {
  plot?.destroy();
  plot = undefined;
  showReadout = makeReadout(readout, curves, { isShown, toggle, remove });
  // Show the values first: the readout may need a second row, which leaves less room for the picture.
  showValues();
  if (curves.length === 0) return;
  const size = { width: width(), height: height() };
  const parts = {
    range,
    isEmpty: () => view.times.length === 0,
    isExact: () => view.is_exact,
    behind: () => behind(),
    marks: () => marks,
    hooks: hooks(),
  };
  // Put the legend above the lanes.
  legend.style.bottom = `${44 + 18 * curves.filter((curve) => curve.isSwitch && isShown(curve)).length}px`;
  ({ plot, base } = makePlot(sheet, size, curves.filter(isShown), parts));
  plot.over.addEventListener("mouseleave", leave);
  plot.over.addEventListener("dblclick", () => follow());
  show();
}

/** @type {() => uPlot.Hooks.Arrays} */
function hooks() {
  return {
    setSelect: [
      (self) => {
        if (self.select.width < 4) return;
        zoom(self.posToVal(self.select.left, "x"), self.posToVal(self.select.left + self.select.width, "x"));
        self.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      },
    ],
    setCursor: [
      (self) => {
        if (isPlacing || !self.over.matches(":hover")) return;
        const { left, idx } = self.cursor;
        isPointed = true;
        lookAt(left === undefined || left < 0 || idx === null || idx === undefined ? undefined : view.times[idx]);
      },
    ],
  };
}

let isPlacing = false;
/** Whether the cursor was placed by the pointer. */
let isPointed = false;

function leave() {
  if (!isPointed) return;
  isPointed = false;
  lookAt(undefined);
}

/**
 * A variable's name for the readout: without the path of inner blocks if it belongs to the loop's own FMU.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {string} name
 */
function brief(loop, name) {
  const full = called(loop, name);
  return full === name ? name : full.slice(full.lastIndexOf(".") + 1);
}

/** @param {KeyboardEvent} event */
function key(event) {
  const far = event.shiftKey ? 10 : 1;
  press(event, {
    ArrowLeft: () => move(-far),
    ArrowRight: () => move(far),
    ArrowDown: () => move(-far),
    ArrowUp: () => move(far),
    PageDown: () => move(-50),
    PageUp: () => move(50),
    Home: () => moveTo(view.times[0]),
    End: () => moveTo(view.times.at(-1)),
    "+": () => zoomBy(0.5),
    "-": () => zoomBy(2),
    Escape: () => follow(),
  });
}

/** Moves the cursor by this many rows of the view. @param {number} by */
function move(by) {
  const at = index();
  if (at === undefined) return;
  // Two rows with the same time are the lowest and the highest value of a group of calls: skip the second.
  let next = Math.min(Math.max(at + by, 0), view.times.length - 1);
  while (next > 0 && next < view.times.length - 1 && view.times[next] === view.times[at]) next += Math.sign(by);
  moveTo(view.times[next]);
}

/** @param {number | undefined} time */
function moveTo(time) {
  if (time === undefined) return;
  isPointed = false;
  lookAt(time);
  text(spoken, spokenValues());
}

/** The row at the cursor, or the last row if there is no cursor. @returns {number | undefined} */
function index() {
  const { times } = view;
  const cursor = cursorTime();
  if (times.length === 0) return undefined;
  if (cursor === undefined) return times.length - 1;
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < cursor) low = middle + 1;
    else high = middle;
  }
  return low > 0 && cursor - times[low - 1] < times[low] - cursor ? low - 1 : low;
}

function placeCursor() {
  const cursor = cursorTime();
  isPlacing = true;
  const left = cursor === undefined || !plot ? -10 : plot.valToPos(cursor, "x");
  plot?.setCursor({ left, top: cursor === undefined ? -10 : 1 }, false);
  isPlacing = false;
}

/** Fetches and redraws the curves in the next frame, if they are visible. */
function refresh() {
  attribute(following, "aria-pressed", String(!isZoomed()));
  if (isInSight()) soon();
}

/** Whether the curves are visible, not hidden by the timing diagram. */
function isInSight() {
  return !byId("curves").classList.contains("shows-timing");
}

const soon = onceAFrame(async () => {
  await fetchCurves();
  show();
});

/** Fetches the visible part of the curves from the engine. */
async function fetchCurves() {
  const loop = store.loop;
  if (!loop || !store.isLive() || curves.length === 0 || (store.state?.calls ?? 0) === 0) {
    view = { times: [], values: curves.map(() => []), units: [], is_exact: true };
    return;
  }
  const [from, to] = range();
  const names = curves.map((curve) => curve.name);
  // One group of calls, which takes two rows, per pixel.
  const points = 2 * Math.round(width());
  const got = await ask({ do: "view", variables: names, from, to, points, means: periods() });
  if (store.loop !== loop || names.length !== curves.length) return;
  view = got;
  await fetchEarlier(loop, from, to, points);
}

/** The averaging period in seconds of each curve that shows the mean of pulses, by name. */
function periods() {
  return Object.fromEntries(curves.flatMap(({ name, period }) => (period === undefined ? [] : [[name, period]])));
}

/**
 * Fetches the curves of earlier runs. They do not change, so they are fetched again only if another part or other
 * variables become visible.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {number} from
 * @param {number} to
 * @param {number} points
 */
async function fetchEarlier(loop, from, to, points) {
  const runs = runsOf(loop).filter(({ run, isShown }) => isShown && run !== store.state?.run);
  for (const run of earlier.keys()) if (!runs.some((one) => one.run === run)) earlier.delete(run);
  const variables = drawnOfEarlier(loop);
  if (variables.length === 0) return;
  for (const { run, calls } of runs) {
    // If a run is much longer than the visible part, fetch only that part: otherwise, a group of calls would be wider
    // than a pixel.
    const isPart = isZoomed() || calls * (store.state?.step ?? 1) > 2 * (to - from);
    const part = isPart ? { from, to } : {};
    const key = JSON.stringify([part, points, variables]);
    if (earlier.get(run)?.key === key) continue;
    try {
      const means = Object.fromEntries(Object.entries(periods()).filter(([name]) => variables.includes(name)));
      const got = await ask({ do: "view", run, variables, ...part, points: isPart ? points : 2 * points, means });
      earlier.set(run, { key, view: got });
    } catch {
      // The engine no longer keeps this run.
      earlier.delete(run);
    }
  }
}

/** A curve's values, as they are drawn. @param {Curve} curve */
function drawnValues(curve) {
  return ofCalls(view.times, view.values[curves.indexOf(curve)] ?? []);
}

/** Shows the fetched data. */
function show() {
  if (!plot) return;
  const visible = curves.filter(isShown);
  const switches = visible.filter((curve) => curve.isSwitch);
  const rows = visible.map((curve) => {
    const values = drawnValues(curve);
    return curve.isSwitch ? laneValues(values, base(switches.indexOf(curve))) : values;
  });
  plot.setData(/** @type {uPlot.AlignedData} */ ([view.times, ...rows]));
  const calls = Math.round(((view.times[2] ?? 0) - (view.times[0] ?? 0)) / (store.state?.step ?? 1));
  text(thinned, view.is_exact ? "" : `min to max of every ${calls} cycles`);
  if (cursorTime() !== undefined) placeCursor();
  showValues();
  showEarlier();
}

/** Shows the names of the earlier runs drawn, in their colours, and the trial with its figures. */
function showEarlier() {
  const drawn = drawnRuns();
  const tried = ghostText();
  const key = JSON.stringify([tried, ...drawn.map(({ name, colour }) => [name, colour])]);
  if (legend.dataset.key === key) return;
  legend.dataset.key = key;
  const { curves: palette, runs } = theme();
  fill(
    legend,
    drawn.map(({ name, colour }) => element("span", swatch(runs[colour % runs.length]), name)),
    tried && element("span.ghost", swatch(palette[1], true), tried),
  );
}

/** The earlier runs whose curves are drawn. */
function drawnRuns() {
  return runsOf(store.loop).filter(({ run }) => earlier.has(run));
}

/** The curves drawn behind the run. @param {ReturnType<typeof theme>} [colours] @param {boolean} [isRunOnly] */
function behind(colours, isRunOnly) {
  const loop = store.loop;
  if (!loop) return [];
  const visible = curves.filter((curve) => !curve.isSwitch && isShown(curve));
  return overlays(
    loop,
    visible,
    runsOf(loop).flatMap(({ run, colour }) => {
      const of = earlier.get(run);
      return of ? [{ view: of.view, colour }] : [];
    }),
    colours,
    isRunOnly,
  );
}

/**
 * A curve's value at row `at` of the view or, without a cursor, its current value. For a group of calls: `lowest …
 * highest`.
 *
 * @param {Curve} curve
 * @param {number | undefined} at
 * @param {number} [digits] by default, all
 */
function valueText(curve, at, digits) {
  /** @param {import("./messages").Value | null | undefined} value */
  const written = (value) => {
    if (value === null || value === undefined) return "NaN";
    const of = curve.isSwitch ? number(value) === 1 : value;
    // A block's WORD is an analog value; a program's WORD is a bit pattern, shown in hexadecimal.
    const bits = programOf(store.loop) && hexadecimal(of, curve.kind);
    if (bits) return bits;
    return digits ? rounded(of, curve.kind, digits) : shown(of, curve.kind);
  };
  if (at === undefined) return "";
  if (cursorTime() === undefined && store.isLive() && curve.period === undefined)
    return written(store.state?.values[curve.name]);
  const values = view.values[curves.indexOf(curve)] ?? [];
  if (view.is_exact) return written(values[at]);
  const pair = [values[at - (at % 2)], values[at - (at % 2) + 1]].filter((value) => typeof value === "number");
  const [low, high] = [written(Math.min(...pair)), written(Math.max(...pair))];
  return low === high || pair.length < 2 ? written(pair[0]) : `${low} … ${high}`;
}

function showValues() {
  showNothing();
  const at = index();
  const loop = store.loop;
  const time = at === undefined ? undefined : view.times[at];
  const heading = time === undefined ? "" : momentText();
  showReadout(
    (curve) => ({ text: valueText(curve, at, curve.isMain ? 5 : 6), full: valueText(curve, at) }),
    heading,
    mode(),
  );
  attribute(place, "aria-valuemax", view.times.at(-1) ?? 0);
  attribute(place, "aria-valuemin", view.times[0] ?? 0);
  attribute(place, "aria-valuenow", time ?? 0);
  attribute(place, "aria-valuetext", loop && time !== undefined ? spokenValues() : "no run yet");
}

/** While there is no run, shows what to do next. */
function showNothing() {
  const loop = store.loop;
  const isEmpty = loop !== undefined && (!store.isLive() || (store.state?.calls ?? 0) === 0);
  nothing.hidden = !isEmpty;
  const hasPlant = (loop?.members.length ?? 0) > 0;
  const key = `${loop?.id} ${isEmpty} ${hasPlant}`;
  if (!loop || !isEmpty || nothing.dataset.key === key) return;
  nothing.dataset.key = key;
  const test = stepTest(loop);
  const ready = test ? "Ready: run the loop, or run a step test to tune it." : "Ready: run the loop.";
  const words = hasPlant ? ready : "No plant is connected yet. Choose one:";
  fill(nothing, element("p", words), hasPlant ? test : plants(loop));
}

/** A button that starts a step test for tuning. @param {import("tool/store.js").Work} loop */
function stepTest(loop) {
  if (loop.description.roles.controller.length === 0 || !manualSwitch(loop)) return null;
  const make = () => {
    store.emit("show", "tune");
    document.getElementById("step-test")?.click();
  };
  return element("button.primary", { onclick: make }, "Run a step test");
}

/**
 * Buttons for the plants that this controller drives in the examples, or for all plants if no example contains it.
 *
 * @param {import("tool/store.js").Work} loop
 */
function plants(loop) {
  const known = store.catalogue.loops.filter(({ setup }) => setup.members[0]?.fmu === loop.description.name);
  const driven = new Set(known.flatMap(({ setup }) => setup.members.slice(1).map(({ fmu }) => fmu)));
  const offered = store.catalogue.fmus.filter(
    ({ name, part }) => part === "plant" && (driven.has(name) || driven.size === 0),
  );
  return offered
    .filter(({ name }) => name !== CHAIN.fmu)
    .map(({ name, summary }) => element("button", { title: summary, onclick: () => takePlant(name) }, name));
}

/** The controller's current mode, AUTO or MANUAL; empty if there is no run or no manual mode. */
function mode() {
  const loop = store.loop;
  const { manual } = loop ? roles(loop) : { manual: undefined };
  const on = manual && store.isLive() ? store.state?.values[manual] : undefined;
  return on === undefined ? "" : on ? "MANUAL" : "AUTO";
}

function spokenValues() {
  const at = index();
  if (at === undefined) return "no run yet";
  const values = curves
    .filter(isShown)
    .map((curve) => `${curve.label} ${valueText(curve, at, 5)} ${curve.unit}`.trim());
  return [`${rounded(view.times[at], "REAL", 9)} s`, ...values].join("; ");
}
