/* Where loops meet and close in the vectorised sweeps: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/loops_close.h"

#include "algebra/dense.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

/* ---- what meets ---- */

static int group_of(int *group, int k)
{
    while (group[k] != k) k = group[k] = group[group[k]];
    return k;
}

/* Parts that share an unknown belong together: those of one group follow each other by w->mate. */
static void group_parts(mbsri_loop_run *w, const mbsri_open_part *part, int count)
{
    for (int p = 0; p < count; ++p) {
        const mbsri_open open = mbsri_open_at(part + p);
        w->group[p] = p;
        for (int k = 0; k < open.count; ++k) {
            int *slot = w->slot + open.id[k];
            if (*slot >= 0) w->group[group_of(w->group, *slot)] = p;
            *slot = p;
        }
    }
    for (int p = 0; p < count; ++p) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) w->slot[open.id[k]] = -1;
        w->mate[p] = -1;
    }
    for (int p = 0; p < count; ++p) {
        const int head = group_of(w->group, p);
        if (head == p) continue;
        w->mate[p] = w->mate[head];
        w->mate[head] = p;
    }
}

static bool row_is_complete(const mbsri_loop_run *w, int id, int i)
{
    return id >= w->run->model->rows || w->loops->closes[id] >= i;
}

/* The unknowns of a group into `set`, those that may be eliminated at body i first, and their
 * places; where no row is among these, nothing is. */
static int find_unknowns(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i, int *set,
                         int *complete)
{
    int count = 0;
    bool rows = i == 0;
    for (int turn = 0; turn < 2; ++turn) {
        for (int p = head; p >= 0; p = w->mate[p]) {
            const mbsri_open open = mbsri_open_at(part + p);
            for (int k = 0; k < open.count; ++k) {
                const int id = open.id[k];
                if (w->slot[id] >= 0 || row_is_complete(w, id, i) != (turn == 0)) continue;
                rows = rows || (turn == 0 && id < w->run->model->rows);
                w->slot[id] = count;
                set[count++] = id;
            }
        }
        if (turn == 0) *complete = count;
    }
    if (!rows) *complete = 0;
    return count;
}

/* ---- what goes on ---- */

/* Those of parts where nothing closes. */
static void add_open(const mbsri_loop_run *w, const mbsri_open *from, const mbsri_open *to,
                     int base)
{
    for (int k = 0; k < from->count; ++k) {
        const int column = base + w->slot[from->id[k]];
        for (int l = 0; l < from->count; ++l) {
            const int entry = column * to->count + base + w->slot[from->id[l]];
            to->F[entry] += from->F[k * from->count + l];
            to->sizes[entry] += from->sizes[k * from->count + l];
        }
        for (int l = 0; l < 8; ++l) {
            to->Q[8 * column + l] += from->Q[8 * k + l];
            to->lengths[8 * column + l] += from->lengths[8 * k + l];
        }
    }
}

static void clear_slots(mbsri_loop_run *w, const int *set, int count)
{
    for (int k = 0; k < count; ++k) w->slot[set[k]] = -1;
}

/* A group closes, or goes on as it is, its open unknowns from place `base` on; their number, or -1.
 */
static int pass_group(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i,
                      const mbsri_open *to, int base, bool *closed)
{
    int *set = w->set, complete = 0;
    const int size = find_unknowns(w, part, head, i, set, &complete);
    bool served = true;
    if (complete > 0) {
        served = mbsri_loops_close_plainly(w, part, head, i, set, size, complete, to, base) ||
                 mbsri_loops_close_group(w, part, head, i, set, size, complete, to, base);
        *closed = true;
    }
    for (int p = head; p >= 0 && complete == 0; p = w->mate[p]) {
        const mbsri_open open = mbsri_open_at(part + p);
        add_open(w, &open, to, base);
    }
    memcpy(to->id + base, set + complete, (size_t)(size - complete) * sizeof *set);
    clear_slots(w, set, size);
    return served ? size - complete : -1;
}

/* How many unknowns of all groups go on; -1: with more motions than rows. */
static int count_open(mbsri_loop_run *w, const mbsri_open_part *part, int count, int i)
{
    int open = 0, motions = 0;
    for (int head = 0; head < count; ++head) {
        int complete = 0;
        if (w->group[head] != head) continue;
        const int size = find_unknowns(w, part, head, i, w->set, &complete);
        clear_slots(w, w->set, size);
        for (int k = complete; k < size; ++k) motions += w->set[k] >= w->run->model->rows;
        open += size - complete;
    }
    return 2 * motions > open ? -1 : open;
}

static void tie_all(mbsri_loop_run *w, int count)
{
    for (int p = 0; p < count; ++p) {
        w->group[p] = 0;
        w->mate[p] = p + 1 < count ? p + 1 : -1;
    }
}

/* What rows read of the root, whose acceleration is known. */
static void read_root(mbsri_loop_run *w, const mbsri_open_part *part, int count)
{
    const double *A = w->run->state[0].A_v;
    for (int p = 0; p < count; ++p) {
        const mbsri_open open = mbsri_open_at(part + p);
        for (int k = 0; k < open.count; ++k) w->s[open.id[k]] -= mbsri_dot3(open.Q + 8 * k + 4, A);
    }
}

/* The parts that meet at body i, group by group, and what goes on. */
static bool join_parts(mbsri_loop_run *w, mbsri_open_part *part, int count, int i, bool *closed)
{
    int base = 0;
    if (count > 1 && w->run->tree->body[i].flags & MBSRI_CLOSES)
        group_parts(w, part, count);
    else
        tie_all(w, count);
    const mbsri_open_part all = {i, count_open(w, part, count, i), w->top};
    if (all.count < 0) return false;
    const size_t size = mbsri_open_size((size_t)all.count);
    const mbsri_open to = mbsri_open_at(&all);
    mbsri_zero(size, all.at);
    w->top += size;
    for (int head = 0; head < count; ++head) {
        if (w->group[head] != head) continue;
        const int passed = pass_group(w, part, head, i, &to, base, closed);
        if (passed < 0) return false;
        base += passed;
    }
    memmove(part->at, all.at, size * sizeof *all.at);
    *part = (mbsri_open_part){i, all.count, part->at};
    return true;
}

/* Groups whose forces follow from joints without motors are taken out of the parts; true: those are
 * all. */
static bool determine(mbsri_loop_run *w, mbsri_open_part *part, int count, int i, bool *closed)
{
    bool all = true;
    group_parts(w, part, count);
    for (int head = 0; head < count; ++head) {
        if (w->group[head] != head || part[head].count == 0) continue;
        if (!mbsri_open_loops_determine(w, part, head, i)) {
            all = false;
            continue;
        }
        *closed = true;
        for (int p = head; p >= 0; p = w->mate[p]) part[p].count = 0;
    }
    return all;
}

static bool meet_all(mbsri_loop_run *w, int i, bool *closed)
{
    const bool closes = w->run->tree->body[i].flags & MBSRI_CLOSES;
    int first = w->parts;
    *closed = false;
    while (first > 0 && w->part[first - 1].body == i) --first;
    mbsri_open_loops_end(w, i);
    mbsri_open_part *part = w->part + first;
    const int count = w->parts - first;
    if (count == 0 || (count == 1 && !closes)) return true;
    if (i == 0 && !w->motor) read_root(w, part, count);
    mbsri_loops_clear_sums(w);
    if (closes && w->motor && determine(w, part, count, i, closed)) {
        part->count = 0;
    } else if (closes && mbsri_loops_close_alone(w, part, count, i)) {
        *closed = true;
        part->count = 0;
    } else if (!join_parts(w, part, count, i, closed)) {
        w->stuck = true;
        return false;
    }
    w->top = part->at + mbsri_open_size((size_t)part->count);
    w->parts = part->count > 0 ? first + 1 : first;
    return true;
}

bool mbsri_open_loops_meet(mbsri_loop_run *w, int i, bool *closed)
{
    if (!meet_all(w, i, closed)) return false;
    if (w->loops->joints) mbsri_open_loops_couple(w, i);
    return true;
}

/* ---- root to leaves ---- */

void mbsri_open_loops_close(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_state *s = w->run->state + i;
    double A[6];
    memcpy(A, s->A_w, 3 * sizeof *A);
    memcpy(A + 3, s->A_v, 3 * sizeof *A);
    for (; w->last && w->last->closes && w->last->body == i; w->last = w->last->before)
        mbsri_pivots_backward((const mbsri_pivots *)(void *)(w->last + 1), w->s, A, w->v);
}
