/* Shapes that touch: each place of the core and of the component contact at which a status is taken
 * fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "faults.h"

#include "../contact/shapes.h"

#ifdef TEST_WITH_FILES
#include <mbsrank/files.h>
#endif

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

#ifdef TEST_WITH_FILES
static const char in_a_file[] =
    "<mujoco><worldbody><geom type='plane' size='0 0 1' pos='0 0 -.1'/>"
    "<body name='a'><freejoint/><geom type='box' size='.1 .1 .1' mass='1'/></body>"
    "<body name='b' pos='.15 0 0'><freejoint/><geom type='sphere' size='.1' mass='1'/></body>"
    "<body name='rod' pos='3 0 0'><joint type='slide' axis='1 0 0'/>"
    "<geom name='g' type='capsule' size='.05 .1' mass='2'/></body></worldbody>"
    "<contact><exclude body1='a' body2='rod'/></contact></mujoco>";

static int is_attached(void *user)
{
    mbsr_file *file = NULL;
    mbsr_touching t = {.model = NULL};
    mbsr_data *d = NULL;
    (void)user;
    int status = mbsr_file_read(in_a_file, sizeof in_a_file - 1, "a.xml", NULL, &file, NULL);
    if (!status) status = mbsr_model_finish(file->model);
    if (!status) status = mbsr_contacts_attach(file, NULL, file->model, file->q0, 0.0, &t, NULL);
    if (!status) status = mbsr_data_create(t.model, &d, NULL);
    if (!status) state_of.out[0] = t.told.shapes, state_of.out[1] = t.shapes;
    mbsr_data_destroy(d);
    mbsr_model_destroy(t.model);
    mbsr_contacts_destroy(t.contacts);
    mbsr_file_destroy(file);
    return status;
}

static void of_a_file(void **state)
{
    const test_faults_act act = {"is attached", is_attached, NULL, state_of.out, 8, 1e-9, 0};
    (void)state;
    assert_in_range(test_faults_each(&act), 20, 100000);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef TEST_WITH_FILES
        cmocka_unit_test(of_a_file),
#endif
        cmocka_unit_test(of_shapes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
