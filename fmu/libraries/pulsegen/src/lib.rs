//! PULSEGEN (FB 43) as an FMU.

fmu::export!(blocks::Pulsegen);
