/* A slave of machine code for front.h: its variables, its memory, its states. One file of the FMU describes it,
   resources/slave.bin, which model_file.py writes. */

#include "front.h"
#include "native.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char MARK[8] = "PCNATIV5";      /* the last digit is the version of the file */

enum { FAULT_NUMBERS = 6, MOST_FAULTS = 24, LONGEST = 16384, PARTS_FROM = 4 /* as in master/fmi/block.py */ };

/* Description of a variable in the file: numbers, then ranges; texts are separate. */
typedef struct { int64_t type, offset, size, causality, extent[3], choices; } Row;
typedef struct { double low, high; } Range;
typedef struct { const char *name, *unit; const char **choice; } Words;

typedef struct { uint64_t first, second; } Sums;

typedef struct { int64_t reals, first_integer, integers, seeds, products, variables, given, coordinates, faults, texts; } Head;

typedef struct {
    char *file;                         /* its content, into which the following pointers point */
    const Head *head;
    const Block *block;                 /* seeds, then products */
    const Row *row;
    const Range *range;
    const double *start_real, *given;
    const int64_t *start_integer;
    Words *words;
    const char **choices, **fault, *refusal;
    int64_t lengths[4], first_state, states, first_fault, first_coordinate, coordinates;
    double *real;                       /* variables, then seeds and products */
    int64_t *integer;
    double *memory;
    double *shown, *started;            /* variables of the last published outputs; of the last start */
    int64_t *shown_integer, *started_integer;
    int is_shown, has_state, was_started;
    int was_saved;                      /* whether a state was saved or restored since the last step */
    uint64_t remarked;                  /* logged warnings, one bit each */
    char refused[LONGEST];              /* why there is no state, empty if there is one */
    Sums sums;                          /* of the file */
} Native;

/* ---- the file ----------------------------------------------------------------------------------------------------- */

static char *read_whole(const char *path, size_t *size)
{
    FILE *file = front_open(path);
    if (!file)
        return NULL;
    char *bytes = NULL;
    long length = fseek(file, 0, SEEK_END) ? -1 : ftell(file);
    if (length > 0 && !fseek(file, 0, SEEK_SET) && (bytes = malloc((size_t)length)) != NULL
        && fread(bytes, 1, (size_t)length, file) != (size_t)length) {
        free(bytes);
        bytes = NULL;
    }
    *size = (size_t)length;
    fclose(file);
    return bytes;
}

/* Return `count` items of a size from the file and advance the cursor. */
static const void *take(const char **cursor, int64_t count, size_t size)
{
    const char *at = *cursor;
    *cursor += (size_t)count * size;
    return at;
}

static const char *take_text(const char **cursor) { return take(cursor, (int64_t)strlen(*cursor) + 1, 1); }

/* Mix the bits of a word. Sums of unmixed words do not notice two flipped signs. */
static uint64_t mixed(uint64_t word)
{
    for (int round = 0; round < 2; round++) {
        word = (word ^ word >> 32) * 0x9e3779b97f4a7c15ull;
        word ^= word >> 29;
    }
    return word;
}

/* Continue the sum of mixed words, and that of the running sums, which detect truncated, changed and moved content. */
static Sums sums_of(const char *words, size_t size, Sums sums)
{
    for (uint64_t word; size >= sizeof word; words += sizeof word, size -= sizeof word) {
        memcpy(&word, words, sizeof word);
        sums.first += mixed(word);
        sums.second += sums.first;
    }
    return sums;
}

/* Return whether the host's token, which the model description contains, ends with the sums of the content. */
static int is_whole(Sums sums, const char *token, size_t size)
{
    char told[40];
    size_t length = (size_t)snprintf(told, sizeof told, "%016llx%016llx}", (unsigned long long)sums.first,
                                     (unsigned long long)sums.second);
    return size % sizeof(uint64_t) == 0 && strlen(token) > length && !strcmp(token + strlen(token) - length, told);
}

/* Set the pointers into the file; return NULL or the fault. A file with the right sums is one of `model_file.slave_file`. */
static const char *lay_out(Native *N, const char *path, const char *token)
{
    const char *scarce = "asks for more memory than there is";
    size_t size = 0;
    N->file = read_whole(path, &size);
    if (!N->file)
        return "is not there, or is empty";
    if (size < sizeof MARK || memcmp(N->file, MARK, sizeof MARK))
        return "is damaged, or of another version of piston-cosim";
    const char *cursor = N->file + sizeof MARK;
    N->sums = sums_of(cursor, size - sizeof MARK, (Sums){0, 0});
    if (!is_whole(N->sums, token, size))
        return "is cut short or damaged";
    const Head *h = N->head = take(&cursor, 1, sizeof *h);
    N->block = take(&cursor, h->seeds + h->products, sizeof *N->block);
    N->row = take(&cursor, h->variables, sizeof(Row));
    N->range = take(&cursor, h->variables, sizeof(Range));
    N->start_real = take(&cursor, h->first_integer, sizeof(double));
    N->start_integer = take(&cursor, h->integers, sizeof(int64_t));
    N->given = take(&cursor, h->given, sizeof(double));
    N->words = calloc((size_t)h->variables + 1, sizeof *N->words);
    N->choices = calloc((size_t)h->texts + 1, sizeof *N->choices);
    N->fault = calloc((size_t)h->faults + 1, sizeof *N->fault);
    if (!N->words || !N->choices || !N->fault)
        return scarce;
    const char **choice = N->choices;
    for (int64_t k = 0; k < h->variables; k++) {
        N->words[k].name = take_text(&cursor);
        N->words[k].unit = take_text(&cursor);
        N->words[k].choice = choice;
        for (int64_t c = 0; c < N->row[k].choices; c++)
            *choice++ = take_text(&cursor);
    }
    for (int64_t k = 0; k < h->faults; k++)
        N->fault[k] = take_text(&cursor);
    N->refusal = take_text(&cursor);
    return NULL;
}

/* ---- sentences ---------------------------------------------------------------------------------------------------- */

static void append(char *text, const char *more)
{
    size_t length = strlen(text);
    snprintf(text + length, LONGEST - length, "%s", more);
}

/* Format a number as Python's {:g}, independent of the host's locale. */
static void append_number(char *text, double number)
{
    char written[40];
    if (isnan(number))
        snprintf(written, sizeof written, "nan");
    else
        snprintf(written, sizeof written, "%g", number);
    for (char *c = written; *c; c++)
        if (*c == ',')
            *c = '.';
    append(text, written);
}

static void append_value(char *text, double number, const char *unit)
{
    append_number(text, number);
    if (strcmp(unit, "1")) {
        append(text, " ");
        append(text, unit);
    }
}

/* Replace {i} {j} {a} {b} {c} in a sentence by the numbers of a fault. */
static void append_fault(char *text, const char *sentence, const double *fault)
{
    for (char one[2] = {0}; *sentence; sentence++) {
        const char *known = "ijabc", *which = sentence[0] == '{' && sentence[1] && sentence[2] == '}' ?
            strchr(known, sentence[1]) : NULL;
        if (which && *which) {
            append_number(text, fault[1 + (which - known)]);
            sentence += 2;
        } else {
            one[0] = *sentence;
            append(text, one);
        }
    }
}

static const char *sentence_of(Native *N, double number)
{
    const char *sentence = number >= 0.0 && number < (double)N->head->faults ? N->fault[(int64_t)number] : "";
    return *sentence ? sentence : "unknown fault";
}

/* Append all faults that an entry has noted. */
static void append_faults(Native *N, char *text, const char *between)
{
    const double *fault = N->memory + N->first_fault;
    for (int64_t k = 0; k < MOST_FAULTS && (double)k < fault[0]; k++) {
        const double *one = fault + 1 + FAULT_NUMBERS * k;
        if (k)
            append(text, between);
        append_fault(text, sentence_of(N, one[0]), one);
    }
}

/* ---- ranges ------------------------------------------------------------------------------------------------------- */

/* name, or name[i,j] with the last index fastest */
static void append_element(Native *N, char *text, int64_t variable, int64_t element)
{
    const Row *v = N->row + variable;
    char index[80];
    append(text, N->words[variable].name);
    if (v->extent[1] > 0)
        snprintf(index, sizeof index, "[%lld,%lld]", (long long)(element / v->extent[1] + 1),
                 (long long)(element % v->extent[1] + 1));
    else if (v->extent[0] > 0)
        snprintf(index, sizeof index, "[%lld]", (long long)(element + 1));
    else
        return;
    append(text, index);
}

/* Append a sentence if a choice has an invalid number. */
static int choice_fault(Native *N, int64_t variable, char *text)
{
    const Row *v = N->row + variable;
    const Words *w = N->words + variable;
    int64_t number = N->integer[v->offset];
    if (number >= 1 && number <= v->choices)
        return 0;
    char written[32];
    append(text, *text ? "\n" : "");
    append(text, w->name);
    append(text, ": expected ");
    const char *between = "";
    for (int64_t c = 0; c < v->choices; c++) {
        snprintf(written, sizeof written, "%s%lld ", between, (long long)(c + 1));
        append(text, written);
        append(text, w->choice[c]);
        between = ", ";
    }
    snprintf(written, sizeof written, ", got %lld", (long long)number);
    append(text, written);
    return 1;
}

/* Append a sentence for the first element of a number that is not finite or out of range. */
static int number_fault(Native *N, int64_t variable, char *text)
{
    const Row *v = N->row + variable;
    const Range *r = N->range + variable;
    const char *unit = N->words[variable].unit;
    for (int64_t k = 0; k < v->size; k++) {
        double x = v->type == REAL ? N->real[v->offset + k] : (double)N->integer[v->offset + k];
        if (x >= r->low && x <= r->high && isfinite(x))
            continue;
        append(text, *text ? "\n" : "");
        if (!isfinite(x)) {
            append_element(N, text, variable, k);
            append(text, ": expected a finite value, got ");
            append_value(text, x, unit);
            return 1;
        }
        append(text, N->words[variable].name);
        append(text, ": expected ");
        append_number(text, r->low);
        append(text, " to ");
        append_value(text, r->high, unit);
        append(text, ", got ");
        append_value(text, x, unit);
        return 1;
    }
    return 0;
}

/* Append a sentence for every variable, or every one that may change between steps, that is out of range; return their
   number. */
static int range_faults(Native *N, int only_changing, char *text)
{
    int count = 0;
    for (int64_t k = 0; k < N->head->variables; k++) {
        const Row *v = N->row + k;
        int changes = v->causality == INPUT || v->causality == TUNABLE;
        if (v->causality == OUTPUT || v->type == TEXT || (only_changing && !changes))
            continue;
        count += v->type == CHOICE ? choice_fault(N, k, text) : number_fault(N, k, text);
    }
    return count;
}

/* ---- calls -------------------------------------------------------------------------------------------------------- */

/* Run an entry and append its faults to `text`; return whether it succeeded. */
static int run(Native *N, Entering *entry, double step, double time, char *text, const char *between)
{
    double numbers[4] = {step, time, N->was_saved, 0.0};
    N->memory[N->first_fault] = N->memory[N->first_fault + 1] = 0.0;
    if (pool_run(entry, N->real, N->integer, N->memory, numbers, N->lengths)) {
        append(text, "there is not enough memory for a step");
        return 0;
    }
    append_faults(N, text, between);
    return N->memory[N->first_fault] == 0.0;
}

static size_t real_bytes(Native *N) { return (size_t)N->head->reals * sizeof(double); }
static size_t integer_bytes(Native *N) { return (size_t)N->head->integers * sizeof(int64_t); }

static void remember(Native *N, double *real, int64_t *integer)
{
    memcpy(real, N->real, real_bytes(N));
    memcpy(integer, N->integer, integer_bytes(N));
}

/* Log the warning of a successful start or step once. It is a negative number at the first fault. */
static void log_remark(Instance *I)
{
    Native *N = I->slave;
    double remark = N->memory[N->first_fault + 1];
    int there = remark < 0.0 && remark >= -(double)N->head->faults;
    uint64_t bit = there ? 1ull << ((int64_t)(-1.0 - remark) & 63) : 0;
    if (!there || N->remarked & bit)
        return;
    N->remarked |= bit;
    front_log(I, WARNING, "%s", sentence_of(N, -1.0 - remark));
}

/* Compute the start state and publish its outputs. A fault is logged, and every later step is rejected. */
static int checked_start(Instance *I)
{
    Native *N = I->slave;
    char text[LONGEST] = "";
    remember(N, N->started, N->started_integer);
    N->was_started = 1;
    N->has_state = !range_faults(N, 0, text) && run(N, native_start, 0.0, 0.0, text, "\n");
    snprintf(N->refused, sizeof N->refused, "%s", text);
    if (N->has_state) {
        log_remark(I);
        return OK;
    }
    front_log(I, ERROR, "%s", text);
    return ERROR;
}

/* Return whether the parameters are those of the last start. */
static int same_parameters(Native *N)
{
    for (int64_t k = 0; k < N->head->variables; k++) {
        const Row *v = N->row + k;
        size_t size = (size_t)v->size;
        if (v->type == CHOICE ? N->integer[v->offset] != N->started_integer[v->offset] :
            v->causality == PARAMETER && v->type == REAL
                && memcmp(N->real + v->offset, N->started + v->offset, size * sizeof(double)))
            return 0;
    }
    return 1;
}

int slave_initialise(Instance *I, int enters)
{
    Native *N = I->slave;
    N->is_shown = 0;
    return enters ? OK : checked_start(I);
}

/* In Initialization Mode, let outputs follow the inputs if these are valid. */
int slave_show(Instance *I)
{
    Native *N = I->slave;
    char text[LONGEST] = "";
    if ((N->is_shown && !memcmp(N->shown, N->real, real_bytes(N))
                             && !memcmp(N->shown_integer, N->integer, integer_bytes(N))))
        return OK;
    if (!range_faults(N, 0, text))
        run(N, native_start, 0.0, 0.0, text, "\n");
    remember(N, N->shown, N->shown_integer);
    N->is_shown = 1;
    return OK;
}

int slave_step(Instance *I, double time, double step)
{
    Native *N = I->slave;
    char text[LONGEST] = "";
    if (!N->has_state) {
        front_log(I, DISCARD, "not initialised: %s", *N->refused ? N->refused : "no start was asked for");
        return DISCARD;
    }
    if (!(step > 0.0 && isfinite(step))) {
        append(text, "step size = ");
        append_number(text, step);
        append(text, " s: must be positive and finite");
    } else if (!range_faults(N, 1, text)) {
        char refused[LONGEST] = "";
        double when[FAULT_NUMBERS] = {0.0, 0.0, 0.0, time + step, 0.0, 0.0};
        int is_done = run(N, native_advance, step, time, refused, "; ");
        N->was_saved = 0;
        if (is_done) {
            log_remark(I);
            return OK;
        }
        append_fault(text, N->refusal, when);
        append(text, refused);
    }
    front_log(I, DISCARD, "%s", text);
    return DISCARD;
}

int slave_products(Instance *I)
{
    Native *N = I->slave;
    char text[LONGEST] = "";
    double task = I->task, more = I->more;
    I->task = I->more = 0.0;
    if (N->has_state && run(N, native_tangent, task, more, text, "; "))
        return OK;
    front_log(I, ERROR, "%s", *text ? text : "not initialised");
    return ERROR;
}

/* Let the next derivative do a task on the coordinates of the model (`WHOLE` in master/fmi/native_parts.py). Return their
   number, and where they are. */
__attribute__((visibility("default")))
int64_t native_task(Instance *I, double task, double more, double **coordinates)
{
    Native *N = I->slave;
    I->task = task, I->more = more;
    *coordinates = N->memory + N->first_coordinate;
    return N->coordinates;
}

int slave_terminate(Instance *I) { (void)I; return OK; }

int slave_set_text(Instance *I, Reference reference, const char *text) { (void)I, (void)reference, (void)text; return OK; }

int slave_get_texts(Instance *I, const Reference *reference, size_t count, const char **texts)
{
    (void)I, (void)reference, (void)texts;
    return count ? ERROR : OK;
}

/* ---- instances ---------------------------------------------------------------------------------------------------- */

/* Set variables to their start values, without a state. */
static void begin(Instance *I)
{
    Native *N = I->slave;
    memcpy(N->real, N->start_real, (size_t)N->head->first_integer * sizeof(double));
    memcpy(N->integer, N->start_integer, integer_bytes(N));
    memset(N->memory, 0, (size_t)N->lengths[2] * sizeof(double));
    memcpy(N->memory, N->given, (size_t)N->head->given * sizeof(double));
    N->is_shown = N->has_state = N->was_started = 0;
    N->refused[0] = 0;
}

/* Return why the slave of these resources cannot be created; NULL if it can. */
static const char *make(Instance *I)
{
    char path[8192];
    Native *N = I->slave = calloc(1, sizeof *N);
    snprintf(path, sizeof path, "%s/slave.bin", I->resources);
    if (!N)
        return "asks for more memory than there is";
    pool_open();
    const char *lacking = lay_out(N, path, I->token);
    if (lacking)
        return lacking;
    const Head *h = N->head;
    const double *sizes = N->given;         /* `memory_of` in block.py */
    N->first_state = (int64_t)sizes[1], N->states = (int64_t)sizes[2], N->first_fault = (int64_t)sizes[3];
    if (h->coordinates >= 0) {              /* a part of the memory */
        const double *ends = sizes + PARTS_FROM + h->coordinates;
        N->first_coordinate = (int64_t)ends[0], N->coordinates = (int64_t)(ends[1] - ends[0]);
    }
    N->lengths[0] = h->first_integer, N->lengths[1] = h->integers, N->lengths[2] = (int64_t)sizes[0], N->lengths[3] = 4;
    N->memory = malloc((size_t)sizes[0] * sizeof(double));
    N->real = calloc((size_t)h->first_integer, sizeof(double));
    N->integer = calloc((size_t)h->integers + 1, sizeof(int64_t));
    N->shown = malloc(real_bytes(N));
    N->started = malloc(real_bytes(N));
    N->shown_integer = malloc(integer_bytes(N) + 1);
    N->started_integer = malloc(integer_bytes(N) + 1);
    I->variable = malloc((size_t)h->variables * sizeof(Entry));
    if (!N->memory || !N->real || !N->integer || !N->shown || !N->started || !N->shown_integer || !N->started_integer
        || !I->variable)
        return "asks for more memory than there is";
    for (int64_t k = 0; k < h->variables; k++)
        I->variable[k] = (Entry){N->row[k].type, N->row[k].offset, N->row[k].size, N->row[k].causality};
    I->real = N->real, I->integer = N->integer;
    I->reals = h->reals, I->integers = h->integers, I->strings = 0;
    I->first_integer = h->first_integer, I->first_string = h->first_integer + h->integers;
    I->seeds = h->seeds, I->products = h->products, I->variables = h->variables;
    I->seed = (Block *)N->block, I->product = (Block *)N->block + h->seeds;
    begin(I);
    return NULL;
}

int slave_create(Instance *I)
{
    const char *lacking = make(I);
    if (lacking)
        front_log(I, ERROR, "instantiate: %s/slave.bin %s", I->resources, lacking);
    return lacking ? ERROR : OK;
}

void slave_free(Instance *I)
{
    Native *N = I->slave;
    if (N) {
        void *owned[] = {N->file, N->words, N->choices, N->fault, N->real, N->integer, N->memory, N->shown, N->started,
                         N->shown_integer, N->started_integer, I->variable};
        for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
            free(owned[k]);
        pool_close();
    }
    free(N);
}

int slave_reset(Instance *I)
{
    begin(I);
    return OK;
}

/* ---- states ------------------------------------------------------------------------------------------------------- */

/* A state in memory: this head, variables, integers, the memory's state. As bytes, all after the head is packed. Numbers
   are little endian as on all supported systems, so states can be exchanged between them. The sums continue those of the
   model's file by all other words, so that a state goes with one model. */
typedef struct { char mark[8]; int64_t reals, integers, states, has_state; Sums sums; } Saved;

static size_t saved_size(Native *N)
{
    return sizeof(Saved) + real_bytes(N) + integer_bytes(N) + (size_t)N->states * sizeof(double);
}

static Saved head_of(Native *N)
{
    Saved s = {.reals = N->head->reals, .integers = N->head->integers, .states = N->states, .has_state = N->has_state};
    memcpy(s.mark, MARK, sizeof s.mark);
    return s;
}

/* Return whether a head is that of a state of this FMU. */
static int is_like(Native *N, const Saved *given)
{
    Saved own = head_of(N);
    own.has_state = given->has_state, own.sums = given->sums;
    return !memcmp(&own, given, sizeof own) && (given->has_state == 0 || given->has_state == 1);
}

/* Return whether it is a state of this FMU, and not of another grid; log it if not. */
static int is_own_state(Instance *I, const void *state)
{
    int own = is_like(I->slave, state);
    if (!own)
        front_log(I, ERROR, "expected a state of this FMU, got one of another FMU");
    return own;
}

static int no_memory(Instance *I)
{
    front_log(I, ERROR, "there is not enough memory for a state");
    return ERROR;
}

int slave_get_state(Instance *I, void **state)
{
    Native *N = I->slave;
    if (*state && !is_own_state(I, *state))
        return ERROR;
    char *at = *state = *state ? *state : malloc(saved_size(N));
    if (!at)
        return no_memory(I);
    N->was_saved = 1;
    *(Saved *)at = head_of(N);
    memcpy(at += sizeof(Saved), N->real, real_bytes(N));
    int64_t *integer = memset(at += real_bytes(N), 0, integer_bytes(N));
    for (int64_t k = 0; k < N->head->variables; k++)
        if (N->row[k].type == CHOICE)
            integer[N->row[k].offset] = N->integer[N->row[k].offset];
    memcpy(at += integer_bytes(N), N->memory + N->first_state, (size_t)N->states * sizeof(double));
    return OK;
}

/* Restore the variables of a saved state. Of the integers, only choices are restored, because the others count work. */
static void restore(Native *N, const char *at)
{
    memcpy(N->real, at, real_bytes(N));
    at += real_bytes(N);
    for (int64_t k = 0; k < N->head->variables; k++) {
        int64_t place = N->row[k].offset;
        if (N->row[k].type == CHOICE)
            memcpy(N->integer + place, at + (size_t)place * sizeof(int64_t), sizeof(int64_t));
    }
}

int slave_set_state(Instance *I, void *state)
{
    Native *N = I->slave;
    if (!is_own_state(I, state))
        return ERROR;
    const char *at = (const char *)state + sizeof(Saved);
    int has_state = (int)((Saved *)state)->has_state, status = OK;
    restore(N, at);
    N->refused[0] = 0;
    N->is_shown = 0;
    if (has_state && (!N->was_started || !N->has_state || !same_parameters(N))) {
        status = checked_start(I);
        restore(N, at);
    }
    N->has_state = has_state && status == OK;
    at += real_bytes(N) + integer_bytes(N);
    memcpy(N->memory + N->first_state, at, (size_t)N->states * sizeof(double));
    N->was_saved = 1;
    return status;
}

void slave_free_state(void *state) { free(state); }

/* ---- states as bytes ---------------------------------------------------------------------------------------------- */

/* A state repeats many words: zeros, and fields that are equal. Packed, it is a sequence of literal words, each part
   after a control word: how many they are, how many words to copy after them, and from how far back. */
enum { LITERALS = 20, LENGTH = 20, DISTANCE = 24, SHORTEST = 3, SLOTS = 16 };

/* Return the number of packed words, which are written if `out` is not NULL. `last` has 2^SLOTS places, all 0. */
static size_t pack(const uint64_t *word, size_t count, uint64_t *out, uint32_t *last)
{
    size_t written = 0, first = 0, at = 0;
    for (;;) {
        size_t length = 0, from = at;
        if (at < count) {
            uint32_t *slot = last + (mixed(word[at]) >> (64 - SLOTS));
            from = *slot;
            *slot = (uint32_t)at;
            if (from < at && at - from < 1u << DISTANCE)
                while (at + length < count && length + 1 < 1u << LENGTH && word[from + length] == word[at + length])
                    length++;
        }
        if (length < SHORTEST)
            length = 0;
        if (length || at == count || at - first + 1 == 1u << LITERALS) {
            if (out) {
                out[written] = (uint64_t)(at - first) | (uint64_t)length << LITERALS
                               | (uint64_t)(at - from) << (LITERALS + LENGTH);
                memcpy(out + written + 1, word + first, (at - first) * sizeof *word);
            }
            written += 1 + at - first;
            if (at == count)
                return written;
            first = at += length;
            if (length)
                continue;
        }
        at++;
    }
}

/* Return whether the packed words give exactly `count` words. */
static int unpack(const char *packed, size_t words, uint64_t *out, size_t count)
{
    size_t at = 0, read = 0;
    while (read < words) {
        uint64_t control;
        memcpy(&control, packed + read++ * sizeof control, sizeof control);
        size_t literals = control & ((1u << LITERALS) - 1), length = control >> LITERALS & ((1u << LENGTH) - 1);
        size_t distance = (size_t)(control >> (LITERALS + LENGTH));
        if (literals > words - read || literals > count - at)
            return 0;
        memcpy(out + at, packed + read * sizeof control, literals * sizeof control);
        at += literals, read += literals;
        if (length && (!distance || distance > at || length > count - at))
            return 0;
        for (; length; length--, at++)
            out[at] = out[at - distance];
    }
    return at == count;
}

static Sums sums_of_state(Native *N, const Saved *head, const char *packed, size_t size)
{
    return sums_of(packed, size, sums_of((const char *)head, offsetof(Saved, sums), N->sums));
}

int slave_state_to_bytes(Instance *I, void *state, char *bytes, size_t *size)
{
    Saved head;
    const char *body = (char *)state + sizeof head;
    size_t length = saved_size(I->slave) - sizeof head;
    uint32_t *last = calloc((size_t)1 << SLOTS, sizeof *last);
    uint64_t *packed = bytes && last ? malloc(2 * length) : NULL;
    int status = !is_own_state(I, state) ? ERROR : !last || (bytes && !packed) ? no_memory(I) : OK;
    if (status == OK) {
        size_t total = sizeof head + pack((const uint64_t *)body, length / sizeof *packed, packed, last) * sizeof *packed;
        if (bytes) {
            head = *(Saved *)state;
            head.sums = sums_of_state(I->slave, &head, (char *)packed, total - sizeof head);
            memcpy(bytes, &head, sizeof head);
            memcpy(bytes + sizeof head, packed, total - sizeof head);
        }
        *size = total;
    }
    free(last);
    free(packed);
    return status;
}

int slave_state_from_bytes(Instance *I, const char *bytes, size_t size, void **state)
{
    Native *N = I->slave;
    Saved given;
    size_t length = saved_size(N), packed = size - sizeof given;
    char *own = malloc(length);
    if (!own)
        return no_memory(I);
    int fits = bytes && size >= sizeof given && packed % sizeof(uint64_t) == 0;
    if (fits) {
        memcpy(&given, bytes, sizeof given);
        Sums found = sums_of_state(N, &given, bytes + sizeof given, packed);
        fits = is_like(N, &given) && !memcmp(&found, &given.sums, sizeof found)
               && unpack(bytes + sizeof given, packed / sizeof(uint64_t), (uint64_t *)(own + sizeof given),
                         (length - sizeof given) / sizeof(uint64_t));
    }
    if (!fits) {
        front_log(I, ERROR, "expected the bytes of a state of this FMU, got %zu other or damaged bytes", size);
        free(own);
        return ERROR;
    }
    memcpy(own, &given, sizeof given);
    *state = own;
    return OK;
}
