/* Links of SDF: what they weigh and how they look.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Without <inertial> a link has 1 kg and moments of 1 kg m^2, as SDF says. */
#include "files/heights.h"
#include "files/hulls.h"
#include "files/sdf_parts.h"
#include "files/solids.h"
#include "files/urdf_parts.h"

#include <string.h>

/* ---- shapes ---- */

typedef struct geometry {
    const char *name;
    mbsr_shape_kind kind;
    struct {
        const char *child;
        int first, count;
        double missing, factor;
    } size[2];
} geometry;

static const geometry geometries[] = {
    {"box", MBSR_SHAPE_BOX, {{"size", 0, 3, 1.0, 0.5}}},
    {"sphere", MBSR_SHAPE_SPHERE, {{"radius", 0, 1, 1.0, 1.0}}},
    {"cylinder", MBSR_SHAPE_CYLINDER, {{"radius", 0, 1, 1.0, 1.0}, {"length", 1, 1, 1.0, 0.5}}},
    {"capsule", MBSR_SHAPE_CAPSULE, {{"radius", 0, 1, 0.5, 1.0}, {"length", 1, 1, 1.0, 0.5}}},
    {"ellipsoid", MBSR_SHAPE_ELLIPSOID, {{"radii", 0, 3, 1.0, 1.0}}},
    {"plane", MBSR_SHAPE_PLANE, {{"size", 0, 2, 1.0, 0.5}}},
    {"mesh", MBSR_SHAPE_MESH, {{"scale", 0, 3, 1.0, 1.0}}},
};

/* z along the normal of a plane. */
static bool turn_plane(mbsri_scene *s, const mbsri_element *of, mbsr_frame *frame)
{
    double normal[3] = {0.0, 0.0, 1.0};
    if (!mbsri_sdf_numbers(s, of, "normal", 3, normal)) return false;
    if (normal[0] == 0.0 && normal[1] == 0.0 && normal[2] == 0.0)
        return mbsri_file_refuse(s, of, "its normal has no direction");
    const mbsr_frame turn = mbsr_frame_along(NULL, normal);
    *frame = mbsr_frame_product(frame, &turn);
    return true;
}

/* The picture of a <heightmap>: black is zero, its brightest point as high as the size says, as in
 * Gazebo. Its first row has the largest y. */
static bool read_heights(mbsri_scene *s, const mbsri_element *of, mbsr_file_shape *shape,
                         bool *known)
{
    const char *path = mbsri_package_path(s, mbsri_text_of(of, "uri"));
    double size[3] = {1.0, 1.0, 1.0}, pos[3] = {0.0, 0.0, 0.0}, *height = NULL;
    *known = false;
    if (!path) return mbsri_file_refuse(s, of, "it has no uri");
    if (!mbsri_sdf_numbers(s, of, "size", 3, size) || !mbsri_sdf_numbers(s, of, "pos", 3, pos))
        return false;
    if (!(size[0] > 0.0 && size[1] > 0.0 && size[2] > 0.0))
        return mbsri_file_refuse(s, of, "its size must be three positive numbers");
    const char *wrong =
        mbsri_heights_load(s, s->home, path, &shape->rows, &shape->columns, &height);
    if (wrong) {
        mbsri_file_find(s, of, "it is left out with heights '%.40s': %s", path, wrong);
        return true;
    }
    *known = true;
    mbsri_heights_scale(height, shape->rows * shape->columns, 0.0, size[2]);
    const mbsr_frame shift = mbsr_frame_at(pos[0], pos[1], pos[2]);
    shape->frame = mbsr_frame_product(&shape->frame, &shift);
    shape->kind = MBSR_SHAPE_HEIGHTS;
    shape->size[0] = 0.5 * size[0], shape->size[1] = 0.5 * size[1], shape->size[2] = 0.0;
    shape->height = height;
    return mbsri_heights_drawn(s, shape);
}

/* *known false: it is not drawn, as a finding says. */
static bool read_geometry(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape,
                          bool *known)
{
    const mbsri_element *list = mbsri_child(e, "geometry"), *of = list ? list->child : NULL;
    const geometry *g = NULL;
    for (size_t k = 0; of && k < sizeof geometries / sizeof *geometries; ++k)
        if (mbsri_is(of, geometries[k].name)) g = geometries + k;
    *known = g != NULL;
    if (of && mbsri_is(of, "heightmap")) return read_heights(s, of, shape, known);
    if (of && !g && !mbsri_is(of, "empty"))
        mbsri_file_find(s, of, "a shape of this kind is not drawn");
    if (!g) return true;
    shape->kind = g->kind;
    if (g->kind == MBSR_SHAPE_MESH) {
        shape->mesh = mbsri_package_path(s, mbsri_text_of(of, "uri"));
        *known = shape->mesh != NULL;
        if (mbsri_child(of, "submesh"))
            mbsri_file_find(s, of, "all of its mesh is drawn, not its submesh alone");
    }
    for (int k = 0; k < 2 && g->size[k].child; ++k) {
        double *size = shape->size + g->size[k].first;
        for (int l = 0; l < g->size[k].count; ++l) size[l] = g->size[k].missing;
        if (!mbsri_sdf_numbers(s, of, g->size[k].child, g->size[k].count, size)) return false;
        for (int l = 0; l < g->size[k].count; ++l) size[l] *= g->size[k].factor;
    }
    return g->kind != MBSR_SHAPE_PLANE || turn_plane(s, of, &shape->frame);
}

static bool read_colour(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape)
{
    const mbsri_element *material = mbsri_child(e, "material");
    const char *const names[] = {"diffuse", "ambient"};
    double clear = 0.0;
    for (int k = 0; k < 2 && material && !shape->coloured; ++k) {
        const char *text = mbsri_text_of(material, names[k]);
        int count;
        if (!mbsri_numbers(s, material, names[k], text, 3, 4, shape->colour, &count)) return false;
        shape->coloured = count > 0;
    }
    if (!mbsri_sdf_numbers(s, e, "transparency", 1, &clear)) return false;
    shape->colour[3] *= 1.0 - clear;
    return true;
}

/* The coefficient of sliding, from <ode>. */
static bool read_friction(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape)
{
    const mbsri_element *friction = mbsri_child(mbsri_child(e, "surface"), "friction");
    if (!mbsri_sdf_numbers(s, mbsri_child(friction, "ode"), "mu", 1, shape->friction)) return false;
    if (shape->friction[0] >= 0.0) return true;
    mbsri_file_find(s, e, "its mu is negative: 1 is taken");
    shape->friction[0] = 1.0;
    return true;
}

/* Where it is in its link. */
static bool place_shape(mbsri_sdf *f, int link, const mbsr_frame *world, const mbsri_element *e,
                        mbsr_frame *frame)
{
    const mbsri_element *pose = mbsri_child(e, "pose");
    const char *base = pose ? mbsri_attribute(pose, "relative_to") : NULL;
    const int model = mbsri_sdf_nodes(f)[link].model;
    mbsr_frame of_model = mbsr_frame_identity(), from;
    if (!mbsri_sdf_read_pose(f->s, pose, frame)) return false;
    if (!base || !base[0]) return true;
    if ((model >= 0 && !mbsri_sdf_world(f, model, &of_model)) ||
        !mbsri_sdf_place(f, e, model, base, &from))
        return false;
    const mbsr_frame back = mbsr_frame_inverse(world);
    from = mbsr_frame_product(&of_model, &from);
    from = mbsr_frame_product(&back, &from);
    *frame = mbsr_frame_product(&from, frame);
    return true;
}

bool mbsri_sdf_shapes(mbsri_sdf *f, int link, const mbsr_frame *world, int body)
{
    mbsri_scene *s = f->s;
    for (const mbsri_element *e = mbsri_sdf_nodes(f)[link].element->child; e; e = e->next) {
        const bool visual = mbsri_is(e, "visual");
        const char *name = mbsri_attribute(e, "name");
        bool known;
        if (!visual && !mbsri_is(e, "collision")) continue;
        mbsr_file_shape shape = {.name = name ? name : "",
                                 .body = body,
                                 .colour = {0.7, 0.7, 0.7, 1.0},
                                 .visual = visual,
                                 .contact = !visual,
                                 .groups = 1,
                                 .mask = 1,
                                 .friction = {1.0, 0.0, 0.0},
                                 .settle = {0.02, 1.0}};
        if (!place_shape(f, link, world, e, &shape.frame) || !read_geometry(s, e, &shape, &known) ||
            !read_colour(s, e, &shape) || !read_friction(s, e, &shape) ||
            (known && !mbsri_hull_shape(s, e, &shape)))
            return false;
        mbsr_file_shape *to = known ? mbsri_list_add(s->arena, &s->shapes, sizeof *to) : NULL;
        if (to) *to = shape;
        if (known && !to) return false;
    }
    return true;
}

/* ---- inertias ---- */

/* From the solids of the collisions, of their densities or that of <inertial>. */
static bool weigh_link(mbsri_sdf *f, const mbsri_element *link, mbsr_inertia *inertia)
{
    mbsri_scene *s = f->s;
    double standard = 1000.0;
    bool some = false;
    if (!mbsri_sdf_numbers(s, mbsri_child(link, "inertial"), "density", 1, &standard)) return false;
    *inertia = mbsr_inertia_zero();
    for (const mbsri_element *e = mbsri_child(link, "collision"); e; e = mbsri_next(e)) {
        mbsr_file_shape shape = {.name = ""};
        double density = standard, volume, tensor[6];
        bool known;
        if (!mbsri_sdf_read_pose(s, mbsri_child(e, "pose"), &shape.frame) ||
            !read_geometry(s, e, &shape, &known) ||
            !mbsri_sdf_numbers(s, e, "density", 1, &density))
            return false;
        if (!known || !mbsri_shape_solid(shape.kind, shape.size, &volume, tensor)) {
            mbsri_file_find(s, e, "its mass is left out: it is no solid of a known size");
            continue;
        }
        for (int k = 0; k < 6; ++k) tensor[k] *= density;
        const mbsr_inertia own = mbsri_solid(s->arena, density * volume, &shape.frame, tensor);
        *inertia = some ? mbsr_inertia_sum(*inertia, own) : own;
        some = true;
    }
    return true;
}

bool mbsri_sdf_inertia(mbsri_sdf *f, const mbsri_element *link, mbsr_inertia *inertia)
{
    static const char *const names[6] = {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"};
    const mbsri_element *inertial = mbsri_child(link, "inertial"),
                        *tensor = mbsri_child(inertial, "inertia");
    const char *automatic = inertial ? mbsri_attribute(inertial, "auto") : NULL;
    double mass = 1.0, I[6] = {1.0, 1.0, 1.0};
    mbsr_frame frame;
    if (automatic && (*automatic == '1' || strcmp(automatic, "true") == 0))
        return weigh_link(f, link, inertia);
    if (!mbsri_sdf_read_pose(f->s, mbsri_child(inertial, "pose"), &frame)) return false;
    if (inertial && !mbsri_sdf_numbers(f->s, inertial, "mass", 1, &mass)) return false;
    for (int k = 0; k < 6 && tensor; ++k)
        if (!mbsri_sdf_numbers(f->s, tensor, names[k], 1, I + k)) return false;
    return mbsri_stated_solid(f->s, link, mass, &frame, I, inertia);
}
