/**
 * Opens files: parameter files, FMUs, recordings, loop descriptions and program sources.
 *
 * @typedef {import("./messages").Loop} Loop
 * @typedef {import("./messages").Loops} Loops
 * @typedef {import("./messages").LoopValue} FileSetting
 * @typedef {import("./messages").Value} Value
 */

import { recordingOf } from "tool/csv.js";
import { accept, ask, EngineError, fromBase64, toBase64, unpacked, upload, whereIsTheEngine } from "tool/engine.js";
import { fileAt, unpackedFiles } from "tool/folder.js";
import { openKnown } from "tool/known.js";
import { openSources, withPrograms } from "tool/machine.js";
import { sourcesAmong } from "tool/program.js";
import { store } from "tool/store.js";
import { isBoolean } from "tool/values.js";
import { unzipped } from "tool/zip.js";

const MEGABYTE = 1_000_000;
/** The maximum file sizes in bytes. For comparison: a parameter file with 10 000 loops has 8 MB. */
const LIMITS = { parameters: 24 * MEGABYTE, fmu: 256 * MEGABYTE, description: MEGABYTE };
/** The maximum number of loops that the table can show without slowing down the page. */
const MOST_LOOPS = 20_000;
/** Text that occurs once per loop: the start of a data block, a JSON object or a block in an Openness file. */
const BEGINNING = /(?<!END_)DATA_BLOCK|"\s*:\s*\{|<SW\.Blocks\./gi;

/**
 * Opens files. Problems are listed with each file. Files rejected earlier are removed from the list.
 *
 * @param {Iterable<File>} files
 */
export async function openFiles(files) {
  store.files = store.files.filter((one) => !one.isRefused);
  store.emit("files");
  store.emit("opening");
  /** @type {File[]} */
  const texts = [];
  for (const file of await unpackedFiles(files)) {
    const why = await whyNoText(file);
    if (why) refuse(file.name, why);
    else texts.push(file);
  }
  const [sources, others] = await sourcesAmong(texts);
  /** The names of sources used by one of the descriptions. @type {Set<string>} */
  const taken = new Set();
  for (const file of others.filter(isDescription)) {
    await attempt(file, async () => {
      for (const name of await openDescription(file, sources)) taken.add(name);
    });
  }
  const left = sources.filter(({ name }) => !taken.has(name));
  if (left.length > 0) await openSources(left).catch(store.say);
  for (const file of others.filter((one) => !isDescription(one))) await attempt(file, () => open(file));
}

/** @param {File} file */
function isDescription(file) {
  return file.name.toLowerCase().endsWith(".toml");
}

/**
 * Opens a loop description.
 *
 * @param {File} file
 * @param {File[]} sources program sources opened with it
 * @returns {Promise<string[]>} the names of its programs' sources
 */
async function openDescription(file, sources) {
  limit(file, LIMITS.description);
  const described = await ask({ do: "described", file: file.name, text: await file.text() });
  const names = described.programs.flatMap((program) => program.sources);
  await openKnown(
    await withPrograms(
      described,
      sources.filter(({ name }) => names.includes(name)),
    ),
    file.name,
  );
  return names;
}

/**
 * Opens a file with `act`; on failure, lists the file with the reason.
 *
 * @param {File} file
 * @param {() => Promise<unknown>} act
 */
async function attempt(file, act) {
  try {
    await act();
  } catch (error) {
    if (error instanceof EngineError) refuse(file.name, error.message);
    else refuse(file.name, `It cannot be read: ${error instanceof Error ? error.message : error}.`);
  }
}

/** Names of binary files: an FMU, a data block dump, a workbook. */
const BINARY = /\.(fmu|bin|dump|xlsx)$/i;
/** The size of the part that is checked for binary content, in bytes. */
const BEGIN = 4096;

/**
 * Why a file cannot be read as text; `undefined` if it can, or if it is a known binary file. Among text files, only
 * UTF-16 contains NUL bytes, and it must begin with a byte order mark.
 *
 * @param {File} file
 * @returns {Promise<string | undefined>}
 */
async function whyNoText(file) {
  if (BINARY.test(file.name)) return undefined;
  const bytes = new Uint8Array(await file.slice(0, BEGIN).arrayBuffer());
  const isMarked = (bytes[0] === 0xff && bytes[1] === 0xfe) || (bytes[0] === 0xfe && bytes[1] === 0xff);
  if (isMarked || !bytes.includes(0)) return undefined;
  const nuls = [0, 1].map((odd) => bytes.filter((byte, at) => at % 2 === odd && byte === 0).length);
  // In UTF-16, one byte of almost every character is 0, and the other is hardly ever 0.
  const isWide = Math.max(...nuls) > bytes.length / 4 && Math.min(...nuls) < bytes.length / 100;
  return isWide
    ? "This is UTF-16 text without a byte order mark: save it as UTF-8."
    : "This is not a text file: open a parameter file, an SCL program, a recording or an FMU.";
}

/** Opens files whose content is Base64, as passed by the command. @param {{ file: string, content: string }[]} given */
export async function openSaved(given) {
  await openFiles(given.map(({ file, content }) => fileAt(file, fromBase64(content))));
}

/** Opens the files passed to the command, and a new loop with the block that it names, if any. */
export async function openGiven() {
  if (!document.getElementById("files")?.textContent?.trim()) return;
  /** @type {{ file: string, content: string }[]} */
  const given = JSON.parse(new TextDecoder().decode(await unpacked("files")));
  await openSaved(given);
  const block = document.querySelector('meta[name="plcfmu-open"]')?.getAttribute("content");
  if (block && store.loops.length === 0) await store.add(block, block);
}

/**
 * Rereads a rejected file as the parameters of a block chosen by the user.
 *
 * @param {import("./store.js").OpenFile} file
 * @param {string} block
 */
export async function readAgain(file, block) {
  const source = sources.get(file);
  if (!source) return;
  store.files.splice(store.files.indexOf(file), 1);
  await openParameters(source, block);
}

/** The file objects behind the open files. @type {WeakMap<import("./store.js").OpenFile, File>} */
const sources = new WeakMap();

/** The file from which a loop was opened; `undefined` after a reload. @param {import("./store.js").Work} loop */
export function sourceOf(loop) {
  const opened = store.files.find(({ name }) => name === loop.file);
  return opened && sources.get(opened);
}

/** @param {File} file */
async function open(file) {
  const name = file.name.toLowerCase();
  if (name.endsWith(".csv")) {
    store.emit("csv", await recordingOf(file));
    store.say(`${file.name} is a recording: ${store.loop ? "" : "open or create a loop, then "}see Replay and Tune.`);
  } else if (name.endsWith(".fmu")) {
    limit(file, LIMITS.fmu);
    await openFmu(file);
  } else {
    limit(file, LIMITS.parameters);
    await openParameters(file);
  }
}

/**
 * @param {File} file
 * @param {number} most
 */
function limit(file, most) {
  if (file.size <= most) return;
  const [has, may] = [file.size, most].map((size) => `${Math.ceil(size / MEGABYTE)} MB`);
  throw new EngineError(`The file is ${has}; the page reads at most ${may}. Export fewer blocks at a time.`);
}

/**
 * @param {File} file
 * @param {string | null} block
 */
async function openParameters(file, block = null) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const beginnings = new TextDecoder("latin1").decode(bytes).match(BEGINNING)?.length ?? 0;
  if (beginnings > MOST_LOOPS) {
    throw new EngineError(
      `The file has ${beginnings} blocks; the page shows at most ${MOST_LOOPS}. Export fewer blocks at a time.`,
    );
  }
  const read = await ask({ do: "read", file: file.name, content: toBase64(bytes), block });
  await show(file, read);
}

/**
 * Lists a file with its loops. If there is only one loop, opens it.
 *
 * @param {File} file
 * @param {Loops} read
 */
async function show(file, read) {
  const before = store.files.findIndex((one) => one.name === file.name);
  const opened = { name: file.name, loops: read.loops, problems: read.problems, isRefused: read.is_refused };
  if (before >= 0) store.files.splice(before, 1, opened);
  else store.files.push(opened);
  sources.set(opened, file);
  store.emit("files");
  if (read.loops.length === 1) await take(opened, 0);
  const count = read.loops.length;
  // If no loop is open, the list is the only thing visible and needs no note.
  if (count > 1 && store.loop) store.say(`${file.name}: ${count} loops; choose one in the list.`);
}

/**
 * Opens a loop of a file for editing, or shows it if it is already open.
 *
 * @param {import("./store.js").OpenFile} file
 * @param {number} at index of the loop in the file
 */
export async function take(file, at) {
  const under = underWork(file, at);
  if (under) return store.show(under);
  const of = file.loops[at];
  const fmu = store.catalogue.fmus.find((one) => one.name === of.block) ?? (await byBlock(of.block));
  if (!fmu) {
    throw new EngineError(`${of.name}: no FMU for the block ${of.block} here; open its .fmu with plcfmu tool.`);
  }
  const loop = await store.add(of.name, fmu.name, of, file.name);
  loop.notes.at = at;
  loop.notes.title = of.title ?? undefined;
  // Redraw the table: it can match the loop with its file only now.
  store.emit("loops");
}

/**
 * The open loop that was opened from this entry of a file, if any.
 *
 * @param {import("./store.js").OpenFile} file
 * @param {number} at
 */
export function underWork(file, at) {
  const name = file.loops[at].name;
  return store.loops.find((one) => one.file === file.name && one.notes.at === at && one.name === name);
}

/**
 * The description of the FMU for a block, by its name or an alias; `undefined` if the catalogue has none.
 *
 * @param {string} block
 */
export async function describedBlock(block) {
  const entry = store.catalogue.fmus.find((one) => one.name === block) ?? (await byBlock(block));
  return entry && store.describe(entry.name);
}

/** @param {string} block */
async function byBlock(block) {
  for (const entry of store.catalogue.fmus) {
    const description = await store.describe(entry.name);
    if (description.block === block || description.aliases.includes(block)) return entry;
  }
  return undefined;
}

/**
 * @param {string} name
 * @param {string} message
 */
function refuse(name, message) {
  const problems = [{ place: null, message, help: null, asks_for_block: false }];
  const file = { name, loops: [], problems, isRefused: true };
  const before = store.files.findIndex((one) => one.name === name && one.isRefused);
  if (before >= 0) store.files.splice(before, 1, file);
  else store.files.push(file);
  store.emit("files");
}

/**
 * Opens an FMU: in the page, its start values become the parameters of a loop if its block is in the catalogue; the
 * server can also run the FMU itself.
 *
 * @param {File} file
 */
async function openFmu(file) {
  if (whereIsTheEngine() === "server") return openUploaded(file);
  const model = await modelDescription(file);
  const identifier = model.querySelector("CoSimulation")?.getAttribute("modelIdentifier") ?? "";
  const entry = store.catalogue.fmus.find((one) => one.name === identifier) ?? (await byBlock(identifier));
  if (!entry) {
    throw new EngineError(
      `${identifier || "This FMU"} is native code, which a page cannot run. Open it with plcfmu tool ${file.name}.`,
    );
  }
  const loop = loopOf(file.name, model, await store.describe(entry.name));
  return show(file, { loops: [loop], problems: [], is_refused: false });
}

/**
 * Opens an FMU on the server: as the parameters of a known block, or as native code that runs only with the user's
 * consent.
 *
 * @param {File} file
 */
async function openUploaded(file) {
  const uploaded = await upload(file);
  const { name, question, problem, parameters } = uploaded;
  if (parameters) return openParameters(new File([fromBase64(parameters.content)], parameters.file));
  if (problem) throw new EngineError(`${name} cannot run here: ${problem}`);
  store.emit("question", {
    text: question,
    yes: "Run it",
    act: async () => {
      await accept(name);
      store.catalogue = await ask({ do: "catalogue" });
      store.emit("catalogue");
      store.say(`${name} can now be chosen as a plant.`);
    },
  });
}

/**
 * A loop with the start values of an FMU.
 *
 * @param {string} file
 * @param {Document} model
 * @param {import("./messages").Description} description
 * @returns {Loop}
 */
function loopOf(file, model, description) {
  /** @type {FileSetting[]} */
  const settings = [];
  for (const one of model.querySelectorAll("ScalarVariable")) {
    const variable = description.variables.find(({ name }) => name === one.getAttribute("name"));
    const text = one.firstElementChild?.getAttribute("start");
    if (!variable || text === null || text === undefined || variable.role === "output") continue;
    const value = isBoolean(variable.kind) ? text === "true" || text === "1" : Number(text);
    settings.push({ name: variable.name, value, origin: file, file: null });
  }
  const name = model.documentElement.getAttribute("modelName") ?? description.name;
  const cycle = settings.find((one) => one.name === description.cycle)?.value;
  const warnings = /** @type {string[]} */ ([]);
  return {
    name,
    title: null,
    block: description.block,
    cycle: typeof cycle === "number" ? cycle : null,
    settings,
    warnings,
  };
}

/** @param {File} file */
async function modelDescription(file) {
  const bytes = await unzipped(file, "modelDescription.xml", 16 * MEGABYTE);
  if (!bytes) throw new EngineError("This is not an FMU: it contains no modelDescription.xml.");
  const model = new DOMParser().parseFromString(new TextDecoder().decode(bytes), "application/xml");
  if (model.querySelector("parsererror") || model.documentElement.tagName !== "fmiModelDescription") {
    throw new EngineError("Its modelDescription.xml cannot be read: run plcfmu check on the FMU to find out why.");
  }
  return model;
}
