/**
 * Charts: what all of them share, and a small one for panels.
 *
 * @typedef {object} Line
 * @property {string} name
 * @property {(number | null)[]} values
 * @property {string} [unit]
 * @property {"left" | "right"} [side]
 * @property {number} [colour] its place in the palette
 * @property {boolean} [isDashed]
 * @property {boolean} [isStepped] whether a value holds until the next
 *
 * @typedef {object} Drawing
 * @property {string} title what a screen reader says of it
 * @property {string} xLabel
 * @property {number[]} x ascending
 * @property {Line[]} lines
 * @property {number} [height] in CSS pixels
 */

import { element, fill } from "tool/dom.js";

/** The font of axes and labels. */
export const FONT = "11px system-ui, 'Segoe UI', Helvetica, Arial, sans-serif";

/** After Okabe and Ito, a little darker on white, so that thin lines can be told from the paper. */
const LIGHT = ["#00785a", "#0062a3", "#c14d00", "#a34d82", "#8a6100", "#5a3fa6", "#4b5563", "#a11d33"];
const DARK = ["#1fbf94", "#56b4e9", "#ee7a2b", "#e08fc0", "#e6b13c", "#b3a1f5", "#c3cad6", "#ff8f98"];

const dark = matchMedia("(prefers-color-scheme: dark)");

/** The colours of charts as the page is shown now. */
export function theme() {
  const style = getComputedStyle(document.documentElement);
  /** @param {string} name */
  const colour = (name) => style.getPropertyValue(name).trim();
  return {
    curves: dark.matches ? DARK : LIGHT,
    ink: colour("--ink"),
    faint: colour("--faint"),
    paper: colour("--paper"),
    grid: dark.matches ? "#262d38" : "#e7eaee",
    earlier: dark.matches ? "#6b7686" : "#9aa4b2",
  };
}

/** @param {() => void} listener called when the colours are others */
export function onTheme(listener) {
  dark.addEventListener("change", listener);
}

/**
 * A short number for an axis or a label: 4 digits, no noise of binary fractions.
 *
 * @param {number} value
 */
export function short(value) {
  return String(Number(value.toPrecision(4)));
}

/**
 * Seconds as people write a time on an axis: 12.5 s, 3:20 min.
 *
 * @param {number} seconds
 * @param {boolean} inMinutes
 */
export function clock(seconds, inMinutes) {
  if (!inMinutes) return String(Number(seconds.toFixed(6)));
  const whole = Math.round(Math.abs(seconds));
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const end = `${String(minutes).padStart(hours ? 2 : 1, "0")}:${String(rest).padStart(2, "0")}`;
  return `${seconds < 0 ? "-" : ""}${hours ? `${hours}:` : ""}${end}`;
}

/** Steps between two marks of a time axis: 1, 2, 5 and then what divides minutes and hours. */
export const TIME_STEPS = [
  ...[
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200,
  ],
  ...[14400, 21600, 43200, 86400, 172800, 604800],
];

/**
 * An axis of uPlot in the page's colours.
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
    label: (self) => ((self.scales.x.max ?? 0) - (self.scales.x.min ?? 0) > 600 ? "min:s" : "s"),
    values: (self, splits) => {
      const long = (self.scales.x.max ?? 0) - (self.scales.x.min ?? 0) > 600;
      return splits.map((split) => clock(split, long));
    },
    ...options,
  });
}

/**
 * How a value axis is ranged: as the data, with some room; percent keeps 0 to 100 as long as nothing lies outside.
 *
 * @param {string} unit
 * @param {() => [number, number]} [more] what else is to be seen, such as earlier runs
 * @returns {uPlot.Range.Function}
 */
export function ranged(unit, more = () => [Infinity, -Infinity]) {
  return (_self, low, high) => {
    const [least, most] = more();
    let from = Math.min(low ?? Infinity, least);
    let to = Math.max(high ?? -Infinity, most);
    if (from > to) [from, to] = [0, unit === "%" ? 100 : 1];
    if (unit === "%" && from >= 0 && to <= 100) return [-4, 104];
    // A constant value lies in the middle, and what is only round-off looks constant.
    const least_span = Math.max(Math.abs(from), Math.abs(to), 1e-6) * 1e-4;
    if (to - from < least_span) {
      const room = Math.max(Math.abs(from) * 0.05, 0.5);
      return [from - room, to + room];
    }
    return uPlot.rangeNum(from, to, 0.08, true);
  };
}

/**
 * A piece of a line, for a legend.
 *
 * @param {string} colour
 * @param {boolean} [isDashed]
 */
export function swatch(colour, isDashed = false) {
  const made = element("i", { class: "swatch" });
  made.style.borderTop = `3px ${isDashed ? "dashed" : "solid"} ${colour}`;
  return made;
}

/**
 * A small chart within an element, as wide as that. Its lines are told apart by the legend, which is text.
 *
 * @param {HTMLElement} within
 * @param {Drawing} drawing
 * @returns {() => void} ends it
 */
export function draw(within, drawing) {
  /** @type {uPlot | undefined} */
  let plot;
  const place = element("div", { role: "img", "aria-label": drawing.title, class: "small-chart" });
  const legend = element("p", { class: "chart-legend" });
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
        scales: {
          x: { time: false },
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
        axes: [
          axis({ label: drawing.xLabel, size: 20, labelSize: 15, space: 50, values: (_, splits) => splits.map(short) }),
          ...sides.map((side) =>
            axis({
              ...{ scale: side, side: side === "left" ? 3 : 1, label: unit(side) },
              ...{ size: 42, values: (/** @type {uPlot} */ _, /** @type {number[]} */ splits) => splits.map(short) },
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
          {},
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
