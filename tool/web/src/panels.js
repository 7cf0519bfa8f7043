/**
 * The panels around the curves: tabs below them, or beside them on a wide screen, and drawers that open over them. The
 * current tab and the height of the tabs are kept in localStorage.
 */

import { attribute, byId, element } from "tool/dom.js";
import { store } from "tool/store.js";

/** The tabs: panel id and title. The panel `side` is a tab only on a narrow screen. @type {[string, string][]} */
const TABS = [
  ["side", "Parameters"],
  ["program", "Program"],
  ["watch", "Watch"],
  ["diagram", "Diagram"],
  ["plant", "Plant"],
  ["tune", "Tune"],
  ["runs", "Runs"],
  ["replay", "Replay"],
  ["done", "Log"],
];
const [FIRST, FIRST_NARROW] = ["plant", "side"];
/** The id of each drawer's panel, and the id of the button that opens it. @type {Record<string, string>} */
const DRAWERS = { opening: "open-button", compare: "compare-button", takeaway: "away-button", help: "help-button" };
const [TAB, HEIGHT] = ["plcfmu-tab", "plcfmu-panels"];
const STEP = 24;

const narrow = matchMedia("(max-width: 66rem)");
let shown = narrow.matches ? FIRST_NARROW : FIRST;

export function mount() {
  const tabs = TABS.map(([id, title]) =>
    element("button", { role: "tab", id: `tab-${id}`, "aria-controls": id, onclick: () => showTab(id) }, title),
  );
  const list = byId("tabs");
  list.append(...tabs);
  list.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const visible = tabs.filter((tab) => tab.offsetParent !== null);
    const at = visible.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    if (by === undefined || at < 0) return;
    event.preventDefault();
    event.stopPropagation();
    const next = visible[(at + by + visible.length) % visible.length];
    next.focus();
    next.click();
  });
  for (const [id] of TABS) {
    if (id === "side") continue;
    attribute(byId(id), "role", "tabpanel");
    attribute(byId(id), "aria-labelledby", `tab-${id}`);
  }
  const wanted = kept(TAB);
  showTab(TABS.find(([id]) => id === wanted)?.[0] ?? shown);
  narrow.addEventListener("change", () => showTab(shown));
  store.on("show", (id) => {
    if (id in DRAWERS) return toggleDrawer(id, true);
    // On a wide screen, the parameters are always visible and are not a tab.
    const isTab = TABS.some(([panel]) => panel === id) && (id !== "side" || narrow.matches);
    if (isTab) showTab(id);
  });
  mountSplit();
}

/**
 * Shows a tab.
 *
 * @param {string} id panel id
 */
function showTab(id) {
  shown = id;
  const visible = id === "side" && !narrow.matches ? FIRST : id;
  document.body.dataset.tab = visible;
  for (const [panel] of TABS) {
    const tab = byId(`tab-${panel}`);
    attribute(tab, "aria-selected", String(panel === visible));
    attribute(tab, "tabindex", panel === visible ? "0" : "-1");
    if (panel !== "side") byId(panel).hidden = panel !== visible;
  }
  keep(TAB, id);
  store.emit("tab", visible);
}

/**
 * Opens or closes a drawer. At most one drawer is open, apart from the first page.
 *
 * @param {string} id
 * @param {boolean} [isOpen] toggles by default
 */
export function toggleDrawer(id, isOpen = Boolean(byId(id).hidden)) {
  for (const other of Object.keys(DRAWERS)) {
    const isFirstPage = other === "opening" && !store.loop;
    if (other !== id && !isFirstPage) byId(other).hidden = true;
  }
  const panel = byId(id);
  panel.hidden = !isOpen;
  for (const [drawer, button] of Object.entries(DRAWERS))
    attribute(byId(button), "aria-expanded", String(!byId(drawer).hidden));
  if (isOpen) {
    store.emit(`open-${id}`);
    panel.scrollTop = 0;
    /** @type {HTMLElement | null} */ (panel.querySelector("button, input, select"))?.focus({ preventScroll: true });
  } else byId(DRAWERS[id]).focus();
}

/** Closes the open drawer, if any. @returns {boolean} whether one was open */
export function closeDrawer() {
  const open = Object.keys(DRAWERS).find((id) => !byId(id).hidden && (id !== "opening" || store.loop));
  if (open) toggleDrawer(open, false);
  return open !== undefined;
}

/** Makes the edge between the curves and the tabs movable with the pointer or the arrow keys. */
function mountSplit() {
  const split = byId("split");
  const panels = byId("panels");
  const work = byId("work");
  const about = {
    role: "separator",
    tabindex: 0,
    "aria-label": "Height of the panels",
    "aria-orientation": "horizontal",
  };
  for (const [name, value] of Object.entries({ ...about, "aria-valuenow": 0 })) attribute(split, name, value);
  /** @param {number} height */
  const set = (height) => {
    const most = work.clientHeight - 180;
    const fit = Math.round(Math.min(Math.max(height, 40), Math.max(most, 40)));
    work.style.setProperty("--panels", `${fit}px`);
    attribute(split, "aria-valuenow", fit);
    keep(HEIGHT, String(fit));
  };
  const before = Number(kept(HEIGHT));
  if (before > 0) work.style.setProperty("--panels", `${before}px`);
  split.addEventListener("pointerdown", (event) => {
    split.setPointerCapture(event.pointerId);
    const [from, height] = [event.clientY, panels.clientHeight];
    const move = (/** @type {PointerEvent} */ moved) => set(height + from - moved.clientY);
    split.addEventListener("pointermove", move);
    split.addEventListener("pointerup", () => split.removeEventListener("pointermove", move), { once: true });
  });
  split.addEventListener("keydown", (event) => {
    const by = { ArrowUp: STEP, ArrowDown: -STEP }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    set(panels.clientHeight + by);
  });
  split.addEventListener("dblclick", () => {
    work.style.removeProperty("--panels");
    keep(HEIGHT, "");
  });
}

/** @param {string} key */
function kept(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

/** @param {string} key @param {string} value */
function keep(key, value) {
  try {
    localStorage.setItem(key, value);
  } catch {
    // Without storage, the value is lost on a reload.
  }
}
