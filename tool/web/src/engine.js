/**
 * Sends requests to the engine: WebAssembly in the page, or the server `plcfmu tool`. Both answer the same requests.
 *
 * @typedef {import("./messages").Dialogue} Dialogue
 */

/** The error if the engine rejects a request. The message states the problem and the remedy. */
export class EngineError extends Error {
  name = "EngineError";
}

/** The error if the server does not respond. The page keeps its content. */
export class ServerLost extends EngineError {
  name = "ServerLost";
}

/** @typedef {"page" | "server"} Home */

/** @type {Home} */
let home = document.querySelector('meta[name="plcfmu-home"]')?.getAttribute("content") === "server" ? "server" : "page";

/** @type {Promise<(request: string) => string> | undefined} */
let inPage;

/** The id of this tab: on the server, each tab has its own engine. */
const tab = [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");

/** The pause before reconnecting, in milliseconds. The server keeps an engine without a connection ten times as long. */
const AGAIN = 1000;

/**
 * Settles when the last request has been answered. Each request waits for the previous one, so that the server's engine
 * receives them in order.
 */
/** @type {Promise<unknown>} */
let last = home === "server" ? stayConnected() : Promise.resolve();

/**
 * Keeps a connection to the server open. Without it, the server ends this tab's engine, so no request is sent before
 * the connection is open.
 *
 * @returns {Promise<unknown>} settles when the connection is open or has failed
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

/** Where the engine runs: in the page or on the server. */
export function whereIsTheEngine() {
  return home;
}

/** Whether the page has its own engine. */
export function hasEngineInPage() {
  return document.getElementById("engine")?.textContent !== "";
}

/** Switches to the page's own engine, which knows nothing of the state of the server's engine. */
export function goOnInThePage() {
  home = "page";
}

/** @type {string | null} */
let engineOfServer = null;
let onNewEngine = () => {};

/**
 * Sets the listener called when a new engine has replaced the old one, whose run is lost.
 *
 * @param {() => void} listener
 */
export function listenToNewEngine(listener) {
  onNewEngine = listener;
}

/**
 * Sends a request to the engine. Requests are answered in order.
 *
 * @template {keyof Dialogue} Do
 * @param {Dialogue[Do]["request"] & { do: Do }} request
 * @returns {Promise<Dialogue[Do]["answer"]>}
 * @throws {EngineError} if the engine rejects the request
 */
export function ask(request) {
  const answer = last.then(() => askNow(JSON.stringify(request)));
  last = answer.catch(() => {});
  return answer;
}

/** The error if a request is cancelled before it is answered. */
export class Stopped extends EngineError {
  name = "Stopped";
}

/**
 * Sends a request to a separate engine in a worker, so that the page stays responsive and the request can be cancelled.
 * The separate engine does not have the programs opened in the page, so a request that it rejects goes to the page's
 * engine. If the server runs the engine, it gets the request as usual, since it never blocks the page.
 *
 * @param {Dialogue["replay"]["request"] & { do: "replay" }} request independent of the current run
 * @param {AbortSignal} signal
 * @returns {Promise<Dialogue["replay"]["answer"]>}
 * @throws {Stopped} if it was cancelled
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
 * Starts a separate engine in a worker and returns its answer to the request.
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
 * The server's description of an FMU that it has read but not executed.
 *
 * @typedef {object} Uploaded
 * @property {string} name
 * @property {string} question question to the user before it runs
 * @property {string | null} problem why it cannot run here
 * @property {{ file: string, content: string } | null} parameters a parameter file with its start values, if its block
 * is in the catalogue
 */

/**
 * Uploads an FMU to the server, which reads it without running any of its code.
 *
 * @param {File} file
 * @returns {Promise<Uploaded>}
 */
export async function upload(file) {
  return content(await post(`upload?file=${encodeURIComponent(file.name)}`, "application/octet-stream", file));
}

/**
 * Allows the server to run an uploaded FMU.
 *
 * @param {string} fmu
 * @returns {Promise<import("./messages").Entry>}
 */
export async function accept(fmu) {
  const secret = document.querySelector('meta[name="plcfmu-secret"]')?.getAttribute("content");
  return content(await post("accept", "application/json", JSON.stringify({ fmu, secret })));
}

/**
 * The memory of the page's engine, in bytes; 0 if it has not been started.
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
  // A function call accepts only some ten thousand arguments.
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
 * The files passed to the command, if they differ from the version with this hash.
 *
 * @param {string} hash of the known version
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
  const lost = "plcfmu tool has stopped responding: restart it and open the new address. Nothing on this page is lost.";
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
  throw new EngineError(answer || `plcfmu tool returned status ${response.status}: try again, or restart it.`);
}

/**
 * The exports of the engine in the page.
 *
 * @typedef {object} Exported
 * @property {WebAssembly.Memory} memory
 * @property {(length: number) => number} room address for a request of this many bytes
 * @property {() => number} message processes the request and returns the length of the answer
 * @property {() => number} answer address of the answer
 */

/** @type {Exported | undefined} */
let exported;

async function open() {
  const module = await /** @type {any} */ (globalThis).compiledEngine;
  if (!module) throw new EngineError("This page has no engine; open it with plcfmu tool.");
  const instance = await WebAssembly.instantiate(/** @type {WebAssembly.Module} */ (module), {});
  const engine = /** @type {Exported} */ (/** @type {unknown} */ (instance.exports));
  exported = engine;
  /** @param {string} request */
  return (request) => {
    try {
      return message(engine, request);
    } catch (error) {
      // The engine has panicked, so its state cannot be trusted: the next request starts a new one.
      inPage = undefined;
      exported = undefined;
      queueMicrotask(onNewEngine);
      throw new EngineError(`The engine cannot continue (${error}). Please report what you did.`);
    }
  };
}

/**
 * Sends a request to an engine. A worker runs a copy of this function's source, so it must not use anything outside
 * itself.
 *
 * @param {Exported} engine
 * @param {string} request
 */
function message(engine, request) {
  const bytes = new TextEncoder().encode(request);
  const at = engine.room(bytes.length) >>> 0;
  // Get the buffer after each call: a call may grow the memory, which replaces its buffer.
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
  const length = engine.message();
  const answer = engine.answer() >>> 0;
  return new TextDecoder().decode(new Uint8Array(engine.memory.buffer, answer, length));
}
