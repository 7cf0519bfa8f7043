//! Random networks as a document of SIMATIC SD: one rung for each element, from the wire of its flow to its own wire.

use super::{COMPARISONS, Element, Flow, Kind, Number, OF_WORDS, OPERATIONS, SHIFTS, TIMERS, declarations, labels};
use std::fmt::Write;

const INT: &str = "{ S7_Templates := \"SrcType := Int\" }";
const INT_WITH_ENO: &str = "{ S7_Templates := \"SrcType := Int\"; S7_GenerateENO := \"TRUE\" }";
const WORD: &str = "{ S7_Templates := \"SrcType := Word\" }";

fn value(of: &Number) -> String {
    match of {
        Number::Variable(at) => format!("#n{at}"),
        Number::Constant(value) => value.to_string(),
    }
}

fn wire(from: Flow, is_fbd: bool) -> String {
    let rail = if is_fbd { "TRUE" } else { "wire#powerrail" };
    from.map_or(rail.to_string(), |at| format!("wire#f{at}"))
}

/// Returns an element as written in its rung, which ends with its wire unless one of its pins leads there.
fn element(kind: &Kind, own: &str, is_fbd: bool) -> (String, bool) {
    let text = match kind {
        Kind::Contact(name, is_negated) if is_fbd => {
            format!("A( in2 := {}#{name} )", if *is_negated { "NOT " } else { "" })
        }
        Kind::Contact(name, is_negated) => format!("{}Contact( #{name} )", if *is_negated { "I_" } else { "" }),
        Kind::Not => "Not()".to_string(),
        Kind::Edge(is_rising, name, bit) => {
            format!("{}_Contact( operand := #{name}, bit := #m{bit} )", if *is_rising { "P" } else { "N" })
        }
        Kind::Trigger(is_rising, bit) => format!("{}_Trig( #m{bit} )", if *is_rising { "P" } else { "N" }),
        Kind::Compare(which, left, right) => {
            format!("{INT} {}_Contact( in1 := {}, in2 := {} )", COMPARISONS[*which].0, value(left), value(right))
        }
        Kind::Coil(name, is_negated) => format!("{}Coil( #{name} )", if *is_negated { "I_" } else { "" }),
        Kind::Set(is_set, name) => format!("{}_Coil( #{name} )", if *is_set { "S" } else { "R" }),
        Kind::Pulse(is_rising, name, bit) => {
            format!("{}_Coil( operand => #{name}, bit := #m{bit} )", if *is_rising { "P" } else { "N" })
        }
        Kind::FlipFlop(is_set_dominant, name, other) => {
            let other = wire(*other, true);
            if *is_set_dominant { format!("#{name}.S_RS( s1 := {other} )") } else { format!("#{name}.S_SR( {other} )") }
        }
        Kind::Timer(which, ms) => {
            format!("{{ S7_Templates := \"time_type := Time\" }} #t{which}.{}( pt := T#{ms}ms, et => )", TIMERS[*which])
        }
        Kind::Counter(reset, most) => {
            format!("{{ S7_Templates := \"value_type := Int\" }} #c0.CTU( r := #{reset}, pv := {most}, cv => )")
        }
        Kind::Move(from, to) => format!("Move( in := {}, out1 => #n{to} )", value(from)),
        Kind::Calculate(which, has_eno, left, right, to) => {
            let settings = if *has_eno { INT_WITH_ENO } else { INT };
            let name = OPERATIONS[*which].0;
            format!("{settings} {name}( in1 := {}, in2 := {}, out => #n{to} )", value(left), value(right))
        }
        Kind::Formula(has_eno, values, to) => {
            let settings = if *has_eno { INT_WITH_ENO } else { INT };
            let settings = settings.replace(" }", "; S7_Expression := \"(in1 + in2) * in3 - in1\" }");
            let [a, b, c] = values.each_ref().map(value);
            format!("{settings} Calculate( in1 := {a}, in2 := {b}, in3 := {c}, out => #n{to} )")
        }
        Kind::Step(is_up, at) => {
            let settings = INT_WITH_ENO.replace("SrcType", "DestType");
            format!("{settings} {}( #n{at} )", if *is_up { "Inc" } else { "Dec" })
        }
        Kind::Select(name, no, yes, to) => {
            let (no, yes) = (value(no), value(yes));
            format!(
                "{{ S7_Templates := \"value_type := Int\" }} SEL( g := #{name}, in0 := {no}, in1 := {yes}, out => #n{to} )"
            )
        }
        Kind::Words(which, words, to) => {
            let pins: String = (1..).zip(words).map(|(pin, at): (u32, _)| format!("in{pin} := #w{at}, ")).collect();
            format!("{WORD} {}( {pins}out => #w{to} )", OF_WORDS[*which])
        }
        Kind::Shift(which, from, by, to) => {
            format!("{WORD} {}( in := #w{from}, n := {by}, out => #w{to} )", SHIFTS[*which])
        }
        Kind::Call(which, x, k, of_eno) => {
            let y = if *of_eno { String::new() } else { format!(", y => {own}") };
            return (format!("#s{which}( x := #{x}, k := {}{y} )", value(k)), *of_eno);
        }
        Kind::Function(x, k, to, of_eno) => {
            let y = if *of_eno { "#truth".to_string() } else { own.to_string() };
            return (format!("\"Fun\"( x := #{x}, k := {}, y => {y}, Ret_Val => #n{to} )", value(k)), *of_eno);
        }
        Kind::Jump(is_if, to) => return (format!("{}JumpCoil( L{to} )", if *is_if { "" } else { "I_" }), false),
        Kind::Or(_) => unreachable!("rungs that end at one wire"),
    };
    (text, true)
}

/// Returns all networks as a document in a language.
pub(super) fn document(networks: &[Vec<Element>], language: &str) -> String {
    let is_fbd = language == "FBD";
    let mut all = format!(
        "{{ S7_PreferredLanguage := \"{language}\" }}\nFUNCTION_BLOCK \"B\"\n{}VAR_TEMP truth : Bool; END_VAR\n",
        declarations()
    );
    let is_label = labels(networks);
    for (number, elements) in networks.iter().enumerate() {
        writeln!(all, "    {{ S7_Language := \"{language}\" }}\n    NETWORK").unwrap();
        if is_label[number] {
            writeln!(all, "Label( L{number} )").unwrap();
        }
        let mut places: Vec<usize> = (0..elements.len()).collect();
        places.sort_by_key(|at| elements[*at].place);
        for at in places {
            let Element { kind, flow, .. } = &elements[at];
            let own = wire(Some(at), is_fbd);
            if let Kind::Or(flows) = kind {
                flows.iter().for_each(|from| writeln!(all, "RUNG {} END_RUNG {own}", wire(*from, is_fbd)).unwrap());
                continue;
            }
            let (text, ends_there) = element(kind, &own, is_fbd);
            let end = if ends_there { format!(" {own}") } else { String::new() };
            writeln!(all, "RUNG {} {text}{end} END_RUNG", wire(*flow, is_fbd)).unwrap();
        }
        all += "    END_NETWORK\n";
    }
    all + "END_FUNCTION_BLOCK\n"
}
