/**
 * The shape of a signal as SVG path data, which can also be drawn on a canvas: a line through its values, or a band if
 * only the lowest and the highest value of each group of calls are known.
 *
 * @typedef {object} How
 * @property {boolean} isExact whether each row is a call; otherwise, each pair of rows is a group of calls
 * @property {boolean} isStepped whether each value holds until the next one
 * @property {number} [base] lower edge of the filled area, for Booleans
 *
 * @typedef {(value: number) => number} Place
 */

/**
 * @param {ArrayLike<number>} times
 * @param {ArrayLike<number | null | undefined>} values
 * @param {How} how
 * @param {Place} x
 * @param {Place} y
 * @returns {{ stroke: string, fill: string }}
 */
export function outline(times, values, how, x, y) {
  return how.isExact ? line(times, values, how, x, y) : band(times, values, x, y);
}

/**
 * @param {ArrayLike<number>} times
 * @param {ArrayLike<number | null | undefined>} values
 * @param {How} how
 * @param {Place} x
 * @param {Place} y
 */
function line(times, values, { isStepped, base }, x, y) {
  const ground = base === undefined ? 0 : fixed(y(base));
  let [stroke, fill, piece, first, last] = ["", "", "", 0, 0];
  const close = () => {
    stroke += piece;
    if (base !== undefined && piece) fill += `${piece}H${last}V${ground}H${first}Z`;
    piece = "";
  };
  for (let at = 0; at < times.length; at += 1) {
    const value = values[at];
    if (value === null || value === undefined) {
      close();
      continue;
    }
    const [across, up] = [fixed(x(times[at])), fixed(y(value))];
    if (!piece) {
      first = across;
      piece = `M${across} ${up}`;
    } else piece += isStepped ? `H${across}V${up}` : `L${across} ${up}`;
    last = across;
  }
  close();
  return { stroke, fill };
}

/**
 * @param {ArrayLike<number>} times
 * @param {ArrayLike<number | null | undefined>} values
 * @param {Place} x
 * @param {Place} y
 */
function band(times, values, x, y) {
  let [high, low, fill] = ["", "", ""];
  let isDown = false;
  for (let at = 0; at < times.length; at += 2) {
    const pair = [values[at], values[at + 1]].filter((value) => value !== null && value !== undefined);
    if (pair.length === 0) {
      isDown = false;
      continue;
    }
    const [top, bottom] = [fixed(y(Math.max(...pair))), fixed(y(Math.min(...pair)))];
    const left = fixed(x(times[at]));
    // A group extends to the beginning of the next one.
    const end = Math.min(at + 2, times.length - 1);
    const right = Math.max(fixed(x(times[end])), left);
    const begin = isDown ? "V" : `M${left} `;
    high += `${begin}${top}H${right}`;
    low += `${begin}${bottom}H${right}`;
    if (bottom > top) fill += `M${left} ${top}H${right}V${bottom}H${left}Z`;
    isDown = true;
  }
  return { stroke: high + low, fill };
}

/** @param {number} value */
function fixed(value) {
  return Math.round(value * 10) / 10;
}
