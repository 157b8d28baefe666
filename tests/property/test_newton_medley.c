/* Newton systems of mechanisms of everything at once, in vector code where that serves, and by the
 * front: A (A^-1 v) = v row by row, with A from products, which eliminate nothing; the same of A^T;
 * and refused where A is singular, nowhere else.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "medley.h"
#include "newton_system.h"
#include "oracle.h"

#include "model/record.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t length_u, size_t length_vt);

typedef struct solver {
    mbsr_newton *newton;
    double share;    /* of what is added up in a row */
    bool transposes; /* it solves transposed systems as well */
    double c;        /* of the last factorisation */
} solver;

typedef struct tally {
    int systems, solved, refused, closed;
    int loops_back; /* closed, solved transposed in vector code */
} tally;

static void take_matrix(const medley *s, mbsr_newton *newton, double *A)
{
    double *e = calloc((size_t)s->size + 1, sizeof *e);
    for (int j = 0; j < s->size; ++j) {
        e[j] = 1.0;
        assert_ok(mbsr_newton_multiply(newton, e, A + j * s->size), mbsr_newton_error(newton));
        e[j] = 0.0;
    }
    free(e);
}

/* Rows, then columns of A to a largest entry of 1, a few times. */
static void equilibrate(int n, double *A)
{
    for (int round = 0; round < 20; ++round) {
        for (int i = 0; i < n; ++i) {
            double row = 0.0, column = 0.0;
            for (int j = 0; j < n; ++j) row = fmax(row, fabs(A[j * n + i]));
            for (int j = 0; j < n && row > 0.0; ++j) A[j * n + i] /= sqrt(row);
            for (int j = 0; j < n; ++j) column = fmax(column, fabs(A[i * n + j]));
            for (int j = 0; j < n && column > 0.0; ++j) A[i * n + j] /= sqrt(column);
        }
    }
}

/* The least singular value over the largest of A, whose rows and columns are scaled; A gets lost.
 */
static double least_singular_value(int n, double *A)
{
    const int work_size = 10 * n;
    double *s = calloc(11 * (size_t)n + 1, sizeof *s), *work = s + n;
    int info = 0;
    equilibrate(n, A);
    dgesvd_("N", "N", &n, &n, A, &n, s, NULL, &n, NULL, &n, work, &work_size, &info, 1, 1);
    const double least = info == 0 ? s[n - 1] / s[0] : 0.0;
    free(s);
    return least;
}

/* ---- what cancels within an entry ---- */

/* Above the body where a loop closes, what a row exerts on joints is the sum over its ends, which
 * cancels to rounding: entries of A that are nothing, times unknowns as large as stiffnesses.
 * Rounding of 1e-13 of what the ends exert stands beside errors of 1e-9 of |A| |x|. */
static const double ROUNDING = 1e-13 / 1e-9;

typedef struct ends {
    double *size;     /* rows x nu: what the ends exert on joint rates, added up by size */
    double *growth;   /* rows: dlambda over the unknown of the row */
    int *position;    /* rows: the position row's place, -1: it has none */
    double rate;      /* of the motion, in rad/s */
    double push;      /* of eta on q', over what it exerts */
    int nq, nu, rows; /* of the model */
} ends;

/* What a closure exerts on its body of one place, in joint rates. */
static void add_end(const medley *s, int closure, int place, int id, double *J, double *row)
{
    double f[6] = {0.0}, tau[6] = {0.0};
    int u, n;
    if (id < 0) return;
    const int d = mbsr_body_dimension(s->m, id);
    assert_ok(mbsr_closure_reaction(s->m, s->d, closure, place, f, tau), mbsr_data_error(s->d));
    assert_ok(mbsr_body_jacobian(s->m, s->d, id, J), mbsr_data_error(s->d));
    assert_ok(mbsr_body_coordinates(s->m, id, NULL, NULL, &u, &n), NULL);
    for (int k = 0; k < s->nu; ++k) {
        for (int l = 0; l < d; ++l) row[k] += fabs(J[k * d + l] * f[l]);
    }
    for (int k = 0; k < n; ++k) row[u + k] += fabs(tau[k]);
}

static void add_row(const medley *s, int closure, int row, double *J, double *lambda, double *size)
{
    const mbsr_error *error = mbsr_data_error(s->d);
    mbsr_closure_def def;
    assert_ok(mbsr_closure_definition(s->m, closure, &def), NULL);
    lambda[row] = 1.0;
    assert_ok(mbsr_closures_set_lambda(s->m, s->d, lambda), error);
    assert_ok(mbsr_stage_forces(s->m, s->d, NULL), error);
    lambda[row] = 0.0;
    for (int k = 0; k < def.bodies; ++k) add_end(s, closure, k, def.body[k], J, size);
}

/* At the state y, for the factor c; free size. */
static ends take_ends(const medley *s, const double *y, double c)
{
    const size_t nu = (size_t)s->nu, rows = (size_t)s->rows;
    ends e = {.nq = s->nq, .nu = s->nu, .rows = s->rows};
    e.size = calloc(rows * (nu + 3) + 6 * nu + 1, sizeof *e.size);
    e.growth = e.size + rows * nu;
    e.position = (int *)(void *)(e.growth + rows);
    double *lambda = e.growth + 2 * rows, *J = lambda + rows;
    e.push = fabs(c) * test_largest(s->nu, s->m->typical.weight);
    e.rate = 1.0 + test_largest(s->nu, y + s->nq + s->nu);
    assert_ok(mbsr_stage_positions(s->m, s->d, s->t, y), mbsr_data_error(s->d));
    assert_ok(mbsr_stage_velocities(s->m, s->d, y + s->nq + s->nu), mbsr_data_error(s->d));
    for (int id = 0; id < mbsr_model_closures(s->m); ++id) {
        int row, count, position, positions;
        mbsr_closure_def def;
        assert_ok(mbsr_closure_definition(s->m, id, &def), NULL);
        assert_ok(mbsr_closure_indices(s->m, id, &row, &count, &position, &positions), NULL);
        for (int k = 0; k < count; ++k) {
            const double stiffness = def.stiffness[k], damping = def.damping[k];
            e.growth[row + k] = stiffness > 0.0 ? 1.0 + fabs(c) * damping / stiffness : fabs(c);
            e.position[row + k] = k < positions ? position + k : -1;
            add_row(s, id, row + k, J, lambda, e.size + (size_t)(row + k) * nu);
        }
    }
    return e;
}

/* The unknown of the position row of row k, or its right-hand side. */
static double held(const ends *e, const double *x, int k)
{
    return e->position[k] < 0 ? 0.0 : fabs(x[e->nq + 2 * e->nu + e->rows + e->position[k]]);
}

/* To the sizes of the rows of A x. */
static void add_ends(const ends *e, const double *x, double *size)
{
    for (int k = 0; k < e->rows; ++k) {
        const double largest = test_largest(e->nu, e->size + k * e->nu);
        for (int j = 0; j < e->nq; ++j) size[j] += ROUNDING * e->push * largest * held(e, x, k);
        const double force = ROUNDING * e->growth[k] * fabs(x[e->nq + 2 * e->nu + k]);
        for (int i = 0; i < e->nu; ++i) {
            size[e->nq + i] += e->size[k * e->nu + i] * force;
            size[e->nq + e->nu + i] += e->size[k * e->nu + i] * force;
        }
    }
}

/* To the sizes of the rows of A' x: rows of closures read rates, and how these and places change
 * with q. */
static void add_ends_transposed(const ends *e, const double *x, double *size)
{
    const int first = e->nq + 2 * e->nu;
    for (int k = 0; k < e->rows; ++k) {
        const double *E = e->size + k * e->nu, rate = ROUNDING * fabs(x[first + k]),
                     largest = test_largest(e->nu, E),
                     read = e->rate * rate + ROUNDING * held(e, x, k);
        for (int i = 0; i < e->nu; ++i) size[e->nq + e->nu + i] += E[i] * rate;
        for (int j = 0; j < e->nq; ++j) size[j] += largest * read;
        if (e->position[k] >= 0)
            size[first + e->rows + e->position[k]] +=
                ROUNDING * e->push * largest * test_largest(e->nq, x);
    }
}

/* ---- solutions ---- */

static void expect_rows(const medley *s, const char *what, double share, const double *a,
                        const double *b, const double *size)
{
    for (int i = 0; i < s->size; ++i) {
        if (fabs(a[i] - b[i]) <= share * size[i]) continue;
        print_error("seed %d: row %d of %d: %s off by %.2e beside %.2e\n", (int)s->c.seed, i,
                    s->size, what, a[i] - b[i], size[i]);
        fail();
    }
}

/* Terms of the rows of A x = v beside those of the dense solution: lost digits make x, and with it
 * all that residuals are compared with, large without bound. */
static void check_size(const medley *s, const double *A, const double *v, const double *size)
{
    const size_t n = (size_t)s->size;
    double *B = malloc((n * n + n + 1) * sizeof *B), *x = B + n * n;
    for (size_t i = 0; i < n; ++i) {
        double largest = 0.0;
        for (size_t j = 0; j < n; ++j) largest = fmax(largest, fabs(A[j * n + i]));
        for (size_t j = 0; j < n; ++j) B[j * n + i] = A[j * n + i] / largest;
        x[i] = v[i] / largest;
    }
    test_solve(s->size, B, x);
    double found = 0.0, dense = 0.0;
    for (size_t i = 0; i < n; ++i) {
        double sum = fabs(v[i]);
        for (size_t j = 0; j < n; ++j) sum += fabs(A[j * n + i] * x[j]);
        dense = fmax(dense, sum);
        found = fmax(found, size[i]);
    }
    if (!(found < 1e3 * dense))
        print_error("seed %d: terms of %.1e, of the dense solution %.1e\n", (int)s->c.seed, found,
                    dense);
    assert_less(found, 1e3 * dense);
    free(B);
}

/* A (A^-1 v) of one factorisation, and products beside A from products, row by row beside what is
 * added up there: |A| |x| + |v| and what cancels within entries. Bodies whose mass is next to
 * nothing, and stiff rows that others repeat, cost digits where nothing is refined. */
static void check_solution(const medley *s, const solver *by, const ends *e, const double *A,
                           const double *v)
{
    mbsr_newton *newton = by->newton;
    const int n = s->size;
    double *x = calloc(4 * (size_t)n + 1, sizeof *x), *r = x + n, *size = r + n, *dense = size + n;
    assert_ok(mbsr_newton_solve(newton, v, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, r), mbsr_newton_error(newton));
    for (int i = 0; i < n; ++i) {
        size[i] = fabs(v[i]);
        for (int j = 0; j < n; ++j) {
            dense[i] += A[j * n + i] * x[j];
            size[i] += fabs(A[j * n + i] * x[j]);
        }
    }
    check_size(s, A, v, size);
    add_ends(e, x, size);
    expect_rows(s, "A x - v", by->share, r, v, size);
    expect_rows(s, "products", 1e-9, r, dense, size);
    free(x);
}

static double dot(int n, const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += a[k] * b[k];
    return sum;
}

/* The same of A^T; and w' A^-1 v = (A^-T w)' v. */
static void check_transposed(const medley *s, const solver *by, const ends *e, const double *A,
                             const double *v)
{
    mbsr_newton *newton = by->newton;
    const int n = s->size;
    double *x = calloc(6 * (size_t)n + 1, sizeof *x), *r = x + n, *size = r + n, *w = size + n,
           *other = w + n, *dense = other + n, sum = 0.0;
    test_rng rng = test_seed(s->c.seed + 17);
    assert_ok(mbsr_newton_solve_transposed(newton, v, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply_transposed(newton, x, r), mbsr_newton_error(newton));
    for (int j = 0; j < n; ++j) {
        size[j] = fabs(v[j]);
        for (int i = 0; i < n; ++i) {
            dense[j] += A[j * n + i] * x[i];
            size[j] += fabs(A[j * n + i] * x[i]);
        }
    }
    add_ends_transposed(e, x, size);
    expect_rows(s, "A' x - v", by->share, r, v, size);
    expect_rows(s, "transposed products", 1e-9, r, dense, size);
    test_fill(&rng, n, w);
    assert_ok(mbsr_newton_solve(newton, w, other), mbsr_newton_error(newton));
    for (int k = 0; k < n; ++k) sum += fabs(v[k] * other[k]) + fabs(x[k] * w[k]);
    assert_less(fabs(dot(n, v, other) - dot(n, x, w)), 1e-6 * sum);
    free(x);
}

/* Steps of the linearised equations: A delta + E h = R tau, by products; and the transpose of that,
 * v' delta = tau_v' tau + h_v' h. */
static void check_steps(const medley *s, const solver *by, const ends *e, const double *A,
                        const double *v)
{
    mbsr_newton *newton = by->newton;
    const mbsr_error *error = mbsr_newton_error(newton);
    const int n = s->size, nu = s->nu;
    double *delta = calloc(8 * (size_t)n + 1, sizeof *delta), *h = delta + n, *tau = h + n,
           *of_h = tau + n, *of_tau = of_h + n, *r = of_tau + n, *size = r + n, *h_v = size + n,
           forth = 0.0, back = 0.0, sum = 0.0;
    test_rng rng = test_seed(s->c.seed + 23);
    test_fill(&rng, n, h);
    test_fill(&rng, nu, tau);
    assert_ok(mbsr_newton_solve_sensitivity(newton, tau, h, delta), error);
    assert_ok(mbsr_newton_multiply(newton, delta, r), error);
    assert_ok(mbsr_newton_multiply_rate(newton, h, of_h), error);
    assert_ok(mbsr_newton_multiply_torque(newton, tau, of_tau), error);
    for (int i = 0; i < n; ++i) {
        r[i] += of_h[i];
        size[i] = fabs(of_h[i]) + fabs(of_tau[i]) + fabs(h[i]);
        for (int j = 0; j < n; ++j)
            size[i] += fabs(A[j * n + i]) * (fabs(delta[j]) + fabs(h[j] / by->c));
    }
    add_ends(e, delta, size);
    add_ends(e, h, size);
    expect_rows(s, "a step", by->share, r, of_tau, size);
    if (by->transposes) {
        assert_ok(mbsr_newton_solve_adjoint(newton, v, of_tau, h_v), error);
        for (int k = 0; k < n; ++k) forth += v[k] * delta[k], sum += fabs(v[k] * delta[k]);
        for (int k = 0; k < n; ++k) back += h_v[k] * h[k], sum += fabs(h_v[k] * h[k]);
        for (int k = 0; k < nu; ++k) back += of_tau[k] * tau[k], sum += fabs(of_tau[k] * tau[k]);
        assert_less(fabs(forth - back), 1e-6 * sum);
    }
    free(delta);
}

static void check_system(const medley *s, solver *by, const double *y, const double *yp, double c,
                         const double *v, tally *all)
{
    mbsr_newton *newton = by->newton;
    const size_t size = (size_t)s->size;
    double *A = calloc(size * size + 1, sizeof *A);
    assert_ok(mbsr_newton_linearise(newton, s->d, s->t, y, yp, c), mbsr_newton_error(newton));
    take_matrix(s, newton, A);
    const int status = mbsr_newton_factor(newton, s->d, s->t, y, yp, c);
    ++all->systems;
    mbsr_newton_info info;
    assert_ok(mbsr_newton_get_info(newton, &info), NULL);
    if (status == MBSR_OK) {
        const ends e = take_ends(s, y, c);
        if (info.exact) check_solution(s, by, &e, A, v);
        by->c = c;
        if (by->transposes && info.exact) {
            check_transposed(s, by, &e, A, v);
            all->loops_back += info.vector_code && s->rows > 0;
        }
        if (info.exact) check_steps(s, by, &e, A, v);
        free(e.size);
        all->solved += info.exact;
    } else {
        const double least = least_singular_value(s->size, A);
        assert_true(status == MBSR_SINGULAR_BLOCK || status == MBSR_LOOP_SINGULAR);
        if (!(least < 1e-11))
            print_error("seed %d, c = %g: %s, sigma %.2e\n", (int)s->c.seed, c,
                        mbsr_newton_error(newton)->text, least);
        assert_less(least, 1e-11);
        ++all->refused;
    }
    free(A);
}

enum way { VECTOR_CODE, FRONT, WAYS };

#if defined(TEST_WITHOUT_VECTORS)
static const bool vectors = false;
#else
static const bool vectors = true;
#endif

/* At a start. */
static void check(uint64_t seed, int way, tally *all)
{
    static const double factors[] = {1.0, 300.0, 1e5, -30.0};
    medley s;
    test_newton_state at;
    test_rng rng = test_seed(seed + 99);
    const medley_choice c = medley_choose(seed);
    if (!medley_make(&s, &c) || s.size > 200) {
        medley_free(&s);
        return;
    }
    /* with transposes, bodies of several kinds are the front's */
    solver by = {.share = way == FRONT ? 1e-9 : 1e-7, .transposes = way == FRONT || seed % 2};
    mbsr_error error;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.transposes = by.transposes;
    opt.by_blocks = way == FRONT;
    opt.products = 1;
    const int served = mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, &opt, &by.newton, &error);
    const int started = test_newton_start(&at, s.m, s.d, s.t, s.q, s.u, NULL);
    if (served == MBSR_OK && started == MBSR_OK && test_largest(s.size, at.yp) < 1e6) {
        double *v = calloc((size_t)s.size + 1, sizeof *v);
        for (int k = 0; k < 4; ++k) {
            test_fill(&rng, s.size, v);
            check_system(&s, &by, at.y, at.yp, factors[k], v, all);
        }
        all->closed += s.rows > 0;
        free(v);
    }
    test_newton_free(&at);
    mbsr_newton_destroy(by.newton);
    medley_free(&s);
}

static void mechanisms_of_everything(void **state)
{
    (void)state;
    /* rows that nearly depend on each other; or do, where rounding leaves a rate with them; small
     * pivots beside large ones to come; stiff rows whose unknowns are large */
    static const uint64_t more[] = {590, 892, 1395, 1725, 414, 858};
    enum { others = sizeof more / sizeof more[0] };
    const int seeds = test_long() ? 400 : test_seeds_short(25, 60);
    for (int way = 0; way < WAYS; ++way) {
        tally all = {0};
        for (int k = 1; k <= seeds; ++k) check((uint64_t)k, way, &all);
        for (int k = 0; k < others; ++k) check(more[k], way, &all);
        assert_true(all.systems > seeds && all.closed > seeds / 4);
        assert_true(all.solved > 0.9 * all.systems);
        assert_in_range(all.refused, 0, all.systems / 50);
        assert_true(way == FRONT || !vectors ? all.loops_back == 0
                                             : all.loops_back > all.closed / 8);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(mechanisms_of_everything)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
