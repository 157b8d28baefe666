/* Derivatives of inverse and forward dynamics of mechanisms of everything at once: against
 * differences of what they are derivatives of, and tangent against adjoint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "medley.h"

#include "rigid_tree.h"

#include "derivatives/record.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

void dgelsy_(const int *m, const int *n, const int *nrhs, double *a, const int *lda, double *b,
             const int *ldb, int *jpvt, const double *rcond, int *rank, double *work,
             const int *lwork, int *info);

enum { LEVELS = 4 };

typedef struct scene {
    medley s;
    test_rigid_tree tree; /* whose model it then is */
    mbsr_derivatives *w;
    test_rng rng;
    bool forward;
    double speed;              /* largest of u' */
    double *load;              /* udot or tau */
    double *dq, *du, *dload;   /* a direction */
    double *q, *u, *at, *qdot; /* displaced */
    double *out, *dlambda;     /* nu, rows: tangents */
    double *sample, *table;    /* nu + rows; LEVELS times that */
} scene;

typedef struct tally {
    int inverse, forward, closed, lambda, refused, by_sweeps;
} tally;

static double *numbers(int count)
{
    return calloc((size_t)count + 1, sizeof(double));
}

static bool open_numbers(scene *z)
{
    const medley *s = &z->s;
    if (mbsr_derivatives_create(s->m, &z->w, NULL) != MBSR_OK) return false;
    double **const of_rates[] = {&z->load, &z->dq, &z->du, &z->dload, &z->u, &z->at, &z->out};
    for (int k = 0; k < 7; ++k) *of_rates[k] = numbers(s->nu);
    z->q = numbers(s->nq);
    z->qdot = numbers(s->nq);
    z->dlambda = numbers(s->rows);
    z->sample = numbers(s->nu + s->rows);
    z->table = numbers(LEVELS * (s->nu + s->rows));
    return true;
}

static bool open_scene(scene *z, uint64_t seed)
{
    medley_choice c = medley_choose(seed);
    if (seed % 3 == 0) c.closures = 0;
    *z = (scene){.rng = test_seed(seed + 7)};
    if (!medley_make(&z->s, &c) || z->s.nu > 150) return false;
    return open_numbers(z);
}

/* Long chains, whose matrices are found by sweeps, have numbers from here on; one is a tree of more
 * rates than there are rows for. */
enum { LONG_CHAINS = 1000, LARGE_TREE = LONG_CHAINS + 6 };

static int bodies_of(uint64_t seed, test_rng *rng)
{
    if (seed == LARGE_TREE) return 210;
    return seed > LONG_CHAINS ? 60 : test_integer(rng, 2, 14);
}

/* A tree of rigid bodies; massless ones, particles and rods make mass matrices too near to singular
 * for differences. */
static bool open_tree(scene *z, uint64_t seed, bool forward)
{
    test_rng rng = test_seed(seed + 77);
    const test_rigid_choice c = {.seed = seed,
                                 .bodies = bodies_of(seed, &rng),
                                 .massless = seed % 4 == 0 && !forward ? 0.2 : 0.0,
                                 .points = seed % 3 == 0 && !forward ? 0.2 : 0.0,
                                 .many = seed % 2 == 0 ? 0.6 : 0.1,
                                 .branching = seed > LONG_CHAINS && seed != LARGE_TREE ? 0.0 : 0.4,
                                 .floating = seed % 5 == 0,
                                 .length = 1.0,
                                 .moving = seed % 7 == 0,
                                 .shuffle = seed % 6 == 0,
                                 .forces = seed % 2 == 1,
                                 .held = seed % 8 == 0 ? 0.2 : 0.0,
                                 .armature = seed % 4 == 1 ? 0.4 : 0.0};
    *z = (scene){.rng = test_seed(seed + 7)};
    test_rigid_tree *tree = &z->tree;
    test_rigid_tree_make(tree, c);
    z->s = (medley){.c = {.seed = seed},
                    .m = tree->model,
                    .d = tree->data,
                    .bodies = c.bodies,
                    .nq = tree->nq,
                    .nu = tree->nu,
                    .t = tree->t,
                    .q = tree->q,
                    .u = tree->u};
    return open_numbers(z);
}

static void close_scene(scene *z)
{
    double *const all[] = {z->load, z->dq, z->du,   z->dload,   z->u,      z->at,
                           z->out,  z->q,  z->qdot, z->dlambda, z->sample, z->table};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; ++k) free(all[k]);
    mbsr_derivatives_destroy(z->w);
    if (z->tree.model)
        test_rigid_tree_free(&z->tree);
    else
        medley_free(&z->s);
}

/* The result, and loop forces, at a state displaced by h. */
static int evaluate(scene *z, double h, double *out)
{
    const medley *s = &z->s;
    for (int k = 0; k < s->nq; ++k) z->q[k] = s->q[k] + h * z->qdot[k];
    for (int k = 0; k < s->nu; ++k) {
        z->u[k] = s->u[k] + h * z->du[k];
        z->at[k] = z->load[k] + h * z->dload[k];
    }
    for (int k = 0; k < s->rows; ++k) out[s->nu + k] = 0.0;
    int status = mbsr_normalise(s->m, s->d, z->q);
    if (status) return status;
    if (!z->forward) return mbsr_inverse_dynamics(s->m, s->d, s->t, z->q, z->u, z->at, NULL, out);
    status = mbsr_forward_dynamics(s->m, s->d, s->t, z->q, z->u, z->at, out);
    if (status || s->rows == 0) return status;
    return mbsr_closures_lambda(s->m, s->d, out + s->nu);
}

/* Richardson's differences into the last line of the table; how far its last two entries disagree.
 */
static int differences(scene *z, double *doubt)
{
    const int n = z->s.nu + z->s.rows;
    for (int level = 0; level < LEVELS; ++level) {
        const double h = 0x1p-6 / (double)(1 << level);
        double *row = z->table + level * n;
        for (int side = 1; side >= -1; side -= 2) {
            const int status = evaluate(z, side * h, z->sample);
            if (status) return status;
            for (int k = 0; k < n; ++k)
                row[k] =
                    (side > 0 ? z->sample[k] : row[k] - z->sample[k]) / (side > 0 ? 1.0 : 2.0 * h);
        }
    }
    *doubt = 0.0;
    double factor = 1.0;
    for (int order = 1; order < LEVELS; ++order) {
        factor *= 4.0;
        for (int level = LEVELS - 1; level >= order; --level) {
            double *fine = z->table + level * n, *coarse = fine - n;
            for (int k = 0; k < n; ++k) {
                const double better = (factor * fine[k] - coarse[k]) / (factor - 1.0);
                if (level == LEVELS - 1 && order == LEVELS - 1 && k < z->s.nu)
                    *doubt = fmax(*doubt, fabs(better - fine[k]));
                fine[k] = better;
            }
        }
    }
    return MBSR_OK;
}

/* x less what rows (rows x nu, column-major) times x is more than `target`. */
static void project(const scene *z, const double *C, const double *target, double *x)
{
    const int rows = z->s.rows, n = z->s.nu, most = rows > n ? rows : n,
              work_size = 100 * (most + 1), one = 1;
    const double rcond = 1e-10;
    double *A = numbers(rows * n), *b = numbers(most), *work = numbers(work_size);
    int *pivots = calloc((size_t)n + 1, sizeof *pivots), rank, info;
    for (int k = 0; k < rows * n; ++k) A[k] = C[k];
    for (int k = 0; k < rows; ++k) {
        b[k] = -target[k];
        for (int j = 0; j < n; ++j) b[k] += C[j * rows + k] * x[j];
    }
    dgelsy_(&rows, &n, &one, A, &rows, b, &most, pivots, &rcond, &rank, work, &work_size, &info);
    for (int j = 0; j < n; ++j) x[j] -= b[j];
    free(A);
    free(b);
    free(work);
    free(pivots);
}

/* A direction; where loops are closed one that they allow. */
static void choose_direction(scene *z)
{
    const medley *s = &z->s;
    test_fill(&z->rng, s->nu, z->dq);
    test_fill(&z->rng, s->nu, z->du);
    test_fill(&z->rng, s->nu, z->dload);
    double *C = numbers(s->rows * s->nu), *rate = numbers(2 * s->rows), *other = rate + s->rows,
           *e = numbers(s->nu);
    const bool closed = z->forward && s->rows > 0;
    assert_ok(mbsr_stage_positions(s->m, s->d, s->t, s->q), mbsr_data_error(s->d));
    for (int j = 0; j < s->nu && closed; ++j) {
        e[j] = 1.0;
        assert_ok(mbsr_closures_apply(s->m, s->d, e, C + j * s->rows), mbsr_data_error(s->d));
        e[j] = 0.0;
    }
    if (closed) project(z, C, rate, z->dq);
    assert_ok(mbsr_stage_velocities(s->m, s->d, z->dq), mbsr_data_error(s->d));
    assert_ok(mbsr_coordinate_rates(s->m, s->d, z->qdot), mbsr_data_error(s->d));
    if (closed) {
        static const double h = 1e-4;
        for (int side = 0; side < 2; ++side) {
            for (int k = 0; k < s->nq; ++k) z->q[k] = s->q[k] + (side ? -h : h) * z->qdot[k];
            assert_ok(mbsr_normalise(s->m, s->d, z->q), mbsr_data_error(s->d));
            assert_ok(mbsr_stage_positions(s->m, s->d, s->t, z->q), mbsr_data_error(s->d));
            assert_ok(mbsr_stage_velocities(s->m, s->d, s->u), mbsr_data_error(s->d));
            assert_ok(mbsr_closures_rate(s->m, s->d, side ? other : rate), mbsr_data_error(s->d));
        }
        for (int k = 0; k < s->rows; ++k) rate[k] = (other[k] - rate[k]) / (2.0 * h);
        project(z, C, rate, z->du);
    }
    free(C);
    free(rate);
    free(e);
}

/* Springs of 1e10 cancel in differences, and closures that give nothing but gaps are differenced
 * three times. */
static double rough(const scene *z)
{
    const mbsri_closure *c = z->s.m->closures.data;
    double factor = 1.0;
    for (size_t k = 0; k < z->s.m->closures.count; ++k, ++c) {
        if (!c->def.table->bias) factor = 100.0;
        for (int r = 0; r < c->rows; ++r) factor = c->def.stiffness[r] > 1e7 ? 100.0 : factor;
    }
    return factor;
}

static void expect_near(const scene *z, const char *what, double off, double limit)
{
    if (off <= limit) return;
    print_error("seed %d (%d bodies, %d rows), %s dynamics: %s off by %.3g > %.3g\n",
                (int)z->s.c.seed, z->s.bodies, z->s.rows, z->forward ? "forward" : "inverse", what,
                off, limit);
    fail();
}

/* The largest entry of the matrices. */
static double find_size(const scene *z, double *largest_lambda)
{
    const medley *s = &z->s;
    double *e = numbers(2 * s->nu + s->rows), *out = e + s->nu, size = 0.0;
    for (int kind = 0; kind < 3; ++kind) {
        for (int j = 0; j < s->nu; ++j) {
            e[j] = 1.0;
            assert_ok(mbsr_derivatives_tangent(z->w, kind == 0 ? e : NULL, kind == 1 ? e : NULL,
                                               kind == 2 ? e : NULL, out,
                                               largest_lambda ? out + s->nu : NULL),
                      mbsr_derivatives_error(z->w));
            e[j] = 0.0;
            size = fmax(size, test_largest(s->nu, out));
            if (largest_lambda)
                *largest_lambda = fmax(*largest_lambda, test_largest(s->rows, out + s->nu));
        }
    }
    free(e);
    return size;
}

/* Tangents beside differences, to 1e-9 of the largest entry. */
static bool check_tangent(scene *z, bool lambda)
{
    const medley *s = &z->s;
    double doubt;
    choose_direction(z);
    assert_ok(
        mbsr_derivatives_tangent(z->w, z->dq, z->du, z->dload, z->out, lambda ? z->dlambda : NULL),
        mbsr_derivatives_error(z->w));
    if (differences(z, &doubt) != MBSR_OK) return false;
    const double *expected = z->table + (LEVELS - 1) * (s->nu + s->rows);
    double off = 0.0, of_lambda = 0.0;
    /* what is added up where loops leave nothing to masses: accelerations of the state itself */
    const double size = fmax(find_size(z, lambda ? &of_lambda : NULL), 0.1 * z->speed),
                 limit = 1e-9 * rough(z);
    for (int k = 0; k < s->nu; ++k) off = fmax(off, fabs(z->out[k] - expected[k]));
    expect_near(z, "tangent", off, limit * size + 3.0 * doubt);
    if (!lambda) return true;
    off = 0.0;
    for (int k = 0; k < s->rows; ++k) off = fmax(off, fabs(z->dlambda[k] - expected[s->nu + k]));
    expect_near(z, "dlambda", off, limit * of_lambda + 3.0 * doubt);
    return true;
}

/* What rounding of tau's derivatives becomes in those of u', by M^-1: small bodies on long chains
 * make both large. */
static double rounding_of(const scene *z)
{
    const medley *s = &z->s;
    const int n = s->nu;
    double *matrix = numbers(n * n + n), *udot = matrix + n * n;
    assert_ok(mbsr_forward_dynamics(s->m, s->d, s->t, s->q, s->u, z->load, udot),
              mbsr_data_error(s->d));
    assert_ok(mbsr_derivatives_inverse(z->w, s->t, s->q, s->u, udot, NULL),
              mbsr_derivatives_error(z->w));
    assert_ok(mbsr_derivatives_matrices(z->w, matrix, NULL, NULL), mbsr_derivatives_error(z->w));
    const double force = test_largest(n * n, matrix);
    assert_ok(mbsr_derivatives_forward(z->w, s->t, s->q, s->u, z->load, NULL, NULL),
              mbsr_derivatives_error(z->w));
    assert_ok(mbsr_derivatives_matrices(z->w, NULL, NULL, matrix), mbsr_derivatives_error(z->w));
    const double inverse = test_largest(n * n, matrix);
    free(matrix);
    return 4.0 * 0x1p-52 * force * inverse;
}

/* Columns of the matrices beside tangents along unit vectors; rounding: of these. */
static void check_matrices(const scene *z, double rounding)
{
    const int n = z->s.nu;
    double *matrix = numbers(4 * n * n), *other = matrix + 3 * n * n, *e = numbers(2 * n),
           *out = e + n;
    const double size = find_size(z, NULL);
    assert_ok(mbsr_derivatives_matrices(z->w, matrix, matrix + n * n, matrix + 2 * n * n),
              mbsr_derivatives_error(z->w));
    for (int k = 0; k < 3 * n; ++k) {
        double off = 0.0;
        e[k % n] = 1.0;
        assert_ok(mbsr_derivatives_tangent(z->w, k < n ? e : NULL, k / n == 1 ? e : NULL,
                                           k / n == 2 ? e : NULL, out, NULL),
                  mbsr_derivatives_error(z->w));
        e[k % n] = 0.0;
        for (int j = 0; j < n; ++j) off = fmax(off, fabs(out[j] - matrix[k * n + j]));
        expect_near(z, "matrix", off, 1e-10 * size + rounding);
    }
    for (int which = 0; which < 3; ++which) { /* one alone */
        assert_ok(mbsr_derivatives_matrices(z->w, which == 0 ? other : NULL,
                                            which == 1 ? other : NULL, which == 2 ? other : NULL),
                  mbsr_derivatives_error(z->w));
        for (int k = 0; k < n * n; ++k)
            expect_near(z, "matrix alone", fabs(other[k] - matrix[which * n * n + k]),
                        1e-13 * size);
    }
    free(matrix);
    free(e);
}

static double product(int n, const double *a, const double *b, double *size)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) {
        sum += a[k] * b[k];
        *size += fabs(a[k] * b[k]);
    }
    return sum;
}

/* <w, J v> = <J^T w, v>. */
static void check_adjoint(scene *z, bool lambda)
{
    const medley *s = &z->s;
    double *w = numbers(4 * s->nu + s->rows), *by_q = w + s->nu, *by_u = by_q + s->nu,
           *by_load = by_u + s->nu, *w_lambda = by_load + s->nu, size = 0.1 * z->speed;
    test_fill(&z->rng, s->nu, w);
    test_fill(&z->rng, s->rows, w_lambda);
    assert_ok(mbsr_derivatives_adjoint(z->w, w, lambda ? w_lambda : NULL, by_q, by_u, by_load),
              mbsr_derivatives_error(z->w));
    double left = product(s->nu, w, z->out, &size);
    if (lambda) left += product(s->rows, w_lambda, z->dlambda, &size);
    const double right = product(s->nu, by_q, z->dq, &size) + product(s->nu, by_u, z->du, &size) +
                         product(s->nu, by_load, z->dload, &size);
    /* where rows depend on others, only along directions that all of them allow, which are found by
     * differences */
    const bool consistent = lambda || z->s.rows == 0 || !z->forward;
    expect_near(z, "adjoint", fabs(left - right), (consistent ? 1e-12 : 1e-8) * size);
    free(w);
}

/* The same tangent by the general matrices. */
static void check_by_matrices(const scene *z, const double *load)
{
    const medley *s = &z->s;
    mbsr_derivatives *w;
    assert_ok(mbsr_derivatives_create(s->m, &w, NULL), NULL);
    mbsri_rigid_destroy(w->rigid);
    w->rigid = NULL;
    assert_ok(z->forward ? mbsr_derivatives_forward(w, s->t, s->q, s->u, load, NULL, NULL)
                         : mbsr_derivatives_inverse(w, s->t, s->q, s->u, load, NULL),
              mbsr_derivatives_error(w));
    double *other = numbers(s->nu), off = 0.0;
    assert_ok(mbsr_derivatives_tangent(w, z->dq, z->du, z->dload, other, NULL), NULL);
    for (int k = 0; k < s->nu; ++k) off = fmax(off, fabs(z->out[k] - other[k]));
    expect_near(z, "tangent beside matrices", off, 1e-10 * find_size(z, NULL));
    mbsr_derivatives_destroy(w);
    free(other);
}

static void check(uint64_t seed, bool tree, bool forward, tally *all)
{
    scene z;
    if (!(tree ? open_tree(&z, seed, forward) : open_scene(&z, seed))) {
        close_scene(&z);
        return;
    }
    const medley *s = &z.s;
    z.forward = forward;
    test_fill(&z.rng, s->nu, z.load);
    const int status = forward ? mbsr_derivatives_forward(z.w, s->t, s->q, s->u, z.load, NULL, NULL)
                               : mbsr_derivatives_inverse(z.w, s->t, s->q, s->u, z.load, NULL);
    if (status == MBSR_OK) {
        z.speed = 1.0;
        if (forward) {
            assert_ok(mbsr_forward_dynamics(s->m, s->d, s->t, s->q, s->u, z.load, z.out), NULL);
            z.speed = fmax(1.0, test_largest(s->nu, z.out));
        }
        const bool lambda =
            forward && s->rows > 0 &&
            mbsr_derivatives_tangent(z.w, NULL, NULL, NULL, z.out, z.dlambda) == MBSR_OK;
        /* elements of some trees are too sharp for differences */
        const bool sharp = tree && seed % 2 == 1, known = sharp || check_tangent(&z, lambda);
        if (sharp) {
            choose_direction(&z);
            assert_ok(mbsr_derivatives_tangent(z.w, z.dq, z.du, z.dload, z.out, NULL), NULL);
        }
        if (tree && z.w->by_sweeps) check_by_matrices(&z, z.load);
        if (known) {
            check_adjoint(&z, lambda);
            if (tree) check_matrices(&z, 0.0);
            ++*(forward ? &all->forward : &all->inverse);
            all->closed += forward && s->rows > 0;
            all->lambda += lambda;
            all->by_sweeps += z.w->by_sweeps;
        }
    } else {
        const int expected =
            forward ? mbsr_forward_dynamics(s->m, s->d, s->t, s->q, s->u, z.load, z.out)
                    : mbsr_inverse_dynamics(s->m, s->d, s->t, s->q, s->u, z.load, NULL, z.out);
        assert_int_equal(status, expected);
        ++all->refused;
    }
    close_scene(&z);
}

static void medleys(void **state)
{
    (void)state;
    tally all = {0};
    const int seeds = test_seeds(40, 150);
    for (int seed = 1; seed <= seeds; ++seed) {
        check((uint64_t)seed, false, false, &all);
        check((uint64_t)seed, false, true, &all);
    }
    assert_true(all.inverse > seeds / 2 && all.forward > seeds / 5 && all.closed > seeds / 10);
}

static void rigid_trees(void **state)
{
    (void)state;
    tally all = {0};
    const int seeds = test_seeds(60, 400);
    for (int seed = 1; seed <= seeds; ++seed) {
        check((uint64_t)seed, true, false, &all);
        check((uint64_t)seed, true, true, &all);
    }
    assert_true(all.by_sweeps > 3 * seeds / 2 && all.forward > seeds / 2);
}

static void long_chains(void **state)
{
    (void)state;
    for (uint64_t seed = LONG_CHAINS + 2; seed <= LARGE_TREE; seed += 2) {
        scene z;
        assert_true(open_tree(&z, seed, true));
        const medley *s = &z.s;
        z.forward = true;
        z.speed = 1.0;
        test_fill(&z.rng, s->nu, z.load);
        assert_ok(mbsr_derivatives_forward(z.w, s->t, s->q, s->u, z.load, NULL, NULL),
                  mbsr_derivatives_error(z.w));
        choose_direction(&z);
        assert_true(z.w->by_sweeps && !z.w->rigid->order.path);
        assert_true(seed != LARGE_TREE || (s->nu > 200 && z.w->rigid->order.down == 0));
        check_matrices(&z, rounding_of(&z));
        close_scene(&z);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(medleys), cmocka_unit_test(rigid_trees),
                                       cmocka_unit_test(long_chains)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
