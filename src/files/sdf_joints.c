/* Joints of SDF: their axes, limits, springs.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Axes are told along those of the joint, before version 1.5 of its model, or of what expressed_in
 * names; a universal joint and a revolute2 turn about `axis`, then `axis2`. A screw advances by
 * screw_thread_pitch / (2 pi), or by -1 / thread_pitch before version 1.10, per rad. */
#include "files/sdf_parts.h"
#include "files/urdf_parts.h"

#include <math.h>
#include <string.h>

enum { MOST_AXES = 2 };

typedef struct joint_type {
    const char *name;
    int axes;
    mbsr_file_joint_kind kind;
    bool limited;
} joint_type;

static const joint_type types[] = {
    {"fixed", 0, MBSR_FILE_FIXED, false},      {"revolute", 1, MBSR_FILE_HINGE, true},
    {"continuous", 1, MBSR_FILE_HINGE, false}, {"prismatic", 1, MBSR_FILE_SLIDE, true},
    {"ball", 1, MBSR_FILE_BALL, false},        {"universal", 2, MBSR_FILE_HINGE, true},
    {"revolute2", 2, MBSR_FILE_HINGE, true},   {"screw", 1, MBSR_FILE_HINGE, true},
    {"gearbox", 0, MBSR_FILE_FIXED, false},
};

static const joint_type *type_of(mbsri_scene *s, const mbsri_element *e)
{
    const char *type = mbsri_attribute(e, "type");
    for (size_t k = 0; type && k < sizeof types / sizeof *types; ++k)
        if (strcmp(types[k].name, type) == 0) return types + k;
    mbsri_file_refuse(s, e, "there is no type '%.40s'", type ? type : "");
    return NULL;
}

/* ---- one axis ---- */

bool mbsri_sdf_direction(mbsri_sdf *f, int node, const mbsri_element *axis, const mbsr_frame *body,
                         double direction[3])
{
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    const mbsri_element *xyz = mbsri_child(axis, "xyz");
    const char *in = xyz ? mbsri_attribute(xyz, "expressed_in") : NULL;
    mbsr_frame along, model = mbsr_frame_identity();
    double a[3] = {0.0, 0.0, 1.0}, length = 0.0;
    if (xyz && xyz->text && !mbsri_numbers(f->s, n.element, "xyz", xyz->text, 3, 3, a, NULL))
        return false;
    if (mbsri_sdf_switch(axis, "use_parent_model_frame", n.version < 5)) in = "__model__";
    if (!in || !in[0]) {
        if (!mbsri_sdf_world(f, node, &along)) return false;
    } else {
        if ((n.model >= 0 && !mbsri_sdf_world(f, n.model, &model)) ||
            !mbsri_sdf_place(f, n.element, n.model, in, &along))
            return false;
        along = mbsr_frame_product(&model, &along);
    }
    for (int k = 0; k < 3; ++k) length += a[k] * a[k];
    length = sqrt(length);
    if (!(length > 0.0) || !isfinite(length))
        return mbsri_file_refuse(f->s, n.element, "its axis has no direction");
    for (int k = 0; k < 3; ++k) {
        direction[k] = 0.0;
        for (int l = 0; l < 9; ++l)
            direction[k] +=
                body->R[3 * k + l / 3] * along.R[3 * (l % 3) + l / 3] * a[l % 3] / length;
    }
    return true;
}

/* Limits beyond 1e15 are none. */
static bool read_limits(mbsri_scene *s, const mbsri_element *axis, mbsri_scene_joint *j)
{
    static const double none = 1e15;
    const mbsri_element *limit = mbsri_child(axis, "limit"),
                        *dynamics = mbsri_child(axis, "dynamics");
    double range[2] = {-INFINITY, INFINITY};
    if (limit) {
        const char *const names[2] = {"lower", "upper"};
        for (int k = 0; k < 2; ++k) {
            const char *text = mbsri_text_of(limit, names[k]);
            if (text && strstr(text, "inf")) continue;
            if (!mbsri_sdf_numbers(s, limit, names[k], 1, range + k)) return false;
        }
    }
    const bool low = range[0] > -none, high = range[1] < none;
    j->joint.limited = low && high && range[0] < range[1];
    if (low != high)
        mbsri_file_find(s, j->element, "its limit is left out: it is on one side alone");
    if (low && high && range[0] > range[1])
        mbsri_file_find(s, j->element, "its limits are left out: lower is above upper");
    if (j->joint.limited) memcpy(j->joint.range, range, sizeof range);
    return !dynamics || (mbsri_sdf_numbers(s, dynamics, "damping", 1, &j->damping) &&
                         mbsri_sdf_numbers(s, dynamics, "friction", 1, &j->joint.friction) &&
                         mbsri_sdf_numbers(s, dynamics, "spring_stiffness", 1, &j->stiffness) &&
                         mbsri_sdf_numbers(s, dynamics, "spring_reference", 1, &j->rest));
}

static bool read_pitch(mbsri_scene *s, const mbsri_element *e, double *pitch)
{
    double thread = 1.0, turn = NAN;
    if (!mbsri_sdf_numbers(s, e, "thread_pitch", 1, &thread) ||
        !mbsri_sdf_numbers(s, e, "screw_thread_pitch", 1, &turn))
        return false;
    *pitch = isnan(turn) ? -1.0 / thread : turn / (2.0 * 3.14159265358979323846);
    return isfinite(*pitch) || mbsri_file_refuse(s, e, "its thread has no pitch");
}

/* ---- a joint ---- */

bool mbsri_sdf_is_gear(const mbsri_sdf_node *n)
{
    const char *type = mbsri_attribute(n->element, "type");
    return n->kind == MBSRI_SDF_JOINT && type && strcmp(type, "gearbox") == 0;
}

bool mbsri_sdf_joints(mbsri_sdf *f, int node, const mbsr_frame *body)
{
    static const char *const names[MOST_AXES] = {"axis", "axis2"};
    mbsri_scene *s = f->s;
    const mbsri_element *e = mbsri_sdf_nodes(f)[node].element;
    const joint_type *type = type_of(s, e);
    mbsr_frame world;
    if (!type || !mbsri_sdf_world(f, node, &world)) return false;
    const mbsr_frame back = mbsr_frame_inverse(body), own = mbsr_frame_product(&back, &world);
    for (int k = 0; k < type->axes; ++k) {
        const mbsri_element *axis = mbsri_child(e, names[k]);
        double direction[3] = {0.0};
        if (type->kind != MBSR_FILE_BALL && !mbsri_sdf_direction(f, node, axis, body, direction))
            return false;
        mbsri_scene_joint *j = mbsri_urdf_joint(s, e, type->kind, direction);
        if (!j) return false;
        j->joint.name = k == 0
                            ? mbsri_sdf_nodes(f)[node].name
                            : mbsri_arena_join(s->arena, mbsri_sdf_nodes(f)[node].name, "_2", "");
        memcpy(j->anchor, own.x, sizeof j->anchor);
        if (!j->joint.name || !read_limits(s, axis, j)) return false;
        if (!type->limited) j->joint.limited = false;
        if (strcmp(type->name, "screw") == 0 && !read_pitch(s, e, &j->pitch)) return false;
    }
    return true;
}
