
/* --- Values ----------------------------------------------------------------------------------------------------------- */

static int plcfmu_is_settable(const plcfmu_row_t *row) {
    return row->role == PLCFMU_INPUT || row->role == PLCFMU_PARAMETER || row->role == PLCFMU_FIXED;
}

/* The FMI type of a variable: 0 Real, 1 Integer, 2 Boolean. */
static int plcfmu_class(const plcfmu_row_t *row) {
    return plcfmu_kinds[row->kind].of;
}

static const char *const plcfmu_classes[] = {"Real", "Integer", "Boolean"};

/* The bits of a value, extended by its sign. */
static int64_t plcfmu_read(const plcfmu_row_t *row, const memory_t *memory) {
    const char *at = (const char *)memory + row->offset;
    switch (row->kind) {
    case PLCFMU_LREAL: case PLCFMU_LTIME: case PLCFMU_LINT: case PLCFMU_ULINT: case PLCFMU_LWORD: {
        int64_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_TIME: case PLCFMU_DINT: {
        int32_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_REAL: case PLCFMU_UDINT: case PLCFMU_DWORD: {
        uint32_t value;
        memcpy(&value, at, sizeof value);
        return (int64_t)value;
    }
    case PLCFMU_INT: {
        int16_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_WORD: case PLCFMU_UINT: {
        uint16_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    case PLCFMU_SINT: {
        int8_t value;
        memcpy(&value, at, sizeof value);
        return value;
    }
    default: {
        uint8_t value;
        memcpy(&value, at, sizeof value);
        return row->kind == PLCFMU_BOOL ? value != 0 : value;
    }
    }
}

static void plcfmu_write(const plcfmu_row_t *row, memory_t *memory, int64_t bits) {
    /* The machine is little endian: the low bytes come first. */
    memcpy((char *)memory + row->offset, &bits, plcfmu_kinds[row->kind].size);
}

/* The bits of a variable of a block. */
static int64_t plcfmu_bits(const plcfmu_block_t *block, uint32_t reference) {
    const plcfmu_row_t *row = &plcfmu_rows[reference];
    if (reference == PLCFMU_CYCLE_ROW) {
        return block->cycle;
    }
    return row->held != 0 ? block->set[reference] : plcfmu_read(row, &block->memory);
}

static void plcfmu_put(plcfmu_block_t *block, uint32_t reference, int64_t bits) {
    const plcfmu_row_t *row = &plcfmu_rows[reference];
    if (reference == PLCFMU_CYCLE_ROW) {
        block->cycle = (int32_t)bits;
    } else if (row->held != 0) {
        block->set[reference] = bits;
    } else {
        plcfmu_write(row, &block->memory, bits);
    }
}

/* A variable as a number: times in seconds, TRUE as 1. */
static double plcfmu_number(int kind, int64_t bits) {
    switch (kind) {
    case PLCFMU_REAL:
        return (double)plcfmu_f32_of((uint32_t)bits);
    case PLCFMU_LREAL:
        return plcfmu_f64_of((uint64_t)bits);
    case PLCFMU_TIME:
        return (double)bits / 1000.0;
    case PLCFMU_LTIME:
        return (double)bits / 1e9;
    case PLCFMU_ULINT: case PLCFMU_LWORD:
        return (double)(uint64_t)bits;
    case PLCFMU_WORD:
        return (double)(int16_t)(uint16_t)bits;
    default:
        return (double)bits;
    }
}

/* The bits of a number; NULL, or the range of the type if it lies outside. */
static const char *plcfmu_bits_of(double number, int kind, int64_t *bits) {
    int is_inside;
    if (kind == PLCFMU_REAL) {
        /* Halfway between the largest REAL and the power of 2 beyond it. */
        is_inside = plcfmu_abs_f64(number) < 340282356779733661637539395458142568448.0;
        *bits = is_inside ? (int64_t)plcfmu_bits_f32((float)number) : 0;
    } else if (kind == PLCFMU_LREAL) {
        is_inside = plcfmu_abs_f64(number) <= 1.7976931348623157e308;
        *bits = (int64_t)plcfmu_bits_f64(number);
    } else if (kind == PLCFMU_TIME) {
        is_inside = number >= 0.0 && number <= 2147483.647;
        number = is_inside ? number * 1000.0 : 0.0;
        *bits = (int64_t)number + (number - (double)(int64_t)number >= 0.5 ? 1 : 0);
    } else {
        number = kind == PLCFMU_LTIME ? plcfmu_round_f64(number * 1e9) : number;
        is_inside = number >= plcfmu_kinds[kind].lowest && number <= plcfmu_kinds[kind].highest;
        *bits = is_inside ? (int64_t)number : 0;
        is_inside = is_inside && (double)*bits == number;
        /* The upper half of an unsigned word is the negative half of a signed one. */
        *bits = kind == PLCFMU_WORD ? (int64_t)(uint16_t)*bits : kind == PLCFMU_DWORD ? (int64_t)(uint32_t)*bits : *bits;
    }
    return is_inside ? NULL : plcfmu_kinds[kind].takes;
}

/* --- The program ------------------------------------------------------------------------------------------------------ */

/* Start values. */
static void plcfmu_start(plcfmu_block_t *block) {
    uint32_t row;
    start(&block->memory);
    for (row = 0; row < PLCFMU_ROWS; row += 1) {
        block->set[row] = row == PLCFMU_CYCLE_ROW ? 0 : plcfmu_read(&plcfmu_rows[row], &block->memory);
    }
    block->calls = 0;
    block->cycle = PLCFMU_CYCLE;
    block->stopped[0] = '\0';
}

/* Gives the program what is set of the variables that it writes, too. */
static void plcfmu_give(plcfmu_block_t *block) {
    uint32_t row;
    for (row = 0; PLCFMU_IN_OUTS && row < PLCFMU_ROWS; row += 1) {
        if (plcfmu_rows[row].held == PLCFMU_EACH_CALL) {
            plcfmu_write(&plcfmu_rows[row], &block->memory, block->set[row]);
        }
    }
#ifdef PLCFMU_OWN_CYCLE
    memcpy((char *)&block->memory + PLCFMU_OWN_CYCLE, &block->cycle, sizeof block->cycle);
#endif
}

/* Why a call was stopped. */
static void plcfmu_say_stop(const plcfmu_block_t *block, const call_t *call, plcfmu_text_t *text) {
    plcfmu_say(text, plcfmu_files[call->stopped >> 24]);
    plcfmu_say(text, ":");
    plcfmu_say_whole(text, call->stopped & 0xFFFFFF);
    if (call->cause == OUT_OF_BOUNDS) {
        plcfmu_say(text, ": index ");
        plcfmu_say_whole(text, call->index);
        plcfmu_say(text, " is outside of ");
        plcfmu_say_whole(text, call->low);
        plcfmu_say(text, "..");
        plcfmu_say_whole(text, call->high);
    } else if (call->cause == OUT_OF_BUDGET) {
        plcfmu_say(text, ": the call has run ");
        plcfmu_say_whole(text, PLCFMU_BUDGET);
        plcfmu_say(text, " statements and is stopped; if this loop ends at some time, raise the budget");
    } else {
        plcfmu_say(text, ": the loop has the step 0 and would not end");
    }
    plcfmu_say(text, " (call ");
    plcfmu_say_whole(text, block->calls);
    plcfmu_say_named(text, ", ", (double)call->now / 1e9, " s after the start)");
}

/* Calls a function at a time in nanoseconds. If it stops, the memory is as before, of which `before` takes a copy. */
static void plcfmu_run(plcfmu_block_t *block, void (*function)(call_t *, memory_t *), int64_t now, memory_t *before,
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

/* A warm restart to another block: all start values but those of what a host sets; then the block of the start, if there is one. */
static void plcfmu_restart(const plcfmu_block_t *from, plcfmu_block_t *to, memory_t *before, plcfmu_text_t *text) {
    uint32_t row;
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
    to->calls = 0;
    to->stopped[0] = '\0';
    plcfmu_give(to);
#ifdef PLCFMU_STARTUP
    plcfmu_run(to, PLCFMU_STARTUP, 0, before, text);
#else
    (void)before, (void)text;
#endif
}

/* One call, unless the program has stopped. */
static void plcfmu_call(plcfmu_block_t *block, memory_t *before, plcfmu_text_t *text) {
    if (block->stopped[0] != '\0') {
        return;
    }
    plcfmu_give(block);
    plcfmu_run(block, PLCFMU_CALL, (int64_t)((uint64_t)block->calls * (uint64_t)block->cycle * 1000000u), before, text);
    block->calls += block->stopped[0] == '\0' ? 1 : 0;
}

/* --- Hash ------------------------------------------------------------------------------------------------------------- */

/* FNV-1a with 128 bits. */
typedef struct {
    uint64_t high;
    uint64_t low;
} plcfmu_hash_t;

static const plcfmu_hash_t plcfmu_hash_basis = {0x6c62272e07bb0142u, 0x62b821756295c58du};

static void plcfmu_hash(plcfmu_hash_t *hash, const void *bytes, size_t count) {
    const unsigned char *byte = (const unsigned char *)bytes;
    size_t i;
    for (i = 0; i < count; i += 1) {
        /* times 2^88 + 0x13b */
        uint64_t low = hash->low ^ byte[i], right = (low & 0xFFFFFFFFu) * 0x13bu, left = (low >> 32) * 0x13bu + (right >> 32);
        hash->high = hash->high * 0x13bu + (left >> 32) + (low << 24);
        hash->low = left << 32 | (right & 0xFFFFFFFFu);
    }
}

/* --- Self-test -------------------------------------------------------------------------------------------------------- */

/* The next number of the tape of inputs, 0 ... 2^24 - 1. */
static uint32_t plcfmu_next(uint32_t *tape) {
    *tape = *tape * 1664525u + 1013904223u;
    return *tape >> 8;
}

/* An input of the tape. */
static double plcfmu_tape(const plcfmu_row_t *row, uint32_t *tape) {
    double drawn = (double)plcfmu_next(tape);
    switch (row->kind) {
    case PLCFMU_BOOL:
        return drawn < 8388608.0 ? 0.0 : 1.0;
    case PLCFMU_REAL: case PLCFMU_LREAL:
        return row->low + (row->high - row->low) * (drawn / 16777216.0);
    case PLCFMU_TIME: case PLCFMU_LTIME:
        return plcfmu_floor_f64(drawn / 4096.0) / 1000.0;
    default:
        return plcfmu_floor_f64(drawn / 167773.0);
    }
}

/* Makes the calls of the tape, and says whether their results have the hash of the library that plcfmu packed. */
static int plcfmu_is_exact(plcfmu_component_t *c) {
    plcfmu_hash_t hash = plcfmu_hash_basis;
    uint32_t tape = 1, row;
    int call;
    plcfmu_restart(&c->instance.block, &c->other, &c->before, &c->text);
    for (call = 0; call < PLCFMU_TEST_CALLS; call += 1) {
        for (row = 0; row < PLCFMU_ROWS; row += 1) {
            int64_t bits;
            /* Each input changes in one of four calls. */
            if (plcfmu_rows[row].role == PLCFMU_INPUT && (plcfmu_next(&tape) < 4194304u || call == 0)
                && plcfmu_bits_of(plcfmu_tape(&plcfmu_rows[row], &tape), plcfmu_rows[row].kind, &bits) == NULL) {
                plcfmu_put(&c->other, row, bits);
            }
        }
        plcfmu_call(&c->other, &c->before, &c->text);
        for (row = 0; row < PLCFMU_ROWS; row += 1) {
            double number = plcfmu_number(plcfmu_rows[row].kind, plcfmu_bits(&c->other, row));
            uint64_t bits = number != number ? 0x7FF8000000000000u : plcfmu_bits_f64(number);
            plcfmu_hash(&hash, &bits, sizeof bits);
        }
    }
    return hash.high == PLCFMU_TEST_HIGH && hash.low == PLCFMU_TEST_LOW 
           && (PLCFMU_TEST_CALLS == 0 || c->other.stopped[0] == '\0');
}
