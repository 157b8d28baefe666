/* Completing a state where springs alone hold some direction without mass (index 2): see
 * completion.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A force gamma in such a direction that depends on positions alone is balanced at all times. Held
 * q, it is off by what an integrator has left of it; what is wanted are the velocities with which
 * it stays there, gamma' = 0, and the accelerations, gamma'' = 0. The solution of K(c) x = (0, 0,
 * gamma') has a part that grows with c,
 *
 *   x_u = a + c b + O(1/c),
 *
 * and b is what u is to be changed by; likewise for gamma'' and u'. gamma' and gamma'' are
 * difference quotients of the fourth order along the motion. */
#include "massless/completion_elastic.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "loops/row_fronts.h"
#include "massless/imbalance.h"
#include "recursion/closures.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"
#include "recursion/rank.h"

#include <float.h>
#include <math.h>

static const double ratio = MBSRI_COMPLETION_RATIO;

/* Steps of quotients, in the time in which the state changes much. */
enum { STEPS = 3 };
static const double share_of_time[STEPS] = {1e-3, 8e-3, 6.4e-2};

void mbsri_completion_part(mbsr_completion *w)
{
    const double c = w->solver.c;
    for (int k = 0; k < w->rates; ++k) w->x[k] = (ratio * w->other[k] - w->x[k]) / (ratio - 1.0);
    for (int k = w->rates; k < w->loops; ++k) {
        const double b = w->kind.elastic ? (w->other[k] - w->x[k]) / ((ratio - 1.0) * c) : 0.0;
        w->x[k] =
            w->kind.elastic ? w->x[k] - c * b : (ratio * w->other[k] - w->x[k]) / (ratio - 1.0);
        w->other[k] = b;
    }
    for (int k = w->loops; k < w->size; ++k) {
        const double I = (ratio * w->other[k] - w->x[k]) / (ratio - 1.0);
        w->other[k] = c * (w->x[k] - I);
        w->x[k] = I;
    }
}

int mbsri_completion_split(mbsr_completion *w, const double *r)
{
    int status = mbsri_completion_solve(w, MBSRI_NEAR, r, w->x);
    if (!status) status = mbsri_completion_solve(w, MBSRI_FAR, r, w->other);
    if (!status) mbsri_completion_part(w);
    return status;
}

/* Whether masses and dampers leave something of a push, whose solution is w->x: F_u,u x_u is all of
 * it where they take it all. Directions without mass may have a small part in the push. F is that
 * at the state, and is again. */
static int ask_springs(mbsr_completion *w, const double *push, bool *some)
{
    static const double left = 1e-3, short_way = 1e-4;
    const double speed = mbsri_completion_speed(w, w->x + w->rates),
                 step = short_way / (speed * mbsri_completion_time(w)), largest = 1.5;
    *some = !isfinite(step);
    if (*some) return MBSR_OK;
    mbsri_copy((size_t)w->size, w->F, w->other);
    mbsri_copy((size_t)w->size, w->y, w->ahead.y);
    mbsri_copy((size_t)w->size, w->yp, w->ahead.yp);
    for (int k = w->rates; k < w->loops; ++k) w->ahead.y[k] += step * w->x[k];
    for (int k = w->loops; k < w->places; ++k) w->ahead.yp[k] += step * w->solver.c * w->x[k];
    const int status = mbsri_completion_residual(w, w->t, w->ahead.y, w->ahead.yp);
    for (int k = 0; k < w->m->nu; ++k) {
        const double taken = (w->F[w->rates + k] - w->other[w->rates + k]) / step;
        *some = *some || fabs(push[k] - taken) > left * largest * w->span.per[k];
    }
    mbsri_copy((size_t)w->size, w->other, w->F);
    return status;
}

/* Whether loop forces take all of a push, whose solution is w->x: motions are rounding then. */
static bool loops_hold(const mbsr_completion *w, const double *push)
{
    static const double little = 1e-9;
    const mbsr_model *m = w->m;
    double *force = w->form.u, left = 0.0, most = 0.0;
    if (m->rows == 0) return false;
    mbsri_closure_transpose(m, w->d, w->x + w->loops, force);
    for (int k = 0; k < m->nu; ++k) {
        left = fmax(left, fabs(push[k] + w->solver.c * force[k]) / w->span.per[k]);
        most = fmax(most, fabs(push[k]) / w->span.per[k]);
    }
    return left <= little * most;
}

/* Of a rate with one c, and with the other, further one. */
static bool grows_with_c(double now, double then)
{
    static const double much = 5.0;
    return then > much * now;
}

/* Whether the motion that a push makes grows with c, or faster: twice the solution is known. */
static int ask_growth(mbsr_completion *w, bool *grows)
{
    static const double faster = 5.0 * MBSRI_COMPLETION_RATIO, rounding = 1e-9;
    *grows = w->kind.faster = false;
    if (loops_hold(w, w->r + w->rates)) return MBSR_OK;
    const int status = mbsri_completion_solve(w, MBSRI_FAR, w->r, w->other);
    if (status) return status;
    const double largest = mbsri_completion_speed(w, w->other + w->rates);
    for (int k = w->rates; k < w->loops; ++k) {
        const double now = fabs(w->x[k]), then = fabs(w->other[k]),
                     speed = then * w->span.per[k - w->rates];
        if (!(grows_with_c(now, then) && speed > rounding * largest)) continue;
        *grows = true;
        w->kind.faster = w->kind.faster || then > faster * now;
    }
    return MBSR_OK;
}

void mbsri_completion_lacking(const mbsr_completion *w, bool *lacks)
{
    const mbsr_model *m = w->m;
    for (int i = 1; i <= m->bodies; ++i) {
        if (m->body[i].group.head != i) continue;
        const mbsri_group g = mbsri_group_in_model(m, i);
        bool some = false;
        for (int k = 0; k < g.members; ++k)
            some = some || w->d->rank[g.member[k]] < m->body[g.member[k]].n;
        for (int k = 0; k < g.members; ++k) {
            const mbsri_body *b = m->body + g.member[k];
            for (int l = 0; l < b->n; ++l) lacks[b->u + l] = some;
        }
    }
}

/* To the joint rates of a group from those of the model, or back. */
static void take_rates(const mbsr_model *m, const mbsri_group *g, bool back, double *all, double *x)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        mbsri_copy((size_t)b->n, back ? x : all + b->u, back ? all + b->u : x);
        x += b->n;
    }
}

/* Takes off what masses would take of forces: as rows of F_u momenta, to which forces are in a
 * proportion that depends on the unit of time. */
static void leave_out_masses(const mbsr_completion *w, double *push)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    if (mbsri_enter(m, d, true, MBSRI_STAGE_BACKWARD, "mbsr_completion_solve")) return;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (mbsri_group_rank(d, &g) == g.n) continue;
        take_rates(m, &g, false, push, d->vec);
        mbsri_null_force(m, d, &g, d->vec, d->vec);
        take_rates(m, &g, true, push, d->vec);
    }
}

void mbsri_completion_push(const mbsr_completion *w, double *push)
{
    mbsri_completion_lacking(w, w->lacks);
    for (int k = 0; k < w->m->nu; ++k)
        push[k] = w->lacks[k] ? (1.0 + 0.5 * sin(12.9898 * k)) * w->span.per[k] : 0.0;
    leave_out_masses(w, push);
}

/* x for a push on all directions without mass, which is left in r. */
static int answer_push(mbsr_completion *w)
{
    w->kind.elastic = false;
    mbsri_zero((size_t)w->size, w->r);
    mbsri_completion_push(w, w->r + w->rates);
    return mbsri_completion_solve(w, MBSRI_NEAR, w->r, w->x);
}

int mbsri_completion_find_elastic(mbsr_completion *w)
{
    bool some = false;
    int status = answer_push(w);
    if (!status) status = ask_springs(w, w->r + w->rates, &some);
    return status || !some ? status : ask_growth(w, &w->kind.elastic);
}

int mbsri_completion_find_growth(mbsr_completion *w)
{
    const int status = answer_push(w);
    return status ? status : ask_growth(w, &w->kind.elastic);
}

bool mbsri_completion_goes_far(mbsr_completion *w, double way)
{
    static const double far = 1e13;
    return !mbsri_enter(w->m, w->d, true, MBSRI_STAGE_BACKWARD, "mbsr_completion_solve") &&
           way * mbsri_work_of_forces(w->m, w->d) > far;
}

bool mbsri_completion_gives_way(mbsr_completion *w)
{
    const double c = mbsri_completion_c(w, MBSRI_NEAR), time = mbsri_completion_time(w);
    double way = 0.0;
    for (int k = w->rates; k < w->loops; ++k) {
        const bool grows = w->kind.elastic && grows_with_c(fabs(w->x[k]), fabs(w->other[k]));
        const double speed = fabs(w->x[k]) * w->span.per[k - w->rates];
        way = fmax(way, grows ? speed / c : speed * time);
    }
    return mbsri_completion_goes_far(w, way);
}

int mbsri_completion_moves(mbsr_completion *w, const double *q, const double *u, double *qdot)
{
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    return status ? status : mbsri_coordinate_rates(w->m, w->d, qdot);
}

/* Whether q' = u in all joints. */
static bool moves_plainly(const mbsr_model *m)
{
    int i = 1;
    while (i <= m->bodies && !m->body[i].joint.table->coordinate_rates) ++i;
    return i > m->bodies;
}

/* The positions w->form.q at s on the path q + s G(u + s u'/2): G at the middle of the way makes
 * the path one of the second order, whatever the coordinates. */
static int go_along(mbsr_completion *w, double s, const double *udot)
{
    const mbsr_model *m = w->m;
    double *q = w->ahead.y, *u = w->ahead.y + w->rates, *qdot = w->ahead.yp;
    int status = MBSR_OK;
    for (int k = 0; k < m->nu; ++k) u[k] = w->y[w->rates + k] + 0.5 * s * udot[k];
    if (moves_plainly(m)) {
        mbsri_copy((size_t)m->nu, u, qdot);
    } else {
        status = mbsri_completion_moves(w, w->y, u, qdot);
        for (int k = 0; k < m->nq; ++k) q[k] = w->y[k] + 0.5 * s * qdot[k];
        if (!status) status = mbsri_completion_moves(w, q, u, qdot);
    }
    for (int k = 0; k < m->nq; ++k) w->form.q[k] = w->y[k] + s * qdot[k];
    return status;
}

/* Whether the equations of each joint are all of momenta or all of forces. */
static bool separates(const mbsr_completion *w)
{
    const mbsr_model *m = w->m;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (b->n > 0 && w->d->rank[i] % b->n != 0) return false;
        if (b->group.head != i && !mbsri_apart(m, w->d, b->group.head)) return false;
    }
    return true;
}

/* The equations of momenta say nothing of forces. */
static void leave_out_momenta(mbsr_completion *w)
{
    for (int i = 1; i <= w->m->bodies; ++i) {
        const mbsri_body *b = w->m->body + i;
        if (w->d->rank[i] > 0) mbsri_zero((size_t)b->n, w->F + w->rates + b->u);
    }
}

/* C u + g_t and g of all rows into `errors` (rows, position rows). */
static int find_errors(mbsr_completion *w, double t, const double *q, const double *u,
                       double *errors)
{
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, t, q);
    if (!status) status = mbsri_velocities(m, w->d, u);
    if (!status) status = mbsri_closure_jacobians(m, w->d);
    if (!status) status = mbsri_closure_errors(m, w->d, errors, errors + m->rows);
    if (status) w->error = w->d->error;
    return status;
}

/* s and s' of stiff rows in w->ahead, by what gaps and rates are there more than at the state. */
static int follow_springs(mbsr_completion *w, double s)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *c = m->closures.data;
    const double *here = w->ahead.errors, *gap_here = here + m->rows;
    double *there = w->ahead.errors + m->rows + m->position_rows, *gap_there = there + m->rows;
    const int status = find_errors(w, w->t + s, w->form.q, w->form.u, there);
    for (size_t id = 0; id < m->closures.count && !status; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k, gap = c->position_row + k;
            const double stiffness = c->def.stiffness[k];
            if (!mbsri_is_stiff(c, k)) continue;
            w->ahead.y[w->loops + row] += stiffness * (gap_there[gap] - gap_here[gap]);
            w->ahead.yp[w->loops + row] =
                w->yp[w->loops + row] + stiffness * (there[row] - here[row]);
        }
    }
    return status;
}

/* F_u at the time t + s with the positions and velocities of w->form and loop forces lambda + s
 * lambda'. The momenta there are those of the velocities, unless no equation of forces knows of
 * them (apart). */
static int look_beside(mbsr_completion *w, double s, bool apart)
{
    const mbsr_model *m = w->m;
    double *y = w->ahead.y;
    int status = MBSR_OK;
    if (apart) {
        mbsri_copy((size_t)m->nq, w->form.q, y);
        mbsri_copy((size_t)m->nu, w->y + m->nq, y + m->nq);
        mbsri_copy((size_t)m->nu, w->form.u, y + w->rates);
    } else {
        status = mbsri_pack(&mbsri_form_momentum, m, w->d, w->t + s, w->form.q, w->form.u, y);
        if (status) w->error = w->d->error;
    }
    if (status) return status;
    mbsri_copy((size_t)(w->size - w->loops), w->y + w->loops, y + w->loops);
    mbsri_copy((size_t)w->size, w->yp, w->ahead.yp);
    for (int k = 0; k < m->rows; ++k) w->ahead.yp[w->loops + k] += s * w->force_rate[k];
    if (mbsri_any_stiff(m)) status = follow_springs(w, s);
    if (status) return status;
    status = mbsri_completion_residual(w, w->t + s, y, w->ahead.yp);
    if (!status && apart) leave_out_momenta(w);
    return status;
}

/* On the path, with velocities u + s u'. */
static int look_along(mbsr_completion *w, double s, bool apart)
{
    const double *udot = w->rate + w->rates;
    const int status = go_along(w, s, udot);
    if (status) w->error = w->d->error;
    for (int k = 0; k < w->m->nu; ++k) w->form.u[k] = w->y[w->rates + k] + s * udot[k];
    return status ? status : look_beside(w, s, apart);
}

/* Weights of F at -2h .. 2h for the first derivative, times 12 h, and for the second, times 12 h^2.
 */
static const double first_weight[5] = {1.0, -8.0, 0.0, 8.0, -1.0},
                    second_weight[5] = {-1.0, 16.0, -30.0, 16.0, -1.0};

/* r (size) = (0, 0, dF_u/dt or d^2F_u/dt^2) along the motion, by steps h, s. F at the state is in
 * w->further. */
static int differentiate(mbsr_completion *w, bool twice, double h, double *r)
{
    const double over = 1.0 / (12.0 * h * (twice ? h : 1.0)),
                 *weight = twice ? second_weight : first_weight;
    const bool apart = separates(w);
    const int failed = mbsri_any_stiff(w->m)
                           ? find_errors(w, w->t, w->y, w->y + w->rates, w->ahead.errors)
                           : MBSR_OK;
    if (failed) return failed;
    mbsri_zero((size_t)w->size, r);
    for (int l = 0; l < 5; ++l) {
        if (weight[l] == 0.0) continue;
        int status = MBSR_OK;
        mbsri_copy((size_t)w->size, w->further, w->F);
        if (l == 2 && apart)
            leave_out_momenta(w);
        else
            status = look_along(w, (l - 2) * h, apart);
        if (status) return status;
        for (int k = w->rates; k < w->loops; ++k) r[k] += over * weight[l] * w->F[k];
    }
    return MBSR_OK;
}

/* What rounding makes of F_u at the most, into w->time (nu): of positions and velocities, by a
 * change of each by 2^-40, and of all forces that act. F at the state is in w->further. */
static int find_noise(mbsr_completion *w)
{
    static const double little = 0x1p-40, most = 1024.0 * DBL_EPSILON, share = 64.0 * DBL_EPSILON;
    const mbsr_model *m = w->m;
    const bool apart = separates(w);
    for (int k = 0; k < m->nq; ++k)
        w->form.q[k] = w->y[k] * (1.0 + little * sin(12.9898 * (k + 1)));
    for (int k = 0; k < m->nu; ++k)
        w->form.u[k] = w->y[w->rates + k] * (1.0 + little * sin(78.233 * (k + 1)));
    const int status = look_beside(w, 0.0, apart);
    const double work = status ? 0.0 : mbsri_work_of_forces(m, w->d);
    for (int k = 0; k < m->nu && !status; ++k) {
        const int row = w->rates + k;
        w->time[k] =
            most / little * fabs(w->F[row] - w->further[row]) + share * work * w->span.per[k];
    }
    return status;
}

/* Takes for each row of r, by the shortest steps h, the quotient by longer ones where it differs by
 * rounding, and by the longest where that is nearer to it: what steps are too long for grows with
 * their fourth power, 4096 from the one to the other. */
static void take_longest(const mbsr_completion *w, double h, const double *longer,
                         const double *longest, double *r)
{
    static const double nearer = 0.5, grows = 512.0;
    for (int k = w->rates; k < w->loops; ++k) {
        const double first = fabs(longer[k] - r[k]), second = fabs(longest[k] - longer[k]);
        if (h * h * first <= w->time[k - w->rates] && second <= grows * first)
            r[k] = second <= nearer * first ? longest[k] : longer[k];
    }
}

/* How far the quotient by steps h is off by their length: that by steps eight times as long is by
 * 4096 times as much. As w->time. */
static double off_by_length(double h, double quotient, double longer)
{
    return h * h * fabs(longer - quotient) / 4095.0;
}

/* By shorter steps where their length makes more of r than rounding: the one falls with their
 * fourth power, the other rises with their square. */
static int take_shorter(mbsr_completion *w, double h, const double *longer, double *r)
{
    static const double shortest = 0.25;
    double share = 1.0, *shorter = w->other;
    for (int k = w->rates; k < w->loops; ++k) {
        const double off = off_by_length(h, r[k], longer[k]);
        if (off > w->time[k - w->rates])
            share = fmin(share, pow(w->time[k - w->rates] / off, 1.0 / 6.0));
    }
    if (share == 1.0) return MBSR_OK;
    share = fmax(share, shortest);
    const int status = differentiate(w, true, share * h, shorter);
    for (int k = w->rates; k < w->loops && !status; ++k) {
        if (off_by_length(h, r[k], longer[k]) > w->time[k - w->rates]) r[k] = shorter[k];
    }
    return status;
}

/* r = (0, 0, d^2F_u/dt^2). Far along the motion F may be
 * known no more. */
static int differentiate_twice(mbsr_completion *w, bool exactly)
{
    const double time = mbsri_completion_time(w), h = share_of_time[0] * time;
    const mbsr_error before = w->d->error;
    int status = differentiate(w, true, h, w->r);
    if (status || !exactly) return status;
    status = find_noise(w);
    if (!status) status = differentiate(w, true, share_of_time[1] * time, w->x);
    if (!status) status = differentiate(w, true, share_of_time[2] * time, w->other);
    if (!status) take_longest(w, h, w->x, w->other, w->r);
    if (!status) status = take_shorter(w, h, w->x, w->r);
    w->d->error = before;
    return MBSR_OK;
}

/* r becomes what springs take of it, F_u,q x_q, from the parts of its solution: dampers take the
 * rest, which is no rounding of zero in F_u'', and would be seen in b, by 1/c^2 of it, at every
 * turn. F is another afterwards. */
static int leave_to_springs(mbsr_completion *w)
{
    static const double short_way = 1e-4;
    const double way = mbsri_completion_speed(w, w->other + w->rates), step = short_way / way;
    mbsri_zero((size_t)w->size, w->r);
    if (!isfinite(step)) return MBSR_OK;
    mbsri_copy((size_t)w->size, w->yp, w->ahead.yp);
    for (int side = -1; side <= 1; side += 2) {
        mbsri_copy((size_t)w->size, w->y, w->ahead.y);
        for (int k = 0; k < w->m->nq; ++k) w->ahead.y[k] += side * step * w->x[k];
        for (int k = w->loops; k < w->size; ++k) w->ahead.y[k] += side * step * w->x[k];
        const int status = mbsri_completion_residual(w, w->t, w->ahead.y, w->ahead.yp);
        if (status) return status;
        for (int k = w->rates; k < w->loops; ++k) w->r[k] += side * w->F[k] / (2.0 * step);
    }
    return MBSR_OK;
}

/* The parts a and b of the solution for r, from where F is that in w->further, which it becomes
 * again; *change: of what size b is. */
static int balance(mbsr_completion *w, double *change)
{
    mbsri_copy((size_t)w->size, w->further, w->F);
    const int status = mbsri_completion_split(w, w->r);
    *change = status ? 0.0 : mbsri_completion_speed(w, w->other + w->rates);
    return status;
}

/* For the first derivative. F stays that at the state, as in the next. */
static int balance_rates(mbsr_completion *w, double *change)
{
    mbsri_copy((size_t)w->size, w->F, w->further);
    const int status = differentiate(w, false, share_of_time[0] * mbsri_completion_time(w), w->r);
    return status ? status : balance(w, change);
}

/* For what springs take of the second. */
static int balance_accelerations(mbsr_completion *w, bool exactly, double *change)
{
    mbsri_copy((size_t)w->size, w->F, w->further);
    int status = differentiate_twice(w, exactly);
    if (!status) status = mbsri_completion_split(w, w->r);
    if (!status) status = leave_to_springs(w);
    return status ? status : balance(w, change);
}

/* Loop forces change with what the motion balances. */
static void take_force_rates(mbsr_completion *w)
{
    for (int k = 0; k < w->m->rows; ++k) w->force_rate[k] -= w->other[w->loops + k];
}

int mbsri_completion_drift(mbsr_completion *w, double *change)
{
    double *u = w->y + w->rates, *udot = w->rate + w->rates;
    const int status = balance_rates(w, change);
    for (int k = 0; k < w->m->nu && !status; ++k) {
        u[k] -= w->other[w->rates + k];
        udot[k] -= w->x[w->rates + k];
    }
    if (!status) take_force_rates(w);
    return status;
}

/* Rates of loop forces. Those that velocities were found with belong to loop forces that masses had
 * no share in yet: velocities do not see that share, accelerations do by its turning. Dampers
 * beside loops make them depend on accelerations. */
static int renew_force_rates(mbsr_completion *w)
{
    double change;
    if (w->m->rows == 0) return MBSR_OK;
    const int status = balance_rates(w, &change);
    if (!status) take_force_rates(w);
    return status;
}

int mbsri_completion_accelerate(mbsr_completion *w, bool exactly)
{
    enum { MOST = 8 };
    static const double enough = 1e-9, /* a correction of that size leaves far less */
        near = 1e-5;
    const int lag = w->m->rows > 0; /* rates of loop forces follow the last accelerations */
    double *udot = w->rate + w->rates, last = INFINITY, change = INFINITY;
    bool falls = true;
    for (int step = 0; step < MOST && falls; ++step, last = change) {
        int status = renew_force_rates(w);
        if (!status) status = balance_accelerations(w, exactly, &change);
        for (int k = 0; k < w->m->nu && !status; ++k) udot[k] -= w->other[w->rates + k];
        if (status || change <= enough * mbsri_completion_speed(w, udot)) return status;
        falls = step <= lag || change < 0.5 * last;
    }
    if (!exactly || change <= near * mbsri_completion_size(w, udot)) return MBSR_OK;
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE,
                                 "accelerations that springs leave were not found");
}
