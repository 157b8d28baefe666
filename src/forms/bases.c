/* Smooth bases of the joint blocks, their rates, and the derivative of the backward recursion.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With all quantities scaled by the frame's S (D <- S D S, D^+ <- S^-1 D^+ S^-1) and Pn = N N^T, at
 * constant rank:
 *
 *   d(D^+) = -D^+ D' D^+ + D^+ D^+ D' Pn + Pn D' D^+ D^+
 *   d(Pi)  = Pn D' D^+ + D^+ D' Pn                         Pi: projection on the range
 *
 * and for the polar factor B of C = Pi B_ref (or (I - Pi) B_ref), P = B^T B_ref symmetric:
 *
 *   B' = (I - B B^T) C' P^-1 + B Omega,   Omega P + P Omega = B^T C' - C'^T B. */
#include "forms/bases.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "base/error.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"

#include <math.h>

int mbsri_frame_renew(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u)
{
    const bool used = d->frame.used;
    d->frame.used = false;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_backward_masses(m, d);
    d->frame.used = used;
    if (status) return status;
    mbsri_copy((size_t)m->nu, d->s, d->s_frame);
    mbsri_copy(m->size.nn, d->X, d->X_frame);
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        d->frame.rank[i] = mbsri_group_rank(d, &g);
    }
    d->frame.known = true;
    return MBSR_OK;
}

/* Turns the c columns of B (n rows) within their span towards B_ref; returns the smallest
 * cosine. */
static double turn_towards(int n, int c, double *B, const double *B_ref, double *scratch)
{
    const size_t cc = (size_t)c * (size_t)c;
    double *A = scratch, *left = A + cc, *right = left + cc, *sigma = right + cc;
    double *turned = sigma + c, *work = turned + (size_t)n * (size_t)c;
    mbsri_zero(cc, A);
    mbsri_atb(n, c, c, 1.0, B, B_ref, A);
    if (c == 1) {
        if (A[0] < 0.0) {
            for (int k = 0; k < n; ++k) B[k] = -B[k];
        }
        return fabs(A[0]);
    }
    if (mbsri_lapack_svd(c, A, sigma, left, right, work, 5 * c + 1) != 0) return 0.0;
    /* B <- B (left right^T) */
    mbsri_zero(cc, A);
    mbsri_abt(c, c, c, 1.0, left, right, A);
    mbsri_zero((size_t)n * (size_t)c, turned);
    mbsri_ab(n, c, c, 1.0, B, A, turned);
    mbsri_copy((size_t)n * (size_t)c, turned, B);
    return sigma[c - 1];
}

int mbsri_frame_align(const mbsr_model *m, mbsr_data *d)
{
    static const double least = 0.05; /* cosine of 87 degrees */
    char label[MBSRI_LABEL];
    d->frame.alignment = 1.0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_body *b = m->body + i;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const int n = g.n, r = mbsri_group_rank(d, &g);
        double *X = d->X + b->nn;
        const double *X_ref = d->X_frame + b->nn;
        if (r != d->frame.rank[i]) {
            return mbsri_fail(&d->error, MBSR_RANK_CHANGED, b->id, MBSR_NONE,
                              "%s: the rank of its joint changes from %d to %d (of %d) at t = %g",
                              mbsri_body_label(m, i, label), d->frame.rank[i], r, n, d->t);
        }
        if (r == n || r == 0) {
            mbsri_copy((size_t)n * (size_t)n, X_ref, X); /* the whole space does not turn */
            continue;
        }
        const double range = turn_towards(n, r, X, X_ref, d->scratch);
        const double null = turn_towards(n, n - r, X + r * n, X_ref + r * n, d->scratch);
        d->frame.alignment = fmin(d->frame.alignment, fmin(range, null));
        if (d->frame.alignment < least) {
            return mbsri_fail(
                &d->error, MBSR_FRAME_TURNED, b->id, MBSR_NONE,
                "%s: its massless directions have turned by about 90 degrees from the "
                "reference at t = %g; renew it",
                mbsri_body_label(m, i, label), d->t);
        }
    }
    return MBSR_OK;
}

/* B' (n x c) of the polar factor B from C' (n x c). */
static void polar_rate(int n, int c, const double *B, const double *B_ref, double *Cdot,
                       double *Bdot, double *scratch)
{
    const size_t cc = (size_t)c * (size_t)c, nc = (size_t)n * (size_t)c;
    double *Q = scratch, *K = Q + cc, *T = K + cc, *p = T + cc, *W = p + c, *work = W + nc;
    /* P = Q diag(p) Q^T,  K = B^T C' */
    mbsri_zero(cc, Q);
    mbsri_atb(n, c, c, 1.0, B, B_ref, Q);
    mbsri_symmetrise(c, Q);
    if (mbsri_lapack_syev(c, Q, p, work, 3 * c) != 0) p[0] = NAN;
    mbsri_zero(cc, K);
    mbsri_atb(n, c, c, 1.0, B, Cdot, K);
    /* W = (C' - B K) P^-1 */
    mbsri_ab(n, c, c, -1.0, B, K, Cdot);
    mbsri_zero(nc, W);
    mbsri_ab(n, c, c, 1.0, Cdot, Q, W);
    for (int l = 0; l < c; ++l) {
        for (int k = 0; k < n; ++k) W[l * n + k] /= p[l];
    }
    mbsri_zero(nc, Bdot);
    mbsri_abt(n, c, c, 1.0, W, Q, Bdot);
    /* Omega = Q [(Q^T (K - K^T) Q)_ab / (p_a + p_b)] Q^T */
    for (int j = 0; j < c; ++j) {
        for (int k = 0; k < j; ++k) {
            const double skew = K[j * c + k] - K[k * c + j];
            K[j * c + k] = skew, K[k * c + j] = -skew;
        }
        K[j * c + j] = 0.0;
    }
    mbsri_zero(cc, T);
    mbsri_ab(c, c, c, 1.0, K, Q, T);
    mbsri_zero(cc, K);
    mbsri_atb(c, c, c, 1.0, Q, T, K);
    for (int j = 0; j < c; ++j) {
        for (int k = 0; k < c; ++k) K[j * c + k] /= p[j] + p[k];
    }
    mbsri_zero(cc, T);
    mbsri_ab(c, c, c, 1.0, Q, K, T);
    mbsri_zero(cc, K);
    mbsri_abt(c, c, c, 1.0, T, Q, K);
    mbsri_ab(n, c, c, 1.0, B, K, Bdot);
}

/* Scaled D^+, and X' and d(D^+) (scaled) from the scaled D'.  All n x n; scratch after them. */
static void block_rates(const mbsri_body *b, const mbsri_group *g, const mbsr_data *d, int r,
                        const double *Ddot, double *Dpdot, double *Xdot, double *scratch)
{
    const int n = g->n;
    const size_t nn = (size_t)n * (size_t)n;
    const double *X = d->X + b->nn, *X_ref = d->X_frame + b->nn, *s = d->s + g->ig;
    const double *Dinv = d->Dinv + b->nn;
    double *Dp = scratch, *Pn = Dp + nn, *T = Pn + nn, *Pidot = T + nn, *Cdot = Pidot + nn;
    double *rest = Cdot + nn;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) Dp[j * n + k] = Dinv[j * n + k] / (s[j] * s[k]);
    }
    mbsri_zero(nn, Pn);
    mbsri_abt(n, n - r, n, 1.0, X + r * n, X + r * n, Pn);
    /* T = Pn D' D^+,  Pi' = T + T^T */
    mbsri_zero(nn, Pidot);
    mbsri_ab(n, n, n, 1.0, Ddot, Dp, Pidot);
    mbsri_zero(nn, T);
    mbsri_ab(n, n, n, 1.0, Pn, Pidot, T);
    /* d(D^+) = -D^+ (D' D^+) + T D^+ + (T D^+)^T */
    mbsri_zero(nn, Dpdot);
    mbsri_ab(n, n, n, 1.0, T, Dp, Dpdot);
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k <= j; ++k) {
            const double sum = Dpdot[j * n + k] + Dpdot[k * n + j];
            Dpdot[j * n + k] = Dpdot[k * n + j] = sum;
        }
    }
    mbsri_ab(n, n, n, -1.0, Dp, Pidot, Dpdot);
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) Pidot[j * n + k] = T[j * n + k] + T[k * n + j];
    }
    mbsri_zero(nn, Xdot);
    if (r == 0 || r == n) return;
    mbsri_zero(nn, Cdot);
    mbsri_ab(n, n, r, 1.0, Pidot, X_ref, Cdot);
    polar_rate(n, r, X, X_ref, Cdot, Xdot, rest);
    mbsri_zero(nn, Cdot);
    mbsri_ab(n, n, n - r, -1.0, Pidot, X_ref + r * n, Cdot);
    polar_rate(n, n - r, X + r * n, X_ref + r * n, Cdot, Xdot + r * n, rest);
}

/* Rows of D' from F and F' at member a, columns of b. */
static void place_block_rates(const mbsri_body *row, const mbsri_body *column, const mbsri_group *g,
                              const mbsr_data *d, const double *F, const double *Fdot, double *Ddot)
{
    const int r = row->group.iu - g->ig, c = column->group.iu - g->ig;
    for (int j = 0; j < column->n; ++j) {
        const double *f = F + (size_t)(j * row->d), *fdot = Fdot + (size_t)(j * row->d);
        for (int k = 0; k < row->n; ++k) {
            const size_t at = row->dn + (size_t)(k * row->d);
            const double entry =
                mbsri_dot(row->d, d->Jdot + at, f) + mbsri_dot(row->d, d->J + at, fdot);
            Ddot[(c + j) * g->n + r + k] = entry;
            if (row != column) Ddot[(r + k) * g->n + c + j] = entry;
        }
    }
}

/* U' and D' of a group (not scaled), as U and D in recursion/group.h:
 *   F' = C' J + C J',  F'_pi = -H'^T F - H^T F',  D'_ab = J_a'^T F_b + J_a^T F_b'
 * work: 4 d n. */
static void products(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double *Udot,
                     double *Ddot, double *work)
{
    const int head = g->member[0];
    mbsri_zero((size_t)g->n * (size_t)g->n, Ddot);
    for (int l = 0; l < g->members; ++l) {
        const mbsri_body *b = m->body + g->member[l];
        const size_t room = (size_t)m->most.d * (size_t)b->n;
        const int n = b->n;
        double *F = work, *Fdot = F + room, *next = Fdot + room, *next_dot = next + room;
        mbsri_zero((size_t)(b->d * n), F);
        mbsri_zero((size_t)(b->d * n), Fdot);
        mbsri_ab(b->d, b->d, n, 1.0, d->Mbar + b->dd, d->J + b->dn, F);
        mbsri_ab(b->d, b->d, n, 1.0, d->Mbardot + b->dd, d->J + b->dn, Fdot);
        mbsri_ab(b->d, b->d, n, 1.0, d->Mbar + b->dd, d->Jdot + b->dn, Fdot);
        for (int a = g->member[l];; a = m->body[a].parent) {
            const mbsri_body *at = m->body + a;
            place_block_rates(at, b, g, d, F, Fdot, Ddot);
            if (a == head) break;
            mbsri_zero((size_t)(at->pred.d * n), next);
            mbsri_zero((size_t)(at->pred.d * n), next_dot);
            mbsri_atb(at->d, at->pred.d, n, -1.0, d->H + at->dp, F, next);
            mbsri_atb(at->d, at->pred.d, n, -1.0, d->Hdot + at->dp, F, next_dot);
            mbsri_atb(at->d, at->pred.d, n, -1.0, d->H + at->dp, Fdot, next_dot);
            mbsri_copy((size_t)(at->pred.d * n), next, F);
            mbsri_copy((size_t)(at->pred.d * n), next_dot, Fdot);
        }
        mbsri_copy((size_t)(m->body[head].d * n), Fdot,
                   Udot + (size_t)((b->group.iu - g->ig) * m->body[head].d));
    }
    mbsri_symmetrise(g->n, Ddot);
}

/* Mbar^a' = Mbar' - U' G^T - G U'^T + G D' G^T, and with H' to the predecessor's Mbar'; n = 0: of a
 * body that is not the head of a group. */
static void pass_rates_on(const mbsr_model *m, mbsr_data *d, int i, int n, const double *Udot,
                          const double *Ddot, double *scratch)
{
    const mbsri_body *b = m->body + i;
    const int dim = b->d, dp = b->pred.d;
    const size_t dd = (size_t)dim * (size_t)dim;
    const double *G = d->G + b->dg, *H = d->H + b->dp, *Hdot = d->Hdot + b->dp;
    double *T = scratch, *Tdot = T + dd, *product = Tdot + dd, *sum = d->Mbardot + b->pred.dd;
    if (dp == 0) return;
    mbsri_copy(dd, d->Mbardot + b->dd, Tdot);
    mbsri_abt(dim, n, dim, -1.0, Udot, G, Tdot);
    mbsri_abt(dim, n, dim, -1.0, G, Udot, Tdot);
    mbsri_zero((size_t)dim * (size_t)n, product);
    mbsri_ab(dim, n, n, 1.0, G, Ddot, product);
    mbsri_abt(dim, n, dim, 1.0, product, G, Tdot);
    mbsri_congruence(dim, dp, H, Tdot, sum, product);
    /* H'^T Mbar^a H + its transpose */
    mbsri_copy(dd, d->Mbar + b->dd, T);
    mbsri_abt(dim, n, dim, -1.0, G, d->U + b->dg, T);
    mbsri_zero((size_t)dim * (size_t)dp, product);
    mbsri_ab(dim, dim, dp, 1.0, T, H, product);
    mbsri_atb(dim, dp, dp, 1.0, Hdot, product, sum);
    mbsri_atb(dim, dp, dp, 1.0, product, Hdot, sum);
}

/* reads Mdot, Hdot, Jdot, Mbar, U, G, Dinv, X, s;  writes Mbardot, Gdot, Xdot. */
int mbsri_frame_rates(const mbsr_model *m, mbsr_data *d)
{
    const size_t dm = (size_t)m->most.d * (size_t)m->most.d;
    double *Udot = d->scratch, *Ddot = Udot + dm, *Dsdot = Ddot + dm, *Dpdot = Dsdot + dm;
    double *rest = Dpdot + dm;
    mbsri_copy(m->size.dd, d->Mdot, d->Mbardot);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        if (!mbsri_heads(m, d, i)) {
            pass_rates_on(m, d, i, 0, Udot, Ddot, rest);
            continue;
        }
        const mbsri_group g = mbsri_group_of(m, d, i);
        const int n = g.n;
        const double *s = d->s + g.ig;
        products(m, d, &g, Udot, Ddot, rest);
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) Dsdot[j * n + k] = s[j] * Ddot[j * n + k] * s[k];
        }
        block_rates(b, &g, d, mbsri_group_rank(d, &g), Dsdot, Dpdot, d->Xdot + b->nn, rest);
        /* G' = U' D^+ + U S d(D^+) S */
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) Dpdot[j * n + k] *= s[j] * s[k];
        }
        mbsri_zero((size_t)b->d * (size_t)n, d->Gdot + b->dg);
        mbsri_ab(b->d, n, n, 1.0, Udot, d->Dinv + b->nn, d->Gdot + b->dg);
        mbsri_ab(b->d, n, n, 1.0, d->U + b->dg, Dpdot, d->Gdot + b->dg);
        pass_rates_on(m, d, i, n, Udot, Ddot, rest);
    }
    return MBSR_OK;
}
