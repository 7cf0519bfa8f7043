//! The engine's interface to an FMU: an instance that can be initialized, set, stepped and read, regardless of its
//! implementation.

use anyhow::{Result, bail};
pub use modeldescription::Type;
use std::any::Any;
use std::error::Error;
use std::fmt;
use std::ops::Range;

/// The FMU ended the simulation during a step. This is not a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminated;

impl fmt::Display for Terminated {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("the FMU ended the simulation")
    }
}

impl Error for Terminated {}

/// The maximum number of updates per event; an FMU that needs more is faulty.
pub const MOST_UPDATES: usize = 100;

/// The result of updating an FMU's discrete states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Whether another update is needed.
    pub is_needed: bool,
    /// The time of its next event in seconds, if known.
    pub next: Option<f64>,
}

/// The sources and targets of a member's values. The wiring depends only on the plan and is computed once, so that a
/// step only has to move values.
#[derive(Debug)]
pub struct Wiring {
    /// The range of the member's values among the run's values.
    pub own: Range<usize>,
    /// The variables that other members read or that are recorded, by type.
    pub read: Vec<Read>,
    /// The connected inputs, by type.
    pub written: Vec<Written>,
}

/// Variables of one type, read by one call.
#[derive(Debug)]
pub struct Read {
    /// Their type.
    pub kind: Type,
    /// Their value references.
    pub references: Vec<u32>,
    /// The range of their values among the run's values.
    pub places: Range<usize>,
}

/// Inputs of one type, written by one call.
#[derive(Debug)]
pub struct Written {
    /// Their type.
    pub kind: Type,
    /// Their value references.
    pub references: Vec<u32>,
    /// The positions of their sources among the run's values.
    pub sources: Vec<usize>,
    /// The positions in this group of the inputs whose values must be converted, with the types of their sources.
    pub converted: Vec<(usize, Type)>,
    /// The values to write; a buffer reused in each step.
    pub values: Vec<f64>,
    /// The source values last written, before conversion; updated only for a member called in Event Mode.
    pub seen: Vec<f64>,
}

/// How a variable is overwritten, even if the FMU computes it or it is connected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Force {
    /// Set it once, now.
    Once(f64),
    /// Keep it at this value from now on, by setting it before and after each step.
    Always(f64),
    /// Stop keeping it at a value.
    Release,
}

/// An instance of an FMU, as needed by a run.
pub trait Component {
    /// Sets the start of the simulation in seconds, and its end if known.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()>;
    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn enter_initialization(&mut self) -> Result<()>;
    /// Exits Initialization Mode.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn exit_initialization(&mut self) -> Result<()>;
    /// Reads variables of one type as cells (see [`Type::cell`]); true is 1.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()>;
    /// Writes variables of one type from cells (see [`Type::cell`]); true is 1.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()>;
    /// Overwrites a variable of any kind, which the interface of an FMU does not allow.
    ///
    /// # Errors
    /// The component can be accessed only through the FMI interface.
    fn force(&mut self, _reference: u32, _how: Force) -> Result<()> {
        bail!(
            "FMI does not allow variables to be forced: to force those of a program, open its sources instead of its FMU"
        )
    }
    /// Steps from `time` to `time + size`, in seconds.
    ///
    /// # Errors
    /// The FMU rejects the call, or [`Terminated`].
    fn step(&mut self, time: f64, size: f64) -> Result<()>;
    /// Enters Event Mode unless it is already active. This and the next two functions are called only for members that
    /// use Event Mode.
    ///
    /// # Errors
    /// The FMU rejects the call or has no Event Mode.
    fn enter_events(&mut self) -> Result<()> {
        bail!("it has no Event Mode")
    }
    /// Applies the inputs in Event Mode and handles due events.
    ///
    /// # Errors
    /// The FMU rejects the call, or [`Terminated`].
    fn update(&mut self) -> Result<Update> {
        bail!("it has no Event Mode")
    }
    /// Leaves Event Mode before the next step.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn leave_events(&mut self) -> Result<()> {
        bail!("it has no Event Mode")
    }
    /// This component, to be combined with those of other runs and stepped side by side; `None`, the default, if it
    /// does not support that.
    fn side(&mut self) -> Option<Side<'_>> {
        None
    }
    /// Ends the simulation.
    ///
    /// # Errors
    /// The FMU rejects the call.
    fn terminate(&mut self) -> Result<()>;
}

/// A component and the function that combines it with others.
pub struct Side<'a> {
    /// The component.
    pub component: &'a mut dyn Any,
    /// Combines it with the components of the other runs.
    pub combine: Combine,
}

/// Combines components of one kind, one from each of several runs, so that they perform ordinary steps side by side;
/// `None` if that is not possible.
pub type Combine = for<'a> fn(Vec<&'a mut dyn Any>, &Wiring) -> Option<Box<dyn Abreast + 'a>>;

/// A member from each of several runs, stepped side by side.
pub trait Abreast {
    /// Whether this step can fail only because of an input value.
    fn is_ordinary(&self, time: f64, size: f64) -> bool;
    /// Writes the connected inputs, performs an ordinary step, and reads the values that other members need, for all
    /// runs. For each position in a run's values, `values` has one value per run. Returns false if a value is refused,
    /// in which case only inputs were written.
    fn cycle(&mut self, values: &mut [f64], time: f64, size: f64) -> bool;
    /// Writes the resulting states back to the components.
    fn end(self: Box<Self>);
}

/// An instance that can be reused for further simulations.
pub trait Reset: Component {
    /// Resets the instance to its initial state.
    ///
    /// # Errors
    /// The FMU rejects the call; a new instance is then required.
    fn reset(&mut self) -> Result<()>;
}

/// Implements [`Component`](crate::component::Component) for a type by forwarding each call:
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

            fn side(&mut $self) -> Option<$crate::component::Side<'_>> {
                $crate::component::Component::side($target)
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
