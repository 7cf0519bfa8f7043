//! The block diagrams in the documentation of the blocks: complete, and those of plants compute what the laws do.

#![allow(clippy::unwrap_used)]

use blocks::table::number;
use blocks::{Block, EachBlock, Law, Role, for_each_block};
use draw::diagram;
use draw::diagram::net::{self, Link};
use modeldescription::Table;
use plants::{Drive, Heater, Process, Sensor, Tank, Thermo, Valve};
use std::collections::BTreeSet;

/// The tables of the blocks that have a diagram, as their libraries tell them.
fn tables() -> Vec<Table> {
    struct Tables(Vec<Table>);
    impl EachBlock for Tables {
        fn block<B: Block>(&mut self) {
            self.0.push(Table::from(B::TABLE));
        }
    }
    let mut tables = Tables(Vec::new());
    for_each_block(&mut tables);
    let tables: Vec<Table> = tables.0.into_iter().filter(|table| diagram::find(&table.docs).is_some()).collect();
    assert!(tables.len() >= 5);
    tables
}

/// The names in the ids of a drawing that begin with `kind`.
fn names<'a>(drawing: &'a str, kind: &str) -> BTreeSet<&'a str> {
    let ids = drawing.split(" id=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    ids.filter_map(|id| id.strip_prefix(kind)).collect()
}

#[test]
fn a_diagram_shows_every_terminal_of_its_block_and_nothing_else() {
    for table in tables() {
        let drawing = diagram::svg(&table).unwrap_or_else(|error| panic!("{error:#}"));
        let own = table.rows.iter().filter(|row| row.role != Role::Local && !row.name.contains('.'));
        let own: BTreeSet<&str> = own.map(|row| row.name.as_str()).collect();
        assert_eq!(names(&drawing, "terminal-"), own, "{}", table.name);
    }
}

#[test]
fn every_output_has_a_wire_in_which_a_program_can_show_its_value() {
    for table in tables() {
        let drawing = diagram::svg(&table).unwrap();
        let wires = names(&drawing, "wire-");
        for row in table.rows.iter().filter(|row| row.role == Role::Output) {
            assert!(wires.contains(row.name.as_str()), "{} of {}: {wires:?}", row.name, table.name);
            assert!(drawing.contains(&format!(r#"id="value-{}""#, row.name)), "{} of {}", row.name, table.name);
        }
    }
}

#[test]
fn a_block_is_drawn_alike_each_time() {
    for table in tables() {
        assert_eq!(diagram::svg(&table).unwrap(), diagram::svg(&table).unwrap());
        assert_eq!(diagram::icon::svg(&table).unwrap(), diagram::icon::svg(&table).unwrap());
    }
}

/// What a box does, by its name and the side where the value leaves it: of the values that come in, by side.
type Boxes<B> = fn(&Plant<B>, &str, &dyn Fn(&str) -> f64) -> f64;

/// A plant at some moment, and its diagram: what the boxes compute is compared with what the law does.
struct Plant<B: Block> {
    block: B,
    links: Vec<Link>,
    boxes: Boxes<B>,
}

impl<B: Block> Plant<B> {
    fn new(set: &[(&str, f64)], boxes: Boxes<B>) -> Plant<B> {
        let links = net::links(&Table::from(B::TABLE)).unwrap();
        let mut plant = Plant { block: B::default(), links, boxes };
        plant.set(set);
        plant.block.restart();
        plant
    }

    fn set(&mut self, values: &[(&str, f64)]) {
        for (name, value) in values {
            let row = B::TABLE.find(name).unwrap_or_else(|| panic!("{name}"));
            let value = number::to_value(*value, B::TABLE.rows[row].kind).unwrap();
            assert!(self.block.set(row, value), "{name}");
        }
    }

    fn value(&self, name: &str) -> f64 {
        let row = B::TABLE.find(name).unwrap_or_else(|| panic!("{name}"));
        number::number(self.block.get(row).unwrap())
    }

    /// What comes into an element at this side, by the diagram. A variable of the block has the value of the law.
    fn entering(&self, element: &str, side: &str) -> f64 {
        let mut links = self.links.iter().filter(|link| link.to == element && link.enters == Some(side));
        let link = links.next().unwrap_or_else(|| panic!("nothing enters {element} at its {side}"));
        assert!(links.next().is_none(), "two wires enter {element} at its {side}");
        let value = self.out_of(&link.from);
        if link.is_negative { -value } else { value }
    }

    fn out_of(&self, element: &str) -> f64 {
        if self.is_a("input", element) {
            return self.value(element);
        }
        if self.is_a("sum", element) {
            let sides = self.links.iter().filter(|link| link.to == element).filter_map(|link| link.enters);
            return sides.map(|side| self.entering(element, side)).sum();
        }
        (self.boxes)(self, element, &|side| self.entering(element, side))
    }

    /// The elements whose signals come into an element.
    fn sources(&self, element: &str) -> BTreeSet<&str> {
        self.links.iter().filter(|link| link.to == element).map(|link| link.from.as_str()).collect()
    }

    fn is_a(&self, kind: &str, element: &str) -> bool {
        B::TABLE.docs.lines().any(|line| line.trim().starts_with(&format!("{kind} {element} ")))
    }

    /// The change of an output per second over one call.
    fn slope(&mut self, output: &str) -> f64 {
        let before = self.value(output);
        self.block.call();
        (self.value(output) - before) / f64::from(self.block.cycle().seconds())
    }
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-3 * expected.abs().max(1e-3), "{found} is not {expected}");
}

fn heater(plant: &Plant<Heater>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    match element {
        "LIMIT" => into("left").clamp(0.0, 100.0),
        // POWER has been the same for longer than the delay.
        "DELAY" => into("left"),
        "RISE" => into("left") / 100.0 * value("RISE"),
        "LOSS" => into("right") * (1.0 + into("left") / 100.0 * value("DOOR_LOSS") / 100.0),
        "FURNACE" => value("T_FURN"),
        "SENSOR" => value("TEMP"),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_furnace_computes_what_its_law_does() {
    let mut plant = Plant::new(&[("CYCLE", 0.001), ("POWER", 50.0), ("DELAY_TM", 0.0), ("T_AMB", 12.0)], heater);
    plant.set(&[("DOOR", 80.0)]);
    (0..20_000).for_each(|_| plant.block.call());
    assert!(plant.value("T_FURN") - plant.value("T_AMB") > 20.0);
    let by_diagram = plant.entering("FURNACE", "left") / plant.value("FURN_TM");
    near(plant.slope("T_FURN"), by_diagram);
    let by_diagram = (plant.entering("SENSOR", "left") - plant.value("TEMP")) / plant.value("SENS_TM");
    near(plant.slope("TEMP"), by_diagram);
}

fn drive(plant: &Plant<Drive>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    // Percent of the torque, from a change of the speed per second.
    let torque = 100.0 / (value("N_MAX") / value("ACC_TM"));
    match element {
        "SCALE" => into("left") * value("N_MAX") / 32767.0,
        "CONTROL" => into("left") / value("CTRL_TM") * torque,
        "LIMIT" => into("left").clamp(-value("M_MAX"), value("M_MAX")),
        "INERTIA" => value("SPEED"),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_drive_computes_what_its_law_does() {
    // At a limit of the torque, and within.
    for (setpoint, load) in [(6000.0, 40.0), (60.0, 40.0), (-60.0, 15.0), (0.0, 0.0)] {
        let mut plant = Plant::new(&[("CYCLE", 0.001), ("SP", setpoint), ("LOAD", load), ("ERR_MAX", 1e6)], drive);
        plant.block.call();
        let by_diagram = plant.entering("INERTIA", "left") / 100.0 * plant.value("N_MAX") / plant.value("ACC_TM");
        let found = plant.slope("SPEED");
        assert!((found - by_diagram).abs() <= 0.02 * by_diagram.abs() + 1e-3, "{setpoint}: {found}, {by_diagram}");
        let torque = plant.value("TORQUE");
        assert!((torque - plant.out_of("LIMIT")).abs() <= 0.02 * torque.abs() + 0.01, "{setpoint}: {torque}");
    }
}

/// In m3/s.
const LITRE_PER_MINUTE: f64 = 1e-3 / 60.0;

fn tank(plant: &Plant<Tank>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    match element {
        "LIMIT_V" | "LIMIT_D" => into("left").clamp(0.0, 100.0),
        "INLET" => into("left") / 100.0 * value("FLOW_MAX"),
        "OUTLET" => {
            let opening = value("CD") * value("A_OUT") * into("left") / 100.0;
            opening * (2.0 * 9.81 * into("right")).sqrt() / LITRE_PER_MINUTE
        }
        "TANK" => value("LEVEL"),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_tank_computes_what_its_law_does() {
    let mut plant = Plant::new(&[("CYCLE", 0.001), ("VALVE", 60.0), ("DRAIN", 80.0), ("L_START", 1.2)], tank);
    plant.block.call();
    let by_diagram = plant.entering("TANK", "left") * LITRE_PER_MINUTE / plant.value("AREA");
    near(plant.slope("LEVEL"), by_diagram);
    near(plant.value("INFLOW"), plant.out_of("INLET"));
    near(plant.value("OUTFLOW"), plant.out_of("OUTLET"));
}

fn valve(plant: &Plant<Valve>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    match element {
        "STEM" => value("LMNR"),
        "CURVE" => (value("CURVE").powf(into("left") / 100.0) - 1.0) / (value("CURVE") - 1.0),
        "ROOT" => into("left") * (into("bottom") / value("PRES_NOM")).sqrt(),
        "SCALE" => into("left") * value("FLOW_MAX"),
        "RISE" => into("left") * value("RISE"),
        "EXCHANGER" => value("T_HX"),
        "SENSOR" => value("TEMP"),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_valve_and_its_heat_exchanger_computes_what_its_law_does() {
    let set =
        [("CYCLE", 0.001), ("POS_START", 60.0), ("CURVE", 30.0), ("PRES", 3.0), ("FLOW_MAX", 250.0), ("T_IN", 15.0)];
    let mut plant = Plant::new(&set, valve);
    (0..3000).for_each(|_| plant.block.call());
    near(plant.value("FLOW"), plant.out_of("SCALE"));
    let by_diagram = (plant.entering("EXCHANGER", "left") - plant.value("T_HX")) / plant.value("HX_TM");
    near(plant.slope("T_HX"), by_diagram);
    let by_diagram = (plant.entering("SENSOR", "left") - plant.value("TEMP")) / plant.value("SENS_TM");
    near(plant.slope("TEMP"), by_diagram);
}

fn thermo(plant: &Plant<Thermo>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    match element {
        "DEMAND_H" => {
            assert_eq!(plant.sources(element), BTreeSet::from(["DRIVE", "HEAT"]));
            (100.0 * value("HEAT") + value("DRIVE").max(0.0)).min(100.0)
        }
        "DEMAND_C" => {
            assert_eq!(plant.sources(element), BTreeSet::from(["COOL", "DRIVE"]));
            (100.0 * value("COOL") - value("DRIVE").min(0.0)).min(100.0)
        }
        "HEATER" => value("HEATING"),
        "COOLER" => value("COOLING"),
        "RISE" => into("left") / 100.0 * value("RISE"),
        "DROP" => into("left") / 100.0 * value("DROP"),
        "CHAMBER" => value("TEMP"),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_chamber_computes_what_its_law_does() {
    for (heat, cool, drive) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 40.0), (0.0, 0.0, -40.0), (1.0, 1.0, 30.0)]
    {
        let set = [("CYCLE", 0.001), ("HEAT", heat), ("COOL", cool), ("DRIVE", drive), ("T_AMB", 95.0), ("LOAD", 7.0)];
        let mut plant = Plant::new(&set, thermo);
        (0..4000).for_each(|_| plant.block.call());
        for (output, lag, time) in
            [("HEATING", "HEATER", "HEAT_TM"), ("COOLING", "COOLER", "COOL_TM"), ("TEMP", "CHAMBER", "ZONE_TM")]
        {
            assert_eq!(plant.sources(output), BTreeSet::from([lag]));
            let by_diagram = (plant.entering(lag, "left") - plant.value(output)) / plant.value(time);
            near(plant.slope(output), by_diagram);
        }
    }
}

/// With a T2 of 0, and with a T1 of 0 where it integrates, the process has one state, which PV shows.
fn process(plant: &Plant<Process>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    let state = || value("PV") - value("PV_0");
    let is_integrating = value("INTEG") == 1.0;
    match element {
        // U and LOAD have been the same for longer than the dead time.
        "DEAD" => into("left"),
        "GAIN" => into("left") * value("GAIN"),
        "LAG_1" if is_integrating => into("left"),
        "LAG_1" | "INT" => state(),
        "LAG_2" => into("left"),
        "INTEG" => {
            assert_eq!(plant.sources(element), BTreeSet::from(["INT", "LAG_2"]));
            plant.out_of(if is_integrating { "INT" } else { "LAG_2" })
        }
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_process_computes_what_its_law_does() {
    let set = [("CYCLE", 0.001), ("DEAD_TM", 0.0), ("GAIN", 1.5), ("U_0", 20.0), ("PV_0", 30.0), ("LOAD", -5.0)];
    let mut plant = Plant::new(&set, process);
    plant.set(&[("U", 60.0), ("PV_0", 25.0)]);
    (0..4000).for_each(|_| plant.block.call());
    assert_eq!(plant.sources("PV"), BTreeSet::from(["POINT"]));
    near(plant.value("PV"), plant.out_of("POINT"));
    let by_diagram = (plant.entering("LAG_1", "left") - plant.out_of("LAG_1")) / plant.value("T1");
    near(plant.slope("PV"), by_diagram);

    let mut plant = Plant::new(&[&set[..], &[("INTEG", 1.0), ("T1", 0.0), ("U", 60.0)]].concat(), process);
    near(plant.value("PV"), plant.out_of("POINT"));
    near(plant.slope("PV"), plant.entering("INT", "left"));
}

fn sensor(plant: &Plant<Sensor>, element: &str, into: &dyn Fn(&str) -> f64) -> f64 {
    let value = |name: &str| plant.value(name);
    let (low, span) = (value("RANGE_LO"), value("RANGE_HI") - value("RANGE_LO"));
    match element {
        // The second call of a sensor that makes nothing but noise.
        "GENERATOR" => {
            let mut alone = Sensor { noise: value("NOISE"), seed: 7, steps: 0, ..Sensor::default() };
            alone.restart();
            alone.call();
            alone.call();
            alone.y
        }
        "FILTER" if value("LAG_TM") == 0.0 => into("left"),
        "FILTER" => {
            let before = value("Y");
            before + (1.0 - (-value("CYCLE") / value("LAG_TM")).exp()) * (into("left") - before)
        }
        "STEPS_OF" if value("STEPS") == 0.0 => into("left"),
        "STEPS_OF" => low + ((into("left") - low) / span * value("STEPS")).round() * span / value("STEPS"),
        "ANALOG" => ((into("left") - low) / span * 27648.0).round(),
        other => panic!("{other}"),
    }
}

#[test]
fn the_diagram_of_the_sensor_computes_what_its_law_does() {
    let set = [("SEED", 7.0), ("NOISE", 0.4), ("RANGE_LO", -50.0), ("RANGE_HI", 150.0), ("U", 20.0)];
    for (lag, steps) in [(0.0, 0.0), (0.3, 0.0), (0.0, 500.0)] {
        let mut plant = Plant::new(&[&set[..], &[("LAG_TM", lag), ("STEPS", steps)]].concat(), sensor);
        plant.block.call();
        plant.set(&[("U", 24.0)]);
        let [y, word] = ["STEPS_OF", "ANALOG"].map(|element| plant.out_of(element));
        plant.block.call();
        assert!((plant.value("Y") - y).abs() < 1e-9, "{lag}, {steps}: {y}");
        assert_eq!(plant.value("Y_PER"), word, "{lag}, {steps}");
        assert_eq!(
            (plant.sources("Y"), plant.sources("Y_PER")),
            (BTreeSet::from(["STEPS_OF"]), BTreeSet::from(["ANALOG"]))
        );
    }
}
