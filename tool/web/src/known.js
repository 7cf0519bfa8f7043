/** Opens loops from descriptions: the examples, and files for `plcfmu run`. */

import { programOf, showOutputs } from "tool/program.js";
import { remake } from "tool/remake.js";
import { beginWith, store } from "tool/store.js";
import { number } from "tool/values.js";

/**
 * Opens a described loop with its plant and runs it according to its description.
 *
 * @param {import("./messages").KnownLoop} known
 * @param {string} [file] name of the description file
 */
export async function openKnown(known, file) {
  const [controller, ...members] = known.setup.members;
  // If a member is not in the catalogue, fail before anything is opened.
  for (const { fmu } of known.setup.members) await store.describe(fmu);
  const loop = await store.add(controller.name, controller.fmu, undefined, file);
  // Replaces the controller's name in the description with its name here.
  const own = (/** @type {string} */ name) =>
    name.startsWith(`${controller.name}.`) ? loop.member + name.slice(controller.name.length) : name;
  store.edit(controller.values);
  await store.send();
  beginWith(loop);
  const connections = known.setup.connections.map(
    ([from, to]) => /** @type {[string, string]} */ ([own(from), own(to)]),
  );
  const copies = members.map((member) => ({ ...member, values: { ...member.values } }));
  const { step, exchange } = known.setup;
  const isProgram = programOf(loop) !== undefined;
  if (isProgram) showOutputs(loop);
  await store.connect({ members: copies, connections, step, exchange });
  const { cycle } = loop.description;
  const length = step ?? (number(cycle ? loop.settings[cycle]?.sent : undefined) || 1);
  const events = known.events.map(([time, variable, value]) => {
    const call = Math.round(time / length);
    return { call, time, variable: own(variable), value };
  });
  await remake(loop, { setup: store.setup(), events, calls: Math.round((known.stop ?? 0) / length) });
  if (!isProgram) {
    if (loop.description.roles.controller.length > 0) store.emit("show", "tune");
    return;
  }
  store.emit("program");
  store.emit("show", "program");
}
