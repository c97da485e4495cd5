/* Files and states altered at random whose sums are computed anew, so that they are valid: native.c has to check what
   they contain. Each one is rejected with a sentence, or the FMU runs with it. */

typedef struct { uint64_t first, second; } Sums;

static Sums sums_of(const uint64_t *word, size_t count, Sums sums)
{
    for (size_t k = 0; k < count; k++) {
        uint64_t mixed = word[k];
        for (int round = 0; round < 2; round++) {
            mixed = (mixed ^ mixed >> 32) * 0x9e3779b97f4a7c15ull;
            mixed ^= mixed >> 29;
        }
        sums.first += mixed;
        sums.second += sums.first;
    }
    return sums;
}

/* Whether a word may be a count or a position: a whole number, as a real or an integer. */
static bool is_whole(uint64_t word)
{
    double real;
    memcpy(&real, &word, sizeof real);
    return (word > 0 && word < 1u << 24) || (real >= 1.0 && real < 1e7 && real == floor(real));
}

/* Put another word in one to three places, half of which hold counts and positions. */
static void alter(uint64_t *word, size_t words)
{
    for (uint32_t n = 1 + any(3); n; n--) {
        size_t at = any((uint32_t)words);
        for (int tries = any(2) ? 99 : 0; tries && !is_whole(word[at]); tries--)
            at = any((uint32_t)words);
        double real = number();
        if (any(2))
            memcpy(&real, word + at, sizeof real);
        real += (double)any(3) - 1.0;
        switch (any(5)) {
        case 0: word[at] ^= 1ull << any(64); break;
        case 1: word[at] = word[any((uint32_t)words)]; break;
        case 2: word[at] += any(2) ? 1 : -1ull; break;
        default: memcpy(word + at, &real, sizeof real);
        }
    }
}

static void use(void *one, const Fmu *f)
{
    for (int k = 0; k < 4; k++) {
        count(step(one, reached(one, f), 1e-5));
        ask_or_tell(one, f);
        ask_or_tell(one, f);
    }
}

/* What an attempt left: whether it was rejected, which needs a sentence. */
static bool is_rejected(int status, long words_before)
{
    if (status && words == words_before)
        fprintf(stderr, "rejected without a sentence\n"), exit(1);
    return status != 0;
}

/* Words of a saved state: before its sums, of its sums, and at its end. A part of it, packed: see native.c. */
enum { HEAD = 5, SUMS = 2, END = 3, LITERALS = 20, LENGTH = 20, MOST_LITERALS = (1 << LITERALS) - 1 };

static size_t unpack(const uint64_t *packed, const uint64_t *end, uint64_t *out)
{
    uint64_t *first = out;
    while (packed < end) {
        uint64_t control = *packed++, literals = control & MOST_LITERALS, distance = control >> (LITERALS + LENGTH);
        memcpy(out, packed, literals * sizeof *out);
        out += literals, packed += literals;
        for (uint64_t length = control >> LITERALS & MOST_LITERALS; length; length--, out++)
            *out = *(out - distance);
    }
    return (size_t)(out - first);
}

/* Run with altered states; return how many were rejected. Add to `damaged` how many copies were rejected of which a bit is
   another one, and the sums are not. */
static long forged_states(const Fmu *f, Sums of_file, long tries, long *damaged)
{
    void *one = made(f, f->resources, true, false), *saved = NULL, *forged;
    size_t size;
    count(enter_at_zero(one)), count(leave(one)), count(step(one, 0.0, 1e-5)), count(step(one, 1e-5, 1e-5));
    if (get_state(one, &saved) || state_size(one, saved, &size))
        exit(1);
    uint64_t *bytes = malloc(size);
    if (to_bytes(one, saved, (char *)bytes, size))
        exit(1);
    size_t words_at_most = (size_t)(bytes[1] + bytes[2] + bytes[3]);
    uint64_t *whole = malloc(words_at_most * sizeof *whole), *altered = malloc((words_at_most + 99) * sizeof *altered);
    uint64_t *body = altered + HEAD + SUMS + 1;
    size_t length = unpack(bytes + HEAD + SUMS, bytes + size / sizeof *bytes - END, whole);
    long rejected = 0;
    for (long k = 0; k < tries; k++) {
        memcpy(altered, bytes, HEAD * sizeof *bytes);
        memcpy(body, whole, length * sizeof *body);
        body[-1] = length;              /* all of them are literals */
        size_t words_altered = any(4) ? (size_t)bytes[3] : length;     /* mostly of the memory, which is last */
        alter(body + length - words_altered, words_altered);
        Sums sums = sums_of(body - 1, length + 1, sums_of(altered, HEAD, of_file));
        memcpy(altered + HEAD, &sums, sizeof sums);
        memcpy(body + length, bytes + size / sizeof *bytes - END, END * sizeof *body);
        forged = NULL;
        long before = words;
        size_t at = any((uint32_t)size);
        ((char *)bytes)[at] ^= 1;
        *damaged += is_rejected(from_bytes(one, (char *)bytes, size, &forged), before);
        ((char *)bytes)[at] ^= 1;
        before = words;
        int status = from_bytes(one, (char *)altered, (HEAD + SUMS + 1 + length + END) * sizeof *altered, &forged);
        if (status)
            fprintf(stderr, "the sums of a state do not fit\n"), exit(1);
        rejected += is_rejected(set_state(one, forged), before);
        use(one, f);
        free_state(one, &forged);
        if (set_state(one, saved) || step(one, reached(one, f), 1e-5))
            fprintf(stderr, "no step after a forged state\n"), exit(1);
    }
    release(one), free(bytes), free(whole), free(altered);
    return rejected;
}

/* Words of the file before its given part, which holds the model. */
static size_t before_given(const uint64_t *head)
{
    const uint64_t first_integer = head[1], integers = head[2], blocks = head[3] + head[4], variables = head[5];
    return 1 + 9 + 3 * blocks + (8 + 2) * variables + first_integer + integers;
}

/* Run with altered files resources/slave.bin; return how many were rejected. */
static long forged_files(const Fmu *f, const uint64_t *whole, size_t size, const char *scratch, long tries)
{
    char token[200], path[4096];
    size_t length = size / sizeof *whole, sums_at = strlen(f->token) - 33;
    uint64_t *altered = malloc(size);
    const size_t given = before_given(whole + 1), texts = given + whole[1 + 6];
    Fmu own = *f;
    long rejected = 0;
    own.token = strcpy(token, f->token);
    for (long k = 0; k < tries; k++) {
        memcpy(altered, whole, size);
        switch (any(4)) {
        case 0: alter(altered + 1, given - 1); break;
        case 1: alter(altered + texts, length - texts); break;
        default: alter(altered + given, texts - given);
        }
        Sums sums = sums_of(altered + 1, length - 1, (Sums){0, 0});
        snprintf(token + sums_at, 40, "%016llx%016llx}", (unsigned long long)sums.first, (unsigned long long)sums.second);
        snprintf(path, sizeof path, "%s/token.txt", scratch);
        write_file(path, token, strlen(token));
        snprintf(path, sizeof path, "%s/slave.bin", scratch);
        write_file(path, altered, size);
        long before = words;
        void *one = made(&own, scratch, true, false);
        if (one) {
            int status = enter_at_zero(one);
            rejected += is_rejected(status ? status : leave(one), before);
            use(one, f);
            release(one);
        } else
            rejected += is_rejected(1, before);
    }
    free(altered);
    return rejected;
}
