//! Facts about functions that the printer needs in advance.

use crate::ir::walk::{self, Look};
use crate::ir::{Argument, Base, Body, Call, Expr, Function, Place, Program, Scalar, Statement, Step, Type, What};
use std::collections::{BTreeMap, BTreeSet};

/// Facts about one function.
#[derive(Clone, Debug, Default)]
pub(super) struct Facts {
    /// Whether it has the parameter `call`: it can be stopped, reads the time or can be called from outside.
    pub needs_call: bool,
    /// Whether it has the parameter `memory`: it accesses the program's memory or can be called from outside.
    pub needs_memory: bool,
    /// Whether it writes only to its own locals and cannot be stopped.
    pub is_pure: bool,
    /// The local with the return value, if the only output is one number.
    pub returns: Option<usize>,
    /// The locals that a call copies to the caller, except `returns`.
    pub outs: BTreeSet<usize>,
}

/// The functions that can be called from outside and all their direct and indirect callees, callees first.
pub(super) fn reached(program: &Program) -> Vec<usize> {
    let entries = program.functions.iter().enumerate().filter(|(_, function)| is_entry(function));
    walk::reached(program, &entries.map(|(number, _)| number).collect::<Vec<_>>())
}

/// Whether a function can be called from outside.
pub(super) fn is_entry(function: &Function) -> bool {
    function.parameters == 0 && function.instance.is_none()
}

/// Whether statements contain a loop or a jump and so might not terminate.
pub(super) fn may_not_end(body: &[Statement]) -> bool {
    walk::any(body, |what| matches!(what, What::While(..) | What::Repeat(..) | What::For(_) | What::Goto(_)))
}

/// Whether the statements contain a RETURN, at any depth.
pub(super) fn may_leave(body: &[Statement]) -> bool {
    walk::any(body, |what| matches!(what, What::Return))
}

/// The facts by function number, set only for the reached functions, which are listed callees first. `counts` means
/// that statements are counted.
pub(super) fn facts(program: &Program, reached: &[usize], counts: bool) -> Vec<Facts> {
    let mut facts = vec![Facts::default(); program.functions.len()];
    struct Outputs<'a>(&'a mut [Facts]);
    impl Look for Outputs<'_> {
        fn call(&mut self, call: &Call) {
            self.0[call.function].outs.extend(call.outputs.iter().map(|(local, _)| *local));
        }
    }
    for number in reached {
        if let Body::Code(body) = &program.functions[*number].body {
            walk::statements(body, &mut Outputs(&mut facts));
        }
    }
    for number in reached {
        let function = &program.functions[*number];
        let outs = facts[*number].outs.clone();
        let only = outs.first().copied().filter(|local| {
            let is_number = matches!(function.locals[*local].ty, Type::Scalar(_));
            outs.len() == 1 && *local >= function.parameters && is_number
        });
        let Body::Code(body) = &function.body else { continue };
        let mut finds = Finds { function, facts: &facts, found: Facts { is_pure: true, ..Facts::default() } };
        walk::statements(body, &mut finds);
        let mut found = finds.found;
        // An entry function has both parameters even if other functions call it.
        found.needs_call |= counts && !program.docs.natives.contains(number) || is_entry(function);
        found.needs_memory |= is_entry(function);
        found.is_pure &= !found.needs_call;
        found.returns = only;
        found.outs = if only.is_some() { BTreeSet::new() } else { outs };
        facts[*number] = found;
    }
    facts
}

struct Finds<'a> {
    function: &'a Function,
    facts: &'a [Facts],
    found: Facts,
}

impl Finds<'_> {
    fn place(&mut self, place: &Place, written: bool) {
        self.found.needs_memory |= place.base == Base::Memory;
        self.found.needs_call |= has_index(place);
        let is_own = match place.base {
            Base::Local(local) => !self.function.locals[local].by_reference,
            _ => false,
        };
        self.found.is_pure &= !written || is_own;
    }
}

impl Look for Finds<'_> {
    fn statement(&mut self, it: &Statement) {
        match &it.what {
            What::Assign(to, _) => self.place(to, true),
            What::Copy(to, from) => {
                self.place(to, true);
                self.place(from, false);
            }
            What::For(it) => {
                self.place(&it.variable, true);
                self.found.needs_call = true;
            }
            What::While(..) | What::Repeat(..) | What::Goto(_) => self.found.needs_call = true,
            _ => {}
        }
    }

    fn expr(&mut self, it: &Expr) {
        match it {
            Expr::Load(_, place) => self.place(place, false),
            Expr::Texts(_, a, b) | Expr::Same(a, b) => {
                self.place(a, false);
                self.place(b, false);
            }
            Expr::Now => self.found.needs_call = true,
            _ => {}
        }
    }

    fn call(&mut self, call: &Call) {
        let callee = &self.facts[call.function];
        self.found.needs_call |= callee.needs_call;
        self.found.needs_memory |= callee.needs_memory;
        self.found.is_pure &= callee.is_pure;
        call.instance.iter().for_each(|place| self.place(place, false));
        for argument in &call.arguments {
            match argument {
                Argument::Copy(place) => self.place(place, false),
                Argument::Reference(place) => self.place(place, true),
                Argument::Value(_) | Argument::Start => {}
            }
        }
        call.outputs.iter().for_each(|(_, place)| self.place(place, true));
    }
}

/// Whether a place has an index, which may need a bounds check.
pub(super) fn has_index(place: &Place) -> bool {
    place.steps.iter().any(|step| matches!(step, Step::Index(..)))
}

/// The local to which a place belongs.
pub(super) fn local(place: &Place) -> Option<usize> {
    match place.base {
        Base::Local(local) => Some(local),
        _ => None,
    }
}

/// A call whose value is used immediately: the call, and the local that carries the value.
pub(super) fn taken<'a>(expr: &'a Expr, facts: &[Facts]) -> Option<(&'a Call, usize)> {
    let Expr::After(before, value) = expr else { return None };
    let ([Statement { what: What::Call(call), .. }], Expr::Load(_, from)) = (&before[..], &**value) else {
        return None;
    };
    let [(output, to)] = &call.outputs[..] else { return None };
    let fits = facts[call.function].returns == Some(*output) && to == from && to.steps.is_empty();
    local(to).filter(|_| fits).map(|local| (call, local))
}

/// Counts how often each local is named, and finds the locals that only carry a call's value.
pub(super) struct Uses<'a> {
    facts: &'a [Facts],
    counts: BTreeMap<usize, usize>,
    through: BTreeSet<usize>,
    read: BTreeSet<usize>,
}

impl<'a> Uses<'a> {
    /// Counts the uses in a function's body. Locals copied to the caller have one more use, at the end.
    pub(super) fn new(facts: &'a [Facts], number: usize, body: &[Statement]) -> Uses<'a> {
        let mut uses = Uses { facts, counts: BTreeMap::new(), through: BTreeSet::new(), read: BTreeSet::new() };
        let own = &facts[number];
        uses.counts.extend(own.outs.iter().copied().chain(own.returns).map(|local| (local, 1)));
        walk::statements(body, &mut uses);
        uses
    }

    /// Counts all uses, including locals that only carry the values of calls.
    pub(super) fn all(body: &[Statement]) -> Uses<'static> {
        let mut uses = Uses { facts: &[], counts: BTreeMap::new(), through: BTreeSet::new(), read: BTreeSet::new() };
        walk::statements(body, &mut uses);
        uses
    }

    /// Whether a local only carries the value of a call and has no other use.
    pub(super) fn is_elided(&self, local: usize) -> bool {
        self.through.contains(&local) && self.counts.get(&local) == Some(&2)
    }

    /// The locals that are named, except those that only carry the values of calls.
    pub(super) fn locals(&self) -> impl Iterator<Item = usize> {
        self.counts.keys().copied().filter(|local| !self.is_elided(*local))
    }

    /// Whether a local is named.
    pub(super) fn is_named(&self, local: usize) -> bool {
        self.counts.contains_key(&local)
    }

    /// Whether a local is read.
    pub(super) fn is_read(&self, local: usize) -> bool {
        self.read.contains(&local)
    }

    fn read(&mut self, place: &Place) {
        self.read.extend(local(place));
        self.place(place);
    }

    fn place(&mut self, place: &Place) {
        if let Some(local) = local(place) {
            *self.counts.entry(local).or_default() += 1;
        }
    }

    /// Notes the local if the whole value or condition of a statement is a call; this call may have side effects.
    fn whole(&mut self, value: &Expr) {
        if !self.facts.is_empty() {
            self.through.extend(taken(value, self.facts).map(|(_, local)| local));
        }
    }
}

impl Look for Uses<'_> {
    fn statement(&mut self, it: &Statement) {
        match &it.what {
            What::Assign(to, value) => {
                self.place(to);
                if !has_index(to) {
                    self.whole(value);
                }
            }
            What::If(condition, ..) => self.whole(condition),
            What::Copy(to, from) => {
                self.place(to);
                self.read(from);
            }
            What::For(it) => self.read(&it.variable),
            _ => {}
        }
    }

    fn expr(&mut self, it: &Expr) {
        match it {
            Expr::Load(_, place) => self.read(place),
            Expr::Texts(_, a, b) | Expr::Same(a, b) => {
                self.read(a);
                self.read(b);
            }
            Expr::Bound { local, .. } => *self.counts.entry(*local).or_default() += 1,
            Expr::After(..) if !self.facts.is_empty() => {
                let pure = taken(it, self.facts).filter(|(call, _)| self.facts[call.function].is_pure);
                self.through.extend(pure.map(|(_, local)| local));
            }
            _ => {}
        }
    }

    fn call(&mut self, call: &Call) {
        call.instance.iter().for_each(|place| self.read(place));
        for argument in &call.arguments {
            if let Argument::Copy(place) | Argument::Reference(place) = argument {
                self.read(place);
            }
        }
        call.outputs.iter().for_each(|(_, place)| self.place(place));
    }
}

/// Whether evaluating an expression early, late or not at all makes no observable difference.
pub(super) fn is_quiet(it: &Expr, facts: &[Facts]) -> bool {
    struct Finds<'a>(bool, &'a [Facts]);
    impl Look for Finds<'_> {
        fn expr(&mut self, it: &Expr) {
            let of = |place: &Place| !has_index(place);
            self.0 &= match it {
                Expr::Load(_, place) => of(place),
                Expr::Texts(_, a, b) | Expr::Same(a, b) => of(a) && of(b),
                Expr::After(..) => taken(it, self.1).is_some_and(|(call, _)| self.1[call.function].is_pure),
                _ => true,
            };
        }
    }
    let mut finds = Finds(true, facts);
    walk::expr(it, &mut finds);
    finds.0
}

/// The statements in printed form: an IF that assigns one variable in both branches becomes a conditional assignment.
pub(super) fn simplified(list: &[Statement], facts: &[Facts]) -> Vec<Statement> {
    list.iter().map(|statement| Statement { at: statement.at, what: simplified_one(&statement.what, facts) }).collect()
}

fn simplified_one(what: &What, facts: &[Facts]) -> What {
    match what {
        What::If(condition, then, otherwise) => {
            let (then, otherwise) = (simplified(then, facts), simplified(otherwise, facts));
            if let ([Statement { what: What::Assign(to, a), .. }], [Statement { what: What::Assign(other, b), .. }]) =
                (&then[..], &otherwise[..])
                && to == other
                && let Some(ty) = short(&[condition, a, b], facts)
                && !has_index(to)
            {
                let choice = Expr::Select(ty, Box::new([condition.clone(), a.clone(), b.clone()]));
                return What::Assign(to.clone(), choice);
            }
            // An ELSIF chain stays a chain.
            let otherwise = match (&what, &otherwise[..]) {
                (What::If(.., before), [Statement { what: What::Assign(..), at }]) => match &before[..] {
                    [Statement { what: What::If(condition, then, otherwise), .. }] => {
                        let (then, otherwise) = (simplified(then, facts), simplified(otherwise, facts));
                        vec![Statement { at: *at, what: What::If(condition.clone(), then, otherwise) }]
                    }
                    _ => otherwise,
                },
                _ => otherwise,
            };
            What::If(condition.clone(), then, otherwise)
        }
        other => other.clone(),
    }
}

/// The type of a conditional expression with these parts; `None` if it is too long for one line, or if the order of
/// evaluation matters.
fn short(parts: &[&Expr; 3], facts: &[Facts]) -> Option<Scalar> {
    struct Size(usize);
    impl Look for Size {
        fn expr(&mut self, it: &Expr) {
            // Nested conditionals are hard to read.
            self.0 += if matches!(it, Expr::Select(..)) { 100 } else { 1 };
        }
    }
    let mut size = Size(0);
    parts.iter().for_each(|part| walk::expr(part, &mut size));
    (size.0 <= 12 && parts.iter().all(|part| is_quiet(part, facts))).then(|| parts[1].ty())
}
