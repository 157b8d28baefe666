/* What MJCF says and the model does not have, what it switches off, and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <stdio.h>

#define MUJOCO(inside) "<mujoco model='m'>\n" inside "</mujoco>\n"
#define WORLD(inside) MUJOCO("<worldbody>" inside "</worldbody>\n")

static void findings(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<compiler boundmass='1'/><option density='1'/><worldbody>"
               "<body name='b' gravcomp='1'><joint name='j'/><geom type='mesh' mesh='x'/></body>"
               "</worldbody><actuator><muscle name='m' joint='j'/>"
               "<motor name='f' joint='j' forcerange='-1 1'/></actuator>"),
        NULL);
    assert_found(file, "compiler", "boundmass");
    assert_found(file, "option", "fluid");
    assert_found(file, "geom", "mesh");
    assert_found(file, "muscle 'm'", "left out");
    assert_int_equal(file->findings, 4);
    mbsr_file_destroy(file);
}

static void more_findings(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<option><flag spring='disable'/></option>"
               "<deformable><flex name='x'/></deformable><extension/>"
               "<worldbody><body name='b' gravcomp='0.0'>"
               "<joint name='j' actuatorfrcrange='-1 1'/><camera/><light/>"
               "<geom name='g' size='1' shellinertia='true'/><bogus/></body></worldbody>"
               "<tendon><fixed name='t' range='0 1'><joint joint='j' coef='1'/></fixed></tendon>"
               "<equality><weld name='w' body1='b' torquescale='0'/>"
               "<weld name='v' body1='b' torquescale='0.5'/></equality>"),
        NULL);
    assert_found(file, "flag", "springs and dampers");
    assert_found(file, "deformable", "left out");
    assert_found(file, "geom 'g'", "solid|shell");
    assert_found(file, "bogus", "left out");
    assert_found(file, "fixed 't'", "limits");
    assert_found(file, "weld 'w'", "turn as well|torquescale");
    assert_int_equal(file->findings, 6);
    mbsr_file_destroy(file);
}

static void rare_findings(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<worldbody><body name='b' mocap='true'><geom name='g' size='1'/></body>"
               "<body name='c'><joint name='j' springdamper='1 1' solreflimit='-1 1'/>"
               "<geom name='h' size='1'/><site name='s'/><site name='t'/></body>"
               "<flexcomp name='cloth' type='grid'/><geom name='z' type='sdf'/>"
               "<composite prefix='w' type='cable' vertex='0 0 4 0 0 5 0 1 5' initial='free'>"
               "<plugin plugin='bend'/><geom type='box' size='1 .1 .1'/></composite></worldbody>"
               "<contact><pair geom1='g' geom2='x'/><pair name='q' geom1='g' geom2='h' "
               "friction='1 .5 .1'/><unknown/></contact>"
               "<tendon><spatial name='u' stiffness='2'><site site='s'/><pulley/><site site='t'/>"
               "</spatial></tendon><equality><flex name='e'/></equality>"),
        NULL);
    assert_found(file, "body 'b'", "mocap");
    assert_found(file, "joint 'j'", "springdamper");
    assert_found(file, "flexcomp 'cloth'", "soft body|'grid'");
    assert_found(file, "pair", "'x' is none of two shapes");
    assert_found(file, "pair 'q'", "first friction");
    assert_found(file, "unknown", "left out");
    assert_found(file, "spatial 'u'", "spring is left out");
    assert_found(file, "flex 'e'", "of this kind");
    assert_found(file, "geom 'z'", "'sdf' is left out");
    assert_found(file, "plugin", "'bend'");
    mbsr_file_destroy(file);
}

/* What holds a body of a soft flex is left out with it; a rigid flex has no bodies. */
static void bodies_of_a_flex(void **state)
{
#define HELD(rigid)                                                                                \
    MUJOCO("<worldbody><body name='b'><joint/><geom size='1'/></body>"                             \
           "<flexcomp name='cloth' type='grid' rigid='" rigid "'/></worldbody>"                    \
           "<equality><weld name='w' body1='b' body2='cloth_0'/></equality>")
    (void)state;
    mbsr_file *file = read_small(HELD("false"), NULL);
    assert_found(file, "weld 'w'", "left out with the soft body");
    mbsr_file_destroy(file);
    assert_file_refused(HELD("true"), NULL, "'cloth_0' is no body");
#undef HELD
}

/* Actuators with a state that only filters, ranges of tendons, tensors that MuJoCo would repair;
 * without any of them nothing is found. */
static void findings_of_actuators(void **state)
{
#define DRIVEN(compiler, actuators)                                                                \
    MUJOCO(compiler "<worldbody><body name='b'><joint name='j' range='-1 1' limited='true'/>"      \
                    "<geom size='1'/></body></worldbody>"                                          \
                    "<tendon><fixed name='t'><joint joint='j' coef='2'/></fixed></tendon>"         \
                    "<actuator>" actuators "</actuator>")
    (void)state;
    mbsr_file *file = read_small(DRIVEN("<compiler balanceinertia='true'/>",
                                        "<general name='a' joint='j' dyntype='filter' gainprm='3'/>"
                                        "<general name='c' joint='j' dyntype='none'/>"
                                        "<general name='d' joint='j' dyntype='integrator'/>"
                                        "<general name='e' joint='j' gaintype='muscle'/>"
                                        "<general name='f' joint='j' biastype='user'/>"
                                        "<position name='p' tendon='t' inheritrange='1'/>"),
                                 NULL);
    assert_found(file, "compiler", "balanceinertia");
    assert_found(file, "general 'a'", "acts at once|filter");
    assert_found(file, "general 'd'", "state of its own");
    assert_found(file, "general 'e'", "gain is not fixed");
    assert_found(file, "general 'f'", "bias is not affine");
    assert_found(file, "position 'p'", "not limited|range of its tendon");
    assert_int_equal(file->findings, 6);
    mbsr_file_destroy(file);
    file = read_small(DRIVEN("<compiler balanceinertia='false'/>",
                             "<general name='a' joint='j' dyntype='none' gainprm='3'/>"
                             "<position name='p' joint='j' inheritrange='1'/>"),
                      NULL);
    assert_int_equal(file->findings, 0);
    mbsr_file_destroy(file);
#undef DRIVEN
}

/* What a file switches off is not in its model. */
static void flags(void **state)
{
    static const char *const flag[] = {"gravity", "passive", "equality", "actuation"};
    (void)state;
    for (int k = 0; k < 4; ++k) {
        char text[600];
        snprintf(text, sizeof text,
                 MUJOCO("<option><flag %s='disable'/></option><worldbody><body name='b'>"
                        "<joint name='j' damping='2'/><geom size='1'/></body></worldbody>"
                        "<equality><joint joint1='j'/></equality>"
                        "<actuator><motor joint='j'/></actuator>"),
                 flag[k]);
        mbsr_file *file = read_small(text, NULL);
        assert_int_equal(file->findings, 0);
        assert_int_equal(file->actuators, 1);
        assert_int_equal(file->actuator[0].force == MBSR_NONE, k == 3);
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_int_equal(mbsr_model_closures(file->model), k == 2 ? 0 : 1);
        assert_int_equal(mbsr_model_forces(file->model), k == 2 ? 3 : 2);
        mbsr_file_destroy(file);
    }
}

/* meshdir, or assetdir; strippath. */
static void folders_of_meshes(void **state)
{
    static const char *const cases[][2] = {{"assetdir='a'", "a/x/m.stl"},
                                           {"assetdir='a' meshdir='b'", "b/x/m.stl"},
                                           {"meshdir='b' strippath='true'", "b/m.stl"}};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        char text[400];
        snprintf(text, sizeof text,
                 MUJOCO("<compiler %s/><asset><mesh name='m' file='x/m.stl'/></asset><worldbody>"
                        "<geom type='mesh' mesh='m'/></worldbody>"),
                 cases[k][0]);
        mbsr_file *file = read_small(text, NULL);
        assert_string_equal(file->shape[0].mesh, cases[k][1]);
        mbsr_file_destroy(file);
    }
}

/* The body b of this inertia, on a joint: has it a finding with these words, or none? */
static void assert_dropped(const char *joint, const char *inertial, const char *words)
{
    char text[600];
    snprintf(text, sizeof text, WORLD("<body name='b'>%s<inertial mass='2' %s/></body>"), joint,
             inertial);
    mbsr_file *file = read_small(text, NULL);
    if (file->findings != (words ? 1 : 0)) print_error("%s\n", text);
    assert_int_equal(file->findings, words ? 1 : 0);
    if (words) assert_found(file, "body 'b'", words);
    mbsr_file_destroy(file);
}

/* Principal axes and centres that MuJoCo 3.14 takes for those of the body, as its M has them. */
static void frames_that_mujoco_drops(void **state)
{
    static const struct {
        const char *inertial, *words;
    } cases[] = {
        {"pos='0 0 0' fullinertia='3 2 1.5 3e-7 0 0'", "products|MuJoCo|1e-07"},
        {"pos='0 0 0' fullinertia='3 2 1.5 0 0 -6e-8'", "products|MuJoCo|2e-08"},
        {"pos='0 0 0' fullinertia='3 2 1.5 3e-6 0 0'", NULL},
        {"pos='0 0 0' fullinertia='3 2 1.5 1e-15 0 0'", NULL},
        {"pos='0 0 5e-7' diaginertia='3 2 1.5'", "centre|5e-07 m|MuJoCo"},
        {"pos='0 -9e-7 0' diaginertia='3 2 1.5'", "centre|9e-07 m|MuJoCo"},
        {"pos='0 0 2e-6' diaginertia='3 2 1.5'", NULL},
        {"pos='0 0 1e-17' diaginertia='3 2 1.5'", NULL},
        {"pos='0 0 5e-7' quat='1 0 0 5e-6' diaginertia='3 2 1.5'", NULL},
        {"pos='0 0 0' quat='1 0 0 5e-7' diaginertia='3 2 1.5'", "products|MuJoCo"},
        {"pos='0 0 0' quat='-1 0 0 5e-7' diaginertia='3 2 1.5'", "products|MuJoCo"},
        {"pos='0 0 5e-7' quat='1 0 0 5e-7' diaginertia='2 2 1.5'", "centre"},
        {"pos='0 0 0' quat='1 0 0 5e-7' diaginertia='2 2 1.5'", NULL},
        {"pos='0 0 5e-7' quat='0 0 0 1' diaginertia='2 2 1.5'", NULL},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        assert_dropped("<joint/>", cases[k].inertial, cases[k].words);
        assert_dropped("<freejoint/>", cases[k].inertial, cases[k].words);
        assert_dropped("<freejoint align='true'/>", cases[k].inertial, NULL);
    }
}

/* A block whose cross section is no rectangle by some units of the last place of 32-bit numbers:
 * of products of inertia of a mesh MuJoCo keeps what is above 1e-7 of the largest moment. */
static void products_of_meshes(void **state)
{
    static const double scale[] = {1.0, 0.01, 0.001};
    (void)state;
    for (int k = 0; k < 6; ++k) {
        const double s = scale[k / 2], skew = (k % 2 ? 12 : 8) * 1.1920928955078125e-7;
        char text[3000];
        int at = snprintf(text, sizeof text, "<mujoco><asset><mesh name='m' vertex='");
        for (int l = 0; l < 8; ++l) {
            const int x = l & 1 ? 1 : -1, y = l & 2 ? 1 : -1, z = l & 4 ? 1 : -1;
            at += snprintf(text + at, sizeof text - (size_t)at, "%.9g %.9g %.9g ",
                           s * x * (1.0 + 0.5 * x * y * skew), s * 2 * y, s * 3 * z);
        }
        snprintf(text + at, sizeof text - (size_t)at,
                 "'/></asset><worldbody><body><joint/><geom type='mesh' mesh='m' pos='1 0 0' "
                 "euler='30 40 50'/></body></worldbody></mujoco>");
        mbsr_file *file = read_small(text, NULL);
        assert_int_equal(file->findings, k % 2 ? 0 : 1);
        if (k % 2 == 0) assert_found(file, "mesh 'm'", "products|MuJoCo|e-08");
        mbsr_file_destroy(file);
    }
}

#define FIELD(samples)                                                                             \
    MUJOCO("<asset><hfield name='h' size='1 1 1 1' " samples                                       \
           "/></asset><worldbody><geom type='hfield' hfield='h'/></worldbody>")
#define CABLE(points)                                                                              \
    WORLD("<composite type='cable' " points "><geom type='capsule' size='.1'/></composite>")
#define TWO(rest)                                                                                  \
    MUJOCO("<worldbody><body name='b'><joint name='j'/><geom name='g' size='1'/></body>"           \
           "<body name='c'><geom name='h' size='1'/></body></worldbody>" rest)

static void refused_files(void **state)
{
    static const struct {
        const char *text, *words;
    } cases[] = {
        {WORLD("<joint/>"), "small.xml:2|joint|world"},
        {WORLD("<body><joint name='j' type='gluey'/></body>"), "joint 'j'|gluey"},
        {WORLD("<body><joint axis='0 0 0'/></body>"), "axis"},
        {WORLD("<body><joint armature='-1'/></body>"), "armature"},
        {WORLD("<body><joint class='c'/></body>"), "no class 'c'"},
        {WORLD("<body><joint/><freejoint/></body>"), "freejoint|alone"},
        {WORLD("<body><body><freejoint/></body></body>"), "freejoint|world"},
        {WORLD("<body name='a'/><body name='a'/>"), "body 'a'|two"},
        {WORLD("<body quat='0 0 0 0'/>"), "quat"},
        {WORLD("<body quat='1 0 0 0' euler='0 0 0'/>"), "two orientations"},
        {WORLD("<body pos='1 2'/>"), "3 numbers"},
        {WORLD("<body pos='1 2 nan'/>"), "nan"},
        {WORLD("<body><inertial pos='0 0 0' mass='-1'/></body>"), "mass"},
        {WORLD("<body><geom type='box' size='1 1'/></body>"), "size"},
        {MUJOCO("<compiler coordinate='global'/>"), "global"},
        {MUJOCO("<compiler eulerseq='abc'/>"), "eulerseq"},
        {MUJOCO("<equality><connect body1='x' anchor='0 0 0'/></equality>"), "'x' is no body"},
        {MUJOCO("<equality><joint joint1='x'/></equality>"), "'x' is no joint"},
        {MUJOCO("<actuator><motor joint='x'/></actuator>"), "motor|'x'"},
        {WORLD("<body><inertial pos='0 0 0' mass='1' diaginertia='1 1 1' "
               "fullinertia='1 1 1 0 0 0'/></body>"),
         "two tensors"},
        {MUJOCO("<worldbody><body><joint name='j'/><geom size='1'/></body></worldbody>"
                "<equality><joint joint1='j' joint2='j'/></equality>"),
         "both its joints are the same"},
        {MUJOCO("<worldbody><body><joint name='j' type='ball'/><geom size='1'/></body></worldbody>"
                "<equality><joint joint1='j'/></equality>"),
         "'j' has not one axis"},
        {MUJOCO("<keyframe><key qpos='1 2'/></keyframe>"), "key|qpos"},
        {MUJOCO("<asset><hfield name='h' nrow='2' ncol='2' size='1 0 1 1'/></asset><worldbody>"
                "<geom type='hfield' hfield='h'/></worldbody>"),
         "hfield 'h'|four positive"},
        {FIELD("nrow='2.5' ncol='2'"), "nrow is 2.5"},
        {FIELD("nrow='2' ncol='1'"), "ncol is 1"},
        {FIELD("nrow='2' ncol='9999999'"), "ncol is 1e+07"},
        {FIELD("nrow='2' ncol='2' elevation='0 1'"), "numbers, 4"},
        {WORLD("<geom type='hfield' hfield='x'/>"), "no hfield 'x'"},
        {WORLD("<geom type='gluey' size='1'/>"), "no type 'gluey'"},
        {WORLD("<geom size='1' mass='-1'/>"), "negative"},
        {WORLD("<geom size='1' density='-1'/>"), "negative"},
        {WORLD("<geom size='1' margin='-1'/>"), "margin is negative"},
        {WORLD("<geom type='box' size='1' fromto='0 0 0 0 0 0'/>"), "no length"},
        {WORLD("<geom type='capsule' fromto='0 0 0 0 0 1'/>"), "no size"},
        {MUJOCO("<asset><mesh name='m' refquat='0 0 0 0'/></asset>"), "refquat"},
        {TWO("<contact><pair geom1='g' geom2='h' margin='-1'/></contact>"), "margin is negative"},
        {TWO("<equality><connect body1='b' body2='c'/></equality>"), "no anchor"},
        {TWO("<equality><weld body1='b' body2='b'/></equality>"), "are the same"},
        {TWO("<equality><weld body1='b' body2='x'/></equality>"), "'x' is no body"},
        {TWO("<equality><connect site1='x' site2='x'/></equality>"), "'x' is no site"},
        {TWO("<actuator><position joint='j' kv='1' dampratio='1'/></actuator>"), "both kv and"},
        {TWO("<actuator><position joint='j' dampratio='-1'/></actuator>"), "dampratio|negative"},
        {TWO("<actuator><motor site='x'/></actuator>"), "'x' is no site"},
        {TWO("<actuator><motor joint='j' ctrlrange='1 -1' ctrllimited='true'/></actuator>"),
         "no range"},
        {WORLD("<composite type='grid'/>"), "type 'grid'"},
        {CABLE("vertex='0 0 x'"), "not numbers alone"},
        {CABLE("vertex='0 0 0'"), "2 to"},
        {CABLE("vertex='0 0 0 1 1'"), "2 to"},
        {CABLE("count='1 1 1'"), "from 2 to"},
        {CABLE("count='3 2 1'"), "one direction"},
        {CABLE("count='3 1 2'"), "one direction"},
        {CABLE("count='3 1 1' curve='x'"), "no curve"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k)
        assert_file_refused(cases[k].text, NULL, cases[k].words);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(findings),
        cmocka_unit_test(more_findings),
        cmocka_unit_test(rare_findings),
        cmocka_unit_test(bodies_of_a_flex),
        cmocka_unit_test(findings_of_actuators),
        cmocka_unit_test(flags),
        cmocka_unit_test(folders_of_meshes),
        cmocka_unit_test(refused_files),
        cmocka_unit_test(frames_that_mujoco_drops),
        cmocka_unit_test(products_of_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
