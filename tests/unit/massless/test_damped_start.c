/* The consistent start by the Newton solver, against the one by directions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "space.h"
#include "tree.h"

#include "massless/damped_start.h"

#include <stdbool.h>
#include <stdlib.h>

static const double now = 0.3;

/* A state with its start by directions, and by the Newton solver. */
typedef struct starts {
    int nq, nu;
    double *q, *u, *udot, *y, *yp;
    mbsr_consistent_info expected, info;
    bool served;
} starts;

static void take(starts *s, const mbsr_model *model)
{
    s->nq = mbsr_model_nq(model);
    s->nu = mbsr_model_nu(model);
    const size_t size = (size_t)(s->nq + 2 * s->nu) + 1;
    s->q = calloc(size, sizeof(double));
    s->u = calloc(size, sizeof(double));
    s->udot = calloc(size, sizeof(double));
    s->y = calloc(size, sizeof(double));
    s->yp = calloc(size, sizeof(double));
}

static void give_back(starts *s)
{
    free(s->q), free(s->u), free(s->udot), free(s->y), free(s->yp);
}

/* Both starts from (q, u); a status of the one by directions. */
static int start_both(const mbsr_model *model, mbsr_data *data, starts *s)
{
    const mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    int status = mbsr_dae_pack(model, data, form, now, s->q, s->u, s->y);
    if (!status)
        status = mbsr_dae_consistent(model, data, form, now, s->y, s->yp, &opt, &s->expected);
    s->info = (mbsr_consistent_info){0};
    assert_ok(mbsri_damped_start(model, data, now, s->q, s->u, s->udot, &opt, &s->info, &s->served),
              mbsr_data_error(data));
    return status;
}

static void compare(const starts *s, double tolerance)
{
    const double *u = s->y + s->nq + s->nu, *udot = s->yp + s->nq + s->nu;
    const double size = 1.0 + test_largest(s->nu, u), size_dot = 1.0 + test_largest(s->nu, udot);
    for (int k = 0; k < s->nu; ++k) {
        assert_close(s->u[k], u[k], tolerance * size);
        assert_close(s->udot[k], udot[k], 100.0 * tolerance * size_dot);
    }
}

static void damped_trees_start_as_by_directions(void **state)
{
    (void)state;
    int served = 0;
    for (int seed = 1; seed <= 40; ++seed) {
        test_space_tree tree;
        test_space_make(&tree, (test_space_opt){.seed = (uint64_t)seed,
                                                .bodies = 4 + seed % 4,
                                                .deficient = 0.7,
                                                .driven = seed % 2,
                                                .laws = 1,
                                                .gravity = 9.81});
        starts s;
        take(&s, tree.model);
        for (int k = 0; k < tree.nq; ++k) s.q[k] = tree.q[k];
        for (int k = 0; k < tree.nu; ++k) s.u[k] = tree.u[k];
        if (start_both(tree.model, tree.data, &s) == MBSR_OK && s.expected.null_directions > 0) {
            assert_true(s.served);
            assert_int_equal(s.expected.elastic_directions, 0);
            compare(&s, 1e-7);
            ++served;
        }
        give_back(&s);
        test_space_free(&tree);
    }
    assert_true(served > 20);
}

static void general_trees_too(void **state)
{
    (void)state;
    int served = 0, directions = 0;
    for (int seed = 1; seed <= 60; ++seed) {
        test_tree tree;
        test_tree_make(&tree, (test_tree_opt){.seed = (uint64_t)seed,
                                              .bodies = 5,
                                              .max_d = 3,
                                              .deficient = 0.7,
                                              .bend = 0.1,
                                              .forces = 1,
                                              .moving_root = seed % 2});
        starts s;
        take(&s, tree.model);
        test_rng rng = test_seed((uint64_t)seed);
        test_fill(&rng, s.nq, s.q);
        test_fill(&rng, s.nu, s.u);
        if (start_both(tree.model, tree.data, &s) == MBSR_OK && s.served) {
            assert_int_equal(s.expected.elastic_directions, 0);
            compare(&s, 1e-6);
            ++served;
            directions += s.expected.null_directions;
        }
        give_back(&s);
        test_tree_free(&tree);
    }
    assert_true(served > 20 && directions > 20);
}

/* A chain of carts without mass but for the last, each on a spring and a damper to the one before.
 * The dampers of carts `bare` and
 * the one after are left out: in series with others, one spring without damper would do. */
static void make_carts(int count, int bare, mbsr_model **model, mbsr_data **data)
{
    mbsr_error error;
    const mbsr_model_def def = mbsr_default_model_def();
    assert_ok(mbsr_model_create(&def, model, &error), &error);
    int at = MBSR_GROUND, id;
    for (int k = 0; k < count; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = at;
        body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        body.inertia = k + 1 < count ? mbsr_inertia_zero() : mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(*model, &body, &at), mbsr_model_error(*model));
        const bool damped = bare < 0 || (k != bare && k != bare + 1);
        const double damping = damped ? 0.5 + 0.01 * k : 0.0;
        const mbsr_force_def spring = mbsr_force_joint_spring(at, 0, 10.0 + k, damping, 0.0);
        assert_ok(mbsr_model_add_force(*model, &spring, &id), mbsr_model_error(*model));
    }
    assert_ok(mbsr_model_finish(*model), mbsr_model_error(*model));
    assert_ok(mbsr_data_create(*model, data, &error), &error);
}

static void carts_free(mbsr_model *model, mbsr_data *data)
{
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
}

static void a_direction_on_a_spring_alone_is_not_served(void **state)
{
    (void)state;
    for (int run = 0; run < 10; ++run) {
        const int bare = run / 2 - 1, balanced = run % 2;
        mbsr_model *model;
        mbsr_data *data;
        starts s;
        make_carts(6, bare, &model, &data);
        take(&s, model);
        /* springs that are in balance leave the rates to chance, were the direction not found */
        for (int k = 0; k < 6; ++k) s.q[k] = balanced ? 1.0 / (10.0 + k) : 0.1 * k, s.u[k] = 1.0;
        assert_ok(start_both(model, data, &s), mbsr_data_error(data));
        assert_int_equal(s.served, bare < 0);
        assert_int_equal(s.expected.elastic_directions, bare < 0 ? 0 : 1);
        if (bare < 0) {
            compare(&s, 1e-7);
        } else {
            for (int k = 0; k < 6; ++k) assert_close(s.u[k], 1.0, 0.0);
        }
        give_back(&s);
        carts_free(model, data);
    }
}

/* Far more directions than a start by directions could find; the carts move at a common force, v_k
 * = (F - c_k q_k) / d_k with F from what the momentum leaves. */
static void a_thousand_massless_carts_start(void **state)
{
    (void)state;
    enum { CARTS = 1000 };
    mbsr_model *model;
    mbsr_data *data;
    starts s;
    make_carts(CARTS, -1, &model, &data);
    take(&s, model);
    double sum = 0.0, compliance = 0.0;
    for (int k = 0; k < CARTS; ++k) {
        s.q[k] = 0.1 * sin(k);
        s.u[k] = 1.0;
        sum += (10.0 + k) * s.q[k] / (0.5 + 0.01 * k);
        compliance += 1.0 / (0.5 + 0.01 * k);
    }
    const double force = (CARTS + sum) / compliance; /* the last one moves with CARTS */
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y),
              mbsr_data_error(data));
    assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, &info),
              mbsr_data_error(data));
    assert_int_equal(info.null_directions, CARTS - 1);
    assert_int_equal(info.elastic_directions, 0);
    double acceleration = 0.0;
    for (int k = 0; k < CARTS; ++k) {
        const double v = (force - (10.0 + k) * s.q[k]) / (0.5 + 0.01 * k);
        assert_close(s.y[2 * CARTS + k], v, 1e-7 * CARTS);
        acceleration += s.yp[2 * CARTS + k];
    }
    assert_close(acceleration, -force, 1e-6 * fabs(force));
    give_back(&s);
    carts_free(model, data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damped_trees_start_as_by_directions),
        cmocka_unit_test(general_trees_too),
        cmocka_unit_test(a_direction_on_a_spring_alone_is_not_served),
        cmocka_unit_test(a_thousand_massless_carts_start),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
