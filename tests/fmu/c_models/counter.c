/* A first-order lag and a counter as an FMI 2.0 FMU: every type of variable of the standard, inputs and outputs.

   Lag:     dx/dt = -k x + u                      by backward Euler
   Counter: n <- n + 1, odd = n mod 2, phase = 1 + n mod 3, words = "step n", each step
   Sums:    sum of what the integer, truth and phase inputs were, a step each; heard: the text input
   Trouble: at the step `trouble_at` what `trouble` says (1 hang, 2 discard, 3 exit(0), 4 print a line); always: change of
            the working directory
   Time:    a step waits WAIT microseconds and computes for BURN microseconds of processor time, 0 unless defined */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#ifndef WAIT
#define WAIT 0
#endif
#ifndef BURN
#define BURN 0
#endif

typedef struct {
    double k, u, x, sums[3];
    int n, number, truth, phase, trouble, trouble_at;
    char heard[64], words[64];
} Model;
typedef unsigned Reference;

void *fmi2Instantiate(const char *a, int b, const char *c, const char *d, const void *e, int g, int h)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)g, (void)h;
    Model *m = calloc(1, sizeof *m);
    m->k = m->x = m->phase = 1;
    m->trouble_at = -1;
    strcpy(m->words, "step 0");
    return m;
}

int fmi2DoStep(Model *m, double time, double step, int last)
{
    (void)time, (void)last;
    if (chdir("/"))
        return 3;
    while (m->trouble == 1 && m->n == m->trouble_at)
        pause();
    if (m->trouble == 2 && m->n == m->trouble_at)
        return 2;
    if (m->trouble == 3 && m->n == m->trouble_at)
        exit(0);
    if (m->trouble == 4 && m->n == m->trouble_at) {
        printf("a banner of the FMU\n");
        fflush(stdout);
    }
    if (WAIT)
        usleep(WAIT);
    if (BURN) {
        clock_t begun = clock();
        while (clock() - begun < BURN * (CLOCKS_PER_SEC / 1000000))
            ;
    }
    m->x = (m->x + step * m->u) / (1 + step * m->k);
    m->n++;
    m->sums[0] += m->number, m->sums[1] += m->truth, m->sums[2] += m->phase;
    snprintf(m->words, sizeof m->words, "step %d", m->n);
    return 0;
}

/* reals: 0 k, 1 u, 2 x, 3 to 5 sums */
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

/* integers: 0 n, 1 number, 2 phase of the counter, 3 phase input, 4 trouble, 5 trouble_at, 6 length of what was heard */
int fmi2SetInteger(Model *m, const Reference *r, size_t n, const int *v)
{
    for (size_t i = 0; i < n; i++)
        *(r[i] == 1 ? &m->number : r[i] == 3 ? &m->phase : r[i] == 4 ? &m->trouble : &m->trouble_at) = v[i];
    return 0;
}

int fmi2GetInteger(Model *m, const Reference *r, size_t n, int *v)
{
    for (size_t i = 0; i < n; i++) {
        const int values[] = {m->n, m->number, 1 + m->n % 3, m->phase, m->trouble, m->trouble_at, (int)strlen(m->heard)};
        v[i] = values[r[i]];
    }
    return 0;
}

int fmi2SetBoolean(Model *m, const Reference *r, size_t n, const int *v) { (void)r, (void)n; m->truth = *v; return 0; }
int fmi2GetBoolean(Model *m, const Reference *r, size_t n, int *v) { (void)r, (void)n; *v = m->n % 2; return 0; }
int fmi2SetString(Model *m, const Reference *r, size_t n, const char *const *v)
{
    (void)r, (void)n;
    snprintf(m->heard, sizeof m->heard, "%s", *v);
    return 0;
}
int fmi2GetString(Model *m, const Reference *r, size_t n, const char **v) { (void)r, (void)n; *v = m->words; return 0; }

int fmi2GetFMUstate(Model *m, void **s) { *s = *s ? *s : malloc(sizeof *m); memcpy(*s, m, sizeof *m); return 0; }
int fmi2SetFMUstate(Model *m, void *s) { memcpy(m, s, sizeof *m); return 0; }
int fmi2FreeFMUstate(void *m, void **s) { (void)m; free(*s); *s = NULL; return 0; }
int fmi2SerializedFMUstateSize(void *m, void *s, size_t *n) { (void)m, (void)s; *n = sizeof(Model); return 0; }
int fmi2SerializeFMUstate(void *m, void *s, char *b, size_t n) { (void)m; memcpy(b, s, n); return 0; }
int fmi2DeSerializeFMUstate(void *m, const char *b, size_t n, void **s)
{
    (void)m; *s = malloc(n); memcpy(*s, b, n);
    return 0;
}
