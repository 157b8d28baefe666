/* The stock joints in space against an independent composition of transforms and against
 * differences of it along a motion; their coordinates; what they refuse.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "samples.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static mbsr_joint_args make_args(const mbsr_joint *joint, mbsr_space space, int d_pred, double t,
                                 const double *q, const double *p_pred)
{
    return (mbsr_joint_args){.param = joint->param,
                             .option = joint->option,
                             .motion = joint->motion,
                             .user = joint->user,
                             .d = joint->d,
                             .np = joint->np,
                             .n = joint->n,
                             .nq = joint->nq,
                             .t = t,
                             .q = q,
                             .pred_space = space,
                             .pred_d = d_pred,
                             .p_pred = d_pred ? p_pred : NULL};
}

static const struct {
    mbsr_space space;
    int d;
} predecessors[] = {
    {MBSR_SPACE_FIXED, 0}, {MBSR_SPACE_POINT, 2}, {MBSR_SPACE_PLANAR, 3}, {MBSR_SPACE_SPATIAL, 6}};

static void poses_agree_with_transforms(void **state)
{
    (void)state;
    test_rng rng = test_seed(21);
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        for (int l = 0; l < 20; ++l) {
            const sample s = sample_make(k, &rng);
            const mbsr_space space = predecessors[l % 4].space;
            double q[7], p_pred[MBSR_POSE_SIZE], p[MBSR_POSE_SIZE], expected[MBSR_POSE_SIZE];
            test_fill(&rng, 7, q);
            for (int c = 0; c < 7; ++c) q[c] *= 3.0;
            test_fill(&rng, MBSR_POSE_SIZE, p_pred);
            const mbsr_frame frame = test_frame(&rng, 1.0);
            if (space == MBSR_SPACE_SPATIAL) memcpy(p_pred, frame.R, sizeof frame.R);
            const double t = test_uniform(&rng);
            const mbsr_joint_args args =
                make_args(&s.joint, space, predecessors[l % 4].d, t, q, p_pred);
            assert_int_equal(s.joint.table->position(&args, p), 0);
            const transform T =
                transform_product(transform_of_body(space, p_pred), sample_pose(&s, q, t));
            transform_pose(&T, expected);
            for (int c = 0; c < MBSR_POSE_SIZE; ++c) assert_close(p[c], expected[c], 3e-14);
        }
    }
}

/* ---- a chain on a moving root --------------------------------------------------------------- */

/* Coordinates of one joint at time t: waves; a quaternion turns and changes its length. */
static void joint_path(const sample *s, int body, double t, double *q)
{
    for (int k = 0; k < s->joint.nq; ++k) q[k] = sample_wave((body + 3 * k) % 7, t, 0);
    if (s->joint.nq != s->joint.n) q[0] += 1.5;
}

/* Weights of first and second differences over five points, step h. */
static const double first[5] = {1.0 / 12, -8.0 / 12, 0.0, 8.0 / 12, -1.0 / 12},
                    second[5] = {-1.0 / 12, 16.0 / 12, -30.0 / 12, 16.0 / 12, -1.0 / 12};
static const double step = 1e-3;

/* u: q', or of a quaternion twice the vector part of q' q^-1, from differences of the path. */
static void joint_rates(const sample *s, int body, double t, double *u)
{
    double q[7], qdot[7] = {0.0};
    for (int l = 0; l < 5; ++l) {
        joint_path(s, body, t + (l - 2) * step, q);
        for (int k = 0; k < s->joint.nq; ++k) qdot[k] += first[l] / step * q[k];
    }
    joint_path(s, body, t, q);
    if (s->joint.nq == s->joint.n) {
        memcpy(u, qdot, sizeof *u * (size_t)s->joint.n);
        return;
    }
    const double size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const double inverse[4] = {q[0] / size, -q[1] / size, -q[2] / size, -q[3] / size};
    double spin[4];
    quaternion_product(qdot, inverse, spin);
    for (int k = 0; k < 3; ++k) u[k] = 2.0 * spin[1 + k];
    for (int k = 3; k < s->joint.n; ++k) u[k] = qdot[k + 1];
}

/* Root and bodies of the chain at time t. */
static void chain_path(const sample *s, double t, transform *T)
{
    double p[MBSR_POSE_SIZE], V[6], A[6], q[7];
    sample_root(NULL, t, p, V, A);
    transform at = transform_of(p + MBSR_POSE_R, p + MBSR_POSE_X);
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        joint_path(s + k, k, t, q);
        at = T[k] = transform_product(at, sample_pose(s + k, q, t));
    }
}

typedef struct chain {
    sample s[SAMPLE_JOINTS];
    mbsr_model *model;
    mbsr_data *data;
} chain;

static void make_chain(chain *c, test_rng *rng)
{
    mbsr_model_def def = mbsr_default_model_def();
    def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, sample_root, NULL);
    assert_ok(mbsr_model_create(&def, &c->model, NULL), NULL);
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        c->s[k] = sample_make(k, rng);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = c->s[k].joint;
        assert_ok(mbsr_model_add_body(c->model, &body, NULL), mbsr_model_error(c->model));
    }
    assert_ok(mbsr_model_finish(c->model), mbsr_model_error(c->model));
    assert_ok(mbsr_data_create(c->model, &c->data, NULL), NULL);
}

/* q, u, u' of the whole chain. */
static void chain_state(const chain *c, double t, double *q, double *u, double *udot)
{
    double rate[6];
    for (int k = 0, iq = 0, iu = 0; k < SAMPLE_JOINTS; ++k) {
        const mbsr_joint *joint = &c->s[k].joint;
        joint_path(c->s + k, k, t, q + iq);
        joint_rates(c->s + k, k, t, u + iu);
        for (int l = 0; l < joint->n; ++l) udot[iu + l] = 0.0;
        for (int l = 0; l < 5; ++l) {
            joint_rates(c->s + k, k, t + (l - 2) * step, rate);
            for (int n = 0; n < joint->n; ++n) udot[iu + n] += first[l] / step * rate[n];
        }
        iq += joint->nq, iu += joint->n;
    }
}

static void a_chain_on_a_moving_root_moves_as_its_transforms_do(void **state)
{
    (void)state;
    test_rng rng = test_seed(22);
    chain c;
    make_chain(&c, &rng);
    double q[64], u[64], udot[64], tau[64], p[MBSR_POSE_SIZE], V[6], A[6];
    for (double t = -1.0; t < 1.5; t += 0.7) {
        transform T[5][SAMPLE_JOINTS];
        for (int l = 0; l < 5; ++l) chain_path(c.s, t + (l - 2) * step, T[l]);
        chain_state(&c, t, q, u, udot);
        assert_ok(mbsr_inverse_dynamics(c.model, c.data, t, q, u, udot, NULL, tau),
                  mbsr_data_error(c.data));
        for (int k = 0; k < SAMPLE_JOINTS; ++k) {
            transform T1 = {{{0}}}, T2 = {{{0}}};
            for (int l = 0; l < 5; ++l) {
                for (int i = 0; i < 16; ++i) {
                    T1.m[i / 4][i % 4] += first[l] / step * T[l][k].m[i / 4][i % 4];
                    T2.m[i / 4][i % 4] += second[l] / (step * step) * T[l][k].m[i / 4][i % 4];
                }
            }
            double expected[MBSR_POSE_SIZE], size;
            transform_pose(&T[2][k], expected);
            assert_ok(mbsr_body_pose(c.model, c.data, k, p), mbsr_data_error(c.data));
            for (int i = 0; i < MBSR_POSE_SIZE; ++i) assert_close(p[i], expected[i], 2e-13);
            assert_ok(mbsr_body_twist(c.model, c.data, k, V), mbsr_data_error(c.data));
            transform_twist(&T[2][k], &T1, expected);
            size = 1.0 + test_largest(6, expected);
            for (int i = 0; i < 6; ++i) assert_close(V[i], expected[i], 1e-8 * size);
            assert_ok(mbsr_body_acceleration(c.model, c.data, k, A), mbsr_data_error(c.data));
            transform_twist(&T[2][k], &T2, expected);
            size = 1.0 + test_largest(6, expected);
            for (int i = 0; i < 6; ++i) assert_close(A[i], expected[i], 1e-8 * size);
        }
    }
    mbsr_data_destroy(c.data);
    mbsr_model_destroy(c.model);
}

/* A root in space without a motion stands upright at the origin. */
static void a_root_at_rest_in_space_is_as_a_fixed_one(void **state)
{
    (void)state;
    test_rng rng = test_seed(20);
    const mbsr_frame A = test_frame(&rng, 1.0);
    mbsr_model_def def = mbsr_default_model_def();
    def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, NULL, NULL);
    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_weld(&A, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const double none[1] = {0.0};
    double p[MBSR_POSE_SIZE];
    assert_ok(mbsr_stage_positions(m, d, 0.0, none), mbsr_data_error(d));
    assert_ok(mbsr_body_pose(m, d, 0, p), mbsr_data_error(d));
    for (int k = 0; k < 9; ++k) assert_close(p[MBSR_POSE_R + k], A.R[k], 1e-15);
    for (int k = 0; k < 3; ++k) assert_close(p[MBSR_POSE_X + k], A.x[k], 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- coordinates, one by one ---------------------------------------------------------------- */

static void pose_of(const mbsr_joint *joint, const double *q, double p[MBSR_POSE_SIZE])
{
    const mbsr_joint_args args = make_args(joint, MBSR_SPACE_FIXED, 0, 0.0, q, NULL);
    assert_int_equal(joint->table->position(&args, p), 0);
}

static void assert_pose(const mbsr_joint *joint, const double *q, const double rows[12])
{
    double p[MBSR_POSE_SIZE];
    pose_of(joint, q, p);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) assert_close(p[3 * j + i], rows[4 * i + j], 1e-15);
        assert_close(p[MBSR_POSE_X + i], rows[4 * i + 3], 1e-15);
    }
}

/* A quarter turn about z is (x, y, z) -> (-y, x, z). */
static void named_joints_have_the_coordinates_their_names_say(void **state)
{
    (void)state;
    const double quarter = acos(0.0), tall[3] = {0, 0, 17.0}, wide[3] = {0.1, 0, 0};
    const double q1[1] = {quarter}, s1[1] = {0.25}, q2[2] = {quarter, 0.25},
                 q3[3] = {0.25, 0.5, quarter}, s3[3] = {0.25, 0.5, 0.75},
                 ball[4] = {sqrt(0.5), 0, 0, sqrt(0.5)},
                 all[7] = {sqrt(0.5), 0, 0, sqrt(0.5), 0.25, 0.5, 0.75};
    const struct {
        mbsr_joint joint;
        const char *name;
        int n, nq;
        const double *q;
        double rows[12];
    } list[] = {
        {mbsr_joint_weld(NULL, NULL), "weld", 0, 0, NULL, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
        {mbsr_joint_revolute(NULL, NULL, tall),
         "revolute",
         1,
         1,
         q1,
         {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}},
        {mbsr_joint_prismatic(NULL, NULL, tall),
         "prismatic",
         1,
         1,
         s1,
         {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.25}},
        {mbsr_joint_screw(NULL, NULL, tall, 0.5 / quarter),
         "screw",
         1,
         1,
         q1,
         {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.5}},
        {mbsr_joint_cylindrical(NULL, NULL, tall),
         "cylindrical",
         2,
         2,
         q2,
         {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.25}},
        {mbsr_joint_universal(NULL, NULL, tall, wide),
         "universal",
         2,
         2,
         (const double[2]){quarter, quarter},
         {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0}},
        {mbsr_joint_in_plane(NULL, NULL),
         "in-plane",
         3,
         3,
         q3,
         {0, -1, 0, 0.25, 1, 0, 0, 0.5, 0, 0, 1, 0}},
        {mbsr_joint_translational(NULL, NULL),
         "translational",
         3,
         3,
         s3,
         {1, 0, 0, 0.25, 0, 1, 0, 0.5, 0, 0, 1, 0.75}},
        {mbsr_joint_spherical(NULL, NULL),
         "spherical",
         3,
         4,
         ball,
         {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}},
        {mbsr_joint_free(NULL, NULL),
         "free",
         6,
         7,
         all,
         {0, -1, 0, 0.25, 1, 0, 0, 0.5, 0, 0, 1, 0.75}},
    };
    for (size_t k = 0; k < sizeof list / sizeof list[0]; ++k) {
        const mbsr_joint *joint = &list[k].joint;
        assert_string_equal(joint->table->name, list[k].name);
        assert_int_equal(joint->space, MBSR_SPACE_SPATIAL);
        assert_int_equal(joint->d, 6);
        assert_int_equal(joint->np, MBSR_POSE_SIZE);
        assert_int_equal(joint->n, list[k].n);
        assert_int_equal(joint->nq, list[k].nq);
        assert_pose(joint, list[k].q, list[k].rows);
    }
}

/* A, B displace where the coordinates are zero: B lies on A. */
static void frame_B_lies_on_A_where_the_coordinates_are_zero(void **state)
{
    (void)state;
    test_rng rng = test_seed(23);
    for (int k = 0; k < SAMPLE_JOINTS - 1; ++k) {
        const sample s = sample_make(k, &rng);
        const double q[7] = {s.joint.nq != s.joint.n ? 1.0 : 0.0, 0, 0, 0, 0, 0, 0};
        double p[MBSR_POSE_SIZE];
        pose_of(&s.joint, q, p);
        mbsr_frame body;
        memcpy(body.R, p + MBSR_POSE_R, sizeof body.R);
        memcpy(body.x, p + MBSR_POSE_X, sizeof body.x);
        const mbsr_frame B = mbsr_frame_product(&body, &s.B);
        for (int i = 0; i < 9; ++i) assert_close(B.R[i], s.A.R[i], 1e-14);
        for (int i = 0; i < 3; ++i) assert_close(B.x[i], s.A.x[i], 1e-14);
    }
}

/* A compound joint's coordinates: free ones in their order in q, driven ones in theirs in the
 * motion; where all are free and take the values of the drive, everything is the same. */
static void driven_axes_move_as_free_ones_with_the_same_values(void **state)
{
    (void)state;
    test_rng rng = test_seed(24);
    const sample s = sample_make(SAMPLE_JOINTS - 1, &rng);
    assert_int_equal(s.joint.n, 3);
    assert_int_equal(s.joint.nq, 3);
    mbsr_axis axes[5] = {{.kind = MBSR_AXIS_ROTATION},
                         {.kind = MBSR_AXIS_TRANSLATION},
                         {.kind = MBSR_AXIS_SCREW, .pitch = 0.7},
                         {.kind = MBSR_AXIS_SCREW, .pitch = -0.4},
                         {.kind = MBSR_AXIS_TRANSLATION}};
    for (int k = 0; k < 5; ++k) {
        const elementary *e = s.step + k;
        memcpy(axes[k].direction, axes[k].kind == MBSR_AXIS_TRANSLATION ? e->v : e->w,
               sizeof axes[k].direction);
    }
    const mbsr_joint free = mbsr_joint_compound(&s.A, &s.B, 5, axes, s.joint.motion, NULL);
    assert_int_equal(free.n, 5);
    assert_null(free.motion);

    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = k ? free : s.joint;
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double x[3][8], tau[8], a[MBSR_POSE_SIZE], b[MBSR_POSE_SIZE];
    const double t = 0.6;
    for (int l = 0; l < 3; ++l) {
        test_fill(&rng, 3, x[l]);
        const double all[5] = {x[l][0], sample_wave(SAMPLE_DRIVEN, t, l), x[l][1],
                               sample_wave(SAMPLE_DRIVEN + 1, t, l), x[l][2]};
        memcpy(x[l] + 3, all, sizeof all);
    }
    assert_ok(mbsr_inverse_dynamics(m, d, t, x[0], x[1], x[2], NULL, tau), mbsr_data_error(d));
    int (*const result[])(const mbsr_model *, mbsr_data *, int,
                          double *) = {mbsr_body_pose, mbsr_body_twist, mbsr_body_acceleration};
    for (int l = 0; l < 3; ++l) {
        assert_ok(result[l](m, d, 0, a), mbsr_data_error(d));
        assert_ok(result[l](m, d, 1, b), mbsr_data_error(d));
        const int count = l ? 6 : MBSR_POSE_SIZE;
        const double size = 1.0 + test_largest(count, b);
        for (int k = 0; k < count; ++k) assert_close(a[k], b[k], 1e-14 * size);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- quaternions ---------------------------------------------------------------------------- */

/* All outputs of a joint with quaternion at one state. */
typedef struct outputs {
    double p[MBSR_POSE_SIZE], H[36], J[36], kI[6], kII[6], Hdot[36], Jdot[36], qdot[7];
} outputs;

static void evaluate(const mbsr_joint *joint, const double *q, const double *u,
                     const double *p_pred, const double *V_pred, outputs *o)
{
    const double V[6] = {0.0};
    mbsr_joint_args args = make_args(joint, MBSR_SPACE_SPATIAL, 6, 0.0, q, p_pred);
    memset(o, 0, sizeof *o);
    assert_int_equal(joint->table->position(&args, o->p), 0);
    args.p = o->p;
    assert_int_equal(joint->table->jacobians(&args, NULL, o->H, o->J, o->kI), 0);
    args.u = u, args.V_pred = V_pred, args.V = V;
    assert_int_equal(joint->table->bias(&args, o->kII), 0);
    assert_int_equal(joint->table->rates(&args, NULL, o->Hdot, o->Jdot), 0);
    assert_int_equal(joint->table->coordinate_rates(&args, o->qdot), 0);
}

static void only_the_direction_of_a_quaternion_counts(void **state)
{
    (void)state;
    static const double lengths[] = {1e-300, 1e-160, 1e-3, -1.0, 7.0, 1e160, 1e300};
    test_rng rng = test_seed(25);
    for (int k = 8; k < 10; ++k) {
        const sample s = sample_make(k, &rng);
        double q[7], u[6], p_pred[MBSR_POSE_SIZE], V_pred[6], longer[7], again[7];
        test_fill(&rng, 7, q);
        test_fill(&rng, 6, u);
        test_fill(&rng, 6, V_pred);
        const mbsr_frame frame = test_frame(&rng, 1.0);
        memcpy(p_pred, frame.R, sizeof frame.R);
        memcpy(p_pred + MBSR_POSE_X, frame.x, sizeof frame.x);
        outputs a, b;
        evaluate(&s.joint, q, u, p_pred, V_pred, &a);
        /* q' keeps the length */
        double radial = 0.0;
        for (int c = 0; c < 4; ++c) radial += q[c] * a.qdot[c];
        assert_close(radial, 0.0, 1e-16);
        for (int c = 4; c < s.joint.nq; ++c) assert_close(a.qdot[c], u[c - 1], 0.0);
        for (size_t l = 0; l < sizeof lengths / sizeof lengths[0]; ++l) {
            memcpy(longer, q, sizeof q);
            for (int c = 0; c < 4; ++c) longer[c] *= lengths[l];
            evaluate(&s.joint, longer, u, p_pred, V_pred, &b);
            for (int c = 0; c < 4; ++c) assert_close(b.qdot[c] / lengths[l], a.qdot[c], 1e-14);
            const double *x = (const double *)&a, *y = (const double *)&b;
            for (size_t c = 0; c < offsetof(outputs, qdot) / sizeof *x; ++c)
                assert_close(x[c], y[c], 1e-14);
            /* the normal form has length 1 and the same direction */
            mbsr_joint_args args = make_args(&s.joint, MBSR_SPACE_SPATIAL, 6, 0.0, longer, p_pred);
            assert_int_equal(s.joint.table->normalise(&args, longer), 0);
            const double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
            const double sign = lengths[l] < 0.0 ? -1.0 : 1.0;
            for (int c = 0; c < 4; ++c) assert_close(longer[c], sign * q[c] / size, 1e-15);
            for (int c = 4; c < 7; ++c) assert_close(longer[c], q[c], 0.0);
            /* which stays as it is */
            memcpy(again, longer, sizeof again);
            assert_int_equal(s.joint.table->normalise(&args, again), 0);
            for (int c = 0; c < 4; ++c) assert_close(again[c], longer[c], 2e-16);
        }
    }
}

/* A spin about one of A's axes, seen from q = 1 and from elsewhere. */
static void u_is_the_angular_velocity_along_the_axes_of_A(void **state)
{
    (void)state;
    test_rng rng = test_seed(26);
    const mbsr_frame A = test_frame(&rng, 1.0), B = test_frame(&rng, 1.0);
    const mbsr_joint joint = mbsr_joint_spherical(&A, &B);
    double q[4], V[6], *J, p[MBSR_POSE_SIZE], Jm[18] = {0}, kI[6];
    J = Jm;
    test_fill(&rng, 4, q);
    mbsr_joint_args args = make_args(&joint, MBSR_SPACE_FIXED, 0, 0.0, q, NULL);
    assert_int_equal(joint.table->position(&args, p), 0);
    args.p = p;
    assert_int_equal(joint.table->jacobians(&args, NULL, NULL, J, kI), 0);
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 6; ++i) V[i] = -J[6 * k + i];
        for (int i = 0; i < 3; ++i) assert_close(V[i], A.R[3 * k + i], 1e-15);
    }
}

static void zero_quaternions_are_refused_by_name(void **state)
{
    (void)state;
    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "arm";
    body.joint = mbsr_joint_weld(NULL, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.name = "ball";
    body.parent = 0;
    body.joint = mbsr_joint_spherical(NULL, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[4] = {0, 0, 0, 0};
    const double u[3] = {0, 0, 0}, one[4] = {1, 0, 0, 0};
    double y[16];
    assert_refused(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d), MBSR_ZERO_QUATERNION, 1,
                   MBSR_NONE, "body 1 'ball'|joint 'spherical'|quaternion has length zero");
    assert_refused(mbsr_normalise(m, d, q), mbsr_data_error(d), MBSR_ZERO_QUATERNION, 1, MBSR_NONE,
                   "body 1 'ball'|normalise");
    assert_refused(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d),
                   MBSR_ZERO_QUATERNION, 1, MBSR_NONE, "body 1 'ball'");
    assert_ok(mbsr_stage_positions(m, d, 0.0, one), mbsr_data_error(d));
    const double half[4] = {0.5, -0.5, 0.5, 0.5}; /* is left alone to the last bit */
    memcpy(q, half, sizeof q);
    assert_ok(mbsr_normalise(m, d, q), mbsr_data_error(d));
    assert_memory_equal(q, half, sizeof q);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- dependent axes ------------------------------------------------------------------------- */

static void gimbal_lock_is_refused_by_name(void **state)
{
    (void)state;
    mbsr_axis axes[3] = {{.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}},
                         {.kind = MBSR_AXIS_ROTATION, .direction = {0, 1, 0}},
                         {.kind = MBSR_AXIS_ROTATION, .direction = {1, 0, 0}}};
    const mbsr_frame A = mbsr_frame_at(0.3, -0.2, 0.5), B = mbsr_frame_at(3.0, 2.0, 1.0);
    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "rotor";
    body.joint = mbsr_joint_compound(&A, &B, 3, axes, NULL, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[3] = {0.4, acos(0.0), -0.7};
    assert_refused(mbsr_stage_positions(m, d, 0.5, q), mbsr_data_error(d), MBSR_RANK_DEFICIENT_J, 0,
                   MBSR_NONE, "body 0 'rotor'|joint 'compound'|full column rank|t = 0.5");
    q[1] += 1e-5;
    assert_ok(mbsr_stage_positions(m, d, 0.5, q), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Armature of a dependent axis gives its rate an inertia of its own: stages and vector code accept
 * the state alike, inverse dynamics takes the accelerations back to the torques. One beside the
 * dependent axes does not help. */
static void armature_holds_axes_in_gimbal_lock(void **state)
{
    (void)state;
    const mbsr_axis axes[3] = {{.kind = MBSR_AXIS_TRANSLATION, .direction = {1, 0, 0}},
                               {.kind = MBSR_AXIS_ROTATION, .direction = {0, 1, 0}},
                               {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}}};
    for (int k = 0; k < 3; ++k) {
        mbsr_model *m;
        mbsr_data *d;
        double armature[3] = {0.0}, tau[3] = {1.0, -2.0, 0.5}, udot[3], back[3];
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_compound(NULL, NULL, 3, axes, NULL, NULL);
        body.inertia = mbsr_inertia_rigid(2.0, (double[3]){0.1, 0.2, 0.3},
                                          (double[6]){0.3, 0.4, 0.5, 0.0, 0.0, 0.0});
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        armature[k] = 0.3;
        assert_ok(mbsr_model_armature(m, 0, 3, armature), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        const double q[3] = {0.4, acos(0.0), -0.7}, u[3] = {0.2, 0.3, -0.1};
        const int expected = k == 1 ? MBSR_RANK_DEFICIENT_J : MBSR_OK;
        assert_int_equal(mbsr_stage_positions(m, d, 0.0, q), expected);
        assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot), expected);
        if (expected == MBSR_OK) {
            assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, udot, NULL, back), NULL);
            for (int l = 0; l < 3; ++l) assert_less(fabs(back[l] - tau[l]), 1e-13);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* ---- refusals ------------------------------------------------------------------------------- */

/* Adds and finishes one body with this joint behind another named "base"; returns the status. */
static int try_joint(const mbsr_joint *joint, const mbsr_joint *base, mbsr_error *error)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "base";
    body.joint = *base;
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.name = "link";
    body.parent = 0;
    body.joint = *joint;
    int status = mbsr_model_add_body(m, &body, NULL);
    if (!status) status = mbsr_model_finish(m);
    *error = *mbsr_model_error(m);
    mbsr_model_destroy(m);
    return status;
}

static void assert_joint_refused(mbsr_joint joint, int status, const char *words)
{
    const mbsr_joint base = mbsr_joint_weld(NULL, NULL);
    char all[200];
    mbsr_error error;
    snprintf(all, sizeof all, "body 1 'link'|joint '%s'|%s", joint.table->name, words);
    assert_refused(try_joint(&joint, &base, &error), &error, status, 1, MBSR_NONE, all);
}

static const double e_x[3] = {1, 0, 0};

static void wrong_frames_are_refused(void **state)
{
    (void)state;
    test_rng rng = test_seed(27);
    const mbsr_frame good = test_frame(&rng, 1.0);
    mbsr_frame f = good;
    f.R[4] += 1e-5;
    assert_joint_refused(mbsr_joint_weld(&f, &good), MBSR_ERR_VALUE, "frame A|orthonormal");
    assert_joint_refused(mbsr_joint_free(&good, &f), MBSR_ERR_VALUE, "frame B|orthonormal");
    f = good;
    for (int k = 0; k < 3; ++k) f.R[k] = -f.R[k];
    assert_joint_refused(mbsr_joint_revolute(&f, &good, e_x), MBSR_ERR_VALUE,
                         "frame A|left-handed");
    f = (mbsr_frame){.x = {0}};
    assert_joint_refused(mbsr_joint_translational(&good, &f), MBSR_ERR_VALUE, "frame B");
    f = good;
    f.R[5] = NAN;
    assert_joint_refused(mbsr_joint_spherical(&f, NULL), MBSR_ERR_VALUE,
                         "param[8] (frame A, R[5]) is nan");
    f = good;
    f.x[2] = INFINITY;
    assert_joint_refused(mbsr_joint_spherical(NULL, &f), MBSR_ERR_VALUE,
                         "param[14] (frame B, x[2]) is inf");
}

static void rounded_frames_are_made_exact(void **state)
{
    (void)state;
    test_rng rng = test_seed(28);
    for (int l = 0; l < 50; ++l) {
        mbsr_frame good = test_frame(&rng, 1.0), f = good;
        for (int k = 0; k < 9; ++k) f.R[k] += 1e-7 * test_uniform(&rng);
        const mbsr_joint joint = mbsr_joint_weld(&f, NULL);
        double p[MBSR_POSE_SIZE];
        pose_of(&joint, NULL, p);
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) {
                double product = 0.0;
                for (int i = 0; i < 3; ++i) product += p[3 * j + i] * p[3 * k + i];
                assert_close(product, j == k, 1e-15);
                assert_close(p[3 * j + k], good.R[3 * j + k], 3e-7);
            }
        }
    }
}

static mbsr_joint compound_of(int count, const mbsr_axis *axes)
{
    return mbsr_joint_compound(NULL, NULL, count, axes, NULL, NULL);
}

static void wrong_axes_are_refused(void **state)
{
    (void)state;
    const double zero[3] = {0, 0, 0}, bad[3] = {1, NAN, 0}, back[3] = {-3, 0, 0};
    assert_joint_refused(mbsr_joint_revolute(NULL, NULL, zero), MBSR_ERR_VALUE,
                         "direction of axis 0 has length 0");
    assert_joint_refused(mbsr_joint_prismatic(NULL, NULL, bad), MBSR_ERR_VALUE, "axis direction");
    assert_joint_refused(mbsr_joint_universal(NULL, NULL, e_x, zero), MBSR_ERR_VALUE,
                         "direction of axis 1 has length 0");
    assert_joint_refused(mbsr_joint_universal(NULL, NULL, e_x, back), MBSR_ERR_VALUE,
                         "axis 1 is parallel");
    assert_joint_refused(mbsr_joint_screw(NULL, NULL, e_x, NAN), MBSR_ERR_VALUE,
                         "param[27] (pitch) is nan");

    mbsr_axis axes[7] = {{.kind = MBSR_AXIS_ROTATION, .direction = {1, 0, 0}},
                         {.kind = MBSR_AXIS_ROTATION, .direction = {0, 1, 0}},
                         {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 1, 0}}};
    for (int k = 3; k < 7; ++k) axes[k] = axes[2];
    assert_joint_refused(compound_of(7, axes), MBSR_ERR_VALUE, "7 axes|0 .. 6");
    assert_joint_refused(compound_of(-1, axes), MBSR_ERR_VALUE, "-1 axes");
    assert_joint_refused(compound_of(4, axes), MBSR_ERR_VALUE, "axis 3 is parallel");
    axes[1].kind = (mbsr_axis_kind)0;
    assert_joint_refused(compound_of(3, axes), MBSR_ERR_VALUE, "kind of axis 1");
    axes[1].kind = (mbsr_axis_kind)4;
    assert_joint_refused(compound_of(3, axes), MBSR_ERR_VALUE, "kind of axis 1");
    axes[1].kind = MBSR_AXIS_ROTATION;
    axes[2].pitch = 0.3;
    assert_joint_refused(compound_of(3, axes), MBSR_ERR_VALUE, "axis 2|pitch is 0.3");
    axes[2].pitch = 0.0;
    axes[1].driven = 1;
    assert_joint_refused(compound_of(3, axes), MBSR_ERR_VALUE, "driven|motion is NULL");
    mbsr_joint altered = mbsr_joint_revolute(NULL, NULL, e_x);
    altered.n = altered.nq = 2;
    assert_joint_refused(altered, MBSR_ERR_VALUE, "n is 2, must be 1");
}

/* A free rotation on top of a prescribed one about the same axis is no mistake. */
static void a_driven_axis_may_be_parallel_to_the_next(void **state)
{
    (void)state;
    test_rng rng = test_seed(30);
    const mbsr_axis axes[2] = {
        {.kind = MBSR_AXIS_ROTATION, .direction = {1, 0, 0}, .driven = 1},
        {.kind = MBSR_AXIS_ROTATION, .direction = {1, 0, 0}},
    };
    const sample s = sample_make(SAMPLE_JOINTS - 1, &rng);
    const mbsr_joint base = mbsr_joint_weld(NULL, NULL),
                     joint = mbsr_joint_compound(NULL, NULL, 2, axes, s.joint.motion, s.joint.user);
    mbsr_error error;
    assert_ok(try_joint(&joint, &base, &error), &error);
}

static void directions_have_any_length_but_zero(void **state)
{
    (void)state;
    static const double lengths[] = {1e-300, 1e-200, 1e200, 1e300};
    for (int k = 0; k < 4; ++k) {
        const double axis[3] = {0.6 * lengths[k], 0.0, 0.8 * lengths[k]};
        const mbsr_joint joint = mbsr_joint_prismatic(NULL, NULL, axis),
                         base = mbsr_joint_weld(NULL, NULL);
        mbsr_error error;
        assert_ok(try_joint(&joint, &base, &error), &error);
        const double q[1] = {5.0}, rows[12] = {1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 4};
        assert_pose(&joint, q, rows);
    }
}

static int stay(const mbsr_joint_args *args, double *p)
{
    for (int k = 0; k < args->np; ++k) p[k] = 0.0;
    return 0;
}

static int no_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)args, (void)K, (void)H, (void)J, (void)kI;
    return 0;
}

static int no_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static void predecessors_in_general_space_are_refused(void **state)
{
    (void)state;
    static const mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                                           .name = "own",
                                           .position = stay,
                                           .jacobians = no_jacobians,
                                           .bias = no_bias};
    test_rng rng = test_seed(29);
    const mbsr_joint base = mbsr_joint_custom(&table, 6, 0, NULL);
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        const sample s = sample_make(k, &rng);
        mbsr_error error;
        assert_refused(try_joint(&s.joint, &base, &error), &error, MBSR_ERR_SPACE, 1, MBSR_NONE,
                       "body 1 'link'|GENERAL");
        const mbsr_joint weld = mbsr_joint_weld(NULL, NULL);
        assert_ok(try_joint(&s.joint, &weld, &error), &error);
    }
    /* and planar joints on a body in space */
    const mbsr_planar_frame o = {0, 0, 0};
    assert_joint_refused(mbsr_joint_planar_free(o, o), MBSR_ERR_SPACE, "SPATIAL");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_agree_with_transforms),
        cmocka_unit_test(a_chain_on_a_moving_root_moves_as_its_transforms_do),
        cmocka_unit_test(a_root_at_rest_in_space_is_as_a_fixed_one),
        cmocka_unit_test(named_joints_have_the_coordinates_their_names_say),
        cmocka_unit_test(frame_B_lies_on_A_where_the_coordinates_are_zero),
        cmocka_unit_test(driven_axes_move_as_free_ones_with_the_same_values),
        cmocka_unit_test(only_the_direction_of_a_quaternion_counts),
        cmocka_unit_test(u_is_the_angular_velocity_along_the_axes_of_A),
        cmocka_unit_test(zero_quaternions_are_refused_by_name),
        cmocka_unit_test(gimbal_lock_is_refused_by_name),
        cmocka_unit_test(armature_holds_axes_in_gimbal_lock),
        cmocka_unit_test(wrong_frames_are_refused),
        cmocka_unit_test(rounded_frames_are_made_exact),
        cmocka_unit_test(wrong_axes_are_refused),
        cmocka_unit_test(a_driven_axis_may_be_parallel_to_the_next),
        cmocka_unit_test(directions_have_any_length_but_zero),
        cmocka_unit_test(predecessors_in_general_space_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
