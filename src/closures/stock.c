/* Definitions of closures, and what the stock ones share.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "base/cookie.h"
#include "tables/table.h"

mbsr_closure_def mbsr_default_closure_def(void)
{
    mbsr_closure_def def = {.cookie = MBSRI_COOKIE, .settled = 1};
    for (int k = 0; k < MBSR_CLOSURE_BODIES; ++k) def.body[k] = MBSR_NONE;
    return def;
}

mbsr_closure_def mbsr_closure_custom(const mbsr_closure_table *table, int bodies, const int *body,
                                     int rows, int position_rows, void *user)
{
    mbsr_closure_def def = mbsr_default_closure_def();
    def.table = table;
    def.bodies = bodies;
    for (int k = 0; k < bodies && k < MBSR_CLOSURE_BODIES && body; ++k) def.body[k] = body[k];
    def.rows = rows;
    def.position_rows = position_rows;
    def.user = user;
    return def;
}

int mbsri_one_row(const mbsr_closure_args *args, int *rows, int *position_rows)
{
    (void)args;
    *rows = *position_rows = 1;
    return MBSR_OK;
}

int mbsri_chosen_rows(const mbsr_closure_args *args, int *rows, int *position_rows)
{
    *rows = *position_rows = args->closure->option[0];
    return MBSR_OK;
}

int mbsri_constant_rows(const mbsr_closure_args *args, const double *lambda,
                        const mbsr_closure_tangent *out)
{
    (void)args, (void)lambda, (void)out;
    return MBSR_OK;
}

int mbsri_no_numbers(const mbsr_closure_args *args, double *out)
{
    (void)args, (void)out;
    return MBSR_OK;
}

mbsr_closure_def mbsri_stock_closure(const mbsr_closure_table *table, int a, int b)
{
    return mbsr_closure_custom(table, 2, (const int[2]){a, b}, 0, 0, NULL);
}

mbsri_end mbsri_end_of(const mbsr_force_body *body)
{
    mbsri_end end = {.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    const double *p = body->p, *V = body->V;
    switch (body->space) {
    case MBSR_SPACE_SPATIAL:
        mbsri_copy(9, p + MBSR_POSE_R, end.R);
        mbsri_copy(3, p + MBSR_POSE_X, end.r);
        if (V) mbsri_copy(3, V, end.w);
        if (V) mbsri_copy(3, V + 3, end.v);
        break;
    case MBSR_SPACE_PLANAR:
        end.R[0] = end.R[4] = cos(p[2]);
        end.R[1] = sin(p[2]);
        end.R[3] = -end.R[1];
        if (V) end.w[2] = V[2];
        /* fall through */
    case MBSR_SPACE_POINT:
        mbsri_copy(2, p, end.r);
        if (V) mbsri_copy(2, V, end.v);
        break;
    default: break;
    }
    return end;
}

void mbsri_end_add(const mbsr_closure_args *args, int k, const double a[3], const double l[3],
                   int row, const mbsr_closure_jacobian *out)
{
    const ptrdiff_t stride = out->rows, column = out->column[k];
    if (column < 0) return;
    double *at = out->matrix + column * stride + row;
    switch (args->body[k].space) {
    case MBSR_SPACE_SPATIAL:
        for (int j = 0; j < 3; ++j) at[j * stride] += a[j];
        for (int j = 0; j < 3; ++j) at[(3 + j) * stride] += l[j];
        break;
    case MBSR_SPACE_PLANAR:
        at[2 * stride] += a[2];
        /* fall through */
    case MBSR_SPACE_POINT:
        at[0] += l[0];
        at[stride] += l[1];
        break;
    default: break;
    }
}

bool mbsri_end_shift(const mbsr_closure_args *args, int k, int r, double turn[3], double shift[3])
{
    const mbsr_force_body *body = args->body + k;
    mbsri_zero(3, turn);
    mbsri_zero(3, shift);
    switch (body->space) {
    case MBSR_SPACE_SPATIAL:
        if (r < 6) *(r < 3 ? turn + r : shift + r - 3) = 1.0;
        return r < 6;
    case MBSR_SPACE_PLANAR:
        if (r < 3) *(r == 2 ? turn + 2 : shift + r) = 1.0;
        return r < 3;
    case MBSR_SPACE_POINT:
        if (r < 2) shift[r] = 1.0;
        return r < 2;
    default: return false;
    }
}

void mbsri_end_load(const mbsr_closure_args *args, int k, const double moment[3],
                    const double force[3], int at, const mbsr_closure_tangent *out)
{
    if (out->column[k] < 0) return;
    double *f = out->force + (ptrdiff_t)at * out->columns + out->column[k];
    switch (args->body[k].space) {
    case MBSR_SPACE_SPATIAL:
        mbsri_add3(1.0, moment, f);
        mbsri_add3(1.0, force, f + 3);
        break;
    case MBSR_SPACE_PLANAR:
        f[2] += moment[2];
        /* fall through */
    case MBSR_SPACE_POINT:
        f[0] += force[0];
        f[1] += force[1];
        break;
    default: break;
    }
}

void mbsri_end_velocity(const mbsri_end *end, const double arm[3], double v[3])
{
    mbsri_cross3(end->w, arm, v);
    mbsri_add3(1.0, end->v, v);
}

void mbsri_end_centripetal(const mbsri_end *end, const double arm[3], double a[3])
{
    mbsri_cross3(end->w, arm, a);
    mbsri_cross3(end->w, a, a);
}

int mbsri_point_of_first(const mbsr_closure_args *args, double x[3])
{
    const mbsri_end a = mbsri_end_of(args->body);
    mbsri_rotate3(a.R, args->closure->param, x);
    mbsri_add3(1.0, a.r, x);
    return MBSR_OK;
}

bool mbsri_flat(const mbsr_closure_args *args)
{
    return args->body[0].space != MBSR_SPACE_SPATIAL && args->body[1].space != MBSR_SPACE_SPATIAL;
}

int mbsri_check_pair(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE])
{
    if (args->body[0].id == args->body[1].id) {
        const int id = args->body[0].id;
        return id == MBSR_GROUND ? mbsri_refuse(text, MBSR_ERR_ID, "both sides are on the ground")
                                 : mbsri_refuse(text, MBSR_ERR_ID, "both sides are on body %d", id);
    }
    for (int k = 0; k < 2; ++k) {
        if (args->body[k].space == MBSR_SPACE_FLEXIBLE)
            return mbsri_refuse(text, MBSR_ERR_SPACE,
                                "body %d is FLEXIBLE; put the closure on a marker of it",
                                args->body[k].id);
        if (args->body[k].space == MBSR_SPACE_GENERAL) {
            return mbsri_refuse(text, MBSR_ERR_SPACE,
                                "body %d is in GENERAL space, whose coordinates have no known "
                                "meaning; use mbsr_closure_custom",
                                args->body[k].id);
        }
    }
    return MBSR_OK;
}

int mbsri_check_frame(const mbsr_closure_def *def, int first, const char *which,
                      char text[MBSR_TEXT_SIZE])
{
    const double defect = mbsri_frame_defect(def->param + first + 3);
    if (defect <= 1e-6) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE,
                        "the axes of %s are not orthonormal and right-handed (by %.2g)", which,
                        defect);
}

int mbsri_closure_motion(const mbsr_closure_args *args, double s[MBSR_CLOSURE_ROWS],
                         double sdot[MBSR_CLOSURE_ROWS], double sddot[MBSR_CLOSURE_ROWS])
{
    mbsri_zero(MBSR_CLOSURE_ROWS, s);
    mbsri_zero(MBSR_CLOSURE_ROWS, sdot);
    mbsri_zero(MBSR_CLOSURE_ROWS, sddot);
    const mbsr_closure_def *def = args->closure;
    if (def->motion == mbsr_table_motion && mbsri_table_columns(def->user) > MBSR_CLOSURE_ROWS)
        return MBSR_ERR_VALUE;
    return def->motion ? def->motion(def->user, args->t, s, sdot, sddot) : MBSR_OK;
}
