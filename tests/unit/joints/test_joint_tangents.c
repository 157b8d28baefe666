/* Derivatives of the stock joints along arbitrary directions against differences of what the
 * functions of the joint write.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "samples.h"
#include "space.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* ---- a state, a direction, and what a joint writes there ------------------------------------ */

enum { MAX_D = 6, MAX_Q = 7 };

/* Everything a joint's functions read besides t; p and V follow from the others. */
typedef struct motion {
    double q[MAX_Q], u[MAX_D], p_pred[MBSR_POSE_SIZE], V_pred[MAX_D], p[MBSR_POSE_SIZE], V[MAX_D];
} motion;

/* A way to move it: rates of q, u and V_pred, and of the predecessor's pose, in space the angular
 * velocity and the velocity of its origin. */
typedef struct direction {
    double q[MAX_Q], u[MAX_D], pose[MAX_D], V_pred[MAX_D];
} direction;

/* What a joint writes, or its changes. */
enum { P, H, J, KI, KII, HDOT, JDOT, QDOT, FIELDS };
static const char *const field_name[] = {"p", "H", "J", "kI", "kII", "Hdot", "Jdot", "qdot"};

typedef struct outputs {
    double field[FIELDS][MAX_D * MAX_D];
} outputs;

typedef struct subject {
    mbsr_joint joint;
    mbsr_space space; /* of the predecessor */
    double t;
} subject;

static const struct {
    mbsr_space space;
    int d, np;
} predecessors[] = {{MBSR_SPACE_FIXED, 0, 0},
                    {MBSR_SPACE_POINT, 2, 2},
                    {MBSR_SPACE_PLANAR, 3, 3},
                    {MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE}};

static int pred_d(const subject *s)
{
    for (int k = 0; k < 4; ++k) {
        if (predecessors[k].space == s->space) return predecessors[k].d;
    }
    return -1;
}

/* As the library calls: nothing of a predecessor at rest, no velocities where there are none. */
static mbsr_joint_args args_of(const subject *s, const motion *x, bool velocities)
{
    const mbsr_joint *joint = &s->joint;
    const bool moves = s->space != MBSR_SPACE_FIXED;
    return (mbsr_joint_args){.param = joint->param,
                             .option = joint->option,
                             .motion = joint->motion,
                             .user = joint->user,
                             .d = joint->d,
                             .np = joint->np,
                             .n = joint->n,
                             .nq = joint->nq,
                             .t = s->t,
                             .q = x->q,
                             .u = velocities ? x->u : NULL,
                             .pred_space = s->space,
                             .pred_d = pred_d(s),
                             .p_pred = moves ? x->p_pred : NULL,
                             .V_pred = moves && velocities ? x->V_pred : NULL,
                             .p = x->p,
                             .V = velocities ? x->V : NULL};
}

/* Completes x by p and V and evaluates all functions. */
static void evaluate(const subject *s, motion *x, outputs *out)
{
    const mbsr_joint_table *table = s->joint.table;
    const int d = s->joint.d, d_pred = pred_d(s);
    double(*f)[MAX_D * MAX_D] = out->field;
    memset(out, 0, sizeof *out);
    mbsr_joint_args args = args_of(s, x, false);
    args.p = NULL;
    assert_int_equal(table->position(&args, f[P]), 0);
    memcpy(x->p, f[P], sizeof x->p);
    args.p = x->p;
    assert_int_equal(table->jacobians(&args, NULL, f[H], f[J], f[KI]), 0);
    for (int k = 0; k < d; ++k) {
        x->V[k] = -f[KI][k];
        for (int c = 0; c < d_pred; ++c) x->V[k] -= f[H][d * c + k] * x->V_pred[c];
        for (int c = 0; c < s->joint.n; ++c) x->V[k] -= f[J][d * c + k] * x->u[c];
    }
    args = args_of(s, x, true);
    assert_int_equal(table->bias(&args, f[KII]), 0);
    assert_int_equal(table->rates(&args, NULL, f[HDOT], f[JDOT]), 0);
    if (table->coordinate_rates) assert_int_equal(table->coordinate_rates(&args, f[QDOT]), 0);
}

/* The state h along the direction. */
static motion moved(const subject *s, const motion *x, const direction *v, double h)
{
    motion y = *x;
    for (int k = 0; k < MAX_Q; ++k) y.q[k] += h * v->q[k];
    for (int k = 0; k < MAX_D; ++k) y.u[k] += h * v->u[k];
    for (int k = 0; k < MAX_D; ++k) y.V_pred[k] += h * v->V_pred[k];
    if (s->space != MBSR_SPACE_SPATIAL) {
        for (int k = 0; k < pred_d(s); ++k) y.p_pred[k] += h * v->pose[k];
        return y;
    }
    const double rate =
        sqrt(v->pose[0] * v->pose[0] + v->pose[1] * v->pose[1] + v->pose[2] * v->pose[2]);
    for (int k = 0; k < 3; ++k) y.p_pred[MBSR_POSE_X + k] += h * v->pose[3 + k];
    if (!(rate > 0.0)) return y;
    mbsr_frame pose = mbsr_frame_identity();
    memcpy(pose.R, x->p_pred + MBSR_POSE_R, sizeof pose.R);
    const mbsr_frame turn = mbsr_frame_rotated(NULL, v->pose, rate * h);
    const mbsr_frame turned = mbsr_frame_product(&turn, &pose);
    memcpy(y.p_pred + MBSR_POSE_R, turned.R, sizeof turned.R);
    return y;
}

/* slope of what is written, dx of what is read, at x along v: six samples, to h^6. */
static void difference(const subject *s, const motion *x, const direction *v, outputs *slope,
                       motion *dx)
{
    static const double weight[] = {-1.0, 9.0, -45.0, 45.0, -9.0, 1.0},
                        at[] = {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0};
    const double h = 2e-3;
    memset(slope, 0, sizeof *slope);
    *dx = (motion){.q = {0.0}};
    for (int l = 0; l < 6; ++l) {
        motion y = moved(s, x, v, at[l] * h);
        outputs out;
        evaluate(s, &y, &out);
        const double w = weight[l] / (60.0 * h), *const in[] = {&out.field[0][0], (double *)&y};
        double *const to[] = {&slope->field[0][0], (double *)dx};
        const size_t count[] = {sizeof out / sizeof *to[0], sizeof y / sizeof *to[0]};
        for (int i = 0; i < 2; ++i) {
            for (size_t k = 0; k < count[i]; ++k) to[i][k] += w * in[i][k];
        }
    }
}

/* ---- the comparison ------------------------------------------------------------------------- */

/* The derivatives as the joint writes them; dx: changes of what it reads. */
static void tangents(const subject *s, const motion *x, const motion *dx, outputs *out)
{
    const mbsr_joint_table *table = s->joint.table;
    const bool moves = s->space != MBSR_SPACE_FIXED;
    double(*f)[MAX_D * MAX_D] = out->field;
    memset(out, 0, sizeof *out);
    mbsr_joint_change by = {.q = dx->q, .p_pred = moves ? dx->p_pred : NULL};
    mbsr_joint_args args = args_of(s, x, false);
    assert_int_equal(table->tangent(&args, &by, f[P], NULL, f[H], f[J], f[KI]), 0);
    by.u = dx->u, by.V_pred = moves ? dx->V_pred : NULL, by.p = dx->p, by.V = dx->V;
    args = args_of(s, x, true);
    double *dqdot = table->coordinate_rates ? f[QDOT] : NULL;
    assert_int_equal(table->rate_tangent(&args, &by, f[KII], NULL, f[HDOT], f[JDOT], dqdot), 0);
}

static void compare(const subject *s, const motion *x, const direction *v)
{
    outputs expected, given;
    motion dx;
    difference(s, x, v, &expected, &dx);
    tangents(s, x, &dx, &given);
    for (int f = 0; f < FIELDS; ++f) {
        const double size = 1.0 + test_largest(MAX_D * MAX_D, expected.field[f]);
        for (int k = 0; k < MAX_D * MAX_D; ++k) {
            const double e = expected.field[f][k], g = given.field[f][k];
            if (fabs(g - e) < 1e-10 * size) continue;
            print_error("%s on %d: derivative of %s[%d] is %.12g, by differences %.12g\n",
                        s->joint.table->name, (int)s->space, field_name[f], k, g, e);
            fail();
        }
    }
}

/* A random state; a quaternion is away from zero. */
static motion random_motion(const subject *s, test_rng *rng)
{
    motion x;
    const bool quaternion = s->joint.nq != s->joint.n;
    do {
        test_fill(rng, MAX_Q, x.q);
    } while (quaternion &&
             x.q[0] * x.q[0] + x.q[1] * x.q[1] + x.q[2] * x.q[2] + x.q[3] * x.q[3] < 0.5);
    for (int k = 0; k < MAX_Q; ++k) x.q[k] *= 2.0;
    test_fill(rng, MAX_D, x.u);
    test_fill(rng, MBSR_POSE_SIZE, x.p_pred);
    test_fill(rng, MAX_D, x.V_pred);
    if (s->space == MBSR_SPACE_SPATIAL) {
        const mbsr_frame frame = test_frame(rng, 1.0);
        memcpy(x.p_pred + MBSR_POSE_R, frame.R, sizeof frame.R);
    }
    outputs unused;
    evaluate(s, &x, &unused);
    return x;
}

/* Each direction alone, and some at once, in a few states. */
static void compare_all(const mbsr_joint *joint, mbsr_space space, int states, test_rng *rng)
{
    subject s = {.joint = *joint, .space = space};
    for (int l = 0; l < states; ++l) {
        s.t = test_uniform(rng);
        const motion x = random_motion(&s, rng);
        const int sizes[] = {joint->nq, joint->n, pred_d(&s), pred_d(&s)};
        const size_t places[] = {offsetof(direction, q), offsetof(direction, u),
                                 offsetof(direction, pose), offsetof(direction, V_pred)};
        for (int part = 0; part < 4; ++part) {
            for (int k = 0; k < sizes[part]; ++k) {
                direction v = {.q = {0.0}};
                double unit = 1.0;
                memcpy((char *)&v + places[part] + sizeof unit * (size_t)k, &unit, sizeof unit);
                compare(&s, &x, &v);
            }
        }
        for (int k = 0; k < 2; ++k) {
            direction v;
            test_fill(rng, (int)(sizeof v / sizeof(double)), (double *)&v);
            compare(&s, &x, &v);
        }
    }
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    for (int k = 0; k < 2; ++k) {
        s[k] = sample_wave(k, t, 0);
        sdot[k] = sample_wave(k, t, 1);
        sddot[k] = sample_wave(k, t, 2);
    }
    return 0;
}

static void joints_in_the_plane(void **state)
{
    (void)state;
    test_rng rng = test_seed(41);
    for (int l = 0; l < 3; ++l) {
        for (int free = 0; free < 8; ++free) {
            for (int driven = 0; driven < 7; ++driven) {
                if (free & driven) continue;
                double a[6];
                test_fill(&rng, 6, a);
                const mbsr_planar_frame A = {a[0], a[1], 3.0 * a[2]}, B = {a[3], a[4], 3.0 * a[5]};
                const mbsr_joint joint = mbsr_joint_planar(A, B, free, driven, drive, NULL);
                compare_all(&joint, predecessors[l].space, 4, &rng);
                if ((free | driven) & MBSR_ANGLE) continue;
                const mbsr_joint point = mbsr_joint_point(A, free, driven, drive, NULL);
                compare_all(&point, predecessors[l].space, 4, &rng);
            }
        }
    }
}

static void joints_in_space(void **state)
{
    (void)state;
    test_rng rng = test_seed(42);
    for (int l = 0; l < 4; ++l) {
        for (int k = 0; k < 4 * SAMPLE_JOINTS; ++k) {
            const mbsr_joint joint = sample_make(k % SAMPLE_JOINTS, &rng).joint;
            compare_all(&joint, predecessors[l].space, 3, &rng);
        }
        for (int k = 0; k < 20; ++k) {
            const mbsr_joint joint =
                test_joint_in_space(&rng, k % 2 ? TEST_COMPOUND : TEST_DRIVEN, 1.0);
            compare_all(&joint, predecessors[l].space, 3, &rng);
        }
    }
}

/* Six axes of all kinds, of which two or none are driven. */
static void long_compound_joints(void **state)
{
    (void)state;
    test_rng rng = test_seed(43);
    for (int k = 0; k < 24; ++k) {
        mbsr_axis axes[6];
        const int first = test_integer(&rng, 0, 5), second = test_integer(&rng, 0, 5);
        for (int c = 0; c < 6; ++c) {
            const mbsr_axis_kind kind = (mbsr_axis_kind)test_integer(&rng, 1, 3);
            axes[c] = (mbsr_axis){.kind = kind,
                                  .pitch = kind == MBSR_AXIS_SCREW ? test_uniform(&rng) : 0.0,
                                  .driven = k % 3 && (c == first || c == second)};
            test_fill(&rng, 3, axes[c].direction);
        }
        const mbsr_frame A = test_frame(&rng, 1.0), B = test_frame(&rng, 1.0);
        const mbsr_joint joint = mbsr_joint_compound(&A, &B, 6, axes, drive, NULL);
        compare_all(&joint, predecessors[k % 4].space, 2, &rng);
    }
}

/* ---- quaternions of any length -------------------------------------------------------------- */

/* The change of q scaled as q is, the rest is the same: only the direction of q counts. */
static void the_length_of_a_quaternion_does_not_count(void **state)
{
    (void)state;
    static const double lengths[] = {1e-300, 1e-160, 1e-3, -1.0, 7.0, 1e160, 1e300};
    test_rng rng = test_seed(44);
    for (int k = 8; k < 10; ++k) {
        const subject s = {.joint = sample_make(k, &rng).joint, .space = MBSR_SPACE_SPATIAL};
        const motion x = random_motion(&s, &rng);
        direction v;
        test_fill(&rng, (int)(sizeof v / sizeof(double)), (double *)&v);
        outputs slope, a, b;
        motion dx;
        difference(&s, &x, &v, &slope, &dx);
        tangents(&s, &x, &dx, &a);
        for (size_t l = 0; l < sizeof lengths / sizeof lengths[0]; ++l) {
            motion y = x, dy = dx;
            for (int c = 0; c < 4; ++c) y.q[c] *= lengths[l], dy.q[c] *= lengths[l];
            tangents(&s, &y, &dy, &b);
            for (int c = 0; c < 4; ++c) b.field[QDOT][c] /= lengths[l];
            for (int f = 0; f < FIELDS; ++f) {
                for (int c = 0; c < MAX_D * MAX_D; ++c)
                    assert_close(b.field[f][c], a.field[f][c], 2e-14);
            }
        }
        /* along q itself nothing moves */
        dx = (motion){.q = {x.q[0], x.q[1], x.q[2], x.q[3]}};
        tangents(&s, &x, &dx, &a);
        for (int f = 0; f < QDOT; ++f) assert_close(test_largest(36, a.field[f]), 0.0, 1e-15);
    }
}

/* ---- statuses ------------------------------------------------------------------------------- */

static int refuse(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t, (void)s, (void)sdot, (void)sddot;
    return 17;
}

static void expect_status(const mbsr_joint *joint, int status)
{
    const subject s = {.joint = *joint, .space = MBSR_SPACE_PLANAR};
    const motion x = {.q = {0.0}}, dx = {.q = {1.0}, .p_pred = {1.0}, .u = {1.0}};
    const mbsr_joint_change by = {dx.q, dx.u, dx.p_pred, dx.V_pred, dx.p, dx.V};
    outputs out = {{{0.0}}};
    double(*f)[MAX_D * MAX_D] = out.field;
    const mbsr_joint_args args = args_of(&s, &x, true);
    assert_int_equal(joint->table->tangent(&args, &by, f[P], NULL, f[H], f[J], f[KI]), status);
    assert_int_equal(
        joint->table->rate_tangent(&args, &by, f[KII], NULL, f[HDOT], f[JDOT], f[QDOT]), status);
}

static void statuses_are_handed_on(void **state)
{
    (void)state;
    const mbsr_planar_frame none = {0.0, 0.0, 0.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_joint planar = mbsr_joint_planar(none, none, 0, MBSR_X, refuse, NULL);
    const mbsr_joint compound = mbsr_joint_compound(NULL, NULL, 1, &axis, refuse, NULL);
    const mbsr_joint ball = mbsr_joint_spherical(NULL, NULL);
    expect_status(&planar, 17);
    expect_status(&compound, 17);
    expect_status(&ball, MBSR_ZERO_QUATERNION);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_in_the_plane),
        cmocka_unit_test(joints_in_space),
        cmocka_unit_test(long_compound_joints),
        cmocka_unit_test(the_length_of_a_quaternion_does_not_count),
        cmocka_unit_test(statuses_are_handed_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
