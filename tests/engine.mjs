// Asks the engine of a page, outside any browser: `node engine.mjs PAGE.html`. Each line of standard input is a request, each
// line of standard output its answer. The engine is read from the page as the page itself reads it.

import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const [, packed] = page.match(/<script type="text\/plain" id="engine">([^<]*)</);
const engine = new WebAssembly.Module(gunzipSync(Buffer.from(packed, "base64")));
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
