/* Native entries of front_toy.py, and the functions of runtime.c for a test. Positions as the variables are declared:
   real gain, bias, x0, extra, u, x, total, then seeds u and products x, total; integer cells, law, rounds, count. */

#include "native.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
#define ARGUMENTS void **result, void **raised, double *real, int64_t *integer, double *memory, double *numbers, \
                  const int64_t lengths[4]
#define UNUSED (void)result, (void)raised, (void)real, (void)integer, (void)memory, (void)numbers, (void)lengths

enum { CELLS = 6, GAIN = 0, BIAS, START, EXTRA, U, X = U + CELLS, TOTAL = X + CELLS, SEED, PRODUCT = SEED + CELLS };
enum { LAW = 1, ROUNDS, COUNT };

void *NRT_MemInfo_alloc_aligned(size_t size, uint32_t alignment);
void NRT_MemInfo_call_dtor(void *counted);
void native_dot(int64_t n, const double *a, const double *b, double *out);
void native_times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y);
int numba_attempt_nocopy_reshape(ptrdiff_t old_count, const ptrdiff_t *old_shape, const ptrdiff_t *old_strides,
                                 ptrdiff_t count, const ptrdiff_t *shape, ptrdiff_t *strides, ptrdiff_t item, int by_columns);

static double *state(double *memory) { return memory + (size_t)memory[1]; }
static double *faults(double *memory) { return memory + (size_t)memory[3]; }
static double *gain(double *memory) { return memory + (size_t)memory[4]; }     /* of the last start */

static void publish(double *real, const double *x)
{
    real[TOTAL] = 0.0;
    for (int k = 0; k < CELLS; k++)
        real[TOTAL] += real[X + k] = x[k];
}

int32_t toy_start(ARGUMENTS)
{
    UNUSED;
    double *x = state(memory), *f = faults(memory);
    if (real[START] > 100.0)
        f[0] = 1.0, f[1] = 0.0, f[4] = real[START];
    if (real[START] < 0.0)
        f[1] = -1.0 - 1.0;
    for (int k = 0; k < CELLS; k++)
        x[k] = real[START];
    x[CELLS] = 0.0;
    *gain(memory) = real[GAIN];
    publish(real, x);
    return 0;
}

static double power_of(const int64_t *integer, double u, int less) { return pow(u, (double)(integer[LAW] - less)); }

int32_t toy_advance(ARGUMENTS)
{
    UNUSED;
    double *x = state(memory), *f = faults(memory);
    if (real[U] == -1234.0)
        return 1;
    if (real[START] < 0.0)
        f[1] = -1.0 - 1.0;
    for (int k = 0; k < CELLS; k++) {
        double rate = (double)integer[ROUNDS] * (*gain(memory) * power_of(integer, real[U + k], 0) + real[BIAS]) + real[EXTRA];
        if (fabs(rate) > 9.0 && f[0] < 2.0) {
            double *one = f + 1 + 6 * (size_t)f[0]++;
            one[0] = 2.0, one[1] = k / 3 + 1, one[2] = k % 3 + 1, one[3] = rate, one[4] = numbers[1], one[5] = numbers[0];
        }
        if (f[0] == 0.0)
            x[k] += numbers[0] * rate;
    }
    x[CELLS] = numbers[0];
    integer[COUNT]++;
    if (f[0] == 0.0)
        publish(real, x);
    return 0;
}

int32_t toy_tangent(ARGUMENTS)
{
    UNUSED;
    double step = state(memory)[CELLS] * real[GAIN] * (double)integer[ROUNDS];
    real[PRODUCT + CELLS] = 0.0;
    for (int k = 0; k < CELLS; k++) {
        real[PRODUCT + k] = step * (double)integer[LAW] * power_of(integer, real[U + k], 1) * real[SEED + k];
        real[PRODUCT + CELLS] += real[PRODUCT + k];
    }
    return 0;
}

/* ---- runtime.c ---------------------------------------------------------------------------------------------------- */

#ifdef __x86_64__
extern int native_wide;
EXPORT int toy_wide(int wide) { int before = native_wide; native_wide = wide; return before; }
#endif

EXPORT void toy_times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y)
{
    native_times(turned, m, n, a, lead, x, y);
}

EXPORT double toy_dot(int64_t n, const double *a, const double *b)
{
    double out;
    native_dot(n, a, b, &out);
    return out;
}

EXPORT int toy_reshape(ptrdiff_t old_count, const ptrdiff_t *old_shape, const ptrdiff_t *old_strides, ptrdiff_t count,
                       const ptrdiff_t *shape, ptrdiff_t *strides, int by_columns)
{
    return numba_attempt_nocopy_reshape(old_count, old_shape, old_strides, count, shape, strides, 8, by_columns);
}

typedef struct { size_t count; void *destructor, *told, *data; size_t size; } Counted;

/* Allocate and free as `integer` says: sizes, or -1 - k to free block k; `memory` gets the addresses of the data. */
static int32_t allocate(ARGUMENTS)
{
    UNUSED;
    Counted *block[16] = {NULL};
    for (int64_t k = 0; k < lengths[1]; k++) {
        if (integer[k] < 0) {
            NRT_MemInfo_call_dtor(block[-1 - integer[k]]);
            block[-1 - integer[k]] = NULL;
            continue;
        }
        Counted *one = block[k] = NRT_MemInfo_alloc_aligned((size_t)integer[k], (uint32_t)numbers[0]);
        memory[k] = one && one->count == 1 && one->size == (size_t)integer[k] ? (double)(uintptr_t)one->data : 0.0;
        if (one)
            memset(one->data, (int)k + 1, one->size);
    }
    for (int64_t k = 0; k < lengths[1]; k++)        /* no block has written into another one */
        for (size_t e = 0; block[k] && e < block[k]->size; e++)
            if (((char *)block[k]->data)[e] != (char)(k + 1))
                memory[k] = -1.0;
    return 0;
}

EXPORT void toy_allocate(int64_t count, int64_t *sizes, double *addresses, double alignment)
{
    const int64_t lengths[4] = {0, count, count, 1};
    pool_run(allocate, NULL, sizes, addresses, &alignment, lengths);
}
