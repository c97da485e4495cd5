/* What fuzz_calls.c asks, by the functions of FMI 3.0. */

typedef void Logger(void *environment, int status, const char *category, const char *message);

void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const Reference *, size_t,
                                  void *, Logger *, void *);
void fmi3FreeInstance(void *);
int fmi3Reset(void *), fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3ExitInitializationMode(void *), fmi3Terminate(void *);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);
int fmi3SetFloat64(void *, const Reference *, size_t, const double *, size_t);
int fmi3GetFloat64(void *, const Reference *, size_t, double *, size_t);
int fmi3SetInt32(void *, const Reference *, size_t, const int32_t *, size_t);
int fmi3GetInt32(void *, const Reference *, size_t, int32_t *, size_t);
int fmi3SetInt64(void *, const Reference *, size_t, const int64_t *, size_t);
int fmi3GetInt64(void *, const Reference *, size_t, int64_t *, size_t);
int fmi3GetString(void *, const Reference *, size_t, const char **, size_t);
int fmi3GetDirectionalDerivative(void *, const Reference *, size_t, const Reference *, size_t, const double *, size_t, double *,
                                 size_t);
int fmi3GetNumberOfVariableDependencies(void *, Reference, size_t *);
int fmi3GetFMUState(void *, void **), fmi3SetFMUState(void *, void *), fmi3FreeFMUState(void *, void **);
int fmi3SerializedFMUStateSize(void *, void *, size_t *), fmi3SerializeFMUState(void *, void *, char *, size_t);
int fmi3DeserializeFMUState(void *, const char *, size_t, void **);

static void log_it(void *environment, int status, const char *category, const char *message)
{
    (void)environment, (void)status, (void)category;
    words += strlen(message) > 0;
}

static void *made(const Fmu *f, const char *resources, bool with_logger, bool logging)
{
    return fmi3InstantiateCoSimulation("one", f->token, resources, false, logging, false, false, NULL, 0, NULL,
                                       with_logger ? log_it : NULL, NULL);
}

static void release(void *one) { fmi3FreeInstance(one); }
static int reset(void *one) { return fmi3Reset(one); }
static int enter(void *one)
{
    return fmi3EnterInitializationMode(one, any(2), number(), any(4) ? 0.0 : number(), any(2), number());
}

static int enter_at_zero(void *one) { return fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0); }
static int leave(void *one) { return fmi3ExitInitializationMode(one); }
static int terminate(void *one) { return fmi3Terminate(one); }
static int get_state(void *one, void **state) { return fmi3GetFMUState(one, state); }
static int set_state(void *one, void *state) { return fmi3SetFMUState(one, state); }
static int free_state(void *one, void **state) { return fmi3FreeFMUState(one, state); }
static int state_size(void *one, void *state, size_t *size) { return fmi3SerializedFMUStateSize(one, state, size); }
static int to_bytes(void *one, void *state, char *bytes, size_t size) { return fmi3SerializeFMUState(one, state, bytes, size); }

static int from_bytes(void *one, const char *bytes, size_t size, void **state)
{
    return fmi3DeserializeFMUState(one, bytes, size, state);
}

static int step(void *one, double time, double length)
{
    bool event, stop, early;
    double reached;
    return fmi3DoStep(one, time, length, any(2), &event, &stop, &early, &reached);
}

static double reached(void *one, const Fmu *f)
{
    double time = 0.0;
    Reference of_time = (Reference)f->count;
    fmi3GetFloat64(one, &of_time, 1, &time, 1);
    return time;
}

/* References, mostly of variables of one kind, and how many values go with them: once in eight times another number. */
typedef struct { Reference vr[MOST]; size_t count, values; } Chosen;

static Chosen chosen(const Fmu *f, bool real)
{
    Chosen c = {.count = any(8)};
    for (size_t k = 0; k < c.count; k++) {
        for (int tries = 0; tries < 9; tries++) {
            c.vr[k] = reference(f->count);
            if (c.vr[k] >= f->count || (f->size[c.vr[k]] > 0) == real)
                break;
        }
        c.values += c.vr[k] < f->count ? (size_t)labs(f->size[c.vr[k]]) : 1;        /* the one behind the last is time */
    }
    if (!any(8))
        c.values = any((uint32_t)c.values + 3);
    return c;
}

static void ask_or_tell(void *one, const Fmu *f)
{
    bool whole = !any(4);
    Chosen c = chosen(f, !whole), d = chosen(f, any(8));
    double *value = malloc(c.values * sizeof *value), *product = malloc(d.values * sizeof *product);
    int32_t *integer = malloc(c.values * sizeof *integer);
    int64_t *choice = malloc(c.values * sizeof *choice);
    const char **text = malloc(c.values * sizeof *text);
    size_t dependencies;
    for (size_t k = 0; k < c.values; k++) {
        value[k] = number();
        choice[k] = integer[k] = any(3) ? (int32_t)any(6) : (int32_t)any(UINT32_MAX);
    }
    if (whole)
        switch (any(6)) {
        case 0: count(fmi3SetInt32(one, c.vr, c.count, integer, c.values)); break;
        case 1: count(fmi3GetInt32(one, c.vr, c.count, integer, c.values)); break;
        case 2: count(fmi3SetInt64(one, c.vr, c.count, choice, c.values)); break;
        case 3: count(fmi3GetInt64(one, c.vr, c.count, choice, c.values)); break;
        case 4: count(fmi3GetString(one, c.vr, c.count, text, c.values)); break;
        case 5: count(fmi3GetNumberOfVariableDependencies(one, c.vr[0], &dependencies)); break;
        }
    else
        switch (any(4)) {
        case 0: count(fmi3SetFloat64(one, c.vr, c.count, value, c.values)); break;
        case 1: case 2: count(fmi3GetFloat64(one, c.vr, c.count, value, c.values)); break;
        case 3: count(fmi3GetDirectionalDerivative(one, d.vr, d.count, c.vr, c.count, value, c.values, product, d.values)); break;
        }
    free(value), free(product), free(integer), free(choice), free(text);
}
