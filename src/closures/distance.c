/* Two points at a distance.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With d = r_P - r_Q, the length l of the definition and s(t) = l or the motion:
 *
 *   g = (|d|^2 - s^2) / (2 l)      g' = (d . d' - s s') / l
 *   where accelerations are zero:  (|d'|^2 + d . (a_P - a_Q) - s'^2 - s s'') / l,
 *   with the centripetal parts a_P, a_Q
 *
 * As a spring the length itself, which must not vanish, with e = d / |d| (points of bodies in the
 * plane may lie off it):
 *
 *   g = |d| - l      g' = e . d'      (|d'|^2 - (e . d')^2) / |d| + e . (a_P - a_Q) */
#include "closures/rows.h"
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/space3.h"

enum { POINT_A = 0, POINT_B = 3, LENGTH = 6 };

typedef struct span {
    mbsri_end a, b;
    double s_P[3], s_Q[3], d[3], l;
    double s, sdot, sddot;
} span;

static int prepare_span(const mbsr_closure_args *args, span *w)
{
    double s[3][MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, s[0], s[1], s[2]);
    w->a = mbsri_end_of(args->body);
    w->b = mbsri_end_of(args->body + 1);
    mbsri_rotate3(w->a.R, args->closure->param + POINT_A, w->s_P);
    mbsri_rotate3(w->b.R, args->closure->param + POINT_B, w->s_Q);
    for (int k = 0; k < 3; ++k) w->d[k] = w->a.r[k] + w->s_P[k] - w->b.r[k] - w->s_Q[k];
    if (mbsri_flat(args)) w->d[2] = 0.0;
    w->l = args->closure->param[LENGTH];
    w->s = args->closure->motion ? s[0][0] : w->l;
    w->sdot = s[1][0];
    w->sddot = s[2][0];
    return status;
}

static int position(const mbsr_closure_args *args, double *g)
{
    span w;
    const int status = prepare_span(args, &w);
    const double length = mbsri_norm3(w.d);
    g[0] = 0.5 * (length - w.s) * (length + w.s) / w.l;
    return status;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    span w;
    const int status = prepare_span(args, &w);
    double e[3], back[3], moment[3];
    for (int k = 0; k < 3; ++k) e[k] = w.d[k] / w.l;
    for (int k = 0; k < 3; ++k) back[k] = -e[k];
    mbsri_cross3(w.s_P, e, moment);
    mbsri_end_add(args, 0, moment, e, 0, out);
    mbsri_cross3(e, w.s_Q, moment);
    mbsri_end_add(args, 1, moment, back, 0, out);
    return status;
}

/* Derivatives for Newton systems of a row with the direction e = d / size, or with the unit vector
 * along d where its length gives the size: de = (dd - e e . dd) / size. */
static void add_tangents(const mbsr_closure_args *args, const span *w, const double e[3],
                         double size, bool unit, double lambda, const mbsr_closure_tangent *out)
{
    const double *const arm[2] = {w->s_P, w->s_Q};
    double turn[3], shift[3], v_P[3], v_Q[3], v[3];
    mbsri_end_velocity(&w->a, w->s_P, v_P);
    mbsri_end_velocity(&w->b, w->s_Q, v_Q);
    for (int j = 0; j < 3; ++j) v[j] = v_P[j] - v_Q[j];
    for (int k = 0; k < 2; ++k) {
        const double sign = k == 0 ? 1.0 : -1.0;
        for (int r = 0; out->column[k] >= 0 && mbsri_end_shift(args, k, r, turn, shift); ++r) {
            const int at = out->column[k] + r;
            double darm[3], dv[3], de[3], moment[3];
            mbsri_cross3(turn, arm[k], darm);
            mbsri_cross3(k == 0 ? w->a.w : w->b.w, darm, dv);
            for (int j = 0; j < 3; ++j) de[j] = sign * (shift[j] + darm[j]) / size;
            if (unit) mbsri_add3(-mbsri_dot3(e, de), e, de);
            out->rate[(ptrdiff_t)at * out->rows] += mbsri_dot3(de, v) + sign * mbsri_dot3(e, dv);
            for (int l = 0; l < 2; ++l) {
                const double own = lambda * (l == 0 ? 1.0 : -1.0);
                double force[3];
                for (int j = 0; j < 3; ++j) force[j] = own * de[j];
                mbsri_cross3(arm[l], force, moment);
                if (l == k) {
                    double turned[3];
                    mbsri_cross3(darm, e, turned);
                    mbsri_add3(own, turned, moment);
                }
                mbsri_end_load(args, l, moment, force, at, out);
            }
        }
    }
}

static int tangent(const mbsr_closure_args *args, const double *lambda,
                   const mbsr_closure_tangent *out)
{
    span w;
    double e[3];
    const int status = prepare_span(args, &w);
    for (int k = 0; k < 3; ++k) e[k] = w.d[k] / w.l;
    if (!status) add_tangents(args, &w, e, w.l, false, lambda[0], out);
    return status;
}

static int drift(const mbsr_closure_args *args, double *gt)
{
    span w;
    const int status = prepare_span(args, &w);
    gt[0] = -w.s * w.sdot / w.l;
    return status;
}

static int bias(const mbsr_closure_args *args, double *out)
{
    span w;
    const int status = prepare_span(args, &w);
    double a_P[3], a_Q[3], v_P[3], v_Q[3], sum = -w.sdot * w.sdot - w.s * w.sddot;
    mbsri_end_centripetal(&w.a, w.s_P, a_P);
    mbsri_end_centripetal(&w.b, w.s_Q, a_Q);
    mbsri_end_velocity(&w.a, w.s_P, v_P);
    mbsri_end_velocity(&w.b, w.s_Q, v_Q);
    for (int k = 0; k < (mbsri_flat(args) ? 2 : 3); ++k) {
        sum += (v_P[k] - v_Q[k]) * (v_P[k] - v_Q[k]);
        sum += w.d[k] * (a_P[k] - a_Q[k]);
    }
    out[0] = sum / w.l;
    return status;
}

static int check_fields(const mbsr_closure_def *def, char text[MBSR_TEXT_SIZE])
{
    if (def->param[LENGTH] > 0.0) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE,
                        "length is %g, must be positive; use mbsr_closure_ball for zero",
                        def->param[LENGTH]);
}

static const char *row(const mbsr_closure_args *args, int k)
{
    (void)args, (void)k;
    return "length";
}

mbsr_closure_def mbsr_closure_distance(int a, const double point_a[3], int b,
                                       const double point_b[3], double length)
{
    static const mbsr_closure_table table = {
        .version = MBSR_CLOSURE_TABLE_VERSION,
        .flags = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED,
        .name = "distance",
        .position = position,
        .jacobian = jacobian,
        .tangent = tangent,
        .drift = drift,
        .bias = bias,
        .count = mbsri_one_row,
        .check = mbsri_check_pair,
        .check_fields = check_fields,
        .row = row,
        .point = mbsri_point_of_first,
    };
    mbsr_closure_def def = mbsri_stock_closure(&table, a, b);
    if (point_a) mbsri_copy(3, point_a, def.param + POINT_A);
    if (point_b) mbsri_copy(3, point_b, def.param + POINT_B);
    def.param[LENGTH] = length;
    return def;
}

/* ---- the length itself ---- */

static int prepare_length(const mbsr_closure_args *args, span *w, double *length, double e[3])
{
    const int status = prepare_span(args, w);
    w->d[2] = w->a.r[2] + w->s_P[2] - w->b.r[2] - w->s_Q[2];
    *length = mbsri_norm3(w->d);
    if (status || !(*length > 0.0)) return status ? status : MBSR_DEGENERATE_FORCE;
    for (int k = 0; k < 3; ++k) e[k] = w->d[k] / *length;
    return MBSR_OK;
}

static int length_position(const mbsr_closure_args *args, double *g)
{
    span w;
    double length, e[3];
    const int status = prepare_length(args, &w, &length, e);
    g[0] = length - w.l;
    return status;
}

static int length_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    span w;
    double length, e[3], back[3], moment[3];
    const int status = prepare_length(args, &w, &length, e);
    if (status) return status;
    for (int k = 0; k < 3; ++k) back[k] = -e[k];
    mbsri_cross3(w.s_P, e, moment);
    mbsri_end_add(args, 0, moment, e, 0, out);
    mbsri_cross3(e, w.s_Q, moment);
    mbsri_end_add(args, 1, moment, back, 0, out);
    return MBSR_OK;
}

static int length_tangent(const mbsr_closure_args *args, const double *lambda,
                          const mbsr_closure_tangent *out)
{
    span w;
    double length, e[3];
    const int status = prepare_length(args, &w, &length, e);
    if (!status) add_tangents(args, &w, e, length, true, lambda[0], out);
    return status;
}

static int length_drift(const mbsr_closure_args *args, double *gt)
{
    (void)args, (void)gt;
    return MBSR_OK;
}

static int length_bias(const mbsr_closure_args *args, double *out)
{
    span w;
    double length, e[3], a_P[3], a_Q[3], v_P[3], v_Q[3], v[3];
    const int status = prepare_length(args, &w, &length, e);
    if (status) return status;
    mbsri_end_centripetal(&w.a, w.s_P, a_P);
    mbsri_end_centripetal(&w.b, w.s_Q, a_Q);
    mbsri_end_velocity(&w.a, w.s_P, v_P);
    mbsri_end_velocity(&w.b, w.s_Q, v_Q);
    for (int k = 0; k < 3; ++k) v[k] = v_P[k] - v_Q[k];
    const double along = mbsri_dot3(e, v);
    for (int k = 0; k < 3; ++k) out[0] += e[k] * (a_P[k] - a_Q[k]) + v[k] * v[k] / length;
    out[0] -= along * along / length;
    return MBSR_OK;
}

mbsr_closure_def mbsri_closure_length(int a, const double point_a[3], int b,
                                      const double point_b[3], double length)
{
    static const mbsr_closure_table table = {
        .version = MBSR_CLOSURE_TABLE_VERSION,
        .flags = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED,
        .name = "length",
        .position = length_position,
        .jacobian = length_jacobian,
        .tangent = length_tangent,
        .drift = length_drift,
        .bias = length_bias,
        .count = mbsri_one_row,
        .check = mbsri_check_pair,
        .row = row,
        .point = mbsri_point_of_first,
    };
    mbsr_closure_def def = mbsri_stock_closure(&table, a, b);
    mbsri_copy(3, point_a, def.param + POINT_A);
    mbsri_copy(3, point_b, def.param + POINT_B);
    def.param[LENGTH] = length;
    return def;
}
