/* What is far for a model: see spans.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "linear/spans.h"

#include <mbsrank/flex.h>

#include <math.h>

double mbsri_linear_length(const mbsr_model *model, mbsr_data *data)
{
    double most = 0.0;
    for (int i = 0; i < mbsr_model_bodies(model); ++i) {
        double x[3] = {0.0};
        if (mbsr_body_point(model, data, i, NULL, x, NULL, NULL)) continue;
        most = fmax(most, sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
    }
    return most;
}

void mbsri_linear_spans(const mbsr_model *model, int body, bool rates, double length, double *span)
{
    int nq, n;
    mbsr_body_def def;
    mbsr_flex_def data;
    const mbsr_flex *flex = NULL;
    mbsr_coordinate_kind kind[MBSRI_LINEAR_SPANS];
    mbsr_body_coordinates(model, body, NULL, &nq, NULL, &n);
    const int count = rates ? n : nq;
    const bool known =
        count <= MBSRI_LINEAR_SPANS && mbsr_body_coordinate_kinds(model, body, rates ? NULL : kind,
                                                                  rates ? kind : NULL) == MBSR_OK;
    if (mbsr_body_definition(model, body, &def) == MBSR_OK &&
        def.inertia.kind == MBSR_INERTIA_FLEXIBLE &&
        mbsr_flex_definition(def.inertia.flex, &data) == MBSR_OK && data.modes == count)
        flex = def.inertia.flex;
    for (int k = 0; k < count; ++k) {
        span[k] = known && kind[k] == MBSR_COORDINATE_TRANSLATION ? length
                                                                  : mbsr_flex_span(flex, k, length);
    }
}
