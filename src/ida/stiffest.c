/* The force elements whose stiffness fails error tests and Newton's method.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the direction v (joint rates) that the filter took off an error last, an element with the
 * energy E(q) and the dissipated power P(q, u) adds
 *
 *   s = E'' + c P'' / 2,    c of the step: d E / d q twice along G v, P twice along v
 *
 * to v^T K v. Both are quadratic in v for springs and dampers: second differences. Where Newton's method
 * failed its corrections lie across the stiff direction, which is not known: there it is the sum of
 * s / M_jj over the unit vectors v of the coordinates, squares of frequencies, to be compared with c^2 of the
 * longest step so far: the present one may be very short where nothing converges. */
#include "ida/stiffest.h"

#include "ida/bend.h"
#include "ida/error.h"
#include "ida/stiff.h"

#include <mbsrank/dynamics.h>

#include <float.h>
#include <math.h>

/* Where velocities begin in y. */
static int velocities(const mbsr_ida *ida)
{
    const int nq = mbsr_model_nq(ida->model);
    return ida->opt.form == MBSR_DAE_MOMENTUM ? nq + mbsr_model_nu(ida->model) : nq;
}

/* Positions and velocities at q + step G v, u + step v; q and u stand in y. */
static int move(mbsr_ida *ida, double step, const double *y, const double *v, double *work)
{
    const mbsr_model *m = ida->model;
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    const double *u = y + velocities(ida);
    const mbsri_stiff *s = mbsri_stiff_of(ida->nonlinear);
    double *q = work, *w = work + nq;
    int status = mbsr_positions(m, ida->data, s->at, y);
    if (!status) status = mbsr_velocities(m, ida->data, v);
    if (!status) status = mbsr_coordinate_rates(m, ida->data, q);
    for (int k = 0; k < nq; ++k) q[k] = y[k] + step * q[k];
    for (int k = 0; k < nu; ++k) w[k] = u[k] + step * v[k];
    if (!status) status = mbsr_positions(m, ida->data, s->at, q);
    return status ? status : mbsr_velocities(m, ida->data, w);
}

/* The step along v: small beside what moves, and well above rounding. */
static double extent(const mbsr_ida *ida, const double *v)
{
    double largest = 0.0;
    for (int k = 0; k < mbsr_model_nu(ida->model); ++k) largest = fmax(largest, fabs(v[k]));
    return largest > 0.0 ? cbrt(DBL_EPSILON) / largest : 0.0;
}

/* Adds factor (E / step^2, c P / 2 step^2) of each element, where the data stands, to s. */
static int add(mbsr_ida *ida, double factor, double c, double *s)
{
    int status = MBSR_OK;
    for (int k = 0; k < mbsr_model_forces(ida->model) && !status; ++k) {
        double energy = 0.0, power = 0.0;
        if (mbsr_force_closure(ida->model, k) != MBSR_NONE) continue;
        status = mbsr_force_power(ida->model, ida->data, k, &energy, &power);
        s[k] += factor * (energy + 0.5 * c * power);
    }
    return status;
}

/* Adds factor s of each element along v, in `ida->moved`, to sum. */
static int along(mbsr_ida *ida, const double *v, double c, double factor, double *sum)
{
    const double *y = N_VGetArrayPointer(ida->moved), step = extent(ida, v);
    int status = MBSR_OK;
    for (int side = -1; side <= 1 && !status && step > 0.0; ++side) {
        status = move(ida, side * step, y, v, N_VGetArrayPointer(ida->work));
        if (!status) status = add(ida, factor * (side ? 1.0 : -2.0) / (step * step), c, sum);
    }
    return status;
}

/* v^T M v */
static int mass_of(mbsr_ida *ida, const double *v, double *mass)
{
    const double *y = N_VGetArrayPointer(ida->moved);
    double kinetic = 0.0, potential = 0.0;
    int status = mbsr_positions(ida->model, ida->data, mbsri_stiff_of(ida->nonlinear)->at, y);
    if (!status) status = mbsr_velocities(ida->model, ida->data, v);
    if (!status) status = mbsr_energy(ida->model, ida->data, &kinetic, &potential);
    *mass = 2.0 * kinetic;
    return status;
}

/* All coordinates that move mass. */
static int along_all(mbsr_ida *ida, double c, double *sum)
{
    const int nu = mbsr_model_nu(ida->model);
    double *v = N_VGetArrayPointer(mbsri_stiff_of(ida->nonlinear)->trial);
    int status = MBSR_OK;
    for (int k = 0; k < nu; ++k) v[k] = 0.0;
    for (int k = 0; k < nu && !status; ++k) {
        double mass = 0.0;
        v[k] = 1.0;
        status = mass_of(ida, v, &mass);
        if (!status && mass > 0.0) status = along(ida, v, c, 1.0 / mass, sum);
        v[k] = 0.0;
    }
    return status;
}

/* s of all elements; *least is what they have to exceed in sum to be worth mentioning. */
static int find(mbsr_ida *ida, double *s, double *least)
{
    const mbsri_stiff *stiff = mbsri_stiff_of(ida->nonlinear);
    double c = 0.0;
    IDAGetCurrentCj(ida->memory, &c);
    c = fabs(c);
    if (stiff->of_iteration && stiff->slowest > 0.0) c = fmin(c, stiff->slowest);
    N_VScale(1.0, stiff->state, ida->moved);
    mbsri_ida_add_bend(ida, stiff->at, 0, ida->moved);
    *least = stiff->of_iteration ? c * c : 0.0;
    return stiff->of_iteration
               ? along_all(ida, c, s)
               : along(ida, N_VGetArrayPointer(stiff->direction) + velocities(ida), c, 1.0, s);
}

/* The largest of s that is not among the `known` first ones; MBSR_NONE: none is positive. */
static int largest(const double *s, int forces, int known, const int *taken)
{
    int best = MBSR_NONE;
    for (int k = 0; k < forces; ++k) {
        bool again = false;
        for (int j = 0; j < known; ++j) again = again || taken[j] == k;
        if (!again && s[k] > 0.0 && (best == MBSR_NONE || s[k] > s[best])) best = k;
    }
    return best;
}

/* Whether there is a direction. */
static bool known(const mbsr_ida *ida)
{
    if (!ida->nonlinear || ida->opt.form == MBSR_DAE_INDEX1) return false;
    const mbsr_sundials_stiff_info *info = &mbsri_stiff_of(ida->nonlinear)->info;
    return info->stiff_tests > 0 || info->careful_failures > 0;
}

int mbsr_ida_stiffest(mbsr_ida *ida, int most, int *force, double *share, int *count)
{
    if (!ida || !count || (most > 0 && (!force || !share))) return MBSR_ERR_NULL;
    const int forces = mbsr_model_forces(ida->model);
    double sum = 0.0, least = 0.0;
    *count = 0;
    if (!known(ida)) return MBSR_OK;
    for (int k = 0; k < forces; ++k) ida->stiffness[k] = 0.0;
    const int status = find(ida, ida->stiffness, &least);
    if (status) {
        const mbsr_error *error = mbsr_data_error(ida->data);
        return mbsri_ida_fail(&ida->error, status, error->body, error->force,
                              "mbsr_ida_stiffest: %s", error->text);
    }
    for (int k = 0; k < forces; ++k) sum += fmax(0.0, ida->stiffness[k]);
    if (sum < least) return MBSR_OK;
    for (int k = 0; k < most; ++k) {
        const int next = largest(ida->stiffness, forces, k, force);
        if (next == MBSR_NONE) break;
        force[k] = next;
        share[k] = ida->stiffness[next] / sum;
        ++*count;
    }
    return MBSR_OK;
}

void mbsri_ida_blame_stiff(mbsr_ida *ida)
{
    int force[2], count = 0;
    double share[2];
    const mbsr_error before = ida->error;
    const int status = mbsr_ida_stiffest(ida, 2, force, share, &count);
    ida->error = before;
    if (status || count == 0) return;
    char second[40] = "";
    if (count > 1 && share[1] > 0.1)
        snprintf(second, sizeof second, " and %d (%.0f %%)", force[1], 100.0 * share[1]);
    const int code = before.status;
    mbsri_ida_fail(&ida->error, code, before.body, force[0],
                   "%.120s; %s by the stiffness of force element %d (%.0f %%)%s: "
                   "make it a stiff closure (as_closure), or softer",
                   before.text,
                   mbsri_stiff_of(ida->nonlinear)->of_iteration ? "Newton's method fails"
                                                                : "error tests fail",
                   force[0], 100.0 * share[0], second);
}
