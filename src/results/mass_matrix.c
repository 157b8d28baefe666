/* Joint-space mass matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"
#include "recursion/mass_matrix.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

/* Inertias by function have no M before the velocities are known. */
static mbsri_stage needed(const mbsr_model *m)
{
    for (int i = 1; m && i <= m->bodies; ++i) {
        if (m->body[i].inertia.kind == MBSR_INERTIA_FUNCTION) return MBSRI_STAGE_VELOCITIES;
    }
    return MBSRI_STAGE_POSITIONS;
}

int mbsr_mass_matrix(const mbsr_model *model, mbsr_data *data, double *matrix)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    const int status = mbsri_enter(m, d, matrix != NULL, needed(m), "mbsr_mass_matrix");
    if (status) return status;
    mbsri_mass_matrix(m, d, matrix);
    return mbsri_check_result(m, d, (size_t)m->nu * (size_t)m->nu, matrix, "mbsr_mass_matrix");
}
