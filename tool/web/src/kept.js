/**
 * Keeps the last sessions in localStorage, where they outlive their tabs, even if the page was opened as a file. The
 * first page offers them. Each tab has one session.
 *
 * @typedef {object} KeptSession
 * @property {string} id
 * @property {string} title the names of its loops
 * @property {number} time when it was last saved, in milliseconds
 * @property {string} content
 */

import { whereIsTheEngine } from "tool/engine.js";

const KEY = "plcfmu-sessions";
/** The key in sessionStorage for the id of this tab's session. */
const OWN = "plcfmu-session";
/** The maximum number of sessions and the maximum length of each: a browser has room for some 5 million characters. */
const MOST = 5;
const LARGEST = 800_000;

/** @returns {KeptSession[]} the latest first */
export function keptSessions() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(kept) ? kept : [];
  } catch {
    return [];
  }
}

/** @param {KeptSession[]} kept latest first; the oldest are dropped if there is no room for all */
function write(kept) {
  for (let count = Math.min(kept.length, MOST); count >= 0; count -= 1) {
    try {
      if (count === 0) localStorage.removeItem(KEY);
      else localStorage.setItem(KEY, JSON.stringify(kept.slice(0, count)));
      return;
    } catch {
      // The storage is full or not available: try with fewer sessions.
    }
  }
}

/**
 * Saves the session of this tab, unless the page comes from a server: storage belongs to an address, and the next
 * server has another one.
 *
 * @param {string} title
 * @param {string} content
 */
export function keepSession(title, content) {
  if (whereIsTheEngine() !== "page" || content.length > LARGEST) return;
  let id = sessionStorage.getItem(OWN);
  if (!id) {
    id = `${Date.now()}-${Math.random()}`;
    sessionStorage.setItem(OWN, id);
  }
  const others = keptSessions().filter((one) => one.id !== id);
  write([{ id, title, time: Date.now(), content }, ...others]);
}

/**
 * Makes a saved session the session of this tab. It is restored when the page is reloaded.
 *
 * @param {KeptSession} session
 * @param {string} key the key in sessionStorage from which a reload restores the content
 */
export function takeUp({ id, content }, key) {
  sessionStorage.setItem(OWN, id);
  sessionStorage.setItem(key, content);
}

/** @param {string} [id] by default, all */
export function forget(id) {
  write(id === undefined ? [] : keptSessions().filter((one) => one.id !== id));
}
