//! An instance of a block or program that runs in this program, without a C interface. It goes through the same checks as an
//! instance behind one, and what it says has the same words.

use anyhow::{Context, Result, anyhow, ensure};
use blocks::Block;
use fmu::component::{self, Fresh, Origin};
use fmu::cyclic::Cyclic;
use fmu::host_type::HostType;
use fmu::refusal::Refusal;
use fmu::state::Function;
use fmu::table::Fingerprint;
use fmu::v2::value::Boolean;
use fmu::v2::{Fmi2, status_name};
use run::component::{Component, Type};
use std::ffi::c_int;

/// An instance.
pub struct Instance<B> {
    component: component::Component<B>,
    /// Integers and Booleans on their way; kept, so that a step allocates nothing.
    integers: Vec<c_int>,
    booleans: Vec<Boolean>,
}

impl<B: Block> Instance<B> {
    /// A new instance of a block with its start values, with logging on.
    ///
    /// # Errors
    /// The name is empty or contains a NUL.
    pub fn new(name: &str) -> Result<Instance<B>> {
        Instance::of(name, Origin { hash: Fingerprint::<B>::HASH, fresh: Fresh::New(B::default) })
    }
}

impl<B: Cyclic> Instance<B> {
    /// A new instance, with logging on.
    ///
    /// # Errors
    /// The name is empty or contains a NUL.
    pub fn of(name: &str, origin: Origin<B>) -> Result<Instance<B>> {
        ensure!(
            !name.is_empty() && !name.contains('\0'),
            "{name:?} is empty or contains a NUL: give the instance a name"
        );
        let component = component::Component::new(origin, true);
        Ok(Instance { component, integers: Vec::new(), booleans: Vec::new() })
    }

    /// What it calls, with its present values.
    pub fn block(&self) -> &B {
        self.component.instance.block()
    }

    /// What the user should know of the last step although it succeeded.
    pub fn take_advice(&mut self) -> Vec<String> {
        std::mem::take(&mut self.component.advice)
    }

    /// Makes a call as the C interface does: if the function may be called now.
    fn call(
        &mut self,
        function: &Function,
        body: impl FnOnce(&mut component::Component<B>) -> Result<(), Refusal>,
    ) -> Result<()> {
        let done = self.component.instance.may(function).and_then(|()| body(&mut self.component));
        // The words of a host that is told so through the C interface.
        done.map_err(|refusal| {
            anyhow!("{} returned {}: {}", function.name, status_name(refusal.answer()), refusal.reason())
        })
    }
}

/// Converts values, calls, and converts back.
fn get<B: Cyclic, T: HostType<Fmi2>>(
    component: &component::Component<B>,
    references: &[u32],
    room: &mut Vec<T>,
    empty: T,
) -> Result<(), Refusal> {
    room.clear();
    room.resize(references.len(), empty);
    component.instance.get(references, room)
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
        let (mut integers, mut booleans) = (std::mem::take(&mut self.integers), std::mem::take(&mut self.booleans));
        let done = match kind {
            Type::Real => self.call(&Function::fmi2GetReal, |component| component.instance.get(references, values)),
            Type::Integer => {
                self.call(&Function::fmi2GetInteger, |component| get(component, references, &mut integers, 0))
            }
            Type::Boolean => {
                self.call(&Function::fmi2GetBoolean, |component| get(component, references, &mut booleans, Boolean(0)))
            }
        };
        if done.is_ok() {
            match kind {
                Type::Real => {}
                Type::Integer => values.iter_mut().zip(&integers).for_each(|(to, from)| *to = f64::from(*from)),
                Type::Boolean => values.iter_mut().zip(&booleans).for_each(|(to, from)| *to = f64::from(from.0)),
            }
        }
        (self.integers, self.booleans) = (integers, booleans);
        done
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        if kind == Type::Real {
            return self.call(&Function::fmi2SetReal, |component| component.instance.set(references, values));
        }
        let mut integers = Vec::with_capacity(values.len());
        for value in values {
            let integer = *value as c_int;
            ensure!(f64::from(integer) == *value, "{value:?} is not an integer of 32 bits");
            integers.push(integer);
        }
        if kind == Type::Integer {
            return self.call(&Function::fmi2SetInteger, |component| component.instance.set(references, &integers));
        }
        let booleans: Vec<_> = integers.iter().map(|integer| Boolean(c_int::from(*integer != 0))).collect();
        self.call(&Function::fmi2SetBoolean, |component| component.instance.set(references, &booleans))
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        self.call(&Function::fmi2DoStep, |component| component.do_step(time, size))
            .with_context(|| format!("at {time:?} s, step {size:?} s"))
    }

    fn terminate(&mut self) -> Result<()> {
        self.call(&Function::fmi2Terminate, |component| {
            component.instance.terminate();
            Ok(())
        })
    }
}
