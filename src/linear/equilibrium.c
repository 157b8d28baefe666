/* Equilibria.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * From rest at q an implicit Euler step of length 1 / c is one Newton system of the momentum form,
 *
 *   K (dq, dp, du, dLambda) = F(t, y, y')      with y = (q, 0, 0, .), y' = (0, 0, 0, lambda),   K =
 * F_y + c F_y'
 *
 * that is (c^2 M + c D + stiffness) dq = forces, loops and directions without mass included. Each
 * is followed by a stop, u = p = 0. For large c it goes down the slope, for c = 0 it is Newton's
 * method: c falls with the forces (pseudo-transient continuation), and rises where a step would be
 * too long or makes matters worse.
 *
 * Forces are measured over the square root of the mass that they move, steps as turns in rad and
 * ways, those by modes too, over the length of the model; a displacement of a millionth of that
 * tells what rate is typical, so that units do not matter. */
#include "files/arena.h"

#include "base/cookie.h"
#include "base/error.h"
#include "linear/spans.h"

#include <mbsrank/linear.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct rest {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_newton *newton;
    double t, length, rate; /* typical of the model: m, 1/s */
    double force;           /* that a displacement of 1 makes, over the root of its mass */
    int nq, nu, rows, size;
    double *y, *yp, *F, *delta, *new_y, *new_yp, *mass, *span, *rate_span;
    double *begun;  /* nq: where the steps began */
    bool *sprung;   /* rows: y has the force itself, of springs of stiff rows; else y' has it */
    int *redundant; /* rows: mbsr_closures_redundant */
    mbsr_equilibrium_info info;
} rest;

static const char name[] = "mbsr_equilibrium";
static const double longest = 0.3, nothing = 1e-8; /* steps */

mbsr_equilibrium_opt mbsr_default_equilibrium_opt(void)
{
    return (mbsr_equilibrium_opt){
        .cookie = MBSRI_COOKIE, .max_iterations = 500, .tolerance = 1e-11};
}

static int fail_data(const rest *w, int status, mbsr_error *error)
{
    const mbsr_error *why = mbsr_data_error(w->d);
    return mbsri_fail(error, status, why->body, why->force, "%s: %s", name, why->text);
}

/* F over the root of the mass that it moves; the rate where it is worst into `worst` (may be NULL).
 */
static double imbalance(const rest *w, const double *F, int *worst)
{
    double sum = 0.0, most = -1.0;
    for (int k = 0; k < w->nu; ++k) {
        const double p = F[w->nq + k], u = F[w->nq + w->nu + k],
                     square = (p * p + u * u) / w->mass[k];
        sum += square;
        if (square > most && worst) *worst = k;
        most = fmax(most, square);
    }
    return sqrt(sum);
}

static int residual(const rest *w, const double *y, const double *yp, double *F)
{
    return mbsr_dae_residual(w->m, w->d, MBSR_DAE_MOMENTUM, w->t, y, yp, F);
}

static void find_units(rest *w)
{
    for (int i = 0; i < mbsr_model_bodies(w->m); ++i) {
        int q, u;
        mbsr_body_coordinates(w->m, i, &q, NULL, &u, NULL);
        mbsri_linear_spans(w->m, i, false, w->length, w->span + q);
        mbsri_linear_spans(w->m, i, true, w->length, w->rate_span + u);
    }
}

/* What accelerations by F are beside spans, 1/s^2. */
static double largest_acceleration(const rest *w, const double *F)
{
    double most = 0.0;
    for (int k = 0; k < w->nu; ++k) {
        const double span = w->rate_span[k] > 0.0 ? w->rate_span[k] : 1.0,
                     force = fmax(fabs(F[w->nq + k]), fabs(F[w->nq + w->nu + k]));
        most = fmax(most, force / (w->mass[k] * span));
    }
    return most;
}

/* Length, masses, and what a small displacement makes of the forces. */
static int find_scales(rest *w)
{
    static const double step = 1e-6;
    int status = residual(w, w->y, w->yp, w->F);
    if (!status) status = mbsr_stage_backward(w->m, w->d);
    if (!status) status = mbsr_momentum_scales(w->m, w->d, w->mass);
    if (status) return status;
    w->length = mbsri_linear_length(w->m, w->d);
    for (int round = 0; round < 2; ++round) {
        uint64_t random = UINT64_C(88172645463325252);
        find_units(w);
        memcpy(w->new_y, w->y, (size_t)w->size * sizeof *w->y);
        for (int k = 0; k < w->nq; ++k) {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            w->new_y[k] += (random >> 63 ? step : -step) * (w->span[k] > 0.0 ? w->span[k] : 1.0);
        }
        status = mbsr_normalise(w->m, w->d, w->new_y);
        if (!status) status = residual(w, w->new_y, w->yp, w->delta);
        if (status) return status;
        for (int k = 0; k < w->size; ++k) w->delta[k] -= w->F[k];
        w->force = imbalance(w, w->delta, NULL) / step;
        w->rate = sqrt(largest_acceleration(w, w->delta) / step);
        if (w->length > 0.0) break;
        /* all origins in one point: what the forces there move at this rate */
        for (int k = 0; k < w->nu && w->rate > 0.0; ++k)
            w->length = fmax(w->length, fabs(w->F[w->nq + k]) / (w->mass[k] * w->rate * w->rate));
        if (!(w->length > 0.0)) w->length = 1.0;
    }
    return MBSR_OK;
}

/* y - delta at rest, and loop forces; the length of the step. */
static double step_to(rest *w, double c)
{
    const int at = w->nq + 2 * w->nu;
    double most = 0.0;
    memcpy(w->new_y, w->y, (size_t)w->size * sizeof *w->y);
    memcpy(w->new_yp, w->yp, (size_t)w->size * sizeof *w->yp);
    for (int k = 0; k < w->nq; ++k) {
        w->new_y[k] -= w->delta[k];
        most = fmax(most, fabs(w->delta[k]) / w->span[k]);
    }
    for (int k = at; k < at + w->rows; ++k) {
        if (w->sprung[k - at])
            w->new_y[k] -= w->delta[k];
        else
            w->new_yp[k] -= c * w->delta[k];
    }
    return most;
}

static void accept(rest *w)
{
    double *y = w->y, *yp = w->yp;
    w->y = w->new_y;
    w->yp = w->new_yp;
    w->new_y = y;
    w->new_yp = yp;
}

static int refuse_solver(const rest *w, int status, mbsr_error *error)
{
    const mbsr_error *why = mbsr_newton_error(w->newton);
    return mbsri_fail(error, status == MBSR_SINGULAR_BLOCK ? MBSR_UNDETERMINED : status, why->body,
                      why->force, "%s: %s", name, why->text);
}

/* A Newton step at c, and the forces where it leads; *length of the step. */
static int try_step(rest *w, double c, double *length, mbsr_error *error)
{
    int status = mbsr_newton_factor(w->newton, w->d, w->t, w->y, w->yp, c);
    ++w->info.factorisations;
    if (!status) status = mbsr_newton_solve(w->newton, w->F, w->delta);
    if (status) return refuse_solver(w, status, error);
    *length = step_to(w, c);
    if (!(*length <= longest)) return MBSR_OK;
    status = mbsr_normalise(w->m, w->d, w->new_y);
    if (!status) status = residual(w, w->new_y, w->new_yp, w->delta);
    return status ? fail_data(w, status, error) : MBSR_OK;
}

/* The joint whose forces are farthest from balance. */
static int refuse_unbalanced(rest *w, mbsr_error *error)
{
    imbalance(w, w->F, &w->info.worst);
    int body = 0, own = 0;
    for (int i = 0; i < mbsr_model_bodies(w->m); ++i) {
        int ui, n;
        mbsr_body_coordinates(w->m, i, NULL, NULL, &ui, &n);
        if (w->info.worst < ui || w->info.worst >= ui + n) continue;
        body = i;
        own = w->info.worst - ui;
    }
    return mbsri_fail(error, MBSR_NO_CONVERGENCE, body, MBSR_NONE,
                      "%s: no equilibrium was found in %d steps: forces along u%d of body %d '%s' "
                      "are farthest from balance (%.3g). Nothing holds it against them, or it has "
                      "far to go: add a spring, a stop or a motor there, or start nearer",
                      name, w->info.iterations, own, body, mbsr_body_name(w->m, body),
                      w->F[w->nq + w->info.worst]);
}

/* The steps. */
static int settle_balance(rest *w, const mbsr_equilibrium_opt *opt, mbsr_error *error)
{
    const double falling =
        largest_acceleration(w, w->F); /* before anything that holds may be near */
    w->rate = fmax(w->rate, sqrt(falling));
    const double least = 1e-5 * w->rate;
    double c = fmax(sqrt(falling / longest), 1e-3 * w->rate), force = imbalance(w, w->F, NULL);
    const double most = 1e4 * fmax(c, w->rate); /* steps along massless directions stay long */
    int idle = 0, falling_steps = 0;
    if (!(c > 0.0)) return MBSR_OK; /* no forces, here and nearby */
    while (w->info.iterations < opt->max_iterations) {
        double length = 0.0;
        const int status = try_step(w, c, &length, error);
        ++w->info.iterations;
        if (status == MBSR_NOT_FINITE || !(length <= longest)) {
            c *= 2.0;
            continue;
        }
        if (status) return status;
        const double left = imbalance(w, w->delta, NULL);
        if (left > 2.0 * force && left > 1e-9 * w->force && length > 1e-6 && c < most) {
            c *= 4.0;
            continue;
        }
        accept(w);
        memcpy(w->F, w->delta, (size_t)w->size * sizeof *w->F);
        w->info.step = length;
        if (length > 1e-6) w->force = fmax(w->force, fabs(left - force) / length);
        /* a large c makes any step short: it is to be short at the model's own rate too */
        const double over = w->rate > 0.0 ? fmax(1.0, c / w->rate) : 1.0;
        if (length * over * over <= opt->tolerance) return MBSR_OK;
        idle = c <= least && left > 0.5 * force && left <= 1e-11 * w->force ? idle + 1 : 0;
        falling_steps = left < force ? falling_steps + 1 : 0;
        /* what is left is rounding, which does not fall each time, along what nothing holds */
        if (idle > 3 && falling_steps < 4) return MBSR_OK;
        c = fmax(least, c * fmin(1.0, fmax(0.05, force > 0.0 ? left / force : 0.05)));
        if (length < 0.1 * longest) c = fmax(least, 0.5 * c);
        force = left;
    }
    return refuse_unbalanced(w, error);
}

static bool take_memory(rest *w, mbsri_arena *arena)
{
    double **const of_size[] = {&w->y, &w->yp, &w->F, &w->delta, &w->new_y, &w->new_yp};
    for (int k = 0; k < 6; ++k)
        *of_size[k] = mbsri_arena_take(arena, ((size_t)w->size + 1) * sizeof(double));
    w->mass = mbsri_arena_take(arena, ((size_t)w->nu + 1) * sizeof(double));
    w->span = mbsri_arena_take(arena, ((size_t)w->nq + 1) * sizeof(double));
    w->rate_span = mbsri_arena_take(arena, ((size_t)w->nu + 1) * sizeof(double));
    w->begun = mbsri_arena_take(arena, ((size_t)w->nq + 1) * sizeof(double));
    w->sprung = mbsri_arena_take(arena, ((size_t)w->rows + 1) * sizeof *w->sprung);
    w->redundant = mbsri_arena_take(arena, ((size_t)w->rows + 1) * sizeof *w->redundant);
    return !arena->failed;
}

/* Which multipliers the equations of motion know themselves: those of stiff rows. */
static void tell_springs(rest *w)
{
    for (int c = 0; c < mbsr_model_closures(w->m); ++c) {
        int row, rows;
        (void)mbsr_closure_indices(w->m, c, &row, &rows, NULL, NULL);
        for (int k = 0; k < rows; ++k)
            w->sprung[row + k] = mbsr_closure_stiffness(w->m, c, k) > 0.0;
    }
}

/* A closed state near q, which is no part of y, at which the rows that count are chosen, at rest.
 */
static int begin_at_rest(rest *w, const double *q, mbsr_error *error)
{
    const int at = w->nq, rates = 2 * w->nu;
    memset(w->delta, 0, (size_t)w->size * sizeof *w->delta);
    int status = mbsr_dae_pack(w->m, w->d, MBSR_DAE_MOMENTUM, w->t, q, w->delta, w->y);
    if (status) return fail_data(w, status, error);
    memcpy(w->new_y, w->y, (size_t)w->size * sizeof *w->y);
    status = mbsr_dae_consistent(w->m, w->d, MBSR_DAE_MOMENTUM, w->t, w->y, w->yp, NULL, NULL);
    const bool no_start = status == MBSR_NO_CONVERGENCE || status == MBSR_RANK_CHANGED;
    if (no_start && w->rows == 0) /* a tree rests without one */
        memcpy(w->y, w->new_y, (size_t)w->size * sizeof *w->y);
    else if (status)
        return fail_data(w, status, error);
    memset(w->y + at, 0, (size_t)rates * sizeof *w->y);
    for (int k = 0; k < w->size; ++k) {
        if (k < at + rates || k >= at + rates + w->rows) w->yp[k] = 0.0;
    }
    status = mbsr_closures_redundant(w->m, w->d, w->redundant);
    return status ? fail_data(w, status, error) : MBSR_OK;
}

/* Springs of stiff rows have their forces in y. */
static void begin_springs(const rest *w)
{
    for (int k = 0; k < w->rows; ++k) {
        if (w->sprung[k]) w->yp[w->nq + 2 * w->nu + k] = 0.0;
    }
}

/* Whether steps are begun anew where they have led. What is redundant where they began is not in
 * the residual: springs follow the steps by the velocity row alone, and are off by the square of
 * their length; rigid rows may come open where they depend on others no more. Next to where rows
 * depend on others loop forces grow until rounding in their rows is a balance. */
static bool starts_matter(const rest *w)
{
    bool matter = false;
    for (int k = 0; k < w->rows; ++k) matter = matter || !w->sprung[k] || w->redundant[k];
    return matter;
}

/* The largest way from q to y. */
static double way_from(const rest *w, const double *q)
{
    double most = 0.0;
    for (int k = 0; k < w->nq; ++k) most = fmax(most, fabs(w->y[k] - q[k]) / w->span[k]);
    return most;
}

/* Into closing (rows): what a step as long as the typical one in all rates, by numbers between a
 * half and one of any sign, closes each row by. */
static int find_closing(rest *w, double *closing)
{
    uint64_t random = UINT64_C(88172645463325252);
    double *step = w->delta;
    for (int j = 0; j < w->nu; ++j) {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        const double size = 0.5 + ldexp((double)(random >> 12 & 0xffffffff), -33);
        step[j] = (random >> 63 ? size : -size) * w->rate_span[j];
    }
    return mbsr_closures_apply(w->m, w->d, step, closing);
}

/* The rigid closure that has come open farthest, of which a row was redundant where the steps
 * began, and is redundant no more; MBSR_NONE. */
static int farthest_open(rest *w)
{
    int open = MBSR_NONE;
    double most = nothing, *gap = w->new_y, *closing = w->new_yp;
    if (w->rows == 0 || mbsr_stage_positions(w->m, w->d, w->t, w->y) ||
        mbsr_closures_gap(w->m, w->d, gap) || find_closing(w, closing))
        return open;
    for (int c = 0; c < mbsr_model_closures(w->m); ++c) {
        int row, place, places;
        (void)mbsr_closure_indices(w->m, c, &row, NULL, &place, &places);
        for (int k = 0; k < places; ++k) {
            if (!w->redundant[row + k] || w->sprung[row + k] || closing[row + k] == 0.0) continue;
            const double way = fabs(gap[place + k] / closing[row + k]);
            if (way > most) open = c;
            most = fmax(most, way);
        }
    }
    return open;
}

static int refuse_open(int closure, const rest *w, mbsr_error *error)
{
    const char *of = mbsr_closure_name(w->m, closure);
    return mbsri_fail(
        error, MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE,
        "%s: closure %d '%s' comes open on the way to an equilibrium, and closes only "
        "where some of its rows depend on others: start farther from there",
        name, closure, of ? of : "");
}

/* The steps, begun anew until they stay. */
static int settle_rows(rest *w, const mbsr_equilibrium_opt *opt, mbsr_error *error)
{
    int status = settle_balance(w, opt, error);
    for (double way = way_from(w, w->begun); !status && way > nothing && starts_matter(w);
         way = way_from(w, w->begun)) {
        memcpy(w->begun, w->y, (size_t)w->nq * sizeof *w->y);
        status = begin_at_rest(w, w->begun, error);
        if (status) break;
        begin_springs(w);
        status = residual(w, w->y, w->yp, w->F);
        if (status) return fail_data(w, status, error);
        status = settle_balance(w, opt, error);
    }
    const int open = status ? MBSR_NONE : farthest_open(w);
    return open < 0 ? status : refuse_open(open, w, error);
}

static int solve_rest(rest *w, const double *q, const mbsr_equilibrium_opt *opt, mbsri_arena *arena,
                      mbsr_error *error)
{
    if (!take_memory(w, arena))
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d numbers", name, w->size);
    mbsr_newton_opt exact = mbsr_default_newton_opt();
    int status = mbsr_newton_create(w->m, MBSR_DAE_MOMENTUM, &exact, &w->newton, error);
    if (status) return status;
    status = begin_at_rest(w, q, error);
    if (status) return status;
    tell_springs(w);
    begin_springs(w);
    memcpy(w->begun, w->y, (size_t)w->nq * sizeof *w->y);
    status = find_scales(w);
    return status ? fail_data(w, status, error) : settle_rows(w, opt, error);
}

int mbsr_equilibrium(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                     const mbsr_equilibrium_opt *opt, double *q_rest, double *lambda,
                     mbsr_equilibrium_info *info, mbsr_error *error)
{
    const mbsr_equilibrium_opt standard = mbsr_default_equilibrium_opt();
    mbsr_model_def def;
    if (!opt) opt = &standard;
    if (!model || !data || !q || !q_rest)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", name,
                          !model  ? "model"
                          : !data ? "data"
                          : !q    ? "q"
                                  : "q_rest");
    if (opt->cookie != MBSRI_COOKIE)
        return mbsri_fail(error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "%s: opt was not made by mbsr_default_equilibrium_opt", name);
    if (opt->max_iterations < 1 || !(opt->tolerance > 0.0))
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: max_iterations is %d, tolerance %g: both must be positive", name,
                          opt->max_iterations, opt->tolerance);
    if (mbsr_model_definition(model, &def))
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", name);
    rest w = {.m = model,
              .d = data,
              .t = t,
              .nq = mbsr_model_nq(model),
              .nu = mbsr_model_nu(model),
              .size = mbsr_dae_size(model, MBSR_DAE_MOMENTUM),
              .rows = mbsr_model_rows(model),
              .info = {.worst = MBSR_NONE}};
    mbsri_arena arena;
    mbsri_arena_open(&arena, &def.allocator);
    int status = solve_rest(&w, q, opt, &arena, error);
    if (!status && lambda && w.rows > 0) {
        /* of the residual there, and no other */
        status = residual(&w, w.y, w.yp, w.F);
        if (!status) status = mbsr_closures_lambda(model, data, lambda);
        if (status) status = fail_data(&w, status, error);
    }
    if (!status) memcpy(q_rest, w.y, (size_t)w.nq * sizeof *q_rest);
    if (info) *info = w.info;
    mbsr_newton_destroy(w.newton);
    mbsri_arena_close(&arena);
    return status;
}
