/**
 * Elements of the page. Text goes in as text and never as markup: names and titles come from files of other people.
 *
 * @typedef {Node | string | number | null | undefined | false} Child
 */

/**
 * A new element.
 *
 * A property that begins with `on` is a listener; `class`, `data-...`, `aria-...` and all else are attributes, where `true` is
 * an empty attribute and `false`, `null` and `undefined` none.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Child | Child[])} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else attribute(made, name, value);
  }
  append(made, children);
  return made;
}

/**
 * The head of a table: a row with a title for each column.
 *
 * @param {Child[]} titles
 * @param {(column: number) => boolean} [isNumber] whether a column holds numbers
 */
export function tableHead(titles, isNumber = () => false) {
  const cells = titles.map((title, at) => element("th", { scope: "col", class: isNumber(at) && "number" }, title));
  return element("thead", {}, element("tr", {}, cells));
}

/**
 * A new element of SVG; attributes as in {@link element}.
 *
 * @param {string} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Child | Child[])} children
 * @returns {SVGElement}
 */
export function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else attribute(made, name, value);
  }
  append(made, children);
  return made;
}

/**
 * Sets an attribute, or removes it with `false`, `null` and `undefined`.
 *
 * @param {Element} of
 * @param {string} name
 * @param {any} value
 */
export function attribute(of, name, value) {
  if (value === false || value === null || value === undefined) of.removeAttribute(name);
  else if (of.getAttribute(name) !== (value === true ? "" : String(value))) {
    of.setAttribute(name, value === true ? "" : String(value));
  }
}

/**
 * Replaces all that is in an element.
 *
 * @param {Element} within
 * @param {...(Child | Child[])} children
 */
export function fill(within, ...children) {
  within.textContent = "";
  append(within, children);
}

/**
 * Sets a text if it is another: a text that is set anew loses its selection.
 *
 * @param {Element} within
 * @param {string} text
 */
export function text(within, text) {
  if (within.textContent !== text) within.textContent = text;
}

/**
 * The element with an id.
 *
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found;
}

/**
 * @param {Element} within
 * @param {(Child | Child[])[]} children
 */
function append(within, children) {
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false) continue;
    within.append(typeof child === "number" ? String(child) : child);
  }
}
