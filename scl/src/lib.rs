//! PLC programs in SCL, as S7-300, S7-400, S7-1200 and S7-1500 execute them: read, checked, and run.

mod lexer;
mod parser;
mod report;
mod syntax;

pub mod program;
