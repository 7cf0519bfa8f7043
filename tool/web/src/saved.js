/**
 * A preview of a file to be saved: the settings that differ from the loop's file or from the start values, with their
 * old and new values, and the edits that are not saved because they have not been applied.
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
 * Whether a setting is a stimulus, such as a setpoint or a mode, whose value in force differs from the file.
 *
 * @param {Setting} one
 */
export function isTried(one) {
  return one.variable.is_stimulus && isChanged(one);
}

/** Whether the value in force differs from the file or, without one, from the start value. @param {Setting} one */
function isChanged(one) {
  return !same(one.variable.kind, one.sent, one.file ?? one.start);
}

/**
 * Whether a loop with changed settings would start in manual mode with the saved file, so that the PLC would not
 * control it.
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
 * @param {boolean} withTried whether the saved file also contains the current stimuli
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
