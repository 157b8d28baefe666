/* Random trees of bodies of several kinds: see kinds.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "kinds.h"

#include "expect.h"
#include "space.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static double share(test_rng *rng)
{
    return 0.5 * (1.0 + test_uniform(rng));
}

/* ---- joints of a caller's own ---- */

static const mbsr_joint_table *stock_in_space, *stock_in_plane;

static int position_in_space(const mbsr_joint_args *args, double *p)
{
    return stock_in_space->position(args, p);
}

static int position_in_plane(const mbsr_joint_args *args, double *p)
{
    return stock_in_plane->position(args, p);
}

/* The same joint, as a caller's; half of them leave derivatives to differences. */
static void make_own(mbsr_joint_table *table, mbsr_joint *joint, bool plane, bool stripped)
{
    *table = *joint->table;
    *(plane ? &stock_in_plane : &stock_in_space) = joint->table;
    table->position = plane ? position_in_plane : position_in_space;
    if (stripped) table->tangent = NULL, table->rate_tangent = NULL;
    joint->table = table;
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* x of the predecessor, or its length only. */
static int point_of(const mbsr_joint_args *args, double *x, double arm[3])
{
    const test_kinds_joint *joint = args->user;
    if (args->pred_space != MBSR_SPACE_SPATIAL) {
        for (int k = 0; k < args->pred_d; ++k) x[k] = args->p_pred[k];
        return args->pred_d;
    }
    for (int k = 0; k < 3; ++k) {
        arm[k] = 0.0;
        for (int l = 0; l < 3; ++l) arm[k] += args->p_pred[MBSR_POSE_R + 3 * l + k] * joint->b[l];
        x[k] = args->p_pred[MBSR_POSE_X + k] + arm[k];
    }
    return 3;
}

static int position(const mbsr_joint_args *args, double *p)
{
    const test_kinds_joint *joint = args->user;
    double x[12] = {0.0}, arm[3];
    const int length = args->pred_space == MBSR_SPACE_FIXED ? 0 : point_of(args, x, arm);
    for (int k = 0; k < args->d; ++k) {
        p[k] = 0.0;
        for (int l = 0; l < length; ++l) p[k] += joint->C[12 * l + k] * x[l];
        for (int l = 0; l < args->n; ++l)
            p[k] += joint->J0[12 * l + k] * (args->q[l] + 0.3 * sin(args->q[l]));
    }
    return 0;
}

/* H += -C dx/dV for the arm, which in H' is its rate and then counts alone. */
static void add_H(const mbsr_joint_args *args, const double arm[3], bool rate, double *H)
{
    const test_kinds_joint *joint = args->user;
    const int d = args->d;
    for (int j = 0; j < args->pred_d; ++j) {
        double column[12] = {0.0};
        if (args->pred_space != MBSR_SPACE_SPATIAL) {
            column[j] = rate ? 0.0 : 1.0;
        } else if (j < 3) {
            const double axis[3] = {j == 0, j == 1, j == 2};
            cross(axis, arm, column);
        } else {
            column[j - 3] = rate ? 0.0 : 1.0;
        }
        for (int k = 0; k < d; ++k) {
            for (int l = 0; l < 12; ++l) H[d * j + k] -= joint->C[12 * l + k] * column[l];
        }
    }
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    const test_kinds_joint *joint = args->user;
    double x[12] = {0.0}, arm[3] = {0.0};
    (void)K, (void)kI;
    if (args->pred_space != MBSR_SPACE_FIXED) {
        point_of(args, x, arm);
        add_H(args, arm, false, H);
    }
    for (int l = 0; l < args->n; ++l) {
        for (int k = 0; k < args->d; ++k)
            J[args->d * l + k] = -joint->J0[12 * l + k] * (1.0 + 0.3 * cos(args->q[l]));
    }
    return 0;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    const test_kinds_joint *joint = args->user;
    double x[12] = {0.0}, arm[3] = {0.0}, swing[3], second[3] = {0.0};
    if (args->pred_space == MBSR_SPACE_SPATIAL) {
        point_of(args, x, arm);
        cross(args->V_pred, arm, swing);
        cross(args->V_pred, swing, second);
    }
    for (int k = 0; k < args->d; ++k) {
        for (int l = 0; l < 3; ++l) kII[k] -= joint->C[12 * l + k] * second[l];
        for (int l = 0; l < args->n; ++l)
            kII[k] += joint->J0[12 * l + k] * 0.3 * sin(args->q[l]) * args->u[l] * args->u[l];
    }
    return 0;
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    const test_kinds_joint *joint = args->user;
    double x[12] = {0.0}, arm[3] = {0.0}, swing[3];
    (void)Kdot;
    if (args->pred_space == MBSR_SPACE_SPATIAL) {
        point_of(args, x, arm);
        cross(args->V_pred, arm, swing);
        add_H(args, swing, true, Hdot);
    }
    for (int l = 0; l < args->n; ++l) {
        for (int k = 0; k < args->d; ++k)
            Jdot[args->d * l + k] = joint->J0[12 * l + k] * 0.3 * sin(args->q[l]) * args->u[l];
    }
    return 0;
}

static const mbsr_joint_table any_dimension = {.version = MBSR_JOINT_TABLE_VERSION,
                                               .flags = MBSR_JOINT_UNIT_K,
                                               .name = "any dimension",
                                               .position = position,
                                               .jacobians = jacobians,
                                               .bias = bias,
                                               .rates = rates};

/* ---- bodies ---- */

static mbsr_joint joint_in_space(test_rng *rng, const test_kinds_choice *c)
{
    const int one[] = {TEST_REVOLUTE, TEST_REVOLUTE, TEST_PRISMATIC, TEST_SCREW, TEST_WELD};
    const int many[] = {TEST_CYLINDRICAL, TEST_UNIVERSAL, TEST_SPHERICAL, TEST_FREE, TEST_DRIVEN};
    const bool several = share(rng) < c->many;
    const int k = test_integer(rng, 0, 4);
    return test_joint_in_space(rng, several ? many[k] : one[k], 1.0);
}

static mbsr_joint joint_in_plane(test_rng *rng, const test_kinds_choice *c)
{
    const mbsr_planar_frame A = {test_uniform(rng), test_uniform(rng), test_uniform(rng)},
                            B = {test_uniform(rng), test_uniform(rng), test_uniform(rng)};
    if (share(rng) < c->many) return mbsr_joint_planar_free(A, B);
    return share(rng) < 0.6 ? mbsr_joint_planar_revolute(A, B) : mbsr_joint_planar_prismatic(A, B);
}

/* M (d x d) of so many random vectors. */
static void fill_mass(test_rng *rng, int d, int rank, double *M)
{
    double x[12];
    memset(M, 0, (size_t)(d * d) * sizeof *M);
    for (int r = 0; r < rank; ++r) {
        test_fill(rng, d, x);
        for (int k = 0; k < d * d; ++k) M[k] += 0.5 * x[k / d] * x[k % d];
    }
}

static mbsr_inertia inertia_of(test_rng *rng, const test_kinds_choice *c)
{
    const double edges[3] = {0.3, 0.5, 0.7}, kind = share(rng);
    double at[3];
    const mbsr_frame frame = test_frame(rng, 0.4);
    test_fill(rng, 3, at);
    if (kind < c->massless) return mbsr_inertia_zero();
    if (c->plane) {
        if (kind < 1.5 * c->massless) return mbsr_inertia_particle(1.2);
        return mbsr_inertia_planar(1.2, at, 0.3);
    }
    if (kind < 1.5 * c->massless) return mbsr_inertia_point_mass(1.2, at);
    return mbsr_inertia_in_frame(&frame, mbsr_inertia_box(9.0, edges));
}

static void amend(test_kinds_tree *s, test_rng *rng, int body, int d, const mbsr_joint *joint)
{
    double M[36];
    if (joint->n > 1 && joint->nq == joint->n && share(rng) < 0.5) {
        const int coordinate = test_integer(rng, 0, joint->n - 1);
        assert_ok(mbsr_model_lock(s->model, body, coordinate, test_uniform(rng)),
                  mbsr_model_error(s->model));
    } else {
        fill_mass(rng, d, test_integer(rng, 1, d), M);
        assert_ok(mbsr_model_regularise(s->model, body, d, M), mbsr_model_error(s->model));
    }
}

static void add_rigid(test_kinds_tree *s, test_rng *rng, const test_kinds_choice *c, int i)
{
    mbsr_body_def body = mbsr_default_body_def();
    const bool own = share(rng) < c->own, table = share(rng) < 0.7, stripped = share(rng) < 0.5;
    body.parent = s->parent[i] < 0 ? MBSR_GROUND : s->parent[i];
    body.joint = c->plane ? joint_in_plane(rng, c) : joint_in_space(rng, c);
    body.inertia = inertia_of(rng, c);
    const mbsr_joint joint = body.joint;
    if (own && table) make_own(s->table + i, &body.joint, c->plane != 0, stripped);
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    if (own && !table) amend(s, rng, i, c->plane ? 3 : 6, &joint);
    s->own[i] = own;
}

static void add_general(test_kinds_tree *s, test_rng *rng, const test_kinds_choice *c, int i)
{
    static const int sizes[] = {3, 4, 6, 9, 12};
    const int d = sizes[test_integer(rng, 0, 4)], n = test_integer(rng, 1, 3);
    double M[144];
    test_kinds_joint *joint = s->joint + i;
    test_fill(rng, 3, joint->b);
    test_fill(rng, 144, joint->C);
    test_fill(rng, 36, joint->J0);
    fill_mass(rng, d, share(rng) < c->massless ? test_integer(rng, 0, 1) : d + 2, M);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = s->parent[i] < 0 ? MBSR_GROUND : s->parent[i];
    body.joint = mbsr_joint_custom(&any_dimension, d, n, joint);
    body.inertia = mbsr_inertia_matrix(d, M);
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    s->own[i] = 2;
}

static void add_spring(test_kinds_tree *s, test_rng *rng, const test_kinds_choice *c, int i)
{
    const int j = share(rng) < 0.5 ? s->parent[i] : test_integer(rng, -1, i - 1);
    double a[3], b[3];
    test_fill(rng, 3, a);
    test_fill(rng, 3, b);
    if (s->own[i] == 2 || j == i || (j >= 0 && s->own[j] == 2)) return;
    const int other = j < 0 ? MBSR_GROUND : j;
    const mbsr_force_def spring = c->plane ? mbsr_force_axis_spring(i, other, 1, 4.0, 0.4, 0.1)
                                           : mbsr_force_point_spring(i, a, other, b, 4.0, 0.5, 0.4);
    assert_ok(mbsr_model_add_force(s->model, &spring, NULL), mbsr_model_error(s->model));
}

void test_kinds_make(test_kinds_tree *s, test_kinds_choice c)
{
    test_rng rng = test_seed(c.seed);
    memset(s, 0, sizeof *s);
    s->bodies = c.bodies;
    s->t = 0.3;
    assert_true(c.bodies <= TEST_KINDS_BODIES);
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int i = 0; i < c.bodies; ++i) {
        s->parent[i] = share(&rng) < 0.7 ? i - 1 : test_integer(&rng, -1, i - 1);
        const bool on_general = s->parent[i] >= 0 && s->own[s->parent[i]] == 2;
        if (on_general || share(&rng) < c.general)
            add_general(s, &rng, &c, i);
        else
            add_rigid(s, &rng, &c, i);
        const mbsr_force_def law =
            test_joint_law(i, 2.0 + test_uniform(&rng), 1.0 + 0.5 * test_uniform(&rng));
        assert_ok(mbsr_model_add_force(s->model, &law, NULL), mbsr_model_error(s->model));
        if (c.springs && share(&rng) < 0.5) add_spring(s, &rng, &c, i);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.7, -2.0, c.plane ? 0.0 : -3.0);
    assert_ok(mbsr_model_add_force(s->model, &gravity, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    s->q = calloc((size_t)(s->nq + s->nu) + 1, sizeof(double));
    s->u = s->q + s->nq;
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

void test_kinds_free(test_kinds_tree *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    free(s->q);
}
