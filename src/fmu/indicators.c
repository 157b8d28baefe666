/* Event functions of an instance: see indicators.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/indicators.h"

#include <math.h>

/* Where the coordinate of a stop stands in q; -1: it is locked. */
static int index_of_stop(const mbsri_instance *in, const mbsr_force_def *stop)
{
    const double *locked_at = in->plan.body[stop->body[0]].locked_at;
    int at, left = 0;
    mbsr_body_coordinates(in->built.model, stop->body[0], &at, NULL, NULL, NULL);
    if (locked_at && !isnan(locked_at[stop->option[0]])) return -1;
    for (int k = 0; k < stop->option[0]; ++k) left += !locked_at || isnan(locked_at[k]);
    return at + left;
}

static double distance_to_stop(const mbsri_instance *in, const mbsri_variable *v, const double *q)
{
    mbsr_force_def stop;
    mbsr_force_definition(in->built.model, v->of, &stop);
    const int at = index_of_stop(in, &stop);
    if (at < 0) return 1.0;
    return v->component == 0 ? q[at] - stop.param[0] : stop.param[1] - q[at];
}

int mbsri_indicate(mbsri_instance *in, mbsr_data *data, double t, const double *q, const double *u,
                   double *value)
{
    const mbsr_model *m = in->built.model;
    bool placed = false;
    for (int k = 0; k < in->variables.indicators; ++k) {
        const mbsri_variable *v = in->variables.list + in->variables.indicators_at + k;
        if (in->plan.force[v->of].def.table->flags & MBSR_FORCE_JOINT_ONLY) {
            value[k] = distance_to_stop(in, v, q);
            continue;
        }
        mbsr_contact_state contact;
        int status = placed ? MBSR_OK : mbsr_stage_positions(m, data, t, q);
        if (!status && !placed) status = mbsr_stage_velocities(m, data, u);
        if (!status) status = mbsr_contact_at(m, data, v->of, &contact);
        if (status) return status;
        placed = true;
        value[k] = -contact.depth;
    }
    return MBSR_OK;
}
