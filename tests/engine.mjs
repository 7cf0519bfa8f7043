// Asks the engine of a page, outside any browser: `node engine.mjs PAGE.html`; with --terminals it says what it imports and exports. Each line of standard input is a request, each
// line of standard output its answer. The engine is read from the page as the page itself reads it.

import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";

const page = readFileSync(process.argv[2], "utf8");
const text = (id) => page.match(new RegExp(`<script type="text/plain" id="${id}">([^<]*)<`))?.[1] ?? "";
// The page's own script unpacks the engine; its modules need a browser.
globalThis.document = {
  readyState: "complete",
  getElementById: (id) => ({ textContent: id === "modules" ? "" : text(id) }),
};
const boot = page.match(/<script type="module" async>(.*?)<\/script>/s)[1];
await import(`data:text/javascript,${encodeURIComponent(boot)}`).catch(() => undefined);
const engine = await globalThis.compiledEngine;
if (process.argv[3] === "--terminals") {
  console.log(JSON.stringify([WebAssembly.Module.imports(engine), WebAssembly.Module.exports(engine)]));
  process.exit();
}
// Without imports: it has no files, no clock, no network.
const { memory, room, message, answer } = new WebAssembly.Instance(engine).exports;

for await (const line of createInterface({ input: process.stdin })) {
  const request = Buffer.from(line);
  // The memory may be another one after any call.
  const place = room(request.length);
  new Uint8Array(memory.buffer, place, request.length).set(request);
  const length = message();
  const text = answer();
  process.stdout.write(`${Buffer.from(memory.buffer, text, length)}\n`);
}
