/* An FMU of FMI 3.0 of somebody else, written without this project's code. It is called every PERIOD: Y = SP - PV, B = GAIN A,
   COUNT counts the calls from beyond 2^53. In Event Mode a call is a time event, and a step returns early at it; without, a
   step makes the calls that lie in it. GAIN is in its resources. FAULT makes it return what makes no sense. */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, ERROR };
enum { TIME, SP, PV, Y, A, B, COUNT, OFFSET, ON, BYTE, PERIOD, FAULT, NAME };
enum { NO_FAULT, NOT_A_NUMBER, ENDLESS, BACKWARDS, STANDING, ENDING };

typedef struct {
    void (*log)(void *, int, const char *, const char *);
    void *environment;
    bool events, early;
    double time, next, sp, pv, a[2][2], b[2][2], period, gain;
    float y;
    int64_t count, offset;
    uint8_t byte;
    int32_t fault;
    bool on;
} Sampled;

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *required, size_t count, void *environment,
                                  void (*log)(void *, int, const char *, const char *), void *update) {
    char path[4096];
    FILE *file;
    if (strcmp(token, "{sampled}") != 0) {
        log(environment, ERROR, "logStatusError", "the instantiation token is not {sampled}");
        return NULL;
    }
    Sampled *of = calloc(1, sizeof *of);
    of->log = log, of->environment = environment, of->events = events, of->early = early;
    of->period = 0.5, of->count = INT64_C(9007199254740993), of->on = true;
    snprintf(path, sizeof path, "%sgain.txt", resources);
    file = fopen(path, "r");
    if (file == NULL || fscanf(file, "%lf", &of->gain) != 1) {
        log(environment, ERROR, "logStatusError", "there is no gain in the resources");
        free(of);
        return NULL;
    }
    fclose(file);
    return of;
}

void fmi3FreeInstance(Sampled *of) { free(of); }
int fmi3EnterInitializationMode(Sampled *of, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    of->time = of->next = start;
    return OK;
}
int fmi3ExitInitializationMode(Sampled *of) { return OK; }
int fmi3EnterEventMode(Sampled *of) { return of->events ? OK : ERROR; }
int fmi3EnterStepMode(Sampled *of) { return of->events ? OK : ERROR; }
int fmi3Terminate(Sampled *of) { return OK; }
int fmi3Reset(Sampled *of) { return OK; }

static void call(Sampled *of) {
    if (of->on) of->y = (float)(of->sp - of->pv);
    for (int i = 0; i < 4; i++) (&of->b[0][0])[i] = of->gain * (&of->a[0][0])[i];
    of->count++;
    of->next += of->period;
}

int fmi3UpdateDiscreteStates(Sampled *of, bool *again, bool *ends, bool *nominals, bool *values, bool *is_next, double *next) {
    *again = of->fault == ENDLESS, *ends = of->fault == ENDING && of->time >= 1.0, *nominals = *values = false, *is_next = true;
    if (of->next <= of->time + 1e-9) call(of);
    *next = of->fault == NOT_A_NUMBER ? NAN : of->next;
    return OK;
}

int fmi3DoStep(Sampled *of, double time, double size, bool prior, bool *event, bool *ends, bool *early, double *last) {
    double end = time + size;
    *event = *ends = *early = false;
    if (of->events && of->early && of->next < end - 1e-9) {
        of->time = *last = of->fault == BACKWARDS ? time - 1.0 : of->fault == STANDING ? time : of->next;
        *event = *early = true;
        return OK;
    }
    if (!of->events)
        while (of->next < end - 1e-9) call(of);
    of->time = *last = end;
    *event = of->events && of->next <= end + 1e-9;
    return OK;
}

int fmi3GetFloat64(Sampled *of, const uint32_t *references, size_t count, double *values, size_t room) {
    for (size_t i = 0; i < count; i++) {
        size_t size = references[i] == B || references[i] == A ? 4 : 1;
        if (room < size) return ERROR;
        switch (references[i]) {
            case TIME: *values = of->time; break;
            case SP: *values = of->sp; break;
            case PV: *values = of->pv; break;
            case PERIOD: *values = of->period; break;
            case A: memcpy(values, of->a, sizeof of->a); break;
            case B: memcpy(values, of->b, sizeof of->b); break;
            default: return ERROR;
        }
        values += size, room -= size;
    }
    return room == 0 ? OK : ERROR;
}
int fmi3SetFloat64(Sampled *of, const uint32_t *references, size_t count, const double *values, size_t room) {
    for (size_t i = 0; i < count; i++) {
        size_t size = references[i] == A ? 4 : 1;
        if (room < size) return ERROR;
        switch (references[i]) {
            case SP: of->sp = *values; break;
            case PV: of->pv = *values; break;
            case PERIOD: of->period = *values; break;
            case A: memcpy(of->a, values, sizeof of->a); break;
            default: return ERROR;
        }
        values += size, room -= size;
    }
    return room == 0 ? OK : ERROR;
}
int fmi3GetFloat32(Sampled *of, const uint32_t *references, size_t count, float *values, size_t room) {
    if (count != 1 || room != 1 || *references != Y) return ERROR;
    *values = of->y;
    return OK;
}
int fmi3GetInt64(Sampled *of, const uint32_t *references, size_t count, int64_t *values, size_t room) {
    if (room != count) return ERROR;
    for (size_t i = 0; i < count; i++) values[i] = references[i] == COUNT ? of->count : of->offset;
    return OK;
}
int fmi3SetInt64(Sampled *of, const uint32_t *references, size_t count, const int64_t *values, size_t room) {
    if (count != 1 || room != 1 || *references != OFFSET) return ERROR;
    of->offset = *values;
    return OK;
}
int fmi3GetInt32(Sampled *of, const uint32_t *references, size_t count, int32_t *values, size_t room) {
    *values = of->fault;
    return OK;
}
int fmi3SetInt32(Sampled *of, const uint32_t *references, size_t count, const int32_t *values, size_t room) {
    of->fault = *values;
    return OK;
}
int fmi3GetUInt8(Sampled *of, const uint32_t *references, size_t count, uint8_t *values, size_t room) {
    *values = of->byte;
    return OK;
}
#ifndef LACKS
int fmi3SetUInt8(Sampled *of, const uint32_t *references, size_t count, const uint8_t *values, size_t room) {
    of->byte = *values;
    return OK;
}
#endif
int fmi3GetBoolean(Sampled *of, const uint32_t *references, size_t count, bool *values, size_t room) {
    *values = of->on;
    return OK;
}
int fmi3SetBoolean(Sampled *of, const uint32_t *references, size_t count, const bool *values, size_t room) {
    of->on = *values;
    return OK;
}

/* What it does not support. */
#define MISSING(name) int name(void) { return ERROR; }
MISSING(fmi3ActivateModelPartition)
MISSING(fmi3CompletedIntegratorStep)
MISSING(fmi3DeserializeFMUState)
MISSING(fmi3EnterConfigurationMode)
MISSING(fmi3EnterContinuousTimeMode)
MISSING(fmi3EvaluateDiscreteStates)
MISSING(fmi3ExitConfigurationMode)
MISSING(fmi3FreeFMUState)
MISSING(fmi3GetAdjointDerivative)
MISSING(fmi3GetBinary)
MISSING(fmi3GetClock)
MISSING(fmi3GetContinuousStateDerivatives)
MISSING(fmi3GetContinuousStates)
MISSING(fmi3GetDirectionalDerivative)
MISSING(fmi3GetEventIndicators)
MISSING(fmi3GetFMUState)
MISSING(fmi3GetInt16)
MISSING(fmi3GetInt8)
MISSING(fmi3GetIntervalDecimal)
MISSING(fmi3GetIntervalFraction)
MISSING(fmi3GetNominalsOfContinuousStates)
MISSING(fmi3GetNumberOfContinuousStates)
MISSING(fmi3GetNumberOfEventIndicators)
MISSING(fmi3GetNumberOfVariableDependencies)
MISSING(fmi3GetOutputDerivatives)
MISSING(fmi3GetShiftDecimal)
MISSING(fmi3GetShiftFraction)
MISSING(fmi3GetString)
MISSING(fmi3GetUInt16)
MISSING(fmi3GetUInt32)
MISSING(fmi3GetUInt64)
MISSING(fmi3GetVariableDependencies)
MISSING(fmi3InstantiateModelExchange)
MISSING(fmi3InstantiateScheduledExecution)
MISSING(fmi3SerializeFMUState)
MISSING(fmi3SerializedFMUStateSize)
MISSING(fmi3SetBinary)
MISSING(fmi3SetClock)
MISSING(fmi3SetContinuousStates)
MISSING(fmi3SetDebugLogging)
MISSING(fmi3SetFMUState)
MISSING(fmi3SetFloat32)
MISSING(fmi3SetInt16)
MISSING(fmi3SetInt8)
MISSING(fmi3SetIntervalDecimal)
MISSING(fmi3SetIntervalFraction)
MISSING(fmi3SetShiftDecimal)
MISSING(fmi3SetShiftFraction)
MISSING(fmi3SetString)
MISSING(fmi3SetTime)
MISSING(fmi3SetUInt16)
MISSING(fmi3SetUInt32)
MISSING(fmi3SetUInt64)
