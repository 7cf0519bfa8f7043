//! HEATER as an FMU: `plants/src/heater.rs`.

fmu::export!(plants::Heater);
