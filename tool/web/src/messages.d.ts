// Generated from tool/src/request.rs and the modules beside it by `UPDATE_EXPECT=1 cargo test -p tool typescript`.

/** Values by the variable's name. */
export type Values = Record<string, Value>;

/** How a variable is set. */
export type Act = "set" | "write" | "force" | "release";

/** A possible assumption about an undeclared name. */
export type Assumption = {
/** The name. */
name: string,
/** The assumption, in a sentence. */
what: string,
/** The place of its first use: the source, and the line in it. */
place: [string, number] | null,
/** Its declaration in SCL. */
text: string, };

/** Open loops, up to the highest frequency that the controller's calls can represent. */
export type Bode = {
/** The frequencies of the points, ascending, in radians per second. */
frequencies: Array<number>,
/** The open loops, in the order of the request. */
loops: Array<OpenLoop>, };

/** The open loops to draw. */
export type BodeRequest = {
/** The plant model. */
model: Model,
/** The controller with the settings of the first loop. */
controller: Member,
/** For each additional loop, the settings that differ from the first loop's, such as those of a rule. */
others: Array<Values>, };

/** A call to an instance. */
export type Called = {
/** The instance. */
instance: string,
/** The arguments. */
arguments: Array<Passed>, };

/** The available FMUs, loops and formats. */
export type Catalogue = {
/** The FMUs, in display order. */
fmus: Array<Entry>,
/** Loops that are known to work: examples for connections and settings. */
loops: Array<KnownLoop>,
/** The formats of parameter files that can be written: extension and title of each. */
formats: Array<[string, string]>, };

/** The event that begins a part of a run. */
export type Cause = "start" | "setpoint" | "automatic" | "disturbance";

/** A change to one of the block's settings, or to its calls. */
export type Change = { "setting": {
/** The name of the setting. */
name: string,
/** Its value in the replay that explains the recording. */
value: Value,
/** Its value in the loop or, if an earlier change applies, after that change. */
before: Value,
/** The reason for trying this value; `None` if it was searched for. */
why: Why | null, } } | { "calls": number } | { "left_out": {
/** Its line in the file. */
line: number,
/** Its time in seconds. */
time: number, } } | { "added": {
/** The line of the row in the file. */
line: number,
/** The time of the row in seconds. */
time: number, } };

/** The block whose characteristics are requested. */
export type CharacteristicRequest = {
/** The block with its settings. */
member: Member, };

/** The characteristics that the block's table describes, with these settings. */
export type Characteristics = {
/** One for each characteristic in the table that differs in the swept variable or in the outputs shown. */
sweeps: Array<Sweep>, };

/** The result of checking a block's settings. */
export type Checked = {
/** Remarks, each with the variables concerned. */
remarks: Array<Remark>,
/** The settings without effect in combination with the others, by name. */
unused: Array<string>,
/** The values as rounded by the PLC types, where they differ from those given. */
rounded: Values, };

/** A block with code. */
export type CodeBlock = {
/** The index of its source. */
file: number,
/** Its name. */
name: string,
/** Its first line (1-based). */
line: number,
/** The variables named in its lines, in source order. */
names: Array<Named>,
/** The instances it calls. */
calls: Array<Called>,
/** The writes to variables, in source order. */
writes: Array<Write>,
/** Its temporaries: name, and type as written. */
temps: Array<[string, string]>,
/** Its constants: name, and value as written. */
constants: Array<[string, string]>,
/** The declarations of its variables and constants: name, and 1-based line number. */
declared: Array<[string, number]>,
/** Its networks in LAD and FBD. */
networks: Array<Network>, };

/** An output, recorded and computed. */
export type Compared = {
/** The name of the output. */
variable: string,
/** The 0-based index of the first call that differs, with its time in seconds. */
first: [number, number] | null,
/** The number of calls in which it differs. */
different: number,
/** The largest difference between a recorded and a computed value. */
largest: number,
/** The largest deviation that counts as equal. */
allowed: number,
/**
 * The noise of the recorded or the computed values, whichever is larger: the standard deviation of the changes
 * from row to row without a trend. 0 for a switch.
 */
noise: number,
/** The times of the curves to draw, in seconds. */
times: Array<number>,
/** The recorded values at these times. */
recorded: Array<number>,
/** The values computed by the block at these times. */
computed: Array<number>, };

/** The result of a translation. */
export type Compiled = {
/** The name in the catalogue under which the program runs; `None` if it was rejected. */
fmu: string | null,
/** The block to run. */
block: string,
/** Errors if it was rejected, otherwise warnings, in the order of the sources. */
problems: Array<Finding>,
/** The blocks to choose from, if the block to run is ambiguous. */
candidates: Array<string>,
/** The time between two calls in seconds. */
cycle: number,
/** The origin of the cycle, if it was proposed from the sources; else empty. */
cycle_from: string,
/** The texts of the sources. */
sources: Array<SourceText>,
/** The blocks with code, in the order of the sources. */
blocks: Array<CodeBlock>,
/** The declarations of data blocks and tags: name, 0-based index of the source, and line. */
declared: Array<[string, number, number]>,
/** The instances of blocks. The first is the program itself, whose path is empty. */
parts: Array<Instance>,
/**
 * A table that summarizes the project's files and missing parts: name and text of each row. Empty for a single
 * source.
 */
survey: Array<[string, string]>,
/** If the program was rejected: assumptions about undeclared names under which it might be accepted. */
assumptions: Array<Assumption>, };

/** The conclusion from a recording about a block. */
export type Conclusion = "equal" | "rounded" | "differs" | "cause" | "likely_cause" | "ambiguous" | "coarse" | "unexplained";

/**
 * Curves. If they are exact, each row is a call. Otherwise, each pair of rows represents a group of calls: their times
 * are those of its first and its last call; their values are the lowest and the highest value of each variable in the
 * group, in the order in which they occur.
 */
export type Curves = {
/** The times in seconds. */
times: Array<number>,
/** The values of each variable at these times; NaN is `null`, true is 1. */
values: (number | null)[][],
/** Their units. */
units: Array<string | null>,
/** Whether every call is included. */
is_exact: boolean, };

/** The source of the recorded step. */
export type Data = { "run": {
/** The run; by default the current one. */
run?: number | null,
/** The beginning in seconds; by default shortly before the last step in the manipulated value. */
from?: number | null,
/** The end in seconds; by default the last call. */
to?: number | null, } } | { "csv": {
/** The text of the file. */
text: string,
/** The time column; by default recognized by its name. */
time?: string | null,
/** The column of the manipulated value; by default recognized by its name. */
input?: string | null,
/** The column of the process value; by default recognized by its name. */
output?: string | null,
/** The time of the first row to use, in the file's seconds. */
from?: number | null,
/** The time of the last row to use, in the file's seconds. */
to?: number | null, } };

/** The operands that decided a truth value. */
export type Decision = {
/** The value; `None` if it was not calculated in this call. */
truth: boolean | null,
/**
 * The role of each operand in the decision: `decided`, `shared` (did not decide alone), `idle` (made no
 * difference).
 */
parts: ("decided" | "shared" | "idle")[],
/** The values of the operands when the decision was calculated; `None` for an operand that is not a Boolean. */
values: Array<boolean | null>,
/** The numbers of the deciding truth values, as in `Monitored::wires`. */
wires: Array<number>, };

/** The decisions that led to an assignment. */
export type Decisions = {
/** The decision on the assigned value; `None` if it is not a truth value. */
value: Decision | null,
/** The decisions on the conditions under which the assignment is executed, in order. */
guards: Array<Decision | null>, };

/** An FMU as needed by its dialog. */
export type Description = {
/** Its name in the catalogue. */
name: string,
/** The name of its block, as used in parameter files. */
block: string,
/** A summary in one sentence. */
summary: string,
/** Other names of the block in PLC projects. */
aliases: Array<string>,
/** Its role in a loop, such as controller or plant. */
part: LoopRole,
/** The variable that holds the time between two calls; `None` for a foreign FMU. */
cycle: string | null,
/** Its variables, in the order of the table. */
variables: Array<Variable>,
/** The roles of its variables in a loop. */
roles: Roles,
/** Its settings in groups, in the order of the dialog. */
groups: Array<Group>, };

/** The reason why equal outputs prove nothing about a controller's settings. */
export type Doubt = { "not_recorded": Array<string> } | "manual" | { "manual_in_loop": string };

/** An element. */
export type Element = {
/** Its shape. */
shape: "contact" | "compare" | "coil" | "box" | "junction",
/** The sign inside it, or the title of its box. */
sign: string,
/** Its 1-based line number. */
line: number,
/** The text above it: its operand, its instance, or the label of a jump. */
above: Operand | null,
/** Its input pins, except the one drawn above it. */
inputs: Array<Input>,
/** Its output pins. */
outputs: Array<Output>, };

/** An FMU of the catalogue. */
export type Entry = {
/** Its name, used in all other requests. */
name: string,
/** A summary in one sentence. */
summary: string,
/** Its role in a loop, such as controller or plant. */
part: LoopRole,
/** Whether it is a foreign FMU: third-party native code. */
is_foreign: boolean, };

/** A variable that was set while the loop ran. */
export type Event = {
/** The 0-based index of the call before which it was set. */
call: number,
/** The time of that call, in seconds. */
time: number,
/** `MEMBER.VARIABLE` */
variable: string,
/** The value; for a release, the previous forced value. */
value: Value,
/** How it was set. */
act?: Act, };

/** The setup of a run, and its events in chronological order. */
export type Events = {
/** The setup at the start of the run. */
setup: Setup,
/** The events. */
events: Array<Event>,
/** The number of calls made by the run. */
calls: number, };

/** When values are passed from outputs to inputs. */
export type Exchange = "sequential" | "parallel";

/** The file to export. */
export type Export = { "what": "parameters",
/** The extension of the file: `awl`, `scl`, `db`, `xml`, `json`, `ssv`. */
format: string,
/** The loops with their values. */
loops: Array<Loop>,
/** The origin of the values, for a comment in the file. */
origin: string,
/**
 * Whether the file contains the current stimuli (setpoint, manual value and the like). Otherwise, stimuli have
 * the values of the file from which the loop was read, or are left out.
 */
stimuli: boolean, } | { "what": "source",
/** The file as opened. */
file: ReadFile,
/** The loops of the file with changed values. */
loops: Array<Loop>,
/** Whether the file contains the current stimuli; otherwise, they keep the values of the file. */
stimuli: boolean, } | { "what": "description",
/** The run; by default the current one. */
run?: number | null, } | { "what": "csv",
/** The run; by default the current one. */
run?: number | null,
/** The variables, by `MEMBER.VARIABLE`; by default all. */
variables: Array<string>,
/**
 * Whether the file also contains the data that a replay of the run needs: mode, setpoint and process value of
 * the controller, and all variables set or changed in the run.
 */
inputs: boolean, } | { "what": "report",
/** The loop with its values. */
of: Loop,
/** The loop's previous values, for comparison; may be empty. */
before: Array<LoopValue>,
/** The run; by default the current one. */
run?: number | null,
/** A picture of the curves, an `<svg>` or a `data:` URL of a PNG; by default drawn by the engine. */
picture?: string | null,
/** The date of the report, as displayed. */
date?: string | null,
/** How the settings were computed, if a rule was applied. */
tuning?: Tuning | null,
/** The runs to compare, all with the same step, the earliest first. */
runs: Array<ReportedRun>,
/** The replays of a recording, in order. */
replays: Array<ReportedReplay>,
/** The unit of the process value, if its variable has none. */
unit?: string | null,
/** The unit of the manipulated value, if its variable has none. */
travel_unit?: string | null, } | { "what": "preset",
/** The loop with its values. */
of: Loop, };

/** An exported file. */
export type Exported = {
/** Its name. */
file: string,
/** Its media type. */
media_type: string,
/** Its bytes, Base64. */
content: string,
/** Remarks for the user, a sentence each. */
remarks: Array<string>, };

/** A setting of a group. */
export type Field = {
/** The variable. */
name: string,
/**
 * The condition under which it has an effect, as pairs `(name, wanted)`: each inner list is joined by AND, the
 * lists by OR; always if empty.
 */
used_if: Array<Array<[string, boolean]>>, };

/** A figure of a run. */
export type Figure = {
/** Its name, such as `settling`. */
key: string,
/** Its title, such as `Settling time`. */
title: string,
/** A short description. */
meaning: string,
/** Its value; `None` if it is missing for the reason given in the remarks. */
value: number | null,
/** Its unit. */
unit: string | null, };

/** The figures that can be computed from a run's signals. */
export type Figures = {
/** The beginning of their window, in seconds. */
from: number,
/** The end of their window, in seconds. */
to: number,
/** The step to which they belong: two runs with the same step over the same time can be compared. */
step: Happened | null,
/** The disturbance to which the disturbance figures belong. */
disturbance: Happened | null,
/** The figures, in display order. */
figures: Array<Figure>,
/** Which figures are missing, and why. */
remarks: Array<string>, };

/** A run, and the part of it to evaluate. */
export type FiguresRequest = {
/** The run; by default the current one. */
run?: number | null,
/** The beginning in seconds; by default that of the last step. */
from?: number | null,
/**
 * The end in seconds; by default that of the last step's window if no beginning is given either, else the last
 * call.
 */
to?: number | null,
/** The unit of the process value, if its variable has none. */
unit?: string | null,
/** The unit of the manipulated value, if its variable has none. */
travel_unit?: string | null, };

/** A message about a place in a source. */
export type Finding = {
/** The source's name; empty if the message concerns all sources. */
file: string,
/** The 1-based line and column, if the message concerns a place in the source. */
place: [number, number] | null,
/** The number of characters concerned in that line. */
length: number,
/** The problem. */
message: string,
/** The remedy. */
help: string | null,
/** Whether it is an error, which prevents the program from running. */
is_error: boolean, };

/** A step as predicted by the identified plant. */
export type Forecasted = {
/** The controller's settings in force that have an effect, as a list. */
settings: string,
/** Its figures by key, for the same step and the same time as the run's figures. */
figures: { [key in string]: number },
/** Whether the run agrees with the prediction, in a sentence or two. */
verdict: string, };

/** The source of an input pin: an operand, the output pin of another element or, if neither, the power rail. */
export type From = {
/** The variable or the constant. */
operand: Operand | null,
/** The index of the element. */
element: number | null,
/** The name of its output pin. */
pin: string, };

/** Settings that belong together. */
export type Group = {
/** Its title. */
title: string,
/** Its settings, in order. */
fields: Array<Field>, };

/** A condition under which statements run. */
export type Guard = {
/** The kind of statement that the condition belongs to. */
of: "if" | "case" | "while" | "until",
/** Its 1-based line number. */
line: number,
/** Its text. */
text: string,
/** Whether the guarded statements run if it is FALSE. */
is_negated: boolean,
/** The variables it names. */
reads: Array<Named>, };

/** The event that begins a window. */
export type Happened = {
/** Its cause. */
cause: Cause,
/** The process value in its first call. */
from: number,
/** The setpoint in its last call. */
to: number,
/** When it began, in seconds. */
start: number,
/** The length of its window, in seconds. */
duration: number,
/**
 * Half the width of the band around the setpoint in which the process value counts as settled or recovered, in the
 * unit of the process value; absent for a disturbance with no step before it.
 */
band: number | null,
/** The variables that disturbed the loop, each with its last value. */
by: Array<Set>, };

/** A model and the quality of its fit. */
export type Identified = {
/** The identified model. */
model: Model,
/** The quality of the fit: 100 (1 - NRMSE) in percent. */
fit: number,
/** The times of a chart of the measured and the modelled response, in seconds. */
times: Array<number>,
/** The measured process value at these times. */
measured: Array<number>,
/** The model's process value at these times. */
modelled: Array<number>,
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** The data from which to identify a plant, and the method. */
export type IdentifyRequest = {
/** The recorded step. */
data: Data,
/** The identification method. */
method: Method,
/** Whether the plant is integrating. */
is_integrating: boolean, };

/** An input pin. */
export type Input = {
/** Its name in upper case. */
pin: string,
/** Whether its value is negated. */
is_negated: boolean,
/** Its sources, combined by OR. */
sources: Array<From>, };

/** An instance of a block. */
export type Instance = {
/** Its path in the FMU's variable names, such as `motors[1]`; empty for the program itself. */
path: string,
/** Its block. */
block: string,
/** Whether the block is a catalogue block rather than SCL code. */
is_native: boolean, };

/** A loop that is known to work. */
export type KnownLoop = {
/** The name of its description, such as `furnace`. */
name: string,
/** Its title. */
title: string,
/** What is special about it, in a sentence; may be empty. */
about: string,
/** Its members and connections. */
setup: Setup,
/** The duration of the run in its description, in seconds. */
stop: number | null,
/** The settings made during the run: the time in seconds, `MEMBER.VARIABLE`, and the value. */
events: Array<[number, string, Value]>,
/** The members that are programs: their FMUs must be built from their sources. */
programs: Array<MadeOf>, };

/** The loop after a load step at the plant's input. */
export type Load = {
/**
 * The load at the plant's input, in percent of the manipulated value, with the sign that leaves the manipulated
 * value more room to compensate for it.
 */
size: number,
/** The largest deviation from the setpoint, in the setpoint's unit. */
deviation: number,
/** The time in seconds from the load until the deviation stays within the band; `None` if it does not. */
recovery: number | null,
/**
 * The integral of the absolute error, in the unit of the setpoint times seconds; absent if the loop does not
 * recover.
 */
iae: number | null,
/** Half the width of the band around the setpoint in which the loop counts as recovered, in the setpoint's unit. */
band: number, };

/** A loop of a file. */
export type Loop = {
/** Its name. */
name: string,
/** Its title in the file. */
title: string | null,
/** The name of its block in the catalogue. */
block: string,
/** The time between two calls, in seconds. */
cycle: number | null,
/** Its values. */
settings: Array<LoopValue>,
/** Warnings about unexpected effects of the settings and about values out of range. */
warnings: Array<string>, };

/** The role of an FMU in a loop. */
export type LoopRole = "controller" | "plant" | "other";

/** A value of a loop. */
export type LoopValue = {
/** The variable. */
name: string,
/** Its value. */
value: Value,
/** The origin of the value, such as `plant.awl:12:8`; `None` for the block's start value. */
origin: string | null,
/** The value in the file from which the loop was read, if the current value differs. */
file: Value | null, };

/** The loops of a file. */
export type Loops = {
/** The loops, in the order of the file; empty if the file is faulty. */
loops: Array<Loop>,
/** The problems, or remarks for the user if the file can be used. */
problems: Array<Problem>,
/** Whether the file could not be used. */
is_refused: boolean, };

/** A member that is a PLC program. */
export type MadeOf = {
/** The member's name. */
member: string,
/** The names of its sources, without folders. */
sources: Array<string>,
/** How it is built from them; its list of files is empty. */
program: Program, };

/** An FMU in a loop. */
export type Member = {
/** Its name in the loop. */
name: string,
/** The name of its FMU, as in [`Fmus`]. */
fmu: string,
/** Its settings; other variables have their start values. */
values: Values, };

/** The method of identification. */
export type Method = "tangent" | "two_points" | "area" | "least_squares";

/**
 * A plant: a lag with dead time, or an integrator with dead time.
 *
 * The gain is measured from the controller's output to the process value that the controller compares with the
 * setpoint. A model identified from a loop's signals has this gain: it includes the factor that the block applies to
 * the process value (PV_FAC), but not the one that the block applies to the manipulated value (LMN_FAC);
 * [`tune`](crate::tune) takes the latter into account.
 */
export type Model = {
/** K in units of the process value per unit of the manipulated value; per second for an integrating plant. */
gain: number,
/** T in seconds; 0 for an integrating plant. */
time_constant: number,
/** The time constant of a second lag in seconds; 0 if there is none. */
second_time_constant: number,
/** L in seconds. */
dead_time: number,
/** Whether the plant is integrating. */
is_integrating: boolean, };

/** The activity of a program in a call, apart from the values of its variables, which belong to the state of the run. */
export type Monitored = {
/** The program's temporary variables at the end of the call. */
temps: Values,
/** Its STRINGs and WSTRINGs at the end of the call, which a run cannot record. */
texts: { [key in string]: string },
/** The executed lines, each with the 0-based index of its source. */
lines: Array<[number, number]>,
/** The program's warnings since its start, each with file and line. */
warnings: Array<string>,
/**
 * The truth values in the networks of the requested block, by number. Values that were not calculated in the call
 * are missing.
 */
wires: Array<[number, boolean]>,
/** For each block whose decisions were requested: the decisions for each of its writes. */
decided: Array<Array<Decisions>>, };

/** A setting that changes during a recording: the comparison uses the recorded values instead of the loop's. */
export type Moving = {
/** The name of the setting. */
name: string,
/** Its first value in the recording. */
first: Value,
/** Its last value in the recording. */
last: Value,
/** Its value in the loop. */
before: Value, };

/** A variable named in a line. */
export type Named = {
/** The 1-based line number. */
line: number,
/** The variable, as the FMU names it; an index may be the path of another variable. */
path: string,
/** Whether it is global, as in `"DB".x`. A name with neither quotation marks nor `#` may be either. */
is_global: boolean, };

/** A network. */
export type Network = {
/** Its number within the block, counted from 1. */
number: number,
/** Its title, possibly empty. */
title: string,
/** Its comment, possibly empty. */
comment: string,
/** Its first line number (1-based). */
line: number,
/** The labels at its beginning. */
labels: Array<string>,
/** Whether it has a power rail, as in LAD. */
has_rail: boolean,
/** Its elements; inputs refer to them by index. */
elements: Array<Element>, };

/** An input that needs a connection. */
export type Open = {
/** The input, `MEMBER.VARIABLE`. */
input: string,
/** The problem, in a sentence. */
text: string, };

/** An open loop with its margins. Infinite margins are absent. */
export type OpenLoop = {
/** The amplitude at each frequency, in dB. */
amplitude: Array<number>,
/** The phase at each frequency, in degrees. */
phase: Array<number>,
/** Ms, the largest sensitivity; absent if the loop is unstable. */
sensitivity: number | null,
/** The gain margin, as a factor. */
gain_margin: number | null,
/** The phase margin, in degrees. */
phase_margin: number | null,
/** The frequency at which the gain margin is read, in radians per second. */
phase_crossover: number | null,
/** The frequency at which the phase margin is read, in radians per second. */
gain_crossover: number | null, };

/** A variable, a constant or a label. */
export type Operand = {
/** The text as written. */
text: string,
/** The path of the variable; `None` for anything else. */
path: string | null,
/** Whether it is a global variable. */
is_global: boolean,
/** The number under which its value is recorded, if it is read as a truth value. */
wire: number | null, };

/** An output pin. */
export type Output = {
/** Its name in upper case. */
pin: string,
/** Whether its value is negated. */
is_negated: boolean,
/** The variables it writes. */
targets: Array<Operand>,
/** The number under which its value is recorded; `None` if it is unconnected or carries the power rail. */
wire: number | null,
/** Whether it carries the power rail's value. */
is_rail: boolean, };

/** An argument of a call. */
export type Passed = {
/** The formal parameter. */
formal: string,
/** The variable passed; `None` for a computed value. */
path: string | null,
/** The 1-based line number. */
line: number, };

/** The simulated response of a loop to a setpoint step and to a load. */
export type Predicted = {
/** The times of the points in seconds. */
times: Array<number>,
/** The setpoint at these times. */
setpoint: Array<number>,
/** The process value at these times. */
process_value: Array<number>,
/** The manipulated value at these times. */
manipulated_value: Array<number>,
/** The overshoot of the process value in percent of the step. */
overshoot: number | null,
/** The settling time of the process value in seconds. */
settling: number | null,
/** The total travel of the manipulated value after the step, in its unit. */
travel: number | null,
/**
 * The effect of a disturbance: a load of 10 % of the manipulated value at the plant's input, from the same steady
 * state.
 */
load: Load | null, };

/** The files of a preset that replace the original's. */
export type Preset = {
/** Its name, which is an identifier. */
name: string,
/** Its GUID. */
guid: string,
/** The new and the changed files, by path. */
files: { [key in string]: string },
/** The paths of the omitted files. A folder ends with `/`. */
left_out: Array<string>,
/** Remarks for the user, a sentence each. */
remarks: Array<string>, };

/** A request for a preset of an FMU opened by the page. */
export type PresetRequest = {
/** The loop with its values. */
of: Loop,
/** The FMU's `modelDescription.xml`, `documentation/index.html` and `resources/start.txt`, where they exist. */
files: { [key in string]: string }, };

/** A problem in a file, or a remark on it. */
export type Problem = {
/** The 1-based line and column, if the problem concerns a place in the file. */
place: [number, number] | null,
/** The problem. */
message: string,
/** The remedy. */
help: string | null,
/** Whether to offer the user a choice of the block whose parameters the file contains. */
asks_for_block: boolean, };

/**
 * The sources of a program, and how it is built from them. The defaults are those of `plcfmu build`, except that the
 * cycle is proposed from the sources.
 */
export type Program = {
/** The sources. */
files: Array<SourceFile>,
/** The name of the FMU, a C identifier; by default the name of the block. */
name?: string | null,
/**
 * The time between two calls in milliseconds, at least 1: a number of seconds in a message, a string with a unit
 * in a file. Required for an FMU.
 */
cycle?: number | null,
/** The block to run, or its instance data block; by default the block that no other block uses. */
run?: string | null,
/** The CPU, `300`, `1200` or `1500`; by default the one implied by the sources' dialect. */
cpu?: string | null,
/** The maximum number of statements per call; one million by default. */
budget?: number | null,
/** Inputs to expose as tunable parameters. */
parameters: Array<string>,
/** Parameters and locals to expose as inputs. */
inputs: Array<string>,
/** Locals to expose as outputs. */
outputs: Array<string>,
/** Names that no source declares, and their types: PLC tags and instances. The first entry for a name wins. */
tags: Array<[string, string]>,
/** Constants that no source declares, and their values as literals. */
constants: Array<[string, string]>, };

/** How to connect a controller and a plant. */
export type Proposal = {
/** The proposed connections. */
connections: Array<Wire>,
/** All other possible connections. */
others: Array<Wire>,
/** Settings for the proposed connections, by `MEMBER.VARIABLE`. */
values: Values,
/** The communication step for the proposed connections, in seconds; by default the controller's cycle. */
step: number | null,
/** When values pass from output to input, as in the known loop on which the proposal is based. */
exchange: Exchange,
/** Unconnected inputs that need a connection. */
open: Array<Open>,
/** Other remarks for the user, a sentence each. */
remarks: Array<string>, };

/** The compensation of a three-step pulse former for heating and cooling of different strength. */
export type Ratio = {
/** The value for RATIOFAC. */
ratio: number,
/** The model for tuning the controller: the one with the smaller gain, but with the longer of the two dead times. */
model: Model,
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** A heating and a cooling step. */
export type RatioRequest = {
/** The plant with the manipulated value above 0. */
heating: Model,
/** The plant with the manipulated value below 0. */
cooling: Model, };

/** A parameter file to read. */
export type ReadFile = {
/** Its name, whose extension selects the format. */
file: string,
/** Its bytes, Base64. */
content: string,
/** The block, if the file does not specify it. */
block?: string | null,
/** The loop's name, if the file does not specify it. */
name?: string | null, };

/** A test with a relay in place of the controller. */
export type RelayTest = {
/** The amplitude of the manipulated value, in its unit. */
amplitude: number,
/** The deviation of the process value at which the relay switches; by default derived from the noise. */
hysteresis?: number | null, };

/** The result of a relay test. */
export type RelayTested = {
/** The state of the run after the test, with the previous mode, manual value and setpoint. */
state: State,
/** When the hold of the plant began, in seconds. */
from: number,
/** Ultimate gain, and ultimate period in seconds: the inputs of the Ziegler–Nichols rule. */
ultimate: [number, number],
/** The amplitude of the process value while the relay switches, in its unit. */
swing: number,
/** The deviation of the process value at which the relay switched, in its unit. */
hysteresis: number,
/**
 * An integrator with dead time that has this ultimate gain and period: a relay identifies a plant at only one
 * frequency.
 */
model: Model,
/** Remarks for the user, a sentence each. */
remarks: Array<string>, };

/** A sentence about settings. */
export type Remark = {
/** The variables concerned. */
variables: Array<string>,
/** The sentence. */
text: string,
/** Whether the FMU will reject the value. */
is_error: boolean, };

/** The recording to replay, and the block. */
export type ReplayRequest = {
/** The block with its settings in the loop. */
controller: Member,
/** The text of the CSV file. */
text: string,
/** The assignment of columns to variables of the block, or to `time`. By default, columns are matched by name. */
columns: Array<[string, string]>,
/** The deviation up to which a value counts as equal; by default, it depends on the digits in the recording. */
tolerance?: number | null,
/** Whether to search for the cause if the outputs differ. */
try_suspects: boolean, };

/** The result of a replay. */
export type Replayed = {
/** The assignment of columns to variables of the block. */
columns: Array<[string, string]>,
/** The number of calls made. */
calls: number,
/** One for each output in the file. */
outputs: Array<Compared>,
/** The settings whose recorded values differ from the loop's: the recorded ones were used. */
settings: Array<Change>,
/**
 * The settings that change during the recording and end with a value other than the loop's: the recorded values
 * were used.
 */
moving: Array<Moving>,
/** The explanations that reduce the differences, best first. */
suspects: Array<Suspect>,
/** The conclusion. */
conclusion: Conclusion,
/**
 * The reason why equal outputs prove nothing about the controller's settings; `None` if the recording depends on
 * them.
 */
doubt: Doubt | null,
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** A replay of a recording through the block. */
export type ReportedReplay = {
/** The recording's file. */
file: string,
/** The controller's settings used for the replay. */
values: Values,
/** The conclusion, in a sentence. */
verdict: string,
/** Remarks on the conclusion, a sentence each. */
remarks: Array<string>,
/** The settings in which the recording differed from the loop. */
settings: Array<Change>, };

/** A run compared with others. */
export type ReportedRun = {
/** The 0-based number of the run. */
run: number,
/** The user's name for it. */
name: string,
/** Its settings at its end, where they differ between the compared runs. */
values: Values,
/** Its settings at its beginning, where they changed during the run. */
begun: Values, };

/** A request of the page. */
export type Request = { "do": "catalogue" } | { "do": "describe",
/** The FMU's name in the catalogue. */
fmu: string, } | { "do": "read" } & ReadFile | { "do": "described",
/** The file name, for messages. */
file: string,
/** The text of the file. */
text: string, } | { "do": "compile" } & Program | { "do": "monitor",
/** Its name in the loop. */
member: string,
/** The 0-based index of the call; by default the last call. For an earlier call, the run is repeated up to it. */
call?: number | null,
/** The block whose networks are displayed, and the path of its instance, which is empty for a function. */
networks?: [string, string] | null,
/** The blocks whose decisions are requested, each with the path of its instance. */
why?: Array<[string, string]> | null, } | { "do": "check",
/** The FMU's name in the catalogue. */
fmu: string,
/** Its settings; the others have their start values. */
values: Values, } | { "do": "propose",
/** The controller. */
controller: Member,
/** The plant to connect to it. */
plant: Member, } | { "do": "start" } & Setup | { "do": "state" } | { "do": "send",
/** The values, by `MEMBER.VARIABLE`. */
values: Values, } | { "do": "force",
/** `write`, `force` or `release`. For `set`, use [`Request::Send`]. */
act: Act,
/** The values, by `MEMBER.VARIABLE`; ignored for a release. */
values: Values, } | { "do": "ramp",
/** `MEMBER.VARIABLE` */
variable: string,
/** The last value. */
to: number,
/** The duration, in seconds. */
seconds: number, } | { "do": "run",
/** The maximum number of calls, at least one. */
calls: number,
/** A condition; the call in which it becomes true is the last. */
until?: Until | null, } | { "do": "settle" } & Settle | { "do": "rest_at" } & RestAt | { "do": "exchange",
/** The new members. */
members: Array<Member>,
/** All connections. */
connections: Array<[string, string]>, } | { "do": "view" } & View | { "do": "events",
/** The run; by default the current one. */
run?: number | null, } | { "do": "same_bits",
/** The run to repeat; by default the current one. */
run?: number | null, } | { "do": "same_test",
/** The run whose test is repeated; by default the current one. */
run?: number | null,
/**
 * The new settings, by `MEMBER.VARIABLE`; all others have their value at the end of that run. Stimuli are
 * ignored.
 */
values: Values, } | { "do": "try",
/** The settings, by `MEMBER.VARIABLE`; stimuli are ignored. */
values: Values,
/** The curves to draw; its `run` is ignored. */
view: View,
/** The window and units of the figures; its `run` is ignored. */
figures: FiguresRequest, } | { "do": "figures" } & FiguresRequest | { "do": "forecast",
/** The run; by default the current one. */
run?: number | null,
/** The plant to connect to it. */
tuning: Tuning, } | { "do": "identify" } & IdentifyRequest | { "do": "tune" } & TuneRequest | { "do": "rules" } & TuneRequest | { "do": "in_force" } & TuneRequest | { "do": "bode" } & BodeRequest | { "do": "step_test" } & StepTest | { "do": "relay_test" } & RelayTest | { "do": "ratio" } & RatioRequest | { "do": "characteristic" } & CharacteristicRequest | { "do": "columns",
/** The file's text. */
text: string, } | { "do": "replay" } & ReplayRequest | { "do": "preset" } & PresetRequest | { "do": "export" } & Export;

/** A request to settle the loop in automatic mode at a setpoint, from which a step can begin. */
export type RestAt = {
/** The setpoint, in its unit. */
setpoint: number, };

/** The roles of an FMU's variables in a loop. The variable names are without the name of the FMU. */
export type Roles = {
/** The setpoint that the user changes. */
setpoint: string | null,
/** The process value: an input of a controller, an output of a plant. */
process_value: string | null,
/** The process value to plot, in the setpoint's unit. */
shown_process_value: string | null,
/** The manipulated value: an output of a controller, an input of a plant. */
manipulated_value: string | null,
/** The switch to manual mode and the manual value. */
manual: [string, string] | null,
/** The switch to manual mode and the manual pulses, up and down, of a controller without a manual value. */
manual_pulses: [string, [string, string]] | null,
/** The parameters GAIN, TI, TD and TM_LAG, in this order; the list may end earlier. */
controller: Array<string>,
/** The switches for the P, I and D actions, in this order. */
structure: Array<string>,
/** The pulses: outputs of a controller (up, down or heat, cool), inputs of a plant. */
pulses: Array<string>,
/** The settings of the pulse former: period, shortest pulse, ratio. */
pulse_former: Array<string>,
/** The disturbances of the loop: inputs of a plant, and values that a controller adds to its output. */
disturbances: Array<string>,
/** The limits of the manipulated value: high, low. */
limits: [string, string] | null,
/** The width of the dead band. */
dead_band: string | null,
/** The shortest pulse of a step controller. */
shortest_pulse: string | null,
/** The input that triggers a complete restart. */
restart: string | null,
/** The inputs that are settings; see [`Roles::is_stimulus`]. */
settings: Array<string>,
/** The parameters that are stimuli. */
stimuli: Array<string>,
/**
 * Additional signals, as pairs of meaning and variable, such as `high stop`: LMNR_HS. Controller and plant use the
 * same meanings. A `fault` is an output that is TRUE while a plant has stopped, such as a tripped drive.
 */
signals: Array<[string, string]>, };

/** A tuning rule. */
export type Rule = "ziegler_nichols_step" | "ziegler_nichols_ultimate" | "chr_setpoint0" | "chr_setpoint20" | "chr_disturbance0" | "chr_disturbance20" | "simc" | "lambda" | "amigo";

/** A rule and its predicted effects. */
export type RuleOutcome = {
/** The rule. */
rule: Rule,
/** The rule's name for users. */
name: string,
/** The settings, and the prediction for the same step as in all other rows. */
tuned: Tuned | null,
/** The reason why there are no settings, if there are none. */
refusal: string | null, };

/** All rules with their predicted effects. */
export type RulesTable = {
/** The rules, one per row. */
rows: Array<RuleOutcome>,
/** The reasons for missing metrics, one per line. */
missing: Array<string>, };

/** A value set while a loop runs. */
export type Set = {
/** When it is set, in seconds. */
time: number,
/** The variable, as `MEMBER.VARIABLE`. */
variable: string,
/** The value; true is 1. `None` if the member was replaced by another one. */
value: number | null,
/** The previous value, if it is known. */
before: number | null, };

/** A request to run until the loop has settled. */
export type Settle = {
/** The maximum number of calls, at least one. */
calls: number,
/** The time from which the loop is watched, in seconds: when the user started the run. */
from: number, };

/** The result of a run until the loop has settled. */
export type Settled = {
/** The state of the run. */
state: State,
/** Whether the loop has settled. */
is_at_rest: boolean,
/**
 * Whether it oscillates steadily instead, and would continue to. If neither is true, all calls were made, or the
 * run has failed.
 */
swings: boolean, };

/** The setup of a run: a controller first, then its plant and any other members. */
export type Setup = {
/** The FMUs, in the order in which they are stepped. */
members: Array<Member>,
/** The connections, each from an output to an input, both `MEMBER.VARIABLE`. */
connections: Array<[string, string]>,
/** The communication step, in seconds; by default the first member's cycle. */
step: number | null,
/** When values pass from output to input. */
exchange: Exchange, };

/** A setting changed during the recording, with the time of the change. */
export type Since = {
/** The setting, with its values after and before the change. */
change: Change,
/** The 0-based index of the likeliest first call with the new value, with its time in seconds. */
at: [number, number],
/** The earliest call that may have been the first with the new value. */
earliest: [number, number],
/**
 * The latest such call. Any call from the earliest to this one explains the recording equally well, possibly with
 * another value.
 */
latest: [number, number], };

/** A source. */
export type SourceFile = {
/** Its name. */
file: string,
/** Its bytes, Base64. */
content: string, };

/** A source as text. */
export type SourceText = {
/** Its name. */
file: string,
/** Its text. */
text: string, };

/** The state of a run. */
export type State = {
/** The 0-based number of the run. */
run: number,
/** The number of calls made. */
calls: number,
/** The time of the last call, in seconds; 0 before the first. */
time: number,
/** The communication step in seconds. */
step: number,
/** The values of all variables in the row of the last call, by `MEMBER.VARIABLE`. */
values: Values,
/**
 * In a parallel exchange: the values after the last call, because the outputs in `values` are those of the
 * previous call.
 */
after: Values | null,
/** The forced values, by `MEMBER.VARIABLE`. */
forced: Values,
/** Why the run has ended: which FMU failed, and its messages. */
failure: string | null,
/** Whether the calls of this request ended because its condition became true. */
is_met: boolean,
/** Remarks since the last answer, from the FMUs and from checking the setup, a sentence each. */
remarks: Array<string>, };

/** A setpoint step. */
export type Step = {
/** The setpoint before the step; by default the controller's current one. */
from?: number | null,
/**
 * The size of the step, negative for a step down; by default, the step after which the manipulated value is 10 %
 * higher in steady state or, if the plant is integrating, initially.
 */
size?: number | null,
/** The manual value at which the plant rests before the step, in percent; by default 50. */
manual?: number | null, };

/** A step in the manual value. */
export type StepTest = {
/**
 * The step in the manipulated value, in its unit; negative for down. If it would exceed a limit and the opposite
 * step would not, the direction is reversed.
 */
size: number,
/** The method of identification. */
method: Method,
/** Whether the plant is integrating. */
is_integrating: boolean, };

/** The result of a step test. */
export type StepTested = {
/** The state of the run after the test, with the previous mode, manual value and setpoint. */
state: State,
/** When the hold of the plant began, in seconds. */
from: number,
/** The time of the last call used for identification, in seconds; later calls restore the loop. */
to: number,
/** The time of the step in the manipulated value, in seconds. */
step: number,
/** The model. */
identified: Identified, };

/** The actions of a controller. */
export type Structure = "p" | "pi" | "pid";

/** An explanation that was tried: one or more changes. */
export type Suspect = {
/** The changes that apply from the start. */
changes: Array<Change>,
/** The change made during the recording, if any. */
since: Since | null,
/**
 * The range of values that explain the recording equally well, if a single numeric setting was changed, from the
 * start or during the recording; `None` if the range is too narrow to report.
 */
range: [number, number] | null,
/**
 * Other settings that may be wrong instead or as well: changed together with another value of the suspect's
 * setting, they explain the recording equally well.
 */
confused: Array<string>,
/** The changed settings with their values; for one that changed during the recording, its value at the end. */
values: Values,
/** The number of calls that still differ. */
different: number,
/** The largest difference that remains. */
largest: number,
/** Whether no difference remains. */
fits: boolean,
/** Whether it is certain: it is the only full explanation, and its values are unambiguous. */
is_sure: boolean,
/** Whether it fits only if the last row, which repeats all outputs, is not a call. */
ends_without_call: boolean, };

/** The means of variables as functions of an input. */
export type Sweep = {
/** The title of the chart. */
title: string,
/** The input that is varied, on the horizontal axis. */
variable: string,
/** The unit of this input. */
unit: string | null,
/** Its values, one per point. */
inputs: Array<number>,
/** Each variable with its mean at each input value; TRUE counts as 1. */
outputs: Array<[string, Array<number>]>, };

/** A run's test, repeated with other settings. */
export type Tried = {
/** Its curves. */
curves: Curves,
/** Its figures; `None` for a loop without a setpoint or a process value. */
figures: Figures | null, };

/** The controller to tune, the plant's model and the rule. */
export type TuneRequest = {
/** The plant model. */
model: Model,
/** The tuning rule. */
rule: Rule,
/** P, PI or PID. */
structure: Structure,
/**
 * The controller with its current settings. The rules use its timing and scaling; the prediction and the remarks
 * use all settings.
 */
controller: Member,
/**
 * The closed-loop time constant in seconds, for the rules SIMC and lambda. By default, it is the dead time for
 * SIMC (1.5 dead times in the table of all rules); for lambda, it is the plant's time constant or three dead
 * times, whichever is longer.
 */
closed_loop?: number | null,
/** This time constant as a position on a scale: 0 is calm, 1 is fast. `closed_loop` takes precedence. */
pace?: number | null,
/** The setpoint step to predict. */
step: Step,
/**
 * Half the width of the band around the setpoint in which the loop counts as recovered from a load, in the unit of
 * the process value, above 0; if there is a run, 2 % of its last step. By default, 2 % of the default predicted
 * step.
 */
band?: number | null,
/** Ultimate gain and period, for the ultimate rule; by default computed from the model. */
ultimate?: [number, number] | null,
/** When the loop exchanges its values; the prediction has the rows of a run with this exchange. */
exchange: Exchange, };

/** Settings and their predicted effects. */
export type Tuned = {
/** The settings in the block's form, by the block's names, including the switches of the structure. */
values: Values,
/** The dead time used, in seconds: the model's, plus half a cycle, plus half a pulse period. */
dead_time: number,
/** The closed-loop time constant used, in seconds, if the rule has one. */
closed_loop: number | null,
/** This time constant as a position on a scale from calm, 0, to fast, 1, as the request may specify it. */
pace: number | null,
/** Ms, the largest sensitivity; absent if the loop is unstable. */
sensitivity: number | null,
/** The gain margin, as a factor. */
gain_margin: number | null,
/** The phase margin in degrees. */
phase_margin: number | null,
/** The simulated setpoint step of the loop of the real block and the model. */
predicted: Predicted,
/**
 * The reasons for missing metrics, by the names of their fields: `sensitivity`, `gain_margin`, `phase_margin`,
 * `overshoot`, `settling`, `travel`, and `deviation`, `recovery` and `iae` of the load.
 */
absent: { [key in string]: string },
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** The origin of computed settings, and their predicted effects. */
export type Tuning = {
/** The plant. */
model: Model,
/** The rule. */
rule: Rule,
/** The resulting settings. */
values: Values,
/** Lambda in seconds, for a rule that uses it. */
closed_loop?: number | null,
/** The maximum sensitivity Ms. */
sensitivity?: number | null,
/** The gain margin, as a factor. */
gain_margin?: number | null,
/** The phase margin, in degrees. */
phase_margin?: number | null,
/** The predicted setpoint step. */
step: Step,
/** All compared rules with their predicted effects; of the curves, only the first and the last setpoint are needed. */
rows: Array<RuleOutcome>,
/** The previous values of the same settings. */
before: Values, };

/** A condition on a variable. */
export type Until = {
/** `MEMBER.VARIABLE` */
variable: string,
/** The comparison: `=`, `<>`, `>`, `>=`, `<`, `<=`. */
sign: "=" | "<>" | ">" | ">=" | "<" | "<=",
/** The value to compare with; TRUE is 1. */
value: number, };

/** A value as written by the user. */
export type Value = boolean | number | "NaN" | "inf" | "-inf";

/** A variable of an FMU. */
export type Variable = {
/** Its name, such as `GAIN`. */
name: string,
/** A short description. */
description: string,
/** Its PLC type, such as `REAL`; in a foreign FMU its FMI type, such as `Real`. */
kind: string,
/** Its role in the block: `input`, `parameter`, `fixed`, `cycle`, `output` or `local`. */
role: "input" | "parameter" | "fixed" | "cycle" | "output" | "local",
/** Whether it can be set while the loop runs. */
is_tunable: boolean,
/** Whether it is a stimulus of the loop (setpoint, manual value, disturbance, noise) rather than a setting. */
is_stimulus: boolean,
/** Its value in a new instance. */
start: Value,
/** The lowest sensible value. */
min: number | null,
/** The highest sensible value. */
max: number | null,
/** Its physical unit; `s` for a TIME. */
unit: string | null, };

/** The curves to show. */
export type View = {
/** The run; by default the current one. */
run?: number | null,
/** The variables, by `MEMBER.VARIABLE`. */
variables: Array<string>,
/** The beginning in seconds; by default that of the run. */
from?: number | null,
/** The end in seconds; by default the last call. */
to?: number | null,
/** The maximum number of rows, at least 2. */
points: number,
/**
 * The variables to average, each with the time to average over, in seconds, up to and including each call; for
 * pulses, their period.
 */
means?: { [key in string]: number } | null, };

/** The reason for trying a value of a setting. */
export type Why = "factor" | "sign" | "minutes" | "no_minutes" | "seconds" | "milliseconds" | "spacing" | { "rhythm": number } | "stays" | "no_dead_band" | "rests";

/** A possible connection. */
export type Wire = {
/** The output, `MEMBER.VARIABLE`. */
from: string,
/** The input, `MEMBER.VARIABLE`. */
to: string,
/** The reason for the proposal. */
reason: string, };

/** A statement that writes a variable. */
export type Write = {
/** The variable written; for a call, the instance whose members it writes. */
path: string,
/** Whether the variable is global. */
is_global: boolean,
/** The 1-based line number whose execution indicates that the write happened. */
line: number,
/** The text of the statement. */
text: string,
/** The variables from which the value is computed. */
reads: Array<Named>,
/** The conditions under which the statement runs, outermost first. */
guards: Array<Guard>, };

/** Each request with its answer. */
export interface Dialogue {
  catalogue: { request: Extract<Request, { do: "catalogue" }>; answer: Catalogue };
  describe: { request: Extract<Request, { do: "describe" }>; answer: Description };
  read: { request: Extract<Request, { do: "read" }>; answer: Loops };
  described: { request: Extract<Request, { do: "described" }>; answer: KnownLoop };
  compile: { request: Extract<Request, { do: "compile" }>; answer: Compiled };
  monitor: { request: Extract<Request, { do: "monitor" }>; answer: Monitored };
  check: { request: Extract<Request, { do: "check" }>; answer: Checked };
  propose: { request: Extract<Request, { do: "propose" }>; answer: Proposal };
  start: { request: Extract<Request, { do: "start" }>; answer: State };
  state: { request: Extract<Request, { do: "state" }>; answer: State };
  send: { request: Extract<Request, { do: "send" }>; answer: State };
  force: { request: Extract<Request, { do: "force" }>; answer: State };
  ramp: { request: Extract<Request, { do: "ramp" }>; answer: State };
  run: { request: Extract<Request, { do: "run" }>; answer: State };
  settle: { request: Extract<Request, { do: "settle" }>; answer: Settled };
  rest_at: { request: Extract<Request, { do: "rest_at" }>; answer: Settled };
  exchange: { request: Extract<Request, { do: "exchange" }>; answer: State };
  view: { request: Extract<Request, { do: "view" }>; answer: Curves };
  events: { request: Extract<Request, { do: "events" }>; answer: Events };
  same_bits: { request: Extract<Request, { do: "same_bits" }>; answer: State };
  same_test: { request: Extract<Request, { do: "same_test" }>; answer: State };
  try: { request: Extract<Request, { do: "try" }>; answer: Tried };
  figures: { request: Extract<Request, { do: "figures" }>; answer: Figures };
  forecast: { request: Extract<Request, { do: "forecast" }>; answer: Forecasted | null };
  identify: { request: Extract<Request, { do: "identify" }>; answer: Identified };
  tune: { request: Extract<Request, { do: "tune" }>; answer: Tuned };
  rules: { request: Extract<Request, { do: "rules" }>; answer: RulesTable };
  in_force: { request: Extract<Request, { do: "in_force" }>; answer: Tuned };
  bode: { request: Extract<Request, { do: "bode" }>; answer: Bode };
  step_test: { request: Extract<Request, { do: "step_test" }>; answer: StepTested };
  relay_test: { request: Extract<Request, { do: "relay_test" }>; answer: RelayTested };
  ratio: { request: Extract<Request, { do: "ratio" }>; answer: Ratio };
  characteristic: { request: Extract<Request, { do: "characteristic" }>; answer: Characteristics };
  columns: { request: Extract<Request, { do: "columns" }>; answer: Array<string> };
  replay: { request: Extract<Request, { do: "replay" }>; answer: Replayed };
  preset: { request: Extract<Request, { do: "preset" }>; answer: Preset };
  export: { request: Extract<Request, { do: "export" }>; answer: Exported };
}
