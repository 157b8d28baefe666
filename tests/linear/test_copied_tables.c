/* Closures and joints of a caller's own: those of random models, whose tables lack derivatives,
 * have the linear equations of the built-in ones.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"

#include <mbsrank/linear.h>

#include <string.h>

typedef struct tables {
    mbsr_joint_table joint[ANY_BODIES];
    mbsr_closure_table closure[ANY_BODIES];
} tables;

/* The same model whose tables have values alone. */
static mbsr_model *without_derivatives(const mbsr_model *of, tables *own)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < mbsr_model_bodies(of); ++k) {
        mbsr_body_def body;
        assert_ok(mbsr_body_definition(of, k, &body), NULL);
        own->joint[k] = *body.joint.table;
        own->joint[k].tangent = NULL;
        own->joint[k].rate_tangent = NULL;
        body.joint.table = own->joint + k;
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    for (int k = 0; k < mbsr_model_forces(of); ++k) {
        mbsr_force_def force;
        assert_ok(mbsr_force_definition(of, k, &force), NULL);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    }
    for (int k = 0; k < mbsr_model_closures(of); ++k) {
        mbsr_closure_def closure;
        assert_ok(mbsr_closure_definition(of, k, &closure), NULL);
        mbsr_closure_table *table = own->closure + k;
        *table = *closure.table;
        table->tangent = NULL;
        table->bias = NULL;
        if (table->position) {
            table->jacobian = NULL;
            table->drift = NULL;
        }
        closure.table = table;
        assert_ok(mbsr_model_add_closure(m, &closure, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* How many states there are; negative: the status, where there are no equations. */
static int count_states(const mbsr_model *m, const double *q, const double *u)
{
    mbsr_data *d;
    mbsr_linear *l;
    mbsr_linear_info info = {.states = 0};
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const int status = mbsr_linear_create(m, d, 0.0, q, u, NULL, &l, NULL);
    if (!status) {
        assert_ok(mbsr_linear_get_info(l, &info), NULL);
        mbsr_linear_destroy(l);
    }
    mbsr_data_destroy(d);
    return status ? -status : info.states;
}

static void closed_models_at_rest(void **state)
{
    (void)state;
    int with_equations = 0;
    for (uint64_t seed = 125; seed < 300; seed += 10) {
        any_model s;
        tables own;
        if (!any_model_make(&s, seed, systems, false)) continue;
        mbsr_model *copy = without_derivatives(s.m, &own);
        const int states = count_states(s.m, s.q, s.u);
        assert_int_equal(count_states(copy, s.q, s.u), states);
        with_equations += states >= 0;
        mbsr_model_destroy(copy);
        mbsr_model_destroy(s.m);
    }
    assert_true(with_equations > 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(closed_models_at_rest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
