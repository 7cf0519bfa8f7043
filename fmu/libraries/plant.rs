//! The FMU of the plant in `plants/src` after which the package is named.

fmu::export!(plants::Plant<{ plants::place(env!("CARGO_PKG_NAME")) }>);
