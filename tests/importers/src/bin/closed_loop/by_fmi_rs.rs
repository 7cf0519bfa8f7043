//! The crate `fmi-rs`.

use super::{Kind, Slave, Variable, boolean, integer, real, real_value};
use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::{fmi2Status, fmi2True};
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::{Causality, VariableType};
use importers::packed;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

pub struct ByFmiRs {
    instance: Arc<FMU2<CS>>,
    // After the instance: it has unpacked the library, and removes it when dropped.
    fmu: FMU2Builder,
}

impl ByFmiRs {
    pub fn new(name: &str) -> ByFmiRs {
        let fmu = FMU2Builder::new(&packed(name)).unwrap().loggingOn(true);
        ByFmiRs { instance: fmu.instantiate_cs(name).unwrap(), fmu }
    }
}

impl Slave for ByFmiRs {
    fn variables(&self) -> BTreeMap<String, Variable> {
        let variables = self.fmu.model_description.modelVariables.iter();
        variables
            .map(|variable| {
                let kind = match variable.variableType {
                    VariableType::Real { .. } => Kind::Real,
                    VariableType::Integer { .. } => Kind::Integer,
                    VariableType::Boolean { .. } => Kind::Boolean,
                    _ => panic!("{}: the FMUs have no such type", variable.name),
                };
                let is_output = variable.causality == Causality::Output;
                (variable.name.clone(), Variable { reference: variable.valueReference, kind, is_output })
            })
            .collect()
    }

    fn set(&mut self, variable: &Variable, value: &Value) {
        let references = &[variable.reference];
        ok(match variable.kind {
            Kind::Real => self.instance.setReal(references, &[real(value)]),
            Kind::Integer => self.instance.setInteger(references, &[integer(value)]),
            Kind::Boolean => self.instance.setBoolean(references, &[boolean(value)]),
        });
    }

    fn get(&mut self, variable: &Variable) -> Value {
        let references = &[variable.reference];
        let (mut real, mut whole) = ([0.0], [0]);
        ok(match variable.kind {
            Kind::Real => self.instance.getReal(references, &mut real),
            Kind::Integer => self.instance.getInteger(references, &mut whole),
            Kind::Boolean => self.instance.getBoolean(references, &mut whole),
        });
        match variable.kind {
            Kind::Real => real_value(real[0]),
            Kind::Integer => json!(whole[0]),
            Kind::Boolean => json!(whole[0] != 0),
        }
    }

    fn initialize(&mut self) {
        ok(self.instance.setupExperiment(None, 0.0, None));
        ok(self.instance.enterInitializationMode());
        ok(self.instance.exitInitializationMode());
    }

    fn step(&mut self, time: f64, step: f64) {
        ok(self.instance.doStep(time, step, fmi2True));
    }
}

fn ok(status: fmi2Status) {
    assert!(status == fmi2Status::Ok, "{status:?}");
}
