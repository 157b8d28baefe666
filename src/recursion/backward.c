/* Backward recursion (17), leaves to root, with K = I (see kinematics.c).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   Mbar_i = M_i + sum_j H_j^T Mbar^a_j H_j,    Mbar^a_j = Mbar_j - Mbar_j J_j D_j^+ J_j^T Mbar_j
 *   fbar_i = f_i - sum_j H_j^T mu_j
 *   mu_j   = (I - Mbar_j J_j D_j^+ J_j^T) (fbar_j + Mbar_j kII_j) + Mbar_j J_j D_j^+ tau_j
 *
 * with D_j = J_j^T Mbar_j J_j + Diag(a_j), a the armature, and its pseudo-inverse (rank.c). Where
 * several joints are one group (group.h), its head is j here and the others pass on to it what they
 * have.
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
 * Turning the tensor of a body into the world's axes leaves errors of the size of its trace in all
 * of its moments, and so do lever arms, of m |r|^2. About an axis with next to no moment of its own
 * Diag does not show them; so the traces, and m |r|^2 from body to body, are added up beside W
 * (`rotated`), as if no joint took any of them, for the decision alone.
 *
 * Where D_j has several rows but not full rank its eigenvalues are wrong by the largest of them,
 * lambda_1 S^-2, which then takes the place of J^T Diag(Mbar) J if it is larger. */
#include "recursion/backward.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/errors.h"
#include "recursion/exact.h"
#include "recursion/flexible_factors.h"
#include "recursion/group.h"
#include "recursion/modal.h"
#include "recursion/rank.h"
#include "recursion/rank_pivots.h"

#include <math.h>

/* G = U D^+; of the modes of a mount that is a group by itself, with J = [Jt; -1] and U_s = Jt^T
 * U_f - D, these rows are Jt^T G_f - D D^+, and 1 - D D^+ = S^-1 X_dropped X_dropped^T S. */
static void find_gains(const mbsr_data *d, const mbsri_group *g, const mbsri_body *b)
{
    const int dim = b->d, n = g->n, rank = mbsri_group_rank(d, g);
    const double *U = d->U + b->dg, *J = d->J + b->dn, *Dinv = d->Dinv + b->nn, *s = d->s + g->ig;
    double *G = d->G + b->dg, *upper = d->scratch;
    mbsri_zero((size_t)dim * (size_t)n, G);
    if (!b->flexible.modal || g->members > 1 || !mbsri_is_zero((size_t)n, b->mass.armature)) {
        mbsri_ab(dim, n, n, 1.0, U, Dinv, G);
        return;
    }
    mbsri_upper(MBSRI_FRAME_ROWS, dim, n, U, upper);
    for (int k = 0; k < n; ++k) {
        double *column = G + k * dim, *modes = column + MBSRI_FRAME_ROWS;
        mbsri_ax(MBSRI_FRAME_ROWS, n, 1.0, upper, Dinv + k * n, column);
        modes[k] = -1.0;
        for (int l = rank; l < n; ++l) {
            const double *x = d->X + b->nn + l * n;
            const double part = x[k] * s[k];
            for (int i = 0; i < n; ++i) modes[i] += x[i] / s[i] * part;
        }
        for (int i = 0; i < n; ++i) {
            if (!b->flexible.upright) modes[i] += mbsri_dot(MBSRI_FRAME_ROWS, J + i * dim, column);
        }
    }
}

/* U and D of the group, rank and pseudo-inverse of D, G = U D^+.
 * reads Mbar, W, J, H;  writes U, D, Dinv, G.  cost: 3 d^2 n, one eigenproblem of size n. */
static int factor_group(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, mbsri_rank_way way)
{
    const mbsri_body *b = m->body + g->member[0];
    mbsri_group_products(m, d, g, d->Mbar, d->U + b->dg, d->D + b->nn, d->scratch);
    mbsri_group_add_armature(m, g, d->D + b->nn);
    for (int k = 0; k < g->members; ++k) d->rank[g->member[k]] = 0;
    d->scale[m->body[g->member[0]].scalar_offset] = 0.0;
    const bool told =
        way == MBSRI_RANK_QUICKLY && b->flexible.modal && mbsri_rank_by_pivots(m, d, g);
    if (g->n > 0 && !told) {
        const int status = mbsri_rank_decision(m, d, g, way == MBSRI_RANK_ROUGHLY);
        if (status) return status;
    }
    find_gains(d, g, b);
    return told ? MBSRI_BY_PIVOTS : MBSR_OK;
}

/* mu = fbar + Mbar kII,  e = tau - J^T mu;  at a head, when e of the group is there, mu += G e;
 * then fbar_pi -= H^T mu.
 * reads Mbar, fbar, kII, tau, J, G, H;  writes e, mu;  adds to fbar of the predecessor.
 * cost: d^2 + 2 d n + d d_pred. */
void mbsri_load_joint(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    double *e = d->e + b->group.iu, *mu = d->mu + b->v;
    /* mu = fbar + Mbar kII */
    mbsri_copy((size_t)b->d, d->fbar + b->v, mu);
    mbsri_copy((size_t)b->n, d->tau + b->iu, e);
    /* e = tau - J^T mu,  mu += G e */
    if (mbsri_in_factors(d, i)) { /* kII = 0 */
        mbsri_factors_load(m, d, i, e, mu);
    } else {
        mbsri_ax_often(b->d, b->d, 1.0, d->Mbar + b->dd, d->kII + b->v, mu);
        mbsri_group_load(m, d, i, d->fbar, d->kII, e, mu, d->scratch);
    }
    /* fbar_pi -= H^T mu */
    mbsri_atx_often(b->d, b->pred.d, -1.0, d->H + b->dp, mu, d->fbar + b->pred.v);
}

/* T = Mbar^a = Mbar - Y Y^T, its upper `rows` rows and columns:
 *
 *   Y = U L^-T                          where D = L L^T has full rank, unless pivots decided that
 *   y_l = U S x_l / sqrt(lambda_l)      else, for each eigenvalue lambda_l of S D S that is kept
 *
 * Nothing cancels between the terms, however small some are.
 * scratch Y (d x n), L (n x n). */
static void articulated_part(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                             int rows, bool by_pivots, double *T, double *Y, double *L)
{
    const mbsri_body *b = m->body + g->member[0];
    const int dim = b->d, n = g->n, rank = mbsri_group_rank(d, g);
    const double *U = d->U + b->dg, *s = d->s + g->ig, *X = d->X + b->nn,
                 *lambda = d->lambda + g->ig;
    mbsri_upper(rows, dim, rows, d->Mbar + b->dd, T);
    if (!by_pivots && mbsri_definite_factor(m, d, g, L)) {
        mbsri_upper(rows, dim, n, U, Y);
        mbsri_divide_by_cholesky(rows, n, L, Y);
        mbsri_abt(rows, n, rows, -1.0, Y, Y, T);
        return;
    }
    for (int l = 0; l < rank; ++l) {
        mbsri_zero((size_t)rows, Y);
        for (int k = 0; k < n; ++k)
            mbsri_ax(rows, 1, 1.0 / sqrt(lambda[l]), U + k * dim, &(double){s[k] * X[l * n + k]},
                     Y);
        mbsri_abt(rows, 1, rows, -1.0, Y, Y, T);
    }
}

/* C += H^T A H as sums of columns of H^T, of which a marker's predecessor has many. */
static void carry_to_modes(int d, int d_pred, const double *H, const double *A, double *C,
                           double *work)
{
    double *Ht = work, *AH = Ht + d_pred * d;
    for (int j = 0; j < d_pred; ++j) {
        for (int k = 0; k < d; ++k) Ht[k * d_pred + j] = H[j * d + k];
    }
    for (int j = 0; j < d_pred; ++j) {
        mbsri_zero((size_t)d, AH);
        mbsri_ax(d, d, 1.0, A, H + j * d, AH);
        mbsri_ax_long(d_pred, d, 1.0, Ht, AH, C + j * d_pred);
    }
}

/* H, and its arm where it is minus a translation of twists; d x d_pred. */
typedef struct transport {
    const double *H;
    int d, d_pred;
    bool translates;
    double rho[3];
} transport;

static transport transport_of(int d, int d_pred, const double *H)
{
    transport by = {.H = H, .d = d, .d_pred = d_pred};
    by.translates = d == 6 && d_pred == 6 && mbsri_is_translation(H, by.rho);
    return by;
}

/* C += H^T A H of a symmetric A; work: d (d_pred + 1). */
static void carry_over(const transport *by, const double *A, double *C, double *work)
{
    const int d = by->d, d_pred = by->d_pred;
    const double *H = by->H;
    if (mbsri_is_zero((size_t)d * (size_t)d, A)) return;
    if (by->translates)
        mbsri_translate_matrix(by->rho, A, C);
    else if (d == 6 && d_pred > 12)
        carry_to_modes(d, d_pred, H, A, C, work);
    else if (d == 3 && d_pred == 3) /* sizes known to the compiler */
        mbsri_congruence(3, 3, H, A, C, work);
    else
        mbsri_congruence(d, d_pred, H, A, C, work);
}

/* Of a head, Mbar_pi += H^T Mbar^a H,  W_pi += H^T E H;  of others what they have themselves.
 * reads Mbar, W, U, G, H;  adds to Mbar, W of the predecessor.
 * cost: 4 (d^2 n + d^2 d_pred + d d_pred^2). */
void mbsri_pass_masses(const mbsr_model *m, mbsr_data *d, int i, bool by_pivots)
{
    const mbsri_body *b = m->body + i;
    const double *H = d->H + b->dp;
    if (b->pred.d == 0) return;
    d->rotated[m->body[b->parent].scalar_offset] +=
        d->rotated[b->scalar_offset] + mbsri_trace_of_arms(b, H, d->Mbar + b->dd);
    const size_t dm = (size_t)m->most.d * (size_t)m->most.d;
    double *T = d->scratch, *E = T + dm, *Q = E + dm, *JQ = Q + dm, *product = JQ + dm;
    if (!mbsri_heads(m, d, i)) {
        const size_t dp = (size_t)b->pred.d;
        double *Mbar = d->Mbar + b->pred.dd, *W = d->W + b->pred.dd;
        const transport by = transport_of(b->d, b->pred.d, H);
        mbsri_zero(dp * dp, T);
        carry_over(&by, d->Mbar + b->dd, T, product);
        carry_over(&by, d->W + b->dd, W, product);
        for (size_t k = 0; k < dp * dp; ++k) Mbar[k] += T[k];
        for (size_t k = 0; k < dp; ++k) W[k * (dp + 1)] -= T[k * (dp + 1)]; /* it is in W already */
        return;
    }
    const mbsri_group g = mbsri_group_of(m, d, i);
    const int rows = mbsri_upper_rows(b);
    double upper[MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS];
    if (b->flexible.modal) {
        mbsri_upper(rows, b->d, b->pred.d, H, upper);
        H = upper;
    }
    double own[2 * MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS];
    if (mbsri_in_factors(d, i)) {
        T = own, E = own + MBSRI_FRAME_ROWS * MBSRI_FRAME_ROWS;
        mbsri_factors_reduce(m, d, i, T, E);
    } else {
        articulated_part(m, d, &g, rows, by_pivots, T, Q, product);
        mbsri_carry_errors(m, d, &g, d->W, 1.0, rows, E, Q, JQ, product);
    }
    if (mbsri_in_factors(d, b->parent)) {
        mbsri_factors_take(m, d, i, T, E);
        return;
    }
    const transport by = transport_of(rows, b->pred.d, H);
    carry_over(&by, T, d->Mbar + b->pred.dd, product);
    carry_over(&by, E, d->W + b->pred.dd, product);
}

int mbsri_eliminate_joint(const mbsr_model *m, mbsr_data *d, int i, mbsri_rank_way way)
{
    const mbsri_body *b = m->body + i;
    if (mbsri_in_factors(d, i) && mbsri_factors_eliminate(m, d, i)) return MBSRI_BY_PIVOTS;
    double *Mbar = d->Mbar + b->dd;
    mbsri_symmetrise(b->d, Mbar);
    mbsri_add_diagonal(b->d, 1.0, Mbar, d->W + b->dd);
    if (!mbsri_heads(m, d, i)) return MBSR_OK;
    const mbsri_group g = mbsri_group_of(m, d, i);
    return factor_group(m, d, &g, way);
}

/* Mbar, W, U, D, G and ranks in double precision. */
static int plain_masses(const mbsr_model *m, mbsr_data *d, mbsri_rank_way way)
{
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t dd = (size_t)b->d * (size_t)b->d;
        mbsri_copy(dd, d->M + b->dd, d->Mbar + b->dd);
        mbsri_zero(dd, d->W + b->dd);
        d->rotated[b->scalar_offset] = mbsri_own_rotated(b, d->M + b->dd);
    }
    for (int i = m->bodies; i >= 1; --i) {
        int status = mbsri_eliminate_joint(m, d, i, way);
        if (!status && mbsri_heads(m, d, i)) status = mbsri_rank_watched(m, d, i);
        if (status) return status;
        mbsri_pass_masses(m, d, i, false);
    }
    return MBSR_OK;
}

/* The recursion for masses, and the sum of all ranks:
 *   double precision, ranks that are clear beyond rounding     unless the data asks for twofold
 *   twofold precision                                          where it does, or some is not clear
 *   double precision, ranks by the usual rule                  where that overflows */
static int masses(const mbsr_model *m, mbsr_data *d)
{
    d->total_rank = 0;
    int status = d->exactly ? mbsri_exact_masses(m, d) : MBSR_OK;
    if (status || !d->exactly) status = plain_masses(m, d, MBSRI_RANK_CLEARLY);
    if (status == MBSRI_UNCLEAR) {
        status = mbsri_exact_masses(m, d);
        if (status == MBSR_NOT_FINITE) status = plain_masses(m, d, MBSRI_RANK_ROUGHLY);
    }
    for (int i = 1; i <= m->bodies && !status; ++i) d->total_rank += d->rank[i];
    return status;
}

void mbsri_backward_loads(const mbsr_model *m, mbsr_data *d)
{
    d->accelerated = false; /* mu is overwritten */
    mbsri_copy(m->size.v, d->f, d->fbar);
    for (int i = m->bodies; i >= 1; --i) mbsri_load_joint(m, d, i);
}

int mbsri_backward_masses(const mbsr_model *m, mbsr_data *d)
{
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    d->single = false;
    for (int i = 1; i <= m->bodies && m->order.grouped; ++i) d->apart[i] = false;
    return masses(m, d);
}

int mbsri_backward_apart(const mbsr_model *m, mbsr_data *d)
{
    bool some = false;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_group g = mbsri_group_in_model(m, i);
        d->apart[i] = g.members > 1 && !mbsri_coupled(m, d, &g);
        some = some || d->apart[i];
    }
    if (!some) return MBSR_OK;
    d->stage = MBSRI_STAGE_FORCES;
    d->keep_scale = true;
    const int status = masses(m, d);
    d->keep_scale = false;
    if (!status) mbsri_backward_loads(m, d);
    return status;
}

int mbsri_backward(const mbsr_model *m, mbsr_data *d)
{
    const int status = mbsri_backward_masses(m, d);
    if (status) return status;
    mbsri_backward_loads(m, d);
    d->stage = MBSRI_STAGE_BACKWARD;
    return MBSR_OK;
}
