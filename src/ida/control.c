/* When steps are careful, and how long matrices live.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A step is ordinary, IDA's own; or careful, one of a trial of 15 to 60; or careful, one of a
 * hundred. Careful steps have a new matrix in each iteration (iteration.c) and filtered error tests
 * (filter.c). They are dear, and do not pay where stiff directions vibrate and have to be resolved.
 * So signs are collected, and what is enough of them begins careful steps, or changes how long the
 * matrices of ordinary steps live:
 *
 *   sign             seen by                                  enough            leads to
 *   STIFF            error test of order <= 3: the filter     1                 100 careful steps
 *                    leaves < 0.05 of it
 *   PARTLY_STIFF     ... < 0.1; < 0.3 where matrices are      1                 a trial
 *                    cheap
 *   VIBRATES         ... < 0.3 at order 1 or 2 where          2 in 100 steps    the next trial,
 *                    matrices are dear                                          after a pause
 *   LOW_ORDER        errors of order 1 and 2 (1 point) that   6 points, which   a trial
 *                    fail their test (3)                      fade
 *   TURNS            second correction, by a new matrix, as   1                 100 careful steps
 *                    large as the first
 *   TURNED           an old matrix was wrong for a stiff      2 in 30 steps     a trial; matrices
 *                    correction                                                 live 1 step
 *   MISLED           plain iteration failed, or was           2 in 10 steps     a trial
 *                    verified and wrong
 *   WRONG_QUOTIENTS  matrix times a direction                 1                 a trial
 *   MUCH_LEFT        last step of an old matrix: it leaves    1                 matrices live half
 *                    much                                                       as long
 *   LITTLE_LEFT      ... little                               1                 twice as long
 *
 * A small vibration that coordinates do not show and BDF of high order keeps alive, seen in the
 * errors of tests of order 3 and more for 200 steps or longer, takes the order down to 2 until
 * steps are past it: stability.c.
 *
 * A trial takes 15 steps, and twice as many as the last one if that ended no longer than 20 of its
 * lengths ago (3 where matrices are dear), at most 100. The next trial of what vibrates is always
 * twice as long, and the pause before it grows up to 32 of its lengths: either it leads out of
 * there, or careful steps are a small part of a run that has to resolve the vibration. Careful
 * steps that are asked for within others prolong these. When they are over steps are ordinary
 * again. */
#include "ida/control.h"

#include <math.h>

enum { FIRST = 15, MOST = 100 };

typedef enum careful { NO_SPAN, TRIAL, NEXT_TRIAL, HUNDRED } careful;
typedef enum life { SAME_LIFE, ONE_STEP, HALF, TWICE } life;

typedef struct rule {
    double enough; /* points */
    double memory; /* steps after which those before are forgotten */
    bool fades;    /* to 1/e after these */
    careful steps;
    life matrices;
} rule;

static const rule rules[MBSRI_SIGNS] = {
    [MBSRI_SIGN_STIFF] = {1.0, 1.0, false, HUNDRED, SAME_LIFE},
    [MBSRI_SIGN_PARTLY_STIFF] = {1.0, 1.0, false, TRIAL, SAME_LIFE},
    [MBSRI_SIGN_VIBRATES] = {2.0, 100.0, false, NEXT_TRIAL, SAME_LIFE},
    [MBSRI_SIGN_LOW_ORDER] = {6.0, 30.0, true, TRIAL, SAME_LIFE},
    [MBSRI_SIGN_TURNS] = {1.0, 1.0, false, HUNDRED, SAME_LIFE},
    [MBSRI_SIGN_TURNED] = {2.0, 30.0, false, TRIAL, ONE_STEP},
    [MBSRI_SIGN_MISLED] = {2.0, 10.0, false, TRIAL, SAME_LIFE},
    [MBSRI_SIGN_WRONG_QUOTIENTS] = {1.0, 1.0, false, TRIAL, SAME_LIFE},
    [MBSRI_SIGN_MUCH_LEFT] = {1.0, 1.0, false, NO_SPAN, HALF},
    [MBSRI_SIGN_LITTLE_LEFT] = {1.0, 1.0, false, NO_SPAN, TWICE},
};

/* ---- careful steps ---- */

void mbsri_control_begin(mbsri_control *c)
{
    for (int k = 0; k < MBSRI_SIGNS; ++k) c->evidence[k] = (mbsri_evidence){0.0, 0};
    c->matrices =
        (mbsri_matrices){.share = c->matrices.share, .kept = c->matrices.kept, .due = 2.0};
    c->learned = false;
    c->until = c->span = 0;
    c->doubt = 1.0;
    c->patience = 1;
    c->failed_at = -1;
    c->low_until = 0;
    c->vibration = (mbsri_vibration){0};
}

mbsri_mode mbsri_control_mode(const mbsri_control *c, long step)
{
    if (c->care == MBSRI_CARE_ALWAYS) return MBSRI_MODE_CAREFUL;
    if (step >= c->until) return MBSRI_MODE_ORDINARY;
    return c->span < MOST ? MBSRI_MODE_TRIAL : MBSRI_MODE_CAREFUL;
}

static bool enough(mbsri_control *c, long step, mbsri_sign sign, double points)
{
    const rule *r = &rules[sign];
    mbsri_evidence *e = &c->evidence[sign];
    const double since = (double)(step - e->at);
    if (r->fades)
        e->points *= exp(-since / r->memory);
    else if (since >= r->memory)
        e->points = 0.0;
    e->points += points;
    e->at = step;
    if (e->points < (r->fades ? c->doubt : 1.0) * r->enough) return false;
    e->points = r->fades ? 0.0 : r->enough - 1.0;
    return true;
}

static void take_care(mbsri_control *c, long step, careful steps)
{
    enum { LONGEST = 32 };
    const long near = c->dear ? 3 : 20;
    bool again = step < c->until + near * c->span;
    if (steps == NO_SPAN || c->care == MBSRI_CARE_NEVER) return;
    if (steps == NEXT_TRIAL) {
        if (step < c->until + c->patience * c->span) return;
        if (c->patience < LONGEST) c->patience *= 2;
        again = c->span > 0;
    }
    if (steps == HUNDRED) {
        c->span = MOST;
        c->doubt = 1.0;
    } else if (step >= c->until) {
        c->span = again ? 2 * c->span : FIRST;
        if (c->span > MOST) c->span = MOST;
    }
    if (step + c->span > c->until) c->until = step + c->span;
}

static void change_life(mbsri_matrices *m, life to)
{
    enum { LONGEST = 64 };
    switch (to) {
    case SAME_LIFE: break;
    case ONE_STEP: m->life = 1; break;
    case HALF: m->life = m->life > 1 ? m->life / 2 : m->life; break;
    case TWICE: m->life = m->life < LONGEST ? 2 * m->life : m->life; break;
    }
}

bool mbsri_control_note(mbsri_control *c, long step, mbsri_sign sign, double points)
{
    if (sign == MBSRI_SIGN_NONE || !enough(c, step, sign, points)) return false;
    if (sign == MBSRI_SIGN_LOW_ORDER && c->dear) c->doubt *= 2.0;
    take_care(c, step, rules[sign].steps);
    change_life(&c->matrices, rules[sign].matrices);
    return true;
}

/* ---- matrices ---- */

/* Where a stiff direction turns, steps are to be careful, and it is old matrices that tell: they
 * are kept at first, and for some time after careful steps. */
static bool is_calm(const mbsri_control *c, long step)
{
    enum { START = 100, CALM = 500 };
    if (c->until > 0) return step >= c->until + CALM;
    return !c->looks || step >= START;
}

/* A matrix has been made. */
static void control_made(mbsri_control *c, long step)
{
    c->matrices.age = 0;
    c->matrices.made_at = step;
}

mbsri_matrix mbsri_control_choose(mbsri_control *c, long step, bool asked, bool able)
{
    enum { BETWEEN = 5 };
    mbsri_matrices *m = &c->matrices;
    ++m->age;
    if (asked) control_made(c, step);
    if (m->share > 0.0 && able && !c->dear && m->age >= m->due && is_calm(c, step))
        return MBSRI_MATRIX_BEGIN;
    if (asked) return MBSRI_MATRIX_NEW;
    if (m->life == 0 || c->iterates || step < m->made_at + m->life) return MBSRI_MATRIX_OLD;
    if (m->life > 1 || step >= m->compared_at + BETWEEN) return MBSRI_MATRIX_LAST;
    control_made(c, step);
    return MBSRI_MATRIX_NEW;
}

void mbsri_control_plan(mbsri_control *c, long step, double off, double size)
{
    static const double longest = 32.0;
    mbsri_matrices *m = &c->matrices;
    const double most = fmin(longest, 2.0 * m->age);
    m->due = off * most > m->age * m->share * size ? m->age * m->share * size / off : most;
    control_made(c, step);
}

void mbsri_control_stale(mbsri_control *c, long step)
{
    control_made(c, step);
    c->matrices.due = 1.0;
}

bool mbsri_control_compared(mbsri_control *c, long step, double left)
{
    static const double most = 0.25, little = 0.08;
    control_made(c, step);
    c->matrices.compared_at = step;
    if (left > most) mbsri_control_note(c, step, MBSRI_SIGN_MUCH_LEFT, 1.0);
    if (left < little) mbsri_control_note(c, step, MBSRI_SIGN_LITTLE_LEFT, 1.0);
    return left > most;
}

void mbsri_control_rate(mbsri_control *c, double quadratic)
{
    enum { MEASURED = 10 };
    c->matrices.quadratic = quadratic;
    c->matrices.rated = MEASURED;
}

bool mbsri_control_predicts(mbsri_control *c, double size, double enough)
{
    mbsri_matrices *m = &c->matrices;
    if (m->rated == 0 || !(m->quadratic * size * size <= enough)) return false;
    --m->rated;
    return true;
}

void mbsri_control_verified(mbsri_control *c, long step, bool misled)
{
    enum { LONGEST = 128 };
    mbsri_matrices *m = &c->matrices;
    m->pause = misled || m->pause == 0 ? 1 : 2 * m->pause;
    if (m->pause > LONGEST) m->pause = LONGEST;
    m->verify_at = c->dear ? step + m->pause : 0;
}

/* One for steps as long, or so much shorter as it was better, serves for some time. */
bool mbsri_control_tests(const mbsri_control *c, long step, double h)
{
    enum { RECENT = 100 };
    const mbsri_matrices *m = &c->matrices;
    return h > m->tested_step || step < m->tested_at || step - m->tested_at >= RECENT;
}

/* The errors of a matrix grow with the square of the step. */
void mbsri_control_tested(mbsri_control *c, long step, double h, double defect, double most)
{
    c->matrices.tested_at = step;
    c->matrices.tested_step = h * sqrt(most / fmax(defect, 1e-3));
}

bool mbsri_control_failed_soon(const mbsri_control *c, long step)
{
    enum { SOON = 10 };
    return c->failed_at >= 0 && step - c->failed_at < SOON;
}
