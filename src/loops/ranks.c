/* Which rows of closures are independent.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rows of C over joint rates in their spans, scaled to about length 1, are made orthogonal one
 * after the other, twice each; what is left of a row is its distance from the span of those before,
 * whose square is the pivot of a Cholesky factorisation of C C^T with unit diagonal.
 *
 * A position may be singular: fewer rows are independent than in the closed positions around it. So
 * two of these are looked at as well, on both sides along a direction that the loops leave free. */
#include "loops/ranks.h"

#include "algebra/dense.h"
#include "loops/assemble.h"
#include "recursion/rounding.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

static const mbsri_closure *end_of(const mbsri_row_set *s)
{
    return mbsri_all_closures(s->m) + s->m->closures.count;
}

/* C of row `row` over rate j in its span. */
static double entry_of(const mbsri_row_set *s, int row, size_t j)
{
    return s->C[j * (size_t)s->rows + (size_t)row] * s->span[j];
}

static double norm_of(const mbsri_row_set *s, int row)
{
    double square = 0.0;
    for (size_t j = 0; j < (size_t)s->n; ++j) {
        const double c = entry_of(s, row, j);
        square += c * c;
    }
    return sqrt(square);
}

/* Rows of one kind compare; joint coordinates are others. */
enum { KINDS = 3 };

static void find_scales(const mbsri_row_set *s, double *scale)
{
    double largest[KINDS] = {0.0};
    for (int turn = 0; turn < 2; ++turn) {
        for (const mbsri_closure *c = mbsri_all_closures(s->m); c < end_of(s); ++c) {
            double own[KINDS] = {0.0};
            for (int k = 0; k < c->rows; ++k) {
                const int kind = (int)mbsri_row_kind(s->m, s->d, c, k);
                own[kind] = fmax(own[kind], norm_of(s, c->row + k));
                largest[kind] = fmax(largest[kind], own[kind]);
            }
            for (int k = 0; k < c->rows && turn == 1; ++k) {
                const int kind = (int)mbsri_row_kind(s->m, s->d, c, k);
                scale[c->row + k] = fmax(own[kind], 1e-3 * largest[kind]);
            }
        }
    }
}

/* The distance of row `row`, over its scale, from the span of the first `count` vectors of Q,
 * squared; the rest of it is left in x, of length 1. */
static double distance(const mbsri_row_set *s, int row, int count)
{
    const size_t n = (size_t)s->n;
    const double scale = s->scale[row];
    double *x = s->x;
    if (!(scale > 0.0)) return 0.0;
    for (size_t j = 0; j < n; ++j) x[j] = entry_of(s, row, j) / scale;
    for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < count; ++k) {
            const double *q = s->Q + (size_t)k * n;
            const double part = mbsri_dot(s->n, q, x);
            for (size_t j = 0; j < n; ++j) x[j] -= part * q[j];
        }
    }
    const double square = mbsri_dot(s->n, x, x);
    for (size_t j = 0; j < n && square > 0.0; ++j) x[j] /= sqrt(square);
    return square;
}

/* A pass over rigid rows of one kind: position rows or others. Those that depend on the first
 * `count` vectors of Q and those of this pass are dropped; returns how many vectors there are then.
 */
static int pass(const mbsri_row_set *s, bool positions, int count, bool *dropped,
                mbsri_ranks *found)
{
    for (const mbsri_closure *c = mbsri_all_closures(s->m); c < end_of(s); ++c) {
        for (int k = positions ? 0 : c->position_rows; k < (positions ? c->position_rows : c->rows);
             ++k) {
            const int row = c->row + k;
            if (mbsri_is_stiff(c, k)) continue;
            const double left = count < s->n ? distance(s, c->row + k, count) : 0.0;
            dropped[row] = !(left > s->dependent);
            if (!s->d->dropped[row] && left < found->weakest_pivot) {
                found->weakest_pivot = left;
                found->weakest = row;
            }
            if (dropped[row])
                found->largest_dropped = fmax(found->largest_dropped, left);
            else
                found->smallest_kept = fmin(found->smallest_kept, left);
            if (!dropped[row])
                mbsri_copy((size_t)s->n, s->x, s->Q + (size_t)count++ * (size_t)s->n);
        }
    }
    return count;
}

/* Stiffness of stiff row k of a closure, in the joint rates of the set. */
static double stiffness_of(const mbsri_row_set *s, const mbsri_closure *c, int k)
{
    const double scale = s->scale[c->row + k];
    return mbsri_is_stiff(c, k) ? c->def.stiffness[k] * scale * scale : 0.0;
}

/* Whether it is stiff, and soft beside another row of its closure; rigid ones are not. */
static bool is_soft(const mbsri_row_set *s, const mbsri_closure *c, int k)
{
    static const double soft = 1e-2;
    double most = 0.0;
    for (int l = 0; l < c->position_rows; ++l) most = fmax(most, stiffness_of(s, c, l));
    return mbsri_is_stiff(c, k) && stiffness_of(s, c, k) < soft * most;
}

/* The stiff row, soft or not, that is farthest from the span of those taken, the first of equals;
 * -1 where none is left. */
static int farthest(const mbsri_row_set *s, bool soft)
{
    int at = -1;
    for (const mbsri_closure *c = mbsri_all_closures(s->m); c < end_of(s); ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            if (!mbsri_is_stiff(c, k) || s->left[c->row + k] < 0.0) continue;
            if (at >= 0 && s->left[c->row + k] <= (1.0 + 1e-6) * s->left[at]) continue;
            if (is_soft(s, c, k) != soft) continue;
            at = c->row + k;
        }
    }
    return at;
}

/* Takes from `left`, the squared distances of rows, what vector q of length 1 has of them. */
static void shorten(const mbsri_row_set *s, const double *q)
{
    for (int k = 0; k < s->rows; ++k) {
        double part = 0.0;
        if (!(s->scale[k] > 0.0) || s->left[k] < 0.0) continue;
        for (size_t j = 0; j < (size_t)s->n; ++j) part += q[j] * entry_of(s, k, j);
        part /= s->scale[k];
        s->left[k] = fmax(s->left[k] - part * part, 0.0);
    }
}

/* Where rows of a closure depend on others its soft ones all do without: their forces are known
 * well enough without, and the mechanism moves against them into positions where all rows together
 * lose rank. */
static void leave_out_soft(const mbsri_row_set *s, bool *dropped)
{
    for (const mbsri_closure *c = mbsri_all_closures(s->m); c < end_of(s); ++c) {
        bool some = false;
        for (int k = 0; k < c->position_rows; ++k)
            some = some || (mbsri_is_stiff(c, k) && dropped[c->row + k]);
        for (int k = 0; k < c->position_rows && some; ++k)
            dropped[c->row + k] = dropped[c->row + k] || is_soft(s, c, k);
    }
}

/* Stiff position rows, the farthest from all before first: of those that depend on each other any
 * may do without, and the others are to stay independent for as much of the motion as may be. */
static int pass_springs(const mbsri_row_set *s, int count, bool *dropped)
{
    for (const mbsri_closure *c = mbsri_all_closures(s->m); c < end_of(s); ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const bool looked_at = k < c->position_rows && mbsri_is_stiff(c, k) && count < s->n;
            s->left[c->row + k] = looked_at ? distance(s, c->row + k, count) : 0.0;
        }
    }
    for (int soft = 0; soft < 2; ++soft) {
        for (int at = farthest(s, soft); at >= 0; at = farthest(s, soft)) {
            const double left = count < s->n ? distance(s, at, count) : 0.0;
            dropped[at] = !(left > s->dependent);
            s->left[at] = -1.0;
            if (dropped[at]) continue;
            double *q = s->Q + (size_t)count++ * (size_t)s->n;
            mbsri_copy((size_t)s->n, s->x, q);
            shorten(s, q);
        }
    }
    leave_out_soft(s, dropped);
    return count;
}

/* Rigid position rows, then stiff ones, which nothing else depends on, then the others. */
void mbsri_ranks_of(const mbsri_row_set *s, bool *dropped, mbsri_ranks *found)
{
    find_scales(s, s->scale);
    const int positions = pass(s, true, 0, dropped, found),
              springs = pass_springs(s, positions, dropped) - positions;
    found->springs += springs;
    found->independent += pass(s, false, positions, dropped, found);
}

static mbsri_row_set all_rows(const mbsri_ranking *w)
{
    return (mbsri_row_set){.m = w->m,
                           .d = w->d,
                           .n = w->n,
                           .rows = w->rows,
                           .dependent = MBSRI_DEPENDENT,
                           .C = w->C,
                           .span = w->span,
                           .Q = w->Q,
                           .scale = w->scale,
                           .x = w->x,
                           .left = w->y};
}

void mbsri_rank_scales(mbsri_ranking *w)
{
    const mbsri_row_set s = all_rows(w);
    if (w->fronts)
        mbsri_copy((size_t)w->rows, mbsri_row_fronts_scales(w->fronts), w->scale);
    else
        find_scales(&s, w->scale);
}

static void ranks_of_matrix(mbsri_ranking *w, const bool *without, bool *dropped,
                            mbsri_ranks *found)
{
    const mbsri_row_set s = all_rows(w);
    for (size_t j = 0; j < (size_t)w->n && without; ++j) {
        for (size_t k = 0; k < (size_t)w->rows; ++k) {
            if (without[k]) w->C[j * (size_t)w->rows + k] = 0.0;
        }
    }
    *found = mbsri_no_ranks();
    mbsri_ranks_of(&s, dropped, found);
}

/* ---- on fronts ---- */

enum { RIGID, STIFF, SOFT, LOOSE, LOOSE_SOFT };

void mbsri_late_rows(const mbsr_model *m, const double *scale, int *late)
{
    static const double soft = 1e-2;
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    for (; c < end; ++c) {
        double most = 0.0;
        for (int k = 0, row = c->row; k < c->position_rows; ++k, ++row)
            most = fmax(most, c->def.stiffness[k] * scale[row] * scale[row]);
        for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
            late[row] = RIGID;
            if (!mbsri_is_stiff(c, k)) continue;
            const bool is_soft = c->def.stiffness[k] * scale[row] * scale[row] < soft * most;
            late[row] = (mbsri_is_loose(c, k) ? LOOSE : STIFF) + (is_soft ? 1 : 0);
        }
    }
}

void mbsri_leave_soft(const mbsr_model *m, const int *late, bool *dropped)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    for (; c < end; ++c) {
        bool some = false;
        for (int row = c->row; row < c->row + c->rows; ++row)
            some = some || (dropped[row] && late[row] != RIGID);
        for (int row = c->row; row < c->row + c->rows && some; ++row)
            dropped[row] = dropped[row] || late[row] == SOFT || late[row] == LOOSE_SOFT;
    }
}

static void take_shared(mbsri_ranking *w)
{
    const bool *shared = mbsri_row_fronts_shared(w->fronts);
    for (int k = 0; k < w->rows; ++k) w->shared[k] = shared[k];
}

/* Of springs: distances of rigid rows are those from each other, not in a position nearby. */
static int ranks_with_springs(mbsri_ranking *w, const bool *without, const bool *near,
                              bool *dropped, mbsri_ranks *found)
{
    mbsri_ranks all;
    int status = MBSR_OK;
    *found = mbsri_no_ranks();
    mbsri_late_rows(w->m, mbsri_row_fronts_scales(w->fronts), w->late);
    mbsri_row_fronts_order(w->fronts, w->late);
    if (!near) {
        for (int k = 0; k < w->rows; ++k)
            w->apart[k] = w->late[k] != RIGID || (without && without[k]);
        status = mbsri_row_fronts_rank(w->fronts, w->apart, NULL, w->shared, found);
        take_shared(w);
    }
    if (!status) status = mbsri_row_fronts_rank(w->fronts, without, near, dropped, &all);
    if (status) return status;
    mbsri_leave_soft(w->m, w->late, dropped);
    found->independent = found->springs = 0;
    for (int k = 0; k < w->rows; ++k) {
        if (dropped[k]) continue;
        if (w->late[k] == RIGID)
            ++found->independent;
        else
            ++found->springs;
    }
    return MBSR_OK;
}

static int ranks_on_fronts(mbsri_ranking *w, const bool *without, const bool *near, bool *dropped,
                           mbsri_ranks *found)
{
    if (w->springs) return ranks_with_springs(w, without, near, dropped, found);
    const int status = mbsri_row_fronts_rank(w->fronts, without, near, dropped, found);
    if (!status) take_shared(w);
    return status;
}

/* The ranks on fronts or, without these, by matrices; *found counts for nothing where they are lost
 * then. near: see row_fronts.h. */
static int find_ranks(mbsri_ranking *w, const bool *without, const bool *near, bool *dropped,
                      mbsri_ranks *found)
{
    int status = MBSR_OK;
    if (w->fronts)
        status = ranks_on_fronts(w, without, near, dropped, found);
    else
        ranks_of_matrix(w, without, dropped, found);
    if (status) return status;
    if (found->independent == 0) found->smallest_kept = 0.0;
    if (found->weakest < 0) found->weakest_pivot = 0.0;
    return MBSR_OK;
}

static bool is_lost(const mbsri_ranking *w)
{
    return w->fronts && mbsri_row_fronts_lost(w->fronts);
}

int mbsri_ranks_without(mbsri_ranking *w, const bool *without, bool *dropped, mbsri_ranks *found)
{
    int status = find_ranks(w, without, NULL, dropped, found);
    if (status || !is_lost(w)) return status;
    status = mbsri_ranking_leave_fronts(w);
    if (!status) status = mbsri_ranking_rows(w);
    return status ? status : find_ranks(w, without, NULL, dropped, found);
}

int mbsri_ranks_here(mbsri_ranking *w, bool *dropped, mbsri_ranks *found)
{
    return mbsri_ranks_without(w, NULL, dropped, found);
}

/* Along which rows may be independent that are not here, and more of them, along which all loops
 * may close. */
enum { WIDE = 3, DIRECTIONS = 8 };

/* One of some directions of joint rates that the rows leave free, the same in every run, from the
 * vectors that the ranks have left: into x. All zero where there is none. */
static void free_direction(mbsri_ranking *w, int independent, int number, double *x)
{
    static const double least[DIRECTIONS] = {0.3, -0.5, -0.5, -0.5, -0.5, -0.5, -0.5, -0.5},
                        stride[DIRECTIONS] = {0.6180339887498949, 0.4142135623730951,
                                              0.7320508075688772, 0.2360679774997898,
                                              0.3166247903553998, 0.6055512754639891,
                                              0.1231056256176605, 0.3588989435406740};
    const size_t n = (size_t)w->n;
    double largest = 0.0;
    for (size_t j = 0; j < n; ++j)
        x[j] = least[number] + fmod(stride[number] * (double)(j + 1), 1.0);
    if (w->fronts) mbsri_row_fronts_allow(w->fronts, x);
    for (int pass = 0; pass < 2 && !w->fronts; ++pass) {
        for (int k = 0; k < independent; ++k) {
            const double *q = w->Q + (size_t)k * n;
            const double part = mbsri_dot(w->n, q, x);
            for (size_t j = 0; j < n; ++j) x[j] -= part * q[j];
        }
    }
    for (size_t j = 0; j < n; ++j) largest = fmax(largest, fabs(x[j]));
    const double by = largest > 1e-8 ? 1.0 / largest : 0.0;
    for (size_t j = 0; j < n; ++j) x[j] *= w->span[j] * by;
}

/* Some of them. */
static void free_directions(mbsri_ranking *w, int independent, int from, int to)
{
    for (int k = from; k < to; ++k) free_direction(w, independent, k, w->free + (size_t)(k * w->n));
}

/* At the positions q, with the vectors of the ranks there. near: see row_fronts.h. */
static int ranks_at(mbsri_ranking *w, double t, const double *q, const bool *near, bool *dropped,
                    mbsri_ranks *found)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_ranking_rows(w);
    return status ? status : find_ranks(w, NULL, near, dropped, found);
}

static int count_of(const mbsri_ranks *ranks)
{
    return ranks->independent + ranks->springs;
}

/* Closes loops from w->q on by all rows but those of `dropped` (NULL: none). */
static bool close_beside(mbsri_ranking *w, double t, const bool *dropped)
{
    mbsr_assembly_opt opt = mbsri_assembly_standard();
    mbsr_assembly_info info;
    if (dropped) opt.tolerance = 1e-10; /* independent rows; what counts is the step */
    bool *given = w->apart;             /* which had been let go before */
    for (int k = 0; k < w->rows; ++k) {
        given[k] = w->closer.let_go[k];
        w->closer.let_go[k] = w->closer.let_go[k] || (dropped && dropped[k]);
    }
    const bool closed = mbsri_assemble(&w->closer, t, w->q, &opt, &info) == MBSR_OK;
    for (int k = 0; k < w->rows; ++k) w->closer.let_go[k] = given[k];
    return closed;
}

/* Positions w->q a step along x (of what joint rates span; n) from q, where the rows that are
 * independent at q close loops, and the ranks there, into w->other; *found is false without such a
 * position. */
static int ranks_beside(mbsri_ranking *w, double t, const double *q, const bool *dropped,
                        const double *x, mbsri_ranks *there, bool *found)
{
    static const double step = 3e-3;
    *found = false;
    if (mbsri_is_zero((size_t)w->n, x)) return MBSR_OK;
    const int status = mbsri_displace(w->m, w->d, q, step, x, w->q);
    *found = !status && close_beside(w, t, dropped);
    return *found ? ranks_at(w, t, w->q, dropped, w->other, there) : status;
}

/* The most rows that are independent beside q, where those of `dropped` may open: into w->beside.
 */
static int widest_beside(mbsri_ranking *w, double t, const double *q, const bool *dropped,
                         mbsri_ranks *widest)
{
    int status = MBSR_OK;
    for (int n = 0; n < WIDE && !status && count_of(widest) < w->rows; ++n) {
        mbsri_ranks there;
        bool found;
        const double *along = w->free + (size_t)(n * w->n);
        status = ranks_beside(w, t, q, dropped, along, &there, &found);
        if (status || !found || there.independent < widest->independent ||
            count_of(&there) <= count_of(widest))
            continue;
        *widest = there;
        for (int k = 0; k < w->rows; ++k) w->beside[k] = w->other[k];
    }
    return status;
}

/* Whether all rows close along a direction beside q in a position that is not singular itself; if
 * so, the ranks there, the rows that depend on others into `rows`. */
static int closed_along(mbsri_ranking *w, double t, const double *q, const bool *dropped, int n,
                        bool *rows, mbsri_ranks *there, bool *found)
{
    mbsri_ranks around;
    int status = ranks_beside(w, t, q, dropped, w->free + (size_t)(n * w->n), there, found);
    if (status || !*found) return status;
    *found = close_beside(w, t, NULL);
    if (!*found) return MBSR_OK;
    mbsri_copy((size_t)w->m->nq, w->q, w->q_beside);
    status = ranks_at(w, t, w->q_beside, NULL, rows, there);
    if (status) return status;
    free_direction(w, there->independent, n, w->x);
    status = ranks_beside(w, t, w->q_beside, rows, w->x, &around, found);
    *found = *found && count_of(&around) <= count_of(there);
    return status;
}

/* Of such positions the one with the most rows that are independent, into `closed` and w->beside:
 * one loop may have closed in its singular position again. `most`: there are no more. */
static int closed_beside(mbsri_ranking *w, double t, const double *q, const bool *dropped, int most,
                         mbsri_ranks *closed, bool *found)
{
    bool *rows = w->beside + w->rows;
    int status = MBSR_OK;
    *found = false;
    for (int n = 0; n < DIRECTIONS && !status; ++n) {
        mbsri_ranks there;
        bool closes;
        if (*found && count_of(closed) >= most) break;
        status = closed_along(w, t, q, dropped, n, rows, &there, &closes);
        if (status || !closes || (*found && count_of(&there) <= count_of(closed))) continue;
        *found = true;
        *closed = there;
        for (int k = 0; k < w->rows; ++k) w->beside[k] = rows[k];
    }
    return status;
}

static int look_around(mbsri_ranking *w, double t, const double *q, bool *dropped,
                       mbsri_ranks *here, int *nearby)
{
    mbsri_ranks widest, closed = mbsri_no_ranks();
    bool found = false;
    int status = ranks_at(w, t, q, NULL, dropped, here);
    if (status || is_lost(w)) return status;
    if (count_of(here) < w->rows) free_directions(w, here->independent, 0, WIDE);
    *nearby = here->independent;
    widest = *here;
    status = widest_beside(w, t, q, dropped, &widest);
    const bool singular = count_of(&widest) > count_of(here);
    if (!status && singular) status = ranks_at(w, t, q, NULL, w->other, &closed);
    if (!status && singular) {
        free_directions(w, closed.independent, WIDE, DIRECTIONS);
        status = closed_beside(w, t, q, dropped, count_of(&widest), &closed, &found);
    }
    if (!status && singular) *nearby = found ? closed.independent : widest.independent;
    for (int k = 0; k < w->rows && singular && !status; ++k) dropped[k] = w->beside[k];
    if (!status) status = mbsri_positions(w->m, w->d, t, q);
    return status ? status : mbsri_ranking_rows(w);
}

int mbsri_ranks_around(mbsri_ranking *w, double t, const double *q, bool *dropped,
                       mbsri_ranks *here, int *nearby)
{
    int status = look_around(w, t, q, dropped, here, nearby);
    if (status || !is_lost(w)) return status;
    status = mbsri_ranking_leave_fronts(w);
    return status ? status : look_around(w, t, q, dropped, here, nearby);
}
