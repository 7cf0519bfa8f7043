/**
 * Places the elements of a network and routes its wires. Columns run from the rail to the right, with each element to
 * the right of its inputs; there is one row per branch.
 *
 * @typedef {import("./messages").Network} Network
 * @typedef {import("./messages").Element} Part
 * @typedef {import("./messages").Input} Input
 * @typedef {import("./messages").Output} Output
 * @typedef {import("./messages").From} From
 *
 * @typedef {object} Pin
 * @property {number} y distance from the top of its element
 * @property {Input} [input]
 * @property {Output} [output]
 *
 * @typedef {object} Placed
 * @property {Part} part
 * @property {number} number of the element in its network
 * @property {string} look `contact`, `compare`, `coil`, `junction`, `box`
 * @property {number} column
 * @property {number} row
 * @property {number} x
 * @property {number} y
 * @property {number} width
 * @property {number} height
 * @property {number} left width of the text on the left of a box
 * @property {number} inner width of the box or the symbol
 * @property {Pin[]} inputs
 * @property {Pin[]} outputs
 *
 * @typedef {object} Wire
 * @property {From} from
 * @property {string} path
 * @property {[number, number][]} dots where wires meet
 *
 * @typedef {object} Layout
 * @property {Placed[]} placed
 * @property {Wire[]} wires
 * @property {number} width
 * @property {number} height
 * @property {[number, number] | undefined} rail top and bottom of the rail
 */

/** The distance of an element's first pin from the element's top, with space for a name and a value above. */
export const FLOW = 46;
/** The spacing of pins, of columns and of rows. */
const [PIN, GAP, BETWEEN] = [32, 20, 10];
/** The x coordinate of the rail. */
export const RAIL = 8;
/** The approximate width of a letter, in pixels. */
const LETTER = 6.7;
/** The factor by which a letter in a box title is wider. */
const BOLD = 1.25;
const MOST_LETTERS = 20;
const SYMBOL = 28;
/** The minimum width of a contact, coil or comparison, with space for the value of its operand. */
const LEAST = 76;

/** A name, shortened for display. @param {string} name */
export function cut(name) {
  return name.length > MOST_LETTERS ? `${name.slice(0, MOST_LETTERS - 1)}…` : name;
}

/** @param {string} text */
function wide(text) {
  return Math.min(text.length, MOST_LETTERS) * LETTER;
}

/** The number in the name of a pin IN1, IN2 ...; 0 for any other pin. @param {string} pin */
function numberOf(pin) {
  return Number(/^IN(\d+)$/.exec(pin)?.[1] ?? 0);
}

/** @param {Input} input */
function isWired({ sources }) {
  return sources.some(({ operand }) => !operand);
}

/** The operands of an input pin. @param {Input} input */
export function operandsOf({ sources }) {
  return sources.flatMap(({ operand }) => operand ?? []);
}

/**
 * Determines an element's pins and size.
 *
 * @param {Part} part
 * @param {number} number
 * @param {boolean} isLadder
 * @returns {Placed}
 */
function sized(part, number, isLadder) {
  const look = isLadder || part.shape === "junction" ? part.shape : "box";
  const place = { part, number, look, column: 0, row: 0, x: 0, y: 0, left: 0 };
  // Wired pins, which carry the power flow, are at the top. IN1 is above IN2, whatever their order in the file.
  const inputs = part.inputs.toSorted(
    (a, b) => Number(isWired(b)) - Number(isWired(a)) || numberOf(a.pin) - numberOf(b.pin),
  );
  const flows = part.outputs.filter((one) => one.wire !== null || one.is_rail);
  const outputs = [...flows, ...part.outputs.filter((one) => !flows.includes(one) && one.targets.length > 0)];
  if (look === "junction") {
    const pins = inputs.map((input) => ({ y: FLOW, input }));
    return {
      ...place,
      width: 0,
      inner: 0,
      height: FLOW + 12,
      inputs: pins,
      outputs: outputs.map((output) => ({ y: FLOW, output })),
    };
  }
  const above = part.above ? wide(part.above.text) : 0;
  if (look === "box") {
    const rows = Math.max(inputs.length, outputs.length, 1);
    const text = (/** @type {import("./messages").Operand[]} */ all) =>
      Math.max(0, ...all.map((one) => wide(one.text)));
    const left = Math.max(0, ...inputs.map((input) => text(operandsOf(input)))) + 4;
    const right = Math.max(0, ...outputs.map((output) => text(output.targets))) + 4;
    const names =
      Math.max(0, ...inputs.map(({ pin }) => wide(pin))) + Math.max(0, ...outputs.map(({ pin }) => wide(pin)));
    const inner = Math.max(56, names + 24, wide(part.sign) * BOLD + 16, above - Math.min(left, right) * 2);
    return {
      ...place,
      ...{ left, inner, width: left + inner + right, height: FLOW + rows * PIN - 8 },
      inputs: inputs.map((input, at) => ({ y: FLOW + at * PIN, input })),
      outputs: outputs.map((output, at) => ({ y: FLOW + at * PIN, output })),
    };
  }
  const [flow, ...rest] = inputs;
  const below = look === "compare" || rest.length > 0;
  const names = rest.flatMap((input) => operandsOf(input).map(({ text }) => wide(text)));
  const width = Math.max(LEAST, SYMBOL + wide(part.sign) + 12, above + 8, ...names.map((name) => name + 8));
  return {
    ...place,
    ...{ width, inner: Math.max(SYMBOL, wide(part.sign) + 16), height: FLOW + (below ? 44 : 16) },
    inputs: [{ y: FLOW, input: flow }, ...rest.map((input) => ({ y: FLOW, input }))].filter(({ input }) => input),
    outputs: outputs.map((output) => ({ y: FLOW, output })),
  };
}

/**
 * The wires into an element, with the pins at which they end.
 *
 * @param {Placed} of
 * @returns {{ pin: Pin, from: From }[]}
 */
function needed({ inputs }) {
  return inputs.flatMap((pin) => (pin.input?.sources ?? []).flatMap((from) => (from.operand ? [] : [{ pin, from }])));
}

/**
 * @param {Network} network
 * @returns {Layout}
 */
export function layout(network) {
  const placed = network.elements.map((part, number) => sized(part, number, network.has_rail));
  columns(placed, network.has_rail);
  rows(placed);
  const widths = /** @type {number[]} */ ([]);
  const heights = /** @type {number[]} */ ([]);
  for (const { column, row, width, height } of placed) {
    widths[column] = Math.max(widths[column] ?? 0, width);
    heights[row] = Math.max(heights[row] ?? 0, height);
  }
  const lefts = sums(widths, network.has_rail ? RAIL + GAP : GAP / 2, GAP);
  const tops = sums(heights, 0, BETWEEN);
  for (const one of placed) {
    one.x = lefts[one.column];
    one.y = tops[one.row];
    // Align the symbols of a column.
    if (one.look !== "box" && one.look !== "junction") one.width = widths[one.column];
  }
  const wires = placed.flatMap((to) => needed(to).map(({ pin, from }) => wire(placed, to, pin, from, tops, heights)));
  const fed = wires
    .filter(({ from }) => from.element === null)
    .map(({ path }) => Number(/^M[\d.]+ ([\d.]+)/.exec(path)?.[1]));
  return {
    ...{ placed, wires },
    width: (lefts.at(-1) ?? 0) + (widths.at(-1) ?? 0) + 12,
    height: (tops.at(-1) ?? 0) + (heights.at(-1) ?? FLOW) + 4,
    rail: fed.length > 0 ? [Math.min(...fed) - 20, Math.max(...fed) + 16] : undefined,
  };
}

/**
 * The start positions of consecutive lengths, with gaps between them.
 *
 * @param {number[]} lengths
 * @param {number} from
 * @param {number} gap
 */
function sums(lengths, from, gap) {
  return Array.from(lengths, (length) => {
    const begin = from;
    from += (length ?? 0) + gap;
    return begin;
  });
}

/**
 * Assigns columns: each element is to the right of its inputs, and a coil at the end of a rung is in the last column.
 *
 * @param {Placed[]} placed
 * @param {boolean} isLadder
 */
function columns(placed, isLadder) {
  const open = new Set(placed);
  // The longest path needs at most one round per element. The limit ends the search if wires form a loop.
  for (let round = 0; round <= placed.length && open.size > 0; round += 1) {
    for (const one of open) {
      const before = needed(one).flatMap(({ from }) => (from.element === null ? [] : [placed[from.element]]));
      if (before.some((other) => open.has(other) && other !== one)) continue;
      one.column = Math.max(0, ...before.map(({ column }) => column + 1));
      open.delete(one);
    }
  }
  if (!isLadder) return;
  const last = Math.max(0, ...placed.map(({ column }) => column));
  for (const one of placed) if (one.look === "coil" && ends(placed, one)) one.column = last;
}

/** Whether no other element uses an output of this one. @param {Placed[]} placed @param {Placed} one */
function ends(placed, one) {
  return !placed.some((other) => needed(other).some(({ from }) => from.element === one.number));
}

/**
 * Assigns rows: an element's first input is in the element's own row; each other input starts a new row below.
 *
 * @param {Placed[]} placed
 */
function rows(placed) {
  let next = 0;
  const done = new Set();
  const place = (/** @type {Placed} */ one, /** @type {number} */ row) => {
    done.add(one);
    one.row = row;
    let isFirst = true;
    for (const { from } of needed(one)) {
      const before = from.element === null ? undefined : placed[from.element];
      if (before && !done.has(before)) place(before, isFirst ? row : next++);
      isFirst = false;
    }
  };
  for (const one of placed.filter((of) => ends(placed, of))) if (!done.has(one)) place(one, next++);
  // Elements in a loop of wires, which has no last element.
  for (const one of placed) if (!done.has(one)) place(one, next++);
}

/**
 * @param {Placed[]} placed
 * @param {Placed} to
 * @param {Pin} pin
 * @param {From} from
 * @param {number[]} tops
 * @param {number[]} heights
 * @returns {Wire}
 */
function wire(placed, to, pin, from, tops, heights) {
  const end = [to.x + (to.look === "box" ? to.left : 0), to.y + pin.y];
  const source = from.element === null ? undefined : placed[from.element];
  // The rail feeds a pin in the pin's own row.
  if (!source) return { from, path: `M${RAIL} ${end[1]}H${end[0]}`, dots: [] };
  const out = source.outputs.find(({ output }) => output?.pin === from.pin) ?? source.outputs[0] ?? { y: FLOW };
  const begin = [source.x + (source.look === "box" ? source.left + source.inner : source.width), source.y + out.y];
  const isOneOf = (pin.input?.sources.length ?? 0) > 1;
  const isSplit = placed.some(
    (other) => other !== to && needed(other).some((one) => one.from.element === source.number),
  );
  if (source.row === to.row && to.column - source.column > 1 && between(placed, source, to)) {
    const under = tops[to.row] + heights[to.row] + BETWEEN / 2;
    const [left, right] = [begin[0] + 8, end[0] - 8];
    return { from, path: `M${begin[0]} ${begin[1]}H${left}V${under}H${right}V${end[1]}H${end[0]}`, dots: [] };
  }
  // A wire that leads up turns just before its end; a wire that leads down turns just after its beginning.
  const turn = begin[1] > end[1] ? end[0] - GAP / 2 : begin[0] + GAP / 2;
  const path =
    begin[1] === end[1] ? `M${begin[0]} ${begin[1]}H${end[0]}` : `M${begin[0]} ${begin[1]}H${turn}V${end[1]}H${end[0]}`;
  const dots = /** @type {[number, number][]} */ ([]);
  if (begin[1] > end[1] && isOneOf) dots.push([turn, end[1]]);
  if (begin[1] < end[1] && isSplit) dots.push([turn, begin[1]]);
  return { from, path, dots };
}

/**
 * Whether there is an element between two others in a row.
 *
 * @param {Placed[]} placed
 * @param {Placed} from
 * @param {Placed} to
 */
function between(placed, from, to) {
  return placed.some(({ row, column }) => row === from.row && column > from.column && column < to.column);
}
