/**
 * What the page is packed in, and its beginning: a script of all modules, known as a URL of this page alone, and the engine, which
 * is compiled beside it.
 */

/**
 * What is packed by gzip in base 93: two digits are 13 bits, or 14 where 93 squared has room for them. The digits are the
 * characters from ! to ~, but for <, which means something in a script. The worker has a copy of its text.
 *
 * @param {string} text
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
const unpack = async (text) => {
  const base = 93;
  const digits = new Uint8Array(127);
  for (let code = 33, digit = 0; code < 127; code += 1) if (code !== 60) digits[code] = digit++;
  const packed = new Uint8Array(text.length);
  let length = 0;
  let bits = 0;
  let count = 0;
  const pairs = text.length - (text.length % 2);
  for (let at = 0; at < pairs; at += 2) {
    const value = digits[text.charCodeAt(at)] + base * digits[text.charCodeAt(at + 1)];
    bits |= value << count;
    count += (value & 0x1fff) < base * base - 0x2000 ? 14 : 13;
    for (; count > 7; count -= 8) {
      packed[length++] = bits;
      bits >>= 8;
    }
  }
  if (pairs < text.length) packed[length++] = bits | (digits[text.charCodeAt(pairs)] << count);
  const stream = new Blob([packed.subarray(0, length)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

/** @param {string} text */
const script = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));

/** @param {string} id */
const packed = (id) => document.getElementById(id)?.textContent?.trim() ?? "";

/** @type {Promise<unknown>} */
const whole = new Promise((done) => {
  if (document.readyState === "loading") addEventListener("DOMContentLoaded", done);
  else done(undefined);
});

/**
 * The unpacked content of an element; nothing if there is none.
 *
 * @param {string} id
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
globalThis.unpackedElement = async (id) => {
  await whole;
  const text = packed(id);
  return text ? unpack(text) : new Uint8Array();
};

/** The engine of the page, if it has one: it is compiled in a worker, or here where there can be none. */
globalThis.compiledEngine = whole.then(async () => {
  const text = packed("engine");
  if (!text) return undefined;
  const work = `const unpack = ${unpack};
onmessage = async ({ data }) => postMessage(await unpack(data).then(WebAssembly.compile).catch(() => null));`;
  /** @type {WebAssembly.Module | null} */
  const module = await new Promise((done) => {
    const worker = new Worker(script(work));
    worker.onmessage = ({ data }) => {
      worker.terminate();
      done(data);
    };
    worker.onerror = () => done(null);
    worker.postMessage(text);
  }).catch(() => null);
  return module ?? WebAssembly.compile(await unpack(text));
});

await import(script(new TextDecoder().decode(await unpack(packed("modules")))));
