/* Derivatives of forces at points of bodies: see slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/slopes.h"

#include "algebra/space3.h"
#include "forces/marker.h"

/* What number r of a body's velocity is in space: 0 .. 2 of its angular velocity, 3 .. 5 of the
 * velocity of its origin. The same of its pose and of its forces. */
static const int component[][6] = {[MBSR_SPACE_POINT] = {3, 4},
                                   [MBSR_SPACE_PLANAR] = {3, 4, 2},
                                   [MBSR_SPACE_SPATIAL] = {0, 1, 2, 3, 4, 5}};

mbsri_columns mbsri_make_columns(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    mbsri_columns c = {.body = args->body, .out = out};
    for (int k = 0; k < 2; ++k) {
        c.first[k] = c.count;
        if (k < args->bodies && out->column[k] >= 0) c.size[k] = args->body[k].d;
        c.count += 2 * c.size[k];
    }
    return c;
}

void mbsri_add_turn(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                    const double y[3], mbsri_vector *dx)
{
    const int *of = component[c->body[k].space];
    dx += c->first[k] + (part == MBSRI_RATE ? c->size[k] : 0);
    for (int r = 0; r < c->size[k]; ++r) {
        if (of[r] > 2) continue;
        const int i = (of[r] + 1) % 3, j = (of[r] + 2) % 3;
        dx[r].x[i] -= sign * y[j];
        dx[r].x[j] += sign * y[i];
    }
}

void mbsri_add_spin(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                    mbsri_vector *dx)
{
    const int *of = component[c->body[k].space];
    dx += c->first[k] + (part == MBSRI_RATE ? c->size[k] : 0);
    for (int r = 0; r < c->size[k]; ++r) {
        if (of[r] <= 2) dx[r].x[of[r]] += sign;
    }
}

void mbsri_add_shift(const mbsri_columns *c, int k, mbsri_state_part part, double sign,
                     mbsri_vector *dx)
{
    const int *of = component[c->body[k].space];
    dx += c->first[k] + (part == MBSRI_RATE ? c->size[k] : 0);
    for (int r = 0; r < c->size[k]; ++r) {
        if (of[r] > 2) dx[r].x[of[r] - 3] += sign;
    }
}

void mbsri_add_velocity(const mbsri_columns *c, int k, double sign, const double arm[3],
                        const mbsri_vector *darm, mbsri_vector *dv)
{
    double omega[3];
    mbsri_body_spin(c->body + k, omega);
    for (int r = 0; r < 3; ++r) omega[r] *= sign;
    for (int l = 0; l < c->count; ++l) mbsri_add_cross3(omega, darm[l].x, dv[l].x);
    mbsri_add_turn(c, k, MBSRI_RATE, sign, arm, dv);
    mbsri_add_shift(c, k, MBSRI_RATE, sign, dv);
}

bool mbsri_point_motion(const mbsri_columns *c, int k, int r, const double arm[3], double dx[3])
{
    const int of = component[c->body[k].space][r];
    dx[0] = dx[1] = dx[2] = 0.0;
    if (of > 2) {
        dx[of - 3] = 1.0;
        return false;
    }
    dx[(of + 1) % 3] = -arm[(of + 2) % 3];
    dx[(of + 2) % 3] = arm[(of + 1) % 3];
    return true;
}

/* column += sign (moment, force), what of it the body feels */
static inline void add_wrench(int size, double sign, const double moment[3], const double force[3],
                              double *column)
{
    if (size == 6) {
        mbsri_add3(sign, moment, column);
        mbsri_add3(sign, force, column + 3);
        return;
    }
    column[0] += sign * force[0];
    column[1] += sign * force[1];
    if (size == 3) column[2] += sign * moment[2];
}

void mbsri_push_slopes(const mbsri_columns *c, int k, double sign, const double arm[3],
                       const double force[3], const mbsri_vector *darm, const mbsri_vector *dforce,
                       const mbsri_vector *dmoment)
{
    static const double none[3] = {0.0, 0.0, 0.0};
    const mbsr_force_derivatives *out = c->out;
    const int size = c->size[k];
    double moment[3];
    if (size == 0) return;
    for (int j = 0, l = 0; j < 2; ++j) {
        if (c->size[j] == 0) continue;
        double *column = out->matrix + (ptrdiff_t)out->column[j] * out->rows + out->row[k];
        for (; l < c->first[j] + 2 * c->size[j]; ++l, column += out->rows) {
            mbsri_cross3(arm, dforce[l].x, moment);
            if (darm) mbsri_add_cross3(darm[l].x, force, moment);
            if (dmoment) mbsri_add3(1.0, dmoment[l].x, moment);
            add_wrench(size, sign, moment, dforce[l].x, column);
        }
    }
    double *column = out->matrix + (ptrdiff_t)out->column[k] * out->rows + out->row[k];
    for (int r = 0; r < size && !darm; ++r, column += out->rows) {
        double turned[3];
        if (!mbsri_point_motion(c, k, r, arm, turned)) continue;
        mbsri_cross3(turned, force, moment);
        add_wrench(size, sign, moment, none, column);
    }
}
