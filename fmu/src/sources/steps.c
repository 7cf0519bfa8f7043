
/* --- Clock: integer ticks of whole milliseconds ------------------------------------------------------------------------

   The program is called at start + k * CYCLE, k = 0, 1, 2, ..., regardless of the communication step: a step makes every
   call with tc <= t < tc + h. The time of a host that adds up is off by the rounding of every addition; a host that
   recomputes its time may pass a rounded h. The clock therefore continues from its own time if rounding explains the
   difference from tc, and from tc otherwise. If the host is ahead, the calls in between are made. */

#define PLCFMU_SAME 1e-6                             /* times closer than this fraction of a CYCLE are equal */
#define PLCFMU_MOST_DRIFT 0.25                       /* maximum drift of a host that adds up, as a fraction of a CYCLE */
#define PLCFMU_ROUNDINGS 4.0                         /* rounding errors that may separate two times meant to be equal */
#define PLCFMU_EPSILON 2.220446049250313e-16
#define PLCFMU_RESOLUTION (PLCFMU_EPSILON * 1000.0)  /* resolution of a double at 1 s, in milliseconds */
#define PLCFMU_MOST_CALLS 4294967296.0               /* maximum in one step; a day at 1 ms has 86 million */
#define PLCFMU_ORDINARY_STEPS 1000.0                 /* steps covered by one check, with the current one */
#define PLCFMU_INFINITY plcfmu_f64_of(0x7FF0000000000000ull)

/* The calls of one step. */
typedef struct {
    i64_t count;
    double lead; /* from the start of the step to the first call, s; negative if the step catches up on calls */
} plcfmu_calls_t;

static plcfmu_clock_t plcfmu_clock(double start, double stop, i32_t cycle) {
    plcfmu_clock_t clock = {0, 0, 0, 0, 0, 0, 0, 0};
    clock.start = start;
    clock.stop = stop;
    clock.cycle = (double)cycle;
    clock.end = start;
    return clock;
}

static double plcfmu_largest(double a, double b) { return a > b ? a : b; }

/* Whether a step goes from the end of the last one, at a tick, to the next tick, with its only call at its start. No
   check can then fail. */
static int plcfmu_is_ordinary(const plcfmu_clock_t *clock, double tc, double h) {
    double period = clock->cycle / 1000.0, from_0 = plcfmu_abs_f64(clock->start);
    double resolved = 0.1 * clock->cycle / (PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION);
    double last = clock->stop - 2.0 * period;
    double horizon = from_0 < resolved ? (last < resolved ? last : resolved) : -PLCFMU_INFINITY;
    double drift, rounding;
    if (!(h == period && clock->offset == 0.0 && clock->next == clock->tick && tc < horizon)) {
        return 0;
    }
    drift = plcfmu_abs_f64((tc - clock->start) * 1000.0 - (double)clock->tick * clock->cycle);
    if (tc == clock->end) {
        return drift < PLCFMU_MOST_DRIFT * clock->cycle;
    }
    rounding = period * 1000.0 == clock->cycle ? PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION : -1.0;
    rounding *= plcfmu_largest(plcfmu_abs_f64(tc) < plcfmu_abs_f64(clock->end) ? plcfmu_abs_f64(tc) : plcfmu_abs_f64(clock->end), from_0);
    return drift <= rounding && (clock->end - tc) * 1000.0 <= PLCFMU_SAME * clock->cycle + rounding;
}

/* Whether, after an ordinary step from tc, the next steps of one CYCLE are ordinary, too: they end before the horizon,
   and the rounding errors of the clock's end cannot add up to the permitted drift. */
static int plcfmu_stays_ordinary(const plcfmu_clock_t *clock, double tc, double steps) {
    double period = clock->cycle / 1000.0, last = tc + (steps + 1.0) * period, from_0 = plcfmu_abs_f64(clock->start);
    double resolved = 0.1 * clock->cycle / (PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION), end = clock->stop - 2.0 * period;
    double magnitude = plcfmu_largest(plcfmu_largest(plcfmu_abs_f64(tc), plcfmu_abs_f64(last)), from_0);
    double rounding = PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION * magnitude;
    double drift = plcfmu_abs_f64((tc - clock->start) * 1000.0 - (double)clock->tick * clock->cycle);
    return last < (end < resolved ? end : resolved) && from_0 < resolved
           && drift + (steps + 1.0) * rounding < 0.9 * PLCFMU_MOST_DRIFT * clock->cycle;
}

/* Advances the clock from tc to tc + h and returns the calls in between. If the step is refused, the clock does not
   advance. */
static plcfmu_status_t plcfmu_advance(plcfmu_clock_t *clock, double tc, double h, plcfmu_calls_t *calls, plcfmu_text_t *text) {
    double cycle = clock->cycle, per_cycle = 1.0 / cycle, period = cycle / 1000.0;
    double magnitude, same, rounding, position, offset = clock->offset, since = clock->since;
    double step, present, lead, tolerance, cycles, most = 1.7976931348623157e308;
    i64_t tick = clock->tick, first = clock->next, passed, next;
    calls->count = 0;
    calls->lead = 0.0;
    if (!(h >= 0.0 && h <= most && plcfmu_abs_f64(tc) <= most)) {
        return plcfmu_say_no_time(text, tc, h);
    }
    magnitude = plcfmu_largest(plcfmu_abs_f64(tc), plcfmu_abs_f64(clock->start));
    same = PLCFMU_SAME * cycle + PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION * magnitude;
    if (same > 0.125 * cycle) {
        return plcfmu_say_no_resolution(text, "currentCommunicationPoint", tc, period);
    }
    if ((clock->end - tc) * 1000.0 > same) {
        return plcfmu_say_before_end(text, tc, clock->end);
    }
    rounding = tc == clock->end || tc == clock->start + clock->since ? PLCFMU_MOST_DRIFT * cycle
                                                                     : PLCFMU_ROUNDINGS * PLCFMU_RESOLUTION * magnitude;
    position = (tc - clock->start) * 1000.0;
    if (plcfmu_abs_f64(position - ((double)tick * cycle + offset)) > rounding) {
        tick = (i64_t)(position * per_cycle);
        offset = position - (double)tick * cycle;
        since = tc - clock->start;
    }
    step = h * 1000.0;
    present = (double)tick * cycle + offset;
    if (clock->stop <= most) {
        double beyond = present + step - (clock->stop - clock->start) * 1000.0;
        if (beyond > 0.0) {
            double behind = (tc + h - clock->stop) * 1000.0;
            if ((beyond < behind ? beyond : behind) > same) {
                return plcfmu_say_after_stop(text, tc, h, clock->stop);
            }
            step -= beyond;
        }
    }
    if (h == 0.0) {
        /* Some hosts end a run with such a step. It makes no call and does not advance the clock. */
        return PLCFMU_OK;
    }
    lead = (double)first * cycle - present;
    /* A long step adds a rounding error. */
    tolerance = (same + PLCFMU_ROUNDINGS * PLCFMU_EPSILON * step) * per_cycle;
    cycles = (offset + step) * per_cycle;
    if (cycles + (double)(tick - first) > PLCFMU_MOST_CALLS) {
        return plcfmu_say_too_many_calls(text, tc, h, clock->end, period);
    }
    passed = (i64_t)(cycles + tolerance);
    next = (i64_t)(cycles - tolerance);
    next = tick + next + (cycles - tolerance > (double)next ? 1 : 0);
    clock->tick = tick + passed;
    clock->next = next > first ? next : first;
    clock->offset = offset + step - (double)passed * cycle;
    clock->end = tc + h > clock->end ? tc + h : clock->end;
    clock->since = since + h;
    calls->count = clock->next - first;
    calls->lead = plcfmu_abs_f64(lead) > same ? lead / 1000.0 : 0.0;
    return PLCFMU_OK;
}

/* --- Steps ------------------------------------------------------------------------------------------------------------ */

/* The value extrapolated by t seconds; an upper bound of its magnitude if `is_bound`. */
static double plcfmu_at(double value, const double *derivatives, double t, int is_bound) {
    double factor = 1.0;
    int order;
    for (order = 0; order < PLCFMU_ORDERS; order += 1) {
        factor *= t / (double)(order + 1);
        value += (is_bound ? plcfmu_abs_f64(derivatives[order]) : derivatives[order]) * factor;
    }
    return value;
}

static void plcfmu_put_number(plcfmu_block_t *block, u32_t row, double number) {
    i64_t bits;
    if (plcfmu_bits_of(number, plcfmu_rows[row].kind, &bits) == NULL) {
        plcfmu_put(block, row, bits);
    }
}

/* Makes the step if it is known to be ordinary and returns whether it did: its times then need no checks. plcfmu_step
   does the same, more slowly. */
static int plcfmu_is_ordinary_step(plcfmu_component_t *c, double tc, double h) {
    plcfmu_clock_t *clock = &c->instance.clock;
    if (!(clock->tick < c->ordinary_below && tc == clock->end && h == c->period && c->instance.extrapolated == 0)) {
        return 0;
    }
    clock->tick += 1;
    clock->next = clock->tick;
    clock->end = tc + h;
    clock->since += h;
    plcfmu_call(&c->instance.block, &c->before, &c->text);
    plcfmu_show_mean(&c->instance.block, plcfmu_pulse(&c->instance.block), 1);
    return 1;
}

static plcfmu_status_t plcfmu_check_running(plcfmu_component_t *c) {
    const char *stopped = c->instance.block.stopped;
    return stopped[0] == '\0' ? PLCFMU_OK : plcfmu_refuse(&c->text, stopped);
}

/* Makes every call from tc up to but not including tc + h. */
static plcfmu_status_t plcfmu_step(plcfmu_component_t *c, double tc, double h) {
    plcfmu_instance_t *instance = &c->instance;
    plcfmu_clock_t clock = instance->clock;
    double period = clock.cycle / 1000.0;
    plcfmu_calls_t calls;
    i64_t call, pulses = 0;
    size_t i;
    c->ordinary_below = 0;
    if (plcfmu_is_ordinary(&clock, tc, h) && plcfmu_stays_ordinary(&clock, tc, PLCFMU_ORDINARY_STEPS)) {
        c->ordinary_below = clock.tick + (i64_t)PLCFMU_ORDINARY_STEPS;
        c->period = period;
    }
    if (plcfmu_advance(&clock, tc, h, &calls, &c->text) != PLCFMU_OK) {
        return PLCFMU_REFUSED;
    }
    for (i = 0; i < instance->extrapolated; i += 1) {
        plcfmu_extrapolation_t *input = &instance->extrapolations[i];
        const plcfmu_row_t *row = &plcfmu_rows[input->row];
        double last = plcfmu_largest(calls.lead + (double)calls.count * period, 0.0);
        const char *range;
        i64_t bits;
        input->value = plcfmu_number(row->kind, plcfmu_bits(&instance->block, input->row));
        /* An upper bound of the value's magnitude within the step. If the bound is in range, every value is. */
        range = plcfmu_bits_of(plcfmu_at(plcfmu_abs_f64(input->value), input->derivatives, last, 1), row->kind, &bits);
        if (range != NULL) {
            return plcfmu_say_extrapolated(&c->text, row->name, last, range);
        }
    }
    instance->clock = clock;
    for (call = 0; call < calls.count; call += 1) {
        double t = plcfmu_largest(calls.lead + (double)call * period, 0.0);
        for (i = 0; i < instance->extrapolated; i += 1) {
            const plcfmu_extrapolation_t *input = &instance->extrapolations[i];
            plcfmu_put_number(&instance->block, input->row, plcfmu_at(input->value, input->derivatives, t, 0));
        }
        plcfmu_call(&instance->block, &c->before, &c->text);
        pulses += plcfmu_pulse(&instance->block);
    }
    for (i = 0; i < instance->extrapolated; i += 1) {
        plcfmu_put_number(&instance->block, instance->extrapolations[i].row, instance->extrapolations[i].value);
    }
    plcfmu_show_mean(&instance->block, pulses, calls.count);
    return plcfmu_check_running(c);
}

/* Advises the host, once, if a step is so short that CYCLE may be in the wrong unit. */
static void plcfmu_advise(plcfmu_component_t *c, double h) {
    double cycle = c->instance.clock.cycle / 1000.0;
    /* Steps below a microsecond are rounding remainders of a host's time. */
    if (!c->is_step_advised && (c->logged & PLCFMU_ADVICE) && 1e-6 < h && h < cycle / 100.0) {
        plcfmu_say_short_step(&c->text, h, PLCFMU_CYCLE_NAME, cycle, plcfmu_round_f64(cycle / h));
        c->is_step_advised = 1;
    }
}
