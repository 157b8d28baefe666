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
 * an inertia by function for M'. What a joint looks at is its own q and the pose of its
 * predecessor, which moves with V: these two are displaced, of one body alone. The rate of a pose
 * in GENERAL space is not known; behind such a body the whole tree is displaced. */
#include "recursion/rates.h"

#include "algebra/dense.h"
#include "recursion/inertia.h"
#include "recursion/kinematics.h"
#include "recursion/locks.h"
#include "recursion/pose.h"
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

static bool by_differences(const mbsri_body *b)
{
    return !analytic_joint(b) || !analytic_mass(b);
}

bool mbsri_rates_need_tree(const mbsri_body *b)
{
    return by_differences(b) && b->pred.space == MBSR_SPACE_GENERAL;
}

size_t mbsri_rates_room(const mbsr_model *m, const mbsri_body *b)
{
    if (!by_differences(b) || mbsri_rates_need_tree(b)) return 0;
    return 2 * ((size_t)b->nq + (size_t)m->body[b->parent].np);
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
    if (!unit_K) mbsri_zero(dd, Kdot);
    mbsri_zero((size_t)b->d * (size_t)b->pred.d, Hdot);
    double *all = b->lock.count ? spare + dd : Jdot; /* every column, those held included */
    mbsri_zero((size_t)b->d * (size_t)b->joint.n, all);
    const mbsr_joint_args args = mbsri_joint_args(m, d, i, true);
    const int status = b->joint.table->rates(&args, unit_K ? NULL : Kdot, Hdot, all);
    if (status) return mbsri_joint_failed(m, d, i, status, "rates");
    if (b->lock.count) mbsri_drop_held(b, all, Jdot);
    if (unit_K) return MBSR_OK;
    divide_by_K(b, d, Kdot, b->pred.d, d->H + b->dp, Hdot, spare);
    divide_by_K(b, d, Kdot, b->n, d->J + b->dn, Jdot, spare);
    return MBSR_OK;
}

/* ---- by differences ---- */

/* Of fourth order, over steps that change the state by about 1e-4 of its size. */
enum { SAMPLES = 4 };
static const double weight[SAMPLES] = {-1.0, 8.0, -8.0, 1.0},
                    place[SAMPLES] = {2.0, 1.0, -1.0, -2.0};

static void clear_rates(const mbsri_body *b, mbsr_data *d)
{
    mbsri_zero((size_t)(b->d * b->pred.d), d->Hdot + b->dp);
    mbsri_zero((size_t)(b->d * b->n), d->Jdot + b->dn);
    mbsri_zero((size_t)(b->d * b->d), d->Mdot + b->dd);
}

static void add_scaled(size_t count, double factor, const double *x, double *sum)
{
    for (size_t k = 0; k < count; ++k) sum[k] += factor * x[k];
}

/* Rates of body i += factor times H, J, M, where it has no analytic ones. */
static int add_rate_sample(const mbsr_model *m, mbsr_data *d, int i, double factor)
{
    const mbsri_body *b = m->body + i;
    if (!analytic_joint(b)) {
        add_scaled((size_t)(b->d * b->pred.d), factor, d->H + b->dp, d->Hdot + b->dp);
        add_scaled((size_t)(b->d * b->n), factor, d->J + b->dn, d->Jdot + b->dn);
    }
    if (analytic_mass(b)) return MBSR_OK;
    const int status =
        mbsri_inertia_velocity(b, d->t, d->p + b->p, d->V + b->v, d->M + b->dd, d->scratch);
    if (status) return mbsri_joint_failed(m, d, i, status, "the inertia's function");
    add_scaled((size_t)(b->d * b->d), factor, d->M + b->dd, d->Mdot + b->dd);
    return MBSR_OK;
}

/* Rate at which a body that is differenced, and its predecessor, change; qdot: of its joint. */
static double speed_of_differences(const mbsr_model *m, const mbsr_data *d, int i, const double *q,
                                   const double *qdot)
{
    const mbsri_body *b = m->body + i, *pred = m->body + b->parent;
    const mbsri_spans s = mbsri_spans_of(m, &b->joint.table->scales);
    double speed = mbsri_span_rate(&s);
    speed = fmax(speed, mbsri_twist_rate(&s, b, d->V + b->v));
    speed = fmax(speed, mbsri_twist_rate(&s, pred, d->V + b->pred.v));
    for (int k = 0; k < b->nq && b->joint.space == MBSR_SPACE_GENERAL; ++k) {
        const double span = mbsri_coordinate_span(&s, m, b, false, k);
        speed = fmax(speed, fabs(qdot[k]) / (span + fabs(q[k])));
    }
    return speed;
}

static double step_of(double speed)
{
    return 5e-4 / speed;
}

/* ---- one body ---- */

/* The arrays in `displaced`: what its joint looks at, and its rate. */
typedef struct view {
    mbsr_space space;
    int nq, np;
    double t, *q, *qdot, *pose, *rate; /* pose: of the predecessor */
} view;

static int open_view(const mbsr_model *m, mbsr_data *d, int i, view *at)
{
    const mbsri_body *b = m->body + i;
    *at = (view){.space = b->pred.space, .nq = b->nq, .np = m->body[b->parent].np, .t = d->t};
    at->q = d->displaced;
    at->qdot = at->q + at->nq;
    at->pose = at->qdot + at->nq;
    at->rate = at->pose + at->np;
    mbsri_copy((size_t)at->nq, d->q + b->iq, at->q);
    mbsri_copy((size_t)at->np, d->p + b->pred.p, at->pose);
    if (at->np > 0) mbsri_pose_rate(at->space, at->np, at->pose, d->V + b->pred.v, at->rate);
    return mbsri_coordinate_rates_of(m, d, i, at->qdot);
}

/* The body at a little later or earlier. */
static int move_on(const mbsr_model *m, mbsr_data *d, int i, const view *at, double h)
{
    const mbsri_body *b = m->body + i;
    d->t = at->t + h;
    for (int k = 0; k < at->nq; ++k) d->q[b->iq + k] = at->q[k] + h * at->qdot[k];
    if (at->np > 0) mbsri_pose_move(at->space, at->np, at->pose, at->rate, h, d->p + b->pred.p);
    return mbsri_position_of(m, d, i);
}

/* To where it was: numbers and all that is found from them. */
static int move_back(const mbsr_model *m, mbsr_data *d, int i, const view *at)
{
    const mbsri_body *b = m->body + i;
    d->t = at->t;
    mbsri_copy((size_t)at->nq, at->q, d->q + b->iq);
    mbsri_copy((size_t)at->np, at->pose, d->p + b->pred.p);
    const int status = mbsri_position_of(m, d, i);
    if (status || analytic_mass(b)) return status;
    return mbsri_inertia_velocity(b, d->t, d->p + b->p, d->V + b->v, d->M + b->dd, d->h + b->v);
}

static int differences_of(const mbsr_model *m, mbsr_data *d, int i)
{
    view at;
    int status = open_view(m, d, i, &at);
    if (status) return status;
    const double h = step_of(speed_of_differences(m, d, i, at.q, at.qdot));
    clear_rates(m->body + i, d);
    for (int k = 0; k < SAMPLES && !status; ++k) {
        status = move_on(m, d, i, &at, place[k] * h);
        if (!status) status = add_rate_sample(m, d, i, weight[k] / (12.0 * h));
    }
    const int back = move_back(m, d, i, &at);
    return status ? status : back;
}

/* ---- the whole tree ---- */

static int displaced(const mbsr_model *m, mbsr_data *d, double t, double h, double factor)
{
    for (int k = 0; k < m->nq; ++k) d->q_moved[k] = d->q_base[k] + h * d->qdot[k];
    int status = mbsri_positions(m, d, t + h, d->q_moved);
    for (int i = 1; i <= m->bodies && !status; ++i) {
        if (mbsri_rates_need_tree(m->body + i)) status = add_rate_sample(m, d, i, factor);
    }
    return status;
}

static int differences(const mbsr_model *m, mbsr_data *d)
{
    const double t = d->t;
    double speed = 0.0;
    int status = mbsri_coordinate_rates(m, d, d->qdot);
    if (status) return status;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_copy((size_t)b->nq, d->q + b->iq, d->q_base + b->q);
        mbsri_copy((size_t)b->n, d->u + b->iu, d->u_base + b->u);
        if (!mbsri_rates_need_tree(b)) continue;
        clear_rates(b, d);
        speed = fmax(speed, speed_of_differences(m, d, i, d->q_base + b->q, d->qdot + b->q));
    }
    const double h = step_of(speed);
    for (int k = 0; k < SAMPLES && !status; ++k)
        status = displaced(m, d, t, place[k] * h, weight[k] / (12.0 * h));
    if (!status) status = mbsri_positions(m, d, t, d->q_base);
    return status ? status : mbsri_velocities(m, d, d->u_base);
}

/* ---- all ---- */

int mbsri_joint_rates_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    int status = MBSR_OK;
    if (by_differences(b) && !mbsri_rates_need_tree(b)) status = differences_of(m, d, i);
    if (!status && analytic_joint(b)) status = joint_rates(m, d, i);
    return status;
}

int mbsri_rates_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int status = mbsri_joint_rates_of(m, d, i);
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
