/* Numbers of files, one after the other made none: each is refused by the file and the line, and
 * nothing is kept.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

enum { LONGEST = 8000 };

static const char mjcf[] =
    "<mujoco><compiler settotalmass='5' inertiagrouprange='0 3'/>"
    "<option gravity='0 0 -10' timestep='.01' density='0' viscosity='0'/>"
    "<asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' scale='1 1 2' refpos='0 0 0' "
    "refquat='1 0 0 0'/><texture name='t' builtin='flat' type='cube' rgb1='1 1 1'/>"
    "<material name='c' texture='t'/><material name='d' rgba='1 0 0 1'/>"
    "<hfield name='h' nrow='2' ncol='2' size='1 1 1 1' elevation='0 1 0 1'/></asset><worldbody>"
    "<geom type='hfield' hfield='h'/><geom name='floor' type='plane' size='1 1 1' group='0' "
    "contype='1' conaffinity='1' condim='3' friction='1 .1 .1' margin='0' solref='.02 1'/>"
    "<geom type='capsule' fromto='0 0 0 0 0 1' size='.1' material='c'/>"
    "<geom type='sphere' size='.1' rgba='1 0 0 1' material='d'/>"
    "<site name='s' pos='0 0 2' quat='1 0 0 0' />"
    "<body name='b' pos='0 0 1' euler='0 0 0' gravcomp='0'>"
    "<joint name='j' axis='0 1 0' pos='0 0 0' ref='0' springref='0' stiffness='1' damping='1' "
    "armature='0' frictionloss='0' range='-1 1' solreflimit='.02 1' solimplimit='.9 .95' "
    "actuatorfrcrange='-1 1'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
    "<geom name='box' type='box' size='.1 .1 .1' density='1000' mass='1' axisangle='0 0 1 0'/>"
    "<geom type='mesh' mesh='m'/><geom type='box' mesh='m' fitscale='1'/>"
    "<site name='r' pos='0 0 .1' xyaxes='1 0 0 0 1 0'/>"
    "<body name='c' zaxis='0 0 1'><joint name='k' axis='1 0 0'/>"
    "<inertial pos='0 0 0' mass='1' fullinertia='1 1 1 0 0 0'/></body></body>"
    "<body name='f'><freejoint/><geom size='.1'/></body>"
    "<replicate count='2' offset='0 0 1' euler='0 0 0'><geom size='.1'/></replicate>"
    "<composite prefix='z' type='cable' count='4 1 1' curve='s' offset='0 0 3' size='1 0 0' "
    "quat='1 0 0 0'><geom type='capsule' size='.01'/><joint kind='main' damping='.1'/></composite>"
    "</worldbody><contact><pair geom1='floor' geom2='box' condim='3' margin='0' friction='1 1' "
    "solref='.02 1'/></contact><tendon>"
    "<fixed name='t' stiffness='1' damping='1' frictionloss='0' armature='0' springlength='0 1' "
    "actuatorfrcrange='-1 1'><joint joint='j' coef='1'/><joint joint='k' coef='2'/></fixed>"
    "<fixed name='u'><joint joint='k' coef='1'/></fixed>"
    "<spatial stiffness='1'><site site='s'/><site site='r'/></spatial></tendon>"
    "<equality><joint joint1='j' joint2='k' polycoef='0 1 0 0 0'/>"
    "<connect body1='b' body2='f' anchor='0 0 0'/>"
    "<weld body1='b' body2='f' relpose='0 0 0 1 0 0 0' torquescale='1' anchor='0 0 0'/>"
    "<tendon tendon1='t' tendon2='u' polycoef='0 1 0 0 0'/></equality>"
    "<actuator><general joint='j' gainprm='1' biastype='affine' biasprm='0 1' gear='1' "
    "ctrlrange='-1 1' forcerange='-1 1'/><position joint='k' kp='1' kv='1' timeconst='0'/>"
    "<position joint='j' dampratio='1' inheritrange='1'/><velocity joint='k' kv='1'/></actuator>"
    "<sensor><jointpos joint='j' cutoff='1'/></sensor>"
    "<keyframe><key time='0' qpos='0 0 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0 1 0 0 0' ctrl='0 0 0 0'/>"
    "</keyframe></mujoco>";

static const char urdf[] =
    "<robot name='r'><link name='a'/><link name='b'><inertial><origin xyz='0 0 0' rpy='0 0 0'/>"
    "<mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
    "<visual><geometry><box size='1 1 1'/></geometry><material name='m'><color rgba='1 0 0 1'/>"
    "</material></visual><visual><geometry><sphere radius='1'/></geometry></visual>"
    "<collision><origin xyz='0 0 0' rpy='0 0 0'/><geometry><cylinder radius='1' length='1'/>"
    "</geometry></collision><visual><geometry><mesh filename='m.stl' scale='1 1 1'/></geometry>"
    "</visual></link><link name='c'/>"
    "<joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
    "<origin xyz='0 0 0' rpy='0 0 0'/><axis xyz='0 0 1'/>"
    "<limit lower='-1' upper='1' effort='1' velocity='1'/><dynamics damping='1' friction='0'/>"
    "</joint><joint name='k' type='prismatic'><parent link='b'/><child link='c'/>"
    "<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>"
    "<mimic joint='j' multiplier='2' offset='0'/></joint></robot>";

static const char sdf[] =
    "<sdf version='1.9'><world name='w'><gravity>0 0 -9</gravity><model name='m'>"
    "<pose>0 0 0 0 0 0</pose><link name='a'><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass>"
    "<pose>0 0 0 0 0 0</pose><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz><ixy>0</ixy>"
    "<ixz>0</ixz><iyz>0</iyz></inertia></inertial><visual name='v'><geometry><box><size>1 1 1"
    "</size></box></geometry><material><diffuse>1 0 0 1</diffuse></material></visual>"
    "<collision name='c'><geometry><cylinder><radius>1</radius><length>1</length></cylinder>"
    "</geometry></collision></link><link name='b'><collision name='s'><geometry><sphere>"
    "<radius>1</radius></sphere></geometry></collision><collision name='p'><geometry><capsule>"
    "<radius>1</radius><length>1</length></capsule></geometry></collision>"
    "<visual name='e'><geometry><ellipsoid><radii>1 1 2</radii></ellipsoid></geometry></visual>"
    "</link><joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1"
    "</xyz><limit><lower>-1</lower><upper>1</upper><effort>1</effort></limit><dynamics><damping>1"
    "</damping><friction>0</friction><spring_stiffness>1</spring_stiffness><spring_reference>0"
    "</spring_reference></dynamics></axis></joint></model></world></sdf>";

/* The next text of numbers alone between `open` and `close`. */
static const char *next_numbers(const char *from, char open, char close, size_t *length)
{
    for (const char *at = strchr(from, open); at; at = strchr(at + 1, open)) {
        *length = strspn(at + 1, "0123456789.- ");
        if (*length > 0 && at[1 + *length] == close) return at + 1;
    }
    return NULL;
}

/* The word before a place is one of a list, each between two blanks. */
static bool is_among(const char *words, const char *text, const char *at)
{
    char word[40] = " ";
    const char *end = at - 1;
    while (end > text && (end[-1] == '=' || end[-1] == '>')) --end;
    const char *begin = end;
    while (begin > text && begin[-1] != ' ' && begin[-1] != '<') --begin;
    snprintf(word + 1, sizeof word - 1, "%.*s ", (int)(end - begin), begin);
    return strstr(words, word) != NULL;
}

/* `unread`: what is not read, or only told of. */
static void each_is_refused(const char *text, char open, char close, const char *unread, int least)
{
    char damaged[LONGEST];
    size_t length;
    int refused = 0;
    mbsr_file_destroy(read_small(text, NULL));
    for (const char *at = next_numbers(text, open, close, &length); at;
         at = next_numbers(at + length, open, close, &length)) {
        if (is_among(unread, text, at)) continue;
        snprintf(damaged, sizeof damaged, "%.*s1 x%s", (int)(at - text), text, at + length);
        mbsr_file *file;
        mbsr_error error = {.text = ""};
        const int status =
            mbsr_file_read(damaged, strlen(damaged), "small.xml", NULL, &file, &error);
        if (status != MBSR_ERR_FILE || file)
            fail_msg("read: %.*s1 x%.20s", (int)(at - text > 60 ? 60 : at - text),
                     at - text > 60 ? at - 60 : text, at + length);
        assert_contains(error.text, "small.xml:1");
        ++refused;
    }
    assert_true(refused >= least);
}

static void numbers_of_mjcf(void **state)
{
    (void)state;
    each_is_refused(mjcf, '\'', '\'', " vertex elevation ", 100);
}

static void numbers_of_urdf(void **state)
{
    (void)state;
    each_is_refused(urdf, '\'', '\'', " effort velocity ", 20);
}

static void numbers_of_sdf(void **state)
{
    (void)state;
    each_is_refused(sdf, '>', '<', " effort ", 20);
}

/* What readers are told. */
static void wrong_options(void **state)
{
    static const char text[] = "<mujoco/>";
    const mbsr_file_package half[] = {{"a", NULL}}, other[] = {{NULL, "a"}};
    const mbsr_xacro_argument some[] = {{"a", NULL}}, more[] = {{NULL, "a"}};
    enum { CASES = 15 };
    static const struct {
        int status;
        const char *words;
    } why[CASES] = {{MBSR_ERR_VALUE, "hull_corners"},    {MBSR_ERR_VALUE, "hull_corners"},
                    {MBSR_ERR_VALUE, "packages"},        {MBSR_ERR_NULL, "package is NULL"},
                    {MBSR_ERR_NULL, "name or folder"},   {MBSR_ERR_NULL, "name or folder"},
                    {MBSR_ERR_VALUE, "arguments"},       {MBSR_ERR_NULL, "argument is NULL"},
                    {MBSR_ERR_NULL, "name or value"},    {MBSR_ERR_NULL, "name or value"},
                    {MBSR_ERR_VALUE, "format"},          {MBSR_ERR_VALUE, "format"},
                    {MBSR_ERR_NO_DEFAULT, "default"},    {MBSR_ERR_VALUE, "opt.gravity is nan"},
                    {MBSR_ERR_FILE, "not of the format"}};
    mbsr_file_opt opt[CASES];
    (void)state;
    for (int k = 0; k < CASES; ++k) opt[k] = mbsr_default_file_opt();
    opt[0].hull_corners = -1, opt[1].hull_corners = 3, opt[2].packages = -1, opt[3].packages = 1;
    opt[4].packages = 1, opt[4].package = half, opt[5].packages = 1, opt[5].package = other;
    opt[6].xacro.arguments = -1, opt[7].xacro.arguments = 1;
    opt[8].xacro.arguments = 1, opt[8].xacro.argument = some;
    opt[9].xacro.arguments = 1, opt[9].xacro.argument = more;
    opt[10].format = (mbsr_file_format)-1, opt[11].format = (mbsr_file_format)99;
    opt[12].cookie = 0, opt[13].gravity[1] = NAN, opt[14].format = MBSR_FILE_URDF;
    for (int k = 0; k < CASES; ++k) {
        mbsr_file *file;
        mbsr_error error = {.text = ""};
        const int status = mbsr_file_read(text, strlen(text), "small.xml", opt + k, &file, &error);
        if (status != why[k].status || file) fail_msg("case %d: %d", k, status);
        assert_contains(error.text, why[k].words);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_mjcf), cmocka_unit_test(numbers_of_urdf),
        cmocka_unit_test(numbers_of_sdf), cmocka_unit_test(wrong_options)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
