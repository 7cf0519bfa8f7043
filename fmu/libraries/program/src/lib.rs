//! The library in the FMU of every PLC program: it reads the program from the FMU's resources.

fmu::export!(functions program::Program);
