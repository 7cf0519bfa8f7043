//! CONT_C (FB 41) as an FMU.

fmu::export!(blocks::ContC);
