//! Model descriptions of FMI 3.0: files of other tools, conversion of a table, and rejected files.

use blocks::Types;
use modeldescription::v3::*;
use modeldescription::{Interface, Names, Type};

/// A model description as other tools write it, with every element and attribute of FMI 3.0.
const FOREIGN: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="ALL" instantiationToken="{7}" description="d" author="a" version="1"
  copyright="c" license="l" generationTool="g" generationDateAndTime="2026-11-25T00:00:00Z" variableNamingConvention="flat">
  <ModelExchange modelIdentifier="ALL" needsExecutionTool="true" canBeInstantiatedOnlyOncePerProcess="true"
    canGetAndSetFMUState="true" canSerializeFMUState="true" providesDirectionalDerivatives="true"
    providesAdjointDerivatives="true" providesPerElementDependencies="true" needsCompletedIntegratorStep="true"
    providesEvaluateDiscreteStates="true"><Annotations><Annotation type="x">any <b>thing</b></Annotation></Annotations></ModelExchange>
  <CoSimulation modelIdentifier="ALL" canHandleVariableCommunicationStepSize="true" fixedInternalStepSize="0.01"
    maxOutputDerivativeOrder="2" recommendedIntermediateInputSmoothness="-1" providesIntermediateUpdate="true"
    mightReturnEarlyFromDoStep="true" canReturnEarlyAfterIntermediateUpdate="true" hasEventMode="true"
    providesEvaluateDiscreteStates="true"/>
  <ScheduledExecution modelIdentifier="ALL"/>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1"/><DisplayUnit name="cm" factor="100"/><DisplayUnit name="1/m" inverse="true"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <Float32Type name="F32" unit="m" min="-1"/><Float64Type name="F64" description="t" quantity="q" unit="m" displayUnit="cm"
      relativeQuantity="true" unbounded="true" min="0" max="9" nominal="2"/>
    <Int8Type name="I8"/><UInt8Type name="U8"/><Int16Type name="I16"/><UInt16Type name="U16"/><Int32Type name="I32"/>
    <UInt32Type name="U32"/><Int64Type name="I64"/><UInt64Type name="U64" max="18446744073709551615"/>
    <BooleanType name="B"/><StringType name="S"/><BinaryType name="Y" mimeType="a/b" maxSize="9"/>
    <EnumerationType name="E" quantity="q" min="1" max="2"><Item name="one" value="1" description="d"/><Item name="two" value="2"/></EnumerationType>
    <ClockType name="C" canBeDeactivated="true" priority="1" intervalVariability="constant" intervalDecimal="0.5" shiftDecimal="0.25"
      supportsFraction="true" resolution="4" intervalCounter="2" shiftCounter="1"/>
  </TypeDefinitions>
  <LogCategories><Category name="logAll" description="d"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" tolerance="1e-4" stepSize="0.1"><Annotations/></DefaultExperiment>
  <ModelVariables>
    <UInt64 name="n" valueReference="1" causality="structuralParameter" start="3"/>
    <Float32 name="narrow" valueReference="2" causality="parameter" declaredType="F32" start="0.1"/>
    <Float64 name="vector" valueReference="3" description="d" causality="input" variability="continuous" declaredType="F64"
      intermediateUpdate="true" unit="m" displayUnit="cm" start="1 2 3"><Dimension valueReference="1"/>
      <Alias name="other" description="o" displayUnit="1/m"/></Float64>
    <Float64 name="matrix" valueReference="4" causality="parameter" variability="tunable" start="5"><Dimension start="2"/><Dimension valueReference="1"/></Float64>
    <Int8 name="i8" valueReference="5" causality="parameter" start="-128"/>
    <UInt8 name="u8" valueReference="6" causality="parameter" start="255" max="255"/>
    <Int16 name="i16" valueReference="7" causality="parameter" start="-32768"/>
    <UInt16 name="u16" valueReference="8" causality="parameter" start="65535"/>
    <Int32 name="i32" valueReference="9" causality="parameter" start="-2147483648"/>
    <UInt32 name="u32" valueReference="10" causality="parameter" start="4294967295"/>
    <Int64 name="i64" valueReference="11" causality="parameter" start="-9223372036854775808"/>
    <UInt64 name="u64" valueReference="12" causality="parameter" start="18446744073709551615"/>
    <Boolean name="b" valueReference="13" causality="input" start="true 0"><Dimension start="2"/></Boolean>
    <String name="s" valueReference="14" causality="parameter"><Start value="a b"/></String>
    <Binary name="y" valueReference="15" causality="parameter" mimeType="a/b" maxSize="4"><Start value="00ff"/></Binary>
    <Enumeration name="e" valueReference="16" causality="input" declaredType="E" start="2"/>
    <Clock name="c" valueReference="17" causality="input" intervalVariability="triggered"/>
    <Float64 name="x" valueReference="18" causality="output" initial="exact" start="1" clocks="17" previous="19"/>
    <Float64 name="v" valueReference="19" derivative="20" canHandleMultipleSetPerTimeInstant="false"/>
    <Float64 name="p" valueReference="20" causality="output" reinit="true"/>
    <Float64 name="time" valueReference="0" causality="independent"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="18" dependencies="3 13" dependenciesKind="dependent constant"/>
    <Output valueReference="20" dependencies=""/>
    <ContinuousStateDerivative valueReference="19"/>
    <ClockedState valueReference="18"/>
    <InitialUnknown valueReference="19"/>
    <InitialUnknown valueReference="20"/>
    <EventIndicator valueReference="19"/>
  </ModelStructure>
  <Annotations><Annotation type="x"/></Annotations>
</fmiModelDescription>
"#;

fn parsed(xml: &str) -> ModelDescription {
    read(xml.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the reason why the foreign description is rejected after a text that occurs in it once has been replaced.
fn refused(from: &str, to: &str) -> String {
    assert_eq!(FOREIGN.matches(from).count(), 1, "{from}");
    match read(FOREIGN.replacen(from, to, 1).as_bytes()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{to} is taken"),
    }
}

/// Returns the findings about it after a change.
fn findings(from: &str, to: &str) -> Vec<String> {
    assert_eq!(FOREIGN.matches(from).count(), 1, "{from}");
    check(&parsed(&FOREIGN.replacen(from, to, 1))).all()
}

#[test]
fn what_is_written_reads_back_and_nothing_is_lost() {
    let description = parsed(FOREIGN);
    let xml = write(&description);
    assert_eq!(read(&xml).unwrap(), description);
    assert_eq!(write(&read(&xml).unwrap()), xml);
    // All attributes of the original, except white space, annotations, defaults and the order.
    let attributes = |xml: &str| {
        let mut all: Vec<String> = xml
            .split(|one: char| "<>\n".contains(one))
            .flat_map(|tag| tag.split("\" "))
            .map(|one| one.trim().trim_end_matches(['/', '"', '?']).to_string())
            .map(|one| one.rsplit(' ').next().filter(|_| !one.contains("=\"")).map_or(one.clone(), str::to_string))
            .filter(|one| one.contains("valueReference=") || one.contains("ALL"))
            .collect();
        all.sort();
        all.len()
    };
    assert_eq!(attributes(&String::from_utf8(xml).unwrap()), attributes(FOREIGN));
    assert_eq!(check(&description).all(), Vec::<String>::new());
}

#[test]
fn what_it_says_is_the_same_as_of_any_version() {
    let of = parsed(FOREIGN).description();
    assert_eq!((of.fmi_version, of.guid.as_str(), of.model_identifier()), ("3.0", "{7}", Some("ALL")));
    let can = of.co_simulation.as_ref().unwrap();
    assert!(can.can("hasEventMode") && !can.can("canGetAndSetFMUstate") && !can.can("modelIdentifier"));
    assert!(of.model_exchange.as_ref().unwrap().can("canGetAndSetFMUstate") && of.scheduled_execution.is_some());
    let vector = of.variable("vector").unwrap();
    assert_eq!((vector.dimensions.as_slice(), vector.count()), ([3].as_slice(), 3));
    assert_eq!((vector.starts.as_slice(), vector.start), ([1.0, 2.0, 3.0].as_slice(), Some(1.0)));
    assert_eq!((vector.min, vector.max, vector.display_unit.as_deref()), (Some(0.0), Some(9.0), Some("cm")));
    let alias = of.variable("other").unwrap();
    assert_eq!((alias.value_reference, alias.display_unit.as_deref()), (3, Some("1/m")));
    // One value for all elements, in two dimensions.
    let matrix = of.variable("matrix").unwrap();
    assert_eq!((matrix.dimensions.as_slice(), matrix.starts.as_slice()), ([2, 3].as_slice(), [5.0; 6].as_slice()));
    let size = of.variable("n").unwrap();
    assert!(size.is_structural && !size.is_settable() && size.variability == modeldescription::Variability::Fixed);
    let kinds = ["narrow", "i8", "u64", "b", "s", "y", "e", "c"].map(|name| {
        let variable = of.variable(name).unwrap();
        (variable.type_name, variable.kind)
    });
    assert_eq!(
        kinds,
        [
            ("Float32", Some(Type::Real)),
            ("Int8", Some(Type::Integer)),
            ("UInt64", Some(Type::Integer)),
            ("Boolean", Some(Type::Boolean)),
            ("String", None),
            ("Binary", None),
            ("Enumeration", Some(Type::Integer)),
            ("Clock", None)
        ]
    );
    // The 32-bit number nearest to 0.1, as stored in the library.
    assert_eq!(of.start("narrow"), Some(0.100_000_001_490_116_12));
    assert_eq!((of.start("i64"), of.start("b")), (Some(-9_223_372_036_854_775_808.0), Some(1.0)));
    // Start values of 64 bits are exact.
    let all = of.clone().expanded();
    let exact = |name: &str| (all.variable(name).unwrap().exact.clone(), all.variable(name).unwrap().start_cell());
    let cell = |bits: u64| Some(f64::from_bits(bits));
    assert_eq!(exact("u64").0, [u64::MAX.into()]);
    assert_eq!(exact("u64").1.map(f64::to_bits), cell(u64::MAX).map(f64::to_bits));
    assert_eq!((exact("i64").0, exact("u8").1), (vec![i64::MIN.into()], Some(255.0)));
    assert_eq!(exact("matrix[2,3]"), (vec![], Some(5.0)));
    assert_eq!(of.variable("s").unwrap().start_text.as_deref(), Some("a b"));
    assert_eq!(of.units[0].display_units.len(), 1, "a reciprocal unit is none that others know");
}

#[test]
fn what_contradicts_itself_is_refused_with_its_line() {
    for (from, to, words) in [
        ("start=\"1 2 3\"", "start=\"1 2\"", "variable \"vector\": start and the array differ in length (2 and 3)"),
        ("valueReference=\"6\"", "valueReference=\"5\"", "variable \"u8\": valueReference = 5 is also used by \"i8\""),
        ("start=\"255\"", "start=\"256\"", "variable \"u8\": start = 256 is above max = 255"),
        ("start=\"65535\"", "start=\"65536\"", "variable \"u16\": 65536 is outside the range of UInt16, 0 to 65535"),
        ("start=\"65535\"", "start=\"0.5\"", "UInt16: start = \"0.5\": expected a list"),
        ("start=\"0.1\"", "start=\"-2\"", "variable \"narrow\": start = -2.0 is below min = -1.0"),
        ("<Alias name=\"other\"", "<Alias name=\"i8\"", "the name \"i8\" is used twice"),
        (
            "<Dimension start=\"2\"/><Dimension",
            "<Dimension start=\"0\"/><Dimension",
            "variable \"matrix\": Dimension: the size is 0",
        ),
        (
            "<Dimension start=\"2\"/><Dimension",
            "<Dimension/><Dimension",
            "Dimension: it must have either start or valueReference",
        ),
        (
            "start=\"1 2 3\"><Dimension valueReference=\"1\"/>",
            "start=\"1 2 3\"><Dimension valueReference=\"12\"/>",
            "valueReference = 12 does not refer to a UInt64 constant",
        ),
        (
            "declaredType=\"E\"",
            "declaredType=\"I32\"",
            "variable \"e\": declaredType = \"I32\" is not of type Enumeration",
        ),
        ("unit=\"m\" displayUnit=\"cm\" start", "unit=\"km\" start", "unit = \"km\" is not defined"),
        (
            "dependencies=\"3 13\"",
            "dependencies=\"3\"",
            "Output: valueReference = 18: dependenciesKind and dependencies differ in length (2 and 1)",
        ),
        (
            "<ClockedState valueReference=\"18\"",
            "<ClockedState valueReference=\"99\"",
            "no variable has the value reference 99",
        ),
        ("<Start value=\"a b\"/>", "<Item name=\"a\" value=\"1\"/>", "FMI 3.0 has no such element inside String"),
        ("intervalVariability=\"triggered\"", "", "Clock: attribute intervalVariability is missing"),
    ] {
        let error = refused(from, to);
        assert!(error.contains(words), "{words:?} is not in: {error}");
    }
    assert!(refused("start=\"1 2 3\"", "start=\"1 2\"").starts_with("line "));
}

#[test]
fn what_misleads_a_host_is_found() {
    for (from, to, words) in [
        ("<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\"/>", "", "0 variables are independent"),
        ("causality=\"input\" start=\"true 0\"", "causality=\"input\"", "variable \"b\": start is missing"),
        (
            "<Output valueReference=\"20\" dependencies=\"\"/>",
            "",
            "Output: variable \"p\" (valueReference 20) is missing",
        ),
        (
            "<InitialUnknown valueReference=\"20\"/>",
            "",
            "InitialUnknown: variable \"p\" (valueReference 20) is missing",
        ),
        ("displayUnit=\"cm\" start", "displayUnit=\"mm\" start", "displayUnit = \"mm\" is not a DisplayUnit"),
        (
            "causality=\"parameter\" start=\"-128\"",
            "causality=\"parameter\" variability=\"discrete\" start=\"-128\"",
            "causality = parameter and variability = discrete are not allowed together",
        ),
        (
            "causality=\"input\" start=\"true 0\"",
            "causality=\"input\" variability=\"continuous\" start=\"1\"",
            "only a Float32 or Float64 can be continuous",
        ),
        ("modelName=\"ALL\"", "modelName=\"OTHER\"", "modelIdentifier = \"ALL\" differs from modelName"),
        ("variableNamingConvention=\"flat\"", "variableNamingConvention=\"structured\" ", ""),
    ] {
        let found = findings(from, to);
        match words {
            "" => assert_eq!(found, Vec::<String>::new()),
            words => assert!(found.len() == 1 && found[0].contains(words), "{words:?} is not in {found:?}"),
        }
    }
}

/// Returns what a library reports about a block with variables of these types.
fn interface(types: Types) -> Interface {
    let row = |name: &str, kind: &str, role: &str, start: &str, more: &str| {
        format!(
            r#"{{"name":"{name}","description":"","kind":"{kind}","role":"{role}","start":{start},"min":null,"max":null,"unit":null{more}}}"#
        )
    };
    let rows = [
        row("r", "REAL", "input", "0.10000000149011612", ""),
        row("count", "LINT", "parameter", "9007199254740992.0", r#","exact":9007199254740993"#),
        row("bits", "DWORD", "input", "4294967295.0", ""),
        row("a[0]", "REAL", "input", "1.0", ""),
        row("a[1]", "REAL", "input", "2.0", ""),
        row("y", "REAL", "output", "0.0", r#","from":["wait"]"#),
        row("wait", "TIME", "parameter", "0.25", ""),
        row("long", "LTIME", "parameter", "0.5", ""),
        row("CYCLE", "TIME", "cycle", "0.1", ""),
    ];
    let json = format!(
        r#"{{"table":{{"name":"PUMP","docs":"Pumps.","cycle":8,"mean":null,"variables":[{}],
        "texts":[{{"name":"t","description":"","type":"STRING[9]","role":"input","start":"on"}}],
        "responses":[{{"title":"x","calls":3,"set":[],"show":[]}}]}},
        "interface":{{"version":"2.0","guid":"{{1}}","capabilities":{{"canGetAndSetFMUstate":true}},"log_categories":[]}}}}"#,
        rows.join(",")
    );
    Interface { version: FMI_VERSION.into(), types, ..Interface::parse(&json).unwrap() }
}

/// Returns the XML line of a variable.
fn line(xml: &str, name: &str) -> String {
    let found = xml.lines().find(|line| line.contains(&format!(" name=\"{name}\"")));
    found.unwrap_or_else(|| panic!("{name} is missing in\n{xml}")).trim().to_string()
}

#[test]
fn a_table_has_the_types_that_the_plc_has() {
    let description = ModelDescription::from_interface(&interface(Types::Native)).unwrap();
    assert_eq!(description.instantiation_token, token("{1}", Types::Native));
    let xml = String::from_utf8(write(&description)).unwrap();
    assert_eq!(
        line(&xml, "r"),
        r#"<Float32 name="r" valueReference="0" causality="input" variability="discrete" start="0.1"/>"#
    );
    assert!(line(&xml, "count").starts_with("<Int64 ") && line(&xml, "count").contains(r#"start="9007199254740993""#));
    assert!(line(&xml, "bits").starts_with("<UInt32 ") && line(&xml, "bits").contains(r#"start="4294967295""#));
    assert!(line(&xml, "a").starts_with(r#"<Float32 name="a" valueReference="3" description="ARRAY[0..1]""#));
    assert!(line(&xml, "a").contains(r#"start="1.0 2.0""#) && xml.contains(r#"<Dimension start="2"/>"#));
    assert!(line(&xml, "wait").starts_with(r#"<Int32 name="wait" valueReference="6" description="in ms""#));
    assert!(line(&xml, "wait").contains(r#"start="250""#) && line(&xml, "long").contains(r#"start="500000000""#));
    assert!(line(&xml, "t").starts_with("<String ") && xml.contains(r#"<Start value="on"/>"#));
    let last = xml.lines().rfind(|line| line.contains(" name=")).unwrap().trim();
    assert!(last.starts_with(r#"<Float64 name="time" valueReference="10""#), "{last}");
    assert!(xml.contains(r#"<Output valueReference="5" dependencies=""/>"#), "{xml}");
    assert!(xml.contains(r#"<InitialUnknown valueReference="5" dependencies="6"/>"#));
    assert!(xml.contains("canGetAndSetFMUState=\"true\"") && xml.contains("hasEventMode=\"true\""));
    assert!(!xml.contains("UnitDefinitions"), "integers have no unit");
}

#[test]
fn a_table_with_wide_types_has_doubles_and_each_element() {
    let description = ModelDescription::from_interface(&interface(Types::Wide)).unwrap();
    assert_eq!(description.instantiation_token, token("{1}", Types::Wide));
    assert_ne!(description.instantiation_token, token("{1}", Types::Native));
    let xml = String::from_utf8(write(&description)).unwrap();
    assert!(line(&xml, "r").starts_with("<Float64 ") && line(&xml, "r").contains(r#"start="0.10000000149011612""#));
    assert!(line(&xml, "bits").starts_with("<Int32 ") && line(&xml, "bits").contains(r#"start="-1""#));
    assert!(line(&xml, "a[1]").contains(r#"valueReference="4""#) && !xml.contains("Dimension"));
    assert!(line(&xml, "wait").contains(r#"unit="s" displayUnit="ms" start="0.25""#), "{}", line(&xml, "wait"));
    assert!(line(&xml, "count").starts_with("<Int64 "));
    assert!(xml.contains(r#"<Unit name="s">"#));
}

#[test]
fn flat_names_have_no_dots_and_indices() {
    let flat = |types, first: &str| {
        let mut interface = Interface { names: Names::Flat, ..interface(types) };
        interface.table.rows[0].name = first.into();
        ModelDescription::from_interface(&interface)
    };
    let named = |types, first| -> Vec<String> {
        let description = flat(types, first).unwrap();
        assert_eq!(description.variable_naming_convention, VariableNamingConvention::Flat);
        description.model_variables.into_iter().map(|of| of.common.name).collect()
    };
    assert_eq!(named(Types::Native, "par.r")[..4], ["par_r", "count", "bits", "a"]);
    assert_eq!(named(Types::Wide, "time")[3..5], ["a_0", "a_1"]);
    assert_eq!(named(Types::Wide, "time").last().unwrap(), "FMI_time");
    // An array is one name, its elements are others.
    assert_eq!(named(Types::Native, "a_1")[0], "a_1");
    assert_eq!(
        flat(Types::Wide, "a_1").unwrap_err().to_string(),
        "PUMP: a_1 and a[1] both have the flat name a_1: rename one of them"
    );
}

#[test]
fn the_rows_of_a_table_are_found_by_flat_names() {
    for types in [Types::Native, Types::Wide] {
        let mut interface = Interface { names: Names::Flat, ..interface(types) };
        interface.table.rows[0].name = "par.r".into();
        let description = ModelDescription::from_interface(&interface).unwrap().description().expanded();
        let rows = interface.table.rows.iter().map(|row| (row.name.as_str(), (row.kind, row.role)));
        let places = description.places(rows);
        let found: Vec<&str> = places.iter().map(|place| description.variables[place.unwrap()].name.as_str()).collect();
        // Elements of an array count from 1, whatever its bounds.
        let elements = if types == Types::Native { ["a[1]", "a[2]"] } else { ["a_0", "a_1"] };
        assert_eq!(found[..5], ["par_r", "count", "bits", elements[0], elements[1]]);
    }
}
