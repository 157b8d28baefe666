/* Loops at a state: closing them, what their rows hold, and which rows are redundant.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * mbsr_closures_report uses dense linear algebra, O((nu + m)^3) for m rows, and takes memory from the model's allocator
 * for the call. mbsr_assemble, mbsr_closures_mobility and mbsr_closures_inverse_dynamics go along the tree in
 * O(bodies + loops), the first two with memory, the third where vector code does not serve the model; so does
 * mbsr_assemble but for stiff rows that cannot all be closed, which are told apart in dense linear algebra. All others look
 * up what is known and take none. */
#ifndef MBSRANK_LOOPS_H
#define MBSRANK_LOOPS_H

#include <mbsrank/closure.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_assembly_opt {
    int cookie;         /* set by mbsr_default_assembly_opt */
    int max_iterations; /* default 100 */
    double
        tolerance; /* of each gap: turns in rad, places over the longest lever of the mechanism or
                         * over their distance from the origin, whichever is more; default 1e-12 */
    /* nu each, NULL (default): none. How many times more than the others a coordinate resists, positive:
     * 1e6 keeps it where it is, as far as the loops let it; 1 for coordinates that stay where they are. */
    const double *weight;
    const int *keep_position;
} mbsr_assembly_opt;

MBSR_API mbsr_assembly_opt mbsr_default_assembly_opt(void);

/* What mbsr_assemble has found. */
typedef struct mbsr_assembly_info {
    int iterations;
    int closure;            /* the one that is open widest, MBSR_NONE where all are closed */
    double gap_before, gap; /* largest |g| of the guess, and of q_closed */
    double change;          /* largest |change| of an entry of q */
} mbsr_assembly_info;

/* Positions that close all loops, near the guess q (nq), by the Levenberg-Marquardt method: the change is small, of
 * turns in rad, of ways over the longest lever of the mechanism, so that units do not matter. Coordinates that a
 * closure knows through its bodies alone, as a pin its angle, have no part in that. q_closed (nq) may be q. Stiff rows are closed like rigid ones;
 * where they are more than the freedoms and cannot all be closed, those that depend on others at q are left as they
 * come, and their gaps are not counted. info may be NULL.
 *
 * MBSR_LOOP_OPEN where no position is found in which all gaps vanish: because there is none, or because
 * the guess leads to a position from which all ways make the gaps larger. q_closed and info then hold
 * the nearest position found, and the text names the loops that are open, and by how much. Also
 * MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY, MBSR_NOT_FINITE and what
 * mbsr_positions returns; q_closed is then as it was. */
MBSR_API int mbsr_assemble(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                           const mbsr_assembly_opt *opt, double *q_closed,
                           mbsr_assembly_info *info);

/* What the rows hold at a position. Ranks are those of C with the
 * rows of a closure scaled so that the longest of them has length 1; rows count in
 * the order of their closures, position rows first, so that of several that are redundant together the
 * last counts as redundant. */
typedef struct mbsr_closure_report {
    int rows;         /* m */
    int independent;  /* rank of C here */
    int nearby;       /* and in closed positions nearby: larger where the position is singular */
    int mobility;     /* freedoms that are left: nu - independent - undetermined */
    int massless;     /* directions of the tree that move no mass */
    int undetermined; /* of these, the ones that no loop holds, neither by rigid nor by stiff rows */
    double smallest_kept; /* squared distance of an independent row from the span of those before */
    double largest_dropped; /* of a dependent one */
    int weakest; /* of the rows that the data does not leave out, the one nearest to the span of
                             those before it; MBSR_NONE where there are none */
    double weakest_pivot; /* its squared distance */
    double gap;           /* largest |g| */
    double
        stretch; /* smallest over largest singular value of the rows on the directions without mass
                             that they hold; 1 where there are none. Where it vanishes these bodies are
                             stretched: a motion that goes on would be an impact */
    int stretched; /* the row that has most part in it, or MBSR_NONE */
} mbsr_closure_report;

/* Reports on the position q, which should be closed. redundant (m): 1 for each row that depends on
 * those before it in every closed position nearby. unique (m): 1 where the loop force of the row is
 * determined by motion and applied forces, 0 where it is a matter of elasticity that the model has not.
 * Both may be NULL. MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY and statuses of mbsr_positions. */
MBSR_API int mbsr_closures_report(const mbsr_model *model, mbsr_data *data, double t,
                                  const double *q, mbsr_closure_report *report, int *redundant,
                                  int *unique);

/* The closure of row `row` among all, its own number of the row, and the row's name ("" where the table
 * gives none). Outputs may be NULL. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_closure_of_row(const mbsr_model *model, int row, int *closure, int *own,
                                 const char **name);

/* What row `row` among all measures at the positions of mbsr_positions, so that its gap can be compared: turns of
 * bodies alone (ROTATION, rad), places (TRANSLATION, m), or joint coordinates (OTHER); and the longest lever of
 * the mechanism (m), by which turns move places. One output may be NULL. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE,
 * MBSR_ERR_ID, what a table returned. */
MBSR_API int mbsr_closure_row_kind(const mbsr_model *model, mbsr_data *data, int row,
                                   mbsr_coordinate_kind *kind, double *lever);

/* What a unit impulse on each joint rate changes it by, all others giving way as the loops let them:
 * mobility (nu) = diag(Z (Z^T M Z)^-1 Z^T), where the columns of Z span the rates that the rows allow; its
 * inverse is the inertia that the rate moves. It does not depend on where loops are cut. 0 for rates that
 * the loops do not let change, -1 for those that move no mass. At the positions of mbsr_positions. Stiff
 * rows count as rigid, unless they are not settled. Takes memory for a short time, and O(bodies + loops); results of
 * mbsr_backward are lost. MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY, MBSR_ERR_SEQUENCE, MBSR_NOT_FINITE. */
MBSR_API int mbsr_closures_mobility(const mbsr_model *model, mbsr_data *data, double *mobility);

/* Which rows the data leaves out of the momentum form, redundant (m): their multipliers are zero and
 * their gaps only watched; of stiff rows, whose springs stay, those whose Eta alone is zero.
 * mbsr_dae_consistent chooses them; a data of which nothing was asked leaves
 * out none. mbsr_closures_drop sets them, for a run that goes on in another data. MBSR_ERR_NULL,
 * MBSR_ERR_MISMATCH. */
MBSR_API int mbsr_closures_dropped(const mbsr_model *model, mbsr_data *data, int *redundant);
MBSR_API int mbsr_closures_drop(const mbsr_model *model, mbsr_data *data, const int *redundant);

/* Loop forces lambda (m) at the state of mbsr_velocities, such as those that y' has: the next mbsr_forces
 * adds what they exert, so that mbsr_accelerations and mbsr_joint_reaction take them in. Without it
 * mbsr_forces takes stiff rows as springs and all others as zero. The residual and mbsr_forward_dynamics do
 * this by themselves. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_NOT_FINITE. */
MBSR_API int mbsr_closures_load(const mbsr_model *model, mbsr_data *data, const double *lambda);

/* Loop forces lambda (m) of the last evaluation: of mbsr_forces, of mbsr_forward_dynamics or the residual.
 * MBSR_ERR_NULL, MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_closures_force(const mbsr_model *model, mbsr_data *data, double *lambda);

/* What one closure exerts on one of its bodies by these loop forces, such as the force of contact on a rolling
 * wheel: f (d numbers, conjugate to V; for a SPATIAL body the wrench about its origin, moment first,
 * world axes) and tau (n, conjugate to u), as mbsr_force_load. place: 0 .. bodies - 1 in its definition;
 * a root at rest has no numbers. One output may be NULL. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_ERR_ID,
 * MBSR_ERR_VALUE (place), MBSR_NOT_FINITE, what the table returned. */
MBSR_API int mbsr_closure_reaction(const mbsr_model *model, mbsr_data *data, int closure, int place,
                                   double *f, double *tau);

/* Where it acts, m, world axes (`point` of mbsr_closure_table): of balls, welds, rows and distances the point of
 * the first body, of rolling bodies that of contact. At the positions of mbsr_positions. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE, MBSR_ERR_ID, MBSR_ERR_VALUE where it has none, such as a coupling; MBSR_NOT_FINITE,
 * what the table returned. */
MBSR_API int mbsr_closure_point(const mbsr_model *model, mbsr_data *data, int closure,
                                double point[3]);

/* Inverse dynamics with loops: tau (nu) of the `count` joint rates listed in `actuated` (places in u),
 * zero for all others, and loop forces lambda (m), so that the accelerations udot (nu) come about:
 *
 *   tau + C^T lambda = (mbsr_inverse_dynamics)        with the rigid rows C
 *
 * in O(bodies + loops). Stiff rows are springs, whose forces the right-hand side has already: their lambda are these
 * forces, as mbsr_closures_force has them, and have no part in the sum. Where there are more actuators than freedoms, |tau| is the least; rows that are
 * redundant where a loop closes share by least norm there, of moments and of forces times the model's length.
 * MBSR_UNDETERMINED names a joint that the actuators listed cannot move as asked for. Statuses of
 * mbsr_inverse_dynamics, MBSR_ERR_VALUE (actuated), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_closures_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t,
                                            const double *q, const double *u, const double *udot,
                                            int count, const int *actuated, double *tau,
                                            double *lambda);

#ifdef __cplusplus
}
#endif

#endif
