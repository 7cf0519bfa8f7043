//! Compiles statements.

use super::place::Location;
use super::{Compiler, Home, Scope, wrong_type};
use crate::ir::walk::call_runs_statements;
use crate::ir::{Argument, At, Base, Body, Call, Expr, For, Place, Scalar, Statement, Type, What};
use crate::machine::code::{Op, Register, Target};

impl Compiler<'_> {
    pub(super) fn statements(&mut self, scope: &mut Scope, list: &[Statement]) -> Result<(), String> {
        let line = scope.at;
        for statement in list.iter().filter(|statement| !matches!(statement.what, What::Comment(_))) {
            if statement.at != At::NOTE {
                scope.at = statement.at;
                self.mark(scope);
            }
            let begin = scope.next;
            self.statement(scope, &statement.what)?;
            scope.next = begin;
        }
        scope.at = line;
        Ok(())
    }

    /// Adds a statement at the current line to the current run, or starts a run with it.
    fn mark(&mut self, scope: &mut Scope) {
        let number = self.code.statements.len() as u32;
        self.code.statements.push(scope.at);
        let (run, op) = match scope.run {
            Some(run) => run,
            None => {
                let run = (self.code.runs.len() as u32, self.code.ops.len());
                self.code.runs.push((number, 0));
                self.emit(scope, Op::Mark { run: run.0, count: 0 });
                scope.run = Some(run);
                run
            }
        };
        self.code.runs[run as usize].1 += 1;
        self.code.ops[op] = Op::Mark { run, count: self.code.runs[run as usize].1 };
    }

    fn statement(&mut self, scope: &mut Scope, what: &What) -> Result<(), String> {
        match what {
            What::Assign(to, value) => self.assign(scope, to, value),
            What::Copy(to, from) => {
                writable(to)?;
                let (from, from_type) = self.address(scope, from)?;
                let (to, to_type) = self.address(scope, to)?;
                self.copy(scope, (to, &to_type), (from, &from_type))
            }
            What::Call(call) => self.call(scope, call),
            What::If(condition, then, otherwise) => self.branch(scope, condition, then, otherwise),
            What::Case(selector, arms, otherwise) => {
                let value = self.integer(scope, selector)?;
                let end = scope.label();
                let labels: Vec<usize> = arms.iter().map(|_| scope.label()).collect();
                for (arm, label) in arms.iter().zip(&labels) {
                    for range in &arm.values {
                        self.code.ranges.push(*range);
                        let range = (self.code.ranges.len() - 1) as u32;
                        self.emit(scope, Op::JumpInside { value, range, to: *label as Target });
                    }
                }
                self.block(scope, otherwise)?;
                for (arm, label) in arms.iter().zip(labels) {
                    self.emit(scope, Op::Jump { to: end as Target });
                    self.here(scope, label);
                    self.block(scope, &arm.body)?;
                }
                self.here(scope, end);
                Ok(())
            }
            What::While(condition, body) => {
                let (again, next, end) = (scope.label(), scope.label(), scope.label());
                self.here(scope, again);
                self.unless(scope, condition, end)?;
                self.looped(scope, body, (end, next))?;
                // Every jump back uses the instruction that checks the budget.
                self.here(scope, next);
                self.emit(scope, Op::Back { to: again as Target });
                self.here(scope, end);
                Ok(())
            }
            What::Repeat(body, condition) => {
                let (again, test, end) = (scope.label(), scope.label(), scope.label());
                self.here(scope, again);
                self.looped(scope, body, (end, test))?;
                self.here(scope, test);
                let condition = self.typed(scope, condition, Scalar::Bool, None)?;
                scope.run = None;
                self.emit(scope, Op::JumpIf { condition, to: end as Target });
                self.emit(scope, Op::Back { to: again as Target });
                self.here(scope, end);
                Ok(())
            }
            What::For(it) => self.count(scope, it),
            What::Break | What::Continue => {
                let (end, next) = *scope.loops.last().ok_or("EXIT or CONTINUE is outside a loop")?;
                let to = if *what == What::Break { end } else { next };
                self.emit(scope, Op::Jump { to: to as Target });
                scope.run = None;
                Ok(())
            }
            What::Return => {
                self.emit(scope, Op::Return);
                scope.run = None;
                Ok(())
            }
            What::Label(label) => {
                if scope.labels[*label].is_some() {
                    return Err("a label is defined twice".to_string());
                }
                self.here(scope, *label);
                Ok(())
            }
            What::Comment(_) => Ok(()),
            What::Goto(label) => {
                self.emit(scope, Op::Back { to: *label as Target });
                scope.run = None;
                Ok(())
            }
        }
    }

    fn assign(&mut self, scope: &mut Scope, to: &Place, value: &Expr) -> Result<(), String> {
        writable(to)?;
        let ty = value.ty();
        // A variable in a register receives the result directly.
        let into = match (to.base, to.steps.is_empty()) {
            (Base::Local(local), true) => match scope.homes.get(local) {
                Some(Home::Register(register)) => Some(*register),
                _ => None,
            },
            _ => None,
        };
        let from = self.typed(scope, value, ty, into)?;
        let (location, found) = self.place(scope, to)?;
        if found != Type::Scalar(ty) {
            return Err(wrong_type(ty, "a variable of a different type"));
        }
        self.store(scope, location, ty, from);
        Ok(())
    }

    fn branch(
        &mut self,
        scope: &mut Scope,
        condition: &Expr,
        then: &[Statement],
        otherwise: &[Statement],
    ) -> Result<(), String> {
        let (no, end) = (scope.label(), scope.label());
        self.unless(scope, condition, no)?;
        self.block(scope, then)?;
        if !otherwise.is_empty() {
            self.emit(scope, Op::Jump { to: end as Target });
        }
        self.here(scope, no);
        self.block(scope, otherwise)?;
        self.here(scope, end);
        Ok(())
    }

    fn count(&mut self, scope: &mut Scope, it: &For) -> Result<(), String> {
        let ty = it.first.ty();
        if !ty.is_integer() {
            return Err(wrong_type("an integer", ty));
        }
        self.assign(scope, &it.variable, &it.first)?;
        let (last, step) = (scope.take()?, scope.take()?);
        self.typed(scope, &it.last, ty, Some(last))?;
        self.typed(scope, &it.step, ty, Some(step))?;
        let (again, next, end) = (scope.label(), scope.label(), scope.label());
        let (value, beyond) = (scope.take()?, scope.take()?);
        let load = Expr::Load(ty, it.variable.clone());
        self.here(scope, again);
        self.typed(scope, &load, ty, Some(value))?;
        self.emit(scope, Op::ForTest { ty, value, last, to: end as Target });
        self.looped(scope, &it.body, (end, next))?;
        self.here(scope, next);
        self.typed(scope, &load, ty, Some(value))?;
        self.emit(scope, Op::ForStep { ty, value, step });
        let (variable, _) = self.place(scope, &it.variable)?;
        self.store(scope, variable, ty, value);
        self.emit(scope, Op::JumpIf { condition: beyond, to: end as Target });
        self.emit(scope, Op::Back { to: again as Target });
        self.here(scope, end);
        Ok(())
    }

    /// Compiles a call: the arguments are evaluated, the places of the outputs are resolved, the function is called,
    /// and its outputs are copied, in this order.
    fn call(&mut self, scope: &mut Scope, call: &Call) -> Result<(), String> {
        let callee = &self.program.functions[call.function];
        let (instance, homes) = self.homes[call.function].clone();
        let address = match (&call.instance, callee.instance) {
            (None, None) => None,
            (Some(place), Some(record)) => match self.address(scope, place)? {
                (address, Type::Record(found)) if found == record => Some(address),
                _ => return Err(format!("an instance of {} has the wrong type", callee.name)),
            },
            _ => return Err(format!("{} is called without its instance or with a wrong one", callee.name)),
        };
        if let (Body::Native(name), Some(instance)) = (&callee.body, address) {
            let (law, size) = self.native(name)?;
            let record = callee.instance.unwrap_or_default();
            if self.program.records[record].start.len() != size || !callee.locals.is_empty() {
                return Err(format!("the instance of {name} has the wrong size"));
            }
            self.emit(scope, Op::Native { law, instance });
            return Ok(());
        }
        if call.arguments.len() != callee.parameters {
            return Err(format!("the number of arguments of {} must be {}", callee.name, callee.parameters));
        }
        // If an argument, or an index in a variable or output, calls a function, all arguments are evaluated before the
        // first parameter is written: that function may be the same one, or use the same registers.
        let apart = call_runs_statements(call);
        let mut passed = Vec::new();
        for ((argument, local), home) in call.arguments.iter().zip(&callee.locals).zip(&homes) {
            match (argument, home, &local.ty) {
                (Argument::Value(value), Home::Register(to), Type::Scalar(ty)) => {
                    let into = if apart { scope.take()? } else { *to };
                    self.typed(scope, value, *ty, Some(into))?;
                    passed.push((into, None));
                }
                (Argument::Copy(place), Home::Memory(_), _) | (Argument::Reference(place), Home::Reference(_), _) => {
                    if matches!(argument, Argument::Reference(_)) {
                        writable(place)?;
                    }
                    let (address, ty) = self.address(scope, place)?;
                    passed.push((address, Some((place, ty))));
                }
                (Argument::Start, Home::Register(_) | Home::Memory(_), _) => passed.push((0, None)),
                _ => return Err(format!("parameter {} of {} cannot be passed like this", local.name, callee.name)),
            }
        }
        let mut outputs = Vec::new();
        for (local, to) in &call.outputs {
            writable(to)?;
            let local =
                callee.locals.get(*local).zip(homes.get(*local)).ok_or("a call uses an output that does not exist")?;
            outputs.push((local, self.place(scope, to)?));
        }

        for (((argument, local), home), (from, variable)) in
            call.arguments.iter().zip(&callee.locals).zip(&homes).zip(&passed)
        {
            match (argument, home, variable) {
                (Argument::Start, Home::Register(to), _) => self.emit(scope, Op::Const { to: *to, bits: 0 }),
                (Argument::Start, Home::Memory(to), _) => self.start_values(scope, *to, &local.ty),
                (_, Home::Memory(to), Some((_, ty))) => {
                    if matches!(local.ty, Type::Text { .. }) {
                        // No bytes beyond the string may remain from an earlier call.
                        self.start_values(scope, *to, &local.ty);
                    }
                    let to = self.address_of(scope, (0, *to))?;
                    self.copy(scope, (to, &local.ty), (*from, ty))?;
                }
                (_, Home::Reference(to), Some((place, ty))) => {
                    self.reference(scope, (*to, &local.ty), (*from, ty), place)?;
                }
                (_, Home::Register(to), _) if to != from => self.emit(scope, Op::Move { to: *to, from: *from }),
                _ => {}
            }
        }
        if let Some(address) = address {
            self.emit(scope, Op::Move { to: instance, from: address });
        }
        let entry = self.code.entries[call.function];
        self.emit(scope, Op::Call { to: entry });
        for ((local, home), (to, ty)) in outputs {
            match (home, to, &ty) {
                (Home::Register(from), to, Type::Scalar(ty)) if local.ty == Type::Scalar(*ty) => {
                    self.store(scope, to, *ty, *from);
                }
                (Home::Memory(from), Location::Memory { base, offset }, ty) => {
                    let to = self.address_of(scope, (base, offset))?;
                    let from = self.address_of(scope, (0, *from))?;
                    self.copy(scope, (to, ty), (from, &local.ty))?;
                }
                _ => return Err(format!("parameter {} of {} cannot be passed like this", local.name, callee.name)),
            }
        }
        Ok(())
    }

    /// Passes a variable by reference, with its bounds if the parameter is an open array.
    fn reference(
        &mut self,
        scope: &mut Scope,
        (to, expected): (Register, &Type),
        (from, found): (Register, &Type),
        place: &Place,
    ) -> Result<(), String> {
        match (expected, found) {
            (Type::Open { of, dimensions }, Type::Array { of: element, bounds })
                if self.program.size(of) == self.program.size(element) && *dimensions == bounds.len() =>
            {
                for (number, bound) in bounds.iter().flat_map(|(low, high)| [low, high]).enumerate() {
                    let to = to + 1 + number as Register;
                    self.emit(scope, Op::Const { to, bits: i64::from(*bound) as u64 });
                }
            }
            (Type::Open { of, dimensions }, Type::Open { of: element, dimensions: same })
                if self.program.size(of) == self.program.size(element) && dimensions == same =>
            {
                let Base::Local(local) = place.base else { return Err("open arrays are parameters".to_string()) };
                let Home::Reference(home) = scope.homes[local] else { return Err("it is not a reference".to_string()) };
                for number in 1..=2 * *dimensions as Register {
                    self.emit(scope, Op::Move { to: to + number, from: home + number });
                }
            }
            (Type::Open { .. }, _) | (_, Type::Open { .. }) => {
                return Err("an array does not match its open array in element type or dimensions".to_string());
            }
            _ if self.program.size(expected) == self.program.size(found) => {}
            _ => return Err("a variable passed by reference has the wrong size".to_string()),
        }
        self.emit(scope, Op::Move { to, from });
        Ok(())
    }

    /// Emits a jump to a label that is taken if a condition is FALSE.
    fn unless(&mut self, scope: &mut Scope, condition: &Expr, to: usize) -> Result<(), String> {
        let condition = self.typed(scope, condition, Scalar::Bool, None)?;
        scope.run = None;
        self.emit(scope, Op::JumpUnless { condition, to: to as Target });
        Ok(())
    }

    /// Compiles statements in runs of their own.
    fn block(&mut self, scope: &mut Scope, list: &[Statement]) -> Result<(), String> {
        scope.run = None;
        self.statements(scope, list)?;
        scope.run = None;
        Ok(())
    }

    /// Compiles the body of a loop, with the labels for `Break` and `Continue`.
    fn looped(&mut self, scope: &mut Scope, body: &[Statement], labels: (usize, usize)) -> Result<(), String> {
        scope.loops.push(labels);
        let done = self.block(scope, body);
        scope.loops.pop();
        done
    }

    /// Places a label at the next instruction and ends the current run.
    fn here(&mut self, scope: &mut Scope, label: usize) {
        scope.labels[label] = Some(self.code.ops.len() as Target);
        scope.run = None;
    }
}

impl Scope<'_> {
    /// Creates a label that has not been placed yet.
    fn label(&mut self) -> usize {
        self.labels.push(None);
        self.labels.len() - 1
    }
}

/// Rejects writes to a constant.
fn writable(place: &Place) -> Result<(), String> {
    if place.base == Base::Constants { Err("a constant cannot be written".to_string()) } else { Ok(()) }
}
