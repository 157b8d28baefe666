/* A model whose shapes touch: see touching.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/touching.h"

#include <mbsrank/contact.h>

#include <math.h>
#include <stdlib.h>

/* What is drawn into each other as the run begins, so that two shapes press with more than the
 * weight of all bodies: pairs of bodies, neither of them the ground, and pairs of shapes of the
 * ground and of what a joint holds to it. */
typedef struct overlaps {
    int bodies, (*body)[2], shapes, (*shape)[2];
} overlaps;

/* The object and the model with its element. Laws are by the masses that the file has, as those of
 * stops are: another value of a parameter leaves them. */
static int make_touching(const program_model *m, const overlaps *without, touching *t,
                         mbsr_contacts_of_file *told)
{
    mbsr_error error = {.text = "no memory"};
    mbsr_force_def def;
    int status = mbsr_contacts_create(&t->contacts, &error);
    if (!status)
        status = mbsr_contacts_add_file(t->contacts, m->file, m->read ? m->read : m->model, 0.0,
                                        told, &error);
    for (int k = 0; k < without->bodies && !status; ++k)
        status =
            mbsr_contacts_exclude(t->contacts, without->body[k][0], without->body[k][1], &error);
    for (int k = 0; k < without->shapes && !status; ++k)
        status = mbsr_contacts_pair(t->contacts, without->shape[k][0], without->shape[k][1], NULL,
                                    &error);
    if (!status) status = mbsr_contacts_force(t->contacts, 0, &def, &error);
    if (!status) status = mbsr_model_copy(m->model, &t->model, &error);
    if (status) return complain(FAILED, "%s", error.text);
    if (mbsr_model_add_force(t->model, &def, &t->force) || mbsr_model_finish(t->model))
        return complain(FAILED, "%s", mbsr_model_error(t->model)->text);
    return DONE;
}

/* Whether joints with less than six freedoms hold a body to the ground, with no other that has
 * shapes between them. */
static bool is_held_by_ground(const program_model *m, int body)
{
    int freedoms = 0;
    for (;; body = mbsr_body_parent(m->model, body)) {
        mbsr_body_def def;
        if (mbsr_body_definition(m->model, body, &def)) return false;
        freedoms += def.joint.n;
        if (def.parent == MBSR_GROUND) return freedoms < 6;
        for (int k = 0; k < m->file->shapes; ++k) {
            if (m->file->shape[k].contact && m->file->shape[k].body == def.parent) return false;
        }
    }
}

static double weigh_all(const program_model *m)
{
    double all = 0.0;
    for (int k = 0; k < mbsr_model_bodies(m->model); ++k) {
        mbsr_body_def def;
        double mass;
        if (mbsr_body_definition(m->model, k, &def)) continue;
        (void)weigh_body(&def.inertia, &mass);
        if (isfinite(mass)) all += mass;
    }
    return 9.81 * (all > 0.0 ? all : 1.0);
}

static void add_pair(int a, int b, int *count, int (*pair)[2])
{
    for (int k = 0; k < *count; ++k) {
        if (pair[k][0] == a && pair[k][1] == b) return;
    }
    pair[*count][0] = a;
    pair[(*count)++][1] = b;
}

/* Whether the file gives two bodies shapes that touch by a law of their own. */
static bool have_pair(const mbsr_file *f, int a, int b)
{
    for (int k = 0; k < f->pairs; ++k) {
        const int x = f->shape[f->pair[k].shape[0]].body, y = f->shape[f->pair[k].shape[1]].body;
        if ((x == a && y == b) || (x == b && y == a)) return true;
    }
    return false;
}

static int list_overlaps(const program_model *m, const mbsr_contact_point *points, int count,
                         overlaps *found)
{
    found->body = malloc(((size_t)count + 1) * sizeof *found->body);
    found->shape = malloc(((size_t)count + 1) * sizeof *found->shape);
    if (!found->body || !found->shape) return complain(FAILED, "no memory");
    const double weight = weigh_all(m);
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
            add_pair(p->body_a, p->body_b, &found->bodies, found->body);
        else if (is_held_by_ground(m, on_ground) && !have_pair(m->file, p->body_a, p->body_b))
            add_pair(p->shape_a, p->shape_b, &found->shapes, found->shape);
    }
    return DONE;
}

static int find_overlaps(const program_model *m, touching *t, const double *q, overlaps *found)
{
    mbsr_error error;
    mbsr_data *d = NULL;
    double *u = calloc((size_t)mbsr_model_nu(t->model) + 1, sizeof *u);
    if (!u || mbsr_data_create(t->model, &d, &error)) {
        free(u);
        return complain(FAILED, "no memory");
    }
    int code = DONE;
    if (mbsr_stage_positions(t->model, d, 0.0, q) || mbsr_stage_velocities(t->model, d, u))
        code = complain(FAILED, "%s", mbsr_data_error(d)->text);
    if (!code) code = touching_look(t, d);
    if (!code) code = list_overlaps(m, t->point, t->count, found);
    mbsr_data_destroy(d);
    free(u);
    return code;
}

static void tell(const mbsr_contacts_of_file *told, const overlaps *found)
{
    if (told->shapes > 0)
        say(stderr, "%d shapes touch, with up to %.3g N/m each; not so: --no-contacts\n",
            told->shapes, told->stiffness);
    if (told->left_out > 0)
        say(stderr,
            "%d shapes for contact are left out: planes that move, meshes without a hull, or no "
            "size\n",
            told->left_out);
    if (found->bodies > 0)
        say(stderr, "shapes of %d pairs of bodies are drawn into each other and never touch\n",
            found->bodies);
    if (found->shapes > 0)
        say(stderr,
            "%d pairs of shapes of the ground and of what a joint holds to it are drawn into each "
            "other and never touch\n",
            found->shapes);
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
    overlaps found = {0};
    *t = (touching){.contacts = NULL};
    if (!on || !has_shapes(m->file)) return DONE;
    int code = make_touching(m, &found, t, &told);
    if (!code) code = find_overlaps(m, t, q, &found);
    if (!code && found.bodies + found.shapes > 0) {
        mbsr_model_destroy(t->model);
        touching_free(t);
        code = make_touching(m, &found, t, &told);
    }
    if (!code && !quiet) tell(&told, &found);
    free(found.body);
    free(found.shape);
    if (code || told.shapes == 0) {
        mbsr_model_destroy(t->model);
        touching_free(t);
    }
    return code;
}

int touching_put(program_model *m, const double *q, bool on, bool quiet, touching *t)
{
    mbsr_error error;
    const int code = touching_make(m, q, on, quiet, t);
    if (code || !t->model) return code;
    mbsr_data_destroy(m->data);
    m->data = NULL;
    m->model = t->model;
    return mbsr_data_create(m->model, &m->data, &error) ? complain(FAILED, "%s", error.text) : DONE;
}

void touching_free(touching *t)
{
    mbsr_contacts_destroy(t->contacts);
    free(t->point);
    *t = (touching){.contacts = NULL};
}

/* ---- points ---- */

int touching_look(touching *t, mbsr_data *data)
{
    int status = mbsr_contact_report(t->model, data, t->force, t->room, t->point, &t->count);
    if (!status && t->count > t->room) {
        const int room = 2 * t->count;
        mbsr_contact_point *larger = realloc(t->point, (size_t)room * sizeof *larger);
        if (!larger) return complain(FAILED, "no memory");
        t->point = larger;
        t->room = room;
        status = mbsr_contact_report(t->model, data, t->force, t->room, t->point, &t->count);
    }
    return status ? complain(FAILED, "%s", mbsr_data_error(data)->text) : DONE;
}

/* On body a of a point. */
static void force_on_a(const mbsr_contact_point *p, double force[3])
{
    for (int k = 0; k < 3; ++k) force[k] = p->normal_force * p->normal[k] + p->friction[k];
}

void touching_arrow(const touching *t, int k, float place[3], float force[3])
{
    const mbsr_contact_point *p = t->point + k;
    const double sign = p->body_a > p->body_b ? 1.0 : -1.0;
    double on_a[3];
    force_on_a(p, on_a);
    for (int l = 0; l < 3; ++l) {
        place[l] = (float)p->point[l];
        force[l] = (float)(sign * on_a[l]);
    }
}

void touching_load(const touching *t, int body, int other, const double none[3], double value[6])
{
    double weight = 0.0, sum[3] = {0.0, 0.0, 0.0};
    for (int l = 0; l < 6; ++l) value[l] = l < 3 ? 0.0 : none[l - 3];
    for (int k = 0; k < t->count; ++k) {
        const mbsr_contact_point *p = t->point + k;
        const bool is_a = p->body_a == body, is_b = p->body_b == body;
        const int second = is_a ? p->body_b : p->body_a;
        double on_a[3];
        if ((!is_a && !is_b) || (other != ANY_BODY && second != other)) continue;
        force_on_a(p, on_a);
        weight += p->normal_force;
        for (int l = 0; l < 3; ++l) {
            value[l] += is_a ? on_a[l] : -on_a[l];
            sum[l] += p->normal_force * p->point[l];
        }
    }
    for (int l = 0; l < 3 && weight > 0.0; ++l) value[3 + l] = sum[l] / weight;
}
