/* Calls at random of the functions of FMI 2.0, linked with the library of a native FMU under AddressSanitizer: references
   that are none, sizes that do not fit, numbers that are none, states of others, of another FMU, freed before, damaged;
   instances freed twice. Each call answers with a status of the standard, and no word of memory is touched that is not its.

   fuzz_calls CALLS SEED SCRATCH (RESOURCES GUID REALS INTEGERS)...     FMUs of one participant, other sizes
   Prints the calls that went well, those that did not, words logged, damaged files that were refused and those tried. */

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef unsigned int Reference;
typedef struct { void *logger, *allocate, *release, *finished, *environment; } Callbacks;
typedef struct { const char *resources, *guid; int64_t reals, integers; } Fmu;

void *fmi2Instantiate(const char *, int, const char *, const char *, const Callbacks *, int, int);
void fmi2FreeInstance(void *);
int fmi2Reset(void *), fmi2EnterInitializationMode(void *), fmi2ExitInitializationMode(void *), fmi2Terminate(void *);
int fmi2DoStep(void *, double, double, int);
int fmi2SetReal(void *, const Reference *, size_t, const double *), fmi2GetReal(void *, const Reference *, size_t, double *);
int fmi2SetInteger(void *, const Reference *, size_t, const int *), fmi2GetInteger(void *, const Reference *, size_t, int *);
int fmi2GetBoolean(void *, const Reference *, size_t, int *);
int fmi2GetString(void *, const Reference *, size_t, const char **);
int fmi2SetRealInputDerivatives(void *, const Reference *, size_t, const int *, const double *);
int fmi2GetDirectionalDerivative(void *, const Reference *, size_t, const Reference *, size_t, const double *, double *);
int fmi2GetFMUstate(void *, void **), fmi2SetFMUstate(void *, void *), fmi2FreeFMUstate(void *, void **);
int fmi2SerializedFMUstateSize(void *, void *, size_t *), fmi2SerializeFMUstate(void *, void *, char *, size_t);
int fmi2DeSerializeFMUstate(void *, const char *, size_t, void **);
int fmi2GetRealStatus(void *, int, double *);

enum { INSTANCES = 4, STATES = 12, MOST = 40, STATUSES = 5 };

static uint64_t seed;
static long answered[STATUSES], words;

static uint32_t any(uint32_t below)         /* xorshift */
{
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (uint32_t)((seed >> 11) % below);
}

static void log_it(void *environment, const char *instance, int status, const char *category, const char *message, ...)
{
    char text[40000];
    va_list list;
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(list, message);
    words += vsnprintf(text, sizeof text, message, list) > 0;
    va_end(list);
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

static Reference reference(const Fmu *f)
{
    int64_t all = f->reals + f->integers;
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

static void *new_instance(const Fmu *f)
{
    static Callbacks callbacks = {.logger = log_it};
    void *one = fmi2Instantiate("one", 1, f->guid, f->resources, any(8) ? &callbacks : NULL, 0, (int)any(2));
    if (!one)
        fprintf(stderr, "no instance\n"), exit(1);
    return one;
}

/* From its start values through a few steps. */
static void run(void *one)
{
    count(fmi2Reset(one));
    count(fmi2EnterInitializationMode(one));
    count(fmi2ExitInitializationMode(one));
    for (uint32_t k = any(4); k; k--)
        count(fmi2DoStep(one, 0.0, 1e-5 * (1 + any(4)), 0));
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
    fmi2FreeFMUstate(one, &old);
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
        count(fmi2GetFMUstate(one, &copy));
        keep(one, k, copy);
        break;
    case 1: case 2:
        count(fmi2SetFMUstate(one, state[k]));
        break;
    case 3:
        copy = state[k];
        count(fmi2FreeFMUstate(one, &copy));
        break;
    case 4:
        count(fmi2SerializedFMUstateSize(one, state[k], &size));
        break;
    case 5:
        if (fmi2SerializedFMUstateSize(one, state[k], &size))
            break;
        if (!any(4))
            size = any((uint32_t)size + 100);
        free(bytes[other]);
        bytes[other] = calloc(1, size + 1);
        length[other] = size;
        count(fmi2SerializeFMUstate(one, state[k], bytes[other], size));
        break;
    case 6:
        if (!bytes[other])
            break;
        if (length[other] && !any(2))
            bytes[other][any((uint32_t)length[other])] ^= (char)(1 << any(8));
        count(fmi2DeSerializeFMUstate(one, bytes[other], any(4) ? length[other] : any((uint32_t)length[other] + 1), &copy));
        keep(one, k, copy);
    }
}

static void call(void *one, const Fmu *f)
{
    Reference vr[MOST], more[MOST];
    double value[MOST], product[MOST];
    int integer[MOST], order[MOST];
    const char *text[MOST];
    size_t n = any(MOST), m = any(MOST);
    for (size_t k = 0; k < MOST; k++) {
        vr[k] = k && any(4) ? vr[k - 1] + 1 : reference(f);
        more[k] = reference(f), value[k] = number();
        integer[k] = any(3) ? (int)any(6) : (int)any(UINT32_MAX), order[k] = (int)any(6) - 1;
    }
    switch (any(12)) {
    case 0: count(fmi2SetReal(one, vr, n, value)); break;
    case 1: count(fmi2GetReal(one, vr, n, value)); break;
    case 2: count(any(4) ? fmi2GetInteger(one, vr, n, integer) : fmi2SetInteger(one, vr, n, integer)); break;
    case 3: count(fmi2GetBoolean(one, vr, n, integer)); break;
    case 4: count(fmi2GetString(one, vr, n, text)); break;
    case 5: count(fmi2SetRealInputDerivatives(one, vr, n, order, value)); break;
    case 6: count(fmi2GetDirectionalDerivative(one, more, m, vr, n, value, product)); break;
    case 7: case 8: count(fmi2DoStep(one, number(), step_size(), 0)); break;
    case 9: run(one); break;
    case 10: count(any(2) ? fmi2EnterInitializationMode(one) : fmi2ExitInitializationMode(one)); break;
    case 11: count(any(2) ? fmi2Terminate(one) : fmi2GetRealStatus(one, (int)any(5), value)); break;
    }
}

/* Damaged copies of resources/slave.bin, each of which has to be refused; how many were. */
static long damaged_files(const Fmu *f, const char *scratch, long tries)
{
    char path[4096];
    static Callbacks callbacks = {.logger = log_it};
    snprintf(path, sizeof path, "%s/slave.bin", f->resources);
    FILE *file = fopen(path, "rb");
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    char *whole = malloc(size), *damaged = malloc(size);
    rewind(file);
    if (fread(whole, 1, size, file) != size)
        exit(1);
    fclose(file);
    long refused = 0;
    snprintf(path, sizeof path, "%s/slave.bin", scratch);
    for (long k = 0; k < tries; k++) {
        size_t kept = k % 2 ? size : any((uint32_t)size);
        memcpy(damaged, whole, size);
        for (uint32_t n = k % 2 ? 1 + any(3) : 0; n; n--)
            damaged[any(any(2) ? 400 : (uint32_t)size)] ^= (char)(1 << any(8));
        if (kept == size && !memcmp(damaged, whole, size))
            damaged[0] ^= 1;
        file = fopen(path, "wb");
        fwrite(damaged, 1, kept, file);
        fclose(file);
        long before = words;
        void *one = fmi2Instantiate("one", 1, f->guid, scratch, &callbacks, 0, 0);
        refused += !one && words > before;
        fmi2FreeInstance(one);
    }
    free(whole), free(damaged);
    return refused;
}

int main(int arguments, char **argument)
{
    long calls = atol(argument[1]), tries = calls / 100 + 100;
    seed = 88172645463325252ULL + strtoull(argument[2], NULL, 10);
    int fmus = (arguments - 4) / 4;
    Fmu *fmu = calloc((size_t)fmus, sizeof *fmu);
    for (int k = 0; k < fmus; k++) {
        char **a = argument + 4 + 4 * k;
        fmu[k] = (Fmu){a[0], a[1], atol(a[2]), atol(a[3])};
    }
    void *one[INSTANCES], *gone = NULL;
    for (int k = 0; k < INSTANCES; k++) {
        one[k] = new_instance(fmu + k % fmus);
        run(one[k]);
    }
    for (long n = 0; n < calls; n++) {
        uint32_t k = any(INSTANCES);
        if (!any(500)) {
            fmi2FreeInstance(gone);          /* freed already, unless it was none */
            fmi2FreeInstance(gone = one[k]);
            fmi2FreeInstance(gone);
            one[k] = new_instance(fmu + k % (uint32_t)fmus);
            gone = NULL;
        } else if (!any(2))
            states(one[k]);
        else
            call(one[k], fmu + k % (uint32_t)fmus);
    }
    for (int k = 0; k < STATES; k++) {
        fmi2FreeFMUstate(one[0], &state[k]);
        free(bytes[k]);
    }
    for (int k = 0; k < INSTANCES; k++)
        fmi2FreeInstance(one[k]);
    long refused = damaged_files(fmu, argument[3], tries);
    free(fmu);
    printf("%ld %ld %ld %ld %ld\n", answered[0], answered[1] + answered[2] + answered[3] + answered[4], words, refused, tries);
    return 0;
}
