/* The end of a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/memory.h"
#include "fronts/choose.h"
#include "sweeps/build.h"

void mbsr_model_destroy(mbsr_model *model)
{
    if (!model) return;
    const mbsr_allocator allocator = model->allocator;
    mbsri_release(&allocator, model->entries.data);
    mbsri_release(&allocator, model->forces.data);
    mbsri_release(&allocator, model->closures.data);
    mbsri_release(&allocator, model->stored.names.data);
    mbsri_release(&allocator, model->stored.matrices.data);
    mbsri_release(&allocator, model->stored.lists.data);
    mbsri_release(&allocator, model->given.inertias.data);
    mbsri_release(&allocator, model->given.closures.data);
    for (size_t k = 0; k < model->stored.tables.count; ++k)
        mbsr_table_destroy(((mbsr_table **)model->stored.tables.data)[k]);
    mbsri_release(&allocator, model->stored.tables.data);
    mbsri_release(&allocator, model->index);
    mbsri_release(&allocator, model->stored.list_index);
    mbsri_release(&allocator, model->armature);
    mbsri_release(&allocator, model->order.u_of);
    mbsri_release(&allocator, model->order.q_of);
    mbsri_release(&allocator, model->order.member);
    mbsri_release(&allocator, model->typical.inertia);
    mbsri_release(&allocator, model->typical.weight);
    mbsri_release(&allocator, model->typical.span);
    mbsri_release(&allocator, model->stand);
    mbsri_release(&allocator, model->stored.joint_param);
    mbsri_release(&allocator, model->elements.along.element);
    mbsri_sweeps_release(model);
    mbsri_plan_destroy(model, model->plan);
    mbsri_release(&allocator, model->body);
    mbsri_release(&allocator, model);
}
