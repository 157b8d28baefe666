/* A linear relation between joint coordinates: g = sum of a_k q_k - b - s(t).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "closures/coupling.h"

#include "closures/stock.h"

enum { OFFSET = MBSR_CLOSURE_BODIES };

static int position(const mbsr_closure_args *args, double *g)
{
    double s[3][MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, s[0], s[1], s[2]);
    const mbsr_closure_def *def = args->closure;
    double sum = -def->param[OFFSET] - s[0][0];
    for (int k = 0; k < def->bodies; ++k) sum += def->param[k] * args->body[k].q[def->option[k]];
    g[0] = sum;
    return status;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    const mbsr_closure_def *def = args->closure;
    for (int k = 0; k < def->bodies; ++k) {
        const int column = out->column[k] + args->body[k].d + def->option[k];
        out->matrix[(ptrdiff_t)column * out->rows] += def->param[k];
    }
    return MBSR_OK;
}

static int drift(const mbsr_closure_args *args, double *gt)
{
    double s[3][MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, s[0], s[1], s[2]);
    gt[0] = -s[1][0];
    return status;
}

static int bias(const mbsr_closure_args *args, double *out)
{
    double s[3][MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, s[0], s[1], s[2]);
    out[0] = -s[2][0];
    return status;
}

static int check_fields(const mbsr_closure_def *def, char text[MBSR_TEXT_SIZE])
{
    bool any = false;
    for (int k = 0; k < def->bodies; ++k) {
        any = any || fabs(def->param[k]) > 0.0;
        if (def->body[k] == MBSR_GROUND)
            return mbsri_refuse(text, MBSR_ERR_ID,
                                "body number %d is the ground, which has no "
                                "joint coordinates",
                                k);
        for (int j = 0; j < k; ++j) {
            if (def->body[j] == def->body[k] && def->option[j] == def->option[k])
                return mbsri_refuse(text, MBSR_ERR_VALUE,
                                    "coordinate %d of body %d stands in it twice", def->option[k],
                                    def->body[k]);
        }
    }
    return any ? MBSR_OK : mbsri_refuse(text, MBSR_ERR_VALUE, "all coefficients are zero");
}

static int check(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < args->closure->bodies; ++k) {
        const mbsr_force_body *body = args->body + k;
        const int coordinate = args->closure->option[k];
        if (coordinate < 0 || coordinate >= body->n)
            return mbsri_refuse(text, MBSR_ERR_VALUE, "coordinate %d of body %d: its joint has %d",
                                coordinate, body->id, body->n);
    }
    return MBSR_OK;
}

static const char *row(const mbsr_closure_args *args, int k)
{
    (void)args, (void)k;
    return "coordinates";
}

static const mbsr_closure_table table = {
    .version = MBSR_CLOSURE_TABLE_VERSION,
    .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN | MBSR_CLOSURE_OWN,
    .name = "coupling",
    .position = position,
    .jacobian = jacobian,
    .tangent = mbsri_constant_rows,
    .drift = drift,
    .bias = bias,
    .count = mbsri_one_row,
    .check = check,
    .check_fields = check_fields,
    .row = row,
};

mbsr_closure_def mbsr_closure_coupling(int terms, const int *body, const int *coordinate,
                                       const double *coefficient, double offset)
{
    mbsr_closure_def def = mbsr_closure_custom(&table, terms, body, 0, 0, NULL);
    for (int k = 0; k < terms && k < MBSR_CLOSURE_BODIES; ++k) {
        def.option[k] = coordinate ? coordinate[k] : 0;
        def.param[k] = coefficient ? coefficient[k] : 0.0;
    }
    def.param[OFFSET] = offset;
    return def;
}

bool mbsri_is_linear_coupling(const mbsr_closure_def *def)
{
    return def->table == &table;
}

double mbsri_coupling_hold(mbsr_closure_def *def, int k, double value)
{
    const double part = def->param[k] * value;
    def->param[OFFSET] -= part;
    --def->bodies;
    for (int l = k; l < def->bodies; ++l) {
        def->param[l] = def->param[l + 1];
        def->option[l] = def->option[l + 1];
        def->body[l] = def->body[l + 1];
    }
    return fabs(part);
}

double mbsri_coupling_rest(const mbsr_closure_def *def)
{
    return -def->param[OFFSET];
}

bool mbsri_coupling_moves(const mbsr_closure_def *def)
{
    return def->motion != NULL;
}
