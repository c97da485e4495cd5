/* A slave of machine code: its entries, which LLVM made of numba's kernels, and their memory.

   An entry works on the slave's real and integer variables, its own memory and a few numbers of the call. `lengths`
   contains their lengths. The first two arguments and the status belong to numba: status 0, or an exception was
   raised. */

#ifndef NATIVE_H
#define NATIVE_H

#include <stdint.h>

/* Of a function that the library does not export, wherever it is defined. */
#ifdef _WIN32
#define INTERNAL
#else
#define INTERNAL __attribute__((visibility("hidden")))
#endif

typedef int32_t Entering(void **result, void **raised, double *real, int64_t *integer, double *memory, double *numbers,
                         const int64_t lengths[4]);

/* The slave's entries, whatever their names in the object file (builder_native.link). */
INTERNAL Entering native_start;      /* state and outputs for the variables */
INTERNAL Entering native_advance;    /* numbers[0], [1]: length of the step and its beginning [s]; [2]: was_saved */
INTERNAL Entering native_tangent;    /* of the last step, from the seeds among the variables to the products */

/* Pools with the blocks of memory of a call, which later calls of any instance reuse. Each call has a pool for itself, so
   that instances may run in parallel. Each instance opens the pools and closes them; the last one frees them.
   Only `pool_run` calls entries. */
void pool_open(void);
void pool_close(void);
int pool_run(Entering *, double *real, int64_t *integer, double *memory, double *numbers, const int64_t lengths[4]);

#endif
