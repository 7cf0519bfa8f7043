/**
 * The catalogue blocks inside a program, such as its controllers. The user chooses one for the diagram, sees its
 * parameters with their current values, and can open it as a separate loop, to tune and replay it like any other.
 *
 * @typedef {import("./messages").Description} Description
 * @typedef {import("tool/store.js").Work} Work
 */

import { assetOf } from "tool/assets.js";
import { choice, element, fill, text } from "tool/dom.js";
import { onceAFrame } from "tool/frame.js";
import { programOf } from "tool/program.js";
import { beginWith, runValue, store } from "tool/store.js";
import { isTime, plcTime, shown } from "tool/values.js";

/**
 * The catalogue blocks inside a loop's program that have a diagram.
 *
 * @param {Work} loop
 */
async function blocksInside(loop) {
  const natives = programOf(loop)?.compiled.parts.filter((part) => part.is_native) ?? [];
  const known = await Promise.all(
    natives.map(async (part) => ((await assetOf(part.block))?.diagram && isInCatalogue(part.block) ? part : undefined)),
  );
  return known.flatMap((part) => part ?? []);
}

/** @param {string} block */
function isInCatalogue(block) {
  return store.catalogue.fmus.some(({ name }) => name === block);
}

/**
 * The inner block that is displayed: the user's choice, or else the first.
 *
 * @param {Work} loop
 */
export async function chosenInside(loop) {
  const all = await blocksInside(loop);
  return all.find(({ path }) => path === loop.notes.inside) ?? all[0];
}

/**
 * The description of an inner block: its variables in the program, under their names in the block.
 *
 * @param {Work} loop
 * @param {string} path
 * @returns {Description}
 */
export function descriptionInside(loop, path) {
  const own = loop.description.variables.filter(({ name }) => name.startsWith(`${path}.`));
  return { ...loop.description, variables: own.map((one) => ({ ...one, name: one.name.slice(path.length + 1) })) };
}

/** @type {HTMLElement} */
let body;
/**
 * The cells that show values, with their PLC types, by the variable's name in the program.
 *
 * @type {Map<string, { kind: string, place: HTMLElement }>}
 */
let values = new Map();

/**
 * Mounts the list of inner blocks above the diagram and the parameters of the chosen one below it.
 *
 * @param {HTMLElement} content
 */
export function mountInside(content) {
  const head = element("div.row.inside");
  body = element("div.inside");
  content.prepend(head);
  content.append(body);
  store.on("loop", () => show(head));
  store.on("plant", () => show(head));
  const due = onceAFrame(update);
  for (const what of ["state", "run"]) store.on(what, () => values.size > 0 && due());
}

/** @param {HTMLElement} head */
async function show(head) {
  const loop = store.loop;
  values = new Map();
  if (!loop || !programOf(loop)) {
    fill(head);
    fill(body);
    return;
  }
  const all = await blocksInside(loop);
  const one = await chosenInside(loop);
  const of = one && (await store.describe(one.block));
  if (store.loop !== loop) return;
  if (!one || !of) {
    fill(head);
    fill(body);
    return;
  }
  const paths = all.map(({ path, block }) => [path, `${path}: ${block}`]);
  const list = choice({ id: "inside-choice" }, paths, one.path, (path) => {
    loop.notes.inside = path;
    store.emit("loop");
  });
  const open = element(
    "button",
    {
      ...{ onclick: () => openAlone(loop, one.path, one.block).catch(store.say) },
      title: "Keeps its values, the plant and the connections; copy the tuned values back into the source yourself",
    },
    "Open as a separate loop",
  );
  fill(head, element("label", { for: "inside-choice" }, "Block inside the program"), list, open);
  fill(body, ...of.groups.map((group) => parameters(loop, one.path, of, group)));
  update();
}

/**
 * The parameters of an inner block, which the program sets.
 *
 * @param {Work} loop
 * @param {string} path
 * @param {Description} of
 * @param {import("./messages").Group} group
 */
function parameters(loop, path, of, group) {
  const rows = group.fields.flatMap(({ name }) => {
    const variable = of.variables.find((one) => one.name === name);
    const own = loop.description.variables.find((one) => one.name === `${path}.${name}`);
    if (!variable || !own) return [];
    const place = element("td.number");
    values.set(own.name, { kind: own.kind, place });
    const line = lineOf(loop, path, name);
    return element(
      "tr",
      { title: variable.description },
      element("td.name", name),
      place,
      element("td.faint", line ? `line ${line}` : ""),
    );
  });
  return rows.length === 0
    ? null
    : element("details", { open: true }, element("summary", group.title), element("table", rows));
}

/**
 * The source line in which the program passes a parameter to the block; `undefined` if it does not pass it.
 *
 * @param {Work} loop
 * @param {string} path
 * @param {string} name
 */
function lineOf(loop, path, name) {
  const found = passed(loop, path, name);
  return found?.line;
}

/**
 * The argument that the program's main block passes for a parameter of an instance.
 *
 * @param {Work} loop
 * @param {string} path
 * @param {string} name
 */
function passed(loop, path, name) {
  const { compiled } = programOf(loop) ?? {};
  const block = compiled?.blocks.find((one) => one.name.toUpperCase() === compiled.block.toUpperCase());
  const call = block?.calls.find((one) => one.instance.toUpperCase() === path.toUpperCase());
  return call?.arguments.find((one) => one.formal.toUpperCase() === name.toUpperCase());
}

function update() {
  const loop = store.loop;
  if (!loop) return;
  for (const [name, { kind, place }] of values) {
    const start = loop.description.variables.find((one) => one.name === name)?.start;
    const now = runValue(loop, name) ?? start;
    text(place, isTime(kind) ? plcTime(Number(now)) : shown(now, kind));
  }
}

/**
 * Opens an inner block as a loop with its current values and the same plant.
 *
 * @param {Work} loop
 * @param {string} path
 * @param {string} block
 */
async function openAlone(loop, path, block) {
  const description = await store.describe(block);
  /** @type {import("./messages").Values} */
  const now = {};
  for (const { name, role, start } of description.variables) {
    const value = runValue(loop, `${path}.${name}`) ?? startOf(loop, `${path}.${name}`);
    if (role !== "output" && role !== "local" && value !== undefined && value !== start) now[name] = value;
  }
  const cycle = loop.settings[loop.description.cycle ?? ""]?.sent;
  if (description.cycle && cycle !== undefined) now[description.cycle] = cycle;
  const { members, step, exchange } = loop;
  const connections = loop.connections;
  const made = await store.add(`${loop.name}.${path}`, block);
  store.edit(now);
  await store.send();
  beginWith(made);
  // A connection to a variable of the program becomes one to the block's terminal for which the program passes that
  // variable.
  const own = (/** @type {string} */ end) => {
    if (!end.startsWith(`${loop.member}.`)) return end;
    const name = end.slice(loop.member.length + 1).toUpperCase();
    const all = description.variables.filter((one) => passed(loop, path, one.name)?.path?.toUpperCase() === name);
    return all.length > 0 ? `${made.member}.${all[0].name}` : undefined;
  };
  const wires = connections.flatMap(([from, to]) => {
    const ends = [own(from), own(to)];
    return ends.every((end) => end !== undefined) ? [/** @type {[string, string]} */ (ends)] : [];
  });
  const copies = members.map((member) => ({ ...member, values: { ...member.values } }));
  await store.connect({ members: copies, connections: wires, step, exchange });
  store.say(
    `${made.name} is ${path} of ${loop.name} with its current values. Changes to it do not affect the program.`,
  );
}

/** @param {Work} loop @param {string} name */
function startOf(loop, name) {
  return loop.description.variables.find((one) => one.name === name)?.start;
}
