/* Two files that say the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_ALIKE_H
#define TEST_ALIKE_H

#include "small.h"

#include <math.h>

enum { ALIKE_MOST = 40 };

/* Some state and accelerations of a file, quaternions of length 1. */
static inline void some_motion(const mbsr_file *file, double *q, double *u, double *udot)
{
    static const int positions[] = {0, 1, 1, 4, 7};
    for (int k = 0, at = 0; k < file->joints; at += positions[file->joint[k].kind], ++k) {
        const int count = positions[file->joint[k].kind];
        double square = 0.0;
        for (int l = 0; l < count; ++l) q[at + l] = 0.5 * sin(1.0 + 3.0 * (at + l));
        for (int l = 0; l < 4 && count > 1; ++l) square += q[at + l] * q[at + l];
        for (int l = 0; l < 4 && count > 1; ++l) q[at + l] /= sqrt(square);
    }
    for (int k = 0; k < file->nu; ++k) u[k] = 0.5 - 0.1 * k, udot[k] = cos(2.0 * k);
}

/* Finishes both and compares tau of one motion, controls included. */
static inline void assert_alike(mbsr_file *a, mbsr_file *b)
{
    mbsr_file *const file[2] = {a, b};
    double tau[2][ALIKE_MOST] = {{0.0}}, q[ALIKE_MOST], u[ALIKE_MOST], udot[ALIKE_MOST], size = 1.0;
    assert_int_equal(a->nu, b->nu);
    assert_int_equal(a->nq, b->nq);
    assert_int_equal(a->actuators, b->actuators);
    assert_true(a->nu <= ALIKE_MOST && a->nq <= ALIKE_MOST);
    some_motion(a, q, u, udot);
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        for (int l = 0; l < file[k]->actuators; ++l) file[k]->control[l] = 0.7 - 0.2 * l;
        assert_ok(mbsr_model_finish(file[k]->model), mbsr_model_error(file[k]->model));
        assert_ok(mbsr_data_create(file[k]->model, &d, NULL), NULL);
        assert_ok(mbsr_inverse_dynamics(file[k]->model, d, 0.0, q, u, udot, NULL, tau[k]),
                  mbsr_data_error(d));
        mbsr_data_destroy(d);
    }
    for (int k = 0; k < a->nu; ++k) size = fmax(size, fabs(tau[1][k]));
    for (int k = 0; k < a->nu; ++k) assert_close(tau[0][k] / size, tau[1][k] / size, 1e-12);
}

#endif
