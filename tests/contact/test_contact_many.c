/* Of many shapes all pairs that touch are found, and no others: beside a loop over all pairs.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <stdbool.h>
#include <stdlib.h>

enum { MOST = 300, STATES = 4 };

/* How spheres lie: in a block, on a sheet, along a rod; radii of one size, of all sizes, one that
 * is larger than all else together. */
typedef enum crowd { BLOCK, SHEET, ROD, SIZES, GIANT, CROWDS } crowd;

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
    const double side = 0.09 * cbrt(count);
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pairs_of_many)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
