/* A consistent start for every form: what is asked, the start itself, what has changed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Trees start by start.c, models with closures by loops_start.c. Both take velocities u_0 to
 * consistent ones, u = S(u_0). Rates that are kept are brought about by Newton's method on u_0
 * (kept_rates.h), each step of which ends with a start of its own; so they hold in every way that a
 * start can go. */
#include "algebra/dense.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "loops/closing.h"
#include "massless/imbalance.h"
#include "massless/kept_rates.h"
#include "massless/loops_start.h"
#include "massless/open.h"
#include "massless/start.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <mbsrank/dynamics.h>

#include <math.h>

static const char function[] = "mbsr_dae_consistent";

mbsr_consistent_opt mbsr_default_consistent_opt(void)
{
    return (mbsr_consistent_opt){.cookie = MBSRI_COOKIE, .max_iterations = 30, .tolerance = 1e-12};
}

/* ---- what is asked ---- */

static int check_call(const mbsr_model *m, mbsr_data *d, mbsr_dae_form form,
                      const mbsr_consistent_opt *opt)
{
    if (m->rows > 0 && mbsri_find_form(form) && form != MBSR_DAE_MOMENTUM) {
        return mbsri_fail(&d->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "%s: the model has closures, which only the momentum form takes",
                          function);
    }
    if (mbsr_dae_size(m, form) < 0) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: form is %d, no such form", function, (int)form);
    }
    if (opt->cookie != MBSRI_COOKIE) {
        return mbsri_fail(&d->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "%s: opt was not made by mbsr_default_consistent_opt", function);
    }
    if (opt->max_iterations < 1 || !(opt->tolerance > 0.0)) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: max_iterations is %d, tolerance is %g; both must be positive",
                          function, opt->max_iterations, opt->tolerance);
    }
    if (opt->side < -1 || opt->side > 1) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: side is %d, must be -1, 0 or 1", function, opt->side);
    }
    return mbsri_closing_check(m, d, opt->weight, opt->keep_position, function);
}

/* ---- the start ---- */

typedef struct start {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_dae_form number;
    const mbsri_dae_form *form;
    double t;
    const mbsr_consistent_opt *opt;
    mbsr_consistent_info *info;
    double *q_given, *u_given, *tried; /* nq, nu, nu: velocities that a start begins with */
    double *q_begun, *u_begun;         /* nq, nu: the state that it does, in joint coordinates */
    double *residual;                  /* nu */
    double *q, *u, *udot, *y, *yp;     /* nq, nu, nu, size, size: where it leads */
    double *span;                      /* nu: of joint rates, but for 1/s */
    double *momentum, *zero;           /* of the momentum form, and its rates, for other forms */
    double *wanted, *missing, *size;   /* of rates that are kept */
    int *rate, count;                  /* their places in u */
    mbsr_completion *completion;       /* where some direction moves no mass */
    mbsri_start search;
    void *memory;
} start;

static int allocate_start(start *s)
{
    const mbsr_model *m = s->m;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = (size_t)s->form->size(m),
                 other = (size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double **const array[] = {&s->q_given, &s->u_given, &s->tried,    &s->q,    &s->u,
                              &s->y,       &s->yp,      &s->momentum, &s->zero, &s->wanted,
                              &s->missing, &s->size,    &s->span,     &s->udot, &s->q_begun,
                              &s->u_begun, &s->residual};
    const size_t length[] = {nq, nu, nu, nq, nu, size, size, other, other,
                             nu, nu, nu, nu, nu, nq,   nu,   nu};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    s->memory = mbsri_allocate(&m->allocator, total * sizeof(double) + nu * sizeof(int));
    if (!s->memory)
        return mbsri_fail(&s->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for a state of %d coordinates", function, m->nq + m->nu);
    double *next = s->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    s->rate = (int *)(void *)next;
    return MBSR_OK;
}

/* What finds the velocities of what has no mass, once. */
static int open_search(start *s)
{
    mbsr_error error = {.status = MBSR_OK};
    if (s->completion) return MBSR_OK;
    int status = mbsr_completion_create(s->m, NULL, &s->completion, &error);
    if (!status) status = mbsri_start_open(&s->search, s->completion);
    if (status == MBSR_ERR_NO_MEMORY)
        return mbsri_fail(&s->d->error, status, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for Newton systems of %d coordinates", function,
                          s->m->nq + s->m->nu);
    if (status) s->d->error = error;
    return status;
}

static void close_search(start *s)
{
    mbsri_start_close(&s->search);
    mbsr_completion_destroy(s->completion);
}

/* Refuses a state found, or why none was, where nothing determines a direction there, if that is
 * not clear, or at the state given. */
static int refuse(start *s, int status, bool clear, bool doubtful)
{
    const mbsr_model *m = s->m;
    const mbsr_completion *w = s->completion;
    mbsri_verdict verdict = {.made = false};
    int refused = MBSR_OK;
    if (!status && !clear)
        refused = mbsri_refuse_open(m, s->d, s->t, s->q, s->u, function, &verdict);
    if (!refused && (status || doubtful))
        refused = mbsri_refuse_open(m, s->d, s->t, s->q_begun, s->u_begun, function, &verdict);
    if (refused || !status) return refused;
    s->d->error = w->error;
    if (status != MBSR_UNDETERMINED || !verdict.made) return status;
    return mbsri_refuse_elsewhere(s->d, function);
}

/* From s->q_begun, s->u_begun to a state in s->q, s->u, s->udot, some directions without mass. */
static int search(start *s, mbsr_consistent_info *info)
{
    const mbsr_model *m = s->m;
    mbsri_start *b = &s->search;
    bool clear = false;
    int status = open_search(s);
    if (status) return status;
    b->opt = s->opt;
    b->info = info;
    b->given.q = s->q_begun;
    b->given.u = s->u_begun;
    status = mbsri_start_find(b, s->d, s->t, &clear);
    const mbsr_completion *w = s->completion;
    if (!status) {
        mbsri_copy((size_t)m->nq, w->y, s->q);
        mbsri_copy((size_t)m->nu, w->y + w->rates, s->u);
        mbsri_copy((size_t)m->nu, w->rate + w->rates, s->udot);
    }
    if (status < 0 || (clear && !b->doubtful)) {
        if (status) s->d->error = w->error;
        return status;
    }
    return refuse(s, status, clear, b->doubtful);
}

/* From s->q and s->u to a state, with u': where all directions move mass that of forward dynamics.
 */
static int find_state(start *s, mbsr_consistent_info *info)
{
    const mbsr_model *m = s->m;
    mbsr_data *d = s->d;
    int status = mbsri_positions(m, d, s->t, s->q);
    if (!status) status = mbsri_velocities(m, d, s->u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    if (d->total_rank == m->nu) return mbsr_forward_dynamics(m, d, s->t, s->q, s->u, NULL, s->udot);
    info->force_defect = mbsri_largest_defect(m, d, false, 0.0, NULL);
    mbsri_copy((size_t)m->nq, s->q, s->q_begun);
    mbsri_copy((size_t)m->nu, s->u, s->u_begun);
    return search(s, info);
}

/* y and y' of the state in s->q, s->u, s->udot. */
static int deliver(start *s)
{
    const mbsr_model *m = s->m;
    mbsr_data *d = s->d;
    const size_t size = (size_t)s->form->size(m);
    int status = mbsri_pack(s->form, m, d, s->t, s->q, s->u, s->y);
    if (!status) status = mbsri_positions(m, d, s->t, s->q);
    if (!status) status = mbsri_velocities(m, d, s->u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    if (d->total_rank < m->nu) mbsri_forward_with_null(m, d, s->udot, s->residual);
    status = s->form->start(m, d, s->t, s->y, s->udot, s->yp);
    if (!status) status = mbsri_check_result(m, d, size, s->y, function);
    return status ? status : mbsri_check_result(m, d, size, s->yp, function);
}

/* Of a tree, from s->y. */
static int start_tree(start *s, mbsr_consistent_info *info)
{
    int status = mbsri_unpack(s->form, s->m, s->d, s->t, s->y, s->q, s->u);
    if (!status) status = find_state(s, info);
    return status ? status : deliver(s);
}

/* The start from s->y. */
static int start_once(start *s)
{
    mbsr_consistent_info found = {.position_changed = MBSR_NONE, .velocity_changed = MBSR_NONE};
    const int before = s->info->iterations;
    const int status =
        s->m->rows > 0 ? mbsri_loops_start(s->m, s->d, s->number, s->t, s->y, s->yp, s->opt, &found)
                       : start_tree(s, &found);
    *s->info = found;
    s->info->iterations += before;
    return status ? status : mbsri_unpack(s->form, s->m, s->d, s->t, s->y, s->q, s->u);
}

/* ---- rates that are kept ---- */

static void list_kept(start *s)
{
    for (int k = 0; k < s->m->nu && s->opt->keep_rate; ++k) {
        if (!s->opt->keep_rate[k]) continue;
        s->wanted[s->count] = s->u_given[k];
        s->size[s->count] = 0.0;
        s->rate[s->count++] = k;
    }
}

/* How fast the model moves, 1/s: the largest of rates u (nu) over its span; no slower than is
 * typical of it. */
static double speed_of(const start *s, const double *u, double *span)
{
    const mbsri_spans spans = mbsri_spans_of(s->m, NULL);
    double speed = mbsri_span_rate(&spans);
    for (int i = 1; i <= s->m->bodies; ++i) {
        const mbsri_body *b = s->m->body + i;
        for (int k = 0; k < b->n; ++k) {
            span[b->u + k] = mbsri_coordinate_span(&spans, s->m, b, true, k);
            speed = fmax(speed, fabs(u[b->u + k]) / span[b->u + k]);
        }
    }
    return speed;
}

/* The largest of what is missing beside what rounding in it is relative to: how fast the model
 * moves. */
static double find_missing(start *s)
{
    const double speed = fmax(speed_of(s, s->u, s->span), speed_of(s, s->u_given, s->span));
    double largest = 0.0;
    for (int l = 0; l < s->count; ++l) {
        s->missing[l] = s->wanted[l] - s->u[s->rate[l]];
        s->size[l] = fmax(s->size[l], speed * s->span[s->rate[l]]);
        if (s->missing[l] != 0.0) largest = fmax(largest, fabs(s->missing[l]) / s->size[l]);
    }
    return largest;
}

/* Impulses for what is missing, into s->tried. */
static int push(start *s)
{
    const bool momentum = s->number == MBSR_DAE_MOMENTUM;
    mbsri_kept_rates kept = {.t = s->t,
                             .y = momentum ? s->y : s->momentum,
                             .yp = momentum ? s->yp : s->zero,
                             .count = s->count,
                             .rate = s->rate,
                             .wanted = s->wanted,
                             .missing = s->missing,
                             .speed = speed_of(s, s->u_given, s->span),
                             .size = s->size};
    int status = MBSR_OK;
    if (!momentum) {
        mbsri_zero((size_t)mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM), s->zero);
        status = mbsri_pack(mbsri_find_form(MBSR_DAE_MOMENTUM), s->m, s->d, s->t, s->q, s->u,
                            s->momentum);
    }
    return status ? status : mbsri_kept_rates_push(s->m, s->d, &kept, s->tried);
}

/* The last digits of rates that are kept, where they stand in y themselves. */
static void settle_digits(start *s)
{
    const int momenta = s->number == MBSR_DAE_MOMENTUM ? s->m->nu : 0;
    for (int l = 0; l < s->count && s->number != MBSR_DAE_INDEX1; ++l)
        s->u[s->rate[l]] = s->y[s->m->nq + momenta + s->rate[l]] = s->wanted[l];
}

/* No velocities found; `share` of the rate that lacks most is missing. */
static int refuse_missing(const start *s, double share)
{
    const mbsr_model *m = s->m;
    char label[MBSRI_LABEL];
    int l = 0;
    while (fabs(s->missing[l]) < share * s->size[l]) ++l;
    const int i = mbsri_body_of_rate(m, s->rate[l]);
    return mbsri_fail(&s->d->error, MBSR_NO_CONVERGENCE, m->body[i].id, MBSR_NONE,
                      "%s: u%d of %s cannot keep %.9g: no impulses found that balance forces with "
                      "it, %.3g is missing",
                      function, s->rate[l] - m->body[i].u, mbsri_body_label(m, i, label),
                      s->wanted[l], s->missing[l]);
}

static int keep_rates(start *s)
{
    enum { PASSES = 30 };
    static const double exact = 1e-14, good = 1e-8;
    double last = INFINITY, now = find_missing(s);
    int status = MBSR_OK;
    for (int pass = 0; pass < PASSES && now > exact; ++pass) {
        if (now > 0.25 * last && now <= good) break;
        last = now;
        status = push(s);
        if (!status) status = mbsri_pack(s->form, s->m, s->d, s->t, s->q_given, s->tried, s->y);
        if (!status) status = start_once(s);
        if (status) return status;
        now = find_missing(s);
    }
    if (now > good) return refuse_missing(s, now);
    settle_digits(s);
    return MBSR_OK;
}

/* ---- what has changed ---- */

static double largest_change(int n, const double *before, const double *after, int *at)
{
    double largest = 0.0;
    *at = MBSR_NONE;
    for (int k = 0; k < n; ++k) {
        const double change = fabs(after[k] - before[k]);
        if (change <= largest) continue;
        largest = change;
        *at = k;
    }
    return largest;
}

/* Refuses a coordinate that was to stay and has not, but for rounding of what it spans: forces
 * along directions without mass have moved it. */
static int check_positions(const start *s)
{
    static const double rounding = 1e-13;
    const mbsr_model *m = s->m;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    char label[MBSRI_LABEL];
    for (int i = 1; i <= m->bodies && s->opt->keep_position; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->nq; ++k) {
            const int rate = k < b->nq - b->n ? 0 : k - (b->nq - b->n);
            const double before = s->q_given[b->q + k], after = s->q[b->q + k],
                         span = mbsri_coordinate_span(&spans, m, b, false, k);
            if (!s->opt->keep_position[b->u + rate]) continue;
            if (fabs(after - before) <= rounding * fmax(span, fabs(before))) continue;
            return mbsri_fail(
                &s->d->error, MBSR_NO_CONVERGENCE, b->id, MBSR_NONE,
                "%s: q%d of %s cannot stay at %.9g: forces along directions without mass "
                "balance at %.9g",
                function, k, mbsri_body_label(m, i, label), before, after);
        }
    }
    return MBSR_OK;
}

static int run(start *s, double *y, double *yp)
{
    const mbsr_model *m = s->m;
    const size_t size = (size_t)s->form->size(m);
    int status = mbsri_unpack(s->form, m, s->d, s->t, y, s->q_given, s->u_given);
    if (status) return status;
    mbsri_copy((size_t)m->nu, s->u_given, s->tried);
    mbsri_copy(size, y, s->y);
    list_kept(s);
    status = start_once(s);
    if (!status && s->count > 0) status = keep_rates(s);
    if (!status) status = check_positions(s);
    if (status) return status;
    s->info->position_change = largest_change(m->nq, s->q_given, s->q, &s->info->position_changed);
    s->info->velocity_change = largest_change(m->nu, s->u_given, s->u, &s->info->velocity_changed);
    mbsri_copy(size, s->y, y);
    mbsri_copy(size, s->yp, yp);
    return MBSR_OK;
}

int mbsr_dae_consistent(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                        double *y, double *yp, const mbsr_consistent_opt *opt,
                        mbsr_consistent_info *info)
{
    const mbsr_consistent_opt standard = mbsr_default_consistent_opt();
    mbsr_consistent_info found = {.position_changed = MBSR_NONE, .velocity_changed = MBSR_NONE};
    if (!opt) opt = &standard;
    int status = mbsri_enter(model, data, y && yp, MBSRI_STAGE_NONE, function);
    if (!status) status = check_call(model, data, form, opt);
    if (status) return status;
    start s = {.m = model,
               .d = data,
               .number = form,
               .form = mbsri_find_form(form),
               .t = t,
               .opt = opt,
               .info = &found};
    status = allocate_start(&s);
    if (status) return status;
    const bool watching = data->watch.active;
    data->watch.active = false; /* a new start may have other ranks */
    status = run(&s, y, yp);
    data->watch.active = watching;
    if (info) *info = found;
    close_search(&s);
    mbsri_release(&model->allocator, s.memory);
    return status;
}
