/* What a unit impulse on each joint rate changes it by, loops closed: see mobility.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Entries of the inverse of the equations (spread.h). Motions that nothing determines are found by
 * solving K x = K z for some z: what x and z differ by is one of them. */
#include "loops/mobility.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fronts/spread.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <math.h>

typedef struct mobility {
    mbsri_fronts w;
    double *out, *z; /* nu, in the order of the sweeps */
} mobility;

/* ---- motions that nothing determines ---- */

/* Rates that these have a part in have no mobility. */
static void mark_undetermined(mobility *x)
{
    mbsri_fronts *w = &x->w;
    const mbsr_model *m = w->m;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double *z = x->z, *free = z + m->nu;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = b->iu; k < b->iu + b->n; ++k)
            z[k] = (1.0 + 0.5 * sin(12.9898 * k)) * mbsri_rate_span(&spans, m, b, k - b->iu);
    }
    mbsri_copy((size_t)m->nu, z, free);
    mbsri_fronts_leave_free(w, free, free + m->nu);
    for (int k = 0; k < m->nu; ++k) {
        if (fabs(free[k]) > 1e-6 * z[k]) x->out[k] = -1.0;
    }
}

static bool prepare(mobility *x)
{
    const mbsr_model *m = x->w.m;
    const size_t nu = (size_t)m->nu, numbers = 5 * nu + (size_t)m->rows + 2 * m->size.v;
    x->out = mbsri_fronts_allocate(&x->w, numbers * sizeof *x->out);
    if (!x->out) return false;
    x->z = x->out + nu;
    return true;
}

static int find(mobility *x, double *result, const char *function)
{
    mbsri_fronts *w = &x->w;
    const mbsri_closure *c = w->m->closures.data;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k)
            w->left_out[c->row + k] = mbsri_is_loose(c, k) || w->d->dropped[c->row + k];
    }
    int status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_fronts_factor(w, NULL, function);
    if (status) return status;
    if (!prepare(x) || !mbsri_fronts_spread(w, NULL))
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d joint rates and %d rows of closures", function,
                          w->m->nu, w->m->rows);
    for (int k = 0; k < w->m->nu; ++k) x->out[k] = fmax(w->e[k], 0.0);
    if (w->frees > 0) mark_undetermined(x);
    status = mbsri_check_result(w->m, w->d, (size_t)w->m->nu, x->out, function);
    if (!status) mbsri_scatter(w->m, x->out, result);
    return status;
}

int mbsri_loops_mobility(const mbsr_model *m, mbsr_data *d, double *result, const char *function)
{
    mobility x = {.out = NULL};
    int status = mbsri_fronts_open(&x.w, m, d, true, function);
    if (!status) status = find(&x, result, function);
    mbsri_fronts_close(&x.w);
    return status;
}
