/* Joints that lack some of their rank, and groups of joints in one piece: they cost what they cost
 * themselves, and their projections are the same in whatever way the tree is evaluated.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "kernels.h"

#include "assembly/data.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>

enum { HINGES = 12, MOST = 24, SIZE = 4 * MOST };

typedef enum end {
    POINT_ON_BALL,
    REGULAR_GROUP,
    ROD_ON_SLIDERS,
    ROTOR_ON_SLIDERS,
    ROD_ON_FREE_PAIR,
    ENDS
} end;

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, size;
    double q[MOST], u[MOST], y[SIZE], yp[SIZE];
} scene;

static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};

/* Lengths, masses and times in other units than SI. */
typedef struct units {
    double m, kg, s;
} units;

static void damp(mbsr_model *m, int body, double damping)
{
    const mbsr_force_def damper = mbsr_force_joint_spring(body, 0, 0.0, damping, 0.0);
    assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
}

/* Two sliders, what the second one carries, and a rod that turns on it. */
static int add_sliders(mbsr_model *m, int base, mbsr_inertia carried, units by)
{
    const double end_of_rod[3] = {0.0, 0.6 * by.m, 0.0}, force = by.kg / by.s;
    const int first =
                  test_add_body(m, base, mbsr_joint_prismatic(NULL, NULL, y), mbsr_inertia_zero()),
              second = test_add_body(m, first, mbsr_joint_prismatic(NULL, NULL, z), carried),
              rod = test_add_body(m, second, mbsr_joint_revolute(NULL, NULL, x),
                                  mbsr_inertia_point_mass(2.0 * by.kg, end_of_rod));
    damp(m, first, 3.0 * force);
    damp(m, second, 2.0 * force);
    damp(m, rod, 0.1 * force * by.m * by.m);
    return rod;
}

/* A hinge without mass before one of the same axis, which takes all inertia from it; then bodies
 * without mass on a universal joint and a hinge, one group that is regular, and what they carry. */
static void add_group(mbsr_model *m, int base, mbsr_inertia body, units by)
{
    const mbsr_frame A = mbsr_frame_at(0.3 * by.m, 0.0, 0.1 * by.m);
    const int free = test_add_body(m, base, mbsr_joint_revolute(&A, NULL, z), mbsr_inertia_zero()),
              turned = test_add_body(m, free, mbsr_joint_revolute(NULL, NULL, z), body),
              cross = test_add_body(m, turned, mbsr_joint_universal(&A, NULL, x, y),
                                    mbsr_inertia_zero()),
              last =
                  test_add_body(m, cross, mbsr_joint_revolute(NULL, NULL, z), mbsr_inertia_zero());
    test_add_body(m, last, mbsr_joint_weld(&A, NULL), body);
    damp(m, free, 2.0 * by.kg * by.m * by.m / by.s);
}

/* A chain of hinges with something without full rank at its end. */
static void make_chain(scene *s, int hinges, end what, units by)
{
    const double com[3] = {0.1 * by.m, 0.2 * by.m, 0.3 * by.m}, moment = by.kg * by.m * by.m,
                 tensor[6] = {0.1 * moment, 0.1 * moment, 0.1 * moment, 0.0, 0.0, 0.0},
                 around[6] = {0.05 * moment, 0.05 * moment, 0.05 * moment, 0.0, 0.0, 0.0},
                 none[3] = {0.0, 0.0, 0.0}, damping = by.kg * by.m * by.m / by.s,
                 turning[3] = {damping, damping, damping};
    const mbsr_frame A = mbsr_frame_at(0.3 * by.m, 0.0, 0.1 * by.m);
    int last = MBSR_GROUND;
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int i = 0; i < hinges; ++i) {
        last = test_add_body(s->model, last, mbsr_joint_revolute(&A, NULL, i % 2 ? y : z),
                             mbsr_inertia_rigid(by.kg, com, tensor));
    }
    if (what == POINT_ON_BALL) {
        const double at[3] = {0.0, 0.6 * by.m, 0.1 * by.m};
        const int ball = test_add_body(s->model, last, mbsr_joint_spherical(&A, NULL),
                                       mbsr_inertia_point_mass(by.kg, at));
        const mbsr_force_def damper = mbsr_force_joint_rotation_spring(ball, none, turning, NULL);
        assert_ok(mbsr_model_add_force(s->model, &damper, NULL), mbsr_model_error(s->model));
    } else if (what == REGULAR_GROUP) {
        add_group(s->model, last, mbsr_inertia_rigid(by.kg, com, tensor), by);
    } else if (what == ROD_ON_FREE_PAIR) {
        /* the rod carries another one, behind which it is deep */
        const mbsr_frame seat = mbsr_frame_at(0.0, 0.6 * by.m, 0.0);
        const int rod = add_sliders(s->model, last, mbsr_inertia_zero(), by);
        test_add_body(s->model, rod, mbsr_joint_revolute(&seat, NULL, x),
                      mbsr_inertia_point_mass(by.kg, seat.x));
    } else {
        const mbsr_inertia rotor = mbsr_inertia_rigid(0.0, none, around);
        add_sliders(s->model, last, what == ROTOR_ON_SLIDERS ? rotor : mbsr_inertia_zero(), by);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * by.m / (by.s * by.s), 0.0);
    assert_ok(mbsr_model_add_force(s->model, &gravity, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    s->size = mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
}

static void make(scene *s, end what, units by)
{
    make_chain(s, HINGES, what, by);
}

static void destroy(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* A state; momenta that do not belong to it, and rates. */
static void draw(scene *s, test_rng *rng)
{
    test_fill(rng, s->nq, s->q);
    test_fill(rng, s->nu, s->u);
    test_fill(rng, s->size, s->yp);
    assert_ok(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y),
              mbsr_data_error(s->data));
    for (int k = 0; k < s->nu; ++k) s->y[s->nq + k] += 0.1 * test_uniform(rng);
}

static void residual(scene *s, double *F)
{
    mbsri_data_poison(s->data);
    assert_ok(mbsr_dae_residual(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, F),
              mbsr_data_error(s->data));
}

static void by_newton(scene *s, int by_blocks, const double *r, double *delta)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton_info info;
    mbsr_newton *newton;
    opt.by_blocks = by_blocks;
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    assert_ok(mbsr_newton_factor(newton, s->data, 0.0, s->y, s->yp, 30.0),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
    assert_int_equal(mbsr_newton_get_info(newton, &info), MBSR_OK);
    assert_int_equal(info.vector_code, !by_blocks);
    mbsr_newton_destroy(newton);
}

static const units si = {1.0, 1.0, 1.0};

static void residuals_are_those_of_the_stages(void **state)
{
    (void)state;
    test_rng rng = test_seed(3);
    for (int what = 0; what < ENDS; ++what) {
        scene s;
        make(&s, (end)what, si);
        for (int turn = 0; turn < 20; ++turn) {
            double F[SIZE], expected[SIZE];
            draw(&s, &rng);
            const test_hidden trees = test_hide_sweeps(s.model);
            residual(&s, expected);
            test_show_sweeps(s.model, trees);
            residual(&s, F);
            assert_true(s.data->stage == MBSRI_STAGE_NONE); /* the sweeps served */
            assert_less(test_relative_distance(s.size, F, expected), 1e-11);
        }
        destroy(&s);
    }
}

static void newton_systems_are_those_of_the_blocks(void **state)
{
    (void)state;
    test_rng rng = test_seed(4);
    for (int what = 0; what < ENDS; ++what) {
        scene s;
        make(&s, (end)what, si);
        for (int turn = 0; turn < 20; ++turn) {
            double r[SIZE], delta[SIZE], expected[SIZE];
            draw(&s, &rng);
            test_fill(&rng, s.size, r);
            by_newton(&s, 0, r, delta);
            by_newton(&s, 1, r, expected);
            assert_less(test_relative_distance(s.size, delta, expected), 1e-8);
        }
        destroy(&s);
    }
}

/* u' of those rates that have inertia, with the others as small as can be, in the measure of s. */
static void units_do_not_matter(void **state)
{
    (void)state;
    const units other[3] = {{1e3, 1e-3, 1.0}, {1e-3, 1.0, 1.0}, {1e3, 1e3, 1e3}};
    for (int what = 0; what < ENDS; ++what) {
        scene s;
        double udot[MOST], expected[MOST];
        test_rng rng = test_seed(5);
        make(&s, (end)what, si);
        draw(&s, &rng);
        assert_int_equal(mbsr_forward_dynamics(s.model, s.data, 0.0, s.q, s.u, NULL, expected),
                         MBSR_UNDETERMINED);
        for (int k = 0; k < 3; ++k) {
            scene in = s;
            make(&in, (end)what, other[k]);
            for (int l = 0; l < s.nu; ++l) {
                const bool length = what >= ROD_ON_SLIDERS && (l == HINGES || l == HINGES + 1);
                in.u[l] *= (length ? other[k].m : 1.0) / other[k].s;
                if (length) in.q[l] *= other[k].m;
            }
            assert_int_equal(mbsr_forward_dynamics(in.model, in.data, 0.0, in.q, in.u, NULL, udot),
                             MBSR_UNDETERMINED);
            for (int l = 0; l < s.nu; ++l) {
                const bool length = what >= ROD_ON_SLIDERS && (l == HINGES || l == HINGES + 1);
                udot[l] *= other[k].s * other[k].s / (length ? other[k].m : 1.0);
            }
            assert_less(test_relative_distance(s.nu, udot, expected), 1e-9);
            destroy(&in);
        }
        destroy(&s);
    }
}

/* A body in vector code takes no more of lean data where bodies of another kind are in the tree
 * than the loads on it need; those others take what they need themselves. */
static void lean_data_stays_lean(void **state)
{
    (void)state;
    for (int what = 0; what < ENDS; ++what) {
        scene s[2];
        mbsr_data *lean;
        double udot[2][MOST];
        for (int k = 0; k < 2; ++k) make_chain(&s[k], 1000 * (k + 1), (end)what, si);
        const size_t bytes = mbsr_data_size_lean(s[1].model) - mbsr_data_size_lean(s[0].model);
        assert_true(bytes <= 1000 * 600);
        for (int k = 0; k < 2; ++k) destroy(&s[k]);
        test_rng rng = test_seed(6);
        make(&s[0], (end)what, si);
        draw(&s[0], &rng);
        assert_ok(mbsr_data_create_lean(s[0].model, &lean, NULL), NULL);
        for (int k = 0; k < 2; ++k)
            assert_int_equal(mbsr_forward_dynamics(s[0].model, k ? lean : s[0].data, 0.0, s[0].q,
                                                   s[0].u, NULL, udot[k]),
                             MBSR_UNDETERMINED);
        assert_memory_equal(udot[0], udot[1], (size_t)s[0].nu * sizeof(double));
        mbsr_data_destroy(lean);
        destroy(&s[0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(residuals_are_those_of_the_stages),
        cmocka_unit_test(newton_systems_are_those_of_the_blocks),
        cmocka_unit_test(units_do_not_matter),
        cmocka_unit_test(lean_data_stays_lean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
