/* Frame B of one body as seen from frame A of another, in the plane.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rows g = T e of e = (x, y, angle) along A's axes a_x, a_y; whole turns count. With s the arm of
 * B's origin on the body of A, s_B that on the body of B, and n = z x the direction:
 *
 *   x' = a_x . (v_b - v_a) + (s_B x a_x) w_b - (s x a_x) w_a        angle' = w_b - w_a */
#include "closures/rows.h"
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/space3.h"

enum { B, A };                              /* places of the bodies */
enum { FRAME_B = 0, FRAME_A = 3, MIX = 6 }; /* in param */

typedef struct bushing {
    double axes[9], e[3]; /* axes of A in the world */
    double arm_b[3], arm_a[3];
} bushing;

static double end_angle(const mbsr_closure_args *args, int k, int frame)
{
    const mbsr_force_body *body = args->body + k;
    return (body->space == MBSR_SPACE_PLANAR ? body->p[2] : 0.0) + args->closure->param[frame + 2];
}

static void prepare_planar_bushing(const mbsr_closure_args *args, bushing *w)
{
    const double *param = args->closure->param, angle = end_angle(args, A, FRAME_A);
    const mbsri_end b = mbsri_end_of(args->body + B), a = mbsri_end_of(args->body + A);
    const double on_b[3] = {param[FRAME_B], param[FRAME_B + 1], 0.0},
                 on_a[3] = {param[FRAME_A], param[FRAME_A + 1], 0.0};
    double at[3];
    mbsri_zero(9, w->axes);
    w->axes[0] = w->axes[4] = cos(angle);
    w->axes[1] = sin(angle);
    w->axes[3] = -w->axes[1];
    w->axes[8] = 1.0;
    mbsri_rotate3(b.R, on_b, w->arm_b);
    mbsri_rotate3(a.R, on_a, at);
    for (int k = 0; k < 3; ++k) {
        w->arm_a[k] = b.r[k] + w->arm_b[k] - a.r[k];
        w->e[k] = w->arm_a[k] - at[k];
    }
    mbsri_unrotate3(w->axes, w->e, w->e);
    w->e[2] = end_angle(args, B, FRAME_B) - angle;
}

static int position(const mbsr_closure_args *args, double *g)
{
    bushing w;
    prepare_planar_bushing(args, &w);
    for (int k = 0; k < args->closure->option[0]; ++k)
        g[k] = mbsri_dot3(args->closure->param + MIX + 3 * k, w.e);
    return MBSR_OK;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    bushing w;
    prepare_planar_bushing(args, &w);
    for (int k = 0; k < args->closure->option[0]; ++k) {
        const double *T = args->closure->param + MIX + 3 * k;
        double along[3], moment[3];
        for (int j = 0; j < 3; ++j)
            along[j] = j < 2 ? T[0] * w.axes[j] + T[1] * w.axes[3 + j] : 0.0;
        mbsri_cross3(w.arm_b, along, moment);
        moment[2] += T[2];
        mbsri_end_add(args, B, moment, along, k, out);
        for (int j = 0; j < 3; ++j) along[j] = -along[j];
        mbsri_cross3(w.arm_a, along, moment);
        moment[2] -= T[2];
        mbsri_end_add(args, A, moment, along, k, out);
    }
    return MBSR_OK;
}

/* The entry that the row is, or has most part in. */
static const char *row(const mbsr_closure_args *args, int k)
{
    static const char *const names[] = {"x", "y", "turn", "mostly x", "mostly y", "mostly turn"};
    const double *T = args->closure->param + MIX + 3 * k;
    int most = 0, parts = 0;
    for (int j = 0; j < 3; ++j) {
        if (fabs(T[j]) > fabs(T[most])) most = j;
        parts += T[j] != 0.0;
    }
    return names[parts > 1 ? 3 + most : most];
}

mbsr_closure_def mbsri_closure_planar_bushing(int a, const double frame_a[3], int b,
                                              const double frame_b[3], int rows, const double *T)
{
    static const mbsr_closure_table table = {
        .version = MBSR_CLOSURE_TABLE_VERSION,
        .flags = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED,
        .name = "planar bushing",
        .position = position,
        .jacobian = jacobian,
        .drift = mbsri_no_numbers,
        .count = mbsri_chosen_rows,
        .row = row,
    };
    mbsr_closure_def def = mbsri_stock_closure(&table, b, a);
    mbsri_copy(3, frame_b, def.param + FRAME_B);
    mbsri_copy(3, frame_a, def.param + FRAME_A);
    mbsri_copy(3 * (size_t)rows, T, def.param + MIX);
    def.option[0] = rows;
    return def;
}
