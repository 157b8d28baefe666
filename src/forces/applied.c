/* Forces given as functions of time, on a body or on a joint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

#include "../dense.h"

/* The function's components, added to `target`; MBSR_MAX_D bounds both d and n. */
static int add(const mbsr_force_args *args, int n, double *target)
{
    double value[MBSR_MAX_D];
    mbsri_zero((size_t)n, value);
    const int status = args->force->function(args->force->user, args->t, n, value);
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

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    if (!args->force->function) return mbsri_refuse(text, MBSR_ERR_NULL, "function is NULL");
    if (args->body->id == MBSR_GROUND)
        return mbsri_refuse(text, MBSR_ERR_ID, "it acts on the ground");
    return MBSR_OK;
}

static const mbsr_force_table body_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "applied force",
    .evaluate = body_evaluate,
    .check = check,
};

static const mbsr_force_table joint_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "applied joint force",
    .evaluate = joint_evaluate,
    .check = check,
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
