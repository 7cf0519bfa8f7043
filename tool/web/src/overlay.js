/**
 * The curves drawn behind the current run: earlier runs in their own colours, and, dashed, the prediction and the trial
 * of edited values. Also copies displayed values with all digits.
 *
 * @typedef {import("tool/curves.js").Curve} Curve
 * @typedef {import("./messages").Curves} View
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Overlay
 * @property {string} scale the axis
 * @property {number[]} times
 * @property {(number | null)[]} values
 * @property {string} colour
 * @property {number[]} dash
 * @property {import("tool/outline.js").How} how
 *
 * @typedef {object} Origin state of the loop before a predicted step
 * @property {number} time of the call with the new setpoint, in seconds
 * @property {number} processValue process value before the step; NaN to draw the prediction at its computed level
 * @property {number} manipulatedValue
 */

import { theme } from "tool/charts.js";
import { outline } from "tool/outline.js";
import { roles } from "tool/signals.js";
import { store } from "tool/store.js";

/** The names of the variables drawn for earlier runs and trials, in the order of their values. @param {Work} loop */
export function drawnOfEarlier(loop) {
  const { processValue, manipulatedValue } = roles(loop);
  return [processValue, manipulatedValue].filter((name) => name !== undefined);
}

/**
 * Hides the values at time 0 in a run with parallel exchange: they are outputs from before the first call, not a state
 * of the loop.
 *
 * @param {number[]} times
 * @param {(number | null)[]} values
 */
export function ofCalls(times, values) {
  const isBefore = store.loop?.exchange === "parallel" && times[0] === 0;
  return isBefore ? values.map((value, at) => (times[at] === 0 ? null : value)) : values;
}

/**
 * The curves drawn behind the run.
 *
 * @param {Work} loop
 * @param {Curve[]} visible
 * @param {{ view: View, colour: number }[]} earlier
 * @param {ReturnType<typeof theme>} [colours]
 * @param {boolean} [isRunOnly] whether to omit trial and prediction
 * @returns {Overlay[]}
 */
export function overlays(loop, visible, earlier, { curves: palette, runs } = theme(), isRunOnly = false) {
  const { setpoint, processValue, manipulatedValue } = roles(loop);
  /** @param {string | undefined} name */
  const shown = (name) => visible.find((curve) => curve.name === name);
  /** @type {Overlay[]} */
  const made = [];
  for (const { view, colour } of earlier) {
    drawnOfEarlier(loop).forEach((name, at) => {
      const curve = shown(name);
      if (!curve) return;
      const how = { isExact: view.is_exact, isStepped: curve.isStepped };
      const ink = runs[colour % runs.length];
      const of = { times: view.times, values: ofCalls(view.times, view.values[at] ?? []), dash: [], how };
      // The first curve has the run's colour; the manipulated value has a lighter shade of it.
      made.push({ scale: curve.scale, colour: at === 0 ? ink : `${ink}99`, ...of });
    });
  }
  if (isRunOnly) return made;
  if (store.ghost) {
    const { times, values, is_exact: isExact } = store.ghost.curves;
    drawnOfEarlier(loop).forEach((name, at) => {
      const curve = shown(name);
      if (!curve) return;
      const colour = palette[curve.colour % palette.length];
      const how = { isExact, isStepped: curve.isStepped };
      made.push({ scale: curve.scale, times, values: ofCalls(times, values[at] ?? []), colour, dash: [6, 4], how });
    });
  }
  if (!store.prediction) return made;
  const { origin, curves: prediction } = store.prediction;
  // Align the predicted step with the step of the run, and draw only one call before it.
  const step = Math.max(
    prediction.setpoint.findIndex((value) => value !== prediction.setpoint[0]),
    0,
  );
  const after = (/** @type {number[]} */ values) => values.slice(Math.max(step - 1, 0));
  const times = after(prediction.times).map((time) => time - prediction.times[step] + origin.time);
  const [goal, answer, moves] = [prediction.setpoint, prediction.process_value, prediction.manipulated_value].map(
    after,
  );
  const level = Number.isNaN(origin.processValue) ? 0 : origin.processValue - (answer[0] ?? 0);
  const push = Number.isNaN(origin.manipulatedValue) ? 0 : origin.manipulatedValue - (moves[0] ?? 0);
  for (const [name, values, by] of /** @type {[string | undefined, number[], number][]} */ ([
    [setpoint, goal, level],
    [processValue, answer, level],
    [manipulatedValue, moves, push],
  ])) {
    const curve = shown(name);
    if (!curve) continue;
    const colour = palette[curve.colour % palette.length];
    const how = { isExact: true, isStepped: curve.isStepped };
    made.push({ scale: curve.scale, times, values: values.map((value) => value + by), colour, dash: [3, 4], how });
  }
  return made;
}

/**
 * The lowest and the highest visible value of the overlays on an axis.
 *
 * @param {Overlay[]} of
 * @param {string} scale
 * @param {[number, number]} range time range
 * @returns {[number, number]}
 */
export function extent(of, scale, [from, to]) {
  let [low, high] = [Infinity, -Infinity];
  for (const one of of) {
    if (one.scale !== scale) continue;
    one.values.forEach((value, at) => {
      if (value === null || one.times[at] < from || one.times[at] > to) return;
      low = Math.min(low, value);
      high = Math.max(high, value);
    });
  }
  return [low, high];
}

/**
 * Draws overlays.
 *
 * @param {uPlot} self
 * @param {Overlay[]} of
 */
export function drawOverlays(self, of) {
  const { ctx, bbox } = self;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.lineWidth = 1.4 * uPlot.pxRatio;
  for (const one of of) {
    ctx.strokeStyle = one.colour;
    ctx.setLineDash(one.dash.map((length) => length * uPlot.pxRatio));
    const { stroke, fill } = outline(
      one.times,
      one.values,
      one.how,
      (time) => self.valToPos(time, "x", true),
      (value) => self.valToPos(value, one.scale, true),
    );
    ctx.stroke(new Path2D(stroke));
    if (!fill) continue;
    ctx.globalAlpha = 0.3;
    ctx.fillStyle = one.colour;
    ctx.fill(new Path2D(fill));
    ctx.globalAlpha = 1;
  }
  ctx.restore();
}

/**
 * Copies selected numbers with all their digits, which are in the attribute `data-full`.
 *
 * @param {ClipboardEvent} event
 */
export function copyInFull(event) {
  const selection = getSelection();
  if (!selection || selection.isCollapsed) return;
  const part = selection.getRangeAt(0).cloneContents();
  const cells = [...part.querySelectorAll("[data-full]")];
  const around = selection.getRangeAt(0).commonAncestorContainer;
  const single = (around instanceof Element ? around : around.parentElement)?.closest("[data-full]");
  if (single) event.clipboardData?.setData("text/plain", single.getAttribute("data-full") ?? "");
  else if (cells.length > 0) {
    for (const cell of cells) cell.textContent = cell.getAttribute("data-full");
    const lines = [...part.querySelectorAll(".signal")].map((row) =>
      [...row.children].map((cell) => cell.textContent).join("\t"),
    );
    event.clipboardData?.setData("text/plain", lines.length > 0 ? lines.join("\n") : (part.textContent ?? ""));
  } else return;
  event.preventDefault();
}
