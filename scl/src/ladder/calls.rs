//! Calls to instances and functions, whose parameters are named like the pins.

use super::flow::Value;
use super::lower::Lowerer;
use super::{Element, Parameter, Way};
use crate::check::types::Elementary;
use crate::front::syntax::{ExpressionId, ExpressionKind, Scope, Statement, StatementKind, Unary};
use std::collections::BTreeSet;

impl Lowerer<'_> {
    /// Lowers a call to an instance: a timer or counter as its `kind`, any other system block as declared.
    pub(super) fn instance(&mut self, kind: Option<&'static str>, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let Some(called) = element.called else {
            let message = format!("{} has no instance", element.name);
            self.report.error(span, message, Some("specify a variable of its type or a data block"));
            return;
        };
        let callee = kind.map_or(called, |kind| self.as_kind(element, called, kind));
        self.call_instance(callee, called, elements, number);
    }

    /// The callee, as a timer or counter of the element's kind. For a global instance, the kind includes the value type
    /// set at the element unless that is TIME or INT: it determines the type of a data block that is not declared.
    pub(super) fn as_kind(&mut self, element: &Element, called: ExpressionId, kind: &str) -> ExpressionId {
        let of = element.setting("TIME_TYPE").or(element.setting("VALUE_TYPE")).unwrap_or_default().to_uppercase();
        let is_usual = ["", "TIME", "INT"].contains(&of.as_str());
        let is_global = matches!(self.tree.expressions[called].kind, ExpressionKind::Name(Scope::Global, _));
        let name = if is_usual || !is_global { kind.to_string() } else { format!("{kind}_{of}") };
        self.member(called, &name, element.span)
    }

    /// The arguments of a call, taken from the pins of an element, and the root variables that the call may write. A
    /// negated output is not an argument: it is written after the call.
    fn arguments(&mut self, element: &Element) -> (Vec<(String, bool, ExpressionId)>, BTreeSet<String>) {
        let span = element.span;
        let mut arguments = Vec::new();
        // The called block may write global variables.
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
                roots.extend(self.roots([value]));
            }
            arguments.push((pin, false, value));
        }
        for (pin, target) in element.outputs.iter().filter(|(pin, _)| pin != "ENO") {
            let is_first = !arguments.iter().any(|(name, _, _)| name == pin);
            if is_first && !self.is_value(element, pin) && !element.negated.contains(pin) {
                // A document may draw an in-out variable on the right-hand side of its box.
                let is_in_out = parameter(element, pin).is_some_and(|parameter| parameter.way == Way::InOut);
                arguments.push((pin.clone(), !is_in_out, *target));
            }
            roots.extend(self.roots([*target]));
        }
        (arguments, roots)
    }

    /// Whether the called block may write the variable at an input pin; true if the call does not list the parameter.
    fn is_in_out(&self, element: &Element, pin: &str) -> bool {
        element.call.is_some() && parameter(element, pin).is_none_or(|parameter| parameter.way == Way::InOut)
    }

    /// Whether a pin is the return value of a function.
    fn is_value(&self, element: &Element, pin: &str) -> bool {
        match &element.call {
            Some(call) if call.is_function => {
                parameter(element, pin).map_or(pin == "RET_VAL", |parameter| parameter.way == Way::Value)
            }
            Some(_) => false,
            None => element.called.is_none() && pin == "RET_VAL",
        }
    }

    fn call_instance(&mut self, callee: ExpressionId, instance: ExpressionId, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let (mut arguments, mut roots) = self.arguments(element);
        roots.extend(self.roots([instance]));
        let eno = self.eno_of_call(element, number, &mut arguments);
        let flow = if eno.is_some() { self.shared(flow, span) } else { flow };
        self.before_writing(&roots, span);
        let mut body = self.aside(|lowerer| {
            let call = lowerer.call(callee, arguments, span);
            lowerer.push(StatementKind::Call(call), span);
        });
        // Negated pins, and the additional variables of pins written to several.
        for (at, (pin, target)) in element.outputs.iter().enumerate() {
            let is_again = element.outputs[..at].iter().any(|(before, _)| before == pin);
            if pin != "ENO" && (is_again || element.negated.contains(pin)) {
                let value = self.member(instance, pin, span);
                let value = self.of_pin(element, pin, value);
                body.push(Statement { kind: StatementKind::Assign(vec![(*target, None)], value), span });
            }
        }
        self.only_if(flow, body, span);
        for pin in self.result_pins(element, number) {
            if self.is_awaited(&(number, pin.clone())) {
                let value = self.member(instance, &pin, span);
                let value = self.of_pin(element, &pin, value);
                let value = self.value(value);
                self.carry((number, pin), value);
            }
        }
        if let Some(eno) = eno {
            self.set(elements, number, "ENO", eno);
        }
    }

    /// The value at an output pin: negated if the pin is negated.
    pub(super) fn of_pin(&mut self, element: &Element, pin: &str, value: ExpressionId) -> ExpressionId {
        let is_negated = element.negated.iter().any(|negated| negated == pin);
        if is_negated { self.unary(Unary::Not, value, element.span) } else { value }
    }

    /// Appends ENO to the arguments of a call if it is in use, and returns its value, which is FALSE before the call.
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

    /// Lowers a call to a function, or to an instance of a function block.
    pub(super) fn call_of(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        let Some(called) = element.called else {
            let message = format!("the call to {} has no instance", element.name);
            self.report.error(element.span, message, Some("specify one"));
            return;
        };
        if element.call.as_ref().is_some_and(|call| call.is_function) {
            self.statement(called, elements, number);
        } else {
            self.call_instance(called, called, elements, number);
        }
    }

    /// Lowers a function called as a statement.
    pub(super) fn statement(&mut self, callee: ExpressionId, elements: &[Element], number: usize) {
        let element = &elements[number];
        let span = element.span;
        let flow = self.flow(element, &["EN"]);
        let (mut arguments, roots) = self.arguments(element);
        let mut carried: Vec<(String, ExpressionId)> = Vec::new();
        let mut value = None;
        let mut pins = self.result_pins(element, number);
        // A call to a function must have arguments for all outputs, even unconnected ones.
        let open = element.open.iter().filter(|pin| *pin != "ENO" && !self.is_value(element, pin));
        pins.extend(open.filter(|_| element.call.is_some()).cloned());
        for pin in pins {
            let mut targets = element.outputs.iter().filter(|(own, _)| *own == pin).map(|(_, target)| *target);
            let only = targets.next().filter(|_| targets.next().is_none());
            let is_direct = !self.is_awaited(&(number, pin.clone())) && !element.negated.contains(&pin);
            let is_value = self.is_value(element, &pin);
            match only.filter(|_| is_direct) {
                Some(target) if is_value => value = Some((target, None)),
                Some(_) => {}
                None => {
                    let name = self.temporary(span);
                    let temporary = self.named(&name, span);
                    carried.push((pin.clone(), temporary));
                    if is_value {
                        value = Some((temporary, Some(name)));
                        continue;
                    }
                    // If the call does not specify the type of an output, the block's declaration does.
                    let of = parameter(element, &pin).and_then(|parameter| parameter.of.as_ref());
                    let of = of.and_then(|of| Elementary::named(&of.to_uppercase()));
                    let of = if element.call.is_some() { of } else { Some(Elementary::Bool) };
                    self.push(StatementKind::Let(name, of, None), span);
                    arguments.retain(|(own, is_output, _)| !is_output || *own != pin);
                    arguments.push((pin, true, temporary));
                }
            }
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
                    let value = lowerer.of_pin(element, pin, *temporary);
                    lowerer.push(StatementKind::Assign(vec![(*target, None)], value), span);
                }
            }
        });
        self.only_if(flow.clone(), body, span);
        for (pin, temporary) in carried {
            if self.is_awaited(&(number, pin.clone())) {
                let value = self.of_pin(element, &pin, temporary);
                self.carry((number, pin), Value { of: Some(value), ..Value::TRUE });
            }
        }
        self.set(elements, number, "ENO", eno.unwrap_or(flow));
    }

    /// Lowers an instruction that is not in the table as a call by name, which yields a more specific error message.
    pub(super) fn other(&mut self, elements: &[Element], number: usize) {
        let element = &elements[number];
        match element.called {
            Some(_) => self.instance(None, elements, number),
            None => {
                let callee = self.function(&element.name.to_uppercase(), element.span);
                self.statement(callee, elements, number);
            }
        }
    }
}

/// The parameter of a call that belongs to a pin.
fn parameter<'e>(element: &'e Element, pin: &str) -> Option<&'e Parameter> {
    let mut parameters = element.call.iter().flat_map(|call| &call.parameters);
    parameters.find(|parameter| parameter.name.eq_ignore_ascii_case(pin))
}
