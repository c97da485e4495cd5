/* The functions of FMI 2.0 for co-simulation, for the slave of front.h. */

#include "front.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void Logger(void *environment, const char *instance, int status, const char *category, const char *message, ...);
typedef struct { Logger *logger; void *allocate, *release, *finished, *environment; } Callbacks;

#define EXPORT __attribute__((visibility("default")))

/* ---- instances -------------------------------------------------------------------------------------------------- */

/* Double every %, because a printf-like logger must not find a conversion in a message. */
static void send(Instance *I, int status, const char *category, const char *text)
{
    if (!I->logger)
        return;
    char *safe = malloc(2 * strlen(text) + 1), *end = safe;
    if (!safe)
        return;
    for (const char *c = text; *c; c++) {
        *end++ = *c;
        if (*c == '%')
            *end++ = '%';
    }
    *end = 0;
    ((Logger *)I->logger)(I->environment, I->name, status, category, safe);
    free(safe);
}

/* Return the path of a URI, without scheme and authority and with %XX decoded. */
static char *path_of(const char *location)
{
    const char *c = strncmp(location, "file:", 5) ? location : location + 5;
    if (c != location && !strncmp(c, "//", 2))
        c = strchr(c + 2, '/') ? strchr(c + 2, '/') : c + 2;
    char *path = malloc(strlen(c) + 1), *end = path;
    if (!path)
        return NULL;
    for (unsigned int code; *c; end++) {
        int escaped = c[0] == '%' && sscanf(c + 1, "%2x", &code) == 1 && c[1] && c[2];
        *end = escaped ? (char)code : *c;
        c += escaped ? 3 : 1;
    }
    for (*end = 0; end > path + 1 && end[-1] == '/';)
        *--end = 0;
    return path;
}

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *location,
                             const Callbacks *host, int visible, int logging)
{
    (void)visible;
    Instance settings = {.send = send, .logging = logging, .name = (char *)name};
    if (host)
        settings.environment = host->environment, settings.logger = (void (*)(void))host->logger;
    if (type != 1) {
        front_log(&settings, ERROR, "fmi2Instantiate: this FMU is for co-simulation");
        return NULL;
    }
    char *path = path_of(location ? location : "");
    return path ? front_create(name, guid, path, settings) : NULL;
}

EXPORT void fmi2FreeInstance(void *I) { if (I) front_free(I); }
EXPORT int fmi2Reset(void *I) { return front_reset(I); }
EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT int fmi2SetDebugLogging(Instance *I, int logging, size_t count, const char *const *categories)
{
    return front_logs(I, __func__, logging, count, categories);
}

EXPORT int fmi2SetupExperiment(Instance *I, int tolerant, double tolerance, double start, int stops, double stop)
{
    (void)tolerant, (void)tolerance;
    return front_set_up(I, __func__, start, stops, stop);
}

EXPORT int fmi2EnterInitializationMode(Instance *I) { return front_enter(I, __func__); }
EXPORT int fmi2ExitInitializationMode(Instance *I) { return front_leave(I, __func__); }
EXPORT int fmi2Terminate(Instance *I) { return front_terminate(I, __func__); }

enum { HIGHEST = 3 };                       /* order of an input derivative */

/* Eq. (Y1): move the inputs along their derivatives to the end of a step, where the slave reads them. */
static void extrapolate(Instance *I, double step)
{
    const double *first = I->rate, *second = first + I->reals, *third = second + I->reals;
    memcpy(I->rate + HIGHEST * I->reals, I->real, (size_t)I->reals * sizeof *first);
    for (int64_t k = 0; k < I->reals; k++)
        if (first[k] || second[k] || third[k])
            I->real[k] += step * (first[k] + step / 2.0 * (second[k] + step / 3.0 * third[k]));
}

EXPORT int fmi2DoStep(Instance *I, double time, double step, int keeps_no_state)
{
    (void)keeps_no_state;
    if (I->rate)
        extrapolate(I, step);
    int status = front_step(I, __func__, time, step);
    for (int64_t k = 0; I->rate && status > WARNING && k < I->reals; k++)
        if (I->causality[k] == INPUT)
            I->real[k] = I->rate[HIGHEST * I->reals + k];
    free(I->rate);
    I->rate = NULL;
    return status;
}

/* ---- values ----------------------------------------------------------------------------------------------------- */

static int unknown(Instance *I, const char *where, Reference reference)
{
    front_log(I, ERROR, "%s: there is no variable of this type with value reference %u", where, reference);
    return ERROR;
}

/* Define a function that does `action` at each position in a storage whose `number` references begin at `first`, after
   `before`, if the variable may be set or this does not matter. */
#define MAY_SET                                                                                \
    ((k && I->causality[vr[k]] == I->causality[vr[k - 1]])                                     \
     || front_may_set(I, __func__, vr[k], I->causality[vr[k]]))
#define EACH(name, constant, type, first, number, before, may, action)                        \
    EXPORT int name(Instance *I, const Reference *vr, size_t count, constant type *value)     \
    {                                                                                         \
        int status = before;                                                                  \
        for (size_t k = 0; k < count; k++) {                                                  \
            int64_t place = (int64_t)vr[k] - (first);                                         \
            if (place < 0 || place >= (number))                                               \
                return unknown(I, __func__, vr[k]);                                           \
            if (!(may))                                                                       \
                return ERROR;                                                                 \
            action;                                                                           \
        }                                                                                     \
        return status;                                                                        \
    }
EACH(fmi2SetReal, const, double, 0, I->reals, OK, MAY_SET, I->real[place] = value[k])
EACH(fmi2GetReal, , double, 0, I->reals, front_show(I), 1, value[k] = I->real[place])
EACH(fmi2SetInteger, const, int, I->first_integer, I->integers, OK, MAY_SET, I->integer[place] = value[k])
EACH(fmi2GetInteger, , int, I->first_integer, I->integers, front_show(I), 1, value[k] = (int)I->integer[place])
EACH(fmi2SetBoolean, const, int, 0, 0, OK, 1, (void)value)
EACH(fmi2GetBoolean, , int, 0, 0, front_show(I), 1, (void)value)
EACH(fmi2SetString, const, char *const, I->first_string, I->strings, OK, MAY_SET, slave_set_text(I, vr[k], value[k]))

EXPORT int fmi2GetString(Instance *I, const Reference *vr, size_t count, const char **value)
{
    for (size_t k = 0; k < count; k++)
        if ((int64_t)vr[k] < I->first_string || (int64_t)vr[k] >= I->first_string + I->strings)
            return unknown(I, __func__, vr[k]);
    int status = front_show(I);
    return status == OK ? slave_get_texts(I, vr, count, value) : status;
}

/* Set derivatives of inputs at the beginning of the next step. A slave interpolates its courses. Other inputs are
   extrapolated. */
EXPORT int fmi2SetRealInputDerivatives(Instance *I, const Reference *vr, size_t count, const int *order, const double *value)
{
    for (size_t k = 0; k < count; k++) {
        const Block *b = I->course, *end = b + I->courses;
        while (b < end && (vr[k] < b->first || vr[k] >= b->first + b->size))
            b++;
        int is_known = order[k] >= 1 && order[k] <= HIGHEST && (int64_t)vr[k] < I->reals && I->causality[vr[k]] == INPUT;
        if (is_known && b == end && !I->rate)
            I->rate = calloc((HIGHEST + 1) * (size_t)I->reals, sizeof *I->rate);
        if (!is_known || (b == end && !I->rate)) {
            front_log(I, ERROR, "%s: no derivative of order %d for value reference %u", __func__, order[k], vr[k]);
            return ERROR;
        }
        if (b < end)
            I->real[b->reserved + (order[k] - 1) * b->size + vr[k] - b->first] = value[k];
        else
            I->rate[(order[k] - 1) * I->reals + vr[k]] = value[k];
    }
    return OK;
}

/* Copy seeds in and products out of the slave's storage: the step-map derivative of the interface contract. */
EXPORT int fmi2GetDirectionalDerivative(Instance *I, const Reference *unknown, size_t unknowns, const Reference *known,
                                        size_t knowns, const double *seed, double *product)
{
    return front_derivative(I, __func__, unknown, unknowns, known, knowns, seed, product);
}

/* ---- states ----------------------------------------------------------------------------------------------------- */

EXPORT int fmi2GetFMUstate(Instance *I, void **state) { return front_get_state(I, __func__, state); }
EXPORT int fmi2SetFMUstate(Instance *I, void *state) { return front_set_state(I, __func__, state); }
EXPORT int fmi2FreeFMUstate(Instance *I, void **state) { (void)I; if (state) front_free_state(state); return OK; }

EXPORT int fmi2SerializedFMUstateSize(Instance *I, void *state, size_t *size)
{
    return front_state_to_bytes(I, __func__, state, NULL, size);
}

EXPORT int fmi2SerializeFMUstate(Instance *I, void *state, char *bytes, size_t size)
{
    return front_state_to_bytes(I, __func__, state, bytes, &size);
}

EXPORT int fmi2DeSerializeFMUstate(Instance *I, const char *bytes, size_t size, void **state)
{
    return front_state_from_bytes(I, __func__, bytes, size, state);
}

/* ---- features that this FMU does not have, as its model description states -------------------------------------- */

static int not_offered(Instance *I, const char *name)
{
    front_log(I, ERROR, "%s: not offered by this FMU", name);
    return ERROR;
}

EXPORT int fmi2GetRealOutputDerivatives(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2CancelStep(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetStatus(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetIntegerStatus(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetStringStatus(Instance *I) { return not_offered(I, __func__); }

/* model exchange: some importers bind every function of the standard */
EXPORT int fmi2EnterEventMode(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2NewDiscreteStates(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2EnterContinuousTimeMode(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2CompletedIntegratorStep(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2SetTime(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2SetContinuousStates(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetDerivatives(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetEventIndicators(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetContinuousStates(Instance *I) { return not_offered(I, __func__); }
EXPORT int fmi2GetNominalsOfContinuousStates(Instance *I) { return not_offered(I, __func__); }

EXPORT int fmi2GetBooleanStatus(Instance *I, int kind, int *value)
{
    enum { TERMINATED = 3 };
    if (kind != TERMINATED)
        return not_offered(I, __func__);
    *value = 0;
    return OK;
}

EXPORT int fmi2GetRealStatus(Instance *I, int kind, double *value)
{
    enum { LAST_SUCCESSFUL_TIME = 2 };
    if (kind != LAST_SUCCESSFUL_TIME)
        return not_offered(I, __func__);
    *value = I->reached;
    return OK;
}
