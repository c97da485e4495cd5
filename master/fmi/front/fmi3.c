/* The functions of FMI 3.0 for co-simulation, answered by the slave behind front.h.

   A value reference is a variable's place in the slave's table, arrays whole; the one behind the last is time. */

#include "front.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef void Logger(void *environment, int status, const char *category, const char *message);

#define EXPORT __attribute__((visibility("default")))

/* ---- instances -------------------------------------------------------------------------------------------------- */

static void send(Instance *I, int status, const char *category, const char *text)
{
    if (I->logger)
        ((Logger *)I->logger)(I->environment, status, category, text);
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                         bool events, bool early, const Reference *intermediate, size_t count, void *environment,
                                         Logger *logger, void *update)
{
    (void)visible, (void)events, (void)early, (void)intermediate, (void)count, (void)update;
    Instance settings = {.send = send, .logging = logging, .environment = environment, .logger = (void (*)(void))logger};
    char *path = strdup(resources ? resources : "");
    for (size_t end = path ? strlen(path) : 0; end > 1 && path[end - 1] == '/';)
        path[--end] = 0;
    return path ? front_create(name, token, path, settings) : NULL;
}

EXPORT void fmi3FreeInstance(void *I) { if (I) front_free(I); }
EXPORT int fmi3Reset(void *I) { return front_reset(I); }
EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT int fmi3SetDebugLogging(Instance *I, bool logging, size_t count, const char *const *categories)
{
    return front_logs(I, __func__, logging, count, categories);
}

EXPORT int fmi3EnterInitializationMode(Instance *I, bool tolerant, double tolerance, double start, bool stops, double stop)
{
    (void)tolerant, (void)tolerance;
    int status = front_set_up(I, __func__, start, stops, stop);
    return status == OK ? front_enter(I, __func__) : status;
}

EXPORT int fmi3ExitInitializationMode(Instance *I) { return front_leave(I, __func__); }
EXPORT int fmi3EnterStepMode(Instance *I) { (void)I; return OK; }
EXPORT int fmi3EnterConfigurationMode(Instance *I) { (void)I; return OK; }
EXPORT int fmi3ExitConfigurationMode(Instance *I) { (void)I; return OK; }
EXPORT int fmi3Terminate(Instance *I) { return front_terminate(I, __func__); }

EXPORT int fmi3DoStep(Instance *I, double time, double step, bool keeps_no_state, bool *event, bool *terminate, bool *early,
                      double *reached)
{
    (void)keeps_no_state;
    int status = front_step(I, __func__, time, step);
    *event = *terminate = *early = false;
    *reached = status == OK ? time + step : time;
    return status;
}

/* ---- values ----------------------------------------------------------------------------------------------------- */

/* Return whether all references are variables of the type (or time, if allowed) with as many elements as values; log
   the fault if not. */
static bool fits(Instance *I, const char *where, int type, bool with_time, const Reference *vr, size_t count, size_t values)
{
    size_t elements = 0;
    for (size_t k = 0; k < count; k++) {
        bool time = with_time && (int64_t)vr[k] == I->variables;
        if (!time && ((int64_t)vr[k] >= I->variables || I->variable[vr[k]].type != type)) {
            front_log(I, ERROR, "%s: there is no variable of this type with value reference %u", where, vr[k]);
            return false;
        }
        elements += time ? 1 : (size_t)I->variable[vr[k]].size;
    }
    if (elements != values)
        front_log(I, ERROR, "%s: the variables have %zu elements, %zu values were given", where, elements, values);
    return elements == values;
}

/* Return whether the variables fit and may be set; log the fault if not. */
static bool may_set(Instance *I, const char *where, int type, const Reference *vr, size_t count, size_t values)
{
    if (!fits(I, where, type, false, vr, count, values))
        return false;
    for (size_t k = 0; k < count; k++)
        if (!front_may_set(I, where, vr[k], I->variable[vr[k]].causality))
            return false;
    return true;
}

EXPORT int fmi3SetFloat64(Instance *I, const Reference *vr, size_t count, const double *value, size_t values)
{
    if (!may_set(I, __func__, REAL, vr, count, values))
        return ERROR;
    for (size_t k = 0; k < count; value += I->variable[vr[k++]].size)
        memcpy(I->real + I->variable[vr[k]].offset, value, (size_t)I->variable[vr[k]].size * sizeof *value);
    return OK;
}

EXPORT int fmi3GetFloat64(Instance *I, const Reference *vr, size_t count, double *value, size_t values)
{
    if (!fits(I, __func__, REAL, true, vr, count, values))
        return ERROR;
    int status = front_show(I);
    for (size_t k = 0; k < count; k++) {
        bool time = (int64_t)vr[k] == I->variables;
        Entry entry = time ? (Entry){.size = 1} : I->variable[vr[k]];
        memcpy(value, time ? &I->reached : I->real + entry.offset, (size_t)entry.size * sizeof *value);
        value += entry.size;
    }
    return status;
}

/* Integers are Int32. Choices are Enumerations, which are passed as Int64. */
#define WHOLE(set, get, type, kind)                                                                        \
    EXPORT int set(Instance *I, const Reference *vr, size_t count, const type *value, size_t values)       \
    {                                                                                                      \
        if (!may_set(I, __func__, kind, vr, count, values))                                                \
            return ERROR;                                                                                  \
        for (size_t k = 0; k < count; k++)                                                                 \
            for (int64_t e = 0; e < I->variable[vr[k]].size; e++)                                          \
                I->integer[I->variable[vr[k]].offset + e] = *value++;                                      \
        return OK;                                                                                         \
    }                                                                                                      \
    EXPORT int get(Instance *I, const Reference *vr, size_t count, type *value, size_t values)             \
    {                                                                                                      \
        if (!fits(I, __func__, kind, false, vr, count, values))                                            \
            return ERROR;                                                                                  \
        int status = front_show(I);                                                                        \
        for (size_t k = 0; k < count; k++)                                                                 \
            for (int64_t e = 0; e < I->variable[vr[k]].size; e++)                                          \
                *value++ = (type)I->integer[I->variable[vr[k]].offset + e];                                \
        return status;                                                                                     \
    }
WHOLE(fmi3SetInt32, fmi3GetInt32, int32_t, INTEGER)
WHOLE(fmi3SetInt64, fmi3GetInt64, int64_t, CHOICE)

EXPORT int fmi3SetString(Instance *I, const Reference *vr, size_t count, const char *const *value, size_t values)
{
    if (!may_set(I, __func__, TEXT, vr, count, values))
        return ERROR;
    for (size_t k = 0; k < count; k++)
        slave_set_text(I, (Reference)(I->first_string + I->variable[vr[k]].offset), value[k]);
    return OK;
}

EXPORT int fmi3GetString(Instance *I, const Reference *vr, size_t count, const char **value, size_t values)
{
    if (!fits(I, __func__, TEXT, false, vr, count, values))
        return ERROR;
    Reference *offset = malloc(count * sizeof *offset + 1);
    if (!offset)
        return ERROR;
    for (size_t k = 0; k < count; k++)
        offset[k] = (Reference)(I->first_string + I->variable[vr[k]].offset);
    int status = front_show(I);
    if (status == OK)
        status = slave_get_texts(I, offset, count, value);
    free(offset);
    return status;
}

/* ---- derivatives ------------------------------------------------------------------------------------------------ */

/* Return the positions in `real` of all elements of the variables. */
static Reference *elements(Instance *I, const Reference *vr, size_t count, size_t values)
{
    Reference *all = malloc(values * sizeof *all + 1), *next = all;
    for (size_t k = 0; all && k < count; k++)
        for (int64_t e = 0; e < I->variable[vr[k]].size; e++)
            *next++ = (Reference)(I->variable[vr[k]].offset + e);
    return all;
}

EXPORT int fmi3GetDirectionalDerivative(Instance *I, const Reference *unknown, size_t unknowns, const Reference *known,
                                        size_t knowns, const double *seed, size_t seeds, double *product, size_t products)
{
    if (!fits(I, __func__, REAL, false, unknown, unknowns, products) || !fits(I, __func__, REAL, false, known, knowns, seeds))
        return ERROR;
    Reference *from = elements(I, known, knowns, seeds), *to = elements(I, unknown, unknowns, products);
    int status = from && to ? front_derivative(I, __func__, to, products, from, seeds, seed, product) : ERROR;
    free(from);
    free(to);
    return status;
}

EXPORT int fmi3GetNumberOfVariableDependencies(Instance *I, Reference reference, size_t *count)
{
    (void)I, (void)reference;
    *count = 0;
    return OK;
}

/* ---- states ----------------------------------------------------------------------------------------------------- */

EXPORT int fmi3GetFMUState(Instance *I, void **state) { return front_get_state(I, __func__, state); }
EXPORT int fmi3SetFMUState(Instance *I, void *state) { return front_set_state(I, __func__, state); }
EXPORT int fmi3FreeFMUState(Instance *I, void **state) { (void)I; if (state) front_free_state(state); return OK; }

EXPORT int fmi3SerializedFMUStateSize(Instance *I, void *state, size_t *size)
{
    return front_state_to_bytes(I, __func__, state, NULL, size);
}

EXPORT int fmi3SerializeFMUState(Instance *I, void *state, char *bytes, size_t size)
{
    return front_state_to_bytes(I, __func__, state, bytes, &size);
}

EXPORT int fmi3DeserializeFMUState(Instance *I, const char *bytes, size_t size, void **state)
{
    return front_state_from_bytes(I, __func__, bytes, size, state);
}

/* ---- features that this FMU does not have, as its model description states -------------------------------------- */

EXPORT void *fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT void *fmi3InstantiateScheduledExecution(void) { return NULL; }

#define NOT_OFFERED(name)                                           \
    EXPORT int name(Instance *I)                                    \
    {                                                               \
        front_log(I, ERROR, #name ": not offered by this FMU");     \
        return ERROR;                                               \
    }
#define BOTH_WAYS(type) NOT_OFFERED(fmi3Get##type) NOT_OFFERED(fmi3Set##type)

BOTH_WAYS(Float32) BOTH_WAYS(Int8) BOTH_WAYS(UInt8) BOTH_WAYS(Int16) BOTH_WAYS(UInt16) BOTH_WAYS(UInt32)
BOTH_WAYS(UInt64) BOTH_WAYS(Boolean) BOTH_WAYS(Binary) BOTH_WAYS(Clock) BOTH_WAYS(IntervalDecimal) BOTH_WAYS(IntervalFraction)
BOTH_WAYS(ShiftDecimal) BOTH_WAYS(ShiftFraction) BOTH_WAYS(ContinuousStates)
NOT_OFFERED(fmi3GetVariableDependencies) NOT_OFFERED(fmi3GetAdjointDerivative) NOT_OFFERED(fmi3GetOutputDerivatives)
NOT_OFFERED(fmi3EnterEventMode) NOT_OFFERED(fmi3EvaluateDiscreteStates) NOT_OFFERED(fmi3UpdateDiscreteStates)
NOT_OFFERED(fmi3EnterContinuousTimeMode) NOT_OFFERED(fmi3CompletedIntegratorStep) NOT_OFFERED(fmi3SetTime)
NOT_OFFERED(fmi3GetContinuousStateDerivatives) NOT_OFFERED(fmi3GetEventIndicators) NOT_OFFERED(fmi3GetNominalsOfContinuousStates)
NOT_OFFERED(fmi3GetNumberOfEventIndicators) NOT_OFFERED(fmi3GetNumberOfContinuousStates) NOT_OFFERED(fmi3ActivateModelPartition)
