/* Runs FMUs that are linked into one program, each under its prefix, with drawn inputs, and prints of each a hash of all values
   after all steps and of its saved state. FMUS is a list of FMU(name), which follows its GUID, types of inputs and cycle. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#ifdef __cplusplus
#define IN_C extern "C"
#else
#define IN_C extern
#endif

#define FMU(name)                                                                                                            \
    IN_C fmi2Component name##_fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,   \
                                                fmi2Boolean, fmi2Boolean);                                                   \
    IN_C fmi2Status name##_fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);       \
    IN_C fmi2Status name##_fmi2EnterInitializationMode(fmi2Component);                                                       \
    IN_C fmi2Status name##_fmi2ExitInitializationMode(fmi2Component);                                                        \
    IN_C fmi2Status name##_fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);                                       \
    IN_C fmi2Status name##_fmi2GetReal(fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *);                       \
    IN_C fmi2Status name##_fmi2SetReal(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Real *);                 \
    IN_C fmi2Status name##_fmi2SetInteger(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Integer *);           \
    IN_C fmi2Status name##_fmi2SetBoolean(fmi2Component, const fmi2ValueReference *, size_t, const fmi2Boolean *);           \
    IN_C fmi2Status name##_fmi2GetFMUstate(fmi2Component, fmi2FMUstate *);                                                   \
    IN_C fmi2Status name##_fmi2SerializedFMUstateSize(fmi2Component, fmi2FMUstate, size_t *);                                \
    IN_C fmi2Status name##_fmi2SerializeFMUstate(fmi2Component, fmi2FMUstate, fmi2Byte *, size_t);                           \
    IN_C void name##_fmi2FreeInstance(fmi2Component);                                                                        \
    extern const char *const name##_guid;                                                                                    \
    extern const char name##_types[];                                                                                        \
    extern const double name##_cycle;                                                                                        \
    static void run_##name(void) {                                                                                           \
        fmi2CallbackFunctions callbacks = {0, 0, 0, 0, 0};                                                                   \
        fmi2Component c;                                                                                                     \
        fmi2FMUstate state = 0;                                                                                              \
        uint64_t hash = 0xcbf29ce484222325u;                                                                                 \
        uint32_t seed = 7;                                                                                                   \
        size_t size = 0, i;                                                                                                  \
        fmi2Byte *bytes;                                                                                                     \
        int step;                                                                                                            \
        callbacks.logger = tell;                                                                                             \
        c = name##_fmi2Instantiate(#name, fmi2CoSimulation, name##_guid, 0, &callbacks, 0, 0);                               \
        check(c != 0, #name ": fmi2Instantiate");                                                                            \
        check(name##_fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) == fmi2OK, "fmi2SetupExperiment");                          \
        check(name##_fmi2EnterInitializationMode(c) == fmi2OK, "fmi2EnterInitializationMode");                               \
        check(name##_fmi2ExitInitializationMode(c) == fmi2OK, "fmi2ExitInitializationMode");                                 \
        for (step = 0; step < 2000; step += 1) {                                                                             \
            for (i = 0; name##_types[i] != '\0'; i += 1) {                                                                   \
                fmi2ValueReference vr = (fmi2ValueReference)i;                                                               \
                int drawn = next(&seed);                                                                                     \
                double number = (double)drawn / 97.0 - 400.0;                                                                \
                int integer = drawn % 120, boolean = drawn % 8 == 0;                                                         \
                if (name##_types[i] == 'R') {                                                                                \
                    check(name##_fmi2SetReal(c, &vr, 1, &number) == fmi2OK, "fmi2SetReal");                                  \
                } else if (name##_types[i] == 'W') {                                                                         \
                    number = (double)integer;                                                                                \
                    check(name##_fmi2SetReal(c, &vr, 1, &number) == fmi2OK, "fmi2SetReal");                                  \
                } else if (name##_types[i] == 'I') {                                                                         \
                    check(name##_fmi2SetInteger(c, &vr, 1, &integer) == fmi2OK, "fmi2SetInteger");                           \
                } else if (name##_types[i] == 'B') {                                                                         \
                    check(name##_fmi2SetBoolean(c, &vr, 1, &boolean) == fmi2OK, "fmi2SetBoolean");                           \
                }                                                                                                            \
            }                                                                                                                \
            check(name##_fmi2DoStep(c, step * name##_cycle, name##_cycle, 1) == fmi2OK, "fmi2DoStep");                       \
            check(name##_fmi2GetFMUstate(c, &state) == fmi2OK, "fmi2GetFMUstate");                                           \
            check(name##_fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK, "fmi2SerializedFMUstateSize");               \
            bytes = (fmi2Byte *)malloc(size);                                                                                \
            check(bytes != 0 && name##_fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK, "fmi2SerializeFMUstate");     \
            for (i = 0; i < size; i += 1) {                                                                                  \
                hash = (hash ^ (unsigned char)bytes[i]) * 0x100000001b3u;                                                    \
            }                                                                                                                \
            free(bytes);                                                                                                     \
        }                                                                                                                    \
        name##_fmi2FreeInstance(c);                                                                                          \
        printf(#name " %08lx%08lx\n", (unsigned long)(hash >> 32), (unsigned long)(hash & 0xFFFFFFFFu));                     \
    }

static void check(int is_right, const char *what) {
    if (!is_right) {
        fprintf(stderr, "%s fails\n", what);
        exit(1);
    }
}

static void tell(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String format, ...) {
    (void)environment, (void)status, (void)category, (void)format;
    fprintf(stderr, "%s is refused\n", name);
}

static int next(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return (int)(*seed >> 16);
}

#include "fmus.h"

int main(void) {
    RUN
    return 0;
}
