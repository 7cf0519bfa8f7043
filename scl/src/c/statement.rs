//! Statements.

use super::{Printer, line};
use crate::program::{Argument, Call, Expr, For, Place, Scalar, Statement, Type, What};

impl Printer<'_> {
    pub(super) fn statements(&mut self, list: &[Statement]) -> Result<(), String> {
        let at = self.scope.at;
        for statement in list {
            self.scope.at = statement.at;
            self.statement(&statement.what)?;
        }
        self.scope.at = at;
        Ok(())
    }

    fn block(&mut self, list: &[Statement]) -> Result<(), String> {
        self.scope.indent += 1;
        let done = self.statements(list);
        self.scope.indent -= 1;
        done
    }

    fn statement(&mut self, what: &What) -> Result<(), String> {
        match what {
            What::Assign(to, value) => {
                let text = self.expr(value)?;
                let to = self.place(to)?;
                self.line(&format!("{to} = {text};"));
            }
            What::Copy(to, from) => {
                let (to_type, from_type) = (self.type_of(to)?, self.type_of(from)?);
                let (to, from) = (self.address(to)?, self.address(from)?);
                self.copy(&to_type, &to, &from_type, &from);
            }
            What::Call(call) => self.call(call)?,
            What::If(condition, then, otherwise) => {
                let condition = self.expr(condition)?;
                self.line(&format!("if ({}) {{", bare(&condition)));
                self.block(then)?;
                if !otherwise.is_empty() {
                    self.line("} else {");
                    self.block(otherwise)?;
                }
                self.line("}");
            }
            What::Case(selector, arms, otherwise) => {
                let value = self.expr(selector)?;
                let value = self.kept(Scalar::I64, &format!("(int64_t){value}"));
                let mut word = "if";
                for arm in arms {
                    let inside: Vec<String> = arm.values.iter().map(|range| inside(&value, *range)).collect();
                    let inside = if inside.is_empty() { "0".to_string() } else { inside.join(" || ") };
                    self.line(&format!("{word} ({inside}) {{"));
                    self.block(&arm.body)?;
                    word = "} else if";
                }
                self.line(if arms.is_empty() { "{" } else { "} else {" });
                self.block(otherwise)?;
                self.line("}");
            }
            What::While(condition, body) => {
                self.line("for (;;) {");
                self.scope.indent += 1;
                let condition = self.expr(condition)?;
                self.line(&format!("if (!{condition}) {{ break; }}"));
                self.scope.indent -= 1;
                self.looped(body)?;
                self.again("}");
            }
            What::Repeat(body, condition) => {
                self.line("for (;;) {");
                self.looped(body)?;
                self.scope.indent += 1;
                let condition = self.expr(condition)?;
                self.line(&format!("if ({}) {{ break; }}", bare(&condition)));
                self.scope.indent -= 1;
                self.again("}");
            }
            What::For(it) => self.count(it)?,
            What::Comment(text) => self.line(&format!("/* {} */", text.replace("*/", "* /"))),
            What::Break => self.line("break;"),
            What::Continue => {
                let (label, used) = self.scope.loops.last_mut().ok_or("there is no loop around")?;
                *used = true;
                let label = format!("goto next_{label};");
                self.line(&label);
            }
            What::Return => {
                self.scope.leaves = true;
                self.line("goto done;");
            }
            What::Label(label) => self.line(&format!("label_{label}:;")),
            What::Goto(label) => self.again(&format!("goto label_{label};")),
        }
        Ok(())
    }

    /// The body of a loop, and the label at its end.
    fn looped(&mut self, body: &[Statement]) -> Result<(), String> {
        self.scope.labels += 1;
        self.scope.loops.push((self.scope.labels, false));
        let done = self.block(body);
        if let Some((label, true)) = self.scope.loops.pop() {
            self.line(&format!("next_{label}:;"));
        }
        done
    }

    /// The way back, if the budget allows it.
    fn again(&mut self, text: &str) {
        self.scope.leaves = true;
        let line = line(self.scope.at);
        self.line(&format!("if (!goes_on(call, {line})) {{ goto done; }}"));
        self.line(text);
    }

    fn count(&mut self, it: &For) -> Result<(), String> {
        let ty = it.first.ty();
        let first = self.expr(&it.first)?;
        let variable = self.place(&it.variable)?;
        self.line(&format!("{variable} = {first};"));
        let last = self.expr(&it.last)?;
        let last = self.kept(ty, &last);
        let step = self.expr(&it.step)?;
        let step = self.kept(ty, &step);
        let next = self.temporary(|_, name| format!("{} {name}", super::scalar(ty)));
        self.line("for (;;) {");
        self.scope.indent += 1;
        if !matches!(it.step, Expr::Const(value) if value.bits() != 0) {
            self.scope.leaves = true;
            let line = line(self.scope.at);
            self.line(&format!("if ({step} == 0) {{ stop(call, STEP_OF_0, {line}); goto done; }}"));
        }
        let passed = match ty.is_signed() {
            true => format!("{step} < 0 ? {variable} < {last} : {variable} > {last}"),
            false => format!("{variable} > {last}"),
        };
        self.line(&format!("if ({passed}) {{ break; }}"));
        self.scope.indent -= 1;
        self.looped(&it.body)?;
        self.scope.indent += 1;
        self.line(&format!("{next} = {variable};"));
        let beyond = self.kept(Scalar::I32, &format!("step_{ty}(&{next}, {step})"));
        self.line(&format!("{variable} = {next};"));
        self.line(&format!("if ({beyond}) {{ break; }}"));
        self.scope.indent -= 1;
        self.again("}");
        Ok(())
    }

    /// Copies from an address to another.
    fn copy(&mut self, to_type: &Type, to: &str, from_type: &Type, from: &str) {
        let text = match (to_type, from_type) {
            (Type::Text { capacity: p, wide }, Type::Text { capacity: q, .. }) => {
                format!("copy_text({to}, {p}u, {from}, {q}u, {});", 1 + u8::from(*wide))
            }
            _ => format!("memmove({to}, {from}, {});", self.program.size(to_type)),
        };
        self.line(&text);
    }

    fn call(&mut self, call: &Call) -> Result<(), String> {
        let callee = &self.program.functions[call.function];
        let mut passed = vec!["call".to_string(), "memory".to_string()];
        if let Some(instance) = &call.instance {
            passed.push(self.address(instance)?);
        }
        let values: Vec<&Expr> = call
            .arguments
            .iter()
            .filter_map(|argument| match argument {
                Argument::Value(value) => Some(value),
                _ => None,
            })
            .collect();
        let mut values = self.exprs(&values)?.into_iter();
        for (argument, local) in call.arguments.iter().zip(&callee.locals) {
            match (argument, &local.ty) {
                (Argument::Value(_), _) => passed.extend(values.next()),
                (Argument::Start, Type::Scalar(_)) => passed.push("0".to_string()),
                (Argument::Start, _) => passed.push("NULL".to_string()),
                (Argument::Copy(place), ty) => {
                    let from_type = self.type_of(place)?;
                    let from = self.address(place)?;
                    let copy = self.temporary(|printer, name| printer.declared(ty, name));
                    self.copy(ty, &format!("&{copy}"), &from_type, &from);
                    let array = matches!(ty, Type::Array { .. });
                    passed.push(if array { copy } else { format!("&{copy}") });
                }
                (Argument::Reference(place), ty) => self.reference(place, ty, &mut passed)?,
            }
        }
        // What the callee copies out goes to a temporary, and from there to its place, which is chosen before the call.
        let mut behind = Vec::new();
        for output in self.outputs[call.function].clone() {
            let Some((_, to)) = call.outputs.iter().find(|(local, _)| *local == output) else {
                passed.push("NULL".to_string());
                continue;
            };
            let ty = &callee.locals[output].ty;
            let to_type = self.type_of(to)?;
            let place = self.address(to)?;
            let address = self.temporary(|_, name| format!("void *{name}"));
            self.line(&format!("{address} = {place};"));
            let value = self.temporary(|printer, name| printer.declared(ty, name));
            let array = matches!(ty, Type::Array { .. });
            passed.push(if array { value.clone() } else { format!("&{value}") });
            behind.push((output, to_type, address, ty.clone(), value));
        }
        self.line(&format!("{}({});", self.functions[call.function], passed.join(", ")));
        behind.sort_by_key(|(output, ..)| call.outputs.iter().position(|(local, _)| local == output));
        for (_, to_type, address, ty, value) in behind {
            self.copy(&to_type, &address, &ty, &format!("&{value}"));
        }
        Ok(())
    }

    /// A variable by reference, and the bounds of an open array.
    fn reference(&mut self, place: &Place, ty: &Type, passed: &mut Vec<String>) -> Result<(), String> {
        let found = self.type_of(place)?;
        let text = self.place(place)?;
        match (ty, found) {
            (Type::Open { .. }, Type::Array { bounds, .. }) => {
                let bounds: Vec<String> =
                    bounds.iter().flat_map(|(low, high)| [low.to_string(), high.to_string()]).collect();
                let name =
                    self.temporary(|_, name| format!("static const int32_t {name}[] = {{{}}}", bounds.join(", ")));
                passed.push(text);
                passed.push(name);
            }
            (Type::Open { .. }, _) => {
                passed.push(text.clone());
                passed.push(format!("{text}_bounds"));
            }
            (Type::Array { .. }, _) => passed.push(text),
            _ => passed.push(format!("&{text}")),
        }
        Ok(())
    }
}

/// An expression without the parentheses around it.
fn bare(expr: &str) -> &str {
    let Some(inner) = expr.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) else { return expr };
    let mut depth = 0_i32;
    let is_whole = inner.chars().all(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth >= 0
    });
    if is_whole { inner } else { expr }
}

/// Whether a value lies within a range.
fn inside(value: &str, (low, high): (i64, i64)) -> String {
    if low == high { format!("{value} == {low}") } else { format!("({value} >= {low} && {value} <= {high})") }
}
