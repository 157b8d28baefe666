/* Accelerations corrected by inverse dynamics, and the error left in them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the residual r = tau - (inverse dynamics of u') the correction solves M du = r. That is
 * forward dynamics of the changes f, kII and r, here with f = kII = 0:
 *
 *   m_i  = f_i + Mbar_i kII_i - sum of H_j^T m_j,   e_i = r_i - J_i^T m_i,   m_i += G_i e_i
 *   du_i = D_i^+ (e_i - U_i^T H_i a_pi),            a_i = -(H_i a_pi + J_i du_i + kII_i)
 *
 * The residual is no more exact than the forces that balance in it. So what is left is the last
 * correction and what the same recursion makes of rounding errors: changes of random signs as large
 * as machine precision times what is added up to f, kII (that is, to A) and tau (sizes.h), three
 * times, of which the root of the mean square is taken. */
#include "recursion/refine.h"

#include "algebra/dense.h"
#include "model/query.h"
#include "recursion/group.h"
#include "recursion/inverse.h"
#include "recursion/sizes.h"

#include <float.h>
#include <math.h>

enum { SAMPLES = 3 };

/* Changes of f and kII of body i and of tau of its joint. */
typedef struct changes {
    double *f, *kII, *tau;
} changes;

/* None but r. */
static void refined_residual(const mbsri_body *b, const mbsr_data *d, const changes *c)
{
    mbsri_zero((size_t)b->d, c->f);
    mbsri_zero((size_t)b->d, c->kII);
    for (int k = 0; k < b->n; ++k) c->tau[k] = -d->out[b->iu + k];
}

/* What rounding may make of them. */
static void rounding(const mbsr_model *m, const mbsr_data *d, int i, int sample, const changes *c)
{
    const mbsri_body *b = m->body + i;
    const size_t dim = (size_t)b->d;
    mbsri_own_sizes(m, d, i, c->f);
    for (int k = 0; k < b->n; ++k) {
        c->tau[k] = DBL_EPSILON * mbsri_joint_size(b, d, k, c->f) *
                    mbsri_sign(3 * sample, (size_t)(b->iu + k));
    }
    for (size_t r = 0; r < dim; ++r) {
        double size = fabs(d->kII[b->v + r]);
        for (size_t l = 0; l < (size_t)b->pred.d; ++l)
            size += fabs(d->H[b->dp + l * dim + r] * d->A[b->pred.v + l]);
        for (size_t l = 0; l < (size_t)b->n; ++l)
            size += fabs(d->J[b->dn + l * dim + r] * d->udot[(size_t)b->iu + l]);
        c->kII[r] = DBL_EPSILON * size * mbsri_sign(3 * sample + 1, b->v + r);
        c->f[r] *= DBL_EPSILON * mbsri_sign(3 * sample + 2, b->v + r);
    }
}

/* x (by the caller's order) from the residual in `out`, or with sample >= 0 from rounding errors.
 * reads J, H, G, U, Dinv, Mbar;  writes impbar, sigma (kII), ep, Az (a). */
static void solve_correction(const mbsr_model *m, mbsr_data *d, int sample, double *x)
{
    double *a_pred = d->scratch, *du = a_pred + m->most.d, *sum = du + m->most.d;
    mbsri_zero(m->size.v, d->impbar);
    mbsri_zero((size_t)m->root.d, d->Az);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        double *bar = d->impbar + b->v, *load = d->ep + b->group.iu, *kII = d->sigma + b->v;
        const changes c = {d->scratch, kII, load};
        if (sample < 0)
            refined_residual(b, d, &c);
        else
            rounding(m, d, i, sample, &c);
        for (int k = 0; k < b->d; ++k) bar[k] += c.f[k];
        mbsri_copy((size_t)b->d, bar, sum);
        mbsri_ax(b->d, b->d, 1.0, d->Mbar + b->dd, kII, sum);
        mbsri_group_load(m, d, i, d->impbar, d->sigma, load, sum, sum + m->most.d);
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, sum, d->impbar + b->pred.v);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *a = d->Az + b->v, *own = x + b->u;
        mbsri_zero((size_t)b->d, a_pred);
        mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->Az + b->pred.v, a_pred);
        if (mbsri_heads(m, d, i)) {
            const mbsri_group g = mbsri_group_of(m, d, i);
            double *load = d->ep + g.ig;
            mbsri_atx(b->d, g.n, -1.0, d->U + b->dg, a_pred, load);
            mbsri_zero((size_t)g.n, du);
            mbsri_ax(g.n, g.n, 1.0, d->Dinv + b->nn, load, du);
            mbsri_group_scatter(m, &g, du, x);
        }
        for (int k = 0; k < b->d; ++k) a[k] = -a_pred[k] - d->sigma[b->v + (size_t)k];
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, own, a);
    }
}

void mbsri_refine_solve(const mbsr_model *m, mbsr_data *d, double *x)
{
    solve_correction(m, d, -1, x);
}

/* One correction of udot. */
static void correct_once(const mbsr_model *m, mbsr_data *d, double *udot, double *change)
{
    mbsri_inverse(m, d, udot);
    solve_correction(m, d, -1, change);
    for (int k = 0; k < m->nu; ++k) udot[k] += change[k];
}

/* x^T D x of a group; x by the caller's order */
static double square_of(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                        const double *x)
{
    const double *D = d->D + m->body[g->member[0]].nn;
    double sum = 0.0, *own = d->scratch;
    mbsri_group_gather(m, g, x, own);
    for (int j = 0; j < g->n; ++j) {
        for (int k = 0; k < g->n; ++k) sum += own[j] * D[j * g->n + k] * own[k];
    }
    return fmax(sum, 0.0);
}

/* Adds weight x^2 to error, entry by entry, and group by group to the first entry of the group in
 * `joints` (by the order of the groups). */
static void add_squares(const mbsr_model *m, const mbsr_data *d, double weight, const double *x,
                        double *error, double *joints)
{
    for (int k = 0; k < m->nu; ++k) error[k] += weight * x[k] * x[k];
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (mbsri_heads(m, d, i) && g.n > 0) joints[g.ig] += weight * square_of(m, d, &g, x);
    }
}

double mbsri_refine(const mbsr_model *m, mbsr_data *d, double *udot, double *error)
{
    double *change = d->v_given, *joints = d->w, largest = 0.0;
    correct_once(m, d, udot, change);
    correct_once(m, d, udot, change);
    mbsri_zero((size_t)m->nu, error);
    mbsri_zero((size_t)m->nu, joints);
    add_squares(m, d, 1.0, change, error, joints);
    mbsri_inverse(m, d, udot);
    for (int l = 0; l < SAMPLES; ++l) {
        solve_correction(m, d, l, change);
        add_squares(m, d, 1.0 / SAMPLES, change, error, joints);
    }
    for (int k = 0; k < m->nu; ++k) error[k] = sqrt(error[k]);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (!mbsri_heads(m, d, i) || g.n == 0 || !(joints[g.ig] > 0.0)) continue;
        const double size = square_of(m, d, &g, udot), left = joints[g.ig];
        largest = fmax(largest, size > left ? sqrt(left / size) : 1.0);
    }
    return largest;
}
