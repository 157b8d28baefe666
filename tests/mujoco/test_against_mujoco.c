/* Models of our own against MuJoCo, where it is installed: poses, masses,
 * accelerations. Its contacts, limits, equalities, dry friction and actuators
 * are off, which are soft there. SPDX-License-Identifier: BSD-3-Clause */
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
};

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
        mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_EQUALITY | mjDSBL_FRICTIONLOSS | mjDSBL_ACTUATION;
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
}

/* What was written moves in MuJoCo as the model here; where a body has no mass, MuJoCo refuses it as the finding
 * says. */
static void written_models_move_in_mujoco(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof models / sizeof *models; ++k) {
        mbsr_file *file = read_finished(models[k]);
        mbsr_written *written;
        mbsr_error error;
        char wrong[500] = "";
        assert_ok(mbsr_file_write_mjcf(file->model, file, NULL, &written, &error), &error);
        if (written->findings == 0) {
            compare_models(file, written->text);
        } else {
            assert_contains(written->finding[0].text, "MuJoCo refuses");
            assert_null(load_in_mujoco(written->text, wrong));
            assert_contains(wrong, "mass and inertia of moving bodies");
        }
        assert_int_equal(written->findings, k == 0); /* a joint of the first has two anchors */
        mbsr_written_destroy(written);
        mbsr_file_destroy(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(models_move_as_in_mujoco),
        cmocka_unit_test(written_models_move_in_mujoco),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
