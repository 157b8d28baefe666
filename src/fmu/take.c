/* The plan of a model: its parts. See take.h; take_names.c has the names.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/take.h"

#include "base/error.h"
#include "fmu/stock.h"
#include "fmu/names.h"
#include "fmu/take_names.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

/* The model, where it goes, and what is growing there. */
typedef struct taker {
    mbsri_unit_plan *plan;
    const mbsr_model *model;
    const mbsr_file *file; /* may be NULL */
    mbsri_list tables, flexes, contacts, inputs, motions;
    mbsr_error *error;
} taker;

static int no_memory_for_plan(const taker *t)
{
    return mbsri_fail_plain(t->error, MBSR_ERR_NO_MEMORY,
                            "mbsr_fmu_export: no memory for the model");
}

/* A part by somebody's own function. */
static int refuse_part(const taker *t, const char *part, const char *name, int id, const char *why)
{
    return mbsri_fail_plain(t->error, MBSR_ERR_VALUE, "mbsr_fmu_export: %s %s%.60s%s (%d): %s",
                            part, name && *name ? "'" : "", name ? name : "",
                            name && *name ? "'" : "", id, why);
}

/* ---- what definitions link to; each is taken once ---- */

static int link_table(taker *t, const mbsr_table *table, mbsri_link *link)
{
    mbsri_plan_table *all = t->tables.items;
    link->kind = MBSRI_LINK_TABLE;
    for (link->index = 0; link->index < t->tables.count; ++link->index)
        if (all[link->index].from == table) return MBSR_OK;
    mbsri_plan_table *made = mbsri_list_add(&t->plan->arena, &t->tables, sizeof *made);
    if (!made) return no_memory_for_plan(t);
    made->from = table;
    return mbsr_table_definition(table, &made->def);
}

static int link_flex(taker *t, const mbsr_flex *flex, int *index)
{
    mbsri_plan_flex *all = t->flexes.items;
    for (*index = 0; *index < t->flexes.count; ++*index)
        if (all[*index].from == flex) return MBSR_OK;
    mbsri_plan_flex *made = mbsri_list_add(&t->plan->arena, &t->flexes, sizeof *made);
    if (!made) return no_memory_for_plan(t);
    made->from = flex;
    return mbsr_flex_definition(flex, &made->def);
}

static int link_shapes(taker *t, const mbsr_contacts *contacts, mbsri_link *link)
{
    mbsri_plan_shapes *all = t->contacts.items;
    link->kind = MBSRI_LINK_SHAPES;
    for (link->index = 0; link->index < t->contacts.count; ++link->index)
        if (all[link->index].from == contacts) return MBSR_OK;
    mbsri_plan_shapes *made = mbsri_list_add(&t->plan->arena, &t->contacts, sizeof *made);
    if (!made) return no_memory_for_plan(t);
    made->from = contacts;
    return mbsr_contacts_definition(contacts, &made->def);
}

/* `count` numbers that the caller holds. */
static int link_input(taker *t, const double *stored, int count, const mbsri_plan_input *as,
                      mbsri_link *link)
{
    mbsri_plan_input *all = t->inputs.items;
    link->kind = MBSRI_LINK_INPUT;
    for (link->index = 0; link->index < t->inputs.count; ++link->index)
        if (all[link->index].from == stored) return MBSR_OK;
    for (int k = 0; k < count; ++k) {
        mbsri_plan_input *made = mbsri_list_add(&t->plan->arena, &t->inputs, sizeof *made);
        if (!made) return no_memory_for_plan(t);
        *made = *as;
        made->name = mbsri_name(&t->plan->arena, "inputs", as->name, "", count > 1 ? k + 1 : 0);
        if (!made->name) return no_memory_for_plan(t);
        made->start = stored[k];
        made->from = stored + k;
    }
    return MBSR_OK;
}

/* The motion of a joint or a closure. */
static int link_motion(taker *t, mbsr_motion_fn motion, void *user, const char *name,
                       mbsri_link *link)
{
    static const char *const parts[] = {"s", "v", "a"};
    *link = (mbsri_link){.function = motion == mbsr_table_motion ? 1 : 2};
    if (motion == mbsr_table_motion) return link_table(t, user, link);
    const mbsr_fmu_motion *stored = user;
    mbsri_plan_motion *all = t->motions.items;
    link->kind = MBSRI_LINK_MOTION;
    for (link->index = 0; link->index < t->motions.count; ++link->index)
        if (all[link->index].from == stored) return MBSR_OK;
    mbsri_plan_motion *made = mbsri_list_add(&t->plan->arena, &t->motions, sizeof *made);
    if (!made) return no_memory_for_plan(t);
    *made = (mbsri_plan_motion){t->inputs.count, stored->count, stored};
    for (int k = 0; k < 3 * stored->count; ++k) {
        mbsri_plan_input *input = mbsri_list_add(&t->plan->arena, &t->inputs, sizeof *input);
        if (!input) return no_memory_for_plan(t);
        *input =
            (mbsri_plan_input){.name = mbsri_name(&t->plan->arena, "motions", name, parts[k % 3],
                                                  stored->count > 1 ? k / 3 + 1 : 0),
                               .unit = "",
                               .start = stored->value[k],
                               .range = {-INFINITY, INFINITY}};
        if (!input->name) return no_memory_for_plan(t);
    }
    return MBSR_OK;
}

static bool is_held(mbsr_motion_fn motion, const void *user)
{
    const mbsr_fmu_motion *stored = user;
    return motion == mbsr_fmu_stored_motion && stored && stored->count >= 1 &&
           stored->count <= MBSR_FMU_MOTION_MOST;
}

/* ---- bodies ---- */

/* Of all rates of the joint as given; of locked ones it is of no matter. None where all are zero.
 */
static void take_armature(const mbsr_model *m, int id, mbsri_plan_body *b)
{
    const double *left = mbsr_body_armature(m, id);
    bool any = false;
    b->armatures = b->joint_n;
    for (int k = 0, l = 0; k < b->joint_n; ++k) {
        b->armature[k] = b->locked_at && !isnan(b->locked_at[k]) ? 0.0 : left[l++];
        any = any || b->armature[k] > 0.0;
    }
    if (!any) b->armature = NULL, b->armatures = 0;
}

static int take_body(taker *t, int id, mbsri_plan_body *b)
{
    const mbsr_model *m = t->model;
    int status = mbsr_body_definition(m, id, &b->def);
    if (status) return mbsri_fail_plain(t->error, status, "mbsr_fmu_export: body %d", id);
    const mbsr_joint *j = &b->def.joint;
    const char *name = b->def.name;
    if (mbsri_fmu_joint_number(j->table) < 0)
        return refuse_part(t, "body", name, id, "its joint is of a table of functions of your own");
    if (j->motion && j->motion != mbsr_table_motion && !is_held(j->motion, j->user))
        return refuse_part(t, "body", name, id,
                           "its joint follows a function of your own; mbsr_table_motion and "
                           "mbsr_fmu_stored_motion can be taken along");
    if (b->def.inertia.kind == MBSR_INERTIA_FUNCTION)
        return refuse_part(t, "body", name, id, "its inertia is a function of your own");
    b->flex = -1;
    if (b->def.inertia.kind == MBSR_INERTIA_FLEXIBLE)
        status = link_flex(t, b->def.inertia.flex, &b->flex);
    if (!status && j->motion)
        status = link_motion(t, j->motion, j->user,
                             mbsri_fmu_label(&t->plan->arena, "body", name, id), &b->link);
    const int number = mbsri_fmu_joint_number(j->table);
    if (!status && mbsri_fmu_joint_user(number) == MBSRI_USER_FLEX) {
        b->link.kind = MBSRI_LINK_FLEX;
        status = link_flex(t, j->user, &b->link.index);
    }
    b->joint_n = j->n;
    b->locked_at = mbsr_body_locked(m, id);
    b->drops = mbsr_body_drops(m, id);
    b->added = mbsr_body_regularisation(m, id);
    b->armature = mbsri_arena_take(&t->plan->arena, ((size_t)j->n + 1) * sizeof *b->armature);
    if (!b->armature) return no_memory_for_plan(t);
    take_armature(m, id, b);
    return status;
}

/* ---- force elements ---- */

/* How many numbers a function of time writes for an element. */
static int numbers_of(const taker *t, const mbsr_force_def *def)
{
    const mbsr_force_def wrench = mbsr_force_wrench(0, NULL, 0, NULL, NULL),
                         joint = mbsr_force_joint_applied(0, NULL, NULL),
                         body = mbsr_force_applied(0, NULL, NULL),
                         servo = mbsr_force_joint_servo(0, 0, &(mbsr_servo){.kp = 0.0});
    int n = 0;
    if (def->table == wrench.table) return 6;
    if (def->table == servo.table) return 2;
    if (def->table == body.table) return mbsr_body_dimension(t->model, def->body[0]);
    if (def->table != joint.table) return 1;
    mbsr_body_coordinates(t->model, def->body[0], NULL, NULL, NULL, &n);
    return n;
}

/* An actuator of the file that has its control there: name and range. */
static const mbsr_file_actuator *actuator_of(const taker *t, int force)
{
    for (int k = 0; t->file && k < t->file->actuators; ++k)
        if (t->file->actuator[k].force == force) return t->file->actuator + k;
    return NULL;
}

static int link_force(taker *t, int id, mbsri_plan_force *f)
{
    const mbsr_force_def *def = &f->def;
    const mbsr_file_actuator *actuator = actuator_of(t, id);
    mbsri_plan_input as = {.unit = "", .range = {-INFINITY, INFINITY}};
    if (actuator && actuator->limited) memcpy(as.range, actuator->range, sizeof as.range);
    as.name = mbsri_fmu_label(&t->plan->arena, "force", actuator ? actuator->name : def->name, id);
    if (def->function == mbsr_table_force) {
        f->link.function = 1;
        return link_table(t, def->user, &f->link);
    }
    if (def->function == mbsr_stored_force) {
        f->link.function = 2;
        return link_input(t, def->user, numbers_of(t, def), &as, &f->link);
    }
    switch (mbsri_fmu_force_user(mbsri_fmu_force_number(def->table))) {
    case MBSRI_USER_FLEX:
        f->link.kind = MBSRI_LINK_FLEX;
        return link_flex(t, def->user, &f->link.index);
    case MBSRI_USER_TABLE: return link_table(t, def->user, &f->link);
    case MBSRI_USER_SHAPES: return link_shapes(t, def->user, &f->link);
    case MBSRI_USER_CONTROL:
        return def->user ? link_input(t, def->user, 1, &as, &f->link) : MBSR_OK;
    default: return MBSR_OK;
    }
}

static int take_force(taker *t, int id, mbsri_plan_force *f)
{
    mbsr_force_def *def = &f->def;
    const int status = mbsr_force_definition(t->model, id, def);
    if (status) return mbsri_fail_plain(t->error, status, "mbsr_fmu_export: force %d", id);
    if (mbsri_fmu_force_number(def->table) < 0)
        return refuse_part(t, "force", def->name, id, "it is of a table of functions of your own");
    if (def->spring)
        return refuse_part(t, "force", def->name, id, "its law is a function of your own");
    if (def->function && def->function != mbsr_table_force && def->function != mbsr_stored_force)
        return refuse_part(
            t, "force", def->name, id,
            "it is a function of your own; mbsr_table_force and mbsr_stored_force can be "
            "taken along");
    return link_force(t, id, f);
}

/* ---- closures ---- */

static bool was_force(const mbsr_model *m, int closure)
{
    for (int k = 0; k < mbsr_model_forces(m); ++k)
        if (mbsr_force_closure(m, k) == closure) return true;
    return false;
}

static int take_closure(taker *t, int id, mbsri_plan_closure *c)
{
    mbsr_closure_def *def = &c->def;
    const int status = mbsr_closure_definition(t->model, id, def);
    if (status) return mbsri_fail_plain(t->error, status, "mbsr_fmu_export: closure %d", id);
    if (mbsri_fmu_closure_number(def->table) < 0)
        return refuse_part(t, "closure", def->name, id,
                           "it is of a table of functions of your own");
    if (def->compliant > 0)
        return refuse_part(t, "closure", def->name, id,
                           "a model does not keep compliance matrices");
    if (!def->motion) return MBSR_OK;
    if (def->motion != mbsr_table_motion && !is_held(def->motion, def->user))
        return refuse_part(t, "closure", def->name, id,
                           "it follows a function of your own; mbsr_table_motion and "
                           "mbsr_fmu_stored_motion can be taken along");
    return link_motion(t, def->motion, def->user,
                       mbsri_fmu_label(&t->plan->arena, "closure", def->name, id), &c->link);
}

/* ---- all of it ---- */

static int take_parts(taker *t)
{
    mbsri_unit_plan *p = t->plan;
    const int closures = mbsr_model_closures(t->model);
    int status = MBSR_OK;
    p->body =
        mbsri_arena_take(&p->arena, (size_t)(mbsr_model_bodies(t->model) + 1) * sizeof *p->body);
    p->force =
        mbsri_arena_take(&p->arena, (size_t)(mbsr_model_forces(t->model) + 1) * sizeof *p->force);
    p->closure = mbsri_arena_take(&p->arena, (size_t)(closures + 1) * sizeof *p->closure);
    if (!p->body || !p->force || !p->closure) return no_memory_for_plan(t);
    for (; p->bodies < mbsr_model_bodies(t->model) && !status; ++p->bodies)
        status = take_body(t, p->bodies, p->body + p->bodies);
    for (; p->forces < mbsr_model_forces(t->model) && !status; ++p->forces)
        status = take_force(t, p->forces, p->force + p->forces);
    for (int k = 0; k < closures && !status; ++k) {
        if (was_force(t->model, k)) continue;
        status = take_closure(t, k, p->closure + p->closures++);
    }
    p->tables = t->tables.count, p->table = t->tables.items;
    p->flexes = t->flexes.count, p->flex = t->flexes.items;
    p->contacts = t->contacts.count, p->shapes = t->contacts.items;
    p->inputs = t->inputs.count, p->input = t->inputs.items;
    p->motions = t->motions.count, p->motion = t->motions.items;
    return status;
}

int mbsri_plan_take(mbsri_unit_plan *plan, const mbsr_model *model, const mbsr_fmu_opt *opt,
                    mbsr_error *error)
{
    taker t = {.plan = plan, .model = model, .file = opt->file, .error = error};
    mbsr_model_def def;
    mbsr_model_definition(model, &def);
    plan->rank_tolerance = def.rank_tolerance;
    if (def.root.motion || def.root.d > 0)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "mbsr_fmu_export: the root moves by a function");
    plan->steps.rtol = opt->rtol;
    plan->steps.atol = opt->atol;
    plan->steps.fixed_step = opt->fixed_step;
    plan->steps.order = opt->order;
    plan->outputs = opt->outputs;
    const int status = take_parts(&t);
    return status ? status : mbsri_take_names(plan, model, opt, error);
}
