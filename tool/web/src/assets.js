/**
 * Help, diagrams and texts of FMUs, built into the page.
 *
 * They are HTML and SVG. Only visible elements and harmless attributes are copied, because a user's own block has texts
 * by that user.
 *
 * @typedef {{ diagram: string, help: Record<string, string>, about: string }} Asset
 */

import { unpacked } from "tool/engine.js";

/** @type {Promise<Record<string, Asset>> | undefined} */
let assets;

/**
 * The page's content for an FMU.
 *
 * @param {string} fmu
 * @returns {Promise<Asset | undefined>}
 */
export async function assetOf(fmu) {
  assets ??= read();
  return (await assets)[fmu];
}

async function read() {
  if (!document.getElementById("assets")?.textContent?.trim()) return {};
  return JSON.parse(new TextDecoder().decode(await unpacked("assets")));
}

const HTML = new Set(
  "a b br code dd div dl dt em h2 h3 h4 h5 i li ol p pre s span strong sub sup table tbody td th thead tr ul".split(
    " ",
  ),
);
const MATH = new Set(
  "math mfrac mi mn mo mover mpadded mphantom mroot mrow mspace msqrt mstyle msub msubsup msup mtable mtd mtext mtr munder munderover semantics".split(
    " ",
  ),
);
const SVG = new Set("circle ellipse g line path polygon polyline rect svg text title tspan".split(" "));
const FORBIDDEN = /^(on|href$|src$|xlink:href$|style$|id$)/;

/**
 * The allowed elements of an HTML string; other elements are replaced by their content.
 *
 * @param {string} text
 * @returns {DocumentFragment}
 */
export function html(text) {
  const parsed = new DOMParser().parseFromString(text, "text/html");
  const fragment = document.createDocumentFragment();
  fragment.append(...[...parsed.body.childNodes].flatMap((node) => copy(node)));
  return fragment;
}

/**
 * The allowed elements of an SVG drawing, with their ids; `undefined` if the text is not SVG.
 *
 * @param {string} text
 * @returns {SVGSVGElement | undefined}
 */
export function drawing(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
  if (parsed.tagName !== "svg") return undefined;
  const [made] = copy(parsed, true);
  return made instanceof SVGSVGElement ? made : undefined;
}

/**
 * @param {Node} node
 * @param {boolean} [keepsIds]
 * @returns {Node[]}
 */
function copy(node, keepsIds = false) {
  if (node.nodeType === Node.TEXT_NODE) return [document.createTextNode(node.textContent ?? "")];
  if (!(node instanceof Element)) return [];
  const children = () => [...node.childNodes].flatMap((child) => copy(child, keepsIds));
  const name = node.localName;
  if (name === "script" || name === "style") return [];
  if (!HTML.has(name) && !MATH.has(name) && !SVG.has(name)) return children();
  const made = document.createElementNS(node.namespaceURI, name);
  for (const attribute of node.attributes) {
    if (FORBIDDEN.test(attribute.name) && !(keepsIds && attribute.name === "id")) continue;
    if (attribute.name !== "xmlns") made.setAttribute(attribute.name, attribute.value);
  }
  const target = name === "a" ? node.getAttribute("href") : null;
  if (target && /^https?:/.test(target)) {
    made.setAttribute("href", target);
    made.setAttribute("target", "_blank");
    made.setAttribute("rel", "noreferrer");
  }
  made.append(...children());
  return [made];
}
