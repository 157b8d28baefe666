/* Elements on one joint coordinate, which the sweeps evaluate law by law in arrays: against the
 * stages, which call them one by one, with joints of one and several axes, held coordinates,
 * several elements on a coordinate, and some of them off.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "kernels.h"

#include <stdlib.h>

enum { BODIES = 6, FORCES = 60, MOST = 12, MOMENTUM = 3 * MOST };

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, forces;
    double q[MOST], u[MOST], x[MOST];
} scene;

static mbsr_force_def random_element(test_rng *rng, int body, int coordinate)
{
    const double a = test_uniform(rng), b = 1.0 + test_uniform(rng), c = 1.0 + test_uniform(rng);
    const mbsr_servo servo = {.kp = b, .kd = c, .reference = a};
    switch (test_integer(rng, 0, 4)) {
    case 0: return mbsr_force_joint_spring(body, coordinate, 10.0 * b, c, a);
    case 1: return mbsr_force_joint_cubic_spring(body, coordinate, b, 5.0 * c, b, a);
    case 2: return mbsr_force_joint_stop(body, coordinate, a - 0.5, a, 100.0 * b, c);
    case 3: return mbsr_force_joint_friction(body, coordinate, b, 0.1 + c);
    default: return mbsr_force_joint_servo(body, coordinate, &servo);
    }
}

/* A branched tree; body 3 has one of its three coordinates held. */
static void make(scene *s, uint64_t seed)
{
    static const int parent[BODIES] = {MBSR_GROUND, 0, 1, 1, 3, 0},
                     free_axes[BODIES] = {1, 2, 1, 2, 1, 3};
    const double com[3] = {0.1, 0.2, 0.3}, tensor[6] = {0.5, 0.6, 0.4, 0.02, 0.01, -0.03};
    const mbsr_frame at = mbsr_frame_at(0.3, -0.2, 0.4);
    const double z[3] = {0.3, 0.1, 1.0}, x[3] = {1.0, 0.2, 0.0};
    const mbsr_joint joint[BODIES] = {
        mbsr_joint_revolute(&at, NULL, z),  mbsr_joint_universal(&at, NULL, z, x),
        mbsr_joint_prismatic(&at, NULL, x), mbsr_joint_translational(&at, NULL),
        mbsr_joint_revolute(&at, NULL, x),  mbsr_joint_translational(&at, NULL)};
    test_rng rng = test_seed(seed);
    *s = (scene){.forces = 0};
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int i = 0; i < BODIES; ++i) {
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = parent[i];
        def.joint = joint[i];
        def.inertia = mbsr_inertia_rigid(2.0, com, tensor);
        assert_ok(mbsr_model_add_body(s->model, &def, NULL), mbsr_model_error(s->model));
    }
    assert_ok(mbsr_model_lock(s->model, 3, 1, 0.25), mbsr_model_error(s->model));
    for (int k = 0; k < FORCES; ++k) {
        const int body = test_integer(&rng, 0, BODIES - 1);
        const mbsr_force_def element =
            random_element(&rng, body, test_integer(&rng, 0, free_axes[body] - 1));
        assert_ok(mbsr_model_add_force(s->model, &element, NULL), mbsr_model_error(s->model));
    }
    if (seed % 2) {
        const double damping[6] = {0.1, 0.1, 0.1, 0.2, 0.2, 0.2};
        const mbsr_force_def bushing =
            mbsr_force_bushing(2, NULL, 4, NULL, (double[6]){1, 1, 1, 3, 3, 3}, damping);
        assert_ok(mbsr_model_add_force(s->model, &bushing, NULL), mbsr_model_error(s->model));
    }
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    assert_int_equal(s->nu, 10);
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
    test_fill(&rng, s->nu, s->x);
    for (int k = 0; k < FORCES; k += 3)
        assert_ok(mbsr_force_switch(s->model, s->data, k, 0), mbsr_data_error(s->data));
}

static void release(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* Forward and inverse dynamics, F of the momentum form, and a solution of its Newton system, one
 * after the other; the last by blocks or not. Returns how many numbers. */
static int evaluate(scene *s, int by_blocks, double *out)
{
    const int nq = s->nq, nu = s->nu;
    double y[MOMENTUM], yp[MOMENTUM] = {0.0};
    mbsr_data *d = s->data;
    const mbsr_error *error = mbsr_data_error(d);
    assert_ok(mbsr_forward_dynamics(s->model, d, 0.0, s->q, s->u, s->x, out), error);
    assert_ok(mbsr_inverse_dynamics(s->model, d, 0.0, s->q, s->u, s->x, NULL, out + nu), error);
    assert_ok(mbsr_dae_pack(s->model, d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), error);
    for (int k = 0; k < nu; ++k) yp[nq + nu + k] = s->x[k];
    assert_ok(mbsr_dae_residual(s->model, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, out + 2 * nu), error);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.by_blocks = by_blocks;
    mbsr_newton *newton;
    mbsr_newton_info info;
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, 20.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, out + 2 * nu, out + 2 * nu + nq + 2 * nu),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_get_info(newton, &info), NULL);
    assert_int_equal(info.vector_code, !by_blocks);
    mbsr_newton_destroy(newton);
    return 2 * nu + 2 * (nq + 2 * nu);
}

static void sweeps_and_stages_agree(void **state)
{
    (void)state;
    double difference = 0.0;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        scene s;
        double expected[10 * MOST], swept[10 * MOST], on[10 * MOST];
        const mbsri_sweep_kernels *list[2];
        make(&s, seed);
        const test_hidden trees = test_hide_sweeps(s.model);
        const int count = evaluate(&s, 1, expected);
        test_show_sweeps(s.model, trees);
        for (int k = 0; k < test_kernels(list); ++k) {
            test_use_kernels(s.model, list[k]);
            assert_int_equal(evaluate(&s, 0, swept), count);
            assert_true(test_relative_distance(s.nu, swept, expected) <= 1e-12);
            assert_true(test_relative_distance(count, swept, expected) <= 1e-10);
        }
        for (int k = 0; k < FORCES; k += 3)
            assert_ok(mbsr_force_switch(s.model, s.data, k, 1), mbsr_data_error(s.data));
        evaluate(&s, 0, on);
        difference = fmax(difference, test_relative_distance(count, on, expected));
        release(&s);
    }
    assert_true(difference > 0.1); /* switches matter */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sweeps_and_stages_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
