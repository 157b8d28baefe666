/* Points fixed to bodies: see marker.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/marker.h"

#include "algebra/space3.h"
#include "forces/stock.h"

#include <math.h>
#include <string.h>

void mbsri_body_axes(const mbsr_force_body *body, double R[9])
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    if (body->space == MBSR_SPACE_SPATIAL) {
        memcpy(R, body->p + MBSR_POSE_R, sizeof unit);
        return;
    }
    memcpy(R, unit, sizeof unit);
    if (body->space == MBSR_SPACE_PLANAR) {
        R[0] = R[4] = cos(body->p[2]);
        R[1] = sin(body->p[2]);
        R[3] = -R[1];
    }
}

void mbsri_body_spin(const mbsr_force_body *body, double omega[3])
{
    omega[0] = omega[1] = omega[2] = 0.0;
    if (!body->V) return;
    if (body->space == MBSR_SPACE_SPATIAL) memcpy(omega, body->V, 3 * sizeof *omega);
    if (body->space == MBSR_SPACE_PLANAR) omega[2] = body->V[2];
}

/* Position and velocity of the body's origin. */
static void origin(const mbsr_force_body *body, double x[3], double v[3])
{
    const int in_space = body->space == MBSR_SPACE_SPATIAL;
    const int axes = in_space ? 3 : body->space == MBSR_SPACE_FIXED ? 0 : 2;
    for (int k = 0; k < 3; ++k) {
        x[k] = k < axes ? body->p[(in_space ? MBSR_POSE_X : 0) + k] : 0.0;
        v[k] = k < axes && body->V ? body->V[(in_space ? 3 : 0) + k] : 0.0;
    }
}

/* x = r + arm,  v = r' + omega x arm */
void mbsri_marker_on(const mbsr_force_body *body, const double in_body[3], mbsri_marker *marker)
{
    double R[9], omega[3];
    mbsri_body_axes(body, R);
    mbsri_body_spin(body, omega);
    mbsri_rotate3(R, in_body, marker->arm);
    origin(body, marker->x, marker->v);
    mbsri_add3(1.0, marker->arm, marker->x);
    mbsri_add_cross3(omega, marker->arm, marker->v);
}

void mbsri_marker_at(const mbsr_force_body *body, const double x[3], mbsri_marker *marker)
{
    double omega[3];
    mbsri_body_spin(body, omega);
    origin(body, marker->x, marker->v);
    for (int k = 0; k < 3; ++k) {
        marker->arm[k] = x[k] - marker->x[k];
        marker->x[k] = x[k];
    }
    mbsri_add_cross3(omega, marker->arm, marker->v);
}

void mbsri_push(const mbsr_force_body *body, const mbsri_marker *marker, double sign,
                const double force[3], const double moment[3])
{
    double total[3];
    mbsri_cross3(marker->arm, force, total);
    if (moment) mbsri_add3(1.0, moment, total);
    if (body->space == MBSR_SPACE_SPATIAL) {
        mbsri_add3(sign, total, body->f);
        mbsri_add3(sign, force, body->f + 3);
    } else if (body->space != MBSR_SPACE_FIXED) {
        body->f[0] += sign * force[0];
        body->f[1] += sign * force[1];
        if (body->space == MBSR_SPACE_PLANAR) body->f[2] += sign * total[2];
    }
}

void mbsri_store_point(const double point[3], double param[3])
{
    for (int k = 0; k < 3; ++k) param[k] = point ? point[k] : 0.0;
}

int mbsri_check_marker(const mbsr_force_args *args, int k, const double point[3], const char *name,
                       char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body + k;
    if (body->space == MBSR_SPACE_FLEXIBLE)
        return mbsri_refuse(text, MBSR_ERR_SPACE,
                            "body %d is FLEXIBLE; put the element on a marker of it", body->id);
    if (body->space == MBSR_SPACE_GENERAL) {
        return mbsri_refuse(text, MBSR_ERR_SPACE,
                            "body %d is in GENERAL space, which has no points", body->id);
    }
    if (body->space == MBSR_SPACE_POINT && mbsri_dot3(point, point) != 0.0) {
        return mbsri_refuse(text, MBSR_ERR_VALUE, "%s is (%g, %g, %g), but body %d is a POINT",
                            name, point[0], point[1], point[2], body->id);
    }
    return MBSR_OK;
}

int mbsri_check_markers(const mbsr_force_args *args, int first, char text[MBSR_TEXT_SIZE])
{
    const double *point = args->force->param + first;
    int status = mbsri_check_marker(args, 0, point, "point_a", text);
    if (!status) status = mbsri_check_marker(args, 1, point + 3, "point_b", text);
    return status ? status : mbsri_check_ends(args, text);
}

int mbsri_check_spatial(const mbsr_force_args *args, int k, int ground, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_body *body = args->body + k;
    if (body->id == MBSR_GROUND) {
        if (!ground) return mbsri_refuse(text, MBSR_ERR_ID, "it acts on the ground");
        if (body->space != MBSR_SPACE_GENERAL) return MBSR_OK;
    } else if (body->space == MBSR_SPACE_SPATIAL) {
        return MBSR_OK;
    }
    return mbsri_refuse(text, MBSR_ERR_SPACE, "body %d is not in SPATIAL space", body->id);
}
