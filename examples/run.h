/* What the examples from 10 on share: running a model with the IDA driver in the momentum form.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_RUN_H
#define EXAMPLES_RUN_H

#include "build.h"

#include <mbsrank/ida.h>

/* A model under way: time, q and u, and the stages up to mbsr_velocities evaluated there. */
typedef struct run {
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ida *ida;
    double t, *y, *yp, *q, *u;
    mbsr_consistent_info start;
} run;

static inline double *numbers(int count)
{
    double *x = calloc((size_t)count + 1, sizeof *x);
    if (!x) exit(1);
    return x;
}

static inline void run_evaluate(run *r)
{
    check(mbsr_dae_unpack(r->m, r->d, MBSR_DAE_MOMENTUM, r->t, r->y, r->q, r->u),
          mbsr_data_error(r->d));
    check(mbsr_positions(r->m, r->d, r->t, r->q), mbsr_data_error(r->d));
    check(mbsr_velocities(r->m, r->d, r->u), mbsr_data_error(r->d));
}

/* Finishes the model, which the run then owns, finds a consistent state near q, u at t = 0 and
 * starts the driver there. */
static inline run run_start_with(mbsr_model *m, const double *q, const double *u, double tolerance,
                                 mbsr_ida_solver solver)
{
    run r = {.m = m};
    mbsr_error error;
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &r.d, &error), &error);
    r.y = numbers(mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    r.yp = numbers(mbsr_dae_size(m, MBSR_DAE_MOMENTUM));
    r.q = numbers(mbsr_model_nq(m));
    r.u = numbers(mbsr_model_nu(m));
    check(mbsr_dae_pack(m, r.d, MBSR_DAE_MOMENTUM, 0.0, q, u, r.y), mbsr_data_error(r.d));
    check(mbsr_dae_consistent(m, r.d, MBSR_DAE_MOMENTUM, 0.0, r.y, r.yp, NULL, &r.start),
          mbsr_data_error(r.d));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    opt.linear_solver = solver;
    check(mbsr_ida_create(m, r.d, &opt, &r.ida, &error), &error);
    check(mbsr_ida_start(r.ida, 0.0, r.y, r.yp), mbsr_ida_error(r.ida));
    run_evaluate(&r);
    return r;
}

/* With the linear solver that the driver chooses. */
static inline run run_start(mbsr_model *m, const double *q, const double *u, double tolerance)
{
    return run_start_with(m, q, u, tolerance, MBSR_IDA_AUTO);
}

static inline void run_to(run *r, double t)
{
    check(mbsr_ida_advance(r->ida, t, &r->t, r->y, r->yp), mbsr_ida_error(r->ida));
    run_evaluate(r);
}

/* Kinetic and potential energy, J. */
static inline double run_energy(run *r)
{
    double kinetic, potential;
    check(mbsr_energy(r->m, r->d, &kinetic, &potential), mbsr_data_error(r->d));
    return kinetic + potential;
}

/* Power turned into heat, W. */
static inline double run_dissipation(run *r)
{
    double power;
    check(mbsr_dissipation(r->m, r->d, &power), mbsr_data_error(r->d));
    return power;
}

static inline long run_steps(const run *r)
{
    mbsr_ida_stats stats;
    check(mbsr_ida_get_stats(r->ida, &stats), mbsr_ida_error(r->ida));
    return stats.steps;
}

static inline void run_end(run *r)
{
    mbsr_ida_destroy(r->ida);
    mbsr_data_destroy(r->d);
    mbsr_model_destroy(r->m);
    free(r->y), free(r->yp), free(r->q), free(r->u);
}

#endif
