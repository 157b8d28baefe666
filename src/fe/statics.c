/* Deflections of a body that nothing holds: see statics.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Springs on six dofs E, with E^T T regular, make K definite, and carry nothing when the loads are
 * balanced: T^T f = 0 gives T^T E alpha E^T u = 0, so E^T u = 0 and K u = f. They fill nothing in,
 * and one factor serves for static modes and for normal modes of the held and of the free body
 * alike. */
#include "fe/statics.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"

#include <math.h>

/* Shifts of K on the diagonal at six dofs that hold the body, chosen by Gram and Schmidt over the
 * rows of T with lengths divided by that of the body: always the dof that moves most in what is
 * left. Returns how many it found. */
static int support(const mbsri_fe_body *body, double *row, double *shift)
{
    const size_t n = (size_t)body->n;
    double square = 0.0, most = 0.0;
    for (size_t k = 0; k < 3 * (size_t)body->nodes; ++k) square += body->x[k] * body->x[k];
    const double length = sqrt(square / body->nodes);
    for (size_t k = 0; k < n; ++k) {
        const bool scaled = body->direction[k] < 3 && length > 0.0;
        for (size_t c = 0; c < 6; ++c)
            row[6 * k + c] = body->T[n * c + k] / (scaled && c < 3 ? length : 1.0);
    }
    for (int step = 0; step < 6; ++step) {
        int best = -1;
        double largest = 0.0;
        for (int k = 0; k < body->n; ++k) {
            const double size = mbsri_dot(6, row + 6 * (size_t)k, row + 6 * (size_t)k);
            if (size > largest && body->K.value[body->K.start[k]] > 0.0) largest = size, best = k;
        }
        if (step == 0) most = largest;
        if (best < 0 || !(largest > 1e-12 * most)) return step;
        double axis[6];
        for (int c = 0; c < 6; ++c) axis[c] = row[6 * (size_t)best + (size_t)c] / sqrt(largest);
        for (int k = 0; k < body->n; ++k) {
            double *r = row + 6 * (size_t)k;
            const double part = mbsri_dot(6, r, axis);
            for (int c = 0; c < 6; ++c) r[c] -= part * axis[c];
        }
        shift[best] = body->K.value[body->K.start[best]];
    }
    return 6;
}

static int no_memory_for_factor(const mbsri_fe_body *body)
{
    return mbsri_fail_plain(body->error, MBSR_ERR_NO_MEMORY,
                            "mbsr_fe_reduce: no memory for the factor of K, %d dofs", body->n);
}

static int factor_stiffness(mbsri_fe_statics *s)
{
    const mbsri_fe_body *body = s->body;
    const size_t n = (size_t)body->n;
    double *row = mbsri_arena_take(body->arena, 6 * n * sizeof *row),
           *shift = mbsri_arena_take(body->arena, n * sizeof *shift);
    if (!shift) return no_memory_for_factor(body);
    const int held = support(body, row, shift);
    if (held < 6)
        return MBSRI_FE_REFUSE("the nodes allow %d independent rigid motions of 6; those with "
                               "stiffness lie on a line or are one",
                               held);
    int column;
    char label[MBSRI_FE_LABEL];
    const int status =
        mbsri_factor_make(&body->def->allocator, s->solver, &body->K, shift, &s->factor, &column);
    if (status == MBSR_ERR_NO_MEMORY) return no_memory_for_factor(body);
    if (status)
        return MBSRI_FE_REFUSE("K has a mechanism or is indefinite: %s has no stiffness once the "
                               "body is held (K is %g there); are all parts joined?",
                               mbsri_fe_label(body, column, label),
                               body->K.value[body->K.start[column]]);
    return MBSR_OK;
}

/* relief = M T (T^T M T)^-1 where that is */
static int relieve(mbsri_fe_statics *s)
{
    const mbsri_fe_body *body = s->body;
    const size_t n = (size_t)body->n;
    double *MT = mbsri_arena_take(body->arena, 6 * n * sizeof *MT), J[36], inverse[36], size[6];
    s->relief = mbsri_arena_take(body->arena, 6 * n * sizeof *MT);
    if (!s->relief) return no_memory_for_factor(body);
    mbsri_sparse_multiply(&body->M, 6, body->T, MT);
    mbsri_fe_atb(body->n, 6, 6, body->T, MT, J);
    for (int k = 0; k < 36; ++k) inverse[k] = k % 7 == 0;
    for (int k = 0; k < 6; ++k) size[k] = J[7 * k];
    bool regular = mbsri_fe_cholesky(6, J) < 0;
    for (int k = 0; k < 6 && regular; ++k) regular = J[7 * k] * J[7 * k] > 1e-13 * size[k];
    mbsri_fe_cholesky_solve(6, J, 6, inverse);
    for (int k = 0; k < 36; ++k) regular = regular && isfinite(inverse[k]);
    if (regular)
        mbsri_fe_ab(body->n, 6, 6, 1.0, MT, inverse, 0.0, s->relief);
    else
        s->relief = NULL;
    return MBSR_OK;
}

int mbsri_fe_statics_make(const mbsri_fe_body *body, int columns, mbsri_fe_statics *s)
{
    const size_t n = (size_t)body->n;
    *s = (mbsri_fe_statics){.body = body, .most = columns};
    s->solver = mbsri_factor_choose(body->def->solver, body->n);
    if (s->solver == MBSR_FE_AUTO)
        return mbsri_fail_plain(
            body->error, MBSR_ERR_UNAVAILABLE,
            "mbsr_fe_reduce: %d dofs are to be solved by CHOLMOD, as more than 5000 "
            "always are, and this library was built without (SuiteSparse)",
            body->n);
    s->C = mbsri_arena_take(body->arena, 6 * n * sizeof *s->C);
    s->six = mbsri_arena_take(body->arena, 6 * (size_t)columns * sizeof *s->six);
    if (!s->six) return no_memory_for_factor(body);
    for (int k = 0; k < 6; ++k) {
        double load[6] = {0.0};
        load[k] = 1.0;
        mbsri_fe_load(body, 0, load, s->C + n * (size_t)k);
    }
    const int status = factor_stiffness(s);
    return status ? status : relieve(s);
}

void mbsri_fe_see_from(mbsri_fe_statics *s, const double *L, int c, double *U)
{
    mbsri_fe_atb(s->body->n, 6, c, L, U, s->six);
    mbsri_fe_ab(s->body->n, 6, c, -1.0, s->body->T, s->six, 1.0, U);
}

bool mbsri_fe_deflect(mbsri_fe_statics *s, const double *L, int c, double *X)
{
    mbsri_fe_atb(s->body->n, 6, c, s->body->T, X, s->six);
    mbsri_fe_ab(s->body->n, 6, c, -1.0, L, s->six, 1.0, X);
    if (!mbsri_factor_solve(s->factor, c, X)) return false;
    s->solves += c;
    mbsri_fe_see_from(s, L, c, X);
    return true;
}
