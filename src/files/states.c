/* States: as drawn, named, and between the model's coordinates and those of MuJoCo.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/states.h"

#include "files/numbers.h"

#include <math.h>
#include <string.h>

/* How many numbers a joint has among positions and among velocities. */
static int positions(const mbsr_file_joint *j)
{
    static const int count[] = {0, 1, 1, 4, 7};
    return count[j->kind];
}

static int velocities(const mbsr_file_joint *j)
{
    static const int count[] = {0, 1, 1, 3, 6};
    return count[j->kind];
}

/* y = R(quaternion)^(T) x */
static void turn(const double quaternion[4], bool transposed, const double x[3], double y[3])
{
    double R[9], result[3];
    mbsr_quaternion_rotation(quaternion, R);
    for (int k = 0; k < 3; ++k) {
        result[k] = 0.0;
        for (int l = 0; l < 3; ++l) result[k] += R[transposed ? 3 * k + l : 3 * l + k] * x[l];
    }
    memcpy(y, result, sizeof result);
}

/* One joint; v and u may be NULL. */
static void convert(const mbsr_file_joint *j, int inverse, const double *p, const double *v,
                    double *q, double *u)
{
    const bool forth = inverse == 0;
    switch (j->kind) {
    case MBSR_FILE_FIXED: break;
    case MBSR_FILE_HINGE:
    case MBSR_FILE_SLIDE:
        q[0] = p[0];
        if (u) u[0] = v[0];
        break;
    case MBSR_FILE_BALL:
        memcpy(q, p, 4 * sizeof *q);
        if (u) turn(p, !forth, v, u);
        break;
    case MBSR_FILE_FREE:
        memcpy(q, p + (forth ? 3 : 4), (forth ? 4 : 3) * sizeof *q);
        memcpy(q + (forth ? 4 : 3), p, (forth ? 3 : 4) * sizeof *q);
        if (!u) break;
        turn(forth ? p + 3 : p, !forth, v + (forth ? 3 : 0), u + (forth ? 0 : 3));
        memcpy(u + (forth ? 3 : 0), v + (forth ? 0 : 3), 3 * sizeof *u);
        break;
    }
}

/* The quaternion of a joint in its numbers; NULL: it has none. */
static const double *quaternion_of(const mbsr_file_joint *j, int inverse, const double *p)
{
    if (j->kind == MBSR_FILE_BALL) return p;
    return j->kind == MBSR_FILE_FREE ? p + (inverse ? 0 : 3) : NULL;
}

int mbsr_file_mujoco_state(const mbsr_file *file, int inverse, const double *position,
                           const double *velocity, double *q, double *u)
{
    if (!file || !position || !q || (velocity && !u)) return MBSR_ERR_NULL;
    for (int k = 0; k < file->nq; ++k) {
        if (!isfinite(position[k])) return MBSR_NOT_FINITE;
    }
    for (int k = 0; velocity && k < file->nu; ++k) {
        if (!isfinite(velocity[k])) return MBSR_NOT_FINITE;
    }
    int at = 0, rate = 0;
    for (int k = 0; k < file->joints; ++k) {
        const mbsr_file_joint *j = file->joint + k;
        const double *quaternion = quaternion_of(j, inverse, position + at);
        if (quaternion) {
            double square = 0.0;
            for (int l = 0; l < 4; ++l) square += quaternion[l] * quaternion[l];
            if (!(square > 0.0) || !isfinite(square)) return MBSR_ERR_VALUE;
        }
        convert(j, inverse, position + at, velocity ? velocity + rate : NULL, q + at,
                velocity ? u + rate : NULL);
        at += positions(j);
        rate += velocities(j);
    }
    return MBSR_OK;
}

/* Numbers of a key's attribute, all or none. */
static bool read_key(mbsri_scene *s, const mbsri_scene_key *k, const char *attribute,
                     const char *text, int count, double *to)
{
    const char *at = text;
    if (!text) return true;
    while (*at == ' ' || (*at >= '\t' && *at <= '\r')) ++at;
    for (int l = 0; l < count; ++l) {
        if (!mbsri_read_number(&at, to + l))
            return mbsri_file_refuse(s, k->element, "%s is not %d numbers", attribute, count);
    }
    return !*at ||
           mbsri_file_refuse(s, k->element, "%s has more than %d numbers", attribute, count);
}

static bool place_keys(mbsri_scene *s, mbsr_file *file, const double *as_drawn)
{
    const mbsri_scene_key *keys = s->keys.items;
    const size_t nq = (size_t)file->nq, nu = (size_t)file->nu, na = (size_t)file->actuators;
    mbsr_file_key *out = mbsri_arena_take(s->arena, (size_t)(s->keys.count + 1) * sizeof *out);
    if (!out) return false;
    for (int k = 0; k < s->keys.count; ++k) {
        double *qpos = mbsri_arena_take(s->arena, (2 * (nq + nu) + na + 1) * sizeof *qpos);
        if (!qpos) return false;
        double *qvel = qpos + nq, *q = qvel + nu, *u = q + nq, *control = u + nu;
        memcpy(qpos, as_drawn, nq * sizeof *qpos);
        if (!read_key(s, keys + k, "qpos", keys[k].position, file->nq, qpos) ||
            !read_key(s, keys + k, "qvel", keys[k].velocity, file->nu, qvel) ||
            !read_key(s, keys + k, "ctrl", keys[k].control, file->actuators, control))
            return false;
        if (mbsr_file_mujoco_state(file, 0, qpos, qvel, q, u))
            return mbsri_file_refuse(s, keys[k].element, "qpos has a quaternion of length zero");
        out[k] = keys[k].key;
        out[k].q = q, out[k].u = u, out[k].control = control;
    }
    file->keys = s->keys.count;
    file->key = out;
    return true;
}

/* Of a free joint where its body is drawn. */
static void draw_free(const mbsri_scene *s, const mbsri_scene_joint *j, double *p)
{
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    p[3] = 1.0;
    if (j->relative) return;
    while (b->id != j->joint.body) ++b;
    memcpy(p, b->frame.x, 3 * sizeof *p);
    mbsr_rotation_quaternion(b->frame.R, p + 3);
}

bool mbsri_scene_states(mbsri_scene *s, mbsr_file *file)
{
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const int count = s->joints.count;
    mbsr_file_joint *out = mbsri_arena_take(s->arena, (size_t)(count + 1) * sizeof *out);
    if (!out) return false;
    for (int k = 0; k < count; ++k) {
        out[k] = joints[k].joint;
        file->nq += positions(out + k);
        file->nu += velocities(out + k);
    }
    file->joints = count;
    file->joint = out;
    double *p = mbsri_arena_take(s->arena, 2 * (size_t)(file->nq + 1) * sizeof *p);
    if (!p) return false;
    double *q = p + file->nq;
    for (int k = 0, at = 0; k < count; at += positions(out + k), ++k) {
        if (out[k].kind == MBSR_FILE_BALL)
            p[at] = 1.0;
        else if (out[k].kind == MBSR_FILE_FREE)
            draw_free(s, joints + k, p + at);
        else
            p[at] = out[k].ref;
    }
    if (mbsr_file_mujoco_state(file, 0, p, NULL, q, NULL)) return false;
    file->q0 = q;
    return place_keys(s, file, p);
}
