/**
 * The form with the translation options of a program: call interval, block to run, CPU, tags and constants that no
 * source declares, and variables that become inputs, outputs or parameters.
 *
 * @typedef {import("./messages").Program} Program
 * @typedef {import("./messages").Compiled} Compiled
 */

import { choice, element, text } from "tool/dom.js";
import { read } from "tool/values.js";

const CPUS = ["300", "1200", "1500"];
/**
 * The options that are lists of names: key, title, purpose.
 *
 * @type {["inputs" | "outputs" | "parameters", string, string][]}
 */
const LISTS = [
  ["inputs", "Inputs", "Settings or data block members that become inputs"],
  ["outputs", "Outputs", "Locals or data block members that become outputs"],
  ["parameters", "Parameters", "Inputs that become parameters"],
];
/**
 * The options that are pairs of a name and a value: key, title, example, separator.
 *
 * @type {["tags" | "constants", string, string, string][]}
 */
const PAIRS = [
  ["tags", "Tags and instances that no source declares, one per line", "Start : Bool", ":"],
  ["constants", "Constants that no source declares, one per line", "MAX = 5", "="],
];

/** Whether the options are open; kept for when the program is redrawn. */
let isOpen = false;

/**
 * The options, folded.
 *
 * @param {Program} program
 * @param {Compiled} compiled
 * @param {(program: Program) => void} translate
 */
export function optionsForm(program, compiled, translate) {
  const problem = element("p.error", { role: "alert" });
  const cycle = element("input.number", {
    size: 8,
    value: String(compiled.cycle),
    id: "program-cycle",
    autocomplete: "off",
  });
  const cpus = CPUS.map((one) => [one, `S7-${one}`]);
  const cpu = choice({ id: "program-cpu" }, [["", "from the sources"], ...cpus], program.cpu ?? "");
  const run = element("input", {
    ...{
      id: "program-run",
      value: program.run ?? "",
      placeholder: compiled.block || "the only block that no other block calls",
    },
    ...{ spellcheck: "false", autocomplete: "off" },
  });
  const lists = LISTS.map(([key, title, about]) => ({
    key,
    title,
    input: element("input", {
      ...{ id: `program-${key}`, value: (program[key] ?? []).join(", "), title: about, placeholder: "NAME, NAME" },
      ...{ spellcheck: "false", autocomplete: "off" },
    }),
  }));
  const pairs = PAIRS.map(([key, title, example, between]) => {
    const input = element("textarea", { id: `program-${key}`, rows: 3, placeholder: example, spellcheck: "false" });
    input.value = (program[key] ?? []).map(([name, of]) => `${name} ${between} ${of}`).join("\n");
    return { key, title, between, example, input };
  });
  const field = (/** @type {string} */ title, /** @type {HTMLElement} */ input) =>
    element("label.option", element("span", title), input);
  const form = element(
    "form.program-options",
    field("Called every (such as 0.1 s or 100 ms)", cycle),
    field("Block to run", run),
    field("CPU", cpu),
    lists.map(({ title, input }) => field(title, input)),
    pairs.map(({ title, input }) => field(title, input)),
    problem,
    element("button.primary", { type: "submit" }, "Translate"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const got = read(cycle.value, { name: "the time between two calls", kind: "TIME" });
    if ("why" in got) {
      text(problem, got.why);
      cycle.focus();
      return;
    }
    /** @type {Program} */
    const next = { ...program, cycle: Number(got.value), cpu: cpu.value || null, run: run.value.trim() || null };
    for (const { key, input } of lists) next[key] = names(input.value);
    for (const { key, input, between, example } of pairs) {
      const found = pairsOf(input.value, between);
      if (!found) {
        text(problem, `Enter one per line, such as ${example}.`);
        input.focus();
        return;
      }
      next[key] = found;
    }
    text(problem, "");
    translate(next);
  });
  const fold = element("details.options", { open: isOpen }, element("summary", "Options"), form);
  fold.addEventListener("toggle", () => {
    isOpen = fold.open;
  });
  return fold;
}

/** @param {string} text */
function names(text) {
  return text
    .split(",")
    .map((name) => name.trim())
    .filter(Boolean);
}

/**
 * @param {string} text
 * @param {string} between
 * @returns {[string, string][] | undefined}
 */
function pairsOf(text, between) {
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  const pairs = lines.map((line) => {
    const at = line.indexOf(between);
    const halves = [line.slice(0, Math.max(at, 0)), line.slice(at + 1)];
    return /** @type {[string, string]} */ (halves.map((half) => half.trim().replace(/^"|"$/g, "")));
  });
  return pairs.every((pair) => pair.every(Boolean)) ? pairs : undefined;
}
