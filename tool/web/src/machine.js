/**
 * Opens program sources. If one block is a machine and another the plant that it controls, both run as programs,
 * connected with each other.
 *
 * @typedef {import("./messages").KnownLoop} KnownLoop
 * @typedef {import("./messages").Program} Program
 * @typedef {import("tool/store.js").Work} Work
 */

import { EngineError } from "tool/engine.js";
import { choose } from "tool/plant.js";
import { admit, openProgram, programNamed, programOf, programs, refused, sourcesOf, translate } from "tool/program.js";
import { store } from "tool/store.js";

/** Words that identify a block as a plant. */
const PLANT = /plant|simul|process|strecke/i;

/**
 * Opens sources together. If exactly two blocks are not called by any other, and the name of only one of them
 * identifies it as a plant, that one is connected to the other as its plant.
 *
 * @param {File[]} files
 */
export async function openSources(files) {
  const loop = await openProgram(files);
  if (loop) return renewPlant(loop);
  const { program, compiled } = refused() ?? {};
  const plants = compiled?.candidates.filter((name) => PLANT.test(name)) ?? [];
  if (!program || compiled?.candidates.length !== 2 || plants.length !== 1) return undefined;
  const machine = compiled.candidates.find((name) => name !== plants[0]);
  return machine && openWith(program, machine, plants[0]);
}

/**
 * Opens one block of the sources as the machine and another as its plant.
 *
 * @param {Program} program
 * @param {string} machine
 * @param {string} plant
 */
export async function openWith(program, machine, plant) {
  const answer = await admit({ ...program, run: plant });
  // Show the plant's problems at their lines.
  if (!answer.fmu) return translate({ ...program, run: plant });
  const loop = await translate({ ...program, run: machine });
  if (!loop) return undefined;
  await choose(answer.fmu);
  const wires = loop.connections.length;
  store.say(
    `${machine} runs with ${plant} as its plant. Connections found by matching names: ${wires}. Check them in the Plant tab.`,
  );
  return loop;
}

/**
 * Adds the FMUs for the programs of a described loop. They are built from sources opened with the description or
 * earlier.
 *
 * @param {KnownLoop} known
 * @param {File[]} files
 * @returns {Promise<KnownLoop>}
 */
export async function withPrograms(known, files) {
  const given = await sourcesOf(files);
  const opened = programs().flatMap((program) => program.files);
  /** @type {Map<string, string>} */
  const made = new Map();
  for (const { member, sources, program } of known.programs) {
    const of = sources.map((name) => [...given, ...opened].find(({ file }) => file === name));
    const missing = sources.filter((_, at) => of[at] === undefined);
    if (missing.length > 0)
      throw new EngineError(`${member} is a program: drop ${missing.join(", ")} together with this description.`);
    const whole = /** @type {Program} */ ({ ...program, files: of });
    const { fmu } = await admit(whole);
    if (!fmu) {
      // Show problems at their lines.
      await translate(whole);
      throw new EngineError(`The program ${member} was rejected: correct the errors shown in its source.`);
    }
    made.set(member, fmu);
  }
  const members = known.setup.members.map((member) => ({ ...member, fmu: made.get(member.name) ?? member.fmu }));
  return { ...known, setup: { ...known.setup, members } };
}

/**
 * After sources have been reopened, rebuilds the other members' programs that were built from them, such as the
 * plant's.
 *
 * @param {Work} loop
 */
async function renewPlant(loop) {
  const { program } = programOf(loop) ?? {};
  if (!program) return;
  const files = new Map(program.files.map((one) => [one.file, one]));
  const members = [];
  for (const member of loop.members) {
    const of = programNamed(member.fmu)?.program;
    const isOld = of?.files.every(({ file }) => files.has(file));
    const fresh = of && isOld ? await admit({ ...of, files: program.files }) : undefined;
    members.push(fresh?.fmu ? { ...member, fmu: fresh.fmu } : member);
  }
  const { connections, step, exchange } = loop;
  if (members.some(({ fmu }, at) => fmu !== loop.members[at].fmu))
    await store.connect({ members, connections, step, exchange });
}
