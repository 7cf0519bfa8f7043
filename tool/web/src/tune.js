/**
 * The panel for tuning: identifies the plant's model from a step, computes settings by a rule, shows their predicted
 * effects, and applies them on request.
 *
 * @typedef {import("./messages").Identified} Identified
 * @typedef {import("./messages").Method} Method
 * @typedef {import("./messages").Model} Model
 * @typedef {import("./messages").Rule} Rule
 * @typedef {import("./messages").Structure} Structure
 * @typedef {import("./messages").Tuned} Tuned
 */

import { bodePlot } from "tool/bode.js";
import { draw } from "tool/charts.js";
import { chooser } from "tool/csv.js";
import { attribute, choice, element, fill, numberInput, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { forecast } from "tool/forecast.js";
import { zoomToStep } from "tool/moment.js";
import { ratioRow } from "tool/ratio.js";
import { applyRow, rulesTable, settingsTable } from "tool/rules.js";
import { differenceUnit, units, unitText } from "tool/signals.js";
import { userStep } from "tool/steptest.js";
import { store, valuesOf, wiredTo } from "tool/store.js";
import { read, rounded, same } from "tool/values.js";

const METHODS = /** @type {[Method, string][]} */ ([
  ["least_squares", "least squares"],
  ["two_points", "two points, 28 % and 63 %"],
  ["tangent", "tangent"],
  ["area", "area"],
]);
const STRUCTURES = /** @type {[Structure, string][]} */ ([
  ["p", "P"],
  ["pi", "PI"],
  ["pid", "PID"],
]);

/** The time shown before a step, as a fraction of the step's duration. */
const BEFORE_STEP = 0.1;

/**
 * @typedef {object} Notes data kept with a loop
 * @property {Record<string, string>} model the text of the fields gain, time_constant, second_time_constant, dead_time
 * @property {boolean} isIntegrating
 * @property {Method} method
 * @property {Rule} rule
 * @property {Structure} structure
 * @property {string} closedLoop lambda in seconds, as typed, or empty
 * @property {number | null} pace the alternative to lambda: from 0 (calm) to 1 (fast)
 * @property {string} from the process value before the predicted step, as typed, or empty
 * @property {string} to the setpoint after it, as typed, or empty
 * @property {[number, number] | null} ultimate gain and period found by a relay test
 * @property {string} step the size of the step in a step test, as typed
 * @property {import("./messages").Tuning | null} applied the tuning last applied
 * @property {string} [plant] identifies the plant from which the model was identified; missing for a recording or typed
 * values
 * @property {Model | undefined} heating
 * @property {Model | undefined} cooling
 */

/** @type {HTMLElement} */
let body;
/**
 * The opened recording and the columns to identify from, if any.
 *
 * @type {import("./csv.js").Recording & { time: string, input: string, output: string } | undefined}
 */
let recorded;
/** @type {() => void} */
let endChart = () => {};
/** The number of the last request. Answers to earlier requests are ignored. */
let asked = 0;
/** @type {Tuned | undefined} */
let tuned;
/** The name of the rule that computed `tuned`. */
let tunedBy = "";
/**
 * All rules with their predicted effects, and the step for which they are compared, as needed in a report.
 *
 * @type {Pick<import("./messages").Tuning, "rows" | "step">}
 */
let comparison = { rows: [], step: {} };

/** @type {HTMLElement} */
let csvPlace;
/** @type {HTMLElement} */
let identifiedPlace;
/** @type {HTMLElement} */
let resultPlace;
/** @type {HTMLElement} */
let forecastPlace;
/** @type {ReturnType<typeof bodePlot>} */
let bode;
/** @type {HTMLElement} */
let ratioPlace;
/** @type {HTMLElement} */
let fitPlace;
/** @type {Map<string, HTMLInputElement>} */
let modelFields = new Map();
/** @type {HTMLElement} */
let fit;

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div");
  forecastPlace = forecast();
  fill(content, body);
  store.on("loop", show);
  store.on("loop", findUnits);
  store.on("plant", () => {
    findUnits();
    if (tuned) tune();
  });
  store.on("csv", openCsv);
  for (const what of ["run", "applied"]) store.on(what, () => tuned && tune());
  store.on("settings", (names) => {
    showNext();
    showBode();
    // Rules depend on other settings, such as CYCLE, the normalization and the pulse former. Ignore changes to settings
    // that the rule computes.
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
    ...{ pace: null, from: "", to: "", ultimate: null, step: "10", applied: null },
    ...{ heating: undefined, cooling: undefined },
  };
  if (!loop) return fresh;
  loop.notes.tune ??= fresh;
  return loop.notes.tune;
}

function show() {
  const loop = store.loop;
  endChart();
  bode?.clear();
  tuned = undefined;
  asked += 1;
  isFromCsv = undefined;
  const isTunable = (loop?.description.roles.controller.length ?? 0) > 0;
  document.body.classList.toggle("has-no-tuning", loop !== undefined && !isTunable);
  if (loop && !isTunable && document.body.dataset.tab === "tune") store.emit("show", "plant");
  if (!loop) {
    fill(body);
    return;
  }
  if (!isTunable) {
    fill(body, element("p.faint", `${loop.description.block} has no gain or integral time to tune.`));
    return;
  }
  csvPlace = element("div");
  identifiedPlace = element("div", { "aria-live": "polite" });
  resultPlace = element("div", { "aria-live": "polite" });
  const bodePlace = element("div.bode");
  bode = bodePlot(bodePlace);
  ratioPlace = element("div");
  fitPlace = element("div");
  fit = element("span.fit");
  const fields = element("div", identifyRow(), csvPlace, modelRow(), identifiedPlace, ruleRow());
  fill(body, element("div.tuning", fields, resultPlace), bodePlace, ratioPlace, fitPlace);
  showCsv();
  showRatio();
  tune();
}

function identifyRow() {
  const kept = notes();
  const method = choice({ id: "tune-method" }, METHODS, kept.method, (next) => {
    kept.method = next;
    identifyAgain();
  });
  return element(
    "div.row",
    element("span.what", "Plant"),
    ...testButtons(),
    element(
      "button",
      {
        ...{ onclick: () => identifyRun() },
        title:
          "From the last step in the manipulated value: in manual mode, let the process value settle, make one step, and wait",
      },
      "Identify from this step",
    ),
    chooser("tune-file", "Identify from a CSV", openAndIdentify, (error) => store.say(error)),
    element("label", { for: "tune-method" }, "by ", method),
  );
}

/** The buttons for the step test and the relay test, with the size of the step. */
function testButtons() {
  const kept = notes();
  const loop = store.loop;
  const { manual, manual_pulses: pulses, manipulated_value: output } = loop?.description.roles ?? {};
  const hasValue = manual && output;
  if (!loop || !(hasValue || pulses)) return [];
  const about = `Size of the step in ${unitOfManipulatedValue()}`;
  const size = numberInput({ id: "step-size", value: kept.step, "aria-label": about });
  /** @param {(size: number) => Promise<void>} test @param {string} what */
  const made = (test, what) => async () => {
    const got = read(size.value, { name: "the step", kind: "LREAL" });
    attribute(size, "aria-invalid", "why" in got ? "true" : undefined);
    if ("why" in got) return refuse(got.why);
    kept.step = size.value;
    fill(identifiedPlace, element("p", { role: "status" }, what));
    store.emit("pause");
    // Let the browser display this text before the engine blocks the page.
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
    try {
      if (!store.isLive()) await store.begin();
      await test(Number(got.value));
    } catch (error) {
      if (store.isLive()) await store.take(ask({ do: "state" }));
      refuse(error instanceof Error ? error.message : String(error));
    }
    // Have the session saved with the values set by the test, and the values checked.
    store.emit("settings", []);
    store.check();
  };
  const step = made(async (size) => {
    const { method, isIntegrating } = kept;
    const tested = await ask({ do: "step_test", size, method, is_integrating: isIntegrating });
    const { state, identified } = tested;
    await store.take(Promise.resolve(state));
    isFromCsv = false;
    tests.set(loop, { from: tested.from, to: tested.to });
    if (store.loop === loop) takeModel(identified);
  }, "Step test: settles in manual mode, makes one step, and waits until the process value has settled again.");
  const relay = made(async (size) => {
    const tested = await ask({ do: "relay_test", amplitude: Math.abs(size) });
    await store.take(Promise.resolve(tested.state));
    if (store.loop === loop) takeRelay(tested);
  }, "Relay test: the manipulated value switches up and down until the process value oscillates steadily.");
  const title = hasValue
    ? "In manual mode, waits until the process value has settled, makes one step, waits again, and identifies the plant"
    : "In manual mode, waits until the process value has settled, moves the actuator by the step size, waits again, and identifies the plant";
  const aboutRelay =
    "In manual mode, switches the manipulated value up and down by the step size, and finds the ultimate gain and period";
  return [
    element(
      "span.control",
      element("button.primary", { id: "step-test", onclick: step, title }, "Step test"),
      size,
      element("span.faint", unitOfManipulatedValue()),
      hasValue && element("button", { id: "relay-test", onclick: relay, title: aboutRelay }, "Relay test"),
    ),
  ];
}

/**
 * Uses the ultimate gain and period from a relay test. If there is no model yet, also uses the test's model.
 *
 * @param {import("./messages").RelayTested} tested
 */
function takeRelay({ ultimate, model: found, remarks, swing, hysteresis }) {
  const kept = notes();
  kept.ultimate = ultimate;
  kept.rule = "ziegler_nichols_ultimate";
  const of = model();
  if (typeof of !== "object") {
    isFromCsv = undefined;
    kept.plant = store.loop && plantOf(store.loop);
    writeModel(found);
  }
  const [gain, period] = ultimate.map((one) => rounded(one, "LREAL", 4));
  const sentence = `Ultimate gain ${gain}, ultimate period ${period} s; the process value swings by ±${rounded(swing, "LREAL", 3)} ${unitOfProcessValue()}, hysteresis ${rounded(hysteresis, "LREAL", 3)} ${unitOfProcessValue()}.`;
  const more =
    typeof of === "object"
      ? []
      : [
          "A relay test identifies the plant at a single frequency: the model is an integrator with dead time, and margins and predictions apply to that model. A plant with several lags has smaller margins: run a step test to find them.",
        ];
  endChart();
  fill(identifiedPlace, remarksOf([sentence, ...more, ...remarks]));
  showRatio();
  tune();
}

/**
 * Whether the last model was identified from a CSV (true) or the run (false); `undefined` if it was not identified.
 *
 * @type {boolean | undefined}
 */
let isFromCsv;

/**
 * The part of each loop's run covered by its last step test, without the return to the previous mode, in seconds.
 *
 * @type {WeakMap<object, { from: number, to: number }>}
 */
const tests = new WeakMap();

/** Identifies from the run, not only from its last step test. */
function identifyRun() {
  if (store.loop) tests.delete(store.loop);
  identify(false);
}

/** Identifies from the same data again, after a change of the method or the kind of plant. */
function identifyAgain() {
  if (isFromCsv !== undefined) identify(isFromCsv, store.loop && tests.get(store.loop));
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
  const columns = [["", "by name"], ...of.columns.map((name) => [name])];
  /** @param {"time" | "input" | "output"} which @param {string} title */
  const column = (which, title) =>
    element(
      "label",
      `${title} `,
      choice({ id: `tune-${which}` }, columns, of[which], (next) => {
        of[which] = next;
        identify(true);
      }),
    );
  fill(
    csvPlace,
    element(
      "div.row",
      element("span.what", ""),
      element("span", of.name),
      column("time", "Time"),
      column("input", "Manipulated value"),
      column("output", "Process value"),
      element("button", { onclick: () => identify(true) }, "Identify"),
    ),
  );
}

/**
 * @param {boolean} fromCsv
 * @param {{ from?: number, to?: number }} [part] the part of the run; by default, all of it
 */
async function identify(fromCsv, part = {}) {
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
      : { run: part };
  if (!fromCsv && !store.isLive()) {
    refuse(
      "There is no run yet. Run the loop in manual mode until the process value has settled, then step the manual value and wait.",
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

/**
 * Shows why no model was found, and clears the previous model, which does not belong to this data.
 *
 * @param {string} why
 */
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
  fill(identifiedPlace, element("p.error", why));
}

/** @param {Identified} identified */
function takeModel(identified) {
  const loop = store.loop;
  if (!loop) return;
  notes().ultimate = null;
  notes().plant = isFromCsv === false ? plantOf(loop) : undefined;
  writeModel(identified.model);
  text(fit, `fit ${rounded(identified.fit, "LREAL", 3)} %`);
  const unit = unitOfProcessValue();
  fill(identifiedPlace, remarksOf(identified.remarks));
  endChart();
  endChart = draw(fitPlace, {
    title: "The process value, measured and modelled",
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

/** Writes a model into the fields. @param {Model} of */
function writeModel(of) {
  const kept = notes();
  kept.isIntegrating = of.is_integrating === true;
  const box = document.getElementById("tune-integrating");
  if (box instanceof HTMLInputElement) box.checked = kept.isIntegrating;
  modelFields.get("time_constant")?.closest("label")?.toggleAttribute("hidden", kept.isIntegrating);
  showUnits();
  for (const [name, input] of modelFields) {
    const value = /** @type {Record<string, any>} */ (of)[name] ?? 0;
    // Show four digits, which are more than a step can determine; calculations use all digits.
    kept.model[name] = String(value);
    input.value = rounded(value, "LREAL", 4);
    input.dataset.full = String(value);
    input.dataset.rounded = input.value;
    input.removeAttribute("aria-invalid");
  }
}

/** The loop's units; empty until they are known. */
let unitsOf = { processValue: "", manipulatedValue: "" };

async function findUnits() {
  const loop = store.loop;
  // Until the units are known, do not show those of the previous loop.
  unitsOf = { processValue: "", manipulatedValue: "" };
  if (!loop) return;
  const found = await units(loop).catch(() => unitsOf);
  if (store.loop !== loop) return;
  unitsOf = found;
  if (modelFields.size > 0) showUnits();
}

function unitOfProcessValue() {
  return unitText(unitsOf.processValue);
}

function unitOfManipulatedValue() {
  return unitText(unitsOf.manipulatedValue) || "%";
}

/** @returns {import("tool/rules.js").Units} */
function unitsOfFigures() {
  const deviation = differenceUnit(unitsOf.processValue);
  return { deviation, iae: deviation ? `${deviation}·s` : "s", travel: unitOfManipulatedValue() };
}

/** @type {HTMLElement} */
let gainUnit;
const stepUnit = element("span.faint");

function showUnits() {
  text(stepUnit, unitOfProcessValue());
  const perSecond = notes().isIntegrating ? " s" : "";
  text(
    gainUnit,
    `${unitOfProcessValue() || "1"}/${perSecond ? `(${unitOfManipulatedValue()}${perSecond})` : unitOfManipulatedValue()}`,
  );
}

function modelRow() {
  const kept = notes();
  gainUnit = element("span.faint");
  modelFields = new Map();
  const fields = /** @type {[string, string, string][]} */ ([
    ["gain", "K", ""],
    ["time_constant", "T", "s"],
    ["second_time_constant", "T2", "s"],
    ["dead_time", "L", "s"],
  ]).map(([name, label, unit]) => {
    const written = kept.model[name] ?? (name === "second_time_constant" ? "0" : "");
    const value = written === "" ? "" : rounded(Number(written), "LREAL", 4);
    const input = numberInput({ size: 7, id: `model-${name}`, value });
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
      name === "gain" ? gainUnit : element("span.faint", unit),
    );
  });
  showUnits();
  const box = element("input", { type: "checkbox", id: "tune-integrating", checked: kept.isIntegrating });
  box.addEventListener("change", () => {
    kept.isIntegrating = box.checked;
    modelFields.get("time_constant")?.closest("label")?.toggleAttribute("hidden", box.checked);
    showUnits();
    if (isFromCsv === undefined) tune();
    else identifyAgain();
  });
  const integrating = element("label", box, " integrating");
  return element("div.row", element("span.what", "Model"), fields, integrating, fit);
}

/**
 * The model in the fields, or the problem with one of them; `undefined` if a field is empty.
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

/** @type {HTMLInputElement} */
let closedField;
/** @type {HTMLInputElement} */
let speedField;
/** @type {{ from: HTMLInputElement, to: HTMLInputElement }} */
let stepFields;
let showClosed = () => {};

function ruleRow() {
  const kept = notes();
  /** @param {string} id @param {string} value */
  const field = (id, value) => numberInput({ size: 6, id, value });
  const closed = field("tune-lambda", kept.closedLoop);
  closedField = closed;
  const closedLabel = element(
    "label",
    {
      title:
        "Lambda, the desired time constant of the closed loop, in seconds. Larger is calmer: less overshoot, more time. If empty, the slider sets it",
    },
    "λ ",
    closed,
    element("span.faint", " s, larger is calmer"),
  );
  const slider = element("input", {
    ...{ type: "range", id: "tune-speed", min: 0, max: 1, step: 0.02, value: kept.pace ?? 1 },
    "aria-label": "From calm to fast",
  });
  speedField = slider;
  slider.addEventListener("input", () => {
    kept.pace = Number(slider.value);
    kept.closedLoop = closed.value = "";
    tune();
  });
  const speed = element("span.control", element("span.faint", "calm"), slider, element("span.faint", "fast"));
  closed.addEventListener("input", () => {
    kept.closedLoop = closed.value.trim().replace(",", ".");
    kept.pace = null;
    tune();
  });
  showClosed = () => {
    for (const one of [closedLabel, speed]) one.toggleAttribute("hidden", !["simc", "lambda"].includes(kept.rule));
  };
  showClosed();
  const structures = STRUCTURES.map(([value, name]) => {
    const radio = element("input", { type: "radio", name: "tune-structure", value, checked: value === kept.structure });
    radio.addEventListener("change", () => {
      kept.structure = value;
      tune();
    });
    return element("label", radio, ` ${name}`);
  });
  stepFields = { from: field("tune-from", kept.from), to: field("tune-to", kept.to) };
  for (const end of /** @type {("from" | "to")[]} */ (["from", "to"])) {
    stepFields[end].addEventListener("input", () => {
      kept[end] = stepFields[end].value.trim().replace(",", ".");
      tune();
    });
  }
  return element(
    "div.row",
    element("span.what", "Rules"),
    element("span.row", { role: "radiogroup", "aria-label": "Structure" }, structures),
    speed,
    closedLabel,
    element(
      "span.control",
      { title: "The setpoint step to predict; if empty, the run's step" },
      element("label", "Step from ", stepFields.from),
      element("label", " to ", stepFields.to),
      stepUnit,
    ),
  );
}

/** Fetches the settings of all rules and shows them. */
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
      of ?? "Identify the plant, or enter K, T and L: then each rule shows its settings and the predicted curve.";
    fill(resultPlace, element("p", { class: of ? "error" : "faint" }, why));
    showBode();
    return;
  }
  try {
    const { step, band, origin, same: place } = await userStep(loop, kept, of);
    const closed = Number(kept.closedLoop);
    const request = {
      ...{ model: of, rule: kept.rule, structure: kept.structure },
      controller: { name: loop.member, fmu: loop.description.name, values: valuesOf(loop) },
      closed_loop: kept.closedLoop !== "" && closed > 0 ? closed : null,
      ...{ pace: kept.pace, step, band, ultimate: kept.ultimate, exchange: loop.exchange },
    };
    const table = await ask({ do: "rules", ...request });
    // Settings in force that cannot be evaluated, for example without P action, get no row.
    const own = { ...request.controller, values: valuesOf(loop, "sent") };
    const present = await ask({ do: "in_force", ...request, controller: own }).catch(() => undefined);
    if (mine !== asked || store.loop !== loop) return;
    comparison = { rows: table.rows.map(withoutCurves), step };
    const row = table.rows.find(({ rule }) => rule === kept.rule);
    tuned = row?.tuned ?? undefined;
    showRules(table, row, place, present);
    tunedBy = row?.name ?? "";
    showBode();
    store.predict(tuned && { title: row?.name ?? "", curves: tuned.predicted, origin });
  } catch (error) {
    if (mine !== asked) return;
    tuned = undefined;
    store.predict(undefined);
    showBode();
    fill(resultPlace, element("p.error", error instanceof Error ? error.message : String(error)));
  }
}

/**
 * A row of the table as stored with the loop for a report: of the curves, it contains only the first and the last
 * setpoint.
 *
 * @param {import("./messages").RuleOutcome} row
 */
function withoutCurves(row) {
  if (!row.tuned) return row;
  const { predicted } = row.tuned;
  const setpoint = predicted.setpoint.length > 0 ? [predicted.setpoint[0], ...predicted.setpoint.slice(-1)] : [];
  const ends = { setpoint, times: [], process_value: [], manipulated_value: [] };
  return { ...row, tuned: { ...row.tuned, predicted: { ...predicted, ...ends } } };
}

/** Shows the Bode plot of the open loop, for the settings in force and for those of the rule. */
function showBode() {
  const of = model();
  if (store.loop && tuned && typeof of === "object") bode.show(store.loop, of, tunedBy, tuned.values);
  else bode?.clear();
}

/**
 * Shows all rules side by side, and the settings of the chosen one.
 *
 * @param {import("./messages").RulesTable} compared
 * @param {import("./messages").RuleOutcome | undefined} chosen
 * @param {string} place the value at which the typed step both begins and ends, so that it cannot be run; empty for a
 * real step
 * @param {Tuned | undefined} present the settings in force, with their predicted effects
 */
function showRules(compared, chosen, place, present) {
  const loop = store.loop;
  if (!loop) return;
  const kept = notes();
  const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.rule : undefined;
  const units = unitsOfFigures();
  const table = rulesTable(loop, compared, present, kept.rule, units, (rule) => {
    kept.rule = rule;
    showClosed();
    tune();
  });
  const answer = chosen?.tuned;
  if (answer && answer.pace !== null && kept.pace === null) speedField.value = String(answer.pace);
  closedField.placeholder = answer?.closed_loop ? rounded(answer.closed_loop, "LREAL", 3) : "";
  const { setpoint = [] } = answer?.predicted ?? {};
  for (const [end, value] of /** @type {["from" | "to", number | undefined][]} */ ([
    ["from", setpoint[0]],
    ["to", setpoint.at(-1)],
  ]))
    stepFields[end].placeholder = value === undefined ? "" : rounded(value, "LREAL", 4);
  fill(
    resultPlace,
    answer ? nextRow(loop, chosen?.name ?? "", answer, place === "") : null,
    forecastPlace,
    remarksOf([...stale(loop, kept), ...(answer?.remarks ?? [])]),
    place === "" ? null : element("p.faint", `Start and target are both ${place}. Enter a different start or target.`),
    element(
      "div.tuned",
      answer ? settingsTable(loop, answer, units) : element("p.error", chosen?.refusal ?? "Choose a rule."),
      element("div.rules.wide", table),
    ),
  );
  const again = focused && resultPlace.querySelector(`[data-rule="${focused}"]`);
  if (again instanceof HTMLElement) again.focus();
}

/**
 * Identifies the plant and its connections: if this text changes, the model is out of date.
 *
 * @param {import("tool/store.js").Work} loop
 */
function plantOf({ members, connections }) {
  return JSON.stringify([members, connections]);
}

/**
 * A remark if the plant has changed since the model was identified.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {Notes} kept
 */
function stale(loop, { plant }) {
  return plant === undefined || plant === plantOf(loop)
    ? []
    : ["The plant was changed after this model was identified: identify the plant again."];
}

/** Shows the next action for the settings of the rule. */
let showNext = () => {};

/**
 * The buttons to apply the settings and to run the predicted step.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {string} rule
 * @param {Tuned} answer
 * @param {boolean} isStep whether the user can run the step
 */
function nextRow(loop, rule, answer, isStep) {
  const { setpoint } = loop.description.roles;
  const [from, to] = [answer.predicted.setpoint[0], answer.predicted.setpoint.at(-1)];
  const next = [
    { name: "Apply", title: "Applies them from the next cycle; Undo reverts them", act: () => applyTuned(answer) },
  ];
  if (isStep && setpoint && to !== undefined && !wiredTo(loop, setpoint)) {
    const [shownStart, shownGoal] = [from, to].map((one) =>
      `${rounded(one, "LREAL", 4)} ${unitOfProcessValue()}`.trimEnd(),
    );
    next.push({
      name: `Run the step to ${shownGoal}`,
      title: `Automatic mode, settled at ${shownStart}, then setpoint ${shownGoal}, at full speed until it has settled`,
      act: () => runStep(setpoint, from, to),
    });
  }
  const { row, show } = applyRow(rule, answer, next);
  showNext = () => {
    if (store.loop !== loop) return;
    const own = Object.entries(answer.values).map(([name, value]) => ({ one: loop.settings[name], value }));
    const isInForce = own.every(({ one, value }) => !one || same(one.variable.kind, one.sent, value));
    show(isInForce ? 1 : 0, isInForce ? "in force" : "");
  };
  showNext();
  return row;
}

/**
 * Runs the predicted step: settles the loop in automatic mode at `from`, then steps the setpoint.
 *
 * @param {string} setpoint
 * @param {number} from
 * @param {number} to
 */
async function runStep(setpoint, from, to) {
  store.emit("pause");
  try {
    if (!store.isLive()) await store.begin();
    await store.take(ask({ do: "rest_at", setpoint: from }).then(({ state }) => state));
    await store.now({ [setpoint]: to });
    showStep();
    store.emit("run-to-rest");
  } catch (error) {
    if (store.isLive()) await store.take(ask({ do: "state" }));
    store.say(error);
  }
}

/** Zooms to the part of the run in which the predicted step will be. */
function showStep() {
  const { times = [] } = store.prediction?.curves ?? {};
  const [start, length] = [store.state?.time ?? 0, (times.at(-1) ?? 0) - (times[0] ?? 0)];
  if (length > 0) zoomToStep(start - BEFORE_STEP * length, start + length);
}

/** @param {Tuned} answer */
function applyTuned(answer) {
  const { values, closed_loop, sensitivity, gain_margin, phase_margin } = answer;
  const of = model();
  const settings = store.loop?.settings ?? {};
  const before = Object.fromEntries(
    Object.keys(values).flatMap((name) => (settings[name] ? [[name, settings[name].sent]] : [])),
  );
  const applied = { values, closed_loop, sensitivity, gain_margin, phase_margin, before, ...comparison };
  if (typeof of === "object") notes().applied = { model: of, rule: notes().rule, ...applied };
  store.edit(values);
  store.send(Object.keys(values));
}

/**
 * The tuning last applied to the current loop, for a report; `null` if no rule has been applied.
 *
 * @returns {import("./messages").Tuning | null}
 */
export function tuning() {
  return store.loop ? notes().applied : null;
}

/** Shows the row for the ratio of heating and cooling, for blocks with a setting for it. */
function showRatio() {
  if (store.loop) fill(ratioPlace, ratioRow(store.loop, notes(), model));
}

/** @param {string[]} remarks */
function remarksOf(remarks) {
  return element(
    "ul.remarks",
    remarks.map((remark) => element("li", remark)),
  );
}
