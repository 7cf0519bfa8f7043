//! Builds libraries from sources.

pub mod c;
pub mod compile;
pub mod platform;
pub mod template;
pub mod universal;
pub mod workspace;
pub mod zig;
