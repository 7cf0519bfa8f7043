
/* --- Variables by type: an array is a variable with one value per element; the time is a variable, too ----------------------- */

#define PLCFMU_TIME_REFERENCE (PLCFMU_ROWS + PLCFMU_TEXT_COUNT)

/* The types, in the order of plcfmu_types. */
enum {
    PLCFMU_FLOAT32, PLCFMU_FLOAT64, PLCFMU_INT8, PLCFMU_UINT8, PLCFMU_INT16, PLCFMU_UINT16, PLCFMU_INT32, PLCFMU_UINT32,
    PLCFMU_INT64, PLCFMU_UINT64, PLCFMU_BOOLEAN
};

static const size_t plcfmu_sizes[] = {4, 8, 1, 1, 2, 2, 4, 4, 8, 8, sizeof(fmi3Boolean)};

/* Rejects missing arrays, a number of values that is not that of the variables and, unless `with_time`, the time. */
static fmi3Status plcfmu_open(plcfmu_component_t *c, const fmi3ValueReference vr[], size_t count, const void *values,
                              size_t value_count, size_t size, const char *access, int with_time) {
    plcfmu_walk_t walk = plcfmu_walk(vr, count);
    size_t found = 0, i;
    u32_t row;
    int has_time = 0;
    if (plcfmu_array(&c->text, vr, count, sizeof *vr, PLCFMU_REFERENCES_NAME) != fmi3OK
        || plcfmu_array(&c->text, values, value_count, size, PLCFMU_VALUES_NAME) != fmi3OK) {
        return fmi3Error;
    }
    for (i = 0; i < count; i += 1) {
#if PLCFMU_HAS_ARRAYS
        if (vr[i] < PLCFMU_REFERENCES && plcfmu_parts[vr[i]].count == 0) {
            return plcfmu_say_inside_array(&c->text, vr[i], plcfmu_parts[vr[i]].first);
        }
#endif
        has_time |= vr[i] == PLCFMU_TIME_REFERENCE;
    }
    while (plcfmu_next_value(&walk, &row)) {
        found += 1;
    }
    if (found != value_count) {
        return plcfmu_say_wrong_count(&c->text, value_count, found);
    }
    if (has_time && !with_time) {
        return access[0] == 'G' ? plcfmu_say_time_is_float64(&c->text, PLCFMU_TIME_REFERENCE)
                                : plcfmu_say_time_is_read(&c->text, PLCFMU_TIME_REFERENCE);
    }
    return fmi3OK;
}

static double plcfmu_time(const plcfmu_instance_t *instance) {
    int is_before = instance->state == PLCFMU_INSTANTIATED || instance->state == PLCFMU_INITIALIZATION;
    return is_before && instance->has_experiment ? instance->start : instance->clock.end;
}

static fmi3Status plcfmu_get(plcfmu_component_t *c, const fmi3ValueReference vr[], size_t count, void *values, size_t value_count,
                             int type) {
    plcfmu_walk_t walk = plcfmu_walk(vr, count);
    const plcfmu_block_t *block;
    char *to = (char *)values;
    u32_t row;
    if (plcfmu_open(c, vr, count, values, value_count, plcfmu_sizes[type], "Get", type == PLCFMU_FLOAT64) != fmi3OK) {
        return fmi3Error;
    }
    while (plcfmu_next_value(&walk, &row)) {
        if (row != PLCFMU_TIME_REFERENCE && plcfmu_check(&c->text, row, type, "Get") != fmi3OK) {
            return fmi3Error;
        }
    }
    walk = plcfmu_walk(vr, count);
    block = plcfmu_shown(c, walk);
    for (; plcfmu_next_value(&walk, &row); to += plcfmu_sizes[type]) {
        int kind = row == PLCFMU_TIME_REFERENCE ? PLCFMU_LREAL : plcfmu_rows[row].kind;
        i64_t bits = row == PLCFMU_TIME_REFERENCE ? (i64_t)plcfmu_bits_f64(plcfmu_time(&c->instance))
                                                  : plcfmu_bits_shown(c, block, row);
        if (type == PLCFMU_FLOAT64) {
            double number = plcfmu_number(kind, bits);
            memcpy(to, &number, sizeof number);
        } else if (type == PLCFMU_BOOLEAN) {
            fmi3Boolean is_true = bits != 0;
            memcpy(to, &is_true, sizeof is_true);
        } else {
            /* Copies the low bytes, which come first. A WORD is sign-extended; this matters only for signed types. */
            i64_t number = kind == PLCFMU_WORD ? (i16_t)(u16_t)bits : bits;
            memcpy(to, &number, plcfmu_sizes[type]);
        }
    }
    return fmi3OK;
}

/* An integer passed by the host. */
static i64_t plcfmu_integer(const char *from, int type) {
    static const u64_t signs[] = {0, 0, 0x80, 0, 0x8000, 0, 0x80000000u, 0, 0, 0, 0};
    u64_t bits = 0;
    memcpy(&bits, from, plcfmu_sizes[type]);
    return (i64_t)((bits ^ signs[type]) - signs[type]);
}

/* Converts a value passed by the host to bits. Returns NULL, or the PLC type's range if the value is outside it. */
static const char *plcfmu_given(const char *from, int type, int kind, i64_t *bits) {
    int is_inside = 1;
    if (type == PLCFMU_FLOAT32) {
        float number;
        memcpy(&number, from, sizeof number);
        is_inside = plcfmu_abs_f64((double)number) < PLCFMU_REAL_END;
        *bits = (i64_t)plcfmu_bits_f32(number);
    } else if (type == PLCFMU_FLOAT64) {
        double number;
        memcpy(&number, from, sizeof number);
        if (kind == PLCFMU_TIME && number < 0.0 && number >= -2147483.648) {
            /* The PLC's TIME may be negative. */
            number = -number * 1000.0;
            *bits = -((i64_t)number + (number - (double)(i64_t)number >= 0.5 ? 1 : 0));
            return NULL;
        }
        return plcfmu_bits_of(number, kind, bits);
    } else if (type == PLCFMU_BOOLEAN) {
        /* Any byte other than 0 is true, although a C compiler may assume that a bool is 0 or 1. */
        *bits = plcfmu_integer(from, type) != 0 ? 1 : 0;
    } else {
        i64_t number = plcfmu_integer(from, type);
        /* No check for 64-bit types and TIME: the host's integer has the same range. */
        if (plcfmu_kinds[kind].size < 8 && kind != PLCFMU_TIME) {
            is_inside = (double)number >= plcfmu_kinds[kind].lowest && (double)number <= plcfmu_kinds[kind].highest;
        }
        *bits = kind == PLCFMU_WORD ? (i64_t)(u16_t)number : kind == PLCFMU_DWORD ? (i64_t)(u32_t)number : number;
    }
    return is_inside ? NULL : plcfmu_kinds[kind].takes;
}

/* Writes a value passed by the host to a message. */
static void plcfmu_say_given(plcfmu_text_t *text, const char *from, int type) {
    float single;
    double number;
    if (type == PLCFMU_FLOAT32) {
        memcpy(&single, from, sizeof single);
        plcfmu_say_number(text, (double)single, 0);
    } else if (type == PLCFMU_FLOAT64) {
        memcpy(&number, from, sizeof number);
        plcfmu_say_number(text, number, 0);
    } else {
        plcfmu_say_whole(text, plcfmu_integer(from, type));
    }
}

static fmi3Status plcfmu_set(plcfmu_component_t *c, const fmi3ValueReference vr[], size_t count, const void *values,
                             size_t value_count, int type) {
    plcfmu_walk_t walk = plcfmu_walk(vr, count);
    const char *from = (const char *)values;
    i64_t bits;
    u32_t row;
    if (plcfmu_open(c, vr, count, values, value_count, plcfmu_sizes[type], "Set", 0) != fmi3OK) {
        return fmi3Error;
    }
    for (; plcfmu_next_value(&walk, &row); from += plcfmu_sizes[type]) {
        const char *range;
        if (plcfmu_check(&c->text, row, type, "Set") != fmi3OK || plcfmu_may_set(c, row) != fmi3OK) {
            return fmi3Error;
        }
        range = plcfmu_given(from, type, plcfmu_rows[row].kind, &bits);
        if (range != NULL) {
            plcfmu_text_t value = {0, {0}};
            plcfmu_say_given(&value, from, type);
            return plcfmu_say_out_of_range(&c->text, plcfmu_rows[row].name, value.text, range);
        }
    }
    walk = plcfmu_walk(vr, count);
    for (from = (const char *)values; plcfmu_next_value(&walk, &row); from += plcfmu_sizes[type]) {
        if (plcfmu_given(from, type, plcfmu_rows[row].kind, &bits) == NULL) {
            plcfmu_put(&c->instance.block, row, bits);
        }
    }
    return fmi3OK;
}

static fmi3Status plcfmu_get_texts(plcfmu_component_t *c, const fmi3ValueReference vr[], size_t count, fmi3String values[],
                                   size_t value_count) {
    if (plcfmu_open(c, vr, count, values, value_count, sizeof(fmi3String), "Get", 0) != fmi3OK) {
        return fmi3Error;
    }
    return plcfmu_get_strings(c, vr, count, values);
}

static fmi3Status plcfmu_set_texts(plcfmu_component_t *c, const fmi3ValueReference vr[], size_t count, const fmi3String values[],
                                   size_t value_count) {
    if (plcfmu_open(c, vr, count, values, value_count, sizeof(fmi3String), "Set", 0) != fmi3OK) {
        return fmi3Error;
    }
    return plcfmu_set_strings(c, vr, count, values);
}

/* --- The 75 functions of FMI 3.0 ------------------------------------------------------------------------------------------- */

/* The answer of functions for variable types that the FMU does not have. */
static fmi3Status plcfmu_nothing(plcfmu_component_t *c, size_t count, const char *what) {
    return count == 0 ? fmi3OK : plcfmu_say_none_of_this_type(&c->text, what);
}

#define PLCFMU_EXCHANGE plcfmu_say_function_of_another_kind(&c->text, "Model Exchange")

const char *fmi3GetVersion(void) { return "3.0"; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String names[]) {
    PLCFMU_ANSWER(SetDebugLogging, plcfmu_set_debug_logging(c, on, count, names));
}

/* Logs that the FMU does not support this kind of simulation. */
static fmi3Instance plcfmu_refuse_kind(int function, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    plcfmu_text_t text = {0, {0}};
    plcfmu_say(&text, plcfmu_functions[function].name);
    plcfmu_say(&text, ": ");
    plcfmu_say_no_simulation_of_this_kind(&text);
    plcfmu_log(logger, environment, "", fmi3Error, "logStatusError", text.text);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging_on, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging_on;
    return plcfmu_refuse_kind(PLCFMU_OF_InstantiateModelExchange, environment, logger);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging_on, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger, fmi3ClockUpdateCallback update,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging_on, (void)update, (void)lock, (void)unlock;
    return plcfmu_refuse_kind(PLCFMU_OF_InstantiateScheduledExecution, environment, logger);
}

static fmi3Status plcfmu_check_arguments(plcfmu_component_t *c, fmi3String name, fmi3String token) {
    return plcfmu_check_name(c, name) == fmi3OK ? plcfmu_begin(c, "instantiationToken", token) : fmi3Error;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging_on, fmi3Boolean event_mode_used, fmi3Boolean early_return_allowed,
                                         const fmi3ValueReference intermediate[], size_t intermediate_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    plcfmu_component_t *c = plcfmu_make(name, logger, environment);
    (void)resources, (void)visible, (void)intermediate, (void)intermediate_count, (void)update;
    if (c == NULL) {
        return NULL;
    }
    c->has_events = event_mode_used ? 1 : 0;
    c->may_return_early = early_return_allowed ? 1 : 0;
    return plcfmu_made(c, plcfmu_check_arguments(c, name, token), logging_on);
}

void fmi3FreeInstance(fmi3Instance instance) { plcfmu_free((plcfmu_component_t *)instance); }

static fmi3Status plcfmu_enter_initialization(plcfmu_component_t *c, double start, int has_stop, double stop) {
    return plcfmu_setup(c, start, has_stop, stop) == fmi3OK ? plcfmu_go(c, PLCFMU_INITIALIZATION) : fmi3Error;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance, (void)tolerance;
    {
        PLCFMU_ANSWER(EnterInitializationMode, plcfmu_enter_initialization(c, start, has_stop, stop));
    }
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    PLCFMU_ANSWER(ExitInitializationMode, plcfmu_exit_initialization(c));
}

static fmi3Status plcfmu_enter_events(plcfmu_component_t *c) {
    return c->has_events ? plcfmu_go(c, PLCFMU_EVENT_MODE) : plcfmu_say_no_event_mode(&c->text);
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    PLCFMU_ANSWER(EnterEventMode, plcfmu_enter_events(c));
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    PLCFMU_ANSWER(Terminate, plcfmu_go(c, PLCFMU_TERMINATED));
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    PLCFMU_ANSWER(Reset, plcfmu_reset(c));
}

/* Reads and writes variables of one type. */
#define PLCFMU_ACCESS(Type, TYPE)                                                                                         \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3##Type values[],     \
                             size_t value_count) {                                                                        \
        PLCFMU_ANSWER(Get##Type, plcfmu_get(c, vr, count, values, value_count, PLCFMU_##TYPE));                           \
    }                                                                                                                     \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,                          \
                             const fmi3##Type values[], size_t value_count) {                                             \
        PLCFMU_ANSWER(Set##Type, plcfmu_set(c, vr, count, values, value_count, PLCFMU_##TYPE));                           \
    }

PLCFMU_ACCESS(Float32, FLOAT32)
PLCFMU_ACCESS(Float64, FLOAT64)
PLCFMU_ACCESS(Int8, INT8)
PLCFMU_ACCESS(UInt8, UINT8)
PLCFMU_ACCESS(Int16, INT16)
PLCFMU_ACCESS(UInt16, UINT16)
PLCFMU_ACCESS(Int32, INT32)
PLCFMU_ACCESS(UInt32, UINT32)
PLCFMU_ACCESS(Int64, INT64)
PLCFMU_ACCESS(UInt64, UINT64)
PLCFMU_ACCESS(Boolean, BOOLEAN)

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3String values[],
                         size_t value_count) {
    PLCFMU_ANSWER(GetString, plcfmu_get_texts(c, vr, count, values, value_count));
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3String values[],
                         size_t value_count) {
    PLCFMU_ANSWER(SetString, plcfmu_set_texts(c, vr, count, values, value_count));
}

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, size_t sizes[], fmi3Binary values[],
                         size_t value_count) {
    (void)vr, (void)sizes, (void)values, (void)value_count;
    {
        PLCFMU_ANSWER(GetBinary, plcfmu_nothing(c, count, "Binary"));
    }
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const size_t sizes[],
                         const fmi3Binary values[], size_t value_count) {
    (void)vr, (void)sizes, (void)values, (void)value_count;
    {
        PLCFMU_ANSWER(SetBinary, plcfmu_nothing(c, count, "Binary"));
    }
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Clock values[]) {
    (void)vr, (void)values;
    {
        PLCFMU_ANSWER(GetClock, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Clock values[]) {
    (void)vr, (void)values;
    {
        PLCFMU_ANSWER(SetClock, plcfmu_nothing(c, count, "Clock"));
    }
}

/* The variables that an output depends on: none after the start; before it, those that a restart reads. Returns NULL,
   with a message, if the reference is not an output. */
static const plcfmu_part_t *plcfmu_dependencies(plcfmu_component_t *c, u32_t reference) {
    static const plcfmu_part_t none = {0, 0};
    int is_before = c->instance.state == PLCFMU_INSTANTIATED || c->instance.state == PLCFMU_INITIALIZATION;
    if (reference >= PLCFMU_REFERENCES || !plcfmu_is_output[reference]) {
        plcfmu_say_no_dependencies(&c->text, reference);
        return NULL;
    }
    return is_before ? &plcfmu_depends[reference] : &none;
}

static fmi3Status plcfmu_count_dependencies(plcfmu_component_t *c, u32_t reference, size_t *count) {
    const plcfmu_part_t *depends;
    if (plcfmu_target(&c->text, count, "nDependencies") != fmi3OK || (depends = plcfmu_dependencies(c, reference)) == NULL) {
        return fmi3Error;
    }
    *count = depends->count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference reference, size_t *count) {
    PLCFMU_ANSWER(GetNumberOfVariableDependencies, plcfmu_count_dependencies(c, reference, count));
}

static fmi3Status plcfmu_get_dependencies(plcfmu_component_t *c, u32_t reference, size_t of_dependent[],
                                          fmi3ValueReference independents[], size_t of_independents[], fmi3DependencyKind kinds[],
                                          size_t count) {
    const plcfmu_part_t *depends = plcfmu_dependencies(c, reference);
    size_t i;
    if (depends == NULL) {
        return fmi3Error;
    }
    if (depends->count != count) {
        return plcfmu_say_wrong_dependency_count(&c->text, count, depends->count);
    }
    if (plcfmu_array(&c->text, of_dependent, count, sizeof *of_dependent, "elementIndicesOfDependent") != fmi3OK
        || plcfmu_array(&c->text, independents, count, sizeof *independents, "independents") != fmi3OK
        || plcfmu_array(&c->text, of_independents, count, sizeof *of_independents, "elementIndicesOfIndependents") != fmi3OK
        || plcfmu_array(&c->text, kinds, count, sizeof *kinds, "dependencyKinds") != fmi3OK) {
        return fmi3Error;
    }
    for (i = 0; i < count; i += 1) {
        /* 0 means all elements. */
        of_dependent[i] = of_independents[i] = 0;
        independents[i] = plcfmu_independents[depends->first + i];
        kinds[i] = fmi3Dependent;
    }
    return fmi3OK;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t of_dependent[],
                                       fmi3ValueReference independents[], size_t of_independents[], fmi3DependencyKind kinds[],
                                       size_t count) {
    PLCFMU_ANSWER(GetVariableDependencies,
                  plcfmu_get_dependencies(c, dependent, of_dependent, independents, of_independents, kinds, count));
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    PLCFMU_ANSWER(GetFMUState, plcfmu_get_state(c, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    PLCFMU_ANSWER(SetFMUState, plcfmu_set_state(c, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    PLCFMU_ANSWER(FreeFMUState, plcfmu_drop_state(c, state));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    PLCFMU_ANSWER(SerializedFMUStateSize, plcfmu_size_of_state(c, state, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    PLCFMU_ANSWER(SerializeFMUState, plcfmu_serialize_state(c, state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    PLCFMU_ANSWER(DeserializeFMUState, plcfmu_deserialize_state(c, bytes, size, state));
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                        const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
                                        size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count) {
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)seed_count, (void)sensitivity, (void)sensitivity_count;
    {
        PLCFMU_ANSWER(GetDirectionalDerivative, plcfmu_say_not_provided(&c->text, "providesDirectionalDerivatives"));
    }
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                    const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],
                                    size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count) {
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)seed_count, (void)sensitivity, (void)sensitivity_count;
    {
        PLCFMU_ANSWER(GetAdjointDerivative, plcfmu_say_not_provided(&c->text, "providesAdjointDerivatives"));
    }
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    PLCFMU_ANSWER(EnterConfigurationMode, plcfmu_say_no_structural_parameters(&c->text));
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    PLCFMU_ANSWER(ExitConfigurationMode, plcfmu_say_no_configuration_mode(&c->text));
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)intervals, (void)qualifiers;
    {
        PLCFMU_ANSWER(GetIntervalDecimal, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)counters, (void)resolutions, (void)qualifiers;
    {
        PLCFMU_ANSWER(GetIntervalFraction, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Float64 shifts[]) {
    (void)vr, (void)shifts;
    {
        PLCFMU_ANSWER(GetShiftDecimal, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    {
        PLCFMU_ANSWER(GetShiftFraction, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                  const fmi3Float64 intervals[]) {
    (void)vr, (void)intervals;
    {
        PLCFMU_ANSWER(SetIntervalDecimal, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    {
        PLCFMU_ANSWER(SetIntervalFraction, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                               const fmi3Float64 shifts[]) {
    (void)vr, (void)shifts;
    {
        PLCFMU_ANSWER(SetShiftDecimal, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)counters, (void)resolutions;
    {
        PLCFMU_ANSWER(SetShiftFraction, plcfmu_nothing(c, count, "Clock"));
    }
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    PLCFMU_ANSWER(EvaluateDiscreteStates, plcfmu_say_not_provided(&c->text, "providesEvaluateDiscreteStates"));
}

static fmi3Status plcfmu_update(plcfmu_component_t *c, fmi3Boolean *needs_update, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                fmi3Boolean *states, fmi3Boolean *is_next_defined, fmi3Float64 *next) {
    plcfmu_text_t *text = &c->text;
    if (plcfmu_target(text, needs_update, "discreteStatesNeedUpdate") != fmi3OK
        || plcfmu_target(text, terminate, "terminateSimulation") != fmi3OK
        || plcfmu_target(text, nominals, "nominalsOfContinuousStatesChanged") != fmi3OK
        || plcfmu_target(text, states, "valuesOfContinuousStatesChanged") != fmi3OK
        || plcfmu_target(text, is_next_defined, "nextEventTimeDefined") != fmi3OK
        || plcfmu_target(text, next, "nextEventTime") != fmi3OK) {
        return fmi3Error;
    }
    if (c->has_events && plcfmu_handle_event(c) != fmi3OK) {
        return fmi3Error;
    }
    *needs_update = *terminate = *nominals = *states = 0;
    *is_next_defined = c->has_events != 0;
    *next = c->has_events ? plcfmu_next_call(&c->instance.clock) : 0.0;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *needs_update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *is_next_defined, fmi3Float64 *next) {
    PLCFMU_ANSWER(UpdateDiscreteStates, plcfmu_update(c, needs_update, terminate, nominals, states, is_next_defined, next));
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    PLCFMU_ANSWER(EnterContinuousTimeMode, PLCFMU_EXCHANGE);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_set_prior, fmi3Boolean *enter_event_mode,
                                       fmi3Boolean *terminate) {
    (void)no_set_prior, (void)enter_event_mode, (void)terminate;
    {
        PLCFMU_ANSWER(CompletedIntegratorStep, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    (void)time;
    {
        PLCFMU_ANSWER(SetTime, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t count) {
    (void)states, (void)count;
    {
        PLCFMU_ANSWER(SetContinuousStates, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t count) {
    (void)derivatives, (void)count;
    {
        PLCFMU_ANSWER(GetContinuousStateDerivatives, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count) {
    (void)indicators, (void)count;
    {
        PLCFMU_ANSWER(GetEventIndicators, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t count) {
    (void)states, (void)count;
    {
        PLCFMU_ANSWER(GetContinuousStates, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t count) {
    (void)nominals, (void)count;
    {
        PLCFMU_ANSWER(GetNominalsOfContinuousStates, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count) {
    (void)count;
    {
        PLCFMU_ANSWER(GetNumberOfEventIndicators, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count) {
    (void)count;
    {
        PLCFMU_ANSWER(GetNumberOfContinuousStates, PLCFMU_EXCHANGE);
    }
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    PLCFMU_ANSWER(EnterStepMode, plcfmu_go(c, PLCFMU_STEP_COMPLETE));
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count) {
    (void)vr, (void)orders, (void)values, (void)value_count;
    {
        PLCFMU_ANSWER(GetOutputDerivatives, count == 0 ? fmi3OK : plcfmu_say_no_output_derivatives(&c->text));
    }
}

PLCFMU_APART static fmi3Status plcfmu_do_step(plcfmu_component_t *c, double tc, double h, fmi3Boolean *event, fmi3Boolean *terminate,
                                              fmi3Boolean *early, fmi3Float64 *last) {
    double end = tc + h;
    int is_early = 0;
    if (plcfmu_target(&c->text, event, "eventHandlingNeeded") != fmi3OK
        || plcfmu_target(&c->text, terminate, "terminateSimulation") != fmi3OK
        || plcfmu_target(&c->text, early, "earlyReturn") != fmi3OK
        || plcfmu_target(&c->text, last, "lastSuccessfulTime") != fmi3OK) {
        return fmi3Error;
    }
    if (h == 0.0) {
        return plcfmu_say_step_of_zero(&c->text);
    }
    if ((c->has_events ? plcfmu_step_between_events(c, tc, h, &end, &is_early)
         : plcfmu_is_ordinary_step(c, tc, h) ? plcfmu_check_running(c)
                                             : plcfmu_step(c, tc, h)) != fmi3OK) {
        return fmi3Error;
    }
    plcfmu_advise(c, h);
    *event = c->has_events && plcfmu_is_due(&c->instance.clock);
    *terminate = 0;
    *early = is_early != 0;
    *last = end;
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 tc, fmi3Float64 h, fmi3Boolean no_set_prior, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    (void)no_set_prior;
    {
        PLCFMU_ANSWER(DoStep, plcfmu_do_step(c, tc, h, event, terminate, early, last));
    }
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    {
        PLCFMU_ANSWER(ActivateModelPartition, plcfmu_say_function_of_another_kind(&c->text, "Scheduled Execution"));
    }
}
