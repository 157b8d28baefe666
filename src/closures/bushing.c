/* Frame B of one body as seen from frame A of another, in space.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along A's axes R_A: e the place of B's origin, theta its rotation vector, R_A^T R_B = exp
 * [theta]x. With x the place of B's origin, s = x - r_a its arm on the body of A, s_B that on the
 * body of B:
 *
 *   e' = R_A^T (v_b + w_b x s_B - v_a - w_a x s)        theta' = J^-1(theta) R_A^T (w_b - w_a)
 *
 * (forces/rotation.h). */
#include "closures/rows.h"
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "forces/rotation.h"

enum { B, A };                      /* places of the bodies */
enum { FRAME_B = 0, FRAME_A = 12 }; /* in param */
enum { ROWS = 0, ENTRY = 1 };       /* in option: how many, and which entries of (theta, e) */

typedef struct bushing {
    double axes[9], theta[3], e[3]; /* axes of A in the world */
    double arm_b[3], arm_a[3];      /* arms to B's origin, from each body's origin, m */
} bushing;

static void prepare_bushing(const mbsr_closure_args *args, bushing *w)
{
    const double *param = args->closure->param;
    const mbsri_end b = mbsri_end_of(args->body + B), a = mbsri_end_of(args->body + A);
    double axes_b[9], back[9], relative[9], quaternion[4], at[3];
    mbsri_multiply3(a.R, param + FRAME_A + 3, w->axes);
    mbsri_multiply3(b.R, param + FRAME_B + 3, axes_b);
    for (int k = 0; k < 9; ++k) back[k] = w->axes[3 * (k % 3) + k / 3];
    mbsri_multiply3(back, axes_b, relative);
    mbsr_rotation_quaternion(relative, quaternion);
    mbsri_quaternion_vector(quaternion, w->theta);
    mbsri_rotate3(b.R, param + FRAME_B, w->arm_b);
    mbsri_rotate3(a.R, param + FRAME_A, at);
    for (int k = 0; k < 3; ++k) {
        w->arm_a[k] = b.r[k] + w->arm_b[k] - a.r[k];
        w->e[k] = w->arm_a[k] - at[k];
    }
    mbsri_unrotate3(w->axes, w->e, w->e);
}

static int position(const mbsr_closure_args *args, double *g)
{
    bushing w;
    prepare_bushing(args, &w);
    for (int k = 0; k < args->closure->option[ROWS]; ++k) {
        const int entry = args->closure->option[ENTRY + k];
        g[k] = entry < 3 ? w.theta[entry] : w.e[entry - 3];
    }
    return MBSR_OK;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    bushing w;
    prepare_bushing(args, &w);
    for (int k = 0; k < args->closure->option[ROWS]; ++k) {
        const int entry = args->closure->option[ENTRY + k];
        double along[3], back[3], moment[3], unit[3] = {0.0, 0.0, 0.0};
        unit[entry % 3] = 1.0;
        if (entry < 3) mbsri_unturn(w.theta, unit, unit);
        mbsri_rotate3(w.axes, unit, along);
        for (int j = 0; j < 3; ++j) back[j] = -along[j];
        if (entry < 3) {
            mbsri_end_add(args, B, along, zero, k, out);
            mbsri_end_add(args, A, back, zero, k, out);
            continue;
        }
        mbsri_cross3(w.arm_b, along, moment);
        mbsri_end_add(args, B, moment, along, k, out);
        mbsri_cross3(w.arm_a, back, moment);
        mbsri_end_add(args, A, moment, back, k, out);
    }
    return MBSR_OK;
}

static const char *row(const mbsr_closure_args *args, int k)
{
    static const char *const names[] = {
        "turn about x", "turn about y", "turn about z", "x", "y", "z"};
    return names[args->closure->option[ENTRY + k]];
}

mbsr_closure_def mbsri_closure_bushing(int a, const double frame_a[12], int b,
                                       const double frame_b[12], int rows, const int *entry)
{
    static const mbsr_closure_table table = {
        .version = MBSR_CLOSURE_TABLE_VERSION,
        .flags = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED,
        .name = "bushing",
        .position = position,
        .jacobian = jacobian,
        .drift = mbsri_no_numbers,
        .count = mbsri_chosen_rows,
        .row = row,
    };
    mbsr_closure_def def = mbsri_stock_closure(&table, b, a);
    mbsri_copy(12, frame_b, def.param + FRAME_B);
    mbsri_copy(12, frame_a, def.param + FRAME_A);
    def.option[ROWS] = rows;
    for (int k = 0; k < rows; ++k) def.option[ENTRY + k] = entry[k];
    return def;
}
