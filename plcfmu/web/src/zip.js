/** One file out of a ZIP archive. */

const END = 0x06054b50;
const ENTRY = 0x02014b50;
const [STORED, DEFLATED] = [0, 8];

/**
 * The content of a file in an archive, or nothing if it is not there.
 *
 * @param {Blob} archive
 * @param {string} path
 * @param {number} limit the largest size of the content in bytes
 * @returns {Promise<Uint8Array | undefined>}
 * @throws {Error} it is no archive, or the file in it is too large
 */
export async function unzipped(archive, path, limit) {
  // The end of the directory may be followed by a comment of 65535 bytes.
  const from = Math.max(0, archive.size - 22 - 0xffff);
  const tail = new DataView(await archive.slice(from).arrayBuffer());
  let end = tail.byteLength - 22;
  while (end >= 0 && tail.getUint32(end, true) !== END) end -= 1;
  if (end < 0) throw new Error("it is not a ZIP archive");
  const at = tail.getUint32(end + 16, true);
  const directory = new DataView(await archive.slice(at, at + tail.getUint32(end + 12, true)).arrayBuffer());
  for (let entry = 0; entry + 46 <= directory.byteLength && directory.getUint32(entry, true) === ENTRY; ) {
    const length = directory.getUint16(entry + 28, true);
    const name = new TextDecoder().decode(new Uint8Array(directory.buffer, entry + 46, length));
    if (name === path) return content(archive, directory, entry, limit);
    entry += 46 + length + directory.getUint16(entry + 30, true) + directory.getUint16(entry + 32, true);
  }
  return undefined;
}

/**
 * @param {Blob} archive
 * @param {DataView} directory
 * @param {number} entry
 * @param {number} limit
 */
async function content(archive, directory, entry, limit) {
  const method = directory.getUint16(entry + 10, true);
  const size = directory.getUint32(entry + 20, true);
  const local = directory.getUint32(entry + 42, true);
  const head = new DataView(await archive.slice(local, local + 30).arrayBuffer());
  const from = local + 30 + head.getUint16(26, true) + head.getUint16(28, true);
  const packed = archive.slice(from, from + size);
  if (method !== STORED && method !== DEFLATED) throw new Error("it is packed by a method that the page does not know");
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
