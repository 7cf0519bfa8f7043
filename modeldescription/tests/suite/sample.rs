//! A model description that contains every construct.

use modeldescription::v2::*;

fn some(text: &str) -> Option<String> {
    Some(text.into())
}

fn source_files(names: &[&str]) -> Vec<SourceFile> {
    names.iter().map(|name| SourceFile { name: (*name).into() }).collect()
}

/// A variable with only the required attributes.
pub(crate) fn variable(name: &str, value_reference: u32, typed: Typed) -> Variable {
    Variable {
        name: name.into(),
        value_reference,
        description: None,
        causality: Causality::Local,
        variability: Variability::Discrete,
        initial: None,
        can_handle_multiple_set_per_time_instant: None,
        typed,
    }
}

pub(crate) fn unknown(index: u32) -> Unknown {
    Unknown { index, dependencies: Some(Vec::new()), dependencies_kind: None }
}

/// A model with one variable, an output.
pub(crate) fn smallest() -> ModelDescription {
    ModelDescription {
        model_name: "SMALL".into(),
        guid: "{1}".into(),
        co_simulation: Some(CoSimulation { model_identifier: "SMALL".into(), ..CoSimulation::default() }),
        model_variables: vec![Variable {
            causality: Causality::Output,
            ..variable("OUT", 0, Typed::Real(Real::default()))
        }],
        model_structure: ModelStructure {
            outputs: vec![unknown(1)],
            initial_unknowns: vec![unknown(1)],
            ..ModelStructure::default()
        },
        ..ModelDescription::default()
    }
}

/// A model description with every element and attribute of FMI 2.0, about which [`check`] finds nothing.
pub(crate) fn everything() -> ModelDescription {
    ModelDescription {
        model_name: "ALL".into(),
        guid: "{6ee18890-bde5-f0fb-5f48-ca872bc22a19}".into(),
        description: some("Line one\nline two\ttab, \"quotes\" & 'more' <tags>"),
        author: some("Ärzte & Co"),
        version: some("1.2"),
        copyright: some("© nobody"),
        license: some("MIT OR Apache-2.0"),
        generation_tool: some("a hand"),
        generation_date_and_time: some("2026-01-02T03:04:05Z"),
        variable_naming_convention: VariableNamingConvention::Structured,
        number_of_event_indicators: Some(2),
        model_exchange: Some(ModelExchange {
            model_identifier: "ALL".into(),
            needs_execution_tool: true,
            completed_integrator_step_not_needed: true,
            can_be_instantiated_only_once_per_process: true,
            can_not_use_memory_management_functions: true,
            can_get_and_set_fmu_state: true,
            can_serialize_fmu_state: true,
            provides_directional_derivative: true,
            source_files: source_files(&["all.c"]),
        }),
        co_simulation: Some(CoSimulation {
            model_identifier: "ALL".into(),
            capabilities: Capabilities {
                needs_execution_tool: true,
                can_handle_variable_communication_step_size: true,
                can_interpolate_inputs: true,
                max_output_derivative_order: 3,
                can_run_asynchronuously: true,
                can_be_instantiated_only_once_per_process: true,
                can_not_use_memory_management_functions: true,
                can_get_and_set_fmu_state: true,
                can_serialize_fmu_state: true,
                provides_directional_derivative: true,
            },
            source_files: source_files(&["all.c", "sub/more.c"]),
        }),
        unit_definitions: vec![
            Unit { name: "1".into(), base_unit: None, display_units: Vec::new() },
            Unit {
                name: "odd".into(),
                base_unit: Some(BaseUnit {
                    kg: 1,
                    m: -2,
                    s: 3,
                    A: -4,
                    K: 5,
                    mol: -6,
                    cd: 7,
                    rad: -8,
                    factor: 0.1,
                    offset: -273.15,
                }),
                display_units: vec![
                    DisplayUnit { name: "odder".into(), factor: 1e-300, offset: 0.0 },
                    DisplayUnit { name: "oddest".into(), factor: 1.0, offset: 32.0 },
                ],
            },
            Unit {
                name: "s".into(),
                base_unit: Some(BaseUnit { s: 1, ..BaseUnit::default() }),
                display_units: Vec::new(),
            },
        ],
        type_definitions: types(),
        log_categories: vec![
            LogCategory { name: "logStatusError".into(), description: some("Errors") },
            LogCategory { name: "logAll".into(), description: None },
        ],
        default_experiment: Some(DefaultExperiment {
            start_time: Some(-0.5),
            stop_time: Some(1e5),
            tolerance: Some(1e-4),
            step_size: Some(0.01),
        }),
        model_variables: variables(),
        model_structure: ModelStructure {
            outputs: vec![unknown(1), Unknown { index: 2, dependencies: None, dependencies_kind: None }],
            derivatives: vec![Unknown {
                index: 4,
                dependencies: Some(vec![3, 5, 6, 7, 8]),
                dependencies_kind: Some(vec![
                    DependencyKind::Dependent,
                    DependencyKind::Constant,
                    DependencyKind::Fixed,
                    DependencyKind::Tunable,
                    DependencyKind::Discrete,
                ]),
            }],
            initial_unknowns: vec![unknown(1), unknown(3), unknown(4), unknown(9)],
        },
    }
}

fn types() -> Vec<SimpleType> {
    let simple_type = |name: &str, attributes| SimpleType { name: name.into(), description: None, attributes };
    vec![
        SimpleType {
            description: some("A real type"),
            ..simple_type(
                "R",
                TypeAttributes::Real(RealAttributes {
                    quantity: some("Torque"),
                    unit: some("odd"),
                    display_unit: some("odder"),
                    relative_quantity: Some(false),
                    min: Some(f64::NEG_INFINITY),
                    max: Some(f64::MAX),
                    nominal: Some(f64::MIN_POSITIVE),
                    unbounded: Some(true),
                }),
            )
        },
        simple_type(
            "I",
            TypeAttributes::Integer(IntegerAttributes {
                quantity: some("Count"),
                min: Some(i32::MIN),
                max: Some(i32::MAX),
            }),
        ),
        simple_type("B", TypeAttributes::Boolean(BooleanType {})),
        simple_type("S", TypeAttributes::String(StringType {})),
        simple_type(
            "E",
            TypeAttributes::Enumeration(EnumerationType {
                quantity: some("Colour"),
                items: vec![
                    Item { name: "red".into(), value: -1, description: some("Stop") },
                    Item { name: "green".into(), value: 7, description: None },
                ],
            }),
        ),
    ]
}

fn variables() -> Vec<Variable> {
    let real = |real| Typed::Real(real);
    let integer = IntegerAttributes { quantity: some("q"), min: Some(-5), max: Some(5) };
    let mut time = variable(
        "time",
        100,
        real(Real { attributes: RealAttributes { unit: some("s"), ..RealAttributes::default() }, ..Real::default() }),
    );
    (time.causality, time.variability) = (Causality::Independent, Variability::Continuous);
    vec![
        Variable {
            description: some("Output\nin two lines"),
            causality: Causality::Output,
            initial: Some(Initial::Approx),
            ..variable(
                "a.b[1,2].'c d'",
                0,
                real(Real {
                    declared_type: some("R"),
                    attributes: RealAttributes {
                        quantity: some("Power"),
                        unit: some("odd"),
                        display_unit: some("oddest"),
                        relative_quantity: Some(true),
                        min: Some(-0.0),
                        max: Some(1.0 / 3.0),
                        nominal: Some(0.1),
                        unbounded: Some(false),
                    },
                    start: Some(0.1),
                    ..Real::default()
                }),
            )
        },
        Variable {
            causality: Causality::Output,
            variability: Variability::Constant,
            initial: Some(Initial::Exact),
            ..variable("constant", 1, Typed::Boolean(Boolean { declared_type: some("B"), start: Some(true) }))
        },
        Variable { variability: Variability::Continuous, ..variable("x", 2, real(Real::default())) },
        Variable {
            variability: Variability::Continuous,
            ..variable("der(x)", 3, real(Real { derivative: Some(3), reinit: true, ..Real::default() }))
        },
        Variable {
            causality: Causality::Input,
            can_handle_multiple_set_per_time_instant: Some(false),
            ..variable("input", 4, real(Real { start: Some(f64::from(0.1_f32)), ..Real::default() }))
        },
        Variable {
            causality: Causality::Parameter,
            variability: Variability::Fixed,
            ..variable(
                "integer",
                0,
                Typed::Integer(Integer { declared_type: some("I"), attributes: integer.clone(), start: Some(-5) }),
            )
        },
        Variable {
            causality: Causality::Parameter,
            variability: Variability::Tunable,
            ..variable("text", 0, Typed::String(Text { declared_type: some("S"), start: some(" two  blanks\r\n") }))
        },
        Variable {
            causality: Causality::Input,
            ..variable(
                "choice",
                1,
                Typed::Enumeration(Enumeration {
                    declared_type: "E".into(),
                    attributes: IntegerAttributes { max: Some(7), ..integer },
                    start: Some(7),
                }),
            )
        },
        Variable {
            causality: Causality::CalculatedParameter,
            variability: Variability::Tunable,
            ..variable("calculated", 2, Typed::Integer(Integer::default()))
        },
        // An alias of der(x).
        Variable { variability: Variability::Continuous, ..variable("v", 3, real(Real::default())) },
        time,
    ]
}
