/* Sensitivities of runs: the run, of which the ends of the steps are kept.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/given.h"
#include "ida/record.h"
#include "ida/sensitivity_record.h"
#include "ida/stops.h"

#include <math.h>
#include <string.h>

/* ---- steps ---- */

static int no_memory_for_step(mbsr_sensitivity *s)
{
    return mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY,
                            "mbsr_sensitivity_run: no memory for %zu steps", s->step.count + 1);
}

static int lower_order(int a, int b)
{
    return a < b ? a : b;
}

/* A node at t, with the state of the driver's polynomial. */
static int keep_node(mbsr_sensitivity *s, double t, int order, bool first, bool crossed)
{
    const size_t size = (size_t)s->size;
    if (!mbsri_sensitivity_reserve(&s->step, 1, sizeof(mbsri_kept_step)) ||
        !mbsri_sensitivity_reserve(&s->state, 2 * size, sizeof(double)))
        return no_memory_for_step(s);
    mbsri_kept_step *step = (mbsri_kept_step *)s->step.data + s->step.count;
    double *y = (double *)s->state.data + s->state.count;
    int status = mbsr_ida_dense(s->ida, t, 0, y);
    if (!status) status = mbsr_ida_dense(s->ida, t, 1, y + size);
    if (status) return status;
    *step = (mbsri_kept_step){t, order, first ? 0 : step[-1].since + 1, crossed};
    ++s->step.count;
    s->state.count += 2 * size;
    return MBSR_OK;
}

/* Nodes of the part of a step that is behind a crossing: the shortest has order 1. */
static int keep_parts(mbsr_sensitivity *s, double from, double to, bool crossed)
{
    static const double part[] = {0.0625, 0.125, 0.25, 0.5};
    int status = MBSR_OK;
    for (size_t k = 0; crossed && k < sizeof part / sizeof part[0] && !status; ++k)
        status = keep_node(s, from + part[k] * (to - from), s->rise, k == 0, k == 0);
    return status;
}

/* u of directions that springs alone hold jumps there, and a frame turns these. */
static int refuse_frame(mbsr_sensitivity *s, double t)
{
    return mbsri_ida_refuse(&s->error, MBSR_ERR_SPACE,
                            "mbsr_sensitivity_run: %s: at t = %.10g a law takes another branch "
                            "where springs alone hold directions without mass",
                            s->frame, t);
}

/* A step that has ended there. Where an element takes another branch within it there is a node, and
 * a segment begins; where that is at its end, with the next step. */
static int keep_step(mbsr_sensitivity *s, const mbsr_ida_progress *now)
{
    enum { MOST = 32 };                  /* what changes more often is at the border of rounding */
    static const double short_of = 1e-6; /* steps: a branch is taken at the end of one */
    double h = 0.0;
    bool first = s->step.count == 0 || (s->restart && now->order == 1), crossed = s->cut;
    IDAGetLastStep(mbsr_ida_memory(s->ida), &h);
    double from = now->t - h, before, behind = now->t;
    int status = first ? mbsri_sensitivity_note_sides(s, from) : MBSR_OK;
    s->rise = first ? MBSRI_NODES : s->cut ? 2 : s->rise + 1;
    first = first || s->cut;
    s->cut = false;
    for (int k = 0; k < MOST && !status; ++k) {
        status = mbsri_sensitivity_cross(s, from, now->t, &before, &behind);
        if (status || !(before < now->t)) break;
        if (s->elastic && s->frame[0]) return refuse_frame(s, before);
        s->cut = now->t - behind <= short_of * h;
        if (s->cut) break;
        if (before - from > short_of * h) {
            status = keep_parts(s, from, before, crossed);
            if (!status)
                status = keep_node(s, before, lower_order(now->order, s->rise), first && !crossed,
                                   false);
            if (status) break;
        }
        status = mbsri_sensitivity_note_sides(s, behind);
        first = crossed = true;
        s->rise = 2;
        from = behind;
    }
    s->restart = false;
    if (!status && (s->cut || behind < now->t)) status = mbsri_sensitivity_note_sides(s, now->t);
    if (!status) status = keep_parts(s, from, now->t, crossed);
    return status
               ? status
               : keep_node(s, now->t, lower_order(now->order, s->rise), first && !crossed, false);
}

static double last_kept(const mbsr_sensitivity *s)
{
    return mbsri_sensitivity_time(s, (long)s->step.count);
}

static int follow_steps(void *user, const mbsr_ida_progress *now)
{
    mbsr_sensitivity *s = user;
    const int status = now->t > last_kept(s) ? keep_step(s, now) : MBSR_OK;
    return status || !s->opt.ida.progress ? status
                                          : s->opt.ida.progress(s->opt.ida.progress_user, now);
}

/* The last step of a call, which the driver does not report. */
static int keep_last(mbsr_sensitivity *s)
{
    mbsr_ida_progress now = {0};
    void *memory = mbsr_ida_memory(s->ida);
    IDAGetCurrentTime(memory, &now.t);
    IDAGetLastOrder(memory, &now.order);
    if (!(now.t > last_kept(s))) return MBSR_OK;
    const int status = keep_step(s, &now);
    if (!status || s->error.status) return status;
    return mbsri_sensitivity_fail(s, status, mbsr_ida_error(s->ida), "mbsr_sensitivity_run");
}

/* Errors of what is solved along the steps are not tested: some ten times those of the run, whose
 * tolerances are less by that. */
static const double stricter = 0.1;

/* The tolerances of each number are read when the driver is made. */
static int tighten(const mbsr_sensitivity *s, mbsr_ida_opt *opt, double **each, mbsr_error *error)
{
    double *const tolerance[] = {&opt->rtol,        &opt->atol,
                                 &opt->atol_angle,  &opt->atol_angular_velocity,
                                 &opt->atol_length, &opt->atol_velocity};
    for (size_t k = 0; k < sizeof tolerance / sizeof *tolerance; ++k) *tolerance[k] *= stricter;
    if (!opt->atol_each) return MBSR_OK;
    *each = mbsri_sensitivity_take((size_t)s->size);
    if (!*each)
        return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY, "mbsr_sensitivity_create: no memory");
    for (int k = 0; k < s->size; ++k) (*each)[k] = stricter * opt->atol_each[k];
    opt->atol_each = *each;
    return MBSR_OK;
}

int mbsri_sensitivity_driver(mbsr_sensitivity *s, mbsr_error *error)
{
    mbsr_ida_opt opt = s->opt.ida;
    double *each = NULL;
    int status = tighten(s, &opt, &each, error);
    opt.progress = follow_steps;
    opt.progress_user = s;
    opt.progress_steps = 1;
    opt.progress_interval = 0.0;
    if (!status) status = mbsr_ida_create(s->model, s->data, &opt, &s->ida, error);
    mbsri_sensitivity_free(each);
    return status;
}

/* ---- the run ---- */

static int check_run(mbsr_sensitivity *s, double t0, int times, const double *time)
{
    if (!time)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_NULL, "mbsr_sensitivity_run: time is NULL");
    if (times < 1)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_VALUE,
                                "mbsr_sensitivity_run: times is %d, must be positive", times);
    if (!isfinite(t0))
        return mbsri_ida_refuse(&s->error, MBSR_NOT_FINITE,
                                "mbsr_sensitivity_run: t0 is not finite");
    double before = t0;
    for (int k = 0; k < times; before = time[k++]) {
        const bool fits = k == 0 ? time[k] >= t0 : time[k] > before;
        if (!fits || !isfinite(time[k]))
            return mbsri_ida_refuse(&s->error, isfinite(time[k]) ? MBSR_ERR_VALUE : MBSR_NOT_FINITE,
                                    "mbsr_sensitivity_run: time[%d] is %.10g, behind %.10g", k,
                                    time[k], before);
    }
    if (time[times - 1] > t0) return MBSR_OK;
    return mbsri_ida_refuse(&s->error, MBSR_ERR_VALUE,
                            "mbsr_sensitivity_run: the last time is the start");
}

static int start_run(mbsr_sensitivity *s, double t0, const double *q, const double *u)
{
    static const char name[] = "mbsr_sensitivity_run";
    const mbsr_model *m = s->model;
    double *y = s->work, *yp = y + s->size;
    mbsr_consistent_info info;
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu;
    double *found = s->given + nq + nu;
    mbsri_given_nothing(m, s->given);
    memset(s->given + nq, 0, nu * sizeof *u);
    if (q) memcpy(s->given, q, nq * sizeof *q);
    if (u) memcpy(s->given + nq, u, nu * sizeof *u);
    int status = mbsr_dae_pack(m, s->data, MBSR_DAE_MOMENTUM, t0, s->given, s->given + nq, y);
    if (!status)
        status = mbsr_dae_consistent(m, s->data, MBSR_DAE_MOMENTUM, t0, y, yp, NULL, &info);
    if (status) return mbsri_sensitivity_fail(s, status, mbsr_data_error(s->data), name);
    if (s->zero != MBSR_NONE && info.null_directions > 0)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_SPACE,
                                "mbsr_sensitivity_run: %s is zero, and there are %d directions "
                                "without mass, which another value may take away",
                                s->named, info.null_directions);
    memcpy(s->begin, y, 2 * (size_t)s->size * sizeof *y);
    memcpy(found, y, nq * sizeof *y);
    memcpy(found + nq, y + nq + nu, nu * sizeof *y);
    s->elastic = info.elastic != 0;
    s->plain = info.null_directions == 0 && mbsr_model_closures(m) == 0;
    status = mbsr_ida_start(s->ida, t0, y, yp);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_ida_error(s->ida), name) : MBSR_OK;
}

/* From t to an output, with a stop at each kink. */
static int advance_to(mbsr_sensitivity *s, double t, double to)
{
    static const char name[] = "mbsr_sensitivity_run";
    const mbsr_ida_opt *opt = &s->opt.ida;
    double *y = s->work, stop = t;
    do {
        int status = mbsri_ida_next_jump(s->model, opt->kink, opt->kink_user, stop, to, &stop);
        if (status)
            return mbsri_ida_refuse(&s->error, status, "%s: the function of kinks returned %d",
                                    name, status);
        status = mbsr_ida_advance(s->ida, stop, NULL, y, NULL);
        if (status && s->error.status) return status; /* no memory for a step */
        if (status) return mbsri_sensitivity_fail(s, status, mbsr_ida_error(s->ida), name);
        status = keep_last(s);
        if (status) return status;
        if (stop < to) s->restart = true;
    } while (stop < to);
    return MBSR_OK;
}

/* Solvers of the forward and the adjoint equations, anew where the last run had other needs. */
static int make_solvers(mbsr_sensitivity *s)
{
    for (int k = 0; k < 2; ++k) {
        mbsr_newton **newton = k == 0 ? &s->newton : &s->back;
        mbsr_newton_opt opt = s->opt.ida.newton;
        opt.method = opt.method == MBSR_NEWTON_TREE ? MBSR_NEWTON_AUTO : opt.method;
        opt.lean = 0;
        opt.together = 0; /* a step has one solution, without iterations that mend it */
        opt.transposes = k == 1;
        mbsr_newton_destroy(*newton);
        *newton = NULL;
        mbsr_error why;
        const int status = mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, newton, &why);
        if (status) return mbsri_sensitivity_fail(s, status, &why, "mbsr_sensitivity_run");
    }
    return MBSR_OK;
}

int mbsr_sensitivity_run(mbsr_sensitivity *sensitivity, double t0, const double *q, const double *u,
                         int times, const double *time, double *q_at, double *u_at)
{
    mbsr_sensitivity *s = sensitivity;
    if (!s) return MBSR_ERR_NULL;
    s->run.made = s->run.checked = s->run.divided = false;
    int status = check_run(s, t0, times, time);
    if (status) return status;
    s->step.count = s->state.count = s->time.count = 0;
    s->start = t0;
    s->restart = s->cut = false;
    s->error.status = MBSR_OK;
    if (!mbsri_sensitivity_reserve(&s->time, (size_t)times, sizeof *time))
        return no_memory_for_step(s);
    memcpy(s->time.data, time, (size_t)times * sizeof *time);
    s->time.count = (size_t)times;
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu;
    status = start_run(s, t0, q, u);
    for (int k = 0; k < times && !status; ++k) {
        const double *y = s->work;
        status = advance_to(s, k > 0 ? time[k - 1] : t0, time[k]);
        if (status) break;
        if (q_at) memcpy(q_at + (size_t)k * nq, y, nq * sizeof *q);
        if (u_at) memcpy(u_at + (size_t)k * nu, y + nq + nu, nu * sizeof *u);
    }
    if (!status) status = make_solvers(s);
    s->run.made = status == MBSR_OK;
    return status;
}
