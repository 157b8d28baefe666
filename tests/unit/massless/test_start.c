/* Consistent starts of trees: u' against differences of consistent states, masses that stay, units, many directions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double now = 0.3;

/* A state of the momentum form, and what was found of it. */
typedef struct starts {
    int nq, nu;
    double *q, *u, *y, *yp;
} starts;

static void take(starts *s, const mbsr_model *model)
{
    s->nq = mbsr_model_nq(model);
    s->nu = mbsr_model_nu(model);
    const size_t size = (size_t)(s->nq + 2 * s->nu) + 1;
    s->q = calloc(size, sizeof(double));
    s->u = calloc(size, sizeof(double));
    s->y = calloc(size, sizeof(double));
    s->yp = calloc(size, sizeof(double));
}

static void give_back(starts *s)
{
    free(s->q), free(s->u), free(s->y), free(s->yp);
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

/* Springs in balance leave the rates to chance, were the direction on a spring alone not found. */
static void a_direction_on_a_spring_alone_is_told(void **state)
{
    (void)state;
    for (int run = 0; run < 10; ++run) {
        const int bare = run / 2 - 1, balanced = run % 2;
        mbsr_model *model;
        mbsr_data *data;
        mbsr_consistent_info info;
        starts s;
        make_carts(6, bare, &model, &data);
        take(&s, model);
        for (int k = 0; k < 6; ++k) s.q[k] = balanced ? 1.0 / (10.0 + k) : 0.1 * k, s.u[k] = 1.0;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y),
                  mbsr_data_error(data));
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, &info),
                  mbsr_data_error(data));
        assert_int_equal(info.null_directions, 5);
        assert_int_equal(info.elastic, bare < 0 ? 0 : 1);
        /* the force in all elements is the same, and its rate where springs alone hold */
        double force = 0.0, rate = 0.0;
        for (int k = 0; k < 6; ++k) {
            const bool damped = bare < 0 || (k != bare && k != bare + 1);
            const double d = damped ? 0.5 + 0.01 * k : 0.0, *u = s.y + 12, *udot = s.yp + 12,
                         f = (10.0 + k) * s.y[k] + d * u[k], g = (10.0 + k) * u[k] + d * udot[k];
            if (k == 0) force = f, rate = g;
            assert_close(f, force, 1e-11 * (1.0 + fabs(force)));
            assert_close(g, rate, 3e-8 * (1.0 + fabs(rate)));
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
    assert_int_equal(info.elastic, 0);
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
        cmocka_unit_test(a_direction_on_a_spring_alone_is_told),
        cmocka_unit_test(a_thousand_massless_carts_start),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
