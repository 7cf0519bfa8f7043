/**
 * The Bode plot of the open loop, for the settings in force and for those of a tuning rule.
 *
 * @typedef {import("./messages").OpenLoop} OpenLoop
 * @typedef {import("tool/charts.js").Drawing} Drawing
 */

import { draw } from "tool/charts.js";
import { element, fill, tableHead } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { valuesOf } from "tool/store.js";
import { rounded } from "tool/values.js";

/**
 * The lowest amplitude in dB and phase in degrees that are drawn: lower values are useless and would compress the plot.
 */
const [LOWEST_AMPLITUDE, LOWEST_PHASE] = [-40, -360];

/**
 * Prepares an element for a plot; returns functions that show and clear it.
 *
 * @param {HTMLElement} place
 */
export function bodePlot(place) {
  const [margins, amplitude, phase] = [1, 2, 3].map(() => element("div"));
  /** @type {(() => void)[]} */
  let ends = [];
  let asked = 0;
  const clear = () => {
    asked += 1;
    for (const end of ends) end();
    ends = [];
    fill(place);
  };
  /**
   * @param {import("tool/store.js").Work} loop
   * @param {import("./messages").Model} model
   * @param {string} rule its name
   * @param {import("./messages").Values} values of the rule
   */
  const show = async (loop, model, rule, values) => {
    asked += 1;
    const mine = asked;
    const controller = { name: loop.member, fmu: loop.description.name, values: valuesOf(loop, "sent") };
    try {
      const { frequencies, loops } = await ask({ do: "bode", model, controller, others: [values] });
      if (mine !== asked) return;
      clear();
      const names = ["in force", rule];
      fill(place, element("h3", "Open loop"), margins, amplitude, phase);
      fill(margins, marginsTable(names, loops));
      ends = [
        draw(amplitude, chart(names, frequencies, loops, "amplitude")),
        draw(phase, chart(names, frequencies, loops, "phase")),
      ];
    } catch (error) {
      if (mine !== asked) return;
      clear();
      const why = error instanceof Error ? error.message : String(error);
      fill(place, element("p.faint", `No Bode plot: ${why}.`));
    }
  };
  return { show, clear };
}

/**
 * The stability margins as a table.
 *
 * @param {string[]} names
 * @param {OpenLoop[]} loops
 */
function marginsTable(names, loops) {
  const number = (/** @type {number | null} */ value, unit = "") =>
    value === null ? "none" : `${rounded(value, "LREAL", 3)}${unit}`;
  const rows = loops.map((of, at) => {
    const { sensitivity, gain_margin, phase_margin } = of;
    const decibels = gain_margin === null ? "" : ` (${rounded(20 * Math.log10(gain_margin), "LREAL", 3)} dB)`;
    const cells = [
      sensitivity === null ? "unstable" : number(sensitivity),
      `${number(gain_margin)}${decibels}`,
      number(phase_margin, "°"),
    ];
    return element(
      "tr",
      element("th", { scope: "row" }, names[at]),
      cells.map((cell) => element("td.number", cell)),
    );
  });
  const head = ["", "Ms", "gain margin", "phase margin"];
  return element(
    "div.wide",
    element(
      "table.margins",
      tableHead(head, (at) => at > 0),
      element("tbody", rows),
    ),
  );
}

/**
 * One half of the plot. Its margin is drawn as a line between the curve and 0 dB or -180°.
 *
 * @param {string[]} names
 * @param {number[]} x
 * @param {OpenLoop[]} loops
 * @param {"amplitude" | "phase"} which
 * @returns {Drawing}
 */
function chart(names, x, loops, which) {
  const isPhase = which === "phase";
  const [lowest, level] = isPhase ? [LOWEST_PHASE, -180] : [LOWEST_AMPLITUDE, 0];
  /** @type {import("tool/charts.js").Mark[]} */
  const marks = [{ from: [x[0], level], to: [x.at(-1) ?? x[0], level] }];
  for (const [at, { gain_margin, phase_margin, gain_crossover, phase_crossover }] of loops.entries()) {
    const read = isPhase ? phase_margin : gain_margin;
    const place = isPhase ? gain_crossover : phase_crossover;
    if (read === null || place === null) continue;
    const value = isPhase ? read - 180 : -20 * Math.log10(read);
    if (value > lowest) marks.push({ from: [place, level], to: [place, value], colour: at + 1 });
  }
  return {
    title: `Bode plot of the open loop: ${which} as a function of frequency`,
    xLabel: "rad/s",
    x,
    isLogarithmic: true,
    marks,
    lines: loops.map((of, at) => ({
      ...{ name: `${names[at]}: ${which}`, unit: isPhase ? "°" : "dB", colour: at + 1, isDashed: at > 0 },
      values: of[which].map((value) => (value < lowest ? null : value)),
    })),
    height: 160,
  };
}
