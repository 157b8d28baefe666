/* Memory of the front, and plans for the pairs that act: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What a plan determines the sizes of stands behind all else in one block. Of a model with elements
 * by pairs the block has room for a plan in which all bodies of such an element act on each other,
 * up to a limit, and plans are made in memory of their own. */
#include "newton/front/axes_step.h"

#include "base/error.h"
#include "base/memory.h"
#include "model/query.h"
#include "newton/front/crowd.h"
#include "newton/front/floating.h"
#include "recursion/closure_view.h"
#include "sweeps/bounded.h"

#include <mbsrank/dae.h>

#include <math.h>
#include <string.h>

/* Of a front with elements by pairs, bytes at most of what a plan determines. */
static const size_t most_room = (size_t)1 << 29;

/* ---- numbers ---- */

static int next(int *used, int count)
{
    *used += count;
    return *used - count;
}

/* The numbers of all bodies; owners where there is room for them. */
static void number(mbsri_front *f)
{
    const mbsr_model *m = f->model;
    int rows = 0, columns = 0;
    for (int i = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const int row = rows, column = columns, range = b->group.head == i ? b->group.n : b->n;
        mbsri_front_names at = {0};
        at.x = next(&columns, f->linear->e[i] + 2 * b->d);
        at.y = next(&rows, 3 * b->d);
        if (f->memory) f->names[i] = at;
        if (f->served && !f->served[i]) continue;
        at.q = next(&columns, b->nq);
        at.u = next(&columns, b->n);
        at.rates = next(&columns, b->n);
        at.range = next(&columns, range);
        at.kappa = next(&rows, b->d);
        at.tau = next(&rows, b->n);
        at.push = next(&rows, b->n);
        at.place = next(&rows, b->nq);
        at.a = next(&rows, b->n);
        at.b = next(&rows, b->n);
        at.range_of_a = next(&rows, range);
        at.momentum = next(&rows, b->n);
        at.rate = next(&rows, b->n);
        if (!f->memory) continue;
        f->names[i] = at;
        for (int k = row; k < rows; ++k) f->rows.owner[k] = i;
        for (int k = column; k < columns; ++k) f->columns.owner[k] = i;
    }
    f->rows.count = rows;
    f->columns.count = columns;
}

/* What the numbers of a body, and those of closures, are. */
static void sort(mbsri_front *f)
{
    const mbsr_model *m = f->model;
    for (int k = 0; k < f->rows.count; ++k) f->rows.kind[k] = MBSRI_FRONT_NONE;
    for (int k = 0; k < f->columns.count; ++k) f->columns.kind[k] = MBSRI_FRONT_NONE;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const mbsri_front_names *at = f->names + i;
        if (f->served && !f->served[i]) continue;
        const int range = b->group.head == i ? b->group.n : b->n;
        for (int k = 0; k < b->nq; ++k)
            f->rows.kind[at->place + k] = f->columns.kind[at->q + k] = MBSRI_FRONT_PLACE;
        for (int k = 0; k < b->n; ++k)
            f->rows.kind[at->b + k] = f->columns.kind[at->u + k] = MBSRI_FRONT_OWN;
        for (int k = 0; k < range; ++k)
            f->rows.kind[at->range_of_a + k] = f->columns.kind[at->range + k] = MBSRI_FRONT_OWN;
    }
    for (size_t k = 0; k < m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)m->closures.data + k;
        for (int r = 0; r < c->rows + c->position_rows; ++r) {
            const int at = r < c->rows ? c->row + r : m->rows + c->position_row + r - c->rows,
                      kind = r < c->rows ? MBSRI_FRONT_LAMBDA : MBSRI_FRONT_ETA;
            f->rows.kind[f->rows.count + at] = f->columns.kind[f->columns.count + at] =
                (unsigned char)kind;
            f->rows.owner[f->rows.count + at] = f->columns.owner[f->columns.count + at] =
                -1 - (int)k;
        }
    }
}

/* ---- memory ---- */

static void *take(unsigned char *base, size_t *used, size_t count, size_t size)
{
    void *here = base ? base + *used : NULL;
    *used += (count * size + 15) / 16 * 16;
    return here;
}

/* What does not depend on the plan; floats: bodies may. */
static size_t place_fixed(mbsri_front *f, bool floats, unsigned char *base)
{
    const mbsr_model *m = f->model;
    const size_t multipliers = (size_t)(m->rows + m->position_rows),
                 rows = (size_t)f->rows.count + multipliers,
                 columns = (size_t)f->columns.count + multipliers, bodies = (size_t)m->bodies + 1;
    size_t used = 0;
    f->names = take(base, &used, bodies, sizeof *f->names);
    f->left = take(base, &used, bodies, sizeof *f->left);
    f->planned = take(base, &used, f->arena ? (size_t)m->elements.pairs : 0, sizeof *f->planned);
    int **const ints[] = {&f->rows.owner, &f->columns.owner, &f->rows.at, &f->columns.at};
    const size_t int_count[] = {rows, columns, rows, columns};
    for (size_t k = 0; k < sizeof ints / sizeof ints[0]; ++k)
        *ints[k] = take(base, &used, int_count[k], sizeof(int));
    f->rows.kind = take(base, &used, rows, 1);
    f->columns.kind = take(base, &used, columns, 1);
    double **const doubles[] = {&f->value, &f->h, &f->rates, &f->wbar, &f->left_over};
    const size_t count[] = {columns, rows, 5 * (size_t)m->nu, m->size.v,
                            2 * (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM)};
    for (size_t k = 0; k < sizeof doubles / sizeof doubles[0]; ++k)
        *doubles[k] = take(base, &used, count[k], sizeof(double));
    double *vectors =
        take(base, &used, mbsri_vectors_place(f->linear, NULL, &f->vectors), sizeof(double));
    if (base) (void)mbsri_vectors_place(f->linear, vectors, &f->vectors);
    const bool bounded = !f->served && mbsri_bounded_serves(m);
    mbsri_sweep_load *bounds = take(base, &used, bounded ? bodies : 0, sizeof *bounds);
    if (base && bounded) mbsri_bounded_prepare(m, bounds);
    f->linear->bounds.load = bounded ? bounds : NULL;
    f->linear->bounds.forward = floats;
    if (floats) {
        unsigned char *floating = take(base, &used, mbsri_floating_place(f, NULL), 1);
        (void)mbsri_floating_place(f, floating);
    }
    f->of_plan = base ? base + used : NULL;
    return used;
}

/* What does. */
static size_t place_plan(mbsri_front *f, const mbsri_front_plan *plan, unsigned char *base)
{
    const size_t most_rows = (size_t)plan->most_rows, most_columns = (size_t)plan->most_columns,
                 front = most_rows * most_columns;
    size_t used = 0;
    f->now.row = take(base, &used, most_rows, sizeof(int));
    f->now.column = take(base, &used, most_columns, sizeof(int));
    f->numbers = take(base, &used, plan->ints, sizeof(int));
    double **const doubles[] = {&f->LU,          &f->matrices,      &f->now.M,
                                &f->now.N,       &f->now.row_scale, &f->now.column_scale,
                                &f->now.largest, &f->local};
    const size_t count[] = {plan->doubles, plan->matrices, front,     front,
                            most_rows,     most_columns,   most_rows, most_rows + most_columns};
    for (size_t k = 0; k < sizeof doubles / sizeof doubles[0]; ++k)
        *doubles[k] = take(base, &used, count[k], sizeof(double));
    return used;
}

static bool *copy_of(const mbsr_model *m, const bool *served)
{
    const size_t size = ((size_t)m->bodies + 1) * sizeof *served;
    bool *copy = mbsri_allocate(&m->allocator, size);
    if (copy) memcpy(copy, served, size);
    return copy;
}

/* Which steps are those of axes, and of bodies that may float. */
static void mark_kinds(mbsri_front *f)
{
    for (int k = 0; k < f->plan.steps; ++k) {
        f->plan.step[k].axes = mbsri_front_may_step(f, k);
        f->plan.step[k].may_float = mbsri_front_may_float(f, k);
    }
}

/* ---- plans in memory of their own ---- */

static void *arena_take(void *user, size_t size)
{
    mbsri_front_arena *a = user;
    const size_t rounded = (size + 15) / 16 * 16;
    if (rounded < size || rounded > a->size - a->used) return NULL;
    a->used += rounded;
    return a->memory + a->used - rounded;
}

static void arena_give(void *user, void *memory)
{
    (void)user;
    (void)memory;
}

/* Room for the lists of a plan and for finding an order: at most each body with each other. */
static size_t arena_size(const mbsri_front *f)
{
    const size_t bodies = (size_t)f->model->bodies + 1,
                 elements = f->model->forces.count + f->model->closures.count +
                            f->model->stored.lists.count + 4 * (size_t)f->model->elements.pairs;
    const size_t size = bodies * 1024 + elements * 64 + bodies * bodies * 64;
    return size < most_room ? size : most_room;
}

/* Whether all bodies of one element by pairs fill the room: the front that is first has 12 rows and
 * columns of each of them, twice. */
static bool fills_room(const mbsr_model *m)
{
    double most = 0.0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsr_force_def *def = &mbsri_force_at(m, k)->def;
        if (def->table->flags & MBSR_FORCE_BY_PAIRS) most = fmax(most, def->bodies - 2);
    }
    return 2.0 * 144.0 * most * most * sizeof(double) > (double)most_room;
}

/* Room that the plan has in which all that may act does. */
static bool find_room(mbsri_front *f)
{
    const mbsri_front_source all = {f->model, NULL, NULL, &f->model->allocator};
    mbsri_front_plan plan;
    f->room = most_room;
    if (fills_room(f->model)) return true;
    if (!mbsri_front_plan_create(&all, NULL, &plan)) return false;
    plan.matrices *= 2; /* there may be several at a time */
    f->room = place_plan(f, &plan, NULL);
    if (f->room > most_room) f->room = most_room;
    mbsri_front_plan_destroy(&f->model->allocator, &plan);
    return true;
}

/* The plan for the pairs of the linearised equations, in the arena. */
static bool plan_here(mbsri_front *f)
{
    const mbsr_allocator allocator = {arena_take, arena_give, f->arena};
    const mbsri_front_source now = {f->model, &f->linear->pairs, f->crowd ? f->crowd->apart : NULL,
                                    &allocator};
    f->arena->used = 0;
    f->planned_count = -1;
    return mbsri_front_plan_create(&now, NULL, &f->plan) &&
           place_plan(f, &f->plan, NULL) <= f->room;
}

static bool is_planned(const mbsri_front *f)
{
    const mbsri_pairs *now = &f->linear->pairs;
    return now->count == f->planned_count &&
           memcmp(now->pair, f->planned, (size_t)now->count * sizeof *now->pair) == 0;
}

/* Whether pairs that were apart are not to be so now. */
static bool rests(const mbsri_front *f)
{
    return mbsri_front_iterates(f) && f->crowd->rest > 0;
}

static int too_many(const mbsri_front *f, mbsr_data *d)
{
    const mbsr_model *m = f->model;
    const mbsri_pairs *now = &f->linear->pairs;
    const mbsri_acting *last = now->pair + now->count - 1;
    char a[MBSRI_LABEL], b[MBSRI_LABEL];
    if (now->count == 0)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_newton_factor: no memory for a plan");
    return mbsri_fail(
        &d->error, MBSR_ERR_NO_MEMORY, m->body[last->body[0]].id,
        ((const mbsri_force *)m->forces.data + last->force)->id,
        "mbsr_newton_factor: %d pairs, up to %s and %s, act on each other at t = %g: the "
        "elimination needs more than the %zu bytes set aside",
        now->count, mbsri_body_label(m, last->body[0], a), mbsri_body_label(m, last->body[1], b),
        d->t, f->room);
}

int mbsri_front_replan(mbsri_front *f, mbsr_data *d)
{
    const mbsri_pairs *now = &f->linear->pairs;
    if (!f->arena || (is_planned(f) && !rests(f))) return MBSR_OK;
    if (f->crowd) mbsri_front_crowd_part(f);
    if (!plan_here(f)) return too_many(f, d);
    (void)place_plan(f, &f->plan, f->of_plan);
    memset(f->left, 0, ((size_t)f->model->bodies + 1) * sizeof *f->left);
    if (now->count > 0) memcpy(f->planned, now->pair, (size_t)now->count * sizeof *now->pair);
    f->planned_count = now->count;
    mark_kinds(f);
    return MBSR_OK;
}

/* ---- creating ---- */

/* The plan, and how much memory it takes. */
static bool plan(mbsri_front *f)
{
    const mbsr_model *m = f->model;
    const mbsri_front_source all = {m, NULL, NULL, &m->allocator};
    if (m->elements.pairs == 0 || f->served) {
        if (!mbsri_front_plan_create(&all, f->served, &f->plan)) return false;
        f->bytes += mbsri_front_plan_bytes(&all, &f->plan);
        f->room = place_plan(f, &f->plan, NULL);
        return true;
    }
    const size_t head = (sizeof *f->arena + 15) / 16 * 16, size = arena_size(f);
    f->arena = mbsri_allocate(&m->allocator, head + size);
    if (!f->arena) return false;
    *f->arena = (mbsri_front_arena){(unsigned char *)f->arena + head, size, 0};
    f->bytes += head + size;
    return find_room(f) && plan_here(f);
}

/* Pairs may be apart where there are some, and `together` says so. */
static bool place_crowd(mbsri_front *f, int together, double error)
{
    const mbsr_model *m = f->model;
    if (m->elements.pairs == 0 || f->served || together == 0 || together >= m->bodies) return true;
    f->crowd = mbsri_front_crowd_create(m, together, error);
    if (f->crowd) f->bytes += f->crowd->bytes;
    return f->crowd != NULL;
}

/* Whether bodies may float: what solves transposed systems, or refines, reads the factors of all
 * unknowns. */
static bool floats(const mbsri_front *f, bool transposes)
{
    return f->arena && !f->linear->whole && !transposes;
}

mbsri_front *mbsri_front_create(const mbsr_model *m, const bool *served, int together, double error,
                                bool transposes)
{
    mbsri_front *f = mbsri_allocate(&m->allocator, sizeof *f);
    if (!f) return NULL;
    *f = (mbsri_front){.model = m, .served = served ? copy_of(m, served) : NULL};
    if (f->served || !served) f->linear = mbsri_linear_create(m, m->rows > 0, f->served);
    if (f->linear && place_crowd(f, transposes ? 0 : together, error) && plan(f)) {
        number(f);
        const size_t size = place_fixed(f, floats(f, transposes), NULL) + f->room;
        f->memory = mbsri_allocate(&m->allocator, size);
        f->bytes += sizeof *f + size + f->linear->bytes;
    }
    if (!f->memory) {
        mbsri_front_destroy(f);
        return NULL;
    }
    (void)place_fixed(f, floats(f, transposes), f->memory);
    (void)place_plan(f, &f->plan, f->of_plan);
    memset(f->left, 0, ((size_t)m->bodies + 1) * sizeof *f->left);
    number(f);
    sort(f);
    mark_kinds(f);
    return f;
}

void mbsri_front_destroy(mbsri_front *f)
{
    if (!f) return;
    const mbsr_allocator allocator = f->model->allocator;
    mbsri_linear_destroy(f->linear);
    mbsri_front_crowd_destroy(f->model, f->crowd);
    if (!f->arena) mbsri_front_plan_destroy(&allocator, &f->plan);
    if (f->arena) mbsri_release(&allocator, f->arena);
    if (f->memory) mbsri_release(&allocator, f->memory);
    if (f->served) mbsri_release(&allocator, f->served);
    mbsri_release(&allocator, f);
}
