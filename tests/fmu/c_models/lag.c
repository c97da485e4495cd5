/* Three first-order lags by backward Euler as an FMI 2.0 FMU, with the derivative of its step; what the oscillating input
   does is nonlinear.

   Eq. (X13):  (1 + H) x_i' = x_i + H (gain sin(u_i + w/3) + i),   s = sum x_i^2 / 10;   x_i = 1 at the start

   A step beyond `at` that is longer than `longest` has a `trouble`. With `talks` it says a sentence in every call. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GAIN, TROUBLE, AT, LONGEST, TALKS, U, W = 8, X, S = 12, STEPS, COUNT };      /* value references */
enum { CALM, DISCARDS, FAILS, CANNOT_DERIVE, CANNOT_BE_SET, IS_NAN, ENDS, WARNS };

typedef struct { double v[COUNT], slope[3], weight, is_in_trouble; } Model;
typedef unsigned Reference;
typedef void Logger(void *environment, const char *instance, int status, const char *category, const char *message, ...);
typedef struct { Model m; Logger *log; void *environment; double reached; } Instance;

static void say(Instance *i, int status, const char *what)
{
    if (i->m.v[TALKS] || status > 1)
        i->log(i->environment, "lag", status, "calls", "%s after %.0f steps", what, i->m.v[STEPS]);
}

static void sum_up(double *v)
{
    v[S] = (v[X] * v[X] + v[X + 1] * v[X + 1] + v[X + 2] * v[X + 2]) / 10;
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, void *const *host, int v, int l)
{
    (void)name, (void)type, (void)guid, (void)place, (void)v, (void)l;
    Instance *i = calloc(1, sizeof *i);
    i->log = (Logger *)host[0], i->environment = host[4];
    i->m.v[GAIN] = i->m.v[X] = i->m.v[X + 1] = i->m.v[X + 2] = 1;
    i->m.v[AT] = 0.25, i->m.v[LONGEST] = 0.06;
    sum_up(i->m.v);
    return i;
}

int fmi2DoStep(Instance *i, double time, double step, int last)
{
    (void)last;
    double *v = i->m.v;
    int trouble = time + step > v[AT] && step > v[LONGEST] ? (int)v[TROUBLE] : CALM;
    i->reached = time + step;
    i->m.is_in_trouble = trouble;
    say(i, 0, "step");
    if (trouble == DISCARDS || trouble == FAILS) {
        say(i, trouble == FAILS ? 3 : 2, trouble == FAILS ? "burst" : "no step of this length");
        return trouble == FAILS ? 3 : 2;
    }
    i->m.weight = step / (1 + step);
    for (int k = 0; k < 3; k++) {
        v[X + k] = (v[X + k] + step * (v[GAIN] * sin(v[U + k] + v[W] / 3) + k + 1)) / (1 + step);
        i->m.slope[k] = i->m.weight * v[GAIN] * cos(v[U + k] + v[W] / 3);
    }
    if (trouble == IS_NAN)
        v[X + 1] = NAN;
    sum_up(v);
    v[STEPS]++;
    return trouble == ENDS ? 2 : trouble == WARNS;
}

int fmi2GetBooleanStatus(Instance *i, int kind, int *value)
{
    *value = kind == 3 && i->m.is_in_trouble == ENDS;       /* fmi2Terminated */
    return 0;
}

int fmi2GetRealStatus(Instance *i, int kind, double *value)
{
    (void)kind;
    *value = i->reached;
    return 0;
}

int fmi2SetReal(Instance *i, const Reference *r, size_t n, const double *v)
{
    for (size_t k = 0; k < n; k++) {
        if (i->m.v[TROUBLE] == CANNOT_BE_SET && r[k] == U && i->m.v[STEPS] > 2)
            return 3;
        i->m.v[r[k]] = v[k];
    }
    return 0;
}

int fmi2GetReal(Instance *i, const Reference *r, size_t n, double *v)
{
    for (size_t k = 0; k < n; k++)
        v[k] = i->m.v[r[k]];
    return 0;
}

int fmi2GetDirectionalDerivative(Instance *i, const Reference *y, size_t ny, const Reference *u, size_t nu, const double *d,
                                 double *result)
{
    double change[COUNT] = {0};
    say(i, 0, "derivative");
    if (i->m.is_in_trouble == CANNOT_DERIVE) {
        say(i, 3, "no derivative");
        return 3;
    }
    for (size_t k = 0; k < nu; k++)
        change[u[k]] = d[k];
    for (int k = 0; k < 3; k++) {
        change[X + k] = i->m.slope[k] * (change[U + k] + change[W] / 3);
        change[S] += i->m.v[X + k] * change[X + k] / 5;
    }
    for (size_t k = 0; k < ny; k++)
        result[k] = change[y[k]];
    return 0;
}

int fmi2GetFMUstate(Instance *i, void **s)
{
    *s = *s ? *s : malloc(sizeof(Model));
    memcpy(*s, &i->m, sizeof(Model));
    return 0;
}

int fmi2SetFMUstate(Instance *i, const void *s)
{
    memcpy(&i->m, s, sizeof(Model));
    say(i, 0, "state");
    return 0;
}

int fmi2FreeFMUstate(Instance *i, void **s) { (void)i; free(*s); *s = NULL; return 0; }
int fmi2SerializedFMUstateSize(Instance *i, const void *s, size_t *n) { (void)i, (void)s; *n = sizeof(Model); return 0; }
int fmi2SerializeFMUstate(Instance *i, const void *s, char *to, size_t n) { (void)i; memcpy(to, s, n); return 0; }

int fmi2DeSerializeFMUstate(Instance *i, const char *from, size_t n, void **s)
{
    (void)i;
    *s = malloc(sizeof(Model));
    memcpy(*s, from, n);
    return 0;
}

int fmi2SetupExperiment(Instance *i, int a, double t, double s, int e, double x)
{
    (void)i, (void)a, (void)t, (void)s, (void)e, (void)x;
    return 0;
}
int fmi2EnterInitializationMode(Instance *i) { (void)i; return 0; }
int fmi2ExitInitializationMode(Instance *i) { (void)i; return 0; }
int fmi2Terminate(Instance *i) { (void)i; return 0; }
void fmi2FreeInstance(Instance *i) { free(i); }

#define ERROR(name) int name(void) { return 3; }
#define EMPTY(name) const char *name(void) { return "2.0"; }
EMPTY(fmi2GetVersion) EMPTY(fmi2GetTypesPlatform)
ERROR(fmi2Reset) ERROR(fmi2SetDebugLogging) ERROR(fmi2GetInteger) ERROR(fmi2SetInteger) ERROR(fmi2GetBoolean)
ERROR(fmi2SetBoolean) ERROR(fmi2GetString) ERROR(fmi2SetString) ERROR(fmi2SetRealInputDerivatives)
ERROR(fmi2GetRealOutputDerivatives) ERROR(fmi2CancelStep) ERROR(fmi2GetStatus) ERROR(fmi2GetIntegerStatus)
ERROR(fmi2GetStringStatus)
