/* Models written as MJCF and read again have the same accelerations; what MJCF cannot say is
 * listed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "locale_comma.h"
#include "small.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST = 256 };

static const char mechanism[] =
    "<mujoco model='a &amp; b'><compiler angle='radian' autolimits='true'/><option gravity='1 0 "
    "-9'/>"
    "<asset><mesh name='m' file='m.stl' scale='2 2 2'/></asset><worldbody>"
    "<geom type='plane' size='1 1 1'/><site name='hook' pos='0 0 2'/>"
    "<body name='base' pos='1 2 3' quat='1 2 0 0'><freejoint name='root'/>"
    " <inertial pos='0.1 0 0.2' mass='3' fullinertia='1 2 2.5 0.1 0.2 0.3'/>"
    " <geom type='mesh' mesh='m' contype='0'/><site name='mark' pos='0.1 0.2 0.3' euler='0.1 0 0'/>"
    " <body name='two' pos='0 0 1' euler='0.3 0.2 0.1'>"
    "  <joint name='slide' type='slide' axis='1 0 1' ref='0.2' springref='0.4' stiffness='7'/>"
    "  <joint name='hinge' axis='0 1 0' pos='0.1 0 0.3' ref='0.5' damping='0.3' armature='0.1' "
    "range='-1 2'/>"
    "  <joint name='other' axis='1 1 0' pos='0.1 0 0.3' ref='-0.7' frictionloss='0.2'/>"
    "  <inertial pos='0 0 0' mass='1' diaginertia='0.1 0.2 0.15'/>"
    "  <body name='ball' pos='0.5 0 0'><joint name='spin' type='ball' pos='0 0.1 0' stiffness='2' "
    "damping='0.4'/>"
    "   <inertial pos='0 0 0.2' mass='0.5' diaginertia='0.01 0.02 0.03'/></body>"
    "  <body name='light' pos='0 0.4 0'><joint name='light' axis='0 0 1' damping='0.1'/></body>"
    " </body></body>"
    "<body name='arm' pos='-1 0 0'><joint name='a' axis='0 1 0'/><geom type='box' size='0.1 0.2 "
    "0.3'/>"
    " <body name='fore' pos='0 0 1'><joint name='b' axis='0 1 0' ref='0.3'/><joint name='c' "
    "axis='0 0 1' pos='0 0 1'/>"
    "  <geom type='capsule' size='0.1 0.2'/><body pos='0 0 1'><geom type='sphere' "
    "size='0.1'/></body></body></body>"
    "<body name='rod' pos='-1 1 0'><joint name='d' axis='0 1 0' ref='0.1'/><geom type='cylinder' "
    "size='0.1 0.4'/></body>"
    "</worldbody>"
    "<tendon><fixed name='both' stiffness='5' damping='0.2' springlength='-0.1 0.2'><joint "
    "joint='a' coef='2'/>"
    "<joint joint='b' coef='-1'/></fixed><fixed name='pull'><joint joint='a' coef='1'/><joint "
    "joint='d' coef='3'/>"
    "</fixed><spatial name='rope' stiffness='4' damping='0.1' springlength='0.5'><site "
    "site='hook'/>"
    "<site site='mark'/></spatial></tendon>"
    "<equality><joint name='geared' joint1='b' joint2='d' polycoef='0.01 0.5 0 0 0'/>"
    "<joint name='curved' joint1='c' joint2='d' polycoef='0 0.2 0.3 0.1 0'/></equality>"
    "<actuator><motor name='m1' joint='a' gear='3'/><position name='m2' tendon='pull' kp='6' "
    "gear='2' ctrlrange='-1 1'/>"
    "</actuator><keyframe><key name='up' time='2' ctrl='0.5 -0.25' qpos='1 2 3 1 0 0 0 .1 .2 .3 1 "
    "0 1 0 .4 .5 .6 .7 .8'/>"
    "</keyframe></mujoco>";

/* A loop that is closed as drawn, by a pin and by a weld to the world. */
static const char loop[] =
    "<mujoco><worldbody><body name='a'><joint name='j' axis='0 1 0' ref='20'/><geom type='box' "
    "size='.1 .1 .5'/>"
    "<body name='b' pos='1 0 0'><joint name='k' axis='0 1 0'/><geom type='box' size='.5 .1 "
    ".1'/></body></body>"
    "<body name='c' pos='0 0 1'><joint name='l' type='ball'/><geom type='sphere' "
    "size='0.2'/></body>"
    "<body name='d' pos='2 0 0'><freejoint/><geom type='sphere' size='0.1'/></body></worldbody>"
    "<equality><connect name='pin' body1='b' body2='c' anchor='0.3 0 1'/><weld name='fast' "
    "body1='d'/></equality></mujoco>";

typedef struct trip {
    mbsr_file *file[2]; /* as read, and as read again */
    mbsr_data *data[2];
    mbsr_written *written;
} trip;

static void finish(trip *t, int k)
{
    mbsr_model *m = t->file[k]->model;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &t->data[k], NULL), NULL);
}

static void go_round(trip *t, const char *text, size_t size, const mbsr_file_opt *opt)
{
    mbsr_error error;
    assert_ok(mbsr_file_read(text, size, "first.xml", opt, &t->file[0], &error), &error);
    finish(t, 0);
    assert_ok(mbsr_file_write_mjcf(t->file[0]->model, t->file[0], NULL, &t->written, &error),
              &error);
    assert_int_equal(strlen(t->written->text), t->written->size);
    const int status = mbsr_file_read(t->written->text, t->written->size, "written.xml", NULL,
                                      &t->file[1], &error);
    if (status) print_error("%s\n", t->written->text);
    assert_ok(status, &error);
    finish(t, 1);
}

static void end_trip(trip *t)
{
    for (int k = 0; k < 2; ++k) {
        mbsr_data_destroy(t->data[k]);
        mbsr_file_destroy(t->file[k]);
    }
    mbsr_written_destroy(t->written);
}

static void assert_near(const char *what, int n, const double *x, const double *y, double tolerance)
{
    double most = 1e-3, off = 0.0;
    for (int k = 0; k < n; ++k) {
        most = fmax(most, fabs(x[k]));
        off = fmax(off, fabs(x[k] - y[k]));
    }
    if (!(off <= tolerance * most)) print_error("%s: off by %.3g of %.3g\n", what, off, most);
    assert_true(off <= tolerance * most);
}

static void assert_same_tables(const trip *t)
{
    const mbsr_file *a = t->file[0], *b = t->file[1];
    assert_int_equal(a->bodies, b->bodies);
    assert_int_equal(a->nq, b->nq);
    assert_int_equal(a->nu, b->nu);
    assert_int_equal(mbsr_model_rows(a->model), mbsr_model_rows(b->model));
    assert_int_equal(a->keys, b->keys);
    for (int k = 0; k < a->bodies; ++k)
        if (a->body_name[k][0]) assert_string_equal(a->body_name[k], b->body_name[k]);
    int l = 0;
    for (int k = 0; k < a->joints; ++k) {
        const mbsr_file_joint *j = a->joint + k;
        if (j->kind == MBSR_FILE_FIXED) continue;
        while (b->joint[l].kind == MBSR_FILE_FIXED) ++l;
        const mbsr_file_joint *own = b->joint + l++;
        assert_int_equal(j->kind, own->kind);
        if (j->name[0]) assert_string_equal(j->name, own->name);
        assert_close(j->ref, own->ref, 0.0);
        assert_close(j->friction, own->friction, 0.0);
        assert_int_equal(j->limited, own->limited);
        for (int i = 0; i < 2 && j->limited; ++i) assert_close(j->range[i], own->range[i], 0.0);
    }
    assert_near("q0", a->nq, a->q0, b->q0, 1e-14);
    for (int k = 0; k < a->keys; ++k) assert_near("key", a->nq, a->key[k].q, b->key[k].q, 1e-14);
}

/* Random about what is drawn; controls too. */
static void random_state(const trip *t, test_rng *rng, double *q, double *u, double *udot)
{
    const mbsr_file *f = t->file[0];
    double shift[MOST];
    assert_in_range(f->nq, 0, MOST);
    test_fill(rng, f->nq, shift);
    test_fill(rng, f->nu, u);
    test_fill(rng, f->nu, udot);
    for (int k = 0; k < f->nq; ++k) q[k] = f->q0[k] + 0.3 * shift[k];
    for (int k = 0; k < f->actuators; ++k) t->file[0]->control[k] = 0.7 - 0.2 * k;
    for (int k = 0, l = 0; k < f->actuators; ++k) {
        if (f->actuator[k].force == MBSR_NONE) continue; /* which is not written */
        assert_true(l < t->file[1]->actuators);
        t->file[1]->control[l++] = f->control[k];
    }
}

/* Inverse dynamics of any state, and accelerations where something determines them. */
static double compare(const trip *t, double tolerance)
{
    double q[MOST], u[MOST], udot[MOST], x[2][MOST], pose[2][MBSR_POSE_SIZE], worst = 0.0;
    test_rng rng = test_seed(11);
    assert_same_tables(t);
    for (int round = 0; round < 3; ++round) {
        const mbsr_file *f = t->file[0];
        int status[2];
        random_state(t, &rng, q, u, udot);
        for (int k = 0; k < 2; ++k)
            assert_ok(
                mbsr_inverse_dynamics(t->file[k]->model, t->data[k], 0.0, q, u, udot, NULL, x[k]),
                mbsr_data_error(t->data[k]));
        assert_near("inverse dynamics", f->nu, x[0], x[1], 1e-12);
        for (int b = 0; b < f->bodies; ++b) {
            for (int k = 0; k < 2; ++k) mbsr_body_pose(t->file[k]->model, t->data[k], b, pose[k]);
            assert_near("pose", MBSR_POSE_SIZE, pose[0], pose[1], 1e-12);
        }
        if (mbsr_model_rows(f->model) > 0) /* closed as drawn */
            for (int k = 0; k < f->nq; ++k) q[k] = f->q0[k];
        memset(u, 0, sizeof u);
        for (int k = 0; k < 2; ++k)
            status[k] = mbsr_forward_dynamics(t->file[k]->model, t->data[k], 0.0, q, u, NULL, x[k]);
        assert_int_equal(status[0], status[1]);
        if (status[0] != MBSR_OK && status[0] != MBSR_UNDETERMINED)
            continue; /* loops that do not close */
        assert_near("accelerations", f->nu, x[0], x[1], tolerance);
        for (int k = 0; k < f->nu; ++k)
            worst = fmax(worst, fabs(x[0][k] - x[1][k]) / (1.0 + fabs(x[0][k])));
    }
    return worst;
}

static bool has_finding(const mbsr_written *w, const char *element, const char *words)
{
    for (int k = 0; k < w->findings; ++k)
        if (strstr(w->finding[k].element, element) && strstr(w->finding[k].text, words))
            return true;
    return false;
}

static void all_features_come_back(void **unused)
{
    (void)unused;
    trip t;
    go_round(&t, mechanism, strlen(mechanism), NULL);
    compare(&t, 1e-10);
    const mbsr_file *a = t.file[0], *b = t.file[1];
    assert_string_equal(b->name, "a & b");
    assert_int_equal(a->actuators, b->actuators);
    for (int k = 0; k < a->actuators; ++k) {
        assert_string_equal(a->actuator[k].name, b->actuator[k].name);
        assert_close(a->actuator[k].gear, b->actuator[k].gear, 1e-15);
        assert_close(a->actuator[k].bias[1], b->actuator[k].bias[1], 0.0);
        assert_int_equal(a->actuator[k].limited, b->actuator[k].limited);
        assert_close(a->key[0].control[k], b->key[0].control[k], 0.0);
    }
    const int mark[2] = {mbsr_file_find_site(a, "mark"), mbsr_file_find_site(b, "mark")};
    assert_near("site", 9, a->site[mark[0]].frame.R, b->site[mark[1]].frame.R, 1e-15);
    assert_int_equal(a->shapes, b->shapes);
    for (int k = 0; k < a->shapes; ++k) {
        assert_int_equal(a->shape[k].kind, b->shape[k].kind);
        assert_int_equal(a->shape[k].body, b->shape[k].body);
        assert_int_equal(a->shape[k].visual, b->shape[k].visual);
        if (a->shape[k].mesh) assert_string_equal(a->shape[k].mesh, b->shape[k].mesh);
    }
    assert_true(has_finding(t.written, "body 'light'", "MuJoCo refuses"));
    assert_null(strstr(t.written->text, "fore/b")); /* c has another anchor: joints of one body */
    assert_int_equal(t.written->findings, 1);
    end_trip(&t);
}

/* A file that has sites by the names that the ends of springs get, elsewhere: springs stay where
 * they are, and sites do not become more from time to time. */
static void sites_by_the_names_of_ends(void **unused)
{
    static const char text[] =
        "<mujoco><worldbody><site name='spring_1_a' pos='5 5 5'/><site name='hook' pos='0 0 2'/>"
        "<body name='a'><joint name='j' type='slide' axis='1 0 0' stiffness='3'/>"
        "<geom type='sphere' size='0.1'/><site name='spring_1_b' pos='3 0 1'/>"
        "<site name='eye' pos='0.1 0 0'/></body></worldbody>"
        "<tendon><spatial name='rope' stiffness='4' springlength='0.5'><site site='hook'/>"
        "<site site='eye'/></spatial></tendon></mujoco>";
    trip t;
    (void)unused;
    go_round(&t, text, sizeof text - 1, NULL);
    assert_int_equal(t.file[0]->sites, 4);
    assert_int_equal(t.file[1]->sites, 4);
    (void)compare(&t, 1e-12);
    end_trip(&t);
}

/* Coefficients, groups, margins, excluded bodies and pairs. */
static void contacts_come_back(void **unused)
{
    (void)unused;
    static const char text[] =
        "<mujoco><worldbody><geom name='floor' type='plane' size='1 1 1'/>"
        "<body name='a' pos='0 0 1'><freejoint/><geom name='p' size='.1' contype='6' "
        "conaffinity='9' condim='4' friction='.3 .02 .01' solref='.05 .7' margin='.01'/>"
        "<geom name='q' size='.1' condim='1'/><geom name='r' size='.1' friction='.4'/></body>"
        "<body name='b' pos='1 0 1'><freejoint/><geom name='s' size='.1' condim='6' "
        "friction='.3 .02 .01'/><geom name='t' size='.1' contype='0' conaffinity='0'/></body>"
        "</worldbody><contact><exclude body1='a' body2='b'/><exclude body1='world' body2='a'/>"
        "<pair geom1='p' geom2='s' condim='6' friction='.5 .5 .1 .2 .2' margin='.03'/>"
        "<pair geom1='floor' geom2='t' condim='1' solref='.1 2'/></contact></mujoco>";
    trip t;
    go_round(&t, text, strlen(text), NULL);
    compare(&t, 1e-12);
    const mbsr_file *a = t.file[0], *b = t.file[1];
    assert_int_equal(a->shapes, 6);
    assert_int_equal(b->shapes, 6);
    for (int k = 0; k < 6; ++k) {
        const mbsr_file_shape *x = a->shape + k, *y = b->shape + k;
        assert_string_equal(x->name, y->name);
        assert_int_equal(x->contact, y->contact);
        assert_int_equal(x->groups, y->groups);
        assert_int_equal(x->mask, y->mask);
        assert_near("friction", 3, x->friction, y->friction, 1e-15);
        assert_near("settle", 2, x->settle, y->settle, 1e-15);
        assert_close(x->margin, y->margin, 1e-15);
    }
    assert_int_equal(b->excluded, 2);
    assert_memory_equal(a->exclude, b->exclude, 4 * sizeof *a->exclude);
    assert_int_equal(b->pairs, 2);
    for (int k = 0; k < 2; ++k) {
        assert_memory_equal(a->pair[k].shape, b->pair[k].shape, sizeof a->pair[k].shape);
        assert_near("friction", 3, a->pair[k].friction, b->pair[k].friction, 1e-15);
        assert_near("settle", 2, a->pair[k].settle, b->pair[k].settle, 1e-15);
        assert_close(a->pair[k].margin, b->pair[k].margin, 1e-15);
    }
    assert_int_equal(t.written->findings, 0);
    end_trip(&t);
}

static int load_heights(void *user, const char *path, const char **text, size_t *size)
{
    static const char bytes[] = "\2\0\0\0\3\0\0\0"
                                "\0\0\x80\x3f\0\0\0\x40\0\0\x40\x40"
                                "\0\0\xa0\x40\0\0\xc0\x40\0\0\x10\x41";
    const int shorter = strstr(path, "short") != NULL;
    (void)user;
    *text = bytes;
    *size = sizeof bytes - 1 - (size_t)shorter;
    return strstr(path, ".bin") ? 0 : 2;
}

#define FIELD(words)                                                                               \
    "<mujoco><asset><hfield name='h' size='2 1 4 .5' " words "/></asset><worldbody>"               \
    "<geom type='hfield' hfield='h' pos='0 0 1'/></worldbody></mujoco>"

/* Heights as MuJoCo 3.14 has them, of the same numbers in the text and in a file. */
static void heights_come_back(void **unused)
{
    (void)unused;
    static const char *const text[2] = {FIELD("nrow='2' ncol='3' elevation='1 2 3 5 6 9'"),
                                        FIELD("file='dir/h.bin'")};
    static const double of[2][6] = {{2, 2.5, 4, 0, 0.5, 1}, {0, 0.5, 1, 2, 2.5, 4}};
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load_heights;
    for (int k = 0; k < 2; ++k) {
        trip t;
        go_round(&t, text[k], strlen(text[k]), &opt);
        for (int l = 0; l < 2; ++l) {
            const mbsr_file_shape *s = t.file[l]->shape;
            assert_int_equal(t.file[l]->shapes, 1);
            assert_int_equal(s->kind, MBSR_SHAPE_HEIGHTS);
            assert_int_equal(s->rows, 2);
            assert_int_equal(s->columns, 3);
            assert_int_equal(s->triangles, 4);
            assert_near("height", 6, s->height, of[k], 1e-15);
            assert_near("size", 2, s->size, (const double[2]){2.0, 1.0}, 1e-15);
            assert_near("place", 3, s->frame.x, (const double[3]){0.0, 0.0, 1.0}, 1e-15);
        }
        assert_int_equal(t.file[0]->findings + t.written->findings, 0);
        end_trip(&t);
    }
    static const char *const wrong[][2] = {
        {FIELD("nrow='1' ncol='3'"), "nrow is 1"},
        {FIELD("nrow='2' ncol='1e9'"), "ncol is 1e+09"},
        {FIELD("nrow='4096' ncol='8192'"), "samples"},
        {FIELD("nrow='2' ncol='3' elevation='1 2 3 4 5'"), "nrow times ncol"},
        {FIELD("nrow='2' ncol='3' elevation='1 2 3 4 5 nan'"), "nrow times ncol"}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k)
        assert_file_refused(wrong[k][0], &opt, wrong[k][1]);
    assert_file_refused("<mujoco><worldbody><geom type='hfield' hfield='x'/></worldbody></mujoco>",
                        &opt, "there is no hfield 'x'");
    static const char *const left[][2] = {{FIELD("file='h.png'"), "no such file"},
                                          {FIELD("file='short.bin'"), "as many numbers"}};
    for (int k = 0; k < 2; ++k) {
        mbsr_file *file = read_small(left[k][0], &opt);
        assert_int_equal(file->shapes, 0);
        assert_int_equal(file->findings, 1);
        assert_contains(file->finding[0].text, left[k][1]);
        mbsr_file_destroy(file);
    }
}

static void loops_come_back(void **unused)
{
    (void)unused;
    trip t;
    go_round(&t, loop, strlen(loop), NULL);
    assert_int_equal(mbsr_model_rows(t.file[1]->model), 9);
    compare(&t, 1e-9);
    assert_int_equal(t.written->findings, 0);
    end_trip(&t);
}

/* What is written of: a link `world` without mass with a floating child and others, shapes without
 * size or mesh, names that are there twice, controls of actuators that are left out, tendons along
 * several sites. */
static void what_mujoco_would_refuse_is_not_written(void **unused)
{
    static const char urdf[] = "<robot name='r'><link name='world'/><link name='b'><inertial><mass "
                               "value='2'/><inertia ixx='1' iyy='1' "
                               "izz='1'/></inertial><visual name='v'><geometry><box size='0 1 "
                               "1'/></geometry></visual><visual name='v'>"
                               "<geometry><sphere radius='1'/></geometry></visual><collision "
                               "name='v'><geometry><sphere radius='1'/></geometry>"
                               "</collision><visual><geometry><mesh "
                               "filename='m.dae'/></geometry></visual></link><joint name='j' "
                               "type='floating'><parent link='world'/><child link='b'/><origin "
                               "xyz='1 2 3' rpy='.1 .2 .3'/></joint></robot>";
    static const char mjcf[] = "<mujoco><worldbody><site name='w' pos='0 0 2'/><body "
                               "name='a'><joint name='j' axis='0 1 0'/><geom size='.1' "
                               "pos='0 0 1'/><site name='p' pos='.1 0 .5'/><site name='q' pos='0 "
                               ".2 1'/></body></worldbody><tendon><spatial "
                               "stiffness='4' damping='1' springlength='.1 .2'><site "
                               "site='w'/><site site='p'/><site site='q'/></spatial>"
                               "</tendon><actuator><muscle joint='j'/><motor name='m' "
                               "joint='j'/></actuator><keyframe><key name='k' ctrl='3 "
                               "5'/></keyframe></mujoco>";
    (void)unused;
    trip t;
    go_round(&t, urdf, strlen(urdf), NULL);
    assert_true(has_finding(t.written, "geom 'v'", "size of it is zero"));
    assert_true(has_finding(t.written, "geom ''", "mesh 'm.dae'"));
    assert_null(strstr(t.written->text, "name=\"world\""));
    const double p[7] = {0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5}, v[6] = {1, 2, 3, 4, 5, 6};
    double q[7], u[6], pose[2][MBSR_POSE_SIZE];
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_file_mujoco_state(t.file[k], 0, p, v, q, u), NULL);
        assert_ok(mbsr_stage_positions(t.file[k]->model, t.data[k], 0.0, q), NULL);
        assert_ok(mbsr_body_pose(t.file[k]->model, t.data[k], 1, pose[k]), NULL);
    }
    assert_near("pose", MBSR_POSE_SIZE, pose[0], pose[1], 1e-14);
    end_trip(&t);
    go_round(&t, mjcf, strlen(mjcf), NULL);
    assert_int_equal(t.file[1]->actuators, 1);
    assert_close(t.file[1]->key[0].control[0], 5.0, 0.0);
    assert_int_equal(t.written->findings, 1);
    compare(&t, 1e-11);
    end_trip(&t);
}

/* Free joints on bodies that do not move are moved to the world, behind what else these carry. */
static void coordinates_in_another_order_are_found(void **unused)
{
    static const char urdf[] =
        "<robot name='r'><link name='base'/><link name='b'><inertial><mass value='2'/><inertia "
        "ixx='1' iyy='1' izz='1'/></inertial></link><link name='c'><inertial><mass value='2'/>"
        "<inertia ixx='1' iyy='1' izz='1'/></inertial></link><joint name='f' type='floating'>"
        "<parent link='base'/><child link='b'/></joint><joint name='h' type='revolute'><parent "
        "link='base'/><child link='c'/></joint></robot>";
    (void)unused;
    trip t;
    go_round(&t, urdf, strlen(urdf), NULL);
    assert_true(has_finding(t.written, "joint 'f'", "come later"));
    assert_int_equal(t.written->findings, 1);
    assert_string_equal(t.file[0]->joint[0].name, "f");
    assert_string_equal(t.file[1]->joint[0].name, "h");
    end_trip(&t);
}

static int has_none(void *user, const char *path)
{
    *(int *)user += strcmp(path, "m.stl") == 0;
    return 0;
}

static void the_caller_says_which_meshes_there_are(void **unused)
{
    (void)unused;
    int asked = 0;
    mbsr_written *written;
    mbsr_write_opt opt = mbsr_default_write_opt();
    mbsr_file *file = read_small(mechanism, NULL);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    opt.has_mesh = has_none;
    opt.user = &asked;
    opt.mesh_folder = "over/there";
    assert_ok(mbsr_file_write_mjcf(file->model, file, &opt, &written, NULL), NULL);
    assert_true(asked > 0);
    assert_true(has_finding(written, "geom ''", "mesh 'm.stl'"));
    assert_null(strstr(written->text, "m.stl"));
    assert_non_null(strstr(written->text, "meshdir=\"over/there\""));
    mbsr_written_destroy(written);
    mbsr_file_destroy(file);
}

/* ---- files ---- */

static char *load(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    const long length = ftell(file);
    rewind(file);
    char *text = malloc((size_t)length + 1);
    *size = fread(text, 1, (size_t)length, file);
    fclose(file);
    return text;
}

static void check_file(const char *folder, const char *name)
{
    char path[600];
    size_t size = 0;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    char *text = load(path, &size);
    if (!text) print_error("%s is missing\n", path);
    assert_non_null(text);
    for (int floating = 0; floating < 2; ++floating) {
        mbsr_file_opt opt = mbsr_default_file_opt();
        trip t;
        opt.floating = floating;
        go_round(&t, text, size, &opt);
        print_message("%s: off by %.2g, %d findings\n", name, compare(&t, 1e-7),
                      t.written->findings);
        end_trip(&t);
    }
    free(text);
}

static void examples_come_back(void **unused)
{
    (void)unused;
    check_file(TEST_FOLDER "/examples/models", "arm.urdf");
    check_file(TEST_FOLDER "/examples/models", "quarter_car.xml");
}

static void robots_come_back(void **unused)
{
    (void)unused;
    static const char *const names[] = {"urdf/baxter.urdf",
                                        "urdf/bolt.urdf",
                                        "urdf/romeo.urdf",
                                        "urdf/simple_humanoid.urdf",
                                        "urdf/double_pendulum_continuous.urdf",
                                        "urdf/synthetic_tree.urdf",
                                        "mjcf/2f85.xml",
                                        "mjcf/cassie.xml",
                                        "mjcf/panda.xml",
                                        "mjcf/ur5e.xml",
                                        "mjcf/synthetic.xml"};
    const char *folder = getenv("MBSR_ROBOTS");
    if (!folder) {
        print_message("skipped: MBSR_ROBOTS is not set\n");
        skip();
    }
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) check_file(folder, names[k]);
}

/* ---- models that were not read ---- */

static mbsr_model *chain_of(const mbsr_joint *joints, int count)
{
    mbsr_model *m;
    const double I[6] = {0.1, 0.2, 0.25, 0.01, 0.0, 0.02}, centre[3] = {0.1, -0.2, 0.3};
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < count; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.name = "same"; /* names that are no names in MJCF */
        body.parent = k > 0 ? k - 1 : MBSR_GROUND;
        body.joint = joints[k];
        body.inertia = mbsr_inertia_rigid(1.0 + k, centre, I);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    return m;
}

static void models_of_c_are_written(void **unused)
{
    (void)unused;
    const double axis[3] = {0.3, -0.5, 0.8}, other[3] = {1.0, 0.0, 0.2};
    const mbsr_frame A = mbsr_frame_rotated((const double[3]){0.1, 0.2, 0.3}, axis, 0.7),
                     B = mbsr_frame_rotated((const double[3]){-0.3, 0.1, 0.2}, other, -0.4);
    const mbsr_joint joints[] = {mbsr_joint_universal(&A, &B, axis, other),
                                 mbsr_joint_cylindrical(&B, &A, other), mbsr_joint_in_plane(&A, &B),
                                 mbsr_joint_weld(&B, &A), mbsr_joint_revolute(&B, NULL, axis)};
    mbsr_model *m = chain_of(joints, 5);
    const mbsr_force_def forces[] = {mbsr_force_gravity(0.0, 0.5, -9.81),
                                     mbsr_force_joint_spring(1, 1, 20.0, 0.5, 0.2),
                                     mbsr_force_joint_spring(1, 1, 10.0, 0.0, -0.1),
                                     mbsr_force_joint_stop(4, 0, -1.0, 1.0, 100.0, 0.0),
                                     mbsr_force_point_spring(0, axis, 4, other, 30.0, 0.2, 0.7)};
    for (int k = 0; k < 5; ++k)
        assert_ok(mbsr_model_add_force(m, forces + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_written *written;
    mbsr_error error;
    assert_ok(mbsr_file_write_mjcf(m, NULL, NULL, &written, &error), &error);
    assert_int_equal(written->findings, 1);
    assert_true(has_finding(written, "force 3", "is left out"));
    mbsr_file *file = read_small(written->text, NULL);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    double q[MOST], u[MOST], udot[2][MOST];
    test_rng rng = test_seed(3);
    test_fill(&rng, mbsr_model_nq(m), q);
    test_fill(&rng, mbsr_model_nu(m), u);
    const mbsr_model *const both[] = {m, file->model};
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        assert_int_equal(mbsr_model_nq(both[k]), mbsr_model_nq(m));
        assert_ok(mbsr_data_create(both[k], &d, NULL), NULL);
        assert_ok(mbsr_forward_dynamics(both[k], d, 0.0, q, u, NULL, udot[k]), mbsr_data_error(d));
        mbsr_data_destroy(d);
    }
    assert_near("accelerations", mbsr_model_nu(m), udot[0], udot[1], 1e-11);
    mbsr_file_destroy(file);
    mbsr_written_destroy(written);
    mbsr_write_opt opt = mbsr_default_write_opt();
    opt.strict = 1;
    assert_int_equal(mbsr_file_write_mjcf(m, NULL, &opt, &written, &error), MBSR_ERR_FILE);
    assert_null(written);
    assert_contains(error.text, "force 3");
    mbsr_model_destroy(m);
}

static void assert_not_written(mbsr_model *m, const char *words)
{
    mbsr_written *written;
    mbsr_error error;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_file_write_mjcf(m, NULL, NULL, &written, &error), MBSR_ERR_SPACE);
    assert_null(written);
    assert_contains(error.text, words);
    mbsr_model_destroy(m);
}

static void what_mjcf_has_not_is_refused(void **unused)
{
    (void)unused;
    const double z[3] = {0.0, 0.0, 1.0};
    mbsr_joint joints[2] = {mbsr_joint_revolute(NULL, NULL, z),
                            mbsr_joint_screw(NULL, NULL, z, 0.1)};
    assert_not_written(chain_of(joints, 2), "body 1 'same': MJCF has no screws");
    joints[1] = mbsr_joint_free(NULL, NULL);
    assert_not_written(chain_of(joints, 2), "begin at the world");
    joints[1] = mbsr_joint_cylindrical(NULL, NULL, z);
    mbsr_model *m = chain_of(joints, 2);
    assert_ok(mbsr_model_lock(m, 1, 0, 0.2), mbsr_model_error(m));
    assert_not_written(m, "are locked");
    mbsr_body_def body = mbsr_default_body_def();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_not_written(m, "none that MJCF has");
}

/* Memory that ends after so many pieces. */
static void *take(void *user, size_t size)
{
    int *left = user;
    return (*left)-- > 0 ? malloc(size) : NULL;
}

static void release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* Names of any letters come back; what MJCF has no words for is told, and left out. */
static void what_mjcf_cannot_say_is_told(void **unused)
{
    (void)unused;
    static const char name[] = "a<b>&\"c'\n\r\td";
    const double z[3] = {0.0, 0.0, 1.0}, flat[6] = {1.0, 1.0, 5.0}, thin[6] = {0.0, 1.0, 1.0},
                 none[3] = {0.0},
                 M[36] = {[0] = 1, [7] = 1, [14] = 1, [21] = 2, [28] = 3, [35] = 4};
    const mbsr_frame turned = mbsr_frame_rotated(none, z, 0.3);
    const mbsr_inertia inertia[] = {
        mbsr_inertia_matrix(6, M), mbsr_inertia_rigid_unchecked(1.0, none, flat),
        mbsr_inertia_rigid(1.0, none, thin), mbsr_inertia_point_mass(1.0, none)};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 4; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.name = k == 0 ? name : NULL;
        body.joint =
            k == 3 ? mbsr_joint_spherical(NULL, &turned) : mbsr_joint_revolute(NULL, NULL, z);
        body.inertia = inertia[k];
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_closure_def rod = mbsr_closure_distance(0, z, 1, none, 1.0);
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_written *written;
    mbsr_error error;
    assert_ok(mbsr_file_write_mjcf(m, NULL, NULL, &written, &error), &error);
    assert_true(has_finding(written, "closure 0", "cannot say this 'distance'"));
    assert_true(has_finding(written, "body 'a<b>", "no rigid body's"));
    assert_true(has_finding(written, "body 'body_1'", "above the sum"));
    assert_true(has_finding(written, "body 'body_2'", "about some axis"));
    assert_true(has_finding(written, "joint", "along the body's axes"));
    mbsr_file *file = read_small(written->text, NULL);
    assert_string_equal(file->body_name[0], name);
    mbsr_file_destroy(file);
    mbsr_written_destroy(written);
    mbsr_model_destroy(m);
}

/* A tensor that no body has, off the origin and turned, is the same again. */
static void negative_moments_come_back(void **unused)
{
    (void)unused;
    mbsr_file *file[2];
    mbsr_written *written;
    mbsr_error error;
    double D[2];
    file[0] = read_small("<mujoco><worldbody><body><joint axis='0 1 0'/><inertial pos='1 2 3' "
                         "mass='2' euler='30 40 50' diaginertia='5 4 -1'/></body></worldbody>"
                         "</mujoco>",
                         NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d;
        const double q[1] = {0.0};
        assert_int_equal(file[k]->findings, 1);
        assert_found(file[k], "inertial", "moment of inertia is negative");
        assert_ok(mbsr_model_finish(file[k]->model), mbsr_model_error(file[k]->model));
        assert_ok(mbsr_data_create(file[k]->model, &d, NULL), NULL);
        assert_ok(mbsr_stage_positions(file[k]->model, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(file[k]->model, d, q), mbsr_data_error(d));
        assert_ok(mbsr_mass_matrix(file[k]->model, d, D + k), mbsr_data_error(d));
        mbsr_data_destroy(d);
        if (k > 0) break;
        assert_ok(mbsr_file_write_mjcf(file[0]->model, file[0], NULL, &written, &error), &error);
        file[1] = read_small(written->text, NULL);
        mbsr_written_destroy(written);
    }
    assert_close(D[1], D[0], 1e-12 * D[0]);
    assert_true(D[0] > 10.0);
    for (int k = 0; k < 2; ++k) mbsr_file_destroy(file[k]);
}

static void wrong_calls_are_refused(void **unused)
{
    (void)unused;
    mbsr_written *written;
    mbsr_error error;
    mbsr_write_opt opt = mbsr_default_write_opt();
    mbsr_file *file = read_small("<mujoco/>", NULL), *other = read_small(loop, NULL);
    assert_int_equal(mbsr_file_write_mjcf(NULL, NULL, NULL, &written, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_write_mjcf(file->model, NULL, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_write_mjcf(file->model, file, NULL, &written, &error),
                     MBSR_ERR_UNFINISHED);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_int_equal(mbsr_file_write_mjcf(file->model, other, NULL, &written, &error),
                     MBSR_ERR_MISMATCH);
    opt.allocator.allocate = take;
    assert_int_equal(mbsr_file_write_mjcf(file->model, file, &opt, &written, &error),
                     MBSR_ERR_VALUE);
    assert_contains(error.text, "one of its two functions");
    opt.cookie = 0;
    assert_int_equal(mbsr_file_write_mjcf(file->model, file, &opt, &written, NULL),
                     MBSR_ERR_NO_DEFAULT);
    assert_ok(mbsr_file_write_mjcf(file->model, file, NULL, &written, &error),
              &error); /* no bodies */
    mbsr_written_destroy(written);
    mbsr_written_destroy(NULL);
    mbsr_file_destroy(file);
    mbsr_file_destroy(other);
}

static void memory_may_end_anywhere(void **unused)
{
    (void)unused;
    mbsr_file *file = read_small(mechanism, NULL);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    int status = MBSR_ERR_NO_MEMORY, pieces = 0;
    for (; status == MBSR_ERR_NO_MEMORY && pieces < 1000; ++pieces) {
        int left = pieces;
        mbsr_written *written;
        mbsr_write_opt opt = mbsr_default_write_opt();
        opt.allocator = (mbsr_allocator){take, release, &left};
        status = mbsr_file_write_mjcf(file->model, file, &opt, &written, NULL);
        mbsr_written_destroy(written);
    }
    assert_int_equal(status, MBSR_OK);
    mbsr_file_destroy(file);
}

static void numbers_have_a_point_in_every_locale(void **unused)
{
    (void)unused;
    if (!test_locale_comma()) skip();
    trip t;
    go_round(&t, mechanism, strlen(mechanism), NULL);
    compare(&t, 1e-10);
    end_trip(&t);
    test_locale_back();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_features_come_back),
        cmocka_unit_test(sites_by_the_names_of_ends),
        cmocka_unit_test(contacts_come_back),
        cmocka_unit_test(heights_come_back),
        cmocka_unit_test(loops_come_back),
        cmocka_unit_test(what_mujoco_would_refuse_is_not_written),
        cmocka_unit_test(coordinates_in_another_order_are_found),
        cmocka_unit_test(the_caller_says_which_meshes_there_are),
        cmocka_unit_test(examples_come_back),
        cmocka_unit_test(robots_come_back),
        cmocka_unit_test(models_of_c_are_written),
        cmocka_unit_test(what_mjcf_has_not_is_refused),
        cmocka_unit_test(what_mjcf_cannot_say_is_told),
        cmocka_unit_test(negative_moments_come_back),
        cmocka_unit_test(wrong_calls_are_refused),
        cmocka_unit_test(memory_may_end_anywhere),
        cmocka_unit_test(numbers_have_a_point_in_every_locale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
