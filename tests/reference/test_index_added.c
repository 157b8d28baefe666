/* As test_index_joints.c, on trees to which flexible beams with massive and massless shapes are added.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "joint_scene.h"

static void try_scenes(void)
{
    const int seeds = test_long() ? 5000 : test_seeds(20, 120);
    int count = 0, judged = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        scene s = scene_draw(seed, false);
        scene_add_beams(&s);
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
    try_scenes();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(with_flexible_beams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
