/* Every type of FMI 3.0 handed on in a step, an array as long as a structural parameter says, events that end a step early,
   and an end that the FMU asks for. With ANNOUNCES events do not end a step early: a step beyond the next one fails. */

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { TIME, N, A_IN, A_OUT, ENDS_AT, GRAIN, EVENTS, LARGEST = 16 };
enum { IN = 10, OUT = 30, KINDS = 13, TEXT = 10, BYTES = 11 };
enum { STARTING, CONFIGURING, EVENT, STEP };
typedef struct {
    double time, ends_at, grain, events, a_in[LARGEST], a_out[LARGEST];
    uint64_t n, in[KINDS], out[KINDS];
    char text[2][64];
    uint8_t bytes[2][64];
    size_t size[2];
    int mode;
} Model;
typedef unsigned Reference;

void *fmi3InstantiateCoSimulation(const char *a, const char *b, const char *c, bool d, bool e, bool events, bool early,
                                  const Reference *h, size_t i, void *j, void *k, void *l)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)h, (void)i, (void)j, (void)k, (void)l;
    if (!events || !early)
        return NULL;
    Model *m = calloc(1, sizeof *m);
    m->n = 3, m->ends_at = 1e9, m->grain = 1e9;
    return m;
}

int fmi3EnterConfigurationMode(Model *m) { m->mode = CONFIGURING; return 0; }
int fmi3ExitConfigurationMode(Model *m) { m->mode = STARTING; return 0; }
int fmi3ExitInitializationMode(Model *m) { m->mode = EVENT; return 0; }
int fmi3EnterEventMode(Model *m) { if (m->mode != STEP) return 3; m->mode = EVENT; return 0; }
int fmi3EnterStepMode(Model *m) { if (m->mode != EVENT) return 3; m->mode = STEP; return 0; }

int fmi3DoStep(Model *m, double time, double step, bool keeps, bool *event, bool *terminate, bool *early, double *reached)
{
    (void)keeps;
    double end = time + step, next = m->grain * (m->events + 1);
    if (m->mode != STEP)
        return 3;
#ifdef ANNOUNCES
    if (end > next + 1e-12)
        return 3;
    *early = false, *event = false;
#else
    *event = next <= end, *early = next < end;
#endif
    *terminate = m->ends_at <= end;
    if (*early)
        end = next;
    if (*terminate && m->ends_at < end)
        end = m->ends_at, *early = true;
    memcpy(m->a_out, m->a_in, sizeof m->a_in);
    memcpy(m->out, m->in, sizeof m->in);
    memcpy(m->text[1], m->text[0], sizeof m->text[0]);
    memcpy(m->bytes[1], m->bytes[0], sizeof m->bytes[0]);
    m->size[1] = m->size[0];
    *reached = m->time = end;
    return 0;
}

int fmi3UpdateDiscreteStates(Model *m, bool *again, bool *end, bool *nominals, bool *values, bool *defined, double *next)
{
    if (m->mode != EVENT)
        return 3;
    m->events += m->time >= m->grain * (m->events + 1) - 1e-12;
    *again = *end = *nominals = *values = *defined = false, *next = 0;
#ifdef ANNOUNCES
    *defined = true, *next = m->grain * (m->events + 1);
#endif
    return 0;
}

static double *place(Model *m, Reference r, size_t *size)
{
    *size = r == A_IN || r == A_OUT ? m->n : 1;
    return r == A_IN ? m->a_in : r == A_OUT ? m->a_out : r == ENDS_AT ? &m->ends_at : r == GRAIN ? &m->grain
         : r == EVENTS ? &m->events : &m->time;
}

int fmi3SetFloat64(Model *m, const Reference *r, size_t n, const double *v, size_t values)
{
    for (size_t i = 0, size; i < n; i++, v += size, values -= size) {
        double *to = place(m, r[i], &size);
        if (size > values)
            return 3;
        memcpy(to, v, size * sizeof *v);
    }
    return values ? 3 : 0;
}

int fmi3GetFloat64(Model *m, const Reference *r, size_t n, double *v, size_t values)
{
    for (size_t i = 0, size; i < n; i++, v += size, values -= size) {
        const double *from = place(m, r[i], &size);
        if (size > values)
            return 3;
        memcpy(v, from, size * sizeof *v);
    }
    return values ? 3 : 0;
}

static uint64_t *cell(Model *m, Reference r) { return r == N ? &m->n : r >= OUT ? m->out + r - OUT : m->in + r - IN; }

#define NUMBERS(name, type)                                                                   \
    int fmi3Set##name(Model *m, const Reference *r, size_t n, const type *v, size_t values)   \
    {                                                                                         \
        if (values != n || (*r == N && m->mode != CONFIGURING))                               \
            return 3;                                                                         \
        for (size_t i = 0; i < n; i++)                                                        \
            memcpy(cell(m, r[i]), v + i, sizeof *v);                                          \
        return 0;                                                                             \
    }                                                                                         \
    int fmi3Get##name(Model *m, const Reference *r, size_t n, type *v, size_t values)         \
    {                                                                                         \
        for (size_t i = 0; i < n; i++)                                                        \
            memcpy(v + i, cell(m, r[i]), sizeof *v);                                          \
        return values != n ? 3 : 0;                                                           \
    }
NUMBERS(Float32, float) NUMBERS(Int8, int8_t) NUMBERS(UInt8, uint8_t) NUMBERS(Int16, int16_t) NUMBERS(UInt16, uint16_t)
NUMBERS(Int32, int32_t) NUMBERS(UInt32, uint32_t) NUMBERS(Int64, int64_t) NUMBERS(UInt64, uint64_t) NUMBERS(Boolean, bool)

int fmi3SetString(Model *m, const Reference *r, size_t n, const char *const *v, size_t values)
{
    (void)r, (void)values;
    if (n != 1 || strlen(*v) > 63)
        return 3;
    strcpy(m->text[0], *v);
    return 0;
}

int fmi3GetString(Model *m, const Reference *r, size_t n, const char **v, size_t values)
{
    for (size_t i = 0; i < n; i++)
        v[i] = m->text[r[i] >= OUT];
    return values != n ? 3 : 0;
}

int fmi3SetBinary(Model *m, const Reference *r, size_t n, const size_t *sizes, const uint8_t *const *v, size_t values)
{
    (void)r, (void)values;
    if (n != 1 || *sizes > 64)
        return 3;
    memcpy(m->bytes[0], *v, m->size[0] = *sizes);
    return 0;
}

int fmi3GetBinary(Model *m, const Reference *r, size_t n, size_t *sizes, const uint8_t **v, size_t values)
{
    for (size_t i = 0; i < n; i++)
        v[i] = m->bytes[r[i] >= OUT], sizes[i] = m->size[r[i] >= OUT];
    return values != n ? 3 : 0;
}

int fmi3GetFMUState(Model *m, void **s) { *s = *s ? *s : malloc(sizeof *m); memcpy(*s, m, sizeof *m); return 0; }
int fmi3SetFMUState(Model *m, void *s) { memcpy(m, s, sizeof *m); return 0; }
int fmi3FreeFMUState(void *m, void **s) { (void)m; free(*s); *s = NULL; return 0; }
