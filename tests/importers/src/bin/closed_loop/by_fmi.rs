//! The crate `fmi` (rust-fmi).

use super::{Kind, Slave, Variable, boolean, integer, real, real_value};
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::{Causality, ScalarVariableElement};
use fmi::traits::FmiImport;
use importers::packed;
use serde_json::{Value, json};
use std::collections::BTreeMap;

pub struct ByFmi {
    instance: InstanceCS,
    // After the instance: it has unpacked the library, and removes it when dropped.
    fmu: Fmi2Import,
}

impl ByFmi {
    pub fn new(name: &str) -> ByFmi {
        let fmu: Fmi2Import = fmi::import::from_path(packed(name)).unwrap();
        ByFmi { instance: fmu.instantiate_cs(name, false, true).unwrap(), fmu }
    }
}

impl Slave for ByFmi {
    fn variables(&self) -> BTreeMap<String, Variable> {
        let variables = self.fmu.model_description().model_variables.variables.iter();
        variables
            .map(|variable| {
                let kind = match variable.elem {
                    ScalarVariableElement::Real(_) => Kind::Real,
                    ScalarVariableElement::Integer(_) => Kind::Integer,
                    ScalarVariableElement::Boolean(_) => Kind::Boolean,
                    _ => panic!("{}: the FMUs have no such type", variable.name),
                };
                let is_output = variable.causality == Causality::Output;
                (variable.name.clone(), Variable { reference: variable.value_reference, kind, is_output })
            })
            .collect()
    }

    fn set(&mut self, variable: &Variable, value: &Value) {
        let references = &[variable.reference];
        match variable.kind {
            Kind::Real => self.instance.set_real(references, &[real(value)]),
            Kind::Integer => self.instance.set_integer(references, &[integer(value)]),
            Kind::Boolean => self.instance.set_boolean(references, &[boolean(value)]),
        }
        .unwrap();
    }

    fn get(&mut self, variable: &Variable) -> Value {
        let references = &[variable.reference];
        let (mut real, mut whole) = ([0.0], [0]);
        match variable.kind {
            Kind::Real => self.instance.get_real(references, &mut real),
            Kind::Integer => self.instance.get_integer(references, &mut whole),
            Kind::Boolean => self.instance.get_boolean(references, &mut whole),
        }
        .unwrap();
        match variable.kind {
            Kind::Real => real_value(real[0]),
            Kind::Integer => json!(whole[0]),
            Kind::Boolean => json!(whole[0] != 0),
        }
    }

    fn initialize(&mut self) {
        self.instance.setup_experiment(None, 0.0, None).unwrap();
        self.instance.enter_initialization_mode().unwrap();
        self.instance.exit_initialization_mode().unwrap();
    }

    fn step(&mut self, time: f64, step: f64) {
        self.instance.do_step(time, step, true).unwrap();
    }
}
