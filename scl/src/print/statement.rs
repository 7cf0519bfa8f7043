//! Prints statements.

use super::facts::{self, Use};
use super::{Dialect, Printer, WIDTH, natural, number};
use crate::check::types::Elementary;
use crate::ir::{Argument, Base, Call, Expr, For, Place, Section, Statement, Step, Type, Value, What};

impl Printer<'_> {
    /// Adds a line to the function; a line that is too wide is broken where possible.
    pub(super) fn line(&mut self, text: &str) {
        let indent = 4 * self.scope.indent;
        let mut rest = text;
        let mut first = true;
        loop {
            let space = indent + if first { 0 } else { 8 };
            let room = WIDTH.saturating_sub(space);
            // A comment must not be broken: it ends at the end of its line.
            let breaks = |(at, _): (usize, &str)| Some(at).filter(|at| *at > 0 && *at < room);
            let end = if rest.len() <= room || rest.starts_with("//") || rest.contains('\'') {
                None
            } else {
                [" OR ", " AND ", ", ", " + ", " - "].iter().find_map(|sign| {
                    rest.match_indices(sign).filter_map(breaks).last().map(|at| at + sign.trim_end().len())
                })
            };
            let Some(end) = end else {
                self.scope.lines.push(format!("{}{rest}", " ".repeat(space)));
                return;
            };
            self.scope.lines.push(format!("{}{}", " ".repeat(space), &rest[..end]));
            rest = rest[end..].trim_start();
            first = false;
        }
    }

    /// Declares a new temporary of this type and returns its name.
    pub(super) fn temporary(&mut self, of: &str) -> String {
        let mut count = self.scope.temporaries.len();
        let name = loop {
            count += 1;
            let name = format!("kept_{count}");
            let taken = self.scope.interface.locals.iter().chain(self.scope.interface.members.values());
            if !taken.clone().any(|other| other.eq_ignore_ascii_case(&name)) {
                break name;
            }
        };
        self.scope.temporaries.push((name.clone(), of.to_string()));
        name
    }

    /// Prints indented statements; an empty list becomes an empty statement.
    fn block(&mut self, list: &[Statement]) -> Result<(), String> {
        self.scope.indent += 1;
        let before = self.scope.lines.len();
        self.statements(list)?;
        if self.scope.lines[before..].iter().all(|line| line.trim_start().starts_with("//")) {
            self.line(";");
        }
        self.scope.indent -= 1;
        Ok(())
    }

    pub(super) fn statements(&mut self, list: &[Statement]) -> Result<(), String> {
        let mut at = 0;
        while at < list.len() {
            at += match self.supplied(&list[at..]) {
                Some((count, call)) => {
                    self.call_block(&list[at..at + count - 1], &call.clone())?;
                    count
                }
                None => {
                    self.statement(&list[at].what)?;
                    1
                }
            };
        }
        Ok(())
    }

    /// If a list starts with assignments to the inputs of an instance followed by a call to it: the number of these
    /// statements, including the call, and the call.
    fn supplied<'s>(&self, list: &'s [Statement]) -> Option<(usize, &'s Call)> {
        let at = list.iter().position(|statement| !matches!(statement.what, What::Assign(..)))?;
        let What::Call(call) = &list[at].what else { return None };
        let instance = call.instance.as_ref()?;
        let is_block = matches!(self.facts.uses.get(&call.function), Some(Use::Block | Use::System));
        let record = self.program.functions[call.function].instance?;
        let mut members = Vec::new();
        let all_inputs = list[..at].iter().all(|statement| {
            let What::Assign(to, value) = &statement.what else { return false };
            let [.., Step::Member(number)] = to.steps.as_slice() else { return false };
            let declared = self.program.docs.declared.get(&(record, *number));
            let is_new = !members.contains(number);
            members.push(*number);
            is_new
                && to.base == instance.base
                && to.steps[..to.steps.len() - 1] == instance.steps
                && declared.is_some_and(|declared| declared.section == Section::Input)
                && !self.hoists(value)
        });
        (is_block && all_inputs).then_some((at + 1, call))
    }

    fn statement(&mut self, what: &What) -> Result<(), String> {
        match what {
            What::Assign(to, value) => {
                let (to, of) = self.place(to)?;
                let value = self.value(value, of.ok_or_else(|| format!("{to} is not a number"))?)?;
                self.line(&format!("{to} := {value};"));
            }
            What::Copy(to, from) => {
                let to = self.place(to)?.0;
                let from = match self.constant_text(from) {
                    Some(text) => text,
                    None => self.place(from)?.0,
                };
                self.line(&format!("{to} := {from};"));
            }
            What::Call(call) => self.call(call)?,
            What::If(condition, then, otherwise) => self.choice("IF", condition, then, otherwise)?,
            What::Case(selector, arms, otherwise) => {
                let selector = self.argument(selector, number(selector.ty()))?;
                self.line(&format!("CASE {selector} OF"));
                self.scope.indent += 1;
                for arm in arms {
                    let value =
                        |(low, high): &(i64, i64)| if low == high { low.to_string() } else { format!("{low}..{high}") };
                    let values: Vec<String> = arm.values.iter().map(value).collect();
                    self.line(&format!("{}:", values.join(", ")));
                    self.block(&arm.body)?;
                }
                self.scope.indent -= 1;
                if !otherwise.is_empty() {
                    self.line("ELSE");
                    self.scope.indent += 1;
                    self.block(otherwise)?;
                    self.scope.indent -= 1;
                }
                self.line("END_CASE;");
            }
            What::While(condition, body) if self.hoists(condition) => {
                self.line("WHILE TRUE DO");
                self.scope.indent += 1;
                self.leave(condition, false)?;
                self.scope.indent -= 1;
                self.block(body)?;
                self.line("END_WHILE;");
            }
            What::While(condition, body) => {
                let condition = self.value(condition, Elementary::Bool)?;
                self.line(&format!("WHILE {condition} DO"));
                self.block(body)?;
                self.line("END_WHILE;");
            }
            What::Repeat(body, condition) if self.hoists(condition) => {
                let again = self.temporary("BOOL");
                let again = self.own(&again);
                self.line(&format!("{again} := FALSE;"));
                self.line("WHILE TRUE DO");
                self.scope.indent += 1;
                self.line(&format!("IF {again} THEN"));
                self.scope.indent += 1;
                self.leave(condition, true)?;
                self.scope.indent -= 1;
                self.line("END_IF;");
                self.line(&format!("{again} := TRUE;"));
                self.scope.indent -= 1;
                self.block(body)?;
                self.line("END_WHILE;");
            }
            What::Repeat(body, condition) => {
                self.line("REPEAT");
                self.block(body)?;
                let condition = self.value(condition, Elementary::Bool)?;
                self.line(&format!("UNTIL {condition}"));
                self.line("END_REPEAT;");
            }
            What::For(it) => self.counted(it)?,
            What::Break => self.line("EXIT;"),
            What::Continue => self.line("CONTINUE;"),
            What::Return => self.line("RETURN;"),
            What::Label(label) => {
                self.scope.labels.insert(*label);
                self.line(&format!("label_{label}:"));
                self.line(";");
            }
            What::Goto(label) => self.line(&format!("GOTO label_{label};")),
            What::Comment(text) => {
                for line in text.lines() {
                    self.line(format!("// {line}").trim_end());
                }
            }
        }
        Ok(())
    }

    /// Prints statements that leave the loop if a condition has the value `if_true`.
    fn leave(&mut self, condition: &Expr, if_true: bool) -> Result<(), String> {
        let condition = self.value(condition, Elementary::Bool)?;
        let condition = if if_true { condition } else { format!("NOT ({condition})") };
        self.line(&format!("IF {condition} THEN"));
        self.line("    EXIT;");
        self.line("END_IF;");
        Ok(())
    }

    fn choice(
        &mut self,
        word: &str,
        condition: &Expr,
        then: &[Statement],
        otherwise: &[Statement],
    ) -> Result<(), String> {
        let condition = self.value(condition, Elementary::Bool)?;
        self.line(&format!("{word} {condition} THEN"));
        self.block(then)?;
        match otherwise {
            [] => {}
            [Statement { what: What::If(next, then, otherwise), .. }] if !self.hoists(next) => {
                return self.choice("ELSIF", next, then, otherwise);
            }
            _ => {
                self.line("ELSE");
                self.block(otherwise)?;
            }
        }
        self.line("END_IF;");
        Ok(())
    }

    fn counted(&mut self, it: &For) -> Result<(), String> {
        let mut is_written = false;
        facts::each_place(&it.body, &mut |place, writes| is_written |= writes && *place == it.variable);
        if is_written || it.variable.steps.iter().any(|step| matches!(step, Step::Index(..))) {
            return Err(
                "in SCL, the variable of a FOR loop cannot be written in the loop or be an array element".to_string()
            );
        }
        let (variable, of) = self.place(&it.variable)?;
        let of = of.unwrap_or(number(it.first.ty()));
        let parts = self.list(&[(&it.first, of), (&it.last, of), (&it.step, of)], None)?;
        self.line(&format!("FOR {variable} := {} TO {} BY {} DO", parts[0], parts[1], parts[2]));
        self.block(&it.body)?;
        self.line("END_FOR;");
        Ok(())
    }

    /// Prints the call to a function block, with the inputs that these statements set as arguments.
    fn call_block(&mut self, inputs: &[Statement], call: &Call) -> Result<(), String> {
        let Some(instance) = &call.instance else {
            return Err("a function block is called without an instance".to_string());
        };
        let mut parts = Vec::new();
        for input in inputs {
            let What::Assign(to, value) = &input.what else { continue };
            let (path, of) = self.place(to)?;
            let name = path.rsplit('.').next().unwrap_or_default().trim_start_matches('#').to_string();
            parts.push(format!("{name} := {}", self.value(value, of.unwrap_or(natural(value.ty())))?));
        }
        self.references(call, &mut parts)?;
        let (mut instance, _) = self.place(instance)?;
        let callee = &self.program.functions[call.function];
        if callee.instance.is_some_and(|record| self.facts.general.contains(&record)) {
            if self.dialect == Dialect::Step7 {
                return Err(format!("STEP 7 does not have the type of {instance}; print the program for TIA Portal"));
            }
            instance = format!("{instance}.{}", callee.name);
        }
        self.line(&format!("{instance}({});", parts.join(", ")));
        Ok(())
    }

    /// Appends the arguments of a call to a function block, all of which are passed by reference.
    fn references(&mut self, call: &Call, parts: &mut Vec<String>) -> Result<(), String> {
        let callee = &self.program.functions[call.function];
        for (local, argument) in call.arguments.iter().enumerate() {
            let Argument::Reference(place) = argument else {
                return Err(format!(
                    "the argument {} of {} must be a variable",
                    callee.locals[local].name, callee.name
                ));
            };
            let place = self.place(place)?.0;
            parts.push(format!("{} := {place}", self.interfaces[&call.function].locals[local]));
        }
        Ok(())
    }

    /// Whether a call cannot be part of an expression because it has outputs other than its value.
    pub(super) fn needs_statements(&self, call: &Call) -> bool {
        let callee = &self.program.functions[call.function];
        let outs = self.facts.outs.get(&call.function);
        let is_copied_back = (0..callee.parameters).any(|local| outs.is_some_and(|outs| outs.contains(&local)));
        let value = self.facts.values.get(&call.function);
        let has_more = outs.into_iter().flatten().any(|local| Some(local) != value);
        is_copied_back || has_more
    }

    /// The text of a function call, and the type of its value.
    pub(super) fn called(&mut self, call: &Call) -> Result<(String, Elementary), String> {
        let callee = &self.program.functions[call.function];
        let mut parts = Vec::new();
        for (local, argument) in call.arguments.iter().enumerate() {
            let name = self.interfaces[&call.function].locals[local].clone();
            let variable = &callee.locals[local];
            let is_copied_back = self.facts.outs.get(&call.function).is_some_and(|outs| outs.contains(&local));
            let text = match (argument, &variable.ty) {
                (Argument::Reference(place), _) => self.place(place)?.0,
                (Argument::Copy(from), Type::Text { .. }) => match self.constant_text(from) {
                    Some(text) => text,
                    None => self.place(from)?.0,
                },
                (Argument::Value(_) | Argument::Start, Type::Scalar(ty)) if is_copied_back => {
                    let of = natural(*ty);
                    let to = call.outputs.iter().find(|(out, _)| *out == local).map(|(_, to)| to);
                    let value = match argument {
                        Argument::Value(value) => self.value(value, of)?,
                        _ => super::literal(Value::new(*ty, 0), of, true, self.dialect)?,
                    };
                    match to {
                        // A temporary of the caller carries the value to the call and back.
                        Some(to) if facts::is_temporary(to) => {
                            let (to, _) = self.place(to)?;
                            self.line(&format!("{to} := {value};"));
                            to
                        }
                        Some(_) => return Err(format!("{name} of {} is copied back to another variable", callee.name)),
                        None => self.kept(of, &value),
                    }
                }
                (Argument::Value(value), Type::Scalar(ty)) => self.value(value, natural(*ty))?,
                (Argument::Start, Type::Scalar(ty)) => {
                    super::literal(Value::new(*ty, 0), natural(*ty), true, self.dialect)?
                }
                _ => {
                    return Err(format!(
                        "{name} of {} is a structure passed by value, but SCL passes it by reference",
                        callee.name
                    ));
                }
            };
            parts.push(format!("{name} := {text}"));
        }
        let members = self.interfaces[&call.function].members.clone();
        if self.facts.uses.get(&call.function) == Some(&Use::Method) {
            for (path, name) in members {
                let steps = path.into_iter().map(Step::Member).collect();
                let (own, _) = self.place(&Place { base: Base::Instance, steps })?;
                parts.push(format!("{name} := {own}"));
            }
        }
        let value = self.facts.values.get(&call.function).copied();
        let outs = self.facts.outs.get(&call.function).cloned().unwrap_or_default();
        for local in outs.into_iter().filter(|local| *local >= callee.parameters && Some(*local) != value) {
            let name = self.interfaces[&call.function].locals[local].clone();
            let Type::Scalar(ty) = callee.locals[local].ty else {
                return Err(format!(
                    "the output {name} of {} is a structure, which SCL cannot copy to the caller",
                    callee.name
                ));
            };
            let to = call.outputs.iter().find(|(out, _)| *out == local).map(|(_, to)| to.clone());
            let to = match to {
                Some(to) => self.place(&to)?.0,
                None => {
                    let name = self.temporary(natural(ty).name());
                    self.own(&name)
                }
            };
            parts.push(format!("{name} => {to}"));
        }
        let of = match value.map(|value| &callee.locals[value].ty) {
            Some(Type::Scalar(ty)) => natural(*ty),
            _ => Elementary::Bool,
        };
        Ok((format!("\"{}\"({})", self.functions[call.function], parts.join(", ")), of))
    }

    fn call(&mut self, call: &Call) -> Result<(), String> {
        if matches!(self.facts.uses.get(&call.function), Some(Use::Block | Use::System)) {
            return self.call_block(&[], call);
        }
        let value = self.facts.values.get(&call.function).copied();
        let to = call.outputs.iter().find(|(local, _)| Some(*local) == value).map(|(_, to)| to.clone());
        let (text, of) = self.called(call)?;
        let Some(to) = to else {
            match value {
                Some(_) => drop(self.kept(of, &text)),
                None => self.line(&format!("{text};")),
            }
            return Ok(());
        };
        let (place, to_type) = self.place(&to)?;
        let text = self.as_type(text, of, to_type.unwrap_or(of))?;
        self.line(&format!("{place} := {text};"));
        Ok(())
    }

    /// The label declarations, if the dialect requires them.
    pub(super) fn label_section(&self) -> Option<String> {
        let labels: Vec<String> = self.scope.labels.iter().map(|label| format!("label_{label}")).collect();
        (self.dialect == Dialect::Step7 && !labels.is_empty())
            .then(|| format!("LABEL\n    {};\nEND_LABEL\n", labels.join(", ")))
    }
}
