
/* ------------------------------------------------------------------------------------------------------------------------
   The door: FMI 2.0 for co-simulation over the program and the table above. The same in every FMU. It does what the library
   does that plcfmu packs; docs/c_sources.md of plcfmu has the table of differences. */

#if defined(__BYTE_ORDER__) && defined(__ORDER_LITTLE_ENDIAN__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "saved states have the bytes of a little endian machine, and this one is none"
#endif

/* Fails to compile if the compiler lays the memory out in another way than the table says. */
typedef char plcfmu_memory_is_laid_out_as_in_the_table[sizeof(memory_t) == PLCFMU_MEMORY ? 1 : -1];

/* The largest message. */
#define PLCFMU_LONGEST 700

/* How many time derivatives of an input can be given. */
#define PLCFMU_ORDERS 4

/* --- Numbers and their bits -------------------------------------------------------------------------------------------- */

static float plcfmu_f32_of(u32_t bits) {
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static double plcfmu_f64_of(u64_t bits) {
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static u32_t plcfmu_bits_f32(float number) {
    u32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static u64_t plcfmu_bits_f64(double number) {
    u64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static double plcfmu_abs_f64(double number) { return plcfmu_f64_of(plcfmu_bits_f64(number) & 0x7FFFFFFFFFFFFFFFull); }

/* To the nearest whole number, ties to even; from 2^52 on every number is whole. */
static double plcfmu_round_f64(double number) {
    if (!(number > -4503599627370496.0 && number < 4503599627370496.0)) {
        return number;
    }
    return number < 0.0 ? (number - 4503599627370496.0) + 4503599627370496.0
                        : (number + 4503599627370496.0) - 4503599627370496.0;
}

/* The whole part of a small number above 0. */
static double plcfmu_floor_f64(double number) { return (double)(i64_t)number; }

/* --- Data ------------------------------------------------------------------------------------------------------------- */

/* The states that an instance can be in. A step is refused before it begins or runs to its end, so there are no others. */
enum { PLCFMU_INSTANTIATED = 1, PLCFMU_INITIALIZATION = 2, PLCFMU_STEP_COMPLETE = 4, PLCFMU_TERMINATED = 8 };

/* Log categories. */
enum { PLCFMU_ERROR = 1, PLCFMU_DISCARD = 2, PLCFMU_FATAL = 4, PLCFMU_ADVICE = 8, PLCFMU_ALL = 15 };

static const char *const plcfmu_categories[] = {"logStatusError", "logStatusDiscard", "logStatusFatal", "logAdvice"};

/* The program with its memory. */
typedef struct {
    memory_t memory;
    i64_t calls;               /* since the restart */
    i64_t set[PLCFMU_ROWS];    /* what the host has set of variables that are held; start values of the others */
    i32_t cycle;               /* milliseconds; a block has it in its memory */
    char stopped[PLCFMU_LONGEST]; /* why the program has stopped, or nothing */
} plcfmu_block_t;

/* The time. Positions are milliseconds since the start. */
typedef struct {
    double start;   /* s */
    double stop;    /* s; infinite without a stop time */
    double cycle;   /* between two calls: whole milliseconds */
    i64_t next;   /* the number of the next call */
    i64_t tick;   /* the present time is tick * cycle + offset */
    double offset;
    double end;     /* of the last step, s, as the host gave it; the furthest end */
    double since;   /* the sum of all steps, s, as a host would add them up */
} plcfmu_clock_t;

/* An input that is extrapolated within a step. */
typedef struct {
    u32_t row;
    double value; /* its own value, while a step replaces it */
    double derivatives[PLCFMU_ORDERS];
} plcfmu_extrapolation_t;

/* An instance. A copy of it is a saved state. */
typedef struct {
    plcfmu_block_t block;
    plcfmu_clock_t clock;
    plcfmu_extrapolation_t extrapolations[PLCFMU_ROWS];
    size_t extrapolated;
    int state;
    int has_experiment;
    double start;
    double stop;
} plcfmu_instance_t;

typedef struct plcfmu_saved {
    plcfmu_instance_t instance;
    struct plcfmu_saved *next;
    int taken;
} plcfmu_saved_t;

/* A message that is written piece by piece. What is too long is cut. */
typedef struct {
    size_t length;
    char text[PLCFMU_LONGEST];
} plcfmu_text_t;

/* What a fmi2Component points to. */
typedef struct {
    plcfmu_instance_t instance;
    plcfmu_block_t other; /* a block to compute with beside that of the instance */
    memory_t before;      /* the memory before a call */
    plcfmu_saved_t *saved;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[256];
    i64_t ordinary_below; /* ticks: up to here a step of one CYCLE from where the last one ended is known to be ordinary */
    double period;        /* of the clock, s */
    int logged;
    int is_step_advised;
    plcfmu_text_t text;
#ifdef PLCFMU_TEXTS
    char given[PLCFMU_TEXT_BYTES]; /* the texts that a host was given, in UTF-8 */
#endif
    int taken;
} plcfmu_component_t;

/* The functions on a component with the states in which they are allowed: FMI 2.0, section 4.2.4, in its order. Two rows are
   more lenient because hosts need it: in state instantiated Get works and gives the start values, and inputs may be set. */
#define PLCFMU_I PLCFMU_INSTANTIATED
#define PLCFMU_N PLCFMU_INITIALIZATION
#define PLCFMU_C PLCFMU_STEP_COMPLETE
#define PLCFMU_T PLCFMU_TERMINATED

typedef struct {
    const char *name;
    int states;
} plcfmu_function_t;

static const plcfmu_function_t plcfmu_functions[] = {
    {"fmi2SetDebugLogging", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2Instantiate", 0},
    {"fmi2SetupExperiment", PLCFMU_I},
    {"fmi2EnterInitializationMode", PLCFMU_I},
    {"fmi2ExitInitializationMode", PLCFMU_N},
    {"fmi2Terminate", PLCFMU_C},
    {"fmi2Reset", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetReal", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetInteger", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetBoolean", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetString", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SetReal", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetInteger", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetBoolean", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2SetString", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2GetFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SetFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2FreeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SerializedFMUstateSize", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2SerializeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2DeSerializeFMUstate", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetDirectionalDerivative", PLCFMU_N | PLCFMU_C},
    {"fmi2SetRealInputDerivatives", PLCFMU_I | PLCFMU_N | PLCFMU_C},
    {"fmi2GetRealOutputDerivatives", PLCFMU_C | PLCFMU_T},
    {"fmi2DoStep", PLCFMU_C},
    {"fmi2CancelStep", PLCFMU_I | PLCFMU_N | PLCFMU_C | PLCFMU_T},
    {"fmi2GetStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetRealStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetIntegerStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetBooleanStatus", PLCFMU_C | PLCFMU_T},
    {"fmi2GetStringStatus", PLCFMU_C | PLCFMU_T},
};

enum {
    PLCFMU_SET_DEBUG_LOGGING, PLCFMU_INSTANTIATE, PLCFMU_SETUP_EXPERIMENT, PLCFMU_ENTER_INITIALIZATION,
    PLCFMU_EXIT_INITIALIZATION, PLCFMU_TERMINATE, PLCFMU_RESET, PLCFMU_GET_REAL, PLCFMU_GET_INTEGER, PLCFMU_GET_BOOLEAN,
    PLCFMU_GET_STRING, PLCFMU_SET_REAL, PLCFMU_SET_INTEGER, PLCFMU_SET_BOOLEAN, PLCFMU_SET_STRING, PLCFMU_GET_STATE,
    PLCFMU_SET_STATE, PLCFMU_FREE_STATE, PLCFMU_SERIALIZED_SIZE, PLCFMU_SERIALIZE, PLCFMU_DESERIALIZE,
    PLCFMU_GET_DIRECTIONAL_DERIVATIVE, PLCFMU_SET_INPUT_DERIVATIVES, PLCFMU_GET_OUTPUT_DERIVATIVES, PLCFMU_DO_STEP,
    PLCFMU_CANCEL_STEP, PLCFMU_GET_STATUS, PLCFMU_GET_REAL_STATUS, PLCFMU_GET_INTEGER_STATUS, PLCFMU_GET_BOOLEAN_STATUS,
    PLCFMU_GET_STRING_STATUS
};

/* --- Messages --------------------------------------------------------------------------------------------------------- */

static void plcfmu_say(plcfmu_text_t *text, const char *more) {
    size_t length = strlen(more), room = sizeof text->text - 1 - text->length;
    length = length < room ? length : room;
    memcpy(text->text + text->length, more, length);
    text->length += length;
    text->text[text->length] = '\0';
}

static void plcfmu_say_whole(plcfmu_text_t *text, i64_t number) {
    char digits[24];
    size_t at = sizeof digits - 1;
    u64_t rest = number < 0 ? 0u - (u64_t)number : (u64_t)number;
    digits[at] = '\0';
    do {
        at -= 1;
        digits[at] = (char)('0' + (int)(rest % 10u));
        rest /= 10u;
    } while (rest != 0);
    plcfmu_say(text, number < 0 ? "-" : "");
    plcfmu_say(text, digits + at);
}

/* A text of the host, cut if it is long, without line breaks. */
static void plcfmu_say_quoted(plcfmu_text_t *text, const char *given) {
    static const char hex[] = "0123456789abcdef";
    size_t i;
    plcfmu_say(text, "\"");
    for (i = 0; given[i] != '\0' && i < 200; i += 1) {
        char one[3] = {'\\', 0, 0}, code[7] = {'\\', 'u', '{', 0, 0, '}', 0};
        unsigned char byte = (unsigned char)given[i];
        if (byte == '"' || byte == '\\' || byte == '\n' || byte == '\r' || byte == '\t') {
            one[1] = byte == '\n' ? 'n' : byte == '\r' ? 'r' : byte == '\t' ? 't' : given[i];
            plcfmu_say(text, one);
        } else if (byte < 0x20 || byte == 0x7f) {
            code[3] = hex[byte >> 4];
            code[4] = hex[byte & 15];
            plcfmu_say(text, code);
        } else {
            one[0] = given[i];
            plcfmu_say(text, one);
        }
    }
    plcfmu_say(text, given[i] == '\0' ? "\"" : "...\"");
}

/* Numbers of 1280 bits, enough for all digits of a double. */
#define PLCFMU_LIMBS 40
typedef struct {
    u32_t limbs[PLCFMU_LIMBS];
} plcfmu_big_t;

static void plcfmu_big_times(plcfmu_big_t *a, u32_t factor) {
    u64_t carry = 0;
    int i;
    for (i = 0; i < PLCFMU_LIMBS; i += 1) {
        carry += (u64_t)a->limbs[i] * factor;
        a->limbs[i] = (u32_t)carry;
        carry >>= 32;
    }
}

static void plcfmu_big_power(plcfmu_big_t *a, u32_t base, int exponent) {
    for (; exponent > 0; exponent -= 1) {
        plcfmu_big_times(a, base);
    }
}

/* a + sign * b */
static plcfmu_big_t plcfmu_big_sum(const plcfmu_big_t *a, const plcfmu_big_t *b, int sign) {
    plcfmu_big_t sum;
    i64_t carry = 0;
    int i;
    for (i = 0; i < PLCFMU_LIMBS; i += 1) {
        carry += (i64_t)a->limbs[i] + sign * (i64_t)b->limbs[i];
        sum.limbs[i] = (u32_t)(u64_t)carry;
        carry = carry < 0 ? -1 : carry >> 32;
    }
    return sum;
}

static int plcfmu_big_compare(const plcfmu_big_t *a, const plcfmu_big_t *b) {
    int i;
    for (i = PLCFMU_LIMBS - 1; i >= 0; i -= 1) {
        if (a->limbs[i] != b->limbs[i]) {
            return a->limbs[i] < b->limbs[i] ? -1 : 1;
        }
    }
    return 0;
}

/* The shortest digits that give the number back, which is finite and above 0. It is 0.DIGITS * 10^(the result). */
static int plcfmu_digits(double number, char *digits) {
    u64_t bits, mantissa;
    int exponent, is_even, power, low = 0, high = 0;
    plcfmu_big_t rest = {{0}}, scale = {{0}}, above = {{0}}, below, sum;
    memcpy(&bits, &number, sizeof bits);
    mantissa = bits & 0xFFFFFFFFFFFFFull;
    exponent = (int)(bits >> 52) & 0x7FF;
    mantissa |= exponent > 0 ? 0x10000000000000ull : 0u;
    exponent = (exponent > 0 ? exponent : 1) - 1075;
    is_even = (mantissa & 1u) == 0;
    /* The number is rest / scale, and half of the distance to the next one above / scale, to the last one below / scale. */
    rest.limbs[0] = (u32_t)mantissa;
    rest.limbs[1] = (u32_t)(mantissa >> 32);
    scale.limbs[0] = above.limbs[0] = 1;
    plcfmu_big_power(&rest, 2, exponent > 0 ? exponent + 1 : 1);
    plcfmu_big_power(&above, 2, exponent > 0 ? exponent : 0);
    plcfmu_big_power(&scale, 2, exponent > 0 ? 1 : 1 - exponent);
    below = above;
    if (mantissa == 0x10000000000000ull && exponent > -1074) {
        /* Below a power of 2 the numbers are twice as dense. */
        plcfmu_big_times(&rest, 2);
        plcfmu_big_times(&scale, 2);
        plcfmu_big_times(&above, 2);
    }
    for (power = 0;; power += 1) {
        sum = plcfmu_big_sum(&rest, &above, 1);
        if (plcfmu_big_compare(&sum, &scale) < (is_even ? 0 : 1)) {
            break;
        }
        plcfmu_big_times(&scale, 10);
    }
    for (; power <= 0; power -= 1) {
        plcfmu_big_t next = plcfmu_big_sum(&rest, &above, 1);
        plcfmu_big_times(&next, 10);
        if (plcfmu_big_compare(&next, &scale) >= (is_even ? 0 : 1)) {
            break;
        }
        plcfmu_big_times(&rest, 10);
        plcfmu_big_times(&above, 10);
        plcfmu_big_times(&below, 10);
    }
    while (!low && !high) {
        int digit = 0;
        plcfmu_big_times(&rest, 10);
        plcfmu_big_times(&above, 10);
        plcfmu_big_times(&below, 10);
        while (plcfmu_big_compare(&rest, &scale) >= 0) {
            rest = plcfmu_big_sum(&rest, &scale, -1);
            digit += 1;
        }
        low = plcfmu_big_compare(&rest, &below) < (is_even ? 1 : 0);
        sum = plcfmu_big_sum(&rest, &above, 1);
        high = plcfmu_big_compare(&sum, &scale) > (is_even ? -1 : 0);
        if (low || high) {
            plcfmu_big_times(&rest, 2);
            digit += high && (!low || plcfmu_big_compare(&rest, &scale) >= 0) ? 1 : 0;
        }
        *digits = (char)('0' + digit);
        digits += 1;
    }
    *digits = '\0';
    return power;
}

/* A number as short as it can be: 0.1, 5.0, 1e300; without the ".0" if it is `plain`. */
static void plcfmu_say_number(plcfmu_text_t *text, double number, int plain) {
    char digits[32], one[2] = {0, 0};
    int count, power, i;
    if (number != number) {
        plcfmu_say(text, "NaN");
        return;
    }
    plcfmu_say(text, plcfmu_bits_f64(number) >> 63 ? "-" : "");
    number = plcfmu_abs_f64(number);
    if (number > 1.7976931348623157e308) {
        plcfmu_say(text, "inf");
        return;
    }
    if (number == 0.0) {
        plcfmu_say(text, plain ? "0" : "0.0");
        return;
    }
    power = plcfmu_digits(number, digits);
    count = (int)strlen(digits);
    if (number < 1e-5 || number >= 1e16) {
        one[0] = digits[0];
        plcfmu_say(text, one);
        plcfmu_say(text, count > 1 ? "." : "");
        plcfmu_say(text, digits + 1);
        plcfmu_say(text, "e");
        plcfmu_say_whole(text, power - 1);
        return;
    }
    plcfmu_say(text, power <= 0 ? "0." : "");
    for (i = power; i < 0; i += 1) {
        plcfmu_say(text, "0");
    }
    for (i = 0; i < count || i < power; i += 1) {
        one[0] = i < count ? digits[i] : '0';
        plcfmu_say(text, i == power && i > 0 ? "." : "");
        plcfmu_say(text, one);
    }
    plcfmu_say(text, count <= power && !plain ? ".0" : "");
}

static void plcfmu_say_named(plcfmu_text_t *text, const char *before, double number, const char *behind) {
    plcfmu_say(text, before);
    plcfmu_say_number(text, number, 0);
    plcfmu_say(text, behind);
}

/* Refuses with a sentence that is finished. */
static fmi2Status plcfmu_refuse(plcfmu_text_t *text, const char *sentence) {
    plcfmu_say(text, sentence);
    return fmi2Error;
}

/* Tells the host, if it wants to know: "FUNCTION: message", in which # begins the reference to a variable and is doubled. */
static void plcfmu_tell(plcfmu_component_t *c, int function, fmi2Status status) {
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
        c->logger(c->environment, c->name, status, plcfmu_categories[category], "%s", text);
    }
    c->text.length = 0;
    c->text.text[0] = '\0';
}

/* Whether a function may be called now. */
static fmi2Status plcfmu_enter(plcfmu_component_t *c, int function) {
    static const char *const names[] = {"instantiated", "Initialization Mode", "stepComplete", "terminated"};
    const char *comma = "";
    int state;
    if (c == NULL) {
        return fmi2Error;
    }
    if (plcfmu_functions[function].states & c->instance.state) {
        return fmi2OK;
    }
    plcfmu_say(&c->text, "not allowed in state ");
    for (state = 0; state < 4; state += 1) {
        plcfmu_say(&c->text, c->instance.state >> state & 1 ? names[state] : "");
    }
    plcfmu_say(&c->text, ", only in ");
    for (state = 0; state < 4; state += 1) {
        if (plcfmu_functions[function].states >> state & 1) {
            plcfmu_say(&c->text, comma);
            plcfmu_say(&c->text, names[state]);
            comma = ", ";
        }
    }
    return fmi2Error;
}

/* What a function answers; a refusal is logged. */
static fmi2Status plcfmu_leave(plcfmu_component_t *c, int function, fmi2Status status) {
    if (c != NULL && (status != fmi2OK || c->text.length > 0)) {
        plcfmu_tell(c, function, status);
    }
    return status;
}

/* Whether an array of the host can be read. */
static fmi2Status plcfmu_array(plcfmu_text_t *text, const void *array, size_t count, size_t size, const char *name) {
    if (array == NULL && count > 0) {
        plcfmu_say(text, name);
        plcfmu_say(text, " is NULL, though it should have ");
    } else if (count > (size_t)-1 / 2 / size) {
        plcfmu_say(text, name);
        plcfmu_say(text, " cannot have ");
    } else {
        return fmi2OK;
    }
    if ((u64_t)count > (u64_t)I64_MAX) {
        plcfmu_say_whole(text, (i64_t)(count / 10u));
        plcfmu_say_whole(text, (i64_t)(count % 10u));
    } else {
        plcfmu_say_whole(text, (i64_t)count);
    }
    return plcfmu_refuse(text, " elements");
}

static fmi2Status plcfmu_target(plcfmu_text_t *text, const void *target, const char *name) {
    if (target != NULL) {
        return fmi2OK;
    }
    plcfmu_say(text, name);
    return plcfmu_refuse(text, " is NULL");
}
