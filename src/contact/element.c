/* The force element of all shapes, and what can be asked of it.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/space3.h"
#include "contact/error.h"
#include "contact/law.h"
#include "contact/near.h"

#include <string.h>

static const mbsr_contacts *shapes_of(const mbsr_force_def *def)
{
    return def->user;
}

/* ---- visiting ---- */

/* The points of two shapes, for one purpose. */
typedef struct visit {
    const mbsr_force_args *args;
    int a, b;                     /* shapes */
    const mbsr_force_body *on[2]; /* their bodies */
    mbsr_contact_law law;
    double sum;                        /* energy or power */
    const mbsr_force_derivatives *out; /* derivatives */
    bool swapped;                      /* out's first body is that of b */
    bool any;                          /* a point was there */
    mbsr_contact_point *point;         /* report */
    int most, count;
} visit;

static const mbsr_force_body *touching_body(const visit *v, const mbsri_touch *t, bool of_a)
{
    return v->on[t->exchanged == of_a];
}

static void push_touching(const mbsr_force_body *body, double sign, const double arm[3],
                          const mbsri_action *f)
{
    double moment[3];
    if (body->space != MBSR_SPACE_SPATIAL) return;
    mbsri_cross3(arm, f->force, moment);
    mbsri_add3(1.0, f->moment, moment);
    mbsri_add3(sign, moment, body->f);
    mbsri_add3(sign, f->force, body->f + 3);
}

static int exert_point(void *user, const mbsri_touch *t)
{
    visit *v = user;
    mbsri_action f;
    mbsri_act(&v->law, t, touching_body(v, t, true), touching_body(v, t, false), &f);
    push_touching(touching_body(v, t, true), 1.0, f.arm_a, &f);
    push_touching(touching_body(v, t, false), -1.0, f.arm_b, &f);
    return MBSR_OK;
}

static int add_energy(void *user, const mbsri_touch *t)
{
    visit *v = user;
    v->sum += mbsri_action_energy(&v->law, t);
    return MBSR_OK;
}

static int add_heat(void *user, const mbsri_touch *t)
{
    visit *v = user;
    mbsri_action f;
    mbsri_act(&v->law, t, touching_body(v, t, true), touching_body(v, t, false), &f);
    v->sum += mbsri_action_heat(&f);
    return MBSR_OK;
}

static int add_slopes(void *user, const mbsri_touch *t)
{
    visit *v = user;
    const mbsr_force_body *a = touching_body(v, t, true), *b = touching_body(v, t, false);
    mbsri_touch here = *t;
    mbsri_action f;
    here.exchanged = t->exchanged != v->swapped;
    mbsri_act(&v->law, t, a, b, &f);
    mbsri_action_slopes(&v->law, &here, a, b, &f, v->out);
    return MBSR_OK;
}

static int note_point(void *user, const mbsri_touch *t)
{
    ((visit *)user)->any = true;
    (void)t;
    return MBSR_OK;
}

/* Which shapes touch, at how many points, and whether they are torn apart. */
static int add_side(void *user, const mbsri_touch *t)
{
    visit *v = user;
    mbsri_action f;
    mbsri_act(&v->law, t, touching_body(v, t, true), touching_body(v, t, false), &f);
    v->sum += (v->a + 1.0) * (v->b + 1.0) + (f.normal > 0.0 ? 0.0 : 0.5);
    return MBSR_OK;
}

typedef int (*purpose)(void *user, const mbsri_touch *touch);

/* The points of shapes a and b. */
static int visit_pair(visit *v, const mbsri_placed *a, const mbsri_placed *b, purpose what)
{
    const int status = mbsri_touches(a, b, v->law.margin, what, v);
    if (status == MBSR_ERR_MEMORY_SIZE && v->args->text)
        mbsri_contact_print(v->args->text, MBSR_TEXT_SIZE,
                            "a corner touches a height field at too many places, of %s and %s",
                            a->shape->name, b->shape->name);
    return status;
}

/* All pairs of shapes of all bodies. */
static int visit_all(visit *v, purpose what)
{
    const mbsr_contacts *c = shapes_of(v->args->force);
    mbsri_near near;
    int count;
    int status = mbsri_near_find(c, v->args, &near, &count);
    for (int k = 0; k < count && !status; ++k) {
        v->a = near.pair[k][0], v->b = near.pair[k][1];
        v->on[0] = v->args->body + c->shape[v->a].place;
        v->on[1] = v->args->body + c->shape[v->b].place;
        v->law = mbsri_law_of_shapes(c, v->a, v->b);
        status = visit_pair(v, near.placed + v->a, near.placed + v->b, what);
    }
    return status;
}

static int evaluate(const mbsr_force_args *args)
{
    visit v = {.args = args};
    return visit_all(&v, exert_point);
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    visit v = {.args = args};
    const int status = visit_all(&v, add_energy);
    *energy_out += v.sum;
    return status;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    visit v = {.args = args};
    const int status = visit_all(&v, add_heat);
    *power += v.sum;
    return status;
}

static double side_of_touches(const mbsr_force_args *args)
{
    visit v = {.args = args};
    return visit_all(&v, add_side) ? 0.0 : v.sum;
}

/* ---- pairs of bodies ---- */

static int pairs(const mbsr_force_args *args, int (*pair)[2], int *count)
{
    const mbsr_contacts *c = shapes_of(args->force);
    mbsri_near near;
    int found, used = 0, status = mbsri_near_find(c, args, &near, &found);
    for (int k = 0; k < found && !status; ++k) {
        const int a = near.pair[k][0], b = near.pair[k][1];
        const int x = c->shape[a].place, y = c->shape[b].place;
        visit v = {.args = args, .law = mbsri_law_of_shapes(c, a, b)};
        status = visit_pair(&v, near.placed + a, near.placed + b, note_point);
        if (!v.any) continue;
        near.pair[used][0] = x < y ? x : y;
        near.pair[used++][1] = x < y ? y : x;
    }
    if (status) return status;
    mbsri_near_sort(&near, c->bodies, used);
    *count = 0;
    for (int k = 0; k < used; ++k) {
        const int *now = near.pair[k];
        if (*count > 0 && pair[*count - 1][0] == now[0] && pair[*count - 1][1] == now[1]) continue;
        pair[*count][0] = now[0];
        pair[*count][1] = now[1];
        ++*count;
    }
    return MBSR_OK;
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_contacts *c = shapes_of(args->force);
    const int x = args->pair[0], y = args->pair[1];
    int status = MBSR_OK;
    for (int i = c->first[x]; i < c->first[x + 1]; ++i) {
        for (int j = c->first[y]; j < c->first[y + 1] && !status; ++j) {
            const bool swapped = c->member[i] > c->member[j];
            const int a = swapped ? c->member[j] : c->member[i],
                      b = swapped ? c->member[i] : c->member[j];
            if (!mbsri_may_touch(c, a, b)) continue;
            mbsri_placed placed[2];
            visit v = {.args = args, .a = a, .b = b, .out = out, .swapped = swapped};
            v.on[0] = args->body + swapped, v.on[1] = args->body + !swapped;
            v.law = mbsri_law_of_shapes(c, a, b);
            mbsri_near_put(c->shape + a, v.on[0], placed);
            mbsri_near_put(c->shape + b, v.on[1], placed + 1);
            status = visit_pair(&v, placed, placed + 1, add_slopes);
        }
    }
    return status;
}

static void needs(const mbsr_force_def *force, mbsr_force_needs *out)
{
    const mbsr_contacts *c = shapes_of(force);
    mbsri_near near;
    out->bytes = mbsri_near_place(c, NULL, &near);
    out->pairs = c->most;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < args->bodies; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_SPATIAL ||
            (body->id == MBSR_GROUND && body->space == MBSR_SPACE_FIXED))
            continue;
        mbsri_contact_print(
            text, MBSR_TEXT_SIZE,
            "shapes are on body %d, which is neither SPATIAL nor the ground at rest", body->id);
        return MBSR_ERR_SPACE;
    }
    return MBSR_OK;
}

static int check_fields(const mbsr_force_def *force, char text[MBSR_TEXT_SIZE])
{
    const mbsr_contacts *c = shapes_of(force);
    if (c && c->made && force->bodies == c->bodies && force->body_list == c->body) return MBSR_OK;
    mbsri_contact_print(text, MBSR_TEXT_SIZE,
                        "user, bodies or body_list are not those of mbsr_contacts_force");
    return MBSR_ERR_VALUE;
}

const mbsr_force_table mbsri_contacts_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT | MBSR_FORCE_BY_PAIRS,
    .name = "contacts",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .derivatives = derivatives,
    .needs = needs,
    .pairs = pairs,
    .side = side_of_touches,
};

/* ---- the report ---- */

static int report(void *user, const mbsri_touch *t)
{
    visit *v = user;
    const double sign = t->exchanged ? -1.0 : 1.0;
    mbsri_action f;
    if (v->count++ >= v->most) return MBSR_OK;
    mbsr_contact_point *to = v->point + v->count - 1;
    mbsri_act(&v->law, t, touching_body(v, t, true), touching_body(v, t, false), &f);
    *to = (mbsr_contact_point){.shape_a = v->a,
                               .shape_b = v->b,
                               .body_a = v->on[0]->id,
                               .body_b = v->on[1]->id,
                               .depth = t->depth,
                               .rate = f.rate,
                               .normal_force = f.normal};
    for (int k = 0; k < 3; ++k) {
        to->point[k] = f.p[k];
        to->normal[k] = sign * t->n[k];
        to->friction[k] = -sign * f.drag * f.sliding[k];
        to->moment[k] = sign * f.moment[k];
        to->sliding[k] = sign * f.sliding[k];
    }
    return MBSR_OK;
}

static bool is_finite(const mbsr_contact_point *p)
{
    double sum = p->depth + p->rate + p->normal_force;
    for (int k = 0; k < 3; ++k)
        sum += p->point[k] + p->normal[k] + p->friction[k] + p->moment[k] + p->sliding[k];
    return isfinite(sum);
}

static int report_all(const mbsr_force_args *args, void *user)
{
    visit *v = user;
    v->args = args;
    if (args->force->table != &mbsri_contacts_table) {
        if (args->text)
            mbsri_contact_print(args->text, MBSR_TEXT_SIZE,
                                "mbsr_contact_report: the element is not one of shapes");
        return MBSR_ERR_VALUE;
    }
    const int status = visit_all(v, report);
    for (int k = 0; k < v->most && k < v->count && !status; ++k) {
        if (!is_finite(v->point + k)) return MBSR_NOT_FINITE;
    }
    return status;
}

int mbsr_contact_report(const mbsr_model *model, mbsr_data *data, int force, int most,
                        mbsr_contact_point *points, int *count)
{
    visit v = {.most = most > 0 && points ? most : 0, .point = points};
    if (!count) return MBSR_ERR_NULL;
    *count = 0;
    const int status = mbsr_force_inspect(model, data, force, report_all, &v);
    if (!status) *count = v.count;
    return status;
}
