/* A plant of FMI 3.0 of somebody else: a step adds its size times U to Y. It has Event Mode and no events of its own. */

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { OK, ERROR = 3 };

typedef struct {
    double time, u, y;
    bool events;
} Held;

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *required, size_t count, void *environment,
                                  void (*log)(void *, int, const char *, const char *), void *update) {
    Held *of = strcmp(token, "{held}") == 0 ? calloc(1, sizeof *of) : NULL;
    if (of != NULL) of->events = events;
    return of;
}

void fmi3FreeInstance(Held *of) { free(of); }
int fmi3EnterInitializationMode(Held *of, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    of->time = start;
    return OK;
}
int fmi3ExitInitializationMode(Held *of) { return OK; }
int fmi3EnterEventMode(Held *of) { return of->events ? OK : ERROR; }
int fmi3EnterStepMode(Held *of) { return of->events ? OK : ERROR; }
int fmi3Terminate(Held *of) { return OK; }
int fmi3Reset(Held *of) { return OK; }
int fmi3UpdateDiscreteStates(Held *of, bool *again, bool *ends, bool *nominals, bool *values, bool *is_next, double *next) {
    *again = *ends = *nominals = *values = *is_next = false;
    return OK;
}
int fmi3DoStep(Held *of, double time, double size, bool prior, bool *event, bool *ends, bool *early, double *last) {
    of->y += size * of->u;
    *event = *ends = *early = false;
    of->time = *last = time + size;
    return OK;
}
int fmi3GetFloat64(Held *of, const uint32_t *references, size_t count, double *values, size_t room) {
    for (size_t i = 0; i < count; i++) values[i] = references[i] == 0 ? of->time : references[i] == 1 ? of->u : of->y;
    return count == room ? OK : ERROR;
}
int fmi3SetFloat64(Held *of, const uint32_t *references, size_t count, const double *values, size_t room) {
    if (count != 1 || room != 1 || *references != 1) return ERROR;
    of->u = *values;
    return OK;
}
