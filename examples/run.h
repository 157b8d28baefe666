/* What the examples from 10 to 20 share: running a model with the IDA driver in the momentum form,
 * by simulation.h; a failure ends the program.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_RUN_H
#define EXAMPLES_RUN_H

#include "build.h"

#include <mbsrank/simulation.h>

/* Starts near q, u at t = 0; the simulation owns the model. */
static inline mbsr_simulation run_start_with(mbsr_model *m, const double *q, const double *u,
                                             double tolerance, mbsr_ida_solver solver)
{
    mbsr_simulation s = mbsr_simulation_of(m);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    opt.linear_solver = solver;
    check(mbsr_simulation_start(&s, &opt, 0.0, q, u), &s.error);
    return s;
}

/* With the linear solver that the driver chooses. */
static inline mbsr_simulation run_start(mbsr_model *m, const double *q, const double *u,
                                        double tolerance)
{
    return run_start_with(m, q, u, tolerance, MBSR_IDA_AUTO);
}

static inline void run_to(mbsr_simulation *s, double t)
{
    check(mbsr_simulation_to(s, t), &s->error);
}

/* Kinetic and potential energy, J. */
static inline double run_energy(mbsr_simulation *s)
{
    double kinetic, potential;
    check(mbsr_energy(s->model, s->data, &kinetic, &potential), mbsr_data_error(s->data));
    return kinetic + potential;
}

/* Power turned into heat, W. */
static inline double run_dissipation(mbsr_simulation *s)
{
    double power;
    check(mbsr_dissipation(s->model, s->data, &power), mbsr_data_error(s->data));
    return power;
}

static inline long run_steps(const mbsr_simulation *s)
{
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(s, &stats);
    return stats.steps;
}

#endif
