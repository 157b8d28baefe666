/* Directions that move no mass, and the slopes of the forces in them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "duration.h"
#include "expect.h"

#include "massless/null_slopes.h"
#include "oracle.h"

#include <stdlib.h>

#define TREES (test_long() ? 300 : test_seeds_short(75, 120))

static const double now = 0.3;

/* A random tree at a random state, with the null space there. */
typedef struct setting {
    test_tree tree;
    mbsri_null_space w;
    double *q, *u;
} setting;

static void setup(setting *s, int seed, double bend, int forces)
{
    const test_tree_opt opt = {.seed = (uint64_t)seed,
                               .bodies = 3 + seed % 9,
                               .max_d = 1 + seed % 4,
                               .welds = seed % 3 == 0,
                               .deficient = 0.9,
                               .bend = bend,
                               .forces = forces,
                               .moving_root = seed % 2,
                               .shuffle = seed % 5 == 0};
    test_rng rng = test_seed((uint64_t)seed + 1000);
    test_tree_make(&s->tree, opt);
    s->q = calloc((size_t)s->tree.nu + 1, sizeof(double));
    s->u = calloc((size_t)s->tree.nu + 1, sizeof(double));
    test_fill(&rng, s->tree.nu, s->q);
    test_fill(&rng, s->tree.nu, s->u);
    assert_ok(
        mbsri_null_open(&s->w, s->tree.model, s->tree.data, now, s->q, s->u, "test_null_space"),
        mbsr_data_error(s->tree.data));
    assert_ok(mbsri_null_basis(&s->w, now, s->q, s->u), mbsr_data_error(s->tree.data));
}

static void teardown(setting *s)
{
    mbsri_null_close(&s->w);
    free(s->q);
    free(s->u);
    test_tree_free(&s->tree);
}

static void the_basis_spans_the_null_space_of_the_mass_matrix(void **state)
{
    (void)state;
    int directions = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        setting s;
        setup(&s, seed, 0.2, 1);
        const int n = s.tree.nu, k = s.w.k;
        double *M = calloc((size_t)(n * n) + 1, sizeof(double)),
               *gram = calloc((size_t)(k * k) + 1, sizeof(double));
        assert_int_equal(mbsr_mass_matrix(s.tree.model, s.tree.data, M), MBSR_OK);
        const double size = test_largest(n * n, M);
        for (int l = 0; l < k; ++l) {
            const double *a = s.w.direction + l * n, length = test_largest(n, a);
            assert_true(length > 0.0);
            for (int r = 0; r < n; ++r) {
                double sum = 0.0;
                for (int c = 0; c < n; ++c) sum += M[c * n + r] * a[c];
                assert_close(sum / length, 0.0, 1e-9 * size);
            }
            for (int c = 0; c < k; ++c) {
                const double *b = s.w.direction + c * n;
                for (int r = 0; r < n; ++r) gram[c * k + l] += a[r] / length * b[r];
            }
        }
        /* as many as the null space has, and independent */
        int *all = calloc((size_t)n + 1, sizeof(int));
        double gap;
        test_oracle oracle;
        for (int r = 0; r < n; ++r) all[r] = r;
        double *uq = calloc((size_t)(2 * n) + 1, sizeof(double));
        memcpy(uq, s.u, sizeof(double) * (size_t)n);
        memcpy(uq + n, s.q, sizeof(double) * (size_t)n);
        test_oracle_make(&oracle, &s.tree, uq);
        const int rank = test_rank(&oracle, n, all, &gap);
        if (gap > 1e4) assert_int_equal(rank, n - k);
        assert_int_equal(test_singular_rank(k, gram), k);
        directions += k;
        test_oracle_free(&oracle);
        free(uq);
        free(all);
        free(M);
        free(gram);
        teardown(&s);
    }
    assert_true(directions > TREES);
}

/* -a_l^T tau where inverse dynamics gives tau without accelerations: the force in direction l, as M
 * a is zero. */
static void forces_along(setting *s, const double *q, const double *u, double *gamma)
{
    const int n = s->tree.nu;
    double *tau = calloc((size_t)(2 * n) + 1, sizeof(double)), *rest = tau + n;
    assert_ok(mbsr_inverse_dynamics(s->tree.model, s->tree.data, now, q, u, rest, NULL, tau),
              mbsr_data_error(s->tree.data));
    for (int l = 0; l < s->w.k; ++l) {
        gamma[l] = 0.0;
        for (int r = 0; r < n; ++r) gamma[l] -= s->w.direction[l * n + r] * tau[r];
    }
    free(tau);
}

/* A (C or S) against differences of those forces at q + h a, or u + h a. Steps of 1 are exact for
 * linear laws. */
static void assert_slopes(setting *s, const double *A, double *x)
{
    const int n = s->tree.nu, k = s->w.k;
    double *ahead = calloc((size_t)(2 * k) + 1, sizeof(double)), *behind = ahead + k;
    for (int c = 0; c < k; ++c) {
        const double *a = s->w.direction + c * n;
        for (int r = 0; r < n; ++r) x[r] += a[r];
        forces_along(s, s->q, s->u, ahead);
        for (int r = 0; r < n; ++r) x[r] -= 2.0 * a[r];
        forces_along(s, s->q, s->u, behind);
        for (int r = 0; r < n; ++r) x[r] += a[r];
        for (int l = 0; l < k; ++l) {
            const double slope = 0.5 * (ahead[l] - behind[l]),
                         size = test_largest(2 * k, ahead) + test_largest(k * k, A);
            assert_close(A[c * k + l], slope, 1e-9 * (1.0 + size));
        }
    }
    free(ahead);
}

static void slopes_are_those_of_inverse_dynamics(void **state)
{
    (void)state;
    int seen = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        setting s;
        setup(&s, seed, seed % 2 ? 0.2 : 0.0, 1);
        assert_ok(mbsri_null_slopes(&s.w, now, s.q, s.u), mbsr_data_error(s.tree.data));
        assert_slopes(&s, s.w.C, s.u);
        /* the directions are the same in all positions when the joints are linear */
        if (seed % 2 == 0) assert_slopes(&s, s.w.S, s.q);
        if (s.w.k > 0) {
            seen += test_largest(s.w.k * s.w.k, s.w.C) > 0.1 &&
                    test_largest(s.w.k * s.w.k, s.w.S) > 0.1;
        }
        teardown(&s);
    }
    assert_true(seen > TREES / 4);
}

static void gamma_is_the_force_along_each_direction(void **state)
{
    (void)state;
    for (int seed = 1; seed <= TREES; ++seed) {
        setting s;
        setup(&s, seed, 0.2, 1);
        double *gamma = calloc((size_t)(2 * s.w.k) + 1, sizeof(double)), *same = gamma + s.w.k;
        forces_along(&s, s.q, s.u, same);
        assert_ok(mbsri_null_gamma(&s.w, now, s.q, s.u, gamma), mbsr_data_error(s.tree.data));
        for (int l = 0; l < s.w.k; ++l)
            assert_close(gamma[l], same[l], 1e-9 * (1.0 + fabs(same[l])));
        free(gamma);
        teardown(&s);
    }
}

/* Curved joints, a moving root and gyroscopic terms, but no force: every slope is exactly zero. */
static void without_forces_all_slopes_are_exactly_zero(void **state)
{
    (void)state;
    for (int seed = 1; seed <= TREES; ++seed) {
        setting s;
        setup(&s, seed, 0.2, 0);
        assert_ok(mbsri_null_slopes(&s.w, now, s.q, s.u), mbsr_data_error(s.tree.data));
        for (int l = 0; l < s.w.k * s.w.k; ++l) assert_true(s.w.C[l] == 0.0 && s.w.S[l] == 0.0);
        teardown(&s);
    }
}

/* Massless plates side by side on heavy carriers, each on its own spring-damper. */
static void directions_couple_only_where_forces_couple_them(void **state)
{
    (void)state;
    enum { ARMS = 5 };
    const mbsr_planar_frame origin = {0};
    mbsr_model *m;
    mbsr_data *d;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int arm = 0; arm < ARMS; ++arm) {
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_planar_revolute(origin, origin);
        body.inertia = mbsr_inertia_planar(1.0 + arm, (double[2]){0.5, 0.1}, 0.3);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        body.parent = 2 * arm;
        body.joint = mbsr_joint_planar_free(origin, origin);
        body.inertia = mbsr_inertia_zero();
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        const mbsr_force_def spring =
            mbsr_force_point_spring(2 * arm + 1, (double[3]){0.3, 0.2, 0.0}, MBSR_GROUND,
                                    (double[3]){-3.0, 2.0, 0.0}, 1e4 / (1 + arm), 7.0, 1.0);
        assert_int_equal(mbsr_model_add_force(m, &spring, NULL), MBSR_OK);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_int_equal(mbsr_model_add_force(m, &gravity, NULL), MBSR_OK);
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    double q[4 * ARMS], u[4 * ARMS];
    test_rng rng = test_seed(9);
    test_fill(&rng, 4 * ARMS, q);
    test_fill(&rng, 4 * ARMS, u);
    mbsri_null_space w;
    assert_ok(mbsri_null_open(&w, m, d, now, q, u, "test_null_space"), mbsr_data_error(d));
    assert_ok(mbsri_null_basis(&w, now, q, u), mbsr_data_error(d));
    assert_ok(mbsri_null_slopes(&w, now, q, u), mbsr_data_error(d));
    assert_int_equal(w.k, 3 * ARMS);
    for (int c = 0; c < w.k; ++c) {
        double inside = 0.0;
        for (int l = 0; l < w.k; ++l) {
            const double C = w.C[c * w.k + l], S = w.S[c * w.k + l];
            if (w.body[l] == w.body[c]) {
                inside = fmax(inside, fmin(fabs(C), fabs(S)));
            } else {
                assert_true(C == 0.0 && S == 0.0);
            }
        }
        assert_true(inside > 0.0);
    }
    mbsri_null_close(&w);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A massless rod of 0.7 m that turns, its tip, where its frame is, on a damper c to a point at 2 m:
 * with the damper's length l, l' = dl/dq and l'' the torque is Q = -c l'^2 u, its slopes -c l'^2
 * and -2 c l' l'' u.
 */
static void a_damper_that_turns_with_the_rod(void **state)
{
    (void)state;
    const double r = 0.7, far = 2.0, c = 3.0, q = 0.8, u = 1.5,
                 l = hypot(r * cos(q) - far, r * sin(q)), l1 = far * r * sin(q) / l,
                 l2 = (far * r * cos(q) - l1 * l1) / l;
    const mbsr_planar_frame origin = {0}, tail = {.x = -r};
    mbsr_model *m;
    mbsr_data *d;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    const int rod = test_add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(origin, tail),
                                  mbsr_inertia_zero());
    const mbsr_force_def damper =
        mbsr_force_point_spring(rod, NULL, MBSR_GROUND, (double[3]){far, 0.0, 0.0}, 0.0, c, 0.0);
    assert_int_equal(mbsr_model_add_force(m, &damper, NULL), MBSR_OK);
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    mbsri_null_space w;
    assert_ok(mbsri_null_open(&w, m, d, now, &q, &u, "test_null_space"), mbsr_data_error(d));
    assert_ok(mbsri_null_basis(&w, now, &q, &u), mbsr_data_error(d));
    assert_ok(mbsri_null_slopes(&w, now, &q, &u), mbsr_data_error(d));
    assert_int_equal(w.k, 1);
    const double square = w.direction[0] * w.direction[0];
    assert_close(w.C[0], -c * l1 * l1 * square, 1e-12 * c * square);
    assert_close(w.S[0], -2.0 * c * l1 * l2 * u * square, 1e-8 * c * square);
    mbsri_null_close(&w);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_basis_spans_the_null_space_of_the_mass_matrix),
        cmocka_unit_test(gamma_is_the_force_along_each_direction),
        cmocka_unit_test(slopes_are_those_of_inverse_dynamics),
        cmocka_unit_test(without_forces_all_slopes_are_exactly_zero),
        cmocka_unit_test(directions_couple_only_where_forces_couple_them),
        cmocka_unit_test(a_damper_that_turns_with_the_rod),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
