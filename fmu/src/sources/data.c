
/* ------------------------------------------------------------------------------------------------------------------------
   The door: FMI for the program and the table above, identical in every FMU. It behaves like the library packed by
   plcfmu; docs/c_sources.md in plcfmu lists the differences. */

#if defined(__BYTE_ORDER__) && defined(__ORDER_LITTLE_ENDIAN__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "saved states are little endian, but this machine is not"
#endif

/* Fails to compile if the compiler's memory layout differs from the table's. */
typedef char plcfmu_memory_is_laid_out_as_in_the_table[sizeof(memory_t) == PLCFMU_MEMORY ? 1 : -1];

/* The maximum size of a message, in bytes. */
#define PLCFMU_LONGEST 700

/* The number of time derivatives that an input can have. */
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

/* Rounds to the nearest whole number, ties to even; every number above 2^52 is whole. */
static double plcfmu_round_f64(double number) {
    if (!(number > -4503599627370496.0 && number < 4503599627370496.0)) {
        return number;
    }
    return number < 0.0 ? (number - 4503599627370496.0) + 4503599627370496.0
                        : (number + 4503599627370496.0) - 4503599627370496.0;
}

/* The whole part of a small positive number. */
static double plcfmu_floor_f64(double number) { return (double)(i64_t)number; }

/* --- Data ------------------------------------------------------------------------------------------------------------- */

/* The states of an instance. A step is refused before it begins or runs to completion, so there are no others. */
enum {
    PLCFMU_INSTANTIATED = 1, PLCFMU_INITIALIZATION = 2, PLCFMU_STEP_COMPLETE = 4, PLCFMU_TERMINATED = 8, PLCFMU_EVENT_MODE = 32
};

/* Log categories. */
enum { PLCFMU_ERROR = 1, PLCFMU_DISCARD = 2, PLCFMU_FATAL = 4, PLCFMU_ADVICE = 8, PLCFMU_ALL = 15 };

static const char *const plcfmu_categories[] = {"logStatusError", "logStatusDiscard", "logStatusFatal", "logAdvice"};

/* The program with its memory. */
typedef struct {
    memory_t memory;
    i64_t calls;               /* number of calls since the restart */
    i64_t set[PLCFMU_ROWS];    /* values set by the host for variables with held != 0; start values of the others */
    i32_t cycle;               /* milliseconds; of a program only: a block has its cycle in memory */
    char stopped[PLCFMU_LONGEST]; /* why the program has stopped, or empty */
} plcfmu_block_t;

/* The clock of an instance. */
typedef struct {
    double start;   /* s */
    double stop;    /* s; infinite without a stop time */
    double cycle;   /* time between two calls, ms: a whole number */
    i64_t next;   /* the number of the next call */
    i64_t tick;   /* the current time, in ms since the start, is tick * cycle + offset */
    double offset;
    double end;     /* end of the last step, s, in the host's time; never decreases */
    double since;   /* the sum of all steps, s, as a host would add them up */
} plcfmu_clock_t;

/* An input extrapolated within a step. */
typedef struct {
    u32_t row;
    double value; /* its own value, saved while a step replaces it */
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

/* A message written piece by piece. Excess text is cut off. */
typedef struct {
    size_t length;
    char text[PLCFMU_LONGEST];
} plcfmu_text_t;

/* The object behind the host's instance pointer. */
typedef struct {
    plcfmu_instance_t instance;
    plcfmu_block_t other; /* a scratch block, in addition to the instance's */
    memory_t before;      /* the memory before a call, restored if the call stops */
    plcfmu_saved_t *saved;
    plcfmu_logger_t logger;
    void *environment;
    char name[256];
    i64_t ordinary_below; /* below this tick, a step of one CYCLE from the last end is known to be ordinary */
    double period;        /* the clock's CYCLE, s */
    int has_events;       /* calls are events that the host handles between steps */
    int may_return_early; /* a step may end early at a call */
    int logged;
    int is_step_advised;
    int is_conversion_advised;
    plcfmu_text_t text;
#ifdef PLCFMU_TEXTS
    char given[PLCFMU_TEXT_BYTES]; /* the texts returned to the host, in UTF-8 */
#endif
    int taken;
} plcfmu_component_t;

#define PLCFMU_I PLCFMU_INSTANTIATED
#define PLCFMU_N PLCFMU_INITIALIZATION
#define PLCFMU_E PLCFMU_EVENT_MODE
#define PLCFMU_C PLCFMU_STEP_COMPLETE
#define PLCFMU_T PLCFMU_TERMINATED

/* A function on a component and the states in which it is allowed. */
typedef struct {
    const char *name;
    int states;
} plcfmu_function_t;

typedef struct {
    int state;
    const char *name;
} plcfmu_state_name_t;
