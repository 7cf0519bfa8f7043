/**
 * The variables of a loop's members, their roles (setpoint, process value, manipulated value), and their units.
 *
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("./messages").Description} Description
 * @typedef {import("tool/store.js").Work} Work
 *
 * @typedef {object} Signal
 * @property {string} name `TIC101.LMN`
 * @property {string} member `TIC101`
 * @property {Variable} variable
 *
 * @typedef {object} Roles signals of a loop by role, as `MEMBER.VARIABLE`
 * @property {string | undefined} setpoint
 * @property {string | undefined} processValue
 * @property {string | undefined} manipulatedValue
 * @property {string[]} pulses
 * @property {string | undefined} manual switch to manual mode
 */

import { ask } from "tool/engine.js";
import { split, store, variable } from "tool/store.js";
import { isBoolean, isTime } from "tool/values.js";

/**
 * All variables of a loop, the controller's first.
 *
 * @param {Work} loop
 * @returns {Promise<Signal[]>}
 */
export async function signals(loop) {
  const members = await descriptions(loop);
  return members.flatMap(([member, description]) =>
    description.variables.map((one) => ({ name: `${member}.${one.name}`, member, variable: one })),
  );
}

/**
 * The FMI units of a loop's process value and manipulated value: those of the controller or, if it does not specify
 * them, those of its plant.
 *
 * @param {Work} loop
 * @returns {Promise<{ processValue: string, manipulatedValue: string }>}
 */
export async function units(loop) {
  const members = new Map(await descriptions(loop));
  /** @param {string | undefined} name `PLANT.U` */
  const unit = (name) => {
    const [member, own] = split(name ?? "");
    const of = members.get(member)?.variables.find((one) => one.name === own)?.unit;
    return of === "1" ? "" : (of ?? "");
  };
  const { processValue, manipulatedValue, setpoint } = roles(loop);
  const input = loop.connections.find(([from]) => from === manipulatedValue)?.[1];
  const plants = [...members]
    .slice(1)
    .flatMap(([name, { roles }]) => (roles.process_value ? `${name}.${roles.process_value}` : []));
  // Without a process value, as in a ramp, the setpoint need not have the plant's unit.
  const outputs = processValue ? plants.map(unit).filter(Boolean) : [];
  return {
    processValue: unit(processValue) || unit(setpoint) || (outputs[0] ?? ""),
    // The mean of pulses is their fraction of the period, in percent.
    manipulatedValue: unit(manipulatedValue) || unit(input) || (pulsePeriod(loop) === undefined ? "" : "%"),
  };
}

/**
 * The members of a loop with their descriptions, the controller first.
 *
 * @param {Work} loop
 * @returns {Promise<[string, Description][]>}
 */
export async function descriptions(loop) {
  const others = loop.members.map(
    async ({ name, fmu }) => /** @type {[string, Description]} */ ([name, await store.describe(fmu)]),
  );
  return [[loop.member, loop.description], ...(await Promise.all(others))];
}

/**
 * The name of the setting that switches the controller to manual mode.
 *
 * @param {Work} loop
 * @returns {string | undefined}
 */
export function manualSwitch({ description: { roles } }) {
  return roles.manual?.[0] ?? roles.manual_pulses?.[0];
}

/**
 * The signals of a loop by role.
 *
 * @param {Work} loop
 * @returns {Roles}
 */
export function roles(loop) {
  const { roles } = loop.description;
  /** @param {string | null | undefined} name */
  const named = (name) => (name ? variable(loop, name) : undefined);
  return {
    setpoint: named(roles.setpoint),
    processValue: named(roles.shown_process_value ?? roles.process_value),
    manipulatedValue: named(roles.manipulated_value),
    pulses: roles.pulses.map((pulse) => variable(loop, pulse)),
    manual: named(manualSwitch(loop)),
  };
}

/**
 * The name of the process value: the controller's or, if it has none, the plant's.
 *
 * @param {Work} loop
 * @returns {Promise<string | undefined>}
 */
export async function controlledValue(loop) {
  const own = roles(loop).processValue;
  if (own) return own;
  const plants = (await descriptions(loop)).slice(1);
  return plants.flatMap(([name, { roles: of }]) => (of.process_value ? `${name}.${of.process_value}` : []))[0];
}

/**
 * The names of outputs that are TRUE while a plant has stopped, such as a tripped drive.
 *
 * @param {Work} loop
 * @returns {Promise<string[]>}
 */
export async function faults(loop) {
  const ofMember = (/** @type {[string, Description]} */ [name, { roles: of }]) =>
    of.signals.flatMap(([meaning, output]) => (meaning === "fault" ? `${name}.${output}` : []));
  return (await descriptions(loop)).flatMap(ofMember);
}

/**
 * The averaging time for a controller's pulses, in seconds: the period of its pulse former; `undefined` if its
 * manipulated value is not a mean of pulses.
 *
 * @param {Work} loop
 * @returns {number | undefined}
 */
export function pulsePeriod(loop) {
  const { pulse_former: former, manipulated_value: output } = loop.description.roles;
  const period = loop.settings[former[0]];
  const kind = loop.description.variables.find((one) => one.name === output)?.kind;
  if (!period || kind !== "LREAL") return undefined;
  const cycle = loop.settings[loop.description.cycle ?? ""]?.sent;
  // The setting for the period is either a time or a number of calls.
  return isTime(period.variable.kind) ? Number(period.sent) : Number(period.sent) * Number(cycle ?? 1);
}

/**
 * The current manipulated value; for pulses, the mean over the last period.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {string} name
 */
export async function presentOutput(loop, name) {
  const state = store.state;
  const period = pulsePeriod(loop);
  if (period === undefined || !state) return state?.values[name];
  const now = { from: state.time, to: state.time, points: 2 };
  const { values } = await ask({ do: "view", variables: [name], ...now, means: { [name]: period } });
  return values[0][0] ?? 0;
}

/**
 * The displayed name of a signal: without the member for the controller's variables, in full for those of other
 * members.
 *
 * @param {Work} loop
 * @param {string} name
 */
export function called(loop, name) {
  return name.startsWith(`${loop.member}.`) ? name.slice(loop.member.length + 1) : name;
}

/** @param {Variable} one */
export function isSwitch(one) {
  return isBoolean(one.kind);
}

/**
 * A unit as displayed after a number; empty for a dimensionless number. FMI units cannot contain a degree sign.
 *
 * @param {string | null | undefined} unit
 */
export function unitText(unit) {
  return unit === "1" ? "" : (unit ?? "").replace("degC", "°C");
}

/**
 * The unit of a difference between two values, as displayed: K instead of °C, as in the figures of a run.
 *
 * @param {string | null | undefined} unit
 */
export function differenceUnit(unit) {
  return unit === "degC" ? "K" : unitText(unit);
}
