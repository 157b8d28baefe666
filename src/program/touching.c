/* A model whose shapes touch: see touching.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/touching.h"

#include <mbsrank/contact.h>

#include <stdlib.h>

/* Pairs of bodies, neither of them the ground, whose shapes overlap as drawn. */
typedef struct overlaps {
    int count, (*pair)[2];
} overlaps;

/* The object and the model with its element; *force is its id. */
static int make_touching(const program_model *m, const overlaps *without, touching *t, int *force,
                         mbsr_contacts_of_file *told)
{
    mbsr_error error = {.text = "no memory"};
    mbsr_force_def def;
    int status = mbsr_contacts_create(&t->contacts, &error);
    if (!status) status = mbsr_contacts_add_file(t->contacts, m->file, m->model, 0.0, told, &error);
    for (int k = 0; k < without->count && !status; ++k)
        status =
            mbsr_contacts_exclude(t->contacts, without->pair[k][0], without->pair[k][1], &error);
    if (!status) status = mbsr_contacts_force(t->contacts, 0, &def, &error);
    if (!status) status = mbsr_model_copy(m->model, &t->model, &error);
    if (status) return complain(FAILED, "%s", error.text);
    if (mbsr_model_add_force(t->model, &def, force) || mbsr_model_finish(t->model))
        return complain(FAILED, "%s", mbsr_model_error(t->model)->text);
    return DONE;
}

static int list_overlaps(const mbsr_contact_point *points, int count, overlaps *found)
{
    found->pair = malloc(((size_t)count + 1) * sizeof *found->pair);
    if (!found->pair) return complain(FAILED, "no memory");
    for (int k = 0; k < count; ++k) {
        const mbsr_contact_point *p = points + k;
        bool known = p->body_a == MBSR_GROUND || p->body_b == MBSR_GROUND;
        for (int l = 0; l < found->count && !known; ++l)
            known = found->pair[l][0] == p->body_a && found->pair[l][1] == p->body_b;
        if (known) continue;
        found->pair[found->count][0] = p->body_a;
        found->pair[found->count++][1] = p->body_b;
    }
    return DONE;
}

static int find_overlaps(const touching *t, int force, const double *q, overlaps *found)
{
    mbsr_error error;
    mbsr_data *d = NULL;
    mbsr_contact_point *points = NULL;
    int count = 0, code = DONE;
    double *u = calloc((size_t)mbsr_model_nu(t->model) + 1, sizeof *u);
    if (!u || mbsr_data_create(t->model, &d, &error)) {
        free(u);
        return complain(FAILED, "no memory");
    }
    int status = mbsr_stage_positions(t->model, d, 0.0, q);
    if (!status) status = mbsr_stage_velocities(t->model, d, u);
    if (!status) status = mbsr_contact_report(t->model, d, force, 0, NULL, &count);
    if (!status && count > 0) points = calloc((size_t)count, sizeof *points);
    if (points) status = mbsr_contact_report(t->model, d, force, count, points, &count);
    if (status) code = complain(FAILED, "%s", mbsr_data_error(d)->text);
    if (!code && points) code = list_overlaps(points, count, found);
    mbsr_data_destroy(d);
    free(points);
    free(u);
    return code;
}

static void tell(const mbsr_contacts_of_file *told, int overlapping)
{
    say(stderr, "%d shapes touch, with up to %.3g N/m each\n", told->shapes, told->stiffness);
    if (told->left_out > 0)
        say(stderr, "%d shapes for contact are left out: meshes, or planes that move\n",
            told->left_out);
    if (told->unserved > 0)
        say(stderr, "%d pairs of shapes never touch: two of these kinds are not served\n",
            told->unserved);
    if (overlapping > 0)
        say(stderr, "shapes of %d pairs of bodies overlap at the start and never touch\n",
            overlapping);
}

static bool has_shapes(const mbsr_file *f)
{
    bool any = false;
    for (int k = 0; k < f->shapes; ++k) any = any || (f->shape[k].contact && f->shape[k].body >= 0);
    return any;
}

int touching_make(const program_model *m, const double *q, bool on, bool quiet, touching *t)
{
    mbsr_contacts_of_file told = {0};
    overlaps none = {0, NULL}, found = {0, NULL};
    int force;
    *t = (touching){NULL, NULL};
    if (!has_shapes(m->file)) return DONE;
    if (!on && !quiet) say(stderr, "shapes for contact do not touch without --contacts\n");
    if (!on) return DONE;
    int code = make_touching(m, &none, t, &force, &told);
    if (!code) code = find_overlaps(t, force, q, &found);
    if (!code && found.count > 0) {
        mbsr_model_destroy(t->model);
        touching_free(t);
        code = make_touching(m, &found, t, &force, &told);
    }
    if (!code && !quiet) tell(&told, found.count);
    free(found.pair);
    if (code && t->model) mbsr_model_destroy(t->model);
    if (code) touching_free(t);
    return code;
}

void touching_free(touching *t)
{
    mbsr_contacts_destroy(t->contacts);
    *t = (touching){NULL, NULL};
}
