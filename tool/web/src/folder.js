/** Reads files from folders and ZIP archives that the user drops or selects as a whole. */

import { EngineError } from "tool/engine.js";
import { unzippedAll } from "tool/zip.js";

/** The maximum number of files in a dropped folder; a project has hundreds. */
const MOST_FILES = 5000;
const LARGEST = 32_000_000;

/** The paths of files found in a folder or an archive. @type {WeakMap<File, string>} */
const paths = new WeakMap();

/** The path of a file, if it is in a folder or an archive. @param {File} file */
export function pathOf(file) {
  return paths.get(file) ?? (file.webkitRelativePath || undefined);
}

/**
 * Creates a file with a path.
 *
 * @param {string} path
 * @param {Uint8Array<ArrayBuffer>} content
 * @param {boolean} [isOne] whether to keep the path: the file is in a folder or an archive
 */
export function fileAt(path, content, isOne = path.includes("/")) {
  const file = new File([content], path.slice(path.lastIndexOf("/") + 1));
  if (isOne) paths.set(file, path);
  return file;
}

/**
 * The dropped files, including those in folders. The entries are read before the first `await`, because the browser
 * discards them afterwards.
 *
 * @param {DataTransfer} transfer
 */
export async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry());
  const files = [...transfer.files];
  if (!entries.some((entry) => entry?.isDirectory)) return files;
  /** @type {File[]} */
  const found = [];
  for (const entry of entries) if (entry) await collect(entry, found);
  return found;
}

/** @param {FileSystemEntry} entry @param {File[]} found */
async function collect(entry, found) {
  if (entry.name.startsWith(".")) return;
  if (found.length > MOST_FILES)
    throw new EngineError(`The folder has more than ${MOST_FILES} files: drop only the folder with the program.`);
  if (entry.isFile) {
    const file = await new Promise((done, failed) => /** @type {FileSystemFileEntry} */ (entry).file(done, failed));
    const path = entry.fullPath.replace(/^\//, "");
    if (path.includes("/")) paths.set(file, path);
    found.push(file);
    return;
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  for (;;) {
    // A browser returns at most a hundred entries at a time.
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (some.length === 0) return;
    for (const one of some) await collect(one, found);
  }
}

/**
 * The files, with each archive replaced by its content.
 *
 * @param {Iterable<File>} files
 */
export async function unpackedFiles(files) {
  /** @type {File[]} */
  const all = [];
  for (const file of files) {
    if (!/\.zip$/i.test(file.name)) {
      all.push(file);
      continue;
    }
    const parts = await unzippedAll(file, (path) => !/(^|\/)[.]|\/$|^__MACOSX/.test(path), LARGEST);
    for (const [path, content] of parts) all.push(fileAt(path, content, true));
  }
  return all;
}
