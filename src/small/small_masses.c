/* The report on small masses: its entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "small/candidates.h"
#include "small/correct.h"
#include "small/directions.h"
#include "small/errors.h"
#include "small/kept_mass.h"
#include "small/loads.h"
#include "small/slow.h"
#include "small/smooth.h"
#include "small/swings.h"
#include "small/table.h"
#include "small/twins.h"
#include "small/verdicts.h"

#include <mbsrank/index.h>
#include <mbsrank/driver.h>

#include <math.h>

static const double periods = 30.0; /* slow times in a duration, where nothing is said */

mbsr_small_masses_opt mbsr_default_small_masses_opt(void)
{
    return (mbsr_small_masses_opt){.cookie = MBSRI_COOKIE,
                                   .ratio = 0.1,
                                   .most = 64,
                                   .tolerance = 1e-3,
                                   .rtol = 1e-6,
                                   .atol = 1e-6};
}

/* ---- what is refused ---- */

static bool positive(double x)
{
    return x > 0.0 && isfinite(x);
}

static int wrong(mbsr_error *error, const char *name, double value, const char *must)
{
    return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "mbsr_small_masses_create: %s is %g, must be %s", name, value, must);
}

static int check_options(const mbsr_small_masses_opt *o, mbsr_error *error)
{
    const struct {
        const char *name;
        double value;
        bool zero;
    } number[] = {{"duration", o->duration, false},
                  {"time_scale", o->time_scale, true},
                  {"ratio", o->ratio, true},
                  {"tolerance", o->tolerance, false},
                  {"rtol", o->rtol, true},
                  {"atol", o->atol, false},
                  {"atol_velocity", o->atol_velocity, true}};
    if (o->cookie != MBSRI_COOKIE)
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_small_masses_create: opt was not made by "
                          "mbsr_default_small_masses_opt");
    for (size_t k = 0; k < sizeof number / sizeof number[0]; ++k) {
        if (positive(number[k].value) || (number[k].zero && number[k].value == 0.0)) continue;
        return wrong(error, number[k].name, number[k].value,
                     number[k].zero ? "finite and not negative" : "positive and finite");
    }
    if (o->parts < 0 || (o->parts > 0 && !o->part))
        return wrong(error, "parts", o->parts, "the number of entries in part");
    if (o->most < 0) return wrong(error, "most", o->most, "not negative");
    if (o->outputs < 0 || (o->outputs > 0) != (o->output != NULL))
        return wrong(error, "outputs", o->outputs, "positive exactly when there is an output");
    return MBSR_OK;
}

/* ---- memory ---- */

/* One pass that counts, and one that places. */
typedef struct layout {
    double *at;
    size_t used;
} layout;

static double *take_vector(layout *l, size_t count)
{
    double *place = l->at ? l->at + l->used : NULL;
    l->used += count;
    return place;
}

static void place_load(layout *l, mbsri_small_load *load, int n)
{
    load->n = n;
    load->value = take_vector(l, (size_t)n);
    load->rate = take_vector(l, (size_t)n);
    load->curvature = take_vector(l, (size_t)n);
}

static void place_vectors(mbsr_small_masses *s, layout *l)
{
    const mbsr_model *m = s->given;
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = (size_t)s->size;
    double **const states[] = {&s->y,        &s->yp,        &s->y_full,
                               &s->yp_full,  &s->work.F,    &s->work.F_loaded,
                               &s->work.rhs, &s->work.total};
    for (size_t k = 0; k < sizeof states / sizeof states[0]; ++k) *states[k] = take_vector(l, size);
    s->start.q = take_vector(l, nq);
    s->work.q = take_vector(l, nq);
    s->start.u = take_vector(l, nu);
    s->work.u = take_vector(l, nu);
    s->work.load = take_vector(l, (size_t)(m->most.d > m->most.n ? m->most.d : m->most.n));
    s->work.slope = take_vector(l, size);
    s->work.trial = take_vector(l, 3 * size);
    s->work.kept = take_vector(l, 2 * size);
    s->swings.pattern = take_vector(l, size * (size_t)s->directions);
    s->slow.wanted = take_vector(l, (size_t)s->directions);
    s->swings.scale = take_vector(l, (size_t)s->directions);
    s->swings.impedance = take_vector(l, 4 * (size_t)s->directions);
    double **const joints[] = {&s->rates.along[0], &s->rates.along[1], &s->rates.along[2],
                               &s->rates.scale,    &s->rates.momentum, &s->rates.tested};
    for (size_t k = 0; k < sizeof joints / sizeof joints[0]; ++k) *joints[k] = take_vector(l, nu);
    s->tolerance = take_vector(l, (size_t)s->outputs);
    s->work.above = take_vector(l, (size_t)s->outputs);
    s->work.below = take_vector(l, (size_t)s->outputs);
    for (int k = 0; k < s->candidates; ++k) {
        mbsri_candidate *c = s->candidate + k;
        const int d = m->body[c->i].d;
        place_load(l, &c->load, d);
        c->force = take_vector(l, (size_t)d);
        c->beside = take_vector(l, (size_t)d);
        c->impulse = take_vector(l, (size_t)d);
        c->velocity = take_vector(l, (size_t)d);
        c->rest = take_vector(l, (size_t)d);
        c->mean = take_vector(l, (size_t)d);
        for (int e = 0; e < 3; ++e) c->error[e] = take_vector(l, size);
        c->offset = take_vector(l, size);
    }
    for (int k = 0; k < s->pushes; ++k) place_load(l, &s->pushed[k].push, s->pushed[k].push.n);
}

static int no_memory_for_masses(mbsr_small_masses *s)
{
    return mbsri_fail(&s->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_small_masses_create: no memory for %d masses", s->candidates);
}

static int allocate_masses(mbsr_small_masses *s)
{
    const mbsr_allocator *a = &s->allocator;
    mbsri_small_directions(s, &s->pushes, &s->directions);
    s->pushed = mbsri_allocate(a, ((size_t)s->pushes + 1) * sizeof *s->pushed);
    s->direction = mbsri_allocate(a, ((size_t)s->directions + 1) * sizeof *s->direction);
    s->slow.each = mbsri_allocate(a, ((size_t)s->directions + 1) * sizeof *s->slow.each);
    s->swings.each = mbsri_allocate(a, ((size_t)s->directions + 1) * sizeof *s->swings.each);
    s->report.mass = mbsri_allocate(a, ((size_t)s->candidates + 1) * sizeof *s->report.mass);
    s->report.text_size = mbsri_small_text_size(s);
    s->report.text = mbsri_allocate(a, s->report.text_size);
    if (!s->pushed || !s->direction || !s->slow.each || !s->swings.each || !s->report.mass ||
        !s->report.text)
        return no_memory_for_masses(s);
    mbsri_small_directions(s, &s->pushes, &s->directions);
    layout l = {NULL, 0};
    place_vectors(s, &l);
    s->numbers = mbsri_allocate(a, l.used * sizeof(double));
    if (!s->numbers) return no_memory_for_masses(s);
    mbsri_zero(l.used, s->numbers);
    l = (layout){s->numbers, 0};
    place_vectors(s, &l);
    return MBSR_OK;
}

/* ---- creation ---- */

static int take_tolerances(mbsr_small_masses *s)
{
    const double *each = s->opt.tolerance_each;
    for (int k = 0; k < s->outputs; ++k) {
        s->tolerance[k] = each ? each[k] : s->opt.tolerance;
        if (!positive(s->tolerance[k]))
            return wrong(&s->error, "a tolerance of outputs", s->tolerance[k],
                         "positive and finite");
    }
    return MBSR_OK;
}

static int build(mbsr_small_masses *s)
{
    int status = mbsri_small_candidates(s);
    if (!status) status = allocate_masses(s);
    if (!status) status = take_tolerances(s);
    return status ? status : mbsri_small_twins(s);
}

int mbsr_small_masses_create(const mbsr_model *model, const mbsr_small_masses_opt *opt,
                             mbsr_small_masses **small, mbsr_error *error)
{
    static const char function[] = "mbsr_small_masses_create";
    if (small) *small = NULL;
    if (!model || !opt || !small)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    if (!model->finished)
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", function);
    int status = check_options(opt, error);
    if (status) return status;
    mbsr_small_masses *s = mbsri_allocate(&model->allocator, sizeof *s);
    if (!s)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory",
                          function);
    *s = (mbsr_small_masses){.given = model, .allocator = model->allocator, .opt = *opt};
    s->error.body = s->error.force = MBSR_NONE;
    s->outputs = opt->output ? opt->outputs : model->nq;
    s->size = mbsr_dae_size(model, MBSR_DAE_MOMENTUM);
    if (s->opt.time_scale == 0.0) s->opt.time_scale = opt->duration / periods;
    status = build(s);
    if (status) {
        if (error) *error = s->error;
        mbsr_small_masses_destroy(s);
        return status;
    }
    s->opt.part = NULL; /* they belong to the caller */
    s->opt.tolerance_each = NULL;
    *small = s;
    return MBSR_OK;
}

void mbsr_small_masses_destroy(mbsr_small_masses *small)
{
    mbsr_small_masses *s = small;
    if (!s) return;
    const mbsr_allocator allocator = s->allocator;
    mbsri_small_twins_release(s);
    mbsri_release(&allocator, s->candidate);
    mbsri_release(&allocator, s->pushed);
    mbsri_release(&allocator, s->direction);
    mbsri_release(&allocator, s->slow.each);
    mbsri_release(&allocator, s->swings.each);
    mbsri_release(&allocator, s->report.mass);
    mbsri_release(&allocator, s->report.text);
    mbsri_release(&allocator, s->numbers);
    mbsri_release(&allocator, s);
}

/* ---- start ---- */

/* After MBSR_UNDETERMINED at the start: fewer zeros, and twins anew; *again: whether that helps. */
static int give_back(mbsr_small_masses *s, double t, bool *again)
{
    const mbsri_twin *twin = &s->reduced;
    mbsr_index_report *report;
    const int status =
        mbsr_index_report_create(twin->model, twin->data, t, s->start.q, s->start.u, &report);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(twin->data));
    int kept = 0;
    const int failed = mbsri_small_keep_mass(s, t, report, &kept);
    mbsr_index_report_destroy(twin->model, report);
    *again = kept > 0;
    return !failed && *again ? mbsri_small_twins(s) : failed;
}

static int settle_state(mbsr_small_masses *s, double t)
{
    for (;;) {
        bool again = false;
        const int status = mbsri_small_settle(s, t, s->start.q, s->start.u, s->y, s->yp);
        if (status != MBSR_UNDETERMINED) return status;
        const mbsr_error error = s->error;
        const int failed = give_back(s, t, &again);
        if (failed) return failed;
        if (!again) return mbsri_small_failed(s, status, &error);
    }
}

/* What the momenta of a twin are measured by, at the state found; scales (nu). */
static int find_scales(mbsr_small_masses *s, const mbsri_twin *twin, double t, double *scales)
{
    const mbsr_model *m = twin->model;
    mbsr_data *d = twin->data;
    int status = mbsr_stage_positions(m, d, t, s->y);
    if (!status) status = mbsr_stage_velocities(m, d, s->y + m->nq + m->nu);
    if (!status) status = mbsr_stage_forces(m, d, NULL);
    if (!status) status = mbsr_stage_backward(m, d);
    if (!status) status = mbsr_momentum_scales(m, d, scales);
    return mbsri_small_failed(s, status, mbsr_data_error(d));
}

/* The full model at the same q and u. */
static int take_full(mbsr_small_masses *s, double t)
{
    const mbsr_model *m = s->full.model;
    mbsr_data *d = s->full.data;
    int status = mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, t, s->y, s->y + m->nq + m->nu, s->y_full);
    if (!status)
        status = mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, t, s->y_full, s->yp_full, NULL, NULL);
    if (status) return mbsri_small_failed(s, status, mbsr_data_error(d));
    status = find_scales(s, &s->full, t, s->work.u);
    for (int l = 0; l < s->directions && !status; ++l) {
        const mbsr_small_direction *x = s->direction + l;
        s->swings.scale[l] = s->work.u[m->body[m->index[x->body]].u + x->coordinate];
    }
    return status ? status : find_scales(s, &s->reduced, t, s->rates.scale);
}

static int look(mbsr_small_masses *s, double t)
{
    int status = settle_state(s, t);
    if (!status) status = take_full(s, t);
    if (!status) status = mbsri_small_measure(s);
    if (!status) status = mbsri_small_slow(s);
    if (!status) status = mbsri_small_forces(s, t, s->y, s->yp);
    if (!status) status = mbsri_small_impulses(s, t, s->y);
    if (!status) status = mbsri_small_displace(s);
    if (status) return status;
    mbsri_small_amplitudes(s);
    status = mbsri_small_swings_begin(s);
    if (status) return status;
    const double c = 1.0 / s->opt.duration;
    const mbsri_small_formula whole = {c, {0.0, 0.0}, c};
    status = mbsri_small_factor(s, t, s->y, s->yp, c);
    if (!status) status = mbsri_small_solve(s, t, s->y, s->yp, &whole);
    return status ? status : mbsri_small_note(s, t, s->y);
}

/* As before the first start. */
static int forget(mbsr_small_masses *s)
{
    bool kept = false;
    s->start.known = false;
    s->slow.count = 0;
    s->zeros.worst = (mbsri_small_worst){0.0, 0.0, s->start.t, 0};
    for (int k = 0; k < s->candidates; ++k) {
        mbsri_candidate *c = s->candidate + k;
        kept = kept || c->keeps_mass;
        c->keeps_mass = false;
        c->worst = s->zeros.worst;
        for (int e = 0; e < 3; ++e) mbsri_zero((size_t)s->size, c->error[e]);
    }
    return kept ? mbsri_small_twins(s) : MBSR_OK;
}

static int refuse_call(mbsr_small_masses *s, int status, const char *text)
{
    return mbsri_fail(&s->error, status, MBSR_NONE, MBSR_NONE, "%s", text);
}

int mbsr_small_masses_start(mbsr_small_masses *small, double t, const double *q, const double *u)
{
    mbsr_small_masses *s = small;
    if (!s) return MBSR_ERR_NULL;
    if (!q || !u) return refuse_call(s, MBSR_ERR_NULL, "mbsr_small_masses_start: q or u is NULL");
    s->start.t = s->run.t[0] = t;
    int status = forget(s);
    if (status) return status;
    mbsri_copy((size_t)s->given->nq, q, s->start.q);
    mbsri_copy((size_t)s->given->nu, u, s->start.u);
    s->factorised.count = 0;
    status = look(s, t);
    if (status) return status;
    s->factorised.at_start = s->factorised.count;
    s->run.states = 1;
    s->start.known = true;
    return MBSR_OK;
}

/* ---- what follows ---- */

int mbsr_small_masses_state(const mbsr_small_masses *small, double *t, double *y, double *yp)
{
    if (!small || !t || !y || !yp) return MBSR_ERR_NULL;
    if (!small->start.known) return MBSR_ERR_SEQUENCE;
    *t = small->start.t;
    mbsri_copy((size_t)small->size, small->y, y);
    mbsri_copy((size_t)small->size, small->yp, yp);
    return MBSR_OK;
}

const mbsr_model *mbsr_small_masses_reduced(const mbsr_small_masses *small)
{
    return small && small->start.known ? small->clean : NULL;
}

int mbsr_small_masses_step(mbsr_small_masses *small, double t, const double *y, const double *yp)
{
    mbsr_small_masses *s = small;
    if (!s) return MBSR_ERR_NULL;
    if (!y || !yp) return refuse_call(s, MBSR_ERR_NULL, "mbsr_small_masses_step: y or yp is NULL");
    if (!s->start.known)
        return refuse_call(s, MBSR_ERR_SEQUENCE,
                           "mbsr_small_masses_step: call mbsr_small_masses_start first");
    if (!isfinite(t))
        return refuse_call(s, MBSR_NOT_FINITE, "mbsr_small_masses_step: t is not finite");
    if (!(t > s->run.t[0]))
        return mbsri_fail(&s->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_small_masses_step: t is %g, not later than the last one, %g", t,
                          s->run.t[0]);
    return mbsri_small_follow(s, t, y, yp);
}

int mbsr_small_masses_get_report(mbsr_small_masses *small, mbsr_small_masses_report *report)
{
    mbsr_small_masses *s = small;
    if (!s) return MBSR_ERR_NULL;
    if (!report)
        return refuse_call(s, MBSR_ERR_NULL, "mbsr_small_masses_get_report: report is NULL");
    if (!s->start.known)
        return refuse_call(s, MBSR_ERR_SEQUENCE,
                           "mbsr_small_masses_get_report: call mbsr_small_masses_start first");
    *report = (mbsr_small_masses_report){.masses = s->candidates,
                                         .directions = s->directions,
                                         .mass = s->report.mass,
                                         .direction = s->direction,
                                         .from = s->start.t,
                                         .to = s->run.t[0],
                                         .states = s->run.states,
                                         .error = s->zeros.worst.error,
                                         .time = s->zeros.worst.time,
                                         .output = s->zeros.worst.output,
                                         .share = s->zeros.worst.share,
                                         .body = MBSR_NONE,
                                         .factorisations = s->factorised.at_start,
                                         .text = s->report.text};
    report->steps = mbsri_small_judge(s);
    double most = 0.0;
    for (int k = 0; k < s->candidates; ++k) {
        report->amplitude += s->report.mass[k].amplitude;
        if (!(s->report.mass[k].share > most)) continue;
        most = s->report.mass[k].share;
        report->body = s->report.mass[k].body;
    }
    mbsri_small_write(s, report);
    return MBSR_OK;
}

int mbsr_small_masses_smooth(mbsr_small_masses *small, int order, double *q, double *u)
{
    mbsr_small_masses *s = small;
    if (!s) return MBSR_ERR_NULL;
    if (!q || !u) return refuse_call(s, MBSR_ERR_NULL, "mbsr_small_masses_smooth: q or u is NULL");
    if (!s->start.known)
        return refuse_call(s, MBSR_ERR_SEQUENCE,
                           "mbsr_small_masses_smooth: call mbsr_small_masses_start first");
    if (order != 1 && order != 2)
        return mbsri_fail(&s->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_small_masses_smooth: order is %d, must be 1 or 2", order);
    if (order == 2) return mbsri_small_correct(s, q, u);
    mbsri_copy((size_t)s->given->nq, s->y, q);
    mbsri_copy((size_t)s->given->nu, s->y + s->given->nq + s->given->nu, u);
    return MBSR_OK;
}

const mbsr_error *mbsr_small_masses_error(const mbsr_small_masses *small)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the object is NULL"};
    return small ? &small->error : &none;
}
