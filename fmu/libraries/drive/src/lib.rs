//! DRIVE as an FMU: `plants/src/drive.rs`.

fmu::export!(plants::Drive);
