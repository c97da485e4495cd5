/* FMUs of FMI 2.0 and 3.0 that behave as FMUs of other tools do. Value references count real numbers from 0 on, integers
   from 100, Booleans from 200 and texts from 300. Parts are chosen by -D, as statements that know the model m:

   START, ENTER, OUT         at the instantiation, when Initialization Mode is entered, before values are read
   STEP                      a step from t over H of the instance I, which may return a status
   DOSTEP, UPDATE            FMI 3.0: before a step (event, early, last), and in fmi3UpdateDiscreteStates (again, next)
   GETS, STATUS, FREE        before a text k is read, fmi2GetStatus (kind, value), when the instance is freed
   RESTORE                   after a state is restored
   FAILS                     status of a call: 'g' or 's' of values (first reference of their type), 'G' or 'S' of a state
   SIZE                      elements of the variable a of FMI 3.0

   If the variable CALLS is set in the environment, calls are written to the file of that name. */

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef SIZE
#define SIZE 1
#endif
#ifndef OUT
#define OUT
#endif
#ifndef STEP
#define STEP
#endif
#ifndef START
#define START
#endif
#ifndef ENTER
#define ENTER
#endif
#ifndef DOSTEP
#define DOSTEP
#endif
#ifndef UPDATE
#define UPDATE
#endif
#ifndef GETS
#define GETS
#endif
#ifndef STATUS
#define STATUS
#endif
#ifndef FREE
#define FREE
#endif
#ifndef FAILS
#define FAILS 0
#endif
#ifndef RESTORE
#define RESTORE
#endif

typedef struct {
    double r[20], t, start, stop;
    long long i[20];
    int b[20], steps;
    char s[4][80], resources[2000], name[80];
} Model;
typedef struct { Model m; void *log, *environment; int version; } Instance;
typedef unsigned Reference;
static double kept;   /* of all instances in a process */
static int restored;

static void say(const char *form, ...)
{
    FILE *file = getenv("CALLS") ? fopen(getenv("CALLS"), "a") : NULL;
    if (!file)
        return;
    va_list given;
    va_start(given, form);
    vfprintf(file, form, given);
    va_end(given);
    fclose(file);
}

static void logged(Instance *I, int status, const char *text)
{
    if (I->version == 2)
        ((void (*)(void *, const char *, int, const char *, const char *, ...))I->log)(
            I->environment, I->m.name, status, "", "%s", text);
    else
        ((void (*)(void *, int, const char *, const char *))I->log)(I->environment, status, "", text);
}

static void *messages(void *I)
{
    for (int k = 0; k < 2000; k++)
        logged(I, 1, "from a thread");
    return NULL;
}

static void out(Model *m) { OUT; }
static int size(unsigned a) { return SIZE; }

static Instance *instantiate(int version, const char *name, const char *resources, void *log, void *environment)
{
    say("instantiate %s\n", resources ? resources : "nowhere");
    Instance *I = calloc(1, sizeof *I);
    Model *m = &I->m;
    I->version = version, I->log = log, I->environment = environment;
    snprintf(m->name, sizeof m->name, "%s", name);
    snprintf(m->resources, sizeof m->resources, "%s", resources ? resources : "");
    START;
    out(m);
    return I;
}

static int enter(Model *m) { ENTER; out(m); return 0; }

static int step(Instance *I, double t, double H)
{
    Model *m = &I->m;
    say("step %.17g %.17g\n", t, H);
    STEP;
    return 0;
}

static int finished(Instance *I, int status, double end)
{
    if (status < 2)
        I->m.t = end, I->m.steps++, out(&I->m);
    return status;
}

static int fails(Instance *I, int call, int first)
{
    Model *m = &I->m;
    int status = FAILS;
    if (status)
        logged(I, status, "no value here");
    return status;
}

static int saved(Instance *I, void **s)
{
    *s = *s ? *s : malloc(sizeof I->m);
    memcpy(*s, &I->m, sizeof I->m);
    return fails(I, 'G', 0);
}

static int restore(Instance *I, const void *s) 
{
    int status = fails(I, 'S', 0);
    memcpy(&I->m, s, sizeof I->m);
    restored++;
    RESTORE;
    return status;
}

static int freed(void **s) { free(*s); *s = NULL; return 0; }
static int serialised(const void *s, char *data, size_t n) { memcpy(data, s, n); return 0; }
static int deserialised(const char *data, size_t n, void **s) { *s = malloc(n); memcpy(*s, data, n); return 0; }

static void stop(Instance *I) { say("free\n"); FREE; free(I); }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, void *const *calls)
{ return instantiate(2, name, resources, calls[0], calls[4]); }
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool events, bool early, const Reference *r, size_t n, void *environment, void *log)
{
    say("events %d\n", events);
    return instantiate(3, name, resources, log, environment);
}
void fmi2FreeInstance(Instance *I) { stop(I); }
void fmi3FreeInstance(Instance *I) { stop(I); }
int fmi2SetupExperiment(Instance *I, int a, double tolerance, double begin, int b, double end)
{ I->m.start = I->m.t = begin, I->m.stop = end; return 0; }
int fmi2EnterInitializationMode(Instance *I) { return enter(&I->m); }
int fmi3EnterInitializationMode(Instance *I, bool a, double tolerance, double begin, bool b, double end)
{ I->m.start = I->m.t = begin, I->m.stop = end; return enter(&I->m); }
int fmi3EnterEventMode(Instance *I) { say("event mode\n"); return 0; }
int fmi3EnterStepMode(Instance *I) { return 0; }
int fmi3UpdateDiscreteStates(Instance *I, bool *again, bool *b, bool *c, bool *d, bool *announced, double *next)
{
    Model *m = &I->m;
    *again = *b = *c = *d = *announced = false;
    UPDATE;
    out(m);
    return 0;
}
int fmi2DoStep(Instance *I, double t, double H, int flag) { return finished(I, step(I, t, H), t + H); }
int fmi3DoStep(Instance *I, double t, double H, bool flag, bool *event, bool *end, bool *early, double *last)
{
    Model *m = &I->m;
    *event = *end = *early = false;
    *last = t + H;
    DOSTEP;
    int status = step(I, t, H);
    return finished(I, status, *last);
}
int fmi2GetStatus(Instance *I, int kind, int *value) { STATUS; return 3; }

int fmi2GetFMUstate(Instance *I, void **s) { return saved(I, s); }
int fmi3GetFMUState(Instance *I, void **s) { return saved(I, s); }
int fmi2SetFMUstate(Instance *I, void *s) { return restore(I, s); }
int fmi3SetFMUState(Instance *I, void *s) { return restore(I, s); }
int fmi2FreeFMUstate(Instance *I, void **s) { return freed(s); }
int fmi3FreeFMUState(Instance *I, void **s) { return freed(s); }
int fmi2SerializedFMUstateSize(Instance *I, void *s, size_t *n) { *n = sizeof I->m; return 0; }
int fmi3SerializedFMUStateSize(Instance *I, void *s, size_t *n) { *n = sizeof I->m; return 0; }
int fmi2SerializeFMUstate(Instance *I, void *s, char *data, size_t n) { return serialised(s, data, n); }
int fmi3SerializeFMUState(Instance *I, void *s, char *data, size_t n) { return serialised(s, data, n); }
int fmi2DeSerializeFMUstate(Instance *I, const char *data, size_t n, void **s) { return deserialised(data, n, s); }
int fmi3DeserializeFMUState(Instance *I, const char *data, size_t n, void **s) { return deserialised(data, n, s); }

#define SET(function, type, values, first) \
    int function(Instance *I, const Reference *r, size_t n, const type *v) \
    { \
        for (size_t k = 0; k < n; k++) { \
            say("set %u %.17g\n", r[k], (double)*v); \
            for (int j = 0; j < size(r[k]); j++) \
                I->m.values[r[k] - first + (unsigned)j] = *v++; \
        } \
        return fails(I, 's', first); \
    }
#define GET(function, type, values, first) \
    int function(Instance *I, const Reference *r, size_t n, type *v) \
    { \
        out(&I->m); \
        for (size_t k = 0; k < n; k++) \
            for (int j = 0; j < size(r[k]); j++) \
                *v++ = (type)I->m.values[r[k] - first + (unsigned)j]; \
        return fails(I, 'g', first); \
    }
#define BOTH(version, name, type, values, first) \
    SET(fmi##version##Set##name, type, values, first) GET(fmi##version##Get##name, type, values, first)
BOTH(2, Real, double, r, 0) BOTH(2, Integer, int, i, 100) BOTH(2, Boolean, int, b, 200)
BOTH(3, Float64, double, r, 0) BOTH(3, Int32, int32_t, i, 100) BOTH(3, Int64, int64_t, i, 100)
BOTH(3, UInt64, uint64_t, i, 100) BOTH(3, Boolean, bool, b, 200)

static int set_text(Instance *I, const Reference *r, size_t n, const char *const *v)
{
    for (size_t k = 0; k < n; k++)
        snprintf(I->m.s[r[k] - 300], sizeof I->m.s[0], "%s", v[k]);
    return fails(I, 's', 300);
}

static int get_text(Instance *I, const Reference *r, size_t n, const char **v)
{
    Model *m = &I->m;
    out(m);
    for (size_t k = 0; k < n; k++) {
        v[k] = m->s[r[k] - 300];
        GETS;
    }
    return fails(I, 'g', 300);
}
int fmi2SetString(Instance *I, const Reference *r, size_t n, const char *const *v) { return set_text(I, r, n, v); }
int fmi3SetString(Instance *I, const Reference *r, size_t n, const char *const *v) { return set_text(I, r, n, v); }
int fmi2GetString(Instance *I, const Reference *r, size_t n, const char **v) { return get_text(I, r, n, v); }
int fmi3GetString(Instance *I, const Reference *r, size_t n, const char **v) { return get_text(I, r, n, v); }
