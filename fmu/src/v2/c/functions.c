
/* --- The 34 functions of FMI 2.0 for co-simulation ----------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return "default"; }

const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component instance, fmi2Boolean on, size_t count, const fmi2String names[]) {
    PLCFMU_ANSWER(SetDebugLogging, plcfmu_set_debug_logging(c, on, count, names));
}

/* Checks the arguments for a new instance. */
static fmi2Status plcfmu_check_arguments(plcfmu_component_t *c, fmi2String name, fmi2Type type, fmi2String guid) {
    if (plcfmu_check_name(c, name) != fmi2OK) {
        return fmi2Error;
    }
    if (type != fmi2CoSimulation) {
        return plcfmu_say_no_simulation_of_this_type(&c->text, (int)type);
    }
    return plcfmu_begin(c, "fmuGUID", guid);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging_on) {
    plcfmu_component_t *c;
    (void)resources;
    (void)visible;
    if (callbacks == NULL || callbacks->logger == NULL) {
        return NULL;
    }
    c = plcfmu_make(name, callbacks->logger, callbacks->componentEnvironment);
    return c == NULL ? NULL : plcfmu_made(c, plcfmu_check_arguments(c, name, type, guid), logging_on);
}

void fmi2FreeInstance(fmi2Component instance) { plcfmu_free((plcfmu_component_t *)instance); }

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance;
    (void)tolerance;
    {
        PLCFMU_ANSWER(SetupExperiment, plcfmu_setup(c, start, has_stop, stop));
    }
}

static fmi2Status plcfmu_enter_initialization(plcfmu_component_t *c) {
    return c->instance.has_experiment ? plcfmu_go(c, PLCFMU_INITIALIZATION)
                                      : plcfmu_say_no_start_time(&c->text, "fmi2SetupExperiment");
}

fmi2Status fmi2EnterInitializationMode(fmi2Component instance) {
    PLCFMU_ANSWER(EnterInitializationMode, plcfmu_enter_initialization(c));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component instance) {
    PLCFMU_ANSWER(ExitInitializationMode, plcfmu_exit_initialization(c));
}

fmi2Status fmi2Terminate(fmi2Component instance) {
    PLCFMU_ANSWER(Terminate, plcfmu_go(c, PLCFMU_TERMINATED));
}

fmi2Status fmi2Reset(fmi2Component instance) {
    PLCFMU_ANSWER(Reset, plcfmu_reset(c));
}

/* --- Reading and writing variables: type 0 Real, 1 Integer, 2 Boolean. All can be accessed as Reals: TRUE is 1 */

static fmi2Status plcfmu_check_type(plcfmu_component_t *c, u32_t row, int of, const char *access) {
    return of == 0 && row < PLCFMU_ROWS ? fmi2OK : plcfmu_check(&c->text, row, of, access);
}

/* Advises the host, once, that a variable of a different type was read or written as a Real. */
static fmi2Status plcfmu_tell_conversion(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, int of) {
    size_t i;
    for (i = 0; of == 0 && i < count && !c->is_conversion_advised && (c->logged & PLCFMU_ADVICE); i += 1) {
        if (plcfmu_rows[vr[i]].type != 0) {
            plcfmu_say_counts_as_real(&c->text, plcfmu_rows[vr[i]].name, plcfmu_types[plcfmu_rows[vr[i]].type]);
            c->is_conversion_advised = 1;
        }
    }
    return fmi2OK;
}

static fmi2Status plcfmu_get(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, int of, void *values) {
    const plcfmu_block_t *block;
    size_t i;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, "vr") != fmi2OK
        || plcfmu_array(&c->text, values, count, of == 0 ? sizeof(fmi2Real) : sizeof(int), "value") != fmi2OK) {
        return fmi2Error;
    }
    for (i = 0; i < count; i += 1) {
        if (plcfmu_check_type(c, vr[i], of, "Get") != fmi2OK) {
            return fmi2Error;
        }
    }
    block = plcfmu_shown(c, plcfmu_walk(vr, count));
    for (i = 0; i < count; i += 1) {
        int kind = plcfmu_rows[vr[i]].kind;
        i64_t bits = plcfmu_bits_shown(c, block, vr[i]);
        if (of == 0) {
            ((fmi2Real *)values)[i] = kind == PLCFMU_DWORD ? (double)(i32_t)(u32_t)bits : plcfmu_number(kind, bits);
        } else {
            /* The 16 bits of a WORD and the 32 bits of a DWORD are read as signed integers. */
            ((int *)values)[i] = kind == PLCFMU_WORD ? (i16_t)(u16_t)bits : (i32_t)(u32_t)bits;
        }
    }
    return plcfmu_tell_conversion(c, vr, count, of);
}

/* The value that the host passed for a variable, as a number. */
static double plcfmu_given(const void *values, size_t i, int of) {
    if (of == 0) {
        return ((const fmi2Real *)values)[i];
    }
    return of == 1 ? (double)((const int *)values)[i] : ((const int *)values)[i] != 0 ? 1.0 : 0.0;
}

static fmi2Status plcfmu_set(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, int of, const void *values) {
    i64_t bits;
    size_t i;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, "vr") != fmi2OK
        || plcfmu_array(&c->text, values, count, of == 0 ? sizeof(fmi2Real) : sizeof(int), "value") != fmi2OK) {
        return fmi2Error;
    }
    for (i = 0; i < count; i += 1) {
        const char *range;
        if (plcfmu_check_type(c, vr[i], of, "Set") != fmi2OK || plcfmu_may_set(c, vr[i]) != fmi2OK) {
            return fmi2Error;
        }
        range = plcfmu_bits_of(plcfmu_given(values, i, of), plcfmu_rows[vr[i]].kind, &bits);
        if (range != NULL) {
            plcfmu_text_t value = {0, {0}};
            plcfmu_say_number(&value, plcfmu_given(values, i, of), of != 0);
            return plcfmu_say_out_of_range(&c->text, plcfmu_rows[vr[i]].name, value.text, range);
        }
    }
    for (i = 0; i < count; i += 1) {
        plcfmu_put_number(&c->instance.block, vr[i], plcfmu_given(values, i, of));
    }
    return plcfmu_tell_conversion(c, vr, count, of);
}

/* The address of a REAL that needs no further checks to be read or, if `is_set`, to be set; NULL for anything else. */
static char *plcfmu_real(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, const fmi2Real value[], int is_set) {
    const plcfmu_row_t *row;
    if (c == NULL || c->instance.state != PLCFMU_STEP_COMPLETE || count != 1 || vr == NULL || value == NULL
        || vr[0] >= PLCFMU_ROWS) {
        return NULL;
    }
    row = &plcfmu_rows[vr[0]];
    if (row->kind != PLCFMU_REAL || row->held != 0
        || (is_set && row->role != PLCFMU_INPUT && row->role != PLCFMU_PARAMETER)) {
        return NULL;
    }
    return (char *)&c->instance.block.memory + row->offset;
}

PLCFMU_APART static fmi2Status plcfmu_get_reals(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                                fmi2Real value[]) {
    PLCFMU_ANSWER(GetReal, plcfmu_get(c, vr, count, 0, value));
}

fmi2Status fmi2GetReal(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)instance;
    const char *real = plcfmu_real(c, vr, count, value, 0);
    if (real != NULL) {
        float number;
        memcpy(&number, real, sizeof number);
        value[0] = (double)number;
        return fmi2OK;
    }
    return plcfmu_get_reals(instance, vr, count, value);
}

fmi2Status fmi2GetInteger(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2Integer value[]) {
    PLCFMU_ANSWER(GetInteger, plcfmu_get(c, vr, count, 1, value));
}

fmi2Status fmi2GetBoolean(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2Boolean value[]) {
    PLCFMU_ANSWER(GetBoolean, plcfmu_get(c, vr, count, 2, value));
}

fmi2Status fmi2GetString(fmi2Component instance, const fmi2ValueReference vr[], size_t count, fmi2String value[]) {
    PLCFMU_ANSWER(GetString, plcfmu_get_strings(c, vr, count, value));
}

PLCFMU_APART static fmi2Status plcfmu_set_reals(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                                const fmi2Real value[]) {
    PLCFMU_ANSWER(SetReal, plcfmu_set(c, vr, count, 0, value));
}

fmi2Status fmi2SetReal(fmi2Component instance, const fmi2ValueReference vr[], size_t count, const fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)instance;
    char *real = plcfmu_real(c, vr, count, value, 1);
    if (real != NULL && plcfmu_abs_f64(value[0]) < PLCFMU_REAL_END) {
        float number = (float)value[0];
        memcpy(real, &number, sizeof number);
        return fmi2OK;
    }
    return plcfmu_set_reals(instance, vr, count, value);
}

fmi2Status fmi2SetInteger(fmi2Component instance, const fmi2ValueReference vr[], size_t count, const fmi2Integer value[]) {
    PLCFMU_ANSWER(SetInteger, plcfmu_set(c, vr, count, 1, value));
}

fmi2Status fmi2SetBoolean(fmi2Component instance, const fmi2ValueReference vr[], size_t count, const fmi2Boolean value[]) {
    PLCFMU_ANSWER(SetBoolean, plcfmu_set(c, vr, count, 2, value));
}

fmi2Status fmi2SetString(fmi2Component instance, const fmi2ValueReference vr[], size_t count, const fmi2String value[]) {
    PLCFMU_ANSWER(SetString, plcfmu_set_strings(c, vr, count, value));
}

fmi2Status fmi2GetFMUstate(fmi2Component instance, fmi2FMUstate *state) {
    PLCFMU_ANSWER(GetFMUstate, plcfmu_get_state(c, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component instance, fmi2FMUstate state) {
    PLCFMU_ANSWER(SetFMUstate, plcfmu_set_state(c, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component instance, fmi2FMUstate *state) {
    PLCFMU_ANSWER(FreeFMUstate, plcfmu_drop_state(c, state));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component instance, fmi2FMUstate state, size_t *size) {
    PLCFMU_ANSWER(SerializedFMUstateSize, plcfmu_size_of_state(c, state, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component instance, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    PLCFMU_ANSWER(SerializeFMUstate, plcfmu_serialize_state(c, state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component instance, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    PLCFMU_ANSWER(DeSerializeFMUstate, plcfmu_deserialize_state(c, bytes, size, state));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real known_changes[],
                                        fmi2Real unknown_changes[]) {
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)known_changes, (void)unknown_changes;
    {
        PLCFMU_ANSWER(GetDirectionalDerivative, plcfmu_say_not_provided(&c->text, "providesDirectionalDerivative"));
    }
}

/* The extrapolation of an input; adds one if the input has none. */
static plcfmu_extrapolation_t *plcfmu_extrapolation(plcfmu_instance_t *instance, u32_t row) {
    size_t i;
    for (i = 0; i < instance->extrapolated; i += 1) {
        if (instance->extrapolations[i].row == row) {
            return &instance->extrapolations[i];
        }
    }
    memset(&instance->extrapolations[i], 0, sizeof instance->extrapolations[i]);
    instance->extrapolations[i].row = row;
    instance->extrapolated += 1;
    return &instance->extrapolations[i];
}

static int plcfmu_is_extrapolated(const plcfmu_extrapolation_t *input) {
    int order, is = 0;
    for (order = 0; order < PLCFMU_ORDERS; order += 1) {
        is |= !(input->derivatives[order] == 0.0);
    }
    return is;
}

/* Sets derivatives: in all subsequent steps, the program sees the inputs extrapolated from the start of the step. 0
   removes a derivative. */
static fmi2Status plcfmu_set_derivatives(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count,
                                         const fmi2Integer order[], const fmi2Real value[]) {
    plcfmu_instance_t *instance = &c->instance;
    size_t i, kept = 0;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, "vr") != fmi2OK
        || plcfmu_array(&c->text, order, count, sizeof *order, "order") != fmi2OK
        || plcfmu_array(&c->text, value, count, sizeof *value, "value") != fmi2OK) {
        return fmi2Error;
    }
    for (i = 0; i < count; i += 1) {
        const plcfmu_row_t *row;
        if (plcfmu_check(&c->text, vr[i], 0, "Set") != fmi2OK) {
            return fmi2Error;
        }
        row = &plcfmu_rows[vr[i]];
        if (row->role != PLCFMU_INPUT || (row->kind != PLCFMU_REAL && row->kind != PLCFMU_LREAL)) {
            return plcfmu_say_no_real_input(&c->text, row->name);
        }
        if (order[i] < 1 || order[i] > PLCFMU_ORDERS) {
            return plcfmu_say_wrong_order(&c->text, row->name, order[i]);
        }
        if (!(plcfmu_abs_f64(value[i]) <= 1.7976931348623157e308)) {
            return plcfmu_say_endless_derivative(&c->text, row->name, value[i]);
        }
    }
    for (i = 0; i < count; i += 1) {
        plcfmu_extrapolation(instance, vr[i])->derivatives[order[i] - 1] = value[i];
    }
    for (i = 0; i < instance->extrapolated; i += 1) {
        if (plcfmu_is_extrapolated(&instance->extrapolations[i])) {
            instance->extrapolations[kept] = instance->extrapolations[i];
            kept += 1;
        }
    }
    instance->extrapolated = kept;
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    PLCFMU_ANSWER(SetRealInputDerivatives, plcfmu_set_derivatives(c, vr, count, order, value));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[]) {
    (void)vr, (void)order, (void)value;
    {
        PLCFMU_ANSWER(GetRealOutputDerivatives, count == 0 ? fmi2OK : plcfmu_say_no_output_derivatives(&c->text));
    }
}

PLCFMU_APART static fmi2Status plcfmu_do_step(plcfmu_component_t *c, double tc, double h) {
    fmi2Status status = plcfmu_step(c, tc, h);
    if (status == fmi2OK) {
        plcfmu_advise(c, h);
    }
    return status;
}

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real tc, fmi2Real h, fmi2Boolean no_set_state_prior) {
    (void)no_set_state_prior;
    {
        PLCFMU_ANSWER(DoStep, plcfmu_is_ordinary_step(c, tc, h) ? plcfmu_check_running(c) : plcfmu_do_step(c, tc, h));
    }
}

fmi2Status fmi2CancelStep(fmi2Component instance) {
    PLCFMU_ANSWER(CancelStep, plcfmu_say_nothing_to_cancel(&c->text));
}

/* Refuses a status kind that a function cannot answer, such as fmi2DoStepStatus or fmi2PendingStatus, which apply only
   while a step is pending. */
static fmi2Status plcfmu_no_status(plcfmu_component_t *c, int kind, const void *value) {
    if (plcfmu_target(&c->text, value, "value") != fmi2OK) {
        return fmi2Error;
    }
    plcfmu_say_no_status(&c->text, kind);
    return fmi2Discard;
}

fmi2Status fmi2GetStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Status *value) {
    PLCFMU_ANSWER(GetStatus, plcfmu_no_status(c, (int)kind, value));
}

static fmi2Status plcfmu_get_real_status(plcfmu_component_t *c, int kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime || value == NULL) {
        return plcfmu_no_status(c, kind, value);
    }
    *value = c->instance.clock.end;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Real *value) {
    PLCFMU_ANSWER(GetRealStatus, plcfmu_get_real_status(c, (int)kind, value));
}

fmi2Status fmi2GetIntegerStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Integer *value) {
    PLCFMU_ANSWER(GetIntegerStatus, plcfmu_no_status(c, (int)kind, value));
}

/* A program never ends the simulation. */
static fmi2Status plcfmu_get_boolean_status(plcfmu_component_t *c, int kind, fmi2Boolean *value) {
    if (kind != fmi2Terminated || value == NULL) {
        return plcfmu_no_status(c, kind, value);
    }
    *value = 0;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Boolean *value) {
    PLCFMU_ANSWER(GetBooleanStatus, plcfmu_get_boolean_status(c, (int)kind, value));
}

fmi2Status fmi2GetStringStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2String *value) {
    PLCFMU_ANSWER(GetStringStatus, plcfmu_no_status(c, (int)kind, value));
}
