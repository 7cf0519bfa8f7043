/**
 * Explains why a variable has its value: by the statement that wrote it last, the conditions under which that statement
 * ran, and the operands of both, each of which can be explained in turn. The engine records which statements ran in a
 * call and which operands decided; other values are those at the end of the call.
 *
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").Decision} Decision
 * @typedef {import("./messages").Named} Named
 * @typedef {import("./messages").Values} Values
 * @typedef {import("./messages").Write} Write
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Found a statement that may write the variable
 * @property {Write} write
 * @property {string} file
 * @property {number} source index of its source
 * @property {string} block its block
 * @property {number} number index of the write in its block
 * @property {string} instance its instance
 * @property {string} prefix path of that instance with a dot; empty for the program itself and for global variables
 * @property {[string, string][]} constants constants of its block, with their values
 * @property {import("./messages").Network[]} networks networks of its block
 *
 * @typedef {object} Call the known facts about a call
 * @property {number} call
 * @property {Values} values at its end
 * @property {import("./messages").Value | null} [before] the explained variable's value before the call
 * @property {number} [first] the first line that wrote it in the call: statements up to this line read `before`
 * @property {import("./messages").Monitored} monitored
 * @property {[string, string][]} looked the blocks for which decisions were requested, each with its instance
 */

import { element, fill } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { forcedSpans } from "tool/force.js";
import { placeOf, tracks } from "tool/history.js";
import { callAt, cursorTime, timeOf, valuesAt } from "tool/moment.js";
import { programNamed } from "tool/program.js";
import { called } from "tool/signals.js";
import { isSettable, split, store } from "tool/store.js";
import { plcText } from "tool/values.js";

/**
 * The executed statements are known only for calls before this one, because the engine must repeat the run up to the
 * call.
 */
const MOST_CALLS = 20_000;
/** The maximum number of statements listed that ran, and of those that did not. */
const MOST_LISTED = 6;

/** @type {HTMLElement} */
let place;
/**
 * The questions asked so far, the latest last. Each is for a call; by default, the call at the cursor or the last one.
 *
 * @type {{ name: string, call?: number }[]}
 */
let asked = [];
/** The call whose decisions are marked in the networks. @type {number | undefined} */
let marked;

/** Creates the panel for the answers. */
export function whyPanel() {
  place = element("section.why", { "aria-live": "polite", hidden: true });
  store.on("why", (/** @type {string} */ name) => {
    asked = [];
    store.emit("show", "program");
    answer(name);
  });
  store.on("loop", close);
  // Remove the marks from the networks when another call is displayed.
  for (const what of ["cursor", "state"])
    store.on(what, () => marked !== undefined && marked !== shownCall() && unmark());
  return place;
}

function close() {
  place.hidden = true;
  asked = [];
  unmark();
}

function unmark() {
  marked = undefined;
  store.emit("decided");
}

/** The displayed call. */
function shownCall() {
  const time = cursorTime();
  return time === undefined ? (store.state?.calls ?? 0) - 1 : callAt(time);
}

/** @param {string} name @param {number} [of] the call; by default, the displayed one */
async function answer(name, of) {
  const loop = store.loop;
  const state = store.isLive() ? store.state : undefined;
  if (!loop || !state || state.calls === 0) return;
  const last = asked.at(-1);
  if (last?.name !== name || last.call !== of) asked.push({ name, call: of });
  try {
    const call = of ?? shownCall();
    const told = await explained(loop, name, call);
    place.hidden = false;
    const back = () => {
      asked.pop();
      const before = asked.pop();
      if (before) answer(before.name, before.call);
    };
    fill(
      place,
      element(
        "div.row",
        asked.length > 1 && element("button", { onclick: back }, "Back"),
        told[0],
        element("button.plain", { "aria-label": "Close the answer", onclick: close }, "×"),
      ),
      ...told.slice(1),
    );
    place.scrollTop = 0;
  } catch (error) {
    store.say(error);
  }
}

/**
 * The explanation of a variable's value in a call.
 *
 * @param {Work} loop
 * @param {string} name
 * @param {number} call
 * @returns {Promise<HTMLElement[]>} beginning with a heading
 */
async function explained(loop, name, call) {
  unmark();
  const state = /** @type {NonNullable<typeof store.state>} */ (store.state);
  const track = (await tracks([name], state)).get(name);
  const changed = track ? track.calls[placeOf(track, call)] : undefined;
  const now = await valuesAt(call);
  const [member, own] = split(name);
  const fmu = member === loop.member ? loop.description.name : loop.members.find((one) => one.name === member)?.fmu;
  const variable = fmu ? (await store.describe(fmu)).variables.find((one) => one.name === own) : undefined;
  const title = `Why is ${called(loop, name)} ${plcText(now[name], variable?.kind ?? "")} at ${timeOf(call)} s?`;
  const heading = element("strong", title);
  const since = changed ? ` since ${timeOf(changed)} s` : " since the beginning of the run";
  const says = (/** @type {(string | HTMLElement)[]} */ ...parts) => [heading, element("p", ...parts)];
  const span = forcedSpans(name).findLast(([first, end]) => first <= call && call < end);
  if (span) return says(`It has been forced since ${timeOf(span[0])} s.`);
  const wire = loop.connections.find(([, to]) => to === name);
  if (wire) return says("It comes from ", operand(loop, wire[0], now, call), ".");
  if (variable && isSettable(variable))
    return says(`It is an input or parameter that you set: it has had this value${since}.`);
  const of = fmu ? programNamed(fmu) : undefined;
  if (!of)
    return says(`${member} is not a program, so its statements are unknown. The variable has had this value${since}.`);
  if (call >= MOST_CALLS) return says(`Which statements ran is known only for the first ${MOST_CALLS} cycles.`);
  const all = writesOf(of.compiled, own);
  if (all.length === 0) return says("No statement of the program writes it: it has its start value.");
  // Use the statements that ran in this call or, if there are none, in the call that last changed the variable.
  let at = await callOf(member, call, all);
  if (!all.some((one) => hasRun(at, one)) && changed) at = await callOf(member, changed, all);
  const ran = all.filter((one) => hasRun(at, one)).reverse();
  at.before = at.call > 0 ? (await valuesAt(at.call - 1))[name] : variable?.start;
  at.first = Math.min(...ran.map(({ write }) => write.line));
  const others = all.filter((one) => !ran.includes(one) && guardsOf(one.write, false).length > 0);
  const answers = [heading];
  const nothing = `No statement has written it${changed ? "" : " in this run: it has its start value"}.`;
  if (ran.length === 0) answers.push(element("p", nothing));
  for (const [place, one] of ran.slice(0, MOST_LISTED).entries())
    answers.push(
      statement(loop, member, one, at, place === 0 ? `At ${timeOf(at.call)} s this wrote it:` : "Before it:", name),
    );
  for (const one of others.slice(0, MOST_LISTED))
    answers.push(statement(loop, member, one, at, "This did not run:", name));
  mark(ran[0] ?? others[0], at);
  answers.push(
    element(
      "p.faint",
      "Booleans in a condition are shown as evaluated there, and the variable itself as read by the first statement that wrote it; all other values are those at the end of the cycle.",
    ),
  );
  return answers;
}

/** @param {string} member @param {number} call @param {Found[]} all @returns {Promise<Call>} */
async function callOf(member, call, all) {
  const values = await valuesAt(call);
  const each = new Map(
    all.map(({ block, instance }) => [`${block} ${instance}`, /** @type {[string, string]} */ ([block, instance])]),
  );
  const looked = [...each.values()];
  return { call, values, looked, monitored: await ask({ do: "monitor", member, call, why: looked }) };
}

/** The recorded decisions for a statement, if there are any. @param {Call} at @param {Found} of */
function decisionsOf({ looked, monitored }, { block, instance, number }) {
  const asked = looked.findIndex((one) => one[0] === block && one[1] === instance);
  return monitored.decided[asked]?.[number];
}

/** Marks the deciding operands in the networks. @param {Found | undefined} of @param {Call} at */
function mark(of, at) {
  const { value, guards } = (of && decisionsOf(at, of)) ?? { value: null, guards: [] };
  const wires = [value, ...guards].flatMap((one) => one?.wires ?? []);
  marked = at.call;
  store.emit("decided", of && { block: of.block, wires: new Set(wires) });
}

/** @param {Call} at @param {Found} of */
function hasRun({ monitored }, { source, write }) {
  return monitored.lines.some(([file, line]) => file === source && line === write.line);
}

/** @param {string} text */
function plain(text) {
  return text.replaceAll("'", "").toUpperCase();
}

/**
 * The statements that may write a variable: those that name it or, if there are none, those that write the structure or
 * call the instance that contains it.
 *
 * @param {Compiled} compiled
 * @param {string} own
 * @returns {Found[]}
 */
function writesOf(compiled, own) {
  const wanted = plain(own);
  const all = compiled.blocks.flatMap((block) => {
    const parts = compiled.parts.filter((part) => plain(part.block) === plain(block.name));
    const instances = parts.map(({ path }) => path);
    // It is unknown which of several instances wrote a global variable, and a function has no instance.
    const global = [instances.length === 1 ? instances[0] : ""];
    return block.writes.flatMap((write, number) =>
      (write.is_global ? global : instances).map((instance) => {
        const prefix = instance && !write.is_global ? `${instance}.` : "";
        return {
          ...{ write, number, instance, prefix },
          block: block.name,
          constants: block.constants,
          networks: block.networks,
          source: block.file,
          ...compiled.sources[block.file],
          path: plain(prefix + write.path),
        };
      }),
    );
  });
  // An index that is a variable may have any value, so all indices are considered equal.
  const fits = (/** @type {string} */ path) =>
    path === wanted ||
    (path.includes("[") && path.replace(/\[[^\]]*\]/g, "[]") === wanted.replace(/\[[^\]]*\]/g, "[]"));
  const named = all.filter(({ path }) => fits(path));
  return named.length > 0 ? named : all.filter(({ path }) => wanted.startsWith(`${path}.`));
}

/**
 * Shows a statement with its operands and the conditions under which it runs.
 *
 * @param {Work} loop
 * @param {string} member
 * @param {Found} of
 * @param {Call} at
 * @param {string} title
 * @param {string} name the explained variable
 */
function statement(loop, member, of, at, title, name) {
  const { write, file } = of;
  const decisions = decisionsOf(at, of);
  const ran = hasRun(at, of);
  // A number has no deciding operands, because it is calculated from all of them.
  const value = ran && decisions?.value?.truth !== null ? decisions?.value : null;
  const reads = (/** @type {Named[]} */ names, /** @type {Decision | null | undefined} */ decision) =>
    apart(operands(loop, member, of, names, at, decision, name), decision);
  const line = (/** @type {number} */ line, /** @type {string} */ text) =>
    element(
      "button.plain",
      { onclick: () => store.emit("line", { file, place: [line, 1] }) },
      `${networkOrLine(of, line)}: `,
      element("code", text.replace(/\s+/g, " ")),
    );
  return element(
    "div.why-statement",
    element("p", `${title} `, line(write.line, write.text), " ", reads(write.reads, value)),
    element(
      "ul",
      guardsOf(write, ran).map((guard) => {
        const decision = decisions?.guards[write.guards.indexOf(guard)];
        // The statement ran, so a recorded value to the contrary is from a later evaluation of the condition; in a
        // loop, from the one that ended the loop.
        const isAgain = ran && decision?.truth === guard.is_negated;
        const isEnd = isAgain && (guard.of === "while" || guard.of === "until");
        return element(
          "li",
          wordOf(guard),
          line(guard.line, guard.text),
          isEnd ? ", which ended the loop: " : " ",
          reads(guard.reads, isAgain && !isEnd ? { truth: null, parts: [], values: [], wires: [] } : decision),
        );
      }),
    ),
  );
}

/**
 * The location of a statement: the network that contains it, if there is just one; otherwise, its line.
 *
 * @param {Found} of
 * @param {number} line
 */
function networkOrLine({ networks }, line) {
  const drawn = networks.filter(({ elements }) => elements.some((one) => one.line === line));
  return drawn.length === 1 ? `network ${drawn[0].number}` : `line ${line}`;
}

/**
 * The conditions of a statement. For one that did not run, without the condition of REPEAT, which is evaluated only at
 * the end of the loop and cannot prevent a statement from running.
 *
 * @param {Write} write
 * @param {boolean} ran
 */
function guardsOf({ guards }, ran) {
  return guards.filter(({ of }) => ran || of !== "until");
}

/**
 * The operands of a truth value, grouped into those that decided and those that made no difference.
 *
 * @param {{ part: Decision["parts"][number] | undefined, shown: HTMLElement }[]} all
 * @param {Decision | null | undefined} decision
 * @returns {HTMLElement[]}
 */
function apart(all, decision) {
  if (!decision || all.length === 0 || (all.length === 1 && decision.truth !== null))
    return all.map(({ shown }) => shown);
  if (decision.truth === null)
    return [
      element(
        "span.part",
        "the deciding operands are unknown: ",
        all.map(({ shown }) => shown),
      ),
    ];
  const of = (/** @type {string} */ part) => all.filter((one) => one.part === part).map(({ shown }) => shown);
  const [decided, shared, idle] = [of("decided"), of("shared"), of("idle")];
  const group = (/** @type {HTMLElement[]} */ some, /** @type {string} */ look, /** @type {string} */ words) =>
    some.length > 0 ? [element("span", { class: `part ${look}` }, `${words}: `, some)] : [];
  const several = decided.length > 2 ? "each of these decided" : decided.length === 2 ? "both decided" : "decided";
  const alone =
    shared.length === 1
      ? "did not decide alone"
      : all.length === 2
        ? "neither decided alone"
        : "none of these decided alone";
  return [
    ...group(decided, "has-decided", several),
    ...group(shared, "has-decided", alone),
    ...group(idle, "is-idle", "made no difference"),
  ];
}

/**
 * The words before a condition. In a CASE, the condition is a value, not a truth value.
 *
 * @param {import("./messages").Guard} guard
 */
function wordOf({ of, is_negated: isNegated }) {
  if (of === "case") return isNegated ? "in the ELSE of the CASE of " : "in the CASE of ";
  if (of === "if") return isNegated ? "if not " : "if ";
  return `${of} `;
}

/**
 * The order in which operands are listed. An operand that is read more than once is listed with the first of these that
 * applies.
 *
 * @type {(string | undefined)[]}
 */
const PARTS = ["decided", "shared", "idle", undefined];

/**
 * The variables that were read, each only once, with their parts in the decision.
 *
 * @param {Work} loop
 * @param {string} member
 * @param {Found} of
 * @param {Named[]} names
 * @param {Call} at
 * @param {Decision | null | undefined} decision
 * @param {string} written the explained variable
 */
function operands(loop, member, { write, prefix, constants }, names, at, decision, written) {
  const { call, values, before, first, monitored } = at;
  const isBefore = before !== undefined && before !== null && write.line <= (first ?? 0);
  const known = new Map(Object.keys(values).map((name) => [plain(name), name]));
  const seen = new Set();
  const all = names.map((named, number) => {
    return { ...named, part: decision?.parts[number], was: decision?.values[number] };
  });
  if (decision) all.sort((one, other) => PARTS.indexOf(one.part) - PARTS.indexOf(other.part));
  return all.flatMap(({ path, is_global: isGlobal, part, was }) => {
    const own = known.get(plain(`${member}.${isGlobal ? "" : prefix}${path}`));
    const temp = prefix ? undefined : Object.keys(monitored.temps).find((one) => plain(one) === plain(path));
    const constant = constants.find(([name]) => plain(name) === plain(path));
    const key = own ?? temp ?? constant?.[0];
    if (key === undefined || seen.has(key)) return [];
    seen.add(key);
    if (own === written && isBefore)
      return [{ part, shown: operand(loop, own, { [own]: before }, Math.max(call - 1, 0), was) }];
    if (own) return [{ part, shown: operand(loop, own, values, call, was) }];
    if (temp) return [{ part, shown: value(`${path} ${plcText(monitored.temps[temp], "")}`) }];
    return [{ part, shown: value(`${path} ${constant?.[1]}`, "A constant") }];
  });
}

/** A value that cannot be explained further. @param {string} text @param {string} [title] */
function value(text, title) {
  return element("span.value", { title }, text);
}

/**
 * A variable with its value, as a button that explains it.
 *
 * @param {Work} loop
 * @param {string} name
 * @param {Values} values
 * @param {number} call the call for which it is explained
 * @param {boolean | null} [was] the value that it had when the condition was evaluated
 */
function operand(loop, name, values, call, was) {
  const [member, own] = split(name);
  const kind = member === loop.member ? loop.description.variables.find((one) => one.name === own)?.kind : undefined;
  const value = was ?? values[name];
  const look = typeof value === "boolean" ? (value ? " is-true" : " is-false") : "";
  return element(
    "button",
    { class: `operand value${look}`, title: `Why ${called(loop, name)}?`, onclick: () => answer(name, call) },
    `${called(loop, name)} ${plcText(value, kind ?? "")}`,
  );
}
