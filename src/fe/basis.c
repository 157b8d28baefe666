/* The modes of the reduced body: see basis.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * All is made orthonormal in K, the normal modes first, the static ones by what the normal ones
 * leave of them, so that W^T K W = 1 and flexibilities at loaded markers are exact whatever the
 * mass is; then W^T M W y = mu y, and modes are Z = W y with omega^2 = 1 / mu. Parts without any
 * mass are those of mu = 0. */
#include "fe/basis.h"

#include "algebra/dense.h"
#include "fe/error.h"
#include "fe/lapack.h"

#include <math.h>

static const double none = 1e-13;      /* mu beside the largest one: no mass */
static const double left = 1e-12;      /* of the energy of a static mode: others have it */
static const double dependent = 1e-10; /* eigenvalues of static modes scaled to 1 */
static const double missed = 1e-6;     /* of a load, after a solve, ... */
static const double loose = 100.0;     /* ... and of what rigid motions cost */

typedef struct stage {
    mbsri_fe_statics *s;
    const mbsri_fe_body *body;
    size_t n;
    double *W, *KW;       /* n x most */
    double *G, *w, *work; /* most x most, most, of eigenproblems */
} stage;

static int no_memory_for_modes(const mbsri_fe_body *body)
{
    return mbsri_fe_fail(body->error, MBSR_ERR_NO_MEMORY,
                         "mbsr_fe_reduce: no memory for the modes of %d dofs", body->n);
}

static bool is_loaded(const mbsri_fe_body *body, int marker)
{
    return marker > 0 && body->def->marker[marker].loaded != 0;
}

/* Unit loads of a marker: 0 .. 2 moments, 3 .. 5 forces. */
static int first_load(const mbsri_fe_body *body, int marker)
{
    return body->marker[marker].turns ? 0 : 3;
}

/* Unit loads at markers that are loaded. */
static int fe_count_loads(const mbsri_fe_body *body)
{
    int count = 0;
    for (int k = 0; k < body->markers; ++k)
        count += is_loaded(body, k) ? 6 - first_load(body, k) : 0;
    return count;
}

/* ---- static modes ---- */

/* Largest |R| beside the largest |F| of the same column. */
static double compare_columns(size_t n, int c, const double *R, const double *F)
{
    double worst = 0.0;
    for (int k = 0; k < c; ++k) {
        double most = 0.0, size = 0.0;
        for (size_t i = 0; i < n; ++i) {
            most = fmax(most, fabs(R[n * (size_t)k + i]));
            size = fmax(size, fabs(F[n * (size_t)k + i]));
        }
        if (!(most <= worst * size)) worst = most / size;
    }
    return worst;
}

/* X (n x c), loads, become deflections seen from the root; refined once, which also tells what was
 * lost. F, R: n x c. */
static int deflect(stage *t, int c, double *X, double *F, double *R)
{
    const mbsri_fe_body *body = t->body;
    const size_t size = t->n * (size_t)c;
    mbsri_fe_atb(body->n, 6, c, body->T, X, t->s->six);
    mbsri_fe_ab(body->n, 6, c, -1.0, t->s->C, t->s->six, 1.0, X);
    mbsri_copy(size, X, F);
    if (!mbsri_fe_deflect(t->s, t->s->C, c, X)) return no_memory_for_modes(body);
    mbsri_sparse_multiply(&body->K, c, X, R);
    for (size_t k = 0; k < size; ++k) R[k] = F[k] - R[k];
    const double worst = compare_columns(t->n, c, R, F);
    if (!(worst <= missed + loose * body->rigid))
        return MBSRI_FE_REFUSE(
            "a static mode misses its load by %.2g of it: K has a mechanism or is "
            "nearly singular once the body is held; are all parts joined?",
            worst);
    if (!mbsri_fe_deflect(t->s, t->s->C, c, R)) return no_memory_for_modes(body);
    for (size_t k = 0; k < size; ++k) X[k] += R[k];
    return MBSR_OK;
}

/* Attachment modes of all loads into X (n x loads). */
static int attach(stage *t, double *X)
{
    const mbsri_fe_body *body = t->body;
    const size_t block = t->n * MBSRI_FE_BLOCK;
    double *F = mbsri_arena_take(body->arena, block * sizeof *F),
           *R = mbsri_arena_take(body->arena, block * sizeof *R);
    if (!R) return no_memory_for_modes(body);
    int count = 0;
    for (int k = 0; k < body->markers; ++k) {
        for (int c = first_load(body, k); c < 6 && is_loaded(body, k); ++c) {
            double load[6] = {0.0};
            load[c] = 1.0;
            mbsri_fe_load(body, k, load, X + t->n * (size_t)count++);
        }
    }
    for (int k = 0; k < count; k += MBSRI_FE_BLOCK) {
        const int c = count - k < MBSRI_FE_BLOCK ? count - k : MBSRI_FE_BLOCK;
        int status = mbsri_fe_tell(body, "static modes", (double)k / count);
        if (!status) status = deflect(t, c, X + t->n * (size_t)k, F, R);
        if (status) return status;
    }
    return MBSR_OK;
}

/* ---- orthonormal in K ---- */

static void energies(stage *t, int c, const double *W, double *e)
{
    mbsri_sparse_multiply(&t->body->K, c, W, t->KW);
    for (int k = 0; k < c; ++k)
        e[k] = mbsri_dot((int)t->n, W + t->n * (size_t)k, t->KW + t->n * (size_t)k);
}

static void scale_vector(size_t n, double factor, double *x)
{
    for (size_t k = 0; k < n; ++k) x[k] *= factor;
}

/* W (n x *c), columns of energy 1, becomes orthonormal in K; what is dependent is left out. */
static int orthonormalise(stage *t, int *c, double *W)
{
    for (int pass = 0; pass < 2 && *c > 0; ++pass) {
        const int m = *c;
        mbsri_sparse_multiply(&t->body->K, m, W, t->KW);
        mbsri_fe_atb((int)t->n, m, m, W, t->KW, t->G);
        if (mbsri_fe_eigen(m, t->G, t->w, t->work) != 0)
            return mbsri_fe_fail(t->body->error, MBSR_ERR_NUMERICS,
                                 "mbsr_fe_reduce: eigenvalues of the modes did not converge");
        *c = 0;
        for (int k = 0; k < m; ++k) {
            if (!(t->w[k] > dependent * t->w[m - 1])) continue;
            for (int i = 0; i < m; ++i) t->G[m * *c + i] = t->G[m * k + i] / sqrt(t->w[k]);
            ++*c;
        }
        mbsri_fe_ab((int)t->n, m, *c, 1.0, W, t->G, 0.0, t->KW);
        mbsri_copy(t->n * (size_t)*c, t->KW, W);
    }
    return MBSR_OK;
}

/* X (n x *c) less what W (n x m) has of it, and scaled; those of which nothing is left are left
 * out. */
static void leave_rest(stage *t, int m, const double *W, int *c, double *X)
{
    double *whole = t->w, *rest = t->work;
    const int all = *c;
    energies(t, all, X, whole);
    for (int pass = 0; pass < 2; ++pass) {
        mbsri_sparse_multiply(&t->body->K, all, X, t->KW);
        mbsri_fe_atb((int)t->n, m, all, W, t->KW, t->G);
        mbsri_fe_ab((int)t->n, m, all, -1.0, W, t->G, 1.0, X);
    }
    energies(t, all, X, rest);
    *c = 0;
    for (int k = 0; k < all; ++k) {
        if (!(rest[k] > left * whole[k])) continue;
        double *to = X + t->n * (size_t)(*c)++;
        if (to != X + t->n * (size_t)k) mbsri_copy(t->n, X + t->n * (size_t)k, to);
        scale_vector(t->n, 1.0 / sqrt(rest[k]), to);
    }
}

/* ---- modes ---- */

/* Modes of W (n x m), by frequency, with their scales. */
static int diagonalise_modes(stage *t, int m, mbsri_fe_basis *b)
{
    mbsri_sparse_multiply(&t->body->M, m, t->W, t->KW);
    mbsri_fe_atb((int)t->n, m, m, t->W, t->KW, t->G);
    if (mbsri_fe_eigen(m, t->G, t->w, t->work) != 0)
        return mbsri_fe_fail(t->body->error, MBSR_ERR_NUMERICS,
                             "mbsr_fe_reduce: eigenvalues of the modes did not converge");
    b->count = m;
    for (int a = 0; a < m; ++a) {
        const double mu = t->w[m - 1 - a];
        double *z = b->Z + t->n * (size_t)a, largest = 0.0;
        mbsri_fe_ab((int)t->n, m, 1, 1.0, t->W, t->G + (size_t)m * (size_t)(m - 1 - a), 0.0, z);
        b->mu[a] = mu > none * t->w[m - 1] ? mu : 0.0;
        b->massless[a] = b->mu[a] * b->cutoff * b->cutoff < 1.0 || b->mu[a] == 0.0;
        for (size_t k = 0; k < t->n; ++k) {
            if (fabs(z[k]) > 1.000001 * fabs(largest)) largest = z[k];
        }
        const double length = b->massless[a] ? 1.0 : 1.0 / sqrt(mu);
        scale_vector(t->n, largest < 0.0 ? -length : length, z);
    }
    return MBSR_OK;
}

int mbsri_fe_make_basis(mbsri_fe_statics *s, const mbsri_fe_modes *modes, mbsri_fe_basis *b)
{
    const mbsri_fe_body *body = s->body;
    const double cutoff = body->def->cutoff;
    int normal = modes->count;
    stage t = {.s = s, .body = body, .n = (size_t)body->n};
    *b = (mbsri_fe_basis){.loads = fe_count_loads(body)};
    /* the highest normal mode keeps its mass, whatever rounding does */
    b->cutoff = cutoff > 0.0 ? cutoff : normal > 0 ? modes->omega[normal - 1] * (1.0 + 1e-6) : 0.0;
    const size_t most = (size_t)(normal + b->loads);
    t.W = mbsri_arena_take(body->arena, t.n * most * sizeof *t.W);
    t.KW = mbsri_arena_take(body->arena, t.n * most * sizeof *t.KW);
    t.G = mbsri_arena_take(body->arena, most * most * sizeof *t.G);
    t.w = mbsri_arena_take(body->arena, most * sizeof *t.w);
    t.work = mbsri_arena_take(body->arena, mbsri_fe_eigen_work((int)most) * sizeof *t.work);
    b->Z = mbsri_arena_take(body->arena, t.n * most * sizeof *b->Z);
    b->mu = mbsri_arena_take(body->arena, most * sizeof *b->mu);
    b->massless = mbsri_arena_take(body->arena, most * sizeof *b->massless);
    if (!b->massless) return no_memory_for_modes(body);
    mbsri_copy(t.n * (size_t)normal, modes->U, t.W);
    mbsri_fe_see_from(s, s->C, normal, t.W);
    for (int k = 0; k < normal; ++k) /* phi^T K phi = omega^2 */
        scale_vector(t.n, 1.0 / modes->omega[k], t.W + t.n * (size_t)k);
    int status = orthonormalise(&t, &normal, t.W);
    double *X = t.W + t.n * (size_t)normal;
    if (!status) status = attach(&t, X);
    if (status) return status;
    int fixed = b->loads;
    leave_rest(&t, normal, t.W, &fixed, X);
    status = orthonormalise(&t, &fixed, X);
    b->dependent = b->loads - fixed;
    return status ? status : diagonalise_modes(&t, normal + fixed, b);
}
