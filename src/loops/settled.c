/* Springs of a settled start: see settled.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/settled.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

/* ---- positions ---- */

static bool any_asked(const mbsri_closer *w)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    bool any = false;
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k)
            any = any || (mbsri_is_stiff(c, k) && mbsri_is_asked(w, c, k));
    }
    return any;
}

/* Lets go of the stiff rows that depend on others at q; *any: whether there are more than before.
 */
static int find_dependent(mbsri_closer *w, double t, const double *q, bool *any)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    mbsri_dense dense;
    mbsri_ranks ranks;
    *any = false;
    if (!any_asked(w)) return MBSR_OK;
    int status = mbsri_dense_open(&dense, w->m, w->d, w->function);
    if (!status) status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_dense_rows(&dense);
    if (!status) status = mbsri_ranks_here(&dense, dense.other, &ranks);
    for (; c < end && !status; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            if (!mbsri_is_stiff(c, k) || !mbsri_is_asked(w, c, k) || !dense.other[c->row + k])
                continue;
            w->let_go[c->row + k] = *any = true;
        }
    }
    mbsri_dense_close(&dense);
    return status;
}

int mbsri_assemble_settled(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                           mbsr_assembly_info *info)
{
    bool any = false;
    const size_t nq = (size_t)w->m->nq;
    double *guess = mbsri_allocate(&w->m->allocator, nq * sizeof *guess);
    if (!guess)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d positions", w->function, w->m->nq);
    mbsri_copy(nq, q, guess);
    int status = mbsri_assemble(w, t, q, opt, info);
    if (status == MBSR_LOOP_OPEN) {
        const mbsr_error open = w->d->error;
        status = find_dependent(w, t, guess, &any);
        if (!status && !any) {
            status = MBSR_LOOP_OPEN;
            w->d->error = open;
        }
    }
    if (!status && any) {
        mbsri_copy(nq, guess, q);
        status = mbsri_assemble(w, t, q, opt, info);
    }
    mbsri_release(&w->m->allocator, guess);
    return status;
}

/* ---- forces ---- */

/* Springs that are let go are stretched as the others' gaps let them. Where all gaps close only
 * those of closures with much stiffer ones are: others share what they bear by their compliance
 * (mbsri_loops_share), which rounding of gaps, times their stiffness, would drown. */
bool mbsri_springs_let_go(mbsri_dense *w, bool apart)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    bool any = false;
    for (int k = 0; k < w->rows; ++k) apart = apart || w->closer.let_go[k];
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const bool follows = mbsri_is_stiff(c, k) && w->d->dropped[c->row + k] &&
                                 (apart || mbsri_is_loose(c, k) || mbsri_is_soft_row(w, c, k));
            w->closer.let_go[c->row + k] = follows;
            any = any || (follows && !mbsri_is_loose(c, k));
            if (mbsri_is_stiff(c, k) && mbsri_is_asked(&w->closer, c, k))
                w->left_out[c->row + k] = false;
        }
    }
    return any;
}

/* A and b: rows of springs, sqrt(k) (C, -g - lambda / k), of which those that are let go have
 * lambda = -k g; and rigid ones, 0 = C x, which weigh more. */
static void fill_springs(mbsri_dense *w, const double *g, const double *lambda)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const size_t stride = (size_t)(w->position_rows + w->n), rows = (size_t)w->rows;
    double stiffest = 0.0;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c)
        stiffest = fmax(stiffest, mbsri_largest(c->position_rows, c->def.stiffness));
    mbsri_zero(stride * (size_t)w->n, w->A);
    mbsri_zero(stride + (size_t)w->n, w->b);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k, position = c->position_row + k;
            const bool stiff = mbsri_is_stiff(c, k), asked = mbsri_is_asked(&w->closer, c, k);
            if (mbsri_is_loose(c, k) || (!stiff && w->d->dropped[row])) continue;
            const double weight = stiff ? sqrt(c->def.stiffness[k]) : 1e3 * sqrt(stiffest);
            for (size_t j = 0; j < (size_t)w->n; ++j)
                w->A[j * stride + (size_t)position] = weight * w->C[j * rows + (size_t)row];
            if (stiff && asked)
                w->b[position] = -weight * (g[position] + lambda[row] / c->def.stiffness[k]);
        }
    }
}

/* The displacement x (n) into w->b after which springs exert what they and lambda do now, C^T
 * lambda = -C^T k (g + C x) but for rigid rows:
 *
 *   sum k (C x + g + lambda / k)^2 = min, with C x = 0 in rigid rows */
static int displacement(mbsri_dense *w, double t, const double *q, const double *lambda)
{
    int rank, status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_dense_rows(w);
    if (!status) status = mbsri_closure_gaps(w->m, w->d, w->g);
    if (status) return status;
    fill_springs(w, w->g, lambda);
    if (mbsri_lapack_gelsy(w->position_rows + w->n, w->n, w->A, w->b, 1e-13, w->factor.pivots,
                           &rank, w->work, w->lwork))
        return mbsri_fail(&w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: a least-squares problem of the springs failed", w->function);
    return MBSR_OK;
}

int mbsri_springs_load(mbsri_dense *w, double t, const double *q, const double *lambda, bool shared,
                       bool *changed)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int status = shared ? displacement(w, t, q, lambda) : MBSR_OK;
    if (status) return status;
    const double rounding =
        fmax(1e-14 * mbsri_closing_size(w->m, w->d, &w->closer.closing),
             1e-12 * mbsri_closing_widest(w->m, &w->closer.closing, w->closer.offset));
    *changed = false;
    mbsri_zero((size_t)w->position_rows, w->offset.missing);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k, position = c->position_row + k;
            if (!mbsri_is_stiff(c, k) || !mbsri_is_asked(&w->closer, c, k)) continue;
            double gap = -lambda[row] / c->def.stiffness[k];
            if (shared) {
                gap = w->g[position];
                for (int j = 0; j < w->n; ++j) gap += w->C[j * w->rows + row] * w->b[j];
            }
            w->offset.missing[position] = gap - w->closer.offset[position];
            *changed = *changed || fabs(w->offset.missing[position]) >
                                       rounding * w->closer.closing.gap[position];
        }
    }
    return MBSR_OK;
}

double mbsri_springs_left(const mbsri_dense *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    double left = 0.0, size = 0.0;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double is = w->offset.missing[c->position_row + k],
                         gap = w->closer.offset[c->position_row + k];
            left += c->def.stiffness[k] * is * is;
            size += c->def.stiffness[k] * gap * gap;
        }
    }
    return left > 0.0 ? sqrt(left / size) : 0.0;
}

/* Forces depend on the gaps, so that gaps found for one another converge slowly, or not at all,
 * where springs are soft beside these forces: a share of what is missing is taken that would have
 * left nothing of it so far (Aitken). */
void mbsri_springs_move(mbsri_dense *w)
{
    static const double most = 100.0, rounding = 1e-16; /* of squares: not to be followed */
    const mbsri_closure *first = mbsri_all_closures(w->m);
    double along = 0.0, square = 0.0, before = 0.0, now = 0.0, size = 0.0;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int position = c->position_row + k;
            const double stiffness = c->def.stiffness[k], was = w->offset.missed[position],
                         is = w->offset.missing[position], turn = is - was;
            along += stiffness * was * turn;
            square += stiffness * turn * turn;
            before += stiffness * was * was;
            now += stiffness * is * is;
            size += stiffness * w->closer.offset[position] * w->closer.offset[position];
        }
    }
    if (!(before > 0.0)) w->offset.relaxation = 1.0;
    if (before > 0.0 && square > 0.0 && now > rounding * size)
        w->offset.relaxation = fmax(-most, fmin(-w->offset.relaxation * along / square, most));
    for (int position = 0; position < w->position_rows; ++position) {
        w->closer.offset[position] += w->offset.relaxation * w->offset.missing[position];
        w->offset.missed[position] = w->offset.missing[position];
    }
}

/* Forces of settled springs at the gaps that they have been given; refused where others were found.
 * Where these gaps tell no forces, being rounding of positions, they are those of what is missing,
 * too. */
int mbsri_springs_take(const mbsri_dense *w, double *lambda)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *first = mbsri_all_closures(m);
    const double limit = 1e-6 * mbsri_largest(w->rows, lambda),
                 rounding = 1e-13 * mbsri_closing_size(m, w->d, &w->closer.closing);
    char label[MBSRI_LABEL];
    for (int id = 0; id < (int)m->closures.count; ++id) {
        const mbsri_closure *c = first + id;
        for (int k = 0; k < c->position_rows; ++k) {
            if (!mbsri_is_stiff(c, k) || !mbsri_is_asked(&w->closer, c, k)) continue;
            const int position = c->position_row + k;
            const double stiffness = c->def.stiffness[k],
                         force = -w->closer.offset[position] * stiffness,
                         change = fabs(lambda[c->row + k] - force);
            if (change > limit && change > rounding * w->closer.closing.gap[position] * stiffness)
                return mbsri_fail(&w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                                  "%s: no positions found at which the springs of %s bear its "
                                  "forces (%.3g is left); settled = 0 takes them as they are",
                                  w->function, mbsri_closure_label(m, id, label), change);
            lambda[c->row + k] =
                change > limit ? force - w->offset.missing[position] * stiffness : force;
        }
    }
    return MBSR_OK;
}
