/* A consistent start of a tree, in any form.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the directions a that move no mass (null_space.h) the equations of motion are balances of
 * forces, gamma(q, u, t) = 0. With C = d gamma / d u and S = d gamma / d q along these directions,
 * and Y an orthonormal basis of the left null space of C, Yc of its complement:
 *
 *   damped directions (rank of C):  Yc^T gamma = 0 fixes velocities        index 1
 *   elastic ones:                   Y^T gamma = 0 fixes positions,
 *                                   Y^T gamma' = 0 velocities              index 2
 *   otherwise                       the motion is not determined
 *
 * The start changes q along the elastic directions only, then u along all of them; momenta p = M u
 * stay. u' follows from the equations of motion, Yc^T gamma' = 0 and Y^T gamma'' = 0. Since all of
 * gamma vanishes along the motion, Y may be held fixed while differentiating.
 *
 * That takes O(N k) operations for k directions, and C by differences. Where they are many and all
 * are damped, the Newton solver does it in O(N) (damped_start.h). */
#include "algebra/dense.h"
#include "base/error.h"
#include "massless/damped_start.h"
#include "massless/imbalance.h"
#include "massless/start.h"
#include "massless/tree_start.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"

#include <math.h>

/* Memory of vectors over the whole state. */
static int allocate_state(mbsri_start *s)
{
    const mbsr_model *m = s->w.m;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = (size_t)s->form->size(m);
    double **const array[] = {&s->q_given, &s->u_given, &s->q,  &s->u,     &s->qdot,
                              &s->udot,    &s->y,       &s->yp, &s->change};
    const size_t length[] = {nq, nu, nq, nu, nq, nu, size, size, nu};
    s->memory = mbsri_allocate(&m->allocator, (3 * nq + 4 * nu + 2 * size) * sizeof(double));
    if (!s->memory) {
        return mbsri_fail(&s->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %zu coordinates", nq + nu);
    }
    double *next = s->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    return MBSR_OK;
}

/* Memory of what the directions need beside the null space itself. */
static int allocate_directions(mbsri_start *s)
{
    const mbsr_model *m = s->w.m;
    const size_t k = (size_t)s->w.k;
    double **const array[] = {&s->left,  &s->left_error, &s->Z,      &s->Z_error,
                              &s->B,     &s->B_error,    &s->defect, &s->weights,
                              &s->moved, &s->trial,      &s->sizes};
    const size_t length[] = {k * k, k * k, k * k, k * k, k * k, k * k, k, k, k, k, k};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    size_t reduction = mbsri_reduction_size(s->w.k, s->w.k) + sizeof(double);
    reduction -= reduction % sizeof(double);
    s->more = mbsri_allocate(&m->allocator, total * sizeof(double) + 2 * reduction);
    if (!s->more) {
        return mbsri_fail(&s->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d null directions", s->w.k);
    }
    double *next = s->more;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    mbsri_reduction_place(&s->reduced, s->w.k, s->w.k, next);
    mbsri_reduction_place(&s->rest, s->w.k, s->w.k, next + reduction / sizeof(double));
    return MBSR_OK;
}

/* Evaluates all stages at the improved state. */
static int evaluate(const mbsri_start *s)
{
    int status = mbsri_positions(s->w.m, s->w.d, s->t, s->q);
    if (!status) status = mbsri_velocities(s->w.m, s->w.d, s->u);
    if (!status) status = mbsri_forces(s->w.m, s->w.d, NULL);
    return status ? status : mbsri_backward(s->w.m, s->w.d);
}

/* The improved state in the form asked for, with its rates. */
static int deliver(const mbsri_start *s, double *y, double *yp)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    const size_t size = (size_t)s->form->size(m);
    int status = mbsri_pack(s->form, m, d, s->t, s->q, s->u, s->y);
    if (!status) status = evaluate(s);
    if (!status) status = s->form->start(m, d, s->t, s->y, s->udot, s->yp);
    if (status) return status;
    status = mbsri_check_result(m, d, size, s->y, "mbsr_dae_consistent");
    if (!status) status = mbsri_check_result(m, d, size, s->yp, "mbsr_dae_consistent");
    if (status) return status;
    mbsri_copy(size, s->y, y);
    mbsri_copy(size, s->yp, yp);
    return MBSR_OK;
}

/* ---- the two ways ---- */

/* By the directions that move no mass. */
static int run_directions(mbsri_start *s)
{
    int status = MBSR_OK;
    s->info.null_directions = s->w.k;
    if (s->w.k > 0) {
        status = mbsri_start_positions(s);
        if (!status) status = mbsri_start_velocities(s);
    }
    if (!status) status = mbsri_start_rates(s);
    s->info.elastic_directions = s->w.k - s->damped;
    return status;
}

static int by_directions(mbsri_start *s)
{
    const mbsr_model *m = s->w.m;
    int status = mbsri_null_open(&s->w, m, s->w.d, s->t, s->q, s->u, "mbsr_dae_consistent");
    if (status) return status;
    status = allocate_directions(s);
    if (!status) status = run_directions(s);
    mbsri_release(&m->allocator, s->more);
    mbsri_null_close(&s->w);
    return status;
}

/* Beyond so many directions the Newton solver is asked first. */
enum { MANY_DIRECTIONS = 24 };

/* By the Newton solver; *served: whether it did. */
static int on_tree(mbsri_start *s, bool *served)
{
    const mbsr_model *m = s->w.m;
    mbsr_data *d = s->w.d;
    *served = false;
    int status = evaluate(s);
    if (status || m->nu - d->total_rank <= MANY_DIRECTIONS) return status;
    s->info.null_directions = m->nu - d->total_rank;
    s->info.force_defect = mbsri_largest_defect(m, d, false, 0.0, NULL);
    status = mbsri_damped_start(m, d, s->t, s->q, s->u, s->udot, s->opt, &s->info, served);
    if (!*served) s->info = (mbsr_consistent_info){0};
    return status;
}

/* From the state given to the result in y, yp. */
static int run(mbsri_start *s, double *y, double *yp)
{
    const mbsr_model *m = s->w.m;
    bool served;
    mbsri_copy((size_t)m->nq, s->q_given, s->q);
    mbsri_copy((size_t)m->nu, s->u_given, s->u);
    int status = on_tree(s, &served);
    if (!status && !served) status = by_directions(s);
    if (status) return status;
    return deliver(s, y, yp);
}

int mbsri_tree_start(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form, double t, double *y,
                     double *yp, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    mbsri_start s = {.form = mbsri_find_form(form), .opt = opt, .t = t, .w = {.m = m, .d = d}};
    int status = allocate_state(&s);
    if (status) return status;
    status = mbsri_unpack(s.form, m, d, t, y, s.q_given, s.u_given);
    if (!status) {
        status = run(&s, y, yp);
        *info = s.info;
    }
    mbsri_release(&m->allocator, s.memory);
    return status;
}
