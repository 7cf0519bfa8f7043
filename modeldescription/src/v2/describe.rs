//! Derives a description of the FMU from an FMI 2.0 model description, and changes its start values.

use super::description::{
    FMI_VERSION, IntegerAttributes, ModelDescription, RealAttributes, TypeAttributes, Typed, Variable,
};
use crate::description::{self, Description, Support, Type, list};
use std::collections::HashMap;

/// The attributes of type definitions, by name.
type Types<'a> = HashMap<&'a str, &'a TypeAttributes>;

impl ModelDescription {
    /// The description of the FMU, independent of the FMI version.
    pub fn description(&self) -> Description {
        let types: Types = self.type_definitions.iter().map(|of| (of.name.as_str(), &of.attributes)).collect();
        let support =
            |model_identifier: &str, capabilities| Support { model_identifier: model_identifier.into(), capabilities };
        Description {
            fmi_version: FMI_VERSION,
            model_name: self.model_name.clone(),
            guid: self.guid.clone(),
            description: self.description.clone(),
            author: self.author.clone(),
            version: self.version.clone(),
            copyright: self.copyright.clone(),
            license: self.license.clone(),
            generation_tool: self.generation_tool.clone(),
            generation_date_and_time: self.generation_date_and_time.clone(),
            co_simulation: self.co_simulation.as_ref().map(|of| support(&of.model_identifier, list(&of.capabilities))),
            model_exchange: self.model_exchange.as_ref().map(|of| support(&of.model_identifier, list(of))),
            scheduled_execution: None,
            units: self.unit_definitions.clone(),
            log_categories: self.log_categories.clone(),
            default_experiment: self.default_experiment,
            variables: self.model_variables.iter().map(|variable| described(variable, &types)).collect(),
            arrays: Vec::new(),
        }
    }

    /// Sets the start value of the variable at this index, with true as 1, and widens its declared range to include it,
    /// as FMI requires; the blocks accept any value.
    pub(crate) fn set_start(&mut self, place: usize, start: f64) {
        match &mut self.model_variables[place].typed {
            Typed::Real(real) => {
                real.start = Some(start);
                widen(&mut real.attributes.min, &mut real.attributes.max, start);
            }
            Typed::Integer(integer) => {
                // A DWORD becomes the Integer with the same bits.
                let start = start as i64 as i32;
                integer.start = Some(start);
                widen(&mut integer.attributes.min, &mut integer.attributes.max, start);
            }
            Typed::Boolean(boolean) => boolean.start = Some(start != 0.0),
            Typed::String(_) | Typed::Enumeration(_) => {}
        }
    }
}

fn widen<T: PartialOrd + Copy>(min: &mut Option<T>, max: &mut Option<T>, start: T) {
    *min = min.map(|min| if start < min { start } else { min });
    *max = max.map(|max| if start > max { start } else { max });
}

fn described(of: &Variable, types: &Types) -> description::Variable {
    let declared = of.typed.declared_type().and_then(|name| types.get(name).copied());
    let bare = description::Variable {
        name: of.name.clone(),
        value_reference: of.value_reference,
        description: of.description.clone(),
        causality: of.causality,
        variability: of.variability,
        initial: of.initial_or_default(),
        type_name: of.typed.name(),
        ..description::Variable::default()
    };
    let integer = |own: &IntegerAttributes, start: Option<i32>| {
        let of_type = match declared {
            Some(TypeAttributes::Integer(attributes)) => attributes,
            _ => &IntegerAttributes::default(),
        };
        description::Variable {
            kind: Some(Type::Integer),
            min: own.min.or(of_type.min).map(f64::from),
            max: own.max.or(of_type.max).map(f64::from),
            start: start.map(f64::from),
            ..bare.clone()
        }
    };
    match &of.typed {
        Typed::Real(real) => {
            let (own, of_type) = match declared {
                Some(TypeAttributes::Real(attributes)) => (&real.attributes, attributes),
                _ => (&real.attributes, &RealAttributes::default()),
            };
            description::Variable {
                kind: Some(Type::Real),
                unit: own.unit.clone().or_else(|| of_type.unit.clone()),
                display_unit: own.display_unit.clone().or_else(|| of_type.display_unit.clone()),
                min: own.min.or(of_type.min),
                max: own.max.or(of_type.max),
                start: real.start,
                ..bare
            }
        }
        Typed::Integer(of) => integer(&of.attributes, of.start),
        Typed::Enumeration(of) => integer(&of.attributes, of.start),
        Typed::Boolean(of) => description::Variable {
            kind: Some(Type::Boolean),
            start: of.start.map(|start| f64::from(u8::from(start))),
            ..bare
        },
        Typed::String(of) => description::Variable { kind: None, start_text: of.start.clone(), ..bare },
    }
}
