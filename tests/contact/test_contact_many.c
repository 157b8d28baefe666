/* Of many shapes all pairs that touch are found, and no others: beside a loop over all pairs. What
 * lies side by side takes no memory of pairs, and a large pile no more iterations than a small one.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <mbsrank/newton.h>

#include <stdbool.h>
#include <stdlib.h>

enum { MOST = 300, STATES = 4 };

/* How spheres lie: in a block, on a sheet, along a rod, far apart; radii of one size, of all sizes,
 * one that is larger than all else together. */
typedef enum crowd { BLOCK, SHEET, ROD, LOOSE, SIZES, GIANT, CROWDS } crowd;

static double radius_of(crowd where, int k, uint64_t *seed)
{
    if (where == GIANT && k == 1) return 3.0;
    return where == SIZES ? 0.02 * exp(1.2 * (1.0 + draw(seed))) : 0.1;
}

static void draw_spheres(crowd where, int count, mbsr_shape *shapes)
{
    uint64_t seed = 3;
    for (int k = 0; k < count; ++k) {
        shapes[k] = sample_shape(MBSR_SHAPE_SPHERE, k);
        shapes[k].size[0] = radius_of(where, k, &seed);
        shapes[k].law.margin = 0.0;
    }
}

/* Places; in odd states the last sphere has flown away. */
static void draw_places(crowd where, int count, int state, uint64_t *seed, double *q)
{
    const double side = (where == LOOSE ? 0.45 : 0.09) * cbrt(count);
    for (int k = 0; k < count; ++k) {
        double *x = q + 7 * k + 4;
        for (int l = 0; l < 3; ++l) {
            const bool thin = (where == SHEET && l == 2) || (where == ROD && l != state % 3);
            x[l] = (thin ? 0.05 : where == ROD ? 6.0 * side : 2.0 * side) * draw(seed);
        }
        q[7 * k] = 1.0;
    }
    if (state % 2 && count > 2) q[7 * (count - 1) + 5] = 1e6;
}

/* Points, by pairs in ascending order. */
static void check_pairs(int count, const mbsr_shape *shapes, const double *q,
                        const mbsr_contact_point *p, int points)
{
    int found = 0;
    for (int a = 0; a < count; ++a) {
        for (int b = a + 1; b < count; ++b) {
            const double *x = q + 7 * a + 4, *y = q + 7 * b + 4;
            const double apart =
                sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                     (x[2] - y[2]) * (x[2] - y[2]));
            if (apart >= shapes[a].size[0] + shapes[b].size[0]) continue;
            assert_true(found < points);
            assert_int_equal(p[found].shape_a, a);
            assert_int_equal(p[found].shape_b, b);
            assert_close(p[found].depth, shapes[a].size[0] + shapes[b].size[0] - apart, 1e-12);
            ++found;
        }
    }
    assert_int_equal(found, points);
}

static int count_pairs(crowd where, int count, mbsr_contact_point *p)
{
    mbsr_shape shapes[MOST];
    double q[7 * MOST] = {0.0}, u[6 * MOST] = {0.0};
    uint64_t seed = 11;
    int all = 0;
    draw_spheres(where, count, shapes);
    scene s = scene_of(count, shapes);
    for (int state = 0; state < STATES; ++state) {
        draw_places(where, count, state, &seed, q);
        const int points = points_at(&s, q, u, MOST * MOST, p);
        check_pairs(count, shapes, q, p, points);
        all += points;
    }
    end_scene(&s);
    return all;
}

static void pairs_of_many(void **unused)
{
    static const int counts[] = {1, 2, 3, 5, 17, 90, MOST};
    mbsr_contact_point *p = calloc((size_t)MOST * MOST, sizeof *p);
    int all = 0;
    (void)unused;
    assert_non_null(p);
    for (int where = 0; where < CROWDS; ++where) {
        for (int k = 0; k < 7; ++k) all += count_pairs((crowd)where, counts[k], p);
    }
    print_message("%d pairs\n", all);
    assert_true(all > 3000);
    free(p);
}

/* Capsules, ellipsoids, cylinders and spheres, turned anyhow and packed as closely as the balls
 * around them can be, with memory for one pair. */
static void none_is_near(void **unused)
{
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_CAPSULE, MBSR_SHAPE_ELLIPSOID,
                                            MBSR_SHAPE_CYLINDER, MBSR_SHAPE_SPHERE};
    enum { SIDE = 4, COUNT = SIDE * SIDE * SIDE };
    static const double apart[] = {2 * 0.351, 2 * 0.251, 2 * 0.325, 2 * 0.201};
    mbsr_shape shapes[COUNT];
    double q[7 * COUNT], u[6 * COUNT] = {0.0};
    mbsr_contact_point p[1];
    uint64_t seed = 5;
    (void)unused;
    for (int kind = 0; kind < 4; ++kind) {
        for (int k = 0; k < COUNT; ++k) {
            const int at[3] = {k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE};
            shapes[k] = sample_shape(kinds[kind], k);
            for (int l = 0; l < 4; ++l) q[7 * k + l] = draw(&seed);
            q[7 * k + 4] = apart[kind] * (at[0] + 0.5 * at[1] + 0.5 * at[2]);
            q[7 * k + 5] = apart[kind] * sqrt(0.75) * (at[1] + at[2] / 3.0);
            q[7 * k + 6] = apart[kind] * sqrt(2.0 / 3.0) * at[2];
        }
        scene s = scene_with(COUNT, shapes, 1);
        assert_int_equal(points_at(&s, q, u, 1, p), 0);
        end_scene(&s);
    }
}

/* Iterations for one solution, of side^3 spheres pressed into each other on a floor. */
static double iterations_of(int side, double c)
{
    enum { SIDE = 9, MANY = SIDE * SIDE * SIDE };
    static mbsr_shape shapes[MANY + 1];
    static double q[7 * MANY], u[6 * MANY], y[19 * MANY], yp[19 * MANY], r[19 * MANY];
    const int count = side * side * side;
    uint64_t seed = 7;
    mbsr_newton *newton;
    mbsr_newton_info info;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    for (int k = 0; k < count; ++k) {
        const int at[3] = {k % side, k / side % side, k / side / side};
        shapes[k] = sample_shape(MBSR_SHAPE_SPHERE, k);
        shapes[k].law = (mbsr_contact_law){
            .stiffness = 1e4, .exponent = 1.5, .damping = 0.3, .friction = 0.3, .slip = 1e-3};
        for (int l = 0; l < 4; ++l) q[7 * k + l] = l == 0;
        for (int l = 0; l < 3; ++l) {
            q[7 * k + 4 + l] = 0.39 * (at[l] + 0.5) + 2e-3 * draw(&seed);
            u[6 * k + l] = 1e-3 * draw(&seed);
            u[6 * k + 3 + l] = 1e-4 * draw(&seed);
        }
    }
    shapes[count] = sample_shape(MBSR_SHAPE_PLANE, MBSR_GROUND);
    scene s = scene_of(count + 1, shapes);
    opt.together = 64;
    assert_int_equal(mbsr_newton_create(s.model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), MBSR_OK);
    const size_t size = (size_t)mbsr_dae_size(s.model, MBSR_DAE_MOMENTUM);
    assert_true(size <= sizeof y / sizeof *y);
    assert_int_equal(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, q, u, y), MBSR_OK);
    for (size_t k = 0; k < size; ++k) r[k] = draw(&seed), yp[k] = 0.0;
    assert_int_equal(mbsr_newton_factor(newton, s.data, 0.0, y, yp, c), MBSR_OK);
    assert_int_equal(mbsr_newton_solve(newton, r, r), MBSR_OK);
    assert_int_equal(mbsr_newton_get_info(newton, &info), MBSR_OK);
    assert_int_equal(info.exact, 0);
    mbsr_newton_destroy(newton);
    end_scene(&s);
    return (double)info.iterations;
}

static void piles_of_all_sizes(void **unused)
{
    (void)unused;
    static const double c[] = {500.0, 2000.0};
    for (int k = 0; k < 2; ++k) {
        const double few = iterations_of(5, c[k]), many = iterations_of(9, c[k]);
        print_message("%g 1/s: %g, %g iterations\n", c[k], few, many);
        assert_true(few > 2.0 && many < 1.3 * few + 1.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pairs_of_many),
                                       cmocka_unit_test(none_is_near),
                                       cmocka_unit_test(piles_of_all_sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
