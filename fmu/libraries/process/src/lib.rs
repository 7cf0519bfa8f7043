//! PROCESS as an FMU: `plants/src/process.rs`.

fmu::export!(plants::Process);
