//! HLG as an FMU.

fmu::export!(blocks::Hlg);
