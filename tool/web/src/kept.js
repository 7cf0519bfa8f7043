/**
 * The last sessions, which outlive their tabs: kept in localStorage, also for the page opened as a file. The first page
 * offers them. Each tab has one session.
 *
 * @typedef {object} KeptSession
 * @property {string} id
 * @property {string} title the names of its loops
 * @property {number} time when it was last saved, in milliseconds
 * @property {string} content
 */

import { whereIsTheEngine } from "tool/engine.js";

const KEY = "plcfmu-sessions";
/** The session of this tab. */
const OWN = "plcfmu-session";
/** The number of sessions kept, each of limited length: a browser has room for some 5 million characters. */
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

/** @param {KeptSession[]} kept the oldest are dropped if there is no room for all */
function write(kept) {
  for (let count = Math.min(kept.length, MOST); count >= 0; count -= 1) {
    try {
      if (count === 0) localStorage.removeItem(KEY);
      else localStorage.setItem(KEY, JSON.stringify(kept.slice(0, count)));
      return;
    } catch {
      // The storage is full or missing.
    }
  }
}

/**
 * Saves the session of this tab, unless the page comes from a server: the next server has a new address and would not
 * find it.
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
 * Makes a saved session the session of this tab; a reload restores it.
 *
 * @param {KeptSession} session
 * @param {string} key storage key of the content that survives a reload
 */
export function takeUp({ id, content }, key) {
  sessionStorage.setItem(OWN, id);
  sessionStorage.setItem(key, content);
}

/** @param {string} [id] by default, all */
export function forget(id) {
  write(id === undefined ? [] : keptSessions().filter((one) => one.id !== id));
}
