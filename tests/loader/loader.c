/* Loads an FMU's library on the system that it was built for and makes the calls that arrive on standard input, so that
 * tests in Python can drive a library of Windows (under Wine) or of another processor (under qemu).
 *
 *   x86_64-w64-mingw32-gcc -O1 -o loader.exe loader.c        wine loader.exe CONT_C.dll
 *   aarch64-linux-gnu-gcc -O1 -o loader loader.c -ldl        qemu-aarch64 -L SYSROOT loader CONT_C.so
 *
 * Numbers are little endian. A call:
 *   u32 function (its place in FUNCTIONS), u32 count, and so many arguments of: u8 kind and
 *     'i'  i64                          an integer, of whatever width the function takes
 *     'd'  f64
 *     'p'  u64                          an address of this process, or 0 for NULL
 *     'b'  u32 length, bytes            a pointer to these bytes; the answer has them as they are after the call
 *     's'  u32 count, (u32 length, bytes) each; length 0xffffffff is NULL     a pointer to an array of strings
 *     'c'  u64 environment, u8 logger   a pointer to fmi2CallbackFunctions, without a logger if that is 0
 * The answer:
 *   u32 count of messages, each: u64 environment, i32 status, three texts (instance, category, message: u32 length, bytes)
 *   u64 result, a text (what the result points to, if the function returns a string), and each 'b' again: u32 length, bytes
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#include <windows.h>
#else
#include <dlfcn.h>
#endif

static const char *const FUNCTIONS[] = {
    "fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2SetDebugLogging", "fmi2Instantiate", "fmi2FreeInstance",
    "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2Reset",
    "fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2GetString",
    "fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean", "fmi2SetString",
    "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate",
    "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative", "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives",
    "fmi2DoStep", "fmi2CancelStep",
    "fmi2GetStatus", "fmi2GetRealStatus", "fmi2GetIntegerStatus", "fmi2GetBooleanStatus", "fmi2GetStringStatus",
    "plcfmu_interface",
};
enum { COUNT = sizeof FUNCTIONS / sizeof *FUNCTIONS, MOST = 8 };

typedef struct {
    void *logger, *allocate, *free, *step_finished, *environment;
} Callbacks;

typedef struct {
    char kind;
    int64_t i;
    double d;
    void *p;
    uint32_t length;
} Argument;

static Argument given[MOST];

/* Messages of the call that runs. */
static char *messages;
static size_t messages_length, messages_room;
static uint32_t messages_count;

static void end(const char *why) {
    fprintf(stderr, "loader: %s\n", why);
    exit(2);
}

static void add(const void *bytes, size_t length) {
    if (messages_length + length > messages_room) {
        messages_room = 2 * (messages_length + length);
        messages = realloc(messages, messages_room);
        if (!messages) end("out of memory");
    }
    memcpy(messages + messages_length, bytes, length);
    messages_length += length;
}

static void add_text(const char *text) {
    uint32_t length = (uint32_t)strlen(text);
    add(&length, sizeof length);
    add(text, length);
}

static void logger(void *environment, const char *instance, int status, const char *category, const char *format, ...) {
    char text[65536];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    uint64_t number = (uint64_t)(uintptr_t)environment;
    int32_t status32 = status;
    add(&number, sizeof number);
    add(&status32, sizeof status32);
    add_text(instance);
    add_text(category);
    add_text(text);
    messages_count++;
}

static void take(void *bytes, size_t length) {
    if (fread(bytes, 1, length, stdin) != length) exit(0);
}

static void give(const void *bytes, size_t length) {
    fwrite(bytes, 1, length, stdout);
}

static void *block(size_t length) {
    void *bytes = malloc(length + 1);
    if (!bytes) end("out of memory");
    return bytes;
}

static void take_argument(Argument *argument) {
    memset(argument, 0, sizeof *argument);
    take(&argument->kind, 1);
    switch (argument->kind) {
    case 'i': take(&argument->i, 8); break;
    case 'd': take(&argument->d, 8); break;
    case 'p': {
        uint64_t address;
        take(&address, 8);
        argument->p = (void *)(uintptr_t)address;
        break;
    }
    case 'b':
        take(&argument->length, 4);
        argument->p = block(argument->length);
        take(argument->p, argument->length);
        break;
    case 's': {
        uint32_t count;
        take(&count, 4);
        char **strings = block(count * sizeof *strings);
        for (uint32_t i = 0; i < count; i++) {
            uint32_t length;
            take(&length, 4);
            strings[i] = NULL;
            if (length != UINT32_MAX) {
                strings[i] = block(length);
                take(strings[i], length);
                strings[i][length] = 0;
            }
        }
        argument->p = strings;
        break;
    }
    case 'c': {
        uint64_t environment;
        char has_logger;
        take(&environment, 8);
        take(&has_logger, 1);
        /* Overwritten right after the call: an FMU has to copy it. */
        Callbacks *callbacks = block(sizeof *callbacks);
        memset(callbacks, 0, sizeof *callbacks);
        callbacks->logger = has_logger ? (void *)logger : NULL;
        callbacks->environment = (void *)(uintptr_t)environment;
        argument->p = callbacks;
        break;
    }
    default: end("unknown kind of argument");
    }
}

#define P(n) given[n].p
#define I(n) ((int)given[n].i)
#define U(n) ((unsigned)given[n].i)
#define Z(n) ((size_t)given[n].i)
#define D(n) given[n].d
#define CALL(type, ...) ((type)function)(__VA_ARGS__)

typedef void *V;
typedef size_t S;

static uint64_t call(uint32_t number, void *function) {
    switch (number) {
    case 0: case 1: return (uintptr_t)CALL(const char *(*)(void));
    case 2: return CALL(int (*)(V, int, S, V), P(0), I(1), Z(2), P(3));
    case 3: return (uintptr_t)CALL(V (*)(V, int, V, V, V, int, int), P(0), I(1), P(2), P(3), P(4), I(5), I(6));
    case 4: CALL(void (*)(V), P(0)); return 0;
    case 5: return CALL(int (*)(V, int, double, double, int, double), P(0), I(1), D(2), D(3), I(4), D(5));
    case 6: case 7: case 8: case 9: case 28: return CALL(int (*)(V), P(0));
    case 10: case 11: case 12: case 13: case 14: case 15: case 16: case 17:
        return CALL(int (*)(V, V, S, V), P(0), P(1), Z(2), P(3));
    case 18: case 19: case 20: return CALL(int (*)(V, V), P(0), P(1));
    case 21: return CALL(int (*)(V, V, V), P(0), P(1), P(2));
    case 22: return CALL(int (*)(V, V, V, S), P(0), P(1), P(2), Z(3));
    case 23: return CALL(int (*)(V, V, S, V), P(0), P(1), Z(2), P(3));
    case 24: return CALL(int (*)(V, V, S, V, S, V, V), P(0), P(1), Z(2), P(3), Z(4), P(5), P(6));
    case 25: case 26: return CALL(int (*)(V, V, S, V, V), P(0), P(1), Z(2), P(3), P(4));
    case 27: return CALL(int (*)(V, double, double, int), P(0), D(1), D(2), I(3));
    case 29: case 30: case 31: case 32: case 33: return CALL(int (*)(V, int, V), P(0), I(1), P(2));
    case 34: return CALL(S (*)(V, S), P(0), Z(1));
    default: end("unknown function");
    }
    return 0;
}

int main(int count, char **arguments) {
    if (count != 2) end("usage: loader LIBRARY < calls > answers");
    void *functions[COUNT];
#ifdef _WIN32
    _setmode(_fileno(stdin), _O_BINARY);
    _setmode(_fileno(stdout), _O_BINARY);
    HMODULE library = LoadLibraryA(arguments[1]);
    if (!library) end("LoadLibrary fails");
#else
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) end(dlerror());
#endif
    for (int i = 0; i < COUNT; i++) {
#ifdef _WIN32
        functions[i] = (void *)GetProcAddress(library, FUNCTIONS[i]);
#else
        functions[i] = dlsym(library, FUNCTIONS[i]);
#endif
        if (!functions[i]) end(FUNCTIONS[i]);
    }
    for (;;) {
        uint32_t number, arguments_count;
        take(&number, 4);
        take(&arguments_count, 4);
        if (number >= COUNT || arguments_count > MOST) end("damaged call");
        memset(given, 0, sizeof given);
        for (uint32_t i = 0; i < arguments_count; i++) take_argument(&given[i]);
        messages_length = messages_count = 0;
        uint64_t result = call(number, functions[number]);
        give(&messages_count, 4);
        give(messages, messages_length);
        give(&result, 8);
        const char *text = number < 2 ? (const char *)(uintptr_t)result : "";
        uint32_t length = (uint32_t)strlen(text);
        give(&length, 4);
        give(text, length);
        for (uint32_t i = 0; i < arguments_count; i++) {
            if (given[i].kind == 'b') {
                give(&given[i].length, 4);
                give(given[i].p, given[i].length);
            }
            if (given[i].kind == 'b' || given[i].kind == 'c') {
                memset(given[i].p, 0x55, given[i].kind == 'b' ? given[i].length : sizeof(Callbacks));
                free(given[i].p);
            }
        }
        fflush(stdout);
    }
}
