/* Trees of rigid bodies read from files.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "tree_file.h"

#include "expect.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct test_tree_load {
    int n;
    double value[6];
} test_tree_load;

static FILE *open_file(const char *name, const char *ending)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.%s", TEST_TREE_FOLDER, name, ending);
    FILE *stream = fopen(path, "r");
    if (!stream) fail_msg("cannot open %s", path);
    return stream;
}

static void read_numbers(FILE *stream, int n, double *x)
{
    for (int k = 0; k < n; ++k) assert_int_equal(fscanf(stream, "%lf", x + k), 1);
}

/* false at the end of the file */
static int read_line(FILE *stream, test_tree_line *line)
{
    if (fscanf(stream, "%d %c", &line->parent, &line->type) != 2) return 0;
    read_numbers(stream, 3, line->axis);
    read_numbers(stream, 3, line->place);
    read_numbers(stream, 4, line->turn);
    read_numbers(stream, 1, &line->mass);
    read_numbers(stream, 3, line->com);
    read_numbers(stream, 6, line->inertia);
    return 1;
}

/* "name n", then n numbers */
static double *read_section(FILE *stream, const char *name, int n)
{
    char found[16] = "";
    int count = 0;
    assert_int_equal(fscanf(stream, "%15s %d", found, &count), 2);
    assert_string_equal(found, name);
    assert_int_equal(count, n);
    double *x = calloc((size_t)n + 1, sizeof(double));
    read_numbers(stream, n, x);
    return x;
}

void test_tree_file_read(test_tree_file *file, const char *name)
{
    *file = (test_tree_file){0};
    FILE *stream = open_file(name, "txt");
    test_tree_line line;
    while (read_line(stream, &line)) {
        assert_in_range(line.parent + 1, 0, file->bodies);
        assert_true(line.type == 'R' || line.type == 'F');
        assert_true(line.type != 'F' || (file->bodies == 0 && line.parent == -1));
        file->line = realloc(file->line, sizeof line * (size_t)(file->bodies + 1));
        file->line[file->bodies++] = line;
        file->nq += line.type == 'F' ? 7 : 1;
        file->nv += line.type == 'F' ? 6 : 1;
    }
    assert_true(feof(stream));
    assert_true(file->bodies > 0);
    fclose(stream);
    stream = open_file(name, "ref");
    file->q = read_section(stream, "q", file->nq);
    file->v = read_section(stream, "v", file->nv);
    file->tau = read_section(stream, "tau", file->nv);
    file->qdd = read_section(stream, "qdd", file->nv);
    fclose(stream);
}

void test_tree_file_free(test_tree_file *file)
{
    free(file->line);
    free(file->q);
    free(file->v);
    free(file->tau);
    free(file->qdd);
}

test_tree_telling test_tree_told(void)
{
    return (test_tree_telling){.world = mbsr_frame_identity(), .length = 1.0, .mass = 1.0};
}

/* Line k of the file as a body; place: line -> id. */
static void add_body(mbsr_model *m, const test_tree_file *file, const test_tree_telling *telling,
                     const int *place, int k)
{
    const test_tree_line *line = file->line + k;
    const double length = telling->length;
    mbsr_frame A = mbsr_frame_quaternion(line->place, line->turn);
    for (int c = 0; c < 3; ++c) A.x[c] *= length;
    if (line->parent < 0) A = mbsr_frame_product(&telling->world, &A);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = line->parent < 0 ? MBSR_GROUND : place[line->parent];
    body.joint = line->type == 'R' ? mbsr_joint_revolute(&A, NULL, line->axis)
                                   : mbsr_joint_free(&telling->world, NULL);
    double com[3], inertia[6];
    for (int c = 0; c < 3; ++c) com[c] = length * line->com[c];
    for (int c = 0; c < 6; ++c) inertia[c] = telling->mass * length * length * line->inertia[c];
    body.inertia = mbsr_inertia_rigid(telling->mass * line->mass, com, inertia);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
}

/* x = a in the model's order: rates, or forces, of rotation times `turn`, of translation times
 * `shift`. */
static void convert(const test_tree_line *line, double turn, double shift, const double *a,
                    double *x)
{
    if (line->type == 'R') {
        x[0] = turn * a[0];
        return;
    }
    for (int k = 0; k < 3; ++k) {
        x[k] = turn * a[3 + k];
        x[3 + k] = shift * a[k];
    }
}

static int constant_load(void *user, double t, int n, double *value)
{
    const test_tree_load *load = user;
    (void)t;
    for (int k = 0; k < n; ++k) value[k] = load->value[k];
    return MBSR_OK;
}

/* The state of the body of a line, from the places q_at and v_at of the file on. */
static void convert_state(test_told_tree *tree, const test_tree_file *file,
                          const test_tree_telling *telling, int k, int id, int q_at, int v_at)
{
    const test_tree_line *line = file->line + k;
    const double L = telling->length, force = telling->mass * L;
    int q, u;
    assert_ok(mbsr_body_coordinates(tree->model, id, &q, NULL, &u, NULL), NULL);
    tree->q[q] = file->q[q_at];
    for (int c = 0; c < 3 && line->type == 'F'; ++c) tree->q[q + 4 + c] = L * file->q[q_at + c];
    for (int c = 0; c < 4 && line->type == 'F'; ++c) tree->q[q + c] = file->q[q_at + 3 + c];
    convert(line, 1.0, L, file->v + v_at, tree->u + u);
    convert(line, force * L, force, file->tau + v_at, tree->tau + u);
    convert(line, 1.0, L, file->qdd + v_at, tree->udot + u);
}

void test_told_tree_make(test_told_tree *tree, const test_tree_file *file,
                         const test_tree_telling *telling)
{
    const int N = file->bodies;
    int *place = calloc((size_t)N, sizeof(int));
    for (int id = 0; id < N; ++id) place[telling->line ? telling->line[id] : id] = id;
    *tree = (test_told_tree){.nq = file->nq, .nu = file->nv};
    assert_ok(mbsr_model_create(NULL, &tree->model, NULL), NULL);
    for (int id = 0; id < N; ++id)
        add_body(tree->model, file, telling, place, telling->line ? telling->line[id] : id);
    double g[3];
    for (int k = 0; k < 3; ++k) g[k] = -9.81 * telling->length * telling->world.R[6 + k];
    const mbsr_force_def gravity = mbsr_force_gravity(g[0], g[1], g[2]);
    assert_ok(mbsr_model_add_force(tree->model, &gravity, NULL), mbsr_model_error(tree->model));
    tree->load = calloc((size_t)N, sizeof(test_tree_load));
    for (int k = 0; k < N && telling->loads; ++k) {
        const mbsr_force_def load =
            mbsr_force_joint_applied(place[k], constant_load, tree->load + k);
        assert_ok(mbsr_model_add_force(tree->model, &load, NULL), mbsr_model_error(tree->model));
    }
    assert_ok(mbsr_model_finish(tree->model), mbsr_model_error(tree->model));
    assert_ok(mbsr_data_create(tree->model, &tree->data, NULL), NULL);
    assert_int_equal(mbsr_model_nq(tree->model), file->nq);
    assert_int_equal(mbsr_model_nu(tree->model), file->nv);
    tree->q = calloc((size_t)file->nq + 3 * (size_t)file->nv, sizeof(double));
    tree->u = tree->q + file->nq;
    tree->tau = tree->u + file->nv;
    tree->udot = tree->tau + file->nv;
    for (int k = 0, q = 0, v = 0; k < N; ++k) {
        convert_state(tree, file, telling, k, place[k], q, v);
        int u, n;
        assert_ok(mbsr_body_coordinates(tree->model, place[k], NULL, NULL, &u, &n), NULL);
        for (int c = 0; c < n; ++c) tree->load[k].value[c] = tree->tau[u + c];
        q += file->line[k].type == 'F' ? 7 : 1;
        v += file->line[k].type == 'F' ? 6 : 1;
    }
    free(place);
}

void test_told_tree_free(test_told_tree *tree)
{
    mbsr_data_destroy(tree->data);
    mbsr_model_destroy(tree->model);
    free(tree->load);
    free(tree->q);
}
