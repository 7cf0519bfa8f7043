/**
 * What the page is packed in, and its beginning: the modules, each after those that it imports, as [name, text]. Each is known
 * as a URL of this page alone.
 */

/** The values of the digits of base 93: from ! to ~, but for <, which means something in a script. */
const BASE = 93;
const VALUES = new Uint8Array(127);
for (let code = 33, digits = 0; code < 127; code += 1) if (code !== 60) VALUES[code] = digits++;

/**
 * The content of an element that holds gzip in base 93: two digits are 13 bits, or 14 where 93 squared has room for them.
 *
 * @param {string} id
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
globalThis.unpackedElement = async (id) => {
  const text = document.getElementById(id)?.textContent?.trim() ?? "";
  const packed = new Uint8Array(text.length);
  let length = 0;
  let bits = 0;
  let count = 0;
  const pairs = text.length - (text.length % 2);
  for (let at = 0; at < pairs; at += 2) {
    const value = VALUES[text.charCodeAt(at)] + BASE * VALUES[text.charCodeAt(at + 1)];
    bits |= value << count;
    count += (value & 0x1fff) < BASE * BASE - 0x2000 ? 14 : 13;
    for (; count > 7; count -= 8) {
      packed[length++] = bits;
      bits >>= 8;
    }
  }
  if (pairs < text.length) packed[length++] = bits | (VALUES[text.charCodeAt(pairs)] << count);
  const stream = new Blob([packed.subarray(0, length)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

/** @type {Map<string, string>} */
const places = new Map();
const modules = new TextDecoder().decode(await globalThis.unpackedElement("modules"));
for (const [name, text] of /** @type {[string, string][]} */ (JSON.parse(modules))) {
  const linked = text.replace(/^(import |.* from )"(tool\/.+)";$/gm, (_, how, of) => `${how}"${places.get(of)}";`);
  places.set(name, URL.createObjectURL(new Blob([linked], { type: "text/javascript" })));
}

/** A module by its name, for tests and for the console: `await moduleOf("tool/store.js")`. @param {string} name */
globalThis.moduleOf = (name) => import(places.get(name) ?? name);

await import(places.get("vendor/uPlot.iife.min.js") ?? "");
await import([...places.values()].at(-1) ?? "");
