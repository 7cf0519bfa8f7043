//! Parses, checks and runs PLC programs in SCL as S7-300, S7-400, S7-1200 and S7-1500 execute them.

mod assume;
mod compile;
mod compiler;
mod constant;
mod copies;
mod declare;
mod format;
mod ladder;
mod lexer;
mod library;
mod lint;
mod lower;
mod network;
mod overlap;
mod parser;
mod report;
mod root;
mod simatic_ml;
mod simatic_sd;
mod start;
mod syntax;
mod system_memory;
mod types;
mod undeclared;

pub mod c;
pub mod interface;
pub mod machine;
pub mod program;
pub mod prove;
pub mod random;
pub mod scl;
pub mod watch;

pub use assume::Assumption;
pub use compile::{Compiled, Survey, assume, assumed, compile, compile_watched, survey};
pub use compiler::Note;
pub use manifest::{Cpu, Manifest as Options, Task};
pub use root::Root;
pub use syntax::BlockKind;
