/* Feedthrough of an array, an integer and a truth value as an FMI 3.0 FMU, in the manner of the Reference-FMUs. With
   REJECTS_EVENTS it is not to be instantiated with Event Mode. */

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { TIME, GAIN, IN, OUT, INTEGER_IN, INTEGER_OUT, BOOLEAN_IN, BOOLEAN_OUT, SIZE = 3 };
typedef struct { double time, gain, in[SIZE], out[SIZE]; int32_t integer; bool boolean; } Model;
typedef unsigned Reference;

static double *place(Model *m, Reference r, size_t *size)
{
    *size = r == IN || r == OUT ? SIZE : 1;
    return r == IN ? m->in : r == OUT ? m->out : r == GAIN ? &m->gain : &m->time;
}

void *fmi3InstantiateCoSimulation(const char *a, const char *b, const char *c, bool d, bool e, bool f, bool g, const Reference *h,
                                  size_t i, void *j, void *k, void *l)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)f, (void)g, (void)h, (void)i, (void)j, (void)k, (void)l;
#ifdef REJECTS_EVENTS
    if (f)
        return NULL;
#endif
    Model *m = calloc(1, sizeof *m);
    m->gain = 1;
    return m;
}

int fmi3DoStep(Model *m, double time, double step, bool keeps, bool *event, bool *terminate, bool *early, double *reached)
{
    (void)keeps;
    for (int i = 0; i < SIZE; i++)
        m->out[i] = m->gain * m->in[i];
    *event = *terminate = *early = false;
    *reached = m->time = time + step;
    return 0;
}

int fmi3SetFloat64(Model *m, const Reference *r, size_t n, const double *v, size_t values)
{
    for (size_t i = 0, size; i < n; i++, v += size, values -= size) {
        double *to = place(m, r[i], &size);
        memcpy(to, v, size * sizeof *v);
    }
    return values ? 3 : 0;
}

int fmi3GetFloat64(Model *m, const Reference *r, size_t n, double *v, size_t values)
{
    for (size_t i = 0, size; i < n; i++, v += size, values -= size) {
        const double *from = place(m, r[i], &size);
        memcpy(v, from, size * sizeof *v);
    }
    return values ? 3 : 0;
}

int fmi3SetInt32(Model *m, const Reference *r, size_t n, const int32_t *v, size_t w)
{
    (void)r, (void)n, (void)w;
    m->integer = *v;
    return 0;
}

int fmi3GetInt32(Model *m, const Reference *r, size_t n, int32_t *v, size_t w)
{
    (void)r, (void)n, (void)w;
    *v = m->integer;
    return 0;
}

int fmi3SetBoolean(Model *m, const Reference *r, size_t n, const bool *v, size_t w)
{
    (void)r, (void)n, (void)w;
    m->boolean = *v;
    return 0;
}

int fmi3GetBoolean(Model *m, const Reference *r, size_t n, bool *v, size_t w)
{
    (void)r, (void)n, (void)w;
    *v = m->boolean;
    return 0;
}

int fmi3GetFMUState(Model *m, void **s) { *s = *s ? *s : malloc(sizeof *m); memcpy(*s, m, sizeof *m); return 0; }
int fmi3SetFMUState(Model *m, void *s) { memcpy(m, s, sizeof *m); return 0; }
int fmi3FreeFMUState(void *m, void **s) { (void)m; free(*s); *s = NULL; return 0; }
int fmi3SerializedFMUStateSize(void *m, void *s, size_t *n) { (void)m, (void)s; *n = sizeof(Model); return 0; }
int fmi3SerializeFMUState(void *m, void *s, uint8_t *b, size_t n) { (void)m; memcpy(b, s, n); return 0; }
int fmi3DeserializeFMUState(void *m, const uint8_t *b, size_t n, void **s)
{
    (void)m; *s = malloc(n); memcpy(*s, b, n);
    return 0;
}
