/* Common parts of all fronts, for slaves in Python and in machine code. See front.h. */

#include "front.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#define NOUSER
#include <windows.h>
#endif

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Names of pythonfmu's log categories, those of statuses in their order. */
static const char *const category[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logAll"};
enum { CATEGORIES = sizeof category / sizeof *category };

void front_log(Instance *I, int status, const char *format, ...)
{
    char text[20000];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    I->send(I, status, category[status - 1], text);
}

/* Read the first line of a file or of a command's output; empty if there is none. */
void front_first_line(FILE *stream, char *line, int size)
{
    if (!fgets(line, size, stream))
        line[0] = 0;
    line[strcspn(line, "\n")] = 0;
}

FILE *front_open(const char *path)
{
#ifdef _WIN32
    wchar_t wide[8192];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 8192) ? _wfopen(wide, L"rb") : NULL;
#else
    return fopen(path, "rb");
#endif
}

/* ---- addresses that hosts hold ------------------------------------------------------------------------------------ */

/* Addresses given to hosts by this library. Freed and unknown addresses are rejected. */
typedef struct { void **at; size_t count, room; } Held;

static Held instances, states;
static atomic_flag busy = ATOMIC_FLAG_INIT;

static size_t place_of(const Held *held, const void *address)
{
    size_t k = held->count;
    while (k && held->at[k - 1] != address)     /* the newest are used most */
        k--;
    return k;
}

static void begin_alone(void)
{
    while (atomic_flag_test_and_set(&busy))
        ;
}

/* Return whether there was memory for it. */
static int hold(Held *held, void *address)
{
    begin_alone();
    if (held->count == held->room) {
        size_t room = 2 * held->room + 16;
        void **more = realloc(held->at, room * sizeof *more);
        if (more)
            held->at = more, held->room = room;
    }
    int fits = held->count < held->room;
    if (fits)
        held->at[held->count++] = address;
    atomic_flag_clear(&busy);
    return fits;
}

static int is_held(const Held *held, const void *address)
{
    begin_alone();
    size_t place = place_of(held, address);
    atomic_flag_clear(&busy);
    return place > 0;
}

/* Return whether it was held. */
static int let_go(Held *held, const void *address)
{
    begin_alone();
    size_t place = place_of(held, address);
    if (place)
        held->at[place - 1] = held->at[--held->count];
    if (!held->count) {
        free(held->at);
        *held = (Held){0};
    }
    atomic_flag_clear(&busy);
    return place > 0;
}

/* ---- phases ------------------------------------------------------------------------------------------------------- */

/* What the standards allow in each phase: its name, what a host should do next, and which variables it may set. */
static const struct { const char *name, *hint, *settable; unsigned causalities; } phase[PHASES] = {
    [INSTANTIATED] = {"before Initialization Mode", "enter Initialization Mode first", "a parameter or an input",
                      1 << PARAMETER | 1 << TUNABLE | 1 << INPUT},
    [INITIALIZING] = {"in Initialization Mode", "leave Initialization Mode first", "a parameter or an input",
                      1 << PARAMETER | 1 << TUNABLE | 1 << INPUT},
    [STEPPING] = {"in Step Mode", "reset the instance to start again", "an input or a tunable parameter",
                  1 << TUNABLE | 1 << INPUT},
    [TERMINATED] = {"after termination", "reset the instance to start again", "no variable", 0},
};

/* Return whether the instance is in the phase of a function; log it if not. */
static int is_in(Instance *I, const char *where, int expected)
{
    if (I->phase != expected)
        front_log(I, ERROR, "%s: expected a call %s, got one %s; %s", where, phase[expected].name, phase[I->phase].name,
                  phase[I->phase].hint);
    return I->phase == expected;
}

int front_may_set(Instance *I, const char *where, Reference reference, int64_t causality)
{
    const char *const names[] = {"parameter", "input", "constant", "output", "tunable parameter"};
    int may = phase[I->phase].causalities >> causality & 1;
    if (!may)
        front_log(I, ERROR, "%s: expected %s %s, got the %s of value reference %u", where, phase[I->phase].settable,
                  phase[I->phase].name, names[causality], reference);
    return may;
}

int front_logs(Instance *I, const char *where, int logging, size_t count, const char *const *categories)
{
    for (size_t k = 0; k < count; k++) {
        int known = 0;
        while (known < CATEGORIES && strcmp(categories[k] ? categories[k] : "", category[known]))
            known++;
        if (known == CATEGORIES) {
            front_log(I, ERROR, "%s: expected a log category of the model description, got %s", where,
                      categories[k] ? categories[k] : "NULL");
            return ERROR;
        }
    }
    I->logging = logging;
    return OK;
}

int front_set_up(Instance *I, const char *where, double start, int stops, double stop)
{
    if (!is_in(I, where, INSTANTIATED))
        return ERROR;
    if (!isfinite(start) || (stops && !(start <= stop))) {
        front_log(I, ERROR, "%s: expected a finite start before the stop, got start %g s and stop %g s", where, start, stop);
        return ERROR;
    }
    I->reached = start;
    I->stop = stops ? stop : INFINITY;
    return OK;
}

int front_enter(Instance *I, const char *where)
{
    int status = is_in(I, where, INSTANTIATED) ? slave_initialise(I, 1) : ERROR;
    if (status <= WARNING)
        I->phase = INITIALIZING;
    return status;
}

/* If the slave rejects its parameters, each later step reports why. */
int front_leave(Instance *I, const char *where)
{
    if (!is_in(I, where, INITIALIZING))
        return ERROR;
    I->phase = STEPPING;
    return slave_initialise(I, 0);
}

int front_show(Instance *I) { return I->phase == INITIALIZING ? slave_show(I) : OK; }

/* A step begins where the last one ended, except for rounding of the host's times. It ends by the stop time; that of a
   host whose clock counts whole nanoseconds is off by less than a hundredth of a step. */
int front_step(Instance *I, const char *where, double time, double step)
{
    const double share = 1e-6, rounding = 4.0 * DBL_EPSILON, lenience = 1e-2;
    if (!is_in(I, where, STEPPING))
        return ERROR;
    if (!isfinite(time) || isnan(step)) {
        front_log(I, ERROR, "%s: expected finite times, got a step of %g s at %g s", where, step, time);
        return ERROR;
    }
    if (!(fabs(time - I->reached) <= share * fabs(step) + rounding * fabs(time))) {
        front_log(I, ERROR, "%s: expected a step at %.15g s, got one at %.15g s; restore a state to return", where, I->reached, time);
        return ERROR;
    }
    if (isfinite(step) && time + step - I->stop > lenience * fabs(step) + rounding * fabs(time)) {
        front_log(I, ERROR, "%s: expected a step to at most %.15g s, the stop time, got one to %.15g s", where, I->stop, time + step);
        return ERROR;
    }
    int status = slave_step(I, time, step);
    if (status <= WARNING)
        I->reached = time + step;
    return status;
}

int front_terminate(Instance *I, const char *where)
{
    if (!is_in(I, where, STEPPING))
        return ERROR;
    I->phase = TERMINATED;
    return slave_terminate(I);
}

/* ---- instances ---------------------------------------------------------------------------------------------------- */

/* Return whether the token is that of the FMU; log it if not. */
static int is_own(Instance *I, const char *token)
{
    char path[8192], own[128] = "";
    snprintf(path, sizeof path, "%s/token.txt", I->resources);
    FILE *file = front_open(path);
    if (!file) {
        front_log(I, ERROR, "instantiate: expected the folder resources of this FMU, got %s, which has no token.txt", I->resources);
        return 0;
    }
    front_first_line(file, own, sizeof own);
    fclose(file);
    int same = token && !strcmp(token, own);
    if (!same)
        front_log(I, ERROR, "instantiate: %s is not the identifier of this FMU, %s: its model description is another's",
                  token ? token : "nothing", own);
    return same;
}

static int list_causalities(Instance *I)
{
    const int64_t first[] = {0, I->first_integer, I->first_string, I->first_integer};
    I->causality = calloc((size_t)(I->first_string + I->strings) + 1, 1);
    for (int64_t k = 0; I->causality && k < I->variables; k++) {
        const Entry *v = I->variable + k;
        memset(I->causality + first[v->type] + v->offset, (int)v->causality, (size_t)v->size);
    }
    return I->causality ? OK : ERROR;
}

static void release(Instance *I)
{
    slave_free(I);
    free(I->rate);
    free(I->causality);
    free(I->name);
    free(I->resources);
    free(I);
}

Instance *front_create(const char *name, const char *token, char *resources, Instance settings)
{
    Instance *I = malloc(sizeof *I);
    char *own = malloc(strlen(name ? name : "instance") + 1);
    if (!I || !own) {
        free(I);
        free(own);
        free(resources);
        return NULL;
    }
    *I = settings;
    I->stop = INFINITY;
    I->name = strcpy(own, name ? name : "instance");
    I->resources = resources;
    I->token = token;
#ifdef _WIN32
    if (resources[0] == '/' && resources[1] && resources[2] == ':')      /* file:///C:/.. */
        memmove(resources, resources + 1, strlen(resources));
#endif
    if (is_own(I, token) && slave_create(I) == OK && list_causalities(I) == OK && hold(&instances, I))
        return I;
    release(I);
    return NULL;
}

void front_free(Instance *I)
{
    if (let_go(&instances, I))
        release(I);
}

int front_reset(Instance *I)
{
    I->phase = INSTANTIATED;
    I->reached = 0.0;
    I->stop = INFINITY;
    free(I->rate);
    I->rate = NULL;
    return slave_reset(I);
}

/* ---- states ------------------------------------------------------------------------------------------------------- */

/* A state of an instance: that of its slave, and where the instance is. As bytes, `Progress` follows the slave's bytes. */
typedef struct { double reached; int64_t phase; uint64_t check; } Progress;
typedef struct { void *slaves; Progress progress; } State;

static Progress progress_at(double reached, int64_t phase)
{
    Progress progress = {reached, phase, 0};
    memcpy(&progress.check, &reached, sizeof reached);
    progress.check = ~(progress.check * 0x9e3779b97f4a7c15ull) ^ (uint64_t)phase;
    return progress;
}

/* Return whether this library gave the state to the host, which has not freed it; log it if not. */
static int is_own_state(Instance *I, const char *where, const void *state)
{
    int own = is_held(&states, state);
    if (!own)
        front_log(I, ERROR, "%s: expected a state of this FMU, got %s", where, state ? "an unknown or freed address" : "NULL");
    return own;
}

/* Give a state to the host, or free it if there is no memory for that. */
static int give(Instance *I, const char *where, void *slaves, Progress progress, void **state)
{
    State *fresh = malloc(sizeof *fresh);
    if (!fresh || !hold(&states, fresh)) {
        front_log(I, ERROR, "%s: there is not enough memory for a state", where);
        free(fresh);
        slave_free_state(slaves);
        return ERROR;
    }
    *fresh = (State){slaves, progress};
    *state = fresh;
    return OK;
}

int front_get_state(Instance *I, const char *where, void **state)
{
    Progress progress = progress_at(I->reached, I->phase);
    State *old = *state;
    if (old) {
        if (!is_own_state(I, where, old))
            return ERROR;
        old->progress = progress;
        return slave_get_state(I, &old->slaves);
    }
    void *slaves = NULL;
    int status = slave_get_state(I, &slaves);
    return status == OK ? give(I, where, slaves, progress, state) : status;
}

int front_set_state(Instance *I, const char *where, void *state)
{
    if (!is_own_state(I, where, state))
        return ERROR;
    State *saved = state;
    int status = slave_set_state(I, saved->slaves);
    if (status <= WARNING) {
        I->reached = saved->progress.reached;
        I->phase = (int)saved->progress.phase;
    }
    return status;
}

void front_free_state(void **state)
{
    State *saved = *state;
    if (let_go(&states, saved)) {
        slave_free_state(saved->slaves);
        free(saved);
    }
    *state = NULL;
}

int front_state_to_bytes(Instance *I, const char *where, void *state, char *bytes, size_t *size)
{
    if (!is_own_state(I, where, state))
        return ERROR;
    State *saved = state;
    size_t length;
    int status = slave_state_to_bytes(I, saved->slaves, NULL, &length);
    size_t total = length + sizeof(Progress);
    if (status != OK || !bytes) {
        *size = total;
        return status;
    }
    if (*size < total) {
        front_log(I, ERROR, "%s: expected room for %zu bytes, got %zu", where, total, *size);
        return ERROR;
    }
    status = slave_state_to_bytes(I, saved->slaves, bytes, &length);
    memcpy(bytes + length, &saved->progress, sizeof(Progress));
    return status;
}

int front_state_from_bytes(Instance *I, const char *where, const char *bytes, size_t size, void **state)
{
    Progress progress = {0};
    if (bytes && size >= sizeof progress)
        memcpy(&progress, bytes + size - sizeof progress, sizeof progress);
    Progress sound = progress_at(progress.reached, progress.phase);
    if (memcmp(&sound, &progress, sizeof sound) || progress.phase < 0 || progress.phase >= PHASES) {
        front_log(I, ERROR, "%s: expected the bytes of a state of this FMU, got %zu other or damaged bytes", where, size);
        return ERROR;
    }
    void *slaves = NULL;
    int status = slave_state_from_bytes(I, bytes, size - sizeof progress, &slaves);
    if (status != OK)
        return status;
    front_free_state(state);
    return give(I, where, slaves, progress, state);
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

/* Return how many references from the first one on are consecutive within its block; 1 if it is in none. */
static size_t run_of(const Block *blocks, int64_t count, const Reference *reference, size_t references)
{
    size_t run = 1, left = 0;
    for (const Block *b = blocks; b < blocks + count && !left; b++)
        if (*reference >= b->first && *reference < b->first + b->size)
            left = (size_t)(b->first + b->size - *reference);
    while (run < references && run < left && reference[run] == *reference + run)
        run++;
    return run;
}

int front_derivative(Instance *I, const char *where, const Reference *unknown, size_t unknowns, const Reference *known,
                     size_t knowns, const double *seed, double *product)
{
    if (!is_in(I, where, STEPPING))
        return ERROR;
    for (int64_t k = 0; k < I->seeds; k++)
        memset(I->real + I->seed[k].reserved, 0, (size_t)I->seed[k].size * sizeof(double));
    int moves = I->task != 0.0, status = OK;
    for (size_t k = 0, run; k < knowns; k += run) {
        int64_t index = reserved(I, I->seed, I->seeds, known[k]);
        run = run_of(I->seed, I->seeds, known + k, knowns - k);
        if (index == UNKNOWN)
            return ERROR;
        if (index >= 0) {
            memcpy(I->real + index, seed + k, run * sizeof *seed);
            moves = 1;
        }
    }
    if (moves)
        status = slave_products(I);
    for (size_t k = 0, run; status == OK && k < unknowns; k += run) {
        int64_t index = reserved(I, I->product, I->products, unknown[k]);
        run = run_of(I->product, I->products, unknown + k, unknowns - k);
        if (index == UNKNOWN)
            return ERROR;
        if (moves && index >= 0)
            memcpy(product + k, I->real + index, run * sizeof *product);
        else
            memset(product + k, 0, run * sizeof *product);
    }
    return status;
}
