/* A consistent start from closed positions: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/closed_start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "algebra/pivots.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/refuse.h"
#include "massless/open.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"
#include "recursion/rounding.h"
#include "recursion/spans.h"

int mbsri_closed_start_open(mbsri_closed_start *s, const mbsr_model *m, mbsr_data *d)
{
    mbsr_error error = {.status = MBSR_OK};
    *s = (mbsri_closed_start){.m = m, .d = d};
    int status = mbsr_completion_create(m, NULL, &s->completion, &error);
    if (!status) status = mbsri_start_open(&s->search, s->completion);
    if (status && status != MBSR_ERR_NO_MEMORY) {
        d->error = error;
        return status;
    }
    const int numbers = m->nq + m->nu + m->rows + 1;
    if (!status) s->q = mbsri_allocate(&m->allocator, (size_t)numbers * sizeof *s->q);
    if (s->q) {
        s->u = s->q + m->nq;
        s->length = s->u + m->nu;
        return MBSR_OK;
    }
    return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_dae_consistent: no memory for Newton systems of %d coordinates",
                      m->nq + m->nu);
}

void mbsri_closed_start_close(mbsri_closed_start *s)
{
    if (!s->m) return;
    mbsri_release(&s->m->allocator, s->q);
    mbsri_start_close(&s->search);
    mbsr_completion_destroy(s->completion);
}

/* Rows of springs count for nothing. */
static void clear_springs(const mbsr_model *m, double *x)
{
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            if (mbsri_is_stiff(c, k)) x[c->row + k] = 0.0;
        }
    }
}

/* After the derivatives of the closures. */
static void find_lengths(const mbsri_closed_start *s)
{
    const mbsr_model *m = s->m;
    const mbsri_closure *c = m->closures.data;
    mbsri_zero((size_t)m->rows, s->length);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int l = 0; l < c->bodies; ++l) {
            const mbsri_body *b = m->body + c->body[l];
            const int rates = mbsri_reads_joints(c) ? b->n : 0;
            const double *C =
                rates > 0 ? s->d->closure_C + c->at + (size_t)((c->column[l] + b->d) * c->rows)
                          : NULL;
            for (int k = 0; k < c->rows; ++k) {
                double turn, move, *length = s->length + c->row + k;
                mbsri_row_parts(m, s->d, c, l, k, &turn, &move);
                mbsri_share(turn, move, m->typical.length, length);
                for (int j = 0; j < rates; ++j)
                    mbsri_share_of_joint(m, b, j, C[j * c->rows + k], length);
            }
        }
    }
}

/* Refuses velocities or accelerations that rows do not allow, those left out among them. */
static int check_rows(mbsri_closed_start *s, double t, const double *q, const double *u,
                      const double *udot)
{
    static const char name[] = "mbsr_dae_consistent";
    const mbsr_model *m = s->m;
    mbsr_data *d = s->d;
    double *rate = s->search.impulse_before, *gained = s->search.load_before;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_closure_rates(m, d, rate);
    if (status) return status;
    find_lengths(s);
    clear_springs(m, rate);
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    const double own = mbsri_span_rate(&spans);
    double size = own + mbsri_largest_rate(m, u);
    status = mbsri_refuse_left(m, d, rate, s->length, size, "velocity row", name);
    if (!status) status = mbsri_closure_bias(m, d, rate);
    if (status) return status;
    size = own * own + mbsri_largest_row(m, rate, s->length) + mbsri_largest_rate(m, udot);
    mbsri_closure_apply(m, d, udot, gained);
    for (int k = 0; k < m->rows; ++k) rate[k] += gained[k];
    clear_springs(m, rate);
    return mbsri_refuse_left(m, d, rate, s->length, size, "acceleration", name);
}

int mbsri_closed_start_find(mbsri_closed_start *s, double t, const double *offset, double *q,
                            double *u, double *udot, double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info)
{
    const mbsr_model *m = s->m;
    const mbsr_completion *w = s->completion;
    mbsri_verdict verdict;
    bool clear;
    mbsri_copy((size_t)m->nq, q, s->q);
    mbsri_copy((size_t)m->nu, u, s->u);
    s->search.opt = opt;
    s->search.info = info;
    s->search.offset = offset;
    s->search.given.q = s->q;
    s->search.given.u = s->u;
    s->search.given.load = lambda;
    int status = mbsri_start_find(&s->search, s->d, t, &clear);
    if (status) {
        s->d->error = w->error;
        return status;
    }
    mbsri_copy((size_t)m->nq, w->y, q);
    mbsri_copy((size_t)m->nu, w->y + w->rates, u);
    mbsri_copy((size_t)m->nu, w->rate + w->rates, udot);
    mbsri_copy((size_t)m->rows, w->yp + w->loops, lambda);
    clear_springs(m, lambda);
    if (!clear && w->kind.deficient)
        status = mbsri_refuse_open(m, s->d, t, q, u, "mbsr_dae_consistent", &verdict);
    if (!status && s->search.doubtful)
        status = mbsri_refuse_open(m, s->d, t, s->q, s->u, "mbsr_dae_consistent", &verdict);
    return status ? status : check_rows(s, t, q, u, udot);
}
