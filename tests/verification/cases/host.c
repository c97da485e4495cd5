/* A host that is nothing but C: steps one unpacked co-simulation FMU of FMI 2.0 or 3.0 and prints what it says.

   host VERSION LIBRARY TOKEN RESOURCES STEP COUNT REFERENCE...
   One line a row, the first before any step: time, then the value of each reference. A status that is not OK ends it. */

#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

typedef void (*Logger2)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger2 logger; void *allocate, *release, *finished, *environment; } Callbacks;

static void *library;

static void logger2(void *environment, const char *instance, int status, const char *category, const char *message, ...)
{
    (void)environment, (void)instance, (void)category;
    if (status > 1)
        fprintf(stderr, "%s\n", message);
}

static void logger3(void *environment, int status, const char *category, const char *message)
{
    (void)environment, (void)category;
    if (status > 1)
        fprintf(stderr, "%s\n", message);
}

static void *function(const char *name)
{
    void *found = dlsym(library, name);
    if (!found)
        fprintf(stderr, "%s\n", dlerror()), exit(1);
    return found;
}

#define CALL(name, types, ...)                                            \
    do {                                                                  \
        int status = ((int (*) types)function(name))(__VA_ARGS__);        \
        if (status)                                                       \
            fprintf(stderr, "%s answered %d\n", name, status), exit(1);   \
    } while (0)

static void print_row(bool third, void *one, double time, const unsigned *reference, size_t count, double *value)
{
    if (third)
        CALL("fmi3GetFloat64", (void *, const unsigned *, size_t, double *, size_t), one, reference, count, value, count);
    else
        CALL("fmi2GetReal", (void *, const unsigned *, size_t, double *), one, reference, count, value);
    printf("%.17g", time);
    for (size_t k = 0; k < count; k++)
        printf(" %.17g", value[k]);
    printf("\n");
}

static void *begun_2(const char *token, const char *resources)
{
    static Callbacks callbacks = {.logger = logger2};
    void *one = ((void *(*)(const char *, int, const char *, const char *, Callbacks *, int, int))function("fmi2Instantiate"))(
        "one", 1, token, resources, &callbacks, 0, 0);
    if (!one)
        exit(1);
    CALL("fmi2SetupExperiment", (void *, int, double, double, int, double), one, 0, 0.0, 0.0, 0, 0.0);
    CALL("fmi2EnterInitializationMode", (void *), one);
    CALL("fmi2ExitInitializationMode", (void *), one);
    return one;
}

static void *begun_3(const char *token, const char *resources)
{
    void *one = ((void *(*)(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned *, size_t, void *,
                            void *, void *))function("fmi3InstantiateCoSimulation"))(
        "one", token, resources, false, false, false, false, NULL, 0, NULL, logger3, NULL);
    if (!one)
        exit(1);
    CALL("fmi3EnterInitializationMode", (void *, bool, double, double, bool, double), one, false, 0.0, 0.0, false, 0.0);
    CALL("fmi3ExitInitializationMode", (void *), one);
    return one;
}

static void step(bool third, void *one, double time, double size)
{
    bool event, end, early;
    double reached;
    if (third)
        CALL("fmi3DoStep", (void *, double, double, bool, bool *, bool *, bool *, double *), one, time, size, true, &event,
             &end, &early, &reached);
    else
        CALL("fmi2DoStep", (void *, double, double, int), one, time, size, 1);
}

int main(int count, char **argument)
{
    bool third = argument[1][0] == '3';
    double size = atof(argument[5]);
    int steps = atoi(argument[6]);
    size_t wanted = (size_t)(count - 7);
    unsigned *reference = calloc(wanted, sizeof *reference);
    double *value = calloc(wanted, sizeof *value);
    for (size_t k = 0; k < wanted; k++)
        reference[k] = (unsigned)atoi(argument[7 + k]);
    library = dlopen(argument[2], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        fprintf(stderr, "%s\n", dlerror()), exit(1);
    void *one = third ? begun_3(argument[3], argument[4]) : begun_2(argument[3], argument[4]);
    print_row(third, one, 0.0, reference, wanted, value);
    for (int n = 0; n < steps; n++) {
        step(third, one, n * size, size);
        print_row(third, one, (n + 1) * size, reference, wanted, value);
    }
    CALL(third ? "fmi3Terminate" : "fmi2Terminate", (void *), one);
    ((void (*)(void *))function(third ? "fmi3FreeInstance" : "fmi2FreeInstance"))(one);
    return 0;
}
