/* Linear equations of motion: entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "linear/record.h"

#include "base/cookie.h"
#include "base/error.h"
#include "linear/lapack.h"
#include "linear/spans.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "mbsr_linear_create";

mbsr_linear_opt mbsr_default_linear_opt(void)
{
    return (mbsr_linear_opt){.cookie = MBSRI_COOKIE};
}

int mbsri_pencil_start(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                       const double *u, const char *function, mbsri_arena *arena, double **y,
                       double **yp, mbsr_error *error)
{
    const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM), nu = mbsr_model_nu(m);
    double *rest = mbsri_arena_take(arena, ((size_t)nu + 1) * sizeof *rest);
    *y = mbsri_arena_take(arena, ((size_t)size + 1) * sizeof **y);
    *yp = mbsri_arena_take(arena, ((size_t)size + 1) * sizeof **yp);
    if (arena->failed)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d numbers", function, size);
    int status = mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, t, q, u ? u : rest, *y);
    if (!status) status = mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, t, *y, *yp, NULL, NULL);
    if (!status) return MBSR_OK;
    const mbsr_error *why = mbsr_data_error(d);
    return mbsri_fail(error, status, why->body, why->force, "%s: %s", function, why->text);
}

/* Modes have no unit of their own, and those of one body none in common: each counts by what moves
 * with it, M (nu x nu), or where that is nothing but for rounding by what the largest mass makes of
 * amplitudes. */
static void weigh_modes(const mbsr_model *m, mbsr_data *d, const double *M, double *mass)
{
    static const double rounding = 1e-20;
    const int nu = mbsr_model_nu(m), bodies = mbsr_model_bodies(m);
    const double length = mbsri_linear_length(m, d);
    double span[MBSRI_LINEAR_SPANS], all = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i < bodies; ++i) {
            mbsr_coordinate_kind kind[MBSRI_LINEAR_SPANS];
            int at, n;
            mbsr_body_coordinates(m, i, NULL, NULL, &at, &n);
            mbsri_linear_spans(m, i, true, length > 0.0 ? length : 1.0, span);
            mbsr_body_coordinate_kinds(m, i, NULL, kind);
            for (int k = 0; k < n; ++k) {
                const double own = M[(at + k) * (nu + 1)], square = span[k] * span[k];
                if (pass == 0)
                    all = fmax(all, own * square);
                else if (kind[k] == MBSR_COORDINATE_OTHER && all > 0.0)
                    mass[at + k] = own * square > rounding * all ? own : all / square;
            }
        }
    }
}

static int build(mbsr_linear *l, const mbsr_model *m, mbsr_data *d, double t, const double *q,
                 const double *u, const mbsr_linear_opt *opt, mbsr_error *error)
{
    double *y, *yp;
    mbsri_coordinates c;
    int status = mbsri_pencil_start(m, d, t, q, u, name, &l->arena, &y, &yp, error);
    const int at = mbsr_model_nq(m) + l->nu;
    for (int k = 0; k < l->nu && !status; ++k)
        l->info.acceleration = fmax(l->info.acceleration, fabs(yp[at + k]));
    if (!status) status = mbsri_pencil_assemble(l, &c, m, d, t, y, yp, opt, error);
    if (status) return status;
    const size_t nu = (size_t)l->nu;
    double *mass = mbsri_arena_take(&l->arena, (nu + nu * nu + 1) * sizeof *mass);
    if (!mass)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", name);
    const int rank = mbsr_total_rank(m, d);
    status = mbsr_momentum_scales(m, d, mass);
    if (!status) status = mbsr_mass_matrix(m, d, mass + nu);
    if (!status) weigh_modes(m, d, mass + nu, mass);
    const mbsr_error *why = mbsr_data_error(d);
    if (status) return mbsri_fail(error, status, why->body, why->force, "%s: %s", name, why->text);
    status = mbsri_signals_enter(l, &c, y, yp, opt, error);
    return status ? status
                  : mbsri_pencil_reduce(l, rank, mass, mass + nu, mbsr_model_rate(m), error);
}

int mbsr_linear_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                       const double *u, const mbsr_linear_opt *opt, mbsr_linear **linear,
                       mbsr_error *error)
{
    const mbsr_linear_opt standard = mbsr_default_linear_opt();
    mbsr_model_def def;
    if (linear) *linear = NULL;
    if (!opt) opt = &standard;
    if (!model || !data || !q || !linear)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          !model  ? "model"
                          : !data ? "data"
                          : !q    ? "q"
                                  : "linear");
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "%s: opt was not made by mbsr_default_linear_opt", name);
    if (mbsr_model_definition(model, &def))
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    int status = mbsri_signals_check(model, opt, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &def.allocator);
    mbsr_linear *l = mbsri_arena_take(&arena, sizeof *l);
    if (!l) {
        mbsri_arena_close(&arena);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", name);
    }
    l->arena = arena;
    l->nu = mbsr_model_nu(model);
    l->closure_rows = mbsr_model_rows(model);
    l->inputs = opt->inputs;
    l->outputs = opt->outputs;
    status = build(l, model, data, t, q, u, opt, error);
    if (status) {
        mbsr_linear_destroy(l);
        return status;
    }
    *linear = l;
    return MBSR_OK;
}

void mbsr_linear_destroy(mbsr_linear *linear)
{
    if (!linear) return;
    mbsri_arena arena = linear->arena;
    mbsri_arena_close(&arena);
}

int mbsr_linear_get_info(const mbsr_linear *linear, mbsr_linear_info *info)
{
    if (!linear || !info) return MBSR_ERR_NULL;
    *info = linear->info;
    return MBSR_OK;
}

const double *mbsr_linear_matrix(const mbsr_linear *linear, mbsr_linear_part part, int *rows,
                                 int *columns)
{
    if (!linear || part < MBSR_LINEAR_E || part >= MBSR_LINEAR_PARTS) return NULL;
    if (rows) *rows = linear->rows[part];
    if (columns) *columns = linear->columns[part];
    return linear->part[part];
}

/* ---- modes ---- */

/* s that is zero but for rounding, in a block of two of length 1e-16, is not said to be damped. */
mbsr_mode mbsri_mode_of(double real, double imaginary, double shift)
{
    const double size = hypot(real, imaginary);
    return (mbsr_mode){.real = real,
                       .imaginary = imaginary,
                       .frequency = imaginary / (2.0 * 3.14159265358979323846),
                       .damping = size > 1e-7 * shift ? -real / size : 0.0};
}

static double size_of(const mbsr_mode *mode)
{
    return hypot(mode->real, mode->imaginary);
}

/* Modes in the order of |s|, by insertion. */
static void sort(mbsr_linear *l)
{
    for (int k = 1; k < l->modes; ++k) {
        const mbsr_mode mode = l->mode[k];
        const int column = l->column[k];
        int at = k;
        for (; at > 0 && size_of(l->mode + at - 1) > size_of(&mode); --at) {
            l->mode[at] = l->mode[at - 1];
            l->column[at] = l->column[at - 1];
        }
        l->mode[at] = mode;
        l->column[at] = column;
    }
}

static int find_modes(mbsr_linear *l)
{
    const int n = l->info.states, one = 1, size = 8 * n + 10;
    const size_t square = (size_t)n * (size_t)n;
    int info = 0;
    l->vectors = mbsri_arena_take(&l->arena, (square + 1) * sizeof *l->vectors);
    l->column = mbsri_arena_take(&l->arena, ((size_t)n + 1) * sizeof *l->column);
    double *A = mbsri_arena_take(&l->arena, (square + 2 * (size_t)n + (size_t)size) * sizeof *A);
    mbsr_mode *mode = mbsri_arena_take(&l->arena, ((size_t)n + 1) * sizeof *mode);
    if (l->arena.failed) return MBSR_ERR_NO_MEMORY;
    double *re = A + square, *im = re + n, *work = im + n;
    memcpy(A, l->part[MBSR_LINEAR_AR], square * sizeof *A);
    if (n > 0)
        dgeev_("N", "V", &n, A, &n, re, im, NULL, &one, l->vectors, &n, work, &size, &info, 1, 1);
    if (info) return MBSR_NO_CONVERGENCE;
    for (int k = 0; k < n; ++k) {
        if (im[k] < 0.0) continue;
        mode[l->modes] = mbsri_mode_of(re[k], im[k], l->info.shift);
        l->column[l->modes++] = k;
    }
    l->mode = mode;
    sort(l);
    return MBSR_OK;
}

int mbsr_linear_modes(mbsr_linear *linear, mbsr_mode *modes, int *count)
{
    if (!linear || !count) return MBSR_ERR_NULL;
    const int status = linear->mode ? MBSR_OK : find_modes(linear);
    if (status) return status;
    *count = linear->modes;
    if (modes) memcpy(modes, linear->mode, (size_t)linear->modes * sizeof *modes);
    return MBSR_OK;
}

int mbsr_linear_shape(mbsr_linear *linear, int k, double *re, double *im)
{
    mbsr_linear *l = linear;
    if (!l || !re) return MBSR_ERR_NULL;
    const int status = l->mode ? MBSR_OK : find_modes(l);
    if (status) return status;
    if (k < 0 || k >= l->modes) return MBSR_ERR_VALUE;
    const int n = l->info.states;
    const bool pair = l->mode[k].imaginary > 0.0;
    const double *real = l->vectors + (size_t)l->column[k] * (size_t)n, *other = real + n;
    double largest = 0.0, a = 1.0, b = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        /* the second time divided by the largest, a + i b */
        for (int i = 0; i < l->nu; ++i) {
            double x = 0.0, y = 0.0;
            for (int j = 0; j < n; ++j) {
                x += l->shapes[(size_t)j * (size_t)l->nu + (size_t)i] * real[j];
                if (pair) y += l->shapes[(size_t)j * (size_t)l->nu + (size_t)i] * other[j];
            }
            if (pass == 0 && hypot(x, y) > largest) {
                largest = hypot(x, y);
                a = x;
                b = y;
            }
            if (pass == 0) continue;
            const double square = a * a + b * b;
            re[i] = (x * a + y * b) / square;
            if (im) im[i] = (y * a - x * b) / square;
        }
    }
    return MBSR_OK;
}

int mbsr_linear_response(mbsr_linear *linear, double frequency, double *re, double *im)
{
    const mbsr_linear *l = linear;
    if (!l || !re || !im) return MBSR_ERR_NULL;
    if (!isfinite(frequency)) return MBSR_NOT_FINITE;
    const int n = l->info.states, inputs = l->inputs, outputs = l->outputs;
    const size_t square = (size_t)n * (size_t)n, sides = (size_t)n * (size_t)inputs;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &l->arena.allocator);
    double *A = mbsri_arena_take(&arena, 2 * (square + 1) * sizeof *A),
           *b = mbsri_arena_take(&arena, 2 * (sides + 1) * sizeof *b);
    int *pivots = mbsri_arena_take(&arena, ((size_t)n + 1) * sizeof *pivots), info = 0;
    if (arena.failed) {
        mbsri_arena_close(&arena);
        return MBSR_ERR_NO_MEMORY;
    }
    for (size_t k = 0; k < square; ++k) A[2 * k] = -l->part[MBSR_LINEAR_AR][k];
    for (int k = 0; k < n; ++k)
        A[2 * (size_t)k * (size_t)(n + 1) + 1] = 2.0 * 3.14159265358979323846 * frequency;
    for (size_t k = 0; k < sides; ++k) b[2 * k] = l->part[MBSR_LINEAR_BR][k];
    if (n > 0 && inputs > 0) zgesv_(&n, &inputs, A, &n, pivots, b, &n, &info);
    for (int j = 0; j < inputs && info == 0; ++j) {
        for (int i = 0; i < outputs; ++i) {
            const int at = j * outputs + i;
            re[at] = l->part[MBSR_LINEAR_DR][at];
            im[at] = 0.0;
            for (int k = 0; k < n; ++k) {
                const double c = l->part[MBSR_LINEAR_CR][(size_t)k * (size_t)outputs + (size_t)i];
                re[at] += c * b[2 * ((size_t)j * (size_t)n + (size_t)k)];
                im[at] += c * b[2 * ((size_t)j * (size_t)n + (size_t)k) + 1];
            }
        }
    }
    mbsri_arena_close(&arena);
    return info ? MBSR_ERR_VALUE : MBSR_OK;
}
