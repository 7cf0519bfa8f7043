//! The contents of an FMI 2.0 modelDescription.xml as plain data: one line for each attribute and each list.
//!
//! Structs and fields are named like the elements and attributes of the standard. If an attribute is absent, its field
//! has the standard's default, or is `None` if there is no default. Annotations are dropped: only the tool that wrote
//! them understands them.
//!
//! `attributes.rs` explains the syntax of the lines.

pub use crate::description::{
    BaseUnit, Capabilities, Causality, DefaultExperiment, DependencyKind, DisplayUnit, Initial, LogCategory, Unit,
    Variability, VariableNamingConvention,
};
use crate::error::Error;
use crate::xml::attributes::*;
use crate::xml::read::{Attribute, Document, Tag};
use crate::xml::write::Xml;

/// The version stated by every model description for FMI 2.0 and its maintenance releases.
pub const FMI_VERSION: &str = "2.0";

elements! {
    /// An FMI 2.0 model description: the element `fmiModelDescription`.
    ModelDescription "fmiModelDescription" with "fmiVersion" = FMI_VERSION {
        /// The model's name.
        model_name "modelName": String;
        /// The identifier of the table, which `fmi2Instantiate` compares with the library's.
        guid "guid": String;
        /// A short description of the model.
        description "description": Option<String>;
        /// The model's author.
        author "author": Option<String>;
        /// The model's version.
        version "version": Option<String>;
        /// The copyright notice.
        copyright "copyright": Option<String>;
        /// The licence.
        license "license": Option<String>;
        /// The tool that generated the FMU.
        generation_tool "generationTool": Option<String>;
        /// The generation date and time, as `xs:dateTime`.
        generation_date_and_time "generationDateAndTime": Option<String>;
        /// The naming convention of variables.
        variable_naming_convention "variableNamingConvention": VariableNamingConvention = VariableNamingConvention::Flat;
        /// Model exchange only: the number of event indicators.
        number_of_event_indicators "numberOfEventIndicators": Option<u32>;
    }, children except "VendorAnnotations" {
        /// Its capabilities for model exchange, if it supports model exchange.
        model_exchange: Option<ModelExchange>;
        /// Its capabilities for co-simulation, if it supports co-simulation.
        co_simulation: Option<CoSimulation>;
        /// The units that variables may refer to.
        unit_definitions in "UnitDefinitions": Vec<Unit>;
        /// Types that variables refer to by `declaredType`.
        type_definitions in "TypeDefinitions": Vec<SimpleType>;
        /// The categories of the FMU's messages.
        log_categories in "LogCategories": Vec<LogCategory>;
        /// The proposed settings of a simulation.
        default_experiment: Option<DefaultExperiment>;
        /// The variables. The model structure refers to them by their index, which starts at 1.
        model_variables in "ModelVariables", required: Vec<Variable>;
        /// The unknowns, and the variables they depend on.
        model_structure: ModelStructure;
    }

    /// `ModelExchange`: capabilities for hosts that provide the solver.
    ModelExchange "ModelExchange" {
        /// The name of the library and prefix of its functions.
        model_identifier "modelIdentifier": String;
        /// Whether the model runs in an external tool, which must be installed.
        needs_execution_tool "needsExecutionTool": bool = false;
        /// Whether `fmi2CompletedIntegratorStep` need not be called.
        completed_integrator_step_not_needed "completedIntegratorStepNotNeeded": bool = false;
        /// Whether a process can have only one instance.
        can_be_instantiated_only_once_per_process "canBeInstantiatedOnlyOncePerProcess": bool = false;
        /// Whether the FMU does not use the host's memory functions.
        can_not_use_memory_management_functions "canNotUseMemoryManagementFunctions": bool = false;
        /// Whether the FMU's state can be saved and restored.
        can_get_and_set_fmu_state "canGetAndSetFMUstate": bool = false;
        /// Whether a saved state can be serialized.
        can_serialize_fmu_state "canSerializeFMUstate": bool = false;
        /// Whether `fmi2GetDirectionalDerivative` is supported.
        provides_directional_derivative "providesDirectionalDerivative": bool = false;
    }, children {
        /// The source files, if the FMU includes them.
        source_files in "SourceFiles": Vec<SourceFile>;
    }

    /// `CoSimulation`: capabilities of an FMU with its own solver.
    CoSimulation "CoSimulation" {
        /// The name of the library and prefix of its functions.
        model_identifier "modelIdentifier": String;
        /// The capabilities.
        capabilities: Capabilities;
    }, children {
        /// The source files, if the FMU includes them.
        source_files in "SourceFiles": Vec<SourceFile>;
    }

    /// `File`: a source file.
    SourceFile "File" {
        /// Its path within the FMU's `sources` folder.
        name "name": String;
    }

    /// `SimpleType`: attributes that variables share.
    SimpleType "SimpleType" {
        /// Its name, by which variables refer to it.
        name "name": String;
        /// A short description.
        description "description": Option<String>;
    }, children {
        /// The type and its attributes.
        attributes: TypeAttributes;
    }

    /// The attributes that a Real and its declared type share.
    RealAttributes "Real" {
        /// The physical quantity, such as `Torque`.
        quantity "quantity": Option<String>;
        /// The unit of the values.
        unit "unit": Option<String>;
        /// The unit in which the values are displayed by default.
        display_unit "displayUnit": Option<String>;
        /// Whether it is a difference, displayed without the offset of the display unit.
        relative_quantity "relativeQuantity": Option<bool>;
        /// The lower end of the range for which the model is valid.
        min "min": Option<f64>;
        /// The upper end of the range for which the model is valid.
        max "max": Option<f64>;
        /// The order of magnitude of the values.
        nominal "nominal": Option<f64>;
        /// Whether it grows without bounds, like the angle of a shaft.
        unbounded "unbounded": Option<bool>;
    }

    /// The attributes that an Integer or an Enumeration and its declared type share.
    IntegerAttributes "Integer" {
        /// The physical quantity.
        quantity "quantity": Option<String>;
        /// The lower end of the range for which the model is valid.
        min "min": Option<i32>;
        /// The upper end of the range for which the model is valid.
        max "max": Option<i32>;
    }

    /// A Boolean as a [`SimpleType`]: no attributes.
    BooleanType "Boolean" {}

    /// A String as a [`SimpleType`]: no attributes.
    StringType "String" {}

    /// An enumeration as a [`SimpleType`].
    EnumerationType "Enumeration" {
        /// The physical quantity.
        quantity "quantity": Option<String>;
    }, children {
        /// The named values.
        items: Vec<Item>;
    }

    /// `Item`: one value of an enumeration.
    Item "Item" {
        /// Its name.
        name "name": String;
        /// Its number.
        value "value": i32;
        /// A short description.
        description "description": Option<String>;
    }

    /// `ScalarVariable`: a variable.
    Variable "ScalarVariable" {
        /// Its name.
        name "name": String;
        /// Its value reference. Variables of the same type with the same reference are aliases.
        value_reference "valueReference": u32;
        /// A short description.
        description "description": Option<String>;
        /// Its causality: who sets it.
        causality "causality": Causality = Causality::Local;
        /// Its variability: when it changes.
        variability "variability": Variability = Variability::Continuous;
        /// How its initial value is determined, if stated in the file; see [`Variable::initial_or_default`].
        initial "initial": Option<Initial>;
        /// Model exchange only: whether an input may be set more than once at the same instant.
        can_handle_multiple_set_per_time_instant "canHandleMultipleSetPerTimeInstant": Option<bool>;
    }, children except "Annotations" {
        /// Its type and the attributes of that type.
        typed: Typed;
    }

    /// `Real`: the attributes of a floating-point variable.
    Real "Real" {
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// The attributes shared with type definitions.
        attributes: RealAttributes;
        /// The value before initialization.
        start "start": Option<f64>;
        /// The index, starting at 1, of the variable whose derivative it is.
        derivative "derivative": Option<u32>;
        /// Model exchange only: whether an event may set this state.
        reinit "reinit": bool = false, omitted;
    }

    /// `Integer`: the attributes of an integer variable.
    Integer "Integer" {
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// The attributes shared with type definitions.
        attributes: IntegerAttributes;
        /// The value before initialization.
        start "start": Option<i32>;
    }

    /// `Boolean`: the attributes of a Boolean variable.
    Boolean "Boolean" {
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// The value before initialization.
        start "start": Option<bool>;
    }

    /// `String`: the attributes of a string variable.
    Text "String" {
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// The value before initialization.
        start "start": Option<String>;
    }

    /// `Enumeration`: the attributes of an enumeration variable.
    Enumeration "Enumeration" {
        /// The type definition that it refers to.
        declared_type "declaredType": String;
        /// The attributes shared with integers.
        attributes: IntegerAttributes;
        /// The value before initialization.
        start "start": Option<i32>;
    }

    /// `ModelStructure`: the unknowns, and the variables they depend on.
    ModelStructure "ModelStructure" {}, children {
        /// All outputs.
        outputs in "Outputs": Vec<Unknown>;
        /// All derivatives of continuous states.
        derivatives in "Derivatives": Vec<Unknown>;
        /// The variables computed in Initialization Mode.
        initial_unknowns in "InitialUnknowns": Vec<Unknown>;
    }

    /// `Unknown`: a variable computed from others.
    Unknown "Unknown" {
        /// The index of the variable, starting at 1.
        index "index": u32;
        /// The indices of the variables that it depends on; `None` means all.
        dependencies "dependencies": Option<Vec<u32>>;
        /// How it depends on each variable in `dependencies`.
        dependencies_kind "dependenciesKind": Option<Vec<DependencyKind>>;
    }
}

choices! {
    /// The type of a variable, and the attributes of that type.
    Typed of "a variable", by default Real {
        /// A 64-bit floating-point number.
        Real(Real);
        /// A 32-bit integer.
        Integer(Integer);
        /// True or false.
        Boolean(Boolean);
        /// A string.
        String(Text);
        /// One of several named numbers.
        Enumeration(Enumeration);
    }

    /// The type of a [`SimpleType`], and the attributes of that type.
    TypeAttributes of "a SimpleType", by default Real {
        /// A 64-bit floating-point number.
        Real(RealAttributes);
        /// A 32-bit integer.
        Integer(IntegerAttributes);
        /// True or false.
        Boolean(BooleanType);
        /// A string.
        String(StringType);
        /// One of several named numbers.
        Enumeration(EnumerationType);
    }
}

impl ModelDescription {
    /// The name of the library and prefix of its functions; the one for co-simulation if the FMU supports both.
    pub fn model_identifier(&self) -> Option<&str> {
        let co_simulation = self.co_simulation.as_ref().map(|flags| flags.model_identifier.as_str());
        co_simulation.or(self.model_exchange.as_ref().map(|flags| flags.model_identifier.as_str()))
    }

    /// The variable with this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.model_variables.iter().find(|variable| variable.name == name)
    }
}

impl ModelExchange {
    /// The names of the attributes in `modelDescription.xml` and their values as text, in the order of the schema.
    pub fn list(&self) -> Vec<(&'static str, String)> {
        crate::description::list(self)
    }
}

impl Variable {
    /// How its initial value is determined: `initial` or, if that is absent, the standard's default for its causality
    /// and variability. `None` for an input and for the independent variable.
    pub fn initial_or_default(&self) -> Option<Initial> {
        use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter};
        self.initial.or(match (self.causality, self.variability) {
            (Input | Independent, _) => None,
            (Parameter, _) | (Output | Local, Variability::Constant) => Some(Initial::Exact),
            (CalculatedParameter | Output | Local, _) => Some(Initial::Calculated),
        })
    }

    /// Whether a host may set it: it is an input or parameter that is not constant.
    pub fn is_settable(&self) -> bool {
        matches!(self.causality, Causality::Input | Causality::Parameter) && self.variability != Variability::Constant
    }
}

impl Typed {
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
