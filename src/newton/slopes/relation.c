/* How the bodies of a force element stand to each other in the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/slopes/relation.h"

#include "newton/slopes/force_slopes.h"

mbsri_relation mbsri_relate(const mbsr_model *m, int i, int j)
{
    if (i == 0 || j == 0) return MBSRI_APART;
    if (i == j) return MBSRI_SAME;
    if (m->body[i].parent == j) return MBSRI_BELOW;
    return m->body[j].parent == i ? MBSRI_ABOVE : MBSRI_APART;
}

bool mbsri_may_cross(const mbsr_model *m, const mbsri_force *force)
{
    const unsigned flags = force->def.table->flags;
    const int *bodies = m->stored.list_index + force->list;
    if (flags & MBSR_FORCE_EVERY_BODY) return false;
    for (int k = 0; k < force->def.bodies; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            if (bodies[k] == 0 || bodies[l] == 0 || bodies[k] == bodies[l]) continue;
            if (mbsri_relate(m, bodies[k], bodies[l]) == MBSRI_APART) return true;
            if (!(flags & MBSR_FORCE_NO_JOINT)) return true;
        }
    }
    return false;
}

void mbsri_slopes_shape(const mbsr_model *m, const mbsri_force *force, int *rows, int *columns)
{
    *rows = *columns = 0;
    for (int k = 0; k < force->def.bodies; ++k) {
        const mbsri_body *b = m->body + m->stored.list_index[force->list + (size_t)k];
        if (b->id == MBSR_GROUND) continue;
        *rows += b->d + b->n;
        *columns += mbsri_pose_size(b) + b->d + b->nq + b->n;
    }
}
