//! What the FMUs can do, as `<CoSimulation>` in modelDescription.xml says it.

/// The attributes and their values. Those that are left out, such as `needsExecutionTool`, are false.
pub const ALL: &[(&str, &str)] = &[
    // The clock makes the calls that fall into a step, whatever its size.
    ("canHandleVariableCommunicationStepSize", "true"),
    // The session extrapolates inputs. Outputs change in steps.
    ("canInterpolateInputs", "true"),
    ("maxOutputDerivativeOrder", "0"),
    ("providesDirectionalDerivative", "false"),
    // A state is a copy of the instance.
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
    // No globals, no threads, memory of our own.
    ("canRunAsynchronuously", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canNotUseMemoryManagementFunctions", "true"),
];
