// Asks the engine of a page, outside any browser: `node engine.mjs PAGE.html`; with --terminals it says what it imports and exports. Each line of standard input is a request, each
// line of standard output its answer. The engine is read from the page as the page itself reads it.

import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const [, packed] = page.match(/<script type="text\/plain" id="engine">([^<]*)</);
// Base 93: two digits are 13 bits, or 14 where there is room for them.
const digit = Object.fromEntries(Array.from({ length: 94 }, (_, at) => String.fromCharCode(33 + at)).filter((one) => one !== "<").map((one, at) => [one, at]));
const bytes = [];
let [bits, count] = [0, 0];
for (const [low, high] of packed.match(/..?/g)) {
  const value = digit[low] + 93 * (digit[high] ?? 0);
  bits |= value << count;
  count += high === undefined ? 8 - count : (value & 8191) < 93 * 93 - 8192 ? 14 : 13;
  for (; count > 7; count -= 8, bits >>= 8) bytes.push(bits & 255);
}
const engine = new WebAssembly.Module(gunzipSync(Buffer.from(bytes)));
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
