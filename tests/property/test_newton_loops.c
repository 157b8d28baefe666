/* The O(N) Newton solver on random trees with random loops, against the dense Newton matrix by
 * differences of the residual.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "loops.h"
#include "own_closure.h"
#include "newton_system.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { BODIES = 9 };

/* ---- random mechanisms ----
 *
 * A tree is made twice: without closures, to see where its bodies are, and then with closures that
 * fit. */
typedef struct choice {
    uint64_t seed;
    int bodies, closures;
    double massless; /* share of bodies without mass */
    int kind;        /* of closures, -1: random */
    int twice;       /* closures added again, being redundant then */
    int bushings;    /* between bodies, neighbours or not */
    int plane;
} choice;

static double share(test_rng *rng)
{
    return 0.5 * (test_uniform(rng) + 1.0);
}

static mbsr_joint random_joint(test_rng *rng, int plane)
{
    double x[3], y[3], p[3];
    test_fill(rng, 3, x);
    test_fill(rng, 3, y);
    test_fill(rng, 3, p);
    const mbsr_frame A = mbsr_frame_rotated(p, y, 1.0);
    const mbsr_planar_frame flat = {p[0], p[1], y[0]}, none = {0.0, 0.0, 0.0};
    const int kind = test_integer(rng, 0, plane ? 3 : 6);
    if (plane) {
        return kind < 2    ? mbsr_joint_planar_revolute(flat, none)
               : kind == 2 ? mbsr_joint_planar_pin_slot(flat, none)
                           : mbsr_joint_planar_prismatic(flat, none);
    }
    switch (kind) {
    case 0: return mbsr_joint_revolute(&A, NULL, x);
    case 1: return mbsr_joint_cylindrical(&A, NULL, x);
    case 2: return mbsr_joint_universal(&A, NULL, x, y);
    case 3: return mbsr_joint_spherical(&A, NULL);
    case 4: return mbsr_joint_prismatic(&A, NULL, x);
    case 5: return mbsr_joint_free(&A, NULL);
    default: return mbsr_joint_translational(&A, NULL);
    }
}

static void add_tree(loops *s, const choice *c, test_rng *rng)
{
    for (int k = 0; k < c->bodies; ++k) {
        double com[3];
        const double tensor[6] = {0.3, 0.4, 0.5, 0.01, 0.02, -0.03};
        mbsr_body_def body = mbsr_default_body_def();
        test_fill(rng, 3, com);
        body.parent = test_integer(rng, -1, k - 1);
        body.joint = random_joint(rng, c->plane);
        const double mass = 1.0 + 0.5 * test_uniform(rng);
        if (share(rng) >= c->massless)
            body.inertia = c->plane ? mbsr_inertia_planar(mass, com, 0.4)
                                    : mbsr_inertia_rigid(mass, com, tensor);
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
        /* some massless bodies are held by loops alone, most by a bushing on the ground */
        const bool light = body.inertia.kind == MBSR_INERTIA_NOT_GIVEN, loose = share(rng) < 0.25;
        const double springs[6] = {3.0, 4.0, 5.0, 2.0, 3.0, 4.0},
                     dampers[6] = {0.7, 0.6, 0.5, 0.7, 0.8, 0.9};
        const mbsr_frame place = mbsr_frame_at(com[0], com[1], com[2]);
        const mbsr_force_def bushing =
            c->plane ? mbsr_force_joint_spring(k, 0, 2.0, 0.7, 0.0)
                     : mbsr_force_bushing(k, NULL, MBSR_GROUND, &place, springs, dampers);
        if (light && !loose)
            assert_ok(mbsr_model_add_force(s->m, &bushing, NULL), mbsr_model_error(s->m));
    }
}

/* Where the bodies are, and the joint coordinates. */
typedef struct places {
    mbsr_frame frame[BODIES];
    double q[LOOPS_MOST];
    int first[BODIES], n[BODIES]; /* coordinates with q' = u */
} places;

static mbsr_frame frame_of(const places *at, int body)
{
    return body == MBSR_GROUND ? mbsr_frame_identity() : at->frame[body];
}

/* A frame of the world in the axes of a body. */
static mbsr_frame seen_from(const places *at, int body, const mbsr_frame *world)
{
    const mbsr_frame frame = frame_of(at, body), inverse = mbsr_frame_inverse(&frame);
    return mbsr_frame_product(&inverse, world);
}

enum { BALL, ROWS, DISTANCE, WELD, BODY_ROWS, COUPLING, ROLLING_BALL, ROLLING_DISC, OWN, KINDS };

static mbsr_closure_def closure(const choice *c, const places *at, test_rng *rng, int kind);

static mbsr_closure_def coupling(const choice *c, const places *at, test_rng *rng)
{
    int body[2] = {0, 0}, coordinate[2];
    double coefficient[2], sum = 0.0;
    test_fill(rng, 2, coefficient);
    for (int k = 0; k < 2; ++k) {
        for (int tries = 0; tries < 50; ++tries) {
            body[k] = test_integer(rng, 0, c->bodies - 1);
            if (at->n[body[k]] > 0 && (k == 0 || body[0] != body[1])) break;
        }
        if (at->n[body[k]] == 0 || (k == 1 && body[0] == body[1]))
            return closure(c, at, rng, DISTANCE);
        coordinate[k] = at->n[body[k]] - 1;
        sum += coefficient[k] * at->q[at->first[body[k]] + coordinate[k]];
    }
    return mbsr_closure_coupling(2, body, coordinate, coefficient, sum);
}

static mbsr_closure_def closure(const choice *c, const places *at, test_rng *rng, int kind)
{
    double p[3], x[6], y[3];
    test_fill(rng, 3, p);
    test_fill(rng, 6, x);
    test_fill(rng, 3, y);
    if (c->plane) p[2] = 0.0, x[2] = x[5] = 0.0;
    const int a = test_integer(rng, 0, c->bodies - 1);
    int b = test_integer(rng, -1, c->bodies - 1);
    if (a == b) b = MBSR_GROUND;
    const mbsr_frame of_a = frame_of(at, a), point = mbsr_frame_at(p[0], p[1], p[2]),
                     world = mbsr_frame_product(&of_a, &point), there = seen_from(at, b, &world);
    switch (kind) {
    case BALL: return mbsr_closure_ball(a, p, b, there.x);
    case ROWS: return mbsr_closure_rows(a, p, b, there.x, c->plane ? 1 : 2, x);
    case BODY_ROWS: return mbsr_closure_body_rows(a, p, b, there.x, c->plane ? 1 : 2, x);
    case WELD: return mbsr_closure_weld(a, &point, b, &there);
    case DISTANCE: {
        double length = 0.0;
        const mbsr_frame of_b = frame_of(at, b);
        for (int k = 0; k < 3; ++k) length += (world.x[k] - of_b.x[k]) * (world.x[k] - of_b.x[k]);
        return mbsr_closure_distance(a, p, b, NULL, sqrt(length));
    }
    case ROLLING_BALL: {
        /* centre at p, which is a radius above the plane */
        mbsr_frame plane = mbsr_frame_along(world.x, y);
        for (int k = 0; k < 3; ++k) plane.x[k] -= 0.3 * plane.R[6 + k];
        plane = seen_from(at, b, &plane);
        return mbsr_closure_rolling_ball(a, p, 0.3, b, &plane);
    }
    case ROLLING_DISC: {
        /* the disc touches at its rim along x, on a plane that contains y and leans over */
        const mbsr_frame lean =
            mbsr_frame_rotated((double[3]){-0.4, 0.0, 0.0}, (double[3]){0.0, 1.0, 0.0}, 1.1);
        const mbsr_frame plane = mbsr_frame_product(&world, &lean);
        const mbsr_frame on_b = seen_from(at, b, &plane);
        return mbsr_closure_rolling_disc(a, &point, 0.4, b, &on_b);
    }
    case OWN: {
        if (b == MBSR_GROUND) b = a == 0 ? c->bodies - 1 : 0;
        mbsr_closure_def def = mbsr_closure_custom(test_own_closure + test_integer(rng, 0, 1), 2,
                                                   (int[2]){a, b}, 1, 1, NULL);
        for (int k = 0; k < 3; ++k) def.param[0] += at->frame[a].x[k] * at->frame[b].x[k];
        return def;
    }
    default: return coupling(c, at, rng);
    }
}

static void find_places(const choice *c, places *at)
{
    loops s;
    double pose[MBSR_POSE_SIZE], y[8 * LOOPS_MOST];
    test_rng rng = test_seed(c->seed), other = test_seed(c->seed + 7919);
    loops_begin(&s, NULL);
    add_tree(&s, c, &rng);
    loops_finish(&s);
    test_fill(&other, s.nq, s.q);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    memcpy(at->q, y, (size_t)s.nq * sizeof *y); /* quaternions of length 1 */
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, at->q), mbsr_data_error(s.d));
    for (int k = 0; k < c->bodies; ++k) {
        int nq, n;
        assert_ok(mbsr_body_pose(s.m, s.d, k, pose), NULL);
        assert_ok(mbsr_body_coordinates(s.m, k, at->first + k, &nq, NULL, &n), NULL);
        at->n[k] = nq == n ? n : 0;
        if (c->plane) {
            at->frame[k] = mbsr_frame_rotated((double[3]){pose[0], pose[1], 0.0},
                                              (double[3]){0.0, 0.0, 1.0}, pose[2]);
            continue;
        }
        memcpy(at->frame[k].R, pose + MBSR_POSE_R, 9 * sizeof *pose);
        memcpy(at->frame[k].x, pose + MBSR_POSE_X, 3 * sizeof *pose);
    }
    loops_free(&s);
}

static void add_bushings(loops *s, const choice *c, test_rng *rng)
{
    const double springs[6] = {30.0, 40.0, 50.0, 200.0, 300.0, 400.0},
                 dampers[6] = {0.3, 0.4, 0.5, 2.0, 3.0, 4.0},
                 K[9] = {200.0, 0.0, 0.0, 0.0, 300.0, 0.0, 0.0, 0.0, 30.0},
                 D[9] = {2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.3};
    for (int k = 0; k < c->bushings; ++k) {
        const int a = test_integer(rng, 1, c->bodies - 1), parent = mbsr_body_parent(s->m, a),
                  other = test_integer(rng, 0, a - 1), b = k == 0 && parent >= 0 ? parent : other;
        const mbsr_frame at = mbsr_frame_at(0.3, -0.2, 0.1);
        const mbsr_planar_frame flat = {0.3, -0.2, 0.4}, none = {0.0, 0.0, 0.0};
        const mbsr_force_def bushing = c->plane
                                           ? mbsr_force_planar_bushing(a, flat, b, none, K, D)
                                           : mbsr_force_bushing(a, &at, b, NULL, springs, dampers);
        assert_ok(mbsr_model_add_force(s->m, &bushing, NULL), mbsr_model_error(s->m));
    }
}

static void make(loops *s, const choice *c)
{
    places at;
    test_rng rng = test_seed(c->seed), other = test_seed(c->seed + 104729);
    find_places(c, &at);
    loops_begin(s, NULL);
    add_tree(s, c, &rng);
    for (int k = 0; k < c->closures; ++k) {
        const int kind =
            c->kind >= 0 ? c->kind : test_integer(&other, 0, c->plane ? COUPLING : KINDS - 1);
        mbsr_closure_def def = closure(c, &at, &other, kind);
        const bool soft = c->kind < 0 && share(&other) < 0.25;
        const bool springs = kind < WELD || kind == COUPLING;
        for (int l = 0; l < (kind == BALL ? c->plane ? 2 : 3 : 1) && soft && springs; ++l) {
            def.stiffness[l] = 1e4;
            def.damping[l] = 30.0;
        }
        for (int l = 0; l < (k < c->twice ? 2 : 1); ++l)
            assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    }
    add_bushings(s, c, &other);
    loops_finish(s);
    memcpy(s->q, at.q, sizeof at.q);
    test_fill(&other, s->nu, s->u);
}

/* ---- solutions ---- */

typedef struct tally {
    int models, left_out, systems, sharp, held;
    int vector_code; /* of the systems, those that some of it served */
    int compared,
        same; /* of models with some; those whose solutions are those by the front to 1e-10 */
    int sharp_products; /* A (A^-1 r) that is r to 1e-9 */
} tally;

static const double factors[] = {1.0, 100.0, 1e5, -30.0};
enum { FACTORS = sizeof factors / sizeof factors[0] };

/* Solutions for several c against the dense matrix, from random right-hand sides; to `all`. */
static void check_solver(test_newton_state *s, const choice *c, int by_blocks, tally *group,
                         double *all)
{
    mbsr_newton *newton;
    mbsr_error error;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    opt.by_blocks = by_blocks;
    assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    double *r = calloc(2 * (size_t)s->n, sizeof *r), *p = r + s->n;
    test_rng rng = test_seed(c->seed + 99);
    for (int k = 0; k < FACTORS; ++k) {
        double *x = all + k * s->n;
        test_fill(&rng, s->n, r);
        assert_ok(mbsr_newton_factor(newton, s->data, s->t, s->y, s->yp, factors[k]),
                  mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
        const test_newton_errors e = test_newton_compare(s, factors[k], r, x);
        mbsr_newton_info info;
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        group->vector_code += info.vector_code;
        ++group->systems;
        group->sharp += e.row < 1e-8 && e.delta < 1e-7;
        if (!(e.net_row < 1e-6) || !(e.net_delta < 1e-6))
            print_error("seed %d, c = %g: row %.2e (net %.2e), delta %.2e (net %.2e), amplified "
                        "%.1e\n",
                        (int)c->seed, factors[k], e.row, e.net_row, e.delta, e.net_delta,
                        e.amplification);
        assert_less(e.net_row, 1e-6);
        assert_less(e.net_delta, 1e-6);
        assert_ok(mbsr_newton_linearise(newton, s->data, s->t, s->y, s->yp, factors[k]),
                  mbsr_newton_error(newton));
        assert_ok(mbsr_newton_multiply(newton, r, p), mbsr_newton_error(newton));
        assert_less(test_newton_product_error(s, factors[k], r, p, NULL), 1e-6);
        assert_ok(mbsr_newton_multiply(newton, x, p), mbsr_newton_error(newton));
        const double back = test_newton_product_error(s, factors[k], x, p, r);
        assert_less(back, 1e-6);
        group->sharp_products += back < 1e-9;
    }
    free(r);
    mbsr_newton_destroy(newton);
}

/* In vector code as far as that serves, and without it. */
static void check_state(test_newton_state *s, const choice *c, tally *group)
{
    const int before = group->vector_code;
    double *x = calloc(2 * FACTORS * (size_t)s->n, sizeof *x), *y = x + FACTORS * s->n;
    check_solver(s, c, 0, group, x);
    const bool vector_code = group->vector_code > before;
    check_solver(s, c, 1, group, y);
    group->compared += vector_code ? FACTORS : 0;
    for (int k = 0; k < FACTORS && vector_code; ++k)
        group->same += test_newton_distance(s, x + k * s->n, y + k * s->n) < 1e-10;
    free(x);
}

/* A start gives a state of a solution, or a status. */
static void expect_solution(const test_newton_state *s, const choice *c)
{
    double *F = calloc((size_t)s->n, sizeof *F);
    assert_ok(mbsr_dae_residual(s->model, s->data, s->form, s->t, s->y, s->yp, F),
              mbsr_data_error(s->data));
    const double left = test_largest(s->n, F), size = 1.0 + test_largest(s->n, s->yp);
    if (!(left < 1e-9 * size)) print_error("seed %d: %.2e of F left\n", (int)c->seed, left);
    assert_less(left, 1e-9 * size);
    free(F);
}

/* Left out: mechanisms with more rows than freedoms, and massless directions that nothing
 * determines. */
static void check(const choice *c, tally *group)
{
    loops s;
    mbsr_consistent_info info = {0};
    test_newton_state state;
    make(&s, c);
    const int status = test_newton_start(&state, s.m, s.d, 0.0, s.q, s.u, &info);
    ++group->models;
    if (status == MBSR_OK) {
        expect_solution(&state, c);
        assert_ok(test_newton_matrices(&state, s.m, s.d), mbsr_data_error(s.d));
    }
    if (status != MBSR_OK || state.roughness > 1e-4 ||
        test_largest(s.nu, state.y + state.nq + state.nu) > 1e3)
        ++group->left_out;
    else
        check_state(&state, c, group);
    test_newton_free(&state);
    loops_free(&s);
}

static void conclude(const tally *group, int most_left_out)
{
    assert_in_range(group->vector_code, group->systems / 4, group->systems / 2);
    assert_in_range(group->same, 0.96 * group->compared, group->compared);
    assert_in_range(group->left_out, 0, most_left_out);
    assert_in_range(group->sharp, 0.01 * test_seeds(84, 90) * group->systems, group->systems);
    assert_in_range(group->sharp_products, 0.01 * test_seeds(84, 90) * group->systems,
                    group->systems);
}

static void closures_of_all_kinds(void **state)
{
    (void)state;
    tally group = {0};
    for (int kind = 0; kind < KINDS; ++kind) {
        for (uint64_t seed = 1; seed <= 4; ++seed) {
            const choice c = {.seed = 100 * (uint64_t)kind + seed,
                              .bodies = 3 + (int)seed % 3,
                              .closures = 1,
                              .massless = 0.2,
                              .kind = kind};
            check(&c, &group);
        }
    }
    conclude(&group, 12);
}

static void several_loops(void **state)
{
    (void)state;
    tally group = {0};
    /* with a group of joints beside a loop, rows and masses of nothing but rounding, and stiff rows
     * that are redundant */
    static const uint64_t more[] = {168, 238, 439, 527, 695};
    const uint64_t models = test_long() ? 600 : (uint64_t)test_seeds_short(20, 40);
    for (uint64_t k = 1; k <= models + sizeof more / sizeof more[0]; ++k) {
        const uint64_t seed = k <= models ? k : more[k - models - 1];
        const choice c = {.seed = seed,
                          .bodies = 4 + (int)seed % 5,
                          .closures = 1 + (int)seed % 3,
                          .massless = 0.15 * (double)(seed % 4),
                          .kind = -1,
                          .twice = seed % 5 == 0,
                          .plane = seed % 3 == 0};
        check(&c, &group);
    }
    conclude(&group, (int)models / 2);
}

static void bushings_beside_loops(void **state)
{
    (void)state;
    tally group = {0};
    const uint64_t models = test_long() ? 300 : (uint64_t)test_seeds_short(5, 24);
    for (uint64_t seed = 1; seed <= models; ++seed) {
        const choice c = {.seed = 3000 + seed,
                          .bodies = 4 + (int)seed % 5,
                          .closures = 1 + (int)seed % 2,
                          .massless = 0.15 * (double)(seed % 3),
                          .kind = -1,
                          .bushings = 1 + (int)seed % 3,
                          .plane = seed % 2 == 0};
        check(&c, &group);
    }
    conclude(&group, (int)models / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(closures_of_all_kinds),
                                       cmocka_unit_test(bushings_beside_loops),
                                       cmocka_unit_test(several_loops)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
