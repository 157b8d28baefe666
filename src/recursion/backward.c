/* Backward recursion (17), leaves to root, with K = I (see kinematics.c).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   Mbar_i = M_i + sum_j H_j^T Mbar^a_j H_j,    Mbar^a_j = Mbar_j - Mbar_j J_j D_j^+ J_j^T Mbar_j
 *   fbar_i = f_i - sum_j H_j^T mu_j
 *   mu_j   = (I - Mbar_j J_j D_j^+ J_j^T) (fbar_j + Mbar_j kII_j) + Mbar_j J_j D_j^+ tau_j
 *
 * with D_j = J_j^T Mbar_j J_j and its pseudo-inverse (rank.c).
 *
 * Beside Mbar runs W, the first-order size of the rounding errors in Mbar and in D (in units of the
 * machine precision). For a positive semi-definite matrix A, products and differences of its
 * entries are wrong by at most about Diag(A), its diagonal as a matrix; Diag does not depend on
 * units. Each body adds what cancels in Mbar^a_j and in D_j, and errors of a successor arrive as
 * the recursion transports them,
 *
 *   d(Mbar^a) = P^T d(Mbar) P + G dD G^T,   P = I - J D^+ J^T Mbar,   G = Mbar J D^+
 *
 * so that
 *
 *   W_i = Diag(Mbar_i) + sum_j H_j^T E_j H_j
 *   E_j = Diag(Mbar_j) + Diag(G_j Diag(J_j^T Diag(Mbar_j) J_j) G_j^T) + P_j^T W_j P_j
 *
 * Where D_j has several rows but not full rank its eigenvalues are wrong by the largest of them,
 * lambda_1 S^-2, which then takes the place of J^T Diag(Mbar) J if it is larger. */
#include "recursion/backward.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "recursion/rank.h"

#include <math.h>

/* D = J^T U with U = Mbar J, its rank and pseudo-inverse, G = U D^+.
 * reads Mbar, W, J;  writes U, D, Dinv, G.  cost: 3 d^2 n, one eigenproblem of size n. */
static int factor_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int dim = b->d, n = b->n;
    double *U = d->U + b->dn, *D = d->D + b->nn, *G = d->G + b->dn;
    const double *J = d->J + b->dn;

    /* U = Mbar J,  D = J^T U */
    mbsri_zero((size_t)dim * (size_t)n, U);
    mbsri_ab(dim, dim, n, 1.0, d->Mbar + b->dd, J, U);
    mbsri_zero((size_t)n * (size_t)n, D);
    mbsri_atb(dim, n, n, 1.0, J, U, D);
    mbsri_symmetrise(n, D);
    /* rank D, D^+ */
    d->rank[i] = 0;
    d->scale[i] = 0.0;
    if (n > 0) {
        const int status = mbsri_rank_decision(m, d, i);
        if (status) return status;
    }
    /* G = U D^+ */
    mbsri_zero((size_t)dim * (size_t)n, G);
    mbsri_ab(dim, n, n, 1.0, U, d->Dinv + b->nn, G);
    return MBSR_OK;
}

/* e = tau - J^T (fbar + Mbar kII), mu = fbar + Mbar kII + G e, fbar_pi -= H^T mu.
 * reads Mbar, fbar, kII, tau, J, G, H;  writes e, mu;  adds to fbar of the predecessor.
 * cost: d^2 + 2 d n + d d_pred. */
void mbsri_load_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    double *e = d->e + b->iu, *mu = d->mu + b->v;
    /* mu = fbar + Mbar kII */
    mbsri_copy((size_t)b->d, d->fbar + b->v, mu);
    mbsri_ax(b->d, b->d, 1.0, d->Mbar + b->dd, d->kII + b->v, mu);
    /* e = tau - J^T mu,  mu += G e */
    mbsri_copy((size_t)b->n, d->tau + b->iu, e);
    mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, mu, e);
    mbsri_ax(b->d, b->n, 1.0, d->G + b->dn, e, mu);
    /* fbar_pi -= H^T mu */
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, mu, d->fbar + b->pred_v);
}

/* E += Diag(A) */
static void add_diagonal(int n, const double *A, double *E)
{
    for (int k = 0; k < n; ++k) E[k * (n + 1)] += A[k * (n + 1)];
}

/* T = Mbar^a = Mbar - Y Y^T, with Y = U L^-T where D = L L^T has full rank, else with the columns
 * y_l = U S x_l / sqrt(lambda_l) of the eigenvalues kept. Nothing cancels between the terms, however
 * small some are; Y, L: d x n and n x n of scratch. */
static void reduce(const mbsri_body *b, const mbsr_data *d, int i, double *T, double *Y, double *L)
{
    const int dim = b->d, n = b->n;
    const double *U = d->U + b->dn, *s = d->s + b->iu, *X = d->X + b->nn,
                 *lambda = d->lambda + b->iu;
    mbsri_copy((size_t)dim * (size_t)dim, d->Mbar + b->dd, T);
    if (mbsri_definite_factor(b, d, i, L)) {
        mbsri_copy((size_t)dim * (size_t)n, U, Y);
        mbsri_divide_by_cholesky(dim, n, L, Y);
        mbsri_abt(dim, n, dim, -1.0, Y, Y, T);
        return;
    }
    for (int l = 0; l < d->rank[i]; ++l) {
        mbsri_zero((size_t)dim, Y);
        for (int k = 0; k < n; ++k)
            mbsri_ax(dim, 1, 1.0 / sqrt(lambda[l]), U + k * dim, &(double){s[k] * X[l * n + k]}, Y);
        mbsri_abt(dim, 1, dim, -1.0, Y, Y, T);
    }
}

/* E = Diag(Mbar) + Diag(G Diag(J^T Diag(Mbar) J) G^T) + P^T W P;  Q: d x n, JQ: n x n of scratch.
 * P = I - J G^T, so P^T W P = W - Q G^T - G Q^T + G (J^T Q) G^T with Q = W J. */
static void transport(const mbsri_body *b, const mbsr_data *d, int i, double *E, double *Q,
                      double *JQ)
{
    const int dim = b->d, n = b->n;
    const double *Mbar = d->Mbar + b->dd, *W = d->W + b->dd, *J = d->J + b->dn, *G = d->G + b->dn,
                 *lambda = d->lambda + b->iu, *s = d->s + b->iu;
    mbsri_zero((size_t)dim * (size_t)n, Q);
    mbsri_ab(dim, dim, n, 1.0, W, J, Q);
    mbsri_zero((size_t)n * (size_t)n, JQ);
    mbsri_atb(dim, n, n, 1.0, J, Q, JQ);
    mbsri_copy((size_t)dim * (size_t)dim, W, E);
    add_diagonal(dim, Mbar, E);
    /* E -= (Q - G JQ / 2) G^T + its transpose */
    mbsri_ab(dim, n, n, -0.5, G, JQ, Q);
    mbsri_abt(dim, n, dim, -1.0, Q, G, E);
    mbsri_abt(dim, n, dim, -1.0, G, Q, E);
    for (int l = 0; l < n; ++l) {
        double size = 0.0;
        for (int k = 0; k < dim; ++k) size += J[l * dim + k] * Mbar[k * (dim + 1)] * J[l * dim + k];
        if (n > 1 && d->rank[i] < n) size = fmax(size, lambda[0] / (s[l] * s[l]));
        for (int k = 0; k < dim; ++k) E[k * (dim + 1)] += size * G[l * dim + k] * G[l * dim + k];
    }
    mbsri_symmetrise(dim, E);
}

/* Mbar_pi += H^T Mbar^a H,  W_pi += H^T E H.
 * reads Mbar, W, U, G, H;  adds to Mbar, W of the predecessor.
 * cost: 4 (d^2 n + d^2 d_pred + d d_pred^2). */
void mbsri_pass_masses(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const double *H = d->H + b->dp;
    if (b->d_pred == 0) return;
    const size_t dm = (size_t)m->max_d * (size_t)m->max_d;
    double *T = d->scratch, *E = T + dm, *Q = E + dm, *product = Q + dm;
    reduce(b, d, i, T, Q, product);
    transport(b, d, i, E, Q, product);
    mbsri_congruence(b->d, b->d_pred, H, T, d->Mbar + b->pred_dd, product);
    mbsri_congruence(b->d, b->d_pred, H, E, d->W + b->pred_dd, product);
}

int mbsri_eliminate_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    mbsri_symmetrise(b->d, d->Mbar + b->dd);
    add_diagonal(b->d, d->Mbar + b->dd, d->W + b->dd);
    return factor_joint(m, d, i);
}

/* The recursion for masses: Mbar, W, U, D, G and ranks. */
static int masses(const mbsr_model *m, mbsr_data *d)
{
    d->total_rank = 0;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    mbsri_copy(m->size_dd, d->M, d->Mbar);
    mbsri_zero(m->size_dd, d->W);
    for (int i = m->bodies; i >= 1; --i) {
        int status = mbsri_eliminate_joint(m, d, i);
        if (!status) status = mbsri_rank_watched(m, d, i);
        if (status) return status;
        mbsri_pass_masses(m, d, i);
        d->total_rank += d->rank[i];
    }
    return MBSR_OK;
}

void mbsri_backward_loads(const mbsr_model *m, mbsr_data *d)
{
    d->accelerated = false; /* mu is overwritten */
    mbsri_copy(m->size_v, d->f, d->fbar);
    for (int i = m->bodies; i >= 1; --i) mbsri_load_joint(m, d, i);
}

int mbsri_backward_masses(const mbsr_model *m, mbsr_data *d)
{
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    return masses(m, d);
}

int mbsri_backward(const mbsr_model *m, mbsr_data *d)
{
    const int status = mbsri_backward_masses(m, d);
    if (status) return status;
    mbsri_backward_loads(m, d);
    d->stage = MBSRI_STAGE_BACKWARD;
    return MBSR_OK;
}
