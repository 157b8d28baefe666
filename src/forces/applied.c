/* Forces given as functions of time: on a body, at a point of a body, on a joint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

#include "../dense.h"
#include "../space3.h"
#include "marker.h"

/* The function's n components; MBSR_MAX_D bounds both d and n. */
static int values(const mbsr_force_args *args, int n, double value[MBSR_MAX_D])
{
    mbsri_zero((size_t)n, value);
    return args->force->function(args->force->user, args->t, n, value);
}

static int add(const mbsr_force_args *args, int n, double *target)
{
    double value[MBSR_MAX_D];
    const int status = values(args, n, value);
    if (status) return status;
    for (int k = 0; k < n; ++k) target[k] += value[k];
    return MBSR_OK;
}

static int body_evaluate(const mbsr_force_args *args)
{
    return add(args, args->body->d, args->body->f);
}

static int joint_evaluate(const mbsr_force_args *args)
{
    return add(args, args->body->n, args->body->tau);
}

/* param: the point; option[0]: along the body's axes. */
static int wrench_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    double value[MBSR_MAX_D], R[9];
    mbsri_marker at;
    const int status = values(args, 6, value);
    if (status) return status;
    if (args->force->option[0]) {
        mbsri_body_axes(body, R);
        mbsri_rotate3(R, value, value);
        mbsri_rotate3(R, value + 3, value + 3);
    }
    mbsri_marker_on(body, args->force->param, &at);
    mbsri_push(body, &at, 1.0, value + 3, value);
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    if (!args->force->function) return mbsri_refuse(text, MBSR_ERR_NULL, "function is NULL");
    if (args->body->id == MBSR_GROUND)
        return mbsri_refuse(text, MBSR_ERR_ID, "it acts on the ground");
    return MBSR_OK;
}

static int wrench_check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = check(args, text);
    return status ? status : mbsri_check_spatial(args, 0, 0, text);
}

static const char *wrench_parameter(int k)
{
    static const char *const names[] = {" (point[0])", " (point[1])", " (point[2])"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table body_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS,
    .name = "applied force",
    .evaluate = body_evaluate,
    .check = check,
};

static const mbsr_force_table joint_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY,
    .name = "applied joint force",
    .evaluate = joint_evaluate,
    .check = check,
};

static const mbsr_force_table wrench_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS,
    .name = "wrench",
    .evaluate = wrench_evaluate,
    .check = wrench_check,
    .parameter = wrench_parameter,
};

static mbsr_force_def make(const mbsr_force_table *table, int body, mbsr_force_fn function,
                           void *user)
{
    mbsr_force_def def = mbsri_stock_force(table, 1, body, MBSR_GROUND);
    def.function = function;
    def.user = user;
    return def;
}

mbsr_force_def mbsr_force_applied(int body, mbsr_force_fn function, void *user)
{
    return make(&body_table, body, function, user);
}

mbsr_force_def mbsr_force_joint_applied(int body, mbsr_force_fn function, void *user)
{
    return make(&joint_table, body, function, user);
}

mbsr_force_def mbsr_force_wrench(int body, const double point[3], int body_axes,
                                 mbsr_force_fn function, void *user)
{
    mbsr_force_def def = make(&wrench_table, body, function, user);
    mbsri_store_point(point, def.param);
    def.option[0] = body_axes;
    return def;
}
