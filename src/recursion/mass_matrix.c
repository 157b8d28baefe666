/* Joint-space mass matrix by composite inertias.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   C_i = M_i + sum_j H_j^T C_j H_j,     block (i,i) = J_i^T C_i J_i,
 *   block (k,i) = J_k^T m_k  for the predecessors k of i, with m_i = C_i J_i and m_pi = -H^T m
 *                 on the way to the root. */
#include "recursion/mass_matrix.h"

#include "algebra/dense.h"

/* Row block of predecessor k times column block of body i; m: d_k x n_i. */
static void place(const mbsr_model *m, const mbsr_data *d, int k, int i, const double *momentum,
                  double *matrix)
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

void mbsri_mass_matrix(const mbsr_model *m, mbsr_data *d, double *matrix)
{
    /* C in the place of Mbar, so mbsr_backward must run again */
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    double *C = d->Mbar, *now = d->scratch, *next = now + (size_t)m->max_d * (size_t)m->max_d;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    mbsri_copy(m->size_dd, d->M, C);
    mbsri_zero((size_t)m->nu * (size_t)m->nu, matrix);

    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        /* m_i = C_i J_i */
        mbsri_zero((size_t)b->d * (size_t)b->n, now);
        mbsri_ab(b->d, b->d, b->n, 1.0, C + b->dd, d->J + b->dn, now);
        for (int k = i; k > 0; k = m->body[k].parent) {
            const mbsri_body *row = m->body + k;
            place(m, d, k, i, now, matrix);
            /* m_pi = -H_k^T m_k */
            mbsri_zero((size_t)row->d_pred * (size_t)b->n, next);
            mbsri_atb(row->d, row->d_pred, b->n, -1.0, d->H + row->dp, now, next);
            mbsri_copy((size_t)row->d_pred * (size_t)b->n, next, now);
        }
        /* C_pi += H_i^T C_i H_i */
        mbsri_congruence(b->d, b->d_pred, d->H + b->dp, C + b->dd, C + b->pred_dd, next);
    }
}
