/** Extracts files from ZIP archives, and copies archives with some files replaced. */

const END = 0x06054b50;
const ENTRY = 0x02014b50;
const FILE = 0x04034b50;
const [STORED, DEFLATED] = [0, 8];
/**
 * The date of all files: 1 January 1980, the earliest that an archive can express. It is fixed, so that the same
 * content always results in the same bytes.
 */
const DAY = 0x21;
/** The flag for UTF-8 names. */
const UTF8 = 0x800;

/**
 * Reads the directory of an archive: its bytes, and the offset of each file's entry in it.
 *
 * @param {Blob} archive
 * @throws {Error} if it is not an archive
 */
async function opened(archive) {
  // The record at the end of the archive may contain a comment of up to 65535 bytes.
  const from = Math.max(0, archive.size - 22 - 0xffff);
  const tail = new DataView(await archive.slice(from).arrayBuffer());
  let end = tail.byteLength - 22;
  while (end >= 0 && tail.getUint32(end, true) !== END) end -= 1;
  if (end < 0) throw new Error("it is not a ZIP archive");
  const at = tail.getUint32(end + 16, true);
  const directory = new DataView(await archive.slice(at, at + tail.getUint32(end + 12, true)).arrayBuffer());
  /** @type {Map<string, number>} */
  const files = new Map();
  for (let entry = 0; entry + 46 <= directory.byteLength && directory.getUint32(entry, true) === ENTRY; ) {
    const length = directory.getUint16(entry + 28, true);
    files.set(new TextDecoder().decode(new Uint8Array(directory.buffer, entry + 46, length)), entry);
    entry += 46 + length + directory.getUint16(entry + 30, true) + directory.getUint16(entry + 32, true);
  }
  return { directory, files };
}

/**
 * The content of a file in an archive; `undefined` if there is no such file.
 *
 * @param {Blob} archive
 * @param {string} path
 * @param {number} limit the maximum size of the content in bytes
 * @returns {Promise<Uint8Array | undefined>}
 * @throws {Error} if it is not an archive, or the file is too large
 */
export async function unzipped(archive, path, limit) {
  const { directory, files } = await opened(archive);
  const entry = files.get(path);
  return entry === undefined ? undefined : content(archive, directory, entry, limit);
}

/**
 * The contents of the wanted files in an archive, by path.
 *
 * @param {Blob} archive
 * @param {(path: string) => boolean} isWanted
 * @param {number} limit the maximum total size of the contents in bytes
 * @returns {Promise<Map<string, Uint8Array<ArrayBuffer>>>}
 * @throws {Error} if it is not an archive, or too large
 */
export async function unzippedAll(archive, isWanted, limit) {
  const { directory, files } = await opened(archive);
  /** @type {Map<string, Uint8Array<ArrayBuffer>>} */
  const contents = new Map();
  let rest = limit;
  for (const [path, entry] of files) {
    if (!isWanted(path)) continue;
    const bytes = await content(archive, directory, entry, rest);
    rest -= bytes.length;
    contents.set(path, bytes);
  }
  return contents;
}

/**
 * A copy of an archive with some files replaced and others removed. Unchanged files are copied in compressed form.
 *
 * @param {Blob} archive
 * @param {Map<string, Uint8Array<ArrayBuffer>>} changed the new or changed files
 * @param {(path: string) => boolean} isLeftOut
 * @returns {Promise<Blob>}
 * @throws {Error} if it is not an archive
 */
export async function rezipped(archive, changed, isLeftOut) {
  const { directory, files } = await opened(archive);
  /** @type {Blob[]} */
  const parts = [];
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const entries = [];
  let length = 0;
  /**
   * @param {string} path
   * @param {Blob} packed
   * @param {{ method: number, sum: number, size: number, attributes: number }} of
   */
  const add = (path, packed, { method, sum, size, attributes }) => {
    const name = new TextEncoder().encode(path);
    // The fields that a file's header and its directory entry have in common, beginning with the version needed.
    const shared = new DataView(new ArrayBuffer(26));
    shared.setUint16(0, 20, true);
    shared.setUint16(2, UTF8, true);
    shared.setUint16(4, method, true);
    shared.setUint16(8, DAY, true);
    shared.setUint32(10, sum, true);
    shared.setUint32(14, packed.size, true);
    shared.setUint32(18, size, true);
    shared.setUint16(22, name.length, true);
    const rest = new DataView(new ArrayBuffer(14));
    rest.setUint32(6, attributes, true);
    rest.setUint32(10, length, true);
    entries.push(joined([number32(ENTRY), new Uint8Array([20, 3]), bytes(shared), bytes(rest), name]));
    const head = joined([number32(FILE), bytes(shared), name]);
    parts.push(new Blob([head]), packed);
    length += head.length + packed.size;
  };
  for (const [path, entry] of files) {
    if (changed.has(path) || isLeftOut(path)) continue;
    add(path, await packedAt(archive, directory, entry), {
      method: directory.getUint16(entry + 10, true),
      sum: directory.getUint32(entry + 16, true),
      size: directory.getUint32(entry + 24, true),
      attributes: directory.getUint32(entry + 38, true),
    });
  }
  for (const [path, raw] of changed) {
    const stream = new Blob([raw]).stream().pipeThrough(new CompressionStream("deflate-raw"));
    const packed = await new Response(stream).blob();
    add(path, packed, { method: DEFLATED, sum: checksum(raw), size: raw.length, attributes: 0o100644 << 16 });
  }
  const size = entries.reduce((sum, entry) => sum + entry.length, 0);
  const end = new DataView(new ArrayBuffer(22));
  end.setUint32(0, END, true);
  end.setUint16(8, entries.length, true);
  end.setUint16(10, entries.length, true);
  end.setUint32(12, size, true);
  end.setUint32(16, length, true);
  return new Blob([...parts, ...entries, end], { type: "application/octet-stream" });
}

/** @param {number} value */
function number32(value) {
  const view = new DataView(new ArrayBuffer(4));
  view.setUint32(0, value, true);
  return bytes(view);
}

/** @param {DataView<ArrayBuffer>} view */
function bytes(view) {
  return new Uint8Array(view.buffer);
}

/** @param {Uint8Array[]} parts */
function joined(parts) {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** The CRC-32 of bytes. @param {Uint8Array} of */
function checksum(of) {
  let sum = ~0;
  for (const byte of of) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit += 1) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
  }
  return ~sum >>> 0;
}

/**
 * The compressed bytes of a file in an archive.
 *
 * @param {Blob} archive
 * @param {DataView} directory
 * @param {number} entry
 */
async function packedAt(archive, directory, entry) {
  const local = directory.getUint32(entry + 42, true);
  const head = new DataView(await archive.slice(local, local + 30).arrayBuffer());
  const from = local + 30 + head.getUint16(26, true) + head.getUint16(28, true);
  return archive.slice(from, from + directory.getUint32(entry + 20, true));
}

/**
 * @param {Blob} archive
 * @param {DataView} directory
 * @param {number} entry
 * @param {number} limit
 */
async function content(archive, directory, entry, limit) {
  const method = directory.getUint16(entry + 10, true);
  const packed = await packedAt(archive, directory, entry);
  if (method !== STORED && method !== DEFLATED)
    throw new Error("it uses a compression method that the page does not support");
  const stream =
    method === STORED ? packed.stream() : packed.stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const parts = [];
  let length = 0;
  const reader = stream.getReader();
  for (;;) {
    const { value, done } = await reader.read();
    if (done) break;
    length += value.byteLength;
    if (length > limit) {
      await reader.cancel();
      throw new Error(`a file in it is larger than ${limit} bytes`);
    }
    parts.push(value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}
