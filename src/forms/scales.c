/* Masses for the tolerances of momenta.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"
#include "model/record.h"

#include <mbsrank/dae.h>

#include <math.h>

int mbsr_momentum_scales(const mbsr_model *model, mbsr_data *data, double *mass)
{
    const int entered =
        mbsri_enter(model, data, mass, MBSRI_STAGE_BACKWARD, "mbsr_momentum_scales");
    if (entered) return entered;
    mbsr_rank_info info;
    double largest = 0.0;
    for (int id = 0; id < model->bodies; ++id) {
        const int status = mbsr_body_rank(model, data, id, &info);
        if (status == MBSR_OK) largest = fmax(largest, info.scale);
    }
    if (!(largest > 0.0)) largest = 1.0;
    for (int id = 0; id < model->bodies; ++id) {
        const mbsri_body *b = model->body + model->index[id];
        const int status = mbsr_body_rank(model, data, id, &info);
        const double scale = status == MBSR_OK && info.scale > 0.0 ? info.scale : largest;
        for (int k = 0; k < b->n; ++k) mass[b->u + k] = scale;
    }
    return MBSR_OK;
}
