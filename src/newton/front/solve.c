/* Solving with the front: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Right-hand sides go the way of the rows, M v = h: L of what was eliminated is taken off, step by step;
 * of y rows h is what is missing, y = M v - h. Backwards, U gives the unknowns, and X the motions of the
 * bodies. Where pivots had to wait, refinement makes up for the digits that others cost. Of p, dp =
 * d(M u) - w in the range of D, w = L (1 - P) r_u, and c dp = r_p + dP in its null space; the two come
 * from products. */
#include "newton/front/assemble.h"

#include "algebra/dense.h"
#include "recursion/closures.h"
#include "recursion/group.h"

#include <mbsrank/dae.h>

#include <math.h>

enum { REFINEMENTS = 3 };

/* ---- right-hand sides ---- */

/* w = L (1 - P) r_u into f->rates, and P r_u behind it; by groups. */
static void lift(mbsri_front *f, const double *ru)
{
    const mbsr_model *m = f->model;
    double *w = f->rates, *null = w + m->nu, *range = null + m->nu;
    mbsri_zero(m->size_v, f->wbar);
    for (int i = 1; i <= m->bodies; ++i)
        mbsri_copy((size_t)m->body[i].n, ru + m->body[i].u, null + m->body[i].ig);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const mbsri_terms k = mbsri_linear_terms(f->linear, i);
        const bool group = f->linear->coupled[i];
        const int n = group ? b->group_n : b->n;
        const int *member, members = mbsri_front_members(f, i, &member);
        if (group && b->head != i) continue;
        mbsri_linear_split(&k, n, f->linear->rank[i], null + b->ig, range + b->ig);
        for (int l = members - 1; l >= 0; --l) {
            const mbsri_body *of = m->body + member[l];
            const mbsri_terms own = mbsri_linear_terms(f->linear, member[l]);
            if (l > 0)
                mbsri_atx(of->d, of->d_pred, -1.0, own.H, f->wbar + of->v, f->wbar + of->pred_v);
        }
        for (int l = 0; l < members; ++l) {
            const mbsri_body *of = m->body + member[l];
            const mbsri_terms own = mbsri_linear_terms(f->linear, member[l]);
            mbsri_copy((size_t)of->n, range + of->ig, w + of->ig);
            mbsri_atx(of->d, of->n, 1.0, own.J, f->wbar + of->v, w + of->ig);
        }
        mbsri_ax(b->d, n, 1.0, k.G, range + b->ig, f->wbar + b->v);
        mbsri_atx(b->d, b->d_pred, -1.0, k.H, f->wbar + b->v, f->wbar + b->pred_v);
    }
}

/* r of the rows of closures: of a stiff one, the equation is taken with the other sign. */
static void load_closures(mbsri_front *f, const double *r)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l)
            f->h[f->row_count + c->row + l] = (mbsri_is_stiff(c, l) ? -1.0 : 1.0) * r[c->row + l];
        for (int l = 0; l < c->held; ++l)
            f->h[f->row_count + m->rows + c->held_row + l] = r[m->rows + c->held_row + l];
    }
}

/* h of the joint's rows, and of y of the predecessor, from that of y. */
static void load_joint(mbsri_front *f, int i, const double *r)
{
    const mbsr_model *m = f->model;
    const mbsri_body *b = m->body + i;
    const mbsri_front_names *at = f->names + i, *above = f->names + b->parent;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const int d = b->d, n = b->n, nq = b->nq;
    const double *y = f->h + at->y, *kappa = f->h + at->kappa, *w = f->rates, *null = w + m->nu;
    double *a = f->h + at->a, *react = f->h + at->b;
    for (int l = 0; l < nq; ++l) f->h[at->place + l] = r[b->q + l];
    for (int l = 0; l < n; ++l) {
        const double tau = f->h[at->tau + l];
        a[l] = r[m->nq + b->u + l] + f->c * w[b->ig + l] - tau;
        react[l] = null[b->ig + l] - tau;
    }
    mbsri_atx(d, n, f->c, k.J, y, a);
    mbsri_atx(d, n, -1.0, k.J, y + d, a);
    mbsri_atx(d, n, -1.0, k.Jdot, y, a);
    if (f->linear->deep[i]) mbsri_atx(d, n, 1.0, k.J, y + 2 * d, react);
    mbsri_linear_pass(b, &k, f->linear->deep[b->parent], y, f->h + above->y);
    if (m->held == 0) return;
    const double *qdot =
        k.qdot + (size_t)(mbsri_linear_motions(f->linear, b->parent) + nq) * (size_t)nq;
    for (int l = 0; l < n; ++l) {
        const double moved =
            m->weight[b->iu + l] * (f->h[at->push + l] - mbsri_dot(d, k.J + l * d, kappa));
        for (int j = 0; j < nq; ++j) f->h[at->place + j] -= qdot[l * nq + j] * moved;
    }
    mbsri_atx(d, b->d_pred, -1.0, k.H, kappa, f->h + above->kappa);
}

/* h of the rows in the range of D of a joint, or group, that is complete. */
static void load_range(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const int *member, members = mbsri_front_members(f, i, &member),
                       n = f->linear->coupled[i] ? b->group_n : b->n;
    for (int r = 0; r < f->linear->rank[i]; ++r) {
        double sum = 0.0;
        for (int l = 0; l < members; ++l) {
            const mbsri_body *of = f->model->body + member[l];
            for (int j = 0; j < of->n; ++j) {
                const int at = of->ig - b->ig + j;
                sum += k.X[r * n + at] * k.s[at] * f->h[f->names[member[l]].a + j];
            }
        }
        f->h[f->names[i].range_of_a + r] = sum;
    }
}

/* ---- the two sweeps ---- */

static void reduce(mbsri_front *f, int k)
{
    const mbsri_front_left *left = f->left + k;
    const int *row = f->numbers + f->plan.step[k].numbers;
    const double *L = f->LU + f->plan.step[k].LU;
    double *h = f->local;
    for (int l = 0; l < left->rows; ++l) h[l] = f->h[row[l]];
    for (int j = 0; j < left->done; ++j) {
        const double *factor = L + (size_t)(j * left->rows);
        for (int l = j + 1; l < left->rows; ++l) h[l] -= factor[l] * h[j];
    }
    for (int l = 0; l < left->rows; ++l) f->h[row[l]] = h[l];
}

static void substitute(mbsri_front *f, int k)
{
    const mbsri_front_left *left = f->left + k;
    const int *row = f->numbers + f->plan.step[k].numbers, *column = row + left->rows;
    const double *U = f->LU + f->plan.step[k].LU + (size_t)left->done * (size_t)left->rows;
    double *v = f->local;
    for (int l = left->done; l < left->columns; ++l) v[l] = f->value[column[l]];
    for (int j = left->done - 1; j >= 0; --j) {
        const double *of = U + (size_t)(j * left->columns);
        v[j] = (f->h[row[j]] - mbsri_dot(left->columns - j - 1, of + j + 1, v + j + 1)) / of[j];
        f->value[column[j]] = v[j];
    }
}

/* u' of the joints of a complete group from what is in the range of D. */
static void spread(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const int *member, members = mbsri_front_members(f, i, &member),
                       n = f->linear->coupled[i] ? b->group_n : b->n;
    for (int l = 0; l < members; ++l) {
        const mbsri_body *of = f->model->body + member[l];
        for (int j = 0; j < of->n; ++j) {
            const int at = of->ig - b->ig + j;
            double sum = 0.0;
            for (int r = 0; r < f->linear->rank[i]; ++r)
                sum += k.X[r * n + at] * k.s[at] * f->value[f->names[i].range + r];
            f->value[f->names[member[l]].rates + j] = sum;
        }
    }
}

/* x = X z of body i. */
static void move(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_linear *w = f->linear;
    const mbsri_front_names *at = f->names + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int x = mbsri_linear_motions(w, i), above = mbsri_linear_motions(w, b->parent);
    double *to = f->value + at->x;
    mbsri_zero((size_t)x, to);
    if (b->parent > 0) mbsri_ax(x, above, 1.0, k.x, f->value + f->names[b->parent].x, to);
    mbsri_ax(x, b->nq, 1.0, k.x + above * x, f->value + at->q, to);
    mbsri_ax(x, b->n, 1.0, k.x + (above + b->nq) * x, f->value + at->u, to);
    if (w->deep[i]) mbsri_ax(b->d, b->n, -1.0, k.J, f->value + at->rates, to + w->e[i] + b->d);
}

/* ---- delta ---- */

static void take_multipliers(const mbsri_front *f, const double *r, double *delta)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l) {
            const int lambda = c->row + l, eta = m->rows + c->held_row + l;
            const bool dropped = f->linear->dropped[lambda], stiff = mbsri_is_stiff(c, l);
            const double K = c->def.stiffness[l], damping = c->def.damping[l];
            if (stiff)
                delta[lambda] = -f->value[f->column_count + lambda] * K / (K + f->c * damping);
            else
                delta[lambda] = dropped ? r[lambda] : f->value[f->column_count + lambda] / f->c;
            if (l < c->held) delta[eta] = dropped ? r[eta] : f->value[f->column_count + eta] / f->c;
        }
    }
}

static double sum_of_sizes(int n, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += fabs(x[k]);
    return sum;
}

/* dp of a joint or group: both equations hold for it to the rounding errors of (a). All of it is taken from
 * that whose row counts these less, beside what else is in that; what D does not take up from F_p in any case. */
static void take_momentum(mbsri_front *f, int i, double *dp, double *rate, double *range)
{
    const mbsri_body *b = f->model->body + i;
    const int n = f->linear->coupled[i] ? b->group_n : b->n, rank = f->linear->rank[i];
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const double *w = f->rates + b->ig, *momentum = f->vectors.momentum + b->ig;
    if (sum_of_sizes(n, w) + sum_of_sizes(n, momentum) > sum_of_sizes(n, rate)) {
        mbsri_copy((size_t)n, rate, dp);
    } else if (rank < n) {
        mbsri_linear_split(&k, n, rank, dp, range);
        mbsri_linear_split(&k, n, rank, rate, dp);
        for (int l = 0; l < n; ++l) dp[l] = range[l] + rate[l];
    }
}

/* dp of all joints: defect is the product with the rest of delta. */
static void take_momenta(mbsri_front *f, const double *r, double *delta)
{
    const mbsr_model *m = f->model;
    double *w = f->rates, *dp = w + m->nu, *rate = dp + m->nu, *range = rate + m->nu;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int l = 0; l < b->n; ++l) {
            dp[b->ig + l] = f->vectors.momentum[b->ig + l] - w[b->ig + l];
            rate[b->ig + l] = (r[m->nq + b->u + l] - f->defect[m->nq + b->u + l]) / f->c;
        }
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (!f->linear->coupled[i] || b->head == i)
            take_momentum(f, i, dp + b->ig, rate + b->ig, range + b->ig);
    }
    for (int i = 1; i <= m->bodies; ++i)
        mbsri_copy((size_t)m->body[i].n, dp + m->body[i].ig, delta + m->nq + m->body[i].u);
}

static void solve(mbsri_front *f, const double *r, double *delta)
{
    const mbsr_model *m = f->model;
    const int closures = m->nq + 2 * m->nu;
    mbsri_zero((size_t)f->row_count, f->h);
    lift(f, r + m->nq + m->nu);
    load_closures(f, r + closures);
    for (int k = 0; k < f->plan.steps; ++k) {
        const int i = f->plan.step[k].body;
        load_joint(f, i, r);
        if (f->linear->deep[i] && (!f->linear->coupled[i] || m->body[i].head == i))
            load_range(f, i);
        reduce(f, k);
    }
    for (int k = f->plan.steps - 1; k >= 0; --k) {
        const int i = f->plan.step[k].body;
        substitute(f, k);
        if (f->linear->deep[i] && (!f->linear->coupled[i] || m->body[i].head == i)) spread(f, i);
        move(f, i);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_copy((size_t)b->nq, f->value + f->names[i].q, delta + b->q);
        mbsri_copy((size_t)b->n, f->value + f->names[i].u, delta + m->nq + m->nu + b->u);
        mbsri_zero((size_t)b->n, delta + m->nq + b->u);
    }
    take_multipliers(f, r + closures, delta + closures);
    mbsri_apply(f->linear, delta, &f->vectors, f->defect);
    take_momenta(f, r, delta);
}

/* Whether what is left of r counts beside the diagonal terms of its rows, and beside the largest rate in those
 * of closures. */
static bool counts(const mbsri_front *f, const double *r, const double *delta, const double *left)
{
    static const double small = 1e-12;
    const mbsr_model *m = f->model;
    const int u = m->nq + m->nu, closures = u + m->nu, size = closures + m->rows + m->held;
    double largest = 0.0;
    for (int k = u; k < closures; ++k) largest = fmax(largest, fabs(delta[k]));
    for (int k = 0; k < size; ++k) {
        const double beside = k < u          ? fabs(f->c * delta[k])
                              : k < closures ? fabs(delta[k - m->nu])
                                             : largest;
        if (fabs(left[k]) > small * (fabs(r[k]) + beside)) return true;
    }
    return false;
}

void mbsri_front_solve(mbsri_front *f, const double *r, double *delta)
{
    const int size = mbsr_dae_size(f->model, MBSR_DAE_MOMENTUM);
    double *left = f->left_over, *change = left + size;
    solve(f, r, delta);
    for (int step = 0; step < REFINEMENTS && f->handed_on; ++step) {
        mbsri_product(f->linear, delta, &f->vectors, left);
        for (int k = 0; k < size; ++k) left[k] = r[k] - left[k];
        if (!counts(f, r, delta, left)) return;
        solve(f, left, change);
        for (int k = 0; k < size; ++k) delta[k] += change[k];
    }
}
