use super::*;
use crate::system::Member;
use modeldescription::DefaultExperiment;

fn variable(name: &str, value_reference: u32, causality: Causality, of: Variable) -> Variable {
    Variable { name: name.into(), value_reference, causality, variability: Variability::Tunable, ..of }
}

fn real(unit: Option<&str>, min: Option<f64>, max: Option<f64>) -> Variable {
    Variable { unit: unit.map(str::to_string), min, max, ..Variable::default() }
}

fn of(kind: Option<Type>) -> Variable {
    Variable { kind, type_name: kind.map_or("String", Type::name), ..Variable::default() }
}

fn description(variables: Vec<Variable>, default_experiment: Option<DefaultExperiment>) -> Description {
    Description { variables, default_experiment, ..Description::default() }
}

fn experiment(start: f64, stop: f64, step: f64) -> Option<DefaultExperiment> {
    Some(DefaultExperiment {
        start_time: Some(start),
        stop_time: Some(stop),
        step_size: Some(step),
        ..DefaultExperiment::default()
    })
}

/// A controller with the inputs SP, PV_PER and ON, the setting GAIN, and the outputs LMN and HIGH.
fn controller() -> Description {
    use Causality::{Input, Output, Parameter};
    let plain = || real(None, None, None);
    let mut cycle = variable("CYCLE", 4, Parameter, real(Some("s"), Some(0.001), None));
    (cycle.variability, cycle.start) = (Variability::Fixed, Some(1.0));
    let variables = vec![
        variable("SP", 0, Input, plain()),
        variable("PV_PER", 1, Input, of(Some(Type::Integer))),
        variable("ON", 2, Input, of(Some(Type::Boolean))),
        variable("GAIN", 3, Parameter, plain()),
        cycle,
        variable("LMN", 5, Output, plain()),
        variable("HIGH", 6, Output, of(Some(Type::Boolean))),
        variable("STATE.SUM", 7, Causality::Local, plain()),
    ];
    description(variables, experiment(0.0, 60.0, 1.0))
}

/// A plant: TEMP in degC and T_PER of POWER in %.
fn plant() -> Description {
    use Causality::{Input, Output};
    let variables = vec![
        variable("POWER", 0, Input, real(Some("%"), Some(0.0), Some(100.0))),
        variable("MODE", 0, Input, of(Some(Type::Integer))),
        variable("TEMP", 1, Output, real(Some("degC"), None, None)),
        variable("T_PER", 2, Output, of(Some(Type::Integer))),
        variable("NAME", 3, Output, of(None)),
    ];
    description(variables, experiment(5.0, 90.0, 0.1))
}

const LOOP: [&str; 2] = ["C.LMN=P.POWER", "P.T_PER=C.PV_PER"];

/// A system with the controller C before the plant P.
fn system(connections: &[&str], settings: &[&str]) -> System {
    System {
        members: ["C", "P"].map(|name| Member { name: name.into(), path: format!("{name}.fmu").into() }).into(),
        connections: connections.iter().map(|text| text.parse().unwrap()).collect(),
        settings: settings.iter().map(|text| text.parse().unwrap()).collect(),
        ..System::default()
    }
}

fn plan(system: &System) -> Result<Plan> {
    Plan::new(system, &[&controller(), &plant()])
}

fn error(system: &System) -> String {
    format!("{:#}", plan(system).unwrap_err())
}

/// Counts of this many Reals, Integers and Booleans and no other types.
fn counts(of: [usize; 3]) -> [usize; Type::ALL.len()] {
    let mut counts = [0; Type::ALL.len()];
    counts[..3].copy_from_slice(&of);
    counts
}

#[test]
fn the_default_recording_has_all_outputs_and_the_inputs_that_are_connected_or_set() {
    let plan = plan(&system(&LOOP, &["C.SP=1", "C.GAIN=2"])).unwrap();
    let names: Vec<_> = plan.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["C.SP", "C.PV_PER", "C.LMN", "C.HIGH", "P.POWER", "P.TEMP", "P.T_PER"]);
    let units: Vec<_> = plan.columns.iter().map(|column| column.unit.as_deref()).collect();
    assert_eq!(units, [None, None, None, None, Some("%"), Some("degC"), None]);
}

#[test]
fn a_recording_holds_what_is_asked_for_in_that_order_and_once() {
    let mut system = system(&LOOP, &[]);
    system.record = ["P.TEMP", "C.STATE.SUM", "C.GAIN", "P.TEMP"].map(Recorded::from).into();
    let plan = plan(&system).unwrap();
    let names: Vec<_> = plan.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["P.TEMP", "C.STATE.SUM", "C.GAIN"]);
}

#[test]
fn outputs_of_the_plant_are_recorded_as_the_controller_reads_them() {
    let before = |system: &System| -> Vec<String> {
        let columns = plan(system).unwrap().columns.into_iter();
        columns.filter(|column| column.is_before_step).map(|column| column.name).collect()
    };
    // T_PER is fed back; TEMP is included with it.
    assert_eq!(before(&system(&LOOP, &[])), ["P.TEMP", "P.T_PER"]);
    // Nothing reads the plant's outputs.
    assert_eq!(before(&system(&LOOP[..1], &[])), [""; 0]);
    // An FMU connected to itself reads its output from before the step.
    assert_eq!(before(&system(&["C.LMN=C.SP"], &[])), ["C.LMN", "C.HIGH"]);
    // Each output of an FMU as its readers see it.
    assert_eq!(before(&system(&["C.LMN=P.POWER", "C.HIGH=C.ON"], &[])), ["C.HIGH"]);
    // In parallel all outputs are read before the steps.
    let parallel = System { exchange: Exchange::Parallel, ..system(&LOOP, &[]) };
    assert_eq!(before(&parallel), ["C.LMN", "C.HIGH", "P.TEMP", "P.T_PER"]);
}

#[test]
fn variables_of_one_type_are_read_in_one_call_and_found_at_their_place() {
    let plan = plan(&system(&LOOP, &[])).unwrap();
    let plant = &plan.members[1];
    assert_eq!(plant.observed, TypedBatch { references: vec![0, 1, 2], counts: counts([2, 1, 0]) });
    assert_eq!(plant.observed.groups().collect::<Vec<_>>(), [(Type::Real, 0..2), (Type::Integer, 2..3)]);
    assert_eq!(plant.outputs, TypedBatch { references: vec![2], counts: counts([0, 1, 0]) });
    assert_eq!(plant.output_places, [2]);
    // The controller's PV_PER comes from member 1, index 2.
    assert_eq!(plan.members[0].connected, TypedBatch { references: vec![1], counts: counts([0, 1, 0]) });
    assert_eq!(plan.members[0].sources, [(1, 2)]);
}

#[test]
fn start_values_go_to_where_the_standard_wants_them() {
    let plan = plan(&system(&[], &["C.GAIN=2", "C.ON=true", "C.SP=1", "C.SP=5@30", "C.SP=4@20", "P.MODE=3"])).unwrap();
    let controller = &plan.members[0];
    let set = |kind, reference, value| Assignment { kind, reference, value };
    assert_eq!(controller.parameters, [set(Type::Real, 3, 2.0)]);
    assert_eq!(controller.inputs, [set(Type::Boolean, 2, 1.0), set(Type::Real, 0, 1.0)]);
    assert_eq!(controller.events, [(20.0, set(Type::Real, 0, 4.0)), (30.0, set(Type::Real, 0, 5.0))]);
    assert_eq!(plan.members[1].inputs, [set(Type::Integer, 0, 3.0)]);
    assert_eq!(plan.warnings, [""; 0]);
}

#[test]
fn values_outside_the_declared_range_are_set_with_a_warning() {
    let plan = plan(&system(&[], &["P.POWER=120", "C.CYCLE=0"])).unwrap();
    assert_eq!(
        plan.warnings,
        [
            "P.POWER = 120.0 is outside the range declared by the FMU, 0.0 to 100.0",
            "C.CYCLE = 0.0 is outside the range declared by the FMU, 0.001 to ..."
        ]
    );
    assert_eq!(plan.members[1].inputs[0].value, 120.0);
}

#[test]
fn the_step_that_is_proposed_is_the_cycle_that_is_set() {
    let proposed = |settings: &[&str]| {
        let plan = plan(&system(&[], settings)).unwrap();
        (plan.step, plan.step_proposed_by)
    };
    assert_eq!(proposed(&["C.CYCLE=0.05"]), (0.05, Some(0)));
    // A setting takes precedence over a parameter file.
    let mut own = system(&[], &["C.CYCLE=0.02", "C.CYCLE=0.05"]);
    own.settings[0].is_preliminary = true;
    assert_eq!(plan(&own).unwrap().step, 0.05);
    assert_eq!(plan(&System { step: Some(0.5), ..system(&[], &["C.CYCLE=0.05"]) }).unwrap().step, 0.5);
}

#[test]
fn a_time_is_the_number_that_is_the_nearest_to_the_decimal_one() {
    let time = |start, step: f64, steps| {
        plan(&System { start: Some(start), step: Some(step), stop: Some(1000.0), ..system(&[], &[]) })
            .unwrap()
            .time(steps)
    };
    assert_eq!(time(0.0, 0.2, 2999), 599.8);
    assert_ne!(2999.0 * 0.2, 599.8);
    assert_eq!(time(-0.3, 0.1, 6), 0.3);
    // One third has no finite decimal form.
    assert_eq!(time(0.0, 1.0 / 3.0, 100), 100.0 * (1.0 / 3.0));
}

#[test]
fn a_value_that_its_type_cannot_have_is_refused() {
    for (setting, expected) in [
        ("C.ON=2", "C.ON cannot be set: it is Boolean; 2.0 is neither true (1) nor false (0)"),
        ("C.SP=true", "C.SP cannot be set: it is Real; true is not a number"),
        ("C.PV_PER=1.5", "C.PV_PER cannot be set: it is Integer; 1.5 is not a 32-bit integer"),
        ("C.PV_PER=3e9", "C.PV_PER cannot be set: it is Integer; 3000000000.0 is not a 32-bit integer"),
        ("P.NAME=1", "P.NAME is a String, which cannot be set or recorded"),
    ] {
        assert_eq!(error(&system(&[], &[setting])), expected);
    }
}

#[test]
fn only_inputs_and_parameters_can_be_set_and_only_when_they_may_change() {
    assert!(error(&system(&[], &["C.LMN=1"])).starts_with("C.LMN cannot be set: its causality is output"));
    assert!(error(&system(&LOOP, &["P.POWER=1"])).ends_with("it is connected to C.LMN"));
    assert_eq!(
        error(&system(&[], &["C.CYCLE=1@20"])),
        "C.CYCLE cannot be set at 20.0 s: it is a fixed parameter; during a run, only inputs and tunable parameters \
         can be set"
    );
    assert!(plan(&system(&[], &["C.GAIN=1@20"])).is_ok());
    assert!(error(&system(&[], &["C.SP=1@20", "C.SP=2@20"])).contains("set twice"));
    assert!(plan(&system(&[], &["C.SP=1", "C.SP=2@20"])).is_ok());
}

#[test]
fn a_time_has_to_be_within_the_run() {
    let mut system = system(&[], &["C.SP=1@9"]);
    (system.start, system.stop, system.step) = (Some(0.0), Some(10.0), Some(1.0));
    assert!(plan(&system).is_ok());
    for time in [-1.0, 9.5, 10.0] {
        system.settings[0].time = Some(time);
        let expected = format!("C.SP cannot be set at {time:?} s: the first step begins at 0.0 s, the last at 9.0 s");
        assert_eq!(error(&system), expected);
    }
}

#[test]
fn an_integer_goes_to_a_real_and_nothing_else_to_another_type() {
    assert!(plan(&system(&["P.T_PER=C.SP"], &[])).is_ok());
    assert_eq!(
        error(&system(&["C.HIGH=P.POWER"], &[])),
        "C.HIGH cannot be connected to P.POWER: it is Boolean, but the input is Real: connect a Real output of the \
         same FMU, such as a mean over the step (available: LMN)"
    );
    for connection in ["P.TEMP=C.PV_PER", "C.HIGH=C.PV_PER", "P.T_PER=C.ON", "P.TEMP=C.ON"] {
        assert!(error(&system(&[connection], &[])).contains(", but the input is "), "{connection}");
    }
}

#[test]
fn units_have_to_be_the_same_where_both_ends_have_one() {
    assert_eq!(
        error(&system(&["P.TEMP=P.POWER"], &[])),
        "P.TEMP cannot be connected to P.POWER: it is in degC, but the input is in %: values are not converted"
    );
    assert!(plan(&system(&["P.TEMP=C.SP"], &[])).is_ok());
}

#[test]
fn a_connection_goes_from_an_output_to_an_input_that_has_no_other() {
    assert!(error(&system(&["C.GAIN=P.POWER"], &[])).contains("the causality of C.GAIN is parameter"));
    assert!(error(&system(&["P.TEMP=C.LMN"], &[])).contains("the causality of C.LMN is output"));
    assert_eq!(
        error(&system(&["P.T_PER=C.SP", "C.LMN=C.SP"], &[])),
        "C.SP has two sources, P.T_PER and C.LMN: remove one of the connections"
    );
    assert_eq!(
        error(&system(&["C.LMN=P.POWER", "C.LMN=P.POWER"], &[])),
        "C.LMN and P.POWER are connected twice: remove one of the connections"
    );
}

#[test]
fn a_wrong_name_says_what_is_near() {
    for (name, expected) in [
        ("C.LMM", "C has no variable LMM; did you mean C.LMN?"),
        ("C.state.sum", "C has no variable state.sum; did you mean C.STATE.SUM?"),
        ("C.XYZXYZ", "C has no variable XYZXYZ; plcfmu info lists its variables"),
        ("SP", "SP does not name its FMU: write C.SP"),
        (
            "c.LMN",
            "c.LMN does not name an FMU of this run: write FMU.VARIABLE, where FMU is one of C, P; did you mean C?",
        ),
        ("FURNACE.TEMP", "FURNACE.TEMP does not name an FMU of this run: write FMU.VARIABLE, where FMU is one of C, P"),
    ] {
        let system = System { record: vec![name.into()], ..system(&[], &[]) };
        assert_eq!(error(&system), expected);
    }
}

#[test]
fn the_longest_name_of_an_fmu_decides() {
    let mut system = system(&[], &[]);
    system.members[1].name = "C.LMN".into();
    system.record = vec!["C.LMN.TEMP".into(), "C.LMN".into()];
    let plan = plan(&system).unwrap();
    let sources: Vec<_> = plan.columns.iter().map(|column| column.source.0).collect();
    assert_eq!(sources, [1, 0]);
}

#[test]
fn two_fmus_of_one_name_are_refused() {
    let mut system = system(&[], &[]);
    system.members[1].name = "C".into();
    assert_eq!(error(&system), "two FMUs are named C: rename one with NAME=P.fmu");
}

#[test]
fn the_times_are_those_that_the_fmus_propose_unless_told_otherwise() {
    let plan = |system: &System| plan(system).map(|plan| (plan.start, plan.step, plan.step_proposed_by, plan.steps));
    let mut system = system(&[], &[]);
    assert_eq!(plan(&system).unwrap(), (0.0, 0.1, Some(1), 900));
    (system.start, system.stop, system.step) = (Some(-1.0), Some(1.0), Some(0.5));
    assert_eq!(plan(&system).unwrap(), (-1.0, 0.5, None, 4));
    // The last whole step, regardless of rounding errors.
    (system.start, system.stop, system.step) = (Some(0.0), Some(0.3), Some(0.1));
    assert_eq!(plan(&system).unwrap().3, 3);
    system.stop = Some(0.39);
    assert_eq!(plan(&system).unwrap().3, 3);
}

#[test]
fn times_that_make_no_run_are_refused() {
    let mut system = system(&[], &[]);
    for (start, stop, step, expected) in [
        (0.0, 10.0, 0.0, "the communication step is 0.0 s"),
        (0.0, 10.0, -1.0, "the communication step is -1.0 s"),
        (0.0, 10.0, f64::NAN, "the communication step is NaN s"),
        (0.0, f64::INFINITY, 1.0, "both must be finite"),
        (0.0, 0.5, 1.0, "is shorter than one communication step of 1.0 s"),
        (5.0, 0.0, 1.0, "is shorter than one communication step of 1.0 s"),
        (1e9, 2e9, 1e-9, "is too small for a run"),
    ] {
        (system.start, system.stop, system.step) = (Some(start), Some(stop), Some(step));
        assert!(error(&system).contains(expected), "{}", error(&system));
    }
}

#[test]
fn an_fmu_that_proposes_no_times_asks_for_them() {
    let silent = description(Vec::new(), None);
    let mut system = System { members: vec![Member { name: "C".into(), path: "C.fmu".into() }], ..System::default() };
    let error = |system: &System| format!("{:#}", Plan::new(system, &[&silent]).unwrap_err());
    assert_eq!(error(&system), "no FMU proposes a communication step: specify one, such as step = 0.1");
    system.step = Some(1.0);
    assert_eq!(error(&system), "no FMU proposes a stop time: specify one, such as stop = 60");
    system.stop = Some(1.0);
    assert_eq!(Plan::new(&system, &[&silent]).unwrap().start, 0.0);
}

#[test]
fn a_value_of_a_parameter_file_gives_way_to_a_connection_and_to_a_setting() {
    let mut system = system(&LOOP, &["C.GAIN=2", "C.GAIN=3", "C.PV_PER=5", "C.SP=1"]);
    for place in [0, 2, 3] {
        system.settings[place].is_preliminary = true;
    }
    let plan = plan(&system).unwrap();
    assert_eq!(plan.members[0].parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [3.0]);
    assert_eq!(plan.members[0].inputs.iter().map(|of| of.value).collect::<Vec<_>>(), [1.0]);
    // A file contains a value for every input, but that does not make each a column.
    assert!(!plan.columns.iter().any(|column| column.name == "C.SP"));
}

#[test]
fn an_error_names_the_place_in_the_file() {
    let place = |line| Some(FilePosition { file: "loop.toml".into(), line, column: 3 });
    let mut wrong = system(&LOOP, &["C.GAIM=2"]);
    wrong.settings[0].place = place(7);
    assert_eq!(error(&wrong), "loop.toml:7:3: C has no variable GAIM; did you mean C.GAIN?");
    let mut wrong = system(&["C.HIGH=P.POWER"], &[]);
    wrong.connections[0].place = place(8);
    assert!(error(&wrong).starts_with("loop.toml:8:3: C.HIGH cannot be connected to P.POWER: it is Boolean"));
    let mut wrong = system(&[], &[]);
    wrong.record = vec![Recorded { variable: "C.X".into(), place: place(9) }];
    assert!(error(&wrong).starts_with("loop.toml:9:3: C has no variable X"));
}
