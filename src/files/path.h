/* A spring and damper along points of bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_PATH_H
#define MBSRI_FILES_PATH_H

#include <mbsrank/force.h>

#include <stdbool.h>

enum { MBSRI_PATH_MOST = 9 };

/* Along straight lines from point to point (body axes, m), no force between the two lengths of
 * rest; `count` from 2 to MBSRI_PATH_MOST, bodies in space or the ground. */
mbsr_force_def mbsri_force_path(int count, const int *body, const double (*point)[3],
                                double stiffness, double damping, const double rest[2]);

/* Its table, by which the element is known. */
const mbsr_force_table *mbsri_path_table(void);

/* One read back, but for bodies; false: it is another element. */
bool mbsri_path_of(const mbsr_force_def *def, double (*point)[3], double *stiffness,
                   double *damping, double rest[2]);

#endif
