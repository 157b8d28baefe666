/* Actuators of a scene.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A servo, whose gain is that of its spring, may give its damping as a ratio r > 0 of the critical
 * one. With the mass M_k that coordinate k moves as drawn, all others held, and its part g_k in the
 * length,
 *
 *   damping = 2 r sqrt(gain sum M_k / g_k^2) */
#include "files/build_parts.h"
#include "files/thrust.h"
#include "files/weights.h"

#include <math.h>
#include <string.h>

static bool is_rated(const mbsr_file_actuator *a)
{
    return a->gain == -a->bias[1] && a->bias[2] > 0.0;
}

static void find_damping(const mbsri_scene_actuator *list, const mbsri_weight *weight,
                         mbsr_file_actuator *a)
{
    double mass = 0.0;
    for (int k = 0; k < list->sum.count; ++k) {
        const double part = a->gear * list->sum.factor[k];
        if (part * part > 1e-15) mass += weight[list->sum.joint[k]].mass / (part * part);
    }
    a->bias[2] *= -2.0 * sqrt(a->gain * mass);
}

static bool is_made(const mbsri_scene *s, const mbsri_scene_actuator *a)
{
    return s->with_actuators && (a->sum.count > 0 || a->site >= 0);
}

/* All joints that carry a site. */
static void count_carriers(const mbsri_scene *s, int site, int *users)
{
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    const int id = ((const mbsr_file_site *)s->sites.items)[site].body;
    int at = id == MBSR_GROUND ? -1 : 0;
    while (at >= 0 && b[at].id != id) ++at;
    for (; at >= 0; at = b[at].parent)
        for (int k = 0; k < b[at].joints; ++k) users[b[at].first + k] += 2;
}

/* For each joint, and behind these for each tendon, 1 where one actuator alone acts on it, on
 * nothing else; more where others do or act on others as well. NULL: no memory. */
static int *count_users(const mbsri_scene *s)
{
    const mbsri_scene_actuator *list = s->actuators.items;
    const int joints = s->joints.count, tendons = s->tendons.count;
    int *users = mbsri_arena_take(s->arena, (size_t)(joints + tendons + 1) * sizeof *users);
    for (int k = 0; users && k < s->actuators.count; ++k) {
        const mbsri_scene_sum *sum = &list[k].sum;
        if (!is_made(s, list + k)) continue;
        for (int l = 0; l < sum->count; ++l) users[sum->joint[l]] += sum->count > 1 ? 2 : 1;
        if (list[k].tendon >= 0) ++users[joints + list[k].tendon];
        if (list[k].site >= 0) count_carriers(s, list[k].site, users);
    }
    return users;
}

/* F stays within range / factor as well. */
static void narrow(mbsr_file_actuator *a, const double range[2], double factor)
{
    double own[2] = {range[0] / factor, range[1] / factor};
    if (own[0] > own[1]) own[0] = range[1] / factor, own[1] = range[0] / factor;
    for (int k = 0; k < 2 && a->force_limited; ++k) {
        const double x = a->force_range[k];
        own[k] = k == 0 ? fmax(own[k], x) : fmin(own[k], x);
    }
    a->force_limited = 1;
    memcpy(a->force_range, own, sizeof own);
}

/* What joints and tendons take of all their actuators; where it is not that of one alone there is a
 * finding. */
static void limit_forces(mbsri_scene *s, const int *users)
{
    mbsri_scene_actuator *list = s->actuators.items;
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const mbsri_scene_tendon *tendons = s->tendons.items;
    for (int k = 0; k < s->actuators.count; ++k) {
        const mbsri_scene_actuator *a = list + k;
        if (!is_made(s, a) || a->sum.count == 0) continue;
        const mbsri_scene_joint *j = joints + a->sum.joint[0];
        const double factor = a->actuator.gear * a->sum.factor[0];
        if (a->tendon >= 0 && tendons[a->tendon].force_limited &&
            users[s->joints.count + a->tendon] == 1)
            narrow(&list[k].actuator, tendons[a->tendon].force_range, 1.0);
        if (a->sum.count == 1 && users[a->sum.joint[0]] == 1 && j->force_limited && factor != 0.0)
            narrow(&list[k].actuator, j->force_range, factor);
    }
}

static void find_limits(mbsri_scene *s, const int *users)
{
    const mbsri_scene_joint *joints = mbsri_scene_joints(s);
    const mbsri_scene_tendon *tendons = s->tendons.items;
    static const char text[] = "what its actuators do is not limited in sum by actuatorfrcrange";
    for (int k = 0; k < s->joints.count; ++k)
        if (joints[k].force_limited && users[k] > 1) mbsri_file_find(s, joints[k].element, text);
    for (int k = 0; k < s->tendons.count; ++k)
        if (tendons[k].force_limited && users[s->joints.count + k] > 1)
            mbsri_file_find(s, tendons[k].element, text);
}

static bool add_actuator(mbsri_scene *s, mbsr_file *file, const mbsri_scene_actuator *of,
                         mbsr_file_actuator *a, const double *control)
{
    const mbsri_file_law law = {.gain = a->gain,
                                .bias = {a->bias[0], a->bias[1], a->bias[2]},
                                .control_limited = a->limited != 0,
                                .force_limited = a->force_limited != 0,
                                .control_range = {a->range[0], a->range[1]},
                                .force_range = {a->force_range[0], a->force_range[1]},
                                .control = control};
    if (of->site < 0)
        return mbsri_scene_sum_force(s, file, &of->sum, a->gear, &law, of->element, &a->force);
    const mbsr_file_site *site = (const mbsr_file_site *)s->sites.items + of->site;
    mbsri_thrust t = {site->body, site->frame, {0.0}, law};
    memcpy(t.gear, of->gear, sizeof t.gear);
    if (site->body == MBSR_GROUND) {
        mbsri_file_find(s, of->element, "it is left out: its site is on the ground");
        return true;
    }
    return mbsri_scene_force(s, file, mbsri_force_thrust(&t), of->element, &a->force);
}

bool mbsri_scene_actuators(mbsri_scene *s, mbsr_file *file)
{
    mbsri_scene_actuator *list = s->actuators.items;
    const int count = s->actuators.count;
    file->control = mbsri_arena_take(s->arena, (size_t)(count + 1) * sizeof *file->control);
    mbsr_file_actuator *out = mbsri_arena_take(s->arena, (size_t)(count + 1) * sizeof *out);
    const int *users = count_users(s);
    const mbsri_weight *weight = count > 0 ? mbsri_scene_weights(s) : NULL;
    if (!file->control || !out || !users || (count > 0 && !weight)) return false;
    limit_forces(s, users);
    find_limits(s, users);
    for (int k = 0; k < count; ++k) {
        mbsr_file_actuator *a = &list[k].actuator;
        a->force = MBSR_NONE;
        if (is_rated(a)) find_damping(list + k, weight, a);
        if (is_made(s, list + k) && !add_actuator(s, file, list + k, a, file->control + k))
            return false;
        a->sum = (mbsr_file_sum){list[k].sum.count, list[k].sum.joint, list[k].sum.factor};
        out[k] = *a;
    }
    file->actuators = count;
    file->actuator = out;
    return true;
}
