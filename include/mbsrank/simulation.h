/* A model, its data and a driver in one hand (component ida): for programs that build one model and
 * run it.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_simulation s = mbsr_simulation_begin(NULL);
 *   int rod = mbsr_simulation_add_body(&s, "rod", MBSR_GROUND, joint, inertia);
 *   mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
 *   mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
 *   for (int k = 1; k <= 100 && !mbsr_simulation_to(&s, 0.1 * k); ++k) printf("%g\n", s.q[0]);
 *   if (s.status) puts(s.error.text);
 *   mbsr_simulation_end(&s);
 *
 * The first failure stays: every later call does nothing and returns its status, so that one look
 * at the end is enough. Model, data and driver are there for everything that is not wrapped. */
#ifndef MBSRANK_SIMULATION_H
#define MBSRANK_SIMULATION_H

#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#ifdef __cplusplus
extern "C" {
#endif

/* To be read, and written by the functions below only. */
typedef struct mbsr_simulation {
    mbsr_model *model; /* finished by mbsr_simulation_start */
    mbsr_data
        *data; /* from there on, as all that follows; at mbsr_stage_accelerations of the state */
    mbsr_ida *ida;
    mbsr_dae_form form;
    double t;                            /* s */
    double *q, *u, *udot;                /* nq, nu, nu; NULL before the start */
    double *lambda;                      /* loop forces, one a row of the closures (closure.h) */
    double *y, *yp;                      /* the state of the form */
    mbsr_consistent_info start;          /* what the consistent start has changed */
    mbsr_small_masses *small;            /* of mbsr_simulation_watch_masses, until the next start */
    double watched;                      /* time of the last state it has looked at */
    struct mbsr_simulation_part *parts;  /* what it frees besides */
    struct mbsr_simulation_given *given; /* of mbsr_simulation_set_position and _set_rate */
    int status;                          /* of the first failure; 0: none */
    mbsr_error error;                    /* its text */
} mbsr_simulation;

/* With an empty model; def NULL: mbsr_default_model_def. */
MBSR_API mbsr_simulation mbsr_simulation_begin(const mbsr_model_def *def);

/* A simulation of a model that has been built, finished or not; the simulation frees it. */
MBSR_API mbsr_simulation mbsr_simulation_of(mbsr_model *model);

/* Add a body, a force element, a closure, and return its id; MBSR_NONE after a failure. Statuses of
 * mbsr_model_add_body, mbsr_model_add_force, mbsr_model_add_closure. */
MBSR_API int mbsr_simulation_add_body(mbsr_simulation *s, const char *name, int parent,
                                      mbsr_joint joint, mbsr_inertia inertia);
MBSR_API int mbsr_simulation_add_force(mbsr_simulation *s, mbsr_force_def force);
MBSR_API int mbsr_simulation_add_closure(mbsr_simulation *s, mbsr_closure_def closure);

/* A table of one column (table.h), constant beyond its ends, for joints and forces to be added; the
 * simulation frees it. NULL after a failure. Statuses of mbsr_table_create. */
MBSR_API mbsr_table *mbsr_simulation_add_table(mbsr_simulation *s, mbsr_table_kind kind, int points,
                                               const double *x, const double *value);

/* Finishes the model unless it is, and makes data besides those of the run, which the simulation
 * frees: for inverse dynamics with some force elements switched off, say. NULL after a failure.
 * Statuses of mbsr_model_finish, mbsr_data_create. */
MBSR_API mbsr_data *mbsr_simulation_add_data(mbsr_simulation *s);

/* Coordinate `coordinate` of the joint of a body (a number of its q: m or rad; quaternions have
 * four), or joint rate `coordinate` (of its u: m/s or rad/s), has this value in every later start,
 * and keeps it; the others follow: loops close around it, and velocities change by impulses of
 * loops and of motors at the rates that are given (mbsr_consistent_opt). A crank that turns at 100
 * rad/s, whatever hangs on it:
 *
 *   mbsr_simulation_set_rate(&s, crank, 0, 100.0);
 *   mbsr_simulation_start(&s, NULL, 0.0, q0, NULL);
 *
 * What there is not is refused by the start, and so is what the loops do not allow, MBSR_LOOP_OPEN,
 * or what forces on bodies without mass determine, MBSR_NO_CONVERGENCE; the text names joint and
 * closure row. _set_none forgets them all. MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_simulation_set_position(mbsr_simulation *s, int body, int coordinate,
                                          double value);
MBSR_API int mbsr_simulation_set_rate(mbsr_simulation *s, int body, int coordinate, double value);
MBSR_API int mbsr_simulation_set_none(mbsr_simulation *s);

/* Finishes the model unless it is, finds a consistent state near q, u (NULL: all coordinates zero,
 * quaternions 1; at rest) at t, and starts a driver there (opt NULL: mbsr_default_ida_opt). Called
 * again it begins another run, of the same model. Statuses of mbsr_model_finish, mbsr_data_create,
 * mbsr_dae_consistent, mbsr_ida_create, mbsr_ida_start. */
MBSR_API int mbsr_simulation_start(mbsr_simulation *s, const mbsr_ida_opt *opt, double t,
                                   const double *q, const double *u);

/* Integrate to a time, by mbsr_ida_advance, and over one sample, by mbsr_ida_sample; then t, q, u,
 * udot, lambda, y, yp are those reached, and the data is at mbsr_stage_accelerations there: poses,
 * twists and accelerations of bodies and points, reactions of joints and closures, what force
 * elements exert, energies and powers can be asked for at once. MBSR_EVENT is no failure: the next
 * call goes on. After a failure they are the last good state, where there is one (mbsr_ida_state).
 * After calls of the driver itself, such as mbsr_ida_run, mbsr_simulation_to with the time it has
 * reached takes up its state. MBSR_ERR_SEQUENCE before the start. */
MBSR_API int mbsr_simulation_to(mbsr_simulation *s, double t);
MBSR_API int mbsr_simulation_sample(mbsr_simulation *s, double t);

/* Accelerations of the joint coordinates, u' (nu), and loop forces lambda (one a row of the
 * closures) of the present state, as s->udot and s->lambda. udot is NaN in the index-1 form with
 * raw_outputs. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE before the start, s->status. */
MBSR_API int mbsr_simulation_accelerations(mbsr_simulation *s, double *udot);
MBSR_API int mbsr_simulation_reactions(mbsr_simulation *s, double *lambda);

/* Keeps the status of a call with s->model and s->data as a failure, if it is the first one, with
 * its text; returns that of the first one:
 *
 *   mbsr_simulation_check(&s, mbsr_body_pose(s.model, s.data, rod, pose)); */
MBSR_API int mbsr_simulation_check(mbsr_simulation *s, int status);

/* What has been integrated since the last start has cost; zero before it. MBSR_ERR_NULL. */
MBSR_API int mbsr_simulation_get_stats(const mbsr_simulation *s, mbsr_ida_stats *stats);

/* From the present state on, every state that mbsr_simulation_to and mbsr_simulation_sample reach
 * is looked at for what the masses that the model neglects (mbsr_model_neglect) would have done
 * there; opt as for mbsr_small_masses_create, whose candidates are these masses and those that opt
 * names. With outputs as dense as the slow motion asks for, mbsr_simulation_get_masses has the
 * largest error that the zeros have made so far, with its time and the body. Momentum form.
 * MBSR_ERR_SEQUENCE before the start; statuses of mbsr_small_masses_create,
 * mbsr_small_masses_start, mbsr_small_masses_step. */
MBSR_API int mbsr_simulation_watch_masses(mbsr_simulation *s, const mbsr_small_masses_opt *opt);
MBSR_API int mbsr_simulation_get_masses(mbsr_simulation *s, mbsr_small_masses_report *report);

/* What the struct has, for languages that do not read structs; NULL is allowed: NaN, NULL,
 * MBSR_ERR_NULL. q (nq) and u (nu) are NULL before the start; they, and what is pointed to, stay
 * the simulation's. */
MBSR_API double mbsr_simulation_time(const mbsr_simulation *s);
MBSR_API const double *mbsr_simulation_q(const mbsr_simulation *s);
MBSR_API const double *mbsr_simulation_u(const mbsr_simulation *s);
MBSR_API mbsr_model *mbsr_simulation_model(const mbsr_simulation *s);
MBSR_API mbsr_data *mbsr_simulation_data(const mbsr_simulation *s);
MBSR_API mbsr_ida *mbsr_simulation_ida(const mbsr_simulation *s);
MBSR_API int mbsr_simulation_status(const mbsr_simulation *s);
MBSR_API const mbsr_error *mbsr_simulation_error(const mbsr_simulation *s); /* never NULL */

/* Forgets the failure, when its cause has been dealt with; t, q, u stay. The next call may be
 * mbsr_simulation_start. */
MBSR_API void mbsr_simulation_forgive(mbsr_simulation *s);

/* Frees all of it; NULL is allowed. */
MBSR_API void mbsr_simulation_end(mbsr_simulation *s);

#ifdef __cplusplus
}
#endif

#endif
