//! The properties of an FMU that a model description states in any version.

use crate::sample::{smallest, variable};
use modeldescription::v2::*;

fn real(declared_type: Option<&str>, attributes: RealAttributes) -> Typed {
    Typed::Real(Real { declared_type: declared_type.map(str::to_string), attributes, ..Real::default() })
}

#[test]
fn a_variable_has_what_its_type_definition_says_unless_it_says_it_itself() {
    let percent =
        RealAttributes { unit: Some("%".into()), min: Some(0.0), max: Some(100.0), ..RealAttributes::default() };
    let word = IntegerAttributes { min: Some(-5), max: Some(9), quantity: None };
    let definition = |name: &str, attributes| SimpleType { name: name.into(), description: None, attributes };
    let own = IntegerAttributes { min: Some(0), ..IntegerAttributes::default() };
    let integer = Integer { declared_type: Some("Word".into()), attributes: own, start: Some(3) };
    let description = ModelDescription {
        type_definitions: vec![
            definition("Percent", TypeAttributes::Real(percent)),
            definition("Word", TypeAttributes::Integer(word)),
        ],
        model_variables: vec![
            variable("A", 0, real(Some("Percent"), RealAttributes { max: Some(50.0), ..RealAttributes::default() })),
            variable("B", 1, Typed::Integer(integer)),
            variable("C", 2, real(None, RealAttributes::default())),
        ],
        ..smallest()
    }
    .description();
    let of = |name: &str| {
        let variable = description.variable(name).unwrap();
        (variable.unit.as_deref(), variable.min, variable.max, variable.start)
    };
    assert_eq!(of("A"), (Some("%"), Some(0.0), Some(50.0), None));
    assert_eq!(of("B"), (None, Some(0.0), Some(9.0), Some(3.0)));
    assert_eq!(of("C"), (None, None, None, None));
    let (b, inside) = (description.variable("B").unwrap(), [-1.0, 0.0, 9.0, 10.0]);
    assert_eq!(inside.map(|value| b.is_outside(value)), [true, false, false, true]);
    assert_eq!((b.range().as_str(), b.kind.unwrap().text(3.0).as_str()), ("0.0 to 9.0", "3"));
}

#[test]
fn a_text_has_a_start_and_no_number_and_true_is_1() {
    let text = Typed::String(Text { start: Some("a b".into()), ..Text::default() });
    let on = Typed::Boolean(Boolean { start: Some(true), ..Boolean::default() });
    let variables = vec![variable("NAME", 0, text), variable("ON", 1, on)];
    let description = ModelDescription { model_variables: variables, ..smallest() }.description();
    let name = description.variable("NAME").unwrap();
    assert_eq!((name.kind, name.start, name.start_text.as_deref()), (None, None, Some("a b")));
    assert_eq!(description.start("ON"), Some(1.0));
    assert_eq!(description.variable("ON").unwrap().kind.unwrap().text(1.0), "true");
}
