/* A copy of a model's definition.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "model/record.h"

#include <string.h>

/* Room for `count` elements in an array that is empty. */
static void *take(const mbsr_model *m, mbsri_array *array, size_t count, size_t element)
{
    if (!mbsri_reserve(&m->allocator, array, count, element)) return NULL;
    array->count = count;
    return array->data;
}

static bool duplicate(mbsr_model *m, const mbsri_array *from, mbsri_array *to, size_t element)
{
    if (from->count == 0) return true;
    if (!take(m, to, from->count, element)) return false;
    memcpy(to->data, from->data, from->count * element);
    return true;
}

/* A body of a finished model as it was added. */
static mbsri_body_entry entry_of(const mbsr_model *m, const mbsri_body *b)
{
    const double *numbers = m->matrices.data;
    mbsri_body_entry entry = {.parent = m->body[b->parent].id,
                              .name = b->name,
                              .joint = b->joint,
                              .inertia = b->inertia,
                              .regular = b->regular,
                              .armature = b->armature_given,
                              .locks = b->locks,
                              .neglected = b->neglected};
    if (b->inertia.kind == MBSR_INERTIA_MATRIX && b->inertia.matrix)
        entry.matrix = (size_t)(b->inertia.matrix - numbers);
    if (b->neglected > 0)
        entry.matrix = ((const mbsri_neglected *)m->neglected.data)[b->neglected - 1].matrix;
    if (b->joint.params > 0) entry.param = (size_t)(b->joint.param - numbers);
    if (b->added) entry.added = (size_t)(b->added - numbers);
    if (b->held) entry.held = (size_t)(b->held - numbers);
    entry.joint.param = NULL;
    return entry;
}

static bool copy_bodies(const mbsr_model *m, mbsr_model *to)
{
    if (!m->finished) return duplicate(to, &m->entries, &to->entries, sizeof(mbsri_body_entry));
    if (m->bodies == 0) return true;
    mbsri_body_entry *entry = take(to, &to->entries, (size_t)m->bodies, sizeof *entry);
    if (!entry) return false;
    for (int id = 0; id < m->bodies; ++id) entry[id] = entry_of(m, m->body + m->index[id]);
    return true;
}

/* Force elements by id, each with its list of ids; those that have become closures are elements. */
static bool copy_forces(const mbsr_model *m, mbsr_model *to)
{
    if (!m->finished)
        return duplicate(to, &m->forces, &to->forces, sizeof(mbsri_force)) &&
               duplicate(to, &m->lists, &to->lists, sizeof(int));
    const size_t count = m->forces.count + m->carried;
    const mbsri_force *force = m->forces.data;
    mbsri_force *made = take(to, &to->forces, count, sizeof *made);
    int *list = take(to, &to->lists, m->lists.count, sizeof *list);
    if ((!made && count > 0) || (!list && m->lists.count > 0)) return false;
    for (size_t k = 0; k < count; ++k) {
        made[force[k].id] = force[k];
        made[force[k].id].closure = MBSR_NONE;
        for (size_t l = force[k].list; l < force[k].list + (size_t)force[k].def.bodies; ++l)
            list[l] = m->body[m->list_index[l]].id;
    }
    return true;
}

/* Those that were added; others are made of force elements when the copy is finished. */
static bool copy_closures(const mbsr_model *m, mbsr_model *to)
{
    const mbsri_closure *closure = m->closures.data;
    if (m->closures.count == 0) return true;
    mbsri_closure *made = take(to, &to->closures, m->closures.count, sizeof *made);
    if (!made) return false;
    to->closures.count = 0;
    for (size_t k = 0; k < m->closures.count; ++k) {
        if (closure[k].force != MBSR_NONE) continue;
        made[to->closures.count++] = (mbsri_closure){.def = closure[k].def,
                                                     .name = closure[k].name,
                                                     .force = MBSR_NONE,
                                                     .mixture = closure[k].mixture};
    }
    return true;
}

static bool copy_all(const mbsr_model *m, mbsr_model *to)
{
    return duplicate(to, &m->names, &to->names, sizeof(char)) &&
           duplicate(to, &m->matrices, &to->matrices, sizeof(double)) &&
           duplicate(to, &m->neglected, &to->neglected, sizeof(mbsri_neglected)) &&
           copy_bodies(m, to) && copy_forces(m, to) && copy_closures(m, to);
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
    made->names.count = 0; /* what an empty model has stands in the copy's too */
    made->matrices.count = 0;
    if (!copy_all(model, made)) {
        mbsr_model_destroy(made);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_copy: no memory");
    }
    *copy = made;
    return MBSR_OK;
}
