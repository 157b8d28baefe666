/* A run of the model without its small masses that watches what they would have done.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/stops.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* The run, and the caller's progress function. */
typedef struct follower {
    mbsr_small_masses *small;
    mbsr_ida *ida;
    double *y, *yp, last; /* the last state given, its time */
    double from;          /* time of the start */
    double moved;         /* time that steps have come to last by more than next to nothing, */
    long moved_at;        /* in this step */
    mbsr_ida_progress_fn progress;
    void *user;
    mbsr_kink_fn kink;
    void *kink_user;
} follower;

/* The joint rate, the largest, that has come to change by itself in next to no time; or none. */
static int running_away(const follower *f)
{
    static const double moment = 1e-6; /* of the run */
    const mbsr_model *m = mbsr_small_masses_reduced(f->small);
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    const double *u = f->y + nq + nu, *udot = f->yp + nq + nu, span = f->last - f->from;
    int at = 0;
    for (int k = 1; k < nu; ++k) {
        if (fabs(u[k]) > fabs(u[at])) at = k;
    }
    const bool away = nu > 0 && span > 0.0 && fabs(u[at]) < moment * span * fabs(udot[at]);
    return away ? at : MBSR_NONE;
}

/* Whether a rate runs away in a thousand steps that have not come on by a billionth of the run. */
static bool stands_still(follower *f, const mbsr_ida_progress *now)
{
    enum { MANY = 1000 };
    static const double little = 1e-9;
    if (now->t - f->moved > little * (now->t - f->from)) {
        f->moved = now->t;
        f->moved_at = now->steps;
    }
    return now->steps > f->moved_at + MANY && running_away(f) != MBSR_NONE;
}

/* Steps so short that they do not change t, where the run is about to fail, have nothing to say. */
static int follow(void *user, const mbsr_ida_progress *now)
{
    follower *f = user;
    int status = MBSR_OK;
    if (now->t > f->last) {
        status = mbsr_ida_dense(f->ida, now->t, 0, f->y);
        if (!status) status = mbsr_ida_dense(f->ida, now->t, 1, f->yp);
        if (!status) status = mbsr_small_masses_step(f->small, now->t, f->y, f->yp);
        f->last = now->t;
    }
    if (!status && stands_still(f, now)) status = MBSR_SINGULAR_BLOCK;
    if (!status && f->progress) status = f->progress(f->user, now);
    return status;
}

static int next_jump(const follower *f, double t, double t_end, double *stop)
{
    return mbsri_ida_next_jump(mbsr_small_masses_reduced(f->small), f->kink, f->kink_user, t, t_end,
                               stop);
}

/* To t_end; the state before a jump is one that the report has to see. */
static int follow_to(follower *f, double t, double t_end)
{
    double stop = t;
    int status = next_jump(f, t, t_end, &stop);
    while (!status) {
        status = mbsr_ida_advance(f->ida, stop, NULL, f->y, f->yp);
        if (status || stop >= t_end) return status;
        if (stop > f->last) status = mbsr_small_masses_step(f->small, stop, f->y, f->yp);
        f->last = stop;
        if (!status) status = next_jump(f, stop, t_end, &stop);
    }
    return status;
}

/* The body of joint rate k, whose place in its joint goes to *coordinate. */
static int body_of(const mbsr_model *m, int k, int *coordinate)
{
    int first = 0, count = 0;
    for (int body = 0; body < mbsr_model_bodies(m); ++body) {
        if (mbsr_body_coordinates(m, body, NULL, NULL, &first, &count)) continue;
        *coordinate = k - first;
        if (k >= first && k < first + count) return body;
    }
    return MBSR_NONE;
}

/* A run that has failed: where the largest rate has come to change by itself in next to no time,
 * the smooth motion ends in a jump, as at a fold of the forces that hold what has no mass; else the
 * failure is the driver's, or the report's. */
static int explain(const follower *f, int status, mbsr_error *error)
{
    const mbsr_model *m = mbsr_small_masses_reduced(f->small);
    const int at = running_away(f);
    int coordinate = 0;
    if (at != MBSR_NONE) {
        const double u = f->y[mbsr_model_nq(m) + mbsr_model_nu(m) + at],
                     udot = f->yp[mbsr_model_nq(m) + mbsr_model_nu(m) + at];
        const int body = body_of(m, at, &coordinate);
        return mbsri_ida_fail(
            error, MBSR_SINGULAR_BLOCK, body, MBSR_NONE,
            "mbsr_small_masses_run: without the masses u%d of body %d '%.40s' runs away at t = %g "
            "(%.3g, and %.3g 1/s): the smooth motion ends there in a jump; name fewer masses in "
            "`part`",
            coordinate, body, mbsr_body_name(m, body), f->last, u, fabs(udot / u));
    }
    const mbsr_error *own = mbsr_small_masses_error(f->small);
    if (error) *error = own->status == status ? *own : *mbsr_ida_error(f->ida);
    return status;
}

/* From the state that `start` has found to t_end. */
static int run(follower *f, const mbsr_ida_opt *opt, mbsr_data *data, double t_end,
               mbsr_error *error)
{
    double t = 0.0;
    int status = mbsr_ida_create(mbsr_small_masses_reduced(f->small), data, opt, &f->ida, error);
    if (status) return status;
    status = mbsr_small_masses_state(f->small, &t, f->y, f->yp);
    if (!status) status = mbsr_ida_start(f->ida, t, f->y, f->yp);
    f->last = f->from = f->moved = t;
    if (!status) status = follow_to(f, t, t_end);
    return status ? explain(f, status, error) : MBSR_OK;
}

int mbsr_small_masses_run(mbsr_small_masses *small, const mbsr_ida_opt *opt, double t_end,
                          mbsr_ida_stats *stats, mbsr_error *error)
{
    static const char function[] = "mbsr_small_masses_run";
    const mbsr_model *m = mbsr_small_masses_reduced(small);
    if (!m)
        return mbsri_ida_refuse(error, small ? MBSR_ERR_SEQUENCE : MBSR_ERR_NULL,
                                "%s: call mbsr_small_masses_start first", function);
    mbsr_ida_opt own = opt ? *opt : mbsr_default_ida_opt();
    if (own.form != MBSR_DAE_MOMENTUM)
        return mbsri_ida_refuse(error, MBSR_ERR_VALUE, "%s: only the momentum form is served",
                                function);
    follower f = {.small = small,
                  .progress = own.progress,
                  .user = own.progress_user,
                  .kink = own.kink,
                  .kink_user = own.kink_user};
    own.progress = follow;
    own.progress_user = &f;
    own.progress_steps = 1;
    own.progress_interval = 0.0;
    const size_t size = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    f.y = calloc(2 * size + 1, sizeof *f.y);
    f.yp = f.y + size;
    mbsr_data *data = NULL;
    int status = f.y ? mbsr_data_create(m, &data, error)
                     : mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY, "%s: no memory", function);
    if (!status) status = run(&f, &own, data, t_end, error);
    if (stats && f.ida) (void)mbsr_ida_get_stats(f.ida, stats);
    mbsr_ida_destroy(f.ida);
    mbsr_data_destroy(data);
    free(f.y);
    return status;
}
