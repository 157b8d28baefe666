/* Poses of SDF: where what has one is, and which link it is fixed to.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The pose of a link or model is relative to its model, of a frame to what it is attached to (its
 * model), of a joint to its child, of a shape to its link, unless the attribute relative_to names
 * another one. The pose of a model with a placement frame P places that frame: T_model = T_pose
 * T_P^-1, with T_P as seen from the model. */
#include "files/sdf_parts.h"
#include "files/urdf_parts.h"

#include <string.h>

bool mbsri_sdf_read_pose(mbsri_scene *s, const mbsri_element *pose, mbsr_frame *frame)
{
    double x[7] = {0.0};
    const char *format = pose ? mbsri_attribute(pose, "rotation_format") : NULL,
               *degrees = pose ? mbsri_attribute(pose, "degrees") : NULL;
    const bool by_quaternion = format && strcmp(format, "quat_xyzw") == 0;
    const double unit = degrees && (*degrees == '1' || strcmp(degrees, "true") == 0)
                            ? 3.14159265358979323846 / 180.0
                            : 1.0;
    const int count = by_quaternion ? 7 : 6;
    *frame = mbsr_frame_identity();
    if (!pose || !pose->text) return true;
    if (!mbsri_numbers(s, pose, "its text", pose->text, count, count, x, NULL)) return false;
    if (!by_quaternion) {
        for (int k = 3; k < 6; ++k) x[k] *= unit;
        *frame = mbsri_rpy_frame(x, x + 3);
        return true;
    }
    const double quaternion[4] = {x[6], x[3], x[4], x[5]};
    double square = 0.0;
    for (int k = 0; k < 4; ++k) square += quaternion[k] * quaternion[k];
    if (!(square > 0.0)) return mbsri_file_refuse(s, pose, "its quaternion has no direction");
    *frame = mbsr_frame_quaternion(x, quaternion);
    return true;
}

const char *mbsri_sdf_full_name(const mbsri_sdf *f, int model, const char *name)
{
    const char *before = model < 0 ? MBSRI_SDF_ALONE : mbsri_sdf_nodes(f)[model].name;
    if (strcmp(before, MBSRI_SDF_ALONE) == 0) return name;
    return mbsri_arena_join(f->s->arena, before, "::", name);
}

int mbsri_sdf_find(const mbsri_sdf *f, int model, const char *name)
{
    const char *full = mbsri_sdf_full_name(f, model, name);
    return full ? mbsri_names_find(&f->names, full) : -1;
}

/* What a pose is relative to: its attribute, `frame` before version 1.7; "": nothing said. */
static const char *base_of(const mbsri_element *pose)
{
    const char *base = pose ? mbsri_attribute(pose, "relative_to") : NULL;
    if (pose && !base) base = mbsri_attribute(pose, "frame");
    return base ? base : "";
}

static bool is_child_of(const mbsri_sdf_node *n, const char *attribute, const char **name)
{
    *name = mbsri_attribute(n->element, attribute);
    return *name && (*name)[0];
}

static bool find_sdf_frame(mbsri_sdf *f, int node);

/* Where a model has the frame that its pose places. */
static bool find_placement(mbsri_sdf *f, int node, mbsr_frame *frame)
{
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    if (!n.placement || !n.placement[0]) return true;
    mbsr_frame placed;
    if (!mbsri_sdf_place(f, n.element, node, n.placement, &placed)) return false;
    const mbsr_frame back = mbsr_frame_inverse(&placed);
    *frame = mbsr_frame_product(frame, &back);
    return true;
}

static bool find_sdf_frame(mbsri_sdf *f, int node)
{
    const mbsri_sdf_node n = mbsri_sdf_nodes(f)[node];
    const char *base = base_of(n.pose), *attached;
    mbsr_frame from, own;
    if (n.state == MBSRI_SDF_KNOWN) return true;
    if (n.state == MBSRI_SDF_OPEN)
        return mbsri_file_refuse(f->s, n.element, "its pose depends on itself");
    mbsri_sdf_nodes(f)[node].state = MBSRI_SDF_OPEN;
    if (!base[0] && n.kind == MBSRI_SDF_FRAME && is_child_of(&n, "attached_to", &attached))
        base = attached;
    if (!base[0] && n.kind == MBSRI_SDF_JOINT && mbsri_text_of(n.element, "child"))
        base = mbsri_text_of(n.element, "child");
    if (!mbsri_sdf_place(f, n.element, n.model, base, &from) ||
        !mbsri_sdf_read_pose(f->s, n.pose, &own))
        return false;
    mbsr_frame frame = mbsr_frame_product(&from, &own);
    if (n.kind == MBSRI_SDF_MODEL && !find_placement(f, node, &frame)) return false;
    mbsri_sdf_nodes(f)[node].frame = frame;
    mbsri_sdf_nodes(f)[node].state = MBSRI_SDF_KNOWN;
    return true;
}

bool mbsri_sdf_place(mbsri_sdf *f, const mbsri_element *e, int model, const char *name,
                     mbsr_frame *frame)
{
    *frame = mbsr_frame_identity();
    if (!name || !name[0] || strcmp(name, "__model__") == 0) return true;
    if (model < 0 && strcmp(name, "world") == 0) return true;
    const int node = mbsri_sdf_find(f, model, name);
    if (node < 0) return mbsri_file_refuse(f->s, e, "'%.60s' is no frame here", name);
    if (!find_sdf_frame(f, node)) return false;
    *frame = mbsri_sdf_nodes(f)[node].frame;
    for (int m = mbsri_sdf_nodes(f)[node].model; m != model; m = mbsri_sdf_nodes(f)[m].model) {
        if (!find_sdf_frame(f, m)) return false;
        *frame = mbsr_frame_product(&mbsri_sdf_nodes(f)[m].frame, frame);
    }
    return true;
}

bool mbsri_sdf_world(mbsri_sdf *f, int node, mbsr_frame *frame)
{
    *frame = mbsr_frame_identity();
    for (int n = node; n >= 0; n = mbsri_sdf_nodes(f)[n].model) {
        if (!find_sdf_frame(f, n)) return false;
        *frame = mbsr_frame_product(&mbsri_sdf_nodes(f)[n].frame, frame);
    }
    return true;
}

bool mbsri_sdf_link(mbsri_sdf *f, const mbsri_element *e, int model, const char *name, int *link)
{
    const char *next = name;
    for (int left = f->nodes.count; left >= 0; --left) {
        const bool own = strcmp(next, "__model__") == 0 && model >= 0;
        *link = -1;
        if (strcmp(next, "world") == 0) return true;
        const int node = own ? model : mbsri_sdf_find(f, model, next);
        if (node < 0) return mbsri_file_refuse(f->s, e, "'%.60s' is no link or frame here", name);
        const mbsri_sdf_node *n = mbsri_sdf_nodes(f) + node;
        *link = n->kind == MBSRI_SDF_LINK ? node : n->canonical;
        if (n->kind == MBSRI_SDF_LINK) return true;
        if (n->kind == MBSRI_SDF_MODEL)
            return *link >= 0 || mbsri_file_refuse(f->s, e, "'%.60s' has no link", name);
        model = n->model;
        if (n->kind == MBSRI_SDF_JOINT)
            next = mbsri_text_of(n->element, "child");
        else if (!is_child_of(n, "attached_to", &next))
            next = model < 0 ? "world" : "__model__";
        if (!next) break;
    }
    return mbsri_file_refuse(f->s, e, "'%.60s' is attached to no link", name);
}
