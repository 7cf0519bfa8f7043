//! Derives a description of the FMU from an FMI 3.0 model description, and changes its start values.

use super::description::{
    Causality, Dimension, FMI_VERSION, FloatAttributes, IntegerAttributes, ModelDescription, TypeAttributes, Typed,
    Variable,
};
use crate::arrays::MOST_ELEMENTS;
use crate::description::{self, Description, Support, Type, list};
use blocks::Value;
use blocks::table::number::{decimal, exact, number};
use std::collections::HashMap;

/// The attributes of type definitions, by name.
type Types<'a> = HashMap<&'a str, &'a TypeAttributes>;

impl ModelDescription {
    /// The description of the FMU, independent of the FMI version. An alias becomes a separate variable.
    pub fn description(&self) -> Description {
        let types: Types = self.type_definitions.iter().map(|of| (of.name.as_str(), &of.attributes)).collect();
        // The first attribute is the model identifier, which is not a capability.
        let support = |identifier: &str, all: Vec<(&'static str, String)>| Support {
            model_identifier: identifier.into(),
            capabilities: all.into_iter().skip(1).collect(),
        };
        let sizes = self.sizes();
        let mut variables = Vec::with_capacity(self.model_variables.len());
        for variable in &self.model_variables {
            let described = described(variable, &types, &sizes);
            let aliases = variable.aliases.iter().map(|alias| description::Variable {
                name: alias.name.clone(),
                description: alias.description.clone(),
                display_unit: alias.display_unit.clone().or_else(|| described.display_unit.clone()),
                ..described.clone()
            });
            let aliases: Vec<_> = aliases.collect();
            variables.push(described);
            variables.extend(aliases);
        }
        Description {
            fmi_version: FMI_VERSION,
            model_name: self.model_name.clone(),
            guid: self.instantiation_token.clone(),
            description: self.description.clone(),
            author: self.author.clone(),
            version: self.version.clone(),
            copyright: self.copyright.clone(),
            license: self.license.clone(),
            generation_tool: self.generation_tool.clone(),
            generation_date_and_time: self.generation_date_and_time.clone(),
            co_simulation: self.co_simulation.as_ref().map(|own| support(&own.of.model_identifier, list(own))),
            model_exchange: self.model_exchange.as_ref().map(|own| support(&own.of.model_identifier, list(own))),
            scheduled_execution: self
                .scheduled_execution
                .as_ref()
                .map(|own| support(&own.of.model_identifier, list(own))),
            units: self.unit_definitions.iter().map(Into::into).collect(),
            log_categories: self.log_categories.clone(),
            default_experiment: self.default_experiment,
            variables,
            arrays: Vec::new(),
        }
    }

    /// The start values of the variables to which array sizes may refer, by value reference.
    pub(super) fn sizes(&self) -> HashMap<u32, u64> {
        let is_size = |variable: &&Variable| matches!(variable.typed, Typed::UInt64(_));
        let sizes = self.model_variables.iter().filter(is_size).filter_map(|variable| {
            let start = *variable.typed.integer()?.0.start.as_ref()?.first()?;
            Some((variable.value_reference(), u64::try_from(start).ok()?))
        });
        sizes.collect()
    }

    /// Sets the start values of variables or elements of arrays, by index, and widens their declared ranges to include
    /// them, as FMI requires; the blocks accept any value.
    ///
    /// # Panics
    /// An index does not exist.
    pub(crate) fn set_starts(&mut self, starts: Vec<(usize, Value)>) {
        let (sizes, mut next) = (self.sizes(), 0);
        let span = |of: &Variable| {
            let (first, count) = (next, elements(of, &sizes));
            next += count * (1 + of.aliases.len());
            (first, count)
        };
        let spans: Vec<(usize, usize)> = self.model_variables.iter().map(span).collect();
        for (place, start) in starts {
            let at = spans.partition_point(|(first, _)| *first <= place) - 1;
            let (first, count) = spans[at];
            set_start(&mut self.model_variables[at], place - first, count, start);
        }
    }
}

/// Sets the start value of one of the `count` elements of a variable; a scalar has one element.
fn set_start(variable: &mut Variable, element: usize, count: usize, start: Value) {
    // The shortest decimal form of a 32-bit number differs from that of the same 64-bit number.
    let is_narrow = matches!(variable.typed, Typed::Float32(_));
    match &mut variable.typed {
        Typed::Float32(own) | Typed::Float64(own) => {
            let start = if is_narrow { decimal(start) } else { number(start) };
            put(&mut own.start, element, count, start);
            widen(&mut own.attributes.min, &mut own.attributes.max, start);
        }
        Typed::Boolean(own) => put(&mut own.start, element, count, number(start) != 0.0),
        other => {
            let bits = exact(start).unwrap_or_default();
            let start = match other {
                Typed::UInt16(_) => i128::from(bits as u16),
                Typed::Int32(_) => i128::from(bits as i32),
                _ => bits,
            };
            if let Some(own) = other.integer_mut() {
                put(&mut own.start, element, count, start);
                widen(&mut own.attributes.min, &mut own.attributes.max, start);
            }
        }
    }
}

/// The number of variables into which [`Description::expanded`] expands a variable: one for each element, or one for a
/// scalar or an array that is too large.
fn elements(of: &Variable, sizes: &HashMap<u32, u64>) -> usize {
    let count = of.dimensions.iter().try_fold(1u64, |product, one| product.checked_mul(size(one, sizes)?));
    count.filter(|count| *count <= MOST_ELEMENTS).map_or(1, |count| count as usize)
}

/// Stores the start value of an array element. The array may have had a single value for all elements so far.
fn put<T: Copy + Default>(starts: &mut Option<Vec<T>>, element: usize, count: usize, start: T) {
    let starts = starts.get_or_insert_default();
    if starts.len() != count {
        let all = starts.first().copied().unwrap_or_default();
        starts.resize(count, all);
    }
    starts[element] = start;
}

fn widen<T: PartialOrd + Copy>(min: &mut Option<T>, max: &mut Option<T>, start: T) {
    *min = min.map(|min| if start < min { start } else { min });
    *max = max.map(|max| if start > max { start } else { max });
}

/// The size of a dimension, if known.
pub(super) fn size(of: &Dimension, sizes: &HashMap<u32, u64>) -> Option<u64> {
    of.start.or_else(|| sizes.get(&of.value_reference?).copied())
}

fn described(of: &Variable, types: &Types, sizes: &HashMap<u32, u64>) -> description::Variable {
    let declared = of.common.declared_type.as_deref().and_then(|name| types.get(name).copied());
    let dimensions: Vec<u64> = of.dimensions.iter().map(|one| size(one, sizes).unwrap_or(0)).collect();
    let causality = match of.common.causality {
        Causality::Parameter | Causality::StructuralParameter => description::Causality::Parameter,
        Causality::CalculatedParameter => description::Causality::CalculatedParameter,
        Causality::Input => description::Causality::Input,
        Causality::Output => description::Causality::Output,
        Causality::Local => description::Causality::Local,
        Causality::Independent => description::Causality::Independent,
    };
    let bare = description::Variable {
        name: of.common.name.clone(),
        value_reference: of.common.value_reference,
        description: of.common.description.clone(),
        causality,
        variability: of.variability(),
        initial: of.initial_or_default().filter(|_| causality != description::Causality::Input),
        type_name: of.typed.name(),
        kind: None,
        is_structural: of.common.causality == Causality::StructuralParameter,
        dimensions,
        ..description::Variable::default()
    };
    let with_starts = |bare: description::Variable, kind: Type, starts: Option<Vec<f64>>| {
        let start = starts.as_ref().and_then(|starts| starts.first().copied());
        let count = usize::try_from(bare.count()).unwrap_or(usize::MAX);
        let starts = match starts {
            _ if bare.dimensions.is_empty() => Vec::new(),
            // A single value applies to all elements, unless the array would take too much memory.
            Some(starts) if starts.len() == 1 && count <= MOST_REPEATED => starts.repeat(count),
            Some(starts) => starts,
            None => Vec::new(),
        };
        description::Variable { kind: Some(kind), start, starts, ..bare }
    };
    match &of.typed {
        Typed::Float32(own) | Typed::Float64(own) => {
            let of_type = declared.and_then(TypeAttributes::float);
            let FloatAttributes { unit, display_unit, min, max, .. } = &own.attributes;
            let is_narrow = matches!(of.typed, Typed::Float32(_));
            // A Float32 holds the nearest 32-bit number.
            let value = |number: f64| if is_narrow { f64::from(number as f32) } else { number };
            let starts = own.start.as_ref().map(|starts| starts.iter().copied().map(value).collect());
            let bare = description::Variable {
                unit: unit.clone().or_else(|| of_type?.unit.clone()),
                display_unit: display_unit.clone().or_else(|| of_type?.display_unit.clone()),
                min: min.or_else(|| of_type?.min),
                max: max.or_else(|| of_type?.max),
                ..bare
            };
            with_starts(bare, Type::Real, starts)
        }
        Typed::Boolean(own) => {
            let number = |start: &bool| f64::from(u8::from(*start));
            with_starts(bare, Type::Boolean, own.start.as_ref().map(|starts| starts.iter().map(number).collect()))
        }
        Typed::String => description::Variable {
            start_text: of.starts.first().map(|start| start.value.clone().unwrap_or_default()),
            ..bare
        },
        Typed::Binary(_) | Typed::Clock(_) => bare,
        other => {
            let Some((own, _)) = other.integer() else { return bare };
            let of_type = declared.and_then(TypeAttributes::integer);
            let IntegerAttributes { min, max, .. } = &own.attributes;
            let number = |number: i128| number as f64;
            let bare = description::Variable {
                min: min.or_else(|| of_type?.min).map(number),
                max: max.or_else(|| of_type?.max).map(number),
                ..bare
            };
            let starts = own.start.as_ref().map(|starts| starts.iter().copied().map(number).collect());
            let bare = description::Variable { exact: own.start.clone().unwrap_or_default(), ..bare };
            with_starts(bare, Type::Integer, starts)
        }
    }
}

/// The maximum number of elements for which a single start value is repeated.
const MOST_REPEATED: usize = 1 << 20;
