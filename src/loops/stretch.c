/* How well loops hold the directions of a tree that move no mass: see stretch.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A direction begins with a null vector of a joint's block D and goes on, body by body, as far as
 * bodies move (recursion/forward.h). What the rows see of it, over its largest rate, are the
 * entries of a sparse matrix. Directions that rows have in common belong together, and so do
 * singular values. */
#include "loops/stretch.h"

#include "algebra/classes.h"
#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "fronts/plan.h"
#include "recursion/closures.h"
#include "recursion/forward.h"
#include "recursion/group.h"

#include <math.h>

typedef struct entry {
    int row;
    double value;
} entry;

typedef struct stretching {
    const mbsri_ranking *w;
    const double *scale;
    int directions;
    mbsri_array entries;  /* direction by direction */
    int *first;           /* directions + 1: where those of each begin */
    int *leader, *next;   /* directions: of those that belong together; the next one of these */
    int *seen;            /* rows: a direction that it sees, -1: none; then its place */
    int *end, *other_end; /* bodies + 1, ends: of closures at a body */
    int *mark;            /* closures: the last direction whose entries it has */
    int *children;        /* bodies + 1 */
    int *moved;           /* bodies: of the direction at work */
    int moves;
    double *a, *x, *z; /* nu, d, n of a group */
    void *memory;
} stretching;

/* ---- memory ---- */

static int no_memory_for_stretch(const stretching *s)
{
    return mbsri_fail(&s->w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for %d directions without mass", s->w->function,
                      s->directions);
}

static int open_stretching(stretching *s)
{
    const mbsr_model *m = s->w->m;
    const size_t bodies = (size_t)m->bodies + 1, k = (size_t)s->directions,
                 closures = m->closures.count, rows = (size_t)m->rows,
                 numbers = (size_t)m->nu + (size_t)m->most.d + (size_t)m->most.n,
                 ints = 3 * k + 1 + rows + 3 * bodies + closures * (MBSRI_ENDS + 1);
    s->memory = mbsri_allocate(&m->allocator, numbers * sizeof(double) + ints * sizeof(int));
    if (!s->memory) return no_memory_for_stretch(s);
    s->a = s->memory;
    s->x = s->a + m->nu;
    s->z = s->x + m->most.d;
    s->first = (int *)(void *)(s->z + m->most.n);
    s->leader = s->first + k + 1;
    s->next = s->leader + k;
    s->seen = s->next + k;
    s->end = s->seen + rows;
    s->children = s->end + bodies;
    s->moved = s->children + bodies;
    s->mark = s->moved + bodies;
    s->other_end = s->mark + closures;
    mbsri_zero((size_t)m->nu, s->a);
    for (size_t i = 0; i < rows; ++i) s->seen[i] = -1;
    for (size_t i = 0; i < closures; ++i) s->mark[i] = -1;
    for (size_t i = 0; i < bodies; ++i) s->end[i] = -1, s->children[i] = 0;
    for (size_t i = 0; i < bodies; ++i) s->w->d->carries[i] = false;
    for (size_t i = 1; i < bodies; ++i) ++s->children[m->body[i].parent];
    return MBSR_OK;
}

static void sort_ends(stretching *s)
{
    const mbsri_closure *c = mbsri_all_closures(s->w->m);
    for (int id = 0; id < (int)s->w->m->closures.count; ++id, ++c) {
        for (int l = 0; l < c->bodies; ++l) {
            const int end = id * MBSRI_ENDS + l;
            if (!mbsri_plan_reads(c, l)) continue;
            s->other_end[end] = s->end[c->body[l]];
            s->end[c->body[l]] = end;
        }
    }
}

/* ---- what rows see ---- */

/* Row k of a closure on the direction at work; zero where it is rounding. */
static double seen_by(const stretching *s, const mbsri_closure *c, int k)
{
    static const double rounding = 1e-13;
    const mbsr_data *d = s->w->d;
    double sum = 0.0, size = 0.0;
    for (int l = 0; l < c->bodies; ++l) {
        if (!mbsri_plan_reads(c, l)) continue;
        const mbsri_body *b = s->w->m->body + c->body[l];
        const double *C = d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k);
        for (int j = 0; j < b->d && d->carries[c->body[l]]; ++j) {
            const double part = C[j * c->rows] * d->Az[b->v + (size_t)j];
            sum += part, size += fabs(part);
        }
        for (int j = 0; j < b->n && mbsri_reads_joints(c); ++j) {
            const double part = C[(b->d + j) * c->rows] * s->a[b->u + j];
            sum += part, size += fabs(part);
        }
    }
    return fabs(sum) > rounding * size ? sum : 0.0;
}

static bool add_entries(stretching *s, const mbsri_closure *c, int direction, double size)
{
    const mbsr_allocator *allocator = &s->w->m->allocator;
    for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
        if (s->w->left_out[row] || !(s->scale[row] > 0.0)) continue;
        const double value = seen_by(s, c, k) / (size * s->scale[row]);
        if (value == 0.0) continue;
        if (!mbsri_reserve(allocator, &s->entries, 1, sizeof(entry))) return false;
        ((entry *)s->entries.data)[s->entries.count++] = (entry){row, value};
        if (s->seen[row] < 0)
            s->seen[row] = direction;
        else
            mbsri_class_join(s->leader, direction, s->seen[row]);
    }
    return true;
}

/* Those of all closures at the bodies that the direction moves. */
static bool look_at_rows(stretching *s, int direction)
{
    const mbsr_model *m = s->w->m;
    double size = 0.0;
    for (int n = 0; n < s->moves; ++n) {
        const mbsri_body *b = m->body + s->moved[n];
        for (int k = b->u; k < b->u + b->n; ++k) size = fmax(size, fabs(s->a[k]) / s->w->span[k]);
    }
    for (int n = 0; n < s->moves && size > 0.0; ++n) {
        for (int end = s->end[s->moved[n]]; end >= 0; end = s->other_end[end]) {
            const int id = end / MBSRI_ENDS;
            if (s->mark[id] == direction) continue;
            s->mark[id] = direction;
            if (!add_entries(s, mbsri_all_closures(m) + id, direction, size)) return false;
        }
    }
    return true;
}

/* ---- directions ---- */

/* One step of the direction that begins at body `from`; pending: bodies that those before move. */
static void take_step(stretching *s, int i, int from, int *pending)
{
    const mbsr_model *m = s->w->m;
    mbsr_data *d = s->w->d;
    if (i > from && d->carries[m->body[i].parent]) --*pending;
    if (!mbsri_heads(m, d, i)) return;
    const mbsri_group g = mbsri_group_of(m, d, i);
    const bool below = i > from && mbsri_null_below(m, d, i, s->x);
    if (!below && i > from) return;
    if (i > from) mbsri_zero((size_t)g.n, s->z);
    mbsri_null_pass(m, d, &g, i == from, below, s->x, s->z);
    mbsri_group_scatter(m, &g, s->z, s->a);
    for (int k = 0; k < g.members; ++k) {
        s->moved[s->moves++] = g.member[k];
        if (d->carries[g.member[k]]) *pending += s->children[g.member[k]];
    }
}

/* The direction of the null vector in s->z of the group of head i. */
static bool follow_direction(stretching *s, int i, int direction)
{
    const mbsr_model *m = s->w->m;
    int pending = 0;
    s->moves = 0;
    take_step(s, i, i, &pending);
    for (int j = i + 1; j <= m->bodies && pending > 0; ++j) take_step(s, j, i, &pending);
    const bool done = look_at_rows(s, direction);
    for (int n = 0; n < s->moves; ++n) {
        const mbsri_body *b = m->body + s->moved[n];
        s->w->d->carries[s->moved[n]] = false;
        mbsri_zero((size_t)b->n, s->a + b->u);
    }
    return done;
}

static int find_entries(stretching *s)
{
    const mbsr_model *m = s->w->m;
    const mbsr_data *d = s->w->d;
    int direction = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        for (int l = mbsri_group_rank(d, &g); l < g.n; ++l, ++direction) {
            const double *X = d->X + m->body[i].nn + l * g.n;
            s->first[direction] = (int)s->entries.count;
            s->leader[direction] = direction;
            for (int k = 0; k < g.n; ++k) s->z[k] = d->s[g.ig + k] * X[k];
            if (!follow_direction(s, i, direction)) return no_memory_for_stretch(s);
        }
    }
    s->first[direction] = (int)s->entries.count;
    return MBSR_OK;
}

/* ---- singular values ---- */

/* What is known of them. */
typedef struct extremes {
    double largest, smallest;
    int row;
} extremes;

/* Places of the rows that directions from l on see, into s->seen; how many there are, and how many
 * directions. */
static int number_rows(stretching *s, int l, int *directions)
{
    const entry *e = s->entries.data;
    int rows = 0;
    for (*directions = 0; l >= 0; l = s->next[l], ++*directions) {
        for (int k = s->first[l]; k < s->first[l + 1]; ++k) {
            if (s->seen[e[k].row] == -1) s->seen[e[k].row] = rows++;
        }
    }
    return rows;
}

/* Of directions from l on, that belong together. */
static int add_extremes(stretching *s, int l, extremes *found)
{
    int directions;
    const entry *e = s->entries.data;
    const int rows = number_rows(s, l, &directions), size = rows > directions ? rows : directions,
              held = rows < directions ? rows : directions, lwork = mbsri_lapack_svd_work(size);
    const size_t N = (size_t)size, square = N * N;
    if (held == 0) return MBSR_OK;
    double *A =
        mbsri_allocate(&s->w->m->allocator, (3 * square + N + (size_t)lwork) * sizeof(double));
    if (!A) return no_memory_for_stretch(s);
    double *U = A + square, *V = U + square, *sigma = V + square, *work = sigma + N;
    mbsri_zero(square, A);
    int column = 0;
    for (int at = l; at >= 0; at = s->next[at], ++column) {
        for (int k = s->first[at]; k < s->first[at + 1]; ++k)
            A[(size_t)column * N + (size_t)s->seen[e[k].row]] = e[k].value;
    }
    const int info = mbsri_lapack_svd(size, A, sigma, U, V, work, lwork);
    found->largest = fmax(found->largest, sigma[0]);
    if (!info && sigma[held - 1] < found->smallest) {
        double most = -1.0;
        found->smallest = sigma[held - 1];
        for (int at = l; at >= 0; at = s->next[at]) {
            for (int k = s->first[at]; k < s->first[at + 1]; ++k) {
                const double part = fabs(U[(size_t)(held - 1) * N + (size_t)s->seen[e[k].row]]);
                if (part > most || (part == most && e[k].row < found->row))
                    most = part, found->row = e[k].row;
            }
        }
    }
    mbsri_release(&s->w->m->allocator, A);
    if (!info) return MBSR_OK;
    return mbsri_fail(&s->w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                      "%s: no singular values of rows on directions without mass", s->w->function);
}

static int find_extremes(stretching *s, extremes *found)
{
    int status = MBSR_OK;
    for (int k = 0; k < s->w->rows; ++k) s->seen[k] = -1;
    for (int l = 0; l < s->directions; ++l) s->next[l] = -1;
    for (int l = s->directions - 1; l >= 0; --l) {
        const int leader = mbsri_class_of(s->leader, l);
        if (leader == l) continue;
        s->next[l] = s->next[leader];
        s->next[leader] = l;
    }
    for (int l = 0; l < s->directions && !status; ++l) {
        if (s->leader[l] == l) status = add_extremes(s, l, found);
    }
    return status;
}

int mbsri_loops_stretch(mbsri_ranking *w, const double *scale, double *stretch, int *row)
{
    stretching s = {.w = w, .scale = scale, .directions = w->n - w->d->total_rank};
    extremes found = {.smallest = INFINITY, .row = -1};
    *stretch = 1.0;
    *row = -1;
    if (s.directions == 0) return MBSR_OK;
    int status = open_stretching(&s);
    if (!status) {
        sort_ends(&s);
        status = find_entries(&s);
    }
    if (!status) status = find_extremes(&s, &found);
    if (!status && found.largest > 0.0) {
        *stretch = found.smallest / found.largest;
        *row = found.row;
    }
    mbsri_release(&w->m->allocator, s.entries.data);
    mbsri_release(&w->m->allocator, s.memory);
    return status;
}
