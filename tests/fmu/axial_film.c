/* The template's film model as an FMU without Python: same variables, same references, same arithmetic in C.
   Compiled with -DN=cells around -DM=cells along. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double viscosity, radius, length;                       /* Reals in the order of the model description */
    double film[N][M], speed[N][M], force[N][M], friction[N][M], pressure[N][M], thinnest, highest;
    double before[N][M];                                    /* film at the end of the last step */
} Film;

static double *real(Film *f) { return &f->viscosity; }

static int advance(Film *f, double step)
{
    double dy = f->length / M, area = dy * 2 * M_PI * f->radius / N;
    f->thinnest = INFINITY, f->highest = 0;
    for (int i = 0; i < N; i++) {
        double wedge[M], resistance[M], squeeze = 0, above = 0, below = 0, p = 0;
        for (int j = 0; j < M; j++) {
            if (!isfinite(f->film[i][j]) || !isfinite(f->speed[i][j]) || !(step > 0))
                return 2;
            double h = fmax(f->film[i][j], 1e-6);
            squeeze += (f->film[i][j] - f->before[i][j]) / step * dy;
            resistance[j] = 12 * f->viscosity / (h * h * h);
            wedge[j] = squeeze - f->speed[i][j] * h / 2;
            above += resistance[j] * wedge[j], below += resistance[j];
            f->friction[i][j] = -f->viscosity * f->speed[i][j] / h * area;
            f->thinnest = fmin(f->thinnest, f->film[i][j]);
        }
        for (int j = 0; j < M; j++) {
            double rise = resistance[j] * (wedge[j] - above / below) * dy;
            f->pressure[i][j] = fmax(p + rise / 2, 0);
            p += rise;
            f->force[i][j] = f->pressure[i][j] * area;
            f->highest = fmax(f->highest, f->pressure[i][j]);
        }
    }
    memcpy(f->before, f->film, sizeof f->film);
    return 0;
}

typedef unsigned Reference;
void *fmi2Instantiate(const char *a, int b, const char *c, const char *d, const void *e, int g, int h)
{
    (void)a, (void)b, (void)c, (void)d, (void)e, (void)g, (void)h;
    Film *f = calloc(1, sizeof *f);
    f->viscosity = 0.012, f->radius = 28.25e-3, f->length = 27e-3;
    for (double *h = f->film[0]; h < f->speed[0]; h++)
        *h = 2e-5;
    return f;
}
int fmi2SetDebugLogging(void *f) { (void)f; return 0; }
int fmi2ExitInitializationMode(Film *f) { memcpy(f->before, f->film, sizeof f->film); return advance(f, 1.0); }
int fmi2Reset(void *f) { (void)f; return 3; }
int fmi2DoStep(Film *f, double time, double step, int last) { (void)time, (void)last; return advance(f, step); }
int fmi2SetReal(Film *f, const Reference *r, size_t n, const double *v) { for (size_t k = 0; k < n; k++) real(f)[r[k]] = v[k]; return 0; }
int fmi2GetReal(Film *f, const Reference *r, size_t n, double *v) { for (size_t k = 0; k < n; k++) v[k] = real(f)[r[k]]; return 0; }
int fmi2SetInteger(void *f) { (void)f; return 3; }
int fmi2GetInteger(void *f, const Reference *r, size_t n, int *v)
{
    (void)f;
    for (size_t k = 0; k < n; k++)
        v[k] = (int[]){N, M, 1}[r[k]];
    return 0;
}
int fmi2SetBoolean(void *f) { (void)f; return 3; }
int fmi2GetBoolean(void *f) { (void)f; return 3; }
int fmi2SetString(void *f) { (void)f; return 3; }
int fmi2GetString(void *f) { (void)f; return 3; }
int fmi2GetFMUstate(Film *f, void **s) { *s = *s ? *s : malloc(sizeof *f); memcpy(*s, f, sizeof *f); return 0; }
int fmi2SetFMUstate(Film *f, void *s) { memcpy(f, s, sizeof *f); return 0; }
int fmi2FreeFMUstate(void *f, void **s) { (void)f; free(*s); *s = NULL; return 0; }
int fmi2SerializedFMUstateSize(void *f, void *s, size_t *n) { (void)f, (void)s; *n = sizeof(Film); return 0; }
int fmi2SerializeFMUstate(void *f, void *s, char *b, size_t n) { (void)f; memcpy(b, s, n); return 0; }
int fmi2DeSerializeFMUstate(void *f, const char *b, size_t n, void **s) { (void)f; *s = malloc(n); memcpy(*s, b, n); return 0; }
int fmi2GetDirectionalDerivative(void *f) { (void)f; return 3; }
int fmi2SetRealInputDerivatives(void *f) { (void)f; return 3; }
int fmi2GetRealOutputDerivatives(void *f) { (void)f; return 3; }
int fmi2CancelStep(void *f) { (void)f; return 3; }
int fmi2GetStatus(void *f) { (void)f; return 3; }
int fmi2GetRealStatus(void *f) { (void)f; return 3; }
int fmi2GetIntegerStatus(void *f) { (void)f; return 3; }
int fmi2GetBooleanStatus(void *f) { (void)f; return 3; }
int fmi2GetStringStatus(void *f) { (void)f; return 3; }
