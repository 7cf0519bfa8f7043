/**
 * The settings of the current loop, grouped as in the vendor's dialog.
 *
 * Edits take effect only when they are applied: Enter applies all edits; Esc discards the edit of one field. Invalid
 * text stays in its field with a message, and the value in force remains. Settings without effect are folded away at
 * the end of their group.
 *
 * @typedef {import("./store.js").Work} Work
 * @typedef {import("./store.js").Setting} Setting
 */

import { mount as characteristic } from "tool/characteristic.js";
import { attribute, byId, element, fill, text } from "tool/dom.js";
import { onceAFrame } from "tool/frame.js";
import { fieldHelp } from "tool/help.js";
import { actingInputs, mount as inputs } from "tool/inputs.js";
import { programOf } from "tool/program.js";
import { unitText } from "tool/signals.js";
import { isEdited, runValue, source, store, wiredTo } from "tool/store.js";
import { isBoolean, isTime, number, plcTime, read, rounded, shown } from "tool/values.js";

/**
 * A row of the panel.
 *
 * @typedef {object} Row
 * @property {HTMLElement} row
 * @property {HTMLInputElement} input
 * @property {HTMLElement} tag
 * @property {HTMLElement} grey
 * @property {HTMLElement} remark
 * @property {HTMLElement} group container for the rows in its group whose settings have an effect
 * @property {HTMLElement} folded container for the other rows in its group
 */

/** @type {Map<string, Row>} */
let rows = new Map();
/**
 * The groups of the current loop.
 *
 * @type {{ box: HTMLElement, used: HTMLElement, fold: HTMLDetailsElement, folded: HTMLElement, summary: HTMLElement, names: string[] }[]}
 */
let groups = [];
/** The groups unfolded by the user, as FMU and title. @type {Set<string>} */
const unfolded = new Set();

/** The controller structures, each with the values of the P, I and D switches. @type {[string, string][]} */
const STRUCTURES = [
  ["P", "100"],
  ["PI", "110"],
  ["PD", "101"],
  ["PID", "111"],
  ["I", "010"],
  ["ID", "011"],
  ["D", "001"],
  ["none", "000"],
];
const USUAL = 4;

/** @param {HTMLElement} content */
export function mount(content) {
  const send = element("button.primary", { id: "send", onclick: () => store.send() }, "Apply");
  const back = element("button", { id: "take-back", onclick: () => store.takeBack(store.edited()) }, "Discard");
  const count = element("span.faint", { id: "edited-count", role: "status" });
  const bar = element("div.row.send", send, back, count);
  const warnings = element("ul.warnings");
  const list = element("div", { id: "fields" });
  const acting = element("div");
  content.append(bar, warnings, acting, list);
  inputs(acting);
  characteristic(content);
  const showBar = () => {
    const edited = store.edited().length;
    attribute(send, "disabled", edited === 0);
    attribute(back, "disabled", edited === 0);
    text(count, edited === 0 ? "All in force" : `${edited} edited, not applied`);
  };
  store.on("loop", () => {
    build(list);
    place();
    showBar();
  });
  store.on("settings", (names) => {
    for (const name of names) showField(name);
    showStructure();
    showBar();
  });
  store.on("checked", () => {
    place();
    const others = store.loop?.checked?.remarks.filter((remark) => fieldOf(remark) === undefined) ?? [];
    fill(
      warnings,
      others.map((one) => element("li", { class: one.is_error ? "error" : "note" }, one.text)),
    );
    for (const name of rows.keys()) showField(name);
  });
  const showAll = () => {
    findActing();
    for (const name of rows.keys()) showField(name);
    showGroups();
  };
  for (const what of ["plant", "run"]) store.on(what, showAll);
  const showWired = onceAFrame(() => {
    for (const name of rows.keys()) if (store.loop && wiredTo(store.loop, name)) showField(name);
  });
  store.on("state", showWired);
}

/**
 * Goes to a field, opening its fold if necessary.
 *
 * @param {string} name
 * @returns {boolean} whether the field exists
 */
export function goTo(name) {
  const row = rows.get(name);
  const input = document.querySelector(`[data-input="${CSS.escape(name)}"] :is(input, button)`);
  if (input instanceof HTMLElement) {
    store.emit("show", "side");
    input.focus();
    return true;
  }
  if (!row) return false;
  const fold = row.row.closest("details");
  if (fold) fold.open = true;
  store.emit("show", "side");
  row.row.scrollIntoView({ block: "nearest" });
  if (row.input.offsetParent) row.input.focus();
  else byId("structure").focus();
  row.input.select?.();
  return true;
}

/** @param {HTMLElement} list */
function build(list) {
  findActing();
  rows = new Map();
  groups = [];
  const loop = store.loop;
  list.textContent = "";
  if (!loop) return;
  for (const group of inOrder(loop.description)) {
    const names = group.fields.map((field) => field.name).filter((name) => name in loop.settings);
    if (names.length === 0) continue;
    const id = `group-${groups.length}`;
    const used = element("div.fields");
    const folded = element("div.fields");
    const summary = element("summary");
    const key = `${loop.description.name} ${group.title}`;
    const fold = element("details", { open: unfolded.has(key) }, summary, folded);
    fold.addEventListener("toggle", () => {
      if (fold.open) unfolded.add(key);
      else unfolded.delete(key);
      place();
    });
    const box = element(
      "section.group",
      { "aria-labelledby": id },
      // A program's unconnected inputs are listed above, so this group contains only connected ones.
      element("h3", { id }, programOf(loop) && group.title === "Inputs" ? "Connected inputs" : group.title),
      used,
      fold,
    );
    for (const name of names) rows.set(name, makeRow(loop, name, used, folded));
    if (names.includes(loop.description.roles.structure[0])) used.append(makeStructure(loop));
    groups.push({ box, used, fold, folded, summary, names });
    list.append(box);
  }
  for (const name of rows.keys()) showField(name);
  showGroups();
  showStructure();
}

/** Hides groups in which all inputs take effect immediately: they contain nothing to edit. */
function showGroups() {
  for (const { box, names } of groups) box.hidden = names.every((name) => actingNames.has(name));
}

/** The inputs that take effect immediately and therefore have no field here. @type {Set<string>} */
let actingNames = new Set();

/** Updates `actingNames`, which depends on the connections. */
function findActing() {
  actingNames = new Set(store.loop ? actingInputs(store.loop).map(({ name }) => name) : []);
}

/**
 * The groups in order of use: first those with the setpoint, then those with tuning settings, so that these are visible
 * even below a list of loops, then the rest.
 *
 * @param {import("./messages").Description} description
 */
function inOrder({ groups, roles }) {
  const tuned = [...roles.structure, ...roles.controller];
  /** @param {typeof groups[number]} group */
  const rank = ({ fields }) => {
    const has = (/** @type {(string | null)[]} */ names) => fields.some(({ name }) => names.includes(name));
    return has([roles.setpoint]) ? 0 : has(tuned) ? 1 : 2;
  };
  return groups.toSorted((one, other) => rank(one) - rank(other));
}

/** Moves each row to its place: among the settings with an effect, or into the fold of its group. */
function place() {
  const loop = store.loop;
  if (!loop) return;
  const unused = new Set(loop.checked?.unused ?? []);
  for (const { used, fold, folded, summary, names } of groups) {
    let count = 0;
    for (const name of names) {
      const row = rows.get(name);
      if (!row) continue;
      // The focused field and edited fields stay where they are.
      const isHere = row.row.parentElement !== null;
      const stays = isHere && (row.row.contains(document.activeElement) || isEdited(loop.settings[name]));
      const target = stays ? row.row.parentElement : unused.has(name) ? folded : used;
      if (target === folded) count += 1;
      if (row.row.parentElement !== target) insert(/** @type {HTMLElement} */ (target), row.row, names);
      row.row.classList.toggle("is-unused", unused.has(name));
    }
    fold.hidden = count === 0;
    const when = hangsOnStructure(loop, names) ? `in ${structureOf(loop)}` : "as set";
    text(summary, `${count} more without effect ${when}: ${fold.open ? "hide" : "show"}`);
  }
}

/**
 * Puts a row into a list in the order of the group.
 *
 * @param {HTMLElement} target
 * @param {HTMLElement} row
 * @param {string[]} order
 */
function insert(target, row, order) {
  const at = order.indexOf(row.dataset.name ?? "");
  const after = [...target.children].find((one) => {
    const name = one instanceof HTMLElement ? one.dataset.name : undefined;
    return name !== undefined && order.indexOf(name) > at;
  });
  target.insertBefore(row, after ?? null);
}

/**
 * @param {Work} loop
 * @param {string} name
 * @param {HTMLElement} group
 * @param {HTMLElement} folded
 * @returns {Row}
 */
function makeRow(loop, name, group, folded) {
  const { variable } = loop.settings[name];
  const id = `field-${name}`;
  const isSwitch = isBoolean(variable.kind);
  const input = element("input", {
    id,
    type: isSwitch ? "checkbox" : "text",
    class: isSwitch ? "switch" : "number",
    inputmode: isSwitch ? null : "text",
    autocomplete: "off",
    spellcheck: "false",
    "aria-describedby": `${id}-unit ${id}-tag ${id}-grey ${id}-remark`,
  });
  let isGoingOn = false;
  input.addEventListener("focus", () => {
    isGoingOn = false;
  });
  // The first click into the field selects the value; the next one places the cursor.
  let wasFocused = false;
  input.addEventListener("pointerdown", () => {
    wasFocused = document.activeElement === input;
  });
  input.addEventListener("click", () => {
    if (!isSwitch && !wasFocused && input.selectionStart === input.selectionEnd) input.select();
  });
  input.addEventListener("input", () => {
    if (isSwitch) return store.edit({ [name]: input.checked });
    const typed = read(input.value, variable);
    if ("why" in typed) store.reject(name, input.value, typed.why);
    else store.edit({ [name]: typed.value }, isGoingOn);
    isGoingOn = true;
  });
  // When the field loses focus, a valid value is rewritten in its standard form.
  input.addEventListener("blur", () => {
    showField(name);
    place();
  });
  input.addEventListener("keydown", (event) => keys(event, name, input));
  const tag = element("span.tag", { id: `${id}-tag` });
  const grey = element("span.grey.faint", { id: `${id}-grey` });
  const remark = element("span.remark", { id: `${id}-remark`, "aria-live": "polite" });
  const unit = variable.unit === null ? (isTime(variable.kind) ? "s" : "") : unitText(variable.unit);
  const help = element(
    "button.plain.ask",
    {
      "aria-label": `Help on ${name}`,
      "aria-expanded": "false",
      onclick: () => fieldHelp(name, row, input),
    },
    "?",
  );
  const row = element(
    "div",
    {
      class: ["field", isSwitch && "of-switch", isLong(name) && "is-long"].filter(Boolean).join(" "),
      "data-name": name,
      title: variable.description,
    },
    element("label.name", { for: id }, broken(name)),
    element("span.value", input),
    element("span.unit", { id: `${id}-unit` }, unit),
    tag,
    help,
    grey,
    remark,
  );
  row.hidden = isOfStructure(loop, name);
  return { row, input, tag, grey, remark, group, folded };
}

/** Whether a part of a name, between dots, is too long to fit beside the field. @param {string} name */
function isLong(name) {
  return name.split(".").some((part) => part.length > 11);
}

/**
 * A name with possible line breaks after its dots, since settings of inner blocks have long names.
 *
 * @param {string} name
 */
function broken(name) {
  return name.split(".").flatMap((part, at) => (at === 0 ? [part] : [".", element("wbr"), part]));
}

/**
 * @param {KeyboardEvent} event
 * @param {string} name
 * @param {HTMLInputElement} input
 */
async function keys(event, name, input) {
  const row = rows.get(name);
  if (event.key === "Enter") {
    event.preventDefault();
    // Apply the edits in other fields, too, so that the run uses the visible values.
    await store.send();
    const setting = store.loop?.settings[name];
    if (setting && !isEdited(setting)) showField(name, true);
  } else if (event.key === "Escape" && row) {
    if (row.row.nextElementSibling?.classList.contains("field-help")) fieldHelp(name, row.row, input);
    else {
      store.takeBack([name]);
      showField(name, true);
    }
    event.stopPropagation();
  } else if ((event.key === "F1" || event.key === "?") && row) {
    event.preventDefault();
    fieldHelp(name, row.row, input);
  }
}

/**
 * Shows a setting in its field.
 *
 * @param {string} name
 * @param {boolean} [isForced] whether to rewrite the text even while the user is in the field
 */
function showField(name, isForced = false) {
  const loop = store.loop;
  const row = rows.get(name);
  const setting = loop?.settings[name];
  if (!loop || !row || !setting) return;
  const { kind } = setting.variable;
  const wire = wiredTo(loop, name);
  row.row.hidden = isOfStructure(loop, name) || actingNames.has(name);
  const value = wire ? (runValue(loop, name) ?? setting.value) : setting.value;
  if (isBoolean(kind)) row.input.checked = Boolean(value);
  else if (isForced || document.activeElement !== row.input || setting.wrong === undefined) {
    // The value of a connected input cannot be edited, so it may be rounded to fit.
    const written = setting.wrong ?? (wire ? rounded(value, kind) : shown(value, kind));
    // Do not rewrite text while it is being typed, if it means the same value.
    const typed = read(row.input.value, setting.variable);
    const isSame = "value" in typed && shown(typed.value, kind) === written;
    const isTyping = document.activeElement === row.input && isSame && !isForced;
    if (!isTyping && row.input.value !== written) row.input.value = written;
  }
  row.input.readOnly = wire !== undefined;
  if (isBoolean(kind)) row.input.disabled = wire !== undefined;
  const edited = isEdited(setting);
  row.row.classList.toggle("is-edited", edited);
  const from = wire ? "wired" : edited ? "edited" : source(setting);
  row.row.dataset.source = wire ? "wired" : source(setting);
  text(row.tag, from);
  const grey = greyOf(loop, setting, value, wire);
  text(row.grey, grey.join("; "));
  attribute(row.grey, "title", grey.join("; ") || undefined);
  row.grey.classList.toggle("is-beside", grey.length === 1 && edited && !wire);
  const said = loop.checked?.remarks ?? [];
  const remarks = said.filter((one) => fieldOf(one) === name);
  const isError = setting.why !== undefined || said.some((one) => one.is_error && one.variables.includes(name));
  text(row.remark, wire ? "" : (setting.why ?? remarks.map((one) => one.text).join(" ")));
  row.remark.classList.toggle("error", isError);
  row.remark.classList.toggle("note", !isError);
  attribute(row.input, "aria-invalid", isError ? "true" : null);
}

/**
 * The variable whose field shows a remark: the first one named in the remark that has a field.
 *
 * @param {import("./messages").Remark} remark
 */
function fieldOf(remark) {
  const loop = store.loop;
  return remark.variables.find((name) => rows.has(name) && loop && !isOfStructure(loop, name));
}

/**
 * The grey text under a field: the value in force if it differs, a time in PLC notation, the range.
 *
 * @param {Work} loop
 * @param {Setting} setting
 * @param {import("./messages").Value} value
 * @param {string | undefined} wire
 */
function greyOf(loop, setting, value, wire) {
  const { kind, min, max } = setting.variable;
  const parts = [];
  if (wire) parts.push(`from ${wire}`);
  if (isEdited(setting) && !wire) parts.push(`in force: ${shown(setting.sent, kind)}`);
  if (isTime(kind)) parts.push(plcTime(number(value)));
  if (!isBoolean(kind)) {
    if (min !== null && max !== null) parts.push(`${shown(min, kind)} ... ${shown(max, kind)}`);
    else if (min !== null) parts.push(`${shown(min, kind)} or more`);
    else if (max !== null) parts.push(`up to ${shown(max, kind)}`);
  }
  const rounded = loop.checked?.rounded[setting.variable.name];
  if (rounded !== undefined && kind !== "REAL") parts.push(`the block holds ${shown(rounded, kind)}`);
  return parts;
}

/**
 * Whether a setting is one of the three switches for P, I and D, which the list of structures replaces.
 *
 * @param {Work} loop
 * @param {string} name
 */
function isOfStructure(loop, name) {
  const { structure } = loop.description.roles;
  return structure.length === 3 && structure.includes(name);
}

/**
 * The structure selected in the fields, such as PI; `undefined` if the block does not have the three switches.
 *
 * @param {Work} loop
 */
function structureOf(loop) {
  const { structure } = loop.description.roles;
  if (structure.length !== 3) return undefined;
  const switches = structure.map((name) => (loop.settings[name]?.value ? "1" : "0")).join("");
  return STRUCTURES.find(([, bits]) => bits === switches)?.[0];
}

/**
 * Whether the structure decides if one of these settings has an effect.
 *
 * @param {Work} loop
 * @param {string[]} names
 */
function hangsOnStructure(loop, names) {
  const { groups: all, roles } = loop.description;
  const fields = all.flatMap((group) => group.fields).filter((one) => names.includes(one.name));
  const needed = fields.flatMap((one) => one.used_if).flat();
  return structureOf(loop) !== undefined && needed.some(([name]) => roles.structure.includes(name));
}

/** @param {Work} loop */
function makeStructure(loop) {
  const names = loop.description.roles.structure;
  const choose = () => {
    const bits = STRUCTURES.find(([title]) => title === select.value)?.[1] ?? "000";
    store.edit(Object.fromEntries(names.map((name, at) => [name, bits[at] === "1"])));
  };
  const select = element("select", {
    id: "structure",
    onchange: choose,
    "aria-describedby": "structure-tag structure-grey",
  });
  select.addEventListener("keydown", (event) => {
    if (event.key === "Enter") {
      event.preventDefault();
      store.send();
    } else if (event.key === "Escape") store.takeBack(names);
    else if (event.key === "F1" || event.key === "?") {
      event.preventDefault();
      fieldHelp(names, row, select);
    }
  });
  const row = element(
    "div.field.of-structure",
    { "data-name": names[0] },
    element("label", { for: "structure" }, "Structure"),
    element("span.value", select),
    element("span"),
    element("span.tag", { id: "structure-tag" }),
    element(
      "button.plain.ask",
      { "aria-label": "Help on the structure", "aria-expanded": "false", onclick: () => fieldHelp(names, row, select) },
      "?",
    ),
    element("span.grey.faint", { id: "structure-grey" }, names.join(", ")),
  );
  return row;
}

/** Shows the structure that the three switches select. */
function showStructure() {
  const loop = store.loop;
  const select = document.getElementById("structure");
  if (!loop || !(select instanceof HTMLSelectElement)) return;
  const present = structureOf(loop) ?? "none";
  const offered = STRUCTURES.filter(([title], at) => at < USUAL || title === present).map(([title]) => title);
  if ([...select.options].map((one) => one.value).join() !== offered.join()) {
    fill(
      select,
      offered.map((title) => element("option", { value: title }, title)),
    );
  }
  select.value = present;
  const settings = loop.description.roles.structure.map((name) => loop.settings[name]);
  const row = select.closest(".field");
  const edited = settings.some(isEdited);
  const from = ["changed", "file"].find((what) => settings.some((one) => source(one) === what)) ?? "start";
  row?.classList.toggle("is-edited", edited);
  if (row instanceof HTMLElement) row.dataset.source = from;
  text(byId("structure-tag"), edited ? "edited" : from);
}
