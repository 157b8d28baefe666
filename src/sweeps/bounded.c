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

bool mbsri_bounded_backward(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    (void)m, (void)d, (void)bounds;
    return false;
}

#else

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

/* The sweeps know how regular a body's inertia is about their own point, which is `arm` away from
 * the body's origin; there the same holds but for the norm of that translation, squared. */
void mbsri_bounded_prepare(const mbsr_model *m, mbsri_sweep_load *bounds)
{
    const mbsri_sweeps *tree = m->tree.plain;
    memset(bounds, 0, ((size_t)m->bodies + 1) * sizeof *bounds);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        double arm[3];
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

bool mbsri_bounded_backward(const mbsr_model *m, mbsr_data *d, mbsri_sweep_load *bounds)
{
    const mbsri_sweep_run run = {.model = m,
                                 .data = d,
                                 .tree = m->tree.plain,
                                 .load = bounds,
                                 .rank = d->rank,
                                 .tau = d->tau};
    if (d->exactly) return false;
    d->single = true;
    d->accelerated = false;
    d->total_rank = m->nu;
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
