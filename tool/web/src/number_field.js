/**
 * A number field that takes effect on Enter, without Apply.
 *
 * @typedef {import("./messages").Value} Value
 */

import { attribute, element, numberInput } from "tool/dom.js";
import { unitText } from "tool/signals.js";
import { number, read, shown } from "tool/values.js";

/**
 * Creates a number field. Enter sets the value; Esc restores the last value set.
 *
 * @param {string} label
 * @param {string} id
 * @param {{ name: string, kind: string, unit: string | null }} of
 * @param {Value} value
 * @param {(value: number) => void} set
 */
export function numberField(label, id, of, value, set) {
  const input = numberInput({ id, size: 7, value: shown(value, of.kind) });
  const check = () => {
    const got = read(input.value, of);
    const why = "why" in got ? got.why : undefined;
    attribute(input, "aria-invalid", why ? "true" : undefined);
    input.setCustomValidity(why ?? "");
    attribute(input, "title", why);
    return "value" in got ? number(got.value) : undefined;
  };
  const enter = () => {
    const got = check();
    if (got === undefined) input.reportValidity();
    else set(got);
  };
  input.addEventListener("input", check);
  let before = value;
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") enter();
    if (event.key === "Escape") {
      input.value = shown(before, of.kind);
      check();
    }
  });
  /** @param {Value} next */
  const follow = (next) => {
    const isTyped = document.activeElement === input && input.value !== shown(before, of.kind);
    before = next;
    if (isTyped) return;
    input.value = shown(next, of.kind);
    check();
  };
  const unit = unitText(of.unit);
  const row = element("label", { for: id }, label, " ", input, unit && element("span.faint", ` ${unit}`));
  return { row, input, check, enter, follow };
}
