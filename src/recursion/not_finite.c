/* The search for the first quantity that is not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/not_finite.h"

#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"

/* The first of a body's quantities, in the order in which they are computed, that is not finite;
 * NULL if all are. */
static const char *culprit(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const size_t dim = (size_t)b->d, n = (size_t)b->n;
    const struct {
        const char *name;
        size_t length;
        const double *x;
        mbsri_stage stage;
    } list[] = {
        {"the pose", (size_t)b->np, d->p + b->p, MBSRI_STAGE_POSITIONS},
        {"H", dim * (size_t)b->pred.d, d->H + b->dp, MBSRI_STAGE_POSITIONS},
        {"J", dim * n, d->J + b->dn, MBSRI_STAGE_POSITIONS},
        {"kI", i > 0 ? dim : 0, d->kI + b->v, MBSRI_STAGE_POSITIONS},
        {"the mass matrix", i > 0 ? dim * dim : 0, d->M + b->dd, MBSRI_STAGE_VELOCITIES},
        {"the velocity", dim, d->V + b->v, MBSRI_STAGE_VELOCITIES},
        {"kII", i > 0 ? dim : 0, d->kII + b->v, MBSRI_STAGE_VELOCITIES},
        {"the gyroscopic force", i > 0 ? dim : 0, d->h + b->v, MBSRI_STAGE_VELOCITIES},
        {"the applied force", i > 0 ? dim : 0, d->f + b->v, MBSRI_STAGE_FORCES},
        {"the joint force", n, d->tau + b->iu, MBSRI_STAGE_FORCES},
    };
    for (size_t k = 0; k < sizeof list / sizeof list[0]; ++k) {
        if (d->stage >= list[k].stage && !mbsri_finite(list[k].length, list[k].x))
            return list[k].name;
    }
    return NULL;
}

int mbsri_report_not_finite(const mbsr_model *m, mbsr_data *d, const char *function)
{
    char label[MBSRI_LABEL];
    for (int i = 0; i <= m->bodies; ++i) {
        const char *name = culprit(m, d, i);
        if (!name) continue;
        return mbsri_fail(&d->error, MBSR_NOT_FINITE, m->body[i].id, MBSR_NONE,
                          "%s: %s is not finite at t = %g",
                          i > 0 ? mbsri_body_label(m, i, label) : "root", name, d->t);
    }
    return mbsri_fail(
        &d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
        "%s: a result is not finite at t = %g although all forces and kinematics are: "
        "overflow",
        function, d->t);
}

int mbsri_check_result(const mbsr_model *m, mbsr_data *d, size_t n, const double *x,
                       const char *function)
{
    return mbsri_finite(n, x) ? MBSR_OK : mbsri_report_not_finite(m, d, function);
}

int mbsri_check_input(mbsr_data *d, size_t n, const double *x, const char *function,
                      const char *name)
{
    if (mbsri_finite(n, x)) return MBSR_OK;
    return mbsri_fail(&d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "%s: %s is not finite",
                      function, name);
}
