/**
 * Draws LAD and FBD networks with their power flow: paths that conduct in the displayed call are green and thick, paths
 * that do not are dashed, and paths whose state is unknown are plain. The truth values of wires are recorded during the
 * call; the values of variables are those at its end.
 *
 * @typedef {import("./messages").CodeBlock} Block
 * @typedef {import("./messages").From} From
 * @typedef {import("./messages").Operand} Operand
 * @typedef {import("tool/ladder_layout.js").Placed} Placed
 * @typedef {import("tool/usage.js").Way} Way
 *
 * @typedef {object} Told the known state of the call
 * @property {Map<number, boolean>} wires truth values by their numbers
 * @property {Set<number>} lines executed in the call
 * @property {(path: string, isGlobal: boolean) => { text: string, name: string | undefined, isForced: boolean } | undefined} value
 */

import { element, fill, svg, text } from "tool/dom.js";
import { cut, FLOW, layout, operandsOf, RAIL } from "tool/ladder_layout.js";
import { store } from "tool/store.js";
import { showUsage } from "tool/usage.js";

/** The smallest scale to which a network is shrunk to fit; beyond that, it scrolls. */
const SMALLEST = 0.75;

/** Functions that update the drawn elements for the displayed call. @type {((told: Told) => void)[]} */
let followers = [];
/** The selected variable. @type {Operand | undefined} */
let selected;
/** @type {HTMLElement} */
let bar;
/** @type {Told | undefined} */
let told;
/** @type {Block} */
let block;
/** @type {(of: import("tool/usage.js").Variable) => Way | undefined} */
let declaration = () => undefined;
/**
 * The block and the wires of the operands that decided the value which the user asked about.
 *
 * @type {{ block: string, wires: Set<number> } | undefined}
 */
let decided;

store.on("decided", (/** @type {typeof decided} */ of) => {
  decided = of;
  if (told) follow(told);
});

/**
 * Draws the networks of a block.
 *
 * @param {Block} of
 * @param {(of: import("tool/usage.js").Variable) => Way | undefined} wayTo returns a link to the declaration of a
 * variable
 * @returns {HTMLElement}
 */
export function ladder(of, wayTo) {
  followers = [];
  declaration = wayTo;
  if (block?.name !== of.name) selected = undefined;
  block = of;
  told = undefined;
  bar = element("div.row.ladder-bar", { role: "status" });
  const list = element("div.networks", { tabindex: 0, role: "region", "aria-label": `Networks of ${of.name}` });
  fill(list, of.networks.map(network));
  showBar();
  return element("div.ladder", bar, list);
}

/** Updates the drawn networks for a call. @param {Told} now */
export function follow(now) {
  told = now;
  for (const each of followers) each(now);
  showBar();
}

/** @param {import("./messages").Network} of */
function network(of) {
  const { placed, wires, width, height, rail } = layout(of);
  const lines = of.elements.map(({ line }) => line);
  /** Whether the network is known to have been executed. @param {Told} now */
  const isRun = (now) =>
    lines.some((line) => now.lines.has(line)) ||
    of.elements.some(({ outputs }) => outputs.some(({ wire }) => wire !== null && now.wires.has(wire)));
  /**
   * The truth value at the source of a wire; `undefined` if it is unknown.
   *
   * @param {From} from
   * @param {Told} now
   * @returns {boolean | undefined}
   */
  const truth = (from, now) => {
    if (from.operand) return noted(from.operand, now);
    if (from.element === null) return isRun(now) || undefined;
    const output = of.elements[from.element].outputs.find(({ pin }) => pin === from.pin);
    if (output?.is_rail) return isRun(now) || undefined;
    return noted(output, now);
  };
  const drawing = svg("svg", {
    ...{ width, height, viewBox: `0 0 ${width} ${height}`, class: "network-drawing" },
    // A wide network is first scaled down, then it scrolls.
    style: `min-width: ${Math.round(width * SMALLEST)}px`,
    ...{ role: "group", "aria-label": `Network ${of.number}` },
  });
  if (rail) {
    const line = svg("path.rail", { d: `M${RAIL} ${rail[0]}V${rail[1]}` });
    followers.push((now) => look(line, isRun(now) || undefined));
    drawing.append(line);
  }
  for (const { from, path, dots } of wires) {
    const line = svg("path.wire", { d: path });
    const marks = dots.map(([cx, cy]) => svg("circle.dot", { cx, cy, r: 2.5 }));
    followers.push((now) => {
      for (const one of [line, ...marks]) look(one, truth(from, now));
    });
    drawing.append(line, ...marks);
  }
  for (const one of placed) drawing.append(...part(one, truth));
  const title = `Network ${of.number}${of.title ? `: ${of.title}` : ""}`;
  return element(
    "section.network",
    { "data-network": of.number },
    element("h3", title),
    of.comment && element("p.faint", of.comment),
    of.labels.length > 0 && element("p", of.labels.map((label) => `${label}:`).join(" ")),
    element("div.wide", drawing),
  );
}

/**
 * The recorded value of an operand or an output pin; `undefined` if it was not evaluated.
 *
 * @param {{ wire: number | null } | null | undefined} of
 * @param {Told} now
 */
function noted(of, now) {
  const number = of?.wire ?? undefined;
  return number === undefined ? undefined : now.wires.get(number);
}

/** @param {Element} of @param {boolean | undefined} truth */
function look(of, truth) {
  of.classList.toggle("is-on", truth === true);
  of.classList.toggle("is-off", truth === false);
}

/**
 * The drawing of an element.
 *
 * @param {Placed} of
 * @param {(from: From, now: Told) => boolean | undefined} truth
 * @returns {SVGElement[]}
 */
function part(of, truth) {
  const { part, x, y } = of;
  if (of.look === "junction") return [];
  if (of.look === "box") return box(of);
  const middle = x + of.width / 2;
  const flow = y + FLOW;
  const [left, right] = [middle - of.inner / 2, middle + of.inner / 2];
  const isCoil = of.look === "coil";
  const shape = isCoil
    ? `M${left + 6} ${flow - 11}a14 14 0 0 0 0 22M${right - 6} ${flow - 11}a14 14 0 0 1 0 22`
    : `M${left} ${flow - 11}v22M${right} ${flow - 11}v22`;
  const symbol = svg(
    "g.symbol",
    svg("path", { d: shape }),
    part.sign === "/" && !isCoil
      ? svg("path", { d: `M${middle - 6} ${flow + 10}L${middle + 6} ${flow - 10}` })
      : svg("text", { x: middle, y: flow + 4, "text-anchor": "middle" }, part.sign),
  );
  const [before, after] = [
    `M${x} ${flow}H${isCoil ? left + 1 : left}`,
    `M${isCoil ? right - 1 : right} ${flow}H${x + of.width}`,
  ];
  const [lead, trail] = [svg("path.wire", { d: before }), svg("path.wire", { d: after })];
  const input = of.inputs[0]?.input;
  const out = of.outputs[0]?.output;
  const isLast = isCoil && !out;
  followers.push((now) => {
    const all = (input?.sources ?? []).map((from) => truth(from, now));
    const into = all.includes(true) ? true : all.every((one) => one === false) ? false : undefined;
    const carried = noted(out, now);
    look(lead, into);
    look(trail, out ? carried : into);
    look(symbol, isCoil ? into : (conducts(part, now) ?? carried));
    const hasDecided = decided?.block === block.name && decided.wires.has(part.above?.wire ?? -1);
    symbol.classList.toggle("is-deciding", !isCoil && hasDecided);
  });
  const second = of.inputs.slice(1).flatMap((pin) => (pin.input ? operandsOf(pin.input) : []));
  return [
    lead,
    ...(isLast ? [] : [trail]),
    symbol,
    ...(part.above ? name(part.above, middle, y + 14, "middle") : []),
    ...second.slice(0, 1).flatMap((one) => name(one, middle, flow + 26, "middle")),
  ];
}

/**
 * Whether a contact is closed by its operand, regardless of the power flow into it; `undefined` if unknown.
 *
 * @param {import("./messages").Element} part
 * @param {Told} now
 */
function conducts({ shape, sign, above }, now) {
  const is = noted(above, now);
  if (shape !== "contact" || is === undefined) return undefined;
  return sign === "" ? is : sign === "/" ? !is : undefined;
}

/** @param {Placed} of @returns {SVGElement[]} */
function box(of) {
  const { part, x, y, left, inner, height } = of;
  const [from, to] = [x + left, x + left + inner];
  const top = y + FLOW - 28;
  const drawn = [
    svg("rect.box", { x: from, y: top, width: inner, height: y + height - top, rx: 3 }),
    svg("text.box-title", { x: (from + to) / 2, y: top + 13, "text-anchor": "middle" }, cut(part.sign)),
    ...(part.above ? name(part.above, (from + to) / 2, y + 12, "middle", true) : []),
  ];
  for (const { y: at, input } of of.inputs) {
    if (!input) continue;
    const level = y + at;
    drawn.push(svg("text.pin", { x: from + 5, y: level + 4 }, input.pin.toLowerCase()));
    if (input.is_negated) drawn.push(svg("circle.negation", { cx: from - 3, cy: level, r: 3 }));
    for (const operand of operandsOf(input).slice(0, 1)) drawn.push(...name(operand, from - 6, level - 1, "end"));
  }
  for (const { y: at, output } of of.outputs) {
    if (!output) continue;
    const level = y + at;
    drawn.push(svg("text.pin", { x: to - 5, y: level + 4, "text-anchor": "end" }, output.pin.toLowerCase()));
    if (output.is_negated) drawn.push(svg("circle.negation", { cx: to + 3, cy: level, r: 3 }));
    for (const operand of output.targets.slice(0, 1)) drawn.push(...name(operand, to + 6, level - 1, "start"));
  }
  return drawn;
}

/**
 * Draws a variable's name with its value below.
 *
 * @param {Operand} operand
 * @param {number} x
 * @param {number} y
 * @param {"start" | "middle" | "end"} anchor
 * @param {boolean} [isInline] whether there is no room for a value
 * @returns {SVGElement[]}
 */
function name(operand, x, y, anchor, isInline = false) {
  const label = svg("text.operand", { x, y, "text-anchor": anchor }, cut(operand.text));
  label.append(svg("title", operand.text));
  if (!operand.path) return [label];
  const value = svg("text.value", { x, y: y + 14, "text-anchor": anchor });
  const choose = () => {
    selected = operand;
    showBar();
    for (const one of document.querySelectorAll(".network .operand"))
      one.classList.toggle("is-selected", one.firstChild?.textContent === label.firstChild?.textContent);
  };
  label.addEventListener("click", choose);
  label.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    event.stopPropagation();
    choose();
  });
  label.setAttribute("role", "button");
  label.setAttribute("tabindex", "0");
  label.classList.toggle("is-selected", selected?.text === operand.text);
  followers.push((now) => {
    const found = now.value(operand.path ?? "", operand.is_global);
    const truth = noted(operand, now);
    const shown = truth === undefined ? (found?.text ?? "") : truth ? "TRUE" : "FALSE";
    text(value, shown);
    value.classList.toggle("is-forced", found?.isForced === true);
    look(value, shown === "TRUE" ? true : shown === "FALSE" ? false : undefined);
  });
  return isInline ? [label] : [label, value];
}

/** Shows the actions for the selected variable. */
function showBar() {
  const path = selected?.path;
  if (!selected || !path) {
    fill(bar, element("span.faint", "Click a name to see why it has its value and where it is used."));
    return;
  }
  const go = (/** @type {number} */ number) =>
    bar.parentElement?.querySelector(`[data-network="${number}"]`)?.scrollIntoView({ block: "nearest" });
  const networks = (/** @type {(of: import("./messages").Element) => string[]} */ texts, /** @type {string} */ word) =>
    block.networks
      .filter(({ elements }) => elements.some((one) => texts(one).includes(selected?.text ?? "")))
      .map(({ number }) => ({
        label: `network ${number}`,
        title: `Network ${number} ${word} it`,
        go: () => go(number),
      }));
  const declared = declaration({ path, isGlobal: selected.is_global });
  showUsage(bar, selected.text, told?.value(path, selected.is_global), [
    ...(declared ? [/** @type {[string, Way[]]} */ (["declared", [declared]])] : []),
    ["written", networks(writes, "writes")],
    ["read", networks(reads, "reads")],
  ]);
}

/** The variables written by an element, as text. @param {import("./messages").Element} of */
function writes({ shape, sign, above, outputs }) {
  const isWriter = shape === "coil" || ["SR", "RS", "INC", "DEC"].includes(sign);
  return [
    ...(isWriter && above ? [above.text] : []),
    ...outputs.flatMap(({ targets }) => targets.map((one) => one.text)),
  ];
}

/** The variables read by an element, as text. @param {import("./messages").Element} of */
function reads(of) {
  const read = of.inputs.flatMap((input) => operandsOf(input).map(({ text }) => text));
  const isRead = of.above && !(of.shape === "coil" && writes(of).includes(of.above.text));
  return isRead && of.above ? [...read, of.above.text] : read;
}
