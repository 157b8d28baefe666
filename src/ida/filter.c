/* The error test of stiff directions.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In the direction of a stiff, damped element BDF of order k gives the momentum an offset of
 * O(h^k), of order 1 about m a h / 2, which jumps when h changes. IDA takes the jump for an error
 * that shrinks with the step, and it does not: tests fail again and again, and the order stays 1.
 * But the offset does no harm: the next implicit step forgets it. So what is tested of an error e_p
 * of the momenta is what is left of it after one such step, with K = dF/dy + c dF/dy'
 *
 *   (., e_p', .) = K^-1 (0, c e_p, 0)
 *
 * In other directions K^-1 c is 1 but for O(h). Errors of q are tested as they are: they have no
 * offset, and q and p together would not do, for e_q / h would come with p.
 *
 * In ordinary steps the filter is asked after a test has failed, and only for what to do about it.
 * Careful steps are dear, and do not pay where stiff directions vibrate and have to be resolved. They
 * begin for a few steps where a stiff direction alone failed a test of order 3 or less, a rare thing
 * in ordinary problems, or where the order stays low, and last as long as the filter leaves next to
 * nothing of errors, which it does where steps are long beside what it takes off, or Newton's method
 * shows that the stiff direction turns within a step. In careful steps it is asked before. IDA measures
 * errors of the present order, of one and two less (where there are), and, after the test is passed,
 * of one more. The function for norms gets vectors only, so each vector of IDA's knows what the
 * filter works with. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <math.h>
#include <stdlib.h>

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
    return extend(N_VClone_Serial(w), ((const content *)w->content)->stiff);
}

static N_Vector clone_empty(N_Vector w)
{
    return extend(N_VCloneEmpty_Serial(w), ((const content *)w->content)->stiff);
}

mbsri_stiff *mbsri_stiff_behind(N_Vector v)
{
    return ((const content *)v->content)->stiff;
}

double mbsri_stiff_momenta(const mbsri_stiff *s, N_Vector x)
{
    const double *value = NV_DATA_S(x), *weight = NV_DATA_S(s->weight);
    double sum = 0.0;
    for (int k = s->first; k < s->last; ++k) {
        const double e = value[k] * weight[k];
        sum += e * e;
    }
    return sqrt(sum / (double)NV_LENGTH_S(x));
}

int mbsri_stiff_solve(mbsri_stiff *s, N_Vector b)
{
    static const double share = 0.3;
    if (!s->looks || s->c == 0.0) return s->solve(b, s->memory);
    const double before = mbsri_stiff_momenta(s, b) / fabs(s->c);
    const int status = s->solve(b, s->memory);
    s->hides = before > 1.0 && mbsri_stiff_momenta(s, b) < share * before;
    return status;
}

/* ---- when ---- */

bool mbsri_stiff_careful(const mbsri_stiff *s)
{
    return s->always || s->steps < s->careful_until;
}

enum { FIRST = 15, LONG = 100 };

void mbsri_stiff_begin(mbsri_stiff *s)
{
    s->span = LONG;
    s->enough = MBSRI_STIFF_ALARM;
    s->careful_until = s->steps + LONG;
}

void mbsri_stiff_try(mbsri_stiff *s)
{
    const long near = s->dear ? 3 : 20;
    if (s->steps >= s->careful_until) {
        const bool again = s->span > 0 && s->steps < s->careful_until + near * s->span;
        s->span = again ? 2 * s->span : FIRST;
        if (s->span > LONG) s->span = LONG;
    }
    if (s->steps + s->span > s->careful_until) s->careful_until = s->steps + s->span;
}

/* Where careful steps are dear (with dense matrices; Krylov methods are left alone), a stiff direction that
 * vibrates gets them only after two failed tests of order 1 or 2 shortly after each other, and for twice as long each
 * time, after pauses that double, too: either they lead out of there, or they are a small part of a run that has to resolve it. */
static void insist(mbsri_stiff *s)
{
    enum { FAILED = 2, LONGEST = 32 };
    if (s->iterates || s->order > 2) return;
    if (s->steps > s->vibrated_at + LONG) s->vibrations = 0;
    s->vibrated_at = s->steps;
    if (++s->vibrations < FAILED) return;
    if (s->steps < s->careful_until + s->patience * s->span) return;
    s->span = s->span > 0 ? 2 * s->span : FIRST;
    if (s->span > LONG) s->span = LONG;
    s->careful_until = s->steps + s->span;
    s->vibrations = 0;
    if (s->patience < LONGEST) s->patience *= 2;
}

/* ---- the filter ---- */

/* s->filtered becomes K^-1 (0, c e_p, 0), K the present matrix and e_p the momenta of x that count; right, unless it is NULL,
 * what is in brackets. Nonzero if the linear solver fails. */
static int filter(mbsri_stiff *s, N_Vector x, N_Vector right)
{
    const double *e = NV_DATA_S(x), *counts = NV_DATA_S(s->id);
    double *to = NV_DATA_S(s->filtered);
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k) {
        const bool momentum = k >= s->first && k < s->last && counts[k] > 0.0;
        to[k] = momentum ? s->c * e[k] : 0.0;
    }
    const int status = s->weigh ? s->weigh(s->user, s->filtered) : 0;
    if (status) return status;
    if (right) N_VScale(1.0, s->filtered, right);
    ++s->info.filter_solves;
    return s->solve(s->filtered, s->memory);
}

/* The norm of x with its momenta filtered; negative if the linear solver fails. */
static double filtered_norm(mbsri_stiff *s, N_Vector x)
{
    const double *e = NV_DATA_S(x);
    double *to = NV_DATA_S(s->filtered);
    if (filter(s, x, NULL)) return -1.0;
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k) {
        if (k < s->first || k >= s->last) to[k] = e[k];
    }
    return s->masked(s->filtered, s->weight, s->id);
}

/* Norm of the momenta of x. */
static double momentum_norm(mbsri_stiff *s, N_Vector x)
{
    const double *from = NV_DATA_S(x);
    double *to = NV_DATA_S(s->change);
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k)
        to[k] = k >= s->first && k < s->last ? from[k] : 0.0;
    return s->masked(s->change, s->weight, s->id);
}

bool mbsri_stiff_moves(mbsri_stiff *s, N_Vector x)
{
    static const double left = 0.3;
    if (!s->id || filter(s, x, NULL)) return false;
    return momentum_norm(s, s->filtered) < left * momentum_norm(s, x);
}

void mbsri_stiff_keep(mbsri_stiff *s, N_Vector x, bool of_iteration)
{
    N_Vector y = NULL;
    s->of_iteration = of_iteration;
    if (IDAGetCurrentY(s->memory, &y) < 0 || IDAGetCurrentTime(s->memory, &s->at) < 0) return;
    N_VScale(1.0, x, s->direction);
    N_VScale(1.0, y, s->state);
}

/* Whether the filter leaves so little of an error x that a stiff direction alone made it: then it is
 * counted, and careful steps begin, for long where steps are so long that nothing of it could be resolved.
 * In the problems of bench/ordinary.c 0.1 to 0.3 is left of such errors, where pins are springs 0.001
 * to 0.05. Between them a few careful steps do no harm, unless they are dear. */
static bool stiff_alone(mbsri_stiff *s, N_Vector x, double filtered, double plain)
{
    if (!(filtered >= 0.0 && filtered < 0.3 * plain)) return false;
    const bool vibrates = filtered > 0.1 * plain;
    ++s->info.stiff_tests;
    mbsri_stiff_keep(s, x, false);
    if (filtered < 0.05 * plain)
        mbsri_stiff_begin(s);
    else if (!vibrates || !s->dear)
        mbsri_stiff_try(s);
    else
        insist(s);
    return true;
}

/* Whether something stiff keeps the order low: a step of order 1 or 2 adds 1 if its error is large and 3 if the
 * test fails, unless the filter leaves most of the error: order is low at first, too, and where light damping lets
 * things vibrate. 30 steps take the sum down to 1/e. Where careful steps are dear and nothing stiff has been
 * found by them, twice as much has to come together for the next. */
static void raise_alarm(mbsri_stiff *s, double by, double filtered)
{
    static const double fade = 30.0, most = 0.6;
    if (!(filtered < most * s->suspect_norm)) return;
    if (s->steps < s->alarmed_at) s->alarm = 0.0; /* IDA has started anew */
    s->alarm *= exp((double)(s->alarmed_at - s->steps) / fade);
    s->alarm += by;
    s->alarmed_at = s->steps;
    if (s->alarm < s->enough) return;
    s->alarm = 0.0;
    if (s->dear) s->enough *= 2.0;
    mbsri_stiff_try(s);
}

/* Ordinary steps are tested by IDA alone. Whether a test fails the norm does not tell, but the next
 * attempt does: what may have failed is kept until then. */
static void keep_error(mbsri_stiff *s, N_Vector x, double plain)
{
    s->suspect = plain > 1.0 && s->order <= 3;
    if (!s->suspect) return;
    N_VScale(1.0, x, s->error);
    s->suspect_norm = plain;
    IDAGetNumErrTestFails(s->memory, &s->tests_failed);
    if (s->order > 2 || s->low_order || s->steps == s->alarmed_at) return;
    raise_alarm(s, 1.0, filtered_norm(s, x));
}

void mbsri_stiff_look_back(mbsri_stiff *s)
{
    long failed = 0;
    if (!s->suspect) return;
    s->suspect = false;
    IDAGetNumErrTestFails(s->memory, &failed);
    if (failed <= s->tests_failed) return;
    const double filtered = filtered_norm(s, s->error);
    if (stiff_alone(s, s->error, filtered, s->suspect_norm)) return;
    if (s->order < 3 && !s->low_order) raise_alarm(s, 3.0, filtered);
}

/* The offset turns with the stiff direction, and the more of it is left the longer the step: it may be no
 * more than a small share of the momenta. Only at loose tolerances are steps so long. */
static double bounded(mbsri_stiff *s, double filtered, double plain)
{
    static const double share = 0.02, least = 80.0;
    if (plain <= least) return filtered;
    N_Vector y = NULL;
    const double all = IDAGetCurrentY(s->memory, &y) < 0 ? 0.0 : momentum_norm(s, y);
    return fmax(filtered, plain / fmax(least, share * all));
}

/* The factor by which the error x, of norm `plain`, is tested more strictly than IDA would: where it may be that of a jump. */
static double strictness(mbsri_stiff *s, N_Vector x, double plain)
{
    static const double many = 20.0;
    const double unequal = mbsri_stiff_unequal(s);
    return unequal * plain > many && unequal * momentum_norm(s, x) > many ? unequal : 1.0;
}

/* The first norm of an error test decides on all: they have to be comparable. `many` tolerances: beyond these the filter has to know
 * that an error is an offset; what is none is tested as that of a jump. */
static double first_norm(mbsri_stiff *s, N_Vector x, double plain)
{
    static const double many = 20.0;
    const double jump = strictness(s, x, plain) * plain;
    s->filters = false;
    if (!s->careful) {
        keep_error(s, x, plain);
        return jump;
    }
    if (jump > many && filter(s, x, s->error) == 0 && !mbsri_stiff_acted(s, x)) return jump;
    if (!(plain > 1.0)) return plain;
    const double filtered = s->stricter * filtered_norm(s, x);
    if (!(filtered >= 0.0 && filtered < plain)) return plain;
    stiff_alone(s, x, filtered, plain);
    s->filters = true;
    return bounded(s, filtered, plain);
}

/* After failures IDA falls to order 1, and doubles h whenever it can, so that it never sees the three
 * equal steps after which it raises the order. With a norm of 0.7 it leaves h as it is. Ordinary steps need
 * that, too: vibrations that higher orders of BDF have excited leave them there. */
static double hold(mbsri_stiff *s, double found)
{
    enum { SOON = 10 };
    if (!(found <= 1.0)) s->rejected_at = s->steps;
    const bool soon = s->rejected_at >= 0 && s->steps - s->rejected_at < SOON;
    return s->order == 1 && soon ? fmax(found, 0.7) : found;
}

/* IDA has no more norms to come in this error test. */
static bool last_of_test(const mbsri_stiff *s, int call)
{
    return call > (s->order < 3 ? s->order : 3);
}

/* Carefully, the order does not fall to 1: the offsets of order 2 jump less. */
static double tested_norm(mbsri_stiff *s, N_Vector x, N_Vector w, N_Vector id)
{
    static const double forbidden = 1e10;
    const double plain = s->masked(x, w, id) * (s->careful ? s->stricter : 1.0);
    const int call = ++s->norms;
    if (call == 1) {
        s->id = id;
        IDAGetCurrentOrder(s->memory, &s->order);
        mbsri_stiff_note_attempt(s);
        return hold(s, first_norm(s, x, plain));
    }
    if (last_of_test(s, call)) s->norms = -1;
    if (call == 2 && s->order == 2 && s->careful) return forbidden;
    if (!s->filters) return plain;
    const double filtered = s->stricter * filtered_norm(s, x);
    return filtered >= 0.0 && filtered < plain ? filtered : plain;
}

static double moved_norm(mbsri_stiff *s, N_Vector x, N_Vector w, N_Vector id)
{
    const int call = ++s->norms;
    if (call == 1) IDAGetCurrentOrder(s->memory, &s->order);
    if (last_of_test(s, call)) s->norms = -1;
    return mbsri_stiff_moved(s, x, w, id, call == 1);
}

static sunrealtype norm(N_Vector x, N_Vector w, N_Vector id)
{
    mbsri_stiff *s = mbsri_stiff_behind(x);
    if (s->norms < 0 || s->test == MBSRI_TEST_PLAIN) return s->masked(x, w, id);
    return s->test == MBSRI_TEST_MOVED ? moved_norm(s, x, w, id) : tested_norm(s, x, w, id);
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
