/* Elements, closures and pairs: see source.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/front/source.h"

int mbsri_front_elements(const mbsri_front_source *from)
{
    const mbsr_model *m = from->model;
    return (int)(m->forces.count + m->closures.count) + (from->pairs ? from->pairs->count : 0);
}

bool mbsri_front_is_apart(const mbsri_front_source *from, int element)
{
    const int pair = element - (int)(from->model->forces.count + from->model->closures.count);
    return from->apart && pair >= 0 && from->apart[pair];
}

int mbsri_front_bodies(const mbsri_front_source *from, int element, const int **list)
{
    const mbsr_model *m = from->model;
    const int forces = (int)m->forces.count, pairs = forces + (int)m->closures.count;
    if (element < forces) {
        const mbsri_force *force = (const mbsri_force *)m->forces.data + element;
        const unsigned flags = force->def.table->flags;
        *list = m->stored.list_index + force->list;
        const bool apart =
            flags & MBSR_FORCE_EVERY_BODY || (flags & MBSR_FORCE_BY_PAIRS && from->pairs);
        return apart ? 0 : force->def.bodies;
    }
    if (element >= pairs) {
        *list = from->pairs->pair[element - pairs].body;
        return 2;
    }
    const mbsri_closure *c = (const mbsri_closure *)m->closures.data + element - forces;
    *list = c->body;
    return c->bodies;
}
