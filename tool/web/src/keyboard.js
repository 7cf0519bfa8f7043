/**
 * The keys for the whole page. Most of them work only outside fields. The panels act on them by listening to events of
 * the store.
 */

import { closeDrawer, toggleDrawer } from "tool/panels.js";
import { store } from "tool/store.js";

/** @type {Record<string, string>} */
const EVENTS = {
  " ": "key-run",
  ".": "key-call",
  m: "key-manual",
  M: "key-manual",
  ArrowLeft: "key-left",
  ArrowRight: "key-right",
  Home: "key-home",
  End: "key-end",
  "+": "key-zoom-in",
  "=": "key-zoom-in",
  "-": "key-zoom-out",
};

export function mount() {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented) return;
    const target = event.target instanceof Element ? event.target : null;
    const isCommand = (event.ctrlKey || event.metaKey) && !event.altKey;
    if (isCommand && command(event, target)) return event.preventDefault();
    if (isCommand || event.altKey) return;
    if (event.key === "Escape") {
      if (closeDrawer()) event.preventDefault();
      return;
    }
    if (event.key === "F1") {
      event.preventDefault();
      return toggleDrawer("help", true);
    }
    if (isTyped(target)) return;
    if (event.key === "?") {
      event.preventDefault();
      return toggleDrawer("help");
    }
    if (!store.loop) return;
    const what = EVENTS[event.key];
    if (!what) return;
    // Space activates the focused button or switch.
    if (event.key === " " && target?.closest("button, summary, a, input, [role=button]")) return;
    event.preventDefault();
    store.emit(what, event);
  });
}

/**
 * @param {KeyboardEvent} event
 * @param {Element | null} target
 * @returns {boolean} whether the key was a command
 */
function command(event, target) {
  const isOther = isTyped(target) && !target?.closest("#parameters");
  const key = event.key.toLowerCase();
  if (key === "enter") store.send();
  else if (isOther) return false;
  else if (key === "z" && !event.shiftKey) store.undo();
  else if (key === "y" || key === "z") store.redo();
  else return false;
  return true;
}

/**
 * Whether the target is a field that receives typed keys.
 *
 * @param {Element | null} target
 */
function isTyped(target) {
  if (target instanceof HTMLInputElement) return target.type !== "checkbox";
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;
}
