/* Solutions of the equations of motion with loops: see system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/system.h"

#include "algebra/dense.h"
#include "model/query.h"

/* Of the joint: e = g - J^T fbar, what the loops open past it get of it, fbar_pred -= H^T (fbar + G e). */
static void load_joint(mbsri_system *w, int i, double *work)
{
    const mbsri_body *b = w->m->body + i;
    const mbsr_data *d = w->d;
    const mbsri_passing *p = w->joint[i];
    double *fbar = w->fbar + b->v, *e = w->e + b->iu, *rate = work;
    mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, fbar, e);
    mbsri_zero((size_t)b->n, rate);
    mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, e, rate);
    for (int k = 0; p && k < p->count; ++k)
        w->s[p->id[k]] += mbsri_dot(b->n, p->X + k * b->n, rate);
    for (int k = 0; p && k < p->nulls; ++k)
        w->s[p->id[p->count + k]] = -mbsri_dot(b->n, p->N + k * b->n, e);
    mbsri_ax(b->d, b->n, 1.0, d->G + b->dg, e, fbar);
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, fbar, w->fbar + b->pred_v);
}

void mbsri_system_rates(mbsri_system *w, int i, double *work)
{
    const mbsri_body *b = w->m->body + i;
    const mbsr_data *d = w->d;
    const mbsri_passing *p = w->joint[i];
    double *a = w->a + b->v, *e = w->e + b->iu, *x = work;
    mbsri_zero((size_t)b->d, a);
    mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, w->a + b->pred_v, a);
    mbsri_atx(b->d, b->n, -1.0, d->U + b->dg, a, e);
    for (int k = 0; p && k < p->count; ++k)
        mbsri_ax(b->n, 1, -1.0, p->X + k * b->n, w->v + p->id[k], e);
    mbsri_zero((size_t)b->n, x);
    mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, e, x);
    for (int k = 0; p && k < p->nulls; ++k)
        mbsri_ax(b->n, 1, 1.0, p->N + k * b->n, w->v + p->id[p->count + k], x);
    mbsri_copy((size_t)b->n, x, e);
}

void mbsri_system_move(mbsri_system *w, int i)
{
    const mbsri_body *b = w->m->body + i;
    double *a = w->a + b->v;
    if (i > 0) {
        mbsri_zero((size_t)b->d, a);
        mbsri_ax(b->d, b->d_pred, -1.0, w->d->H + b->dp, w->a + b->pred_v, a);
        mbsri_ax(b->d, b->n, -1.0, w->d->J + b->dn, w->e + b->iu, a);
    }
    for (const mbsri_pivots *f = w->closing[i]; f; f = f->next)
        mbsri_pivots_backward(f, w->s, a, w->v);
}

void mbsri_system_solve(mbsri_system *w, const double *g, const double *b, double *x,
                        double *lambda)
{
    const mbsr_model *m = w->m;
    const size_t rows = (size_t)m->rows, nu = (size_t)m->nu;
    double *work = w->d->scratch;
    mbsri_gather(m, g, w->e);
    mbsri_copy(rows, b, w->s);
    mbsri_zero(nu, w->s + rows);
    mbsri_zero(rows + nu, w->v);
    mbsri_zero(m->size_v, w->fbar);
    for (int i = m->bodies; i >= 0; --i) {
        double *fbar = w->fbar + m->body[i].v;
        for (const mbsri_pivots *f = w->closing[i]; f; f = f->next)
            mbsri_pivots_forward(f, w->s, fbar);
        if (i > 0) load_joint(w, i, work);
    }
    mbsri_zero((size_t)m->root.d, w->a);
    for (int i = 0; i <= m->bodies; ++i) {
        if (i > 0) mbsri_system_rates(w, i, work);
        mbsri_system_move(w, i);
    }
    mbsri_scatter(m, w->e, x);
    mbsri_copy(rows, w->v, lambda);
    for (size_t k = 0; k < rows; ++k) {
        if (w->left_out[k]) lambda[k] = 0.0;
    }
}
