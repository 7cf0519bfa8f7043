//! The FMU of a plant: of that in `plants/src` after which the package is named.

fmu::export!(plants::Plant<{ plants::place(env!("CARGO_PKG_NAME")) }>);
