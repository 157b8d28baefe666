/* The model of a plan: see build.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/build.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>

static int held_motion(void *user, double t, double *s, double *sdot, double *sddot)
{
    const mbsri_held_motion *m = user;
    const double dt = t - *m->t0;
    for (int k = 0; k < m->count; ++k) {
        const double *x = m->value + 3 * k;
        s[k] = x[0] + dt * (x[1] + 0.5 * dt * x[2]);
        sdot[k] = x[1] + dt * x[2];
        sddot[k] = x[2];
    }
    return MBSR_OK;
}

static void *link_to(const mbsri_built *b, const mbsri_link *link, const double *input)
{
    switch (link->kind) {
    case MBSRI_LINK_TABLE: return b->table[link->index];
    case MBSRI_LINK_FLEX: return b->flex[link->index];
    case MBSRI_LINK_SHAPES: return b->contacts[link->index];
    case MBSRI_LINK_INPUT: return (void *)(input + link->index);
    case MBSRI_LINK_MOTION: return b->motion + link->index;
    default: return NULL;
    }
}

static mbsr_motion_fn motion_of(const mbsri_link *link)
{
    return link->function == 1 ? mbsr_table_motion : link->function == 2 ? held_motion : NULL;
}

static mbsr_force_fn force_of_plan(const mbsri_link *link)
{
    return link->function == 1 ? mbsr_table_force : link->function == 2 ? mbsr_stored_force : NULL;
}

/* Of a failure of the model. */
static int told(const mbsri_built *b, int status, mbsr_error *error)
{
    if (status) *error = *mbsr_model_error(b->model);
    return status;
}

static int amend(const mbsri_built *b, const mbsri_plan_body *body, int id)
{
    int status = MBSR_OK;
    if (body->added) status = mbsr_model_regularise(b->model, id, body->def.joint.d, body->added);
    for (int k = 0; body->locked_at && k < body->joint_n && !status; ++k)
        if (!isnan(body->locked_at[k]))
            status = mbsr_model_lock(b->model, id, k, body->locked_at[k]);
    if (body->drops && !status) status = mbsr_model_drop_locked(b->model, id);
    if (body->armature && !status)
        status = mbsr_model_armature(b->model, id, body->armatures, body->armature);
    return status;
}

static int add_bodies(const mbsri_unit_plan *plan, const mbsri_built *b, const double *input)
{
    for (int k = 0; k < plan->bodies; ++k) {
        const mbsri_plan_body *body = plan->body + k;
        mbsr_body_def def = body->def;
        int id;
        def.joint.user = link_to(b, &body->link, input);
        def.joint.motion = motion_of(&body->link);
        if (body->flex >= 0) def.inertia.flex = b->flex[body->flex];
        int status = mbsr_model_add_body(b->model, &def, &id);
        if (!status) status = amend(b, body, id);
        if (status) return status;
    }
    return MBSR_OK;
}

static int add_plan_elements(const mbsri_unit_plan *plan, const mbsri_built *b, const double *input)
{
    int status = MBSR_OK;
    for (int k = 0; k < plan->forces && !status; ++k) {
        const mbsri_plan_force *force = plan->force + k;
        mbsr_force_def def = force->def;
        def.user = link_to(b, &force->link, input);
        def.function = force_of_plan(&force->link);
        if (force->link.kind == MBSRI_LINK_SHAPES) {
            status = mbsr_contacts_force(def.user, 0, &def, NULL);
            def.name = force->def.name;
        }
        if (!status) status = mbsr_model_add_force(b->model, &def, NULL);
    }
    for (int k = 0; k < plan->closures && !status; ++k) {
        const mbsri_plan_closure *closure = plan->closure + k;
        mbsr_closure_def def = closure->def;
        def.user = link_to(b, &closure->link, input);
        def.motion = motion_of(&closure->link);
        status = mbsr_model_add_closure(b->model, &def, NULL);
    }
    return status;
}

static int make_contacts(const mbsr_contacts_def *def, mbsr_contacts **made, mbsr_error *error)
{
    mbsr_force_def force;
    int status = mbsr_contacts_create(made, error);
    mbsr_contacts *c = *made;
    for (int k = 0; k < def->shapes && !status; ++k)
        status = mbsr_contacts_add(c, def->shape + k, NULL, error);
    for (int k = 0; k < def->excluded && !status; ++k)
        status = mbsr_contacts_exclude(c, def->exclude[2 * k], def->exclude[2 * k + 1], error);
    for (int k = 0; k < def->pairs && !status; ++k) {
        const mbsr_shape_pair *pair = def->pair + k;
        status = mbsr_contacts_pair(c, pair->a, pair->b, pair->never ? NULL : &pair->law, error);
    }
    if (!status) status = mbsr_contacts_join(c, def->bodies, def->joined, error);
    if (!status) status = mbsr_contacts_force(c, def->max_pairs, &force, error);
    return status;
}

/* What the parts link to. */
static int make_parts(const mbsri_unit_plan *plan, const double *input, const double *t0,
                      mbsri_built *b, mbsr_error *error)
{
    int status = MBSR_OK;
    b->table = calloc((size_t)plan->tables + 1, sizeof(mbsr_table *));
    b->flex = calloc((size_t)plan->flexes + 1, sizeof(mbsr_flex *));
    b->contacts = calloc((size_t)plan->contacts + 1, sizeof(mbsr_contacts *));
    b->motion = calloc((size_t)plan->motions + 1, sizeof *b->motion);
    if (!b->table || !b->flex || !b->contacts || !b->motion)
        return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY, "no memory for the parts of a model");
    for (; b->tables < plan->tables && !status; ++b->tables)
        status = mbsr_table_create(&plan->table[b->tables].def, b->table + b->tables, error);
    for (; b->flexes < plan->flexes && !status; ++b->flexes)
        status = mbsr_flex_create(&plan->flex[b->flexes].def, b->flex + b->flexes, error);
    for (; b->objects < plan->contacts && !status; ++b->objects)
        status = make_contacts(&plan->shapes[b->objects].def, b->contacts + b->objects, error);
    for (int k = 0; k < plan->motions; ++k)
        b->motion[k] =
            (mbsri_held_motion){plan->motion[k].count, input + plan->motion[k].input, t0 + k};
    return status;
}

/* Whether coordinates and sites of the plan are those of the model. */
static int check_sizes(const mbsri_unit_plan *plan, const mbsri_built *b, mbsr_error *error)
{
    if (mbsr_model_nq(b->model) == plan->nq && mbsr_model_nu(b->model) == plan->nu) return MBSR_OK;
    return mbsri_fail_plain(error, MBSR_ERR_FILE,
                            "the model has %d coordinates and %d rates, its names are of %d and %d",
                            mbsr_model_nq(b->model), mbsr_model_nu(b->model), plan->nq, plan->nu);
}

int mbsri_build(const mbsri_unit_plan *plan, const double *input, const double *t0,
                mbsri_built *built, mbsr_error *error)
{
    *built = (mbsri_built){.model = NULL};
    mbsr_model_def def = mbsr_default_model_def();
    def.rank_tolerance = plan->rank_tolerance;
    int status = make_parts(plan, input, t0, built, error);
    if (!status) status = mbsr_model_create(&def, &built->model, error);
    if (!status) {
        status = add_bodies(plan, built, input);
        if (!status) status = add_plan_elements(plan, built, input);
        if (!status) status = mbsr_model_finish(built->model);
        told(built, status, error);
    }
    if (!status) status = check_sizes(plan, built, error);
    if (!status) status = mbsr_parameters_create(built->model, &built->list, error);
    if (status) mbsri_built_destroy(built);
    return status;
}

void mbsri_built_destroy(mbsri_built *built)
{
    mbsr_model_destroy(built->model);
    mbsr_parameters_destroy(built->list);
    for (int k = 0; k < built->tables; ++k) mbsr_table_destroy(built->table[k]);
    for (int k = 0; k < built->flexes; ++k) mbsr_flex_destroy(built->flex[k]);
    for (int k = 0; k < built->objects; ++k) mbsr_contacts_destroy(built->contacts[k]);
    free(built->table);
    free(built->flex);
    free(built->contacts);
    free(built->motion);
    *built = (mbsri_built){.model = NULL};
}
