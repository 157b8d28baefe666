/* Forces given as functions of time: on a body, at a point of a body, on a joint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/slopes.h"
#include "forces/stock.h"
#include "tables/table.h"

/* The function's n components; MBSR_MAX_D bounds both d and n. */
static int values(const mbsr_force_args *args, int n, double value[MBSR_MAX_D])
{
    mbsri_zero((size_t)n, value);
    return args->force->function(args->force->user, args->t, n, value);
}

static int add_values(const mbsr_force_args *args, int n, double *target)
{
    double value[MBSR_MAX_D];
    const int status = values(args, n, value);
    if (status) return status;
    for (int k = 0; k < n; ++k) target[k] += value[k];
    return MBSR_OK;
}

static int body_evaluate(const mbsr_force_args *args)
{
    return add_values(args, args->body->d, args->body->f);
}

static int joint_evaluate(const mbsr_force_args *args)
{
    return add_values(args, args->body->n, args->body->tau);
}

/* Moment and force along the world axes, and the point they act at, which param gives; option[0]:
 * they are given along the body's axes. */
static int wrench(const mbsr_force_args *args, double value[MBSR_MAX_D], mbsri_marker *at)
{
    const mbsr_force_body *body = args->body;
    const int status = values(args, 6, value);
    if (status) return status;
    if (args->force->option[0]) {
        double R[9];
        mbsri_body_axes(body, R);
        mbsri_rotate3(R, value, value);
        mbsri_rotate3(R, value + 3, value + 3);
    }
    mbsri_marker_on(body, args->force->param, at);
    return MBSR_OK;
}

static int wrench_evaluate(const mbsr_force_args *args)
{
    double value[MBSR_MAX_D];
    mbsri_marker at;
    const int status = wrench(args, value, &at);
    if (status) return status;
    mbsri_push(args->body, &at, 1.0, value + 3, value);
    return MBSR_OK;
}

/* The arm turns with the body, and so does what is given along its axes. */
static int wrench_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    mbsri_vector dforce[MBSRI_MAX_COLUMNS] = {{{0.0}}}, dmoment[MBSRI_MAX_COLUMNS] = {{{0.0}}};
    double value[MBSR_MAX_D];
    mbsri_marker at;
    const int status = wrench(args, value, &at);
    if (status) return status;
    if (args->force->option[0]) {
        mbsri_add_turn(&c, 0, MBSRI_POSE, 1.0, value, dmoment);
        mbsri_add_turn(&c, 0, MBSRI_POSE, 1.0, value + 3, dforce);
    }
    mbsri_push_slopes(&c, 0, 1.0, at.arm, value + 3, NULL, dforce, dmoment);
    return MBSR_OK;
}

static int check_function(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    if (def->function == mbsr_stored_force && !def->user)
        return mbsri_refuse(text, MBSR_ERR_NULL, "user is NULL, must be the numbers stored");
    return def->function ? MBSR_OK : mbsri_refuse(text, MBSR_ERR_NULL, "function is NULL");
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 1, 0, text);
    return status ? status : check_function(def, text);
}

static int wrench_check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 1, 1, text);
    return status ? status : check_function(def, text);
}

/* n: components that the function has to write. */
static int check_components(const mbsr_force_args *args, int n, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_def *def = args->force;
    if (args->body->id == MBSR_GROUND)
        return mbsri_refuse(text, MBSR_ERR_ID, "it acts on the ground");
    if (def->function == mbsr_table_force && mbsri_table_columns(def->user) != n)
        return mbsri_table_refuse(def->user, n, text);
    return MBSR_OK;
}

static int body_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    return check_components(args, args->body->d, text);
}

static int joint_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    return check_components(args, args->body->n, text);
}

static int wrench_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check_components(args, 6, text);
    return status ? status : mbsri_check_spatial(args, 0, 0, text);
}

static const char *wrench_parameter(int k)
{
    static const char *const names[] = {" (point[0])", " (point[1])", " (point[2])"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table body_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "applied force",
    .evaluate = body_evaluate,
    .check = body_check,
    .check_fields = check_fields,
    .derivatives = mbsri_no_slopes,
};

static const mbsr_force_table joint_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "applied joint force",
    .evaluate = joint_evaluate,
    .check = joint_check,
    .check_fields = check_fields,
    .derivatives = mbsri_no_slopes,
};

static const mbsr_force_table wrench_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "wrench",
    .evaluate = wrench_evaluate,
    .check = wrench_check,
    .check_fields = wrench_check_fields,
    .parameter = wrench_parameter,
    .derivatives = wrench_derivatives,
};

static mbsr_force_def make_applied(const mbsr_force_table *table, int body, mbsr_force_fn function,
                                   void *user)
{
    mbsr_force_def def = mbsri_stock_force(table, 1, body, MBSR_GROUND);
    def.function = function;
    def.user = user;
    return def;
}

mbsr_force_def mbsr_force_applied(int body, mbsr_force_fn function, void *user)
{
    return make_applied(&body_table, body, function, user);
}

mbsr_force_def mbsr_force_joint_applied(int body, mbsr_force_fn function, void *user)
{
    return make_applied(&joint_table, body, function, user);
}

mbsr_force_def mbsr_force_wrench(int body, const double point[3], int body_axes,
                                 mbsr_force_fn function, void *user)
{
    mbsr_force_def def = make_applied(&wrench_table, body, function, user);
    mbsri_store_point(point, def.param);
    def.option[0] = body_axes;
    return def;
}

int mbsr_stored_force(void *stored, double t, int n, double *value)
{
    (void)t;
    if (!stored || !value) return MBSR_ERR_NULL;
    for (int k = 0; k < n; ++k) value[k] = ((const double *)stored)[k];
    return MBSR_OK;
}
