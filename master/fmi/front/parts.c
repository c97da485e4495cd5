/* Participants that the machine code of a coupled slave calls: the entries of those inside it, and FMI 2.0 instances of
   the process for the iteration of `run`. PARTS names the packages, PART(fmu_ehd) PART(fmu_mfbd). */

#include "native.h"

#include <stddef.h>
#include <string.h>
#include <time.h>

#define EXPORT __attribute__((visibility("default")))

#define PART(package) INTERNAL Entering package##_start, package##_advance, package##_tangent;
PARTS
#undef PART

#define PART(package) {package##_start, package##_advance, package##_tangent},
static Entering *const entries[][3] = {PARTS};
#undef PART

/* As `ParticipantRow` in master/coupling/native_block.py begins. */
enum { CODE, REAL, REALS, INTEGER, INTEGERS, MEMORY, MEMORIES };
enum { ADVANCE = 1 };                   /* as in master/coupling/native_system.py; other entries are derivatives */
enum { WHOLE, TO_COORDINATES, FROM_COORDINATES, READ, PLACE };      /* tasks of these, as in master/fmi/native_parts.py */
enum { FIRST_CALLED = 256, EMPTY = 2, WARNING = 1 };        /* as in master/coupling/compiled_newton.py */

/* An instance, as `Called` in master/coupling/compiled_newton.py. Its variables are inputs, outputs, seeds, products. */
typedef struct {
    void *component, *begin;            /* the instance, and its state at the beginning of the macro step */
    int (*set_state)(void *, void *);
    int (*set)(void *, const uint32_t *, size_t, const double *);
    int (*step)(void *, double, double, int);
    int (*get)(void *, const uint32_t *, size_t, double *);
    int (*derive)(void *, const uint32_t *, size_t, const uint32_t *, size_t, const double *, double *);
    int64_t (*task)(void *, double, double, double **);
    const uint32_t *inputs, *outputs;
    size_t input_count, output_count;
    double spent, carried;              /* in steps and derivatives; in values and states [s] */
    int has_moved;                      /* whether it may have left the state at the beginning */
} Called;

static _Thread_local Called *called;
static _Thread_local size_t called_count;

static double now(void)
{
#ifdef _WIN32
    return 0.0;                         /* `run` does not iterate by instances there */
#else
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
#endif
}

/* Set an instance to its state at the beginning of the macro step, and its inputs; 0, or a call failed. */
static int32_t set_back(Called *one, const double *inputs)
{
    return (one->has_moved && one->set_state(one->component, one->begin) > WARNING)
           || one->set(one->component, one->inputs, one->input_count, inputs) > WARNING;
}

/* Run a derivative of an instance, or a task on its coordinates; 0, or a call failed. */
static int32_t run_derivative(Called *one, double *real, double *coordinates, const double *numbers)
{
    double *outputs = real + one->input_count, *seeds = outputs + one->output_count, *own = NULL;
    int task = (int)numbers[0], reads = task <= TO_COORDINATES, writes = task == WHOLE || task == FROM_COORDINATES;
    size_t size = 0;
    if (task == PLACE && set_back(one, real))
        return 1;
    if (task != WHOLE) {
        size = (size_t)one->task(one->component, numbers[0], numbers[1], &own) * sizeof(double);
        memcpy(own, coordinates, size);
    }
    int status = one->derive(one->component, one->outputs, writes ? one->output_count : 0, one->inputs,
                             reads ? one->input_count : 0, seeds, seeds + one->input_count);
    if (size)
        memcpy(coordinates, own, size);
    if (task == PLACE && status <= WARNING)
        status = one->get(one->component, one->outputs, one->output_count, outputs);
    return status > WARNING;
}

/* Run an entry of an instance; 0, or a call failed. */
static int32_t run_called(Called *one, int64_t entry, double *real, double *memory, const double *numbers)
{
    double begun = now();
    if (entry != ADVANCE) {
        int32_t failed = run_derivative(one, real, memory + EMPTY, numbers);
        one->has_moved = 1;
        one->spent += now() - begun;
        return failed;
    }
    if (set_back(one, real))
        return 1;
    double fed = now();
    one->has_moved = 1;
    int status = one->step(one->component, numbers[1], numbers[0], 1 /* no state before is restored */);
    double stepped = now();
    if (status <= WARNING)
        status = one->get(one->component, one->outputs, one->output_count, real + one->input_count);
    one->spent += stepped - fed;
    one->carried += fed - begun + now() - stepped;
    return status > WARNING;
}

/* Entry of a participant on its part of the whole memory; 0, or an exception was raised, or there is no such code. Called within `pool_run`. */
INTERNAL int32_t native_part(int64_t entry, const double *row, double *memory, double *numbers)
{
    if (!(row[CODE] < FIRST_CALLED + called_count))
        return -1;
    size_t code = (size_t)row[CODE];
    if (code >= FIRST_CALLED)
        return run_called(called + code - FIRST_CALLED, entry, memory + (size_t)row[REAL], memory + (size_t)row[MEMORY],
                          numbers);
    if (code >= sizeof entries / sizeof *entries)
        return -1;
    void *result = NULL, *raised = NULL;
    const int64_t lengths[4] = {(int64_t)row[REALS], (int64_t)row[INTEGERS], (int64_t)row[MEMORIES], 4};
    return entries[code][entry](&result, &raised, memory + (size_t)row[REAL],
                                             (int64_t *)(memory + (size_t)row[INTEGER]), memory + (size_t)row[MEMORY],
                                             numbers, lengths);
}

INTERNAL Entering native_iterate;

/* Iterate a macro step of instances to its fixed point (`iterate` in master/coupling/native.py); 0, or an exception was
   raised. */
EXPORT int coupling_iterate(Called *instances, size_t count, double *real, double *memory, double *numbers,
                            const int64_t lengths[4])
{
    int64_t none = 0;
    called = instances;
    called_count = count;
    int status = pool_run(native_iterate, real, &none, memory, numbers, lengths);
    called_count = 0;
    return status;
}
