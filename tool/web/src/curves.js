/**
 * The curves of a run: setpoint and process value on the left, manipulated value on the right, others of choice, Booleans in
 * lanes below; earlier runs in grey, a predicted curve dashed; a cursor with the values of all.
 *
 * All values come from the engine's `view`, thinned to the width of the picture.
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
 * @property {boolean} isOfChoice whether the user has chosen it and can remove it
 *
 * @typedef {object} Notes what is kept with a loop
 * @property {string[]} chosen
 * @property {string[]} hidden
 * @property {number} window in seconds, 0 is all
 */

import { axis, FONT, onTheme, ranged, short, swatch, theme, timeAxis } from "tool/charts.js";
import { attribute, element, fill, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { copyInFull, drawnOfEarlier, drawOverlays, extent, overlays } from "tool/overlay.js";
import { called, isSwitch, roles, signals, units, unitText } from "tool/signals.js";
import { store } from "tool/store.js";
import { number, rounded, shown } from "tool/values.js";

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
const LANE = 17;
const HEIGHT = 270;
const NARROW = 620;

/** @type {HTMLElement} */
let place;
/** @type {HTMLElement} */
let above;
/** @type {HTMLElement} */
let below;
/** @type {HTMLElement} */
let readout;
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
/** @type {uPlot | undefined} */
let lanes;
/** @type {View} */
let view = { times: [], values: [], units: [], is_exact: true };
/** A part of the run that the user has chosen; without it the last part is shown and moves on. @type {[number, number] | undefined} */
let zoomed;
/** Where the cursor is, in seconds, as the keys or the mouse have set it. @type {number | undefined} */
let cursor;
/** Earlier runs: their curves by run. @type {Map<number, { key: string, view: View }>} */
const earlier = new Map();
/** Where a predicted curve begins: the time, and the loop's values then. It is a step away from them. */
let origin = { time: 0, processValue: 0, manipulatedValue: 0 };

let isScheduled = false;
let isFetching = false;
let isStale = false;

/** @param {HTMLElement} content */
export function mount(content) {
  build(content);
  new ResizeObserver(() => {
    if (plot && Math.abs(width() - plot.width) >= 1) {
      make();
      refresh();
    }
  }).observe(place);
  onTheme(() => make());
  store.on("loop", () => {
    zoomed = cursor = undefined;
    earlier.clear();
    view = { times: [], values: [], units: [], is_exact: true };
    choose();
  });
  store.on("plant", choose);
  store.on("run", () => {
    zoomed = undefined;
    refresh();
  });
  store.on("state", refresh);
  store.on("prediction", () => {
    origin = here();
    refresh();
  });
  store.on("key-left", () => move(-1));
  store.on("key-right", () => move(1));
  store.on("key-home", () => moveTo(view.times[0]));
  store.on("key-end", () => moveTo(view.times.at(-1)));
  store.on("key-zoom-in", () => zoomBy(0.5));
  store.on("key-zoom-out", () => zoomBy(2));
}

/** Where the loop is now. */
function here() {
  const loop = store.loop;
  if (!loop || !store.isLive() || !store.state)
    return { time: 0, processValue: Number.NaN, manipulatedValue: Number.NaN };
  const { processValue, manipulatedValue } = roles(loop);
  const { time, values } = store.state;
  return {
    time,
    processValue: number(values[processValue ?? ""]),
    manipulatedValue: number(values[manipulatedValue ?? ""]),
  };
}

/**
 * What is shown, as a picture: the curves with names and values, on paper.
 *
 * @returns {HTMLCanvasElement | undefined}
 */
export function picture() {
  if (!plot || !store.loop) return undefined;
  const ratio = plot.ctx.canvas.width / plot.width;
  const { paper, ink, curves: palette } = theme();
  const shownCurves = curves.filter(isShown);
  const top = 40 + 16 * Math.ceil(shownCurves.length / 4);
  const canvas = document.createElement("canvas");
  canvas.width = plot.ctx.canvas.width;
  canvas.height = Math.round(top * ratio) + plot.ctx.canvas.height + (lanes?.ctx.canvas.height ?? 0);
  const drawing = canvas.getContext("2d");
  if (!drawing) return undefined;
  drawing.fillStyle = paper;
  drawing.fillRect(0, 0, canvas.width, canvas.height);
  drawing.scale(ratio, ratio);
  drawing.fillStyle = ink;
  drawing.font = FONT.replace("11px", "bold 13px");
  drawing.fillText(`${store.loop.name}  ${store.loop.description.name}`, 8, 18, plot.width - 16);
  drawing.font = FONT;
  const at = index();
  const time = at === undefined ? "" : `at ${shown(view.times[at], "REAL")} s`;
  drawing.fillText(`${time}${cursor === undefined ? " (last call)" : " (cursor)"}`, 8, 34);
  const column = (plot.width - 16) / 4;
  shownCurves.forEach((curve, number) => {
    const [x, y] = [8 + column * (number % 4), 50 + 16 * Math.floor(number / 4)];
    drawing.fillStyle = palette[curve.colour % palette.length] ?? ink;
    drawing.fillRect(x, y - 5, 14, 3);
    drawing.fillStyle = ink;
    drawing.fillText(`${curve.label} ${valueText(curve, at, 6)} ${curve.unit}`, x + 18, y, column - 22);
  });
  drawing.setTransform(1, 0, 0, 1, 0, 0);
  drawing.drawImage(plot.ctx.canvas, 0, Math.round(top * ratio));
  if (lanes) drawing.drawImage(lanes.ctx.canvas, 0, Math.round(top * ratio) + plot.ctx.canvas.height);
  return canvas;
}

/** What part of the run is shown. @returns {{ from: number, to: number }} */
export function shownPart() {
  const [from, to] = range();
  return { from, to };
}

/** The curves that are shown, by their names in the engine. */
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
  following = element("button", { type: "button", onclick: () => follow(notes()?.window ?? 300) }, "Follow");
  adding = element("select", { onchange: add });
  above = element("div", {});
  below = element("div", {});
  spoken = element("p", { class: "visually-hidden", role: "status", "aria-live": "polite" });
  place = element(
    "div",
    {
      ...{ class: "chart", tabindex: 0, role: "slider", "aria-label": "Cursor in the curves", "aria-valuemin": 0 },
      ...{ "aria-valuemax": 0, "aria-valuenow": 0, "aria-valuetext": "no run yet", onkeydown: key },
      "aria-describedby": "curves-keys",
    },
    above,
    below,
  );
  readout = element("div", { class: "readout" });
  readout.addEventListener("copy", copyInFull);
  fill(
    content,
    element(
      "div",
      { class: "row curves-bar" },
      element("label", {}, "Window ", windowing),
      following,
      element("button", { type: "button", title: "Zoom in (+)", onclick: () => zoomBy(0.5) }, "Zoom in"),
      element("button", { type: "button", title: "Zoom out (-)", onclick: () => zoomBy(2) }, "Zoom out"),
      element("label", { class: "adding" }, "Add ", adding),
    ),
    element("div", { class: "curves-grid" }, place, readout),
    element(
      "p",
      { id: "curves-keys", class: "faint chart-keys" },
      "Drag to zoom, double click to follow again. Keys: ← → cursor, Shift ten times as far, Home, End, + −, Esc.",
    ),
    spoken,
  );
  choose();
}

/** @returns {Notes | undefined} */
function notes() {
  const loop = store.loop;
  if (!loop) return undefined;
  loop.notes.curves ??= { chosen: [], hidden: [], window: 300 };
  return loop.notes.curves;
}

/** @param {Curve} curve */
function isShown(curve) {
  return !notes()?.hidden.includes(curve.name);
}

/** Which curves there are for the loop that is shown. */
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
  const kept = /** @type {Notes} */ (notes());
  kept.chosen = kept.chosen.filter((name) => found.some((signal) => signal.name === name));
  const { setpoint, processValue, manipulatedValue, pulses, manual } = roles(loop);
  const main = [setpoint, processValue, manipulatedValue].filter((name) => name !== undefined);
  const outputs = found.filter(({ member, variable }) => member === loop.member && variable.role === "output");
  const shownFirst = main.length > 0 ? main : outputs.slice(0, 3).map((signal) => signal.name);
  const names = new Set([...shownFirst, ...kept.chosen, ...pulses, ...(manual ? [manual] : [])]);
  const left = knownUnits.processValue || unitOf(main[0] ?? shownFirst[0]);
  const right = knownUnits.manipulatedValue;
  let colour = 3;
  curves = [...names].flatMap((name) => {
    const signal = found.find((one) => one.name === name);
    if (!signal) return [];
    const isLeft = name === setpoint || name === processValue;
    const unit = isLeft ? left : name === manipulatedValue ? right : unitText(signal.variable.unit);
    const own = unit === left ? "left" : unit === right ? "right" : `unit ${unit}`;
    const scale = name === manipulatedValue ? "right" : isLeft ? "left" : own;
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
      isOfChoice: kept.chosen.includes(name),
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

/** The list of variables that can be added. */
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
    element("option", { value: "" }, `a curve (${MOST_CHOSEN - numbers.length} more) or a lane`),
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
  return Math.max(place?.clientWidth ?? 0, 200);
}

/** Makes the pictures anew: other curves, another width, other colours. */
function make() {
  plot?.destroy();
  lanes?.destroy();
  plot = lanes = undefined;
  makeReadout();
  if (curves.length === 0) return;
  const switches = curves.filter((curve) => curve.isSwitch && isShown(curve));
  plot = makePlot(
    curves.filter((curve) => !curve.isSwitch),
    switches.length === 0,
  );
  if (switches.length > 0) lanes = makeLanes(switches, plot);
  show();
}

/** @type {() => uPlot.Options["cursor"]} */
function cursorOptions() {
  return {
    ...{ y: false, points: { show: false }, drag: { x: true, y: false, setScale: false } },
    sync: { key: "curves", scales: ["x", null], setSeries: false },
    bind: {
      dblclick: () => () => {
        follow(notes()?.window ?? 300);
        return null;
      },
    },
  };
}

/** @type {() => uPlot.Hooks.Arrays} */
function hooks() {
  return {
    setSelect: [
      (self) => {
        if (self.select.width < 4) return;
        zoom(self.posToVal(self.select.left, "x"), self.posToVal(self.select.left + self.select.width, "x"));
        for (const one of [plot, lanes]) one?.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      },
    ],
    setCursor: [
      (self) => {
        if (isPlacing || !self.over.matches(":hover")) return;
        const { left, idx } = self.cursor;
        cursor = left === undefined || left < 0 || idx === null || idx === undefined ? undefined : view.times[idx];
        showValues();
      },
    ],
  };
}

let isPlacing = false;

/**
 * @param {Curve[]} numbers
 * @param {boolean} isAlone whether there are no lanes below
 */
function makePlot(numbers, isAlone) {
  const { curves: palette, grid } = theme();
  const visible = numbers.filter(isShown);
  const scales = [...new Set(["left", ...visible.map((curve) => curve.scale)])];
  /** @param {string} scale */
  const unit = (scale) => numbers.find((curve) => curve.scale === scale)?.unit ?? "";
  const isNarrow = width() < NARROW;
  const others = scales.filter((scale) => scale !== "left" && scale !== "right");
  return new uPlot(
    {
      ...{
        width: width(),
        height: HEIGHT,
        legend: { show: false },
        cursor: cursorOptions(),
        padding: [8, isNarrow ? 8 : null, 0, 0],
      },
      hooks: { ...hooks(), drawAxes: [(self) => drawOverlays(self, behind())] },
      scales: {
        x: { time: false, range: () => range() },
        ...Object.fromEntries(
          scales.map((scale) => [scale, { range: ranged(unit(scale), () => extent(behind(), scale, range())) }]),
        ),
      },
      series: [
        {},
        ...numbers.map((curve) => ({
          ...{ label: curve.label, scale: curve.scale, show: isShown(curve), points: { show: false } },
          ...{ stroke: palette[curve.colour % palette.length], width: curve.colour === 1 ? 2 : 1.4 },
          paths: curve.isStepped ? uPlot.paths.stepped?.({ align: 1 }) : undefined,
        })),
      ],
      axes: [
        isAlone
          ? timeAxis()
          : timeAxis({
              values: (_, splits) => splits.map(() => ""),
              size: 4,
              label: undefined,
              ticks: { show: false },
            }),
        axis({ scale: "left", label: axisLabel(numbers, "left"), size: 48, values: (_, splits) => splits.map(short) }),
        ...["right", ...(isNarrow ? [] : others)]
          .filter((scale) => scales.includes(scale))
          .map((scale) =>
            axis({
              ...{ scale, side: 1, label: axisLabel(numbers, scale), size: 42, grid: { show: false, stroke: grid } },
              values: (/** @type {uPlot} */ _, /** @type {number[]} */ splits) => splits.map(short),
            }),
          ),
      ],
    },
    undefined,
    above,
  );
}

/**
 * @param {Curve[]} numbers
 * @param {string} scale
 */
function axisLabel(numbers, scale) {
  const there = numbers.filter((curve) => curve.scale === scale && isShown(curve));
  const unit = numbers.find((curve) => curve.scale === scale)?.unit ?? "";
  return `${there.map((curve) => curve.label).join(", ")}${unit ? `  ${unit}` : ""}`;
}

/**
 * @param {Curve[]} switches
 * @param {uPlot} beside the plot above, whose axes it lines up with
 */
function makeLanes(switches, beside) {
  const { curves: palette, faint } = theme();
  const count = switches.length;
  // The place of uPlot's axes is known once they have been drawn.
  const ratio = uPlot.pxRatio;
  const left = beside.bbox.left / ratio;
  const right = beside.width - (beside.bbox.left + beside.bbox.width) / ratio;
  return new uPlot(
    {
      ...{
        width: width(),
        height: count * LANE + 40,
        legend: { show: false },
        cursor: cursorOptions(),
        hooks: hooks(),
      },
      padding: [4, right, 0, 0],
      scales: {
        x: { time: false, range: () => range() },
        lane: { range: () => [0, count] },
      },
      series: [
        {},
        ...switches.map((curve, at) => ({
          ...{ label: curve.label, scale: "lane", points: { show: false }, width: 1.2 },
          ...{ stroke: palette[curve.colour % palette.length], fill: `${palette[curve.colour % palette.length]}38` },
          ...{ fillTo: count - 1 - at + 0.12, paths: uPlot.paths.stepped?.({ align: 1 }) },
        })),
      ],
      axes: [
        timeAxis(),
        axis({
          ...{ scale: "lane", size: left, gap: 4, stroke: faint, ticks: { show: false }, grid: { show: false } },
          ...{
            splits: () => switches.map((_, at) => count - 0.5 - at),
            values: () => switches.map((curve) => narrow(curve.label)),
          },
        }),
      ],
    },
    undefined,
    below,
  );
}

/**
 * A name that fits beside the curves: without the blocks inside the controller.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {string} name
 */
function brief(loop, name) {
  const full = called(loop, name);
  return full === name ? name : full.slice(full.lastIndexOf(".") + 1);
}

/** A label that fits beside a lane. @param {string} label */
function narrow(label) {
  const last = label.slice(label.lastIndexOf(".") + 1);
  return last.length > 10 ? `${last.slice(0, 9)}…` : last;
}

/**
 * The part of the run that is shown.
 *
 * @returns {[number, number]}
 */
function range() {
  if (zoomed) return zoomed;
  const last = store.isLive() ? (store.state?.time ?? 0) : 0;
  const length = notes()?.window ?? 300;
  const predicted = store.prediction ? origin.time + (store.prediction.curves.times.at(-1) ?? 0) : 0;
  // A prediction reaches into the future, but does not push what was measured out of sight.
  const end = Math.max(last, length === 0 ? predicted : Math.min(predicted, last + length / 2));
  const step = store.state?.step ?? 1;
  if (length === 0) return [0, Math.max(end, 10 * step)];
  return end <= length ? [0, length] : [end - length, end];
}

/** @param {number} length in seconds, 0 is all */
function follow(length) {
  const kept = notes();
  if (kept) kept.window = length;
  zoomed = cursor = undefined;
  refresh();
}

/**
 * @param {number} from
 * @param {number} to
 */
function zoom(from, to) {
  const step = store.state?.step ?? 1;
  if (to - from < 2 * step) [from, to] = [(from + to) / 2 - step, (from + to) / 2 + step];
  zoomed = [Math.max(from, 0), Math.max(to, 2 * step)];
  refresh();
}

/** @param {number} factor */
function zoomBy(factor) {
  const [from, to] = range();
  const last = store.isLive() ? (store.state?.time ?? 0) : 0;
  const middle = Math.min(Math.max(cursor ?? Math.min(to, last), from), to);
  if (factor > 1 && from <= 0 && to >= last) return;
  zoom(middle - (middle - from) * factor, middle + (to - middle) * factor);
}

/** @param {KeyboardEvent} event */
function key(event) {
  const far = event.shiftKey ? 10 : 1;
  /** @type {Record<string, () => void>} */
  const keys = {
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
    Escape: () => follow(notes()?.window ?? 300),
  };
  const action = keys[event.key];
  if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation();
  action();
}

/** Moves the cursor by so many calls that are drawn. @param {number} by */
function move(by) {
  const at = index();
  if (at === undefined) return;
  // Two rows of one time are the lowest and the highest value there.
  let next = Math.min(Math.max(at + by, 0), view.times.length - 1);
  while (next > 0 && next < view.times.length - 1 && view.times[next] === view.times[at]) next += Math.sign(by);
  moveTo(view.times[next]);
}

/** @param {number | undefined} time */
function moveTo(time) {
  if (time === undefined) return;
  cursor = time;
  placeCursor();
  showValues();
  text(spoken, spokenValues());
}

/** The row at the cursor; the last one without it. @returns {number | undefined} */
function index() {
  const { times } = view;
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
  isPlacing = true;
  for (const one of [plot, lanes]) {
    if (!one) continue;
    const left = cursor === undefined ? -10 : one.valToPos(cursor, "x");
    one.setCursor({ left, top: cursor === undefined ? -10 : 1 }, false);
  }
  isPlacing = false;
}

/** Draws anew in the next frame, with what the engine has then. */
function refresh() {
  attribute(following, "aria-pressed", String(zoomed === undefined));
  isStale = true;
  if (isScheduled || isFetching) return;
  isScheduled = true;
  requestAnimationFrame(async () => {
    isScheduled = false;
    isStale = false;
    isFetching = true;
    try {
      await fetchCurves();
      show();
    } catch (error) {
      store.say(error);
    } finally {
      isFetching = false;
      if (isStale) refresh();
    }
  });
}

/** Gets what is to be seen from the engine. */
async function fetchCurves() {
  const loop = store.loop;
  if (!loop || !store.isLive() || curves.length === 0 || (store.state?.calls ?? 0) === 0) {
    view = { times: [], values: curves.map(() => []), units: [], is_exact: true };
    return;
  }
  const [from, to] = range();
  const names = curves.map((curve) => curve.name);
  const points = Math.max(Math.round(width()), 100);
  const got = await ask({ do: "view", variables: names, from, to, points });
  if (store.loop !== loop || names.length !== curves.length) return;
  view = got;
  await fetchEarlier(loop, from, to, points);
}

/**
 * Earlier runs do not change: they are asked for when another part of them is to be seen.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {number} from
 * @param {number} to
 * @param {number} points
 */
async function fetchEarlier(loop, from, to, points) {
  const runs = loop.runs.filter((run) => run !== store.state?.run).slice(-4);
  for (const run of earlier.keys()) if (!runs.includes(run)) earlier.delete(run);
  const variables = drawnOfEarlier(loop);
  if (variables.length === 0) return;
  for (const run of runs) {
    const part = zoomed ? { from, to } : {};
    const key = JSON.stringify([part, points, variables]);
    if (earlier.get(run)?.key === key) continue;
    try {
      earlier.set(run, {
        key,
        view: await ask({ do: "view", run, variables, ...part, points: zoomed ? points : 2 * points }),
      });
    } catch {
      // The engine keeps the last few runs only.
      loop.runs = loop.runs.filter((one) => one !== run);
      earlier.delete(run);
    }
  }
}

/** Shows what has been got. */
function show() {
  if (!plot) return;
  const numbers = curves.flatMap((curve, at) => (curve.isSwitch ? [] : [view.values[at] ?? []]));
  plot.setData(/** @type {uPlot.AlignedData} */ ([view.times, ...numbers]));
  if (lanes) {
    const switches = curves.flatMap((curve, at) => (curve.isSwitch && isShown(curve) ? [view.values[at] ?? []] : []));
    const rows = switches.map((values, at) => {
      const base = switches.length - 1 - at + 0.12;
      return values.map((value) => (value === null ? null : base + 0.72 * value));
    });
    lanes.setData(/** @type {uPlot.AlignedData} */ ([view.times, ...rows]));
  }
  if (cursor !== undefined) placeCursor();
  showValues();
}

/** What is drawn behind the curves. */
function behind() {
  const loop = store.loop;
  if (!loop) return [];
  const visible = curves.filter((curve) => !curve.isSwitch && isShown(curve));
  return overlays(
    loop,
    visible,
    [...earlier.values()].map(({ view }) => view),
    origin,
  );
}

/** The rows of the table beside the curves. @type {{ curve: Curve, cell: HTMLElement }[]} */
let rows = [];
/** @type {HTMLElement} */
let heading;

function makeReadout() {
  const { curves: palette } = theme();
  rows = curves.map((curve) => ({ curve, cell: element("td", { class: "number value" }) }));
  heading = element("caption", {}, "No run yet");
  const count = earlier.size;
  fill(
    readout,
    element(
      "table",
      {},
      heading,
      element(
        "thead",
        { class: "visually-hidden" },
        element(
          "tr",
          {},
          ["Curve", "Value", "Unit"].map((title) => element("th", { scope: "col" }, title)),
        ),
      ),
      element(
        "tbody",
        {},
        rows.map(({ curve, cell }) =>
          element(
            "tr",
            {},
            element(
              "th",
              { scope: "row" },
              element(
                "button",
                {
                  ...{
                    type: "button",
                    class: "curve-name",
                    "aria-pressed": String(isShown(curve)),
                    onclick: () => toggle(curve),
                  },
                  title: isShown(curve) ? `Hide ${curve.name}` : `Show ${curve.name}`,
                },
                swatch(isShown(curve) ? palette[curve.colour % palette.length] : "transparent"),
                element("span", { class: "name" }, curve.label),
              ),
            ),
            cell,
            element(
              "td",
              { class: "unit" },
              curve.unit,
              curve.isOfChoice &&
                element(
                  "button",
                  {
                    type: "button",
                    class: "plain remove",
                    "aria-label": `Remove ${curve.name}`,
                    onclick: () => remove(curve),
                  },
                  "×",
                ),
            ),
          ),
        ),
      ),
    ),
    count > 0 && element("p", { class: "faint" }, `Grey: ${count === 1 ? "the run" : `${count} runs`} before`),
  );
}

/**
 * @param {Curve} curve
 * @param {number | undefined} at
 * @param {number} [digits]
 */
function valueText(curve, at, digits) {
  if (at === undefined) return "";
  const value = view.values[curves.indexOf(curve)]?.[at];
  if (value === null || value === undefined) return "NaN";
  return digits
    ? rounded(curve.isSwitch ? value === 1 : value, curve.kind, digits)
    : shown(curve.isSwitch ? value === 1 : value, curve.kind);
}

function showValues() {
  const at = index();
  const loop = store.loop;
  for (const { curve, cell } of rows) {
    const full = valueText(curve, at);
    text(cell, valueText(curve, at, 9));
    attribute(cell, "title", full || undefined);
    attribute(cell, "data-full", full || undefined);
  }
  const time = at === undefined ? undefined : view.times[at];
  const grey = earlier.size > 0 ? ` · ${earlier.size} earlier in grey` : "";
  const which = cursor === undefined ? "now" : "cursor";
  if (heading) text(heading, time === undefined ? "No run yet" : `${which}: ${rounded(time, "REAL", 9)} s${grey}`);
  attribute(place, "aria-valuemax", view.times.at(-1) ?? 0);
  attribute(place, "aria-valuemin", view.times[0] ?? 0);
  attribute(place, "aria-valuenow", time ?? 0);
  attribute(place, "aria-valuetext", loop && time !== undefined ? spokenValues() : "no run yet");
}

function spokenValues() {
  const at = index();
  if (at === undefined) return "no run yet";
  const values = curves
    .filter(isShown)
    .map((curve) => `${curve.label} ${valueText(curve, at, 5)} ${curve.unit}`.trim());
  return [`${rounded(view.times[at], "REAL", 9)} s`, ...values].join("; ");
}
