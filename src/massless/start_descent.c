/* Positions of a consistent start, down the slope of springs: see start_descent.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Newton's method stops where a direction on springs loses its stiffness, and which way it takes
 * from there is a matter of rounding. What follows the forces along directions without mass as if
 * dampers resisted goes past that, to a balance that springs come back to, and to the same one
 * whatever the units,
 *
 *   (K(c) + l/c D) x = (0, 0, F_u, 0, g),   D = 1 over squares of spans on F_u, u:    q -= x_q
 *
 * which is an implicit Euler step of that motion of length 1/l, as x_u grows with c. l falls with
 * the forces (pseudo-transient continuation, as in linear/equilibrium.c), and rises where a step
 * would be too long or makes matters worse.
 *
 * With S the answers u to forces F_u on the n joint rates that lack mass, A = D^1/2 S D^1/2,
 *
 *   (1 + l/c A) z = D^1/2 S F_u,   x = K(c)^-1 (0, 0, F_u - l/c D^1/2 z, 0, g)
 *
 * z is looked for among D^1/2 S F_u and what A makes of it again and again, which serves all l at a
 * state (Arnoldi): with as many as n exactly. */
#include "massless/start_descent.h"

#include "massless/completion_elastic.h"
#include "massless/start_return.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/memory.h"
#include "model/query.h"
#include "recursion/kinematics.h"

#include <math.h>

enum { MOST = 48 };

/* Vectors V for one matrix, orthonormal, with V^T A V = H, and the length of the first. */
typedef struct basis {
    int count;
    double *V, *H, length; /* MOST x n, MOST x MOST */
} basis;

typedef struct descent {
    int n, *rate, *pivots; /* joint rates that lack mass: n places in u; MOST: scratch */
    basis of[MBSRI_MATRICES];
    double *A, *work, *z; /* MOST x MOST, 4 MOST, n: scratch */
    void *memory;
} descent;

static int open_descent(mbsri_start *s, descent *v)
{
    const mbsr_model *m = s->w->m;
    size_t n = 0;
    for (int k = 0; k < m->nu; ++k) n += s->lacks[k];
    const size_t numbers = (2 * MOST + 1) * n + 3 * MOST * MOST + 4 * MOST;
    v->memory = mbsri_allocate(&m->allocator, numbers * sizeof(double) + (n + MOST) * sizeof(int));
    if (!v->memory)
        return mbsri_completion_fail(s->w, MBSR_ERR_NO_MEMORY, "no memory for answers of springs");
    double *next = v->memory;
    for (int j = 0; j < MBSRI_MATRICES; ++j) {
        v->of[j].V = next;
        v->of[j].H = next + MOST * n;
        next += MOST * n + MOST * MOST;
    }
    v->A = next;
    v->work = v->A + MOST * MOST;
    v->z = v->work + 4 * MOST;
    v->rate = (int *)(void *)(v->z + n);
    v->pivots = v->rate + n;
    for (int k = 0; k < m->nu; ++k) {
        if (s->lacks[k]) v->rate[v->n++] = k;
    }
    return MBSR_OK;
}

/* x = K(c)^-1 (a (0, 0, F_u, 0, g) + b D^1/2 z) with matrix j; u (n): D^1/2 x_u, not if NULL. */
static int answer(mbsri_start *s, const descent *v, int j, double a, double b, const double *z,
                  double *x, double *u)
{
    mbsr_completion *w = s->w;
    for (int k = 0; k < w->size; ++k) w->r[k] = a * s->step[k];
    for (int k = 0; k < v->n; ++k)
        w->r[w->rates + v->rate[k]] += b * z[k] * w->span.per[v->rate[k]];
    const int status = mbsri_completion_solve(w, j, w->r, x);
    for (int k = 0; k < v->n && u; ++k) u[k] = x[w->rates + v->rate[k]] * w->span.per[v->rate[k]];
    return status;
}

/* Takes its parts along the vectors of b off u, twice, as rounding leaves some, into column k of H;
 * the length of the rest. */
static double take_off_parts(const descent *v, basis *b, int k, double *u)
{
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i <= k; ++i) {
            const double *vector = b->V + (size_t)i * (size_t)v->n,
                         part = mbsri_dot(v->n, vector, u);
            b->H[k * MOST + i] += part;
            for (int l = 0; l < v->n; ++l) u[l] -= part * vector[l];
        }
    }
    return sqrt(mbsri_dot(v->n, u, u));
}

static int find_basis(mbsri_start *s, descent *v, int j)
{
    static const double rounding = 1e-13;
    basis *b = v->of + j;
    const int n = v->n, most = n < MOST ? n : MOST;
    double *u = b->V, largest = 0.0;
    mbsri_zero(MOST * MOST, b->H);
    int status = answer(s, v, j, 1.0, 0.0, v->z, s->w->x, u);
    b->length = sqrt(mbsri_dot(n, u, u));
    double length = b->length;
    for (b->count = 0; b->count < most && length > rounding * largest && !status;) {
        const int k = b->count++;
        double *next = k + 1 < most ? u + n : v->z;
        if (k > 0) b->H[(k - 1) * MOST + k] = length;
        for (int l = 0; l < n; ++l) u[l] /= length;
        status = answer(s, v, j, 0.0, 1.0, u, s->w->x, next);
        largest = fmax(largest, sqrt(mbsri_dot(n, next, next)));
        length = take_off_parts(v, b, k, next);
        u = next;
    }
    return status;
}

static double largest_force(const mbsri_start *s, const descent *v)
{
    const mbsr_completion *w = s->w;
    double force = 0.0;
    for (int k = 0; k < v->n; ++k)
        force = fmax(force, fabs(w->F[w->rates + v->rate[k]]) / w->span.per[v->rate[k]]);
    return force;
}

/* At w->y what is to become zero, into s->step, and the vectors for both matrices. */
static int find_bases(mbsri_start *s, descent *v, double *force)
{
    mbsr_completion *w = s->w;
    int status = mbsri_start_evaluate(s, true);
    *force = largest_force(s, v);
    if (!status) status = mbsri_start_factor(s);
    mbsri_start_rows(s, true, false, true);
    mbsri_copy((size_t)w->size, w->r, s->step);
    for (int j = 0; j < MBSRI_MATRICES && !status; ++j) status = find_basis(s, v, j);
    return status;
}

/* x for matrix j. */
static int solve_damped(mbsri_start *s, descent *v, int j, double l, double *x)
{
    const basis *b = v->of + j;
    const double by_c = l / mbsri_completion_c(s->w, j);
    const int n = b->count;
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < n; ++i)
            v->A[k * n + i] = by_c * b->H[k * MOST + i] + (i == k ? 1.0 : 0.0);
    }
    if (n > 0 && !(mbsri_lapack_inverse(n, v->A, v->pivots, v->work) > 0.0))
        return MBSR_NO_CONVERGENCE;
    mbsri_zero((size_t)v->n, v->z);
    for (int k = 0; k < n; ++k) {
        const double share = v->A[k] * b->length, *vector = b->V + (size_t)k * (size_t)v->n;
        for (int i = 0; i < v->n; ++i) v->z[i] += share * vector[i];
    }
    return answer(s, v, j, 1.0, -by_c, v->z, x, NULL);
}

/* The step at l, into w->x: *length of it. */
static int solve_step(mbsri_start *s, descent *v, double l, double *length)
{
    mbsr_completion *w = s->w;
    int status = solve_damped(s, v, MBSRI_NEAR, l, w->x);
    if (!status) status = solve_damped(s, v, MBSRI_FAR, l, w->other);
    if (status) return status;
    mbsri_completion_part(w);
    *length = mbsri_start_extent(s, w->x);
    return isfinite(*length) ? MBSR_OK : MBSR_NO_CONVERGENCE;
}

/* The step at *l, or at more where that is too long. */
static int find_step(mbsri_start *s, descent *v, double force, double *l, double *length)
{
    enum { TRIES = 60 };
    static const double longest = 0.3;
    for (int tries = 0; tries < TRIES; ++tries) {
        const int status = solve_step(s, v, *l, length);
        if (status || *length <= longest) return status;
        *l = 2.0 * fmax(*l, 0.1 * force);
    }
    return MBSR_NO_CONVERGENCE;
}

/* w->y less w->x, masses where they were; the largest force there. */
static int take_step(mbsri_start *s, const descent *v, double *force)
{
    mbsr_completion *w = s->w;
    mbsri_copy((size_t)w->size, w->y, s->before);
    for (int k = 0; k < w->rates; ++k) w->y[k] -= w->x[k];
    for (int k = w->rates; k < w->loops; ++k) w->y[k] -= w->x[k];
    int status = mbsri_normalise(w->m, w->d, w->y);
    if (!status) status = mbsri_start_return_masses(s);
    if (!status) status = mbsri_start_evaluate(s, true);
    *force = largest_force(s, v);
    return status;
}

static int go_down(mbsri_start *s, descent *v)
{
    enum { STEPS = 150 };
    static const double little = 1e-6, short_step = 0.15;
    mbsr_completion *w = s->w;
    double l = 0.0;
    for (int step = 0; step < STEPS; ++step) {
        double force, now, length = 0.0;
        int status = find_bases(s, v, &force);
        if (status) return status;
        if (step == 0) l = 4.0 * force;
        status = find_step(s, v, force, &l, &length);
        if (status) return status;
        ++s->info->iterations;
        status = take_step(s, v, &now);
        if (status < 0) return status;
        if (status || (now > 2.0 * force && length > little)) {
            mbsri_copy((size_t)w->size, s->before, w->y);
            l *= 4.0;
            continue;
        }
        s->displaced = true;
        if (length <= little && (l * length <= little * force || mbsri_start_balances(s)))
            return MBSR_OK;
        l *= fmin(1.0, fmax(0.05, now / force));
        if (length < short_step) l *= 0.5;
    }
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE, "position");
}

int mbsri_start_descend(mbsri_start *s)
{
    descent v = {.n = 0};
    int status = open_descent(s, &v);
    if (status) return status;
    status = go_down(s, &v);
    mbsri_release(&s->w->m->allocator, v.memory);
    return status;
}
