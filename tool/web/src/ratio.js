/**
 * The ratio of heating gain to cooling gain, from a model of each.
 *
 * @typedef {import("./messages").Model} Model
 */

import { element, fill, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { store } from "tool/store.js";
import { rounded } from "tool/values.js";

/**
 * A row in which the user stores a model for heating and one for cooling; the ratio is computed from both. `null` for a
 * block without a setting for the ratio.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {{ heating: Model | undefined, cooling: Model | undefined }} kept
 * @param {() => Model | string | undefined} model returns the current model, or why there is none
 */
export function ratioRow(loop, kept, model) {
  const factor = loop.description.roles.pulse_former[2];
  if (!factor) return null;
  const row = element("div.row");
  const result = element("span", { "aria-live": "polite" });
  /** @param {"heating" | "cooling"} which */
  const take = (which) => {
    const now = model();
    if (typeof now !== "object") {
      text(result, now ?? "Identify a step first.");
      return;
    }
    kept[which] = now;
    show();
  };
  /** @param {Model | undefined} of */
  const gain = (of) => (of ? `K ${rounded(of.gain, "LREAL", 4)}` : "none yet");
  const compute = async () => {
    if (!kept.heating || !kept.cooling) return;
    try {
      const ratio = await ask({ do: "ratio", heating: kept.heating, cooling: kept.cooling });
      fill(
        result,
        `${factor} ${rounded(ratio.ratio, "REAL", 5)} `,
        element("button", { onclick: () => store.edit({ [factor]: ratio.ratio }) }, "Apply"),
        ...ratio.remarks.map((remark) => element("span.faint", ` ${remark}`)),
      );
    } catch (error) {
      text(result, error instanceof Error ? error.message : String(error));
    }
  };
  const show = () => {
    fill(
      row,
      element("span.what", { title: factor }, factor.slice(factor.lastIndexOf(".") + 1)),
      element("button", { onclick: () => take("heating") }, "This model is heating"),
      element("span.faint", gain(kept.heating)),
      element("button", { onclick: () => take("cooling") }, "This model is cooling"),
      element("span.faint", gain(kept.cooling)),
      result,
    );
    compute();
  };
  show();
  return row;
}
