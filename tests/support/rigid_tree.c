/* Random trees of rigid bodies in space under gravity.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "rigid_tree.h"

#include "expect.h"
#include "space.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

static double share(test_rng *rng)
{
    return 0.5 * (1.0 + test_uniform(rng));
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    for (int k = 0; k < 2; ++k) {
        const double w = 1.0 + k;
        s[k] = sin(w * t), sdot[k] = w * cos(w * t), sddot[k] = -w * w * sin(w * t);
    }
    return 0;
}

/* A rotation that is driven, a free one, a translation that is driven, a free one; or all driven.
 * */
static mbsr_joint driven_joint(test_rng *rng, const mbsr_frame *A, const mbsr_frame *B)
{
    mbsr_axis axes[4] = {{.kind = MBSR_AXIS_ROTATION, .driven = 1},
                         {.kind = MBSR_AXIS_ROTATION},
                         {.kind = MBSR_AXIS_TRANSLATION, .driven = 1},
                         {.kind = MBSR_AXIS_TRANSLATION}};
    for (int k = 0; k < 4; ++k) test_fill(rng, 3, axes[k].direction);
    const int count = 1 + (int)(4.0 * share(rng));
    return mbsr_joint_compound(A, B, count, axes, drive, NULL);
}

static mbsr_joint random_joint(test_rng *rng, const test_rigid_choice *c)
{
    mbsr_frame A = test_frame(rng, c->length), B = test_frame(rng, 0.3 * c->length);
    double axis[3], second[3];
    test_fill(rng, 3, axis);
    test_fill(rng, 3, second);
    if (share(rng) < c->many) {
        switch ((int)(7.0 * share(rng))) {
        case 6: return driven_joint(rng, &A, &B);
        case 0: return mbsr_joint_spherical(&A, &B);
        case 1: return mbsr_joint_free(&A, &B);
        case 2: return mbsr_joint_universal(&A, &B, axis, second);
        case 3: return mbsr_joint_cylindrical(&A, &B, axis);
        case 4: return mbsr_joint_in_plane(&A, &B);
        default: return mbsr_joint_translational(&A, &B);
        }
    }
    switch ((int)(6.0 * share(rng))) {
    case 0: return mbsr_joint_prismatic(&A, &B, axis);
    case 1: return mbsr_joint_screw(&A, &B, axis, 0.4 * c->length);
    case 2: return mbsr_joint_weld(&A, &B);
    default: return mbsr_joint_revolute(&A, &B, axis);
    }
}

/* The joint without what its table says of derivatives, and, for bare joints, of rates. */
static void strip(mbsr_joint_table *table, mbsr_joint *joint, bool bare)
{
    *table = *joint->table;
    table->tangent = NULL;
    table->rate_tangent = NULL;
    if (bare) table->rates = NULL;
    joint->table = table;
}

/* Locks some coordinates of a body and adds to its mass matrix. */
static void amend(mbsr_model *model, test_rng *rng, const test_rigid_choice *c, int body,
                  const mbsr_joint *joint)
{
    for (int k = 0; k < joint->n && joint->nq == joint->n; ++k) {
        if (share(rng) < c->held)
            assert_ok(mbsr_model_lock(model, body, k, share(rng)), mbsr_model_error(model));
    }
    if (share(rng) >= c->added) return;
    double B[36], M[36] = {0.0};
    test_fill(rng, 36, B);
    const int rank = 1 + (int)(6.0 * share(rng));
    for (int l = 0; l < rank; ++l) {
        for (int k = 0; k < 36; ++k) M[k] += 0.05 * B[6 * l + k / 6] * B[6 * l + k % 6];
    }
    assert_ok(mbsr_model_regularise(model, body, 6, M), mbsr_model_error(model));
}

/* Small and large ones beside the bodies; the same along a quaternion, and drawn apart from all
 * else, so that a tree differs from that without them in nothing more. */
static void add_armature(mbsr_model *model, const test_rigid_choice *c, int body,
                         const mbsr_joint *joint)
{
    test_rng rng = test_seed(c->seed + 7919 * ((uint64_t)body + 1));
    double values[6];
    if (share(&rng) >= c->armature) return;
    for (int k = 0; k < joint->n; ++k)
        values[k] = c->length * c->length * pow(10.0, -3.0 + 3.0 * share(&rng));
    if (joint->nq > joint->n) values[1] = values[2] = values[0];
    assert_ok(mbsr_model_armature(model, body, joint->n, values), mbsr_model_error(model));
}

static mbsr_inertia random_inertia(test_rng *rng, const test_rigid_choice *c)
{
    double a = 0.1 + share(rng);
    const double b = 0.1 + share(rng), l = c->length;
    double at[3], end[3];
    test_fill(rng, 3, at);
    test_fill(rng, 3, end);
    for (int k = 0; k < 3; ++k) at[k] *= 0.3 * l, end[k] *= 0.3 * l;
    if (share(rng) < c->massless) return mbsr_inertia_zero();
    if (c->light > 0.0 && share(rng) < c->light) a *= pow(10.0, -6.0 - 10.0 * share(rng));
    if (share(rng) < c->points)
        return share(rng) < 0.5 ? mbsr_inertia_point_mass(a, at) : mbsr_inertia_rod(a, at, end);
    const double edges[3] = {0.3 * l, 0.2 * l * a, 0.4 * l * b};
    const mbsr_frame frame = test_frame(rng, 0.3 * l);
    return mbsr_inertia_in_frame(&frame, mbsr_inertia_box(a / (l * l * l), edges));
}

/* f = -0.3 M V - (0.1, .., 0.1): a made-up element that reads all there is of a body. */
static int drag(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < 6; ++k) {
        b->f[k] -= 0.1;
        for (int l = 0; l < 6; ++l) b->f[k] -= 0.3 * b->M[6 * l + k] * b->V[l];
    }
    for (int k = 0; k < b->n; ++k) b->tau[k] -= 0.2 * b->u[k] + 0.1 * b->p[MBSR_POSE_X];
    return 0;
}

static const mbsr_force_table drag_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_EVERY_BODY,
                                            .name = "drag",
                                            .evaluate = drag};

static void add_force(test_rigid_tree *s, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
}

static void add_forces(test_rigid_tree *s, test_rng *rng, const test_rigid_choice *c)
{
    const double one[6] = {1.0, 2.0, 3.0, 40.0, 50.0, 60.0}, two[6] = {0.1, 0.2, 0.3, 4, 5, 6};
    if (c->forces > 1) add_force(s, mbsr_force_custom(&drag_table, 0, NULL, NULL));
    for (int i = 0; i < c->bodies; ++i) {
        double a[3], b[3];
        test_fill(rng, 3, a);
        test_fill(rng, 3, b);
        const int other = (int)(c->bodies * share(rng)) - 1;
        const mbsr_frame A = test_frame(rng, 0.2), B = test_frame(rng, 0.2);
        if (other == i) continue;
        if (i % 3 == 0) add_force(s, mbsr_force_point_spring(i, a, other, b, 10.0, 1.0, 0.5));
        if (i % 3 == 1) add_force(s, mbsr_force_bushing(i, &A, other, &B, one, two));
    }
}

/* A root that turns about a slanting axis while it shakes. */
static int root_motion(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const double axis[3] = {0.48, 0.6, 0.64}, x[3] = {sin(t), 1.0, -t};
    const mbsr_frame frame = mbsr_frame_rotated(x, axis, 0.7 * t * t + 0.3);
    for (int k = 0; k < 9; ++k) p[MBSR_POSE_R + k] = frame.R[k];
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = frame.x[k];
        V[k] = 1.4 * t * axis[k];
        A[k] = 1.4 * axis[k];
    }
    V[3] = cos(t), V[5] = -1.0;
    A[3] = -sin(t);
    return 0;
}

void test_rigid_tree_make(test_rigid_tree *s, test_rigid_choice c)
{
    test_rng rng = test_seed(c.seed);
    mbsr_model_def def = c.def ? *c.def : mbsr_default_model_def();
    if (c.moving)
        def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, root_motion, NULL);
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
    s->table = calloc((size_t)c.bodies, sizeof *s->table);
    for (int k = 0; k < c.bodies; ++k) {
        const int i = c.shuffle ? c.bodies - 1 - k : k; /* place in the tree; id k */
        mbsr_body_def body = mbsr_default_body_def();
        int on = i - 1;
        if (i > 0 && share(&rng) < c.branching) on = (int)(i * share(&rng)) % i;
        body.parent = on < 0 ? MBSR_GROUND : c.shuffle ? c.bodies - 1 - on : on;
        body.joint = random_joint(&rng, &c);
        body.inertia = random_inertia(&rng, &c);
        const mbsr_frame seat = mbsr_frame_at(0.3, -0.2, 0.5);
        if (c.floating && on < 0) body.joint = mbsr_joint_free(&seat, NULL);
        if (c.tables && k % 3 > 0) strip(s->table + k, &body.joint, k % 3 == 2);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
        if (c.held > 0.0 || c.added > 0.0) amend(s->model, &rng, &c, k, &body.joint);
        if (c.armature > 0.0) add_armature(s->model, &c, k, &body.joint);
    }
    add_force(s, mbsr_force_gravity(0.7, -1.3, -9.81));
    if (c.forces) add_forces(s, &rng, &c);
    for (int k = 0; k < c.element_count; ++k) add_force(s, c.elements[k]);
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    const size_t size = (size_t)s->nq + 4 * (size_t)s->nu + 1;
    s->q = malloc(size * sizeof(double));
    s->u = s->q + s->nq;
    s->tau = s->u + s->nu;
    s->udot = s->tau + s->nu;
    s->expected = s->udot + s->nu;
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
    test_fill(&rng, s->nu, s->tau);
    s->t = 0.4;
}

void test_rigid_tree_free(test_rigid_tree *s)
{
    free(s->q);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    free(s->table);
}
