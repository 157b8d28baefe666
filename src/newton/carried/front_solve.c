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
    for (int k = 0; k < m->rows + m->held && r; ++k) {
        const mbsri_multiplier *multiplier = v->multiplier + k;
        if (multiplier->right >= 0) v->store[multiplier->right] = multiplier->in * of_rows[k];
    }
}

/* Of the right-hand sides h of all rows, by number, what the elimination leaves; b: of the body
 * above. */
static void reduce(mbsr_newton *w, int i, const double *h, double *p, double *b)
{
    mbsri_carried *v = &w->carried;
    const mbsri_carried_front *front = v->front + i;
    const int size = front->size, rows = size + front->actions;
    const int *row = v->numbers + front->swap_row, *place = v->numbers + front->place;
    const double *M = v->store + front->LU;
    for (int k = 0; k < rows; ++k) p[k] = h[k < size ? row[k] : k];
    for (int k = 0; k < front->done; ++k) {
        const double *L = M + (size_t)k * (size_t)rows;
        for (int l = k + 1; l < rows; ++l) p[l] -= L[l] * p[k];
    }
    const mbsri_pool *up = mbsri_carried_up(w, i);
    double *right = v->store + up->right;
    mbsri_copy((size_t)front->done, p, v->store + front->right);
    for (int k = front->done; k < size; ++k) right[place[k - front->done]] += p[k];
    for (int k = 0; k < front->actions; ++k) b[k] -= p[size + k];
}

void mbsri_front_reduce_one(mbsr_newton *w, int k, double *b)
{
    mbsri_carried *v = &w->carried;
    const mbsri_carried_front *front = v->front + k;
    double *h = v->work, *p = h + front->size + front->actions;
    mbsri_zero((size_t)(front->size + front->actions), h);
    mbsri_copy((size_t)front->size, v->store + mbsri_carried_at(w, k)->right, h);
    reduce(w, k, h, p, b);
}

/* x: the perturbation of the body above. */
void mbsri_front_substitute_one(mbsr_newton *w, int i, const double *x)
{
    mbsri_carried *v = &w->carried;
    const mbsri_carried_front *front = v->front + i;
    const int rows = front->size + front->actions, done = front->done;
    const int *column = v->numbers + front->swap_column, *name = v->numbers + front->column;
    const int columns = front->size + front->motions;
    const double *U = v->store + front->LU + done * rows, *right = v->store + front->right;
    double *z = v->work; /* all unknowns, and x */
    for (int l = done; l < front->size; ++l) z[l] = v->value[name[column[l]]];
    mbsri_copy((size_t)front->motions, x, z + front->size);
    for (int k = done - 1; k >= 0; --k) {
        const double *row = U + k * columns;
        z[k] = (right[k] - mbsri_dot(columns - k - 1, row + k + 1, z + k + 1)) / row[k];
        v->value[name[column[k]]] = z[k];
    }
}

void mbsri_front_multipliers(const mbsr_newton *w, const double *r, double *delta)
{
    const mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < m->rows + m->held; ++k) {
        const mbsri_multiplier *multiplier = v->multiplier + k;
        if (multiplier->right >= 0)
            delta[first + k] = v->value[k] * multiplier->out;
        else
            delta[first + k] = r ? r[first + k] : 0.0;
    }
}
