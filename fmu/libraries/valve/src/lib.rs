//! VALVE as an FMU: `plants/src/valve.rs`.

fmu::export!(plants::Valve);
