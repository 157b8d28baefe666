/* The variables of an FMU: see variables.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/variables.h"

#include "base/error.h"
#include "fmu/names.h"

#include <mbsrank/closure.h>

#include <stdlib.h>
#include <string.h>

/* What is being listed. */
typedef struct lister {
    mbsri_unit_plan *plan;
    const mbsr_model *model;
    const mbsr_parameters *parameters;
    mbsri_list list;
} lister;

static mbsri_variable *add_variable(lister *l, mbsri_variable_kind kind, int of, int component)
{
    mbsri_variable *v = mbsri_list_add(&l->plan->arena, &l->list, sizeof *v);
    if (!v) return NULL;
    *v = (mbsri_variable){.kind = kind,
                          .of = of,
                          .component = component,
                          .description = "",
                          .unit = "",
                          .derivative_of = -1};
    return v;
}

/* One more with its name; false: no memory. */
static bool add_named(lister *l, mbsri_variable v, const char *group, const char *label,
                      const char *part, int index)
{
    mbsri_variable *made = add_variable(l, v.kind, v.of, v.component);
    if (!made) return false;
    *made = v;
    made->name = mbsri_name(&l->plan->arena, group, label, part, index);
    if (!made->description) made->description = "";
    if (!made->unit) made->unit = "";
    return made->name != NULL;
}

static const char *part_label(lister *l, const char *part, const char *name, int id)
{
    return mbsri_fmu_label(&l->plan->arena, part, name, id);
}

/* ---- time, parameters, inputs, coordinates ---- */

static bool add_parameters(lister *l)
{
    for (int k = 0; k < mbsr_parameters_count(l->parameters); ++k) {
        mbsri_variable *v = add_variable(l, MBSRI_PARAMETER, k, 0);
        mbsr_parameter p;
        if (!v) return false;
        mbsr_parameter_get(l->parameters, k, &p);
        v->name = p.name;
        v->unit = p.unit;
        v->description = p.description;
        v->start = p.value;
    }
    return true;
}

static bool add_inputs(lister *l)
{
    for (int k = 0; k < l->plan->inputs; ++k) {
        const mbsri_plan_input *input = l->plan->input + k;
        mbsri_variable *v = add_variable(l, MBSRI_INPUT, k, 0);
        if (!v) return false;
        v->name = input->name;
        v->unit = input->unit;
        v->description = "held over a communication step";
        v->start = input->start;
    }
    return true;
}

/* Units by what a coordinate measures: other, rotation, translation. */
static bool add_coordinates(lister *l, mbsri_variable_kind kind, const char *part,
                            const char *const unit[3], const char *description, int derivative_of)
{
    const bool position = kind == MBSRI_Q || kind == MBSRI_QDOT;
    const mbsri_plan_coordinate *c = position ? l->plan->q : l->plan->u;
    for (int k = 0; k < (position ? l->plan->nq : l->plan->nu); ++k) {
        const mbsri_variable v = {.kind = kind,
                                  .of = k,
                                  .description = description,
                                  .unit = unit[c[k].kind >= 0 && c[k].kind < 3 ? c[k].kind : 0],
                                  .start = c[k].start,
                                  .derivative_of = derivative_of < 0 ? -1 : derivative_of + k};
        if (!add_named(l, v, "joints", c[k].joint, part, c[k].place)) return false;
    }
    return true;
}

/* States of model exchange are q and p. */
static bool add_states(lister *l, mbsri_variables *out)
{
    static const char *const p_units[3] = {"", "kg.m2/s", "kg.m/s"},
                             *const v_units[3] = {"", "rad/s", "m/s"},
                             *const f_units[3] = {"", "N.m", "N"};
    out->p_at = l->list.count;
    bool good = add_coordinates(l, MBSRI_P, "p", p_units, "generalised momentum", -1);
    out->derivatives_at = l->list.count;
    good = good && add_coordinates(l, MBSRI_QDOT, "qdot", v_units, "derivative of q", out->q_at);
    return good && add_coordinates(l, MBSRI_PDOT, "pdot", f_units, "derivative of p", out->p_at);
}

/* ---- outputs ---- */

static bool add_sites(lister *l)
{
    for (int k = 0; k < l->plan->sites; ++k) {
        const mbsri_plan_site *site = l->plan->site + k;
        const mbsr_space space = l->plan->body[site->body].def.joint.space;
        const char *label = part_label(l, "site", site->name, k + 1);
        for (int c = 0; c < (space == MBSR_SPACE_POINT ? 3 : 7); ++c) {
            const mbsri_variable v = {.kind = MBSRI_SITE,
                                      .of = k,
                                      .component = c,
                                      .description = c < 3 ? "position in the world"
                                                           : "quaternion (w, x, y, z) of its axes",
                                      .unit = c < 3 ? "m" : "",
                                      .derivative_of = -1};
            if (!add_named(l, v, "sites", label, c < 3 ? "x" : "e", c < 3 ? c + 1 : c - 2))
                return false;
        }
    }
    return true;
}

/* Wrenches of bodies in space: moment, then force. */
static const char *unit_of_load(mbsr_space space, int k)
{
    if (space == MBSR_SPACE_POINT) return "N";
    if (space == MBSR_SPACE_PLANAR) return k < 2 ? "N" : "N.m";
    if (space != MBSR_SPACE_SPATIAL && space != MBSR_SPACE_FLEXIBLE) return "";
    return k < 3 ? "N.m" : k < 6 ? "N" : "";
}

/* `rate`: where the rates of the body begin in u. */
static bool add_load(lister *l, mbsri_variable v, int count, const char *group, const char *label,
                     const char *part, mbsr_space space, int rate)
{
    for (int k = 0; k < count; ++k) {
        v.component = k;
        v.unit =
            v.kind == MBSRI_EFFORT ? mbsri_plan_effort(l->plan, rate + k) : unit_of_load(space, k);
        if (!add_named(l, v, group, label, part, k + 1)) return false;
    }
    return true;
}

/* On each body with shapes. */
static bool add_contacts(lister *l, int force, const mbsr_force_def *def)
{
    for (int k = 0; k < def->bodies; ++k) {
        const int body = (def->body_list ? def->body_list : def->body)[k];
        if (body < 0 || body >= l->plan->bodies) continue;
        const mbsri_plan_body *b = l->plan->body + body;
        const mbsri_variable v = {.kind = MBSRI_FORCE,
                                  .of = force,
                                  .place = k,
                                  .description = "what contacts exert on the body",
                                  .derivative_of = -1};
        if (!add_load(l, v, b->def.joint.d, "contacts", part_label(l, "body", b->def.name, body),
                      "f", b->def.joint.space, 0))
            return false;
    }
    return true;
}

static bool add_force_outputs(lister *l)
{
    for (int k = 0; k < l->plan->forces; ++k) {
        const mbsr_force_def *def = &l->plan->force[k].def;
        const unsigned flags = def->table->flags;
        if (flags & MBSR_FORCE_EVERY_BODY) continue;
        if (l->plan->force[k].link.kind == MBSRI_LINK_SHAPES) {
            if (!add_contacts(l, k, def)) return false;
            continue;
        }
        const int body = def->body_list ? def->body_list[0] : def->body[0];
        if (body < 0 || body >= l->plan->bodies) continue;
        int n = 0, rate = 0;
        const mbsr_joint *joint = &l->plan->body[body].def.joint;
        mbsr_body_coordinates(l->model, body, NULL, NULL, &rate, &n);
        const char *label = part_label(l, "force", def->name, k);
        const mbsri_variable f = {.kind = MBSRI_FORCE,
                                  .of = k,
                                  .description = "what it exerts on its first body",
                                  .derivative_of = -1},
                             tau = {.kind = MBSRI_EFFORT,
                                    .of = k,
                                    .description = "what it exerts along joint rates",
                                    .derivative_of = -1};
        if (!(flags & MBSR_FORCE_JOINT_ONLY) &&
            !add_load(l, f, joint->d, "forces", label, "f", joint->space, 0))
            return false;
        if (!(flags & MBSR_FORCE_NO_JOINT) &&
            !add_load(l, tau, n, "forces", label, "tau", joint->space, rate))
            return false;
    }
    return true;
}

static bool add_reactions(lister *l)
{
    for (int k = 0; k < l->plan->bodies; ++k) {
        const mbsr_joint *joint = &l->plan->body[k].def.joint;
        const mbsri_variable v = {.kind = MBSRI_REACTION,
                                  .of = k,
                                  .description = "what the joint exerts on the body",
                                  .derivative_of = -1};
        if (!add_load(l, v, joint->d, "reactions",
                      part_label(l, "body", l->plan->body[k].def.name, k), "f", joint->space, 0))
            return false;
    }
    for (int k = 0; k < mbsr_model_closures(l->model); ++k) {
        int row, rows;
        mbsr_closure_indices(l->model, k, &row, &rows, NULL, NULL);
        const char *label = part_label(l, "closure", mbsr_closure_name(l->model, k), k);
        for (int r = 0; r < rows; ++r) {
            const mbsri_variable v = {.kind = MBSRI_LOOP,
                                      .of = row + r,
                                      .description = "loop force of a row",
                                      .derivative_of = -1};
            if (!add_named(l, v, "closures", label, "lambda", r + 1)) return false;
        }
    }
    return true;
}

static bool add_energy(lister *l)
{
    const mbsri_variable v = {.unit = "J", .derivative_of = -1};
    mbsri_variable kinetic = v, potential = v;
    kinetic.kind = MBSRI_KINETIC;
    potential.kind = MBSRI_POTENTIAL;
    return add_named(l, kinetic, "energy", "kinetic", "", 0) &&
           add_named(l, potential, "energy", "potential", "", 0);
}

/* ---- event indicators: stops, contacts ---- */

static bool add_indicators(lister *l)
{
    for (int k = 0; k < l->plan->forces; ++k) {
        const mbsr_force_def *def = &l->plan->force[k].def;
        const bool stop = strcmp(def->table->name, "joint stop") == 0,
                   contact = strcmp(def->table->name, "contact") == 0;
        const char *label = part_label(l, "force", def->name, k);
        const mbsri_variable v = {.kind = MBSRI_INDICATOR, .of = k, .derivative_of = -1};
        mbsri_variable upper = v;
        upper.component = 1;
        if ((stop || contact) && !add_named(l, v, "events", label, stop ? "lower" : "contact", 0))
            return false;
        if (stop && !add_named(l, upper, "events", label, "upper", 0)) return false;
    }
    return true;
}

/* ---- all of them ---- */

static int order_of_names(const void *a, const void *b)
{
    const mbsri_variable *const *x = a, *const *y = b;
    const int order = strcmp((*x)->name, (*y)->name);
    return order ? order : (*x > *y) - (*x < *y);
}

/* Of several variables with the same name the later ones get another one. */
static bool make_unique(lister *l)
{
    mbsri_variable *v = l->list.items, **sorted = calloc((size_t)l->list.count, sizeof *sorted);
    if (!sorted) return false;
    for (int k = 0; k < l->list.count; ++k) sorted[k] = v + k;
    qsort(sorted, (size_t)l->list.count, sizeof *sorted, order_of_names);
    const char *last = l->list.count > 0 ? sorted[0]->name : "";
    bool good = true;
    for (int k = 1; k < l->list.count && good; ++k) {
        if (strcmp(sorted[k]->name, last) != 0) {
            last = sorted[k]->name;
            continue;
        }
        const size_t size = strlen(last) + 40;
        char *name = mbsri_arena_take(&l->plan->arena, size);
        good = name != NULL;
        if (good) mbsri_print(name, size, "variable%d.%s", (int)(sorted[k] - v), last);
        sorted[k]->name = name;
    }
    free(sorted);
    return good;
}

static bool add_all_variables(lister *l, mbsri_variables *out)
{
    static const char *const q_units[3] = {"", "rad", "m"},
                             *const u_units[3] = {"", "rad/s", "m/s"},
                             *const a_units[3] = {"", "rad/s2", "m/s2"};
    const int outputs = l->plan->outputs;
    mbsri_variable *time = add_variable(l, MBSRI_TIME, 0, 0);
    if (!time) return false;
    time->name = "time";
    time->unit = "s";
    bool good = add_parameters(l);
    out->parameters = l->list.count - 1;
    out->inputs_at = l->list.count;
    good = good && add_inputs(l);
    out->q_at = l->list.count;
    good = good && add_coordinates(l, MBSRI_Q, "q", q_units, "joint coordinate", -1);
    out->u_at = l->list.count;
    good = good && add_coordinates(l, MBSRI_U, "u", u_units, "joint rate", -1);
    out->udot_at = l->list.count;
    good = good && add_coordinates(l, MBSRI_UDOT, "a", a_units, "joint acceleration", -1);
    out->p_at = out->derivatives_at = -1;
    if (l->plan->model_exchange) good = good && add_states(l, out);
    if (outputs & MBSR_FMU_SITES) good = good && add_sites(l);
    if (outputs & MBSR_FMU_FORCES) good = good && add_force_outputs(l);
    if (outputs & MBSR_FMU_REACTIONS) good = good && add_reactions(l);
    if (outputs & MBSR_FMU_ENERGY) good = good && add_energy(l);
    out->indicators_at = l->list.count;
    good = good && add_indicators(l);
    out->indicators = l->list.count - out->indicators_at;
    return good;
}

bool mbsri_list_variables(mbsri_unit_plan *plan, const mbsri_built *built,
                          mbsri_variables *variables)
{
    lister l = {.plan = plan, .model = built->model, .parameters = built->list};
    *variables = (mbsri_variables){.list = NULL};
    if (!add_all_variables(&l, variables) || !make_unique(&l)) return false;
    variables->list = l.list.items;
    variables->count = l.list.count;
    return true;
}
