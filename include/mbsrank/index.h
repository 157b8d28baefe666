/* Diagnosis: which joint directions have no inertia, what determines them, and the differential
 * index of the equations of motion (a DAE) that follows.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_INDEX_H
#define MBSRANK_INDEX_H

#include <mbsrank/dae.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A direction is a combination of joint rates, u = a. It is algebraic when it leaves every mass at
 * rest: (joint-space mass matrix) a = 0. */
typedef enum mbsr_direction_kind {
    MBSR_DIRECTION_DAMPED = 1,      /* a force that depends on velocity determines it: index 1 */
    MBSR_DIRECTION_ELASTIC = 2,     /* only forces that depend on position do: index 2 */
    MBSR_DIRECTION_UNDETERMINED = 3 /* nothing does */
} mbsr_direction_kind;

/* weight times joint rate u[coordinate] of a body. */
typedef struct mbsr_direction_term {
    int body;       /* id */
    int coordinate; /* 0 .. n-1 within the joint */
    double weight;  /* in units of that rate */
} mbsr_direction_term;

/* A combination of joint rates that moves no mass, and what determines it. */
typedef struct mbsr_direction {
    mbsr_direction_kind kind;
    int terms;
    const mbsr_direction_term *term; /* largest weight 1 */
    int forces;                      /* force elements that determine it */
    const int *force;   /* their ids: those whose forces change with the rates (damped) or the
                           positions   (elastic) along the direction; none where undetermined, or
                           where   only the   change of the direction itself does it */
    int closures;       /* stiff closures that determine it, by their springs or dampers */
    const int *closure; /* their ids */
} mbsr_direction;

/* The verdict at one state. Directions other than those listed are dynamic. */
typedef struct mbsr_index_report {
    int dynamic, damped, elastic, undetermined; /* how many directions of each kind */
    int index; /* differential index of the DAE: 0 (no algebraic direction), 1 (damped ones, or
                  closures), 2 (elastic ones too), or -1 with undetermined directions */
    int loop_supported;  /* further directions without mass, which rigid rows of closures support */
    double conditioning; /* smallest over largest singular value of d gamma / d zeta, scaled to unit
                            rows and columns, over the damped directions; 1 without any */
    int directions;      /* damped + elastic + undetermined */
    const mbsr_direction *direction; /* undetermined ones first, then elastic, then damped */
    const char *text; /* every undetermined direction with the bodies concerned and what to do; ""
                         when there is none */
} mbsr_index_report;

/* Classifies every joint direction of a model at (t, q, u) from the ranks of the joint blocks and
 * from the slopes of the forces in the massless directions. The verdict does not depend
 * on units. Directions that do not act on each other are reported apart; of a kind those are chosen
 * that concern few joint rates. On success *report belongs
 * to the caller and is released by mbsr_index_report_destroy; on failure it is NULL.
 *
 * With closures (positions closed, velocities as their rows allow) it classifies the directions in
 * which neither mass nor a rigid row resists. Loop forces lambda are those of the motion at the
 * state, [M -C^T; C 0] (u'; lambda) = (forces; -bias); held, they stiffen or soften directions
 * along which they turn. Stiff rows are springs and dampers. Which rows are redundant
 * mbsr_closures_report says. Linear algebra of joint rates and rows is dense then where the model
 * is small or has stiff rows, or where loops leave a direction without mass free, and goes front by
 * front elsewhere; statuses of mbsr_forward_dynamics.
 *
 * Force elements with derivatives of their own are asked for these, the others differenced. Their
 * forces are then also evaluated at states far from the given one (up to 10 times q, 1e6 times u);
 * where they fail, the difference quotients take shorter steps. Allocates from the model's
 * allocator. Costs some dozens of residuals times the number of null directions that act on one and
 * the same; where all force elements have derivatives, mostly some dozens in all. Memory as
 * (bodies) x (directions).
 *
 * All statuses of the stages in dynamics.h; MBSR_ERR_NO_MEMORY. An undetermined direction is a
 * result, not a failure. */
MBSR_API int mbsr_index_report_create(const mbsr_model *model, mbsr_data *data, double t,
                                      const double *q, const double *u, mbsr_index_report **report);

/* Releases a report of this model; NULL is allowed. */
MBSR_API void mbsr_index_report_destroy(const mbsr_model *model, mbsr_index_report *report);

#ifdef __cplusplus
}
#endif

#endif
