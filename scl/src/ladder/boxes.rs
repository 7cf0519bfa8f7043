//! Boxes that compute a value, and their ENO, which states whether they succeeded.

use super::elements::{Failure, Formula};
use super::flow::Value;
use super::lower::{Lowerer, numbered};
use super::{Element, MOST_PINS};
use crate::check::types::Elementary;
use crate::front::lexer::Span;
use crate::front::syntax::{Binary, ExpressionId, ExpressionKind, Statement, StatementKind, Unary};
use std::collections::BTreeSet;

impl Lowerer<'_> {
    /// Lowers a box that runs if EN is TRUE: adds its statements and sets the values of its output pins.
    pub(super) fn boxed(&mut self, formula: Formula, failure: Failure, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let Some((result, failed)) = self.formula(formula, failure, element) else { return };
        let pins: BTreeSet<String> = self.result_pins(element, number);
        if let Some(pin) = pins.iter().find(|pin| !pin.starts_with("OUT") && *pin != "RET_VAL") {
            let message = format!("{} has no pin {}", element.name, pin.to_lowercase());
            self.report.error(span, message, Some("disconnect that pin"));
            return;
        }
        let targets: Vec<(&str, ExpressionId)> = match formula {
            Formula::Step(_) => {
                self.operand(element, "OPERAND").map(|operand| ("OPERAND", operand)).into_iter().collect()
            }
            _ => results(element).collect(),
        };
        let is_wired = pins.iter().any(|pin| self.is_awaited(&(number, pin.clone())));
        let has_eno = self.has_eno(element, number);
        let roots = self.roots(targets.iter().map(|(_, target)| *target));
        // A value moved to several variables is read once per variable, without a temporary, so that it may be a string
        // or a structure.
        let is_read_again = matches!(formula, Formula::Same) && self.value(result).reads.is_disjoint(&roots);
        let is_direct = !is_wired && (targets.len() <= 1 || is_read_again);
        let flow = if has_eno { self.shared(flow, span) } else { flow };
        let flow = if has_eno { self.apart(flow, &roots, span) } else { flow };
        let fails = has_eno && element.has_eno && failed.is_some();
        let eno = fails.then(|| self.temporary(span));
        if let Some(eno) = &eno {
            let no = self.literal("BOOL#FALSE", span);
            self.push(StatementKind::Let(eno.clone(), Some(Elementary::Bool), Some(no)), span);
        }
        self.before_writing(&roots, span);
        let mut carried = None;
        let body = self.aside(|lowerer| {
            if let (Some(eno), Some(failed)) = (&eno, failed) {
                let succeeds = lowerer.unary(Unary::Not, failed, span);
                lowerer.push(StatementKind::Let(eno.clone(), Some(Elementary::Bool), Some(succeeds)), span);
            }
            let result = if is_direct {
                result
            } else {
                let name = lowerer.temporary(span);
                lowerer.push(StatementKind::Let(name.clone(), None, Some(result)), span);
                lowerer.named(&name, span)
            };
            for (pin, target) in &targets {
                let result = if *pin == "OPERAND" { result } else { lowerer.of_pin(element, pin, result) };
                lowerer.push(StatementKind::Assign(vec![(*target, None)], result), span);
            }
            carried = Some(result);
        });
        self.only_if(flow.clone(), body, span);
        for pin in pins {
            if let (true, Some(carried)) = (self.is_awaited(&(number, pin.clone())), carried) {
                let carried = self.of_pin(element, &pin, carried);
                let value = Value { of: Some(carried), ..Value::TRUE };
                self.carry((number, pin), value);
            }
        }
        let eno = match eno {
            Some(eno) => Value { of: Some(self.named(&eno, span)), ..Value::TRUE },
            None => flow,
        };
        self.set(elements, number, "ENO", eno);
    }

    /// DEMUX: assigns the value to the output selected by K, or to ELSE if K selects none; the other outputs keep their
    /// values.
    pub(super) fn demultiplexed(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let (Some(k), Some(value)) = (self.operand(element, "K"), self.operand(element, "IN")) else { return };
        let selected = |pin: &str| pin.strip_prefix("OUT").and_then(|number| number.parse::<i64>().ok());
        for pin in self.result_pins(element, number) {
            let (message, help) = if pin != "ELSE" && selected(&pin).is_none() {
                (format!("{} has no pin {}", element.name, pin.to_lowercase()), "disconnect that pin")
            } else if self.is_awaited(&(number, pin.clone())) {
                let message = format!("{}: {} is wired to another element", element.name, pin.to_lowercase());
                (message, "write it to a variable, which keeps its value while K selects another output")
            } else {
                continue;
            };
            self.report.error(span, message, Some(help));
            return;
        }
        let drawn = element.outputs.iter().map(|(pin, _)| pin).chain(&element.open).filter_map(|pin| selected(pin));
        let card = element.setting("CARD").and_then(|card| card.trim().parse::<i64>().ok());
        let count = drawn.map(|last| last + 1).chain(card).max().unwrap_or(0).min(MOST_PINS as i64);
        let roots = self.roots(element.outputs.iter().map(|(_, target)| *target));
        let flow = self.shared(flow, span);
        let flow = self.apart(flow, &roots, span);
        let eno = (element.has_eno && self.has_eno(element, number)).then(|| self.temporary(span));
        if let Some(eno) = &eno {
            let no = self.literal("BOOL#FALSE", span);
            self.push(StatementKind::Let(eno.clone(), Some(Elementary::Bool), Some(no)), span);
        }
        self.before_writing(&roots, span);
        let body = self.aside(|lowerer| {
            if let Some(eno) = &eno {
                let limits = [(Binary::GreaterOrEqual, 0), (Binary::Less, count)].map(|(operator, limit)| {
                    let limit = lowerer.literal(&limit.to_string(), span);
                    lowerer.binary(operator, k, limit, span)
                });
                let is_one = lowerer.binary(Binary::And, limits[0], limits[1], span);
                lowerer.push(StatementKind::Let(eno.clone(), Some(Elementary::Bool), Some(is_one)), span);
            }
            let branches = (0..count).map(|at| {
                let at_number = lowerer.literal(&at.to_string(), span);
                let is_selected = lowerer.binary(Binary::Equal, k, at_number, span);
                (is_selected, lowerer.given_to(element, &format!("OUT{at}"), value))
            });
            let branches: Vec<(ExpressionId, Vec<Statement>)> = branches.collect();
            let otherwise = lowerer.given_to(element, "ELSE", value);
            if branches.is_empty() {
                lowerer.code.extend(otherwise);
            } else {
                lowerer.push(StatementKind::If(branches, otherwise), span);
            }
        });
        self.only_if(flow.clone(), body, span);
        let eno = eno.map(|eno| Value { of: Some(self.named(&eno, span)), ..Value::TRUE });
        self.set(elements, number, "ENO", eno.unwrap_or(flow));
    }

    /// Returns the assignments of a value to the variables at an output pin.
    fn given_to(&mut self, element: &Element, pin: &str, value: ExpressionId) -> Vec<Statement> {
        let value = self.of_pin(element, pin, value);
        let targets = element.outputs.iter().filter(|(own, _)| own == pin);
        let assign =
            |target| Statement { kind: StatementKind::Assign(vec![(target, None)], value), span: element.span };
        targets.map(|(_, target)| assign(*target)).collect()
    }

    pub(super) fn has_eno(&self, element: &Element, number: usize) -> bool {
        self.is_awaited(&(number, "ENO".to_string())) || element.outputs.iter().any(|(pin, _)| pin == "ENO")
    }

    /// The output pins of an element, except ENO, that are written to a variable or needed by another element.
    pub(super) fn result_pins(&self, element: &Element, number: usize) -> BTreeSet<String> {
        let of_element = self.uses.range((number, String::new())..(number + 1, String::new()));
        let wired = of_element.filter(|(_, uses)| **uses > 0).map(|((_, pin), _)| pin);
        let written = element.outputs.iter().map(|(pin, _)| pin);
        wired.chain(written).filter(|pin| *pin != "ENO").cloned().collect()
    }

    /// The value of a box, and an expression that is TRUE if the box fails (`None` if it cannot fail); `None` after an
    /// error such as a missing pin, which has been reported.
    fn formula(
        &mut self,
        formula: Formula,
        failure: Failure,
        element: &Element,
    ) -> Option<(ExpressionId, Option<ExpressionId>)> {
        let span = element.span;
        let of = |names: [&str; 2]| {
            let of = names.iter().find_map(|name| element.setting(name))?.to_uppercase();
            Some(Elementary::named(&of).map_or(of, |of| of.name().to_string()))
        };
        let (own, source) = (of(["DESTTYPE", "DEST_TYPE"]), of(["SRCTYPE", "SRC_TYPE"]));
        let mut given: Vec<(String, ExpressionId)> = Vec::new();
        let result = match formula {
            Formula::Same => self.operand(element, "IN")?,
            Formula::Fold(operator) => {
                self.check_cardinality(element);
                for pin in numbered(element) {
                    let value = self.operand(element, &pin)?;
                    given.push((pin, self.typed(element, value)));
                }
                if given.len() < 2 {
                    let message = format!("{} has fewer than two inputs", element.name);
                    self.report.error(span, message, Some("wire IN1 and IN2"));
                    return None;
                }
                let values: Vec<ExpressionId> = given.iter().map(|(_, value)| *value).collect();
                values.into_iter().reduce(|left, right| self.binary(operator, left, right, span))?
            }
            Formula::Unary(operator) => {
                let value = self.operand(element, "IN")?;
                let value = self.typed(element, value);
                given.push(("IN".to_string(), value));
                self.unary(operator, value, span)
            }
            Formula::Step(operator) => {
                let mut value = self.operand(element, "OPERAND")?;
                // INC and DEC specify only the type of their result, which is also the type of their operand.
                if let Some(of) = own.as_ref().and_then(|own| Elementary::named(own)) {
                    value = self.tree.expressions.add(ExpressionKind::As(of, value), span);
                }
                let value = self.typed(element, value);
                let one = self.literal("1", span);
                given.extend([("IN1".to_string(), value), ("IN2".to_string(), one)]);
                self.binary(operator, value, one, span)
            }
            Formula::Call(name, plain, typed) | Formula::Typed(name, plain, typed) => {
                let is_typed = matches!(formula, Formula::Typed(..));
                for (pins, is_typed) in [(plain, false), (typed, true)] {
                    for pin in pins {
                        for pin in self.pins(element, pin) {
                            let value = self.operand(element, &pin)?;
                            let value = if is_typed { self.typed(element, value) } else { value };
                            given.push((pin, value));
                        }
                    }
                }
                let name = match &own {
                    Some(own) if is_typed => format!("{name}_{own}"),
                    _ => name.to_string(),
                };
                let pins = given.iter().map(|(pin, value)| (formal(pin), *value)).collect();
                self.of_function(&name, pins, span)
            }
            Formula::Convert => {
                let value = self.operand(element, "IN")?;
                given.push(("IN".to_string(), value));
                match (source, &own) {
                    (_, None) => value,
                    (source, Some(own)) => {
                        let name = source.map_or(format!("TO_{own}"), |source| format!("{source}_TO_{own}"));
                        self.of_function(&name, given.clone(), span)
                    }
                }
            }
            Formula::Equation => {
                let Some(equation) = element.equation else {
                    self.report.error(
                        span,
                        format!("{} has no expression", element.name),
                        Some("enter one in the box"),
                    );
                    return None;
                };
                for pin in numbered(element) {
                    let value = self.operand(element, &pin)?;
                    given.push((pin, self.typed(element, value)));
                }
                self.substituted(equation, &given)?
            }
        };
        let failed = match failure {
            Failure::Never => None,
            Failure::Calculation("CALL") if matches!(formula, Formula::Equation) => {
                Some(self.equation_fails(result, span))
            }
            Failure::Calculation("CALL") => Some(self.of_function("CALL?", vec![("IN".to_string(), result)], span)),
            Failure::Calculation(kind) => {
                let name = own.as_ref().map_or(format!("{kind}?"), |own| format!("{kind}?_{own}"));
                // A box without an explicit type uses the type of the variable it writes.
                if let (true, None, Some((_, target))) = (kind == "CONVERT", &own, results(element).next()) {
                    given.push(("OUT".to_string(), target));
                }
                Some(self.of_function(&name, given, span))
            }
            Failure::Condition("TEXT") => self.text_fails(formula, &given, results(element).next(), span),
            Failure::Condition("SCALE_X") => {
                let limits = self.limits_fail(&given, span)?;
                let name = own.as_ref().map_or("SCALE_X?".to_string(), |own| format!("SCALE_X?_{own}"));
                let fails = self.of_function(&name, given, span);
                Some(self.binary(Binary::Or, limits, fails, span))
            }
            Failure::Condition(kind) => self.condition(kind, &given, result, span),
        };
        Some((result, failed))
    }

    /// The call of a named function with these pins as arguments.
    pub(super) fn of_function(&mut self, name: &str, pins: Vec<(String, ExpressionId)>, span: Span) -> ExpressionId {
        let callee = self.function(name, span);
        let arguments = pins.into_iter().map(|(pin, value)| (pin, false, value)).collect();
        self.call(callee, arguments, span)
    }

    /// An expression that is TRUE if the value of `result`, or of a part of it, overflows its type or is invalid.
    fn equation_fails(&mut self, result: ExpressionId, span: Span) -> ExpressionId {
        let mut open = vec![result];
        let mut fails = self.of_function("CALL?", vec![("IN".to_string(), result)], span);
        while let Some(id) = open.pop() {
            let part = match &self.tree.expressions[id].kind {
                ExpressionKind::Unary(operator, inner) => {
                    let (operator, inner) = (*operator, *inner);
                    open.push(inner);
                    (operator == Unary::Minus).then_some(("NEG?", vec![inner]))
                }
                ExpressionKind::Binary(operator, left, right) => {
                    let (operator, left, right) = (*operator, *left, *right);
                    open.extend([left, right]);
                    let kind = match operator {
                        Binary::Add => Some("ADD?"),
                        Binary::Subtract => Some("SUB?"),
                        Binary::Multiply => Some("MUL?"),
                        Binary::Divide => Some("DIV?"),
                        Binary::Modulo => Some("MOD?"),
                        _ => None,
                    };
                    kind.map(|kind| (kind, vec![left, right]))
                }
                ExpressionKind::Call(_, arguments) => {
                    open.extend(arguments.iter().map(|argument| argument.value));
                    Some(("CALL?", vec![id]))
                }
                _ => None,
            };
            if let Some((name, values)) = part {
                let pins = (1..).zip(values).map(|(at, value): (u32, _)| (format!("IN{at}"), value)).collect();
                let fails_here = self.of_function(name, pins, span);
                fails = self.binary(Binary::Or, fails, fails_here, span);
            }
        }
        fails
    }

    /// An expression that is TRUE if the box fails for these inputs: MN is above MX, K selects no input, or the limits
    /// or the result are invalid.
    fn condition(
        &mut self,
        kind: &str,
        given: &[(String, ExpressionId)],
        result: ExpressionId,
        span: Span,
    ) -> Option<ExpressionId> {
        let pin = |name: &str| value_of(given, name);
        match kind {
            "LIMIT" => Some(self.binary(Binary::Greater, pin("MN")?, pin("MX")?, span)),
            "MUX" => {
                let inputs = given.iter().filter(|(pin, _)| pin.starts_with("IN") && pin != "INELSE").count();
                let (none, last) = (self.literal("0", span), self.literal(&(inputs.max(1) - 1).to_string(), span));
                let below = self.binary(Binary::Less, pin("K")?, none, span);
                let above = self.binary(Binary::Greater, pin("K")?, last, span);
                Some(self.binary(Binary::Or, below, above, span))
            }
            _ => {
                let limits = self.limits_fail(given, span)?;
                let invalid = self.of_function("CALL?", vec![("IN".to_string(), result)], span);
                Some(self.binary(Binary::Or, limits, invalid, span))
            }
        }
    }

    /// An expression that is TRUE unless MIN is below MAX.
    fn limits_fail(&mut self, given: &[(String, ExpressionId)], span: Span) -> Option<ExpressionId> {
        let pin = |name: &str| value_of(given, name);
        Some(self.binary(Binary::GreaterOrEqual, pin("MIN")?, pin("MAX")?, span))
    }

    /// An expression that is TRUE if the position or the number of characters is outside the string, or if the result
    /// is too long for its variable.
    fn text_fails(
        &mut self,
        formula: Formula,
        given: &[(String, ExpressionId)],
        target: Option<(&str, ExpressionId)>,
        span: Span,
    ) -> Option<ExpressionId> {
        let pin = |name: &str| value_of(given, name);
        let Formula::Call(name, ..) = formula else { return None };
        let mut all: Vec<ExpressionId> = Vec::new();
        let zero = self.literal("0", span);
        if let Some(count) = pin("L") {
            all.push(self.binary(Binary::Less, count, zero, span));
        }
        if let Some(place) = pin("P") {
            // INSERT inserts after a character, or at position 0 before the first one.
            let operator = if name == "INSERT" { Binary::Less } else { Binary::LessOrEqual };
            all.push(self.binary(operator, place, zero, span));
            let text = self.of_function("LEN", vec![("IN".to_string(), pin("IN").or(pin("IN1"))?)], span);
            all.push(self.binary(Binary::Greater, place, text, span));
        }
        let texts: Vec<ExpressionId> = given
            .iter()
            .filter(|(pin, _)| pin.strip_prefix("IN").is_some_and(|at| !at.is_empty()))
            .map(|of| of.1)
            .collect();
        if let (Some((_, target)), "CONCAT" | "INSERT") = (target, name) {
            let lengths: Vec<ExpressionId> =
                texts.into_iter().map(|text| self.of_function("LEN", vec![("IN".to_string(), text)], span)).collect();
            let sum = lengths.into_iter().reduce(|one, other| self.binary(Binary::Add, one, other, span))?;
            let most = self.of_function("MAX_LEN", vec![("IN".to_string(), target)], span);
            all.push(self.binary(Binary::Greater, sum, most, span));
        }
        all.into_iter().reduce(|one, other| self.binary(Binary::Or, one, other, span))
    }

    /// The pins of an element that match a pattern such as `IN*`.
    fn pins(&self, element: &Element, pattern: &str) -> Vec<String> {
        match pattern {
            "IN*" => numbered(element),
            "INELSE" => {
                let is_else = |pin: &&String| matches!(pin.as_str(), "INELSE" | "ELSE");
                element.inputs.iter().map(|input| &input.pin).filter(is_else).cloned().collect()
            }
            pin => vec![pin.to_string()],
        }
    }

    /// The expression of a Calculate box, with the values of its pins substituted.
    fn substituted(&mut self, id: ExpressionId, given: &[(String, ExpressionId)]) -> Option<ExpressionId> {
        let span = self.tree.expressions[id].span;
        let kind = match &self.tree.expressions[id].kind {
            ExpressionKind::Name(_, name) => {
                let name = name.key();
                let found = value_of(given, &name);
                if found.is_none() && name.starts_with("IN") {
                    self.report.error(span, format!("the expression uses {name}, which is not wired"), Some("wire it"));
                    return None;
                }
                return Some(found.unwrap_or(id));
            }
            ExpressionKind::Unary(operator, inner) => {
                let (operator, inner) = (*operator, *inner);
                ExpressionKind::Unary(operator, self.substituted(inner, given)?)
            }
            ExpressionKind::Binary(operator, left, right) => {
                let (operator, left, right) = (*operator, *left, *right);
                ExpressionKind::Binary(operator, self.substituted(left, given)?, self.substituted(right, given)?)
            }
            ExpressionKind::Call(callee, arguments) => {
                let (callee, mut arguments) = (*callee, arguments.clone());
                for argument in &mut arguments {
                    argument.value = self.substituted(argument.value, given)?;
                }
                ExpressionKind::Call(callee, arguments)
            }
            _ => return Some(id),
        };
        Some(self.tree.expressions.add(kind, span))
    }
}

/// The result pins of a box and the variables they are written to.
fn results(element: &Element) -> impl Iterator<Item = (&str, ExpressionId)> {
    element.outputs.iter().filter(|(pin, _)| pin != "ENO").map(|(pin, target)| (pin.as_str(), *target))
}

/// The value supplied to the pin with this name.
fn value_of(given: &[(String, ExpressionId)], name: &str) -> Option<ExpressionId> {
    given.iter().find(|(pin, _)| pin == name).map(|(_, value)| *value)
}

/// The name of the function parameter that receives the value of a pin.
fn formal(pin: &str) -> String {
    if pin == "ELSE" { "INELSE".to_string() } else { pin.to_string() }
}
