/* More mechanisms with the driver: other cuts of one loop, rolling, loops in space with rows that
 * are redundant in every position, massless directions that no loop holds, drift.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

#include <mbsrank/simulation.h>

/* ---- other cuts of the four-bar linkage ---- */

static void four_bar(loops *s, int cut)
{
    const mbsr_planar_frame own = {0.0, 0.0, 0.0}, end_of_coupler = {2.5, 0.0, 0.0};
    const mbsr_frame end_of_rocker = mbsr_frame_at(2.0, 0.0, 0.0);
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(s, "coupler", a, 1.0, 0.0, 2.5, 2.5);
    const double q[3] = {1.256084040027, -0.8663220350055, 1.254529363248};
    memcpy(s->q, q, sizeof q);
    if (cut == 0) { /* at the rocker's end: a pin */
        const int c = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
        loops_pin(s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    } else if (cut == 1) { /* the same by a cut body and a weld */
        const int c = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
        const mbsr_joint pin = mbsr_joint_planar_revolute(end_of_coupler, own);
        assert_ok(mbsr_model_add_loop_joint(s->m, "pin", b, &pin, c, &end_of_rocker, NULL, NULL),
                  mbsr_model_error(s->m));
        s->q[3] = q[2] - q[0] - q[1];
    } else { /* at the ground: the rocker hangs on the coupler, turned round */
        int c;
        mbsr_body_def body = mbsr_default_body_def();
        body.name = "rocker";
        body.parent = b;
        body.joint = mbsr_joint_planar_revolute(end_of_coupler, (mbsr_planar_frame){2.0, 0.0, 0.0});
        body.inertia = mbsr_inertia_planar(2.0, (double[2]){1.0, 0.0}, 2.0 * 4.0 / 12.0);
        assert_ok(mbsr_model_add_body(s->m, &body, &c), NULL);
        if (cut == 2) {
            loops_pin(s, "pin", c, 0.0, 0.0, MBSR_GROUND, 2.0, 0.0);
        } else { /* a massless rod: the distance from the rocker's foot, which must be where it is
                  */
            const double x[6] = {1.0, 0.0, 0.0, 1.0, 1.0, 0.0}, foot[3] = {2.0, 0.0, 0.0};
            const mbsr_closure_def rows = mbsr_closure_rows(c, NULL, MBSR_GROUND, foot, 2, x);
            assert_ok(mbsr_model_add_closure(s->m, &rows, NULL), NULL);
        }
        s->q[2] = q[2] - q[0] - q[1];
    }
    loops_finish(s);
    s->u[0] = 5.0;
    if (cut == 0) loops_velocities(s, 0.0);
    if (cut == 0) return;
    /* the same velocities in these coordinates */
    loops with_pin;
    four_bar(&with_pin, 0);
    memcpy(s->u, with_pin.u, 3 * sizeof *s->u);
    s->u[cut == 1 ? 3 : 2] = s->u[2] - s->u[0] - s->u[1];
    loops_free(&with_pin);
}

/* The same motion with every cut, to 1000 tolerances, and as many steps to 30 percent. */
static void compare_cuts(void (*make)(loops *, int), int cuts)
{
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    double truth = 0.0;
    long first = 0;
    for (int cut = 0; cut < cuts; ++cut) {
        long steps = 0;
        for (int k = 2; k >= 0; --k) {
            loops s;
            make(&s, cut);
            const loops_result r = loops_run(&s, tolerance[k], 1.0);
            assert_int_equal(r.status, MBSR_OK);
            if (cut == 0 && k == 2) truth = s.q[0];
            assert_close(s.q[0], truth, 1e3 * tolerance[k]);
            steps += r.steps;
            loops_free(&s);
        }
        if (cut == 0) first = steps;
        assert_true(10 * steps <= 13 * first && 10 * steps >= 7 * first);
    }
}

static void other_cuts(void **state)
{
    (void)state;
    compare_cuts(four_bar, 4);
}

/* ---- other cuts of a slider-crank mechanism ---- */

/* Crank 0.5 m, rod 1.5 m, slider of 1 kg on a line through the crank's hinge; cut at the rod's end,
 * or at the slider's guide: by a prismatic joint, or by a row for its place and one for its turn.
 */
static void slider_crank(loops *s, int cut)
{
    const mbsr_planar_frame own = {0.0, 0.0, 0.0}, end = {1.5, 0.0, 0.0};
    const double angle = -asin(0.5 * sin(1.0) / 1.5), x = 0.5 * cos(1.0) + 1.5 * cos(angle),
                 turn = -0.5 * cos(1.0) * 4.0 / (1.5 * cos(angle)),
                 speed = -0.5 * sin(1.0) * 4.0 - 1.5 * sin(angle) * turn;
    int c;
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 0.5);
    const int b = loops_rod(s, "rod", a, 0.5, 0.0, 1.0, 1.5);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "slider";
    body.inertia = mbsr_inertia_planar(1.0, (double[2]){0.0, 0.0}, 0.1);
    body.parent = cut == 0 ? MBSR_GROUND : b;
    body.joint =
        cut == 0 ? mbsr_joint_planar_prismatic(own, own) : mbsr_joint_planar_revolute(end, own);
    assert_ok(mbsr_model_add_body(s->m, &body, &c), mbsr_model_error(s->m));
    if (cut == 0) loops_pin(s, "pin", b, 1.5, 0.0, c, 0.0, 0.0);
    if (cut == 1) {
        const mbsr_joint guide = mbsr_joint_planar_prismatic(own, own);
        assert_ok(
            mbsr_model_add_loop_joint(s->m, "guide", MBSR_GROUND, &guide, c, NULL, NULL, NULL),
            mbsr_model_error(s->m));
    }
    if (cut == 2) {
        const double up[3] = {0.0, 1.0, 0.0};
        const mbsr_closure_def guide = mbsr_closure_rows(c, NULL, MBSR_GROUND, NULL, 1, up),
                               level =
                                   mbsr_closure_coupling(3, (int[3]){a, b, c}, (int[3]){0, 0, 0},
                                                         (double[3]){1.0, 1.0, 1.0}, 0.0);
        assert_ok(mbsr_model_add_closure(s->m, &guide, NULL), mbsr_model_error(s->m));
        assert_ok(mbsr_model_add_closure(s->m, &level, NULL), mbsr_model_error(s->m));
    }
    loops_finish(s);
    const double q[4] = {1.0, angle - 1.0, cut == 0 ? x : -angle, x},
                 u[4] = {4.0, turn - 4.0, cut == 0 ? speed : -turn, speed};
    memcpy(s->q, q, sizeof q);
    memcpy(s->u, u, sizeof u);
}

static void other_cuts_of_a_slider_crank(void **state)
{
    (void)state;
    compare_cuts(slider_crank, 3);
}

/* ---- a pin in a slot of a body that turns ---- */

/* Crank with a pin in the slot of a rocker: by a row fixed in the rocker, and by a joint with two
 * freedoms (turning on a prismatic joint) as a loop joint. */
static void a_slotted_link(void **state)
{
    (void)state;
    double truth[2] = {0.0, 0.0};
    for (int way = 0; way < 2; ++way) {
        loops s;
        const mbsr_planar_frame own = {0.0, 0.0, 0.0};
        const double across[3] = {0.0, 2.0, 0.0}, end[3] = {0.4, 0.0, 0.0};
        loops_begin(&s, NULL);
        const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 0.4);
        const int b = loops_rod(&s, "rocker", MBSR_GROUND, 0.0, -1.0, 2.0, 1.6);
        if (way == 0) {
            const mbsr_closure_def slot = mbsr_closure_body_rows(a, end, b, NULL, 1, across);
            assert_ok(mbsr_model_add_closure(s.m, &slot, NULL), mbsr_model_error(s.m));
        } else {
            int c;
            mbsr_body_def block = mbsr_default_body_def();
            block.parent = b;
            block.joint = mbsr_joint_planar_prismatic(own, own);
            assert_ok(mbsr_model_add_body(s.m, &block, &c), mbsr_model_error(s.m));
            loops_pin(&s, "pin", c, 0.0, 0.0, a, 0.4, 0.0);
        }
        loops_finish(&s);
        /* the pin at (0.4 cos 0.5, 0.4 sin 0.5) seen from the rocker's hinge at (0, -1) */
        const double x = 0.4 * cos(0.5), y = 1.0 + 0.4 * sin(0.5);
        s.q[0] = 0.5, s.q[1] = atan2(y, x), s.q[2] = hypot(x, y);
        s.u[0] = 6.0;
        s.u[1] = 6.0 * 0.4 * (x * cos(0.5) + y * sin(0.5)) / (x * x + y * y);
        s.u[2] = 6.0 * 0.4 * (y * cos(0.5) - x * sin(0.5)) / hypot(x, y);
        assert_int_equal(loops_run(&s, 1e-8, 1.5).status, MBSR_OK);
        for (int k = 0; k < 2; ++k) {
            if (way == 0) truth[k] = s.q[k];
            assert_close(s.q[k], truth[k], 1e-5);
        }
        assert_close(sin(s.q[1]) * 0.4 * cos(s.q[0]), cos(s.q[1]) * (1.0 + 0.4 * sin(s.q[0])),
                     1e-7);
        loops_free(&s);
    }
}

/* ---- dead centres ---- */

static int upright_bar(mbsr_simulation *s, int parent, double x, double angle)
{
    static const double com[2] = {0.5, 0.0};
    return mbsr_simulation_add_body(s, NULL, parent,
                                    mbsr_joint_planar_revolute((mbsr_planar_frame){x, 0.0, angle},
                                                               (mbsr_planar_frame){0.0, 0.0, 0.0}),
                                    mbsr_inertia_planar(1.0, com, 1.0 / 12.0));
}

/* The angle of all cranks after t: m a'' = -w cos a. */
static double angle_of_cranks(int count, double t)
{
    enum { STEPS = 20000 };
    const double h = t / STEPS, w = 9.81 * (0.5 * (count + 1) + count),
                 m = (count + 1) / 3.0 + count;
    double a = acos(0.0), u = -1.0;
    for (int k = 0; k < STEPS; ++k) {
        const double half = u - 0.5 * h * w / m * cos(a);
        a += h * half;
        u = half - 0.5 * h * w / m * cos(a);
    }
    return a;
}

/* Cranks of 1 m on the ground, 1 m apart, and a coupler from the end of each to that of the next.
 * Where they lie flat loop forces are not determined. Close to it rounding of rows, multiplied,
 * kept corrections above the tolerance: at 1e-10 steps shrank until the run ended there. */
static void thirty_four_bars_pass_dead_centres(void **state)
{
    (void)state;
    enum { LOOPS = 30 };
    static const double tip[3] = {1.0, 0.0, 0.0}, t_end = 1.5;
    const double up = acos(0.0);
    int crank[LOOPS + 1];
    mbsr_ida_stats stats;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    for (int k = 0; k <= LOOPS; ++k) crank[k] = upright_bar(&s, MBSR_GROUND, k, up);
    for (int k = 0; k < LOOPS; ++k) {
        const int coupler = upright_bar(&s, crank[k], 1.0, -up);
        mbsr_simulation_add_closure(&s, mbsr_closure_ball(coupler, tip, crank[k + 1], tip));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_set_rate(&s, crank[0], 0, -1.0);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-10;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    mbsr_simulation_to(&s, t_end);
    assert_ok(mbsr_simulation_status(&s), mbsr_simulation_error(&s));
    for (int k = 0; k <= LOOPS; ++k)
        assert_close(up + mbsr_simulation_q(&s)[k], angle_of_cranks(LOOPS, t_end), 2e-7);
    assert_ok(mbsr_simulation_get_stats(&s, &stats), NULL);
    assert_less((double)stats.steps, 1000.0);
    mbsr_simulation_end(&s);
}

/* ---- rolling ---- */

/* A disc that rolls on a circle: lean a, radius R of the disc, rate w of heading, spin s about its
 * axis, I along it and J across. With the velocity R (w sin a - s) of the centre, the moment about
 * the centre is
 *
 *   w cos(a) (I s - (I - J) w sin a) = m R^2 w cos(a) (w sin a - s) + m g R sin a */
static void a_steady_disc(void **state)
{
    (void)state;
    const double R = 0.25, mass = 2.0, I = 0.5 * mass * R * R, J = 0.5 * I, lean = 0.3, w = 1.7;
    const double spin = (mass * 9.81 * R * tan(lean) + (mass * R * R + I - J) * w * w * sin(lean)) /
                        ((I + mass * R * R) * w);
    const double x[3] = {1.0, 0.0, 0.0}, none[3] = {0.0};
    const double tensor[6] = {J, J, I, 0.0, 0.0, 0.0}, up[3] = {0.0, 1.0, 0.0};
    const mbsr_frame plane = mbsr_frame_along(NULL, up);
    loops s;
    loops_begin(&s, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "disc";
    body.joint = mbsr_joint_free(NULL, NULL);
    body.inertia = mbsr_inertia_rigid(mass, none, tensor);
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), mbsr_model_error(s.m));
    mbsr_closure_def roll = mbsr_closure_rolling_disc(0, NULL, R, MBSR_GROUND, &plane);
    roll.name = "road";
    assert_ok(mbsr_model_add_closure(s.m, &roll, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    /* y up; the axis z turned about x by the lean, so that it points down by sin(lean) */
    const mbsr_frame at = mbsr_frame_rotated(NULL, x, lean);
    mbsr_rotation_quaternion(at.R, s.q);
    const double *axis = at.R + 6;
    s.q[5] = R * cos(lean);
    /* omega = w up + spin axis */
    for (int k = 0; k < 3; ++k) s.u[k] = w * up[k] + spin * axis[k];
    /* v = omega x (from contact to centre) */
    const double arm[3] = {0.0, R * cos(lean), R * sin(lean)};
    s.u[3] = s.u[1] * arm[2] - s.u[2] * arm[1];
    s.u[4] = s.u[2] * arm[0] - s.u[0] * arm[2];
    s.u[5] = s.u[0] * arm[1] - s.u[1] * arm[0];
    double pose[MBSR_POSE_SIZE], rate[3], gap[1];
    loops_rows(&s, 0.0, s.q, s.u, NULL, gap, rate, NULL);
    assert_close(gap[0], 0.0, 1e-14);
    assert_less(test_largest(3, rate), 1e-13);
    const double x0 = s.q[4], z0 = s.q[6], v = s.u[3], T = 3.0;
    const loops_result r = loops_run(&s, 1e-8, T);
    assert_int_equal(r.status, MBSR_OK);
    assert_ok(mbsr_body_pose(s.m, s.d, 0, pose), NULL);
    assert_close(fabs(asin(pose[7])), lean, 1e-5);
    assert_close(pose[10], R * cos(lean), 1e-5);
    /* the centre goes round a circle of radius v / w */
    const double turn = w * T;
    assert_close(s.q[4] - x0, v / w * sin(turn), 1e-4);
    assert_close(s.q[6] - z0, -v / w * (1.0 - cos(turn)), 1e-4);
    loops_free(&s);
}

/* ---- massless directions that no loop holds ---- */

/* Crank, three massless rods, rocker; the knees are held by springs and dampers. */
static void free_knees(void **state)
{
    (void)state;
    double truth = 0.0;
    for (int k = 2; k >= 0; --k) {
        static const double tolerance[] = {1e-4, 1e-6, 1e-8};
        loops s;
        loops_begin(&s, NULL);
        const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
        const int b = loops_rod(&s, "rod", a, 1.0, 0.0, 0.0, 1.0);
        const int c = loops_rod(&s, "rod", b, 1.0, 0.0, 0.0, 1.0);
        const int e = loops_rod(&s, "rod", c, 1.0, 0.0, 0.0, 1.0);
        const int f = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 1.0);
        const double end[3] = {1.0, 0.0, 0.0}, one[3] = {1.0, 3.0, 0.0}, two[3] = {1.5, 3.0, 0.0};
        const mbsr_force_def spring[2] = {
            mbsr_force_point_spring(b, end, MBSR_GROUND, one, 60.0, 5.0, 0.2),
            mbsr_force_point_spring(c, end, MBSR_GROUND, two, 60.0, 5.0, 0.2)};
        for (int j = 0; j < 2; ++j) assert_ok(mbsr_model_add_force(s.m, spring + j, NULL), NULL);
        loops_pin(&s, "rod-rocker", e, 1.0, 0.0, f, 1.0, 0.0);
        loops_finish(&s);
        const double q[5] = {1.6, -0.8, -0.8, -1.2, 1.4};
        memcpy(s.q, q, sizeof q);
        s.u[0] = 2.0;
        mbsr_closure_report report;
        double closed[5];
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, closed, NULL), mbsr_data_error(s.d));
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, closed, &report, NULL, NULL),
                  mbsr_data_error(s.d));
        assert_int_equal(report.undetermined, 1);
        const loops_result r = loops_run(&s, tolerance[k], 2.0);
        assert_int_equal(r.status, MBSR_OK);
        if (k == 2) truth = s.q[0];
        assert_close(s.q[0], truth, 300.0 * tolerance[k]);
        loops_free(&s);
    }
}

/* ---- drift ---- */

static void a_long_run(void **state)
{
    (void)state;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "coupler", a, 1.0, 0.0, 0.0, 2.5);
    const int c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(&s);
    s.q[0] = 1.2, s.q[1] = -0.9, s.q[2] = 1.3, s.u[0] = 6.0;
    const loops_result r = loops_run(&s, 1e-6, 100.0);
    assert_int_equal(r.status, MBSR_OK);
    assert_less(r.gap, 1e-5);
    loops_free(&s);
}

/* ---- Bricard's linkage: six revolute joints, mobile against the count of rows ---- */

/* Rods of 1 m and 1 kg, section 0.1 m square, gravity along -y, from rest; the sixth side is the
 * ground. The sixth joint is a cut body and a weld: six rows, five of them independent in every
 * position. */
static void bricard(void **state)
{
    (void)state;
    static const double P[6][3] = {{0, 0, 0},  {1, 0, 0},  {1, -1, 0},
                                   {1, -1, 1}, {0, -1, 1}, {0, 0, 1}},
                        axis[6][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0},
                                      {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    loops s;
    int last = MBSR_GROUND, redundant[6], sum = 0;
    mbsr_frame at = mbsr_frame_identity();
    double pose[MBSR_POSE_SIZE], energy[4], change = 0.0;
    loops_begin(&s, NULL);
    for (int k = 0; k < 5; ++k) {
        double com[3], tensor[6] = {0.0}, next[3];
        mbsr_body_def body = mbsr_default_body_def();
        for (int j = 0; j < 3; ++j) {
            next[j] = P[k + 1][j] - P[k][j];
            com[j] = 0.5 * next[j];
            tensor[j] = (fabs(next[j]) > 0.5 ? 0.02 : 1.01) / 12.0;
        }
        body.name = "rod";
        body.parent = last;
        body.joint = mbsr_joint_revolute(&at, NULL, axis[k]);
        body.inertia = mbsr_inertia_rigid(1.0, com, tensor);
        assert_ok(mbsr_model_add_body(s.m, &body, &last), mbsr_model_error(s.m));
        at = mbsr_frame_at(next[0], next[1], next[2]);
    }
    const mbsr_joint sixth = mbsr_joint_revolute(&at, NULL, axis[5]);
    const mbsr_frame there = mbsr_frame_at(P[5][0], P[5][1], P[5][2]);
    assert_ok(
        mbsr_model_add_loop_joint(s.m, "sixth", last, &sixth, MBSR_GROUND, &there, NULL, NULL),
        mbsr_model_error(s.m));
    loops_finish(&s);
    for (int end = 0; end < 2; ++end) {
        mbsr_closure_report report;
        assert_ok(mbsr_closures_report(s.m, s.d, 0.0, s.q, &report, redundant, NULL),
                  mbsr_data_error(s.d));
        assert_int_equal(report.rows, 6);
        assert_int_equal(report.independent, 5);
        assert_int_equal(report.nearby, 5);
        assert_int_equal(report.mobility, 1);
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), NULL);
        assert_ok(mbsr_stage_velocities(s.m, s.d, s.u), NULL);
        assert_ok(mbsr_energy(s.m, s.d, energy + 2 * end, energy + 2 * end + 1), NULL);
        if (end == 1) continue;
        const loops_result r = loops_run(&s, 1e-8, 2.0);
        assert_int_equal(r.status, MBSR_OK);
        change = r.energy;
    }
    for (int k = 0; k < 6; ++k) sum += redundant[k];
    assert_int_equal(sum, 1);
    assert_close(energy[0] + energy[1], energy[2] + energy[3], 1e-3);
    assert_close(change, energy[2] + energy[3] - energy[0] - energy[1], 1e-9);
    assert_ok(mbsr_stage_positions(s.m, s.d, 2.0, s.q), NULL);
    assert_ok(mbsr_body_pose(s.m, s.d, 2, pose), NULL);
    assert_close(pose[9], -0.77814, 1e-4);
    assert_close(pose[10], -0.98035, 1e-4);
    assert_close(pose[11], -0.19725, 1e-4);
    loops_free(&s);
}

/* ---- springs that share a force ---- */

static int turn(void *user, double t, double *phi, double *rate, double *acceleration)
{
    (void)user;
    *phi = 10.0 * t;
    *rate = 10.0;
    *acceleration = 0.0;
    return MBSR_OK;
}

static const double bend = 0.5; /* between the shafts, rad */

/* Two shafts with a universal joint, the first one driven; the second ends in a ball bearing, whose
 * row along the shaft is redundant. Rigid where stiffness is 0. */
static void shafts(loops *s, double stiffness, double damping)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, tensor[6] = {0.03, 0.03, 0.05};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_frame on_shaft = mbsr_frame_at(0.0, 0.0, 0.4),
                     tilted = mbsr_frame_rotated(NULL, x, bend),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    mbsr_body_def body = mbsr_default_body_def();
    int shaft;
    loops_begin(s, NULL);
    body.parent = MBSR_GROUND;
    body.joint = mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL);
    assert_ok(mbsr_model_add_body(s->m, &body, &shaft), mbsr_model_error(s->m));
    body.parent = shaft;
    body.joint = mbsr_joint_universal(NULL, NULL, x, y);
    body.inertia = mbsr_inertia_rigid(4.0, (double[3]){0.0, 0.0, 0.0}, tensor);
    assert_ok(mbsr_model_add_body(s->m, &body, &shaft), mbsr_model_error(s->m));
    mbsr_closure_def ball = mbsr_closure_ball(shaft, on_shaft.x, MBSR_GROUND, on_ground.x);
    for (int k = 0; k < 3; ++k) {
        ball.stiffness[k] = stiffness;
        ball.damping[k] = damping * stiffness;
    }
    assert_ok(mbsr_model_add_closure(s->m, &ball, NULL), mbsr_model_error(s->m));
    loops_finish(s);
    s->q[0] = bend;
    s->u[1] = -10.0 * sin(bend);
}

/* Angle of the second shaft, against tan(phi_2) = tan(phi_1) cos(bend) of rigid bearings. */
static double off_the_law(loops *s, double t)
{
    double p[MBSR_POSE_SIZE];
    assert_ok(mbsr_stage_positions(s->m, s->d, t, s->q), NULL);
    assert_ok(mbsr_body_pose(s->m, s->d, 1, p), NULL);
    const double *x = p + MBSR_POSE_R, along = x[1] * cos(bend) + x[2] * sin(bend),
                 angle = atan2(along, x[0]), law = atan2(sin(10.0 * t) * cos(bend), cos(10.0 * t));
    return fabs(remainder(angle - law, 2.0 * acos(-1.0)));
}

static void springs_along_a_shaft(void **state)
{
    (void)state;
    static const double tolerance = 1e-6, t = 0.37;
    loops s;
    shafts(&s, 0.0, 0.0);
    const loops_result rigid = loops_run(&s, tolerance, t);
    assert_int_equal(rigid.status, MBSR_OK);
    assert_less(off_the_law(&s, t), 30.0 * tolerance);
    loops_free(&s);
    for (int damped = 0; damped < 2; ++damped) {
        for (double k = 1e4; k < 2e14; k *= 100.0) {
            shafts(&s, k, damped ? 1e-4 : 0.0);
            const loops_result r = loops_run(&s, tolerance, t);
            assert_int_equal(r.status, MBSR_OK);
            if (k > 1e7) assert_in_range(r.steps, 0, 1.25 * (double)rigid.steps);
            assert_less(off_the_law(&s, t), 30.0 * tolerance + 4.0 / k);
            /* shared by equal springs: none of it along the shaft, but for rounding of gaps */
            const double force = test_largest(3, s.lambda);
            assert_less(0.1, force);
            if (k > 1e5)
                assert_close(cos(bend) * s.lambda[2] - sin(bend) * s.lambda[1], 0.0,
                             1e-3 * force + 3e-16 * k);
            loops_free(&s);
        }
    }
}

/* ---- a row that looks redundant and is not ---- */

/* q_a - q_b, but for a hump where q_a is between 1 and 2. */
static int humped_gap(const mbsr_closure_args *args, double *g)
{
    const double q = args->body[0].q[0], x = (q - 1.0) * (2.0 - q);
    g[0] = q - args->body[1].q[0] + (x > 0.0 ? x * x * x : 0.0);
    return 0;
}

/* Two wheels on one shaft are held together twice; the second time so that it is redundant at the
 * start and at the end, and not in between. */
static void opens_and_closes_between(void **state)
{
    (void)state;
    static const mbsr_closure_table humped = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                              .flags = MBSR_CLOSURE_JOINTS,
                                              .name = "humped",
                                              .position = humped_gap};
    loops s;
    mbsr_error error;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "b", MBSR_GROUND, 0.0, 0.0, 2.0, 1.0);
    const mbsr_closure_def together =
        mbsr_closure_coupling(2, (int[2]){a, b}, (int[2]){0, 0}, (double[2]){1.0, -1.0}, 0.0);
    mbsr_closure_def twice = mbsr_closure_custom(&humped, 2, (int[2]){a, b}, 1, 1, NULL);
    twice.name = "hump";
    assert_ok(mbsr_model_add_closure(s.m, &together, NULL), mbsr_model_error(s.m));
    assert_ok(mbsr_model_add_closure(s.m, &twice, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    s.u[0] = s.u[1] = 12.0;
    assert_int_equal(loops_try(&s, 1e-6, 0.25, &error).status, MBSR_LOOP_OPEN);
    assert_contains(error.text, "closure 1 'hump'|left out|at t = 0.1|mbsr_ida_advance");
    loops_free(&s);
}

/* Cranks in a row in one line, from where every loop may branch: run with all loops closed, or
 * refused for that. */
static void cranks_in_one_line(void **state)
{
    (void)state;
    for (int count = 2; count <= 8; count += 2) {
        loops s;
        double gap[16];
        loops_begin(&s, NULL);
        int crank = loops_rod(&s, NULL, MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
        s.u[0] = 1.0;
        for (int k = 1; k <= count; ++k) {
            const int rod = loops_rod(&s, NULL, crank, 1.0, 0.0, 1.0, 1.0);
            crank = loops_rod(&s, NULL, MBSR_GROUND, k, 0.0, 1.0, 1.0);
            loops_pin(&s, NULL, rod, 1.0, 0.0, crank, 1.0, 0.0);
            s.u[rod] = -1.0, s.u[crank] = 1.0;
        }
        loops_finish(&s);
        const loops_result r = loops_run(&s, 1e-6, 0.5);
        if (r.status == MBSR_OK) {
            assert_ok(mbsr_stage_positions(s.m, s.d, 0.5, s.q), NULL);
            assert_ok(mbsr_closures_gap(s.m, s.d, gap), NULL);
            for (int k = 0; k < 2 * count; ++k) assert_close(gap[k], 0.0, 1e-5);
        } else {
            assert_int_equal(r.status, MBSR_LOOP_SINGULAR);
        }
        loops_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(other_cuts),
                                       cmocka_unit_test(other_cuts_of_a_slider_crank),
                                       cmocka_unit_test(a_slotted_link),
                                       cmocka_unit_test(thirty_four_bars_pass_dead_centres),
                                       cmocka_unit_test(a_steady_disc),
                                       cmocka_unit_test(free_knees),
                                       cmocka_unit_test(a_long_run),
                                       cmocka_unit_test(bricard),
                                       cmocka_unit_test(cranks_in_one_line),
                                       cmocka_unit_test(springs_along_a_shaft),
                                       cmocka_unit_test(opens_and_closes_between)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
