/**
 * The state of the page, and all functions that change it. The panels display this state, call these functions, and
 * listen for changes.
 *
 * # For the panels
 *
 * - `store.loop` is the current {@link Work}, `store.loops` are all open ones. A Work has its settings by name, each
 * with the block's start value, the value in the file, the value in force (`sent`) and the value in the field
 * (`value`). A setting is *edited* while the last two differ; `store.send()` puts edited values in force, also in the
 * engine's run if it belongs to this loop. `loop.members` are the other FMUs of the loop (plant, sensor),
 * `loop.connections` are the connections between all members, and `loop.step` and `loop.exchange` determine how they
 * are stepped. All are in the form that `start` accepts; change them with `store.connect(...)`.
 * - `loop.member` is the name of the controller's member: the loop's name, reduced to plain characters. Its variables
 *   in the engine are `variable(loop, "GAIN")` = `TIC101.GAIN`.
 * - A run: `store.begin()` starts it (Setup from the loop), `store.calls(n)` makes calls, `store.repeat(...)` repeats
 *   it, `store.now(values)` sets live values immediately (setpoint, MAN, disturbances), `store.ramp(...)` ramps a
 *   value. Each resolves to the new State, which becomes `store.state`. `store.isLive()` returns whether the engine's
 *   current run belongs to the current loop. `loop.runs` are the numbers of its runs in the engine, latest last.
 * - A panel's own requests go through `ask` in engine.js; show an error with `store.say(error)` or next to its cause.
 *
 * # Events: `store.on(what, function)`, which returns a function that removes the listener
 *
 * | what | when |
 * |---|---|
 * | `catalogue` | the catalogue has been loaded or changed |
 * | `ready` | the session has been restored and given files are open |
 * | `files` | a file has been opened or closed |
 * | `loops` | the list of open loops has changed |
 * | `loop` | another loop is current, or none |
 * | `settings` | values of the current loop were edited, sent or undone; detail: the names |
 * | `applied` | edited values of the current loop are in force; detail: the names |
 * | `checked` | the engine has checked the settings of the current loop |
 * | `plant` | members, connections or settings of members have changed |
 * | `run` | a run has begun; earlier ones are in `loop.runs`; detail: its Setup |
 * | `runs` | the list of runs has changed, or the choice of those drawn |
 * | `figures` | new figures of the current run; detail: the figures with their step |
 * | `pause` | request to stop making calls |
 * | `run-to-rest` | request to run at full speed until the loop settles |
 * | `marks` | the events of the run have changed; detail: times and texts |
 * | `tab`, `open-ID` | a tab is shown; detail: its id; a drawer is opened |
 * | `state` | calls were made or values set: `store.state` is new (many times a second; draw at most once a frame) |
 * | `failure` | the run has failed: `store.state.failure` |
 * | `say` | a message to the user; detail: {@link Said} |
 * | `question` | a question to the user; detail: `{text, yes, no, act}`, where `act` is run on a yes |
 * | `home` | the engine is lost, or has been replaced |
 * | `csv` | a CSV file was dropped; detail: its Recording |
 * | `opening` | the user has selected files: errors about earlier ones are removed |
 * | `prediction` | a predicted curve has appeared or disappeared: `store.prediction`, `store.ghost` |
 * | `key-run`, `key-call`, `key-manual`, `key-left`, `key-right`, `key-home`, `key-end`, `key-zoom-in`, `key-zoom-out` | a key outside of fields |
 * | `why` | request to explain a variable's value; detail: its name |
 * | `decided` | the wires in a block's networks that decided the value; detail: `{block, wires}`, none when the explanation is closed |
 * | `show` | go to a tab or a drawer; detail: its id (`tune`, `takeaway`, `help` ...) |
 *
 * @typedef {import("./messages").Value} Value
 * @typedef {import("./messages").Values} Values
 * @typedef {import("./messages").Description} Description
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("./messages").Member} Member
 * @typedef {import("./messages").Checked} Checked
 * @typedef {import("./messages").State} State
 *
 * @typedef {object} Setting
 * @property {Variable} variable
 * @property {Value} start the block's start value
 * @property {Value | undefined} file the value in the file, if there is one
 * @property {string | undefined} origin its position in the file, `plant.awl:12:8`
 * @property {Value} sent the value in force
 * @property {Value} opened the value with which the loop was opened
 * @property {Value} value the last valid value in the field
 * @property {string | undefined} wrong invalid text in the field
 * @property {string | undefined} why what is wrong with it
 *
 * @typedef {object} Work
 * @property {number} id
 * @property {string} name its name in the file, or the name that the user chose
 * @property {string} member the name of its controller in the engine
 * @property {string | undefined} file the file from which it was opened
 * @property {string[]} warnings
 * @property {Description} description
 * @property {Record<string, Setting>} settings in the order of the table
 * @property {Checked | undefined} checked the block's check of the values in the fields
 * @property {Member[]} members the other FMUs, such as the plant
 * @property {[string, string][]} connections
 * @property {number | null} step the communication step in seconds; by default, the controller's cycle
 * @property {import("./messages").Exchange} exchange
 * @property {Record<string, any>} notes data that panels keep with a loop, by panel name; plain data
 * @property {number[]} runs
 * @property {Change[]} undo
 * @property {Change[]} redo
 *
 * @typedef {{ name: string, before: Value, after: Value, wasInForce?: boolean }[]} Change
 *
 * @typedef {object} OpenFile
 * @property {string} name
 * @property {import("./messages").Loop[]} loops
 * @property {import("./messages").Problem[]} problems
 * @property {boolean} isRefused
 *
 * @typedef {object} Said
 * @property {string} text
 * @property {boolean} isError
 *
 * @typedef {object} Prediction
 * @property {string} title
 * @property {import("./messages").Predicted} curves
 * @property {import("tool/overlay.js").Origin} origin the state from which the step starts
 */

import { ask, EngineError, ServerLost } from "tool/engine.js";
import { same } from "tool/values.js";

/** @type {Map<string, Set<(detail: any) => void>>} */
const listeners = new Map();

let lastId = 0;
/**
 * The number of the last check of each loop. Pending checks with a lower number are obsolete.
 *
 * @type {WeakMap<Work, number>}
 */
const checks = new WeakMap();
/**
 * The last Undo or Redo. Each waits for the previous one, which may have to update the run.
 *
 * @type {Promise<unknown>}
 */
let restoring = Promise.resolve();

export const store = {
  /** @type {import("./messages").Catalogue} */
  catalogue: { fmus: [], loops: [], formats: [] },
  /** @type {OpenFile[]} */
  files: [],
  /** @type {Work[]} */
  loops: [],
  /** @type {Work | undefined} */
  loop: undefined,
  /** @type {State | undefined} */
  state: undefined,
  /** The loop to which the engine's current run belongs. @type {Work | undefined} */
  live: undefined,
  /** @type {Prediction | undefined} */
  prediction: undefined,
  /**
   * The test of the current run, repeated with the values in the fields, and the state of the run at that time.
   *
   * @type {(import("./messages").Tried & { values: Values, of: State }) | undefined}
   */
  ghost: undefined,
  /** Whether the server has stopped responding. */
  isLost: false,
  /** Whether the page is making calls, not paused. */
  isRunning: false,

  /**
   * @param {string} what
   * @param {(detail: any) => void} listener
   */
  on(what, listener) {
    if (!listeners.has(what)) listeners.set(what, new Set());
    listeners.get(what)?.add(listener);
    return () => listeners.get(what)?.delete(listener);
  },

  /**
   * @param {string} what
   * @param {any} [detail]
   */
  emit(what, detail) {
    for (const listener of listeners.get(what) ?? []) listener(detail);
  },

  /**
   * Shows a message to the user.
   *
   * @param {string | Error | unknown} what
   */
  say(what) {
    if (what instanceof ServerLost) {
      // A single banner reports the loss of the server for all failed requests.
      if (store.isLost) return;
      store.isLost = true;
      store.emit("home");
      return;
    }
    const isError = what instanceof Error;
    const text = isError ? what.message : String(what);
    if (isError && !(what instanceof EngineError)) console.error(what);
    store.emit("say", { text, isError });
  },

  /** @type {Map<string, Promise<Description>>} */
  descriptions: new Map(),

  /**
   * The description of an FMU in the catalogue.
   *
   * @param {string} fmu
   * @returns {Promise<Description>}
   */
  describe(fmu) {
    let description = store.descriptions.get(fmu);
    if (!description) {
      description = ask({ do: "describe", fmu });
      description.catch(() => store.descriptions.delete(fmu));
      store.descriptions.set(fmu, description);
    }
    return description;
  },

  /**
   * Opens a loop and shows it.
   *
   * @param {string} name
   * @param {string} fmu the FMU's name in the catalogue
   * @param {import("./messages").Loop} [of] the loop as read from a file
   * @param {string} [file] the file's name
   * @returns {Promise<Work>}
   */
  async add(name, fmu, of, file) {
    const description = await store.describe(fmu);
    const given = new Map(of?.settings.filter((setting) => setting.origin !== null).map((one) => [one.name, one]));
    /** @type {Record<string, Setting>} */
    const settings = {};
    for (const variable of description.variables) {
      if (!isSettable(variable)) continue;
      const found = given.get(variable.name);
      const value = found?.value ?? variable.start;
      const origin = found?.origin ?? undefined;
      const start = { variable, start: variable.start, file: found?.value, origin };
      settings[variable.name] = { ...start, sent: value, opened: value, value, wrong: undefined, why: undefined };
    }
    lastId += 1;
    const taken = new Set(["PLANT", "SENSOR", ...store.loops.map((loop) => loop.member)]);
    /** @type {Work} */
    const loop = {
      id: lastId,
      name,
      member: plainName(name, description.block, taken),
      file,
      warnings: of?.warnings ?? [],
      description,
      settings,
      checked: undefined,
      members: [],
      connections: [],
      step: null,
      exchange: "sequential",
      notes: {},
      runs: [],
      undo: [],
      redo: [],
    };
    store.loops.push(loop);
    store.emit("loops");
    store.show(loop);
    return loop;
  },

  /**
   * Shows an open loop.
   *
   * @param {Work | undefined} loop
   */
  show(loop) {
    if (store.loop === loop) return;
    store.loop = loop;
    store.prediction = undefined;
    store.emit("loop");
    if (loop && !loop.checked) store.check();
  },

  /**
   * Closes a loop.
   *
   * @param {Work} loop
   */
  remove(loop) {
    const at = store.loops.indexOf(loop);
    store.loops.splice(at, 1);
    if (store.live === loop) store.live = store.state = undefined;
    store.emit("loops");
    if (store.loop === loop) store.show(store.loops[Math.min(at, store.loops.length - 1)]);
  },

  /**
   * Edits values of the current loop: changes them in the fields, but does not put them in force.
   *
   * @param {Values} values
   * @param {boolean} [isTyped] whether this continues the last edit: continuous typing in a field is a single edit
   */
  edit(values, isTyped = false) {
    const loop = store.loop;
    if (!loop) return;
    /** @type {Change} */
    const change = [];
    // Typing after the value was applied is a new edit.
    let isMore = isTyped;
    for (const [name, after] of Object.entries(values)) {
      const setting = loop.settings[name];
      if (!setting) continue;
      if (!isEdited(setting)) isMore = false;
      setting.wrong = setting.why = undefined;
      if (!same(setting.variable.kind, setting.value, after)) change.push({ name, before: setting.value, after });
      setting.value = after;
    }
    const last = loop.undo.at(-1);
    if (isMore && change.length === 1 && last?.length === 1 && last[0].name === change[0].name) {
      last[0].after = change[0].after;
      loop.redo = [];
    } else if (change.length > 0) {
      loop.undo.push(change);
      loop.redo = [];
    }
    store.emit("settings", Object.keys(values));
    store.check();
  },

  /**
   * Keeps invalid text in its field; the value in force is not changed.
   *
   * @param {string} name
   * @param {string} wrong
   * @param {string} why what is wrong with it
   */
  reject(name, wrong, why) {
    const setting = store.loop?.settings[name];
    if (!setting) return;
    setting.value = setting.sent;
    setting.wrong = wrong;
    setting.why = why;
    store.emit("settings", [name]);
  },

  /**
   * Discards edits: the fields return to the values in force.
   *
   * @param {string[]} names
   */
  takeBack(names) {
    const loop = store.loop;
    if (!loop) return;
    store.edit(Object.fromEntries(names.map((name) => [name, loop.settings[name].sent])));
  },

  /**
   * The names of a loop's edited settings, including those with invalid text.
   *
   * @param {Work} [loop] by default, the current one
   * @returns {string[]}
   */
  edited(loop) {
    const settings = Object.entries((loop ?? store.loop)?.settings ?? {});
    return settings.filter(([, one]) => isEdited(one)).map(([name]) => name);
  },

  /**
   * Puts edited values in force, also in the run.
   *
   * @param {string[]} [names] by default, all
   * @param {Work} [of] the loop; by default, the current one
   * @returns {Promise<boolean>} whether all values were applied
   */
  async send(names, of) {
    const loop = of ?? store.loop;
    if (!loop) return true;
    const wanted = names ?? store.edited(loop);
    await store.check(loop);
    const errors =
      loop.checked?.remarks.filter((remark) => remark.is_error).flatMap((remark) => remark.variables) ?? [];
    const good = wanted.filter((name) => loop.settings[name].wrong === undefined && !errors.includes(name));
    const isAll = good.length === wanted.length;
    // Do not send values that are already in force: the curves would mark them as changes.
    const sending = good.filter((name) => isEdited(loop.settings[name]));
    if (sending.length === 0) return isAll;
    const values = Object.fromEntries(sending.map((name) => [name, loop.settings[name].value]));
    try {
      await prepareTakeover(loop, values);
      if (store.live === loop) await store.take(ask({ do: "send", values: named(loop, values) }));
    } catch (error) {
      store.say(error);
      return false;
    }
    for (const [name, value] of Object.entries(values)) loop.settings[name].sent = value;
    store.emit("settings", loop === store.loop ? sending : []);
    store.emit("loops");
    if (loop === store.loop) store.emit("applied", sending);
    return isAll;
  },

  /** Undoes the last edit; values of it that are in force are also restored in the run. @returns {Promise<unknown>} */
  undo() {
    return store.restore("undo", "redo", "before");
  },

  /**
   * Redoes the last undone edit; values of it that were in force are put in force again.
   *
   * @returns {Promise<unknown>}
   */
  redo() {
    return store.restore("redo", "undo", "after");
  },

  /**
   * @param {"undo" | "redo"} from
   * @param {"undo" | "redo"} to
   * @param {"before" | "after"} which
   * @returns {Promise<unknown>}
   */
  restore(from, to, which) {
    restoring = restoring.then(async () => {
      const loop = store.loop;
      const change = loop?.[from].pop();
      if (!loop || !change) return;
      loop[to].push(change);
      const there = change.filter(({ name }) => loop.settings[name]);
      for (const one of there) {
        const setting = loop.settings[one.name];
        if (from === "undo") one.wasInForce = !isEdited(setting);
        setting.value = one[which];
        setting.wrong = setting.why = undefined;
      }
      store.emit(
        "settings",
        there.map(({ name }) => name),
      );
      const inForce = there.filter(({ wasInForce }) => wasInForce).map(({ name }) => name);
      if (inForce.length > 0) await store.send(inForce, loop);
      else await store.check(loop);
    });
    return restoring;
  },

  /**
   * Asks the engine to check the values in the fields.
   *
   * @param {Work} [of] the loop; by default, the current one
   * @returns {Promise<void>}
   */
  async check(of) {
    const loop = of ?? store.loop;
    if (!loop) return;
    const mine = (checks.get(loop) ?? 0) + 1;
    checks.set(loop, mine);
    try {
      const checked = await ask({ do: "check", fmu: loop.description.name, values: valuesOf(loop) });
      if (mine !== checks.get(loop)) return;
      loop.checked = checked;
      if (loop === store.loop) store.emit("checked");
    } catch (error) {
      store.say(error);
    }
  },

  /**
   * Sets the other members of the current loop, all its connections, the communication step and the exchange of values.
   * If `isGoingOn`, the run continues with the current controller, and with the step and the exchange with which it
   * began.
   *
   * @param {Pick<Work, "members" | "connections" | "step" | "exchange">} changed
   * @param {boolean} [isGoingOn]
   */
  async connect(changed, isGoingOn = false) {
    const loop = store.loop;
    if (!loop) return;
    const { step, exchange } = loop;
    Object.assign(loop, changed);
    const { members, connections } = loop;
    try {
      if (isGoingOn && store.isLive()) {
        const hadEnded = store.state?.failure;
        await store.take(ask({ do: "exchange", members, connections }));
        if (hadEnded) await store.sendLate(loop);
        if (step !== loop.step || exchange !== loop.exchange)
          store.say(
            "The run keeps its communication step and exchange; those for the new plant take effect in the next run.",
          );
      }
    } catch (error) {
      store.say(error);
    }
    store.emit("plant");
  },

  /**
   * After a failed run continues with another plant, sends the values that were set in the meantime.
   *
   * @param {Work} loop
   */
  async sendLate(loop) {
    const late = Object.entries(loop.settings).filter(([name, one]) => {
      const now = runValue(loop, name);
      return now !== undefined && !wiredTo(loop, name) && !same(one.variable.kind, one.sent, now);
    });
    if (late.length === 0) return;
    const values = Object.fromEntries(late.map(([name, one]) => [name, one.sent]));
    await store.take(ask({ do: "send", values: named(loop, values) }));
  },

  /** Whether the engine's current run belongs to the current loop. */
  isLive() {
    return store.loop !== undefined && store.live === store.loop;
  },

  /**
   * The current loop in the form that `start` accepts, with the values in force.
   *
   * @returns {import("./messages").Setup}
   */
  setup() {
    const loop = store.loop;
    if (!loop) return { members: [], connections: [], step: null, exchange: "sequential" };
    const controller = { name: loop.member, fmu: loop.description.name, values: valuesOf(loop, "sent") };
    const { connections, step, exchange } = loop;
    return { members: [controller, ...loop.members], connections, step, exchange };
  },

  /** Starts a run of the current loop with the values in force. */
  async begin() {
    const loop = store.loop;
    if (!loop) throw new EngineError("Open or create a loop first.");
    const setup = store.setup();
    let state = await ask({ do: "start", ...setup });
    // Variables remain forced until they are released, except those that the loop no longer has.
    const held = Object.fromEntries(Object.entries(loop.notes.forced ?? {}).filter(([name]) => name in state.values));
    if (Object.keys(held).length > 0) state = await ask({ do: "force", act: "force", values: held });
    store.live = loop;
    loop.runs.push(state.run);
    await store.take(Promise.resolve(state));
    store.emit("run", setup);
    return state;
  },

  /**
   * Repeats a run: bit for bit, or as the same test with the settings in force.
   *
   * @param {"same_bits" | "same_test"} what
   * @param {number} [run] by default, the current one
   */
  async repeat(what, run) {
    const loop = store.live;
    const before = Object.entries(loop?.settings ?? {}).map(([name, one]) => ({ name, one, before: one.value }));
    const state = await ask(what === "same_bits" ? { do: what, run: run ?? null } : { do: what, run, values: {} });
    loop?.runs.push(state.run);
    await store.take(Promise.resolve(state));
    // Values sent after the last call are in force, but not yet in the state.
    const { setup, events } = await ask({ do: "events" });
    for (const { call, variable: name, value, act = "set" } of events) {
      const [member, own] = split(name);
      const setting = member === loop?.member ? loop?.settings[own] : undefined;
      if (setting && act === "set" && call >= state.calls) {
        setting.sent = setting.value = value;
      }
    }
    if (loop && run !== undefined) {
      const { members, connections, step, exchange } = setup;
      Object.assign(loop, { members: members.slice(1), connections, step, exchange });
    }
    store.emit("settings", Object.keys(loop?.settings ?? {}));
    // The repeated run may have other settings: make their change undoable.
    const change = before.map(({ name, one, before }) => ({ name, before, after: one.value }));
    const moved = change.filter(
      ({ name, before, after }) => !same(loop?.settings[name].variable.kind ?? "", before, after),
    );
    if (loop && moved.length > 0) {
      loop.undo.push(moved);
      loop.redo = [];
    }
    store.emit("run", setup);
    store.emit("plant");
    return state;
  },

  /**
   * Makes calls, and starts a run if the current loop has none. Pauses after the call in which the breakpoint becomes
   * true.
   *
   * @param {number} calls
   */
  async calls(calls) {
    if (!store.isLive()) await store.begin();
    const { text, condition } = store.loop?.notes.breakpoint ?? {};
    await store.take(ask({ do: "run", calls, until: condition }));
    if (!store.state?.is_met) return;
    store.emit("pause");
    store.say(`Paused: ${text}.`);
  },

  /**
   * Makes calls until the loop has settled or oscillates steadily.
   *
   * @param {number} calls maximum number of calls
   * @param {number} from when the user started the run, in seconds
   * @returns {Promise<string>} `settled` or `swings`; empty if neither
   */
  async settle(calls, from) {
    let rests = "";
    const settled = ask({ do: "settle", calls, from }).then(({ state, is_at_rest, swings }) => {
      rests = is_at_rest ? "settled" : swings ? "swings" : "";
      return state;
    });
    await store.take(settled);
    return rests;
  },

  /**
   * Sets values immediately: in the fields, in force and in the run. Variables of the controller are given by their own
   * names, others by `MEMBER.VARIABLE`.
   *
   * @param {Values} values
   * @param {boolean} [isEvent] whether values of other members apply only to the current run, so that the next run
   * starts without them
   */
  async now(values, isEvent = false) {
    const loop = store.loop;
    if (!loop) return undefined;
    const full = named(loop, values);
    await prepareTakeover(loop, values);
    // A run that has failed accepts no values: they take effect in the next run.
    const isGoing = store.isLive() && !store.state?.failure;
    const state = isGoing ? await store.take(ask({ do: "send", values: full })) : undefined;
    /** @type {Values} */
    const own = {};
    for (const [name, value] of Object.entries(full)) {
      const [member, variable] = split(name);
      const other = loop.members.find((one) => one.name === member);
      if (other && !(isEvent && isGoing)) other.values = { ...other.values, [variable]: value };
      else if (!other && loop.settings[variable]) {
        loop.settings[variable].sent = value;
        own[variable] = value;
      }
    }
    store.edit(own);
    if (Object.keys(own).length < Object.keys(full).length) store.emit("plant");
    return state;
  },

  /**
   * Ramps a variable linearly to a value, call by call.
   *
   * @param {string} name name in the controller, or `MEMBER.VARIABLE`
   * @param {number} to
   * @param {number} seconds
   */
  async ramp(name, to, seconds) {
    const loop = store.loop;
    if (!loop) return undefined;
    if (!store.isLive()) await store.begin();
    const [variable] = Object.keys(named(loop, { [name]: to }));
    return store.take(ask({ do: "ramp", variable, to, seconds }));
  },

  /**
   * Accepts a State from the engine. Fields without edits follow the run.
   *
   * @param {Promise<State>} answer
   * @returns {Promise<State>}
   */
  async take(answer) {
    const before = store.state;
    const state = await answer;
    store.state = state;
    const moved = follow(store.live, state, before);
    if (moved.length > 0 && store.isLive()) store.emit("settings", moved);
    store.emit("state");
    for (const remark of state.remarks) store.say(remark);
    if (state.failure && state.failure !== before?.failure) store.emit("failure");
    return state;
  },

  /** @param {Prediction | undefined} prediction */
  predict(prediction) {
    store.prediction = prediction;
    store.emit("prediction");
  },
};

/**
 * Whether a user may set a variable.
 *
 * @param {Variable} variable
 */
export function isSettable(variable) {
  return variable.role !== "output" && variable.role !== "local";
}

/**
 * Makes the current values of a newly opened loop its initial values; earlier edits can no longer be undone.
 *
 * @param {Work} loop
 */
export function beginWith(loop) {
  loop.undo = [];
  for (const setting of Object.values(loop.settings)) setting.opened = setting.sent;
}

/** @param {Setting} setting */
export function isEdited(setting) {
  return setting.wrong !== undefined || !same(setting.variable.kind, setting.value, setting.sent);
}

/**
 * The origin of a setting's value.
 *
 * @param {Setting} setting
 * @param {"value" | "sent"} [which] the value in the field, or the value in force
 * @returns {"start" | "file" | "changed"}
 */
export function source(setting, which = "value") {
  const { kind } = setting.variable;
  if (setting.file !== undefined && same(kind, setting[which], setting.file)) return "file";
  return setting.file === undefined && same(kind, setting[which], setting.start) ? "start" : "changed";
}

/**
 * The settings of a loop that are in its file or differ from the block's start values, in the form that the engine
 * accepts.
 *
 * @param {Work} loop
 * @param {"value" | "sent"} which the values in the fields, or the values in force
 * @returns {Values}
 */
export function valuesOf(loop, which = "value") {
  const settings = Object.entries(loop.settings);
  const given = settings.filter(([, one]) => one.file !== undefined || !same(one.variable.kind, one[which], one.start));
  return Object.fromEntries(given.map(([name, one]) => [name, one[which]]));
}

/**
 * A loop in the form that `export` accepts.
 *
 * @param {Work} loop
 * @returns {import("./messages").Loop}
 */
export function asLoop(loop) {
  const cycle = loop.description.cycle ? loop.settings[loop.description.cycle]?.sent : undefined;
  const settings = Object.entries(loop.settings).map(([name, one]) => {
    const isStart = same(one.variable.kind, one.sent, one.start);
    const origin = one.origin ?? (isStart ? null : "the parameter tool");
    return { name, value: one.sent, origin, file: one.file ?? null };
  });
  const block = loop.description.block;
  const title = loop.notes.title ?? null;
  return {
    name: loop.name,
    title,
    block,
    cycle: typeof cycle === "number" ? cycle : null,
    settings,
    warnings: loop.warnings,
  };
}

/**
 * The engine's name of a controller's variable.
 *
 * @param {Work} loop
 * @param {string} name
 */
export function variable(loop, name) {
  return `${loop.member}.${name}`;
}

/**
 * The value of a controller's variable in the current run; `undefined` if the run belongs to another loop.
 *
 * @param {Work} loop
 * @param {string} name
 * @returns {Value | undefined}
 */
export function runValue(loop, name) {
  return store.live === loop ? store.state?.values[variable(loop, name)] : undefined;
}

/**
 * The output connected to a controller's input, such as `PLANT.T`; `undefined` if it is not connected.
 *
 * @param {Work} loop
 * @param {string} name
 */
export function wiredTo(loop, name) {
  return loop.connections.find(([, to]) => to === variable(loop, name))?.[0];
}

/**
 * @param {Work} loop
 * @param {Values} values
 * @returns {Values}
 */
function named(loop, values) {
  const members = new Set([loop.member, ...loop.members.map((member) => member.name)]);
  const full = Object.entries(values).map(([name, value]) => [
    name in loop.settings || !members.has(split(name)[0]) ? variable(loop, name) : name,
    value,
  ]);
  return Object.fromEntries(full);
}

/**
 * Splits `MEMBER.VARIABLE` at the first dot: only the variable's name may contain dots.
 *
 * @param {string} name
 * @returns {[string, string]}
 */
export function split(name) {
  const at = name.indexOf(".");
  return at < 0 ? ["", name] : [name.slice(0, at), name.slice(at + 1)];
}

/**
 * Before manual mode ends, makes one call with the values set since the last call. In manual mode, each call adapts the
 * integral action to the settings and the setpoint of that call. In a PLC, many calls are made before the operator ends
 * manual mode; in a paused run, none.
 *
 * @param {Work} loop
 * @param {Values} values values about to be set
 */
async function prepareTakeover(loop, values) {
  const { manual } = loop.description.roles;
  const calls = store.live === loop ? (store.state?.calls ?? 0) : 0;
  if (!manual || values[manual[0]] !== false || loop.settings[manual[0]]?.sent !== true || calls === 0) return;
  const { events } = await ask({ do: "events" });
  if (events.some(({ call }) => call >= calls)) await store.take(ask({ do: "run", calls: 1 }));
}

/**
 * Updates the settings that a ramp or a repeated run has changed in the run, and returns their names. A value sent
 * since the last call is kept: it is not in the state yet.
 *
 * @param {Work | undefined} loop
 * @param {State} state
 * @param {State | undefined} before
 */
function follow(loop, state, before) {
  const isSameRun = before?.run === state.run;
  const moved = [];
  for (const [name, setting] of Object.entries(loop?.settings ?? {})) {
    const now = loop && state.values[variable(loop, name)];
    // A forced value does not replace the set value.
    const isForced = loop && variable(loop, name) in state.forced;
    if (!loop || now === undefined || isForced || isEdited(setting) || wiredTo(loop, name)) continue;
    const { kind } = setting.variable;
    const last = isSameRun ? before?.values[variable(loop, name)] : undefined;
    if (same(kind, now, setting.sent) || (last !== undefined && same(kind, now, last))) continue;
    setting.sent = setting.value = now;
    moved.push(name);
  }
  return moved;
}

/**
 * A unique member name for the engine: letters, digits and underscores, beginning with a letter.
 *
 * @param {string} name
 * @param {string} block
 * @param {Set<string>} taken
 */
function plainName(name, block, taken) {
  const plain = name.replace(/[^A-Za-z0-9_]/g, "_").slice(0, 32);
  const first = /^[A-Za-z]/.test(plain) ? plain : `${block}_${plain}`.replace(/[^A-Za-z0-9_]/g, "_");
  let made = first;
  for (let number = 2; taken.has(made); number += 1) made = `${first}_${number}`;
  return made;
}
