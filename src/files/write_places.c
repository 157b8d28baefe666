/* Writing MJCF: shapes, sites and meshes, by the bodies on which they stand: see writer.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/thrust.h"
#include "files/writer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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

/* ---- what stands on which body ---- */

typedef enum place_kind { SHAPE, SITE, SPRING, THRUST, END } place_kind;

typedef struct place {
    place_kind kind;
    int body, number, end; /* end: of a spring or of a closure */
} place;

static void add_place(mbsri_file_writer *w, mbsri_list *places, place_kind kind, int body,
                      int number, int end)
{
    if (body < MBSR_GROUND || body >= w->bodies) return;
    place *p = mbsri_list_add(w->arena, places, sizeof *p);
    if (p) *p = (place){kind, body, number, end};
}

static void find_spring_sites(mbsri_file_writer *w, mbsri_list *places)
{
    const mbsri_written_spring *s = w->springs.items;
    for (int k = 0; k < w->springs.count; ++k) {
        for (int l = 0; l < s[k].count; ++l)
            if (!s[k].there[l]) add_place(w, places, SPRING, s[k].body[l], k, l);
    }
}

static bool thrust_of(const mbsri_file_writer *w, int actuator, mbsri_thrust *t)
{
    const int id = w->file->actuator[actuator].force;
    mbsr_force_def def;
    return id != MBSR_NONE && !mbsr_force_definition(w->model, id, &def) &&
           mbsri_thrust_of(&def, t);
}

/* Where actuators push that act on sites. */
static void find_thrusts(mbsri_file_writer *w, mbsri_list *places)
{
    mbsri_thrust t;
    for (int k = 0; w->file && k < w->file->actuators; ++k)
        if (thrust_of(w, k, &t)) add_place(w, places, THRUST, t.body, k, 0);
}

/* Ends of pins that are open as drawn. */
static void find_open_ends(mbsri_file_writer *w, mbsri_list *places)
{
    for (int id = 0; id < mbsr_model_closures(w->model); ++id) {
        mbsr_closure_def def;
        if (mbsr_closure_definition(w->model, id, &def) || !mbsri_written_is_open(w, &def))
            continue;
        for (int k = 0; k < 2; ++k) add_place(w, places, END, def.body[k], id, k);
    }
}

/* Those of body k stand from place_at[k + 1] on, in the order in which they were found. */
bool mbsri_write_find_places(mbsri_file_writer *w)
{
    mbsri_list places = {.count = 0};
    for (int k = 0; w->file && k < w->file->shapes; ++k)
        add_place(w, &places, SHAPE, w->file->shape[k].body, k, 0);
    for (int k = 0; w->file && k < w->file->sites; ++k)
        add_place(w, &places, SITE, w->file->site[k].body, k, 0);
    find_spring_sites(w, &places);
    find_thrusts(w, &places);
    find_open_ends(w, &places);
    const place *found = places.items;
    place *ordered = mbsri_arena_take(w->arena, ((size_t)places.count + 1) * sizeof *ordered);
    int *at = mbsri_arena_take(w->arena, ((size_t)w->bodies + 3) * sizeof *at);
    if (!ordered || !at || w->arena->failed) return false;
    for (int k = 0; k < places.count; ++k) ++at[found[k].body + 3];
    for (int k = 0; k < w->bodies; ++k) at[k + 3] += at[k + 2];
    for (int k = 0; k < places.count; ++k) ordered[at[found[k].body + 2]++] = found[k];
    w->place = ordered;
    w->place_at = at;
    return true;
}

/* ---- writing them ---- */

static void write_spring_site(mbsri_file_writer *w, const place *p)
{
    const mbsri_written_spring *s = (const mbsri_written_spring *)w->springs.items + p->number;
    const double *x = s->point[p->end];
    const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
    write_site(w, s->site[p->end], &frame);
}

static void write_thrust(mbsri_file_writer *w, const place *p)
{
    mbsri_thrust t;
    bool there;
    if (!thrust_of(w, p->number, &t)) return;
    const char *base = mbsri_write_print(w, "thrust_%d", w->file->actuator[p->number].force),
               *name = mbsri_write_site_name(w, p->body, &t.frame, base, &there);
    if (!there) write_site(w, name, &t.frame);
}

static void write_end(mbsri_file_writer *w, const place *p)
{
    mbsr_closure_def def;
    bool there;
    if (mbsr_closure_definition(w->model, p->number, &def)) return;
    const double *x = def.param + 12 * p->end;
    const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
    const char *name = mbsri_write_end_name(w, &def, p->number, p->end, &there);
    if (!there) write_site(w, name, &frame);
}

void mbsri_write_places(mbsri_file_writer *w, int body)
{
    const place *all = w->place;
    for (int at = w->place_at[body + 1]; at < w->place_at[body + 2]; ++at) {
        const place *p = all + at;
        switch (p->kind) {
        case SHAPE: write_shape(w, w->file->shape + p->number, p->number); break;
        case SITE:
            write_site(w, w->file->site[p->number].name, &w->file->site[p->number].frame);
            break;
        case SPRING: write_spring_site(w, p); break;
        case THRUST: write_thrust(w, p); break;
        case END: write_end(w, p); break;
        }
    }
}

/* ---- meshes and fields of heights ---- */

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

void mbsri_write_assets(mbsri_file_writer *w)
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
