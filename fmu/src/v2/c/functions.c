
/* --- The 34 functions of FMI 2.0 for co-simulation ----------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return "default"; }

const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String names[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_DEBUG_LOGGING);
    status = status == fmi2OK ? plcfmu_set_debug_logging(c, on, count, names) : status;
    return plcfmu_leave(c, PLCFMU_SET_DEBUG_LOGGING, status);
}

/* Why there is no instance. */
static fmi2Status plcfmu_check_arguments(plcfmu_component_t *c, fmi2String name, fmi2Type type, fmi2String guid) {
    if (plcfmu_check_name(c, name) != fmi2OK) {
        return fmi2Error;
    }
    if (type != fmi2CoSimulation) {
        plcfmu_say(&c->text, "fmuType = ");
        plcfmu_say_whole(&c->text, (i64_t)(int)type);
        return plcfmu_refuse(&c->text, ": this FMU is for co-simulation (1) only");
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

void fmi2FreeInstance(fmi2Component component) { plcfmu_free((plcfmu_component_t *)component); }

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SETUP_EXPERIMENT);
    (void)has_tolerance;
    (void)tolerance;
    status = status == fmi2OK ? plcfmu_setup(c, start, has_stop, stop) : status;
    return plcfmu_leave(c, PLCFMU_SETUP_EXPERIMENT, status);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_ENTER_INITIALIZATION);
    if (status == fmi2OK && !c->instance.has_experiment) {
        status = plcfmu_refuse(&c->text, "the start time is unknown: call fmi2SetupExperiment first");
    } else if (status == fmi2OK) {
        c->instance.state = PLCFMU_INITIALIZATION;
    }
    return plcfmu_leave(c, PLCFMU_ENTER_INITIALIZATION, status);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_EXIT_INITIALIZATION);
    status = status == fmi2OK ? plcfmu_exit_initialization(c) : status;
    return plcfmu_leave(c, PLCFMU_EXIT_INITIALIZATION, status);
}

fmi2Status fmi2Terminate(fmi2Component component) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_TERMINATE);
    if (status == fmi2OK) {
        c->instance.state = PLCFMU_TERMINATED;
    }
    return plcfmu_leave(c, PLCFMU_TERMINATE, status);
}

fmi2Status fmi2Reset(fmi2Component component) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_RESET);
    if (status == fmi2OK) {
        plcfmu_fresh(c);
    }
    return plcfmu_leave(c, PLCFMU_RESET, status);
}

/* --- Reading and writing variables: of type 0 Real, 1 Integer, 2 Boolean. As Reals, there are all of them: TRUE is 1 */

static fmi2Status plcfmu_check_type(plcfmu_component_t *c, u32_t row, int of, const char *access) {
    return of == 0 && row < PLCFMU_ROWS ? fmi2OK : plcfmu_check(&c->text, row, of, access);
}

/* Says once that a variable of another type was read or written as a Real. */
static fmi2Status plcfmu_tell_conversion(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count, int of) {
    size_t i;
    for (i = 0; of == 0 && i < count && !c->is_conversion_advised && (c->logged & PLCFMU_ADVICE); i += 1) {
        if (plcfmu_rows[vr[i]].type != 0) {
            plcfmu_say(&c->text, plcfmu_rows[vr[i]].name);
            plcfmu_say(&c->text, " is ");
            plcfmu_say(&c->text, plcfmu_types[plcfmu_rows[vr[i]].type]);
            plcfmu_say(&c->text, ", and counts as a Real here (TRUE is 1)");
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
            /* A WORD is the integer of its 16 bits with sign, a DWORD that of its 32 bits. */
            ((int *)values)[i] = kind == PLCFMU_WORD ? (i16_t)(u16_t)bits : (i32_t)(u32_t)bits;
        }
    }
    return plcfmu_tell_conversion(c, vr, count, of);
}

/* The number that a host gives for a variable. */
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
            plcfmu_say(&c->text, plcfmu_rows[vr[i]].name);
            plcfmu_say(&c->text, " = ");
            plcfmu_say_number(&c->text, plcfmu_given(values, i, of), of != 0);
            plcfmu_say(&c->text, ": ");
            return plcfmu_refuse(&c->text, range);
        }
    }
    for (i = 0; i < count; i += 1) {
        plcfmu_put_number(&c->instance.block, vr[i], plcfmu_given(values, i, of));
    }
    return plcfmu_tell_conversion(c, vr, count, of);
}

/* The REAL in the memory that a host may read, or set, in a control cycle without any check; NULL of anything else. */
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

PLCFMU_APART static fmi2Status plcfmu_get_reals(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count,
                                                fmi2Real value[]) {
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_REAL);
    status = status == fmi2OK ? plcfmu_get(c, vr, count, 0, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_REAL, status);
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    const char *real = plcfmu_real(c, vr, count, value, 0);
    if (real != NULL) {
        float number;
        memcpy(&number, real, sizeof number);
        value[0] = (double)number;
        return fmi2OK;
    }
    return plcfmu_get_reals(c, vr, count, value);
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Integer value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_INTEGER);
    status = status == fmi2OK ? plcfmu_get(c, vr, count, 1, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_INTEGER, status);
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Boolean value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_BOOLEAN);
    status = status == fmi2OK ? plcfmu_get(c, vr, count, 2, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_BOOLEAN, status);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2String value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_STRING);
    status = status == fmi2OK ? plcfmu_get_strings(c, vr, count, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_STRING, status);
}

PLCFMU_APART static fmi2Status plcfmu_set_reals(plcfmu_component_t *c, const fmi2ValueReference vr[], size_t count,
                                                const fmi2Real value[]) {
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_REAL);
    status = status == fmi2OK ? plcfmu_set(c, vr, count, 0, value) : status;
    return plcfmu_leave(c, PLCFMU_SET_REAL, status);
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    char *real = plcfmu_real(c, vr, count, value, 1);
    if (real != NULL && plcfmu_abs_f64(value[0]) < PLCFMU_REAL_END) {
        float number = (float)value[0];
        memcpy(real, &number, sizeof number);
        return fmi2OK;
    }
    return plcfmu_set_reals(c, vr, count, value);
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Integer value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_INTEGER);
    status = status == fmi2OK ? plcfmu_set(c, vr, count, 1, value) : status;
    return plcfmu_leave(c, PLCFMU_SET_INTEGER, status);
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Boolean value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_BOOLEAN);
    status = status == fmi2OK ? plcfmu_set(c, vr, count, 2, value) : status;
    return plcfmu_leave(c, PLCFMU_SET_BOOLEAN, status);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2String value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_STRING);
    status = status == fmi2OK ? plcfmu_set_strings(c, vr, count, value) : status;
    return plcfmu_leave(c, PLCFMU_SET_STRING, status);
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_STATE);
    status = status == fmi2OK ? plcfmu_get_state(c, state) : status;
    return plcfmu_leave(c, PLCFMU_GET_STATE, status);
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_STATE);
    status = status == fmi2OK ? plcfmu_set_state(c, state) : status;
    return plcfmu_leave(c, PLCFMU_SET_STATE, status);
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_FREE_STATE);
    status = status == fmi2OK ? plcfmu_drop_state(c, state) : status;
    return plcfmu_leave(c, PLCFMU_FREE_STATE, status);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SERIALIZED_SIZE);
    status = status == fmi2OK ? plcfmu_size_of_state(c, state, size) : status;
    return plcfmu_leave(c, PLCFMU_SERIALIZED_SIZE, status);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SERIALIZE);
    status = status == fmi2OK ? plcfmu_serialize_state(c, state, bytes, size) : status;
    return plcfmu_leave(c, PLCFMU_SERIALIZE, status);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_DESERIALIZE);
    status = status == fmi2OK ? plcfmu_deserialize_state(c, bytes, size, state) : status;
    return plcfmu_leave(c, PLCFMU_DESERIALIZE, status);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real known_changes[],
                                        fmi2Real unknown_changes[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_DIRECTIONAL_DERIVATIVE);
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)known_changes, (void)unknown_changes;
    status = status == fmi2OK ? plcfmu_refuse(&c->text, "not provided (providesDirectionalDerivative = false)") : status;
    return plcfmu_leave(c, PLCFMU_GET_DIRECTIONAL_DERIVATIVE, status);
}

/* The place of an input among those that are extrapolated. */
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

/* In the steps from now on, the program sees the inputs extrapolated from the start of the step. 0 removes a derivative. */
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
            plcfmu_say(&c->text, row->name);
            return plcfmu_refuse(&c->text, " is not a Real input: only Real inputs have derivatives");
        }
        if (order[i] < 1 || order[i] > PLCFMU_ORDERS) {
            plcfmu_say(&c->text, row->name);
            plcfmu_say(&c->text, ": order ");
            plcfmu_say_whole(&c->text, order[i]);
            return plcfmu_refuse(&c->text, ": derivatives go from order 1 to 4");
        }
        if (!(plcfmu_abs_f64(value[i]) <= 1.7976931348623157e308)) {
            plcfmu_say(&c->text, row->name);
            plcfmu_say_named(&c->text, ": derivative ", value[i], ": must be finite");
            return fmi2Error;
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

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_SET_INPUT_DERIVATIVES);
    status = status == fmi2OK ? plcfmu_set_derivatives(c, vr, count, order, value) : status;
    return plcfmu_leave(c, PLCFMU_SET_INPUT_DERIVATIVES, status);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[]) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_OUTPUT_DERIVATIVES);
    (void)vr, (void)order, (void)value;
    if (status == fmi2OK && count > 0) {
        status = plcfmu_refuse(&c->text, "outputs change in steps and have no derivatives (maxOutputDerivativeOrder = 0)");
    }
    return plcfmu_leave(c, PLCFMU_GET_OUTPUT_DERIVATIVES, status);
}

PLCFMU_APART static fmi2Status plcfmu_do_step(plcfmu_component_t *c, double tc, double h) {
    fmi2Status status = plcfmu_enter(c, PLCFMU_DO_STEP);
    if (status == fmi2OK) {
        status = plcfmu_step(c, tc, h);
        if (status == fmi2OK) {
            plcfmu_advise(c, h);
        }
    }
    return plcfmu_leave(c, PLCFMU_DO_STEP, status);
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real tc, fmi2Real h, fmi2Boolean no_set_state_prior) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    (void)no_set_state_prior;
    if (c != NULL && c->instance.state == PLCFMU_STEP_COMPLETE && plcfmu_is_ordinary_step(c, tc, h)) {
        if (!PLCFMU_MAY_STOP || c->instance.block.stopped[0] == '\0') {
            return fmi2OK;
        }
        return plcfmu_leave(c, PLCFMU_DO_STEP, plcfmu_refuse(&c->text, c->instance.block.stopped));
    }
    return plcfmu_do_step(c, tc, h);
}

fmi2Status fmi2CancelStep(fmi2Component component) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_CANCEL_STEP);
    status = status == fmi2OK
                 ? plcfmu_refuse(&c->text, "a step is complete when fmi2DoStep returns, so there is never one to cancel")
                 : status;
    return plcfmu_leave(c, PLCFMU_CANCEL_STEP, status);
}

/* fmi2DoStepStatus, fmi2PendingStatus and the rest are only asked while a step is pending. */
static fmi2Status plcfmu_no_status(plcfmu_component_t *c, int kind, const void *value) {
    if (plcfmu_target(&c->text, value, "value") != fmi2OK) {
        return fmi2Error;
    }
    plcfmu_say(&c->text, "status kind ");
    plcfmu_say_whole(&c->text, kind);
    plcfmu_say(&c->text, " has no answer here: no step is ever pending");
    return fmi2Discard;
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_STATUS);
    status = status == fmi2OK ? plcfmu_no_status(c, (int)kind, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_STATUS, status);
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_REAL_STATUS);
    if (status == fmi2OK && kind == fmi2LastSuccessfulTime && value != NULL) {
        *value = c->instance.clock.end;
    } else if (status == fmi2OK) {
        status = plcfmu_no_status(c, (int)kind, value);
    }
    return plcfmu_leave(c, PLCFMU_GET_REAL_STATUS, status);
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_INTEGER_STATUS);
    status = status == fmi2OK ? plcfmu_no_status(c, (int)kind, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_INTEGER_STATUS, status);
}

/* A program never ends the simulation. */
fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_BOOLEAN_STATUS);
    if (status == fmi2OK && kind == fmi2Terminated && value != NULL) {
        *value = 0;
    } else if (status == fmi2OK) {
        status = plcfmu_no_status(c, (int)kind, value);
    }
    return plcfmu_leave(c, PLCFMU_GET_BOOLEAN_STATUS, status);
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value) {
    plcfmu_component_t *c = (plcfmu_component_t *)component;
    fmi2Status status = plcfmu_enter(c, PLCFMU_GET_STRING_STATUS);
    status = status == fmi2OK ? plcfmu_no_status(c, (int)kind, value) : status;
    return plcfmu_leave(c, PLCFMU_GET_STRING_STATUS, status);
}
