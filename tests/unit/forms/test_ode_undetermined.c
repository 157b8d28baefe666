/* Velocities that nothing determines, or next to nothing, in the reduced ODE; in four systems of
 * units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <stdbool.h>

/* How many units of the model make 1 m, 1 kg, 1 s. */
typedef struct units {
    const char *name;
    double m, kg, s;
} units;

static const units systems[] = {{"m, kg, s", 1.0, 1.0, 1.0},
                                {"mm, t, s", 1e3, 1e-3, 1.0},
                                {"km, kg, s", 1e-3, 1.0, 1.0},
                                {"mm, g, ms", 1e3, 1e3, 1e3}};

enum { SYSTEMS = sizeof systems / sizeof systems[0], STATES = 1000, NQ = 5, NU = 4 };

/* About the axis of the rod: drive - (damping + quadratic |u|) u. */
typedef struct resistance {
    double drive, damping, quadratic;
} resistance;

static const double rod_end[3] = {0.3, 0.2, 0.1};

/* The axis of the rod along those of its predecessor, and the rate about it. */
static double axis_rate(const double *q, const double *u, double axis[3])
{
    const double length =
        sqrt(rod_end[0] * rod_end[0] + rod_end[1] * rod_end[1] + rod_end[2] * rod_end[2]);
    double R[9], rate = 0.0;
    mbsr_quaternion_rotation(q, R);
    for (int k = 0; k < 3; ++k) {
        axis[k] = (R[k] * rod_end[0] + R[3 + k] * rod_end[1] + R[6 + k] * rod_end[2]) / length;
        rate += axis[k] * u[k];
    }
    return rate;
}

static int resist(const mbsr_force_args *args)
{
    const resistance *law = args->force->user;
    const mbsr_force_body *rod = args->body;
    double axis[3];
    const double rate = axis_rate(rod->q, rod->u, axis),
                 torque = law->drive - (law->damping + law->quadratic * fabs(rate)) * rate;
    for (int k = 0; k < 3; ++k) rod->tau[k] += axis[k] * torque;
    return 0;
}

static const mbsr_force_table resistance_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "resistance", .evaluate = resist};

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    int rod, nq, nu;
} scene;

/* A rod of 1 kg that hangs on a ball: nothing turns it about its own axis. On the ground, or behind
 * a body on a revolute. */
static scene scene_make(units in, bool behind, resistance *law)
{
    scene s = {.rod = behind ? 1 : 0, .nq = behind ? 5 : 4, .nu = behind ? 4 : 3};
    const double torque = in.kg * in.m * in.m / (in.s * in.s);
    assert_ok(mbsr_model_create(NULL, &s.model, NULL), NULL);
    if (behind) {
        mbsr_body_def arm = mbsr_default_body_def();
        const double edges[3] = {0.1 * in.m, 0.2 * in.m, 0.4 * in.m};
        const mbsr_frame at = mbsr_frame_at(0.0, 0.1 * in.m, 0.2 * in.m);
        arm.name = "arm";
        arm.joint = mbsr_joint_revolute(NULL, NULL, (double[3]){0.0, 1.0, 0.0});
        arm.inertia = mbsr_inertia_in_frame(
            &at, mbsr_inertia_box(300.0 * in.kg / (in.m * in.m * in.m), edges));
        assert_ok(mbsr_model_add_body(s.model, &arm, NULL), mbsr_model_error(s.model));
    }
    mbsr_body_def rod = mbsr_default_body_def();
    const mbsr_frame ball = mbsr_frame_at(0.0, 0.2 * in.m, 0.4 * in.m);
    double end[3];
    for (int k = 0; k < 3; ++k) end[k] = rod_end[k] * in.m;
    rod.name = "rod";
    rod.parent = behind ? 0 : MBSR_GROUND;
    rod.joint = mbsr_joint_spherical(behind ? &ball : NULL, NULL);
    rod.inertia = mbsr_inertia_rod(in.kg, (double[3]){0.0, 0.0, 0.0}, end);
    assert_ok(mbsr_model_add_body(s.model, &rod, NULL), mbsr_model_error(s.model));
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81 * in.m / (in.s * in.s));
    assert_ok(mbsr_model_add_force(s.model, &gravity, NULL), mbsr_model_error(s.model));
    if (law) {
        mbsr_force_def force = mbsr_default_force_def();
        law->drive *= torque;
        law->damping *= torque * in.s;
        law->quadratic *= torque * in.s * in.s;
        force.table = &resistance_table;
        force.bodies = 1;
        force.body[0] = s.rod;
        force.user = law;
        assert_ok(mbsr_model_add_force(s.model, &force, NULL), mbsr_model_error(s.model));
    }
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_ok(mbsr_data_create(s.model, &s.data, NULL), NULL);
    return s;
}

static void scene_free(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static void random_state(const scene *s, units in, test_rng *rng, double *q, double *u)
{
    test_fill(rng, s->nq, q);
    test_fill(rng, s->nu, u);
    for (int k = 0; k < s->nu; ++k) u[k] *= 5.0 / in.s;
    assert_ok(mbsr_normalise(s->model, s->data, q), mbsr_data_error(s->data));
}

static void a_rod_that_nothing_turns_is_refused(void **unused)
{
    (void)unused;
    int counts[2][SYSTEMS][3] = {{{0}}}, wrong = 0;
    for (int behind = 0; behind < 2; ++behind) {
        for (int l = 0; l < SYSTEMS; ++l) {
            scene s = scene_make(systems[l], behind != 0, NULL);
            test_rng rng = test_seed(51);
            for (int state = 0; state < STATES; ++state) {
                double q[NQ], u[NU], x[NQ + NU], xdot[NQ + NU];
                mbsr_ode *ode;
                random_state(&s, systems[l], &rng, q, u);
                assert_ok(mbsr_ode_create(s.model, s.data, 0.0, q, u, &ode),
                          mbsr_data_error(s.data));
                assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(s.data));
                const int status = mbsr_ode_rhs(ode, 0.0, x, xdot);
                const mbsr_error *error = mbsr_data_error(s.data);
                ++counts[behind][l][status == MBSR_OK ? 0 : status == MBSR_UNDETERMINED ? 1 : 2];
                if (status != MBSR_UNDETERMINED || error->body != s.rod)
                    ++wrong;
                else
                    assert_contains(error->text, "'rod'");
                mbsr_ode_destroy(ode);
            }
            scene_free(&s);
        }
    }
    for (int behind = 0; behind < 2 && wrong; ++behind) {
        for (int l = 0; l < SYSTEMS; ++l)
            print_error("%s, %s: %d OK, %d undetermined, %d other\n", systems[l].name,
                        behind ? "behind a body" : "on the ground", counts[behind][l][0],
                        counts[behind][l][1], counts[behind][l][2]);
    }
    assert_int_equal(wrong, 0);
}

/* The rate about the axis is what it has to be, whatever Newton starts from; at_rest: from zero. */
static void axis_rate_is_found(resistance law, bool at_rest, double expected, double tolerance)
{
    for (int behind = 0; behind < 2; ++behind) {
        for (int l = 0; l < SYSTEMS; ++l) {
            resistance scaled = law;
            scene s = scene_make(systems[l], behind != 0, &scaled);
            test_rng rng = test_seed(52);
            for (int state = 0; state < STATES / 10; ++state) {
                double q[NQ], u[NU], x[NQ + NU], start[NU];
                mbsr_ode *ode;
                random_state(&s, systems[l], &rng, q, u);
                random_state(&s, systems[l], &rng, x, start);
                for (int k = 0; k < s.nu && at_rest; ++k) start[k] = 0.0;
                assert_ok(mbsr_ode_create(s.model, s.data, 0.0, q, u, &ode),
                          mbsr_data_error(s.data));
                assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(s.data));
                assert_ok(mbsr_ode_velocities(ode, 0.0, x, start), mbsr_data_error(s.data));
                double axis[3];
                const double rate = axis_rate(q + s.nq - 4, start + s.nu - 3, axis);
                assert_close(rate * systems[l].s, expected, tolerance);
                mbsr_ode_destroy(ode);
            }
            scene_free(&s);
        }
    }
}

/* The moments on the rod are of the size of 2 N m, at rates of 5 rad/s. */
static void weak_damping_is_damping(void **unused)
{
    (void)unused;
    axis_rate_is_found((resistance){.damping = 0.4}, false, 0.0, 1e-11);
    axis_rate_is_found((resistance){.damping = 0.4e-3}, false, 0.0, 1e-10);
    axis_rate_is_found((resistance){.damping = 0.4e-6}, false, 0.0, 1e-7);
}

/* Drag without a slope where Newton starts. */
static void quadratic_drag_is_damping(void **unused)
{
    (void)unused;
    axis_rate_is_found((resistance){.drive = 0.4, .quadratic = 0.1}, true, 2.0, 1e-10);
}

/* The sizes of forces that many links pass on grow as the forces do. A bead without mass, held by
 * dampers, and a chain of particles that all hang straight from it. */
static void a_long_chain_does_not_hide_a_damper(void **unused)
{
    (void)unused;
    static const int links[] = {1, 30, 100, 400};
    for (int k = 0; k < 4; ++k) {
        const int nu = links[k] + 2;
        mbsr_model *m;
        mbsr_data *d;
        mbsr_ode *ode;
        mbsr_index_report *report;
        double q[402] = {0.1, 0.2, 0.3}, u[402] = {0.0}, x[804], xdot[804];
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int id = 0; id <= links[k]; ++id) {
            mbsr_body_def body = mbsr_default_body_def();
            body.parent = id - 1;
            body.joint = id == 0 ? mbsr_joint_point_free()
                                 : mbsr_joint_planar_revolute((mbsr_planar_frame){0.0, 0.0, 0.0},
                                                              (mbsr_planar_frame){0.0, 1.0, 0.0});
            if (id > 0) body.inertia = mbsr_inertia_particle(1.0);
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        }
        const mbsr_force_def forces[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 100.0, 5.0, 0.0),
                                         mbsr_force_axis_spring(0, MBSR_GROUND, 1, 100.0, 5.0, 0.0),
                                         mbsr_force_gravity(0.0, -9.81, 0.0)};
        for (int l = 0; l < 3; ++l)
            assert_ok(mbsr_model_add_force(m, forces + l, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        for (int l = 0; l < nu; ++l) u[l] = 0.1 * sin(l + 1.0);
        assert_ok(mbsr_ode_create(m, d, 0.0, q, u, &ode), mbsr_data_error(d));
        assert_ok(mbsr_ode_pack(ode, 0.0, q, u, x), mbsr_data_error(d));
        assert_ok(mbsr_ode_rhs(ode, 0.0, x, xdot), mbsr_data_error(d));
        assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->damped, 1);
        assert_int_equal(report->directions, 1);
        mbsr_index_report_destroy(m, report);
        mbsr_ode_destroy(ode);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rod_that_nothing_turns_is_refused),
        cmocka_unit_test(weak_damping_is_damping),
        cmocka_unit_test(quadratic_drag_is_damping),
        cmocka_unit_test(a_long_chain_does_not_hide_a_damper),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
