/* Solutions of the equations of motion with loops: see fronts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fronts/fronts.h"

#include "algebra/dense.h"
#include "fronts/idle.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/mass_matrix.h"

/* ---- to the root ---- */

void mbsri_fronts_reduce(const mbsri_pivots *f, double *s)
{
    const int N = f->size + f->d;
    for (int p = 0; p < f->pivots; ++p) {
        const double *L = f->A + p * N, value = s[f->id[p]];
        if (value == 0.0) continue;
        for (int i = f->across[p] != 0.0 ? p + 2 : p + 1; i < N; ++i) s[f->id[i]] -= L[i] * value;
    }
}

/* Of the joint: e = g + J^T s, what the loops open past it get of it, s_pred -= H^T (s - G e). */
static void load_joint(mbsri_fronts *w, int k, double *work)
{
    const int i = w->plan->step[k].body;
    const mbsri_body *b = w->m->body + i;
    const mbsr_data *d = w->d;
    const mbsri_passing *p = w->passing[k];
    double *s = w->s + mbsri_motion_number(w, b), *e = w->e + b->iu, *rate = work;
    mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, s, e);
    mbsri_zero((size_t)b->n, rate);
    mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, e, rate);
    for (int l = 0; p && l < p->count; ++l)
        w->s[p->id[l]] += mbsri_dot(b->n, p->X + l * b->n, rate);
    for (int l = 0; p && l < p->nulls; ++l)
        w->s[p->id[p->count + l]] = -mbsri_dot(b->n, p->N + l * b->n, e);
    mbsri_ax(b->d, b->n, -1.0, d->G + b->dg, e, s);
    mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, s,
              w->s + mbsri_motion_number(w, w->m->body + b->parent));
}

/* ---- to the leaves ---- */

void mbsri_fronts_rates(mbsri_fronts *w, int k, double *work)
{
    const mbsri_body *b = w->m->body + w->plan->step[k].body;
    const mbsr_data *d = w->d;
    const mbsri_passing *p = w->passing[k];
    double *a = w->v + mbsri_motion_number(w, b), *e = w->e + b->iu, *x = work;
    mbsri_zero((size_t)b->d, a);
    mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp,
             w->v + mbsri_motion_number(w, w->m->body + b->parent), a);
    mbsri_atx(b->d, b->n, -1.0, d->U + b->dg, a, e);
    for (int l = 0; p && l < p->count; ++l)
        mbsri_ax(b->n, 1, -1.0, p->X + l * b->n, w->v + p->id[l], e);
    mbsri_zero((size_t)b->n, x);
    mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, e, x);
    for (int l = 0; p && l < p->nulls; ++l)
        mbsri_ax(b->n, 1, 1.0, p->N + l * b->n, w->v + p->id[p->count + l], x);
    mbsri_copy((size_t)b->n, x, e);
}

void mbsri_fronts_substitute(const mbsri_pivots *f, const double *s, double *v)
{
    const int N = f->size + f->d;
    for (int p = f->pivots - 1; p >= 0; --p) {
        const bool second = p > 0 && f->across[p - 1] != 0.0;
        const int first = second ? p - 1 : p;
        const double b = f->across[first], *D = f->A + first * (N + 1);
        double sum = s[f->id[first]] / D[0];
        if (b != 0.0) {
            const double c = D[N + 1], det = D[0] * c - b * b, r = s[f->id[first]],
                         t = s[f->id[first + 1]];
            sum = (second ? D[0] * t - b * r : c * r - b * t) / det;
        }
        const double *L = f->A + p * N;
        for (int i = b != 0.0 ? first + 2 : p + 1; i < N; ++i) sum -= L[i] * v[f->id[i]];
        v[f->id[p]] = sum;
    }
}

void mbsri_fronts_move(mbsri_fronts *w, int k)
{
    const int i = w->plan->step[k].body;
    const mbsri_body *b = w->m->body + i;
    if (i > 0) {
        double *a = w->v + mbsri_motion_number(w, b);
        mbsri_zero((size_t)b->d, a);
        mbsri_ax(b->d, b->pred.d, -1.0, w->d->H + b->dp,
                 w->v + mbsri_motion_number(w, w->m->body + b->parent), a);
        mbsri_ax(b->d, b->n, -1.0, w->d->J + b->dn, w->e + b->iu, a);
    }
    if (w->pivots[k]) mbsri_fronts_substitute(w->pivots[k], w->s, w->v);
}

void mbsri_fronts_solve(mbsri_fronts *w, const double *g, const double *b, double *x,
                        double *lambda)
{
    const mbsr_model *m = w->m;
    const size_t rows = (size_t)m->rows, nu = (size_t)m->nu;
    const int steps = w->plan->steps;
    double *work = w->d->scratch;
    mbsri_gather(m, g, w->e);
    mbsri_copy(rows, b, w->s);
    mbsri_zero(nu + m->size.v, w->s + rows);
    mbsri_zero(rows + nu + m->size.v, w->v);
    for (int k = 0; k < steps; ++k) {
        if (w->pivots[k]) mbsri_fronts_reduce(w->pivots[k], w->s);
        if (w->plan->step[k].body > 0) load_joint(w, k, work);
    }
    for (int k = steps - 1; k >= 0; --k) {
        if (w->plan->step[k].body > 0) mbsri_fronts_rates(w, k, work);
        mbsri_fronts_move(w, k);
    }
    mbsri_scatter(m, w->e, x);
    mbsri_idle_leave_out(w, w->v);
    mbsri_copy(rows, w->v, lambda);
    for (size_t k = 0; k < rows; ++k) {
        if (w->left_out[k]) lambda[k] = 0.0;
    }
}

void mbsri_fronts_leave_free(mbsri_fronts *w, double *x, double *work)
{
    const mbsr_model *m = w->m;
    double *g = work, *y = g + m->nu, *rows = y + m->nu;
    mbsri_mass_product(m, w->d, x, w->e, rows + m->rows);
    mbsri_scatter(m, w->e, g);
    mbsri_scatter(m, x, y);
    mbsri_closure_apply(m, w->d, y, rows);
    mbsri_fronts_solve(w, g, rows, y, rows);
    mbsri_gather(m, y, w->e);
    for (int k = 0; k < m->nu; ++k) x[k] -= w->e[k];
}
