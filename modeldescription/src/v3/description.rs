//! What a modelDescription.xml of FMI 3.0 says, as plain data: one line for each attribute and each list, as for FMI 2.0.
//!
//! Structs and fields have the names that the standard gives to elements and attributes. If an attribute is absent, its
//! field has the standard's default, or is `None` where the standard has no default. Annotations are not kept: only the
//! tool that wrote them understands them.
//!
//! The fifteen elements that are variables have one struct, [`Variable`], and the fourteen that are types another,
//! [`TypeDefinition`]: what their lines mean is said in `attributes.rs`, what belongs to which element in `variable.rs`.

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

/// The version of the standard, as every model description of FMI 3.0 and its maintenance releases states it.
pub const FMI_VERSION: &str = "3.0";

elements! {
    /// A model description of FMI 3.0: the element `fmiModelDescription`.
    ModelDescription "fmiModelDescription" with "fmiVersion" = FMI_VERSION {
        /// The model's name.
        model_name "modelName": String;
        /// Identifies the interface; the functions that instantiate compare it with the library's.
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
        /// The tool that made the FMU.
        generation_tool "generationTool": Option<String>;
        /// When the FMU was made, as `xs:dateTime`.
        generation_date_and_time "generationDateAndTime": Option<String>;
        /// How the variables' names are formed.
        variable_naming_convention "variableNamingConvention": VariableNamingConvention = VariableNamingConvention::Flat;
    }, children {
        /// What the FMU can do in model exchange, if it supports that.
        model_exchange: Option<ModelExchange>;
        /// Its capabilities in co-simulation, if it supports that.
        co_simulation: Option<CoSimulation>;
        /// What the FMU can do in scheduled execution, if it supports that.
        scheduled_execution: Option<ScheduledExecution>;
        /// All units that are used.
        unit_definitions in "UnitDefinitions": Vec<Unit>;
        /// Types that variables refer to by `declaredType`.
        type_definitions in "TypeDefinitions": Vec<TypeDefinition>;
        /// The categories of the FMU's messages.
        log_categories in "LogCategories": Vec<LogCategory>;
        /// The simulation that the FMU proposes.
        default_experiment: Option<DefaultExperiment>;
        /// The variables. The model structure refers to them by their value references.
        model_variables in "ModelVariables", required: Vec<Variable>;
        /// Which variables are unknowns, and what they depend on.
        model_structure: ModelStructure;
    }

    /// What an FMU can do in any kind of simulation.
    InterfaceType {
        /// The name of the library.
        model_identifier "modelIdentifier": String;
        /// The FMU only connects to a tool, which has to be installed.
        needs_execution_tool "needsExecutionTool": bool = false;
        /// A process can hold only one instance.
        can_be_instantiated_only_once_per_process "canBeInstantiatedOnlyOncePerProcess": bool = false;
        /// The FMU's state can be saved and restored.
        can_get_and_set_fmu_state "canGetAndSetFMUState": bool = false;
        /// A saved state can be converted to bytes and back.
        can_serialize_fmu_state "canSerializeFMUState": bool = false;
        /// `fmi3GetDirectionalDerivative` works.
        provides_directional_derivatives "providesDirectionalDerivatives": bool = false;
        /// `fmi3GetAdjointDerivative` works.
        provides_adjoint_derivatives "providesAdjointDerivatives": bool = false;
        /// Dependencies are known element by element.
        provides_per_element_dependencies "providesPerElementDependencies": bool = false;
    }

    /// `ModelExchange`: what an FMU can do in a host that brings the solver.
    ModelExchange "ModelExchange" {
        /// What every kind of simulation has.
        of: InterfaceType;
        /// `fmi3CompletedIntegratorStep` has to be called.
        needs_completed_integrator_step "needsCompletedIntegratorStep": bool = false;
        /// `fmi3EvaluateDiscreteStates` works.
        provides_evaluate_discrete_states "providesEvaluateDiscreteStates": bool = false;
    }

    /// `CoSimulation`: what an FMU can do that brings its own solver.
    CoSimulation "CoSimulation" {
        /// What every kind of simulation has.
        of: InterfaceType;
        /// Communication steps may differ in size.
        can_handle_variable_communication_step_size "canHandleVariableCommunicationStepSize": bool = false;
        /// The step of the FMU's solver in seconds, if it is fixed.
        fixed_internal_step_size "fixedInternalStepSize": Option<f64>;
        /// The highest order of derivatives that outputs have.
        max_output_derivative_order "maxOutputDerivativeOrder": u32 = 0;
        /// How smooth inputs should be that are set in the intermediate update.
        recommended_intermediate_input_smoothness "recommendedIntermediateInputSmoothness": i32 = 0, omitted;
        /// The FMU calls the host within a step.
        provides_intermediate_update "providesIntermediateUpdate": bool = false;
        /// A step may end before its end.
        might_return_early_from_do_step "mightReturnEarlyFromDoStep": bool = false;
        /// The host may end a step in the intermediate update.
        can_return_early_after_intermediate_update "canReturnEarlyAfterIntermediateUpdate": bool = false;
        /// The FMU has Event Mode.
        has_event_mode "hasEventMode": bool = false;
        /// `fmi3EvaluateDiscreteStates` works.
        provides_evaluate_discrete_states "providesEvaluateDiscreteStates": bool = false;
    }

    /// `ScheduledExecution`: what an FMU can do in a host that activates its clocks.
    ScheduledExecution "ScheduledExecution" {
        /// What every kind of simulation has.
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
        /// Multiplied with a value.
        factor "factor": f64 = 1.0, omitted;
        /// Added to the product.
        offset "offset": f64 = 0.0, omitted;
        /// Whether the reciprocal of the value is displayed.
        inverse "inverse": bool = false, omitted;
    }

    /// The attributes that variables of all types have.
    Common {
        /// Its name.
        name "name": String;
        /// Its number in the C functions, which no other variable has.
        value_reference "valueReference": u32;
        /// A short text.
        description "description": Option<String>;
        /// Who sets it.
        causality "causality": Causality = Causality::Local;
        /// When it changes, if the file says so; see [`Variable::variability`].
        variability "variability": Option<Variability>;
        /// Model exchange only.
        can_handle_multiple_set_per_time_instant "canHandleMultipleSetPerTimeInstant": Option<bool>;
        /// The value references of the clocks that it changes with.
        clocks "clocks": Option<Vec<u32>>;
        /// It can be accessed in the intermediate update.
        intermediate_update "intermediateUpdate": Option<bool>;
        /// It is the value of the variable with this value reference at the last tick of the clock.
        previous "previous": Option<u32>;
        /// The type definition that it refers to.
        declared_type "declaredType": Option<String>;
        /// How it gets its first value, if the file says so; see [`Variable::initial_or_default`].
        initial "initial": Option<Initial>;
    }

    /// The attributes that a floating-point number and its declared type share. Those of a Float32 are decimals: the FMU has the
    /// nearest 32-bit numbers.
    FloatAttributes {
        /// The physical quantity, such as `Torque`.
        quantity "quantity": Option<String>;
        /// The unit of the values.
        unit "unit": Option<String>;
        /// The unit in which the values are displayed by default.
        display_unit "displayUnit": Option<String>;
        /// A difference, displayed without the offset of the display unit.
        relative_quantity "relativeQuantity": Option<bool>;
        /// Grows without bounds, as the angle of a shaft does.
        unbounded "unbounded": Option<bool>;
        /// The lowest value that the model is made for.
        min "min": Option<f64>;
        /// The highest value that the model is made for.
        max "max": Option<f64>;
        /// The order of magnitude.
        nominal "nominal": Option<f64>;
    }

    /// `Float32`, `Float64`
    Float {
        /// The attributes that type definitions have too.
        attributes: FloatAttributes;
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<f64>>;
        /// It is the derivative of the variable with this value reference.
        derivative "derivative": Option<u32>;
        /// Model exchange only: an event may set this state.
        reinit "reinit": bool = false, omitted;
    }

    /// The attributes that an integer and its declared type share.
    IntegerAttributes {
        /// The physical quantity.
        quantity "quantity": Option<String>;
        /// The lowest value that the model is made for.
        min "min": Option<i128>;
        /// The highest value that the model is made for.
        max "max": Option<i128>;
    }

    /// `Int8` to `UInt64`, and `Enumeration`
    Integer {
        /// The attributes that type definitions have too.
        attributes: IntegerAttributes;
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<i128>>;
    }

    /// `Boolean`
    Boolean {
        /// The values before initialization: one for each element, or one for all.
        start "start": Option<Vec<bool>>;
    }

    /// The attributes that a Binary and its declared type share.
    BinaryAttributes {
        /// What the bytes are.
        mime_type "mimeType": Option<String>;
        /// The most bytes.
        max_size "maxSize": Option<u64>;
    }

    /// The attributes that a Clock and its declared type share.
    ClockAttributes {
        /// The host may switch it off.
        can_be_deactivated "canBeDeactivated": bool = false, omitted;
        /// Scheduled execution only: a lower number comes first.
        priority "priority": Option<u32>;
        /// Who decides when it ticks.
        interval_variability "intervalVariability": IntervalVariability;
        /// The time between two ticks in seconds.
        interval_decimal "intervalDecimal": Option<f64>;
        /// The time of the first tick after the start, in seconds.
        shift_decimal "shiftDecimal": f64 = 0.0, omitted;
        /// The functions with fractions work.
        supports_fraction "supportsFraction": bool = false, omitted;
        /// What the counters are divided by.
        resolution "resolution": Option<u64>;
        /// The time between two ticks as a counter.
        interval_counter "intervalCounter": Option<u64>;
        /// The time of the first tick as a counter.
        shift_counter "shiftCounter": u64 = 0, omitted;
    }

    /// `Dimension`: one size of an array, as a number or as the value of a variable.
    Dimension "Dimension" {
        /// The size.
        start "start": Option<u64>;
        /// The value reference of the variable that is the size.
        value_reference "valueReference": Option<u32>;
    }

    /// `Start`: a text, or bytes as hexadecimal digits.
    Start "Start" {
        /// The value.
        value "value": Option<String>;
    }

    /// `Alias`: another name of a variable.
    Alias "Alias" {
        /// The name.
        name "name": String;
        /// A short text.
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
        /// A short text.
        description "description": Option<String>;
    }

    /// `ModelStructure`: which variables are unknowns, and what they depend on.
    ModelStructure "ModelStructure" {}, children {
        /// All outputs.
        outputs: Vec<Output>;
        /// All derivatives of continuous states.
        continuous_state_derivatives: Vec<ContinuousStateDerivative>;
        /// All states that change at ticks of clocks.
        clocked_states: Vec<ClockedState>;
        /// The unknowns in Initialization Mode.
        initial_unknowns: Vec<InitialUnknown>;
        /// The variables that signal events.
        event_indicators: Vec<EventIndicator>;
    }

    /// A variable that is computed from others.
    Unknown {
        /// The value reference of the variable.
        value_reference "valueReference": u32;
        /// The value references of the variables that it depends on; `None` means all.
        dependencies "dependencies": Option<Vec<u32>>;
        /// How it depends on each of them.
        dependencies_kind "dependenciesKind": Option<Vec<DependencyKind>>;
    }

    /// `Output`
    Output "Output" {
        /// The variable.
        unknown: Unknown;
    }

    /// `ContinuousStateDerivative`
    ContinuousStateDerivative "ContinuousStateDerivative" {
        /// The variable.
        unknown: Unknown;
    }

    /// `ClockedState`
    ClockedState "ClockedState" {
        /// The variable.
        unknown: Unknown;
    }

    /// `InitialUnknown`
    InitialUnknown "InitialUnknown" {
        /// The variable.
        unknown: Unknown;
    }

    /// `EventIndicator`
    EventIndicator "EventIndicator" {
        /// The variable.
        unknown: Unknown;
    }
}

words! {
    /// Who sets a variable.
    Causality {
        /// The host, before the simulation or, if tunable, between steps.
        Parameter "parameter",
        /// The FMU, from parameters.
        CalculatedParameter "calculatedParameter",
        /// Another FMU or the host, during the simulation.
        Input "input",
        /// The FMU, for others.
        Output "output",
        /// The FMU, for itself.
        Local "local",
        /// No one: it is the time.
        Independent "independent",
        /// The host, in Configuration Mode: sizes of arrays depend on it.
        StructuralParameter "structuralParameter",
    }

    /// Who decides when a clock ticks.
    #[derive(Default)]
    IntervalVariability {
        /// The file.
        Constant "constant",
        /// The FMU, before the first tick.
        Fixed "fixed",
        /// Parameters.
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
    /// The name of the library; that of co-simulation if the FMU supports more.
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
    /// Without reciprocal display units, which only FMI 3.0 has.
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
