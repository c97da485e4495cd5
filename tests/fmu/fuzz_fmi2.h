/* What fuzz_calls.c asks, by the functions of FMI 2.0. */

typedef struct { void *logger, *allocate, *release, *finished, *environment; } Callbacks;

void *fmi2Instantiate(const char *, int, const char *, const char *, const Callbacks *, int, int);
void fmi2FreeInstance(void *);
int fmi2Reset(void *), fmi2EnterInitializationMode(void *), fmi2ExitInitializationMode(void *), fmi2Terminate(void *);
int fmi2DoStep(void *, double, double, int);
int fmi2SetReal(void *, const Reference *, size_t, const double *), fmi2GetReal(void *, const Reference *, size_t, double *);
int fmi2SetInteger(void *, const Reference *, size_t, const int *), fmi2GetInteger(void *, const Reference *, size_t, int *);
int fmi2GetBoolean(void *, const Reference *, size_t, int *);
int fmi2GetString(void *, const Reference *, size_t, const char **);
int fmi2SetRealInputDerivatives(void *, const Reference *, size_t, const int *, const double *);
int fmi2GetDirectionalDerivative(void *, const Reference *, size_t, const Reference *, size_t, const double *, double *);
int fmi2GetFMUstate(void *, void **), fmi2SetFMUstate(void *, void *), fmi2FreeFMUstate(void *, void **);
int fmi2SerializedFMUstateSize(void *, void *, size_t *), fmi2SerializeFMUstate(void *, void *, char *, size_t);
int fmi2DeSerializeFMUstate(void *, const char *, size_t, void **);
int fmi2GetRealStatus(void *, int, double *);

static void log_it(void *environment, const char *instance, int status, const char *category, const char *message, ...)
{
    char text[40000];
    va_list list;
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(list, message);
    words += vsnprintf(text, sizeof text, message, list) > 0;
    va_end(list);
}

static void *made(const Fmu *f, const char *resources, bool with_logger, bool logging)
{
    static Callbacks callbacks = {.logger = log_it};
    return fmi2Instantiate("one", 1, f->token, resources, with_logger ? &callbacks : NULL, 0, logging);
}

static void release(void *one) { fmi2FreeInstance(one); }
static int reset(void *one) { return fmi2Reset(one); }
static int enter(void *one) { return fmi2EnterInitializationMode(one); }
static int enter_at_zero(void *one) { return enter(one); }
static int leave(void *one) { return fmi2ExitInitializationMode(one); }
static int terminate(void *one) { return fmi2Terminate(one); }
static int step(void *one, double time, double length) { return fmi2DoStep(one, time, length, 0); }
static int get_state(void *one, void **state) { return fmi2GetFMUstate(one, state); }
static int set_state(void *one, void *state) { return fmi2SetFMUstate(one, state); }
static int free_state(void *one, void **state) { return fmi2FreeFMUstate(one, state); }
static int state_size(void *one, void *state, size_t *size) { return fmi2SerializedFMUstateSize(one, state, size); }
static int to_bytes(void *one, void *state, char *bytes, size_t size) { return fmi2SerializeFMUstate(one, state, bytes, size); }

static int from_bytes(void *one, const char *bytes, size_t size, void **state)
{
    return fmi2DeSerializeFMUstate(one, bytes, size, state);
}

static double reached(void *one, const Fmu *f)
{
    double time = 0.0;
    (void)f;
    fmi2GetRealStatus(one, 2, &time);
    return time;
}

static void ask_or_tell(void *one, const Fmu *f)
{
    Reference vr[MOST], more[MOST];
    double value[MOST], product[MOST];
    int integer[MOST], order[MOST];
    const char *text[MOST];
    size_t n = any(MOST), m = any(MOST);
    for (size_t k = 0; k < MOST; k++) {
        vr[k] = k && any(4) ? vr[k - 1] + 1 : reference(f->reals + f->others);
        more[k] = reference(f->reals + f->others), value[k] = number();
        integer[k] = any(3) ? (int)any(6) : (int)any(UINT32_MAX), order[k] = (int)any(6) - 1;
    }
    switch (any(8)) {
    case 0: count(fmi2SetReal(one, vr, n, value)); break;
    case 1: count(fmi2GetReal(one, vr, n, value)); break;
    case 2: count(any(4) ? fmi2GetInteger(one, vr, n, integer) : fmi2SetInteger(one, vr, n, integer)); break;
    case 3: count(fmi2GetBoolean(one, vr, n, integer)); break;
    case 4: count(fmi2GetString(one, vr, n, text)); break;
    case 5: count(fmi2SetRealInputDerivatives(one, vr, n, order, value)); break;
    case 6: count(fmi2GetDirectionalDerivative(one, more, m, vr, n, value, product)); break;
    case 7: count(fmi2GetRealStatus(one, (int)any(5), value)); break;
    }
}
