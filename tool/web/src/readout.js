/**
 * The values above the curves: current, or at the cursor. Each name is a button that hides or shows its curve.
 *
 * @typedef {import("tool/curves.js").Curve} Curve
 *
 * @typedef {object} Shown the displayed value of a curve
 * @property {string} text with a limited number of digits
 * @property {string} full with all digits
 */

import { swatch, theme } from "tool/charts.js";
import { attribute, element, fill, text } from "tool/dom.js";

/**
 * @param {HTMLElement} within
 * @param {Curve[]} curves
 * @param {{ isShown: (curve: Curve) => boolean, toggle: (curve: Curve) => void, remove: (curve: Curve) => void }} how
 * @returns {(read: (curve: Curve) => Shown, when: string, mode: string) => void} shows values
 */
export function makeReadout(within, curves, { isShown, toggle, remove }) {
  const { curves: palette } = theme();
  const badge = element("span.mode");
  const cells = curves.map((curve) => {
    const value = element("span.value.number");
    const name = element(
      "button.curve-name",
      {
        ...{ "aria-pressed": String(isShown(curve)) },
        ...{ onclick: () => toggle(curve), title: isShown(curve) ? `Hide ${curve.name}` : `Show ${curve.name}` },
      },
      swatch(isShown(curve) ? palette[curve.colour % palette.length] : "transparent", curve.isDashed),
      element("span.name", curve.label),
    );
    const gone = curve.isOfChoice
      ? element("button.plain.remove", { "aria-label": `Remove ${curve.name}`, onclick: () => remove(curve) }, "×")
      : null;
    const unit = element("span.unit.faint", curve.unit);
    return {
      curve,
      value,
      cell: element("div", { class: curve.isMain ? "signal is-main" : "signal" }, name, value, unit, gone),
    };
  });
  fill(
    within,
    cells.filter(({ curve }) => curve.isMain).map(({ cell }) => cell),
    badge,
    cells.filter(({ curve }) => !curve.isMain).map(({ cell }) => cell),
  );
  return (read, heading, mode) => {
    for (const { curve, value } of cells) {
      const { text: brief, full } = read(curve);
      text(value, brief);
      attribute(value, "title", full || undefined);
      attribute(value, "data-full", full || undefined);
    }
    text(badge, heading || mode);
    badge.hidden = badge.textContent === "";
  };
}
