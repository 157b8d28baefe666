/* Energy and gaps in a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/drift.h"

#include "ida/error.h"
#include "ida/loops.h"
#include "ida/outputs.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>

static double largest(int n, const double *x)
{
    double found = 0.0;
    for (int k = 0; k < n; ++k) found = fmax(found, fabs(x[k]));
    return found;
}

/* What the energy of stiff rows is by their forces s, s^2 / 2 k, beyond that by their gaps, k g^2 /
 * 2, in which errors of positions are multiplied by k. */
static double by_forces(const mbsr_ida *ida, const double *y, const double *g)
{
    const double *spring = y + mbsri_ida_loops(ida);
    double sum = 0.0;
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, held_row, held;
        mbsr_closure_indices(ida->model, c, &row, NULL, &held_row, &held);
        for (int k = 0; k < held; ++k) {
            const double stiffness = mbsr_closure_stiffness(ida->model, c, k),
                         gap = g[held_row + k], s = spring[row + k];
            if (stiffness > 0.0) sum += 0.5 * (s * s / stiffness - stiffness * gap * gap);
        }
    }
    return sum;
}

static int measure_drift(mbsr_ida *ida, double t, const double *y, mbsr_ida_drift *drift)
{
    const mbsr_model *model = ida->model;
    mbsr_data *data = ida->data;
    double *q = N_VGetArrayPointer(ida->displaced), *u = q + mbsr_model_nq(model),
           *rows = N_VGetArrayPointer(ida->work), kinetic, potential;
    *drift = (mbsr_ida_drift){0};
    int status = mbsr_dae_unpack(model, data, ida->opt.form, t, y, q, u);
    if (!status) status = mbsr_stage_positions(model, data, t, q);
    if (!status) status = mbsr_stage_velocities(model, data, u);
    if (!status) status = mbsr_energy(model, data, &kinetic, &potential);
    if (status) return status;
    drift->energy = kinetic + potential;
    if (mbsr_model_rows(model) == 0) return MBSR_OK;
    status = mbsr_closures_gap(model, data, rows);
    drift->gap = largest(mbsr_model_position_rows(model), rows);
    drift->energy += by_forces(ida, y, rows);
    if (!status) status = mbsr_closures_rate(model, data, rows);
    drift->rate = largest(mbsr_model_rows(model), rows);
    return status;
}

/* The same of the driver's state. */
static int measure_present(mbsr_ida *ida, mbsr_ida_drift *drift)
{
    return measure_drift(ida, ida->run.present, N_VGetArrayPointer(mbsri_ida_output_y(ida)), drift);
}

void mbsri_ida_drift_start(mbsr_ida *ida, double t, const double *y)
{
    mbsr_ida_drift drift;
    ida->drift.measured = measure_drift(ida, t, y, &drift) == MBSR_OK;
    ida->drift.first_energy = drift.energy;
    ida->drift.largest_gap = drift.gap;
    ida->drift.steps = -1;
}

void mbsri_ida_drift_note(mbsr_ida *ida)
{
    const mbsr_model *model = ida->model;
    mbsr_data *data = ida->data;
    double *q = N_VGetArrayPointer(ida->displaced), *g = N_VGetArrayPointer(ida->work);
    long steps = 0;
    if (mbsr_model_position_rows(model) == 0) return;
    IDAGetNumSteps(ida->memory, &steps);
    if (steps == ida->drift.steps) return;
    ida->drift.steps = steps;
    const double *y = N_VGetArrayPointer(ida->y);
    int status = mbsr_dae_unpack(model, data, ida->opt.form, ida->run.present, y, q,
                                 q + mbsr_model_nq(model));
    if (!status) status = mbsr_stage_positions(model, data, ida->run.present, q);
    if (!status) status = mbsr_closures_gap(model, data, g);
    if (!status)
        ida->drift.largest_gap =
            fmax(ida->drift.largest_gap, largest(mbsr_model_position_rows(model), g));
}

int mbsr_ida_get_drift(mbsr_ida *ida, mbsr_ida_drift *drift)
{
    if (!ida) return MBSR_ERR_NULL;
    if (!drift || (!ida->run.started && !ida->run.failed))
        return mbsri_ida_refuse(&ida->error, drift ? MBSR_ERR_SEQUENCE : MBSR_ERR_NULL,
                                "mbsr_ida_get_drift: %s",
                                drift ? "call mbsr_ida_start first" : "drift is NULL");
    mbsr_ida_drift found;
    mbsri_ida_complete(ida);
    const int status = measure_present(ida, &found);
    if (status)
        return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(ida->data),
                                 "mbsr_ida_get_drift");
    found.largest_gap = fmax(ida->drift.largest_gap, found.gap);
    found.energy_change = ida->drift.measured ? found.energy - ida->drift.first_energy : 0.0;
    if (!isfinite(found.energy) || !isfinite(found.energy_change))
        return mbsri_ida_refuse(&ida->error, MBSR_NOT_FINITE,
                                "mbsr_ida_get_drift: the energy is not finite");
    *drift = found;
    return MBSR_OK;
}
