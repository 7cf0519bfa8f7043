// Asks the engine of a page, outside any browser: `node engine.mjs PAGE.html`; with --terminals it says what it imports and exports. Each line of standard input is a request, each
// line of standard output its answer. The engine is read from the page as the page itself reads it.

import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const [, packed] = page.match(/<script type="text\/plain" id="engine">([^<]*)</);
// Base 85: five digits are four bytes.
const digits = Array.from({ length: 93 }, (_, at) => String.fromCharCode(33 + at)).filter((one) => !"\"&'<>\\`|".includes(one));
const bytes = packed.match(/.{1,5}/g).flatMap((group) => {
  const number = [...group.padEnd(5, "}")].reduce((sum, digit) => 85 * sum + digits.indexOf(digit), 0);
  return [24, 16, 8, 0].map((place) => Math.floor(number / 2 ** place) & 255).slice(0, group.length - 1);
});
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
