/* One FMU instance in the C front: a slave, its storage, and the host's logger.

   The front is the shared library of an FMU. The functions of the standards are in fmi2.c and fmi3.c, their common
   parts in common.c. There are two kinds of slave. One is Python (front.c, on Linux). The library then has no Python
   symbols: it uses the Python that is already in the process, or starts one, imports the slave, and forwards every
   call. Numbers do not pass through Python: the slave returns the addresses of its two arrays (layout), which the front
   reads and writes. The other kind is linked machine code (native.c, runtime.c), on any system. */

#ifndef FRONT_H
#define FRONT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef unsigned int Reference;
typedef struct { int64_t first, size, reserved; } Block;         /* references first..first+size-1 <-> reserved.. */
typedef struct { int64_t type, offset, size; } Entry;   /* a variable of the table; type 0 real, 1 integer, 2 text, 3 choice */

typedef struct Instance {
    void *slave;                            /* owned: a PyObject, or the slave of native.c */
    char *name, *resources;
    void *environment;                      /* the host's */
    int logging;                            /* warnings and errors are sent even without it */
    void (*send)(struct Instance *, int status, const char *category, const char *text);
    void (*logger)(void);                   /* the host's, with the type of its standard */
    void *text;                             /* PyObject that keeps the last returned strings alive */
    double reached;                         /* end of the last step taken */
    int initialising;                       /* in Initialization Mode, where outputs follow inputs */
    double *real;
    int64_t *integer;
    int64_t reals, integers, strings;
    int64_t first_integer, first_string;    /* FMI 2: value references count through all types, reals from 0 */
    int64_t courses, seeds, products, variables;    /* lengths of the arrays below */
    Block *course, *seed, *product;         /* a course: consecutive derivatives of an input, up to the third */
    Entry *variable;
} Instance;

enum { OK, WARNING, DISCARD, ERROR, FATAL };    /* numbers of statuses in both standards */

/* Create an instance, NULL if rejected; takes ownership of the path. `token` is the GUID (FMI 2) or instantiation token
   (FMI 3) that the host read in the model description. It must match resources/token.txt. */
Instance *front_create(const char *name, const char *token, char *resources, Instance settings);
void front_free(Instance *);
int front_reset(Instance *);
void front_log(Instance *, int status, const char *format, ...);
int front_step(Instance *, double time, double step);
int front_initialise(Instance *, int enters);                   /* enter Initialization Mode, or leave it */
int front_show(Instance *);                                     /* before values are read */
int front_terminate(Instance *);
int front_products(Instance *);                                 /* products for the seeds, both in reserved storage */
int front_set_text(Instance *, Reference, const char *text);    /* references from first_string on */
int front_get_texts(Instance *, const Reference *, size_t count, const char **texts);
int front_derivative(Instance *, const Reference *unknown, size_t unknowns, const Reference *known, size_t knowns,
                     const double *seed, double *product);                      /* of the step map, Reals only */
int front_get_state(Instance *, void **state);
int front_set_state(Instance *, void *state);
void front_free_state(void **state);
int front_state_to_bytes(Instance *, void *state, char *bytes, size_t *size);   /* bytes NULL: only the size */
int front_state_from_bytes(Instance *, const char *bytes, size_t size, void **state);

/* in common.c */
void front_first_line(FILE *, char *line, int size);            /* of a file or a command's output, empty if there is none */
int front_is_own(Instance *, const char *token);

#endif
