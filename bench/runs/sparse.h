/* A sparse Jacobian by differences and KLU, in place of the linear solver of an IDA driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef SPARSE_H
#define SPARSE_H

#include <mbsrank/ida.h>

typedef struct sparse sparse;

typedef struct sparse_info {
    long entries;   /* of the Jacobian that may differ from zero */
    long groups;    /* of columns that are differenced together */
    long residuals; /* evaluated for differences, the search for the pattern included */
    long jacobians;
} sparse_info;

/* Finds the pattern of dF/dy + c dF/dy' near (y, yp) by changing one entry after the other, puts
 * columns without a common row into groups (Curtis, Powell, Reid), and attaches KLU to the driver.
 * NULL if there are more than `most` entries, or if this program was built without KLU. The driver
 * is to be destroyed first. */
sparse *sparse_attach(mbsr_ida *ida, const mbsr_model *model, mbsr_data *data, const double *y,
                      const double *yp, long most);
void sparse_destroy(sparse *s); /* NULL is allowed */

sparse_info sparse_get_info(const sparse *s);

#endif
