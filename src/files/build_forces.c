/* Forces of a scene: springs of joints and tendons, stops, friction, weight.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/build_parts.h"
#include "files/solids.h"
#include "files/thrust.h"

#include <math.h>
#include <string.h>

/* Of a free joint, at rest as drawn. */
static mbsr_force_def free_spring(const mbsri_scene *s, const mbsri_scene_joint *j)
{
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    double k[6], d[6];
    for (int l = 0; l < 6; ++l) k[l] = j->stiffness, d[l] = j->damping;
    while (b->id != j->joint.body) ++b;
    return mbsr_force_bushing(MBSR_GROUND, &b->frame, b->id, NULL, k, d);
}

static bool add_joint_forces(mbsri_scene *s, mbsr_file *file, const mbsri_scene_joint *j)
{
    const mbsr_file_joint *of = &j->joint;
    bool good = true;
    if (s->with_passive && (j->stiffness != 0.0 || j->damping != 0.0 || j->cubic != 0.0)) {
        if (mbsri_has_axis(of)) {
            good = mbsri_scene_force(
                s, file,
                j->cubic > 0.0
                    ? mbsr_force_joint_cubic_spring(of->body, of->coordinate, j->stiffness,
                                                    j->cubic, j->damping, j->rest)
                    : mbsr_force_joint_spring(of->body, of->coordinate, j->stiffness, j->damping,
                                              j->rest),
                j->element, NULL);
        } else if (of->kind == MBSR_FILE_BALL) {
            const double k[3] = {j->stiffness, j->stiffness, j->stiffness},
                         d[3] = {j->damping, j->damping, j->damping};
            good = mbsri_scene_force(
                s, file, mbsr_force_joint_rotation_spring(of->body, k, d, NULL), j->element, NULL);
        } else if (!j->relative) {
            good = mbsri_scene_force(s, file, free_spring(s, j), j->element, NULL);
        }
    }
    if (good && of->stop_stiffness > 0.0)
        good = mbsri_scene_force(s, file,
                                 mbsr_force_joint_stop(of->body, of->coordinate, of->range[0],
                                                       of->range[1], of->stop_stiffness,
                                                       of->stop_damping),
                                 j->element, NULL);
    if (good && of->slip > 0.0)
        good = mbsri_scene_force(
            s, file, mbsr_force_joint_friction(of->body, of->coordinate, of->friction, of->slip),
            j->element, NULL);
    return good;
}

/* Along sites, which are of bodies of the model by now. */
static bool add_path(mbsri_scene *s, mbsr_file *file, const mbsri_scene_tendon *t)
{
    const mbsr_file_site *sites = s->sites.items, *a = sites + t->site[0], *b = sites + t->site[1];
    int body[MBSRI_PATH_MOST];
    double point[MBSRI_PATH_MOST][3];
    if (isnan(t->rest[0])) {
        mbsri_file_find(s, t->element,
                        "its spring is left out: without springlength it is at rest where joints "
                        "are at their springref, not as drawn");
        return true;
    }
    if (t->count == 2 && t->rest[0] == t->rest[1])
        return mbsri_scene_force(s, file,
                                 mbsr_force_point_spring(a->body, a->frame.x, b->body, b->frame.x,
                                                         t->stiffness, t->damping, t->rest[0]),
                                 t->element, NULL);
    for (int k = 0; k < t->count; ++k) {
        body[k] = sites[t->site[k]].body;
        memcpy(point[k], sites[t->site[k]].frame.x, sizeof point[k]);
    }
    return mbsri_scene_force(s, file,
                             mbsri_force_path(t->count, body, (const double(*)[3])point,
                                              t->stiffness, t->damping, t->rest),
                             t->element, NULL);
}

static bool add_tendon(mbsri_scene *s, mbsr_file *file, const mbsri_scene_tendon *t)
{
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    if (!s->with_passive || (t->stiffness == 0.0 && t->damping == 0.0)) return true;
    if (t->count > 0) return add_path(s, file, t);
    if (t->sum.count == 0) return true;
    mbsri_file_law law = {.bias = {0.0, -t->stiffness, -t->damping},
                          .rest = {t->rest[0], t->rest[1]}};
    if (isnan(t->rest[0])) {
        law.rest[0] = 0.0;
        for (int k = 0; k < t->sum.count; ++k)
            law.rest[0] += t->sum.factor[k] * joints[t->sum.joint[k]].rest;
        law.rest[1] = law.rest[0];
    }
    return mbsri_scene_sum_force(s, file, &t->sum, 1.0, &law, t->element, NULL);
}

/* ---- tendons at rest as drawn ---- */

static double drawn_length(const mbsri_scene *s, const mbsri_scene_tendon *t,
                           const mbsr_frame *frames)
{
    const mbsr_file_site *sites = s->sites.items;
    double last[3] = {0.0}, length = 0.0;
    for (int k = 0; k < t->count; ++k) {
        const mbsr_file_site *site = sites + t->site[k];
        const mbsr_frame world =
            site->body < 0 ? site->frame : mbsr_frame_product(frames + site->body, &site->frame);
        double square = 0.0;
        for (int l = 0; l < 3; ++l) square += (world.x[l] - last[l]) * (world.x[l] - last[l]);
        length += k > 0 ? sqrt(square) : 0.0;
        memcpy(last, world.x, sizeof last);
    }
    return length;
}

/* Lengths of rest of tendons along sites that have none, while sites are on bodies as drawn. Where
 * a joint is drawn elsewhere than its spring rests nothing is known of them. */
bool mbsri_scene_settle(mbsri_scene *s)
{
    mbsri_scene_tendon *t = s->tendons.items;
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const mbsr_frame *frames = s->tendons.count > 0 ? mbsri_scene_drawn(s) : NULL;
    for (int k = 0; k < s->joints.count; ++k)
        if (joints[k].rest != joints[k].joint.ref) return true;
    for (int k = 0; k < s->tendons.count && frames; ++k) {
        if (t[k].count > 0 && isnan(t[k].rest[0]))
            t[k].rest[0] = t[k].rest[1] = drawn_length(s, t + k, frames);
    }
    return frames || s->tendons.count == 0;
}

/* What carries a part of its weight. */
static bool add_lift(mbsri_scene *s, mbsr_file *file, const mbsri_scene_body *b)
{
    double mass, centre[3], tensor[6], F[3];
    const double *g = s->gravity;
    if (b->weightless == 0.0 || !mbsri_solid_of(&b->inertia, &mass, centre, tensor)) return true;
    for (int k = 0; k < 3; ++k) F[k] = -b->weightless * mass * g[k];
    if (F[0] == 0.0 && F[1] == 0.0 && F[2] == 0.0) return true;
    return mbsri_scene_force(s, file, mbsri_force_lift(b->id, centre, F), b->element, NULL);
}

/* ---- all of it ---- */

bool mbsri_scene_forces(mbsri_scene *s, mbsr_file *file, const mbsri_element *root)
{
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const mbsri_scene_tendon *tendons = s->tendons.items;
    const double *g = s->gravity;
    if ((g[0] != 0.0 || g[1] != 0.0 || g[2] != 0.0) &&
        !mbsri_scene_force(s, file, mbsr_force_gravity(g[0], g[1], g[2]), root, NULL))
        return false;
    for (int k = 0; k < s->bodies.count; ++k) {
        if (!add_lift(s, file, mbsri_scene_bodies(s) + k)) return false;
    }
    if (!mbsri_scene_limits(s)) return false;
    for (int k = 0; k < s->joints.count; ++k) {
        if (!add_joint_forces(s, file, joints + k)) return false;
    }
    for (int k = 0; k < s->tendons.count; ++k) {
        if (!add_tendon(s, file, tendons + k)) return false;
    }
    return true;
}
