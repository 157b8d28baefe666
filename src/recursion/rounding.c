/* What of C and of the mass matrix is nothing but rounding: see rounding.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/rounding.h"

#include "algebra/dense.h"
#include "algebra/pivots.h"
#include "inertias/exact.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/pose.h"
#include "recursion/rank.h"
#include "recursion/spans.h"

#include <math.h>

/* Entries of C below these shares of what is added up in them are zero; the second where a
 * closure's derivatives are differences. */
static const double ROUNDING = 1e-13, DIFFERENCES = 1e-9;

void mbsri_row_parts(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c, int l, int k,
                     double *turn, double *move)
{
    const mbsri_body *b = m->body + c->body[l];
    double square[2] = {0.0};
    for (int j = 0; j < b->d && c->column[l] >= 0; ++j) {
        const double C = d->closure_C[c->at + (size_t)((c->column[l] + j) * c->rows + k)];
        square[mbsri_is_angle(b->joint.space, j)] += C * C;
    }
    *move = sqrt(square[0]);
    *turn = sqrt(square[1]);
}

void mbsri_share_of_joint(const mbsr_model *m, const mbsri_body *b, int j, double C, double *share)
{
    const bool slides = mbsri_coordinate_kind(b, true, j) == MBSR_COORDINATE_TRANSLATION;
    mbsri_share(slides ? 0.0 : fabs(C), slides ? fabs(C) : 0.0, m->typical.length, share);
}

mbsr_coordinate_kind mbsri_row_kind(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                                    int k)
{
    const double *C = d->closure_C + c->at + k;
    bool linear = false;
    if (c->def.table->flags & MBSR_CLOSURE_JOINTS) return MBSR_COORDINATE_OTHER;
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = m->body + c->body[l];
        const bool space = b->joint.space == MBSR_SPACE_SPATIAL,
                   plane = b->joint.space == MBSR_SPACE_PLANAR;
        const int from = space ? 3 : 0, to = space ? 6 : plane ? 2 : b->d;
        for (int j = from; j < to && c->column[l] >= 0; ++j)
            linear = linear || fabs(C[(size_t)(c->column[l] + j) * (size_t)c->rows]) > 0.0;
    }
    return linear ? MBSR_COORDINATE_TRANSLATION : MBSR_COORDINATE_ROTATION;
}

/* The longest lever in the mechanism: between origins of neighbours, and of rows about origins,
 * which all vanish where points stand in one line; so no less than the length typical of the model.
 */
double mbsri_longest_lever(const mbsr_model *m, const mbsr_data *d)
{
    const mbsri_closure *first = mbsri_all_closures(m);
    double length = m->typical.length, turn, move;
    for (int i = 1; i <= m->bodies; ++i)
        length = fmax(length, mbsri_lever_of(m->body + i, d->H + m->body[i].dp));
    for (const mbsri_closure *c = first; c < first + m->closures.count; ++c) {
        for (int l = 0; l < c->bodies * c->rows; ++l) {
            mbsri_row_parts(m, d, c, l / c->rows, l % c->rows, &turn, &move);
            if (move > 1e-3) length = fmax(length, turn / move);
        }
    }
    return length;
}

double mbsri_row_rounding(const mbsri_closure *c)
{
    return c->def.table->jacobian ? ROUNDING : DIFFERENCES;
}
