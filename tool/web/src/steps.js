/**
 * Finds the steps of sequences in a program: the variables of CASE statements, and the names of their values in the
 * source.
 *
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").CodeBlock} Block
 * @typedef {import("./messages").Program} Program
 */

import { lookOf } from "tool/scl.js";

/** The text before a colon, which may be labels of a CASE; and a single label. */
const [LABELS, LABEL] = [/^([^:]+):(?!=)/, /^\s*[#"\w.+-]+\s*$/];
const WHOLE = /^[+-]?\d+$/;

/**
 * The names of the values of each CASE variable, by the variable's path in the program, in capitals. A value whose
 * label is a constant has the constant's name; a value whose label is a number has the text of the comment in its line,
 * if any.
 *
 * @param {Compiled} compiled
 * @param {Program} program
 * @returns {Map<string, Map<number, string>>}
 */
export function steps(compiled, program) {
  /** @type {Map<string, Map<number, string>>} */
  const found = new Map();
  for (const [file, source] of compiled.sources.entries()) {
    const lines = lookOf(source.text.split(/\r\n|\n|\r/));
    /**
     * The names for each open CASE, innermost last; `undefined` if its selector is not a variable.
     *
     * @type {(Map<number, string> | undefined)[]}
     */
    const open = [];
    for (const [at, { code, comment }] of lines.entries()) {
      const block = compiled.blocks.findLast((one) => one.file === file && one.line <= at + 1);
      const over = /\bCASE\s+(.+?)\s+OF\b/i.exec(code);
      if (over && !/\bEND_CASE\b/i.test(code)) {
        const path = variableOf(over[1], at + 1, block);
        open.push(path && block ? namesOf(found, pathsOf(compiled, block, path)) : undefined);
      }
      const names = open.at(-1);
      const labels = (over ? "" : (LABELS.exec(code)?.[1] ?? "")).split(",");
      if (names && block && labels.every((one) => LABEL.test(one))) name(names, labels, comment, block, program);
      if (/\bEND_CASE\b/i.test(code) && !over) open.pop();
    }
  }
  return found;
}

/**
 * The variable of which an expression consists; `undefined` if it is not just a variable.
 *
 * @param {string} expression
 * @param {number} line
 * @param {Block | undefined} block
 */
function variableOf(expression, line, block) {
  const plain = (/** @type {string} */ text) => text.replace(/[#"'\s]/g, "").toUpperCase();
  return block?.names.find((one) => one.line === line && plain(one.path) === plain(expression));
}

/**
 * The paths of a block's variable in all instances of the block.
 *
 * @param {Compiled} compiled
 * @param {Block} block
 * @param {import("./messages").Named} variable
 */
function pathsOf(compiled, block, { path, is_global: isGlobal }) {
  if (isGlobal) return [path];
  const own = compiled.parts.filter((part) => part.block.toUpperCase() === block.name.toUpperCase());
  return own.map((part) => (part.path ? `${part.path}.${path}` : path));
}

/**
 * @param {Map<string, Map<number, string>>} found
 * @param {string[]} paths
 */
function namesOf(found, paths) {
  const plain = paths.map((path) => path.replaceAll("'", "").toUpperCase());
  // A second CASE of the same variable adds to its names.
  const names = found.get(plain[0] ?? "") ?? new Map();
  for (const path of plain) found.set(path, names);
  return names;
}

/**
 * @param {Map<number, string>} names
 * @param {string[]} labels
 * @param {string} comment
 * @param {Block} block
 * @param {Program} program
 */
function name(names, labels, comment, block, program) {
  const constants = new Map(
    [...(program.constants ?? []), ...block.constants].map(([of, value]) => [of.toUpperCase(), value]),
  );
  for (const label of labels) {
    const plain = label.replace(/[#"\s]/g, "");
    const value = WHOLE.test(plain) ? plain : constants.get(plain.toUpperCase());
    const number = value === undefined ? Number.NaN : Number(value.replace(/^[A-Za-z_]+#/, ""));
    if (!Number.isInteger(number) || names.has(number)) continue;
    const told = WHOLE.test(plain) ? (labels.length === 1 ? comment : "") : plain;
    if (told) names.set(number, told);
  }
}
