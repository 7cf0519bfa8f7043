/**
 * CSV recordings of a plant. The page only decodes the text; the engine parses it.
 *
 * @typedef {object} Recording
 * @property {string} name the file's name
 * @property {string} text
 * @property {string[]} columns the column names
 */

import { element } from "tool/dom.js";
import { ask, EngineError } from "tool/engine.js";
import { store } from "tool/store.js";

/** The maximum file size. The engine would reject larger files. */
const MOST_BYTES = 60_000_000;

/**
 * Reads a CSV file in UTF-8, UTF-16 or Windows-1252.
 *
 * @param {File} file
 * @returns {Promise<Recording>}
 * @throws {EngineError} if the file is too large or the engine rejects it
 */
export async function recordingOf(file) {
  if (file.size > MOST_BYTES) {
    const size = Math.round(file.size / 1e6);
    throw new EngineError(
      `The file is ${size} MB; at most ${MOST_BYTES / 1e6} MB can be read. Cut it down to the part that matters.`,
    );
  }
  const text = decoded(new Uint8Array(await file.arrayBuffer()));
  try {
    return { name: file.name, text, columns: await ask({ do: "columns", text }) };
  } catch (error) {
    throw error instanceof EngineError ? new EngineError(`${file.name}: ${error.message}`) : error;
  }
}

/** @param {Uint8Array} bytes */
function decoded(bytes) {
  const encoding =
    bytes[0] === 0xff && bytes[1] === 0xfe ? "utf-16le" : bytes[0] === 0xfe && bytes[1] === 0xff ? "utf-16be" : "utf-8";
  try {
    return new TextDecoder(encoding, { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/**
 * A button that opens a CSV file, which can also be dropped on it.
 *
 * @param {string} id
 * @param {string} label
 * @param {(recording: Recording) => void} take
 * @param {(error: unknown) => void} fail
 */
export function chooser(id, label, take, fail) {
  const input = element("input.visually-hidden", { type: "file", accept: ".csv,.txt,.tsv,text/csv", id });
  /** @param {File | undefined} file */
  const read = async (file) => {
    if (!file) return;
    store.emit("opening");
    try {
      take(await recordingOf(file));
    } catch (error) {
      fail(error);
    }
    input.value = "";
  };
  input.addEventListener("change", () => read(input.files?.[0]));
  const button = element("label.button.drop", { for: id }, label);
  button.addEventListener("dragover", (event) => event.preventDefault());
  button.addEventListener("drop", (event) => {
    event.preventDefault();
    event.stopPropagation();
    read(event.dataTransfer?.files[0]);
  });
  return element("span.chooser", input, button);
}
