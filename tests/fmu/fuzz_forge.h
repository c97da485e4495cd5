/* States altered at random whose sums are computed anew, so that they are valid: the model has to check what they contain.
   Each one is rejected with a sentence, or the FMU runs with it. */

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
static long forged_states(const Fmu *f, long tries, long *damaged)
{
    Sums of_file;                       /* the end of the token */
    if (sscanf(f->token + strlen(f->token) - 33, "%16" SCNx64 "%16" SCNx64, &of_file.first, &of_file.second) != 2)
        exit(1);
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
