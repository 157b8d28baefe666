/* The stock force elements: values by hand, gradients of their energies, balance of power, and
 * failures.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "model/query.h"
#include "recursion/data.h"

/* ---- a small tree: planar body 0 on the ground, planar body 1 on it, point 2 on body 1 ------- */

enum { NU = 8 };
static const int dims[3] = {3, 3, 2};

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
} scene;

/* Bodies with inertia; forces added by `add` (NULL ends the list). */
static scene make(const mbsr_force_def *forces, int count)
{
    const mbsr_planar_frame A = {0.3, -0.2, 0.4}, B = {-0.5, 0.1, 0.2};
    scene s;
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), 0);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k < 2 ? mbsr_joint_planar_free(A, B) : mbsr_joint_point_free();
        body.inertia = k < 2 ? mbsr_inertia_planar(2.0 + k, (const double[2]){0.3, -0.4 * k}, 0.5)
                             : mbsr_inertia_particle(1.5);
        assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    }
    for (int k = 0; k < count; ++k) {
        assert_ok(mbsr_model_add_force(s.model, forces + k, NULL), mbsr_model_error(s.model));
    }
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), 0);
    assert_int_equal(mbsr_model_nu(s.model), NU);
    return s;
}

static void drop(scene s)
{
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

static int evaluate(scene s, double t, const double *q, const double *u)
{
    assert_int_equal(mbsr_stage_positions(s.model, s.data, t, q), 0);
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, u), 0);
    return mbsr_stage_forces(s.model, s.data, NULL);
}

/* The elements' share of f of a body: without the gyroscopic force. */
static void force_on(scene s, int id, double *f)
{
    const mbsri_body *b = s.model->body + mbsri_index(s.model, id);
    for (int k = 0; k < b->d; ++k) f[k] = s.data->f[b->v + (size_t)k] + s.data->h[b->v + (size_t)k];
}

static double potential(scene s, const double *q)
{
    static const double zero[NU] = {0};
    double E = NAN;
    assert_int_equal(mbsr_stage_positions(s.model, s.data, 0.0, q), 0);
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, zero), 0);
    assert_int_equal(mbsr_energy(s.model, s.data, NULL, &E), 0);
    return E;
}

/* Generalised forces of the elements at rest (q, u): sum over bodies of (dV/du)^T f, plus tau. */
static void generalised(scene s, double t, const double *q, const double *u, double *Q)
{
    double f[3][3], V0[3][3];
    static const double none[NU] = {0};
    assert_int_equal(evaluate(s, t, q, u), 0);
    for (int id = 0; id < 3; ++id) force_on(s, id, f[id]);
    for (int c = 0; c < NU; ++c) Q[c] = s.data->tau[c];
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, none), 0);
    for (int id = 0; id < 3; ++id)
        assert_int_equal(mbsr_body_twist(s.model, s.data, id, V0[id]), 0);
    for (int c = 0; c < NU; ++c) {
        double unit[NU] = {0}, V[3];
        unit[c] = 1.0;
        assert_int_equal(mbsr_stage_velocities(s.model, s.data, unit), 0);
        for (int id = 0; id < 3; ++id) {
            assert_int_equal(mbsr_body_twist(s.model, s.data, id, V), 0);
            for (int k = 0; k < dims[id]; ++k) Q[c] += (V[k] - V0[id][k]) * f[id][k];
        }
    }
}

/* ---- the elements under test ----------------------------------------------------------------- */

enum { STOP = 10, ELEMENTS };

/* Every stock element with an energy; damping scaled by `damping`. */
static void elements(double damping, mbsr_force_def *list)
{
    static const double a[3] = {0.4, 0.7}, b[3] = {-0.6, 0.2}, o[3] = {0}, far[3] = {3.0, -2.0};
    list[0] = mbsr_force_gravity(0.8, -9.81, 0.0);
    list[1] = mbsr_force_axis_spring(0, MBSR_GROUND, 1, 40.0, 3.0 * damping, 0.3);
    list[2] = mbsr_force_axis_spring(MBSR_GROUND, 1, 2, 25.0, 2.0 * damping, -0.4);
    list[3] = mbsr_force_axis_spring(2, 0, 0, 15.0, 1.0 * damping, 0.1);
    list[4] = mbsr_force_point_spring(0, a, 1, b, 30.0, 4.0 * damping, 0.9);
    list[5] = mbsr_force_point_spring(2, o, 0, a, 20.0, 5.0 * damping, 1.1);
    list[6] = mbsr_force_point_spring(MBSR_GROUND, far, 1, b, 10.0, 6.0 * damping, 2.0);
    list[7] = mbsr_force_point_spring(1, a, 0, b, 12.0, 0.0, 0.0);
    list[8] = mbsr_force_joint_spring(1, 2, 18.0, 2.5 * damping, 0.6);
    list[9] = mbsr_force_joint_spring(2, 0, 22.0, 1.5 * damping, -0.6);
    list[STOP] = mbsr_force_joint_stop(1, 2, -0.2, 0.1, 22.0, 1.5 * damping);
}

static void forces_without_damping_are_minus_the_gradient_of_the_energy(void **state)
{
    (void)state;
    mbsr_force_def list[ELEMENTS];
    test_rng rng = test_seed(21);
    elements(0.0, list);
    for (int k = 0; k < ELEMENTS; ++k) {
        const scene s = make(list + k, 1);
        double most = 0.0;
        for (int round = 0; round < 5; ++round) {
            const double h = 1e-5;
            double q[NU], u[NU], Q[NU];
            test_fill(&rng, NU, q);
            test_fill(&rng, NU, u);
            generalised(s, 0.0, q, u, Q);
            most = fmax(most, test_largest(NU, Q));
            for (int c = 0; c < NU; ++c) {
                const double held = q[c];
                q[c] = held + h;
                const double ahead = potential(s, q);
                q[c] = held - h;
                const double behind = potential(s, q);
                q[c] = held;
                assert_close(Q[c], -(ahead - behind) / (2.0 * h), 1e-6);
            }
        }
        assert_less(1e-3, most);
        drop(s);
    }
}

/* Power of the damping alone = power with damping - power without: negative, what mbsr_dissipation
 * says, and 0 at rest. Together with the test above the sum of f.V and tau.u is -dE/dt -
 * dissipation. */
static void damping_takes_power_and_springs_return_their_energy(void **state)
{
    (void)state;
    mbsr_force_def damped[ELEMENTS], elastic[ELEMENTS];
    test_rng rng = test_seed(22);
    elements(1.0, damped);
    elements(0.0, elastic);
    for (int k = 0; k < ELEMENTS; ++k) {
        const scene s = make(damped + k, 1), e = make(elastic + k, 1);
        const int dissipates = damped[k].param[1] > 0.0 && k > 0;
        double most = 0.0;
        for (int round = 0; round < 10; ++round) {
            const double h = 1e-5;
            double q[NU], u[NU], moved[NU], power = 0.0, loss = 0.0, stated[2], V[3], f[3], fe[3];
            test_fill(&rng, NU, q);
            test_fill(&rng, NU, u);
            assert_int_equal(evaluate(s, 0.0, q, u), 0);
            assert_int_equal(evaluate(e, 0.0, q, u), 0);
            assert_int_equal(mbsr_dissipation(s.model, s.data, stated), 0);
            assert_int_equal(mbsr_dissipation(e.model, e.data, stated + 1), 0);
            for (int id = 0; id < 3; ++id) {
                force_on(s, id, f);
                force_on(e, id, fe);
                assert_int_equal(mbsr_body_twist(s.model, s.data, id, V), 0);
                for (int c = 0; c < dims[id]; ++c)
                    power += f[c] * V[c], loss += (fe[c] - f[c]) * V[c];
            }
            for (int c = 0; c < NU; ++c) {
                power += s.data->tau[c] * u[c];
                loss += (e.data->tau[c] - s.data->tau[c]) * u[c];
            }
            for (int c = 0; c < NU; ++c) moved[c] = q[c] + h * u[c];
            const double ahead = potential(s, moved);
            for (int c = 0; c < NU; ++c) moved[c] = q[c] - h * u[c];
            const double behind = potential(s, moved);
            assert_close(power, -(ahead - behind) / (2.0 * h) - loss, 1e-6);
            assert_close(stated[0], loss, 1e-12 * (1.0 + fabs(loss)));
            assert_close(stated[1], 0.0, 0.0);
            most = fmax(most, loss);
            if (dissipates && k < STOP) assert_less(0.0, loss);
        }
        assert_int_equal(most > 0.0, dissipates);
        drop(s);
        drop(e);
    }
}

/* Of one element and of all; the numbers are those of models with that element alone. */
static void energies_and_losses_of_elements_add_up(void **state)
{
    (void)state;
    mbsr_force_def list[ELEMENTS];
    test_rng rng = test_seed(24);
    double q[NU], u[NU], E, P, all[2], sum[2] = {0};
    elements(1.0, list);
    test_fill(&rng, NU, q);
    test_fill(&rng, NU, u);
    /* added in another order than that of the bodies they act on */
    mbsr_force_def turned[ELEMENTS];
    for (int k = 0; k < ELEMENTS; ++k) turned[k] = list[ELEMENTS - 1 - k];
    const scene s = make(turned, ELEMENTS);
    assert_int_equal(mbsr_stage_positions(s.model, s.data, 0.0, q), 0);
    assert_refused(mbsr_dissipation(s.model, s.data, &P), mbsr_data_error(s.data),
                   MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "mbsr_dissipation|mbsr_stage_velocities");
    assert_refused(mbsr_force_power(s.model, s.data, 0, &E, &P), mbsr_data_error(s.data),
                   MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "mbsr_force_power|mbsr_stage_velocities");
    assert_int_equal(mbsr_stage_velocities(s.model, s.data, u), 0);
    for (int k = 0; k < ELEMENTS; ++k) {
        const scene one = make(turned + k, 1);
        double alone[2];
        assert_int_equal(evaluate(one, 0.0, q, u), 0);
        assert_int_equal(mbsr_energy(one.model, one.data, NULL, alone), 0);
        assert_int_equal(mbsr_dissipation(one.model, one.data, alone + 1), 0);
        assert_int_equal(mbsr_force_power(s.model, s.data, k, &E, &P), 0);
        assert_close(E, alone[0], 0.0);
        assert_close(P, alone[1], 0.0);
        assert_int_equal(mbsr_force_power(s.model, s.data, k, NULL, NULL), 0);
        assert_int_equal(mbsr_force_power(s.model, s.data, k, &all[0], NULL), 0);
        assert_int_equal(mbsr_force_power(s.model, s.data, k, NULL, &all[1]), 0);
        assert_close(all[0], E, 0.0);
        assert_close(all[1], P, 0.0);
        sum[0] += E;
        sum[1] += P;
        drop(one);
    }
    assert_int_equal(mbsr_energy(s.model, s.data, NULL, all), 0);
    assert_int_equal(mbsr_dissipation(s.model, s.data, all + 1), 0);
    assert_close(all[0], sum[0], 1e-12 * fabs(sum[0]));
    assert_close(all[1], sum[1], 1e-12 * sum[1]);
    assert_less(1.0, sum[1]);
    for (int k = 0; k < 2; ++k) {
        assert_refused(mbsr_force_power(s.model, s.data, k ? -1 : ELEMENTS, &E, &P),
                       mbsr_data_error(s.data), MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                       k ? "no force -1" : "no force 11");
    }
    assert_int_equal(mbsr_dissipation(s.model, s.data, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_dissipation(NULL, s.data, &P), MBSR_ERR_NULL);
    assert_int_equal(mbsr_force_power(s.model, NULL, 0, &E, &P), MBSR_ERR_NULL);
    drop(s);
}

static void action_equals_reaction(void **state)
{
    (void)state;
    mbsr_force_def list[ELEMENTS];
    test_rng rng = test_seed(23);
    elements(1.0, list);
    static const int between[] = {3, 4, 5, 7}; /* elements between two bodies of the tree */
    for (int l = 0; l < 4; ++l) {
        const scene s = make(list + between[l], 1);
        for (int round = 0; round < 5; ++round) {
            double q[NU], u[NU], sum[2] = {0}, moment = 0.0;
            test_fill(&rng, NU, q);
            test_fill(&rng, NU, u);
            assert_int_equal(evaluate(s, 0.0, q, u), 0);
            for (int id = 0; id < 3; ++id) {
                double f[3], p[3];
                force_on(s, id, f);
                assert_int_equal(mbsr_body_pose(s.model, s.data, id, p), 0);
                sum[0] += f[0];
                sum[1] += f[1];
                moment += p[0] * f[1] - p[1] * f[0] + (dims[id] == 3 ? f[2] : 0.0);
            }
            assert_close(sum[0], 0.0, 1e-12);
            assert_close(sum[1], 0.0, 1e-12);
            /* an axis spring acts along a fixed direction, not along the line of the two bodies */
            if (between[l] != 3) assert_close(moment, 0.0, 1e-12);
        }
        drop(s);
    }
}

/* ---- values by hand -------------------------------------------------------------------------- */

static void springs_pull_as_calculated_by_hand(void **state)
{
    (void)state;
    const mbsr_planar_frame o = {0, 0, 0};
    const double point[3] = {0.0, 1.0}, origin[3] = {0},
                 q[5] = {2.0, 0.0, -1.5707963267948966, 0.5, 3.0};
    const double u[5] = {0.5, 0.0, 2.0, 0.0, -1.0};
    /* a planar body at (2, 0) turned by -90 degrees: its point (0, 1) is at (3, 0), moving with
     * (0.5, 2) */
    const mbsr_force_def list[] = {
        mbsr_force_point_spring(0, point, MBSR_GROUND, origin, 10.0, 4.0, 1.0),
        mbsr_force_axis_spring(0, MBSR_GROUND, 2, 100.0, 3.0, 0.0),
        mbsr_force_axis_spring(1, 0, 0, 7.0, 2.0, 0.25),
        mbsr_force_joint_spring(1, 1, 11.0, 5.0, 2.0),
    };
    mbsr_model *m;
    mbsr_data *d;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_planar_free(o, o);
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    body.joint = mbsr_joint_point_free();
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    for (int k = 0; k < 4; ++k) assert_int_equal(mbsr_model_add_force(m, list + k, NULL), 0);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    const scene s = {m, d};
    assert_int_equal(evaluate(s, 0.0, q, u), 0);
    double f[3], E;
    force_on(s, 0, f);
    /* along x: -(10 (3 - 1) + 4 * 0.5) = -22, from the other spring +7 (0.5 - 2 - 0.25) + 2 (0 -
     * 0.5) = -13.25 */
    assert_close(f[0], -22.0 - 13.25, 1e-13);
    assert_close(f[1], 0.0, 1e-13);
    /* moment: arm (1, 0) x (-22, 0) = 0; angle spring -(100 * (-pi/2) + 3 * 2) */
    assert_close(f[2], 50.0 * 3.141592653589793 - 6.0, 1e-12);
    force_on(s, 1, f);
    assert_close(f[0], 13.25, 1e-13);
    assert_close(f[1], 0.0, 1e-13);
    assert_close(d->tau[4], -(11.0 * 1.0 + 5.0 * -1.0), 1e-13);
    assert_close(d->tau[3], 0.0, 0.0);
    assert_int_equal(mbsr_energy(m, d, NULL, &E), 0);
    const double turn = 1.5707963267948966;
    assert_close(E, 0.5 * (10.0 * 4.0 + 100.0 * turn * turn + 7.0 * 1.75 * 1.75 + 11.0), 1e-12);
    drop(s);
}

static void gravity_acts_at_the_centre_of_mass(void **state)
{
    (void)state;
    const mbsr_planar_frame o = {0, 0, 0};
    const double com[2] = {0.5, 0.2}, q[7] = {1.0, 2.0, 0.7, 3.0, 4.0, 5.0, 6.0}, zero[7] = {0};
    const double cosine = cos(0.7), sine = sin(0.7);
    const double rx = cosine * 0.5 - sine * 0.2, ry = sine * 0.5 + cosine * 0.2;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def body = mbsr_default_body_def();
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    body.joint = mbsr_joint_planar_free(o, o);
    body.inertia = mbsr_inertia_planar(3.0, com, 0.4);
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(2.0);
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    body.inertia = mbsr_inertia_zero();
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    const mbsr_force_def gravity = mbsr_force_gravity(1.5, -9.0, 0.0);
    assert_int_equal(mbsr_model_add_force(m, &gravity, NULL), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    const scene s = {m, d};
    double f[3], E;
    assert_int_equal(evaluate(s, 0.0, q, zero), 0);
    force_on(s, 0, f);
    assert_close(f[0], 4.5, 1e-14);
    assert_close(f[1], -27.0, 1e-14);
    assert_close(f[2], 3.0 * (rx * -9.0 - ry * 1.5), 1e-13);
    force_on(s, 1, f);
    assert_close(f[0], 3.0, 0.0);
    assert_close(f[1], -18.0, 0.0);
    force_on(s, 2, f);
    assert_close(f[0], 0.0, 0.0);
    assert_close(f[1], 0.0, 0.0);
    assert_int_equal(mbsr_energy(m, d, NULL, &E), 0);
    assert_close(E, -3.0 * (1.5 * (1.0 + rx) - 9.0 * (2.0 + ry)) - 2.0 * (1.5 * 3.0 - 9.0 * 4.0),
                 1e-12);
    drop(s);
}

static int ramp(void *user, double t, int n, double *value)
{
    *(int *)user = n;
    for (int k = 0; k < n; ++k) {
        assert_close(value[k], 0.0, 0.0);
        value[k] = (k + 1) * t;
    }
    return 0;
}

static void applied_forces_follow_their_functions_and_add_up(void **state)
{
    (void)state;
    int d_seen = 0, n_seen = 0;
    const mbsr_force_def list[] = {mbsr_force_applied(0, ramp, &d_seen),
                                   mbsr_force_applied(0, ramp, &d_seen),
                                   mbsr_force_joint_applied(2, ramp, &n_seen)};
    const scene s = make(list, 3);
    const double q[NU] = {0};
    double f[3], tau[NU] = {0};
    assert_int_equal(evaluate(s, 0.25, q, q), 0);
    assert_int_equal(d_seen, 3);
    assert_int_equal(n_seen, 2);
    force_on(s, 0, f);
    for (int k = 0; k < 3; ++k) assert_close(f[k], 0.5 * (k + 1), 0.0);
    assert_close(s.data->tau[6], 0.25, 0.0);
    assert_close(s.data->tau[7], 0.5, 0.0);
    assert_close(s.data->tau[5], 0.0, 0.0);
    /* the caller's tau is added to that */
    tau[7] = 10.0;
    assert_int_equal(mbsr_stage_forces(s.model, s.data, tau), 0);
    assert_close(s.data->tau[7], 10.5, 0.0);
    assert_close(tau[7], 10.0, 0.0);
    drop(s);
}

static void held_forces_are_the_callers_numbers(void **state)
{
    (void)state;
    double held[3] = {1.0, -2.0, 3.0}, f[3];
    const double q[NU] = {0};
    const mbsr_force_def list[] = {mbsr_force_applied(0, mbsr_stored_force, held),
                                   mbsr_force_joint_applied(2, mbsr_stored_force, held)};
    const scene s = make(list, 2);
    for (int round = 0; round < 2; ++round) {
        assert_int_equal(evaluate(s, 0.25, q, q), 0);
        force_on(s, 0, f);
        for (int k = 0; k < 3; ++k) assert_close(f[k], held[k], 0.0);
        for (int k = 0; k < 2; ++k) assert_close(s.data->tau[6 + k], held[k], 0.0);
        held[1] = 7.0;
    }
    assert_int_equal(mbsr_stored_force(NULL, 0.0, 1, f), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stored_force(held, 0.0, 1, NULL), MBSR_ERR_NULL);
    drop(s);
}

/* ---- what elements see ----------------------------------------------------------------------- */

static int look(const mbsr_force_args *args)
{
    const mbsr_force_body *own = args->body, *ground = args->body + 1;
    assert_int_equal(args->bodies, 2);
    assert_close(args->t, 0.75, 0.0);
    assert_int_equal(own->id, 1);
    assert_int_equal(own->space, MBSR_SPACE_PLANAR);
    assert_true(own->d == 3 && own->n == 3 && own->nq == 3);
    assert_non_null(own->p);
    assert_close(own->q[1], 0.5, 0.0);
    assert_close(own->u[2], 0.25, 0.0);
    assert_close(own->M[0], 3.0, 0.0);
    assert_int_equal(ground->id, MBSR_GROUND);
    assert_int_equal(ground->space, MBSR_SPACE_FIXED);
    assert_true(ground->d == 0 && ground->n == 0);
    assert_true(!ground->M && !ground->q && !ground->u && !ground->tau);
    own->f[0] += 100.0;
    own->tau[2] += 200.0;
    ++*(int *)args->force->user;
    return 0;
}

static int look_dissipation(const mbsr_force_args *args, double *power)
{
    const mbsr_force_body *own = args->body;
    assert_true(!own->f && !own->tau && !args->body[1].f);
    assert_close(own->u[2], 0.25, 0.0);
    assert_non_null(own->V);
    assert_close(*power, 0.0, 0.0);
    *power = 5.0;
    return 0;
}

static int every_dissipation(const mbsr_force_args *args, double *power)
{
    assert_close(*power, 0.0, 0.0);
    *power = pow(10.0, args->body->id);
    return 0;
}

static int look_energy(const mbsr_force_args *args, double *energy)
{
    const mbsr_force_body *own = args->body;
    assert_close(*energy, 0.0, 0.0);
    assert_true(!own->V && !own->u && !own->f && !own->tau);
    assert_close(own->q[1], 0.5, 0.0);
    *energy = 3.0;
    return 0;
}

static int count_every(const mbsr_force_args *args)
{
    assert_int_equal(args->bodies, 1);
    *(int *)args->force->user += 1 << (4 * args->body->id);
    return 0;
}

static void custom_elements_see_their_bodies(void **state)
{
    (void)state;
    const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                    .name = "look",
                                    .evaluate = look,
                                    .energy = look_energy,
                                    .dissipation = look_dissipation};
    const mbsr_force_table every = {.version = MBSR_FORCE_TABLE_VERSION,
                                    .flags = MBSR_FORCE_EVERY_BODY,
                                    .name = "every",
                                    .evaluate = count_every,
                                    .dissipation = every_dissipation};
    int calls = 0, visits = 0;
    const mbsr_force_def list[] = {
        mbsr_force_custom(&table, 2, (const int[]){1, MBSR_GROUND}, &calls),
        mbsr_force_custom(&every, 0, NULL, &visits)};
    const scene s = make(list, 2);
    double q[NU] = {0}, u[NU] = {0}, E = 0.0, f[3];
    q[4] = 0.5;
    u[5] = 0.25;
    assert_int_equal(evaluate(s, 0.75, q, u), 0);
    assert_int_equal(calls, 1);
    assert_int_equal(visits, 0x111);
    force_on(s, 1, f);
    assert_close(f[0], 100.0, 0.0);
    assert_close(s.data->tau[5], 200.0, 0.0);
    assert_int_equal(mbsr_energy(s.model, s.data, NULL, &E), 0);
    assert_close(E, 3.0, 0.0);
    assert_int_equal(mbsr_dissipation(s.model, s.data, &E), 0);
    assert_close(E, 116.0, 0.0);
    assert_int_equal(mbsr_force_power(s.model, s.data, 1, f, &E), 0);
    assert_close(f[0], 0.0, 0.0);
    assert_close(E, 111.0, 0.0);
    drop(s);
}

/* ---- failures -------------------------------------------------------------------------------- */

static void a_point_spring_without_direction_says_so(void **state)
{
    (void)state;
    const double o[3] = {0}, q[NU] = {0}, u[NU] = {0};
    double pose[3], f[3];
    /* at q = 0 the point 2 lies on the origin of body 1 */
    mbsr_force_def spring = mbsr_force_point_spring(2, o, 1, o, 10.0, 0.0, 0.5);
    spring.name = "rope";
    for (int k = 0; k < 2; ++k) {
        scene s = make(&spring, 1);
        assert_int_equal(evaluate(s, 0.125, q, u), MBSR_DEGENERATE_FORCE);
        assert_true(MBSR_DEGENERATE_FORCE > 0);
        assert_refused(mbsr_stage_forces(s.model, s.data, NULL), mbsr_data_error(s.data),
                       MBSR_DEGENERATE_FORCE, MBSR_NONE, 0,
                       "force 0 'rope'|point spring-damper|t = 0.125");
        assert_int_equal(mbsr_stage_backward(s.model, s.data), MBSR_ERR_SEQUENCE);
        drop(s);
        /* the same with damping only */
        spring.param[1] = 1.0;
        spring.param[2] = 0.0;
    }
    /* neither free length nor damping: zero force, and defined */
    spring.param[1] = 0.0;
    scene s = make(&spring, 1);
    assert_int_equal(evaluate(s, 0.0, q, u), MBSR_OK);
    assert_int_equal(mbsr_body_pose(s.model, s.data, 2, pose), 0);
    force_on(s, 2, f);
    assert_close(f[0], 0.0, 1e-14);
    drop(s);
}

static int fail_with(const mbsr_force_args *args)
{
    return *(const int *)args->force->user;
}

static int fail_energy(const mbsr_force_args *args, double *energy)
{
    *energy = 0.0;
    return *(const int *)args->force->user;
}

static int fail_function(void *user, double t, int n, double *value)
{
    (void)t, (void)n, (void)value;
    return *(int *)user;
}

static void what_a_force_returns_is_passed_on_unchanged(void **state)
{
    (void)state;
    static const int codes[] = {17, -7};
    const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                    .name = "moody",
                                    .evaluate = fail_with,
                                    .energy = fail_energy,
                                    .dissipation = fail_energy};
    mbsr_force_table no_heat = table;
    no_heat.dissipation = NULL;
    const double x[NU] = {0.3, 0.4};
    double F[2 * NU], E;
    for (int k = 0; k < 2; ++k) {
        int code = 0;
        mbsr_force_def list[] = {mbsr_force_gravity(0, -1, 0.0),
                                 mbsr_force_custom(&table, 1, (const int[]){1}, &code),
                                 mbsr_force_applied(2, fail_function, &code)};
        list[1].name = "motor";
        const mbsr_force_def other = mbsr_force_custom(&no_heat, 1, (const int[]){1}, &code);
        const scene s = make(list, 2), applied = make(list + 2, 1), cold = make(&other, 1);
        assert_int_equal(evaluate(s, 0.5, x, x), 0);
        code = codes[k];
        const mbsr_error *e = mbsr_data_error(s.data);
        assert_refused(mbsr_energy(s.model, s.data, NULL, &E), e, code, MBSR_NONE, 1,
                       "force 1 'motor'|moody|energy");
        assert_refused(mbsr_dissipation(s.model, s.data, &E), e, code, MBSR_NONE, 1,
                       "force 1 'motor'|moody|dissipation|t = 0.5");
        assert_int_equal(mbsr_force_power(s.model, s.data, 1, &E, NULL), code);
        assert_int_equal(mbsr_force_power(s.model, s.data, 1, NULL, &E), code);
        assert_refused(mbsr_stage_forces(s.model, s.data, NULL), e, code, MBSR_NONE, 1,
                       "force 1 'motor'|moody|evaluate|t = 0.5");
        assert_int_equal(mbsr_forward_dynamics(s.model, s.data, 0.5, x, x, NULL, F), code);
        assert_int_equal(mbsr_inverse_dynamics(s.model, s.data, 0.5, x, x, x, NULL, F), code);
        double y[2 * NU] = {0.3, 0.4}, yp[2 * NU] = {0};
        assert_int_equal(mbsr_dae_residual(s.model, s.data, MBSR_DAE_RECURSIVE, 0.5, y, yp, F),
                         code);
        assert_int_equal(
            mbsr_dae_residual(s.model, s.data, MBSR_DAE_INVERSE_DYNAMICS, 0.5, y, yp, F), code);
        assert_int_equal(
            mbsr_dae_consistent(s.model, s.data, MBSR_DAE_RECURSIVE, 0.5, y, yp, NULL, NULL), code);
        assert_int_equal(mbsr_stage_positions(cold.model, cold.data, 0.5, x), 0);
        assert_int_equal(mbsr_stage_velocities(cold.model, cold.data, x), 0);
        assert_int_equal(mbsr_force_power(cold.model, cold.data, 0, &E, F), code);
        drop(cold);
        assert_refused(evaluate(applied, 0.5, x, x), mbsr_data_error(applied.data), code, MBSR_NONE,
                       0, "applied force");
        drop(s);
        drop(applied);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_without_damping_are_minus_the_gradient_of_the_energy),
        cmocka_unit_test(damping_takes_power_and_springs_return_their_energy),
        cmocka_unit_test(energies_and_losses_of_elements_add_up),
        cmocka_unit_test(action_equals_reaction),
        cmocka_unit_test(springs_pull_as_calculated_by_hand),
        cmocka_unit_test(gravity_acts_at_the_centre_of_mass),
        cmocka_unit_test(applied_forces_follow_their_functions_and_add_up),
        cmocka_unit_test(held_forces_are_the_callers_numbers),
        cmocka_unit_test(custom_elements_see_their_bodies),
        cmocka_unit_test(a_point_spring_without_direction_says_so),
        cmocka_unit_test(what_a_force_returns_is_passed_on_unchanged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
