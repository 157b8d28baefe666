/* Shapes of MJCF, and what they weigh.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/colours.h"
#include "files/hulls.h"
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <math.h>
#include <string.h>

static bool shape_kind(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_shape_kind *kind,
                       bool *known)
{
    static const char *const names[] = {"box",       "sphere", "cylinder", "capsule",
                                        "ellipsoid", "plane",  "mesh",     "hfield"};
    const char *type = mbsri_mjcf_get(node, "type");
    *known = true;
    *kind = mbsri_mjcf_get(node, "mesh") ? MBSR_SHAPE_MESH : MBSR_SHAPE_SPHERE;
    if (!type) return true;
    for (int k = 0; k < 8; ++k) {
        if (strcmp(type, names[k]) != 0) continue;
        *kind = (mbsr_shape_kind)k;
        return true;
    }
    *known = false;
    if (strcmp(type, "sdf") != 0)
        return mbsri_file_refuse(m->s, node->e, "there is no type '%.40s'", type);
    mbsri_file_find(m->s, node->e, "a shape of type '%.10s' is left out", type);
    return true;
}

/* Sizes, and the frame of one that is given from end to end. */
static bool read_size(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape)
{
    static const int least[] = {3, 1, 2, 2, 3, 0, 0, 0};
    double ends[6], along[3], length = 0.0, middle[3];
    int given, count;
    const bool ended = shape->kind == MBSR_SHAPE_CAPSULE || shape->kind == MBSR_SHAPE_CYLINDER ||
                       shape->kind == MBSR_SHAPE_BOX || shape->kind == MBSR_SHAPE_ELLIPSOID;
    if (!mbsri_mjcf_numbers(m, node, "size", 0, 3, shape->size, &count) ||
        !mbsri_mjcf_numbers(m, node, "fromto", 6, 6, ends, &given))
        return false;
    if (given && ended) {
        for (int k = 0; k < 3; ++k) {
            along[k] = ends[k] - ends[3 + k];
            middle[k] = 0.5 * (ends[k] + ends[3 + k]);
            length += along[k] * along[k];
        }
        if (!(length > 0.0)) return mbsri_file_refuse(m->s, node->e, "fromto has no length");
        const bool round = shape->kind == MBSR_SHAPE_CAPSULE || shape->kind == MBSR_SHAPE_CYLINDER;
        shape->frame = mbsri_mjcf_along(middle, along);
        if (!round) shape->size[1] = shape->size[0];
        shape->size[round ? 1 : 2] = 0.5 * sqrt(length);
        return count > 0 || mbsri_file_refuse(m->s, node->e, "it has no size");
    }
    for (int k = 0; k < least[shape->kind]; ++k) {
        if (!(shape->size[k] > 0.0))
            return mbsri_file_refuse(m->s, node->e, "its size must be %d positive number%s",
                                     least[shape->kind], least[shape->kind] > 1 ? "s" : "");
    }
    return true;
}

/* Volume, tensor and frame at the centre of a mesh, its principal axes there; false: not known, as
 * a finding says. */
static bool weigh_mesh(mbsri_mjcf *m, const mbsri_mjcf_part *node, const mbsr_frame *at,
                       mbsr_frame *frame, mbsr_frame *principal, double *volume, double tensor[6])
{
    const char *name = mbsri_mjcf_get(node, "mesh");
    mbsri_mjcf_mesh *mesh = mbsri_mjcf_find_mesh(m, name);
    const char *wrong = mesh ? mbsri_mjcf_measure(m, mesh) : "there is no such mesh";
    if (wrong) {
        const int reason = mesh ? mesh->reason : 0;
        mbsri_file_find(m->s, node->e,
                        "the mass of mesh '%.40s' is left out, its body has no <inertial>: %s%s%s",
                        name ? name : "", wrong, reason > 1 ? ": " : "", mbsri_file_why(reason));
        return false;
    }
    const double *x = mesh->solid.centre;
    const mbsr_frame centre = mbsr_frame_at(x[0], x[1], x[2]);
    *frame = mbsr_frame_product(at, &centre);
    *principal = mbsr_frame_product(at, &mesh->principal);
    *volume = mesh->solid.volume;
    memcpy(tensor, mesh->solid.tensor, sizeof mesh->solid.tensor);
    return true;
}

/* Its part of the inertia of the body, where `sum` is given. */
static bool weigh_shape(mbsri_mjcf *m, const mbsri_mjcf_part *node, const mbsr_frame *at,
                        const mbsr_file_shape *shape, mbsri_mjcf_solids *sum)
{
    const double *groups = mbsri_mjcf_compiler(m, node->e)->groups;
    double density = 1000.0, mass = 0.0, group = 0.0, volume, I[6];
    int given;
    if (!mbsri_mjcf_number(m, node, "density", &density) ||
        !mbsri_mjcf_number(m, node, "group", &group) ||
        !mbsri_mjcf_numbers(m, node, "mass", 1, 1, &mass, &given))
        return false;
    if (mass < 0.0 || density < 0.0)
        return mbsri_file_refuse(m->s, node->e, "its mass or density is negative");
    if (sum && mbsri_mjcf_switch(node, "shellinertia", false))
        mbsri_file_find(m->s, node->e, "its inertia is that of a solid, not of a shell");
    if (!sum || group < groups[0] || group > groups[1]) return true;
    mbsr_frame frame = shape->frame, principal = frame;
    if (shape->kind == MBSR_SHAPE_MESH) {
        if ((given ? mass : density) == 0.0) return true;
        if (!weigh_mesh(m, node, at, &frame, &principal, &volume, I)) return true;
    } else if (!mbsri_shape_solid(shape->kind, shape->size, &volume, I) || !(volume > 0.0)) {
        return true;
    }
    const double factor = given ? mass / volume : density;
    if (factor == 0.0) return true;
    for (int k = 0; k < 6; ++k) I[k] *= factor;
    const mbsr_inertia own = mbsri_solid(m->s->arena, factor * volume, &frame, I);
    sum->inertia = sum->some ? mbsr_inertia_sum(sum->inertia, own) : own;
    sum->some = true;
    if (factor * volume > 1e-14) { /* as MuJoCo */
        ++sum->heavy;
        sum->frame = principal;
    }
    return true;
}

void mbsri_mjcf_plain_law(double friction[3], double settle[2])
{
    friction[0] = 1.0, friction[1] = 0.005, friction[2] = 0.0001;
    settle[0] = 0.02, settle[1] = 1.0;
}

bool mbsri_mjcf_reference(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                          double to[2])
{
    if (!mbsri_mjcf_numbers(m, node, attribute, 1, 2, to, NULL)) return false;
    if (to[0] < 0.0 && to[1] <= 0.0) return true;
    if (!(to[0] > 0.0 && to[1] > 0.0)) to[0] = 0.02, to[1] = 1.0;
    if (!m->unsafe) to[0] = fmax(to[0], 2.0 * m->timestep);
    return true;
}

void mbsri_mjcf_rub(double kinds, double friction[3])
{
    if (kinds < 3.0) friction[0] = 0.0;
    if (kinds < 4.0) friction[1] = 0.0;
    if (kinds < 6.0) friction[2] = 0.0;
}

/* Groups above 2 are those that MuJoCo does not show at first. */
static bool find_use(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape)
{
    double group = 0.0, type = 1.0, affinity = 1.0, kinds = 3.0;
    mbsri_mjcf_plain_law(shape->friction, shape->settle);
    if (!mbsri_mjcf_number(m, node, "group", &group) ||
        !mbsri_mjcf_number(m, node, "contype", &type) ||
        !mbsri_mjcf_number(m, node, "conaffinity", &affinity) ||
        !mbsri_mjcf_number(m, node, "condim", &kinds) ||
        !mbsri_mjcf_numbers(m, node, "friction", 1, 3, shape->friction, NULL) ||
        !mbsri_mjcf_number(m, node, "margin", &shape->margin) ||
        !mbsri_mjcf_reference(m, node, "solref", shape->settle))
        return false;
    mbsri_mjcf_rub(kinds, shape->friction);
    if (shape->margin < 0.0) return mbsri_file_refuse(m->s, node->e, "its margin is negative");
    shape->visual = group <= 2.0;
    shape->groups = type > 0.0 && type < 4294967296.0 ? (unsigned)type : 0;
    shape->mask = affinity > 0.0 && affinity < 4294967296.0 ? (unsigned)affinity : 0;
    shape->contact = shape->groups != 0 || shape->mask != 0;
    return true;
}

bool mbsri_mjcf_add_shape(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                          mbsri_mjcf_solids *sum)
{
    mbsr_file_shape shape = {
        .name = mbsri_mjcf_name(e), .body = at->body, .colour = {0.5, 0.5, 0.5, 1.0}};
    mbsri_mjcf_part node;
    bool known;
    if (!mbsri_mjcf_node(m, e, "geom", at->childclass, &node) ||
        !shape_kind(m, &node, &shape.kind, &known))
        return false;
    if (!known) return true;
    if (!mbsri_mjcf_frame(m, &node, &shape.frame) || !mbsri_mjcf_colour(m, &node, &shape) ||
        !find_use(m, &node, &shape))
        return false;
    const char *mesh = mbsri_mjcf_get(&node, "mesh");
    const bool field = shape.kind == MBSR_SHAPE_HEIGHTS;
    if (field && !mbsri_mjcf_field_shape(m, &node, &shape, &known)) return false;
    if (!known) return true;
    if (!mesh && !field && !read_size(m, &node, &shape)) return false;
    shape.frame = mbsr_frame_product(at->frame, &shape.frame);
    const mbsr_frame own = shape.frame;
    if (mesh && !mbsri_mjcf_mesh_shape(m, &node, &shape, &known)) return false;
    if (!known) return true;
    if (!mbsri_hull_shape(m->s, e, &shape) || !weigh_shape(m, &node, &own, &shape, sum))
        return false;
    mbsr_file_shape *to = mbsri_list_add(m->s->arena, &m->s->shapes, sizeof *to);
    if (to) *to = shape;
    return to != NULL;
}
