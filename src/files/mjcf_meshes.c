/* Meshes of MJCF: where their files are, what they enclose, shapes that are fitted to them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A mesh is read when its mass or its size is needed, once, and not kept. Fitted shapes have the
 * inertia box of the mesh, half edges sqrt(3/2 (I_b + I_c - I_a) / V), or the box around it, along
 * its principal axes, of which the first has the largest moment. */
#include "files/mjcf_parts.h"
#include "files/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *mbsri_mjcf_asset_path(const mbsri_mjcf *m, const mbsri_element *e)
{
    const char *file = mbsri_attribute(e, "file");
    const mbsri_compiler *c = mbsri_mjcf_compiler(m, e);
    const char *last = file && c->strip ? strrchr(file, '/') : NULL, *folder = c->folder;
    if (last) file = last + 1;
    if (!file || file[0] == '/') return file;
    if (folder && folder[0]) file = mbsri_arena_join(m->s->arena, folder, "/", file);
    if (!file || file[0] == '/' || !c->home[0]) return file;
    return mbsri_arena_join(m->s->arena, c->home, file, "");
}

const char *mbsri_mjcf_stem(mbsri_arena *arena, const char *file)
{
    const char *slash = strrchr(file, '/');
    if (slash) file = slash + 1;
    const char *point = strrchr(file, '.');
    return mbsri_arena_text(arena, file, point ? (size_t)(point - file) : strlen(file));
}

/* Its own, or that of its file. */
static const char *mesh_name(mbsri_mjcf *m, const mbsri_element *e)
{
    const char *name = mbsri_attribute(e, "name"), *file = mbsri_attribute(e, "file");
    return name || !file ? name : mbsri_mjcf_stem(m->s->arena, file);
}

static bool read_inertia(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsri_mjcf_mesh *mesh)
{
    const char *kind = mbsri_mjcf_get(node, "inertia");
    mesh->kind =
        !kind && mbsri_mjcf_compiler(m, node->e)->exact ? MBSRI_MESH_EXACT : MBSRI_MESH_LEGACY;
    if (!kind || strcmp(kind, "legacy") == 0) return true;
    mesh->kind = strcmp(kind, "shell") == 0 ? MBSRI_MESH_SHELL : MBSRI_MESH_EXACT;
    mesh->hull = strcmp(kind, "convex") == 0;
    return mesh->kind == MBSRI_MESH_SHELL || mesh->hull || strcmp(kind, "exact") == 0 ||
           mbsri_file_refuse(m->s, node->e, "there is no inertia '%.40s'", kind);
}

bool mbsri_mjcf_add_mesh(mbsri_mjcf *m, const mbsri_element *e)
{
    mbsri_mjcf_mesh mesh = {.element = e, .place.scale = {1.0, 1.0, 1.0}};
    double origin[3] = {0.0}, turn[4] = {1.0};
    mbsri_mjcf_part node;
    if (!mbsri_mjcf_node(m, e, "mesh", NULL, &node) || !read_inertia(m, &node, &mesh) ||
        !mbsri_mjcf_numbers(m, &node, "scale", 3, 3, mesh.place.scale, NULL) ||
        !mbsri_mjcf_numbers(m, &node, "refpos", 3, 3, origin, NULL) ||
        !mbsri_mjcf_numbers(m, &node, "refquat", 4, 4, turn, NULL))
        return false;
    if (!(turn[0] != 0.0 || turn[1] != 0.0 || turn[2] != 0.0 || turn[3] != 0.0))
        return mbsri_file_refuse(m->s, e, "refquat has no direction");
    mesh.place.reference = mbsr_frame_quaternion(origin, turn);
    mesh.file = mbsri_mjcf_asset_path(m, e);
    const char *name = mesh_name(m, e);
    mbsri_mjcf_mesh *to = mbsri_list_add(m->s->arena, &m->meshes, sizeof *to);
    if (!to) return false;
    *to = mesh;
    return !name || mbsri_names_find(&m->mesh_names, name) >= 0 ||
           mbsri_names_add(m->s->arena, &m->mesh_names, name, m->meshes.count - 1);
}

mbsri_mjcf_mesh *mbsri_mjcf_find_mesh(const mbsri_mjcf *m, const char *name)
{
    const int at = mbsri_names_find(&m->mesh_names, name);
    return at < 0 ? NULL : (mbsri_mjcf_mesh *)m->meshes.items + at;
}

/* ---- what they enclose ---- */

static const char *load_mesh(mbsri_mjcf *m, mbsri_mjcf_mesh *mesh, mbsri_arena *arena,
                             mbsri_list *triangles)
{
    const char *points = mbsri_attribute(mesh->element, "vertex"),
               *faces = mbsri_attribute(mesh->element, "face"), *text;
    size_t size;
    if (points) return mbsri_mesh_of_numbers(arena, points, faces, triangles);
    if (!mesh->file)
        return mbsri_attribute(mesh->element, "builtin") ? "meshes that MuJoCo builds are not made"
                                                         : "it is not a file";
    const char *path = mbsri_arena_join(arena, mesh->file[0] == '/' ? "" : m->home, mesh->file, "");
    if (!path) return "there is no memory for it";
    mesh->reason = m->s->opt->load ? m->s->opt->load(m->s->opt->user, path, &text, &size) : 1;
    return mesh->reason ? "there is no such file"
                        : mbsri_mesh_read(arena, text, size, path, triangles);
}

/* In the place of triangles those of their convex hull. */
static const char *take_hull(mbsri_arena *arena, mbsri_list *triangles)
{
    mbsri_list hull = {.count = 0};
    const mbsri_triangle *t = triangles->items;
    if (triangles->count == 0) return "it has no triangles";
    const char *wrong = mbsri_mesh_hull(arena, t->corner[0], 3 * triangles->count, &hull);
    *triangles = hull;
    return wrong;
}

/* The box of a mesh: the inertia box, and the one around it. */
static void find_boxes(mbsri_mjcf *m, const mbsri_list *triangles, mbsri_mjcf_mesh *mesh)
{
    double moments[3];
    mbsr_frame *frame = &mesh->principal;
    const double dropped =
        mbsri_principal(mesh->solid.tensor, MBSRI_NO_PRODUCT_OF_MESHES, moments, frame->R);
    mbsri_find_products(m->s, mesh->element, dropped);
    memcpy(frame->x, mesh->solid.centre, sizeof frame->x);
    for (int k = 0; k < 3; ++k) {
        const double others = moments[(k + 1) % 3] + moments[(k + 2) % 3];
        mesh->box[k] = sqrt(fmax(0.0, 1.5 * (others - moments[k]) / mesh->solid.volume));
    }
    mbsri_mesh_bounds(triangles, frame, mesh->lower, mesh->upper);
}

const char *mbsri_mjcf_measure(mbsri_mjcf *m, mbsri_mjcf_mesh *mesh)
{
    mbsri_arena arena;
    mbsri_list triangles = {.count = 0};
    if (mesh->measured) return mesh->wrong;
    mbsri_arena_open(&arena, &m->s->opt->model.allocator);
    mesh->measured = true;
    mesh->wrong = load_mesh(m, mesh, &arena, &triangles);
    if (!mesh->wrong && mesh->hull) mesh->wrong = take_hull(&arena, &triangles);
    if (!mesh->wrong) {
        mbsri_mesh_move(&triangles, &mesh->place);
        mesh->wrong = mbsri_mesh_measure(&triangles, mesh->kind, &mesh->solid);
    }
    if (!mesh->wrong) find_boxes(m, &triangles, mesh);
    if (arena.failed) m->s->arena->failed = true;
    mbsri_arena_close(&arena);
    return mesh->wrong;
}

/* ---- shapes ---- */

/* Triangles of a mesh that has no file, in their place, for what draws it. */
static void keep_triangles(mbsri_mjcf *m, const mbsri_element *e, mbsri_mjcf_mesh *mesh)
{
    mbsri_list triangles = {.count = 0};
    if (mesh->triangle) return;
    const char *wrong = load_mesh(m, mesh, m->s->arena, &triangles);
    if (wrong)
        mbsri_file_find(m->s, e, "it is not drawn: %s", wrong);
    else
        mbsri_mesh_move(&triangles, &mesh->place);
    double *corner =
        mbsri_arena_take(m->s->arena, (9 * (size_t)triangles.count + 1) * sizeof *corner);
    for (int k = 0; k < triangles.count && corner; ++k)
        memcpy(corner + 9 * k, ((const mbsri_triangle *)triangles.items)[k].corner,
               9 * sizeof *corner);
    mesh->triangle = corner;
    mesh->triangles = wrong || !corner ? 0 : triangles.count;
}

/* Where the points of the file go when they have been scaled: for what draws them. */
static void place_mesh(mbsri_mjcf *m, const mbsri_element *e, mbsri_mjcf_mesh *mesh,
                       mbsr_file_shape *shape)
{
    const double *scale = mesh->place.scale;
    shape->mesh = mesh->file;
    if (!mesh->file) {
        keep_triangles(m, e, mesh);
        shape->triangles = mesh->triangles;
        shape->triangle = mesh->triangle;
        return;
    }
    mbsr_frame back = mbsr_frame_inverse(&mesh->place.reference);
    double turned = 0.0;
    for (int k = 0; k < 9; ++k) turned = fmax(turned, fabs(back.R[k] - (k % 4 == 0 ? 1.0 : 0.0)));
    if (turned > 0.0 && (scale[0] != scale[1] || scale[1] != scale[2]))
        mbsri_file_find(m->s, e, "it is drawn without the refquat of its mesh");
    for (int k = 0; k < 3; ++k) back.x[k] *= scale[k];
    memcpy(shape->size, scale, sizeof shape->size);
    shape->frame = mbsr_frame_product(&shape->frame, &back);
}

/* Sizes of a shape as the box with these half edges has them; round ones about the last axis. */
static void size_of_box(mbsr_shape_kind kind, const double box[3], bool around, double size[3])
{
    const double wide = around ? fmax(box[0], box[1]) : 0.5 * (box[0] + box[1]);
    memcpy(size, box, 3 * sizeof *size);
    if (kind == MBSR_SHAPE_SPHERE)
        size[0] = around ? fmax(wide, box[2]) : (box[0] + box[1] + box[2]) / 3.0;
    if (kind != MBSR_SHAPE_CAPSULE && kind != MBSR_SHAPE_CYLINDER) return;
    size[0] = wide;
    size[1] = box[2];
    if (kind == MBSR_SHAPE_CAPSULE)
        size[1] = around ? box[2] - wide : fmax(0.0, box[2] - 0.5 * wide);
}

static void fit_shape(const mbsri_mjcf_mesh *mesh, bool around, double factor,
                      mbsr_file_shape *shape)
{
    double half[3];
    mbsr_frame frame = mesh->principal;
    for (int k = 0; k < 3; ++k) {
        half[k] = around ? 0.5 * (mesh->upper[k] - mesh->lower[k]) : mesh->box[k];
        const double middle = around ? 0.5 * (mesh->upper[k] + mesh->lower[k]) : 0.0;
        for (int l = 0; l < 3; ++l) frame.x[l] += mesh->principal.R[3 * k + l] * middle;
    }
    size_of_box(shape->kind, half, around, shape->size);
    for (int k = 0; k < 3; ++k) shape->size[k] *= factor;
    shape->frame = mbsr_frame_product(&shape->frame, &frame);
}

bool mbsri_mjcf_mesh_shape(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape,
                           bool *known)
{
    const char *name = mbsri_mjcf_get(node, "mesh");
    mbsri_mjcf_mesh *mesh = mbsri_mjcf_find_mesh(m, name);
    double factor = 1.0;
    *known = true;
    if (shape->kind == MBSR_SHAPE_MESH) {
        for (int k = 0; k < 3; ++k) shape->size[k] = 1.0;
        if (mesh) place_mesh(m, node->e, mesh, shape);
        return true;
    }
    if (!mbsri_mjcf_number(m, node, "fitscale", &factor)) return false;
    const char *wrong = mesh ? mbsri_mjcf_measure(m, mesh) : "there is no such mesh";
    *known = wrong == NULL;
    if (*known)
        fit_shape(mesh, mbsri_mjcf_compiler(m, node->e)->fit_around, factor, shape);
    else
        mbsri_file_find(m->s, node->e, "it is left out, fitted to mesh '%.40s': %s%s%s", name,
                        wrong, mesh && mesh->reason > 1 ? ": " : "",
                        mbsri_file_why(mesh ? mesh->reason : 0));
    return true;
}
