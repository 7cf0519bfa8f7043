//! An instance of a block or program that runs in this process, without a C interface. It performs the same checks as
//! an instance called through the C interface, with the same messages.

use crate::abreast;
use anyhow::{Context, Result, anyhow, ensure};
use blocks::table::abreast::Abreast;
use blocks::table::number::to_value;
use blocks::{Block, Value};
use fmu::clock::Clock;
use fmu::component::{self, Origin};
use fmu::cyclic::{Cyclic, StartValues};
use fmu::host_type::HostType;
use fmu::refusal::Refusal;
use fmu::state::Function;
use fmu::table::Fingerprint;
use fmu::v2::value::Boolean;
use fmu::v2::{Fmi2, status_name};
use run::component::{Combine, Component, Force, Reset, Side, Type};
use std::ffi::c_int;

/// An instance of a block or program.
pub struct Instance<B: Cyclic> {
    component: component::Component<B>,
    /// Buffers for Integers and Booleans; kept, so that a step allocates nothing.
    integers: Vec<c_int>,
    booleans: Vec<Boolean>,
    /// The forced rows, with their values.
    forced: Vec<(usize, Value)>,
    /// Combines this instance with those of other runs, to step them side by side; `None` if it cannot be combined.
    combine: Option<Combine>,
}

impl<B: Block> Instance<B> {
    /// Like [`Instance::new`], but the instance can be stepped side by side with instances of other runs; their blocks
    /// are then stored together as a `G`.
    ///
    /// # Errors
    /// As for [`Instance::new`].
    pub fn abreast<G: Abreast<B>>(name: &str) -> Result<Instance<B>> {
        Ok(Instance { combine: Some(abreast::combine::<B, G>), ..Instance::new(name)? })
    }

    /// A new instance with the block's own start values, with logging on.
    ///
    /// # Errors
    /// The name is empty or contains a NUL.
    pub fn new(name: &str) -> Result<Instance<B>> {
        let origin = Origin { hash: Fingerprint::<B>::HASH, form: 0, start: StartValues::Own };
        Instance::from_origin(name, origin)
    }
}

impl<B: Cyclic> Instance<B> {
    /// A new instance, with logging on.
    ///
    /// # Errors
    /// The name is empty or contains a NUL.
    pub fn from_origin(name: &str, origin: Origin<B>) -> Result<Instance<B>> {
        ensure!(
            !name.is_empty() && !name.contains('\0'),
            "{name:?} is empty or contains a NUL: give the instance a name"
        );
        let component = component::Component::new(origin, true);
        Ok(Instance { component, integers: Vec::new(), booleans: Vec::new(), forced: Vec::new(), combine: None })
    }

    /// The block, with its current values.
    pub fn block(&self) -> &B {
        self.component.instance.block()
    }

    /// The block and the clock, if the next step may be an ordinary one.
    pub(crate) fn ordinary_parts(&mut self) -> Option<(&mut B, &mut Clock)> {
        let instance = &mut self.component.instance;
        if instance.may(&Function::fmi2DoStep).is_ok() { instance.ordinary_parts() } else { None }
    }

    /// Removes and returns the advice for the user, such as a program's warnings in the last step.
    pub fn take_advice(&mut self) -> Vec<String> {
        std::mem::take(&mut self.component.advice)
    }

    /// Calls a function as the C interface does: only if the instance's state permits it.
    fn call(
        &mut self,
        function: &Function,
        body: impl FnOnce(&mut component::Component<B>) -> Result<(), Refusal>,
    ) -> Result<()> {
        let done = self.component.instance.may(function).and_then(|()| body(&mut self.component));
        // A host receives the same message through the C interface.
        done.map_err(|refusal| {
            anyhow!("{} returned {}: {}", function.name, status_name(refusal.answer()), refusal.reason())
        })
    }

    /// Writes the forced values into the block.
    #[inline]
    fn hold(&mut self) {
        for (row, value) in &self.forced {
            self.component.instance.overwrite(*row, *value);
        }
    }

    #[inline]
    fn get<T: HostType<Fmi2>>(&mut self, function: &Function, references: &[u32], values: &mut [T]) -> Result<()> {
        self.call(function, |component| component.instance.get(references, values))
    }

    #[inline]
    fn set<T: HostType<Fmi2>>(&mut self, function: &Function, references: &[u32], values: &[T]) -> Result<()> {
        self.call(function, |component| component.instance.set(references, values))
    }
}

impl<B: Cyclic> Component for Instance<B> {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.call(&Function::fmi2SetupExperiment, |component| component.instance.setup_experiment(start, stop))
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.call(&Function::fmi2EnterInitializationMode, |component| {
            component.instance.enter_initialization_mode(&Function::fmi2SetupExperiment)
        })
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.call(&Function::fmi2ExitInitializationMode, component::Component::exit_initialization_mode)
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        if kind == Type::Real {
            return self.get(&Function::fmi2GetReal, references, values);
        }
        // A single value needs no buffer.
        if let (Type::Integer, [_], [value]) = (kind, references, &mut *values) {
            let mut integer = [0];
            self.get(&Function::fmi2GetInteger, references, &mut integer)?;
            *value = f64::from(integer[0]);
            return Ok(());
        }
        if let (Type::Boolean, [_], [value]) = (kind, references, &mut *values) {
            let mut boolean = [Boolean(0)];
            self.get(&Function::fmi2GetBoolean, references, &mut boolean)?;
            *value = f64::from(boolean[0].0);
            return Ok(());
        }
        let (mut integers, mut booleans) = (std::mem::take(&mut self.integers), std::mem::take(&mut self.booleans));
        let done = if kind == Type::Integer {
            integers.clear();
            integers.resize(references.len(), 0);
            self.get(&Function::fmi2GetInteger, references, &mut integers)
        } else {
            booleans.clear();
            booleans.resize(references.len(), Boolean(0));
            self.get(&Function::fmi2GetBoolean, references, &mut booleans)
        };
        if done.is_ok() && kind == Type::Integer {
            values.iter_mut().zip(&integers).for_each(|(to, from)| *to = f64::from(*from));
        } else if done.is_ok() {
            values.iter_mut().zip(&booleans).for_each(|(to, from)| *to = f64::from(from.0));
        }
        (self.integers, self.booleans) = (integers, booleans);
        done
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        if kind == Type::Real {
            return self.set(&Function::fmi2SetReal, references, values);
        }
        if let [value] = values
            && f64::from(*value as c_int) == *value
        {
            let integer = *value as c_int;
            return match kind {
                Type::Integer => self.set(&Function::fmi2SetInteger, references, &[integer]),
                _ => self.set(&Function::fmi2SetBoolean, references, &[Boolean(c_int::from(integer != 0))]),
            };
        }
        let (mut integers, mut booleans) = (std::mem::take(&mut self.integers), std::mem::take(&mut self.booleans));
        integers.clear();
        integers.extend(values.iter().map(|value| *value as c_int));
        let done = match values.iter().zip(&integers).find(|(value, integer)| f64::from(**integer) != **value) {
            Some((value, _)) => Err(anyhow!("{value:?} is not a 32-bit integer")),
            None if kind == Type::Integer => self.set(&Function::fmi2SetInteger, references, &integers),
            None => {
                booleans.clear();
                booleans.extend(integers.iter().map(|integer| Boolean(c_int::from(*integer != 0))));
                self.set(&Function::fmi2SetBoolean, references, &booleans)
            }
        };
        (self.integers, self.booleans) = (integers, booleans);
        done
    }

    fn force(&mut self, reference: u32, how: Force) -> Result<()> {
        let row = reference as usize;
        let kind = self.block().table().rows.get(row).context("no such variable")?.kind;
        let value = |number| to_value(number, kind).map_err(|range| anyhow!("{number:?}: {range}"));
        match how {
            Force::Once(number) => self.component.instance.overwrite(row, value(number)?),
            Force::Always(number) => {
                let value = value(number)?;
                self.forced.retain(|(other, _)| *other != row);
                self.forced.push((row, value));
            }
            Force::Release => self.forced.retain(|(other, _)| *other != row),
        }
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        self.hold();
        let done = self
            .call(&Function::fmi2DoStep, |component| component.do_step(time, size).map(drop))
            .with_context(|| format!("at {time:?} s, step {size:?} s"));
        self.hold();
        done
    }

    fn side(&mut self) -> Option<Side<'_>> {
        self.combine.map(|combine| Side { component: self, combine })
    }

    fn terminate(&mut self) -> Result<()> {
        self.call(&Function::fmi2Terminate, |component| {
            component.instance.terminate();
            Ok(())
        })
    }
}

impl<B: Cyclic> Reset for Instance<B> {
    fn reset(&mut self) -> Result<()> {
        self.call(&Function::fmi2Reset, |component| {
            component.reset();
            Ok(())
        })
    }
}
