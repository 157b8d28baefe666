/* Steps by the error without IDA: what a set of sources has in the place of driver.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each step of the stepper is taken whole and in two halves; these are kept, and tell the error of
 * the whole one, of order p,
 *
 *   e = |x_whole - x_halves| / (2^p - 1),   x = (q, u),
 *
 * a root mean square in units of rtol |x| + atol. The next step is 0.9 e^(-1/(p+1)) times as long.
 */
#include "fmu/driver.h"

#include "fmu/solve.h"

#include <math.h>

/* ---- making ---- */

mbsri_result mbsri_make_driver(mbsri_instance *in)
{
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.order = in->plan.steps.order;
    opt.halvings = 0;
    opt.watch_energy = 0;
    in->h = 0.0;
    return mbsri_make_stepper(in, &opt);
}

void mbsri_drop_driver(mbsri_instance *in)
{
    (void)in;
}

/* ---- of IDA, which there is not ---- */

int mbsri_driver_state(mbsri_instance *in, const mbsr_error **error)
{
    (void)in;
    *error = NULL;
    return MBSR_ERR_UNAVAILABLE;
}

int mbsri_driver_motion(mbsri_instance *in, const mbsr_error **error)
{
    return mbsri_driver_state(in, error);
}

/* ---- steps ---- */

static double error_of(const mbsri_instance *in, const double *whole, const double *halves)
{
    const int n = in->plan.nq + in->plan.nu;
    const double rtol = in->tolerance > 0.0 ? in->tolerance : in->plan.steps.rtol;
    double sum = 0.0;
    for (int k = 0; k < n; ++k) {
        const double e = (whole[k] - halves[k]) / (rtol * fabs(halves[k]) + in->plan.steps.atol);
        sum += e * e;
    }
    return sqrt(sum / fmax(n, 1.0)) / (in->plan.steps.order == 2 ? 3.0 : 1.0);
}

/* From y and y' at t to t + h, and its error; infinite: a step was refused. */
static int attempt_twice(mbsri_instance *in, double t, double h, double *error)
{
    mbsr_stepper *s = in->solver.stepper;
    const int nq = in->plan.nq, n = nq + in->plan.nu;
    double *whole = in->work, *halves = whole + n; /* together fewer than three times y */
    *error = INFINITY;
    int status = mbsr_stepper_to(s, t + h);
    if (!status) status = mbsr_stepper_motion(s, NULL, whole, whole + nq);
    if (!status) status = mbsr_stepper_resume(s, t, in->y, in->yp);
    if (!status) status = mbsr_stepper_to(s, t + 0.5 * h);
    if (!status) status = mbsr_stepper_to(s, t + h);
    if (!status) status = mbsr_stepper_motion(s, NULL, halves, halves + nq);
    if (!status) *error = error_of(in, whole, halves);
    return status < 0 ? status : MBSR_OK;
}

/* One accepted step, until t_end at most. */
static int advance_by_error(mbsri_instance *in, double t_end)
{
    mbsr_stepper *s = in->solver.stepper;
    const double t = in->t, power = -1.0 / (in->plan.steps.order + 1.0);
    double error = INFINITY;
    int status = mbsr_stepper_state(s, NULL, in->y, in->yp);
    while (!status && !(error <= 1.0)) {
        const bool last = in->h <= 0.0 || t + 1.01 * in->h >= t_end;
        const double h = last ? t_end - t : in->h;
        if (!(t + 0.25 * h > t)) return MBSR_NO_CONVERGENCE;
        status = attempt_twice(in, t, h, &error);
        if (!status && !(error <= 1.0)) status = mbsr_stepper_resume(s, t, in->y, in->yp);
        const double next = h * fmin(fmax(0.9 * pow(error, power), 0.2), 5.0);
        in->h = last && error <= 1.0 ? fmax(in->h, next) : next;
        if (!status && error <= 1.0) in->t = last ? t_end : t + h;
    }
    return status;
}

mbsri_result mbsri_drive(mbsri_instance *in, double t_end, bool *event)
{
    int status = MBSR_OK;
    *event = false;
    if (in->fresh) {
        status = mbsr_stepper_resume(in->solver.stepper, in->t, in->y, in->yp);
        in->h = 0.0;
    }
    in->fresh = false;
    while (!status && in->t < t_end) {
        status = advance_by_error(in, t_end);
        if (status || !in->importer.intermediate || in->t >= t_end) continue;
        if (!mbsri_update(in, in->t, &t_end)) break;
    }
    return status ? mbsri_failed(in, "the step", status, mbsr_stepper_error(in->solver.stepper))
                  : MBSRI_OK;
}
