/* A matrix by difference quotients of one side is put to the test.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Too stiff a matrix (see differences.c) makes corrections so small that they pass for converged:
 * a run with long steps then stands still and reports success. So new ones are multiplied, by
 * differences of two sides, with a direction v: K^-1 (F(y + e v) - F(y - e v)) / 2 e should be v.
 * It is y' at the end of the step, the way that the motion goes: the correction that was found with
 * the matrix lies, more often than not, where the matrix is right. What counts are the momenta:
 * velocities show as well how much a motion without anything stiff changes the matrix within a
 * step. Two residuals for each matrix tested; none where nothing in it is stiff. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <float.h>
#include <math.h>

static const double most_defect = 0.5, hardly = 0.02;

static bool note_test(mbsri_stiff *s, double h, double defect)
{
    mbsri_control_tested(&s->control, s->now.steps, h, defect, most_defect);
    return defect > most_defect;
}

/* Whether nothing in the matrix resists a step: K^-1 c leaves momenta, of a tolerance each with
 * signs + - - +, as they are. Then quotients are right, too. One solution; where the filter is dear
 * this is not asked. */
static bool nothing_stiff(mbsri_stiff *s)
{
    double *x = NV_DATA_S(s->change);
    const double *weight = NV_DATA_S(s->weight);
    if (s->weigh) return false;
    N_VConst(0.0, s->change);
    for (int k = s->first; k < s->last; ++k) x[k] = ((k / 2 + k) % 2 ? -1.0 : 1.0) / weight[k];
    const double all = mbsri_stiff_momenta(s, s->change);
    N_VScale(1.0, s->change, s->filtered);
    N_VScale(s->now.c, s->change, s->change);
    ++s->info.filter_solves;
    if (s->solve(s->change, s->memory)) return false;
    N_VLinearSum(1.0, s->change, -1.0, s->filtered, s->change);
    return mbsri_stiff_momenta(s, s->change) <= hardly * all;
}

/* Largest e for which entries change by no more than `relative`; 0 if v is zero. */
static double extent(N_Vector v, N_Vector y, N_Vector w, double relative)
{
    const double *change = N_VGetArrayPointer(v), *value = N_VGetArrayPointer(y),
                 *weight = N_VGetArrayPointer(w);
    double e = INFINITY;
    for (sunindextype k = 0; k < N_VGetLength(v); ++k) {
        const double size = fmax(fabs(value[k]), 1.0 / weight[k]);
        if (change[k] != 0.0) e = fmin(e, relative * size / fabs(change[k]));
    }
    return isfinite(e) ? e : 0.0;
}

/* F(y + e v) with c: into `to`. */
static int shifted(mbsri_stiff *s, N_Vector ee, N_Vector v, double e, N_Vector to)
{
    N_VLinearSum(1.0, ee, e, v, s->trial);
    return s->system(s->trial, to, s->memory);
}

bool mbsri_stiff_wrong_matrix(mbsri_stiff *s, N_Vector predicted, N_Vector ee)
{
    static const double no_way = 0.1, least = 0.1; /* tolerances in a step; share of all of v */
    N_Vector rate = NULL, v = s->error, w = s->weight;
    double h = 0.0;
    mbsri_control *control = &s->control;
    if (!control->quotients || !control->matrices.untested) return false;
    if (control->care == MBSRI_CARE_NEVER) return false;
    control->matrices.untested = false;
    if (IDAGetCurrentStep(s->memory, &h) < 0) return false;
    if (!mbsri_control_tests(control, s->now.steps, fabs(h))) return false;
    if (IDAGetCurrentYp(s->memory, &rate) < 0) return false;
    N_VScale(1.0, rate, v);
    const double speed = N_VWrmsNorm(v, w);
    if (speed * fabs(h) < no_way) return false;
    if (nothing_stiff(s)) return note_test(s, fabs(h), hardly);
    const double e = extent(v, predicted, w, cbrt(DBL_EPSILON));
    if (!(e > 0.0)) return false;
    if (shifted(s, ee, v, e, s->change) || shifted(s, ee, v, -e, s->filtered)) return false;
    N_VLinearSum(0.5 / e, s->change, -0.5 / e, s->filtered, s->change);
    ++s->info.filter_solves;
    if (s->solve(s->change, s->memory)) return false;
    N_VLinearSum(1.0, s->change, -1.0, v, s->change);
    const double defect =
        mbsri_stiff_momenta(s, s->change) / fmax(mbsri_stiff_momenta(s, v), least * speed);
    return note_test(s, fabs(h), defect);
}
