/* A first-order lag dx/dt = gain u - x by backward Euler as an FMI 2.0 FMU that keeps to the letter of the standard: its
   directional derivative is the partial derivative at the communication point, 0 for a state. With REFUSES it is not to
   be instantiated; a step beyond `fails_at` answers FAILS (default: fmi2Error), and fmi2Terminate answers ENDS. A call
   that the standard forbids after a failure aborts. */

#include <stdlib.h>
#include <string.h>

#ifndef FAILS
#define FAILS 3
#endif
#ifndef ENDS
#define ENDS i->m.fails_at < 0.5 ? 3 : 0
#endif

static int dead; /* no instance is to be called after fmi2Fatal */

typedef struct { double u, x, gain, x0, fails_at; } Model;
typedef unsigned Reference;
typedef void Logger(void *environment, const char *instance, int status, const char *category, const char *message, ...);
typedef struct { Model m; Logger *log; void *environment; int failed; } Instance;

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, void *const *host, int v, int l)
{
    (void)type, (void)guid, (void)place, (void)v, (void)l;
    Logger *log = (Logger *)host[0];
#ifdef REFUSES
    log(host[4], name, 3, "error", "no licence for this cell");
    return NULL;
#endif
    (void)name;
    Instance *i = calloc(1, sizeof *i);
    i->log = log, i->environment = host[4];
    i->m.gain = 1, i->m.fails_at = 1e9;
    return i;
}

int fmi2DoStep(Instance *i, double time, double step, int last)
{
    (void)last;
    if (time + step > i->m.fails_at) {
        i->failed = 1;
        dead = FAILS == 4;
        i->log(i->environment, "cell", 3, "error", "the cell has burst");
        return FAILS;
    }
    i->m.x = (i->m.x + step * i->m.gain * i->m.u) / (1 + step);
    return 0;
}

int fmi2Terminate(Instance *i)
{
    if (i->failed || dead)
        abort();
    if (ENDS)
        i->log(i->environment, "cell", 3, "error", "the cell will not end");
    return ENDS;
}

void fmi2FreeInstance(Instance *i)
{
    if (dead)
        abort();
    free(i);
}

int fmi2SetReal(Instance *i, const Reference *r, size_t n, const double *v)
{
    for (size_t k = 0; k < n; k++)
        (&i->m.u)[r[k]] = v[k];
    return 0;
}

int fmi2GetReal(Instance *i, const Reference *r, size_t n, double *v)
{
    for (size_t k = 0; k < n; k++)
        v[k] = (&i->m.u)[r[k]];
    return 0;
}

int fmi2GetDirectionalDerivative(Instance *i, const Reference *y, size_t ny, const Reference *u, size_t nu, const double *d,
                                 double *result)
{
    (void)i, (void)y, (void)u, (void)nu, (void)d;
    memset(result, 0, ny * sizeof *result);
    return 0;
}

int fmi2GetFMUstate(Instance *i, void **s)
{
    *s = *s ? *s : malloc(sizeof(Model));
    memcpy(*s, &i->m, sizeof(Model));
    return 0;
}

int fmi2SetFMUstate(Instance *i, const void *s) { memcpy(&i->m, s, sizeof(Model)); return 0; }
int fmi2FreeFMUstate(Instance *i, void **s)
{
    (void)i;
    if (dead)
        abort();
    free(*s);
    *s = NULL;
    return 0;
}
int fmi2ExitInitializationMode(Instance *i) { i->m.x = i->m.x0; return 0; }
