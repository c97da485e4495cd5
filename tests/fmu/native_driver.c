/* Drives a lubrication FMU on any system and prints a digest of its forces after each step; compiled with -DNUMBERS a body
   FMU, and prints a sum of its film thickness.

   driver LIBRARY LOCATION GUID CELLS STEPS FILM_REFERENCE VELOCITY_REFERENCE FORCE_REFERENCE
   Film and velocity, or forces, are made of products and sums alone, so that they have the same bits everywhere. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

typedef unsigned int Reference;

static void *library;

static void *function(const char *name)
{
    void *found = FIND(library, name);
    if (!found)
        fprintf(stderr, "no %s\n", name), exit(1);
    return found;
}

static void need(int status, const char *what)
{
    if (status)
        fprintf(stderr, "%s answered %d\n", what, status), exit(1);
}

int main(int count, char **argument)
{
    (void)count;
    library = OPEN(argument[1]);
    if (!library)
        fprintf(stderr, "%s does not load\n", argument[1]), exit(1);
    int cells = atoi(argument[4]), steps = atoi(argument[5]);
    Reference first[3];
    for (int k = 0; k < 3; k++)
        first[k] = (Reference)atoi(argument[6 + k]);
    void *(*instantiate)(const char *, int, const char *, const char *, void *, int, int) = function("fmi2Instantiate");
    int (*set)(void *, Reference *, size_t, double *) = function("fmi2SetReal");
    int (*get)(void *, Reference *, size_t, double *) = function("fmi2GetReal");
    int (*step)(void *, double, double, int) = function("fmi2DoStep");
    int (*enter)(void *) = function("fmi2EnterInitializationMode"), (*leave)(void *) = function("fmi2ExitInitializationMode");
    void *one = instantiate("one", 1, argument[3], argument[2], NULL, 0, 0);
    if (!one)
        fprintf(stderr, "no instance\n"), exit(1);
    double *value = malloc(sizeof(double) * (size_t)cells);
    Reference *reference = malloc(sizeof(Reference) * (size_t)cells);
    need(enter(one), "enter");
    for (int n = 0; n <= steps; n++) {
        double swing = 1.0, phase = (n % 90) / 45.0 - 1.0;
        swing = phase * (1.0 - phase * phase);
        for (int which = 0; which < 2; which++) {
            for (int k = 0; k < cells; k++) {
                double place = (double)k / cells;
                reference[k] = first[which] + (Reference)k;
#ifdef NUMBERS
                value[k] = which ? 0.1 * swing : 20.0 * place * (1.0 - place) * (1.0 + 2.0 * swing);
#else
                value[k] = which ? 16.0 * swing : 8e-6 + 1.2e-5 * place * (1.0 - place) * (1.0 + 2.0 * swing);
#endif
            }
            need(set(one, reference, (size_t)cells, value), "set");
        }
        need(n ? step(one, (n - 1) * 5e-5, 5e-5, 0) : leave(one), "step");
        if (!n)
            continue;
        for (int k = 0; k < cells; k++)
            reference[k] = first[2] + (Reference)k;
        need(get(one, reference, (size_t)cells, value), "get");
#ifdef NUMBERS
        double sum = 0.0;
        for (int k = 0; k < cells; k++)
            sum += (1.0 + (double)k / cells) * value[k];
        printf("%d %.17g\n", n, sum);
#else
        unsigned long long digest = 14695981039346656037ULL, bits;
        for (int k = 0; k < cells; k++) {
            memcpy(&bits, value + k, sizeof bits);
            digest = (digest ^ bits) * 1099511628211ULL;
        }
        printf("%d %016llx\n", n, digest);
#endif
    }
    return 0;
}
