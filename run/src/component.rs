//! What the engine needs of an FMU: an instance that it can initialize, set, step and read, whatever is behind it.

use anyhow::Result;
pub use modeldescription::Type;

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
    /// Reads variables of one type; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()>;
    /// Writes variables of one type; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()>;
    /// Steps from `time` to `time + size`, in seconds.
    ///
    /// # Errors
    /// The FMU refuses.
    fn step(&mut self, time: f64, size: f64) -> Result<()>;
    /// Ends the simulation.
    ///
    /// # Errors
    /// The FMU refuses.
    fn terminate(&mut self) -> Result<()>;
}

/// An instance that can be used for one simulation after the other.
pub trait Reset: Component {
    /// Makes it as new.
    ///
    /// # Errors
    /// The FMU refuses; then only a new instance can go on.
    fn reset(&mut self) -> Result<()>;
}

impl<C: Component + ?Sized> Component for &mut C {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        (**self).setup(start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        (**self).enter_initialization()
    }

    fn exit_initialization(&mut self) -> Result<()> {
        (**self).exit_initialization()
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        (**self).read(kind, references, values)
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        (**self).write(kind, references, values)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        (**self).step(time, size)
    }

    fn terminate(&mut self) -> Result<()> {
        (**self).terminate()
    }
}

impl<C: Component + ?Sized> Component for Box<C> {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        (**self).setup(start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        (**self).enter_initialization()
    }

    fn exit_initialization(&mut self) -> Result<()> {
        (**self).exit_initialization()
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        (**self).read(kind, references, values)
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        (**self).write(kind, references, values)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        (**self).step(time, size)
    }

    fn terminate(&mut self) -> Result<()> {
        (**self).terminate()
    }
}

impl<C: Reset + ?Sized> Reset for Box<C> {
    fn reset(&mut self) -> Result<()> {
        (**self).reset()
    }
}
