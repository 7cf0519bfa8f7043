
/* --- Calls ------------------------------------------------------------------------------------------------------------ */

/* Logs "FUNCTION: message" if the host has selected the category. A # is doubled, since it would start a reference to a
   variable. */
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

/* Rejects a function in the current state. */
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

/* Checks that a function may be called now. */
static plcfmu_status_t plcfmu_enter(plcfmu_component_t *c, int function) {
    if (c == NULL) {
        return PLCFMU_REFUSED;
    }
    return plcfmu_functions[function].states & c->instance.state ? PLCFMU_OK : plcfmu_not_now(c, function);
}

/* Returns the status of a function, after logging a refusal or advice. */
static plcfmu_status_t plcfmu_leave(plcfmu_component_t *c, int function, plcfmu_status_t status) {
    if (c != NULL && (status != PLCFMU_OK || c->text.length > 0)) {
        plcfmu_tell(c, function, status);
    }
    return status;
}

/* Checks that an array of the host can be accessed. */
static plcfmu_status_t plcfmu_array(plcfmu_text_t *text, const void *array, size_t count, size_t size, const char *name) {
    if (array == NULL && count > 0) {
        return plcfmu_say_no_elements(text, name, count);
    }
    return count > (size_t)-1 / 2 / size ? plcfmu_say_too_many_elements(text, name, count) : PLCFMU_OK;
}

static plcfmu_status_t plcfmu_target(plcfmu_text_t *text, const void *target, const char *name) {
    return target != NULL ? PLCFMU_OK : plcfmu_say_no_target(text, name);
}

/* The body of a function: checks the state, evaluates the answer, logs and returns the status. */
#define PLCFMU_ANSWER(name, answer)                                       \
    plcfmu_component_t *c = (plcfmu_component_t *)instance;               \
    plcfmu_status_t status = plcfmu_enter(c, PLCFMU_OF_##name);           \
    status = status == PLCFMU_OK ? (answer) : status;                     \
    return plcfmu_leave(c, PLCFMU_OF_##name, status)
