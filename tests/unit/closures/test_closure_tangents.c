/* Derivatives of stock closures for Newton systems against differences of forces and rates.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include "newton/slopes/closure_slopes.h"
#include "recursion/closure_differences.h"
#include "recursion/closures.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static int tumble(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const double axis[3] = {2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0};
    const mbsr_frame frame = mbsr_frame_rotated(NULL, axis, 0.4 + t);
    memcpy(p + MBSR_POSE_R, frame.R, sizeof frame.R);
    for (int k = 0; k < 3; ++k) {
        V[k] = axis[k];
        A[k] = V[3 + k] = A[3 + k] = 0.0;
        p[MBSR_POSE_X + k] = 0.1 * k;
    }
    V[4] = 0.3;
    return 0;
}

static void add(loops *s, mbsr_closure_def def)
{
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

static void body(loops *s, mbsr_joint joint)
{
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = joint;
    assert_ok(mbsr_model_add_body(s->m, &def, NULL), mbsr_model_error(s->m));
}

static mbsr_closure_def stiff(mbsr_closure_def def, int rows)
{
    for (int k = 0; k < rows; ++k) def.stiffness[k] = 10.0 * (k + 1);
    return def;
}

/* Closures of all kinds between two bodies, of which the first or the second may be the ground. */
static void add_closures(loops *s, int a, int b, bool flat)
{
    const double p[3] = {0.3, -0.2, flat ? 0.0 : 0.1}, r[3] = {-0.1, 0.5, flat ? 0.0 : 0.2},
                 along[6] = {1.0, 2.0, flat ? 0.0 : 3.0, 0.0, 1.0, 0.0};
    const mbsr_frame A = mbsr_frame_at(0.2, 0.1, flat ? 0.0 : -0.1),
                     B = mbsr_frame_at(0.0, 0.3, 0.0);
    double C[36] = {0.0};
    add(s, mbsr_closure_weld(a, &A, b, &B));
    add(s, stiff(mbsr_closure_weld(a, &A, b, &B), flat ? 3 : 6));
    add(s, mbsr_closure_ball(a, p, b, r));
    add(s, mbsr_closure_rows(a, p, b, r, 2, along));
    add(s, mbsr_closure_body_rows(a, p, b, r, 2, along));
    add(s, mbsr_closure_distance(a, p, b, r, 0.7));
    mbsr_closure_def soft = mbsr_closure_weld(a, &A, b, &B);
    soft.compliant = flat ? 3 : 6;
    for (int k = 0; k < soft.compliant * soft.compliant; ++k)
        C[k] = k % (soft.compliant + 1) == 0 ? 1.0 : 0.3;
    soft.compliance = C;
    add(s, soft);
    mbsr_force_def line = mbsr_force_point_spring(a, p, b, r, 100.0, 1.0, 0.4);
    line.as_closure = MBSR_SPRING_LOOSE;
    assert_ok(mbsr_model_add_force(s->m, &line, NULL), mbsr_model_error(s->m));
}

static void compare(loops *s)
{
    test_rng rng = test_seed(3);
    double q[LOOPS_MOST], u[LOOPS_MOST];
    loops_build(s);
    test_fill(&rng, s->nq, q);
    test_fill(&rng, s->nu, u);
    assert_ok(mbsr_normalise(s->m, s->d, q), NULL);
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.2, q), mbsr_data_error(s->d));
    assert_ok(mbsr_stage_velocities(s->m, s->d, u), mbsr_data_error(s->d));
    assert_ok(mbsri_closure_jacobians(s->m, s->d), mbsr_data_error(s->d));
    test_fill(&rng, s->rows, s->d->loop_lambda);
    for (size_t k = 0; k < s->m->closures.count; ++k) {
        const mbsri_closure *c = (const mbsri_closure *)s->m->closures.data + k;
        const size_t columns = (size_t)c->columns, size = columns * (columns + (size_t)c->rows);
        double *work = calloc(mbsri_closure_tangents_work(c) + 2 * size, sizeof *work);
        assert_non_null(work);
        double *own = work + mbsri_closure_tangents_work(c), *truth = own + size;
        mbsri_closure_tangents out = {.S = own, .slope = own + columns * columns};
        assert_non_null(c->def.table->tangent);
        assert_int_equal(mbsri_closure_tangents_of(s->m, s->d, c, work, &out), MBSR_OK);
        assert_int_equal(mbsri_closure_tangent(s->m, s->d, c, s->d->loop_lambda + c->row, work,
                                               truth, truth + columns * columns),
                         MBSR_OK);
        for (size_t j = 0; j < size; ++j) {
            if (fabs(own[j] - truth[j]) > 1e-9)
                print_message("closure %d (%s), number %d\n", (int)k, c->def.table->name, (int)j);
            assert_close(own[j], truth[j], 1e-9);
        }
        free(work);
    }
    loops_free(s);
}

static void in_space(void **state)
{
    (void)state;
    const mbsr_root moving = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, tumble, NULL);
    for (int k = 0; k < 2; ++k) {
        loops s;
        loops_begin(&s, k ? &moving : NULL);
        body(&s, mbsr_joint_free(NULL, NULL));
        body(&s, mbsr_joint_free(NULL, NULL));
        add_closures(&s, 0, 1, false);
        add_closures(&s, MBSR_GROUND, 1, false);
        add_closures(&s, 0, MBSR_GROUND, false);
        compare(&s);
    }
}

static void in_the_plane(void **state)
{
    (void)state;
    loops s;
    const mbsr_planar_frame own = {0.0, 0.0, 0.0};
    loops_begin(&s, NULL);
    body(&s, mbsr_joint_planar_free(own, own));
    body(&s, mbsr_joint_planar_free(own, own));
    add_closures(&s, 0, 1, true);
    add_closures(&s, MBSR_GROUND, 1, true);
    add(&s, mbsr_closure_coupling(2, (int[2]){0, 1}, (int[2]){0, 1}, (double[2]){1.0, 2.0}, 0.0));
    compare(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(in_space),
        cmocka_unit_test(in_the_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
