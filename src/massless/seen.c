/* Which directions springs and dampers see: see seen.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/seen.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/element_rows.h"
#include "massless/scales.h"

#include <float.h>
#include <math.h>

/* The least share that counts of what is subtracted. */
static const double least_seen = 1e-12;

/* Room for a reduction, and behind it for a row of `count` numbers, its errors and sizes. */
static int make_room(mbsri_null_space *w, int count, const int *direction, bool velocity,
                     double **row)
{
    const int rows = mbsri_rows_gather(w, count, direction, velocity, NULL, NULL);
    const size_t size = mbsri_reduction_size(count, rows) / sizeof(double) + 1,
                 more = size + 3 * (size_t)count;
    w->element.room.count = 0;
    if (!mbsri_reserve(&w->m->allocator, &w->element.room, more, sizeof(double))) {
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for what %d force elements see of %d null directions",
                          w->function, rows, count);
    }
    mbsri_reduction_place(&w->element.reduced, count, rows, w->element.room.data);
    *row = (double *)w->element.room.data + size;
    (void)mbsri_rows_gather(w, count, direction, velocity, w->element.reduced.A,
                            w->element.reduced.error);
    w->element.reduced.m = rows;
    return MBSR_OK;
}

/* sizes (count) = the largest rates of directions, by typical sizes. Pivots are taken where
 * elements see most of a direction beside that: one that goes on into large rates behind a slender
 * body is then not subtracted from others, in which it would hide all else. */
static void find_sizes(const mbsri_null_space *w, int count, const int *direction, double *sizes)
{
    for (int n = 0; n < count; ++n) sizes[n] = mbsri_direction_size(w, direction[n]);
}

int mbsri_seen_by_dampers(mbsri_null_space *w, int count, const int *direction)
{
    double *row;
    const int status = make_room(w, count, direction, true, &row);
    if (status) return status;
    double *sizes = row + 2 * count;
    find_sizes(w, count, direction, sizes);
    mbsri_reduce(&w->element.reduced, count, w->element.reduced.m, count, least_seen, sizes);
    return MBSR_OK;
}

int mbsri_seen_by_springs(mbsri_null_space *w, int count, const int *direction, int e,
                          const double *Z, const double *Z_error)
{
    double *x;
    const int status = make_room(w, count, direction, false, &x);
    if (status) return status;
    double *dx = x + count, *sizes = dx + count;
    for (int n = 0; n < w->element.reduced.m; ++n) {
        mbsri_copy((size_t)count, w->element.reduced.A + n * count, x);
        mbsri_copy((size_t)count, w->element.reduced.error + n * count, dx);
        for (int b = 0; b < e; ++b) { /* e <= count: what is read later is not overwritten */
            const double *z = Z + b * count, *dz = Z_error + b * count;
            double sum = 0.0, error = 0.0;
            for (int p = 0; p < count; ++p) {
                sum += x[p] * z[p];
                error += (dx[p] + 4.0 * DBL_EPSILON * fabs(x[p])) * fabs(z[p]) + fabs(x[p]) * dz[p];
            }
            w->element.reduced.A[n * e + b] = fabs(sum) > 10.0 * error ? sum : 0.0;
            w->element.reduced.error[n * e + b] = error;
        }
    }
    find_sizes(w, count, direction, x);
    for (int b = 0; b < e; ++b) {
        sizes[b] = 0.0;
        for (int p = 0; p < count; ++p) sizes[b] = fmax(sizes[b], fabs(Z[b * count + p]) * x[p]);
    }
    mbsri_reduce(&w->element.reduced, e, w->element.reduced.m, e, least_seen, sizes);
    return MBSR_OK;
}

void mbsri_seen_through(int count, int e, const double *Z, const double *weights, double *out)
{
    for (int a = 0; a < count; ++a) {
        double size = 0.0;
        out[a] = 0.0;
        for (int b = 0; b < e; ++b) {
            const double part = weights[b] * Z[b * count + a];
            out[a] += part;
            size += fabs(part);
        }
        if (fabs(out[a]) <= 1e-12 * size) out[a] = 0.0;
    }
}
