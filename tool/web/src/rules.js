/**
 * The table of tuning rules with their predicted effects, and the settings of the chosen rule next to the current
 * settings.
 *
 * @typedef {import("./messages").Tuned} Tuned
 * @typedef {import("tool/store.js").Work} Work
 */

import { element, tableHead, text } from "tool/dom.js";
import { unitText } from "tool/signals.js";
import { rounded, shown } from "tool/values.js";

/**
 * The units of predicted figures, as displayed.
 *
 * @typedef {object} Units
 * @property {string} deviation unit of a difference between process values
 * @property {string} iae
 * @property {string} travel
 */

/** The metrics in the table: title, and key in `Tuned.absent`, the engine's reasons for missing metrics. */
const METRICS = /** @type {[string, string][]} */ ([
  ["Ms", "sensitivity"],
  ["overshoot", "overshoot"],
  ["settles", "settling"],
  ["travel", "travel"],
  ["load: deviation", "deviation"],
  ["recovers", "recovery"],
  ["load: IAE", "iae"],
  ["gain margin", "gain_margin"],
  ["phase margin", "phase_margin"],
]);
/**
 * The CSS classes of columns that are hidden in narrow and in very narrow tables. The list for the chosen rule contains
 * all metrics.
 *
 * @type {Record<string, string>}
 */
const DETAILS = {
  ...{ travel: "detail", recovers: "detail", "gain margin": "detail", "phase margin": "detail" },
  "load: deviation": "detail is-last",
};

/**
 * The table of all rules.
 *
 * @param {Work} loop
 * @param {import("./messages").RulesTable} table
 * @param {Tuned | undefined} present the settings in force, with their predicted effects
 * @param {import("./messages").Rule} chosen
 * @param {Units} units
 * @param {(rule: import("./messages").Rule) => void} choose
 */
export function rulesTable(loop, { rows, missing }, present, chosen, units, choose) {
  // Settings that no rule of this structure computes, such as TD for PI, get no column.
  const isSet = (/** @type {string} */ name) => rows.some(({ tuned }) => typeof tuned?.values[name] === "number");
  const settings = loop.description.roles.controller.slice(0, 3).filter(isSet);
  const names = settings.map((name) => name.slice(name.lastIndexOf(".") + 1));
  /** @param {Tuned} tuned */
  const cells = (tuned) => {
    const { predicted, sensitivity, values } = tuned;
    const given = settings.map((one) => {
      const value = values[one];
      return element("td.number", typeof value === "number" ? rounded(value, "LREAL", 3) : "");
    });
    const metrics = [
      ...[number(sensitivity), number(predicted.overshoot, " %"), number(predicted.settling, " s")],
      number(predicted.travel, ` ${units.travel}`),
      number(predicted.load?.deviation ?? null, ` ${units.deviation}`),
      ...[number(predicted.load?.recovery ?? null, " s"), number(predicted.load?.iae ?? null, ` ${units.iae}`)],
      ...[number(tuned.gain_margin), number(tuned.phase_margin, "°")],
    ];
    const told = metrics.map((cell, at) => {
      const [metric, key] = METRICS[at];
      return element("td", { class: `number ${DETAILS[metric] ?? ""}`, title: tuned.absent[key] }, cell);
    });
    return [...given, ...told];
  };
  const body = rows.map(({ rule, name, tuned, refusal }) => {
    const pressed = String(rule === chosen);
    const of = { class: "plain", title: name, "aria-pressed": pressed, "data-rule": rule };
    const button = element("td", element("button", { ...of, onclick: () => choose(rule) }, name));
    if (!tuned) {
      return element("tr", button, element("td.faint", { colspan: 12, title: refusal }, refusal ?? ""));
    }
    return element("tr", { class: rule === chosen && "is-now" }, button, cells(tuned));
  });
  const head = tableHead(["Rule", ...names, ...METRICS.map(([metric]) => metric)], (at) => at > 0);
  for (const cell of head.querySelectorAll("th")) cell.className += ` ${DETAILS[cell.textContent ?? ""] ?? ""}`;
  return element(
    "div",
    element(
      "table",
      head,
      present && element("tbody.present", element("tr", element("td", "in force"), cells(present))),
      element("tbody.all", body),
    ),
    missing.length > 0 &&
      element(
        "ul.remarks.missing",
        missing.map((line) => element("li", line)),
      ),
  );
}

/**
 * The settings of a rule on one line, with buttons for the next actions in order, such as applying the settings.
 *
 * @param {string} rule
 * @param {Tuned} answer
 * @param {{ name: string, title: string, act: () => void }[]} next
 * @returns {{ row: HTMLElement, show: (at: number, words: string) => void }} `show` marks the next action, with words
 * about it; later ones are disabled
 */
export function applyRow(rule, answer, next) {
  const isStable = answer.sensitivity !== null;
  const numbers = Object.entries(answer.values).flatMap(([name, value]) =>
    typeof value === "number" ? [`${name.slice(name.lastIndexOf(".") + 1)} ${rounded(value, "LREAL", 5)}`] : [],
  );
  const buttons = next.map(({ name, title, act }) => element("button", { title, onclick: act }, name));
  const about = element("span", { class: isStable ? "faint" : "error" });
  text(about, isStable ? "" : "The loop would be unstable: choose another rule or structure.");
  const row = element(
    "p.row",
    element("span.what", "Settings"),
    buttons,
    element("span", `${rule}: ${numbers.join(", ")}`),
    about,
  );
  const show = (/** @type {number} */ now, /** @type {string} */ words) => {
    for (const [at, button] of buttons.entries()) {
      button.classList.toggle("primary", at === now);
      button.disabled = !isStable || at > now;
    }
    if (isStable) text(about, words);
  };
  return { row, show };
}

/**
 * The settings of a rule and the resulting margins of the loop.
 *
 * @param {Work} loop
 * @param {Tuned} answer
 * @param {Units} units
 */
export function settingsTable(loop, answer, units) {
  const rows = Object.entries(answer.values).map(([name, value]) => {
    const setting = loop.settings[name];
    const kind = setting?.variable.kind ?? "LREAL";
    return element(
      "tr",
      element("th.name", { scope: "row" }, name),
      element("td.number", setting ? shown(setting.value, kind) : ""),
      element(
        "td.number.strong",
        { title: String(value) },
        typeof value === "boolean" ? shown(value, kind) : rounded(value, kind, 5),
      ),
      element("td.faint", unitText(setting?.variable.unit)),
    );
  });
  const { predicted } = answer;
  const facts = /** @type {[string, string, string][]} */ ([
    ["Ms", "Maximum sensitivity: up to 1.6 is cautious, above 2 is aggressive", number(answer.sensitivity)],
    ["gain margin", "The gain can grow by this factor before the loop becomes unstable", number(answer.gain_margin)],
    ["phase margin", "", number(answer.phase_margin, "°")],
    ["overshoot", "Overshoot of the predicted setpoint step", number(predicted.overshoot, " %")],
    ["settling", "Settling time of the predicted setpoint step, within 2 %", number(predicted.settling, " s")],
    ["travel", "Total movement of the manipulated value in that step", number(predicted.travel, ` ${units.travel}`)],
    [
      "load: deviation",
      `Largest deviation after a load step of ${predicted.load && predicted.load.size < 0 ? "-10 %" : "+10 %"} at the plant's input`,
      number(predicted.load?.deviation ?? null, ` ${units.deviation}`),
    ],
    [
      "load: recovery",
      `Time until the process value stays within the recovery band${predicted.load ? `: ± ${number(predicted.load.band, ` ${units.deviation}`)}` : ""}`,
      number(predicted.load?.recovery ?? null, " s"),
    ],
    [
      "dead time used",
      "Sum of the model's dead time, half a cycle and half a pulse period",
      number(answer.dead_time, " s"),
    ],
  ]);
  return element(
    "div",
    element(
      "table",
      tableHead(["Setting", "now", "rule", "unit"], (at) => at === 1 || at === 2),
      element("tbody", rows),
    ),
    element(
      "dl.figures",
      facts.map(([name, title, value]) => element("div", { title }, element("dt", name), element("dd", value))),
    ),
  );
}

/**
 * @param {number | null} value
 * @param {string} [unit]
 */
function number(value, unit = "") {
  return value === null || value === undefined ? "–" : `${rounded(value, "LREAL", 3)}${unit}`.trimEnd();
}
