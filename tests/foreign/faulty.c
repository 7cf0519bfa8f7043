/* An FMU of somebody else, a lag from U to Y that fails as FAULT says once AT steps are made. It prints to standard output.
   Another FAULT than 0 can be compiled in. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    const Callbacks *callbacks;
    double u, y;
    int fault, at, steps;
} Faulty;

enum { OK, WARNING, DISCARD, ERROR };
enum { NONE, ABORT, HANG, REFUSE, LEAVE, QUIT, END };

#ifndef FAULT
#define FAULT NONE
#endif

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging) {
    Faulty *faulty = strcmp(guid, "faulty") ? NULL : callbacks->allocate(1, sizeof *faulty);
    if (!faulty) return NULL;
    faulty->callbacks = callbacks;
    puts("an FMU that talks");
    fflush(stdout);
    return faulty;
}

void fmi2FreeInstance(Faulty *of) { of->callbacks->release(of); }
int fmi2SetupExperiment(Faulty *of, int tolerance_defined, double tolerance, double start, int stop_defined, double stop) {
    return OK;
}
int fmi2EnterInitializationMode(Faulty *of) { return OK; }
int fmi2ExitInitializationMode(Faulty *of) { return OK; }
int fmi2Terminate(Faulty *of) { return OK; }
int fmi2Reset(Faulty *of) { return OK; }

int fmi2GetReal(Faulty *of, const unsigned *references, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = *(&of->u + references[i]);
    return OK;
}
int fmi2SetReal(Faulty *of, const unsigned *references, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++) *(&of->u + references[i]) = values[i];
    return OK;
}
int fmi2GetInteger(Faulty *of, const unsigned *references, size_t count, int *values) {
    for (size_t i = 0; i < count; i++) values[i] = *(&of->fault + references[i]);
    return OK;
}
int fmi2SetInteger(Faulty *of, const unsigned *references, size_t count, const int *values) {
    for (size_t i = 0; i < count; i++) *(&of->fault + references[i]) = values[i];
    return OK;
}
int fmi2GetBoolean(Faulty *of, const unsigned *references, size_t count, int *values) { return ERROR; }
int fmi2SetBoolean(Faulty *of, const unsigned *references, size_t count, const int *values) { return ERROR; }

int fmi2DoStep(Faulty *of, double time, double size, int no_set) {
    volatile int for_ever = 1;
    int fault = FAULT ? FAULT : of->fault;
    puts("a step");
    fflush(stdout);
    of->y += (of->u - of->y) * size / 8.0;
    if (of->steps++ < of->at) return OK;
    switch (fault) {
    case ABORT:
        abort();
    case HANG:
        while (for_ever) pause();
    case REFUSE:
        of->callbacks->logger(of->callbacks->environment, "", ERROR, "logStatusError", "the sensor is broken");
        return ERROR;
    case LEAVE:
        exit(3);
    case QUIT:
        of->callbacks->logger(of->callbacks->environment, "", OK, "logStatusOK", "no more water");
        exit(0);
    case END:
        return DISCARD;
    }
    return OK;
}

/* 3 is fmi2Terminated. */
int fmi2GetBooleanStatus(Faulty *of, int kind, int *value) {
    *value = kind == 3 && of->fault == END;
    return OK;
}

#define UNSUPPORTED(name) int name(void) { return ERROR; }
UNSUPPORTED(fmi2SetDebugLogging)
UNSUPPORTED(fmi2GetString)
UNSUPPORTED(fmi2SetString)
UNSUPPORTED(fmi2GetFMUstate)
UNSUPPORTED(fmi2SetFMUstate)
UNSUPPORTED(fmi2FreeFMUstate)
UNSUPPORTED(fmi2SerializedFMUstateSize)
UNSUPPORTED(fmi2SerializeFMUstate)
UNSUPPORTED(fmi2DeSerializeFMUstate)
UNSUPPORTED(fmi2GetDirectionalDerivative)
UNSUPPORTED(fmi2SetRealInputDerivatives)
UNSUPPORTED(fmi2GetRealOutputDerivatives)
UNSUPPORTED(fmi2CancelStep)
UNSUPPORTED(fmi2GetStatus)
UNSUPPORTED(fmi2GetRealStatus)
UNSUPPORTED(fmi2GetIntegerStatus)
UNSUPPORTED(fmi2GetStringStatus)
