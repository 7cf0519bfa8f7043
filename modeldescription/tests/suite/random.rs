//! Random descriptions with random damage.

use crate::sample::everything;
use modeldescription::Interface;
use modeldescription::v2::*;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

/// Text that XML can represent, including all characters with a special meaning.
fn text() -> impl Strategy<Value = String> {
    let special =
        proptest::sample::select("<>&\"'\n\r\t ;#]-?!=/äß\u{a0}\u{2028}\u{feff}\u{fffd}😀".chars().collect::<Vec<_>>());
    let any = any::<char>().prop_filter("XML cannot hold it", |c| {
        matches!(c, '\t' | '\n' | '\r' | ' '..) && !matches!(c, '\u{fffe}' | '\u{ffff}')
    });
    vec(prop_oneof![special, any, proptest::char::range('a', 'z')], 0..12).prop_map(String::from_iter)
}

fn number() -> impl Strategy<Value = f64> {
    proptest::num::f64::ANY.prop_filter("it equals nothing", |number| !number.is_nan())
}

/// Orders start, min and max, as far as they are present.
fn ordered<T: PartialOrd + Copy + std::fmt::Debug>(
    number: impl Strategy<Value = T>,
) -> impl Strategy<Value = [Option<T>; 3]> {
    (vec(number, 3), any::<[bool; 3]>()).prop_map(|(mut numbers, is_there)| {
        numbers.sort_by(|a, b| a.partial_cmp(b).unwrap());
        std::array::from_fn(|i| is_there[i].then_some(numbers[i]))
    })
}

fn unit() -> impl Strategy<Value = Unit> {
    let base_unit =
        (any::<[i32; 8]>(), number(), number()).prop_map(|([kg, m, s, a, k, mol, cd, rad], factor, offset)| BaseUnit {
            kg,
            m,
            s,
            A: a,
            K: k,
            mol,
            cd,
            rad,
            factor,
            offset,
        });
    let display_unit =
        (text(), number(), number()).prop_map(|(name, factor, offset)| DisplayUnit { name, factor, offset });
    (text(), option::of(base_unit), vec(display_unit, 0..3)).prop_map(|(name, base_unit, mut display_units)| {
        number_all(&mut display_units, |display_unit| &mut display_unit.name);
        Unit { name, base_unit, display_units }
    })
}

/// Makes names unique.
fn number_all<T>(items: &mut [T], name: impl Fn(&mut T) -> &mut String) {
    for (i, item) in items.iter_mut().enumerate() {
        name(item).push_str(&i.to_string());
    }
}

/// A Real's attributes, its unit a number that stands for one, and its start.
fn real_attributes() -> impl Strategy<Value = (RealAttributes, Option<f64>)> {
    let texts = (option::of(text()), option::of("[0-9]"), option::of(text()));
    let rest = (any::<Option<bool>>(), option::of(number()), any::<Option<bool>>());
    (texts, ordered(number()), rest).prop_map(|(texts, [min, start, max], (relative_quantity, nominal, unbounded))| {
        let (quantity, unit, display_unit) = texts;
        let attributes =
            RealAttributes { quantity, unit, display_unit, relative_quantity, min, max, nominal, unbounded };
        (attributes, start)
    })
}

fn integer_attributes() -> impl Strategy<Value = (IntegerAttributes, Option<i32>)> {
    (option::of(text()), ordered(any::<i32>()))
        .prop_map(|(quantity, [min, start, max])| (IntegerAttributes { quantity, min, max }, start))
}

/// Types, one of each kind; `E` without a range.
fn types() -> impl Strategy<Value = Vec<SimpleType>> {
    let items = vec((text(), any::<i32>(), option::of(text())), 0..3).prop_map(|items| {
        let mut items: Vec<Item> =
            items.into_iter().map(|(name, value, description)| Item { name, value, description }).collect();
        number_all(&mut items, |item| &mut item.name);
        items
    });
    let described = vec(option::of(text()), 5);
    (real_attributes(), integer_attributes(), option::of(text()), items, described).prop_map(
        |((real, _), (integer, _), quantity, items, described)| {
            let attributes = [
                // Only variables have ranges here: those of a type would have to fit all of its variables.
                ("R", TypeAttributes::Real(RealAttributes { min: None, max: None, ..real })),
                ("I", TypeAttributes::Integer(IntegerAttributes { min: None, max: None, ..integer })),
                ("B", TypeAttributes::Boolean(BooleanType {})),
                ("S", TypeAttributes::String(StringType {})),
                ("E", TypeAttributes::Enumeration(EnumerationType { quantity, items })),
            ];
            std::iter::zip(attributes, described)
                .map(|((name, attributes), description)| SimpleType { name: name.into(), description, attributes })
                .collect()
        },
    )
}

fn typed() -> impl Strategy<Value = Typed> {
    let declared = |name: &'static str| option::of(Just(name.to_string()));
    let real =
        (declared("R"), real_attributes(), any::<bool>()).prop_map(|(declared_type, (attributes, start), reinit)| {
            Typed::Real(Real { declared_type, attributes, start, derivative: Some(1), reinit })
        });
    let integer = (declared("I"), integer_attributes())
        .prop_map(|(declared_type, (attributes, start))| Typed::Integer(Integer { declared_type, attributes, start }));
    let boolean = (declared("B"), any::<Option<bool>>())
        .prop_map(|(declared_type, start)| Typed::Boolean(Boolean { declared_type, start }));
    let string = (declared("S"), option::of(text()))
        .prop_map(|(declared_type, start)| Typed::String(Text { declared_type, start }));
    let enumeration = integer_attributes().prop_map(|(attributes, start)| {
        Typed::Enumeration(Enumeration { declared_type: "E".into(), attributes, start })
    });
    prop_oneof![real, integer, boolean, string, enumeration]
}

fn variable() -> impl Strategy<Value = Variable> {
    use proptest::sample::select;
    let causality = select(vec![
        Causality::Parameter,
        Causality::CalculatedParameter,
        Causality::Input,
        Causality::Output,
        Causality::Local,
        Causality::Independent,
    ]);
    let variability = select(vec![
        Variability::Constant,
        Variability::Fixed,
        Variability::Tunable,
        Variability::Discrete,
        Variability::Continuous,
    ]);
    let initial = option::of(select(vec![Initial::Exact, Initial::Approx, Initial::Calculated]));
    let several = any::<Option<bool>>();
    (text(), option::of(text()), causality, variability, initial, several, typed()).prop_map(
        |(name, description, causality, variability, initial, several, typed)| Variable {
            name,
            value_reference: 0,
            description,
            causality,
            variability,
            initial,
            can_handle_multiple_set_per_time_instant: several,
            typed,
        },
    )
}

/// An unknown whose indices are arbitrary numbers, to be reduced to existing ones.
fn unknown() -> impl Strategy<Value = Unknown> {
    let kinds = proptest::sample::select(vec![
        DependencyKind::Dependent,
        DependencyKind::Constant,
        DependencyKind::Fixed,
        DependencyKind::Tunable,
        DependencyKind::Discrete,
    ]);
    (any::<u32>(), option::of(vec((any::<u32>(), kinds), 0..5)), any::<bool>()).prop_map(|(index, pairs, has_kinds)| {
        let (dependencies, kinds) = pairs.map(|pairs| pairs.into_iter().unzip()).unzip();
        Unknown { index, dependencies, dependencies_kind: kinds.filter(|_| has_kinds) }
    })
}

fn interfaces() -> impl Strategy<Value = (ModelExchange, CoSimulation)> {
    let source_file = text().prop_map(|name| SourceFile { name });
    (text(), any::<[bool; 9]>(), any::<u32>(), vec(source_file, 0..3)).prop_map(|(name, flag, order, mut files)| {
        // Each file is named once.
        files.dedup_by(|one, other| one.name == other.name);
        let model_exchange = ModelExchange {
            model_identifier: name.clone(),
            needs_execution_tool: flag[0],
            completed_integrator_step_not_needed: flag[1],
            can_be_instantiated_only_once_per_process: flag[2],
            can_not_use_memory_management_functions: flag[3],
            can_get_and_set_fmu_state: flag[4],
            can_serialize_fmu_state: flag[5],
            provides_directional_derivative: flag[6],
            source_files: files.clone(),
        };
        let capabilities = Capabilities {
            needs_execution_tool: flag[6],
            can_handle_variable_communication_step_size: flag[5],
            can_interpolate_inputs: flag[4],
            max_output_derivative_order: order,
            can_run_asynchronuously: flag[3],
            can_be_instantiated_only_once_per_process: flag[2],
            can_not_use_memory_management_functions: flag[1],
            can_get_and_set_fmu_state: flag[0],
            can_serialize_fmu_state: flag[7],
            provides_directional_derivative: flag[8],
        };
        let co_simulation = CoSimulation { model_identifier: name, capabilities, source_files: files };
        (model_exchange, co_simulation)
    })
}

/// Any consistent description.
fn description() -> impl Strategy<Value = ModelDescription> {
    let texts = (text(), text(), vec(option::of(text()), 7));
    let head = (any::<bool>(), any::<Option<u32>>(), interfaces(), 0..3);
    let category = (text(), option::of(text())).prop_map(|(name, description)| LogCategory { name, description });
    let experiment = vec(option::of(number()), 4);
    let lists = (vec(unit(), 0..4), types(), vec(category, 0..3), option::of(experiment));
    let unknowns = (vec(unknown(), 0..4), vec(unknown(), 0..4), vec(unknown(), 0..4));
    (texts, head, lists, vec(variable(), 0..8), unknowns).prop_map(|(texts, head, lists, variables, unknowns)| {
        let (model_name, guid, texts) = texts;
        let [description, author, version, copyright, license, generation_tool, generation_date_and_time] =
            texts.try_into().unwrap();
        let (is_structured, number_of_event_indicators, (model_exchange, co_simulation), purpose) = head;
        let (mut units, types, mut categories, experiment) = lists;
        number_all(&mut units, |unit| &mut unit.name);
        number_all(&mut categories, |category| &mut category.name);
        let (outputs, derivatives, initial_unknowns) = unknowns;
        let mut description = ModelDescription {
            model_name,
            guid,
            description,
            author,
            version,
            copyright,
            license,
            generation_tool,
            generation_date_and_time,
            variable_naming_convention: if is_structured {
                VariableNamingConvention::Structured
            } else {
                VariableNamingConvention::Flat
            },
            number_of_event_indicators,
            model_exchange: (purpose != 0).then_some(model_exchange),
            co_simulation: (purpose != 1).then_some(co_simulation),
            unit_definitions: units,
            type_definitions: types,
            log_categories: categories,
            default_experiment: experiment.map(|times| DefaultExperiment {
                start_time: times[0],
                stop_time: times[1],
                tolerance: times[2],
                step_size: times[3],
            }),
            model_variables: variables,
            model_structure: ModelStructure { outputs, derivatives, initial_unknowns },
        };
        connect(&mut description);
        description
    })
}

/// Replaces all references by references to existing items.
fn connect(description: &mut ModelDescription) {
    let units: Vec<String> = description.unit_definitions.iter().map(|unit| unit.name.clone()).collect();
    let chosen = |number: &Option<String>| {
        let number: usize = number.as_ref()?.parse().unwrap();
        (!units.is_empty()).then(|| units[number % units.len()].clone())
    };
    for simple_type in &mut description.type_definitions {
        if let TypeAttributes::Real(real) = &mut simple_type.attributes {
            real.unit = chosen(&real.unit);
        }
    }
    number_all(&mut description.model_variables, |variable| &mut variable.name);
    for (i, variable) in (0..).zip(&mut description.model_variables) {
        variable.value_reference = i;
        if let Typed::Real(real) = &mut variable.typed {
            real.attributes.unit = chosen(&real.attributes.unit);
        }
    }
    let count = u32::try_from(description.model_variables.len()).unwrap();
    let structure = &mut description.model_structure;
    for list in [&mut structure.outputs, &mut structure.derivatives, &mut structure.initial_unknowns] {
        if count == 0 {
            list.clear();
        }
        for unknown in list {
            let indices = unknown.dependencies.iter_mut().flatten();
            [&mut unknown.index].into_iter().chain(indices).for_each(|index| *index = 1 + *index % count);
        }
    }
}

proptest! {
    #[test]
    fn any_description_reads_back_as_it_was_written(description in description()) {
        let bytes = write(&description);
        let again = read(&bytes);
        prop_assert_eq!(again.as_ref(), Ok(&description));
        // Zeros are equal whatever their sign, but their texts differ.
        prop_assert_eq!(write(&again.unwrap()), bytes);
    }

    #[test]
    fn any_damage_has_an_answer(
        pieces in vec((any::<prop::sample::Index>(), 0..40_usize, vec(any::<u8>(), 0..4)), 1..4),
    ) {
        let mut xml = write(&everything());
        for (place, length, bytes) in pieces {
            let begin = place.index(xml.len());
            let end = xml.len().min(begin + length);
            xml.splice(begin..end, bytes);
        }
        if let Ok(description) = read(&xml) {
            check(&description);
            let again = read(&write(&description)).unwrap();
            prop_assert_eq!(write(&again), write(&description));
        }
    }

    #[test]
    fn pieces_of_a_description_in_any_order_have_an_answer(
        order in vec(any::<prop::sample::Index>(), 0..60),
    ) {
        let xml = String::from_utf8(write(&everything())).unwrap();
        let pieces: Vec<&str> = xml.split_inclusive(['>', ' ', '"']).collect();
        let mixed: String = order.iter().map(|index| *index.get(&pieces)).collect();
        prop_assert!(read(mixed.as_bytes()).is_err());
        let begun = format!("{}{mixed}", &xml[..xml.find("<ModelVariables>").unwrap()]);
        prop_assert!(read(begun.as_bytes()).is_err());
    }

    #[test]
    fn any_bytes_have_an_answer(bytes in vec(any::<u8>(), 0..200)) {
        prop_assert!(read(&bytes).is_err());
        prop_assert!(Interface::parse(&String::from_utf8_lossy(&bytes)).is_err());
    }
}
