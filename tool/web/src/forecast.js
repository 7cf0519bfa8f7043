/**
 * Compares the figures of the last setpoint step with those predicted by the identified plant for the settings then in
 * force. This reveals a wrong model.
 *
 * @typedef {import("./messages").Figures} Figures
 */

import { element, fill, tableHead } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { stepText, valueText } from "tool/figures.js";
import { store } from "tool/store.js";

/** The latest figures that arrived while a request was pending. @type {Figures | undefined} */
let next;
let isAsking = false;

/**
 * Creates an element that shows the comparison, once computed settings have been applied and the run has a setpoint
 * step.
 *
 * @returns {HTMLElement}
 */
export function forecast() {
  const place = element("div.forecast", { "aria-live": "polite" });
  store.on("figures", async (/** @type {Figures} */ figures) => {
    next = figures;
    if (isAsking) return;
    isAsking = true;
    while (next) {
      const now = next;
      next = undefined;
      await show(place, now);
    }
    isAsking = false;
  });
  for (const what of ["run", "loop"]) store.on(what, () => fill(place));
  return place;
}

/** @param {HTMLElement} place @param {Figures} figures */
async function show(place, { step, figures }) {
  const { loop, state } = store;
  const tuning = /** @type {import("./messages").Tuning | undefined} */ (loop?.notes.tune?.applied);
  if (!tuning || step?.cause !== "setpoint") return fill(place);
  // If the step cannot be predicted, the page shows nothing; the report states the reason.
  const of = await ask({ do: "forecast", tuning }).catch(() => null);
  if (store.loop !== loop || store.state?.run !== state?.run) return;
  const both = figures.filter(({ key, value }) => of && value !== null && key in of.figures);
  if (!of || both.length === 0) return fill(place);
  const row = (/** @type {string} */ name, /** @type {(one: typeof both[number]) => number | null} */ value) =>
    element(
      "tr",
      element("th", { scope: "row" }, name),
      both.map((one) => element("td.number", valueText(value(one) ?? 0, one.unit))),
    );
  fill(
    place,
    element("p.faint", `The step from ${stepText(step)}, with ${of.settings}:`),
    element(
      "div.wide",
      { tabindex: 0, role: "region", "aria-label": "Predicted and run" },
      element(
        "table",
        tableHead(["", ...both.map(({ title }) => title)], (at) => at > 0),
        element(
          "tbody",
          row("predicted", ({ key }) => of.figures[key]),
          row("run", ({ value }) => value),
        ),
      ),
    ),
    // Show the verdict only while the run is paused.
    store.isRunning ? null : element("p", of.verdict),
  );
}
