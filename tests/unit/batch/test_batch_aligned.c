/* Batches of trees whose axes are parallel, opposite or across each other, with joints in one
 * place, in four systems of units: against one call for each state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/batch.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>

enum { BODIES = 9, STATES = 9, MOST_Q = 4 * BODIES, MOST_U = 3 * BODIES };

typedef struct scene {
    mbsr_model *model;
    double q[STATES * MOST_Q], u[STATES * MOST_U], tau[STATES * MOST_U];
} scene;

static bool chance(test_rng *rng, int percent)
{
    return test_integer(rng, 1, 100) <= percent;
}

/* 0, or half a metre forth or back, in each direction. */
static void random_offset(test_rng *rng, double length, double *x)
{
    for (int k = 0; k < 3; ++k)
        x[k] = chance(rng, 50) ? 0.0 : (chance(rng, 50) ? 0.5 : -0.5) * length;
}

static mbsr_joint random_joint(test_rng *rng, const mbsr_frame *A)
{
    double axis[3] = {0.0, 0.0, 0.0};
    axis[test_integer(rng, 0, 2)] = chance(rng, 50) ? 1.0 : -1.0;
    const int kind = test_integer(rng, 1, 10);
    return kind <= 7   ? mbsr_joint_revolute(A, NULL, axis)
           : kind <= 9 ? mbsr_joint_prismatic(A, NULL, axis)
                       : mbsr_joint_spherical(A, NULL);
}

static mbsr_inertia random_inertia(test_rng *rng, double mass, double length)
{
    const double square = 0.01 * mass * length * length;
    double com[3], tensor[6] = {0.0};
    if (chance(rng, 15)) return mbsr_inertia_zero();
    for (int k = 0; k < 3; ++k) {
        com[k] = chance(rng, 50) ? 0.0 : 0.15 * length * test_uniform(rng);
        tensor[k] = square * (1.5 + 0.5 * test_uniform(rng));
    }
    return mbsr_inertia_rigid(mass * (1.0 + 0.5 * test_uniform(rng)), com, tensor);
}

/* The coordinates of body i, and with them tau, in states 0: zero, 1: quarter turns, others: any.
 */
static void set_state(scene *s, test_rng *rng, int i, double length, double force)
{
    int q, nq, u, nu;
    mbsr_coordinate_kind kind[6], rate[6];
    const int all_q = mbsr_model_nq(s->model), all_u = mbsr_model_nu(s->model);
    assert_ok(mbsr_body_coordinates(s->model, i, &q, &nq, &u, &nu), NULL);
    assert_ok(mbsr_body_coordinate_kinds(s->model, i, kind, rate), NULL);
    for (int state = 0; state < STATES; ++state) {
        double *at = s->q + state * all_q + q, square = 0.0;
        for (int k = 0; k < nq; ++k) {
            at[k] = state == 0   ? 0.0
                    : state == 1 ? acos(0.0) * test_integer(rng, 0, 3)
                                 : 3.0 * test_uniform(rng);
            if (nq == 4) at[k] += k == 0;
            square += at[k] * at[k];
        }
        for (int k = 0; k < nq && nq == 4; ++k) at[k] /= sqrt(square);
        const bool slides = kind[0] == MBSR_COORDINATE_TRANSLATION;
        if (slides) at[0] *= length;
        for (int k = 0; k < nu; ++k) {
            s->u[state * all_u + u + k] = 0.0;
            s->tau[state * all_u + u + k] = force * (slides ? 1.0 : length) * test_uniform(rng);
        }
    }
}

static void build(scene *s, test_rng *rng, const units *system)
{
    const double L = system->length, M = system->mass, a = L / (system->time * system->time);
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int i = 0; i < BODIES; ++i) {
        double offset[3], axis[3] = {0.0, 0.0, 0.0};
        mbsr_body_def body = mbsr_default_body_def();
        random_offset(rng, L, offset);
        axis[test_integer(rng, 0, 2)] = 1.0;
        const mbsr_frame A = mbsr_frame_rotated(offset, axis, acos(0.0) * test_integer(rng, 0, 2));
        body.parent = i == 0 ? MBSR_GROUND : chance(rng, 70) ? i - 1 : test_integer(rng, 0, i - 1);
        body.joint = random_joint(rng, &A);
        body.inertia = random_inertia(rng, M, L);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    const mbsr_force_def weight = mbsr_force_gravity(0.0, -9.81 * a, 0.3 * a);
    assert_ok(mbsr_model_add_force(s->model, &weight, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    for (int i = 0; i < BODIES; ++i) set_state(s, rng, i, L, M * a);
}

static void compare(const double *batch, const double *one, int n, double most)
{
    const double size = test_largest(n, one);
    for (int k = 0; k < n; ++k) assert_close(batch[k], one[k], most * size);
}

static void run(const scene *s, int *served)
{
    mbsr_batch *batch = NULL;
    mbsr_data *d = NULL;
    double udot[STATES * MOST_U], tau[STATES * MOST_U], one[MOST_U];
    int status[STATES];
    const int nq = mbsr_model_nq(s->model), nu = mbsr_model_nu(s->model);
    assert_int_equal(mbsr_batch_create(s->model, &batch, NULL), MBSR_OK);
    assert_int_equal(mbsr_data_create(s->model, &d, NULL), MBSR_OK);
    (void)mbsr_batch_forward_dynamics(s->model, batch, 0.0, STATES, s->q, s->u, s->tau, udot,
                                      status);
    for (int k = 0; k < STATES; ++k) {
        const double *q = s->q + k * nq, *u = s->u + k * nu;
        assert_int_equal(mbsr_forward_dynamics(s->model, d, 0.0, q, u, s->tau + k * nu, one),
                         status[k]);
        if (status[k]) continue;
        compare(udot + k * nu, one, nu, 1e-9);
        ++*served;
    }
    assert_ok(
        mbsr_batch_inverse_dynamics(s->model, batch, 0.0, STATES, s->q, s->u, s->tau, tau, status),
        mbsr_batch_error(batch));
    for (int k = 0; k < STATES; ++k) {
        assert_ok(mbsr_inverse_dynamics(s->model, d, 0.0, s->q + k * nq, s->u + k * nu,
                                        s->tau + k * nu, NULL, one),
                  mbsr_data_error(d));
        compare(tau + k * nu, one, nu, 1e-10);
    }
    mbsr_batch_destroy(batch);
    mbsr_data_destroy(d);
}

static void aligned_trees(void **state)
{
    (void)state;
    int served[4] = {0};
    const int seeds = test_seeds_short(60, 2000);
    for (int system = 0; system < 4; ++system) {
        for (int seed = 1; seed <= seeds; ++seed) {
            test_rng rng = test_seed((uint64_t)seed);
            scene s;
            build(&s, &rng, systems + system);
            run(&s, served + system);
            mbsr_model_destroy(s.model);
        }
    }
    assert_true(served[0] > seeds);
    for (int system = 1; system < 4; ++system) assert_int_equal(served[system], served[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(aligned_trees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
