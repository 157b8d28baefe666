/* Energy, and the power that elements dissipate.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "dynamics/entry.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "recursion/not_finite.h"
#include "results/energy.h"

#include <mbsrank/dynamics.h>

double mbsri_kinetic_energy_of(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const double *armature = m->armature + b->iu, *u = d->u + b->iu;
    mbsri_zero((size_t)b->d, d->scratch);
    mbsri_inertia_times(b, d->p + b->p, d->M + b->dd, 1.0, d->V + b->v, d->scratch);
    double twice = mbsri_dot(b->d, d->V + b->v, d->scratch);
    for (int k = 0; k < b->n; ++k) twice += armature[k] * u[k] * u[k];
    return 0.5 * twice;
}

int mbsr_energy(const mbsr_model *model, mbsr_data *data, double *kinetic, double *potential)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_energy");
    if (status) return status;
    double T = 0.0, E = 0.0;
    for (int i = 1; i <= m->bodies; ++i) T += mbsri_kinetic_energy_of(m, d, i);
    if (potential) {
        status = mbsri_element_sum(m, d, NULL, MBSRI_ENERGY, &E);
        if (!status && m->rows > 0) status = mbsri_closure_sum(m, d, true, &E);
        if (status) return status;
    }
    status = mbsri_check_result(m, d, 2, (double[]){kinetic ? T : 0.0, E}, "mbsr_energy");
    if (status) return status;
    if (kinetic) *kinetic = T;
    if (potential) *potential = E;
    return MBSR_OK;
}

int mbsr_dissipation(const mbsr_model *model, mbsr_data *data, double *power)
{
    double sum = 0.0;
    int status = mbsri_enter(model, data, power, MBSRI_STAGE_VELOCITIES, "mbsr_dissipation");
    if (!status) status = mbsri_element_sum(model, data, NULL, MBSRI_DISSIPATION, &sum);
    if (!status && model->rows > 0) status = mbsri_closure_sum(model, data, false, &sum);
    if (!status) status = mbsri_check_result(model, data, 1, &sum, "mbsr_dissipation");
    if (!status) *power = sum;
    return status;
}

int mbsr_force_power(const mbsr_model *model, mbsr_data *data, int force, double *energy,
                     double *power)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_force_power");
    if (status) return status;
    const mbsri_force *element = mbsri_find_force(m, d, force, "mbsr_force_power");
    if (!element) return MBSR_ERR_ID;
    double E = 0.0, P = 0.0;
    if (energy) status = mbsri_element_sum(m, d, element, MBSRI_ENERGY, &E);
    if (!status && power) status = mbsri_element_sum(m, d, element, MBSRI_DISSIPATION, &P);
    if (!status) status = mbsri_check_result(m, d, 2, (double[]){E, P}, "mbsr_force_power");
    if (status) return status;
    if (energy) *energy = E;
    if (power) *power = P;
    return MBSR_OK;
}
