/* Shapes near each other: see near.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Boxes along the world's axes, sorted by where they begin along the axis along which shapes are
 * spread most, and swept. The order of the last call is kept, since it seldom changes much; what is
 * found does not depend on it. */
#include "contact/near.h"

#include "algebra/space3.h"
#include "contact/error.h"
#include "contact/field.h"

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

/* The axis with the largest variance, another than the last where it is twice as large. */
static int choose_axis(const mbsr_contacts *c, const mbsri_near *near, int last)
{
    double spread[3];
    int best = last;
    for (int k = 0; k < 3; ++k) {
        double sum = 0.0, square = 0.0;
        for (int i = 0; i < c->count - c->grounds; ++i) {
            const double x = near->placed[near->order[i]].x[k] - near->placed[near->order[0]].x[k];
            sum += x;
            square += x * x;
        }
        spread[k] = square - sum * sum / (c->count - c->grounds);
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

static void put_boxes(const mbsri_near *near, int count)
{
    for (int i = 0; i < count; ++i) {
        const mbsri_placed *placed = near->placed + near->order[i];
        mbsri_box *box = near->box + i;
        for (int k = 0; k < 3; ++k) box->low[k] = placed->low[k], box->high[k] = placed->high[k];
        box->shape = near->order[i];
    }
}

/* Along one axis, without a branch: most boxes that are passed do not overlap along another. */
static int overlaps(const mbsri_box *a, const mbsri_box *b, int k)
{
    return (a->low[k] <= b->high[k]) & (b->low[k] <= a->high[k]);
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

static int sweep(const mbsr_contacts *c, const mbsr_force_args *args, mbsri_near *near, int axis,
                 int *count)
{
    const mbsri_box *const end = near->box + (c->count - c->grounds);
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    put_boxes(near, c->count - c->grounds);
    for (const mbsri_box *a = near->box; a < end; ++a) {
        for (const mbsri_box *b = a + 1; b < end && b->low[axis] <= a->high[axis]; ++b) {
            if (!(overlaps(a, b, next) & overlaps(a, b, last)) ||
                !mbsri_may_touch(c, a->shape, b->shape))
                continue;
            const int status = put_pair(c, args, near, a->shape, b->shape, count);
            if (status) return status;
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
    near->kept[1] = choose_axis(c, near, near->kept[1]);
    sort_order(near, c->count - c->grounds, near->kept[1]);
    int status = sweep(c, args, near, near->kept[1], count);
    if (!status) status = find_on_ground(c, args, near, count);
    if (!status) mbsri_near_sort(near, c->count, *count);
    return status;
}
