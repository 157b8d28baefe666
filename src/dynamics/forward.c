/* Forward dynamics (articulated-body algorithm): by the vectorised sweeps, or by the stages.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"
#include "loops/forward.h"
#include "recursion/forward.h"
#include "recursion/rank.h"
#include "sweeps/dynamics.h"

#include <mbsrank/dynamics.h>

static int closed_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                           const double *u, const double *tau, double *udot)
{
    const int status = mbsri_sweeps_loops_dynamics(m, d, t, q, u, tau, udot);
    if (status == MBSRI_NOT_SERVED)
        return mbsri_loops_forward(m, d, t, q, u, tau, NULL, udot, "mbsr_forward_dynamics");
    if (!status) mbsri_remember(m, d, MBSRI_PENDING_MOTION, q, u, tau);
    return status;
}

int mbsr_forward_dynamics(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                          const double *u, const double *tau, double *udot)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, q && u && udot, MBSRI_STAGE_NONE, "mbsr_forward_dynamics");
    if (status) return status;
    if (m->rows > 0) return closed_dynamics(m, d, t, q, u, tau, udot);
    status = mbsri_sweeps_forward_dynamics(m, d, t, q, u, tau, udot);
    if (status == MBSRI_NOT_SERVED) return mbsri_forward_by_stages(m, d, t, q, u, tau, udot);
    if (status) return status;
    mbsri_remember(m, d, MBSRI_PENDING_FORWARD, q, u, tau);
    d->total_rank = 0;
    for (int i = 1; i <= m->live; ++i) d->total_rank += d->rank[i];
    return d->total_rank == m->nu ? MBSR_OK : mbsri_check_ranks(m, d);
}
