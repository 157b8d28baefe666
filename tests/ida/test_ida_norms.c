/* What src/ida/error_test.c and jumps.c count on and SUNDIALS does not promise: which masked norms
 * IDA asks for in an error test, in which order, and what it makes of them. Where this fails a
 * release of SUNDIALS has changed that.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "problems.h"

#include "ida/compat.h"

#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

enum { SIZE = 2, PAST = 8, ASKED = 6 };

typedef struct point {
    double t, y[SIZE];
} point;

/* Norms to be handed out in the place of those of order k, k - 1, k - 2 and k + 1; NaN: the true
 * one. */
typedef struct script {
    double of_order, below, two_below, above;
} script;

/* A run of van der Pol's oscillator in steps of IDA. */
typedef struct watched {
    SUNContext context;
    mbsri_ida_messages messages;
    void *memory;
    N_Vector y, yp, id;
    SUNMatrix matrix;
    SUNLinearSolver solver;
    script script;
    point past[PAST]; /* ends of steps, the last first */
    int known;
    bool open;             /* an attempt goes on: */
    double x[ASKED][SIZE]; /* what norms have been asked for in it */
    int asked;
    double norm; /* the first of these */
    point end;   /* where it ends */
    int order;
    long failed;           /* error tests before it */
    int seen[7], failures; /* errors of such orders; tests that failed */
} watched;

static watched run; /* an operation on vectors is told nothing else */

static sunrealtype (*masked)(N_Vector, N_Vector, N_Vector);

static const script as_they_are = {NAN, NAN, NAN, NAN};

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* y at the end of the attempt minus the polynomial through the last points, of such an order. */
static void error_of(int order, double e[SIZE])
{
    memcpy(e, run.end.y, sizeof run.end.y);
    for (int j = 0; j <= order; ++j) {
        double weight = 1.0;
        for (int k = 0; k <= order; ++k)
            if (k != j) weight *= (run.end.t - run.past[k].t) / (run.past[j].t - run.past[k].t);
        for (int i = 0; i < SIZE; ++i) e[i] -= weight * run.past[j].y[i];
    }
}

static void assert_asked(int call, int order)
{
    double e[SIZE];
    error_of(order, e);
    ++run.seen[order];
    for (int i = 0; i < SIZE; ++i) {
        if (fabs(run.x[call][i] - e[i]) <= 1e-9 * (1.0 + fabs(run.end.y[i]))) continue;
        fail_msg("SUNDIALS %s: masked norm %d of an error test of order %d is not of the error of "
                 "order %d, which next() in src/ida/error_test.c takes it for",
                 SUNDIALS_VERSION, call + 1, run.order, order);
    }
}

/* IDA's test is C |e| <= 1, C as src/ida/jumps.c says. */
static void assert_tested(bool failed)
{
    const double h = run.end.t - run.past[0].t;
    double last = 0.0, sum = 0.0;
    for (int j = 0; j <= run.order; ++j) {
        last = h / (run.end.t - run.past[j].t);
        if (j < run.order) sum += last - 1.0 / (j + 1);
    }
    const double error = fmax(last, fabs(last + sum)) * run.norm;
    if (failed ? error > 1.0 - 1e-9 : error < 1.0 + 1e-9) return;
    fail_msg("SUNDIALS %s: a test of order %d has %s with an error of %g by the constant of "
             "src/ida/jumps.c",
             SUNDIALS_VERSION, run.order, failed ? "failed" : "passed", error);
}

/* An attempt has ended, and what it has asked for is what it should. */
static void end_attempt(void)
{
    long failures = 0;
    if (!run.open || run.asked == 0) return;
    IDAGetNumErrTestFails(run.memory, &failures);
    const bool failed = failures > run.failed;
    const int least_asked = least(run.order, 3), most = failed ? least_asked : least_asked + 1;
    run.open = false;
    if (run.known < PAST) return; /* the start has points of its own */
    if (run.asked < least_asked || run.asked > most)
        fail_msg("SUNDIALS %s: an error test of order %d has asked for %d masked norms, and not "
                 "for %d%s: see next() in "
                 "src/ida/error_test.c",
                 SUNDIALS_VERSION, run.order, run.asked, least_asked, failed ? "" : " or one more");
    for (int call = 0; call < least_asked; ++call) assert_asked(call, run.order - call);
    if (run.asked > least_asked) assert_asked(least_asked, run.order + 1);
    assert_tested(failed);
    run.failures += failed;
}

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user)
{
    (void)t;
    (void)user;
    const double *a = NV_DATA_S(y), *b = NV_DATA_S(yp);
    NV_DATA_S(F)[0] = b[0] - a[1];
    NV_DATA_S(F)[1] = b[1] - 8.0 * (1.0 - a[0] * a[0]) * a[1] + a[0];
    end_attempt();
    run.open = true;
    run.asked = 0;
    return 0;
}

static double scripted(int call)
{
    if (call == 0) return run.script.of_order;
    if (call == 1 && run.order > 1) return run.script.below;
    return call == 2 && run.order > 2 ? run.script.two_below : run.script.above;
}

static sunrealtype norm(N_Vector x, N_Vector w, N_Vector id)
{
    double result = masked(x, w, id);
    if (!run.open || run.asked == ASKED) return result;
    if (run.asked == 0) {
        N_Vector y = NULL;
        IDAGetCurrentOrder(run.memory, &run.order);
        IDAGetNumErrTestFails(run.memory, &run.failed);
        IDAGetCurrentY(run.memory, &y);
        IDAGetCurrentTime(run.memory, &run.end.t);
        memcpy(run.end.y, NV_DATA_S(y), sizeof run.end.y);
    }
    const double wanted = scripted(run.asked);
    if (!isnan(wanted)) result = wanted;
    memcpy(run.x[run.asked], NV_DATA_S(x), sizeof run.x[0]);
    if (run.asked++ == 0) run.norm = result;
    return result;
}

static void drop_message(void *user, int code, const char *message)
{
    (void)user;
    (void)code;
    (void)message;
}

/* A run of such tolerances and order begins. */
static void begin(double tolerance, int order, script s)
{
    run = (watched){.messages = {drop_message, NULL}, .script = s};
    assert_true(mbsri_ida_context(&run.context, &run.messages));
    N_Vector *const vector[] = {&run.y, &run.yp, &run.id};
    for (int k = 0; k < 3; ++k) *vector[k] = N_VNew_Serial(SIZE, run.context);
    masked = run.y->ops->nvwrmsnormmask;
    run.y->ops->nvwrmsnormmask = norm;
    NV_DATA_S(run.y)[0] = 2.0;
    NV_DATA_S(run.y)[1] = 0.0;
    NV_DATA_S(run.yp)[0] = 0.0;
    NV_DATA_S(run.yp)[1] = -2.0;
    N_VConst(1.0, run.id);
    run.memory = IDACreate(run.context);
    run.matrix = SUNDenseMatrix(SIZE, SIZE, run.context);
    run.solver = SUNLinSol_Dense(run.y, run.matrix, run.context);
    assert_int_equal(IDAInit(run.memory, residual, 0.0, run.y, run.yp), IDA_SUCCESS);
    IDASStolerances(run.memory, tolerance, tolerance);
    IDASetId(run.memory, run.id);
    IDASetSuppressAlg(run.memory, SUNTRUE);
    IDASetLinearSolver(run.memory, run.solver, run.matrix);
    IDASetMaxOrd(run.memory, order);
}

/* One step; its length. */
static double step(void)
{
    double t = 0.0, h = 0.0;
    assert_int_equal(IDASolve(run.memory, 1e9, &t, run.y, run.yp, IDA_ONE_STEP), IDA_SUCCESS);
    end_attempt();
    run.open = false;
    IDAGetLastStep(run.memory, &h);
    for (int k = PAST - 1; k > 0; --k) run.past[k] = run.past[k - 1];
    run.past[0].t = t;
    memcpy(run.past[0].y, NV_DATA_S(run.y), sizeof run.past[0].y);
    run.known = least(run.known + 1, PAST);
    return h;
}

static void end(void)
{
    IDAFree(&run.memory);
    SUNLinSolFree(run.solver);
    SUNMatDestroy(run.matrix);
    N_VDestroy(run.y);
    N_VDestroy(run.yp);
    N_VDestroy(run.id);
    SUNContext_Free(&run.context);
}

/* Of an error test of order k: k, k - 1, k - 2 and, if it is passed and the order may rise, k + 1.
 */
static void norms_are_asked_for_from_the_order_down_then_above(void **state)
{
    (void)state;
    static const double tolerance[] = {1e-2, 1e-4, 1e-7};
    int seen[7] = {0}, failures = 0;
    for (int r = 0; r < 3; ++r) {
        begin(tolerance[r], 5, as_they_are);
        for (int k = 0; k < 600; ++k) step();
        for (int k = 0; k < 7; ++k) seen[k] += run.seen[k];
        failures += run.failures;
        end();
    }
    for (int order = 1; order <= 5; ++order) assert_true(seen[order] > 30);
    assert_true(failures > 30);
}

static int order_after(int steps)
{
    int order = 0;
    for (int k = 0; k < steps; ++k) step();
    IDAGetCurrentOrder(run.memory, &order);
    return order;
}

/* hold() in src/ida/error_test.c. */
static void a_norm_of_seven_tenths_keeps_the_step_at_order_one(void **state)
{
    (void)state;
    begin(1e-4, 5, (script){0.7, 0.0, 0.0, 1e10});
    assert_int_equal(order_after(20), 1);
    const double h = step();
    for (int k = 0; k < 20; ++k) {
        if (step() == h) continue;
        fail_msg("SUNDIALS %s: a norm of 0.7 changes the step at order 1", SUNDIALS_VERSION);
    }
    end();
}

/* tested_norm() in src/ida/error_test.c. */
static void an_order_falls_only_where_the_error_below_is_no_larger(void **state)
{
    (void)state;
    static const struct {
        script norms;
        int most, after;
        const char *what;
    } cases[] = {{{0.3, 1e10, 1e10, 1e10}, 2, 2, "falls to an order of a large error"},
                 {{0.3, 0.0, 1e10, 1e10}, 2, 1, "does not fall to 1 where that is without error"},
                 {{0.3, 0.15, 0.15, 1e10}, 5, 1, "does not fall to orders of half the error"},
                 {{0.3, 1e10, 1e10, 0.0}, 5, 5, "does not rise to an order without error"}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        begin(1e-4, cases[c].most, cases[c].norms);
        if (order_after(40) != cases[c].after)
            fail_msg("SUNDIALS %s: the order %s", SUNDIALS_VERSION, cases[c].what);
        end();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(norms_are_asked_for_from_the_order_down_then_above),
        cmocka_unit_test(a_norm_of_seven_tenths_keeps_the_step_at_order_one),
        cmocka_unit_test(an_order_falls_only_where_the_error_below_is_no_larger)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
