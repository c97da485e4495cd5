/* What machine code of numba asks of its surroundings: counted blocks of memory, and the shape of an array told anew.
   See native.h. */

#include "native.h"

#include <fenv.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define INTERNAL
#else
#define INTERNAL __attribute__((visibility("hidden")))
#endif

/* ---- memory ------------------------------------------------------------------------------------------------------- */

/* As numba knows it: code reads `count` and `data`. */
typedef struct { size_t count; void *destructor, *told, *data; size_t size; void *allocator; } Counted;

typedef struct Piece {
    Counted counted;
    struct Piece *free_next, *next;     /* of the same size and free; of all */
    int power;
} Piece;

enum { SMALLEST = 8, POWERS = 48, ALIGNMENT = 64 };     /* pieces of 2^8 bytes and more */

struct Pool { Piece *free[POWERS], *all; };

static _Thread_local Pool *pool;        /* of the call that this thread is in */

#ifdef __x86_64__
INTERNAL int native_wide;               /* whether the processor has vectors of four numbers (native_code.in_two_versions) */

static void look_at_processor(void)
{
    __builtin_cpu_init();
    native_wide = __builtin_cpu_supports("avx2");
}
#else
static void look_at_processor(void) {}
#endif

Pool *pool_make(void)
{
    look_at_processor();
    return calloc(1, sizeof(Pool));
}

void pool_free(Pool *p)
{
    for (Piece *piece = p ? p->all : NULL, *next; piece; piece = next) {
        next = piece->next;
        free(piece);
    }
    free(p);
}

int pool_run(Pool *p, Entering *entry, double *real, int64_t *integer, double *memory, double *numbers,
             const int64_t lengths[4])
{
    void *result = NULL, *raised = NULL;
    Pool *outer = pool;
    fenv_t host;
    fegetenv(&host);
    fesetenv(FE_DFL_ENV);               /* a host may round otherwise, or flush small numbers to zero */
    pool = p;
    int status = entry(&result, &raised, real, integer, memory, numbers, lengths);
    pool = outer;
    fesetenv(&host);
    return status;
}

INTERNAL void *NRT_MemInfo_alloc_aligned(size_t size, uint32_t alignment)
{
    int power = SMALLEST;
    if (alignment > ALIGNMENT)
        return NULL;
    while (((size_t)1 << power) < size)
        if (++power == POWERS)
            return NULL;
    Piece *piece = pool->free[power];
    if (piece)
        pool->free[power] = piece->free_next;
    else {
        piece = malloc(sizeof *piece + ALIGNMENT + ((size_t)1 << power));
        if (!piece)
            return NULL;
        *piece = (Piece){.next = pool->all, .power = power};
        piece->counted.data = (void *)(((uintptr_t)(piece + 1) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
        pool->all = piece;
    }
    piece->counted.count = 1;
    piece->counted.size = size;
    return piece;
}

/* Of a block that nobody counts on any more. */
INTERNAL void NRT_MemInfo_call_dtor(void *counted)
{
    Piece *piece = counted;
    piece->free_next = pool->free[piece->power];
    pool->free[piece->power] = piece;
}

/* ---- products ----------------------------------------------------------------------------------------------------- */

enum { LANES = 8 };                     /* sums side by side, which a processor may take at once */

INTERNAL void native_dot(int64_t n, const double *a, const double *b, double *out)
{
    double sum[LANES] = {0.0}, total = 0.0;
    int64_t k = 0;
    for (; k + LANES <= n; k += LANES)
        for (int lane = 0; lane < LANES; lane++)
            sum[lane] += a[k + lane] * b[k + lane];
    for (; k < n; k++)
        total += a[k] * b[k];
    for (int lane = 0; lane < LANES; lane++)
        total += sum[lane];
    *out = total;
}

/* y = A x of a matrix by columns, m rows, n columns; turned 't': y = A^T x. */
INTERNAL void native_times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y)
{
    if (turned == 't') {
        for (int64_t j = 0; j < n; j++)
            native_dot(m, a + j * lead, x, y + j);
        return;
    }
    for (int64_t i = 0; i < m; i++)
        y[i] = 0.0;
    for (int64_t j = 0; j < n; j++)
        for (int64_t i = 0; i < m; i++)
            y[i] += a[j * lead + i] * x[j];
}

/* ---- shapes ------------------------------------------------------------------------------------------------------- */

/* Strides of an array in its new shape. All arrays of the entries that are told a new one are contiguous. */
INTERNAL int numba_attempt_nocopy_reshape(ptrdiff_t old_count, const ptrdiff_t *old_shape, const ptrdiff_t *old_strides,
                                          ptrdiff_t count, const ptrdiff_t *shape, ptrdiff_t *strides, ptrdiff_t item,
                                          int by_columns)
{
    ptrdiff_t expected = item;
    for (ptrdiff_t k = old_count - 1; k >= 0; k--) {
        if (old_shape[k] != 1 && old_strides[k] != expected)
            return 0;
        expected *= old_shape[k];
    }
    for (ptrdiff_t k = count - 1, stride = item; k >= 0; k--) {
        strides[k] = stride;
        stride *= shape[k];
    }
    return !by_columns;
}
