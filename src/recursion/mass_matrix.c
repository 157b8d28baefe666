/* Joint-space mass matrix by composite inertias.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   C_i = M_i + sum_j H_j^T C_j H_j,     block (i,i) = J_i^T C_i J_i + Diag(armature),
 *   block (k,i) = J_k^T m_k  for the predecessors k of i, with m_i = C_i J_i and m_pi = -H^T m
 *                 on the way to the root.
 *
 * Where a diagonal entry is a small difference of large numbers, in twofold precision. */
#include "recursion/mass_matrix.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/exact.h"

/* Row block of predecessor k times column block of body i; m: d_k x n_i. */
static void place_mass_block(const mbsr_model *m, const mbsr_data *d, int k, int i,
                             const double *momentum, double *matrix)
{
    const mbsri_body *row = m->body + k, *column = m->body + i;
    const size_t nu = (size_t)m->nu;
    for (int b = 0; b < column->n; ++b) {
        for (int a = 0; a < row->n; ++a) {
            const double value = mbsri_dot(row->d, d->J + row->dn + (size_t)a * (size_t)row->d,
                                           momentum + (size_t)b * (size_t)row->d);
            matrix[(size_t)(column->u + b) * nu + (size_t)(row->u + a)] = value;
            matrix[(size_t)(row->u + a) * nu + (size_t)(column->u + b)] = value;
        }
    }
}

/* Whether a diagonal entry of the joint of body i is so much smaller than what cancels in it that
 * it has lost some of nine digits: beyond 1e-6 it has not. C: d x d. */
static bool loses_digits(const mbsri_body *b, const double *J, const double *C,
                         const double *matrix, size_t nu)
{
    double turning = 0.0, sliding = 0.0;
    if (b->joint.space != MBSR_SPACE_SPATIAL) return false;
    for (int k = 0; k < 3; ++k) turning += C[7 * k], sliding += C[7 * (3 + k)];
    for (int l = 0; l < b->n; ++l, J += 6) {
        const double size = turning * mbsri_dot(3, J, J) + sliding * mbsri_dot(3, J + 3, J + 3),
                     entry = matrix[(size_t)(b->u + l) * (nu + 1)];
        if (!(entry >= 1e-6 * size)) return true;
    }
    return false;
}

/* C_pi += H_i^T C_i H_i;  work: max_d x max_d. */
static void pass_composite_on(const mbsri_body *b, const mbsr_data *d, double *C, double *work)
{
    mbsri_congruence(b->d, b->pred.d, d->H + b->dp, C + b->dd, C + b->pred.dd, work);
}

/* C = M, in the place of Mbar, so mbsr_stage_backward must run again. */
static double *begin_composite(const mbsr_model *m, mbsr_data *d)
{
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    mbsri_copy(m->size.dd, d->M, d->Mbar);
    return d->Mbar;
}

/* In double precision; whether some digits were lost. */
static bool composites(const mbsr_model *m, mbsr_data *d, double *matrix)
{
    double *C = begin_composite(m, d), *now = d->scratch,
           *next = now + (size_t)m->most.d * (size_t)m->most.d;
    bool lost = false;
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        /* m_i = C_i J_i */
        mbsri_zero((size_t)b->d * (size_t)b->n, now);
        mbsri_ab(b->d, b->d, b->n, 1.0, C + b->dd, d->J + b->dn, now);
        for (int k = i; k > 0; k = m->body[k].parent) {
            const mbsri_body *row = m->body + k;
            place_mass_block(m, d, k, i, now, matrix);
            /* m_pi = -H_k^T m_k */
            mbsri_zero((size_t)row->pred.d * (size_t)b->n, next);
            mbsri_atb(row->d, row->pred.d, b->n, -1.0, d->H + row->dp, now, next);
            mbsri_copy((size_t)row->pred.d * (size_t)b->n, next, now);
        }
        lost = lost || loses_digits(b, d->J + b->dn, C + b->dd, matrix, (size_t)m->nu);
        pass_composite_on(b, d, C, next);
    }
    return lost;
}

void mbsri_mass_diagonal(const mbsr_model *m, mbsr_data *d, double *diagonal)
{
    double *C = begin_composite(m, d), *momentum = d->scratch, *work = momentum + m->most.d;
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const double *column = d->J + b->dn + (size_t)k * (size_t)b->d;
            mbsri_zero((size_t)b->d, momentum);
            mbsri_ax(b->d, b->d, 1.0, C + b->dd, column, momentum);
            diagonal[b->u + k] = mbsri_dot(b->d, column, momentum) + b->mass.armature[k];
        }
        pass_composite_on(b, d, C, work);
    }
}

void mbsri_mass_matrix(const mbsr_model *m, mbsr_data *d, double *matrix)
{
    const size_t size = (size_t)m->nu * (size_t)m->nu;
    mbsri_zero(size, matrix);
    if (composites(m, d, matrix)) {
        mbsri_exact_mass_matrix(m, d, matrix);
        /* products of twofold numbers overflow early */
        if (!mbsri_finite(size, matrix)) (void)composites(m, d, matrix);
    }
    for (size_t k = 0; k < (size_t)m->nu; ++k)
        matrix[(size_t)m->order.u_of[k] * ((size_t)m->nu + 1)] += m->armature[k];
}

/* a = -(H a_pred + J x), and the momenta back along the tree. */
void mbsri_mass_product(const mbsr_model *m, const mbsr_data *d, const double *x, double *result,
                        double *work)
{
    double *a = work, *p = a + m->size.v;
    mbsri_zero(2 * m->size.v, work);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, a + b->pred.v, a + b->v);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, x + b->iu, a + b->v);
        mbsri_ax(b->d, b->d, 1.0, d->M + b->dd, a + b->v, p + b->v);
    }
    for (int k = 0; k < m->nu; ++k) result[k] = m->armature[k] * x[k];
    for (int i = m->bodies; i > 0; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, p + b->v, result + b->iu);
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, p + b->v, p + b->pred.v);
    }
}
