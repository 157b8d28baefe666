/* Linkages in a plane, made of bodies in space whose axes lie anywhere, with pins that are stiff
 * balls: of each the row across the plane is redundant, and rounding of its gap is a force.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

/* A rod from a to b along the root's axes at the start, with its own axes turned: its frame in the
 * root. */
static mbsr_frame turned(const double *a, double angle)
{
    return mbsr_frame_rotated(a, (double[3]){0.3, -0.8, 0.5}, angle);
}

/* What of the root is x, seen from the frame. */
static mbsr_frame seen(const mbsr_frame *from, const double *x)
{
    const mbsr_frame back = mbsr_frame_inverse(from), at = mbsr_frame_at(x[0], x[1], x[2]);
    return mbsr_frame_product(&back, &at);
}

static int add_rod(loops *s, int parent, const mbsr_frame *before, const mbsr_frame *frame,
                   const double *a, const double *b, double mass)
{
    const mbsr_frame from = seen(frame, a), to = seen(frame, b), A = seen(before, a);
    const mbsr_inertia ball = mbsr_inertia_sphere(30.0, 0.1);
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = mbsr_joint_revolute(&A, &from, (double[3]){0.0, 0.0, 1.0});
    body.inertia = mbsr_inertia_sum(mbsr_inertia_rod(mass, from.x, to.x), ball);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

/* Crank and coupler on one side, the rocker on the other; the pin between coupler and rocker. */
static void build(loops *s, double stiffness, double angle)
{
    static const double A[3] = {0.0, 0.0, 0.0}, B[3] = {0.8, -0.6, 0.0}, C[3] = {1.8, -0.4, 0.0},
                        D[3] = {1.0, 0.0, 0.0};
    const mbsr_frame root = mbsr_frame_identity(), crank = turned(A, angle),
                     coupler = turned(B, 2.0 * angle), rocker = turned(D, -angle);
    loops_begin(s, NULL);
    const int first = add_rod(s, MBSR_GROUND, &root, &crank, A, B, 1.0),
              middle = add_rod(s, first, &crank, &coupler, B, C, 2.0),
              last = add_rod(s, MBSR_GROUND, &root, &rocker, D, C, 1.0);
    const mbsr_frame on_coupler = seen(&coupler, C), on_rocker = seen(&rocker, C);
    mbsr_closure_def pin = mbsr_closure_ball(middle, on_coupler.x, last, on_rocker.x);
    for (int k = 0; k < 3; ++k) {
        pin.stiffness[k] = stiffness;
        pin.damping[k] = 1e-4 * stiffness;
    }
    assert_ok(mbsr_model_add_closure(s->m, &pin, NULL), mbsr_model_error(s->m));
    loops_finish(s);
}

static void cost_what_rigid_ones_do(void **state)
{
    (void)state;
    for (int turn = 0; turn < 4; ++turn) {
        loops s;
        build(&s, 0.0, 0.9 * turn);
        const loops_result rigid = loops_run(&s, 1e-6, 0.5);
        const double crank = s.q[0];
        assert_int_equal(rigid.status, MBSR_OK);
        loops_free(&s);
        for (double stiffness = 1e8; stiffness < 2e14; stiffness *= 10.0) {
            build(&s, stiffness, 0.9 * turn);
            const loops_result r = loops_run(&s, 1e-6, 0.5);
            print_message("%g N/m: %ld steps, rigid %ld\n", stiffness, r.steps, rigid.steps);
            assert_int_equal(r.status, MBSR_OK);
            assert_close(s.q[0], crank, 3e-5);
            assert_less((double)r.steps, 1.3 * (double)rigid.steps);
            loops_free(&s);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(cost_what_rigid_ones_do)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
