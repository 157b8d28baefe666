/* Shapes of files that touch: what is added, what never touches, what stands.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <mbsrank/files.h>
#include <mbsrank/simulation.h>

static mbsr_file *read(const char *text)
{
    mbsr_file *file;
    mbsr_error error;
    if (mbsr_file_read(text, strlen(text), "small.xml", NULL, &file, &error))
        fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_finish(file->model), MBSR_OK);
    return file;
}

/* The model of a file with the element. */
static mbsr_model *touching_model(const mbsr_file *file, mbsr_contacts **contacts, int *force,
                                  mbsr_contacts_of_file *told)
{
    mbsr_error error;
    mbsr_force_def def;
    mbsr_model *m;
    assert_int_equal(mbsr_contacts_create(contacts, &error), MBSR_OK);
    if (mbsr_contacts_add_file(*contacts, file, file->model, 0.0, told, &error))
        fail_msg("%s", error.text);
    if (mbsr_contacts_force(*contacts, 0, &def, &error)) fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_copy(file->model, &m, &error), MBSR_OK);
    assert_int_equal(mbsr_model_add_force(m, &def, force), MBSR_OK);
    if (mbsr_model_finish(m)) fail_msg("%s", mbsr_model_error(m)->text);
    return m;
}

/* A quadruped with spheres for feet stands: the floor carries its weight. */
static const char stands[] =
    "<mujoco><option gravity='0 0 -9.81'/><worldbody><geom type='plane' size='0 0 1'/>"
    "<body name='trunk' pos='0 0 0.4'><freejoint/><geom type='box' size='.3 .15 .05' mass='8'/>"
    "<body name='a' pos='.25 .15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='b' pos='.25 -.15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='c' pos='-.25 .15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='d' pos='-.25 -.15 0'><joint type='hinge' axis='0 1 0' stiffness='200' "
    "damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "</body></worldbody></mujoco>";

static void quadruped(void **unused)
{
    (void)unused;
    mbsr_file *file = read(stands);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_int_equal(told.shapes, 10);
    assert_int_equal(told.left_out, 0);
    mbsr_simulation s = mbsr_simulation_of(m);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-5;
    double u[10] = {0};
    if (mbsr_simulation_start(&s, &opt, 0.0, file->q0, u)) fail_msg("%s", s.error.text);
    if (mbsr_simulation_to(&s, 3.0)) fail_msg("%s", s.error.text);
    mbsr_contact_point point[32];
    if (mbsr_contact_report(s.model, s.data, force, 32, point, &count))
        fail_msg("%s", mbsr_data_error(s.data)->text);
    double weight = 0.0;
    for (int k = 0; k < count; ++k) weight += point[k].normal_force;
    assert_int_equal(count, 4);
    assert_close(weight, (8.0 + 4 * 0.6) * 9.81, 1e-2);
    assert_true(mbsr_simulation_q(&s)[6] > 0.38 && mbsr_simulation_q(&s)[6] < 0.401);
    mbsr_simulation_end(&s);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
}

/* Excluded bodies, groups. */
static const char parts[] =
    "<mujoco><worldbody>"
    "<body name='a'><freejoint/><geom name='x' type='sphere' size='.1' mass='1' contype='2' "
    "conaffinity='0' friction='.7' condim='3'/></body>"
    "<body name='b' pos='.15 0 0'><freejoint/><geom name='y' type='sphere' size='.1' mass='1' "
    "contype='0' conaffinity='2'/></body>"
    "<body name='c' pos='0 .15 0'><freejoint/><geom name='z' type='ellipsoid' size='.1 .1 .2' "
    "mass='1' contype='0' conaffinity='2'/></body>"
    "<body name='d' pos='0 0 .15'><freejoint/><geom type='sphere' size='.1' mass='1' "
    "contype='0' conaffinity='2'/></body>"
    "</worldbody><contact><exclude body1='a' body2='d'/></contact></mujoco>";

static void groups(void **unused)
{
    (void)unused;
    mbsr_file *file = read(parts);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    mbsr_error error;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_int_equal(told.shapes, 4);
    mbsr_data *d;
    assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, (double[24]){0.0, 0.0, 0.0, 0.01}), MBSR_OK);
    mbsr_contact_point point[4];
    assert_int_equal(mbsr_contact_report(m, d, force, 4, point, &count), MBSR_OK);
    assert_int_equal(count, 2); /* not d, which is excluded, nor y with z and d by their groups */
    assert_int_equal(point[1].shape_b, 2);
    assert_close(point[1].depth, 0.05, 1e-12);
    assert_close(point[0].depth, 0.05, 1e-12);
    assert_true(fabs(point[0].friction[0]) < 1e-12 && point[0].normal_force > 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
}

static void refusals(void **unused)
{
    (void)unused;
    mbsr_file *file = read(parts);
    mbsr_contacts *c;
    mbsr_error error;
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add_file(NULL, file, file->model, 0.0, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, NULL, file->model, 0.0, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, file, NULL, 0.0, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, file, file->model, -1.0, NULL, &error),
                     MBSR_ERR_VALUE);
    assert_int_equal(mbsr_contacts_add_file(c, file, file->model, NAN, NULL, &error),
                     MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "stiffness is nan"));
    mbsr_contacts_destroy(c);
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(quadruped), cmocka_unit_test(groups),
                                       cmocka_unit_test(refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
