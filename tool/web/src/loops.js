/** The opening page with its drawer (files, new loops, examples), and the table of all loops. */

import { byId, choice, element, fill, text } from "tool/dom.js";
import { EngineError } from "tool/engine.js";
import { describedBlock, openFiles, readAgain, take, underWork } from "tool/files.js";
import { cards, live, showRecorded } from "tool/first.js";
import { dropped } from "tool/folder.js";
import { onceAFrame } from "tool/frame.js";
import { forget, keptSessions } from "tool/kept.js";
import { openKnown } from "tool/known.js";
import { goOn } from "tool/session.js";
import { isEdited, source, store } from "tool/store.js";
import { rounded } from "tool/values.js";

/** A row of the table. @typedef {{ name: string, title?: string, block: string, cycle: number | null, warnings: number, file?: string, loop: import("./store.js").Work | undefined, given: import("./messages").LoopValue[], take: () => unknown }} Row */

/** A column other than name and state: its title, and for each row a sort key and the text. @typedef {{ title: string, isNumber: boolean, isWide: boolean, of: (row: Row) => [number | string, string] }} Column */

/** Rows per page of the table: few beside an open loop, many while the table has the page to itself. */
const [FEW, MANY] = [5, 25];

const MOST_PROBLEMS = 20;
/** The example that the first button opens. */
const FIRST_EXAMPLE = "furnace";

let page = 0;
let filter = "";
/**
 * The title of the column to sort by; by default, rows are in the order of their files.
 *
 * @type {{ title: string, isDown: boolean } | undefined}
 */
let sorting;
/** The roles of the blocks' variables, by block name. @type {Map<string, import("./messages").Roles>} */
const rolesOf = new Map();
let shownRows = "";
/** @type {(import("./store.js").OpenFile | boolean)[]} */
let shownFiles = [];

/** @param {HTMLElement} content */
export function mount(content) {
  mountOpening();
  const list = element("div");
  const search = element("input", {
    type: "search",
    placeholder: "Filter by name, title or block",
    "aria-label": "Filter the loops by name, title or block",
    oninput: () => {
      filter = search.value.toLowerCase();
      page = 0;
      showRows(list, search);
    },
  });
  const problems = element("div.problems");
  content.append(search, list, problems);
  const update = () => {
    byId("loops").classList.toggle("has-files", store.files.length > 0);
    document.body.classList.toggle("has-list", store.files.length > 0 || store.loops.length > 1);
    document.body.classList.toggle("is-empty", store.loops.length === 0);
    showRows(list, search);
    showProblems(problems);
  };
  for (const what of ["files", "loops", "loop"]) store.on(what, update);
  const learn = async () => {
    if (await learnRoles()) showRows(list, search);
  };
  for (const what of ["catalogue", "files", "loops"]) store.on(what, learn);
  store.on(
    "settings",
    onceAFrame(() => showRows(list, search)),
  );
  store.on("files", () => {
    // Close the drawer, which would cover the list.
    if (store.loop) byId("opening").hidden = true;
    page = 0;
  });
  update();
}

function mountOpening() {
  const opening = byId("opening");
  const input = element("input", {
    type: "file",
    id: "open-files",
    multiple: true,
    "aria-describedby": "open-kinds",
    onchange: async () => {
      const files = [...(input.files ?? [])];
      input.value = "";
      await openFiles(files);
    },
  });
  const choose = element("label.files", element("span", "Open files"), input);
  const kinds = element(
    "p.faint",
    { id: "open-kinds" },
    "Or drop them anywhere: a program (.scl, .udt); AWL, SCL, .db, Openness XML, JSON, SSV, .fmu; a recorded CSV. Nothing leaves this computer.",
  );
  const name = element("input", {
    id: "new-name",
    value: "",
    placeholder: "TIC101",
    maxlength: 128,
    spellcheck: "false",
  });
  const block = element("select", { id: "new-block" });
  const summary = element("p.faint", { id: "new-summary" });
  const make = element("button.primary", { type: "submit", disabled: true }, "New loop");
  const form = element(
    "form.new",
    {
      onsubmit: async (/** @type {Event} */ event) => {
        event.preventDefault();
        try {
          await store.add(name.value.trim() || freeName(block.value), block.value);
          name.value = "";
          store.emit("show", "plant");
        } catch (error) {
          store.say(error);
        }
      },
    },
    element("label", element("span", "Name"), name),
    element("label", element("span", "Block"), block),
    make,
  );
  const living = element("figure.living");
  showRecorded(living);
  const examples = element("div.examples");
  const show = () => {
    const controllers = store.catalogue.fmus.filter(isController);
    make.disabled = controllers.length === 0;
    fill(
      block,
      controllers.map((one) => element("option", { value: one.name }, one.name)),
    );
    showSummary();
    showExamples(examples);
  };
  const showSummary = () => text(summary, store.catalogue.fmus.find((one) => one.name === block.value)?.summary ?? "");
  block.addEventListener("change", showSummary);
  store.on("catalogue", show);
  const promise = element(
    "p.promise",
    "Your S7 controller (FB 41, FB 42, FB 43, or your own SCL), bit for bit, in the browser. Run the loop, tune it, and export the settings to STEP 7 or TIA Portal.",
  );
  const begin = element("div.begin", promise, living, choose, kinds, form, summary);
  byId("opening").querySelector(".content")?.append(begin, examples);
  // The live loop starts only after a session, if any, has been restored.
  store.on("ready", () => live(living).catch(store.say));
  store.on("loops", () => {
    if (store.loops.length === 0) opening.hidden = false;
  });
  store.on("loop", () => {
    if (!store.loop) return;
    // The user may have scrolled down on the first page.
    if (!opening.hidden) scrollTo(0, 0);
    opening.hidden = true;
  });
  mountDrop();
}

/** @param {HTMLElement} within */
function showExamples(within) {
  if (store.catalogue.loops.length === 0) return fill(within);
  fill(
    within,
    doors(),
    recent(within),
    element("h2", "Examples: click one to run it"),
    cards((known) => openKnown(known).catch(store.say)),
  );
}

/** The three buttons for getting started. */
function doors() {
  const program = element("input", {
    ...{
      type: "file",
      id: "open-program",
      class: "visually-hidden",
      multiple: true,
      accept: ".scl,.udt,.db,.xml,.s7dcl,.s7res,.xlsx,.sdf,.zip",
    },
    onchange: async () => {
      const files = [...(program.files ?? [])];
      program.value = "";
      await openFiles(files);
    },
  });
  const first = store.catalogue.loops.find(({ name }) => name === FIRST_EXAMPLE);
  const words = (/** @type {string} */ name, /** @type {string} */ about) => [
    element("strong", name),
    element("span.faint", about),
  ];
  const run = () => first && openKnown(first).catch(store.say);
  return element(
    "div.doors",
    element(
      "button.door",
      { onclick: run },
      words("Try a loop", "A furnace starts immediately: change GAIN and run it again"),
    ),
    element(
      "label.door.button",
      { for: "open-files" },
      words("Open my file", "AWL, SCL, XML, JSON, SSV, FMU, or a recorded CSV"),
    ),
    program,
    element(
      "label.door.button",
      { for: "open-program" },
      words("Run my program", "SCL, LAD, FBD, or a whole project: drop its folder or zip"),
    ),
  );
}

/** The list of the last sessions; `null` if there are none. @param {HTMLElement} within */
function recent(within) {
  const sessions = keptSessions();
  if (sessions.length === 0) return null;
  const again = (/** @type {string} */ id) => () => {
    forget(id);
    showExamples(within);
  };
  return element(
    "div.recent",
    element("h2", "Continue where you left off"),
    element(
      "ul",
      sessions.map((session) =>
        element(
          "li.row",
          element("button.plain.session", { onclick: () => goOn(session) }, session.title),
          element("span.faint", new Date(session.time).toLocaleString()),
          element("button.plain", { "aria-label": `Forget ${session.title}`, onclick: again(session.id) }, "Forget"),
        ),
      ),
    ),
    element("p.faint", "The last five sessions are kept in this browser, on this computer."),
  );
}

/** Accepts files dropped anywhere on the page. */
function mountDrop() {
  const isOfFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files") ?? false;
  document.addEventListener("dragover", (event) => {
    if (!isOfFiles(event)) return;
    event.preventDefault();
    document.body.classList.add("is-dropping");
  });
  document.addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("is-dropping");
  });
  document.addEventListener("drop", async (event) => {
    document.body.classList.remove("is-dropping");
    if (!isOfFiles(event)) return;
    event.preventDefault();
    if (event.dataTransfer) await openFiles(await dropped(event.dataTransfer));
  });
}

/**
 * Whether an FMU is offered as the controller of a new loop. A foreign FMU of unknown role is not.
 *
 * @param {import("./messages").Entry} entry
 */
function isController(entry) {
  return entry.part === "controller" || (entry.part === "other" && !entry.is_foreign);
}

/** @param {string} block */
function freeName(block) {
  const taken = new Set(store.loops.map((loop) => loop.name));
  let number = 1;
  while (taken.has(`${block}_${number}`)) number += 1;
  return `${block}_${number}`;
}

/** All loops: first those created here, then those from files. */
function allRows() {
  /** @type {Row[]} */
  const rows = [];
  const inFiles = new Set();
  for (const file of store.files) {
    for (const [at, loop] of file.loops.entries()) {
      const work = underWork(file, at);
      if (work) inFiles.add(work);
      rows.push({
        name: loop.name,
        title: loop.title ?? undefined,
        block: loop.block,
        cycle: loop.cycle,
        warnings: loop.warnings.length,
        file: file.name,
        loop: work,
        given: loop.settings,
        take: () => take(file, at),
      });
    }
  }
  const own = store.loops.filter((loop) => !inFiles.has(loop)).map((loop) => rowOf(loop));
  const all = [...own, ...rows];
  // The file is shown only where two loops have the same name.
  const count = new Map();
  for (const { name } of all) count.set(name, (count.get(name) ?? 0) + 1);
  for (const row of all) if (count.get(row.name) === 1) row.file = undefined;
  return all;
}

/**
 * @param {import("./store.js").Work} loop
 * @returns {Row}
 */
function rowOf(loop) {
  const cycle = loop.description.cycle && loop.settings[loop.description.cycle]?.sent;
  return {
    name: loop.name,
    block: loop.description.block,
    cycle: typeof cycle === "number" ? cycle : null,
    warnings: loop.warnings.length,
    loop,
    given: [],
    take: () => store.show(loop),
  };
}

/** Fetches the variable roles of the listed blocks. @returns {Promise<boolean>} whether any are new */
async function learnRoles() {
  const named = [...store.files.flatMap(({ loops }) => loops), ...store.loops.map(({ description }) => description)];
  const unknown = [...new Set(named.map(({ block }) => block))].filter((block) => !rolesOf.has(block));
  const found = await Promise.all(unknown.map((block) => describedBlock(block).catch(() => undefined)));
  for (const description of found) if (description) rolesOf.set(description.block, description.roles);
  return found.some((one) => one !== undefined);
}

/**
 * The value of a variable in a row: the value in force if the loop is open, otherwise the value in the file.
 *
 * @param {Row} row
 * @param {string | null | undefined} name
 */
function ofRow(row, name) {
  if (!name) return undefined;
  return row.loop?.settings[name]?.sent ?? row.given.find((one) => one.name === name)?.value;
}

/**
 * A column with the value of the numeric variable in a role.
 *
 * @param {string} title
 * @param {(roles: import("./messages").Roles) => string | null | undefined} role
 * @param {string} [unit]
 * @returns {Column}
 */
function numberColumn(title, role, unit = "") {
  return {
    ...{ title, isNumber: true, isWide: true },
    of: (row) => {
      const roles = rolesOf.get(row.block);
      const value = roles && ofRow(row, role(roles));
      if (typeof value !== "number") return [Number.NEGATIVE_INFINITY, ""];
      return [value, `${rounded(value, "REAL")}${unit}`];
    },
  };
}

/** @type {Column[]} */
const COLUMNS = [
  { title: "Block", isNumber: false, isWide: false, of: ({ block }) => [block, block] },
  {
    ...{ title: "Cycle", isNumber: true, isWide: false },
    of: ({ cycle }) => (cycle === null ? [Number.NEGATIVE_INFINITY, ""] : [cycle, `${rounded(cycle, "TIME")} s`]),
  },
  numberColumn("GAIN", ({ controller }) => controller[0]),
  numberColumn("TI", ({ controller }) => controller[1], " s"),
  {
    ...{ title: "Mode", isNumber: false, isWide: true },
    of: (row) => {
      const on = ofRow(row, rolesOf.get(row.block)?.manual?.[0]);
      const mode = on === undefined ? "" : on === true ? "MANUAL" : "AUTO";
      return [mode, mode];
    },
  },
  numberColumn("Setpoint", ({ setpoint }) => setpoint),
];

/** The rows in the order chosen by the user. Rows with equal values keep their order. @param {Row[]} rows */
function sorted(rows) {
  if (!sorting) return rows;
  const { title, isDown } = sorting;
  const column = COLUMNS.find((one) => one.title === title);
  const key = (/** @type {Row} */ row) => (column ? column.of(row)[0] : row.name);
  const keyed = rows.map((row) => ({ row, key: key(row) }));
  const compare = (/** @type {any} */ one, /** @type {any} */ other) =>
    typeof one === "string"
      ? one.localeCompare(other, "en", { numeric: true })
      : one < other
        ? -1
        : Number(one > other);
  keyed.sort((one, other) => compare(one.key, other.key) * (isDown ? -1 : 1));
  return keyed.map(({ row }) => row);
}

/**
 * The table head: the first click on a title sorts by its column, the second reverses the order, the third ends
 * sorting.
 *
 * @param {HTMLElement} list
 * @param {HTMLElement} search
 */
function head(list, search) {
  const cell = (/** @type {string} */ title, /** @type {string | false} */ look) => {
    const isOwn = sorting?.title === title;
    const turn = () => {
      sorting = !isOwn ? { title, isDown: false } : sorting?.isDown ? undefined : { title, isDown: true };
      page = 0;
      showRows(list, search);
    };
    const order = !isOwn ? "none" : sorting?.isDown ? "descending" : "ascending";
    const button = { class: "plain sort", "data-row": `by ${title}`, onclick: turn };
    const mark = isOwn ? (sorting?.isDown ? " ▼" : " ▲") : "";
    return element("th", { scope: "col", class: look, "aria-sort": order }, element("button", button, title, mark));
  };
  return element(
    "thead",
    element(
      "tr",
      cell("Loop", false),
      COLUMNS.map(({ title, isNumber, isWide }) =>
        cell(title, [isNumber && "number", isWide && "of-wide"].filter(Boolean).join(" ") || false),
      ),
      element("th", { scope: "col" }, element("span.visually-hidden", "State")),
    ),
  );
}

/**
 * @param {HTMLElement} list
 * @param {HTMLElement} search
 */
function showRows(list, search) {
  const focused = list.contains(document.activeElement) ? document.activeElement?.getAttribute("data-row") : null;
  const all = allRows();
  const matching = filter
    ? all.filter((row) => [row.name, row.block, row.title].some((text) => text?.toLowerCase().includes(filter)))
    : all;
  const found = sorted(matching);
  // A row with a title is taller: show fewer rows, so that the page buttons stay visible.
  const few = found.some(({ title }) => title) ? FEW - 1 : FEW;
  const rows = store.loops.length > 0 ? few : MANY;
  search.hidden = all.length <= 8;
  // Keep existing elements: an element recreated under the pointer would lose a click.
  const key = JSON.stringify([
    page,
    sorting,
    all.length,
    found.length,
    found.slice(page * rows, page * rows + rows).map(summaryOf),
  ]);
  if (key === shownRows) return;
  shownRows = key;
  const pages = Math.max(1, Math.ceil(found.length / rows));
  page = Math.min(page, pages - 1);
  const from = page * rows;
  const shown = found.slice(from, from + rows);
  fill(
    list,
    all.length > 0 &&
      element(
        "table.loops",
        head(list, search),
        element(
          "tbody",
          shown.map((row, index) => showRow(row, from + index)),
        ),
      ),
    pages > 1 &&
      element(
        "p.row.pages",
        pageButton(list, search, "Previous", -1, page > 0),
        element("span", `${from + 1} to ${from + shown.length} of ${found.length}`),
        pageButton(list, search, "Next", 1, page < pages - 1),
      ),
    all.length > 0 && found.length === 0 && element("p.faint", "No loop has this name, title or block."),
  );
  if (focused) /** @type {HTMLElement | null} */ (list.querySelector(`[data-row="${focused}"]`))?.focus();
}

/**
 * @param {HTMLElement} list
 * @param {HTMLElement} search
 * @param {string} title
 * @param {number} by
 * @param {boolean} isThere
 */
function pageButton(list, search, title, by, isThere) {
  const turn = () => {
    page += by;
    showRows(list, search);
  };
  return element("button", { "data-row": title, disabled: !isThere, onclick: turn }, title);
}

/**
 * @param {Row} row
 * @param {number} number
 */
function showRow(row, number) {
  const { state, isShown, warnings } = summaryOf(row);
  const open = async () => {
    try {
      await row.take();
    } catch (error) {
      store.say(error);
    }
  };
  const name = element(
    "button.plain.loop",
    { "data-row": number, "aria-current": isShown ? "true" : null, onclick: open },
    row.name || "(no name)",
  );
  const under = [row.file, row.title].filter(Boolean).join(": ");
  return element(
    "tr",
    { class: isShown && "is-shown" },
    element("td", name, under ? element("span.row-title.faint", { title: under }, under) : null),
    COLUMNS.map(({ isNumber, isWide, of }) =>
      element(
        "td",
        { class: [isNumber && "number", isWide && "of-wide"].filter(Boolean).join(" ") || false },
        of(row)[1],
      ),
    ),
    element(
      "td",
      {
        class: warnings ? "note" : "faint",
        title:
          warnings && `${row.warnings} ${row.warnings === 1 ? "remark" : "remarks"} from the block about its settings`,
      },
      state,
    ),
  );
}

/**
 * The data shown in a row, including its state.
 *
 * @param {Row} row
 */
function summaryOf(row) {
  const settings = Object.values(row.loop?.settings ?? {});
  const changed = settings.filter((one) => source(one, "sent") === "changed").length;
  const edited = settings.filter(isEdited).length;
  const warnings = row.warnings > 0 ? `! ${row.warnings}` : "";
  // Keep the state on one line, so that nothing below moves when a value is edited.
  const changes = edited > 0 ? `${edited} edited` : changed > 0 && `${changed} changed`;
  const state = [warnings, changes].filter(Boolean).join(", ");
  return {
    state,
    warnings,
    name: row.name,
    file: row.file,
    columns: COLUMNS.map(({ of }) => of(row)[1]),
    isShown: row.loop !== undefined && row.loop === store.loop,
  };
}

/** @param {HTMLElement} within */
function showProblems(within) {
  // Keep the elements while the files are unchanged, so that an open fold stays open.
  const now = [...store.files, store.loops.length > 0];
  if (now.length === shownFiles.length && now.every((one, at) => one === shownFiles[at])) return;
  shownFiles = now;
  fill(
    within,
    store.files.map((file) => {
      const close = () => closeFile(file);
      const count = file.loops.length === 1 ? "1 loop" : `${file.loops.length} loops`;
      return element(
        "div",
        { class: file.isRefused ? "file is-refused" : "file" },
        element(
          "p.row",
          element("span.file-name", file.name),
          element("span", { class: file.isRefused ? "error" : "faint" }, file.isRefused ? "not opened" : count),
          element("button.plain", { "aria-label": `Close ${file.name}`, onclick: close }, "Close"),
        ),
        file.problems.length > 0 && problems(file),
        file.isRefused && again(file),
      );
    }),
  );
}

/**
 * Closes a file; if its loops have changes, asks first. The user can undo this.
 *
 * @param {import("./store.js").OpenFile} file
 */
function closeFile(file) {
  const changed = file.loops.flatMap((_, at) => {
    const work = underWork(file, at);
    const settings = Object.values(work?.settings ?? {});
    const count = settings.filter((one) => isEdited(one) || source(one) === "changed").length;
    return work && count > 0 ? [`${work.name} (${count})`] : [];
  });
  const close = async () => {
    const at = store.files.indexOf(file);
    if (at < 0) return;
    store.files.splice(at, 1);
    store.emit("files");
    if (file.loops.length === 0) return;
    const reopen = async () => {
      store.files.splice(at, 0, file);
      store.emit("files");
    };
    store.emit("question", { text: `${file.name} was closed.`, yes: "Open it again", no: "Close", act: reopen });
  };
  if (changed.length === 0) close();
  else
    store.emit("question", {
      text: `${file.name} has changes that are not saved in a file: ${changed.join(", ")}. Close it anyway?`,
      ...{ yes: "Close it", no: "Keep it", act: close },
    });
}

/**
 * The list of a file's problems. Remarks on an accepted file are folded while a loop is open.
 *
 * @param {import("./store.js").OpenFile} file
 */
function problems(file) {
  const { length } = file.problems;
  const list = [
    element(
      "ul",
      file.problems.slice(0, MOST_PROBLEMS).map((one) => problem(file, one)),
    ),
    length > MOST_PROBLEMS && element("p.faint", `and ${length - MOST_PROBLEMS} more`),
  ];
  if (file.isRefused) return element("div", list);
  const title = length === 1 ? "1 remark" : `${length} remarks`;
  return element("details", { open: store.loops.length === 0 }, element("summary", title), list);
}

/**
 * @param {import("./store.js").OpenFile} file
 * @param {import("./messages").Problem} one
 */
function problem(file, one) {
  const place = one.place ? `${file.name}, line ${one.place[0]}, column ${one.place[1]}: ` : "";
  return element(
    "li",
    element("span", { class: file.isRefused ? "error" : "note" }, place + one.message),
    one.help && element("span.help", ` Help: ${one.help}`),
  );
}

/**
 * Offers to reread a file as the parameters of a block chosen by the user, since some formats do not name the block.
 *
 * @param {import("./store.js").OpenFile} file
 */
function again(file) {
  if (!file.problems.some((one) => one.asks_for_block)) return null;
  const own = store.catalogue.fmus.filter((one) => isController(one) && !one.is_foreign);
  const names = own.map(({ name }) => [name]);
  const list = choice({}, names);
  const read = async () => {
    try {
      await readAgain(file, list.value);
    } catch (error) {
      store.say(error instanceof EngineError ? error : new EngineError(String(error)));
    }
  };
  return element(
    "p.row",
    element("label", "Read it as parameters of ", list),
    element("button", { onclick: read }, "Read again"),
  );
}
