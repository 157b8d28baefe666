/* Displaced poses, and derivatives of a joint's functions by differences: see move.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Derivatives are central differences of fourth order over steps of a thousandth of the change over
 * which the functions change (recursion/spans.h). Where only velocities change, those of second
 * order over a step of their size are exact: kII is quadratic in them, K', H', J' and q' are
 * linear. A joint without `rates` has K', H', J' by such differences along its motion, which are
 * then differenced once more. */
#include "newton/slopes/move.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/space3.h"
#include "base/memory.h"

#include <math.h>

static const double step = 1e-3; /* of the span */

/* ---- differences of a joint's functions ---- */

size_t mbsri_joint_mover_place(const mbsri_body *b, int np_pred, double *memory,
                               mbsri_joint_mover *w)
{
    const size_t d = (size_t)b->d, dp = (size_t)b->pred.d, n = (size_t)b->joint.n,
                 nq = (size_t)b->joint.nq, pred = (size_t)np_pred;
    size_t used = 0;
    double **const vector[] = {&w->q,      &w->q_on,      &w->qdot,    &w->u,
                               &w->p_pred, &w->p_pred_on, &w->dp_pred, &w->p,
                               &w->p_on,   &w->V_pred,    &w->V};
    const size_t length[] = {nq, nq, nq, n, pred, pred, pred, (size_t)b->np, (size_t)b->np, dp, d};
    for (size_t k = 0; k < sizeof length / sizeof length[0]; ++k)
        *vector[k] = mbsri_take(&memory, &used, length[k]);
    mbsri_joint_sample *const samples[] = {&w->sample, &w->inner};
    for (int k = 0; k < 2; ++k) {
        samples[k]->K = mbsri_take(&memory, &used, d * d);
        samples[k]->H = mbsri_take(&memory, &used, d * dp);
        samples[k]->J = mbsri_take(&memory, &used, d * n);
        samples[k]->k = mbsri_take(&memory, &used, d);
    }
    return used;
}

static bool unit_K(const mbsri_joint_mover *w)
{
    return (w->table->flags & MBSR_JOINT_UNIT_K) != 0;
}

/* The outputs of a joint's function as it finds them: K, if it writes one, the unit matrix or zero,
 * the rest zero. */
static void preset(const mbsri_joint_mover *w, const mbsr_joint_args *args, double unit,
                   const mbsri_joint_sample *s)
{
    const size_t d = (size_t)args->d;
    if (!unit_K(w)) mbsri_zero(d * d, s->K);
    for (size_t k = 0; k < d && !unit_K(w); ++k) s->K[k * (d + 1)] = unit;
    mbsri_zero(d * (size_t)args->pred_d, s->H);
    mbsri_zero(d * (size_t)args->n, s->J);
    mbsri_zero(d, s->k);
}

static void add(size_t count, double factor, const double *x, double *sum)
{
    for (size_t k = 0; k < count && sum; ++k) sum[k] += factor * x[k];
}

static void add_sample(const mbsr_joint_args *args, double factor, const mbsri_joint_sample *s,
                       double *K, double *H, double *J, double *k)
{
    const size_t d = (size_t)args->d;
    add(d * d, factor, s->K, K);
    add(d * (size_t)args->pred_d, factor, s->H, H);
    add(d * (size_t)args->n, factor, s->J, J);
    add(d, factor, s->k, k);
}

/* Sample of jacobians at args, whose pose is found first, into p. */
static int jacobians_at(const mbsri_joint_mover *w, mbsr_joint_args args, double *p,
                        mbsri_joint_sample *s, const char **name)
{
    args.p = args.V = args.V_pred = args.u = NULL;
    mbsri_zero((size_t)args.np, p);
    *name = "position";
    int status = w->table->position(&args, p);
    if (status) return status;
    args.p = p;
    preset(w, &args, 1.0, s);
    *name = "jacobians";
    return w->table->jacobians(&args, unit_K(w) ? NULL : s->K, s->H, s->J, s->k);
}

/* args displaced by h along `by`: q and the predecessor's pose. */
static mbsr_joint_args displace(const mbsri_joint_mover *w, const mbsr_joint_args *args,
                                const mbsr_joint_change *by, double h)
{
    mbsr_joint_args moved = *args;
    for (int k = 0; k < args->nq; ++k) w->q[k] = args->q[k] + h * by->q[k];
    moved.q = w->q;
    if (args->pred_space == MBSR_SPACE_FIXED) return moved;
    mbsri_pose_move(args->pred_space, w->np_pred, args->p_pred, by->p_pred, h, w->p_pred);
    moved.p_pred = w->p_pred;
    return moved;
}

int mbsri_joint_move_tangent(mbsri_joint_mover *w, const mbsr_joint_args *args,
                             const mbsr_joint_change *by, double *dp, double *dK, double *dH,
                             double *dJ, double *dkI, const char **name)
{
    const double h = step * w->span;
    for (int l = 0; l < 4; ++l) {
        const mbsr_joint_args moved = displace(w, args, by, mbsri_difference_place(l) * h);
        const int status = jacobians_at(w, moved, w->p, &w->sample, name);
        if (status) return status;
        add((size_t)args->np, mbsri_difference_weight(l) / (12.0 * h), w->p, dp);
        add_sample(args, mbsri_difference_weight(l) / (12.0 * h), &w->sample, dK, dH, dJ, dkI);
    }
    return MBSR_OK;
}

/* q' at args; into w->qdot. */
static int coordinate_rates(const mbsri_joint_mover *w, const mbsr_joint_args *args)
{
    mbsri_zero((size_t)args->nq, w->qdot);
    if (w->table->coordinate_rates) return w->table->coordinate_rates(args, w->qdot);
    mbsri_copy((size_t)args->n, args->u, w->qdot);
    return MBSR_OK;
}

/* K', H', J' at args as `rates` would write them, from jacobians along the motion. */
static int rates_by_motion(mbsri_joint_mover *w, const mbsr_joint_args *args, double *Kdot,
                           double *Hdot, double *Jdot, const char **name)
{
    *name = "coordinate_rates";
    int status = coordinate_rates(w, args);
    if (status) return status;
    const double whole = step / w->speed;
    const bool moves = args->pred_space != MBSR_SPACE_FIXED;
    if (moves)
        mbsri_pose_rate(args->pred_space, w->np_pred, args->p_pred, args->V_pred, w->dp_pred);
    for (int l = 0; l < 4 && !status; ++l) {
        const double h = mbsri_difference_place(l) * whole;
        mbsr_joint_args moved = *args;
        moved.t += h;
        for (int k = 0; k < args->nq; ++k) w->q_on[k] = args->q[k] + h * w->qdot[k];
        moved.q = w->q_on;
        if (moves) {
            mbsri_pose_move(args->pred_space, w->np_pred, args->p_pred, w->dp_pred, h,
                            w->p_pred_on);
            moved.p_pred = w->p_pred_on;
        }
        status = jacobians_at(w, moved, w->p_on, &w->inner, name);
        if (!status)
            add_sample(args, mbsri_difference_weight(l) / (12.0 * whole), &w->inner, Kdot, Hdot,
                       Jdot, NULL);
    }
    return status;
}

static int rates_at(mbsri_joint_mover *w, const mbsr_joint_args *args, double *Kdot, double *Hdot,
                    double *Jdot, const char **name)
{
    if (!w->table->rates) return rates_by_motion(w, args, Kdot, Hdot, Jdot, name);
    *name = "rates";
    return w->table->rates(args, Kdot, Hdot, Jdot);
}

int mbsri_joint_move_Kdot(mbsri_joint_mover *w, const mbsr_joint_args *args, double *Kdot,
                          double *Hdot, double *Jdot)
{
    const char *name;
    const size_t d = (size_t)args->d;
    mbsri_zero(d * d, Kdot);
    mbsri_zero(d * (size_t)args->pred_d, Hdot);
    mbsri_zero(d * (size_t)args->n, Jdot);
    return rates_at(w, args, Kdot, Hdot, Jdot, &name);
}

int mbsri_joint_move_rates(mbsri_joint_mover *w, const mbsr_joint_args *args,
                           const mbsr_joint_change *by, double *dkII, double *dKdot, double *dHdot,
                           double *dJdot, double *dqdot, const char **name)
{
    const double whole = w->still ? w->span : step * w->span;
    for (int l = 0; l < (w->still ? 2 : 4); ++l) {
        const double place = w->still ? 1.0 - 2.0 * l : mbsri_difference_place(l),
                     weight = (w->still ? 0.5 * place : mbsri_difference_weight(l) / 12.0) / whole,
                     h = place * whole;
        mbsr_joint_args moved = *args;
        if (!w->still) {
            moved = displace(w, args, by, h);
            mbsri_pose_move(w->space, args->np, args->p, by->p, h, w->p);
            moved.p = w->p;
        }
        for (int k = 0; k < args->n; ++k) w->u[k] = args->u[k] + h * by->u[k];
        for (int k = 0; k < args->pred_d; ++k) w->V_pred[k] = args->V_pred[k] + h * by->V_pred[k];
        for (int k = 0; k < args->d; ++k) w->V[k] = args->V[k] + h * by->V[k];
        moved.u = w->u, moved.V_pred = w->V_pred, moved.V = w->V;
        preset(w, args, 0.0, &w->sample);
        mbsri_joint_sample *s = &w->sample;
        *name = "bias";
        int status = w->table->bias(&moved, s->k);
        if (!status) status = rates_at(w, &moved, unit_K(w) ? NULL : s->K, s->H, s->J, name);
        if (!status && dqdot) {
            *name = "coordinate_rates";
            status = coordinate_rates(w, &moved);
        }
        if (status) return status;
        add_sample(args, weight, s, dKdot, dHdot, dJdot, dkII);
        if (dqdot) add((size_t)args->nq, weight, w->qdot, dqdot);
    }
    return MBSR_OK;
}
