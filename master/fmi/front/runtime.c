/* Functions that numba's machine code needs: counted blocks of memory, and new shapes of arrays. See native.h. */

#include "native.h"

#include <fenv.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#ifdef __x86_64__
#include <cpuid.h>
#endif

/* ---- memory ------------------------------------------------------------------------------------------------------- */

/* Layout as in numba: code reads `count` and `data`. */
typedef struct { size_t count; void *destructor, *told, *data; size_t size; void *allocator; } Counted;

typedef struct Piece {
    Counted counted;
    struct Piece *free_next, *next;     /* free pieces of the same size; all pieces */
    int power;
} Piece;

enum { SMALLEST = 8, POWERS = 48, ALIGNMENT = 64 };     /* pieces of 2^8 bytes and more */

typedef struct Pool { Piece *free[POWERS], *all; struct Pool *next; } Pool;

static _Thread_local Pool *pool;        /* pool of the current call of this thread */
static Pool *idle;                      /* pools that no call uses */
static size_t instances;                /* that have opened the pools */
static atomic_flag busy = ATOMIC_FLAG_INIT;

#ifdef __x86_64__
INTERNAL int native_wide;               /* whether the processor has vectors of four numbers (native_code.in_two_versions) */

/* Set `native_wide`: the processor has AVX2, and the system saves its registers. __builtin_cpu_supports would need the
   compiler's run-time library, which release libraries do not use. */
static void look_at_processor(void)
{
    enum { VECTOR_STATE = 6 };
    unsigned a, b, c, d, state, rest;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE))
        return;
    __asm__("xgetbv" : "=a"(state), "=d"(rest) : "c"(0));
    native_wide = (state & VECTOR_STATE) == VECTOR_STATE && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2);
}
#else
static void look_at_processor(void) {}
#endif

static void begin_alone(void)
{
    while (atomic_flag_test_and_set(&busy))
        ;
}

void pool_open(void)
{
    begin_alone();
    instances++;
    atomic_flag_clear(&busy);
}

void pool_close(void)
{
    begin_alone();
    for (instances--; !instances && idle;) {
        Pool *p = idle;
        idle = p->next;
        for (Piece *piece = p->all, *next; piece; piece = next) {
            next = piece->next;
            free(piece);
        }
        free(p);
    }
    atomic_flag_clear(&busy);
}

int pool_run(Entering *entry, double *real, int64_t *integer, double *memory, double *numbers,
             const int64_t lengths[4])
{
    void *result = NULL, *raised = NULL;
    begin_alone();
    Pool *outer = pool, *own = idle;
    if (own)
        idle = own->next;
    else
        look_at_processor();
    atomic_flag_clear(&busy);
    if (!own && !(own = calloc(1, sizeof *own)))
        return -1;
    fenv_t host;
    fegetenv(&host);
    fesetenv(FE_DFL_ENV);               /* a host may have another rounding mode, or flush small numbers to zero */
    pool = own;
    int status = entry(&result, &raised, real, integer, memory, numbers, lengths);
    pool = outer;
    fesetenv(&host);
    begin_alone();
    own->next = idle;
    idle = own;
    atomic_flag_clear(&busy);
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

/* Free a block without references. */
INTERNAL void NRT_MemInfo_call_dtor(void *counted)
{
    Piece *piece = counted;
    piece->free_next = pool->free[piece->power];
    pool->free[piece->power] = piece;
}

/* ---- products ----------------------------------------------------------------------------------------------------- */

/* Vectors of four numbers, at any address. A processor with vectors of two splits them, with the same bits, because
   lanes are summed in one order and nothing is fused (-ffp-contract=off). */
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

enum { LANES = 8, TOGETHER = 4 };       /* parallel sums of a product; vectors that are multiplied together */

#define EVERYWHERE static inline __attribute__((always_inline))

EVERYWHERE double added(Four low, Four high, double rest)
{
    for (int lane = 0; lane < 4; lane++)
        rest += low[lane];
    for (int lane = 0; lane < 4; lane++)
        rest += high[lane];
    return rest;
}

EVERYWHERE double dot(int64_t n, const double *a, const double *b)
{
    Four low = {0.0}, high = {0.0};
    double rest = 0.0;
    int64_t k = 0;
    for (; k + LANES <= n; k += LANES) {
        low += *(const Four *)(a + k) * *(const Four *)(b + k);
        high += *(const Four *)(a + k + 4) * *(const Four *)(b + k + 4);
    }
    for (; k < n; k++)
        rest += a[k] * b[k];
    return added(low, high, rest);
}

/* `dot` for each of TOGETHER columns. */
EVERYWHERE void dots(int64_t n, const double *a, int64_t lead, const double *b, double *out)
{
    const double *c = a + lead, *d = c + lead, *e = d + lead;
    Four low[TOGETHER] = {{0.0}}, high[TOGETHER] = {{0.0}};
    double rest[TOGETHER] = {0.0};
    int64_t k = 0;
    for (; k + LANES <= n; k += LANES) {
        Four first = *(const Four *)(b + k), second = *(const Four *)(b + k + 4);
        low[0] += *(const Four *)(a + k) * first;
        high[0] += *(const Four *)(a + k + 4) * second;
        low[1] += *(const Four *)(c + k) * first;
        high[1] += *(const Four *)(c + k + 4) * second;
        low[2] += *(const Four *)(d + k) * first;
        high[2] += *(const Four *)(d + k + 4) * second;
        low[3] += *(const Four *)(e + k) * first;
        high[3] += *(const Four *)(e + k + 4) * second;
    }
    for (; k < n; k++)
        for (int j = 0; j < TOGETHER; j++)
            rest[j] += a[j * lead + k] * b[k];
    for (int j = 0; j < TOGETHER; j++)
        out[j] = added(low[j], high[j], rest[j]);
}

/* y += A x of TOGETHER columns. */
EVERYWHERE void add_columns(int64_t m, const double *a, int64_t lead, const double *x, double *y)
{
    const double *b = a + lead, *c = b + lead, *d = c + lead;
    int64_t i = 0;
    for (; i + 4 <= m; i += 4) {
        Four sum = *(const Four *)(y + i);
        sum += *(const Four *)(a + i) * x[0];
        sum += *(const Four *)(b + i) * x[1];
        sum += *(const Four *)(c + i) * x[2];
        sum += *(const Four *)(d + i) * x[3];
        *(Four *)(y + i) = sum;
    }
    for (; i < m; i++)
        y[i] = y[i] + a[i] * x[0] + b[i] * x[1] + c[i] * x[2] + d[i] * x[3];
}

EVERYWHERE void times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y)
{
    int64_t j = 0;
    if (turned == 't') {
        for (; j + TOGETHER <= n; j += TOGETHER)
            dots(m, a + j * lead, lead, x, y + j);
        for (; j < n; j++)
            y[j] = dot(m, a + j * lead, x);
        return;
    }
    for (int64_t i = 0; i < m; i++)
        y[i] = 0.0;
    for (; j + TOGETHER <= n; j += TOGETHER)
        add_columns(m, a + j * lead, lead, x + j, y);
    for (; j < n; j++)
        for (int64_t i = 0; i < m; i++)
            y[i] += a[j * lead + i] * x[j];
}

#ifdef __x86_64__
#define WIDE __attribute__((target("avx2")))

static WIDE double wide_dot(int64_t n, const double *a, const double *b)
{
    return dot(n, a, b);
}

static WIDE void wide_times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y)
{
    times(turned, m, n, a, lead, x, y);
}
#else
enum { native_wide };
#define wide_dot dot
#define wide_times times
#endif

INTERNAL void native_dot(int64_t n, const double *a, const double *b, double *out)
{
    *out = native_wide ? wide_dot(n, a, b) : dot(n, a, b);
}

/* y = A x of a matrix by columns, m rows, n columns; turned 't': y = A^T x. */
INTERNAL void native_times(char turned, int64_t m, int64_t n, const double *a, int64_t lead, const double *x, double *y)
{
    (native_wide ? wide_times : times)(turned, m, n, a, lead, x, y);
}

/* ---- shapes ------------------------------------------------------------------------------------------------------- */

/* Strides of an array in its new shape. All arrays that get a new shape are contiguous. */
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
