/* Entries of the participants inside a coupled slave: what its machine code calls them by. PARTS names the packages,
   PART(fmu_ehd) PART(fmu_mfbd). */

#include "native.h"

#include <stddef.h>

#define PART(package) INTERNAL Entering package##_size, package##_start, package##_advance, package##_tangent;
PARTS
#undef PART

#define PART(package) {package##_size, package##_start, package##_advance, package##_tangent},
static Entering *const entries[][4] = {PARTS};
#undef PART

/* As `ParticipantRow` in master/coupling/native_block.py begins. */
enum { CODE, REAL, REALS, INTEGER, INTEGERS, MEMORY, MEMORIES };

/* Entry of a participant on its part of the whole memory; 0, or an exception was raised, or there is no such code. Called within `pool_run`. */
INTERNAL int32_t native_part(int64_t entry, const double *row, double *memory, double *numbers)
{
    if (!(row[CODE] < sizeof entries / sizeof *entries))
        return -1;
    void *result = NULL, *raised = NULL;
    const int64_t lengths[4] = {(int64_t)row[REALS], (int64_t)row[INTEGERS], (int64_t)row[MEMORIES], 4};
    return entries[(size_t)row[CODE]][entry](&result, &raised, memory + (size_t)row[REAL],
                                             (int64_t *)(memory + (size_t)row[INTEGER]), memory + (size_t)row[MEMORY],
                                             numbers, lengths);
}
