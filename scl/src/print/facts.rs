//! Decides how each function is expressed in SCL, and rewrites constructs that SCL lacks.

use super::Dialect;
use crate::ir::walk::change::{self, Change};
use crate::ir::walk::{self, Look};
use crate::ir::{Argument, Base, Body, Call, Expr, Function, Place, Program, Section, Statement, Step, Type, What};
use crate::library::is_timer;
use std::collections::{BTreeMap, BTreeSet};

/// How a function is expressed in SCL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// As a function.
    Function,
    /// As a function block.
    Block,
    /// As a function that receives the used parts of the instance as parameters.
    Method,
    /// Not at all: the CPU or its libraries contain it.
    System,
}

/// Facts about the functions to print and their callees.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// The functions to print, callees first.
    pub reached: Vec<usize>,
    pub uses: BTreeMap<usize, Use>,
    /// The function with the body of each function block, by record.
    pub blocks: BTreeMap<usize, usize>,
    /// The type names of records that exist in the CPU or its libraries, by record.
    pub systems: BTreeMap<usize, String>,
    /// The system records shared by several kinds of blocks.
    pub general: BTreeSet<usize>,
    /// The locals that calls copy to the caller, by called function.
    pub outs: BTreeMap<usize, BTreeSet<usize>>,
    /// The local with the return value, by function.
    pub values: BTreeMap<usize, usize>,
    /// The parts of the instance that a method uses, as paths of member indices, and whether it writes them.
    pub members: BTreeMap<usize, BTreeMap<Vec<usize>, bool>>,
}

/// A copy of the program prepared for printing, and the facts about it: values for an FMU's host are no longer
/// assigned, and methods that cannot become functions are inlined.
pub(super) fn prepared(program: &Program, roots: &[usize], dialect: Dialect) -> Result<(Program, Facts), String> {
    let mut program = program.clone();
    drop_host_values(&mut program);
    let order = walk::reached(&program, roots);
    inline(&mut program, &order);
    let facts = facts(&program, roots, dialect)?;
    Ok((program, facts))
}

/// The roots, and the functions called on an instance other than the caller's own.
fn called_from_outside(program: &Program, roots: &[usize], order: &[usize]) -> BTreeSet<usize> {
    let mut found: BTreeSet<usize> = roots.iter().copied().collect();
    for number in order {
        if let Body::Code(body) = &program.functions[*number].body {
            walk::each_call(body, &mut |call| {
                if call.instance.as_ref().is_some_and(|instance| !is_self(instance)) {
                    found.insert(call.function);
                }
            });
        }
    }
    found
}

fn facts(program: &Program, roots: &[usize], dialect: Dialect) -> Result<Facts, String> {
    let mut facts = Facts::default();
    let library = program.files.iter().position(|file| file == crate::library::FILE);
    let order = walk::reached(program, roots);
    let outside = called_from_outside(program, roots, &order);
    for number in &order {
        let function = &program.functions[*number];
        let is_system = match &function.body {
            Body::Native(_) => true,
            Body::Code(body) => body.first().is_some_and(|first| Some(usize::from(first.at.file)) == library),
        };
        let of = match function.instance {
            _ if is_system => Use::System,
            Some(_) if outside.contains(number) => Use::Block,
            Some(_) => Use::Method,
            None => Use::Function,
        };
        facts.uses.insert(*number, of);
        match (of, function.instance) {
            (Use::System, Some(record)) => {
                let name = system_name(function);
                if let Some(other) = facts.systems.insert(record, name.clone())
                    && other != name
                {
                    // A record used by several kinds of timers: variables have the general type, calls name the kind.
                    let of = if name.ends_with("_LTIME") { "IEC_LTIMER" } else { "IEC_TIMER" };
                    let is_timer = is_timer(&function.name);
                    facts.systems.insert(record, if is_timer { of.to_string() } else { other });
                    facts.general.insert(record);
                }
            }
            (Use::System, None) => {
                return Err(format!("{} is a library function that cannot be written in SCL", function.name));
            }
            (Use::Block, Some(record)) => {
                if let Some(other) = facts.blocks.insert(record, *number) {
                    let (one, other) = (&program.functions[other].name, &function.name);
                    return Err(format!(
                        "{one} and {other} are called on the same instance, but a function block has only one body"
                    ));
                }
            }
            _ => {}
        }
    }
    facts.reached = order.iter().copied().filter(|number| facts.uses[number] != Use::System).collect();
    for number in &facts.reached {
        if let Body::Code(body) = &program.functions[*number].body {
            walk::each_call(body, &mut |call| {
                facts.outs.entry(call.function).or_default().extend(call.outputs.iter().map(|(local, _)| *local));
            });
        }
    }
    for number in &facts.reached {
        let function = &program.functions[*number];
        let outs = facts.outs.get(number).into_iter().flatten().filter(|local| **local >= function.parameters);
        let outs: Vec<usize> = outs.copied().collect();
        let is_named = |local: &&usize| function.locals[**local].name.eq_ignore_ascii_case(&function.name);
        let value = outs.iter().find(is_named).or(outs.first().filter(|_| outs.len() == 1));
        if let Some(value) = value.filter(|local| matches!(function.locals[**local].ty, Type::Scalar(_))) {
            facts.values.insert(*number, *value);
        }
        if facts.uses[number] == Use::Method {
            let used = members(program, &facts, function, dialect);
            facts.members.insert(*number, used);
        }
    }
    Ok(facts)
}

/// The type name of a block of the CPU or its libraries.
fn system_name(function: &Function) -> String {
    let name = function.name.as_str();
    if is_timer(name) && !name.ends_with("_LTIME") { format!("{name}_TIME") } else { name.to_string() }
}

/// The parts of the instance that a function uses, and whether it writes them: members or, in STEP 7, where a function
/// cannot pass on a structure it received, members of structures.
fn members(program: &Program, facts: &Facts, function: &Function, dialect: Dialect) -> BTreeMap<Vec<usize>, bool> {
    let mut used: BTreeMap<Vec<usize>, bool> = BTreeMap::new();
    let Body::Code(body) = &function.body else { return used };
    each_place(body, &mut |place, writes| {
        let number = |step: &Step| match step {
            Step::Member(number) => Some(*number),
            _ => None,
        };
        let most = if dialect == Dialect::Step7 { usize::MAX } else { 1 };
        let path: Vec<usize> = place.steps.iter().map_while(number).take(most).collect();
        if place.base == Base::Instance && !path.is_empty() {
            *used.entry(path).or_default() |= writes;
        }
    });
    walk::each_call(body, &mut |call| {
        if call.instance.as_ref().is_some_and(is_self) {
            let inner = facts.members.get(&call.function).cloned();
            let inner = inner.unwrap_or_else(|| members(program, facts, &program.functions[call.function], dialect));
            inner.into_iter().for_each(|(member, writes)| *used.entry(member).or_default() |= writes);
        }
    });
    used
}

/// Whether a place is the function's entire instance.
pub(super) fn is_self(place: &Place) -> bool {
    place.base == Base::Instance && place.steps.is_empty()
}

/// Whether a place is an entire local.
pub(super) fn is_temporary(place: &Place) -> bool {
    matches!(place.base, Base::Local(_)) && place.steps.is_empty()
}

/// Removes the assignments of constants to values for an FMU's host.
fn drop_host_values(program: &mut Program) {
    let declared = program.docs.declared.clone();
    let is_host = |place: &Place, record: Option<usize>| match (place.base, place.steps.as_slice()) {
        (Base::Instance, [Step::Member(member)]) => record
            .and_then(|record| declared.get(&(record, *member)))
            .is_some_and(|declared| declared.section == Section::Host),
        _ => false,
    };
    for function in &mut program.functions {
        let record = function.instance;
        if let Body::Code(body) = &mut function.body {
            body.retain(
                |statement| !matches!(&statement.what, What::Assign(to, Expr::Const(_)) if is_host(to, record)),
            );
        }
    }
}

/// Whether a type contains an instance, so that a variable of this type cannot be a parameter of a function.
fn has_instance(program: &Program, ty: &Type) -> bool {
    match ty {
        Type::Array { of, .. } => has_instance(program, of),
        Type::Record(record) => {
            program.functions.iter().any(|function| function.instance == Some(*record))
                || program.records[*record].members.iter().any(|member| has_instance(program, &member.ty))
        }
        _ => false,
    }
}

/// Inlines the methods that work on inner instances, since they cannot become functions.
fn inline(program: &mut Program, order: &[usize]) {
    for number in order {
        let Body::Code(body) = program.functions[*number].body.clone() else { continue };
        let mut locals = program.functions[*number].locals.clone();
        let body = inlined(program, body, &mut locals);
        let function = &mut program.functions[*number];
        function.locals = locals;
        function.body = Body::Code(body);
    }
}

fn inlined(program: &Program, list: Vec<Statement>, locals: &mut Vec<crate::ir::Local>) -> Vec<Statement> {
    let mut all = Vec::new();
    for mut statement in list {
        match &mut statement.what {
            What::Call(call) if can_be_inlined(program, call) => {
                let callee = &program.functions[call.function];
                let first = locals.len();
                locals.extend(callee.locals.iter().cloned());
                let own = |local: usize| Place::new(Base::Local(first + local));
                for (local, argument) in call.arguments.iter().enumerate() {
                    let value = match (argument, &callee.locals[local].ty) {
                        (Argument::Value(value), _) => value.clone(),
                        (_, Type::Scalar(ty)) => Expr::Const(crate::ir::Value::new(*ty, 0)),
                        _ => continue,
                    };
                    all.push(Statement { at: statement.at, what: What::Assign(own(local), value) });
                }
                let Body::Code(body) = &callee.body else { continue };
                all.extend(body.iter().map(|statement| moved(statement, first)));
                for (local, to) in &call.outputs {
                    if let Type::Scalar(ty) = callee.locals[*local].ty {
                        let value = Expr::Load(ty, own(*local));
                        all.push(Statement { at: statement.at, what: What::Assign(to.clone(), value) });
                    }
                }
                continue;
            }
            What::If(_, then, otherwise) => {
                *then = inlined(program, std::mem::take(then), locals);
                *otherwise = inlined(program, std::mem::take(otherwise), locals);
            }
            What::While(_, body) | What::Repeat(body, _) => *body = inlined(program, std::mem::take(body), locals),
            What::Case(_, arms, otherwise) => {
                for arm in arms {
                    arm.body = inlined(program, std::mem::take(&mut arm.body), locals);
                }
                *otherwise = inlined(program, std::mem::take(otherwise), locals);
            }
            _ => {}
        }
        all.push(statement);
    }
    all
}

/// Whether this is a call to a method on the same instance that uses inner instances and has no early exit.
fn can_be_inlined(program: &Program, call: &Call) -> bool {
    let callee = &program.functions[call.function];
    let (Some(record), Body::Code(body)) = (callee.instance, &callee.body) else { return false };
    let mut uses = false;
    let members = &program.records[record].members;
    each_place(body, &mut |place, _| {
        if let (Base::Instance, Some(Step::Member(member))) = (place.base, place.steps.first()) {
            uses |= has_instance(program, &members[*member].ty);
        }
    });
    let leaves = walk::any(body, |what| matches!(what, What::Return | What::Label(_) | What::Goto(_)));
    let by_value = callee.locals[..callee.parameters].iter().all(|local| matches!(local.ty, Type::Scalar(_)));
    call.instance.as_ref().is_some_and(is_self) && uses && !leaves && by_value
}

/// A copy of a statement with its local indices increased by `by`.
fn moved(statement: &Statement, by: usize) -> Statement {
    struct Moves(usize);
    impl Change for Moves {
        fn place(&mut self, place: &mut Place) {
            if let Base::Local(local) = &mut place.base {
                *local += self.0;
            }
        }
    }
    let mut statement = statement.clone();
    change::statements(std::slice::from_mut(&mut statement), &mut Moves(by));
    statement
}

/// Calls `show` for all places, with whether they may be written.
pub(super) fn each_place(list: &[Statement], show: &mut dyn FnMut(&Place, bool)) {
    struct Places<'s>(&'s mut dyn FnMut(&Place, bool));
    impl Look for Places<'_> {
        fn statement(&mut self, statement: &Statement) {
            match &statement.what {
                What::Assign(to, _) => (self.0)(to, true),
                What::Copy(to, from) => {
                    (self.0)(to, true);
                    (self.0)(from, false);
                }
                What::For(it) => (self.0)(&it.variable, true),
                _ => {}
            }
        }
        fn expr(&mut self, expr: &Expr) {
            match expr {
                Expr::Load(_, place) => (self.0)(place, false),
                Expr::Texts(_, a, b) | Expr::Same(a, b) => {
                    (self.0)(a, false);
                    (self.0)(b, false);
                }
                _ => {}
            }
        }
        fn call(&mut self, call: &Call) {
            call.instance.iter().for_each(|instance| (self.0)(instance, true));
            for argument in &call.arguments {
                match argument {
                    Argument::Copy(place) => (self.0)(place, false),
                    Argument::Reference(place) => (self.0)(place, true),
                    _ => {}
                }
            }
            call.outputs.iter().for_each(|(_, to)| (self.0)(to, true));
        }
    }
    walk::statements(list, &mut Places(show));
}
