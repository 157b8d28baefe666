/* Reference solutions of Exudyn's test suite, models written by hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>

#define EXUDYN "Test suite of Exudyn (TestModels), "

static const double pi = 3.14159265358979323846, x_axis[3] = {1.0, 0.0, 0.0},
                    y_axis[3] = {0.0, 1.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};

static double norm(const double *x)
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* Where a point of a body is. */
static void place(mbsr_simulation *s, int body, const double point[3], double *x)
{
    double pose[MBSR_POSE_SIZE] = {0.0};
    sheet_check(mbsr_body_pose(s->model, s->data, body, pose), &s->error);
    for (int k = 0; k < 3; ++k) {
        x[k] = pose[MBSR_POSE_X + k];
        for (int l = 0; l < 3; ++l) x[k] += pose[MBSR_POSE_R + k + 3 * l] * point[l];
    }
}

/* Sum of the sizes of the entries of a body's position and quaternion. */
static double sizes(mbsr_simulation *s, int body, const double point[3])
{
    double x[3], pose[MBSR_POSE_SIZE] = {0.0}, sum = 0.0;
    place(s, body, point, x);
    sheet_check(mbsr_body_pose(s->model, s->data, body, pose), &s->error);
    const double *R = pose + MBSR_POSE_R;
    for (int k = 0; k < 4; ++k) {
        double square = 1.0;
        for (int l = 0; l < 3; ++l) square += (k == 0 || k == l + 1 ? 1.0 : -1.0) * R[4 * l];
        sum += 0.5 * sqrt(fmax(square, 0.0));
    }
    for (int k = 0; k < 3; ++k) sum += fabs(x[k]);
    return sum;
}

static mbsr_inertia cuboid(double density, double x, double y, double z)
{
    const double edges[3] = {x, y, z};
    return mbsr_inertia_box(density, edges);
}

/* A cuboid whose centre is at (x, y, 0) of its body. */
static mbsr_inertia cuboid_at(double density, double a, double b, double c, double x, double y)
{
    const mbsr_frame at = mbsr_frame_at(x, y, 0.0);
    return mbsr_inertia_in_frame(&at, cuboid(density, a, b, c));
}

/* A chain of hinges by its own recursion, explicit steps: as exact as its last digits. */
static void kinematic_trees(sheet *out)
{
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, "link", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis),
                             cuboid_at(1000.0, 1.0, 0.1, 0.1, 0.5, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    sheet_start(&s, 1e-11, NULL, NULL);
    sheet_run(&s, 1.0);
    sheet_problem(out, "Pendulum of a cuboid at 1 s",
                  EXUDYN "ObjectKinematicTree.py: steps of 10⁻³ s of order 7.");
    sheet_add(out, "φ, rad", -3.134018551808591, s.q[0], 1e-8);
    mbsr_simulation_end(&s);

    const mbsr_frame half = mbsr_frame_rotated(NULL, x_axis, 0.5 * pi),
                     turned = mbsr_frame_rotated(NULL, y_axis, 0.25 * pi),
                     both = mbsr_frame_product(&half, &turned), step = mbsr_frame_at(2.0, 0.0, 0.0);
    double sum = 0.0;
    int body = MBSR_GROUND;
    s = mbsr_simulation_begin(NULL);
    for (int k = 0; k < 5; ++k) {
        const mbsr_frame identity = mbsr_frame_identity(),
                         at = mbsr_frame_product(&step, k % 3 >= 1 ? &both : &turned);
        body = mbsr_simulation_add_body(&s, NULL, body,
                                        mbsr_joint_revolute(k == 0 ? &identity : &at, NULL, z_axis),
                                        cuboid_at(1000.0, 2.0, 0.1, 0.1, 1.0, 0.0));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -10.0, 0.0));
    sheet_start(&s, 1e-10, NULL, NULL);
    sheet_run(&s, 1.0);
    for (int k = 0; k < 5; ++k) sum += s.q[k];
    sheet_problem(out, "Chain of five links, axes turned, at 1 s",
                  EXUDYN "kinematicTreeTest.py: steps of 5·10⁻³ s of order 4.");
    sheet_add(out, "sum of the angles, rad", -1.309383960216414, sum, 1e-8);
    mbsr_simulation_end(&s);
}

static void mass_on_a_spring(sheet *out)
{
    static const double u[3] = {1.0, 0.0, 0.0}, zero[3] = {0.0, 0.0, 0.0};
    const mbsr_frame at = mbsr_frame_at(1.0, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(
        &s, "mass", MBSR_GROUND, mbsr_joint_translational(&at, NULL), mbsr_inertia_particle(10.0));
    mbsr_simulation_add_force(
        &s, mbsr_force_point_spring(MBSR_GROUND, zero, body, zero, 1000.0, 0.0, 1.0));
    sheet_start(&s, 1e-11, NULL, u);
    sheet_run(&s, 2.0);
    sheet_problem(out, "Mass on a spring at 2 s", EXUDYN "velocityVerletTest.py, exact.");
    sheet_add(out, "x, m", 1.091294525072764, 1.0 + s.q[0], 1e-8);
    mbsr_simulation_end(&s);
}

/* A bar of which one end lies in a stiff bushing. */
static void elastic_pendulum(sheet *out)
{
    static const double com[2] = {0.5, 0.0}, stiffness[9] = {5e5, 0.0, 0.0, 0.0, 5e5},
                        damping[9] = {5e3, 0.0, 0.0, 0.0, 5e3};
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0}, hook = {-1.0, 1.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body =
        mbsr_simulation_add_body(&s, "bar", MBSR_GROUND, mbsr_joint_planar_free(hook, origin),
                                 mbsr_inertia_planar(12.0, com, 1.0));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_add_force(
        &s, mbsr_force_planar_bushing(MBSR_GROUND, hook, body, origin, stiffness, damping));
    sheet_start(&s, 1e-9, NULL, NULL);
    sheet_run(&s, 0.4);
    sheet_problem(out, "Bar in a stiff bushing at 0.4 s",
                  EXUDYN "rigidBody2Dtest.py: the same body three times; steps of 10⁻³ s.");
    sheet_add(out, "angle and distance of the centre", -0.5055295700922415 / 3.0,
              s.q[2] + hypot(-1.0 + s.q[0] + 0.5 * cos(s.q[2]), 1.0 + s.q[1] + 0.5 * sin(s.q[2])),
              1e-5);
    mbsr_simulation_end(&s);
}

/* A hinge, then a ball joint; full tensors of inertia. */
static void two_bodies(sheet *out)
{
    static const double com[3] = {0.3, 0.0, 0.0}, tensor[6] = {10.0, 7.0, 6.0, 1.0, 2.0, 3.0};
    const mbsr_frame end = mbsr_frame_at(0.6, 0.0, 0.0);
    double x[3];
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int first = mbsr_simulation_add_body(&s, "first", MBSR_GROUND,
                                               mbsr_joint_revolute(NULL, NULL, z_axis),
                                               mbsr_inertia_rigid_unchecked(25.0, com, tensor)),
              second =
                  mbsr_simulation_add_body(&s, "second", first, mbsr_joint_spherical(&end, NULL),
                                           mbsr_inertia_rigid_unchecked(25.0, com, tensor));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    sheet_start(&s, 1e-9, NULL, NULL);
    sheet_run(&s, 1.0);
    place(&s, second, com, x);
    x[0] -= 0.9;
    sheet_problem(out, "Hinge and ball joint at 1 s",
                  EXUDYN "rigidBodyCOMtest.py: steps of 10⁻² s.");
    sheet_add(out, "way of the second centre, twice, m", 3.409431467726291, 2.0 * norm(x), 1e-5);
    mbsr_simulation_end(&s);
}

/* A body that slides along a line, and three more on ball joints. */
static void ball_joints(sheet *out)
{
    static const double tensor[6] = {6.0, 1.0, 6.0}, centre[3] = {0.0, 0.0, 0.0},
                        ahead[3] = {0.3, 0.0, -0.1};
    const mbsr_frame from = mbsr_frame_at(-0.3, 0.0, 0.0), end = mbsr_frame_at(0.3, 0.0, 0.1),
                     next = mbsr_frame_at(0.6, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int slide = mbsr_simulation_add_body(&s, "slide", MBSR_GROUND,
                                               mbsr_joint_prismatic(&from, NULL, x_axis),
                                               mbsr_inertia_zero()),
              first = mbsr_simulation_add_body(&s, NULL, slide, mbsr_joint_spherical(NULL, NULL),
                                               mbsr_inertia_rigid(2.0, centre, tensor));
    int body = first, second = MBSR_NONE;
    for (int k = 0; k < 3; ++k) {
        body = mbsr_simulation_add_body(&s, NULL, body,
                                        mbsr_joint_spherical(k == 0 ? &end : &next, NULL),
                                        mbsr_inertia_rigid(2.0, ahead, tensor));
        if (k == 0) second = body;
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    sheet_start(&s, 1e-9, NULL, NULL);
    sheet_run(&s, 1.0);
    sheet_problem(out, "Four bodies on ball joints, the first on a line, at 1 s",
                  EXUDYN "sphericalJointTest.py: steps of 10⁻³ s.");
    sheet_add(out, "sizes of positions and quaternions of two", 4.409080446575089,
              sizes(&s, first, centre) + sizes(&s, second, ahead), 1e-5);
    mbsr_simulation_end(&s);
}

static void double_pendulum(sheet *out)
{
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0}, end = {0.8, 0.0, 0.0};
    static const double com[2] = {0.8, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int first = mbsr_simulation_add_body(&s, "first", MBSR_GROUND,
                                               mbsr_joint_planar_revolute(origin, origin),
                                               mbsr_inertia_planar(2.5, com, 0.0));
    mbsr_simulation_add_body(&s, "second", first, mbsr_joint_planar_revolute(end, origin),
                             mbsr_inertia_planar(2.5, com, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    sheet_start(&s, 1e-10, NULL, NULL);
    sheet_run(&s, 1.0);
    sheet_problem(out, "Double pendulum of two points at 1 s",
                  EXUDYN "coordinateVectorConstraint.py: steps of 10⁻³ s.");
    sheet_add(out, "x + y of the first, m", -1.0825265797698322, 0.8 * (cos(s.q[0]) + sin(s.q[0])),
              2e-5);
    mbsr_simulation_end(&s);
}

static int crank_torque(void *user, double t, int n, double *value)
{
    (void)user;
    (void)t;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    value[n - 1] = 0.1;
    return MBSR_OK;
}

/* Crank, rod and slider, on the ground or on a body in soft springs. */
static double slider_crank(int floating)
{
    static const double half1[2] = {0.05, 0.0}, half2[2] = {0.15, 0.0}, end[3] = {0.3, 0.0, 0.0};
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0}, pin = {0.1, 0.0, 0.0}, slot = {0.4, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int base = MBSR_GROUND;
    if (floating) {
        base = mbsr_simulation_add_body(&s, "base", MBSR_GROUND,
                                        mbsr_joint_planar_free(origin, origin),
                                        mbsr_inertia_planar(2.0, NULL, 1.0));
        for (int k = 0; k < 3; ++k)
            mbsr_simulation_add_force(&s, mbsr_force_joint_spring(base, k, 5000.0, 50.0, 0.0));
    }
    const int crank = mbsr_simulation_add_body(&s, "crank", base,
                                               mbsr_joint_planar_revolute(origin, origin),
                                               mbsr_inertia_planar(0.2, half1, 0.2 / 12.0 * 0.01)),
              rod = mbsr_simulation_add_body(&s, "rod", crank,
                                             mbsr_joint_planar_revolute(pin, origin),
                                             mbsr_inertia_planar(0.2, half2, 0.2 / 12.0 * 0.09)),
              slider = mbsr_simulation_add_body(&s, "slider", base,
                                                mbsr_joint_planar_prismatic(slot, origin),
                                                mbsr_inertia_planar(0.4, NULL, 4e-4));
    double pose[MBSR_POSE_SIZE] = {0.0};
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(rod, end, slider, NULL));
    mbsr_simulation_add_force(&s, mbsr_force_applied(crank, crank_torque, NULL));
    sheet_start(&s, 1e-9, NULL, NULL);
    sheet_run(&s, 0.3);
    sheet_check(mbsr_body_pose(s.model, s.data, slider, pose), &s.error);
    mbsr_simulation_end(&s);
    return fabs(pose[0]);
}

static void slider_cranks(sheet *out)
{
    sheet_problem(
        out, "Slider-crank under a constant torque, on the ground and on an elastic base, at 0.3 s",
        EXUDYN "sliderCrankFloatingTest.py: steps of 6·10⁻⁵ s.");
    sheet_add(out, "sum of both sliders' x, m", 0.591649163378833,
              slider_crank(0) + slider_crank(1), 1e-7);
}

/* A cart on a spring and a chain of four links whose end stays level. */
static void cart_and_chain(sheet *out)
{
    static const double end[3] = {0.0, 0.5, 0.0}, level[3] = {2.0, 0.0, 0.0}, down[3] = {0, 1, 0},
                        origin[3] = {0.0, 0.0, 0.0};
    const mbsr_frame step = mbsr_frame_at(0.0, 0.5, 0.0);
    double x[3];
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body =
        mbsr_simulation_add_body(&s, "cart", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, x_axis),
                                 cuboid(5000.0, 0.5, 0.1, 0.1));
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, 20000.0, 400.0, 0.0));
    for (int k = 0; k < 4; ++k) {
        const mbsr_frame first = mbsr_frame_rotated(NULL, z_axis, -0.5 * pi);
        body = mbsr_simulation_add_body(&s, NULL, body,
                                        mbsr_joint_revolute(k == 0 ? &first : &step, NULL, z_axis),
                                        cuboid_at(1000.0, 0.1, 0.5, 0.1, 0.0, 0.25));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_add_closure(&s, mbsr_closure_rows(body, end, MBSR_GROUND, level, 1, down));
    sheet_start(&s, 1e-9, NULL, NULL);
    sheet_run(&s, 0.5);
    place(&s, body, origin, x);
    mbsr_simulation_end(&s);
    sheet_problem(out, "Cart and chain, its end on a line, at 0.5 s",
                  EXUDYN "kinematicTreeConstraintTest.py, twice the same; steps of 4·10⁻³ s.");
    sheet_add(out, "distances of the last hinge, m", 1.8135975384620484, 2.0 * norm(x), 5e-4);
}

/* The spatial slider-crank of IFToMM's benchmarks, for a short time. */
static void spatial_slider_crank(sheet *out)
{
    static const double crank_tensor[6] = {1e-4, 1e-5, 1e-4}, rod_tensor[6] = {4e-4, 4e-3, 4e-3},
                        slider_tensor[6] = {1e-4, 1e-4, 1e-4}, centre[3] = {0.0, 0.0, 0.0},
                        top[3] = {0.0, 0.0, 0.08}, foot[3] = {-0.15, 0.0, 0.0};
    const double reach = sqrt(0.09 - 0.01 - 0.04), x[3] = {reach / 0.3, -0.1 / 0.3, -0.2 / 0.3},
                 q[4] = {0.0, reach, 0.0, 0.0};
    /* z of the rod: what is left of A's place across the rod. */
    double z[3] = {0.0, 0.1, 0.12}, R[9];
    const double along = z[0] * x[0] + z[1] * x[1] + z[2] * x[2];
    for (int k = 0; k < 3; ++k) z[k] -= along * x[k];
    const double size = norm(z);
    for (int k = 0; k < 3; ++k) z[k] /= size;
    for (int k = 0; k < 3; ++k) {
        R[k] = x[k];
        R[3 + k] = z[(k + 1) % 3] * x[(k + 2) % 3] - z[(k + 2) % 3] * x[(k + 1) % 3];
        R[6 + k] = z[k];
    }
    mbsr_frame pose = mbsr_frame_at(-0.15 * x[0], -0.15 * x[1], -0.15 * x[2]);
    for (int k = 0; k < 9; ++k) pose.R[k] = R[k];
    const mbsr_frame back = mbsr_frame_inverse(&pose), pivot = mbsr_frame_at(0.0, 0.1, 0.12);
    const mbsr_axis axes[2] = {{MBSR_AXIS_ROTATION, {1.0, 0.0, 0.0}, 0.0, 0},
                               {MBSR_AXIS_ROTATION, {R[3], R[4], R[5]}, 0.0, 0}};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int crank = mbsr_simulation_add_body(&s, "crank", MBSR_GROUND,
                                               mbsr_joint_revolute(&pivot, NULL, x_axis),
                                               mbsr_inertia_rigid(0.12, centre, crank_tensor)),
              slider = mbsr_simulation_add_body(&s, "slider", MBSR_GROUND,
                                                mbsr_joint_prismatic(NULL, NULL, x_axis),
                                                mbsr_inertia_rigid(2.0, centre, slider_tensor)),
              rod = mbsr_simulation_add_body(&s, "rod", slider,
                                             mbsr_joint_compound(NULL, &back, 2, axes, NULL, NULL),
                                             mbsr_inertia_rigid(0.5, centre, rod_tensor));
    mbsr_simulation_add_closure(&s, mbsr_closure_ball(rod, foot, crank, top));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    mbsr_simulation_set_position(&s, crank, 0, 0.0);
    mbsr_simulation_set_rate(&s, crank, 0, 6.0);
    sheet_start(&s, 1e-9, q, NULL);
    sheet_run(&s, 0.2);
    sheet_problem(out, "Slider-crank in space at 0.2 s",
                  EXUDYN "sliderCrank3Dtest.py, benchmark of IFToMM; steps of 2·10⁻⁴ s.");
    sheet_add(out, "sizes of positions and quaternions of two", 3.3642761780921897,
              sizes(&s, crank, centre) + sizes(&s, rod, centre), 1e-7);
    mbsr_simulation_end(&s);
}

/* A coin that rolls in circles: the place of contact. */
static void coin(sheet *out)
{
    const double r = 0.01, tilt = pi / 180.0, spin = 10.0 * pi,
                 place0[3] = {r * sin(tilt), 0.0, r * cos(tilt)},
                 tensor[6] = {0.5 * r * r, 0.25 * r * r, 0.25 * r * r}, zero[3] = {0.0, 0.0, 0.0};
    const mbsr_frame at = mbsr_frame_rotated(place0, y_axis, tilt),
                     disc = mbsr_frame_rotated(zero, y_axis, 0.5 * pi),
                     plane = mbsr_frame_identity();
    const double q[7] = {1.0};
    /* Twists: of the body, along its own axes. */
    const double u[6] = {-spin * sin(tilt), 0.0, spin * cos(tilt), 0.0, spin * r * sin(tilt), 0.0};
    double x[3];
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body = mbsr_simulation_add_body(&s, "coin", MBSR_GROUND, mbsr_joint_free(&at, NULL),
                                              mbsr_inertia_rigid(1.0, zero, tensor));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    const int rolling = mbsr_simulation_add_closure(
        &s, mbsr_closure_rolling_disc(body, &disc, r, MBSR_GROUND, &plane));
    sheet_start(&s, 1e-10, q, u);
    sheet_run(&s, 0.5);
    sheet_check(mbsr_closure_point(s.model, s.data, rolling, x), &s.error);
    sheet_problem(out, "Rolling coin at 0.5 s",
                  EXUDYN
                  "rollingCoinTest.py: steps of 5·10⁻⁴ s; the number noted there up to 2024.");
    sheet_add(out, "x of contact, m", 0.0020040999273379673, x[0], 2e-6);
    mbsr_simulation_end(&s);
}

void sheet_exudyn(sheet *out)
{
    kinematic_trees(out);
    mass_on_a_spring(out);
    elastic_pendulum(out);
    two_bodies(out);
    ball_joints(out);
    double_pendulum(out);
    slider_cranks(out);
    cart_and_chain(out);
    spatial_slider_crank(out);
    coin(out);
}
