/* A lag with clocks of every kind as an FMI 3.0 FMU that keeps to the letter: clocked variables move in Event Mode while
   their clock ticks, a step is taken in Step Mode, an event inside a step ends it. */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { TIME, K, GAIN, CROSS_AT, X0, U, X, Y_IN, U_OUT, MARK, PUSH, WAIT, SAMPLES, LATERS, NEXTS, FIXEDS, KICKS, REALS };
enum { SAMPLE = 20, CROSSED, KICK, PASSED, LATER, NEXT, FIXED, CLOCKS };
enum { STARTING, EVENT, STEP };
typedef struct { double v[REALS], sum; bool ticks[CLOCKS], told; int mode; } Model;
typedef unsigned Reference;

static int clock_of(Reference r) { return r == Y_IN || r == U_OUT ? SAMPLE : r == MARK ? CROSSED : r == PUSH ? KICK : 0; }

static bool is_closed(const Model *m, Reference r)
{
    int clock = clock_of(r);
    return clock && !(m->mode == EVENT && m->ticks[clock]);
}

void *fmi3InstantiateCoSimulation(const char *a, const char *b, const char *c, bool d, bool e, bool events, bool early,
                                  const Reference *h, size_t i, void *j, void *k, void *l)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)h, (void)i, (void)j, (void)k, (void)l;
    if (!events || !early)
        return NULL;
    Model *m = calloc(1, sizeof *m);
    m->v[K] = 1, m->v[GAIN] = 1, m->v[CROSS_AT] = 1e9, m->v[WAIT] = 0.05;
    return m;
}

int fmi3EnterInitializationMode(Model *m, bool t, double tolerance, double start, bool s, double stop)
{
    (void)t, (void)tolerance, (void)s, (void)stop;
    m->v[TIME] = start;
    return 0;
}

int fmi3ExitInitializationMode(Model *m) { m->mode = EVENT; m->v[X] = m->v[X0]; return 0; }
int fmi3EnterEventMode(Model *m) { if (m->mode != STEP) return 3; m->mode = EVENT; return 0; }
int fmi3EnterStepMode(Model *m)
{
    if (m->mode != EVENT)
        return 3;
    memset(m->ticks, 0, sizeof m->ticks);
    m->mode = STEP;
    return 0;
}

int fmi3DoStep(Model *m, double time, double step, bool keeps, bool *event, bool *terminate, bool *early, double *reached)
{
    (void)keeps;
    if (m->mode != STEP || fabs(time - m->v[TIME]) > 1e-9)
        return 3;
    double end = time + step;
    *event = m->v[TIME] < m->v[CROSS_AT] && m->v[CROSS_AT] <= end;
    *early = *event && m->v[CROSS_AT] < end;
    if (*early)
        end = m->v[CROSS_AT];
    double decay = exp(-m->v[K] * (end - time));
    m->v[X] = decay * m->v[X] + (1 - decay) * m->v[U] / m->v[K];
    if (*event)
        m->v[CROSS_AT] = -1e9, m->ticks[CROSSED] = true;
    *terminate = false;
    *reached = m->v[TIME] = end;
    return 0;
}

int fmi3SetFloat64(Model *m, const Reference *r, size_t n, const double *v, size_t values)
{
    (void)values;
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= REALS || (is_closed(m, r[i]) && m->mode != STARTING))
            return 3;
        m->v[r[i]] = v[i];
    }
    return 0;
}

int fmi3GetFloat64(Model *m, const Reference *r, size_t n, double *v, size_t values)
{
    (void)values;
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= REALS || (is_closed(m, r[i]) && r[i] != Y_IN && r[i] != PUSH))
            return 3;
        if (r[i] == U_OUT)
            m->v[U_OUT] = -m->v[GAIN] * (m->v[Y_IN] + m->sum);
        if (r[i] == MARK)
            m->v[MARK] = m->v[X];
        v[i] = m->v[r[i]];
    }
    return 0;
}

int fmi3SetClock(Model *m, const Reference *r, size_t n, const bool *v)
{
    if (m->mode != EVENT)
        return 3;
    for (size_t i = 0; i < n; i++) {
        if (r[i] < SAMPLE || r[i] >= CLOCKS || r[i] == CROSSED || r[i] == PASSED)
            return 3;
        m->ticks[r[i]] = v[i];
        if (r[i] == KICK)
            m->ticks[PASSED] = v[i];
        if (r[i] == LATER)
            m->v[WAIT] *= 2, m->told = false;
    }
    return 0;
}

int fmi3GetClock(Model *m, const Reference *r, size_t n, bool *v)
{
    if (m->mode != EVENT)
        return 3;
    for (size_t i = 0; i < n; i++)
        v[i] = m->ticks[r[i]];
    return 0;
}

int fmi3UpdateDiscreteStates(Model *m, bool *again, bool *end, bool *nominals, bool *values, bool *defined, double *next)
{
    if (m->mode != EVENT)
        return 3;
    m->v[SAMPLES] += m->ticks[SAMPLE], m->v[LATERS] += m->ticks[LATER], m->v[NEXTS] += m->ticks[NEXT];
    m->v[FIXEDS] += m->ticks[FIXED], m->v[KICKS] += m->ticks[KICK];
    if (m->ticks[SAMPLE])
        m->sum += m->v[Y_IN];
    if (m->ticks[KICK] && m->v[PUSH] > 1e6)
        return 3;
    if (m->ticks[KICK])
        m->v[X] += m->v[PUSH];
    memset(m->ticks, 0, sizeof m->ticks);
    *again = *end = *nominals = *values = *defined = false, *next = 0;
    return 0;
}

int fmi3GetIntervalDecimal(Model *m, const Reference *r, size_t n, double *interval, int *qualifier)
{
    for (size_t i = 0; i < n; i++) {
        interval[i] = r[i] == LATER ? m->v[WAIT] : r[i] == NEXT ? 0.1 * (m->v[NEXTS] + 1) : 0.125;
        qualifier[i] = (r[i] == LATER && m->told) || (r[i] == NEXT && m->v[NEXTS] == 2) ? 1 : 2;
        m->told = m->told || r[i] == LATER;
    }
    return 0;
}

int fmi3GetShiftDecimal(Model *m, const Reference *r, size_t n, double *shift)
{
    (void)m, (void)r;
    for (size_t i = 0; i < n; i++)
        shift[i] = 0.025;
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
