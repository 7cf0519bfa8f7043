//! PULS_CTR as an FMU.

fmu::export!(blocks::PulsCtr);
