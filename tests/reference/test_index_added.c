/* As test_index_joints.c, on trees to which flexible beams with massive and massless shapes are
 * added, closures, or both.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "joint_scene.h"

static void try_scenes(bool beams, bool closures)
{
    const int seeds = test_long() ? 200 : test_seeds(5, 10);
    int count = 0, judged = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        scene s = scene_draw(seed, false);
        if (beams) scene_add_beams(&s);
        if (closures) scene_add_closures(&s);
        const verdict v = scene_judge(&s);
        judged += v.settled;
        for (size_t l = 0; l < sizeof systems / sizeof *systems && v.settled; ++l)
            count += scene_is_wrong(seed, &s, &v, systems + l);
    }
    assert_true(judged > seeds / 2);
    assert_int_equal(count, 0);
}

static void with_flexible_beams(void **state)
{
    (void)state;
    try_scenes(true, false);
}

static void with_closures(void **state)
{
    (void)state;
    try_scenes(false, true);
}

static void with_both(void **state)
{
    (void)state;
    try_scenes(true, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(with_flexible_beams),
        cmocka_unit_test(with_closures),
        cmocka_unit_test(with_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
