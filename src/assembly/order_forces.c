/* The order of the force elements in a finished model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/order_forces.h"

#include "base/error.h"
#include "forces/coordinate_laws.h"
#include "model/locked.h"

/* The first body a force element acts on, by index; 0 for none but the ground. */
static int first_body(const mbsr_model *m, size_t id)
{
    const mbsri_force *force = (const mbsri_force *)m->forces.data + id;
    int first = 0;
    for (int k = 0; k < force->def.bodies; ++k) {
        const int body = m->stored.list_index[force->list + (size_t)k];
        if (first == 0 || (body > 0 && body < first)) first = body;
    }
    return first;
}

/* The law of an element; of those that are closures, or rest, one behind all laws. */
static int law_of(const mbsri_force *force)
{
    return force->closure != MBSR_NONE || force->resting ? MBSRI_LAWS
                                                         : (int)mbsri_law_of(&force->def);
}

/* Elements of a law, in the order of the sweeps: by counting sort on the first body, to `sorted`;
 * count: N + 1 ints, how many act on each body. Returns how many there are. */
static size_t sort_law(const mbsr_model *m, int law, int N, int *count, mbsri_force *sorted)
{
    const mbsri_force *force = m->forces.data;
    int sum = 0;
    for (int i = 0; i <= N; ++i) count[i] = 0;
    for (size_t id = 0; id < m->forces.count; ++id)
        count[first_body(m, id)] += law_of(force + id) == law;
    for (int i = 0; i <= N; ++i) {
        const int here = count[i];
        count[i] = sum;
        sum += here;
    }
    for (size_t id = 0; id < m->forces.count; ++id) {
        if (law_of(force + id) == law) sorted[count[first_body(m, id)]++] = force[id];
    }
    return (size_t)sum;
}

/* Lists of bodies in the order of the elements, by index; those of ids likewise. */
static void order_lists(mbsr_model *m, mbsri_force *sorted, int *lists)
{
    size_t used = 0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const size_t list = sorted[k].list;
        sorted[k].list = used;
        for (int b = 0; b < sorted[k].def.bodies; ++b)
            lists[used++] = m->stored.list_index[list + (size_t)b];
    }
    for (size_t k = 0; k < used; ++k) ((int *)m->stored.lists.data)[k] = m->body[lists[k]].id;
}

/* The numbers of the elements on one coordinate, which are the last that are evaluated. */
static void collect_along(mbsr_model *m)
{
    mbsri_coordinate_elements *along = &m->elements.along;
    const size_t count = mbsri_coordinate_count(along);
    const mbsri_force *force = (const mbsri_force *)m->forces.data + (m->forces.count - count);
    for (size_t k = 0; k < count; ++k) {
        const mbsri_body *b = m->body + m->stored.list_index[force[k].list];
        const mbsr_force_def *def = &force[k].def;
        mbsri_coordinate_element *e = along->element + k;
        for (int l = 0; l < MBSRI_LAW_PARAMS; ++l) e->param[l] = def->param[l];
        e->option = def->option[1];
        e->q = b->iq + def->option[0];
        e->u = b->iu + def->option[0];
    }
}

int mbsri_order_forces(mbsr_model *m, int N, int *count)
{
    const size_t forces = m->forces.count;
    mbsri_coordinate_elements *along = &m->elements.along;
    mbsri_force *sorted = mbsri_allocate(&m->allocator, forces * sizeof *sorted);
    int *lists = mbsri_allocate(&m->allocator, m->stored.lists.count * sizeof *lists);
    along->element = mbsri_allocate(&m->allocator, forces * sizeof *along->element);
    if (!sorted || !lists || !along->element) {
        mbsri_release(&m->allocator, sorted);
        mbsri_release(&m->allocator, lists);
        return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_finish: no memory");
    }
    size_t placed = sort_law(m, MBSRI_LAW_NONE, N, count, sorted);
    m->elements.anywhere = count[0];
    for (int law = MBSRI_LAW_NONE + 1; law < MBSRI_LAWS; ++law) {
        const size_t here = sort_law(m, law, N, count, sorted + placed);
        along->first[law + 1] = along->first[law] + here;
        placed += here;
    }
    m->elements.idle = sort_law(m, MBSRI_LAWS, N, count, sorted + placed);
    const int *bodies = m->stored.lists.data; /* NULL where no element has a list */
    for (size_t k = 0; k < forces; ++k)
        mbsri_force_hold(m, sorted + k, bodies ? bodies + sorted[k].list : NULL);
    order_lists(m, sorted, lists);
    mbsri_release(&m->allocator, m->forces.data);
    mbsri_release(&m->allocator, m->stored.list_index);
    m->forces.data = sorted;
    m->forces.capacity = forces;
    m->forces.count = placed;
    m->stored.list_index = lists;
    collect_along(m);
    return MBSR_OK;
}
