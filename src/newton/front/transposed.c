/* Solutions with the transposed matrix: see transposed.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A solution (solve.c) is a row of linear steps, from r by way of h and of the motions to delta.
 * Here each is transposed, the last first: `value` and `h` hold what v says of a motion or of a
 * right-hand side. So this file is that one backwards:
 *
 *   b += A a  becomes  a^T += A^T b^T */
#include "newton/front/transposed.h"

#include "algebra/dense.h"
#include "newton/front/assemble.h"
#include "newton/front/refine.h"
#include "newton/linear/groups.h"
#include "newton/linear/product_transposed.h"
#include "recursion/closures.h"

#include <math.h>

/* ---- delta ---- */

/* What multipliers of v say of those that were solved for, and of r where they are left out. */
static void take_multipliers(const mbsri_front *f, const double *v, double *x)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l) {
            const int lambda = c->row + l, eta = m->rows + c->position_row + l;
            const bool dropped = f->linear->dropped[lambda], stiff = mbsri_is_stiff(c, l);
            const double K = c->def.stiffness[l], damping = c->def.damping[l];
            double *of = f->value + f->columns.count;
            x[lambda] = dropped && !stiff ? v[lambda] : 0.0;
            of[lambda] =
                stiff ? -v[lambda] * K / (K + f->c * damping) : (dropped ? 0.0 : v[lambda] / f->c);
            if (l >= c->position_rows) continue;
            x[eta] = dropped ? v[eta] : 0.0;
            of[eta] = dropped ? 0.0 : v[eta] / f->c;
        }
    }
}

/* Of dp, what is in the range of D is d(M u) - w, the rest the rate of p. */
static void take_momentum(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const int n = mbsri_linear_group(f->linear, i).n;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    double *momentum = f->rates + 2 * f->model->nu + b->group.iu, *rate = momentum + f->model->nu;
    mbsri_linear_split_transposed(&k, n, f->linear->rank[i], momentum, rate);
}

static void take_all(mbsri_front *f, const double *v)
{
    const mbsr_model *m = f->model;
    mbsri_zero((size_t)(f->columns.count + m->rows + m->position_rows), f->value);
    mbsri_zero((size_t)(f->rows.count + m->rows + m->position_rows), f->h);
    mbsri_zero(5 * (size_t)m->nu, f->rates);
    mbsri_zero(m->size.v, f->wbar);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_copy((size_t)b->nq, v + b->q, f->value + f->names[i].q);
        mbsri_copy((size_t)b->n, v + m->nq + m->nu + b->u, f->value + f->names[i].u);
        mbsri_copy((size_t)b->n, v + m->nq + b->u, f->rates + 2 * m->nu + b->group.iu);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (mbsri_linear_leads(f->linear, i)) take_momentum(f, i);
    }
}

/* ---- the two sweeps ---- */

/* x = X z of body i. */
static void move_body(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_linear *w = f->linear;
    const mbsri_front_names *at = f->names + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int x = mbsri_linear_motions(w, i), above = mbsri_linear_motions(w, b->parent);
    const double *from = f->value + at->x;
    if (b->parent > 0) mbsri_atx(x, above, 1.0, k.x, from, f->value + f->names[b->parent].x);
    mbsri_atx(x, b->nq, 1.0, k.x + above * x, from, f->value + at->q);
    mbsri_atx(x, b->n, 1.0, k.x + (above + b->nq) * x, from, f->value + at->u);
    if (w->below_massless[i])
        mbsri_atx(b->d, b->n, -1.0, k.J, from + w->e[i] + b->d, f->value + at->rates);
}

/* u' of the joints of a complete group from what is in the range of D; or, of rows, (a) in that
 * range from (a). */
static void spread(mbsri_front *f, int i, bool rows)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    double *range = rows ? f->h + f->names[i].range_of_a : f->value + f->names[i].range;
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = f->model->body + g.member[l];
        const mbsri_front_names *at = f->names + g.member[l];
        double *whole = rows ? f->h + at->a : f->value + at->rates;
        for (int j = 0; j < of->n; ++j) {
            const int place = of->group.iu - b->group.iu + j;
            for (int r = 0; r < f->linear->rank[i]; ++r) {
                const double weight = k.X[r * g.n + place] * k.s[place];
                if (rows)
                    whole[j] += weight * range[r];
                else
                    range[r] += weight * whole[j];
            }
        }
    }
}

/* d(M u) - w, and dp by its rate, of the joint: into v of all columns of the step. */
static void find_momentum(mbsri_front *f, int k, const double *kept, double *v)
{
    const mbsri_body *b = f->model->body + f->plan.step[k].body;
    const mbsri_front_names *at = f->names + f->plan.step[k].body;
    const int n = b->n;
    double *momentum = f->rates + 2 * f->model->nu + b->group.iu, *rate = momentum + f->model->nu;
    for (int l = 0; l < n; ++l) {
        rate[l] /= f->c;
        f->h[at->momentum + l] -= momentum[l];
        f->h[at->rate + l] -= rate[l];
    }
    for (int j = 0; j < f->left[k].columns; ++j, kept += 2 * n)
        v[j] += mbsri_dot(n, kept, momentum) + mbsri_dot(n, kept + n, rate);
}

static void substitute(mbsri_front *f, int k)
{
    const mbsri_front_left *left = f->left + k;
    const int *row = f->numbers + f->plan.step[k].numbers, *column = row + left->rows;
    const double *U = f->LU + f->plan.step[k].LU + (size_t)left->done * (size_t)left->rows;
    double *v = f->local;
    for (int l = 0; l < left->columns; ++l) v[l] = f->value[column[l]];
    find_momentum(f, k, U + left->done * left->columns, v);
    for (int j = 0; j < left->done; ++j) {
        const double *of = U + (size_t)(j * left->columns), h = v[j] / of[j];
        f->h[row[j]] += h;
        for (int l = j + 1; l < left->columns; ++l) v[l] -= of[l] * h;
    }
    for (int l = left->done; l < left->columns; ++l) f->value[column[l]] = v[l];
}

/* What h of the step's rows says of those that its unknowns stand in. */
static void reduce(mbsri_front *f, int k)
{
    const mbsri_front_left *left = f->left + k;
    const int *row = f->numbers + f->plan.step[k].numbers;
    const double *L = f->LU + f->plan.step[k].LU;
    double *h = f->local;
    for (int l = 0; l < left->rows; ++l) h[l] = f->h[row[l]];
    for (int j = left->done - 1; j >= 0; --j)
        h[j] -= mbsri_dot(left->rows - j - 1, L + (size_t)(j * left->rows) + j + 1, h + j + 1);
    for (int l = 0; l < left->done; ++l) f->h[row[l]] = h[l];
}

/* ---- right-hand sides ---- */

/* y_pi += B y */
static void pass_back(mbsri_front *f, int i)
{
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    mbsri_linear_pass_transposed(f->model->body + i, &k,
                                 f->linear->below_massless[f->model->body[i].parent],
                                 f->h + f->names[f->model->body[i].parent].y, f->h + f->names[i].y);
}

/* What eta makes of the joint's places, and of the loads above. */
static void push_back(mbsri_front *f, int i)
{
    const mbsr_model *m = f->model;
    const mbsri_body *b = m->body + i;
    const mbsri_front_names *at = f->names + i, *above = f->names + b->parent;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const int nq = b->nq;
    const double *qdot =
        k.qdot + (size_t)(mbsri_linear_motions(f->linear, b->parent) + nq) * (size_t)nq;
    double *kappa = f->h + at->kappa;
    for (int l = 0; l < b->n; ++l) {
        const double moved =
            -m->typical.weight[b->iu + l] * mbsri_dot(nq, qdot + l * nq, f->h + at->place);
        f->h[at->push + l] += moved;
        for (int j = 0; j < b->d; ++j) kappa[j] -= k.J[l * b->d + j] * moved;
    }
    mbsri_ax(b->d, b->pred.d, -1.0, k.H, f->h + above->kappa, kappa);
}

/* h of the joint's rows, and of y of the predecessor, into those of y and into x. */
static void load_joint(mbsri_front *f, int i, double *x)
{
    const mbsr_model *m = f->model;
    const mbsri_body *b = m->body + i;
    const mbsri_front_names *at = f->names + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const int d = b->d, n = b->n;
    double *y = f->h + at->y, *w = f->rates, *null = w + m->nu;
    const double *a = f->h + at->a, *react = f->h + at->b;
    if (m->position_rows > 0) push_back(f, i);
    pass_back(f, i);
    for (int l = 0; l < n; ++l) {
        const double momentum = f->h[at->momentum + l] + f->c * a[l],
                     rate = f->h[at->rate + l] - a[l];
        f->h[at->tau + l] += rate - react[l];
        x[m->nq + b->u + l] = -rate;
        w[b->group.iu + l] = momentum;
        null[b->group.iu + l] = react[l];
        for (int j = 0; j < d; ++j) {
            y[j] += k.J[l * d + j] * momentum + k.Jdot[l * d + j] * rate;
            y[d + j] += k.J[l * d + j] * rate;
        }
        for (int j = 0; j < d && f->linear->below_massless[i]; ++j)
            y[2 * d + j] += k.J[l * d + j] * react[l];
    }
    for (int l = 0; l < b->nq; ++l) x[b->q + l] = f->h[at->place + l];
}

/* w = L (1 - P) r_u / s of a joint or group, and P r_u behind it: into r_u, predecessors first. */
static void lift(mbsri_front *f, int i, double *ru)
{
    const mbsr_model *m = f->model;
    double *w = f->rates, *null = w + m->nu, *range = null + m->nu, *rest = range + m->nu;
    const double s = mbsri_linear_rate(f->linear, i);
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    mbsri_ax(b->d, b->pred.d, -1.0, k.H, f->wbar + b->pred.v, f->wbar + b->v);
    mbsri_copy((size_t)g.n, w + b->group.iu, range + b->group.iu);
    mbsri_atx(b->d, g.n, 1.0, k.G, f->wbar + b->v, range + b->group.iu);
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = m->body + g.member[l];
        const mbsri_terms own = mbsri_linear_terms(f->linear, g.member[l]);
        mbsri_ax(of->d, of->n, 1.0, own.J, w + of->group.iu, f->wbar + of->v);
        if (l > 0) mbsri_ax(of->d, of->pred.d, -1.0, own.H, f->wbar + of->pred.v, f->wbar + of->v);
    }
    for (int l = b->group.iu; l < b->group.iu + g.n; ++l) {
        range[l] /= s;
        null[l] -= range[l];
    }
    mbsri_linear_split_transposed(&k, g.n, f->linear->rank[i], null + b->group.iu,
                                  rest + b->group.iu);
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = m->body + g.member[l];
        for (int j = 0; j < of->n; ++j)
            ru[of->u + j] = range[of->group.iu + j] + rest[of->group.iu + j];
    }
}

/* r of the rows of closures. */
static void load_closures(const mbsri_front *f, double *x)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l)
            x[c->row + l] += (mbsri_is_stiff(c, l) ? -1.0 : 1.0) * f->h[f->rows.count + c->row + l];
        for (int l = 0; l < c->position_rows; ++l)
            x[m->rows + c->position_row + l] += f->h[f->rows.count + m->rows + c->position_row + l];
    }
}

static bool solve_transposed(mbsri_front *f, const double *v, double *x)
{
    const mbsr_model *m = f->model;
    const int closures = m->nq + 2 * m->nu;
    take_all(f, v);
    take_multipliers(f, v + closures, x + closures);
    for (int k = 0; k < f->plan.steps; ++k) {
        const int i = f->plan.step[k].body;
        move_body(f, i);
        if (f->linear->below_massless[i] && mbsri_linear_leads(f->linear, i)) spread(f, i, false);
        substitute(f, k);
    }
    for (int k = f->plan.steps - 1; k >= 0; --k) {
        const int i = f->plan.step[k].body;
        reduce(f, k);
        if (f->linear->below_massless[i] && mbsri_linear_leads(f->linear, i)) spread(f, i, true);
        load_joint(f, i, x);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (mbsri_linear_leads(f->linear, i)) lift(f, i, x + m->nq + m->nu);
    }
    load_closures(f, x + closures);
    return true;
}

/* ---- refinement ---- */

/* What is left of v, at most, beside the terms that are there in any model. */
static double share(const mbsri_front *f, const double *v, const double *x, const double *left)
{
    const mbsr_model *m = f->model;
    const int u = m->nq + m->nu, closures = u + m->nu;
    double most = 0.0, places = 0.0, momenta = 0.0;
    for (int k = 0; k < m->nq; ++k) places = fmax(places, fabs(f->c * x[k]));
    for (int k = m->nq; k < u; ++k) momenta = fmax(momenta, fabs(f->c * x[k]));
    for (int k = 0; k < closures + m->rows + m->position_rows; ++k) {
        const double beside = k < m->nq                ? fabs(f->c * x[k])
                              : k < u                  ? fmax(fabs(f->c * x[k]), fabs(x[k + m->nu]))
                              : k < closures           ? places / fabs(f->c)
                              : k < closures + m->rows ? momenta
                                                       : places;
        if (left[k] != 0.0) most = fmax(most, fabs(left[k]) / (fabs(v[k]) + beside));
    }
    return most;
}

void mbsri_front_solve_transposed(mbsri_front *f, const double *v, double *x)
{
    static const mbsri_front_way way = {solve_transposed, mbsri_product_transposed, share};
    (void)mbsri_front_refine(f, &way, v, x);
}
