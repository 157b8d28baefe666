/* A dense matrix factored by LAPACK, in place of the linear solver of an IDA driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef RUNS_LAPACK_H
#define RUNS_LAPACK_H

#include <mbsrank/ida.h>

typedef struct lapack lapack;

/* Attaches it to the driver, which is to be destroyed first; the matrix is IDA's, by differences.
 */
lapack *lapack_attach(mbsr_ida *ida, int size);
void lapack_destroy(lapack *l); /* NULL is allowed */

#endif
