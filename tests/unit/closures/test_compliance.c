/* Closures with a compliance matrix: forces, energies and powers are those of the matrices.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include "algebra/lapack.h"

#include <mbsrank/driver.h>

#include <stdbool.h>
#include <string.h>

enum { MOST = 6 };

/* Two rods in the plane, or two bodies in space, the second on the first. */
static void build(loops *s, bool flat, const double *A, const double *D)
{
    const double axis[3] = {2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0}, z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame end = mbsr_frame_at(0.5, 0.1, flat ? 0.0 : 0.2);
    loops_begin(s, NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k == 0 ? MBSR_GROUND : 0;
        body.joint = flat ? mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0})
                          : mbsr_joint_universal(&end, NULL, z, axis);
        body.inertia = flat ? mbsr_inertia_planar(1.5, (double[2]){0.2, -0.1}, 0.3)
                            : mbsr_inertia_rigid(1.5, (double[3]){0.2, -0.1, 0.3},
                                                 (double[6]){0.4, 0.5, 0.6, 0.01, 0.02, -0.03});
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    }
    mbsr_closure_def weld = mbsr_closure_weld(1, &end, MBSR_GROUND, NULL);
    weld.name = "weld";
    weld.compliant = A ? flat ? 3 : 6 : 0;
    weld.compliance = A;
    weld.compliance_damping = D;
    assert_ok(mbsr_model_add_closure(s->m, &weld, NULL), mbsr_model_error(s->m));
    loops_finish(s);
}

/* X X^T of n x rank random numbers, with units that differ by `spread`. */
static void gram(test_rng *rng, int n, int rank, double spread, double *A)
{
    double X[MOST * MOST];
    test_fill(rng, n * rank, X);
    for (int k = 0; k < n * rank; ++k) X[k] *= k % n % 2 ? spread : 1.0;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
            A[j * n + k] = 0.0;
            for (int l = 0; l < rank; ++l) A[j * n + k] += X[l * n + j] * X[l * n + k];
        }
    }
}

static void multiply(int n, const double *A, const double *x, double *y)
{
    for (int k = 0; k < n; ++k) {
        y[k] = 0.0;
        for (int j = 0; j < n; ++j) y[k] += A[j * n + k] * x[j];
    }
}

static double dot(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum;
}

/* Gaps and rates along the table's rows, from a rigid twin, whose turns are taken as exact. */
static void rows_of(loops *s, const double *q, const double *u, double *g, double *rate)
{
    loops_rows(s, 0.0, q, u, NULL, g, rate, NULL);
}

static void by_the_matrices(void **state)
{
    (void)state;
    test_rng rng = test_seed(11);
    for (int trial = 0; trial < 20; ++trial) {
        const bool flat = trial % 2 == 0;
        const int n = flat ? 3 : 6;
        double A[MOST * MOST], K[MOST * MOST], D[MOST * MOST], T[MOST * MOST], work[4 * MOST];
        double q[LOOPS_MOST], u[LOOPS_MOST], g[MOST], rate[MOST], elastic[MOST], damping[MOST],
            lambda[MOST], own_g[MOST], own_rate[MOST], potential, power;
        double weight[2] = {0.0, 0.0};
        int pivots[MOST];
        loops rigid, s;
        gram(&rng, n, n, 0.05, A);
        gram(&rng, n, 1 + trial % n, 1.0, D);
        memcpy(K, A, sizeof K);
        assert_true(mbsri_lapack_inverse(n, K, pivots, work) > 0.0);
        build(&rigid, flat, NULL, NULL);
        build(&s, flat, A, D);
        test_fill(&rng, s.nq, q);
        test_fill(&rng, s.nu, u);
        for (int k = 0; k < s.nq; ++k) q[k] *= 0.3;
        assert_ok(mbsr_closure_mixture(s.m, 0, T), NULL);
        for (int k = 0; k < n; ++k) assert_true(mbsr_closure_stiffness(s.m, 0, k) > 0.0);
        rows_of(&rigid, q, u, g, rate);
        rows_of(&s, q, u, own_g, own_rate);
        /* g = T g of the table; the rates, whose turns are exact here, back from their own */
        double expected[MOST], back[MOST * MOST];
        multiply(n, T, g, expected);
        for (int k = 0; k < n; ++k) assert_close(own_g[k], expected[k], 1e-13);
        memcpy(back, T, sizeof back);
        assert_true(mbsri_lapack_inverse(n, back, pivots, work) > 0.0);
        multiply(n, back, own_rate, rate);
        multiply(n, K, g, elastic);
        multiply(n, D, rate, damping);
        /* forces along the table's rows are T^T lambda */
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, q), NULL);
        assert_ok(mbsr_stage_velocities(s.m, s.d, u), NULL);
        assert_ok(mbsr_energy(s.m, s.d, NULL, &potential), NULL);
        assert_ok(mbsr_dissipation(s.m, s.d, &power), NULL);
        assert_ok(mbsr_stage_forces(s.m, s.d, NULL), NULL);
        assert_ok(mbsr_closures_lambda(s.m, s.d, lambda), NULL);
        const double scale = test_largest(n, elastic) + test_largest(n, damping);
        for (int k = 0; k < n; ++k)
            assert_close(dot(n, T + k * n, lambda), -elastic[k] - damping[k], 1e-9 * scale);
        assert_ok(mbsr_force_power(s.m, s.d, 0, weight, NULL), NULL);
        assert_close(potential - weight[0], 0.5 * dot(n, g, elastic), 1e-9 * fabs(potential));
        assert_close(power, dot(n, rate, damping), 1e-9 * power);
        loops_free(&rigid);
        loops_free(&s);
    }
}

/* A matrix of rank r leaves n - r rigid rows, to which no compliance leads. */
static void semidefinite(void **state)
{
    (void)state;
    test_rng rng = test_seed(12);
    for (int rank = 0; rank <= 6; ++rank) {
        double A[MOST * MOST], T[MOST * MOST], back[MOST];
        int rigid = 0;
        loops s;
        gram(&rng, 6, rank, 1e-3, A);
        build(&s, false, A, NULL);
        assert_ok(mbsr_closure_mixture(s.m, 0, T), NULL);
        for (int k = 0; k < 6; ++k) {
            double row[6], length = 0.0;
            for (int j = 0; j < 6; ++j) row[j] = T[j * 6 + k];
            for (int j = 0; j < 6; ++j) length += row[j] * row[j];
            assert_close(length, 1.0, 1e-12);
            multiply(6, A, row, back);
            const double stiffness = mbsr_closure_stiffness(s.m, 0, k), size = dot(6, row, back);
            if (stiffness == 0.0) {
                assert_close(size, 0.0, 1e-12);
                ++rigid;
            } else {
                assert_close(size * stiffness, 1.0, 1e-8);
            }
        }
        assert_int_equal(rigid, 6 - rank);
        loops_free(&s);
    }
}

/* Numbers on the diagonal are the same as numbers by row. */
static void diagonal(void **state)
{
    (void)state;
    const double A[9] = {1e-4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-2},
                 D[9] = {7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0};
    double T[9];
    loops s;
    build(&s, true, A, D);
    assert_ok(mbsr_closure_mixture(s.m, 0, T), NULL);
    for (int k = 0; k < 3; ++k) {
        const double stiffness = mbsr_closure_stiffness(s.m, 0, k);
        const char *name;
        int along = 0;
        while (T[3 * along + k] == 0.0) ++along;
        assert_close(T[3 * along + k], 1.0, 1e-15);
        assert_close(stiffness, along == 0 ? 1e4 : along == 1 ? 0.0 : 1e2, 1e-9);
        assert_ok(mbsr_closure_of_row(s.m, k, NULL, NULL, &name), NULL);
        assert_string_equal(name, along == 0 ? "x" : along == 1 ? "y" : "turn about z");
    }
    loops_free(&s);
}

static void refuse(int n, const double *A, const double *D, double stiffness, bool at_finish,
                   const char *words)
{
    loops s;
    loops_begin(&s, NULL);
    loops_rod(&s, "rod", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    mbsr_closure_def def = mbsr_closure_ball(0, NULL, MBSR_GROUND, NULL);
    def.name = "pin";
    def.compliant = n;
    def.compliance = A;
    def.compliance_damping = D;
    def.stiffness[0] = stiffness;
    if (at_finish) assert_ok(mbsr_model_add_closure(s.m, &def, NULL), NULL);
    const int status = at_finish ? mbsr_model_finish(s.m) : mbsr_model_add_closure(s.m, &def, NULL);
    assert_refused(status, mbsr_model_error(s.m), MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, words);
    if (!at_finish) loops_finish(&s);
    loops_free(&s);
}

static void refused(void **state)
{
    (void)state;
    const double good[4] = {1e-4, 0.0, 0.0, 1e-4}, skew[4] = {1e-4, 1e-5, 2e-5, 1e-4},
                 indefinite[4] = {1e-4, 2e-4, 2e-4, 1e-4}, none[4] = {NAN, 0.0, 0.0, 1.0},
                 negative[4] = {1.0, 0.0, 0.0, -1.0}, edge[4] = {0.0, 1e-9, 1e-9, 1.0},
                 far[4] = {1e-14, 0.0, 0.0, 1e4}, mixed[4] = {1e18, 9e8, 9e8, 1.0};
    refuse(2, NULL, NULL, 0.0, false, "closure 0 'pin'|compliance is NULL");
    refuse(-1, good, NULL, 0.0, false, "compliant is -1");
    refuse(13, good, NULL, 0.0, false, "compliant is 13");
    refuse(2, skew, NULL, 0.0, false, "compliance is not symmetric");
    refuse(2, indefinite, NULL, 0.0, false, "compliance is not|semi-definite");
    refuse(2, none, NULL, 0.0, false, "compliance (0,0) is nan");
    refuse(2, negative, NULL, 0.0, false, "compliance (1,1) is -1");
    refuse(2, edge, NULL, 0.0, false, "(1,0)");
    refuse(2, good, indefinite, 0.0, false, "compliance_damping is not|semi-definite");
    refuse(2, good, negative, 0.0, false, "compliance_damping (1,1) is -1");
    refuse(2, far, mixed, 0.0, false, "too near");
    refuse(2, good, NULL, 5.0, false, "stiffness[0] is 5");
    refuse(1, good, NULL, 0.0, true, "closure 0 'pin' (ball)|compliant is 1|2 position rows");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_the_matrices),
        cmocka_unit_test(semidefinite),
        cmocka_unit_test(diagonal),
        cmocka_unit_test(refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
