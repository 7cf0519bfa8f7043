
/* The functions on a component with the states in which they are allowed: FMI 2.0, section 4.2.4, in its order. Two rows are
   more lenient because hosts need it: in state instantiated Get works and gives the start values, and inputs may be set. */

static const plcfmu_function_t plcfmu_functions[] = {
    {"fmi2SetDebugLogging", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2Instantiate", 0},
    {"fmi2SetupExperiment", PLCFMU_I},
    {"fmi2EnterInitializationMode", PLCFMU_I},
    {"fmi2ExitInitializationMode", PLCFMU_N},
    {"fmi2Terminate", PLCFMU_C},
    {"fmi2Reset", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetReal", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetInteger", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetBoolean", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetString", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SetReal", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetInteger", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetBoolean", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetString", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2GetFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SetFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2FreeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SerializedFMUstateSize", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SerializeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2DeSerializeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetDirectionalDerivative", PLCFMU_N | PLCFMU_C},
    {"fmi2SetRealInputDerivatives", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2GetRealOutputDerivatives", PLCFMU_C | PLCFMU_T},
    {"fmi2DoStep", PLCFMU_C},
    {"fmi2CancelStep", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetRealStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetIntegerStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetBooleanStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetStringStatus", PLCFMU_C | PLCFMU_T},
};

enum {
    PLCFMU_SET_DEBUG_LOGGING, PLCFMU_INSTANTIATE, PLCFMU_SETUP_EXPERIMENT, PLCFMU_ENTER_INITIALIZATION,
    PLCFMU_EXIT_INITIALIZATION, PLCFMU_TERMINATE, PLCFMU_RESET, PLCFMU_GET_REAL, PLCFMU_GET_INTEGER, PLCFMU_GET_BOOLEAN,
    PLCFMU_GET_STRING, PLCFMU_SET_REAL, PLCFMU_SET_INTEGER, PLCFMU_SET_BOOLEAN, PLCFMU_SET_STRING, PLCFMU_GET_STATE,
    PLCFMU_SET_STATE, PLCFMU_FREE_STATE, PLCFMU_SERIALIZED_SIZE, PLCFMU_SERIALIZE, PLCFMU_DESERIALIZE,
    PLCFMU_GET_DIRECTIONAL_DERIVATIVE, PLCFMU_SET_INPUT_DERIVATIVES, PLCFMU_GET_OUTPUT_DERIVATIVES, PLCFMU_DO_STEP,
    PLCFMU_CANCEL_STEP, PLCFMU_GET_STATUS, PLCFMU_GET_REAL_STATUS, PLCFMU_GET_INTEGER_STATUS, PLCFMU_GET_BOOLEAN_STATUS,
    PLCFMU_GET_STRING_STATUS
};

static const plcfmu_state_name_t plcfmu_state_names[] = {
    {PLCFMU_INSTANTIATED, "instantiated"}, {PLCFMU_INITIALIZATION, "Initialization Mode"},
    {PLCFMU_STEP_COMPLETE, "stepComplete"}, {PLCFMU_TERMINATED, "terminated"},
};
