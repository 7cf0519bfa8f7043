/**
 * Shows the unconnected inputs of a program as operator controls: switches, push buttons and number fields. Changes
 * take effect immediately and are recorded as events of the run.
 *
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("tool/store.js").Work} Work
 */

import { attribute, element, fill, text } from "tool/dom.js";
import { forced, isForced } from "tool/force.js";
import { cursorTime, momentText, momentValues } from "tool/moment.js";
import { numberField } from "tool/number_field.js";
import { openInputs, programOf } from "tool/program.js";
import { isSwitch } from "tool/signals.js";
import { store, variable } from "tool/store.js";
import { number, shown } from "tool/values.js";

/** Words in an input's comment or name that suggest a push button. */
const PUSH_COMMENT = /push.?button|\bbutton\b|momentary|\btaster\b|\bpulse\b/i;
const PUSH_NAME = /(^|_)(start|stop|reset|ack|acknowledge|quit|confirm|jog)\w*$/i;

/**
 * Functions that show a new value in an input's control, by input name.
 *
 * @type {Map<string, (value: import("./messages").Value) => void>}
 */
const fields = new Map();
/** The elements for the value at the cursor, by input name. @type {Map<string, [Variable, HTMLElement]>} */
const moments = new Map();
/** Identifies the loop and the controls shown. */
let drawn = "";

/** @param {HTMLElement} within */
export function mount(within) {
  const group = element("section.group.inputs", { "aria-labelledby": "inputs-title", hidden: true });
  within.append(group);
  const update = () => show(group);
  for (const what of ["loop", "plant", "program"]) store.on(what, update);
  store.on("settings", (/** @type {string[]} */ names) => {
    for (const name of names) {
      const setting = store.loop?.settings[name];
      if (setting) fields.get(name)?.(setting.sent);
    }
  });
  for (const what of ["moment", "forced"]) store.on(what, showMoment);
  update();
}

/** Shows each input's value at the cursor or, without a cursor, its forced value. */
function showMoment() {
  const loop = store.loop;
  if (!loop) return;
  for (const [name, [{ kind }, place]] of moments) {
    const full = variable(loop, name);
    const isNow = cursorTime() === undefined;
    const value = isNow ? forced()[full] : momentValues()[full];
    place.hidden = value === undefined;
    text(place, place.hidden ? "" : `${isNow ? "forced " : ""}${shown(value, kind)} ${momentText()}`);
    place.closest(".input")?.classList.toggle("is-forced", isForced(full));
  }
}

/**
 * The inputs that take effect immediately, unlike settings, which are edited and applied.
 *
 * @param {Work} loop
 */
export function actingInputs(loop) {
  return programOf(loop) ? openInputs(loop) : [];
}

/** @param {HTMLElement} group */
function show(group) {
  const loop = store.loop;
  const inputs = loop ? actingInputs(loop) : [];
  const key = JSON.stringify([loop?.id, inputs.map((one) => [one.name, loop && isPush(loop, one)])]);
  if (key === drawn) return;
  drawn = key;
  fields.clear();
  moments.clear();
  group.hidden = inputs.length === 0;
  fill(
    group,
    element("h3", { id: "inputs-title" }, "Inputs"),
    loop && inputs.map((one) => (isSwitch(one) ? boolean(loop, one, group) : numeric(loop, one))),
  );
  showMoment();
}

/**
 * Sets an input before the next call.
 *
 * @param {string} name
 * @param {import("./messages").Value} value
 */
async function act(name, value) {
  try {
    return await store.now({ [name]: value });
  } catch (error) {
    store.say(error);
    return undefined;
  }
}

/**
 * Whether an input is a push button: chosen by the user, otherwise guessed from its comment and name.
 *
 * @param {Work} loop
 * @param {Variable} of
 */
function isPush(loop, { name, description }) {
  return /** @type {boolean} */ (loop.notes.inputs?.[name] ?? (PUSH_COMMENT.test(description) || PUSH_NAME.test(name)));
}

/**
 * @param {Work} loop
 * @param {Variable} of
 * @param {HTMLElement} group
 */
function boolean(loop, of, group) {
  const isButton = isPush(loop, of);
  const other = () => {
    loop.notes.inputs = { ...loop.notes.inputs, [of.name]: !isButton };
    show(group);
  };
  const control = isButton ? push(loop, of) : toggle(loop, of);
  const turn = isButton ? `Make ${of.name} a toggle switch` : `Make ${of.name} a push button`;
  return row(of, control, element("button.plain.ask", { "aria-label": turn, title: turn, onclick: other }, "⇄"));
}

/**
 * @param {Variable} of
 * @param {HTMLElement} control
 * @param {HTMLElement | null} [more]
 */
function row(of, control, more = null) {
  const { name, description } = of;
  const moment = element("span.at-moment", { hidden: true });
  moments.set(name, [of, moment]);
  return element("div.input", { "data-input": name, title: description }, control, more, moment);
}

/**
 * A toggle switch.
 *
 * @param {Work} loop
 * @param {Variable} of
 */
function toggle(loop, { name }) {
  const box = element("input", { type: "checkbox", role: "switch" });
  box.addEventListener("change", () => act(name, box.checked));
  const state = element("span.state");
  fields.set(name, (value) => {
    box.checked = value === true;
    text(state, shown(value, "BOOL"));
  });
  fields.get(name)?.(loop.settings[name].sent);
  return element("label", box, " ", element("span.name", name), " ", state);
}

/**
 * A push button: TRUE while pressed, and for at least one call.
 *
 * @param {Work} loop
 * @param {Variable} of
 */
function push(loop, { name }) {
  const button = element("button.push", element("span.name", name));
  let isDown = false;
  /**
   * The run that accepted the press, and its number of calls at that time.
   *
   * @type {{ run: number | undefined, calls: number } | undefined}
   */
  let taken;
  /** @type {(() => void) | undefined} */
  let endWaiting;
  const end = () => {
    const now = store.live === loop ? store.state : undefined;
    const isSeen = taken && now && now.calls > (now.run === taken.run ? taken.calls : 0);
    if (!isSeen && button.isConnected) return;
    endWaiting?.();
    endWaiting = taken = undefined;
    isDown = false;
    if (store.loop === loop) act(name, false);
  };
  const press = async () => {
    if (isDown) return;
    isDown = true;
    // A call already in progress does not see the press.
    const state = await act(name, true);
    taken = { run: state?.run, calls: state?.calls ?? 0 };
    if (endWaiting) end();
  };
  const release = () => {
    if (!isDown || endWaiting) return;
    // Release it only after a call: the run would not notice a press that ends between two calls.
    endWaiting = store.on("state", end);
    end();
  };
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    press();
  });
  for (const what of ["pointerup", "pointercancel", "blur"]) button.addEventListener(what, release);
  button.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) press();
  });
  button.addEventListener("keyup", (event) => {
    if (event.key === " " || event.key === "Enter") release();
  });
  fields.set(name, (value) => attribute(button, "aria-pressed", String(value === true)));
  fields.get(name)?.(loop.settings[name].sent);
  return button;
}

/**
 * A number field, with a slider if the input has two limits.
 *
 * @param {Work} loop
 * @param {Variable} of
 */
function numeric(loop, of) {
  const { name, kind, min, max } = of;
  const value = loop.settings[name].sent;
  const label = element("span.name", name);
  const field = numberField("", `input-${name}`, of, value, (next) => act(name, next));
  field.row.prepend(label);
  if (min === null || max === null) {
    fields.set(name, field.follow);
    return row(of, field.row);
  }
  const step = kind === "REAL" || kind === "LREAL" ? "any" : "1";
  const about = { "aria-label": `${name}, ${min} to ${max}`, min, max, step, value: number(value) };
  const slider = element("input", { type: "range", ...about });
  let isActing = false;
  slider.addEventListener("input", async () => {
    if (isActing) return;
    isActing = true;
    // The slider may move while a value is being sent: repeat until its latest position has been sent.
    for (let last = Number.NaN; last !== Number(slider.value); ) {
      last = Number(slider.value);
      await act(name, last);
    }
    isActing = false;
  });
  fields.set(name, (next) => {
    field.follow(next);
    if (document.activeElement !== slider) slider.value = String(number(next));
  });
  return row(of, field.row, slider);
}
