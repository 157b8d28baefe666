/* Null vectors and inverses of joint blocks: double precision against the twofold pass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "close.h"
#include "expect.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <string.h>

enum { HINGES = 6 };

/* A ball joint twice over, of hinges without mass, with a point mass `off` its last axis, along
 * which it lies at q = 0. */
static mbsr_model *gimbal(double off)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < HINGES; ++k) {
        const double axis[3] = {k % 3 == 0, k % 3 == 1, k % 3 == 2}, at[3] = {off, 0.5 * off, 0.9};
        mbsr_body_def b = mbsr_default_body_def();
        b.parent = k == 0 ? MBSR_GROUND : k - 1;
        b.joint = mbsr_joint_revolute(NULL, NULL, axis);
        b.inertia = k + 1 == HINGES ? mbsr_inertia_point_mass(0.3, at) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* P (n x n) = X_dropped X_dropped^T of the group of body 1; its rank. */
static int project(const mbsr_model *m, const mbsr_data *d, double *P)
{
    const mbsri_group g = mbsri_group_of(m, d, 1);
    const int n = g.n, rank = mbsri_group_rank(d, &g);
    const double *X = d->X + m->body[1].nn;
    assert_true(rank > 0 && rank < n);
    memset(P, 0, HINGES * HINGES * sizeof *P);
    for (int l = rank; l < n; ++l) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) P[j * n + k] += X[l * n + j] * X[l * n + k];
        }
    }
    return rank;
}

/* |D D^+ D - D| beside the largest entry of D, of the group of body 1. */
static double residual(const mbsr_model *m, const mbsr_data *d)
{
    const int n = mbsri_group_of(m, d, 1).n;
    const double *D = d->D + m->body[1].nn, *inverse = d->Dinv + m->body[1].nn;
    double half[HINGES * HINGES] = {0.0}, most = 0.0, size = 0.0;
    assert_in_range(n, 2, HINGES);
    for (int k = 0; k < n * n; ++k)
        for (int l = 0; l < n; ++l) half[k] += D[k / n * n + l] * inverse[l * n + k % n];
    for (int k = 0; k < n * n; ++k) {
        double sum = -D[k];
        for (int l = 0; l < n; ++l) sum += half[k / n * n + l] * D[l * n + k % n];
        most = fmax(most, fabs(sum));
        size = fmax(size, fabs(D[k]));
    }
    return most / size;
}

/* The largest difference between the projections of both; what the twofold pass leaves of D. */
static double difference(const mbsr_model *m, mbsr_data *d, const double *q, double *left)
{
    const double u[HINGES] = {0.0};
    double plain[HINGES * HINGES], exact[HINGES * HINGES], most = 0.0;
    assert_ok(mbsri_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsri_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsri_forces(m, d, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsri_backward(m, d), mbsr_data_error(d));
    const int rank = project(m, d, plain);
    d->exactly = true;
    assert_ok(mbsri_backward(m, d), mbsr_data_error(d));
    d->exactly = false;
    assert_int_equal(project(m, d, exact), rank);
    *left = residual(m, d);
    for (int k = 0; k < HINGES * HINGES; ++k) most = fmax(most, fabs(plain[k] - exact[k]));
    return most;
}

/* At q = 0 the last hinge moves next to nothing, elsewhere the others move the mass about the same
 * axis. */
static void null_vectors_are_as_good_as_masses(void **state)
{
    (void)state;
    test_rng rng = test_seed(31);
    double most = 0.0, worst = 0.0;
    for (int round = 0; round < 400; ++round) {
        mbsr_model *m = gimbal(pow(10.0, -1.0 - round % 6));
        mbsr_data *d = NULL;
        double q[HINGES], left;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        for (int k = 0; k < HINGES; ++k) q[k] = 1.2 * test_uniform(&rng);
        most = fmax(most, difference(m, d, q, &left));
        worst = fmax(worst, left * pow(10.0, -2.0 * (round % 6)));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    print_message("null vectors differ by at most %.2g, D D^+ D - D is up to %.2g\n", most, worst);
    assert_true(most < 1e-9 && worst < 1e-9);
}

/* Point masses on two ball joints, all on one line: neither joint turns any about it. */
static void columns_are_orthonormal(void **state)
{
    enum { BALLS = 2, N = 3 };
    const double on_line[3] = {0.2, -0.3, 0.6}, q[4 * BALLS] = {1.0, 0.0, 0.0, 0.0, 1.0},
                 u[N * BALLS] = {0.0};
    const mbsr_frame end = mbsr_frame_at(0.4, -0.6, 1.2);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    (void)state;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < BALLS; ++k)
        (void)test_add_body(m, k - 1, mbsr_joint_spherical(k == 0 ? NULL : &end, NULL),
                            mbsr_inertia_point_mass(0.3, on_line));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsri_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsri_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsri_forces(m, d, NULL, NULL), mbsr_data_error(d));
    d->exactly = true;
    assert_ok(mbsri_backward(m, d), mbsr_data_error(d));
    for (int i = 1; i <= BALLS; ++i) {
        const double *X = d->X + m->body[i].nn;
        assert_int_equal(d->rank[i], 2);
        for (int k = 0; k < N * N; ++k) {
            double product = 0.0;
            for (int l = 0; l < N; ++l) product += X[k / N * N + l] * X[k % N * N + l];
            assert_close(product, k % (N + 1) == 0 ? 1.0 : 0.0, 1e-14);
        }
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A thin rod between a slider and a disc, on one pin nearly along it. Rounding of the disc's
 * inertia counts a thousand times about the rod's other axes; what is left where this is confined
 * is no less than rounding of the rod itself. */
static void errors_are_those_of_the_body_at_least(void **state)
{
    enum { D = 6 };
    static const double x[3] = {1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, middle[3] = {0.0};
    const double q[3] = {0.0}, u[3] = {0.0}, disc[6] = {1.0, 1.0, 1.0}, low[3] = {-1e-3, 0.0, -1.0},
                 high[3] = {1e-3, 0.0, 1.0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    (void)state;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int slider = test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, x),
                                     mbsr_inertia_rigid(1.0, middle, disc)),
              pinned = test_add_body(m, slider, mbsr_joint_revolute(NULL, NULL, z),
                                     mbsr_inertia_rod(3.0, low, high));
    (void)test_add_body(m, pinned, mbsr_joint_revolute(NULL, NULL, z),
                        mbsr_inertia_rigid(1.0, middle, disc));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsri_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsri_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsri_forces(m, d, NULL, NULL), mbsr_data_error(d));
    d->exactly = true;
    assert_ok(mbsri_backward(m, d), mbsr_data_error(d));
    const double *W = d->W + m->body[1].dd, *own = d->Mbar + m->body[1].dd,
                 *behind = d->Mbar + m->body[2].dd;
    for (int k = 0; k < D * D; k += D + 1) assert_less((1.0 - 1e-12) * (own[k] + behind[k]), W[k]);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(null_vectors_are_as_good_as_masses),
        cmocka_unit_test(columns_are_orthonormal),
        cmocka_unit_test(errors_are_those_of_the_body_at_least),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
