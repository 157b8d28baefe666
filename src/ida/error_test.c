/* The error test of IDA, with norms of one's own.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA asks for masked norms of vectors, and does not say what they are. After Newton's method has
 * solved a step of order k they are the errors of order k, of k - 1 where k > 1, of k - 2 where k >
 * 2, and, if the test is passed and the order may rise, of k + 1. The vectors that IDA makes know
 * what they are tested by. What is used besides: with a norm of 0.7 IDA leaves h as it is at order
 * 1, and it lowers the order where the error of the lower one is no larger.
 * tests/ida/test_ida_norms.c fails where IDA does otherwise.
 *
 * In ordinary steps the filter (filter.c) is asked after a test has failed, and only for what to do
 * about it: signs for control.c. In careful steps it is asked before. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <math.h>
#include <stdlib.h>

/* ---- what it says that the filter leaves little ---- */

/* The sign that a test of norm `plain` at such an order gives. In the problems of bench/ordinary.c
 * 0.1 to 0.3 is left of errors that stiff directions make, where pins are springs 0.001 to 0.05:
 * those are long steps, in which nothing could be resolved. Between them a few careful steps do no
 * harm, unless they are dear. Krylov methods are left alone then. */
static mbsri_sign sign_of(const mbsri_control *c, int order, double filtered, double plain)
{
    if (filtered < 0.05 * plain) return MBSRI_SIGN_STIFF;
    if (filtered <= 0.1 * plain || !c->dear) return MBSRI_SIGN_PARTLY_STIFF;
    return order <= 2 && !c->iterates ? MBSRI_SIGN_VIBRATES : MBSRI_SIGN_NONE;
}

/* Whether the filter leaves so little of an error x that a stiff direction alone made it: then it
 * is counted. */
static bool stiff_alone(mbsri_stiff *s, N_Vector x, double filtered, double plain)
{
    if (!(filtered >= 0.0 && filtered < 0.3 * plain)) return false;
    ++s->info.stiff_tests;
    mbsri_stiff_keep(s, x, false);
    const mbsri_sign sign = sign_of(&s->control, s->now.order, filtered, plain);
    mbsri_control_note(&s->control, s->now.steps, sign, 1.0);
    return true;
}

/* A large error of order 1 or 2, if the filter does not leave most of it: order is low at first,
 * too, and where light damping lets things vibrate. */
static void note_low_order(mbsri_stiff *s, double points, double filtered)
{
    static const double most = 0.6;
    if (filtered < most * s->now.suspect_norm)
        mbsri_control_note(&s->control, s->now.steps, MBSRI_SIGN_LOW_ORDER, points);
}

/* Ordinary steps are tested by IDA alone. Whether a test fails the norm does not tell, but the next
 * attempt does: what may have failed is kept until then. */
static void keep_error(mbsri_stiff *s, N_Vector x, double plain)
{
    mbsri_attempt *now = &s->now;
    now->suspect = plain > 1.0 && now->order <= 3;
    if (!now->suspect) return;
    N_VScale(1.0, x, s->error);
    now->suspect_norm = plain;
    IDAGetNumErrTestFails(s->memory, &now->tests_failed);
    const bool noted = now->steps == s->control.evidence[MBSRI_SIGN_LOW_ORDER].at;
    if (now->order <= 2 && !s->low_order && !noted)
        note_low_order(s, 1.0, mbsri_stiff_filtered_norm(s, x));
}

void mbsri_stiff_look_back(mbsri_stiff *s)
{
    long failed = 0;
    if (!s->now.suspect) return;
    s->now.suspect = false;
    IDAGetNumErrTestFails(s->memory, &failed);
    if (failed <= s->now.tests_failed) return;
    const double filtered = mbsri_stiff_filtered_norm(s, s->error);
    if (stiff_alone(s, s->error, filtered, s->now.suspect_norm)) return;
    if (s->now.order < 3 && !s->low_order) note_low_order(s, 3.0, filtered);
}

/* ---- the norms ---- */

/* The offset turns with the stiff direction, and the more of it is left the longer the step: it may
 * be no more than a small share of the momenta. Only at loose tolerances are steps so long. */
static double bounded(mbsri_stiff *s, double filtered, double plain)
{
    static const double share = 0.02, least = 80.0;
    if (plain <= least) return filtered;
    N_Vector y = NULL;
    const double all = IDAGetCurrentY(s->memory, &y) < 0 ? 0.0 : mbsri_stiff_momentum_norm(s, y);
    return fmax(filtered, plain / fmax(least, share * all));
}

/* The norm by which an error of `norm`, `momenta` in its momenta, is tested where it may be that of
 * a jump. Less than `many` tolerances may be noise that no step makes smaller, or what the filter
 * leaves of an offset: by `doubtful` times IDA's constant at most. */
static double as_jump(mbsri_stiff *s, double norm, double momenta, double doubtful)
{
    static const double many = 10.0;
    const double all = mbsri_stiff_unequal(s, momenta);
    const double unequal = momenta > many ? all : fmin(doubtful, all);
    return unequal * momenta > many ? unequal * norm : norm;
}

/* The first norm of an error test decides on all: they have to be comparable. `many` tolerances:
 * beyond these the filter has to know that an error is an offset. What is none, and what the filter
 * leaves, is tested as that of a jump. */
static double first_norm(mbsri_stiff *s, N_Vector x, double plain)
{
    static const double many = 20.0, noise = 20.0;
    const double jump = as_jump(s, plain, mbsri_stiff_momentum_norm(s, x), noise);
    s->now.tests = MBSRI_MEASURE_ALL;
    if (!s->now.careful) {
        keep_error(s, x, plain);
        return jump;
    }
    if (plain > 1.0 && mbsri_stiff_is_rounding(s, x)) {
        s->now.tests = MBSRI_MEASURE_COORDINATES;
        return s->stricter * mbsri_stiff_coordinate_norm(s, x);
    }
    if (jump > many && mbsri_stiff_filter(s, x, s->error) == 0 && !mbsri_stiff_acted(s, x))
        return jump;
    if (!(plain > 1.0)) return plain;
    const double filtered = s->stricter * mbsri_stiff_filtered_norm(s, x);
    if (!(filtered >= 0.0 && filtered < plain)) return plain;
    stiff_alone(s, x, filtered, plain);
    s->now.tests = MBSRI_MEASURE_FILTERED;
    return bounded(s, as_jump(s, filtered, mbsri_stiff_momentum_norm(s, s->filtered), 1.0), plain);
}

/* After failures IDA falls to order 1, and doubles h whenever it can, so that it never sees the
 * three equal steps after which it raises the order. With a norm of 0.7 it leaves h as it is.
 * Ordinary steps need that, too: vibrations that higher orders of BDF have excited leave them
 * there. */
static double hold(mbsri_stiff *s, double found)
{
    if (!(found <= 1.0)) s->control.failed_at = s->now.steps;
    const bool soon = mbsri_control_failed_soon(&s->control, s->now.steps);
    return s->now.order == 1 && soon ? fmax(found, 0.7) : found;
}

/* What a test of order 3 or more says of vibrations; x: the error below its order, of norm `plain`.
 */
static void note_errors(mbsri_stiff *s, N_Vector x, double plain)
{
    double h = 0.0;
    mbsri_errors *e = &s->now.errors;
    if (s->now.order < 3 || IDAGetCurrentStep(s->memory, &h) < 0) return;
    e->momenta_below = mbsri_stiff_momenta(s, x);
    e->coordinates_below = sqrt(fmax(0.0, plain * plain - e->momenta_below * e->momenta_below));
    mbsri_control_note_errors(&s->control, s->now.steps, fabs(h), s->now.order, e);
}

/* Carefully, the order does not fall to 1: the offsets of order 2 jump less. Where it is to be low
 * it stays at 2. */
static bool forbidden(const mbsri_attempt *now, mbsri_call call)
{
    if (call == MBSRI_CALL_BELOW) return now->order == 2 && (now->low || now->careful);
    return call == MBSRI_CALL_ABOVE && now->order >= 2 && now->low;
}

static double first_of_test(mbsri_stiff *s, N_Vector x, double plain)
{
    double h = 0.0;
    mbsri_stiff_note_attempt(s);
    s->now.errors.momenta = mbsri_stiff_momenta(s, x);
    s->now.low = IDAGetCurrentStep(s->memory, &h) >= 0 &&
                 mbsri_control_low_order(&s->control, s->now.steps, fabs(h));
    s->now.norm = hold(s, first_norm(s, x, plain));
    return s->now.norm;
}

/* Where the order is to be low, errors of lower orders are the smaller ones. */
static double tested_norm(mbsri_stiff *s, N_Vector x, mbsri_call call)
{
    static const double very_large = 1e10;
    const double all = s->masked(x, s->weight, s->id);
    double found = all * (s->now.careful ? s->stricter : 1.0);
    if (call == MBSRI_CALL_OF_ORDER) return first_of_test(s, x, found);
    if (call == MBSRI_CALL_BELOW) note_errors(s, x, all);
    if (forbidden(&s->now, call)) return very_large;
    if (s->now.tests == MBSRI_MEASURE_COORDINATES)
        found = s->stricter * mbsri_stiff_coordinate_norm(s, x);
    if (s->now.tests == MBSRI_MEASURE_FILTERED) {
        const double filtered = s->stricter * mbsri_stiff_filtered_norm(s, x);
        if (filtered >= 0.0 && filtered < found) found = filtered;
    }
    return s->now.low ? fmin(found, 0.5 * s->now.norm) : found;
}

/* What IDA asks for next in a test of such an order. */
static mbsri_call next(mbsri_call last, int order)
{
    switch (last) {
    case MBSRI_CALL_AWAITED: return MBSRI_CALL_OF_ORDER;
    case MBSRI_CALL_OF_ORDER: return order > 1 ? MBSRI_CALL_BELOW : MBSRI_CALL_ABOVE;
    case MBSRI_CALL_BELOW: return order > 2 ? MBSRI_CALL_TWO_BELOW : MBSRI_CALL_ABOVE;
    case MBSRI_CALL_TWO_BELOW: return MBSRI_CALL_ABOVE;
    case MBSRI_CALL_ABOVE:
    case MBSRI_CALL_NONE: break;
    }
    return MBSRI_CALL_NONE;
}

static sunrealtype norm(N_Vector x, N_Vector w, N_Vector id)
{
    mbsri_stiff *s = mbsri_stiff_behind(x);
    const mbsri_call call = next(s->now.call, s->now.order);
    s->now.call = call;
    if (call == MBSRI_CALL_NONE || s->test == MBSRI_TEST_PLAIN) return s->masked(x, w, id);
    if (call == MBSRI_CALL_OF_ORDER) {
        s->id = id;
        IDAGetCurrentOrder(s->memory, &s->now.order);
    }
    return s->test == MBSRI_TEST_MOVED ? mbsri_stiff_moved(s, x, call == MBSRI_CALL_OF_ORDER)
                                       : tested_norm(s, x, call);
}

/* ---- vectors that know ---- */

typedef struct content {
    struct _N_VectorContent_Serial serial;
    mbsri_stiff *stiff;
} content;

/* v, a serial vector, gets room for the reference; NULL, and v is gone, without memory. */
static N_Vector extend(N_Vector v, mbsri_stiff *s)
{
    content *larger = v ? realloc(v->content, sizeof *larger) : NULL;
    if (!larger) {
        if (v) N_VDestroy(v);
        return NULL;
    }
    larger->stiff = s;
    v->content = larger;
    return v;
}

static N_Vector clone(N_Vector w)
{
    return extend(N_VClone_Serial(w), mbsri_stiff_behind(w));
}

static N_Vector clone_empty(N_Vector w)
{
    return extend(N_VCloneEmpty_Serial(w), mbsri_stiff_behind(w));
}

mbsri_stiff *mbsri_stiff_behind(N_Vector v)
{
    return ((const content *)v->content)->stiff;
}

bool mbsri_stiff_attach(mbsri_stiff *s, N_Vector y)
{
    if (N_VGetVectorID(y) != SUNDIALS_NVEC_SERIAL) return false;
    content *larger = realloc(y->content, sizeof *larger);
    if (!larger) return false;
    larger->stiff = s;
    y->content = larger;
    s->masked = y->ops->nvwrmsnormmask;
    y->ops->nvwrmsnormmask = norm;
    y->ops->nvclone = clone;
    y->ops->nvcloneempty = clone_empty;
    return true;
}
