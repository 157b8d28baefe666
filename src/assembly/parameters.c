/* The list of a model's parameters: names, units, places.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Grammar of names: identifiers separated by points; what is none stands between quotes, in which '
 * and \ are written \' and \\; the number of one of several follows in brackets, from 1. */
#include "assembly/parameters.h"

#include "assembly/tables.h"
#include "base/error.h"
#include "base/memory.h"
#include "joints/chain.h"
#include "joints/planar.h"
#include "model/query.h"

#include <string.h>

/* Tables of more numbers are not listed. */
enum { MOST_ENTRIES = 1024 };

/* ---- names ---- */

static bool is_name_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_plain_name(const char *label)
{
    if (!is_name_letter(*label)) return false;
    while (is_name_letter(*label) || (*label >= '0' && *label <= '9')) ++label;
    return !*label;
}

/* Copies the label, in quotes where it is none of the language's; returns behind it. What is no
 * printable character of ASCII becomes ?. */
static char *put_label(const char *label, char *to)
{
    const bool plain = is_plain_name(label);
    if (!plain) *to++ = '\'';
    for (; *label; ++label) {
        if (*label == '\'' || *label == '\\') *to++ = '\\';
        *to++ = *label >= ' ' && *label <= '~' && *label != '"' ? *label : '?';
    }
    if (!plain) *to++ = '\'';
    return to;
}

/* What is being listed: the owner, and what names of its parameters begin with. */
typedef struct lister {
    mbsr_parameters *list;
    const char *group, *label;
    mbsr_parameter_owner owner;
    int id;
    char made[24]; /* label of an owner without a name */
} lister;

static void begin_owner(lister *l, mbsr_parameter_owner owner, int id, size_t name)
{
    static const char *const groups[] = {"bodies", "forces", "closures", "tables"},
                             *const parts[] = {"body", "force", "closure", "table"};
    const char *given = (const char *)l->list->base->stored.names.data + name;
    l->group = groups[owner];
    l->owner = owner;
    l->id = id;
    mbsri_print(l->made, sizeof l->made, "%s%d", parts[owner],
                owner == MBSR_PARAMETER_TABLE ? id + 1 : id);
    l->label = *given ? given : l->made;
}

/* One parameter `part`, entry `index` of several (number from 1 in its name; 0: of one). */
static bool add_parameter(lister *l, mbsr_parameter_part part, int place, const char *name,
                          int number, const char *unit, const char *description, double value)
{
    mbsr_parameters *list = l->list;
    const mbsr_allocator *allocator = &list->base->allocator;
    const size_t size = strlen(l->group) + 2 * strlen(l->label) + strlen(name) + 40;
    if (!mbsri_reserve(allocator, &list->text, size, 1) ||
        !mbsri_reserve(allocator, &list->all, 1, sizeof(mbsri_parameter)))
        return false;
    char *first = (char *)list->text.data + list->text.count, *at = first;
    at += mbsri_print(at, size, "%s.", l->group);
    at = put_label(l->label, at);
    at += mbsri_print(at, size - (size_t)(at - first), ".%s", name);
    if (number > 0) at += mbsri_print(at, size - (size_t)(at - first), "[%d]", number);
    ((mbsri_parameter *)list->all.data)[list->all.count++] =
        (mbsri_parameter){.info = {.unit = unit,
                                   .description = description,
                                   .owner = l->owner,
                                   .id = l->id,
                                   .part = part,
                                   .index = number > 0 ? number - 1 : 0,
                                   .value = value},
                          .name = list->text.count,
                          .place = place};
    list->text.count += (size_t)(at - first) + 1;
    return true;
}

/* ---- bodies ---- */

static bool add_inertia(lister *l, const mbsri_body_entry *entry)
{
    static const char *const tensor[] = {"Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"};
    const mbsr_inertia *i = &entry->inertia;
    const bool rigid = i->kind == MBSR_INERTIA_SPATIAL, flat = i->kind == MBSR_INERTIA_PLANAR;
    if (entry->neglected > 0 || !(rigid || flat || i->kind == MBSR_INERTIA_PARTICLE)) return true;
    bool good = add_parameter(l, MBSR_PARAMETER_MASS, 0, "mass", 0, "kg", "mass", i->mass);
    for (int k = 0; k < (rigid ? 3 : flat ? 2 : 0) && good; ++k)
        good = add_parameter(l, MBSR_PARAMETER_COM, k, "com", k + 1, "m",
                             "centre of mass in body axes", i->com[k]);
    for (int k = 0; k < 6 && rigid && good; ++k) {
        good = add_parameter(l, MBSR_PARAMETER_TENSOR, k, tensor[k], 0, "kg.m2",
                             "tensor about the centre of mass", i->tensor[k]);
        if (good) ((mbsri_parameter *)l->list->all.data)[l->list->all.count - 1].info.index = k;
    }
    if (flat && good)
        good = add_parameter(l, MBSR_PARAMETER_MOMENT, 0, "I", 0, "kg.m2",
                             "moment of inertia about the centre of mass", i->moment);
    return good;
}

static bool add_armatures(lister *l, const mbsri_body_entry *entry)
{
    static const char *const units[] = {"", "kg.m2", "kg"};
    const mbsri_joint *joint = &entry->joint;
    const double *numbers = l->list->base->stored.matrices.data;
    bool good = true;
    if (joint->table->coordinate_rates && joint->table->position != mbsri_chain_position)
        return true;
    for (int k = 0; k < joint->n && good; ++k)
        good = add_parameter(l, MBSR_PARAMETER_ARMATURE, k, "armature", joint->n > 1 ? k + 1 : 0,
                             units[mbsri_joint_kind(joint, true, k)], "inertia along a joint rate",
                             entry->armature > 0 ? numbers[entry->armature + (size_t)k] : 0.0);
    return good;
}

static bool add_origins(lister *l, const mbsri_body_entry *entry)
{
    static const char *const on_A = "origin of the joint on the predecessor",
                             *const on_B = "origin of the joint on the body",
                             *const turn = "angle of the joint's frame";
    const double *param = (const double *)l->list->base->stored.matrices.data + entry->param;
    const mbsr_parameter_part part = MBSR_PARAMETER_JOINT;
    int free;
    const bool flat = mbsri_planar_coordinates(entry->joint.table, entry->joint.option, &free);
    bool good = true;
    if (!flat && entry->joint.table->position != mbsri_chain_position) return true;
    const int n = flat ? 2 : 3, B = flat ? 3 : MBSRI_B;
    const bool point = entry->joint.space == MBSR_SPACE_POINT; /* it has no frame B */
    for (int k = 0; k < n && good; ++k)
        good = add_parameter(l, part, k, "joint_position", k + 1, "m", on_A, param[k]);
    for (int k = 0; k < n && !point && good; ++k)
        good = add_parameter(l, part, B + k, "joint_offset", k + 1, "m", on_B, param[B + k]);
    if (flat && good) good = add_parameter(l, part, 2, "joint_angle", 0, "rad", turn, param[2]);
    if (!flat || point) return good;
    return good && add_parameter(l, part, 5, "offset_angle", 0, "rad", turn, param[5]);
}

/* ---- laws of force elements ---- */

/* What an element acts along: by the coordinate, or the place among six. OTHER: not known here. */
static mbsr_coordinate_kind kind_of_law(const mbsr_model *base, const mbsri_force *force, int index)
{
    const char *table = force->def.table->name;
    const int body = ((const int *)base->stored.lists.data)[force->list];
    const mbsri_body_entry *entry = base->entries.data;
    if (strcmp(table, "bushing") == 0)
        return index <= 3 ? MBSR_COORDINATE_ROTATION : MBSR_COORDINATE_TRANSLATION;
    if (strcmp(table, "joint rotation spring-damper") == 0 || strstr(table, "bearing"))
        return MBSR_COORDINATE_ROTATION;
    if (strncmp(table, "point", 5) == 0) return MBSR_COORDINATE_TRANSLATION;
    if (strncmp(table, "joint", 5) != 0 || body < 0) return MBSR_COORDINATE_OTHER;
    return mbsri_joint_kind(&entry[body].joint, true, force->def.option[0]);
}

/* "" where it depends on more than is known here. */
static const char *unit_of_law(const mbsr_model *base, const mbsri_force *force, const char *name,
                               int index)
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
    if (strcmp(force->def.table->name, "gravity") == 0) return "m/s2";
    if (force->def.bodies < 1 || (strcmp(name, "rest") == 0 && index > 0)) return "";
    const mbsr_coordinate_kind kind = kind_of_law(base, force, index);
    if (kind == MBSR_COORDINATE_OTHER) return "";
    for (size_t k = 0; k < sizeof units / sizeof *units; ++k)
        if (strcmp(name, units[k].name) == 0)
            return kind == MBSR_COORDINATE_ROTATION ? units[k].about : units[k].along;
    return "";
}

/* " (stiffness[2])" as name and number, 3; false: it has no such name. Frames are not to be changed
 * entry by entry. */
static bool read_law(const char *text, char name[40], int *number)
{
    const size_t length = strcspn(text + (*text ? 2 : 0), "[)");
    if (!*text || length >= 40 || strcspn(text, ",.") < strlen(text)) return false;
    memcpy(name, text + 2, length);
    name[length] = '\0';
    *number = 0;
    const char *digits = text + 2 + length;
    if (*digits != '[') return true;
    for (++digits; *digits >= '0' && *digits <= '9'; ++digits)
        *number = 10 * *number + (*digits - '0');
    ++*number;
    return true;
}

static bool add_law(lister *l, const mbsri_force *force)
{
    const mbsr_force_table *table = force->def.table;
    bool good = true;
    for (int k = 0; k < MBSR_FORCE_PARAMS && table->parameter && good; ++k) {
        char name[40];
        int number;
        const char *text = table->parameter(k);
        if (!text || !read_law(text, name, &number)) continue;
        good = add_parameter(l, MBSR_PARAMETER_LAW, k, name, number,
                             unit_of_law(l->list->base, force, name, number), table->name,
                             force->def.param[k]);
    }
    return good;
}

/* ---- closures and tables ---- */

static bool add_stiff_rows(lister *l, const mbsr_closure_def *def)
{
    bool good = true;
    for (int k = 0; k < MBSR_CLOSURE_ROWS && good; ++k) {
        if (!(def->stiffness[k] > 0.0)) continue;
        good = add_parameter(l, MBSR_PARAMETER_STIFFNESS, k, "stiffness", k + 1, "",
                             "of a stiff row", def->stiffness[k]) &&
               add_parameter(l, MBSR_PARAMETER_DAMPING, k, "damping", k + 1, "", "of a stiff row",
                             def->damping[k]);
    }
    return good;
}

/* A table where it is found for the first time. */
static bool add_table(lister *l, const mbsr_table *table)
{
    mbsri_array *found = &l->list->table;
    const mbsr_table **all = found->data;
    mbsr_table_def def;
    if (!table) return true;
    for (size_t k = 0; k < found->count; ++k)
        if (all[k] == table) return true;
    if (!mbsri_reserve(&l->list->base->allocator, found, 1, sizeof table)) return false;
    ((const mbsr_table **)found->data)[found->count] = table;
    begin_owner(l, MBSR_PARAMETER_TABLE, (int)found->count++, 0);
    mbsr_table_definition(table, &def);
    const int entries = def.points * def.columns;
    bool good = true;
    if (def.points > MOST_ENTRIES || entries > MOST_ENTRIES) return true;
    for (int k = 0; k < def.points && good; ++k)
        good =
            add_parameter(l, MBSR_PARAMETER_POINT, k, "x", k + 1, "", "point of a table", def.x[k]);
    for (int k = 0; k < entries && good; ++k)
        good = add_parameter(l, MBSR_PARAMETER_TABLE_VALUE, k, "value", k + 1, "",
                             "entry of a table, point by point", def.value[k]);
    return good;
}

static bool add_all(mbsr_parameters *list)
{
    const mbsr_model *base = list->base;
    const mbsri_body_entry *body = base->entries.data;
    const mbsri_force *force = base->forces.data;
    const mbsri_closure *closure = base->closures.data;
    lister l = {.list = list};
    bool good = true;
    for (size_t k = 0; k < base->entries.count && good; ++k) {
        begin_owner(&l, MBSR_PARAMETER_BODY, (int)k, body[k].name);
        good =
            add_inertia(&l, body + k) && add_armatures(&l, body + k) && add_origins(&l, body + k);
    }
    for (size_t k = 0; k < base->forces.count && good; ++k) {
        begin_owner(&l, MBSR_PARAMETER_FORCE, (int)k, force[k].name);
        good = add_law(&l, force + k);
    }
    for (size_t k = 0; k < base->closures.count && good; ++k) {
        begin_owner(&l, MBSR_PARAMETER_CLOSURE, (int)k, closure[k].name);
        good = add_stiff_rows(&l, &closure[k].def);
    }
    for (size_t k = 0; k < base->entries.count && good; ++k)
        good = add_table(&l, mbsri_joint_table_of(&body[k].joint));
    for (size_t k = 0; k < base->forces.count && good; ++k)
        good = add_table(&l, mbsri_force_table_of(&force[k].def));
    for (size_t k = 0; k < base->closures.count && good; ++k)
        good = add_table(&l, mbsri_closure_table_of(&closure[k].def));
    return good;
}

/* ---- the list ---- */

int mbsr_parameters_create(const mbsr_model *model, mbsr_parameters **list, mbsr_error *error)
{
    static const char function[] = "mbsr_parameters_create";
    if (list) *list = NULL;
    if (!model || !list)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          model ? "list" : "model");
    if (!model->finished)
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", function);
    mbsr_model *base;
    const int status = mbsr_model_copy(model, &base, error);
    if (status) return status;
    mbsr_parameters *made = mbsri_allocate(&base->allocator, sizeof *made);
    if (made) {
        *made = (mbsr_parameters){.base = base};
        if (add_all(made)) {
            *list = made;
            return MBSR_OK;
        }
        mbsr_parameters_destroy(made);
    } else {
        mbsr_model_destroy(base);
    }
    return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", function);
}

void mbsr_parameters_destroy(mbsr_parameters *list)
{
    if (!list) return;
    mbsr_model *base = list->base;
    mbsri_release(&base->allocator, list->all.data);
    mbsri_release(&base->allocator, list->text.data);
    mbsri_release(&base->allocator, list->table.data);
    mbsri_release(&base->allocator, list);
    mbsr_model_destroy(base);
}

int mbsr_parameters_count(const mbsr_parameters *list)
{
    return list ? (int)list->all.count : -1;
}

int mbsr_parameters_find(const mbsr_parameters *list, const char *name)
{
    if (!list || !name) return MBSR_NONE;
    const mbsri_parameter *all = list->all.data;
    for (size_t k = 0; k < list->all.count; ++k)
        if (strcmp((const char *)list->text.data + all[k].name, name) == 0) return (int)k;
    return MBSR_NONE;
}

int mbsr_parameter_get(const mbsr_parameters *list, int parameter, mbsr_parameter *out)
{
    if (!list || !out) return MBSR_ERR_NULL;
    if (parameter < 0 || (size_t)parameter >= list->all.count) return MBSR_ERR_ID;
    const mbsri_parameter *p = (const mbsri_parameter *)list->all.data + parameter;
    *out = p->info;
    out->name = (const char *)list->text.data + p->name;
    return MBSR_OK;
}
