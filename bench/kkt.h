/* The equations of motion of rods in the plane in redundant coordinates, [M G^T; G 0] with three
 * rates a body and two rows a hinge or pin, as a sparse matrix for KLU.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef BENCH_KKT_H
#define BENCH_KKT_H

typedef struct bench_kkt bench_kkt;

/* A rod along x of its axes, hinged at its origin to the parent (-1: ground), at rest. */
typedef struct bench_rod {
    int parent;
    double x, y, angle, mass, length; /* of its origin in the world, m, rad, kg */
} bench_rod;

/* A pin between the ends of two rods; b = -1: to the ground. */
typedef struct bench_pin {
    int a, b;
    double x, y; /* in the world */
} bench_pin;

/* NULL without KLU. gravity: 2 numbers. The order of elimination is chosen here, once. */
bench_kkt *bench_kkt_open(int rods, const bench_rod *rod, int pins, const bench_pin *pin,
                          const double *gravity);
void bench_kkt_close(bench_kkt *k);

/* Numerical factorisation, with pivots; accelerations of bodies (x, y, angle each), then forces. 0:
 * a failure. */
int bench_kkt_factor(bench_kkt *k);
const double *bench_kkt_solve(bench_kkt *k);

#endif
