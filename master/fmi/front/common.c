/* Common parts of all fronts, for slaves in Python and in machine code. See front.h. */

#include "front.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void front_log(Instance *I, int status, const char *format, ...)
{
    char text[20000];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    I->send(I, status, status == DISCARD ? "logStatusDiscard" : "logStatusError", text);
}

/* Read the first line of a file or of a command's output; empty if there is none. */
void front_first_line(FILE *stream, char *line, int size)
{
    if (!fgets(line, size, stream))
        line[0] = 0;
    line[strcspn(line, "\n")] = 0;
}

/* Return whether the token is that of the FMU; log it if not. An FMU without its resources fails later, with its name. */
int front_is_own(Instance *I, const char *token)
{
    char path[8192], own[128] = "";
    snprintf(path, sizeof path, "%s/token.txt", I->resources);
    FILE *file = fopen(path, "r");
    if (!file)
        return 1;
    front_first_line(file, own, sizeof own);
    fclose(file);
    int same = token && !strcmp(token, own);
    if (!same)
        front_log(I, ERROR, "instantiate: %s is not the identifier of this FMU, %s: its model description is another's",
                  token ? token : "nothing", own);
    return same;
}

/* ---- derivatives ------------------------------------------------------------------------------------------------ */

enum { NO_DEPENDENCE = -1, UNKNOWN = -2 };

/* Return the index into `real` that is reserved for the seed or product of a reference; NO_DEPENDENCE for a variable
   without one; UNKNOWN, logged, if there is no such variable. */
static int64_t reserved(Instance *I, const Block *blocks, int64_t count, Reference reference)
{
    for (int64_t k = 0; k < count; k++)
        if (reference >= blocks[k].first && reference < blocks[k].first + blocks[k].size)
            return blocks[k].reserved + reference - blocks[k].first;
    if ((int64_t)reference < I->reals)
        return NO_DEPENDENCE;
    front_log(I, ERROR, "directional derivative: no real variable of value reference %u", reference);
    return UNKNOWN;
}

int front_derivative(Instance *I, const Reference *unknown, size_t unknowns, const Reference *known, size_t knowns,
                     const double *seed, double *product)
{
    for (int64_t k = 0; k < I->seeds; k++)
        memset(I->real + I->seed[k].reserved, 0, (size_t)I->seed[k].size * sizeof(double));
    int moves = 0, status = OK;
    for (size_t k = 0; k < knowns; k++) {
        int64_t index = reserved(I, I->seed, I->seeds, known[k]);
        if (index == UNKNOWN)
            return ERROR;
        if (index >= 0) {
            I->real[index] = seed[k];
            moves = 1;
        }
    }
    if (moves)
        status = front_products(I);
    for (size_t k = 0; status == OK && k < unknowns; k++) {
        int64_t index = reserved(I, I->product, I->products, unknown[k]);
        if (index == UNKNOWN)
            return ERROR;
        product[k] = moves && index >= 0 ? I->real[index] : 0.0;
    }
    return status;
}
