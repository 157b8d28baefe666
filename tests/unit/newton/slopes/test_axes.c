/* Derivatives of joints that are sequences of axes, in formulas, against those of joints of any
 * kind, which go through the joint's functions `tangent` and `rate_tangent`; and which joints are
 * taken for such. Free bodies and joints in the plane likewise.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/linear/linear.h"
#include "newton/slopes/axes.h"
#include "newton/slopes/joint_slopes.h"
#include "newton/slopes/planar_slopes.h"
#include "newton/slopes/steady_joint.h"
#include "newton_scene.h"
#include "recursion/inverse.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 400, COLUMNS = 24 };

/* Largest difference of a block beside its largest number. */
static void compare(const char *what, int rows, int columns, const double *x, int stride,
                    int outside, const double *reference, int reference_stride)
{
    double largest = 1.0, off = 0.0;
    for (int j = 0; j < columns; ++j) {
        const int from = j < outside ? j : j + outside / 2; /* behind those of A */
        for (int r = 0; r < rows; ++r) {
            const double of = reference[from * reference_stride + r];
            largest = fmax(largest, fabs(of));
            off = fmax(off, fabs(of - x[j * stride + r]));
        }
    }
    if (!(off <= 1e-12 * largest)) print_error("%s: off by %.2e\n", what, off);
    assert_true(off <= 1e-12 * largest);
}

static int check_joint(const mbsr_model *m, mbsr_data *d, int i, double *memory)
{
    static double x[12 * COLUMNS], below[12 * COLUMNS], own[12 * COLUMNS], qdot[6 * COLUMNS];
    const mbsri_body *b = m->body + i;
    mbsri_joint_slopes s;
    if (!mbsri_axes_serve(b)) return 0;
    mbsri_joint_slopes_place(&s, memory);
    assert_int_equal(mbsri_joint_slopes_of(m, d, i, false, d->udot + b->iu, &s), MBSR_OK);
    mbsri_axes_slopes(b, d, x, below, own, qdot);
    const int outside = 2 * b->pred.d, columns = outside + 2 * b->n;
    compare("motion", 12, columns, x, 12, outside, s.x, 18);
    compare("predecessor", outside, columns, below, 12, outside, s.below, 18);
    compare("own", 2 * b->n, columns, own, 2 * b->n, outside, s.own, 3 * b->n);
    compare("q'", b->n, columns, qdot, b->n, outside, s.qdot, b->n);
    return b->n;
}

static void formulas_are_those_of_the_joint(void **state)
{
    (void)state;
    int served[7] = {0}, others = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        test_rigid_tree tree;
        test_newton_state s;
        double x[MOST];
        const test_rigid_choice choice = {.seed = seed,
                                          .bodies = 12,
                                          .many = 0.7,
                                          .forces = 1,
                                          .moving = seed % 2,
                                          .armature = 0.3,
                                          .held = seed % 5 == 0 ? 0.2 : 0.0};
        test_newton_scene(&tree, &s, choice, MOST, x);
        const mbsr_model *m = tree.model;
        mbsr_data *d = tree.data;
        double *memory = malloc(mbsri_joint_slopes_size(m) * sizeof *memory),
               *spare = malloc((size_t)(m->nq + m->nu) * sizeof *spare);
        assert_int_equal(mbsri_linear_state(m, d, s.t, s.y, s.yp, spare), MBSR_OK);
        for (int i = 1; i <= m->bodies; ++i) {
            const int n = check_joint(m, d, i, memory);
            ++served[n];
            others += n == 0;
        }
        free(memory);
        free(spare);
        test_newton_scene_free(&tree, &s);
    }
    assert_true(served[1] > 50 && served[2] > 10 && served[3] > 10 && others > 10);
}

/* Six axes, a screw among them; a quaternion is none. */
static void joints_of_six_axes(void **state)
{
    (void)state;
    static const mbsr_axis axes[6] = {
        {MBSR_AXIS_SCREW, {1, 0, 0}, 0.1, 0},    {MBSR_AXIS_TRANSLATION, {0, 1, 0}, 0.0, 0},
        {MBSR_AXIS_ROTATION, {0, 0, 1}, 0.0, 0}, {MBSR_AXIS_TRANSLATION, {0, 0.6, 0.8}, 0.0, 0},
        {MBSR_AXIS_ROTATION, {0, 1, 0}, 0.0, 0}, {MBSR_AXIS_ROTATION, {0.8, 0, 0.6}, 0.0, 0}};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    test_newton_state s;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 3; ++k) {
        const mbsr_frame at = mbsr_frame_at(0.3, -0.2, 0.1 + 0.2 * k),
                         own = mbsr_frame_at(0.1, 0.2, 0.05);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.inertia = mbsr_inertia_in_frame(&own, mbsr_inertia_sphere(900.0, 0.2));
        body.joint = k == 1 ? mbsr_joint_spherical(&at, &own)
                            : mbsr_joint_compound(&at, &own, 6, axes, NULL, NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[16], u[15], spare[40];
    for (int k = 0; k < 16; ++k) q[k] = 0.3 * sin(k + 1.0);
    for (int k = 0; k < 15; ++k) u[k] = cos(3.0 * k);
    assert_ok(test_newton_start(&s, m, d, 0.0, q, u, NULL), mbsr_data_error(d));
    double *memory = malloc(mbsri_joint_slopes_size(m) * sizeof *memory);
    assert_int_equal(mbsri_linear_state(m, d, s.t, s.y, s.yp, spare), MBSR_OK);
    assert_int_equal(check_joint(m, d, 1, memory), 6);
    assert_int_equal(check_joint(m, d, 2, memory), 0);
    assert_int_equal(check_joint(m, d, 3, memory), 6);
    free(memory);
    test_newton_free(&s);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A free body, and a twin whose joint's frame is off its origin by nearly nothing, so that its
 * slopes come from the joint's functions. */
static void free_bodies_have_constant_axes(void **state)
{
    (void)state;
    const double q[7] = {0.9, -0.5, 0.3, 0.7, 0.4, -1.2, 2.5},
                 u[6] = {0.7, -1.1, 0.4, 2.0, 0.3, -0.8}, x[3] = {0.3, -0.2, 0.1},
                 z[3] = {0.36, 0.48, 0.8}, nearly[3] = {1e-15, 0.0, 0.0}, none[3] = {0.0};
    const mbsr_frame at = mbsr_frame_along(x, z);
    double of_x[2][18 * 19], rate[2][7 * 19], twice[2][14], spare[40];
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    test_newton_state s;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 2; ++k) {
        const mbsr_frame own = mbsr_frame_along(k ? nearly : none, z);
        mbsr_body_def body = mbsr_default_body_def();
        body.inertia = mbsr_inertia_sphere(900.0, 0.2);
        body.joint = mbsr_joint_free(&at, &own);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        memcpy(twice[0] + (ptrdiff_t)(7 * k), q, sizeof q);
        memcpy(twice[1] + (ptrdiff_t)(6 * k), u, sizeof u);
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(test_newton_start(&s, m, d, 0.0, twice[0], twice[1], NULL), mbsr_data_error(d));
    double *memory = malloc(mbsri_joint_slopes_size(m) * sizeof *memory);
    assert_int_equal(mbsri_linear_state(m, d, s.t, s.y, s.yp, spare), MBSR_OK);
    for (int k = 0; k < 2; ++k) {
        mbsri_joint_slopes to;
        assert_true(mbsri_steady_joint_serves(m->body + 1 + k) == (k == 0));
        mbsri_joint_slopes_place(&to, memory);
        assert_int_equal(mbsri_joint_slopes_of(m, d, 1 + k, true, u, &to), MBSR_OK);
        assert_int_equal(to.columns, 19);
        memcpy(of_x[k], to.x, sizeof of_x[k]);
        memcpy(rate[k], to.qdot, sizeof rate[k]);
        for (int l = 0; l < 18 * 19; ++l) assert_true(k == 0 || fabs(to.own[l]) < 1e-11);
    }
    compare("motion", 18, 19, of_x[0], 18, 0, of_x[1], 18);
    compare("q'", 7, 19, rate[0], 7, 0, rate[1], 7);
    free(memory);
    test_newton_free(&s);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- in the plane ---- */

enum { LINKS = 5 };

static int drive(void *user, double t, double *value, double *rate, double *acceleration)
{
    (void)user;
    for (int k = 0; k < 2; ++k) {
        value[k] = 0.3 * sin(t + k);
        rate[k] = 0.9 * cos(t + k);
        acceleration[k] = 1.1 * (1 - k);
    }
    return 0;
}

/* A chain, and behind it a twin whose joints have a table of its own. */
static mbsr_model *two_chains(test_rng *rng, mbsr_joint_table *copy)
{
    mbsr_model *m = NULL;
    mbsr_body_def link[LINKS];
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 2 * LINKS; ++k) {
        double a[8];
        mbsr_body_def *body = link + k % LINKS;
        test_fill(rng, 8, a);
        const int free = k == LINKS - 1 ? MBSR_ANGLE : test_integer(rng, 1, 7),
                  driven = test_integer(rng, 0, 2) ? 0 : (7 ^ free) & test_integer(rng, 0, 6);
        if (k < LINKS) {
            *body = mbsr_default_body_def();
            body->joint = mbsr_joint_planar((mbsr_planar_frame){a[0], a[1], 3.0 * a[2]},
                                            (mbsr_planar_frame){a[3], a[4], 3.0 * a[5]}, free,
                                            driven, driven ? drive : NULL, NULL);
            body->inertia = mbsr_inertia_planar(1.5, a + 6, 0.4);
        } else {
            *copy = *body->joint.table;
            body->joint.table = copy;
        }
        body->parent = k % LINKS ? k - 1 : MBSR_GROUND;
        assert_ok(mbsr_model_add_body(m, body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* The slopes of both twins of a link. */
static void check_link(const mbsr_model *m, mbsr_data *d, int i, const double *udot)
{
    const size_t size = mbsri_joint_slopes_size(m);
    double *memory = malloc(2 * size * sizeof *memory);
    mbsri_joint_slopes s[2];
    for (int k = 0; k < 2; ++k) {
        const mbsri_body *b = m->body + i + k * LINKS;
        assert_true(mbsri_planar_slopes_serve(b) == (k == 0));
        mbsri_joint_slopes_place(s + k, memory + (size_t)k * size);
        assert_int_equal(mbsri_joint_slopes_of(m, d, i + k * LINKS, true, udot + b->iu, s + k), 0);
    }
    const int count = (int)(s[0].work - s[0].x);
    assert_int_equal(count, s[1].work - s[1].x);
    compare("in the plane", count, 1, s[0].x, count, 0, s[1].x, count);
    free(memory);
}

static void joints_in_the_plane(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        double q[6 * LINKS], u[6 * LINKS], udot[6 * LINKS], spare[12 * LINKS];
        test_rng rng = test_seed(seed);
        mbsr_joint_table copy;
        mbsr_data *d = NULL;
        test_newton_state s;
        mbsr_model *m = two_chains(&rng, &copy);
        const int n = m->nu / 2;
        double *const vector[] = {q, u, udot};
        for (int k = 0; k < 3; ++k) {
            test_fill(&rng, n, vector[k]);
            memcpy(vector[k] + n, vector[k], (size_t)n * sizeof q[0]);
        }
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(test_newton_start(&s, m, d, 0.7, q, u, NULL), mbsr_data_error(d));
        assert_int_equal(mbsri_linear_state(m, d, s.t, s.y, s.yp, spare), MBSR_OK);
        mbsri_inverse(m, d, udot);
        for (int i = 1; i <= LINKS; ++i) check_link(m, d, i, udot);
        test_newton_free(&s);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formulas_are_those_of_the_joint),
        cmocka_unit_test(joints_of_six_axes),
        cmocka_unit_test(free_bodies_have_constant_axes),
        cmocka_unit_test(joints_in_the_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
