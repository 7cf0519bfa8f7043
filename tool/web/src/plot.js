/**
 * Draws a run with uPlot: curves with one axis per unit, Booleans in lanes below them on the same time axis, overlays
 * behind them, and marks for events.
 *
 * @typedef {import("tool/curves.js").Curve} Curve
 * @typedef {import("tool/overlay.js").Overlay} Overlay
 *
 * @typedef {object} Mark an event
 * @property {number} time
 * @property {string} text
 *
 * @typedef {object} Parts data that is queried each time the picture is drawn
 * @property {() => [number, number]} range time range
 * @property {() => boolean} isEmpty whether there is no value yet
 * @property {() => boolean} isExact
 * @property {() => Overlay[]} behind
 * @property {() => Mark[]} marks
 * @property {uPlot.Hooks.Arrays} hooks
 */

import { axis, FONT, numberings, onLines, ranged, theme, ticks, timeAxis } from "tool/charts.js";
import { outline } from "tool/outline.js";
import { drawOverlays, extent } from "tool/overlay.js";

const LANE = 18;
const ROOM = 4;
/** The margin on the right if there is no axis: space for half of the last time label. */
const MARGIN = 20;
const [TOP, BOTTOM] = [18, 36];
const NARROW = 620;
/** The minimum spacing of grid lines, in pixels. */
const SPACE = 36;

/** The height of a Boolean's TRUE, as a fraction of its lane. */
const FULL = 0.68;

/**
 * @param {HTMLElement} place
 * @param {{ width: number, height: number }} size
 * @param {Curve[]} all the visible curves
 * @param {Parts} parts
 */
export function makePlot(place, { width, height }, all, parts) {
  const { curves: palette, grid } = theme();
  const units = [...new Set(all.flatMap(({ scale, isSwitch }) => (isSwitch || scale === "left" ? [] : [scale])))];
  // A narrow picture has space for one axis on the right, preferably that of the manipulated value.
  const first = units.includes("right") ? "right" : units[0];
  const right = units.filter((scale) => scale === first || width >= NARROW);
  // A curve whose axis does not fit uses the left axis.
  const curves = all.map((curve) =>
    units.includes(curve.scale) && !right.includes(curve.scale) ? { ...curve, scale: "left" } : curve,
  );
  const numbers = curves.filter((curve) => !curve.isSwitch);
  const switches = curves.filter((curve) => curve.isSwitch);
  const inner = height - TOP - BOTTOM;
  const lanes = switches.length > 0 ? switches.length * LANE + ROOM : 0;
  // Extend each axis downwards, so that the curves stay above the lanes.
  const below = lanes / Math.max(inner - lanes, 1);
  /** The value on each axis at the upper edge of the lanes. @type {Record<string, number>} */
  const floors = {};
  /**
   * The numbers on each axis. Those of the right axes are at the grid lines of the left axis.
   *
   * @type {Record<string, number[]>}
   */
  const lines = {};
  const scales = [...new Set(["left", ...numbers.map((curve) => curve.scale)])];
  /** The range of the left axis, without the lanes. @type {[number, number]} */
  let edges = [0, 1];
  /** @type {number[][]} */
  let choices = [];
  /** @param {string} scale */
  const range = (scale) => {
    const unit = numbers.find((curve) => curve.scale === scale)?.unit ?? "";
    const of = ranged(unit, () => extent(parts.behind(), scale, parts.range()), scale === "left" ? 4 : 0);
    return (/** @type {uPlot} */ self, /** @type {number} */ low, /** @type {number} */ high) => {
      let [from, to] = /** @type {[number, number]} */ (of(self, low, high, scale));
      ends[scale] = isPercent(scale) && to <= 104 ? 100 : Infinity;
      if (scale === "left") {
        [from, to, choices] = numberings(from, to, (inner - lanes) / SPACE);
        lines.left = choices[0];
        edges = [from, to];
      } else {
        [from, to, lines[scale], lines.left] = onLines(choices, edges, from, to);
        choices = [lines.left];
      }
      floors[scale] = from;
      return /** @type {uPlot.Range.MinMax} */ ([from - (to - from) * below, to]);
    };
  };
  /** @param {string} scale */
  const isPercent = (scale) => numbers.find((curve) => curve.scale === scale)?.unit === "%";
  /** The highest number shown on each axis: 100 on a percent axis. @type {Record<string, number>} */
  const ends = {};
  /** @param {string} scale */
  const aboveLanes = (scale) => (/** @type {uPlot} */ _, /** @type {number[]} */ splits) =>
    splits.map((split) => (split < floors[scale] || split > (ends[scale] ?? Infinity) ? null : split));
  /** @param {string} scale @param {number} side */
  const valueAxis = (scale, side) => {
    const filter = aboveLanes(scale);
    const isLeft = scale === "left";
    return axis({
      ...{ scale, side, label: axisLabel(numbers, scale), filter, ticks: { show: false, filter } },
      grid: { show: isLeft, stroke: grid, width: 1, filter },
      splits: () => lines[scale] ?? [],
      // While there are no values, the numbers would be meaningless.
      values: (_, splits) => (parts.isEmpty() ? splits.map(() => "") : ticks(splits)),
      size: (_, values) => {
        const names = isLeft ? switches.map((curve) => lastName(curve).length) : [];
        return 14 + 6.5 * Math.max(3, ...names, ...(values ?? []).map((value) => String(value ?? "").length));
      },
    });
  };
  /** @param {number} at */
  const base = (at) => (ROOM / 2 + LANE * (switches.length - 1 - at)) / LANE + 0.12;
  const paths = (/** @type {uPlot} */ self, /** @type {number} */ at) => {
    const curve = curves[at - 1];
    const scale = self.series[at].scale ?? "left";
    const of = { isExact: parts.isExact(), isStepped: curve.isStepped || curve.isSwitch };
    const lane = curve.isSwitch ? { base: base(switches.indexOf(curve)) } : {};
    const made = outline(
      self.data[0],
      self.data[at],
      { ...of, ...lane },
      (time) => self.valToPos(time, "x", true),
      (value) => self.valToPos(value, scale, true),
    );
    return { stroke: new Path2D(made.stroke), fill: made.fill ? new Path2D(made.fill) : null };
  };
  const plot = new uPlot(
    {
      ...{ width, height, legend: { show: false }, padding: [TOP, right.length > 0 ? 0 : MARGIN, 0, 0] },
      cursor: {
        ...{ y: false, points: { show: false }, drag: { x: true, y: false, setScale: false } },
      },
      hooks: {
        ...parts.hooks,
        drawAxes: [(self) => drawOverlays(self, parts.behind())],
        draw: [(self) => drawMarks(self, parts.marks()), (self) => drawNames(self, switches, base)],
      },
      scales: {
        x: { time: false, range: () => parts.range() },
        lane: { range: () => [0, inner / LANE] },
        ...Object.fromEntries(scales.map((scale) => [scale, { range: range(scale) }])),
      },
      series: [
        {},
        ...curves.map((curve) => {
          const colour = palette[curve.colour % palette.length];
          return {
            ...{ label: curve.label, scale: curve.isSwitch ? "lane" : curve.scale, points: { show: false }, paths },
            ...{ stroke: colour, width: curve.isSwitch ? 1 : curve.colour === 1 ? 2 : 1.5 },
            dash: curve.isDashed ? [6, 4] : undefined,
            fill: `${colour}${curve.isSwitch ? "40" : "59"}`,
          };
        }),
      ],
      axes: [timeAxis(), valueAxis("left", 3), ...right.map((scale) => valueAxis(scale, 1))],
    },
    undefined,
    place,
  );
  return { plot, base };
}

/**
 * The values of a Boolean on the scale of the lanes.
 *
 * @param {(number | null)[]} values
 * @param {number} base
 */
export function laneValues(values, base) {
  return values.map((value) => (value === null ? null : base + FULL * value));
}

/**
 * @param {Curve[]} numbers
 * @param {string} scale
 */
function axisLabel(numbers, scale) {
  const there = numbers.filter((curve) => curve.scale === scale);
  const units = [...new Set(there.map((curve) => curve.unit))];
  const labels = units.map((unit) => {
    const names = there.filter((curve) => curve.unit === unit).map((curve) => curve.label);
    return `${names.join(", ")}${unit ? `  ${unit}` : ""}`;
  });
  return labels.join("; ");
}

/**
 * Draws the names of the lanes, aligned with the numbers of the left axis.
 *
 * @param {uPlot} self
 * @param {Curve[]} switches
 * @param {(at: number) => number} base
 */
function drawNames(self, switches, base) {
  const { ctx, bbox } = self;
  const { faint, grid } = theme();
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.font = scaled(FONT, ratio);
  ctx.textAlign = "right";
  ctx.textBaseline = "middle";
  switches.forEach((curve, at) => {
    const y = self.valToPos(base(at) + FULL / 2, "lane", true);
    ctx.fillStyle = faint;
    ctx.fillText(lastName(curve), bbox.left - 6 * ratio, y);
    ctx.fillStyle = grid;
    ctx.fillRect(bbox.left, self.valToPos(base(at), "lane", true), bbox.width, Math.max(1, ratio / 2));
  });
  ctx.restore();
}

/**
 * Draws the events: a line at each time, with its text at the top where it fits.
 *
 * @param {uPlot} self
 * @param {Mark[]} marks
 */
function drawMarks(self, marks) {
  const { ctx, bbox } = self;
  const { faint, mark } = theme();
  const ratio = uPlot.pxRatio;
  const [from, to] = [self.scales.x.min ?? 0, self.scales.x.max ?? 0];
  ctx.save();
  ctx.font = scaled(FONT, ratio);
  // Drawing the axes has changed the text alignment.
  ctx.textAlign = "left";
  ctx.textBaseline = "bottom";
  let free = bbox.left;
  const seen = marks.filter(({ time }) => time >= from && time <= to);
  const places = seen.map(({ time }) => Math.round(self.valToPos(time, "x", true)));
  for (const [at, { text }] of seen.entries()) {
    const x = places[at];
    ctx.strokeStyle = mark;
    ctx.lineWidth = ratio;
    ctx.setLineDash([2 * ratio, 3 * ratio]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillStyle = faint;
    ctx.beginPath();
    ctx.moveTo(x - 4 * ratio, bbox.top - 6 * ratio);
    ctx.lineTo(x + 4 * ratio, bbox.top - 6 * ratio);
    ctx.lineTo(x, bbox.top);
    ctx.fill();
    const wide = ctx.measureText(text).width;
    // The text must not reach the next mark. A mark at nearly the same place does not count.
    const next = places.find((other) => other > x + 8 * ratio);
    const end = next === undefined ? bbox.left + bbox.width : next - 4 * ratio;
    if (x + 6 * ratio < free || x + 6 * ratio + wide > end) continue;
    ctx.fillText(text, x + 6 * ratio, bbox.top - ratio);
    free = x + 6 * ratio + wide + 8 * ratio;
  }
  ctx.restore();
}

/** The name of a lane: without the path of inner blocks, and shortened. @param {Curve} curve */
function lastName(curve) {
  const name = curve.label.slice(curve.label.lastIndexOf(".") + 1);
  return name.length > 10 ? `${name.slice(0, 9)}…` : name;
}

/** @param {string} font @param {number} ratio */
function scaled(font, ratio) {
  return font.replace(/^\d+/, (size) => String(Number(size) * ratio));
}
