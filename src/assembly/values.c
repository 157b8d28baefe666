/* Models in which some parameters have other values: a copy of the definition, the numbers put into
 * it, checked as additions are, and finished.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/parameters.h"
#include "assembly/tables.h"
#include "base/error.h"
#include "base/memory.h"
#include "closures/rows.h"
#include "model/check.h"
#include "recursion/data.h"

#include <math.h>
#include <string.h>

double *mbsri_parameter_place(mbsr_model *m, const mbsri_parameter *p)
{
    mbsri_body_entry *body = (mbsri_body_entry *)m->entries.data + p->info.id;
    double *numbers = m->stored.matrices.data;
    switch (p->info.part) {
    case MBSR_PARAMETER_MASS: return &body->inertia.mass;
    case MBSR_PARAMETER_COM: return body->inertia.com + p->place;
    case MBSR_PARAMETER_TENSOR: return body->inertia.tensor + p->place;
    case MBSR_PARAMETER_MOMENT: return &body->inertia.moment;
    case MBSR_PARAMETER_ARMATURE:
        return body->armature > 0 ? numbers + body->armature + p->place : NULL;
    case MBSR_PARAMETER_JOINT: return numbers + body->param + p->place;
    case MBSR_PARAMETER_LAW:
        return ((mbsri_force *)m->forces.data)[p->info.id].def.param + p->place;
    case MBSR_PARAMETER_STIFFNESS:
        return ((mbsri_closure *)m->closures.data)[p->info.id].def.stiffness + p->place;
    case MBSR_PARAMETER_DAMPING:
        return ((mbsri_closure *)m->closures.data)[p->info.id].def.damping + p->place;
    case MBSR_PARAMETER_POINT:
    case MBSR_PARAMETER_TABLE_VALUE: break;
    }
    return NULL;
}

static const mbsri_parameter *parameter_of(const mbsr_parameters *list, int which)
{
    return (const mbsri_parameter *)list->all.data + which;
}

static bool differs(double a, double b)
{
    return a < b || a > b;
}

/* Puts a number into the definition; what tables have is for put_tables. */
static int put_value(mbsr_model *m, const mbsri_parameter *p, double value)
{
    mbsri_body_entry *body = (mbsri_body_entry *)m->entries.data + p->info.id;
    double *place = mbsri_parameter_place(m, p);
    if (p->info.part == MBSR_PARAMETER_ARMATURE && !place && value != 0.0) {
        const double none[MBSR_MAX_D] = {0.0};
        const int status = mbsr_model_armature(m, p->info.id, body->joint.n, none);
        if (status) return status;
        place = mbsri_parameter_place(m, p);
    }
    if (!place) return MBSR_OK;
    const bool digits = p->info.part == MBSR_PARAMETER_COM || p->info.part == MBSR_PARAMETER_TENSOR;
    if (digits && differs(*place, value)) body->inertia.exact = 0;
    *place = value;
    return MBSR_OK;
}

/* Table `id` of the list in a copy of its base, which has its own of those that the base owns. */
static const mbsr_table *table_in_copy(const mbsr_model *m, const mbsr_parameters *list, int id)
{
    const mbsr_table *table = ((const mbsr_table **)list->table.data)[id];
    mbsr_table *const *owned = list->base->stored.tables.data, *const *copied =
                                                                   m->stored.tables.data;
    for (size_t k = 0; k < list->base->stored.tables.count; ++k)
        if (owned[k] == table) return copied[k];
    return table;
}

/* The table with all numbers that are given for it. */
static int put_table(mbsr_model *m, const mbsr_parameters *list, int id, int count,
                     const int *which, const double *value)
{
    const mbsr_table *old = table_in_copy(m, list, id);
    mbsr_table_def def;
    mbsr_table_definition(old, &def);
    const size_t points = (size_t)def.points, entries = points * (size_t)def.columns;
    double *x = mbsri_allocate(&m->allocator, (points + entries) * sizeof *x);
    if (!x) return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "no memory");
    double *entry = x + points;
    memcpy(x, def.x, points * sizeof *x);
    memcpy(entry, def.value, entries * sizeof *entry);
    for (int k = 0; k < count; ++k) {
        const mbsri_parameter *p = parameter_of(list, which[k]);
        if (p->info.owner != MBSR_PARAMETER_TABLE || p->info.id != id) continue;
        (p->info.part == MBSR_PARAMETER_POINT ? x : entry)[p->place] = value[k];
    }
    def.x = x, def.value = entry;
    const int status = mbsri_table_replace(m, old, &def, &m->error);
    mbsri_release(&m->allocator, x);
    return status;
}

/* ---- checks ---- */

static const char *text_at(const mbsr_model *m, size_t name)
{
    return (const char *)m->stored.names.data + name;
}

static int recheck_body(mbsr_model *m, const mbsri_parameter *p)
{
    mbsri_body_entry *entry = (mbsri_body_entry *)m->entries.data + p->info.id;
    const double *numbers = m->stored.matrices.data;
    const int n = entry->joint.n, d = entry->joint.d, id = p->info.id;
    char label[MBSRI_LABEL];
    mbsri_label(label, "body", id, text_at(m, entry->name));
    if (p->info.part == MBSR_PARAMETER_ARMATURE) {
        double values[MBSR_MAX_D];
        if (entry->armature == 0) return MBSR_OK;
        memcpy(values, numbers + entry->armature, (size_t)n * sizeof *values);
        return mbsr_model_armature(m, id, n, values);
    }
    if (p->info.part == MBSR_PARAMETER_JOINT) {
        mbsr_joint joint = {MBSRI_JOINT_FIELDS(&entry->joint)};
        memcpy(joint.param, numbers + entry->param, (size_t)joint.params * sizeof *joint.param);
        memcpy(joint.option, entry->joint.option, sizeof joint.option);
        return mbsri_check_joint(m, &joint, id, label);
    }
    bool regular, added = false;
    int status =
        mbsri_check_inertia(m, &entry->inertia, entry->joint.space, d, id, label, &regular);
    if (!status && entry->added > 0) {
        const mbsr_inertia matrix = mbsr_inertia_matrix(d, numbers + entry->added);
        status = mbsri_check_inertia(m, &matrix, entry->joint.space, d, id, label, &added);
    }
    entry->regular = regular || added;
    return status;
}

static int recheck_force(mbsr_model *m, int id)
{
    const mbsri_force *force = (const mbsri_force *)m->forces.data + id;
    mbsr_force_def def = force->def;
    const int *bodies = def.bodies > 0 ? (const int *)m->stored.lists.data + force->list : NULL;
    char label[MBSRI_LABEL];
    for (int k = 0; k < def.bodies && k < 2; ++k) def.body[k] = bodies[k];
    def.body_list = def.bodies > 2 ? bodies : NULL;
    return mbsri_check_force(m, &def, id, mbsri_label(label, "force", id, text_at(m, force->name)));
}

static int recheck_closure(mbsr_model *m, int id)
{
    mbsri_closure *closure = (mbsri_closure *)m->closures.data + id;
    char label[MBSRI_LABEL];
    const int status = mbsri_check_closure(
        m, &closure->def, mbsri_label(label, "closure", id, text_at(m, closure->name)));
    if (!status) mbsri_stiff_axes(&closure->def);
    return status;
}

/* The owner of a parameter with all numbers that are given. */
static int check_owner(mbsr_model *m, const mbsri_parameter *p)
{
    switch (p->info.owner) {
    case MBSR_PARAMETER_BODY: return recheck_body(m, p);
    case MBSR_PARAMETER_FORCE: return recheck_force(m, p->info.id);
    case MBSR_PARAMETER_CLOSURE: return recheck_closure(m, p->info.id);
    case MBSR_PARAMETER_TABLE: break;
    }
    return MBSR_OK;
}

static int check_values(const mbsr_parameters *list, int count, const int *which,
                        const double *value, const char *function, mbsr_error *error)
{
    if (!list || (count > 0 && (!which || !value)))
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          !list    ? "list"
                          : !which ? "which"
                                   : "value");
    if (count < 0)
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "%s: count is %d", function,
                          count);
    for (int k = 0; k < count; ++k) {
        if (which[k] < 0 || (size_t)which[k] >= list->all.count)
            return mbsri_fail(error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                              "%s: which[%d] is %d, but there are %d parameters", function, k,
                              which[k], (int)list->all.count);
        if (!isfinite(value[k]))
            return mbsri_fail(
                error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "%s: %.100s is %g", function,
                (const char *)list->text.data + parameter_of(list, which[k])->name, value[k]);
    }
    return MBSR_OK;
}

/* Whether the table of parameter k has been made for an earlier one. */
static bool table_is_made(const mbsr_parameters *list, const int *which, int k)
{
    const int id = parameter_of(list, which[k])->info.id;
    for (int l = 0; l < k; ++l) {
        const mbsri_parameter *p = parameter_of(list, which[l]);
        if (p->info.owner == MBSR_PARAMETER_TABLE && p->info.id == id) return true;
    }
    return false;
}

/* ---- models and data ---- */

int mbsr_parameters_model(const mbsr_parameters *list, int count, const int *which,
                          const double *value, mbsr_model **model, mbsr_error *error)
{
    static const char function[] = "mbsr_parameters_model";
    if (!model)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: model is NULL",
                          function);
    *model = NULL;
    int status = check_values(list, count, which, value, function, error);
    if (status) return status;
    mbsr_model *made;
    status = mbsr_model_copy(list->base, &made, error);
    if (status) return status;
    for (int k = 0; k < count && !status; ++k) {
        const mbsri_parameter *p = parameter_of(list, which[k]);
        if (p->info.owner != MBSR_PARAMETER_TABLE)
            status = put_value(made, p, value[k]);
        else if (!table_is_made(list, which, k))
            status = put_table(made, list, p->info.id, count, which, value);
    }
    for (int k = 0; k < count && !status; ++k)
        status = check_owner(made, parameter_of(list, which[k]));
    if (!status) status = mbsr_model_finish(made);
    if (!status) {
        *model = made;
        return MBSR_OK;
    }
    if (error) *error = made->error;
    mbsr_model_destroy(made);
    return status;
}

int mbsr_parameters_data(const mbsr_parameters *list, int count, const int *which,
                         const double *value, mbsr_data **data, mbsr_error *error)
{
    if (!data)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_parameters_data: data is NULL");
    *data = NULL;
    mbsr_model *own;
    int status = mbsr_parameters_model(list, count, which, value, &own, error);
    if (status) return status;
    status = mbsr_data_create(own, data, error);
    if (status)
        mbsr_model_destroy(own);
    else
        (*data)->own = own;
    return status;
}
