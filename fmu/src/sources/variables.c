
/* --- Variables by value reference -------------------------------------------------------------------------------------- */

/* Iterates over the values of the variables passed by a host: one per variable, or one per element of an array. */
typedef struct {
    const plcfmu_reference_t *references;
    size_t count;
    size_t element; /* the next element of an array */
} plcfmu_walk_t;

static plcfmu_walk_t plcfmu_walk(const plcfmu_reference_t *references, size_t count) {
    plcfmu_walk_t walk = {NULL, 0, 0};
    walk.references = references;
    walk.count = count;
    return walk;
}

/* Advances to the next value and sets `row` to its index in the table; returns 0 at the end. */
static int plcfmu_next_value(plcfmu_walk_t *walk, u32_t *row) {
#if PLCFMU_HAS_ARRAYS
    while (walk->count > 0) {
        u32_t reference = *walk->references;
        if (reference >= PLCFMU_REFERENCES) {
            break;
        }
        if (walk->element < plcfmu_parts[reference].count) {
            *row = plcfmu_elements[plcfmu_parts[reference].first + walk->element];
            walk->element += 1;
            return 1;
        }
        walk->element = 0;
        walk->references += 1;
        walk->count -= 1;
    }
#endif
    if (walk->count == 0) {
        return 0;
    }
    *row = *walk->references;
    walk->references += 1;
    walk->count -= 1;
    return 1;
}

/* Rejects a reference that does not refer to a variable of the type being read or written. `access` is Get or Set. */
static plcfmu_status_t plcfmu_no_variable(plcfmu_text_t *text, u32_t reference, const char *access) {
    if (reference < PLCFMU_ROWS) {
        const plcfmu_row_t *row = &plcfmu_rows[reference];
        return plcfmu_say_other_type(text, reference, row->name, plcfmu_types[row->type], PLCFMU_PREFIX, access);
    }
#ifdef PLCFMU_TEXTS
    if (reference - PLCFMU_ROWS < PLCFMU_TEXTS) {
        const char *name = plcfmu_text_rows[reference - PLCFMU_ROWS].name;
        return plcfmu_say_other_type(text, reference, name, "String", PLCFMU_PREFIX, access);
    }
#endif
    return plcfmu_say_unknown_reference(text, reference, PLCFMU_ROWS + PLCFMU_TEXT_COUNT - 1);
}

static plcfmu_status_t plcfmu_check(plcfmu_text_t *text, u32_t row, int of, const char *access) {
    if (row >= PLCFMU_ROWS || plcfmu_rows[row].type != of) {
        return plcfmu_no_variable(text, row, access);
    }
    return PLCFMU_OK;
}

/* The block as a restart would leave it, if a restart is possible. */
static const plcfmu_block_t *plcfmu_restarted(plcfmu_component_t *c) {
    const plcfmu_block_t *shown = &c->instance.block;
    if (plcfmu_cycle(shown) >= 1) {
        if (plcfmu_check_settings(&c->instance.block, &c->text) == PLCFMU_OK) {
            plcfmu_restart(shown, &c->other, &c->before, &c->text);
            shown = &c->other;
        }
        c->text.length = 0;
        c->text.text[0] = '\0';
    }
    return shown;
}

/* The block with the computed values to show: in Initialization Mode those that a restart would produce, if one is
   possible. */
static const plcfmu_block_t *plcfmu_shown(plcfmu_component_t *c, plcfmu_walk_t walk) {
    int is_asked = 0;
    u32_t row;
    while (c->instance.state == PLCFMU_INITIALIZATION && plcfmu_next_value(&walk, &row)) {
        is_asked |= row < PLCFMU_ROWS && row != PLCFMU_CYCLE_ROW && !plcfmu_is_settable(&plcfmu_rows[row]);
    }
    return is_asked ? plcfmu_restarted(c) : &c->instance.block;
}

/* The bits of a variable; if it is computed, from `block`. */
static i64_t plcfmu_bits_shown(const plcfmu_component_t *c, const plcfmu_block_t *block, u32_t row) {
    int is_set = row == PLCFMU_CYCLE_ROW || plcfmu_is_settable(&plcfmu_rows[row]);
    return plcfmu_bits(is_set ? &c->instance.block : block, row);
}

/* Checks that a variable can be set now. */
static plcfmu_status_t plcfmu_may_set(plcfmu_component_t *c, u32_t reference) {
    const plcfmu_row_t *row = &plcfmu_rows[reference];
    int is_fixed = row->role == PLCFMU_FIXED || row->role == PLCFMU_CYCLE_TIME;
    if (row->role == PLCFMU_INPUT || row->role == PLCFMU_PARAMETER
        || (is_fixed && c->instance.state != PLCFMU_STEP_COMPLETE
            && c->instance.state != PLCFMU_EVENT_MODE)) {
        return PLCFMU_OK;
    }
    return is_fixed ? plcfmu_say_fixed_parameter(&c->text, row->name, PLCFMU_PREFIX) : plcfmu_say_computed(&c->text, row->name);
}
