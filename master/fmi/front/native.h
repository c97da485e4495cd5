/* A slave of machine code: its entries, which LLVM made of numba's kernels, and the memory that they ask for.

   An entry works on the slave's real and integer variables, its own memory and a few numbers of the call, whose lengths
   stand in `lengths`. The first two arguments are numba's, and so is the status: 0, or an exception was raised. */

#ifndef NATIVE_H
#define NATIVE_H

#include <stdint.h>

typedef int32_t Entering(void **result, void **raised, double *real, int64_t *integer, double *memory, double *numbers,
                         const int64_t lengths[4]);

/* The slave's own, whatever they are called in the object file (builder_native.link). */
Entering native_size;       /* numbers: length of the memory, first of the state, its length, first of the faults */
Entering native_start;      /* state and outputs for the variables */
Entering native_advance;    /* numbers[0], [1]: length of the step and where it begins [s] */
Entering native_tangent;    /* of the last step, from the seeds among the variables to the products */

/* Blocks of memory that come and go within a call, kept for the next one; one pool an instance, so that instances may
   run at the same time. Entries are called by `pool_run` alone. */
typedef struct Pool Pool;
Pool *pool_make(void);
void pool_free(Pool *);
int pool_run(Pool *, Entering *, double *real, int64_t *integer, double *memory, double *numbers, const int64_t lengths[4]);

#endif
