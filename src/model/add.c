/* Adding bodies and force elements: validate, reserve, then commit, so that a refusal changes
 * nothing.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "closures/springs.h"
#include "model/check.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Rooms in the model that an addition needs besides its own entry. */
static bool reserve(mbsr_model *m, const char *name, size_t matrix, size_t list)
{
    return mbsri_reserve(&m->allocator, &m->stored.names, name ? strlen(name) + 1 : 0,
                         sizeof(char)) &&
           mbsri_reserve(&m->allocator, &m->stored.matrices, matrix, sizeof(double)) &&
           mbsri_reserve(&m->allocator, &m->stored.lists, list, sizeof(int));
}

static size_t store_name(mbsr_model *m, const char *name)
{
    if (!name || !name[0]) return 0;
    const size_t offset = m->stored.names.count, length = strlen(name) + 1;
    memcpy((char *)m->stored.names.data + offset, name, length);
    m->stored.names.count += length;
    return offset;
}

static size_t store_matrix(mbsr_model *m, size_t size, const double *matrix)
{
    const size_t offset = m->stored.matrices.count;
    if (size > 0) memcpy((double *)m->stored.matrices.data + offset, matrix, size * sizeof *matrix);
    m->stored.matrices.count += size;
    return offset;
}

static int check_open_model(mbsr_model *m, const void *def, const char *function)
{
    if (!def)
        return mbsri_fail(&m->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: the definition is NULL", function);
    if (m->finished) {
        return mbsri_fail(&m->error, MBSR_ERR_FINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is finished and cannot be changed", function);
    }
    return MBSR_OK;
}

static int check_body(mbsr_model *m, const mbsr_body_def *def, int id, const char *label,
                      bool *regular)
{
    if (def->cookie != MBSRI_COOKIE) {
        return mbsri_fail(&m->error, MBSR_ERR_NO_DEFAULT, id, MBSR_NONE,
                          "body %d: the definition was not made by mbsr_default_body_def", id);
    }
    if (def->parent < MBSR_GROUND) {
        return mbsri_fail(&m->error, MBSR_ERR_ID, id, MBSR_NONE,
                          "%s: parent is %d, neither a body nor MBSR_GROUND", label, def->parent);
    }
    if (def->parent == id) {
        return mbsri_fail(&m->error, MBSR_ERR_CYCLE, id, MBSR_NONE,
                          "%s: parent is %d, the body itself", label, def->parent);
    }
    const int status = mbsri_check_joint(m, &def->joint, id, label);
    return status ? status
                  : mbsri_check_inertia(m, &def->inertia, def->joint.space, def->joint.d, id, label,
                                        regular);
}

/* What the model keeps of a joint, but for its parameters. */
static mbsri_joint kept(const mbsr_joint *joint)
{
    mbsri_joint k = {MBSRI_JOINT_FIELDS(joint)};
    memcpy(k.option, joint->option, sizeof k.option);
    return k;
}

int mbsr_model_add_body(mbsr_model *model, const mbsr_body_def *def, int *id)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status = check_open_model(m, def, "mbsr_model_add_body");
    if (status) return status;
    if (m->entries.count >= INT_MAX - 1) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_add_body: too many bodies");
    }
    const int next = (int)m->entries.count;
    char label[MBSRI_LABEL];
    mbsri_label(label, "body", next, def->cookie == MBSRI_COOKIE ? def->name : NULL);
    bool regular = false;
    status = check_body(m, def, next, label, &regular);
    if (status) return status;

    const bool matrix = def->inertia.kind == MBSR_INERTIA_MATRIX && def->inertia.matrix;
    const size_t size = matrix ? (size_t)def->joint.d * (size_t)def->joint.d : 0;
    const size_t params = (size_t)def->joint.params;
    if (!reserve(m, def->name, size + params, 0) ||
        !mbsri_reserve(&m->allocator, &m->entries, 1, sizeof(mbsri_body_entry))) {
        return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, next, MBSR_NONE, "%s: no memory", label);
    }
    ((mbsri_body_entry *)m->entries.data)[m->entries.count++] = (mbsri_body_entry){
        .parent = def->parent,
        .name = store_name(m, def->name),
        .matrix = store_matrix(m, size, def->inertia.matrix),
        .param = store_matrix(m, params, def->joint.param),
        .joint = kept(&def->joint),
        .inertia = def->inertia,
        .regular = regular,
    };
    if (id) *id = next;
    return MBSR_OK;
}

static int check_force(mbsr_model *m, const mbsr_force_def *def, int id, const char *label)
{
    const mbsr_force_table *table = def->table;
    if (!table || table->version != MBSR_FORCE_TABLE_VERSION || !table->name || !table->evaluate) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, MBSR_NONE, id,
                          "%s: table is NULL, of another version, or lacks name or evaluate",
                          label);
    }
    const unsigned by_pairs = MBSR_FORCE_BY_PAIRS, apart = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT;
    if (table->flags & by_pairs && (!table->needs || !table->pairs || !table->derivatives ||
                                    (table->flags & apart) != apart)) {
        return mbsri_fail(
            &m->error, MBSR_ERR_VALUE, MBSR_NONE, id,
            "%s (%s): acts by pairs, but lacks needs, pairs, derivatives, or the flags "
            "MBSR_FORCE_NO_MASS and MBSR_FORCE_NO_JOINT",
            label, table->name);
    }
    int status = mbsri_check_scales(m, &table->scales, MBSR_NONE, id, label, table->name);
    if (status) return status;
    const bool every = (table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    if (def->bodies < 0 || (every && def->bodies != 0) ||
        (!every && def->bodies > 2 && !def->body_list)) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, MBSR_NONE, id, "%s (%s): bodies is %d%s",
                          label, table->name, def->bodies,
                          def->bodies > 2 ? ", but body_list is NULL" : "");
    }
    const int *list = def->body_list ? def->body_list : def->body;
    for (int k = 0; k < def->bodies; ++k) {
        if (list[k] < MBSR_GROUND) {
            return mbsri_fail(&m->error, MBSR_ERR_ID, MBSR_NONE, id,
                              "%s (%s): body number %d is %d, neither a body nor MBSR_GROUND",
                              label, table->name, k, list[k]);
        }
    }
    for (int k = 0; k < MBSR_FORCE_PARAMS; ++k) {
        if (!isfinite(def->param[k])) {
            return mbsri_fail(&m->error, MBSR_ERR_VALUE, MBSR_NONE, id,
                              "%s (%s): param[%d]%s is %g", label, table->name, k,
                              table->parameter ? table->parameter(k) : "", def->param[k]);
        }
    }
    char text[MBSR_TEXT_SIZE] = "";
    status = table->check_fields ? table->check_fields(def, text) : MBSR_OK;
    if (!status) status = mbsri_spring_check(def, text);
    if (!status) return MBSR_OK;
    return mbsri_fail(&m->error, status, MBSR_NONE, id, "%s (%s): %.150s", label, table->name,
                      text[0] ? text : mbsr_status_text(status));
}

int mbsr_model_add_force(mbsr_model *model, const mbsr_force_def *def, int *id)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status = check_open_model(m, def, "mbsr_model_add_force");
    if (status) return status;
    const int next = (int)m->forces.count;
    if (def->cookie != MBSRI_COOKIE) {
        return mbsri_fail(&m->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, next,
                          "force %d: the definition was not made by mbsr_default_force_def", next);
    }
    char label[MBSRI_LABEL];
    mbsri_label(label, "force", next, def->name);
    status = check_force(m, def, next, label);
    if (status) return status;

    if (!reserve(m, def->name, 0, (size_t)def->bodies) ||
        !mbsri_reserve(&m->allocator, &m->forces, 1, sizeof(mbsri_force))) {
        return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, next, "%s: no memory", label);
    }
    mbsri_force force = {.def = *def,
                         .id = next,
                         .name = store_name(m, def->name),
                         .list = m->stored.lists.count,
                         .closure = MBSR_NONE};
    const int *list = def->body_list ? def->body_list : def->body;
    for (int k = 0; k < def->bodies; ++k)
        ((int *)m->stored.lists.data)[m->stored.lists.count++] = list[k];
    force.def.name = NULL;
    force.def.body_list = NULL;
    ((mbsri_force *)m->forces.data)[m->forces.count++] = force;
    if (id) *id = next;
    return MBSR_OK;
}
