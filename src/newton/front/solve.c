/* Solving with the front: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Right-hand sides go the way of the rows, M v = h: L of what was eliminated is taken off, step by
 * step; of y rows h is what is missing, y = M v - h. Backwards, U gives the unknowns, and X the
 * motions of the bodies. Beside loops, refinement makes up for the digits that late pivots cost. Of
 * p, dp = d(M u) - w in the range of D, w = L (1 - P) r_u, and c dp = r_p + dP in its null space.
 */
#include "newton/front/assemble.h"
#include "newton/front/crowd.h"
#include "newton/front/floating.h"
#include "newton/front/refine.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/inlined.h"
#include "newton/linear/groups.h"
#include "recursion/closures.h"

#include <mbsrank/dae.h>

#include <math.h>

enum { REFINEMENTS = 5 };

/* ---- joints in space ---- */

/* Whether the joint of body i is one in space where nothing is below a massless joint: H and H' are
 * those of an arm r and its rate, and the predecessor's motion goes on as that of a rigid body
 * does. */
static bool is_arm(const mbsri_front *f, int i)
{
    const mbsri_front_step *s = f->plan.step + f->plan.position[i];
    const bool *below_massless = f->linear->below_massless;
    return s->axes && !below_massless[i] && !below_massless[f->model->body[i].parent] &&
           f->model->body[i].parent > 0;
}

/* y (6) += -H^T m of an arm, whose entries H has below its diagonal */
static void take_arm(const double H[36], const double m[6], double y[6])
{
    const double r[3] = {H[11], H[15], H[4]};
    mbsri_add_cross3(r, m + 3, y);
    for (int k = 0; k < 6; ++k) y[k] += m[k];
}

/* mbsri_linear_pass */
static void pass_arm(const mbsri_terms *k, const double *y, double *below)
{
    const double rate[3] = {k->Hdot[11], k->Hdot[15], k->Hdot[4]};
    take_arm(k->H, y, below);
    take_arm(k->H, y + 6, below + 6);
    mbsri_add_cross3(rate, y + 3, below + 6);
}

/* x of the body from that of its predecessor: its rotation and its rate move the rest. */
static void move_arm(const double *X, const double *above, double *x)
{
    double t[12];
    for (int r = 0; r < 12; ++r) t[r] = above[r];
    for (int l = 0; l < 3; ++l) {
        const double *turn = X + 12 * l, *rate = turn + 72;
        for (int r = 3; r < 12; ++r) t[r] += turn[r] * above[l];
        for (int r = 9; r < 12; ++r) t[r] += rate[r] * above[6 + l];
    }
    for (int r = 0; r < 12; ++r) x[r] = t[r];
}

/* ---- right-hand sides ---- */

/* w = L (1 - P) r_u / s of a joint or group into f->rates, and P r_u behind it; successors first.
 */
static void lift(mbsri_front *f, int i, const double *ru)
{
    const mbsr_model *m = f->model;
    double *w = f->rates, *null = w + m->nu, *range = null + m->nu;
    const double s = mbsri_linear_rate(f->linear, i);
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = m->body + g.member[l];
        mbsri_copy((size_t)of->n, ru + of->u, null + of->group.iu);
    }
    mbsri_linear_split(&k, g.n, f->linear->rank[i], null + b->group.iu, range + b->group.iu);
    for (int l = b->group.iu; l < b->group.iu + g.n; ++l) range[l] /= s;
    for (int l = g.members - 1; l > 0; --l) {
        const mbsri_body *of = m->body + g.member[l];
        const mbsri_terms own = mbsri_linear_terms(f->linear, g.member[l]);
        mbsri_atx(of->d, of->pred.d, -1.0, own.H, f->wbar + of->v, f->wbar + of->pred.v);
    }
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = m->body + g.member[l];
        const mbsri_terms own = l == 0 ? k : mbsri_linear_terms(f->linear, g.member[l]);
        mbsri_copy((size_t)of->n, range + of->group.iu, w + of->group.iu);
        mbsri_atx_often(of->d, of->n, 1.0, own.J, f->wbar + of->v, w + of->group.iu);
    }
    mbsri_ax_often(b->d, g.n, 1.0, k.G, range + b->group.iu, f->wbar + b->v);
    if (is_arm(f, i))
        take_arm(k.H, f->wbar + b->v, f->wbar + b->pred.v);
    else
        mbsri_atx(b->d, b->pred.d, -1.0, k.H, f->wbar + b->v, f->wbar + b->pred.v);
}

/* r of the rows of closures: of a stiff one, the equation is taken with the other sign. */
static void load_closures(mbsri_front *f, const double *r)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l)
            f->h[f->rows.count + c->row + l] = (mbsri_is_stiff(c, l) ? -1.0 : 1.0) * r[c->row + l];
        for (int l = 0; l < c->position_rows; ++l)
            f->h[f->rows.count + m->rows + c->position_row + l] = r[m->rows + c->position_row + l];
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
    double *a = f->h + at->a, *react = f->h + at->b, *momentum = f->h + at->momentum,
           *rate = f->h + at->rate;
    for (int l = 0; l < nq; ++l) f->h[at->place + l] = r[b->q + l];
    for (int l = 0; l < n; ++l) {
        const double tau = f->h[at->tau + l];
        momentum[l] = w[b->group.iu + l];
        rate[l] = tau - r[m->nq + b->u + l];
        react[l] = null[b->group.iu + l] - tau;
    }
    mbsri_atx_often(d, n, 1.0, k.J, y, momentum);
    mbsri_atx_often(d, n, 1.0, k.J, y + d, rate);
    mbsri_atx_often(d, n, 1.0, k.Jdot, y, rate);
    for (int l = 0; l < n; ++l) a[l] = f->c * momentum[l] - rate[l];
    if (f->linear->below_massless[i]) mbsri_atx(d, n, 1.0, k.J, y + 2 * d, react);
    if (is_arm(f, i))
        pass_arm(&k, y, f->h + above->y);
    else
        mbsri_linear_pass(b, &k, f->linear->below_massless[b->parent], y, f->h + above->y);
    if (m->position_rows == 0) return;
    const double *qdot =
        k.qdot + (size_t)(mbsri_linear_motions(f->linear, b->parent) + nq) * (size_t)nq;
    for (int l = 0; l < n; ++l) {
        const double moved =
            m->typical.weight[b->iu + l] * (f->h[at->push + l] - mbsri_dot(d, k.J + l * d, kappa));
        for (int j = 0; j < nq; ++j) f->h[at->place + j] -= qdot[l * nq + j] * moved;
    }
    mbsri_atx(d, b->pred.d, -1.0, k.H, kappa, f->h + above->kappa);
}

/* h of the rows in the range of D of a joint, or group, that is complete. */
static void load_range(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    for (int r = 0; r < f->linear->rank[i]; ++r) {
        double sum = 0.0;
        for (int l = 0; l < g.members; ++l) {
            const mbsri_body *of = f->model->body + g.member[l];
            for (int j = 0; j < of->n; ++j) {
                const int at = of->group.iu - b->group.iu + j;
                sum += k.X[r * g.n + at] * k.s[at] * f->h[f->names[g.member[l]].a + j];
            }
        }
        f->h[f->names[i].range_of_a + r] = sum;
    }
}

/* ---- the two sweeps ---- */

static void reduce(mbsri_front *f, int i, const double *r)
{
    const int k = f->plan.position[i];
    load_joint(f, i, r);
    if (f->linear->below_massless[i] && mbsri_linear_leads(f->linear, i)) load_range(f, i);
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

/* sums (2 n) += kept (2 n, columns) v */
MBSRI_INLINE void add_kept(const int n, int columns, const double *kept, const double *v,
                           double *momentum, double *rate)
{
    for (int j = 0; j < columns; ++j, kept += 2 * n) {
        for (int l = 0; l < n; ++l) momentum[l] += kept[l] * v[j];
        for (int l = 0; l < n; ++l) rate[l] += kept[n + l] * v[j];
    }
}

/* d(M u) - w, and dp by its rate, of the joint; v: of all columns of the step. */
static void find_momentum(mbsri_front *f, int k, const double *kept, const double *v)
{
    const mbsri_front_step *s = f->plan.step + k;
    const mbsri_body *b = f->model->body + s->body;
    const mbsri_front_names *at = f->names + s->body;
    double *momentum = f->rates + 2 * f->model->nu + b->group.iu, *rate = momentum + f->model->nu;
    const int n = b->n;
    for (int l = 0; l < n; ++l) momentum[l] = -f->h[at->momentum + l];
    for (int l = 0; l < n; ++l) rate[l] = -f->h[at->rate + l];
    if (n == 1) {
        double sum[2] = {momentum[0], rate[0]};
        add_kept(1, f->left[k].columns, kept, v, sum, sum + 1);
        momentum[0] = sum[0], rate[0] = sum[1];
    } else if (n == 6) {
        add_kept(6, f->left[k].columns, kept, v, momentum, rate);
    } else {
        add_kept(n, f->left[k].columns, kept, v, momentum, rate);
    }
    for (int l = 0; l < n; ++l) rate[l] /= f->c;
}

/* x.y, in four sums of which none waits for another */
static double row_product(int n, const double *x, const double *y)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    int k = 0;
    for (; k < n - 3; k += 4) {
        for (int l = 0; l < 4; ++l) sum[l] += x[k + l] * y[k + l];
    }
    double all = (sum[0] + sum[2]) + (sum[1] + sum[3]);
    for (; k < n; ++k) all += x[k] * y[k];
    return all;
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
        v[j] = (f->h[row[j]] - row_product(left->columns - j - 1, of + j + 1, v + j + 1)) / of[j];
        f->value[column[j]] = v[j];
    }
    find_momentum(f, k, U + left->done * left->columns, v);
}

/* u' of the joints of a complete group from what is in the range of D. */
static void spread(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    for (int l = 0; l < g.members; ++l) {
        const mbsri_body *of = f->model->body + g.member[l];
        for (int j = 0; j < of->n; ++j) {
            const int at = of->group.iu - b->group.iu + j;
            double sum = 0.0;
            for (int r = 0; r < f->linear->rank[i]; ++r)
                sum += k.X[r * g.n + at] * k.s[at] * f->value[f->names[i].range + r];
            f->value[f->names[g.member[l]].rates + j] = sum;
        }
    }
}

/* x = X z of body i. */
static void move_body(mbsri_front *f, int i)
{
    const mbsri_body *b = f->model->body + i;
    const mbsri_linear *w = f->linear;
    const mbsri_front_names *at = f->names + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int x = mbsri_linear_motions(w, i), above = mbsri_linear_motions(w, b->parent);
    double *to = f->value + at->x;
    mbsri_zero((size_t)x, to);
    if (is_arm(f, i))
        move_arm(k.x, f->value + f->names[b->parent].x, to);
    else if (b->parent > 0)
        mbsri_ax(x, above, 1.0, k.x, f->value + f->names[b->parent].x, to);
    mbsri_ax(x, b->nq, 1.0, k.x + above * x, f->value + at->q, to);
    mbsri_ax(x, b->n, 1.0, k.x + (above + b->nq) * x, f->value + at->u, to);
    if (w->below_massless[i])
        mbsri_ax(b->d, b->n, -1.0, k.J, f->value + at->rates, to + w->e[i] + b->d);
}

/* ---- delta ---- */

static void take_multipliers(const mbsri_front *f, const double *r, double *delta)
{
    const mbsr_model *m = f->model;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int l = 0; l < c->rows; ++l) {
            const int lambda = c->row + l, eta = m->rows + c->position_row + l;
            const bool dropped = f->linear->dropped[lambda], stiff = mbsri_is_stiff(c, l);
            const double K = c->def.stiffness[l], damping = c->def.damping[l];
            if (stiff)
                delta[lambda] = -f->value[f->columns.count + lambda] * K / (K + f->c * damping);
            else
                delta[lambda] = dropped ? r[lambda] : f->value[f->columns.count + lambda] / f->c;
            if (l < c->position_rows)
                delta[eta] = dropped ? r[eta] : f->value[f->columns.count + eta] / f->c;
        }
    }
}

static double sum_of_sizes(int n, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += fabs(x[k]);
    return sum;
}

/* dp of a joint or group: both equations hold for it to the rounding errors of (a). All of it is
 * taken from that whose row counts these less, beside what else is in that; what D does not take up
 * from F_p in any case. */
static void take_momentum(mbsri_front *f, int i, double *dp, double *rate, double *range)
{
    const mbsri_body *b = f->model->body + i;
    const int n = mbsri_linear_group(f->linear, i).n, rank = f->linear->rank[i];
    const mbsri_terms k = mbsri_linear_terms(f->linear, i);
    const double *w = f->rates + b->group.iu;
    double momentum = 0.0;
    for (int l = 0; l < n; ++l) momentum += fabs(dp[l] + w[l]);
    if (sum_of_sizes(n, w) + momentum > sum_of_sizes(n, rate)) {
        mbsri_copy((size_t)n, rate, dp);
    } else if (rank < n) {
        mbsri_linear_split(&k, n, rank, dp, range);
        mbsri_linear_split(&k, n, rank, rate, dp);
        for (int l = 0; l < n; ++l) dp[l] = range[l] + rate[l];
    }
}

/* dp of the joint of body i, or of the group that it leads, into the rates. */
static void take_momenta(mbsri_front *f, int i)
{
    const int nu = f->model->nu;
    double *dp = f->rates + 2 * nu + f->model->body[i].group.iu, *rate = dp + nu;
    if (mbsri_linear_leads(f->linear, i)) take_momentum(f, i, dp, rate, rate + nu);
}

static void take_unknowns(const mbsri_front *f, int i, double *dq, double *dp, double *du)
{
    const mbsri_body *b = f->model->body + i;
    mbsri_copy((size_t)b->nq, f->value + f->names[i].q, dq);
    mbsri_copy((size_t)b->n, f->rates + 2 * f->model->nu + b->group.iu, dp);
    mbsri_copy((size_t)b->n, f->value + f->names[i].u, du);
}

bool mbsri_front_iterates(const mbsri_front *f)
{
    return f->crowd && f->crowd->count > 0;
}

long mbsri_front_iterations(const mbsri_front *f)
{
    return f->crowd ? f->crowd->iterations : 0;
}

void mbsri_front_start(mbsri_front *f)
{
    mbsri_zero((size_t)f->rows.count, f->h);
    mbsri_zero(f->model->size.v, f->wbar);
}

void mbsri_front_reduce(mbsri_front *f, int i, const double *r)
{
    const mbsri_group g = mbsri_linear_group(f->linear, i);
    if (!mbsri_linear_leads(f->linear, i)) return;
    lift(f, i, r + f->model->nq + f->model->nu);
    for (int l = g.members - 1; l >= 0; --l) reduce(f, g.member[l], r);
}

/* Whether steps after this one, forces in pairs apart or what stands beside the front read the
 * motion of its body. */
static bool is_read(const mbsri_front *f, int k)
{
    return f->plan.step[k].children > 0 || f->served || mbsri_front_iterates(f);
}

void mbsri_front_substitute(mbsri_front *f, int i)
{
    substitute(f, f->plan.position[i]);
    if (f->linear->below_massless[i] && mbsri_linear_leads(f->linear, i)) spread(f, i);
    if (is_read(f, f->plan.position[i])) move_body(f, i);
}

void mbsri_front_finish(mbsri_front *f, double *delta)
{
    const mbsr_model *m = f->model;
    for (int i = 1; i <= m->bodies; ++i) {
        const bool floats = f->plan.step[f->plan.position[i]].floats;
        if ((!f->served || f->served[i]) && !floats) take_momenta(f, i);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        double *dp = delta + m->nq + m->body[i].u;
        if (!f->served || f->served[i]) take_unknowns(f, i, delta + m->body[i].q, dp, dp + m->nu);
    }
}

static void substitute_step(mbsri_front *f, int k, const double *r)
{
    if (f->plan.step[k].floats)
        mbsri_floating_substitute(f, k, r);
    else
        mbsri_front_substitute(f, f->plan.step[k].body);
}

/* Towards the last step; of a body that is alone all. */
static void reduce_step(mbsri_front *f, int k, const double *r)
{
    const bool alone = mbsri_front_is_alone(f, k);
    if (f->plan.step[k].floats)
        mbsri_floating_reduce(f, k, r);
    else if (alone)
        mbsri_front_reduce(f, f->plan.step[k].body, r);
    else
        reduce(f, f->plan.step[k].body, r);
    if (alone) substitute_step(f, k, r);
}

void mbsri_front_sweep(mbsri_front *f, const double *r)
{
    const mbsr_model *m = f->model;
    mbsri_front_start(f);
    if (mbsri_front_iterates(f)) mbsri_front_crowd_load(f);
    for (int i = m->bodies; i >= 1; --i) {
        const int k = f->plan.position[i];
        if (mbsri_linear_leads(f->linear, i) && !mbsri_front_is_alone(f, k) &&
            !f->plan.step[k].floats)
            lift(f, i, r + m->nq + m->nu);
    }
    load_closures(f, r + m->nq + 2 * m->nu);
    mbsri_floating_displace(f, r);
    for (int k = 0; k < f->plan.steps; ++k) reduce_step(f, k, r);
    for (int k = f->plan.steps - 1; k >= 0; --k)
        if (!mbsri_front_is_alone(f, k)) substitute_step(f, k, r);
}

static bool solve_front(mbsri_front *f, const double *r, double *delta)
{
    const int closures = f->model->nq + 2 * f->model->nu;
    const bool done = !mbsri_front_iterates(f) || mbsri_front_crowd_solve(f, r, mbsri_front_sweep);
    mbsri_front_sweep(f, r);
    mbsri_front_finish(f, delta);
    take_multipliers(f, r + closures, delta + closures);
    return done;
}

/* What is left of r, at most, beside the diagonal terms of its rows, and beside the largest rate in
 * those of closures. */
static double share(const mbsri_front *f, const double *r, const double *delta, const double *left)
{
    const mbsr_model *m = f->model;
    const int u = m->nq + m->nu, closures = u + m->nu, size = closures + m->rows + m->position_rows;
    double largest = 0.0, most = 0.0;
    for (int k = u; k < closures; ++k) largest = fmax(largest, fabs(delta[k]));
    for (int k = 0; k < size; ++k) {
        const double beside = k < u          ? fabs(f->c * delta[k])
                              : k < closures ? fabs(delta[k - m->nu])
                                             : largest;
        if (left[k] != 0.0) most = fmax(most, fabs(left[k]) / (fabs(r[k]) + beside));
    }
    return most;
}

bool mbsri_front_refine(mbsri_front *f, const mbsri_front_way *way, const double *r, double *delta)
{
    static const double enough = 1e-14, less = 0.5;
    const int size = mbsr_dae_size(f->model, MBSR_DAE_MOMENTUM);
    double *left = f->left_over, *change = left + size, before = HUGE_VAL;
    bool done = way->solve(f, r, delta);
    for (int step = 0; step < REFINEMENTS && f->linear->whole && done; ++step) {
        way->product(f->linear, delta, &f->vectors, left);
        for (int k = 0; k < size; ++k) left[k] = r[k] - left[k];
        const double now = way->share(f, r, delta, left);
        if (!(now > enough && now < less * before)) break;
        before = now;
        done = way->solve(f, left, change);
        for (int k = 0; k < size; ++k) delta[k] += change[k];
    }
    return done;
}

bool mbsri_front_solve(mbsri_front *f, const double *r, double *delta)
{
    static const mbsri_front_way way = {solve_front, mbsri_product, share};
    return mbsri_front_refine(f, &way, r, delta);
}
