/* A copy of a model's definition.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/tables.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "model/locked.h"

#include <string.h>

/* Room for `count` elements in an array that is empty. */
static void *reserve_array(const mbsr_model *m, mbsri_array *array, size_t count, size_t element)
{
    if (!mbsri_reserve(&m->allocator, array, count, element)) return NULL;
    array->count = count;
    return array->data;
}

static bool duplicate(mbsr_model *m, const mbsri_array *from, mbsri_array *to, size_t element)
{
    if (from->count == 0) return true;
    if (!reserve_array(m, to, from->count, element)) return false;
    memcpy(to->data, from->data, from->count * element);
    return true;
}

/* Force elements by id, each with its list of ids; those that have become closures are elements. */
static bool copy_forces(const mbsr_model *m, mbsr_model *to)
{
    if (!m->finished)
        return duplicate(to, &m->forces, &to->forces, sizeof(mbsri_force)) &&
               duplicate(to, &m->stored.lists, &to->stored.lists, sizeof(int));
    const size_t count = m->forces.count + m->elements.idle;
    const mbsri_force *force = m->forces.data;
    mbsri_force *made = reserve_array(to, &to->forces, count, sizeof *made);
    int *list = reserve_array(to, &to->stored.lists, m->stored.lists.count, sizeof *list);
    if ((!made && count > 0) || (!list && m->stored.lists.count > 0)) return false;
    for (size_t k = 0; k < count; ++k) {
        mbsri_force *element = made + force[k].id;
        *element = force[k];
        mbsri_force_as_given(force + k, &element->def);
        element->closure = MBSR_NONE;
        for (size_t l = force[k].list; l < force[k].list + (size_t)force[k].def.bodies; ++l)
            list[l] = m->body[m->stored.list_index[l]].id;
    }
    return true;
}

/* Those that were added; others are made of force elements when the copy is finished. */
static bool copy_closures(const mbsr_model *m, mbsr_model *to)
{
    const mbsri_closure *closure = m->closures.data;
    if (m->closures.count == 0) return true;
    mbsri_closure *made = reserve_array(to, &to->closures, m->closures.count, sizeof *made);
    if (!made) return false;
    to->closures.count = 0;
    for (size_t k = 0; k < m->closures.count; ++k) {
        if (closure[k].force != MBSR_NONE) continue;
        made[to->closures.count++] = (mbsri_closure){.def = *mbsri_closure_as_given(m, closure + k),
                                                     .name = closure[k].name,
                                                     .force = MBSR_NONE,
                                                     .mixture = closure[k].mixture};
    }
    return true;
}

/* A model's own tables go with it, so a copy has its own. */
static bool copy_tables(const mbsr_model *m, mbsr_model *to)
{
    mbsr_table *const *table = m->stored.tables.data;
    for (size_t k = 0; k < m->stored.tables.count; ++k) {
        mbsr_table_def def;
        mbsr_table_definition(table[k], &def);
        if (mbsri_table_replace(to, table[k], &def, NULL)) return false;
    }
    return true;
}

static bool copy_all(const mbsr_model *m, mbsr_model *to)
{
    return duplicate(to, &m->stored.names, &to->stored.names, sizeof(char)) &&
           duplicate(to, &m->stored.matrices, &to->stored.matrices, sizeof(double)) &&
           duplicate(to, &m->given.inertias, &to->given.inertias, sizeof(mbsri_neglected)) &&
           duplicate(to, &m->entries, &to->entries, sizeof(mbsri_body_entry)) &&
           copy_forces(m, to) && copy_closures(m, to) && copy_tables(m, to);
}

int mbsr_model_copy(const mbsr_model *model, mbsr_model **copy, mbsr_error *error)
{
    if (!copy || !model) {
        if (copy) *copy = NULL;
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_model_copy: %s is NULL",
                          copy ? "model" : "copy");
    }
    const mbsr_model_def def = {.cookie = MBSRI_COOKIE,
                                .root = model->root,
                                .rank_tolerance = model->rank_tolerance,
                                .allocator = model->allocator};
    mbsr_model *made;
    const int status = mbsr_model_create(&def, &made, error);
    *copy = NULL;
    if (status) return status;
    made->stored.names.count = 0; /* what an empty model has stands in the copy's too */
    made->stored.matrices.count = 0;
    if (!copy_all(model, made)) {
        mbsr_model_destroy(made);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_copy: no memory");
    }
    *copy = made;
    return MBSR_OK;
}
