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
static void rotate_by(const double quaternion[4], bool transposed, const double x[3], double y[3])
{
    double R[9], result[3];
    mbsr_quaternion_rotation(quaternion, R);
    for (int k = 0; k < 3; ++k) {
        result[k] = 0.0;
        for (int l = 0; l < 3; ++l) result[k] += R[transposed ? 3 * k + l : 3 * l + k] * x[l];
    }
    memcpy(y, result, sizeof result);
}

/* The product of two quaternions. */
static void quaternion_product(const double a[4], const double b[4], double ab[4])
{
    ab[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    ab[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    ab[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    ab[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

/* Free joints: (x, Q) and (v, W along the body's axes) there, (Q, x) and (w, v) along the axes of
 * `from` here. */
static void free_from_mujoco(const mbsr_frame *from, const double *p, const double *v, double *q,
                             double *u)
{
    const mbsr_frame back = mbsr_frame_inverse(from);
    double frame[4];
    mbsr_rotation_quaternion(back.R, frame);
    quaternion_product(frame, p + 3, q);
    rotate_by(frame, false, p, q + 4);
    for (int k = 0; k < 3; ++k) q[4 + k] += back.x[k];
    if (!u) return;
    rotate_by(q, false, v + 3, u);
    rotate_by(frame, false, v, u + 3);
}

static void free_to_mujoco(const mbsr_frame *from, const double *q, const double *u, double *p,
                           double *v)
{
    double frame[4];
    mbsr_rotation_quaternion(from->R, frame);
    quaternion_product(frame, q, p + 3);
    rotate_by(frame, false, q + 4, p);
    for (int k = 0; k < 3; ++k) p[k] += from->x[k];
    if (!v) return;
    rotate_by(q, true, u, v + 3);
    rotate_by(frame, false, u + 3, v);
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
        if (u) rotate_by(p, !forth, v, u);
        break;
    case MBSR_FILE_FREE: (forth ? free_from_mujoco : free_to_mujoco)(&j->from, p, v, q, u); break;
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

/* Numbers of a key's attribute; where there are fewer the others stay. */
static bool read_key(mbsri_scene *s, const mbsri_scene_key *k, const char *attribute,
                     const char *text, int count, double *to)
{
    const char *at = text;
    if (!text) return true;
    while (*at == ' ' || (*at >= '\t' && *at <= '\r')) ++at;
    for (int l = 0; l < count; ++l) {
        if (!*at && l > 0) {
            mbsri_file_find(s, k->element, "%s has %d numbers of %d: the others are as drawn",
                            attribute, l, count);
            break;
        }
        if (!mbsri_read_number(&at, to + l))
            return mbsri_file_refuse(s, k->element, "%s is not %d numbers", attribute, count);
    }
    return !*at ||
           mbsri_file_refuse(s, k->element, "%s has more than %d numbers", attribute, count);
}

/* One of zeros is 1 0 0 0. */
static void mend_quaternions(const mbsr_file *file, double *position)
{
    for (int k = 0, at = 0; k < file->joints; at += positions(file->joint + k), ++k) {
        const double *quaternion = quaternion_of(file->joint + k, 0, position + at);
        double square = 0.0;
        for (int l = 0; quaternion && l < 4; ++l) square += quaternion[l] * quaternion[l];
        if (quaternion && square == 0.0) position[quaternion - position] = 1.0;
    }
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
        mend_quaternions(file, qpos);
        if (mbsr_file_mujoco_state(file, 0, qpos, qvel, q, u))
            return mbsri_file_refuse(s, keys[k].element, "its state is not finite");
        out[k] = keys[k].key;
        out[k].q = q, out[k].u = u, out[k].control = control;
    }
    file->keys = s->keys.count;
    file->key = out;
    return true;
}

/* Where free joints count from: the world, or as drawn, on bodies that do not move. */
static void place_free(const mbsri_scene *s, const mbsri_scene_body *b)
{
    mbsri_scene_joint *j = mbsri_scene_joints(s) + b->first;
    if (b->joints != 1 || j->joint.kind != MBSR_FILE_FREE || !j->relative) return;
    j->joint.from = b->frame;
    for (int p = b->parent; p >= 0; p = mbsri_scene_bodies(s)[p].parent) {
        const mbsri_scene_body *below = mbsri_scene_bodies(s) + p;
        if (below->joints > 0) return;
        j->joint.from = mbsr_frame_product(&below->frame, &j->joint.from);
    }
}

/* A free joint where its body is drawn. */
static void draw_free(const mbsri_scene *s, const mbsri_scene_body *b, double *p)
{
    const mbsri_scene_joint *j = mbsri_scene_joints(s) + b->first;
    const mbsr_frame *drawn = j->relative ? &j->joint.from : &b->frame;
    memcpy(p, drawn->x, 3 * sizeof *p);
    mbsr_rotation_quaternion(drawn->R, p + 3);
}

/* The position as MuJoCo has it, as drawn. */
static void draw(const mbsri_scene *s, double *p)
{
    for (int k = 0, at = 0; k < s->bodies.count; ++k) {
        const mbsri_scene_body *b = mbsri_scene_bodies(s) + k;
        for (int l = 0; l < b->joints; ++l) {
            const mbsr_file_joint *j = &mbsri_scene_joints(s)[b->first + l].joint;
            if (j->kind == MBSR_FILE_FREE)
                draw_free(s, b, p + at);
            else if (positions(j) > 0)
                p[at] = j->kind == MBSR_FILE_BALL ? 1.0 : j->ref;
            at += positions(j);
        }
    }
}

bool mbsri_scene_states(mbsri_scene *s, mbsr_file *file)
{
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const int count = s->joints.count;
    mbsr_file_joint *out = mbsri_arena_take(s->arena, (size_t)(count + 1) * sizeof *out);
    if (!out) return false;
    for (int k = 0; k < count; ++k) mbsri_scene_joints(s)[k].joint.from = mbsr_frame_identity();
    for (int k = 0; k < s->bodies.count; ++k) place_free(s, mbsri_scene_bodies(s) + k);
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
    draw(s, p);
    if (mbsr_file_mujoco_state(file, 0, p, NULL, q, NULL)) return false;
    file->q0 = q;
    return place_keys(s, file, p);
}
