/* Three Dahlquist equations dx/dt = -k x + u by backward Euler as an FMI 2.0 FMU, in the manner of the Reference-FMUs:
   no derivatives, no logging, no serialisation unless SERIALISES is defined; what is not offered answers fmi2Error.
   A step waits WAIT microseconds, 0 unless defined, and is bent by BEND. */

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef WAIT
#define WAIT 0
#endif
#ifndef BEND
#define BEND 0
#endif

typedef struct { double k, u[3], x[3]; } Model;
typedef unsigned Reference;

void *fmi2Instantiate(const char *a, int b, const char *c, const char *d, const void *e, int g, int h)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)g, (void)h;
    Model *m = calloc(1, sizeof *m);
    m->k = 1, m->x[0] = 1, m->x[1] = 2, m->x[2] = -3;
    return m;
}

int fmi2DoStep(Model *m, double time, double step, int last)
{
    (void)time, (void)last;
    if (WAIT)
        usleep(WAIT);
    double u = m->u[0] * m->u[1] * m->u[2];
    for (int i = 0; i < 3; i++)
        m->x[i] = (m->x[i] + step * (m->u[i] + BEND * u)) / (1 + step * m->k);
    return 0;
}

int fmi2SetReal(Model *m, const Reference *r, size_t n, const double *v)
{
    for (size_t i = 0; i < n; i++)
        (&m->k)[r[i]] = v[i];
    return 0;
}

int fmi2GetReal(Model *m, const Reference *r, size_t n, double *v)
{
    for (size_t i = 0; i < n; i++)
        v[i] = (&m->k)[r[i]];
    return 0;
}

int fmi2GetBoolean(Model *m, const Reference *r, size_t n, int *v)
{
    (void)r;
    for (size_t i = 0; i < n; i++)
        v[i] = m->x[1] < 1;
    return 0;
}

int fmi2GetFMUstate(Model *m, void **s) { *s = *s ? *s : malloc(sizeof *m); memcpy(*s, m, sizeof *m); return 0; }
int fmi2SetFMUstate(Model *m, void *s) { memcpy(m, s, sizeof *m); return 0; }
int fmi2FreeFMUstate(void *m, void **s) { (void)m; free(*s); *s = NULL; return 0; }

#ifdef SERIALISES
int fmi2SerializedFMUstateSize(void *m, void *s, size_t *n) { (void)m, (void)s; *n = sizeof(Model); return 0; }
int fmi2SerializeFMUstate(void *m, void *s, char *b, size_t n) { (void)m; memcpy(b, s, n); return 0; }
int fmi2DeSerializeFMUstate(void *m, const char *b, size_t n, void **s)
{
    (void)m; *s = malloc(n); memcpy(*s, b, n);
    return 0;
}
#else
#endif
