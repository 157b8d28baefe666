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

static double vector_size(const double x[3])
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* The amplitude of mode k that moves the body by `length`, in the mean square over its mass or at a
 * marker, or turns one by 1 rad; 1: none does. */
static double span_of_mode(const mbsr_flex_def *f, int k, double length)
{
    const int shapes = f->modes + f->dependent;
    double moves = f->mass > 0.0 ? sqrt(fmax(0.0, f->Mf[k * (shapes + 1)]) / f->mass) : 0.0,
           turns = 0.0;
    for (int i = 0; i < f->markers; ++i) {
        moves = fmax(moves, vector_size(f->marker[i].Phi + (ptrdiff_t)3 * k));
        turns = fmax(turns, vector_size(f->marker[i].Psi + (ptrdiff_t)3 * k));
    }
    const double reach = fmax(moves / length, turns);
    return reach > 0.0 ? 1.0 / reach : 1.0;
}

void mbsri_linear_spans(const mbsr_model *model, int body, bool rates, double length, double *span)
{
    int nq, n;
    mbsr_body_def def;
    mbsr_flex_def flex = {.modes = 0};
    mbsr_coordinate_kind kind[MBSRI_LINEAR_SPANS];
    mbsr_body_coordinates(model, body, NULL, &nq, NULL, &n);
    const int count = rates ? n : nq;
    const bool known =
        count <= MBSRI_LINEAR_SPANS && mbsr_body_coordinate_kinds(model, body, rates ? NULL : kind,
                                                                  rates ? kind : NULL) == MBSR_OK;
    if (mbsr_body_definition(model, body, &def) == MBSR_OK &&
        def.inertia.kind == MBSR_INERTIA_FLEXIBLE)
        mbsr_flex_definition(def.inertia.flex, &flex);
    for (int k = 0; k < count; ++k) {
        span[k] = known && kind[k] == MBSR_COORDINATE_TRANSLATION ? length
                  : flex.modes == count                           ? span_of_mode(&flex, k, length)
                                                                  : 1.0;
    }
}
