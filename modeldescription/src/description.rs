//! What a modelDescription.xml of FMI 2.0 says, as plain data.
//!
//! Elements and attributes have the standard's names. An attribute for which the standard has a default has that
//! default here if it is absent; any other attribute that may be absent is an [`Option`]. Annotations, which mean
//! something to their own tool only, have no place here.

use std::fmt;

/// The version of the standard, as it stands in every model description of FMI 2.0 and its maintenance releases.
pub const FMI_VERSION: &str = "2.0";

/// A model description of FMI 2.0: the element `fmiModelDescription`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelDescription {
    /// The model's name.
    pub model_name: String,
    /// Compared with the library's at `fmi2Instantiate`.
    pub guid: String,
    /// What the model is.
    pub description: Option<String>,
    /// Who made the model.
    pub author: Option<String>,
    /// The model's version.
    pub version: Option<String>,
    /// Whose the model is.
    pub copyright: Option<String>,
    /// What others may do with it.
    pub license: Option<String>,
    /// The tool that made the FMU.
    pub generation_tool: Option<String>,
    /// When the FMU was made, as `xs:dateTime`.
    pub generation_date_and_time: Option<String>,
    /// What the variables' names are made of.
    pub variable_naming_convention: VariableNamingConvention,
    /// Model exchange only.
    pub number_of_event_indicators: Option<u32>,
    /// What the FMU can do for model exchange, if it is made for that.
    pub model_exchange: Option<ModelExchange>,
    /// What the FMU can do for co-simulation, if it is made for that.
    pub co_simulation: Option<CoSimulation>,
    /// All units that are used.
    pub unit_definitions: Vec<Unit>,
    /// Types that variables refer to by `declaredType`.
    pub type_definitions: Vec<SimpleType>,
    /// What the FMU's messages are filed under.
    pub log_categories: Vec<LogCategory>,
    /// The simulation that is proposed.
    pub default_experiment: Option<DefaultExperiment>,
    /// The variables. Their index, by which the model structure names them, begins with 1.
    pub model_variables: Vec<Variable>,
    /// Which variables are unknowns, and what they depend on.
    pub model_structure: ModelStructure,
}

impl ModelDescription {
    /// The name of the library and prefix of its functions: that for co-simulation, if there are two.
    pub fn model_identifier(&self) -> Option<&str> {
        let co_simulation = self.co_simulation.as_ref().map(|flags| flags.model_identifier.as_str());
        co_simulation.or(self.model_exchange.as_ref().map(|flags| flags.model_identifier.as_str()))
    }

    /// The variable of this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.model_variables.iter().find(|variable| variable.name == name)
    }
}

/// `ModelExchange`: what an FMU can do in a host that brings the solver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelExchange {
    /// The name of the library and prefix of its functions.
    pub model_identifier: String,
    /// The FMU is no more than a connection to a tool.
    pub needs_execution_tool: bool,
    /// `fmi2CompletedIntegratorStep` need not be called.
    pub completed_integrator_step_not_needed: bool,
    /// A process can hold one instance only.
    pub can_be_instantiated_only_once_per_process: bool,
    /// The FMU does not use the host's functions for memory.
    pub can_not_use_memory_management_functions: bool,
    /// The FMU's state can be saved and restored.
    #[doc(alias = "canGetAndSetFMUstate")]
    pub can_get_and_set_fmu_state: bool,
    /// A saved state can be turned into bytes and back.
    #[doc(alias = "canSerializeFMUstate")]
    pub can_serialize_fmu_state: bool,
    /// `fmi2GetDirectionalDerivative` works.
    pub provides_directional_derivative: bool,
    /// The source files, if the FMU comes with any.
    pub source_files: Vec<String>,
}

/// `CoSimulation`: what an FMU can do that brings its own solver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoSimulation {
    /// The name of the library and prefix of its functions.
    pub model_identifier: String,
    /// The FMU is no more than a connection to a tool.
    pub needs_execution_tool: bool,
    /// Communication steps may differ in size.
    pub can_handle_variable_communication_step_size: bool,
    /// `fmi2SetRealInputDerivatives` works.
    pub can_interpolate_inputs: bool,
    /// The highest derivative that `fmi2GetRealOutputDerivatives` gives.
    pub max_output_derivative_order: u32,
    /// A step may go on after `fmi2DoStep` returned. (The standard spells it so.)
    pub can_run_asynchronuously: bool,
    /// A process can hold one instance only.
    pub can_be_instantiated_only_once_per_process: bool,
    /// The FMU does not use the host's functions for memory.
    pub can_not_use_memory_management_functions: bool,
    /// The FMU's state can be saved and restored.
    #[doc(alias = "canGetAndSetFMUstate")]
    pub can_get_and_set_fmu_state: bool,
    /// A saved state can be turned into bytes and back.
    #[doc(alias = "canSerializeFMUstate")]
    pub can_serialize_fmu_state: bool,
    /// `fmi2GetDirectionalDerivative` works.
    pub provides_directional_derivative: bool,
    /// The source files, if the FMU comes with any.
    pub source_files: Vec<String>,
}

/// `Unit`: a unit and what it is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unit {
    /// Its name, by which variables refer to it.
    pub name: String,
    /// What it is in SI units.
    pub base_unit: Option<BaseUnit>,
    /// Units in which people may like to see it better.
    pub display_units: Vec<DisplayUnit>,
}

/// `BaseUnit`: a value in SI units is `factor` * value + `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)] // A is the ampere, K the kelvin
pub struct BaseUnit {
    /// Exponent of the kilogram.
    pub kg: i32,
    /// Exponent of the metre.
    pub m: i32,
    /// Exponent of the second.
    pub s: i32,
    /// Exponent of the ampere.
    pub A: i32,
    /// Exponent of the kelvin.
    pub K: i32,
    /// Exponent of the mole.
    pub mol: i32,
    /// Exponent of the candela.
    pub cd: i32,
    /// Exponent of the radian.
    pub rad: i32,
    /// What a value is multiplied by.
    pub factor: f64,
    /// What is added then.
    pub offset: f64,
}

impl Default for BaseUnit {
    fn default() -> BaseUnit {
        BaseUnit { kg: 0, m: 0, s: 0, A: 0, K: 0, mol: 0, cd: 0, rad: 0, factor: 1.0, offset: 0.0 }
    }
}

/// `DisplayUnit`: a value to be shown is `factor` * value + `offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Its name, by which variables refer to it.
    pub name: String,
    /// What a value is multiplied by.
    pub factor: f64,
    /// What is added then.
    pub offset: f64,
}

/// `SimpleType`: attributes that variables share.
#[derive(Clone, Debug, PartialEq)]
pub struct SimpleType {
    /// Its name, by which variables refer to it.
    pub name: String,
    /// A short text.
    pub description: Option<String>,
    /// Type and attributes.
    pub attributes: TypeAttributes,
}

/// The attributes of a [`SimpleType`].
#[derive(Clone, Debug, PartialEq)]
pub enum TypeAttributes {
    /// 64-bit floating point.
    Real(RealAttributes),
    /// 32-bit integer.
    Integer(IntegerAttributes),
    /// True or false.
    Boolean,
    /// Text.
    String,
    /// One of some named numbers.
    Enumeration {
        /// The physical quantity.
        quantity: Option<String>,
        /// The names and their numbers.
        items: Vec<Item>,
    },
}

/// `Item`: one value of an enumeration.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Its name.
    pub name: String,
    /// Its number.
    pub value: i32,
    /// A short text.
    pub description: Option<String>,
}

/// What a Real and its declared type have in common.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RealAttributes {
    /// The physical quantity, such as `Torque`.
    pub quantity: Option<String>,
    /// The unit of the values.
    pub unit: Option<String>,
    /// The unit in which people may like to see them better.
    pub display_unit: Option<String>,
    /// A difference, to be shown without the display unit's offset.
    pub relative_quantity: Option<bool>,
    /// The lowest value that the model is made for.
    pub min: Option<f64>,
    /// The highest value that the model is made for.
    pub max: Option<f64>,
    /// The order of magnitude.
    pub nominal: Option<f64>,
    /// Grows without bounds, as the angle of a shaft does.
    pub unbounded: Option<bool>,
}

/// What an Integer and its declared type have in common, and an Enumeration too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IntegerAttributes {
    /// The physical quantity.
    pub quantity: Option<String>,
    /// The lowest value that the model is made for.
    pub min: Option<i32>,
    /// The highest value that the model is made for.
    pub max: Option<i32>,
}

/// `Category`: something that messages are filed under.
#[derive(Clone, Debug, PartialEq)]
pub struct LogCategory {
    /// Its name, as the logger gets it.
    pub name: String,
    /// What these messages tell.
    pub description: Option<String>,
}

/// `DefaultExperiment`: the simulation that is proposed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DefaultExperiment {
    /// Its start in seconds.
    pub start_time: Option<f64>,
    /// Its end in seconds.
    pub stop_time: Option<f64>,
    /// The relative tolerance.
    pub tolerance: Option<f64>,
    /// The communication step in seconds.
    pub step_size: Option<f64>,
}

/// `ScalarVariable`: a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// What the C functions know it by. Variables of one type that share it are the same by two names.
    pub value_reference: u32,
    /// A short text.
    pub description: Option<String>,
    /// Who sets it.
    pub causality: Causality,
    /// When it changes.
    pub variability: Variability,
    /// How it gets its first value, if that is said; see [`Variable::initial_or_default`].
    pub initial: Option<Initial>,
    /// Model exchange only.
    pub can_handle_multiple_set_per_time_instant: Option<bool>,
    /// Its type and what goes with that.
    pub typed: Typed,
}

impl Variable {
    /// How it gets its first value: as is said or, if nothing is, as the standard infers it from causality and
    /// variability. An input and the independent variable have none.
    pub fn initial_or_default(&self) -> Option<Initial> {
        use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter};
        self.initial.or(match (self.causality, self.variability) {
            (Input | Independent, _) => None,
            (Parameter, _) | (Output | Local, Variability::Constant) => Some(Initial::Exact),
            (CalculatedParameter | Output | Local, _) => Some(Initial::Calculated),
        })
    }

    /// Whether a host may set it: an input or a parameter that is no constant.
    pub fn is_settable(&self) -> bool {
        matches!(self.causality, Causality::Input | Causality::Parameter) && self.variability != Variability::Constant
    }
}

/// A variable's type, and the attributes that go with it.
#[derive(Clone, Debug, PartialEq)]
pub enum Typed {
    /// 64-bit floating point.
    Real(Real),
    /// 32-bit integer.
    Integer(Integer),
    /// True or false.
    Boolean(Boolean),
    /// Text.
    String(Text),
    /// One of some named numbers.
    Enumeration(Enumeration),
}

impl Typed {
    /// The standard's name of the type.
    pub fn name(&self) -> &'static str {
        match self {
            Typed::Real(_) => "Real",
            Typed::Integer(_) => "Integer",
            Typed::Boolean(_) => "Boolean",
            Typed::String(_) => "String",
            Typed::Enumeration(_) => "Enumeration",
        }
    }

    /// The name of the type definition that it refers to.
    pub fn declared_type(&self) -> Option<&str> {
        match self {
            Typed::Real(real) => real.declared_type.as_deref(),
            Typed::Integer(integer) => integer.declared_type.as_deref(),
            Typed::Boolean(boolean) => boolean.declared_type.as_deref(),
            Typed::String(text) => text.declared_type.as_deref(),
            Typed::Enumeration(enumeration) => Some(&enumeration.declared_type),
        }
    }

    /// Whether there is a start value.
    pub fn has_start(&self) -> bool {
        match self {
            Typed::Real(real) => real.start.is_some(),
            Typed::Integer(integer) => integer.start.is_some(),
            Typed::Boolean(boolean) => boolean.start.is_some(),
            Typed::String(text) => text.start.is_some(),
            Typed::Enumeration(enumeration) => enumeration.start.is_some(),
        }
    }
}

/// `Real`
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Real {
    /// The type definition that it refers to.
    pub declared_type: Option<String>,
    /// What it shares with type definitions.
    pub attributes: RealAttributes,
    /// The value before initialization.
    pub start: Option<f64>,
    /// It is the derivative of the variable with this index.
    pub derivative: Option<u32>,
    /// Model exchange only: an event may set this state.
    pub reinit: bool,
}

/// `Integer`
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Integer {
    /// The type definition that it refers to.
    pub declared_type: Option<String>,
    /// What it shares with type definitions.
    pub attributes: IntegerAttributes,
    /// The value before initialization.
    pub start: Option<i32>,
}

/// `Boolean`
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boolean {
    /// The type definition that it refers to.
    pub declared_type: Option<String>,
    /// The value before initialization.
    pub start: Option<bool>,
}

/// `String`
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Text {
    /// The type definition that it refers to.
    pub declared_type: Option<String>,
    /// The value before initialization.
    pub start: Option<String>,
}

/// `Enumeration`
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Enumeration {
    /// The type definition that it refers to.
    pub declared_type: String,
    /// What it shares with integers.
    pub attributes: IntegerAttributes,
    /// The value before initialization.
    pub start: Option<i32>,
}

/// `ModelStructure`: which variables are unknowns, and what they depend on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelStructure {
    /// All outputs.
    pub outputs: Vec<Unknown>,
    /// All derivatives of continuous states.
    pub derivatives: Vec<Unknown>,
    /// What is unknown in Initialization Mode.
    pub initial_unknowns: Vec<Unknown>,
}

/// `Unknown`: a variable that is computed from others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unknown {
    /// The index of the variable, beginning with 1.
    pub index: u32,
    /// The indices of the variables that it depends on; absent means all.
    pub dependencies: Option<Vec<u32>>,
    /// In which way it depends on each of them.
    pub dependencies_kind: Option<Vec<DependencyKind>>,
}

/// A type whose values are words of the standard.
pub(crate) trait Words: Copy + Sized + 'static {
    /// All values with their words, in the standard's order.
    const WORDS: &'static [(&'static str, Self)];
}

macro_rules! words {
    ($($(#[$meta:meta])* $Name:ident { $($(#[$value_meta:meta])* $Value:ident $word:literal,)* })*) => { $(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $Name { $($(#[$value_meta])* #[doc = concat!("`", $word, "`")] $Value,)* }

        impl $Name {
            /// The standard's word for it.
            pub fn word(self) -> &'static str {
                match self { $($Name::$Value => $word,)* }
            }
        }

        impl Words for $Name {
            const WORDS: &'static [(&'static str, Self)] = &[$(($word, $Name::$Value)),*];
        }

        impl fmt::Display for $Name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(self.word())
            }
        }
    )* };
}

words! {
    /// What the variables' names are made of.
    #[derive(Default)]
    VariableNamingConvention {
        /// Anything.
        #[default]
        Flat "flat",
        /// Identifiers with dots and indices between.
        Structured "structured",
    }

    /// Who sets a variable.
    #[derive(Default)]
    Causality {
        /// The host, before the simulation or, if it is tunable, in between.
        Parameter "parameter",
        /// The FMU, from parameters.
        CalculatedParameter "calculatedParameter",
        /// Another FMU or the host, during the simulation.
        Input "input",
        /// The FMU, for others.
        Output "output",
        /// The FMU, for itself.
        #[default]
        Local "local",
        /// Nobody: the time.
        Independent "independent",
    }

    /// When a variable changes.
    #[derive(Default)]
    Variability {
        /// Never.
        Constant "constant",
        /// Not after initialization.
        Fixed "fixed",
        /// Between steps, when the host wants it.
        Tunable "tunable",
        /// At some instants.
        Discrete "discrete",
        /// Always.
        #[default]
        Continuous "continuous",
    }

    /// How a variable gets its first value.
    Initial {
        /// It is the start value.
        Exact "exact",
        /// It is found by iteration from the start value.
        Approx "approx",
        /// It is computed from other variables.
        Calculated "calculated",
    }

    /// In which way an unknown depends on a known.
    DependencyKind {
        /// In any way.
        Dependent "dependent",
        /// Multiplied by a constant.
        Constant "constant",
        /// Multiplied by something that is fixed after initialization.
        Fixed "fixed",
        /// Multiplied by something tunable.
        Tunable "tunable",
        /// Multiplied by something discrete.
        Discrete "discrete",
    }
}
