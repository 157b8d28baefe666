/* Kinks that tables bring into a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/drive.h"
#include "model/record.h"

#include <math.h>

/* Takes a kink of a table that is nearer than *next, or as near and in a lower derivative. `more`:
 * what the table stands for counts so many derivatives less than q and the momenta. */
static void take_nearer_kink(const mbsr_table *table, double t, int direction, int more,
                             mbsr_kink *next)
{
    mbsr_kink found;
    if (mbsr_table_kink(table, t, direction, &found.t, &found.derivative)) return;
    found.derivative += more;
    const double nearer = direction * (next->t - found.t);
    if (nearer > 0.0 || (found.t == next->t && found.derivative < next->derivative)) *next = found;
}

int mbsr_model_kink(const mbsr_model *model, double t, int direction, mbsr_kink *next)
{
    const mbsr_model *m = model;
    if (!m || !next) return MBSR_ERR_NULL;
    if (!m->finished) return MBSR_ERR_UNFINISHED;
    if (direction != 1 && direction != -1) return MBSR_ERR_VALUE;
    if (isnan(t)) return MBSR_NOT_FINITE;
    *next = (mbsr_kink){direction > 0 ? INFINITY : -INFINITY, 1};
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_joint *joint = &m->body[i].joint;
        if (joint->motion == mbsr_table_motion)
            take_nearer_kink(joint->user, t, direction, 0, next);
    }
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (force[k].def.function == mbsr_table_force)
            take_nearer_kink(force[k].def.user, t, direction, mbsri_table_lead(&force[k].def),
                             next);
    }
    const mbsri_closure *closure = m->closures.data;
    for (size_t k = 0; k < m->closures.count; ++k) {
        if (closure[k].def.motion == mbsr_table_motion)
            take_nearer_kink(closure[k].def.user, t, direction, 0, next);
    }
    return MBSR_OK;
}
