/**
 * The timing diagram of a program: a lane for each Boolean, steps as bands with numbers and names, a panel of analog
 * values for each unit, and a cursor. Beside each signal is its value at the cursor or now. Lanes are as high as a line
 * of text and scroll if necessary.
 *
 * @typedef {import("tool/history.js").Track} Track
 * @typedef {import("tool/store.js").Work} Work
 * @typedef {import("tool/timing_signals.js").Shown} Shown
 *
 * @typedef {object} Row a lane, a band, or a panel with several signals
 * @property {Shown[]} signals
 * @property {HTMLElement} row
 * @property {HTMLElement[]} values one for each signal
 * @property {SVGElement} plot
 */

import { clock, numberings, onTheme, swatch, TIME_STEPS, theme, ticks, timeUnit } from "tool/charts.js";
import { attribute, byId, element, fill, press, svg, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { forcedSpans, isForced } from "tool/force.js";
import { onceAFrame } from "tool/frame.js";
import { parts, placeOf, tracks } from "tool/history.js";
import {
  callAt,
  cursorTime,
  follow,
  isLate,
  lookAt,
  momentText,
  momentValues,
  range,
  timeOf,
  zoom,
  zoomBy,
} from "tool/moment.js";
import { outline } from "tool/outline.js";
import { programOf } from "tool/program.js";
import { compared, comparedText, hasRun, sameAgain } from "tool/same_again.js";
import { store } from "tool/store.js";
import { chooser, shownSignals, valueText } from "tool/timing_signals.js";

/**
 * The height of a lane, which must equal that in the style sheet; the minimum height of a panel; and the minimum width
 * of a picture; all in pixels.
 */
const [LANE, PANEL, NARROWEST] = [22, 84, 100];
/** The y coordinates of TRUE and FALSE in a lane, and the margin at the top and the bottom of a panel. */
const [HIGH, LOW, MARGIN] = [4, 17, 8];
/** Changes less than this many pixels apart are not distinguished. */
const NEAR = 3;
/** The approximate width of a letter, and the space around a text, in pixels. */
const [LETTER, ROOM] = [6.4, 6];
/** The minimum distance for a pointer movement to count as a drag, in pixels. */
const DRAG = 4;

/** @type {HTMLElement} */
let diagram;
/** @type {HTMLElement} */
let list;
/** @type {SVGElement} */
let axis;
/** @type {HTMLElement} */
let line;
/** @type {HTMLElement} */
let selection;
/** @type {HTMLElement} */
let badge;
/** @type {HTMLElement} */
let hint;
/** @type {HTMLElement} */
let slider;
/** @type {HTMLButtonElement[]} */
let views = [];
/** @type {ReturnType<typeof chooser>} */
let choosing;
/** @type {HTMLButtonElement} */
let again;
/** The verdict on the repeated run: whether and where it differs from the earlier one. @type {HTMLElement} */
let verdict;

/** @type {Row[]} */
let rows = [];
/** Identifies the signals for which the rows were built. */
let made = "";
/** The known history of the run's signals, by name. @type {Map<string, Track>} */
let known = new Map();
/** The same for the run with which it is compared, but only of signals that differ. @type {Map<string, Track>} */
let before = new Map();
/** @type {import("./messages").Curves | undefined} */
let curves;

/** Whether the cursor follows the pointer, not pinned. */
let isPointed = false;

/** @param {HTMLElement} content the content of the curves panel, in which the diagram replaces the curves */
export function mount(content) {
  list = element("div.timing-rows", { tabindex: -1 });
  axis = svg("svg.timing-axis");
  slider = element(
    "div.timing-slider",
    {
      ...{ role: "slider", tabindex: 0, "aria-label": "Cursor in the timing diagram" },
      ...{ "aria-valuemin": 0, "aria-valuemax": 0, "aria-valuenow": 0, onkeydown: key },
      title: "← → one cycle, with Shift ten; Page keys: next change; + − zoom; Esc: now",
    },
    axis,
  );
  line = element("div.timing-cursor", { hidden: true });
  selection = element("div.timing-selection", { hidden: true });
  hint = element("p.timing-hint.faint");
  diagram = element("div.timing", list, slider, line, selection, hint);
  badge = element("span.mode.timing-moment", { role: "status" });
  views = [
    ["Diagram", true],
    ["Curves", false],
  ].map(([title, isTiming]) =>
    element("button", { onclick: () => choose(isTiming === true) }, /** @type {string} */ (title)),
  );
  const repeat = () => sameAgain().catch(store.say);
  again = element(
    "button.same-again",
    { onclick: repeat, title: "Repeats the last run's inputs with the current program" },
    "Same again",
  );
  verdict = element("span.timing-verdict", { role: "status" });
  const group = element("span.speeds.timing-views", { role: "group", "aria-label": "View" }, ...views);
  choosing = chooser(() => rebuild());
  const head = content.querySelector(".curves-head");
  head?.prepend(group, again, badge, verdict);
  head?.querySelector(".curves-bar")?.append(choosing.fold);
  content.append(diagram);
  point();
  new ResizeObserver(refresh).observe(diagram);
  onTheme(() => rebuild(true));
  for (const what of ["loop", "plant"]) store.on(what, () => rebuild());
  for (const what of ["state", "run", "range"]) store.on(what, refresh);
  store.on("cursor", () => isShown() && placeCursor(width(), list.offsetLeft + list.clientWidth));
  store.on("moment", showValues);
  for (const what of ["forced", "compared"]) store.on(what, refresh);
  store.on("key-left", () => isShown() && move(-1));
  store.on("key-right", () => isShown() && move(1));
  store.on("key-home", () => isShown() && lookAt(timeOf(0)));
  store.on("key-end", () => isShown() && lookAt(timeOf(lastCall())));
  rebuild();
}

/** @param {boolean} isTiming whether to show the diagram rather than the curves */
function choose(isTiming) {
  const loop = store.loop;
  if (loop) loop.notes.timing = { ...loop.notes.timing, isOff: !isTiming };
  rebuild();
}

/** Whether the diagram is shown. */
function isShown() {
  return programOf(store.loop) !== undefined && store.loop?.notes.timing?.isOff !== true;
}

/**
 * Rebuilds the rows for the current loop if they have changed.
 *
 * @param {boolean} [isForced] whether to rebuild regardless, because colours have changed
 */
async function rebuild(isForced = false) {
  const loop = store.loop;
  byId("curves").classList.toggle("shows-timing", isShown());
  for (const [at, button] of views.entries()) attribute(button, "aria-pressed", String((at === 0) === isShown()));
  byId("curves").classList.toggle("has-timing", programOf(loop) !== undefined);
  if (!loop || !isShown()) {
    made = "";
    return;
  }
  try {
    const shown = await shownSignals(loop);
    if (store.loop !== loop) return;
    choosing.follow(loop);
    const key = JSON.stringify([loop.id, loop.description.name, shown.map(({ name, kind }) => [name, kind])]);
    if (key !== made || isForced) build(shown);
    made = key;
    refresh();
  } catch (error) {
    store.say(error);
  }
}

/** @param {Shown[]} shown */
function build(shown) {
  const { curves: palette } = theme();
  const lanes = shown.filter(({ kind }) => kind !== "panel").map((one) => row([one], palette));
  const panels = shown.filter(({ kind }) => kind === "panel");
  const units = [...new Set(panels.map(({ unit }) => unit))];
  const groups = units.map((unit) =>
    row(
      panels.filter((one) => one.unit === unit),
      palette,
    ),
  );
  rows = [...lanes, ...groups];
  fill(
    list,
    rows.map((one) => one.row),
  );
}

/**
 * @param {Shown[]} signals
 * @param {string[]} palette
 * @returns {Row}
 */
function row(signals, palette) {
  const [{ kind, unit }] = signals;
  const values = signals.map(() => element("span.value.number"));
  const labels = signals.map(({ label, name, colour, isDashed }, at) =>
    element(
      "div.timing-label",
      { title: name, "data-signal": name },
      kind === "panel" && swatch(palette[colour % palette.length], isDashed),
      element("button.plain.name", { "aria-label": `Why ${label}?`, onclick: () => store.emit("why", name) }, label),
      values[at],
    ),
  );
  const plot = svg("svg.timing-plot", { "aria-hidden": "true" });
  const head = kind === "panel" ? element("div.timing-unit.faint", unit || "without a unit") : null;
  const made = element("div", { class: `timing-row is-${kind}` }, element("div", head, labels), plot);
  return { signals, row: made, values, plot };
}

const soon = onceAFrame(async () => {
  await fetchSignals();
  if (isShown()) draw();
});

function refresh() {
  if (isShown()) soon();
}

/** The width of the pictures: that of the list without the column of names. */
function width() {
  const names = Number.parseFloat(getComputedStyle(diagram).getPropertyValue("--names"));
  return Math.max(list.clientWidth - names, NARROWEST);
}

function lastCall() {
  return Math.max((store.isLive() ? (store.state?.calls ?? 0) : 0) - 1, 0);
}

/** Fetches the visible part of the run from the engine. */
async function fetchSignals() {
  const state = store.isLive() ? store.state : undefined;
  const all = rows.flatMap(({ signals }) => signals);
  if (!state || state.calls === 0) {
    known = new Map();
    curves = undefined;
    return;
  }
  const of = (/** @type {boolean} */ isPanel) =>
    all.flatMap(({ kind, name }) => ((kind === "panel") === isPanel && name in state.values ? [name] : []));
  known = await tracks(of(false), state);
  const { of: other, calls, first } = compared() ?? {};
  const differing = of(false).filter((name) => first?.has(name));
  before =
    other === undefined || calls === undefined
      ? new Map()
      : await tracks(differing, { ...state, run: other, calls, time: timeOf(calls - 1), after: state.after && {} });
  const variables = of(true);
  const [from, to] = range();
  // Include one more call on each side, so that lines continue to the edges.
  const part = { from: Math.max(from - state.step, 0), to: to + state.step };
  curves = undefined;
  if (variables.length > 0) curves = await ask({ do: "view", variables, ...part, points: 2 * Math.round(width()) });
  names = variables;
}

/** The names of the signals in `curves`. @type {string[]} */
let names = [];

/** Draws the visible rows. */
function draw() {
  const [from, to] = range();
  // Measure everything before changing anything, so that the browser computes the layout only once.
  const [across, right, step] = [width(), list.offsetLeft + list.clientWidth, store.state?.step ?? 1];
  const [top, bottom] = [list.scrollTop, list.scrollTop + list.clientHeight];
  const seen = rows.filter(({ row }) => {
    const above = row.offsetTop - list.offsetTop;
    return above <= bottom && above + row.offsetHeight >= top;
  });
  const scale = across / (to - from);
  const x = (/** @type {number} */ time) => (time - from) * scale;
  const lines = timeLines(from, to, across);
  for (const one of seen) {
    const [{ kind }] = one.signals;
    const height = kind === "panel" ? Math.max(PANEL, LANE * (one.signals.length + 1)) : LANE;
    attribute(one.plot, "width", across);
    attribute(one.plot, "height", height);
    const grid = svg("path.grid", { d: lines.map((time) => `M${fixed(x(time))} 0V${height}`).join("") });
    if (kind === "panel") fill(one.plot, grid, panel(one, x, height, across));
    else fill(one.plot, grid, lane(one.signals[0], { from, to, step, x, near: NEAR / (scale * step) }));
    one.plot.append(...held(one, x, step, height), ...different(one, x, step, height));
  }
  drawAxis(lines, x, across, to - from);
  text(hint, store.isLive() && (store.state?.calls ?? 0) > 0 ? "" : "Run, and set the inputs on the left.");
  placeCursor(across, right);
  showValues();
  const comparison = compared();
  text(verdict, comparison ? comparedText(comparison, timeOf) : "");
  attribute(verdict, "title", verdict.textContent || undefined);
  verdict.classList.toggle("is-different", (comparison?.first.size ?? 0) > 0);
  again.hidden = !hasRun(store.loop);
}

/**
 * Bars below signals in the calls in which they were forced.
 *
 * @param {Row} row
 * @param {(time: number) => number} x
 * @param {number} step
 * @param {number} height
 */
function held({ signals }, x, step, height) {
  const end = lastCall() + 1;
  return signals.flatMap(({ name }) =>
    forcedSpans(name).map(([first, last]) => {
      const [left, right] = [first, Math.min(last, end)].map((call) => fixed(x(timeOf(0) + call * step)));
      return svg("path.held", { d: `M${left} ${height - 2}H${Math.max(right, left)}` });
    }),
  );
}

/**
 * Marks for the calls in which a signal differs between a repeated run and the earlier one; for an analog value, only
 * the first such call is marked.
 *
 * @param {Row} row
 * @param {(time: number) => number} x
 * @param {number} step
 * @param {number} height
 */
function different({ signals }, x, step, height) {
  const { first, calls = 0 } = compared() ?? {};
  const place = (/** @type {number} */ call) => fixed(x(timeOf(0) + call * step));
  return signals.flatMap(({ name, kind }) => {
    const at = first?.get(name);
    if (at === undefined) return [];
    if (kind === "panel") return [svg("path.differs", { d: `M${place(at)} 0V${height}` })];
    const [one, other] = [known.get(name), before.get(name)];
    if (!one || !other) return [];
    const ends = [...new Set([...one.calls, ...other.calls, calls])]
      .filter((call) => call <= calls)
      .sort((a, b) => a - b);
    let marks = "";
    for (const [place_, call] of ends.entries()) {
      const isSame = Object.is(one.values[placeOf(one, call)], other.values[placeOf(other, call)]);
      const next = ends[place_ + 1];
      if (!isSame && next !== undefined) marks += `M${place(call)} 1H${Math.max(place(next), place(call) + 1)}`;
    }
    return marks ? [svg("path.differs", { d: marks })] : [];
  });
}

/** @param {number} from @param {number} to @param {number} across */
function timeLines(from, to, across) {
  const step = TIME_STEPS.find((one) => one >= ((to - from) * 80) / across) ?? to - from;
  const first = Math.ceil(from / step - 1e-9);
  return Array.from({ length: Math.max(Math.floor(to / step + 1e-9) - first + 1, 0) }, (_, at) => (first + at) * step);
}

/** @param {number[]} lines @param {(time: number) => number} x @param {number} across @param {number} length */
function drawAxis(lines, x, across, length) {
  attribute(axis, "width", across);
  attribute(axis, "height", LANE);
  const unit = timeUnit(length);
  // The unit is at the end of the axis: leave out numbers that would overlap it.
  const numbers = lines.filter((time) => x(time) < across - unit.length * LETTER - 2 * LETTER);
  const written = numbers.map((time, at) =>
    svg(
      "text.axis",
      { x: fixed(x(time)), y: 14, "text-anchor": at === 0 && x(time) < 8 ? "start" : "middle" },
      clock(time, length),
    ),
  );
  fill(axis, written, svg("text.axis", { x: across - 2, y: 14, "text-anchor": "end" }, unit));
}

/**
 * Draws a Boolean or a step, with edges exactly at their calls.
 *
 * @param {Shown} signal
 * @param {{ from: number, to: number, step: number, x: (time: number) => number, near: number }} view
 */
function lane(signal, { from, to, step, x, near }) {
  const track = known.get(signal.name);
  if (!track || track.until === 0) return [];
  const begin = timeOf(0);
  const of = parts(track, Math.max(Math.floor((from - begin) / step), 0), Math.ceil((to - begin) / step) + 1, near);
  let [stroke, high, dense, frames] = ["", "", "", ""];
  /** @type {SVGElement[]} */
  const texts = [];
  let isDown = false;
  for (const { from: first, to: end, value, changes } of of) {
    const [left, right] = [fixed(x(begin + first * step)), fixed(x(begin + end * step))];
    if (changes > 0) {
      dense += `M${left} ${HIGH}H${right}V${LOW}H${left}Z`;
      texts.push(...label([`${changes} changes`, String(changes)], left, right));
      isDown = false;
    } else if (signal.kind === "band") {
      frames += `M${left} ${HIGH - 2}H${right}V${LOW + 2}H${left}Z`;
      const number = valueText(value, signal, false);
      texts.push(...label([valueText(value, signal), number], left, right));
    } else {
      const y = value === 1 ? HIGH : LOW;
      stroke += `${isDown ? "V" : `M${left} `}${y}H${right}`;
      if (value === 1) high += `M${left} ${HIGH}H${right}V${LOW}H${left}Z`;
      isDown = true;
    }
  }
  const path = (/** @type {string} */ look, /** @type {string} */ d) => (d ? svg("path", { class: look, d }) : null);
  return [path("high", high), path("dense", dense), path("frames", frames), path("stroke", stroke), ...texts];
}

/**
 * The first of several texts, longest first, that fits between two positions.
 *
 * @param {string[]} choices
 * @param {number} left
 * @param {number} right
 */
function label(choices, left, right) {
  const from = Math.max(left, 0);
  const room = right - from - ROOM;
  const fits = choices.find((one) => one.length * LETTER <= room);
  return fits ? [svg("text", { x: fixed(from + ROOM / 2), y: 15 }, fits)] : [];
}

/**
 * Draws the analog values of one unit, with a numbered grid.
 *
 * @param {Row} row
 * @param {(time: number) => number} x
 * @param {number} height
 * @param {number} across
 */
function panel({ signals }, x, height, across) {
  const { curves: palette } = theme();
  const of = signals.flatMap((one) => {
    const values = curves?.values[names.indexOf(one.name)];
    return values ? [{ ...one, values }] : [];
  });
  let [low, high] = [Infinity, -Infinity];
  for (const { values } of of)
    for (const value of values) if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (!curves || low > high) return [];
  if (high - low < 1e-9 * Math.max(Math.abs(high), 1)) [low, high] = [low - 1, high + 1];
  const [bottom, top, choices] = numberings(low, high, 3);
  const y = (/** @type {number} */ value) => MARGIN + ((top - value) / (top - bottom)) * (height - 2 * MARGIN);
  const { times, is_exact: isExact } = curves;
  const lines = of.map(({ name, values, isStepped, colour, isDashed }) => {
    const at = isLate(name) ? times.map((time) => time - (store.state?.step ?? 0)) : times;
    const { stroke, fill } = outline(at, values, { isExact, isStepped }, x, y);
    const dash = isDashed ? { "stroke-dasharray": "5 3" } : {};
    const style = `color: ${palette[colour % palette.length]}`;
    return svg("g", { style }, svg("path.area", { d: fill }), svg("path.curve", { d: stroke, ...dash }));
  });
  const marks = choices[0].filter((value) => y(value) >= MARGIN - 1 && y(value) <= height - MARGIN + 1);
  const grid = marks.map((value) => `M0 ${fixed(y(value))}H${across}`).join("");
  const written = ticks(marks).map((number, at) =>
    svg("text.axis", { x: 2, y: fixed(y(marks[at]) + 4) }, number ?? ""),
  );
  return [svg("path.grid", { d: grid }), ...lines, ...written];
}

/** @param {number} value */
function fixed(value) {
  return Math.round(value * 10) / 10;
}

/** @param {number} across width of the pictures @param {number} right x coordinate of their right edge */
function placeCursor(across, right) {
  const time = cursorTime();
  const [from, to] = range();
  const at = time === undefined ? Number.NaN : ((time - from) / (to - from)) * across;
  line.hidden = !(at >= 0 && at <= across);
  if (!line.hidden) line.style.left = `${right - across + at}px`;
  text(badge, momentText());
  badge.hidden = badge.textContent === "";
  const shown = time ?? (store.isLive() ? (store.state?.time ?? 0) : 0);
  attribute(slider, "aria-valuemax", timeOf(lastCall()));
  attribute(slider, "aria-valuenow", shown);
}

/** Shows the values at the cursor, or now. */
function showValues() {
  if (!isShown()) return;
  const values = momentValues();
  const spoken = [];
  for (const { signals, values: places } of rows) {
    for (const [at, signal] of signals.entries()) {
      const value = values[signal.name];
      const shown = value === undefined ? "" : valueText(value, signal);
      text(places[at], shown);
      attribute(places[at], "title", shown || undefined);
      const look = signal.kind === "lane" ? (value === true ? "is-true" : "is-false") : "";
      attribute(places[at], "class", `value number ${shown ? look : ""}`);
      const row = places[at].parentElement;
      row?.classList.toggle("is-forced", isForced(signal.name));
      row?.classList.toggle("is-different", compared()?.first.has(signal.name) === true);
      if (shown) spoken.push(`${signal.label} ${shown}`);
    }
  }
  attribute(slider, "aria-valuetext", [momentText() || "now", ...spoken].join("; "));
}

/** The time at the pointer; `undefined` if it is not over the pictures. @param {PointerEvent | MouseEvent} event */
function pointed(event) {
  const left = list.getBoundingClientRect().left + list.clientWidth - width();
  const across = event.clientX - left;
  if (across < 0 || across > width()) return undefined;
  const [from, to] = range();
  return from + (across / width()) * (to - from);
}

/** Handles the pointer: moving it moves the cursor, dragging zooms, and a click pins the cursor. */
function point() {
  /** Where a drag began. @type {{ x: number, time: number, cursor: number | undefined } | undefined} */
  let drag;
  const at = (/** @type {number} */ time) => lookAt(lastCall() > 0 ? timeOf(callAt(time)) : undefined);
  diagram.addEventListener("pointermove", (event) => {
    const time = pointed(event);
    if (drag && Math.abs(event.clientX - drag.x) > DRAG) {
      const [begin, end] = [drag.x, event.clientX].sort((one, other) => one - other);
      selection.hidden = false;
      Object.assign(selection.style, {
        left: `${begin - diagram.getBoundingClientRect().left}px`,
        width: `${end - begin}px`,
      });
    }
    if (time !== undefined && event.pointerType === "mouse" && (isPointed || cursorTime() === undefined)) {
      isPointed = true;
      at(time);
    }
  });
  diagram.addEventListener("pointerleave", () => {
    if (isPointed) lookAt(undefined);
    isPointed = false;
  });
  diagram.addEventListener("pointerdown", (event) => {
    const time = pointed(event);
    if (event.button !== 0 || time === undefined) return;
    drag = { x: event.clientX, time, cursor: isPointed ? undefined : cursorTime() };
  });
  diagram.addEventListener("pointercancel", () => {
    drag = undefined;
    selection.hidden = true;
  });
  addEventListener("pointerup", (event) => {
    if (!drag) return;
    const { x, time, cursor } = drag;
    drag = undefined;
    const isDragged = !selection.hidden;
    selection.hidden = true;
    const end = pointed(event) ?? time;
    if (isDragged) zoom(Math.min(time, end), Math.max(time, end));
    else if (Math.abs(event.clientX - x) <= DRAG) {
      // A click at the pinned cursor removes it.
      isPointed = false;
      const call = timeOf(callAt(time));
      if (cursor === call) lookAt(undefined);
      else at(time);
    }
  });
  diagram.addEventListener("dblclick", () => follow());
  list.addEventListener("scroll", refresh);
}

/** @param {KeyboardEvent} event */
function key(event) {
  const far = event.shiftKey ? 10 : 1;
  press(event, {
    ArrowLeft: () => move(-far),
    ArrowRight: () => move(far),
    ArrowDown: () => list.scrollBy(0, LANE),
    ArrowUp: () => list.scrollBy(0, -LANE),
    PageDown: () => toChange(1),
    PageUp: () => toChange(-1),
    Home: () => lookAt(timeOf(0)),
    End: () => lookAt(timeOf(lastCall())),
    "+": () => zoomBy(0.5),
    "-": () => zoomBy(2),
    Escape: () => follow(),
  });
}

/** The call at the cursor, or the last one. */
function here() {
  const time = cursorTime();
  return time === undefined ? lastCall() : callAt(time);
}

/** Moves the cursor by a number of calls. @param {number} by */
function move(by) {
  isPointed = false;
  lookAt(timeOf(Math.min(Math.max(here() + by, 0), lastCall())));
  bringIntoSight();
}

/** Moves the cursor to the next or the previous call in which a Boolean or a step changes. @param {1 | -1} way */
function toChange(way) {
  const now = here();
  const found = rows.flatMap(({ signals: [{ name }] }) => {
    const track = known.get(name);
    if (!track) return [];
    const at = placeOf(track, way > 0 ? now : now - 1);
    return track.calls[way > 0 ? at + 1 : at] ?? [];
  });
  isPointed = false;
  if (found.length > 0) lookAt(timeOf(way > 0 ? Math.min(...found) : Math.max(...found)));
  bringIntoSight();
}

/** Moves the visible part so that it contains the cursor. */
function bringIntoSight() {
  const [from, to] = range();
  const time = cursorTime();
  if (time === undefined || (time >= from && time <= to)) return;
  const half = (to - from) / 2;
  zoom(Math.max(time - half, 0), Math.max(time - half, 0) + 2 * half);
}
