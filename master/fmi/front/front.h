/* One FMU instance as the C front sees it: a slave, its storage, and the host's logger.

   The front is the shared library of an FMU. What the standards ask is in fmi2.c and fmi3.c, what they do alike in
   common.c; they know two kinds of slave. One is Python (front.c, on Linux). The library then holds no Python symbol of
   its own: it takes the Python that is already in the process, or finds one and starts it, imports the slave, and hands
   every call on. Numbers do not pass through Python: the slave tells where its two arrays lie (layout), and they are read
   and written there. The other is machine code that was linked in (native.c, runtime.c), on any system. */

#ifndef FRONT_H
#define FRONT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef unsigned int Reference;
typedef struct { int64_t first, size, reserved; } Block;         /* references first..first+size-1 <-> reserved.. */
typedef struct { int64_t type, offset, size; } Entry;   /* a variable of the table; type 0 real, 1 integer, 2 text, 3 choice */

typedef struct Instance {
    void *slave;                            /* owned: a PyObject, or what native.c knows of one */
    char *name, *resources;
    void *environment;                      /* the host's */
    int logging;                            /* warnings and worse are sent even without */
    void (*send)(struct Instance *, int status, const char *category, const char *text);
    void (*logger)(void);                   /* the host's, of the type its standard gives it */
    void *text;                             /* PyObject: keeps the strings last handed out alive */
    double reached;                         /* end of the last step taken */
    int initialising;                       /* in Initialization Mode: outputs follow what is set */
    double *real;
    int64_t *integer;
    int64_t reals, integers, strings;
    int64_t first_integer, first_string;    /* value references of FMI 2 count through all types; those of reals from 0 */
    int64_t courses, seeds, products, variables;    /* lengths of the arrays below */
    Block *course, *seed, *product;         /* a course: three derivatives of an input, one after the other */
    Entry *variable;
} Instance;

enum { OK, WARNING, DISCARD, ERROR, FATAL };    /* both standards number their statuses so */

/* NULL if refused; takes the path over. `token` is the GUID (FMI 2) or instantiation token (FMI 3) that the host read
   in the model description, which must be the one in resources/token.txt. */
Instance *front_create(const char *name, const char *token, char *resources, Instance settings);
void front_free(Instance *);
int front_reset(Instance *);
void front_log(Instance *, int status, const char *format, ...);
int front_step(Instance *, double time, double step);
int front_initialise(Instance *, int enters);                   /* into Initialization Mode, or out of it */
int front_show(Instance *);                                     /* before values are read */
int front_terminate(Instance *);
int front_products(Instance *);                                 /* of the seeds, both in reserved storage */
int front_set_text(Instance *, Reference, const char *text);    /* references from first_string on */
int front_get_texts(Instance *, const Reference *, size_t count, const char **texts);
int front_derivative(Instance *, const Reference *unknown, size_t unknowns, const Reference *known, size_t knowns,
                     const double *seed, double *product);                      /* of the step map, Reals alone */
int front_get_state(Instance *, void **state);
int front_set_state(Instance *, void *state);
void front_free_state(void **state);
int front_state_to_bytes(Instance *, void *state, char *bytes, size_t *size);   /* bytes NULL: the size alone */
int front_state_from_bytes(Instance *, const char *bytes, size_t size, void **state);

/* in common.c */
void front_first_line(FILE *, char *line, int size);            /* of a file or a command's output; empty without one */
int front_is_own(Instance *, const char *token);

#endif
