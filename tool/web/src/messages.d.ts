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
/** Ascending, in radians per second. */
frequencies: Array<number>,
/** In the order of the request. */
loops: Array<OpenLoop>, };

/** The open loops to draw. */
export type BodeRequest = {
/** The plant. */
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
/** The kinds of parameter files that can be written: extensions and titles. */
formats: Array<[string, string]>, };

/** The event that begins a part of a run. */
export type Cause = "start" | "setpoint" | "automatic" | "disturbance";

/** A change to one of the block's settings, or to its calls. */
export type Change = { "setting": {
/** The setting. */
name: string,
/** Its value in the replay that explains the recording. */
value: Value,
/** Its value in the loop. */
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

/** The check of a block's settings. */
export type Checked = {
/** Sentences, each with the settings that it names. */
remarks: Array<Remark>,
/** The settings without effect in combination with the others, by name. */
unused: Array<string>,
/** The values as held by the PLC's types, where they differ from the given ones. */
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
/** The variable. */
variable: string,
/** The 0-based index of the first call that differs, with its time in seconds. */
first: [number, number] | null,
/** The number of calls that differ. */
different: number,
/** The largest difference. */
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
/** The recorded values. */
recorded: Array<number>,
/** The values computed by the block. */
computed: Array<number>, };

/** The result of a translation. */
export type Compiled = {
/** The name in the catalogue under which the program runs; `None` if it was rejected. */
fmu: string | null,
/** The block to run. */
block: string,
/** Errors, and warnings for the author, in the order of the sources. */
problems: Array<Finding>,
/** The blocks to choose from, if the block to run is ambiguous. */
candidates: Array<string>,
/** The time between two calls in seconds. */
cycle: number,
/** The origin of the cycle. */
cycle_from: string,
/** The texts of the sources. */
sources: Array<SourceText>,
/** The blocks with code, in the order of the sources. */
blocks: Array<CodeBlock>,
/** The declarations of data blocks and tags: the name, the index of the source, and the line. */
declared: Array<[string, number, number]>,
/** The instances of blocks; first the program itself, whose path is empty. */
parts: Array<Instance>,
/** A summary of the project's files and of missing parts: rows of a table. Empty for a single source. */
survey: Array<[string, string]>,
/** Possible assumptions about undeclared names; without them, the program is rejected. */
assumptions: Array<Assumption>, };

/** The conclusion from a recording about a block. */
export type Conclusion = "equal" | "rounded" | "differs" | "cause" | "likely_cause" | "ambiguous" | "coarse" | "unexplained";

/**
 * Curves: each row is a call. If they are not exact, each pair of rows represents a group of calls, at the times of
 * its first and its last one, with the lowest and the highest value of each variable in the group, in the order in
 * which they occur.
 */
export type Curves = {
/** The times in seconds. */
times: Array<number>,
/** The values of each variable at these times; `null` stands for NaN; true is 1. */
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
/** The role of each operand in the decision: `decided`, `shared` (one reason of several), `idle`. */
parts: ("decided" | "shared" | "idle")[],
/** The values of the operands when they were calculated; `None` for one that is not a Boolean. */
values: Array<boolean | null>,
/** The numbers of the deciding truth values, as for wires. */
wires: Array<number>, };

/** The decisions that led to an assignment. */
export type Decisions = {
/** On the value; `None` if it is not a truth value. */
value: Decision | null,
/** On the conditions under which it runs, in order. */
guards: Array<Decision | null>, };

/** An FMU as displayed by a dialog. */
export type Description = {
/** Its name in the catalogue. */
name: string,
/** The name of its block, as used in parameter files. */
block: string,
/** A summary in one sentence. */
summary: string,
/** The other names by which a PLC project may call the block. */
aliases: Array<string>,
/** Its role in a loop. */
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
/** Its role in a loop. */
part: LoopRole,
/** Whether it is a foreign FMU: third-party native code. */
is_foreign: boolean, };

/** A value that was set while the loop ran. */
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
/** `awl`, `scl`, `db`, `xml`, `json`, `ssv`: the extension of the file. */
format: string,
/** The loops with their values. */
loops: Array<Loop>,
/** The origin of the values, for a comment. */
origin: string,
/**
 * Whether the file contains the current stimuli: setpoint, manual value and the like. By default they have the
 * value of their original file, or the block's start value.
 */
stimuli: boolean, } | { "what": "source",
/** The file as opened. */
file: ReadFile,
/** The loops of the file with changed values. */
loops: Array<Loop>,
/** Whether the file contains the current stimuli, as for a new parameter file. */
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
/** The previous values, for comparison; may be empty. */
before: Array<LoopValue>,
/** The run; by default the current one. */
run?: number | null,
/** A picture of the curves, an `<svg>` or a `data:` URL of a PNG; by default drawn by the engine. */
picture?: string | null,
/** The date of the report, as displayed. */
date?: string | null,
/** The origin of the settings. */
tuning?: Tuning | null,
/** The compared runs of the same step, the earliest first. */
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

/** The figures of a run that its signals permit. */
export type Figures = {
/** The beginning of their window, in seconds. */
from: number,
/** The end of their window, in seconds. */
to: number,
/** The step to which they belong: two runs with the same step over the same time can be compared. */
step: Happened | null,
/** The disturbance to which the figures of a disturbance belong. */
disturbance: Happened | null,
/** The figures, in display order. */
figures: Array<Figure>,
/** The missing figures, and the reasons. */
remarks: Array<string>, };

/** A run, and the part of it to evaluate. */
export type FiguresRequest = {
/** The run; by default the current one. */
run?: number | null,
/** The beginning in seconds; by default that of the last step. */
from?: number | null,
/** The end in seconds; if neither end nor beginning is given, that of the last step's window. */
to?: number | null,
/** The unit of the process value, if its variable has none. */
unit?: string | null,
/** The unit of the manipulated value, if its variable has none. */
travel_unit?: string | null, };

/** A message about a place in a source. */
export type Finding = {
/** The source's name; empty if it concerns all of them. */
file: string,
/** The 1-based line and column. */
place: [number, number] | null,
/** The number of characters concerned, in its first line. */
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

/** A condition. */
export type Guard = {
/** The kind of statement it belongs to. */
of: "if" | "case" | "while" | "until",
/** Its 1-based line number. */
line: number,
/** Its text. */
text: string,
/** Whether the guarded statements run if it is FALSE. */
is_negated: boolean,
/** The variables it names. */
reads: Array<Named>, };

/** The event that a window belongs to. */
export type Happened = {
/** Its cause. */
cause: Cause,
/** The process value when it began. */
from: number,
/** The setpoint at its end. */
to: number,
/** Its time, in seconds. */
start: number,
/** The length of its window, in seconds. */
duration: number,
/**
 * Half the width of the band around the setpoint in which the process value counts as settled or recovered, in
 * its unit; absent after a disturbance with no step before it.
 */
band: number | null,
/** The variables that disturbed the loop, each with its last value. */
by: Array<Set>, };

/** A model and the quality of its fit. */
export type Identified = {
/** The model. */
model: Model,
/** The quality of the fit: 100 (1 - NRMSE) in percent. */
fit: number,
/** The times of a chart of the measured and the modelled response, in seconds. */
times: Array<number>,
/** The measured process value. */
measured: Array<number>,
/** The model's process value. */
modelled: Array<number>,
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** The data from which to identify a plant, and the method. */
export type IdentifyRequest = {
/** The recorded step. */
data: Data,
/** The method. */
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
/** Its path as named in the FMU, such as `motors[1]`; empty for the program itself. */
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
/** Its special feature, or empty. */
about: string,
/** Its members and connections. */
setup: Setup,
/** The length of its run in the description, in seconds. */
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
/** The largest deviation from the setpoint, in its unit. */
deviation: number,
/** The time in seconds after the load from which the deviation stays within the band; `None` if it does not. */
recovery: number | null,
/**
 * The integral of the absolute error, in the unit of the setpoint times seconds; absent if the loop does not
 * recover.
 */
iae: number | null,
/** Half the width of the band around the setpoint in which the loop has recovered, in its unit. */
band: number, };

/** A loop of a file. */
export type Loop = {
/** Its name. */
name: string,
/** Its title in the file. */
title: string | null,
/** The name of its block in the catalogue. */
block: string,
/** The time between two calls. */
cycle: number | null,
/** Its values. */
settings: Array<LoopValue>,
/** Effects of the settings that a user may not expect, and values out of range. */
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
/** The value in the file, if the current value differs. */
file: Value | null, };

/** The loops of a file. */
export type Loops = {
/** The loops, in the order of the file; empty if the file is faulty. */
loops: Array<Loop>,
/** Problems, and remarks for the user. */
problems: Array<Problem>,
/** Whether the file could not be used. */
is_refused: boolean, };

/** A member that is a PLC program. */
export type MadeOf = {
/** The member. */
member: string,
/** The names of its sources, without folders. */
sources: Array<string>,
/** How it is built from them. The sources themselves are missing. */
program: Program, };

/** An FMU in a loop. */
export type Member = {
/** Its name in the loop. */
name: string,
/** The FMU's name in the catalogue. */
fmu: string,
/** Its settings; other variables have their start values. */
values: Values, };

/** The method of identification. */
export type Method = "tangent" | "two_points" | "area" | "least_squares";

/**
 * A plant: a lag with dead time, or an integrator with dead time.
 *
 * The gain is measured from the controller's output to the process value that the controller compares with the
 * setpoint. A model identified from a loop's signals has this gain: it includes the factors and offsets that the block
 * applies to the process value (PV_FAC). It does not include those applied to the manipulated value inside the block
 * (LMN_FAC); [`tune`](crate::tune) takes them into account.
 */
export type Model = {
/** K in units of the process value per unit of the manipulated value; per second for an integrating plant. */
gain: number,
/** T in seconds; 0 for an integrating plant. */
time_constant: number,
/** A second lag in seconds, or 0. */
second_time_constant: number,
/** L in seconds. */
dead_time: number,
/** Whether the plant is integrating. */
is_integrating: boolean, };

/**
 * The activity of a program in its last call, apart from the values of its variables, which are in the state of the
 * run.
 */
export type Monitored = {
/** The temporaries of the running block, at the end of the call. */
temps: Values,
/** Its STRINGs and WSTRINGs at the end of the call; a run has numbers only. */
texts: { [key in string]: string },
/** The executed lines: the 0-based index of the source, and the line. */
lines: Array<[number, number]>,
/** The program's warnings since its start, with file and line. */
warnings: Array<string>,
/** The truth values in the networks of the requested block, by number. Those that were not calculated are missing. */
wires: Array<[number, boolean]>,
/** The decisions in each of the requested blocks: a row for each of its writes. */
decided: Array<Array<Decisions>>, };

/** A setting that changes during a recording: the comparison uses the recorded values instead of the loop's. */
export type Moving = {
/** The setting. */
name: string,
/** Its first value in the recording. */
first: Value,
/** Its last value there. */
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
/** At each frequency, in dB. */
amplitude: Array<number>,
/** At each frequency, in degrees. */
phase: Array<number>,
/** Ms, the largest sensitivity; absent if the loop is unstable. */
sensitivity: number | null,
/** The gain margin, as a factor. */
gain_margin: number | null,
/** In degrees. */
phase_margin: number | null,
/** The frequency at which the gain margin is read, in radians per second. */
phase_crossover: number | null,
/** The frequency at which the phase margin is read, in radians per second. */
gain_crossover: number | null, };

/** A variable, a constant or a label. */
export type Operand = {
/** The text as written. */
text: string,
/** The path of a variable. */
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

/** A simulated loop. */
export type Predicted = {
/** In seconds. */
times: Array<number>,
/** The setpoint. */
setpoint: Array<number>,
/** The process value. */
process_value: Array<number>,
/** The manipulated value. */
manipulated_value: Array<number>,
/** Its overshoot in percent of the step. */
overshoot: number | null,
/** Its settling time in seconds. */
settling: number | null,
/** The total travel of the manipulated value since the step. */
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

/** A preset of an FMU opened by the page. */
export type PresetRequest = {
/** The loop with its values. */
of: Loop,
/** The FMU's `modelDescription.xml`, `documentation/index.html` and `resources/start.txt`, where they exist. */
files: { [key in string]: string }, };

/** A problem or a remark at a place in a file. */
export type Problem = {
/** The 1-based line and column, if it has a place. */
place: [number, number] | null,
/** The problem. */
message: string,
/** The remedy. */
help: string | null,
/** Whether the user must choose the block whose parameters the file contains. */
asks_for_block: boolean, };

/**
 * The sources of a program, and how it is built from them. The defaults are those of `plcfmu build`; the default cycle
 * is proposed by the sources.
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
/** The communication step for them; by default the controller's cycle. */
step: number | null,
/** When values pass from output to input, in the known loop on which the proposal is based. */
exchange: Exchange,
/** Unconnected inputs that need a connection. */
open: Array<Open>,
/** Other remarks for the user, a sentence each. */
remarks: Array<string>, };

/** The compensation of a three-step pulse former for heating and cooling of different strength. */
export type Ratio = {
/** RATIOFAC. */
ratio: number,
/** The model for tuning the controller: the weaker gain, the longer dead time. */
model: Model,
/** Remarks for the user, one sentence each. */
remarks: Array<string>, };

/** A heating and a cooling step. */
export type RatioRequest = {
/** The plant with the manipulated value above 0. */
heating: Model,
/** The plant with the manipulated value below 0. */
cooling: Model, };

/** A parameter file. */
export type ReadFile = {
/** Its name, whose extension selects the format. */
file: string,
/** Its bytes, Base64. */
content: string,
/** The block, if the file does not specify it. */
block?: string | null,
/** The loop's name, if the file does not specify it. */
name?: string | null, };

/** A relay instead of the controller. */
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
/** The amplitude of the process value while the relay switches. */
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
/** The block with the file's parameters. */
controller: Member,
/** The text of the CSV file. */
text: string,
/** The assignment of columns to variables of the block, or to `time`. By default, columns are matched by name. */
columns: Array<[string, string]>,
/** The deviation up to which a value counts as equal; by default, the recording's resolution. */
tolerance?: number | null,
/** Whether to look for likely causes. */
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
/** The explanations tried, best first. */
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

/** A recording that was replayed through the block. */
export type ReportedReplay = {
/** The recording's file. */
file: string,
/** The controller's settings with which it was replayed. */
values: Values,
/** The conclusion, in a sentence. */
verdict: string,
/** Further remarks on it, a sentence each. */
remarks: Array<string>,
/** The settings in which the recording differed from the loop. */
settings: Array<Change>, };

/** A run compared with others. */
export type ReportedRun = {
/** Its number in the session. */
run: number,
/** The user's name for it. */
name: string,
/** Its settings at its end, where they differ from other runs. */
values: Values,
/** Its settings at its beginning, where they changed during the run. */
begun: Values, };

/** A request of the page. */
export type Request = { "do": "catalogue" } | { "do": "describe",
/** The FMU's name in the catalogue. */
fmu: string, } | { "do": "read" } & ReadFile | { "do": "described",
/** Its file's name, for messages. */
file: string,
/** Its text. */
text: string, } | { "do": "compile" } & Program | { "do": "monitor",
/** Its name in the loop. */
member: string,
/** The 0-based index of the call; by default the last one. For an earlier one, the run is repeated up to it. */
call?: number | null,
/** The block whose networks are displayed, and the path of its instance; empty for a function. */
networks?: [string, string] | null,
/** The blocks whose decisions are requested, each with the path of its instance. */
why?: Array<[string, string]> | null, } | { "do": "check",
/** The FMU's name in the catalogue. */
fmu: string,
/** Its settings; the others have their start values. */
values: Values, } | { "do": "propose",
/** The controller. */
controller: Member,
/** The plant. */
plant: Member, } | { "do": "start" } & Setup | { "do": "state" } | { "do": "send",
/** The values, by `MEMBER.VARIABLE`. */
values: Values, } | { "do": "force",
/** `write`, `force` or `release`; `set` is what [`Request::Send`] does. */
act: Act,
/** The values, by `MEMBER.VARIABLE`; ignored for a release. */
values: Values, } | { "do": "ramp",
/** `MEMBER.VARIABLE` */
variable: string,
/** The last value. */
to: number,
/** The duration. */
seconds: number, } | { "do": "run",
/** The number, at least one. */
calls: number,
/** A condition: the call in which it becomes true is the last one. */
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
 * The settings in force, by `MEMBER.VARIABLE`; others have their value at the end of that run. Stimuli are
 * ignored.
 */
values: Values, } | { "do": "try",
/** The settings, by `MEMBER.VARIABLE`; stimuli are ignored. */
values: Values,
/** The curves to draw; its `run` is ignored. */
view: View,
/** The window and the units of the figures; its `run` is ignored. */
figures: FiguresRequest, } | { "do": "figures" } & FiguresRequest | { "do": "forecast",
/** The run; by default the current one. */
run?: number | null,
/** The plant. */
tuning: Tuning, } | { "do": "identify" } & IdentifyRequest | { "do": "tune" } & TuneRequest | { "do": "rules" } & TuneRequest | { "do": "in_force" } & TuneRequest | { "do": "bode" } & BodeRequest | { "do": "step_test" } & StepTest | { "do": "relay_test" } & RelayTest | { "do": "ratio" } & RatioRequest | { "do": "characteristic" } & CharacteristicRequest | { "do": "columns",
/** The file's text. */
text: string, } | { "do": "replay" } & ReplayRequest | { "do": "preset" } & PresetRequest | { "do": "export" } & Export;

/** Automatic mode, settled at a setpoint, from which a step can begin. */
export type RestAt = {
/** The setpoint, in its unit. */
setpoint: number, };

/** The roles of an FMU's variables in a loop. All names are the FMU's own. */
export type Roles = {
/** The setpoint changed by the user. */
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
/** GAIN, TI, TD and TM_LAG, if the block has them. */
controller: Array<string>,
/** The switches for the P, I and D actions. */
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

/** A rule. */
export type Rule = "ziegler_nichols_step" | "ziegler_nichols_ultimate" | "chr_setpoint0" | "chr_setpoint20" | "chr_disturbance0" | "chr_disturbance20" | "simc" | "lambda" | "amigo";

/** A rule and its predicted effects. */
export type RuleOutcome = {
/** The rule. */
rule: Rule,
/** Its name. */
name: string,
/** The settings, and the prediction for the same step as in all other rows. */
tuned: Tuned | null,
/** The reason why there are no settings. */
refusal: string | null, };

/** All rules with their predicted effects. */
export type RulesTable = {
/** The rules, one per row. */
rows: Array<RuleOutcome>,
/** The reasons for missing metrics, a line for each. */
missing: Array<string>, };

/** A value set while a loop runs. */
export type Set = {
/** When, in seconds. */
time: number,
/** `MEMBER.VARIABLE` */
variable: string,
/** The value; true is 1. `None` if another member replaced this one. */
value: number | null,
/** The previous value, if it is known. */
before: number | null, };

/** A run until the loop has settled. */
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
 * Whether it oscillates steadily instead, and would continue to. If neither, all calls were made, or the run has
 * failed.
 */
swings: boolean, };

/** The setup of a run: a controller first, then its plant and any other members. */
export type Setup = {
/** The FMUs, in the order in which they are stepped. */
members: Array<Member>,
/** The connections, each from an output to an input, both `MEMBER.VARIABLE`. */
connections: Array<[string, string]>,
/** The communication step; by default the first member's cycle. */
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
/** The latest such call. Any call in between explains the recording equally well, possibly with another value. */
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
 * The values after the last call if members act in parallel, where the outputs in the row are those of the
 * previous call.
 */
after: Values | null,
/** The forced values, by `MEMBER.VARIABLE`. */
forced: Values,
/** Why the run has ended: which FMU failed, and its messages. */
failure: string | null,
/** Whether the last calls ended because their condition became true. */
is_met: boolean,
/** Remarks of the FMUs and the plan since the last answer, a sentence each. */
remarks: Array<string>, };

/** A setpoint step. */
export type Step = {
/** The setpoint before the step; by default that of the controller. */
from?: number | null,
/**
 * The size of the step, negative for a step down; by default, the step that finally moves the manipulated value by
 * 10 %, or initially if the plant is integrating.
 */
size?: number | null,
/** The manual value at which the plant rests before the step, in percent; by default 50. */
manual?: number | null, };

/** A step in the manual value. */
export type StepTest = {
/**
 * The step in the manipulated value, in its unit; negative for down. If it exceeds a limit and the opposite step
 * does not, the direction is reversed.
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
/** The last call used for identification, in seconds: later ones restore the loop. */
to: number,
/** The time of the step in the manipulated value, in seconds. */
step: number,
/** The model. */
identified: Identified, };

/** The actions of a controller. */
export type Structure = "p" | "pi" | "pid";

/** A change that was tried. */
export type Suspect = {
/** The changes that apply from the start. */
changes: Array<Change>,
/** The change made during the recording, if any. */
since: Since | null,
/** If exactly one of the changes is a number, the range of values that explain the recording equally well. */
range: [number, number] | null,
/**
 * Other settings that could differ as well, with another value of this number, and explain the recording equally
 * well.
 */
confused: Array<string>,
/** The changed settings with their values; for one that changed during the recording, its value at the end. */
values: Values,
/** The number of calls that still differ. */
different: number,
/** The largest difference. */
largest: number,
/** Whether no difference remains. */
fits: boolean,
/** Whether it is certain: it is the only full explanation, and its values are unambiguous. */
is_sure: boolean,
/** Whether it fits only if the last row, which repeats all outputs, is not a call. */
ends_without_call: boolean, };

/** The means of variables as functions of an input. */
export type Sweep = {
/** Its title. */
title: string,
/** The variable of the horizontal axis. */
variable: string,
/** Its unit. */
unit: string | null,
/** Its values. */
inputs: Array<number>,
/** Each variable with its means; true counts 1. */
outputs: Array<[string, Array<number>]>, };

/** A run's test, repeated with other settings. */
export type Tried = {
/** Its curves. */
curves: Curves,
/** Its figures; `None` for a loop without a setpoint or a process value. */
figures: Figures | null, };

/** The controller to tune, the plant's model and the rule. */
export type TuneRequest = {
/** The plant. */
model: Model,
/** The rule. */
rule: Rule,
/** P, PI or PID. */
structure: Structure,
/** The controller with its current settings, of which CYCLE, the normalization and the pulse former matter. */
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
 * Half the width of the band in which the loop has recovered from a load, in the unit of the process value, above
 * 0; after a run, 2 % of its last step. By default, 2 % of the default predicted step.
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
/** The dead time used: the model's, plus half a cycle, plus half a pulse period. */
dead_time: number,
/** The closed-loop time constant used, if the rule has one. */
closed_loop: number | null,
/** This time constant as a position on a scale from calm, 0, to fast, 1, as the request may specify it. */
pace: number | null,
/** The largest sensitivity. */
sensitivity: number | null,
/** The gain margin, as a factor. */
gain_margin: number | null,
/** The phase margin in degrees. */
phase_margin: number | null,
/** The simulated setpoint step of the real block with the model. */
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
/** The largest sensitivity. */
sensitivity?: number | null,
/** The gain margin, as a factor. */
gain_margin?: number | null,
/** In degrees. */
phase_margin?: number | null,
/** The predicted setpoint step. */
step: Step,
/** All compared rules with their predicted effects; the curves may be omitted except for both ends of the setpoint. */
rows: Array<RuleOutcome>,
/** The previous values of the same settings. */
before: Values, };

/** A condition. */
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
/** `input`, `parameter`, `fixed`, `cycle`, `output`, `local` */
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
/** Its physical unit; s for a TIME. */
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
/** The maximum number of points. */
points: number,
/**
 * The variables to average, each with the number of seconds to average over, ending with the call itself: for
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
/** The conditions under which it runs, outermost first. */
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
