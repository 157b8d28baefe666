/* Forward dynamics with an estimate of its error.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"
#include "recursion/forward.h"
#include "recursion/not_finite.h"
#include "recursion/refine.h"

#include <mbsrank/dynamics.h>

int mbsr_forward_dynamics_refined(const mbsr_model *model, mbsr_data *data, double t,
                                  const double *q, const double *u, const double *tau, double *udot,
                                  double *error, double *relative)
{
    static const char name[] = "mbsr_forward_dynamics_refined";
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter_tree(m, d, q && u && udot, MBSRI_STAGE_NONE, name);
    if (!status) status = mbsri_forward_by_stages(m, d, t, q, u, tau, udot);
    if (status) return status;
    double *each = error ? error : d->u_given;
    const double largest = mbsri_refine(m, d, udot, each);
    status = mbsri_check_result(m, d, (size_t)m->nu, udot, name);
    if (!status) status = mbsri_check_result(m, d, (size_t)m->nu, each, name);
    if (status) return status;
    if (relative) *relative = largest;
    return MBSR_OK;
}
