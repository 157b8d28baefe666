/* Parameters of which derivatives are asked for: which there are, and where they enter.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/seeds.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "model/query.h"

#include <string.h>

/* ---- where they enter ---- */

/* A seed more; without arrays it is counted alone. */
static void add_seed(mbsri_seeds *s, mbsri_seed_place place, size_t at, int count)
{
    if (count == 0) return;
    if (s->seed)
        s->seed[s->seeds] =
            (mbsri_seed){.place = place, .count = count, .at = at, .value = s->values};
    ++s->seeds;
    s->values += (size_t)count;
}

/* Of a body with V from v on: its momentum (0), the rate of that (1), its mu (2). */
static void add_action_seed(mbsri_seeds *s, int which, size_t v, int d)
{
    if (s->use == MBSRI_SEED_RESIDUAL)
        add_seed(s, MBSRI_SEED_ACTION, 3 * v + (size_t)(which * d), d);
    else
        add_seed(s, MBSRI_SEED_REACTION, v, d);
}

static void add_body_seeds(mbsri_seeds *s, const mbsri_linear *l, int i)
{
    const mbsri_body *b = l->model->body + i;
    if (i == 0) return;
    add_action_seed(s, 2, b->v, b->d);
    add_seed(s, MBSRI_SEED_TORQUE, (size_t)b->iu, b->n);
    if (s->use != MBSRI_SEED_RESIDUAL) return;
    add_action_seed(s, 1, b->v, b->d);
    add_action_seed(s, 0, b->v, b->d);
}

static void add_element_seeds(mbsri_seeds *s, const mbsri_linear *l, int k)
{
    const mbsr_model *m = l->model;
    const mbsri_force *force = mbsri_force_at(m, (size_t)k);
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    for (int i = 1; i <= m->bodies && every; ++i) add_body_seeds(s, l, i);
    for (int j = 0; j < force->def.bodies && !every; ++j)
        add_body_seeds(s, l, m->stored.list_index[force->list + (size_t)j]);
}

/* Of bodies that move with a frame of a joint. */
static void add_frame_seeds(mbsri_seeds *s, const mbsri_linear *l, const mbsri_seeded *p)
{
    const mbsr_model *m = l->model;
    for (int j = 1; j <= m->bodies; ++j) {
        const mbsri_body *b = m->body + j;
        if (!mbsri_rides(m, p->index, j)) continue;
        add_seed(s, MBSRI_SEED_MOTION, l->motion[j], l->e[j] + 2 * b->d);
        if (b->parent > 0) add_action_seed(s, 2, b->pred.v, b->pred.d);
        add_seed(s, MBSRI_SEED_LOAD, (size_t)b->u, b->n);
        if (s->use != MBSRI_SEED_RESIDUAL) continue;
        add_seed(s, MBSRI_SEED_PULSE, (size_t)b->u, b->n);
        add_seed(s, MBSRI_SEED_DRIFT, (size_t)b->u, b->n);
        for (int which = 1; which >= 0 && b->parent > 0; --which)
            add_action_seed(s, which, b->pred.v, b->pred.d);
    }
}

static void add_spring_seeds(mbsri_seeds *s, const mbsri_seeded *p, const mbsr_model *m, int place)
{
    const mbsri_closure *c = mbsri_closure_at(m, (size_t)p->index);
    add_seed(s, MBSRI_SEED_SPRING, (size_t)(c->row + place), 1);
    if (s->use != MBSRI_SEED_RESIDUAL || p->parameter.info.part != MBSR_PARAMETER_STIFFNESS) return;
    add_seed(s, MBSRI_SEED_ROW, (size_t)(c->row + place), 1);
    if (place < c->position_rows)
        add_seed(s, MBSRI_SEED_ROW, (size_t)(m->rows + c->position_row + place), 1);
}

static void lay_out_seeds(mbsri_seeds *s, const mbsri_linear *l)
{
    const mbsr_model *m = l->model;
    s->seeds = s->values = 0;
    for (int k = 0; k < s->count; ++k) {
        mbsri_seeded *p = s->of + k;
        const int place = p->parameter.place;
        p->first = s->seeds;
        switch (p->parameter.info.part) {
        case MBSR_PARAMETER_MASS:
        case MBSR_PARAMETER_COM:
        case MBSR_PARAMETER_TENSOR:
        case MBSR_PARAMETER_MOMENT: add_body_seeds(s, l, p->index); break;
        case MBSR_PARAMETER_ARMATURE: {
            const int u = mbsri_rate_as_given(m->body + p->index, place);
            const size_t at = (size_t)(m->body[p->index].u + u);
            if (u >= 0) add_seed(s, MBSRI_SEED_LOAD, at, 1);
            if (u >= 0 && s->use == MBSRI_SEED_RESIDUAL) add_seed(s, MBSRI_SEED_PULSE, at, 1);
            break;
        }
        case MBSR_PARAMETER_JOINT:
            if (s->use > 0)
                add_seed(s, MBSRI_SEED_MOTION, (size_t)p->index, s->use);
            else
                add_frame_seeds(s, l, p);
            break;
        case MBSR_PARAMETER_LAW:
            if (p->index >= 0) add_element_seeds(s, l, p->index);
            break;
        case MBSR_PARAMETER_STIFFNESS:
        case MBSR_PARAMETER_DAMPING: add_spring_seeds(s, p, m, place); break;
        case MBSR_PARAMETER_POINT:
        case MBSR_PARAMETER_TABLE_VALUE: break;
        }
        p->last = s->seeds;
    }
}

/* ---- which can be had ---- */

static int refuse_parameter(const mbsr_parameters *list, int which, const char *function,
                            const char *why, mbsr_error *error)
{
    mbsr_parameter p;
    mbsr_parameter_get(list, which, &p);
    return mbsri_fail(error, MBSR_ERR_SPACE, p.owner == MBSR_PARAMETER_BODY ? p.id : MBSR_NONE,
                      p.owner == MBSR_PARAMETER_FORCE ? p.id : MBSR_NONE, "%s: %.100s: %s",
                      function, p.name, why);
}

/* The element of that id among those that are evaluated; -1: it rests. */
static int index_of_element(const mbsr_model *m, int id, bool *is_closure)
{
    const size_t all = m->forces.count + m->elements.idle;
    *is_closure = false;
    for (size_t k = 0; k < all; ++k) {
        const mbsri_force *force = mbsri_force_at(m, k);
        if (force->id != id) continue;
        *is_closure = !force->resting && k >= m->forces.count;
        return k < m->forces.count ? (int)k : -1;
    }
    return -1;
}

/* An element that reads masses and is not one on every body. */
static const mbsri_force *reader_of_mass(const mbsr_model *m, int i)
{
    const unsigned blind = MBSR_FORCE_NO_MASS | MBSR_FORCE_JOINT_ONLY | MBSR_FORCE_EVERY_BODY;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsri_force *force = mbsri_force_at(m, k);
        if (force->def.table->flags & blind) continue;
        for (int j = 0; j < force->def.bodies; ++j)
            if (m->stored.list_index[force->list + (size_t)j] == i) return force;
    }
    return NULL;
}

/* Finds the owner of parameter `which` of the list. */
static int choose_parameter(mbsri_seeded *p, const mbsr_model *m, const mbsr_parameters *list,
                            int which, const char *function, mbsr_error *error)
{
    p->parameter = ((const mbsri_parameter *)list->all.data)[which];
    const mbsr_parameter *told = &p->parameter.info;
    if (told->owner == MBSR_PARAMETER_TABLE)
        return refuse_parameter(list, which, function, "there are no derivatives in tables", error);
    if (told->owner == MBSR_PARAMETER_BODY) {
        p->index = mbsri_index(m, told->id);
        const bool inertia = told->part <= MBSR_PARAMETER_MOMENT;
        if (inertia && reader_of_mass(m, p->index))
            return refuse_parameter(list, which, function,
                                    "a force element on the body reads its mass matrix", error);
    } else if (told->owner == MBSR_PARAMETER_FORCE) {
        bool is_closure;
        p->index = index_of_element(m, told->id, &is_closure);
        if (is_closure)
            return refuse_parameter(list, which, function,
                                    "the element is a closure, of which there are no derivatives",
                                    error);
    } else {
        const mbsri_closure *c = mbsri_closure_at(m, (size_t)told->id);
        p->index = told->id;
        if (c->mix || c->given > 0)
            return refuse_parameter(list, which, function,
                                    "its rows are not those of the closure as given", error);
    }
    return MBSR_OK;
}

/* Whether the list may be one of a model like this. */
static bool is_of_model(const mbsr_parameters *list, const mbsr_model *m)
{
    const mbsr_model *base = list->base;
    const mbsri_body_entry *a = base->entries.data, *b = m->entries.data;
    const size_t forces = m->forces.count + m->elements.idle;
    bool same = base->entries.count == m->entries.count && base->forces.count == forces;
    for (size_t k = 0; k < m->entries.count && same; ++k)
        same = a[k].parent == b[k].parent && a[k].joint.table == b[k].joint.table &&
               a[k].joint.n == b[k].joint.n && a[k].inertia.kind == b[k].inertia.kind;
    for (size_t k = 0; k < forces && same; ++k) {
        const mbsri_force *force = mbsri_force_at(m, k);
        same = mbsri_force_at(base, (size_t)force->id)->def.table == force->def.table;
    }
    return same && base->closures.count <= m->closures.count;
}

/* ---- memory ---- */

/* Numbers of the longest call of an element, and of a body. */
static size_t longest_call(const mbsr_model *m)
{
    size_t most = (size_t)(2 * m->most.d * m->most.d + 2 * m->most.d + m->most.n);
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsri_force *force = mbsri_force_at(m, k);
        size_t one = (size_t)(m->root.d + m->most.d + m->most.n);
        for (int j = 0; j < force->def.bodies; ++j) {
            const mbsri_body *b = m->body + m->stored.list_index[force->list + (size_t)j];
            one += (size_t)(b->d + b->n);
        }
        if (one > most) most = one;
    }
    return most;
}

/* Arrays behind `of`, which is there; memory NULL: their size. */
static size_t place_seeds(mbsri_seeds *s, size_t longest, unsigned char *memory)
{
    size_t used = (size_t)s->count * sizeof *s->of;
    if (memory) s->seed = (mbsri_seed *)(void *)(memory + used);
    used += s->seeds * sizeof *s->seed;
    double **const place[] = {&s->value, &s->by, &s->work};
    const size_t length[] = {s->values, (size_t)s->count, 2 * longest};
    for (size_t k = 0; k < 3 + MBSRI_SEED_PLACES; ++k) {
        double **at = k < 3 ? place[k] : s->sum + (k - 3);
        if (memory) *at = (double *)(void *)(memory + used);
        used += (k < 3 ? length[k] : s->length[k - 3]) * sizeof(double);
    }
    return used;
}

static void set_lengths(mbsri_seeds *s, const mbsri_linear *l)
{
    const mbsr_model *m = l->model;
    const size_t nu = (size_t)m->nu;
    const bool residual = s->use == MBSRI_SEED_RESIDUAL;
    s->length[MBSRI_SEED_MOTION] = s->use > 0 ? 0 : l->motions;
    s->length[MBSRI_SEED_REACTION] = residual ? 0 : m->size.v;
    s->length[MBSRI_SEED_TORQUE] = s->length[MBSRI_SEED_LOAD] = nu;
    s->length[MBSRI_SEED_SPRING] = (size_t)m->rows;
    if (!residual) return;
    s->length[MBSRI_SEED_ACTION] = 3 * m->size.v;
    s->length[MBSRI_SEED_PULSE] = s->length[MBSRI_SEED_DRIFT] = nu;
    s->length[MBSRI_SEED_ROW] = (size_t)(m->rows + m->position_rows);
}

int mbsri_seeds_create(mbsri_seeds *s, const mbsri_linear *l, int use, const mbsr_parameters *list,
                       int count, const int *which, const char *function, mbsr_error *error)
{
    const mbsr_model *m = l->model;
    mbsri_seeds made = {.count = count, .use = use};
    set_lengths(&made, l);
    *s = (mbsri_seeds){.count = 0};
    if (!is_of_model(list, m))
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: the list is of another model", function);
    made.of = mbsri_allocate(&m->allocator, ((size_t)count + 1) * sizeof *made.of);
    if (!made.of)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory",
                          function);
    int status = MBSR_OK;
    for (int k = 0; k < count && !status; ++k)
        status = choose_parameter(made.of + k, m, list, which[k], function, error);
    if (!status) {
        lay_out_seeds(&made, l);
        const size_t longest = longest_call(m), size = place_seeds(&made, longest, NULL);
        unsigned char *memory = mbsri_allocate(&m->allocator, size + 1);
        if (memory) {
            memset(memory, 0, size);
            memcpy(memory, made.of, (size_t)count * sizeof *made.of);
            mbsri_release(&m->allocator, made.of);
            made.of = (mbsri_seeded *)(void *)memory;
            made.memory = memory;
            (void)place_seeds(&made, longest, memory);
            lay_out_seeds(&made, l);
            made.longest = longest;
            *s = made;
            return MBSR_OK;
        }
        status = mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                            "%s: no memory for %d parameters", function, count);
    }
    mbsri_release(&m->allocator, made.of);
    return status;
}

void mbsri_seeds_destroy(mbsri_seeds *s, const mbsr_model *m)
{
    if (s->memory) mbsri_release(&m->allocator, s->memory);
    *s = (mbsri_seeds){.count = 0};
}

/* ---- products ---- */

int mbsri_seeds_find(mbsri_seeds *s, const mbsri_linear *l, mbsr_data *d)
{
    int status = MBSR_OK;
    for (int k = 0; k < s->count && !status; ++k) {
        if (s->of[k].first < s->of[k].last) status = mbsri_seed_values(s, s->of + k, l, d);
    }
    return status;
}

void mbsri_seeds_along(mbsri_seeds *s, const double *theta)
{
    for (int k = 0; k < MBSRI_SEED_PLACES; ++k) mbsri_zero(s->length[k], s->sum[k]);
    for (int k = 0; k < s->count; ++k) {
        for (size_t j = s->of[k].first; j < s->of[k].last; ++j) {
            const mbsri_seed *seed = s->seed + j;
            double *to = s->sum[seed->place] + seed->at;
            for (int i = 0; i < seed->count; ++i)
                to[i] += theta[k] * s->value[seed->value + (size_t)i];
        }
    }
}

void mbsri_seeds_back(mbsri_seeds *s, const double *const gradient[MBSRI_SEED_PLACES])
{
    for (int k = 0; k < s->count; ++k) {
        s->by[k] = 0.0;
        for (size_t j = s->of[k].first; j < s->of[k].last; ++j) {
            const mbsri_seed *seed = s->seed + j;
            s->by[k] +=
                mbsri_dot(seed->count, s->value + seed->value, gradient[seed->place] + seed->at);
        }
    }
}
