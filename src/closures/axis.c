/* A difference of coordinates of two bodies: g = p_a[axis] - p_b[axis] - rest, where V = p'.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "closures/rows.h"
#include "closures/stock.h"

enum { REST };

static int position(const mbsr_closure_args *args, double *g)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const int axis = args->closure->option[0];
    g[0] = mbsri_entry(a, a->p, axis) - mbsri_entry(b, b->p, axis) - args->closure->param[REST];
    return MBSR_OK;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    const int axis = args->closure->option[0];
    for (int k = 0; k < 2; ++k) {
        if (out->column[k] >= 0) out->matrix[out->column[k] + axis] += k == 0 ? 1.0 : -1.0;
    }
    return MBSR_OK;
}

static const char *row(const mbsr_closure_args *args, int k)
{
    (void)args, (void)k;
    return "axis";
}

mbsr_closure_def mbsri_closure_axis(int a, int b, int axis, double rest)
{
    static const mbsr_closure_table table = {
        .version = MBSR_CLOSURE_TABLE_VERSION,
        .flags = MBSR_CLOSURE_OWN,
        .name = "axis",
        .position = position,
        .jacobian = jacobian,
        .tangent = mbsri_constant_rows,
        .drift = mbsri_no_numbers,
        .bias = mbsri_no_numbers,
        .count = mbsri_one_row,
        .row = row,
    };
    mbsr_closure_def def = mbsri_stock_closure(&table, a, b);
    def.option[0] = axis;
    def.param[REST] = rest;
    return def;
}
