/* Shapes that touch: each place of the core and of the component contact at which a status is taken
 * fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "faults.h"

#include "../contact/shapes.h"

static test_acts_scene state_of;
static long failed;

typedef struct asked {
    scene *scene;
    const test_acts *act;
} asked;

static int ask(void *user)
{
    asked *a = user;
    return a->act->act(&state_of);
}

static int is_reported(void *user)
{
    asked *a = user;
    enum { MOST = 40 };
    mbsr_contact_point point[MOST];
    int count = 0;
    int status = mbsr_stage_positions(a->scene->model, a->scene->data, 0.0, state_of.q);
    if (!status) status = mbsr_stage_velocities(a->scene->model, a->scene->data, state_of.u);
    if (!status)
        status = mbsr_contact_report(a->scene->model, a->scene->data, a->scene->force, MOST, point,
                                     &count);
    for (int k = 0; k < count && k < MOST && !status; ++k) state_of.out[k] = point[k].depth;
    return status;
}

static void of_shapes(void **state)
{
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_SPHERE,    MBSR_SHAPE_CAPSULE,
                                            MBSR_SHAPE_CYLINDER,  MBSR_SHAPE_BOX,
                                            MBSR_SHAPE_ELLIPSOID, MBSR_SHAPE_MESH};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    (void)state;
    for (int first = 0; first < KINDS; ++first) {
        for (int second = first; second < KINDS; ++second) {
            mbsr_shape shapes[3] = {sample_shape(kinds[first], 0), sample_shape(kinds[second], 0),
                                    sample_shape(MBSR_SHAPE_PLANE, MBSR_GROUND)};
            double q[14], u[12];
            uint64_t random = 7;
            scene s = scene_of(3, shapes);
            for (int k = 0; k < 14; ++k) q[k] = k % 7 < 4 ? draw(&random) : 0.06 * draw(&random);
            for (int k = 0; k < 12; ++k) u[k] = 0.2 * draw(&random);
            assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
            assert_ok(mbsr_normalise(s.model, s.data, q), mbsr_data_error(s.data));
            assert_true(test_acts_take(&state_of, s.model, s.data, 0.0, q, u));
            asked user = {&s, NULL};
            test_faults_act act = {"is reported",
                                   is_reported,
                                   &user,
                                   state_of.out,
                                   sizeof state_of.out / sizeof(double),
                                   1e-7,
                                   0};
            failed += test_faults_each(&act);
            for (const test_acts *a = test_acts_table; a->name; ++a) {
                if (strcmp(a->name, "has_small_masses") == 0) continue;
                if (strcmp(a->name, "is_stepped") == 0) continue; /* its substeps meet others */
                user.act = a, act.name = a->name, act.call = ask;
                failed += test_faults_each(&act);
            }
            end_scene(&s);
        }
    }
    assert_in_range(failed, 100, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_shapes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
