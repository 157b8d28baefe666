/* Trees of rigid bodies from files (tests/reference/trees), and chains made up here.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef BENCH_TREES_H
#define BENCH_TREES_H

#include <mbsrank/mbsrank.h>

/* A model with a state, in the model's order. */
typedef struct bench_model {
    mbsr_model *model;
    int bodies, nq, nu;
    double *q, *u, *tau, *udot; /* udot: the reference, or NULL */
} bench_model;

/* Reads NAME.txt and NAME.ref of a folder; ends the program if it cannot. */
void bench_read_tree(bench_model *tree, const char *folder, const char *name);

/* A chain of revolute joints about random axes with the links of a random arm; every
 * `massless`-th body has no inertia (0: none), and every joint a spring-damper where `springs`.
 * udot is NULL. */
void bench_make_chain(bench_model *tree, int bodies, int massless, int springs);

/* Branches in two, of segments: a cross about x and a link about y, both without mass, and a rod
 * about the same y, whose springs are in series, so that the link's joint has no rank. */
void bench_make_segments(bench_model *tree, int segments);

/* Rods nearly in one line that turn about y: D of a joint is the small rest of what it is made of.
 */
void bench_make_beam(bench_model *tree, int bodies);

/* Not closed, closed by pins, closed by pins of 1e10 N/m. */
typedef enum bench_loop { BENCH_OPEN, BENCH_RIGID, BENCH_STIFF } bench_loop;

/* A chain of rods in the plane, each with a parallelogram of crank, coupler and rocker on it;
 * couplers without mass where `massless`. */
void bench_make_fourbars(bench_model *tree, int count, int massless, bench_loop loop);

/* The same in space, the rods of the chain about two axes in turn, closed by ball joints; couplers
 * on hinges, universal or ball joints, and without mass where `massless`. */
typedef enum bench_coupler { BENCH_HINGE, BENCH_UNIVERSAL, BENCH_BALL } bench_coupler;
void bench_make_linkages(bench_model *tree, int count, bench_coupler on, int massless, int closed);

/* A chain of rods in the plane with one parallelogram, on its last rod or on its first. */
void bench_make_one_loop(bench_model *tree, int rods, int at_root, int closed);

/* One loop of `links` rods in the plane, a regular polygon with its first and last corner on the
 * ground. */
void bench_make_ring(bench_model *tree, int links, int closed);

/* Many loops that close on one body: four-bars in a row on the ground; parallelograms on a
 * carrier; legs of six hinges between the ground and a platform, the first of which carries it. */
typedef enum bench_crowd { BENCH_BARS, BENCH_CARRIER, BENCH_LEGS } bench_crowd;
void bench_make_crowd(bench_model *tree, bench_crowd kind, int count);

/* Cranks on the ground; from the tip of each two slides without mass on springs in a row, and a rod
 * on them, whose tip stays at a distance from a point: one elastic direction a crank. */
void bench_make_sprung_cranks(bench_model *tree, int count);

/* Couplings of joint coordinates: `gears`, a chain of rods, each turning against the one before;
 * `hands`, a chain of them, whose five fingers have three joints each, two of which follow the
 * first; `differentials`, a chain of rods with a cage and two wheels on each; `train`, wheels on
 * the ground that turn each other. Springs of 1e4 N m where BENCH_STIFF. */
typedef enum bench_gearing {
    BENCH_GEARS,
    BENCH_HANDS,
    BENCH_DIFFERENTIALS,
    BENCH_TRAIN
} bench_gearing;
void bench_make_gearing(bench_model *tree, bench_gearing kind, int count, bench_loop loop);

void bench_free_tree(bench_model *tree);

#endif
