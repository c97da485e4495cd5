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
typedef struct { int64_t type, offset, size, causality; } Entry;    /* a variable of the table, with numbers of `Type` and `Causality` */

typedef struct Instance {
    void *slave;                            /* owned: a PyObject, or the slave of native.c */
    char *name, *resources;
    const char *token;                      /* the host's, during front_create */
    void *environment;                      /* the host's */
    int logging;                            /* warnings and errors are sent even without it */
    void (*send)(struct Instance *, int status, const char *category, const char *text);
    void (*logger)(void);                   /* the host's, with the type of its standard */
    void *text;                             /* PyObject that keeps the last returned strings alive */
    double reached, stop;                   /* end of the last step taken; stop time, infinite if there is none */
    int phase;                              /* one of `Phase` */
    double *real;
    int64_t *integer;
    int64_t reals, integers, strings;
    int64_t first_integer, first_string;    /* FMI 2: value references count through all types, reals from 0 */
    int64_t courses, seeds, products, variables;    /* lengths of the arrays below */
    Block *course, *seed, *product;         /* a course: consecutive derivatives of an input, up to the third */
    Entry *variable;
    unsigned char *causality;               /* by value references of FMI 2 */
    double *rate;                           /* owned: derivatives of reals by order, then the reals; NULL if none is set */
    double task, more;                      /* of native.c: what the next derivative does, the whole if 0 */
} Instance;

enum { OK, WARNING, DISCARD, ERROR, FATAL };    /* numbers of statuses in both standards */
enum Phase { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, PHASES };
enum Type { REAL, INTEGER, TEXT, CHOICE };
enum Causality { PARAMETER, INPUT, CONSTANT, OUTPUT, TUNABLE };   /* as `KINDS` in variables.py */

/* ---- in common.c: the rules of the standards, equal for all slaves. `where` is the function that the host called. */

/* Create an instance, NULL if rejected; takes ownership of the path. `token` is the GUID (FMI 2) or instantiation token
   (FMI 3) that the host read in the model description. It must match resources/token.txt. */
Instance *front_create(const char *name, const char *token, char *resources, Instance settings);
void front_free(Instance *);
int front_reset(Instance *);
int front_logs(Instance *, const char *where, int logging, size_t count, const char *const *categories);
int front_set_up(Instance *, const char *where, double start, int stops, double stop);
int front_enter(Instance *, const char *where);
int front_leave(Instance *, const char *where);
int front_step(Instance *, const char *where, double time, double step);
int front_terminate(Instance *, const char *where);
int front_show(Instance *);                                     /* before values are read */
int front_may_set(Instance *, const char *where, Reference, int64_t causality);        /* whether; logged if not */
int front_derivative(Instance *, const char *where, const Reference *unknown, size_t unknowns, const Reference *known,
                     size_t knowns, const double *seed, double *product);       /* of the step map, Reals only */
int front_get_state(Instance *, const char *where, void **state);
int front_set_state(Instance *, const char *where, void *state);
void front_free_state(void **state);
int front_state_to_bytes(Instance *, const char *where, void *state, char *bytes, size_t *size);   /* bytes NULL: only the size */
int front_state_from_bytes(Instance *, const char *where, const char *bytes, size_t size, void **state);

void front_log(Instance *, int status, const char *format, ...);
FILE *front_open(const char *path);                             /* to read; paths of the standards are UTF-8 */
void front_first_line(FILE *, char *line, int size);            /* of a file or a command's output, empty if there is none */

/* ---- in front.c and native.c: what a slave does */

int slave_create(Instance *);                                   /* status; also fills the lengths, arrays and addresses above */
void slave_free(Instance *);
int slave_reset(Instance *);
int slave_initialise(Instance *, int enters);                   /* enter Initialization Mode, or leave it */
int slave_show(Instance *);                                     /* let outputs follow inputs in Initialization Mode */
int slave_step(Instance *, double time, double step);
int slave_terminate(Instance *);
int slave_products(Instance *);                                 /* products for the seeds, both in reserved storage */
int slave_set_text(Instance *, Reference, const char *text);    /* references from first_string on */
int slave_get_texts(Instance *, const Reference *, size_t count, const char **texts);
int slave_get_state(Instance *, void **state);                  /* overwrites a state that is not NULL */
int slave_set_state(Instance *, void *state);
void slave_free_state(void *state);
int slave_state_to_bytes(Instance *, void *state, char *bytes, size_t *size);      /* bytes NULL, or with enough room */
int slave_state_from_bytes(Instance *, const char *bytes, size_t size, void **state);

#endif
