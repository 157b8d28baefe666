/* Joints of SDF that follow others.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A mimicking axis has q = multiplier (q_leader - reference) + offset. A gearbox with a reference
 * body keeps
 *
 *   theta_2 = -ratio theta_1
 *
 * for the angles of its parent about `axis` and of its child about `axis2` from that body, where
 * hinges join them to it. */
#include "files/sdf_parts.h"

#include <math.h>
#include <string.h>

static mbsri_scene_equality *new_equality(mbsri_scene *s, const mbsri_sdf_node *n,
                                          mbsri_scene_equality_kind kind)
{
    mbsri_scene_equality *q = mbsri_list_add(s->arena, &s->equalities, sizeof *q);
    if (q) *q = (mbsri_scene_equality){.kind = kind, .name = n->name, .element = n->element};
    return q;
}

/* ---- mimicking axes ---- */

/* The joint of the scene that has that name, and its axis. -1: there is none. */
static int find_joint(const mbsri_sdf *f, const mbsri_names *names, int model, const char *name,
                      const char *axis)
{
    const int node = mbsri_sdf_find(f, model, name);
    if (node < 0) return -1;
    const char *full = mbsri_sdf_nodes(f)[node].name;
    if (axis && strcmp(axis, "axis2") == 0) full = mbsri_arena_join(f->s->arena, full, "_2", "");
    return mbsri_names_find(names, full);
}

/* q = multiplier (q_leader - reference) + offset */
static bool add_mimic(mbsri_sdf *f, const mbsri_names *names, int node, int axis)
{
    mbsri_scene *s = f->s;
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    const mbsri_element *mimic =
        mbsri_child(mbsri_child(n.element, axis ? "axis2" : "axis"), "mimic");
    double multiplier = 1.0, offset = 0.0, reference = 0.0;
    if (!mimic) return true;
    const char *leader = mbsri_attribute(mimic, "joint");
    if (!mbsri_sdf_numbers(s, mimic, "multiplier", 1, &multiplier) ||
        !mbsri_sdf_numbers(s, mimic, "offset", 1, &offset) ||
        !mbsri_sdf_numbers(s, mimic, "reference", 1, &reference))
        return false;
    const int own = mbsri_names_find(names,
                                     axis ? mbsri_arena_join(s->arena, n.name, "_2", "") : n.name),
              other = leader ? find_joint(f, names, n.model, leader, mbsri_attribute(mimic, "axis"))
                             : -1;
    if (other < 0)
        return mbsri_file_refuse(s, n.element, "it mimics '%.50s', which is no joint with an axis",
                                 leader ? leader : "");
    if (own < 0 || own == other) return mbsri_file_refuse(s, n.element, "it mimics itself");
    mbsri_scene_equality *q = new_equality(s, &n, MBSRI_POLYNOMIAL);
    if (!q) return false;
    q->joint[0] = own, q->joint[1] = other;
    q->power[0] = offset - multiplier * reference, q->power[1] = multiplier;
    return true;
}

/* ---- gearboxes ---- */

/* Adds factor times the angle of link b from link a about an axis of a gearbox; false: no hinge
 * joins them. */
static bool add_angle(mbsri_sdf *f, const mbsri_names *names, int node, int a, int b, int axis,
                      double factor, mbsri_scene_sum *sum)
{
    const mbsri_sdf_node *n = mbsri_sdf_nodes(f);
    const int links[2] = {a, b};
    const mbsri_element *about = mbsri_child(n[node].element, axis ? "axis2" : "axis");
    mbsr_frame world = mbsr_frame_identity(), frame;
    double wanted[3], along = 0.0;
    for (int k = 0; k < 2; ++k) {
        const int child = links[!k], carrier = child < 0 ? -1 : n[child].carrier;
        if (carrier < 0 || n[carrier].end[0] != links[k]) continue;
        const int joint = mbsri_names_find(names, n[carrier].name);
        const mbsri_scene_joint *j = mbsri_scene_joints(f->s) + joint;
        if (joint < 0 || j->joint.kind != MBSR_FILE_HINGE) return false;
        if (!mbsri_sdf_direction(f, node, about, &world, wanted) ||
            !mbsri_sdf_world(f, child, &frame))
            return false;
        for (int l = 0; l < 9; ++l) along += wanted[l % 3] * frame.R[l] * j->axis[l / 3];
        sum->joint[sum->count] = joint;
        sum->factor[sum->count++] = factor * (k == 0 ? along : -along);
        return fabs(fabs(along) - 1.0) < 1e-3;
    }
    return false;
}

static bool add_gear(mbsri_sdf *f, const mbsri_names *names, int node)
{
    mbsri_scene *s = f->s;
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    const char *reference = mbsri_text_of(n.element, "gearbox_reference_body");
    double ratio = 1.0;
    int from = -1;
    mbsri_scene_sum sum = {.count = 0};
    if (!mbsri_sdf_numbers(s, n.element, "gearbox_ratio", 1, &ratio) ||
        (reference && !mbsri_sdf_link(f, n.element, n.model, reference, &from)))
        return false;
    if (!reference || !add_angle(f, names, node, from, n.end[0], 0, ratio, &sum) ||
        !add_angle(f, names, node, from, n.end[1], 1, 1.0, &sum)) {
        if (s->message[0]) return false;
        mbsri_file_find(s, n.element,
                        "it is left out: no hinges about its axes join both its links to its "
                        "reference body");
        return true;
    }
    mbsri_scene_equality *q = new_equality(s, &n, MBSRI_SUM);
    if (q) q->sum = sum;
    return q != NULL;
}

/* ---- all of them ---- */

bool mbsri_sdf_relations(mbsri_sdf *f)
{
    const mbsri_scene_joint *j = mbsri_scene_joints(f->s);
    mbsri_names names = {.slot = NULL};
    for (int k = 0; k < f->s->joints.count; ++k)
        if ((j[k].joint.kind == MBSR_FILE_HINGE || j[k].joint.kind == MBSR_FILE_SLIDE) &&
            mbsri_names_find(&names, j[k].joint.name) < 0 &&
            !mbsri_names_add(f->s->arena, &names, j[k].joint.name, k))
            return false;
    for (int k = 0; k < f->nodes.count; ++k)
        for (int axis = 0; axis < 2; ++axis)
            if (mbsri_sdf_nodes(f)[k].kind == MBSRI_SDF_JOINT && !add_mimic(f, &names, k, axis))
                return false;
    for (int k = 0; k < f->nodes.count; ++k)
        if (mbsri_sdf_is_gear(mbsri_sdf_nodes(f) + k) && !add_gear(f, &names, k)) return false;
    return true;
}
