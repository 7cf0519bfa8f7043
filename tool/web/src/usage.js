/**
 * Finds where a variable of a program is declared, written and read, and shows the bar with links to these places.
 *
 * @typedef {import("./messages").CodeBlock} Block
 * @typedef {import("./messages").Compiled} Compiled
 *
 * @typedef {object} Variable a variable as named in a block
 * @property {string} path
 * @property {boolean} isGlobal
 *
 * @typedef {object} Spot
 * @property {number} file index of the source
 * @property {number} line
 *
 * @typedef {object} Way a link in the bar
 * @property {string} label
 * @property {string} title what the place does with the variable
 * @property {() => void} go
 */

import { element, fill } from "tool/dom.js";
import { store } from "tool/store.js";

/** The maximum number of links in each group. */
const MOST_LISTED = 12;

/** @param {string} text */
function plain(text) {
  return text.replaceAll("'", "").toUpperCase();
}

/** The first name of a path. @param {string} path */
function first(path) {
  return plain(path.split(/[.[]/)[0]);
}

/**
 * Where a variable is declared; `undefined` if no source declares it, as with a tag from a tag table.
 *
 * @param {Compiled} compiled
 * @param {Block} block
 * @param {Variable} of
 * @returns {Spot | undefined}
 */
export function declarationOf(compiled, block, { path, isGlobal }) {
  const wanted = first(path);
  const own = isGlobal ? undefined : block.declared.find(([name]) => plain(name) === wanted);
  if (own) return { file: block.file, line: own[1] };
  const all = compiled.declared.find(([name]) => plain(name) === wanted);
  if (all) return { file: all[1], line: all[2] };
  const called = compiled.blocks.find(({ name }) => plain(name) === wanted);
  return called && { file: called.file, line: called.line };
}

/**
 * The lines that write a variable, and those that read it. A block's parameter is also written where a call passes a
 * value for it.
 *
 * @param {Compiled} compiled
 * @param {Block} block
 * @param {Variable} of
 * @returns {{ writers: Spot[], readers: Spot[] }}
 */
export function usesOf(compiled, block, of) {
  const wanted = plain(of.path);
  const isIt = (/** @type {{ path: string, is_global: boolean }} */ one) =>
    plain(one.path) === wanted && (of.isGlobal ? one.is_global : true);
  const [writers, readers] = [/** @type {Spot[]} */ ([]), /** @type {Spot[]} */ ([])];
  for (const one of of.isGlobal ? compiled.blocks : [block]) {
    const written = one.writes.filter(isIt).map(({ line }) => line);
    const read = one.writes
      .flatMap(({ reads, guards }) => [reads, ...guards.map((guard) => guard.reads)].flat())
      .filter(isIt)
      .map(({ line }) => line);
    for (const line of new Set(written)) writers.push({ file: one.file, line });
    // A line that names the variable reads it, unless it only writes it.
    const named = one.names.filter(isIt).map(({ line }) => line);
    for (const line of new Set(named))
      if (read.includes(line) || !written.includes(line)) readers.push({ file: one.file, line });
  }
  if (!of.isGlobal) writers.push(...callers(compiled, block, wanted));
  return { writers, readers };
}

/**
 * The lines in which calls of a block pass a value for one of its parameters.
 *
 * @param {Compiled} compiled
 * @param {Block} block
 * @param {string} formal
 * @returns {Spot[]}
 */
function callers(compiled, block, formal) {
  const instances = compiled.parts
    .filter((part) => plain(part.block) === plain(block.name))
    .map(({ path }) => plain(path));
  return compiled.blocks.flatMap((caller) => {
    const own = compiled.parts
      .filter((part) => plain(part.block) === plain(caller.name))
      .map(({ path }) => plain(path));
    const prefixes = ["", ...own.filter((path) => path !== "").map((path) => `${path}.`)];
    return caller.calls
      .filter(({ instance }) => prefixes.some((prefix) => instances.includes(prefix + plain(instance))))
      .flatMap((call) => call.arguments.filter((one) => plain(one.formal) === formal))
      .map(({ line }) => ({ file: caller.file, line }));
  });
}

/**
 * Fills the bar for a chosen variable: its value, buttons to explain and watch it, and links to its uses.
 *
 * @param {HTMLElement} bar
 * @param {string} text the variable as written
 * @param {{ text: string, name: string | undefined } | undefined} found its value, and its name if the run records it
 * @param {[string, Way[]][]} ways links, each group with its heading
 */
export function showUsage(bar, text, found, ways) {
  const name = found?.name;
  const key = JSON.stringify([text, found?.text, name, ways.map(([word, all]) => [word, all.length])]);
  if (bar.dataset.shown === key) return;
  bar.dataset.shown = key;
  const watch = () => {
    const loop = store.loop;
    if (loop && name && !(loop.notes.watch ?? []).includes(name))
      loop.notes.watch = [...(loop.notes.watch ?? []), name];
    store.emit("plant");
    store.emit("show", "watch");
  };
  const button = (/** @type {Way} */ { label, title, go }) =>
    element("button.plain", { title, "aria-label": title, onclick: go }, label);
  fill(
    bar,
    element("strong", text),
    found ? element("span", found.text) : null,
    name && element("button", { onclick: () => store.emit("why", name) }, "Why"),
    name && element("button", { onclick: watch }, "Watch"),
    ways.flatMap(([word, all]) => [
      element("span.faint", `${word} ${all.length > 0 ? "in" : "nowhere"}`),
      ...all.slice(0, MOST_LISTED).map(button),
      all.length > MOST_LISTED && element("span.faint", `and ${all.length - MOST_LISTED} more`),
    ]),
  );
}
