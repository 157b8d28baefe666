/* Shapes near each other: see near.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Boxes along the world's axes, sorted by where they begin along the axis along which shapes are
 * spread most, and swept. The order of the last call is kept, since it seldom changes much; what is
 * found does not depend on it. Across that axis the boxes stand in columns of a grid, each in all
 * that it reaches into, and each column is swept by itself: so a box meets as many others as there
 * are nearby, however many there are in all. Of two boxes that share columns the first of these
 * counts. */
#include "contact/near.h"

#include "algebra/space3.h"
#include "contact/error.h"
#include "contact/field.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static void *take_part(unsigned char *base, size_t *used, size_t size)
{
    void *here = base ? base + *used : NULL;
    *used += (size + 15) / 16 * 16;
    return here;
}

size_t mbsri_near_place(const mbsr_contacts *c, void *memory, mbsri_near *near)
{
    const size_t count = (size_t)c->count, most = (size_t)c->most,
                 numbers = (size_t)(c->bodies > c->count ? c->bodies : c->count);
    size_t used = 0;
    near->placed = take_part(memory, &used, count * sizeof *near->placed);
    near->order = take_part(memory, &used, count * sizeof *near->order);
    near->box = take_part(memory, &used, count * sizeof *near->box);
    near->entry = take_part(memory, &used, MBSRI_NEAR_ENTRIES * count * sizeof *near->entry);
    near->pair = take_part(memory, &used, most * sizeof *near->pair);
    near->spare = take_part(memory, &used, most * sizeof *near->spare);
    near->start = take_part(memory, &used, (numbers + 2) * sizeof *near->start);
    near->kept = take_part(memory, &used, 2 * sizeof *near->kept);
    return used;
}

void mbsri_near_put(const mbsri_shape *shape, const mbsr_force_body *body, mbsri_placed *placed)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0},
                        none[3] = {0.0, 0.0, 0.0};
    const bool fixed = body->space != MBSR_SPACE_SPATIAL;
    mbsri_place_shape(shape, fixed ? unit : body->p + MBSR_POSE_R,
                      fixed ? none : body->p + MBSR_POSE_X, placed);
}

/* Of the places of shapes, along the world's axes. */
typedef struct spread_of_shapes {
    double mean[3], variance[3];
} spread_of_shapes;

/* The axis with the largest variance, another than the last where it is twice as large; the means
 * and variances of all. */
static int choose_axis(const mbsr_contacts *c, const mbsri_near *near, int last,
                       spread_of_shapes *of)
{
    const int count = c->count - c->grounds;
    double spread[3];
    int best = last;
    for (int k = 0; k < 3; ++k) {
        double sum = 0.0, square = 0.0;
        for (int i = 0; i < count; ++i) {
            const double x = near->placed[near->order[i]].x[k] - near->placed[near->order[0]].x[k];
            sum += x;
            square += x * x;
        }
        spread[k] = square - sum * sum / count;
        of->mean[k] = count > 0 ? near->placed[near->order[0]].x[k] + sum / count : 0.0;
        of->variance[k] = spread[k] / count;
    }
    for (int k = 0; k < 3; ++k) {
        if (spread[k] > 2.0 * spread[best]) best = k;
    }
    return best;
}

static void sort_order(const mbsri_near *near, int count, int axis)
{
    for (int i = 1; i < count; ++i) {
        const int now = near->order[i];
        const double begin = near->placed[now].low[axis];
        int at = i;
        for (; at > 0 && near->placed[near->order[at - 1]].low[axis] > begin; --at)
            near->order[at] = near->order[at - 1];
        near->order[at] = now;
    }
}

static void begin_order(const mbsr_contacts *c, mbsri_near *near)
{
    int used = 0;
    for (int k = 0; k < c->count; ++k) {
        if (!mbsri_is_ground(c->shape[k].kind)) near->order[used++] = k;
    }
    near->kept[0] = 1;
    near->kept[1] = 0;
}

static int put_pair(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near, int a,
                    int b, int *count)
{
    if (*count >= c->most) {
        if (args->text)
            mbsri_contact_print(
                args->text, MBSR_TEXT_SIZE,
                "more than %d pairs of shapes are near each other, %s and %s among them", c->most,
                c->shape[a].name, c->shape[b].name);
        return MBSR_ERR_MEMORY_SIZE;
    }
    near->pair[*count][0] = a < b ? a : b;
    near->pair[*count][1] = a < b ? b : a;
    ++*count;
    return MBSR_OK;
}

/* ---- columns ---- */

/* Columns across the axis that is swept: how many along each of the two other axes, where the first
 * begin there, and columns a metre. */
typedef struct grid {
    int axis[2], count[2];
    double begin[2], by[2];
} grid;

/* The boxes in the order, and the sums of their widths. */
static void put_boxes(const mbsri_near *near, int count, double width[3])
{
    for (int k = 0; k < 3; ++k) width[k] = 0.0;
    for (int i = 0; i < count; ++i) {
        const mbsri_placed *placed = near->placed + near->order[i];
        mbsri_box *box = near->box + i;
        for (int k = 0; k < 3; ++k) {
            box->low[k] = placed->low[k], box->high[k] = placed->high[k];
            width[k] += box->high[k] - box->low[k];
        }
        box->ball = placed->shape->ball + placed->shape->margin;
        box->shape = near->order[i];
        box->first[0] = box->first[1] = box->last[0] = box->last[1] = 0;
    }
}

/* Columns twice as wide as boxes are on average, over where most are: evenly spread ones fill twice
 * 1.73 deviations. Those at the border reach outwards. */
static void choose_grid(grid *g, const spread_of_shapes *spread, const double width[3], int count)
{
    static const double across = 3.5;
    for (int k = 0; k < 2; ++k) {
        const int l = g->axis[k];
        const double range = across * sqrt(spread->variance[l]),
                     columns = range * count / (2.0 * width[l]);
        if (!(columns >= 2.0)) continue;
        g->count[k] = columns < count ? (int)columns : count;
        g->begin[k] = spread->mean[l] - 0.5 * range;
        g->by[k] = g->count[k] / range;
    }
}

/* Half as many along each axis. */
static void join_columns(grid *g)
{
    for (int k = 0; k < 2; ++k) {
        const int fewer = (g->count[k] + 1) / 2;
        g->by[k] *= (double)fewer / g->count[k];
        g->count[k] = fewer;
    }
}

/* The column, along one axis, of a place there. */
static int place_in_grid(const grid *g, int k, double x)
{
    const double at = (x - g->begin[k]) * g->by[k];
    return at >= g->count[k] - 1 ? g->count[k] - 1 : at > 0.0 ? (int)at : 0;
}

/* Which columns each box reaches into; how many entries that takes in all. */
static size_t reach_columns(const grid *g, mbsri_near *near, int count)
{
    const bool one = g->count[0] * g->count[1] == 1;
    size_t entries = one ? (size_t)count : 0;
    for (int i = 0; i < count && !one; ++i) {
        mbsri_box *box = near->box + i;
        for (int k = 0; k < 2; ++k) {
            box->first[k] = place_in_grid(g, k, box->low[g->axis[k]]);
            box->last[k] = place_in_grid(g, k, box->high[g->axis[k]]);
        }
        entries +=
            (size_t)(box->last[0] - box->first[0] + 1) * (size_t)(box->last[1] - box->first[1] + 1);
    }
    return entries;
}

/* Counts the boxes of each column in `start`, one place on, or lists them in order from there. */
static void visit_columns(const grid *g, mbsri_near *near, int count, bool listed)
{
    for (int i = 0; i < count; ++i) {
        const mbsri_box *box = near->box + i;
        for (int x = box->first[0]; x <= box->last[0]; ++x) {
            for (int y = box->first[1]; y <= box->last[1]; ++y) {
                int *at = near->start + x * g->count[1] + y;
                if (listed)
                    near->entry[(*at)++] = box;
                else
                    ++at[1];
            }
        }
    }
}

/* The columns, with their boxes in `entry`, each up to `start`. Few boxes are one column. */
static grid fill_columns(mbsri_near *near, const spread_of_shapes *spread, int axis, int count)
{
    enum { FEW = 64, BOXES = 4 }; /* BOXES: of a column, on average at least */
    double width[3];
    put_boxes(near, count, width);
    grid g = {.axis = {(axis + 1) % 3, (axis + 2) % 3}, .count = {1, 1}};
    if (count >= FEW) choose_grid(&g, spread, width, count);
    while ((size_t)g.count[0] * (size_t)g.count[1] > (size_t)count / BOXES + 1 ||
           reach_columns(&g, near, count) > (size_t)MBSRI_NEAR_ENTRIES * (size_t)count)
        join_columns(&g);
    const int columns = g.count[0] * g.count[1];
    if (columns == 1) {
        for (int i = 0; i < count; ++i) near->entry[i] = near->box + i;
        near->start[0] = count;
        return g;
    }
    for (int k = 0; k <= columns; ++k) near->start[k] = 0;
    visit_columns(&g, near, count, false);
    for (int k = 0; k < columns; ++k) near->start[k + 1] += near->start[k];
    visit_columns(&g, near, count, true);
    return g;
}

/* Along one axis, without a branch: most boxes that are passed do not overlap along another. */
static int overlaps(const mbsri_box *a, const mbsri_box *b, int k)
{
    return (a->low[k] <= b->high[k]) & (b->low[k] <= a->high[k]);
}

static bool balls_overlap(const mbsri_box *a, const mbsri_box *b)
{
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double apart = 0.5 * ((a->low[k] + a->high[k]) - (b->low[k] + b->high[k]));
        square += apart * apart;
    }
    return !(square > (a->ball + b->ball) * (a->ball + b->ball));
}

/* Whether the box around a shape reaches below a plane or height field. */
static bool reaches(const mbsri_placed *plane, const mbsri_placed *s)
{
    if (plane->shape->field) return mbsri_field_reached(plane, s);
    const double *n = plane->R + 6;
    double least = -plane->shape->margin;
    for (int k = 0; k < 3; ++k)
        least += n[k] * ((n[k] > 0.0 ? s->low[k] : s->high[k]) - plane->x[k]);
    return least <= 0.0;
}

/* Whether column x, y is the first that two boxes share. */
static bool is_first(const mbsri_box *a, const mbsri_box *b, int x, int y)
{
    return (a->first[0] == x || b->first[0] == x) && (a->first[1] == y || b->first[1] == y);
}

static int sweep(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near,
                 const spread_of_shapes *spread, int axis, int *count)
{
    const grid g = fill_columns(near, spread, axis, c->count - c->grounds);
    int begin = 0;
    for (int k = 0; k < g.count[0] * g.count[1]; ++k) {
        const int end = near->start[k], x = k / g.count[1], y = k % g.count[1];
        for (; begin < end; ++begin) {
            const mbsri_box *a = near->entry[begin];
            for (int l = begin + 1; l < end; ++l) {
                const mbsri_box *b = near->entry[l];
                if (!(b->low[axis] <= a->high[axis])) break;
                if (!(overlaps(a, b, g.axis[0]) & overlaps(a, b, g.axis[1])) ||
                    !is_first(a, b, x, y) || !balls_overlap(a, b) ||
                    !mbsri_may_touch(c, a->shape, b->shape))
                    continue;
                const int status = put_pair(c, args, near, a->shape, b->shape, count);
                if (status) return status;
            }
        }
    }
    return MBSR_OK;
}

static int find_on_ground(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near,
                          int *count)
{
    for (int p = 0; p < c->count; ++p) {
        if (!mbsri_is_ground(c->shape[p].kind)) continue;
        for (int s = 0; s < c->count; ++s) {
            if (!mbsri_may_touch(c, p, s) || !reaches(near->placed + p, near->placed + s)) continue;
            const int status = put_pair(c, args, near, p, s, count);
            if (status) return status;
        }
    }
    return MBSR_OK;
}

void mbsri_near_sort(mbsri_near *near, int numbers, int count)
{
    int *start = near->start;
    for (int k = 0; k <= numbers; ++k) start[k] = 0;
    for (int k = 0; k < count; ++k) ++start[near->pair[k][0] + 1];
    for (int k = 0; k < numbers; ++k) start[k + 1] += start[k];
    for (int k = 0; k < count; ++k) {
        int *to = near->spare[start[near->pair[k][0]]++];
        to[0] = near->pair[k][0], to[1] = near->pair[k][1];
    }
    for (int i = 0; i < count; ++i) {
        const int a = near->spare[i][0], b = near->spare[i][1];
        int at = i;
        for (; at > 0 && near->pair[at - 1][0] == a && near->pair[at - 1][1] > b; --at)
            near->pair[at][0] = a, near->pair[at][1] = near->pair[at - 1][1];
        near->pair[at][0] = a, near->pair[at][1] = b;
    }
}

int mbsri_near_find(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near,
                    int *count)
{
    (void)mbsri_near_place(c, args->memory, near);
    *count = 0;
    for (int k = 0; k < c->count; ++k)
        mbsri_near_put(c->shape + k, args->body + c->shape[k].place, near->placed + k);
    if (!near->kept[0]) begin_order(c, near);
    spread_of_shapes spread;
    near->kept[1] = choose_axis(c, near, near->kept[1], &spread);
    sort_order(near, c->count - c->grounds, near->kept[1]);
    int status = sweep(c, args, near, &spread, near->kept[1], count);
    if (!status) status = find_on_ground(c, args, near, count);
    if (!status) mbsri_near_sort(near, c->count, *count);
    return status;
}
