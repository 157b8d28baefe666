/* Nothing of files returns MBSR_OK with a number that is not finite; wrong calls are refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <locale.h>
#include <math.h>

static const char hinge[] =
    "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1,5'/></inertial></link>"
    "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>";

static void options_are_checked(void **state)
{
    (void)state;
    mbsr_file *file;
    mbsr_error error;
    const double wrong[] = {NAN, INFINITY, -1.0};
    for (int field = 0; field < 4; ++field) {
        for (int k = 0; k < 3; ++k) {
            mbsr_file_opt opt = mbsr_default_file_opt();
            double *const place[] = {&opt.stop_stiffness, &opt.stop_damping, &opt.slip,
                                     opt.gravity + 1};
            *place[field] = wrong[k];
            if (field == 3 && k == 2) continue;
            assert_int_equal(mbsr_file_read("", 0, NULL, &opt, &file, &error), MBSR_ERR_VALUE);
            assert_contains(error.text, field == 3 ? "gravity" : field == 2 ? "slip" : "stop_");
        }
    }
    mbsr_file_opt opt = mbsr_default_file_opt();
    assert_int_equal(mbsr_file_read(NULL, 0, NULL, &opt, &file, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_read("", 0, NULL, &opt, NULL, &error), MBSR_ERR_NULL);
    opt.format = (mbsr_file_format)7;
    assert_int_equal(mbsr_file_read("", 0, NULL, &opt, &file, &error), MBSR_ERR_VALUE);
    opt.cookie = 0;
    assert_int_equal(mbsr_file_read("", 0, NULL, &opt, &file, NULL), MBSR_ERR_NO_DEFAULT);
}

static void options_of_xacro_are_checked(void **state)
{
    (void)state;
    static const char text[] = "<a/>";
    mbsr_file *file;
    mbsr_written *written;
    mbsr_error error;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.xacro.arguments = -1;
    assert_int_equal(mbsr_file_read(text, 4, NULL, &opt, &file, &error), MBSR_ERR_VALUE);
    assert_contains(error.text, "mbsr_file_read|opt.xacro.arguments");
    assert_int_equal(mbsr_file_expand_xacro(text, 4, NULL, &opt, &written, &error), MBSR_ERR_VALUE);
    assert_contains(error.text, "mbsr_file_expand_xacro|opt.xacro.arguments");
    opt.xacro.arguments = 1;
    assert_int_equal(mbsr_file_expand_xacro(text, 4, NULL, &opt, &written, &error), MBSR_ERR_NULL);
    opt.xacro.argument = &(mbsr_xacro_argument){"a", NULL};
    assert_int_equal(mbsr_file_expand_xacro(text, 4, NULL, &opt, &written, &error), MBSR_ERR_NULL);
    assert_null(written);
    assert_int_equal(mbsr_file_expand_xacro(text, 4, NULL, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_ok(mbsr_file_expand_xacro(text, 4, NULL, NULL, &written, &error), &error);
    assert_string_equal(written->text, "<a/>\n");
    mbsr_written_destroy(written);
}

static void states_are_checked(void **state)
{
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.floating = 1;
    mbsr_file *file = read_small("<robot name='r'><link name='a'/></robot>", &opt);
    double p[7] = {1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5}, v[6] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, q[7],
           u[6], back[7], rates[6];
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, v, q, u), MBSR_OK);
    assert_int_equal(mbsr_file_mujoco_state(file, 1, q, u, back, rates), MBSR_OK);
    for (int k = 0; k < 7; ++k) assert_close(back[k], p[k], 1e-15);
    for (int k = 0; k < 6; ++k) assert_close(rates[k], v[k], 1e-15);
    assert_int_equal(mbsr_file_mujoco_state(NULL, 0, p, v, q, u), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, v, q, NULL), MBSR_ERR_NULL);
    v[2] = NAN;
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, v, q, u), MBSR_NOT_FINITE);
    p[3] = p[4] = p[5] = p[6] = 0.0;
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, NULL, q, NULL), MBSR_ERR_VALUE);
    p[3] = INFINITY;
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, NULL, q, NULL), MBSR_NOT_FINITE);
    mbsr_file_destroy(file);
}

/* "1,5" is no number anywhere, 1.5 is one everywhere. */
static void the_locale_does_not_matter(void **state)
{
    static const char *const names[] = {"C", "de_DE.UTF-8", "de_DE.utf8"};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        if (!setlocale(LC_NUMERIC, names[k])) continue;
        assert_file_refused(hinge, NULL, "1,5");
        mbsr_file *file = read_small(
            "<robot name='r'><link name='a'><inertial><mass value='1.50000000000000000000001e0'/>"
            "</inertial></link></robot>",
            NULL);
        mbsr_file_destroy(file);
        static const char xacro[] = "<a xmlns:xacro='u' v='${1 / 4} ${round(2.675, 2)}'/>";
        mbsr_written *written;
        assert_ok(mbsr_file_expand_xacro(xacro, strlen(xacro), NULL, NULL, &written, NULL), NULL);
        assert_string_equal(written->text, "<a v=\"0.25 2.67\"/>\n");
        mbsr_written_destroy(written);
    }
    setlocale(LC_NUMERIC, "C");
}

static int no_defaults(void)
{
    return mbsr_default_file_opt().cookie == 0;
}

static int no_read(void)
{
    return mbsr_file_read(NULL, 0, NULL, NULL, NULL, NULL) == MBSR_OK;
}

static int no_destroy(void)
{
    mbsr_file_destroy(NULL);
    return 0;
}

static int no_model(void)
{
    return mbsr_file_take_model(NULL) != NULL;
}

static int no_joint(void)
{
    return mbsr_file_find_joint(NULL, "a") >= 0;
}

static int no_site(void)
{
    return mbsr_file_find_site(NULL, "a") >= 0;
}

static int no_actuator(void)
{
    return mbsr_file_find_actuator(NULL, "a") >= 0;
}

static int no_key(void)
{
    return mbsr_file_find_key(NULL, NULL) >= 0;
}

static int no_sensor(void)
{
    return mbsr_file_find_sensor(NULL, "a") >= 0;
}

static int no_state(void)
{
    double q = 0.0, u = 0.0;
    return mbsr_file_mujoco_state(NULL, 0, &q, &u, &q, &u) == MBSR_OK;
}

static int no_sense(void)
{
    static const char text[] =
        "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody><sensor>"
        "<jointpos joint='j'/><clock/></sensor></mujoco>";
    const double q = NAN, u = 0.0;
    double value[4];
    mbsr_file *file = read_small(text, NULL);
    mbsr_data *d;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    const int bad =
        mbsr_file_sense(file, 0, file->model, d, 0.0, &q, &u, value) != MBSR_NOT_FINITE ||
        mbsr_file_sense(file, 1, file->model, d, NAN, &u, &u, value) != MBSR_NOT_FINITE;
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
    return bad;
}

static int no_write_defaults(void)
{
    return mbsr_default_write_opt().cookie == 0;
}

static int no_text(void)
{
    mbsr_written *written;
    return mbsr_file_write_mjcf(NULL, NULL, NULL, &written, NULL) == MBSR_OK || written != NULL;
}

static int no_xacro(void)
{
    mbsr_written *written;
    return mbsr_file_expand_xacro(NULL, 0, NULL, NULL, &written, NULL) == MBSR_OK ||
           written != NULL;
}

static int no_written(void)
{
    mbsr_written_destroy(NULL);
    return 0;
}

static int no_triangles(void)
{
    return mbsr_mesh_triangles(NULL, 0, NULL, NULL, NULL, NULL) == MBSR_OK;
}

/* Functions of the component (tests/hygiene/finite.sh), each with what must not come of NULL. */
static const struct {
    const char *name;
    int (*comes)(void);
} calls[] = {
    {"mbsr_default_file_opt", no_defaults},
    {"mbsr_file_read", no_read},
    {"mbsr_file_destroy", no_destroy},
    {"mbsr_file_take_model", no_model},
    {"mbsr_file_find_joint", no_joint},
    {"mbsr_file_find_site", no_site},
    {"mbsr_file_find_actuator", no_actuator},
    {"mbsr_file_find_key", no_key},
    {"mbsr_file_find_sensor", no_sensor},
    {"mbsr_file_mujoco_state", no_state},
    {"mbsr_file_sense", no_sense},
    {"mbsr_default_write_opt", no_write_defaults},
    {"mbsr_file_write_mjcf", no_text},
    {"mbsr_written_destroy", no_written},
    {"mbsr_file_expand_xacro", no_xacro},
    {"mbsr_mesh_triangles", no_triangles},
};

static void nothing_comes_of_null(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof calls / sizeof *calls; ++k) {
        if (calls[k].comes()) fail_msg("%s makes something of NULL", calls[k].name);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_are_checked),   cmocka_unit_test(options_of_xacro_are_checked),
        cmocka_unit_test(states_are_checked),    cmocka_unit_test(the_locale_does_not_matter),
        cmocka_unit_test(nothing_comes_of_null),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
