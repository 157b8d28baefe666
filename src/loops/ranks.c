/* Which rows of closures are independent.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rows of C over joint rates in their spans are scaled to about length 1; what counts is the
 * distance of a row from the span of the others.
 *
 * A position may be singular: fewer rows are independent than in the closed positions around it. So
 * two of these are looked at as well, on both sides along a direction that the loops leave free. */
#include "loops/ranks.h"

#include "algebra/dense.h"
#include "loops/assemble.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

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

static int find_ranks(mbsri_ranking *w, const bool *without, const bool *near, bool *dropped,
                      mbsri_ranks *found)
{
    int status;
    if (w->springs) {
        status = ranks_with_springs(w, without, near, dropped, found);
    } else {
        status = mbsri_row_fronts_rank(w->fronts, without, near, dropped, found);
        if (!status) take_shared(w);
    }
    if (status) return status;
    if (found->independent == 0) found->smallest_kept = 0.0;
    if (found->weakest < 0) found->weakest_pivot = 0.0;
    return MBSR_OK;
}

int mbsri_ranks_without(mbsri_ranking *w, const bool *without, bool *dropped, mbsri_ranks *found)
{
    return find_ranks(w, without, NULL, dropped, found);
}

int mbsri_ranks_here(mbsri_ranking *w, bool *dropped, mbsri_ranks *found)
{
    return find_ranks(w, NULL, NULL, dropped, found);
}

/* Along which rows may be independent that are not here, and more of them, along which all loops
 * may close. */
enum { WIDE = 3, DIRECTIONS = 8 };

/* One of some directions of joint rates that the rows leave free, the same in every run, from the
 * vectors that the ranks have left: into x. All zero where there is none. */
static void free_direction(mbsri_ranking *w, int number, double *x)
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
    mbsri_row_fronts_allow(w->fronts, x);
    for (size_t j = 0; j < n; ++j) largest = fmax(largest, fabs(x[j]));
    const double by = largest > 1e-8 ? 1.0 / largest : 0.0;
    for (size_t j = 0; j < n; ++j) x[j] *= w->span[j] * by;
}

/* Some of them. */
static void free_directions(mbsri_ranking *w, int from, int to)
{
    for (int k = from; k < to; ++k) free_direction(w, k, w->free + (size_t)(k * w->n));
}

/* At the positions q, with the vectors of the ranks there. near: see row_fronts.h. */
static int ranks_at(mbsri_ranking *w, double t, const double *q, const bool *near, bool *dropped,
                    mbsri_ranks *found)
{
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
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
    free_direction(w, n, w->x);
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

int mbsri_ranks_around(mbsri_ranking *w, double t, const double *q, bool *dropped,
                       mbsri_ranks *here, int *nearby)
{
    mbsri_ranks widest, closed = mbsri_no_ranks();
    bool found = false;
    int status = ranks_at(w, t, q, NULL, dropped, here);
    if (status) return status;
    if (count_of(here) < w->rows) free_directions(w, 0, WIDE);
    *nearby = here->independent;
    widest = *here;
    status = widest_beside(w, t, q, dropped, &widest);
    const bool singular = count_of(&widest) > count_of(here);
    if (!status && singular) status = ranks_at(w, t, q, NULL, w->other, &closed);
    if (!status && singular) {
        free_directions(w, WIDE, DIRECTIONS);
        status = closed_beside(w, t, q, dropped, count_of(&widest), &closed, &found);
    }
    if (!status && singular) *nearby = found ? closed.independent : widest.independent;
    for (int k = 0; k < w->rows && singular && !status; ++k) dropped[k] = w->beside[k];
    if (!status) status = mbsri_positions(w->m, w->d, t, q);
    return status ? status : mbsri_closure_jacobians(w->m, w->d);
}
