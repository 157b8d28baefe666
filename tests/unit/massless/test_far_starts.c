/* Starts far from the balance of the forces, and what the report and the start say of states at
 * which a rank or a slope is lost.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "units.h"

#include <float.h>

enum { MOST = 4 };

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    double q[MOST], u[MOST]; /* before, and where a start succeeds behind it */
    double udot[MOST];
} scene;

static const mbsr_planar_frame origin = {0};

/* Carts in a row, each on the one before. */
static scene carts(int count, const double *mass)
{
    scene s = {0};
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), MBSR_OK);
    for (int k = 0; k < count; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_point(origin, MBSR_X, 0, NULL, NULL);
        body.inertia = mass[k] > 0.0 ? mbsr_inertia_particle(mass[k]) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    }
    return s;
}

static void force(scene *s, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
}

static void finish(scene *s)
{
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_int_equal(mbsr_data_create(s->model, &s->data, NULL), MBSR_OK);
}

static void drop(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static int start(scene *s)
{
    double y[3 * MOST], yp[3 * MOST];
    const int n = mbsr_model_nu(s->model);
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    assert_ok(mbsr_dae_pack(s->model, s->data, form, 0.0, s->q, s->u, y), mbsr_data_error(s->data));
    const int status = mbsr_dae_consistent(s->model, s->data, form, 0.0, y, yp, NULL, NULL);
    for (int k = 0; k < n && !status; ++k) {
        s->q[k] = y[k];
        s->u[k] = y[2 * n + k];
        s->udot[k] = yp[2 * n + k];
    }
    return status;
}

static mbsr_index_report *report(scene *s)
{
    mbsr_index_report *made;
    assert_ok(mbsr_index_report_create(s->model, s->data, 0.0, s->q, s->u, &made),
              mbsr_data_error(s->data));
    return made;
}

/* Spring 1 pulls with 1/2 where friction gives -u / sqrt(u^2 + slip^2): u = slip / sqrt 3. */
static void friction_holds_a_cart_that_slides_far_too_fast(void **state)
{
    (void)state;
    for (double speed = 1e-3; speed < 2e4; speed *= 10.0) {
        for (int sign = -1; sign <= 1; sign += 2) {
            scene s = carts(2, (double[]){0.0, 1.0});
            force(&s, mbsr_force_joint_friction(0, 0, 1.0, 0.01));
            force(&s, mbsr_force_joint_spring(1, 0, 1.0, 0.0, 0.0));
            finish(&s);
            s.q[1] = 0.5;
            s.u[0] = sign * speed;
            s.u[1] = -s.u[0]; /* the mass stands */
            assert_ok(start(&s), mbsr_data_error(s.data));
            assert_close(s.u[0], 0.01 / sqrt(3.0), 1e-12);
            assert_close(s.u[0] + s.u[1], 0.0, 1e-10);
            drop(&s);
        }
    }
}

static void friction_that_holds_less_than_the_load_is_no_balance(void **state)
{
    (void)state;
    scene s = carts(2, (double[]){0.0, 1.0});
    force(&s, mbsr_force_joint_friction(0, 0, 1.0, 0.01));
    force(&s, mbsr_force_joint_spring(1, 0, 1.0, 0.0, 0.0));
    finish(&s);
    s.q[1] = 1.5;
    assert_refused(start(&s), mbsr_data_error(s.data), MBSR_NO_CONVERGENCE, 0, MBSR_NONE,
                   "no velocity balances the forces|body 0");
    drop(&s);
}

static int push(void *user, double t, int n, double *value)
{
    (void)t;
    for (int k = 0; k < n; ++k) value[k] = *(const double *)user;
    return 0;
}

/* A motor of 1e5 N on a damper of 1 N s/m drives at 1e5 m/s, and the spring of 100 N/m behind takes
 * 100 times that in force a second: u' = -1e7 m/s^2. */
static void motor_on_a_weak_damper_in_all_units(void **state)
{
    (void)state;
    for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l) {
        const double length = systems[l].length, mass = systems[l].mass, time = systems[l].time;
        double newton = 1e5 * mass * length / (time * time);
        scene s = carts(2, (double[]){0.0, mass});
        force(&s, mbsr_force_joint_spring(0, 0, 0.0, mass / time, 0.0));
        force(&s, mbsr_force_joint_applied(0, push, &newton));
        force(&s, mbsr_force_joint_spring(1, 0, 100.0 * mass / (time * time), 0.0, 0.0));
        finish(&s);
        assert_ok(start(&s), mbsr_data_error(s.data));
        assert_close(s.u[0] / (1e5 * length / time), 1.0, 1e-12);
        assert_close(s.udot[0] / (-1e7 * length / (time * time)), 1.0, 1e-5);
        drop(&s);
    }
}

/* Each spring is relaxed in the end. */
static void relax(int seed, const units *in)
{
    test_rng rng = test_seed((uint64_t)seed);
    const double velocity = in->length / in->time;
    double stiffness[2], rest[2];
    scene s = carts(3, (double[]){0.0, 0.0, in->mass * pow(10.0, 3.0 * test_uniform(&rng))});
    const int absolute = seed % 2;
    for (int k = 0; k < 2; ++k) {
        stiffness[k] = pow(10.0, 6.0 * test_uniform(&rng)) * in->mass / (in->time * in->time);
        rest[k] = 0.1 * in->length * test_uniform(&rng);
        force(&s, absolute ? mbsr_force_axis_spring(k, k - 1, 0, stiffness[k], 0.0, rest[k])
                           : mbsr_force_joint_spring(k, 0, stiffness[k], 0.0, rest[k]));
    }
    finish(&s);
    for (int k = 0; k < 3; ++k) {
        s.q[k] = in->length * pow(10.0, 3.0 * test_uniform(&rng));
        s.u[k] = velocity * pow(10.0, 3.0 * test_uniform(&rng));
    }
    const double size = test_largest(3, s.q);
    assert_ok(start(&s), mbsr_data_error(s.data));
    for (int k = 0; k < 2; ++k) { /* rounding of the stiffer one's force moves the softer */
        const double ratio = fmax(1.0, stiffness[1 - k] / stiffness[k]);
        assert_close(s.q[k], rest[k], 1e3 * DBL_EPSILON * size * ratio);
    }
    for (int k = 0; k < 2; ++k) assert_close(s.u[k], 0.0, 1e-6 * fabs(s.u[2]) + 1e-9 * velocity);
    drop(&s);
}

static void soft_and_stiff_springs_far_from_rest(void **state)
{
    (void)state;
    for (int seed = 1; seed <= (test_long() ? 3000 : test_seeds(60, 600)); ++seed) {
        for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l) relax(seed, systems + l);
    }
}

/* tau = F - u^3 */
static int cube(const mbsr_force_args *args)
{
    const double u = args->body->u[0];
    args->body->tau[0] += args->force->param[0] - u * u * u;
    return 0;
}

static void damper_without_slope_at_rest(void **state)
{
    (void)state;
    static const mbsr_force_table table = {
        .version = MBSR_FORCE_TABLE_VERSION, .name = "cube", .evaluate = cube};
    static const double loads[] = {8.0, 1e-6, 1e6, 0.0};
    for (int k = 0; k < 4; ++k) {
        scene s = carts(1, (double[]){0.0});
        mbsr_force_def def = mbsr_force_custom(&table, 1, (const int[]){0}, NULL);
        def.param[0] = loads[k];
        force(&s, def);
        finish(&s);
        if (loads[k] > 0.0) {
            assert_ok(start(&s), mbsr_data_error(s.data));
            assert_close(s.u[0] / cbrt(loads[k]), 1.0, 1e-10);
        } else { /* any u near 0 would do to first order */
            assert_refused(start(&s), mbsr_data_error(s.data), MBSR_UNDETERMINED, 0, MBSR_NONE,
                           "neither a damper nor a spring|at this state");
        }
        drop(&s);
    }
}

/* The mass at the tip of two links in line: no acceleration along them. */
static void straight_links_name_the_body_and_the_state(void **state)
{
    (void)state;
    scene s = {0};
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), MBSR_OK);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.name = k ? "lower" : "upper";
        body.parent = k - 1;
        body.joint =
            mbsr_joint_planar_revolute((mbsr_planar_frame){k ? 1.0 : 0.0, 0.0, 0.0}, origin);
        body.inertia =
            k ? mbsr_inertia_planar(1.0, (double[2]){1.0, 0.0}, 0.0) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    }
    force(&s, mbsr_force_gravity(0.0, -9.81, 0.0));
    finish(&s);
    s.q[0] = -1.25;
    mbsr_index_report *made;
    assert_refused(mbsr_index_report_create(s.model, s.data, 0.0, s.q, s.u, &made),
                   mbsr_data_error(s.data), MBSR_RANK_CHANGED, 0, MBSR_NONE,
                   "body 0 'upper'|from 0 to 1 (of 1)|t = 0|q0 = -1.25");
    assert_refused(start(&s), mbsr_data_error(s.data), MBSR_RANK_CHANGED, 0, MBSR_NONE,
                   "body 0 'upper'|from 0 to 1 (of 1)|t = 0|q0 = -1.25");
    s.q[1] = 0.1;
    assert_ok(start(&s), mbsr_data_error(s.data));
    drop(&s);
}

/* Whether a direction is that of these joint rates and lists these elements alone. */
static void assert_direction(const mbsr_direction *d, mbsr_direction_kind kind, int a, int b,
                             int element)
{
    assert_int_equal(d->kind, kind);
    assert_int_equal(d->terms, 2);
    assert_int_equal(d->term[0].body, a);
    assert_int_equal(d->term[1].body, b);
    assert_close(d->term[0].weight + d->term[1].weight, 0.0, 1e-15);
    assert_int_equal(d->forces, element >= 0 ? 1 : 0);
    if (element >= 0) assert_int_equal(d->force[0], element);
}

/* Springs on the first and last joint, a damper on the last: it resists what moves the last cart
 * against the others, the first spring what moves the first. */
static void directions_are_few_rates_and_name_their_elements(void **state)
{
    (void)state;
    scene s = carts(4, (double[]){0.0, 0.0, 0.0, 1.0});
    force(&s, mbsr_force_joint_spring(0, 0, 1.0, 0.0, 0.0));
    force(&s, mbsr_force_joint_spring(3, 0, 1.0, 1.0, 0.0));
    finish(&s);
    mbsr_index_report *made = report(&s);
    assert_int_equal(made->dynamic, 1);
    assert_int_equal(made->directions, 3);
    assert_direction(made->direction, MBSR_DIRECTION_UNDETERMINED, 1, 2, -1);
    assert_direction(made->direction + 1, MBSR_DIRECTION_ELASTIC, 0, 2, 0);
    assert_direction(made->direction + 2, MBSR_DIRECTION_DAMPED, 2, 3, 1);
    mbsr_index_report_destroy(s.model, made);
    drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(friction_holds_a_cart_that_slides_far_too_fast),
        cmocka_unit_test(friction_that_holds_less_than_the_load_is_no_balance),
        cmocka_unit_test(motor_on_a_weak_damper_in_all_units),
        cmocka_unit_test(soft_and_stiff_springs_far_from_rest),
        cmocka_unit_test(damper_without_slope_at_rest),
        cmocka_unit_test(straight_links_name_the_body_and_the_state),
        cmocka_unit_test(directions_are_few_rates_and_name_their_elements),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
