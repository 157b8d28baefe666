/* Rates of H, J and M along the motion, which the momentum form needs.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With K divided out (kinematics.c), K = I and
 *
 *   H' <- K^-1 (H' - K' H),   J' <- K^-1 (J' - K' J)
 *
 * where H and J on the right are divided by K already.
 *
 * A joint says what K', H', J' are, or leaves it to central differences along (t, q, q'); so does
 * an inertia by function for M'. */
#include "recursion/rates.h"

#include "algebra/dense.h"
#include "recursion/inertia.h"
#include "recursion/kinematics.h"
#include "recursion/locks.h"
#include "recursion/spans.h"

#include <math.h>

static bool analytic_joint(const mbsri_body *b)
{
    return b->joint.table->rates != NULL;
}

static bool analytic_mass(const mbsri_body *b)
{
    return b->inertia.kind != MBSR_INERTIA_FUNCTION;
}

bool mbsri_rates_by_differences(const mbsri_body *b)
{
    return !analytic_joint(b) || !analytic_mass(b);
}

/* X' <- K^-1 (X' - K' X) for `columns` columns; Kdot d x d, spare: d x columns of scratch. */
static void divide_by_K(const mbsri_body *b, const mbsr_data *d, const double *Kdot, int columns,
                        const double *X, double *Xdot, double *spare)
{
    const size_t size = (size_t)b->d * (size_t)columns;
    mbsri_copy(size, Xdot, spare);
    mbsri_ab(b->d, b->d, columns, -1.0, Kdot, X, spare);
    mbsri_zero(size, Xdot);
    mbsri_ab(b->d, b->d, columns, 1.0, d->Kinv + b->k, spare, Xdot);
}

static int joint_rates(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const bool unit_K = (b->joint.table->flags & MBSR_JOINT_UNIT_K) != 0;
    const size_t dd = (size_t)b->d * (size_t)b->d;
    double *Kdot = d->scratch, *spare = Kdot + dd, *Hdot = d->Hdot + b->dp, *Jdot = d->Jdot + b->dn;
    mbsri_zero(dd, Kdot);
    mbsri_zero((size_t)b->d * (size_t)b->d_pred, Hdot);
    double *all = b->locks ? spare + dd : Jdot; /* every column, those held included */
    mbsri_zero((size_t)b->d * (size_t)b->joint.n, all);
    const mbsr_joint_args args = mbsri_joint_args(m, d, i, true);
    const int status = b->joint.table->rates(&args, unit_K ? NULL : Kdot, Hdot, all);
    if (status) return mbsri_joint_failed(m, d, i, status, "rates");
    if (b->locks) mbsri_drop_held(b, all, Jdot);
    if (unit_K) return MBSR_OK;
    divide_by_K(b, d, Kdot, b->d_pred, d->H + b->dp, Hdot, spare);
    divide_by_K(b, d, Kdot, b->n, d->J + b->dn, Jdot, spare);
    return MBSR_OK;
}

/* Kinematics a little later or earlier than the state in `base`; adds factor times H, J, M to the
 * rates of those bodies that have no analytic ones. */
static int displaced(const mbsr_model *m, mbsr_data *d, double t, double h, double factor)
{
    for (int k = 0; k < m->nq; ++k) d->q_moved[k] = d->q_base[k] + h * d->qdot[k];
    int status = mbsri_positions(m, d, t + h, d->q_moved);
    for (int i = 1; i <= m->bodies && !status; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t dd = (size_t)b->d * (size_t)b->d;
        if (!analytic_joint(b)) {
            for (size_t k = b->dp; k < b->dp + (size_t)b->d * (size_t)b->d_pred; ++k) {
                d->Hdot[k] += factor * d->H[k];
            }
            for (size_t k = b->dn; k < b->dn + (size_t)b->d * (size_t)b->n; ++k) {
                d->Jdot[k] += factor * d->J[k];
            }
        }
        if (!analytic_mass(b)) {
            status =
                mbsri_inertia_velocity(b, d->t, d->p + b->p, d->V + b->v, d->M + b->dd, d->scratch);
            if (status) return mbsri_joint_failed(m, d, i, status, "the inertia's function");
            for (size_t k = b->dd; k < b->dd + dd; ++k) d->Mdot[k] += factor * d->M[k];
        }
    }
    return status;
}

/* Largest rate at which the bodies that are differenced, and their predecessors, change. */
static double speed_of(const mbsr_model *m, const mbsr_data *d)
{
    double speed = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i, *pred = m->body + b->parent;
        if (!mbsri_rates_by_differences(b)) continue;
        const mbsri_spans s = mbsri_spans_of(m, &b->joint.table->scales);
        speed = fmax(speed, mbsri_span_rate(&s));
        speed = fmax(speed, mbsri_twist_rate(&s, b, d->V + b->v));
        speed = fmax(speed, mbsri_twist_rate(&s, pred, d->V + b->pred_v));
        for (int k = 0; k < b->nq && b->joint.space == MBSR_SPACE_GENERAL; ++k) {
            const double span = mbsri_coordinate_span(&s, m, b, false, k);
            speed = fmax(speed, fabs(d->qdot[b->q + k]) / (span + fabs(d->q_base[b->q + k])));
        }
    }
    return speed;
}

/* Differences of fourth order over steps that change the state by about 1e-4 of its size. */
static int differences(const mbsr_model *m, mbsr_data *d)
{
    const double t = d->t;
    int status = mbsri_coordinate_rates(m, d, d->qdot);
    if (status) return status;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_copy((size_t)b->nq, d->q + b->iq, d->q_base + b->q);
        mbsri_copy((size_t)b->n, d->u + b->iu, d->u_base + b->u);
    }
    mbsri_zero(m->size_dp, d->Hdot);
    mbsri_zero(m->size_dn, d->Jdot);
    mbsri_zero(m->size_dd, d->Mdot);
    const double h = 5e-4 / speed_of(m, d);
    static const double weight[] = {-1.0, 8.0, -8.0, 1.0}, place[] = {2.0, 1.0, -1.0, -2.0};
    for (int k = 0; k < 4 && !status; ++k)
        status = displaced(m, d, t, place[k] * h, weight[k] / (12.0 * h));
    /* back to where it was */
    if (!status) status = mbsri_positions(m, d, t, d->q_base);
    return status ? status : mbsri_velocities(m, d, d->u_base);
}

int mbsri_rates_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int status = analytic_joint(b) ? joint_rates(m, d, i) : MBSR_OK;
    if (analytic_mass(b))
        mbsri_inertia_mass_rate(b, d->p + b->p, d->V + b->v, d->M + b->dd, d->Mdot + b->dd);
    return status;
}

int mbsri_rates(const mbsr_model *m, mbsr_data *d)
{
    int status = m->differences ? differences(m, d) : MBSR_OK;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->Mdot);
    for (int i = 1; i <= m->bodies && !status; ++i) status = mbsri_rates_of(m, d, i);
    return status;
}
