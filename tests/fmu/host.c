/* A host that is not Python: loads co-simulation FMUs that were unpacked, steps them side by side, prints what they say.

   host STEP COUNT (FOLDER IDENTIFIER LOCATION INPUT_REFERENCE INPUT_VALUE OUTPUT_REFERENCE SEED_REFERENCE GUID)...
   One line an FMU:  final output, directional derivative of it for a unit seed, bytes of state, same after a repeat (0/1).
   Every status that is not OK ends the program with a message and exit code 1. */

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { void *logger, *allocate, *release, *finished, *environment; } Callbacks;

static void logger(void *environment, const char *instance, int status, const char *category, const char *message, ...)
{
    (void)environment;
    va_list list;
    va_start(list, message);
    fprintf(stderr, "%s [%s %d] ", instance, category, status);
    vfprintf(stderr, message, list);
    fprintf(stderr, "\n");
    va_end(list);
}

static void *function(void *library, const char *name)
{
    void *found = dlsym(library, name);
    if (!found)
        fprintf(stderr, "%s\n", dlerror()), exit(1);
    return found;
}

#define CALL(fmu, name, types, ...)                                                        \
    do {                                                                                   \
        int status = ((int (*) types)function((fmu)->library, #name))(__VA_ARGS__);        \
        if (status)                                                                        \
            fprintf(stderr, #name " answered %d\n", status), exit(1);                      \
    } while (0)

typedef struct {
    void *library, *instance;
    unsigned input, output, seed;
    double value;
} Fmu;

static double output(Fmu *f)
{
    double value;
    CALL(f, fmi2GetReal, (void *, unsigned *, size_t, double *), f->instance, &f->output, 1, &value);
    return value;
}

static void step(Fmu *f, double time, double size)
{
    double value = f->value * (1 - 100 * time);    /* an input that moves */
    CALL(f, fmi2SetReal, (void *, unsigned *, size_t, double *), f->instance, &f->input, 1, &value);
    CALL(f, fmi2DoStep, (void *, double, double, int), f->instance, time, size, 0);
}

int main(int count, char **argument)
{
    static Callbacks callbacks = {.logger = logger};
    double size = atof(argument[1]);
    int steps = atoi(argument[2]), fmus = (count - 3) / 8;
    Fmu *all = calloc((size_t)fmus, sizeof *all);
    for (int k = 0; k < fmus; k++) {
        char **a = argument + 3 + 8 * k, path[4096];
        Fmu *f = all + k;
        snprintf(path, sizeof path, "%s/binaries/linux64/%s.so", a[0], a[1]);
        f->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        if (!f->library)
            fprintf(stderr, "%s\n", dlerror()), exit(1);
        f->input = (unsigned)atoi(a[3]), f->value = atof(a[4]), f->output = (unsigned)atoi(a[5]), f->seed = (unsigned)atoi(a[6]);
        f->instance = ((void *(*)(char *, int, char *, char *, Callbacks *, int, int))function(f->library, "fmi2Instantiate"))(
            a[1], 1, a[7], a[2], &callbacks, 0, 0);
        if (!f->instance)
            fprintf(stderr, "fmi2Instantiate answered NULL\n"), exit(1);
        CALL(f, fmi2SetupExperiment, (void *, int, double, double, int, double), f->instance, 0, 0.0, 0.0, 0, 0.0);
        CALL(f, fmi2EnterInitializationMode, (void *), f->instance);
        CALL(f, fmi2SetReal, (void *, unsigned *, size_t, double *), f->instance, &f->input, 1, &f->value);
        CALL(f, fmi2ExitInitializationMode, (void *), f->instance);
    }
    for (int n = 0; n < steps; n++)
        for (int k = 0; k < fmus; k++)
            step(all + k, n * size, size);
    for (int k = 0; k < fmus; k++) {
        Fmu *f = all + k;
        void *state = NULL;
        size_t bytes;
        double one = 1, product;
        CALL(f, fmi2GetFMUstate, (void *, void **), f->instance, &state);
        CALL(f, fmi2SerializedFMUstateSize, (void *, void *, size_t *), f->instance, state, &bytes);
        step(f, steps * size, size);
        double first = output(f);
        CALL(f, fmi2GetDirectionalDerivative, (void *, unsigned *, size_t, unsigned *, size_t, double *, double *),
             f->instance, &f->output, 1, &f->seed, 1, &one, &product);
        CALL(f, fmi2SetFMUstate, (void *, void *), f->instance, state);
        step(f, steps * size, size);
        printf("%.17g %.17g %zu %d\n", first, product, bytes, first == output(f));
        CALL(f, fmi2FreeFMUstate, (void *, void **), f->instance, &state);
    }
    for (int k = 0; k < fmus; k++) {
        CALL(all + k, fmi2Terminate, (void *), all[k].instance);
        ((void (*)(void *))function(all[k].library, "fmi2FreeInstance"))(all[k].instance);
        dlclose(all[k].library);
    }
    return 0;
}
