/* Joints of a user's own between bodies in space, which the vectorised sweeps take as theirs where
 * H is a translation: which are taken, and that evaluations agree with the stages.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "kernels.h"

#include "assembly/data.h"
#include "model/query.h"

#include <math.h>
#include <stdlib.h>

enum { BODIES = 8 };

/* ---- joints made of stock ones ---- */

typedef enum how {
    PLAIN,      /* as the stock joint */
    BARE,       /* without rates */
    SCALED,     /* all of K, H, J, kI, kII multiplied by a number that moves with q */
    STABILISED, /* it does not turn with its predecessor */
    SWITCHING,  /* nor this one where q > 1 */
    HOWS
} how;

static const mbsr_joint_table *stock[BODIES];
static mbsr_joint_table table[BODIES];
static how made[BODIES];

static int number_of(const mbsr_joint_args *args)
{
    return *(const int *)args->user;
}

static double factor(const mbsr_joint_args *args)
{
    return made[number_of(args)] == SCALED ? 1.5 + sin(args->q[0]) : 1.0;
}

static int position(const mbsr_joint_args *args, double *p)
{
    return stock[number_of(args)]->position(args, p);
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    const int i = number_of(args), d_pred = args->pred_d;
    const double c = factor(args);
    const int status = stock[i]->jacobians(args, NULL, H, J, kI);
    const bool still = made[i] == STABILISED || (made[i] == SWITCHING && args->q[0] > 1.0);
    for (int k = 0; k < 3 * d_pred && still; ++k) H[6 * (k / 3) + k % 3] = 0.0;
    for (int k = 0; k < 36 && K; ++k) K[k] = k % 7 == 0 ? c : 0.0;
    for (int k = 0; k < 6 * d_pred; ++k) H[k] *= c;
    for (int k = 0; k < 6 * args->n; ++k) J[k] *= c;
    for (int k = 0; k < 6; ++k) kI[k] *= c;
    return status;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    const int status = stock[number_of(args)]->bias(args, kII);
    for (int k = 0; k < 6; ++k) kII[k] *= factor(args);
    return status;
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)Kdot;
    return stock[number_of(args)]->rates(args, NULL, Hdot, Jdot);
}

static mbsr_joint of_user(int i, how h, mbsr_joint joint)
{
    static const int number[BODIES] = {0, 1, 2, 3, 4, 5, 6, 7};
    stock[i] = joint.table;
    made[i] = h;
    table[i] = (mbsr_joint_table){.version = MBSR_JOINT_TABLE_VERSION,
                                  .flags = h == SCALED ? 0 : MBSR_JOINT_UNIT_K,
                                  .name = "of a user",
                                  .position = position,
                                  .jacobians = jacobians,
                                  .bias = bias,
                                  .rates = h == PLAIN ? rates : NULL,
                                  .coordinate_rates = joint.table->coordinate_rates,
                                  .normalise = joint.table->normalise};
    joint.table = table + i;
    joint.user = (void *)(uintptr_t)(number + i);
    return joint;
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    s[0] = 0.3 * sin(t), sdot[0] = 0.3 * cos(t), sddot[0] = -0.3 * sin(t);
    return 0;
}

/* ---- models ---- */

static const double x_axis[3] = {1, 0, 0}, slant[3] = {0.6, 0.0, 0.8};

static mbsr_frame seat(int i)
{
    const double x[3] = {0.3, 0.1 * i, -0.2};
    return mbsr_frame_rotated(x, slant, 0.2 * i);
}

/* A motion of the root in every direction. */
static int shake(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const mbsr_frame frame =
        mbsr_frame_rotated((double[3]){sin(t), 2.0, -t}, slant, 0.5 * t * t + 0.2);
    for (int k = 0; k < 9; ++k) p[MBSR_POSE_R + k] = frame.R[k];
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = frame.x[k];
        V[k] = t * slant[k], A[k] = slant[k];
    }
    V[3] = cos(t), V[5] = -1.0, A[3] = -sin(t);
    return 0;
}

static mbsr_model *start(bool moving)
{
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m;
    if (moving) def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, shake, NULL);
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    const mbsr_force_def weight = mbsr_force_gravity(0.5, -2.0, -9.0);
    assert_ok(mbsr_model_add_force(m, &weight, NULL), mbsr_model_error(m));
    return m;
}

static void add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
}

static mbsr_inertia brick(int i)
{
    const double com[3] = {0.1, 0.05 * i, 0.2}, edges[3] = {0.2, 0.3, 0.1 + 0.05 * i};
    const mbsr_frame at = mbsr_frame_rotated(com, x_axis, 0.3);
    return mbsr_inertia_in_frame(&at, mbsr_inertia_box(100.0, edges));
}

/* A tree in which body `i` has a joint of each kind in turn, between stock joints; the elements act
 * on bodies of both sorts. */
static mbsr_model *make(how h, bool moving, bool loaded)
{
    mbsr_model *m = start(moving);
    for (int i = 0; i < BODIES; ++i) {
        const mbsr_frame A = seat(i);
        const mbsr_axis axes[] = {
            {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.6, 0.8}, .driven = 1},
            {.kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}}};
        mbsr_joint joint = i % 4 == 0   ? mbsr_joint_revolute(&A, NULL, slant)
                           : i % 4 == 1 ? mbsr_joint_spherical(&A, NULL)
                           : i % 4 == 2 ? mbsr_joint_universal(&A, NULL, x_axis, slant)
                                        : mbsr_joint_compound(&A, NULL, 2, axes, drive, NULL);
        if (i != 1 && i != 7) joint = of_user(i, i == 5 ? PLAIN : h, joint);
        add(m, i == 0 ? MBSR_GROUND : i == 6 ? 3 : i - 1, joint, brick(i));
    }
    if (loaded) {
        const mbsr_force_def spring = mbsr_force_point_spring(2, x_axis, 6, slant, 30.0, 2.0, 0.5);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* ---- evaluations ---- */

typedef struct state {
    double t, q[64], u[64], tau[64], yp[192], y[192];
} state;

static state random_state(const mbsr_model *m, mbsr_data *d, test_rng *rng, double reach)
{
    state s = {.t = 0.7};
    test_fill(rng, m->nq, s.q);
    for (int k = 0; k < m->nq; ++k) s.q[k] *= reach;
    test_fill(rng, m->nu, s.u);
    test_fill(rng, m->nu, s.tau);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, s.t, s.q, s.u, s.y), mbsr_data_error(d));
    test_fill(rng, m->nq + 2 * m->nu, s.yp);
    for (int k = m->nq; k < m->nq + m->nu; ++k) s.y[k] += 0.1 * test_uniform(rng);
    return s;
}

enum { FORWARD, INVERSE, MOMENTUM, EVALUATIONS };

static int evaluate(int what, const mbsr_model *m, mbsr_data *d, const state *s, double *x)
{
    switch (what) {
    case FORWARD: return mbsr_forward_dynamics(m, d, s->t, s->q, s->u, s->tau, x);
    case INVERSE: return mbsr_inverse_dynamics(m, d, s->t, s->q, s->u, s->tau, NULL, x);
    default: return mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, s->t, s->y, s->yp, x);
    }
}

static int evaluate_by_sweeps(int what, const mbsr_model *m, mbsr_data *d, const state *s,
                              double *x)
{
    switch (what) {
    case FORWARD: return mbsri_sweeps_forward_dynamics(m, d, s->t, s->q, s->u, s->tau, x);
    case INVERSE: return mbsri_sweeps_inverse_dynamics(m, d, s->t, s->q, s->u, s->tau, x);
    default: return mbsri_sweeps_momentum_residual(m, d, s->t, s->y, s->yp, x);
    }
}

/* At a state, every evaluation by the sweeps, for every processor, against the stages; served: what
 * the sweeps are to say. */
static void compare(mbsr_model *m, mbsr_data *d, const state *s, bool served)
{
    const mbsri_sweep_kernels *list[2];
    const double exact[EVALUATIONS] = {1e-10, 1e-12, 1e-10};
    double x[192], expected[192];
    for (int what = 0; what < EVALUATIONS; ++what) {
        const int length = what == MOMENTUM ? m->nq + 2 * m->nu : m->nu;
        const test_hidden trees = test_hide_sweeps(m);
        assert_ok(evaluate(what, m, d, s, expected), mbsr_data_error(d));
        test_show_sweeps(m, trees);
        for (int k = 0; k < test_kernels(list); ++k) {
            test_use_kernels(m, list[k]);
            mbsri_data_poison(d);
            assert_int_equal(evaluate_by_sweeps(what, m, d, s, x),
                             served ? MBSR_OK : MBSRI_NOT_SERVED);
            if (!served) assert_ok(evaluate(what, m, d, s, x), mbsr_data_error(d));
            assert_less(test_relative_distance(length, x, expected), exact[what]);
        }
    }
}

static void evaluations_are_those_of_the_stages(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(11);
    for (int k = 0; k < 4 * HOWS; ++k) {
        const how h = (how)(k / 4);
        mbsr_model *m = make(h, k % 2 > 0, k / 2 % 2 > 0);
        mbsr_data *d;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        /* of platforms, that on a root at rest; dividing by K leaves rounding errors in H */
        const int users = h == SCALED ? 1 : h == STABILISED ? 2 - k % 2 : 6;
        assert_int_equal(m->tree.evaluated->users, users);
        assert_int_equal(m->tree.evaluated->blocks, 6 - users);
        for (int l = 0; l < 3; ++l) {
            const state s = random_state(m, d, &rng, h == SWITCHING ? 0.4 : 1.0);
            compare(m, d, &s, true);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* A joint that stops being such a one sends that evaluation to the stages. */
static void a_joint_that_changes_its_kind(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(12);
    mbsr_model *m = make(SWITCHING, true, true);
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(m->tree.evaluated->users, 6);
    state s = random_state(m, d, &rng, 0.4);
    compare(m, d, &s, true);
    int place;
    assert_ok(mbsr_body_coordinates(m, 4, &place, NULL, NULL, NULL), NULL);
    s.q[place] = s.y[place] = 1.2;
    compare(m, d, &s, false);
    s.q[place] = s.y[place] = 0.2;
    compare(m, d, &s, true);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A hinge that moves nothing is left to the steps that find its rank. */
static void joints_without_inertia(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(13);
    mbsr_model *m = start(false);
    mbsr_data *d;
    const mbsr_frame A = seat(1);
    add(m, MBSR_GROUND, of_user(0, PLAIN, mbsr_joint_revolute(&A, NULL, slant)), brick(0));
    add(m, 0, of_user(1, PLAIN, mbsr_joint_revolute(&A, NULL, slant)), mbsr_inertia_zero());
    add(m, 0, of_user(2, PLAIN, mbsr_joint_revolute(&A, NULL, x_axis)), brick(2));
    const mbsr_force_def damper = mbsr_force_joint_spring(1, 0, 0.0, 5.0, 0.0);
    assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(m->tree.evaluated->users, 2);
    assert_int_equal(m->tree.evaluated->blocks, 1);
    const state s = random_state(m, d, &rng, 1.0);
    double x[192], expected[192];
    const test_hidden trees = test_hide_sweeps(m);
    assert_ok(evaluate(MOMENTUM, m, d, &s, expected), mbsr_data_error(d));
    test_show_sweeps(m, trees);
    assert_int_equal(evaluate_by_sweeps(MOMENTUM, m, d, &s, x), MBSR_OK);
    assert_less(test_relative_distance(m->nq + 2 * m->nu, x, expected), 1e-10);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(evaluations_are_those_of_the_stages),
                                       cmocka_unit_test(a_joint_that_changes_its_kind),
                                       cmocka_unit_test(joints_without_inertia)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
