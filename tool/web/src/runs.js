/**
 * The list of a loop's runs, with their names, the settings in which they differ, their figures side by side, their
 * colours, and whether they are drawn. A run can be repeated: as the same test with the current settings, or bit for
 * bit.
 *
 * @typedef {import("./messages").Figure} Figure
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Kept a run in the list, plain data
 * @property {number} run its 0-based number in the engine
 * @property {string} name
 * @property {number} colour its index in the colours of runs; the current run has the colours of the signals
 * @property {boolean} isShown
 * @property {import("./messages").Setup} setup
 * @property {import("./messages").Event[]} events
 * @property {number} calls
 * @property {Figure[]} figures
 * @property {import("./messages").Happened | null} [step] the step to which the figures belong
 */

import { swatch, theme } from "tool/charts.js";
import { element, fill, tableHead } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { areComparable, figuresOf, shownUnit, stepText } from "tool/figures.js";
import { repeated } from "tool/moment.js";
import { split, store } from "tool/store.js";
import { rounded, same, shown } from "tool/values.js";

/** The number of runs that the engine keeps, including the current one. */
const MOST = 6;
/** The events of a run are kept only if there are no more than this; otherwise, it cannot be repeated after a reload. */
const MOST_EVENTS = 5000;

/** @type {HTMLElement} */
let body;

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div.runs");
  fill(content, body);
  store.on("run", begin);
  store.on("figures", (/** @type {import("./messages").Figures} */ { figures, step }) => {
    const now = present();
    if (!now) return;
    now.figures = figures;
    now.step = step;
    now.calls = store.state?.calls ?? 0;
    show();
  });
  store.on("state", () => {
    const now = present();
    if (now) now.calls = store.state?.calls ?? 0;
  });
  for (const what of ["loop", "tab"]) store.on(what, show);
  store.on("applied", follow);
  show();
}

/**
 * The listed runs of a loop, earliest first.
 *
 * @param {Work | undefined} loop
 * @returns {Kept[]}
 */
export function runsOf(loop) {
  if (!loop) return [];
  loop.notes.runs ??= [];
  return loop.notes.runs;
}

/** The list entry of the current run. */
function present() {
  return store.isLive() ? runsOf(store.loop).find(({ run }) => run === store.state?.run) : undefined;
}

/**
 * Adds a new run to the list and completes the entry of the previous one.
 *
 * @param {import("./messages").Setup} setup
 */
function begin(setup) {
  const [loop, state] = [store.live, store.state];
  if (!loop || !state) return;
  const list = runsOf(loop);
  const before = list.at(-1);
  if (!list.some(({ run }) => run === state.run)) {
    const number = 1 + Math.max(0, ...list.map(({ name }) => Number(/^Run (\d+)$/.exec(name)?.[1] ?? 0)));
    const colour = ((before?.colour ?? -1) + 1) % theme().runs.length;
    const first = { run: state.run, name: `Run ${number}`, colour, isShown: true };
    list.push({ ...first, setup: structuredClone(setup), events: [], calls: state.calls, figures: [] });
    if (list.length > MOST) list.splice(0, list.length - MOST);
    if (before) complete(loop, before);
  }
  show();
  store.emit("runs");
}

/**
 * Fetches the final data of a run after the next one has begun.
 *
 * @param {Work} loop
 * @param {Kept} kept
 */
async function complete(loop, kept) {
  try {
    const { events, calls } = await ask({ do: "events", run: kept.run });
    kept.events = events.length > MOST_EVENTS ? [] : events;
    kept.calls = calls;
    if (calls > 0) ({ figures: kept.figures, step: kept.step } = await figuresOf(loop, kept.run));
    show();
  } catch {
    // The engine no longer has the run: keep the data in the list.
  }
}

/**
 * Whether a variable of the controller is a stimulus. All others are settings.
 *
 * @param {Work} loop
 * @param {string} name
 */
function isStimulus(loop, name) {
  return loop.settings[name]?.variable.is_stimulus === true;
}

/** @param {() => Promise<unknown>} action */
const tried = (action) => async () => {
  store.emit("pause");
  try {
    await action();
  } catch (error) {
    store.say(error);
  }
};

/** The two buttons that repeat the current run. */
export function againButtons() {
  const test = "The same setpoints, manual values and disturbances, with the current settings";
  const bits = "The same run bit for bit: same start, same settings. Undo restores the current settings";
  return [
    element("button", { onclick: tried(() => repeated("same_test")), title: test }, "Same test"),
    element("button", { onclick: tried(() => repeated("same_bits")), title: bits }, "Repeat exactly"),
  ];
}

/**
 * All values that each of the controller's settings had in the calls of a run, in order.
 *
 * @param {Work} loop
 * @param {Pick<Kept, "setup" | "events" | "calls">} of
 * @returns {Map<string, import("tool/store.js").Value[]>}
 */
function valuesIn(loop, { setup, events, calls }) {
  const begun = setup.members[0]?.values ?? {};
  const all = new Map(Object.entries(loop.settings).map(([name, one]) => [name, [begun[name] ?? one.start]]));
  for (const { variable, value, call } of events) {
    const [member, name] = split(variable);
    const values = all.get(name);
    if (call >= calls || member !== loop.member || !values) continue;
    // A value set before the first call replaces the one from the setup.
    if (call === 0) values.length = 0;
    values.push(value);
  }
  return all;
}

/**
 * The controller settings of a run, without stimuli, each with its successive values.
 *
 * @param {Work} loop
 * @param {Kept} kept
 */
function settingsOf(loop, kept) {
  const settings = [...valuesIn(loop, kept)].filter(([name]) => !isStimulus(loop, name));
  return new Map(
    settings.map(([name, values]) => {
      const { kind } = loop.settings[name].variable;
      return [name, values.filter((value, at) => at === 0 || !same(kind, value, values[at - 1]))];
    }),
  );
}

/** Updates the current run's entry with its events so far. */
async function follow() {
  const [loop, now] = [store.loop, present()];
  if (!loop || !now) return;
  const { events, calls } = await ask({ do: "events", run: now.run });
  Object.assign(now, { events: events.length > MOST_EVENTS ? [] : events, calls });
  show();
}

/**
 * The previous settings of a loop, for a report: those at the end of the run `run`; by default, those with which the
 * loop was opened.
 *
 * @param {Work} loop
 * @param {number} [run]
 * @returns {Promise<import("./messages").LoopValue[]>}
 */
export async function settingsBefore(loop, run) {
  const values = run === undefined ? undefined : valuesIn(loop, await ask({ do: "events", run }));
  return Object.entries(loop.settings).map(([name, { origin, opened }]) => {
    return { name, value: values?.get(name)?.at(-1) ?? opened, origin: origin ?? null, file: null };
  });
}

/**
 * Whether the current run, repeated with the settings in force, would differ: it had other settings in some of its
 * calls.
 *
 * @param {Work} loop
 */
export async function isAnotherTest(loop) {
  const all = valuesIn(loop, await ask({ do: "events" }));
  return [...all].some(([name, values]) => {
    const { sent, variable } = loop.settings[name];
    return !variable.is_stimulus && values.some((value) => !same(variable.kind, value, sent));
  });
}

/**
 * The names of the settings in which runs differ.
 *
 * @param {Work} loop
 * @param {ReturnType<typeof settingsOf>[]} all the settings of each run
 */
function differingOf(loop, all) {
  return [...(all[0]?.keys() ?? [])].filter((name) => {
    const { kind } = loop.settings[name].variable;
    const first = all[0].get(name) ?? [];
    const isFirst = (/** @type {import("tool/store.js").Value[]} */ values) =>
      values.length === first.length && values.every((value, at) => same(kind, value, first[at]));
    return all.some((one) => !isFirst(one.get(name) ?? []));
  });
}

/**
 * For a report: the last run and those drawn runs whose step is comparable, with the settings in which they differ.
 *
 * @param {Work} loop
 * @returns {import("./messages").ReportedRun[]}
 */
export function comparedRuns(loop) {
  const last = runsOf(loop).at(-1);
  const isThere = (/** @type {Kept} */ kept) =>
    loop.runs.includes(kept.run) && (kept === last || (kept.isShown && areComparable(kept.step, last?.step)));
  const list = runsOf(loop).filter(isThere);
  const all = list.map((kept) => settingsOf(loop, kept));
  const differing = differingOf(loop, all);
  return list.map(({ run, name }, at) => {
    const values = differing.map((setting) => ({ setting, had: all[at].get(setting) ?? [] }));
    return {
      ...{ run, name },
      values: Object.fromEntries(values.map(({ setting, had }) => [setting, had.at(-1) ?? 0])),
      begun: Object.fromEntries(
        values.filter(({ had }) => had.length > 1).map(({ setting, had }) => [setting, had[0]]),
      ),
    };
  });
}

function show() {
  const loop = store.loop;
  if (!body || document.body.dataset.tab !== "runs") return;
  const list = runsOf(loop);
  if (!loop || list.length === 0) {
    fill(body, element("p.faint", "Lists each run with its settings and metrics for comparison. Press Run."));
    return;
  }
  if (body.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement) return;
  const all = list.map((kept) => settingsOf(loop, kept));
  const differing = differingOf(loop, all);
  const titles = new Map(list.flatMap(({ figures }) => figures.map(({ key, title }) => [key, title])));
  const head = ["Run", "Settings that differ", "Step", ...titles.values(), "Again"];
  const rows = list.map((kept, at) => {
    const values = differing.map((setting) => {
      const { kind } = loop.settings[setting].variable;
      const had = (all[at].get(setting) ?? []).map((value) => shown(value, kind));
      return `${setting} ${had.join(", then ")}`;
    });
    return row(loop, kept, values.join(", "), [...titles.keys()]);
  });
  const table = element(
    "table",
    tableHead(head, (at) => at > 2),
    element("tbody", rows),
  );
  const count = element("span.faint", `${list.length} of at most ${MOST} runs`);
  fill(body, element("div.row", againButtons(), count), element("div.wide", table));
}

/**
 * @param {Work} loop
 * @param {Kept} kept
 * @param {string} values text of the settings that differ
 * @param {string[]} metrics keys
 */
function row(loop, kept, values, metrics) {
  const { curves, runs } = theme();
  const { name, run, step } = kept;
  const isNow = store.isLive() && run === store.state?.run;
  const last = runsOf(loop).at(-1);
  const isComparable = kept === last || areComparable(step, last?.step);
  const isShown = { checked: kept.isShown || isNow, disabled: isNow, "aria-label": `Show ${name}` };
  const box = element("input", { type: "checkbox", ...isShown });
  box.addEventListener("change", () => {
    kept.isShown = box.checked;
    store.emit("runs");
  });
  const field = element("input.run-name", { value: name, maxlength: 40, "aria-label": `Name of ${name}` });
  field.addEventListener("change", () => {
    kept.name = field.value.trim() || kept.name;
  });
  const repeat = { "aria-label": `Repeat ${name} exactly`, onclick: tried(() => store.repeat("same_bits", run)) };
  const cells = metrics.map((key) => {
    const figure = kept.figures.find((one) => one.key === key);
    if (!isComparable || !figure || figure.value === null) return element("td.number");
    const text = `${rounded(figure.value, "LREAL", 3)} ${shownUnit(figure.unit)}`.trimEnd();
    return element("td.number", { "data-full": figure.value }, text);
  });
  const why = "The step or its duration differs from that of the last run: the metrics cannot be compared";
  return element(
    "tr",
    { class: isNow && "is-now" },
    element("td", element("span.row", box, swatch(isNow ? curves[1] : runs[kept.colour % runs.length]), field)),
    element("td.name", values || (isNow ? "now" : "")),
    isComparable
      ? element("td.name", step && stepText(step))
      : element("td.name.faint", { title: why }, step && `${stepText(step)} (not comparable)`),
    cells,
    element("td", !isNow && loop.runs.includes(run) && element("button.plain", repeat, "Repeat")),
  );
}
