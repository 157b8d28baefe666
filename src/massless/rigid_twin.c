/* A copy of a model in which stiff rows are rigid: see rigid_twin.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/rigid_twin.h"

#include "sweeps/loops.h"

#include <mbsrank/model.h>

void mbsri_rigid_twin_forget_plan(const mbsri_rigid_twin *twin)
{
    mbsr_model *m = twin->model;
    if (m->tree.evaluated) mbsri_sweeps_release_loops(m, m->tree.evaluated);
}

/* Takes the springs from rows: before finishing those of closures as they were added, afterwards
 * all. True: of some that are of matrices. */
static bool make_rigid(const mbsr_model *m, const bool *springs, bool finished, mbsr_model *twin)
{
    const mbsri_closure *given = m->closures.data;
    mbsri_closure *c = twin->closures.data;
    bool mixed = false;
    for (size_t id = 0; id < twin->closures.count; ++id, ++c) {
        mixed = mixed || c->def.compliant > 0;
        if (!finished && c->def.compliant > 0) continue;
        for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
            if (springs && k < given[id].rows && springs[given[id].row + k]) continue;
            c->def.stiffness[k] = c->def.damping[k] = 0.0;
        }
    }
    return mixed;
}

int mbsri_rigid_twin_open(const mbsr_model *m, mbsr_data *d, const bool *springs,
                          mbsri_rigid_twin *twin)
{
    *twin = (mbsri_rigid_twin){NULL, NULL};
    int status = mbsr_model_copy(m, &twin->model, &d->error);
    if (status) return status;
    (void)make_rigid(m, springs, false, twin->model);
    status = mbsr_model_finish(twin->model);
    if (status) {
        d->error = *mbsr_model_error(twin->model);
        return status;
    }
    if (make_rigid(m, springs, true, twin->model)) mbsri_rigid_twin_forget_plan(twin);
    return mbsr_data_create(twin->model, &twin->data, &d->error);
}

void mbsri_rigid_twin_close(mbsri_rigid_twin *twin)
{
    mbsr_data_destroy(twin->data);
    mbsr_model_destroy(twin->model);
}
