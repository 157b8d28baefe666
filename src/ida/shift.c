/* y - c in the place of y: see kinks.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/shift.h"

#include "ida/vectors.h"

#include <math.h>
#include <string.h>

/* The vectors; the last is longer. */
enum { VECTORS = 10 };
static void list(mbsri_ida_kinks *k, N_Vector *vector[VECTORS])
{
    N_Vector *const all[VECTORS] = {
        &k->c_derivative[0], &k->c_derivative[1], &k->y,     &k->yp,    &k->node[0],
        &k->node[1],         &k->node[2],         &k->ahead, &k->right, &k->work};
    memcpy(vector, all, sizeof all);
}

bool mbsri_ida_make_kinks(mbsr_ida *ida)
{
    const int work = mbsr_model_nq(ida->model) + 4 * mbsr_model_nu(ida->model);
    N_Vector *vector[VECTORS];
    list(&ida->kinks, vector);
    for (int l = 0; l < VECTORS; ++l) {
        *vector[l] = N_VNew_Serial(l < VECTORS - 1 ? ida->size : work, ida->context);
        if (!*vector[l]) return false;
        mbsri_ida_use_own_operations(*vector[l]);
        N_VConst(0.0, *vector[l]);
    }
    return true;
}

void mbsri_ida_free_kinks(mbsr_ida *ida)
{
    N_Vector *vector[VECTORS];
    list(&ida->kinks, vector);
    for (int l = 0; l < VECTORS; ++l) {
        if (*vector[l]) N_VDestroy(*vector[l]);
    }
}

void mbsri_ida_forget_kinks(mbsr_ida *ida)
{
    mbsri_ida_kinks *k = &ida->kinks;
    k->known = k->reached = k->requested = k->sampled = k->shifted = false;
    k->step = 0.0;
    k->patience = 0;
}

/* ---- z and y ---- */

void mbsri_ida_add_shift(const mbsr_ida *ida, double t, int n, N_Vector y)
{
    const mbsri_ida_kinks *k = &ida->kinks;
    const double s = t - k->from, square[] = {0.5 * s * s, s, 1.0, 0.0},
                 cube[] = {s * s * s / 6.0, 0.5 * s * s, s, 1.0};
    if (!k->shifted || n > 3) return;
    N_VLinearSum(1.0, y, square[n], k->c_derivative[0], y);
    N_VLinearSum(1.0, y, cube[n], k->c_derivative[1], y);
}

void mbsri_ida_shift_back(mbsr_ida *ida, double t, N_Vector *y, N_Vector *yp)
{
    mbsri_ida_kinks *k = &ida->kinks;
    if (!k->shifted) return;
    N_VScale(1.0, *y, k->y);
    mbsri_ida_add_shift(ida, t, 0, k->y);
    *y = k->y;
    if (!yp) return;
    N_VScale(1.0, *yp, k->yp);
    mbsri_ida_add_shift(ida, t, 1, k->yp);
    *yp = k->yp;
}

void mbsri_ida_end_shift(mbsr_ida *ida)
{
    ida->kinks.shifted = false;
}

void mbsri_ida_note_step(mbsr_ida *ida)
{
    long steps = 0;
    if (!ida->kinks.shifted) return;
    IDAGetNumSteps(ida->memory, &steps);
    if (steps != 1) return;
    IDAGetLastStep(ida->memory, &ida->kinks.step);
    ida->kinks.step = fabs(ida->kinks.step);
}
