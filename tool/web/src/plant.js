/**
 * The panel for the plant of a loop: the choice of a plant, its settings and connections, and the measuring chain
 * between plant and controller.
 *
 * @typedef {import("./messages").Description} Description
 * @typedef {import("./messages").Member} Member
 * @typedef {import("./messages").Proposal} Proposal
 * @typedef {import("./messages").Value} Value
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("./messages").Wire} Wire
 * @typedef {import("tool/store.js").Work} Work
 */

import { choice, element, fill, numberInput, text } from "tool/dom.js";
import { ask } from "tool/engine.js";
import { programNamed } from "tool/program.js";
import { called, isSwitch, unitText } from "tool/signals.js";
import { isSettable, split, store, valuesOf } from "tool/store.js";
import { plcTime, read, shown } from "tool/values.js";

/** The generic plant, which is offered first, and its three main parameters with their usual names. */
const GENERIC = "PROCESS";
const THREE_NUMBERS = /** @type {[string, string][]} */ ([
  ["GAIN", "Gain"],
  ["T1", "Time constant"],
  ["DEAD_TM", "Dead time"],
]);
const DEAD_TIME = "DEAD_TM";
const ROOM = "DEAD_MAX";
/** The measuring chain: its FMU, its input and output, and the two parameters that make it alter the value. */
export const CHAIN = { fmu: "SENSOR", from: "U", to: "Y", noise: "NOISE", steps: "STEPS" };
const PLANT = "PLANT";
const SENSOR = "SENSOR";
const EXCHANGES = {
  sequential: "Each member receives what the members before it have just computed (sequential).",
  parallel: "All members receive their inputs at the same time, before any of them is stepped (parallel).",
};

/** @type {HTMLElement} */
let body;
/** The proposals for connections, by the id of the loop. @type {Map<number, Proposal>} */
const proposals = new Map();
/** The last text typed for each parameter of the generic plant, by name. @type {Record<string, string>} */
const typed = {};
/** The number of the latest attempt to draw the panel: older attempts are abandoned. */
let drawings = 0;
/** Identifies the state shown in the panel, which is redrawn only if that state changes. */
let drawn = "";

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div");
  fill(content, body);
  for (const what of ["catalogue", "loop", "plant"]) store.on(what, show);
  store.on("settings", keepCycle);
  store.on("loop", () => {
    const asked = document.querySelector('meta[name="plcfmu-plant"]')?.getAttribute("content");
    if (asked && store.loop && store.loop.members.length === 0 && !store.loop.notes.plant) {
      store.loop.notes.plant = "asked";
      choose(asked);
    }
  });
  show();
}

/**
 * The plant of a loop: the first member other than the measuring chain.
 *
 * @param {Work | undefined} loop
 */
export function plantOf(loop) {
  return loop?.members.find((member) => member.fmu !== CHAIN.fmu);
}

/**
 * The measuring chain of a loop.
 *
 * @param {Work | undefined} loop
 */
export function sensorOf(loop) {
  return loop?.members.find((member) => member.fmu === CHAIN.fmu);
}

/**
 * The unconnected inputs through which a user can disturb the loop, such as `PLANT.DOOR`, with their current values.
 * The controller's own come last.
 *
 * @param {Work} loop
 * @returns {Promise<{ name: string, variable: Variable, value: Value }[]>}
 */
export async function disturbances(loop) {
  const found = [];
  const state = store.isLive() ? store.state : undefined;
  // Values set after the last call are not yet among the run's values.
  const { events } = state ? await ask({ do: "events" }) : { events: [] };
  const sent = events.filter(({ call, act = "set" }) => state && call >= state.calls && act === "set");
  const acting = { ...state?.values, ...Object.fromEntries(sent.map(({ variable: name, value }) => [name, value])) };
  // A controller without a plant has no loop to disturb.
  const own =
    loop.members.length > 0 ? [{ name: loop.member, fmu: loop.description.name, values: valuesOf(loop, "sent") }] : [];
  for (const member of [...loop.members, ...own]) {
    const description = await store.describe(member.fmu);
    for (const name of description.roles.disturbances) {
      const variable = description.variables.find((one) => one.name === name);
      const full = `${member.name}.${name}`;
      if (!variable || loop.connections.some(([, to]) => to === full)) continue;
      found.push({ name: full, variable, value: acting[full] ?? member.values[name] ?? variable.start });
    }
  }
  return found;
}

/**
 * Connects a plant as proposed by the engine. An existing run continues with it.
 *
 * @param {string} fmu
 * @param {import("./messages").Values} [values]
 */
export async function choose(fmu, values = {}) {
  const loop = store.loop;
  if (!loop) return;
  try {
    const description = await store.describe(fmu);
    /** @type {Member} */
    const plant = { name: PLANT, fmu, values };
    const controller = { name: loop.member, fmu: loop.description.name, values: valuesOf(loop, "sent") };
    const proposal = await ask({ do: "propose", controller, plant });
    if (store.loop !== loop) return;
    proposals.set(loop.id, proposal);
    /** @type {import("./messages").Values} */
    const own = {};
    for (const [name, value] of Object.entries(proposal.values)) {
      const [member, variable] = split(name);
      if (member === PLANT && !(variable in values)) plant.values = { ...plant.values, [variable]: value };
      if (member === loop.member) own[variable] = value;
    }
    setCycle(loop, plant, description);
    const wires = proposal.connections.map(({ from, to }) => /** @type {[string, string]} */ ([from, to]));
    const members = [plant];
    const connections = sensorOf(loop) ? await throughSensor(loop, description, members, wires) : wires;
    await store.connect({ members, connections, step: proposal.step, exchange: proposal.exchange }, true);
    if (Object.keys(own).length > 0) {
      store.edit(own);
      if (store.edited().length > 0) {
        store.say(
          `${Object.keys(own).join(", ")} changed to match ${fmu}; apply ${store.edited().length > 1 ? "them" : "it"}.`,
        );
      }
    }
  } catch (error) {
    store.say(error);
  }
}

/**
 * The index of the connection that carries the process value from the plant to the controller; -1 if there is none.
 *
 * @param {Work} loop
 * @param {Member} plant
 * @param {Description} description
 * @param {[string, string][]} [wires]
 */
function measured(loop, plant, description, wires = loop.connections) {
  const output = `${plant.name}.${description.roles.process_value}`;
  const input = `${loop.member}.${loop.description.roles.process_value}`;
  return wires.findIndex(([from, to]) => from === output && to === input);
}

/** @param {Work} loop @param {Member} plant @param {Description} description */
async function withSensor(loop, plant, description) {
  const members = [plant];
  const connections = await throughSensor(loop, description, members, loop.connections);
  await exchanged(loop, members, connections);
}

/** @param {Work} loop @param {Member} sensor */
async function withoutSensor(loop, sensor) {
  const from = loop.connections.find(([, to]) => to === `${sensor.name}.${CHAIN.from}`)?.[0];
  const connections = loop.connections.flatMap((wire) => {
    if (wire[1].startsWith(`${sensor.name}.`) || (wire[0].startsWith(`${sensor.name}.`) && !from)) return [];
    return wire[0].startsWith(`${sensor.name}.`) ? [/** @type {[string, string]} */ ([from, wire[1]])] : [wire];
  });
  await exchanged(
    loop,
    loop.members.filter((member) => member !== sensor),
    connections,
  );
}

/**
 * Inserts the measuring chain into the connection of the process value.
 *
 * @param {Work} loop
 * @param {Description} plant
 * @param {Member[]} members initially the plant; the chain is added
 * @param {[string, string][]} wires
 * @returns {Promise<[string, string][]>}
 */
async function throughSensor(loop, plant, members, wires) {
  if (!store.catalogue.fmus.some((entry) => entry.name === CHAIN.fmu)) return wires;
  const at = measured(loop, members[0], plant, wires);
  if (at < 0) return wires;
  const description = await store.describe(CHAIN.fmu);
  /** @type {Member} */
  const sensor = {
    name: SENSOR,
    fmu: CHAIN.fmu,
    // A new chain passes the value unchanged.
    values: sensorOf(loop)?.values ?? { [CHAIN.noise]: 0, [CHAIN.steps]: 0 },
  };
  setCycle(loop, sensor, description);
  members.push(sensor);
  const [from, to] = wires[at];
  const rest = wires.filter((_, one) => one !== at);
  return [...rest, [from, `${SENSOR}.${CHAIN.from}`], [`${SENSOR}.${CHAIN.to}`, to]];
}

/**
 * Enlarges the plant's memory for its dead time if necessary. The size of this memory is fixed when a run starts.
 *
 * @param {Description} description
 * @param {import("./messages").Values} values values to set, to which the size of the memory is added
 * @param {import("./messages").Values} [before]
 */
function withRoom(description, values, before = {}) {
  const room = description.variables.find((one) => one.name === ROOM);
  const asked = values[DEAD_TIME];
  if (room && typeof asked === "number" && asked > Number(before[ROOM] ?? room.start)) values[ROOM] = asked;
}

/**
 * Sets a member's cycle to that of the controller.
 *
 * @param {Work} loop
 * @param {Member} member
 * @param {Description} description
 */
function setCycle(loop, member, description) {
  const cycle = loop.description.cycle && loop.settings[loop.description.cycle]?.sent;
  if (cycle && description.cycle) member.values = { ...member.values, [description.cycle]: cycle };
}

/** Updates the members' cycles if the controller's cycle is among the changed settings. @param {string[]} names */
async function keepCycle(names) {
  const loop = store.loop;
  if (!loop?.description.cycle || !names.includes(loop.description.cycle)) return;
  for (const member of loop.members) setCycle(loop, member, await store.describe(member.fmu));
}

/** Draws the panel. */
async function show() {
  const loop = store.loop;
  drawings += 1;
  const mine = drawings;
  if (!loop) return;
  const plant = plantOf(loop);
  try {
    const parts = plant ? await connected(loop, plant) : await unconnected();
    const shown = JSON.stringify([
      [loop.id, loop.members, loop.connections, loop.step, loop.exchange],
      [store.catalogue.fmus, loop.notes.plant],
    ]);
    if (mine !== drawings || (shown === drawn && body.childElementCount > 0)) return;
    const focus =
      document.activeElement instanceof HTMLElement && body.contains(document.activeElement)
        ? document.activeElement.id
        : "";
    const open = [...body.querySelectorAll("details[open]")].map((details) => details.id);
    drawn = shown;
    fill(body, chooser(loop, plant), ...parts);
    for (const id of open) document.getElementById(id)?.setAttribute("open", "");
    if (focus) document.getElementById(focus)?.focus();
  } catch (error) {
    if (mine === drawings) store.say(error);
  }
}

/**
 * @param {Work} loop
 * @param {Member | undefined} plant
 */
function chooser(loop, plant) {
  const entries = store.catalogue.fmus.filter(
    ({ name, part, is_foreign: isForeign }) =>
      (part === "plant" || isForeign || (programNamed(name) !== undefined && name !== loop.description.name)) &&
      name !== CHAIN.fmu,
  );
  entries.sort((one, other) => Number(other.name === GENERIC) - Number(one.name === GENERIC));
  const plants = entries.map(({ name, summary }) => [name, `${name}: ${summary}`]);
  const list = choice({ id: "plant-choice" }, [["", "no plant"], ...plants], plant?.fmu, (fmu) => {
    if (fmu) choose(fmu);
    else
      store.connect(
        { members: [], connections: loop.connections.filter(isOwn(loop)), step: null, exchange: "sequential" },
        true,
      );
  });
  return element("p.row", element("label", { for: "plant-choice" }, "Plant"), list);
}

/** @param {Work} loop */
function isOwn(loop) {
  return (/** @type {[string, string]} */ wire) => wire.every((end) => end.startsWith(`${loop.member}.`));
}

/** The content if no plant is connected. @returns {Promise<HTMLElement[]>} */
async function unconnected() {
  const sentence = element("p", "No plant is connected. You can run the controller in open loop, or choose a plant.");
  if (!store.catalogue.fmus.some((entry) => entry.name === GENERIC)) return [sentence];
  const generic = await store.describe(GENERIC);
  const problem = element("p.error", { role: "alert" });
  const inputs = THREE_NUMBERS.flatMap(([name, title]) => {
    const variable = generic.variables.find((one) => one.name === name);
    if (!variable) return [];
    const start = typed[name] ?? shown(variable.start, variable.kind);
    const input = numberInput({ size: 7, value: start, id: `generic-${name}` });
    input.addEventListener("input", () => {
      typed[name] = input.value;
    });
    const unit = unitText(variable.unit);
    const label = element("label", { for: `generic-${name}` }, title);
    return {
      variable,
      input,
      row: element("span.entry", label, input, unit && element("span.faint", unit)),
    };
  });
  const form = element(
    "form.row",
    inputs.map(({ row }) => row),
    element("button", { type: "submit" }, "Use this plant"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    /** @type {import("./messages").Values} */
    const values = {};
    for (const { variable, input } of inputs) {
      const got = read(input.value, variable);
      const why = "why" in got ? got.why : undefined;
      if (why) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
      text(problem, why ?? "");
      if ("why" in got) {
        input.focus();
        return;
      }
      values[variable.name] = got.value;
    }
    withRoom(generic, values);
    choose(GENERIC, values);
  });
  const about = element(
    "p.faint",
    "The generic plant: a lag with dead time. Its gain is the change in the process value per 1 % change in the manipulated value.",
  );
  return [sentence, form, problem, about];
}

/**
 * @param {Work} loop
 * @param {Member} plant
 * @returns {Promise<HTMLElement[]>}
 */
async function connected(loop, plant) {
  /** @type {HTMLElement[]} */
  const parts = [await sentences(loop, plant)];
  const sensor = sensorOf(loop);
  const description = await store.describe(plant.fmu);
  if (plant.fmu === GENERIC) {
    const main = THREE_NUMBERS.flatMap(([name, title]) => {
      const variable = description.variables.find((one) => one.name === name);
      return variable ? field(loop, plant, variable, title) : [];
    });
    parts.push(element("div.entries", main));
  }
  if (sensor) {
    const { variables } = await store.describe(sensor.fmu);
    const [noise, steps] = [CHAIN.noise, CHAIN.steps].map((name) => variables.find((one) => one.name === name));
    const fields = [];
    if (noise) fields.push(field(loop, sensor, noise, "Measuring noise"));
    if (steps) fields.push(field(loop, sensor, steps, "Resolution, steps"));
    parts.push(element("div.entries", fields));
  }
  const isThere = store.catalogue.fmus.some(({ name }) => name === CHAIN.fmu);
  if (sensor || (isThere && measured(loop, plant, description) >= 0)) {
    const onclick = () => (sensor ? withoutSensor(loop, sensor) : withSensor(loop, plant, description));
    const title = "A sensor between plant and controller, with noise and the resolution of an analog input";
    const words = sensor ? "Remove the sensor" : "Measure through a sensor";
    parts.push(element("p", element("button", { id: "sensor", title, onclick }, words)));
  }
  for (const member of loop.members) parts.push(await settings(loop, member));
  return parts;
}

/**
 * The connections as editable sentences.
 *
 * @param {Work} loop
 * @param {Member} plant
 */
async function sentences(loop, plant) {
  let proposal = proposals.get(loop.id);
  if (!proposal) {
    const controller = { name: loop.member, fmu: loop.description.name, values: valuesOf(loop, "sent") };
    proposal = await ask({ do: "propose", controller, plant });
    proposals.set(loop.id, proposal);
  }
  const possible = [...proposal.connections, ...proposal.others];
  const sensor = sensorOf(loop);
  // If all connections have the same reason, state it only once.
  const reasons = new Set(proposal.connections.map((wire) => wire.reason));
  const common = reasons.size === 1 && proposal.connections.length > 1 ? [...reasons][0] : undefined;
  const inputs = [...new Set([...loop.connections.map(([, to]) => to), ...possible.map(({ to }) => to)])];
  const isThere = (/** @type {string} */ to) => loop.connections.some((wire) => wire[1] === to);
  /** @param {string} to */
  const row = (to) => {
    const from = loop.connections.find((wire) => wire[1] === to)?.[0] ?? "";
    const choices = possible.filter((wire) => wire.to === to).map((wire) => wire.from);
    if (sensor && to === `${loop.member}.${loop.description.roles.process_value}`)
      choices.push(`${sensor.name}.${CHAIN.to}`);
    if (from && !choices.includes(from)) choices.push(from);
    const id = `wire-to-${to}`;
    const about = { id, "aria-label": `Source of ${called(loop, to)}` };
    const outputs = choices.map((one) => [one, called(loop, one)]);
    const list = choice(about, [["", "nothing"], ...outputs], from, (next) => rewire(loop, to, next));
    const reason = possible.find((wire) => wire.from === from && wire.to === to)?.reason;
    const goes = element("span", " goes to ", element("span.name", called(loop, to)));
    return element("li", list, goes, reason && reason !== common && element("span.faint.reason", reason));
  };
  const free = inputs.filter((to) => !isThere(to));
  const open = proposal.open.filter(({ input }) => !isThere(input));
  const hint = "No output clearly matches an input: choose below.";
  const said = [...(loop.connections.length === 0 ? [hint] : []), ...open.map((one) => one.text), ...proposal.remarks];
  const remarks = said.map((remark) => element("li.note", remark));
  return element(
    "div",
    element(
      "ul.sentences",
      inputs.filter(isThere).map(row),
      common && element("li.faint", `For all: ${common}`),
      element("li.faint", { id: "exchange" }, EXCHANGES[loop.exchange]),
      loop.step !== null && element("li.faint", { id: "step" }, `The communication step is ${loop.step} s.`),
      remarks,
    ),
    free.length > 0 &&
      element(
        "details",
        { id: "free-inputs", open: open.some(({ input }) => free.includes(input)) },
        element("summary", `${free.length} more ${free.length === 1 ? "input" : "inputs"} that can be connected`),
        element("ul.sentences", free.map(row)),
      ),
  );
}

/**
 * @param {Work} loop
 * @param {string} to
 * @param {string} from
 */
async function rewire(loop, to, from) {
  const rest = loop.connections.filter((wire) => wire[1] !== to);
  const connections = from ? [...rest, /** @type {[string, string]} */ ([from, to])] : rest;
  await exchanged(loop, loop.members, connections);
}

/**
 * @param {Work} loop
 * @param {Member[]} members
 * @param {[string, string][]} connections
 */
async function exchanged(loop, members, connections) {
  const isRunning = store.isLive();
  const { step, exchange } = loop;
  await store.connect({ members, connections, step, exchange }, true);
  if (isRunning) store.say("The plant has restarted with the changed connection; the controller continued.");
}

/**
 * All settings of a member, folded.
 *
 * @param {Work} loop
 * @param {Member} member
 */
async function settings(loop, member) {
  const description = await store.describe(member.fmu);
  const byName = new Map(description.variables.map((one) => [one.name, one]));
  const names = description.groups.flatMap((group) => group.fields.map((one) => one.name));
  const groups = [...description.groups];
  const rest = description.variables.filter((one) => isSettable(one) && !names.includes(one.name));
  if (rest.length > 0) groups.push({ title: "Others", fields: rest.map(({ name }) => ({ name, used_if: [] })) });
  const count = Object.keys(member.values).length;
  return element(
    "details",
    { id: `settings-${member.name}` },
    element("summary", `Settings of ${member.name}: ${member.fmu}${count > 0 ? `, ${count} set` : ""}`),
    groups.map((group) =>
      element(
        "fieldset",
        element("legend", group.title),
        element(
          "div.entries",
          group.fields.flatMap(({ name }) => {
            const variable = byName.get(name);
            return variable && isSettable(variable) ? field(loop, member, variable, undefined, "all-") : [];
          }),
        ),
      ),
    ),
  );
}

/**
 * A setting of a member.
 *
 * @param {Work} loop
 * @param {Member} member
 * @param {Variable} variable
 * @param {string} [title]
 * @param {string} [prefix]
 */
function field(loop, member, variable, title, prefix = "") {
  const full = `${member.name}.${variable.name}`;
  const id = `${prefix}field-${full}`;
  const source = loop.connections.find(([, to]) => to === full)?.[0];
  const value = member.values[variable.name] ?? variable.start;
  const problem = element("span.error", { id: `${id}-problem`, role: "alert" });
  const isFollowing = member.fmu !== "" && variable.role === "cycle";
  const common = { id, disabled: source !== undefined || isFollowing, "aria-describedby": `${id}-problem` };
  /** @param {Value} next */
  const set = async (next) => {
    text(problem, "");
    const room = /** @type {import("./messages").Values} */ ({ [variable.name]: next });
    withRoom(await store.describe(member.fmu), room, member.values);
    if (Object.keys(room).length > 1 || (store.isLive() && !variable.is_tunable)) {
      member.values = { ...member.values, ...room };
      store.emit("plant");
      if (store.isLive()) store.say(`${full} takes effect when the next run starts.`);
      return;
    }
    try {
      await store.now({ [full]: next });
    } catch (error) {
      text(problem, error instanceof Error ? error.message : String(error));
    }
  };
  let control;
  if (isSwitch(variable)) {
    const box = element("input", { ...common, type: "checkbox", checked: value === true });
    box.addEventListener("change", () => set(box.checked));
    control = box;
  } else {
    const input = numberInput({ ...common, size: 9, value: shown(value, variable.kind) });
    input.addEventListener("change", () => {
      const got = read(input.value, variable);
      if ("why" in got) {
        input.setAttribute("aria-invalid", "true");
        text(problem, got.why);
      } else {
        input.removeAttribute("aria-invalid");
        set(got.value);
      }
    });
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") {
        input.value = shown(member.values[variable.name] ?? variable.start, variable.kind);
        input.removeAttribute("aria-invalid");
        text(problem, "");
      }
    });
    control = input;
  }
  const unit = unitText(variable.unit);
  const range = [variable.min, variable.max].map((limit) => (limit === null ? "" : shown(limit, variable.kind)));
  const hint = source
    ? `from ${called(loop, source)}`
    : isFollowing
      ? "the controller's cycle"
      : [
          unit,
          variable.kind === "TIME" ? plcTime(Number(value)) : "",
          range.some(Boolean) ? `${range[0]} … ${range[1]}` : "",
        ]
          .filter(Boolean)
          .join("  ");
  return element(
    "div.entry",
    element("label", { for: id, title: variable.description }, title ?? element("span.name", variable.name)),
    control,
    element("span.faint.hint", hint),
    problem,
  );
}
