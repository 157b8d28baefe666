/* Bodies as elements of MJCF, each within its predecessor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/solids.h"
#include "files/thrust.h"
#include "files/writer.h"
#include "files/xml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool differs(const mbsr_frame *frame)
{
    const mbsr_frame unit = mbsr_frame_identity();
    double most = 0.0;
    for (int k = 0; k < 9; ++k) most = fmax(most, fabs(frame->R[k] - unit.R[k]));
    return most > 1e-15;
}

/* ---- inertias ---- */

/* What MuJoCo refuses, or changes. */
static void find_weight(mbsri_file_writer *w, int k, const char *element, double mass,
                        const double tensor[6])
{
    double moments[3];
    mbsri_moments(tensor, moments);
    if (w->def[k].joint.n > 0 && !(mass > 0.0))
        mbsri_write_find(w, element, "it has no mass: MuJoCo refuses the file");
    else if (w->def[k].joint.n > 0 && !(moments[0] > 0.0))
        mbsri_write_find(w, element,
                         "it has no moment of inertia about some axis: MuJoCo refuses the file");
    else if (moments[2] > (1.0 + 1e-6) * (moments[0] + moments[1]))
        mbsri_write_find(w, element,
                         "one moment of inertia is above the sum of the others: MuJoCo refuses the "
                         "file");
}

static void write_inertia(mbsri_file_writer *w, int k, const char *element)
{
    double mass, centre[3], I[6];
    const mbsr_inertia *inertia = &w->def[k].inertia;
    if (!mbsri_solid_of(inertia, &mass, centre, I)) {
        mbsri_write_find(w, element, "its inertia is no rigid body's: it is left out");
        return;
    }
    find_weight(w, k, element, mass, I);
    if (inertia->kind == MBSR_INERTIA_NOT_GIVEN) return;
    const bool diagonal = !(fabs(I[3]) > 0.0) && !(fabs(I[4]) > 0.0) && !(fabs(I[5]) > 0.0);
    mbsri_begin(&w->text, "inertial");
    mbsri_set_numbers(&w->text, "pos", 3, centre);
    mbsri_set_number(&w->text, "mass", mass);
    mbsri_set_numbers(&w->text, diagonal ? "diaginertia" : "fullinertia", diagonal ? 3 : 6, I);
    mbsri_end(&w->text);
}

/* ---- joints ---- */

static void find_joint(mbsri_file_writer *w, const mbsri_written_joint *j, const char *what)
{
    char element[120];
    snprintf(element, sizeof element, "joint '%.80s'", j->name);
    mbsri_write_find(w, element, "%s", what);
}

static void set_passive(mbsri_file_writer *w, const mbsri_written_joint *j)
{
    mbsri_text *t = &w->text;
    const double armature = mbsr_body_armature(w->model, j->body)[j->coordinate],
                 rest = fabs(j->stiffness) > 0.0 ? j->moment / j->stiffness : 0.0;
    if (fabs(j->stiffness) > 0.0) mbsri_set_number(t, "stiffness", j->stiffness);
    if (fabs(rest) > 0.0) mbsri_set_number(t, "springref", rest);
    if (fabs(j->damping) > 0.0) mbsri_set_number(t, "damping", j->damping);
    if (armature > 0.0) mbsri_set_number(t, "armature", armature);
    if (!j->of) return;
    if (j->of->friction > 0.0) mbsri_set_number(t, "frictionloss", j->of->friction);
    if (j->of->limited) {
        mbsri_set_text(t, "limited", "true");
        mbsri_set_numbers(t, "range", 2, j->of->range);
    }
}

static void write_joint(mbsri_file_writer *w, const mbsri_written_joint *j)
{
    static const char *const types[] = {"", "hinge", "slide", "ball", "free"};
    mbsri_text *t = &w->text;
    mbsri_begin(t, "joint");
    mbsri_set_text(t, "name", j->name);
    mbsri_set_text(t, "type", types[j->kind]);
    if (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_SLIDE)
        mbsri_set_numbers(t, "axis", 3, j->axis);
    if (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_BALL)
        mbsri_set_numbers(t, "pos", 3, j->anchor);
    if (j->of && fabs(j->of->ref) > 0.0) mbsri_set_number(t, "ref", j->of->ref);
    set_passive(w, j);
    mbsri_end(t);
}

static void write_own_joints(mbsri_file_writer *w, int k)
{
    const mbsr_joint_chain *c = w->chain + k;
    const mbsri_written_joint *j = w->joint + w->joint_at[k];
    const bool is_free = c->quaternion && c->axes > 0;
    const double *B = c->B.x;
    if (is_free && (differs(&c->A) || differs(&c->B) || fabs(c->A.x[0]) + fabs(c->A.x[1]) > 0.0 ||
                    fabs(c->A.x[2]) + fabs(B[0]) + fabs(B[1]) + fabs(B[2]) > 0.0))
        find_joint(w, j, "its coordinates are those of the body in the world");
    if (c->quaternion && !is_free && differs(&c->B))
        find_joint(w, j, "its quaternion is told along the body's axes");
    if (c->quaternion || c->axes > 0) {
        if (w->joint_at[k] < w->reached)
            find_joint(w, j, "its coordinates come later in the text than in the model");
        w->reached = w->joint_at[k] + 1;
    }
    for (int l = 0; l < (c->quaternion ? 1 : c->axes); ++l) write_joint(w, j + l);
}

/* Those of bodies in between first, outermost before. */
static void write_joints(mbsri_file_writer *w, int k)
{
    int chain[MBSRI_XML_DEPTH], count = 0;
    for (int at = k; at != MBSR_NONE && count < MBSRI_XML_DEPTH; at = w->before[at])
        chain[count++] = at;
    while (count > 0) write_own_joints(w, chain[--count]);
}

/* ---- what stands on a body ---- */

/* A name where it stands for the first time; then none. */
static const char *only_name(mbsri_file_writer *w, mbsri_names *names, const char *name)
{
    if (!*name || mbsri_names_find(names, name) >= 0) return NULL;
    mbsri_names_add(w->arena, names, name, 0);
    return name;
}

/* What a mesh is to MuJoCo: STL, OBJ or MSH; and the caller may have none of that name. */
static bool keeps_mesh(const mbsri_file_writer *w, const mbsr_file_shape *s)
{
    const char *path = s->mesh;
    static const char *const endings[] = {".stl", ".STL", ".obj", ".OBJ", ".msh", ".MSH"};
    const char *point = path ? strrchr(path, '.') : NULL;
    bool known = false;
    if (s->triangles > 0) return true;
    for (int k = 0; point && k < 6; ++k) known = known || strcmp(point, endings[k]) == 0;
    return known && !strstr(path, "://") &&
           (!w->opt->has_mesh || w->opt->has_mesh(w->opt->user, path));
}

/* Whether it can be written: a finding, where it cannot. */
static bool has_size(mbsri_file_writer *w, const mbsr_file_shape *s, int sizes)
{
    char element[120];
    bool good = s->kind != MBSR_SHAPE_MESH || keeps_mesh(w, s);
    for (int k = 0; k < sizes && s->kind != MBSR_SHAPE_PLANE; ++k) good = good && s->size[k] > 0.0;
    snprintf(element, sizeof element, "geom '%.80s'", s->name);
    if (!good && s->kind == MBSR_SHAPE_MESH)
        mbsri_write_find(w, element, "it is left out: MuJoCo cannot read mesh '%.60s'",
                         s->mesh ? s->mesh : "");
    else if (!good)
        mbsri_write_find(w, element, "it is left out: a size of it is zero");
    return good;
}

/* The lowest height of a field, and how much higher its highest is. */
typedef struct span {
    double low, size;
} span;

static span span_of(const mbsr_file_shape *s)
{
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < s->rows * s->columns; ++k) {
        low = fmin(low, s->height[k]);
        high = fmax(high, s->height[k]);
    }
    return (span){low, high - low};
}

static void write_shape(mbsri_file_writer *w, const mbsr_file_shape *s, int number)
{
    static const char *const types[] = {"box",       "sphere", "cylinder", "capsule",
                                        "ellipsoid", "plane",  "mesh",     "hfield"};
    static const int sizes[] = {3, 1, 2, 2, 3, 3, 0, 0};
    mbsri_text *t = &w->text;
    if (!has_size(w, s, sizes[s->kind])) return;
    mbsri_begin(t, "geom");
    mbsri_set_text(t, "name", only_name(w, &w->shapes, s->name));
    mbsri_set_text(t, "type", types[s->kind]);
    if (s->kind == MBSR_SHAPE_MESH)
        mbsri_set_text(t, "mesh", mbsri_write_print(w, "mesh_%d", number));
    else if (s->kind == MBSR_SHAPE_HEIGHTS)
        mbsri_set_text(t, "hfield", mbsri_write_print(w, "hfield_%d", number));
    else
        mbsri_set_numbers(t, "size", sizes[s->kind], s->size);
    mbsr_frame frame =
        mbsr_frame_at(0.0, 0.0, s->kind == MBSR_SHAPE_HEIGHTS ? span_of(s).low : 0.0);
    frame = mbsr_frame_product(&s->frame, &frame);
    mbsri_write_frame(w, &frame);
    if (s->coloured) mbsri_set_numbers(t, "rgba", 4, s->colour);
    if (!s->visual) mbsri_set_text(t, "group", "3");
    mbsri_set_contact(w, s);
    mbsri_end(t);
}

static void write_site(mbsri_file_writer *w, const char *name, const mbsr_frame *frame)
{
    mbsri_begin(&w->text, "site");
    mbsri_set_text(&w->text, "name", only_name(w, &w->sites, name));
    mbsri_write_frame(w, frame);
    mbsri_end(&w->text);
}

/* Where actuators push that act on sites. */
static void write_thrusts(mbsri_file_writer *w, int body)
{
    for (int k = 0; w->file && k < w->file->actuators; ++k) {
        const int id = w->file->actuator[k].force;
        mbsr_force_def def;
        mbsri_thrust t;
        if (id == MBSR_NONE || mbsr_force_definition(w->model, id, &def) ||
            !mbsri_thrust_of(&def, &t) || t.body != body)
            continue;
        bool there;
        const char *base = mbsri_write_print(w, "thrust_%d", id),
                   *name = mbsri_write_site_name(w, body, &t.frame, base, &there);
        if (!there) write_site(w, name, &t.frame);
    }
}

/* Ends of pins that are open as drawn. */
static void write_ends(mbsri_file_writer *w, int body)
{
    for (int id = 0; id < mbsr_model_closures(w->model); ++id) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(w->model, id, &def) || !mbsri_written_is_open(w, &def))
            continue;
        for (int k = 0; k < 2; ++k) {
            const double *x = def.param + 12 * k;
            if (def.body[k] != body) continue;
            const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
            bool there;
            const char *name = mbsri_write_end_name(w, &def, id, k, &there);
            if (!there) write_site(w, name, &frame);
        }
    }
}

static void write_shapes_and_sites(mbsri_file_writer *w, int body)
{
    const mbsri_written_spring *spring = w->springs.items;
    for (int k = 0; w->file && k < w->file->shapes; ++k)
        if (w->file->shape[k].body == body) write_shape(w, w->file->shape + k, k);
    for (int k = 0; w->file && k < w->file->sites; ++k)
        if (w->file->site[k].body == body)
            write_site(w, w->file->site[k].name, &w->file->site[k].frame);
    for (int k = 0; k < w->springs.count; ++k) {
        for (int l = 0; l < spring[k].count; ++l) {
            const double *x = spring[k].point[l];
            const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
            if (spring[k].body[l] == body && !spring[k].there[l])
                write_site(w, spring[k].site[l], &frame);
        }
    }
    write_thrusts(w, body);
    write_ends(w, body);
}

/* Corners, three for each triangle. */
static void set_triangles(mbsri_file_writer *w, const mbsr_file_shape *s)
{
    const size_t count = 3 * (size_t)s->triangles;
    double *number = mbsri_arena_take(w->arena, count * sizeof *number);
    for (size_t k = 0; k < count && number; ++k) number[k] = (double)k;
    if (!number) return;
    mbsri_set_numbers(&w->text, "vertex", (int)(3 * count), s->triangle);
    mbsri_set_numbers(&w->text, "face", (int)count, number);
}

static void write_mesh(mbsri_file_writer *w, int k)
{
    const mbsr_file_shape *s = w->file->shape + k;
    mbsri_begin(&w->text, "mesh");
    mbsri_set_text(&w->text, "name", mbsri_write_print(w, "mesh_%d", k));
    if (s->triangles > 0)
        set_triangles(w, s);
    else
        mbsri_set_text(&w->text, "file", s->mesh);
    mbsri_set_numbers(&w->text, "scale", 3, s->size);
    mbsri_end(&w->text);
}

/* The first row of the text has the largest y; MuJoCo scales heights to its size. */
static void write_field(mbsri_file_writer *w, int k)
{
    const mbsr_file_shape *s = w->file->shape + k;
    const span heights = span_of(s);
    const double top = heights.size > 0.0 ? heights.size : 1.0,
                 size[4] = {s->size[0], s->size[1], top, 0.1 * top};
    double *number =
        mbsri_arena_take(w->arena, (size_t)s->rows * (size_t)s->columns * sizeof *number);
    if (!number) return;
    for (int j = 0; j < s->rows; ++j) {
        for (int i = 0; i < s->columns; ++i)
            number[j * s->columns + i] =
                s->height[(s->rows - 1 - j) * s->columns + i] - heights.low;
    }
    mbsri_begin(&w->text, "hfield");
    mbsri_set_text(&w->text, "name", mbsri_write_print(w, "hfield_%d", k));
    mbsri_set_numbers(&w->text, "size", 4, size);
    mbsri_set_number(&w->text, "nrow", s->rows);
    mbsri_set_number(&w->text, "ncol", s->columns);
    mbsri_set_numbers(&w->text, "elevation", s->rows * s->columns, number);
    mbsri_end(&w->text);
}

static void write_assets(mbsri_file_writer *w)
{
    bool some = false;
    for (int k = 0; w->file && k < w->file->shapes; ++k) {
        const mbsr_file_shape *s = w->file->shape + k;
        const bool mesh = s->kind == MBSR_SHAPE_MESH && keeps_mesh(w, s);
        if (!mesh && s->kind != MBSR_SHAPE_HEIGHTS) continue;
        if (!some) mbsri_begin(&w->text, "asset"), mbsri_into(&w->text);
        some = true;
        if (mesh)
            write_mesh(w, k);
        else
            write_field(w, k);
    }
    if (some) mbsri_out(&w->text, "asset");
}

/* ---- bodies ---- */

/* The part of its weight that is carried, where it is one. */
static void write_lift(mbsri_file_writer *w, int k, const char *element)
{
    double mass, centre[3], tensor[6], along = 0.0, weight = 0.0, off = 0.0, size = 0.0;
    const double *F = w->lift + 3 * k, *g = w->gravity;
    (void)mbsri_solid_of(&w->def[k].inertia, &mass, centre, tensor);
    for (int l = 0; l < 3; ++l) {
        along -= F[l] * g[l] * mass;
        weight += mass * mass * g[l] * g[l];
        size += fabs(F[l]);
    }
    if (!(size > 0.0)) return;
    const double part = weight > 0.0 ? along / weight : 0.0;
    for (int l = 0; l < 3; ++l) off += fabs(F[l] + part * mass * g[l]);
    if (off <= 1e-12 * size)
        mbsri_set_number(&w->text, "gravcomp", part);
    else
        mbsri_write_find(w, element, "a force on it is left out: it is not against its weight");
}

static void begin_body(mbsri_file_writer *w, int k)
{
    char element[120];
    snprintf(element, sizeof element, "body '%.80s'", w->body[k]);
    mbsri_begin(&w->text, "body");
    mbsri_set_text(&w->text, "name", w->body[k]);
    mbsri_write_frame(w, w->frame + k);
    write_lift(w, k, element);
    mbsri_into(&w->text);
    if (mbsr_body_regularisation(w->model, k))
        mbsri_write_find(w, element, "what was added to its mass matrix is left out");
    write_inertia(w, k, element);
    write_joints(w, k);
    write_shapes_and_sites(w, k);
}

/* First child and next sibling of each body, in ascending order; [0] and on: of the world, then of
 * body 0. */
static bool link_children(mbsri_file_writer *w, int **first, int **next)
{
    const size_t size = ((size_t)w->bodies + 1) * sizeof **first;
    *first = mbsri_arena_take(w->arena, size);
    *next = mbsri_arena_take(w->arena, size);
    if (!*first || !*next) return false;
    for (int k = 0; k <= w->bodies; ++k) (*first)[k] = -1;
    for (int k = w->bodies - 1; k >= 0; --k) {
        const int on = w->def[k].parent + 1;
        if (w->joined[k]) continue;
        (*next)[k] = (*first)[on];
        (*first)[on] = k;
    }
    return true;
}

void mbsri_write_bodies(mbsri_file_writer *w)
{
    int *first, *next;
    if (!link_children(w, &first, &next)) return;
    write_assets(w);
    mbsri_begin(&w->text, "worldbody");
    mbsri_into(&w->text);
    write_shapes_and_sites(w, MBSR_GROUND);
    for (int k = first[0]; k >= 0;) {
        begin_body(w, k);
        int on = first[k + 1];
        while (on < 0 && k >= 0) {
            mbsri_out(&w->text, "body");
            on = next[k];
            k = w->def[k].parent;
        }
        k = on;
    }
    mbsri_out(&w->text, "worldbody");
}
