/* Robots from files against references that were computed without this library. The data are other
 * people's and stay out of the project: the variable MBSR_ROBOTS of the environment tells their
 * folder, with urdf/, mjcf/ and ref/; skipped without.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "json.h"

#include <mbsrank/files.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdio.h>

enum { MOST = 128 };

static char folder[400];

static char *load(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    fseek(file, 0, SEEK_END);
    const long length = ftell(file);
    rewind(file);
    char *text = malloc((size_t)length + 1);
    *size = fread(text, 1, (size_t)length, file);
    text[*size] = '\0';
    fclose(file);
    return text;
}

static json *load_reference(const char *name, char **text)
{
    char path[512];
    size_t size;
    snprintf(path, sizeof path, "%s/ref/%s.json", folder, name);
    *text = load(path, &size);
    if (!*text) return NULL;
    char *at = *text;
    return json_parse(&at);
}

typedef struct robot {
    char *text;
    mbsr_file *file;
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
} robot;

static void open_robot(robot *r, const json *ref, const mbsr_file_opt *opt, double more)
{
    char path[512];
    size_t size;
    mbsr_error error;
    const char *format = json_get(ref, "format")->text;
    snprintf(path, sizeof path, "%s/%s/%s", folder, format, json_get(ref, "file")->text);
    r->text = load(path, &size);
    assert_non_null(r->text);
    assert_ok(mbsr_file_read(r->text, size, path, opt, &r->file, &error), &error);
    r->model = r->file->model;
    for (int k = 0; k < r->file->joints && more > 0.0; ++k) {
        const mbsr_file_joint *j = r->file->joint + k;
        if (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_SLIDE)
            assert_ok(mbsr_model_armature(r->model, j->body, 1, &more), mbsr_model_error(r->model));
    }
    assert_ok(mbsr_model_finish(r->model), mbsr_model_error(r->model));
    assert_ok(mbsr_data_create(r->model, &r->data, NULL), NULL);
    r->nq = mbsr_model_nq(r->model);
    r->nu = mbsr_model_nu(r->model);
    assert_int_equal(r->nq, r->file->nq);
    assert_int_equal(r->nu, r->file->nu);
    assert_true(r->nq <= MOST);
}

static void close_robot(robot *r)
{
    mbsr_data_destroy(r->data);
    mbsr_file_destroy(r->file);
    free(r->text);
}

static double most_of(int n, const double *x)
{
    return 1e-3 + test_largest(n, x);
}

/* The largest difference relative to the largest number. */
static double compare(const char *model, const char *what, int n, const double *x,
                      const double *expected, double tolerance)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k] - expected[k]));
    most /= most_of(n, expected);
    if (!(most <= tolerance)) print_error("%s: %s off by %.3g\n", model, what, most);
    assert_true(most <= tolerance);
    return most;
}

static double *numbers(const json *of, const char *key, double *to)
{
    const json *list = json_get(of, key);
    return list && json_numbers(list, MOST, to) == list->count ? to : NULL;
}

/* What stands in the coordinates of MuJoCo in those of the model: rates, accelerations and forces
 * alike. */
static void convert(const robot *r, const double *qpos, const double *x, double *q, double *y)
{
    assert_int_equal(mbsr_file_mujoco_state(r->file, 0, qpos, x, q, y), MBSR_OK);
}

static void check_names(const robot *r, const json *ref)
{
    const json *joints = json_get(ref, "joints"), *bodies = json_get(ref, "bodies");
    static const char *const kinds[] = {"fixed", "hinge", "slide", "ball", "free"};
    int k = 0;
    assert_int_equal(joints->count, r->file->joints);
    for (const json *j = joints->child; j; j = j->next, ++k) {
        const mbsr_file_joint *own = r->file->joint + k;
        const char *name = json_get(j, "name")->text;
        assert_string_equal(json_get(j, "type")->text, kinds[own->kind]);
        if (strcmp(name, "root_free") != 0) assert_string_equal(name, own->name);
        assert_close(json_get(j, "ref")->number, own->ref, 1e-15);
    }
    for (const json *b = bodies->child; b; b = b->next) {
        const char *name = json_get(b, "name")->text;
        int id = 0;
        while (id < r->file->bodies && strcmp(r->file->body_name[id], name) != 0) ++id;
        assert_true(id < r->file->bodies);
    }
}

static void check_poses(const robot *r, const json *ref, const json *state, const char *model)
{
    const json *pos = json_get(state, "body_pos"), *quat = json_get(state, "body_quat"),
               *bodies = json_get(ref, "bodies");
    const json *p = pos->child, *w = quat ? quat->child : NULL;
    for (const json *b = bodies->child; b && p; b = b->next, p = p->next) {
        double pose[MBSR_POSE_SIZE], x[3], q[4], R[9];
        const int id = mbsr_model_find_body(r->model, json_get(b, "name")->text);
        json_numbers(p, 3, x);
        assert_ok(mbsr_body_pose(r->model, r->data, id, pose), mbsr_data_error(r->data));
        compare(model, json_get(b, "name")->text, 3, pose + MBSR_POSE_X, x, 1e-12);
        if (!w) continue;
        json_numbers(w, 4, q);
        mbsr_quaternion_rotation(q, R);
        compare(model, "axes", 9, pose, R, 1e-12);
        w = w->next;
    }
}

static double check_state(robot *r, const json *state, int passive, const char *model)
{
    double qpos[MOST], x[MOST], q[MOST], u[MOST], y[MOST], expected[MOST], out[MOST], worst = 0.0;
    const json *numpy = json_get(state, "numpy");
    const json *added = json_get(state, "armature_added");
    const bool singular = json_get(state, "M_singular")->truth;
    assert_non_null(numbers(state, "q", qpos));
    assert_non_null(numbers(state, "v", x));
    convert(r, qpos, x, q, u);
    assert_non_null(numbers(state, "qacc_in", x));
    convert(r, qpos, x, q, y);
    if (!added || !singular) {
        assert_ok(mbsr_inverse_dynamics(r->model, r->data, 0.0, q, u, y, NULL, out),
                  mbsr_data_error(r->data));
        assert_non_null(numbers(numpy, passive ? "qfrc_inverse" : "qfrc_inverse_nopassive", x));
        convert(r, qpos, x, q, expected);
        worst = fmax(worst, compare(model, "qfrc_inverse", r->nu, out, expected, 1e-11));
    }
    const json *of = singular ? added : numpy;
    if (!of) return worst;
    assert_non_null(numbers(state, "tau", x));
    convert(r, qpos, x, q, y);
    assert_ok(mbsr_forward_dynamics(r->model, r->data, 0.0, q, u, y, out),
              mbsr_data_error(r->data));
    assert_non_null(numbers(of, passive ? "qacc" : "qacc_nopassive", x));
    convert(r, qpos, x, q, expected);
    const json *cond = json_get(state, "cond_M_scaled");
    const double condition = cond && cond->number > 1.0 ? cond->number : 1e3;
    worst = fmax(worst, compare(model, "qacc", r->nu, out, expected, 1e-11 * condition));
    return worst;
}

static void check_tree(const json *ref, const char *model)
{
    double worst = 0.0;
    const json *states = json_get(ref, "states");
    const bool singular = json_get(states->child, "M_singular")->truth;
    for (int passive = 0; passive < 2; ++passive) {
        mbsr_file_opt opt = mbsr_default_file_opt();
        robot r;
        opt.floating = strcmp(json_get(ref, "base")->text, "floating") == 0;
        opt.closures = opt.actuators = 0;
        opt.passive = passive;
        open_robot(&r, ref, &opt, singular ? 0.01 : 0.0);
        check_names(&r, ref);
        for (const json *s = states->child; s; s = s->next) {
            worst = fmax(worst, check_state(&r, s, passive, model));
            check_poses(&r, ref, s, model);
        }
        double mass, momentum[6];
        assert_ok(mbsr_tree_momentum(r.model, r.data, NULL, &mass, NULL, momentum),
                  mbsr_data_error(r.data));
        assert_close(mass, json_get(ref, "total_mass")->number, 1e-12 * mass);
        close_robot(&r);
    }
    print_message("%s: off by %.2g\n", model, worst);
}

/* Where the mass matrix is singular: the forces, and that it is said to be. */
static void check_singular(const json *ref, const char *model)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    robot r;
    const json *state = json_get(ref, "states")->child;
    double qpos[MOST], x[MOST], q[MOST], u[MOST], y[MOST], expected[MOST], out[MOST];
    opt.floating = strcmp(json_get(ref, "base")->text, "floating") == 0;
    opt.closures = opt.actuators = 0;
    open_robot(&r, ref, &opt, 0.0);
    numbers(state, "q", qpos), numbers(state, "v", x);
    convert(&r, qpos, x, q, u);
    numbers(state, "qacc_in", x);
    convert(&r, qpos, x, q, y);
    assert_ok(mbsr_inverse_dynamics(r.model, r.data, 0.0, q, u, y, NULL, out),
              mbsr_data_error(r.data));
    numbers(json_get(state, "numpy"), "qfrc_inverse", x);
    convert(&r, qpos, x, q, expected);
    compare(model, "qfrc_inverse", r.nu, out, expected, 1e-11);
    assert_int_equal(mbsr_forward_dynamics(r.model, r.data, 0.0, q, u, NULL, out),
                     MBSR_UNDETERMINED);
    assert_ok(mbsr_stage_positions(r.model, r.data, 0.0, q), mbsr_data_error(r.data));
    assert_ok(mbsr_stage_velocities(r.model, r.data, u), mbsr_data_error(r.data));
    assert_ok(mbsr_stage_forces(r.model, r.data, NULL), mbsr_data_error(r.data));
    assert_ok(mbsr_stage_backward(r.model, r.data), mbsr_data_error(r.data));
    assert_int_equal(mbsr_total_rank(r.model, r.data), (int)json_get(state, "rank_M")->number);
    close_robot(&r);
}

static void check_loops(const json *ref, const char *model)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    robot r;
    double worst = 0.0;
    opt.actuators = 0;
    open_robot(&r, ref, &opt, 0.0);
    const json *states = json_get(json_get(ref, "loops"), "states");
    for (const json *s = states->child; s; s = s->next) {
        double qpos[MOST], x[MOST], q[MOST], u[MOST], tau[MOST], expected[MOST], out[MOST];
        numbers(s, "q", qpos), numbers(s, "v", x);
        convert(&r, qpos, x, q, u);
        numbers(s, "tau", x);
        convert(&r, qpos, x, q, tau);
        assert_int_equal(mbsr_model_rows(r.model), (int)json_get(s, "rows")->number);
        assert_ok(mbsr_forward_dynamics(r.model, r.data, 0.0, q, u, tau, out),
                  mbsr_data_error(r.data));
        numbers(s, "qacc", x);
        convert(&r, qpos, x, q, expected);
        worst = fmax(worst, compare(model, "qacc with loops", r.nu, out, expected, 1e-8));
    }
    print_message("%s: with loops off by %.2g\n", model, worst);
    close_robot(&r);
}

/* Mimicking joints as closures; accelerations of the independent ones. */
static void check_mimic(const json *ref, const char *model)
{
    const json *reduced = json_get(ref, "mimic_reduced"), *names = json_get(reduced, "independent");
    mbsr_file_opt opt = mbsr_default_file_opt();
    robot r;
    double qpos[MOST], x[MOST], q[MOST], u[MOST], tau[MOST], expected[MOST], out[MOST];
    if (!names || !json_get(reduced, "udot")) return;
    opt.floating = strcmp(json_get(ref, "base")->text, "floating") == 0;
    open_robot(&r, ref, &opt, 0.0);
    numbers(reduced, "q", qpos), numbers(reduced, "v", x);
    convert(&r, qpos, x, q, u);
    numbers(json_get(ref, "states")->child, "tau", x);
    const json *given = json_get(reduced, "tau");
    if (given && given->count == r.nu) numbers(reduced, "tau", x);
    convert(&r, qpos, x, q, tau);
    assert_ok(mbsr_forward_dynamics(r.model, r.data, 0.0, q, u, tau, out), mbsr_data_error(r.data));
    numbers(reduced, "udot", expected);
    int k = 0, at = 0;
    for (const json *n = names->child; n; n = n->next, ++k) {
        const int joint = mbsr_file_find_joint(r.file, n->text);
        int first;
        assert_true(joint >= 0);
        assert_ok(
            mbsr_body_coordinates(r.model, r.file->joint[joint].body, NULL, NULL, &first, NULL),
            NULL);
        x[k] = out[first + r.file->joint[joint].coordinate];
        at = k + 1;
    }
    print_message("%s: mimicking off by %.2g\n", model,
                  compare(model, "mimicking", at, x, expected, 1e-8));
    close_robot(&r);
}

static void check_keys(const json *ref)
{
    const json *keys = json_get(ref, "keys");
    mbsr_file_opt opt = mbsr_default_file_opt();
    robot r;
    if (!keys) return;
    open_robot(&r, ref, &opt, 0.0);
    for (const json *k = keys->child; k; k = k->next) {
        double qpos[MOST], q[MOST];
        const int key = mbsr_file_find_key(r.file, k->key);
        assert_true(key >= 0);
        assert_int_equal(json_numbers(k, MOST, qpos), r.nq);
        assert_int_equal(mbsr_file_mujoco_state(r.file, 0, qpos, NULL, q, NULL), MBSR_OK);
        for (int l = 0; l < r.nq; ++l) assert_true(q[l] == r.file->key[key].q[l]);
    }
    close_robot(&r);
}

static void check_robots(const char *const *names, int count)
{
    for (int k = 0; k < count; ++k) {
        char *text;
        json *ref = load_reference(names[k], &text);
        if (!ref) {
            print_message("skipped: no references in %s\n", folder);
            skip();
        }
        check_tree(ref, names[k]);
        if (json_get(json_get(ref, "states")->child, "M_singular")->truth)
            check_singular(ref, names[k]);
        if (json_get(ref, "loops")) check_loops(ref, names[k]);
        if (json_get(ref, "mimic_reduced")) check_mimic(ref, names[k]);
        check_keys(ref);
        json_free(ref);
        free(text);
    }
}

static void robots_from_urdf(void **state)
{
    static const char *const names[] = {"double_pendulum_continuous",
                                        "synthetic_tree",
                                        "bolt",
                                        "simple_humanoid",
                                        "baxter",
                                        "romeo"};
    (void)state;
    check_robots(names, 6);
}

static void robots_from_mjcf(void **state)
{
    static const char *const names[] = {"ur5e", "panda", "2f85", "cassie", "synthetic"};
    (void)state;
    check_robots(names, 5);
}

int main(void)
{
    const char *given = getenv("MBSR_ROBOTS");
    snprintf(folder, sizeof folder, "%s",
             given ? given : "the folder MBSR_ROBOTS, which is not set");
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(robots_from_urdf),
        cmocka_unit_test(robots_from_mjcf),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
