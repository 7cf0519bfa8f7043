/**
 * Replays a recording from a plant through the block, to find out whether it computes the same values as the block in
 * the PLC, and if not, why.
 *
 * @typedef {import("./messages").Replayed} Replayed
 * @typedef {import("./csv.js").Recording} Recording
 */

import { draw } from "tool/charts.js";
import { chooser } from "tool/csv.js";
import { byId, choice, element, fill, tableHead, text } from "tool/dom.js";
import { askAside, Stopped } from "tool/engine.js";
import { changed, fitting, verdict } from "tool/replay_words.js";
import { manualSwitch, unitText } from "tool/signals.js";
import { store, valuesOf } from "tool/store.js";
import { rounded, shown } from "tool/values.js";

/** The maximum number of columns named in the summary, so that the verdict below stays visible. */
const MOST_NAMED = 6;
/** @type {Recording | undefined} */
let recorded;
/**
 * The columns and their variables as assigned by the user; `undefined` until then, so that the engine assigns them.
 *
 * @type {[string, string][] | undefined}
 */
let columns;
let trySuspects = true;
/** @type {string} */
let tolerance = "";
/** @type {HTMLElement} */
let body;
/** @type {HTMLElement} */
let mapping;
/** @type {HTMLElement} */
let result;
/**
 * The curves of the replay, shown in place of the run's curves while the tab is open: below the table, they would be
 * out of sight.
 *
 * @type {HTMLElement}
 */
let stage;
/** Draws the curves of the chosen output; `undefined` if there is no result. @type {(() => void) | undefined} */
let drawCurve;
/** @type {() => void} */
let endChart = () => {};
/** A note that is shown if the settings have changed since the replay. @type {HTMLElement} */
let stale;
/** The settings used for the displayed result: all except stimuli, as JSON; and the controller's, as displayed. */
let replayedWith = "";
let shownWith = "";
/** The height of everything on the stage except the chart, in pixels. */
const AROUND = 96;
/** Cancels the replay in progress. */
let running = new AbortController();
/** The maximum number of replays in a report: each uses the values that the previous one found. */
const MOST_REPORTED = 4;

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div");
  mapping = element("div");
  result = element("div", { "aria-live": "polite" });
  stage = element("div.replay-stage", { role: "region", "aria-label": "Recorded and computed", hidden: true });
  byId("curves").querySelector(".content")?.append(stage);
  stale = element("p.note", { hidden: true });
  fill(content, body, mapping, stale, result);
  store.on("csv", open);
  store.on("loop", show);
  store.on("tab", showStage);
  store.on("settings", showStale);
  show();
}

/** Shows the curves while the tab is open. */
function showStage() {
  stage.hidden = drawCurve === undefined || document.body.dataset.tab !== "replay";
  if (!stage.hidden) drawCurve?.();
}

/** The values in the fields of all settings except stimuli, as JSON. */
function settingsInFields() {
  const loop = store.loop;
  if (!loop) return "";
  return JSON.stringify(Object.entries(valuesOf(loop)).filter(([name]) => !loop.settings[name].variable.is_stimulus));
}

/** Marks the verdict as outdated if the settings have changed. */
function showStale() {
  stale.hidden = replayedWith === "" || replayedWith === settingsInFields();
  text(stale, `The settings have changed since this replay: it used ${shownWith}. Press Replay.`);
  result.classList.toggle("is-former", !stale.hidden);
}

/** Removes the curves of the replay. */
function endStage() {
  endChart();
  drawCurve = undefined;
  showStage();
}

/** @param {Recording} recording */
function open(recording) {
  recorded = recording;
  columns = undefined;
  show();
  replay();
}

/** Replays the open recording. */
const again = () => replay();

function show() {
  endStage();
  replayedWith = "";
  showStale();
  fill(result);
  fill(mapping);
  const loop = store.loop;
  const about = loop
    ? `A CSV recorded on the plant (time, setpoint, process value, manipulated value ...) is replayed through ${loop.description.block} with the parameters of ${loop.name}.`
    : "Open or create a loop first: a recording is replayed through its block.";
  fill(
    body,
    element("p.faint", about),
    element(
      "div.row",
      chooser("replay-file", recorded ? "Another CSV" : "Choose or drop a CSV", open, (error) => store.say(error)),
      recorded && element("span", recorded.name),
      recorded && loop && element("button", { onclick: again }, "Replay"),
      recorded && suspectsBox(),
      recorded && toleranceField(),
    ),
  );
}

function suspectsBox() {
  const box = element("input", { type: "checkbox", checked: trySuspects });
  box.addEventListener("change", () => {
    trySuspects = box.checked;
  });
  return element("label", box, " Look for likely causes");
}

function toleranceField() {
  const input = element("input.number", { size: 6, value: tolerance, placeholder: "auto", inputmode: "decimal" });
  input.addEventListener("input", () => {
    tolerance = input.value.trim().replace(",", ".");
    const isWrong = tolerance !== "" && !(Number(tolerance) >= 0);
    if (isWrong) input.setAttribute("aria-invalid", "true");
    else input.removeAttribute("aria-invalid");
  });
  return element("label", "equal within ", input);
}

/**
 * @param {boolean} [isGoingOn] whether values found by the last replay were applied, so that the report keeps both
 * replays
 */
async function replay(isGoingOn = false) {
  const loop = store.loop;
  if (!loop || !recorded) return;
  const of = recorded;
  endStage();
  replayedWith = settingsInFields();
  showStale();
  const used = loop.description.roles.controller.filter((name) => !loop.checked?.unused.includes(name));
  const values = Object.fromEntries(used.map((name) => [name, loop.settings[name].value]));
  shownWith = settings(values);
  fill(result, element("p", "Replaying …"));
  running.abort();
  const own = new AbortController();
  running = own;
  const allowed = tolerance !== "" && Number(tolerance) >= 0 ? Number(tolerance) : null;
  /** @type {import("./messages").Dialogue["replay"]["request"] & { do: "replay" }} */
  const request = {
    ...{ do: "replay", text: of.text, columns: columns ?? [], try_suspects: false, tolerance: allowed },
    controller: { name: loop.member, fmu: loop.description.name, values: valuesOf(loop) },
  };
  try {
    let replayed = await askAside(request, own.signal);
    if (trySuspects && replayed.conclusion !== "equal") replayed = await causes(request, replayed, own);
    if (store.loop !== loop || recorded !== of || running !== own) return;
    showMapping(replayed.columns);
    const told = showResult(replayed, allowed);
    keep({ file: of.name, values, verdict: told.headline, remarks: told.details }, replayed, isGoingOn);
  } catch (error) {
    // Stopped because another replay has started.
    if (error instanceof Stopped) return;
    showMapping(columns ?? []);
    fill(result, element("p.error", error instanceof Error ? error.message : String(error)));
  }
}

/**
 * Repeats the replay with a search for the causes of the difference. The search takes seconds, so the page shows the
 * time elapsed, and the user can stop the search and keep the known result.
 *
 * @param {import("./messages").Dialogue["replay"]["request"] & { do: "replay" }} request
 * @param {Replayed} known
 * @param {AbortController} own
 */
async function causes(request, known, own) {
  let isStopped = false;
  const stop = () => {
    isStopped = true;
    own.abort();
  };
  const begun = Date.now();
  const progress = element("span", { "aria-hidden": "true" });
  const show = () => text(progress, `${Math.round((Date.now() - begun) / 1000)} s`);
  const [first] = known.outputs.flatMap(({ variable, first }) =>
    first ? `${variable} differs from cycle ${first[0]} onward. ` : [],
  );
  fill(
    result,
    element("p.row", `${first ?? ""}Looking for the cause …`, progress, element("button", { onclick: stop }, "Stop")),
  );
  show();
  const timer = setInterval(show, 500);
  try {
    return await askAside({ ...request, try_suspects: true }, own.signal);
  } catch (error) {
    if (isStopped) return known;
    throw error;
  } finally {
    clearInterval(timer);
  }
}

/**
 * Keeps a replay for the report.
 *
 * @param {Omit<import("./messages").ReportedReplay, "settings">} told
 * @param {Replayed} replayed
 * @param {boolean} isGoingOn
 */
function keep(told, replayed, isGoingOn) {
  const loop = store.loop;
  if (!loop) return;
  const settings = fitting(replayed).filter((change) => "setting" in change);
  const before = replaysOf(loop).filter((one) => one.file === told.file);
  loop.notes.replays = [...(isGoingOn ? before.slice(1 - MOST_REPORTED) : before.slice(0, -1)), { ...told, settings }];
}

/**
 * The report's entries for the last replayed recording.
 *
 * @param {import("tool/store.js").Work} loop
 * @returns {import("./messages").ReportedReplay[]}
 */
export function replaysOf(loop) {
  return loop.notes.replays ?? [];
}

/** @param {[string, string][]} found */
function showMapping(found) {
  const loop = store.loop;
  if (!loop || !recorded) return;
  const names = recorded.columns;
  const variables = loop.description.variables.map((one) => one.name);
  const uses = ["", "time", ...variables].map((name) => [name, name || "not used"]);
  const changed = names.map((column, at) => {
    const now = found.find(([name]) => name === column)?.[1] ?? "";
    const list = choice({ id: `replay-column-${at}` }, uses, now, () => {
      columns = names.flatMap((name, one) => {
        const chosen = /** @type {HTMLSelectElement} */ (document.getElementById(`replay-column-${one}`)).value;
        return chosen ? [/** @type {[string, string]} */ ([name, chosen])] : [];
      });
      replay();
    });
    return element("div.entry", element("label", { for: list.id }, column), list);
  });
  const wasOpen = mapping.querySelector("details")?.open ?? found.length === 0;
  const named = (/** @type {[string, string]} */ [column, name]) => (column === name ? name : `${column} is ${name}`);
  fill(
    mapping,
    element(
      "details",
      { open: wasOpen },
      element(
        "summary",
        `Columns: ${found.slice(0, MOST_NAMED).map(named).join(", ") || "none found"}${found.length > MOST_NAMED ? ` and ${found.length - MOST_NAMED} more` : ""}`,
      ),
      element("div.entries", changed),
    ),
  );
}

/**
 * @param {Replayed} replayed
 * @param {number | null} allowed the user's tolerance
 * @returns {{ headline: string, details: string[] }} the text shown
 */
function showResult(replayed, allowed) {
  const loop = store.loop;
  if (!loop) return { headline: "", details: [] };
  const { variables, roles } = loop.description;
  const block = { variables, controller: roles.controller, manual: manualSwitch(loop) };
  const fits = replayed.outputs.length > 0 && replayed.outputs.every((output) => output.different === 0);
  const kind = (/** @type {string} */ name) => loop.description.variables.find((one) => one.name === name);
  const told = verdict(replayed, allowed, block);
  const isSame = fits && replayed.doubt === null && replayed.settings.length === 0 && replayed.moving.length === 0;
  const found = fitting(replayed).flatMap((change) =>
    "setting" in change ? [/** @type {[string, any]} */ ([change.setting.name, change.setting.value])] : [],
  );
  const values = Object.fromEntries(found);
  fill(
    result,
    element(
      "p",
      { class: isSame ? "verdict good" : "verdict note", tabindex: -1 },
      element("strong", told.headline),
      ` ${told.details.join(" ")}`,
    ),
    found.length > 0 && element("p.row", useButton(values, "primary")),
    element(
      "ul.remarks",
      replayed.remarks.map((remark) => element("li", remark)),
    ),
    replayed.outputs.length > 0 &&
      table(
        ["Output", "First difference", "Cycles that differ", "Largest difference"],
        replayed.outputs.map((output) => [
          element("span.name", output.variable),
          output.first ? `cycle ${output.first[0]}, ${rounded(output.first[1], "REAL")} s` : "none",
          `${output.different} of ${replayed.calls}`,
          `${rounded(output.largest, "LREAL", 6)} ${unitText(kind(output.variable)?.unit)}`,
        ]),
      ),
    replayed.suspects.length > 0 &&
      element(
        "details",
        { open: !fits },
        element("summary", `Changes tried: ${replayed.suspects.length}`),
        table(
          ["Change", "Values that still differ", "Largest difference", "Settings"],
          replayed.suspects.map((suspect) => [
            `${changed(suspect, block)}.`,
            suspect.fits ? element("strong.good", "none: it fits") : String(suspect.different),
            rounded(suspect.largest, "LREAL", 6),
            // Offer a change only if no difference remains and it applies to the whole recording. The likeliest change
            // is already offered above.
            suspect.fits &&
            !suspect.since &&
            Object.keys(suspect.values).length > 0 &&
            settings(suspect.values) !== settings(values)
              ? useButton(suspect.values)
              : "",
          ]),
        ),
      ),
  );
  if (replayed.outputs.length > 0) chooseOutput(replayed);
  return told;
}

/** @param {import("./messages").Values} values @param {string} [kind] */
function useButton(values, kind = "") {
  const title = "Applies them from the next cycle and replays the recording; Undo reverts them";
  return element("button", { class: kind, title, onclick: () => take(values) }, `Apply ${settings(values)}`);
}

/** @param {import("./messages").Values} values */
function settings(values) {
  const kinds = store.loop?.settings ?? {};
  return Object.entries(values)
    .map(([name, value]) => `${name} ${shown(value, kinds[name]?.variable.kind ?? "REAL")}`)
    .join(", ");
}

/** Applies values found by a replay and replays with them. @param {import("./messages").Values} values */
async function take(values) {
  store.edit(values);
  if (!(await store.send(Object.keys(values)))) return;
  await replay(true);
  // The button that had the focus no longer exists.
  const said = result.querySelector(".verdict");
  if (said instanceof HTMLElement && document.activeElement === document.body) said.focus();
}

/**
 * Offers the curves of all outputs, and shows the output that differs in the most cycles.
 *
 * @param {Replayed} replayed
 */
function chooseOutput(replayed) {
  const chart = element("div");
  const worst = replayed.outputs.reduce((one, other) => (other.different > one.different ? other : one));
  const list = element(
    "select",
    replayed.outputs.map((output) => element("option", { selected: output === worst }, output.variable)),
  );
  drawCurve = () => {
    const output = replayed.outputs.find((one) => one.variable === list.value);
    if (!output) return;
    endChart();
    const variable = store.loop?.description.variables.find((one) => one.name === output.variable);
    const unit = unitText(variable?.unit);
    endChart = draw(chart, {
      title: `${output.variable}, recorded and computed`,
      height: Math.max(stage.clientHeight - AROUND, 120),
      xLabel: "s",
      x: output.times,
      lines: [
        { name: `${output.variable} recorded`, values: output.recorded, unit, colour: 6, isStepped: true },
        {
          name: `${output.variable} computed`,
          values: output.computed,
          unit,
          colour: 2,
          isStepped: true,
          isDashed: true,
        },
      ],
    });
  };
  list.addEventListener("change", () => drawCurve?.());
  fill(stage, element("label.row", "Recorded and computed: ", list), chart);
  showStage();
}

/**
 * @param {string[]} titles
 * @param {(string | HTMLElement)[][]} rows
 */
function table(titles, rows) {
  return element(
    "div.wide",
    { tabindex: 0, role: "region", "aria-label": titles[0] },
    element(
      "table",
      tableHead(titles),
      element(
        "tbody",
        rows.map((row) =>
          element(
            "tr",
            row.map((cell) => element("td", cell)),
          ),
        ),
      ),
    ),
  );
}
