//! The contents of an FMI 3.0 modelDescription.xml as plain data: one line for each attribute and each list, as for
//! FMI 2.0.
//!
//! Structs and fields are named like the elements and attributes of the standard. If an attribute is absent, its field
//! has the standard's default, or is `None` if there is no default. Annotations are dropped: only the tool that wrote
//! them understands them.
//!
//! The fifteen elements for variables share one struct, [`Variable`], and the fourteen for types another,
//! [`TypeDefinition`]: `attributes.rs` explains the syntax of the lines, `variable.rs` defines which attributes belong
//! to which element.

pub use super::variable::{TypeAttributes, TypeDefinition, Typed, Variable};
pub use crate::description::{
    BaseUnit, DefaultExperiment, DependencyKind, Initial, LogCategory, Variability, VariableNamingConvention,
};
use crate::error::Error;
use crate::xml::attributes::*;
use crate::xml::lexical::{SPACES, Value};
use crate::xml::read::{Attribute, Document, Tag};
use crate::xml::write::Xml;
use std::borrow::Cow;
use std::fmt;

/// The version stated by every model description for FMI 3.0 and its maintenance releases.
pub const FMI_VERSION: &str = "3.0";

elements! {
    /// An FMI 3.0 model description: the element `fmiModelDescription`.
    ModelDescription "fmiModelDescription" with "fmiVersion" = FMI_VERSION {
        /// The model's name.
        model_name "modelName": String;
        /// The identifier of the interface, which the instantiation functions compare with the library's.
        instantiation_token "instantiationToken": String;
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
    }, children {
        /// Its capabilities for model exchange, if it supports model exchange.
        model_exchange: Option<ModelExchange>;
        /// Its capabilities for co-simulation, if it supports co-simulation.
        co_simulation: Option<CoSimulation>;
        /// Its capabilities for scheduled execution, if it supports scheduled execution.
        scheduled_execution: Option<ScheduledExecution>;
        /// The units that variables may refer to.
        unit_definitions in "UnitDefinitions": Vec<Unit>;
        /// Types that variables refer to by `declaredType`.
        type_definitions in "TypeDefinitions": Vec<TypeDefinition>;
        /// The categories of the FMU's messages.
        log_categories in "LogCategories": Vec<LogCategory>;
        /// The proposed settings of a simulation.
        default_experiment: Option<DefaultExperiment>;
        /// The variables. The model structure refers to them by their value references.
        model_variables in "ModelVariables", required: Vec<Variable>;
        /// The unknowns, and the variables they depend on.
        model_structure: ModelStructure;
    }

    /// The capabilities common to all kinds of simulation.
    InterfaceType {
        /// The name of the library.
        model_identifier "modelIdentifier": String;
        /// Whether the model runs in an external tool, which must be installed.
        needs_execution_tool "needsExecutionTool": bool = false;
        /// Whether a process can have only one instance.
        can_be_instantiated_only_once_per_process "canBeInstantiatedOnlyOncePerProcess": bool = false;
        /// Whether the FMU's state can be saved and restored.
        can_get_and_set_fmu_state "canGetAndSetFMUState": bool = false;
        /// Whether a saved state can be serialized.
        can_serialize_fmu_state "canSerializeFMUState": bool = false;
        /// Whether `fmi3GetDirectionalDerivative` is supported.
        provides_directional_derivatives "providesDirectionalDerivatives": bool = false;
        /// Whether `fmi3GetAdjointDerivative` is supported.
        provides_adjoint_derivatives "providesAdjointDerivatives": bool = false;
        /// Whether dependencies are known for each element of an array.
        provides_per_element_dependencies "providesPerElementDependencies": bool = false;
    }

    /// `ModelExchange`: capabilities for hosts that provide the solver.
    ModelExchange "ModelExchange" {
        /// The capabilities common to all kinds of simulation.
        of: InterfaceType;
        /// Whether `fmi3CompletedIntegratorStep` must be called.
        needs_completed_integrator_step "needsCompletedIntegratorStep": bool = false;
        /// Whether `fmi3EvaluateDiscreteStates` is supported.
        provides_evaluate_discrete_states "providesEvaluateDiscreteStates": bool = false;
    }

    /// `CoSimulation`: capabilities of an FMU with its own solver.
    CoSimulation "CoSimulation" {
        /// The capabilities common to all kinds of simulation.
        of: InterfaceType;
        /// Whether communication steps may differ in size.
        can_handle_variable_communication_step_size "canHandleVariableCommunicationStepSize": bool = false;
        /// The step size of the FMU's solver in seconds, if it is fixed.
        fixed_internal_step_size "fixedInternalStepSize": Option<f64>;
        /// The highest order of output derivatives that the FMU provides; 0 if it provides none.
        max_output_derivative_order "maxOutputDerivativeOrder": u32 = 0;
        /// The recommended smoothness of inputs set in the intermediate update.
        recommended_intermediate_input_smoothness "recommendedIntermediateInputSmoothness": i32 = 0, omitted;
        /// Whether the FMU can call the host's intermediate update within a step.
        provides_intermediate_update "providesIntermediateUpdate": bool = false;
        /// Whether a step may return before its end.
        might_return_early_from_do_step "mightReturnEarlyFromDoStep": bool = false;
        /// Whether the host may end a step in the intermediate update.
        can_return_early_after_intermediate_update "canReturnEarlyAfterIntermediateUpdate": bool = false;
        /// Whether the FMU has Event Mode.
        has_event_mode "hasEventMode": bool = false;
        /// Whether `fmi3EvaluateDiscreteStates` is supported.
        provides_evaluate_discrete_states "providesEvaluateDiscreteStates": bool = false;
    }

    /// `ScheduledExecution`: capabilities for a host that activates the FMU's clocks.
    ScheduledExecution "ScheduledExecution" {
        /// The capabilities common to all kinds of simulation.
        of: InterfaceType;
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

    /// `DisplayUnit`: the displayed value is `factor` * value + `offset`, or `factor` / value if it is `inverse`.
    DisplayUnit "DisplayUnit" {
        /// Its name, by which variables refer to it.
        name "name": String;
        /// The factor by which a value is multiplied.
        factor "factor": f64 = 1.0, omitted;
        /// The offset added to the product.
        offset "offset": f64 = 0.0, omitted;
        /// Whether the reciprocal of the value is displayed.
        inverse "inverse": bool = false, omitted;
    }

    /// The attributes common to variables of all types.
    Common {
        /// Its name.
        name "name": String;
        /// Its unique value reference.
        value_reference "valueReference": u32;
        /// A short description.
        description "description": Option<String>;
        /// Its causality: who sets it.
        causality "causality": Causality = Causality::Local;
        /// Its variability: when it changes, if stated in the file; see [`Variable::variability`].
        variability "variability": Option<Variability>;
        /// Model exchange only: whether an input may be set more than once at the same instant.
        can_handle_multiple_set_per_time_instant "canHandleMultipleSetPerTimeInstant": Option<bool>;
        /// The value references of the clocks on whose ticks it changes.
        clocks "clocks": Option<Vec<u32>>;
        /// Whether it can be accessed in the intermediate update.
        intermediate_update "intermediateUpdate": Option<bool>;
        /// The value reference of the variable whose value at the previous clock tick it holds.
        previous "previous": Option<u32>;
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// How its initial value is determined, if stated in the file; see [`Variable::initial_or_default`].
        initial "initial": Option<Initial>;
    }

    /// The attributes shared by a floating-point number and its declared type. Those of a Float32 are as written in the
    /// file, not yet rounded to 32 bits.
    FloatAttributes {
        /// The physical quantity, such as `Torque`.
        quantity "quantity": Option<String>;
        /// The unit of the values.
        unit "unit": Option<String>;
        /// The unit in which the values are displayed by default.
        display_unit "displayUnit": Option<String>;
        /// Whether it is a difference, displayed without the offset of the display unit.
        relative_quantity "relativeQuantity": Option<bool>;
        /// Whether it grows without bounds, like the angle of a shaft.
        unbounded "unbounded": Option<bool>;
        /// The lower end of the range for which the model is valid.
        min "min": Option<f64>;
        /// The upper end of the range for which the model is valid.
        max "max": Option<f64>;
        /// The order of magnitude of the values.
        nominal "nominal": Option<f64>;
    }

    /// `Float32`, `Float64`: the attributes of a floating-point variable.
    Float {
        /// The attributes shared with type definitions.
        attributes: FloatAttributes;
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<f64>>;
        /// The value reference of the variable whose derivative it is.
        derivative "derivative": Option<u32>;
        /// Model exchange only: whether an event may set this state.
        reinit "reinit": bool = false, omitted;
    }

    /// The attributes shared by an integer and its declared type.
    IntegerAttributes {
        /// The physical quantity.
        quantity "quantity": Option<String>;
        /// The lower end of the range for which the model is valid.
        min "min": Option<i128>;
        /// The upper end of the range for which the model is valid.
        max "max": Option<i128>;
    }

    /// `Int8` to `UInt64`, and `Enumeration`: the attributes of an integer or enumeration variable.
    Integer {
        /// The attributes shared with type definitions.
        attributes: IntegerAttributes;
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<i128>>;
    }

    /// `Boolean`: the attributes of a Boolean variable.
    Boolean {
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<bool>>;
    }

    /// The attributes shared by a Binary and its declared type.
    BinaryAttributes {
        /// The media type of the bytes.
        mime_type "mimeType": Option<String>;
        /// The maximum number of bytes.
        max_size "maxSize": Option<u64>;
    }

    /// The attributes shared by a Clock and its declared type.
    ClockAttributes {
        /// Whether the host may deactivate it.
        can_be_deactivated "canBeDeactivated": bool = false, omitted;
        /// Scheduled execution only: the priority; lower numbers come first.
        priority "priority": Option<u32>;
        /// What determines its interval.
        interval_variability "intervalVariability": IntervalVariability;
        /// The interval in seconds.
        interval_decimal "intervalDecimal": Option<f64>;
        /// The time of the first tick after the start, in seconds.
        shift_decimal "shiftDecimal": f64 = 0.0, omitted;
        /// Whether the interval can be read and set as a fraction of counts.
        supports_fraction "supportsFraction": bool = false, omitted;
        /// The number of counts per second.
        resolution "resolution": Option<u64>;
        /// The interval in counts.
        interval_counter "intervalCounter": Option<u64>;
        /// The time of the first tick after the start, in counts.
        shift_counter "shiftCounter": u64 = 0, omitted;
    }

    /// `Dimension`: the size of one dimension of an array, either fixed or the value of a variable.
    Dimension "Dimension" {
        /// The size, if it is fixed.
        start "start": Option<u64>;
        /// The value reference of the variable that holds the size, if it is not fixed.
        value_reference "valueReference": Option<u32>;
    }

    /// `Start`: the start value of a String, or of a Binary in hexadecimal.
    Start "Start" {
        /// The value.
        value "value": Option<String>;
    }

    /// `Alias`: an additional name for a variable.
    Alias "Alias" {
        /// The name.
        name "name": String;
        /// A short description.
        description "description": Option<String>;
        /// The unit in which the values are displayed by default.
        display_unit "displayUnit": Option<String>;
    }

    /// `Item`: one value of an enumeration.
    Item "Item" {
        /// Its name.
        name "name": String;
        /// Its number.
        value "value": i64;
        /// A short description.
        description "description": Option<String>;
    }

    /// `ModelStructure`: the unknowns, and the variables they depend on.
    ModelStructure "ModelStructure" {}, children {
        /// All outputs.
        outputs: Vec<Output>;
        /// All derivatives of continuous states.
        continuous_state_derivatives: Vec<ContinuousStateDerivative>;
        /// All states that change at clock ticks.
        clocked_states: Vec<ClockedState>;
        /// The variables computed in Initialization Mode.
        initial_unknowns: Vec<InitialUnknown>;
        /// The variables that signal events.
        event_indicators: Vec<EventIndicator>;
    }

    /// A variable computed from others.
    Unknown {
        /// The value reference of the variable.
        value_reference "valueReference": u32;
        /// The value references of the variables that it depends on; `None` means all.
        dependencies "dependencies": Option<Vec<u32>>;
        /// How it depends on each variable in `dependencies`.
        dependencies_kind "dependenciesKind": Option<Vec<DependencyKind>>;
    }

    /// `Output`: an output.
    Output "Output" {
        /// The variable and its dependencies.
        unknown: Unknown;
    }

    /// `ContinuousStateDerivative`: the derivative of a continuous state.
    ContinuousStateDerivative "ContinuousStateDerivative" {
        /// The variable and its dependencies.
        unknown: Unknown;
    }

    /// `ClockedState`: a state that changes at clock ticks.
    ClockedState "ClockedState" {
        /// The variable and its dependencies.
        unknown: Unknown;
    }

    /// `InitialUnknown`: a variable computed in Initialization Mode.
    InitialUnknown "InitialUnknown" {
        /// The variable and its dependencies.
        unknown: Unknown;
    }

    /// `EventIndicator`: a variable that signals events.
    EventIndicator "EventIndicator" {
        /// The variable and its dependencies.
        unknown: Unknown;
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
        /// The FMU, for others.
        Output "output",
        /// The FMU, for internal use.
        Local "local",
        /// Nothing: it is the time.
        Independent "independent",
        /// The host, in Configuration Mode: array sizes depend on it.
        StructuralParameter "structuralParameter",
    }

    /// What determines a clock's interval.
    #[derive(Default)]
    IntervalVariability {
        /// The model description.
        Constant "constant",
        /// The FMU, before the first tick.
        Fixed "fixed",
        /// The FMU, depending on tunable parameters.
        Tunable "tunable",
        /// The FMU, at each tick.
        Changing "changing",
        /// The FMU, at events.
        Countdown "countdown",
        /// The host or another FMU.
        #[default]
        Triggered "triggered",
    }
}

impl ModelDescription {
    /// The name of the library; the one for co-simulation if the FMU supports several kinds of simulation.
    pub fn model_identifier(&self) -> Option<&str> {
        let simulated = self.co_simulation.as_ref().map(|own| &own.of);
        let exchanged = self.model_exchange.as_ref().map(|own| &own.of);
        let scheduled = self.scheduled_execution.as_ref().map(|own| &own.of);
        simulated.or(exchanged).or(scheduled).map(|of| of.model_identifier.as_str())
    }

    /// The variable with this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.model_variables.iter().find(|variable| variable.common.name == name)
    }
}

impl From<crate::description::Unit> for Unit {
    fn from(of: crate::description::Unit) -> Unit {
        let display = |of: crate::description::DisplayUnit| DisplayUnit {
            name: of.name,
            factor: of.factor,
            offset: of.offset,
            inverse: false,
        };
        Unit {
            name: of.name,
            base_unit: of.base_unit,
            display_units: of.display_units.into_iter().map(display).collect(),
        }
    }
}

impl From<&Unit> for crate::description::Unit {
    /// Converts a unit, dropping reciprocal display units, which exist only in FMI 3.0.
    fn from(of: &Unit) -> crate::description::Unit {
        let display = |of: &DisplayUnit| crate::description::DisplayUnit {
            name: of.name.clone(),
            factor: of.factor,
            offset: of.offset,
        };
        crate::description::Unit {
            name: of.name.clone(),
            base_unit: of.base_unit,
            display_units: of.display_units.iter().filter(|unit| !unit.inverse).map(display).collect(),
        }
    }
}
