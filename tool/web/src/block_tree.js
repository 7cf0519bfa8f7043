/**
 * The blocks and instances of a program as a tree, in which the user chooses one to display.
 *
 * @typedef {import("./messages").Compiled} Compiled
 * @typedef {import("./messages").Instance} Instance
 */

import { element } from "tool/dom.js";

/** Whether the tree is open; kept for when the program is redrawn. */
let isOpen = false;

/**
 * The tree; `null` for a program with a single block.
 *
 * @param {Compiled} compiled
 * @param {(block: string, path: string | undefined) => void} choose
 */
export function blockTree({ parts, blocks, sources }, choose) {
  const named = (/** @type {string} */ name) => blocks.find((one) => one.name.toUpperCase() === name.toUpperCase());
  const own = parts.filter((part) => named(part.block));
  // Blocks without an instance: functions, and organization blocks that are not the program itself.
  const others = blocks.filter((block) => !own.some((part) => part.block.toUpperCase() === block.name.toUpperCase()));
  if (own.length + others.length < 2) return null;
  const entry = (/** @type {string} */ text, /** @type {string} */ block, /** @type {string | undefined} */ path) => {
    const at = named(block);
    const title = at && `${sources[at.file].file}, line ${at.line}`;
    return element("button.plain", { title, onclick: () => choose(block, path) }, text);
  };
  /** The instances directly below another, with none in between. @param {Instance} of @returns {Instance[]} */
  const below = (of) =>
    own.filter(
      (part) =>
        part !== of &&
        within(part.path, of.path) &&
        !own.some((one) => one !== of && one !== part && within(one.path, of.path) && within(part.path, one.path)),
    );
  /** @param {Instance} of @returns {HTMLElement} */
  const branch = (of) => {
    const inner = below(of);
    const text = of.path ? `${of.path}: ${of.block}` : of.block;
    return element("li", entry(text, of.block, of.path), inner.length > 0 && list(inner));
  };
  /** @param {Instance[]} of @returns {HTMLElement} */
  const list = (of) => element("ul", of.map(branch));
  const fold = element(
    "details.options.block-tree",
    { open: isOpen },
    element("summary", "Blocks"),
    element(
      "div.program-options",
      list(own.filter(({ path }) => path === "")),
      others.length > 0 &&
        element(
          "ul",
          others.map(({ name }) => element("li", entry(name, name, undefined))),
        ),
    ),
  );
  fold.addEventListener("toggle", () => {
    isOpen = fold.open;
  });
  return fold;
}

/** Whether a path is inside an instance's path. @param {string} path @param {string} of */
function within(path, of) {
  return of === "" ? path !== "" : path.startsWith(`${of}.`);
}
