/* The O(N) Newton solver where it cannot go on: singular and nearly singular systems, callbacks
 * that fail or write what is not finite. Each time the object serves on.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton_system.h"

#include <stdbool.h>
#include <stdlib.h>

enum { MOST = 64, MOST_BODIES = 5, MOST_FORCES = 8 };

/* What a model is made of, and a solver at a state y, y' = 0. */
typedef struct scene {
    int bodies, forces;
    mbsr_body_def body[MOST_BODIES];
    mbsr_force_def force[MOST_FORCES];
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    int n;
    double y[MOST], yp[MOST], r[MOST], delta[MOST];
} scene;

static int add_body(scene *s, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def *b = s->body + s->bodies;
    *b = mbsr_default_body_def();
    b->name = name;
    b->parent = parent;
    b->joint = joint;
    b->inertia = inertia;
    return s->bodies++;
}

static void add_force(scene *s, mbsr_force_def def)
{
    s->force[s->forces++] = def;
}

static void open_scene(scene *s)
{
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int k = 0; k < s->bodies; ++k)
        assert_ok(mbsr_model_add_body(s->model, s->body + k, NULL), mbsr_model_error(s->model));
    for (int k = 0; k < s->forces; ++k)
        assert_ok(mbsr_model_add_force(s->model, s->force + k, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &s->newton, &error), &error);
    s->n = mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
    assert_in_range(s->n, 1, MOST);
    test_rng rng = test_seed(3);
    test_fill(&rng, s->n, s->r);
}

static void close_scene(scene *s)
{
    mbsr_newton_destroy(s->newton);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static int factor(scene *s, double t, double c)
{
    return mbsr_newton_factor(s->newton, s->data, t, s->y, s->yp, c);
}

/* Factoring is refused so, and there is nothing to solve with. */
static void expect_refusal(scene *s, double t, double c, int status, int body, int force,
                           const char *words)
{
    double held[MOST];
    memcpy(held, s->delta, sizeof held);
    assert_refused(factor(s, t, c), mbsr_newton_error(s->newton), status, body, force, words);
    assert_int_equal(mbsr_newton_solve(s->newton, s->r, s->delta), MBSR_ERR_SEQUENCE);
    assert_memory_equal(held, s->delta, sizeof held);
}

/* It works, and as well as another solver. */
static void expect_service(scene *s, double t, double c)
{
    double expected[MOST];
    mbsr_newton *fresh;
    mbsr_error error;
    assert_ok(factor(s, t, c), mbsr_newton_error(s->newton));
    assert_ok(mbsr_newton_solve(s->newton, s->r, s->delta), mbsr_newton_error(s->newton));
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &fresh, &error), &error);
    assert_ok(mbsr_newton_factor(fresh, s->data, t, s->y, s->yp, c), mbsr_newton_error(fresh));
    assert_ok(mbsr_newton_solve(fresh, s->r, expected), mbsr_newton_error(fresh));
    assert_memory_equal(s->delta, expected, (size_t)s->n * sizeof(double));
    mbsr_newton_destroy(fresh);
}

/* ---- nothing determines a motion ---- */

/* A point without mass that may move in x and y, named "bead". */
static int add_bead(scene *s)
{
    return add_body(s, "bead", MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_zero());
}

static void a_body_without_mass_and_force(void **state)
{
    (void)state;
    scene s = {0};
    add_bead(&s);
    open_scene(&s);
    expect_refusal(&s, 0.0, 10.0, MBSR_SINGULAR_BLOCK, 0, MBSR_NONE, "bead|singular");
    assert_true(MBSR_SINGULAR_BLOCK > 0);
    close_scene(&s);
}

static void a_force_in_one_direction_only(void **state)
{
    (void)state;
    scene s = {0};
    add_body(&s, "cart", MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_particle(2.0));
    const int bead = add_body(&s, "bead", 0, mbsr_joint_point_free(), mbsr_inertia_zero());
    add_force(&s, mbsr_force_axis_spring(bead, MBSR_GROUND, 0, 100.0, 5.0, 0.0));
    open_scene(&s);
    expect_refusal(&s, 0.0, 10.0, MBSR_SINGULAR_BLOCK, bead, MBSR_NONE, "bead|singular");
    close_scene(&s);
}

static void a_cable_that_becomes_slack(void **state)
{
    (void)state;
    scene s = {0};
    const mbsr_spring cable = {
        .stiffness = 50.0, .damping = 1.0, .free_length = 1.0, .one_sided = 1};
    const double left[3] = {-2.0, 0.0, 0.0}, below[3] = {-2.0, -0.8, 0.0};
    const int bead = add_bead(&s);
    add_force(&s, mbsr_force_spring(bead, NULL, MBSR_GROUND, left, &cable));
    add_force(&s, mbsr_force_spring(bead, NULL, MBSR_GROUND, below, &cable));
    open_scene(&s);
    expect_service(&s, 0.0, 10.0);
    s.y[0] = -1.7; /* one hangs loose, but the other holds in its direction and across it */
    s.y[1] = 0.6;
    expect_service(&s, 0.0, 10.0);
    s.y[1] = -0.2; /* both */
    expect_refusal(&s, 0.0, 10.0, MBSR_SINGULAR_BLOCK, bead, MBSR_NONE, "bead|singular");
    s.y[0] = 0.0;
    expect_service(&s, 0.0, 20.0);
    close_scene(&s);
}

/* ---- nearly singular ---- */

/* A bead with dampers along x and along y, one `ratio` times as strong as the other, in joint
 * coordinates that are turned by 0.7 rad. */
static void open_lame(scene *s, double ratio)
{
    *s = (scene){0};
    add_body(s, "cart", MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_particle(2.0));
    const int bead = add_body(
        s, "bead", 0,
        mbsr_joint_point((mbsr_planar_frame){0.1, 0.2, 0.7}, MBSR_X | MBSR_Y, 0, NULL, NULL),
        mbsr_inertia_zero());
    add_force(s, mbsr_force_axis_spring(bead, MBSR_GROUND, 0, 0.0, 3.0, 0.0));
    add_force(s, mbsr_force_axis_spring(bead, MBSR_GROUND, 1, 0.0, 3.0 * ratio, 0.0));
    open_scene(s);
}

static void damping_far_below_its_neighbour(void **state)
{
    (void)state;
    scene s;
    for (double ratio = 1e-18; ratio < 1e-15; ratio *= 10.0) {
        open_lame(&s, ratio);
        expect_refusal(&s, 0.0, 10.0, MBSR_SINGULAR_BLOCK, 1, MBSR_NONE, "bead|singular");
        close_scene(&s);
    }
    /* Rather less remains to be solved for, as well as the ratio allows. The rates of the bead in
     * the world, by hand: 3 (dx', ratio dy') with r_u turned. */
    for (double ratio = 1e-12; ratio < 1.0; ratio *= 10.0) {
        open_lame(&s, ratio);
        assert_ok(factor(&s, 0.0, 10.0), mbsr_newton_error(s.newton));
        memset(s.r, 0, sizeof s.r);
        s.r[s.n - 2] = 1.0; /* the bead's */
        assert_ok(mbsr_newton_solve(s.newton, s.r, s.delta), mbsr_newton_error(s.newton));
        const double c = cos(0.7), w = sin(0.7), a = s.delta[s.n - 2], b = s.delta[s.n - 1],
                     x = c * a - w * b + s.delta[s.n - 4], y = w * a + c * b + s.delta[s.n - 3];
        assert_close(3.0 * x, c, 1e-12 + 1e-15 / ratio);
        assert_close(3.0 * ratio * y, w, 1e-12 + 1e-15 / ratio);
        close_scene(&s);
    }
}

/* A mass that is next to nothing, below a joint without mass, does as well as none. */
static void masses_that_are_next_to_nothing(void **state)
{
    (void)state;
    static const double masses[] = {0.0, 1e-14, 1e-50, 1e-100};
    double expected[4];
    for (int k = 0; k < 4; ++k) {
        scene s = {0};
        for (int l = 0; l < 2; ++l) {
            add_body(&s, "bead", l - 1, mbsr_joint_point_free(),
                     mbsr_inertia_particle(l * masses[k]));
            add_force(&s, mbsr_force_axis_spring(l, MBSR_GROUND, 0, 100.0, 5.0, 0.0));
            add_force(&s, mbsr_force_axis_spring(l, MBSR_GROUND, 1, 70.0, 4.0, 0.1));
        }
        open_scene(&s);
        s.y[0] = 0.3, s.y[9] = 0.4;
        for (int l = 4; l < 12; ++l)
            s.r[l] = 0.0; /* only r_q means the same with mass and without */
        expect_service(&s, 0.0, 10.0);
        for (int l = 0; l < 4; ++l) {
            if (k == 0) expected[l] = s.delta[8 + l];
            assert_close(s.delta[8 + l], expected[l], k == 0 ? 0.0 : 1e-9);
        }
        close_scene(&s);
    }
}

/* ---- elements across the tree ---- */

/* -(sum of the V of both bodies) on each of them along x; param[0]: of the other body. */
static int push_both(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    const double other = args->force->param[0];
    b[0].f[0] -= b[0].V[0] + other * b[1].V[0];
    b[1].f[0] -= b[1].V[0] + other * b[0].V[0];
    return 0;
}

static const mbsr_force_table push_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "push both", .evaluate = push_both};

static void an_element_across_the_tree(void **state)
{
    (void)state;
    /* in r_u the whole is ((1, a), (a, 1)) */
    static const double shares[] = {1.0, -1.0, 1.0 + 1e-15, 0.5, 1.0 - 1e-10};
    for (int k = 0; k < 5; ++k) {
        scene s = {0};
        const mbsr_planar_frame at = {0.0, 0.0, 0.0};
        int pair[2];
        for (int l = 0; l < 2; ++l)
            pair[l] = add_body(&s, l ? "right" : "left", MBSR_GROUND,
                               mbsr_joint_point(at, MBSR_X, 0, NULL, NULL), mbsr_inertia_zero());
        mbsr_force_def push = mbsr_force_custom(&push_table, 2, pair, NULL);
        push.param[0] = shares[k];
        add_force(&s, mbsr_force_gravity(0.0, -1.0, 0.0));
        add_force(&s, push);
        open_scene(&s);
        if (k < 3) {
            expect_refusal(&s, 0.0, 10.0, MBSR_SINGULAR_BLOCK, MBSR_NONE, 1,
                           "across the tree|singular");
        } else {
            expect_service(&s, 0.0, 10.0);
            const double a = s.delta[4] + shares[k] * s.delta[5],
                         b = shares[k] * s.delta[4] + s.delta[5];
            assert_close(fabs(a), fabs(s.r[4]), 1e-5);
            assert_close(fabs(b), fabs(s.r[5]), 1e-5);
        }
        close_scene(&s);
    }
}

/* What a callback is to return, and to write in addition. */
typedef struct orders {
    int status;
    double bad;
} orders;

/* A joint with q' = (1 + q) u: c = u is where dq is not determined. Away from q = 0.3 its q' obeys
 * orders. */
static orders growth;

static int growing_position(const mbsr_joint_args *args, double *p)
{
    *p = log(1.0 + *args->q);
    return 0;
}

static int growing_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                             double *kI)
{
    (void)args, (void)K, (void)H, (void)kI;
    *J = -1.0;
    return 0;
}

static int growing_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static int growing_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)args, (void)Kdot, (void)Hdot, (void)Jdot;
    return 0;
}

static int growing_coordinates(const mbsr_joint_args *args, double *qdot)
{
    const bool away = *args->q != 0.3;
    *qdot = (1.0 + *args->q) * *args->u + (away ? growth.bad : 0.0);
    return away ? growth.status : 0;
}

static const mbsr_joint_table growing = {.version = MBSR_JOINT_TABLE_VERSION,
                                         .flags = MBSR_JOINT_UNIT_K,
                                         .name = "growing",
                                         .position = growing_position,
                                         .jacobians = growing_jacobians,
                                         .bias = growing_bias,
                                         .rates = growing_rates,
                                         .coordinate_rates = growing_coordinates};

static void a_coordinate_that_grows_at_the_rate_c(void **state)
{
    (void)state;
    static const double mass = 2.0;
    scene s = {0};
    add_body(&s, "yeast", MBSR_GROUND, mbsr_joint_custom(&growing, 1, 1, NULL),
             mbsr_inertia_matrix(1, &mass));
    open_scene(&s);
    s.y[0] = 0.3, s.y[2] = 2.0;
    expect_refusal(&s, 0.0, 2.0, MBSR_SINGULAR_BLOCK, 0, MBSR_NONE, "yeast|growing|q'");
    expect_service(&s, 0.0, 2.5);
    /* c dq - u dq - (1 + q) du = r_q */
    assert_close(0.5 * s.delta[0] - 1.3 * s.delta[2], s.r[0], 1e-9);
    growth.bad = NAN;
    expect_refusal(&s, 0.0, 2.5, MBSR_NOT_FINITE, 0, MBSR_NONE, "yeast|growing");
    growth = (orders){.status = -5};
    expect_refusal(&s, 0.0, 2.5, -5, 0, MBSR_NONE, "yeast|growing|coordinate_rates");
    growth.status = 0;
    expect_service(&s, 0.0, 2.5);
    close_scene(&s);
}

/* ---- callbacks ---- */

/* A user's joint along one axis, by way of a stock one. */
typedef enum duty { POSITION, JACOBIANS, BIAS, RATES, TANGENT, RATE_TANGENT, DUTIES } duty;

static orders ordered[DUTIES];

static int jaded_position(const mbsr_joint_args *args, double *p)
{
    p[0] = *args->q + ordered[POSITION].bad;
    return ordered[POSITION].status;
}

static int jaded_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)args, (void)K, (void)H, (void)kI;
    J[0] = -1.0 + ordered[JACOBIANS].bad;
    return ordered[JACOBIANS].status;
}

static int jaded_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args;
    kII[0] = ordered[BIAS].bad;
    return ordered[BIAS].status;
}

static int jaded_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)args, (void)Kdot, (void)Hdot;
    Jdot[0] = ordered[RATES].bad;
    return ordered[RATES].status;
}

static int jaded_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                         double *dK, double *dH, double *dJ, double *dkI)
{
    (void)args, (void)dK, (void)dH, (void)dkI;
    dp[0] = *by->q;
    dJ[0] = ordered[TANGENT].bad;
    return ordered[TANGENT].status;
}

static int jaded_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              double *dkII, double *dKdot, double *dHdot, double *dJdot,
                              double *dqdot)
{
    (void)args, (void)by, (void)dKdot, (void)dHdot, (void)dqdot, (void)dkII;
    dJdot[0] = ordered[RATE_TANGENT].bad;
    return ordered[RATE_TANGENT].status;
}

static const mbsr_joint_table jaded = {.version = MBSR_JOINT_TABLE_VERSION,
                                       .flags = MBSR_JOINT_UNIT_K,
                                       .name = "jaded",
                                       .position = jaded_position,
                                       .jacobians = jaded_jacobians,
                                       .bias = jaded_bias,
                                       .rates = jaded_rates,
                                       .tangent = jaded_tangent,
                                       .rate_tangent = jaded_rate_tangent};

static void joint_functions_that_fail(void **state)
{
    (void)state;
    static const double mass = 2.0;
    scene s = {0};
    add_body(&s, "slide", MBSR_GROUND, mbsr_joint_custom(&jaded, 1, 1, NULL),
             mbsr_inertia_matrix(1, &mass));
    add_force(&s, mbsr_force_joint_spring(0, 0, 3.0, 1.0, 0.0));
    open_scene(&s);
    s.y[0] = 0.2, s.y[1] = 0.8, s.y[2] = 0.4;
    static const char *const names[] = {"slide|position", "slide|jacobians", "slide|bias",
                                        "slide|rates",    "slide|tangent",   "slide|rate_tangent"};
    for (int k = 0; k < DUTIES; ++k) {
        ordered[k] = (orders){.status = k % 2 ? 7 + k : -7 - k};
        if (k != BIAS) /* which only deficient trees need */
            expect_refusal(&s, 0.0, 10.0, ordered[k].status, 0, MBSR_NONE, names[k]);
        ordered[k] = (orders){.bad = NAN};
        if (k != BIAS) expect_refusal(&s, 0.0, 10.0, MBSR_NOT_FINITE, 0, MBSR_NONE, "slide");
        ordered[k] = (orders){0};
        expect_service(&s, 0.0, 10.0);
    }
    close_scene(&s);
}

/* A damper on a joint, or on a body, that obeys orders; with and without derivatives. */
static orders evaluation, slopes;

static int tired_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    if (b->tau && b->n > 0) b->tau[0] -= 2.0 * b->u[0] - evaluation.bad;
    return evaluation.status;
}

static int tired_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_force_body *b = args->body;
    if (b->n > 0) out->matrix[out->rows * (out->columns - 1) + b->d] += -2.0 + slopes.bad;
    return slopes.status;
}

static void force_functions_that_fail(void **state)
{
    (void)state;
    static const unsigned flags[] = {0u, MBSR_FORCE_JOINT_ONLY, MBSR_FORCE_EVERY_BODY};
    static const double axis[3] = {0.0, 1.0, 0.0}, edges[3] = {0.2, 0.4, 1.0};
    /* joint elements are for vector code, the others read M and are not */
    for (int k = 0; k < 6; ++k) {
        const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                        .flags = flags[k / 2],
                                        .name = "tired",
                                        .evaluate = tired_evaluate,
                                        .derivatives = k % 2 ? tired_derivatives : NULL};
        static const int second = 1;
        scene s = {0};
        for (int l = 0; l < 2; ++l)
            add_body(&s, "link", l - 1, mbsr_joint_revolute(NULL, NULL, axis),
                     mbsr_inertia_box(3.0, edges));
        add_force(&s, mbsr_force_gravity(0.0, 0.0, -1.0));
        add_force(&s, mbsr_force_custom(&table, flags[k / 2] & MBSR_FORCE_EVERY_BODY ? 0 : 1,
                                        &second, NULL));
        s.force[1].name = "clerk";
        open_scene(&s);
        s.y[0] = 0.3, s.y[4] = 0.7, s.y[5] = -0.2;
        for (int l = 0; l < 2; ++l) {
            evaluation.status = l ? -9 : 9;
            if (k % 2 == 0)
                expect_refusal(&s, 0.5, 10.0, evaluation.status, MBSR_NONE, 1,
                               "clerk|tired|evaluate|0.5");
            evaluation.status = 0;
            slopes.status = l ? -8 : 8;
            if (k % 2)
                expect_refusal(&s, 0.5, 10.0, slopes.status, MBSR_NONE, 1,
                               "clerk|tired|derivatives|0.5");
            slopes.status = 0;
            evaluation.bad = slopes.bad = l ? NAN : INFINITY;
            expect_refusal(&s, 0.5, 10.0, MBSR_NOT_FINITE, MBSR_NONE, 1,
                           "clerk|tired|derivatives are not finite");
            evaluation.bad = slopes.bad = 0.0;
            expect_service(&s, 0.5, 10.0);
        }
        close_scene(&s);
    }
}

/* A mass in the plane by function of the pose, which fails away from the state only. */
static orders far_away;

static int heavy(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)V;
    const bool away = p[0] != 0.25;
    for (int k = 0; k < 3; ++k) M[4 * k] = 2.0 + p[0];
    h[0] = away ? far_away.bad : 0.0;
    return away ? far_away.status : 0;
}

static void inertias_that_fail(void **state)
{
    (void)state;
    scene s = {0};
    add_body(&s, "cloud", MBSR_GROUND,
             mbsr_joint_planar_free((mbsr_planar_frame){0.0, 0.0, 0.0},
                                    (mbsr_planar_frame){0.0, 0.0, 0.0}),
             mbsr_inertia_function(heavy, NULL));
    open_scene(&s);
    s.y[0] = 0.25;
    far_away.status = 6;
    expect_refusal(&s, 0.0, 10.0, 6, 0, MBSR_NONE, "cloud");
    far_away.status = 0;
    far_away.bad = NAN;
    expect_refusal(&s, 0.0, 10.0, MBSR_NOT_FINITE, 0, MBSR_NONE, "cloud");
    far_away.bad = 0.0;
    expect_service(&s, 0.0, 10.0);
    close_scene(&s);
}

/* ---- ends of the range of numbers ---- */

static void factors_of_any_size(void **state)
{
    (void)state;
    static const double axis[3] = {0.0, 1.0, 0.0}, edges[3] = {0.2, 0.4, 1.0};
    static const double c[] = {1e-12, 1e12, -1e12, 1e290, -1e290, 1e-290, 1e308};
    for (int blocks = 0; blocks < 2; ++blocks) {
        scene s = {0};
        for (int l = 0; l < 2; ++l)
            add_body(&s, "link", l - 1, mbsr_joint_revolute(NULL, NULL, axis),
                     mbsr_inertia_box(3.0, edges));
        add_force(&s, mbsr_force_joint_spring(0, 0, 4.0, 0.3, 0.0));
        if (blocks)
            add_body(&s, "bead", MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_particle(1.0));
        open_scene(&s);
        for (int k = 0; k < 7; ++k) {
            /* a solution or a refusal, and no NaN */
            const int status = factor(&s, 0.0, c[k]);
            assert_true(status == MBSR_OK || (k > 2 && status > 1000));
            if (status == MBSR_OK && mbsr_newton_solve(s.newton, s.r, s.delta) == MBSR_OK)
                assert_true(isfinite(test_largest(s.n, s.delta)));
            else
                assert_true(k > 2);
        }
        expect_service(&s, 0.0, 3.0);
        close_scene(&s);
    }
}

/* A crank in line with the rod that ties it to the ground, wherever these stand: of what the rod
 * reads rounding is left, in any units. */
static void a_crank_at_dead_centre(void **state)
{
    (void)state;
    static const double units[] = {1.0, 1e3, 1e-3}, z[3] = {0.0, 0.0, 1.0};
    for (int k = 0; k < 24; ++k) {
        const double unit = units[k % 3], along = 0.3 + 0.7 * k, arm[3] = {unit, 0.0, 0.0},
                     com[3] = {0.4 * unit, 0.0, 0.0}, about[3] = {0.6, 0.8, 0.0},
                     I = 0.2 * unit * unit, moments[6] = {I, I, I};
        mbsr_frame frame = mbsr_frame_rotated(NULL, about, 0.2 + 0.9 * k), end;
        end = mbsr_frame_rotated(NULL, z, along);
        end = mbsr_frame_product(&frame, &end);
        const double ground[3] = {2.2 * unit * end.R[0], 2.2 * unit * end.R[1],
                                  2.2 * unit * end.R[2]};
        const mbsr_closure_def rod = mbsr_closure_distance(0, arm, MBSR_GROUND, ground, 1.2 * unit);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_revolute(&frame, NULL, z);
        body.inertia = mbsr_inertia_rigid(2.0, com, moments);
        mbsr_model *m;
        mbsr_data *d;
        mbsr_newton *newton;
        const double y[5] = {along}, yp[5] = {0.0};
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 5);
        assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), NULL);
        for (double c = 1e-2; c < 1e10; c *= 1e3)
            assert_refused(mbsr_newton_factor(newton, d, 0.0, y, yp, c), mbsr_newton_error(newton),
                           MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE, "length|depends on other");
        mbsr_newton_destroy(newton);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_body_without_mass_and_force),
        cmocka_unit_test(a_force_in_one_direction_only),
        cmocka_unit_test(a_cable_that_becomes_slack),
        cmocka_unit_test(damping_far_below_its_neighbour),
        cmocka_unit_test(masses_that_are_next_to_nothing),
        cmocka_unit_test(an_element_across_the_tree),
        cmocka_unit_test(a_coordinate_that_grows_at_the_rate_c),
        cmocka_unit_test(joint_functions_that_fail),
        cmocka_unit_test(force_functions_that_fail),
        cmocka_unit_test(inertias_that_fail),
        cmocka_unit_test(factors_of_any_size),
        cmocka_unit_test(a_crank_at_dead_centre),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
