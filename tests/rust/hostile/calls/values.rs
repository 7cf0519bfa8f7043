//! fmi2GetReal to fmi2SetString.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, Model, count_of, good_array, held, is_of, ok_if};
use crate::numbers::{any_integer, any_real};
use std::ffi::c_int;
use std::ptr;
use tests::{Fmu, Role, Status};

/// What stands in the host's arrays before a call, and has to stand there still where a call does not write.
const REAL: f64 = 4711.5;
const INTEGER: c_int = -4711;

impl Host<'_> {
    pub fn get(&mut self, turn: &mut Turn) -> Answer {
        let references = self.references(turn.random, turn.name);
        let (count, vr_null) = count_of(turn.random, references.len());
        let value_null = turn.random.once_in(16);
        let expected = get_expected(turn, self.fmu, &references, count, vr_null || value_null);

        let mut reals = [REAL; 8];
        let mut integers = [INTEGER; 8];
        let vr = if vr_null { ptr::null() } else { references.as_ptr() };
        let to_real = if value_null { ptr::null_mut() } else { reals.as_mut_ptr() };
        let to_integer = if value_null { ptr::null_mut() } else { integers.as_mut_ptr() };
        let (library, component) = (&self.fmu.library, turn.component);
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status: Status = unsafe {
            match turn.name {
                "fmi2GetReal" => (library.get_real)(component, vr, count, to_real),
                "fmi2GetInteger" => (library.get_integer)(component, vr, count, to_integer),
                _ => (library.get_boolean)(component, vr, count, to_integer),
            }
        }
        .into();

        let arguments = format!("{references:?}, {count}");
        let what = turn.with(&arguments);
        let written = if status == Status::Ok { count } else { 0 };
        assert!(reals[written..].iter().all(|real| *real == REAL), "{what} wrote behind its array");
        assert!(integers[written..].iter().all(|integer| *integer == INTEGER), "{what} wrote behind its array");
        for (place, reference) in references[..written].iter().enumerate() {
            let variable = &self.fmu.variables[*reference as usize];
            let got = if turn.name == "fmi2GetReal" { reals[place] } else { f64::from(integers[place]) };
            assert!(got != f64::from(INTEGER) && got != REAL, "{what} has not written {}", variable.name);
            if turn.name == "fmi2GetBoolean" {
                assert!(got == 0.0 || got == 1.0, "{what}: {} = {got}", variable.name);
            }
            if variable.role.is_settable() {
                let held = turn.model.values[*reference as usize];
                assert!(got.to_bits() == held.to_bits(), "{what}: {} = {got:?}, not {held:?}", variable.name);
            }
        }
        turn.unchanged(status, expected, arguments)
    }

    pub fn set(&mut self, turn: &mut Turn) -> Answer {
        let references = self.references(turn.random, turn.name);
        let (count, vr_null) = count_of(turn.random, references.len());
        let value_null = turn.random.once_in(16);
        let (reals, integers) = self.values(turn, &references);
        let given: Vec<f64> = match turn.name {
            "fmi2SetReal" => reals.clone(),
            _ => integers.iter().copied().map(f64::from).collect(),
        };
        let expected = set_expected(turn, self.fmu, &references, count, vr_null || value_null, &given);

        let vr = if vr_null { ptr::null() } else { references.as_ptr() };
        let from_reals = if value_null { ptr::null() } else { reals.as_ptr() };
        let from_integers = if value_null { ptr::null() } else { integers.as_ptr() };
        let (library, component) = (&self.fmu.library, turn.component);
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status: Status = unsafe {
            match turn.name {
                "fmi2SetReal" => (library.set_real)(component, vr, count, from_reals),
                "fmi2SetInteger" => (library.set_integer)(component, vr, count, from_integers),
                _ => (library.set_boolean)(component, vr, count, from_integers),
            }
        }
        .into();

        let mut after = turn.model.clone();
        if status == Status::Ok {
            for (reference, value) in references.iter().zip(&given).take(count) {
                let kind = self.fmu.variables[*reference as usize].kind;
                after.values[*reference as usize] = held(kind, *value).unwrap();
            }
        }
        Answer { status, expected, arguments: format!("{references:?}, {count}, {reals:?}, {integers:?}"), after }
    }

    /// Values to set, as Reals and as Integers or Booleans: mostly such that fit, so that something is set.
    fn values(&self, turn: &mut Turn, references: &[u32]) -> (Vec<f64>, Vec<c_int>) {
        let random = &mut *turn.random;
        let start = |reference: &u32| self.fmu.variables.get(*reference as usize).map_or(0.0, |row| row.start);
        let reals = references
            .iter()
            .map(|reference| match random.below(4) {
                0 => any_real(random),
                1 => start(reference),
                _ => random.between(0.0, 5.0),
            })
            .collect();
        (reals, references.iter().map(|_| any_integer(random)).collect())
    }

    pub fn string(&mut self, turn: &mut Turn) -> Answer {
        let references = self.references(turn.random, "fmi2GetReal");
        let (count, null) = count_of(turn.random, references.len());
        let vr = if null { ptr::null() } else { references.as_ptr() };
        // Equal literals need not have the same address.
        let text = c"text".as_ptr();
        let mut texts = [text; 8];
        // No variable is a String.
        let expected = ok_if(turn.allowed && count == 0);
        let (library, component) = (&self.fmu.library, turn.component);
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status = unsafe {
            match turn.name {
                "fmi2GetString" => (library.get_string)(component, vr, count, texts.as_mut_ptr()),
                _ => (library.set_string)(component, vr, count, texts.as_ptr()),
            }
        }
        .into();
        let arguments = format!("{references:?}, {count}");
        assert!(texts.iter().all(|after| *after == text), "{} wrote a text", turn.with(&arguments));
        turn.unchanged(status, expected, arguments)
    }
}

/// All are variables of this function's type.
fn get_expected(turn: &Turn, fmu: &Fmu, references: &[u32], count: usize, null: bool) -> Expected {
    let fit = references.iter().take(count).all(|reference| {
        fmu.variables.get(*reference as usize).is_some_and(|variable| is_of(variable.kind, turn.name))
    });
    ok_if(turn.allowed && good_array(count, references.len(), null) && fit)
}

/// All are variables of this function's type that may be set now, and can hold their values.
fn set_expected(turn: &Turn, fmu: &Fmu, references: &[u32], count: usize, null: bool, given: &[f64]) -> Expected {
    let fit = references.iter().zip(given).take(count).all(|(reference, value)| {
        fmu.variables.get(*reference as usize).is_some_and(|variable| {
            is_of(variable.kind, turn.name)
                && may_be_set(variable.role, &turn.model)
                && held(variable.kind, *value).is_some()
        })
    });
    ok_if(turn.allowed && good_array(count, references.len(), null) && fit)
}

fn may_be_set(role: Role, model: &Model) -> bool {
    match role {
        Role::Input | Role::Parameter => true,
        Role::Fixed | Role::Cycle => model.state < 2,
        Role::Output | Role::Local => false,
    }
}
