/**
 * Converts values of PLC types to and from the text that users read and type.
 *
 * @typedef {import("./messages").Value} Value
 */

/** Integer PLC types with their ranges. @type {Record<string, [number, number]>} */
const WHOLE = {
  INT: [-32768, 32767],
  WORD: [-32768, 32767],
  DINT: [-2147483648, 2147483647],
  Integer: [-2147483648, 2147483647],
};
const BOOLEAN = new Set(["BOOL", "Boolean"]);
const LONGEST_TIME = 2147483647;

/** @param {string} kind */
export function isBoolean(kind) {
  return BOOLEAN.has(kind);
}

/** @param {string} kind */
export function isTime(kind) {
  return kind === "TIME";
}

/**
 * A value as a number; true is 1.
 *
 * @param {Value | undefined | null} value
 * @returns {number}
 */
export function number(value) {
  if (value === undefined || value === null) return Number.NaN;
  if (typeof value === "string") return { NaN: Number.NaN, inf: Infinity, "-inf": -Infinity }[value] ?? Number.NaN;
  return Number(value);
}

/**
 * Whether two values are equal in a variable of this type: a REAL has 24 significant bits, a TIME whole milliseconds.
 *
 * @param {string} kind
 * @param {Value} one
 * @param {Value} other
 */
export function same(kind, one, other) {
  const [a, b] = [number(one), number(other)];
  if (kind === "REAL") return Object.is(Math.fround(a), Math.fround(b));
  if (kind === "TIME") return Math.round(a * 1000) === Math.round(b * 1000);
  return Object.is(a, b);
}

/**
 * A value with just enough digits to distinguish it from its neighbours in its type: a REAL 0.1 is `0.1`.
 *
 * @param {Value | undefined | null} value
 * @param {string} kind
 * @returns {string}
 */
export function shown(value, kind) {
  if (value === undefined || value === null) return "";
  if (isBoolean(kind) || typeof value === "boolean") return value ? "TRUE" : "FALSE";
  const x = number(value);
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "NaN" : x > 0 ? "inf" : "-inf";
  if (kind === "REAL") return String(shortest(x));
  if (kind === "TIME") return String(Math.round(x * 1000) / 1000);
  return Object.is(x, -0) ? "-0" : String(x);
}

/**
 * A value rounded to this many significant digits, for display only: copied values must be exact.
 *
 * @param {Value | undefined | null} value
 * @param {string} kind
 * @param {number} [digits]
 */
export function rounded(value, kind, digits = 5) {
  const full = shown(value, kind);
  const x = number(value);
  if (!Number.isFinite(x) || isBoolean(kind)) return full;
  return String(Number(x.toPrecision(digits)));
}

/** The bit string types, with their numbers of hexadecimal digits. @type {Record<string, number>} */
const BITS = { BYTE: 2, WORD: 4, DWORD: 8 };

/**
 * A bit string in PLC notation, such as `16#0002`; `undefined` for other types.
 *
 * @param {Value | undefined | null} value
 * @param {string} kind
 * @returns {string | undefined}
 */
export function hexadecimal(value, kind) {
  const digits = BITS[kind.toUpperCase()];
  const x = number(value);
  if (digits === undefined || !Number.isInteger(x)) return undefined;
  const bits = x < 0 ? x + 16 ** digits : x;
  return `16#${bits.toString(16).toUpperCase().padStart(digits, "0")}`;
}

/**
 * A value of a program in PLC notation: TIMEs and bit strings in their own notations, whole numbers with all digits,
 * other numbers rounded for display.
 *
 * @param {Value | undefined | null} value
 * @param {string} kind
 * @param {number} [digits]
 */
export function plcText(value, kind, digits = 7) {
  if (value === undefined || value === null) return "";
  if (isTime(kind)) return plcTime(number(value));
  const isWhole = !/REAL$/i.test(kind) && Number.isInteger(number(value));
  return hexadecimal(value, kind) ?? (isWhole ? shown(value, kind) : rounded(value, kind, digits));
}

/**
 * A TIME in PLC notation, such as `T#1M20S500MS`.
 *
 * @param {number} seconds
 */
export function plcTime(seconds) {
  let rest = Math.round(Math.abs(seconds) * 1000);
  if (rest === 0) return "T#0MS";
  let text = seconds < 0 ? "T#-" : "T#";
  for (const [name, length] of /** @type {[string, number][]} */ ([
    ["D", 86_400_000],
    ["H", 3_600_000],
    ["M", 60_000],
    ["S", 1000],
    ["MS", 1],
  ])) {
    const count = Math.floor(rest / length);
    if (count > 0) text += `${count}${name}`;
    rest -= count * length;
  }
  return text;
}

/**
 * Parses the user's text; returns the value, or the problem and its remedy.
 *
 * @param {string} text
 * @param {{ name: string, kind: string }} variable
 * @returns {{ value: Value } | { why: string }}
 */
export function read(text, { name, kind }) {
  const written = text.trim();
  if (written === "") return { why: `${name} needs a value.` };
  if (isBoolean(kind)) {
    if (/^(true|1|on)$/i.test(written)) return { value: true };
    if (/^(false|0|off)$/i.test(written)) return { value: false };
    return { why: `${name} is a ${kind}: enter TRUE or FALSE.` };
  }
  if (isTime(kind)) return readTime(written, name);
  const plain = written.replace(/^([+-]?\d+),(\d+(?:e[+-]?\d+)?)$/i, "$1.$2");
  const hexadecimal = /^(?:W#)?16#([0-9a-f_]+)$/i.exec(plain);
  let value = hexadecimal ? Number.parseInt(hexadecimal[1].replaceAll("_", ""), 16) : Number(plain);
  if (!hexadecimal && !/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain)) {
    return { why: `"${short(written)}" is not a number; enter one such as 2.5 or 1e-3.` };
  }
  const range = WHOLE[kind];
  if (range) {
    if (hexadecimal && kind === "WORD" && value > 32767 && value <= 65535) value -= 65536;
    if (!Number.isInteger(value)) return { why: `${name} is of type ${kind}: enter a whole number.` };
    if (value < range[0] || value > range[1]) {
      return { why: `${name} is of type ${kind}: enter a number from ${range[0]} to ${range[1]}.` };
    }
  }
  const held = kind === "REAL" ? Math.fround(value) : value;
  if (!Number.isFinite(held))
    return { why: `${short(written)} exceeds the range of type ${kind} (a REAL holds magnitudes up to about 3.4e38).` };
  return { value };
}

/**
 * @param {string} written
 * @param {string} name
 * @returns {{ value: Value } | { why: string }}
 */
function readTime(written, name) {
  const form = `"${short(written)}" is not a time; enter seconds such as 1.5, or 500 ms, 2 min, T#1M30S.`;
  const compact = written
    .replace(/^(t|time)#/i, "")
    .replaceAll("_", "")
    .replace(",", ".");
  const sign = compact.startsWith("-") ? -1 : 1;
  const parts = [...compact.replace(/^[+-]/, "").matchAll(/\s*(\d+\.?\d*|\.\d+)\s*(ms|min|d|h|m|s|)\s*/giy)];
  if (parts.length === 0 || parts.map(([part]) => part).join("") !== compact.replace(/^[+-]/, "")) return { why: form };
  if (parts.length > 1 && parts.some(([, , unit]) => unit === "")) return { why: form };
  /** @type {Record<string, number>} */
  const length = { "": 1000, ms: 1, s: 1000, m: 60_000, min: 60_000, h: 3_600_000, d: 86_400_000 };
  const total = parts.reduce((sum, [, count, unit]) => sum + Number(count) * length[unit.toLowerCase()], 0);
  const milliseconds = Math.round(total);
  if (Math.abs(total - milliseconds) > 1e-6)
    return { why: `${name} is a TIME, which holds whole milliseconds: round the value.` };
  if (milliseconds > LONGEST_TIME) return { why: `${name} is a TIME: at most 2147483.647 s (about 24 days).` };
  return { value: (sign * milliseconds) / 1000 };
}

/** @param {string} text */
function short(text) {
  return text.length > 30 ? `${text.slice(0, 30)}...` : text;
}

/**
 * The number with the fewest digits that yields the same REAL.
 *
 * @param {number} x
 */
function shortest(x) {
  const real = Math.fround(x);
  if (real !== x) return x;
  for (let digits = 1; digits < 10; digits += 1) {
    const tried = Number(x.toPrecision(digits));
    if (Math.fround(tried) === real) return tried;
  }
  return x;
}
