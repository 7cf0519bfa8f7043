
/* The functions on a component with the states in which they are allowed: FMI 3.0, sections 2.3 and 4.2. It is more lenient where
   hosts need it: in state instantiated Get works and gives the start values, and inputs may be set; in Step Mode discrete inputs
   may be set with Event Mode, too. */
#define PLCFMU_ANY (PLCFMU_I | PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)
#define PLCFMU_SETTABLE (PLCFMU_I | PLCFMU_N | PLCFMU_E | PLCFMU_C)
#define PLCFMU_FUNCTIONS(F) \
    F(SetDebugLogging, PLCFMU_ANY)                                                              \
    F(InstantiateModelExchange, 0)                                                              \
    F(InstantiateCoSimulation, 0)                                                               \
    F(InstantiateScheduledExecution, 0)                                                         \
    F(EnterInitializationMode, PLCFMU_I)                                                        \
    F(ExitInitializationMode, PLCFMU_N)                                                         \
    F(EnterEventMode, PLCFMU_C)                                                                 \
    F(Terminate, PLCFMU_N | PLCFMU_E | PLCFMU_C)                                                \
    F(Reset, PLCFMU_ANY)                                                                        \
    F(GetFloat32, PLCFMU_ANY)                                                                   \
    F(GetFloat64, PLCFMU_ANY)                                                                   \
    F(GetInt8, PLCFMU_ANY)                                                                      \
    F(GetUInt8, PLCFMU_ANY)                                                                     \
    F(GetInt16, PLCFMU_ANY)                                                                     \
    F(GetUInt16, PLCFMU_ANY)                                                                    \
    F(GetInt32, PLCFMU_ANY)                                                                     \
    F(GetUInt32, PLCFMU_ANY)                                                                    \
    F(GetInt64, PLCFMU_ANY)                                                                     \
    F(GetUInt64, PLCFMU_ANY)                                                                    \
    F(GetBoolean, PLCFMU_ANY)                                                                   \
    F(GetString, PLCFMU_ANY)                                                                    \
    F(GetBinary, PLCFMU_ANY)                                                                    \
    F(GetClock, PLCFMU_ANY)                                                                     \
    F(SetFloat32, PLCFMU_SETTABLE)                                                              \
    F(SetFloat64, PLCFMU_SETTABLE)                                                              \
    F(SetInt8, PLCFMU_SETTABLE)                                                                 \
    F(SetUInt8, PLCFMU_SETTABLE)                                                                \
    F(SetInt16, PLCFMU_SETTABLE)                                                                \
    F(SetUInt16, PLCFMU_SETTABLE)                                                               \
    F(SetInt32, PLCFMU_SETTABLE)                                                                \
    F(SetUInt32, PLCFMU_SETTABLE)                                                               \
    F(SetInt64, PLCFMU_SETTABLE)                                                                \
    F(SetUInt64, PLCFMU_SETTABLE)                                                               \
    F(SetBoolean, PLCFMU_SETTABLE)                                                              \
    F(SetString, PLCFMU_SETTABLE)                                                               \
    F(SetBinary, PLCFMU_SETTABLE)                                                               \
    F(SetClock, PLCFMU_SETTABLE)                                                                \
    F(GetNumberOfVariableDependencies, PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)               \
    F(GetVariableDependencies, PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)                       \
    F(GetFMUState, PLCFMU_ANY)                                                                  \
    F(SetFMUState, PLCFMU_ANY)                                                                  \
    F(FreeFMUState, PLCFMU_ANY)                                                                 \
    F(SerializedFMUStateSize, PLCFMU_ANY)                                                       \
    F(SerializeFMUState, PLCFMU_ANY)                                                            \
    F(DeserializeFMUState, PLCFMU_ANY)                                                          \
    F(GetDirectionalDerivative, PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)                      \
    F(GetAdjointDerivative, PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)                          \
    F(EnterConfigurationMode, PLCFMU_I | PLCFMU_E | PLCFMU_C)                                   \
    F(ExitConfigurationMode, PLCFMU_ANY)                                                        \
    F(GetIntervalDecimal, PLCFMU_ANY)                                                           \
    F(GetIntervalFraction, PLCFMU_ANY)                                                          \
    F(GetShiftDecimal, PLCFMU_ANY)                                                              \
    F(GetShiftFraction, PLCFMU_ANY)                                                             \
    F(SetIntervalDecimal, PLCFMU_ANY)                                                           \
    F(SetIntervalFraction, PLCFMU_ANY)                                                          \
    F(SetShiftDecimal, PLCFMU_ANY)                                                              \
    F(SetShiftFraction, PLCFMU_ANY)                                                             \
    F(EvaluateDiscreteStates, PLCFMU_N | PLCFMU_E)                                              \
    F(UpdateDiscreteStates, PLCFMU_E)                                                           \
    F(EnterContinuousTimeMode, PLCFMU_ANY)                                                      \
    F(CompletedIntegratorStep, PLCFMU_ANY)                                                      \
    F(SetTime, PLCFMU_ANY)                                                                      \
    F(SetContinuousStates, PLCFMU_ANY)                                                          \
    F(GetContinuousStateDerivatives, PLCFMU_ANY)                                                \
    F(GetEventIndicators, PLCFMU_ANY)                                                           \
    F(GetContinuousStates, PLCFMU_ANY)                                                          \
    F(GetNominalsOfContinuousStates, PLCFMU_ANY)                                                \
    F(GetNumberOfEventIndicators, PLCFMU_ANY)                                                   \
    F(GetNumberOfContinuousStates, PLCFMU_ANY)                                                  \
    F(EnterStepMode, PLCFMU_E)                                                                  \
    F(GetOutputDerivatives, PLCFMU_C | PLCFMU_T)                                                \
    F(DoStep, PLCFMU_C)                                                                         \
    F(ActivateModelPartition, PLCFMU_ANY)

#define PLCFMU_FUNCTION(name, states) {"fmi3" #name, states},
static const plcfmu_function_t plcfmu_functions[] = {PLCFMU_FUNCTIONS(PLCFMU_FUNCTION)};

#define PLCFMU_NUMBER(name, states) PLCFMU_OF_##name,
enum { PLCFMU_FUNCTIONS(PLCFMU_NUMBER) PLCFMU_FUNCTION_COUNT };
#define PLCFMU_INSTANTIATE PLCFMU_OF_InstantiateCoSimulation

static const plcfmu_state_name_t plcfmu_state_names[] = {
    {PLCFMU_INSTANTIATED, "instantiated"}, {PLCFMU_INITIALIZATION, "Initialization Mode"}, {PLCFMU_EVENT_MODE, "Event Mode"},
    {PLCFMU_STEP_COMPLETE, "Step Mode"}, {PLCFMU_TERMINATED, "terminated"},
};
