/**
 * The visible curves as a picture for export: an SVG with title, date and legend, and a PNG rendered from it.
 */

import { clock, FONT, paperTheme, ticks, timeUnit } from "tool/charts.js";
import { bringUpToDate, shownPicture } from "tool/curves.js";
import { outline } from "tool/outline.js";
import { store } from "tool/store.js";

/**
 * The sizes of pictures. Those for a report are smaller: a report is narrow, so they are scaled down less, and their
 * text stays legible.
 */
const SIZES = { alone: [1200, 640], report: [800, 560] };
const MARGINS = { left: 76, right: 76, top: 146, bottom: 48 };
/** The number of PNG pixels per pixel of the picture. */
const SCALE = 2;
const LANE = 0.68;
/**
 * The number of rows for the labels of marks, their spacing, the width of a letter, and the space for the count of
 * omitted labels.
 */
const [ROWS, LINE, LETTER, MORE] = [3, 15, 7.2, 26];

/** @param {unknown} text */
function escaped(text) {
  return String(text).replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
}

/**
 * The picture as SVG, in the colours for white paper.
 *
 * @param {{ isReport?: boolean, date?: Date }} [how] in a report, the picture omits trial and prediction
 * @returns {Promise<string | undefined>} `undefined` if there is no run
 */
export async function svgPicture({ isReport = false, date = new Date() } = {}) {
  await bringUpToDate();
  const { plot, view, curves, values, behind, runs, ghost, marks, base } = shownPicture(isReport);
  const [WIDTH, HEIGHT] = isReport ? SIZES.report : SIZES.alone;
  const loop = store.loop;
  if (!plot || !loop || view.times.length === 0) return undefined;
  const { curves: palette, runs: colours, ink, faint, paper, grid, mark } = paperTheme();
  const scales = plot.scales;
  const box = { left: MARGINS.left, top: MARGINS.top, right: WIDTH - MARGINS.right, bottom: HEIGHT - MARGINS.bottom };
  /** @param {number} value @param {string} scale */
  const part = (value, scale) => {
    const { min = 0, max = 1 } = scales[scale] ?? {};
    return (value - (min ?? 0)) / ((max ?? 1) - (min ?? 0) || 1);
  };
  /** @param {number} time */
  const x = (time) => box.left + part(time, "x") * (box.right - box.left);
  /** @param {string} scale */
  const y = (scale) => (/** @type {number} */ value) => box.bottom - part(value, scale) * (box.bottom - box.top);
  /** @param {string} content @param {number} across @param {number} up @param {string} [more] */
  const words = (content, across, up, more = "") =>
    `<text x="${across.toFixed(1)}" y="${up.toFixed(1)}" ${more}>${escaped(content)}</text>`;
  const parts = [];
  const date_ = `${date.toISOString().slice(0, 16).replace("T", " ")} UTC`;
  parts.push(
    words(`${loop.name}  ${loop.description.block}`, 24, 34, `class="title"`),
    words(date_, WIDTH - 24, 34, `text-anchor="end"`),
    words(plantOf(loop), 24, 54),
  );
  let [across, down] = [24, 78];
  /** @param {string} name @param {string} colour @param {boolean} isDashed */
  const entry = (name, colour, isDashed) => {
    const dash = isDashed ? ` stroke-dasharray="5 3"` : "";
    const wide = 50 + name.length * LETTER;
    if (across > 24 && across + wide > WIDTH) [across, down] = [24, down + 16];
    parts.push(
      `<path d="M${across} ${down}h20" stroke="${colour}" stroke-width="3"${dash}/>`,
      words(name, across + 26, down + 4),
    );
    across += wide;
  };
  for (const curve of curves) {
    const name = `${curve.label}${curve.unit ? ` in ${curve.unit}` : ""}`;
    entry(name, palette[curve.colour % palette.length], curve.isDashed === true);
  }
  for (const { name, colour } of runs) entry(name, colours[colour % colours.length], false);
  if (ghost) entry(ghost, palette[1], true);
  const axes = plot.axes.map((axis) => /** @type {any} */ (axis));
  const length = (scales.x.max ?? 0) - (scales.x.min ?? 0);
  for (const split of axes[0]._splits ?? []) {
    parts.push(
      `<path d="M${x(split).toFixed(1)} ${box.top}V${box.bottom}" stroke="${grid}"/>`,
      words(clock(split, length), x(split), box.bottom + 18, `text-anchor="middle"`),
    );
  }
  parts.push(words(timeUnit(length), (box.left + box.right) / 2, box.bottom + 36, `text-anchor="middle"`));
  axes.slice(1).forEach((axis, at) => {
    const floor = at === 0 ? box.bottom : Infinity;
    const shown = /** @type {(number | null)[]} */ (axis.filter(plot, axis._splits ?? []));
    const place = y(axis.scale);
    const edge = at === 0 ? box.left - 8 : box.right + 8 + (at - 1) * 60;
    ticks(shown).forEach((text, number) => {
      const value = shown[number];
      if (text === null || value === null) return;
      if (floor !== Infinity)
        parts.push(`<path d="M${box.left} ${place(value).toFixed(1)}H${box.right}" stroke="${grid}"/>`);
      parts.push(words(text, edge, place(value) + 4, `text-anchor="${at === 0 ? "end" : "start"}"`));
    });
    const label = typeof axis.label === "function" ? axis.label(plot, at + 1) : axis.label;
    const middle = (box.top + box.bottom) / 2;
    const beside = at === 0 ? 18 : edge + 50;
    parts.push(words(label ?? "", beside, middle, `text-anchor="middle" transform="rotate(-90 ${beside} ${middle})"`));
  });
  const seen = marks.filter(({ time }) => time >= (scales.x.min ?? 0) && time <= (scales.x.max ?? 0));
  for (const { time, text, row, isLeft } of placed(seen, x, WIDTH)) {
    const across = x(time).toFixed(1);
    const up = box.top - 4 - row * LINE;
    parts.push(`<path d="M${across} ${box.top}V${box.bottom}" stroke="${mark}" stroke-dasharray="2 3"/>`);
    if (text)
      parts.push(
        `<path d="M${across} ${up}V${box.top}" stroke="${mark}"/>`,
        words(text, x(time) + (isLeft ? -3 : 3), up, isLeft ? `text-anchor="end"` : ""),
      );
  }
  /** @param {ReturnType<typeof outline>} shape @param {string} colour @param {string} more */
  const drawn = ({ stroke, fill }, colour, more) => {
    if (fill) parts.push(`<path d="${fill}" fill="${colour}" fill-opacity="0.3" clip-path="url(#area)"/>`);
    parts.push(`<path d="${stroke}" stroke="${colour}" ${more} clip-path="url(#area)"/>`);
  };
  for (const one of behind) {
    const dash = one.dash.length > 0 ? `stroke-dasharray="${one.dash.join(" ")}"` : "";
    drawn(outline(one.times, one.values, one.how, x, y(one.scale)), one.colour, dash);
  }
  const switches = curves.filter((curve) => curve.isSwitch);
  curves.forEach((curve, at) => {
    const colour = palette[curve.colour % palette.length];
    const how = { isExact: view.is_exact, isStepped: curve.isStepped || curve.isSwitch };
    if (!curve.isSwitch) {
      const dash = curve.isDashed ? ` stroke-dasharray="6 4"` : "";
      drawn(outline(view.times, values[at], how, x, y(curve.scale)), colour, `stroke-width="1.8"${dash}`);
      return;
    }
    const ground = base(switches.indexOf(curve));
    const rows = values[at].map((value) => (value === null ? null : ground + LANE * value));
    drawn(outline(view.times, rows, { ...how, base: ground }, x, y("lane")), colour, "");
    const middle = y("lane")(ground + LANE / 2) + 4;
    for (const [value, from, to] of stretches(view.times, values[at])) {
      const word = value === 0 ? "FALSE" : "TRUE";
      const left = Math.max(x(from), box.left) + 4;
      if (left + word.length * LETTER < Math.min(x(to), box.right)) parts.push(words(word, left, middle));
    }
    parts.push(words(curve.label, box.left - 8, middle, `text-anchor="end"`));
  });
  const area = `<clipPath id="area"><rect x="${box.left}" y="${box.top}" width="${box.right - box.left}" height="${box.bottom - box.top}"/></clipPath>`;
  const style = `text{font:${FONT.replace("11px", "13px")};fill:${faint}}.title{font-weight:600;font-size:18px;fill:${ink}}path:not([fill]){fill:none;stroke-linejoin:round}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" width="${WIDTH}" height="${HEIGHT}"><style>${style}</style><defs>${area}</defs><rect width="${WIDTH}" height="${HEIGHT}" fill="${paper}"/>${parts.join("\n")}</svg>`;
}

/**
 * Places the labels of marks in rows, so that they do not overlap. Labels for which there is no space are counted at
 * the label before them.
 *
 * @param {{ time: number, text: string }[]} marks ascending
 * @param {(time: number) => number} x
 * @param {number} width of the picture
 */
function placed(marks, x, width) {
  const free = Array.from({ length: ROWS }, () => 0);
  /** @type {{ time: number, text: string, row: number, isLeft: boolean, more: number }[]} */
  const made = [];
  for (const { time, text } of marks) {
    const wide = text.length * LETTER + 8;
    const isLeft = x(time) + wide > width;
    const from = isLeft ? x(time) - wide : x(time);
    const row = free.findIndex((end) => end <= from);
    const before = made.findLast((one) => one.text !== "");
    if (row < 0 && before) before.more += 1;
    else free[row] = from + wide + MORE;
    made.push({ time, text: row < 0 ? "" : text, row: Math.max(row, 0), isLeft, more: 0 });
  }
  return made.map((one) => ({ ...one, text: one.more > 0 ? `${one.text} +${one.more}` : one.text }));
}

/**
 * The periods in which a Boolean keeps its value.
 *
 * @param {number[]} times
 * @param {(number | null)[]} values
 * @returns {[number, number, number][]} value, start time and end time
 */
function stretches(times, values) {
  /** @type {[number, number, number][]} */
  const found = [];
  values.forEach((value, at) => {
    const last = found.at(-1);
    if (last) last[2] = times[at];
    if (value !== null && value !== last?.[0]) found.push([value, times[at], times[at]]);
  });
  return found;
}

/** @param {import("tool/store.js").Work} loop */
function plantOf(loop) {
  const members = loop.members.map((member) => member.fmu).join(", ");
  return [loop.file && `from ${loop.file}`, members && `plant: ${members}`].filter(Boolean).join(", ");
}

/** The picture as PNG. @returns {Promise<Blob | undefined>} `undefined` if there is no run */
export async function pngPicture() {
  const svg = await svgPicture();
  if (!svg) return undefined;
  const image = new Image();
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  image.src = address;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = SIZES.alone.map((length) => length * SCALE);
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  URL.revokeObjectURL(address);
  return new Promise((done) => canvas.toBlob((content) => done(content ?? undefined), "image/png"));
}
