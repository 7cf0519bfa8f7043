/**
 * The program view: the source with its errors marked, or drawn networks. During a run, the values of the variables in
 * each line are shown beside it. Values that changed since the last update are highlighted, and lines executed in the
 * displayed call have a bar at their number.
 *
 * @typedef {import("./messages").CodeBlock} Block
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").Finding} Finding
 * @typedef {import("./messages").Monitored} Monitored
 * @typedef {import("./messages").Named} Named
 * @typedef {import("./messages").Program} Program
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Line
 * @property {HTMLElement} row
 * @property {HTMLElement} values
 * @property {Block | undefined} block
 * @property {Named[]} names
 * @property {string} shown the displayed values, as text
 */

import { blockTree } from "tool/block_tree.js";
import { byId, choice, element, fill, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { isForced } from "tool/force.js";
import { follow, ladder } from "tool/ladder.js";
import { openWith } from "tool/machine.js";
import { callAt, cursorTime, momentText, momentValues } from "tool/moment.js";
import { byPath, forgetRefused, programOf, refused, translate } from "tool/program.js";
import { optionsForm } from "tool/program_options.js";
import { assumptionsForm, surveyTable } from "tool/project.js";
import { coloured, NAME } from "tool/scl.js";
import { store } from "tool/store.js";
import { declarationOf, showUsage, usesOf } from "tool/usage.js";
import { isBoolean, isTime, number, plcText } from "tool/values.js";
import { whyPanel } from "tool/why.js";

/** The type of a value that is not a number. */
const TEXT = "STRING";
/** The height of a line, in pixels; must equal the height in the style sheet. */
const HEIGHT = 20;
/** The number of lines laid out together when they become visible. */
const SECTION = 50;
/** The minimum interval between requests for values, in milliseconds. */
const PAUSE = 100;
const MOST_PROBLEMS = 50;
/** The executed lines are shown only for calls before this one, because the engine must repeat the run up to the call. */
const MOST_CALLS = 20_000;

/** @type {HTMLElement} */
let body;
/** The displayed program. @type {{ program: Program, compiled: Compiled } | undefined} */
let showing;
/** The index of the displayed source. */
let file = 0;
/** The watched instances, by the block's name in capitals. @type {Map<string, string>} */
const chosen = new Map();
/** The names of sources displayed as text although they have networks. @type {Set<string>} */
const asText = new Set();
/** The block whose networks are drawn. @type {Block | undefined} */
let drawnBlock;
/** The name of the last block that the user chose. @type {string | undefined} */
let looked;
/** @type {Line[]} */
let lines = [];
/** The lines in sections that are laid out together. @type {{ box: HTMLElement, lines: Line[] }[]} */
let sections = [];
/** @type {HTMLElement} */
let sheet;
/** The list of uses of the variable chosen in the source. @type {HTMLElement} */
let usage;
/**
 * The chosen variable, its block, and the links to its uses.
 *
 * @type {(import("tool/usage.js").Variable & { block: Block, ways: [string, import("tool/usage.js").Way[]][] }) | undefined}
 */
let selected;
/** Shows the time of the displayed values, unless it is now. @type {HTMLElement} */
let badge;
/** @type {Map<string, import("./messages").Variable>} */
let variables = new Map();
/** The panel that explains why a variable has its value. @type {HTMLElement} */
let why;
/**
 * The program's activity in the last call or in the call at the cursor; the next three variables say for which it was
 * fetched.
 *
 * @type {Monitored | undefined}
 */
let monitored;
/** The cursor position of `monitored`. @type {number | undefined} */
let monitoredAt;
/** @type {number | undefined} */
let monitoredRun;
/** The block and instance whose networks `monitored` covers. */
let monitoredOf = "";
/** Whether a request for values is pending. */
let isAsking = false;
/** @type {string} */
let drawn = "";

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div.program");
  why = whyPanel();
  usage = element("div.row.usage", { role: "status", hidden: true });
  content.append(body);
  for (const what of ["loop", "program"]) store.on(what, show);
  for (const what of ["state", "run", "moment"]) store.on(what, due);
  for (const what of ["moment", "forced"]) store.on(what, update);
  store.on("failure", () => {
    if (programOf(store.loop)) store.emit("show", "program");
    draw();
  });
  store.on("tab", due);
  store.on("line", goTo);
  show();
}

/** Shows the loop's program, or the last rejected program. */
function show() {
  const bad = refused();
  const [was, before] = [showing, showing?.compiled];
  showing = bad ?? programOf(store.loop);
  variables = store.loop ? byPath(store.loop) : new Map();
  monitored = selected = undefined;
  usage.hidden = true;
  const { compiled } = showing ?? {};
  // After its source was edited and reopened, a program stays at the same place.
  const isAgain = before !== undefined && before.block === compiled?.block;
  const kept = isAgain ? compiled.sources.findIndex((one) => one.file === before.sources[file]?.file) : -1;
  if (kept < 0) {
    isBrought = false;
    openedAt = undefined;
  }
  document.body.classList.toggle("has-program", showing !== undefined);
  document.body.classList.toggle("has-refused", bad !== undefined);
  // Only a program with a controller has metrics, a diagram and a replay.
  const isController = compiled?.parts.some((part) => part.is_native) ?? true;
  document.body.classList.toggle("has-no-controller", !isController);
  const wrong = compiled?.sources.findIndex(({ file }) => file === firstProblem()?.file) ?? -1;
  file = wrong >= 0 ? wrong : kept >= 0 ? kept : (runBlock()?.file ?? 0);
  // Without a loop there are no panels, so the first page shows a rejected program.
  const place = store.loop ? byId("program") : byId("refused");
  byId("refused").hidden = !bad || store.loop !== undefined;
  place.querySelector(".content")?.append(body);
  // A new program triggers the events `loop` and `program`: create its lines only once.
  if (showing !== was) drawn = "";
  draw();
  const first = firstProblem();
  if (bad && first?.place) goTo(first);
  due();
}

/** The block that runs as the program. */
function runBlock() {
  const { compiled } = showing ?? {};
  return compiled?.blocks.find(({ name }) => same(name, compiled.block));
}

/** The first error in the displayed program. */
function firstProblem() {
  return showing?.compiled.problems.find((one) => one.is_error && one.place);
}

/**
 * The error that ended the run, if it is in a line of a source.
 *
 * @returns {{ file: string, line: number, text: string } | undefined}
 */
function stopped() {
  const failure = store.isLive() && !refused() ? store.state?.failure : undefined;
  if (!failure || !showing) return undefined;
  for (const { file: name } of showing.compiled.sources) {
    const at = failure.indexOf(`${name}:`);
    const place = at < 0 ? null : /^:(\d+): (.*)$/s.exec(failure.slice(at + name.length));
    if (place) return { file: name, line: Number(place[1]), text: place[2] };
  }
  return undefined;
}

function draw() {
  if (!showing) {
    drawn = "";
    lines = sections = [];
    fill(body, element("p.faint", "This loop's controller is a block, not a program: drop program sources (.scl)."));
    return;
  }
  const stop = stopped();
  const key = JSON.stringify([
    ...[showing.compiled.fmu, file, [...chosen], stop, store.loop?.id, refused() !== undefined],
    [[...asText], looked],
  ]);
  // A rejected program is always redrawn, because it has no name to compare.
  if (key === drawn && !refused()) return;
  drawn = key;
  const { compiled } = showing;
  const source = compiled.sources[file];
  if (stop && source.file !== stop.file) {
    file = compiled.sources.findIndex((one) => one.file === stop.file);
    draw();
    return;
  }
  const top = sheet?.isConnected ? topLine() : -1;
  const networked = withNetworks();
  drawnBlock = asText.has(source.file) || stop || refused() ? undefined : networked;
  sheet = element("div.source", { tabindex: 0, role: "region", "aria-label": `Source ${source.file}` });
  const texts = source.text.split(/\r\n|\n|\r/);
  const looks = coloured(texts);
  const own = compiled.blocks.filter((one) => one.file === file);
  /** The variables named in each line. @type {Map<number, Named[]>} */
  const names = new Map();
  for (const named of own.flatMap((one) => one.names)) names.set(named.line, [...(names.get(named.line) ?? []), named]);
  lines = texts.map((text, at) => {
    const block = own.findLast((one) => one.line <= at + 1);
    return line(text, at + 1, looks[at], block, names.get(at + 1) ?? []);
  });
  sections = [];
  for (let from = 0; from < lines.length; from += SECTION) {
    const some = lines.slice(from, from + SECTION);
    const box = element(
      "div.source-section",
      some.flatMap(({ row }, at) => [row, ...notesOf(source.file, from + at + 1)]),
    );
    box.style.setProperty("--lines", String(some.length));
    sections.push({ box, lines: some });
  }
  fill(
    sheet,
    sections.map(({ box }) => box),
  );
  sheet.style.setProperty("--digits", String(String(lines.length).length));
  sheet.addEventListener("scroll", update);
  // A click on a value explains it; a click on a name lists its uses.
  sheet.addEventListener("click", ({ target }) => {
    const value = target instanceof Element ? target.closest("[data-name]") : null;
    if (value instanceof HTMLElement) store.emit("why", value.dataset.name);
    if (target instanceof HTMLElement && target.classList.contains(NAME)) choose(target);
  });
  sheet.addEventListener("keydown", keyOfName);
  // If several blocks could run, that is a question, not an error.
  fill(
    body,
    ...[head(), why, surveyTable(compiled), assumptionsForm(showing.program, compiled, again)],
    compiled.candidates.length > 1 ? null : problems(compiled.problems),
    ...(drawnBlock ? [ladder(drawnBlock, (of) => wayTo(drawnBlock, of))] : [usage, sheet]),
  );
  if (top > 0) toTop(lines[top]);
  if (stop) lines[stop.line - 1]?.row.scrollIntoView({ block: "center" });
  update();
}

/** The head above the source: lists to choose the source and the instance, and the options. */
function head() {
  badge = element("span.mode");
  const { compiled, program } = /** @type {NonNullable<typeof showing>} */ (showing);
  const isRefused = compiled.fmu === null;
  const sources = compiled.sources.flatMap((one, at) => (isText(one) ? [] : [[String(at), one.file]]));
  const files = choice({ "aria-label": "Source" }, sources, String(file), (at) => {
    file = Number(at);
    draw();
  });
  const choices = compiled.candidates.map((name) =>
    element("button.primary", { onclick: () => again({ ...program, run: name }) }, `Run ${name}`),
  );
  // If there are two candidates, offer to run each with the other as its plant.
  const pairs = compiled.candidates.flatMap((machine) =>
    compiled.candidates.filter((plant) => plant !== machine).map((plant) => [machine, plant]),
  );
  const both = (pairs.length === 2 ? pairs : []).map(([machine, plant]) =>
    element(
      "button",
      { onclick: () => openWith(program, machine, plant).catch(store.say) },
      `Run ${machine} with ${plant} as its plant`,
    ),
  );
  return element(
    "div.row.program-head",
    element("strong", isRefused ? (choices.length > 0 ? "Which block runs?" : "Not translated") : compiled.block),
    compiled.sources.filter((one) => !isText(one)).length < 2
      ? element("span.faint", compiled.sources[0]?.file)
      : files,
    isRefused ? null : blockTree(compiled, look),
    isRefused ? null : instances(compiled),
    isRefused || !withNetworks() ? null : textButton(compiled.sources[file].file),
    badge,
    choices,
    both,
    optionsForm(program, compiled, again),
    isRefused &&
      element(
        "button",
        { onclick: () => forgetRefused() },
        store.loop && programOf(store.loop) ? "Back to the running program" : "Close",
      ),
  );
}

/**
 * The block in the displayed source whose networks can be drawn: the block that the user chose, else the block that
 * runs, else the first.
 */
function withNetworks() {
  const all = showing?.compiled.blocks.filter((one) => one.file === file && one.networks.length > 0) ?? [];
  return all.find(({ name }) => name === looked) ?? all.find((one) => one === runBlock()) ?? all[0];
}

/** Shows a block in the instance at a path. @param {string} name @param {string | undefined} path */
function look(name, path) {
  const of = showing?.compiled.blocks.find((one) => same(one.name, name));
  if (!of) return;
  file = of.file;
  looked = of.name;
  if (path !== undefined) chosen.set(name.toUpperCase(), path);
  openedAt = -1;
  draw();
  if (!drawnBlock) lines[of.line - 1]?.row.scrollIntoView({ block: "start" });
  due();
}

/**
 * Whether a source contains only the texts of another document, with which they are shown.
 *
 * @param {{ file: string }} of
 */
function isText({ file: name }) {
  return /\.s7res$/i.test(name);
}

/** A button that switches between text and networks. @param {string} name */
function textButton(name) {
  const isShown = asText.has(name);
  const change = () => {
    if (isShown) asText.delete(name);
    else asText.add(name);
    draw();
    due();
  };
  return element("button", { "aria-pressed": String(isShown), onclick: change }, "Text");
}

/** @param {Program} program */
function again(program) {
  return translate(program, programOf(store.loop) ? store.loop : undefined).catch(store.say);
}

/**
 * For each block in the displayed source with several instances: a list to choose the watched instance.
 *
 * @param {Compiled} compiled
 */
function instances(compiled) {
  const parts = compiled.parts.filter((part) => !part.is_native);
  return compiled.blocks.flatMap((block) => {
    const own = parts.filter((part) => same(part.block, block.name));
    if (block.file !== file || own.length < 2) return [];
    const about = { "aria-label": `Instance of ${block.name}`, title: `The ${block.name} to watch` };
    const paths = own.map(({ path }) => [path]);
    const list = choice(about, paths, instanceOf(block), (path) => {
      chosen.set(block.name.toUpperCase(), path);
      lines.find((one) => one.block === block)?.row.scrollIntoView({ block: "start" });
      due();
    });
    return list;
  });
}

/** @param {string} one @param {string} other */
function same(one, other) {
  return one.toUpperCase() === other.toUpperCase();
}

/**
 * The path of a block's watched instance; `undefined` for a function.
 *
 * @param {Block} block
 */
function instanceOf(block) {
  const own = (showing?.compiled.parts ?? []).filter((part) => !part.is_native && same(part.block, block.name));
  const wanted = chosen.get(block.name.toUpperCase());
  return (own.find((part) => part.path === wanted) ?? own[0])?.path;
}

/**
 * The list of problems, each with a link to its line.
 *
 * @param {Finding[]} all
 */
function problems(all) {
  if (all.length === 0) return null;
  const errors = all.filter((one) => one.is_error).length;
  const count = (/** @type {number} */ of, /** @type {string} */ what) => `${of} ${of === 1 ? what : `${what}s`}`;
  const title = errors > 0 ? count(errors, "error") : count(all.length, "remark");
  const item = (/** @type {Finding} */ one) => {
    const place = one.place ? `${one.file}, line ${one.place[0]}: ` : "";
    const help = one.help ? element("span.help", ` ${one.help}`) : null;
    const words = [element("span", { class: one.is_error ? "error" : "note" }, place + one.message), help];
    return element("li", one.place ? element("button.plain.finding", { onclick: () => goTo(one) }, ...words) : words);
  };
  return element(
    "details.findings",
    { open: errors > 0 },
    element("summary", { class: errors > 0 ? "error" : "note" }, title),
    element("ul", all.slice(0, MOST_PROBLEMS).map(item)),
    all.length > MOST_PROBLEMS && element("p.faint", `and ${all.length - MOST_PROBLEMS} more`),
  );
}

/** @param {Pick<Finding, "file" | "place">} one */
function goTo({ file: name, place }) {
  if (!place || !showing) return;
  const at = showing.compiled.sources.findIndex((source) => source.file === name);
  if (at >= 0 && at !== file) {
    file = at;
    draw();
  }
  const network = drawnBlock?.networks.findLast(({ line }) => line <= place[0]);
  // Declarations are only in the text.
  if (drawnBlock && !network) {
    asText.add(showing.compiled.sources[file].file);
    draw();
  }
  for (const one of body.querySelectorAll(".network")) {
    const isIt = one instanceof HTMLElement && Number(one.dataset.network) === network?.number;
    one.classList.toggle("is-target", isIt);
    if (isIt) one.scrollIntoView({ block: "center" });
  }
  const row = lines[place[0] - 1]?.row;
  row?.scrollIntoView({ block: "center" });
  for (const other of lines) other.row.classList.toggle("is-target", other.row === row);
}

/**
 * A link to the declaration of a variable, if a source contains it.
 *
 * @param {Block | undefined} block
 * @param {import("tool/usage.js").Variable} of
 */
function wayTo(block, of) {
  const spot = showing && block && declarationOf(showing.compiled, block, of);
  return spot && way(spot, "declares");
}

/** A link to a line. @param {import("tool/usage.js").Spot} spot @param {string} word */
function way({ file: at, line }, word) {
  const name = showing?.compiled.sources[at]?.file ?? "";
  const label = at === file ? `line ${line}` : `${name}, line ${line}`;
  return { label, title: `${label} ${word} it`, go: () => goTo({ file: name, place: [line, 1] }) };
}

/** Chooses the variable to which a name in the source refers. @param {HTMLElement} target */
function choose(target) {
  const row = target.closest("[data-line]");
  const at = row instanceof HTMLElement ? Number(row.dataset.line) : 0;
  const name = (target.textContent ?? "").replace(/^#|"/g, "");
  const block = lines[at - 1]?.block;
  if (!block) return;
  const parts = (/** @type {string} */ path) => path.split(/[.[\],]+/).map((part) => part.toUpperCase());
  const wanted = name.toUpperCase();
  const named = lines[at - 1].names.filter(({ path }) => parts(path).includes(wanted));
  // Prefer the variable itself, then a variable whose path begins with the name, then one whose path ends with it.
  const rank = (/** @type {Named} */ { path }) =>
    path.toUpperCase() === wanted ? 0 : parts(path)[0] === wanted ? 1 : parts(path).at(-1) === wanted ? 2 : 3;
  const best = named.toSorted((one, other) => rank(one) - rank(other))[0];
  const isOwn = block.declared.some(([one]) => one.toUpperCase() === wanted);
  const path = best && rank(best) < 3 ? best.path : name;
  const variable = { path, isGlobal: best?.is_global ?? !isOwn };
  selected = { ...variable, block, ways: waysTo(block, variable) };
  for (const one of sheet.querySelectorAll(".is-selected")) one.classList.remove("is-selected");
  target.classList.add("is-selected");
  showSelected();
}

/**
 * Links to the declaration, the writers and the readers of a variable.
 *
 * @param {Block} block
 * @param {import("tool/usage.js").Variable} of
 * @returns {[string, import("tool/usage.js").Way[]][]}
 */
function waysTo(block, of) {
  if (!showing) return [];
  const declared = wayTo(block, of);
  const { writers, readers } = usesOf(showing.compiled, block, of);
  return [
    ["declared", declared ? [declared] : []],
    ["written", writers.map((spot) => way(spot, "writes"))],
    ["read", readers.map((spot) => way(spot, "reads"))],
  ];
}

/** Shows the current value and the uses of the chosen variable. */
function showSelected() {
  usage.hidden = selected === undefined;
  if (!selected) return;
  const { block, path, isGlobal, ways } = selected;
  showUsage(usage, path, store.isLive() ? valueNow(block, path, isGlobal) : undefined, ways);
}

/**
 * In the source, Enter moves to the first visible name; arrow keys move from name to name.
 *
 * @param {KeyboardEvent} event
 */
function keyOfName(event) {
  const { key, target } = event;
  if (!(target instanceof HTMLElement) || event.ctrlKey || event.altKey || event.metaKey) return;
  const isName = target.classList.contains(NAME);
  const all = [...sheet.querySelectorAll(`.${NAME}`)];
  const top = sheet.getBoundingClientRect().top;
  /** @type {Element | undefined} */
  let next;
  if (isName && key === "ArrowLeft") next = all[all.indexOf(target) - 1];
  else if (isName && key === "ArrowRight") next = all[all.indexOf(target) + 1];
  else if (target === sheet && key === "Enter") next = all.find((one) => one.getBoundingClientRect().top >= top);
  else if (isName && key === "Escape") next = sheet;
  else if (!isName || (key !== "Enter" && key !== " ")) return;
  event.preventDefault();
  if (next instanceof HTMLElement) next.focus();
  else if (key === "Enter" || key === " ") choose(target);
}

/**
 * A source line.
 *
 * @param {string} text
 * @param {number} at
 * @param {(string | HTMLElement)[]} look
 * @param {Block | undefined} block
 * @param {Named[]} names
 * @returns {Line}
 */
function line(text, at, look, block, names) {
  const { compiled } = /** @type {NonNullable<typeof showing>} */ (showing);
  const found = compiled.problems.filter((one) => one.place?.[0] === at && one.file === compiled.sources[file].file);
  const values = element("span.values");
  const row = element(
    "div",
    {
      class: ["line", found.some((one) => one.is_error) && "is-wrong", found.length > 0 && "has-note"]
        .filter(Boolean)
        .join(" "),
      "data-line": at,
    },
    element("span.line-number", at),
    element("code", { title: text.length > 60 ? text.trim() : null }, found.length > 0 ? marked(text, found) : look),
    values,
  );
  return { row, values, block, names, shown: "" };
}

/**
 * The text of a line with its problems marked.
 *
 * @param {string} text
 * @param {Finding[]} found
 */
function marked(text, found) {
  const parts = [];
  let from = 0;
  const letters = [...text];
  for (const one of found.toSorted((a, b) => (a.place?.[1] ?? 0) - (b.place?.[1] ?? 0))) {
    const start = (one.place?.[1] ?? 1) - 1;
    if (start < from) continue;
    const end = start + Math.max(one.length, 1);
    parts.push(letters.slice(from, start).join(""));
    const about = { class: one.is_error ? "is-error" : "is-note", title: one.message };
    parts.push(element("mark", about, letters.slice(start, end).join("") || " "));
    from = end;
  }
  return [...parts, letters.slice(from).join("")];
}

/**
 * The notes below a line: errors with remedies, and the reason if the program stopped there.
 *
 * @param {string} name
 * @param {number} at
 */
function notesOf(name, at) {
  const { compiled } = /** @type {NonNullable<typeof showing>} */ (showing);
  const own = compiled.problems.filter((one) => one.is_error && one.file === name && one.place?.[0] === at);
  const told = own.map((one) =>
    element("p.line-note", element("span.error", one.message), one.help && element("span.help", ` ${one.help}`)),
  );
  const stop = stopped();
  if (stop?.file === name && stop.line === at) {
    const restart = () => store.begin().then(draw).catch(store.say);
    told.push(
      element(
        "p.line-note.is-stop",
        element("span.error", `Stopped here: ${stop.text} `),
        element("button.restart", { onclick: restart }, "Restart"),
      ),
    );
  }
  return told;
}

/** Fetches and shows the values if the program tab is visible, then pauses. */
async function due() {
  if (isAsking || !showing || refused() || document.body.dataset.tab !== "program") return;
  isAsking = true;
  const loop = store.loop;
  askedState = store.isLive() ? store.state : undefined;
  const time = cursorTime();
  askedTime = time;
  try {
    draw();
    const call = time === undefined ? null : callAt(time);
    const run = store.state?.run;
    /** @type {[string, string] | null} */
    const networks = drawnBlock ? [drawnBlock.name, instanceOf(drawnBlock) ?? ""] : null;
    const of = String(networks);
    // The activity of an earlier call does not change.
    const isSame = monitoredAt === time && monitoredRun === run && monitoredOf === of;
    const isKnown = call !== null && monitored !== undefined && isSame;
    if (loop && store.isLive() && (call ?? 0) < MOST_CALLS && !isKnown) {
      const told = await ask({ do: "monitor", member: loop.member, call, networks });
      if (store.loop === loop) [monitored, monitoredAt, monitoredRun, monitoredOf] = [told, time, run, of];
    }
  } catch (error) {
    store.say(error);
  }
  requestAnimationFrame(() => {
    update();
    setTimeout(() => {
      isAsking = false;
      if (isBehind()) due();
    }, PAUSE);
  });
}

/** Whether the executed lines of this program have already been scrolled into view. */
let isBrought = false;
/**
 * The index of the topmost line after the source was opened at its code; `undefined` if it has not been opened there.
 *
 * @type {number | undefined}
 */
let openedAt;
/** The state whose values are displayed. @type {unknown} */
let shownState;
/** @type {unknown} */
let askedState;
/** @type {number | undefined} */
let askedTime;

function isBehind() {
  return askedState !== (store.isLive() ? store.state : undefined) || askedTime !== cursorTime();
}

/** The program's activity in the displayed call, if it is known yet. */
function monitoredNow() {
  return monitoredAt === cursorTime() ? monitored : undefined;
}

/** Shows the values of the visible lines. */
function update() {
  if (!showing || refused() || !badge) return;
  const state = store.isLive() ? store.state : undefined;
  showSelected();
  text(badge, momentText());
  badge.hidden = cursorTime() === undefined;
  const isNext = shownState !== state;
  shownState = state;
  const run = new Set((state && monitoredNow())?.lines.filter(([of]) => of === file).map(([, at]) => at));
  if (drawnBlock) {
    const wires = new Map(state && monitoredNow()?.wires);
    follow({
      wires,
      lines: run,
      value: (path, isGlobal) => (state ? valueNow(drawnBlock, path, isGlobal) : undefined),
    });
  }
  if (!sheet?.isConnected) return;
  openAtCode();
  bringRunLines(run);
  for (const one of inSight(HEIGHT)) {
    one.row.classList.toggle("has-run", state !== undefined && run.has(Number(one.row.dataset.line)));
    if (one.names.length > 0) showValues(one, state, isNext);
  }
}

/**
 * The visible lines. They are all found before any is changed, so that the browser computes the layout only once.
 *
 * @param {number} margin
 */
function inSight(margin) {
  const { top, bottom } = sheet.getBoundingClientRect();
  const isIn = (/** @type {HTMLElement} */ of) => {
    const box = of.getBoundingClientRect();
    return box.bottom > top - margin && box.top < bottom + margin;
  };
  return sections.filter(({ box }) => isIn(box)).flatMap(({ lines }) => lines.filter(({ row }) => isIn(row)));
}

/** Opens the source at the block that runs, below types and declarations, unless there are errors. */
function openAtCode() {
  if (openedAt !== undefined || sheet.clientHeight === 0 || firstProblem()) return;
  const block = runBlock();
  if (block?.file === file && sheet.scrollTop === 0) toTop(lines[block.line - 1]);
  openedAt = topLine();
}

/** Scrolls a line to the top. @param {Line | undefined} of */
function toTop(of) {
  if (of) sheet.scrollTop += of.row.getBoundingClientRect().top - sheet.getBoundingClientRect().top;
}

/** The index of the topmost visible line. Unlike the scroll position, it does not change when lines above are laid out. */
function topLine() {
  return lines.indexOf(inSight(-2)[0]);
}

/**
 * Scrolls the first executed line into view, unless the user has scrolled. Otherwise, declarations might fill the
 * visible part.
 *
 * @param {Set<number>} run
 */
function bringRunLines(run) {
  if (isBrought || run.size === 0) return;
  isBrought = true;
  const block = runBlock();
  // Ignore lines of a function above the block, although they are executed, too.
  const begin = block?.file === file ? block.line : 1;
  const first = lines[Math.min(...[...run].filter((at) => at >= begin)) - 1];
  if (!first || topLine() !== openedAt) return;
  if (first.row.getBoundingClientRect().bottom > sheet.getBoundingClientRect().bottom) toTop(first);
}

/**
 * @param {Line} one
 * @param {import("./messages").State | undefined} state
 * @param {boolean} isNext whether there has been a call since the last update
 */
function showValues(one, state, isNext) {
  const found = state ? one.names.flatMap((named) => value(one, named) ?? []) : [];
  const shown = JSON.stringify(found);
  if (shown === one.shown) {
    if (isNext)
      for (const changed of one.values.querySelectorAll(".is-changed")) changed.classList.remove("is-changed");
    return;
  }
  const before = new Map(
    one.shown ? JSON.parse(one.shown).map((/** @type {string[]} */ [path, text]) => [path, text]) : [],
  );
  one.shown = shown;
  fill(
    one.values,
    found.map(([path, text, kind, name, held]) => {
      const isChanged = before.has(path) && before.get(path) !== text;
      const look = isBoolean(kind) ? (text === "TRUE" ? "is-true" : "is-false") : "";
      return element(
        "span",
        {
          class: `value ${look}${isChanged ? " is-changed" : ""}${held ? " is-forced" : ""}`,
          title: `${path} = ${text}${held ? ", forced" : ""}`,
          "data-name": name || null,
        },
        // The name is needed: beside a NOT, a bare value would look like the value of the condition.
        element("span.faint", `${lastName(path)} `),
        text,
      );
    }),
  );
}

/** @param {string} path */
function lastName(path) {
  return path.slice(path.lastIndexOf(".") + 1);
}

/**
 * The displayed value of a variable named in a line: path, value as text, type, name in the run, and whether it is
 * forced; all as strings, to be compared as JSON.
 *
 * @param {Line} one
 * @param {Named} named
 * @returns {[string, string, string, string, string][] | undefined}
 */
function value({ block }, named) {
  const found = valueNow(block, named.path, named.is_global);
  return found && [[named.path, found.text, found.kind, found.name ?? "", found.isForced ? "forced" : ""]];
}

/**
 * The displayed value of a variable: its type, the value as text, its name if the run records it, and whether it is
 * forced.
 *
 * @param {Block | undefined} block
 * @param {string} path
 * @param {boolean} isGlobal
 */
function valueNow(block, path, isGlobal) {
  const found = find(block, path, isGlobal);
  if (!found) return undefined;
  const [kind, now, name] = found;
  const text = kind === TEXT ? `'${now}'` : plcText(now, kind);
  return { kind, text, name, isForced: name !== undefined && isForced(name) };
}

/**
 * Finds a variable by its path, in the block's watched instance or globally. Returns its type, its value, and its name
 * if the run records it.
 *
 * @param {Block | undefined} block
 * @param {string} path
 * @param {boolean} isGlobal
 * @returns {[string, import("./messages").Value, string?] | undefined}
 */
function find(block, path, isGlobal) {
  const loop = store.loop;
  const { compiled } = showing ?? {};
  if (!block || !loop || !compiled || !store.state) return undefined;
  // Replace a variable used as an index by its value.
  let isKnown = true;
  const plain = path.replace(/\[([^\]]*)\]/g, (_, indices) => {
    const known = indices.split(",").map((/** @type {string} */ index) => {
      if (/^-?\d+$/.test(index.trim())) return index.trim();
      const of = find(block, index.trim(), isGlobal);
      isKnown &&= of !== undefined;
      return of ? String(number(of[1])) : "";
    });
    return `[${known.join(",")}]`;
  });
  if (!isKnown) return undefined;
  const prefix = instanceOf(block);
  // A function's own variables no longer exist after its call; a variable of the program with the same name is a
  // different one.
  if (prefix === undefined && !isGlobal) return undefined;
  const own = prefix ? `${prefix}.${plain}` : plain;
  const candidates = isGlobal ? [plain] : [own];
  for (const candidate of candidates) {
    const variable = variables.get(candidate.toUpperCase());
    const name = variable && `${loop.member}.${variable.name}`;
    const now = name === undefined ? undefined : momentValues()[name];
    if (variable && now !== undefined) return [variable.kind, now, name];
    const texts = Object.entries(monitoredNow()?.texts ?? {});
    const text = texts.find(([name]) => same(name, candidate));
    if (text) return [TEXT, /** @type {any} */ (text[1])];
  }
  // Only temporaries of the main block are known: those of inner blocks no longer exist.
  const temp = prefix === "" ? block.temps.find(([name]) => same(name, plain)) : undefined;
  const temps = monitoredNow()?.temps ?? {};
  const name = temp && Object.keys(temps).find((one) => same(one, plain));
  if (!temp || !name) return undefined;
  const now = temps[name];
  return isTime(temp[1]) ? ["TIME", number(now) / 1000] : [temp[1], now];
}
