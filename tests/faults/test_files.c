/* Files are read, expanded and written, where each place of the component files fails at which it
 * is taken whether something succeeded.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "faults.h"

#include <mbsrank/files.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { NUMBERS = 128, MOST = 1 << 16 };

static double out[NUMBERS];

/* A text of a file, and for xacro behind a form feed the YAML that it loads. */
typedef struct given {
    const char *name;
    char text[MOST];
    size_t size, yaml;
} given;

static given it;

/* What files name: parts, and the YAML. */
static int load(void *user, const char *path, const char **text, size_t *size)
{
    static const char *const parts[][2] = {
        {"part.xml", "<mujoco><worldbody><body name='o'><joint/></body></worldbody></mujoco>"},
        {"part.sdf", "<sdf version='1.8'><model name='x'><link name='f'/></model></sdf>"}};
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    (void)user;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        if (strcmp(name, parts[k][0]) != 0) continue;
        *text = parts[k][1], *size = strlen(*text);
        return 0;
    }
    if (it.yaml == 0 || strstr(path, "missing")) return 2; /* ENOENT everywhere */
    const bool yaml = strstr(path, ".yaml") != NULL;
    *text = yaml ? it.text + it.size + 1 : it.text;
    *size = yaml ? it.yaml : it.size;
    return 0;
}

static mbsr_file_opt options(void)
{
    static const mbsr_file_package package = {"here", "folder/"};
    static const mbsr_xacro_argument argument = {"given", "0.5"};
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load;
    opt.stop_stiffness = 10.0;
    opt.slip = 1e-3;
    opt.hull_corners = 8;
    opt.packages = opt.xacro.arguments = 1;
    opt.package = &package;
    opt.xacro.argument = &argument;
    return opt;
}

static void open_file(const char *path, const char *name)
{
    char whole[600];
    snprintf(whole, sizeof whole, "%s/%s/%s", TEST_FOLDER, path, name);
    FILE *file = fopen(whole, "rb");
    assert_non_null(file);
    it.name = name;
    it.size = fread(it.text, 1, MOST, file);
    fclose(file);
    assert_in_range(it.size, 1, MOST - 1);
    const char *mark = memchr(it.text, '\f', it.size);
    it.yaml = mark ? it.size - (size_t)(mark - it.text) - 1 : 0;
    if (mark) it.size -= it.yaml + 1;
}

/* ---- acts ---- */

/* What was read: counts, where bodies are, what they weigh. */
static int take_file(mbsr_file *file)
{
    mbsr_data *d = NULL;
    int status = mbsr_model_finish(file->model);
    out[3] = file->findings, out[4] = file->shapes, out[5] = file->sensors, out[6] = file->sites;
    out[7] = file->actuators, out[8] = file->keys, out[9] = file->excluded + file->pairs;
    out[10] = mbsr_model_forces(file->model), out[11] = mbsr_model_closures(file->model);
    if (!status) status = mbsr_data_create(file->model, &d, NULL);
    if (!status) status = mbsr_stage_positions(file->model, d, 0.0, file->q0);
    for (int k = 0; k < mbsr_model_bodies(file->model) && !status; ++k) {
        mbsr_body_def def;
        status = mbsr_body_pose(file->model, d, k, out + 12 + 12 * (k % 8));
        (void)mbsr_body_definition(file->model, k, &def);
        out[110 + k % 8] += def.inertia.mass + def.inertia.tensor[0] + def.inertia.com[2];
    }
    mbsr_data_destroy(d);
    return status;
}

static int is_read(void *user)
{
    const mbsr_file_opt opt = options();
    mbsr_file *file = NULL;
    (void)user;
    int status = mbsr_file_read(it.text, it.size, it.name, &opt, &file, NULL);
    if (!status) status = take_file(file);
    mbsr_file_destroy(file);
    return status;
}

/* All sensors at the start, and that state as MuJoCo counts. */
static int is_sensed(void *user)
{
    enum { MOST_COORDINATES = 200 };
    const mbsr_file_opt opt = options();
    static double q[MOST_COORDINATES], u[MOST_COORDINATES], rest[MOST_COORDINATES],
        udot[MOST_COORDINATES];
    mbsr_file *file = NULL;
    mbsr_data *d = NULL;
    (void)user;
    int status = mbsr_file_read(it.text, it.size, it.name, &opt, &file, NULL);
    if (!status) status = mbsr_model_finish(file->model);
    if (!status && file->nq > MOST_COORDINATES) status = MBSR_ERR_VALUE;
    if (!status) status = mbsr_data_create(file->model, &d, NULL);
    if (!status) status = mbsr_file_mujoco_state(file, 1, file->q0, rest, q, u);
    for (int k = 0; !status && k < file->nu && k < 20; ++k) out[100 + k] = q[k] + u[k];
    if (!status) status = mbsr_forward_dynamics(file->model, d, 0.0, file->q0, rest, NULL, udot);
    if (!status) status = mbsr_stage_accelerations(file->model, d, udot);
    for (int k = 0; !status && k < file->sensors; ++k)
        status = mbsr_file_sense(file, k, file->model, d, 0.0, file->q0, rest, out + 4 * (k % 25));
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
    return status;
}

/* What a text is, as numbers. */
static void take_text(const mbsr_written *w)
{
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t k = 0; k < w->size; ++k)
        sum = (sum ^ (unsigned char)w->text[k]) * UINT64_C(1099511628211);
    out[0] = (double)(sum >> 32), out[1] = (double)(sum & 0xffffffffu);
    out[2] = (double)w->size, out[3] = w->findings;
}

/* Of what can be written as MJCF. */
static int is_written(void *user)
{
    const mbsr_file_opt opt = options();
    mbsr_file *file = NULL;
    mbsr_written *written = NULL;
    (void)user;
    int status = mbsr_file_read(it.text, it.size, it.name, &opt, &file, NULL);
    if (!status) status = mbsr_model_finish(file->model);
    if (!status) status = mbsr_file_write_mjcf(file->model, file, NULL, &written, NULL);
    if (!status) take_text(written);
    mbsr_written_destroy(written);
    mbsr_file_destroy(file);
    return status;
}

static int is_expanded(void *user)
{
    const mbsr_file_opt opt = options();
    mbsr_written *written = NULL;
    (void)user;
    const int status = mbsr_file_expand_xacro(it.text, it.size, it.name, &opt, &written, NULL);
    if (!status) take_text(written);
    mbsr_written_destroy(written);
    return status;
}

static long each(const char *name, int (*call)(void *user))
{
    const test_faults_act act = {name, call, NULL, out, NUMBERS, 1e-10, 0};
    return test_faults_each(&act);
}

static void of_models(void **state)
{
    static const char *const names[][2] = {
        {"tests/fuzz/corpus", "small.urdf"},   {"tests/fuzz/corpus", "small.xml"},
        {"tests/fuzz/corpus", "small.sdf"},    {"tests/fuzz/corpus", "attributes.xml"},
        {"tests/fuzz/corpus", "elements.sdf"}, {"examples/models", "gripper.xml"},
        {"examples/models", "suspension.xml"}, {"examples/models", "wiper.sdf"}};
    (void)state;
    long failed = 0;
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        open_file(names[k][0], names[k][1]);
        assert_int_equal(is_read(NULL), MBSR_OK);
        failed += each("is read", is_read) + each("is written", is_written);
    }
    assert_in_range(failed, 100, 100000);
}

static const char with_sensors[] =
    "<mujoco><worldbody><body name='a' pos='0 0 1'><joint name='h' axis='0 1 0' damping='1'/>"
    "<geom size='.1 .2' type='capsule'/><site name='s' pos='.1 0 0' euler='10 20 30'/>"
    "<body name='b' pos='.5 0 0'><joint name='l' type='ball'/><geom size='.1'/>"
    "<site name='o' pos='0 0 .2'/></body></body></worldbody>"
    "<tendon><fixed name='t'><joint joint='h' coef='2'/></fixed></tendon>"
    "<actuator><position name='m' joint='h' kp='3' ctrlrange='-1 1' forcerange='-2 2'/></actuator>"
    "<sensor><accelerometer site='s' cutoff='3'/><gyro site='s'/><velocimeter site='o'/>"
    "<force site='s'/><torque site='o'/><jointpos joint='h'/><jointvel joint='h'/>"
    "<ballquat joint='l'/><ballangvel joint='l'/><tendonpos tendon='t'/><tendonvel tendon='t'/>"
    "<actuatorpos actuator='m'/><actuatorvel actuator='m'/><actuatorfrc actuator='m'/>"
    "<framepos objtype='site' objname='s' reftype='site' refname='o'/>"
    "<framequat objtype='body' objname='b' reftype='body' refname='a'/>"
    "<framezaxis objtype='site' objname='s'/><framelinvel objtype='site' objname='s'/>"
    "<frameangvel objtype='body' objname='b' reftype='site' refname='s'/>"
    "<framelinacc objtype='site' objname='o'/><frameangacc objtype='xbody' objname='b'/>"
    "<subtreecom body='a'/><subtreelinvel body='a'/><subtreeangmom body='b'/><clock/>"
    "</sensor></mujoco>";

static void of_sensors(void **state)
{
    (void)state;
    it = (given){.name = "sensors.xml", .size = sizeof with_sensors - 1};
    memcpy(it.text, with_sensors, it.size);
    assert_int_equal(is_sensed(NULL), MBSR_OK);
    assert_in_range(each("is sensed", is_sensed), 40, 100000);
}

static void of_xacro(void **state)
{
    (void)state;
    open_file("tests/fuzz/corpus", "small.xacro");
    assert_int_equal(is_expanded(NULL), MBSR_OK);
    assert_in_range(each("is expanded", is_expanded), 40, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_models), cmocka_unit_test(of_sensors),
                                       cmocka_unit_test(of_xacro)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
