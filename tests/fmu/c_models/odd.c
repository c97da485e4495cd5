/* One input, one output, as an FMI 2.0 FMU with the habits of FMUs that other tools export. Parts are chosen by -D:

   STEP      what a step does to x, given u and the length H      default: x' = u - x, backward Euler
   OUTPUT    y                                                    default: x
   FEEDS     y follows u at once
   UNDOES    takes its last step back where it is told that an earlier state may be restored
   DEAF      answers 0 if its input is read
   SAVES=0   saves no states
   FORGETS   a state that is restored makes it start its integrator anew: x is off by this share of itself
   NOISE     y is off by 0 to 4 times this share of itself, as often as states were restored
   SHARES    all instances share their memory

   STEP and OUTPUT know x, u, the length H and begin t of the step. The integer output n counts steps, and 1000 less for
   each state that is restored. */

#include <stdlib.h>
#include <string.h>

#ifndef STEP
#define STEP x = (x + H * u) / (1 + H)
#endif
#ifndef OUTPUT
#define OUTPUT x
#endif
#ifndef SAVES
#define SAVES 1
#endif

typedef struct { double x, y, u, before, begun; } Model; /* references 0 to 2: x, y, u */
typedef struct { Model m; int n; } Instance;
typedef unsigned Reference;
static int restored;

static void say(Model *m)
{
    double x = m->x, u = m->u, t = m->begun;
    (void)x, (void)u, (void)t;
    m->y = OUTPUT;
#ifdef NOISE
    m->y *= 1 + NOISE * (restored % 5);
#endif
}

void *fmi2Instantiate(const char *a, int b, const char *c, const char *d, const void *e, int g, int h)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)g, (void)h;
#ifdef SHARES
    static Instance only;
    Instance *i = &only;
#else
    Instance *i = calloc(1, sizeof *i);
#endif
    i->m.x = i->m.before = 1;
    say(&i->m);
    return i;
}

int fmi2DoStep(Instance *i, double time, double H, int never_back)
{
    double x = i->m.x, u = i->m.u, t = time;
    (void)t, (void)u;
#ifdef UNDOES
    if (!never_back)
        x = i->m.before;
#endif
    (void)never_back;
    i->m.before = x, i->m.begun = time, i->n++;
    STEP;
    i->m.x = x;
    say(&i->m);
    return 0;
}

int fmi2SetReal(Instance *i, const Reference *r, size_t n, const double *v)
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] != 2)
            return 3;
        i->m.u = v[k];
    }
    return 0;
}

int fmi2GetReal(Instance *i, const Reference *r, size_t n, double *v)
{
#ifdef FEEDS
    say(&i->m);
#endif
    for (size_t k = 0; k < n; k++)
        v[k] = (&i->m.x)[r[k]];
#ifdef DEAF
    for (size_t k = 0; k < n; k++)
        v[k] = r[k] == 2 ? 0 : v[k];
#endif
    return 0;
}

int fmi2GetInteger(Instance *i, const Reference *r, size_t n, int *v) { (void)r, (void)n; *v = i->n; return 0; }

int fmi2GetFMUstate(Instance *i, void **s)
{
    if (!SAVES)
        return 3;
    *s = *s ? *s : malloc(sizeof(Model));
    memcpy(*s, &i->m, sizeof(Model));
    return 0;
}

int fmi2SetFMUstate(Instance *i, const void *s)
{
    if (!SAVES)
        return 3;
    memcpy(&i->m, s, sizeof(Model));
#ifdef FORGETS
    i->m.x *= 1 + FORGETS;
#endif
    i->n -= 1000, restored++;
    return 0;
}

int fmi2FreeFMUstate(Instance *i, void **s) { (void)i; free(*s); *s = NULL; return 0; }
int fmi2ExitInitializationMode(Instance *i) { say(&i->m); return 0; }
void fmi2FreeInstance(Instance *i)
{
#ifndef SHARES
    free(i);
#endif
    (void)i;
}
