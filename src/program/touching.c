/* A model whose shapes touch: see touching.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/touching.h"

#include <mbsrank/contact.h>

#include <stdlib.h>

static void tell(const mbsr_touching *found)
{
    const mbsr_contacts_of_file *told = &found->told;
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
    mbsr_touching made;
    mbsr_error error = {.text = ""};
    *t = (touching){.contacts = NULL};
    if (!on || !has_shapes(m->file)) return DONE;
    /* laws are by the masses that the file has, as those of stops are */
    if (mbsr_contacts_attach(m->file, m->read, m->model, q, 0.0, &made, &error))
        return complain(FAILED, "%s", error.text);
    if (!quiet) tell(&made);
    *t = (touching){.contacts = made.contacts, .model = made.model, .force = made.force};
    return DONE;
}

int touching_put(program_model *m, const double *q, bool on, bool quiet, touching *t)
{
    mbsr_error error = {.text = ""};
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
