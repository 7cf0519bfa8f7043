use super::*;
use crate::component::Update;
use crate::plan::TypedBatch;
use std::cell::RefCell;
use std::rc::Rc;

/// Reals by value reference. A step adds `INPUT` (1) to `OUTPUT` (0); `PARAMETER` (2) is added at initialization.
const OUTPUT: u32 = 0;
const INPUT: u32 = 1;
const PARAMETER: u32 = 2;

/// A component that logs the calls it receives.
struct Sum {
    name: &'static str,
    values: [f64; 3],
    log: Rc<RefCell<Vec<String>>>,
    fails_at: f64,
    /// Whether it ends the simulation at `fails_at`, which is not a failure.
    ends: bool,
    /// Whether its output follows its input immediately.
    passes_on: bool,
}

impl Sum {
    fn note(&self, what: &str) {
        self.log.borrow_mut().push(format!("{} {what}", self.name));
    }
}

impl Component for Sum {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.note(&format!("setup {start} {}", stop.unwrap()));
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.values[OUTPUT as usize] = self.values[PARAMETER as usize];
        self.note("enter");
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.note("exit");
        Ok(())
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        assert_eq!(kind, Type::Real);
        for (value, reference) in values.iter_mut().zip(references) {
            *value = self.values[*reference as usize];
        }
        Ok(())
    }

    fn write(&mut self, _: Type, references: &[u32], values: &[f64]) -> Result<()> {
        for (value, reference) in values.iter().zip(references) {
            self.values[*reference as usize] = *value;
            if self.passes_on && *reference == INPUT {
                self.values[OUTPUT as usize] = *value;
            }
            self.note(&format!("{reference} = {value}"));
        }
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        if time == self.fails_at && self.ends {
            bail!(Terminated);
        }
        if time == self.fails_at {
            bail!("it refuses: no more");
        }
        self.values[OUTPUT as usize] += self.values[INPUT as usize];
        self.note(&format!("step {time} {size}"));
        Ok(())
    }

    fn terminate(&mut self) -> Result<()> {
        self.note("terminate");
        Ok(())
    }
}

/// Counts of this many Reals and no other types.
fn counts(reals: usize) -> [usize; Type::ALL.len()] {
    let mut counts = [0; Type::ALL.len()];
    counts[0] = reals;
    counts
}

fn real(reference: u32, value: f64) -> Assignment {
    Assignment { kind: Type::Real, reference, value }
}

/// A member whose input is connected to the output of `from`.
fn member(name: &str, from: usize, start: f64) -> MemberPlan {
    MemberPlan {
        name: name.into(),
        parameters: vec![real(PARAMETER, start)],
        connected: TypedBatch { references: vec![INPUT], counts: counts(1) },
        sources: vec![(from, 0)],
        outputs: TypedBatch { references: vec![OUTPUT], counts: counts(1) },
        output_places: vec![0],
        observed: TypedBatch { references: vec![OUTPUT, INPUT], counts: counts(2) },
        ..MemberPlan::default()
    }
}

fn column(name: &str, source: (usize, usize), is_before_step: bool) -> Column {
    Column {
        name: name.into(),
        unit: None,
        kind: Type::Real,
        is_input: name.ends_with(".IN"),
        source,
        is_before_step,
        is_unread: false,
    }
}

/// Members A and B in a ring, A first; A begins with 1 and B with 10.
fn ring(exchange: Exchange) -> Plan {
    Plan {
        start: 0.0,
        step: 0.5,
        step_proposed_by: None,
        scale: None,
        steps: 2,
        exchange,
        members: vec![member("A", 1, 1.0), member("B", 0, 10.0)],
        columns: vec![
            column("A.IN", (0, 1), false),
            column("A.OUT", (0, 0), exchange == Exchange::Parallel),
            column("B.IN", (1, 1), false),
            column("B.OUT", (1, 0), true),
        ],
        warnings: Vec::new(),
    }
}

fn run_it(plan: &Plan, fails_at: f64) -> (Result<Recording>, Vec<String>) {
    let log = Rc::default();
    let component =
        |name| Sum { name, values: [0.0; 3], log: Rc::clone(&log), fails_at, ends: false, passes_on: false };
    let result = run(plan, &mut [component("A"), component("B")], |_| {});
    (result, log.take())
}

fn rows(recording: &Recording) -> Vec<(f64, Vec<f64>)> {
    recording.rows().map(|(time, row)| (time, row.to_vec())).collect()
}

#[test]
fn an_fmu_gets_what_those_before_it_have_given_in_the_same_step() {
    let (recording, _) = run_it(&ring(Exchange::Sequential), f64::NAN);
    // A: 1 + 10 = 11; B: 10 + 11 = 21. A: 11 + 21 = 32; B: 21 + 32 = 53. B's output is as A reads it.
    // At the end A would read 53.
    let expected =
        [(0.0, vec![10.0, 11.0, 11.0, 10.0]), (0.5, vec![21.0, 32.0, 32.0, 21.0]), (1.0, vec![53.0, 32.0, 32.0, 53.0])];
    assert_eq!(rows(&recording.unwrap()), expected);
}

#[test]
fn in_parallel_all_get_what_was_given_in_the_last_step() {
    let (recording, _) = run_it(&ring(Exchange::Parallel), f64::NAN);
    // A: 1 + 10 = 11; B: 10 + 1 = 11. A: 11 + 11 = 22; B: 11 + 11 = 22. Both outputs are as the other reads them.
    let expected =
        [(0.0, vec![10.0, 1.0, 1.0, 10.0]), (0.5, vec![11.0, 11.0, 11.0, 11.0]), (1.0, vec![22.0, 22.0, 22.0, 22.0])];
    assert_eq!(rows(&recording.unwrap()), expected);
}

#[test]
fn a_start_value_goes_through_a_chain_in_whatever_order_it_is() {
    // A's 7 goes to D, from there to B and to C, which is first: it would take three passes.
    let names = ["C", "B", "D", "A"];
    let mut members: Vec<_> = (1..=3).map(|from| member(names[from - 1], from, 0.0)).collect();
    members.push(MemberPlan { connected: TypedBatch::default(), sources: Vec::new(), ..member("A", 0, 7.0) });
    let first = |exchange| {
        let columns = vec![column("C.IN", (0, 1), false)];
        let plan = Plan { members: members.clone(), columns, ..ring(exchange) };
        let component = |name| Sum {
            name,
            values: [0.0; 3],
            log: Rc::default(),
            fails_at: f64::NAN,
            ends: false,
            passes_on: name != "A",
        };
        let recording = run(&plan, &mut names.map(component), |_| {}).unwrap();
        rows(&recording)[0].1[0]
    };
    assert_eq!((first(Exchange::Sequential), first(Exchange::Parallel)), (7.0, 0.0));
}

#[test]
fn in_each_row_a_connected_input_is_the_output_that_it_is_connected_to() {
    for exchange in [Exchange::Sequential, Exchange::Parallel] {
        for (_, row) in run_it(&ring(exchange), f64::NAN).0.unwrap().rows() {
            assert_eq!((row[0], row[2]), (row[3], row[1]), "{exchange:?}");
        }
    }
}

#[test]
fn the_calls_come_in_the_order_of_the_standard() {
    let mut plan = ring(Exchange::Sequential);
    plan.steps = 1;
    plan.members[1].inputs = vec![real(INPUT, 7.0)];
    let (recording, log) = run_it(&plan, f64::NAN);
    recording.unwrap();
    let expected = "\
A setup 0 0.5; A 2 = 1; A enter; B setup 0 0.5; B 2 = 10; B enter; B 1 = 7; A 1 = 10; B 1 = 1; A exit; B exit; \
A 1 = 10; A step 0 0.5; B 1 = 11; B step 0 0.5; A terminate; B terminate";
    assert_eq!(log.join("; "), expected);
}

#[test]
fn an_event_comes_at_the_first_communication_point_that_is_not_earlier() {
    for (at, expected) in [(0.0, "0"), (0.3, "0.5"), (0.5, "0.5"), (0.5 + 1e-9, "0.5"), (0.51, "1"), (1.5, "1.5")] {
        let mut plan = ring(Exchange::Sequential);
        plan.steps = 4;
        plan.members[0].events = vec![(at, real(PARAMETER, 99.0))];
        let (_, log) = run_it(&plan, f64::NAN);
        let set = log.iter().position(|line| line == "A 2 = 99").unwrap();
        let step = log[set..].iter().find(|line| line.contains("step")).unwrap();
        assert_eq!(*step, format!("A step {expected} 0.5"), "{at}");
    }
}

#[test]
fn an_output_that_no_fmu_reads_stands_at_its_time() {
    let alone = MemberPlan {
        connected: TypedBatch::default(),
        sources: Vec::new(),
        outputs: TypedBatch::default(),
        output_places: Vec::new(),
        inputs: vec![real(INPUT, 10.0)],
        ..member("A", 0, 1.0)
    };
    let columns = vec![Column { is_unread: true, ..column("A.OUT", (0, 0), false) }];
    let plan = Plan { members: vec![alone], columns, ..ring(Exchange::Sequential) };
    let component =
        || Sum { name: "A", values: [0.0; 3], log: Rc::default(), fails_at: f64::NAN, ends: false, passes_on: false };
    let recording = run(&plan, &mut [component()], |_| {}).unwrap();
    assert_eq!(rows(&recording), [(0.0, vec![1.0]), (0.5, vec![11.0]), (1.0, vec![21.0])]);
    // The row of a call holds the results of the call.
    let mut calls = Run::begin(&plan, vec![component()], Some(1.0)).unwrap();
    calls.step(&plan).unwrap();
    assert_eq!((calls.time(), calls.row()), (0.0, &[11.0][..]));
}

#[test]
fn the_row_of_a_step_that_is_ended_has_what_was_there_before_it() {
    let component =
        |name| Sum { name, values: [0.0; 3], log: Rc::default(), fails_at: 0.5, ends: true, passes_on: false };
    let recording = run(&ring(Exchange::Parallel), &mut [component("A"), component("B")], |_| {}).unwrap();
    // After the first step both outputs are 11; no inputs were recorded in the second one.
    let expected = [(0.0, vec![10.0, 1.0, 1.0, 10.0]), (0.5, vec![10.0, 11.0, 1.0, 11.0])];
    assert_eq!(rows(&recording), expected);
    assert_eq!(recording.ended.unwrap(), "A: the FMU ended the simulation");
}

#[test]
fn the_times_do_not_add_up() {
    let plan = Plan { step: 0.1, steps: 1000, ..ring(Exchange::Sequential) };
    let recording = run_it(&plan, f64::NAN).0.unwrap();
    assert!(recording.times.iter().enumerate().all(|(step, time)| *time == step as f64 * 0.1));
}

#[test]
fn an_error_says_which_fmu_fails() {
    let (result, log) = run_it(&ring(Exchange::Sequential), 0.5);
    assert_eq!(format!("{:#}", result.unwrap_err()), "A: it refuses: no more");
    // The standard forbids termination after an error.
    assert!(!log.iter().any(|line| line.contains("terminate")), "{log:?}");
}

#[test]
fn a_recording_that_does_not_fit_into_the_memory_is_refused() {
    let plan = Plan { steps: usize::MAX / 16, ..ring(Exchange::Sequential) };
    let error = run_it(&plan, f64::NAN).0.unwrap_err().to_string();
    assert!(
        error.ends_with("steps of 4 variables do not fit into memory: record fewer variables, or use longer steps")
    );
}

#[test]
fn progress_is_told_after_each_step() {
    let log = Rc::default();
    let component =
        |name| Sum { name, values: [0.0; 3], log: Rc::clone(&log), fails_at: f64::NAN, ends: false, passes_on: false };
    let mut told = Vec::new();
    run(&ring(Exchange::Sequential), &mut [component("A"), component("B")], |done| told.push(done)).unwrap();
    assert_eq!(told, [1, 2]);
}

#[test]
fn csv_reads_back_bit_equal_and_quotes_odd_names() {
    let mut columns = vec![column("A.x,\"y\"", (0, 0), false), column("A.n", (0, 1), false)];
    columns.push(column("A.on", (0, 2), false));
    columns[1].kind = Type::Integer;
    columns[2].kind = Type::Boolean;
    let values = vec![0.1 + 0.2, -3.0, 1.0, 1e-300, 27648.0, 0.0];
    let mut csv = Vec::new();
    Recording { columns, times: vec![0.0, 0.1], values, ended: None }.write_csv(&mut csv).unwrap();
    let expected = "time,\"A.x,\"\"y\"\"\",A.n,A.on\n0.0,0.30000000000000004,-3,1\n0.1,1e-300,27648,0\n";
    assert_eq!(String::from_utf8(csv).unwrap(), expected);
}

#[test]
fn a_thinned_recording_keeps_the_least_and_the_greatest_value_in_their_order() {
    let columns = vec![column("A", (0, 0), false), column("B", (0, 1), false)];
    let thinned = |most: usize| {
        let mut thinned = Thinned::new(columns.clone(), 7, most);
        for (step, a) in [3.0, 9.0, 1.0, 5.0, 5.0, 5.0, 2.0].into_iter().enumerate() {
            thinned.push(step as f64, &[a, step as f64]);
        }
        let recording = thinned.recording();
        recording.rows().map(|(time, row)| (time, row[0], row[1])).collect::<Vec<_>>()
    };
    assert_eq!(thinned(7).len(), 7);
    // Four rows become two each; the last three as well.
    assert_eq!(thinned(4), [(0.0, 9.0, 0.0), (3.0, 1.0, 3.0), (4.0, 5.0, 4.0), (6.0, 2.0, 6.0)]);
}

/// A controller in Event Mode that is called every half second, and then outputs half the distance of its `INPUT` from
/// 8.
#[derive(Default)]
struct Sampled {
    values: [f64; 3],
    now: f64,
    was_called: bool,
}

impl Component for Sampled {
    fn setup(&mut self, start: f64, _: Option<f64>) -> Result<()> {
        self.now = start;
        Ok(())
    }

    fn enter_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn read(&mut self, _: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        values.iter_mut().zip(references).for_each(|(value, reference)| *value = self.values[*reference as usize]);
        Ok(())
    }

    fn write(&mut self, _: Type, references: &[u32], values: &[f64]) -> Result<()> {
        values.iter().zip(references).for_each(|(value, reference)| self.values[*reference as usize] = *value);
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        (self.now, self.was_called) = (time + size, false);
        Ok(())
    }

    fn enter_events(&mut self) -> Result<()> {
        Ok(())
    }

    fn update(&mut self) -> Result<Update> {
        if !std::mem::replace(&mut self.was_called, true) {
            self.values[OUTPUT as usize] = (8.0 - self.values[INPUT as usize]) / 2.0;
        }
        Ok(Update { is_needed: false, next: Some(self.now + 0.5) })
    }

    fn leave_events(&mut self) -> Result<()> {
        Ok(())
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

/// A plant without Event Mode, which begins with 1, before a controller with Event Mode.
fn plant_first() -> (Plan, Vec<Box<dyn Component>>) {
    let plan = Plan {
        members: vec![member("P", 1, 1.0), MemberPlan { has_events: true, ..member("S", 0, 0.0) }],
        columns: vec![
            column("P.OUT", (0, 0), false),
            column("S.IN", (1, 1), false),
            column("S.OUT", (1, 0), true),
            column("P.IN", (0, 1), false),
        ],
        ..ring(Exchange::Sequential)
    };
    let log = Rc::default();
    let plant = Sum { name: "P", values: [0.0; 3], log, fails_at: f64::NAN, ends: false, passes_on: false };
    (plan, vec![Box::new(plant), Box::<Sampled>::default()])
}

#[test]
fn what_an_fmu_is_called_with_in_event_mode_is_recorded_at_the_output_and_at_the_input() {
    let (plan, mut components) = plant_first();
    let recording = run(&plan, &mut components, |_| {}).unwrap();
    // From the plant's 1, the controller computes 3.5; from 1 + 3.5 it computes 1.75.
    let expected =
        [(0.0, vec![1.0, 1.0, 3.5, 3.5]), (0.5, vec![4.5, 4.5, 1.75, 1.75]), (1.0, vec![6.25, 6.25, 1.75, 1.75])];
    assert_eq!(rows(&recording), expected);
}

#[test]
fn after_an_exchange_it_is_recorded_so_too() {
    let (plan, components) = plant_first();
    let mut run = Run::begin(&plan, components, Some(5.0)).unwrap();
    run.step(&plan).unwrap();
    assert_eq!(run.row(), [1.0, 1.0, 3.5, 3.5]);
    run.exchange(&plan, vec![Box::<Sampled>::default()]).unwrap();
    run.step(&plan).unwrap();
    assert_eq!(run.row(), [4.5, 4.5, 1.75, 1.75]);
}
