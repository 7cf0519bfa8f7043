//! The statements for each element.

use super::Element;
use super::elements::{Law, Returned};
use super::flow::Value;
use super::lower::Lowerer;
use crate::check::constant::{self, Literal};
use crate::check::types::Elementary;
use crate::front::lexer::Span;
use crate::front::syntax::{Binary, ExpressionId, ExpressionKind, Name, Statement, StatementKind, Unary};

/// The input pins for power flow.
const FLOW: &[&str] = &["PRE", "IN"];
/// The pins for the preset time of a timer coil.
const PRESET: [&str; 4] = ["PT", "VALUE", "TV", "PRESET"];
/// The maximum number of bits in a field of an array.
const MOST_BITS: i128 = 65_535;
/// The maximum number of bits in a field of a bit string.
const MOST_BITS_OF_A_WORD: i128 = 64;

impl Lowerer<'_> {
    /// Lowers an element according to its law.
    pub(super) fn law(&mut self, law: Law, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        match law {
            Law::Contact(is_negated) => {
                let flow = self.flow(element, &["IN"]);
                let Some(operand) = self.operand(element, "OPERAND") else { return };
                let value = self.value(operand);
                let value = if is_negated { self.negated(value, span) } else { value };
                let out = self.joined(Binary::And, flow, value, span);
                self.set(elements, number, "OUT", out);
            }
            Law::EdgeContact(is_rising) => {
                let flow = self.flow(element, FLOW);
                let operands = (self.operand(element, "OPERAND"), self.operand(element, "BIT"));
                let (Some(operand), Some(bit)) = operands else { return };
                let roots = self.roots([bit]);
                let flow = self.apart(flow, &roots, span);
                let value = self.value(operand);
                let edge = self.edge(value, bit, is_rising, span);
                let out = self.joined(Binary::And, flow, edge, span);
                self.set(elements, number, "OUT", out);
            }
            Law::EdgeOfFlow(is_rising) => {
                let flow = self.flow(element, &["IN"]);
                let Some(bit) = self.operand(element, "BIT") else { return };
                let edge = self.edge(flow, bit, is_rising, span);
                self.set(elements, number, "OUT", edge);
            }
            Law::Compare(_) | Law::Range(_) | Law::Valid(_) => self.comparison(law, elements, number),
            Law::Gate(operator) => {
                self.check_cardinality(element);
                let pins: Vec<String> = element.inputs.iter().map(|input| input.pin.clone()).collect();
                let values: Vec<Value> = pins.iter().filter_map(|pin| self.input(element, pin)).collect();
                let joined = values.into_iter().reduce(|left, right| self.joined(operator, left, right, span));
                match joined {
                    Some(value) => self.set(elements, number, "OUT", value),
                    None => {
                        let message = format!("{} has no connected inputs", element.name);
                        self.report.error(span, message, Some("wire its inputs, or delete it"));
                    }
                }
            }
            Law::Not => {
                let flow = self.flow(element, &["IN"]);
                let out = self.negated(flow, span);
                self.set(elements, number, "OUT", out);
            }
            Law::Coil(_) | Law::Set(_) | Law::EdgeCoil(_) | Law::SetField(_) => self.coil(law, elements, number),
            Law::FlipFlop(is_set_dominant) => self.flip_flop(is_set_dominant, elements, number),
            Law::Instance(kind) => self.instance(Some(kind), elements, number),
            Law::System => self.instance(None, elements, number),
            Law::TimerCoil(_) | Law::TimerFunction(_) => self.timer_coil(law, elements, number),
            Law::Jump(is_if_true) => {
                let flow = self.flow(element, &["IN", "EN"]);
                let flow = if is_if_true { flow } else { self.negated(flow, span) };
                let Some(label) = &element.label else {
                    self.report.error(
                        span,
                        format!("{} has no label", element.name),
                        Some("enter the label to jump to"),
                    );
                    return;
                };
                let body = self.aside(|lowerer| lowerer.jump(label, span));
                self.only_if(flow, body, span);
            }
            Law::Label => {
                if let Some(label) = &element.label {
                    self.push(StatementKind::Label(label.clone()), span);
                }
            }
            Law::Return(returned) => {
                let flow = self.flow(element, &["IN", "EN"]);
                let value = match returned {
                    Returned::Unchanged if element.inputs.iter().any(|input| input.pin == "OPERAND") => {
                        self.operand(element, "OPERAND")
                    }
                    Returned::Unchanged => None,
                    Returned::True => Some(self.literal("BOOL#TRUE", span)),
                    Returned::False => Some(self.literal("BOOL#FALSE", span)),
                    Returned::Operand => self.operand(element, "OPERAND"),
                };
                self.tree.may_set_eno |= value.is_some();
                let body = vec![Statement { kind: StatementKind::Return(value), span }];
                self.only_if(flow, body, span);
            }
            Law::Box(formula, failure) => self.boxed(formula, failure, elements, number),
            Law::Demultiplex => self.demultiplexed(elements, number),
            Law::Statement(name) => {
                let callee = self.function(name, span);
                self.statement(callee, elements, number);
            }
            Law::Refused(help) => {
                self.report.error(span, format!("{} is not supported", element.name), Some(help));
            }
        }
    }

    /// Detects an edge of a value, whose previous value is in `bit`, then stores the value there.
    fn edge(&mut self, value: Value, bit: ExpressionId, is_rising: bool, span: Span) -> Value {
        let value = self.shared(value, span);
        let (now, before) = (self.expression(&value, span), bit);
        let edge = if is_rising {
            let not_before = self.unary(Unary::Not, before, span);
            self.binary(Binary::And, now, not_before, span)
        } else {
            let not_now = self.unary(Unary::Not, now, span);
            self.binary(Binary::And, before, not_now, span)
        };
        let edge = self.value(edge);
        let edge = self.kept(edge, span);
        self.assign(bit, now, span);
        edge
    }

    /// A value converted to the type that the element specifies for its inputs, if it specifies one.
    pub(super) fn typed(&mut self, element: &Element, value: ExpressionId) -> ExpressionId {
        // MIN, MAX, LIMIT and SEL specify the type of their inputs in the same setting as counters.
        let of = element.setting("SRCTYPE").or(element.setting("VALUE_TYPE"));
        let of = of.and_then(|name| Elementary::named(&name.to_uppercase()));
        let span = self.tree.expressions[value].span;
        match of {
            Some(of) => self.tree.expressions.add(ExpressionKind::As(of, value), span),
            None => value,
        }
    }

    fn comparison(&mut self, law: Law, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let has_operand = matches!(law, Law::Valid(_)) && element.inputs.iter().any(|input| input.pin == "OPERAND");
        let flow = self.flow(element, if has_operand { FLOW } else { &["PRE"] });
        let pin = |lowerer: &mut Self, pin: &str| {
            let operand = lowerer.operand(element, pin)?;
            Some(lowerer.typed(element, operand))
        };
        let result = match law {
            Law::Compare(operator) => {
                let (Some(left), Some(right)) = (pin(self, "IN1"), pin(self, "IN2")) else { return };
                self.binary(operator, left, right, span)
            }
            Law::Range(is_inside) => {
                let pins = (pin(self, "MIN"), pin(self, "IN"), pin(self, "MAX"));
                let (Some(low), Some(value), Some(high)) = pins else { return };
                let operators = if is_inside {
                    [Binary::GreaterOrEqual, Binary::LessOrEqual]
                } else {
                    [Binary::Less, Binary::Greater]
                };
                let one = self.binary(operators[0], value, low, span);
                let other = self.binary(operators[1], value, high, span);
                self.binary(if is_inside { Binary::And } else { Binary::Or }, one, other, span)
            }
            _ => {
                let Some(value) = pin(self, if has_operand { "OPERAND" } else { "IN" }) else { return };
                let invalid = self.of_function("CALL?", vec![("IN".to_string(), value)], span);
                if matches!(law, Law::Valid(true)) { self.unary(Unary::Not, invalid, span) } else { invalid }
            }
        };
        let result = self.value(result);
        let out = self.joined(Binary::And, flow, result, span);
        self.set(elements, number, "OUT", out);
    }

    fn coil(&mut self, law: Law, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["IN", "EN"]);
        let negated = element.negated.iter().any(|pin| pin == "OPERAND");
        let Some(mut target) = self.operand(element, "OPERAND") else { return };
        if negated && let ExpressionKind::Unary(Unary::Not, inner) = self.tree.expressions[target].kind {
            target = inner;
            if !matches!(law, Law::Coil(_)) {
                let message = format!("{} has a negated operand", element.name);
                self.report.error(span, message, Some("negate the power flow that leads to it instead"));
            }
        }
        let is_passed = ["OUT", "ENO"].iter().any(|pin| self.is_awaited(&(number, pin.to_string())));
        let bit = element.inputs.iter().any(|input| input.pin == "BIT").then(|| self.operand(element, "BIT")).flatten();
        let roots = self.roots(bit.into_iter().chain([target]));
        let flow = if is_passed {
            let flow = self.shared(flow, span);
            self.apart(flow, &roots, span)
        } else {
            flow
        };
        match law {
            Law::Coil(is_negated) => {
                let value = if is_negated != negated { self.negated(flow.clone(), span) } else { flow.clone() };
                let value = self.expression(&value, span);
                self.assign(target, value, span);
            }
            Law::EdgeCoil(is_rising) => {
                let Some(bit) = bit.or_else(|| self.operand(element, "BIT")) else { return };
                let edge = self.edge(flow.clone(), bit, is_rising, span);
                let edge = self.expression(&edge, span);
                self.assign(target, edge, span);
            }
            Law::SetField(is_set) => self.field(is_set, element, flow.clone(), target),
            Law::Set(is_set) => {
                let roots = self.roots([target]);
                self.before_writing(&roots, span);
                let body = self.aside(|lowerer| {
                    let value = lowerer.literal(if is_set { "BOOL#TRUE" } else { "BOOL#FALSE" }, span);
                    lowerer.assign(target, value, span);
                });
                self.only_if(flow.clone(), body, span);
            }
            _ => {}
        }
        for pin in ["OUT", "ENO"] {
            self.set(elements, number, pin, flow.clone());
        }
    }

    /// Sets or resets consecutive bits, starting at an element of an array or at a bit of a word.
    fn field(&mut self, is_set: bool, element: &Element, flow: Value, first: ExpressionId) {
        let span = element.span;
        let Some(count) = self.operand(element, "N") else { return };
        if let Some(number) = self.whole(count).filter(|number| !(1..=MOST_BITS).contains(number)) {
            let message = format!("{}: {number} is not a valid number of bits", element.name);
            self.report.error(span, message, Some(&format!("enter a number from 1 to {MOST_BITS}")));
            return;
        }
        let roots = self.roots([first]);
        self.before_writing(&roots, span);
        let value = self.literal(if is_set { "BOOL#TRUE" } else { "BOOL#FALSE" }, span);
        let body = match &self.tree.expressions[first].kind {
            ExpressionKind::Index(array, indices) if indices.len() == 1 => {
                let (array, index) = (*array, indices[0]);
                self.elements_of_field(array, index, count, value, span)
            }
            ExpressionKind::Member(word, bit) => {
                let (word, bit) = (*word, bit.key());
                let Some(bit) = bit.trim_start_matches('%').strip_prefix('X').and_then(|bit| bit.parse().ok()) else {
                    return self.no_field(element);
                };
                let Some(body) = self.bits_of_field(element, word, bit, count, value) else { return };
                body
            }
            _ => return self.no_field(element),
        };
        self.only_if(flow, body, span);
    }

    fn no_field(&mut self, element: &Element) {
        let message =
            format!("{}: the operand is neither an element of an array of Bool nor a bit of a word", element.name);
        self.report.error(
            element.span,
            message,
            Some("specify the first bit to be changed, such as #bits[0] or #word.%X0"),
        );
    }

    /// The value of an integer literal; `None` for any other expression.
    fn whole(&self, id: ExpressionId) -> Option<i128> {
        match &self.tree.expressions[id].kind {
            ExpressionKind::Literal(text) => match constant::read(text) {
                Ok(Literal::Whole(whole, _)) => Some(whole),
                _ => None,
            },
            _ => None,
        }
    }

    fn elements_of_field(
        &mut self,
        array: ExpressionId,
        index: ExpressionId,
        count: ExpressionId,
        value: ExpressionId,
        span: Span,
    ) -> Vec<Statement> {
        self.aside(|lowerer| {
            let counter = lowerer.temporary(span);
            lowerer.push(StatementKind::Let(counter.clone(), Some(Elementary::DInt), None), span);
            let [first, last] = match (lowerer.whole(index), lowerer.whole(count)) {
                (Some(low), Some(count)) => [low, low + count - 1].map(|at| lowerer.literal(&at.to_string(), span)),
                _ => {
                    let wide = |lowerer: &mut Self, id| {
                        lowerer.tree.expressions.add(ExpressionKind::As(Elementary::DInt, id), span)
                    };
                    let (low, count) = (wide(lowerer, index), wide(lowerer, count));
                    let end = lowerer.binary(Binary::Add, low, count, span);
                    let one = lowerer.literal("1", span);
                    [low, lowerer.binary(Binary::Subtract, end, one, span)]
                }
            };
            let variable = lowerer.named(&counter, span);
            let at = lowerer.named(&counter, span);
            let target = lowerer.tree.expressions.add(ExpressionKind::Index(array, vec![at]), span);
            let write = Statement { kind: StatementKind::Assign(vec![(target, None)], value), span };
            lowerer.push(StatementKind::For { variable, first, last, step: None, body: vec![write] }, span);
        })
    }

    fn bits_of_field(
        &mut self,
        element: &Element,
        word: ExpressionId,
        first: u32,
        count: ExpressionId,
        value: ExpressionId,
    ) -> Option<Vec<Statement>> {
        let span = element.span;
        let Some(count) = self.whole(count).filter(|count| *count <= MOST_BITS_OF_A_WORD) else {
            let message = format!(
                "{}: the number of bits in a word must be a constant from 1 to {MOST_BITS_OF_A_WORD}",
                element.name
            );
            self.report.error(span, message, Some("enter such a constant"));
            return None;
        };
        let at = self.tree.expressions[word].span;
        let bits = (0..count).map(|offset| format!("%X{}", i128::from(first) + offset));
        let write = |text: String| {
            let kind = ExpressionKind::Member(word, Name { text, span: at });
            let target = self.tree.expressions.add(kind, span);
            Statement { kind: StatementKind::Assign(vec![(target, None)], value), span }
        };
        Some(bits.map(write).collect())
    }

    fn flip_flop(&mut self, is_set_dominant: bool, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let pin = |lowerer: &mut Self, pins: [&str; 2]| pins.iter().find_map(|pin| lowerer.input(element, pin));
        let (set, reset) = (pin(self, ["S", "S1"]), pin(self, ["R", "R1"]));
        let Some(operand) = self.operand(element, "OPERAND") else { return };
        let never = |lowerer: &mut Self| Value { of: Some(lowerer.literal("BOOL#FALSE", span)), ..Value::TRUE };
        let set = set.unwrap_or_else(|| never(self));
        let reset = reset.unwrap_or_else(|| never(self));
        let held = self.value(operand);
        let not_reset = self.negated(reset, span);
        let next = if is_set_dominant {
            let kept = self.joined(Binary::And, held, not_reset, span);
            self.joined(Binary::Or, set, kept, span)
        } else {
            let on = self.joined(Binary::Or, set, held, span);
            self.joined(Binary::And, on, not_reset, span)
        };
        let next = self.expression(&next, span);
        self.assign(operand, next, span);
        let out = self.value(operand);
        self.set(elements, number, "Q", out);
    }

    fn timer_coil(&mut self, law: Law, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["IN", "EN"]);
        let timer = ["OPERAND", "TIMER"].iter().find_map(|pin| self.input(element, pin)).and_then(|value| value.of);
        let Some(timer) = timer.or(element.called) else {
            self.report.error(span, format!("{} has no timer", element.name), Some("enter an IEC timer"));
            return;
        };
        let preset = PRESET.iter().find_map(|pin| self.input(element, pin));
        let preset = preset.map(|preset| self.expression(&preset, span));
        let roots = self.roots([timer]);
        let flow = self.shared(flow, span);
        let flow = self.apart(flow, &roots, span);
        self.before_writing(&roots, span);
        let mut arguments: Vec<(String, bool, ExpressionId)> =
            preset.into_iter().map(|preset| ("PT".to_string(), false, preset)).collect();
        match law {
            Law::TimerCoil(kind) => {
                let callee = self.as_kind(element, timer, kind);
                let flow = self.expression(&flow, span);
                arguments.insert(0, ("IN".to_string(), false, flow));
                let call = self.call(callee, arguments, span);
                self.push(StatementKind::Call(call), span);
            }
            Law::TimerFunction(name) => {
                let callee = self.function(name, span);
                arguments.push(("TIMER".to_string(), false, timer));
                let call = self.call(callee, arguments, span);
                let body = vec![Statement { kind: StatementKind::Call(call), span }];
                self.only_if(flow.clone(), body, span);
            }
            _ => {}
        }
        for pin in ["OUT", "ENO"] {
            self.set(elements, number, pin, flow.clone());
        }
    }
}
