/* Massless bodies between springs and dampers: the Maxwell element, carts in series, a branch, a
 * leaf with a force, a moved root. All forms of the equations, from the library's own start,
 * against the matrix exponential or a closed form.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "cart_network.h"

enum { POINTS = 20 };

/* Exact q and u at time t. Of start->u only what the velocities of the masses need may count. */
typedef void exact_fn(const void *user, const run_state *start, double t, double *q, double *u);

static double deviation(int n, const run_state *a, const double *q, const double *u)
{
    double error = 0.0;
    for (int k = 0; k < n; ++k) {
        error = run_larger(error, fabs(a->q[k] - q[k]));
        error = run_larger(error, fabs(a->u[k] - u[k]));
    }
    return error;
}

/* Each form and tolerance within 100 tolerances of the exact motion, and the forms of each other.
 * In r->q, r->u the forces need not balance: the library must keep q and the rates
 * of the masses. */
static void check_motion(run *r, int null_directions, exact_fn *exact, const void *user)
{
    static run_state state[RUN_FORMS][POINTS + 1];
    const int n = mbsr_model_nq(r->model);
    run_state given = {.t = 0.0};
    memcpy(given.q, r->q, (size_t)n * sizeof *given.q);
    memcpy(given.u, r->u, (size_t)n * sizeof *given.u);
    r->points = POINTS;
    for (double tolerance = 1e-6; tolerance > 1e-9; tolerance *= 1e-2) {
        r->tolerance = tolerance;
        for (int f = 0; f < RUN_FORMS; ++f) {
            double q[RUN_MOST], u[RUN_MOST], error = 0.0, difference = 0.0;
            r->form = run_forms[f];
            run_integrate(r, state[f]);
            assert_int_equal(r->info.null_directions, null_directions);
            assert_int_equal(r->info.elastic, 0);
            for (int k = 0; k <= POINTS; ++k) {
                exact(user, &given, r->T * k / POINTS, q, u);
                if (k == 0) assert_close(deviation(n, state[f], q, u), 0.0, 1e-9);
                error = run_larger(error, deviation(n, state[f] + k, q, u));
                difference = run_larger(difference,
                                        deviation(n, state[f] + k, state[0][k].q, state[0][k].u));
            }
            run_report(r, error);
            assert_less(error, 100.0 * tolerance);
            assert_less(difference, 100.0 * tolerance);
        }
        run_compare(r, RUN_REPEATS);
    }
}

/* ---- networks ---- */

typedef struct network_reference {
    const cart_network *network;
    expm_system system;
} network_reference;

static void network_exact(const void *user, const run_state *start, double t, double *q, double *u)
{
    const network_reference *reference = user;
    double x[EXPM_MOST];
    cart_state(reference->network, start->q, start->u, x);
    expm_solve(&reference->system, t, x, x);
    cart_coordinates(reference->network, &reference->system, x, q, u);
}

static void check_network(cart_network *w, double T)
{
    double q[CARTS_MOST], u[CARTS_MOST];
    test_rng rng = test_seed(3);
    test_fill(&rng, CARTS_MOST, q);
    test_fill(&rng, CARTS_MOST, u);
    mbsr_model *m = cart_model(w);
    const network_reference reference = {w, cart_system(w)};
    int massless = 0;
    for (int k = 0; k < w->carts; ++k) massless += !cart_has_velocity_state(w, k);
    run r = {.name = w->name, .model = m, .T = T, .q = q, .u = u};
    check_motion(&r, massless, network_exact, &reference);
    mbsr_model_destroy(m);
}

/* A chain of massless carts with a mass at the end. */
static void carts_in_series(void **unused)
{
    (void)unused;
    cart_network two = {
        .name = "two massless carts in series",
        .carts = 3,
        .parent = {CART_GROUND, 0, 1},
        .mass = {0.0, 0.0, 1.5},
        .elements = 3,
        .element = {{0, CART_GROUND, 30.0, 2.0}, {1, 0, 5.0, 3.0}, {2, 1, 20.0, 1.0}}};
    check_network(&two, 2.0);
    cart_network five = {.name = "five massless carts in series",
                         .carts = 6,
                         .parent = {CART_GROUND, 0, 1, 2, 3, 4},
                         .mass = {0.0, 0.0, 0.0, 0.0, 0.0, 0.7},
                         .elements = 6,
                         .element = {{0, CART_GROUND, 30.0, 2.0},
                                     {1, 0, 5.0, 3.0},
                                     {2, 1, 20.0, 1.0},
                                     {3, 2, 0.0, 4.0},
                                     {4, 3, 12.0, 2.5},
                                     {5, 4, 9.0, 0.5}}};
    check_network(&five, 2.0);
}

/* The same chain, with the third cart held by a spring and damper to the ground as well. */
static void carts_in_series_with_a_force_across_the_tree(void **unused)
{
    (void)unused;
    cart_network w = {.name = "carts in series, one tied to the ground",
                      .carts = 5,
                      .parent = {CART_GROUND, 0, 1, 2, 3},
                      .mass = {0.0, 0.0, 0.0, 0.6, 0.7},
                      .elements = 6,
                      .element = {{0, CART_GROUND, 30.0, 2.0},
                                  {1, 0, 5.0, 3.0},
                                  {2, 1, 20.0, 1.0},
                                  {3, 2, 10.0, 0.0},
                                  {4, 3, 12.0, 2.0},
                                  {2, CART_GROUND, 9.0, 0.5}}};
    check_network(&w, 2.0);
}

static void massless_body_with_two_successors(void **unused)
{
    (void)unused;
    cart_network w = {
        .name = "massless body with two successors",
        .carts = 3,
        .parent = {CART_GROUND, 0, 0},
        .mass = {0.0, 1.0, 2.0},
        .elements = 3,
        .element = {{0, CART_GROUND, 30.0, 2.0}, {1, 0, 15.0, 1.0}, {2, 0, 8.0, 0.5}}};
    check_network(&w, 2.0);
}

static void massless_node_on_a_moved_body(void **unused)
{
    (void)unused;
    cart_network w = {.name = "massless node on a driven body",
                      .carts = 3,
                      .parent = {CART_GROUND, 0, 1},
                      .mass = {0.0, 0.0, 1.3},
                      .elements = 3,
                      .element = {{1, 0, 25.0, 2.0}, {2, 1, 10.0, 1.0}, {1, CART_GROUND, 3.0, 0.7}},
                      .drive = CART_DRIVEN_JOINT,
                      .amplitude = 0.3,
                      .omega = 5.0};
    check_network(&w, 2.0);
    w.name = "massless node on a moving root";
    w.drive = CART_MOVING_ROOT;
    w.elements = 2;
    check_network(&w, 2.0);
}

/* ---- closed forms ---- */

/* Spring c to the ground, node, damper d, mass m: m v' = -c x1, x1' + c x1 / d = v. */
static const double MAXWELL_C = 40.0, MAXWELL_D = 6.0, MAXWELL_M = 1.5;

static void maxwell_exact(const void *unused, const run_state *start, double t, double *q,
                          double *u)
{
    (void)unused;
    const double c = MAXWELL_C, d = MAXWELL_D, m = MAXWELL_M;
    const double v0 = start->u[0] + start->u[1], decay = c / (2.0 * d),
                 omega = sqrt(c / m - decay * decay);
    const double A = start->q[0], rate0 = v0 - c * A / d, B = (rate0 + decay * A) / omega;
    const double e = exp(-decay * t), C = cos(omega * t), S = sin(omega * t);
    q[0] = e * (A * C + B * S);
    u[0] = -decay * q[0] + omega * e * (B * C - A * S);
    u[1] = c * q[0] / d;
    const double v = u[0] + u[1];
    q[1] = start->q[1] - m / d * (v - v0); /* d q2' = c x1 = -m v' */
}

static void maxwell_element(void **unused)
{
    (void)unused;
    const double q[2] = {0.2, 0.5}, u[2] = {1.0, -0.4};
    mbsr_model *m = run_model();
    const int node = run_cart(m, "node", MBSR_GROUND, 0.0),
              mass = run_cart(m, "mass", node, MAXWELL_M);
    run_force(m, mbsr_force_axis_spring(node, MBSR_GROUND, 0, MAXWELL_C, 0.0, 0.0));
    run_force(m, mbsr_force_axis_spring(mass, node, 0, 0.0, MAXWELL_D, 0.0));
    run_finish(m);
    run r = {.name = "Maxwell element", .model = m, .T = 2.0, .q = q, .u = u};
    check_motion(&r, 1, maxwell_exact, NULL);
    mbsr_model_destroy(m);
}

/* A mass m on a spring c0, a massless leaf on it with spring c and damper d, F sin(omega t) on the
 * leaf: c e + d e' = F sin(omega t), m x'' + c0 x = F sin(omega t). */
static const double LEAF_M = 2.0, LEAF_C0 = 18.0, LEAF_C = 8.0, LEAF_D = 3.0, LEAF_F = 4.0,
                    LEAF_OMEGA = 5.0;

static int leaf_force(void *unused, double t, int n, double *value)
{
    (void)unused;
    for (int k = 0; k < n; ++k) value[k] = k == 0 ? LEAF_F * sin(LEAF_OMEGA * t) : 0.0;
    return MBSR_OK;
}

static void leaf_exact(const void *unused, const run_state *start, double t, double *q, double *u)
{
    (void)unused;
    const double w = LEAF_OMEGA, own = sqrt(LEAF_C0 / LEAF_M), lambda = LEAF_C / LEAF_D;
    const double P = LEAF_F / (LEAF_C0 - LEAF_M * w * w);
    const double A = start->q[0], B = (start->u[0] - P * w) / own;
    q[0] = A * cos(own * t) + B * sin(own * t) + P * sin(w * t);
    u[0] = own * (B * cos(own * t) - A * sin(own * t)) + P * w * cos(w * t);
    const double scale = LEAF_F / (LEAF_C * LEAF_C + LEAF_D * LEAF_D * w * w);
    const double E = start->q[1] + scale * LEAF_D * w;
    q[1] = E * exp(-lambda * t) + scale * (LEAF_C * sin(w * t) - LEAF_D * w * cos(w * t));
    u[1] = -lambda * E * exp(-lambda * t) +
           scale * w * (LEAF_C * cos(w * t) + LEAF_D * w * sin(w * t));
}

static void massless_leaf_with_a_force(void **unused)
{
    (void)unused;
    const double q[2] = {0.2, 0.5}, u[2] = {1.0, -0.4};
    mbsr_model *m = run_model();
    const int mass = run_cart(m, "mass", MBSR_GROUND, LEAF_M),
              leaf = run_cart(m, "leaf", mass, 0.0);
    run_force(m, mbsr_force_axis_spring(mass, MBSR_GROUND, 0, LEAF_C0, 0.0, 0.0));
    run_force(m, mbsr_force_axis_spring(leaf, mass, 0, LEAF_C, LEAF_D, 0.0));
    run_force(m, mbsr_force_applied(leaf, leaf_force, NULL));
    run_finish(m);
    run r = {.name = "massless leaf with a force", .model = m, .T = 2.0, .q = q, .u = u};
    check_motion(&r, 1, leaf_exact, NULL);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maxwell_element),
        cmocka_unit_test(carts_in_series),
        cmocka_unit_test(carts_in_series_with_a_force_across_the_tree),
        cmocka_unit_test(massless_body_with_two_successors),
        cmocka_unit_test(massless_leaf_with_a_force),
        cmocka_unit_test(massless_node_on_a_moved_body),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
