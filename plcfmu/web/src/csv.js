/** CSV files of the plant, as far as the page has to know them: the engine reads them. */

import { element } from "tool/dom.js";
import { ask, EngineError } from "tool/engine.js";

/** More than this the engine refuses; the page should not try. */
const MOST_BYTES = 60_000_000;

/**
 * The text of a file, whatever Windows has written it with.
 *
 * @param {Blob} file
 * @returns {Promise<string>}
 * @throws {EngineError} a sentence
 */
export async function textOf(file) {
  if (file.size > MOST_BYTES) {
    const size = Math.round(file.size / 1e6);
    throw new EngineError(
      `The file has ${size} MB; at most ${MOST_BYTES / 1e6} MB can be read. Cut out the part that matters.`,
    );
  }
  const bytes = new Uint8Array(await file.arrayBuffer());
  const encoding =
    bytes[0] === 0xff && bytes[1] === 0xfe ? "utf-16le" : bytes[0] === 0xfe && bytes[1] === 0xff ? "utf-16be" : "utf-8";
  try {
    return new TextDecoder(encoding, { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/**
 * The names of the columns; none if the text is no CSV file.
 *
 * @param {string} text
 * @returns {Promise<string[]>}
 */
export function columnsOf(text) {
  return ask({ do: "columns", text }).catch(() => []);
}

/**
 * A button that opens a CSV file, or takes one that is dropped on it.
 *
 * @param {string} id
 * @param {string} label
 * @param {(name: string, text: string) => void} take
 * @param {(error: unknown) => void} fail
 */
export function chooser(id, label, take, fail) {
  const input = element("input", { type: "file", accept: ".csv,.txt,.tsv,text/csv", id, class: "visually-hidden" });
  /** @param {File | undefined} file */
  const read = async (file) => {
    if (!file) return;
    try {
      take(file.name, await textOf(file));
    } catch (error) {
      fail(error);
    }
    input.value = "";
  };
  input.addEventListener("change", () => read(input.files?.[0]));
  const button = element("label", { class: "button drop", for: id }, label);
  button.addEventListener("dragover", (event) => event.preventDefault());
  button.addEventListener("drop", (event) => {
    event.preventDefault();
    event.stopPropagation();
    read(event.dataTransfer?.files[0]);
  });
  return element("span", { class: "chooser" }, input, button);
}
