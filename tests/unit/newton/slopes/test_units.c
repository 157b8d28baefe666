/* Joints, force elements and closures that leave derivatives to differences, in several systems of
 * units, against the same ones with derivatives of their own.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>

/* What a metre, a second and a kilogram are. */
typedef struct unit {
    const char *name;
    double m, s, kg;
} unit;

static const unit units[] = {{"m, s, kg", 1.0, 1.0, 1.0},
                             {"mm, s, t", 1e3, 1.0, 1e-3},
                             {"km, s, kg", 1e-3, 1.0, 1.0},
                             {"mm, ms, g", 1e3, 1e3, 1e3}};

enum { UNITS = 4, BODIES = 6, MOST = 16 };

/* ---- tables without derivatives ---- */

/* Copies whose functions the library does not know. */
typedef struct tables {
    mbsr_joint_table joint[BODIES];
    mbsr_force_table force[BODIES];
} tables;

static int position(const mbsr_joint_args *args, double *p)
{
    return mbsr_joint_weld(NULL, NULL).table->position(args, p);
}

static mbsr_joint bare_joint(mbsr_joint joint, mbsr_joint_table *table)
{
    *table = *joint.table;
    table->position = position;
    table->rates = NULL;
    table->tangent = NULL;
    table->rate_tangent = NULL;
    joint.table = table;
    return joint;
}

static mbsr_force_def bare_force(mbsr_force_def def, double time, mbsr_force_table *table)
{
    *table = *def.table;
    table->derivatives = NULL;
    table->scales.time = time;
    def.table = table;
    return def;
}

/* ---- a tree of joints of one and of several axes, with and without masses ---- */

typedef struct scene {
    tables own;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    int nq, nu;
    double q[MOST], u[MOST], y[3 * MOST], yp[3 * MOST];
} scene;

static void add_bodies(scene *s, const unit *by, bool bare)
{
    static const double axis[3] = {0.3, 0.4, 0.9}, x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    const double L = by->m, density = 500.0 * by->kg / (L * L * L);
    for (int i = 0; i < BODIES; ++i) {
        const double edges[3] = {0.3 * L, 0.5 * L, 0.4 * L};
        mbsr_frame A = mbsr_frame_rotated(NULL, x, 0.4 * i);
        A.x[0] = 0.4 * L, A.x[1] = 0.1 * L * i, A.x[2] = -0.2 * L;
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = i == 0 ? MBSR_GROUND : i == 4 ? 1 : i - 1;
        switch (i) {
        case 0: def.joint = mbsr_joint_prismatic(&A, NULL, axis); break;
        case 1: def.joint = mbsr_joint_cylindrical(&A, NULL, x); break;
        case 3: def.joint = mbsr_joint_universal(&A, NULL, x, y); break;
        default: def.joint = mbsr_joint_revolute(&A, NULL, axis); break;
        }
        if (bare && i != 2) def.joint = bare_joint(def.joint, s->own.joint + i);
        def.inertia = i == 4 ? mbsr_inertia_zero() : mbsr_inertia_box(density, edges);
        assert_ok(mbsr_model_add_body(s->model, &def, NULL), mbsr_model_error(s->model));
    }
}

static void add_forces(scene *s, const unit *by, bool bare, double time, bool gravity)
{
    const double L = by->m, N = by->kg * L / (by->s * by->s), at[3] = {0.1 * L, -0.2 * L, 0.3 * L};
    const mbsr_spring cubic = {.stiffness = 80.0 * N / L,
                               .cubic = 30.0 * N / (L * L * L),
                               .damping = 5.0 * N * by->s / L,
                               .free_length = 0.2 * L};
    const mbsr_force_def forces[] = {
        mbsr_force_spring(3, at, 0, NULL, &cubic),
        mbsr_force_spring(4, NULL, 5, at, &cubic),
        mbsr_force_joint_friction(0, 0, 4.0 * N, 0.3 * L / by->s),
        mbsr_force_joint_friction(4, 0, 2.0 * N * L, 0.4 / by->s),
        mbsr_force_joint_cubic_spring(1, 1, 60.0 * N / L, 90.0 * N / (L * L * L),
                                      3.0 * N * by->s / L, 0.05 * L),
    };
    for (int k = 0; k < 5; ++k) {
        const mbsr_force_def def = bare ? bare_force(forces[k], time, s->own.force + k) : forces[k];
        assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
    }
    const mbsr_force_def weight =
        mbsr_force_gravity(2.0 * L / (by->s * by->s), 0.0, -9.0 * L / (by->s * by->s));
    if (gravity) assert_ok(mbsr_model_add_force(s->model, &weight, NULL), NULL);
}

/* Size of coordinate k of all: the length for translations. */
static double size_of(const unit *by, int k)
{
    return k == 0 || k == 2 ? by->m : 1.0; /* body 0, and the second of body 1 */
}

static void make(scene *s, const unit *by, bool bare, bool gravity, bool moving)
{
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &s->model, &error), &error);
    add_bodies(s, by, bare);
    /* at rest and without weight nothing tells over which velocities friction changes */
    add_forces(s, by, bare, gravity || moving ? 0.0 : by->s, gravity);
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    assert_in_range(s->nu, 1, MOST);
    assert_int_equal(s->nq, s->nu);
    for (int k = 0; k < s->nu; ++k) {
        s->q[k] = (0.3 + 0.2 * sin(k)) * size_of(by, k);
        s->u[k] = moving ? (0.7 * cos(k) - 0.2) * size_of(by, k) / by->s : 0.0;
    }
    assert_ok(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y),
              mbsr_data_error(s->data));
    for (int k = s->nu; k < 2 * s->nu; ++k) s->y[k] *= 1.0 + 0.1 * sin(k); /* somewhat beside it */
    for (int k = 0; k < 3 * s->nu; ++k) {
        const double rate = (0.4 + 0.3 * sin(2.0 * k)) * size_of(by, k % s->nu) / by->s;
        s->yp[k] = k < s->nu ? s->u[k] : moving ? rate / by->s : 0.0;
    }
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &s->newton, &error), &error);
}

static void release(scene *s)
{
    mbsr_newton_destroy(s->newton);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* F, or the Newton direction of a right-hand side whose numbers count alike in all units. */
static void residual(scene *s, double *F)
{
    assert_ok(mbsr_dae_residual(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, F),
              mbsr_data_error(s->data));
}

static void direction(scene *s, const unit *by, double *delta)
{
    double r[3 * MOST];
    for (int k = 0; k < 3 * s->nu; ++k) {
        const double x = cos(3.0 * k), L = size_of(by, k % s->nu), p = by->kg * by->m * by->m / L;
        r[k] = k < s->nu ? x * L / by->s : k < 2 * s->nu ? x * p / (by->s * by->s) : x * p / by->s;
    }
    assert_ok(mbsr_newton_factor(s->newton, s->data, 0.0, s->y, s->yp, 100.0 / by->s),
              mbsr_newton_error(s->newton));
    assert_ok(mbsr_newton_solve(s->newton, r, delta), mbsr_newton_error(s->newton));
}

/* Fails where a differs from b by more than the tolerance: three blocks, numbers divided by what
 * size_of makes of them (momenta: multiplied). */
static void compare(const scene *s, const unit *by, const char *what, const double *a,
                    const double *b, bool first_is_momentum, double tolerance)
{
    for (int block = 0; block < 3; ++block) {
        const bool momentum = block == 1 || (block == 2 && first_is_momentum);
        double largest = 0.0, off = 0.0;
        for (int k = 0; k < s->nu; ++k) {
            const double L = size_of(by, k), size = momentum ? 1.0 / L : L;
            largest = fmax(largest, fabs(b[block * s->nu + k]) / size);
            off = fmax(off, fabs(a[block * s->nu + k] - b[block * s->nu + k]) / size);
        }
        if (!(off <= tolerance * largest))
            print_error("%s in %s, block %d: off by %.2e of %.2e\n", what, by->name, block, off,
                        largest);
        assert_true(off <= tolerance * largest);
    }
}

static void try(const unit *by, bool gravity, bool moving)
{
    scene own, bare;
    double a[3 * MOST], b[3 * MOST];
    make(&own, by, false, gravity, moving);
    make(&bare, by, true, gravity, moving);
    residual(&own, a);
    residual(&bare, b);
    compare(&own, by, "residual", b, a, true, 1e-10);
    direction(&own, by, a);
    direction(&bare, by, b);
    compare(&own, by, "direction", b, a, false, 1e-8);
    release(&own);
    release(&bare);
}

static void rates_and_newton_directions(void **state)
{
    (void)state;
    for (int k = 0; k < UNITS; ++k) {
        for (int how = 0; how < 4; ++how) try(units + k, how & 1, how & 2);
    }
}

/* ---- springs with a law by function ---- */

/* A damper of 5 N that saturates at some 0.3 m/s; user: the unit. */
static int saturating(void *user, double x, double v, double *force, double *energy, double *power)
{
    const unit *by = user;
    const double N = by->kg * by->m / (by->s * by->s);
    (void)x;
    (void)energy;
    *force = 5.0 * N * tanh(v / (0.3 * by->m / by->s));
    if (power) *power = *force * v;
    return MBSR_OK;
}

/* A box on a slide with such a damper to the ground: u' of the Newton direction beside the true
 * one. */
static double error_of_spring(unit by)
{
    const double L = by.m, axis[3] = {1.0, 0.0, 0.0}, edges[3] = {0.2 * L, 0.2 * L, 0.2 * L},
                 density = 1000.0 * by.kg / (L * L * L), mass = density * 0.008 * L * L * L,
                 u = 0.15 * L / by.s, c = 10.0 / by.s;
    const mbsr_spring law = {.function = saturating, .user = &by};
    const double q = 0.7 * L, y[3] = {q, mass * u, u}, yp[3] = {u, 0.0, 0.0},
                 r[3] = {0.0, 1.0, 0.0};
    const mbsr_force_def spring = mbsr_force_spring(0, NULL, MBSR_GROUND, NULL, &law),
                         weight = mbsr_force_gravity(0.0, 0.0, -9.81 * L / (by.s * by.s));
    mbsr_model *m;
    mbsr_data *d;
    mbsr_newton *newton;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_prismatic(NULL, NULL, axis);
    def.inertia = mbsr_inertia_box(density, edges);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &weight, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), NULL);
    double delta[3];
    assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, c), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
    const double slope = (1.0 - tanh(0.5) * tanh(0.5)) * 5.0 * by.kg / by.s / 0.3,
                 truth = 1.0 / (mass * c + slope);
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return fabs(fabs(delta[2] / truth) - 1.0);
}

static void laws_of_springs_by_function(void **state)
{
    (void)state;
    for (int k = 0; k < UNITS; ++k) assert_less(error_of_spring(units[k]), 1e-9);
}

/* ---- stated scales ---- */

/* tau = -sin(q / a) - tanh(u / b), which change over less than the library expects. */
static const double a = 1e-5, b = 1e-4;

static int fine_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    body->tau[0] -= sin(body->q[0] / a) + tanh(body->u[0] / b);
    return MBSR_OK;
}

/* u' of the Newton direction beside that of the law's own slopes. */
static double error_of(mbsr_scales scales, double q, double u)
{
    const mbsr_force_table fine = {.version = MBSR_FORCE_TABLE_VERSION,
                                   .name = "fine",
                                   .evaluate = fine_evaluate,
                                   .scales = scales};
    const double edges[3] = {0.2, 0.2, 0.2}, axis[3] = {0.0, 0.0, 1.0}, c = 10.0,
                 mass = 1000.0 * 0.008;
    const int body = 0;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_newton *newton;
    mbsr_error error;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_prismatic(NULL, NULL, axis);
    def.inertia = mbsr_inertia_box(1000.0, edges);
    const mbsr_force_def law = mbsr_force_custom(&fine, 1, &body, NULL);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &law, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, &error), &error);
    const double y[3] = {q, mass * u, u}, yp[3] = {u, 0.0, 0.0}, r[3] = {0.0, 1.0, 0.0};
    double delta[3];
    assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, c), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
    /* m c du + tau' du + tau_q du / c = +-1 */
    const double slope = 1.0 - tanh(u / b) * tanh(u / b),
                 truth = 1.0 / (mass * c + slope / b + cos(q / a) / (a * c));
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return fabs(fabs(delta[2] / truth) - 1.0);
}

static void a_table_states_its_scales(void **state)
{
    (void)state;
    const mbsr_scales none = {0.0, 0.0, 0.0, 0.0}, own = {.length = a, .time = a / b};
    assert_less(error_of(own, 0.3 * a, 0.4 * b), 1e-9);
    assert_true(error_of(none, 0.3 * a, 0.4 * b) > 1e-6);
}

static void scales_that_are_none_are_refused(void **state)
{
    (void)state;
    mbsr_model *m;
    const int bodies[2] = {0, MBSR_GROUND};
    mbsr_joint_table joint = *mbsr_joint_weld(NULL, NULL).table;
    mbsr_force_table force = *mbsr_force_gravity(0.0, 0.0, 1.0).table;
    mbsr_closure_table closure = *mbsr_closure_ball(0, NULL, MBSR_GROUND, NULL).table;
    joint.scales.length = -1.0;
    force.scales.time = INFINITY;
    closure.scales.other = NAN;
    mbsr_body_def def = mbsr_default_body_def();
    def.name = "arm";
    def.joint = mbsr_joint_weld(NULL, NULL);
    def.joint.table = &joint;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_refused(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m), MBSR_ERR_VALUE, 0,
                   MBSR_NONE, "arm|table.scales.length is -1");
    const mbsr_force_def law = mbsr_force_custom(&force, 0, NULL, NULL);
    assert_refused(mbsr_model_add_force(m, &law, NULL), mbsr_model_error(m), MBSR_ERR_VALUE,
                   MBSR_NONE, 0, "table.scales.time is inf");
    const mbsr_closure_def loop = mbsr_closure_custom(&closure, 2, bodies, 3, 3, NULL);
    assert_refused(mbsr_model_add_closure(m, &loop, NULL), mbsr_model_error(m), MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "table.scales.other is nan");
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rates_and_newton_directions),
                                       cmocka_unit_test(laws_of_springs_by_function),
                                       cmocka_unit_test(a_table_states_its_scales),
                                       cmocka_unit_test(scales_that_are_none_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
