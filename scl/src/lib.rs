//! Parses, checks and runs PLC programs in SCL, LAD and FBD as S7-300, S7-400, S7-1200 and S7-1500 execute them. The
//! README describes the path of a program through the folders.

mod check;
mod compile;
mod front;
mod ladder;
mod library;
mod lower;
mod print;
mod report;

pub mod c;
pub mod ir;
pub mod machine;
pub mod prove;
pub mod random;
pub mod watch;

pub use check::compiler::Note;
pub use compile::assume::Assumption;
pub use compile::root::Root;
pub use compile::{Compiled, Survey, assume, assumed, compile, compile_watched, interface, survey};
pub use front::syntax::BlockKind;
pub use manifest::{Cpu, Manifest as Options, Task};
pub use print::{Dialect, print};
