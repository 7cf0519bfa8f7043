/**
 * The drawer for exports: the block's FMU with the loop's values as start values, parameter files, the run as a
 * description or CSV, a picture, and a report.
 *
 * @typedef {import("./messages").Export} Export
 */

import { shownNames } from "tool/curves.js";
import { choice, element, fill } from "tool/dom.js";
import { ask, EngineError, fromBase64, toBase64, whereIsTheEngine } from "tool/engine.js";
import { sourceOf } from "tool/files.js";
import { linkOfLoop } from "tool/link.js";
import { pngPicture, svgPicture } from "tool/picture.js";
import { programOf } from "tool/program.js";
import { replaysOf } from "tool/replay.js";
import { comparedRuns, settingsBefore } from "tool/runs.js";
import { isTried, showSaved } from "tool/saved.js";
import { units } from "tool/signals.js";
import { asLoop, store } from "tool/store.js";
import { tuning } from "tool/tune.js";
import { rezipped, unzipped } from "tool/zip.js";

/** Who can open a link: the address of a page opened as a file works only on this computer. */
const WHO_OPENS =
  location.protocol === "file:"
    ? "It works only on this computer: to share it, put the page on a server or a network share, open it there, and copy the link again."
    : "Anyone who opens it gets this loop and this run.";

/** @type {HTMLElement} */
let body;
/** @type {HTMLElement} */
let remarks;

/** @param {HTMLElement} content */
export function mount(content) {
  body = element("div");
  remarks = element("ul.remarks", { role: "status" });
  fill(content, body, remarks);
  for (const what of ["loop", "loops", "run", "home", "files"]) store.on(what, show);
  store.on("loop", () => fill(remarks));
  store.on("settings", () => showContent?.());
  show();
}

/**
 * Requests a file from the engine and downloads it.
 *
 * @param {Export} what
 */
export async function download(what, rename = (/** @type {string} */ name) => name) {
  try {
    const exported = await ask({ do: "export", ...what });
    exported.file = rename(exported.file);
    save(exported.file, new Blob([fromBase64(exported.content)], { type: exported.media_type }));
    fill(
      remarks,
      element("li.good", `${exported.file} was saved in this browser's download folder.`),
      exported.remarks.map((remark) => element("li", remark)),
    );
  } catch (error) {
    store.say(error);
  }
}

/**
 * @param {string} name
 * @param {Blob} content
 */
export function save(name, content) {
  const address = URL.createObjectURL(content);
  const link = element("a", { href: address, download: name });
  link.click();
  // The browser reads the content after this function has returned.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/**
 * Updates the preview of the files to be saved.
 *
 * @type {(() => void) | undefined}
 */
let showContent;

function show() {
  const loop = store.loop;
  if (!loop) {
    fill(body);
    showContent = undefined;
    return;
  }
  const isAlive = store.isLive();
  const format = choice({ "aria-label": "Format of the parameter file" }, store.catalogue.formats);
  const which = element(
    "select",
    { "aria-label": "Which loops" },
    element("option", { value: "one" }, loop.name),
    store.loops.length > 1 && element("option", { value: "all" }, `all ${store.loops.length} open loops`),
  );
  // Stimuli are not settings of the PLC, so they are saved only if the user includes them.
  const stimuli = element("input", { type: "checkbox" });
  const names = element("span");
  const tried = element("label", stimuli, names);
  const content = element("div.content-of-file");
  const source = sourceOf(loop);
  const ofFile = () => (source ? store.loops.filter(({ file }) => file === loop.file) : [loop]);
  const chosen = () => (which.value === "all" ? store.loops : [loop]);
  showContent = () => {
    const ofRun = Object.entries(loop.settings).filter(([, one]) => isTried(one));
    tried.hidden = ofRun.length === 0;
    names.textContent = ` also ${ofRun.map(([name]) => name).join(", ")} as in the run`;
    // Preview everything that either of the buttons saves.
    showSaved(content, [...new Set([...ofFile(), ...chosen()])], stimuli.checked);
  };
  for (const one of [which, stimuli]) one.addEventListener("change", () => showContent?.());
  const parameters = () =>
    download({
      what: "parameters",
      format: format.value,
      loops: chosen().map(asLoop),
      origin: loop.file ?? loop.description.name,
      stimuli: stimuli.checked,
    });
  const whole = async () => {
    if (!source) return;
    const bytes = toBase64(new Uint8Array(await source.arrayBuffer()));
    const loops = ofFile().map(asLoop);
    await download({ what: "source", file: { file: source.name, content: bytes }, loops, stimuli: stimuli.checked });
  };
  const curves = () => download({ what: "csv", variables: shownNames(), inputs: true });
  const everything = () =>
    download({ what: "csv", variables: [], inputs: false }, (name) => name.replace(/\.csv$/, "_all.csv"));
  const noRun = isAlive ? undefined : "Run the loop first";
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(await linkOfLoop());
      fill(remarks, element("li.good", `The link is on the clipboard. ${WHO_OPENS}`));
    } catch (error) {
      store.say(error);
    }
  };
  fill(
    body,
    // The address of a page from plcfmu tool works only on this computer.
    whereIsTheEngine() === "page" &&
      element(
        "div.row",
        element("span.what", "Link"),
        element("button", { onclick: copy }, "Copy link"),
        element("span.faint", "the loop, its settings and this run, in the address itself"),
      ),
    programOf(loop)
      ? sources(loop)
      : [
          element(
            "div.row",
            element("span.what", "Parameters"),
            which,
            format,
            element("button", { onclick: parameters }, "Save parameters"),
            tried,
          ),
          source &&
            element(
              "div.row",
              element("span.what", "File"),
              element("button.primary", { onclick: whole }, `Save ${source.name}`),
              element("span.faint", "as it was opened, with only the values changed"),
            ),
          preset(loop),
          content,
        ],
    element(
      "div.row",
      element("span.what", "This run"),
      button("Save as TOML", noRun, () => download({ what: "description" })),
      button("CSV of the curves", noRun, curves),
      button("CSV of everything", noRun, everything),
    ),
    element(
      "div.row",
      element("span.what", "Document"),
      button("Picture (SVG)", noRun, () => savePicture("svg")),
      button("Picture (PNG)", noRun, () => savePicture("png")),
      button("Report (HTML)", noRun, () => report(loop)),
    ),
  );
  showContent();
}

/**
 * @param {string} name
 * @param {string | undefined} why why it is disabled
 * @param {() => void} action
 */
function button(name, why, action) {
  return element("button", { disabled: why !== undefined, title: why, onclick: action }, name);
}

/**
 * Buttons to save the sources of a loop's program, and the command that builds an FMU from them.
 *
 * @param {import("tool/store.js").Work} loop
 */
function sources(loop) {
  const { program, compiled } = programOf(loop) ?? {};
  const files = program?.files ?? [];
  const milliseconds = Math.round((compiled?.cycle ?? 0) * 1000);
  return element(
    "div.row",
    element("span.what", "Program"),
    files.map(({ file, content }) =>
      button(`Save ${file}`, undefined, () => save(file, new Blob([fromBase64(content)], { type: "text/plain" }))),
    ),
    element("span.faint", "As an FMU:"),
    element("code", `plcfmu build ${files.map(({ file }) => file).join(" ")}`),
    element("span.faint", `with the source's start values and a cycle of ${milliseconds} ms`),
  );
}

/** @param {import("tool/store.js").Work} loop */
function preset(loop) {
  const title = element("span.what", "FMU");
  const block = loop.description.block;
  if (whereIsTheEngine() === "server") {
    const give = () => download({ what: "preset", of: asLoop(loop) });
    return element("div.row", title, button(`Save ${block} with these values as an FMU`, undefined, give));
  }
  const input = element("input.visually-hidden", { type: "file", accept: ".fmu", id: "preset-fmu" });
  /** @param {File | undefined} file */
  const take = async (file) => {
    if (file) await savePreset(loop, file);
    input.value = "";
  };
  input.addEventListener("change", () => take(input.files?.[0]));
  const label = element("label.button.drop", { for: "preset-fmu" }, `Choose or drop ${block}.fmu`);
  label.addEventListener("dragover", (event) => event.preventDefault());
  label.addEventListener("drop", (event) => {
    event.preventDefault();
    event.stopPropagation();
    take(event.dataTransfer?.files[0]);
  });
  return element(
    "div.row",
    title,
    element("span.chooser", input, label),
    element("span.faint", "Saves a copy of this FMU that starts with the settings, mode and setpoint in force"),
  );
}

/** The files of an FMU that a preset changes, and the maximum size of each in bytes. */
const OF_PRESET = ["modelDescription.xml", "documentation/index.html", "resources/start.txt"];
const LARGEST = 1 << 26;

/**
 * Saves a copy of the FMU supplied by the user, with the loop's values as start values.
 *
 * @param {import("tool/store.js").Work} loop
 * @param {File} fmu
 */
async function savePreset(loop, fmu) {
  try {
    /** @type {Record<string, string>} */
    const files = {};
    for (const path of OF_PRESET) {
      const content = await unzipped(fmu, path, LARGEST);
      if (content) files[path] = new TextDecoder().decode(content);
    }
    const preset = await ask({ do: "preset", of: asLoop(loop), files });
    const changed = new Map(Object.entries(preset.files).map(([path, text]) => [path, new TextEncoder().encode(text)]));
    /** @param {string} path */
    const isLeftOut = (path) =>
      preset.left_out.some((out) => path === out || (out.endsWith("/") && path.startsWith(out)));
    const name = `${preset.name}.fmu`;
    save(name, await rezipped(fmu, changed, isLeftOut));
    fill(
      remarks,
      element("li.good", `${name} was saved in this browser's download folder.`),
      preset.remarks.map((remark) => element("li", remark)),
    );
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    store.say(new EngineError(`${fmu.name}: ${reason}`));
  }
}

/** @param {"svg" | "png"} format */
async function savePicture(format) {
  const name = `${(store.loop?.name ?? "loop").replace(/[^A-Za-z0-9_.-]/g, "_")}.${format}`;
  const svg = format === "svg" ? await svgPicture() : undefined;
  const content = svg ? new Blob([svg], { type: "image/svg+xml" }) : await pngPicture();
  if (!content) return;
  save(name, content);
  fill(remarks, element("li.good", `${name} was saved in this browser's download folder.`));
}

/** @param {import("tool/store.js").Work} loop */
async function report(loop) {
  const runs = comparedRuns(loop);
  const before = await settingsBefore(loop, runs.length > 1 ? runs[0].run : undefined);
  const picture = (await svgPicture({ isReport: true })) ?? null;
  const date = `${new Date().toISOString().slice(0, 16).replace("T", " ")} UTC`;
  const { processValue: unit, manipulatedValue: travel_unit } = await units(loop);
  return download({
    ...{ what: "report", of: asLoop(loop), before, date, tuning: tuning(), picture },
    ...{ runs, replays: replaysOf(loop), unit: unit || null, travel_unit: travel_unit || null },
  });
}
