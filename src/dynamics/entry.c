/* Checks of every call on a data object, and the stages run on demand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"

#include <mbsrank/dynamics.h>

void mbsri_remember(const mbsr_model *m, mbsr_data *d, mbsri_pending pending, const double *q,
                    const double *u, const double *load)
{
    mbsri_copy((size_t)m->nq, q, d->q_last);
    mbsri_copy((size_t)m->nu, u, d->u_last);
    if (load)
        mbsri_copy((size_t)m->nu, load, d->load_last);
    else
        mbsri_zero((size_t)m->nu, d->load_last);
    d->pending = pending;
}

/* Runs the stages of a pending evaluation up to the one that is needed. */
static int catch_up(const mbsr_model *m, mbsr_data *d, mbsri_stage needed)
{
    const mbsri_pending pending = d->pending;
    const bool forward = pending != MBSRI_PENDING_INVERSE;
    const double *lambda = m->rows > 0 ? d->loop_lambda : NULL; /* of that evaluation */
    int status = mbsri_positions(m, d, d->t, d->q_last);
    if (!status && needed > MBSRI_STAGE_POSITIONS) status = mbsri_velocities(m, d, d->u_last);
    d->lambda_known = lambda != NULL;
    if (!status && needed > MBSRI_STAGE_VELOCITIES)
        status = mbsri_forces(m, d, forward ? d->load_last : NULL, lambda);
    if (!status && needed > MBSRI_STAGE_FORCES) status = mbsri_backward(m, d);
    if (!status && needed >= MBSRI_STAGE_FORCES && pending == MBSRI_PENDING_INVERSE)
        mbsri_inverse(m, d, d->load_last);
    if (!status && needed >= MBSRI_STAGE_FORCES && pending == MBSRI_PENDING_MOTION)
        mbsri_inverse(m, d, d->udot_last);
    if (!status && d->stage < MBSRI_STAGE_BACKWARD) d->pending = pending;
    return status;
}

int mbsri_enter(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage needed,
                const char *function)
{
    static const char *const stage[] = {"", "mbsr_stage_positions", "mbsr_stage_velocities",
                                        "mbsr_stage_forces", "mbsr_stage_backward"};
    if (!d) return MBSR_ERR_NULL;
    if (!m || !arguments) {
        return mbsri_fail(&d->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    }
    if (d->model != m) {
        return mbsri_fail(&d->error, MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE,
                          "%s: the data belongs to another model", function);
    }
    if (d->stage < needed && d->pending != MBSRI_PENDING_NONE) return catch_up(m, d, needed);
    if (d->stage < needed) {
        return mbsri_fail(&d->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, "%s: call %s first",
                          function, stage[needed]);
    }
    return MBSR_OK;
}

int mbsri_enter_tree(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage needed,
                     const char *function)
{
    const int status = mbsri_enter(m, d, arguments, needed, function);
    if (status || m->rows == 0) return status;
    return mbsri_fail(&d->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                      "%s: the model has closures, which this does not serve", function);
}
