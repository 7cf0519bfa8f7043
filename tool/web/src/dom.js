/**
 * Creates and changes page elements. Text is always inserted as text, never as markup, because names and titles come
 * from files.
 *
 * @typedef {Node | string | number | null | undefined | false} Child
 * @typedef {Record<string, string | number | boolean | null | undefined | Function>} Attributes
 */

/**
 * Creates an element from a tag, optional attributes, and children: `element("p.faint", "No run yet")`.
 *
 * A dot in the tag starts a class. An attribute whose value is a function adds a listener for the event in its name
 * after `on`. `true` sets an empty attribute; `false`, `null` and `undefined` set none. A button has the type `button`
 * by default, so it submits no form.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag | `${Tag}.${string}`} tag
 * @param {Attributes | Child | Child[]} [first]
 * @param {...(Child | Child[])} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, first, ...children) {
  const [name, ...classes] = tag.split(".");
  const made = /** @type {HTMLElementTagNameMap[Tag]} */ (document.createElement(name));
  if (name === "button") made.setAttribute("type", "button");
  return complete(made, classes, first, children);
}

/**
 * A table head: one row with a title for each column.
 *
 * @param {Child[]} titles
 * @param {(column: number) => boolean} [isNumber] whether a column holds numbers
 */
export function tableHead(titles, isNumber = () => false) {
  const cells = titles.map((title, at) => element("th", { scope: "col", class: isNumber(at) && "number" }, title));
  return element("thead", element("tr", cells));
}

/** An input field for a number. @param {Attributes} attributes */
export function numberInput(attributes) {
  return element("input.number", { inputmode: "decimal", autocomplete: "off", ...attributes });
}

/**
 * A drop-down list.
 *
 * @template {string} T
 * @param {Attributes} attributes
 * @param {string[][]} options each a value and, if it differs, its name
 * @param {T} [now] the selected value; by default, the first
 * @param {(next: T) => unknown} [take] called on a change
 */
export function choice(attributes, options, now, take) {
  const all = options.map(([value, name = value]) => element("option", { value, selected: value === now }, name));
  const list = element("select", attributes, all);
  list.addEventListener("change", () => take?.(/** @type {T} */ (list.value)));
  return list;
}

/**
 * Creates an SVG element; otherwise like {@link element}.
 *
 * @param {string} tag
 * @param {Attributes | Child | Child[]} [first]
 * @param {...(Child | Child[])} children
 */
export function svg(tag, first, ...children) {
  const [name, ...classes] = tag.split(".");
  return complete(document.createElementNS("http://www.w3.org/2000/svg", name), classes, first, children);
}

/**
 * @template {Element} Made
 * @param {Made} made
 * @param {string[]} classes
 * @param {Attributes | Child | Child[]} first
 * @param {(Child | Child[])[]} children
 */
function complete(made, classes, first, children) {
  if (classes.length > 0) made.setAttribute("class", classes.join(" "));
  if (typeof first !== "object" || first === null || first instanceof Node || Array.isArray(first))
    children.unshift(first);
  else
    for (const [name, value] of Object.entries(first)) {
      if (typeof value === "function") made.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
      else attribute(made, name, value);
    }
  append(made, children);
  return made;
}

/**
 * Sets an attribute, or removes it if the value is `false`, `null` or `undefined`.
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
 * Replaces the content of an element.
 *
 * @param {Element} within
 * @param {...(Child | Child[])} children
 */
export function fill(within, ...children) {
  within.textContent = "";
  append(within, children);
}

/**
 * Sets the text of an element only if it differs, because setting it clears the user's selection.
 *
 * @param {Element} within
 * @param {string} text
 */
export function text(within, text) {
  if (within.textContent !== text) within.textContent = text;
}

/**
 * Runs the action of a key, unless Ctrl, Alt or Meta is held.
 *
 * @param {KeyboardEvent} event
 * @param {Record<string, () => void>} actions by key
 */
export function press(event, actions) {
  const action = actions[event.key];
  if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation();
  action();
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
