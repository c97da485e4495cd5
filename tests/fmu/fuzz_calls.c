/* Calls at random of the functions of FMI 2.0 or, with FMI3 defined, of FMI 3.0, linked with the library of a native FMU
   under AddressSanitizer: references that are none, sizes that do not fit, numbers that are none, states of others, of
   another FMU, freed before, damaged; instances freed twice. Each call answers with a status of the standard, and no word
   of memory is touched that is not its.

   fuzz_calls CALLS SEED (RESOURCES TOKEN SIZES)...     FMUs of one participant, other sizes
   SIZES is a text, for each variable of the table a number: its elements, negative where they are no real numbers.
   Prints the calls that went well, those that did not, words logged; damaged states that were rejected; states with new
   sums that were rejected; and how many of both were tried. */

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef unsigned int Reference;
typedef struct { const char *resources, *token; int64_t count, *size, reals, others; } Fmu;

enum { INSTANCES = 4, STATES = 12, MOST = 40, STATUSES = 5 };

static uint64_t seed;
static long answered[STATUSES];
static long words;                          /* logged */

static uint32_t any(uint32_t below)         /* xorshift */
{
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (uint32_t)((seed >> 11) % below);
}


static void count(int status)
{
    if (status < 0 || status >= STATUSES)
        fprintf(stderr, "status %d\n", status), exit(1);
    answered[status]++;
}

static double number(void)
{
    const double strange[] = {0.0, -0.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324, -1.0, 1e9};
    return any(3) ? (any(2000) - 1000.0) * (any(2) ? 1e-8 : 1.0) : strange[any(sizeof strange / sizeof *strange)];
}

/* One of `all` references, or, once in ten times, none of them. */
static Reference reference(int64_t all)
{
    if (any(10))
        return (Reference)any((uint32_t)all);
    return any(2) ? (Reference)(all + any(3) - 1) : (Reference)any(UINT32_MAX);
}

#ifndef LONG_STEP
#define LONG_STEP 1.0
#endif

static double step_size(void)
{
    const double strange[] = {0.0, -1e-5, NAN, INFINITY, 1e300, 1e-300, LONG_STEP};
    return any(3) ? 1e-5 * (1 + any(20)) : strange[any(sizeof strange / sizeof *strange)];
}

static void *made(const Fmu *, const char *resources, bool with_logger, bool logging);
static void release(void *);
static int reset(void *), enter(void *), enter_at_zero(void *), leave(void *), terminate(void *), step(void *, double time, double length);
static int get_state(void *, void **), set_state(void *, void *), free_state(void *, void **);
static int state_size(void *, void *, size_t *), to_bytes(void *, void *, char *, size_t);
static int from_bytes(void *, const char *, size_t, void **);
static double reached(void *, const Fmu *);         /* end of the last step [s] */
static void ask_or_tell(void *, const Fmu *);       /* values, derivatives, what is not offered */

#ifdef FMI3
#include "fuzz_fmi3.h"
#else
#include "fuzz_fmi2.h"
#endif

static void *new_instance(const Fmu *f)
{
    void *one = made(f, f->resources, any(8), any(2));
    if (!one)
        fprintf(stderr, "no instance\n"), exit(1);
    return one;
}

/* From its start values, some of them changed, through a few steps. */
static void run(void *one, const Fmu *f)
{
    count(reset(one));
    count(enter(one));
    for (uint32_t k = any(3); k; k--)
        ask_or_tell(one, f);
    count(leave(one));
    for (uint32_t k = any(4); k; k--)
        count(step(one, reached(one, f), 1e-5 * (1 + any(4))));
}

static void *state[STATES];
static size_t length[STATES];
static char *bytes[STATES];

/* Puts a new state in the place of another, which is freed, once more if it was. */
static void keep(void *one, uint32_t k, void *fresh)
{
    void *old = state[k];
    if (!fresh || fresh == old)
        return;
    free_state(one, &old);
    state[k] = fresh;
}

/* States by their addresses, freed ones among them. */
static void states(void *one)
{
    uint32_t k = any(STATES), other = any(STATES);
    void *copy = any(3) ? NULL : state[k];
    size_t size = 0;
    switch (any(7)) {
    case 0:
        count(get_state(one, &copy));
        keep(one, k, copy);
        break;
    case 1: case 2:
        count(set_state(one, state[k]));
        break;
    case 3:
        copy = state[k];
        count(free_state(one, &copy));
        break;
    case 4:
        count(state_size(one, state[k], &size));
        break;
    case 5:
        if (state_size(one, state[k], &size))
            break;
        if (!any(4))
            size = any((uint32_t)size + 100);
        free(bytes[other]);
        bytes[other] = calloc(1, size + 1);
        length[other] = size;
        count(to_bytes(one, state[k], bytes[other], size));
        break;
    case 6:
        if (!bytes[other])
            break;
        if (length[other] && !any(2))
            bytes[other][any((uint32_t)length[other])] ^= (char)(1 << any(8));
        count(from_bytes(one, bytes[other], any(4) ? length[other] : any((uint32_t)length[other] + 1), &copy));
        keep(one, k, copy);
    }
}

static void call(void *one, const Fmu *f)
{
    switch (any(12)) {
    case 0: case 1: count(step(one, any(4) ? reached(one, f) : number(), step_size())); break;
    case 2: run(one, f); break;
    case 3: count(any(2) ? enter(one) : leave(one)); break;
    case 4: if (any(2)) count(terminate(one)); break;
    default: ask_or_tell(one, f);
    }
}

#include "fuzz_forge.h"

static void read_sizes(Fmu *f, const char *text)
{
    char *end;
    f->size = malloc((strlen(text) + 1) * sizeof *f->size);
    for (int64_t size; size = strtol(text, &end, 10), end != text; text = end) {
        f->size[f->count++] = size;
        *(size > 0 ? &f->reals : &f->others) += labs(size);
    }
}

int main(int arguments, char **argument)
{
    long calls = atol(argument[1]), tries = calls / 10;
    seed = 88172645463325252ULL + strtoull(argument[2], NULL, 10);
    int fmus = (arguments - 3) / 3;
    Fmu *fmu = calloc((size_t)fmus, sizeof *fmu);
    for (int k = 0; k < fmus; k++) {
        char **a = argument + 3 + 3 * k;
        fmu[k] = (Fmu){.resources = a[0], .token = a[1]};
        read_sizes(fmu + k, a[2]);
    }
    void *one[INSTANCES], *gone = NULL;
    for (int k = 0; k < INSTANCES; k++) {
        one[k] = new_instance(fmu + k % fmus);
        if (enter_at_zero(one[k]) || leave(one[k]) || step(one[k], 0.0, 1e-5))
            fprintf(stderr, "a step from the start values was refused\n"), exit(1);
    }
    for (long n = 0; n < calls; n++) {
        uint32_t k = any(INSTANCES);
        if (!any(500)) {
            release(gone);          /* freed already, unless it was none */
            release(gone = one[k]);
            release(gone);
            one[k] = new_instance(fmu + k % (uint32_t)fmus);
            gone = NULL;
        } else if (!any(2))
            states(one[k]);
        else
            call(one[k], fmu + k % (uint32_t)fmus);
    }
    for (int k = 0; k < STATES; k++) {
        free_state(one[0], &state[k]);
        free(bytes[k]);
    }
    for (int k = 0; k < INSTANCES; k++)
        release(one[k]);
    long damaged = 0, forged = forged_states(fmu, tries, &damaged);
    for (int k = 0; k < fmus; k++)
        free(fmu[k].size);
    free(fmu);
    printf("%ld %ld %ld %ld %ld %ld\n", answered[0], answered[1] + answered[2] + answered[3] + answered[4], words, damaged,
           forged, tries);
    return 0;
}
