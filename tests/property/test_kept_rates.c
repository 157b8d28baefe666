/* Starts that keep some joint rates, of random trees and loops in the plane whose bodies without
 * mass are damped, against dense constrained least squares:
 *
 *   (u - u_0)^T M (u - u_0) = min,    C u = 0,    Z^T h(u) = 0,    E u = e
 *
 * with the inverse dynamics h and Z spanning the kernel of M and C.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "duration.h"
#include "expect.h"
#include "medley.h"

#include "algebra/lapack.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 300, BODIES = 9, MOST = 64, UNKNOWNS = 4 * BODIES, WORK = 20000 };

typedef struct scene {
    mbsr_model *m;
    mbsr_data *d;
    int n, rows;
    double q[BODIES], u[BODIES];
} scene;

/* ---- models ---- */

static mbsr_planar_frame random_frame(test_rng *rng)
{
    const double x = test_uniform(rng), y = test_uniform(rng);
    return (mbsr_planar_frame){x, y, test_uniform(rng)};
}

static int add_body(mbsr_model *m, test_rng *rng, int parent, bool massless)
{
    const mbsr_planar_frame a = random_frame(rng), b = random_frame(rng);
    const bool turns = test_uniform(rng) < 0.4;
    const double com[2] = {test_uniform(rng), test_uniform(rng)}, mass = 1.5 + test_uniform(rng);
    const int id = test_add_body(
        m, parent, turns ? mbsr_joint_planar_revolute(a, b) : mbsr_joint_planar_prismatic(a, b),
        massless ? mbsr_inertia_zero() : mbsr_inertia_planar(mass, com, 0.2 * mass));
    const mbsr_force_def damper =
        mbsr_force_joint_spring(id, 0, 3.0, pow(10.0, test_uniform(rng)), test_uniform(rng));
    assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
    return id;
}

static void add_damper(mbsr_model *m, test_rng *rng, int bodies)
{
    const int a = test_integer(rng, 0, bodies - 1), b = (a + 1) % bodies;
    const double p[3] = {test_uniform(rng), test_uniform(rng), 0.0},
                 r[3] = {test_uniform(rng) + 3.0, test_uniform(rng), 0.0};
    const mbsr_force_def damper = mbsr_force_point_spring(a, p, b, r, 2.0, 4.0, 1.0);
    assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
}

/* Bodies and forces; the same each time for one seed. */
static int add_tree(mbsr_model *m, test_rng *rng)
{
    const int bodies = test_integer(rng, 3, BODIES);
    for (int i = 0; i < bodies; ++i)
        add_body(m, rng,
                 test_integer(rng, -1, i - 1) < 0 ? MBSR_GROUND : test_integer(rng, 0, i - 1),
                 test_uniform(rng) < -0.3);
    add_damper(m, rng, bodies);
    return bodies;
}

/* The point of a body that is at (x, y). */
static void local(const scene *s, int body, double x, double y, double point[3])
{
    double pose[MBSR_POSE_SIZE];
    assert_ok(mbsr_body_pose(s->m, s->d, body, pose), NULL);
    const double dx = x - pose[0], dy = y - pose[1], c = cos(pose[2]), n = sin(pose[2]);
    point[0] = c * dx + n * dy;
    point[1] = c * dy - n * dx;
    point[2] = 0.0;
}

static void finish(scene *s)
{
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
}

static void end(scene *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

/* Two bodies that pins hold at their places, and one more to the ground, in the model to be. */
static void add_pins(const scene *s, mbsr_model *m, test_rng *rng, int pins)
{
    for (int k = 0; k < pins; ++k) {
        const int a = test_integer(rng, 0, s->n - 1), b = (a + 1 + k) % s->n;
        const double x = test_uniform(rng), y = test_uniform(rng), ground[3] = {x, y, 0.0};
        double on_a[3], on_b[3];
        local(s, a, x, y, on_a);
        local(s, b, x, y, on_b);
        const mbsr_closure_def pin = k == 0 && a != b
                                         ? mbsr_closure_ball(a, on_a, b, on_b)
                                         : mbsr_closure_ball(a, on_a, MBSR_GROUND, ground);
        assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    }
}

static void make(scene *s, uint64_t seed)
{
    test_rng rng = test_seed(seed), again;
    mbsr_model *closed = NULL;
    memset(s, 0, sizeof *s);
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
    again = rng;
    s->n = add_tree(s->m, &rng);
    finish(s);
    test_fill(&rng, s->n, s->q);
    test_fill(&rng, s->n, s->u);
    const int pins = s->n < 5 ? 0 : test_integer(&rng, 0, 2);
    if (pins == 0) return;
    assert_ok(mbsr_model_create(NULL, &closed, NULL), NULL);
    add_tree(closed, &again);
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, s->q), NULL);
    add_pins(s, closed, &rng, pins);
    end(s);
    s->m = closed;
    finish(s);
    s->rows = mbsr_model_rows(s->m);
}

/* ---- the oracle ---- */

typedef struct oracle {
    double M[BODIES * BODIES], C[BODIES * BODIES]; /* n x n, rows x n */
    double Z[BODIES * BODIES], G[BODIES * BODIES],
        g[BODIES]; /* n x k; k x n and k: Z^T h = G u + g */
    int k, pivots[UNKNOWNS];
    double work[WORK];
} oracle;

/* Z^T h(u) */
static void balance(const scene *s, const oracle *o, const double *u, double *r)
{
    double h[BODIES], still[BODIES] = {0.0};
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, 0.0, s->q, u, still, NULL, h),
              mbsr_data_error(s->d));
    for (int l = 0; l < o->k; ++l) {
        r[l] = 0.0;
        for (int j = 0; j < s->n; ++j) r[l] += o->Z[l * s->n + j] * h[j];
    }
}

static void find_kernel(const scene *s, oracle *o)
{
    double A[BODIES * BODIES], values[BODIES], U[BODIES * BODIES], V[BODIES * BODIES];
    const int n = s->n;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            A[j * n + i] = o->M[j * n + i];
            for (int r = 0; r < s->rows; ++r)
                A[j * n + i] += o->C[i * s->rows + r] * o->C[j * s->rows + r];
        }
    }
    assert_int_equal(mbsri_lapack_svd(n, A, values, U, V, o->work, WORK), 0);
    o->k = 0;
    for (int l = 0; l < n; ++l) {
        if (values[l] > 1e-11 * values[0]) continue;
        memcpy(o->Z + o->k++ * n, V + l * n, (size_t)n * sizeof *V);
    }
}

/* At positions closed. */
static void look(const scene *s, oracle *o)
{
    double unit[BODIES] = {0.0}, r[BODIES];
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, s->q), NULL);
    assert_ok(mbsr_stage_velocities(s->m, s->d, unit), NULL);
    assert_ok(mbsr_mass_matrix(s->m, s->d, o->M), NULL);
    for (int j = 0; j < s->n && s->rows > 0; ++j) {
        unit[j] = 1.0;
        assert_ok(mbsr_closures_apply(s->m, s->d, unit, o->C + j * s->rows), NULL);
        unit[j] = 0.0;
    }
    find_kernel(s, o);
    balance(s, o, unit, o->g);
    for (int j = 0; j < s->n; ++j) {
        unit[j] = 1.0;
        balance(s, o, unit, r);
        unit[j] = 0.0;
        for (int l = 0; l < o->k; ++l) o->G[j * o->k + l] = r[l] - o->g[l];
    }
}

/* u by the stationarity of the least squares; returns what is left of the equations. */
static double solve(const scene *s, oracle *o, int count, const int *rate, double *u)
{
    const int n = s->n, N = n + s->rows + o->k + count;
    double *A = calloc((size_t)(2 * N * N + 2 * N), sizeof *A), *B = A + N * N, *x = B + N * N,
           *b = x + N;
    for (int j = 0; j < n; ++j) {
        int row = n;
        for (int i = 0; i < n; ++i) {
            A[j * N + i] = o->M[j * n + i];
            b[i] += o->M[j * n + i] * s->u[j];
        }
        for (int r = 0; r < s->rows; ++r, ++row) A[j * N + row] = o->C[j * s->rows + r];
        for (int r = 0; r < o->k; ++r, ++row) A[j * N + row] = o->G[j * o->k + r];
        for (int r = 0; r < count; ++r, ++row) A[j * N + row] = rate[r] == j ? 1.0 : 0.0;
        for (int r = n; r < N; ++r) A[r * N + j] = A[j * N + r];
    }
    for (int l = 0; l < o->k; ++l) b[n + s->rows + l] = -o->g[l];
    for (int l = 0; l < count; ++l) b[n + s->rows + o->k + l] = s->u[rate[l]];
    memcpy(B, A, (size_t)(N * N) * sizeof *A);
    memcpy(x, b, (size_t)N * sizeof *x);
    int rank;
    assert_int_equal(mbsri_lapack_gelsy(N, N, A, x, 1e-10, o->pivots, &rank, o->work, WORK), 0);
    memcpy(u, x, (size_t)n * sizeof *u);
    double left = 0.0;
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j < N; ++j) b[i] -= B[j * N + i] * x[j];
        left = fmax(left, fabs(b[i]));
    }
    free(A);
    return left;
}

/* ---- what is compared ---- */

typedef struct tally {
    int kept, refused, massless, loops;
} tally;

static void compare(scene *s, uint64_t seed, tally *all)
{
    oracle *o = calloc(1, sizeof *o);
    double y[MOST], yp[MOST], before[MOST], F[MOST], u[BODIES];
    int keep[BODIES] = {0}, rate[BODIES], count = 0;
    test_rng rng = test_seed(seed + 77);
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    for (int k = 0; k < s->n; ++k) {
        if (test_uniform(&rng) < 0.4) continue;
        keep[k] = 1;
        rate[count++] = k;
    }
    opt.keep_rate = keep;
    look(s, o);
    const double left = solve(s, o, count, rate, u), size = 1.0 + test_largest(s->n, u);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), NULL);
    memcpy(before, y, sizeof y);
    const int status = mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, NULL);
    if (left < 1e-9 && size < 1e3) {
        if (status) print_error("seed %d: ", (int)seed);
        assert_ok(status, mbsr_data_error(s->d));
        for (int k = 0; k < s->n; ++k) {
            if (keep[k]) assert_true(y[2 * s->n + k] == s->u[k]);
            if (!(fabs(y[2 * s->n + k] - u[k]) < 1e-6 * size)) print_error("seed %d: ", (int)seed);
            assert_close(y[2 * s->n + k], u[k], 1e-6 * size);
        }
        assert_ok(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), NULL);
        const int length = mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM);
        assert_less(test_largest(length, F), 1e-7 * (size + test_largest(length, yp)));
        ++all->kept;
        all->massless += o->k > 0;
        all->loops += s->rows > 0;
    } else if (left > 1e-3) {
        if (!status) print_error("seed %d: ", (int)seed);
        assert_true(status == MBSR_LOOP_OPEN || status == MBSR_NO_CONVERGENCE);
        assert_contains(mbsr_data_error(s->d)->text, "cannot keep");
        assert_memory_equal(y, before, (size_t)(2 * s->n) * sizeof *y);
        ++all->refused;
    }
    free(o);
}

static void as_least_squares(void **state)
{
    (void)state;
    tally all = {0};
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        scene s;
        make(&s, seed);
        compare(&s, seed, &all);
        end(&s);
    }
    assert_true(all.kept > 100 && all.refused > 20 && all.massless > 40 && all.loops > 20);
}

/* ---- mechanisms of everything ---- */

/* Velocities of a start at positions q (nq) of the mechanism, from random ones beside u (nu); into
 * `to`. */
static int velocities(const medley *s, test_rng *rng, const double *q, const double *u, double *y,
                      double *yp, double *to)
{
    for (int k = 0; k < s->nu; ++k) to[k] = u[k] + test_uniform(rng);
    int status = mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, q, to, y);
    if (!status)
        status = mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, NULL, NULL);
    memcpy(to, y + s->nq + s->nu, (size_t)s->nu * sizeof *to);
    return status;
}

/* What is left of the equations of motion at y and y', beside the largest of y'. */
static double residual(const medley *s, const double *y, const double *yp)
{
    double *F = calloc((size_t)s->size + 1, sizeof *F);
    assert_ok(mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, F), NULL);
    const double left = test_largest(s->size, F) / (1.0 + test_largest(s->size, yp));
    free(F);
    return left;
}

/* A third of the rates keep values that another start has found: 1 if they did, 0 if that was
 * refused, -1 where there is no such start. */
static int keep_some(const medley *s, test_rng *rng)
{
    const size_t size = (size_t)s->size, nu = (size_t)s->nu;
    double *y = calloc(3 * size + 2 * nu + 1, sizeof *y), *yp = y + size, *before = yp + size,
           *u = before + size, *other = u + nu;
    int *keep = calloc(nu + 1, sizeof *keep), result = -1;
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    opt.keep_rate = keep;
    if (!velocities(s, rng, s->q, s->u, y, yp, u) && !velocities(s, rng, y, u, y, yp, other)) {
        const double usual = residual(s, y, yp);
        for (int k = 0; k < s->nu; ++k) {
            keep[k] = test_uniform(rng) < -0.4;
            if (keep[k]) u[k] = other[k];
        }
        assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, u, before), NULL);
        memcpy(y, before, size * sizeof *y);
        const int status =
            mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, &opt, NULL);
        if (status) {
            assert_memory_equal(y, before, size * sizeof *y);
        } else {
            for (int k = 0; k < s->nu; ++k) assert_true(!keep[k] || y[s->nq + s->nu + k] == u[k]);
            assert_less(residual(s, y, yp), 1e-8 + 10.0 * usual);
        }
        result = status == MBSR_OK;
    }
    free(keep);
    free(y);
    return result;
}

static void of_everything(void **state)
{
    (void)state;
    int kept = 0, refused = 0;
    const int seeds = test_long() ? 150 : test_seeds(12, 30);
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; ++seed) {
        medley s;
        test_rng rng = test_seed(seed + 5);
        const medley_choice c = medley_choose(seed);
        const int result = medley_make(&s, &c) ? keep_some(&s, &rng) : -1;
        kept += result == 1;
        refused += result == 0;
        medley_free(&s);
    }
    assert_true(kept > seeds / 3 && refused <= kept / 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(as_least_squares),
                                       cmocka_unit_test(of_everything)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
