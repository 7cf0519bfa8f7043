/**
 * A project: a table of what its files contain, and a list of assumptions about undeclared names, which the user edits
 * and accepts.
 *
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").Program} Program
 */

import { element } from "tool/dom.js";
import { fromBase64, toBase64 } from "tool/engine.js";
import { store } from "tool/store.js";

/** The name of the source that contains the accepted assumptions. */
const ASSUMED = "assumed.scl";

/** A table of what the files contain; `null` for a single source without assumptions. @param {Compiled} compiled */
export function surveyTable({ survey, sources, fmu, assumptions }) {
  const count = sources.filter(({ file }) => !/\.s7res$/i.test(file)).length;
  if (survey.length === 0 || (count < 2 && assumptions.length === 0)) return null;
  return element(
    "details.survey",
    { open: fmu === null },
    element("summary", `The project: ${count} ${count === 1 ? "source" : "sources"}`),
    element(
      "table",
      survey.map(([name, text]) => element("tr", element("th", { scope: "row" }, name), element("td", text))),
    ),
  );
}

/**
 * The list of proposed assumptions or, if there are none, the accepted ones; `null` without either.
 *
 * @param {Program} program
 * @param {Compiled} compiled
 * @param {(program: Program) => void} translate
 */
export function assumptionsForm(program, compiled, translate) {
  const before = program.files.find(({ file }) => file === ASSUMED);
  if (compiled.assumptions.length > 0) return proposed(program, compiled, textOf(before), translate);
  if (!before) return null;
  const input = element("textarea", { "aria-label": "Assumptions", rows: 8, spellcheck: "false" });
  input.value = textOf(before);
  const count = input.value.match(/^\/\/ .+: /gm)?.length ?? 0;
  return form(`${count} ${count === 1 ? "name is" : "names are"} assumed`, false, [input], "Translate again", () =>
    translate(withAssumed(program, input.value)),
  );
}

/**
 * @param {Program} program
 * @param {Compiled} compiled
 * @param {string} before the assumptions accepted so far
 * @param {(program: Program) => void} translate
 */
function proposed(program, { assumptions }, before, translate) {
  const rows = assumptions.map(({ name, what, place, text }) => {
    const input = element("textarea", {
      ...{
        "aria-label": `Declaration of ${name}`,
        rows: Math.min(text.trim().split("\n").length, 8),
        spellcheck: "false",
      },
    });
    input.value = text.trim();
    const at = place && `${place[0]}, line ${place[1]}`;
    const go = () => place && store.emit("line", { file: place[0], place: [place[1], 1] });
    const head = element(
      "p",
      element("strong", name),
      ` is ${what} `,
      at && element("button.plain", { onclick: go }, at),
    );
    return { head, input, title: `// ${name}: ${what}` };
  });
  const count = rows.length === 1 ? "1 name" : `${rows.length} names`;
  return form(
    `${count} without a declaration: possible assumptions`,
    true,
    rows.map(({ head, input }) => element("div.assumption", head, input)),
    `Assume ${rows.length === 1 ? "it" : `these ${rows.length}`}`,
    () =>
      translate(withAssumed(program, before + rows.map(({ title, input }) => `${title}\n${input.value}\n`).join(""))),
  );
}

/**
 * @param {string} title
 * @param {boolean} isOpen
 * @param {HTMLElement[]} content
 * @param {string} button
 * @param {() => void} act
 */
function form(title, isOpen, content, button, act) {
  return element(
    "details.assumptions",
    { open: isOpen },
    element("summary", title),
    element("div.assumption-list", content),
    element("button.primary", { onclick: act }, button),
  );
}

/** @param {import("./messages").SourceFile | undefined} file */
function textOf(file) {
  return file ? new TextDecoder().decode(fromBase64(file.content)) : "";
}

/** @param {Program} program @param {string} text @returns {Program} */
function withAssumed(program, text) {
  const others = program.files.filter(({ file }) => file !== ASSUMED);
  return { ...program, files: [...others, { file: ASSUMED, content: toBase64(new TextEncoder().encode(text)) }] };
}
