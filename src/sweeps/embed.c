/* Bodies and joints as the vectorised sweeps take them: see embed.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In the plane, motions along x, y and about z and those along z and about x, y do not mix. So the
 * moments of inertia about x and y may be anything: with those about z, M of a rigid body is
 * regular, and the bound of rounding errors (rank_bound.h) tells more. */
#include "sweeps/embed.h"

#include "inertias/rigid.h"
#include "joints/planar.h"
#include "recursion/kinematics.h"

#include <math.h>
#include <string.h>

/* The joint's free coordinates stand in option[0], the driven ones in option[1], as masks. */
enum { DRIVEN = 1, AXES_IN_PLANE = 3 };

static bool is_planar(const mbsri_joint *joint, int *free)
{
    return mbsri_planar_coordinates(joint->table, joint->option, free);
}

static bool in_plane(const mbsri_body *b)
{
    return b->joint.space == MBSR_SPACE_PLANAR || b->joint.space == MBSR_SPACE_POINT;
}

/* ---- which bodies ---- */

bool mbsri_embeds_inertia(const mbsri_body *b)
{
    if (b->mass.added) return false;
    switch (b->inertia.kind) {
    case MBSR_INERTIA_NOT_GIVEN:
    case MBSR_INERTIA_PARTICLE: return true;
    case MBSR_INERTIA_SPATIAL: return !in_plane(b);
    case MBSR_INERTIA_PLANAR: return in_plane(b);
    case MBSR_INERTIA_MATRIX: return !b->inertia.matrix;
    default: return false;
    }
}

bool mbsri_embeds(const mbsr_model *m, int bodies, int i)
{
    const mbsri_body *b = m->body + i;
    int free;
    if (b->lock.count > 0 || !mbsri_embeds_inertia(b) || b->pred.space == MBSR_SPACE_GENERAL)
        return false;
    if (b->joint.table->position == mbsri_chain_position) return true;
    if (!is_planar(&b->joint, &free) || !in_plane(b)) return false;
    const bool leaf = i == bodies || m->body[i + 1].parent != i,
               turning = b->pred.space == MBSR_SPACE_PLANAR;
    return leaf || !turning || b->joint.space == MBSR_SPACE_PLANAR;
}

/* ---- joints ---- */

static void place_frame(const double origin[2], double angle, double param[12])
{
    const mbsr_frame frame = {
        .x = {origin[0], origin[1], 0.0},
        .R = {cos(angle), sin(angle), 0.0, -sin(angle), cos(angle), 0.0, 0.0, 0.0, 1.0}};
    memcpy(param, frame.x, sizeof frame.x);
    memcpy(param + 3, frame.R, sizeof frame.R);
}

static void add_step(mbsri_joint *joint, double *param, int coordinate, int code)
{
    const int step = joint->option[0]++,
              kind = coordinate == 2 ? MBSRI_ROTATION : MBSRI_TRANSLATION;
    param[MBSRI_AXES + MBSRI_AXIS_SIZE * step + coordinate] = 1.0;
    joint->option[1 + step] = kind | code;
}

mbsri_joint mbsri_embedded_joint(const mbsri_body *b, double param[MBSRI_EMBED_PARAMS])
{
    static const double origin[2] = {0.0, 0.0};
    mbsri_joint joint = b->joint;
    int free;
    if (!is_planar(&b->joint, &free)) return joint;
    const double *given = b->joint.param;
    const bool point = joint.space == MBSR_SPACE_POINT;
    memset(param, 0, MBSRI_EMBED_PARAMS * sizeof *param);
    place_frame(given, given[2], param + MBSRI_A);
    /* the axes of a POINT stay those of its predecessor */
    place_frame(point ? origin : given + 3, point ? given[2] : given[5], param + MBSRI_B);
    const int driven = b->joint.option[DRIVEN];
    memset(joint.option, 0, sizeof joint.option);
    for (int k = 0, q = 0, s = 0; k < AXES_IN_PLANE; ++k) {
        if (free & 1 << k)
            add_step(&joint, param, k, q++ << MBSRI_PLACE_SHIFT);
        else if (driven & 1 << k)
            add_step(&joint, param, k, MBSRI_DRIVEN | s++ << MBSRI_PLACE_SHIFT);
    }
    joint.space = MBSR_SPACE_SPATIAL;
    joint.d = 6;
    joint.np = MBSR_POSE_SIZE;
    joint.param = param;
    return joint;
}

/* theta_i = theta_pi + alpha + phi - beta; a POINT has no angle, nor has a root at rest */
void mbsri_embedded_angle(const mbsri_body *b, double *angle, int *coordinate)
{
    int free;
    *angle = 0.0;
    *coordinate = MBSRI_ANGLE_HELD;
    if (b->joint.space != MBSR_SPACE_PLANAR || !is_planar(&b->joint, &free)) return;
    *angle = b->joint.param[2] - b->joint.param[5];
    if (free & MBSR_ANGLE)
        *coordinate = b->iq + b->nq - 1;
    else if (b->joint.option[DRIVEN] & MBSR_ANGLE)
        *coordinate = MBSRI_ANGLE_DRIVEN;
}

/* The angle is the last of the driven coordinates. */
double mbsri_driven_angle(const mbsri_joint *joint, double t)
{
    double s[3] = {0.0}, rate[3] = {0.0}, second[3] = {0.0};
    const int driven = joint->option[DRIVEN];
    (void)joint->motion(joint->user, t, s, rate, second);
    return s[(driven & 1) + (driven >> 1 & 1)];
}

/* ---- inertias ---- */

mbsr_inertia mbsri_embedded_inertia(const mbsri_body *b, double length)
{
    const mbsr_inertia *given = &b->inertia;
    const double m = given->mass, about = given->moment, round = m * length * length;
    /* no joint turns a POINT that does not stand on a PLANAR body */
    const bool turned = b->joint.space != MBSR_SPACE_POINT || b->pred.space == MBSR_SPACE_PLANAR;
    if (given->kind == MBSR_INERTIA_NOT_GIVEN) return mbsr_inertia_zero();
    if (given->kind == MBSR_INERTIA_PLANAR) {
        return mbsr_inertia_rigid(m, (double[3]){given->com[0], given->com[1], 0.0},
                                  (double[6]){about, about, about, 0.0, 0.0, 0.0});
    }
    if (turned || given->kind != MBSR_INERTIA_PARTICLE) return *given;
    const double com[3] = {0.0, 0.0, 0.0};
    return mbsr_inertia_rigid(m, com, (double[6]){round, round, round, 0.0, 0.0, 0.0});
}

/* ---- states ---- */

void mbsri_lift(int d, const double *x, double lifted[6])
{
    for (int k = 0; k < 6; ++k) lifted[k] = d == 6 ? x[k] : 0.0;
    for (int k = 0; k < 2 && d < 6; ++k) lifted[3 + k] = x[k];
    if (d == 3) lifted[2] = x[2];
}

void mbsri_lower(int d, const double lifted[6], double *x)
{
    for (int k = 0; k < 6 && d == 6; ++k) x[k] = lifted[k];
    for (int k = 0; k < 2 && d < 6; ++k) x[k] = lifted[3 + k];
    if (d == 3) x[2] = lifted[2];
}

void mbsri_embedded_pose(mbsr_space space, const double *p, double R[9], double r[3])
{
    for (int k = 0; k < 9; ++k) R[k] = k % 4 == 0;
    for (int k = 0; k < 3; ++k) r[k] = 0.0;
    if (space == MBSR_SPACE_SPATIAL) {
        memcpy(R, p + MBSR_POSE_R, 9 * sizeof *R);
        memcpy(r, p + MBSR_POSE_X, 3 * sizeof *r);
    }
    if (space == MBSR_SPACE_POINT || space == MBSR_SPACE_PLANAR) memcpy(r, p, 2 * sizeof *r);
    if (space != MBSR_SPACE_PLANAR) return;
    R[0] = R[4] = cos(p[2]);
    R[1] = sin(p[2]);
    R[3] = -R[1];
}

int mbsri_embedded_root(const mbsr_model *m, mbsr_data *d, double R[9], double r[3], double V[6],
                        double A[6])
{
    const mbsr_space space = m->root.space;
    const int status = space == MBSR_SPACE_FIXED ? MBSR_OK : mbsri_move_root(m, d);
    for (int k = 0; k < 6; ++k) V[k] = A[k] = 0.0;
    mbsri_embedded_pose(space, d->p, R, r);
    if (status || space == MBSR_SPACE_FIXED || space == MBSR_SPACE_GENERAL) return status;
    mbsri_lift(m->root.d, d->V, V);
    mbsri_lift(m->root.d, d->A, A);
    return MBSR_OK;
}
