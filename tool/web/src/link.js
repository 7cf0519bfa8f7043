/**
 * Creates and opens links that contain a loop with its settings and its run, compressed in the URL's fragment, which is
 * never sent to a server. On another computer, the link reproduces the run bit for bit.
 *
 * @typedef {object} Carried
 * @property {1} version
 * @property {string} name of the loop
 * @property {string} fmu
 * @property {import("./messages").Program} [program] the sources, if the loop's controller is a program
 * @property {(import("./messages").Program | null)[]} [others] the same for each of the other members, in order
 * @property {import("./messages").Values} values in force at the end
 * @property {number | null} window visible part of the curves, in seconds
 * @property {Record<string, any>} [notes] for a program: the signals of the diagram, the watch table, the kinds of
 *   inputs
 * @property {import("tool/remake.js").Made | null} run
 * @property {Pick<import("tool/store.js").Work, "members" | "connections" | "step" | "exchange">} plant
 * @property {string} member the controller's name in the run
 */

import { ask, EngineError, fromBase64, toBase64 } from "tool/engine.js";
import { admit, programNamed, programOf } from "tool/program.js";
import { remake } from "tool/remake.js";
import { beginWith, store, valuesOf } from "tool/store.js";

const BEGIN = "#loop=";
/** The maximum size of a link's content in bytes, and the maximum number of calls in its run. */
const [LARGEST, MOST_CALLS] = [4_000_000, 2_000_000];

/** The keys of the loop's notes that a link contains. */
const NOTES = ["timing", "watch", "inputs"];

/** A link to the current loop. @returns {Promise<string>} */
export async function linkOfLoop() {
  const loop = store.loop;
  if (!loop) throw new EngineError("Open or create a loop first.");
  const { members, connections, step, exchange, name, member } = loop;
  const run = store.isLive() ? await ask({ do: "events" }) : null;
  /** @type {Carried} */
  const carried = {
    ...{ version: 1, name, member, fmu: loop.description.name, values: valuesOf(loop, "sent") },
    program: programOf(loop)?.program,
    others: members.map(({ fmu }) => programNamed(fmu)?.program ?? null),
    window: loop.notes.curves?.window ?? null,
    notes: Object.fromEntries(NOTES.flatMap((key) => (loop.notes[key] ? [[key, loop.notes[key]]] : []))),
    ...{ run, plant: { members, connections, step, exchange } },
  };
  const bytes = new TextEncoder().encode(JSON.stringify(carried));
  const packed = await through(bytes, new CompressionStream("deflate-raw"), LARGEST);
  const text = toBase64(packed).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  return location.href.split("#")[0] + BEGIN + text;
}

/** Opens the loop in the page's address, if there is one. */
export async function openLink() {
  if (!location.hash.startsWith(BEGIN)) return;
  const text = location.hash.slice(BEGIN.length).replaceAll("-", "+").replaceAll("_", "/");
  // Remove the loop from the address: it becomes part of the session, which a reload restores.
  history.replaceState(null, "", location.href.split("#")[0]);
  /** @type {Carried} */
  let carried;
  try {
    const bytes = await through(fromBase64(text), new DecompressionStream("deflate-raw"), LARGEST);
    carried = JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    throw new EngineError("The link is incomplete: copy all of it, up to the last character.");
  }
  if (carried.version !== 1)
    throw new EngineError("The link was created by another version of this page: create it again with this version.");
  if ((carried.run?.calls ?? 0) > MOST_CALLS)
    throw new EngineError(`The run in the link has ${carried.run?.calls} cycles; the maximum is ${MOST_CALLS}.`);
  const fmu = carried.program ? (await admit(carried.program)).fmu : carried.fmu;
  // A program's FMU may have another name here.
  /** @type {Map<string, string>} */
  const fmus = new Map();
  for (const [at, program] of (carried.others ?? []).entries()) {
    const name = program && (await admit(program)).fmu;
    if (name) fmus.set(carried.plant.members[at].fmu, name);
  }
  const here = (/** @type {import("./messages").Member} */ member) => ({
    ...member,
    fmu: fmus.get(member.fmu) ?? member.fmu,
  });
  const loop = await store.add(String(carried.name), String(fmu));
  const taken = store.loops.some((one) => one !== loop && one.member === carried.member);
  if (!taken) loop.member = String(carried.member);
  store.edit(carried.values);
  await store.send();
  beginWith(loop);
  for (const key of NOTES) if (carried.notes?.[key]) loop.notes[key] = carried.notes[key];
  if (carried.window !== null) loop.notes.curves = { chosen: [], hidden: [], window: Number(carried.window) };
  const own = renamed(carried.member, loop.member);
  const { step, exchange } = carried.plant;
  const members = carried.plant.members.map(here);
  const wires = carried.plant.connections.map(([from, to]) => /** @type {[string, string]} */ ([own(from), own(to)]));
  await store.connect({ members, connections: wires, step, exchange });
  store.emit("loop");
  if (!carried.run) return;
  const { setup, events, calls } = carried.run;
  const [controller, ...others] = setup.members;
  const connections = setup.connections.map(([from, to]) => /** @type {[string, string]} */ ([own(from), own(to)]));
  await remake(loop, {
    setup: {
      ...setup,
      members: [{ ...controller, name: loop.member, fmu: loop.description.name }, ...others.map(here)],
      connections,
    },
    events: events.map((event) => ({ ...event, variable: own(event.variable) })),
    calls,
  });
}

/**
 * Returns a function that renames the controller in a variable name: its original name may already be taken here.
 *
 * @param {string} from
 * @param {string} to
 */
function renamed(from, to) {
  return (/** @type {string} */ name) => (name.startsWith(`${from}.`) ? to + name.slice(from.length) : name);
}

/**
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {CompressionStream | DecompressionStream} stream
 * @param {number} most
 */
async function through(bytes, stream, most) {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts = [];
  let length = 0;
  for (let { done, value } = await reader.read(); !done && value; { done, value } = await reader.read()) {
    length += value.length;
    if (length > most)
      throw new EngineError(
        `The link would contain more than ${most} bytes: make a shorter run, or save files instead.`,
      );
    parts.push(value);
  }
  const whole = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}
