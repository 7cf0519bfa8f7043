//! SENSOR as an FMU: `plants/src/sensor.rs`.

fmu::export!(plants::Sensor);
