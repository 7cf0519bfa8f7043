/**
 * Shared parts of all charts, and a small chart used in panels.
 *
 * @typedef {object} Line
 * @property {string} name
 * @property {(number | null)[]} values
 * @property {string} [unit]
 * @property {"left" | "right"} [side]
 * @property {number} [colour] index in the palette
 * @property {boolean} [isDashed]
 * @property {boolean} [isStepped] whether each value holds until the next one
 *
 * @typedef {object} Drawing
 * @property {string} title read out by a screen reader
 * @property {string} xLabel
 * @property {number[]} x ascending
 * @property {Line[]} lines
 * @property {number} [height] in CSS pixels
 * @property {boolean} [isLogarithmic] whether the x axis is logarithmic
 * @property {Mark[]} [marks] straight lines over the curves of the left axis
 *
 * @typedef {object} Mark
 * @property {[number, number]} from
 * @property {[number, number]} to
 * @property {number} [colour] index in the palette; by default, the colour of an axis
 */

import { element, fill } from "tool/dom.js";

/** The font of axes and labels. */
export const FONT = "11px system-ui, 'Segoe UI', Helvetica, Arial, sans-serif";

/** Palette names of the colours for setpoint, process value and manipulated value, then for curves that the user adds. */
const CURVES = ["setpoint", "curve-1", "curve-2", ...[1, 2, 3, 4, 5].map((one) => `choice-${one}`)];
/** Palette names of the colours for compared runs. */
const RUNS = ["run-1", "run-2", "choice-1", "choice-2", "choice-5"];

const dark = matchMedia("(prefers-color-scheme: dark)");

/** The colours of a picture on white paper: the same as in the style sheet for a light page. */
const ON_PAPER = { ink: "#18212e", faint: "#566070", paper: "#ffffff" };

/**
 * The colours of the light (`false`) and the dark theme (`true`). They are cached because reading them makes the
 * browser recompute the style of the whole page.
 *
 * @type {Map<boolean, ReturnType<typeof themeNow>>}
 */
const themes = new Map();

/** The chart colours for the page's current theme. */
export function theme() {
  const known = themes.get(dark.matches) ?? themeNow();
  themes.set(dark.matches, known);
  return known;
}

function themeNow() {
  const style = getComputedStyle(document.documentElement);
  /** @param {string} name */
  const colour = (name) => style.getPropertyValue(name).trim();
  return { ...palette(dark.matches), ink: colour("--ink"), faint: colour("--faint"), paper: colour("--paper") };
}

/** The chart colours on white paper, whatever the theme of the page. */
export function paperTheme() {
  return { ...palette(false), ...ON_PAPER };
}

/**
 * The colours from the palette, which the style sheet, the charts and the printed pictures share.
 *
 * @param {boolean} isDark
 */
function palette(isDark) {
  const style = getComputedStyle(document.documentElement);
  const colour = (/** @type {string} */ name) =>
    style.getPropertyValue(`--${name}-${isDark ? "dark" : "light"}`).trim();
  return {
    curves: CURVES.map(colour),
    runs: RUNS.map(colour),
    grid: isDark ? "#262d38" : "#e9ecf0",
    mark: isDark ? "#4a5566" : "#c2c9d3",
  };
}

/** @param {() => void} listener called when the colours change */
export function onTheme(listener) {
  dark.addEventListener("change", listener);
}

/**
 * The labels of an axis's ticks, with just enough digits to tell them apart.
 *
 * @param {(number | null)[]} splits
 * @returns {(string | null)[]}
 */
export function ticks(splits) {
  const there = splits.filter((split) => split !== null);
  const step = there.length > 1 ? Math.abs(there[1] - there[0]) : Math.abs(there[0] ?? 1);
  const most = Math.max(...there.map(Math.abs));
  const isFar = most >= 1e6 || (most > 0 && most < 1e-4);
  const digits = Math.max(0, Math.ceil(Math.log10(most / step) - 1e-4) + 1);
  let decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  // A step of 0.0025 needs one digit more than a step of 0.002.
  for (let more = 0; more < 2 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 0.01; more += 1)
    decimals += 1;
  decimals = Math.min(decimals, 12);
  return splits.map((split) => {
    if (split === null) return null;
    if (split === 0) return "0";
    return isFar ? split.toExponential(Math.min(digits, 12)) : String(split.toFixed(decimals));
  });
}

/** Round steps between two numbers on an axis, within a decade. */
const STEPS = [1, 2, 2.5, 5];

/**
 * The ends of an axis, rounded if a round number is near, and the possible sets of round numbers on it, densest first.
 *
 * @param {number} from
 * @param {number} to
 * @param {number} most the maximum number of steps
 * @returns {[number, number, number[][]]}
 */
export function numberings(from, to, most) {
  const least = (to - from) / Math.max(most, 1);
  const wide = rounder(least).filter((step) => step >= least && step < 3 * least);
  const near = (/** @type {number} */ round, /** @type {number} */ end) =>
    Math.abs(round - end) < 0.06 * (to - from) ? round : end;
  const low = near(Math.floor(from / wide[0]) * wide[0], from);
  const high = near(Math.ceil(to / wide[0]) * wide[0], to);
  const numbers = wide.map((step) => {
    const first = Math.ceil(low / step - 1e-9);
    return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, at) => (first + at) * step);
  });
  return [low, high, numbers];
}

/**
 * Scales a second axis so that its ticks coincide with grid lines of the first axis and its curves get as much room as
 * possible. Returns the ends and the ticks of the second axis, and the ticks of the first.
 *
 * @param {number[][]} of the possible sets of numbers on the first axis
 * @param {[number, number]} edges of the first axis
 * @param {number} from start of the range that must be visible
 * @param {number} to its end
 */
export function onLines(of, [low, high], from, to) {
  /** @type {[number, number, number[], number[]]} */
  let best = [from, to, [], of[0] ?? []];
  let span = Infinity;
  for (const lines of of) {
    const between = lines[1] - lines[0];
    const [below, above] = [(lines[0] - low) / between, (high - lines[0]) / between];
    const fits = (/** @type {number} */ step) => {
      const first = Math.floor(from / step + below + 1e-9) * step;
      return { first, is: first + above * step >= to - 1e-9 * step };
    };
    const step = rounder((to - from) / (above + below)).find((one) => fits(one).is);
    if (step === undefined || (above + below) * step > 0.99 * span) continue;
    span = (above + below) * step;
    const { first } = fits(step);
    best = [first - below * step, first + above * step, lines.map((_, at) => first + at * step), lines];
  }
  return best;
}

/** Round steps in ascending order, from the decade of a length upwards. @param {number} length */
function rounder(length) {
  const decade = Math.floor(Math.log10(length));
  return [0, 1, 2].flatMap((more) => STEPS.map((one) => Number(`${one}e${decade + more}`)));
}

const DAY = 86400;
/** The lengths of the visible part, in seconds, above which times are written in minutes or in days. */
const [IN_MINUTES, IN_DAYS] = [600, 3 * DAY];

/**
 * Formats a time for an axis: `12.5` (seconds), `3:20` (minutes), `1:03:20` (hours), `4 d 12 h`.
 *
 * @param {number} seconds
 * @param {number} length of the visible part, in seconds
 */
export function clock(seconds, length) {
  if (length <= IN_MINUTES) return String(Number(seconds.toFixed(6)));
  if (length > IN_DAYS) {
    const hours = Math.round((seconds % DAY) / 3600);
    return `${Math.floor(seconds / DAY)} d${hours ? ` ${hours} h` : ""}`;
  }
  const whole = Math.round(Math.abs(seconds));
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const end = `${String(minutes).padStart(hours ? 2 : 1, "0")}:${String(rest).padStart(2, "0")}`;
  return `${seconds < 0 ? "-" : ""}${hours ? `${hours}:` : ""}${end}`;
}

/** Steps between two ticks of a time axis: 1, 2, 5, then divisors of minutes and hours, then days. */
export const TIME_STEPS = [
  ...[
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200,
  ],
  ...[14400, 21600, 43200],
  ...[1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000].map((days) => days * DAY),
];

/**
 * A uPlot axis in the page's colours.
 *
 * @param {uPlot.Axis} options
 * @returns {uPlot.Axis}
 */
export function axis(options) {
  const { faint, grid } = theme();
  return {
    ...{ font: FONT, labelFont: FONT, stroke: faint, gap: 3, size: 46, labelSize: 16, labelGap: 0 },
    ...{ grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, size: 4, width: 1 } },
    ...options,
  };
}

/**
 * A time axis.
 *
 * @param {uPlot.Axis} [options]
 * @returns {uPlot.Axis}
 */
export function timeAxis(options = {}) {
  return axis({
    size: 20,
    labelSize: 15,
    space: 62,
    incrs: TIME_STEPS,
    label: (self) => timeUnit((self.scales.x.max ?? 0) - (self.scales.x.min ?? 0)),
    values: (self, splits) => {
      const length = (self.scales.x.max ?? 0) - (self.scales.x.min ?? 0);
      return splits.map((split) => clock(split, length));
    },
    ...options,
  });
}

/** The unit of the numbers on a time axis. @param {number} length in seconds */
export function timeUnit(length) {
  if (length <= IN_MINUTES) return "s";
  return length > IN_DAYS ? "days" : length > 3600 ? "h:min:s" : "min:s";
}

/**
 * A range function for a value axis: the range of the data with a margin. A percent axis shows 0 to 100 unless a value
 * is outside.
 *
 * @param {string} unit
 * @param {() => [number, number]} [more] an additional range that must be visible, such as that of earlier runs
 * @param {number} [room] margin of a percent axis below 0 and above 100
 * @returns {uPlot.Range.Function}
 */
export function ranged(unit, more = () => [Infinity, -Infinity], room = 4) {
  return (_self, low, high) => {
    const [least, most] = more();
    let from = Math.min(low ?? Infinity, least);
    let to = Math.max(high ?? -Infinity, most);
    if (from > to) [from, to] = [0, unit === "%" ? 100 : 1];
    if (unit === "%" && from >= 0 && to <= 100) return [-room, 100 + room];
    // A constant value is drawn in the middle. A range that is mere round-off counts as constant.
    const least_span = Math.max(Math.abs(from), Math.abs(to), 1e-6) * 1e-4;
    if (to - from < least_span) {
      const room = Math.max(Math.abs(from) * 0.05, 0.5);
      return [from - room, to + room];
    }
    return uPlot.rangeNum(from, to, 0.08, true);
  };
}

/**
 * A short line segment for a legend.
 *
 * @param {string} colour
 * @param {boolean} [isDashed]
 */
export function swatch(colour, isDashed = false) {
  const made = element("i.swatch");
  made.style.borderTop = `3px ${isDashed ? "dashed" : "solid"} ${colour}`;
  return made;
}

/**
 * @param {uPlot} plot
 * @param {Mark[]} marks
 */
function drawMarks(plot, marks) {
  const { curves, faint } = theme();
  const { ctx } = plot;
  ctx.save();
  ctx.setLineDash([]);
  for (const { from, to, colour } of marks) {
    ctx.strokeStyle = colour === undefined ? faint : curves[colour];
    ctx.lineWidth = (colour === undefined ? 1 : 2.5) * devicePixelRatio;
    ctx.beginPath();
    for (const [x, y] of [from, to]) ctx.lineTo(plot.valToPos(x, "x", true), plot.valToPos(y, "left", true));
    ctx.stroke();
  }
  ctx.restore();
}

/**
 * Draws a small chart that fills the width of an element, with a text legend for its lines.
 *
 * @param {HTMLElement} within
 * @param {Drawing} drawing
 * @returns {() => void} removes the chart
 */
export function draw(within, drawing) {
  /** @type {uPlot | undefined} */
  let plot;
  const place = element("div.small-chart", { role: "img", "aria-label": drawing.title });
  const legend = element("p.chart-legend");
  fill(within, place, legend);

  const make = () => {
    plot?.destroy();
    const { curves, ink } = theme();
    /** @param {Line} line @param {number} at */
    const colour = (line, at) => curves[(line.colour ?? at) % curves.length];
    const sides = /** @type {("left" | "right")[]} */ (["left", "right"]).filter((side) =>
      drawing.lines.some((line) => (line.side ?? "left") === side),
    );
    /** @param {"left" | "right"} side */
    const unit = (side) => drawing.lines.find((line) => (line.side ?? "left") === side)?.unit ?? "";
    plot = new uPlot(
      {
        width: Math.max(within.clientWidth, 120),
        height: drawing.height ?? 170,
        legend: { show: false },
        cursor: { show: false },
        // Draw a slope as a line rather than as a staircase of pixels.
        pxAlign: 0,
        scales: {
          x: drawing.isLogarithmic ? { time: false, distr: 3, range: (_, low, high) => [low, high] } : { time: false },
          ...Object.fromEntries(sides.map((side) => [side, { range: ranged(unit(side)) }])),
        },
        series: [
          {},
          ...drawing.lines.map((line, at) => ({
            ...{ label: line.name, scale: line.side ?? "left", stroke: colour(line, at), width: 1.5 },
            ...{ dash: line.isDashed ? [6, 4] : undefined, points: { show: false } },
            paths: line.isStepped ? uPlot.paths.stepped?.({ align: 1 }) : undefined,
          })),
        ],
        hooks: { draw: [(self) => drawMarks(self, drawing.marks ?? [])] },
        axes: [
          axis({
            ...{ label: drawing.xLabel, size: 20, labelSize: 15, space: 50 },
            values: (_, splits) => (drawing.isLogarithmic ? splits.map((one) => one && String(one)) : ticks(splits)),
          }),
          ...sides.map((side) =>
            axis({
              ...{ scale: side, side: side === "left" ? 3 : 1, label: unit(side) },
              ...{ size: 42, values: (/** @type {uPlot} */ _, /** @type {number[]} */ splits) => ticks(splits) },
              grid: { show: side === sides[0], stroke: theme().grid, width: 1 },
            }),
          ),
        ],
      },
      /** @type {uPlot.AlignedData} */ ([drawing.x, ...drawing.lines.map((line) => line.values)]),
      place,
    );
    fill(
      legend,
      drawing.lines.map((line, at) =>
        element(
          "span",
          swatch(colour(line, at) ?? ink, line.isDashed),
          `${line.name}${line.unit ? ` in ${line.unit}` : ""}`,
        ),
      ),
    );
  };
  make();
  const watch = new ResizeObserver(() => {
    const width = Math.max(within.clientWidth, 120);
    if (plot && width !== plot.width) plot.setSize({ width, height: drawing.height ?? 170 });
  });
  watch.observe(within);
  dark.addEventListener("change", make);
  return () => {
    watch.disconnect();
    dark.removeEventListener("change", make);
    plot?.destroy();
    fill(within);
  };
}
