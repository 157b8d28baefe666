/* Ranks by the bound alone: see bounded.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/bounded.h"

#include "algebra/dense.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

#if defined(MBSR_WITHOUT_VECTORS)

bool mbsri_bounded_serves(const mbsr_model *m)
{
    (void)m;
    return false;
}

void mbsri_bounded_prepare(const mbsr_model *m, mbsri_sweep_load *bounds)
{
    (void)m, (void)bounds;
}

bool mbsri_bounded_free(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    (void)m, (void)d, (void)bounds;
    return false;
}

bool mbsri_bounded_backward(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    (void)m, (void)d, (void)bounds;
    return false;
}

#else

#include "joints/chain.h"
#include "sweeps/block_bound.h"
#include "sweeps/build.h"
#include "sweeps/dynamics.h"

bool mbsri_bounded_serves(const mbsr_model *m)
{
    bool serves = m->tree.plain && m->live == m->bodies && !m->order.grouped;
    for (int i = 1; i <= m->bodies && serves; ++i)
        serves = mbsri_has_twist(m->body[i].joint.space) && mbsri_has_twist(m->body[i].pred.space);
    return serves;
}

/* k >= 1 with M >= Lambda t / k, t the trace of M in the metric of Lambda = diag(l^2, 1); infinite
 * where M is not regular. */
static double spread_of(const mbsr_inertia *inertia, double l)
{
    const double *I = inertia->tensor, lambda = mbsri_sweeps_regularity(inertia, l),
                 turning = I[MBSR_XX] + I[MBSR_YY] + I[MBSR_ZZ] +
                           2.0 * inertia->mass * mbsri_dot3(inertia->com, inertia->com);
    return lambda > 0.0 ? (turning / (l * l) + 3.0 * inertia->mass) / lambda : INFINITY;
}

/* Whether the joint block D of body i is regular in every pose where J has orthonormal axes: a
 * rigid body with six rates behind a root at rest, without successors. J turns M, which leaves
 * Lambda as it is. So the smallest eigenvalue of D scaled to unit diagonal is 1 / k at least, and
 * the traces of its blocks are k times an entry at most, in the body's own metric; W <= k M in that
 * of the tree. */
static bool is_regular_in_every_pose(const mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i;
    const mbsr_inertia *inertia = &b->inertia;
    const bool last = i == m->bodies || m->body[i + 1].parent != i;
    if (b->d != 6 || b->n != 6 || b->pred.d != 0 || !last || b->mass.added ||
        inertia->kind != MBSR_INERTIA_SPATIAL || !(inertia->mass > 0.0) ||
        b->joint.table->position != mbsri_chain_position || b->lock.count > 0 ||
        !mbsri_chain_is_steady(b->pred.space, b->joint.param, b->joint.option))
        return false;
    const double *I = inertia->tensor,
                 l = sqrt((I[MBSR_XX] + I[MBSR_YY] + I[MBSR_ZZ]) / (3.0 * inertia->mass)),
                 own = l > 0.0 ? spread_of(inertia, l) : INFINITY;
    return mbsri_is_known_by_bound(&m->tree.plain->rule, 0.9 / own,
                                   spread_of(inertia, m->tree.plain->length), own);
}

/* The sweeps know how regular a body's inertia is about their own point, which is `arm` away from
 * the body's origin; there the same holds but for the norm of that translation, squared. */
void mbsri_bounded_prepare(const mbsr_model *m, mbsri_sweep_load *bounds)
{
    const mbsri_sweeps *tree = m->tree.plain;
    memset(bounds, 0, ((size_t)m->bodies + 1) * sizeof *bounds);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        double arm[3];
        bounds[i].bound[3] = is_regular_in_every_pose(m, i) ? 1.0 : 0.0;
        if (b->flags & MBSRI_BLOCK || !(b->soft > 0.0)) continue;
        mbsri_sweeps_own_origin(tree, m, i, arm);
        const double norm = 1.0 + mbsri_norm3(arm) / tree->length;
        bounds[i].bound[2] = b->soft * norm * norm;
    }
}

static void open_body(const mbsr_model *m, mbsr_data *d, int i, double *bound)
{
    const mbsri_body *b = m->body + i;
    const size_t dd = (size_t)b->d * (size_t)b->d;
    mbsri_copy(dd, d->M + b->dd, d->Mbar + b->dd);
    mbsri_copy((size_t)b->d, d->f + b->v, d->fbar + b->v);
    for (int k = 0; k < b->d; ++k) d->W[b->dd + (size_t)(k * (b->d + 1))] = 0.0;
    bound[0] = bound[1] = 0.0;
}

/* Whether J has rotations and translations along orthonormal axes each. */
static bool is_turned_unit(const double J[36])
{
    static const double rounding = 1e-6;
    double most = 0.0;
    for (int k = 0; k < 6; ++k) {
        const int own = k < 3 ? 0 : 3, other = 3 - own;
        for (int l = own; l <= k; ++l) {
            const double product = mbsri_dot3(J + 6 * k + own, J + 6 * l + own);
            most = fmax(most, fabs(product - (l == k ? 1.0 : 0.0)));
        }
        for (int l = other; l < other + 3; ++l) most = fmax(most, fabs(J[6 * k + l]));
    }
    return most < rounding;
}

/* Ranks are to be found, by this evaluation alone. */
static mbsri_sweep_run begin_ranks(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    d->single = true;
    d->accelerated = false;
    d->total_rank = m->nu;
    return (mbsri_sweep_run){.model = m,
                             .data = d,
                             .tree = m->tree.plain,
                             .load = bounds,
                             .rank = d->rank,
                             .tau = d->tau};
}

bool mbsri_bounded_free(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    bool free = m->rows == 0;
    for (int i = 1; i <= m->bodies && free; ++i)
        free = bounds[i].bound[3] > 0.0 && is_turned_unit(d->J + m->body[i].dn);
    if (!free) return false;
    const mbsri_sweep_run run = begin_ranks(m, d, bounds);
    for (int i = 1; i <= m->bodies; ++i) {
        d->rank[i] = 6;
        mbsri_zero(36, d->Jdot + m->body[i].dn);
    }
    return mbsri_sweeps_as_watched(&run);
}

bool mbsri_bounded_backward(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    const mbsri_sweep_run run = begin_ranks(m, d, bounds);
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->Mbar);
    mbsri_zero((size_t)m->root.d, d->fbar);
    for (int i = 1; i <= m->bodies; ++i) open_body(m, d, i, bounds[i].bound);
    for (int i = m->bodies; i >= 1; --i) {
        const double *bound = bounds[i].bound;
        double *above = bounds[m->body[i].parent].bound;
        if (!pass_bounded(&run, i)) return false;
        above[0] = fmax(above[0], bound[0]);
        above[1] += bound[1];
    }
    return mbsri_sweeps_as_watched(&run);
}

#endif
