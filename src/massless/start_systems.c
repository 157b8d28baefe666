/* What a consistent start keeps, and its Newton systems: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/start_systems.h"

#include "massless/completion_elastic.h"
#include "massless/imbalance.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "recursion/closures.h"
#include "recursion/spans.h"

#include <math.h>

/* How many numbers s->columns needs. */
static size_t columns_size(const mbsr_model *m)
{
    size_t most = (size_t)m->nu;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t own = (size_t)((b->nq + b->n + 1) * b->n);
        if (b->joint.table->coordinate_rates && own > most) most = own;
    }
    return most;
}

int mbsri_start_open(mbsri_start *s, mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, rows = (size_t)m->rows,
                 size = (size_t)w->size, masses = mbsri_masses_size(m);
    const struct {
        double **at;
        size_t count;
    } vector[] = {{&s->per_place, nq},
                  {&s->target, nu},
                  {&s->beyond, nu},
                  {&s->missing, nu},
                  {&s->impulse, rows},
                  {&s->before, size},
                  {&s->impulse_before, rows},
                  {&s->load_before, rows},
                  {&s->step, size},
                  {&s->load_step, rows},
                  {&s->columns, columns_size(m)},
                  {&s->found, 2 * (size + 3 * rows)},
                  {&s->ways, 2 * MBSRI_WAYS * nu}};
    enum { VECTORS = sizeof vector / sizeof vector[0] };
    size_t total = masses;
    s->w = w;
    for (int k = 0; k < VECTORS; ++k) total += vector[k].count;
    s->memory = mbsri_allocate(&m->allocator, total * sizeof(double) + nu * sizeof(bool));
    if (!s->memory) {
        return mbsri_fail(&w->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %zu numbers", total);
    }
    double *next = s->memory;
    mbsri_masses_place(m, next, &s->masses);
    next += masses;
    for (int k = 0; k < VECTORS; ++k) {
        *vector[k].at = next;
        next += vector[k].count;
    }
    s->lacks = (bool *)(void *)next;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->nq; ++k)
            s->per_place[b->q + k] = 1.0 / mbsri_coordinate_span(&spans, m, b, false, k);
    }
    return MBSR_OK;
}

void mbsri_start_close(mbsri_start *s)
{
    if (s->memory) mbsri_release(&s->w->m->allocator, s->memory);
}

/* ---- Newton systems ---- */

/* Springs that are taken as they are have the force s of their gaps. */
static void take_springs(mbsr_completion *w)
{
    const mbsri_closure *c = w->m->closures.data;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int at = w->loops + c->row + k;
            if (mbsri_is_stiff(c, k)) w->y[at] = w->ahead.y[at];
        }
    }
}

int mbsri_start_evaluate(mbsri_start *s, bool own)
{
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int status = MBSR_OK;
    if (own) {
        status = mbsri_pack(&mbsri_form_momentum, m, w->d, w->t, w->y, w->y + w->rates, w->ahead.y);
        if (status) w->error = w->d->error;
        mbsri_copy((size_t)m->nu, w->ahead.y + m->nq, w->y + m->nq);
        if (!status) take_springs(w);
    }
    return status ? status : mbsri_completion_residual(w, w->t, w->y, w->yp);
}

void mbsri_start_rows(mbsri_start *s, bool forces, bool rates, bool gaps)
{
    const mbsr_completion *w = s->w;
    mbsri_zero((size_t)w->size, w->r);
    for (int k = w->rates; k < w->loops && forces; ++k)
        w->r[k] = s->lacks[k - w->rates] ? w->F[k] : 0.0;
    for (int k = w->loops; k < w->places && rates; ++k) w->r[k] = w->F[k];
    for (int k = w->places; k < w->size && gaps; ++k)
        w->r[k] = w->F[k] - (s->offset ? s->offset[k - w->places] : 0.0);
}

int mbsri_start_factor(mbsri_start *s)
{
    const int status = mbsri_completion_factor(s->w, MBSRI_NEAR);
    return status ? status : mbsri_completion_factor(s->w, MBSRI_FAR);
}

int mbsri_start_solve(mbsri_start *s, const double *momenta)
{
    mbsr_completion *w = s->w;
    double *const x[MBSRI_MATRICES] = {w->x, w->other};
    for (int j = MBSRI_NEAR; j < MBSRI_MATRICES; ++j) {
        for (int k = 0; k < w->m->nu && momenta; ++k)
            w->r[w->m->nq + k] = mbsri_completion_c(w, j) * momenta[k];
        const int status = mbsri_completion_solve(w, j, w->r, x[j]);
        if (status) return status;
    }
    mbsri_completion_part(w);
    return MBSR_OK;
}

double mbsri_start_extent(const mbsri_start *s, const double *dq)
{
    double largest = 0.0;
    for (int k = 0; k < s->w->m->nq; ++k) largest = fmax(largest, fabs(dq[k]) * s->per_place[k]);
    return largest;
}

bool mbsri_start_balances(mbsri_start *s)
{
    static const double rounding = 1e-10;
    mbsr_completion *w = s->w;
    if (mbsri_start_evaluate(s, true) ||
        mbsri_enter(w->m, w->d, true, MBSRI_STAGE_BACKWARD, "mbsr_dae_consistent"))
        return false;
    const double left = mbsri_largest_defect(w->m, w->d, false, 0.0, NULL);
    return left <= rounding * mbsri_largest_load(w->m, w->d);
}
