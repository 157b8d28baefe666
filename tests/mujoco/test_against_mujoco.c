/* Models of our own against MuJoCo, where it is installed: poses, masses,
 * accelerations. Its contacts, limits, equalities, dry friction and actuators
 * are off, which are soft there.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <mujoco/mujoco.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST = 40 };

static const char *const models[] = {
    /* joints of all types, several on a body, references, anchors, springs,
       dampers, armature */
    "<mujoco><compiler angle='degree' eulerseq='zYx'/><option gravity='1 2 "
    "-9'/>"
    "<default><joint damping='.3' armature='.02'/><default class='s'><joint "
    "type='slide' axis='1 2 3' "
    "stiffness='7' springref='.2' ref='.1'/></default></default><worldbody>"
    "<body name='a' pos='1 2 3' euler='10 20 30'><joint pos='.1 .2 .3' axis='1 "
    "1 0' ref='20'/>"
    "<joint class='s'/><joint pos='.3 0 0' axis='0 1 2' stiffness='3' "
    "springref='40'/>"
    "<geom type='box' size='.1 .2 .3' pos='.1 0 0' axisangle='1 2 3 50'/>"
    "<body name='b' pos='0 0 1' xyaxes='1 2 0 0 1 1'><joint type='ball' pos='0 "
    "0 -.2' stiffness='2'/>"
    "<geom type='capsule' size='.1' fromto='0 0 0 .3 .4 .5'/>"
    "<body name='c' pos='.5 .5 .5' zaxis='1 1 2'><joint axis='0 1 0' pos='.1 0 "
    "0'/>"
    "<joint axis='1 0 0' pos='.1 0 0'/><geom type='cylinder' size='.2 .3' "
    "density='300'/></body></body>"
    "</body><body name='f' pos='3 0 0' quat='1 2 3 4'><freejoint/>"
    "<geom type='ellipsoid' size='.3 .2 .1' mass='3'/><body name='g' pos='0 1 "
    "0'><joint/>"
    "<inertial pos='.1 .2 .3' mass='2' diaginertia='.3 .4 .5' euler='10 0 "
    "20'/><geom size='1'/></body>"
    "</body></worldbody></mujoco>",
    /* radians, Euler angles about moving axes, tendons with springs, a chain of
       slides */
    "<mujoco><compiler angle='radian' inertiafromgeom='true' autolimits='true'/><worldbody>"
    "<body name='a' euler='.1 .2 .3'><joint name='i' axis='3 0 4' range='-1 "
    "1'/>"
    "<inertial pos='0 0 0' mass='100' diaginertia='1 1 1'/><geom size='.3'/>"
    "<body name='b' pos='0 .4 0'><joint name='j' type='slide' axis='0 0 "
    "2'/><geom size='.2' pos='0 0 1'/>"
    "</body></body><site name='w' pos='2 0 0'/><body name='c' pos='0 0 "
    "2'><joint axis='1 0 0'/>"
    "<joint axis='0 1 0'/><joint axis='0 0 1'/><geom type='box' size='.1 .1 "
    ".4' pos='0 0 .4'/>"
    "<site name='s' pos='0 .1 .8'/></body></worldbody><tendon>"
    "<fixed stiffness='20' damping='3' springlength='.4'><joint joint='i' "
    "coef='2'/>"
    "<joint joint='j' coef='-3'/></fixed><spatial stiffness='30' damping='2' "
    "springlength='.5'>"
    "<site site='w'/><site site='s'/></spatial></tendon></mujoco>",
    /* classes in classes and for children, actuators of all kinds with their defaults, keys */
    "<mujoco><compiler angle='radian' autolimits='true'/>"
    "<default><general gear='3' ctrlrange='-2 2'/><joint damping='.1'/><default class='arm'>"
    "<joint axis='0 1 0' armature='.3'/><geom type='capsule' size='.05 .2'/>"
    "<default class='servo'><position kp='20'/><joint damping='.4'/></default></default>"
    "</default><worldbody><body name='a' childclass='arm'><joint name='i' ref='.2'/><geom/>"
    "<body name='b' pos='0 0 .4'><joint name='j' class='servo'/><geom class='main' size='.1'/>"
    "<body name='c' pos='0 0 .4' childclass='servo'><joint name='k' type='slide' axis='0 0 1'/>"
    "<geom size='.1 .1'/></body></body></body></worldbody>"
    "<tendon><fixed name='t'><joint joint='i' coef='.5'/><joint joint='k' coef='-1.5'/></fixed>"
    "</tendon><actuator><motor name='m' joint='i'/><position name='p' class='servo' joint='j'/>"
    "<position name='o' joint='j' kp='7' gear='-2'/><velocity name='v' joint='k' kv='5'/>"
    "<general name='g' joint='i' gaintype='fixed' gainprm='4' biastype='affine' biasprm='.3 -2 "
    "-.7'/>"
    "<general name='n' joint='k' biasprm='9 9 9'/><motor name='d' tendon='t' gear='.5'/>"
    "<general name='e' tendon='t' gainprm='2' biastype='affine' biasprm='0 -3 -.2'/></actuator>"
    "<keyframe><key name='up' time='2' qpos='.1 .2 .3' qvel='1 2 3' ctrl='1 0 .5 0 -1 0 2 0'/>"
    "<key name='down' qpos='.4 .5 .6'/></keyframe></mujoco>",
    /* inertias: groups that count, masses given, from end to end, tensors in all spellings */
    "<mujoco><compiler inertiagrouprange='1 2'/><worldbody><body name='a'><freejoint/>"
    "<geom size='9'/><geom group='1' size='.2' mass='4'/><geom group='2' type='box' size='.1 .1 "
    ".1' fromto='0 0 0 .4 .1 .2'/>"
    "<geom group='3' size='7' mass='100'/><body name='b' pos='.1 .2 .3'><joint/><geom group='1' "
    "type='ellipsoid' "
    "size='.1' fromto='.1 .2 .3 .4 .4 .4'/></body><body name='c'><joint axis='1 0 0'/><inertial "
    "pos='.1 0 .2' mass='3' "
    "fullinertia='.4 .5 .6 .01 -.02 .03'/></body><body name='d'><joint axis='0 1 0'/><inertial "
    "pos='0 .1 0' mass='1' "
    "diaginertia='.1 .2 .25' xyaxes='1 1 0 0 0 3'/></body><body name='e'><joint/><inertial pos='0 "
    "0 1' mass='2' "
    "diaginertia='.1 .2 .25' zaxis='1 2 3'/></body><body name='f' axisangle='1 2 3 40'><joint "
    "axis='1 2 3'/>"
    "<inertial pos='0 0 1' mass='2' diaginertia='.1 .2 .25' axisangle='0 1 1 70'/><geom group='1' "
    "size='5'/></body>"
    "</body></worldbody></mujoco>",
};

/* Tendons along several sites, two of them on one body, and at rest as drawn: what MJCF is not
 * written of. */
static const char path_model[] =
    "<mujoco><worldbody><site name='w' pos='.1 .2 1.5'/><body name='a' pos='0 0 1'>"
    "<joint axis='0 1 0' springref='0'/><joint axis='1 0 0' pos='0 0 .1'/><geom size='.1' pos='.3 "
    "0 0'/>"
    "<site name='p' pos='.2 .1 0'/><site name='q' pos='.5 0 .1'/><body name='b' pos='.6 0 0'>"
    "<joint type='ball'/><geom type='box' size='.1 .2 .05' pos='.1 .1 .1'/><site name='r' pos='.3 "
    ".2 .1'/></body>"
    "</body><body name='c' pos='1 1 1'><freejoint/><geom type='box' size='.1 .2 .05'/><site "
    "name='t' pos='0 .1 .1'/>"
    "</body></worldbody><tendon><spatial stiffness='40' damping='3' springlength='1.1'><site "
    "site='w'/>"
    "<site site='p'/><site site='q'/><site site='r'/></spatial><spatial stiffness='20' damping='1'>"
    "<site site='t'/><site site='q'/><site site='w'/></spatial><spatial stiffness='9' damping='2'>"
    "<site site='r'/><site site='t'/></spatial></tendon></mujoco>";

enum { CLOSED_MESH = 2 };

/* A pyramid, convex; the same with a dent in its base, which is not. */
static const char *const meshes[CLOSED_MESH] = {
    "v 0 0 0\nv 1 0 0\nv 1 1.5 0\nv 0 1.5 0\nv .3 .4 2\n"
    "f 1 4 3\nf 1 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    "v 0 0 0\nv 1 0 0\nv 1 1.5 0\nv 0 1.5 0\nv .3 .4 2\nv .5 .6 .4\n"
    "f 1 4 6\nf 4 3 6\nf 3 2 6\nf 2 1 6\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"};

static void fill(const mjModel *m, test_rng *rng, double *q, double *v, double *tau)
{
    test_fill(rng, m->nq, q);
    test_fill(rng, m->nv, v);
    test_fill(rng, m->nv, tau);
    for (int j = 0; j < m->njnt; ++j) {
        if (m->jnt_type[j] == mjJNT_BALL) mju_normalize4(q + m->jnt_qposadr[j]);
        if (m->jnt_type[j] == mjJNT_FREE) mju_normalize4(q + m->jnt_qposadr[j] + 3);
    }
}

static void compare_poses(const mbsr_file *file, mbsr_data *d, const mjModel *m, const mjData *md)
{
    for (int b = 1; b < m->nbody; ++b) {
        double pose[MBSR_POSE_SIZE], R[9];
        const int id = mbsr_model_find_body(file->model, m->names + m->name_bodyadr[b]);
        assert_true(id >= 0);
        assert_ok(mbsr_body_pose(file->model, d, id, pose), mbsr_data_error(d));
        mbsr_quaternion_rotation(md->xquat + 4 * b, R);
        for (int k = 0; k < 3; ++k) assert_close(pose[MBSR_POSE_X + k], md->xpos[3 * b + k], 1e-12);
        for (int k = 0; k < 9; ++k) assert_close(pose[k], R[k], 1e-12);
    }
}

static void compare_states(const mbsr_file *file, mbsr_data *d, mjModel *m, mjData *md,
                           uint64_t seed)
{
    test_rng rng = test_seed(seed);
    double tau[MOST], q[MOST], u[MOST], force[MOST], udot[MOST], expected[MOST], mass;
    fill(m, &rng, md->qpos, md->qvel, tau);
    test_fill(&rng, m->nu, md->ctrl);
    memcpy(file->control, md->ctrl, (size_t)m->nu * sizeof *md->ctrl);
    memcpy(md->qfrc_applied, tau, (size_t)m->nv * sizeof *tau);
    mj_forward(m, md);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, md->qpos, md->qvel, q, u), MBSR_OK);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, md->qpos, tau, q, force), MBSR_OK);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, md->qpos, md->qacc, q, expected), MBSR_OK);
    assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, q, u, force, udot), mbsr_data_error(d));
    const double size = test_largest(m->nv, expected);
    for (int k = 0; k < m->nv; ++k) assert_close(udot[k], expected[k], 1e-9 * size);
    compare_poses(file, d, m, md);
    assert_ok(mbsr_tree_momentum(file->model, d, NULL, &mass, NULL, NULL), mbsr_data_error(d));
    assert_close(mass, mj_getTotalmass(m), 1e-12 * mass);
}

/* Named states, and what actuators are limited to. */
static void compare_keys(const mbsr_file *file, const mjModel *m)
{
    double q[MOST], u[MOST];
    assert_int_equal(file->keys, m->nkey);
    for (int k = 0; k < m->nkey; ++k) {
        const mbsr_file_key *key = file->key + k;
        assert_string_equal(key->name, m->names + m->name_keyadr[k]);
        assert_true(key->time == m->key_time[k]);
        assert_int_equal(
            mbsr_file_mujoco_state(file, 0, m->key_qpos + k * m->nq, m->key_qvel + k * m->nv, q, u),
            MBSR_OK);
        for (int l = 0; l < m->nq; ++l) assert_close(key->q[l], q[l], 1e-15);
        for (int l = 0; l < m->nv; ++l) assert_close(key->u[l], u[l], 1e-15);
        for (int l = 0; l < m->nu; ++l) assert_true(key->control[l] == m->key_ctrl[k * m->nu + l]);
    }
    for (int k = 0; k < m->nu; ++k) {
        const mbsr_file_actuator *a = file->actuator + k;
        assert_int_equal(a->limited, m->actuator_ctrllimited[k]);
        if (a->limited) assert_true(a->range[1] == m->actuator_ctrlrange[2 * k + 1]);
    }
}

/* NULL, and why, where MuJoCo refuses it. */
static mjModel *load_in_mujoco(const char *text, char wrong[500])
{
    static const char path[] = "against_mujoco.xml";
    FILE *to = fopen(path, "w");
    assert_non_null(to);
    fputs(text, to);
    fclose(to);
    mjModel *m = mj_loadXML(path, NULL, wrong, 500);
    remove(path);
    return m;
}

/* T (3 x 3) = sum of moment[k] times the square of column k of R. */
static void turned(const double R[9], const double moment[3], double T[9])
{
    for (int k = 0; k < 9; ++k) {
        T[k] = 0.0;
        for (int j = 0; j < 3; ++j) T[k] += R[3 * j + k % 3] * moment[j] * R[3 * j + k / 3];
    }
}

/* One turn about axis k of R, so that T has no product of inertia about the two other axes. */
static void make_principal(const double T[9], int k, double R[9])
{
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    double D[3] = {0.0}; /* ii, jj, ij of R^T T R */
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            D[0] += R[3 * i + r] * T[3 * c + r] * R[3 * i + c];
            D[1] += R[3 * j + r] * T[3 * c + r] * R[3 * j + c];
            D[2] += R[3 * i + r] * T[3 * c + r] * R[3 * j + c];
        }
    }
    const double angle = 0.5 * atan2(2.0 * D[2], D[0] - D[1]);
    for (int r = 0; r < 3; ++r) {
        const double x = R[3 * i + r], y = R[3 * j + r];
        R[3 * i + r] = cos(angle) * x + sin(angle) * y;
        R[3 * j + r] = cos(angle) * y - sin(angle) * x;
    }
}

/* MuJoCo 2.2.2 leaves principal axes as they are when they are off by less than 1.4e-6 (cosines of
 * 1 - 1e-12), which is checked, and gets those of the model here. */
static void refine_axes(const mbsr_file *file, mjModel *m)
{
    static const int place[6] = {0, 4, 8, 3, 6, 7};
    for (int b = 1; b < m->nbody; ++b) {
        mbsr_body_def def;
        double R[9], own[9], T[9], *moment = m->body_inertia + 3 * b;
        const int id = mbsr_model_find_body(file->model, m->names + m->name_bodyadr[b]);
        assert_ok(mbsr_body_definition(file->model, id, &def), NULL);
        mbsr_quaternion_rotation(m->body_iquat + 4 * b, R);
        turned(R, moment, own);
        for (int k = 0; k < 6; ++k) {
            const int at = place[k];
            T[at] = T[3 * (at % 3) + at / 3] = def.inertia.tensor[k];
            assert_close(own[at], T[at], 1.5e-6 * test_largest(3, moment));
        }
        for (int sweep = 0; sweep < 30; ++sweep) make_principal(T, sweep % 3, R);
        for (int k = 0; k < 3; ++k) {
            moment[k] = 0.0;
            for (int l = 0; l < 9; ++l) moment[k] += R[3 * k + l % 3] * T[l] * R[3 * k + l / 3];
        }
        mbsr_rotation_quaternion(R, m->body_iquat + 4 * b);
        m->body_sameframe[b] = 0;
    }
}

/* A model of this library moves as that text does in MuJoCo. */
static void compare_models(const mbsr_file *file, const char *text)
{
    char wrong[500] = "";
    mjModel *m = load_in_mujoco(text, wrong);
    if (!m) print_error("%s\n%s\n", wrong, text);
    assert_non_null(m);
    mjData *md = mj_makeData(m);
    mbsr_data *d;
    m->opt.disableflags |=
        mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_EQUALITY | mjDSBL_FRICTIONLOSS | mjDSBL_CLAMPCTRL;
    assert_int_equal(file->actuators, m->nu);
    compare_keys(file, m);
    refine_axes(file, m);
    assert_int_equal(file->nq, m->nq);
    assert_int_equal(file->nu, m->nv);
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    for (uint64_t seed = 1; seed <= 5; ++seed) compare_states(file, d, m, md, seed);
    mbsr_data_destroy(d);
    mj_deleteData(md);
    mj_deleteModel(m);
}

static mbsr_file *read_finished(const char *text)
{
    mbsr_file *file = read_small(text, NULL);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    return file;
}

static void models_move_as_in_mujoco(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof models / sizeof *models; ++k) {
        mbsr_file *file = read_finished(models[k]);
        compare_models(file, models[k]);
        mbsr_file_destroy(file);
    }
    mbsr_file *file = read_finished(path_model);
    assert_int_equal(file->findings, 0);
    assert_int_equal(mbsr_model_forces(file->model), 4);
    compare_models(file, path_model);
    mbsr_file_destroy(file);
}

/* What was written moves in MuJoCo as the model here. */
static void written_models_move_in_mujoco(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof models / sizeof *models; ++k) {
        mbsr_file *file = read_finished(models[k]);
        mbsr_written *written;
        mbsr_error error;
        assert_ok(mbsr_file_write_mjcf(file->model, file, NULL, &written, &error), &error);
        assert_int_equal(written->findings, 0);
        compare_models(file, written->text);
        mbsr_written_destroy(written);
        mbsr_file_destroy(file);
    }
}

static int load_mesh(void *user, const char *path, const char **text, size_t *size)
{
    (void)path;
    *text = user;
    *size = strlen(user);
    return 0;
}

/* Inertias of meshes, whose vertices are floats in MuJoCo. Its own frames are at their centres. */
static void meshes_weigh_as_in_mujoco(void **state)
{
    static const char name[] = "against_mujoco.obj",
                      text[] = "<mujoco><compiler exactmeshinertia='true'/><asset><mesh name='m' "
                               "file='against_mujoco.obj' scale='.5 -.3 .4'/></asset><worldbody>"
                               "<body name='b'><freejoint/><geom type='mesh' mesh='m' pos='1 2 3' "
                               "euler='10 20 30' density='700'/></body></worldbody></mujoco>";
    (void)state;
    for (int k = 0; k < CLOSED_MESH; ++k) {
        char wrong[500] = "", copy[500];
        mbsr_file_opt opt = mbsr_default_file_opt();
        snprintf(copy, sizeof copy, "%s", meshes[k]);
        opt.load = load_mesh;
        opt.user = copy;
        mbsr_file *file = read_small(text, &opt);
        assert_int_equal(file->findings, 0);
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        FILE *to = fopen(name, "w");
        assert_non_null(to);
        fputs(meshes[k], to);
        fclose(to);
        mjModel *m = load_in_mujoco(text, wrong);
        remove(name);
        if (!m) print_error("%s\n", wrong);
        assert_non_null(m);
        mbsr_body_def def;
        assert_ok(mbsr_body_definition(file->model, 0, &def), NULL);
        assert_close(def.inertia.mass, m->body_mass[1], 1e-6 * m->body_mass[1]);
        for (int l = 0; l < 3; ++l) assert_close(def.inertia.com[l], m->body_ipos[3 + l], 1e-6);
        /* its principal moments turned into the body */
        double R[9];
        const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
        const double largest = test_largest(3, m->body_inertia + 3);
        mbsr_quaternion_rotation(m->body_iquat + 4, R);
        for (int l = 0; l < 6; ++l) {
            double sum = 0.0;
            for (int j = 0; j < 3; ++j)
                sum += R[3 * j + row[l]] * m->body_inertia[3 + j] * R[3 * j + column[l]];
            assert_close(def.inertia.tensor[l], sum, 1e-6 * largest);
        }
        mj_deleteModel(m);
        mbsr_file_destroy(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_weigh_as_in_mujoco),
        cmocka_unit_test(models_move_as_in_mujoco),
        cmocka_unit_test(written_models_move_in_mujoco),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
