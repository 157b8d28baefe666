/* modelDescription.xml: what both versions of the standard have. See describe.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/describe.h"

#include "base/error.h"

#include <mbsrank/model.h>

#include <string.h>

bool mbsri_is_derivative(const mbsri_variable *v)
{
    return v->derivative_of >= 0;
}

bool mbsri_is_output(const mbsri_variable *v)
{
    switch (v->kind) {
    case MBSRI_TIME:
    case MBSRI_PARAMETER:
    case MBSRI_INPUT:
    case MBSRI_P:
    case MBSRI_QDOT:
    case MBSRI_PDOT:
    case MBSRI_INDICATOR: return false;
    default: return true;
    }
}

bool mbsri_has_start(const mbsri_variable *v)
{
    return v->kind == MBSRI_PARAMETER || v->kind == MBSRI_INPUT || v->kind == MBSRI_Q ||
           v->kind == MBSRI_U;
}

bool mbsri_is_initial_unknown(const mbsri_variable *v)
{
    return mbsri_is_output(v) || mbsri_is_derivative(v) || v->kind == MBSRI_P;
}

const char *mbsri_causality(const mbsri_variable *v)
{
    switch (v->kind) {
    case MBSRI_TIME: return "independent";
    case MBSRI_PARAMETER: return "parameter";
    case MBSRI_INPUT: return "input";
    default: return mbsri_is_output(v) ? "output" : "local";
    }
}

/* ---- units ---- */

typedef struct unit {
    const char *name;
    int kg, m, s, rad;
} unit;

static const unit units[] = {
    {"s", 0, 0, 1, 0},         {"kg", 1, 0, 0, 0},       {"m", 0, 1, 0, 0},
    {"rad", 0, 0, 0, 1},       {"m/s", 0, 1, -1, 0},     {"rad/s", 0, 0, -1, 1},
    {"m/s2", 0, 1, -2, 0},     {"rad/s2", 0, 0, -2, 1},  {"N", 1, 1, -2, 0},
    {"N.m", 1, 2, -2, 0},      {"J", 1, 2, -2, 0},       {"kg.m2", 1, 2, 0, 0},
    {"kg.m/s", 1, 1, -1, 0},   {"kg.m2/s", 1, 2, -1, 0}, {"N/m", 1, 0, -2, 0},
    {"N.m/rad", 1, 2, -2, -1}, {"N.s/m", 1, 0, -1, 0},   {"N.m.s/rad", 1, 2, -1, -1},
};

static bool is_used(const mbsri_variables *v, const char *name)
{
    for (int k = 0; k < v->count; ++k)
        if (v->list[k].unit && strcmp(v->list[k].unit, name) == 0) return true;
    return false;
}

static void put_exponent(mbsri_text *t, const char *name, int exponent)
{
    if (exponent != 0) mbsri_set_number(t, name, exponent);
}

/* Angles are shown in degrees: rad/s in deg/s. False: the unit is shown as it is. */
static bool shown_as(const char *name, char display[20])
{
    if (strncmp(name, "rad", 3) != 0) return false;
    mbsri_print(display, 20, "deg%s", name + 3);
    return true;
}

static void put_display(mbsri_text *t, const unit *u)
{
    char name[20];
    if (!shown_as(u->name, name)) return;
    mbsri_begin(t, "DisplayUnit");
    mbsri_set_text(t, "name", name);
    mbsri_set_number(t, "factor", 57.295779513082323);
    mbsri_end(t);
}

void mbsri_put_unit(mbsri_text *t, const mbsri_variable *v)
{
    char name[20];
    mbsri_set_text(t, "unit", v->unit);
    if (shown_as(v->unit, name)) mbsri_set_text(t, "displayUnit", name);
}

static void put_units(mbsri_text *t, const mbsri_described *d)
{
    mbsri_begin(t, "UnitDefinitions");
    mbsri_into(t);
    for (size_t k = 0; k < sizeof units / sizeof *units; ++k) {
        const unit *u = units + k;
        if (!is_used(d->variables, u->name)) continue;
        mbsri_begin(t, "Unit");
        mbsri_set_text(t, "name", u->name);
        mbsri_into(t);
        mbsri_begin(t, "BaseUnit");
        put_exponent(t, "kg", u->kg);
        put_exponent(t, "m", u->m);
        put_exponent(t, "s", u->s);
        put_exponent(t, "rad", u->rad);
        mbsri_end(t);
        put_display(t, u);
        mbsri_out(t, "Unit");
    }
    mbsri_out(t, "UnitDefinitions");
}

/* ---- categories, experiment ---- */

static void put_categories(mbsri_text *t)
{
    static const char *const categories[][2] = {
        {"logEvents", "starts, stops that are hit, changes of rank"},
        {"logStatusWarning", "warnings"},
        {"logStatusDiscard", "steps that are refused"},
        {"logStatusError", "errors"},
        {"logAll", "all of them"}};
    mbsri_begin(t, "LogCategories");
    mbsri_into(t);
    for (int k = 0; k < 5; ++k) {
        mbsri_begin(t, "Category");
        mbsri_set_text(t, "name", categories[k][0]);
        mbsri_set_text(t, "description", categories[k][1]);
        mbsri_end(t);
    }
    mbsri_out(t, "LogCategories");
}

void mbsri_describe_common(mbsri_text *t, const mbsri_described *d)
{
    put_units(t, d);
    put_categories(t);
    mbsri_begin(t, "DefaultExperiment");
    mbsri_set_number(t, "startTime", 0.0);
    mbsri_set_number(t, "stopTime", d->stop_time);
    mbsri_set_number(t, "tolerance", d->plan->steps.rtol);
    mbsri_set_number(t, "stepSize", d->step_size);
    mbsri_end(t);
}

/* ---- dependencies: known of joint coordinates, and of positions of sites ---- */

/* Numbers of the states q that a variable depends on, at most `most`; -1: on more than these. */
static int list_dependencies(const mbsri_described *d, const mbsri_variable *v, int first,
                             mbsri_arena *arena, double *list)
{
    const mbsri_unit_plan *p = d->plan;
    const bool states = d->variables->p_at >= 0;
    if (v->kind == MBSRI_Q) {
        if (states) list[0] = d->variables->q_at + v->of + first;
        return states ? 1 : 0;
    }
    if (v->kind != MBSRI_SITE || p->motions > 0) return -1;
    int count = 0, body = p->site[v->of].body;
    bool *found = mbsri_arena_take(arena, (size_t)p->nq + 1);
    if (!found) return -1;
    for (; body >= 0; body = p->body[body].def.parent) {
        int at, nq;
        mbsr_body_coordinates(d->model, body, &at, &nq, NULL, NULL);
        for (int k = 0; k < nq; ++k) found[at + k] = true;
    }
    for (int k = 0; k < p->nq && states; ++k)
        if (found[k]) list[count++] = d->variables->q_at + k + first;
    return count;
}

void mbsri_put_dependencies(mbsri_text *t, const mbsri_described *d, const mbsri_variable *v,
                            int first)
{
    double *list = mbsri_arena_take(t->arena, ((size_t)d->plan->nq + 1) * sizeof *list);
    const int count = list ? list_dependencies(d, v, first, t->arena, list) : -1;
    if (count < 0) return;
    mbsri_set_numbers(t, "dependencies", count, list);
    if (v->kind == MBSRI_Q && count > 0) mbsri_set_attribute(t, "dependenciesKind", "constant");
}
