/* The stepper: its birth, its entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/cookie.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "recursion/spans.h"
#include "stepper/energy.h"
#include "stepper/step.h"

#include <math.h>

enum { MOST_HALVINGS = 10, MOST_CORRECTIONS = 100 };

mbsr_stepper_opt mbsr_default_stepper_opt(void)
{
    return (mbsr_stepper_opt){.cookie = MBSRI_COOKIE,
                              .h = 1e-3,
                              .order = 2,
                              .halvings = 4,
                              .corrections = 12,
                              .matrix_steps = 1,
                              .tolerance = 1e-9,
                              .watch_energy = 1,
                              .newton = mbsr_default_newton_opt()};
}

/* ---- what is refused ---- */

static int wrong_option(mbsr_error *error, const char *text, double value)
{
    return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "mbsr_stepper_create: %s is %g",
                      text, value);
}

static int check_options(const mbsr_stepper_opt *opt, mbsr_error *error)
{
    if (opt->cookie != MBSRI_COOKIE) {
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_create: opt was not made by mbsr_default_stepper_opt");
    }
    if (!(opt->h > 0.0 && isfinite(opt->h)))
        return wrong_option(error, "h must be positive and finite, it", opt->h);
    if (opt->order != 1 && opt->order != 2)
        return wrong_option(error, "order must be 1 or 2, it", opt->order);
    if (opt->halvings < 0 || opt->halvings > MOST_HALVINGS)
        return wrong_option(error, "halvings must be 0 .. 10, it", opt->halvings);
    if (opt->corrections < 2 || opt->corrections > MOST_CORRECTIONS)
        return wrong_option(error, "corrections must be 2 .. 100, it", opt->corrections);
    if (opt->matrix_steps < 1)
        return wrong_option(error, "matrix_steps must be positive, it", opt->matrix_steps);
    if (!(opt->tolerance > 0.0 && opt->tolerance <= 1e-3))
        return wrong_option(error, "tolerance must be positive, 1e-3 at most, it", opt->tolerance);
    return MBSR_OK;
}

static int check_stepper(const mbsr_model *model, mbsr_data *data, const mbsr_stepper_opt *opt,
                         mbsr_error *error)
{
    int status = check_options(opt, error);
    if (status) return status;
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_create: the model is not finished");
    }
    status = mbsri_enter(model, data, true, MBSRI_STAGE_NONE, "mbsr_stepper_create");
    if (status) {
        if (error) *error = data->error;
        return status;
    }
    if (!data->lean) return MBSR_OK;
    return mbsri_fail(error, MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE,
                      "mbsr_stepper_create: lean data does not hold poses and velocities");
}

/* ---- birth and death ---- */

static void find_stepper_spans(mbsr_stepper *s)
{
    const mbsr_model *m = s->model;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *q = s->span + b->q, *u = s->span + m->nq + b->u;
        for (int k = 0; k < b->nq; ++k) q[k] = mbsri_coordinate_span(&spans, m, b, false, k);
        for (int k = 0; k < b->n; ++k) u[k] = mbsri_coordinate_span(&spans, m, b, true, k);
    }
}

static bool place_vectors(mbsr_stepper *s)
{
    double **const vector[] = {&s->y, &s->yp,   &s->kept_y, &s->kept_yp, &s->Y,
                               &s->K, &s->base, &s->F,      &s->delta,   &s->before};
    const size_t count = sizeof vector / sizeof vector[0];
    const size_t nq = (size_t)s->model->nq, nu = (size_t)s->model->nu;
    const size_t numbers = count * s->size + nq + 2 * nu + 1;
    s->memory = mbsri_allocate(&s->model->allocator, numbers * sizeof(double));
    if (!s->memory) return false;
    double *at = s->memory;
    mbsri_zero(numbers, at);
    for (size_t k = 0; k < count; ++k, at += s->size) *vector[k] = at;
    s->span = at;
    s->mean = at + nq + nu;
    s->info.bytes = sizeof *s + numbers * sizeof(double);
    return true;
}

/* The Newton solver, which has to be exact. */
static int make_newton(mbsr_stepper *s, mbsr_error *error)
{
    mbsr_newton_info info;
    const int status =
        mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &s->opt.newton, &s->newton, error);
    if (status) return status;
    mbsr_newton_get_info(s->newton, &info);
    s->info.bytes += info.bytes;
    if (info.exact) return MBSR_OK;
    return mbsri_fail(
        error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
        "mbsr_stepper_create: %d force elements lie across the tree, and newton.method or "
        "newton.max_rank = %d leaves them out of the matrix",
        info.across, s->opt.newton.max_rank);
}

static int make_stepper(mbsr_stepper *s, mbsr_error *error)
{
    if (!place_vectors(s)) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_create: no memory for %zu numbers of a state", s->size);
    }
    find_stepper_spans(s);
    s->info.bound = mbsri_stepper_bound(s);
    return make_newton(s, error);
}

int mbsr_stepper_create(const mbsr_model *model, mbsr_data *data, const mbsr_stepper_opt *opt,
                        mbsr_stepper **stepper, mbsr_error *error)
{
    const mbsr_stepper_opt standard = mbsr_default_stepper_opt();
    if (!opt) opt = &standard;
    if (stepper) *stepper = NULL;
    if (!model || !data || !stepper) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_create: %s is NULL",
                          !model  ? "model"
                          : !data ? "data"
                                  : "stepper");
    }
    int status = check_stepper(model, data, opt, error);
    if (status) return status;
    mbsr_stepper *s = mbsri_allocate(&model->allocator, sizeof *s);
    if (!s) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_create: no memory");
    }
    *s = (mbsr_stepper){.model = model,
                        .data = data,
                        .opt = *opt,
                        .size = (size_t)mbsr_dae_size(model, MBSR_DAE_MOMENTUM),
                        .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""}};
    status = make_stepper(s, error);
    if (status) {
        mbsr_stepper_destroy(s);
        return status;
    }
    *stepper = s;
    return MBSR_OK;
}

void mbsr_stepper_destroy(mbsr_stepper *stepper)
{
    if (!stepper) return;
    const mbsr_allocator allocator = stepper->model->allocator;
    mbsr_newton_destroy(stepper->newton);
    if (stepper->memory) mbsri_release(&allocator, stepper->memory);
    mbsri_release(&allocator, stepper);
}

/* ---- states ---- */

static int fail_stepper(mbsr_stepper *s, int status, const char *text)
{
    return mbsri_fail(&s->error, status, MBSR_NONE, MBSR_NONE, "%s", text);
}

static int too_early(mbsr_stepper *s, const char *function)
{
    return mbsri_fail(&s->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                      "%s: call mbsr_stepper_start first", function);
}

/* Takes y and yp in kept_y and kept_yp as the state at t; on failure the state stays. */
static int begin_at(mbsr_stepper *s, double t)
{
    const mbsr_model *m = s->model;
    s->kept_account = s->account;
    int status = mbsr_stage_positions(m, s->data, t, s->kept_y);
    if (!status) status = mbsr_stage_velocities(m, s->data, s->kept_y + m->nq + m->nu);
    if (status) s->cause = *mbsr_data_error(s->data);
    if (!status) status = mbsri_stepper_open_account(s);
    if (status) {
        s->account = s->kept_account;
        s->error = s->cause;
        return status;
    }
    mbsri_copy(s->size, s->kept_y, s->y);
    mbsri_copy(s->size, s->kept_yp, s->yp);
    s->t = s->from = t;
    s->since = 0;
    s->factored = 0.0;
    s->started = true;
    return MBSR_OK;
}

int mbsr_stepper_start(mbsr_stepper *stepper, double t, const double *q, const double *u)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!q || !u) return fail_stepper(s, MBSR_ERR_NULL, "mbsr_stepper_start: q or u is NULL");
    int status = mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, t, q, u, s->kept_y);
    if (!status) {
        mbsri_zero(s->size, s->kept_yp);
        status = mbsr_dae_consistent(s->model, s->data, MBSR_DAE_MOMENTUM, t, s->kept_y, s->kept_yp,
                                     NULL, NULL);
    }
    if (status) {
        s->error = *mbsr_data_error(s->data);
        return status;
    }
    status = begin_at(s, t);
    if (status) return status;
    s->info = (mbsr_stepper_info){.bound = s->info.bound, .bytes = s->info.bytes};
    return MBSR_OK;
}

int mbsr_stepper_resume(mbsr_stepper *stepper, double t, const double *y, const double *yp)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!y || !yp) return fail_stepper(s, MBSR_ERR_NULL, "mbsr_stepper_resume: y or yp is NULL");
    if (!isfinite(t) || !mbsri_finite(s->size, y) || !mbsri_finite(s->size, yp))
        return fail_stepper(s, MBSR_NOT_FINITE, "mbsr_stepper_resume: t, y or yp is not finite");
    mbsri_copy(s->size, y, s->kept_y);
    mbsri_copy(s->size, yp, s->kept_yp);
    return begin_at(s, t);
}

int mbsr_stepper_motion(mbsr_stepper *stepper, double *t, double *q, double *u)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!s->started) return too_early(s, "mbsr_stepper_motion");
    const size_t nq = (size_t)s->model->nq, nu = (size_t)s->model->nu;
    if (t) *t = s->t;
    if (q) mbsri_copy(nq, s->y, q);
    if (u) mbsri_copy(nu, s->y + nq + nu, u);
    return MBSR_OK;
}

int mbsr_stepper_state(mbsr_stepper *stepper, double *t, double *y, double *yp)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!s->started) return too_early(s, "mbsr_stepper_state");
    if (t) *t = s->t;
    if (y) mbsri_copy(s->size, s->y, y);
    if (yp) mbsri_copy(s->size, s->yp, yp);
    return MBSR_OK;
}

int mbsr_stepper_jump(mbsr_stepper *stepper)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!s->started) return too_early(s, "mbsr_stepper_jump");
    mbsri_copy(s->size, s->y, s->kept_y);
    mbsri_copy(s->size, s->yp, s->kept_yp);
    return begin_at(s, s->t);
}

/* ---- steps ---- */

int mbsr_stepper_step(mbsr_stepper *stepper)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!s->started) return too_early(s, "mbsr_stepper_step");
    const double t_end = s->from + (double)(s->since + 1) * s->opt.h;
    if (!(t_end > s->t)) {
        return mbsri_fail(&s->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_step: a step of %g s does not change t = %g s", s->opt.h,
                          s->t);
    }
    const int status = mbsri_stepper_advance(s, t_end, s->opt.h);
    if (!status) ++s->since;
    return status;
}

int mbsr_stepper_to(mbsr_stepper *stepper, double t_end)
{
    mbsr_stepper *s = stepper;
    if (!s) return MBSR_ERR_NULL;
    if (!s->started) return too_early(s, "mbsr_stepper_to");
    if (!isfinite(t_end) || !(t_end > s->t)) {
        return mbsri_fail(&s->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_stepper_to: t_end is %g s, must be finite and later than t = %g s",
                          t_end, s->t);
    }
    const int status = mbsri_stepper_advance(s, t_end, t_end - s->t);
    if (status) return status;
    s->from = t_end;
    s->since = 0;
    return MBSR_OK;
}

int mbsr_stepper_get_info(const mbsr_stepper *stepper, mbsr_stepper_info *info)
{
    if (!stepper || !info) return MBSR_ERR_NULL;
    *info = stepper->info;
    return MBSR_OK;
}

const mbsr_error *mbsr_stepper_error(const mbsr_stepper *stepper)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the stepper is NULL"};
    return stepper ? &stepper->error : &none;
}
