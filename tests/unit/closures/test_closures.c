/* Rows of closures: derivatives and biases against differences, forces against virtual power.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <mbsrank/driver.h>
#include <mbsrank/verify.h>

#include <stdbool.h>
#include <string.h>

static int swing(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    /* a planar root */
    p[0] = 0.3 * sin(2.0 * t), V[0] = 0.6 * cos(2.0 * t), A[0] = -1.2 * sin(2.0 * t);
    p[1] = 0.2 * t, V[1] = 0.2, A[1] = 0.0;
    p[2] = 0.7 * sin(t), V[2] = 0.7 * cos(t), A[2] = -0.7 * sin(t);
    return 0;
}

/* A root in space that turns about an oblique axis and moves. */
static int tumble(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const double axis[3] = {2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0}, angle = 0.4 * sin(1.5 * t),
                 rate = 0.6 * cos(1.5 * t), change = -0.9 * sin(1.5 * t);
    const mbsr_frame frame = mbsr_frame_rotated(NULL, axis, angle);
    memcpy(p + MBSR_POSE_R, frame.R, sizeof frame.R);
    for (int k = 0; k < 3; ++k) {
        V[k] = rate * axis[k];
        A[k] = change * axis[k];
        p[MBSR_POSE_X + k] = 0.1 * k * sin(t);
        V[3 + k] = 0.1 * k * cos(t);
        A[3 + k] = -0.1 * k * sin(t);
    }
    return 0;
}

static int three(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    for (int k = 0; k < 3; ++k) {
        s[k] = 0.4 + 0.1 * sin(t + k);
        sdot[k] = 0.1 * cos(t + k);
        sddot[k] = -0.1 * sin(t + k);
    }
    return 0;
}

static int one(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 0.9 + 0.1 * sin(2.0 * t);
    *sdot = 0.2 * cos(2.0 * t);
    *sddot = -0.4 * sin(2.0 * t);
    return 0;
}

static int body(loops *s, int parent, mbsr_joint joint)
{
    int id;
    mbsr_body_def def = mbsr_default_body_def();
    def.parent = parent;
    def.joint = joint;
    assert_ok(mbsr_model_add_body(s->m, &def, &id), mbsr_model_error(s->m));
    return id;
}

static void add(loops *s, mbsr_closure_def def)
{
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* ---- a closure of the caller's own, with and without its derivatives: g = r_a . r_b - t^2 - q
 * ---- */

static int own_position(const mbsr_closure_args *args, double *g)
{
    const double *a = args->body[0].p + MBSR_POSE_X, *b = args->body[1].p + MBSR_POSE_X;
    g[0] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - args->t * args->t - sin(args->body[1].q[0]);
    return 0;
}

static int own_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    for (int k = 0; k < 3; ++k) {
        out->matrix[out->column[0] + 3 + k] = args->body[1].p[MBSR_POSE_X + k];
        out->matrix[out->column[1] + 3 + k] = args->body[0].p[MBSR_POSE_X + k];
    }
    out->matrix[out->column[1] + 6] = -cos(args->body[1].q[0]);
    return 0;
}

static int own_drift(const mbsr_closure_args *args, double *gt)
{
    gt[0] = -2.0 * args->t;
    return 0;
}

static int own_bias(const mbsr_closure_args *args, double *bias)
{
    const double *a = args->body[0].V + 3, *b = args->body[1].V + 3;
    const double q = args->body[1].q[0], u = args->body[1].u[0];
    bias[0] = 2.0 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) - 2.0 + sin(q) * u * u;
    return 0;
}

static const mbsr_closure_table own[] = {{.version = MBSR_CLOSURE_TABLE_VERSION,
                                          .flags = MBSR_CLOSURE_JOINTS,
                                          .name = "bare",
                                          .position = own_position},
                                         {.version = MBSR_CLOSURE_TABLE_VERSION,
                                          .flags = MBSR_CLOSURE_JOINTS,
                                          .name = "slopes",
                                          .position = own_position,
                                          .jacobian = own_jacobian},
                                         {.version = MBSR_CLOSURE_TABLE_VERSION,
                                          .flags = MBSR_CLOSURE_JOINTS,
                                          .name = "all",
                                          .position = own_position,
                                          .jacobian = own_jacobian,
                                          .drift = own_drift,
                                          .bias = own_bias}};

/* ---- models with every closure ---- */

static mbsr_closure_def stiff(mbsr_closure_def def, int rows)
{
    for (int k = 0; k < rows; ++k) def.stiffness[k] = 1e3 * (k + 1);
    return def;
}

static mbsr_closure_def moving(mbsr_closure_def def, mbsr_motion_fn motion)
{
    def.motion = motion;
    return def;
}

/* Bodies in space, and points and frames on them. */
typedef struct bodies {
    int a, b, c, d, flat;
    mbsr_frame A, B, C;
} bodies;

static const double point_p[3] = {0.4, 0.1, -0.2}, point_q[3] = {0.1, -0.3, 0.5};

static bodies begin_space(loops *s, bool moving_root)
{
    const mbsr_root root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, tumble, NULL);
    const double x[3] = {1.0, 0.2, 0.1}, y[3] = {-0.3, 1.0, 0.2};
    const mbsr_axis axes[3] = {{MBSR_AXIS_ROTATION, {1.0, 0.0, 0.0}, 0.0, 0},
                               {MBSR_AXIS_ROTATION, {0.0, 1.0, 0.0}, 0.0, 0},
                               {MBSR_AXIS_TRANSLATION, {0.0, 0.0, 1.0}, 0.0, 0}};
    const mbsr_planar_frame at = {0.1, 0.2, 0.3}, on = {0.0, 0.1, 0.2};
    bodies o = {.A = mbsr_frame_rotated(point_p, x, 0.5),
                .B = mbsr_frame_rotated(point_q, y, -0.7),
                .C = mbsr_frame_rotated(point_q, x, 0.2)};
    loops_begin(s, moving_root ? &root : NULL);
    o.a = body(s, MBSR_GROUND, mbsr_joint_compound(&o.A, NULL, 3, axes, NULL, NULL));
    o.b = body(s, o.a, mbsr_joint_revolute(&o.B, NULL, y));
    o.c = body(s, MBSR_GROUND, mbsr_joint_cylindrical(&o.C, NULL, x));
    o.d = body(s, o.c, mbsr_joint_universal(&o.A, NULL, x, y));
    o.flat = body(s, MBSR_GROUND,
                  moving_root ? mbsr_joint_in_plane(&o.A, &o.B) : mbsr_joint_planar_free(at, on));
    return o;
}

static void make_space(loops *s, bool moving_root)
{
    const bodies o = begin_space(s, moving_root);
    const double *p = point_p, *q = point_q, lines[6] = {1.0, 2.0, 2.0, 0.0, 3.0, -1.0};
    add(s, mbsr_closure_weld(o.b, &o.A, o.d, &o.B));
    add(s, mbsr_closure_weld(o.b, &o.A, MBSR_GROUND, &o.C));
    add(s, mbsr_closure_ball(o.b, p, o.d, q));
    add(s, moving(mbsr_closure_ball(o.d, p, MBSR_GROUND, q), three));
    add(s, moving(mbsr_closure_rows(o.d, p, o.b, q, 2, lines), three));
    add(s, mbsr_closure_rows(MBSR_GROUND, p, o.b, q, 1, lines));
    add(s, mbsr_closure_distance(o.b, p, o.d, q, 0.8));
    add(s, moving(mbsr_closure_distance(o.b, p, MBSR_GROUND, q, 0.8), one));
    add(s, mbsr_closure_rolling_ball(o.b, p, 0.3, o.d, &o.A));
    add(s, mbsr_closure_rolling_disc(o.b, &o.B, 0.4, o.d, &o.A));
    add(s, mbsr_closure_rolling_disc(o.b, &o.B, 0.4, MBSR_GROUND, &o.C));
    add(s, mbsr_closure_weld(o.flat, &o.A, o.d, &o.B));
    add(s, mbsr_closure_ball(o.flat, p, o.b, q));
    add(s, moving(mbsr_closure_coupling(3, (int[3]){o.a, o.b, o.a}, (int[3]){2, 0, 0},
                                        (double[3]){1.5, -2.0, 0.5}, 0.3),
                  one));
    for (int k = 0; k < 3; ++k)
        add(s, mbsr_closure_custom(own + k, 2, (int[2]){o.d, o.b}, 1, 1, NULL));
    add(s, moving(mbsr_closure_body_rows(o.d, p, o.b, q, 2, lines), three));
    add(s, mbsr_closure_body_rows(o.b, p, MBSR_GROUND, q, 1, lines));
    add(s, mbsr_closure_body_rows(o.flat, p, o.d, q, 3, (double[9]){1, 0, 0, 0, 1, 0, 0.5, 0, 1}));
    loops_finish(s);
}

/* Rows with springs, which may have gaps. */
static void make_stiff(loops *s, bool moving_root)
{
    const bodies o = begin_space(s, moving_root);
    add(s, stiff(mbsr_closure_weld(o.b, &o.A, o.d, &o.B), 6));
    add(s, stiff(mbsr_closure_weld(o.b, &o.A, MBSR_GROUND, &o.C), 4));
    add(s, stiff(mbsr_closure_weld(MBSR_GROUND, &o.A, o.d, &o.B), 6));
    add(s, stiff(mbsr_closure_weld(o.d, &o.A, o.flat, &o.B), 5));
    add(s, stiff(mbsr_closure_ball(o.b, point_p, o.d, point_q), 2));
    add(s, moving(stiff(mbsr_closure_ball(o.d, point_p, o.b, point_q), 3), three));
    loops_finish(s);
}

static void make_plane(loops *s, bool moving_root)
{
    const mbsr_root root = mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, swing, NULL);
    const double z[3] = {0.0, 0.0, 1.0}, p[3] = {0.4, 0.1, 0.0}, q[3] = {0.1, -0.3, 0.0},
                 lines[6] = {1.0, 2.0, 0.0, 0.0, 3.0, 0.0}, up[3] = {0.3, 1.0, 0.0};
    const mbsr_frame A = mbsr_frame_rotated(p, z, 0.5), B = mbsr_frame_rotated(q, z, -0.7),
                     plane = mbsr_frame_along(q, up);
    loops_begin(s, moving_root ? &root : NULL);
    const int a = loops_rod(s, "a", MBSR_GROUND, 0.1, 0.2, 1.0, 1.0);
    const int b = loops_rod(s, "b", a, 1.0, 0.0, 1.0, 0.8);
    const int c = body(s, MBSR_GROUND,
                       mbsr_joint_planar_free((mbsr_planar_frame){0.5, 0.1, 0.4},
                                              (mbsr_planar_frame){0.2, 0.1, 0.0}));
    const int point = body(
        s, a, mbsr_joint_point((mbsr_planar_frame){0.5, 0.1, 0.4}, MBSR_X | MBSR_Y, 0, NULL, NULL));
    add(s, mbsr_closure_weld(b, &A, c, &B));
    add(s, mbsr_closure_weld(MBSR_GROUND, &A, c, &B));
    add(s, mbsr_closure_weld(point, NULL, c, &B));
    add(s, mbsr_closure_ball(b, p, c, q));
    add(s, mbsr_closure_ball(point, NULL, c, q));
    add(s, mbsr_closure_rows(b, p, MBSR_GROUND, q, 2, lines));
    add(s, moving(mbsr_closure_rows(b, p, c, q, 1, lines), three));
    add(s, moving(mbsr_closure_body_rows(b, p, c, q, 2, lines), three));
    add(s, mbsr_closure_body_rows(MBSR_GROUND, p, c, q, 1, lines));
    add(s, mbsr_closure_distance(b, p, c, q, 0.5));
    add(s, mbsr_closure_rolling_ball(c, p, 0.4, b, &plane));
    add(s, mbsr_closure_rolling_ball(c, p, 0.4, MBSR_GROUND, &plane));
    add(s, mbsr_closure_coupling(2, (int[2]){a, b}, (int[2]){0, 0}, (double[2]){1.0, -2.0}, 0.1));
    add(s, stiff(mbsr_closure_weld(b, &A, c, &B), 3));
    add(s, stiff(mbsr_closure_weld(MBSR_GROUND, &A, c, &B), 3));
    add(s, stiff(mbsr_closure_ball(b, p, c, q), 2));
    add(s, stiff(mbsr_closure_ball(point, NULL, c, q), 1));
    loops_finish(s);
}

/* ---- tests ---- */

static void verify_all(loops *s, double t)
{
    assert_ok(mbsr_stage_positions(s->m, s->d, t, s->q), mbsr_data_error(s->d));
    assert_ok(mbsr_stage_velocities(s->m, s->d, s->u), mbsr_data_error(s->d));
    for (int id = 0; id < mbsr_model_closures(s->m); ++id) {
        mbsr_closure_errors e;
        int rows, held;
        assert_ok(mbsr_closure_verify(s->m, s->d, id, &e), mbsr_data_error(s->d));
        assert_ok(mbsr_closure_indices(s->m, id, NULL, &rows, NULL, &held), NULL);
        if (e.bias > 1e-7 || e.drift > 1e-8) print_error("closure %d: %s\n", id, e.text);
        assert_less(e.drift, 1e-8);
        assert_less(e.bias, 1e-7);
    }
}

/* C u + g_t and its derivative against differences over time of the state (q + t u, u), by the
 * library's functions for whole trees; turns of open welds left out, see mbsr_closure_weld. */
static void differ(loops *s, double t, const bool *turn)
{
    static const double place[] = {1.0, -1.0, 2.0, -2.0}, weight[] = {8.0, -8.0, -1.0, 1.0};
    const double h = 1e-3;
    double rate[LOOPS_MOST], bias[LOOPS_MOST], g[LOOPS_MOST], r[LOOPS_MOST], q[LOOPS_MOST];
    double by_g[LOOPS_MOST] = {0.0}, by_r[LOOPS_MOST] = {0.0};
    for (int l = 0; l < 4; ++l) {
        for (int k = 0; k < s->nq; ++k) q[k] = s->q[k] + place[l] * h * s->u[k];
        loops_rows(s, t + place[l] * h, q, s->u, NULL, g, r, NULL);
        for (int k = 0; k < s->position_rows; ++k) by_g[k] += weight[l] * g[k] / (12.0 * h);
        for (int k = 0; k < s->rows; ++k) by_r[k] += weight[l] * r[k] / (12.0 * h);
    }
    loops_rows(s, t, s->q, s->u, NULL, g, rate, bias);
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows, held_row, held;
        assert_ok(mbsr_closure_indices(s->m, c, &row, &rows, &held_row, &held), NULL);
        for (int k = 0; k < held; ++k) {
            if (!turn[row + k]) assert_close(rate[row + k], by_g[held_row + k], 1e-8);
        }
        for (int k = 0; k < rows; ++k) assert_close(bias[row + k], by_r[row + k], 1e-7);
    }
}

/* lambda . (C x) = x . (C^T lambda). */
static void power(loops *s, double t, test_rng *rng)
{
    double x[LOOPS_MOST], lambda[LOOPS_MOST], Cx[LOOPS_MOST], Ctl[LOOPS_MOST], sum = 0.0;
    test_fill(rng, s->nu, x);
    test_fill(rng, s->rows, lambda);
    assert_ok(mbsr_stage_positions(s->m, s->d, t, s->q), NULL);
    assert_ok(mbsr_closures_apply(s->m, s->d, x, Cx), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_transpose(s->m, s->d, lambda, Ctl), mbsr_data_error(s->d));
    for (int k = 0; k < s->rows; ++k) sum += lambda[k] * Cx[k];
    for (int k = 0; k < s->nu; ++k) sum -= x[k] * Ctl[k];
    assert_close(sum, 0.0, 1e-12);
}

static void try_rows(void (*make)(loops *, bool), bool moving_root, const bool *turn)
{
    loops s;
    make(&s, moving_root);
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        test_rng rng = test_seed(seed);
        test_fill(&rng, s.nq, s.q);
        test_fill(&rng, s.nu, s.u);
        verify_all(&s, 0.7);
        differ(&s, 0.7, turn);
        power(&s, 0.7, &rng);
    }
    loops_free(&s);
}

static void rows_in_space(void **state)
{
    (void)state;
    bool turn[LOOPS_MOST] = {false};
    for (int k = 0; k < 3; ++k) turn[k] = turn[6 + k] = true;
    for (int k = 0; k < 3; ++k) turn[32 + k] = true; /* the weld of a body in the plane */
    try_rows(make_space, false, turn);
    try_rows(make_space, true, turn);
}

static void stiff_rows_in_space(void **state)
{
    (void)state;
    const bool turn[LOOPS_MOST] = {false};
    try_rows(make_stiff, false, turn);
    try_rows(make_stiff, true, turn);
}

static void rows_in_the_plane(void **state)
{
    (void)state;
    const bool turn[LOOPS_MOST] = {false};
    try_rows(make_plane, false, turn);
    try_rows(make_plane, true, turn);
}

/* Derivatives that are wrong are found. */
static int wrong_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    own_jacobian(args, out);
    out->matrix[out->column[0] + 4] *= 1.01;
    return 0;
}

static void a_wrong_derivative_is_found(void **state)
{
    (void)state;
    static const mbsr_closure_table wrong = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                             .flags = MBSR_CLOSURE_JOINTS,
                                             .name = "wrong",
                                             .position = own_position,
                                             .jacobian = wrong_jacobian};
    loops s;
    mbsr_closure_errors e;
    loops_begin(&s, NULL);
    const double z[3] = {0.0, 0.0, 1.0}, x[3] = {1.0, 1.0, 0.0};
    const mbsr_frame A = mbsr_frame_at(0.3, 0.2, 0.5);
    const int a = body(&s, MBSR_GROUND, mbsr_joint_translational(&A, NULL));
    const int b = body(&s, a, mbsr_joint_revolute(&A, NULL, z));
    const int c = body(&s, b, mbsr_joint_revolute(&A, NULL, x));
    add(&s, mbsr_closure_custom(&wrong, 2, (int[2]){a, c}, 1, 1, NULL));
    loops_finish(&s);
    for (int k = 0; k < s.nq; ++k) s.q[k] = s.u[k] = 0.3 + 0.1 * k;
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.2, s.q), NULL);
    assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
    assert_ok(mbsr_closure_verify(s.m, s.d, 0, &e), mbsr_data_error(s.d));
    assert_true(e.jacobian > 1e-4);
    assert_contains(e.text, "jacobian|row 0|column 4");
    loops_free(&s);
}

/* The turn of a weld: its rotation vector, over more than a right angle; stiff rows have its exact
 * derivative, rigid ones that of closed frames. */
static void turns_of_a_weld(void **state)
{
    (void)state;
    for (int stiff = 0; stiff < 2; ++stiff) {
        loops s;
        loops_begin(&s, NULL);
        const int a = body(&s, MBSR_GROUND, mbsr_joint_spherical(NULL, NULL));
        mbsr_closure_def weld = mbsr_closure_weld(a, NULL, MBSR_GROUND, NULL);
        for (int k = 0; k < 6 && stiff; ++k) weld.stiffness[k] = 1e3;
        add(&s, weld);
        loops_finish(&s);
        const double axis[3] = {1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0}, angle = 2.5;
        double g[6];
        s.q[0] = cos(0.5 * angle);
        for (int k = 0; k < 3; ++k) s.q[1 + k] = sin(0.5 * angle) * axis[k];
        for (int k = 0; k < 3; ++k) s.u[k] = 0.3 * k - 0.2;
        loops_rows(&s, 0.0, s.q, s.u, NULL, g, NULL, NULL);
        for (int k = 0; k < 3; ++k) assert_close(g[k], angle * axis[k], 1e-14);
        mbsr_closure_errors e;
        assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
        assert_ok(mbsr_closure_verify(s.m, s.d, 0, &e), mbsr_data_error(s.d));
        if (stiff)
            assert_less(e.jacobian, 1e-8);
        else
            assert_true(e.jacobian > 0.1);
        s.q[0] = 1.0, s.q[1] = s.q[2] = s.q[3] = 0.0;
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), NULL);
        assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
        assert_ok(mbsr_closure_verify(s.m, s.d, 0, &e), mbsr_data_error(s.d));
        assert_less(e.jacobian, 1e-8);
        loops_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_in_space), cmocka_unit_test(stiff_rows_in_space),
        cmocka_unit_test(rows_in_the_plane), cmocka_unit_test(a_wrong_derivative_is_found),
        cmocka_unit_test(turns_of_a_weld)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
