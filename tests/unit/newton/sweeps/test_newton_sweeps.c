/* The Newton system of the momentum form by the sweeps in vector code, against differences of the
 * residual that know nothing of them, for every kind of processor that this machine can run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A random delta gives, by differences of sixth order along it, r = (dF/dy + c dF/dy') delta, and
 * the solver must find delta again. */
#include "expect.h"
#include "kernels.h"
#include "newton/sweeps/sweeps.h"
#include "rigid_tree.h"
#include "space.h"
#include "algebra/space3.h"
#include "assembly/data.h"
#include "recursion/group.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A state of the momentum form, a direction and what it does to F. */
typedef struct newton_system {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu, size;
    double t, c;
    double *y, *yp, *delta, *r, *found, *work;
    void *block; /* of the solver */
    mbsri_newton_sweeps *newton;
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
    assert_ok(mbsr_stage_positions(model, data, t, q), mbsr_data_error(data));
    assert_ok(mbsr_stage_velocities(model, data, u), mbsr_data_error(data));
    assert_ok(mbsr_momenta(model, data, s->y + nq), mbsr_data_error(data));
    memcpy(s->y + nq + nu, u, (size_t)nu * sizeof(double));
    const size_t bytes = mbsri_newton_sweeps_size(model, false);
    const size_t up = (bytes + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    s->block = aligned_alloc(MBSR_DATA_ALIGNMENT, up);
    memset(s->block, 0xff, up); /* NaN */
    s->newton = mbsri_newton_sweeps_place(model, true, s->block, NULL);
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

static void differentiate(newton_system *s, double h)
{
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

/* Factors, solves and compares; returns the error, or -1 if not served. The
 * differences truncate too much with the longest step in stiff trees and lose too many digits with
 * the shortest in others. */
static double check_one(newton_system *s)
{
    double least = INFINITY;
    for (int k = 11; k <= 13; ++k) {
        differentiate(s, ldexp(1.0, -k));
        const int status =
            mbsri_newton_sweeps_factor(s->newton, s->data, s->t, s->y, s->y + s->nq + s->nu, s->c);
        if (status == MBSRI_NOT_SERVED) return -1.0;
        assert_ok(status, mbsr_data_error(s->data));
        memcpy(s->found, s->r, (size_t)s->size * sizeof(double));
        mbsri_newton_sweeps_solve(s->newton, s->found, NULL, s->found, NULL);
        least = fmin(least, error_of(s));
    }
    return least;
}

/* The same with all kernels, the largest error. */
static double check(newton_system *s, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const mbsri_sweep_kernels *list[2];
    double most = 0.0;
    test_fill(&rng, s->size, s->delta);
    test_fill(&rng, s->size, s->yp);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        const double one = check_one(s);
        if (one < 0.0) return one;
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
    assert_less(most_of(40, (test_rigid_choice){.seed = 1500, .floating = 1, .length = 1.0}), 1e-7);
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

/* A wrench in body axes that also drags: slopes of everything on a body's own motion. */
static int push(void *user, double t, int n, double *value)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) value[k] = 3.0 - k;
    return 0;
}

static int drag(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < 6; ++k) b->f[k] -= (1.0 + 0.3 * k) * b->V[k] + 0.2 * b->V[(k + 1) % 6];
    return 0;
}

static const mbsr_force_table drag_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_EVERY_BODY | MBSR_FORCE_NO_MASS |
                                                     MBSR_FORCE_NO_JOINT,
                                            .name = "drag",
                                            .evaluate = drag};

enum { MOST_ELEMENTS = 64 };

/* Springs and bushings between each body and its predecessor or the ground, wrenches, drag. The
 * tree is the one of `choice` without them. */
static int make_elements(test_rigid_choice choice, mbsr_force_def elements[MOST_ELEMENTS])
{
    const double one[6] = {1.0, 2.0, 3.0, 40.0, 50.0, 60.0}, two[6] = {0.1, 0.2, 0.3, 4, 5, 6};
    test_rng rng = test_seed(choice.seed);
    test_rigid_tree tree;
    int count = 0;
    test_rigid_tree_make(&tree, choice);
    for (int i = 0; i < choice.bodies; ++i) {
        const int on = i % 2 ? mbsr_body_parent(tree.model, i) : MBSR_GROUND;
        const mbsr_frame A = test_frame(&rng, 0.2), B = test_frame(&rng, 0.2);
        switch (i % 5) {
        case 0:
        case 3: elements[count++] = mbsr_force_point_spring(i, A.x, on, B.x, 30.0, 2.0, 0.1); break;
        case 1: elements[count++] = mbsr_force_bushing(i, &A, on, &B, one, two); break;
        case 2:
            elements[count++] = mbsr_force_bushing(on, &A, i, &B, two, one);
            elements[count++] = mbsr_force_wrench(i, A.x, 1, push, NULL);
            break;
        default: break;
        }
    }
    elements[count++] = mbsr_force_custom(&drag_table, 0, NULL, NULL);
    test_rigid_tree_free(&tree);
    return count;
}

static void elements_on_neighbours(void **state)
{
    (void)state;
    double most = 0.0;
    for (int k = 0; k < 60; ++k) {
        mbsr_force_def elements[MOST_ELEMENTS];
        test_rigid_choice choice = {.seed = 700 + (uint64_t)k,
                                    .bodies = 1 + k % 13,
                                    .armature = 0.3 * (k % 4),
                                    .many = 0.5 * (k % 3),
                                    .branching = 0.25 * (k % 4),
                                    .moving = k % 5 == 4,
                                    .shuffle = k % 3 == 2,
                                    .length = 1.0};
        choice.element_count = make_elements(choice, elements);
        choice.elements = elements;
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        newton_system s;
        open_system(&s, tree.model, tree.data, tree.t, tree.q, tree.u, rates[k % 4]);
        const double error = check(&s, (uint64_t)k);
        assert_true(error >= 0.0);
        most = fmax(most, error);
        close_system(&s);
        test_rigid_tree_free(&tree);
    }
    print_message("relative error of delta at most %.2g\n", most);
    assert_less(most, 1e-7);
}

/* Joint forces and forces on all bodies that do not depend on anything, `loading` times given
 * numbers. */
static double loading;

static double load_number(int body, int k)
{
    return 1.0 + 0.3 * body - 0.7 * k + 0.1 * body * k;
}

static int given_load(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < 6 && b->f; ++k) b->f[k] += loading * load_number(b->id, k);
    for (int k = 0; k < b->n; ++k) b->tau[k] += loading * load_number(b->id, 6 + k);
    return 0;
}

static int no_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    (void)args, (void)out;
    return 0;
}

static const mbsr_force_table load_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_EVERY_BODY | MBSR_FORCE_NO_MASS,
                                            .name = "given load",
                                            .evaluate = given_load,
                                            .derivatives = no_derivatives};

/* On joints alone. */
static const mbsr_force_table joint_load_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                                  .flags =
                                                      MBSR_FORCE_EVERY_BODY | MBSR_FORCE_JOINT_ONLY,
                                                  .name = "given joint load",
                                                  .evaluate = given_load,
                                                  .derivatives = no_derivatives};

/* Poses and velocities of all bodies at y + h delta. */
static void place_all(newton_system *s, double h, double (*pose)[MBSR_POSE_SIZE], double (*V)[6])
{
    for (int k = 0; k < s->size; ++k) s->work[k] = s->y[k] + h * s->found[k];
    assert_ok(mbsr_stage_positions(s->model, s->data, s->t, s->work), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->work + s->nq + s->nu),
              mbsr_data_error(s->data));
    for (int i = 1; i <= s->model->bodies; ++i) {
        const mbsri_body *b = s->model->body + i;
        memcpy(pose[i], s->data->p + b->p, sizeof pose[i]);
        memcpy(V[i], s->data->V + b->v, sizeof V[i]);
    }
}

/* The motions that the solver reports against differences of poses and velocities along delta. */
static void check_motion(newton_system *s, const double *motion)
{
    enum { BODIES = 20 };
    const double h = 1e-6 / test_largest(s->size, s->found);
    double pose[2][BODIES][MBSR_POSE_SIZE], V[2][BODIES][6];
    place_all(s, h, pose[0], V[0]);
    place_all(s, -h, pose[1], V[1]);
    double size = 1.0;
    for (int i = 1; i <= s->model->bodies; ++i)
        size = fmax(size, test_largest(12, motion + 12 * i));
    for (int i = 1; i <= s->model->bodies; ++i) {
        const double *R = s->data->p + s->model->body[i].p; /* a little off, of no account */
        double slope[MBSR_POSE_SIZE], W[9], found[12];
        for (int k = 0; k < MBSR_POSE_SIZE; ++k)
            slope[k] = (pose[0][i][k] - pose[1][i][k]) / (2.0 * h);
        mbsri_multiply_transposed3(slope, R, W); /* dR R^T = [dtheta]x */
        found[0] = 0.5 * (W[5] - W[7]);
        found[1] = 0.5 * (W[6] - W[2]);
        found[2] = 0.5 * (W[1] - W[3]);
        for (int k = 0; k < 3; ++k) found[3 + k] = slope[MBSR_POSE_X + k];
        for (int k = 0; k < 6; ++k) found[6 + k] = (V[0][i][k] - V[1][i][k]) / (2.0 * h);
        assert_less(distance(12, found, motion + 12 * i), 1e-5 * size);
    }
}

/* delta of a load is that of the change of F that it makes; and what the solver says of the bodies'
 * motions. */
static void check_load(newton_system *s, bool bodies)
{
    const mbsr_model *m = s->model;
    double *load = calloc(m->size.v + (size_t)m->nu, sizeof *load),
           *motion = calloc(12 * ((size_t)m->bodies + 1), sizeof *motion);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int l = 0; l < 6; ++l) load[b->v + (size_t)l] = load_number(b->id, l);
        for (int l = 0; l < b->n; ++l)
            load[m->size.v + (size_t)(b->iu + l)] = load_number(b->id, 6 + l);
    }
    loading = 0.0;
    assert_ok(
        mbsri_newton_sweeps_factor(s->newton, s->data, s->t, s->y, s->y + s->nq + s->nu, s->c),
        mbsr_data_error(s->data));
    mbsri_newton_sweeps_solve(s->newton, NULL, load, s->found, motion);
    if (bodies) check_motion(s, motion);
    memset(s->r, 0, (size_t)s->size * sizeof *s->r);
    loading = 1.0;
    sample(s, 0.0, -1.0, s->r);
    loading = 0.0;
    sample(s, 0.0, 1.0, s->r);
    mbsri_newton_sweeps_solve(s->newton, s->r, NULL, s->delta, NULL);
    assert_less(error_of(s), 1e-8);
    free(load);
    free(motion);
}

static void loads_and_motions(void **state)
{
    (void)state;
    for (int k = 0; k < 40; ++k) {
        const bool bodies = k % 2 == 0;
        const mbsr_force_def given =
            mbsr_force_custom(bodies ? &load_table : &joint_load_table, 0, NULL, NULL);
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, (test_rigid_choice){.seed = 900 + (uint64_t)k,
                                                        .bodies = 1 + k % 13,
                                                        .many = 0.3 * (k % 3),
                                                        .branching = 0.25 * (k % 4),
                                                        .moving = k % 5 == 4,
                                                        .length = 1.0,
                                                        .elements = &given,
                                                        .element_count = 1});
        newton_system s;
        open_system(&s, tree.model, tree.data, tree.t, tree.q, tree.u, rates[k % 4]);
        check_load(&s, bodies);
        close_system(&s);
        test_rigid_tree_free(&tree);
    }
}

/* A spring-damper on every joint. */
static int spring_damper(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < b->n; ++k)
        b->tau[k] -= (2.0 + k) * b->u[k] + 5.0 * sin(b->q[k + b->nq - b->n]);
    return 0;
}

static const mbsr_force_table spring_damper_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                                     .flags = MBSR_FORCE_JOINT_ONLY |
                                                              MBSR_FORCE_EVERY_BODY,
                                                     .name = "spring-damper",
                                                     .evaluate = spring_damper};

/* u where the algebraic equations hold, by Newton's method with q and p held; false: no
 * convergence, or not served. */
static bool settle(newton_system *s)
{
    double *u = s->y + s->nq + s->nu, *F = s->r;
    for (int k = 0; k < 60; ++k) {
        memset(F, 0, (size_t)s->size * sizeof *F);
        sample(s, 0.0, 1.0, F);
        memset(F, 0, (size_t)(s->nq + s->nu) * sizeof *F);
        if (test_largest(s->size, F) < 1e-13) return true;
        if (mbsri_newton_sweeps_factor(s->newton, s->data, s->t, s->y, u, 1e8)) return false;
        mbsri_newton_sweeps_solve(s->newton, F, NULL, F, NULL);
        for (int l = 0; l < s->nu; ++l) u[l] -= F[s->nq + s->nu + l];
    }
    return false;
}

static bool has_load(const mbsr_model *model)
{
    const mbsri_force *force = model->forces.data;
    for (size_t k = 0; k < model->forces.count; ++k) {
        if (force[k].def.table == &load_table) return true;
    }
    return false;
}

/* Settles and checks; returns the error, or -1 where the state or the sweeps do not serve. */
static double check_settled(mbsr_model *model, mbsr_data *data, double t, const double *q,
                            const double *u, double c, int *deficient)
{
    newton_system s;
    double error = -1.0;
    open_system(&s, model, data, t, q, u, c);
    if (settle(&s)) {
        error = check(&s, 1);
        assert_true(error >= 0.0);
        *deficient += s.newton->last.below_massless;
        if (has_load(model)) check_load(&s, true);
    }
    close_system(&s);
    return error;
}

/* Half of the bodies have no mass; on every other tree elements act on bodies, too. */
static void massless_bodies(void **state)
{
    (void)state;
    const mbsr_force_def law = mbsr_force_custom(&spring_damper_table, 0, NULL, NULL);
    int served = 0, deficient = 0;
    double most = 0.0;
    for (int k = 0; k < 200; ++k) {
        mbsr_force_def elements[MOST_ELEMENTS + 1];
        test_rigid_choice choice = {.seed = 2000 + (uint64_t)k,
                                    .bodies = 1 + k % 13,
                                    .armature = k % 6 == 5 ? 0.4 : 0.0,
                                    .massless = k % 3 ? 0.5 : 0.8,
                                    .many = k % 8 == 3 ? 0.2 : 0.0,
                                    .branching = 0.25 * (k % 4),
                                    .moving = k % 5 == 4,
                                    .shuffle = k % 3 == 2,
                                    .length = 1.0};
        if (k / 4 % 2) choice.element_count = make_elements(choice, elements);
        elements[choice.element_count++] = law;
        choice.elements = elements;
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        const double error =
            check_settled(tree.model, tree.data, tree.t, tree.q, tree.u, rates[k % 4], &deficient);
        served += error >= 0.0;
        most = fmax(most, error);
        test_rigid_tree_free(&tree);
    }
    print_message("%d trees, %d with joints whose block is zero; relative error at most %.2g\n",
                  served, deficient, most);
    assert_true(served >= 160 && deficient >= 100);
    assert_less(most, 1e-7);
}

static void add_body(mbsr_model *model, test_rng *rng, int kind, int on, const mbsr_frame *A,
                     const double axis[3], double mass)
{
    const double edges[3] = {0.3, 0.2, 0.5};
    const mbsr_frame at = test_frame(rng, 0.5);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = on;
    body.joint = kind == 0   ? mbsr_joint_revolute(A, NULL, axis)
                 : kind == 1 ? mbsr_joint_prismatic(A, NULL, axis)
                             : mbsr_joint_screw(A, NULL, axis, 0.4);
    body.inertia = mbsr_inertia_in_frame(&at, mbsr_inertia_box(mass * 30.0, edges));
    assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
}

/* A bushing or a spring between a body and its predecessor or the ground. */
static void add_neighbour(mbsr_model *model, test_rng *rng, int body, int on, int which)
{
    const double one[6] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, two[6] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    const mbsr_frame A = test_frame(rng, 0.2), B = test_frame(rng, 0.2);
    const mbsr_force_def def = which % 2
                                   ? mbsr_force_bushing(on, &A, body, &B, one, two)
                                   : mbsr_force_point_spring(body, A.x, on, B.x, 3.0, 1.0, 0.1);
    assert_ok(mbsr_model_add_force(model, &def, NULL), mbsr_model_error(model));
}

/* Cells of massless bodies and one with mass: one or two that turn or slide about the same axis as
 * it, or (`skew`) three with other axes through the same point. The joint block of the first is
 * zero, with all that follows in its subtree. */
static mbsr_model *make_cells(int k, bool skew, int *bodies)
{
    enum { CELLS = 4 };
    mbsr_model *model;
    test_rng rng = test_seed(4000 + (uint64_t)k);
    int last[CELLS + 1] = {MBSR_GROUND};
    *bodies = 0;
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int c = 0; c < CELLS; ++c) {
        const int kind = (k + c) % (skew ? 2 : 3), massless = skew ? 3 : 1 + (k / 3 + c) % 2;
        const mbsr_frame A = test_frame(&rng, 1.0);
        int on = last[k % 4 < 2 ? c : c / 2];
        double axis[3];
        test_fill(&rng, 3, axis);
        for (int l = 0; l <= massless; ++l) {
            if (skew) test_fill(&rng, 3, axis);
            add_body(model, &rng, kind, on, l ? NULL : &A, axis, l < massless ? 0.0 : 1.0);
            if (k % 2) add_neighbour(model, &rng, *bodies, (k + l) % 3 ? on : MBSR_GROUND, k + l);
            on = (*bodies)++;
        }
        last[c + 1] = on;
    }
    const mbsr_force_def law = mbsr_force_custom(&spring_damper_table, 0, NULL, NULL),
                         gravity = mbsr_force_gravity(1.0, 2.0, -9.0),
                         given = mbsr_force_custom(&load_table, 0, NULL, NULL);
    assert_ok(mbsr_model_add_force(model, &law, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_add_force(model, &gravity, NULL), mbsr_model_error(model));
    if (k % 2) assert_ok(mbsr_model_add_force(model, &given, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    return model;
}

/* Whether joints of a group lack rank such that they are eliminated together. */
static bool has_coupled(const mbsr_model *model, mbsr_data *data, const double *q, const double *u)
{
    assert_ok(mbsr_stage_positions(model, data, 0.0, q), mbsr_data_error(data));
    assert_ok(mbsr_stage_velocities(model, data, u), mbsr_data_error(data));
    assert_ok(mbsr_stage_forces(model, data, NULL), mbsr_data_error(data));
    assert_ok(mbsr_stage_backward(model, data), mbsr_data_error(data));
    for (int i = 1; i <= model->bodies; ++i) {
        const mbsri_group g = mbsri_group_in_model(model, i);
        if (g.members > 1 && mbsri_coupled(model, data, &g)) return true;
    }
    return false;
}

static void massless_bodies_in_series(void **state)
{
    (void)state;
    int served = 0, deficient = 0, coupled = 0;
    double most = 0.0;
    for (int k = 0; k < 120; ++k) {
        mbsr_data *data;
        int bodies;
        double q[16], u[16];
        mbsr_model *model = make_cells(k, k >= 60, &bodies);
        test_rng rng = test_seed((uint64_t)k);
        assert_ok(mbsr_data_create(model, &data, NULL), NULL);
        test_fill(&rng, bodies, q);
        test_fill(&rng, bodies, u);
        const double error = check_settled(model, data, 0.0, q, u, rates[k % 4], &deficient);
        served += error >= 0.0;
        most = fmax(most, error);
        coupled += error < 0.0 && has_coupled(model, data, q, u);
        mbsr_data_destroy(data);
        mbsr_model_destroy(model);
    }
    print_message("%d trees, %d with joints whose block is zero; relative error at most %.2g; %d "
                  "others with joints to be eliminated together\n",
                  served, deficient, most, coupled);
    assert_true(served >= 50 && served + coupled >= 110 && deficient == served);
    assert_less(most, 1e-7);
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
    assert_int_equal(mbsri_newton_sweeps_factor(s.newton, lean, s.t, s.y, s.y + s.nq + s.nu, s.c),
                     0);
    mbsri_newton_sweeps_solve(s.newton, s.r, NULL, s.work, NULL);
    assert_memory_equal(s.work, s.found, (size_t)s.size * sizeof(double));
    for (int k = 0; k < 2; ++k) {
        mbsri_data_poison(tree.data);
        if (k == 0)
            assert_int_equal(
                mbsri_newton_sweeps_factor(s.newton, tree.data, s.t, s.y, s.y + s.nq + s.nu, s.c),
                0);
        else
            assert_ok(
                mbsr_dae_residual(tree.model, tree.data, MBSR_DAE_MOMENTUM, s.t, s.y, s.yp, s.work),
                mbsr_data_error(tree.data));
        assert_ok(mbsr_body_rank(tree.model, tree.data, 8, info + k), mbsr_data_error(tree.data));
        assert_ok(mbsr_body_pose(tree.model, tree.data, 8, pose[k]), mbsr_data_error(tree.data));
    }
    assert_memory_equal(pose[0], pose[1], sizeof pose[0]);
    assert_int_equal(info[0].rank, info[1].rank);
    mbsri_newton_sweeps_solve(s.newton, NULL, NULL, s.work, NULL);
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
    mbsri_sweeps *const whole = model->tree.newton;
    model->tree.newton = model->tree.plain; /* here there is nobody to leave blocks to */
    open_system(&s, model, data, 0.0, q, u, c);
    const int status = mbsri_newton_sweeps_factor(s.newton, data, 0.0, q, u, c);
    if (status == MBSR_SINGULAR_BLOCK) assert_int_equal(mbsr_data_error(data)->body, 1);
    close_system(&s);
    model->tree.newton = whole;
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
    assert_int_equal(status_of(&slider, 0.0, 1.0), MBSR_OK);
    assert_int_equal(status_of(&three, 0.0, 1.125), MBSRI_NOT_SERVED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_of_all_joints),
        cmocka_unit_test(elements_on_joints),
        cmocka_unit_test(elements_on_neighbours),
        cmocka_unit_test(loads_and_motions),
        cmocka_unit_test(massless_bodies),
        cmocka_unit_test(massless_bodies_in_series),
        cmocka_unit_test(point_masses_on_rods),
        cmocka_unit_test(data_stays_consistent),
        cmocka_unit_test(singular_rows_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
