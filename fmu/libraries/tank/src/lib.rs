//! TANK as an FMU: `plants/src/tank.rs`.

fmu::export!(plants::Tank);
