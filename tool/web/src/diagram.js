/**
 * The live block diagram: values on the wires, switches in their current position, active limits lit.
 *
 * A click on a switch, or Enter, throws it; a click on a value goes to its field.
 */

import { assetOf, drawing } from "tool/assets.js";
import { attribute, element, fill, text } from "tool/dom.js";
import { onceAFrame } from "tool/frame.js";
import { chosenInside, descriptionInside, mountInside } from "tool/inside.js";
import { goTo } from "tool/parameters.js";
import { runValue, store, wiredTo } from "tool/store.js";
import { isBoolean, rounded, shown } from "tool/values.js";

/** The space for a value beside a terminal, in characters, and the width of a character in the drawing. */
const ROOM = 10;
const CHARACTER = 6.7;
/** The key in sessionStorage for the size of the diagram. */
const SIZE = "plcfmu-diagram";

/**
 * The parts of a drawing that show a variable.
 *
 * @typedef {object} Part
 * @property {string} name
 * @property {string} kind
 * @property {Element | undefined} value
 * @property {number} room the room for the value, in characters
 * @property {Element[]} lit the elements lit while a Boolean is TRUE
 * @property {{ group: Element, blades: [boolean, Element][] }[]} switches
 */

/** @type {Part[]} */
let parts = [];
/** @type {string} */
let shownOf = "";
/** The path of the displayed block inside the program, with a trailing dot; empty for the loop's own block. */
let within = "";

/** @param {HTMLElement} content */
export function mount(content) {
  const sheet = element("div.sheet");
  const note = element("p.faint");
  /** @type {["Fit", "Full size"]} */
  const sizes = ["Fit", "Full size"];
  const buttons = sizes.map((size) =>
    element("button", { "aria-pressed": "false", onclick: () => resize(size) }, size),
  );
  const resize = (/** @type {string} */ size) => {
    content.dataset.size = size.split(" ")[0].toLowerCase();
    for (const button of buttons) attribute(button, "aria-pressed", String(button.textContent === size));
    attribute(sheet, "tabindex", size === "Full size" ? "0" : null);
    attribute(sheet, "role", size === "Full size" ? "region" : null);
    attribute(sheet, "aria-label", size === "Full size" ? "Block diagram, scrollable" : null);
    try {
      sessionStorage.setItem(SIZE, size);
    } catch {
      // Without storage, the size is lost on a reload.
    }
    text(note, "Click a switch to throw it, or a value to go to its field.");
  };
  content.append(
    element("div.row.sizes", { role: "group", "aria-label": "Size of the diagram" }, buttons, note),
    sheet,
  );
  mountInside(content);
  resize(sizes.find((size) => size === kept()) ?? "Fit");
  store.on("loop", async () => {
    const loop = store.loop;
    const inside = loop && (await chosenInside(loop));
    const shownNow = inside ? `${loop.description.name} ${inside.path}` : (loop?.description.name ?? "");
    if (loop !== store.loop) return;
    if (shownNow !== shownOf) {
      shownOf = shownNow;
      within = inside ? `${inside.path}.` : "";
      parts = [];
      fill(sheet);
      const asset = loop && (await assetOf(inside?.block ?? loop.description.name));
      if (loop !== store.loop) {
        shownOf = "";
        return;
      }
      const made = asset?.diagram ? drawing(asset.diagram) : undefined;
      if (made && loop) {
        prepare(made, inside ? descriptionInside(loop, inside.path) : loop.description);
        fill(sheet, made);
      } else fill(sheet, element("p.faint", loop ? `${loop.description.block} has no diagram.` : ""));
    }
    due();
  });
  for (const what of ["state", "settings", "plant", "run", "checked"]) store.on(what, due);
}

/** The size stored before a reload, if any. */
function kept() {
  try {
    return sessionStorage.getItem(SIZE);
  } catch {
    return null;
  }
}

const due = onceAFrame(update);

/**
 * Finds the parts of a drawing and makes them interactive.
 *
 * @param {SVGSVGElement} made
 * @param {import("./messages").Description} description
 */
function prepare(made, description) {
  // In an element with the role of a picture, switches would be hidden from screen readers.
  made.setAttribute("role", "group");
  /** @type {Map<string, Part>} */
  const found = new Map();
  const part = (/** @type {string} */ name) => {
    const variable = description.variables.find((one) => one.name === name);
    if (!variable) return undefined;
    const known = found.get(name) ?? { name, kind: variable.kind, value: undefined, room: ROOM, lit: [], switches: [] };
    found.set(name, known);
    return known;
  };
  for (const one of made.querySelectorAll("[id]")) {
    const named = /(?:^|-)(wire|switch|terminal|value)-(.+)$/.exec(one.id);
    if (!named) continue;
    const [, what, rest] = named;
    const name = one.getAttribute("data-variable") ?? rest;
    const of = part(name);
    if (!of) continue;
    if (what === "value") {
      of.value = one;
      of.room = roomOf(one);
    }
    if ((what === "wire" || what === "terminal") && isBoolean(of.kind)) of.lit.push(one);
    if (what === "switch") prepareSwitch(of, one);
    if (what === "terminal") one.addEventListener("click", () => goTo(name));
  }
  for (const one of made.querySelectorAll("[data-variable]:not([id])"))
    one.addEventListener("click", () => goTo(one.getAttribute("data-variable") ?? ""));
  parts = [...found.values()];
}

/**
 * The number of characters that fit between a setting's name in a box and the end of its line.
 *
 * @param {Element} value
 */
function roomOf(value) {
  const name = value.parentElement?.querySelector(".diagram-label");
  if (!name || value.getAttribute("text-anchor") !== "end") return ROOM;
  const width = Number(value.getAttribute("x")) - Number(name.getAttribute("x"));
  return Math.max(3, Math.floor(width / CHARACTER) - (name.textContent ?? "").length - 1);
}

/**
 * Formats a value with as many digits as fit.
 *
 * @param {import("./messages").Value | undefined} value
 * @param {string} kind
 * @param {number} room
 */
function fitting(value, kind, room) {
  let fit = shown(value, kind);
  for (let digits = 9; digits > 1 && fit.length > room; digits -= 1) fit = rounded(value, kind, digits);
  return fit;
}

/**
 * @param {Part} of
 * @param {Element} group
 */
function prepareSwitch(of, group) {
  /** @type {[boolean, Element][]} */
  const blades = [...group.querySelectorAll("[data-value]")].map((blade) => [
    blade.getAttribute("data-value") === "TRUE",
    blade,
  ]);
  of.switches.push({ group, blades });
  const setting = within ? undefined : store.loop?.settings[of.name];
  if (!setting) return;
  // The lines of a switch are thin, so the area around them is clickable, too.
  const box = { x: Infinity, y: Infinity, right: -Infinity, bottom: -Infinity };
  for (const [, blade] of blades) {
    for (const [, x, y] of (blade.getAttribute("d") ?? "").matchAll(/[ML]\s*(-?[\d.]+)[ ,]+(-?[\d.]+)/g)) {
      box.x = Math.min(box.x, Number(x));
      box.right = Math.max(box.right, Number(x));
      box.y = Math.min(box.y, Number(y));
      box.bottom = Math.max(box.bottom, Number(y));
    }
  }
  if (Number.isFinite(box.x)) {
    const area = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    const margin = 7;
    const size = {
      x: box.x - margin,
      y: box.y - margin,
      width: box.right - box.x + 2 * margin,
      height: box.bottom - box.y + 2 * margin,
    };
    for (const [name, value] of Object.entries({ ...size, rx: 3, class: "hit", fill: "transparent" }))
      attribute(area, name, value);
    group.append(area);
  }
  attribute(group, "role", "button");
  attribute(group, "tabindex", "0");
  group.classList.add("is-throwable");
  const title = group.querySelector("title");
  if (title) text(title, `${of.name}: click to throw it. ${title.textContent ?? ""}`);
  const turn = async () => {
    const loop = store.loop;
    if (!loop || wiredTo(loop, of.name)) return;
    const now = runValue(loop, of.name) ?? loop.settings[of.name].sent;
    await store.now({ [of.name]: !now }).catch(store.say);
  };
  group.addEventListener("click", turn);
  group.addEventListener("keydown", (event) => {
    const { key } = /** @type {KeyboardEvent} */ (event);
    if (key !== "Enter" && key !== " ") return;
    event.preventDefault();
    event.stopPropagation();
    turn();
  });
}

/** Shows the values of the run or, without a run, the values in force. */
function update() {
  const loop = store.loop;
  if (!loop) return;
  for (const part of parts) {
    const own = within ? startOf(loop, within + part.name) : loop.settings[part.name]?.sent;
    const value = runValue(loop, within + part.name) ?? own;
    if (part.value) {
      text(part.value, fitting(value, part.kind, part.room));
    }
    for (const one of part.lit) one.classList.toggle("is-true", value === true && isLit(loop, part.name));
    for (const { group, blades } of part.switches) {
      for (const [at, blade] of blades) attribute(blade, "visibility", at === Boolean(value) ? null : "hidden");
      if (group.getAttribute("role") !== "button") continue;
      attribute(group, "aria-pressed", String(Boolean(value)));
      attribute(group, "aria-label", `${part.name} is ${value ? "TRUE" : "FALSE"}`);
    }
  }
}

/** @param {import("./store.js").Work} loop @param {string} name */
function startOf(loop, name) {
  return loop.description.variables.find((one) => one.name === name)?.start;
}

/**
 * Whether a Boolean is lit while TRUE: only outputs are, which signal that something is active, such as a limit. A
 * setting shows its state by the position of its switch.
 *
 * @param {import("./store.js").Work} loop
 * @param {string} name
 */
function isLit(loop, name) {
  return !(name in loop.settings);
}
