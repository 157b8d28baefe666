/* A few modes of large models.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * At rest E of the pencil (reduce.c) has ones in the rows of q and p alone, and S r = (q and p of
 * K^-1 (r, 0)): one solution of a Newton system, in O(N). Its largest eigenvalues 1 / (s - e) are
 * those of e next to the shift s; infinite e are zeros of S, and gone after three products. Momenta
 * along massless directions, which no equation reads and S keeps, are dropped by taking M du for
 * dp, which is the same where they are zero. Vectors are scaled so that their squares are energies.
 */
#include "linear/krylov.h"
#include "linear/record.h"
#include "linear/spans.h"

#include "base/cookie.h"
#include "base/error.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

static const char name[] = "mbsr_modes_near";

static const double farthest =
    1e4; /* from the shift, over it: beyond lie roots of rounding errors */
static const double lowest = 1e-3; /* shift, over the rate of the slowest modes that are asked */

mbsr_near_opt mbsr_default_near_opt(void)
{
    return (mbsr_near_opt){.cookie = MBSRI_COOKIE, .count = 20, .tolerance = 1e-10};
}

typedef struct near {
    mbsri_coordinates c;
    const mbsr_near_opt *opt;
    mbsr_newton *newton;
    mbsri_arena arena;
    mbsri_krylov space;
    double *y, *yp, *r, *delta; /* size of y */
    double *mass, *driven;      /* nu: of rates; momenta that driven joints have at u = 0 */
    double shift;
    int first;    /* vectors that are looked at first */
    bool nearest; /* are wanted; else the slowest */
    bool massless;
    mbsr_error *error;
} near;

static int fail_as(mbsr_error *error, int status, const mbsr_error *why)
{
    return mbsri_fail(error, status, why->body, why->force, "%s: %s", name, why->text);
}

/* out = S in, of scaled numbers; may be the same. */
static int apply_shifted(void *context, const double *in, double *out)
{
    near *w = context;
    const mbsri_coordinates *c = &w->c;
    const int nu = c->nu;
    double *p = w->r + c->nq, *u = w->delta + c->nq + nu;
    memset(w->r, 0, (size_t)c->size * sizeof *w->r);
    for (int k = 0; k < nu; ++k) {
        const double root = sqrt(w->mass[k]);
        w->delta[k] = in[k] / (root * w->shift);
        p[k] = in[nu + k] * root;
    }
    mbsri_coordinates_lift(c, w->delta, w->r);
    int status = mbsr_newton_solve(w->newton, w->r, w->delta);
    if (status) return fail_as(w->error, status, mbsr_newton_error(w->newton));
    if (w->massless) {
        status = mbsr_stage_velocities(c->model, c->data, u);
        if (!status) status = mbsr_momenta(c->model, c->data, w->delta + c->nq);
        if (status) return fail_as(w->error, status, mbsr_data_error(c->data));
    }
    mbsri_coordinates_take(c, w->delta, w->r);
    for (int k = 0; k < nu; ++k) {
        const double root = sqrt(w->mass[k]);
        out[k] = w->r[k] * root * w->shift;
        out[nu + k] = (w->delta[c->nq + k] - (w->massless ? w->driven[k] : 0.0)) / root;
    }
    return MBSR_OK;
}

static int factor_at(near *w, double shift)
{
    const mbsri_coordinates *c = &w->c;
    w->shift = shift;
    int status = mbsr_newton_factor(w->newton, c->data, c->t, w->y, w->yp, shift);
    if (status) return fail_as(w->error, status, mbsr_newton_error(w->newton));
    status = w->massless ? mbsr_stage_positions(c->model, c->data, c->t, w->y) : MBSR_OK;
    return status ? fail_as(w->error, status, mbsr_data_error(c->data)) : MBSR_OK;
}

/* e of the block at k: as a mode; where the block ends. */
static int mode_at(const near *w, int k, mbsr_mode *mode, double *distance, double *left)
{
    double re, im;
    const int next = mbsri_krylov_block(&w->space, k, &re, &im, left);
    const double square = re * re + im * im;
    *distance = square > 0.0 ? 1.0 / sqrt(square) : HUGE_VAL;
    *left *= *distance;
    *mode = mbsri_mode_of(w->shift - re / square, im / square, w->shift);
    return next;
}

static double distance_from_zero(const mbsr_mode *mode)
{
    return hypot(mode->real, mode->imaginary);
}

/* |e| of the slowest modes among those at hand, the `count`-th from below; no more of them: the
 * last. */
static double slowest_rate(const near *w, int count, double least)
{
    double rate = least;
    for (int found = 0; found < count;) {
        double next = HUGE_VAL;
        int times = 0;
        for (int k = 0; k < w->space.k;) {
            mbsr_mode mode;
            double distance, left;
            k = mode_at(w, k, &mode, &distance, &left);
            const double size = distance_from_zero(&mode);
            if (!(size > rate) || !(distance < HUGE_VAL) || size > next) continue;
            times = size < next ? 1 : times + 1;
            next = size;
        }
        if (times == 0) break;
        rate = next;
        found += times;
    }
    return rate;
}

/* The rate of the slowest mode that is not at rest, as a small space next to the shift tells it; 0:
 * it tells of none. */
static int see_slowest(near *w, double shift, double *rate)
{
    enum { SPACE = 20 };
    mbsri_krylov *z = &w->space;
    const int m = z->m;
    *rate = 0.0;
    int status = factor_at(w, shift);
    z->k = 0;
    z->m = z->limit = m < SPACE ? m : SPACE;
    if (!status) status = mbsri_krylov_begin(z);
    if (!status) status = mbsri_krylov_grow(z);
    if (!status && mbsri_krylov_sort(z)) {
        const double least = 1e-6 * shift, found = slowest_rate(w, 1, least);
        *rate = found > least ? found : 0.0;
    }
    z->m = z->limit = m;
    z->k = 0;
    return status;
}

/* A shift of half the rate of the slowest mode that is not at rest. Small spaces tell that rate,
 * too large where the shift is much larger. Modes at rest tell nothing, and roots of rounding
 * errors go with the shift: where there are only these, within what rounding leaves of the rate
 * typical of the model, the shift is that rate. */
static int find_shift(near *w)
{
    enum { ROUNDS = 20 };
    static const double rounding = 1e-11;
    const double typical = mbsr_model_rate(w->c.model), first = typical > 0.0 ? typical : 1.0;
    double shift = first, rate;
    for (int round = 0; round < ROUNDS; ++round) {
        const int status = see_slowest(w, shift, &rate);
        if (status && round == 0) return status;
        if (rate > 0.5 * shift && rate < 40.0 * shift) return MBSR_OK;
        shift = rate > 0.0 ? 0.4 * rate : 1e-5 * shift;
        if (status || shift < rounding * first || shift > first / rounding) break;
    }
    return factor_at(w, first);
}

/* How many vectors at the front are wanted, and whether they have converged: of the `count` modes
 * nearest to the shift; where slow ones are asked, of all up to where no slower one can be. Next to
 * the lowest shift the nearest are the slowest, but for a thousandth. Their sum tells one set from
 * another. */
static int find_wanted(const near *w, bool *converged, double *sum)
{
    const int count = w->opt->count;
    const double reach = w->nearest ? 0.0 : w->shift + slowest_rate(w, count, -1.0);
    int at = 0, modes = 0;
    *converged = true;
    *sum = 0.0;
    while (at < w->space.k) {
        mbsr_mode mode;
        double distance, left;
        const int next = mode_at(w, at, &mode, &distance, &left);
        if (!(distance < farthest * w->shift)) break;
        if (modes >= count && distance > reach * (1.0 + 1e-9)) break;
        *converged = *converged && left <= w->opt->tolerance;
        *sum += (double)(next - at) * w->shift / distance;
        at = next;
        ++modes;
    }
    *converged = *converged && (modes >= count || w->space.exhausted);
    return at;
}

/* Where the block ends that holds vector k - 1. */
static int end_of_block(const mbsri_krylov *z, int k)
{
    int at = 0;
    double re, im, left;
    while (at < k) at = mbsri_krylov_block(z, at, &re, &im, &left);
    return at;
}

/* Whether the first vector that is not wanted is known to be smaller than the last that is. */
static bool ends_there(const near *w, int wanted)
{
    double re, im, left, least = 0.0;
    if (wanted >= w->space.k) return false;
    for (int at = 0; at < wanted;) {
        at = mbsri_krylov_block(&w->space, at, &re, &im, &left);
        least = hypot(re, im);
    }
    (void)mbsri_krylov_block(&w->space, wanted, &re, &im, &left);
    return hypot(re, im) + left < least;
}

/* A new space at a lower shift, where too many modes to be held are as near to it as the slowest
 * that are asked may be. */
static int lower_shift(near *w)
{
    const double rate = slowest_rate(w, w->opt->count, -1.0), next = w->shift / 16.0;
    w->nearest = next <= lowest * rate || rate <= 1e-6 * w->shift;
    const int status = factor_at(w, w->nearest && rate > next ? lowest * rate : next);
    w->space.k = 0;
    w->space.limit = w->space.m;
    return status ? status : mbsri_krylov_begin(&w->space);
}

/* The space of what is wanted, and no more. What random vectors add to it is looked at first where
 * a few have been added. */
static int find_space(near *w)
{
    enum { CYCLES = 200, FEW = 30 };
    mbsri_krylov *z = &w->space;
    double last = 0.0;
    int status = mbsri_krylov_begin(z);
    z->limit = w->first;
    for (int cycle = 0; cycle < CYCLES && !status; ++cycle) {
        bool converged;
        double sum;
        status = mbsri_krylov_grow(z);
        if (status) break;
        if (!mbsri_krylov_sort(z)) break;
        const int wanted = find_wanted(w, &converged, &sum);
        const bool same = converged && fabs(sum - last) <= 1e-7 * sum;
        if (converged && (!same || z->k >= z->m || z->exhausted || ends_there(w, wanted))) {
            mbsri_krylov_keep(z, wanted);
            if (z->exhausted || same) return MBSR_OK;
            last = sum;
            status = mbsri_krylov_begin(z);
            z->limit = wanted + FEW < z->m ? wanted + FEW : z->m;
            continue;
        }
        if (z->k < z->m && !z->exhausted) {
            z->limit = z->m;
            continue;
        }
        if (z->exhausted) break;
        if (wanted > z->m - 6) {
            if (w->nearest) break;
            status = lower_shift(w);
            last = 0.0;
            continue;
        }
        const int kept = end_of_block(z, wanted + (z->k - wanted) / 2);
        mbsri_krylov_keep(z, kept < z->m ? kept : wanted);
    }
    if (status) return status;
    return mbsri_fail(w->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "%s: the %d modes nearest to the shift %g were not found in %d cycles of %d "
                      "solutions; ask for more or fewer, or at another shift",
                      name, w->opt->count, w->shift, (int)CYCLES, z->m);
}

/* Shape of mode k of the space, whose vectors are X: the largest number becomes 1. spare: 2 n. */
static void take_shape(const near *w, const double *X, int k, bool pair, double *spare, double *re,
                       double *im)
{
    const mbsri_krylov *z = &w->space;
    const int nu = w->c.nu;
    double largest = 0.0, a = 1.0, b = 0.0, *other = spare + nu;
    memset(spare, 0, 2 * (size_t)nu * sizeof *spare);
    for (int j = 0; j < z->k; ++j) {
        const double *v = z->V + (size_t)j * (size_t)z->n, *x = X + (size_t)k * (size_t)z->k + j;
        const double real = x[0], part = pair ? x[z->k] : 0.0;
        for (int i = 0; i < nu; ++i) {
            spare[i] += real * v[i];
            other[i] += part * v[i];
        }
    }
    for (int i = 0; i < nu; ++i) {
        const double root = sqrt(w->mass[i]);
        spare[i] /= root;
        other[i] /= root;
        if (!(hypot(spare[i], other[i]) > largest)) continue;
        largest = hypot(spare[i], other[i]);
        a = spare[i];
        b = other[i];
    }
    for (int i = 0; i < nu; ++i) {
        const double square = a * a + b * b;
        if (re) re[i] = (spare[i] * a + other[i] * b) / square;
        if (im) im[i] = (other[i] * a - spare[i] * b) / square;
    }
}

/* What the space holds, slowest first, of the nearest or of the slowest. */
static int take_modes(near *w, mbsr_mode *modes, int *found, double *re, double *im)
{
    const mbsri_krylov *z = &w->space;
    const size_t k = (size_t)z->k, nu = (size_t)w->c.nu;
    double *X = mbsri_arena_take(&w->arena, (k * k + 2 * nu + 1) * sizeof *X);
    int *from = mbsri_arena_take(&w->arena, (k + 1) * sizeof *from), count = 0;
    if (w->arena.failed) return MBSR_ERR_NO_MEMORY;
    if (!mbsri_krylov_vectors(&w->space, X))
        return mbsri_fail(w->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                          "%s: LAPACK found no eigenvectors", name);
    for (int at = 0; at < z->k;) {
        mbsr_mode mode;
        double distance, left;
        const int place = at;
        at = mode_at(w, at, &mode, &distance, &left);
        int to = count;
        for (; to > 0 && distance_from_zero(modes + to - 1) > distance_from_zero(&mode); --to) {
            if (to == w->opt->count) continue;
            modes[to] = modes[to - 1];
            from[to] = from[to - 1];
        }
        if (to == w->opt->count) continue;
        modes[to] = mode;
        from[to] = place;
        if (count < w->opt->count) ++count;
    }
    for (int i = 0; i < count && (re || im); ++i)
        take_shape(w, X, from[i], modes[i].imaginary > 0.0, X + k * k,
                   re ? re + (size_t)i * nu : NULL, im ? im + (size_t)i * nu : NULL);
    *found = count;
    return MBSR_OK;
}

/* A closure with rows that F knows as springs, or MBSR_NONE. */
static int find_stiff(const mbsr_model *m)
{
    for (int k = 0; k < mbsr_model_closures(m); ++k) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(m, k, &def)) continue;
        if (def.compliant > 0) return k;
        for (int r = 0; r < MBSR_CLOSURE_ROWS; ++r) {
            if (def.stiffness[r] > 0.0) return k;
        }
    }
    return MBSR_NONE;
}

/* y at rest, and in y' the loop forces there alone: consistent where loops are closed. */
static int start_at_rest(near *w, const double *q)
{
    const mbsri_coordinates *c = &w->c;
    const int rates = c->nq + 2 * c->nu;
    if (mbsr_model_rows(c->model) > 0) {
        const int status = mbsri_pencil_start(c->model, c->data, c->t, q, NULL, name, &w->arena,
                                              &w->y, &w->yp, w->error);
        if (status) return status;
        memset(w->y + c->nq, 0, 2 * (size_t)c->nu * sizeof *w->y);
        memset(w->yp, 0, (size_t)rates * sizeof *w->yp);
        return MBSR_OK;
    }
    w->y = mbsri_arena_take(&w->arena, 2 * ((size_t)c->size + 1) * sizeof *w->y);
    if (!w->y) return MBSR_ERR_NO_MEMORY;
    w->yp = w->y + c->size + 1;
    const int status =
        mbsr_dae_pack(c->model, c->data, MBSR_DAE_MOMENTUM, c->t, q, w->y + c->nq, w->y);
    return status ? fail_as(w->error, status, mbsr_data_error(c->data)) : MBSR_OK;
}

static int open_near(near *w, const double *q)
{
    mbsri_coordinates *c = &w->c;
    enum { SMALL = 1000, DENSE = 240 }; /* rates; vectors of models below */
    const int n = 2 * c->nu, first = 4 * w->opt->count + 30,
              most = n < SMALL && first < DENSE ? DENSE : first;
    const size_t size = (size_t)c->size + 1;
    w->r = mbsri_arena_take(&w->arena, (2 * size + 2 * (size_t)c->nu) * sizeof *w->r);
    w->space = (mbsri_krylov){.apply = apply_shifted, .context = w};
    mbsri_krylov_open(&w->space, &w->arena, n, most < n ? most : n);
    w->first = first < w->space.m ? first : w->space.m;
    w->nearest = w->opt->shift > 0.0;
    if (w->arena.failed) return MBSR_ERR_NO_MEMORY;
    w->delta = w->r + size;
    w->mass = w->delta + size;
    w->driven = w->mass + c->nu;
    int status = start_at_rest(w, q);
    if (status) return status;
    status = mbsri_coordinates_find(c, &w->arena, w->y, w->yp);
    if (status == MBSR_ERR_NO_MEMORY) return status;
    if (!status)
        status = mbsr_dae_residual(c->model, c->data, MBSR_DAE_MOMENTUM, c->t, w->y, w->yp, w->r);
    if (!status) status = mbsr_stage_backward(c->model, c->data);
    if (!status) status = mbsr_momentum_scales(c->model, c->data, w->mass);
    w->massless = !status && mbsr_total_rank(c->model, c->data) < c->nu;
    if (!status) status = mbsr_stage_velocities(c->model, c->data, w->driven);
    if (!status) status = mbsr_momenta(c->model, c->data, w->driven);
    if (status) return fail_as(w->error, status, mbsr_data_error(c->data));
    return mbsr_newton_create(c->model, MBSR_DAE_MOMENTUM, NULL, &w->newton, w->error);
}

/* Forces that are left at q move the model some 1e-6 rad, or of its length, at most. */
static int check_rest(near *w)
{
    static const double most = 1e-6;
    const mbsri_coordinates *c = &w->c;
    int status =
        mbsr_dae_residual(c->model, c->data, MBSR_DAE_MOMENTUM, c->t, w->y, w->yp, w->delta);
    if (status) return fail_as(w->error, status, mbsr_data_error(c->data));
    status = mbsr_newton_solve(w->newton, w->delta, w->delta);
    if (status) return fail_as(w->error, status, mbsr_newton_error(w->newton));
    const double length = mbsri_linear_length(c->model, c->data);
    for (int i = 0; i < c->bodies; ++i) {
        int at, nq;
        double span[MBSRI_LINEAR_SPANS];
        mbsr_body_coordinates(c->model, i, &at, &nq, NULL, NULL);
        if (nq > MBSRI_LINEAR_SPANS) continue;
        mbsri_linear_spans(c->model, i, false, length, span);
        for (int k = 0; k < nq; ++k) {
            if (!(fabs(w->delta[at + k]) > most * span[k]) || !(span[k] > 0.0)) continue;
            return mbsri_fail(w->error, MBSR_ERR_VALUE, i, MBSR_NONE,
                              "%s: the model is not at rest at q: forces would move coordinate %d "
                              "of body %d (%s) by %.3g; mbsr_equilibrium finds where it rests",
                              name, k, i, mbsr_body_name(c->model, i), w->delta[at + k]);
        }
    }
    return MBSR_OK;
}

static int run_near(near *w, const double *q, mbsr_mode *modes, int *found, double *re, double *im)
{
    int status = open_near(w, q);
    if (!status) status = w->opt->shift > 0.0 ? factor_at(w, w->opt->shift) : find_shift(w);
    if (!status) status = check_rest(w);
    if (!status) status = find_space(w);
    if (!status) status = take_modes(w, modes, found, re, im);
    if (status == MBSR_ERR_NO_MEMORY)
        return mbsri_fail(w->error, status, MBSR_NONE, MBSR_NONE, "%s: no memory for %d states",
                          name, 2 * w->c.nu);
    return status;
}

int mbsr_modes_near(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                    const mbsr_near_opt *opt, mbsr_mode *modes, int *found, double *re, double *im,
                    mbsr_error *error)
{
    const mbsr_near_opt standard = mbsr_default_near_opt();
    mbsr_model_def def;
    if (found) *found = 0;
    if (!opt) opt = &standard;
    if (!model || !data || !q || !modes || !found)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          !model   ? "model"
                          : !data  ? "data"
                          : !q     ? "q"
                          : !modes ? "modes"
                                   : "found");
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "%s: opt was not made by mbsr_default_near_opt", name);
    if (opt->count < 1 || opt->count > 1000 || !(opt->shift >= 0.0) || !isfinite(opt->shift) ||
        !(opt->tolerance > 0.0))
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: count is %d (1 .. 1000), shift %g (>= 0), tolerance %g (> 0)", name,
                          opt->count, opt->shift, opt->tolerance);
    if (mbsr_model_definition(model, &def))
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    const int stiff = find_stiff(model);
    if (stiff != MBSR_NONE)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: closure %d has stiff rows: make them force elements, or use "
                          "mbsr_linear_create",
                          name, stiff);
    near w = {.opt = opt, .error = error};
    mbsri_arena_open(&w.arena, &def.allocator);
    mbsri_coordinates_of(&w.c, model, data, t);
    const int status = run_near(&w, q, modes, found, re, im);
    mbsr_newton_destroy(w.newton);
    mbsri_arena_close(&w.arena);
    return status;
}
