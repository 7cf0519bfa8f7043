//! What the engine needs of an FMU: an instance that it can initialize, set, step and read, whatever is behind it.

use anyhow::{Result, bail};
pub use modeldescription::Type;
use std::any::Any;
use std::error::Error;
use std::fmt;
use std::ops::Range;

/// The FMU has ended the simulation in a step, which is no failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminated;

impl fmt::Display for Terminated {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("the FMU ended the simulation")
    }
}

impl Error for Terminated {}

/// An FMU that still has events after this many updates is at fault.
pub const MOST_UPDATES: usize = 100;

/// What an FMU says when its discrete states are updated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// They are to be updated once more.
    pub is_needed: bool,
    /// When its next event is, in seconds, if it knows.
    pub next: Option<f64>,
}

/// Where the values of a member come from and go to. It follows from the plan alone: worked out once, so that a step only moves
/// values.
#[derive(Debug)]
pub struct Wiring {
    /// Where the member's values are in those of the run.
    pub own: Range<usize>,
    /// What others need or is recorded, by type.
    pub read: Vec<Read>,
    /// The connected inputs, by type.
    pub written: Vec<Written>,
}

/// Variables of one type, which one call reads.
#[derive(Debug)]
pub struct Read {
    /// Their type.
    pub kind: Type,
    /// Their value references.
    pub references: Vec<u32>,
    /// Where their values are in those of the run.
    pub places: Range<usize>,
}

/// Inputs of one type, which one call writes.
#[derive(Debug)]
pub struct Written {
    /// Their type.
    pub kind: Type,
    /// Their value references.
    pub references: Vec<u32>,
    /// Where their values come from in those of the run.
    pub sources: Vec<usize>,
    /// Which of them are converted, by their places, and from what.
    pub converted: Vec<(usize, Type)>,
    /// The values of the present step.
    pub values: Vec<f64>,
    /// Of an FMU with Event Mode, the values of the sources that were written last.
    pub seen: Vec<f64>,
}

/// How a variable is written that the FMU computes itself, or that is connected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    /// Now.
    Once(f64),
    /// Before and after each step from now on.
    Always(f64),
    /// No longer.
    Release,
}

/// What a run needs of an instance of an FMU.
pub trait Component {
    /// Start of the simulation in seconds, and its end if that is known.
    ///
    /// # Errors
    /// The FMU refuses. So in all other functions.
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()>;
    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The FMU refuses.
    fn enter_initialization(&mut self) -> Result<()>;
    /// Leaves Initialization Mode.
    ///
    /// # Errors
    /// The FMU refuses.
    fn exit_initialization(&mut self) -> Result<()>;
    /// Reads variables of one type, each as [`Type::cell`] says; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()>;
    /// Writes variables of one type, each as [`Type::cell`] says; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()>;
    /// Writes a variable whatever it is, which no FMU allows through its interface.
    ///
    /// # Errors
    /// The component has no more than its interface.
    fn force(&mut self, _reference: u32, _how: Force) -> Result<()> {
        bail!("only variables of blocks and programs that run without an FMU can be forced")
    }
    /// Steps from `time` to `time + size`, in seconds.
    ///
    /// # Errors
    /// The FMU refuses; [`Terminated`].
    fn step(&mut self, time: f64, size: f64) -> Result<()>;
    /// Enters Event Mode, if it is not in it. Called only of a member whose plan has events; so are the next two.
    ///
    /// # Errors
    /// The FMU refuses, or has no Event Mode.
    fn enter_events(&mut self) -> Result<()> {
        bail!("it has no Event Mode")
    }
    /// Takes over the inputs in Event Mode, and makes what is due.
    ///
    /// # Errors
    /// The FMU refuses; [`Terminated`].
    fn update(&mut self) -> Result<Update> {
        bail!("it has no Event Mode")
    }
    /// Leaves Event Mode for the next step.
    ///
    /// # Errors
    /// The FMU refuses.
    fn leave_events(&mut self) -> Result<()> {
        bail!("it has no Event Mode")
    }
    /// Itself, to stand among the others of [`abreast`](Component::abreast); `None`, the default, if it cannot.
    fn any(&mut self) -> Option<&mut dyn Any> {
        None
    }
    /// This one and others of the same kind, a member of each of several runs, as what makes their ordinary steps side by side; none,
    /// the default, if it cannot.
    fn abreast<'a>(&'a mut self, _others: Vec<&'a mut dyn Any>, _wiring: &Wiring) -> Option<Box<dyn Abreast + 'a>> {
        None
    }
    /// Ends the simulation.
    ///
    /// # Errors
    /// The FMU refuses.
    fn terminate(&mut self) -> Result<()>;
}

/// A member of each of several runs, which make the same steps side by side.
pub trait Abreast {
    /// Whether this step can fail only because of an input value.
    fn is_ordinary(&self, time: f64, size: f64) -> bool;
    /// Writes the connected inputs, makes a step that is ordinary, and reads what others need, for all runs. `values` has a value of
    /// each run for each place in the values of a run. False if a value is refused; only inputs are written then.
    fn cycle(&mut self, values: &mut [f64], time: f64, size: f64) -> bool;
    /// Gives the components what they have come to.
    fn end(self: Box<Self>);
}

/// An instance that can be used for one simulation after the other.
pub trait Reset: Component {
    /// Makes it as new.
    ///
    /// # Errors
    /// The FMU refuses; then only a new instance can go on.
    fn reset(&mut self) -> Result<()>;
}

/// Makes a type a [`Component`](crate::component::Component) that forwards each call:
/// `forward_component!([GENERICS] TYPE, self => TARGET)`.
#[macro_export]
macro_rules! forward_component {
    ([$($generics:tt)*] $type:ty, $self:ident => $target:expr) => {
        $crate::forward_component! { [$($generics)*] $type, $self => $target,
            setup(start: f64, stop: Option<f64>)
            enter_initialization()
            exit_initialization()
            read(kind: $crate::component::Type, references: &[u32], values: &mut [f64])
            write(kind: $crate::component::Type, references: &[u32], values: &[f64])
            force(reference: u32, how: $crate::component::Force)
            step(time: f64, size: f64)
            enter_events()
            leave_events()
            terminate()
        }
    };
    ([$($generics:tt)*] $type:ty, $self:ident => $target:expr, $($name:ident($($argument:ident: $of:ty),*))*) => {
        impl<$($generics)*> $crate::component::Component for $type {
            $(
                #[inline]
                fn $name(&mut $self $(, $argument: $of)*) -> anyhow::Result<()> {
                    $crate::component::Component::$name($target $(, $argument)*)
                }
            )*

            #[inline]
            fn update(&mut $self) -> anyhow::Result<$crate::component::Update> {
                $crate::component::Component::update($target)
            }

            fn any(&mut $self) -> Option<&mut dyn std::any::Any> {
                $crate::component::Component::any($target)
            }

            fn abreast<'abreast>(
                &'abreast mut $self,
                others: Vec<&'abreast mut dyn std::any::Any>,
                wiring: &$crate::component::Wiring,
            ) -> Option<Box<dyn $crate::component::Abreast + 'abreast>> {
                $crate::component::Component::abreast($target, others, wiring)
            }
        }
    };
}

forward_component!([C: Component + ?Sized] &mut C, self => &mut **self);
forward_component!([C: Component + ?Sized] Box<C>, self => &mut **self);

impl<C: Reset + ?Sized> Reset for Box<C> {
    fn reset(&mut self) -> Result<()> {
        (**self).reset()
    }
}
