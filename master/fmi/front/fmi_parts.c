/* What the iteration of `run` calls its participants by, where it is machine code
   (master/coupling/methods/compiled_newton.py), and the iteration itself: FMI 2.0 instances of this process by their
   functions, all others together by one of Python's. Inside a coupled slave parts.c is in this place. As the master it
   runs on POSIX systems. */

#include "native.h"

#include <stddef.h>
#include <time.h>

#define EXPORT __attribute__((visibility("default")))

enum { WARNING = 1 };                   /* fmi2Warning: what is worse ends the iteration */
enum { ADVANCE = 2, TANGENT };          /* as in master/coupling/native_system.py */
enum { CODE, REAL };                    /* as `ParticipantRow` in master/coupling/native_block.py begins */
enum { SET_STATE = 1, SET, STEP, GET, DERIVE };

/* As `Instance` in master/participants/pointers.py. */
typedef struct {
    int (*ask)(int64_t);                /* Python's, which knows where the numbers are; NULL: what follows is called */
    void *component, *begin;            /* the instance, and its state at the beginning of the macro step */
    int (*set_state)(void *, void *);
    int (*set)(void *, const uint32_t *, size_t, const double *);
    int (*step)(void *, double, double, int);
    int (*get)(void *, const uint32_t *, size_t, double *);
    int (*derive)(void *, const uint32_t *, size_t, const uint32_t *, size_t, const double *, double *);
    const uint32_t *inputs, *outputs;
    size_t input_count, output_count;
    double spent, carried;              /* in steps and derivatives; in setting and reading [s] */
    int64_t calls;                      /* steps and derivatives that were begun */
    int64_t failed, status;             /* the function that failed and what it returned; 0 */
    int64_t is_called;                  /* a step or a derivative is under way */
} Instance;

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

static int is_well(Instance *one, int function, int status)
{
    if (status <= WARNING)
        return 1;
    one->failed = function;
    one->status = status;
    return 0;
}

/* real: inputs, outputs, seeds, products. */
static int advance(Instance *one, double *real, double time, double step)
{
    double begun = now(), fed, stepped;
    if (!is_well(one, SET_STATE, one->set_state(one->component, one->begin)))
        return 1;
    if (one->input_count && !is_well(one, SET, one->set(one->component, one->inputs, one->input_count, real)))
        return 1;
    one->is_called = 1;
    fed = now();
    one->calls++;
    int is_taken = is_well(one, STEP, one->step(one->component, time, step, 1 /* no state before `time` is restored */));
    stepped = now();
    one->spent += stepped - fed;
    one->is_called = 0;
    if (!is_taken)
        return 1;
    real += one->input_count;
    if (one->output_count && !is_well(one, GET, one->get(one->component, one->outputs, one->output_count, real)))
        return 1;
    one->carried += fed - begun + now() - stepped;
    return 0;
}

static int derive(Instance *one, double *real)
{
    double begun = now(), *seeds = real + one->input_count + one->output_count;
    one->is_called = 1;
    one->calls++;
    int status = one->derive(one->component, one->outputs, one->output_count, one->inputs, one->input_count, seeds,
                             seeds + one->input_count);
    one->spent += now() - begun;
    one->is_called = 0;
    return !is_well(one, DERIVE, status);
}

/* The row's code is the address of the instance: a whole number that a double holds. */
INTERNAL int32_t native_part(int64_t entry, const double *row, double *memory, double *numbers)
{
    Instance *one = (Instance *)(uintptr_t)row[CODE];
    double *real = memory + (size_t)row[REAL];
    if (one->ask)
        return one->ask(entry);
    return entry == ADVANCE ? advance(one, real, numbers[1], numbers[0]) : derive(one, real);
}

INTERNAL Entering master_coupling_methods_iterate;

EXPORT void *iteration_make(void)
{
    return pool_make();
}

EXPORT void iteration_free(void *pool)
{
    pool_free(pool);
}

/* A macro step to its fixed point; 0, or an exception was raised. */
EXPORT int iteration_run(void *pool, double *real, double *memory, double *numbers, const int64_t lengths[4])
{
    int64_t none = 0;
    return pool_run(pool, master_coupling_methods_iterate, real, &none, memory, numbers, lengths);
}
