
/* --- Calls ------------------------------------------------------------------------------------------------------------ */

/* Tells the host, if it wants to know: "FUNCTION: message", in which # begins the reference to a variable and is doubled. */
static void plcfmu_tell(plcfmu_component_t *c, int function, plcfmu_status_t status) {
    static const int bits[] = {PLCFMU_ADVICE, PLCFMU_ERROR, PLCFMU_DISCARD, PLCFMU_ERROR, PLCFMU_FATAL, PLCFMU_ERROR};
    char text[2 * PLCFMU_LONGEST + 64];
    const char *parts[3];
    size_t length = 0;
    int category = 0, part;
    if (c->logged & bits[status]) {
        while (!(bits[status] >> category & 1)) {
            category += 1;
        }
        parts[0] = plcfmu_functions[function].name;
        parts[1] = ": ";
        parts[2] = c->text.text;
        for (part = 0; part < 3; part += 1) {
            const char *from = parts[part];
            for (; *from != '\0'; from += 1) {
                text[length] = *from;
                length += 1;
                if (*from == '#') {
                    text[length] = '#';
                    length += 1;
                }
            }
        }
        text[length] = '\0';
        plcfmu_log(c->logger, c->environment, c->name, status, plcfmu_categories[category], text);
    }
    c->text.length = 0;
    c->text.text[0] = '\0';
}

/* Refuses a function in the present state. */
static plcfmu_status_t plcfmu_not_now(plcfmu_component_t *c, int function) {
    const size_t count = sizeof plcfmu_state_names / sizeof plcfmu_state_names[0];
    const char *name = "";
    plcfmu_text_t allowed = {0, {0}};
    size_t state;
    for (state = 0; state < count; state += 1) {
        name = plcfmu_state_names[state].state == c->instance.state ? plcfmu_state_names[state].name : name;
        if (plcfmu_functions[function].states & plcfmu_state_names[state].state) {
            plcfmu_say(&allowed, allowed.length > 0 ? ", " : "");
            plcfmu_say(&allowed, plcfmu_state_names[state].name);
        }
    }
    return plcfmu_say_not_now(&c->text, name, allowed.text);
}

/* Whether a function may be called now. */
static plcfmu_status_t plcfmu_enter(plcfmu_component_t *c, int function) {
    if (c == NULL) {
        return PLCFMU_REFUSED;
    }
    return plcfmu_functions[function].states & c->instance.state ? PLCFMU_OK : plcfmu_not_now(c, function);
}

/* What a function answers; a refusal is logged. */
static plcfmu_status_t plcfmu_leave(plcfmu_component_t *c, int function, plcfmu_status_t status) {
    if (c != NULL && (status != PLCFMU_OK || c->text.length > 0)) {
        plcfmu_tell(c, function, status);
    }
    return status;
}

/* Whether an array of the host can be read. */
static plcfmu_status_t plcfmu_array(plcfmu_text_t *text, const void *array, size_t count, size_t size, const char *name) {
    if (array == NULL && count > 0) {
        return plcfmu_say_no_elements(text, name, count);
    }
    return count > (size_t)-1 / 2 / size ? plcfmu_say_too_many_elements(text, name, count) : PLCFMU_OK;
}

static plcfmu_status_t plcfmu_target(plcfmu_text_t *text, const void *target, const char *name) {
    return target != NULL ? PLCFMU_OK : plcfmu_say_no_target(text, name);
}

/* What a function does: what it answers where it is allowed. */
#define PLCFMU_ANSWER(name, answer)                                       \
    plcfmu_component_t *c = (plcfmu_component_t *)instance;               \
    plcfmu_status_t status = plcfmu_enter(c, PLCFMU_OF_##name);           \
    status = status == PLCFMU_OK ? (answer) : status;                     \
    return plcfmu_leave(c, PLCFMU_OF_##name, status)
