/* The functions of a closure's table with its rows combined: see closure_rows.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/closure_rows.h"

#include "algebra/dense.h"

/* x (held) <- T x */
static void mix_rows(const mbsri_closure *c, double *x)
{
    double was[MBSR_CLOSURE_ROWS];
    if (!c->mix) return;
    mbsri_copy((size_t)c->position_rows, x, was);
    for (int k = 0; k < c->position_rows; ++k)
        x[k] = mbsri_dot(c->position_rows, c->mix + k * c->position_rows, was);
}

int mbsri_closure_position(const mbsri_closure *c, const mbsr_closure_args *args, double *g)
{
    const int status = c->def.table->position(args, g);
    mix_rows(c, g);
    return status;
}

int mbsri_closure_jacobian(const mbsri_closure *c, const mbsr_closure_args *args,
                           const mbsr_closure_jacobian *out)
{
    const int status = c->def.table->jacobian(args, out);
    for (int j = 0; j < out->columns && c->mix; ++j)
        mix_rows(c, out->matrix + (ptrdiff_t)j * out->rows);
    return status;
}

int mbsri_closure_table_tangent(const mbsri_closure *c, const mbsr_closure_args *args,
                                const double *lambda, const mbsr_closure_tangent *out)
{
    double forces[MBSR_CLOSURE_ROWS] = {0.0};
    if (!c->mix) return c->def.table->tangent(args, lambda, out);
    /* lambda of the table's rows: T^T lambda */
    for (int k = 0; k < c->position_rows; ++k) {
        for (int j = 0; j < c->position_rows; ++j)
            forces[j] += c->mix[k * c->position_rows + j] * lambda[k];
    }
    for (int k = c->position_rows; k < c->rows; ++k) forces[k] = lambda[k];
    const int status = c->def.table->tangent(args, forces, out);
    for (int j = 0; j < out->columns; ++j) mix_rows(c, out->rate + (ptrdiff_t)j * out->rows);
    return status;
}

int mbsri_closure_table_drift(const mbsri_closure *c, const mbsr_closure_args *args, double *gt)
{
    const int status = c->def.table->drift(args, gt);
    mix_rows(c, gt);
    return status;
}

int mbsri_closure_table_bias(const mbsri_closure *c, const mbsr_closure_args *args, double *bias)
{
    const int status = c->def.table->bias(args, bias);
    mix_rows(c, bias);
    return status;
}
