//! CONT_S (FB 42) as an FMU.

fmu::export!(blocks::ContS);
