/**
 * PLC programs: the engine translates dropped sources and adds the program to its catalogue; the program then runs as
 * the controller of a loop. A rejected program is kept to show its problems at their lines.
 *
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").Program} Program
 * @typedef {import("./messages").SourceFile} SourceFile
 * @typedef {import("tool/store.js").Work} Work
 */

import { ask, EngineError, toBase64 } from "tool/engine.js";
import { pathOf } from "tool/folder.js";
import { isSettable, store } from "tool/store.js";
import { isBoolean } from "tool/values.js";
import { unzippedAll } from "tool/zip.js";

/** Names of program files, including tag tables. */
const SOURCE = /\.(scl|udt|db|xml|s7dcl|s7res|xlsx|sdf)$/i;
/** In a project folder, an AWL file is also a source; on its own, it is a parameter file. */
const OF_PROJECT = /\.(scl|udt|db|awl|xml|s7dcl|s7res|xlsx|sdf)$/i;
/** Text found only in sources with code. Other files may be parameter files. */
const CODE = /^[ \t\ufeff]*(FUNCTION_BLOCK|ORGANIZATION_BLOCK|FUNCTION)\b|<SW\.Blocks\.(FB|FC|OB)\b/im;
/** The paths of the parts of a workbook that contain its tables. */
const WORKBOOK = /^xl\/.*\.(xml|rels)$/;
const LARGEST = 16_000_000;
/** The maximum number of sources listed as the origin of a loop. */
const MOST_NAMED = 4;
/** The maximum numbers of curves that are shown initially: of numbers and of Booleans. */
const [MOST_NUMBERS, MOST_SWITCHES] = [4, 8];

/**
 * The translated programs by their names in the catalogue, in the order of translation.
 *
 * @type {Map<string, { program: Program, compiled: Compiled }>}
 */
const known = new Map();

/** The last rejected program. @type {{ program: Program, compiled: Compiled } | undefined} */
let refusedNow;

/** The last rejected program, if it has not been corrected yet. */
export function refused() {
  return refusedNow;
}

/** Forgets the rejected program. */
export function forgetRefused() {
  refusedNow = undefined;
  store.emit("program");
}

/**
 * The translated program of a loop; `undefined` if the loop's controller is a block.
 *
 * @param {Work | undefined} loop
 */
export function programOf(loop) {
  return loop && known.get(loop.description.name);
}

/** All programs, for restoring after a reload: if they are retranslated in this order, they get the same names. */
export function programs() {
  return [...known.values()].map(({ program }) => program);
}

/**
 * Separates the sources of a program from other files opened with them.
 *
 * @param {File[]} files
 * @returns {Promise<[File[], File[]]>} the sources, if one of them contains code, and the other files
 */
export async function sourcesAmong(files) {
  for (const file of files.filter(({ name }) => SOURCE.test(name))) {
    if (file.size > LARGEST) continue;
    const bytes = new Uint8Array(await file.arrayBuffer());
    // Remove the NUL bytes that UTF-16 has between the letters.
    const text = new TextDecoder("latin1").decode(bytes).replaceAll("\0", "");
    if (!CODE.test(text)) continue;
    // Other files are ignored if they are in a project folder.
    const isPart = (/** @type {File} */ one) => (pathOf(one) === undefined ? SOURCE : OF_PROJECT).test(one.name);
    return [files.filter(isPart), files.filter((one) => !isPart(one) && pathOf(one) === undefined)];
  }
  return [[], files];
}

/**
 * Reads files into the form that the engine accepts: Base64, and workbooks unpacked.
 *
 * @param {File[]} files
 */
export async function sourcesOf(files) {
  /** @type {import("./messages").SourceFile[]} */
  const sources = [];
  const content = (/** @type {Uint8Array} */ bytes) => toBase64(bytes);
  for (const file of files) {
    if (file.size > LARGEST) throw new EngineError(`${file.name} is larger than ${LARGEST / 1e6} MB: leave it out.`);
    const isTwice = files.some((one) => one !== file && one.name.toLowerCase() === file.name.toLowerCase());
    const name = isTwice ? (pathOf(file)?.replaceAll("/", "_") ?? file.name) : file.name;
    if (/\.xlsx$/i.test(name)) {
      const parts = await unzippedAll(file, (path) => WORKBOOK.test(path), LARGEST);
      for (const [path, bytes] of parts) sources.push({ file: `${name}/${path}`, content: content(bytes) });
    } else sources.push({ file: name, content: content(new Uint8Array(await file.arrayBuffer())) });
  }
  return sources;
}

/**
 * Opens sources as one program.
 *
 * @param {File[]} files
 * @returns {Promise<Work | undefined>} the loop, unless the program was rejected
 */
export async function openProgram(files) {
  const sources = await sourcesOf(files);
  const isFolder = files.every((file) => pathOf(file) !== undefined);
  const isIn =
    (/** @type {SourceFile[]} */ all) =>
    (/** @type {SourceFile} */ { file }) =>
      all.some((one) => one.file === file);
  // Reopened sources belong to the loop that already has all of them; its options and its other sources are kept. A
  // reopened folder may also contain new sources.
  const before = store.loops.find((loop) => {
    const files = programOf(loop)?.program.files ?? [];
    return files.length > 0 && (sources.every(isIn(files)) || (isFolder && files.every(isIn(sources))));
  });
  const earlier = programOf(before)?.program;
  // Keep the cycle that the user has set for the loop.
  const cycle = before?.settings[before.description.cycle ?? ""];
  const own = cycle && cycle.sent !== cycle.start ? { cycle: Number(cycle.sent) } : {};
  const others = earlier?.files.map((one) => sources.find(({ file }) => file === one.file) ?? one) ?? [];
  const program = { ...earlier, ...own, files: [...others, ...sources.filter((one) => !isIn(others)(one))] };
  const loop = await translate(/** @type {Program} */ (program), before);
  if (loop && isFolder) loop.notes.isFolder = true;
  return loop;
}

/** The program that has this name in the catalogue, if it was opened here. @param {string} fmu */
export function programNamed(fmu) {
  return known.get(fmu);
}

/**
 * Translates a program and shows it, in a new loop or in place of a loop's program.
 *
 * @param {Program} program
 * @param {Work} [loop]
 * @returns {Promise<Work | undefined>} the loop, unless the program was rejected
 */
export async function translate(program, loop) {
  const compiled = await admit(program);
  if (!compiled.fmu) {
    refusedNow = { program, compiled };
    store.emit("program");
    store.emit("show", "program");
    return undefined;
  }
  refusedNow = undefined;
  const made = loop ? await replaced(loop, compiled.fmu) : await opened(compiled);
  store.emit("program");
  store.emit("show", "program");
  return made;
}

/**
 * Translates a program. If it is accepted, it is added to the catalogue.
 *
 * @param {Program} program
 * @returns {Promise<Compiled>}
 */
export async function admit(program) {
  const compiled = await ask({ do: "compile", ...program });
  if (compiled.fmu && !known.has(compiled.fmu)) {
    known.set(compiled.fmu, { program, compiled });
    store.catalogue = await ask({ do: "catalogue" });
    store.emit("catalogue");
  }
  return compiled;
}

/** @param {Compiled} compiled */
async function opened(compiled) {
  const name = freeName(compiled.block);
  const files = compiled.sources.map(({ file }) => file).filter((file) => !/\.s7res$/i.test(file));
  const origin = files.length > MOST_NAMED ? `${files.length} sources` : files.join(", ");
  const loop = await store.add(name, compiled.fmu ?? "", undefined, origin);
  showOutputs(loop);
  if (compiled.cycle_from)
    store.say(
      `${compiled.block} is called every ${compiled.cycle} s: ${compiled.cycle_from}. Change it under Options.`,
    );
  return loop;
}

/**
 * Shows curves for the program's outputs other than the setpoint, the process value and the manipulated value.
 *
 * @param {Work} loop
 */
export function showOutputs(loop) {
  const { roles, variables, cycle } = loop.description;
  const main = [roles.setpoint, roles.shown_process_value, roles.manipulated_value];
  const outputs = variables.filter(({ role, name }) => role === "output" && !main.includes(name) && name !== cycle);
  const numbers = outputs.filter(({ kind }) => !isBoolean(kind)).slice(0, MOST_NUMBERS);
  const switches = outputs.filter(({ kind }) => isBoolean(kind)).slice(0, MOST_SWITCHES);
  const chosen = [...numbers, ...switches].map(({ name }) => `${loop.member}.${name}`);
  loop.notes.curves = { chosen, hidden: [], window: 0 };
  store.emit("plant");
}

/** @param {string} block */
function freeName(block) {
  const taken = new Set(store.loops.map(({ name }) => name));
  let name = block;
  for (let number = 2; taken.has(name); number += 1) name = `${block} ${number}`;
  return name;
}

/**
 * Replaces the program of a loop. Plant and runs are kept, and so are values and connections whose variables the new
 * program still has.
 *
 * @param {Work} before
 * @param {string} fmu
 */
async function replaced(before, fmu) {
  if (before.description.name === fmu) {
    store.show(before);
    return before;
  }
  store.emit("pause");
  const loop = await store.add(before.name, fmu, undefined, before.file);
  for (const [name, setting] of Object.entries(loop.settings)) {
    const old = before.settings[name];
    // The cycle was already set by the translation.
    if (!old || old.variable.kind !== setting.variable.kind || name === loop.description.cycle) continue;
    const isChanged = old.sent !== old.start;
    if (isChanged) setting.sent = setting.value = old.sent;
    setting.opened = old.opened;
  }
  const { member, members, step, exchange, notes, runs } = before;
  const isThere = (/** @type {string} */ end) => {
    const own = end.startsWith(`${member}.`) ? end.slice(member.length + 1) : undefined;
    return own === undefined || loop.description.variables.some(({ name }) => name === own);
  };
  const connections = before.connections.filter((wire) => wire.every(isThere));
  const at = store.loops.indexOf(before);
  store.remove(before);
  store.loops.splice(store.loops.indexOf(loop), 1);
  store.loops.splice(at, 0, loop);
  Object.assign(loop, { member, members, connections, step, exchange, notes, runs });
  store.emit("loops");
  store.show(loop);
  store.emit("loop");
  store.emit("plant");
  // Update the fields, which were drawn with the start values.
  store.emit("settings", Object.keys(loop.settings));
  store.say(`${loop.name} has the changed program. The next run starts with it; earlier runs are kept for comparison.`);
  return loop;
}

/**
 * The variables of a loop's program by their paths in the sources, in capitals.
 *
 * @param {Work} loop
 */
export function byPath(loop) {
  // In a variable's name, a part that is not an identifier is enclosed in apostrophes.
  const plain = (/** @type {string} */ name) => name.replaceAll("'", "").toUpperCase();
  return new Map(loop.description.variables.map((one) => [plain(one.name), one]));
}

/**
 * The unconnected inputs of a loop's program, which the user can set.
 *
 * @param {Work} loop
 */
export function openInputs(loop) {
  const wired = new Set(loop.connections.map(([, to]) => to));
  return loop.description.variables.filter(
    (one) => one.role === "input" && isSettable(one) && !wired.has(`${loop.member}.${one.name}`),
  );
}
