/* What an element exerts on one of its bodies, as an output.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "linear/record.h"

int mbsri_body_of_force(const mbsr_model *m, int force, int place)
{
    mbsr_force_def def;
    if (mbsr_force_definition(m, force, &def)) return MBSR_GROUND;
    const bool every = (def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    if (place < 0 || place >= (every ? mbsr_model_bodies(m) : def.bodies)) return MBSR_GROUND;
    return every ? place : (def.body_list ? def.body_list : def.body)[place];
}

int mbsri_sample_force(const mbsr_model *m, mbsr_data *d, const mbsr_signal *s, double *value)
{
    double f[MBSR_MAX_D] = {0.0}, tau[MBSR_MAX_D] = {0.0};
    const int status = mbsr_force_load(m, d, s->id, s->place, f, tau),
              size = mbsr_body_dimension(m, mbsri_body_of_force(m, s->id, s->place));
    *value = s->part < size ? f[s->part] : tau[s->part - size];
    return status;
}
