//! THERMO as an FMU: `plants/src/thermo.rs`.

fmu::export!(plants::Thermo);
