/* The plan of an elimination: see plan.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Orders are tried, and that with the fewest multiplications is kept: from the last body to the
 * first; by depth, which takes the rails of a ladder side by side; and by least border (order.c).
 */
#include "newton/front/plan.h"

#include "base/memory.h"
#include "newton/front/order.h"
#include "newton/slopes/force_slopes.h"
#include "recursion/closures.h"

#include <stdlib.h>
#include <string.h>

/* Unknowns beyond those of open multipliers that may be handed on for want of a good pivot. */
enum { SPARE = 6 };

/* ---- memory ---- */

typedef struct draft {
    const mbsr_model *m;
    const mbsri_front_source *from;
    const bool *served; /* NULL: all */
    mbsri_front_plan *plan;
    bool crosses;       /* something ties bodies that are no neighbours */
    mbsri_array border; /* mbsri_front_border */
    int *marked;        /* N + 1: the last step whose border has the body, and 1; */
    int *impulse;       /* and in whose border it has its impulse */
    int *last_child;    /* of a step: chains of its children, by `before` */
    int *before;
    int *rows, *rates; /* of what is handed on: velocity rows, rates beyond these, */
    int *waiting, *unsettled, *massless; /* multipliers, rates of groups that are not complete, and
                                          * whether bodies without full inertia are behind */
} draft;

static void *numbers(const mbsri_front_source *from, size_t count)
{
    return mbsri_allocate(from->allocator, (count > 0 ? count : 1) * sizeof(int));
}

/* Elements with their bodies, at most. */
static size_t entries_of(const mbsri_front_source *from)
{
    size_t sum = 0;
    for (int k = 0; k < mbsri_front_elements(from); ++k) {
        const int *list;
        sum += (size_t)mbsri_front_bodies(from, k, &list);
    }
    return sum;
}

void mbsri_front_plan_destroy(const mbsr_allocator *allocator, mbsri_front_plan *plan)
{
    void *const memory[] = {plan->step,    plan->position, plan->child,
                            plan->element, plan->border,   plan->coordinates};
    for (size_t k = 0; k < sizeof memory / sizeof memory[0]; ++k) {
        if (memory[k]) mbsri_release(allocator, memory[k]);
    }
    *plan = (mbsri_front_plan){0};
}

size_t mbsri_front_plan_bytes(const mbsri_front_source *from, const mbsri_front_plan *plan)
{
    const size_t bodies = (size_t)from->model->bodies + 1;
    return bodies * (sizeof *plan->step + 2 * sizeof(int) + sizeof(bool)) +
           entries_of(from) * sizeof(int) + (size_t)plan->entries * sizeof *plan->border;
}

static bool allocate_plan(const mbsri_front_source *from, mbsri_front_plan *plan)
{
    const size_t bodies = (size_t)from->model->bodies + 1;
    *plan = (mbsri_front_plan){.steps = from->model->bodies};
    return (plan->step = mbsri_allocate(from->allocator, bodies * sizeof *plan->step)) &&
           (plan->position = numbers(from, bodies)) && (plan->child = numbers(from, bodies)) &&
           (plan->element = numbers(from, entries_of(from))) &&
           (plan->coordinates = mbsri_allocate(from->allocator, bodies * sizeof(bool)));
}

/* ---- what is where ---- */

static void find_coordinates(const mbsri_front_source *from, const bool *served, bool *coordinates)
{
    const mbsr_model *m = from->model;
    const int forces = (int)m->forces.count, fixed = forces + (int)m->closures.count;
    memset(coordinates, 0, ((size_t)m->bodies + 1) * sizeof *coordinates);
    for (int k = 0; k < fixed && !served; ++k) { /* pairs do not read joints */
        const int *list, count = mbsri_front_bodies(from, k, &list);
        const bool reads =
            k < forces
                ? !(((const mbsri_force *)m->forces.data)[k].def.table->flags & MBSR_FORCE_NO_JOINT)
                : mbsri_reads_joints((const mbsri_closure *)m->closures.data + k - forces);
        bool several = false;
        for (int l = 1; l < count; ++l) several = several || list[l] != list[0];
        for (int l = 0; l < count && reads && several; ++l) coordinates[list[l]] = true;
    }
}

/* The step in which an element is added: the first that passes one of its bodies; -1: there is
 * none. */
static int step_of(const mbsri_front_source *from, const mbsri_front_plan *plan, int element)
{
    const int *list, count = mbsri_front_bodies(from, element, &list);
    int first = -1;
    for (int k = 0; k < count; ++k) {
        if (list[k] == 0) continue;
        const int at = plan->position[list[k]];
        if (first < 0 || at < first) first = at;
    }
    return first;
}

/* Whether an element is added in the step of its body l: of each, if it is apart. */
static bool is_added(const draft *d, int element, int l)
{
    const int *list;
    (void)mbsri_front_bodies(d->from, element, &list);
    if (list[l] == 0) return false;
    if (mbsri_front_is_apart(d->from, element)) return true;
    if (!d->served) return d->plan->position[list[l]] == step_of(d->from, d->plan, element);
    return d->served[list[l]];
}

static bool is_repeated(const int *list, int l)
{
    bool again = false;
    for (int k = 0; k < l; ++k) again = again || list[k] == list[l];
    return again;
}

/* Counts the elements of each step, and lists them where there is room; how many entries that
 * takes. */
static int list_elements(draft *d, bool listed)
{
    mbsri_front_plan *plan = d->plan;
    int used = 0;
    for (int k = 0; k < mbsri_front_elements(d->from); ++k) {
        const int *list, count = mbsri_front_bodies(d->from, k, &list);
        for (int l = 0; l < count; ++l) {
            if (is_repeated(list, l) || !is_added(d, k, l)) continue;
            mbsri_front_step *s = plan->step + plan->position[list[l]];
            if (listed) plan->element[s->first_element + s->elements] = k;
            ++s->elements;
            ++used;
        }
    }
    return used;
}

static void place_elements(draft *d)
{
    mbsri_front_plan *plan = d->plan;
    int used = 0;
    for (int k = 0; k < plan->steps; ++k) plan->step[k].elements = 0;
    plan->elements = list_elements(d, false);
    for (int k = 0; k < plan->steps; ++k) {
        plan->step[k].first_element = used;
        used += plan->step[k].elements;
        plan->step[k].elements = 0;
    }
    (void)list_elements(d, true);
}

/* Adds a body to the border of step k. */
static bool add_body(draft *d, int k, int body)
{
    const mbsri_front_plan *plan = d->plan;
    if (body == 0 || plan->position[body] <= k || d->marked[body] == k + 1) return true;
    if (!mbsri_reserve(d->from->allocator, &d->border, 1, sizeof(mbsri_front_border))) return false;
    d->marked[body] = k + 1;
    ((mbsri_front_border *)d->border.data)[d->border.count++].body = body;
    return true;
}

/* By position, that which is passed first in front. */
static void sort_border(const mbsri_front_plan *plan, int count, mbsri_front_border *border)
{
    for (int k = 1; k < count; ++k) {
        const mbsri_front_border now = border[k];
        int at = k;
        for (; at > 0 && plan->position[border[at - 1].body] > plan->position[now.body]; --at)
            border[at] = border[at - 1];
        border[at] = now;
    }
}

static bool find_border(draft *d, int k)
{
    mbsri_front_plan *plan = d->plan;
    mbsri_front_step *s = plan->step + k;
    const int parent = d->m->body[s->body].parent;
    s->first_border = (int)d->border.count;
    bool room = add_body(d, k, parent);
    d->impulse[parent] = k + 1;
    for (int l = 0; l < s->elements && room && !d->served; ++l) {
        const int *list, element = plan->element[s->first_element + l],
                         count = mbsri_front_bodies(d->from, element, &list);
        if (mbsri_front_is_apart(d->from, element)) continue;
        for (int j = 0; j < count && room; ++j) room = add_body(d, k, list[j]);
    }
    for (int l = 0; l < s->children && room && !d->served; ++l) {
        const mbsri_front_step *child = plan->step + plan->child[s->first_child + l];
        for (int j = 0; j < child->borders && room; ++j) {
            const mbsri_front_border now =
                ((mbsri_front_border *)d->border.data)[child->first_border + j];
            if (now.whole) d->impulse[now.body] = k + 1;
            room = add_body(d, k, now.body);
        }
    }
    s->borders = (int)d->border.count - s->first_border;
    s->next = -1;
    if (s->borders == 0 || !room) return room;
    mbsri_front_border *border = (mbsri_front_border *)d->border.data + s->first_border;
    sort_border(plan, s->borders, border);
    for (int l = 0; l < s->borders; ++l) border[l].whole = d->impulse[border[l].body] == k + 1;
    s->next = plan->position[border[0].body];
    return true;
}

static void find_children(draft *d, int k, int *used)
{
    mbsri_front_step *s = d->plan->step + k;
    s->first_child = *used;
    for (int child = d->last_child[k]; child >= 0; child = d->before[child])
        d->plan->child[(*used)++] = child;
    s->children = *used - s->first_child;
}

/* ---- sizes ---- */

/* Most columns and rows of a body in a border. */
static int columns_of(const draft *d, int body)
{
    const mbsri_body *b = d->m->body + body;
    return mbsri_pose_size(b) + 2 * b->d + (d->plan->coordinates[body] ? b->nq + b->n : 0);
}

static int rows_of(const draft *d, int body)
{
    const mbsri_body *b = d->m->body + body;
    return (d->m->position_rows > 0 ? 4 : 3) * b->d + (d->plan->coordinates[body] ? 2 * b->n : 0);
}

/* Multipliers of the closures of a step; rows: those of velocity rows alone. */
static int multipliers_of(const draft *d, const mbsri_front_step *s, int *rows)
{
    const int forces = (int)d->m->forces.count;
    int sum = 0;
    *rows = 0;
    for (int l = 0; l < s->elements; ++l) {
        const int k = d->plan->element[s->first_element + l] - forces;
        if (k < 0 || k >= (int)d->m->closures.count) continue;
        const mbsri_closure *c = (const mbsri_closure *)d->m->closures.data + k;
        sum += c->rows + c->position_rows;
        *rows += c->rows;
    }
    return sum;
}

/* Multiplications of step k, about: velocity rows are done with when as many rates have been
 * passed. */
static double operations(draft *d, const mbsri_front_step *s, int k, int rows, int multipliers)
{
    const mbsri_body *b = d->m->body + s->body;
    int open = rows, rates = b->n;
    for (int l = 0; l < s->children; ++l) {
        open += d->rows[d->plan->child[s->first_child + l]];
        rates += d->rates[d->plan->child[s->first_child + l]];
    }
    const int done = rates < open ? rates : open;
    d->rows[k] = open - done;
    d->rates[k] = rates - done;
    const double own = b->nq + b->n + multipliers, width = own + 2 * d->rows[k];
    return own * (width + s->border_rows) * (width + s->border_columns) +
           (width + s->border_columns) * s->border_columns * 6.0;
}

/* Of a body that something else passes: what it hands to one that is served. */
static void measure_other(draft *d, int k)
{
    mbsri_front_step *s = d->plan->step + k;
    const int parent = d->m->body[s->body].parent;
    const bool hands = parent > 0 && d->served[parent];
    s->border_columns = hands ? columns_of(d, parent) : 0;
    s->border_rows = hands ? rows_of(d, parent) : 0;
    d->waiting[k] = d->unsettled[k] = d->massless[k] = d->rows[k] = d->rates[k] = 0;
}

/* Sizes of step k, at most. Of multipliers no more can be without a pivot than the border has
 * columns, as rows of a regular matrix; nor of directions without inertia. */
static void measure_border(draft *d, int k)
{
    mbsri_front_step *s = d->plan->step + k;
    if (d->served && !d->served[s->body]) {
        measure_other(d, k);
        return;
    }
    const mbsri_body *b = d->m->body + s->body;
    int rows, carried = 0, open = 0, groups = b->group.head == s->body ? b->n - b->group.n : b->n,
              light = !b->mass.regular;
    const int more = multipliers_of(d, s, &rows);
    int waiting = more;
    s->border_columns = s->border_rows = 0;
    for (int l = 0; l < s->borders; ++l) {
        const mbsri_front_border now =
            ((const mbsri_front_border *)d->border.data)[s->first_border + l];
        s->border_columns += columns_of(d, now.body);
        s->border_rows += rows_of(d, now.body) - (now.whole ? 0 : d->m->body[now.body].d);
    }
    for (int l = 0; l < s->children; ++l) {
        const int child = d->plan->child[s->first_child + l];
        carried += d->plan->step[child].carried;
        open += 2 * d->unsettled[child];
        waiting += d->waiting[child];
        groups += d->unsettled[child];
        light = light || d->massless[child];
    }
    if (groups < 0) groups = 0; /* something else passes members of the group */
    s->crowded = carried > MBSRI_FRONT_ROOM + open;
    if (s->crowded) carried = MBSRI_FRONT_ROOM + open;
    d->plan->crowded = d->plan->crowded || s->crowded;
    const int own = b->nq + b->n + (b->group.head == s->body ? b->group.n : b->n),
              all = own + more + carried;
    if (waiting > s->border_columns) waiting = s->border_columns;
    d->waiting[k] = waiting;
    d->unsettled[k] = groups;
    d->massless[k] = light;
    s->delayed =
        d->crosses || d->m->rows > 0 ? waiting + SPARE + (light ? s->border_columns : 0) : 0;
    s->carried = all < s->delayed + 2 * groups ? all : s->delayed + 2 * groups;
    if (s->borders == 0) s->carried = 0;
    s->rates = b->n;
    s->unknowns = all;
    s->rows =
        all + s->border_rows + 4 * b->d + 4 * b->n + (b->group.head == s->body ? b->group.n : b->n);
    s->columns = all + s->border_columns + mbsri_pose_size(b) + 2 * b->d +
                 (b->group.head == s->body ? b->group.n : b->n);
    d->plan->operations += operations(d, s, k, rows, more);
}

/* Makes the plan of an order, as long as `operations` is not above `most`; false: there is no
 * memory. */
static bool lay_out(draft *d, const int *order, double most)
{
    mbsri_front_plan *plan = d->plan;
    int used = 0;
    plan->operations = 0.0;
    plan->crowded = false;
    d->border.count = 0;
    for (int k = 0; k < plan->steps; ++k) {
        plan->step[k] = (mbsri_front_step){.body = order[k]};
        plan->position[order[k]] = k;
        d->last_child[k] = -1;
    }
    for (int i = 0; i <= d->m->bodies; ++i) d->marked[i] = d->impulse[i] = 0;
    place_elements(d);
    for (int k = 0; k < plan->steps; ++k) {
        find_children(d, k, &used);
        if (!find_border(d, k)) return false;
        measure_border(d, k);
        if (plan->operations > most) return true;
        const int next = plan->step[k].next;
        if (next < 0) continue;
        d->before[k] = d->last_child[next];
        d->last_child[next] = k;
    }
    plan->children = used;
    return true;
}

/* ---- orders ---- */

static bool crosses(const mbsri_front_source *from)
{
    const mbsr_model *m = from->model;
    for (int k = 0; k < mbsri_front_elements(from); ++k) {
        const int *list, count = mbsri_front_bodies(from, k, &list);
        if (mbsri_front_is_apart(from, k)) continue;
        for (int l = 1; l < count; ++l) {
            const int a = list[0], b = list[l];
            if (a != b && a != 0 && b != 0 && m->body[a].parent != b && m->body[b].parent != a)
                return true;
            if (count > 2) return true;
        }
    }
    return false;
}

/* Takes the other order if it is cheaper than `best`; false: there is no memory. */
static bool compare(draft *d, double *best, int *order, const int *other)
{
    if (!lay_out(d, other, *best)) return false;
    if (d->plan->operations > *best) return true;
    *best = d->plan->operations;
    if (other != order) memcpy(order, other, (size_t)d->m->bodies * sizeof *order);
    return true;
}

static bool choose_elimination(draft *d, int *order, int *other)
{
    const mbsr_model *m = d->m;
    double best = 1e300;
    for (int k = 0; k < m->bodies; ++k) order[k] = m->bodies - k;
    if (!d->crosses) return true;
    if (!compare(d, &best, order, order)) return false;
    mbsri_front_order_by_depth(m, other, d->marked);
    if (!compare(d, &best, order, other)) return false;
    return mbsri_front_order_by_border(d->from, other) && compare(d, &best, order, other);
}

/* ---- places ---- */

/* Places of matrices that are handed on: each is taken when its step is done and free when the next
 * has read it. `free` has lengths and places. */
typedef struct gap {
    size_t at, length;
} gap;

static size_t take_gap(gap *gaps, int *count, size_t length, size_t *end)
{
    for (int k = 0; k < *count; ++k) {
        if (gaps[k].length < length) continue;
        const size_t at = gaps[k].at;
        gaps[k].at += length;
        gaps[k].length -= length;
        if (gaps[k].length == 0) gaps[k] = gaps[--*count];
        return at;
    }
    *end += length;
    return *end - length;
}

/* Adds a gap, and joins it with its neighbours. */
static void give_gap(gap *gaps, int *count, gap now)
{
    for (int k = 0; k < *count; ++k) {
        const bool behind = gaps[k].at + gaps[k].length == now.at,
                   before = now.at + now.length == gaps[k].at;
        if (!behind && !before) continue;
        now = (gap){behind ? gaps[k].at : now.at, now.length + gaps[k].length};
        gaps[k] = gaps[--*count];
        k = -1;
    }
    if (now.length > 0) gaps[(*count)++] = now;
}

static size_t matrix_size(const mbsri_front_step *s)
{
    return (size_t)(s->carried + s->border_rows) * (size_t)(s->carried + s->border_columns);
}

static void place_fronts(mbsri_front_plan *plan, gap *gaps)
{
    int count = 0;
    plan->matrices = plan->doubles = plan->ints = 0;
    plan->most_rows = plan->most_columns = 0;
    for (int k = 0; k < plan->steps; ++k) {
        mbsri_front_step *s = plan->step + k;
        s->matrix = take_gap(gaps, &count, matrix_size(s), &plan->matrices);
        for (int l = 0; l < s->children; ++l) {
            const mbsri_front_step *child = plan->step + plan->child[s->first_child + l];
            give_gap(gaps, &count, (gap){child->matrix, matrix_size(child)});
        }
        const size_t rows = (size_t)(s->unknowns + s->border_rows),
                     columns = (size_t)(s->unknowns + s->border_columns);
        s->LU = plan->doubles;
        if (s->rows == 0) continue; /* not served */
        plan->doubles += (size_t)s->unknowns * (rows + columns) + 2 * (size_t)s->rates * columns;
        s->numbers = plan->ints;
        plan->ints += rows + columns;
        if (s->rows > plan->most_rows) plan->most_rows = s->rows;
        if (s->columns > plan->most_columns) plan->most_columns = s->columns;
    }
}

bool mbsri_front_plan_create(const mbsri_front_source *from, const bool *served,
                             mbsri_front_plan *plan)
{
    const size_t bodies = (size_t)from->model->bodies + 1;
    int *memory = numbers(from, 11 * bodies);
    gap *gaps = memory ? mbsri_allocate(from->allocator, bodies * sizeof *gaps) : NULL;
    draft d = {.m = from->model, .from = from, .served = served, .plan = plan};
    *plan = (mbsri_front_plan){0};
    bool made = gaps && allocate_plan(from, plan);
    if (made) {
        int *order = memory, *other = memory + bodies;
        d.marked = memory + 2 * bodies;
        d.last_child = memory + 3 * bodies;
        d.before = memory + 4 * bodies;
        d.rows = memory + 5 * bodies;
        d.rates = memory + 6 * bodies;
        d.unsettled = memory + 7 * bodies;
        d.massless = memory + 8 * bodies;
        d.waiting = memory + 9 * bodies;
        d.impulse = memory + 10 * bodies;
        d.crosses = !served && crosses(from);
        find_coordinates(from, served, plan->coordinates);
        made = choose_elimination(&d, order, other) && lay_out(&d, order, 1e300);
    }
    if (made) {
        plan->border = d.border.data;
        plan->entries = (int)d.border.count;
        place_fronts(plan, gaps);
    } else {
        if (d.border.data) mbsri_release(from->allocator, d.border.data);
        mbsri_front_plan_destroy(from->allocator, plan);
    }
    if (memory) mbsri_release(from->allocator, memory);
    if (gaps) mbsri_release(from->allocator, gaps);
    return made;
}
