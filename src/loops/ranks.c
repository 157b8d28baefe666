/* Which rows of closures are independent.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rows of C, scaled to about length 1, are made orthogonal one after the other, twice each; what is left of a
 * row is its distance from the span of those before, whose square is the pivot of a Cholesky
 * factorisation of C C^T with unit diagonal.
 *
 * A position may be singular: fewer rows are independent than in the closed positions around it. So two
 * of these are looked at as well, on both sides along a direction that the loops leave free. */
#include "loops/ranks.h"

#include "algebra/dense.h"
#include "loops/assemble.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

/* Squared distances below this are zero [choice]. */
static const double DEPENDENT = 1e-10;

static double norm_of(const mbsri_dense *w, int row)
{
    double square = 0.0;
    for (int j = 0; j < w->n; ++j) {
        const double c = w->C[(size_t)j * (size_t)w->rows + (size_t)row];
        square += c * c;
    }
    return sqrt(square);
}

/* What a row measures: turns of bodies, joint coordinates, or places; rows of one kind compare. */
enum { TURN, JOINTS, PLACE, KINDS };

static int kind_of(const mbsri_dense *w, const mbsri_closure *c, int k)
{
    const double *C = w->d->closure_C + c->at + k;
    bool linear = false;
    if (c->def.table->flags & MBSR_CLOSURE_JOINTS) return JOINTS;
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = w->m->body + c->body[l];
        const bool space = b->joint.space == MBSR_SPACE_SPATIAL,
                   plane = b->joint.space == MBSR_SPACE_PLANAR;
        const int from = space ? 3 : 0, to = space ? 6 : plane ? 2 : b->d;
        for (int j = from; j < to && c->column[l] >= 0; ++j)
            linear = linear || fabs(C[(size_t)(c->column[l] + j) * (size_t)c->rows]) > 0.0;
    }
    return linear ? PLACE : TURN;
}

void mbsri_rank_scales(const mbsri_dense *w, double *scale)
{
    const mbsri_closure *first = w->m->closures.data;
    double largest[KINDS] = {0.0};
    for (int pass = 0; pass < 2; ++pass) {
        for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
            double own[KINDS] = {0.0};
            for (int k = 0; k < c->rows; ++k) {
                const int kind = kind_of(w, c, k);
                own[kind] = fmax(own[kind], norm_of(w, c->row + k));
                largest[kind] = fmax(largest[kind], own[kind]);
            }
            for (int k = 0; k < c->rows && pass == 1; ++k) {
                const int kind = kind_of(w, c, k);
                scale[c->row + k] = fmax(own[kind], 1e-3 * largest[kind]);
            }
        }
    }
}

/* The distance of row `row`, over its scale, from the span of the first `count` vectors of Q (n numbers
 * each), squared; the rest of it is left in x, of length 1. */
static double distance(const mbsri_dense *w, int row, double scale, int count, const double *Q,
                       double *x)
{
    const size_t n = (size_t)w->n, rows = (size_t)w->rows;
    if (!(scale > 0.0)) return 0.0;
    for (size_t j = 0; j < n; ++j) x[j] = w->C[j * rows + (size_t)row] / scale;
    for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < count; ++k) {
            const double *q = Q + (size_t)k * n;
            const double part = mbsri_dot(w->n, q, x);
            for (size_t j = 0; j < n; ++j) x[j] -= part * q[j];
        }
    }
    const double square = mbsri_dot(w->n, x, x);
    for (size_t j = 0; j < n && square > 0.0; ++j) x[j] /= sqrt(square);
    return square;
}

/* A pass over rows of one kind: position rows or others, rigid or stiff. Those that depend on the first
 * `count` vectors of Q and those of this pass are dropped; returns how many vectors there are then. */
static int pass(mbsri_dense *w, bool held, bool stiff, int count, bool *dropped, mbsri_ranks *found)
{
    const mbsri_closure *first = w->m->closures.data;
    double *Q = w->A;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = held ? 0 : c->held; k < (held ? c->held : c->rows); ++k) {
            const int row = c->row + k;
            if (mbsri_is_stiff(c, k) != stiff) continue;
            const double left =
                count < w->n ? distance(w, row, w->right[row], count, Q, w->x) : 0.0;
            dropped[row] = !(left > DEPENDENT);
            if (!stiff && !w->d->dropped[row] && left < found->weakest_pivot) {
                found->weakest_pivot = left;
                found->weakest = row;
            }
            if (!stiff && dropped[row])
                found->largest_dropped = fmax(found->largest_dropped, left);
            else if (!stiff)
                found->smallest_kept = fmin(found->smallest_kept, left);
            if (!dropped[row]) mbsri_copy((size_t)w->n, w->x, Q + (size_t)count++ * (size_t)w->n);
        }
    }
    return count;
}

/* Rigid position rows, then stiff ones, which nothing else depends on, then the others. */
void mbsri_ranks_here(mbsri_dense *w, bool *dropped, mbsri_ranks *found)
{
    mbsri_rank_scales(w, w->right);
    *found = (mbsri_ranks){.smallest_kept = INFINITY, .weakest = -1, .weakest_pivot = INFINITY};
    const int held = pass(w, true, false, 0, dropped, found);
    found->springs = pass(w, true, true, held, dropped, found) - held;
    found->independent = pass(w, false, false, held, dropped, found);
    if (found->independent == 0) found->smallest_kept = 0.0;
    if (found->weakest < 0) found->weakest_pivot = 0.0;
}

/* A direction of joint rates that the rows leave free, the same in every run, from the vectors that
 * mbsri_ranks_here has left: into w->x. False where there is none. */
static bool free_direction(mbsri_dense *w, int independent)
{
    const size_t n = (size_t)w->n;
    double largest = 0.0;
    for (size_t j = 0; j < n; ++j) w->x[j] = 0.3 + fmod(0.6180339887498949 * (double)(j + 1), 1.0);
    for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < independent; ++k) {
            const double *q = w->A + (size_t)k * n;
            const double part = mbsri_dot(w->n, q, w->x);
            for (size_t j = 0; j < n; ++j) w->x[j] -= part * q[j];
        }
    }
    for (size_t j = 0; j < n; ++j) largest = fmax(largest, fabs(w->x[j]));
    if (!(largest > 1e-8)) return false;
    for (size_t j = 0; j < n; ++j) w->x[j] /= largest;
    return true;
}

int mbsri_ranks_around(mbsri_dense *w, double t, const double *q, bool *dropped, mbsri_ranks *here,
                       int *nearby)
{
    static const double step = 1e-3; /* rad or m */
    const mbsr_assembly_opt opt = mbsri_assembly_standard();
    mbsri_ranks there;
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_dense_rows(w);
    if (status) return status;
    mbsri_ranks_here(w, dropped, here);
    *nearby = here->independent;
    int springs = here->springs;
    if (here->independent + springs == w->rows || !free_direction(w, here->independent))
        return MBSR_OK;
    bool *other = w->other;
    double *direction = w->sigma;
    mbsri_copy((size_t)w->n, w->x, direction);
    for (int side = -1; side <= 1; side += 2) {
        status = mbsri_positions(w->m, w->d, t, q);
        if (!status) status = mbsri_displace(w, q, side * step, direction, w->q);
        if (status) return status;
        mbsr_assembly_info info;
        status = mbsri_assemble(w, t, w->q, &opt, &info);
        if (status) continue; /* no closed position on this side */
        status = mbsri_positions(w->m, w->d, t, w->q);
        if (!status) status = mbsri_dense_rows(w);
        if (status) return status;
        mbsri_ranks_here(w, other, &there);
        if (there.independent < *nearby || there.independent + there.springs <= *nearby + springs)
            continue;
        *nearby = there.independent;
        springs = there.springs;
        for (int k = 0; k < w->rows; ++k) dropped[k] = other[k];
    }
    status = mbsri_positions(w->m, w->d, t, q);
    return status ? status : mbsri_dense_rows(w);
}
