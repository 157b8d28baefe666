/* Small trees of all kinds of bodies: the models.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "mixed.h"

#include <stdbool.h>
#include <string.h>

const double mixed_spring[3] = {12.0, 1.5, 0.2};

void mixed_cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        c[k] += a[l] * b[m] - a[m] * b[l];
    }
}

static double wave(int k, double t, int derivative)
{
    const double a = 0.3 + 0.2 * k, w = 1.1 + 0.4 * k, phase = 0.5 * k + 0.2;
    if (derivative == 0) return a * sin(w * t + phase);
    return derivative == 1 ? a * w * cos(w * t + phase) : -a * w * w * sin(w * t + phase);
}

static int drive_one(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    s[0] = wave(0, t, 0), sdot[0] = wave(0, t, 1), sddot[0] = wave(0, t, 2);
    return 0;
}

static int drive_two(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)drive_one(user, t, s, sdot, sddot);
    s[1] = wave(2, t, 0), sdot[1] = wave(2, t, 1), sddot[1] = wave(2, t, 2);
    return 0;
}

/* ---- roots ---- */

static const double root_axis[3] = {0.36, -0.48, 0.8};

static int move_in_space(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const mbsr_frame turned = mbsr_frame_rotated(NULL, root_axis, wave(3, t, 0));
    memcpy(p + MBSR_POSE_R, turned.R, sizeof turned.R);
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = wave(k, t, 0);
        V[k] = wave(3, t, 1) * root_axis[k];
        A[k] = wave(3, t, 2) * root_axis[k];
        V[3 + k] = wave(k, t, 1);
        A[3 + k] = wave(k, t, 2);
    }
    return 0;
}

static int move_in_plane(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    for (int k = 0; k < 3; ++k) p[k] = wave(k, t, 0), V[k] = wave(k, t, 1), A[k] = wave(k, t, 2);
    return 0;
}

/* ---- the general joint: with the point x = r + R b of the predecessor, entry by entry
 *
 *   k_j = sinh p_j - h_j . x - g_j q - 0.3 sin(t + j),    K = diag(cosh p_j)
 *
 * a = R b as the body in space that the predecessor is. ---- */

static const double point_b[3] = {0.4, -0.3, 0.0};
static const double h[2][3] = {{0.7, -0.5, 0.4}, {-0.2, 0.9, 0.6}};
static const double g[2] = {1.1, -0.8};

static void predecessor(const mbsr_joint_args *args, double a[3], double r[3], double omega[3])
{
    const double *p = args->p_pred, *V = args->V_pred;
    if (args->pred_space == MBSR_SPACE_SPATIAL) {
        for (int k = 0; k < 3; ++k) {
            r[k] = p[MBSR_POSE_X + k];
            a[k] = p[k] * point_b[0] + p[3 + k] * point_b[1] + p[6 + k] * point_b[2];
            omega[k] = V ? V[k] : 0.0;
        }
        return;
    }
    r[0] = p[0], r[1] = p[1], r[2] = 0.0;
    a[0] = cos(p[2]) * point_b[0] - sin(p[2]) * point_b[1];
    a[1] = sin(p[2]) * point_b[0] + cos(p[2]) * point_b[1];
    a[2] = 0.0;
    omega[0] = omega[1] = 0.0;
    omega[2] = V ? V[2] : 0.0;
}

static int general_position(const mbsr_joint_args *args, double *p)
{
    double a[3], r[3], omega[3];
    predecessor(args, a, r, omega);
    for (int j = 0; j < 2; ++j) {
        double sum = g[j] * args->q[0] + 0.3 * sin(args->t + j);
        for (int k = 0; k < 3; ++k) sum += h[j][k] * (r[k] + a[k]);
        p[j] = asinh(sum);
    }
    return 0;
}

static int general_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                             double *kI)
{
    double a[3], r[3], omega[3];
    predecessor(args, a, r, omega);
    for (int j = 0; j < 2; ++j) {
        double moment[3] = {0.0, 0.0, 0.0};
        mixed_cross(a, h[j], moment);
        K[3 * j] = cosh(args->p[j]);
        J[j] = -g[j];
        kI[j] = -0.3 * cos(args->t + j);
        const bool plane = args->pred_space == MBSR_SPACE_PLANAR;
        for (int k = 0; k < (plane ? 2 : 3); ++k) H[2 * (plane ? k : 3 + k) + j] = -h[j][k];
        if (plane)
            H[4 + j] = -moment[2];
        else
            for (int k = 0; k < 3; ++k) H[2 * k + j] = -moment[k];
    }
    return 0;
}

static int general_bias(const mbsr_joint_args *args, double *kII)
{
    double a[3], r[3], omega[3], v[3] = {0.0}, w[3] = {0.0};
    predecessor(args, a, r, omega);
    mixed_cross(omega, a, v);
    mixed_cross(omega, v, w);
    for (int j = 0; j < 2; ++j) {
        kII[j] = sinh(args->p[j]) * args->V[j] * args->V[j] + 0.3 * sin(args->t + j);
        for (int k = 0; k < 3; ++k) kII[j] -= h[j][k] * w[k];
    }
    return 0;
}

static const mbsr_joint_table general = {.version = MBSR_JOINT_TABLE_VERSION,
                                         .name = "sinh",
                                         .position = general_position,
                                         .jacobians = general_jacobians,
                                         .bias = general_bias};

/* ---- bodies ---- */

void mixed_load(int id, double t, int n, double *value)
{
    for (int k = 0; k < n; ++k) value[k] = (2.0 + id) * cos(0.7 * k + id + 1.3 * t);
}

static int load(void *user, double t, int n, double *value)
{
    mixed_load(((const mixed_body *)user)->id, t, n, value);
    return 0;
}

static void add(mixed *s, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mixed_body *b = s->body + s->bodies;
    mbsr_body_def def = mbsr_default_body_def();
    def.name = name;
    def.parent = parent;
    def.joint = joint;
    def.inertia = inertia;
    b->id = s->bodies++;
    b->parent = parent;
    b->space = joint.space;
    b->d = joint.d;
    b->np = joint.np;
    b->loaded = s->scene != MIXED_ARM;
    assert_ok(mbsr_model_add_body(s->model, &def, NULL), mbsr_model_error(s->model));
}

/* A rigid body with this mass and place of it, and the same in M. */
static mbsr_inertia rigid(mixed *s, double mass, double x, double y, double z)
{
    const double c[3] = {x, y, z}, tensor[6] = {0.7, 0.9, 1.1, 0.1, -0.2, 0.15};
    const double about_c[9] = {0.7, 0.1, -0.2, 0.1, 0.9, 0.15, -0.2, 0.15, 1.1};
    double *M = s->body[s->bodies].M;
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
            const double square = j == k ? x * x + y * y + z * z : 0.0;
            M[6 * j + k] = about_c[3 * j + k] + mass * (square - c[j] * c[k]);
        }
        M[7 * (3 + j)] = mass;
        /* m [c]x above the diagonal, its transpose below */
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        M[6 * (3 + j) + k] = M[6 * k + 3 + j] = mass * c[l];
        M[6 * (3 + k) + j] = M[6 * j + 3 + k] = -mass * c[l];
    }
    return mbsr_inertia_rigid(mass, c, tensor);
}

static mbsr_inertia particle(mixed *s, double mass, int first)
{
    mixed_body *b = s->body + s->bodies;
    const int d = first ? 6 : 2;
    for (int k = first; k < d; ++k) b->M[(d + 1) * k] = mass;
    return mbsr_inertia_particle(mass);
}

static mbsr_inertia planar(mixed *s, double mass, double x, double y, double moment)
{
    double *M = s->body[s->bodies].M;
    M[0] = M[4] = mass;
    M[2] = M[6] = -mass * y;
    M[5] = M[7] = mass * x;
    M[8] = moment + mass * (x * x + y * y);
    return mbsr_inertia_planar(mass, (const double[2]){x, y}, moment);
}

/* A positive definite d x d matrix of no particular kind, added to M. */
static void some_matrix(mixed *s, int body, int d, double *matrix)
{
    test_rng rng = test_seed(77);
    double X[36];
    test_fill(&rng, d * d, X);
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k) {
            matrix[d * j + k] = j == k ? 0.5 : 0.0;
            for (int l = 0; l < d; ++l) matrix[d * j + k] += X[d * l + j] * X[d * l + k];
            s->body[body].M[d * j + k] += matrix[d * j + k];
        }
    }
}

static void add_general(mixed *s, int parent)
{
    double matrix[4] = {0.0};
    some_matrix(s, s->bodies, 2, matrix);
    add(s, "gauge", parent, mbsr_joint_custom(&general, 2, 1, NULL),
        mbsr_inertia_matrix(2, matrix));
}

static mbsr_joint two_axes_and_a_drive(const mbsr_frame *A, const mbsr_frame *B, bool driven)
{
    const mbsr_axis axes[3] = {{MBSR_AXIS_ROTATION, {1.0, 0.5, -0.3}, 0.0, 0},
                               {MBSR_AXIS_TRANSLATION, {0.2, 1.0, 0.7}, 0.0, driven},
                               {MBSR_AXIS_SCREW, {-0.4, 0.3, 1.0}, 0.25, 0}};
    return mbsr_joint_compound(A, B, 3, axes, driven ? drive_one : NULL, NULL);
}

static void add_in_space(mixed *s, bool only_stock)
{
    const double axis[3] = {0.3, 1.0, -0.6}, other[3] = {1.0, 0.1, 0.4}, x[3] = {0.4, -0.2, 0.6};
    const mbsr_frame A = mbsr_frame_rotated(x, axis, 0.8), B = mbsr_frame_rotated(axis, x, -1.3);
    double matrix[36] = {0.0}, added[36] = {0.0};
    add(s, "base", MBSR_GROUND, mbsr_joint_free(&A, &B), rigid(s, 2.0, 0.1, -0.3, 0.2));
    add(s, "arm", 0, two_axes_and_a_drive(&B, &A, !only_stock), rigid(s, 1.2, 0.4, 0.0, 0.1));
    if (!only_stock) some_matrix(s, s->bodies, 6, matrix);
    add(s, "ball", 1, mbsr_joint_spherical(&A, NULL),
        only_stock ? rigid(s, 0.8, 0.0, 0.2, 0.0) : mbsr_inertia_matrix(6, matrix));
    add(s, "slide", MBSR_GROUND, mbsr_joint_cylindrical(NULL, &B, axis), particle(s, 1.5, 3));
    if (!only_stock) assert_ok(mbsr_model_lock(s->model, 3, 1, 0.3), mbsr_model_error(s->model));
    add(s, "dummy", 3, mbsr_joint_weld(&A, &B), mbsr_inertia_zero());
    add(s, "tool", 4, mbsr_joint_universal(&B, NULL, axis, other), rigid(s, 0.6, -0.2, 0.3, 0.5));
    if (only_stock) return;
    some_matrix(s, 5, 6, added);
    assert_ok(mbsr_model_regularise(s->model, 5, 6, added), mbsr_model_error(s->model));
    const mbsr_axis driven[2] = {{MBSR_AXIS_ROTATION, {0.0, 1.0, 0.3}, 0.0, 1},
                                 {MBSR_AXIS_SCREW, {1.0, 0.0, 0.0}, -0.4, 1}};
    add(s, "cart", MBSR_GROUND, mbsr_joint_compound(&A, &B, 2, driven, drive_two, NULL),
        rigid(s, 0.9, 0.2, 0.2, -0.1));
}

static void add_in_plane(mixed *s)
{
    const mbsr_planar_frame A = {0.3, -0.2, 0.4}, B = {-0.5, 0.1, 0.2};
    const double axis[3] = {0.3, 1.0, -0.6};
    const mbsr_frame C = mbsr_frame_rotated(axis, axis, 0.8);
    add(s, "beam", MBSR_GROUND, mbsr_joint_planar(A, B, MBSR_ANGLE, MBSR_X, drive_one, NULL),
        planar(s, 2.0, 0.3, -0.4, 0.5));
    add(s, "pin", 0, mbsr_joint_point(A, MBSR_X, MBSR_Y, drive_one, NULL), particle(s, 1.5, 0));
    add(s, "bead", 1, mbsr_joint_point_free(), particle(s, 0.7, 0));
    add(s, "flap", 1, mbsr_joint_planar_free(A, B), planar(s, 1.1, -0.2, 0.6, 0.3));
    add(s, "rotor", 0, mbsr_joint_revolute(&C, NULL, axis), rigid(s, 1.0, 0.2, -0.1, 0.3));
    add(s, "float", 2, mbsr_joint_free(NULL, &C), rigid(s, 0.5, 0.1, 0.1, -0.2));
}

static mbsr_root root_of(mixed_scene scene)
{
    if (scene == MIXED_ARM) return mbsr_root_fixed();
    if (scene == MIXED_PLANE || scene == MIXED_GENERAL_PLANE)
        return mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, move_in_plane, NULL);
    return mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, move_in_space, NULL);
}

void mixed_make(mixed *s, mixed_scene scene)
{
    mbsr_model_def def = mbsr_default_model_def();
    memset(s, 0, sizeof *s);
    s->scene = scene;
    def.root = root_of(scene);
    s->root_d = def.root.d;
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
    if (scene == MIXED_PLANE || scene == MIXED_GENERAL_PLANE)
        add_in_plane(s);
    else
        add_in_space(s, scene == MIXED_ARM);
    if (scene == MIXED_GENERAL) add_general(s, 5);
    if (scene == MIXED_GENERAL_PLANE) add_general(s, 3);
    mbsr_force_def force = mbsr_force_joint_spring(MIXED_SPRUNG_BODY, MIXED_SPRUNG, mixed_spring[0],
                                                   mixed_spring[1], mixed_spring[2]);
    assert_ok(mbsr_model_add_force(s->model, &force, NULL), mbsr_model_error(s->model));
    for (int id = 0; id < s->bodies; ++id) {
        force = mbsr_force_applied(id, load, s->body + id);
        if (!s->body[id].loaded) continue;
        assert_ok(mbsr_model_add_force(s->model, &force, NULL), mbsr_model_error(s->model));
    }
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    assert_true(s->nq <= MIXED_NQ && s->nu <= MIXED_NU && s->bodies <= MIXED_BODIES);
}

void mixed_free(mixed *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}
