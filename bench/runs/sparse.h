/* Newton's systems of the momentum form in sparse augmented form, with analytic entries, for KLU,
 * in place of the linear solver of an IDA driver.
 * SPDX-License-Identifier: BSD-3-Clause
 */
#ifndef SPARSE_H
#define SPARSE_H

#include "stiff.h"

#include <mbsrank/ida.h>

typedef struct sparse sparse;

typedef struct sparse_info {
    long unknowns, entries, factors; /* of the matrix, and of L and U */
    long factorisations;
} sparse_info;

/* NULL if this program was built without KLU. */
sparse *sparse_open(const stiff_model *stiff, const mbsr_model *model, mbsr_data *data);
void sparse_destroy(sparse *s); /* NULL is allowed */

/* In place of the driver's linear solver; the driver is to be destroyed first. */
void sparse_attach(sparse *s, mbsr_ida *ida);

sparse_info sparse_get_info(const sparse *s);

/* The same system on the tree and by KLU, at a solution (y, yp) of the equations of motion, c =
 * 1000 / s. */
typedef struct sparse_comparison {
    double factor, solve, tree_factor, tree_solve; /* s */
    double difference;                             /* largest, over the largest number */
} sparse_comparison;

/* With elements across the tree the rows of u are left at zero: how the library splits them among
 * the axes of a joint that has inertia along some of them only is not known here. */
sparse_comparison sparse_compare(sparse *s, const double *y, const double *yp);

#endif
