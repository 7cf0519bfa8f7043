//! Prints statements.

use super::expr::{Effect, bare, constant};
use super::facts::{self, Uses};
use super::{PrintedLocal, Printer, Run, WIDTH, comment, line, scalar};
use crate::ir::{Argument, Call, Expr, For, Place, Scalar, Statement, Type, Value, What};

impl Printer<'_> {
    /// Prints the statements of a function's body.
    pub(super) fn body(&mut self, list: &[Statement]) -> Result<(), String> {
        self.list(list, true)
    }

    pub(super) fn statements(&mut self, list: &[Statement]) -> Result<(), String> {
        self.list(list, false)
    }

    /// Prints statements; `last` means that the function ends after them.
    fn list(&mut self, list: &[Statement], last: bool) -> Result<(), String> {
        let at = self.scope.at;
        let mut skip = false;
        for (number, statement) in list.iter().enumerate() {
            if std::mem::take(&mut skip) {
                continue;
            }
            let rest = &list[number + 1..];
            let is_last = last && rest.iter().all(|it| matches!(it.what, What::Comment(_)));
            if let What::Comment(text) = &statement.what {
                let text = comment(text, 4 * self.scope.indent);
                self.text.push_str(&text);
                self.text.push('\n');
                continue;
            }
            self.scope.at = statement.at;
            self.mark();
            self.declare(statement, rest);
            if let (What::Assign(to, value), Some(direct)) = (&statement.what, self.scope.direct)
                && facts::local(to) == Some(direct)
            {
                let value = self.whole(value)?;
                self.line(&format!("return {value};"));
                skip = matches!(rest.first(), Some(Statement { what: What::Return, .. }));
                continue;
            }
            self.statement(&statement.what, is_last)?;
        }
        self.scope.at = at;
        Ok(())
    }

    /// Deducts a statement from the budget, if statements are counted, as the machine does.
    fn mark(&mut self) {
        if !self.scope.counts {
            return;
        }
        if !std::mem::replace(&mut self.scope.is_run, true) {
            let call = self.argument("call");
            self.line(&format!("{call}->budget -= ;"));
            self.scope.runs.push(Run { at: self.text.len() - ";\n".len(), count: 0 });
        }
        if let Some(run) = self.scope.runs.last_mut() {
            run.count += 1;
        }
    }

    /// Declares the pending locals that this statement uses, except those used only in one branch of it and nowhere
    /// after it.
    fn declare(&mut self, statement: &Statement, rest: &[Statement]) {
        if !self.scope.locals.iter().any(|local| local.is_pending) {
            return;
        }
        let one = std::slice::from_ref(statement);
        let here: Vec<usize> = named(one).into_iter().filter(|it| self.scope.locals[*it].is_pending).collect();
        let Some(function) = self.scope.function else { return };
        for local in here {
            let is_used_behind = named(rest).contains(&local);
            let in_parts = match &statement.what {
                What::If(condition, then, otherwise) => {
                    let head = What::If(condition.clone(), Vec::new(), Vec::new());
                    let uses = |list: &[Statement]| named(list).contains(&local);
                    if uses(&[Statement { at: statement.at, what: head }]) {
                        2
                    } else {
                        usize::from(uses(then)) + usize::from(uses(otherwise))
                    }
                }
                _ => 2,
            };
            // A local used only in one branch is declared there.
            if !is_used_behind && in_parts == 1 {
                continue;
            }
            self.scope.locals[local].is_pending = false;
            let Type::Scalar(ty) = function.locals[local].ty else { continue };
            let PrintedLocal { name, is_read, .. } = &self.scope.locals[local];
            let (name, is_read) = (name.clone(), *is_read);
            match &statement.what {
                What::Assign(to, value) if facts::local(to) == Some(local) && !reads(value, local, &self.facts) => {
                    self.scope.declared = Some(local);
                }
                _ => {
                    let start = if assigns(one, local, &self.facts) {
                        String::new()
                    } else {
                        format!(" = {}", constant(Value::new(ty, 0)))
                    };
                    self.line(&format!("{} {name}{start};", scalar(ty)));
                    if !is_read {
                        self.line(&format!("(void){name};"));
                    }
                }
            }
        }
    }

    fn block(&mut self, list: &[Statement], last: bool) -> Result<(), String> {
        self.scope.indent += 1;
        self.scope.is_run = false;
        let done = self.list(list, last);
        self.scope.is_run = false;
        self.scope.indent -= 1;
        done
    }

    fn statement(&mut self, what: &What, last: bool) -> Result<(), String> {
        match what {
            What::Assign(to, value) => {
                let declared = self.scope.declared.take();
                let mut text = self.whole(value)?;
                if self.comes_before(value, self.of_place(to)) {
                    text = self.kept(value.ty(), &text);
                }
                let name = self.place(to)?;
                match declared {
                    Some(_) => self.assigned(&format!("{} {name}", scalar(value.ty())), &text),
                    None => self.assigned(&name, &text),
                }
                if declared.is_some_and(|local| !self.scope.locals[local].is_read) {
                    self.line(&format!("(void){name};"));
                }
            }
            What::Copy(to, from) => {
                let (to_type, from_type) = (self.type_of(to)?, self.type_of(from)?);
                let (from, to) = self.addresses(from, to)?;
                self.copy(&to_type, &to, &from_type, &from);
            }
            What::Call(call) => self.call(call)?,
            What::If(..) => self.branch(what, "if", last)?,
            What::Case(selector, arms, otherwise) => {
                let value = self.expr(selector)?;
                let value = self.kept(Scalar::I64, &format!("(i64_t){value}"));
                if arms.is_empty() {
                    self.line(&format!("(void){value};"));
                }
                let mut word = "if";
                for arm in arms {
                    let inside: Vec<String> = arm.values.iter().map(|range| inside(&value, *range)).collect();
                    let inside = if inside.is_empty() { "0".to_string() } else { inside.join(" || ") };
                    self.line(&format!("{word} ({inside}) {{"));
                    self.block(&arm.body, false)?;
                    word = "} else if";
                }
                self.line(if arms.is_empty() { "{" } else { "} else {" });
                self.block(otherwise, false)?;
                self.line("}");
            }
            What::While(condition, body) => {
                self.line("for (;;) {");
                self.scope.indent += 1;
                self.scope.is_run = false;
                let condition = self.expr(condition)?;
                self.line(&format!("if (!{condition}) {{"));
                self.line("    break;");
                self.line("}");
                self.scope.indent -= 1;
                self.looped(body)?;
                self.again("}");
            }
            What::Repeat(body, condition) => {
                self.line("for (;;) {");
                self.looped(body)?;
                self.scope.indent += 1;
                let condition = self.expr(condition)?;
                self.line(&format!("if ({}) {{", bare(&condition)));
                self.line("    break;");
                self.line("}");
                self.scope.indent -= 1;
                self.again("}");
            }
            What::For(it) => self.count(it)?,
            What::Comment(_) => {}
            What::Break => {
                self.line("break;");
                self.scope.is_run = false;
            }
            What::Continue => {
                let (label, used) = self.scope.loops.last_mut().ok_or("EXIT or CONTINUE is outside a loop")?;
                *used = true;
                let label = format!("goto next_{label};");
                self.line(&label);
                self.scope.is_run = false;
            }
            What::Return => {
                self.leave(0);
                self.scope.is_run = false;
            }
            What::Label(label) => {
                self.line(&format!("label_{label}:;"));
                self.scope.is_run = false;
            }
            What::Goto(label) => self.again(&format!("goto label_{label};")),
        }
        Ok(())
    }

    /// Prints an assignment, on two lines if it is too long for one.
    fn assigned(&mut self, to: &str, value: &str) {
        if 4 * self.scope.indent + to.len() + value.len() + 4 <= WIDTH {
            return self.line(&format!("{to} = {value};"));
        }
        self.line(&format!("{to} ="));
        self.line(&format!("    {value};"));
    }

    /// Prints `if`, then `else if` for each additional condition that needs no statements or declarations before it.
    fn branch(&mut self, what: &What, word: &str, last: bool) -> Result<(), String> {
        let What::If(condition, then, otherwise) = what else { return Ok(()) };
        let condition = self.expr(condition)?;
        self.line(&format!("{word} ({}) {{", bare(&condition)));
        self.block(then, last)?;
        match &otherwise[..] {
            [] => self.line("}"),
            [Statement { what: next @ What::If(next_condition, ..), .. }]
                if !self.scope.counts && facts::is_quiet(next_condition, &self.facts) && !self.declares(otherwise) =>
            {
                self.branch(next, "} else if", last)?;
            }
            _ => {
                self.line("} else {");
                self.block(otherwise, last)?;
                self.line("}");
            }
        }
        Ok(())
    }

    /// Whether these statements of an ELSE cannot be printed as `else if`: they are not a single IF, or locals must be
    /// declared before it.
    fn declares(&self, list: &[Statement]) -> bool {
        let [Statement { what: What::If(condition, then, otherwise), at }] = list else { return true };
        let head = [Statement { at: *at, what: What::If(condition.clone(), Vec::new(), Vec::new()) }];
        let uses = |list: &[Statement]| -> Vec<usize> {
            named(list).into_iter().filter(|it| self.scope.locals[*it].is_pending).collect()
        };
        let (then, otherwise) = (uses(then), uses(otherwise));
        !uses(&head).is_empty() || then.iter().any(|local| otherwise.contains(local))
    }

    /// Prints the statement that leaves the function, indented by `deeper` more levels.
    fn leave(&mut self, deeper: usize) {
        let facts = &self.facts[self.scope.number];
        let text = match facts.returns {
            _ if !facts.outs.is_empty() => {
                self.scope.leaves = true;
                "goto done;".to_string()
            }
            Some(result) if self.scope.direct.is_none() => format!("return {};", self.local(result)),
            _ => "return;".to_string(),
        };
        self.line(&format!("{:width$}{text}", "", width = 4 * deeper));
    }

    /// Prints the body of a loop, and the label at its end.
    fn looped(&mut self, body: &[Statement]) -> Result<(), String> {
        self.scope.labels += 1;
        self.scope.loops.push((self.scope.labels, false));
        let done = self.block(body, false);
        if let Some((label, true)) = self.scope.loops.pop() {
            self.line(&format!("next_{label}:;"));
        }
        done
    }

    /// Prints a check of the budget, then `text`: the `}` that ends a loop's body, or a `goto`.
    fn again(&mut self, text: &str) {
        let line = line(self.scope.at);
        let (deeper, call) = (if text == "}" { "    " } else { "" }, self.argument("call"));
        self.line(&format!("{deeper}if (!goes_on({call}, {line})) {{"));
        self.leave(1 + deeper.len() / 4);
        self.line(&format!("{deeper}}}"));
        self.line(text);
        self.scope.is_run = false;
    }

    fn count(&mut self, it: &For) -> Result<(), String> {
        let ty = it.first.ty();
        let mut first = self.expr(&it.first)?;
        if self.comes_before(&it.first, self.of_place(&it.variable)) {
            first = self.kept(ty, &first);
        }
        let variable = self.place(&it.variable)?;
        self.line(&format!("{variable} = {};", bare(&first)));
        let last = self.expr(&it.last)?;
        let last = self.kept(ty, &last);
        let step = self.expr(&it.step)?;
        let step = self.kept(ty, &step);
        let next = self.temporary(|_, name| format!("{} {name}", scalar(ty)));
        self.line("for (;;) {");
        self.scope.indent += 1;
        self.scope.is_run = false;
        if !matches!(it.step, Expr::Const(value) if value.bits() != 0) {
            let (call, line) = (self.argument("call"), line(self.scope.at));
            self.line(&format!("if ({step} == 0) {{"));
            self.line(&format!("    stop({call}, STEP_OF_0, {line});"));
            self.leave(1);
            self.line("}");
        }
        let passed = match ty.is_signed() {
            true => format!("{step} < 0 ? {variable} < {last} : {variable} > {last}"),
            false => format!("{variable} > {last}"),
        };
        self.line(&format!("if ({passed}) {{"));
        self.line("    break;");
        self.line("}");
        self.scope.indent -= 1;
        self.looped(&it.body)?;
        self.scope.indent += 1;
        self.line(&format!("{next} = {variable};"));
        let beyond = self.kept(Scalar::I32, &format!("step_{ty}(&{next}, {step})"));
        self.line(&format!("{variable} = {next};"));
        self.line(&format!("if ({beyond}) {{"));
        self.line("    break;");
        self.line("}");
        self.scope.indent -= 1;
        self.again("}");
        Ok(())
    }

    /// Prints a statement that copies a variable from one address to another.
    fn copy(&mut self, to_type: &Type, to: &str, from_type: &Type, from: &str) {
        let text = match (to_type, from_type) {
            (Type::Text { capacity: p, wide }, Type::Text { capacity: q, .. }) => {
                format!("copy_text({to}, {p}u, {from}, {q}u, {});", 1 + u8::from(*wide))
            }
            _ => format!("memmove({to}, {from}, {});", self.program.size(to_type)),
        };
        self.line(&text);
    }

    /// The call to a function as C text, without its outputs.
    pub(super) fn called(&mut self, call: &Call) -> Result<String, String> {
        let passed = self.passed(call, &[])?;
        Ok(format!("{}({})", self.function_names[call.function], passed.join(", ")))
    }

    /// The arguments of a call as C text, preceded by the addresses of the outputs in `chosen`. The instance is
    /// evaluated first, then the arguments in order, then the addresses; arguments are copied after that.
    fn passed(&mut self, call: &Call, chosen: &[&Place]) -> Result<Vec<String>, String> {
        let callee = &self.program.functions[call.function];
        let mut passed = Vec::new();
        if self.facts[call.function].needs_call {
            passed.push(self.argument("call"));
        }
        if self.facts[call.function].needs_memory {
            passed.push(self.argument("memory"));
        }
        // The budget is checked after all arguments are evaluated.
        let at_end = Effect { runs: false, stops: self.scope.counts };
        let outputs = chosen.iter().fold(at_end, |effect, place| effect.and(self.of_place(place)));
        let behind = |printer: &Self, rest: &[Argument]| {
            rest.iter().fold(outputs, |effect, argument| {
                effect.and(match argument {
                    Argument::Value(value) => printer.of_expr(value),
                    Argument::Copy(place) | Argument::Reference(place) => printer.of_place(place),
                    Argument::Start => Effect::default(),
                })
            })
        };
        if let (Some(instance), Some(record)) = (&call.instance, callee.instance) {
            let mut address = self.address(instance)?;
            if self.is_found_before(instance, behind(self, &call.arguments)) {
                address = self.held(&format!("{}_t *", self.records[record]), &address);
            }
            passed.push(address);
        }
        let mut copies = Vec::new();
        for (number, (argument, local)) in call.arguments.iter().zip(&callee.locals).enumerate() {
            let later = behind(self, &call.arguments[number + 1..]);
            match (argument, &local.ty) {
                (Argument::Value(value), ty) => {
                    let mut text = self.expr(value)?;
                    if self.comes_before(value, later)
                        && let Type::Scalar(ty) = ty
                    {
                        text = self.kept(*ty, &text);
                    }
                    passed.push(bare(&text).to_string());
                }
                (Argument::Start, Type::Scalar(ty)) => passed.push(constant(Value::new(*ty, 0))),
                (Argument::Start, _) => passed.push("NULL".to_string()),
                (Argument::Copy(place), ty) => {
                    let mut from = self.address(place)?;
                    if self.is_found_before(place, later) {
                        from = self.held("const void *", &from);
                    }
                    let copy = self.temporary(|printer, name| printer.declared(ty, name));
                    let array = matches!(ty, Type::Array { .. });
                    passed.push(if array { copy.clone() } else { format!("&{copy}") });
                    copies.push((ty, copy, self.type_of(place)?, from));
                }
                (Argument::Reference(place), ty) => self.reference(place, ty, later, &mut passed)?,
            }
        }
        // The places to which the outputs are copied are resolved after the arguments.
        let chosen = chosen.iter().map(|place| self.chosen(place)).collect::<Result<Vec<_>, _>>()?;
        for (ty, copy, from_type, from) in copies {
            if matches!(ty, Type::Text { .. }) {
                self.line(&format!("memset(&{copy}, 0, sizeof {copy});"));
            }
            self.copy(ty, &format!("&{copy}"), &from_type, &from);
        }
        passed.splice(0..0, chosen);
        Ok(passed)
    }

    fn call(&mut self, call: &Call) -> Result<(), String> {
        let callee = &self.program.functions[call.function];
        let facts = self.facts[call.function].clone();
        // The value that a C function returns is assigned directly unless its place has a checked index. Any other
        // number is assigned directly if it goes to a local to which no other output goes. The remaining places, and
        // those of a different type, are resolved before the call.
        let is_direct = |printer: &Self, output: usize, to: &Place| -> Result<bool, String> {
            let ty = &callee.locals[output].ty;
            if printer.type_of(to)? != *ty {
                return Ok(false);
            }
            if facts.returns.is_some() {
                return Ok(!printer.is_checked(to));
            }
            // If two outputs go to the same local, the order of copying matters.
            let shared = call.outputs.iter().filter(|(_, other)| facts::local(other) == facts::local(to)).count() > 1;
            let is_own = !shared && facts::local(to).is_some_and(|_| to.steps.is_empty());
            Ok(is_own && matches!(ty, Type::Scalar(_)) && !printer.is_reference(to))
        };
        let mut chosen = Vec::new();
        for (output, to) in &call.outputs {
            if !is_direct(self, *output, to)? {
                chosen.push((*output, to));
            }
        }
        let places: Vec<&Place> = chosen.iter().map(|(_, place)| *place).collect();
        let mut addresses = self.passed(call, &places)?;
        let mut passed = addresses.split_off(places.len());
        let counts = self.scope.counts && !self.program.docs.natives.contains(&call.function);
        if counts {
            let (call, line) = (self.argument("call"), line(self.scope.at));
            self.line(&format!("if (!goes_in({call}, {line})) {{"));
            self.leave(1);
            self.line("}");
        }
        let name = self.function_names[call.function].clone();
        if let Some(result) = facts.returns {
            let called = format!("{name}({})", passed.join(", "));
            let Some((_, to)) = call.outputs.iter().find(|(local, _)| *local == result) else {
                self.line(&format!("(void){called};"));
                return Ok(());
            };
            let Some(address) = addresses.pop() else {
                let to = self.place(to)?;
                self.assigned(&to, &called);
                return Ok(());
            };
            let (to_type, ty) = (self.type_of(to)?, &callee.locals[result].ty);
            let value = self.temporary(|printer, name| printer.declared(ty, name));
            self.line(&format!("{value} = {called};"));
            self.copy(&to_type, &address, ty, &format!("&{value}"));
            return Ok(());
        }
        // The callee copies each of these outputs to a temporary; from there, it is copied to its place after the call.
        let mut values: Vec<String> = Vec::new();
        for (output, _) in &chosen {
            values.push(self.temporary(|printer, name| printer.declared(&callee.locals[*output].ty, name)));
        }
        for output in facts.outs {
            let given = call.outputs.iter().find(|(local, _)| *local == output);
            let value = chosen.iter().zip(&values).find(|((local, _), _)| *local == output);
            passed.push(match (given, value) {
                (_, Some((_, value))) if matches!(callee.locals[output].ty, Type::Array { .. }) => value.clone(),
                (_, Some((_, value))) => format!("&{value}"),
                (Some((_, to)), None) => self.address(to)?,
                (None, None) => "NULL".to_string(),
            });
        }
        self.line(&format!("{name}({});", passed.join(", ")));
        for (((output, to), address), value) in chosen.into_iter().zip(addresses).zip(values) {
            let to_type = self.type_of(to)?;
            self.copy(&to_type, &address, &callee.locals[output].ty, &format!("&{value}"));
        }
        Ok(())
    }

    fn is_reference(&self, place: &Place) -> bool {
        let function = self.scope.function;
        facts::local(place).zip(function).is_some_and(|(local, function)| function.locals[local].by_reference)
    }

    /// Stores the address of a place in a new temporary and returns the temporary's name.
    fn chosen(&mut self, place: &Place) -> Result<String, String> {
        let place = self.address(place)?;
        Ok(self.held("void *", &place))
    }

    /// Passes a variable by reference, with its bounds if the parameter is an open array.
    fn reference(&mut self, place: &Place, ty: &Type, later: Effect, passed: &mut Vec<String>) -> Result<(), String> {
        let found = self.type_of(place)?;
        let is_array = matches!(found, Type::Array { .. } | Type::Open { .. });
        let mut text = if is_array { self.place(place)? } else { self.address(place)? };
        if self.is_found_before(place, later) {
            let pointer = self.pointer(&found, "");
            text = self.held(&pointer, &text);
        }
        passed.push(text.clone());
        match (ty, found) {
            (Type::Open { .. }, Type::Array { bounds, .. }) => {
                let bounds: Vec<String> =
                    bounds.iter().flat_map(|(low, high)| [low.to_string(), high.to_string()]).collect();
                passed
                    .push(self.temporary(|_, name| format!("static const i32_t {name}[] = {{{}}}", bounds.join(", "))));
            }
            (Type::Open { .. }, _) => passed.push(format!("{text}_bounds")),
            _ => {}
        }
        Ok(())
    }
}

/// The C condition that a value lies within a range.
fn inside(value: &str, (low, high): (i64, i64)) -> String {
    if low == high { format!("{value} == {low}") } else { format!("({value} >= {low} && {value} <= {high})") }
}

/// Whether every path through a function's body ends with an assignment to this local, and the local has no other use.
pub(super) fn is_direct(body: &[Statement], result: usize) -> bool {
    fn ends(list: &[Statement], result: usize, last: bool) -> Option<bool> {
        // Whether the end of the list is unreachable; `None` if the local is used in any other way.
        for (number, statement) in list.iter().enumerate() {
            let rest = &list[number + 1..];
            let is_nothing = |rest: &[Statement]| rest.iter().all(|it| matches!(it.what, What::Comment(_)));
            let is_last = last && is_nothing(rest);
            match &statement.what {
                What::Assign(to, value) if facts::local(to) == Some(result) => {
                    let returns = match rest.first() {
                        // After further statements, the function would end without returning a value.
                        Some(Statement { what: What::Return, .. }) => is_nothing(&rest[1..]),
                        _ => is_last,
                    };
                    if !returns || reads(value, result, &[]) {
                        return None;
                    }
                    return Some(true);
                }
                What::If(condition, then, otherwise) => {
                    if reads(condition, result, &[]) {
                        return None;
                    }
                    let (then, otherwise) = (ends(then, result, is_last)?, ends(otherwise, result, is_last)?);
                    if then && otherwise {
                        return is_nothing(rest).then_some(true);
                    }
                }
                What::Return => return None,
                _ => {
                    let one = std::slice::from_ref(statement);
                    if named(one).contains(&result) || facts::may_leave(one) {
                        return None;
                    }
                }
            }
        }
        Some(false)
    }
    ends(body, result, true) == Some(true)
}

/// The locals named by statements.
fn named(list: &[Statement]) -> Vec<usize> {
    Uses::all(list).locals().collect()
}

/// Whether an expression reads a local.
fn reads(expr: &Expr, local: usize, _: &[facts::Facts]) -> bool {
    let one = [Statement { at: crate::ir::At::default(), what: What::If(expr.clone(), Vec::new(), Vec::new()) }];
    named(&one).contains(&local)
}

/// Whether every path through the statements assigns a local before reading it.
fn assigns(list: &[Statement], local: usize, facts: &[facts::Facts]) -> bool {
    for statement in list {
        match &statement.what {
            What::Assign(to, value) => {
                if reads(value, local, facts) {
                    return false;
                }
                if facts::local(to) == Some(local) && to.steps.is_empty() {
                    return true;
                }
            }
            What::If(condition, then, otherwise) => {
                if reads(condition, local, facts) {
                    return false;
                }
                let ends = |list: &[Statement]| {
                    !named(list).contains(&local) && matches!(list.last(), Some(Statement { what: What::Return, .. }))
                };
                let (first, second) = (assigns(then, local, facts), assigns(otherwise, local, facts));
                if (first || ends(then)) && (second || ends(otherwise)) && (first || second) {
                    return true;
                }
                if named(then).contains(&local) || named(otherwise).contains(&local) {
                    return false;
                }
            }
            What::Return => return false,
            _ if named(std::slice::from_ref(statement)).contains(&local) => return false,
            _ => {}
        }
    }
    false
}
