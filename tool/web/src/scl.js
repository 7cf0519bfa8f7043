/** Splits SCL into keywords, names, literals and comments, and highlights them. */

import { element } from "tool/dom.js";

const WORDS =
  /^(AND|ARRAY|AT|BEGIN|BY|CASE|CONSTANT|CONTINUE|DATA_BLOCK|DIV|DO|ELSE|ELSIF|END_[A-Z_]+|EXIT|FALSE|FOR|FUNCTION|FUNCTION_BLOCK|GOTO|IF|MOD|NOT|OF|OR|ORGANIZATION_BLOCK|REGION|REPEAT|RETAIN|RETURN|STRUCT|THEN|TITLE|TO|TRUE|TYPE|UNTIL|VAR|VAR_[A-Z_]+|VERSION|WHILE|XOR)$/i;
/** The CSS class of names of variables and blocks. */
export const NAME = "is-name";
/**
 * The parts of a line: a comment to the end of the line, the start of a block comment, quoted text, a literal or local
 * name, a word, anything else.
 */
const PARTS =
  /(\/\/.*)|(\(\*|\/\*)|('(?:\$.|[^'$])*'|"[^"]*")|(#[A-Za-z_]\w*|[A-Za-z_]\w*#[\w.+-]*|\d[\w.#]*)|([A-Za-z_]\w*)|([^A-Za-z_0-9#'"(/]+|.)/g;

/**
 * The lines of a source, each as a list of highlighted parts.
 *
 * @param {string[]} lines
 * @returns {(string | HTMLElement)[][]}
 */
export function coloured(lines) {
  return partsOf(lines).map((parts) =>
    parts.map(([text, look]) => {
      if (look === NAME) return element("span", { class: look, role: "button", tabindex: -1 }, text);
      return look ? element("span", { class: look }, text) : text;
    }),
  );
}

/**
 * The lines of a source, each split into its code and its comment, without the comment signs.
 *
 * @param {string[]} lines
 */
export function lookOf(lines) {
  return partsOf(lines).map((parts) => {
    const of = (/** @type {boolean} */ isComment) =>
      parts.flatMap(([text, look]) => ((look === "is-comment") === isComment ? [text] : [])).join("");
    return {
      code: of(false),
      comment: of(true)
        .replace(/^(\/\/|\(\*|\/\*)|(\*\)|\*\/)$/g, "")
        .trim(),
    };
  });
}

/**
 * The parts of each line, each with its CSS class or an empty string. A block comment may span several lines.
 *
 * @param {string[]} lines
 * @returns {[string, string][][]}
 */
function partsOf(lines) {
  /** The sign that ends the open block comment, if any. @type {string | undefined} */
  let end;
  return lines.map((line) => {
    /** @type {[string, string][]} */
    const parts = [];
    const put = (/** @type {string} */ text, /** @type {string} */ look = "") => {
      if (text) parts.push([text, look]);
    };
    for (let at = 0; at < line.length; ) {
      if (end !== undefined) {
        const found = line.indexOf(end, at);
        const stop = found < 0 ? line.length : found + end.length;
        put(line.slice(at, stop), "is-comment");
        if (found >= 0) end = undefined;
        at = stop;
        continue;
      }
      PARTS.lastIndex = at;
      const found = PARTS.exec(line);
      if (!found) break;
      const [text, comment, opening, quoted, literal, word] = found;
      if (opening) {
        end = opening === "(*" ? "*)" : "*/";
        continue;
      }
      at += text.length;
      if (comment) put(text, "is-comment");
      else if (quoted?.startsWith("'") || (literal && !literal.startsWith("#"))) put(text, "is-literal");
      else if (word && WORDS.test(word)) put(text, "is-word");
      else put(text, word || quoted || literal ? NAME : "");
    }
    return parts;
  });
}
