/* Mechanisms of everything at once: vector code beside the ways that take any kind of body, and
 * both beside dense equations.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "kernels.h"
#include "loops.h"
#include "medley_equations.h"
#include "newton_system.h"

#include "model/record.h"
#include "sweeps/loops.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

/* What was compared. */
typedef struct tally {
    int models, residuals, forward, inverse, reports, started, systems, vector_code;
} tally;

static void expect_below(const medley *s, const char *what, double value, double limit)
{
    if (value < limit) return;
    print_error("seed %d, %d bodies: %s: %.3g, expected below %.3g\n", (int)s->c.seed, s->bodies,
                what, value, limit);
    fail();
}

static void expect_status(const medley *s, const char *what, int status, int expected)
{
    if (status == expected) return;
    print_error("seed %d, %d bodies: %s: %s, expected %s: %s\n", (int)s->c.seed, s->bodies, what,
                mbsr_status_name(status), mbsr_status_name(expected), mbsr_data_error(s->d)->text);
    fail();
}

static double *numbers(size_t count)
{
    double *x = calloc(count + 1, sizeof *x);
    for (size_t k = 0; k < count; ++k) x[k] = NAN; /* to be written, or seen */
    return x;
}

static double distance(int n, const double *a, const double *b)
{
    double off = 0.0;
    for (int k = 0; k < n; ++k)
        off = a[k] - b[k] == a[k] - b[k] ? fmax(off, fabs(a[k] - b[k])) : NAN;
    return off;
}

/* Without its plan of loops a model is left to the way for any kind of body. */
static mbsri_sweep_loops *hide_plan(const medley *s)
{
    mbsri_sweep_loops *plan = s->m->tree.evaluated ? s->m->tree.evaluated->loops : NULL;
    if (plan) s->m->tree.evaluated->loops = NULL;
    return plan;
}

static void show_plan(const medley *s, mbsri_sweep_loops *plan)
{
    if (plan) s->m->tree.evaluated->loops = plan;
}

/* ---- the residual ---- */

/* By every kernel as by the stages. */
static void check_residual(const medley *s, test_rng *rng, tally *all)
{
    const size_t size = (size_t)s->size;
    double *y = numbers(4 * size), *yp = y + size, *F = yp + size, *stages = F + size;
    test_fill(rng, s->size, y);
    test_fill(rng, s->size, yp);
    for (int k = 0; k < s->nq; ++k) y[k] = s->q[k];
    const test_hidden trees = test_hide_sweeps(s->m);
    expect_status(s, "residual by stages",
                  mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, stages), MBSR_OK);
    test_show_sweeps(s->m, trees);
    const mbsri_sweep_kernels *kernels[2] = {NULL};
    const int count = s->m->tree.evaluated ? test_kernels(kernels) : 1;
    for (int k = count - 1; k >= 0; --k) {
        if (s->m->tree.evaluated) s->m->tree.evaluated->kernels = kernels[k];
        expect_status(s, "residual",
                      mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, F), MBSR_OK);
        expect_below(s, "residual", distance(s->size, F, stages),
                     1e-10 * (1.0 + test_largest(s->size, stages)));
        ++all->residuals;
    }
    free(y);
}

/* ---- forward and inverse dynamics ---- */

/* How far a result may be from the dense equations. */
static double limit_of(const medley_equations *e)
{
    const double size = 1.0 + test_largest(e->N, e->x);
    return size * (1e-9 + e->noise) / fmin(1.0, 30.0 * e->worst);
}

/* By both ways; the dense equations are solved with this tau. */
static void compare_forward(const medley *s, const medley_equations *e, const double *tau,
                            tally *all)
{
    double *udot = numbers((size_t)(s->nu + s->rows)), *lambda = udot + s->nu;
    const double size = 1.0 + test_largest(e->N, e->x);
    for (int way = 0; way < 2 && e->clear; ++way) {
        mbsri_sweep_loops *plan = way == 0 ? NULL : hide_plan(s);
        const int status = mbsr_forward_dynamics(s->m, s->d, s->t, s->q, s->u, tau, udot);
        show_plan(s, plan);
        if (e->moves) {
            expect_status(s, "forward dynamics", status, MBSR_UNDETERMINED);
        } else if (e->left > 1e-3 * size) {
            expect_status(s, "forward dynamics", status, MBSR_LOOP_OPEN);
        } else if (e->left < 1e-12 * size) {
            expect_status(s, "forward dynamics", status, MBSR_OK);
            assert_ok(mbsr_closures_lambda(s->m, s->d, lambda), mbsr_data_error(s->d));
            expect_below(s, "accelerations", distance(s->nu, udot, e->x), limit_of(e));
            expect_below(s, "loop forces", medley_forces_off(s, e, lambda, 1.0), limit_of(e));
            ++all->forward;
        }
    }
    free(udot);
}

static void check_forward(const medley *s, test_rng *rng, tally *all)
{
    double *tau = numbers((size_t)s->nu);
    medley_equations e;
    medley_find_equations(s, &e);
    test_fill(rng, s->nu, tau);
    for (int k = 0; k < s->nu; ++k) e.g[k] += tau[k];
    for (int k = 0; k < e.m; ++k) e.bias[k] = -e.bias[k];
    medley_solve(&e, e.M, e.g, e.bias);
    compare_forward(s, &e, tau, all);
    medley_free_equations(&e);
    free(tau);
}

/* Motors on `some` of ten joint rates. */
static void check_inverse(const medley *s, test_rng *rng, int some, tally *all)
{
    const size_t n = (size_t)s->nu;
    double *udot = numbers(3 * n + (size_t)s->rows), *need = udot + n, *tau = need + n,
           *lambda = tau + n, *P = calloc(n * n + 1, sizeof *P);
    int *actuated = calloc(n + 1, sizeof *actuated), count = 0;
    medley_equations e;
    test_fill(rng, s->nu, udot);
    for (int k = 0; k < s->nu; ++k) {
        if (test_integer(rng, 0, 9) < some) actuated[count++] = k, P[k * (s->nu + 1)] = 1.0;
    }
    medley_find_equations(s, &e);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, s->t, s->q, s->u, udot, NULL, need), NULL);
    medley_solve(&e, P, need, NULL);
    const double size = 1.0 + test_largest(s->nu, need);
    for (int way = 0; way < 2 && e.clear; ++way) {
        mbsri_sweep_loops *plan = way == 0 ? NULL : hide_plan(s);
        const int status = loops_inverse_dynamics(s->m, s->d, s->t, s->q, s->u, udot, count,
                                                  actuated, tau, lambda);
        show_plan(s, plan);
        if (e.left > 1e-4 * size) {
            expect_status(s, "inverse dynamics", status, MBSR_UNDETERMINED);
        } else if (e.left < 1e-11 * test_largest(s->nu, need)) {
            expect_status(s, "inverse dynamics", status, MBSR_OK);
            for (int k = 0; k < s->nu; ++k) e.x[k] *= P[k * (s->nu + 1)];
            expect_below(s, "motors", distance(s->nu, tau, e.x), limit_of(&e));
            expect_below(s, "loop forces", medley_forces_off(s, &e, lambda, -1.0), limit_of(&e));
            ++all->inverse;
        }
    }
    medley_free_equations(&e);
    free(udot);
    free(P);
    free(actuated);
}

/* ---- rows, reactions, reports ---- */

/* Forces and moments of one closure on its bodies, as joint forces. */
static void add_reactions(const medley *s, int closure, double *J, double *sum)
{
    mbsr_closure_def def;
    assert_ok(mbsr_closure_definition(s->m, closure, &def), NULL);
    for (int place = 0; place < def.bodies; ++place) {
        const int id = def.body[place], d = mbsr_body_dimension(s->m, id);
        double f[6] = {0.0}, tau[6] = {0.0};
        int u, n;
        if (id < 0) continue;
        assert_ok(mbsr_closure_reaction(s->m, s->d, closure, place, f, tau), mbsr_data_error(s->d));
        assert_ok(mbsr_body_jacobian(s->m, s->d, id, J), mbsr_data_error(s->d));
        assert_ok(mbsr_body_coordinates(s->m, id, NULL, NULL, &u, &n), NULL);
        for (int k = 0; k < s->nu; ++k)
            for (int l = 0; l < d; ++l) sum[k] += J[k * d + l] * f[l];
        for (int k = 0; k < n; ++k) sum[u + k] += tau[k];
    }
}

/* Transposed rows are what is applied, and the reactions of all closures together. */
static void check_rows(const medley *s, test_rng *rng)
{
    const size_t n = (size_t)s->nu, r = (size_t)s->rows;
    double *x = numbers(2 * n + 2 * r), *y = x + n, *lambda = y + r, *z = lambda + r,
           *sum = calloc(n + 1, sizeof *sum), *J = numbers(6 * n), one = 0.0, two = 0.0;
    const mbsr_error *error = mbsr_data_error(s->d);
    test_fill(rng, s->nu, x);
    test_fill(rng, s->rows, lambda);
    assert_ok(mbsr_stage_positions(s->m, s->d, s->t, s->q), error);
    assert_ok(mbsr_stage_velocities(s->m, s->d, s->u), error);
    assert_ok(mbsr_closures_apply(s->m, s->d, x, y), error);
    assert_ok(mbsr_closures_transpose(s->m, s->d, lambda, z), error);
    for (int k = 0; k < s->rows; ++k) one += y[k] * lambda[k];
    for (int k = 0; k < s->nu; ++k) two += x[k] * z[k];
    expect_below(s, "transposed rows", fabs(one - two), 1e-11 * (1.0 + test_largest(s->nu, z)));
    assert_ok(mbsr_closures_set_lambda(s->m, s->d, lambda), error);
    assert_ok(mbsr_stage_forces(s->m, s->d, NULL), error);
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) add_reactions(s, c, J, sum);
    expect_below(s, "reactions", distance(s->nu, sum, z), 1e-11 * (1.0 + test_largest(s->nu, z)));
    assert_ok(mbsr_closures_mobility(s->m, s->d, x), error);
    expect_below(s, "mobility", test_largest(s->nu, x), INFINITY);
    free(x);
    free(sum);
    free(J);
}

static void check_report(const medley *s, tally *all)
{
    mbsr_closure_report r;
    int *redundant = calloc((size_t)(2 * s->rows) + 1, sizeof *redundant), dependent = 0;
    expect_status(s, "report",
                  mbsr_closures_report(s->m, s->d, s->t, s->q, &r, redundant, redundant + s->rows),
                  MBSR_OK);
    for (int k = 0; k < s->rows; ++k) dependent += redundant[k];
    assert_int_equal(r.rows, s->rows);
    assert_int_equal(r.mobility, s->nu - r.independent - r.undetermined);
    assert_true(r.nearby >= r.independent);
    if (s->c.stiff == 0.0) assert_int_equal(dependent + r.nearby, s->rows);
    const double found[] = {r.smallest_kept, r.largest_dropped, r.gap, r.stretch};
    expect_below(s, "report", test_largest(4, found), INFINITY);
    ++all->reports;
    free(redundant);
}

/* ---- Newton systems ---- */

static mbsr_newton *solver(const medley *s, int by_blocks)
{
    mbsr_newton *newton;
    mbsr_error error;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = by_blocks;
    opt.products = 1;
    const int status = mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, &opt, &newton, &error);
    if (status != MBSR_ERR_SPACE)
        assert_ok(status, &error); /* a closure that reads quaternions' rates */
    return newton;
}

/* The matrix, column by column, as the products know it; as one that c does not change. */
static void take_matrix(const medley *s, mbsr_newton *newton, test_newton_state *at, double c)
{
    double *e = calloc((size_t)s->size + 1, sizeof *e);
    assert_ok(mbsr_newton_linearise(newton, s->d, s->t, at->y, at->yp, c),
              mbsr_newton_error(newton));
    for (int j = 0; j < s->size; ++j) {
        e[j] = 1.0;
        assert_ok(mbsr_newton_multiply(newton, e, at->A + j * s->size), NULL);
        e[j] = 0.0;
    }
    free(e);
}

/* Solutions by both, beside each other and the dense matrix. */
static void compare_solvers(const medley *s, mbsr_newton *const newton[2], test_newton_state *at,
                            double c, test_rng *rng, tally *all)
{
    const size_t n = (size_t)s->size;
    double *r = numbers(3 * n), *x[2] = {r + n, r + 2 * n};
    int status[2];
    mbsr_newton_info info;
    test_fill(rng, s->size, r);
    for (int k = 0; k < 2; ++k) {
        status[k] = mbsr_newton_factor(newton[k], s->d, s->t, at->y, at->yp, c);
        if (!status[k])
            assert_ok(mbsr_newton_solve(newton[k], r, x[k]), mbsr_newton_error(newton[k]));
    }
    expect_status(s, "Newton system", status[0], status[1]);
    assert_ok(mbsr_newton_get_info(newton[0], &info), NULL);
    if (!status[0] && info.vector_code && s->size < 250) {
        take_matrix(s, newton[1], at, c);
        const test_newton_errors e = test_newton_compare(at, 0.0, r, x[1]);
        /* slopes by differences, and springs of 1e10 N/m, cost either of them digits */
        const double lost = 1e-8 * (1.0 + e.amplification) + 100.0 * e.delta + 1e3 * e.row;
        expect_below(s, "Newton solution", test_newton_distance(at, x[0], x[1]), lost);
        ++all->vector_code;
    }
    ++all->systems;
    free(r);
}

static void check_newton(const medley *s, test_newton_state *at, test_rng *rng, tally *all)
{
    static const double factors[] = {1.0, 300.0, 1e5, -30.0};
    mbsr_newton *newton[2] = {solver(s, 0), solver(s, 1)};
    for (int k = 0; k < 4 && newton[0] && newton[1]; ++k)
        compare_solvers(s, newton, at, factors[k], rng, all);
    mbsr_newton_destroy(newton[0]);
    mbsr_newton_destroy(newton[1]);
}

/* Where rows that depend on each other let no start be, there is no report either. */
static void expect_contradiction(const medley *s)
{
    mbsr_index_report *report;
    expect_status(s, "report beside a start without",
                  mbsr_index_report_create(s->m, s->d, s->t, s->q, s->u, &report), MBSR_LOOP_OPEN);
}

/* A start satisfies the equations; dynamics and Newton systems there. */
static void check_start(medley *s, test_rng *rng, tally *all)
{
    test_newton_state at;
    double *F = numbers((size_t)s->size);
    const int status = test_newton_start(&at, s->m, s->d, s->t, s->q, s->u, NULL);
    if (status == MBSR_OK) {
        medley_equations e;
        medley_find_equations(s, &e);
        assert_ok(mbsr_dae_residual(s->m, s->d, at.form, s->t, at.y, at.yp, F),
                  mbsr_data_error(s->d));
        const double size = 1.0 + test_largest(s->size, at.yp);
        expect_below(s, "residual of a start", test_largest(s->size, F), (1e-8 + e.noise) * size);
        medley_free_equations(&e);
        assert_ok(mbsr_dae_unpack(s->m, s->d, at.form, s->t, at.y, s->q, s->u), NULL);
        check_forward(s, rng, all);
        check_inverse(s, rng, 7, all);
        if (size < 1e6) check_newton(s, &at, rng, all);
        ++all->started;
    } else {
        if (status == MBSR_LOOP_SINGULAR)
            expect_contradiction(s);
        else if (status != MBSR_LOOP_OPEN && status != MBSR_UNDETERMINED)
            expect_status(s, "start", status, MBSR_NO_CONVERGENCE);
    }
    test_newton_free(&at);
    free(F);
}

/* ---- tests ---- */

static void check(uint64_t seed, tally *all)
{
    medley s;
    test_rng rng = test_seed(seed + 77);
    const medley_choice c = medley_choose(seed);
    if (medley_make(&s, &c)) {
        check_residual(&s, &rng, all);
        check_forward(&s, &rng, all);
        check_inverse(&s, &rng, 3, all);
        check_inverse(&s, &rng, 10, all);
        check_rows(&s, &rng);
        check_report(&s, all);
        check_start(&s, &rng, all);
        ++all->models;
    }
    medley_free(&s);
}

static void small_mechanisms(void **state)
{
    (void)state;
    /* held bodies and couplings beside blocks, in trees partly in vector code; rounding in forces
     * that move nothing, where these meet others; a pivot of 1e-12 */
    static const uint64_t more[] = {55, 199, 214, 283, 431, 878, 917, 3835};
    const int seeds = test_long() ? 4000 : test_seeds(20, 40),
              others = (int)(sizeof more / sizeof more[0]);
    tally all = {0};
    for (int k = 1; k <= seeds; ++k) check((uint64_t)k, &all);
    for (int k = 0; k < others; ++k) check(more[k], &all);
    assert_true(all.models > 0.9 * seeds && all.residuals > all.models);
    assert_true(all.forward > all.models / 2 && all.inverse > all.models / 2);
    assert_true(all.started > all.models / 2);
    assert_true(all.vector_code > all.systems / 3 && all.vector_code < all.systems);
}

/* Residual, factor and solution of a tree with short loops; whether its rows are independent, and
 * it is not so long a chain that no solution is known. */
static bool check_large(uint64_t seed, tally *all)
{
    medley s;
    test_rng rng = test_seed(seed);
    int status[2];
    const medley_choice c = {.seed = seed,
                             .family = (medley_family)(seed % 3),
                             .bodies = 2001 + (int)seed,
                             .closures = 10 + (int)seed % 4 * 10,
                             .stiff = 0.1,
                             .local = true};
    if (!medley_make(&s, &c)) {
        medley_free(&s);
        return false;
    }
    double *y = numbers(5 * (size_t)s.size), *yp = y + s.size, *r = yp + s.size,
           *x[2] = {r + s.size, r + 2 * s.size};
    check_residual(&s, &rng, all);
    for (int k = 0; k < 2 * s.size; ++k) y[k] = 1e-3 * test_uniform(&rng);
    for (int k = 0; k < s.nq; ++k) y[k] = s.q[k];
    test_fill(&rng, s.size, r);
    for (int k = 0; k < 2; ++k) {
        mbsr_newton *newton = solver(&s, k);
        status[k] = mbsr_newton_factor(newton, s.d, s.t, y, yp, 1e4);
        if (!status[k]) assert_ok(mbsr_newton_solve(newton, r, x[k]), mbsr_newton_error(newton));
        mbsr_newton_destroy(newton);
    }
    expect_status(&s, "Newton system", status[0], status[1]);
    const double size = status[0] ? INFINITY : test_largest(s.size, x[1]);
    if (size < 1e6) expect_below(&s, "Newton solution", distance(s.size, x[0], x[1]), 1e-9 * size);
    free(y);
    medley_free(&s);
    return size < 1e6;
}

/* So many bodies that what is read soon is asked for beforehand. */
static void large_trees(void **state)
{
    (void)state;
    static const uint64_t some[] = {4, 9, 16, 17};
    tally all = {0};
    for (int k = 0; k < 4; ++k) assert_true(check_large(some[k], &all));
    for (uint64_t seed = 1; test_long() && seed <= 60; ++seed) (void)check_large(seed, &all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(large_trees),
                                       cmocka_unit_test(small_mechanisms)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
