//! What each element does, as statements.

use super::elements::{Failure, Formula, Law, Returned};
use super::flow::{Value, root};
use super::lower::Lowerer;
use super::{Element, Way};
use crate::lexer::Span;
use crate::syntax::{Binary, ExpressionId, ExpressionKind, Scope, Statement, StatementKind, Unary};
use crate::types::Elementary;
use std::collections::BTreeSet;

/// The pins at which a flow arrives.
const FLOW: &[&str] = &["PRE", "IN"];
/// The pins of the preset time of a timer's coil.
const PRESET: [&str; 4] = ["PT", "VALUE", "TV", "PRESET"];
/// So many bits a field may have.
const MOST_BITS: u32 = 65_535;

impl Lowerer<'_> {
    /// An element by its law.
    pub fn law(&mut self, law: Law, elements: &[Element], number: usize) {
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
                let pins: Vec<String> = element.inputs.iter().map(|input| input.pin.clone()).collect();
                let values: Vec<Value> = pins.iter().filter_map(|pin| self.input(element, pin)).collect();
                let joined = values.into_iter().reduce(|left, right| self.joined(operator, left, right, span));
                match joined {
                    Some(value) => self.set(elements, number, "OUT", value),
                    None => {
                        let message = format!("{} has no inputs", element.name);
                        self.report.error(span, message, Some("wire them, or delete it"));
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
                let flow = self.flow(element, &["IN"]);
                let flow = if is_if_true { flow } else { self.negated(flow, span) };
                let Some(label) = &element.label else {
                    self.report.error(span, format!("{} has no label", element.name), Some("enter the label"));
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
                let flow = self.flow(element, &["IN"]);
                let value = match returned {
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
            Law::Statement(name) => {
                let callee = self.function(name, span);
                self.statement(callee, elements, number);
            }
        }
    }

    /// The edge of a value whose last one is kept in a bit.
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

    /// A value in the type that the element has for its inputs.
    fn typed(&mut self, element: &Element, value: ExpressionId) -> ExpressionId {
        // INC and DEC have one type, that of their result.
        let of = element.setting("SRCTYPE").or(element.setting("DESTTYPE"));
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
                let invalid = self.fails("CALL?", vec![("IN".to_string(), value)], span);
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
        }
        let is_passed = ["OUT", "ENO"].iter().any(|pin| self.is_awaited(&(number, pin.to_string())));
        let bit = element.inputs.iter().any(|input| input.pin == "BIT").then(|| self.operand(element, "BIT")).flatten();
        let roots = self.roots(bit.into_iter().chain([target]));
        let flow = match law {
            _ if is_passed => {
                let flow = self.shared(flow, span);
                self.apart(flow, &roots, span)
            }
            _ => flow,
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
                let root = root(&self.tree.expressions, target, &self.owner.shared);
                self.before_writing(&BTreeSet::from([root]), span);
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

    /// Sets or resets bits from an element of an array, or from a bit of a word, on.
    fn field(&mut self, is_set: bool, element: &Element, flow: Value, first: ExpressionId) {
        let span = element.span;
        let Some(count) = self.operand(element, "N") else { return };
        let literal = |lowerer: &Self, id: ExpressionId| match &lowerer.tree.expressions[id].kind {
            ExpressionKind::Literal(text) => text.rsplit('#').next()?.parse::<i64>().ok(),
            _ => None,
        };
        let Some(count) = literal(self, count).filter(|count| (1..=i64::from(MOST_BITS)).contains(count)) else {
            let message = format!("{}: the number of bits is no constant from 1 to {MOST_BITS}", element.name);
            self.report.error(span, message, Some("enter a number"));
            return;
        };
        let ExpressionKind::Index(array, indices) = &self.tree.expressions[first].kind else {
            let message = format!("{}: the operand is no element of an array of Bool", element.name);
            self.report.error(span, message, Some("use the first element to be changed, such as #bits[0]"));
            return;
        };
        let (array, index) = (*array, indices.clone());
        let ([index], Some(low)) = (index.as_slice(), index.first().and_then(|index| literal(self, *index))) else {
            let message = format!("{}: the first element has an index that is no constant", element.name);
            self.report.error(span, message, Some("use a constant index and one dimension"));
            return;
        };
        let at = self.tree.expressions[*index].span;
        let root = root(&self.tree.expressions, array, &self.owner.shared);
        self.before_writing(&BTreeSet::from([root]), span);
        let body = self.aside(|lowerer| {
            let counter = lowerer.temporary(span);
            lowerer.push(StatementKind::Let(counter.clone(), Some(Elementary::DInt), None), span);
            let range = [lowerer.literal(&low.to_string(), at), lowerer.literal(&(low + count - 1).to_string(), at)];
            let variable = lowerer.named(&counter, span);
            let index = lowerer.named(&counter, span);
            let target = lowerer.tree.expressions.add(ExpressionKind::Index(array, vec![index]), span);
            let value = lowerer.literal(if is_set { "BOOL#TRUE" } else { "BOOL#FALSE" }, span);
            let write = Statement { kind: StatementKind::Assign(vec![(target, None)], value), span };
            lowerer.push(StatementKind::For(variable, range, None, vec![write]), span);
        });
        self.only_if(flow, body, span);
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
                let callee = self.member(timer, kind, span);
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

    /// A box that is executed if EN: what it writes, and what its pins carry.
    fn boxed(&mut self, formula: Formula, failure: Failure, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let Some((result, failed)) = self.formula(formula, failure, element) else { return };
        let pins: BTreeSet<String> = self.result_pins(element, number);
        let targets: Vec<ExpressionId> = match formula {
            Formula::Step(_) => self.operand(element, "OPERAND").into_iter().collect(),
            _ => element.outputs.iter().filter(|(pin, _)| pin != "ENO").map(|(_, target)| *target).collect(),
        };
        let is_wired = pins.iter().any(|pin| self.is_awaited(&(number, pin.clone())));
        let has_eno = self.has_eno(element, number);
        let roots = self.roots(targets.iter().copied());
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
            let is_once = !is_wired && targets.len() <= 1;
            let result = if is_once {
                result
            } else {
                let name = lowerer.temporary(span);
                lowerer.push(StatementKind::Let(name.clone(), None, Some(result)), span);
                lowerer.named(&name, span)
            };
            for target in &targets {
                lowerer.push(StatementKind::Assign(vec![(*target, None)], result), span);
            }
            carried = Some(result);
        });
        self.only_if(flow.clone(), body, span);
        for pin in pins {
            if let (true, Some(carried)) = (self.is_awaited(&(number, pin.clone())), carried) {
                let value = Value { of: Some(carried), ..Value::TRUE };
                self.values.insert((number, pin), value);
            }
        }
        let eno = match eno {
            Some(eno) => Value { of: Some(self.named(&eno, span)), ..Value::TRUE },
            None => flow,
        };
        self.set(elements, number, "ENO", eno);
    }

    fn has_eno(&self, element: &Element, number: usize) -> bool {
        self.is_awaited(&(number, "ENO".to_string())) || element.outputs.iter().any(|(pin, _)| pin == "ENO")
    }

    /// The output pins of an element that are used, without ENO.
    fn result_pins(&self, element: &Element, number: usize) -> BTreeSet<String> {
        let wired = self.uses.iter().filter(|((of, _), uses)| *of == number && **uses > 0).map(|((_, pin), _)| pin);
        let written = element.outputs.iter().map(|(pin, _)| pin);
        wired.chain(written).filter(|pin| *pin != "ENO").cloned().collect()
    }

    /// A call of an instance: a timer or a counter as its kind, any other block of the system as it is declared.
    fn instance(&mut self, kind: Option<&'static str>, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let Some(called) = element.called else {
            let message = format!("{} has no instance", element.name);
            self.report.error(span, message, Some("enter its instance: a variable of its type, or a data block"));
            return;
        };
        let callee = match kind {
            None => called,
            Some(kind) => {
                let of = element.setting("TIME_TYPE").or(element.setting("VALUE_TYPE")).unwrap_or_default();
                let is_usual = ["", "TIME", "INT"].contains(&of.to_uppercase().as_str());
                let is_global = matches!(self.tree.expressions[called].kind, ExpressionKind::Name(Scope::Global, _));
                let name =
                    if is_usual || !is_global { kind.to_string() } else { format!("{kind}_{}", of.to_uppercase()) };
                self.member(called, &name, span)
            }
        };
        self.call_instance(callee, called, elements, number);
    }

    /// The arguments of a call from the pins of an element, and what they write.
    fn arguments(&mut self, element: &Element) -> (Vec<(String, bool, ExpressionId)>, BTreeSet<String>) {
        let span = element.span;
        let mut arguments = Vec::new();
        // A block that is called may write what all blocks see.
        let mut roots = BTreeSet::from([String::new()]);
        let pins: Vec<String> =
            element.inputs.iter().map(|input| input.pin.clone()).filter(|pin| pin != "EN").collect();
        for pin in pins {
            let Some(value) = self.input(element, &pin) else { continue };
            let value = self.expression(&value, span);
            if matches!(
                self.tree.expressions[value].kind,
                ExpressionKind::Name(..) | ExpressionKind::Member(..) | ExpressionKind::Index(..)
            ) && self.is_in_out(element, &pin)
            {
                roots.insert(root(&self.tree.expressions, value, &self.owner.shared));
            }
            arguments.push((pin, false, value));
        }
        for (pin, target) in element.outputs.iter().filter(|(pin, _)| pin != "ENO") {
            let is_first = !arguments.iter().any(|(name, is_output, _)| *is_output && name == pin);
            if is_first && !self.is_value(element, pin) {
                arguments.push((pin.clone(), true, *target));
            }
            roots.insert(root(&self.tree.expressions, *target, &self.owner.shared));
        }
        (arguments, roots)
    }

    fn is_in_out(&self, element: &Element, pin: &str) -> bool {
        let Some(call) = &element.call else { return false };
        let found = call.parameters.iter().find(|parameter| parameter.name.eq_ignore_ascii_case(pin));
        found.is_none_or(|parameter| parameter.way == Way::InOut)
    }

    fn is_value(&self, element: &Element, pin: &str) -> bool {
        let Some(call) = element.call.as_ref().filter(|call| call.is_function) else { return false };
        let found = call.parameters.iter().find(|parameter| parameter.name.eq_ignore_ascii_case(pin));
        found.map_or(pin == "RET_VAL", |parameter| parameter.way == Way::Value)
    }

    fn call_instance(&mut self, callee: ExpressionId, instance: ExpressionId, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let (mut arguments, mut roots) = self.arguments(element);
        roots.insert(root(&self.tree.expressions, instance, &self.owner.shared));
        let eno = self.eno_of_call(element, number, &mut arguments);
        let flow = if eno.is_some() { self.shared(flow, span) } else { flow };
        self.before_writing(&roots, span);
        let mut body = self.aside(|lowerer| {
            let call = lowerer.call(callee, arguments, span);
            lowerer.push(StatementKind::Call(call), span);
        });
        // A pin that is written to several variables.
        for (at, (pin, target)) in element.outputs.iter().enumerate() {
            if pin != "ENO" && element.outputs[..at].iter().any(|(before, _)| before == pin) {
                let value = self.member(instance, pin, span);
                body.push(Statement { kind: StatementKind::Assign(vec![(*target, None)], value), span });
            }
        }
        self.only_if(flow, body, span);
        for pin in self.result_pins(element, number) {
            if self.is_awaited(&(number, pin.clone())) {
                let value = self.member(instance, &pin, span);
                let mut value = self.value(value);
                if element.negated.contains(&pin) {
                    value = self.negated(value, span);
                }
                self.values.insert((number, pin), value);
            }
        }
        if let Some(eno) = eno {
            self.set(elements, number, "ENO", eno);
        }
    }

    /// ENO of a call, if it is wired: FALSE before the call.
    fn eno_of_call(
        &mut self,
        element: &Element,
        number: usize,
        arguments: &mut Vec<(String, bool, ExpressionId)>,
    ) -> Option<Value> {
        let span = element.span;
        self.has_eno(element, number).then(|| {
            let eno = self.temporary(span);
            let no = self.literal("BOOL#FALSE", span);
            self.push(StatementKind::Let(eno.clone(), Some(Elementary::Bool), Some(no)), span);
            arguments.push(("ENO".to_string(), true, self.named(&eno, span)));
            Value { of: Some(self.named(&eno, span)), ..Value::TRUE }
        })
    }

    /// A call of a block.
    pub fn call_of(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        let Some(called) = element.called else {
            let message = format!("the call of {} has no instance", element.name);
            self.report.error(element.span, message, Some("enter its instance"));
            return;
        };
        if element.call.as_ref().is_some_and(|call| call.is_function) {
            self.statement(called, elements, number);
        } else {
            self.call_instance(called, called, elements, number);
        }
    }

    /// A function that is called as a statement.
    fn statement(&mut self, callee: ExpressionId, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let (mut arguments, roots) = self.arguments(element);
        let mut carried: Vec<(String, ExpressionId)> = Vec::new();
        let mut value = None;
        for pin in self.result_pins(element, number) {
            let is_wired = self.is_awaited(&(number, pin.clone()));
            let targets = element.outputs.iter().filter(|(own, _)| *own == pin).count();
            let is_value = self.is_value(element, &pin);
            if !is_wired && targets == 1 && !is_value {
                continue;
            }
            let name = self.temporary(span);
            let parameter = element.call.iter().flat_map(|call| &call.parameters);
            let of = parameter.into_iter().find(|parameter| parameter.name.eq_ignore_ascii_case(&pin));
            let of = of.and_then(|parameter| Elementary::named(&parameter.of.as_ref()?.to_uppercase()));
            let temporary = self.named(&name, span);
            carried.push((pin.clone(), temporary));
            if is_value && !is_wired && targets == 1 {
                value = element.outputs.iter().find(|(own, _)| *own == pin).map(|(_, target)| (*target, None));
                carried.pop();
                continue;
            }
            if is_value {
                value = Some((temporary, Some(name)));
                continue;
            }
            self.push(StatementKind::Let(name, Some(of.unwrap_or(Elementary::Bool)), None), span);
            arguments.retain(|(own, is_output, _)| !is_output || *own != pin);
            arguments.push((pin, true, temporary));
        }
        let eno = match element.call {
            Some(_) => self.eno_of_call(element, number, &mut arguments),
            None => None,
        };
        let flow = if self.has_eno(element, number) {
            let flow = self.shared(flow, span);
            self.apart(flow, &roots, span)
        } else {
            flow
        };
        self.before_writing(&roots, span);
        let body = self.aside(|lowerer| {
            let call = lowerer.call(callee, arguments, span);
            match value {
                None => lowerer.push(StatementKind::Call(call), span),
                Some((_, Some(name))) => lowerer.push(StatementKind::Let(name, None, Some(call)), span),
                Some((target, None)) => lowerer.push(StatementKind::Assign(vec![(target, None)], call), span),
            }
            for (pin, temporary) in &carried {
                for (_, target) in element.outputs.iter().filter(|(own, _)| own == pin) {
                    lowerer.push(StatementKind::Assign(vec![(*target, None)], *temporary), span);
                }
            }
        });
        self.only_if(flow.clone(), body, span);
        for (pin, temporary) in carried {
            if self.is_awaited(&(number, pin.clone())) {
                self.values.insert((number, pin), Value { of: Some(temporary), ..Value::TRUE });
            }
        }
        self.set(elements, number, "ENO", eno.unwrap_or(flow));
    }

    /// An instruction that has no row: called by its name, so that what is known of the name is said.
    pub fn other(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        match element.called {
            Some(_) => self.instance(None, elements, number),
            None => {
                let callee = self.function(&element.name.to_uppercase(), element.span);
                self.statement(callee, elements, number);
            }
        }
    }

    /// The value of a box, and what is TRUE if it fails; `None` if a pin is missing, which is told.
    fn formula(
        &mut self,
        formula: Formula,
        failure: Failure,
        element: &Element,
    ) -> Option<(ExpressionId, Option<ExpressionId>)> {
        let span = element.span;
        let own = element.setting("DESTTYPE").map(str::to_uppercase);
        let source = element.setting("SRCTYPE").map(str::to_uppercase);
        let mut given: Vec<(String, ExpressionId)> = Vec::new();
        let result = match formula {
            Formula::Same => self.operand(element, "IN")?,
            Formula::Fold(operator) => {
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
                let value = self.operand(element, "OPERAND")?;
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
                let callee = self.function(&name, span);
                let arguments = given.iter().map(|(pin, value)| (formal(pin), false, *value)).collect();
                self.call(callee, arguments, span)
            }
            Formula::Convert => {
                let value = self.operand(element, "IN")?;
                given.push(("IN".to_string(), value));
                match (source, &own) {
                    (_, None) => value,
                    (source, Some(own)) => {
                        let name = source.map_or(format!("TO_{own}"), |source| format!("{source}_TO_{own}"));
                        let callee = self.function(&name, span);
                        self.call(callee, vec![("IN".to_string(), false, value)], span)
                    }
                }
            }
            Formula::Equation => {
                let Some(equation) = element.equation else {
                    self.report.error(span, format!("{} has no expression", element.name), Some("enter it in the box"));
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
            Failure::Calculation("CALL") => Some(self.fails("CALL?", vec![("IN".to_string(), result)], span)),
            Failure::Calculation(kind) => {
                let name = own.map_or(format!("{kind}?"), |own| format!("{kind}?_{own}"));
                Some(self.fails(&name, given, span))
            }
            Failure::Condition(kind) => self.condition(kind, &given, result, span),
        };
        Some((result, failed))
    }

    /// TRUE if a calculation fails.
    fn fails(&mut self, name: &str, pins: Vec<(String, ExpressionId)>, span: Span) -> ExpressionId {
        let callee = self.function(name, span);
        let arguments = pins.into_iter().map(|(pin, value)| (pin, false, value)).collect();
        self.call(callee, arguments, span)
    }

    /// TRUE if the inputs of a function are none that it has a value for.
    fn condition(
        &mut self,
        kind: &str,
        given: &[(String, ExpressionId)],
        result: ExpressionId,
        span: Span,
    ) -> Option<ExpressionId> {
        let pin = |name: &str| given.iter().find(|(pin, _)| pin == name).map(|(_, value)| *value);
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
                let limits = self.binary(Binary::GreaterOrEqual, pin("MIN")?, pin("MAX")?, span);
                let invalid = self.fails("CALL?", vec![("IN".to_string(), result)], span);
                Some(self.binary(Binary::Or, limits, invalid, span))
            }
        }
    }

    /// The pins of an element that a pattern such as `IN*` names.
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

    /// The expression of a Calculate box with what its pins get.
    fn substituted(&mut self, id: ExpressionId, given: &[(String, ExpressionId)]) -> Option<ExpressionId> {
        let span = self.tree.expressions[id].span;
        let kind = match &self.tree.expressions[id].kind {
            ExpressionKind::Name(_, name) => {
                let name = name.key();
                let found = given.iter().find(|(pin, _)| *pin == name).map(|(_, value)| *value);
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

/// The pins IN0, IN1, IN2 ... of an element, in the order of their numbers.
fn numbered(element: &Element) -> Vec<String> {
    let number = |pin: &str| pin.strip_prefix("IN").and_then(|number| number.parse::<u32>().ok());
    let mut pins: Vec<(u32, String)> =
        element.inputs.iter().filter_map(|input| Some((number(&input.pin)?, input.pin.clone()))).collect();
    pins.sort();
    pins.into_iter().map(|(_, pin)| pin).collect()
}

/// The name of a function's parameter for a pin.
fn formal(pin: &str) -> String {
    if pin == "ELSE" { "INELSE".to_string() } else { pin.to_string() }
}
