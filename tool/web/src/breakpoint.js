/**
 * A breakpoint: a condition on a variable. The run pauses after the call in which the condition becomes true.
 *
 * @typedef {import("./messages").Until} Until
 */

import { element, text } from "tool/dom.js";
import { signals } from "tool/signals.js";
import { store } from "tool/store.js";

/** A condition such as `level > 95`, `valve` or `NOT valve`. */
const CONDITION = /^\s*(NOT\s+)?(.+?)\s*(?:(<=|>=|<>|=|<|>)\s*(\S+))?\s*$/i;

/** The input field for the breakpoint. */
export function breakpointField() {
  const input = element("input", {
    ...{ id: "breakpoint", placeholder: "level > 95, valve, NOT valve", spellcheck: "false", autocomplete: "off" },
    ...{ list: "watch-names", "aria-describedby": "breakpoint-said" },
  });
  const said = element("span.error", { id: "breakpoint-said", role: "alert" });
  const show = () => {
    input.value = store.loop?.notes.breakpoint?.text ?? "";
    text(said, "");
  };
  input.addEventListener("change", async () => {
    const loop = store.loop;
    if (!loop) return;
    const condition = await read(input.value);
    if (store.loop !== loop) return;
    text(said, typeof condition === "string" ? condition : "");
    input.setAttribute("aria-invalid", String(typeof condition === "string"));
    if (typeof condition === "string") return;
    loop.notes.breakpoint = condition && { text: input.value.trim(), condition };
    store.emit("settings", []);
  });
  store.on("loop", show);
  show();
  return element("label.row", { for: "breakpoint" }, "Pause when", input, said);
}

/** The breakpoint of the current loop, if it has one. @returns {Until | undefined} */
export function breakpoint() {
  return store.loop?.notes.breakpoint?.condition;
}

/**
 * Parses a condition; returns an error message if it is invalid, and `undefined` if the text is empty.
 *
 * @param {string} of
 * @returns {Promise<Until | string | undefined>}
 */
async function read(of) {
  const loop = store.loop;
  if (!of.trim() || !loop) return undefined;
  const [, not, name, sign, value] = CONDITION.exec(of) ?? [];
  const wanted = name.toUpperCase();
  const all = await signals(loop);
  const own = `${loop.member}.`.toUpperCase();
  const found = all.find((one) => [wanted, own + wanted].includes(one.name.toUpperCase()));
  if (!found) return `${name} is not a variable: choose one from the list.`;
  if (!sign) return { variable: found.name, sign: "=", value: not ? 0 : 1 };
  const truth = { TRUE: 1, FALSE: 0 }[value.toUpperCase()];
  const number = truth ?? Number(value.replace(",", "."));
  if (Number.isNaN(number)) return `${value} is not a number: enter ${found.name} ${sign} 1.5, for example.`;
  return { variable: found.name, sign: /** @type {Until["sign"]} */ (sign), value: number };
}
