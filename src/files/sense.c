/* Numbers of sensors: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As seen from a frame with origin y, axes R_0, velocity w and spin omega_0,
 *
 *   point R_0^T (x - y),   velocity R_0^T (v - w - omega_0 x (x - y)),
 *       spin R_0^T (omega - omega_0)
 *
 * Of the bodies of a subtree, with masses m, centres c, velocities v there and tensors I: centre
 * sum m c / sum m = C, its velocity V likewise, momentum about C: sum (I omega + m (c - C) x (v -
 * V)). */
#include "files/solids.h"
#include "algebra/space3.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/files.h>

#include <math.h>
#include <string.h>

/* Where what is asked for is evaluated. */
typedef struct state {
    const mbsr_file *file;
    const mbsr_model *model;
    mbsr_data *data;
    const double *q, *u;
} state;

/* A frame in the world, with its motion. */
typedef struct moving {
    mbsr_frame frame;
    double velocity[3], spin[3];
} moving;

/* ---- frames ---- */

static int find_frame(const state *s, int body, const mbsr_frame *on, moving *m)
{
    double pose[MBSR_POSE_SIZE] = {0.0}, twist[6] = {0.0}, arm[3], turned[3];
    mbsr_frame own = mbsr_frame_identity();
    memcpy(pose + MBSR_POSE_R, own.R, sizeof own.R); /* of a root at rest nothing is told */
    int status = mbsr_body_pose(s->model, s->data, body, pose);
    if (!status) status = mbsr_body_twist(s->model, s->data, body, twist);
    if (status) return status;
    memcpy(own.x, pose + MBSR_POSE_X, sizeof own.x);
    memcpy(own.R, pose + MBSR_POSE_R, sizeof own.R);
    m->frame = mbsr_frame_product(&own, on);
    for (int k = 0; k < 3; ++k) arm[k] = m->frame.x[k] - own.x[k];
    mbsri_cross3(twist, arm, turned);
    for (int k = 0; k < 3; ++k) {
        m->spin[k] = twist[k];
        m->velocity[k] = twist[3 + k] + turned[k];
    }
    return MBSR_OK;
}

/* As seen from another frame. */
static void see_from(const moving *from, moving *m)
{
    double arm[3], carried[3];
    const mbsr_frame back = mbsr_frame_inverse(&from->frame);
    for (int k = 0; k < 3; ++k) arm[k] = m->frame.x[k] - from->frame.x[k];
    mbsri_cross3(from->spin, arm, carried);
    for (int k = 0; k < 3; ++k) {
        m->velocity[k] -= from->velocity[k] + carried[k];
        m->spin[k] -= from->spin[k];
    }
    mbsri_unrotate3(from->frame.R, m->velocity, m->velocity);
    mbsri_unrotate3(from->frame.R, m->spin, m->spin);
    m->frame = mbsr_frame_product(&back, &m->frame);
}

static int sense_frame(const state *s, const mbsr_file_sensor *of, double *value)
{
    moving m, from;
    int status = find_frame(s, of->body, &of->frame, &m);
    if (!status && of->relative) status = find_frame(s, of->from_body, &of->from, &from);
    if (status) return status;
    if (of->relative) see_from(&from, &m);
    const double *axes = m.frame.R, *found = m.velocity;
    switch (of->kind) {
    case MBSR_SENSOR_POINT: found = m.frame.x; break;
    case MBSR_SENSOR_AXIS_X:
    case MBSR_SENSOR_AXIS_Y:
    case MBSR_SENSOR_AXIS_Z: found = axes + 3 * (of->kind - MBSR_SENSOR_AXIS_X); break;
    case MBSR_SENSOR_TURN: mbsr_rotation_quaternion(axes, value); return MBSR_OK;
    case MBSR_SENSOR_SPIN: found = m.spin; break;
    default: break;
    }
    memcpy(value, found, 3 * sizeof *value);
    if (of->own_axes) mbsri_unrotate3(axes, value, value);
    return MBSR_OK;
}

static int sense_acceleration(const state *s, const mbsr_file_sensor *of, double *value)
{
    double A[6] = {0.0};
    moving m;
    int status = find_frame(s, of->body, &of->frame, &m);
    if (!status && of->body != MBSR_GROUND) {
        status = mbsr_body_acceleration(s->model, s->data, of->body, A);
        if (!status)
            status = mbsr_body_point(s->model, s->data, of->body, of->frame.x, NULL, NULL, A + 3);
    }
    if (status) return status;
    const bool linear = of->kind == MBSR_SENSOR_ACCELERATION;
    for (int k = 0; k < 3; ++k) value[k] = linear ? A[3 + k] - of->gravity[k] : A[k];
    if (of->own_axes) mbsri_unrotate3(m.frame.R, value, value);
    return MBSR_OK;
}

/* What the joint of a body exerts on it, along the axes of the frame. */
static int sense_reaction(const state *s, const mbsr_file_sensor *of, double *value)
{
    double W[6], pose[MBSR_POSE_SIZE], arm[3], moment[3];
    moving m;
    int status = find_frame(s, of->body, &of->frame, &m);
    if (!status) status = mbsr_body_pose(s->model, s->data, of->body, pose);
    if (!status) status = mbsr_joint_reaction(s->model, s->data, of->body, W);
    if (status) return status;
    for (int k = 0; k < 3; ++k) arm[k] = pose[MBSR_POSE_X + k] - m.frame.x[k];
    mbsri_cross3(arm, W + 3, moment);
    for (int k = 0; k < 3; ++k)
        value[k] = of->kind == MBSR_SENSOR_FORCE ? W[3 + k] : W[k] + moment[k];
    mbsri_unrotate3(m.frame.R, value, value);
    return MBSR_OK;
}

/* ---- lengths and drives ---- */

/* Where the numbers of a joint stand in q and u. */
static void coordinate_places(const state *s, int joint, int *q, int *u)
{
    const mbsr_file_joint *j = s->file->joint + joint;
    (void)mbsr_body_coordinates(s->model, j->body, q, NULL, u, NULL);
    *q += j->position;
    *u += j->coordinate;
}

static void sum_up(const state *s, const mbsr_file_sum *sum, double *length, double *rate)
{
    *length = *rate = 0.0;
    for (int k = 0; k < sum->count; ++k) {
        int q, u;
        coordinate_places(s, sum->joint[k], &q, &u);
        *length += sum->factor[k] * s->q[q];
        *rate += sum->factor[k] * s->u[u];
    }
}

static int measure_path(const state *s, const mbsr_file_sensor *of, double *length, double *rate)
{
    moving at[2];
    *length = *rate = 0.0;
    for (int k = 0; k < of->sites; ++k) {
        const mbsr_file_site *site = s->file->site + of->site[k];
        double d[3], square = 0.0, closing = 0.0;
        at[0] = at[1];
        const int status = find_frame(s, site->body, &site->frame, at + 1);
        if (status) return status;
        for (int l = 0; l < 3 && k > 0; ++l) {
            d[l] = at[1].frame.x[l] - at[0].frame.x[l];
            square += d[l] * d[l];
            closing += d[l] * (at[1].velocity[l] - at[0].velocity[l]);
        }
        if (square > 0.0) *length += sqrt(square), *rate += closing / sqrt(square);
    }
    return MBSR_OK;
}

/* Of a tendon along sites, of a sum of joints, or of an actuator. */
static int sense_length(const state *s, const mbsr_file_sensor *of, double *value)
{
    double length, rate;
    int status = MBSR_OK;
    if (of->sites > 0)
        status = measure_path(s, of, &length, &rate);
    else
        sum_up(s, &of->sum, &length, &rate);
    if (status) return status;
    const double gear = of->actuator < 0 ? 1.0 : s->file->actuator[of->actuator].gear;
    value[0] = gear * (of->kind == MBSR_SENSOR_POSITION ? length : rate);
    return MBSR_OK;
}

static double drive_of(const state *s, int actuator)
{
    const mbsr_file_actuator *a = s->file->actuator + actuator;
    double w = s->file->control[actuator], l, rate;
    if (a->force == MBSR_NONE) return 0.0;
    sum_up(s, &a->sum, &l, &rate);
    if (a->limited) w = fmin(fmax(w, a->range[0]), a->range[1]);
    const double F =
        a->gain * w + a->bias[0] + a->bias[1] * a->gear * l + a->bias[2] * a->gear * rate;
    return a->force_limited ? fmin(fmax(F, a->force_range[0]), a->force_range[1]) : F;
}

static double joint_drive_of(const state *s, int joint)
{
    double tau = 0.0;
    for (int k = 0; k < s->file->actuators; ++k) {
        const mbsr_file_actuator *a = s->file->actuator + k;
        for (int l = 0; l < a->sum.count; ++l)
            if (a->sum.joint[l] == joint) tau += a->gear * a->sum.factor[l] * drive_of(s, k);
    }
    return tau;
}

static void sense_ball(const state *s, const mbsr_file_sensor *of, double *value)
{
    double R[9];
    int q, u;
    coordinate_places(s, of->joint, &q, &u);
    if (of->kind == MBSR_SENSOR_BALL) {
        memcpy(value, s->q + q, 4 * sizeof *value);
        return;
    }
    mbsr_quaternion_rotation(s->q + q, R);
    mbsri_unrotate3(R, s->u + u, value);
}

/* ---- subtrees ---- */

typedef struct sums {
    double mass, centre[3], velocity[3],
        momentum[3]; /* the last three times mass, about the origin */
} sums;

static int add_body(const state *s, int body, const mbsr_body_def *def, sums *sum)
{
    double mass, centre[3], I[6], spin[3], L[3], turned[3], moment[3];
    moving m;
    if (!mbsri_solid_of(&def->inertia, &mass, centre, I)) return MBSR_OK;
    const mbsr_frame on = mbsr_frame_at(centre[0], centre[1], centre[2]);
    const int status = find_frame(s, body, &on, &m);
    if (status) return status;
    mbsri_unrotate3(m.frame.R, m.spin, spin);
    L[0] = I[0] * spin[0] + I[3] * spin[1] + I[4] * spin[2];
    L[1] = I[3] * spin[0] + I[1] * spin[1] + I[5] * spin[2];
    L[2] = I[4] * spin[0] + I[5] * spin[1] + I[2] * spin[2];
    for (int k = 0; k < 3; ++k)
        turned[k] = m.frame.R[k] * L[0] + m.frame.R[3 + k] * L[1] + m.frame.R[6 + k] * L[2];
    mbsri_cross3(m.frame.x, m.velocity, moment);
    sum->mass += mass;
    for (int k = 0; k < 3; ++k) {
        sum->centre[k] += mass * m.frame.x[k];
        sum->velocity[k] += mass * m.velocity[k];
        sum->momentum[k] += turned[k] + mass * moment[k];
    }
    return MBSR_OK;
}

/* Bodies of a subtree follow each other: depth first. */
static int sense_subtree(const state *s, const mbsr_file_sensor *of, double *value)
{
    sums sum = {.mass = 0.0};
    double moment[3];
    const int first = of->body == MBSR_GROUND ? 0 : of->body;
    for (int k = first; k < mbsr_model_bodies(s->model); ++k) {
        mbsr_body_def def = mbsr_default_body_def();
        int status = mbsr_body_definition(s->model, k, &def);
        if (k > first && of->body != MBSR_GROUND && def.parent < of->body) break;
        if (!status) status = add_body(s, k, &def, &sum);
        if (status) return status;
    }
    memset(value, 0, 3 * sizeof *value);
    if (!(sum.mass > 0.0)) return MBSR_OK;
    mbsri_cross3(sum.centre, sum.velocity, moment);
    for (int k = 0; k < 3; ++k)
        value[k] = of->kind == MBSR_SENSOR_CENTRE ? sum.centre[k] / sum.mass
                   : of->kind == MBSR_SENSOR_CENTRE_VELOCITY
                       ? sum.velocity[k] / sum.mass
                       : sum.momentum[k] - moment[k] / sum.mass;
    return MBSR_OK;
}

/* ---- all of them ---- */

static int sense(const state *s, const mbsr_file_sensor *of, double t, double *value)
{
    switch (of->kind) {
    case MBSR_SENSOR_POSITION:
    case MBSR_SENSOR_RATE: return sense_length(s, of, value);
    case MBSR_SENSOR_BALL:
    case MBSR_SENSOR_BALL_RATE: sense_ball(s, of, value); return MBSR_OK;
    case MBSR_SENSOR_ACCELERATION:
    case MBSR_SENSOR_SPIN_RATE: return sense_acceleration(s, of, value);
    case MBSR_SENSOR_FORCE:
    case MBSR_SENSOR_TORQUE: return sense_reaction(s, of, value);
    case MBSR_SENSOR_DRIVE: value[0] = drive_of(s, of->actuator); return MBSR_OK;
    case MBSR_SENSOR_JOINT_DRIVE: value[0] = joint_drive_of(s, of->joint); return MBSR_OK;
    case MBSR_SENSOR_CENTRE:
    case MBSR_SENSOR_CENTRE_VELOCITY:
    case MBSR_SENSOR_MOMENTUM: return sense_subtree(s, of, value);
    case MBSR_SENSOR_TIME: value[0] = t; return MBSR_OK;
    case MBSR_SENSOR_POTENTIAL: return mbsr_energy(s->model, s->data, NULL, value);
    case MBSR_SENSOR_KINETIC: return mbsr_energy(s->model, s->data, value, NULL);
    default: return sense_frame(s, of, value);
    }
}

static bool has_no_cutoff(mbsr_file_sensor_kind kind)
{
    return kind == MBSR_SENSOR_BALL || kind == MBSR_SENSOR_TURN ||
           (kind >= MBSR_SENSOR_AXIS_X && kind <= MBSR_SENSOR_AXIS_Z);
}

int mbsr_file_sense(const mbsr_file *file, int sensor, const mbsr_model *model, mbsr_data *data,
                    double t, const double *q, const double *u, double value[4])
{
    if (!file || !model || !data || !value || (mbsr_model_nu(model) > 0 && (!q || !u)))
        return MBSR_ERR_NULL;
    if (sensor < 0 || sensor >= file->sensors) return MBSR_ERR_ID;
    const mbsr_file_sensor *of = file->sensor + sensor;
    const state s = {file, model, data, q, u};
    const int status = sense(&s, of, t, value);
    for (int k = 0; k < of->size && !status; ++k)
        if (!isfinite(value[k])) return MBSR_NOT_FINITE;
    for (int k = 0; k < of->size && !status && of->cutoff > 0.0 && !has_no_cutoff(of->kind); ++k)
        value[k] = fmin(fmax(value[k], -of->cutoff), of->cutoff);
    return status;
}
