/* SDF beside the same models in MJCF: poses in all their ways, joints, loops, included and nested
 * models.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "alike.h"

#include <stdbool.h>
#include <stdio.h>

#define SDF(inside) "<sdf version='1.9'>" inside "</sdf>"
#define MODEL(inside) SDF("<model name='m'>" inside "</model>")
#define MUJOCO(inside)                                                                             \
    "<mujoco><compiler angle='radian' eulerseq='XYZ'/><worldbody>" inside "</worldbody></mujoco>"
#define HEAVY                                                                                      \
    "<inertial><pose>.1 .2 .3 0 0 .4</pose><mass>2</mass><inertia><ixx>.5</ixx><iyy>.6</iyy>"      \
    "<izz>.7</izz><ixy>.01</ixy><ixz>.02</ixz><iyz>.03</iyz></inertia></inertial>"
/* the same */
#define HEAVY_TOO                                                                                  \
    "<body pos='.1 .2 .3' euler='0 0 .4'><inertial pos='0 0 0' mass='2' "                          \
    "fullinertia='.5 .6 .7 .01 .02 .03'/></body>"
#define LINK(name, pose) "<link name='" name "'><pose>" pose "</pose>" HEAVY "</link>"

static mbsr_file *read_clean(const char *text, const mbsr_file_opt *opt)
{
    mbsr_file *file = read_small(text, opt);
    for (int k = 0; k < file->findings; ++k)
        print_error("%s: %s\n", file->finding[k].element, file->finding[k].text);
    assert_int_equal(file->findings, 0);
    return file;
}

static void assert_same(const char *sdf, const mbsr_file_opt *opt, const char *other)
{
    mbsr_file *a = read_clean(sdf, opt), *b = read_clean(other, NULL);
    assert_int_equal(a->format, MBSR_FILE_SDF);
    assert_alike(a, b);
    mbsr_file_destroy(a);
    mbsr_file_destroy(b);
}

/* Frames on frames, on joints and on links, in angles, degrees and quaternions. */
static void poses_relative_to_each_other(void **state)
{
    (void)state;
    assert_same(
        MODEL("<pose>1 2 3 .1 .2 .3</pose>"
              "<link name='c'><pose relative_to='j'>.4 .5 .6 0 0 0</pose>" HEAVY "</link>"
              "<link name='b'><pose relative_to='g'>.3 .2 .1 .6 .5 .4</pose>" HEAVY "</link>"
              "<frame name='g'><pose relative_to='f' degrees='true'>.1 0 0 30 60 0</pose></frame>"
              "<frame name='f' attached_to='a'><pose>0 .5 0 0 .7 0</pose></frame>"
              "<link name='a'>" HEAVY "</link>"
              "<joint name='j' type='revolute'><pose>.1 0 0 .3 0 0</pose><parent>f</parent>"
              "<child>b</child><axis><xyz>1 2 3</xyz><dynamics><damping>.1</damping>"
              "<spring_stiffness>3</spring_stiffness><spring_reference>.2</spring_reference>"
              "</dynamics></axis></joint>"
              "<joint name='k' type='prismatic'><pose rotation_format='quat_xyzw'>.2 .3 .4 .5 .5 "
              "-.5 .5</pose><parent>b</parent><child>c</child><axis>"
              "<xyz expressed_in='j'>0 1 1</xyz></axis></joint>"
              "<joint name='l' type='revolute'><pose rotation_format='quat_xyzw'>.2 .3 .4 .5 .5 "
              "-.5 .5</pose><parent>c</parent><child>d</child><axis><xyz>1 2 0</xyz></axis></joint>"
              "<link name='d'><pose relative_to='c'/>" HEAVY "</link>"),
        NULL,
        MUJOCO("<frame pos='1 2 3' euler='.1 .2 .3'><body><freejoint/>" HEAVY_TOO
               "<frame pos='0 .5 0' euler='0 .7 0'><frame pos='.1 0 0' euler='0.5235987755982988 "
               "1.0471975511965976 0'>"
               "<body pos='.3 .2 .1' euler='.6 .5 .4'><frame pos='.1 0 0' euler='.3 0 0'>"
               "<joint axis='1 2 3' damping='.1' stiffness='3' springref='.2'/>"
               "<body pos='.4 .5 .6'><joint type='slide' axis='0 1 1'/>" HEAVY_TOO
               "<body><frame pos='.2 .3 .4' quat='.5 .5 .5 -.5'><joint axis='1 2 "
               "0'/></frame>" HEAVY_TOO "</body></body></frame>" HEAVY_TOO
               "</body></frame></frame></body></frame>"));
}

/* In the order of the joints: depth first. */
static void joints_of_all_kinds(void **state)
{
    (void)state;
    assert_same(
        MODEL(
            LINK("a", "0 0 1 0 0 0") LINK("b", "0 1 1 .2 0 0") LINK("c", "0 2 1 0 .3 0")
                LINK("d", "0 3 1 0 0 .4") LINK("e", "0 0 0 0 0 0") LINK(
                    "f",
                    "1 0 0 0 0 0") "<joint name='w' "
                                   "type='fixed'><parent>world</parent><child>a</child></joint>"
                                   "<joint name='u' "
                                   "type='universal'><parent>a</parent><child>b</"
                                   "child><axis><xyz>1 0 "
                                   "0</xyz></axis><axis2><xyz>0 1 "
                                   "0</xyz><dynamics><damping>.3</damping></dynamics>"
                                   "</axis2></joint>"
                                   "<joint name='r' "
                                   "type='revolute2'><parent>b</parent><child>c</"
                                   "child><axis><xyz>0 0 "
                                   "1</xyz></axis><axis2><xyz>0 1 1</xyz></axis2></joint>"
                                   "<joint name='p' type='ball'><pose>.1 .2 .3 0 0 "
                                   "0</pose><parent>c</parent>"
                                   "<child>d</child></joint>"
                                   "<joint name='n' "
                                   "type='continuous'><parent>world</parent><child>e</child><axis>"
                                   "<xyz>0 1 0</xyz></axis></joint>"),
        NULL,
        MUJOCO("<body pos='0 0 1'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
               "<body pos='0 1 0' euler='.2 0 0'><joint axis='1 0 0'/><joint axis='0 1 0' "
               "damping='.3'/>" HEAVY_TOO
               "<frame euler='-.2 0 0'><body pos='0 1 0' euler='0 .3 0'><joint/><joint axis='0 1 "
               "1'/>" HEAVY_TOO
               "<frame euler='0 -.3 0'><body pos='0 1 0' euler='0 0 .4'><joint type='ball' "
               "pos='.1 .2 .3'/>" HEAVY_TOO "</body></frame></body></frame></body></body>"
               "<body><joint axis='0 1 0'/>" HEAVY_TOO "</body>"
               "<body pos='1 0 0'><freejoint/>" HEAVY_TOO "</body>"));
}

/* A mass m on a screw: (I + m p^2) q'' + p m g. */
static void a_screw(void **state)
{
    static const char *const pitches[2] = {
        "<screw_thread_pitch>0.6283185307179586</screw_thread_pitch>",
        "<thread_pitch>-10</thread_pitch>"};
    char text[900];
    (void)state;
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        const double zero = 0.0, one = 1.0;
        double tau;
        snprintf(text, sizeof text,
                 MODEL("<link name='a'><inertial><mass>3</mass><inertia><izz>2</izz></inertia>"
                       "</inertial></link><joint name='s' type='screw'>%s<parent>world</parent>"
                       "<child>a</child><axis><xyz>0 0 1</xyz></axis></joint>"),
                 pitches[k]);
        mbsr_file *file = read_clean(text, NULL);
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
        assert_ok(mbsr_inverse_dynamics(file->model, d, 0.0, &zero, &one, &one, NULL, &tau),
                  mbsr_data_error(d));
        assert_close(tau, 2.0 + 3.0 * 0.01 + 0.1 * 3.0 * 9.81, 1e-13);
        mbsr_data_destroy(d);
        mbsr_file_destroy(file);
    }
}

/* ---- versions ---- */

#define TURNED                                                                                     \
    "<model name='m'>" LINK(                                                                       \
        "a", "1 0 0 .4 .5 .6") "<joint name='j' type='universal'>"                                 \
                               "<parent>world</parent><child>a</child><axis><xyz>1 2 "             \
                               "3</xyz></axis><axis2><xyz>0 1 0</xyz>"                             \
                               "%s</axis2></joint></model>"

/* Before 1.5 axes are along the model's, unless they say otherwise; before 1.6 gravity is of the
 * physics. */
static void what_old_versions_say(void **state)
{
    static const struct {
        const char *begin, *end, *second;
        double gravity;
        bool along_model, both;
    } cases[] = {
        {"<gazebo version='1.2'><world name='w'><physics><gravity>0 0 0</gravity></physics>",
         "</world></gazebo>", "", 0.0, true, true},
        {"<sdf version='1.4'><world name='w'><physics><gravity>0 0 -1</gravity></physics>",
         "</world></sdf>", "<use_parent_model_frame>0</use_parent_model_frame>", -1.0, true, false},
        {"<sdf version='1.5'><world name='w'><physics><gravity>0 0 -2</gravity></physics>",
         "</world></sdf>", "<use_parent_model_frame>True</use_parent_model_frame>", -2.0, false,
         true},
        {"<sdf version='1.6'><world name='w'><gravity>0 0 -3</gravity><physics><gravity>0 0 -2"
         "</gravity></physics>",
         "</world></sdf>", "", -3.0, false, false},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        char text[2000], other[2000];
        snprintf(text, sizeof text, "%s" TURNED "%s", cases[k].begin, cases[k].second,
                 cases[k].end);
        snprintf(other, sizeof other,
                 SDF("<world name='w'><gravity>0 0 %g</gravity><model name='m'>" LINK(
                     "a", "1 0 0 .4 .5 .6") "<joint name='j' type='universal'><parent>world"
                                            "</parent><child>a</child><axis><xyz expressed_in='%s'>"
                                            "1 2 3</xyz></axis><axis2><xyz expressed_in='%s'>0 1 0"
                                            "</xyz></axis2></joint></model></world>"),
                 cases[k].gravity, cases[k].along_model ? "__model__" : "",
                 cases[k].both ? "__model__" : "");
        assert_same(text, NULL, other);
    }
}

/* A joint may have a link's name, and a coefficient of friction may say nothing. */
static void names_and_numbers_of_old_versions(void **state)
{
    static const char text[] =
        "<sdf version='1.6'><model name='m'><joint name='a' type='revolute'><parent>b</parent>"
        "<child>a</child><axis><xyz>0 0 1</xyz></axis></joint><link name='a'><collision name='c'>"
        "<geometry><sphere><radius>1</radius></sphere></geometry><surface><friction><ode><mu>-1"
        "</mu></ode></friction></surface></collision></link><link name='b'/></model></sdf>";
    mbsr_file *file = read_small(text, NULL);
    (void)state;
    assert_found(file, "joint 'a'", "its name is taken");
    assert_found(file, "collision 'c'", "1 is taken");
    int named = 0;
    for (int k = 0; k < file->joints; ++k) named += strcmp(file->joint[k].name, "a_joint") == 0;
    assert_int_equal(named, 1);
    assert_close(file->shape[0].friction[0], 1.0, 0.0);
    mbsr_file_destroy(file);
}

/* ---- models in models ---- */

static const char arm[] =
    MODEL("<frame name='grip' attached_to='l'><pose>0 0 .5 .1 .2 .3</pose></frame>" LINK(
        "l", ".1 0 0 0 0 0"));
static const char config[] =
    "<model><sdf version='1.9'>arm.sdf</sdf><sdf version='1.4'>old.sdf</sdf></model>";

static int load(void *user, const char *path, const char **text, size_t *size)
{
    (void)user;
    *text = strcmp(path, "arm/model.config") == 0 ? config : arm;
    *size = strlen(*text);
    return strcmp(path, "arm/arm.sdf") != 0 && strcmp(path, "arm/model.config") != 0 &&
           strcmp(path, "known/arm/arm.sdf") != 0;
}

static void worlds_of_models(void **state)
{
    static const mbsr_file_package package = {"arm", "known/arm"};
    mbsr_file_opt opt = mbsr_default_file_opt();
    (void)state;
    opt.load = load;
    for (int k = 0; k < 2; ++k) {
        const char *uri = k == 0 ? "model://arm" : "model://arm/arm.sdf";
        char text[2000];
        opt.packages = k;
        opt.package = &package;
        snprintf(
            text, sizeof text,
            SDF("<world name='w'><gravity>0 1 -2</gravity><light name='sun'/>"
                "<include><uri>%s</uri><name>left</name><pose>1 0 0 0 0 .5</pose>"
                "<placement_frame>grip</placement_frame></include>"
                "<model name='table'><static>true</static>" LINK(
                    "top", "0 0 1 0 0 0") "</model><model name='outer'><pose>0 3 0 0 0 "
                                          "0</pose>"
                                          "<model name='inner'><pose>0 0 .1 .2 0 "
                                          "0</pose>" LINK("l", "0 .2 0 0 0 0") "</model>" LINK(
                                              "k", "0 0 0 0 0 0") "<joint name='j' "
                                                                  "type='revolute'><parent>k</"
                                                                  "parent><child>inner::l</"
                                                                  "child><axis>"
                                                                  "<xyz expressed_in='inner'>0 1 "
                                                                  "0</xyz></axis></joint></model></"
                                                                  "world>"),
            uri);
        mbsr_file *file = read_clean(text, &opt);
        assert_int_equal(file->bodies, 4);
        assert_string_equal(file->body_name[0], "left::l");
        assert_string_equal(file->joint[2].name, "outer::j");
        assert_int_equal(file->joint[0].kind, MBSR_FILE_FREE);
        mbsr_file *other = read_clean(
            "<mujoco><compiler angle='radian' eulerseq='XYZ'/><option gravity='0 1 "
            "-2'/><worldbody><body><freejoint/>" HEAVY_TOO "</body>"
            "<body pos='0 3 0'><freejoint/>" HEAVY_TOO "<frame pos='0 0 .1' euler='.2 0 0'>"
            "<body pos='0 .2 0'><joint axis='0 1 0'/>" HEAVY_TOO "</body></frame></body>"
            "</worldbody></mujoco>",
            NULL);
        assert_alike(file, other);
        /* the grip of the left arm is where the pose says: T T_grip^-1 of the model */
        const mbsr_frame placed =
            mbsr_frame_rotated((double[3]){1.0, 0.0, 0.0}, (double[3]){0.0, 0.0, 1.0}, 0.5);
        mbsr_frame grip = mbsr_frame_at(0.1, 0.0, 0.5);
        for (int axis = 2; axis >= 0; --axis) {
            double along[3] = {0.0};
            along[axis] = 1.0;
            const mbsr_frame turn = mbsr_frame_rotated(NULL, along, 0.1 * (axis + 1));
            grip = mbsr_frame_product(&grip, &turn);
        }
        const mbsr_frame link = mbsr_frame_at(0.1, 0.0, 0.0), back = mbsr_frame_inverse(&grip);
        mbsr_frame expected = mbsr_frame_product(&placed, &back);
        expected = mbsr_frame_product(&expected, &link);
        for (int l = 0; l < 3; ++l) assert_close(file->q0[4 + l], expected.x[l], 1e-14);
        mbsr_file_destroy(file);
        mbsr_file_destroy(other);
    }
}

/* ---- loops ---- */

/* Accelerations of the tree's joints of a four-bar, whatever closes it. */
static void assert_closed(const char *text, int bodies, int rows, const double *expected)
{
    mbsr_file *file = read_clean(text, NULL);
    mbsr_data *d;
    double gap[12], udot[8], u[8] = {0.0};
    assert_int_equal(file->bodies, bodies);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_int_equal(mbsr_model_position_rows(file->model), rows);
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    assert_ok(mbsr_closures_gap(file->model, d, gap), mbsr_data_error(d));
    for (int k = 0; k < rows; ++k) assert_close(gap[k], 0.0, 1e-15);
    assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, file->q0, u, NULL, udot),
              mbsr_data_error(d));
    for (int k = 0; k < 3; ++k) {
        const char name[2] = {"ijk"[k], '\0'};
        assert_close(udot[mbsr_file_find_joint(file, name)], expected[k], 1e-9);
    }
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

#define BAR(name, pose)                                                                            \
    "<link name='" name "'><pose>" pose "</pose><inertial><pose>.5 0 0 0 0 0</pose><mass>1</mass>" \
    "<inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1</izz></inertia></inertial></link>"
#define HINGE(name, parent, child, pose)                                                           \
    "<joint name='" name "' type='revolute'><pose>" pose "</pose><parent>" parent                  \
    "</parent><child>" child "</child><axis><xyz>0 1 0</xyz></axis></joint>"
#define FOUR_BAR(last)                                                                             \
    MODEL(BAR("a", "0 0 0 0 0 0") BAR("b", "1 0 0 0 -1 0") BAR("c", "3 0 0 0 -2.5 0")              \
              HINGE("i", "world", "a", "0 0 0 0 0 0") HINGE("j", "a", "b", "0 0 0 0 0 0")          \
                  HINGE("k", "world", "c", "0 0 0 0 0 0") last)

static void a_link_on_two_joints(void **state)
{
    /* the same with a connect of MJCF */
    mbsr_file *file = read_clean(
        "<mujoco><compiler angle='radian' eulerseq='XYZ'/><worldbody>"
        "<body name='a'><joint axis='0 1 0'/><inertial pos='.5 0 0' mass='1' diaginertia='.1 .1 "
        ".1'/><body name='b' pos='1 0 0' euler='0 -1 0'><joint axis='0 1 0'/><inertial pos='.5 0 "
        "0' mass='1' diaginertia='.1 .1 .1'/></body></body>"
        "<body name='c' pos='3 0 0' euler='0 -2.5 0'><joint axis='0 1 0'/><inertial pos='.5 0 0' "
        "mass='1' diaginertia='.1 .1 .1'/></body></worldbody>"
        "<equality><connect body1='b' body2='c' anchor='.8 0 .1'/></equality></mujoco>",
        NULL);
    double udot[3], u[3] = {0.0};
    mbsr_data *d;
    (void)state;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, file->q0, u, NULL, udot),
              mbsr_data_error(d));
    assert_true(fabs(udot[0]) > 1.0);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
#define AT_B "<pose relative_to='b'>.8 0 .1 0 0 0</pose><parent>b</parent><child>c</child>"
    assert_closed(FOUR_BAR("<joint name='l' type='ball'>" AT_B "</joint>"), 3, 3, udot);
    assert_closed(
        FOUR_BAR("<joint name='l' type='revolute'>" AT_B "<axis><xyz>0 1 0</xyz></axis></joint>"),
        4, 6, udot);
    assert_closed(FOUR_BAR("<joint name='l' type='universal'>" AT_B
                           "<axis><xyz>0 1 0</xyz></axis><axis2><xyz>1 0 0</xyz></axis2></joint>"),
                  4, 6, udot);
    udot[2] -= udot[0] + udot[1]; /* the last joint at the world in place of the one there */
    assert_closed(MODEL(BAR("a", "0 0 0 0 0 0") BAR("b", "1 0 0 0 -1 0") BAR("c", "3 0 0 0 -2.5 0")
                            HINGE("i", "world", "a", "0 0 0 0 0 0") HINGE(
                                "j", "a", "b",
                                "0 0 0 0 0 0") "<joint name='k' type='revolute'>" AT_B
                                               "<axis><xyz>0 1 0</xyz></axis></joint><joint "
                                               "name='l' type='ball'>"
                                               "<parent>world</parent><child>c</child></joint>"),
                  3, 3, udot);
}

/* Joints in a circle, one by which links hang on each other, and one between links of the world. */
static void circles_of_joints(void **state)
{
    (void)state;
    mbsr_file *file =
        read_clean(MODEL(LINK("a", "0 0 0 0 0 0") LINK("b", "1 0 0 0 0 0") LINK("c", "0 1 0 0 0 0")
                             HINGE("i", "a", "b", "0 0 0 0 0 0") HINGE("j", "b", "c", "0 0 0 0 0 0")
                                 HINGE("k", "c", "a", "0 0 0 0 0 0")),
                   NULL);
    assert_int_equal(file->bodies, 4);
    assert_int_equal(file->nu, 6 + 3);
    assert_string_equal(file->body_name[0], "a");
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    mbsr_file_destroy(file);
    file = read_small(
        SDF("<world name='w'><model name='s'><static>1</static>" LINK("a", "0 0 0 0 0 0")
                LINK("b", "1 0 0 0 0 0") HINGE("i", "a", "b", "0 0 0 0 0 0") "</model></world>"),
        NULL);
    assert_int_equal(file->nu, 1); /* of the body that closes the loop */
    mbsr_file_destroy(file);
}

static void joints_that_follow_others(void **state)
{
    static const double drawn[2] = {0.0, 0.0};
    mbsr_data *d;
    double gap[2];
    (void)state;
#define MIMIC                                                                                      \
    "<mimic "                                                                                      \
    "joint='i'><multiplier>-2</multiplier><offset>.3</offset><reference>.1</reference></mimic>"
    mbsr_file *file = read_clean(
        MODEL(LINK("a", "0 0 0 0 0 0") LINK("b", "1 0 0 0 3.141592653589793 0") HINGE(
            "i", "world", "a",
            "0 0 0 0 0 0") "<joint name='j' "
                           "type='revolute'><parent>world</parent><child>b</child><axis><xyz>0 1 "
                           "0</xyz>" MIMIC "</axis></joint>"
                           "<joint name='g' type='gearbox'><parent>a</parent><child>b</child>"
                           "<gearbox_ratio>3</gearbox_ratio><gearbox_reference_body>world</"
                           "gearbox_reference_body>"
                           "<axis><xyz expressed_in='__model__'>0 1 0</xyz></axis><axis2><xyz "
                           "expressed_in='__model__'>0 -1 0</xyz></axis2></joint>"),
        NULL);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, drawn), mbsr_data_error(d));
    assert_ok(mbsr_closures_gap(file->model, d, gap), mbsr_data_error(d));
    assert_close(fabs(gap[0]), 0.5, 1e-15); /* q_j = -2 (q_i - .1) + .3 */
    assert_close(gap[1], 0.0, 1e-15);
    const double q[2] = {0.2, 0.6}; /* about -y: -.6 = -3 * .2 */
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_closures_gap(file->model, d, gap), mbsr_data_error(d));
    assert_close(gap[1], 0.0, 1e-15);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

/* ---- the rest ---- */

static void what_links_weigh_and_how_they_look(void **state)
{
    mbsr_body_def def = mbsr_default_body_def();
    (void)state;
    mbsr_file *file = read_small(
        MODEL(
            "<link name='standard'/><link name='auto'><inertial auto='true'><density>500</density>"
            "</inertial><collision name='c'><pose>0 0 1 0 0 0</pose><geometry><box><size>1 2 "
            "3</size></box></geometry><surface><friction><ode><mu>.25</mu><mu2>.3</mu2></ode></"
            "friction></surface>"
            "</collision><collision name='d'><density>100</density>"
            "<geometry><sphere><radius>.5</radius></sphere></geometry></collision>"
            "<visual name='v'><pose>1 2 3 0 0 0</pose><transparency>.5</transparency><geometry>"
            "<mesh><uri>model://none/m.dae</uri><scale>2 2 2</scale></mesh></geometry><material>"
            "<ambient>.1 .1 .1 1</ambient><diffuse>.2 .4 .6 1</diffuse></material></visual>"
            "<visual name='p'><geometry><polyline/></geometry></visual></link>"),
        NULL);
    assert_int_equal(file->findings, 1);
    assert_found(file, "polyline", "not drawn");
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    mbsr_body_definition(file->model, 0, &def);
    assert_close(def.inertia.mass, 1.0, 0.0);
    mbsr_body_definition(file->model, 1, &def);
    assert_close(def.inertia.mass, 3000.0 + 100.0 * 3.14159265358979 / 6.0, 1e-12);
    assert_int_equal(file->shapes, 3);
    assert_int_equal(file->shape[2].kind, MBSR_SHAPE_MESH);
    assert_string_equal(file->shape[2].mesh, "model://none/m.dae");
    assert_close(file->shape[2].colour[1], 0.4, 0.0);
    assert_close(file->shape[2].colour[3], 0.5, 0.0);
    assert_close(file->shape[0].size[2], 1.5, 0.0);
    assert_int_equal(file->shape[0].visual, 0);
    assert_close(file->shape[0].friction[0], 0.25, 0.0);
    assert_close(file->shape[1].friction[0], 1.0, 0.0);
    mbsr_file_destroy(file);
}

/* A shape at a frame of its model, a plane by its normal; what has no volume weighs nothing. */
static void where_shapes_are(void **state)
{
    mbsr_body_def def = mbsr_default_body_def();
    (void)state;
    mbsr_file *file = read_small(
        MODEL("<pose>5 0 0 0 0 0</pose><frame name='f'><pose>1 2 3 0 0 0</pose></frame>"
              "<link name='a'><pose>0 1 0 0 0 0</pose><inertial auto='true'/>"
              "<visual name='v'><pose relative_to='f'>0 0 1 0 0 0</pose><geometry><sphere>"
              "<radius>1</radius></sphere></geometry></visual>"
              "<collision name='p'><geometry><plane><normal>1 0 0</normal><size>2 4</size></plane>"
              "</geometry></collision>"
              "<visual name='m'><geometry><mesh><uri>m.dae</uri><submesh><name>s</name></submesh>"
              "</mesh></geometry></visual></link>"),
        NULL);
    const mbsr_file_shape *shape = file->shape;
    assert_int_equal(file->shapes, 3);
    for (int k = 0; k < 3; ++k) {
        const int of = shape[k].kind == MBSR_SHAPE_PLANE;
        if (shape[k].kind == MBSR_SHAPE_MESH) continue;
        for (int l = 0; l < 3; ++l) {
            static const double place[3] = {1.0, 1.0, 4.0}, normal[3] = {1.0, 0.0, 0.0};
            assert_close(of ? shape[k].frame.R[6 + l] : shape[k].frame.x[l],
                         of ? normal[l] : place[l], 1e-15);
        }
    }
    assert_found(file, "mesh", "not its submesh alone");
    assert_found(file, "collision 'p'", "no solid of a known size");
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    mbsr_body_definition(file->model, 0, &def);
    assert_close(def.inertia.mass, 0.0, 0.0);
    mbsr_file_destroy(file);
}

/* Sizes are 1 m where a file says none, a capsule's radius 0.5 m. */
static void sizes_that_are_missing(void **state)
{
    static const char *const names[] = {"box", "sphere", "cylinder", "capsule", "ellipsoid"};
    static const double sizes[][3] = {
        {0.5, 0.5, 0.5}, {1.0}, {1.0, 0.5}, {0.5, 0.5}, {1.0, 1.0, 1.0}};
    (void)state;
    for (int k = 0; k < 5; ++k) {
        char text[400];
        snprintf(text, sizeof text,
                 MODEL("<link name='a'><collision name='c'><geometry><%s/></geometry></collision>"
                       "</link>"),
                 names[k]);
        mbsr_file *file = read_small(text, NULL);
        assert_int_equal(file->shapes, 1);
        for (int l = 0; l < 3; ++l) assert_close(file->shape[0].size[l], sizes[k][l], 0.0);
        mbsr_file_destroy(file);
    }
}

/* Limits that are none, words that SDF has not. */
static void what_is_left_out(void **state)
{
#define LIMITED(limit)                                                                             \
    MODEL("<link name='a'/><joint name='j' type='revolute'><parent>world</parent><child>a</child>" \
          "<axis><xyz>0 0 1</xyz><limit>" limit "</limit></axis></joint>")
    static const char *const cases[][2] = {
        {LIMITED("<lower>-1</lower>"), "on one side alone"},
        {LIMITED("<upper>1</upper><lower>-inf</lower>"), "on one side alone"},
        {LIMITED("<lower>1</lower><upper>-1</upper>"), "lower is above upper"}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        mbsr_file *file = read_small(cases[k][0], NULL);
        assert_int_equal(file->findings, 1);
        assert_found(file, "joint 'j'", cases[k][1]);
        assert_int_equal(file->joint[0].limited, 0);
        mbsr_file_destroy(file);
    }
    mbsr_file *file = read_small(MODEL("<link name='a'><glue/><own:word/></link>"), NULL);
    assert_int_equal(file->findings, 1);
    assert_found(file, "glue", "with all in them");
    mbsr_file_destroy(file);
#undef LIMITED
}

static void files_that_are_refused(void **state)
{
    static const char *const cases[][2] = {
        {MODEL("<link name='a'><collision name='c'><geometry><plane><normal>0 0 0</normal></plane>"
               "</geometry></collision></link>"),
         "its normal has no direction"},
        {MODEL("<link name='a'><visual name='c'><pose relative_to='x'/><geometry><plane/>"
               "</geometry></visual></link>"),
         "'x' is no frame"},
        {"<sdf version='1.1'/>", "'1.1'"},
        {"<gazebo version='1.0'/>", "'1.0'"},
        {"<gazebo/>", "no <robot>"},
        {"<sdf/>", "from 1.2"},
        {SDF(""), "neither a world nor a model"},
        {SDF("<model name='a'/><model name='b'/>"), "second model"},
        {MODEL("<link/>"), "no name"},
        {MODEL("<link name='a'/><frame name='a'/>"), "two of the name 'a'"},
        {MODEL("<link name='a'><pose>1 2</pose></link>"), "6 numbers"},
        {MODEL("<link name='a'><pose relative_to='b'/></link>"), "'b' is no frame"},
        {MODEL("<frame name='a'><pose relative_to='b'/></frame><frame name='b'><pose "
               "relative_to='a'/></frame><link name='l'><pose relative_to='a'/></link>"),
         "depends on itself"},
        {MODEL("<link name='a'/><frame name='f' attached_to='g'/><frame name='g' "
               "attached_to='f'/><joint name='j' type='fixed'><parent>f</parent><child>a</child>"
               "</joint>"),
         "attached to no link"},
        {MODEL("<link name='a'/><joint name='j' type='weird'><parent>world</parent><child>a</child>"
               "</joint>"),
         "type 'weird'"},
        {MODEL("<link name='a'/><joint name='j' type='fixed'><parent>a</parent></joint>"),
         "no child"},
        {MODEL("<link name='a'/><joint name='j' type='fixed'><parent>a</parent><child>world</child>"
               "</joint>"),
         "child is the world"},
        {MODEL("<link name='a'/><joint name='j' type='revolute'><parent>world</parent>"
               "<child>a</child><axis><xyz>0 0 0</xyz></axis></joint>"),
         "no direction"},
        {MODEL("<include/>"), "no uri"},
        {MODEL("<include><uri>model://x</uri></include>"), "no model model://x"},
        {MODEL("<include merge='true'><uri>model://x</uri></include>"), "merge"},
        {MODEL("<link name='a'><inertial><mass>-1</mass></inertial></link>"), "mass is -1"},
        {SDF("<world name='a'/><world name='b'/>"), "second world"},
        {SDF("<model name='m' canonical_link='x'><link name='a'/></model>"), "'x' is no link"},
        {SDF("<model name='m' canonical_link='f'><link name='a'/><frame name='f'/></model>"),
         "'f' is no link"},
        {SDF("<world name='w'><model name='m'><frame name='f'/></model><model name='n'>"
             "<link name='a'/></model><joint name='j' type='fixed'><parent>m</parent>"
             "<child>n::a</child></joint></world>"),
         "'m' has no link"},
        {MODEL("<link name='a'/><joint name='j' type='screw'><parent>world</parent>"
               "<child>a</child><axis><xyz>0 0 1</xyz></axis><thread_pitch>0</thread_pitch>"
               "</joint>"),
         "no pitch"},
        {MODEL("<link name='a'/><joint name='j' type='revolute'><parent>world</parent>"
               "<child>a</child><axis><xyz>0 0 1</xyz><mimic joint='x'/></axis></joint>"),
         "mimics 'x'"},
        {MODEL("<link name='a'/><joint name='j' type='revolute'><parent>world</parent>"
               "<child>a</child><axis><xyz>0 0 1</xyz><mimic joint='j'/></axis></joint>"),
         "mimics itself"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k)
        assert_file_refused(cases[k][0], NULL, cases[k][1]);
}

/* Read again as MJCF, loops and massless bodies included. */
static void converted_and_read_again(void **state)
{
    mbsr_written *written;
    mbsr_error error;
    (void)state;
    mbsr_file *a = read_clean(
        FOUR_BAR("<joint name='l' type='revolute'>" AT_B "<axis><xyz>0 1 0</xyz></axis></joint>"),
        NULL);
    assert_ok(mbsr_model_finish(a->model), mbsr_model_error(a->model));
    assert_ok(mbsr_file_write_mjcf(a->model, a, NULL, &written, &error), &error);
    mbsr_file *b = read_small(written->text, NULL),
              *c = read_clean(FOUR_BAR("<joint name='l' "
                                       "type='revolute'>" AT_B
                                       "<axis><xyz>0 1 0</xyz></axis></joint>"),
                              NULL);
    assert_int_equal(b->bodies, 4);
    assert_alike(c, b);
    mbsr_written_destroy(written);
    mbsr_file_destroy(a);
    mbsr_file_destroy(b);
    mbsr_file_destroy(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_relative_to_each_other),
        cmocka_unit_test(joints_of_all_kinds),
        cmocka_unit_test(a_screw),
        cmocka_unit_test(what_old_versions_say),
        cmocka_unit_test(names_and_numbers_of_old_versions),
        cmocka_unit_test(worlds_of_models),
        cmocka_unit_test(a_link_on_two_joints),
        cmocka_unit_test(circles_of_joints),
        cmocka_unit_test(joints_that_follow_others),
        cmocka_unit_test(what_links_weigh_and_how_they_look),
        cmocka_unit_test(where_shapes_are),
        cmocka_unit_test(sizes_that_are_missing),
        cmocka_unit_test(what_is_left_out),
        cmocka_unit_test(files_that_are_refused),
        cmocka_unit_test(converted_and_read_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
