/**
 * Tuning: the plant's model from a step, settings by a rule, what they lead to, and only then into the fields.
 *
 * @typedef {import("./messages").Identified} Identified
 * @typedef {import("./messages").Method} Method
 * @typedef {import("./messages").Model} Model
 * @typedef {import("./messages").Rule} Rule
 * @typedef {import("./messages").Structure} Structure
 * @typedef {import("./messages").Tuned} Tuned
 */

import { draw } from "tool/charts.js";
import { chooser } from "tool/csv.js";
import { attribute, element, fill, tableHead, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { units, unitText } from "tool/signals.js";
import { canStep, stepTest } from "tool/steptest.js";
import { store, valuesOf } from "tool/store.js";
import { read, rounded, shown } from "tool/values.js";

const METHODS = /** @type {[Method, string][]} */ ([
  ["least_squares", "least squares"],
  ["two_points", "two points, 28 % and 63 %"],
  ["tangent", "tangent"],
  ["area", "area"],
]);
const RULES = /** @type {[Rule, string][]} */ ([
  ["simc", "SIMC"],
  ["amigo", "AMIGO"],
  ["chr_setpoint0", "Chien-Hrones-Reswick, setpoint, 0 %"],
  ["chr_setpoint20", "Chien-Hrones-Reswick, setpoint, 20 %"],
  ["chr_disturbance0", "Chien-Hrones-Reswick, disturbance, 0 %"],
  ["chr_disturbance20", "Chien-Hrones-Reswick, disturbance, 20 %"],
  ["ziegler_nichols_step", "Ziegler-Nichols, step answer"],
  ["ziegler_nichols_ultimate", "Ziegler-Nichols, ultimate gain"],
]);
const STRUCTURES = /** @type {[Structure, string][]} */ ([
  ["p", "P"],
  ["pi", "PI"],
  ["pid", "PID"],
]);

/**
 * @typedef {object} Notes what is kept with a loop
 * @property {Record<string, string>} model the fields: gain, time_constant, second_time_constant, dead_time
 * @property {boolean} isIntegrating
 * @property {Method} method
 * @property {Rule} rule
 * @property {Structure} structure
 * @property {string} closedLoop lambda in seconds, or empty
 * @property {string} step the size of the step test
 * @property {Model | undefined} heating
 * @property {Model | undefined} cooling
 */

/** @type {HTMLElement} */
let body;
/**
 * The recording to identify from; without it the run.
 *
 * @type {import("./csv.js").Recording & { time: string, input: string, output: string } | undefined}
 */
let recorded;
/** @type {() => void} */
let endChart = () => {};
/** Answers that come late are not shown. */
let asked = 0;
/** @type {Tuned | undefined} */
let tuned;

/** @type {HTMLElement} */
let csvPlace;
/** @type {HTMLElement} */
let identifiedPlace;
/** @type {HTMLElement} */
let resultPlace;
/** @type {HTMLElement} */
let rulesPlace;
/** @type {HTMLElement} */
let ratioPlace;
/** @type {Map<string, HTMLInputElement>} */
let modelFields = new Map();
/** @type {HTMLElement} */
let fit;

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div", {});
  fill(content, body);
  store.on("loop", show);
  store.on("loop", findUnits);
  store.on("plant", findUnits);
  store.on("csv", openCsv);
  store.on("settings", (names) => {
    // CYCLE, the normalisation and the pulse former count in a rule; what the rule itself has written does not.
    const own = Object.keys(tuned?.values ?? {});
    if (tuned && names.some((/** @type {string} */ name) => !own.includes(name))) tune();
  });
  show();
}

/** @returns {Notes} */
function notes() {
  const loop = store.loop;
  /** @type {Notes} */
  const fresh = {
    ...{ model: {}, isIntegrating: false, method: "least_squares", rule: "simc", structure: "pi", closedLoop: "" },
    step: "10",
    ...{ heating: undefined, cooling: undefined },
  };
  if (!loop) return fresh;
  loop.notes.tune ??= fresh;
  return loop.notes.tune;
}

function show() {
  const loop = store.loop;
  endChart();
  tuned = undefined;
  asked += 1;
  isFromCsv = undefined;
  if (!loop) {
    fill(body);
    return;
  }
  const { controller } = loop.description.roles;
  if (controller.length === 0) {
    fill(body, element("p", { class: "faint" }, `${loop.description.block} has no gain and no integral time to tune.`));
    return;
  }
  csvPlace = element("div", {});
  identifiedPlace = element("div", { "aria-live": "polite" });
  resultPlace = element("div", { "aria-live": "polite" });
  rulesPlace = element("div", { class: "rules wide" });
  ratioPlace = element("div", {});
  fit = element("span", { class: "fit" });
  fill(body, identifyRow(), csvPlace, modelRow(), identifiedPlace, ruleRow(), resultPlace, ratioPlace);
  showCsv();
  showRatio();
  tune();
}

function identifyRow() {
  const kept = notes();
  const method = choice("tune-method", METHODS, kept.method, (next) => {
    kept.method = next;
    identifyAgain();
  });
  const box = element("input", { type: "checkbox", checked: kept.isIntegrating });
  box.addEventListener("change", () => {
    kept.isIntegrating = box.checked;
    modelFields.get("time_constant")?.closest("label")?.toggleAttribute("hidden", box.checked);
    showUnits();
    if (isFromCsv === undefined) tune();
    else identifyAgain();
  });
  return element(
    "div",
    { class: "row" },
    element("span", { class: "what" }, "Plant"),
    stepTestButton(),
    element(
      "button",
      {
        ...{ type: "button", onclick: () => identify(false) },
        title: "From the last step of the manipulated value in this run: at rest, in manual, one step, wait",
      },
      "Identify from this step",
    ),
    chooser("tune-file", "Identify from a CSV", openAndIdentify, (error) => store.say(error)),
    element("label", { for: "tune-method" }, "by ", method),
    element("label", {}, box, " integrating"),
  );
}

/**
 * @template {string} T
 * @param {string} id
 * @param {[T, string][]} from
 * @param {T} now
 * @param {(next: T) => void} take
 */
function choice(id, from, now, take) {
  const list = element(
    "select",
    { id },
    from.map(([value, name]) => element("option", { value, selected: value === now }, name)),
  );
  list.addEventListener("change", () => take(/** @type {T} */ (list.value)));
  return list;
}

/** The step test in one button, with the size of its step. */
function stepTestButton() {
  const kept = notes();
  const loop = store.loop;
  if (!loop || !canStep(loop)) return null;
  const size = element("input", {
    ...{ class: "number", id: "step-size", value: kept.step, inputmode: "decimal", autocomplete: "off" },
    ...{ "aria-label": `Size of the step in ${unitOfManipulatedValue()}` },
  });
  const test = async () => {
    const got = read(size.value, { name: "the step", kind: "LREAL" });
    attribute(size, "aria-invalid", "why" in got ? "true" : undefined);
    if ("why" in got) return refuse(got.why);
    kept.step = size.value;
    const tell = (/** @type {string} */ sentence) => fill(identifiedPlace, element("p", { role: "status" }, sentence));
    try {
      await stepTest(Number(got.value), kept.isIntegrating, tell);
      if (store.loop === loop) await identify(false);
    } catch (error) {
      refuse(error instanceof Error ? error.message : String(error));
    }
  };
  const title = "Manual at the present value, wait for rest, one step, wait for rest, identify";
  return element(
    "span",
    { class: "control" },
    element("button", { type: "button", class: "primary", id: "step-test", onclick: test, title }, "Step test"),
    size,
    element("span", { class: "faint" }, unitOfManipulatedValue()),
  );
}

/** From what the model was identified last: a CSV, or the run. @type {boolean | undefined} */
let isFromCsv;

/** Another method, or another kind of plant: the same data give another model. */
function identifyAgain() {
  if (isFromCsv !== undefined) identify(isFromCsv);
}

/** @param {import("./csv.js").Recording} recording */
function openCsv(recording) {
  recorded = { ...recording, time: "", input: "", output: "" };
  showCsv();
}

/** @param {import("./csv.js").Recording} recording */
function openAndIdentify(recording) {
  openCsv(recording);
  identify(true);
}

function showCsv() {
  if (!recorded || !csvPlace) return;
  const of = recorded;
  /** @param {"time" | "input" | "output"} which @param {string} title */
  const column = (which, title) =>
    element(
      "label",
      {},
      `${title} `,
      choice(
        `tune-${which}`,
        /** @type {[string, string][]} */ ([["", "by its name"], ...of.columns.map((name) => [name, name])]),
        of[which],
        (next) => {
          of[which] = next;
          identify(true);
        },
      ),
    );
  fill(
    csvPlace,
    element(
      "div",
      { class: "row" },
      element("span", { class: "what" }, ""),
      element("span", {}, of.name),
      column("time", "Time"),
      column("input", "Manipulated value"),
      column("output", "Process value"),
      element("button", { type: "button", onclick: () => identify(true) }, "Identify"),
    ),
  );
}

/** @param {boolean} fromCsv */
async function identify(fromCsv) {
  const loop = store.loop;
  if (!loop) return;
  const kept = notes();
  isFromCsv = fromCsv;
  /** @type {import("./messages").Data} */
  const data =
    fromCsv && recorded
      ? {
          csv: {
            text: recorded.text,
            ...Object.fromEntries(
              ["time", "input", "output"].map((one) => [one, /** @type {any} */ (recorded)[one] || null]),
            ),
          },
        }
      : { run: {} };
  if (!fromCsv && !store.isLive()) {
    refuse(
      "There is no run yet. Run the loop in manual until the process value rests, then step the manual value and wait.",
    );
    return;
  }
  try {
    const identified = await ask({ do: "identify", data, method: kept.method, is_integrating: kept.isIntegrating });
    if (store.loop !== loop) return;
    takeModel(identified);
  } catch (error) {
    refuse(error instanceof Error ? error.message : String(error));
  }
}

/** What was identified before is not the model of this recording. @param {string} why */
function refuse(why) {
  endChart();
  text(fit, "");
  const kept = notes();
  kept.model = {};
  for (const [name, input] of modelFields) {
    input.value = name === "second_time_constant" ? "0" : "";
    input.dataset.full = input.dataset.rounded = input.value;
    input.removeAttribute("aria-invalid");
  }
  tune();
  fill(identifiedPlace, element("p", { class: "error" }, why));
}

/** @param {Identified} identified */
function takeModel(identified) {
  const loop = store.loop;
  if (!loop) return;
  const kept = notes();
  const { model } = identified;
  kept.isIntegrating = model.is_integrating === true;
  for (const [name, input] of modelFields) {
    const value = /** @type {Record<string, any>} */ (model)[name] ?? 0;
    // Four digits are more than a step tells; all are used.
    kept.model[name] = String(value);
    input.value = rounded(value, "LREAL", 4);
    input.dataset.full = String(value);
    input.dataset.rounded = input.value;
    input.removeAttribute("aria-invalid");
  }
  text(fit, `fit ${rounded(identified.fit, "LREAL", 3)} %`);
  const chart = element("div", {});
  const unit = unitOfProcessValue();
  fill(identifiedPlace, remarksOf(identified.remarks), chart);
  endChart();
  endChart = draw(chart, {
    title: "The process value, measured and of the model",
    xLabel: "s",
    x: identified.times,
    lines: [
      { name: "measured", values: identified.measured, unit, colour: 1 },
      { name: "model", values: identified.modelled, unit, colour: 2, isDashed: true },
    ],
    height: 150,
  });
  showRatio();
  tune();
}

/** The loop's units, as soon as they are known. */
let unitsOf = { processValue: "", manipulatedValue: "" };

async function findUnits() {
  const loop = store.loop;
  if (!loop) return;
  const found = await units(loop).catch(() => unitsOf);
  if (store.loop !== loop) return;
  unitsOf = found;
  if (modelFields.size > 0) showUnits();
}

function unitOfProcessValue() {
  return unitsOf.processValue;
}

function unitOfManipulatedValue() {
  return unitsOf.manipulatedValue || "%";
}

/** @type {HTMLElement} */
let gainUnit;

function showUnits() {
  const perSecond = notes().isIntegrating ? " s" : "";
  text(
    gainUnit,
    `${unitOfProcessValue() || "1"}/${perSecond ? `(${unitOfManipulatedValue()}${perSecond})` : unitOfManipulatedValue()}`,
  );
}

function modelRow() {
  const kept = notes();
  gainUnit = element("span", { class: "faint" });
  modelFields = new Map();
  const fields = /** @type {[string, string, string][]} */ ([
    ["gain", "K", ""],
    ["time_constant", "T", "s"],
    ["second_time_constant", "T2", "s"],
    ["dead_time", "L", "s"],
  ]).map(([name, label, unit]) => {
    const written = kept.model[name] ?? (name === "second_time_constant" ? "0" : "");
    const input = element("input", {
      ...{ class: "number", size: 7, inputmode: "decimal", autocomplete: "off", id: `model-${name}` },
      value: written === "" ? "" : rounded(Number(written), "LREAL", 4),
    });
    input.dataset.full = written;
    input.dataset.rounded = input.value;
    input.addEventListener("input", () => {
      input.dataset.full = input.value;
      input.dataset.rounded = input.value;
      kept.model[name] = input.value;
      text(fit, "");
      tune();
    });
    modelFields.set(name, input);
    return element(
      "label",
      { hidden: name === "time_constant" && kept.isIntegrating },
      `${label} `,
      input,
      " ",
      name === "gain" ? gainUnit : element("span", { class: "faint" }, unit),
    );
  });
  showUnits();
  return element("div", { class: "row" }, element("span", { class: "what" }, "Model"), fields, fit);
}

/**
 * The model of the fields, or what is wrong with them.
 *
 * @returns {Model | string | undefined}
 */
function model() {
  const kept = notes();
  /** @type {Record<string, number>} */
  const values = {};
  for (const [name, input] of modelFields) {
    if (name === "time_constant" && kept.isIntegrating) {
      values[name] = 0;
      continue;
    }
    const written = input.dataset.full ?? "";
    if (written.trim() === "") return undefined;
    const got = read(written, { name: name.replaceAll("_", " "), kind: "LREAL" });
    attribute(input, "aria-invalid", "why" in got ? "true" : undefined);
    if ("why" in got) return got.why;
    values[name] = Number(got.value);
  }
  return {
    ...{ gain: values.gain, time_constant: values.time_constant, dead_time: values.dead_time },
    ...{ second_time_constant: values.second_time_constant, is_integrating: kept.isIntegrating },
  };
}

function ruleRow() {
  const kept = notes();
  const closed = element("input", {
    class: "number",
    size: 6,
    value: kept.closedLoop,
    placeholder: "L",
    inputmode: "decimal",
    autocomplete: "off",
  });
  const closedLabel = element(
    "label",
    { title: "Lambda, the time constant of the closed loop that SIMC aims at: the dead time is fast, more is calm" },
    "λ ",
    closed,
    element("span", { class: "faint" }, " s, closed loop"),
  );
  const slider = element("input", {
    ...{ type: "range", id: "tune-speed", min: -CALMEST, max: CALMEST / 2, step: 0.1, value: 0 },
    "aria-label": "From calm to fast",
  });
  slider.addEventListener("input", () => {
    const of = model();
    if (typeof of !== "object") return;
    const lag = of.is_integrating ? 10 * of.dead_time : of.time_constant;
    const least = Math.max(of.dead_time, lag / 20) || 1;
    kept.closedLoop = String(Number((least * 2 ** -Number(slider.value)).toPrecision(3)));
    closed.value = kept.closedLoop;
    tune();
  });
  const speed = element(
    "span",
    { class: "control" },
    element("span", { class: "faint" }, "calm"),
    slider,
    element("span", { class: "faint" }, "fast"),
  );
  closed.addEventListener("input", () => {
    kept.closedLoop = closed.value.trim().replace(",", ".");
    tune();
  });
  showClosed = () => {
    for (const one of [closedLabel, speed]) one.toggleAttribute("hidden", kept.rule !== "simc");
  };
  showClosed();
  const rule = choice("tune-rule", RULES, kept.rule, (next) => {
    kept.rule = next;
    showClosed();
    tune();
  });
  const structures = STRUCTURES.map(([value, name]) => {
    const radio = element("input", { type: "radio", name: "tune-structure", value, checked: value === kept.structure });
    radio.addEventListener("change", () => {
      kept.structure = value;
      tune();
    });
    return element("label", {}, radio, ` ${name}`);
  });
  return element(
    "div",
    { class: "row" },
    element("span", { class: "what" }, "Rule"),
    element("label", { class: "visually-hidden", for: "tune-rule" }, "Rule"),
    rule,
    element("span", { class: "row", role: "radiogroup", "aria-label": "Structure" }, structures),
    speed,
    closedLabel,
  );
}

/** The slider reaches from 2^4 times the shortest sensible lambda to a quarter of it. */
const CALMEST = 4;
let showClosed = () => {};

/** Asks for the settings of the rule, and shows them. */
async function tune() {
  const loop = store.loop;
  if (!loop) return;
  const kept = notes();
  asked += 1;
  const mine = asked;
  const of = model();
  if (of === undefined || typeof of === "string") {
    tuned = undefined;
    store.predict(undefined);
    const why =
      of ?? "Identify the plant, or type K, T and L: then each rule shows its settings and the predicted curve.";
    fill(resultPlace, element("p", { class: of ? "error" : "faint" }, why));
    return;
  }
  try {
    const answer = await tunedBy(kept.rule, of, loop);
    if (mine !== asked || store.loop !== loop) return;
    tuned = answer;
    store.predict({ title: RULES.find(([rule]) => rule === kept.rule)?.[1] ?? "", curves: answer.predicted });
    showTuned(answer);
    await showRules(of, loop, mine);
  } catch (error) {
    if (mine !== asked) return;
    tuned = undefined;
    store.predict(undefined);
    fill(resultPlace, element("p", { class: "error" }, error instanceof Error ? error.message : String(error)));
  }
}

/**
 * @param {Rule} rule
 * @param {Model} of
 * @param {import("tool/store.js").Work} loop
 */
function tunedBy(rule, of, loop) {
  const kept = notes();
  const closed = Number(kept.closedLoop);
  return ask({
    ...{ do: "tune", model: of, rule, structure: kept.structure },
    controller: { name: loop.member, fmu: loop.description.name, values: valuesOf(loop) },
    closed_loop: rule === "simc" && kept.closedLoop !== "" && closed > 0 ? closed : null,
    step: {},
  });
}

/**
 * All rules side by side, each with what it leads to.
 *
 * @param {Model} of
 * @param {import("tool/store.js").Work} loop
 * @param {number} mine which question this answers
 */
async function showRules(of, loop, mine) {
  const rows = [];
  for (const [rule, title] of RULES) {
    const answer = await tunedBy(rule, of, loop).catch((error) => String(error.message ?? error));
    if (mine !== asked || store.loop !== loop) return;
    rows.push(ruleTableRow(rule, title, answer, loop));
  }
  const { controller } = loop.description.roles;
  const names = controller.slice(0, 3).map((name) => name.slice(name.lastIndexOf(".") + 1));
  const titles = ["Rule", ...names, "Ms", "overshoot", "settles", "travel"];
  fill(
    rulesPlace,
    element(
      "table",
      {},
      tableHead(titles, (at) => at > 0),
      element("tbody", {}, rows),
    ),
  );
}

/**
 * @param {Rule} rule
 * @param {string} title
 * @param {Tuned | string} answer
 * @param {import("tool/store.js").Work} loop
 */
function ruleTableRow(rule, title, answer, loop) {
  const kept = notes();
  const take = () => {
    kept.rule = rule;
    const list = document.getElementById("tune-rule");
    if (list instanceof HTMLSelectElement) list.value = rule;
    showClosed();
    tune();
  };
  const name = element(
    "td",
    {},
    element(
      "button",
      { type: "button", class: "plain", "aria-pressed": String(rule === kept.rule), onclick: take },
      title,
    ),
  );
  if (typeof answer === "string") {
    return element("tr", {}, name, element("td", { class: "faint", colspan: 7, title: answer }, answer));
  }
  const { predicted, sensitivity, values } = answer;
  const moves = predicted.manipulated_value;
  const travel = moves.reduce((sum, value, at) => sum + (at > 0 ? Math.abs(value - moves[at - 1]) : 0), 0);
  const settings = loop.description.roles.controller.slice(0, 3).map((one) => {
    const value = values[one];
    return typeof value === "number" ? rounded(value, "LREAL", 3) : "";
  });
  const facts = [number(sensitivity), number(predicted.overshoot, " %"), number(predicted.settling, " s")];
  const cells = [...settings, ...facts, number(travel, ` ${unitOfManipulatedValue()}`)];
  return element(
    "tr",
    { class: rule === kept.rule && "is-now" },
    name,
    cells.map((cell) => element("td", { class: "number" }, cell)),
  );
}

/** @param {Tuned} answer */
function showTuned(answer) {
  const loop = store.loop;
  if (!loop) return;
  const rows = Object.entries(answer.values).map(([name, value]) => {
    const setting = loop.settings[name];
    const kind = setting?.variable.kind ?? "LREAL";
    return element(
      "tr",
      {},
      element("th", { scope: "row", class: "name" }, name),
      element("td", { class: "number" }, setting ? shown(setting.value, kind) : ""),
      element(
        "td",
        { class: "number strong", title: String(value) },
        typeof value === "boolean" ? shown(value, kind) : rounded(value, kind, 5),
      ),
      element("td", { class: "faint" }, unitText(setting?.variable.unit)),
    );
  });
  const { predicted } = answer;
  const facts = /** @type {[string, string, string][]} */ ([
    ["Ms", "The largest sensitivity: up to 1.6 is cautious, above 2 is sharp", number(answer.sensitivity)],
    ["gain margin", "So much more gain the loop takes", number(answer.gain_margin)],
    ["phase margin", "", number(answer.phase_margin, "°")],
    ["overshoot", "Of the predicted setpoint step", number(predicted.overshoot, " %")],
    ["settling", "Settling time of the predicted setpoint step, within 2 %", number(predicted.settling, " s")],
    ["dead time used", "The model's, half a cycle, half a pulse period", number(answer.dead_time, " s")],
  ]);
  const isStable = answer.sensitivity !== null;
  const apply = element(
    "button",
    { type: "button", class: "primary", onclick: () => applyTuned(answer), disabled: !isStable },
    "Apply",
  );
  fill(
    resultPlace,
    element(
      "div",
      { class: "tuned" },
      element(
        "div",
        {},
        element(
          "table",
          {},
          tableHead(["Setting", "now", "rule", "unit"], (at) => at === 1 || at === 2),
          element("tbody", {}, rows),
        ),
        element(
          "p",
          { class: "row" },
          apply,
          isStable
            ? element("span", { class: "faint" }, "into the fields; nothing is in force until you send it")
            : element("span", { class: "error" }, "The loop would be unstable: take another rule or structure."),
        ),
      ),
      element(
        "dl",
        { class: "figures" },
        facts.map(([name, title, value]) =>
          element("div", { title }, element("dt", {}, name), element("dd", {}, value)),
        ),
      ),
    ),
    rulesPlace,
    remarksOf(answer.remarks),
  );
}

/** @param {Tuned} answer */
function applyTuned(answer) {
  store.edit(answer.values);
  showTuned(answer);
  const names = store.edited();
  store.say(
    names.length > 0 ? `${names.join(", ")} edited; send them to the block.` : "The block has these settings already.",
  );
}

/** The ratio of heating and cooling, for blocks that have one. */
function showRatio() {
  const loop = store.loop;
  if (!loop) return;
  const factor = loop.description.roles.pulse_former[2];
  if (!factor) {
    fill(ratioPlace);
    return;
  }
  const kept = notes();
  const result = element("span", { "aria-live": "polite" });
  /** @param {"heating" | "cooling"} which */
  const take = (which) => {
    const now = model();
    if (typeof now !== "object") {
      text(result, now ?? "Identify a step first.");
      return;
    }
    kept[which] = now;
    showRatio();
  };
  /** @param {Model | undefined} of */
  const gain = (of) => (of ? `K ${rounded(of.gain, "LREAL", 4)}` : "none yet");
  const compute = async () => {
    if (!kept.heating || !kept.cooling) return;
    try {
      const ratio = await ask({ do: "ratio", heating: kept.heating, cooling: kept.cooling });
      fill(
        result,
        `${factor} ${rounded(ratio.ratio, "REAL", 5)} `,
        element("button", { type: "button", onclick: () => store.edit({ [factor]: ratio.ratio }) }, "Apply"),
        ...ratio.remarks.map((remark) => element("span", { class: "faint" }, ` ${remark}`)),
      );
    } catch (error) {
      text(result, error instanceof Error ? error.message : String(error));
    }
  };
  fill(
    ratioPlace,
    element(
      "div",
      { class: "row" },
      element("span", { class: "what", title: factor }, factor.slice(factor.lastIndexOf(".") + 1)),
      element("button", { type: "button", onclick: () => take("heating") }, "This model is heating"),
      element("span", { class: "faint" }, gain(kept.heating)),
      element("button", { type: "button", onclick: () => take("cooling") }, "This model is cooling"),
      element("span", { class: "faint" }, gain(kept.cooling)),
      result,
    ),
  );
  compute();
}

/** @param {string[]} remarks */
function remarksOf(remarks) {
  return element(
    "ul",
    { class: "remarks" },
    remarks.map((remark) => element("li", {}, remark)),
  );
}

/**
 * @param {number | null} value
 * @param {string} [unit]
 */
function number(value, unit = "") {
  return value === null || value === undefined ? "–" : `${rounded(value, "LREAL", 4)}${unit}`;
}
