/* Newton systems of mechanisms of which some bodies are in vector code and others, on loops too,
 * are not: beside the elimination by blocks and the dense matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"

#include <math.h>
#include <stdlib.h>

/* ---- a user's hinge in the plane: the stock one ---- */

static const mbsr_joint_table *stock;
static mbsr_joint_table own;

static int position(const mbsr_joint_args *args, double *p)
{
    return stock->position(args, p);
}

static int own_rod(loops *s, int parent, double x, double length)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint =
        mbsr_joint_planar_revolute((mbsr_planar_frame){x, 0.0, 0.0}, (mbsr_planar_frame){0});
    stock = body.joint.table;
    own = *stock;
    own.position = position;
    body.joint.table = &own;
    body.inertia = mbsr_inertia_planar(1.2, (double[2]){0.5 * length, 0.1}, 0.2);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

/* ---- solutions ---- */

static void compare(loops *s, const double *q)
{
    test_rng rng = test_seed(11);
    loops_finish(s);
    test_fill(&rng, s->nu, s->u);
    assert_true(s->m->tree.newton->blocks > 0);
    newton_both_ways(s->m, s->d, q, s->u, BY_FRONT, NULL, 0);
    loops_free(s);
}

/* ---- tests ---- */

/* A rod without mass, whose end stands under that of a pendulum, beside a strut on a user's hinge.
 */
static void held_rods(void **state)
{
    (void)state;
    static const double q[] = {1.0, 1.3, 0.7, 0.4};
    loops s;
    loops_begin(&s, NULL);
    const int crank = own_rod(&s, MBSR_GROUND, 0.0, 1.0),
              rocker = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 1.0, 1.5),
              pendulum = loops_rod(&s, "pendulum", MBSR_GROUND, 4.0, 1.0, 1.0, 0.9),
              light = loops_rod(&s, "light", MBSR_GROUND, 4.0, 0.0, 0.0, 1.0);
    const mbsr_closure_def under =
        mbsr_closure_rows(light, (double[3]){1.0, 0.0, 0.0}, pendulum, (double[3]){0.9, 0.0, 0.0},
                          1, (double[3]){1.0, 0.0, 0.0});
    const mbsr_closure_def strut = mbsr_closure_distance(crank, (double[3]){1.0, 0.0, 0.0}, rocker,
                                                         (double[3]){1.5, 0.0, 0.0}, 2.0);
    assert_ok(mbsr_model_add_closure(s.m, &strut, NULL), mbsr_model_error(s.m));
    assert_ok(mbsr_model_add_closure(s.m, &under, NULL), mbsr_model_error(s.m));
    compare(&s, q);
}

/* g = sin q_a - 0.6 q_b */
static int cam_gap(const mbsr_closure_args *args, double *g)
{
    g[0] = sin(args->body[0].q[0]) - 0.6 * args->body[1].q[0];
    return 0;
}

static int cam_rows(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    out->matrix[out->column[0] + args->body[0].d] = cos(args->body[0].q[0]);
    out->matrix[out->column[1] + args->body[1].d] = -0.6;
    return 0;
}

/* A coupling whose ratio turns, beside a user's hinge, and in a tree of which bodies lack inertia.
 */
static void cams(void **state)
{
    (void)state;
    static const mbsr_closure_table cam = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                           .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES |
                                                    MBSR_CLOSURE_PLAIN | MBSR_CLOSURE_OWN,
                                           .name = "cam",
                                           .position = cam_gap,
                                           .jacobian = cam_rows};
    static const double q[] = {0.3, 0.8, 1.1, -0.4};
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        loops_begin(&s, NULL);
        (void)own_rod(&s, MBSR_GROUND, 0.0, 1.0);
        const int shaft = loops_rod(&s, "shaft", MBSR_GROUND, 2.0, 0.0, 1.0, 1.0),
                  follower = loops_rod(&s, "follower", shaft, 1.0, 0.0, massless ? 0.0 : 0.7, 0.8);
        (void)loops_rod(&s, "tool", follower, 0.8, 0.0, 0.5, 0.5);
        const mbsr_closure_def def =
            mbsr_closure_custom(&cam, 2, (int[2]){shaft, follower}, 1, 1, NULL);
        assert_ok(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m));
        compare(&s, q);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(held_rods), cmocka_unit_test(cams)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
