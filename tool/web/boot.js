/**
 * Unpacks and starts the page: a script with all modules, which runs from a blob URL, and the engine, which a worker
 * compiles in parallel.
 */

/**
 * Decodes a base-93 string: two digits hold 13 bits, or 14 where the value permits, since 93 squared exceeds 2^13. The
 * digits are the characters from ! to ~ except <, which has a meaning in HTML. The worker runs a copy of this
 * function's source.
 *
 * @param {string} text
 * @returns {Uint8Array<ArrayBuffer>}
 */
const decoded = (text) => {
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
  return packed.subarray(0, length);
};

/**
 * Decodes a base-93 string and unpacks it with gzip.
 *
 * @param {string} text
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
const unpack = async (text) => {
  const stream = new Blob([decoded(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

/**
 * Unpacks LZMA: the unpacked length in 4 bytes (little-endian), then a stream without a header, with 4 literal context
 * bits. The worker runs a copy of this function's source.
 *
 * @param {Uint8Array<ArrayBuffer>} packed
 * @returns {Uint8Array<ArrayBuffer>}
 */
const expand = (packed) => {
  const size = new DataView(packed.buffer, packed.byteOffset).getUint32(0, true);
  const out = new Uint8Array(size);
  // Offsets of the probabilities in `chances`: of decisions by state, of distances, lengths and literals.
  const [isMatch, isRepeat, isOlder, isOldest, isThird, isLong] = [0, 12, 24, 36, 48, 60];
  const [slots, near, low, lengths, repeats, literals] = [72, 328, 443, 459, 733, 1007];
  const chances = new Uint16Array(literals + (0x300 << 4)).fill(1024);
  let at = 5;
  let range = 0xffffffff;
  let code = 0;
  const refill = () => {
    range = (range << 8) >>> 0;
    code = ((code << 8) | packed[at++]) >>> 0;
  };
  for (let first = 0; first < 4; first += 1) code = ((code << 8) | packed[at++]) >>> 0;
  const bit = (/** @type {number} */ place) => {
    const chance = chances[place];
    const bound = (range >>> 11) * chance;
    let is = 0;
    if (code < bound) {
      range = bound;
      chances[place] = chance + ((2048 - chance) >> 5);
    } else {
      range = (range - bound) >>> 0;
      code = (code - bound) >>> 0;
      chances[place] = chance - (chance >> 5);
      is = 1;
    }
    if (range < 0x1000000) refill();
    return is;
  };
  /** A number of `count` bits, most significant bit first. @param {number} place @param {number} count */
  const number = (place, count) => {
    let found = 1;
    for (let each = 0; each < count; each += 1) found = (found << 1) | bit(place + found);
    return found - (1 << count);
  };
  /** The same, least significant bit first. @param {number} place @param {number} count */
  const reversed = (place, count) => {
    let [found, tree] = [0, 1];
    for (let each = 0; each < count; each += 1) {
      const is = bit(place + tree);
      tree = (tree << 1) | is;
      found |= is << each;
    }
    return found;
  };
  const lengthOf = (/** @type {number} */ place) => {
    if (bit(place) === 0) return number(place + 2, 3);
    return bit(place + 1) === 0 ? 8 + number(place + 10, 3) : 16 + number(place + 18, 8);
  };
  const distanceOf = (/** @type {number} */ length) => {
    const slot = number(slots + 64 * Math.min(length, 3), 6);
    if (slot < 4) return slot;
    const count = (slot >> 1) - 1;
    const begin = (2 | (slot & 1)) << count;
    if (slot < 14) return begin + reversed(near + begin - slot, count);
    let direct = 0;
    for (let each = 4; each < count; each += 1) {
      range >>>= 1;
      const is = code >= range ? 1 : 0;
      if (is === 1) code = (code - range) >>> 0;
      direct = (direct << 1) | is;
      if (range < 0x1000000) refill();
    }
    return begin + (direct << 4) + reversed(low, 4);
  };
  const before = [0, 0, 0, 0];
  let state = 0;
  for (let to = 0; to < size; ) {
    if (bit(isMatch + state) === 0) {
      const place = literals + 0x300 * ((to > 0 ? out[to - 1] : 0) >> 4);
      let symbol = 1;
      // After a match, the byte that would have continued the match selects the probabilities.
      for (
        let match = state > 6 ? out[to - before[0] - 1] : -1;
        match >= 0 && symbol < 0x100;
        match = (match << 1) & 0xff
      ) {
        const expected = match >> 7;
        const is = bit(place + ((1 + expected) << 8) + symbol);
        symbol = (symbol << 1) | is;
        if (is !== expected) break;
      }
      while (symbol < 0x100) symbol = (symbol << 1) | bit(place + symbol);
      out[to++] = symbol;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let length = 0;
    if (bit(isRepeat + state) === 0) {
      length = lengthOf(lengths);
      before.unshift(distanceOf(length));
      before.pop();
      state = state < 7 ? 7 : 10;
    } else {
      if (bit(isOlder + state) === 1) {
        const which = bit(isOldest + state) === 0 ? 1 : bit(isThird + state) === 0 ? 2 : 3;
        before.unshift(...before.splice(which, 1));
      } else if (bit(isLong + state) === 0) {
        out[to] = out[to - before[0] - 1];
        to += 1;
        state = state < 7 ? 9 : 11;
        continue;
      }
      length = lengthOf(repeats);
      state = state < 7 ? 8 : 11;
    }
    const from = to - before[0] - 1;
    for (let each = 0; each < length + 2; each += 1) out[to + each] = out[from + each];
    to += length + 2;
  }
  return out;
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
 * The unpacked content of an element; empty if the element is missing or empty.
 *
 * @param {string} id
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
globalThis.unpackedElement = async (id) => {
  await whole;
  const text = packed(id);
  return text ? unpack(text) : new Uint8Array();
};

/** The compiled engine, if the page contains one: compiled in a worker, or here if that fails. */
globalThis.compiledEngine = whole.then(async () => {
  const text = packed("engine");
  if (!text) return undefined;
  const work = `const decoded = ${decoded};
const expand = ${expand};
onmessage = async ({ data }) => postMessage(await WebAssembly.compile(expand(decoded(data))).catch(() => null));`;
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
  return module ?? WebAssembly.compile(expand(decoded(text)));
});

await import(script(new TextDecoder().decode(await unpack(packed("modules")))));
