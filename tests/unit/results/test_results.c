/* What can be asked of an evaluated state: accelerations, reactions, Jacobians, momentum of the
 * tree, bias forces, normal form of q; against differences along motions and Newton's and Euler's
 * equations of every single body.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "mixed.h"

#include "assembly/data.h"
#include "model/query.h"
#include "recursion/kinematics.h"

#include <string.h>

enum { ROUNDS = 3 };

typedef struct state {
    double t, q[MIXED_NQ], u[MIXED_NU], udot[MIXED_NU], tau[MIXED_NU];
} state;

static void random_state(const mixed *s, test_rng *rng, state *x)
{
    x->t = test_uniform(rng);
    test_fill(rng, s->nq, x->q);
    test_fill(rng, s->nu, x->u);
    test_fill(rng, s->nu, x->udot);
    test_fill(rng, s->nu, x->tau);
}

/* From memory that holds nothing: poses and velocities of the state. */
static void move(mixed *s, double t, const double *q, const double *u)
{
    mbsri_data_poison(s->data);
    assert_ok(mbsr_stage_positions(s->model, s->data, t, q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, u), mbsr_data_error(s->data));
}

/* And accelerations of udot under the joint forces tau. */
static void accelerate(mixed *s, const state *x)
{
    move(s, x->t, x->q, x->u);
    assert_ok(mbsr_stage_forces(s->model, s->data, x->tau), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_accelerations(s->model, s->data, x->udot), mbsr_data_error(s->data));
}

/* Every scene in `scenes` at a few states. */
static void for_scenes(int scenes, void (*check)(mixed *s, state *x))
{
    for (int scene = 0; scene < scenes; ++scene) {
        test_rng rng = test_seed(40 + (uint64_t)scene);
        mixed s;
        mixed_make(&s, (mixed_scene)scene);
        for (int round = 0; round < ROUNDS; ++round) {
            state x;
            random_state(&s, &rng, &x);
            check(&s, &x);
        }
        mixed_free(&s);
    }
}

static int size_of(const mixed *s, int id)
{
    return id == MBSR_GROUND ? s->root_d : s->body[id].d;
}

static void twist_of(mixed *s, int id, double *V)
{
    assert_ok(mbsr_body_twist(s->model, s->data, id, V), mbsr_data_error(s->data));
}

/* ---- motions --------------------------------------------------------------------------------- */

/* q' = G(q) u at (t, q). */
static void rates(mixed *s, double t, const double *q, const double *u, double *qdot)
{
    move(s, t, q, u);
    assert_ok(mbsr_coordinate_rates(s->model, s->data, qdot), mbsr_data_error(s->data));
}

/* The state a time h later, with udot constant: one Runge-Kutta step for q. */
static void advance(mixed *s, const state *x, double h, state *y)
{
    static const double place[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double slope[MIXED_NQ] = {0.0}, q[MIXED_NQ], u[MIXED_NU];
    *y = *x;
    y->t = x->t + h;
    for (int stage = 0; stage < 4; ++stage) {
        for (int k = 0; k < s->nq; ++k) q[k] = x->q[k] + place[stage] * h * slope[k];
        for (int k = 0; k < s->nu; ++k) u[k] = x->u[k] + place[stage] * h * x->udot[k];
        rates(s, x->t + place[stage] * h, q, u, slope);
        for (int k = 0; k < s->nq; ++k) y->q[k] += weight[stage] * h / 6.0 * slope[k];
    }
    for (int k = 0; k < s->nu; ++k) y->u[k] += h * x->udot[k];
}

/* d/dt of the n numbers that `value` writes, along the motion; error of fourth order in the step.
 */
static void along_the_motion(mixed *s, const state *x, int n,
                             void (*value)(mixed *s, const void *which, double *out),
                             const void *which, double *slope)
{
    const double step = 1e-3, weight[4] = {1.0, -8.0, 8.0, -1.0};
    for (int k = 0; k < n; ++k) slope[k] = 0.0;
    for (int l = 0; l < 4; ++l) {
        double out[6];
        state y;
        advance(s, x, step * (l < 2 ? l - 2 : l - 1), &y);
        move(s, y.t, y.q, y.u);
        value(s, which, out);
        for (int k = 0; k < n; ++k) slope[k] += weight[l] * out[k] / (12.0 * step);
    }
}

/* ---- Jacobians ------------------------------------------------------------------------------- */

/* Twist of a small displacement from pose a to pose b: rotations by the antisymmetric part of
 * R_b R_a^T, whose error is of third order. */
static void displacement(mbsr_space space, int d, const double *a, const double *b, double *twist)
{
    if (space != MBSR_SPACE_SPATIAL) {
        for (int k = 0; k < d; ++k) twist[k] = b[k] - a[k];
        return;
    }
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        double lower = 0.0, upper = 0.0;
        for (int c = 0; c < 3; ++c) {
            lower += b[3 * c + m] * a[3 * c + l];
            upper += b[3 * c + l] * a[3 * c + m];
        }
        twist[k] = 0.5 * (lower - upper);
        twist[3 + k] = b[MBSR_POSE_X + k] - a[MBSR_POSE_X + k];
    }
}

static void check_jacobian(mixed *s, state *x)
{
    static const double none[MIXED_NU] = {0.0};
    double J[MIXED_BODIES + 1][6 * MIXED_NU], V[6], V0[6];
    for (int id = MBSR_GROUND; id < s->bodies; ++id) { /* poses are enough */
        mbsri_data_poison(s->data);
        assert_ok(mbsr_stage_positions(s->model, s->data, x->t, x->q), mbsr_data_error(s->data));
        assert_ok(mbsr_body_jacobian(s->model, s->data, id, J[id + 1]), mbsr_data_error(s->data));
    }
    for (int id = MBSR_GROUND; id < s->bodies; ++id) {
        const int d = size_of(s, id);
        move(s, x->t, x->q, none);
        twist_of(s, id, V0);
        move(s, x->t, x->q, x->u);
        twist_of(s, id, V);
        for (int k = 0; k < d; ++k) {
            double sum = V0[k];
            for (int c = 0; c < s->nu; ++c) sum += J[id + 1][d * c + k] * x->u[c];
            assert_close(sum, V[k], 1e-13);
        }
    }
    /* column c: where u_c alone moves the body at this moment */
    for (int c = 0; c < s->nu; ++c) {
        const double step = 1e-5;
        double qdot[MIXED_NQ], unit[MIXED_NU] = {0.0}, pose[2][MBSR_POSE_SIZE], moved[6];
        unit[c] = 1.0;
        rates(s, x->t, x->q, unit, qdot);
        for (int id = 0; id < s->bodies; ++id) {
            const mixed_body *b = s->body + id;
            for (int side = 0; side < 2; ++side) {
                double q[MIXED_NQ];
                for (int k = 0; k < s->nq; ++k) q[k] = x->q[k] + (side - 0.5) * step * qdot[k];
                assert_ok(mbsr_stage_positions(s->model, s->data, x->t, q),
                          mbsr_data_error(s->data));
                assert_ok(mbsr_body_pose(s->model, s->data, id, pose[side]), NULL);
            }
            displacement(b->space, b->d, pose[0], pose[1], moved);
            for (int k = 0; k < b->d; ++k)
                assert_close(J[id + 1][b->d * c + k], moved[k] / step, 1e-9);
        }
    }
}

static void a_jacobian_maps_joint_rates_to_the_twist_and_to_displacements(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_jacobian);
}

/* ---- accelerations --------------------------------------------------------------------------- */

static void twist_along(mixed *s, const void *which, double *V)
{
    twist_of(s, *(const int *)which, V);
}

static void check_acceleration(mixed *s, state *x)
{
    for (int id = MBSR_GROUND; id < s->bodies; ++id) {
        double A[6], slope[6];
        const int d = size_of(s, id);
        along_the_motion(s, x, d, twist_along, &id, slope);
        accelerate(s, x);
        assert_ok(mbsr_body_acceleration(s->model, s->data, id, A), mbsr_data_error(s->data));
        for (int k = 0; k < d; ++k) assert_close(A[k], slope[k], 1e-8);
    }
}

static void an_acceleration_is_the_rate_of_the_twist_along_the_motion(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_acceleration);
}

/* ---- Newton and Euler, body by body ---------------------------------------------------------- */

/* What a body needs to move with (V, A), in its world axes: impulse rates along the body's axes
 * with the mass matrix that is constant there, turned into the world.
 *
 *   P = M V_b,   moment = P_L' + omega x P_L + v x P_p,   force = P_p' + omega x P_p */
static void needed_in_space(const double *M, const double *R, const double *V, const double *A,
                            double *f)
{
    double Vb[6] = {0.0}, Ab[6] = {0.0}, P[6] = {0.0}, f_b[6] = {0.0};
    double spin[3] = {0.0};
    mixed_cross(V, V + 3, spin); /* v' along turning axes is v' - omega x v */
    for (int k = 0; k < 6; ++k) {
        const int block = k < 3 ? 0 : 3;
        for (int l = 0; l < 3; ++l) {
            const double turn = R[3 * (k - block) + l];
            Vb[k] += turn * V[block + l];
            Ab[k] += turn * (A[block + l] - (block ? spin[l] : 0.0));
        }
    }
    for (int k = 0; k < 6; ++k) {
        for (int l = 0; l < 6; ++l) {
            P[k] += M[6 * l + k] * Vb[l];
            f_b[k] += M[6 * l + k] * Ab[l];
        }
    }
    mixed_cross(Vb, P, f_b);
    mixed_cross(Vb + 3, P + 3, f_b);
    mixed_cross(Vb, P + 3, f_b + 3);
    for (int k = 0; k < 6; ++k) {
        const int block = k < 3 ? 0 : 3;
        f[k] = 0.0;
        for (int l = 0; l < 3; ++l) f[k] += R[3 * l + k - block] * f_b[block + l];
    }
}

/* Centre of mass c turned by the angle: m (r'' + alpha x c - omega^2 c), and the moment about the
 * origin. */
static void needed_in_plane(const double *M, const double *p, const double *V, const double *A,
                            double *f)
{
    const double c = cos(p[2]), s = sin(p[2]), m = M[0];
    const double x = c * M[7] + s * M[6], y = s * M[7] - c * M[6]; /* m times centre of mass */
    f[0] = m * A[0] - A[2] * y - V[2] * V[2] * x;
    f[1] = m * A[1] + A[2] * x - V[2] * V[2] * y;
    f[2] = M[8] * A[2] + x * A[1] - y * A[0];
}

static void needed(mixed *s, int id, double *f)
{
    const mixed_body *b = s->body + id;
    double p[MBSR_POSE_SIZE], V[6], A[6];
    assert_ok(mbsr_body_pose(s->model, s->data, id, p), NULL);
    twist_of(s, id, V);
    assert_ok(mbsr_body_acceleration(s->model, s->data, id, A), NULL);
    if (b->space == MBSR_SPACE_SPATIAL) {
        needed_in_space(b->M, p, V, A, f);
    } else if (b->space == MBSR_SPACE_PLANAR) {
        needed_in_plane(b->M, p, V, A, f);
    } else {
        for (int k = 0; k < b->d; ++k) {
            f[k] = 0.0;
            for (int l = 0; l < b->d; ++l) f[k] += b->M[b->d * l + k] * A[l];
        }
    }
}

/* Pose, as a point and a wrench in space: what lies in the plane has z = 0. */
static void as_wrench(mixed *s, int id, const double *f, double r[3], double wrench[6])
{
    const mbsr_space space = id == MBSR_GROUND ? s->model->root.space : s->body[id].space;
    double p[MBSR_POSE_SIZE];
    assert_ok(mbsr_body_pose(s->model, s->data, id, p), NULL);
    memset(wrench, 0, 6 * sizeof *wrench);
    if (space == MBSR_SPACE_SPATIAL) {
        memcpy(r, p + MBSR_POSE_X, 3 * sizeof *r);
        if (f) memcpy(wrench, f, 6 * sizeof *wrench);
        return;
    }
    r[0] = p[0], r[1] = p[1], r[2] = 0.0;
    if (f) wrench[3] = f[0], wrench[4] = f[1];
    if (f && space == MBSR_SPACE_PLANAR) wrench[2] = f[2];
}

/* The force on the predecessor, conjugate to its velocity, that does what f does on body id: f
 * moved to its origin. */
static void moved(mixed *s, int id, const double *f, double *g)
{
    const int parent = s->body[id].parent;
    const mbsr_space space = parent == MBSR_GROUND ? s->model->root.space : s->body[parent].space;
    double r[3], r_pred[3], wrench[6], none[6], arm[3];
    as_wrench(s, id, f, r, wrench);
    as_wrench(s, parent, NULL, r_pred, none);
    for (int k = 0; k < 3; ++k) arm[k] = r[k] - r_pred[k];
    mixed_cross(arm, wrench + 3, wrench);
    if (space == MBSR_SPACE_SPATIAL) {
        memcpy(g, wrench, 6 * sizeof *g);
        return;
    }
    g[0] = wrench[3], g[1] = wrench[4];
    if (space == MBSR_SPACE_PLANAR) g[2] = wrench[2];
}

/* The same for the general body: (dV / dV_pred)^T f = -(K^-1 H)^T f with its own K and H. */
static void moved_general(mixed *s, int id, const double *f, double *g)
{
    const mbsri_body *b = s->model->body + mbsri_index(s->model, id);
    const mbsr_joint_args args = mbsri_joint_args(s->model, s->data, mbsri_index(s->model, id), 0);
    double K[4] = {1.0, 0.0, 0.0, 1.0}, H[12] = {0.0}, J[2] = {0.0}, kI[2] = {0.0};
    assert_int_equal(b->joint.table->jacobians(&args, K, H, J, kI), 0);
    for (int k = 0; k < b->pred.d; ++k)
        g[k] = -(H[2 * k] * f[0] / K[0] + H[2 * k + 1] * f[1] / K[3]);
}

/* Reactions, applied forces and what the successors' joints exert, against what the body's motion
 * needs. */
static void check_reaction(mixed *s, state *x)
{
    double sum[MIXED_BODIES + 1][6] = {{0.0}}, f[6], g[6] = {0.0};
    accelerate(s, x);
    for (int id = 0; id < s->bodies; ++id) {
        const mixed_body *b = s->body + id;
        assert_ok(mbsr_joint_reaction(s->model, s->data, id, f), mbsr_data_error(s->data));
        if (b->space == MBSR_SPACE_GENERAL)
            moved_general(s, id, f, g);
        else
            moved(s, id, f, g);
        for (int k = 0; k < b->d; ++k) sum[id + 1][k] += f[k];
        for (int k = 0; k < size_of(s, b->parent); ++k) sum[b->parent + 1][k] -= g[k];
        if (!b->loaded) continue;
        mixed_load(id, x->t, b->d, f);
        for (int k = 0; k < b->d; ++k) sum[id + 1][k] += f[k];
    }
    for (int id = 0; id < s->bodies; ++id) {
        needed(s, id, f);
        for (int k = 0; k < s->body[id].d; ++k) assert_close(sum[id + 1][k], f[k], 1e-12);
    }
    /* nothing accelerates the root but who moves it: its force balances the joints' on it */
    assert_ok(mbsr_joint_reaction(s->model, s->data, MBSR_GROUND, f), mbsr_data_error(s->data));
    for (int k = 0; k < s->root_d; ++k) assert_close(sum[0][k], -f[k], 1e-12);
}

static void reactions_and_applied_forces_move_every_body_as_newton_and_euler_say(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_reaction);
}

/* The work of the reaction on the joint's own rates is that of the joint force and the spring. */
static void compare_with_joint_forces(mixed *s, const state *x, const double *tau)
{
    for (int id = 0; id < s->bodies; ++id) {
        const int d = s->body[id].d;
        double J[6 * MIXED_NU], f[6];
        int q, u, n;
        assert_int_equal(mbsr_body_coordinates(s->model, id, &q, NULL, &u, &n), 0);
        assert_ok(mbsr_joint_reaction(s->model, s->data, id, f), mbsr_data_error(s->data));
        assert_ok(mbsr_body_jacobian(s->model, s->data, id, J), mbsr_data_error(s->data));
        for (int c = 0; c < n; ++c) {
            double work = 0.0, expected = tau[u + c];
            for (int k = 0; k < d; ++k) work += J[d * (u + c) + k] * f[k];
            if (id == MIXED_SPRUNG_BODY && c == MIXED_SPRUNG) {
                expected -= mixed_spring[0] * (x->q[q + c] - mixed_spring[2]);
                expected -= mixed_spring[1] * x->u[u + c];
            }
            assert_close(work, expected, 1e-11);
        }
    }
}

static void check_joint_forces(mixed *s, state *x)
{
    double tau[MIXED_NU], udot[MIXED_NU];
    mbsri_data_poison(s->data);
    assert_ok(mbsr_inverse_dynamics(s->model, s->data, x->t, x->q, x->u, x->udot, NULL, tau),
              mbsr_data_error(s->data));
    assert_true(test_largest(s->nu, tau) > 0.5);
    compare_with_joint_forces(s, x, tau);
    /* forward dynamics leaves no reactions, but the accelerations that give them */
    mbsri_data_poison(s->data);
    assert_ok(mbsr_forward_dynamics(s->model, s->data, x->t, x->q, x->u, x->tau, udot),
              mbsr_data_error(s->data));
    assert_refused(mbsr_joint_reaction(s->model, s->data, 0, tau), mbsr_data_error(s->data),
                   MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, "mbsr_joint_reaction");
    assert_ok(mbsr_stage_accelerations(s->model, s->data, udot), mbsr_data_error(s->data));
    compare_with_joint_forces(s, x, x->tau);
}

static void reactions_contain_the_joint_forces(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_joint_forces);
}

/* ---- inverse dynamics ------------------------------------------------------------------------ */

static void check_bias(mixed *s, state *x)
{
    double tau[MIXED_NU], bias[MIXED_NU], mass[MIXED_NU * MIXED_NU];
    const int n = s->nu;
    mbsri_data_poison(s->data);
    assert_ok(mbsr_bias_forces(s->model, s->data, x->t, x->q, x->u, bias),
              mbsr_data_error(s->data));
    assert_ok(mbsr_mass_matrix(s->model, s->data, mass), mbsr_data_error(s->data));
    mbsri_data_poison(s->data);
    assert_ok(mbsr_inverse_dynamics(s->model, s->data, x->t, x->q, x->u, x->udot, NULL, tau),
              mbsr_data_error(s->data));
    for (int c = 0; c < n; ++c) {
        double sum = bias[c];
        for (int k = 0; k < n; ++k) sum += mass[n * k + c] * x->udot[k];
        assert_close(sum, tau[c], 1e-12);
    }
    /* virtual power, body by body: what the motion needs less what is applied */
    double power[MIXED_NU] = {0.0};
    for (int id = 0; id < s->bodies; ++id) {
        const int d = s->body[id].d;
        double J[6 * MIXED_NU], f[6], applied[6] = {0.0};
        needed(s, id, f);
        if (s->body[id].loaded) mixed_load(id, x->t, d, applied);
        assert_ok(mbsr_body_jacobian(s->model, s->data, id, J), mbsr_data_error(s->data));
        for (int c = 0; c < n; ++c) {
            for (int k = 0; k < d; ++k) power[c] += J[d * c + k] * (f[k] - applied[k]);
        }
    }
    int q, u;
    assert_int_equal(mbsr_body_coordinates(s->model, MIXED_SPRUNG_BODY, &q, NULL, &u, NULL), 0);
    power[u] += mixed_spring[0] * (x->q[q] - mixed_spring[2]) + mixed_spring[1] * x->u[u];
    for (int c = 0; c < n; ++c) assert_close(power[c], tau[c], 1e-11);
}

static void mass_matrix_and_bias_forces_are_inverse_dynamics(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_bias);
}

/* ---- momentum of the tree -------------------------------------------------------------------- */

/* Momentum about the world's origin. */
static void momentum_along(mixed *s, const void *about, double *momentum)
{
    assert_ok(mbsr_tree_momentum(s->model, s->data, about, NULL, NULL, momentum),
              mbsr_data_error(s->data));
}

/* Adds f, which acts at the body's origin, as a wrench about a fixed point. */
static void add_wrench(mixed *s, int id, const double *f, const double about[3], double *sum)
{
    double r[3], wrench[6], arm[3];
    as_wrench(s, id, f, r, wrench);
    for (int k = 0; k < 3; ++k) arm[k] = r[k] - about[k];
    mixed_cross(arm, wrench + 3, wrench);
    for (int k = 0; k < 6; ++k) sum[k] += wrench[k];
}

/* The moment about a POINT that a joint exerts on it: a point cannot turn, so the moment ends
 * there, as on something outside. */
static void add_moment_on_point(mixed *s, int id, double *sum)
{
    const int parent = s->body[id].parent;
    double f[6], r[3], r_pred[3], wrench[6], none[6], arm[3];
    if (parent == MBSR_GROUND || s->body[parent].space != MBSR_SPACE_POINT) return;
    assert_ok(mbsr_joint_reaction(s->model, s->data, id, f), NULL);
    as_wrench(s, id, f, r, wrench);
    as_wrench(s, parent, NULL, r_pred, none);
    for (int k = 0; k < 3; ++k) arm[k] = r[k] - r_pred[k];
    mixed_cross(arm, wrench + 3, wrench);
    for (int k = 0; k < 3; ++k) sum[k] += wrench[k];
}

/* d/dt of the momentum is the sum of the applied wrenches and of what holds the root. Reactions
 * that a planar joint exerts out of the plane are no part of the model: there only what lies in the
 * plane balances. */
static void check_momentum_rate(mixed *s, state *x)
{
    const bool plane = s->model->root.space == MBSR_SPACE_PLANAR;
    const double about[3] = {0.8, -1.3, plane ? 0.0 : 0.6};
    double slope[6], sum[6] = {0.0}, f[6];
    along_the_motion(s, x, 6, momentum_along, about, slope);
    accelerate(s, x);
    for (int id = 0; id < s->bodies; ++id) {
        if (s->body[id].parent == MBSR_GROUND && s->scene == MIXED_ARM) {
            /* a root at rest has no force of its own: its joints' */
            assert_ok(mbsr_joint_reaction(s->model, s->data, id, f), NULL);
            add_wrench(s, id, f, about, sum);
        }
        add_moment_on_point(s, id, sum);
        if (!s->body[id].loaded) continue;
        mixed_load(id, x->t, s->body[id].d, f);
        add_wrench(s, id, f, about, sum);
    }
    if (s->root_d > 0) {
        assert_ok(mbsr_joint_reaction(s->model, s->data, MBSR_GROUND, f), NULL);
        add_wrench(s, MBSR_GROUND, f, about, sum);
    }
    for (int k = plane ? 2 : 0; k < (plane ? 5 : 6); ++k) assert_close(slope[k], sum[k], 1e-7);
}

static void the_momentum_of_the_tree_changes_by_the_external_wrenches(void **unused)
{
    (void)unused;
    for_scenes(MIXED_SCENES, check_momentum_rate);
}

/* Mass, centre and momentum of one body about a point, from its matrix along its own axes. */
static double one_body(mixed *s, int id, const double about[3], double first[3], double P[6])
{
    const mixed_body *b = s->body + id;
    double p[MBSR_POSE_SIZE], V[6], r[3], wrench[6], f[6] = {0.0}, c[3] = {0.0}, mass;
    assert_ok(mbsr_body_pose(s->model, s->data, id, p), NULL);
    twist_of(s, id, V);
    memset(P, 0, 6 * sizeof *P);
    if (b->space == MBSR_SPACE_SPATIAL) {
        /* P = R M R^T V */
        double Vb[6] = {0.0}, Pb[6] = {0.0};
        for (int k = 0; k < 6; ++k) {
            for (int l = 0; l < 3; ++l) Vb[k] += p[3 * (k % 3) + l] * V[k - k % 3 + l];
        }
        for (int k = 0; k < 36; ++k) Pb[k % 6] += b->M[k] * Vb[k / 6];
        for (int k = 0; k < 6; ++k) {
            for (int l = 0; l < 3; ++l) f[k] += p[3 * l + k % 3] * Pb[k - k % 3 + l];
        }
        mass = (b->M[21] + b->M[28] + b->M[35]) / 3.0;
        const double body[3] = {0.5 * (b->M[26] - b->M[31]), 0.5 * (b->M[30] - b->M[20]),
                                0.5 * (b->M[19] - b->M[24])};
        for (int k = 0; k < 9; ++k) c[k % 3] += p[k] * body[k / 3];
    } else {
        const double *M = b->M;
        mass = M[0];
        if (b->space == MBSR_SPACE_PLANAR) {
            c[0] = cos(p[2]) * M[7] + sin(p[2]) * M[6];
            c[1] = sin(p[2]) * M[7] - cos(p[2]) * M[6];
            f[2] = M[8] * V[2] + c[0] * V[1] - c[1] * V[0];
        }
        f[0] = mass * V[0] - (b->d > 2 ? V[2] * c[1] : 0.0);
        f[1] = mass * V[1] + (b->d > 2 ? V[2] * c[0] : 0.0);
    }
    as_wrench(s, id, f, r, wrench);
    add_wrench(s, id, f, about, P);
    for (int k = 0; k < 3; ++k) first[k] = mass * r[k] + c[k];
    return mass;
}

static void check_momentum(mixed *s, state *x)
{
    static const double none[MIXED_NU] = {0.0};
    const double about[3] = {0.8, -1.3, 0.6}, origin[3] = {0.0, 0.0, 0.0};
    for (int turn = 0; turn < 3; ++turn) { /* moved by u; by what is driven alone; elsewhere */
        double mass = NAN, centre[3], P[6], sum[6] = {0.0}, first[3] = {0.0}, total = 0.0;
        move(s, x->t, x->q, turn == 1 ? none : x->u);
        for (int id = 0; id < s->bodies; ++id) {
            double one[6], c[3];
            total += one_body(s, id, turn == 2 ? about : origin, c, one);
            for (int k = 0; k < 6; ++k) sum[k] += one[k];
            for (int k = 0; k < 3; ++k) first[k] += c[k];
        }
        assert_ok(mbsr_tree_momentum(s->model, s->data, turn == 2 ? about : NULL, &mass, centre, P),
                  mbsr_data_error(s->data));
        assert_close(mass, total, 1e-13);
        for (int k = 0; k < 3; ++k) assert_close(centre[k], first[k] / total, 1e-13);
        for (int k = 0; k < 6; ++k) assert_close(P[k], sum[k], 1e-12);
        if (s->scene == MIXED_ARM && turn == 1)
            for (int k = 0; k < 6; ++k) assert_close(P[k], 0.0, 0.0);
        else
            assert_true(test_largest(6, P) > 0.1);
        /* each output alone */
        double again[6];
        assert_int_equal(
            mbsr_tree_momentum(s->model, s->data, turn == 2 ? about : NULL, NULL, NULL, again), 0);
        assert_memory_equal(again, P, sizeof P);
        assert_int_equal(mbsr_tree_momentum(s->model, s->data, NULL, NULL, again, NULL), 0);
        assert_memory_equal(again, centre, sizeof centre);
        assert_int_equal(mbsr_tree_momentum(s->model, s->data, NULL, again, NULL, NULL), 0);
        assert_memory_equal(again, &mass, sizeof mass);
    }
}

static void the_momentum_of_the_tree_is_the_sum_over_its_bodies(void **unused)
{
    (void)unused;
    for_scenes(MIXED_SCENES, check_momentum);
}

static void a_tree_without_mass_has_its_centre_nowhere(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_spherical(NULL, NULL);
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    assert_int_equal(mbsr_model_add_body(m, &def, NULL), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    mbsri_data_poison(d);
    double mass = NAN, centre[3] = {NAN, NAN, NAN}, P[6] = {NAN, NAN, NAN, NAN, NAN, NAN};
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, (const double[4]){0.1, 0.2, 0.3, 0.4}), 0);
    assert_int_equal(mbsr_stage_velocities(m, d, (const double[3]){1.0, 2.0, 3.0}), 0);
    assert_int_equal(mbsr_tree_momentum(m, d, NULL, &mass, centre, P), 0);
    assert_close(mass, 0.0, 0.0);
    assert_close(test_largest(3, centre), 0.0, 0.0);
    assert_close(test_largest(6, P), 0.0, 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- normal form ----------------------------------------------------------------------------- */

/* Places of the quaternions in q. */
static int quaternions(const mixed *s, int *place)
{
    int count = 0;
    for (int id = 0; id < s->bodies; ++id) {
        int q, nq, n;
        assert_int_equal(mbsr_body_coordinates(s->model, id, &q, &nq, NULL, &n), 0);
        if (nq == n + 1) place[count++] = q;
    }
    return count;
}

/* Fails unless b is a with its quaternions at length 1. */
static void assert_normal(const mixed *s, const double *a, const double *b)
{
    double expected[MIXED_NQ];
    int place[MIXED_BODIES];
    memcpy(expected, a, sizeof expected);
    const int count = quaternions(s, place);
    assert_true(count >= 1);
    for (int l = 0; l < count; ++l) {
        double *e = expected + place[l], size = 0.0;
        for (int k = 0; k < 4; ++k) size += e[k] * e[k];
        assert_true(fabs(size - 1.0) > 1e-3);
        for (int k = 0; k < 4; ++k) e[k] /= sqrt(size);
    }
    for (int k = 0; k < s->nq; ++k) assert_close(b[k], expected[k], 1e-15);
}

static void check_normal_form(mixed *s, state *x)
{
    static const mbsr_dae_form forms[4] = {MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1, MBSR_DAE_RECURSIVE,
                                           MBSR_DAE_INVERSE_DYNAMICS};
    double pose[2][MBSR_POSE_SIZE], q[MIXED_NQ];
    memcpy(q, x->q, sizeof q);
    mbsri_data_poison(s->data);
    assert_ok(mbsr_normalise(s->model, s->data, q), mbsr_data_error(s->data));
    assert_normal(s, x->q, q);
    for (int id = 0; id < s->bodies; ++id) { /* no pose depends on what changed */
        for (int side = 0; side < 2; ++side) {
            assert_int_equal(mbsr_stage_positions(s->model, s->data, x->t, side ? q : x->q), 0);
            assert_int_equal(mbsr_body_pose(s->model, s->data, id, pose[side]), 0);
        }
        for (int k = 0; k < s->body[id].np; ++k) assert_close(pose[0][k], pose[1][k], 1e-14);
    }
    for (int f = 0; f < 4; ++f) {
        double y[MIXED_NQ + 2 * MIXED_NU], back[MIXED_NQ], u[MIXED_NU];
        int place[MIXED_BODIES];
        assert_ok(mbsr_dae_pack(s->model, s->data, forms[f], x->t, x->q, x->u, y),
                  mbsr_data_error(s->data));
        assert_normal(s, x->q, y);
        /* as an integrator might bring it back: longer, shorter */
        const int count = quaternions(s, place);
        for (int l = 0; l < count; ++l)
            for (int k = 0; k < 4; ++k) y[place[l] + k] *= l % 2 ? 0.3 : 1.7;
        assert_ok(mbsr_dae_unpack(s->model, s->data, forms[f], x->t, y, back, u),
                  mbsr_data_error(s->data));
        for (int k = 0; k < s->nq; ++k) assert_close(back[k], q[k], 1e-15);
        for (int k = 0; k < s->nu; ++k) assert_close(u[k], x->u[k], 1e-11);
        /* length zero has no direction */
        for (int k = 0; k < 4; ++k) y[place[0] + k] = 0.0;
        assert_refused(mbsr_dae_unpack(s->model, s->data, forms[f], x->t, y, back, u),
                       mbsr_data_error(s->data), MBSR_ZERO_QUATERNION,
                       s->scene == MIXED_PLANE || s->scene == MIXED_GENERAL_PLANE ? 5 : 0,
                       MBSR_NONE, s->body[0].space == MBSR_SPACE_PLANAR ? "float" : "base");
    }
}

static void pack_and_unpack_normalise_quaternions(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_normal_form);
}

/* q' = G u turns the quaternion and keeps its length. */
static void check_length(mixed *s, state *x)
{
    double qdot[MIXED_NQ];
    int place[MIXED_BODIES];
    rates(s, x->t, x->q, x->u, qdot);
    const int count = quaternions(s, place);
    for (int l = 0; l < count; ++l) {
        double growth = 0.0, size = 0.0;
        for (int k = place[l]; k < place[l] + 4; ++k) {
            growth += qdot[k] * x->q[k];
            size += qdot[k] * qdot[k];
        }
        assert_true(size > 1e-3);
        assert_close(growth, 0.0, 1e-15);
    }
}

static void the_rate_of_a_quaternion_keeps_its_length(void **unused)
{
    (void)unused;
    for_scenes(MIXED_ALL, check_length);
}

/* A joint whose normal form is an angle within half a turn; the coordinates before and after stay.
 */
static int wrap(const mbsr_joint_args *args, double *q)
{
    assert_int_equal(args->nq, 3);
    q[2] = remainder(q[2], 2.0 * acos(-1.0));
    return 0;
}

static void a_normal_form_sees_locked_coordinates_too(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_in_plane(NULL, NULL);
    def.inertia = mbsr_inertia_sphere(1.0, 1.0);
    mbsr_joint_table table = *def.joint.table;
    table.normalise = wrap;
    def.joint.table = &table;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 2; ++k) assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_lock(m, 0, 0, 0.25), mbsr_model_error(m));
    assert_ok(mbsr_model_lock(m, 1, 1, 0.5), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    const double turn = 2.0 * acos(-1.0), expected[4] = {0.1, 0.4, -0.2, -0.7};
    double q[4] = {0.1, 0.4 + 2.0 * turn, -0.2, -0.7 - turn};
    mbsri_data_poison(d);
    assert_ok(mbsr_normalise(m, d, q), mbsr_data_error(d));
    for (int k = 0; k < 4; ++k) assert_close(q[k], expected[k], 1e-14);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static double out[MIXED_NU * MIXED_NU];

typedef int (*body_query)(const mbsr_model *m, mbsr_data *d, int body, double *result);

static const struct {
    body_query ask;
    const char *name;
} queries[] = {{mbsr_body_acceleration, "mbsr_body_acceleration"},
               {mbsr_joint_reaction, "mbsr_joint_reaction"},
               {mbsr_body_jacobian, "mbsr_body_jacobian"}};

static void assert_no_reactions(mixed *s, const char *words)
{
    for (int k = 0; k < 2; ++k) {
        assert_refused(queries[k].ask(s->model, s->data, 0, out), mbsr_data_error(s->data),
                       MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, words);
        assert_contains(mbsr_data_error(s->data)->text, queries[k].name);
    }
}

static void reactions_are_those_of_the_last_accelerations_only(void **unused)
{
    (void)unused;
    static const char *const before = "call |before|mbsr_stage_accelerations|mbsr_inverse_dynamics";
    mixed s;
    state x;
    test_rng rng = test_seed(90);
    mixed_make(&s, MIXED_SPACE);
    random_state(&s, &rng, &x);
    mbsr_model *m = s.model;
    mbsr_data *d = s.data;
    assert_no_reactions(&s, "call ");
    for (int next = 0; next < 6; ++next) {
        accelerate(&s, &x);
        for (int k = 0; k < 2; ++k) assert_int_equal(queries[k].ask(m, d, 0, out), 0);
        /* asking for results changes nothing */
        assert_int_equal(mbsr_body_jacobian(m, d, 0, out), 0);
        assert_int_equal(mbsr_mass_matrix(m, d, out), 0);
        assert_int_equal(mbsr_tree_momentum(m, d, NULL, NULL, NULL, out), 0);
        assert_int_equal(mbsr_energy(m, d, out, out + 1), 0);
        assert_int_equal(mbsr_momenta(m, d, out), 0);
        assert_int_equal(mbsr_coordinate_rates(m, d, out), 0);
        double again[2][6], first[2][6], y[MIXED_NQ + MIXED_NU];
        for (int k = 0; k < 2; ++k) assert_int_equal(queries[k].ask(m, d, 5, again[k]), 0);
        accelerate(&s, &x);
        for (int k = 0; k < 2; ++k) assert_int_equal(queries[k].ask(m, d, 5, first[k]), 0);
        assert_memory_equal(again, first, sizeof first);
        switch (next) { /* a new stage makes them invalid */
        case 0: assert_int_equal(mbsr_stage_positions(m, d, x.t, x.q), 0); break;
        case 1: assert_int_equal(mbsr_stage_velocities(m, d, x.u), 0); break;
        case 2: assert_int_equal(mbsr_stage_forces(m, d, NULL), 0); break;
        case 3: assert_int_equal(mbsr_stage_backward(m, d), 0); break;
        case 4:
            assert_int_equal(mbsr_forward_dynamics(m, d, x.t, x.q, x.u, x.tau, out), 0);
            assert_int_equal(mbsr_stage_accelerations(m, d, x.udot), 0);
            assert_int_equal(mbsr_stage_forward(m, d, x.tau, out), 0);
            break;
        default:
            assert_int_equal(mbsr_dae_pack(m, d, MBSR_DAE_RECURSIVE, x.t, x.q, x.u, y), 0);
            accelerate(&s, &x);
            assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, x.t, y, y, out), 0);
        }
        assert_no_reactions(&s, next < 2 ? "call " : before);
    }
    mixed_free(&s);
}

static void stages_that_are_missing_are_named(void **unused)
{
    (void)unused;
    mixed s;
    state x;
    test_rng rng = test_seed(91);
    mixed_make(&s, MIXED_PLANE);
    random_state(&s, &rng, &x);
    mbsr_model *m = s.model;
    mbsr_data *d = s.data;
    const mbsr_error *error = mbsr_data_error(d);
    assert_refused(mbsr_body_jacobian(m, d, 0, out), error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "mbsr_body_jacobian|mbsr_stage_positions");
    assert_int_equal(mbsr_stage_positions(m, d, x.t, x.q), 0);
    assert_refused(mbsr_tree_momentum(m, d, NULL, out, NULL, NULL), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_tree_momentum|mbsr_stage_velocities");
    assert_int_equal(mbsr_stage_velocities(m, d, x.u), 0);
    assert_refused(mbsr_stage_accelerations(m, d, x.udot), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_stage_accelerations|mbsr_stage_forces");
    mixed_free(&s);
}

static int heavy(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)p, (void)V, (void)h;
    M[0] = M[3] = 2.0;
    return 0;
}

static void the_mass_matrix_waits_for_inertias_by_function(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_point_free();
    def.inertia = mbsr_inertia_function(heavy, NULL);
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    const double q[2] = {1.0, 2.0};
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, q), 0);
    assert_refused(mbsr_mass_matrix(m, d, out), mbsr_data_error(d), MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_mass_matrix|mbsr_stage_velocities");
    assert_int_equal(mbsr_stage_velocities(m, d, q), 0);
    assert_ok(mbsr_mass_matrix(m, d, out), mbsr_data_error(d));
    assert_close(out[0], 2.0, 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void wrong_arguments_are_refused(void **unused)
{
    (void)unused;
    mixed s, other;
    state x;
    test_rng rng = test_seed(92);
    mixed_make(&s, MIXED_SPACE);
    mixed_make(&other, MIXED_PLANE);
    random_state(&s, &rng, &x);
    accelerate(&s, &x);
    mbsr_model *m = s.model;
    mbsr_data *d = s.data;
    const mbsr_error *error = mbsr_data_error(d);
    for (size_t k = 0; k < sizeof queries / sizeof queries[0]; ++k) {
        static const int ids[] = {MIXED_BODIES, -2, 1000000};
        for (int l = 0; l < 3; ++l) {
            assert_refused(queries[k].ask(m, d, ids[l], out), error, MBSR_ERR_ID, MBSR_NONE,
                           MBSR_NONE, queries[k].name);
            assert_contains(error->text, "there is no body");
        }
        assert_refused(queries[k].ask(m, d, 0, NULL), error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                       queries[k].name);
        assert_int_equal(queries[k].ask(NULL, d, 0, out), MBSR_ERR_NULL);
        assert_int_equal(queries[k].ask(m, NULL, 0, out), MBSR_ERR_NULL);
        assert_refused(queries[k].ask(other.model, d, 0, out), error, MBSR_ERR_MISMATCH, MBSR_NONE,
                       MBSR_NONE, queries[k].name);
    }
    assert_refused(mbsr_stage_accelerations(m, d, NULL), error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_accelerations");
    assert_refused(mbsr_bias_forces(m, d, 0.0, x.q, x.u, NULL), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "mbsr_bias_forces");
    assert_refused(mbsr_normalise(m, d, NULL), error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "mbsr_normalise");
    assert_refused(mbsr_tree_momentum(other.model, d, NULL, out, NULL, NULL), error,
                   MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "mbsr_tree_momentum");
    /* the reactions are still there */
    assert_int_equal(mbsr_joint_reaction(m, d, 0, out), 0);
    x.udot[1] = NAN;
    assert_refused(mbsr_stage_accelerations(m, d, x.udot), error, MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, "not finite");
    mixed_free(&s);
    mixed_free(&other);
}

/* Without inertia a general body is no obstacle; with it nobody knows where its momentum points. */
static void the_momentum_of_a_general_body_is_refused(void **unused)
{
    (void)unused;
    for (int scene = MIXED_GENERAL; scene < MIXED_ALL; ++scene) {
        mixed s;
        state x;
        test_rng rng = test_seed(93);
        mixed_make(&s, (mixed_scene)scene);
        random_state(&s, &rng, &x);
        move(&s, x.t, x.q, x.u);
        assert_refused(mbsr_tree_momentum(s.model, s.data, NULL, out, NULL, NULL),
                       mbsr_data_error(s.data), MBSR_ERR_SPACE, s.bodies - 1, MBSR_NONE,
                       "mbsr_tree_momentum|gauge|GENERAL");
        mixed_free(&s);
    }
    mbsr_model *m;
    mbsr_data *d;
    mbsr_body_def def = mbsr_default_body_def();
    const double nothing[9] = {0.0};
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    def.joint = mbsr_joint_planar_free((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
    def.joint.space = MBSR_SPACE_GENERAL;
    def.inertia = mbsr_inertia_matrix(3, nothing);
    assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    def.joint = mbsr_joint_point_free();
    def.inertia = mbsr_inertia_particle(2.0);
    assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    const double q[5] = {1.0, 2.0, 3.0, 4.0, 5.0};
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, q), 0);
    assert_int_equal(mbsr_stage_velocities(m, d, q), 0);
    assert_ok(mbsr_tree_momentum(m, d, NULL, NULL, NULL, out), mbsr_data_error(d));
    assert_close(out[3], 8.0, 1e-15);
    assert_close(out[4], 10.0, 1e-15);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_jacobian_maps_joint_rates_to_the_twist_and_to_displacements),
        cmocka_unit_test(an_acceleration_is_the_rate_of_the_twist_along_the_motion),
        cmocka_unit_test(reactions_and_applied_forces_move_every_body_as_newton_and_euler_say),
        cmocka_unit_test(reactions_contain_the_joint_forces),
        cmocka_unit_test(mass_matrix_and_bias_forces_are_inverse_dynamics),
        cmocka_unit_test(the_momentum_of_the_tree_changes_by_the_external_wrenches),
        cmocka_unit_test(the_momentum_of_the_tree_is_the_sum_over_its_bodies),
        cmocka_unit_test(a_tree_without_mass_has_its_centre_nowhere),
        cmocka_unit_test(pack_and_unpack_normalise_quaternions),
        cmocka_unit_test(the_rate_of_a_quaternion_keeps_its_length),
        cmocka_unit_test(a_normal_form_sees_locked_coordinates_too),
        cmocka_unit_test(reactions_are_those_of_the_last_accelerations_only),
        cmocka_unit_test(stages_that_are_missing_are_named),
        cmocka_unit_test(the_mass_matrix_waits_for_inertias_by_function),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(the_momentum_of_a_general_body_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
