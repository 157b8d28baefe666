/* A consistent start: accelerations, the equations of motion, Yc^T gamma' = 0 and Y^T gamma'' = 0.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "massless/null_slopes.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"

#include <float.h>
#include <math.h>

/* out = [Yc^T gamma'; Y^T gamma''] along the motion with the present u'. */
static int defect_of_rates(mbsri_start *s, double *out)
{
    mbsri_null_space *w = &s->w;
    const double h = mbsri_start_short_time(s, 1e-4);
    int status = mbsri_null_gamma(w, s->t, s->q, s->u, s->defect);
    if (!status) status = mbsri_start_differences(s, h, true, s->defect, s->trial, s->defect);
    if (status) return status;
    mbsri_start_turn(s, s->trial, out);
    mbsri_copy((size_t)w->k, s->defect, s->trial);
    mbsri_start_turn(s, s->trial, s->defect);
    for (int r = s->damped; r < w->k; ++r) out[r] = s->defect[r];
    return MBSR_OK;
}

/* sizes (k) += what rounding of positions is multiplied by: S_lm times the multiple of direction m that
 * is as long as q. */
static void add_springs(mbsri_start *s, double *sizes)
{
    const mbsri_null_space *w = &s->w;
    const int k = w->k, nq = w->m->nq;
    const double length = fmax(1.0, mbsri_start_relative(nq, s->q, w->q_scale));
    for (int m = 0; m < k; ++m) {
        const double *rate = w->q_rate + (size_t)m * (size_t)nq,
                     share = length / mbsri_start_relative(nq, rate, w->q_scale);
        for (int l = 0; l < k; ++l) sizes[l] += fabs(w->S[m * k + l]) * share;
    }
}

/* B, slopes of Y^T gamma'' along the null directions: Y^T S, and where differences show more, the
 * change of C in time. */
static int slopes_of_rates(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_model *m = w->m;
    const int k = w->k, e = k - s->damped;
    const double time = mbsri_start_short_time(s, 1e-4), rate = 1e-4 / time;
    mbsri_start_springs(s);
    if (s->by_rows && mbsri_largest(m->nu, s->u) == 0.0) /* C does not change: it is made of rows */
        return mbsri_start_factor(s, MBSRI_LEAST_STIFFNESS);
    if (e > 0) {
        mbsri_start_loads(s, s->weights);
        add_springs(s, s->weights);
    }
    for (int l = 0; l < k && e > 0; ++l) {
        const double *a = w->direction + (size_t)l * (size_t)m->nu;
        const double h = fmax(rate, mbsri_start_relative(m->nu, s->udot, w->u_scale)) /
                         mbsri_start_relative(m->nu, a, w->u_scale);
        mbsri_ax(m->nu, 1, h, a, &(double){1.0}, s->udot);
        const int status = defect_of_rates(s, s->change);
        mbsri_ax(m->nu, 1, -h, a, &(double){1.0}, s->udot);
        if (status) return status;
        for (int r = 0; r < e; ++r) {
            const double slope = (s->change[s->damped + r] - s->moved[s->damped + r]) / h;
            const double *y = s->left + (s->damped + r) * k;
            double row = 0.0, noise = 0.0;
            for (int c = 0; c < k; ++c) {
                row = fmax(row, fabs(s->B[c * e + r]));
                noise += 1e3 * DBL_EPSILON * fabs(y[c]) * s->weights[c] / (time * time * h);
            }
            if (fabs(slope - s->B[l * e + r]) > 10.0 * noise + 1e-4 * fmax(row, fabs(slope)))
                s->B[l * e + r] = slope;
        }
    }
    return mbsri_start_factor(s, MBSRI_LEAST_STIFFNESS);
}

/* The defect is affine in u'; what rounding leaves of it the next solutions remove. */
static int null_rates(mbsri_start *s)
{
    enum { REFINED = 3 };
    int status = defect_of_rates(s, s->moved);
    if (!status) status = slopes_of_rates(s);
    for (int step = 0; step < REFINED && !status; ++step) {
        if (step > 0) status = defect_of_rates(s, s->moved);
        for (int r = 0; r < s->w.k; ++r) s->moved[r] = -s->moved[r];
        mbsri_start_solve(s, s->moved);
        if (!status) mbsri_null_combine(&s->w, s->weights, s->udot);
    }
    return status;
}

int mbsri_start_rates(mbsri_start *s)
{
    mbsri_null_space *w = &s->w;
    const mbsr_error before = w->d->error;
    int status = mbsri_forward_by_stages(w->m, w->d, s->t, s->q, s->u, NULL, s->udot);
    if (status == MBSR_UNDETERMINED) {
        w->d->error = before; /* expected: the null directions are what is looked for */
    } else if (status) {
        return status;
    }
    status = mbsri_coordinate_rates(w->m, w->d, s->qdot);
    return status || w->k == 0 ? status : null_rates(s);
}
