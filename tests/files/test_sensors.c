/* Sensors beside MuJoCo 3.14, at a state that moves; what is left out.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdio.h>

static const char sensed[] =
    "<mujoco><compiler angle='radian'/><option gravity='0 .5 -9.81'><flag "
    "contact='disable'/></option><worldbody><site name='w' pos='.1 .2 .3' euler='.1 .2 "
    ".3'/>"
    "<body name='a' pos='0 0 1'><freejoint/><inertial pos='.1 .2 .3' mass='2' "
    "fullinertia='.5 .6 .7 .01 .02 .03'/><site name='s' pos='.3 .1 0' euler='.4 .5 .6'/>"
    "<body name='b' pos='.5 0 0' euler='0 .3 0'><joint name='h' axis='0 1 1' "
    "damping='.2'/><inertial pos='.1 0 .3' mass='1' diaginertia='.1 .2 .15'/><geom "
    "name='g' type='box' size='.1 .2 .3' pos='0 .1 .2' euler='.2 0 .1'/><site name='t' "
    "pos='0 .2 .1' euler='0 .7 0'/>"
    "<body name='c' pos='0 .4 0'><joint name='q' type='ball' pos='.1 0 0'/><inertial "
    "pos='.2 0 .1' mass='.5' diaginertia='.05 .06 .07'/><site name='u' pos='.2 .2 "
    ".2'/></body></body>"
    "<body name='d' pos='0 -.4 0'><joint name='l' type='slide' axis='1 2 0'/><inertial "
    "pos='.2 0 .1' mass='.7' diaginertia='.05 .06 .07'/></body></body></worldbody>"
    "<tendon><fixed name='f'><joint joint='h' coef='2'/><joint joint='l' "
    "coef='-3'/></fixed><spatial name='p'><site site='w'/><site site='s'/><site "
    "site='u'/></spatial></tendon>"
    "<actuator><motor name='m' joint='h' gear='3'/><position name='o' tendon='f' kp='4' "
    "kv='.5' gear='2'/><motor name='x' joint='h' gear='-2'/></actuator>"
    "<sensor><jointpos name='s0' joint='h'/><jointvel name='s1' "
    "joint='l'/><jointactuatorfrc name='s2' joint='h'/><ballquat name='s3' "
    "joint='q'/><ballangvel name='s4' joint='q'/><tendonpos name='s5' "
    "tendon='f'/><tendonvel name='s6' tendon='p'/><tendonpos name='s7' "
    "tendon='p'/><actuatorpos name='s8' actuator='o'/><actuatorvel name='s9' "
    "actuator='m'/><actuatorfrc name='s10' actuator='o'/>"
    "<framepos name='s11' objtype='body' objname='b' reftype='site' "
    "refname='s'/><framequat name='s12' objtype='xbody' objname='c'/><framexaxis "
    "name='s13' objtype='site' objname='u'/><frameyaxis name='s14' objtype='site' "
    "objname='t' reftype='site' refname='w'/><framezaxis name='s15' objtype='geom' "
    "objname='g'/><framelinvel name='s16' objtype='site' objname='u' reftype='xbody' "
    "refname='b'/><frameangvel name='s17' objtype='site' objname='u' reftype='site' "
    "refname='s'/><framelinacc name='s18' objtype='site' objname='t'/><frameangacc "
    "name='s19' objtype='xbody' objname='c'/>"
    "<accelerometer name='s20' site='u'/><velocimeter name='s21' site='t'/><gyro "
    "name='s22' site='t' cutoff='.1'/><force name='s23' site='t'/><torque name='s24' "
    "site='t'/><force name='s25' site='u'/><torque name='s26' site='u'/><subtreecom "
    "name='s27' body='b'/><subtreelinvel name='s28' body='a'/><subtreeangmom name='s29' "
    "body='b'/><e_kinetic name='s30'/><clock name='s31'/></sensor>"
    "</mujoco>";

/* By mj_forward at q = sin(1 + 3 k) / 2, quaternions of length 1, u = 0.5 - 0.1 k, controls 0.7 -
 * 0.2 k, t = 1.5. */
static const double expected[][4] = {
    {-0.00442565464520194},
    {-0.500000000000000},
    {-26.3065885038430},
    {-0.181103057737085, 0.370692994879075, -0.552863509208179, 0.723968456641502},
    {-0.200000000000000, -0.300000000000000, -0.400000000000000},
    {0.956455890745095},
    {-0.117344974779823},
    {1.27364893050833},
    {1.91291178149019},
    {-0.300000000000000},
    {-6.95164712596076},
    {0.172814608779446, -0.108619881217237, 0.426324640982053},
    {-0.540393401931619, -0.528960674383481, 0.174731028789758, -0.630590710114427},
    {0.143648847790910, 0.496682432481721, 0.855962364705589},
    {0.119945383805464, 0.185856060085649, -0.975228501343762},
    {0.921351744090059, 0.339244279584734, 0.189800638648139},
    {-0.0205614415894199, -0.00677977911481771, 0.00559121765979059},
    {0.209174545560153, 0.393878538497528, -0.0836566670471276},
    {-9.13413028247635, -9.24334353334440, 2.52290365970021},
    {-23.9334255580901, -4.00063899459183, 12.2367766034985},
    {-4.80776965131507, 4.53146205551833, 24.4981997918601},
    {-0.570887460291548, -0.245731317698078, 0.318038479215990},
    {0.100000000000000, 0.0298870476694297, 0.100000000000000},
    {-5.52023626044388, -17.2687661471009, -14.8071182727613},
    {14.8606023165784, -17.9320077317854, -14.4415296038402},
    {-4.10654548149621, 2.53374143968571, 11.7464819274218},
    {-1.84254809754722, 1.99595728904142, -1.07468324026781},
    {0.962213672607074, -0.701707909165574, 0.0489334842631809},
    {0.490991128330568, 0.355508295673239, 0.415011686138804},
    {0.0112373412414352, -0.0128149906208260, -0.0414529886770678},
    {1.23597639400798},
    {1.50000000000000},
};

static void numbers_of_sensors(void **state)
{
    static const int quaternion[2] = {3, 8};
    double p[16], v[16], q[16], u[16], udot[16];
    mbsr_data *d;
    (void)state;
    mbsr_file *file = read_small(sensed, NULL);
    assert_int_equal(file->findings, 0);
    assert_int_equal(file->sensors, sizeof expected / sizeof *expected);
    for (int k = 0; k < file->nq; ++k) p[k] = 0.5 * sin(1.0 + 3.0 * k);
    for (int k = 0; k < 2; ++k) {
        double square = 0.0;
        for (int l = 0; l < 4; ++l) square += p[quaternion[k] + l] * p[quaternion[k] + l];
        for (int l = 0; l < 4; ++l) p[quaternion[k] + l] /= sqrt(square);
    }
    for (int k = 0; k < file->nu; ++k) v[k] = 0.5 - 0.1 * k;
    for (int k = 0; k < file->actuators; ++k) file->control[k] = 0.7 - 0.2 * k;
    assert_int_equal(mbsr_file_mujoco_state(file, 0, p, v, q, u), MBSR_OK);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_forward_dynamics(file->model, d, 1.5, q, u, NULL, udot), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(file->model, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_accelerations(file->model, d, udot), mbsr_data_error(d));
    for (int k = 0; k < file->sensors; ++k) {
        double value[4], size = 1.0;
        char name[16];
        snprintf(name, sizeof name, "s%d", k);
        const int at = mbsr_file_find_sensor(file, name), count = file->sensor[at].size;
        assert_ok(mbsr_file_sense(file, at, file->model, d, 1.5, q, u, value), mbsr_data_error(d));
        for (int l = 0; l < count; ++l) size = fmax(size, fabs(expected[k][l]));
        const int other = count == 4 && value[0] * expected[k][0] < 0.0; /* the same turn */
        for (int l = 0; l < count && other; ++l) value[l] = -value[l];
        for (int l = 0; l < count; ++l) {
            if (fabs(value[l] - expected[k][l]) > 1e-12 * size) print_error("sensor %s\n", name);
            assert_close(value[l] / size, expected[k][l] / size, 1e-12);
        }
    }
    assert_int_equal(mbsr_file_sense(file, file->sensors, file->model, d, 0.0, q, u, p),
                     MBSR_ERR_ID);
    assert_int_equal(mbsr_file_sense(file, 0, file->model, d, 0.0, NULL, u, p), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(NULL, 0, file->model, d, 0.0, q, u, p), MBSR_ERR_NULL);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void sensors_that_are_left_out(void **state)
{
    static const char *const cases[][2] = {
        {"<touch name='x' site='s'/>", "no state gives"},
        {"<rangefinder name='x' site='s'/>", "no state gives"},
        {"<force name='x' site='none'/>", "none that the model has"},
        {"<framequat name='x' objtype='body' objname='b'/>", "none that the model has"},
        {"<framepos name='x' objtype='camera' objname='b'/>", "none that the model has"},
        {"<gyro name='x' site='s' delay='.1'/>", "at once"},
        {"<jointpos name='x' joint='f'/>", "none that the model has"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        char text[500], element[40];
        snprintf(text, sizeof text,
                 "<mujoco><worldbody><body name='b'><freejoint name='f'/><geom size='1'/><site "
                 "name='s'/></body></worldbody><sensor>%s</sensor></mujoco>",
                 cases[k][0]);
        mbsr_file *file = read_small(text, NULL);
        const int length = (int)strcspn(cases[k][0] + 1, " ");
        snprintf(element, sizeof element, "%.*s 'x'", length, cases[k][0] + 1);
        assert_found(file, element, cases[k][1]);
        mbsr_file_destroy(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_sensors),
        cmocka_unit_test(sensors_that_are_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
