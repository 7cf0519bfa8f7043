/**
 * Turns the run of a program into a test: the inputs as they were set, and the observed outputs, of which the user
 * keeps those that are expected. The result is a file for `plcfmu test`.
 *
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("tool/history.js").Track} Track
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Item a line of the list: values set before a call, or values observed after it
 * @property {number} call
 * @property {number} until the last call with the observed values
 * @property {Map<Variable, number>} values
 * @property {boolean} isSet
 * @property {boolean} isKept
 */

import { element, fill } from "tool/dom.js";
import { EngineError } from "tool/engine.js";
import { forcedSpans } from "tool/force.js";
import { placeOf, tracks } from "tool/history.js";
import { programOf } from "tool/program.js";
import { variable as fullName, isSettable, store } from "tool/store.js";
import { save } from "tool/takeaway.js";
import { isBoolean, isTime, number, shown } from "tool/values.js";

/** The maximum number of steps in a test. */
const MOST_STEPS = 5000;
const LISTED = 300;
const WHOLE = /^(BYTE|WORD|DWORD|S?INT|USINT|UINT|DINT|UDINT)$/;
const REAL = /^L?REAL$/;
const BITS = /** @type {Record<string, number>} */ ({ BYTE: 8, WORD: 16, DWORD: 32 });

/** Creates the button that shows the list, and the element for the list. */
export function testMaker() {
  const place = element("div.test-maker");
  const button = element("button", { onclick: () => open(place).catch(store.say) }, "Save as test");
  button.hidden = !programOf(store.loop);
  return { button, place };
}

/** @param {HTMLElement} place */
async function open(place) {
  const loop = store.loop;
  const of = programOf(loop);
  if (!loop || !of) return;
  store.emit("pause");
  const items = await observed(loop);
  const name = element("input", { id: "test-name", value: "what was recorded on the page", size: 40 });
  const boxes = items.map((item) => {
    const box = element("input", { type: "checkbox", checked: item.isKept });
    box.addEventListener("change", () => {
      item.isKept = box.checked;
    });
    return box;
  });
  const all = (/** @type {boolean} */ isKept) => () => {
    for (const [at, item] of items.entries()) if (!item.isSet) item.isKept = boxes[at].checked = isKept;
  };
  const file = `${of.compiled.block}_test.toml`;
  const write = () => save(file, new Blob([written(loop, items, name.value)], { type: "application/toml" }));
  const told = items.slice(0, LISTED).map((item, at) => {
    const values = [...item.values].map(([of, value]) => `${of.name} ${text(of, value)}`).join(", ");
    const time = `${seconds(item.call)} s`;
    if (item.isSet) return element("li", element("span.faint", `at ${time} set `), values);
    const until = item.until > item.call ? ` to ${seconds(item.until)} s` : "";
    return element("li", element("label", boxes[at], ` at ${time}${until} expect ${values}`));
  });
  fill(
    place,
    element(
      "div.row",
      element("label", { for: "test-name" }, "Name of the case ", name),
      element("button.primary", { onclick: write }, `Save ${file}`),
      element("button", { onclick: all(true) }, "Keep all"),
      element("button", { onclick: all(false) }, "Keep none"),
      element("button", { onclick: () => fill(place) }, "Close"),
    ),
    element(
      "p.faint",
      `Keep what is expected of the program. Then run: plcfmu test ${file}, ${
        loop.notes.isFolder ? "in the program's folder" : `beside ${of.program.files.map((one) => one.file).join(", ")}`
      }.`,
    ),
    element("ul.test-steps", told),
    items.length > LISTED && element("p.faint", `and ${items.length - LISTED} more, which are kept.`),
  );
  name.focus();
}

/** The time of a call, in seconds. @param {number} call */
function seconds(call) {
  return Math.round(call * (store.state?.step ?? 1) * 1000) / 1000;
}

/** Whether a test can contain values of a variable, by its type. @param {Variable} of */
function isTestable({ kind }) {
  return isBoolean(kind) || isTime(kind) || WHOLE.test(kind) || REAL.test(kind);
}

/**
 * The values set for the program in the current run, and the observed values of its outputs, in order.
 *
 * @param {Work} loop
 * @returns {Promise<Item[]>}
 */
async function observed(loop) {
  const state = store.isLive() ? store.state : undefined;
  if (!state || state.calls === 0)
    throw new EngineError("Nothing has run yet: run the program, then save what it did.");
  const { cycle, variables } = loop.description;
  const own = cycle ? number(loop.settings[cycle]?.sent) : state.step;
  if (Math.abs(own - state.step) > 1e-9)
    throw new EngineError(
      `The run's step is ${state.step} s, but ${loop.name} is called every ${own} s: in a test, each step is a cycle of the program.`,
    );
  const all = variables.filter((one) => isTestable(one) && one.name !== cycle);
  const isForced = (/** @type {Variable} */ { name }) => forcedSpans(fullName(loop, name)).length > 0;
  const given = all.filter((one) => isSettable(one) || isForced(one));
  const results = all.filter((one) => one.role === "output" && !isForced(one));
  const known = await tracks(
    [...given, ...results].map(({ name }) => fullName(loop, name)),
    state,
  );
  const of = (/** @type {Variable} */ { name }) => /** @type {Track} */ (known.get(fullName(loop, name)));
  const sets = group(given, (one) => changes(one, of(one), forcedSpans(fullName(loop, one.name)), state.calls));
  const exact = results.filter(({ kind }) => !REAL.test(kind) && !isTime(kind));
  const expected = group(exact, (one) => changes(one, of(one), [], state.calls));
  const last = state.calls - 1;
  const items = [...sets].map(([call, values]) => ({ call, until: call, values, isSet: true, isKept: true }));
  for (const [call, values] of expected)
    items.push({ call, until: lastOf([...values.keys()].map(of), call, last), values, isSet: false, isKept: true });
  // Analog values change all the time: expect them only when another output changes, and at the end.
  const calls = [...new Set([...expected.keys(), last])].sort((one, other) => one - other);
  const analog = results.filter((one) => !exact.includes(one));
  for (const [call, values] of group(analog, (one) => sampled(one, of(one), calls)))
    items.push({ call, until: call, values, isSet: false, isKept: true });
  if (items.every(({ isSet }) => isSet)) {
    const values = new Map(results.map((one) => [one, of(one).values.at(-1) ?? 0]));
    if (values.size > 0) items.push({ call: last, until: last, values, isSet: false, isKept: true });
  }
  if (items.length > MOST_STEPS)
    throw new EngineError(
      `The test would have ${items.length} steps, but at most ${MOST_STEPS} are possible: make a shorter run.`,
    );
  return items.sort((one, two) => one.call - two.call || Number(two.isSet) - Number(one.isSet));
}

/**
 * The calls in which a variable changes, with its values. Before the first call, it has its start value. While it is
 * forced, every call is included, because a test must set it each time.
 *
 * @param {Variable} variable
 * @param {Track} track
 * @param {[number, number][]} spans
 * @param {number} calls
 * @returns {[number, number][]}
 */
function changes({ start }, track, spans, calls) {
  const { calls: at, values } = track;
  const found = new Map(at.map((call, place) => [call, values[place]]));
  if (Object.is(found.get(0), number(start))) found.delete(0);
  for (const [first, end] of spans) {
    let place = placeOf(track, first);
    for (let call = first; call < Math.min(end, calls); call += 1) {
      if (at[place + 1] === call) place += 1;
      found.set(call, values[place]);
    }
  }
  return [...found];
}

/**
 * The values in the given calls, without those equal to the previous one. Before the first call, a variable has its
 * start value.
 *
 * @param {Variable} variable
 * @param {Track} track
 * @param {number[]} calls
 * @returns {[number, number][]}
 */
function sampled({ start }, track, calls) {
  let before = number(start);
  return calls
    .map((call) => /** @type {[number, number]} */ ([call, track.values[placeOf(track, call)]]))
    .filter(([, value]) => {
      const isChange = !Object.is(value, before);
      before = value;
      return isChange;
    });
}

/**
 * @param {Variable[]} variables
 * @param {(variable: Variable) => [number, number][]} changesOf
 * @returns {Map<number, Map<Variable, number>>} by call
 */
function group(variables, changesOf) {
  const found = new Map();
  for (const variable of variables)
    for (const [call, value] of changesOf(variable))
      found.set(call, (found.get(call) ?? new Map()).set(variable, value));
  return found;
}

/**
 * The last call before any of several variables changes again.
 *
 * @param {Track[]} all
 * @param {number} call
 * @param {number} last
 */
function lastOf(all, call, last) {
  return Math.min(last, ...all.map((track) => (track.calls[placeOf(track, call) + 1] ?? Infinity) - 1));
}

/**
 * The content of the file.
 *
 * @param {Work} loop
 * @param {Item[]} items
 * @param {string} name
 */
function written(loop, items, name) {
  const of = programOf(loop);
  if (!of) return "";
  const { files, cpu, run, tags, constants } = of.program;
  const quoted = (/** @type {string} */ text) => JSON.stringify(text);
  const list = (/** @type {string[]} */ texts) => `[${texts.map(quoted).join(", ")}]`;
  const head = [
    `# Recorded on the page of plcfmu: plcfmu test ${of.compiled.block}_test.toml`,
    // Without `sources`, the program consists of the folder that contains the test file.
    loop.notes.isFolder ? "" : `sources = ${list(files.map(({ file }) => file))}`,
    `cycle = "${Math.round((store.state?.step ?? 1) * 1000)}ms"`,
    run ? `fb = ${quoted(run)}` : "",
    cpu ? `cpu = ${quoted(cpu)}` : "",
    tags?.length ? `instances = ${list(tags.map(([tag, type]) => `${tag} : ${type}`))}` : "",
    constants?.length ? `constants = ${list(constants.map(([constant, value]) => `${constant}=${value}`))}` : "",
  ];
  const table = (/** @type {Item} */ { values }) => {
    const pairs = [...values].map(([one, value]) => {
      const key = /^[A-Za-z0-9_]+$/.test(one.name) ? one.name : quoted(one.name.replaceAll("'", ""));
      return `${key} = ${literal(one, value)}`;
    });
    return `{ ${pairs.join(", ")} }`;
  };
  const steps = items
    .filter(({ isKept }) => isKept)
    .map((item) => {
      const at = `at = "${seconds(item.call)}s"`;
      if (item.isSet) return `  { ${at}, set = ${table(item)} },`;
      const until = item.until > item.call ? `, until = "${seconds(item.until)}s"` : "";
      return `  { ${at}${until}, expect = ${table(item)} },`;
    });
  return `${[...head.filter(Boolean), "", "[[case]]", `name = ${quoted(name)}`, "steps = [", ...steps, "]"].join("\n")}\n`;
}

/** A value in TOML. @param {Variable} of @param {number} value */
function literal({ kind }, value) {
  if (isBoolean(kind)) return String(value === 1);
  if (isTime(kind)) return `"${Math.round(value * 1000)}ms"`;
  if (kind in BITS && value < 0) return String(value + 2 ** BITS[kind]);
  const text = shown(value, kind);
  // In TOML, a number without a decimal point is an integer.
  return REAL.test(kind) && /^-?\d+$/.test(text) ? `${text}.0` : text;
}

/** A value for display. @param {Variable} of @param {number} value */
function text({ kind }, value) {
  return isBoolean(kind) ? shown(value === 1, "BOOL") : shown(value, kind);
}
