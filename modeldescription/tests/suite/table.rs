//! From a block's table to a model description.

use modeldescription::v2::*;
use modeldescription::{Error, Interface, Names};

/// Returns a row in JSON as the `fmu` crate writes it.
fn row(name: &str, kind: &str, role: &str, rest: &str) -> String {
    let mut fields: Vec<String> = ["start", "min", "max", "unit"]
        .map(|field| if field == "start" { "\"start\":0.0".into() } else { format!("\"{field}\":null") })
        .into();
    for given in rest.split(", ").filter(|given| !given.is_empty()) {
        let (field, value) = given.split_once(' ').unwrap();
        let place = fields.iter().position(|known| known.starts_with(&format!("\"{field}\""))).unwrap();
        fields[place] = format!("\"{field}\":{value}");
    }
    let fields = fields.join(",");
    format!(r#"{{"name":"{name}","description":"About {name}","kind":"{kind}","role":"{role}",{fields}}}"#)
}

/// Returns a block with these rows after a CYCLE of 10 ms.
fn json(rows: &[String]) -> String {
    let cycle = row("CYCLE", "TIME", "cycle", "start 0.01, min 0.001");
    let rows: Vec<String> = [cycle].into_iter().chain(rows.iter().cloned()).collect();
    format!(
        r#"{{"table":{{"name":"BLOCK","docs":" Does it.\n In full.\n\n The law.\n","cycle":0,"mean":null,
        "variables":[{}],"responses":[{{"title":"t","calls":60,"set":[],"show":[]}}]}},
        "interface":{{"version":"2.0","guid":"{{0123}}",
        "capabilities":{{"canHandleVariableCommunicationStepSize":true,"canInterpolateInputs":true,
        "maxOutputDerivativeOrder":2,"canNotUseMemoryManagementFunctions":true,"canGetAndSetFMUstate":true,
        "canSerializeFMUstate":true,"canRunAsynchronuously":false}},
        "log_categories":[{{"name":"logStatusError","description":"Calls that were refused"}},
        {{"name":"logAll","description":null}}]}}}}"#,
        rows.join(",")
    )
}

fn of(rows: &[String]) -> Result<ModelDescription, Error> {
    ModelDescription::from_interface(&Interface::parse(&json(rows)).unwrap())
}

fn one(kind: &str, role: &str, rest: &str) -> Variable {
    of(&[row("X", kind, role, rest)]).unwrap_or_else(|error| panic!("{error}")).model_variables.remove(1)
}

fn refused(kind: &str, role: &str, rest: &str) -> String {
    of(&[row("X", kind, role, rest)]).unwrap_err().to_string()
}

fn real(variable: &Variable) -> &Real {
    match &variable.typed {
        Typed::Real(real) => real,
        other => panic!("{} instead of Real", other.name()),
    }
}

#[test]
fn the_model_has_the_name_the_guid_and_the_first_paragraph_of_the_block() {
    let description = of(&[]).unwrap();
    assert_eq!(description.model_name, "BLOCK");
    assert_eq!(description.model_identifier(), Some("BLOCK"));
    assert_eq!(description.guid, "{0123}");
    assert_eq!(description.description.as_deref(), Some("Does it. In full."));
    assert_eq!(description.variable_naming_convention, VariableNamingConvention::Structured);
    assert!(description.generation_tool.unwrap().starts_with("plcfmu "));
    assert_eq!(description.generation_date_and_time, None);
}

#[test]
fn a_variable_has_the_description_of_its_row_and_none_if_that_is_empty() {
    let undescribed = row("B", "REAL", "input", "").replace("About B", "");
    let variables = of(&[row("A", "REAL", "input", ""), undescribed]).unwrap().model_variables;
    let descriptions: Vec<_> = variables.iter().map(|variable| variable.description.as_deref()).collect();
    assert_eq!(descriptions, [Some("About CYCLE"), Some("About A"), None]);
}

#[test]
fn what_is_made_of_a_table_reads_back_as_it_was_written() {
    let rows = ["REAL", "LREAL", "TIME", "WORD", "INT", "BOOL"].map(|kind| row(kind, kind, "input", "start 1.0"));
    let description = of(&rows).unwrap();
    assert_eq!(read(&write(&description)).as_ref(), Ok(&description));
}

#[test]
fn it_is_for_co_simulation_only_and_has_the_capabilities_of_the_library() {
    let description = of(&[]).unwrap();
    assert_eq!(description.model_exchange, None);
    let expected = CoSimulation {
        model_identifier: "BLOCK".into(),
        capabilities: Capabilities {
            needs_execution_tool: false,
            can_handle_variable_communication_step_size: true,
            can_interpolate_inputs: true,
            max_output_derivative_order: 2,
            can_run_asynchronuously: false,
            can_be_instantiated_only_once_per_process: false,
            can_not_use_memory_management_functions: true,
            can_get_and_set_fmu_state: true,
            can_serialize_fmu_state: true,
            provides_directional_derivative: false,
        },
        source_files: Vec::new(),
    };
    assert_eq!(description.co_simulation, Some(expected));
}

#[test]
fn the_log_categories_are_those_of_the_library() {
    let expected = [
        LogCategory { name: "logStatusError".into(), description: Some("Calls that were refused".into()) },
        LogCategory { name: "logAll".into(), description: None },
    ];
    assert_eq!(of(&[]).unwrap().log_categories, expected);
}

#[test]
fn the_experiment_lasts_as_long_as_the_response_with_steps_of_the_default_cycle() {
    let expected =
        DefaultExperiment { start_time: Some(0.0), stop_time: Some(0.6), tolerance: None, step_size: Some(0.01) };
    assert_eq!(of(&[]).unwrap().default_experiment, Some(expected));
}

#[test]
fn a_response_without_a_call_still_leaves_a_step_to_simulate() {
    let interface = Interface::parse(&json(&[]).replace("\"calls\":60", "\"calls\":0")).unwrap();
    let experiment = ModelDescription::from_interface(&interface).unwrap().default_experiment.unwrap();
    assert_eq!(experiment.stop_time, Some(0.01));
}

#[test]
fn the_value_reference_is_the_number_of_the_row() {
    let rows = [row("A", "BOOL", "output", ""), row("B", "REAL", "input", ""), row("C", "INT", "local", "")];
    let variables = of(&rows).unwrap().model_variables;
    let references: Vec<(&str, u32)> = variables.iter().map(|v| (v.name.as_str(), v.value_reference)).collect();
    assert_eq!(references, [("CYCLE", 0), ("A", 1), ("B", 2), ("C", 3)]);
}

#[test]
fn a_role_decides_on_causality_variability_and_start() {
    use Causality::{Input, Local, Output, Parameter};
    use Variability::{Discrete, Fixed, Tunable};
    for (role, causality, variability, initial, has_start) in [
        ("input", Input, Discrete, None, true),
        ("parameter", Parameter, Tunable, Some(Initial::Exact), true),
        ("fixed", Parameter, Fixed, Some(Initial::Exact), true),
        ("output", Output, Discrete, Some(Initial::Calculated), false),
        ("local", Local, Discrete, Some(Initial::Calculated), false),
    ] {
        for kind in ["REAL", "LREAL", "TIME", "WORD", "INT", "BOOL"] {
            let variable = one(kind, role, "");
            let found = (variable.causality, variable.variability, variable.initial, variable.typed.has_start());
            assert_eq!(found, (causality, variability, initial, has_start), "{kind} {role}");
        }
    }
    let cycle = &of(&[]).unwrap().model_variables[0];
    assert_eq!((cycle.causality, cycle.variability, real(cycle).start), (Parameter, Fixed, Some(0.01)));
}

#[test]
fn a_type_decides_on_the_fmi_type() {
    let names = ["REAL", "LREAL", "TIME", "WORD", "INT", "BOOL"].map(|kind| one(kind, "input", "").typed.name());
    assert_eq!(names, ["Real", "Real", "Real", "Integer", "Integer", "Boolean"]);
}

#[test]
fn a_time_is_in_seconds_and_shown_in_milliseconds_and_no_other_type_is() {
    let time = one("TIME", "parameter", "start 20.0");
    let attributes = &real(&time).attributes;
    assert_eq!((attributes.unit.as_deref(), attributes.display_unit.as_deref()), (Some("s"), Some("ms")));
    let lreal = one("LREAL", "parameter", "start 20.0, unit \"s\"");
    let attributes = &real(&lreal).attributes;
    assert_eq!((attributes.unit.as_deref(), attributes.display_unit.as_deref()), (Some("s"), None));
}

#[test]
fn start_and_range_are_the_tables_bit_by_bit_and_no_other_range_is_there() {
    // 0.1 as a 32-bit REAL.
    let variable = one("REAL", "input", "start 0.10000000149011612, min -0.0, max 3.4028235e38");
    let found = real(&variable);
    assert_eq!(found.start.map(f64::to_bits), Some(f64::from(0.1_f32).to_bits()));
    assert_eq!(found.attributes.min.map(f64::to_bits), Some((-0.0_f64).to_bits()));
    assert_eq!(found.attributes.max, Some(3.4028235e38));
    for kind in ["REAL", "LREAL", "TIME"] {
        let attributes = &real(&one(kind, "input", "")).attributes.clone();
        assert_eq!((attributes.min, attributes.max), (None, None), "{kind}");
    }
    for (kind, rest, expected) in [
        ("WORD", "", (None, None, Some(0))),
        ("INT", "", (None, None, Some(0))),
        ("INT", "start -3.0, min -32767.0, max 32767.0", (Some(-32767), Some(32767), Some(-3))),
    ] {
        let Typed::Integer(integer) = one(kind, "input", rest).typed else { panic!() };
        assert_eq!((integer.attributes.min, integer.attributes.max, integer.start), expected);
    }
    let Typed::Boolean(boolean) = one("BOOL", "input", "start 1.0").typed else { panic!() };
    assert_eq!(boolean.start, Some(true));
}

#[test]
fn all_outputs_and_nothing_else_are_unknowns_and_depend_on_nothing() {
    let rows = [
        row("IN", "REAL", "input", ""),
        row("OUT", "REAL", "output", ""),
        row("INNER", "REAL", "local", ""),
        row("Q", "BOOL", "output", ""),
    ];
    let structure = of(&rows).unwrap().model_structure;
    let unknown = |index| Unknown { index, dependencies: Some(Vec::new()), dependencies_kind: None };
    assert_eq!(structure.outputs, [unknown(3), unknown(5)]);
    assert_eq!(structure.initial_unknowns, [unknown(3), unknown(5)]);
    assert_eq!(structure.derivatives, []);
}

#[test]
fn the_restart_value_of_an_output_depends_on_the_settings_that_the_table_names() {
    let rows = [
        row("GAIN", "REAL", "parameter", ""),
        row("FIRST", "INT", "fixed", ""),
        row("OUT", "REAL", "output", "").replace('}', ",\"from\":[\"FIRST\",\"CYCLE\"]}"),
        row("Q", "BOOL", "output", ""),
    ];
    let structure = of(&rows).unwrap().model_structure;
    let unknown = |index, dependencies: &[u32]| Unknown {
        index,
        dependencies: Some(dependencies.into()),
        dependencies_kind: None,
    };
    assert_eq!(structure.outputs, [unknown(4, &[]), unknown(5, &[])]);
    assert_eq!(structure.initial_unknowns, [unknown(4, &[1, 3]), unknown(5, &[])]);
}

#[test]
fn a_restart_value_from_what_is_no_setting_is_refused() {
    for other in ["IN", "OUT", "NOSUCH"] {
        let output = row("OUT", "REAL", "output", "").replace('}', &format!(",\"from\":[\"{other}\"]}}"));
        let error = Interface::parse(&json(&[row("IN", "REAL", "input", ""), output])).unwrap_err().to_string();
        assert!(error.contains(&format!("the restart value of OUT depends on {other:?}")), "{error}");
    }
}

#[test]
fn every_unit_that_is_used_is_defined_once_and_no_other_is() {
    let rows = [
        row("A", "LREAL", "input", "unit \"degC\""),
        row("B", "LREAL", "input", "unit \"%\""),
        row("C", "REAL", "output", "unit \"degC\""),
    ];
    let units = of(&rows).unwrap().unit_definitions;
    assert_eq!(units.iter().map(|unit| unit.name.as_str()).collect::<Vec<_>>(), ["%", "s", "degC"]);
    assert_eq!(units[0].base_unit, Some(BaseUnit { factor: 0.01, ..BaseUnit::default() }));
    assert_eq!(units[1].base_unit, Some(BaseUnit { s: 1, ..BaseUnit::default() }));
    assert_eq!(units[2].base_unit, Some(BaseUnit { K: 1, offset: 273.15, ..BaseUnit::default() }));
}

#[test]
fn a_second_is_shown_as_1000_milliseconds() {
    let second = &of(&[]).unwrap().unit_definitions[0];
    assert_eq!(second.display_units, [DisplayUnit { name: "ms".into(), factor: 1000.0, offset: 0.0 }]);
}

#[test]
fn an_unknown_unit_is_named_with_its_variable_and_the_known_ones() {
    let error = refused("LREAL", "input", "unit \"furlong\"");
    assert!(error.contains("variable X") && error.contains("\"furlong\"") && error.contains("degC, K/s"), "{error}");
}

#[test]
fn a_unit_that_fmi_cannot_express_is_refused() {
    assert!(refused("INT", "input", "unit \"rpm\"").contains("an FMI Integer cannot have a unit"));
    for given in ["unit \"1\"", "min 0.0", "max 1.0"] {
        assert!(refused("BOOL", "input", given).contains("a BOOL cannot have a unit or a range"), "{given}");
    }
    assert!(refused("TIME", "input", "unit \"min\"").contains("unit \"min\": a TIME is in seconds"));
    assert_eq!(real(&one("TIME", "input", "unit \"s\"")).attributes.unit.as_deref(), Some("s"));
}

#[test]
fn a_value_that_its_type_does_not_have_is_refused() {
    let refused = |kind: &str, rest: &str| {
        let error = Interface::parse(&json(&[row("X", kind, "input", rest)])).unwrap_err();
        error.to_string()
    };
    assert_eq!(refused("INT", "start 0.5"), "the library's table of BLOCK: X is 0.5: an INT accepts -32768 ... 32767");
    assert!(refused("INT", "max 32768.0").contains("X is 32768.0: an INT accepts"));
    assert!(refused("WORD", "start -32769.0").contains("X is -32769.0: a WORD accepts"));
    assert!(refused("BOOL", "start 2.0").contains("X is 2.0: a BOOL accepts 0 and 1"));
}

#[test]
fn a_start_out_of_range_and_an_empty_range_are_refused() {
    assert!(refused("REAL", "input", "start 5.0, max 3.0").contains("start = 5.0 is above max = 3.0"));
    assert!(refused("INT", "fixed", "start -1.0, min 0.0").contains("start = -1 is below min = 0"));
    assert!(refused("LREAL", "output", "min 2.0, max 1.0").contains("min = 2.0 is above max = 1.0"));
}

#[test]
fn one_name_that_is_not_structured_makes_the_convention_flat() {
    use VariableNamingConvention::{Flat, Structured};
    for (name, convention) in [
        ("a.b[1,2]", Structured),
        ("'Groesse [m]'.x", Structured),
        ("GRÖSSE", Flat),
        ("'Größe [m]'.x", Flat),
        ("a[-1]", Flat),
    ] {
        let description = of(&[row("A", "REAL", "output", ""), row(name, "REAL", "output", "")]).unwrap();
        assert_eq!(description.variable_naming_convention, convention, "{name}");
    }
}

#[test]
fn flat_names_have_no_dots_and_indices() {
    let flat = |rows: &[String]| {
        let interface = Interface::parse(&json(rows))?;
        ModelDescription::from_interface(&Interface { names: Names::Flat, ..interface })
    };
    let row = |name: &str| row(name, "REAL", "output", "");
    let description = flat(&[row("par.level"), row("m[1,2]")]).unwrap();
    let names: Vec<&str> = description.model_variables.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["CYCLE", "par_level", "m_1_2"]);
    assert_eq!(description.variable_naming_convention, VariableNamingConvention::Flat);
    assert_eq!(
        flat(&[row("par.level"), row("par_level")]).unwrap_err().to_string(),
        "BLOCK: par.level and par_level both have the flat name par_level: rename one of them"
    );
}

#[test]
fn names_that_no_host_can_use_are_refused() {
    let error = of(&[row("CYCLE", "REAL", "output", "")]).unwrap_err().to_string();
    assert!(error.contains("\"CYCLE\": the name is used twice"), "{error}");
    let interface = Interface::parse(&json(&[]).replace("\"BLOCK\"", "\"MY-BLOCK\"")).unwrap();
    let error = ModelDescription::from_interface(&interface).unwrap_err().to_string();
    assert!(error.contains("\"MY-BLOCK\" is not a C identifier"), "{error}");
}
