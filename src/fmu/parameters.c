/* Parameters: masses, laws of force elements, stiff rows, armature, entries of tables. See
 * parameters.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/parameters.h"

#include "base/error.h"
#include "fmu/names.h"
#include "fmu/stock.h"

#include <string.h>

/* Tables of more numbers are fixed. */
enum { MOST_ENTRIES = 1024 };

/* What a parameter is called, and its unit. */
typedef struct entry {
    const char *group, *label, *part;
    int index; /* 1, 2, ...; 0: none */
    const char *unit, *description;
    int exact_of; /* 1 and the body whose tensor loses its further digits by a change; 0: none */
} entry;

static bool add_parameter(mbsri_plan *plan, mbsri_list *list, const entry *e, double *place)
{
    mbsri_variable *v = mbsri_list_add(&plan->arena, list, sizeof *v);
    if (!v) return false;
    *v = (mbsri_variable){.kind = MBSRI_PARAMETER,
                          .name = mbsri_name(&plan->arena, e->group, e->label, e->part, e->index),
                          .description = e->description,
                          .unit = e->unit,
                          .of = e->exact_of,
                          .start = *place,
                          .place = place,
                          .derivative_of = -1};
    return v->name != NULL;
}

/* ---- bodies ---- */

static bool add_body_parameters(mbsri_plan *plan, mbsri_list *list, int id)
{
    static const char *const tensor[] = {"Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"};
    mbsri_plan_body *b = plan->body + id;
    mbsr_inertia *i = &b->def.inertia;
    entry e = {
        "bodies", mbsri_fmu_label(&plan->arena, "body", b->def.name, id), "mass", 0, "kg", "mass",
        0};
    const bool rigid = i->kind == MBSR_INERTIA_SPATIAL, flat = i->kind == MBSR_INERTIA_PLANAR;
    bool good = true;
    if (rigid || flat || i->kind == MBSR_INERTIA_PARTICLE)
        good = add_parameter(plan, list, &e, &i->mass);
    for (int k = 0; k < (rigid ? 3 : flat ? 2 : 0) && good; ++k) {
        e = (entry){e.group,           e.label, "com", k + 1, "m", "centre of mass in body axes",
                    rigid ? id + 1 : 0};
        good = add_parameter(plan, list, &e, i->com + k);
    }
    for (int k = 0; k < 6 && rigid && good; ++k) {
        e = (entry){e.group, e.label, tensor[k], 0, "kg.m2", "tensor about the centre of mass",
                    id + 1};
        good = add_parameter(plan, list, &e, i->tensor + k);
    }
    e = (entry){e.group, e.label, "I", 0, "kg.m2", "moment of inertia about the centre of mass", 0};
    if (flat && good) good = add_parameter(plan, list, &e, &i->moment);
    for (int k = 0; k < b->armatures && good; ++k) {
        e = (entry){e.group,    e.label,
                    "armature", b->armatures > 1 ? k + 1 : 0,
                    "",         "inertia along a joint rate",
                    0};
        good = add_parameter(plan, list, &e, b->armature + k);
    }
    return good;
}

/* ---- laws of force elements ---- */

/* What an element acts along: by the coordinate, or the place among six. MBSR_COORDINATE_OTHER: not
 * known here. */
static int kind_of_parameter(const mbsri_plan *plan, const mbsr_force_def *def, int index)
{
    const char *table = def->table->name;
    if (strcmp(table, "bushing") == 0)
        return index <= 3 ? MBSR_COORDINATE_ROTATION : MBSR_COORDINATE_TRANSLATION;
    if (strcmp(table, "joint rotation spring-damper") == 0 || strstr(table, "bearing"))
        return MBSR_COORDINATE_ROTATION;
    if (strncmp(table, "point", 5) == 0) return MBSR_COORDINATE_TRANSLATION;
    const int at =
        strncmp(table, "joint", 5) == 0 ? mbsri_plan_rate(plan, def->body[0], def->option[0]) : -1;
    return at >= 0 ? plan->u[at].kind : MBSR_COORDINATE_OTHER;
}

/* "" where it depends on more than is known here. */
static const char *parameter_unit(const mbsri_plan *plan, const mbsr_force_def *def,
                                  const char *name, int index)
{
    static const struct {
        const char *name, *along, *about;
    } units[] = {{"stiffness", "N/m", "N.m/rad"},
                 {"damping", "N.s/m", "N.m.s/rad"},
                 {"kp", "N/m", "N.m/rad"},
                 {"kd", "N.s/m", "N.m.s/rad"},
                 {"rest", "m", "rad"},
                 {"lower", "m", "rad"},
                 {"upper", "m", "rad"},
                 {"reference", "m", "rad"},
                 {"limit", "N", "N.m"},
                 {"free_length", "m", "m"},
                 {"radius", "m", "m"},
                 {"load", "N", "N"},
                 {"force", "N", "N.m"},
                 {"slip", "m/s", "rad/s"},
                 {"torque", "N.m", "N.m"}};
    if (strcmp(def->table->name, "gravity") == 0) return "m/s2";
    const int kind = kind_of_parameter(plan, def, index);
    if (kind == MBSR_COORDINATE_OTHER || (strcmp(name, "rest") == 0 && index > 0)) return "";
    for (size_t k = 0; k < sizeof units / sizeof *units; ++k)
        if (strcmp(name, units[k].name) == 0)
            return kind == MBSR_COORDINATE_ROTATION ? units[k].about : units[k].along;
    return "";
}

/* " (stiffness[2])" as name and index; false: it has no such name. Frames are not to be changed
 * entry by entry. */
static bool read_name(const char *text, char name[40], int *index)
{
    const size_t length = strcspn(text + (*text ? 2 : 0), "[)");
    if (!*text || length >= 40 || strcspn(text, ",.") < strlen(text)) return false;
    memcpy(name, text + 2, length);
    name[length] = '\0';
    *index = 0;
    const char *digits = text + 2 + length;
    if (*digits != '[') return true;
    for (++digits; *digits >= '0' && *digits <= '9'; ++digits)
        *index = 10 * *index + (*digits - '0');
    ++*index;
    return true;
}

static bool add_law(mbsri_plan *plan, mbsri_list *list, int id)
{
    mbsr_force_def *def = &plan->force[id].def;
    const char *label = mbsri_fmu_label(&plan->arena, "force", def->name, id);
    if (!label) return false;
    for (int k = 0; k < MBSR_FORCE_PARAMS && def->table->parameter; ++k) {
        char name[40];
        int index;
        const char *text = def->table->parameter(k);
        if (!text || !read_name(text, name, &index)) continue;
        const char *part = mbsri_arena_text(&plan->arena, name, strlen(name));
        if (!part) return false;
        const entry e = {
            "forces",         label, part, index, parameter_unit(plan, def, part, index),
            def->table->name, 0};
        if (!add_parameter(plan, list, &e, def->param + k)) return false;
    }
    return true;
}

/* ---- closures and tables ---- */

static bool add_row_parameters(mbsri_plan *plan, mbsri_list *list, int id)
{
    mbsr_closure_def *def = &plan->closure[id].def;
    const char *label = mbsri_fmu_label(&plan->arena, "closure", def->name, id);
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
        if (!(def->stiffness[k] > 0.0)) continue;
        const entry e[2] = {{"closures", label, "stiffness", k + 1, "", "of a stiff row", 0},
                            {"closures", label, "damping", k + 1, "", "of a stiff row", 0}};
        if (!add_parameter(plan, list, e, def->stiffness + k) ||
            !add_parameter(plan, list, e + 1, def->damping + k))
            return false;
    }
    return true;
}

/* The plan's own copy of an array, whose numbers may be changed. */
static bool own(mbsri_plan *plan, const double **array, size_t count)
{
    double *copy = mbsri_arena_take(&plan->arena, count * sizeof *copy);
    if (!copy) return false;
    memcpy(copy, *array, count * sizeof *copy);
    *array = copy;
    return true;
}

static bool add_entries(mbsri_plan *plan, mbsri_list *list, int id)
{
    mbsr_table_def *def = &plan->table[id].def;
    const char *label = mbsri_fmu_label(&plan->arena, "table", NULL, id + 1);
    const size_t points = (size_t)def->points, entries = points * (size_t)def->columns;
    if (entries > MOST_ENTRIES) return true;
    if (!own(plan, &def->x, points) || !own(plan, &def->value, entries)) return false;
    for (size_t k = 0; k < points + entries; ++k) {
        const bool x = k < points;
        const entry e = {"tables",
                         label,
                         x ? "x" : "value",
                         (int)(x ? k : k - points) + 1,
                         "",
                         x ? "point of a table" : "entry of a table, point by point",
                         0};
        if (!add_parameter(plan, list, &e, (double *)(x ? def->x + k : def->value + (k - points))))
            return false;
    }
    return true;
}

bool mbsri_list_parameters(mbsri_plan *plan, mbsri_list *list)
{
    bool good = true;
    for (int k = 0; k < plan->bodies && good; ++k) good = add_body_parameters(plan, list, k);
    for (int k = 0; k < plan->forces && good; ++k) good = add_law(plan, list, k);
    for (int k = 0; k < plan->closures && good; ++k) good = add_row_parameters(plan, list, k);
    for (int k = 0; k < plan->tables && good; ++k) good = add_entries(plan, list, k);
    return good;
}
