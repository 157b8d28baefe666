/* The test of a joint's derivatives against differences of what its functions write.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * States beside the one of the test, at -2h, -h, h, 2h along a direction, with the pose from
 * `position` and V from (8), give differences (differences.h) of what the functions read there,
 * which are the `by` of the derivatives, and of what they write, which is what the derivatives
 * should be. The directions are those of single numbers, and one of all at once. */
#include "verify/joint_check_tangents.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "recursion/pose.h"
#include "verify/verifier.h"

#include <math.h>
#include <stdio.h>

enum { Q, POSE, U, V_PRED, PARTS };

/* ---- memory ---- */

static void lay_out_moving(const mbsri_verifier *w, mbsri_moving *x, double *memory, size_t *used)
{
    mbsri_verifier_lay_out_place(w, &x->at, memory, used);
    x->u = mbsri_verifier_take(memory, used, w->n, 1);
    x->V_pred = mbsri_verifier_take(memory, used, w->d_pred, 1);
    x->V = mbsri_verifier_take(memory, used, w->d, 1);
}

static void lay_out_written(const mbsri_verifier *w, mbsri_written *x, double *memory, size_t *used)
{
    x->p = mbsri_verifier_take(memory, used, w->np, 1);
    mbsri_verifier_lay_out_jacobians(w, &x->jacobians, memory, used);
    x->kII = mbsri_verifier_take(memory, used, w->d, 1);
    mbsri_verifier_lay_out_jacobians(w, &x->rates, memory, used);
    x->qdot = mbsri_verifier_take(memory, used, w->nq, 1);
}

void mbsri_verifier_lay_out_tangents(mbsri_verifier *w, double *memory, size_t *used)
{
    mbsri_written *const sets[] = {&w->tangents.sample, &w->tangents.expected, &w->tangents.given};
    lay_out_moving(w, &w->tangents.state, memory, used);
    lay_out_moving(w, &w->tangents.change, memory, used);
    for (int k = 0; k < 3; ++k) lay_out_written(w, sets[k], memory, used);
    w->tangents.scale = mbsri_verifier_take(memory, used, w->nq, 1);
    w->tangents.row = mbsri_verifier_take(memory, used, w->d, 1);
}

/* Numbers in K, H, J, kI; in all that is read; in all that is written, of it the part from kII. */
static size_t jacobians_size(const mbsri_verifier *w)
{
    return (size_t)w->d * (size_t)(w->d + w->d_pred + w->n + 1);
}

static size_t moving_size(const mbsri_verifier *w)
{
    return (size_t)(w->nq + w->np_pred + w->np + w->n + w->d_pred + w->d);
}

static size_t rates_size(const mbsri_verifier *w)
{
    return (size_t)(w->d + w->nq) + jacobians_size(w);
}

/* ---- what the functions write beside the state ---- */

/* p, V and all that is written, at q, u, p_pred, V_pred of w->moving. */
static int evaluate_moving(mbsri_verifier *w)
{
    const mbsr_joint_table *table = w->joint->table;
    mbsri_moving *x = &w->tangents.state;
    mbsri_written *out = &w->tangents.sample;
    mbsri_zero(rates_size(w), out->kII);
    int status = mbsri_verifier_pose(w, &x->at);
    if (!status) status = mbsri_verifier_jacobians(w, &x->at, &out->jacobians);
    if (status) return status;
    mbsri_copy((size_t)w->np, x->at.p, out->p);
    if (!table->rate_tangent) return MBSR_OK;
    status = mbsri_verifier_velocity(w, &out->jacobians, x->u, x->V_pred, x->V);
    if (status) return status;
    const mbsr_joint_args args = mbsri_verifier_args(w, &x->at, x->u, x->V_pred, x->V);
    status = mbsri_verifier_settle(w, table->bias(&args, out->kII), "bias", (size_t)w->d, out->kII);
    if (!status && table->rates) {
        mbsri_jacobians *rates = &out->rates;
        status =
            table->rates(&args, mbsri_verifier_unit_K(w) ? NULL : rates->K, rates->H, rates->J);
        status = mbsri_verifier_settle(w, status, "rates", jacobians_size(w), rates->K);
    }
    if (!status && table->coordinate_rates) {
        status = table->coordinate_rates(&args, out->qdot);
        status = mbsri_verifier_settle(w, status, "coordinate_rates", (size_t)w->nq, out->qdot);
    }
    return status;
}

/* How many directions the part has. */
static int directions(const mbsri_verifier *w, int part)
{
    switch (part) {
    case Q: return w->nq;
    case POSE: return mbsri_turns(w->at->pred_space) ? w->d_pred : w->np_pred;
    case U: return w->n;
    default: return w->d_pred;
    }
}

/* w->moving goes by s along direction k of the part; rates by s times the largest rate. */
static void displace_moving(mbsri_verifier *w, int part, int k, double s)
{
    mbsri_moving *x = &w->tangents.state;
    if (part == Q) {
        x->at.q[k] += s * w->tangents.scale[k];
    } else if (part == U) {
        x->u[k] += s * w->speed;
    } else if (part == V_PRED) {
        x->V_pred[k] += s * w->speed;
    } else if (!mbsri_turns(w->at->pred_space)) {
        x->at.p_pred[k] += s;
    } else {
        mbsri_zero((size_t)w->d_pred, w->unit);
        w->unit[k] = 1.0;
        mbsri_verifier_move(w, w->unit, s, x->at.p_pred);
    }
}

/* w->moving: s along direction k of the part, from the state itself; PARTS: along the mean of all,
 * where what is wrong along one of them shows less than along that one. */
static void place_beside(mbsri_verifier *w, int part, int k, double s)
{
    mbsri_moving *x = &w->tangents.state;
    x->at.t = w->base.t;
    mbsri_copy((size_t)w->nq, w->base.q, x->at.q);
    mbsri_copy((size_t)w->np_pred, w->base.p_pred, x->at.p_pred);
    mbsri_copy((size_t)w->n, w->at->u, x->u);
    mbsri_copy((size_t)w->d_pred, w->V_pred, x->V_pred);
    if (part < PARTS) {
        displace_moving(w, part, k, s);
        return;
    }
    int count = 0;
    for (int l = 0; l < PARTS; ++l) count += directions(w, l);
    for (int l = 0; l < PARTS; ++l) {
        for (int c = 0; c < directions(w, l); ++c) displace_moving(w, l, c, s / count);
    }
}

/* The change of what is read, and the slopes of what is written. */
static int find_written_slopes(mbsri_verifier *w, int part, int k)
{
    const size_t read = moving_size(w), written = (size_t)w->np + jacobians_size(w) + rates_size(w);
    const double h = w->at->step;
    mbsri_zero(read, w->tangents.change.at.q);
    mbsri_zero(written, w->tangents.expected.p);
    for (int l = 0; l < 4; ++l) {
        place_beside(w, part, k, mbsri_difference_place(l) * h);
        const int status = evaluate_moving(w);
        if (status) return status;
        const double weight = mbsri_difference_weight(l) / (12.0 * h);
        for (size_t c = 0; c < read; ++c)
            w->tangents.change.at.q[c] += weight * w->tangents.state.at.q[c];
        for (size_t c = 0; c < written; ++c)
            w->tangents.expected.p[c] += weight * w->tangents.sample.p[c];
    }
    return MBSR_OK;
}

/* A number of q moves as far in a direction of its own as it does with a unit of u, so that the
 * length of a quaternion does not count; those that do not move, as far as the one that moves
 * least. */
static int find_direction_scales(mbsri_verifier *w)
{
    double least = INFINITY;
    mbsri_zero((size_t)w->nq, w->tangents.scale);
    for (int c = 0; c < w->n; ++c) {
        mbsri_zero((size_t)w->n, w->unit);
        w->unit[c] = 1.0;
        const int status = mbsri_verifier_qdot(w, &w->base, w->unit);
        if (status) return status;
        for (int k = 0; k < w->nq; ++k)
            w->tangents.scale[k] = fmax(w->tangents.scale[k], fabs(w->qdot[k]));
    }
    for (int k = 0; k < w->nq; ++k) {
        if (w->tangents.scale[k] > 0.0) least = fmin(least, w->tangents.scale[k]);
    }
    for (int k = 0; k < w->nq; ++k) {
        if (!(w->tangents.scale[k] > 0.0)) w->tangents.scale[k] = isfinite(least) ? least : 1.0;
    }
    return MBSR_OK;
}

/* ---- the verdicts ---- */

enum { NAME = 64 };

/* "tangent along q(1): J" into a buffer of NAME; returns the buffer. */
static const char *label(char *buffer, const char *function, int part, int k, const char *what)
{
    static const char *const names[] = {"q", "the predecessor's pose", "u", "V_pred"};
    if (part < PARTS)
        snprintf(buffer, NAME, "%s along %s(%d): %s", function, names[part], k, what);
    else
        snprintf(buffer, NAME, "%s along all at once: %s", function, what);
    return buffer;
}

/* A unit of the rates of H and J, and of V itself, in V: largest entry of K^-1 (K, H, J) in each
 * row, with K^-1 as mbsri_verifier_velocity left it. */
static void find_rows(mbsri_verifier *w)
{
    for (int r = 0; r < w->d; ++r) w->tangents.row[r] = 1.0;
    for (int c = 0; c < w->d_pred + w->n; ++c) {
        mbsri_zero((size_t)w->d, w->inverse.work);
        mbsri_ax(w->d, w->d, 1.0, w->inverse.K, w->jacobians.given.H + (size_t)c * (size_t)w->d,
                 w->inverse.work);
        for (int r = 0; r < w->d; ++r)
            w->tangents.row[r] = fmax(w->tangents.row[r], fabs(w->inverse.work[r]));
    }
}

/* The unit of number k of the pose, or else of q'. */
static double unit_of_number(const mbsri_verifier *w, bool pose, int k)
{
    if (!pose) return w->speed * w->tangents.scale[k];
    if (mbsri_turns(w->joint->space))
        return k < MBSR_POSE_X ? mbsri_largest(3, w->tangents.row)
                               : w->tangents.row[3 + k - MBSR_POSE_X];
    return w->np == w->d ? w->tangents.row[k] : mbsri_largest(w->d, w->tangents.row);
}

/* Raises a field to the largest error of a pose or q', each number in its unit, compared with the
 * largest of them or with 1. */
static void compare_numbers(mbsri_verifier *w, double *field, const char *name, bool pose,
                            const double *given, const double *expected)
{
    const int count = pose ? w->np : w->nq;
    double size = 1.0;
    for (int k = 0; k < count; ++k)
        size = fmax(size, fmax(fabs(given[k]), fabs(expected[k])) / unit_of_number(w, pose, k));
    for (int k = 0; k < count; ++k) {
        mbsri_verifier_note(w, field,
                            fabs(given[k] - expected[k]) / (unit_of_number(w, pose, k) * size),
                            "%s(%d) is %.9g, by differences %.9g", name, k, given[k], expected[k]);
    }
}

static int verify_tangent(mbsri_verifier *w, int part, int k)
{
    const mbsri_written *given = &w->tangents.given, *expected = &w->tangents.expected;
    const mbsri_jacobians *x = &given->jacobians, *y = &expected->jacobians;
    const mbsr_joint_args args = mbsri_verifier_args(w, &w->base, NULL, NULL, NULL);
    const mbsr_joint_change by = {.q = w->tangents.change.at.q,
                                  .p_pred = w->tangents.change.at.p_pred};
    const size_t size = (size_t)w->np + jacobians_size(w);
    double *field = &w->errors->tangent;
    char name[NAME];
    mbsri_zero(size, given->p);
    int status = w->joint->table->tangent(
        &args, &by, given->p, mbsri_verifier_unit_K(w) ? NULL : x->K, x->H, x->J, x->kI);
    status = mbsri_verifier_settle(w, status, "tangent", size, given->p);
    if (status) return status;
#define NAMED(what) label(name, "tangent", part, k, what)
    compare_numbers(w, field, NAMED("p"), true, given->p, expected->p);
    if (!mbsri_verifier_unit_K(w))
        mbsri_verifier_compare(w, field, NAMED("K"), w->d, x->K, y->K, 1.0);
    mbsri_verifier_compare(w, field, NAMED("H"), w->d_pred, x->H, y->H, 1.0);
    mbsri_verifier_compare(w, field, NAMED("J"), w->n, x->J, y->J, 1.0);
    mbsri_verifier_compare(w, field, NAMED("kI"), 1, x->kI, y->kI, w->speed);
#undef NAMED
    return MBSR_OK;
}

static int verify_rate_tangent(mbsri_verifier *w, int part, int k)
{
    const mbsr_joint_table *table = w->joint->table;
    const mbsri_written *given = &w->tangents.given, *expected = &w->tangents.expected;
    const mbsri_jacobians *x = &given->rates, *y = &expected->rates;
    const mbsri_moving *dx = &w->tangents.change;
    const mbsr_joint_args args = mbsri_verifier_args(w, &w->base, w->at->u, w->V_pred, w->V);
    const mbsr_joint_change by = {dx->at.q, dx->u, dx->at.p_pred, dx->V_pred, dx->at.p, dx->V};
    double *field = &w->errors->rate_tangent;
    char name[NAME];
    mbsri_zero(rates_size(w), given->kII);
    int status = table->rate_tangent(&args, &by, given->kII, mbsri_verifier_unit_K(w) ? NULL : x->K,
                                     x->H, x->J, table->coordinate_rates ? given->qdot : NULL);
    status = mbsri_verifier_settle(w, status, "rate_tangent", rates_size(w), given->kII);
    if (status) return status;
#define NAMED(what) label(name, "rate_tangent", part, k, what)
    mbsri_verifier_compare(w, field, NAMED("kII"), 1, given->kII, expected->kII,
                           w->speed * w->speed);
    if (table->rates && !mbsri_verifier_unit_K(w))
        mbsri_verifier_compare(w, field, NAMED("Kdot"), w->d, x->K, y->K, w->speed);
    if (table->rates) {
        mbsri_verifier_compare(w, field, NAMED("Hdot"), w->d_pred, x->H, y->H, w->speed);
        mbsri_verifier_compare(w, field, NAMED("Jdot"), w->n, x->J, y->J, w->speed);
    }
    if (table->coordinate_rates)
        compare_numbers(w, field, NAMED("qdot"), false, given->qdot, expected->qdot);
#undef NAMED
    return MBSR_OK;
}

static int verify_direction(mbsri_verifier *w, int part, int k)
{
    const mbsr_joint_table *table = w->joint->table;
    const bool moves_velocities = part == U || part == V_PRED;
    if (moves_velocities && !table->rate_tangent) return MBSR_OK;
    int status = find_written_slopes(w, part, k);
    if (!status && table->tangent && !moves_velocities) status = verify_tangent(w, part, k);
    if (!status && table->rate_tangent) status = verify_rate_tangent(w, part, k);
    return status;
}

int mbsri_verify_tangents(mbsri_verifier *w)
{
    const mbsr_joint_table *table = w->joint->table;
    if (!table->tangent && !table->rate_tangent) return MBSR_OK;
    int count = 0;
    int status = find_direction_scales(w);
    if (!status)
        status = mbsri_verifier_velocity(w, &w->jacobians.given, w->at->u, w->V_pred, w->V);
    if (!status) find_rows(w);
    for (int part = 0; part < PARTS; ++part) {
        for (int k = 0; k < directions(w, part) && !status; ++k, ++count)
            status = verify_direction(w, part, k);
    }
    return status || count == 0 ? status : verify_direction(w, PARTS, 0);
}
