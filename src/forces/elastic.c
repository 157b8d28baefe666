/* Stiffness and damping of a flexible body's modes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "flexible/data.h"
#include "forces/columns.h"
#include "forces/stock.h"

/* f_s = -K s - D s' */
static int evaluate(const mbsr_force_args *args)
{
    const mbsr_flex *f = args->force->user;
    const mbsr_force_body *body = args->body;
    mbsri_ax(f->n, f->n, -1.0, f->K, body->p + MBSR_POSE_SIZE, body->f + 6);
    mbsri_ax(f->n, f->n, -1.0, f->D, body->V + 6, body->f + 6);
    return MBSR_OK;
}

/* x^T A x */
static double square(int n, const double *A, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * mbsri_dot(n, A + (size_t)k * (size_t)n, x);
    return sum;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    const mbsr_flex *f = args->force->user;
    *energy_out += 0.5 * square(f->n, f->K, args->body->p + MBSR_POSE_SIZE);
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    const mbsr_flex *f = args->force->user;
    *power += square(f->n, f->D, args->body->V + 6);
    return MBSR_OK;
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_flex *f = args->force->user;
    const int row = out->row[0] + 6, s = out->column[0] + 6,
              sdot = mbsri_V_column(args->body, out->column[0]) + 6;
    for (int j = 0; j < f->n; ++j) {
        for (int k = 0; k < f->n; ++k) {
            mbsri_add_slope(out, row + k, s + j, -f->K[j * f->n + k]);
            mbsri_add_slope(out, row + k, sdot + j, -f->D[j * f->n + k]);
        }
    }
    return MBSR_OK;
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 1, 0, text);
    if (status || def->user) return status;
    return mbsri_refuse(text, MBSR_ERR_NULL, "flex is NULL");
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_flex *f = args->force->user;
    const mbsr_force_body *body = args->body;
    if (body->space == MBSR_SPACE_FLEXIBLE && body->d == 6 + f->n) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_SPACE, "body %d is not a flexible one of %d modes", body->id,
                        f->n);
}

static const mbsr_force_table elastic_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "elastic",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .derivatives = derivatives,
};

mbsr_force_def mbsr_force_elastic(int body, const mbsr_flex *flex)
{
    mbsr_force_def def = mbsri_stock_force(&elastic_table, 1, body, MBSR_GROUND);
    def.user = (void *)flex;
    return def;
}
