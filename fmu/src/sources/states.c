
/* --- Saved states ------------------------------------------------------------------------------------------------------ */

#ifdef PLCFMU_MAX_INSTANCES
#ifndef PLCFMU_MAX_STATES
#define PLCFMU_MAX_STATES (4 * PLCFMU_MAX_INSTANCES)
#endif
static plcfmu_component_t plcfmu_components[PLCFMU_MAX_INSTANCES];
static plcfmu_saved_t plcfmu_states[PLCFMU_MAX_STATES];
#endif

static plcfmu_component_t *plcfmu_new_component(void) {
#ifdef PLCFMU_MAX_INSTANCES
    size_t i;
    for (i = 0; i < PLCFMU_MAX_INSTANCES; i += 1) {
        if (!plcfmu_components[i].taken) {
            memset(&plcfmu_components[i], 0, sizeof plcfmu_components[i]);
            plcfmu_components[i].taken = 1;
            return &plcfmu_components[i];
        }
    }
    return NULL;
#else
    return (plcfmu_component_t *)calloc(1, sizeof(plcfmu_component_t));
#endif
}

static void plcfmu_free_component(plcfmu_component_t *c) {
#ifdef PLCFMU_MAX_INSTANCES
    c->taken = 0;
#else
    free(c);
#endif
}

static plcfmu_saved_t *plcfmu_new_state(void) {
#ifdef PLCFMU_MAX_INSTANCES
    size_t i;
    for (i = 0; i < PLCFMU_MAX_STATES; i += 1) {
        if (!plcfmu_states[i].taken) {
            plcfmu_states[i].taken = 1;
            return &plcfmu_states[i];
        }
    }
    return NULL;
#else
    return (plcfmu_saved_t *)calloc(1, sizeof(plcfmu_saved_t));
#endif
}

static void plcfmu_free_state(plcfmu_saved_t *state) {
#ifdef PLCFMU_MAX_INSTANCES
    state->taken = 0;
#else
    free(state);
#endif
}

/* The saved state with this address, which is only compared, and the link that points to it. */
static plcfmu_saved_t *plcfmu_find(plcfmu_component_t *c, void *address, plcfmu_saved_t ***link) {
    plcfmu_saved_t **at;
    for (at = &c->saved; *at != NULL; at = &(*at)->next) {
        if ((void *)*at == address) {
            *link = at;
            return *at;
        }
    }
    plcfmu_say_unknown_state(&c->text);
    return NULL;
}

/* The host's saved state, or a new one if the pointer is NULL. */
static plcfmu_saved_t *plcfmu_keep(plcfmu_component_t *c, void **address) {
    plcfmu_saved_t **link = NULL, *state;
    if (*address != NULL) {
        return plcfmu_find(c, *address, &link);
    }
    state = plcfmu_new_state();
    if (state == NULL) {
        plcfmu_say(&c->text, "no memory for another state; free one, or compile with a larger PLCFMU_MAX_STATES");
        return NULL;
    }
    state->next = c->saved;
    c->saved = state;
    *address = state;
    return state;
}

/* --- Serialized states: the same bytes as in the library packed by plcfmu ------------------------------------------------ */

/* The first bytes of a serialized state; the last byte is the version of the format. */
static const unsigned char plcfmu_magic[8] = {'p', 'l', 'c', 'f', 'm', 'u', 0, 1};

/* Bytes that are written or read in sequence. */
typedef struct {
    unsigned char *to;
    const unsigned char *from;
    size_t left;
    int is_damaged;
} plcfmu_bytes_t;

/* Writes or reads a number or an array in the machine's byte order, which is little endian. */
static void plcfmu_pass(plcfmu_bytes_t *bytes, void *value, size_t size) {
    if (bytes->left < size) {
        bytes->is_damaged = 1;
        return;
    }
    if (bytes->to != NULL) {
        memcpy(bytes->to, value, size);
        bytes->to += size;
    } else {
        memcpy(value, bytes->from, size);
        bytes->from += size;
    }
    bytes->left -= size;
}

/* Whether all values are in the ranges that steps can produce. Any other clock could demand an endless number of calls. */
static int plcfmu_is_possible(const plcfmu_clock_t *clock) {
    double most = 1.7976931348623157e308;
    return clock->cycle >= 0.0 && clock->cycle <= 2147483647.0 && plcfmu_abs_f64(clock->start) <= most && plcfmu_abs_f64(clock->end) <= most
           && plcfmu_abs_f64(clock->since) <= most && clock->stop >= clock->start && clock->tick >= 0
           && clock->tick <= 9007199254740992 && clock->next >= clock->tick && clock->next <= clock->tick + 2
           && plcfmu_abs_f64(clock->offset) <= 2.0 * clock->cycle;
}

/* Writes or reads the data that a program has in addition to its memory. */
static void plcfmu_pass_program(plcfmu_bytes_t *bytes, plcfmu_block_t *block) {
    u64_t length = strlen(block->stopped);
    u32_t row;
    plcfmu_pass(bytes, &block->cycle, 4);
    plcfmu_pass(bytes, &block->calls, 8);
    for (row = 0; row < PLCFMU_ROWS; row += 1) {
        if (row != PLCFMU_CYCLE_ROW) {
            plcfmu_pass(bytes, &block->set[row], 8);
        }
    }
    plcfmu_pass(bytes, &length, 8);
    bytes->is_damaged |= length >= sizeof block->stopped;
    if (!bytes->is_damaged) {
        plcfmu_pass(bytes, block->stopped, (size_t)length);
        block->stopped[length] = '\0';
    }
}

/* Writes or reads an instance. */
static void plcfmu_pass_instance(plcfmu_bytes_t *bytes, plcfmu_instance_t *instance) {
    plcfmu_clock_t *clock = &instance->clock;
    plcfmu_block_t *block = &instance->block;
    u64_t count = instance->extrapolated;
    unsigned char state = (unsigned char)instance->state, has_experiment = (unsigned char)instance->has_experiment;
    size_t i;
    plcfmu_pass(bytes, &state, 1);
    plcfmu_pass(bytes, &has_experiment, 1);
    plcfmu_pass(bytes, &instance->start, 8);
    plcfmu_pass(bytes, &instance->stop, 8);
    plcfmu_pass(bytes, &clock->start, 8);
    plcfmu_pass(bytes, &clock->stop, 8);
    plcfmu_pass(bytes, &clock->cycle, 8);
    plcfmu_pass(bytes, &clock->next, 8);
    plcfmu_pass(bytes, &clock->tick, 8);
    plcfmu_pass(bytes, &clock->offset, 8);
    plcfmu_pass(bytes, &clock->end, 8);
    plcfmu_pass(bytes, &clock->since, 8);
    plcfmu_pass(bytes, &count, 8);
    bytes->is_damaged |= count > PLCFMU_ROWS;
    for (i = 0; !bytes->is_damaged && i < count; i += 1) {
        plcfmu_pass(bytes, &instance->extrapolations[i].row, 4);
        plcfmu_pass(bytes, instance->extrapolations[i].derivatives, 8 * PLCFMU_ORDERS);
        bytes->is_damaged |= instance->extrapolations[i].row >= PLCFMU_ROWS;
    }
    if (!PLCFMU_IS_BLOCK) {
        plcfmu_pass_program(bytes, block);
    }
    for (i = 0; i < sizeof plcfmu_fields / sizeof plcfmu_fields[0]; i += 1) {
        unsigned char *field = (unsigned char *)&block->memory + plcfmu_fields[i].offset;
        plcfmu_pass(bytes, field, plcfmu_fields[i].size);
        bytes->is_damaged |= plcfmu_fields[i].is_truth && *field > 1;
    }
    if (bytes->is_damaged) {
        return;
    }
    bytes->is_damaged = has_experiment > 1 || !plcfmu_is_possible(clock) || (state & (state - 1)) != 0
                        || (state & (PLCFMU_I | PLCFMU_N | PLCFMU_E | PLCFMU_C | PLCFMU_T)) == 0;
    instance->state = state;
    instance->has_experiment = has_experiment;
    instance->extrapolated = (size_t)count;
}

/* Sizes in bytes: magic, the GUID and the length precede the content, and the checksum follows it. */
#define PLCFMU_HEAD 32u
#define PLCFMU_CHECKSUM 16u

static size_t plcfmu_serialized_size(const plcfmu_instance_t *instance) {
    size_t content = 90u + 36u * instance->extrapolated, i;
    if (!PLCFMU_IS_BLOCK) {
        content += 20u + 8u * (PLCFMU_ROWS - 1u) + strlen(instance->block.stopped);
    }
    for (i = 0; i < sizeof plcfmu_fields / sizeof plcfmu_fields[0]; i += 1) {
        content += plcfmu_fields[i].size;
    }
    return PLCFMU_HEAD + content + PLCFMU_CHECKSUM;
}

static void plcfmu_serialize(plcfmu_instance_t *instance, unsigned char *to, size_t size) {
    plcfmu_bytes_t bytes = {NULL, NULL, 0, 0};
    u64_t length = size - PLCFMU_HEAD - PLCFMU_CHECKSUM;
    plcfmu_hash_t hash = plcfmu_hash_basis;
    memcpy(to, plcfmu_magic, sizeof plcfmu_magic);
    memcpy(to + 8, plcfmu_fingerprint, sizeof plcfmu_fingerprint);
    memcpy(to + 24, &length, 8);
    bytes.to = to + PLCFMU_HEAD;
    bytes.left = (size_t)length;
    plcfmu_pass_instance(&bytes, instance);
    plcfmu_hash(&hash, to, size - PLCFMU_CHECKSUM);
    memcpy(to + size - PLCFMU_CHECKSUM, &hash.low, 8);
    memcpy(to + size - 8, &hash.high, 8);
}

static plcfmu_status_t plcfmu_deserialize(plcfmu_text_t *text, const unsigned char *from, size_t size, plcfmu_instance_t *to) {
    plcfmu_bytes_t bytes = {NULL, NULL, 0, 0};
    plcfmu_hash_t hash = plcfmu_hash_basis, expected;
    u64_t length;
    if (size < 8 || memcmp(from, plcfmu_magic, sizeof plcfmu_magic) != 0) {
        return plcfmu_say_no_serialized_state(text);
    }
    if (size < 24 || memcmp(from + 8, plcfmu_fingerprint, sizeof plcfmu_fingerprint) != 0) {
        return plcfmu_say_state_of_another_fmu(text, PLCFMU_NAME);
    }
    if (size < PLCFMU_HEAD + PLCFMU_CHECKSUM) {
        return plcfmu_say_damaged_state(text);
    }
    memcpy(&length, from + 24, 8);
    memcpy(&expected.low, from + size - PLCFMU_CHECKSUM, 8);
    memcpy(&expected.high, from + size - 8, 8);
    plcfmu_hash(&hash, from, size - PLCFMU_CHECKSUM);
    bytes.from = from + PLCFMU_HEAD;
    bytes.left = size - PLCFMU_HEAD - PLCFMU_CHECKSUM;
    bytes.is_damaged = hash.high != expected.high || hash.low != expected.low || length != bytes.left;
    if (!bytes.is_damaged) {
        memset(to, 0, sizeof *to);
        plcfmu_pass_instance(&bytes, to);
    }
    return bytes.is_damaged || bytes.left > 0 ? plcfmu_say_damaged_state(text) : PLCFMU_OK;
}
