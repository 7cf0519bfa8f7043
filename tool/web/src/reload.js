/**
 * Files that the command was given: when one is saved, it is opened again, with the inputs, what is forced and the layout as they are.
 */

import { given, whereIsTheEngine } from "tool/engine.js";
import { openSaved } from "tool/files.js";
import { store } from "tool/store.js";

/** How often is asked, in milliseconds. */
const PAUSE = 1000;

/** Which version of the files is open. */
let hash = "";

/** Begins to look at the files. */
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
      // The server has ended, as the next request to the engine will show.
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
