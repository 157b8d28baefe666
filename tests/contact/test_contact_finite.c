/* Nothing of contact returns MBSR_OK with a number that is not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

/* Every function of the header: those that take numbers refuse wrong ones in test_contact_points.c.
 */
static const char *const functions[] = {
    "mbsr_default_shape",  "mbsr_contacts_create",  "mbsr_contacts_destroy",
    "mbsr_contacts_add",   "mbsr_contacts_exclude", "mbsr_contacts_pair",
    "mbsr_contacts_force", "mbsr_contact_report",   "mbsr_contacts_add_file",
    "mbsr_contacts_join",  "mbsr_contacts_table",   "mbsr_contacts_definition",
    "mbsr_contacts_attach"};

/* States that overflow on the way give a status or finite numbers, and a good one then what it gave
 * before. */
static void reports(void **unused)
{
    (void)unused;
    static const double extreme[] = {1e100, -1e160, 1e200, 1e300, 1e-300, 1e-160};
    const double q[14] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0.05, 0.02, 0.29}, u[12] = {0.1, 0.2};
    for (int kind = MBSR_SHAPE_BOX; kind <= MBSR_SHAPE_MESH; ++kind) {
        if (kind == MBSR_SHAPE_CYLINDER || kind == MBSR_SHAPE_ELLIPSOID || kind == MBSR_SHAPE_PLANE)
            continue;
        const mbsr_shape shapes[2] = {sample_shape((mbsr_shape_kind)kind, 0),
                                      sample_shape((mbsr_shape_kind)kind, 0)};
        scene s = scene_of(2, shapes);
        mbsr_contact_point before[32] = {{0}}, after[32] = {{0}};
        const int count = points_at(&s, q, u, 32, before);
        for (int at = 0; at < 26; ++at) {
            for (int k = 0; k < 6; ++k) {
                double wrong_q[14], wrong_u[12];
                mbsr_contact_point point[32];
                int found;
                memcpy(wrong_q, q, sizeof q);
                memcpy(wrong_u, u, sizeof u);
                *(at < 14 ? wrong_q + at : wrong_u + (at - 14)) = extreme[k];
                int status = mbsr_stage_positions(s.model, s.data, 0.0, wrong_q);
                if (!status) status = mbsr_stage_velocities(s.model, s.data, wrong_u);
                if (!status)
                    status = mbsr_contact_report(s.model, s.data, s.force, 32, point, &found);
                if (status) {
                    assert_true(mbsr_data_error(s.data)->text[0]);
                    continue;
                }
                for (int l = 0; l < found && l < 32; ++l) {
                    for (int r = 0; r < 3; ++r)
                        assert_true(isfinite(point[l].point[r] + point[l].friction[r]));
                    assert_true(isfinite(point[l].depth + point[l].normal_force));
                }
            }
        }
        assert_int_equal(points_at(&s, q, u, 32, after), count);
        assert_memory_equal(before, after, sizeof before);
        int found;
        assert_int_equal(mbsr_contact_report(s.model, s.data, s.force + 1, 0, NULL, &found),
                         MBSR_ERR_ID);
        assert_int_equal(mbsr_contact_report(s.model, s.data, s.force, 0, NULL, NULL),
                         MBSR_ERR_NULL);
        assert_int_equal(mbsr_contact_report(NULL, s.data, s.force, 0, NULL, &found),
                         MBSR_ERR_NULL);
        end_scene(&s);
    }
    for (size_t k = 0; k < sizeof functions / sizeof functions[0]; ++k)
        assert_memory_equal(functions[k], "mbsr_", 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(reports)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
