/* Random trees of bodies in space that are made of mass points.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "space.h"

#include "expect.h"

#include <stdlib.h>
#include <string.h>

void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t jobu_length, size_t jobvt_length);

/* ---- the law of a joint ---- */

static int law_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    const double *q = b->q, *param = args->force->param;
    const int turned = b->nq > b->n ? 3 : 0;
    for (int k = 0; k < b->n; ++k) b->tau[k] -= param[1] * b->u[k];
    for (int k = turned; k < b->n; ++k) b->tau[k] -= param[0] * sin(q[k + (b->nq - b->n)]);
    if (!turned) return MBSR_OK;
    const double size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    for (int k = 0; k < 3; ++k) b->tau[k] -= param[0] * 2.0 * q[0] * q[1 + k] / size;
    return MBSR_OK;
}

/* stiffness (1 - cos q), stiffness (1 - cos theta) */
static int law_energy(const mbsr_force_args *args, double *energy)
{
    const mbsr_force_body *b = args->body;
    const double *q = b->q, stiffness = args->force->param[0];
    const int turned = b->nq > b->n ? 3 : 0;
    for (int k = turned; k < b->n; ++k) *energy += stiffness * (1.0 - cos(q[k + (b->nq - b->n)]));
    if (!turned) return MBSR_OK;
    const double part = q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    *energy += stiffness * 2.0 * part / (part + q[0] * q[0]);
    return MBSR_OK;
}

static int law_dissipation(const mbsr_force_args *args, double *power)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < b->n; ++k) *power += args->force->param[1] * b->u[k] * b->u[k];
    return MBSR_OK;
}

static const mbsr_force_table law_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "test joint law",
    .evaluate = law_evaluate,
    .energy = law_energy,
    .dissipation = law_dissipation,
    .scales = {.length = 1.0}, /* in any unit */
};

mbsr_force_def test_joint_law(int body, double stiffness, double damping)
{
    mbsr_force_def def = mbsr_force_custom(&law_table, 1, NULL, NULL);
    def.body[0] = body;
    def.param[0] = stiffness;
    def.param[1] = damping;
    return def;
}

/* ---- joints ---- */

int test_motion(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = 0.3 * sin(2.0 * t + 0.4);
    *sdot = 0.6 * cos(2.0 * t + 0.4);
    *sddot = -1.2 * sin(2.0 * t + 0.4);
    return MBSR_OK;
}

/* A direction, which lies at 30 degrees at least from `other`. */
static void random_axis(test_rng *rng, const double *other, double *axis)
{
    for (;;) {
        test_fill(rng, 3, axis);
        const double size = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        double along = 0.0;
        for (int k = 0; k < 3; ++k) axis[k] /= size;
        for (int k = 0; k < 3 && other; ++k) along += axis[k] * other[k];
        if (size > 0.1 && fabs(along) < 0.86) return;
    }
}

/* Two rotations, a translation and a screw, or the first of them; driven: a rotation or the
 * screw is, as test_motion knows no units of length. */
static mbsr_joint random_compound(test_rng *rng, const mbsr_frame *A, const mbsr_frame *B,
                                  int driven, double unit)
{
    const int count = test_integer(rng, 2, 4);
    mbsr_axis axes[4] = {{.kind = MBSR_AXIS_ROTATION}};
    for (int k = 0; k < count; ++k) {
        static const mbsr_axis_kind kind[] = {MBSR_AXIS_ROTATION, MBSR_AXIS_ROTATION,
                                              MBSR_AXIS_TRANSLATION, MBSR_AXIS_SCREW};
        axes[k].kind = kind[k];
        axes[k].pitch = kind[k] == MBSR_AXIS_SCREW ? 0.2 * unit : 0.0;
        random_axis(rng, k > 0 ? axes[k - 1].direction : NULL, axes[k].direction);
    }
    const int place = test_integer(rng, 0, count - 1);
    if (driven) axes[place == 2 ? 1 : place].driven = 1;
    return mbsr_joint_compound(A, B, count, axes, driven ? test_motion : NULL, NULL);
}

mbsr_joint test_joint_in_space(test_rng *rng, int kind, double unit)
{
    const mbsr_frame A = test_frame(rng, 0.5 * unit), B = test_frame(rng, 0.3 * unit);
    double a[3], b[3];
    random_axis(rng, NULL, a);
    random_axis(rng, a, b);
    switch (kind) {
    case TEST_WELD: return mbsr_joint_weld(&A, &B);
    case TEST_REVOLUTE: return mbsr_joint_revolute(&A, &B, a);
    case TEST_PRISMATIC: return mbsr_joint_prismatic(&A, &B, a);
    case TEST_SCREW: return mbsr_joint_screw(&A, &B, a, 0.1 * unit);
    case TEST_CYLINDRICAL: return mbsr_joint_cylindrical(&A, &B, a);
    case TEST_UNIVERSAL: return mbsr_joint_universal(&A, &B, a, b);
    case TEST_IN_PLANE: return mbsr_joint_in_plane(&A, &B);
    case TEST_TRANSLATIONAL: return mbsr_joint_translational(&A, &B);
    case TEST_SPHERICAL: return mbsr_joint_spherical(&A, &B);
    case TEST_FREE: return mbsr_joint_free(&A, &B);
    default: return random_compound(rng, &A, &B, kind == TEST_DRIVEN, unit);
    }
}

/* ---- trees ---- */

/* Turns about the z axis and shifts along (1, 2, -1) as test_motion says. */
static int root_motion(void *user, double t, double *p, double *V, double *A)
{
    static const double axis[3] = {0.0, 0.0, 1.0}, along[3] = {1.0, 2.0, -1.0};
    const double unit = *(const double *)user;
    double s, sd, sdd;
    test_motion(NULL, t, &s, &sd, &sdd);
    const mbsr_frame frame = mbsr_frame_rotated(NULL, axis, s);
    memcpy(p + MBSR_POSE_R, frame.R, sizeof frame.R);
    V[2] = sd;
    A[2] = sdd;
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = unit * along[k] * s;
        V[3 + k] = unit * along[k] * sd;
        A[3 + k] = unit * along[k] * sdd;
    }
    return MBSR_OK;
}

/* The points of a body, and their inertia as the library sums it. */
static mbsr_inertia random_points(test_rng *rng, const test_space_opt *opt, test_points *points)
{
    const int deficient = test_uniform(rng) < 2.0 * opt->deficient - 1.0;
    const int low = test_integer(rng, 0, 2);
    mbsr_inertia inertia = mbsr_inertia_zero();
    points->count = deficient ? low : TEST_MAX_POINTS;
    for (int k = 0; k < TEST_MAX_POINTS; ++k) {
        points->mass[k] = opt->mass * (1.0 + 0.5 * test_uniform(rng));
        test_fill(rng, 3, points->at[k]);
        for (int c = 0; c < 3; ++c) points->at[k][c] *= 0.4 * opt->length;
        if (k >= points->count) continue;
        inertia =
            mbsr_inertia_sum(inertia, mbsr_inertia_point_mass(points->mass[k], points->at[k]));
    }
    return inertia;
}

/* Angular velocity of a body when one rate of its joint is `rate` and all others are zero. */
static void spin(const test_space_tree *tree, int id, int k, double rate, double *omega)
{
    double *u = calloc((size_t)tree->nu, sizeof(double)), V[6];
    u[k] = rate;
    assert_ok(mbsr_stage_velocities(tree->model, tree->data, u), mbsr_data_error(tree->data));
    assert_ok(mbsr_body_twist(tree->model, tree->data, id, V), mbsr_data_error(tree->data));
    memcpy(omega, V, 3 * sizeof(double));
    free(u);
}

/* Random numbers, of which those that are lengths are put into the units of the tree. */
static void random_state(test_space_tree *tree, test_rng *rng)
{
    test_fill(rng, tree->nq, tree->q);
    test_fill(rng, tree->nu, tree->u);
    if (tree->unit == 1.0) return;
    double *q = calloc((size_t)tree->nq, sizeof(double));
    memcpy(q, tree->q, sizeof(double) * (size_t)tree->nq);
    assert_ok(mbsr_stage_positions(tree->model, tree->data, 0.0, q), mbsr_data_error(tree->data));
    for (int id = 0; id < tree->N; ++id) {
        int at, nq, u, n;
        assert_ok(mbsr_body_coordinates(tree->model, id, &at, &nq, &u, &n), NULL);
        for (int k = 0; k < n; ++k) {
            double turned[3], still[3];
            spin(tree, id, u + k, 1.0, turned);
            spin(tree, id, u + k, 0.0, still);
            if (fabs(turned[0] - still[0]) + fabs(turned[1] - still[1]) +
                    fabs(turned[2] - still[2]) >
                1e-9)
                continue;
            tree->q[at + (nq - n) + k] *= tree->unit;
            tree->u[u + k] *= tree->unit;
        }
    }
    free(q);
}

void test_space_make(test_space_tree *tree, test_space_opt opt)
{
    test_rng rng = test_seed(opt.seed);
    const int N = opt.bodies;
    if (opt.length == 0.0) opt.length = 1.0;
    if (opt.mass == 0.0) opt.mass = 1.0;
    *tree = (test_space_tree){.N = N, .unit = opt.length};
    tree->parent = calloc((size_t)N, sizeof(int));
    tree->points = calloc((size_t)N, sizeof(test_points));
    mbsr_model_def def = mbsr_default_model_def();
    if (opt.driven) {
        def.root =
            mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, root_motion, &tree->unit);
    }
    assert_ok(mbsr_model_create(&def, &tree->model, NULL), NULL);
    for (int id = 0; id < N; ++id) {
        tree->parent[id] = test_integer(&rng, -1, id - 1);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = tree->parent[id];
        body.joint = test_joint_in_space(
            &rng, test_integer(&rng, 0, opt.driven ? TEST_DRIVEN : TEST_FREE), opt.length);
        body.inertia = random_points(&rng, &opt, tree->points + id);
        tree->rows += 3 * tree->points[id].count;
        assert_ok(mbsr_model_add_body(tree->model, &body, NULL), mbsr_model_error(tree->model));
        const mbsr_force_def law =
            test_joint_law(id, 1.0 + 0.5 * test_uniform(&rng), 1.0 + 0.5 * test_uniform(&rng));
        if (opt.laws)
            assert_ok(mbsr_model_add_force(tree->model, &law, NULL), mbsr_model_error(tree->model));
    }
    for (int k = 0; k < 3; ++k) tree->g[k] = opt.gravity * (k == 0 ? 0.36 : k == 1 ? 0.48 : -0.8);
    const mbsr_force_def gravity = mbsr_force_gravity(tree->g[0], tree->g[1], tree->g[2]);
    assert_ok(mbsr_model_add_force(tree->model, &gravity, NULL), mbsr_model_error(tree->model));
    assert_ok(mbsr_model_finish(tree->model), mbsr_model_error(tree->model));
    assert_ok(mbsr_data_create(tree->model, &tree->data, NULL), NULL);
    tree->nq = mbsr_model_nq(tree->model);
    tree->nu = mbsr_model_nu(tree->model);
    tree->q = calloc((size_t)(tree->nq + tree->nu) + 1, sizeof(double));
    tree->u = tree->q + tree->nq;
    random_state(tree, &rng);
}

void test_space_free(test_space_tree *tree)
{
    mbsr_data_destroy(tree->data);
    mbsr_model_destroy(tree->model);
    free(tree->parent);
    free(tree->points);
    free(tree->q);
}

/* ---- mass points ---- */

static void cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Positions (rate == 0) or velocities of the points. */
static void at_points(const test_space_tree *tree, int rate, double *x)
{
    int row = 0;
    for (int id = 0; id < tree->N; ++id) {
        double p[MBSR_POSE_SIZE], V[6], arm[3], turn[3];
        assert_ok(mbsr_body_pose(tree->model, tree->data, id, p), mbsr_data_error(tree->data));
        if (rate)
            assert_ok(mbsr_body_twist(tree->model, tree->data, id, V), mbsr_data_error(tree->data));
        for (int c = 0; c < tree->points[id].count; ++c, row += 3) {
            const double *at = tree->points[id].at[c], weight = sqrt(tree->points[id].mass[c]);
            for (int k = 0; k < 3; ++k) arm[k] = p[k] * at[0] + p[3 + k] * at[1] + p[6 + k] * at[2];
            if (rate) cross(V, arm, turn);
            for (int k = 0; k < 3; ++k)
                x[row + k] = weight * (rate ? V[3 + k] + turn[k] : p[MBSR_POSE_X + k] + arm[k]);
        }
    }
    assert_int_equal(row, tree->rows);
}

void test_space_positions(const test_space_tree *tree, double *x)
{
    at_points(tree, 0, x);
}

void test_space_velocities(const test_space_tree *tree, double *v)
{
    at_points(tree, 1, v);
}

void test_space_jacobian(const test_space_tree *tree, double *P)
{
    double *u = calloc((size_t)(tree->nu + tree->rows) + 1, sizeof(double)), *rest = u + tree->nu;
    assert_ok(mbsr_stage_velocities(tree->model, tree->data, u), mbsr_data_error(tree->data));
    test_space_velocities(tree, rest);
    for (int c = 0; c < tree->nu; ++c) {
        u[c] = 1.0;
        assert_ok(mbsr_stage_velocities(tree->model, tree->data, u), mbsr_data_error(tree->data));
        test_space_velocities(tree, P + (size_t)c * (size_t)tree->rows);
        u[c] = 0.0;
        for (int r = 0; r < tree->rows; ++r) P[c * tree->rows + r] -= rest[r];
    }
    free(u);
}

int test_column_rank(int rows, const double *A, int count, const int *use, double *kept,
                     double *dropped)
{
    const int least = rows < count ? rows : count, lwork = 10 * (rows + count) + 10, one = 1;
    if (least == 0) return 0;
    double *copy = calloc((size_t)(rows * count), sizeof(double)),
           *length = calloc((size_t)count, sizeof(double)),
           *s = calloc((size_t)least, sizeof(double)),
           *work = calloc((size_t)lwork, sizeof(double)), none = 0.0;
    for (int c = 0; c < count; ++c) {
        for (int r = 0; r < rows; ++r) length[c] = hypot(length[c], A[use[c] * rows + r]);
    }
    const double tiny = 1e-11 * test_largest(count, length);
    for (int c = 0; c < count; ++c) {
        for (int r = 0; r < rows && length[c] > tiny; ++r)
            copy[c * rows + r] = A[use[c] * rows + r] / length[c];
    }
    int info = 0, rank = 0;
    dgesvd_("N", "N", &rows, &count, copy, &rows, s, &none, &one, &none, &one, work, &lwork, &info,
            1, 1);
    assert_int_equal(info, 0);
    for (int k = 0; k < least; ++k) {
        if (s[k] > 1e-7) {
            ++rank;
            *kept = fmin(*kept, s[k]);
        } else {
            *dropped = fmax(*dropped, s[k]);
        }
    }
    free(copy);
    free(length);
    free(s);
    free(work);
    return rank;
}
