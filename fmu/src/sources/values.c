
/* --- Values ----------------------------------------------------------------------------------------------------------- */

static int plcfmu_is_settable(const plcfmu_row_t *row) {
    return row->role == PLCFMU_INPUT || row->role == PLCFMU_PARAMETER || row->role == PLCFMU_FIXED;
}

#ifdef PLCFMU_TEXTS
/* Whether a text keeps the value set by the host. */
static int plcfmu_is_given(const plcfmu_text_row_t *row) {
    return row->role == PLCFMU_INPUT || row->role == PLCFMU_PARAMETER;
}
#endif

/* The bits of a value, sign-extended. */
static i64_t plcfmu_read(const plcfmu_row_t *row, const memory_t *memory) {
    const char *at = (const char *)memory + row->offset;
    switch (row->kind) {
    case PLCFMU_LREAL: case PLCFMU_LTIME: case PLCFMU_LINT: case PLCFMU_ULINT: case PLCFMU_LWORD: {
        i64_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_TIME: case PLCFMU_DINT: {
        i32_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_REAL: case PLCFMU_UDINT: case PLCFMU_DWORD: {
        u32_t value;
        memcpy(&value, at, sizeof value);
        return (i64_t)value;
    }
    case PLCFMU_INT: {
        i16_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_WORD: case PLCFMU_UINT: {
        u16_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_SINT: {
        i8_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    default: {
        u8_t value;
        memcpy(&value, at, sizeof value);
        return row->kind == PLCFMU_BOOL ? value != 0 : value;
    }
    }
}

static void plcfmu_write(const plcfmu_row_t *row, memory_t *memory, i64_t bits) {
    /* The machine is little endian: the low bytes come first. */
    memcpy((char *)memory + row->offset, &bits, plcfmu_kinds[row->kind].size);
}

/* The bits of a block's variable. */
static i64_t plcfmu_bits(const plcfmu_block_t *block, u32_t reference) {
    const plcfmu_row_t *row = &plcfmu_rows[reference];
    if (!PLCFMU_IS_BLOCK && reference == PLCFMU_CYCLE_ROW) {
        return block->cycle;
    }
    return row->held != 0 ? block->set[reference] : plcfmu_read(row, &block->memory);
}

static void plcfmu_put(plcfmu_block_t *block, u32_t reference, i64_t bits) {
    const plcfmu_row_t *row = &plcfmu_rows[reference];
    if (!PLCFMU_IS_BLOCK && reference == PLCFMU_CYCLE_ROW) {
        block->cycle = (i32_t)bits;
    } else if (row->held != 0) {
        block->set[reference] = bits;
    } else {
        plcfmu_write(row, &block->memory, bits);
    }
}

/* The time between two calls, in milliseconds. */
static i32_t plcfmu_cycle(const plcfmu_block_t *block) {
    return (i32_t)plcfmu_bits(block, PLCFMU_CYCLE_ROW);
}

/* A variable as a number: times in seconds, TRUE as 1. */
static double plcfmu_number(int kind, i64_t bits) {
    switch (kind) {
    case PLCFMU_REAL:
        return (double)plcfmu_f32_of((u32_t)bits);
    case PLCFMU_LREAL:
        return plcfmu_f64_of((u64_t)bits);
    case PLCFMU_TIME:
        return (double)bits / 1000.0;
    case PLCFMU_LTIME:
        return (double)bits / 1e9;
    case PLCFMU_ULINT: case PLCFMU_LWORD:
        return (double)(u64_t)bits;
    case PLCFMU_WORD:
        return (double)(i16_t)(u16_t)bits;
    default:
        return (double)bits;
    }
}

/* Halfway between the largest REAL and the next power of 2. */
#define PLCFMU_REAL_END 340282356779733661637539395458142568448.0

/* Converts a number to the bits of a type. Returns NULL, or the type's range if the number is outside it. */
static const char *plcfmu_bits_of(double number, int kind, i64_t *bits) {
    int is_inside;
    if (kind == PLCFMU_REAL) {
        is_inside = plcfmu_abs_f64(number) < PLCFMU_REAL_END;
        *bits = is_inside ? (i64_t)plcfmu_bits_f32((float)number) : 0;
    } else if (kind == PLCFMU_LREAL) {
        is_inside = plcfmu_abs_f64(number) <= 1.7976931348623157e308;
        *bits = (i64_t)plcfmu_bits_f64(number);
    } else if (kind == PLCFMU_TIME) {
        is_inside = number >= 0.0 && number <= 2147483.647;
        number = is_inside ? number * 1000.0 : 0.0;
        *bits = (i64_t)number + (number - (double)(i64_t)number >= 0.5 ? 1 : 0);
    } else {
        number = kind == PLCFMU_LTIME ? plcfmu_round_f64(number * 1e9) : number;
        is_inside = number >= plcfmu_kinds[kind].lowest && number <= plcfmu_kinds[kind].highest;
        *bits = is_inside ? (i64_t)number : 0;
        is_inside = is_inside && (double)*bits == number;
        /* The upper half of an unsigned word is the negative half of a signed one. */
        *bits = kind == PLCFMU_WORD ? (i64_t)(u16_t)*bits : kind == PLCFMU_DWORD ? (i64_t)(u32_t)*bits : *bits;
    }
    return is_inside ? NULL : plcfmu_kinds[kind].takes;
}

/* --- The program ------------------------------------------------------------------------------------------------------ */

/* Sets the start values. */
static void plcfmu_start(plcfmu_block_t *block) {
    u32_t row;
    start(&block->memory);
    for (row = 0; row < PLCFMU_ROWS; row += 1) {
        block->set[row] = row == PLCFMU_CYCLE_ROW ? 0 : plcfmu_read(&plcfmu_rows[row], &block->memory);
    }
    block->calls = 0;
    block->cycle = PLCFMU_CYCLE;
    block->stopped[0] = '\0';
}

/* Copies to memory the time between two calls and the host's values of variables that the program also writes. */
static void plcfmu_give(plcfmu_block_t *block) {
    u32_t row;
    for (row = 0; PLCFMU_IN_OUTS && row < PLCFMU_ROWS; row += 1) {
        if (plcfmu_rows[row].held == PLCFMU_EACH_CALL) {
            plcfmu_write(&plcfmu_rows[row], &block->memory, block->set[row]);
        }
    }
#ifdef PLCFMU_OWN_CYCLE
    memcpy((char *)&block->memory + PLCFMU_OWN_CYCLE, &block->cycle, sizeof block->cycle);
#endif
}

/* Writes the reason why a call was stopped, with its place and time. */
static void plcfmu_say_stop(const plcfmu_block_t *block, const call_t *call, plcfmu_text_t *text) {
    plcfmu_say(text, plcfmu_files[call->stopped >> 24]);
    plcfmu_say(text, ":");
    plcfmu_say_whole(text, call->stopped & 0xFFFFFF);
    if (call->cause == OUT_OF_BOUNDS) {
        plcfmu_say(text, ": index ");
        plcfmu_say_whole(text, call->index);
        plcfmu_say(text, " is outside ");
        plcfmu_say_whole(text, call->low);
        plcfmu_say(text, "..");
        plcfmu_say_whole(text, call->high);
    } else if (call->cause == OUT_OF_BUDGET) {
        plcfmu_say(text, ": the call was stopped after ");
        plcfmu_say_whole(text, PLCFMU_BUDGET);
        plcfmu_say(text, " statements; if this loop does end, increase the budget");
    } else {
        plcfmu_say(text, ": the loop has step 0 and would never end");
    }
    plcfmu_say(text, " (call ");
    plcfmu_say_whole(text, block->calls);
    plcfmu_say(text, ", ");
    plcfmu_say_number(text, (double)call->now / 1e9, 0);
    plcfmu_say(text, " s after the start)");
}

/* Calls a function at a time in nanoseconds. If it stops, the memory is restored from `before`, which receives a copy
   before the call. */
static void plcfmu_run(plcfmu_block_t *block, void (*function)(call_t *, memory_t *), i64_t now, memory_t *before,
                       plcfmu_text_t *text) {
    call_t call = {0, PLCFMU_BUDGET, 0, 0, 0, 0, 0};
    call.now = now;
    if (PLCFMU_MAY_STOP) {
        memcpy(before, &block->memory, sizeof *before);
    }
    function(&call, &block->memory);
    if (call.stopped != 0) {
        memcpy(&block->memory, before, sizeof *before);
        plcfmu_say_stop(block, &call, text);
        memcpy(block->stopped, text->text, text->length + 1);
        text->length = 0;
        text->text[0] = '\0';
    }
}

/* The pulse of a block after its last call: 1, 0 or -1. */
static i64_t plcfmu_pulse(const plcfmu_block_t *block) {
    i32_t pulse = 0;
#ifdef PLCFMU_MEAN
    memcpy(&pulse, (const char *)&block->memory + PLCFMU_PULSE, sizeof pulse);
#else
    (void)block;
#endif
    return pulse;
}

/* Writes the mean of the pulse over the calls of a step, in percent; without calls, the value of the held pulse. */
static void plcfmu_show_mean(plcfmu_block_t *block, i64_t pulses, i64_t calls) {
#ifdef PLCFMU_MEAN
    double percent = 100.0 * (double)pulses / (double)calls;
    if (calls == 0) {
        call_t call = {0, PLCFMU_BUDGET, 0, 0, 0, 0, 0};
        PLCFMU_PULSE_CALL(&call, &block->memory);
        percent = 100.0 * (double)plcfmu_pulse(block);
    }
    memcpy((char *)&block->memory + PLCFMU_MEAN, &percent, sizeof percent);
#else
    (void)block, (void)pulses, (void)calls;
#endif
}

/* Rejects settings with which the block cannot run. */
static plcfmu_status_t plcfmu_check_settings(plcfmu_block_t *block, plcfmu_text_t *text) {
#ifdef PLCFMU_CHECK
    call_t call = {0, PLCFMU_BUDGET, 0, 0, 0, 0, 0};
    const char *rest;
    size_t number = PLCFMU_REFUSAL_NUMBERS;
    i32_t refusal;
    PLCFMU_CHECK(&call, &block->memory);
    memcpy(&refusal, (const char *)&block->memory + PLCFMU_REFUSAL, sizeof refusal);
    if (refusal == 0) {
        return PLCFMU_OK;
    }
    for (rest = plcfmu_refusals[refusal - 1]; *rest != '\0'; rest += 1) {
        char one[2] = {0, 0};
        one[0] = *rest;
        if (*rest == 1 || *rest == 2) {
            double given;
            memcpy(&given, (const char *)&block->memory + number, sizeof given);
            number += sizeof given;
            plcfmu_say_number(text, given, *rest == 1);
        } else {
            plcfmu_say(text, one);
        }
    }
    return PLCFMU_REFUSED;
#else
    (void)block, (void)text;
    return PLCFMU_OK;
#endif
}

/* Writes a restarted copy of a block to `to`, keeping the values set by the host. */
static void plcfmu_restart_block(const plcfmu_block_t *from, plcfmu_block_t *to, memory_t *before, plcfmu_text_t *text) {
    memcpy(to, from, sizeof *to);
    to->calls = 0;
    to->stopped[0] = '\0';
#ifdef PLCFMU_RESTART
    plcfmu_run(to, PLCFMU_RESTART, 0, before, text);
#else
    (void)before, (void)text;
#endif
    plcfmu_show_mean(to, 0, 0);
}

/* Writes a warm-restarted copy of a block to `to`: resets all variables to their start values, except those set by the
   host, then calls the startup block, if any. */
static void plcfmu_restart(const plcfmu_block_t *from, plcfmu_block_t *to, memory_t *before, plcfmu_text_t *text) {
    u32_t row;
    if (PLCFMU_IS_BLOCK) {
        plcfmu_restart_block(from, to, before, text);
        return;
    }
    memcpy(to, from, sizeof *to);
    start(&to->memory);
    for (row = 0; row < PLCFMU_ROWS; row += 1) {
        if (plcfmu_is_settable(&plcfmu_rows[row])) {
            plcfmu_put(to, row, plcfmu_bits(from, row));
        }
        if (plcfmu_rows[row].held == PLCFMU_AT_START) {
            plcfmu_write(&plcfmu_rows[row], &to->memory, to->set[row]);
        }
    }
#ifdef PLCFMU_TEXTS
    for (row = 0; row < PLCFMU_TEXTS; row += 1) {
        const plcfmu_text_row_t *text_row = &plcfmu_text_rows[row];
        if (plcfmu_is_given(text_row)) {
            memcpy((char *)&to->memory + text_row->offset, (const char *)&from->memory + text_row->offset, text_row->size);
        }
    }
#endif
    to->calls = 0;
    to->stopped[0] = '\0';
    plcfmu_give(to);
#ifdef PLCFMU_STARTUP
    plcfmu_run(to, PLCFMU_STARTUP, 0, before, text);
#else
    (void)before, (void)text;
#endif
}

/* Makes one call, unless the program has stopped. */
static void plcfmu_call(plcfmu_block_t *block, memory_t *before, plcfmu_text_t *text) {
    if (PLCFMU_MAY_STOP && block->stopped[0] != '\0') {
        return;
    }
    plcfmu_give(block);
    if (!PLCFMU_MAY_STOP) {
        call_t call = {0, PLCFMU_BUDGET, 0, 0, 0, 0, 0};
        call.now = (i64_t)((u64_t)block->calls * (u64_t)block->cycle * 1000000u);
        PLCFMU_CALL(&call, &block->memory);
        block->calls += 1;
        return;
    }
    plcfmu_run(block, PLCFMU_CALL, (i64_t)((u64_t)block->calls * (u64_t)block->cycle * 1000000u), before, text);
    block->calls += block->stopped[0] == '\0' ? 1 : 0;
}

/* --- Hash ------------------------------------------------------------------------------------------------------------- */

/* 128-bit FNV-1a. */
typedef struct {
    u64_t high;
    u64_t low;
} plcfmu_hash_t;

static const plcfmu_hash_t plcfmu_hash_basis = {0x6c62272e07bb0142ull, 0x62b821756295c58dull};

static void plcfmu_hash(plcfmu_hash_t *hash, const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    size_t i;
    for (i = 0; i < count; i += 1) {
        /* times 2^88 + 0x13b */
        u64_t low = hash->low ^ byte[i], right = (low & 0xFFFFFFFFu) * 0x13bu, left = (low >> 32) * 0x13bu + (right >> 32);
        hash->high = hash->high * 0x13bu + (left >> 32) + (low << 24);
        hash->low = left << 32 | (right & 0xFFFFFFFFu);
    }
}

/* --- Self-test -------------------------------------------------------------------------------------------------------- */

/* The next number of the tape of inputs, 0 ... 2^24 - 1. */
static u32_t plcfmu_next(u32_t *tape) {
    *tape = *tape * 1664525u + 1013904223u;
    return *tape >> 8;
}

/* Whether the tape sets a variable: all inputs, and parameters of some types. */
static int plcfmu_is_drawn(const plcfmu_row_t *row) {
    int is_type = row->kind == PLCFMU_REAL || row->kind == PLCFMU_LREAL || row->kind == PLCFMU_TIME || row->kind == PLCFMU_BOOL;
    return row->role == PLCFMU_INPUT || (row->role == PLCFMU_PARAMETER && is_type);
}

/* A value for the tape. On average, one in four BOOLs is TRUE, and half of the floating-point inputs are small. */
static double plcfmu_tape(const plcfmu_row_t *row, u32_t *tape) {
    static const double scales[] = {1.0, 1.0, 0.0625, 0.00390625};
    u32_t number = plcfmu_next(tape);
    double drawn = (double)number, between = row->low + (row->high - row->low) * (drawn / 16777216.0);
    switch (row->kind) {
    case PLCFMU_BOOL:
        return drawn < 4194304.0 ? 1.0 : 0.0;
    case PLCFMU_REAL: case PLCFMU_LREAL:
        return row->role == PLCFMU_INPUT ? between * scales[number % 4] : between;
    case PLCFMU_TIME: case PLCFMU_LTIME:
        if (row->kind == PLCFMU_TIME && row->role == PLCFMU_PARAMETER) {
            return plcfmu_floor_f64(between * 1000.0) / 1000.0;
        }
        return plcfmu_floor_f64(drawn / 4096.0) / 1000.0;
    default:
        return plcfmu_floor_f64(drawn / 167773.0);
    }
}

/* Whether products and sums are each rounded, in order. The numbers are volatile so that nothing is computed at compile
   time. The square of 1 + 2^-12 rounds to 1 + 2^-11, and 1 vanishes when added to 10^8. */
static int plcfmu_is_strict(void) {
    volatile float factor = 1.000244140625f, rounded = 1.00048828125f, large = 1e8f;
    float x = factor, y = rounded, z = large;
    return x * x - y == 0.0f && (x + z) - z == 0.0f;
}

/* Makes the calls of the tape and returns whether the hash of their results is that of the library packed by plcfmu. */
static int plcfmu_is_exact(plcfmu_component_t *c) {
    plcfmu_hash_t hash = plcfmu_hash_basis;
    u32_t tape = 1, row;
    int call;
    plcfmu_restart(&c->instance.block, &c->other, &c->before, &c->text);
    for (call = 0; call < PLCFMU_TEST_CALLS; call += 1) {
        for (row = 0; row < PLCFMU_ROWS; row += 1) {
            i64_t bits;
            /* On average, each variable changes in one of four calls. */
            if (plcfmu_is_drawn(&plcfmu_rows[row]) && (plcfmu_next(&tape) < 4194304u || call == 0)
                && plcfmu_bits_of(plcfmu_tape(&plcfmu_rows[row], &tape), plcfmu_rows[row].kind, &bits) == NULL) {
                plcfmu_put(&c->other, row, bits);
            }
        }
        plcfmu_call(&c->other, &c->before, &c->text);
        plcfmu_show_mean(&c->other, plcfmu_pulse(&c->other), 1);
        for (row = 0; row < PLCFMU_ROWS; row += 1) {
            double number = plcfmu_number(plcfmu_rows[row].kind, plcfmu_bits(&c->other, row));
            u64_t bits = number != number ? 0x7FF8000000000000ull : plcfmu_bits_f64(number);
            plcfmu_hash(&hash, &bits, sizeof bits);
        }
    }
    return hash.high == PLCFMU_TEST_HIGH && hash.low == PLCFMU_TEST_LOW
           && (PLCFMU_TEST_CALLS == 0 || c->other.stopped[0] == '\0');
}
