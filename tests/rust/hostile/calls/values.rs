//! fmi2GetReal to fmi2SetString.

use crate::calls::{Answer, Turn};
use crate::host::Host;
use crate::model::{Expected, Model, count_of, good_array, has_access, held, holds, ok_if, takes};
use crate::numbers::{any_integer, any_real};
use std::ffi::{CStr, c_char, c_int};
use std::ptr;
use tests::{Fmu, Random, Role, Status};

/// What stands in the host's arrays before a call, and has to stand there still where a call does not write.
const REAL: f64 = 4711.5;
const INTEGER: c_int = -4711;

impl Host<'_> {
    pub(crate) fn get(&mut self, turn: &mut Turn) -> Answer {
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

    pub(crate) fn set(&mut self, turn: &mut Turn) -> Answer {
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
        let start = |reference: &u32| self.fmu.variables.get(*reference as usize).map_or(0.0, |row| row.start());
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

    pub(crate) fn string(&mut self, turn: &mut Turn) -> Answer {
        let references = self.text_references(turn.random);
        let (count, vr_null) = count_of(turn.random, references.len());
        let value_null = turn.random.once_in(16);
        let is_get = turn.name == "fmi2GetString";
        let given: Vec<Option<&CStr>> = references.iter().map(|_| any_text(turn.random)).collect();
        let fits = |(reference, given): (&u32, &Option<&CStr>)| {
            let number = (*reference as usize).checked_sub(self.fmu.variables.len());
            let Some(text) = number.and_then(|number| self.fmu.texts.get(number)) else { return false };
            let given = given.and_then(|given| given.to_str().ok());
            is_get || may_be_set(text.role, &turn.model) && given.is_some_and(|given| holds(text, given))
        };
        let expected = ok_if(
            turn.allowed
                && good_array(count, references.len(), vr_null || value_null)
                && references.iter().zip(&given).take(count).all(fits),
        );

        let untouched = *b"untouched\0";
        let untouched = untouched.as_ptr().cast::<c_char>();
        let mut texts = [untouched; 8];
        if !is_get {
            texts.iter_mut().zip(&given).for_each(|(to, given)| *to = given.map_or(ptr::null(), CStr::as_ptr));
        }
        let vr = if vr_null { ptr::null() } else { references.as_ptr() };
        let values = if value_null { ptr::null_mut() } else { texts.as_mut_ptr() };
        let (library, component) = (&self.fmu.library, turn.component);
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status: Status = unsafe {
            if is_get {
                (library.get_string)(component, vr, count, values)
            } else {
                (library.set_string)(component, vr, count, values)
            }
        }
        .into();

        let arguments = format!("{references:?}, {count}, {given:?}");
        let what = turn.with(&arguments);
        let done = if status == Status::Ok { count } else { 0 };
        let mut after = turn.model.clone();
        for (place, reference) in references[..done].iter().enumerate() {
            let number = *reference as usize - self.fmu.variables.len();
            if !is_get {
                after.texts[number] = given[place].unwrap().to_str().unwrap().to_string();
                continue;
            }
            assert!(texts[place] != untouched, "{what} has not written {}", self.fmu.texts[number].name);
            // SAFETY: a text that the FMU gave, which lives until the next call on the instance.
            let got = unsafe { CStr::from_ptr(texts[place]) }.to_str().unwrap();
            let (text, held) = (&self.fmu.texts[number], &turn.model.texts[number]);
            assert!(!text.role.is_settable() || got == held, "{what}: {} = {got:?}, not {held:?}", text.name);
        }
        let written = if is_get { done } else { texts.len() };
        assert!(texts[written..].iter().all(|text| *text == untouched), "{what} wrote behind its array");
        Answer { status, expected, arguments, after }
    }

    /// Value references, mostly those of texts if there are any.
    fn text_references(&self, random: &mut Random) -> Vec<u32> {
        let (first, texts) = (self.fmu.variables.len() as u32, self.fmu.texts.len());
        let mut references = self.references(random, "fmi2GetReal");
        for reference in references.iter_mut().filter(|_| texts > 0) {
            if !random.once_in(8) {
                *reference = first + random.below(texts) as u32;
            }
        }
        references
    }
}

/// Texts for STRING[3], STRING[6] and WSTRING[4]: such that fit, that are one character too long, or that are none.
pub(crate) fn any_text(random: &mut Random) -> Option<&'static CStr> {
    random.pick(&[
        Some(c""),
        Some(c"No"),
        Some(c"\u{e4}\u{ff}"),
        Some(c"B-7"),
        Some(c"%s%n"),
        Some(c"A-1000"),
        Some(c"A-10000"),
        Some(c"\u{20ac}"),
        Some(c"\u{1f600}\u{1f600}"),
        Some(c"\u{1f600}\u{1f600}a"),
        Some(c"\xff"),
        None,
    ])
}

/// All are variables that this function reads.
fn get_expected(turn: &Turn, fmu: &Fmu, references: &[u32], count: usize, null: bool) -> Expected {
    let fit = references.iter().take(count).all(|reference| {
        fmu.variables.get(*reference as usize).is_some_and(|variable| has_access(variable.kind, turn.name))
    });
    ok_if(turn.allowed && good_array(count, references.len(), null) && fit)
}

/// All are variables that may be set now, by this function, to their values.
fn set_expected(turn: &Turn, fmu: &Fmu, references: &[u32], count: usize, null: bool, given: &[f64]) -> Expected {
    let fit = references.iter().zip(given).take(count).all(|(reference, value)| {
        fmu.variables
            .get(*reference as usize)
            .is_some_and(|variable| may_be_set(variable.role, &turn.model) && takes(variable.kind, turn.name, *value))
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
