/* Consistent starts of small models with closures: what balances is taken as it is, what does not
 * is named.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "body.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <string.h>

static const double tilt = 0.5;

static int turn(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 10.0 * t;
    *sdot = 10.0;
    *sddot = 0.0;
    return 0;
}

/* A driven shaft turns another by a universal joint, whose bearing has no mass: rows hold it
 * across, rubber keeps it from turning, with springs of 10 N m/rad and 0.1 N m s/rad. Lengths in
 * `unit` of a metre. */
static mbsr_model *shafts(double unit, double stiffness)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                 com[3] = {0.0}, square = unit * unit,
                 moments[6] = {0.03 * square, 0.03 * square, 0.05 * square},
                 place[3] = {0.0, -0.4 * unit * sin(tilt), 0.4 * unit * cos(tilt)},
                 rubber[6] = {10.0 * square, 10.0 * square, 10.0 * square},
                 loss[6] = {0.1 * square, 0.1 * square, 0.1 * square},
                 across[6] = {1.0, 0.0, 0.0, 0.0, cos(tilt), sin(tilt)};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const mbsr_frame on_shaft = mbsr_frame_at(0.0, 0.0, 0.4 * unit),
                     tilted = mbsr_frame_rotated(NULL, x, tilt),
                     on_ground = mbsr_frame_product(&tilted, &on_shaft);
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int a = test_add_body(
        m, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL), mbsr_inertia_zero());
    const int b = test_add_body(m, a, mbsr_joint_universal(NULL, NULL, x, y),
                                mbsr_inertia_rigid(4.0, com, moments));
    const int c = test_add_body(m, b, mbsr_joint_revolute(&on_shaft, NULL, z), mbsr_inertia_zero());
    const mbsr_force_def bushing =
        mbsr_force_bushing(MBSR_GROUND, &on_ground, c, NULL, rubber, loss);
    assert_ok(mbsr_model_add_force(m, &bushing, NULL), mbsr_model_error(m));
    mbsr_closure_def rows = mbsr_closure_rows(c, NULL, MBSR_GROUND, place, 2, across);
    for (int k = 0; k < 2 && stiffness > 0.0; ++k) {
        rows.stiffness[k] = stiffness;
        rows.damping[k] = 1e-5 * stiffness;
    }
    assert_ok(mbsr_model_add_closure(m, &rows, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* In steady rotation no force acts at all, but for rounding; the start is what was given. */
static void a_start_without_forces(void **state)
{
    (void)state;
    static const double units[] = {1.0, 1e3, 1e-3};
    for (int k = 0; k < 6; ++k) {
        mbsr_model *m = shafts(units[k / 2], k % 2 ? 1e8 : 0.0);
        mbsr_data *d = NULL;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        double q[3] = {tilt, 0.0, 0.0}, u[3] = {0.0, -10.0 * sin(tilt), -10.0 * cos(tilt)}, y[16],
               yp[16];
        assert_true(mbsr_dae_size(m, MBSR_DAE_MOMENTUM) <= 16);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        for (int l = 0; l < 3; ++l) {
            assert_close(y[l], q[l], 1e-12);
            assert_close(y[6 + l], u[l], 1e-9);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* Turned by 0.2 rad the rubber's spring asks for 20 rad/s more. */
static void a_start_whose_rate_is_found(void **state)
{
    (void)state;
    mbsr_model *m = shafts(1.0, 0.0);
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    double q[3] = {tilt, 0.0, 0.2}, u[3] = {0.0, -10.0 * sin(tilt), -10.0 * cos(tilt)}, y[16],
           yp[16];
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    assert_close(y[8], u[2] - 20.0, 1e-6);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static int hold(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t;
    *s = *sdot = *sddot = 0.0;
    return 0;
}

/* The connecting rod of a crank at rest: a beam with two normal modes and, of its end, static ones
 * without mass or damping, which a pin ties to the piston. */
static mbsr_model *crank_with_rod(const mbsr_flex *flex)
{
    static const double x[3] = {1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, none[3] = {0.0},
                        rows[6] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const mbsr_frame pin = mbsr_frame_at(0.15, 0.0, 0.0), start = mbsr_frame_at(0.45, 0.0, 0.0);
    mbsr_flexible_def rod = mbsr_default_flexible_def();
    mbsr_model *m = NULL;
    int body, end;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    rod.parent =
        test_add_body(m, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &axis, hold, NULL),
                      mbsr_inertia_box(0.4, (double[3]){0.2, 0.04, 0.02}));
    rod.flex = flex;
    rod.joint = mbsr_joint_revolute(&pin, NULL, z);
    assert_ok(mbsr_model_add_flexible(m, &rod, &body), mbsr_model_error(m));
    assert_ok(mbsr_model_add_marker(m, body, 16, "end", &end), mbsr_model_error(m));
    const int piston = test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(&start, NULL, x),
                                     mbsr_inertia_point_mass(0.08, none));
    const mbsr_closure_def closure = mbsr_closure_rows(end, NULL, piston, NULL, 2, rows);
    assert_ok(mbsr_model_add_closure(m, &closure, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* At rest, without weight, rounding is no damper: the stiffness of the modes determines them. */
static void a_start_at_rest_of_elastic_modes(void **state)
{
    (void)state;
    enum { MOST = 64 };
    static const int loaded = 16;
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex_def data;
    mbsr_flex *damped, *flex;
    double D[MOST], y[MOST] = {0.0}, yp[MOST];
    def.length = 0.3, def.density = 0.50368, def.EI_z = 68.27;
    def.elements = 16, def.modes = 2, def.damping = 0.02;
    def.loaded = 1, def.node = &loaded;
    assert_ok(mbsr_flex_beam(&def, &damped, NULL), NULL);
    mbsr_flex_definition(damped, &data);
    assert_true(data.modes > 2 && data.modes * data.modes <= MOST);
    memcpy(D, data.D, (size_t)(data.modes * data.modes) * sizeof *D);
    for (int k = def.modes; k < data.modes; ++k) D[k * (data.modes + 1)] = 0.0;
    data.D = D;
    assert_ok(mbsr_flex_create(&data, &flex, NULL), NULL);
    mbsr_model *m = crank_with_rod(flex);
    mbsr_data *d = NULL;
    mbsr_consistent_info info;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    assert_in_range(size, 1, MOST);
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info),
              mbsr_data_error(d));
    assert_int_equal(info.elastic, 1);
    assert_true(info.null_directions > 0);
    for (int k = 0; k < size; ++k) assert_close(yp[k], 0.0, 1e-9);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(damped);
}

/* A point mass slides away from where a rod holds it; the rod ends in its line, `arm` beside, on a
 * plate without mass that turns in a damper and a spring, theta about the mass. Of the balance
 *
 *   d theta' = k (rest - theta) - T arm (1 + arm / rod) theta
 *
 * all but the second order, with the tension T = m (g + arm (1 + arm / rod) theta'^2), theta'
 * follows at theta = 0, and theta'' from its rate. */
static void a_damper_beside_a_loaded_rod(void **state)
{
    (void)state;
    static const double mass = 2.0, g = 9.81, k = 3.0, damping = 0.7, rest = 0.4, arm = 0.3,
                        rod = 1.7;
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0};
    const double on_plate[3] = {arm, 0.0, 0.0}, on_ground[3] = {arm + rod, 0.0, 0.0},
                 center[2] = {0.0, 0.0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double y[16] = {0.0}, yp[16];
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int body = test_add_body(m, MBSR_GROUND, mbsr_joint_planar_pin_slot(origin, origin),
                                   mbsr_inertia_planar(mass, center, 0.0));
    const mbsr_force_def law = mbsr_force_joint_spring(body, 1, k, damping, rest),
                         weight = mbsr_force_gravity(-g, 0.0, 0.0);
    const mbsr_closure_def closure =
        mbsr_closure_distance(body, on_plate, MBSR_GROUND, on_ground, rod);
    assert_ok(mbsr_model_add_force(m, &law, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &weight, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_closure(m, &closure, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, 16);
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    const double speed = k * rest / damping, lever = arm * (1.0 + arm / rod),
                 tension = mass * (g + lever * speed * speed);
    assert_close(y[0], 0.0, 1e-14);
    assert_close(y[4], 0.0, 1e-12);
    assert_close(y[5], speed, 1e-10 * speed);
    assert_close(yp[4], lever * speed * speed, 1e-7);
    assert_close(yp[5], -(k + tension * lever) * speed / damping, 1e-6);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Springs of a closed mechanism at their rest lengths: what is left of forces is rounding, also at
 * a body that only loops act on. */
static void springs_at_rest_in_a_loop(void **state)
{
    (void)state;
    static const double first[3] = {1.0, 2.0, 2.0}, second[3] = {2.0, 3.0, 6.0},
                        third[3] = {3.0, 4.0, 0.0}, com[3] = {0.5, 0.0, -1.0},
                        com0[3] = {0.0, -0.4, 0.0}, origin[3] = {0.0, 0.0, 0.0},
                        moments[6] = {1.1e-3, 1.32e-3, 1.54e-3},
                        moments0[6] = {2.1e-4, 2.52e-4, 2.94e-4},
                        ends[2][2][3] = {{{0.0, 0.75, 0.75}, {-1.0, -0.4, 0.5}},
                                         {{0.0, -0.4, 0.5}, {0.5, 1.0, -0.4}}},
                        ball[2][3] = {{0.0, 0.75, 0.75}, {-1.75, 1.15, 0.15}},
                        rod[2][3] = {{0.5, 0.7, 1.0}, {-0.4, 0.0, 1.0}};
    mbsr_frame f = mbsr_frame_at(-1.0, 0.75, -1.0);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double y[64] = {0.75,
                    2.060753653048625,
                    -0.18131977440149025,
                    0.5,
                    1.0,
                    0.0,
                    0.0,
                    0.0,
                    1.0,
                    -0.4,
                    1.0,
                    0.5,
                    0.5,
                    0.5,
                    0.5,
                    1.0},
           given[16], yp[64];
    memcpy(given, y, sizeof given);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(&f, NULL, first),
                  mbsr_inertia_rigid(0.0021, com0, moments0));
    f = mbsr_frame_at(0.7, 0.0, 0.5);
    test_add_body(m, 0, mbsr_joint_revolute(&f, NULL, second), mbsr_inertia_zero());
    f = mbsr_frame_at(0.0, 0.5, -1.0);
    test_add_body(m, 1, mbsr_joint_cylindrical(&f, NULL, third),
                  mbsr_inertia_point_mass(39.5, origin));
    f = mbsr_frame_at(0.75, 0.0, -0.4);
    test_add_body(m, 2, mbsr_joint_free(&f, NULL), mbsr_inertia_zero());
    f = (mbsr_frame){.R = {0.6, 0.0, -0.8, 0.0, 1.0, 0.0, 0.8, 0.0, 0.6}, .x = {0.75, 0.5, 0.5}};
    test_add_body(m, 3, mbsr_joint_spherical(&f, NULL), mbsr_inertia_rigid(0.011, com, moments));
    f = (mbsr_frame){.R = {0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0}, .x = {0.0}};
    test_add_body(m, 4, mbsr_joint_prismatic(&f, NULL, third), mbsr_inertia_zero());
    const mbsr_force_def law[3] = {
        mbsr_force_point_spring(2, ends[0][0], 1, ends[0][1], 0.789, 0.0, 2.582408965592741),
        mbsr_force_point_spring(3, ends[1][0], 4, ends[1][1], 0.0188, 0.0, 2.126617031813674),
        mbsr_force_joint_spring(5, 0, 0.339, 0.0, 1.0)};
    const mbsr_closure_def loop[2] = {
        mbsr_closure_ball(2, ball[0], 3, ball[1]),
        mbsr_closure_distance(3, rod[0], 5, rod[1], 1.1191514642799696)};
    for (int k = 0; k < 3; ++k)
        assert_ok(mbsr_model_add_force(m, law + k, NULL), mbsr_model_error(m));
    for (int k = 0; k < 2; ++k)
        assert_ok(mbsr_model_add_closure(m, loop + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, 64);
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    for (int k = 0; k < 16; ++k) assert_close(y[k], given[k], 1e-12);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A mass of 2 kg hangs by a closure with a compliance of 1e-5 m/N, and takes a body without mass
 * along, which a spring of 3 N/m from 0.5 m pushes up. */
static void a_start_on_a_compliance(void **state)
{
    (void)state;
    static const double upright[3] = {0.0, 0.0, 1.0}, compliance[1] = {1e-5};
    const double at_rest = -compliance[0] * (2.0 * 9.81 - 1.5) / (1.0 + 3.0 * compliance[0]);
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double y[10] = {0.0}, yp[10];
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, upright),
                  mbsr_inertia_particle(2.0));
    test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, upright), mbsr_inertia_zero());
    const mbsr_force_def law[2] = {mbsr_force_gravity(0.0, 0.0, -9.81),
                                   mbsr_force_joint_spring(1, 0, 3.0, 0.0, 0.5)};
    mbsr_closure_def row[2] = {mbsr_closure_rows(0, NULL, 1, NULL, 1, upright),
                               mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 1, upright)};
    row[1].compliant = 1;
    row[1].compliance = compliance;
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_model_add_force(m, law + k, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_closure(m, row + k, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, 10);
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(d));
    for (int k = 0; k < 2; ++k) {
        assert_close(y[k], at_rest, 1e-14);
        assert_close(y[4 + k], 0.0, 1e-12);
        assert_close(yp[4 + k], 0.0, 1e-9);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_damper_beside_a_loaded_rod),
                                       cmocka_unit_test(springs_at_rest_in_a_loop),
                                       cmocka_unit_test(a_start_without_forces),
                                       cmocka_unit_test(a_start_whose_rate_is_found),
                                       cmocka_unit_test(a_start_at_rest_of_elastic_modes),
                                       cmocka_unit_test(a_start_on_a_compliance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
