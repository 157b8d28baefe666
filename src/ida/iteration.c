/* Newton's method for stiff elements.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Predicted coordinates leave a stiff element strained by g, of the second order in the step, and
 * k g is a large force. With an old matrix, whose stiff direction has turned by an angle a since,
 * an iteration leaves a force k g a across that direction, where there is only the inertia m c^2 to
 * resist it: the iterations creep or diverge, or stop, small in the norm, with a rest of strain
 * whose energy is not small. A new matrix in each iteration leaves k g^2: it converges
 * quadratically or not at all. So in careful steps the matrix is new at first, and in each
 * iteration in which the residual r of the momenta, r / c, shows that something is still strained,
 * and the last correction has to be small itself, not by a rate of convergence. Where there
 * are contacts, matrices of the last steps come first, and each goes on as long as an iteration
 * leaves less than three tenths of r / c, one of the step itself less than a tenth; these count for
 * nothing until r / c shows that nothing is strained. There a rate does count, where corrections
 * and momenta both have it. (Of a Krylov method it is the preconditioner that would be new, in each
 * step is enough. Where momenta do not show all that is strained it is new in each iteration.)
 * Other steps are left to the solver of SUNDIALS, or begin with a new matrix (renewal.c).
 *
 * There a stiff matrix may hide a force: a residual r of the momenta is an error r / c of theirs
 * unless something stiff takes it, and where the matrix is old, that may be gone: a stop that was
 * left, a direction that has turned. The correction is small then, and passes for converged. So
 * where r / c was more than the tolerance, and the correction less than a third of it, the next
 * residual is looked at. As long as its r / c is beyond the tolerance and halves each time,
 * iterations with the matrix at hand go on; where it does not, iterations with new matrices have
 * the last word. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <ida/ida_ls.h>

#include <float.h>
#include <math.h>

/* ---- careful steps ---- */

/* Of iterations with old matrices where there are contacts: what each leaves at most. One of the
 * present step leaves more than `faster` where forces turn or have kinks: a new one has to show. */
static const double fast = 0.3, faster = 0.1;

/* Whether two corrections in a row, of new matrices, are of one size: the stiff direction turns so
 * much in one of them that the next has to undo what it did. An old matrix would not do here. */
static bool turns(double before, double size, double tolerance)
{
    return before > tolerance && size > 0.3 * before;
}

/* The first n entries of x in the norm of corrections. */
static double norm_of_first(const mbsri_stiff *s, N_Vector x, sunindextype n)
{
    const double *value = N_VGetArrayPointer(x), *weight = N_VGetArrayPointer(s->weight);
    double sum = 0.0;
    for (sunindextype k = 0; k < n; ++k) sum += value[k] * weight[k] * value[k] * weight[k];
    return sqrt(sum / (double)N_VGetLength(x));
}

/* Where multipliers of closures begin: the length where there are none. */
static sunindextype multipliers(const mbsri_stiff *s)
{
    const sunindextype first = 2 * (sunindextype)s->last - s->first, all = N_VGetLength(s->change);
    return first < all ? first : all;
}

/* Whether the last correction, s->change of norm `size`, moves coordinates by their rounding alone.
 * Where rows of closures are near to depending on each other they multiply it, for multipliers most
 * of all. */
static bool is_rounding(const mbsri_stiff *s, double size)
{
    static const double few = 4.0, many = 1e4, share = 0.1;
    const bool multiplied = norm_of_first(s, s->change, multipliers(s)) < share * size;
    N_Vector y = NULL;
    if (IDAGetCurrentY(s->memory, &y) < 0) return false;
    return norm_of_first(s, s->change, s->first) <=
           (multiplied ? many : few) * DBL_EPSILON * norm_of_first(s, y, s->first);
}

/* What an iteration found: momenta r / c that were left, and its correction. */
typedef struct found {
    double left, size;
} found;

/* Whether the matrix at hand will do once more: it is young, and leaves much less of the momenta
 * r / c than there was; a new one costs as much as seven iterations. */
static bool serves(const mbsri_stiff *s, bool young, double left, double before)
{
    const bool present = s->made.step == s->now.steps && s->made.c == s->now.c;
    return s->control.matrices.kept > 0 && s->control.looks && young &&
           left <= (present ? faster : fast) * before;
}

/* Where there are contacts: whether both shrink so much that the next correction would be small. */
static bool converges(const mbsri_stiff *s, const found *now, const found *last, double enough)
{
    static const double safe = 0.5;
    const double rate = fmax(now->size / last->size, now->left / last->left);
    return s->control.matrices.kept > 0 && rate <= fast && rate * now->size <= safe * enough;
}

/* Whether it was made a few steps ago for a c like this. */
static bool is_young(const mbsri_stiff *s)
{
    static const double alike = 0.2;
    return s->set_up && s->now.steps - s->made.step <= s->control.matrices.kept &&
           fabs(s->now.c - s->made.c) <= alike * fabs(s->made.c);
}

/* IDA's tolerance is for what is left after the last iteration. Where rounding keeps corrections
 * above the smaller one here, four of them in a row within it will do; or within `rounding`, where
 * they do not even shrink. With short steps h rounding of q is one of velocities by 1/h, beyond all
 * tolerances at last, and shorter steps make it worse: corrections that do not shrink and move
 * coordinates by their rounding are the last. Nothing better is to be had either where corrections
 * have been shortened in vain twice, after one that was not. */
static int iterate(mbsri_stiff *s, N_Vector ee, double tolerance, double rounding, bool young)
{
    enum { ITERATIONS = 10 };
    static const double share = 0.03;
    const double enough = s->control.looks ? share * tolerance : 0.0,
                 within = s->control.iterates ? INFINITY : enough;
    int small = 0, still = 0, vain = 0, fresh = 0;
    double judged = 0.0, power = 0.0;
    found before = {INFINITY, 0.0};
    bool grows = false;
    for (int k = 1; k <= ITERATIONS; ++k) {
        mbsri_search search = MBSRI_SEARCH_NONE;
        int status = mbsri_stiff_evaluate(s, ee);
        if (!status && k > 1) status = mbsri_stiff_search(s, ee, power, enough, vain == 0, &search);
        if (status) return status;
        if (search == MBSRI_SEARCH_IN_VAIN && ++vain == 3) return SUN_NLS_SUCCESS;
        N_VScale(1.0, s->change, s->trial);
        const double left = mbsri_stiff_left(s);
        const bool old = serves(s, young && !search, left, before.left);
        status = mbsri_stiff_correct(s, ee, old ? INFINITY : k == 1 || search ? 0.0 : within);
        if (status) return status;
        young = true;
        power = mbsri_stiff_power(s, s->change, s->trial);
        N_VScale(1.0, s->change, s->filtered);
        const double size = N_VWrmsNorm(s->change, s->weight);
        const found now = {left, size}, last = before;
        before = now;
        fresh = old ? 0 : fresh + 1;
        if (fresh == 2 && turns(last.size, size, tolerance)) mbsri_stiff_note(s, MBSRI_SIGN_TURNS);
        if (old && left > within) continue;
        small = size <= tolerance ? small + 1 : 0;
        still = size <= rounding ? still + 1 : 0;
        grows = still > 1 && (grows || size > judged);
        if (size <= share * tolerance || small == 4 || (still > 3 && grows)) return SUN_NLS_SUCCESS;
        if (k > 2 && size > 0.3 * judged && is_rounding(s, size)) return SUN_NLS_SUCCESS;
        if (converges(s, &now, &last, share * tolerance)) return SUN_NLS_SUCCESS;
        judged = size;
    }
    ++s->now.failures;
    return SUN_NLS_CONV_RECVR;
}

int mbsri_stiff_iterate(mbsri_stiff *s, N_Vector ee, double tolerance, double rounding, bool young)
{
    ++s->info.careful_attempts;
    const int status = iterate(s, ee, tolerance, rounding, young && is_young(s));
    if (status != SUN_NLS_CONV_RECVR) return status;
    ++s->info.careful_failures;
    mbsri_stiff_keep(s, ee, true);
    return status;
}

/* What stiff elements ask of an iterative solver: of IDA's own accuracy, a twentieth of what
 * Newton's method leaves, elements that its preconditioner knows nothing of make wrong corrections,
 * and so do quotients over the length of a tolerance. 0 and 1 are IDA's defaults. */
void mbsri_stiff_prepare(mbsri_stiff *s, bool careful)
{
    if (s->control.iterates) {
        IDASetEpsLin(s->memory, careful ? 1e-7 : 0.0);
        IDASetIncrementFactor(s->memory, careful ? 1e-2 : 1.0);
    }
    if (s->prepare) s->prepare(s->user, careful);
}

/* ---- ordinary steps ---- */

/* What the linear solver is, as soon as it has worked: it iterates, or has made a matrix. */
static void learn(mbsri_stiff *s)
{
    mbsri_control *c = &s->control;
    long linear = 0, matrices = 0, quotients = 0;
    if (c->learned || IDAGetNumLinIters(s->memory, &linear) < 0) return;
    IDAGetNumJacEvals(s->memory, &matrices);
    IDAGetNumLinResEvals(s->memory, &quotients);
    c->iterates = linear > 0;
    c->quotients = !c->iterates && quotients > 0;
    c->dear = c->dear || c->iterates || c->quotients;
    c->learned = c->iterates || matrices > 0;
}

/* Plain iterations go on until the momenta that are left do not matter: MOST of them, as long as
 * they halve what is left. SUN_NLS_CONTINUE: that was not enough. */
static int go_on(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    enum { MOST = 4 };
    double before = INFINITY;
    for (int k = 0;; ++k) {
        int status = mbsri_stiff_evaluate(s, ee);
        if (status) return status;
        const double now = mbsri_stiff_left(s);
        if (now <= tolerance) return SUN_NLS_SUCCESS;
        if (k == MOST || !(now < 0.5 * before)) return SUN_NLS_CONTINUE;
        before = now;
        status = mbsri_stiff_correct(s, ee, INFINITY);
        if (status) return status;
    }
}

/* Iterations with new matrices after plain ones. Where they are dear and have nothing to correct,
 * the next are put off, for twice as long each time. */
static int renew(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    if (s->now.steps < s->control.matrices.verify_at) return SUN_NLS_SUCCESS;
    N_VScale(1.0, ee, s->error);
    mbsri_stiff_prepare(s, true);
    const int status = mbsri_stiff_iterate(s, ee, tolerance, tolerance, false);
    mbsri_stiff_prepare(s, false);
    N_VLinearSum(1.0, ee, -1.0, s->error, s->error);
    const bool misled = status || N_VWrmsNorm(s->error, s->weight) > tolerance;
    mbsri_control_verified(&s->control, s->now.steps, misled);
    if (misled) mbsri_stiff_note(s, MBSRI_SIGN_MISLED);
    return status;
}

/* After plain iterations that may have been misled. */
static int verify(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    if (!s->now.hides) return SUN_NLS_SUCCESS;
    const int status = go_on(s, ee, tolerance);
    return status == SUN_NLS_CONTINUE ? renew(s, ee, tolerance) : status;
}

/* After one iteration of SUNDIALS. By a rate of convergence that an earlier step has shown IDA
 * takes a large correction, too, for the last; the matrix has grown older since, and what each step
 * leaves grows from step to step: of the velocities of index 2 by a factor of three. So the rate is
 * measured. Where it can not be told, of rounding, a tenth of the first correction will do. */
static int measure_rate(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    static const double large = 1000.0, little = 0.1;
    const double size = N_VWrmsNorm(ee, s->weight);
    if (size <= large * tolerance) return SUN_NLS_SUCCESS;
    const int status = mbsri_stiff_settle(s, ee, size, tolerance, false);
    if (status != SUN_NLS_CONV_RECVR) return status;
    if (N_VWrmsNorm(s->change, s->weight) <= little * size) return SUN_NLS_SUCCESS;
    return mbsri_stiff_iterate(s, ee, tolerance, tolerance, false);
}

/* Newton's method of SUNDIALS. */
static int iterate_as_ida(mbsri_stiff *s, N_Vector predicted, N_Vector ee, double tolerance,
                          bool set_up)
{
    int status =
        SUNNonlinSolSolve(s->plain, predicted, ee, s->weight, tolerance, set_up, s->memory);
    SUNNonlinSolGetNumIters(s->plain, &s->now.iterations);
    SUNNonlinSolGetNumConvFails(s->plain, &s->now.stale);
    s->now.failures = s->now.stale;
    s->control.matrices.untested = s->control.matrices.untested || set_up || s->now.stale > 0;
    if (set_up || s->now.stale > 0) mbsri_stiff_note_matrix(s);
    if (!status && s->now.iterations == 1) status = measure_rate(s, ee, tolerance);
    return status;
}

/* By the iteration of SUNDIALS, or one that begins with a new matrix. */
static int iterate_with(mbsri_stiff *s, mbsri_matrix matrix, N_Vector predicted, N_Vector ee,
                        double tolerance)
{
    const bool begins = matrix == MBSRI_MATRIX_BEGIN;
    const int status =
        begins ? mbsri_stiff_begin_anew(s, ee, tolerance)
               : iterate_as_ida(s, predicted, ee, tolerance, matrix == MBSRI_MATRIX_NEW);
    if (status == SUN_NLS_CONV_RECVR) mbsri_stiff_note(s, MBSRI_SIGN_MISLED);
    return begins ? status : mbsri_stiff_judge(s, matrix, status, ee, tolerance);
}

int mbsri_stiff_iterate_plainly(mbsri_stiff *s, N_Vector predicted, N_Vector ee, double tolerance,
                                bool set_up)
{
    const mbsri_matrix matrix =
        mbsri_control_choose(&s->control, s->now.steps, set_up, s->set_up != NULL);
    const int status = iterate_with(s, matrix, predicted, ee, tolerance);
    learn(s);
    const bool loops = multipliers(s) < N_VGetLength(ee) && !s->control.iterates;
    if (status == SUN_NLS_CONV_RECVR && loops && s->now.steps > 0) { /* by rounding, perhaps */
        N_VConst(0.0, ee);
        return SUN_NLS_CONTINUE;
    }
    if (status) return status;
    if (!mbsri_stiff_wrong_matrix(s, predicted, ee)) return verify(s, ee, tolerance);
    mbsri_stiff_note(s, MBSRI_SIGN_WRONG_QUOTIENTS);
    N_VConst(0.0, ee);
    return SUN_NLS_CONTINUE;
}
