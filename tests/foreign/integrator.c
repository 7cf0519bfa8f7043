/* An FMU of somebody else: written without this project's code, with only those functions of FMI 2.0 that every
   co-simulation calls. It integrates U to Y, logs with a format, uses the host's memory, and reads the word GAIN from
   its resources. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    const Callbacks *callbacks;
    double u, y, limit, gain;
    int steps, on;
} Integrator;

enum { OK, WARNING, DISCARD, ERROR };

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging) {
    char path[4096];
    double gain = 0.0;
    FILE *file;
    if (type != 1 || strcmp(guid, "foreign") != 0 || strncmp(resources, "file:///", 8) != 0) return NULL;
    snprintf(path, sizeof path, "%s/gain.txt", resources + 7);
    file = fopen(path, "r");
    if (file == NULL || fscanf(file, "%lf", &gain) != 1) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatusError", "no gain in %s", path);
        return NULL;
    }
    fclose(file);
    Integrator *integrator = callbacks->allocate(1, sizeof *integrator);
    integrator->callbacks = callbacks;
    integrator->limit = HUGE_VAL;
    integrator->gain = gain;
    return integrator;
}

void fmi2FreeInstance(Integrator *of) { of->callbacks->release(of); }
int fmi2SetupExperiment(Integrator *of, int tolerance_defined, double tolerance, double start, int stop_defined, double stop) {
    return stop_defined && stop > start ? OK : ERROR;
}
int fmi2EnterInitializationMode(Integrator *of) { return OK; }
int fmi2ExitInitializationMode(Integrator *of) { return OK; }
int fmi2Terminate(Integrator *of) { return OK; }
int fmi2Reset(Integrator *of) { return OK; }

int fmi2GetReal(Integrator *of, const unsigned *references, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = *(&of->u + references[i]);
    return OK;
}
int fmi2SetReal(Integrator *of, const unsigned *references, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++) *(&of->u + references[i]) = values[i];
    return OK;
}
int fmi2GetInteger(Integrator *of, const unsigned *references, size_t count, int *values) {
    for (size_t i = 0; i < count; i++) values[i] = *(&of->steps + references[i]);
    return OK;
}
int fmi2SetInteger(Integrator *of, const unsigned *references, size_t count, const int *values) { return ERROR; }
int fmi2GetBoolean(Integrator *of, const unsigned *references, size_t count, int *values) {
    return fmi2GetInteger(of, references, count, values);
}
int fmi2SetBoolean(Integrator *of, const unsigned *references, size_t count, const int *values) {
    for (size_t i = 0; i < count; i++) *(&of->steps + references[i]) = values[i];
    return OK;
}

int fmi2DoStep(Integrator *of, double time, double size, int no_set) {
    if (of->on) of->y += of->gain * of->u * size;
    of->steps++;
    if (of->y <= of->limit) return OK;
    of->callbacks->logger(of->callbacks->environment, "", ERROR, "logStatusError", "Y is above %g", of->limit);
    return DISCARD;
}
