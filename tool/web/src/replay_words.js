/**
 * Puts the conclusions of a replay, which the engine returns as data, into words.
 *
 * @typedef {import("./messages").Change} Change
 * @typedef {import("./messages").Replayed} Replayed
 * @typedef {import("./messages").Since} Since
 * @typedef {import("./messages").Suspect} Suspect
 * @typedef {import("./messages").Variable} Variable
 * @typedef {import("./messages").Why} Why
 *
 * @typedef {object} Block data of the block that the text needs
 * @property {Variable[]} variables
 * @property {string[]} controller the names of its tuning settings
 * @property {string | undefined} manual the name of its switch to manual mode
 */

import { unitText } from "tool/signals.js";
import { isBoolean, isTime, rounded, shown } from "tool/values.js";

/** The maximum number of outputs listed by name. */
const MOST_OUTPUTS = 6;
/** The maximum number of explanations given. */
const MOST_EXPLANATIONS = 3;
/** The tolerance proposed for a noisy output, as a multiple of its noise: hardly any values differ by more. */
const NOISY = 6;
/** A range whose end exceeds this magnitude is open on that side. */
const OPEN = 1e300;
/** The tolerance is reported if it exceeds this fraction of an output's range. */
const COARSE = 0.01;

/** @type {Record<Exclude<Why, object>, string>} */
const WHY = {
  factor: "a round multiple or fraction of it",
  sign: "the opposite sign",
  minutes: "minutes, not seconds",
  no_minutes: "seconds, not minutes",
  seconds: "seconds, not milliseconds",
  milliseconds: "milliseconds, not seconds",
  spacing: "the spacing of the rows",
  stays: "the recording stays there",
  no_dead_band: "no dead band",
  rests: "the recording does not move within it",
};

/** @param {Why} why */
function reason(why) {
  if (typeof why !== "object") return WHY[why];
  return `the outputs change only in one of ${why.rhythm} rows`;
}

/**
 * A setting's values in the replay and in the loop, as text.
 *
 * @param {{ name: string, value: import("./messages").Value, before: import("./messages").Value }} setting
 * @param {Variable[]} variables
 */
function valuesOf({ name, value, before }, variables) {
  const kind = variables.find((one) => one.name === name)?.kind ?? "REAL";
  return [value, before].map((one) => `${shown(one, kind)}${isTime(kind) ? " s" : ""}`);
}

/** @param {Change} change @param {Variable[]} variables */
function ofChange(change, variables) {
  if ("setting" in change) {
    const { name, why } = change.setting;
    const [now, was] = valuesOf(change.setting, variables);
    return `${name} is ${now} instead of ${was}${why ? `: ${reason(why)}` : ""}`;
  }
  if ("calls" in change) return `the block is called ${change.calls} times per row`;
  const [{ line, time }, isLeftOut] =
    "left_out" in change ? /** @type {const} */ ([change.left_out, true]) : [change.added, false];
  const row = `line ${line} (${rounded(time, "LREAL")} s)`;
  return isLeftOut ? `${row} is not a call` : `there is an additional call before ${row}`;
}

/**
 * The changes of a suspect, as part of a sentence.
 *
 * @param {Suspect} suspect
 * @param {Block} block
 */
export function changed(suspect, { variables }) {
  const { changes, since, confused } = suspect;
  const all = changes.map((change) => ofChange(change, variables));
  if (since) all.push(`${ofChange(since.change, variables)} from ${rounded(since.at[1], "LREAL")} s onward`);
  const doubts = [];
  const range = rangeOf(suspect, variables);
  // The range belongs to the last change.
  const last = changes.at(-1);
  const whose = changes.length > 1 && !since && last && "setting" in last ? `${last.setting.name} ` : "";
  if (range) doubts.push(`${whose}${range} fits`);
  if (confused.length > 0) doubts.push(`a different ${confused.join(" or ")} would also fit`);
  return `${all.join(", and ")}${doubts.length > 0 ? ` (${doubts.join("; ")})` : ""}`;
}

/**
 * The range of values with which the recording fits, such as `84.8 to 94.2 s`; `undefined` if only one value fits.
 *
 * @param {Suspect} suspect
 * @param {Variable[]} variables
 */
function rangeOf({ changes, since, range }, variables) {
  if (!range) return undefined;
  const all = since ? [since.change] : changes;
  const searched = all.flatMap((change) => ("setting" in change && !change.setting.why ? change.setting.name : []));
  const kind = variables.find((one) => one.name === searched.at(-1))?.kind ?? "REAL";
  const unit = isTime(kind) ? " s" : "";
  const [low, high] = range.map((end) => rounded(end, "LREAL", 4));
  if (range[1] >= OPEN) return `${low}${unit} or more`;
  if (range[0] <= -OPEN) return `${high}${unit} or less`;
  return `${low} to ${high}${unit}`;
}

/**
 * The changes with which the recording fits: those that it contains, and those found. None if nothing fits or the
 * result is ambiguous.
 *
 * @param {Replayed} replayed
 * @returns {Change[]}
 */
export function fitting({ conclusion, settings, suspects }) {
  if (conclusion === "equal" || conclusion === "rounded") return settings;
  const isFound = conclusion === "cause" || conclusion === "likely_cause";
  const found = suspects.find(({ fits }) => fits);
  if (!isFound || !found) return [];
  const { changes, since, values } = found;
  if (!since || !("setting" in since.change)) return [...settings, ...changes];
  // Of a setting changed during the recording, the last value counts. If the loop already has it, it is not a change.
  const { setting } = since.change;
  const own = changes.flatMap((change) => ("setting" in change ? change.setting : []));
  const before = own.find(({ name }) => name === setting.name)?.before ?? setting.before;
  const others = own.filter(({ name }) => name !== setting.name);
  return [
    ...settings,
    ...[...others, { ...setting, before }].filter(({ name }) => name in values).map((one) => ({ setting: one })),
  ];
}

/**
 * Reports that a setting was changed during the recording: `Up to cycle 69 GAIN is 2; from cycle 70 (35 s) onward,
 * GAIN 0.75 explains every cycle.`, with details such as the uncertainty of time and value.
 *
 * @param {Suspect} suspect
 * @param {Since} since of the suspect
 * @param {Variable[]} variables
 * @param {boolean} isSure
 */
function ofSince(suspect, { change, at, earliest, latest }, variables, isSure) {
  if (!("setting" in change)) return { headline: "", details: [] };
  const { name } = change.setting;
  const [value, before] = valuesOf(change.setting, variables);
  const [call, time] = at;
  const details = [];
  const range = rangeOf(suspect, variables);
  const isOpen = earliest[0] < latest[0];
  const ofCall = (/** @type {[number, number]} */ [of, when]) => `${of} (${rounded(when, "LREAL")} s)`;
  if (isOpen) {
    const between = `${ofCall(earliest)} to ${ofCall(latest)}`;
    details.push(`The change could be in any cycle from ${between}${range ? `, with ${name} ${range}` : ""}.`);
  } else if (range) details.push(`${name} ${range} would fit.`);
  const { changes } = suspect;
  const own = changes.flatMap((one) => ("setting" in one ? one.setting : [])).find((one) => one.name === name);
  if (own) details.push(`The loop has ${name} ${valuesOf(own, variables)[1]}.`);
  const others = changes.filter((one) => !("setting" in one && one.setting.name === name));
  const besides = others.length > 0 ? `, with ${fit(others, { variables })} throughout` : "";
  return {
    headline: `Up to ${isOpen ? "about " : ""}cycle ${call - 1} ${name} is ${before}; from cycle ${call} (${rounded(time, "LREAL")} s) onward, ${name} ${value} ${isSure ? "" : "most likely "}explains every cycle${besides}.`,
    details,
  };
}

/**
 * Puts changes into words: `GAIN 0.7 instead of 2, and line 902 (5 s) is not a call`.
 *
 * @param {Change[]} changes
 * @param {{ variables: Variable[] }} block
 */
function fit(changes, { variables }) {
  const settings = changes.flatMap((change) => {
    if (!("setting" in change)) return [];
    const [now, was] = valuesOf(change.setting, variables);
    return `${change.setting.name} ${now} instead of ${was}`;
  });
  const others = changes.filter((change) => !("setting" in change)).map((change) => ofChange(change, variables));
  if (settings.length === 0) return `if ${others.join(", and ")}`;
  return [settings.join(" and "), ...others].filter(Boolean).join(", and ");
}

/**
 * The settings that changed in the recording and were replayed as recorded, although the loop has other values: `the
 * recording's GAIN (0.7 at first, 0.77 at the end), while 1.2 is in force`.
 *
 * @param {Replayed["moving"]} moving
 * @param {Block} block
 */
function withRecorded(moving, { variables }) {
  const told = moving.map(({ name, first, last, before }) => {
    const [begin, own] = valuesOf({ name, value: first, before }, variables);
    const [end] = valuesOf({ name, value: last, before }, variables);
    return `${name} (${begin} at first, ${end} at the end), while ${own} is in force`;
  });
  return `the recording's ${told.join(", and ")}`;
}

/**
 * The conclusion: a headline and further details.
 *
 * @param {Replayed} replayed
 * @param {number | null} tolerance the user's tolerance
 * @param {Block} block
 * @returns {{ headline: string, details: string[] }}
 */
export function verdict(replayed, tolerance, block) {
  const { outputs, calls, conclusion, settings, moving, suspects } = replayed;
  if (conclusion === "equal") {
    const names = listed(outputs.map(({ variable }) => variable));
    const most = Math.max(...outputs.map(({ largest }) => largest), 0);
    const within =
      tolerance === null ? "the resolution of the recorded digits" : `the tolerance of ${String(tolerance)}`;
    const how =
      most === 0
        ? `bit for bit in all ${calls} cycles`
        : `in all ${calls} cycles, within ${within} (up to ${rounded(most, "LREAL", 3)})`;
    const is = outputs.length === 1 ? "is" : "are";
    const coarse = coarsely(replayed, block);
    const equal = `${names} ${is} equal from the first cycle onward, ${how}.${coarse && ` ${coarse}`}`;
    const more = doubt(replayed, block);
    const isOwn = moving.length === 0;
    if (settings.length === 0 && isOwn) return { headline: equal, details: more };
    if (settings.length === 0) {
      return { headline: `${names} ${is} equal with ${withRecorded(moving, block)}.`, details: [equal, ...more] };
    }
    if (!isOwn) more.unshift(`It was replayed with ${withRecorded(moving, block)}.`);
    return { headline: `The recording fits ${fit(settings, block)}.`, details: [equal, ...more] };
  }
  const difference = ofDifference(replayed, block);
  // Mention the tolerance only if no change explains the difference.
  const coarse = suspects.some(({ fits }) => fits) ? "" : coarsely(replayed, block);
  const isRecorded = settings.length > 0;
  const recorded = isRecorded ? [`It was replayed with ${fit(settings, block)}, as recorded.`] : [];
  if (coarse) recorded.push(coarse);
  // If the recording contains other settings than the loop, that is the main point.
  const own = isRecorded ? `The recording has ${fit(settings, block)}, but even then ` : "";
  const told = suspects.filter(({ fits }) => fits).map((suspect) => changed(suspect, block));
  const [first, ...others] = told.slice(0, MOST_EXPLANATIONS);
  if (conclusion === "coarse") {
    const remedy = "Record every cycle, with rows CYCLE apart.";
    return {
      headline: "Cycles are missing between the rows: the recording does not reveal the settings.",
      details: [`With one cycle per row, ${difference}.`, remedy],
    };
  }
  if (conclusion === "rounded") {
    const same =
      "other last digits in the measured values would change as many cycles. Nothing indicates that a setting differs";
    return {
      headline: `${listed(outputs.map(({ variable }) => variable))} agree within the recorded digits.`,
      details: [`${difference}; ${same}: record more digits to see small differences.`, ...recorded],
    };
  }
  if (conclusion === "differs") return { headline: `${own}${difference}.`, details: [] };
  const alike = suspects.filter(({ fits }) => fits);
  const [likeliest] = alike;
  if (likeliest?.since && (conclusion === "cause" || conclusion === "likely_cause")) {
    const { headline, details } = ofSince(likeliest, likeliest.since, block.variables, conclusion === "cause");
    const also = others.length > 0 ? [`It could also be: ${others.join("; or: ")}.`] : [];
    return { headline, details: [...details, ...also, `With the settings of the loop, ${difference}.`, ...recorded] };
  }
  if (conclusion === "cause") {
    const details = [`${difference}; no difference remains if ${first}.`, ...recorded];
    return { headline: `The recording fits ${fit(fitting(replayed), block)}.`, details };
  }
  if (conclusion === "likely_cause") {
    const also = others.length > 0 ? [`It could also be: ${others.join("; or: ")}.`] : [];
    const details = [`${difference}; no difference remains if ${first}.`, ...also, ...recorded];
    return { headline: `The recording most likely fits ${fit(fitting(replayed), block)}.`, details };
  }
  if (conclusion === "ambiguous") {
    const each =
      others.length > 0
        ? `These changes cannot be told apart, since each explains this recording: ${[first, ...others].join("; or: ")}.`
        : `${first}.`;
    const remedy = "Record a setpoint step in automatic mode, with more digits.";
    if (likeliest?.since) {
      const names = alike.flatMap(({ since }) => (since && "setting" in since.change ? since.change.setting.name : []));
      const [call, time] = likeliest.since.at;
      return {
        headline: `From cycle ${call} (${rounded(time, "LREAL")} s) onward, a different ${names.join(" or ")} explains every cycle.`,
        details: [
          alike.length > 1
            ? `The recording does not show which: ${told.slice(0, MOST_EXPLANATIONS).join("; or: ")}.`
            : `${first}.`,
          `With the settings of the loop, ${difference}.`,
          ...recorded,
        ],
      };
    }
    return {
      headline: isRecorded
        ? `The recording has ${fit(settings, block)}, and fits more than one additional change.`
        : others.length > 0 || likeliest.confused.length > 0
          ? "The recording fits more than one change."
          : "The recording fits more than one value.",
      details: [`${difference}.`, each, remedy, ...(coarse ? [coarse] : [])],
    };
  }
  const isSaid = replayed.columns.some(([, variable]) => variable === block.manual);
  const manual = `If the controller was in manual mode for a while, record ${block.manual}, too.`;
  const off = Math.max(...outputs.map(({ noise, allowed }) => (noise > allowed ? NOISY * noise : 0)), 0);
  const noisy =
    off > 0
      ? `The recording is noisy: replay it with ${rounded(off, "LREAL", 1)} in the field “equal within”, or enter there how far a value may be off.`
      : "If the recording is noisy, enter in the field “equal within” how far a value may be off.";
  // A change is reported as close only if it removes at least half of the differences.
  const all = outputs.reduce((sum, { different }) => sum + different, 0);
  const best = suspects.find(({ different }) => 2 * different <= all);
  const still = best?.different === 1 ? "1 value still differs" : `${best?.different} values still differ`;
  const begin = Math.min(...outputs.flatMap(({ first: at }) => at?.[0] ?? []));
  const where = begin > 0 ? " and changed there: perhaps several settings" : "";
  const nearest = best
    ? `The closest match is: ${changed(best, block)} (${still}).`
    : `The cause may be something that was not recorded${where}.`;
  return {
    headline: isRecorded
      ? `${own}nothing that was tried explains it.`
      : "Nothing that was tried explains this recording.",
    details: [
      `${difference}.`,
      nearest,
      ...(coarse ? [coarse] : []),
      ...(block.manual && !isSaid ? [manual] : []),
      ...(tolerance === null ? [noisy] : []),
    ],
  };
}

/**
 * A warning if the tolerance is large compared with the movement of an output; otherwise empty.
 *
 * @param {Replayed} replayed
 * @param {Block} block
 */
function coarsely({ outputs }, { variables }) {
  const told = outputs.flatMap(({ variable, allowed, recorded }) => {
    const of = variables.find(({ name }) => name === variable);
    const known = recorded.filter((value) => Number.isFinite(value));
    // The tolerance cannot be compared with the range of a constant output.
    const span = Math.max(...known) - Math.min(...known);
    if (isBoolean(of?.kind ?? "") || !(span > 0) || allowed <= COARSE * span) return [];
    const unit = unitText(of?.unit);
    return `${rounded(allowed, "LREAL", 2)}${unit && ` ${unit}`} in ${variable}`;
  });
  return told.length > 0 ? `Differences of up to ${listed(told)} go unnoticed: they are within the tolerance.` : "";
}

/** @param {string[]} names */
function listed(names) {
  return names.length > MOST_OUTPUTS
    ? `${names.slice(0, MOST_OUTPUTS - 1).join(", ")} and ${names.length - MOST_OUTPUTS + 1} more`
    : names.join(", ");
}

/** When the outputs begin to differ, and by how much. @param {Replayed} replayed @param {Block} block */
function ofDifference({ outputs, calls }, { variables }) {
  const different = outputs.filter((one) => one.first !== null);
  const [begins] = [...different].sort((a, b) => (a.first?.[0] ?? 0) - (b.first?.[0] ?? 0));
  if (!begins) return "The outputs differ";
  const of = variables.find(({ name }) => name === begins.variable);
  const [call, time] = begins.first ?? [0, 0];
  const unit = unitText(of?.unit);
  const by = isBoolean(of?.kind ?? "")
    ? `in ${begins.different} of ${calls} cycles`
    : `by up to ${rounded(begins.largest, "LREAL")}${unit && ` ${unit}`} (${begins.different} of ${calls} cycles)`;
  const others = different.filter((one) => one !== begins).map(({ variable }) => variable);
  const too = others.length > 0 ? `, as do ${listed(others)}` : "";
  return `${begins.variable} differs from cycle ${call} (${rounded(time, "LREAL")} s) onward, ${by}${too}`;
}

/**
 * Why equal outputs prove nothing about the settings, as sentences; empty if they prove them.
 *
 * @param {Replayed} replayed
 * @param {Block} block
 */
function doubt({ doubt: why }, { controller }) {
  if (why === null) return [];
  const settings = controller.join(", ");
  if (why === "manual")
    return [
      `But all cycles are in manual mode: the recording says nothing about ${settings}. Replay a recording made in automatic mode.`,
    ];
  if ("not_recorded" in why)
    return [
      `But the recording has no ${why.not_recorded.join(" or ")}: it says nothing about ${settings}. Record that as well.`,
    ];
  const name = why.manual_in_loop;
  return [
    `But the recording has no ${name}, and in the loop ${name} is TRUE: replayed in manual mode, it says nothing about ${settings}. Set ${name} to FALSE if it was recorded in automatic mode.`,
  ];
}
