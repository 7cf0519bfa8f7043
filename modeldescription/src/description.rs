//! The description of an FMU, independent of the FMI version of its `modelDescription.xml`.
//!
//! The elements and words below are common to all versions.

use crate::arrays::Array;
use crate::error::Error;
use crate::xml::attributes::*;
use crate::xml::lexical::{SPACES, Value};
use crate::xml::read::{Attribute, Document, Tag};
use crate::xml::write::Xml;
use blocks::{Class, Kind};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// The generation tool stated in the descriptions of blocks: this program and its version.
pub const GENERATION_TOOL: &str = concat!("plcfmu ", env!("CARGO_PKG_VERSION"));

/// The description of an FMU, as needed by a master, a study or a tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The FMI version, such as `2.0`.
    pub fmi_version: &'static str,
    /// The model's name.
    pub model_name: String,
    /// The GUID or instantiation token, which the library compares with its own.
    pub guid: String,
    /// A short description of the model.
    pub description: Option<String>,
    /// The model's author.
    pub author: Option<String>,
    /// The model's version.
    pub version: Option<String>,
    /// The copyright notice.
    pub copyright: Option<String>,
    /// The licence.
    pub license: Option<String>,
    /// The tool that generated the FMU.
    pub generation_tool: Option<String>,
    /// The generation date and time, as `xs:dateTime`.
    pub generation_date_and_time: Option<String>,
    /// Its capabilities for co-simulation, if it supports co-simulation.
    pub co_simulation: Option<Support>,
    /// Its capabilities for model exchange, if it supports model exchange.
    pub model_exchange: Option<Support>,
    /// Its capabilities for scheduled execution, if it supports scheduled execution.
    pub scheduled_execution: Option<Support>,
    /// The units that variables may refer to.
    pub units: Vec<Unit>,
    /// The categories of the FMU's messages.
    pub log_categories: Vec<LogCategory>,
    /// The proposed settings of a simulation.
    pub default_experiment: Option<DefaultExperiment>,
    /// The variables.
    pub variables: Vec<Variable>,
    /// The arrays whose elements are variables, in an [expanded](Description::expanded) description.
    pub arrays: Vec<Array>,
}

/// The capabilities of an FMU for one kind of simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Support {
    /// The name of the library.
    pub model_identifier: String,
    /// The names of the capabilities and their values as text, named and ordered as in `modelDescription.xml`.
    pub capabilities: Vec<(&'static str, String)>,
}

/// A variable. Attributes that it does not state are taken from its type definition.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its value reference. Variables of the same type with the same reference are aliases.
    pub value_reference: u32,
    /// A short description.
    pub description: Option<String>,
    /// Its causality: who sets it.
    pub causality: Causality,
    /// Its variability: when it changes.
    pub variability: Variability,
    /// How its initial value is determined; `None` for an input and for the independent variable.
    pub initial: Option<Initial>,
    /// The type by which it is read and written; `None` if it cannot be read as a number, such as a string.
    pub kind: Option<Type>,
    /// The name of its type in its FMI version, such as `Float64`.
    pub type_name: &'static str,
    /// The size of each dimension of an array, 0 if unknown; empty for a scalar.
    pub dimensions: Vec<u64>,
    /// The unit of its values.
    pub unit: Option<String>,
    /// The unit in which its values are displayed by default.
    pub display_unit: Option<String>,
    /// The lower end of the range for which the model is valid.
    pub min: Option<f64>,
    /// The upper end of the range for which the model is valid.
    pub max: Option<f64>,
    /// The value before initialization; true is 1. For an array, the value of the first element.
    pub start: Option<f64>,
    /// The value of a string before initialization.
    pub start_text: Option<String>,
    /// The values of an array before initialization, one for each element (in a very large array, one may apply to
    /// all); empty for a scalar or string.
    pub starts: Vec<f64>,
    /// The values of an integer before initialization, one for each element or one for all. Unlike `start` and
    /// `starts`, they are exact even for large 64-bit integers. Empty in FMI 2.0, which has only 32-bit integers.
    pub exact: Vec<i128>,
    /// Whether it is a structural parameter, on which array sizes may depend and which is set in Configuration Mode.
    pub is_structural: bool,
}

impl Default for Variable {
    /// A continuous local Real without a name: the defaults of FMI 2.0.
    fn default() -> Variable {
        Variable {
            name: String::new(),
            value_reference: 0,
            description: None,
            causality: Causality::Local,
            variability: Variability::Continuous,
            initial: None,
            kind: Some(Type::Real),
            type_name: Type::Real.name(),
            dimensions: Vec::new(),
            unit: None,
            display_unit: None,
            min: None,
            max: None,
            start: None,
            start_text: None,
            starts: Vec::new(),
            exact: Vec::new(),
            is_structural: false,
        }
    }
}

impl Variable {
    /// The value before initialization as a [cell](Type::cell); `None` if there is none, or for a string.
    pub fn start_cell(&self) -> Option<f64> {
        let kind = self.kind?;
        let exact = self.exact.first().and_then(|start| kind.whole_cell(*start));
        exact.or_else(|| self.start.map(|start| kind.cell(start)))
    }
}

/// The type by which a variable is read and written. An enumeration counts as an Integer, but as an Int64 in an
/// [expanded](Description::expanded) FMI 3.0 description.
///
/// FMI 2.0 has the types Real, Integer and Boolean; FMI 3.0 calls the first two Float64 and Int32.
///
/// Values are 64-bit floating-point numbers, which hold any value of these types except large ones of Int64 and UInt64:
/// these are passed as [cells](Type::cell).
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq, PartialOrd, Ord)]
pub enum Type {
    /// A 64-bit floating-point number.
    Real,
    /// A 32-bit integer.
    Integer,
    /// TRUE or FALSE.
    Boolean,
    /// A 32-bit floating-point number.
    Float32,
    /// An 8-bit integer.
    Int8,
    /// An unsigned 8-bit integer.
    UInt8,
    /// A 16-bit integer.
    Int16,
    /// An unsigned 16-bit integer.
    UInt16,
    /// An unsigned 32-bit integer.
    UInt32,
    /// A 64-bit integer.
    Int64,
    /// An unsigned 64-bit integer.
    UInt64,
}

impl Type {
    /// All types, in the order of declaration.
    pub const ALL: [Type; 11] = [
        Type::Real,
        Type::Integer,
        Type::Boolean,
        Type::Float32,
        Type::Int8,
        Type::UInt8,
        Type::Int16,
        Type::UInt16,
        Type::UInt32,
        Type::Int64,
        Type::UInt64,
    ];

    /// The FMI 2.0 type that holds the values of a PLC type; a TIME is a number of seconds.
    pub const fn from_kind(kind: Kind) -> Type {
        match kind.class() {
            Class::Real => Type::Real,
            Class::Integer => Type::Integer,
            Class::Boolean => Type::Boolean,
        }
    }

    /// Its name in FMI 2.0; in FMI 3.0 if FMI 2.0 does not have the type.
    pub const fn name(self) -> &'static str {
        match self {
            Type::Real => "Real",
            Type::Integer => "Integer",
            Type::Boolean => "Boolean",
            Type::Float32 => "Float32",
            Type::Int8 => "Int8",
            Type::UInt8 => "UInt8",
            Type::Int16 => "Int16",
            Type::UInt16 => "UInt16",
            Type::UInt32 => "UInt32",
            Type::Int64 => "Int64",
            Type::UInt64 => "UInt64",
        }
    }

    /// Its name in FMI 3.0.
    pub const fn name_v3(self) -> &'static str {
        match self {
            Type::Real => "Float64",
            Type::Integer => "Int32",
            other => other.name(),
        }
    }

    /// The lowest and highest values of an integer type; `None` for other types.
    pub const fn whole(self) -> Option<(i128, i128)> {
        match self {
            Type::Real | Type::Float32 | Type::Boolean => None,
            Type::Integer => Some((i32::MIN as i128, i32::MAX as i128)),
            Type::Int8 => Some((i8::MIN as i128, i8::MAX as i128)),
            Type::UInt8 => Some((0, u8::MAX as i128)),
            Type::Int16 => Some((i16::MIN as i128, i16::MAX as i128)),
            Type::UInt16 => Some((0, u16::MAX as i128)),
            Type::UInt32 => Some((0, u32::MAX as i128)),
            Type::Int64 => Some((i64::MIN as i128, i64::MAX as i128)),
            Type::UInt64 => Some((0, u64::MAX as i128)),
        }
    }

    /// The size of a value in bits; a Boolean, which is an integer in FMI 2.0, counts as 32.
    pub const fn bits(self) -> u32 {
        match self {
            Type::Int8 | Type::UInt8 => 8,
            Type::Int16 | Type::UInt16 => 16,
            Type::Integer | Type::UInt32 | Type::Float32 | Type::Boolean => 32,
            Type::Real | Type::Int64 | Type::UInt64 => 64,
        }
    }

    /// Whether its values are floating-point numbers.
    pub const fn is_floating(self) -> bool {
        matches!(self, Type::Real | Type::Float32)
    }

    /// Whether a cell holds the bits of a value instead of its number, because an `f64` cannot represent every value.
    pub const fn is_wide(self) -> bool {
        matches!(self, Type::Int64 | Type::UInt64)
    }

    /// The number in a cell, rounded to an `f64`.
    pub fn number(self, cell: f64) -> f64 {
        match self {
            Type::Int64 => cell.to_bits() as i64 as f64,
            Type::UInt64 => cell.to_bits() as f64,
            _ => cell,
        }
    }

    /// A number as a cell. The cell of a 64-bit integer has the same bits as the integer.
    pub fn cell(self, number: f64) -> f64 {
        match self {
            Type::Int64 => f64::from_bits(number as i64 as u64),
            Type::UInt64 => f64::from_bits(number as u64),
            _ => number,
        }
    }

    /// An integer as a cell, or `None` if it is outside the range of the type.
    pub fn whole_cell(self, number: i128) -> Option<f64> {
        let (low, high) = self.whole()?;
        (low..=high).contains(&number).then(|| match self {
            Type::Int64 => f64::from_bits(number as i64 as u64),
            Type::UInt64 => f64::from_bits(number as u64),
            _ => number as f64,
        })
    }

    /// The integer in a cell of an integer type, or `None` if it is outside the range of the type.
    pub fn whole_of(self, cell: f64) -> Option<i128> {
        let (low, high) = self.whole()?;
        match self {
            Type::Int64 => Some(i128::from(cell.to_bits() as i64)),
            Type::UInt64 => Some(i128::from(cell.to_bits())),
            _ => Some(cell as i128).filter(|whole| *whole as f64 == cell && (low..=high).contains(whole)),
        }
    }

    /// A value of this type as written in `modelDescription.xml` and in the start values of a preset; `value` is 1 for
    /// true.
    pub fn text(self, value: f64) -> String {
        match self {
            Type::Real => format!("{value:?}"),
            Type::Float32 => format!("{:?}", value as f32),
            Type::Boolean => (value != 0.0).to_string(),
            _ => (value as i128).to_string(),
        }
    }
}

impl Description {
    /// Whether the version is FMI 3.0; otherwise it is FMI 2.0.
    pub fn is_fmi_3(&self) -> bool {
        self.fmi_version.starts_with('3')
    }

    /// The name of the library for co-simulation or, if the FMU does not support that, for model exchange.
    pub fn model_identifier(&self) -> Option<&str> {
        let support = self.co_simulation.as_ref().or(self.model_exchange.as_ref());
        support.map(|support| support.model_identifier.as_str())
    }

    /// The elements of the array with this name.
    pub fn array(&self, name: &str) -> Option<&[Variable]> {
        let array = self.arrays.iter().find(|array| array.name == name)?;
        self.variables.get(array.first..array.first + array.count)
    }

    /// The variable with this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// The sampling time of the block in the FMU: the only fixed parameter in seconds whose start value equals the
    /// proposed step size. `None` if there are none or several.
    pub fn cycle(&self) -> Option<&Variable> {
        let step = self.default_experiment.and_then(|experiment| experiment.step_size)?;
        let is_cycle = |variable: &&Variable| {
            let is_fixed = variable.causality == Causality::Parameter && variable.variability == Variability::Fixed;
            is_fixed && variable.unit.as_deref() == Some("s") && variable.start == Some(step)
        };
        let mut all = self.variables.iter().filter(is_cycle);
        all.next().filter(|_| all.next().is_none())
    }

    /// The start value of the variable with this name; true is 1.
    pub fn start(&self, name: &str) -> Option<f64> {
        self.variable(name)?.start
    }
}

impl Support {
    /// Whether the FMU has a capability. Its name is compared ignoring case, which differs between versions:
    /// `canGetAndSetFMUstate`, `canGetAndSetFMUState`.
    pub fn can(&self, capability: &str) -> bool {
        self.capabilities.iter().any(|(name, value)| name.eq_ignore_ascii_case(capability) && value == "true")
    }
}

impl Variable {
    /// Whether a host may set it: it is an input or a parameter, but neither constant nor structural.
    pub fn is_settable(&self) -> bool {
        matches!(self.causality, Causality::Input | Causality::Parameter)
            && self.variability != Variability::Constant
            && !self.is_structural
    }

    /// The number of values: 1, or the number of elements of an array.
    pub fn count(&self) -> u64 {
        self.dimensions.iter().product()
    }

    /// Whether it is an enumeration.
    pub fn is_enumeration(&self) -> bool {
        self.type_name == "Enumeration"
    }

    /// Whether it may be set while the simulation runs.
    pub fn is_tunable(&self) -> bool {
        self.is_settable() && (self.causality == Causality::Input || self.variability == Variability::Tunable)
    }

    /// Whether a value is outside the declared range.
    pub fn is_outside(&self, value: f64) -> bool {
        self.min.is_some_and(|min| value < min) || self.max.is_some_and(|max| value > max)
    }

    /// The range for messages, with `...` for a missing limit: `0.0 to ...`.
    pub fn range(&self) -> String {
        let show = |bound: Option<f64>| bound.map_or("...".into(), |bound| format!("{bound:?}"));
        format!("{} to {}", show(self.min), show(self.max))
    }
}

elements! {
    /// The capabilities of an FMU for co-simulation: attributes of the element `CoSimulation`, and an object in a
    /// library's JSON.
    #[serde(default)]
    Capabilities and json {
        /// Whether the model runs in an external tool, which must be installed.
        needs_execution_tool "needsExecutionTool": bool = false;
        /// Whether communication steps may differ in size.
        can_handle_variable_communication_step_size "canHandleVariableCommunicationStepSize": bool = false;
        /// Whether the host can set time derivatives of inputs.
        can_interpolate_inputs "canInterpolateInputs": bool = false;
        /// The highest order of output derivatives that the FMU provides; 0 if it provides none.
        max_output_derivative_order "maxOutputDerivativeOrder": u32 = 0;
        /// Whether a step may continue after its call has returned. (The standard's spelling.)
        can_run_asynchronuously "canRunAsynchronuously": bool = false;
        /// Whether a process can have only one instance.
        can_be_instantiated_only_once_per_process "canBeInstantiatedOnlyOncePerProcess": bool = false;
        /// Whether the FMU does not use the host's memory functions.
        can_not_use_memory_management_functions "canNotUseMemoryManagementFunctions": bool = false;
        /// Whether the FMU's state can be saved and restored.
        can_get_and_set_fmu_state "canGetAndSetFMUstate": bool = false;
        /// Whether a saved state can be serialized.
        can_serialize_fmu_state "canSerializeFMUstate": bool = false;
        /// Whether the FMU provides directional derivatives.
        provides_directional_derivative "providesDirectionalDerivative": bool = false;
    }

    /// `Unit`: a unit and its definition in SI units.
    Unit "Unit" {
        /// Its name, by which variables refer to it.
        name "name": String;
    }, children {
        /// Its definition in SI units.
        base_unit: Option<BaseUnit>;
        /// Units in which its values may be displayed.
        display_units: Vec<DisplayUnit>;
    }

    /// `BaseUnit`: a value in SI units is `factor` * value + `offset`.
    #[derive(Copy)]
    #[allow(non_snake_case)] // A is the ampere, K the kelvin
    BaseUnit "BaseUnit" {
        /// Exponent of the kilogram.
        kg "kg": i32 = 0, omitted;
        /// Exponent of the metre.
        m "m": i32 = 0, omitted;
        /// Exponent of the second.
        s "s": i32 = 0, omitted;
        /// Exponent of the ampere.
        A "A": i32 = 0, omitted;
        /// Exponent of the kelvin.
        K "K": i32 = 0, omitted;
        /// Exponent of the mole.
        mol "mol": i32 = 0, omitted;
        /// Exponent of the candela.
        cd "cd": i32 = 0, omitted;
        /// Exponent of the radian.
        rad "rad": i32 = 0, omitted;
        /// The factor by which a value is multiplied.
        factor "factor": f64 = 1.0, omitted;
        /// The offset added to the product.
        offset "offset": f64 = 0.0, omitted;
    }

    /// `DisplayUnit`: the displayed value is `factor` * value + `offset`.
    DisplayUnit "DisplayUnit" {
        /// Its name, by which variables refer to it.
        name "name": String;
        /// The factor by which a value is multiplied.
        factor "factor": f64 = 1.0, omitted;
        /// The offset added to the product.
        offset "offset": f64 = 0.0, omitted;
    }

    /// `Category`: a category of log messages.
    LogCategory "Category" and json {
        /// Its name, as the host's logger receives it.
        name "name": String;
        /// The subject of its messages.
        description "description": Option<String>;
    }

    /// `DefaultExperiment`: the proposed settings of a simulation.
    #[derive(Copy)]
    DefaultExperiment "DefaultExperiment" {
        /// The start time in seconds.
        start_time "startTime": Option<f64>;
        /// The stop time in seconds.
        stop_time "stopTime": Option<f64>;
        /// The relative tolerance.
        tolerance "tolerance": Option<f64>;
        /// The communication step size in seconds.
        step_size "stepSize": Option<f64>;
    }
}

words! {
    /// The causality of a variable: who sets it.
    Causality {
        /// The host, before the simulation or, if tunable, between steps.
        Parameter "parameter",
        /// The FMU, from parameters.
        CalculatedParameter "calculatedParameter",
        /// Another FMU or the host, during the simulation.
        Input "input",
        /// The FMU, for use by others.
        Output "output",
        /// The FMU, for internal use.
        Local "local",
        /// Nothing: it is the time.
        Independent "independent",
    }

    /// The variability of a variable: when it changes.
    Variability {
        /// Never.
        Constant "constant",
        /// Not after initialization.
        Fixed "fixed",
        /// Between steps, when the host sets it.
        Tunable "tunable",
        /// At certain instants.
        Discrete "discrete",
        /// At any time.
        Continuous "continuous",
    }

    /// How the initial value of a variable is determined.
    Initial {
        /// By the start value.
        Exact "exact",
        /// By iteration from the start value.
        Approx "approx",
        /// By computation from other variables.
        Calculated "calculated",
    }

    /// The naming convention of variables.
    VariableNamingConvention {
        /// Any string.
        Flat "flat",
        /// Identifiers, dots and indices.
        Structured "structured",
    }

    /// How an unknown depends on a known variable.
    DependencyKind {
        /// In any way.
        Dependent "dependent",
        /// Multiplied by a constant.
        Constant "constant",
        /// Multiplied by a factor that is fixed after initialization.
        Fixed "fixed",
        /// Multiplied by a tunable factor.
        Tunable "tunable",
        /// Multiplied by a discrete factor.
        Discrete "discrete",
    }
}

/// The names of the attributes in `modelDescription.xml` and their values as text, in the order of the schema.
pub(crate) fn list(attributes: &impl Attributes) -> Vec<(&'static str, String)> {
    let mut list = Vec::new();
    attributes.write(&mut |name, value| list.push((name, value.to_owned())));
    list
}

impl Capabilities {
    /// The names of the attributes in `modelDescription.xml` and their values as text, in the order of the schema.
    pub fn list(&self) -> Vec<(&'static str, String)> {
        list(self)
    }
}

impl BaseUnit {
    /// The names of the attributes in `modelDescription.xml` and their values as text, in the order of the schema,
    /// except those with default values.
    pub fn list(&self) -> Vec<(&'static str, String)> {
        list(self)
    }
}

impl Causality {
    /// Whether this causality permits a variability (table in FMI 2.0, section 2.2.7). Importers reject an FMU that
    /// violates it.
    pub fn allows(self, variability: Variability) -> bool {
        use Variability::{Constant, Continuous, Discrete, Fixed, Tunable};
        match self {
            Causality::Parameter | Causality::CalculatedParameter => matches!(variability, Fixed | Tunable),
            Causality::Input => matches!(variability, Discrete | Continuous),
            Causality::Output => matches!(variability, Constant | Discrete | Continuous),
            Causality::Local => true,
            Causality::Independent => variability == Continuous,
        }
    }
}
