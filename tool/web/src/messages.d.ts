// The messages of the tool: tool/src/message.rs and the modules beside it, in the words of TypeScript.

export type Value = boolean | number | "NaN" | "inf" | "-inf";
export type Values = Record<string, Value>;
export type Part = "controller" | "plant" | "other";

export interface Entry {
  name: string;
  summary: string;
  part: Part;
  is_foreign: boolean;
}
export interface KnownLoop {
  title: string;
  setup: Setup;
}
export interface Catalogue {
  fmus: Entry[];
  loops: KnownLoop[];
}

export interface Variable {
  name: string;
  description: string;
  kind: string;
  role: "input" | "parameter" | "fixed" | "cycle" | "output" | "local";
  is_tunable: boolean;
  start: Value;
  min: number | null;
  max: number | null;
  unit: string | null;
}
export interface Roles {
  setpoint: string | null;
  process_value: string | null;
  shown_process_value: string | null;
  manipulated_value: string | null;
  manual: [string, string] | null;
  controller: string[];
  structure: string[];
  pulses: string[];
  pulse_former: string[];
  disturbances: string[];
  signals: [string, string][];
}
export interface Field {
  name: string;
  used_if: [string, boolean][][];
}
export interface Group {
  title: string;
  fields: Field[];
}
export interface Description {
  name: string;
  block: string;
  summary: string;
  aliases: string[];
  part: Part;
  cycle: string | null;
  variables: Variable[];
  roles: Roles;
  groups: Group[];
}

export interface Setting {
  name: string;
  value: Value;
  origin: string | null;
}
export interface Loop {
  name: string;
  block: string;
  cycle: number | null;
  settings: Setting[];
  warnings: string[];
}
export interface Problem {
  place: [number, number] | null;
  message: string;
  help: string | null;
}
export interface Loops {
  loops: Loop[];
  problems: Problem[];
  is_refused: boolean;
}
export interface Remark {
  variables: string[];
  text: string;
  is_error: boolean;
}
export interface Checked {
  remarks: Remark[];
  unused: string[];
  rounded: Values;
}
export interface Wire {
  from: string;
  to: string;
  reason: string;
}
export interface Proposal {
  connections: Wire[];
  others: Wire[];
  values: Values;
  remarks: string[];
}

export interface Member {
  name: string;
  fmu: string;
  values: Values;
}
export interface Setup {
  members: Member[];
  connections: [string, string][];
  step?: number | null;
  exchange?: "sequential" | "parallel";
}
export interface State {
  run: number;
  calls: number;
  time: number;
  step: number;
  values: Values;
  failure: string | null;
  remarks: string[];
}
export interface Curves {
  times: number[];
  values: (number | null)[][];
  units: (string | null)[];
  is_exact: boolean;
}
export interface Event {
  call: number;
  time: number;
  variable: string;
  value: Value;
}
export interface Events {
  events: Event[];
  calls: number;
}

export interface Figures {
  from: number;
  to: number;
  rise: number | null;
  overshoot: number | null;
  settled: number | null;
  iae: number | null;
  ise: number | null;
  peak: number | null;
  travel: number | null;
  pulses: number | null;
  unit: string | null;
  travel_unit: string | null;
  remarks: string[];
}

export type Data =
  | { run: { run?: number | null; from?: number | null; to?: number | null } }
  | {
      csv: {
        text: string;
        time?: string | null;
        input?: string | null;
        output?: string | null;
        from?: number | null;
        to?: number | null;
      };
    };
export type Method = "tangent" | "two_points" | "area" | "least_squares";
export interface Model {
  gain: number;
  time_constant: number;
  second_time_constant?: number;
  dead_time: number;
  is_integrating?: boolean;
}
export interface Identified {
  model: Model;
  fit: number;
  times: number[];
  measured: number[];
  modelled: number[];
  remarks: string[];
}
export type Rule =
  | "ziegler_nichols_step"
  | "ziegler_nichols_ultimate"
  | "chr_setpoint0"
  | "chr_setpoint20"
  | "chr_disturbance0"
  | "chr_disturbance20"
  | "simc"
  | "amigo";
export type Structure = "p" | "pi" | "pid";
export interface Predicted {
  times: number[];
  setpoint: number[];
  process_value: number[];
  manipulated_value: number[];
  overshoot: number | null;
  settled: number | null;
}
export interface Tuned {
  values: Values;
  dead_time: number;
  sensitivity: number | null;
  gain_margin: number | null;
  phase_margin: number | null;
  predicted: Predicted;
  remarks: string[];
}
export interface Ratio {
  ratio: number;
  model: Model;
  remarks: string[];
}
export interface Sweep {
  title: string;
  variable: string;
  unit: string | null;
  inputs: number[];
  outputs: [string, number[]][];
}
export interface Characteristics {
  sweeps: Sweep[];
}
export interface Compared {
  variable: string;
  first: [number, number] | null;
  different: number;
  largest: number;
  times: number[];
  recorded: number[];
  computed: number[];
}
export interface Suspect {
  text: string;
  values: Values;
  different: number;
  largest: number;
  fits: boolean;
}
export interface Replayed {
  columns: [string, string][];
  calls: number;
  outputs: Compared[];
  suspects: Suspect[];
  verdict: string;
  is_conclusive: boolean;
  remarks: string[];
}
export interface Preset {
  name: string;
  guid: string;
  files: Record<string, string>;
  left_out: string[];
  remarks: string[];
}

export interface Exported {
  file: string;
  media_type: string;
  content: string;
  remarks: string[];
}

export type Export =
  | { what: "parameters"; format: string; loops: Loop[]; origin: string }
  | { what: "description"; run?: number | null }
  | { what: "csv"; run?: number | null; variables?: string[] }
  | { what: "report"; of: Loop; before: Setting[]; run?: number | null; picture?: string | null }
  | { what: "preset"; of: Loop };

/** What the page asks for, and what it is answered. */
export interface Dialogue {
  catalogue: { request: { do: "catalogue" }; answer: Catalogue };
  describe: { request: { do: "describe"; fmu: string }; answer: Description };
  read: {
    request: { do: "read"; file: string; content: string; block?: string | null; name?: string | null };
    answer: Loops;
  };
  check: { request: { do: "check"; fmu: string; values: Values }; answer: Checked };
  propose: { request: { do: "propose"; controller: Member; plant: Member }; answer: Proposal };
  start: { request: { do: "start" } & Setup; answer: State };
  send: { request: { do: "send"; values: Values }; answer: State };
  ramp: { request: { do: "ramp"; variable: string; to: number; seconds: number }; answer: State };
  run: { request: { do: "run"; calls: number }; answer: State };
  exchange: {
    request: { do: "exchange"; members: Member[]; connections: [string, string][] };
    answer: State;
  };
  view: {
    request: {
      do: "view";
      run?: number | null;
      variables: string[];
      from?: number | null;
      to?: number | null;
      points: number;
    };
    answer: Curves;
  };
  events: { request: { do: "events"; run?: number | null }; answer: Events };
  again: { request: { do: "again" }; answer: State };
  figures: {
    request: { do: "figures"; run?: number | null; from?: number | null; to?: number | null };
    answer: Figures;
  };
  identify: {
    request: { do: "identify"; data: Data; method: Method; is_integrating?: boolean };
    answer: Identified;
  };
  tune: {
    request: {
      do: "tune";
      model: Model;
      rule: Rule;
      structure: Structure;
      controller: Member;
      closed_loop?: number | null;
      ultimate?: [number, number] | null;
    };
    answer: Tuned;
  };
  ratio: { request: { do: "ratio"; heating: Model; cooling: Model }; answer: Ratio };
  characteristic: { request: { do: "characteristic"; member: Member }; answer: Characteristics };
  columns: { request: { do: "columns"; text: string }; answer: string[] };
  replay: {
    request: {
      do: "replay";
      controller: Member;
      text: string;
      columns?: [string, string][];
      tolerance?: number | null;
      try_suspects?: boolean;
    };
    answer: Replayed;
  };
  preset: { request: { do: "preset"; of: Loop; files: Record<string, string> }; answer: Preset };
  export: { request: { do: "export" } & Export; answer: Exported };
}
export type Request = Dialogue[keyof Dialogue]["request"];
