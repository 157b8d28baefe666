/* Trees of stock joints in space, and twins of them with joints written here in another way: bodies
 * in space with the stock inertias, and GENERAL bodies with inertias by function. Same masses,
 * accelerations, joint forces and residuals.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The twin's kinematics: twists (omega, v0) about the world's origin, where v0 is the velocity of
 * the point that passes there. The motion of step k with the twist xi in the running frame T is
 * S_k = Ad(T) xi, all S add up, and S_k' = V0_k x S_k with the twist V0_k of the running frame. A
 * body's own V is (omega, v0 + omega x r). k is multiplied by a regular matrix Q(t), so that K =
 * Q. */
#include "expect.h"
#include "samples.h"

#include <string.h>

/* ---- twists --------------------------------------------------------------------------------- */

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Ad(T) (w, v) = (R w, R v + x x R w) */
static void carry(const transform *T, const double w[3], const double v[3], double S[6])
{
    double x[3], lever[3];
    for (int i = 0; i < 3; ++i) {
        S[i] = S[3 + i] = 0.0;
        for (int j = 0; j < 3; ++j) {
            S[i] += T->m[i][j] * w[j];
            S[3 + i] += T->m[i][j] * v[j];
        }
        x[i] = T->m[i][3];
    }
    cross(x, S, lever);
    for (int i = 0; i < 3; ++i) S[3 + i] += lever[i];
}

/* c = a x b = (a_w x b_w, a_w x b_v + a_v x b_w) */
static void bracket(const double a[6], const double b[6], double c[6])
{
    double other[3];
    cross(a, b, c);
    cross(a, b + 3, c + 3);
    cross(a + 3, b, other);
    for (int i = 0; i < 3; ++i) c[3 + i] += other[i];
}

/* ---- a joint of the twin -------------------------------------------------------------------- */

typedef struct twin {
    sample s;
    double Q0[36], Q1[36]; /* Q = Q0 + sin(t) Q1 */
    int particles;
    double m[4], x[4][3]; /* of the body, in its axes */
} twin;

static void times(const double *A, const double *x, double *y)
{
    for (int i = 0; i < 6; ++i) {
        y[i] = 0.0;
        for (int j = 0; j < 6; ++j) y[i] += A[6 * j + i] * x[j];
    }
}

static void weight(const twin *w, double t, bool rate, double *Q)
{
    for (int i = 0; i < 36; ++i) Q[i] = rate ? cos(t) * w->Q1[i] : w->Q0[i] + sin(t) * w->Q1[i];
}

/* Columns S of the joint's rates and their S', in the order of u; the parts of what is driven. */
typedef struct motion {
    double S[6][6], rate[6][6];     /* per coordinate of u */
    double drive[6], drive_bias[6]; /* sum of S s', sum of S' s' + S s'' over driven steps */
    double V0[6], V0_pred[6];       /* twists about the world's origin */
    double r[3], r_pred[3];
} motion;

static transform predecessor(const mbsr_joint_args *args)
{
    return args->pred_d ? transform_of(args->p_pred + MBSR_POSE_R, args->p_pred + MBSR_POSE_X)
                        : transform_unit();
}

static void add_step(motion *w, const double S[6], const double before[6], int place, double sd,
                     double sdd)
{
    double rate[6];
    bracket(before, S, rate);
    for (int i = 0; i < 6; ++i) {
        w->V0[i] += S[i] * sd;
        if (place >= 0) {
            w->S[place][i] = S[i];
            w->rate[place][i] = rate[i];
        } else {
            w->drive[i] += S[i] * sd;
            w->drive_bias[i] += rate[i] * sd + S[i] * sdd;
        }
    }
}

static void find_motion(const mbsr_joint_args *args, motion *w)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, none[3] = {0, 0, 0};
    const sample *s = &((const twin *)args->user)->s;
    *w = (motion){.V0 = {0}};
    transform T = predecessor(args);
    for (int i = 0; i < 3; ++i) w->r_pred[i] = T.m[i][3];
    if (args->V_pred && args->pred_d) {
        double lever[3];
        memcpy(w->V0_pred, args->V_pred, sizeof w->V0_pred);
        cross(w->V0_pred, w->r_pred, lever);
        for (int i = 0; i < 3; ++i) w->V0_pred[3 + i] -= lever[i];
    }
    memcpy(w->V0, w->V0_pred, sizeof w->V0);
    T = transform_product(T, transform_of(s->A.R, s->A.x));
    const int behind = args->nq - args->n; /* places of q ahead of those of u */
    for (int k = 0; k < s->steps; ++k) {
        const elementary *e = s->step + k;
        double S[6], before[6];
        memcpy(before, w->V0, sizeof before);
        if (e->quaternion) {
            for (int c = 0; c < 3; ++c) {
                carry(&T, axes[c], none, S);
                add_step(w, S, before, c, args->u ? args->u[c] : 0.0, 0.0);
            }
            T = transform_product(T, transform_quaternion(args->q));
            continue;
        }
        const int c = e->coordinate, wave = SAMPLE_DRIVEN + c;
        const double x = e->driven ? sample_wave(wave, args->t, 0) : args->q[c];
        const double xd = e->driven ? sample_wave(wave, args->t, 1)
                          : args->u ? args->u[c - behind]
                                    : 0.0;
        double turn[3], shift[3];
        for (int i = 0; i < 3; ++i) turn[i] = x * e->w[i], shift[i] = x * e->v[i];
        carry(&T, e->w, e->v, S);
        add_step(w, S, before, e->driven ? -1 : c - behind, xd,
                 e->driven ? sample_wave(wave, args->t, 2) : 0.0);
        T = transform_product(T, transform_exp(turn, shift));
    }
    T = transform_product(T, transform_inverse(transform_of(s->B.R, s->B.x)));
    for (int i = 0; i < 3; ++i) w->r[i] = T.m[i][3];
}

/* y = -(S about the body's origin): (a, b) -> -(a, b + a x r) */
static void to_body(const double S[6], const double r[3], double y[6])
{
    double lever[3];
    cross(S, r, lever);
    for (int i = 0; i < 3; ++i) {
        y[i] = -S[i];
        y[3 + i] = -S[3 + i] - lever[i];
    }
}

static int position(const mbsr_joint_args *args, double *p)
{
    const twin *w = args->user;
    const transform T = transform_product(predecessor(args), sample_pose(&w->s, args->q, args->t));
    transform_pose(&T, p);
    return 0;
}

/* H before Q: the predecessor's twist about the world's origin, and from there to the body. */
static void plain_H(const motion *w, int c, double column[6])
{
    double V[6] = {0.0}, lever[3];
    V[c] = 1.0;
    cross(V, w->r_pred, lever);
    for (int i = 0; i < 3; ++i) V[3 + i] -= lever[i];
    to_body(V, w->r, column);
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    motion w;
    double Q[36], column[6];
    find_motion(args, &w);
    weight(args->user, args->t, false, Q);
    memcpy(K, Q, sizeof Q);
    for (int c = 0; c < args->pred_d; ++c) {
        plain_H(&w, c, column);
        times(Q, column, H + 6 * c);
    }
    for (int c = 0; c < args->n; ++c) {
        to_body(w.S[c], w.r, column);
        times(Q, column, J + 6 * c);
    }
    to_body(w.drive, w.r, column);
    times(Q, column, kI);
    return 0;
}

/* A0 = A0_pred + sum of S' u + what is driven + S u', v' = a0 + alpha x r + omega x v. */
static int bias(const mbsr_joint_args *args, double *kII)
{
    motion w;
    double A0[6], pred[6] = {0.0}, sum[6], lever[3], Q[36];
    find_motion(args, &w);
    /* of the predecessor: a0 = r'' - alpha x r - omega x r', the last without accelerations */
    if (args->pred_d) {
        cross(args->V_pred, args->V_pred + 3, lever);
        for (int i = 0; i < 3; ++i) pred[3 + i] = -lever[i];
    }
    for (int i = 0; i < 6; ++i) {
        A0[i] = pred[i] + w.drive_bias[i];
        for (int c = 0; c < args->n; ++c) A0[i] += w.rate[c][i] * args->u[c];
    }
    to_body(A0, w.r, sum);
    double v[3];
    cross(w.V0, w.r, v);
    for (int i = 0; i < 3; ++i) v[i] += w.V0[3 + i];
    cross(w.V0, v, lever);
    for (int i = 0; i < 3; ++i) sum[3 + i] -= lever[i];
    weight(args->user, args->t, false, Q);
    times(Q, sum, kII);
    return 0;
}

/* d/dt of Q (column): Q' column + Q column', where columns turn with the joint and r moves. */
static void rate_of(const double *Q, const double *Qdot, const double column[6],
                    const double slope[6], double *out)
{
    double other[6];
    times(Qdot, column, out);
    times(Q, slope, other);
    for (int i = 0; i < 6; ++i) out[i] += other[i];
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    motion w;
    double Q[36], Qdot[36], column[6], slope[6], v[3], v_pred[3], lever[3];
    find_motion(args, &w);
    weight(args->user, args->t, false, Q);
    weight(args->user, args->t, true, Qdot);
    memcpy(Kdot, Qdot, sizeof Qdot);
    cross(w.V0, w.r, v);
    cross(w.V0_pred, w.r_pred, v_pred);
    for (int i = 0; i < 3; ++i) v[i] += w.V0[3 + i], v_pred[i] += w.V0_pred[3 + i];
    for (int c = 0; c < args->pred_d; ++c) {
        double V[6] = {0.0};
        V[c] = 1.0;
        plain_H(&w, c, column);
        double relative[3];
        for (int i = 0; i < 3; ++i) relative[i] = v[i] - v_pred[i], slope[i] = 0.0;
        cross(V, relative, lever);
        for (int i = 0; i < 3; ++i) slope[3 + i] = -lever[i];
        rate_of(Q, Qdot, column, slope, Hdot + 6 * c);
    }
    for (int c = 0; c < args->n; ++c) {
        to_body(w.S[c], w.r, column);
        to_body(w.rate[c], w.r, slope);
        cross(w.S[c], v, lever);
        for (int i = 0; i < 3; ++i) slope[3 + i] -= lever[i];
        rate_of(Q, Qdot, column, slope, Jdot + 6 * c);
    }
    return 0;
}

/* q' = 1/2 (0, omega) q */
static int coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    const double omega[4] = {0.0, 0.5 * args->u[0], 0.5 * args->u[1], 0.5 * args->u[2]};
    quaternion_product(omega, args->q, qdot);
    for (int k = 3; k < args->n; ++k) qdot[k + 1] = args->u[k];
    return 0;
}

static const mbsr_joint_table plain_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                             .name = "twin",
                                             .position = position,
                                             .jacobians = jacobians,
                                             .bias = bias,
                                             .rates = rates},
                              ball_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                            .name = "twin with quaternion",
                                            .position = position,
                                            .jacobians = jacobians,
                                            .bias = bias,
                                            .rates = rates,
                                            .coordinate_rates = coordinate_rates};

/* M and h of the particles. */
static int inertia(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    const twin *w = user;
    (void)t;
    for (int k = 0; k < w->particles; ++k) {
        const double m = w->m[k];
        double arm[3], turn[3], spin[3], moment[3];
        for (int i = 0; i < 3; ++i) {
            arm[i] = 0.0;
            for (int j = 0; j < 3; ++j) arm[i] += p[MBSR_POSE_R + 3 * j + i] * w->x[k][j];
        }
        /* velocity of the particle per unit of V: (e x arm, e) */
        double B[6][3] = {{0}};
        for (int c = 0; c < 3; ++c) {
            double e[3] = {c == 0, c == 1, c == 2};
            cross(e, arm, B[c]);
            B[3 + c][c] = 1.0;
        }
        for (int i = 0; i < 36; ++i) {
            for (int l = 0; l < 3; ++l) M[i] += m * B[i / 6][l] * B[i % 6][l];
        }
        cross(V, arm, turn);
        cross(V, turn, spin);
        cross(arm, spin, moment);
        for (int i = 0; i < 3; ++i) h[i] += m * moment[i], h[3 + i] += m * spin[i];
    }
    return 0;
}

/* ---- trees ---------------------------------------------------------------------------------- */

enum { STOCK, OWN, GENERAL, MODELS };
enum { BODIES = 10, MAX_N = 64 };

typedef struct twins {
    twin w[BODIES];
    int parent[BODIES];
    mbsr_model *model[MODELS];
    mbsr_data *data[MODELS];
    int nq, nu, bodies;
    double q[MAX_N], u[MAX_N], x[MAX_N];
} twins;

static void make_twin(twin *w, int kind, int particles, test_rng *rng)
{
    *w = (twin){.s = sample_make(kind, rng), .particles = particles};
    test_fill(rng, 36, w->Q0);
    test_fill(rng, 36, w->Q1);
    for (int i = 0; i < 36; ++i) {
        w->Q0[i] = 0.2 * w->Q0[i] + (i % 7 == 0 ? 1.5 : 0.0);
        w->Q1[i] *= 0.2;
    }
    for (int k = 0; k < particles; ++k) {
        w->m[k] = 1.2 + test_uniform(rng);
        test_fill(rng, 3, w->x[k]);
    }
}

static mbsr_body_def define(const twins *s, twin *w, int k, int model)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = s->parent[k];
    body.joint = w->s.joint;
    body.inertia = mbsr_inertia_zero();
    for (int l = 0; l < w->particles; ++l)
        body.inertia = mbsr_inertia_sum(body.inertia, mbsr_inertia_point_mass(w->m[l], w->x[l]));
    if (model == STOCK) return body;
    const int n = w->s.joint.n, nq = w->s.joint.nq;
    body.joint = mbsr_joint_custom(nq == n ? &plain_table : &ball_table, 6, n, w);
    body.joint.np = MBSR_POSE_SIZE;
    body.joint.nq = nq;
    if (model == OWN) body.joint.space = MBSR_SPACE_SPATIAL;
    if (model == GENERAL) body.inertia = mbsr_inertia_function(inertia, w);
    return body;
}

/* The models and a state, from bodies and parents. */
static void finish_twins(twins *s, bool moving_root, test_rng *rng)
{
    s->nq = s->nu = 0;
    for (int k = 0; k < s->bodies; ++k) s->nq += s->w[k].s.joint.nq, s->nu += s->w[k].s.joint.n;
    for (int g = 0; g < MODELS; ++g) {
        mbsr_model_def def = mbsr_default_model_def();
        if (moving_root) {
            def.root = mbsr_root_moving(g == GENERAL ? MBSR_SPACE_GENERAL : MBSR_SPACE_SPATIAL, 6,
                                        MBSR_POSE_SIZE, sample_root, NULL);
        }
        assert_ok(mbsr_model_create(&def, &s->model[g], NULL), NULL);
        for (int k = 0; k < s->bodies; ++k) {
            const mbsr_body_def body = define(s, s->w + k, k, g);
            assert_ok(mbsr_model_add_body(s->model[g], &body, NULL), mbsr_model_error(s->model[g]));
            for (int c = 0; c < body.joint.n && body.joint.n == body.joint.nq; ++c) {
                const mbsr_force_def spring = mbsr_force_joint_spring(k, c, 3.0 + c, 0.5, 0.1);
                assert_ok(mbsr_model_add_force(s->model[g], &spring, NULL),
                          mbsr_model_error(s->model[g]));
            }
        }
        assert_ok(mbsr_model_finish(s->model[g]), mbsr_model_error(s->model[g]));
        assert_ok(mbsr_data_create(s->model[g], &s->data[g], NULL), NULL);
        assert_int_equal(mbsr_model_nq(s->model[g]), s->nq);
        assert_int_equal(mbsr_model_nu(s->model[g]), s->nu);
    }
    assert_true(s->nq <= MAX_N);
    test_fill(rng, s->nq, s->q);
    test_fill(rng, s->nu, s->u);
    test_fill(rng, s->nu, s->x);
}

/* `least`: particles of a body, up to four. */
static void make_twins(twins *s, uint64_t seed, int least, bool moving_root)
{
    test_rng rng = test_seed(seed);
    s->bodies = test_integer(&rng, 5, BODIES);
    for (int k = 0; k < s->bodies; ++k) {
        s->parent[k] = test_integer(&rng, k > 3 ? k - 3 : -1, k - 1);
        make_twin(s->w + k, test_integer(&rng, 0, SAMPLE_JOINTS - 1), test_integer(&rng, least, 4),
                  &rng);
    }
    finish_twins(s, moving_root, &rng);
}

static void drop_twins(twins *s)
{
    for (int g = 0; g < MODELS; ++g) {
        mbsr_data_destroy(s->data[g]);
        mbsr_model_destroy(s->model[g]);
    }
}

/* The twins' results against the stock joints', compared with the largest number. */
static void assert_twins(int n, double result[MODELS][3 * MAX_N], double tolerance)
{
    const double size = 1.0 + test_largest(n, result[STOCK]);
    for (int g = OWN; g < MODELS; ++g) {
        for (int k = 0; k < n; ++k) assert_close(result[g][k], result[STOCK][k], tolerance * size);
    }
}

static const double now = 0.4;

static void bodies_masses_and_forces_are_the_same(void **state)
{
    (void)state;
    static double mass[MODELS][MAX_N * MAX_N];
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        twins s;
        double result[MODELS][3 * MAX_N];
        make_twins(&s, seed, 0, seed % 2 == 0);
        for (int g = 0; g < MODELS; ++g) {
            mbsr_data *d = s.data[g];
            assert_ok(mbsr_inverse_dynamics(s.model[g], d, now, s.q, s.u, s.x, NULL, result[g]),
                      mbsr_data_error(d));
            assert_ok(mbsr_stage_positions(s.model[g], d, now, s.q), mbsr_data_error(d));
            assert_ok(mbsr_stage_velocities(s.model[g], d, s.u), mbsr_data_error(d));
            assert_ok(mbsr_mass_matrix(s.model[g], d, mass[g]), mbsr_data_error(d));
        }
        assert_twins(s.nu, result, 1e-12);
        const double size = 1.0 + test_largest(s.nu * s.nu, mass[STOCK]);
        for (int k = 0; k < s.nu * s.nu; ++k) {
            assert_close(mass[OWN][k], mass[STOCK][k], 1e-12 * size);
            assert_close(mass[GENERAL][k], mass[STOCK][k], 1e-12 * size);
        }
        for (int k = 0; k < s.bodies; ++k) {
            for (int g = 0; g < MODELS; ++g)
                assert_ok(mbsr_body_twist(s.model[g], s.data[g], k, result[g]), NULL);
            assert_twins(6, result, 1e-12);
            for (int g = 0; g < MODELS; ++g)
                assert_ok(mbsr_body_pose(s.model[g], s.data[g], k, result[g]), NULL);
            assert_twins(MBSR_POSE_SIZE, result, 1e-13);
        }
        drop_twins(&s);
    }
}

static void forward_dynamics_is_the_same(void **state)
{
    (void)state;
    for (uint64_t seed = 101; seed <= 140; ++seed) {
        twins s;
        double udot[MODELS][3 * MAX_N];
        make_twins(&s, seed, 4, seed % 2 == 0);
        for (int g = 0; g < MODELS; ++g) {
            assert_ok(mbsr_forward_dynamics(s.model[g], s.data[g], now, s.q, s.u, s.x, udot[g]),
                      mbsr_data_error(s.data[g]));
        }
        assert_twins(s.nu, udot, 1e-11);
        drop_twins(&s);
    }
}

/* Whether joints are eliminated one by one, or as blocks, in the same way: what is welded takes
 * part in the decision. Rows of (25) are other combinations of the equations where they are not.
 * Needs mbsr_stage_backward. */
static bool eliminated_alike(const twins *s, int g)
{
    bool alike = true;
    for (int i = 0; i < s->bodies; ++i) {
        mbsr_rank_info one, other;
        assert_ok(mbsr_body_rank(s->model[STOCK], s->data[STOCK], i, &one), NULL);
        assert_ok(mbsr_body_rank(s->model[g], s->data[g], i, &other), NULL);
        assert_int_equal(one.rank, other.rank);
        alike = alike && fabs(one.scale - other.scale) <= 1e-9 * one.scale;
    }
    return alike;
}

/* At the same y, y', with masses of any rank. (In the index-1 form y has coordinates in bases of
 * which each model has its own.) Where M is a function its rate is found by differences, and
 * with it p' of the momentum form. */
static void residuals_are_the_same(void **state)
{
    (void)state;
    static const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                          MBSR_DAE_INVERSE_DYNAMICS};
    int compared = 0;
    for (uint64_t seed = 201; seed <= 240; ++seed) {
        twins s;
        make_twins(&s, seed, 0, seed % 2 == 0);
        for (int f = 0; f < 3; ++f) {
            double y[MODELS][3 * MAX_N], yp[3 * MAX_N], F[MODELS][3 * MAX_N];
            test_rng rng = test_seed(seed);
            const int size = mbsr_dae_size(s.model[STOCK], forms[f]);
            test_fill(&rng, size, yp);
            for (int g = 0; g < MODELS; ++g) {
                assert_int_equal(mbsr_dae_size(s.model[g], forms[f]), size);
                assert_ok(mbsr_dae_pack(s.model[g], s.data[g], forms[f], now, s.q, s.u, y[g]),
                          mbsr_data_error(s.data[g]));
                /* the stock joints make quaternions of length 1 of them, the twins do not */
                memcpy(y[g], y[STOCK], sizeof(double) * (size_t)s.nq);
            }
            assert_twins(size, y, 1e-12);
            for (int g = 0; g < MODELS; ++g) {
                assert_ok(
                    mbsr_dae_residual(s.model[g], s.data[g], forms[f], now, y[STOCK], yp, F[g]),
                    mbsr_data_error(s.data[g]));
            }
            const double scale = 1.0 + test_largest(size, F[STOCK]);
            for (int g = OWN; g < MODELS; ++g) {
                if (forms[f] == MBSR_DAE_RECURSIVE && !eliminated_alike(&s, g)) continue;
                ++compared;
                for (int k = 0; k < size; ++k) assert_close(F[g][k], F[STOCK][k], 1e-11 * scale);
            }
        }
        drop_twins(&s);
    }
    assert_true(compared > 180); /* of 240 */
}

/* A particle on a ball joint spins without inertia about the line between them, where the next
 * body's ball joint sits: that body must be told of the spin, though the particle has mass. */
static void a_spin_without_inertia_reaches_the_next_body(void **state)
{
    (void)state;
    test_rng rng = test_seed(300);
    twins s = {.bodies = 2, .parent = {MBSR_GROUND, 0}};
    for (int k = 0; k < 2; ++k) {
        twin *w = s.w + k;
        make_twin(w, 8, k ? 4 : 1, &rng);
        w->s.B = mbsr_frame_identity();
        w->s.A = mbsr_frame_at(0.0, 0.0, k ? -1.5 : 0.0);
        w->s.joint = mbsr_joint_spherical(&w->s.A, &w->s.B);
    }
    s.w[0].x[0][0] = s.w[0].x[0][1] = 0.0;
    finish_twins(&s, false, &rng);
    double residual[MODELS][3 * MAX_N];
    for (int g = 0; g < MODELS; ++g) {
        mbsr_rank_info info;
        assert_ok(
            mbsr_recursive_residual(s.model[g], s.data[g], now, s.q, s.u, s.x, NULL, residual[g]),
            mbsr_data_error(s.data[g]));
        assert_ok(mbsr_body_rank(s.model[g], s.data[g], 0, &info), mbsr_data_error(s.data[g]));
        assert_int_equal(info.rank, 2);
    }
    assert_twins(s.nu, residual, 1e-12);
    drop_twins(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_masses_and_forces_are_the_same),
        cmocka_unit_test(forward_dynamics_is_the_same),
        cmocka_unit_test(residuals_are_the_same),
        cmocka_unit_test(a_spin_without_inertia_reaches_the_next_body),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
