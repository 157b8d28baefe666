/* The backward step of a block by the bound of rounding errors, where it tells: with the kernels,
 * so that the products of the common sizes are unrolled for the processor.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * W <= kappa Mbar + spread Lambda as in rank_bound.h, for a block and a predecessor whose V has
 * angular and linear parts: Lambda = diag(w), w = L^2 for the former and 1 for the latter. With
 * ||G J^T||^2 in this metric for the transport through the joint, and ||H||^2 to the predecessor.
 */
#ifndef MBSRI_BLOCK_BOUND_H
#define MBSRI_BLOCK_BOUND_H

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "sweeps/block.h"
#include "sweeps/carry.h"
#include "sweeps/lane.h"
#include "sweeps/rank_bound.h"

#include <math.h>
#include <string.h>

/* A body with d numbers in V has (omega, v), or x, y and perhaps the angle. */
MBSRI_INLINE bool is_angular(int d, int k)
{
    return d == 6 ? k < 3 : k == 2;
}

/* Its Lambda. */
MBSRI_INLINE double weight(int d, int k, double area)
{
    return is_angular(d, k) ? area : 1.0;
}

/* L of D = L L^T, lower by rows; a bound below on the smallest eigenvalue of D scaled to unit
 * diagonal, 0 where a pivot is not positive: the product of the scaled pivots is the determinant,
 * and the other eigenvalues together are at most e times their mean. */
MBSRI_INLINE double factor_block(int n, const double *D, double *L)
{
    double determinant = 1.0;
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l <= k; ++l) {
            double sum = D[l * n + k];
            for (int j = 0; j < l; ++j) sum -= L[k * n + j] * L[l * n + j];
            if (l < k) {
                L[k * n + l] = sum / L[l * n + l];
            } else {
                if (!(sum > 0.0)) return 0.0;
                determinant *= sum / D[k * n + k];
                L[k * n + k] = sqrt(sum);
            }
        }
    }
    return n > 1 ? determinant / 2.7182818284590452 : 1.0;
}

/* Dinv = D^-1 from L. */
MBSRI_INLINE void invert_block(int n, const double *L, double *Dinv)
{
    for (int j = 0; j < n; ++j) {
        double *x = Dinv + j * n;
        for (int k = 0; k < n; ++k) {
            x[k] = k == j ? 1.0 : 0.0;
            for (int l = 0; l < k; ++l) x[k] -= L[k * n + l] * x[l];
            x[k] /= L[k * n + k];
        }
        for (int k = n - 1; k >= 0; --k) {
            for (int l = k + 1; l < n; ++l) x[k] -= L[l * n + k] * x[l];
            x[k] /= L[k * n + k];
        }
    }
}

/* Whether H = -X with X = [1 0; -[rho]x 1], as that of a joint between bodies in space mostly is.
 */
MBSRI_INLINE bool is_translation(const double H[36], v4 *rho)
{
    double r[3];
    const bool same = mbsri_is_translation(H, r);
    *rho = (v4){r[0], r[1], r[2], 0.0};
    return same;
}

/* A bound of ||H||^2: (1 + |rho| / L)^2 of a translation, in general the sum of squares. */
MBSRI_INLINE double stretch_of(int d, int dp, const double *H, double area, const v4 *rho)
{
    double squares = 0.0;
    if (rho) {
        const double ratio = 1.0 + sqrt(sum3(*rho * *rho) / area);
        return ratio * ratio;
    }
    for (int j = 0; j < dp; ++j) {
        for (int k = 0; k < d; ++k) {
            const double h = H[j * d + k];
            squares += h * h * weight(d, k, area) / weight(dp, j, area);
        }
    }
    return squares;
}

/* D, its inverse and G; false: the bound does not tell that D is regular. */
MBSRI_INLINE bool certify_block(const mbsri_sweep_run *run, int i, int d, int n, double kappa,
                                double spread)
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *data = run->data;
    const double area = run->tree->length * run->tree->length;
    const double *J = data->J + b->dn;
    double *U = data->U + b->dg, *D = data->D + b->nn, *G = data->G + b->dg, *L = data->X + b->nn;
    mbsri_zero((size_t)(d * n), U);
    mbsri_ab(d, d, n, 1.0, data->Mbar + b->dd, J, U);
    mbsri_zero((size_t)(n * n), D);
    mbsri_atb(d, n, n, 1.0, J, U, D);
    for (int l = 0; l < n; ++l) D[l * (n + 1)] += b->mass.armature[l];
    const double least = factor_block(n, D, L), *Mbar = data->Mbar + b->dd;
    double turning = 0.0, sliding = 0.0;
    for (int k = 0; k < d; ++k) *(is_angular(d, k) ? &turning : &sliding) += Mbar[k * (d + 1)];
    for (int l = 0; l < n; ++l) {
        double size = 0.0, local = 0.0;
        for (int k = 0; k < d; ++k) {
            size += weight(d, k, area) * J[l * d + k] * J[l * d + k];
            local += (is_angular(d, k) ? turning : sliding) * J[l * d + k] * J[l * d + k];
        }
        const double Dll = D[l * (n + 1)];
        if (!mbsri_is_known_by_bound(&run->tree->rule, least * Dll, kappa * Dll + spread * size,
                                     local))
            return false;
    }
    invert_block(n, L, data->Dinv + b->nn);
    mbsri_zero((size_t)(d * n), G);
    mbsri_ab(d, n, n, 1.0, U, data->Dinv + b->nn, G);
    run->rank[i] = n;
    data->scale[b->scalar_offset] = 0.0;
    return true;
}

/* The bound of ||J G^T||^2. */
MBSRI_INLINE double transport_of(const mbsri_sweep_run *run, int i, int d, int n)
{
    const mbsri_body *b = run->model->body + i;
    const double *J = run->data->J + b->dn, *G = run->data->G + b->dg;
    const double area = run->tree->length * run->tree->length;
    double norm = n > 0 ? 0.0 : 1.0, armature = 0.0;
    for (int l = 0; l < n; ++l) {
        double by_J = 0.0, by_G = 0.0;
        for (int k = 0; k < d; ++k) {
            const double w = weight(d, k, area);
            by_J += w * J[l * d + k] * J[l * d + k];
            by_G += G[l * d + k] * G[l * d + k] / w;
        }
        norm += sqrt(by_J * by_G);
        armature += b->mass.armature[l];
    }
    return beside(armature > 0.0, norm * norm);
}

/* A symmetric 6 x 6 as the blocks of a carry, and such blocks added to one. */
MBSRI_INLINE void matrix_to_blocks(const double A[36], blocks *c)
{
    clear(c);
    c->I[0] = (v4){A[0], A[7], A[14], 0.0};
    c->I[1] = (v4){A[8], A[12], A[6], 0.0};
    c->G[0] = (v4){A[3], A[10], A[17], 0.0};
    c->G[1] = (v4){A[9], A[16], A[5], 0.0};
    c->G[2] = (v4){A[15], A[4], A[11], 0.0};
    c->M[0] = (v4){A[21], A[28], A[35], 0.0};
    c->M[1] = (v4){A[29], A[33], A[27], 0.0};
}

MBSRI_INLINE void add_blocks(const blocks *c, double A[36])
{
    _Alignas(32) mbsri_carry m;
    to_memory(c, &m);
    mbsri_carry_add_to(&m, A);
}

/* Mbar^a = Mbar - G U^T, then H^T Mbar^a H added to the predecessor's Mbar; rho: of a
 * translation. */
MBSRI_INLINE void pass_mass(const mbsri_sweep_run *run, int i, int d, int dp, int n, const v4 *rho)
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *data = run->data;
    double T[36], TH[36], *above = data->Mbar + b->pred.dd;
    memcpy(T, data->Mbar + b->dd, (size_t)(d * d) * sizeof *T);
    mbsri_abt(d, n, d, -1.0, data->G + b->dg, data->U + b->dg, T);
    if (rho) {
        blocks c;
        matrix_to_blocks(T, &c);
        translate(*rho, &c);
        add_blocks(&c, above);
    } else {
        mbsri_symmetrise(d, T);
        mbsri_congruence(d, dp, data->H + b->dp, T, above, TH);
    }
}

/* As mbsri_load_joint: e and mu, -H^T mu to the predecessor. */
MBSRI_INLINE void load_sized(const mbsri_sweep_run *run, int i, int d, int dp, int n)
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *data = run->data;
    double *e = data->e + b->group.iu, *mu = data->mu + b->v;
    for (int k = 0; k < d; ++k) mu[k] = data->fbar[b->v + (size_t)k];
    mbsri_ax(d, d, 1.0, data->Mbar + b->dd, data->kII + b->v, mu);
    for (int k = 0; k < n; ++k) e[k] = data->tau[b->iu + k];
    mbsri_atx(d, n, -1.0, data->J + b->dn, mu, e);
    mbsri_ax(d, n, 1.0, data->G + b->dg, e, mu);
    mbsri_atx(d, dp, -1.0, data->H + b->dp, mu, data->fbar + b->pred.v);
}

/* Body i with sizes known to the compiler; false: not clear. */
MBSRI_INLINE bool pass_sized(const mbsri_sweep_run *run, int i, int d, int dp, int n)
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *data = run->data;
    const double area = run->tree->length * run->tree->length, soft = run->load[i].bound[2];
    const double *Mbar = data->Mbar + b->dd, *W = data->W + b->dd;
    double *bound = run->load[i].bound, trace = 0.0;
    mbsri_symmetrise(d, data->Mbar + b->dd);
    for (int k = 0; k < d; ++k) {
        trace += Mbar[k * (d + 1)] / weight(d, k, area);
        bound[1] += W[k * (d + 1)] / weight(d, k, area);
    }
    double kappa = bound[0], spread = bound[1] + trace;
    if (soft > 0.0) {
        kappa = fmax(kappa, spread * soft);
        spread = 0.0;
    }
    if (!certify_block(run, i, d, n, kappa, spread)) return false;
    load_sized(run, i, d, dp, n);
    if (dp == 0) return true;
    const double norm = transport_of(run, i, d, n), *H = data->H + b->dp;
    v4 rho;
    const v4 *moved = d == 6 && dp == 6 && is_translation(H, &rho) ? &rho : NULL;
    bound[0] = kappa;
    bound[1] = (spread * norm + trace * (1.0 + norm)) * stretch_of(d, dp, H, area, moved);
    pass_mass(run, i, d, dp, n, moved);
    return true;
}

/* Three numbers of three, without those around them. */
MBSRI_INLINE v4 three(const double *x)
{
    return (v4){x[0], x[1], x[2], 0.0};
}

MBSRI_INLINE void put_three(double *x, v4 a)
{
    for (int k = 0; k < 3; ++k) x[k] = a[k];
}

/* Body i with one coordinate, behind a body in space of which it is a translation away: the same in
 * three dimensions at a time, with U = (U_L, U_p) and so on. */
MBSRI_INLINE bool pass_hinge(const mbsri_sweep_run *run, int i, v4 rho)
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *data = run->data;
    const double per_area = 1.0 / (run->tree->length * run->tree->length), *J = data->J + b->dn,
                 *W = data->W + b->dd, *kII = data->kII + b->v, *fbar = data->fbar + b->v;
    double *bound = run->load[i].bound, *U = data->U + b->dg, *G = data->G + b->dg,
           *mu = data->mu + b->v, *Mbar = data->Mbar + b->dd, *above = data->fbar + b->pred.v;
    const v4 k_w = three(kII), k_v = three(kII + 3);
    blocks c;
    column j = {.S_L = three(J), .S_p = three(J + 3), .armature = b->mass.armature[0]};
    mbsri_symmetrise(6, Mbar);
    matrix_to_blocks(Mbar, &c);
    double kappa = bound[0], spread = bound[1];
    for (int k = 0; k < 6; ++k) spread += W[7 * k] * (k < 3 ? per_area : 1.0);
    if (!certify_column(run->tree, bound[2], &c, &j, &kappa, &spread)) return false;
    put_three(U, j.U_L), put_three(U + 3, j.U_p);
    put_three(G, j.g_L), put_three(G + 3, j.g_p);
    data->D[b->nn] = j.D;
    data->Dinv[b->nn] = 1.0 / j.D;
    run->rank[i] = 1;
    data->scale[b->scalar_offset] = 0.0;
    /* mu = fbar + Mbar kII,  e = tau - J^T mu,  mu += G e,  X^T mu to the predecessor */
    v4 mu_L, mu_p;
    times_masses(&c, k_w, k_v, &mu_L, &mu_p);
    mu_L += three(fbar);
    mu_p += three(fbar + 3);
    const double e = data->tau[b->iu] - sum3(j.S_L * mu_L + j.S_p * mu_p);
    data->e[b->group.iu] = e;
    mu_L += j.g_L * splat(e);
    mu_p += j.g_p * splat(e);
    put_three(mu, mu_L), put_three(mu + 3, mu_p);
    put_three(above, three(above) + mu_L + cross(rho, mu_p));
    put_three(above + 3, three(above + 3) + mu_p);
    /* the bound, and Mbar^a */
    const double ratio = 1.0 + sqrt(sum3(rho * rho) * per_area);
    bound[0] = kappa;
    bound[1] = spread * ratio * ratio;
    subtract_dyad(j.g_L, j.g_p, j.U_L, j.U_p, &c);
    translate(rho, &c);
    add_blocks(&c, data->Mbar + b->pred.dd);
    return true;
}

/* Through body i by the bound, which is left for its predecessor in load[i].bound. */
MBSRI_OUTLINE bool pass_bounded(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    const int d = b->d, dp = b->pred.d, n = b->n;
    v4 rho;
    if (d == 6 && dp == 6 && n == 1 && is_translation(run->data->H + b->dp, &rho))
        return pass_hinge(run, i, rho);
    if (d == 6 && dp == 6) return pass_sized(run, i, 6, 6, n);
    if (d == 3 && dp == 3 && n == 1) return pass_sized(run, i, 3, 3, 1);
    return pass_sized(run, i, d, dp, n);
}

#endif
