/* A consistent start by Newton systems.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * K(c) = dF/dy + c dF/dy' of the momentum form. For r = (0, 0, r_u, r_Lambda, r_Eta), block by
 * block,
 *
 *   x_q = A_q + O(1/c)   x_p = A_p + O(1/c)   x_u = a + c b + O(1/c)
 *       c x_Lambda = c I + L + O(1/c)
 *
 * b: velocity of directions that springs alone hold, A_q = G b and what closes loops; a: all other
 * velocities; I: impulses of loops, A_p = C^T I; L: loop forces. Solutions for c and 100 c tell one
 * from the other, and so Newton's method finds
 *
 *   positions    F_u = 0 and g = 0 by A_q and a        start_positions.c, start_descent.c
 *   velocities   F_u = 0, C u + g_t = 0 by a, I, L; dF_u/dt = 0 by b        start_velocities.c
 *   rates        as those of any state        completion_rates.c
 *
 * In place of c = infinity stand values beyond all rates of the model, tried one after the other.
 */
#include "massless/start.h"

#include "massless/completion_elastic.h"
#include "massless/completion_rates.h"
#include "massless/imbalance.h"
#include "massless/start_descent.h"
#include "massless/start_positions.h"
#include "massless/start_return.h"
#include "massless/start_velocities.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"

#include <mbsrank/driver.h>

#include <math.h>

static const char function[] = "mbsr_dae_consistent", position[] = "position";

/* c in the time in which the state changes much, and how many of these look for a balance of
 * springs in vain before rounding alone would lead to one. */
static const double ladder[] = {1e5, 1e7, 1e9, 1e11, 1e3, 1e4, 1e6, 3e4, 1e2};
enum { RUNGS = sizeof ladder / sizeof ladder[0], CAREFUL = 4, ENOUGH = 2 };

/* ---- from a guess to a state ---- */

static int begin_start(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    int status = mbsri_pack(&mbsri_form_momentum, w->m, w->d, w->t, s->given.q, s->given.u, w->y);
    mbsri_zero((size_t)w->size, w->yp);
    mbsri_copy((size_t)w->m->rows, s->given.load, w->yp + w->loops);
    mbsri_zero((size_t)w->size, w->rate);
    mbsri_zero((size_t)w->m->rows, w->force_rate);
    mbsri_zero((size_t)w->m->rows, s->impulse);
    s->displaced = false;
    for (int k = 0; k < w->m->nu && s->from != MBSRI_FROM_GIVEN; ++k) {
        const double speed = s->from == MBSRI_FROM_REST ? 0.0 : w->span.least;
        if (s->lacks[k])
            w->y[w->rates + k] = speed * (1.0 + 0.5 * sin(12.9898 * k)) / w->span.per[k];
    }
    if (!status) return mbsri_completion_residual(w, w->t, w->y, w->yp);
    w->error = w->d->error;
    return status;
}

/* Notes the masses of the state given, at which w->y is. */
static int note_masses(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    int status = mbsri_positions(w->m, w->d, w->t, w->y);
    if (!status) status = mbsri_velocities(w->m, w->d, s->given.u);
    if (!status) mbsri_masses_note(w->m, w->d, w->y, s->given.u, &s->masses);
    if (status) w->error = w->d->error;
    return status;
}

/* Whether velocities are so far beyond what is typical of the model and those given that their
 * squares have a rounding like forces that act: what balances there is rounding. */
static bool runs_away(const mbsri_start *s)
{
    static const double far = 1e8;
    const mbsr_completion *w = s->w;
    const double speed = fmax(w->span.least, mbsri_completion_speed(w, s->given.u));
    return mbsri_completion_speed(w, w->y + w->rates) > far * speed;
}

/* The velocities that dampers fix at the positions given; those given where there are none, or
 * where friction gives way there. */
static int settle_dampers(mbsri_start *s)
{
    int status = mbsri_start_momenta(s);
    if (!status) status = mbsri_start_velocities(s, false);
    if (status < 0 || (!status && !runs_away(s))) return status;
    return begin_start(s);
}

/* Velocities at the positions found. Impulses of loops are told from loop forces, where these are
 * not known yet, but for a share of 1/c^2 of them: with what is known then they are found anew,
 * until that changes no velocity. */
static int find_velocities(mbsri_start *s)
{
    enum { PASSES = 4 };
    static const double enough = 1e-12, near = 1e-9;
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    const size_t nu = (size_t)m->nu;
    const double *u = w->y + w->rates;
    double *before = s->columns, last = 1.0;
    int status = mbsri_start_momenta(s);
    if (status || !(w->kind.deficient || m->rows > 0)) return status;
    status = mbsri_start_velocities(s, true);
    if (m->rows == 0 || !w->kind.deficient) return status;
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        mbsri_copy(nu, u, before);
        mbsri_zero((size_t)m->rows, s->impulse);
        status = mbsri_start_velocities(s, true);
        for (size_t k = 0; k < nu; ++k) before[k] -= u[k];
        const double change =
            mbsri_completion_speed(w, before) / (w->span.least + mbsri_completion_speed(w, u));
        if (mbsri_completion_converged(change, last, enough, near)) break;
        last = change;
    }
    return status;
}

/* Positions and velocities in turn, where the former depend on the latter; `again`: close to both.
 */
static int alternate(mbsri_start *s, bool again)
{
    enum { TURNS = 4 };
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int status = MBSR_OK;
    for (int turn = 0; turn < TURNS && !status; ++turn) {
        const int before = s->info->iterations;
        s->sought = position;
        if (w->kind.elastic) status = mbsri_start_positions(s);
        if (!again && turn == 0 && (m->rows > 0 || runs_away(s)))
            mbsri_copy((size_t)m->nu, s->given.u, w->y + w->rates);
        if (status || (turn > 0 && s->info->iterations == before)) break;
        s->sought = "velocity";
        status = find_velocities(s);
        if (!w->kind.elastic) break;
    }
    return status;
}

/* Whether the state found, or a place in it, is so far away that what balances there is rounding.
 */
static bool is_out_of_reach(mbsri_start *s)
{
    static const double far = 1e8;
    const mbsr_completion *w = s->w;
    for (int k = 0; k < w->m->nq; ++k) w->form.q[k] = w->y[k] - s->given.q[k];
    return runs_away(s) || mbsri_start_extent(s, w->form.q) > far;
}

/* Springs held what nothing else seemed to hold, or not, also at the state found: friction that
 * slips holds little. */
static int stays_as_it_is(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const bool elastic = w->kind.elastic;
    if (is_out_of_reach(s))
        return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE, "a state within reach");
    const int status = w->kind.deficient ? mbsri_completion_find_growth(w) : MBSR_OK;
    if (status || w->kind.elastic == elastic) return status;
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE, "directions on springs alone");
}

/* Into s->found (`second`: its second half), or back from there, what has been found. */
static void keep_state(mbsri_start *s, bool second, bool back)
{
    mbsr_completion *w = s->w;
    const size_t rows = (size_t)w->m->rows, size = (size_t)w->size;
    const struct {
        double *x;
        size_t count;
    } part[] = {{w->y, size}, {s->impulse, rows}, {w->yp + w->loops, rows}, {w->force_rate, rows}};
    double *kept = s->found + (second ? size + 3 * rows : 0);
    for (size_t k = 0; k < sizeof part / sizeof part[0]; kept += part[k++].count)
        mbsri_copy(part[k].count, back ? kept : part[k].x, back ? part[k].x : kept);
}

/* From the balance found to the one that differs from the state given along directions on springs
 * alone. Where no way leads there, the first one found is kept. */
static int return_rest(mbsri_start *s)
{
    enum { WAYS = 20 };
    static const double enough = 1e-12, near = 1e-8;
    mbsr_completion *w = s->w;
    double way = INFINITY, last = INFINITY;
    bool there = false;
    int status = MBSR_OK, number = 0;
    for (int k = 0; k < WAYS && !there && !status; ++k, last = way) {
        keep_state(s, false, false);
        status = mbsri_start_return(s, number, &way);
        there = mbsri_completion_converged(way, last, enough, near);
        number = way > last ? 0 : number + 1;
        if (!status && way >= 4.0 * last) status = MBSR_NO_CONVERGENCE;
        if (!status && way > enough) status = alternate(s, true);
    }
    if (status < 0 || (there && !status)) return status;
    if (!(s->c.balanced > 0.0)) {
        keep_state(s, false, true);
        mbsri_completion_forget(w);
        status = stays_as_it_is(s);
        if (status) return status;
        keep_state(s, true, false);
        s->c.balanced = w->solver.c;
    }
    return MBSR_NO_CONVERGENCE;
}

static int accelerate(mbsri_start *s)
{
    const int status = mbsri_start_evaluate(s, true);
    if (status) return status;
    s->sought = "acceleration";
    return mbsri_completion_rates(s->w, true);
}

/* The state in balance, and its accelerations: on springs alone where Newton's method leads, or
 * from where these come to rest. */
static int balance(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    int status = w->kind.elastic && w->m->position_rows == 0 ? settle_dampers(s) : MBSR_OK;
    if (!status) status = alternate(s, false);
    if (status == MBSR_NO_CONVERGENCE && w->kind.elastic && s->sought == position) {
        status = begin_start(s);
        if (!status) status = mbsri_start_descend(s);
        if (!status) status = alternate(s, false);
    }
    if (!status && w->kind.elastic && s->displaced) status = return_rest(s);
    return status ? status : accelerate(s);
}

/* Whether forces take a push, whose solution is w->x, as the matrices say, by their difference
 * over a way so short. */
static int compare_push(mbsri_start *s, const double *push, double step, bool *clear)
{
    static const double off = 1e-3;
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    double *before = s->missing, error = 0.0, largest = 0.0;
    int status = MBSR_OK;
    mbsri_copy((size_t)w->size, w->y, w->ahead.y);
    mbsri_copy((size_t)w->size, w->yp, w->ahead.yp);
    for (int side = -1; side <= 1 && !status; side += 2) {
        for (int k = 0; k < w->loops; ++k) w->ahead.y[k] = w->y[k] + side * step * w->x[k];
        for (int k = w->loops; k < w->places; ++k)
            w->ahead.yp[k] = w->yp[k] + side * step * w->other[k];
        status = mbsri_completion_residual(w, w->t, w->ahead.y, w->ahead.yp);
        if (side < 0) mbsri_copy((size_t)m->nu, w->F + w->rates, before);
    }
    for (int k = 0; k < m->nu; ++k) {
        const double taken = (w->F[w->rates + k] - before[k]) / (2.0 * step);
        largest = fmax(largest, fabs(push[k]) / w->span.per[k]);
        if (w->lacks[k]) error = fmax(error, fabs(push[k] - taken) / w->span.per[k]);
    }
    *clear = !status && error <= off * largest;
    return status < 0 ? status : MBSR_OK;
}

/* The longest of ways, of rates in the time in which the state changes much and of positions, that
 * the solution in w->x goes. */
static double longest_way(const mbsri_start *s)
{
    const mbsr_completion *w = s->w;
    return fmax(mbsri_completion_speed(w, w->x + w->rates) * s->time, mbsri_start_extent(s, w->x));
}

/* Whether matrices a short way beside the state found, along the solution for a push in w->x,
 * determine what they do there: not where a stop or a cable lets go. Status. */
static int check_sides(mbsri_start *s, const double *push, bool *holds)
{
    static const double way = 1e-6, much = 1e6;
    mbsr_completion *w = s->w;
    const size_t size = (size_t)w->size, rows = (size_t)w->m->rows;
    const double longest = longest_way(s), step = way / longest;
    int status = MBSR_OK;
    mbsri_copy(size, w->y, s->before);
    mbsri_copy(size, w->x, s->step);
    mbsri_copy(rows, w->yp + w->loops, s->load_before);
    mbsri_copy(rows, w->other + w->loops, s->load_step);
    for (int side = -1; side <= 1 && *holds && status >= 0; side += 2) {
        for (int k = 0; k < w->loops; ++k) w->y[k] = s->before[k] + side * step * s->step[k];
        for (size_t k = 0; k < rows; ++k)
            w->yp[(size_t)w->loops + k] = s->load_before[k] + side * step * s->load_step[k];
        status = mbsri_completion_residual(w, w->t, w->y, w->yp);
        if (!status) status = mbsri_start_factor(s);
        mbsri_zero(size, w->r);
        mbsri_copy((size_t)w->m->nu, push, w->r + w->rates);
        if (!status) status = mbsri_start_solve(s, NULL);
        *holds = !status && longest_way(s) <= much * longest;
    }
    mbsri_copy(size, s->before, w->y);
    mbsri_copy(rows, s->load_before, w->yp + w->loops);
    mbsri_completion_forget(w);
    return status < 0 ? status : MBSR_OK;
}

/* Whether the state found is another one than that given. */
static bool has_moved(const mbsri_start *s)
{
    static const double little = 1e-6;
    const mbsr_completion *w = s->w;
    const double *u = w->y + w->rates;
    for (int k = 0; k < w->m->nu; ++k) w->form.u[k] = u[k] - s->given.u[k];
    return s->displaced || mbsri_completion_speed(w, w->form.u) > little * w->span.least;
}

/* Whether rows that are but traces of rounding along a direction hold a push, whose solution is
 * w->x: by loop forces that are far larger. */
static bool held_by_traces(const mbsri_start *s, const double *push)
{
    static const double far = 1e8;
    const mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    double most = 0.0, largest = 0.0;
    if (m->rows == 0) return false;
    mbsri_closure_transpose(m, w->d, w->other + w->loops, w->form.u);
    for (int k = 0; k < m->nu; ++k) {
        most = fmax(most, fabs(w->form.u[k]) / w->span.per[k]);
        largest = fmax(largest, fabs(push[k]) / w->span.per[k]);
    }
    return most > far * largest;
}

/* Whether forces take a push along directions without mass as the matrices say. Where nothing but
 * rounding determines a direction they do not, over ways of any length. */
static int check_clear(mbsri_start *s, bool *clear)
{
    static const double way[] = {1e-4, 1e-5, 1e-6};
    mbsr_completion *w = s->w;
    double *push = s->target;
    mbsri_completion_push(w, push);
    mbsri_zero((size_t)w->size, w->r);
    mbsri_copy((size_t)w->m->nu, push, w->r + w->rates);
    int status = mbsri_start_solve(s, NULL);
    if (status) return status;
    const double longest = longest_way(s);
    bool holds = true;
    *clear = isfinite(1.0 / longest) && !held_by_traces(s, push) &&
             !mbsri_completion_goes_far(s->w, longest);
    if (!*clear) return MBSR_OK;
    *clear = false;
    for (size_t k = 0; k < sizeof way / sizeof way[0] && !status && !*clear; ++k)
        status = compare_push(s, push, way[k] / longest, clear);
    if (!status && !*clear && has_moved(s)) status = check_sides(s, push, &holds);
    if (status || holds) return status;
    return mbsri_fail(&w->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "%s: forces that determine directions without mass let go at the state that "
                      "balances them, as those of a stop do: what moves beyond is not determined",
                      function);
}

/* Whether ranks at the state found are those of the states around it: *clear. */
static int compare_ranks(mbsri_start *s, bool *clear)
{
    static const double short_way = 1e-4;
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    int rank[2] = {0, 0}, status = MBSR_OK;
    mbsri_copy((size_t)m->nq, w->y, w->form.q);
    mbsri_zero((size_t)m->nu, w->form.u);
    for (int beside = 0; beside < 2 && !status; ++beside) {
        for (int k = 0; k < m->nq && beside; ++k)
            w->form.q[k] += short_way * (1.0 + 0.5 * sin(12.9898 * k)) / s->per_place[k];
        status = mbsri_normalise(m, w->d, w->form.q);
        if (!status) status = mbsri_positions(m, w->d, w->t, w->form.q);
        if (!status) status = mbsri_velocities(m, w->d, w->form.u);
        if (!status) status = mbsri_forces(m, w->d, NULL, NULL);
        if (!status) status = mbsri_backward(m, w->d);
        rank[beside] = w->d->total_rank;
    }
    *clear = !status && rank[0] == rank[1];
    return status < 0 ? status : MBSR_OK;
}

/* No balance found, of positions or of velocities: names the joint at which the largest force is
 * left. */
static int refuse_imbalance(mbsri_start *s, const char *what)
{
    mbsr_completion *w = s->w;
    char label[MBSRI_LABEL];
    int head = 0;
    double share = 0.0;
    if (!mbsri_enter(w->m, w->d, true, MBSRI_STAGE_BACKWARD, function))
        share = mbsri_largest_defect(w->m, w->d, true, 0.0, &head);
    return mbsri_fail(
        &w->error, MBSR_NO_CONVERGENCE, head > 0 ? w->m->body[head].id : MBSR_NONE, MBSR_NONE,
        "%s: no %s balances the forces along directions without mass: of those on %s "
        "%.3g is left",
        function, what, head > 0 ? mbsri_body_label(w->m, head, label) : "the joints", share);
}

/* What is known of the model at the state given, with F there. */
static int survey(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    s->from = MBSRI_FROM_GIVEN;
    s->sought = "velocity";
    int status = begin_start(s);
    if (status) return status;
    const int rank = mbsr_total_rank(w->m, w->d);
    w->kind.deficient = rank < w->m->nu;
    s->info->null_directions = w->m->nu - rank;
    s->time = mbsri_completion_time(w);
    mbsri_completion_lacking(w, s->lacks);
    return note_masses(s);
}

/* How the matrices were: for all c singular in a joint, for all in rows of closures, for none in a
 * joint. */
typedef struct climbed {
    bool singular, dependent, regular;
} climbed;

/* Whether what springs alone hold gives way, as the search for growth has found. */
static bool springs_give_way(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    const double c = mbsri_completion_c(w, MBSRI_FAR);
    return w->kind.elastic &&
           mbsri_completion_goes_far(w, mbsri_completion_speed(w, w->other + w->rates) / c);
}

/* With one c: rotations and steps of positions no wider than that. */
static int stand_on(mbsri_start *s, double c, double widest)
{
    mbsr_completion *w = s->w;
    w->solver.c = c;
    w->kind.elastic = false;
    s->longest = s->widest = widest;
    mbsri_completion_forget(w);
    int status = begin_start(s);
    if (!status && w->kind.deficient) status = mbsri_completion_find_growth(w);
    if (!status && s->from == MBSRI_FROM_GIVEN && (w->kind.faster || springs_give_way(s)))
        s->doubtful = true;
    if (!status && s->searches >= ENOUGH && w->kind.elastic) return MBSR_NO_CONVERGENCE;
    if (!status) status = balance(s);
    if (!status) status = stays_as_it_is(s);
    s->info->elastic = w->kind.elastic;
    return status;
}

/* With one c after the other, until one serves; at last with the one where rounding ended it. */
static int climb(mbsri_start *s, int rungs, climbed *all)
{
    int status = MBSR_OK;
    s->c.rounded = 0.0;
    s->c.serves = false;
    for (int rung = 0; rung < rungs; ++rung) {
        status = stand_on(s, ladder[rung] / s->time, rung < CAREFUL ? 0.5 : 0.1);
        if (status <= 0) return status;
        s->searches += s->w->kind.elastic && s->sought == position;
        if (s->searches >= ENOUGH) return status;
        all->singular = all->singular && status == MBSR_SINGULAR_BLOCK;
        all->dependent = all->dependent && status == MBSR_LOOP_SINGULAR;
        all->regular = all->regular && status != MBSR_SINGULAR_BLOCK;
    }
    if (s->c.rounded == 0.0) return status;
    s->c.serves = true;
    return stand_on(s, s->c.rounded, s->c.widest);
}

/* The balance that was kept. */
static int take_balance(mbsri_start *s)
{
    mbsr_completion *w = s->w;
    w->solver.c = s->c.balanced;
    w->kind.elastic = true;
    s->info->elastic = 1;
    mbsri_completion_forget(w);
    keep_state(s, true, true);
    const int status = accelerate(s);
    return status ? status : stays_as_it_is(s);
}

/* From the velocities given, then from others; what failed first, for which part of the state, into
 * *first and *sought. */
static int climb_from_all(mbsri_start *s, climbed *all, mbsr_error *first, const char **sought)
{
    int status = MBSR_NO_CONVERGENCE;
    s->c.balanced = 0.0;
    s->doubtful = false;
    s->searches = 0;
    for (int from = MBSRI_FROM_GIVEN;
         from <= MBSRI_FROM_ELSEWHERE && status > 0 && !(s->c.balanced > 0.0); ++from) {
        s->from = (mbsri_start_from)from;
        status = climb(s, from == MBSRI_FROM_GIVEN ? RUNGS : CAREFUL, all);
        if (from > MBSRI_FROM_GIVEN) continue;
        s->doubtful = s->doubtful || !all->regular;
        *first = s->w->error;
        *sought = s->sought;
    }
    return status;
}

/* Whether loop forces act at the state given, which may hold what nothing else does. */
static bool is_loaded(const mbsri_start *s)
{
    bool any = false;
    for (int k = 0; k < s->w->m->rows; ++k) any = any || s->given.load[k] != 0.0;
    return any;
}

int mbsri_start_find(mbsri_start *s, mbsr_data *d, double t, bool *clear)
{
    enum { ASKED = 64 }; /* directions: a report of more costs more than all the rest */
    mbsr_completion *w = s->w;
    climbed all = {true, true, true};
    const char *sought = "velocity";
    mbsr_error first;
    *clear = false;
    w->d = d;
    w->t = t;
    w->times.from = s->opt->side > 0 ? t : -INFINITY;
    w->times.to = s->opt->side < 0 ? t : INFINITY;
    int status = survey(s);
    if (status) return status;
    status = climb_from_all(s, &all, &first, &sought);
    if (status > 0 && s->c.balanced > 0.0) status = take_balance(s);
    if (status <= 0) {
        if (!status && w->kind.deficient) status = check_clear(s, clear);
        if (!status && *clear) status = compare_ranks(s, clear);
        *clear = *clear && all.regular;
        /* of a state that stays as it is *clear tells */
        s->doubtful = s->doubtful || (s->info->elastic && is_loaded(s));
        s->doubtful = s->doubtful && (status || has_moved(s)) && s->info->null_directions <= ASKED;
        return status;
    }
    if (s->searches > 0 || (!all.singular && !all.dependent)) return refuse_imbalance(s, sought);
    w->error = first; /* nothing was sought */
    if (!all.dependent) w->error.status = MBSR_UNDETERMINED;
    return w->error.status;
}
