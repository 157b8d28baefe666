/* Models of files whose shapes touch.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/error.h"

#include <mbsrank/contact.h>
#include <mbsrank/files.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* What is made, and of what. */
typedef struct attaching {
    const mbsr_file *file;
    const mbsr_model *masses, *model;
    double stiffness;
    mbsr_touching *made;
    /* What is drawn into each other, so that two shapes press with more than the weight of all
     * bodies: pairs of bodies, neither of them the ground, and pairs of shapes of the ground and of
     * what a joint holds to it. */
    int (*body)[2], (*shape)[2];
    mbsr_error *error;
} attaching;

static const char name[] = "mbsr_contacts_attach";

static void let_go(mbsr_touching *t)
{
    mbsr_model_destroy(t->model);
    mbsr_contacts_destroy(t->contacts);
    t->model = NULL;
    t->contacts = NULL;
    t->force = MBSR_NONE;
}

/* The object, without what is drawn into each other, and the model with its element. */
static int attach_once(const attaching *a)
{
    mbsr_touching *t = a->made;
    mbsr_force_def def;
    int status = mbsr_contacts_create(&t->contacts, a->error);
    if (!status)
        status = mbsr_contacts_add_file(t->contacts, a->file, a->masses, a->stiffness, &t->told,
                                        a->error);
    for (int k = 0; k < t->bodies && !status; ++k)
        status = mbsr_contacts_exclude(t->contacts, a->body[k][0], a->body[k][1], a->error);
    for (int k = 0; k < t->shapes && !status; ++k)
        status = mbsr_contacts_pair(t->contacts, a->shape[k][0], a->shape[k][1], NULL, a->error);
    if (!status) status = mbsr_contacts_force(t->contacts, 0, &def, a->error);
    if (!status) status = mbsr_model_copy(a->model, &t->model, a->error);
    if (status) return status;
    status = mbsr_model_add_force(t->model, &def, &t->force);
    if (!status) status = mbsr_model_finish(t->model);
    if (status && a->error) *a->error = *mbsr_model_error(t->model);
    return status;
}

/* Whether joints with less than six freedoms hold a body to the ground, with no other that has
 * shapes between them. */
static bool is_held_by_ground(const attaching *a, int body)
{
    int freedoms = 0;
    for (;; body = mbsr_body_parent(a->model, body)) {
        mbsr_body_def def;
        if (mbsr_body_definition(a->model, body, &def)) return false;
        freedoms += def.joint.n;
        if (def.parent == MBSR_GROUND) return freedoms < 6;
        for (int k = 0; k < a->file->shapes; ++k) {
            if (a->file->shape[k].contact && a->file->shape[k].body == def.parent) return false;
        }
    }
}

static double weight_of_all(const mbsr_model *m)
{
    double all = 0.0;
    for (int k = 0; k < mbsr_model_bodies(m); ++k) {
        mbsr_body_def def;
        if (mbsr_body_definition(m, k, &def)) continue;
        const mbsr_inertia_kind kind = def.inertia.kind;
        if (kind == MBSR_INERTIA_SPATIAL || kind == MBSR_INERTIA_PARTICLE) all += def.inertia.mass;
    }
    return 9.81 * (all > 0.0 ? all : 1.0);
}

static void note_pair(int x, int y, int *count, int (*pair)[2])
{
    for (int k = 0; k < *count; ++k) {
        if (pair[k][0] == x && pair[k][1] == y) return;
    }
    pair[*count][0] = x;
    pair[(*count)++][1] = y;
}

/* Whether the file gives two bodies shapes that touch by a law of their own. */
static bool have_law(const mbsr_file *f, int x, int y)
{
    for (int k = 0; k < f->pairs; ++k) {
        const int a = f->shape[f->pair[k].shape[0]].body, b = f->shape[f->pair[k].shape[1]].body;
        if ((a == x && b == y) || (a == y && b == x)) return true;
    }
    return false;
}

static void list_overlaps(attaching *a, const mbsr_contact_point *points, int count)
{
    const double weight = weight_of_all(a->model);
    for (int k = 0, next; k < count; k = next) { /* points of two shapes follow each other */
        const mbsr_contact_point *p = points + k;
        const int on_ground = p->body_a == MBSR_GROUND ? p->body_b : p->body_a;
        double force = 0.0;
        for (next = k; next < count && points[next].shape_a == p->shape_a &&
                       points[next].shape_b == p->shape_b;
             ++next)
            force += points[next].normal_force;
        if (force <= weight) continue;
        if (p->body_a != MBSR_GROUND && p->body_b != MBSR_GROUND)
            note_pair(p->body_a, p->body_b, &a->made->bodies, a->body);
        else if (is_held_by_ground(a, on_ground) && !have_law(a->file, p->body_a, p->body_b))
            note_pair(p->shape_a, p->shape_b, &a->made->shapes, a->shape);
    }
}

static int find_points(attaching *a, mbsr_data *d)
{
    const mbsr_touching *t = a->made;
    int count = 0, status = mbsr_contact_report(t->model, d, t->force, 0, NULL, &count);
    const size_t room = (size_t)count + 1;
    mbsr_contact_point *points = calloc(room, sizeof *points);
    a->body = calloc(room, sizeof *a->body);
    a->shape = calloc(room, sizeof *a->shape);
    if (!points || !a->body || !a->shape)
        status = mbsri_contact_fail(a->error, MBSR_ERR_NO_MEMORY, "%s: no memory", name);
    else if (!status)
        status = mbsr_contact_report(t->model, d, t->force, count, points, &count);
    if (!status) list_overlaps(a, points, count);
    free(points);
    return status;
}

static int find_overlaps(attaching *a, const double *q)
{
    mbsr_data *d = NULL;
    const mbsr_model *m = a->made->model;
    double *u = calloc((size_t)mbsr_model_nu(m) + 1, sizeof *u);
    int status = u ? mbsr_data_create(m, &d, a->error)
                   : mbsri_contact_fail(a->error, MBSR_ERR_NO_MEMORY, "%s: no memory", name);
    if (!status) {
        status = mbsr_stage_positions(m, d, 0.0, q);
        if (!status) status = mbsr_stage_velocities(m, d, u);
        if (!status) status = find_points(a, d);
        if (status && status != MBSR_ERR_NO_MEMORY && a->error) *a->error = *mbsr_data_error(d);
    }
    mbsr_data_destroy(d);
    free(u);
    return status;
}

int mbsr_contacts_attach(const mbsr_file *file, const mbsr_model *masses, const mbsr_model *model,
                         const double *q, double stiffness, mbsr_touching *made, mbsr_error *error)
{
    if (made) *made = (mbsr_touching){.force = MBSR_NONE};
    if (!file || !model || !q || !made)
        return mbsri_contact_fail(error, MBSR_ERR_NULL, "%s: %s is NULL", name,
                                  !file    ? "file"
                                  : !model ? "model"
                                  : !q     ? "q"
                                           : "made");
    attaching a = {.file = file,
                   .masses = masses ? masses : model,
                   .model = model,
                   .stiffness = stiffness,
                   .made = made,
                   .error = error};
    int status = attach_once(&a);
    if (!status) status = find_overlaps(&a, q);
    if (!status && made->bodies + made->shapes > 0) {
        let_go(made);
        status = attach_once(&a);
    }
    free(a.body);
    free(a.shape);
    if (status || made->told.shapes == 0) let_go(made);
    return status;
}
