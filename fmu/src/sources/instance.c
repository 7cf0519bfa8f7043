
/* --- What a host can request of an instance, in any FMI version ----------------------------------------------------------- */

/* Marks functions that must not be inlined: a control cycle does not call them and need not save the registers they
   use. */
#if defined(__GNUC__)
#define PLCFMU_APART __attribute__((noinline))
#else
#define PLCFMU_APART
#endif

/* Sets up the instance when it is new or reset. */
static void plcfmu_fresh(plcfmu_component_t *c) {
    memset(&c->instance, 0, sizeof c->instance);
    plcfmu_start(&c->instance.block);
    c->instance.clock = plcfmu_clock(0.0, PLCFMU_INFINITY, plcfmu_cycle(&c->instance.block));
    c->instance.state = PLCFMU_INSTANTIATED;
    c->ordinary_below = 0;
}

static plcfmu_status_t plcfmu_reset(plcfmu_component_t *c) {
    plcfmu_fresh(c);
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_go(plcfmu_component_t *c, int state) {
    c->instance.state = state;
    return PLCFMU_OK;
}

/* Creates a component whose instance is not set up; logs a message and returns NULL if there is no memory. */
static plcfmu_component_t *plcfmu_make(const char *name, plcfmu_logger_t logger, void *environment) {
    plcfmu_component_t *c = plcfmu_new_component();
    size_t length = name == NULL ? 0 : strlen(name);
    if (c == NULL) {
        plcfmu_log(logger, environment, length == 0 ? "" : name, PLCFMU_REFUSED, "logStatusError",
                   PLCFMU_INSTANTIATE_NAME ": no memory for another instance; free one, or compile with a larger "
                                           "PLCFMU_MAX_INSTANCES");
        return NULL;
    }
    c->logger = logger;
    c->environment = environment;
    length = length < sizeof c->name ? length : sizeof c->name - 1;
    if (length > 0) {
        memcpy(c->name, name, length);
    }
    c->logged = PLCFMU_ERROR | PLCFMU_FATAL;
    return c;
}

static plcfmu_status_t plcfmu_check_name(plcfmu_component_t *c, const char *name) {
    return name == NULL || name[0] == '\0' ? plcfmu_say_no_name(&c->text) : PLCFMU_OK;
}

/* Sets up the instance with the start values, unless the identifier, called `what` in the standard, belongs to another
   FMU. */
static plcfmu_status_t plcfmu_begin(plcfmu_component_t *c, const char *what, const char *identifier) {
    if (identifier == NULL || strcmp(identifier, PLCFMU_GUID) != 0) {
        plcfmu_text_t given = {0, {0}};
        if (identifier == NULL) {
            plcfmu_say(&given, "NULL");
        } else {
            plcfmu_say_quoted(&given, identifier);
        }
        return plcfmu_say_other_library(&c->text, what, given.text, PLCFMU_GUID);
    }
    plcfmu_fresh(c);
    if (!plcfmu_is_strict() || !plcfmu_is_exact(c)) {
        return plcfmu_refuse(&c->text, "this library was compiled with options that change its results (-ffast-math, fused "
                                       "multiply-add, x87 or similar): its self-test fails; compile it without them");
    }
    return PLCFMU_OK;
}

/* Returns the component, or frees it and returns NULL if it was refused. */
static plcfmu_component_t *plcfmu_made(plcfmu_component_t *c, plcfmu_status_t status, int logging_on) {
    if (plcfmu_leave(c, PLCFMU_INSTANTIATE, status) != PLCFMU_OK) {
        plcfmu_free_component(c);
        return NULL;
    }
    c->logged = logging_on ? PLCFMU_ALL : PLCFMU_ERROR | PLCFMU_FATAL;
    return c;
}

static void plcfmu_free(plcfmu_component_t *c) {
    while (c != NULL && c->saved != NULL) {
        plcfmu_saved_t *next = c->saved->next;
        plcfmu_free_state(c->saved);
        c->saved = next;
    }
    if (c != NULL) {
        plcfmu_free_component(c);
    }
}

static plcfmu_status_t plcfmu_set_debug_logging(plcfmu_component_t *c, int on, size_t count, const char *const names[]) {
    int selected = count == 0 ? PLCFMU_ALL : 0, category;
    size_t i;
    if (plcfmu_array(&c->text, names, count, sizeof *names, "categories") != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    for (i = 0; i < count; i += 1) {
        if (names[i] == NULL) {
            return plcfmu_say_no_category(&c->text);
        }
        for (category = 0; category < 4 && strcmp(names[i], plcfmu_categories[category]) != 0; category += 1) {
        }
        if (category == 4) {
            return plcfmu_say_unknown_category(&c->text, names[i]);
        }
        selected |= 1 << category;
    }
    c->logged = on ? selected : 0;
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_setup(plcfmu_component_t *c, double start, int has_stop, double stop) {
    if (!(plcfmu_abs_f64(start) <= 1.7976931348623157e308)) {
        return plcfmu_say_start_time(&c->text, start);
    }
    if (has_stop && !(stop >= start)) {
        return plcfmu_say_stop_time(&c->text, stop, start);
    }
    c->instance.has_experiment = 1;
    c->instance.start = start;
    c->instance.stop = has_stop ? stop : PLCFMU_INFINITY;
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_exit_initialization(plcfmu_component_t *c) {
    plcfmu_instance_t *instance = &c->instance;
    if (plcfmu_cycle(&instance->block) < 1) {
        return plcfmu_say_short_cycle(&c->text, PLCFMU_CYCLE_NAME, (double)plcfmu_cycle(&instance->block) / 1000.0);
    }
    if (plcfmu_check_settings(&instance->block, &c->text) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    plcfmu_restart(&instance->block, &c->other, &c->before, &c->text);
    memcpy(&instance->block, &c->other, sizeof c->other);
    instance->clock = plcfmu_clock(instance->start, instance->stop, plcfmu_cycle(&instance->block));
    instance->state = c->has_events ? PLCFMU_EVENT_MODE : PLCFMU_STEP_COMPLETE;
    c->ordinary_below = 0;
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_get_state(plcfmu_component_t *c, void **state) {
    plcfmu_saved_t *saved;
    if (plcfmu_target(&c->text, state, PLCFMU_STATE_NAME) != PLCFMU_OK || (saved = plcfmu_keep(c, state)) == NULL) {
        return PLCFMU_REFUSED;
    }
    memcpy(&saved->instance, &c->instance, sizeof c->instance);
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_set_state(plcfmu_component_t *c, void *state) {
    plcfmu_saved_t **link, *saved = plcfmu_find(c, state, &link);
    if (saved == NULL) {
        return PLCFMU_REFUSED;
    }
    if (saved->instance.state == PLCFMU_EVENT_MODE && !c->has_events) {
        return plcfmu_say_state_in_event_mode(&c->text);
    }
    memcpy(&c->instance, &saved->instance, sizeof c->instance);
    c->ordinary_below = 0;
    return PLCFMU_OK;
}

/* Frees a saved state and sets the pointer to NULL. Does nothing for NULL. */
static plcfmu_status_t plcfmu_drop_state(plcfmu_component_t *c, void **state) {
    plcfmu_saved_t **link, *saved;
    if (plcfmu_target(&c->text, state, PLCFMU_STATE_NAME) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    if (*state == NULL) {
        return PLCFMU_OK;
    }
    saved = plcfmu_find(c, *state, &link);
    if (saved == NULL) {
        return PLCFMU_REFUSED;
    }
    *link = saved->next;
    plcfmu_free_state(saved);
    *state = NULL;
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_size_of_state(plcfmu_component_t *c, void *state, size_t *size) {
    plcfmu_saved_t **link, *saved;
    if (plcfmu_target(&c->text, size, "size") != PLCFMU_OK || (saved = plcfmu_find(c, state, &link)) == NULL) {
        return PLCFMU_REFUSED;
    }
    *size = plcfmu_serialized_size(&saved->instance);
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_serialize_state(plcfmu_component_t *c, void *state, void *bytes, size_t size) {
    plcfmu_saved_t **link, *saved;
    size_t length;
    if (plcfmu_array(&c->text, bytes, size, 1, "serializedState") != PLCFMU_OK || (saved = plcfmu_find(c, state, &link)) == NULL) {
        return PLCFMU_REFUSED;
    }
    length = plcfmu_serialized_size(&saved->instance);
    if (size < length) {
        return plcfmu_say_small_buffer(&c->text, size, length);
    }
    plcfmu_serialize(&saved->instance, (unsigned char *)bytes, length);
    return PLCFMU_OK;
}

static plcfmu_status_t plcfmu_deserialize_state(plcfmu_component_t *c, const void *bytes, size_t size, void **state) {
    plcfmu_saved_t *saved, **link;
    int is_new;
    if (plcfmu_array(&c->text, bytes, size, 1, "serializedState") != PLCFMU_OK
        || plcfmu_target(&c->text, state, PLCFMU_STATE_NAME) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    /* A refused call changes nothing: the bytes are read into a separate state, which then replaces the old one. */
    is_new = *state == NULL;
    if (!is_new && plcfmu_find(c, *state, &link) == NULL) {
        return PLCFMU_REFUSED;
    }
    {
        void *read = NULL;
        saved = plcfmu_keep(c, &read);
        if (saved == NULL) {
            return PLCFMU_REFUSED;
        }
        if (plcfmu_deserialize(&c->text, (const unsigned char *)bytes, size, &saved->instance) != PLCFMU_OK) {
            c->saved = saved->next;
            plcfmu_free_state(saved);
            return PLCFMU_REFUSED;
        }
        if (is_new) {
            *state = read;
        } else {
            plcfmu_saved_t *old = plcfmu_find(c, *state, &link);
            memcpy(&old->instance, &saved->instance, sizeof saved->instance);
            c->saved = saved->next;
            plcfmu_free_state(saved);
        }
    }
    return PLCFMU_OK;
}

