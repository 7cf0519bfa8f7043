/**
 * What the page is packed in, and its beginning: the modules, each after those that it imports, as [name, text]. Each is known
 * as a URL of this page alone.
 */

/** The values of the digits of base 85: from ! to }, but for those that mean something in HTML or in a text. */
const VALUES = new Map();
for (let code = 33; code < 126; code += 1)
  if (!"\"&'<>\\`|".includes(String.fromCharCode(code))) VALUES.set(code, VALUES.size);

/**
 * The content of an element that holds gzip in base 85.
 *
 * @param {string} id
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
globalThis.unpackedElement = async (id) => {
  const text = document.getElementById(id)?.textContent?.trim() ?? "";
  const groups = Math.ceil(text.length / 5);
  const bytes = new Uint8Array(4 * groups);
  const view = new DataView(bytes.buffer);
  for (let group = 0; group < groups; group += 1) {
    let number = 0;
    // Behind the end there are highest digits.
    for (let at = 5 * group; at < 5 * group + 5; at += 1)
      number = 85 * number + (VALUES.get(text.charCodeAt(at)) ?? 84);
    view.setUint32(4 * group, number);
  }
  const packed = bytes.subarray(0, bytes.length - (5 * groups - text.length));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
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
