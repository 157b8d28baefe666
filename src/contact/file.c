/* Shapes of files.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/core.h"
#include "contact/error.h"
#include "contact/touch.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/files.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a model: what its bodies hang on. */
typedef struct tree {
    int bodies;
    int *parent; /* by id; MBSR_GROUND */
    bool *welded, *shaped;
    double mass, *joined; /* of all that moves; by the root of a tree, of that tree */
    mbsr_frame *frame;    /* of bodies that are welded to the ground, in it */
} tree;

/* The first of the bodies that are welded to each other. */
static int weld_of(const tree *t, int body)
{
    while (body != MBSR_GROUND && t->welded[body]) body = t->parent[body];
    return body;
}

/* The first part of its tree that moves; MBSR_GROUND of what does not. */
static int root_of(const tree *t, int body)
{
    int root = MBSR_GROUND;
    for (int part = weld_of(t, body); part != MBSR_GROUND; part = weld_of(t, t->parent[part]))
        root = part;
    return root;
}

/* Where bodies are that are welded to the ground; wherever the others are. */
static int find_frames(const mbsr_model *m, tree *t)
{
    mbsr_data *d = NULL;
    double *q = calloc((size_t)mbsr_model_nq(m) + 1, sizeof *q);
    int status = q ? mbsr_data_create(m, &d, NULL) : MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < t->bodies && !status; ++k) {
        int at, nq, n;
        mbsr_body_coordinates(m, k, &at, &nq, NULL, &n);
        if (nq > n) q[at] = 1.0; /* a quaternion */
    }
    if (!status) status = mbsr_stage_positions(m, d, 0.0, q);
    for (int k = 0; k < t->bodies && !status; ++k) {
        double pose[MBSR_POSE_SIZE + MBSR_MAX_D];
        if (weld_of(t, k) != MBSR_GROUND || mbsr_body_dimension(m, k) != 6) continue;
        status = mbsr_body_pose(m, d, k, pose);
        memcpy(t->frame[k].R, pose + MBSR_POSE_R, sizeof t->frame[k].R);
        memcpy(t->frame[k].x, pose + MBSR_POSE_X, sizeof t->frame[k].x);
    }
    mbsr_data_destroy(d);
    free(q);
    return status;
}

static int find_tree(const mbsr_model *m, const mbsr_file *file, tree *t)
{
    for (int k = 0; k < t->bodies; ++k) {
        mbsr_body_def def;
        const int status = mbsr_body_definition(m, k, &def);
        if (status) return status;
        const mbsr_inertia_kind kind = def.inertia.kind;
        t->parent[k] = def.parent;
        t->welded[k] = def.joint.n == 0;
        const int root = root_of(t, k);
        if (kind != MBSR_INERTIA_SPATIAL && kind != MBSR_INERTIA_PARTICLE) continue;
        if (root == MBSR_GROUND) continue;
        t->mass += def.inertia.mass;
        t->joined[root] += def.inertia.mass;
    }
    for (int k = 0; k < file->shapes; ++k) {
        const mbsr_file_shape *s = file->shape + k;
        if (s->contact && s->body >= 0 && s->body < t->bodies) t->shaped[s->body] = true;
    }
    return MBSR_OK;
}

/* The one that carries it, bodies without shapes left aside. */
static int carrier_of(const tree *t, int body)
{
    if (body == MBSR_GROUND) return MBSR_NONE;
    int above = weld_of(t, t->parent[body]);
    while (above != MBSR_GROUND && !t->shaped[above]) above = weld_of(t, t->parent[above]);
    return above;
}

/* Planes and height fields, which are the ground's, of a body that is welded to it. */
static bool is_welded_ground(const tree *t, const mbsr_file_shape *s)
{
    return mbsri_is_ground(s->kind) && s->contact && s->body >= 0 && s->body < t->bodies &&
           weld_of(t, s->body) == MBSR_GROUND;
}

static bool has_welded_ground(const tree *t, const mbsr_file *file)
{
    for (int k = 0; k < file->shapes; ++k)
        if (is_welded_ground(t, file->shape + k)) return true;
    return false;
}

/* Bodies of one part, or of two of which one carries the other, never touch. */
static int exclude_joined(mbsr_contacts *c, const tree *t, const mbsr_file *file, mbsr_error *error)
{
    int(*joined)[2] = malloc(((size_t)t->bodies + 1) * sizeof *joined);
    if (!joined)
        return mbsri_contact_fail(error, MBSR_ERR_NO_MEMORY, "mbsr_contacts_add_file: no memory");
    for (int k = 0; k < t->bodies; ++k) {
        const int part = weld_of(t, k), carrier = carrier_of(t, part);
        joined[k][0] = part;
        joined[k][1] = carrier == MBSR_GROUND ? MBSR_NONE : carrier;
    }
    int status = mbsr_contacts_join(c, t->bodies, joined[0], error);
    free(joined);
    for (int k = 0; k < file->excluded && !status; ++k)
        status = mbsr_contacts_exclude(c, file->exclude[2 * k], file->exclude[2 * k + 1], error);
    return status;
}

static mbsr_contact_law law_of(const double friction[3], const double settle[2], double margin,
                               double mass, double stiffness)
{
    const bool timed = settle[0] >= 0.0; /* else -stiffness and -damping of 1 kg */
    const double gravity = 9.81, T = settle[0] > 0.0 ? settle[0] : 0.02,
                 z = settle[1] > 0.0 ? settle[1] : 1.0,
                 spring = timed ? 1.0 / (T * z * T * z) : -settle[0],
                 damper = timed ? 2.0 * z / T : -settle[1];
    return (mbsr_contact_law){.stiffness = stiffness > 0.0 ? stiffness : 2.0 * mass * spring,
                              .exponent = 1.0,
                              .damping =
                                  damper / gravity, /* k x damping is m damper where m rests */
                              .friction = fmax(0.0, friction[0]),
                              .slip = 1e-3,
                              .torsional = fmax(0.0, friction[1]),
                              .rolling = fmax(0.0, friction[2]),
                              .spin = 1e-2,
                              .margin = margin};
}

/* Of a mesh of a file: its hull, smaller by the rounding that its core gets. */
static double *shrink_hull(const mbsr_file_shape *from, mbsr_shape *s)
{
    double middle[3] = {0.0, 0.0, 0.0}, size = 0.0;
    double *corner = malloc(3 * (size_t)from->hull_corners * sizeof *corner);
    if (!corner) return NULL;
    for (int k = 0; k < 3 * from->hull_corners; ++k)
        middle[k % 3] += from->hull_corner[k] / from->hull_corners;
    for (int k = 0; k < from->hull_corners; ++k) {
        const double *x = from->hull_corner + 3 * (ptrdiff_t)k;
        const double arm[3] = {x[0] - middle[0], x[1] - middle[1], x[2] - middle[2]};
        size = fmax(size, sqrt(arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]));
    }
    s->rounding = size / 100.0;
    for (int k = 0; k < 3 * from->hull_corners; ++k)
        corner[k] = middle[k % 3] + 0.99 * (from->hull_corner[k] - middle[k % 3]);
    s->vertices = from->hull_corners;
    s->triangles = from->hull_sides;
    s->vertex = corner;
    s->triangle = from->hull_side;
    return corner;
}

/* What a file is made into. */
typedef struct made {
    mbsr_contacts *contacts;
    const mbsr_file *file;
    const tree *tree;
    double mass, stiffness;
    int *id; /* of each shape of the file; MBSR_NONE */
    mbsr_contacts_of_file done;
} made;

static int add_file_shape(made *m, int k, mbsr_error *error)
{
    const mbsr_file_shape *from = m->file->shape + k;
    const bool welded = is_welded_ground(m->tree, from), mesh = from->kind == MBSR_SHAPE_MESH,
               moves = mbsri_is_ground(from->kind) && from->body != MBSR_GROUND && !welded;
    m->id[k] = MBSR_NONE;
    if (!from->contact) return MBSR_OK;
    if (moves || (mesh && from->hull_corners == 0) ||
        !mbsri_core_has_size(from->kind, from->size)) {
        ++m->done.left_out;
        return MBSR_OK;
    }
    mbsr_shape s = mbsr_default_shape();
    s.name = from->name;
    s.body = welded ? MBSR_GROUND : from->body;
    s.kind = from->kind;
    s.frame = welded ? mbsr_frame_product(m->tree->frame + from->body, &from->frame) : from->frame;
    for (int l = 0; l < 3; ++l) s.size[l] = from->size[l];
    s.rows = from->rows, s.columns = from->columns;
    s.height = from->height;
    s.groups = from->groups;
    s.mask = from->mask;
    s.law = law_of(from->friction, from->settle, from->margin, m->mass, m->stiffness);
    double *corner = mesh ? shrink_hull(from, &s) : NULL;
    if (mesh && !corner)
        return mbsri_contact_fail(error, MBSR_ERR_NO_MEMORY, "mbsr_contacts_add_file: no memory");
    m->done.stiffness = fmax(m->done.stiffness, s.law.stiffness);
    const int status = mbsr_contacts_add(m->contacts, &s, m->id + k, error);
    free(corner);
    m->done.shapes += status == MBSR_OK;
    return status;
}

/* Pairs have half the stiffness of a shape, since they stand for two. */
static int add_file_pairs(const made *m, mbsr_error *error)
{
    int status = MBSR_OK;
    for (int k = 0; k < m->file->pairs && !status; ++k) {
        const mbsr_file_pair *pair = m->file->pair + k;
        const int a = m->id[pair->shape[0]], b = m->id[pair->shape[1]];
        if (a == MBSR_NONE || b == MBSR_NONE) continue;
        mbsr_contact_law law =
            law_of(pair->friction, pair->settle, pair->margin, m->mass, m->stiffness);
        law.stiffness *= 0.5;
        status = mbsr_contacts_pair(m->contacts, a, b, &law, error);
    }
    return status;
}

static bool has_couple(const mbsr_contacts *c, int a, int b)
{
    for (int k = 0; k < c->couples; ++k) {
        const mbsr_shape_pair *pair = c->couple + k;
        if ((pair->a == a && pair->b == b) || (pair->a == b && pair->b == a)) return true;
    }
    return false;
}

/* What a body's shapes never touch goes for those that have become the ground's. */
static int exclude_welded(const made *m, int body, int other, mbsr_error *error)
{
    const mbsr_file *f = m->file;
    int status = MBSR_OK;
    for (int a = 0; a < f->shapes; ++a) {
        if (f->shape[a].body != body || m->id[a] == MBSR_NONE ||
            !is_welded_ground(m->tree, f->shape + a))
            continue;
        for (int b = 0; b < f->shapes && !status; ++b) {
            if (f->shape[b].body != other || m->id[b] == MBSR_NONE ||
                has_couple(m->contacts, m->id[a], m->id[b]))
                continue;
            status = mbsr_contacts_pair(m->contacts, m->id[a], m->id[b], NULL, error);
        }
    }
    return status;
}

/* What may rest on a shape: all that moves, up to ten trees of the heaviest kind. */
static double bearing_of(const tree *t)
{
    double most = 0.0;
    for (int k = 0; k < t->bodies; ++k) most = fmax(most, t->joined[k]);
    return t->mass > 0.0 ? fmin(t->mass, 10.0 * most) : 1.0;
}

static int add_file_shapes(mbsr_contacts *c, const tree *t, const mbsr_file *file, double stiffness,
                           mbsr_contacts_of_file *told, mbsr_error *error)
{
    made m = {
        .contacts = c, .file = file, .tree = t, .mass = bearing_of(t), .stiffness = stiffness};
    int status = MBSR_OK;
    m.id = malloc(((size_t)file->shapes + 1) * sizeof *m.id);
    if (!m.id)
        return mbsri_contact_fail(error, MBSR_ERR_NO_MEMORY, "mbsr_contacts_add_file: no memory");
    for (int k = 0; k < file->shapes && !status; ++k) status = add_file_shape(&m, k, error);
    if (!status) status = add_file_pairs(&m, error);
    for (int k = 0; k < 2 * file->excluded && !status; ++k)
        status = exclude_welded(&m, file->exclude[k], file->exclude[k ^ 1], error);
    free(m.id);
    *told = m.done;
    return status;
}

int mbsr_contacts_add_file(mbsr_contacts *contacts, const mbsr_file *file, const mbsr_model *model,
                           double stiffness, mbsr_contacts_of_file *told, mbsr_error *error)
{
    const char *const function = "mbsr_contacts_add_file";
    mbsr_contacts_of_file done = {0};
    if (!contacts || !file || !model)
        return mbsri_contact_fail(error, MBSR_ERR_NULL, "%s: %s is NULL", function,
                                  !contacts ? "contacts"
                                  : !file   ? "file"
                                            : "model");
    if (!(stiffness >= 0.0) || !isfinite(stiffness))
        return mbsri_contact_fail(error, MBSR_ERR_VALUE, "%s: stiffness is %g", function,
                                  stiffness);
    tree t = {.bodies = mbsr_model_bodies(model)};
    const size_t count = (size_t)t.bodies + 1;
    t.parent = calloc(count, sizeof *t.parent);
    t.welded = calloc(count, sizeof *t.welded);
    t.shaped = calloc(count, sizeof *t.shaped);
    t.joined = calloc(count, sizeof *t.joined);
    t.frame = calloc(count, sizeof *t.frame);
    int status =
        t.parent && t.welded && t.shaped && t.joined && t.frame ? MBSR_OK : MBSR_ERR_NO_MEMORY;
    if (status)
        (void)mbsri_contact_fail(error, status, "%s: no memory", function);
    else if ((status = find_tree(model, file, &t)))
        (void)mbsri_contact_fail(error, status, "%s: the model is not finished", function);
    else if (has_welded_ground(&t, file) && (status = find_frames(model, &t)))
        (void)mbsri_contact_fail(error, status, "%s: %s", function, mbsr_status_text(status));
    if (!status) status = add_file_shapes(contacts, &t, file, stiffness, &done, error);
    if (!status) status = exclude_joined(contacts, &t, file, error);
    free(t.parent);
    free(t.welded);
    free(t.shaped);
    free(t.joined);
    free(t.frame);
    if (!status && told) *told = done;
    return status;
}
