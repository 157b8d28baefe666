/* Rounding errors on their way through the backward recursion: see errors.h and backward.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/errors.h"

#include "algebra/dense.h"
#include "joints/chain.h"
#include "recursion/modal.h"
#include "recursion/pose.h"

#include <math.h>

void mbsri_diagonal_sizes(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                          double *size)
{
    for (int i = 0; i < g->members; ++i) {
        const mbsri_body *b = m->body + g->member[i];
        const int dim = b->d;
        const double *Mbar = d->Mbar + b->dd, *J = d->J + b->dn;
        for (int l = 0; l < b->n; ++l) {
            double sum = b->mass.armature[l];
            for (int k = 0; k < mbsri_upper_rows(b); ++k)
                sum += J[l * dim + k] * Mbar[k * (dim + 1)] * J[l * dim + k];
            if (b->flexible.modal) sum += Mbar[(MBSRI_FRAME_ROWS + l) * (dim + 1)];
            size[b->group.iu - g->ig + l] = sum;
        }
    }
}

/* E -= (Q - G JQ / 2) G^T + its transpose, and += G Diag(size) G^T along its diagonal; Q gets lost.
 */
static inline void pass_joint(int rows, int n, const double *G, const double *JQ,
                              const double *size, double *Q, double *E)
{
    mbsri_ab(rows, n, n, -0.5, G, JQ, Q);
    mbsri_abt(rows, n, rows, -1.0, Q, G, E);
    mbsri_abt(rows, n, rows, -1.0, G, Q, E);
    for (int l = 0; l < n; ++l) {
        for (int k = 0; k < rows; ++k)
            E[k * (rows + 1)] += size[l] * G[l * rows + k] * G[l * rows + k];
    }
    mbsri_symmetrise(rows, E);
}

/* P = I - J G^T, so P^T W P = W - Q G^T - G Q^T + G (J^T Q) G^T with Q = W J; both as U and D of a
 * group. Q: d x n, JQ: n x n of scratch. */
void mbsri_carry_errors(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                        const double *W, double share, int rows, double *E, double *Q, double *JQ,
                        double *work)
{
    const mbsri_body *b = m->body + g->member[0];
    const int dim = b->d, n = g->n;
    const double *G = d->G + b->dg, *Mbar = d->Mbar + b->dd, *lambda = d->lambda + g->ig,
                 *s = d->s + g->ig;
    const bool deficient = n > 1 && mbsri_group_rank(d, g) < n;
    mbsri_group_products(m, d, g, W, Q, JQ, work);
    if (rows < dim) {
        double *upper = work + rows * n;
        mbsri_upper(rows, dim, n, Q, upper);
        mbsri_upper(rows, dim, n, G, work);
        Q = upper, G = work, work = upper + rows * n;
    }
    mbsri_upper(rows, dim, rows, W + b->dd, E);
    for (int k = 0; k < rows; ++k) E[k * (rows + 1)] += share * Mbar[k * (dim + 1)];
    double *size = work;
    mbsri_diagonal_sizes(m, d, g, size);
    for (int l = 0; l < n; ++l) {
        if (deficient) size[l] = fmax(size[l], lambda[0] / (s[l] * s[l]));
        size[l] *= share;
    }
    if (rows == 3 && n == 1) /* sizes known to the compiler */
        pass_joint(3, 1, G, JQ, size, Q, E);
    else if (rows == 6 && n == 1)
        pass_joint(6, 1, G, JQ, size, Q, E);
    else
        pass_joint(rows, n, G, JQ, size, Q, E);
}

double mbsri_own_rotated(const mbsri_body *b, const double *M)
{
    const int next = b->d + 1;
    return mbsri_turns(b->joint.space) ? M[0] + M[next] + M[2 * next] : 0.0;
}

double mbsri_trace_of_arms(const mbsri_body *b, const double *H, const double *A)
{
    double square = 0.0;
    const int d = b->d, next = d + 1;
    if (!mbsri_turns(b->joint.space) || !mbsri_turns(b->pred.space)) return 0.0;
    for (int c = 0; c < 3; ++c) square += mbsri_dot(3, H + d * c + 3, H + d * c + 3);
    if (b->joint.table->position == mbsri_chain_position) {
        const double *x = b->joint.param + MBSRI_A;
        square = fmax(square, 2.0 * mbsri_dot(3, x, x));
    }
    return 0.5 * square * fmax(A[3 * next], fmax(A[4 * next], A[5 * next]));
}

/* m |r|^2 of the body, r from its predecessor's origin: out of H, as a difference of positions it
 * would be lost where the tree is far away. */
static double squared_arm(const mbsr_data *d, const mbsri_body *b)
{
    const double *x = d->p + b->p + MBSR_POSE_X, *A = d->Mbar + b->dd;
    const int next = b->d + 1;
    if (b->pred.space == MBSR_SPACE_SPATIAL) return mbsri_trace_of_arms(b, d->H + b->dp, A);
    return mbsri_dot(3, x, x) * fmax(A[3 * next], fmax(A[4 * next], A[5 * next]));
}

double mbsri_rotated_along(const mbsr_data *d, const mbsri_body *b, int l)
{
    if (!mbsri_turns(b->joint.space)) return 0.0;
    const double *J = d->J + b->dn + (size_t)(l * b->d);
    const bool arm =
        b->n > 1 && b->joint.space == MBSR_SPACE_SPATIAL && mbsri_dot(3, J + 3, J + 3) > 0.0;
    return mbsri_dot(3, J, J) * (d->rotated[b->scalar_offset] + (arm ? squared_arm(d, b) : 0.0));
}
