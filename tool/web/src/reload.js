/**
 * Reopens the files passed to the command whenever one of them changes; inputs, forced variables and layout are kept.
 */

import { given, whereIsTheEngine } from "tool/engine.js";
import { openSaved } from "tool/files.js";
import { store } from "tool/store.js";

/** The polling interval, in milliseconds. */
const PAUSE = 1000;

/** The hash of the files as opened. */
let hash = "";

/** Starts watching the files. */
export async function watchFiles() {
  if (whereIsTheEngine() !== "server" || !document.getElementById("files")?.textContent?.trim()) return;
  hash = (await given(hash))?.hash ?? "";
  const look = async () => {
    try {
      const changed = document.hidden ? undefined : await given(hash);
      if (changed) {
        hash = changed.hash;
        await open(changed.files);
      }
    } catch {
      // The server is gone, which the next request to the engine reports: stop watching.
      return;
    }
    setTimeout(look, PAUSE);
  };
  setTimeout(look, PAUSE);
}

/** @param {{ file: string, content: string }[]} files */
async function open(files) {
  const wasRunning = store.isRunning;
  store.emit("pause");
  await openSaved(files);
  if (wasRunning && store.loop) store.emit("key-run");
}
