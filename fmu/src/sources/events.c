
/* --- Calls as events, which the host handles between steps -------------------------------------------------------------- */

/* The tolerance, in milliseconds, within which times count as equal to the current one. */
static double plcfmu_same(const plcfmu_clock_t *clock) {
    return PLCFMU_SAME * clock->cycle
           + PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION * plcfmu_largest(plcfmu_abs_f64(clock->end), plcfmu_abs_f64(clock->start));
}

/* Whether the next call is due at the current time, within rounding. */
static int plcfmu_is_due(const plcfmu_clock_t *clock) {
    return (double)(clock->next - clock->tick) * clock->cycle - clock->offset <= plcfmu_same(clock);
}

/* The time of the next call, s. */
static double plcfmu_next_call(const plcfmu_clock_t *clock) {
    return clock->start + (double)clock->next * clock->cycle / 1000.0;
}

/* Makes the call that is due at the current time, if it has not been made yet. */
static plcfmu_status_t plcfmu_handle_event(plcfmu_component_t *c) {
    plcfmu_clock_t *clock = &c->instance.clock;
    plcfmu_block_t *block = &c->instance.block;
    if (plcfmu_same(clock) > 0.125 * clock->cycle) {
        return plcfmu_say_no_resolution(&c->text, "the time", clock->end, clock->cycle / 1000.0);
    }
    if (plcfmu_is_due(clock)) {
        clock->next += 1;
        c->ordinary_below = 0;
        plcfmu_call(block, &c->before, &c->text);
        plcfmu_show_mean(block, plcfmu_pulse(block), 1);
    }
    return plcfmu_check_running(c);
}

/* Makes a step. If early return is allowed and a call follows those due at the start, the step ends at that call.
   Returns the end of the step. */
static plcfmu_status_t plcfmu_step_between_events(plcfmu_component_t *c, double tc, double h, double *end, int *is_early) {
    plcfmu_clock_t clock = c->instance.clock;
    *end = tc + h;
    *is_early = 0;
    if (c->may_return_early) {
        double lead;
        plcfmu_calls_t calls;
        i64_t due = 0;
        if (plcfmu_advance(&clock, tc, h, &calls, &c->text) != PLCFMU_OK) {
            return PLCFMU_REFUSED;
        }
        lead = calls.lead;
        if (!(lead > 0.0)) {
            due = (i64_t)(-lead / (clock.cycle / 1000.0) + PLCFMU_SAME) + 1;
        }
        if (calls.count > due) {
            clock = c->instance.clock;
            clock.next += due;
            *end = plcfmu_next_call(&clock);
            *is_early = 1;
        }
    }
    return plcfmu_step(c, tc, *is_early ? plcfmu_largest(*end - tc, 0.0) : h);
}
