/* Tables that a model owns.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/tables.h"

#include "base/error.h"
#include "base/memory.h"

int mbsri_table_replace(mbsr_model *m, const mbsr_table *old, const mbsr_table_def *def,
                        mbsr_error *error)
{
    mbsr_table *made;
    if (!mbsri_reserve(&m->allocator, &m->stored.tables, 1, sizeof(mbsr_table *)))
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "no memory");
    const int status = mbsr_table_create(def, &made, error);
    if (status) return status;
    ((mbsr_table **)m->stored.tables.data)[m->stored.tables.count++] = made;
    mbsri_body_entry *body = m->entries.data;
    for (size_t k = 0; k < m->entries.count; ++k)
        if (mbsri_joint_table_of(&body[k].joint) == old) body[k].joint.user = made;
    mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k)
        if (mbsri_force_table_of(&force[k].def) == old) force[k].def.user = made;
    mbsri_closure *closure = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k)
        if (mbsri_closure_table_of(&closure[k].def) == old) closure[k].def.user = made;
    return MBSR_OK;
}
