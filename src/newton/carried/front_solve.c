/* Solving with fronts: see front_solve.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Leaves to root, the right-hand sides go the way of the rows: L of the eliminated ones is taken
 * off, what is left stands in the pool above and in b of the body above. Root to leaves, U gives
 * the unknowns that went from those that were carried on and from x of that body. */
#include "newton/carried/front_solve.h"

#include "algebra/dense.h"
#include "recursion/closures.h"

#include <stdbool.h>

void mbsri_front_load(mbsr_newton *w, const double *r)
{
    mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    mbsri_zero(v->right_count, v->store + v->right);
    const double *of_rows = r ? r + m->nq + 2 * m->nu : NULL;
    for (int k = 0; k < m->rows + m->position_rows && r; ++k) {
        const mbsri_multiplier *multiplier = v->multiplier + k;
        if (multiplier->right >= 0) v->store[multiplier->right] = multiplier->in * of_rows[k];
    }
}

void mbsri_front_multipliers(const mbsr_newton *w, const double *r, double *delta)
{
    const mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < m->rows + m->position_rows; ++k) {
        const mbsri_multiplier *multiplier = v->multiplier + k;
        if (multiplier->right >= 0)
            delta[first + k] = v->value[k] * multiplier->out;
        else
            delta[first + k] = r ? r[first + k] : 0.0;
    }
}

void mbsri_front_multipliers_transposed(mbsr_newton *w, const double *v, double *x)
{
    mbsri_carried *carried = &w->carried;
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    mbsri_zero((size_t)carried->names, carried->value);
    mbsri_zero(carried->right_count, carried->store + carried->right);
    for (int k = 0; k < m->rows + m->position_rows; ++k) {
        const mbsri_multiplier *multiplier = carried->multiplier + k;
        if (multiplier->right >= 0)
            carried->value[k] = v[first + k] * multiplier->out;
        else
            x[first + k] = v[first + k];
    }
}

void mbsri_front_load_transposed(const mbsr_newton *w, double *x)
{
    const mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < m->rows + m->position_rows; ++k) {
        const mbsri_multiplier *multiplier = v->multiplier + k;
        if (multiplier->right >= 0) x[first + k] = multiplier->in * v->store[multiplier->right];
    }
}
