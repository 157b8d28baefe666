/* Directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/null_space.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"

#include <math.h>

static int evaluate(mbsri_null_space *w, double t, const double *q, const double *u)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = mbsri_forces(w->m, w->d, NULL);
    if (!status) status = mbsri_backward(w->m, w->d);
    return status;
}

int mbsri_null_open(mbsri_null_space *w, const mbsr_model *m, mbsr_data *d, double t,
                    const double *q, const double *u, const char *function)
{
    *w = (mbsri_null_space){.m = m, .d = d, .function = function};
    const int status = evaluate(w, t, q, u);
    if (status) return status;
    w->k = m->nu - d->total_rank;
    const size_t k = (size_t)w->k, nu = (size_t)m->nu, nq = (size_t)m->nq, n = (size_t)m->max_n;
    const size_t steps = (MBSRI_HIGHEST_DECADE - MBSRI_LOWEST_DECADE + 1) * k;
    double **const array[] = {&w->vector, &w->direction, &w->C, &w->S, &w->ahead, &w->behind,
                              &w->slopes, &w->sizes,     &w->q, &w->u, &w->rate,  &w->force};
    const size_t length[] = {n * k, nu * k, k * k, k * k, k, k, steps, steps, nq, nu, nq, nu};
    size_t used = 2 * k * sizeof(int) + sizeof(double); /* the ints first, then doubles, aligned */
    used -= used % sizeof(double);
    size_t total = used;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l)
        total += length[l] * sizeof(double);
    w->memory = mbsri_allocate(&m->allocator, total);
    if (!w->memory) {
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d null directions", function, w->k);
    }
    w->head = w->memory;
    w->body = w->head + k;
    double *next = (double *)((unsigned char *)w->memory + used);
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    return MBSR_OK;
}

void mbsri_null_close(mbsri_null_space *w)
{
    mbsri_release(&w->m->allocator, w->memory);
    w->memory = NULL;
}

/* a from N_l of the group of head j, leaves-ward. */
static void lift(mbsri_null_space *w, int j, const double *vector, double *a)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    double *x = d->scratch;
    double *z = x + m->max_d;
    mbsri_zero((size_t)m->nu, a);
    for (int i = 0; i <= m->bodies; ++i) d->carries[i] = false;
    for (int i = j; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const bool below = mbsri_null_below(m, d, i, x);
        if (!below && i != j) continue;
        mbsri_zero((size_t)g.n, z);
        if (i == j) mbsri_copy((size_t)g.n, vector, z);
        mbsri_null_pass(m, d, &g, i == j, below, x, z);
        mbsri_group_scatter(m, &g, z, a);
    }
}

/* The number of directions must be the one that memory was taken for. */
static int check_number(mbsri_null_space *w)
{
    const int now = w->m->nu - w->d->total_rank;
    if (now == w->k) return MBSR_OK;
    return mbsri_fail(&w->d->error, MBSR_RANK_CHANGED, MBSR_NONE, MBSR_NONE,
                      "%s: the number of directions without mass changes from %d to %d",
                      w->function, w->k, now);
}

/* The body of the group whose joint lacks the rank number `missing`, from the head on. */
static int lacking(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int missing)
{
    int k = 0;
    while (k < g->members - 1) {
        missing -= m->body[g->member[k]].n - d->rank[g->member[k]];
        if (missing < 0) break;
        ++k;
    }
    return g->member[k];
}

int mbsri_null_basis(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = evaluate(w, t, q, u);
    if (!status) status = check_number(w);
    if (status) return status;
    int column = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        for (int l = mbsri_group_rank(d, &g); l < g.n; ++l, ++column) {
            double *vector = w->vector + (size_t)column * (size_t)m->max_n;
            for (int k = 0; k < g.n; ++k)
                vector[k] = d->s[g.ig + k] * d->X[m->body[i].nn + (size_t)(l * g.n + k)];
            w->head[column] = i;
            w->body[column] = lacking(m, d, &g, l - mbsri_group_rank(d, &g));
            lift(w, i, vector, w->direction + (size_t)column * (size_t)m->nu);
        }
    }
    return MBSR_OK;
}

int mbsri_null_gamma(mbsri_null_space *w, double t, const double *q, const double *u, double *gamma)
{
    const mbsr_model *m = w->m;
    int status = evaluate(w, t, q, u);
    if (!status) status = check_number(w);
    if (status) return status;
    for (int l = 0; l < w->k; ++l) {
        const mbsri_group g = mbsri_group_of(m, w->d, w->head[l]);
        if (l == 0 || w->head[l] != w->head[l - 1])
            mbsri_null_force(m, w->d, &g, w->d->e + g.ig, w->force);
        gamma[l] = mbsri_dot(g.n, w->vector + (size_t)l * (size_t)m->max_n, w->force);
    }
    return mbsri_check_result(m, w->d, (size_t)w->k, gamma, w->function);
}

int mbsri_null_rate(mbsri_null_space *w, double t, const double *q, const double *x, double *rate)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, x);
    return status ? status : mbsri_coordinate_rates(w->m, w->d, rate);
}

void mbsri_null_combine(const mbsri_null_space *w, const double *weights, double *y)
{
    mbsri_ax(w->m->nu, w->k, 1.0, w->direction, weights, y);
}

/* Divides each row by its largest entry; scale (k) gets the factors. */
void mbsri_scale_rows(int k, double *A, double *scale)
{
    for (int r = 0; r < k; ++r) {
        double size = 0.0;
        for (int c = 0; c < k; ++c) size = fmax(size, fabs(A[c * k + r]));
        scale[r] = size > 0.0 ? 1.0 / size : 1.0;
        for (int c = 0; c < k; ++c) A[c * k + r] *= scale[r];
    }
}

void mbsri_scale_columns(int k, double *A, double *scale)
{
    for (int c = 0; c < k; ++c) {
        const double size = mbsri_largest(k, A + c * k);
        scale[c] = size > 0.0 ? 1.0 / size : 1.0;
        for (int r = 0; r < k; ++r) A[c * k + r] *= scale[c];
    }
}
