//! Findings about a description that the schema accepts.

use crate::sample::{everything, smallest, unknown, variable};
use modeldescription::v2::*;

/// Returns the findings about the sample after a change.
fn findings(change: impl FnOnce(&mut ModelDescription)) -> Vec<String> {
    let mut description = everything();
    change(&mut description);
    check(&description).all()
}

/// Returns the only finding about the sample after a change.
fn finding(change: impl FnOnce(&mut ModelDescription)) -> String {
    let findings = findings(change);
    assert_eq!(findings.len(), 1, "{findings:#?}");
    findings.into_iter().next().unwrap()
}

/// Whether a Real or a Boolean with these properties is accepted.
fn combination(causality: Causality, variability: Variability, initial: Option<Initial>, has_start: bool) -> bool {
    let start = has_start.then_some(1.0);
    let real = Typed::Real(Real { start, ..Real::default() });
    let variable = Variable { causality, variability, initial, ..variable("X", 0, real) };
    let is_unknown = causality == Causality::CalculatedParameter
        || causality == Causality::Output && !matches!(variable.initial_or_default(), Some(Initial::Exact));
    let structure = ModelStructure {
        outputs: if causality == Causality::Output { vec![unknown(1)] } else { Vec::new() },
        derivatives: Vec::new(),
        initial_unknowns: if is_unknown { vec![unknown(1)] } else { Vec::new() },
    };
    check(&ModelDescription { model_variables: vec![variable], model_structure: structure, ..smallest() })
        .all()
        .is_empty()
}

#[test]
fn there_is_nothing_to_say_of_a_description_that_is_right() {
    assert_eq!(check(&everything()).all(), Vec::<String>::new());
    assert_eq!(check(&smallest()).all(), Vec::<String>::new());
}

#[test]
fn a_start_outside_its_range_and_an_empty_range() {
    let real = |min, max, start| {
        Typed::Real(Real {
            attributes: RealAttributes { min, max, ..RealAttributes::default() },
            start,
            ..Real::default()
        })
    };
    let with = |typed| finding(|d| d.model_variables[4].typed = typed);
    assert!(with(real(Some(1.0), None, Some(0.5))).contains("variable \"input\": start = 0.5 is below min = 1.0"));
    assert!(with(real(None, Some(0.25), Some(0.5))).contains("variable \"input\": start = 0.5 is above max = 0.25"));
    assert!(with(real(Some(2.0), Some(1.0), Some(1.5))).contains("min = 2.0 is above max = 1.0"));
    assert!(with(real(Some(0.0), None, Some(f64::NAN))).contains("start = NaN"));
    assert_eq!(findings(|d| d.model_variables[4].typed = real(Some(0.5), Some(0.5), Some(0.5))), Vec::<String>::new());
}

#[test]
fn the_range_of_a_declared_type_holds_where_the_variable_gives_none() {
    let integer = |declared_type: &str, start| {
        Typed::Integer(Integer { declared_type: Some(declared_type.into()), start: Some(start), ..Integer::default() })
    };
    let with = |start, min, max| {
        findings(|d| {
            d.type_definitions[1].attributes = TypeAttributes::Integer(IntegerAttributes { quantity: None, min, max });
            d.model_variables[5].typed = integer("I", start);
        })
    };
    assert!(with(1, Some(2), None)[0].contains("start = 1 is below min = 2"));
    assert!(with(3, None, Some(2))[0].contains("start = 3 is above max = 2"));
    assert_eq!(with(2, Some(2), Some(2)), Vec::<String>::new());
    assert!(
        finding(|d| {
            d.type_definitions[0].attributes =
                TypeAttributes::Real(RealAttributes { min: Some(2.0), ..RealAttributes::default() });
            d.model_variables[0].typed =
                Typed::Real(Real { declared_type: Some("R".into()), start: Some(1.0), ..Real::default() });
        })
        .contains("start = 1.0 is below min = 2.0")
    );
}

#[test]
fn an_empty_range_of_a_type() {
    let finding = finding(|d| {
        let range = IntegerAttributes { quantity: None, min: Some(6), max: Some(-6) };
        d.type_definitions[1].attributes = TypeAttributes::Integer(range);
    });
    assert!(finding.contains("SimpleType \"I\": min = 6 is above max = -6"), "{finding}");
}

#[test]
fn units_types_and_display_units_that_are_not_defined() {
    let unit = |d: &mut ModelDescription, unit: &str| {
        let attributes = RealAttributes { unit: Some(unit.into()), ..RealAttributes::default() };
        d.model_variables[4].typed = Typed::Real(Real { attributes, start: Some(0.0), ..Real::default() });
    };
    assert!(finding(|d| unit(d, "furlong")).contains("variable \"input\": unit = \"furlong\" is not defined"));
    let display = finding(|d| {
        let Typed::Real(real) = &mut d.model_variables[0].typed else { panic!() };
        real.attributes.display_unit = Some("ms".into());
    });
    assert!(display.contains("displayUnit = \"ms\" is not a DisplayUnit of unit = \"odd\""), "{display}");
    let type_unit = finding(|d| {
        let attributes = RealAttributes { unit: Some("furlong".into()), ..RealAttributes::default() };
        d.type_definitions[0].attributes = TypeAttributes::Real(attributes);
    });
    assert!(type_unit.contains("SimpleType \"R\": unit = \"furlong\" is not defined"), "{type_unit}");
    let declared = finding(|d| {
        d.model_variables[6].typed = Typed::String(Text { declared_type: Some("T".into()), start: Some(String::new()) })
    });
    assert!(declared.contains("variable \"text\": declaredType = \"T\" is not defined"), "{declared}");
    let kind = finding(|d| {
        d.model_variables[6].typed = Typed::String(Text { declared_type: Some("B".into()), start: Some(String::new()) })
    });
    assert!(kind.contains("declaredType = \"B\" is not of type String"), "{kind}");
}

#[test]
fn a_display_unit_of_the_declared_types_unit_is_right() {
    let found = findings(|d| {
        let attributes = RealAttributes { display_unit: Some("odder".into()), ..RealAttributes::default() };
        let real = Real { declared_type: Some("R".into()), attributes, start: Some(0.0), ..Real::default() };
        d.model_variables[4].typed = Typed::Real(real);
    });
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn names_that_are_there_twice() {
    assert!(
        finding(|d| d.model_variables[5].name = "input".into()).contains("variable \"input\": the name is used twice")
    );
    let units = findings(|d| {
        let unit = d.unit_definitions[1].clone();
        d.unit_definitions.push(unit);
    });
    assert_eq!(units, ["Unit \"odd\" is defined twice: define it once"]);
    let files = finding(|d| {
        let files = &mut d.co_simulation.as_mut().unwrap().source_files;
        files.extend([SourceFile { name: "twice.c".into() }, SourceFile { name: "twice.c".into() }]);
    });
    assert_eq!(files, "CoSimulation: File \"twice.c\" is defined twice: define it once");
    let display_units = finding(|d| {
        let display_unit = d.unit_definitions[1].display_units[0].clone();
        d.unit_definitions[1].display_units.push(display_unit);
    });
    assert_eq!(display_units, "Unit \"odd\": DisplayUnit \"odder\" is defined twice: define it once");
    assert!(
        finding(|d| d.log_categories[1].name = "logStatusError".into())
            .contains("Category \"logStatusError\" is defined twice")
    );
    let types = finding(|d| {
        let simple_type = d.type_definitions[2].clone();
        d.type_definitions.push(simple_type);
    });
    assert_eq!(types, "SimpleType \"B\" is defined twice: define it once");
    let items = finding(|d| {
        let TypeAttributes::Enumeration(EnumerationType { items, .. }) = &mut d.type_definitions[4].attributes else {
            panic!()
        };
        items[0].name = "green".into();
    });
    assert_eq!(items, "SimpleType \"E\": Item \"green\" is defined twice: define it once");
}

#[test]
fn two_variables_that_can_be_set_with_one_value_reference() {
    // An Enumeration is set by fmi2SetInteger; a Boolean or a String with the same value reference is a different
    // variable.
    let found = finding(|d| d.model_variables[7].value_reference = 0);
    assert!(found.contains("variable \"choice\": valueReference = 0 is also used by \"integer\""), "{found}");
    assert_eq!(findings(|d| d.model_variables[4].value_reference = 2), Vec::<String>::new());
}

#[test]
fn indices_of_variables_that_do_not_exist() {
    for index in [0, 12] {
        let found = findings(|d| d.model_structure.outputs[1].index = index);
        assert!(
            found[0]
                .contains(&format!("Outputs: Unknown with index = {index}: no such variable; the indices are 1 to 11")),
            "{found:?}"
        );
        let found = finding(|d| d.model_structure.outputs[0].dependencies = Some(vec![1, index]));
        assert!(found.contains(&format!("dependencies has {index}")), "{found}");
        let found =
            findings(|d| d.model_variables[3].typed = Typed::Real(Real { derivative: Some(index), ..Real::default() }));
        assert!(found[0].contains(&format!("variable \"der(x)\": derivative = {index}")), "{found:?}");
    }
}

#[test]
fn as_many_kinds_as_dependencies() {
    let found = finding(|d| d.model_structure.derivatives[0].dependencies = Some(vec![1, 2]));
    assert!(found.contains("index = 4: dependenciesKind and dependencies differ in length (5 and 2)"), "{found}");
    let found = finding(|d| d.model_structure.derivatives[0].dependencies = None);
    assert!(found.contains("differ in length (5 and 0)"), "{found}");
}

#[test]
fn a_model_that_is_for_nothing() {
    let found = finding(|d| (d.model_exchange, d.co_simulation) = (None, None));
    assert!(found.contains("neither ModelExchange nor CoSimulation"), "{found}");
}

#[test]
fn a_library_that_has_another_name_than_its_model_or_one_that_c_has_not() {
    let rename = |identifier: &str| {
        findings(|d| {
            d.co_simulation.as_mut().unwrap().model_identifier = identifier.into();
            d.model_name = identifier.into();
        })
    };
    assert!(
        finding(|d| d.model_name = "OTHER".into())
            .contains("modelIdentifier = \"ALL\" differs from modelName = \"OTHER\"")
    );
    for wrong in ["", "1A", "A-B", "A.B", "Ä"] {
        assert!(rename(wrong)[0].contains("is not a C identifier"), "{wrong}");
    }
    for right in ["A", "_", "a1_B"] {
        assert_eq!(rename(right), Vec::<String>::new(), "{right}");
    }
}

#[test]
fn an_empty_guid_and_a_model_without_variables() {
    assert!(finding(|d| d.guid.clear()).contains("guid is empty"));
    let empty =
        ModelDescription { model_variables: Vec::new(), model_structure: ModelStructure::default(), ..smallest() };
    assert_eq!(check(&empty).all(), ["there are no variables: the schema requires at least one"]);
}

#[test]
fn characters_that_xml_cannot_hold() {
    assert!(
        finding(|d| d.description = Some("a\u{7}".into()))
            .contains("description: XML cannot represent the character '\\u{7}'")
    );
    let found = finding(|d| d.model_variables[4].description = Some("\u{ffff}".into()));
    assert!(found.contains("variable \"input\": XML cannot represent the character '\\u{ffff}'"), "{found}");
}

#[test]
fn an_experiment_that_cannot_be_simulated() {
    let with = |change: fn(&mut DefaultExperiment)| finding(|d| change(d.default_experiment.as_mut().unwrap()));
    for step_size in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let found = finding(|d| d.default_experiment.as_mut().unwrap().step_size = Some(step_size));
        assert!(found.contains(&format!("stepSize = {step_size:?}")), "{found}");
    }
    assert!(with(|e| e.tolerance = Some(0.0)).contains("tolerance = 0.0"));
    assert!(with(|e| e.stop_time = e.start_time).contains("stopTime = -0.5"));
}

#[test]
fn names_that_the_structured_naming_convention_does_not_have() {
    let is_right = |name: &str| {
        let mut description = smallest();
        description.variable_naming_convention = VariableNamingConvention::Structured;
        description.model_variables[0].name = name.into();
        check(&description).all().is_empty()
    };
    for right in [
        "a",
        "_a1",
        "a.b",
        "a[1]",
        "a[1,23].b",
        "'a b'",
        "'\\'\\n'.a",
        "der(a)",
        "der(a.b[1,2],2)",
        "der(a[1,2])",
        "der",
    ] {
        assert!(is_right(right), "{right}");
    }
    for wrong in [
        "",
        ".",
        "a.",
        ".a",
        "a..b",
        "1a",
        "a b",
        "ä",
        "a[",
        "a[]",
        "a[x]",
        "a[1",
        "a[1]b",
        "a]",
        "''",
        "'a",
        "'ä'",
        "'\\x'",
        "'a\"'",
        "a'b'",
        "der()",
        "der(a",
        "der(a,)",
        "der(a,b)",
        "der(a,1,2)",
        "a-b",
        "a\n",
    ] {
        assert!(!is_right(wrong), "{wrong}");
    }
}

#[test]
fn flat_names_may_be_anything() {
    let mut description = smallest();
    description.model_variables[0].name = "a b-1".into();
    assert_eq!(check(&description).all(), Vec::<String>::new());
}

#[test]
fn causality_variability_and_initial_go_together_as_the_standards_tables_say() {
    use Causality::*;
    use Variability::*;
    let all_initial = [None, Some(Initial::Exact), Some(Initial::Approx), Some(Initial::Calculated)];
    // What initial may be, and which of these needs a start; an empty list: they exclude each other.
    let [none, exact, approx, calculated] = all_initial;
    for (causality, variability, allowed) in [
        (Parameter, Constant, &[][..]),
        (Parameter, Fixed, &[none, exact]),
        (Parameter, Tunable, &[none, exact]),
        (Parameter, Discrete, &[]),
        (Parameter, Continuous, &[]),
        (CalculatedParameter, Constant, &[]),
        (CalculatedParameter, Fixed, &[none, approx, calculated]),
        (CalculatedParameter, Tunable, &[none, approx, calculated]),
        (CalculatedParameter, Discrete, &[]),
        (CalculatedParameter, Continuous, &[]),
        (Input, Constant, &[]),
        (Input, Fixed, &[]),
        (Input, Tunable, &[]),
        (Input, Discrete, &[none]),
        (Input, Continuous, &[none]),
        (Output, Constant, &[none, exact]),
        (Output, Fixed, &[]),
        (Output, Tunable, &[]),
        (Output, Discrete, &all_initial),
        (Output, Continuous, &all_initial),
        (Local, Constant, &[none, exact]),
        (Local, Fixed, &[none, approx, calculated]),
        (Local, Tunable, &[none, approx, calculated]),
        (Local, Discrete, &all_initial),
        (Local, Continuous, &all_initial),
        (Independent, Constant, &[]),
        (Independent, Fixed, &[]),
        (Independent, Tunable, &[]),
        (Independent, Discrete, &[]),
        (Independent, Continuous, &[none]),
    ] {
        for initial in all_initial {
            let needs_start = match initial {
                Some(Initial::Exact | Initial::Approx) => true,
                Some(Initial::Calculated) => false,
                None => matches!(causality, Parameter | Input) || variability == Constant,
            };
            let is_allowed = allowed.contains(&initial);
            let case = format!("{causality} {variability} {initial:?}");
            assert_eq!(combination(causality, variability, initial, needs_start), is_allowed, "{case}");
            assert!(!combination(causality, variability, initial, !needs_start), "{case}, start");
        }
    }
}

#[test]
fn only_a_real_is_continuous() {
    let found = finding(|d| {
        d.model_variables[7].variability = Variability::Continuous;
    });
    assert!(found.contains("variable \"choice\": variability = continuous: only a Real can be continuous"), "{found}");
}

#[test]
fn a_start_that_is_no_item_of_its_enumeration() {
    let found = finding(|d| {
        let Typed::Enumeration(enumeration) = &mut d.model_variables[7].typed else { panic!() };
        enumeration.start = Some(0);
    });
    assert!(
        found.contains("variable \"choice\": start = 0 is not the value of any item of its enumeration type"),
        "{found}"
    );
}

#[test]
fn the_model_structure_lists_exactly_the_unknowns_in_order() {
    let lists = |change: fn(&mut ModelStructure)| findings(|d| change(&mut d.model_structure));
    assert_eq!(lists(|s| drop(s.outputs.pop())), ["Outputs: variable \"constant\" (index 2) is missing: add it"]);
    assert_eq!(
        lists(|s| s.outputs.push(unknown(3))),
        ["Outputs: variable \"x\" (index 3) does not belong here: remove it"]
    );
    assert_eq!(lists(|s| s.outputs.push(unknown(1))), ["Outputs: a variable is listed twice: list it once"]);
    assert_eq!(lists(|s| s.outputs.reverse()), Vec::<String>::new());
    assert_eq!(
        lists(|s| drop(s.initial_unknowns.pop())),
        ["InitialUnknowns: variable \"calculated\" (index 9) is missing: add it"]
    );
    assert_eq!(
        lists(|s| drop(s.initial_unknowns.remove(1))),
        ["InitialUnknowns: variable \"x\" (index 3) is missing: add it"]
    );
    assert_eq!(
        lists(|s| s.initial_unknowns.push(unknown(10))),
        ["InitialUnknowns: variable \"v\" (index 10) does not belong here: remove it"]
    );
    assert_eq!(
        lists(|s| s.initial_unknowns.reverse()),
        ["InitialUnknowns: the indices are not in ascending order: sort them"]
    );
    assert_eq!(
        lists(|s| s.initial_unknowns.push(unknown(9))),
        ["InitialUnknowns: a variable is listed twice: list it once"]
    );
}

#[test]
fn of_many_findings_the_first_are_told_and_the_others_counted() {
    let found = findings(|d| d.model_structure.outputs.extend((0..1000).map(|k| unknown(100_000 + k))));
    // Two sentences on each of the 1000: the variable does not exist, and it is not an output.
    assert_eq!(found.len(), MOST_FINDINGS + 1, "{found:#?}");
    assert!(found[0].starts_with("Outputs: Unknown with index = 100000: no such variable"), "{}", found[0]);
    assert_eq!(found[MOST_FINDINGS], format!("and {} more", 2000 - MOST_FINDINGS));
}
