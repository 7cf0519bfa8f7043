/**
 * A preview of a file to be saved: each setting of each loop that differs, with its old and its new value, and each
 * edit that has not been applied and therefore will not be saved.
 *
 * @typedef {import("tool/store.js").Work} Work
 * @typedef {import("tool/store.js").Setting} Setting
 */

import { element, fill, tableHead } from "tool/dom.js";
import { manualSwitch } from "tool/signals.js";
import { isEdited, store } from "tool/store.js";
import { same, shown } from "tool/values.js";

/** The maximum number of rows in the table. */
const MOST = 40;

/**
 * Whether a stimulus, such as a setpoint or a mode, differs between run and file.
 *
 * @param {Setting} one
 */
export function isTried(one) {
  return one.variable.is_stimulus && isChanged(one);
}

/** Whether the value in force differs from the file. @param {Setting} one */
function isChanged(one) {
  return !same(one.variable.kind, one.sent, one.file ?? one.start);
}

/**
 * Whether the saved file would leave a loop in manual mode: in the PLC, the loop would not be controlled.
 *
 * @param {Work} loop
 * @param {boolean} withTried
 */
function staysManual(loop, withTried) {
  const name = manualSwitch(loop);
  const mode = name === undefined ? undefined : loop.settings[name];
  if (!mode || (withTried ? mode.sent : (mode.file ?? mode.start)) !== true) return false;
  return Object.values(loop.settings).some(isChanged);
}

/**
 * Shows what will be saved.
 *
 * @param {HTMLElement} within
 * @param {Work[]} loops the loops in the file
 * @param {boolean} withTried whether the file also contains the stimuli of the run
 */
export function showSaved(within, loops, withTried) {
  const all = loops.flatMap((loop) => Object.entries(loop.settings).map(([name, one]) => ({ loop, name, one })));
  const changed = all.filter(({ one }) => isChanged(one) && (withTried || !one.variable.is_stimulus));
  const isAlone = loops.length === 1;
  const title = (/** @type {Work} */ loop, /** @type {string} */ name) => (isAlone ? name : `${loop.name}: ${name}`);
  const unsent = all.filter(({ one }) => isEdited(one));
  const manual = loops.filter((loop) => staysManual(loop, withTried));
  const apply = async () => {
    for (const loop of loops) await store.send(undefined, loop);
  };
  fill(
    within,
    unsent.length > 0 &&
      element(
        "div.unsent.note",
        element(
          "ul",
          unsent.slice(0, MOST).map(({ loop, name, one }) => {
            const kept = shown(one.sent, one.variable.kind);
            const edit = one.wrong ?? shown(one.value, one.variable.kind);
            const what = `${title(loop, name)} has an edit (${edit}) that is not applied and will not be saved; `;
            return element("li", `${what}the file will contain ${kept}.`);
          }),
        ),
        element("button", { onclick: apply }, "Apply all edits"),
      ),
    changed.length === 0
      ? element("p.faint", "No setting differs from the file or the block's start values.")
      : element(
          "table.to-save",
          tableHead(
            ["Setting", loops.some(({ file }) => file) ? "In the file" : "Start value", "Saved"],
            (at) => at > 0,
          ),
          element(
            "tbody",
            changed
              .slice(0, MOST)
              .map(({ loop, name, one: { variable, file, start, sent } }) =>
                element(
                  "tr",
                  element("td.name", title(loop, name)),
                  element("td.number", shown(file ?? start, variable.kind)),
                  element("td.number", shown(sent, variable.kind)),
                ),
              ),
          ),
        ),
    changed.length > MOST && element("p.faint", `and ${changed.length - MOST} more`),
    manual.length > 0 &&
      element(
        "ul.note",
        manual.slice(0, MOST).map((loop) => {
          const { manual, manual_pulses: pulses } = loop.description.roles;
          const outputs = (manual?.slice(1) ?? pulses?.[1] ?? []).map((name) => {
            const { sent, file, start, variable } = loop.settings[name];
            return `${name} ${shown(withTried ? sent : (file ?? start), variable.kind)}`;
          });
          const mode = title(loop, manualSwitch(loop) ?? "");
          return element(
            "li",
            `${mode} is TRUE in the saved file: the controller starts in manual mode, with ${outputs.join(" and ")}.`,
          );
        }),
      ),
  );
}
