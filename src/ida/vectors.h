/* Operations on serial vectors, compiled as the library is.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_VECTORS_H
#define MBSRI_IDA_VECTORS_H

#include <sundials/sundials_nvector.h>

/* Gives a serial vector, and all that will be cloned from it, operations of the library's own in
 * the place of those of SUNDIALS (not of those that somebody has replaced): the same numbers to the
 * last bit. Some packages of SUNDIALS are compiled without optimisation; half of the time of a run
 * goes into vectors then. */
void mbsri_ida_use_own_operations(N_Vector v);

#endif
