/* The same mechanism in space told in two ways must move alike: a joint as a chain of simpler ones
 * with massless links between, as a compound joint, with other coordinates; a body cut in two;
 * other frames; in the plane and in space; a driven axis and a root that moves.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "space.h"

#include "assembly/data.h"

#include <string.h>

enum { TRIALS = 25, MOST = 32, MOST_PARTS = 6 };

static const double now = 0.3;
static const double e_x[3] = {1.0, 0.0, 0.0}, e_y[3] = {0.0, 1.0, 0.0}, e_z[3] = {0.0, 0.0, 1.0};

/* ---- a model and its motion ------------------------------------------------------------------ */

typedef struct side {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    double q[MOST], u[MOST], udot[MOST];
    double loss; /* how much rounding grows where axes are nearly dependent; 1: not at all */
} side;

static void begin(side *s, const mbsr_root *root)
{
    mbsr_model_def def = mbsr_default_model_def();
    if (root) def.root = *root;
    *s = (side){.loss = 1.0};
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
}

static int add(side *s, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    int id = MBSR_NONE;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(s->model, &body, &id), mbsr_model_error(s->model));
    return id;
}

static void finish(side *s, const double gravity[3])
{
    const mbsr_force_def weight = mbsr_force_gravity(gravity[0], gravity[1], gravity[2]);
    assert_ok(mbsr_model_add_force(s->model, &weight, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    assert_in_range(s->nq, 0, MOST);
}

static void end(side *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* Poses and twists of the state. */
static void move(side *s, double t)
{
    assert_ok(mbsr_stage_positions(s->model, s->data, t, s->q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->u), mbsr_data_error(s->data));
}

/* Accelerations under the forces. */
static void accelerate(side *s, double t)
{
    mbsri_data_poison(s->data);
    assert_ok(mbsr_forward_dynamics(s->model, s->data, t, s->q, s->u, NULL, s->udot),
              mbsr_data_error(s->data));
    assert_ok(mbsr_stage_accelerations(s->model, s->data, s->udot), mbsr_data_error(s->data));
}

/* Classical Runge-Kutta steps of (q, u) from t = now on. */
static void integrate(side *s, double duration, int steps)
{
    static const double node[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    const double h = duration / steps;
    for (int step = 0; step < steps; ++step) {
        double q0[MOST], u0[MOST], dq[MOST] = {0.0}, du[MOST] = {0.0}, qdot[MOST] = {0.0},
                                   slope[MOST] = {0.0};
        memcpy(q0, s->q, sizeof q0);
        memcpy(u0, s->u, sizeof u0);
        for (int stage = 0; stage < 4; ++stage) {
            for (int k = 0; k < s->nq; ++k) s->q[k] = q0[k] + node[stage] * h * qdot[k];
            for (int k = 0; k < s->nu; ++k) s->u[k] = u0[k] + node[stage] * h * slope[k];
            assert_ok(mbsr_forward_dynamics(s->model, s->data, now + h * (step + node[stage]), s->q,
                                            s->u, NULL, slope),
                      mbsr_data_error(s->data));
            assert_ok(mbsr_coordinate_rates(s->model, s->data, qdot), mbsr_data_error(s->data));
            for (int k = 0; k < s->nq; ++k) dq[k] += weight[stage] * h / 6.0 * qdot[k];
            for (int k = 0; k < s->nu; ++k) du[k] += weight[stage] * h / 6.0 * slope[k];
        }
        for (int k = 0; k < s->nq; ++k) s->q[k] = q0[k] + dq[k];
        for (int k = 0; k < s->nu; ++k) s->u[k] = u0[k] + du[k];
    }
}

/* ---- motion of a frame ----------------------------------------------------------------------- */

typedef struct flight {
    mbsr_frame frame;
    double V[6], A[6]; /* of its origin */
} flight;

static void add_cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; ++k)
        c[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* A frame that stands in a body (NULL: the body's own); accelerations after accelerate() only. */
static flight flight_of(const side *s, int body, const mbsr_frame *standing, int accelerated)
{
    const mbsr_frame own = mbsr_frame_identity();
    flight f = {.V = {0.0}};
    double pose[MBSR_POSE_SIZE];
    assert_ok(mbsr_body_pose(s->model, s->data, body, pose), mbsr_data_error(s->data));
    assert_ok(mbsr_body_twist(s->model, s->data, body, f.V), mbsr_data_error(s->data));
    if (accelerated) {
        assert_ok(mbsr_body_acceleration(s->model, s->data, body, f.A), mbsr_data_error(s->data));
    }
    memcpy(f.frame.R, pose + MBSR_POSE_R, sizeof f.frame.R);
    memcpy(f.frame.x, pose + MBSR_POSE_X, sizeof f.frame.x);
    const mbsr_frame moved = mbsr_frame_product(&f.frame, standing ? standing : &own);
    double arm[3], sweep[3] = {0.0};
    for (int k = 0; k < 3; ++k) arm[k] = moved.x[k] - f.frame.x[k];
    add_cross(f.V, arm, sweep);
    add_cross(f.A, arm, f.A + 3);
    if (accelerated) add_cross(f.V, sweep, f.A + 3);
    for (int k = 0; k < 3; ++k) f.V[3 + k] += sweep[k];
    f.frame = moved;
    return f;
}

static void assert_same_flight(const flight *a, const flight *b, double pose, double rates)
{
    for (int k = 0; k < 9; ++k) assert_close(a->frame.R[k], b->frame.R[k], pose);
    for (int k = 0; k < 3; ++k) assert_close(a->frame.x[k], b->frame.x[k], pose);
    const double speed = 1.0 + test_largest(6, b->V), size = 1.0 + test_largest(6, b->A);
    for (int k = 0; k < 6; ++k) {
        assert_close(a->V[k], b->V[k], rates * speed);
        assert_close(a->A[k], b->A[k], rates * size);
    }
}

/* Body ia of a moves as the frame standing in body ib of b. */
static void assert_same_motion(const side *a, int ia, const side *b, int ib,
                               const mbsr_frame *standing)
{
    const flight fa = flight_of(a, ia, NULL, 1), fb = flight_of(b, ib, standing, 1);
    assert_same_flight(&fa, &fb, 1e-13, 1e-11 * fmax(a->loss, b->loss));
}

/* Quaternion, angular velocity, place and velocity of frame B on `body` in frame A on `pred`, all
 * along A's axes: the coordinates of free and spherical joints. */
static void relative(const side *s, int pred, const mbsr_frame *A, int body, const mbsr_frame *B,
                     double q[7], double u[6])
{
    const flight a = flight_of(s, pred, A, 0), b = flight_of(s, body, B, 0);
    const mbsr_frame back = mbsr_frame_inverse(&a.frame),
                     between = mbsr_frame_product(&back, &b.frame);
    double arm[3], swept[3] = {0.0}, rate[6];
    for (int k = 0; k < 3; ++k) arm[k] = b.frame.x[k] - a.frame.x[k];
    add_cross(a.V, arm, swept);
    for (int k = 0; k < 3; ++k) {
        rate[k] = b.V[k] - a.V[k];
        rate[3 + k] = b.V[3 + k] - a.V[3 + k] - swept[k];
    }
    mbsr_rotation_quaternion(between.R, q);
    memcpy(q + 4, between.x, sizeof between.x);
    for (int k = 0; k < 3; ++k) {
        u[k] = u[3 + k] = 0.0;
        for (int l = 0; l < 3; ++l) {
            u[k] += a.frame.R[3 * k + l] * rate[l];
            u[3 + k] += a.frame.R[3 * k + l] * rate[3 + l];
        }
    }
}

/* ---- mechanisms: base, the joint in question, arm, tip --------------------------------------- */

static mbsr_inertia block(test_rng *rng)
{
    const mbsr_frame at = test_frame(rng, 0.3);
    double edges[3];
    for (int k = 0; k < 3; ++k) edges[k] = 0.4 + 0.3 * test_uniform(rng);
    return mbsr_inertia_in_frame(&at, mbsr_inertia_box(20.0, edges));
}

static const double g[3] = {3.0, -5.0, -7.0};

/* What stands around the joint: the same for the same seed. Bodies 0, parts (the last: 1 + parts),
 * and a tip. */
static void mechanism(side *s, int seed, int parts, const mbsr_joint *joint)
{
    test_rng rng = test_seed((uint64_t)seed);
    begin(s, NULL);
    int id = add(s, MBSR_GROUND, test_joint_in_space(&rng, TEST_UNIVERSAL, 1.0), block(&rng));
    const mbsr_inertia arm = block(&rng);
    for (int k = 0; k < parts; ++k)
        id = add(s, id, joint[k], k < parts - 1 ? mbsr_inertia_zero() : arm);
    add(s, id, test_joint_in_space(&rng, TEST_CYLINDRICAL, 1.0), block(&rng));
    finish(s, g);
}

/* A state: base and tip at random, the joint between them (nq, nu numbers) as given. */
static void outer_state(side *s, int seed, const double *q, const double *u, int nq, int nu)
{
    test_rng rng = test_seed((uint64_t)seed + 50);
    double outer[8];
    assert_int_equal(s->nq, 4 + nq);
    assert_int_equal(s->nu, 4 + nu);
    test_fill(&rng, 8, outer);
    memcpy(s->q, outer, 2 * sizeof(double));
    memcpy(s->u, outer + 2, 2 * sizeof(double));
    memcpy(s->q + 2, q, sizeof(double) * (size_t)nq);
    memcpy(s->u + 2, u, sizeof(double) * (size_t)nu);
    memcpy(s->q + 2 + nq, outer + 4, 2 * sizeof(double));
    memcpy(s->u + 2 + nu, outer + 6, 2 * sizeof(double));
}

/* The same accelerations, and after a while the same place, where the joint is so many parts. */
static void assert_alike(side *a, int parts_a, side *b, int parts_b, int later)
{
    accelerate(a, now);
    accelerate(b, now);
    assert_same_motion(a, 0, b, 0, NULL);
    assert_same_motion(a, parts_a, b, parts_b, NULL);
    assert_same_motion(a, parts_a + 1, b, parts_b + 1, NULL);
    if (!later) return;
    integrate(a, 0.1, 400);
    integrate(b, 0.1, 400);
    move(a, now + 0.1);
    move(b, now + 0.1);
    const flight fa = flight_of(a, parts_a + 1, NULL, 0), fb = flight_of(b, parts_b + 1, NULL, 0);
    assert_same_flight(&fa, &fb, 1e-9, 1e-8);
}

/* A joint of several axes, and its axes as joints of their own. */
static int as_chain(const mbsr_frame *A, const mbsr_frame *B, int count, const mbsr_axis *axes,
                    mbsr_joint *chain)
{
    for (int k = 0; k < count; ++k) {
        const mbsr_frame *first = k == 0 ? A : NULL, *last = k == count - 1 ? B : NULL;
        const double *a = axes[k].direction;
        chain[k] = axes[k].kind == MBSR_AXIS_ROTATION ? mbsr_joint_revolute(first, last, a)
                   : axes[k].kind == MBSR_AXIS_SCREW
                       ? mbsr_joint_screw(first, last, a, axes[k].pitch)
                       : mbsr_joint_prismatic(first, last, a);
    }
    return count;
}

static mbsr_axis turning(const double a[3])
{
    return (mbsr_axis){.kind = MBSR_AXIS_ROTATION, .direction = {a[0], a[1], a[2]}};
}

static mbsr_axis sliding(const double a[3])
{
    return (mbsr_axis){.kind = MBSR_AXIS_TRANSLATION, .direction = {a[0], a[1], a[2]}};
}

/* The joint of that number, and its axes. */
enum { UNIVERSAL, CYLINDRICAL, IN_PLANE, TRANSLATIONAL, MANY_AXES, SEVERAL };
static mbsr_joint several_axes(int which, const mbsr_frame *A, const mbsr_frame *B, int *count,
                               mbsr_axis axes[MOST_PARTS])
{
    static const double a[3] = {0.6, 0.0, -0.8}, b[3] = {0.3, 2.0, 0.1};
    switch (which) {
    case UNIVERSAL:
        *count = 2, axes[0] = turning(a), axes[1] = turning(b);
        return mbsr_joint_universal(A, B, a, b);
    case CYLINDRICAL:
        *count = 2, axes[0] = turning(a), axes[1] = sliding(a);
        return mbsr_joint_cylindrical(A, B, a);
    case IN_PLANE:
        *count = 3, axes[0] = sliding(e_x), axes[1] = sliding(e_y), axes[2] = turning(e_z);
        return mbsr_joint_in_plane(A, B);
    case TRANSLATIONAL:
        *count = 3, axes[0] = sliding(e_x), axes[1] = sliding(e_y), axes[2] = sliding(e_z);
        return mbsr_joint_translational(A, B);
    default:
        *count = 5, axes[0] = turning(a), axes[1] = sliding(b), axes[2] = turning(b);
        axes[3] = (mbsr_axis){.kind = MBSR_AXIS_SCREW, .direction = {1.0, 1.0, 0.2}, .pitch = 0.3};
        axes[4] = sliding(a);
        return mbsr_joint_compound(A, B, 5, axes, NULL, NULL);
    }
}

static void a_joint_of_several_axes_is_a_chain_with_massless_links(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TRIALS; ++seed) {
        for (int which = 0; which < SEVERAL; ++which) {
            test_rng rng = test_seed((uint64_t)seed + 10);
            const mbsr_frame A = test_frame(&rng, 0.5), B = test_frame(&rng, 0.5);
            mbsr_axis axes[MOST_PARTS];
            mbsr_joint chain[MOST_PARTS];
            int count;
            const mbsr_joint joint = several_axes(which, &A, &B, &count, axes);
            side one, many;
            mechanism(&one, seed, 1, &joint);
            mechanism(&many, seed, as_chain(&A, &B, count, axes, chain), chain);
            double q[MOST_PARTS], u[MOST_PARTS];
            test_fill(&rng, count, q);
            test_fill(&rng, count, u);
            outer_state(&one, seed, q, u, count, count);
            outer_state(&many, seed, q, u, count, count);
            assert_alike(&one, 1, &many, count, seed == 1);
            for (int k = 0; k < one.nu; ++k) assert_close(one.udot[k], many.udot[k], 1e-8);
            end(&one);
            end(&many);
        }
    }
}

/* 1 / det^2 of the last three axes of body 1's joint, all rotations: u is found by dividing by det,
 * and u' once more from its squares. */
static double loss_at(side *s, int count)
{
    double J[6 * MOST];
    assert_ok(mbsr_body_jacobian(s->model, s->data, 1, J), mbsr_data_error(s->data));
    int first;
    assert_ok(mbsr_body_coordinates(s->model, 1, NULL, NULL, &first, NULL), NULL);
    const double *a = J + 6 * (first + count - 3), *b = a + 6, *c = b + 6;
    const double det = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    return 1.0 / (det * det);
}

/* Spherical: three rotations. Free: three translations before them. */
static void check_quaternion_joint(int seed, int count, const mbsr_axis *axes, int free)
{
    test_rng rng = test_seed((uint64_t)seed + 20);
    const mbsr_frame A = test_frame(&rng, 0.5), B = test_frame(&rng, 0.5);
    const mbsr_joint quaternion = free ? mbsr_joint_free(&A, &B) : mbsr_joint_spherical(&A, &B),
                     compound = mbsr_joint_compound(&A, &B, count, axes, NULL, NULL);
    mbsr_joint chain[MOST_PARTS];
    side s, c, m;
    mechanism(&s, seed, 1, &quaternion);
    mechanism(&c, seed, 1, &compound);
    mechanism(&m, seed, as_chain(&A, &B, count, axes, chain), chain);
    double q[MOST_PARTS + 1], u[MOST_PARTS];
    test_fill(&rng, count, q);
    test_fill(&rng, count, u);
    outer_state(&c, seed, q, u, count, count);
    outer_state(&m, seed, q, u, count, count);
    move(&c, now);
    relative(&c, 0, &A, 1, &B, q, u);
    s.loss = loss_at(&c, count);
    outer_state(&s, seed, q, u, count + 1, count);
    assert_alike(&s, 1, &c, 1, seed == 1);
    outer_state(&s, seed, q, u, count + 1, count);
    assert_alike(&s, 1, &m, count, 0);
    end(&s);
    end(&c);
    end(&m);
}

static void a_spherical_joint_is_three_revolutes(void **unused)
{
    (void)unused;
    static const double c[3] = {0.5, 0.2, 1.0};
    const mbsr_axis xyz[] = {turning(e_x), turning(e_y), turning(e_z)},
                    oblique[] = {turning(e_z), turning(e_x), turning(c)};
    for (int seed = 1; seed <= TRIALS; ++seed) {
        check_quaternion_joint(seed, 3, xyz, 0);
        check_quaternion_joint(seed, 3, oblique, 0);
    }
}

static void a_free_joint_is_three_translations_and_three_rotations(void **unused)
{
    (void)unused;
    const mbsr_axis axes[] = {sliding(e_x), sliding(e_y), sliding(e_z),
                              turning(e_z), turning(e_y), turning(e_x)};
    for (int seed = 1; seed <= TRIALS; ++seed) check_quaternion_joint(seed, 6, axes, 1);
}

/* ---- bodies cut in two, other frames --------------------------------------------------------- */

/* base, arm, tip; the arm as one body, or its second half welded to the first at `cut`, with the
 * tip on the second half. Halves: any inertia, in the axes of their own half. */
static void cut_arm(side *s, int seed, const mbsr_frame *cut, mbsr_inertia first,
                    mbsr_inertia second, int apart)
{
    test_rng rng = test_seed((uint64_t)seed);
    const mbsr_frame tip = test_frame(&rng, 0.5), A = test_frame(&rng, 0.2),
                     back = mbsr_frame_inverse(cut), B = mbsr_frame_product(&back, &A),
                     on_whole = mbsr_frame_product(cut, &tip);
    begin(s, NULL);
    const int base = add(s, MBSR_GROUND, test_joint_in_space(&rng, TEST_FREE, 1.0), block(&rng));
    int arm = add(s, base, test_joint_in_space(&rng, TEST_SPHERICAL, 1.0),
                  apart ? first : mbsr_inertia_sum(first, mbsr_inertia_in_frame(cut, second)));
    if (apart) arm = add(s, arm, mbsr_joint_weld(&A, &B), second);
    add(s, arm, mbsr_joint_universal(apart ? &tip : &on_whole, NULL, e_x, e_y), block(&rng));
    finish(s, g);
    test_rng state = test_seed((uint64_t)seed + 50);
    test_fill(&state, s->nq, s->q);
    test_fill(&state, s->nu, s->u);
}

static void a_body_cut_in_two_moves_as_before(void **unused)
{
    (void)unused;
    const double end_point[3] = {0.3, -0.2, 0.5}, zero[3] = {0.0, 0.0, 0.0};
    for (int seed = 1; seed <= TRIALS; ++seed) {
        test_rng rng = test_seed((uint64_t)seed + 30);
        const mbsr_frame cut = test_frame(&rng, 0.6);
        const mbsr_inertia halves[][2] = {
            {block(&rng), block(&rng)},
            {mbsr_inertia_zero(), block(&rng)},
            {mbsr_inertia_point_mass(2.0, end_point), mbsr_inertia_rod(1.0, zero, end_point)},
            {mbsr_inertia_particle(2.0), mbsr_inertia_zero()}};
        for (int k = 0; k < 4; ++k) {
            side whole, apart;
            cut_arm(&whole, seed, &cut, halves[k][0], halves[k][1], 0);
            cut_arm(&apart, seed, &cut, halves[k][0], halves[k][1], 1);
            accelerate(&whole, now);
            accelerate(&apart, now);
            for (int body = 0; body < 2; ++body)
                assert_same_motion(&apart, body, &whole, body, NULL);
            assert_same_motion(&apart, 2, &whole, 1, &cut);
            assert_same_motion(&apart, 3, &whole, 2, NULL);
            end(&whole);
            end(&apart);
        }
    }
}

/* A chain of all kinds of joints in which every body may have another frame of reference, `at[k]`
 * in its old one: joints and inertias are told in it. */
static void chain_with_frames(side *s, int seed, const mbsr_frame *at)
{
    test_rng rng = test_seed((uint64_t)seed);
    begin(s, NULL);
    mbsr_frame pred = mbsr_frame_identity();
    int id = MBSR_GROUND;
    for (int kind = 0; kind < TEST_DRIVEN + 1; ++kind) {
        const mbsr_frame back = mbsr_frame_inverse(at + kind);
        mbsr_joint joint = test_joint_in_space(&rng, kind, 1.0);
        /* A and B stand first among the parameters, origin before axes */
        mbsr_frame A, B;
        memcpy(A.x, joint.param, sizeof A.x);
        memcpy(A.R, joint.param + 3, sizeof A.R);
        memcpy(B.x, joint.param + 12, sizeof B.x);
        memcpy(B.R, joint.param + 15, sizeof B.R);
        A = mbsr_frame_product(&pred, &A);
        B = mbsr_frame_product(&back, &B);
        memcpy(joint.param, A.x, sizeof A.x);
        memcpy(joint.param + 3, A.R, sizeof A.R);
        memcpy(joint.param + 12, B.x, sizeof B.x);
        memcpy(joint.param + 15, B.R, sizeof B.R);
        id = add(s, id, joint, mbsr_inertia_in_frame(&back, block(&rng)));
        pred = back;
    }
    finish(s, g);
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

static void frames_of_reference_do_not_matter(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TRIALS; ++seed) {
        test_rng rng = test_seed((uint64_t)seed + 40);
        mbsr_frame same[TEST_KINDS], other[TEST_KINDS];
        for (int k = 0; k < TEST_KINDS; ++k) {
            same[k] = mbsr_frame_identity();
            other[k] = test_frame(&rng, 1.0);
        }
        side a, b;
        chain_with_frames(&a, seed, same);
        chain_with_frames(&b, seed, other);
        accelerate(&a, now);
        accelerate(&b, now);
        const double size = 1.0 + test_largest(a.nu, a.udot);
        for (int k = 0; k < a.nu; ++k) assert_close(b.udot[k], a.udot[k], 1e-10 * size);
        for (int k = 0; k < TEST_KINDS; ++k) {
            const flight fb = flight_of(&b, k, NULL, 1), fa = flight_of(&a, k, other + k, 1);
            assert_same_flight(&fb, &fa, 1e-12, 1e-10);
        }
        end(&a);
        end(&b);
    }
}

/* ---- the plane in space ---------------------------------------------------------------------- */

static mbsr_frame lifted(mbsr_planar_frame f)
{
    return mbsr_frame_rotated((double[3]){f.x, f.y, 0.0}, e_z, f.angle);
}

/* A tree of planar bodies, as such (`space` 0), or as bodies in space. */
static void planar_tree(side *s, int seed, int space)
{
    enum { BODIES = 8 };
    test_rng rng = test_seed((uint64_t)seed);
    begin(s, NULL);
    for (int k = 0; k < BODIES; ++k) {
        const int parent = test_integer(&rng, -1, k - 1), kind = k % 5;
        const mbsr_planar_frame a = {test_uniform(&rng), test_uniform(&rng), test_uniform(&rng)},
                                b = {test_uniform(&rng), test_uniform(&rng), test_uniform(&rng)};
        const mbsr_frame A = lifted(a), B = lifted(b);
        const mbsr_axis pin_slot[] = {sliding(e_x), turning(e_z)};
        const mbsr_joint planar[] = {mbsr_joint_planar_revolute(a, b),
                                     mbsr_joint_planar_prismatic(a, b),
                                     mbsr_joint_planar_pin_slot(a, b), mbsr_joint_planar_free(a, b),
                                     mbsr_joint_planar_weld(a, b)};
        const mbsr_joint spatial[] = {mbsr_joint_revolute(&A, &B, e_z),
                                      mbsr_joint_prismatic(&A, &B, e_x),
                                      mbsr_joint_compound(&A, &B, 2, pin_slot, NULL, NULL),
                                      mbsr_joint_in_plane(&A, &B), mbsr_joint_weld(&A, &B)};
        const double mass = 1.5 + test_uniform(&rng), moment = 0.3 + 0.2 * test_uniform(&rng),
                     com[3] = {test_uniform(&rng), test_uniform(&rng), 0.0},
                     tensor[6] = {0.6 * moment, 0.7 * moment, moment, 0.1 * moment, 0.0, 0.0};
        add(s, parent, space ? spatial[kind] : planar[kind],
            space ? mbsr_inertia_rigid(mass, com, tensor) : mbsr_inertia_planar(mass, com, moment));
    }
    finish(s, (double[3]){2.0, -9.0, space ? -3.0 : 0.0});
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

static void a_planar_tree_is_the_same_in_space(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TRIALS; ++seed) {
        side plane, space;
        planar_tree(&plane, seed, 0);
        planar_tree(&space, seed, 1);
        assert_int_equal(plane.nu, space.nu);
        accelerate(&plane, now);
        accelerate(&space, now);
        const double size = 1.0 + test_largest(plane.nu, plane.udot);
        for (int k = 0; k < plane.nu; ++k) assert_close(space.udot[k], plane.udot[k], 1e-10 * size);
        for (int id = 0; id < mbsr_model_bodies(plane.model); ++id) {
            const flight f = flight_of(&space, id, NULL, 1);
            double p[3], V[3], A[3];
            assert_ok(mbsr_body_pose(plane.model, plane.data, id, p), NULL);
            assert_ok(mbsr_body_twist(plane.model, plane.data, id, V), NULL);
            assert_ok(mbsr_body_acceleration(plane.model, plane.data, id, A), NULL);
            const flight expected = {.frame = lifted((mbsr_planar_frame){p[0], p[1], p[2]}),
                                     .V = {0.0, 0.0, V[2], V[0], V[1], 0.0},
                                     .A = {0.0, 0.0, A[2], A[0], A[1], 0.0}};
            assert_same_flight(&f, &expected, 1e-12, 1e-10);
        }
        end(&plane);
        end(&space);
    }
}

/* Bodies in space on a planar body and on a point: the same with all in space. */
static void carriers(side *s, int seed, int space)
{
    test_rng rng = test_seed((uint64_t)seed);
    const mbsr_planar_frame a = {0.3, -0.2, 0.5}, b = {0.1, 0.4, -0.3}, o = {0.0, 0.0, 0.0};
    const mbsr_frame A = lifted(a), B = lifted(b);
    const double com[3] = {0.2, 0.1, 0.0}, tensor[6] = {0.2, 0.2, 0.3, 0.0, 0.0, 0.0};
    const mbsr_axis slide[] = {sliding(e_x), sliding(e_y)};
    begin(s, NULL);
    add(s, MBSR_GROUND,
        space ? mbsr_joint_in_plane(&A, &B)
              : mbsr_joint_planar(a, b, MBSR_X | MBSR_Y | MBSR_ANGLE, 0, NULL, NULL),
        space ? mbsr_inertia_rigid(2.0, com, tensor) : mbsr_inertia_planar(2.0, com, 0.3));
    add(s, MBSR_GROUND,
        space ? mbsr_joint_compound(NULL, NULL, 2, slide, NULL, NULL)
              : mbsr_joint_point(o, MBSR_X | MBSR_Y, 0, NULL, NULL),
        mbsr_inertia_particle(1.5));
    for (int k = 0; k < 2; ++k)
        add(s, k, test_joint_in_space(&rng, TEST_SPHERICAL, 1.0), block(&rng));
    finish(s, g);
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

static void bodies_in_space_may_stand_on_bodies_in_the_plane(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TRIALS; ++seed) {
        side mixed, space;
        carriers(&mixed, seed, 0);
        carriers(&space, seed, 1);
        accelerate(&mixed, now);
        accelerate(&space, now);
        for (int k = 0; k < space.nu; ++k)
            assert_close(mixed.udot[k], space.udot[k],
                         1e-12 * (1.0 + test_largest(space.nu, space.udot)));
        for (int id = 2; id < 4; ++id) assert_same_motion(&mixed, id, &space, id, NULL);
        end(&mixed);
        end(&space);
    }
}

/* ---- driven axes ----------------------------------------------------------------------------- */

static void speed(double t, double s[3], double w[3])
{
    s[0] = 0.4 * sin(3.0 * t), s[1] = 1.2 * cos(3.0 * t), s[2] = -3.6 * sin(3.0 * t);
    w[0] = 0.5 * t * t, w[1] = t, w[2] = 1.0;
}

static const double rail[3] = {0.6, 0.0, 0.8};

/* Along the rail, then about the z axis. */
static int drives(void *unused, double t, double *s, double *sdot, double *sddot)
{
    (void)unused;
    double along[3], about[3];
    speed(t, along, about);
    s[0] = along[0], sdot[0] = along[1], sddot[0] = along[2];
    s[1] = about[0], sdot[1] = about[1], sddot[1] = about[2];
    return MBSR_OK;
}

static int root_in_space(void *unused, double t, double *p, double *V, double *A)
{
    (void)unused;
    double along[3], about[3];
    speed(t, along, about);
    const mbsr_frame frame = mbsr_frame_rotated(NULL, e_z, about[0]);
    memcpy(p + MBSR_POSE_R, frame.R, sizeof frame.R);
    V[2] = about[1], A[2] = about[2];
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = rail[k] * along[0];
        V[3 + k] = rail[k] * along[1];
        A[3 + k] = rail[k] * along[2];
    }
    return MBSR_OK;
}

static void a_driven_axis_is_a_moving_root(void **unused)
{
    (void)unused;
    const mbsr_axis driven[] = {
        {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.6, 0.0, 0.8}, .driven = 1},
        {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1}};
    const mbsr_root moving =
        mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, root_in_space, NULL);
    for (int seed = 1; seed <= TRIALS; ++seed) {
        side root, axis;
        begin(&root, &moving);
        begin(&axis, NULL);
        add(&axis, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 2, driven, drives, NULL),
            mbsr_inertia_zero());
        side *both[] = {&root, &axis};
        for (int k = 0; k < 2; ++k) {
            test_rng rng = test_seed((uint64_t)seed);
            int id = k ? 0 : MBSR_GROUND;
            for (int body = 0; body < 3; ++body) {
                id =
                    add(both[k], id,
                        test_joint_in_space(&rng, body == 1 ? TEST_SPHERICAL : TEST_UNIVERSAL, 1.0),
                        block(&rng));
            }
            finish(both[k], g);
            test_fill(&rng, both[k]->nq, both[k]->q);
            test_fill(&rng, both[k]->nu, both[k]->u);
            accelerate(both[k], now);
        }
        for (int body = 0; body < 3; ++body) assert_same_motion(&axis, body + 1, &root, body, NULL);
        for (int k = 0; k < root.nu; ++k)
            assert_close(axis.udot[k], root.udot[k], 1e-11 * (1.0 + fabs(root.udot[k])));
        end(&root);
        end(&axis);
    }
}

/* A root in space without a motion stands at the world's origin. */
static void a_root_in_space_at_rest_is_the_ground(void **unused)
{
    (void)unused;
    const mbsr_root still = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, NULL, NULL);
    side root, ground, *both[] = {&root, &ground};
    begin(&root, &still);
    begin(&ground, NULL);
    for (int k = 0; k < 2; ++k) {
        test_rng rng = test_seed(9);
        add(both[k], MBSR_GROUND, test_joint_in_space(&rng, TEST_UNIVERSAL, 1.0), block(&rng));
        finish(both[k], g);
        test_fill(&rng, 2, both[k]->q);
        test_fill(&rng, 2, both[k]->u);
        accelerate(both[k], now);
    }
    assert_same_motion(&root, 0, &ground, 0, NULL);
    end(&root);
    end(&ground);
}

/* A coordinate that moves by itself as its drive would: the same accelerations of all others. */
static void a_driven_coordinate_moves_as_a_free_one_that_is_pushed(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TRIALS; ++seed) {
        side driven, pushed;
        for (int k = 0; k < 2; ++k) {
            side *s = k ? &pushed : &driven;
            test_rng rng = test_seed((uint64_t)seed);
            mbsr_axis axes[] = {turning(e_x), turning(rail), sliding(e_y)};
            axes[1].driven = !k;
            const mbsr_frame A = test_frame(&rng, 0.5), B = test_frame(&rng, 0.5);
            const mbsr_joint joint =
                mbsr_joint_compound(&A, &B, 3, axes, k ? NULL : test_motion, NULL);
            mechanism(s, seed, 1, &joint);
        }
        test_rng rng = test_seed((uint64_t)seed + 60);
        double s, sd, sdd, tau[MOST];
        test_motion(NULL, now, &s, &sd, &sdd);
        test_fill(&rng, pushed.nq, pushed.q);
        test_fill(&rng, pushed.nu, pushed.u);
        pushed.q[3] = s, pushed.u[3] = sd;
        for (int k = 0, to = 0; k < pushed.nu; ++k) {
            if (k == 3) continue;
            driven.q[to] = pushed.q[k];
            driven.u[to++] = pushed.u[k];
        }
        accelerate(&driven, now);
        for (int k = 0, from = 0; k < pushed.nu; ++k)
            pushed.udot[k] = k == 3 ? sdd : driven.udot[from++];
        mbsri_data_poison(pushed.data);
        assert_ok(mbsr_inverse_dynamics(pushed.model, pushed.data, now, pushed.q, pushed.u,
                                        pushed.udot, NULL, tau),
                  mbsr_data_error(pushed.data));
        for (int body = 0; body < 3; ++body) assert_same_motion(&driven, body, &pushed, body, NULL);
        for (int k = 0; k < pushed.nu; ++k) {
            if (k != 3) assert_close(tau[k], 0.0, 1e-11 * (1.0 + test_largest(pushed.nu, tau)));
        }
        assert_less(1e-3, fabs(tau[3]));
        end(&driven);
        end(&pushed);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_joint_of_several_axes_is_a_chain_with_massless_links),
        cmocka_unit_test(a_spherical_joint_is_three_revolutes),
        cmocka_unit_test(a_free_joint_is_three_translations_and_three_rotations),
        cmocka_unit_test(a_body_cut_in_two_moves_as_before),
        cmocka_unit_test(frames_of_reference_do_not_matter),
        cmocka_unit_test(a_planar_tree_is_the_same_in_space),
        cmocka_unit_test(bodies_in_space_may_stand_on_bodies_in_the_plane),
        cmocka_unit_test(a_driven_axis_is_a_moving_root),
        cmocka_unit_test(a_root_in_space_at_rest_is_the_ground),
        cmocka_unit_test(a_driven_coordinate_moves_as_a_free_one_that_is_pushed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
