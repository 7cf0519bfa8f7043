//! Random networks in SCL: a flag for the flow of each element, and a statement or two for its behavior.

use super::{COMPARISONS, Element, Flow, Kind, Number, OF_WORDS, OPERATIONS, SHIFTS, TIMERS, declarations, labels};
use std::fmt::Write;

/// Returns the elements in the order in which they take effect: by their positions, each after those it needs, the
/// earlier of these first. A junction has no effect: it has the position of its first input, and comes when it is
/// needed.
fn order(elements: &[Element]) -> Vec<usize> {
    fn place(elements: &[Element], at: usize) -> (u64, usize) {
        let (mut own, mut first) = ((elements[at].place, at), None);
        if let Kind::Or(flows) = &elements[at].kind {
            first = flows.iter().flatten().map(|of| place(elements, *of)).min();
            own = (u64::MAX, at);
        }
        first.unwrap_or(own)
    }
    fn visit(elements: &[Element], at: usize, order: &mut Vec<usize>) {
        if order.contains(&at) {
            return;
        }
        let mut needed = vec![elements[at].flow];
        match &elements[at].kind {
            Kind::Or(flows) => needed = flows.clone(),
            Kind::FlipFlop(_, _, other) => needed.push(*other),
            _ => {}
        }
        let mut needed: Vec<usize> = needed.into_iter().flatten().collect();
        needed.sort_by_key(|other| place(elements, *other));
        needed.into_iter().for_each(|other| visit(elements, other, order));
        order.push(at);
    }
    let is_junction = |at: &usize| matches!(elements[*at].kind, Kind::Or(_));
    let mut places: Vec<usize> = (0..elements.len()).collect();
    places.sort_by_key(|at| (is_junction(at), elements[*at].place));
    let mut order = Vec::new();
    places.into_iter().for_each(|at| visit(elements, at, &mut order));
    order
}

fn value(of: &Number) -> String {
    match of {
        Number::Variable(at) => format!("#n{at}"),
        Number::Constant(value) => format!("INT#{value}"),
    }
}

/// Returns the statements of an element: `f` is its input flow, `e` its output flow.
fn statement(kind: &Kind, f: &str, e: &str, flow: impl Fn(Flow) -> String) -> String {
    match kind {
        Kind::Contact(name, true) => format!("{e} := {f} AND NOT #{name};"),
        Kind::Contact(name, false) => format!("{e} := {f} AND #{name};"),
        Kind::Or(flows) => {
            let flows: Vec<String> = flows.iter().map(|from| flow(*from)).collect();
            format!("{e} := {};", flows.join(" OR "))
        }
        Kind::Not => format!("{e} := NOT {f};"),
        Kind::Edge(true, name, bit) => format!("{e} := {f} AND (#{name} AND NOT #m{bit}); #m{bit} := #{name};"),
        Kind::Edge(false, name, bit) => format!("{e} := {f} AND (NOT #{name} AND #m{bit}); #m{bit} := #{name};"),
        Kind::Trigger(true, bit) => format!("{e} := {f} AND NOT #m{bit}; #m{bit} := {f};"),
        Kind::Trigger(false, bit) => format!("{e} := NOT {f} AND #m{bit}; #m{bit} := {f};"),
        Kind::Compare(which, left, right) => {
            format!("{e} := {f} AND ({} {} {});", value(left), COMPARISONS[*which].1, value(right))
        }
        Kind::Coil(name, is_negated) => {
            format!("#{name} := {}{f}; {e} := {f};", if *is_negated { "NOT " } else { "" })
        }
        Kind::Set(is_set, name) => format!("IF {f} THEN #{name} := {is_set}; END_IF; {e} := {f};"),
        Kind::Pulse(true, name, bit) => format!("#{name} := {f} AND NOT #m{bit}; #m{bit} := {f}; {e} := {f};"),
        Kind::Pulse(false, name, bit) => format!("#{name} := NOT {f} AND #m{bit}; #m{bit} := {f}; {e} := {f};"),
        // The dominant input comes last; the flow goes to the other one.
        Kind::FlipFlop(is_set_dominant, name, other) => {
            let other = flow(*other);
            let first = !is_set_dominant;
            format!(
                "IF {f} THEN #{name} := {first}; END_IF; IF {other} THEN #{name} := {is_set_dominant}; END_IF; {e} := #{name};"
            )
        }
        Kind::Timer(which, ms) => {
            let kind = TIMERS[*which];
            format!("#t{which}.{kind}(IN := {f}, PT := T#{ms}ms); {e} := #t{which}.Q;")
        }
        Kind::Counter(reset, most) => format!("#c0(CU := {f}, R := #{reset}, PV := {most}); {e} := #c0.Q;"),
        Kind::Jump(is_if, to) => format!("IF {}{f} THEN GOTO L{to}; END_IF;", if *is_if { "" } else { "NOT " }),
        Kind::Call(which, x, k, of_eno) => {
            let result = if *of_eno { f.to_string() } else { format!("#s{which}.y") };
            format!("IF {f} THEN #s{which}(x := #{x}, k := {}); END_IF; {e} := {result};", value(k))
        }
        Kind::Function(x, k, to, of_eno) => {
            let call = format!("#n{to} := \"Fun\"(x := #{x}, k := {}, y => #truth);", value(k));
            let result = if *of_eno { "TRUE" } else { "#truth" };
            format!("{e} := FALSE; IF {f} THEN {call} {e} := {result}; END_IF;")
        }
        of_box => boxed(of_box, f, e),
    }
}

/// Returns the statements of a box.
fn boxed(kind: &Kind, f: &str, e: &str) -> String {
    match kind {
        Kind::Move(from, to) => format!("IF {f} THEN #n{to} := {}; END_IF; {e} := {f};", value(from)),
        Kind::Calculate(which, false, left, right, to) => {
            let sum = format!("{} {} {}", value(left), OPERATIONS[*which].1, value(right));
            format!("IF {f} THEN #n{to} := {sum}; END_IF; {e} := {f};")
        }
        Kind::Calculate(which, true, left, right, to) => {
            // An overflow in INT does not occur in DINT.
            let (left, right) = (value(left), value(right));
            let wide = format!("INT_TO_DINT({left}) {} INT_TO_DINT({right})", OPERATIONS[*which].1);
            let has_quotient = if *which > 2 { format!("{right} <> 0") } else { "TRUE".to_string() };
            format!(
                "IF {f} THEN #wide := {wide}; {e} := #wide >= -32768 AND #wide <= 32767 AND {has_quotient}; \
                 #n{to} := {left} {} {right}; ELSE {e} := FALSE; END_IF;",
                OPERATIONS[*which].1
            )
        }
        Kind::Formula(has_eno, values, to) => {
            let [a, b, c] = values.each_ref().map(value);
            // Each step in DINT is compared with the one in INT.
            let fits = format!(
                "INT_TO_DINT({a}) + INT_TO_DINT({b}) = INT_TO_DINT({a} + {b}) AND INT_TO_DINT({a} + {b}) * INT_TO_DINT({c}) = \
                 INT_TO_DINT(({a} + {b}) * {c}) AND INT_TO_DINT(({a} + {b}) * {c}) - INT_TO_DINT({a}) = INT_TO_DINT(({a} + {b}) * {c} - {a})"
            );
            let eno = if *has_eno { format!("{f} AND {fits}") } else { f.to_string() };
            format!("{e} := {eno}; IF {f} THEN #n{to} := ({a} + {b}) * {c} - {a}; END_IF;")
        }
        Kind::Step(is_up, at) => {
            let (last, sign) = if *is_up { (32767, '+') } else { (-32768, '-') };
            format!("{e} := {f} AND #n{at} <> {last}; IF {f} THEN #n{at} := #n{at} {sign} 1; END_IF;")
        }
        Kind::Select(name, no, yes, to) => format!(
            "IF {f} THEN IF #{name} THEN #n{to} := {}; ELSE #n{to} := {}; END_IF; END_IF; {e} := {f};",
            value(yes),
            value(no)
        ),
        Kind::Words(which, words, to) => {
            let words: Vec<String> = words.iter().map(|at| format!("#w{at}")).collect();
            let value = words.join(&format!(" {} ", OF_WORDS[*which].to_uppercase()));
            format!("IF {f} THEN #w{to} := {value}; END_IF; {e} := {f};")
        }
        Kind::Shift(which, from, by, to) => {
            let name = SHIFTS[*which].to_uppercase();
            format!("IF {f} THEN #w{to} := {name}(IN := #w{from}, N := {by}); END_IF; {e} := {f};")
        }
        other => unreachable!("{other:?}"),
    }
}

/// Returns all networks as a source in SCL.
pub(super) fn source(networks: &[Vec<Element>]) -> String {
    let mut all = format!("FUNCTION_BLOCK \"B\"\n{}VAR_TEMP\nwide : DINT;\ntruth : BOOL;\n", declarations());
    for (number, elements) in networks.iter().enumerate() {
        (0..elements.len()).for_each(|at| writeln!(all, "f{number}_{at} : BOOL;").unwrap());
    }
    all += "END_VAR\nBEGIN\n";
    let is_label = labels(networks);
    for (number, elements) in networks.iter().enumerate() {
        if is_label[number] {
            writeln!(all, "L{number}: ;").unwrap();
        }
        let flow = |from: Flow| from.map_or("TRUE".to_string(), |at| format!("#f{number}_{at}"));
        for at in order(elements) {
            let (f, e) = (flow(elements[at].flow), flow(Some(at)));
            writeln!(all, "{}", statement(&elements[at].kind, &f, &e, flow)).unwrap();
        }
    }
    all + "END_FUNCTION_BLOCK\n"
}
