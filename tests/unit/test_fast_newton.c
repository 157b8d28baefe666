/* The Newton system of the momentum form by the sweeps in vector code, against differences of the
 * residual that know nothing of them, for every kind of processor that this machine can run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A random delta gives, by differences of sixth order along it, r = (dF/dy + c dF/dy') delta, and
 * the solver must find delta again. */
#include "expect.h"
#include "fast/newton.h"
#include "rigid_tree.h"
#include "space.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int kernels(const mbsri_fast_kernels *list[2])
{
    int count = 0;
    list[count++] = &mbsri_fast_base;
#if defined(MBSR_WITH_V3)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        list[count++] = &mbsri_fast_v3;
#endif
    return count;
}

/* A state of the momentum form, a direction and what it does to F. */
typedef struct newton_system {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, size;
    double t, c;
    double *y, *yp, *delta, *r, *found, *work;
    void *block; /* of the solver */
    mbsri_fast_newton *newton;
} newton_system;

static void close_system(newton_system *s)
{
    free(s->y);
    free(s->block);
}

static void open_system(newton_system *s, mbsr_model *model, mbsr_data *data, double t,
                        const double *q, const double *u, double c)
{
    const int nq = mbsr_model_nq(model), nu = mbsr_model_nu(model), size = nq + 2 * nu;
    *s = (newton_system){
        .model = model, .data = data, .nq = nq, .nu = nu, .size = size, .t = t, .c = c};
    s->y = calloc(9 * (size_t)size + 1, sizeof(double));
    s->yp = s->y + size;
    s->delta = s->yp + size;
    s->r = s->delta + size;
    s->found = s->r + size;
    s->work = s->found + size;
    memcpy(s->y, q, (size_t)nq * sizeof(double));
    assert_ok(mbsr_positions(model, data, t, q), mbsr_data_error(data));
    assert_ok(mbsr_velocities(model, data, u), mbsr_data_error(data));
    assert_ok(mbsr_momenta(model, data, s->y + nq), mbsr_data_error(data));
    memcpy(s->y + nq + nu, u, (size_t)nu * sizeof(double));
    const size_t bytes = mbsri_fast_newton_size(model);
    const size_t up = (bytes + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    s->block = aligned_alloc(MBSR_DATA_ALIGNMENT, up);
    memset(s->block, 0xff, up); /* NaN */
    s->newton = mbsri_fast_newton_place(model, s->block);
}

/* out += weight F(y + h delta, y' + c h delta) */
static void sample(newton_system *s, double h, double weight, double *out)
{
    double *y = s->work, *yp = y + s->size, *F = yp + s->size;
    for (int k = 0; k < s->size; ++k) {
        y[k] = s->y[k] + h * s->delta[k];
        yp[k] = s->yp[k] + s->c * h * s->delta[k];
    }
    assert_ok(mbsr_dae_residual(s->model, s->data, MBSR_DAE_MOMENTUM, s->t, y, yp, F),
              mbsr_data_error(s->data));
    for (int k = 0; k < s->size; ++k) out[k] += weight * F[k];
}

static void differentiate(newton_system *s)
{
    const double h = 0x1p-11;
    const double place[] = {1.0, 2.0, 3.0}, weight[] = {45.0, -9.0, 1.0};
    memset(s->r, 0, (size_t)s->size * sizeof(double));
    for (int k = 0; k < 3; ++k) {
        sample(s, place[k] * h, weight[k] / (60.0 * h), s->r);
        sample(s, -place[k] * h, -weight[k] / (60.0 * h), s->r);
    }
}

static double distance(int n, const double *a, const double *b)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) {
        const double one = fabs(a[k] - b[k]);
        if (!(one <= most)) most = one;
    }
    return most;
}

/* The largest error of the solution, relative to the largest of delta q, p and u each. */
static double error_of(const newton_system *s)
{
    const int start[] = {0, s->nq, s->nq + s->nu, s->size};
    double most = 0.0;
    for (int k = 0; k < 3; ++k) {
        const int n = start[k + 1] - start[k];
        const double one = distance(n, s->delta + start[k], s->found + start[k]) /
                           (1e-300 + test_largest(n, s->delta + start[k]));
        if (n > 0 && !(one <= most)) most = one;
    }
    return most;
}

/* Factors, solves and compares, with all kernels; returns the largest error, or -1 if not served.
 * */
static double check(newton_system *s, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const mbsri_fast_kernels *list[2];
    test_fill(&rng, s->size, s->delta);
    test_fill(&rng, s->size, s->yp);
    differentiate(s);
    double most = 0.0;
    for (int k = 0; k < kernels(list); ++k) {
        s->model->fast->kernels = list[k];
        const int status =
            mbsri_fast_newton_factor(s->newton, s->data, s->t, s->y, s->y + s->nq + s->nu, s->c);
        if (status == MBSRI_NOT_SERVED) return -1.0;
        assert_ok(status, mbsr_data_error(s->data));
        memcpy(s->found, s->r, (size_t)s->size * sizeof(double));
        mbsri_fast_newton_solve(s->newton, s->found, NULL, s->found, NULL);
        const double one = error_of(s);
        if (!(one <= most)) most = one;
    }
    return most;
}

static const double rates[] = {1.0, 30.0, 1e3, -50.0};

/* The largest error on `count` random trees like the one given; all must be served. */
static double most_of(int count, test_rigid_choice like)
{
    double most = 0.0;
    for (int k = 0; k < count; ++k) {
        test_rigid_choice choice = like;
        choice.seed += (uint64_t)k;
        choice.bodies = 1 + k % 13;
        choice.many = like.many * (k % 2);
        choice.branching = 0.25 * (k % 4);
        choice.moving = k % 5 == 4;
        choice.shuffle = k % 3 == 2;
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        newton_system s;
        open_system(&s, tree.model, tree.data, tree.t, tree.q, tree.u, rates[k % 4]);
        const double error = check(&s, (uint64_t)k);
        assert_true(error >= 0.0);
        if (!(error <= most)) most = error;
        close_system(&s);
        test_rigid_tree_free(&tree);
    }
    print_message("relative error of delta at most %.2g\n", most);
    return most;
}

static void trees_of_all_joints(void **state)
{
    (void)state;
    assert_less(most_of(60, (test_rigid_choice){.seed = 100, .many = 0.5, .length = 1.0}), 1e-7);
    assert_less(most_of(60, (test_rigid_choice){.seed = 300, .many = 1.0, .length = 1.0}), 1e-7);
}

/* Every joint force depends on all coordinates and rates of its joint, and on the length of a
 * quaternion. */
static int coupled_law(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < b->n; ++k) {
        for (int l = 0; l < b->nq; ++l) b->tau[k] += (3.0 * k - l) * sin(b->q[l] + k);
        for (int l = 0; l < b->n; ++l) b->tau[k] -= (1.0 + k + 2.0 * l) * b->u[l];
    }
    return 0;
}

static const mbsr_force_table coupled_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                               .flags =
                                                   MBSR_FORCE_JOINT_ONLY | MBSR_FORCE_EVERY_BODY,
                                               .name = "coupled law",
                                               .evaluate = coupled_law};

static void elements_on_joints(void **state)
{
    (void)state;
    const mbsr_force_def law = mbsr_force_custom(&coupled_table, 0, NULL, NULL);
    assert_less(
        most_of(60,
                (test_rigid_choice){
                    .seed = 500, .many = 0.7, .length = 1.0, .elements = &law, .element_count = 1}),
        1e-7);
}

/* Point masses on massless rods: every body's own mass matrix is singular, no joint's block is. */
static void point_masses_on_rods(void **state)
{
    (void)state;
    mbsr_model *model;
    mbsr_data *data;
    double q[8], u[8];
    test_rng rng = test_seed(3);
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int k = 0; k < 8; ++k) {
        const double axis[3] = {0.1 * k, 1.0, 0.0}, end[3] = {1.0, 0.0, 0.2 * k};
        const mbsr_frame A = mbsr_frame_at(1.0, 0.0, 0.0);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_revolute(&A, NULL, axis);
        body.inertia = mbsr_inertia_point_mass(1.0, end);
        assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    assert_ok(mbsr_model_add_force(model, &gravity, NULL), mbsr_model_error(model));
    for (int k = 0; k < 8; ++k) {
        const mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 100.0, 1.0, 0.1);
        assert_ok(mbsr_model_add_force(model, &spring, NULL), mbsr_model_error(model));
    }
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create(model, &data, NULL), NULL);
    test_fill(&rng, 8, q);
    test_fill(&rng, 8, u);
    newton_system s;
    open_system(&s, model, data, 0.0, q, u, 40.0);
    assert_less(fabs(check(&s, 1)), 1e-9);
    close_system(&s);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
}

/* Lean data does, gives the same numbers, and can be asked for results afterwards like data of
 * which the residual has been asked. */
static void data_stays_consistent(void **state)
{
    (void)state;
    test_rigid_tree tree;
    test_rigid_tree_make(&tree,
                         (test_rigid_choice){.seed = 7, .bodies = 9, .many = 0.5, .length = 1.0});
    newton_system s;
    mbsr_data *lean;
    mbsr_rank_info info[2];
    double pose[2][MBSR_POSE_SIZE];
    open_system(&s, tree.model, tree.data, tree.t, tree.q, tree.u, 30.0);
    assert_true(check(&s, 1) >= 0.0);
    assert_ok(mbsr_data_create_lean(tree.model, &lean, NULL), NULL);
    assert_int_equal(mbsri_fast_newton_factor(s.newton, lean, s.t, s.y, s.y + s.nq + s.nu, s.c), 0);
    mbsri_fast_newton_solve(s.newton, s.r, NULL, s.work, NULL);
    assert_memory_equal(s.work, s.found, (size_t)s.size * sizeof(double));
    for (int k = 0; k < 2; ++k) {
        mbsri_data_poison(tree.data);
        if (k == 0)
            assert_int_equal(
                mbsri_fast_newton_factor(s.newton, tree.data, s.t, s.y, s.y + s.nq + s.nu, s.c), 0);
        else
            assert_ok(
                mbsr_dae_residual(tree.model, tree.data, MBSR_DAE_MOMENTUM, s.t, s.y, s.yp, s.work),
                mbsr_data_error(tree.data));
        assert_ok(mbsr_body_rank(tree.model, tree.data, 8, info + k), mbsr_data_error(tree.data));
        assert_ok(mbsr_body_pose(tree.model, tree.data, 8, pose[k]), mbsr_data_error(tree.data));
    }
    assert_memory_equal(pose[0], pose[1], sizeof pose[0]);
    assert_int_equal(info[0].rank, info[1].rank);
    mbsri_fast_newton_solve(s.newton, NULL, NULL, s.work, NULL);
    for (int k = 0; k < s.size; ++k) assert_true(s.work[k] == 0.0);
    mbsr_data_destroy(lean);
    close_system(&s);
    test_rigid_tree_free(&tree);
}

/* tau = q: with c = 1 and a unit mass, c (c m) - 1 = 0. */
static int repel(const mbsr_force_args *args)
{
    for (int k = 0; k < args->body->n; ++k) args->body->tau[k] += args->body->q[k];
    return 0;
}

static int repel_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    for (int k = 0; k < args->body->n; ++k)
        out->matrix[(out->column[0] + 12 + k) * out->rows + out->row[0] + 6 + k] += 1.0;
    return 0;
}

static const mbsr_force_table repel_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                             .flags = MBSR_FORCE_JOINT_ONLY,
                                             .name = "repulsion",
                                             .evaluate = repel,
                                             .derivatives = repel_derivatives};

/* A slider or three of mass 0 or 1 with that law. */
static int status_of(const mbsr_joint *joint, double mass, double c)
{
    mbsr_model *model;
    mbsr_data *data;
    const int on = 1;
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_weld(NULL, NULL);
    assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
    body.parent = 0;
    body.joint = *joint;
    body.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
    const mbsr_force_def law = mbsr_force_custom(&repel_table, 1, &on, NULL);
    assert_ok(mbsr_model_add_force(model, &law, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create(model, &data, NULL), NULL);
    const double q[3] = {0.25, 0.5, -0.5}, u[3] = {1.0, 0.5, 2.0};
    newton_system s;
    open_system(&s, model, data, 0.0, q, u, c);
    const int status = mbsri_fast_newton_factor(s.newton, data, 0.0, q, u, c);
    if (status == MBSR_SINGULAR_BLOCK) assert_int_equal(mbsr_data_error(data)->body, 1);
    close_system(&s);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
    return status;
}

static void singular_rows_are_reported(void **state)
{
    (void)state;
    const double axis[3] = {1.0, 0.0, 0.0};
    const mbsr_joint slider = mbsr_joint_prismatic(NULL, NULL, axis),
                     three = mbsr_joint_translational(NULL, NULL);
    assert_int_equal(status_of(&slider, 1.0, 1.0), MBSR_SINGULAR_BLOCK);
    assert_int_equal(status_of(&three, 1.0, 1.0), MBSR_SINGULAR_BLOCK);
    assert_int_equal(status_of(&slider, 1.0, 1.125), MBSR_OK);
    assert_int_equal(status_of(&three, 1.0, 1.125), MBSR_OK);
    assert_int_equal(status_of(&slider, 0.0, 1.125), MBSRI_NOT_SERVED);
    assert_int_equal(status_of(&three, 0.0, 1.125), MBSRI_NOT_SERVED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_of_all_joints),        cmocka_unit_test(elements_on_joints),
        cmocka_unit_test(point_masses_on_rods),       cmocka_unit_test(data_stays_consistent),
        cmocka_unit_test(singular_rows_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
