/* What is asked of an mbsr_parallel.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_THREADS_H
#define MBSRI_THREADS_H

#include <mbsrank/threads.h>

/* A status, with a text that begins with the function's name. */
int mbsri_parallel_check(const mbsr_parallel *parallel, const char *function, mbsr_error *error);

#endif
