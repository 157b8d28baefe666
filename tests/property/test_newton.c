/* The O(N) Newton solver on random trees, against the dense Newton matrix by differences of the
 * residual.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "kinds.h"
#include "mixed.h"
#include "newton_system.h"
#include "plane_tree.h"
#include "rigid_tree.h"
#include "space.h"
#include "tree.h"
#include "web.h"

#include <float.h>
#include <stdbool.h>
#include <stdlib.h>

#define TREES (test_long() ? 80 : test_seeds_short(16, 24))

/* ---- one tree ---- */

/* What a group of trees has come to. */
typedef struct tally {
    const char *name;
    int trees, left_out; /* left out: see check */
    int systems, sharp;  /* sharp: to a row defect of 1e-8 and an error of 1e-7, nothing deducted */
    int across;          /* trees with elements across */
    int eliminated;      /* those whose elements across go with the tree as well */
    int swept;           /* trees in vector code */
    int turned;          /* systems solved transposed in vector code */
    int null, elastic;   /* trees with directions that move no mass */
    double between;      /* largest distance of the two versions, net of what differences cost */
    int products, sharp_products; /* A (A^-1 r); with rows that are r to 1e-9 */
    bool differenced;             /* some elements have no derivatives */
    bool twice;                   /* some joint's derivatives are differences of differences */
} tally;

static mbsr_newton *make_solver(const mbsr_model *model, mbsr_newton_method method, int by_blocks,
                                int transposes)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    mbsr_error error;
    opt.method = method;
    opt.by_blocks = by_blocks;
    opt.transposes = transposes;
    opt.products = 1;
    assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

static void solve(mbsr_newton *newton, const test_newton_state *s, double c, const double *r,
                  double *delta)
{
    assert_ok(mbsr_newton_factor(newton, s->data, s->t, s->y, s->yp, c), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
}

/* Fails where a solution is off by more than the reference is uncertain. Returns how far
 * differences move it that are central, of first order, right to eps^(2/3). */
static double judge(const test_newton_state *s, double c, const double *r, const double *x,
                    int number, tally *group)
{
    const test_newton_errors e = test_newton_compare(s, c, r, x);
    ++group->systems;
    group->sharp += e.row < 1e-8 && e.delta < 1e-7;
    if (!(e.net_row < 1e-6) || !(e.net_delta < 1e-6)) {
        print_error("%s %d, c = %g: row %.2e (net %.2e), delta %.2e (net %.2e), amplified %.1e\n",
                    group->name, number, c, e.row, e.net_row, e.delta, e.net_delta,
                    e.amplification);
    }
    assert_less(e.net_row, 1e-6);
    assert_less(e.net_delta, 1e-6);
    return e.amplification * pow(DBL_EPSILON, 2.0 / 3.0);
}

/* The distance of two versions' solutions. */
static void compare(const test_newton_state *s, const double *x, const double *other, double moved,
                    tally *group)
{
    const double distance = test_newton_distance(s, x, other);
    group->between = fmax(group->between, distance - (group->differenced ? moved : 0.0));
}

/* Products with the matrix against the dense matrix, for r, and against the systems that x solves,
 * of either version. */
static void judge_products(mbsr_newton *newton, const test_newton_state *s, double c,
                           const double *r, const double *const x[2], int number, tally *group)
{
    double *p = calloc((size_t)s->n, sizeof *p);
    assert_ok(mbsr_newton_linearise(newton, s->data, s->t, s->y, s->yp, c),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, r, p), mbsr_newton_error(newton));
    const double dense = test_newton_product_error(s, c, r, p, NULL);
    if (!(dense < 1e-6))
        print_error("%s %d, c = %g: product off by %.2e\n", group->name, number, c, dense);
    assert_less(dense, 1e-6);
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_newton_multiply(newton, x[k], p), mbsr_newton_error(newton));
        const double back = test_newton_product_error(s, c, x[k], p, r);
        if (!(back < 1e-6))
            print_error("%s %d, c = %g: A x - r by %.2e\n", group->name, number, c, back);
        assert_less(back, 1e-6);
        ++group->products;
        group->sharp_products += back < 1e-9;
    }
    free(p);
}

/* Elements across eliminated with the tree instead, likewise, and against the corrected solution x.
 */
static void check_eliminated(test_newton_state *s, double c, const double *r, const double *x,
                             int number, tally *group)
{
    double *other = calloc((size_t)s->n, sizeof *other);
    for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
        mbsr_newton *newton = make_solver(s->model, MBSR_NEWTON_ELIMINATED, by_blocks, 0);
        mbsr_newton_info info;
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        if (info.method == MBSR_NEWTON_ELIMINATED) {
            solve(newton, s, c, r, other);
            compare(s, x, other, judge(s, c, r, other, number, group), group);
            ++group->eliminated;
        }
        mbsr_newton_destroy(newton);
    }
    free(other);
}

/* A^T x = r, row by row beside what is added up there; and r A^-1 w = x w with the solution of the
 * same factors. */
static void check_transposed(const test_newton_state *s, mbsr_newton *newton, double c,
                             const double *r, tally *group)
{
    const size_t n = (size_t)s->n;
    double *x = calloc(4 * n, sizeof *x), *p = x + n, *w = p + n, *y = w + n, dot = 0.0, size = 0.0;
    mbsr_newton_info info;
    const mbsr_error *error = mbsr_newton_error(newton);
    for (size_t k = 0; k < n; ++k) w[k] = cos((double)k), x[k] = NAN;
    solve(newton, s, c, w, y);
    assert_ok(mbsr_newton_solve_transposed(newton, r, x), error);
    assert_ok(mbsr_newton_linearise(newton, s->data, s->t, s->y, s->yp, c), error);
    assert_ok(mbsr_newton_multiply_transposed(newton, x, p), error);
    assert_ok(mbsr_newton_get_info(newton, &info), NULL);
    for (size_t j = 0; j < n; ++j) {
        double row = fabs(r[j]);
        for (size_t i = 0; i < n; ++i) row += fabs((s->A[j * n + i] + c * s->B[j * n + i]) * x[i]);
        assert_less(fabs(p[j] - r[j]), 1e-7 * row);
        dot += r[j] * y[j] - x[j] * w[j], size += fabs(r[j] * y[j]) + fabs(x[j] * w[j]);
    }
    assert_less(fabs(dot), 1e-9 * size);
    group->turned += info.vector_code;
    free(x);
}

/* Both versions of the exact solver against the dense matrix and each other. */
static void check_state(test_newton_state *s, int number, tally *group)
{
    static const double factors[] = {1.0, 100.0, 1e5, -30.0};
    mbsr_newton *newton = make_solver(s->model, MBSR_NEWTON_CORRECTED, 0, 0),
                *blocks = make_solver(s->model, MBSR_NEWTON_CORRECTED, 1, 0),
                *turned = make_solver(s->model, MBSR_NEWTON_CORRECTED, 0, 1);
    double *r = calloc(3 * (size_t)s->n, sizeof *r), *x = r + s->n, *other = x + s->n;
    mbsr_newton_info info;
    test_rng rng = test_seed((uint64_t)number + 99);
    for (size_t k = 0; k < sizeof factors / sizeof factors[0]; ++k) {
        test_fill(&rng, s->n, r);
        solve(newton, s, factors[k], r, x);
        solve(blocks, s, factors[k], r, other);
        const double moved = judge(s, factors[k], r, x, number, group);
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        if (info.vector_code) (void)judge(s, factors[k], r, other, number, group);
        if ((k + (size_t)number) % 2 == 0)
            judge_products(newton, s, factors[k], r, (const double *const[2]){x, other}, number,
                           group);
        compare(s, x, other, moved, group);
        check_eliminated(s, factors[k], r, x, number, group);
        check_transposed(s, turned, factors[k], r, group);
    }
    group->across += info.across > 0;
    group->swept += info.vector_code;
    free(r);
    mbsr_newton_destroy(newton);
    mbsr_newton_destroy(blocks);
    mbsr_newton_destroy(turned);
}

/* The residuals of two models of the same equations, beside the state. */
static void assert_same_equations(const test_newton_state *s, const mbsr_model *model,
                                  mbsr_data *data)
{
    double *F = calloc(4 * (size_t)s->n + 1, sizeof *F), *other = F + s->n, *y = other + s->n,
           *yp = y + s->n;
    for (int k = 0; k < s->n; ++k) {
        y[k] = s->y[k] + 0.01 * sin(k);
        yp[k] = s->yp[k] + 0.01 * cos(k);
    }
    assert_ok(mbsr_dae_residual(s->model, s->data, s->form, s->t, y, yp, F), NULL);
    assert_ok(mbsr_dae_residual(model, data, s->form, s->t, y, yp, other), NULL);
    for (int k = 0; k < s->n; ++k)
        assert_close(other[k], F[k], 1e-8 * (1.0 + test_largest(s->n, F)));
    free(F);
}

/* The smallest scaled eigenvalue that counts as inertia at the state, 1 if there is none. */
static double smallest_inertia(const test_newton_state *s)
{
    double smallest = 1.0;
    assert_ok(mbsr_stage_positions(s->model, s->data, s->t, s->y), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->y + s->nq + s->nu),
              mbsr_data_error(s->data));
    assert_ok(mbsr_stage_forces(s->model, s->data, NULL), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_backward(s->model, s->data), mbsr_data_error(s->data));
    for (int body = 0; body < mbsr_model_bodies(s->model); ++body) {
        mbsr_rank_info rank;
        assert_ok(mbsr_body_rank(s->model, s->data, body, &rank), mbsr_data_error(s->data));
        if (rank.rank > 0) smallest = fmin(smallest, rank.smallest_kept);
    }
    return smallest;
}

/* Whether a ball joint has turned by half a turn, where the force of a spring has no derivative. */
static bool half_turned(const mbsr_model *model, const double *q)
{
    for (int id = 0; id < mbsr_model_bodies(model); ++id) {
        int iq, nq, iu, nu;
        assert_ok(mbsr_body_coordinates(model, id, &iq, &nq, &iu, &nu), NULL);
        if (nq > nu && fabs(q[iq]) < 1e-6) return true;
    }
    return false;
}

/* The solver for `model` against the matrix of `plain`, the same equations as far as possible
 * without differences inside.
 *
 * Rough: the residual is not smooth over the length of the differences, as where a bushing is
 * turned by pi. Wild: velocities so large that its rounding errors count. Near: the rank of a joint
 * is about to change, and rounding errors are divided by an eigenvalue below 1e-7, in the residual
 * as in the solver. */
static void check_by(const mbsr_model *plain, mbsr_data *plain_data, const mbsr_model *model,
                     mbsr_data *data, double t, const double *q, const double *u, int number,
                     tally *group)
{
    mbsr_consistent_info info = {0};
    test_newton_state s;
    const int status = test_newton_start(&s, model, data, t, q, u, &info);
    if (status == MBSR_OK) {
        if (plain != model) assert_same_equations(&s, plain, plain_data);
        assert_ok(test_newton_matrices(&s, plain, plain_data), mbsr_data_error(plain_data));
    }
    const bool wild = test_largest(s.nu, s.y + s.nq + s.nu) > 1e4 || half_turned(model, s.y),
               near = status == MBSR_OK && smallest_inertia(&s) < 1e-7;
    ++group->trees;
    if (status != MBSR_OK || s.nu == 0 || s.roughness > 1e-4 || wild || near) {
        ++group->left_out;
    } else {
        group->null += info.null_directions > 0;
        group->elastic += info.elastic;
        check_state(&s, number, group);
    }
    test_newton_free(&s);
}

static void check(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                  const double *u, int number, tally *group)
{
    check_by(model, data, model, data, t, q, u, number, group);
}

/* Nearly all trees could be used, and the reference is good nearly everywhere: in 90 % of the
 * systems or, as that scatters, in 84 % of a few. */
static void conclude(const tally *group, int most_left_out)
{
    assert_in_range(group->left_out, 0, most_left_out);
    assert_in_range(group->sharp, 0.01 * test_seeds(84, 90) * group->systems, group->systems);
    /* over steps of 1e-3, rounding in these counts 1e6 times, and the two versions round otherwise
     */
    assert_less(group->between, group->twice ? 1e-8 : 1e-9);
    assert_in_range(group->sharp_products, 0.01 * test_seeds(84, 90) * group->products,
                    group->products);
}

/* ---- trees of rigid bodies ---- */

static void rigid(test_rigid_choice choice, tally *group)
{
    test_rigid_tree tree, plain;
    test_rigid_tree_make(&tree, choice);
    choice.tables = 0;
    test_rigid_tree_make(&plain, choice);
    check_by(plain.model, plain.data, tree.model, tree.data, tree.t, tree.q, tree.u,
             (int)choice.seed, group);
    test_rigid_tree_free(&tree);
    test_rigid_tree_free(&plain);
}

/* The choice that all trees of rigid bodies begin with. */
static test_rigid_choice rigid_choice(int seed)
{
    return (test_rigid_choice){.seed = (uint64_t)seed,
                               .bodies = 2 + seed % 7,
                               .many = 0.2 * (seed % 4),
                               .branching = 0.5,
                               .length = 0.5,
                               .moving = seed % 2,
                               .shuffle = seed / 2 % 2};
}

static void rigid_bodies(void **state)
{
    (void)state;
    tally group = {.name = "rigid"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_rigid_choice choice = rigid_choice(seed);
        choice.forces = seed % 3;
        choice.points = 0.3 * (seed % 3);
        choice.armature = seed % 4 == 3 ? 0.5 : 0.0;
        rigid(choice, &group);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.swept > TREES / 8 && group.across > TREES / 4);
    assert_true(group.turned > TREES / 4);
    assert_true(group.eliminated > TREES);
}

static void bodies_without_mass(void **state)
{
    (void)state;
    tally group = {.name = "massless"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_rigid_choice choice = rigid_choice(seed);
        choice.forces = 2;
        choice.massless = 0.5;
        choice.points = 0.5;
        choice.armature = seed % 5 == 4 ? 0.4 : 0.0;
        rigid(choice, &group);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null > TREES / 2 && group.across > TREES / 2);
    assert_true(group.eliminated > TREES);
}

static void locked_joints_added_masses_and_joints_without_derivatives(void **state)
{
    (void)state;
    tally group = {.name = "amended"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_rigid_choice choice = rigid_choice(seed);
        choice.forces = 2;
        choice.many = 0.5;
        choice.massless = 0.3;
        choice.points = 0.5;
        choice.held = choice.added = 0.4;
        choice.armature = seed % 3 == 2 ? 0.5 : 0.0;
        choice.tables = seed % 2;
        rigid(choice, &group);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null > TREES / 4 && group.across > TREES / 2);
    assert_true(group.eliminated > TREES);
}

static void mass_points_in_several_units(void **state)
{
    (void)state;
    tally group = {.name = "points"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        test_space_opt opt = {.seed = (uint64_t)seed,
                              .bodies = 1 + seed % 9,
                              .deficient = 0.2 * (seed % 5),
                              .driven = seed % 2,
                              .laws = 1,
                              .gravity = 9.81};
        if (seed % 3 == 0) opt.length = 1000.0, opt.mass = 1e-3;
        test_space_make(&tree, opt);
        check(tree.model, tree.data, 0.3, tree.q, tree.u, seed, &group);
        test_space_free(&tree);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null > 3 * TREES / 8 && group.turned > TREES);
}

/* ---- bodies of other kinds ---- */

static void general_bodies(void **state)
{
    (void)state;
    tally group = {.name = "general"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_tree tree, plain;
        double q[64], u[64];
        test_rng rng = test_seed((uint64_t)seed);
        test_tree_opt opt = {.seed = (uint64_t)seed,
                             .bodies = 1 + seed % 8,
                             .max_d = 4,
                             .welds = seed / 2 % 2,
                             .deficient = seed % 2 ? 0.0 : 0.6,
                             .bend = 0.15,
                             .forces = seed % 4 != 3,
                             .moving_root = seed % 3 == 0,
                             .shuffle = seed % 2,
                             .tables = 1};
        test_tree_make(&tree, opt);
        opt.tables = 0;
        test_tree_make(&plain, opt);
        test_fill(&rng, tree.nu, q);
        test_fill(&rng, tree.nu, u);
        check_by(plain.model, plain.data, tree.model, tree.data, 0.3, q, u, seed, &group);
        test_tree_free(&tree);
        test_tree_free(&plain);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null > TREES / 4 && group.across > TREES / 3);
}

static void bodies_in_the_plane(void **state)
{
    (void)state;
    tally group = {.name = "plane"};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_plane_tree tree;
        test_plane_make(&tree, (test_plane_choice){.seed = (uint64_t)seed,
                                                   .bodies = 2 + seed % 8,
                                                   .massless = 0.3 * (seed % 3),
                                                   .functions = seed % 2,
                                                   .moving = seed % 2,
                                                   .damped = 1});
        check(tree.model, tree.data, tree.t, tree.q, tree.u, seed, &group);
        test_plane_free(&tree);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null >= TREES / 2 && group.across > TREES / 2);
    assert_true(group.eliminated > TREES);
}

static void bodies_of_all_kinds(void **state)
{
    (void)state;
    tally rigid = {.name = "mixed"}, general = {.name = "with a general body", .twice = true};
    for (int seed = 0; seed < test_seeds_short(2, 6) * MIXED_ALL; ++seed) {
        mixed tree;
        double q[MIXED_NQ], u[MIXED_NU];
        test_rng rng = test_seed((uint64_t)seed);
        const mixed_scene scene = (mixed_scene)(seed % MIXED_ALL);
        mixed_make(&tree, scene);
        test_fill(&rng, tree.nq, q);
        test_fill(&rng, tree.nu, u);
        check(tree.model, tree.data, 0.3, q, u, seed, scene < MIXED_SCENES ? &rigid : &general);
        mixed_free(&tree);
    }
    conclude(&rigid, 0);
    conclude(&general, 0);
}

/* How often bodies of two kinds are neighbours: one of a caller's own on a rigid one, and the other
 * way round; and how often both move with a massless direction at or before the first of them. */
typedef struct borders {
    int down, up, deep_down, deep_up;
} borders;

static void count_borders(const test_kinds_tree *tree, borders *n)
{
    int deep[TEST_KINDS_BODIES];
    for (int i = 0; i < tree->bodies; ++i) {
        const int parent = tree->parent[i];
        mbsr_rank_info rank;
        assert_ok(mbsr_body_rank(tree->model, tree->data, i, &rank), mbsr_data_error(tree->data));
        deep[i] = rank.rank < rank.n || (parent >= 0 && deep[parent]);
        if (parent < 0) continue;
        const bool down = tree->own[i] && !tree->own[parent],
                   up = !tree->own[i] && tree->own[parent];
        n->down += down;
        n->up += up;
        n->deep_down += down && deep[parent];
        n->deep_up += up && deep[parent];
    }
}

/* Trees whose kinds meet in any order. */
static void kinds_in_any_order(void **state)
{
    (void)state;
    tally group = {.name = "kinds"};
    borders n = {0};
    for (int seed = 1; seed <= 3 * TREES; ++seed) {
        test_kinds_tree tree;
        const test_kinds_choice choice = {.seed = (uint64_t)seed,
                                          .bodies = 2 + seed % 8,
                                          .plane = seed % 4 == 3,
                                          .own = 0.4,
                                          .general = seed % 4 < 2 ? 0.2 : 0.0,
                                          .many = seed % 3 ? 0.0 : 0.3,
                                          .massless = seed % 3 == 0 ? 0.3
                                                      : seed % 5    ? 0.7
                                                                    : 0.0,
                                          .springs = seed / 2 % 2};
        test_kinds_make(&tree, choice);
        const int left_out = group.left_out;
        check(tree.model, tree.data, tree.t, tree.q, tree.u, seed, &group);
        if (group.left_out == left_out) count_borders(&tree, &n);
        test_kinds_free(&tree);
    }
    assert_true(group.swept > TREES / 2 && group.null > TREES);
    assert_true(n.down > TREES && n.up > TREES && n.deep_down > TREES / 8 &&
                n.deep_up > TREES / 10);
    assert_true(group.eliminated > TREES);
    conclude(&group, (TREES + 20) / 20);
}

/* ---- chains without mass ---- */

/* A letter a body, each on the one before or, at a comma, the one before that: 0 no mass, p a
 * point, r a rod, b a box. */
typedef struct chain {
    mbsr_model *model;
    mbsr_data *data;
    double q[80], u[80];
} chain;

static mbsr_inertia inertia_of(char letter, test_rng *rng)
{
    static const double a[3] = {0.2, -0.1, 0.3}, b[3] = {-0.3, 0.2, 0.4},
                        edges[3] = {0.3, 0.5, 0.7};
    const mbsr_frame frame = test_frame(rng, 0.4);
    if (letter == 'p') return mbsr_inertia_point_mass(1.2, a);
    if (letter == 'r') return mbsr_inertia_rod(1.2, a, b);
    if (letter == 'b') return mbsr_inertia_in_frame(&frame, mbsr_inertia_box(9.0, edges));
    return mbsr_inertia_zero();
}

static void make_chain(chain *s, const char *pattern, uint64_t seed, double damping)
{
    test_rng rng = test_seed(seed);
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int id = 0, back = 1; *pattern; ++pattern) {
        if (*pattern == ',') {
            back = 2;
            continue;
        }
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = id >= back ? id - back : MBSR_GROUND;
        body.joint = test_joint_in_space(&rng, test_integer(&rng, TEST_REVOLUTE, TEST_FREE), 1.0);
        body.inertia = inertia_of(*pattern, &rng);
        const mbsr_force_def law = test_joint_law(id, 3.0 + test_uniform(&rng), damping);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
        assert_ok(mbsr_model_add_force(s->model, &law, NULL), mbsr_model_error(s->model));
        back = 1;
        ++id;
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.2, -1.0, 0.3);
    assert_ok(mbsr_model_add_force(s->model, &gravity, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    assert_true(mbsr_model_nq(s->model) <= 80);
    test_fill(&rng, mbsr_model_nq(s->model), s->q);
    test_fill(&rng, mbsr_model_nu(s->model), s->u);
    for (int k = 0; k < mbsr_model_nq(s->model); ++k) s->q[k] *= 0.5;
}

static void chains_of_bodies_without_mass(void **state)
{
    (void)state;
    static const char *const patterns[] = {"000b",   "b000",     "0b0b0b", "000000",    "b0p0r0",
                                           "prprpr", "00,0b,00", "0",      "b00r,0,0,p"};
    enum { PATTERNS = sizeof patterns / sizeof patterns[0] };
    tally damped = {.name = "chains"}, elastic = {.name = "elastic"};
    for (int seed = 0; seed < test_seeds_short(2, 4) * PATTERNS; ++seed) {
        chain s;
        make_chain(&s, patterns[seed % PATTERNS], (uint64_t)seed + 1, 0.8);
        check(s.model, s.data, 0.0, s.q, s.u, seed, &damped);
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.model);
        make_chain(&s, patterns[seed % PATTERNS], (uint64_t)seed + 1, 0.0);
        check(s.model, s.data, 0.0, s.q, s.u, seed, &elastic);
        mbsr_data_destroy(s.data);
        mbsr_model_destroy(s.model);
    }
    conclude(&damped, 0);
    conclude(&elastic, elastic.trees / 3);
    assert_true(damped.null > 2 * damped.trees / 3);
    assert_true(elastic.elastic > 2 * elastic.trees / 5);
}

/* ---- force elements of every kind ---- */

enum { MOST_ELEMENTS = 24 };

/* Makes an element on bodies a and b, the first two of a list that must stay; b may be the ground,
 * which is the third. na: joint coordinates of a, none where q' is not u. Returns how many it made.
 */
static int elements_between(test_rng *rng, int kind, const int list[3], int na, mbsr_force_def *def)
{
    const int a = list[0], b = list[1];
    double x[3], y[3], n[3];
    test_fill(rng, 3, x);
    test_fill(rng, 3, y);
    test_fill(rng, 3, n);
    const mbsr_spring taut = {.stiffness = 8.0,
                              .cubic = 1.0,
                              .damping = 0.2,
                              .free_length = 0.01,
                              .one_sided = 1},
                      slack = {.stiffness = 8.0, .free_length = 50.0, .one_sided = 1};
    mbsr_contact contact = {.centre = {x[0], x[1], x[2]},
                            .radius = 30.0,
                            .point = {y[0], y[1], y[2]},
                            .normal = {n[0], n[1], n[2]},
                            .stiffness = 0.02,
                            .exponent = 1.5,
                            .damping = 0.03,
                            .friction = 0.3,
                            .slip = 0.5};
    switch (kind) {
    case 0: *def = mbsr_force_spring(a, x, b, y, &taut); return 1;
    case 1: *def = mbsr_force_spring(a, x, b, y, &slack); return 1;
    case 2: *def = mbsr_force_contact(a, b, &contact); return 1;
    case 3:
        contact.radius = 0.01;
        for (int k = 0; k < 3; ++k) contact.point[k] = -100.0 * n[k];
        *def = mbsr_force_contact(a, MBSR_GROUND, &contact);
        return 1;
    case 4: *def = mbsr_force_joint_stop(a, 0, -0.01, 0.01, 20.0, 0.5); return na > 0;
    case 5: *def = mbsr_force_joint_stop(a, 0, -50.0, 50.0, 20.0, 0.5); return na > 0;
    case 6: *def = mbsr_force_joint_friction(a, 0, 0.7, 0.5); return na > 0;
    case 7: *def = mbsr_force_joint_spring(a, 0, 4.0, 1.0, 0.1); return na > 0;
    default:
        /* a web: its kind, with derivatives or without, on two bodies, one, or two and the ground
         * */
        *def =
            test_web((test_web_kind)(kind % TEST_WEB_KINDS), 1 + kind / 3 % 3, list, 0.6, kind % 2);
        return b != MBSR_GROUND;
    }
}

static mbsr_force_def orientation_spring(int body)
{
    static const double stiffness[3] = {2.0, 3.0, 5.0}, damping[3] = {0.3, 0.2, 0.4},
                        rest[4] = {1.0, 0.3, -0.2, 0.1};
    return mbsr_force_joint_rotation_spring(body, stiffness, damping, rest);
}

static void every_force_element(void **state)
{
    (void)state;
    tally group = {.name = "elements", .differenced = true};
    for (int seed = 1; seed <= TREES; ++seed) {
        test_rigid_choice choice = rigid_choice(seed);
        test_rigid_tree tree;
        mbsr_force_def elements[MOST_ELEMENTS + 1];
        int lists[MOST_ELEMENTS][3];
        test_rng rng = test_seed((uint64_t)seed + 1000);
        choice.bodies = 3 + seed % 5;
        choice.tables = seed % 5 == 0;
        if (seed % 3 == 0) choice.massless = 0.3, choice.points = 0.4, choice.forces = 2;
        test_rigid_tree_make(&tree, choice);
        for (int tries = 0; tries < MOST_ELEMENTS && choice.element_count < 8; ++tries) {
            int *list = lists[tries], nq, n, kind = (seed + tries) % 24;
            /* what mixes bodies and joints is not for vector code */
            if (kind > 7 && seed % 2 && kind % TEST_WEB_KINDS == TEST_WEB_ALL) continue;
            list[0] = test_integer(&rng, 0, choice.bodies - 1);
            list[1] = test_integer(&rng, -1, choice.bodies - 1);
            list[2] = MBSR_GROUND;
            if (list[0] == list[1]) continue;
            assert_ok(mbsr_body_coordinates(tree.model, list[0], NULL, &nq, NULL, &n), NULL);
            if (nq == n + 1 && tries % 2)
                elements[choice.element_count++] = orientation_spring(list[0]);
            else if (nq == n && n > 0 && kind == 3)
                elements[choice.element_count++] =
                    mbsr_force_joint_cubic_spring(list[0], n - 1, 2.0, 3.0, 0.5, 0.2);
            else
                choice.element_count += elements_between(&rng, kind, list, nq == n ? n : 0,
                                                         elements + choice.element_count);
        }
        if (seed % 4 == 0)
            elements[choice.element_count++] = test_web_everywhere(0.4, seed % 8 == 0);
        choice.elements = elements;
        test_rigid_tree_free(&tree);
        rigid(choice, &group);
    }
    conclude(&group, (TREES + 20) / 20);
    assert_true(group.null > TREES / 9 && group.across > 2 * TREES / 3 && group.swept > TREES / 8);
}

/* ---- what is left out without the correction ---- */

/* An element on one body: what a web on three feels there when the others do not move. */
typedef struct frozen {
    mbsr_force_def web;
    int k;
    double *p[3], *V[3], *q[3], *u[3];
    int n[3], nq[3];
} frozen;

static int feel(const mbsr_force_args *args)
{
    const frozen *z = args->force->user;
    double f[6], tau[6];
    mbsr_force_body body[3];
    const mbsr_force_args inner = {.force = &z->web, .t = args->t, .bodies = 3, .body = body};
    for (int l = 0; l < 3; ++l) {
        body[l] = *args->body;
        if (l == z->k) continue;
        body[l].p = z->p[l], body[l].V = z->V[l], body[l].q = z->q[l], body[l].u = z->u[l];
        body[l].n = z->n[l], body[l].nq = z->nq[l];
        body[l].f = f, body[l].tau = tau;
    }
    return z->web.table->evaluate(&inner);
}

static const mbsr_force_table frozen_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "frozen", .evaluate = feel};

/* What the web on bodies 0, 2 and 4 of a chain reads at a state. */
static void freeze(const test_newton_state *s, frozen *z)
{
    const double *q = s->y, *u = s->y + s->nq + s->nu;
    assert_ok(mbsr_stage_positions(s->model, s->data, s->t, q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, u), mbsr_data_error(s->data));
    for (int l = 0; l < 3; ++l) {
        int at_q, at_u;
        assert_ok(mbsr_body_coordinates(s->model, 2 * l, &at_q, z->nq + l, &at_u, z->n + l), NULL);
        z->p[l] = calloc(12 + 6 + 7 + 6, sizeof(double));
        z->V[l] = z->p[l] + 12, z->q[l] = z->V[l] + 6, z->u[l] = z->q[l] + 7;
        assert_ok(mbsr_body_pose(s->model, s->data, 2 * l, z->p[l]), NULL);
        assert_ok(mbsr_body_twist(s->model, s->data, 2 * l, z->V[l]), NULL);
        for (int k = 0; k < z->nq[l]; ++k) z->q[l][k] = q[at_q + k];
        for (int k = 0; k < z->n[l]; ++k) z->u[l][k] = u[at_u + k];
    }
}

static int nothing(void *user, double t, int n, double *f)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) f[k] = 0.0;
    return MBSR_OK;
}

static void the_tree_alone_holds_other_bodies_still(void **state)
{
    (void)state;
    static const int bodies[3] = {0, 2, 4};
    int left_out = 0;
    for (int seed = 1; seed <= 20; ++seed) {
        test_rigid_choice choice = {
            .seed = (uint64_t)seed, .bodies = 6, .many = 0.5, .length = 0.5, .element_count = 4};
        test_rigid_tree tree, held;
        test_newton_state s, reference;
        mbsr_newton_info info;
        const mbsr_force_def web =
            test_web((test_web_kind)(seed % TEST_WEB_KINDS), 3, bodies, 2.0, seed / 3 % 2);
        frozen z[3];
        /* what acts on the other bodies keeps bodies on welds apart, which would make neighbours */
        mbsr_force_def elements[6] = {web};
        for (int l = 0; l < 3; ++l) elements[1 + l] = mbsr_force_applied(2 * l + 1, nothing, NULL);
        choice.elements = elements;
        test_rigid_tree_make(&tree, choice);
        assert_ok(test_newton_start(&s, tree.model, tree.data, 0.4, tree.q, tree.u, NULL), NULL);
        for (int l = 0; l < 3; ++l) {
            z[l] = (frozen){.web = web, .k = l};
            freeze(&s, z + l);
            elements[l] = mbsr_force_custom(&frozen_table, 1, bodies + l, z + l);
            elements[3 + l] = mbsr_force_applied(2 * l + 1, nothing, NULL);
        }
        choice.element_count = 6;
        test_rigid_tree_make(&held, choice);
        assert_ok(test_newton_start(&reference, held.model, held.data, 0.4, held.q, held.u, NULL),
                  NULL);
        assert_ok(test_newton_matrices(&reference, held.model, held.data),
                  mbsr_data_error(held.data));

        mbsr_newton *newton = make_solver(tree.model, MBSR_NEWTON_TREE, 0, 0);
        double *r = calloc(2 * (size_t)s.n + 1, sizeof *r), *x = r + s.n;
        test_rng rng = test_seed((uint64_t)seed);
        test_fill(&rng, s.n, r);
        solve(newton, &s, 50.0, r, x);
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        assert_int_equal(info.exact, !info.vector_code);
        assert_int_equal(info.across, 1);
        left_out += info.vector_code;
        if (info.exact) assert_ok(test_newton_matrices(&s, tree.model, tree.data), NULL);
        const test_newton_errors e = test_newton_compare(info.exact ? &s : &reference, 50.0, r, x);
        assert_less(e.net_row, 1e-8);
        assert_less(e.net_delta, 1e-7);

        free(r);
        mbsr_newton_destroy(newton);
        test_newton_free(&s), test_newton_free(&reference);
        test_rigid_tree_free(&tree), test_rigid_tree_free(&held);
        for (int l = 0; l < 9; ++l) free(z[l / 3].p[l % 3]);
    }
    assert_in_range(left_out, 10, 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rigid_bodies),
        cmocka_unit_test(bodies_without_mass),
        cmocka_unit_test(locked_joints_added_masses_and_joints_without_derivatives),
        cmocka_unit_test(mass_points_in_several_units),
        cmocka_unit_test(general_bodies),
        cmocka_unit_test(bodies_in_the_plane),
        cmocka_unit_test(bodies_of_all_kinds),
        cmocka_unit_test(kinds_in_any_order),
        cmocka_unit_test(chains_of_bodies_without_mass),
        cmocka_unit_test(every_force_element),
        cmocka_unit_test(the_tree_alone_holds_other_bodies_still),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
