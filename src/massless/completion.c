/* Completing a state: see completion.h of the public headers.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * K(c) = dF/dy + c dF/dy' of the momentum form, r = (r_q, r_p, r_u, r_Lambda, r_Eta). As c grows, x
 * = K(c)^-1 r has for r_q = r_p = 0
 *
 *   x_q, x_p -> 0 in trees; with loops what closes them in the weights w, and impulses C^T I
 *   x_u -> the correction of velocities,     c x_Lambda -> that of loop forces, and c I
 *
 * so that Newton's method with r = (0, 0, F_u, F_Lambda, F_Eta) settles u at given q and p. The
 * rates follow from F = 0 differentiated, K(c) y' = c dF/dy' y' - dF/dt in the rows of algebraic
 * equations. In the others r = c q' and c p', with what is known of them, gives x_q and x_p that
 * miss q' and p' by a share of 1/c, and the next solution aims so much further. What x_Lambda finds
 * is missing in the loop forces, which p' was found with.
 *
 * Rates of trees all of whose directions move mass are those of forward dynamics. */
#include "massless/completion_elastic.h"
#include "massless/completion_matrix.h"
#include "massless/completion_rates.h"
#include "massless/completion_velocities.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "forms/loops.h"
#include "model/query.h"
#include "newton/front/front.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/spans.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <float.h>
#include <math.h>

/* c in the time in which the state changes much, one after the other until one serves: beyond all
 * that is stiff, but not so far that springs which alone hold something are drowned. */
static const double ladder[] = {1e6, 1e9, 1e4, 1e12};
enum { RUNGS = sizeof ladder / sizeof ladder[0] };

/* ---- creation ---- */

/* Memory for all vectors in one block, and the dense matrices where there is no Newton solver. */
static bool allocate_vectors(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const size_t size = (size_t)w->size, nq = (size_t)m->nq, nu = (size_t)m->nu,
                 rows = (size_t)m->rows, gaps = (size_t)m->position_rows,
                 dense = w->solver.matrix[MBSRI_NEAR].newton ? 0 : size,
                 far = w->solver.pair ? dense : 0;
    const struct {
        double **at;
        size_t count;
    } vector[] = {
        {&w->y, size},
        {&w->yp, size},
        {&w->F, size},
        {&w->r, size},
        {&w->x, size},
        {&w->other, size},
        {&w->rate, size},
        {&w->time, size},
        {&w->given, size + rows},
        {&w->ahead.y, size},
        {&w->ahead.yp, size},
        {&w->further, size},
        {&w->force_rate, rows},
        {&w->ahead.errors, 2 * (rows + gaps)},
        {&w->span.per, nu},
        {&w->span.loop, rows},
        {&w->form.q, nq},
        {&w->form.u, nu},
        {&w->tau, nu},
        {&w->solver.matrix[MBSRI_NEAR].inverse, dense * size},
        {&w->solver.matrix[MBSRI_FAR].inverse, far * size},
        {&w->solver.work, 4 * dense},
    };
    enum { VECTORS = sizeof vector / sizeof vector[0] };
    size_t total = 1;
    for (int k = 0; k < VECTORS; ++k) total += vector[k].count;
    const size_t bytes = total * sizeof(double) + dense * sizeof(int) + nu * sizeof(bool);
    w->memory = mbsri_allocate(&m->allocator, bytes);
    if (!w->memory) return false;
    w->info.bytes += bytes;
    double *next = w->memory;
    mbsri_zero(total, next);
    for (int k = 0; k < VECTORS; ++k) {
        *vector[k].at = next;
        next += vector[k].count;
    }
    w->solver.pivots = (int *)(void *)next;
    w->lacks = (bool *)(void *)(w->solver.pivots + dense);
    return true;
}

/* What motions are measured by. */
static void find_spans(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    const mbsri_spans s = mbsri_spans_of(m, NULL);
    w->span.least = mbsri_span_rate(&s);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k)
            w->span.per[b->u + k] = 1.0 / mbsri_coordinate_span(&s, m, b, true, k);
    }
}

/* Beyond this rank of elements across the tree (newton.h) a dense matrix is no worse. */
enum { LARGEST_RANK = 600 };

/* A Newton solver, exact; none where there is no such. */
static int make_newton(mbsr_completion *w, const mbsr_newton_opt *opt, mbsr_newton **newton,
                       mbsr_error *error)
{
    mbsr_newton_opt own = opt ? *opt : mbsr_default_newton_opt();
    mbsr_newton_info info = {.exact = 0};
    mbsr_error refusal;
    own.method = MBSR_NEWTON_AUTO;
    own.max_rank = LARGEST_RANK;
    own.products = 0;
    const int status = mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, &own, newton, &refusal);
    if (status == MBSR_ERR_SPACE || status == MBSR_ERR_LEAN) return MBSR_OK;
    if (status && error) *error = refusal;
    if (status) return status;
    mbsr_newton_get_info(*newton, &info);
    w->info.bytes += info.bytes;
    if (info.exact) return MBSR_OK;
    mbsr_newton_destroy(*newton);
    *newton = NULL;
    return MBSR_OK;
}

/* Both; one where all bodies have mass. */
static int make_matrices(mbsr_completion *w, const mbsr_newton_opt *opt, mbsr_error *error)
{
    for (int i = 1; i <= w->m->bodies; ++i)
        w->solver.pair = w->solver.pair || !w->m->body[i].mass.regular;
    int status = make_newton(w, opt, &w->solver.matrix[MBSRI_NEAR].newton, error);
    if (!status && w->solver.pair && w->solver.matrix[MBSRI_NEAR].newton)
        status = make_newton(w, opt, &w->solver.matrix[MBSRI_FAR].newton, error);
    return status;
}

int mbsr_completion_create(const mbsr_model *model, const mbsr_newton_opt *opt,
                           mbsr_completion **completion, mbsr_error *error)
{
    static const char name[] = "mbsr_completion_create";
    if (completion) *completion = NULL;
    if (!model || !completion) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          model ? "completion" : "model");
    }
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    }
    mbsr_completion *w = mbsri_allocate(&model->allocator, sizeof *w);
    if (!w) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "%s: no memory", name);
    }
    const int rates = model->nq + model->nu, loops = rates + model->nu;
    *w = (mbsr_completion){.m = model,
                           .error = {MBSR_OK, MBSR_NONE, MBSR_NONE, ""},
                           .times = {0.0, -INFINITY, INFINITY, 0},
                           .info.bytes = sizeof *w,
                           .size = loops + model->rows + model->position_rows,
                           .rates = rates,
                           .loops = loops,
                           .places = loops + model->rows};
    int status = make_matrices(w, opt, error);
    if (!status && !allocate_vectors(w)) {
        status = mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                            "%s: no memory for %d numbers", name, w->size);
    }
    if (status) {
        mbsr_completion_destroy(w);
        return status;
    }
    find_spans(w);
    *completion = w;
    return MBSR_OK;
}

void mbsr_completion_destroy(mbsr_completion *completion)
{
    if (!completion) return;
    const mbsr_allocator allocator = completion->m->allocator;
    for (int j = 0; j < MBSRI_MATRICES; ++j)
        mbsr_newton_destroy(completion->solver.matrix[j].newton);
    mbsri_release(&allocator, completion->memory);
    mbsri_release(&allocator, completion);
}

/* ---- questions ---- */

int mbsr_completion_set_times(mbsr_completion *completion, const mbsr_completion_times *times)
{
    mbsr_completion *w = completion;
    if (!w || !times) return MBSR_ERR_NULL;
    if (times->scale >= 0.0 && isfinite(times->scale) && times->from < times->to) {
        w->times = *times;
        return MBSR_OK;
    }
    return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "mbsr_completion_set_times: scale is %g, from %g to %g", times->scale,
                      times->from, times->to);
}

int mbsr_completion_get_info(const mbsr_completion *completion, mbsr_completion_info *info)
{
    if (!completion || !info) return MBSR_ERR_NULL;
    *info = completion->info;
    info->damped = completion->kind.deficient && !completion->kind.elastic;
    return MBSR_OK;
}

const mbsr_error *mbsr_completion_error(const mbsr_completion *completion)
{
    static const mbsr_error null = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "completion is NULL"};
    return completion ? &completion->error : &null;
}

/* ---- states ---- */

static int here(mbsr_completion *w)
{
    return mbsri_completion_residual(w, w->t, w->y, w->yp);
}

/* w->y, w->yp as they were given, with the residual there. */
static int return_to_given(mbsr_completion *w)
{
    const size_t size = (size_t)w->size, rows = (size_t)w->m->rows;
    mbsri_copy(size, w->given, w->y);
    mbsri_zero(size, w->yp);
    mbsri_copy(rows, w->given + size, w->yp + w->loops);
    return here(w);
}

/* Whether the rounding of accelerations is as large as all that is typical of the model. */
static bool is_out_of_reach(const mbsr_completion *w)
{
    const double speed = fmax(w->span.least, mbsri_completion_speed(w, w->y + w->rates)),
                 change = mbsri_completion_speed(w, w->rate + w->rates);
    return change * mbsri_completion_time(w) * DBL_EPSILON > speed;
}

/* u and all rates from w->y, whose residual is known, and loop forces in w->yp. Rates alone are
 * what dynamics asks for, exactly. */
static int attempt(mbsr_completion *w, bool velocities)
{
    int status = velocities ? mbsri_completion_velocities(w) : MBSR_OK;
    if (!status) status = mbsri_completion_rates(w, !velocities);
    if (status || !is_out_of_reach(w)) return status;
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "accelerations were not found: those that balance are beyond all "
                                 "that is typical of the model");
}

/* Whether the last state was of the same kind, so that its matrices may serve, and what it knew of
 * springs. */
static bool continues(const mbsr_completion *w, double c, bool deficient)
{
    static const double far = 10.0;
    return w->times.follow && w->last.follows && w->kind.deficient == deficient &&
           c <= far * w->solver.c && w->solver.c <= far * c;
}

/* Names the joint whose rates go farthest in w->x. */
static int refuse_farthest(mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    char label[MBSRI_LABEL];
    int farthest = 0;
    double most = -1.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = b->u; k < b->u + b->n; ++k) {
            const double speed = fabs(w->x[w->rates + k]) * w->span.per[k];
            if (speed > most) most = speed, farthest = i;
        }
    }
    const mbsri_body *b = m->body + farthest;
    return mbsri_fail(
        &w->error, MBSR_SINGULAR_BLOCK, b->id, MBSR_NONE,
        "%s: joint '%s': no more than rounding holds its motion at t = %g; " MBSRI_SINGULAR_ADVICE,
        mbsri_body_label(m, farthest, label), b->joint.table->name, w->t);
}

/* Whether springs alone hold some direction; MBSR_SINGULAR_BLOCK where rounding alone does. */
static int ask_what_holds(mbsr_completion *w)
{
    const int status = mbsri_completion_find_elastic(w);
    if (status || !mbsri_completion_gives_way(w)) return status;
    return refuse_farthest(w);
}

/* With what is known from the last state; then with one c after the other. The failure that counts
 * is the first of these, but for singular matrices: far out they are so because something soft is
 * drowned. From w->given, with loop forces behind it. */
static int search(mbsr_completion *w, bool velocities)
{
    mbsr_error first = {.status = MBSR_OK};
    int status = return_to_given(w);
    if (status) return status;
    const double time = mbsri_completion_time(w);
    const bool deficient = mbsr_total_rank(w->m, w->d) < w->m->nu;
    if (continues(w, ladder[0] / time, deficient)) {
        status = attempt(w, velocities);
        if (status <= 0) return status;
        status = return_to_given(w);
    }
    w->kind.deficient = deficient;
    for (int step = 0; step < RUNGS; ++step) {
        w->solver.c = ladder[step] / time;
        w->kind.elastic = false;
        mbsri_completion_forget(w);
        if (step > 0) status = return_to_given(w);
        if (!status && w->kind.deficient) status = ask_what_holds(w);
        if (!status) status = attempt(w, velocities);
        if (status <= 0) return status;
        if (first.status == MBSR_OK || first.status == MBSR_SINGULAR_BLOCK) first = w->error;
        first.status = first.status == MBSR_OK ? status : first.status;
    }
    w->error = first;
    return first.status;
}

/* ---- the calls ---- */

static int take_data_error(mbsr_completion *w, int status)
{
    w->error = *mbsr_data_error(w->d);
    return status;
}

/* What all calls begin with. */
static int enter(mbsr_completion *w, mbsr_data *d, double t, bool arguments, const char *function)
{
    if (!w) return MBSR_ERR_NULL;
    w->last.follows = w->last.found;
    w->last.found = false;
    if (!d || !arguments) {
        return mbsri_fail(&w->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    }
    w->d = d;
    w->t = t;
    int status = mbsri_enter(w->m, d, true, MBSRI_STAGE_NONE, function);
    if (!status) status = mbsri_check_input(d, 1, &t, function, "t");
    mbsri_zero((size_t)w->m->nu, w->tau);
    return status ? take_data_error(w, status) : MBSR_OK;
}

/* The data is at the accelerations found; the stages run when somebody asks. */
static void leave(const mbsr_completion *w, mbsr_data *d)
{
    const mbsr_model *m = w->m;
    if (d->lean) return;
    d->stage = MBSRI_STAGE_NONE;
    d->t = w->t;
    d->accelerated = false;
    mbsri_remember(m, d, MBSRI_PENDING_MOTION, w->y, w->y + w->rates, w->tau);
    mbsri_copy((size_t)m->nu, w->rate + w->rates, d->udot_last);
    if (m->rows > 0) mbsri_loops_take(m, d, w->y + w->loops, w->yp + w->loops);
}

/* A failure of the Newton systems in the words of the caller. */
static int conclude(mbsr_completion *w, int status)
{
    ++w->info.states;
    w->last.found = status == MBSR_OK;
    if (w->last.found) leave(w, w->d);
    if (status != MBSR_SINGULAR_BLOCK) return status;
    w->error.status = MBSR_UNDETERMINED;
    return MBSR_UNDETERMINED;
}

int mbsr_completion_motion(const mbsr_completion *completion, mbsr_data *data, double *q, double *u,
                           double *udot, double *lambda)
{
    const mbsr_completion *w = completion;
    if (!w || !data) return MBSR_ERR_NULL;
    if (data->model != w->m) return MBSR_ERR_MISMATCH;
    if (!w->last.found)
        return mbsri_fail(
            &data->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
            "mbsr_completion_motion: no state has been completed, or the last one failed");
    const size_t nq = (size_t)w->m->nq, nu = (size_t)w->m->nu;
    leave(w, data);
    if (q) mbsri_copy(nq, w->y, q);
    if (u) mbsri_copy(nu, w->y + w->rates, u);
    if (udot) mbsri_copy(nu, w->rate + w->rates, udot);
    return lambda && w->m->rows > 0 ? mbsr_closures_lambda(w->m, data, lambda) : MBSR_OK;
}

/* The state of another form. */
static int complete_form(mbsr_completion *w, const mbsri_dae_form *form, double *y, double *yp)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    int status = mbsri_unpack(form, m, d, w->t, y, w->form.q, w->form.u);
    if (!status)
        status = mbsri_pack(&mbsri_form_momentum, m, d, w->t, w->form.q, w->form.u, w->given);
    if (status) return take_data_error(w, status);
    status = search(w, true);
    if (status) return status;
    status = mbsri_pack_motion(form, m, d, w->t, w->y, w->y + w->rates, w->rate + w->rates,
                               w->ahead.y, w->ahead.yp);
    if (status) return take_data_error(w, status);
    mbsri_copy((size_t)form->size(m), w->ahead.y, y);
    mbsri_copy((size_t)form->size(m), w->ahead.yp, yp);
    return MBSR_OK;
}

static int complete_momentum(mbsr_completion *w, double *y, double *yp)
{
    const size_t size = (size_t)w->size, rows = (size_t)w->m->rows;
    mbsri_copy(size, y, w->given);
    mbsri_copy(rows, yp + w->loops, w->given + size);
    int status = mbsri_check_input(w->d, size + rows, w->given, "mbsr_completion_solve", "y");
    if (!status) status = mbsri_normalise(w->m, w->d, w->given);
    if (status) return take_data_error(w, status);
    status = search(w, true);
    if (status) return status;
    mbsri_copy((size_t)w->loops, w->rate, w->ahead.yp);
    mbsri_copy(size - (size_t)w->loops, w->yp + w->loops, w->ahead.yp + w->loops);
    status = mbsri_check_result(w->m, w->d, size, w->ahead.yp, "mbsr_completion_solve");
    if (status) return take_data_error(w, status);
    mbsri_copy(size, w->y, y);
    mbsri_copy(size, w->ahead.yp, yp);
    return MBSR_OK;
}

int mbsr_completion_solve(mbsr_completion *completion, mbsr_data *data, mbsr_dae_form form,
                          double t, double *y, double *yp)
{
    static const char name[] = "mbsr_completion_solve";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, y && yp, name);
    if (status) return status;
    const mbsri_dae_form *found = mbsri_find_form(form);
    if (!found) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: form is %d, no such form", name, (int)form);
    }
    if (w->m->rows > 0 && form != MBSR_DAE_MOMENTUM) {
        return mbsri_fail(&w->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "%s: the model has closures, which only the momentum form takes", name);
    }
    status =
        form == MBSR_DAE_MOMENTUM ? complete_momentum(w, y, yp) : complete_form(w, found, y, yp);
    return conclude(w, status);
}

/* Rates of a closed model at w->given. Where forward dynamics does not serve, forces on bodies
 * without mass make loop forces: those of a state beside this one, with velocities that balance.
 * They are told once more from those found, as a share of 1/c of what is not known of them moves
 * the state. Rounding in them would be accelerations of what loops hardly hold: they balance to the
 * last digit, but where the velocities given do not let them. */
static int find_dynamics(mbsr_completion *w)
{
    enum { PASSES = 2 };
    int status = return_to_given(w);
    w->kind.deficient = mbsr_total_rank(w->m, w->d) < w->m->nu;
    w->solver.c = ladder[0] / mbsri_completion_time(w);
    if (!status) status = mbsri_completion_forward(w);
    if (status != MBSR_UNDETERMINED) return status;
    for (int pass = 0; pass < PASSES; ++pass) {
        status = search(w, true);
        if (status) return status;
        mbsri_copy((size_t)w->m->rows, w->yp + w->loops, w->given + w->size);
    }
    status = return_to_given(w);
    if (!status) status = mbsri_completion_rates(w, true);
    if (status <= 0) return status;
    status = return_to_given(w);
    return status ? status : mbsri_completion_rates(w, false);
}

int mbsr_completion_dynamics(mbsr_completion *completion, mbsr_data *data, double t,
                             const double *q, const double *u, const double *tau, double *udot,
                             double *lambda)
{
    static const char name[] = "mbsr_completion_dynamics";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, q && u && udot, name);
    if (status) return status;
    const mbsr_model *m = w->m;
    if (tau) status = mbsri_check_input(data, (size_t)m->nu, tau, name, "tau");
    if (tau && !status) mbsri_copy((size_t)m->nu, tau, w->tau);
    if (!status) status = mbsri_pack(&mbsri_form_momentum, m, data, t, q, u, w->given);
    mbsri_zero((size_t)m->rows, w->given + w->size);
    if (status) return take_data_error(w, status);
    status = m->rows > 0 ? find_dynamics(w) : search(w, false);
    if (!status) mbsri_copy((size_t)m->nu, w->rate + w->rates, udot);
    status = conclude(w, status);
    if (!status && lambda) mbsri_copy((size_t)m->rows, data->loop_lambda, lambda);
    return status;
}

/* Newton's method for F(t, y, y' + c (y - y_given)) = 0, from w->y, w->yp. Where a one-sided
 * element lets go on the way it goes to and fro between what holds on either side, with half the
 * corrections less and less. */
static int relax(mbsr_completion *w, double c)
{
    enum { MOST = 40, PATIENT = 4 };
    static const double enough = 1e-10, near = 1e-6, less = 0.7;
    double last = INFINITY, length = 1.0;
    w->solver.c = c;
    int status = here(w);
    for (int step = 0; step < MOST && !status; ++step) {
        status = mbsri_completion_factor(w, MBSRI_NEAR);
        if (!status) status = mbsri_completion_solve(w, MBSRI_NEAR, w->F, w->x);
        if (status) return status;
        const double change =
            mbsri_completion_speed(w, w->x + w->rates) /
            (1e-3 / mbsri_completion_time(w) + mbsri_completion_speed(w, w->y + w->rates));
        if (step >= PATIENT && change > less * last)
            length *= 0.5;
        else if (change < 0.3 * last)
            length = fmin(1.0, 2.0 * length);
        for (int k = 0; k < w->size; ++k) {
            w->y[k] -= length * w->x[k];
            w->yp[k] -= length * c * w->x[k];
        }
        status = here(w);
        if (status || change <= enough || (change > 0.5 * last && change <= near)) return status;
        last = change;
    }
    return status ? status
                  : mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                          "Newton's method does not take out the strain");
}

int mbsr_completion_relax(mbsr_completion *completion, mbsr_data *data, double t, double rate,
                          double *y, double *yp)
{
    static const char name[] = "mbsr_completion_relax";
    mbsr_completion *w = completion;
    int status = enter(w, data, t, y && yp, name);
    if (status) return status;
    if (!(isfinite(rate) && rate != 0.0)) {
        return mbsri_fail(&w->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "%s: rate is %g", name,
                          rate);
    }
    const size_t size = (size_t)w->size;
    status = mbsri_check_input(data, size, y, name, "y");
    if (!status) status = mbsri_check_input(data, size, yp, name, "yp");
    if (status) return take_data_error(w, status);
    mbsri_copy(size, y, w->y);
    mbsri_copy(size, yp, w->yp);
    status = relax(w, rate);
    if (!status) {
        mbsri_copy(size, w->y, y);
        mbsri_copy(size, w->yp, yp);
    }
    return status == MBSR_SINGULAR_BLOCK ? MBSR_UNDETERMINED : status;
}
