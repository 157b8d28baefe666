/* The stock joints against an independent composition of homogeneous transforms and against
 * differences of it.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

/* ---- the independent kinematics: 3 x 3 matrices, row by row ---------------------------------- */

typedef struct transform {
    double m[3][3];
} transform;

static transform turn_and_shift(double x, double y, double angle)
{
    return (transform){
        {{cos(angle), -sin(angle), x}, {sin(angle), cos(angle), y}, {0.0, 0.0, 1.0}}};
}

static transform product(transform a, transform b)
{
    transform c = {{{0}}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) c.m[i][j] += a.m[i][k] * b.m[k][j];
        }
    }
    return c;
}

/* Inverse of a rotation and shift. */
static transform inverse(transform a)
{
    transform c = {{{a.m[0][0], a.m[1][0], 0.0}, {a.m[0][1], a.m[1][1], 0.0}, {0.0, 0.0, 1.0}}};
    for (int i = 0; i < 2; ++i) c.m[i][2] = -c.m[i][0] * a.m[0][2] - c.m[i][1] * a.m[1][2];
    return c;
}

/* ---- joints under test: every way to make a coordinate free, driven or locked ---------------- */

typedef struct sample {
    mbsr_planar_frame A, B;
    int d, free, driven;
    int drives; /* number of driven coordinates */
    mbsr_joint joint;
} sample;

static double wave(int k, double t, int derivative)
{
    const double a = 0.3 + 0.2 * k, w = 1.1 + 0.4 * k, phase = 0.5 * k + 0.2;
    if (derivative == 0) return a * sin(w * t + phase);
    return derivative == 1 ? a * w * cos(w * t + phase) : -a * w * w * sin(w * t + phase);
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    const sample *w = user;
    for (int k = 0; k < w->drives; ++k)
        s[k] = wave(k, t, 0), sdot[k] = wave(k, t, 1), sddot[k] = wave(k, t, 2);
    return 0;
}

/* Number `index` of 27 planar and 9 point joints (index 27 .. 35): base 3, locked, free, driven. */
enum { SAMPLES = 36 };

static void make_sample(sample *w, int index, test_rng *rng)
{
    *w = (sample){.A = {test_uniform(rng), test_uniform(rng), 3.0 * test_uniform(rng)},
                  .B = {test_uniform(rng), test_uniform(rng), 3.0 * test_uniform(rng)},
                  .d = index < 27 ? 3 : 2};
    for (int k = 0, rest = index < 27 ? index : index - 27; k < w->d; ++k, rest /= 3) {
        if (rest % 3 == 1) w->free |= 1 << k;
        if (rest % 3 == 2) w->driven |= 1 << k, ++w->drives;
    }
    w->joint = w->d == 3 ? mbsr_joint_planar(w->A, w->B, w->free, w->driven, drive, w)
                         : mbsr_joint_point(w->A, w->free, w->driven, drive, w);
}

/* Pose of the body by transforms; `space` and pose of the predecessor. */
static void compose(const sample *w, mbsr_space space, const double *p_pred, const double *q,
                    double t, double *p)
{
    transform T = turn_and_shift(0.0, 0.0, 0.0);
    double s[3] = {0.0, 0.0, 0.0};
    if (space == MBSR_SPACE_POINT) T = turn_and_shift(p_pred[0], p_pred[1], 0.0);
    if (space == MBSR_SPACE_PLANAR) T = turn_and_shift(p_pred[0], p_pred[1], p_pred[2]);
    for (int k = 0, free = 0, driven = 0; k < 3; ++k) {
        if (w->free & (1 << k)) s[k] = q[free++];
        if (w->driven & (1 << k)) s[k] = wave(driven++, t, 0);
    }
    T = product(T, turn_and_shift(w->A.x, w->A.y, w->A.angle));
    T = product(T, turn_and_shift(s[0], s[1], s[2]));
    if (w->d == 3) T = product(T, inverse(turn_and_shift(w->B.x, w->B.y, w->B.angle)));
    p[0] = T.m[0][2];
    p[1] = T.m[1][2];
    /* the angle itself cannot be read from the matrix; its sine and cosine must fit */
    if (w->d == 2) return;
    p[2] = (space == MBSR_SPACE_PLANAR ? p_pred[2] : 0.0) + w->A.angle + s[2] - w->B.angle;
    assert_close(cos(p[2]), T.m[0][0], 1e-14);
    assert_close(sin(p[2]), T.m[1][0], 1e-14);
}

static const struct {
    mbsr_space space;
    int d;
} predecessors[] = {{MBSR_SPACE_FIXED, 0}, {MBSR_SPACE_POINT, 2}, {MBSR_SPACE_PLANAR, 3}};

/* Calls `check` for every joint on every predecessor. */
static void for_all(void (*check)(const sample *w, mbsr_space space, int d_pred, test_rng *rng))
{
    test_rng rng = test_seed(11);
    for (int index = 0; index < SAMPLES; ++index) {
        for (int k = 0; k < 3; ++k) {
            sample w;
            make_sample(&w, index, &rng);
            w.joint.user = &w;
            check(&w, predecessors[k].space, predecessors[k].d, &rng);
        }
    }
}

/* Arguments of a call of the table; a root at rest has no pose, so NULL must do. */
static mbsr_joint_args make_args(const sample *w, mbsr_space space, int d_pred, double t,
                                 const double *q, const double *p_pred)
{
    return (mbsr_joint_args){.param = w->joint.param,
                             .option = w->joint.option,
                             .motion = w->joint.motion,
                             .user = w->joint.user,
                             .d = w->joint.d,
                             .np = w->joint.np,
                             .n = w->joint.n,
                             .nq = w->joint.nq,
                             .t = t,
                             .q = q,
                             .pred_space = space,
                             .pred_d = d_pred,
                             .p_pred = d_pred ? p_pred : NULL};
}

/* Position and Jacobians by the table, preset as the library does it. */
typedef struct frame {
    double p[3], H[9], J[9], kI[3];
} frame;

static void call(const sample *w, mbsr_space space, int d_pred, double t, const double *q,
                 const double *p_pred, frame *f)
{
    mbsr_joint_args args = make_args(w, space, d_pred, t, q, p_pred);
    *f = (frame){{0}, {0}, {0}, {0}};
    assert_int_equal(w->joint.table->position(&args, f->p), 0);
    args.p = f->p;
    assert_int_equal(w->joint.table->jacobians(&args, NULL, f->H, f->J, f->kI), 0);
}

/* ---- position and its derivatives ------------------------------------------------------------ */

static void check_position(const sample *w, mbsr_space space, int d_pred, test_rng *rng)
{
    double q[3], p_pred[3], expected[3];
    frame f;
    test_fill(rng, 3, q);
    test_fill(rng, 3, p_pred);
    const double t = test_uniform(rng);
    call(w, space, d_pred, t, q, p_pred, &f);
    compose(w, space, p_pred, q, t, expected);
    for (int k = 0; k < w->d; ++k) assert_close(f.p[k], expected[k], 1e-14);
}

static void positions_agree_with_transforms(void **state)
{
    (void)state;
    for_all(check_position);
}

/* A column of -dg/dx by central differences of compose(); x points into q, p_pred or at t. */
static void difference(const sample *w, mbsr_space space, const double *p_pred, const double *q,
                       const double *t, double *x, double *column)
{
    const double h = 1e-5, held = *x;
    double ahead[3], behind[3];
    *x = held + h;
    compose(w, space, p_pred, q, *t, ahead);
    *x = held - h;
    compose(w, space, p_pred, q, *t, behind);
    *x = held;
    for (int k = 0; k < w->d; ++k) column[k] = -(ahead[k] - behind[k]) / (2.0 * h);
}

static void check_jacobians(const sample *w, mbsr_space space, int d_pred, test_rng *rng)
{
    double q[3], p_pred[3], t = test_uniform(rng), column[3];
    frame f;
    test_fill(rng, 3, q);
    test_fill(rng, 3, p_pred);
    call(w, space, d_pred, t, q, p_pred, &f);
    for (int c = 0; c < w->joint.n; ++c) {
        difference(w, space, p_pred, q, &t, q + c, column);
        for (int k = 0; k < w->d; ++k) assert_close(f.J[c * w->d + k], column[k], 1e-9);
    }
    for (int c = 0; c < d_pred; ++c) {
        difference(w, space, p_pred, q, &t, p_pred + c, column);
        for (int k = 0; k < w->d; ++k) assert_close(f.H[c * w->d + k], column[k], 1e-9);
    }
    difference(w, space, p_pred, q, &t, &t, column);
    for (int k = 0; k < w->d; ++k) assert_close(f.kI[k], column[k], 1e-9);
    /* nothing is written beyond the columns there are */
    for (int k = w->joint.n * w->d; k < 9; ++k) assert_close(f.J[k], 0.0, 0.0);
    for (int k = d_pred * w->d; k < 9; ++k) assert_close(f.H[k], 0.0, 0.0);
}

static void jacobians_agree_with_differences_of_transforms(void **state)
{
    (void)state;
    for_all(check_jacobians);
}

/* ---- along a motion -------------------------------------------------------------------------- */

/* A smooth motion of coordinate k and its derivatives. */
static double path(int k, double t, int derivative)
{
    const double w = 0.9 + 0.35 * k;
    if (derivative == 0) return 0.2 * k + 0.7 * sin(w * t + k) + 0.1 * t * t;
    return derivative == 1 ? 0.7 * w * cos(w * t + k) + 0.2 * t
                           : -0.7 * w * w * sin(w * t + k) + 0.2;
}

/* Everything at time t: poses, V = -(H V_pred + J u + kI). */
typedef struct moment {
    double q[3], u[3], p_pred[3], V_pred[3], V[3];
    frame f;
} moment;

static void at(const sample *w, mbsr_space space, int d_pred, double t, moment *s)
{
    for (int k = 0; k < 3; ++k) {
        s->q[k] = path(k, t, 0), s->u[k] = path(k, t, 1);
        s->p_pred[k] = path(k + 3, t, 0), s->V_pred[k] = path(k + 3, t, 1);
    }
    call(w, space, d_pred, t, s->q, s->p_pred, &s->f);
    for (int k = 0; k < w->d; ++k) {
        s->V[k] = -s->f.kI[k];
        for (int c = 0; c < d_pred; ++c) s->V[k] -= s->f.H[c * w->d + k] * s->V_pred[c];
        for (int c = 0; c < w->joint.n; ++c) s->V[k] -= s->f.J[c * w->d + k] * s->u[c];
    }
}

static void check_bias(const sample *w, mbsr_space space, int d_pred, test_rng *rng)
{
    const double t = test_uniform(rng), h = 1e-5;
    moment now, ahead, behind;
    double kII[3] = {0}, Hdot[9] = {0}, Jdot[9] = {0};
    at(w, space, d_pred, t, &now);
    at(w, space, d_pred, t + h, &ahead);
    at(w, space, d_pred, t - h, &behind);
    mbsr_joint_args args = make_args(w, space, d_pred, t, now.q, now.p_pred);
    args.u = now.u;
    args.V_pred = d_pred ? now.V_pred : NULL;
    args.p = now.f.p;
    args.V = now.V;
    assert_int_equal(w->joint.table->bias(&args, kII), 0);
    assert_int_equal(w->joint.table->rates(&args, NULL, Hdot, Jdot), 0);
    for (int k = 0; k < w->d; ++k) {
        /* V is the velocity, and kII = -(V' + H V_pred' + J u') */
        assert_close(now.V[k], (ahead.f.p[k] - behind.f.p[k]) / (2.0 * h), 1e-8);
        double expected = -(ahead.V[k] - behind.V[k]) / (2.0 * h);
        for (int c = 0; c < d_pred; ++c) expected -= now.f.H[c * w->d + k] * path(c + 3, t, 2);
        for (int c = 0; c < w->joint.n; ++c) expected -= now.f.J[c * w->d + k] * path(c, t, 2);
        assert_close(kII[k], expected, 1e-8);
    }
    for (int k = 0; k < 9; ++k) {
        assert_close(Hdot[k], (ahead.f.H[k] - behind.f.H[k]) / (2.0 * h), 1e-8);
        assert_close(Jdot[k], (ahead.f.J[k] - behind.f.J[k]) / (2.0 * h), 1e-8);
    }
}

static void bias_and_rates_agree_with_differences_along_a_motion(void **state)
{
    (void)state;
    for_all(check_bias);
}

/* ---- through the library --------------------------------------------------------------------- */

static int move_root(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    for (int k = 0; k < 3; ++k)
        p[k] = path(k + 6, t, 0), V[k] = path(k + 6, t, 1), A[k] = path(k + 6, t, 2);
    return 0;
}

/* A moving root, a free body on it, and the joint under test on that body, which alone has mass:
 * the unit matrix. */
typedef struct chain {
    sample base, own;
    mbsr_model *model;
    mbsr_data *data;
    int nu;
} chain;

static void make_chain(chain *w, int index, int pred_d, test_rng *rng)
{
    static const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, unit_2[4] = {1, 0, 0, 1};
    mbsr_model_def def = mbsr_default_model_def();
    make_sample(&w->base, pred_d == 3 ? 13 : 27 + 4, rng); /* all coordinates free */
    make_sample(&w->own, index, rng);
    w->own.joint.user = &w->own;
    def.root = mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, move_root, NULL);
    assert_int_equal(mbsr_model_create(&def, &w->model, NULL), 0);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = w->base.joint;
    assert_ok(mbsr_model_add_body(w->model, &body, NULL), mbsr_model_error(w->model));
    body.parent = 0;
    body.joint = w->own.joint;
    body.inertia = mbsr_inertia_matrix(w->own.d, w->own.d == 3 ? unit : unit_2);
    assert_ok(mbsr_model_add_body(w->model, &body, NULL), mbsr_model_error(w->model));
    assert_ok(mbsr_model_finish(w->model), mbsr_model_error(w->model));
    assert_int_equal(mbsr_data_create(w->model, &w->data, NULL), 0);
    w->nu = mbsr_model_nu(w->model);
    assert_int_equal(w->nu, pred_d + w->own.joint.n);
}

/* Pose of the last body by transforms alone. */
static void compose_chain(const chain *w, const double *q, double t, double *p)
{
    double root[3], middle[3];
    for (int k = 0; k < 3; ++k) root[k] = path(k + 6, t, 0);
    compose(&w->base, MBSR_SPACE_PLANAR, root, q, t, middle);
    compose(&w->own, w->base.d == 3 ? MBSR_SPACE_PLANAR : MBSR_SPACE_POINT, middle, q + w->base.d,
            t, p);
}

static void check_chain(const chain *w, double t)
{
    const double h = 1e-4;
    double q[6], u[6], udot[6], ahead[3], now[3], behind[3], V[3], tau[6], p[3];
    for (int k = 0; k < 6; ++k) q[k] = path(k, t, 0), u[k] = path(k, t, 1), udot[k] = path(k, t, 2);
    assert_int_equal(mbsr_inverse_dynamics(w->model, w->data, t, q, u, udot, NULL, tau), 0);
    assert_int_equal(mbsr_body_pose(w->model, w->data, 1, p), 0);
    assert_int_equal(mbsr_body_twist(w->model, w->data, 1, V), 0);
    compose_chain(w, q, t, now);
    double moved[6];
    for (int k = 0; k < 6; ++k) moved[k] = path(k, t + h, 0);
    compose_chain(w, moved, t + h, ahead);
    for (int k = 0; k < 6; ++k) moved[k] = path(k, t - h, 0);
    compose_chain(w, moved, t - h, behind);
    double A[3] = {0};
    for (int k = 0; k < w->own.d; ++k) {
        assert_close(p[k], now[k], 1e-14);
        assert_close(V[k], (ahead[k] - behind[k]) / (2.0 * h), 1e-6);
        A[k] = (ahead[k] - 2.0 * now[k] + behind[k]) / (h * h);
    }
    /* the unit mass: tau = (dp/dq)^T A */
    for (int c = 0; c < w->nu; ++c) {
        double expected = 0.0;
        memcpy(moved, q, sizeof q);
        moved[c] = q[c] + h;
        compose_chain(w, moved, t, ahead);
        moved[c] = q[c] - h;
        compose_chain(w, moved, t, behind);
        for (int k = 0; k < w->own.d; ++k) expected += (ahead[k] - behind[k]) / (2.0 * h) * A[k];
        assert_close(tau[c], expected, 1e-6 * (1.0 + fabs(expected)));
    }
}

static void a_chain_on_a_moving_root_moves_as_its_transforms_do(void **state)
{
    (void)state;
    test_rng rng = test_seed(12);
    for (int index = 0; index < SAMPLES; ++index) {
        for (int pred_d = 2; pred_d <= 3; ++pred_d) {
            chain w;
            make_chain(&w, index, pred_d, &rng);
            check_chain(&w, test_uniform(&rng));
            mbsr_data_destroy(w.data);
            mbsr_model_destroy(w.model);
        }
    }
}

/* ---- the constructors ------------------------------------------------------------------------ */

static void named_joints_have_the_coordinates_their_names_say(void **state)
{
    (void)state;
    const mbsr_planar_frame A = {0.1, 0.2, 0.3}, B = {0.4, 0.5, 0.6};
    const struct {
        mbsr_joint joint;
        int d, n, mask;
    } list[] = {
        {mbsr_joint_planar_weld(A, B), 3, 0, 0},
        {mbsr_joint_planar_revolute(A, B), 3, 1, MBSR_ANGLE},
        {mbsr_joint_planar_prismatic(A, B), 3, 1, MBSR_X},
        {mbsr_joint_planar_pin_slot(A, B), 3, 2, MBSR_X | MBSR_ANGLE},
        {mbsr_joint_planar_free(A, B), 3, 3, MBSR_X | MBSR_Y | MBSR_ANGLE},
        {mbsr_joint_point(A, MBSR_Y, 0, NULL, NULL), 2, 1, MBSR_Y},
    };
    for (size_t l = 0; l < sizeof list / sizeof list[0]; ++l) {
        const mbsr_joint *joint = &list[l].joint;
        sample w = {.A = A, .B = B, .d = list[l].d, .free = list[l].mask, .joint = *joint};
        const double q[3] = {0.7, -0.3, 0.9};
        double p[3], expected[3];
        assert_int_equal(joint->d, list[l].d);
        assert_int_equal(joint->np, list[l].d);
        assert_int_equal(joint->n, list[l].n);
        assert_int_equal(joint->nq, list[l].n);
        assert_int_equal(joint->space, list[l].d == 3 ? MBSR_SPACE_PLANAR : MBSR_SPACE_POINT);
        const mbsr_joint_args args = make_args(&w, MBSR_SPACE_FIXED, 0, 0.0, q, NULL);
        assert_int_equal(joint->table->position(&args, p), 0);
        compose(&w, MBSR_SPACE_FIXED, NULL, q, 0.0, expected);
        for (int k = 0; k < w.d; ++k) assert_close(p[k], expected[k], 1e-15);
    }
    /* a free point adds its coordinates to the predecessor's */
    const mbsr_joint joint = mbsr_joint_point_free();
    const double q[2] = {0.7, -0.3}, p_pred[3] = {2.0, 3.0, 1.0};
    double p[2];
    sample w = {.joint = joint};
    const mbsr_joint_args args = make_args(&w, MBSR_SPACE_POINT, 2, 0.0, q, p_pred);
    assert_int_equal(joint.table->position(&args, p), 0);
    assert_close(p[0], 2.7, 1e-15);
    assert_close(p[1], 2.7, 1e-15);
}

static int refuse(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)t, (void)s, (void)sdot, (void)sddot;
    return *(int *)user;
}

static void what_a_motion_returns_is_passed_on(void **state)
{
    (void)state;
    static const int codes[] = {17, -7};
    for (int k = 0; k < 2; ++k) {
        int code = 0;
        const mbsr_planar_frame o = {0, 0, 0};
        mbsr_model *m;
        mbsr_data *d;
        mbsr_body_def body = mbsr_default_body_def();
        body.name = "crank";
        body.joint = mbsr_joint_planar(o, o, 0, MBSR_ANGLE, refuse, &code);
        assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
        assert_int_equal(mbsr_model_finish(m), 0);
        assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
        const double none[1] = {0};
        assert_int_equal(mbsr_stage_positions(m, d, 0.25, none), 0);
        code = codes[k];
        assert_refused(mbsr_stage_positions(m, d, 0.25, none), mbsr_data_error(d), code, 0,
                       MBSR_NONE, "body 0 'crank'|joint 'planar'|position|t = 0.25");
        code = 0;
        assert_int_equal(mbsr_stage_positions(m, d, 0.25, none), 0);
        code = codes[k];
        assert_refused(mbsr_stage_velocities(m, d, none), mbsr_data_error(d), code, 0, MBSR_NONE,
                       "body 0 'crank'|bias");
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(positions_agree_with_transforms),
        cmocka_unit_test(jacobians_agree_with_differences_of_transforms),
        cmocka_unit_test(bias_and_rates_agree_with_differences_along_a_motion),
        cmocka_unit_test(a_chain_on_a_moving_root_moves_as_its_transforms_do),
        cmocka_unit_test(named_joints_have_the_coordinates_their_names_say),
        cmocka_unit_test(what_a_motion_returns_is_passed_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
