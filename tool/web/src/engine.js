/**
 * The engine: in the page as WebAssembly, or behind `plcfmu tool`. Both answer the same requests.
 *
 * @typedef {import("./messages").Dialogue} Dialogue
 */

/** A request that the engine refused. The message is a sentence that states the problem and the remedy. */
export class EngineError extends Error {
  name = "EngineError";
}

/** The server does not answer. All that is shown stays. */
export class ServerLost extends EngineError {
  name = "ServerLost";
}

/** @typedef {"page" | "server"} Home */

/** @type {Home} */
let home = document.querySelector('meta[name="plcfmu-home"]')?.getAttribute("content") === "server" ? "server" : "page";

/** @type {Promise<(request: string) => string> | undefined} */
let inPage;

/** Each tab has its own engine. */
const tab = [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");

/** The pause before a lost connection is made again, in milliseconds. The server waits ten times as long for it. */
const AGAIN = 1000;

/** One request after the other: the server's engine must get them in the order in which they were made. */
/** @type {Promise<unknown>} */
let last = home === "server" ? stayConnected() : Promise.resolve();

/**
 * Keeps a connection to the server. With it ends the engine of this tab, so the engine is asked only after it has begun.
 *
 * @returns {Promise<unknown>} when it is open or has failed
 */
function stayConnected() {
  return new Promise((done) => {
    const socket = new WebSocket(new URL(`presence?tab=${tab}`, location.href.replace("http", "ws")));
    socket.onopen = done;
    socket.onclose = (event) => {
      done(event);
      setTimeout(() => home === "server" && stayConnected(), AGAIN);
    };
  });
}

/** Where the engine is. */
export function whereIsTheEngine() {
  return home;
}

/** Whether the page has its own engine. */
export function hasEngineInPage() {
  return document.getElementById("engine")?.textContent !== "";
}

/** From now on the engine in the page answers; it knows nothing that the server's engine knew. */
export function goOnInThePage() {
  home = "page";
}

/** @type {string | null} */
let engineOfServer = null;
let onNewEngine = () => {};

/**
 * What to do when there is a new engine, which knows nothing of what ran.
 *
 * @param {() => void} listener
 */
export function listenToNewEngine(listener) {
  onNewEngine = listener;
}

/**
 * Asks the engine. Requests are answered in the order in which they are asked.
 *
 * @template {keyof Dialogue} Do
 * @param {Dialogue[Do]["request"] & { do: Do }} request
 * @returns {Promise<Dialogue[Do]["answer"]>}
 * @throws {EngineError} what is wrong, in a sentence
 */
export function ask(request) {
  const answer = last.then(() => askNow(JSON.stringify(request)));
  last = answer.catch(() => {});
  return answer;
}

/** A question stopped before it was answered. */
export class Stopped extends EngineError {
  name = "Stopped";
}

/**
 * Asks an engine of its own in a worker, so that the page goes on meanwhile and the question can be taken back. That engine has none of
 * the blocks of the page's programs: what it refuses, the page's own is asked. The server's works beside the page anyway.
 *
 * @param {Dialogue["replay"]["request"] & { do: "replay" }} request that needs nothing of what runs
 * @param {AbortSignal} signal
 * @returns {Promise<Dialogue["replay"]["answer"]>}
 * @throws {Stopped} if it was taken back
 */
export async function askAside(request, signal) {
  const stopped = new Promise((_, reject) => {
    const stop = () => reject(new Stopped("It was stopped."));
    if (signal.aborted) stop();
    else signal.addEventListener("abort", stop, { once: true });
  });
  const module = home === "page" && (await /** @type {any} */ (globalThis).compiledEngine);
  const aside = module ? inWorker(module, JSON.stringify(request), signal) : Promise.reject();
  return Promise.race([aside.then(content).catch(() => (signal.aborted ? stopped : ask(request))), stopped]);
}

/**
 * The answer of a separate engine.
 *
 * @param {WebAssembly.Module} module
 * @param {string} request
 * @param {AbortSignal} signal
 * @returns {Promise<string>}
 */
function inWorker(module, request, signal) {
  const work = `const message = ${message};
onmessage = async ({ data }) => {
  const engine = (await WebAssembly.instantiate(data.module, {})).exports;
  postMessage(message(engine, data.request));
};`;
  return new Promise((done, failed) => {
    const script = URL.createObjectURL(new Blob([work], { type: "text/javascript" }));
    const worker = new Worker(script);
    const end = () => {
      worker.terminate();
      URL.revokeObjectURL(script);
    };
    signal.addEventListener("abort", end, { once: true });
    worker.onmessage = ({ data }) => {
      end();
      done(data);
    };
    const fail = () => {
      end();
      failed();
    };
    worker.onerror = fail;
    worker.onmessageerror = fail;
    worker.postMessage({ module, request });
  });
}

/**
 * The server's description of an FMU that it has read but not run.
 *
 * @typedef {object} Uploaded
 * @property {string} name
 * @property {string} question what to ask the user before it runs
 * @property {string | null} problem why it cannot run here
 * @property {{ file: string, content: string } | null} parameters its start values, if its block is one of the catalogue
 */

/**
 * Uploads an FMU to the server, which reads it and runs none of its code.
 *
 * @param {File} file
 * @returns {Promise<Uploaded>}
 */
export async function upload(file) {
  return content(await post(`upload?file=${encodeURIComponent(file.name)}`, "application/octet-stream", file));
}

/**
 * Lets the server run an FMU that was uploaded.
 *
 * @param {string} fmu
 * @returns {Promise<import("./messages").Entry>}
 */
export async function accept(fmu) {
  const secret = document.querySelector('meta[name="plcfmu-secret"]')?.getAttribute("content");
  return content(await post("accept", "application/json", JSON.stringify({ fmu, secret })));
}

/**
 * How many bytes of memory the engine in the page has, 0 of another.
 *
 * @returns {number}
 */
export function memory() {
  return exported?.memory.buffer.byteLength ?? 0;
}

/**
 * The unpacked content of an element.
 *
 * @param {string} id
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
export function unpacked(id) {
  return /** @type {any} */ (globalThis).unpackedElement(id);
}

/**
 * @param {string} text
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function fromBase64(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}

/**
 * @param {Uint8Array} bytes
 * @returns {string}
 */
export function toBase64(bytes) {
  const parts = [];
  // A call takes some ten thousand arguments at most.
  for (let at = 0; at < bytes.length; at += 0x6000) parts.push(String.fromCharCode(...bytes.subarray(at, at + 0x6000)));
  return btoa(parts.join(""));
}

/** @param {string} request */
async function askNow(request) {
  if (home === "server") return content(await post("message", "application/json", request));
  inPage ??= open();
  const answer = await inPage;
  return content(answer(request));
}

/** @param {string} answer */
function content(answer) {
  const read = JSON.parse(answer);
  if (read.error) throw new EngineError(read.error.message);
  return read.ok;
}

/**
 * The files that the command was given, if they differ from a version.
 *
 * @param {string} hash of the version
 * @returns {Promise<{ hash: string, files: { file: string, content: string }[] } | undefined>}
 */
export async function given(hash) {
  const answer = await post("given", "application/json", JSON.stringify({ hash }));
  return answer ? JSON.parse(answer) : undefined;
}

/**
 * @param {string} where
 * @param {string} type
 * @param {BodyInit} body
 */
async function post(where, type, body) {
  const lost = "plcfmu tool has stopped responding. Nothing on this page is lost: restart it and open the new address.";
  let response;
  try {
    response = await fetch(where, { method: "POST", headers: { "Content-Type": type, "X-Page": tab }, body });
  } catch {
    throw new ServerLost(lost);
  }
  const answer = await response.text();
  const engine = response.headers.get("X-Engine");
  if (engine !== null && engineOfServer !== null && engine !== engineOfServer) queueMicrotask(onNewEngine);
  engineOfServer = engine ?? engineOfServer;
  if (response.ok || answer.startsWith('{"error"')) return answer;
  if (response.status >= 500 || response.status === 404) throw new ServerLost(lost);
  throw new EngineError(answer || `plcfmu tool refuses with status ${response.status}.`);
}

/**
 * The exports of the engine in the page.
 *
 * @typedef {object} Exported
 * @property {WebAssembly.Memory} memory
 * @property {(length: number) => number} room where a request of this many bytes is to be written
 * @property {() => number} message how long the answer is
 * @property {() => number} answer where it is
 */

/** @type {Exported | undefined} */
let exported;

async function open() {
  const module = await /** @type {any} */ (globalThis).compiledEngine;
  if (!module) throw new EngineError("This page has no engine of its own; open it with plcfmu tool.");
  const instance = await WebAssembly.instantiate(/** @type {WebAssembly.Module} */ (module), {});
  const engine = /** @type {Exported} */ (/** @type {unknown} */ (instance.exports));
  exported = engine;
  /** @param {string} request */
  return (request) => {
    try {
      return message(engine, request);
    } catch (error) {
      // State left behind by a panic cannot be trusted.
      inPage = undefined;
      exported = undefined;
      queueMicrotask(onNewEngine);
      throw new EngineError(`The engine cannot go on (${error}). Please report what you did.`);
    }
  };
}

/**
 * Asks an engine. A worker gets the text of this function: it uses nothing around it.
 *
 * @param {Exported} engine
 * @param {string} request
 */
function message(engine, request) {
  const bytes = new TextEncoder().encode(request);
  const at = engine.room(bytes.length) >>> 0;
  // The memory may be another one after any call.
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  const length = engine.message();
  const answer = engine.answer() >>> 0;
  return new TextDecoder().decode(new Uint8Array(engine.memory.buffer, answer, length));
}
