/* The parts of a finished model as they were added.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "model/locked.h"
#include "model/query.h"

#include <string.h>

static const char *name_at(const mbsr_model *m, size_t name)
{
    return name > 0 ? (const char *)m->stored.names.data + name : NULL;
}

int mbsr_model_definition(const mbsr_model *model, mbsr_model_def *def)
{
    if (!model || !def) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    *def = (mbsr_model_def){.cookie = MBSRI_COOKIE,
                            .root = model->root,
                            .rank_tolerance = model->rank_tolerance,
                            .allocator = model->allocator};
    return MBSR_OK;
}

int mbsr_body_definition(const mbsr_model *model, int body, mbsr_body_def *def)
{
    if (!model || !def) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    if (body < 0 || body >= model->bodies) return MBSR_ERR_ID;
    const mbsri_body *b = model->body + model->index[body];
    const mbsri_body_entry *entry = (const mbsri_body_entry *)model->entries.data + body;
    const mbsri_joint *joint = &entry->joint;
    *def = mbsr_default_body_def();
    def->name = name_at(model, b->name);
    def->parent = entry->parent;
    def->inertia = b->inertia;
    def->joint = (mbsr_joint){MBSRI_JOINT_FIELDS(joint)};
    if (joint->params > 0)
        memcpy(def->joint.param, (const double *)model->stored.matrices.data + entry->param,
               (size_t)joint->params * sizeof *def->joint.param);
    memcpy(def->joint.option, joint->option, sizeof joint->option);
    return MBSR_OK;
}

int mbsr_force_definition(const mbsr_model *model, int force, mbsr_force_def *def)
{
    if (!model || !def) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const mbsri_force *all = model->forces.data;
    for (size_t k = 0; k < model->forces.count + model->elements.idle; ++k) {
        if (all[k].id != force) continue;
        mbsri_force_as_given(all + k, def);
        const int *list =
            def->bodies > 0 ? (const int *)model->stored.lists.data + all[k].list : NULL;
        def->name = name_at(model, all[k].name);
        for (int l = 0; l < 2; ++l) def->body[l] = l < def->bodies ? list[l] : MBSR_NONE;
        def->body_list = def->bodies > 2 ? list : NULL;
        return MBSR_OK;
    }
    return MBSR_ERR_ID;
}

int mbsr_closure_definition(const mbsr_model *model, int closure, mbsr_closure_def *def)
{
    if (!model || !def) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    if (!c) return MBSR_ERR_ID;
    *def = *mbsri_closure_as_given(model, c);
    def->name = name_at(model, c->name);
    return MBSR_OK;
}
