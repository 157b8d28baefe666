/* Closures in the momentum form.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The multipliers stand in y as their integrals, Lambda of the m velocity rows and Eta of the h
 * position rows, so that the loop forces lambda = Lambda' come with y':
 *
 *   q' = G (u + w C_h^T Eta')          p' = (.) + C^T Lambda'
 *   0 = C u + g_t                      0 = g(q, t)
 *
 * On solutions Eta does not change: the velocity rows keep the position rows, and Eta takes what
 * discretisation leaves. The weights w, one a joint rate, are inverse inertias of the model
 * (assembly/survey.c): no units are preferred by them, and no mass matrix stands there, which may
 * be singular. With p - C^T Lambda and q - w C_h^T Eta as differential unknowns u, Lambda and Eta
 * follow from algebraic equations that are regular where C has full rank and no direction that
 * closures allow moves without mass: index 1, as the tree has it.
 *
 * Row k that is dropped, being redundant: 0 = Lambda_k, 0 = Eta_k, and no force. Stiff row, with
 * stiffness k and damping d: the place of Lambda_k holds the force s of the spring alone,
 *
 *   lambda = -(s + (d / k) s')         0 = s' / k - (C u + g_t)         0 = g - s / k
 *
 * in which nothing grows with k. Where rows depend on each other, springs share the force by their
 * stiffness, and the velocity rows alone say how; Eta would not be determined. Of a stiff row that
 * is dropped its position row is left out therefore, 0 = Eta_k: with those of the others it follows
 * from its velocity row, and no rounding of g is multiplied by k. */
#include "forms/loops.h"

#include "algebra/dense.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

static const mbsri_closure *first(const mbsr_model *m)
{
    return m->closures.data;
}

int mbsri_loops_pack(const mbsr_model *m, mbsr_data *d, double *x)
{
    double *g = x + m->rows;
    const int status = mbsri_closure_gaps(m, d, g);
    if (status) return status;
    mbsri_zero((size_t)m->rows, x);
    for (const mbsri_closure *c = first(m), *end = c + m->closures.count; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k)
            x[c->row + k] = c->def.stiffness[k] * g[c->position_row + k];
    }
    mbsri_zero((size_t)m->position_rows, g);
    return MBSR_OK;
}

void mbsri_loops_take(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp)
{
    const double *etadot = xp + m->rows;
    mbsri_zero((size_t)m->rows, d->loop_eta);
    for (const mbsri_closure *c = first(m), *end = c + m->closures.count; c < end; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const int row = c->row + k;
            if (mbsri_is_stiff(c, k))
                d->loop_lambda[row] = -(x[row] + c->def.damping[k] / c->def.stiffness[k] * xp[row]);
            else
                d->loop_lambda[row] = d->dropped[row] ? 0.0 : xp[row];
            if (k < c->position_rows && !d->dropped[row])
                d->loop_eta[row] = etadot[c->position_row + k];
        }
    }
}

int mbsri_loops_coordinate_rates(const mbsr_model *m, mbsr_data *d, double *qdot)
{
    double *along = d->closure_w, *u = d->w;
    mbsri_closure_transpose(m, d, d->loop_eta, NULL);
    mbsri_copy((size_t)m->nu, d->u, u);
    for (int k = 0; k < m->nu; ++k) d->u[k] += m->typical.weight[k] * along[k];
    const int status = mbsri_coordinate_rates(m, d, qdot);
    mbsri_copy((size_t)m->nu, u, d->u);
    return status;
}

int mbsri_loops_residual(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp,
                         double *F)
{
    const double *Eta = x + m->rows;
    double *velocity = F, *place = F + m->rows;
    const int status = mbsri_closure_errors(m, d, velocity, place);
    if (status) return status;
    for (const mbsri_closure *c = first(m), *end = c + m->closures.count; c < end; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const int row = c->row + k, held = c->position_row + k;
            const double stiffness = c->def.stiffness[k];
            if (stiffness > 0.0) {
                velocity[row] = xp[row] / stiffness - velocity[row];
                place[held] = d->dropped[row] ? Eta[held] : place[held] - x[row] / stiffness;
            } else if (d->dropped[row]) {
                velocity[row] = x[row];
                if (k < c->position_rows) place[held] = Eta[held];
            }
        }
    }
    return MBSR_OK;
}
