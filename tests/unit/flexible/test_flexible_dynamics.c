/* Flexible bodies in trees: states with published digits of an independent program (dense, in
 * another language), and relations that any such body obeys.
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "flexible.h"

#include "expect.h"
#include "newton_system.h"

#include <string.h>

static void assert_all_close(int n, const double *x, const double *expected, double tolerance)
{
    for (int k = 0; k < n; ++k)
        assert_close(x[k], expected[k], tolerance * fmax(1.0, fabs(expected[k])));
}

static const mbsr_error *error_of(const test_flexible *w)
{
    return mbsr_data_error(w->data);
}

/* The state up to its velocities. */
static void place(const test_flexible *w)
{
    assert_ok(mbsr_stage_positions(w->model, w->data, 0.0, w->q), error_of(w));
    assert_ok(mbsr_stage_velocities(w->model, w->data, w->u), error_of(w));
}

static void accelerate(const test_flexible *w, double *udot)
{
    assert_ok(mbsr_forward_dynamics(w->model, w->data, 0.0, w->q, w->u, NULL, udot), error_of(w));
}

static void assert_energies(const test_flexible *w, double kinetic, double potential)
{
    double T, U;
    place(w);
    assert_ok(mbsr_energy(w->model, w->data, &T, &U), error_of(w));
    assert_close(T, kinetic, 1e-13);
    assert_close(U, potential, 1e-13);
}

/* ---- digits ---- */

static void a_pendulum_that_bends(void **state)
{
    (void)state;
    static const double udot[3] = {1717.730878496629, -5583.461517677348, 4092.827801551222},
                        momenta[3] = {0.418360952380953, 0.316666666666668, 0.254761904761906},
                        tip[2] = {0.952381287058993, 0.305073571552596};
    test_flexible w;
    double x[3], pose[12];
    test_flexible_pendulum(&w, 100.0, 0);
    accelerate(&w, x);
    assert_all_close(3, x, udot, 1e-11);
    assert_energies(&w, 0.2628709523809528, 1.5085759926668796);
    assert_ok(mbsr_momenta(w.model, w.data, x), error_of(&w));
    assert_all_close(3, x, momenta, 1e-13);
    assert_ok(mbsr_body_pose(w.model, w.data, w.tip, pose), error_of(&w));
    assert_all_close(2, pose + MBSR_POSE_X, tip, 1e-14);
    test_flexible_free(&w);
}

static const double tree_udot[8] = {46.137571568370703, -82.720325987585795, -10.910216137952448,
                                    27.408890818675275, 4.603535908704208,   -23.802744355488695,
                                    -9.714116931326512, -6.157363220931480},
                    tree_momenta[8] = {1.615828913639696, 1.303209036887395,  -0.195435136047308,
                                       1.064265218841453, -0.022707237419761, 0.050293863098154,
                                       0.103426312651952, -0.055688568784442},
                    tree_rates[8] = {-1.417903529797994, -3.218635967668367, -7.181330282463900,
                                     -3.635291581913473, -4.782737836468331, -3.612918026093213,
                                     -5.283472613823678, -7.082037677483859};

static void two_beams_in_space(void **state)
{
    (void)state;
    static const double diagonal[8] = {
        1.264117729571194, 0.878695624825009, 1.076026292335585, 1.403494078210479,
        0.454632343520832, 0.594646164918942, 0.530007687606734, 0.7};
    static const double tip[3] = {0.893801710041279, 0.453892611888852, -0.03},
                        twist[6] = {-0.057227753727654, 0.194275233836167, 2.299540671133268,
                                    -0.648601783043178, 1.354332207042722, -0.1},
                        last[3] = {0.268929851648062, 0.311816945312443, -0.315218627643909},
                        momentum[6] = {0.064837915779073,  0.200417213307797, 1.615828913639696,
                                       -1.037087285959587, 1.778717479613317, -0.096993677930108};
    for (int reversed = 0; reversed < 2; ++reversed) {
        test_flexible w;
        double x[8], matrix[64], pose[12], V[6];
        test_flexible_tree(&w, reversed, 0);
        accelerate(&w, x);
        assert_all_close(8, x, tree_udot, 1e-12);
        assert_energies(&w, 1.1309548082989649, -2.6807316797418625);
        assert_ok(mbsr_momenta(w.model, w.data, x), error_of(&w));
        assert_all_close(8, x, tree_momenta, 1e-13);
        assert_ok(mbsr_mass_matrix(w.model, w.data, matrix), error_of(&w));
        for (int k = 0; k < 8; ++k) assert_close(matrix[9 * k], diagonal[k], 1e-13);
        assert_ok(mbsr_body_pose(w.model, w.data, w.tip, pose), error_of(&w));
        assert_all_close(3, pose + MBSR_POSE_X, tip, 1e-14);
        assert_ok(mbsr_body_twist(w.model, w.data, w.tip, V), error_of(&w));
        assert_all_close(6, V, twist, 1e-14);
        assert_ok(mbsr_body_pose(w.model, w.data, w.last, pose), error_of(&w));
        assert_all_close(3, pose + MBSR_POSE_X, last, 1e-14);
        double mass;
        assert_ok(mbsr_tree_momentum(w.model, w.data, NULL, &mass, NULL, V), error_of(&w));
        assert_close(mass, 1.7 + 0.8 + 0.7, 1e-14);
        assert_all_close(6, V, momentum, 1e-13);
        test_flexible_free(&w);
    }
}

/* p' of the momentum form: F of its rows of p is p' - rates there. */
static void momenta_change_without_differences(void **state)
{
    (void)state;
    test_flexible w;
    double y[24], yp[24] = {0.0}, F[24];
    test_flexible_tree(&w, 0, 0);
    assert_ok(mbsr_dae_pack(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, w.q, w.u, y), error_of(&w));
    assert_all_close(8, y + 8, tree_momenta, 1e-13);
    assert_ok(mbsr_dae_residual(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error_of(&w));
    for (int k = 0; k < 8; ++k) assert_close(fabs(F[8 + k]), fabs(tree_rates[k]), 1e-12);
    test_flexible_free(&w);
}

/* ---- massless modes ---- */

static void a_massless_mode_is_a_direction_of_its_own(void **state)
{
    (void)state;
    static const double udot[4] = {80.250961200417350, -134.664419022288143, 6.65, 0.0};
    test_flexible w;
    double x[4];
    test_flexible_massless(&w);
    mbsr_rank_info mount, joint;
    assert_int_equal(mbsr_forward_dynamics(w.model, w.data, 0.0, w.q, w.u, NULL, x),
                     MBSR_UNDETERMINED);
    assert_all_close(4, x, udot, 1e-12);
    assert_ok(mbsr_body_rank(w.model, w.data, w.flexible[0], &mount), error_of(&w));
    assert_ok(mbsr_body_rank(w.model, w.data, w.flexible[0] - 1, &joint), error_of(&w));
    assert_int_equal(mount.rank, 2);
    assert_int_equal(mount.n, 3);
    assert_int_equal(joint.rank, 1);

    double y[12], yp[12] = {0.0};
    mbsr_consistent_info start;
    assert_ok(mbsr_dae_pack(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, w.q, w.u, y), error_of(&w));
    assert_ok(mbsr_dae_consistent(w.model, w.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &start),
              error_of(&w));
    assert_int_equal(start.null_directions, 1);
    assert_close(y[11], -7.206193184913, 1e-11);
    test_flexible_free(&w);
}

static void the_index_report_names_the_mode(void **state)
{
    (void)state;
    test_flexible w;
    test_flexible_massless(&w);
    mbsr_index_report *report;
    assert_ok(mbsr_index_report_create(w.model, w.data, 0.0, w.q, w.u, &report), error_of(&w));
    assert_int_equal(report->damped, 1);
    assert_int_equal(report->index, 1);
    assert_int_equal(report->directions, 1);
    assert_int_equal(report->direction[0].terms, 1);
    assert_int_equal(report->direction[0].term[0].body, w.flexible[0]);
    assert_int_equal(report->direction[0].term[0].coordinate, 2);
    assert_int_equal(report->direction[0].forces, 1);
    assert_int_equal(report->direction[0].force[0], 0);
    mbsr_index_report_destroy(w.model, report);
    test_flexible_free(&w);
}

/* ---- relations ---- */

static mbsr_flex *rigid_data(double mass, const double com[3], const double tensor[6])
{
    mbsr_flex_def def = mbsr_default_flex_def();
    const mbsr_flex_marker root = {.frame = mbsr_frame_identity()};
    const double half = 0.5 * (tensor[0] + tensor[1] + tensor[2]);
    const double I[9] = {tensor[0], tensor[3], tensor[4], tensor[3], tensor[1],
                         tensor[5], tensor[4], tensor[5], tensor[2]};
    mbsr_flex *flex;
    mbsr_error error;
    def.mass = mass;
    for (int j = 0; j < 3; ++j) {
        def.c0[j] = mass * com[j];
        for (int k = 0; k < 3; ++k)
            def.N0[3 * j + k] = (j == k ? half : 0.0) - I[3 * j + k] + mass * com[j] * com[k];
    }
    def.markers = 1, def.marker = &root;
    assert_ok(mbsr_flex_create(&def, &flex, &error), &error);
    return flex;
}

/* A body without modes on a free joint, and the rigid body of its numbers. */
static void without_modes_it_is_a_rigid_body(void **state)
{
    (void)state;
    static const double com[3] = {0.1, -0.2, 0.3}, tensor[6] = {0.8, 0.9, 1.1, 0.05, -0.02, 0.1};
    double udot[2][6], q[7], u[6], energy[2][2];
    test_rng rng = test_seed(3);
    mbsr_flex *flex = rigid_data(2.5, com, tensor);
    test_fill(&rng, 7, q);
    test_fill(&rng, 6, u);
    for (int k = 0; k < 2; ++k) {
        mbsr_model *m;
        mbsr_data *d;
        mbsr_body_def body = mbsr_default_body_def();
        mbsr_flexible_def flexible = mbsr_default_flexible_def();
        mbsr_force_def g = mbsr_force_gravity(1.0, -2.0, 9.0);
        body.joint = flexible.joint = mbsr_joint_free(NULL, NULL);
        body.inertia = mbsr_inertia_rigid(2.5, com, tensor);
        flexible.flex = flex;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        assert_ok(k ? mbsr_model_add_flexible(m, &flexible, NULL)
                    : mbsr_model_add_body(m, &body, NULL),
                  mbsr_model_error(m));
        assert_ok(mbsr_model_add_force(m, &g, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot[k]), mbsr_data_error(d));
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
        assert_ok(mbsr_energy(m, d, energy[k], energy[k] + 1), mbsr_data_error(d));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_all_close(6, udot[1], udot[0], 1e-14);
    assert_all_close(2, energy[1], energy[0], 1e-14);
    mbsr_flex_destroy(flex);
}

/* dE/dt = -dissipation + power of the load, by differences of the energy along q', u'. */
static void energy_changes_by_what_is_dissipated(void **state)
{
    (void)state;
    const double h = 1e-4;
    test_flexible w;
    double udot[8], E[4], T, U, power, tip[6] = {0.0};
    test_flexible_tree(&w, 0, 0);
    const test_flexible at = w;
    accelerate(&w, udot);
    place(&w);
    assert_ok(mbsr_dissipation(w.model, w.data, &power), error_of(&w));
    /* the load's: on the middle of the first beam */
    assert_ok(mbsr_body_twist(w.model, w.data, mbsr_model_bodies(w.model) - 1, tip), error_of(&w));
    static const double load[6] = {0.1, 0.2, -0.3, 1.0, -2.0, 0.5};
    double work = -power;
    for (int k = 0; k < 6; ++k) work += load[k] * tip[k];
    static const double step[4] = {-2.0, -1.0, 1.0, 2.0};
    for (int l = 0; l < 4; ++l) {
        const double s = step[l] * h;
        for (int k = 0; k < 8; ++k) {
            w.q[k] = at.q[k] + s * at.u[k] + 0.5 * s * s * udot[k];
            w.u[k] = at.u[k] + s * udot[k];
        }
        place(&w);
        assert_ok(mbsr_energy(w.model, w.data, &T, &U), error_of(&w));
        E[l] = T + U;
    }
    const double rate = (E[0] - 8.0 * E[1] + 8.0 * E[2] - E[3]) / (12.0 * h);
    assert_close(rate, work, 1e-8 * fabs(work) + 1e-8);
    test_flexible_free(&w);
}

/* Inverse dynamics of the accelerations found gives no joint forces; the reaction at the root
 * carries the weight and d(momentum)/dt. */
static void inverse_dynamics_agree(void **state)
{
    (void)state;
    test_flexible w;
    double udot[8], tau[8];
    test_flexible_tree(&w, 1, 0);
    accelerate(&w, udot);
    assert_ok(mbsr_inverse_dynamics(w.model, w.data, 0.0, w.q, w.u, udot, NULL, tau), error_of(&w));
    for (int k = 0; k < 8; ++k) assert_close(tau[k], 0.0, 1e-12);
    test_flexible_free(&w);
}

static void jacobians_are_those_of_the_twists(void **state)
{
    (void)state;
    test_flexible w;
    double J[9 * 8], V[9], sum[9] = {0.0};
    test_flexible_tree(&w, 0, 0);
    place(&w);
    assert_ok(mbsr_body_jacobian(w.model, w.data, w.flexible[0], J), error_of(&w));
    assert_ok(mbsr_body_twist(w.model, w.data, w.flexible[0], V), error_of(&w));
    for (int k = 0; k < 8; ++k) {
        for (int r = 0; r < 9; ++r) sum[r] += J[9 * k + r] * w.u[k];
    }
    assert_all_close(9, sum, V, 1e-14);
    assert_close(V[6], w.u[1], 0.0);
    test_flexible_free(&w);
}

/* ---- Newton systems ---- */

static void newton_systems(const test_flexible *w)
{
    test_newton_state s;
    mbsr_newton *newton;
    mbsr_error error;
    double r[32], x[32];
    test_rng rng = test_seed(9);
    assert_ok(test_newton_start(&s, w->model, w->data, 0.0, w->q, w->u, NULL), error_of(w));
    assert_ok(test_newton_matrices(&s, w->model, w->data), error_of(w));
    assert_ok(mbsr_newton_create(w->model, MBSR_DAE_MOMENTUM, NULL, &newton, &error), &error);
    test_fill(&rng, s.n, r);
    for (int k = 0; k < 3; ++k) {
        const double c = (double[3]){1.0, 30.0, 1e4}[k];
        assert_ok(mbsr_newton_factor(newton, s.data, s.t, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
        const test_newton_errors e = test_newton_compare(&s, c, r, x);
        assert_less(e.row, 1e-8);
        assert_less(e.net_row, 1e-9);
    }
    mbsr_newton_destroy(newton);
    test_newton_free(&s);
}

static void the_newton_solver_serves_flexible_bodies(void **state)
{
    (void)state;
    test_flexible w;
    test_flexible_pendulum(&w, 100.0, 0);
    newton_systems(&w);
    test_flexible_free(&w);
    test_flexible_tree(&w, 0, 0);
    newton_systems(&w);
    test_flexible_free(&w);
    test_flexible_massless(&w);
    newton_systems(&w);
    test_flexible_free(&w);
}

/* A beam on a hinge with a load at its end, one or two of its modes held: its J has then other
 * rows than -1 in it. */
static void modes_may_be_locked(void **state)
{
    (void)state;
    static const double axis[3] = {0.0, 0.0, 1.0}, zero[3] = {0.0};
    for (int locks = 1; locks <= 2; ++locks) {
        test_flexible w = {0};
        double udot[5], tau[5];
        mbsr_error error;
        mbsr_beam_def beam = mbsr_default_beam_def();
        beam.length = beam.density = 1.0, beam.EI_y = 70.0, beam.EI_z = 50.0, beam.modes = 4;
        assert_ok(mbsr_flex_beam(&beam, w.flex, &error), &error);
        assert_ok(mbsr_model_create(NULL, &w.model, NULL), NULL);
        mbsr_flexible_def def = mbsr_default_flexible_def();
        def.parent = MBSR_GROUND, def.flex = w.flex[0];
        def.joint = mbsr_joint_revolute(NULL, NULL, axis);
        const mbsr_error *e = mbsr_model_error(w.model);
        assert_ok(mbsr_model_add_flexible(w.model, &def, w.flexible), e);
        assert_ok(mbsr_model_add_marker(w.model, w.flexible[0], 15, NULL, &w.tip), e);
        const mbsr_force_def force =
            mbsr_force_point_spring(w.tip, NULL, MBSR_GROUND, zero, 10.0, 0.5, 0.3);
        assert_ok(mbsr_model_add_force(w.model, &force, NULL), e);
        assert_ok(mbsr_model_lock(w.model, w.flexible[0], 1, 0.02), e);
        if (locks == 2) assert_ok(mbsr_model_lock(w.model, w.flexible[0], 2, 0.0), e);
        assert_ok(mbsr_model_finish(w.model), e);
        assert_ok(mbsr_data_create(w.model, &w.data, NULL), NULL);
        const int nu = mbsr_model_nu(w.model);
        assert_int_equal(nu, 5 - locks);
        for (int k = 0; k < nu; ++k) w.q[k] = 0.03 * (k + 1), w.u[k] = 0.5 - 0.2 * k;
        accelerate(&w, udot);
        assert_ok(mbsr_inverse_dynamics(w.model, w.data, 0.0, w.q, w.u, udot, NULL, tau),
                  error_of(&w));
        for (int k = 0; k < nu; ++k) assert_close(tau[k], 0.0, 1e-11);
        newton_systems(&w);
        test_flexible_free(&w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pendulum_that_bends),
        cmocka_unit_test(two_beams_in_space),
        cmocka_unit_test(momenta_change_without_differences),
        cmocka_unit_test(a_massless_mode_is_a_direction_of_its_own),
        cmocka_unit_test(the_index_report_names_the_mode),
        cmocka_unit_test(without_modes_it_is_a_rigid_body),
        cmocka_unit_test(energy_changes_by_what_is_dissipated),
        cmocka_unit_test(inverse_dynamics_agree),
        cmocka_unit_test(jacobians_are_those_of_the_twists),
        cmocka_unit_test(the_newton_solver_serves_flexible_bodies),
        cmocka_unit_test(modes_may_be_locked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
