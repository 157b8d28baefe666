/* The data object: no result depends on what was in memory before; threads; wrong use.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "assembly/data.h"
#include "tree.h"
#include "algebra/numbers.h"

#include <mbsrank/driver.h>

#include <pthread.h>
#include <stdlib.h>

/* ---- the same results whatever was there before ---------------------------------------------- */

/* All results at one state, one behind the other. */
typedef struct results {
    size_t size;
    double *x;
} results;

typedef struct input {
    double *y, *yp, *tau;
} input;

static results make_results(const mbsr_model *m)
{
    const size_t n = (size_t)mbsr_dae_size(m, MBSR_DAE_RECURSIVE), nu = (size_t)mbsr_model_nu(m);
    const size_t bodies = (size_t)mbsr_model_bodies(m);
    const size_t size = 2 * n + 3 * nu + nu * nu + 2 + bodies * (2 * TEST_MAX_D + 3) + 2;
    return (results){size, calloc(size, sizeof(double))};
}

static input make_input(const mbsr_model *m, uint64_t seed)
{
    const int n = mbsr_dae_size(m, MBSR_DAE_RECURSIVE);
    const input in = {calloc((size_t)n, sizeof(double)), calloc((size_t)n, sizeof(double)),
                      calloc((size_t)n, sizeof(double))};
    test_rng rng = test_seed(seed);
    test_fill(&rng, n, in.y);
    test_fill(&rng, n, in.yp);
    test_fill(&rng, n, in.tau);
    return in;
}

static void free_input(input in)
{
    free(in.y);
    free(in.yp);
    free(in.tau);
}

/* Pose, twist and rank of every body. */
static double *per_body(const mbsr_model *m, mbsr_data *d, double *x)
{
    for (int id = 0; id < mbsr_model_bodies(m); ++id) {
        mbsr_rank_info info;
        assert_int_equal(mbsr_body_pose(m, d, id, x), 0);
        assert_int_equal(mbsr_body_twist(m, d, id, x + TEST_MAX_D), 0);
        assert_int_equal(mbsr_body_rank(m, d, id, &info), 0);
        x += 2 * TEST_MAX_D;
        *x++ = info.rank;
        *x++ = info.smallest_kept;
        *x++ = info.largest_dropped;
    }
    *x++ = mbsr_total_rank(m, d);
    return x;
}

/* Fills `out`; with `poison` everything the data holds is made NaN before each evaluation. */
static void evaluate(const mbsr_model *m, mbsr_data *d, input in, int poison, results out)
{
    const int n = mbsr_dae_size(m, MBSR_DAE_RECURSIVE), nq = mbsr_model_nq(m),
              nu = mbsr_model_nu(m);
    const double *q = in.y, *u = in.y + nq, *udot = in.yp + nq;
    double *x = out.x;
    memset(out.x, 0, out.size * sizeof *out.x);
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_INVERSE_DYNAMICS, 0.3, in.y, in.yp, x), 0);
    x += n;
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_inverse_dynamics(m, d, 0.3, q, u, udot, NULL, x), 0);
    x += nu;
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_stage_positions(m, d, 0.3, q), 0);
    assert_int_equal(mbsr_mass_matrix(m, d, x), 0);
    x += nu * nu;
    if (poison) mbsri_data_poison(d);
    const int status = mbsr_forward_dynamics(m, d, 0.3, q, u, in.tau, x);
    assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
    x += nu;
    *x++ = status;
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_recursive_residual(m, d, 0.3, q, u, udot, in.tau, x), 0);
    x += nu;
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_stage_positions(m, d, 0.3, q), 0);
    assert_int_equal(mbsr_stage_velocities(m, d, u), 0);
    assert_int_equal(mbsr_energy(m, d, x, x + 1), 0);
    x += 2;
    if (poison) mbsri_data_poison(d);
    assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.3, in.y, in.yp, x), 0);
    x += n;
    x = per_body(m, d, x);
    assert_int_equal((size_t)(x - out.x), out.size);
}

static const test_tree_opt mixed = {.bodies = 15,
                                    .max_d = 5,
                                    .welds = 1,
                                    .deficient = 0.4,
                                    .bend = 0.3,
                                    .forces = 1,
                                    .moving_root = 1,
                                    .shuffle = 1};

static test_tree make_tree(uint64_t seed)
{
    test_tree tree;
    test_tree_opt opt = mixed;
    opt.seed = seed;
    test_tree_make(&tree, opt);
    return tree;
}

static void results_do_not_depend_on_what_was_in_memory(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
        test_tree tree = make_tree(seed);
        const mbsr_model *m = tree.model;
        const input in = make_input(m, seed), other = make_input(m, seed + 100);
        results fresh = make_results(m), again = make_results(m);
        evaluate(m, tree.data, in, 0, fresh);
        assert_true(mbsri_finite(fresh.size, fresh.x));

        /* poisoned before every evaluation */
        evaluate(m, tree.data, in, 1, again);
        assert_memory_equal(fresh.x, again.x, fresh.size * sizeof(double));
        /* after another state */
        evaluate(m, tree.data, other, 0, again);
        assert_memory_not_equal(fresh.x, again.x, fresh.size * sizeof(double));
        evaluate(m, tree.data, in, 0, again);
        assert_memory_equal(fresh.x, again.x, fresh.size * sizeof(double));
        /* in memory of ones and of zeros */
        const size_t size = mbsr_data_size(m);
        void *memory = aligned_alloc(MBSR_DATA_ALIGNMENT, size);
        for (int fill = 0; fill < 2; ++fill) {
            mbsr_data *d;
            memset(memory, fill ? 0xff : 0, size);
            assert_int_equal(mbsr_data_init(m, memory, size, &d, NULL), 0);
            evaluate(m, d, in, 0, again);
            assert_memory_equal(fresh.x, again.x, fresh.size * sizeof(double));
        }
        free(memory);
        free(fresh.x);
        free(again.x);
        free_input(in);
        free_input(other);
        test_tree_free(&tree);
    }
}

/* ---- threads --------------------------------------------------------------------------------- */

typedef struct job {
    const mbsr_model *model;
    mbsr_data *data;
    input in;
    results out;
} job;

enum { ROUNDS = 200 };

static void *run(void *argument)
{
    job *w = argument;
    const int n = mbsr_dae_size(w->model, MBSR_DAE_RECURSIVE);
    w->out.x[n] = 0.0;
    for (int round = 0; round < ROUNDS; ++round) {
        const int status = mbsr_dae_residual(w->model, w->data, MBSR_DAE_RECURSIVE, 0.001 * round,
                                             w->in.y, w->in.yp, w->out.x);
        for (int k = 0; k < n; ++k) w->out.x[n] += w->out.x[k] * (k + 1 + round);
        w->out.x[n] += status;
    }
    return NULL;
}

static void two_threads_share_a_model(void **state)
{
    (void)state;
    test_tree tree = make_tree(3);
    job alone[2], together[2];
    pthread_t thread[2];
    for (int k = 0; k < 2; ++k) {
        alone[k] = (job){tree.model, NULL, make_input(tree.model, (uint64_t)k + 1),
                         make_results(tree.model)};
        together[k] = (job){tree.model, NULL, alone[k].in, make_results(tree.model)};
        assert_int_equal(mbsr_data_create(tree.model, &alone[k].data, NULL), 0);
        assert_int_equal(mbsr_data_create(tree.model, &together[k].data, NULL), 0);
        run(alone + k);
    }
    for (int k = 0; k < 2; ++k)
        assert_int_equal(pthread_create(thread + k, NULL, run, together + k), 0);
    for (int k = 0; k < 2; ++k) assert_int_equal(pthread_join(thread[k], NULL), 0);
    assert_memory_not_equal(alone[0].out.x, alone[1].out.x, alone[0].out.size * sizeof(double));
    for (int k = 0; k < 2; ++k) {
        assert_memory_equal(alone[k].out.x, together[k].out.x, alone[k].out.size * sizeof(double));
        free_input(alone[k].in);
        free(alone[k].out.x);
        free(together[k].out.x);
        mbsr_data_destroy(alone[k].data);
        mbsr_data_destroy(together[k].data);
    }
    test_tree_free(&tree);
}

/* ---- wrong use ------------------------------------------------------------------------------- */

static void refused_by_all(const mbsr_model *m, mbsr_data *d, int status, const char *words)
{
    double x[64] = {0};
    const mbsr_dae_form form = MBSR_DAE_RECURSIVE;
    mbsr_rank_info info;
    const mbsr_error *e = mbsr_data_error(d);
    assert_refused(mbsr_stage_positions(m, d, 0, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_positions|");
    assert_contains(e->text, words);
    assert_refused(mbsr_stage_velocities(m, d, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_velocities|");
    assert_refused(mbsr_stage_forces(m, d, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_forces");
    assert_refused(mbsr_stage_backward(m, d), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_backward");
    assert_refused(mbsr_stage_forward(m, d, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_stage_forward");
    assert_refused(mbsr_coordinate_rates(m, d, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_coordinate_rates");
    assert_refused(mbsr_recursive_residual(m, d, 0, x, x, x, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_recursive_residual");
    assert_refused(mbsr_inverse_dynamics(m, d, 0, x, x, x, NULL, x), e, status, MBSR_NONE,
                   MBSR_NONE, "mbsr_inverse_dynamics");
    assert_refused(mbsr_forward_dynamics(m, d, 0, x, x, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_forward_dynamics");
    assert_refused(mbsr_mass_matrix(m, d, x), e, status, MBSR_NONE, MBSR_NONE, "mbsr_mass_matrix");
    assert_refused(mbsr_energy(m, d, x, x), e, status, MBSR_NONE, MBSR_NONE, "mbsr_energy");
    assert_refused(mbsr_body_pose(m, d, 0, x), e, status, MBSR_NONE, MBSR_NONE, "mbsr_body_pose");
    assert_refused(mbsr_body_twist(m, d, 0, x), e, status, MBSR_NONE, MBSR_NONE, "mbsr_body_twist");
    assert_refused(mbsr_body_rank(m, d, 0, &info), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_body_rank");
    assert_refused(mbsr_dae_pack(m, d, form, 0, x, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_dae_pack");
    assert_refused(mbsr_dae_unpack(m, d, form, 0, x, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_dae_unpack");
    assert_refused(mbsr_dae_residual(m, d, form, 0, x, x, x), e, status, MBSR_NONE, MBSR_NONE,
                   "mbsr_dae_residual");
    assert_refused(mbsr_dae_consistent(m, d, form, 0, x, x, NULL, NULL), e, status, MBSR_NONE,
                   MBSR_NONE, "mbsr_dae_consistent");
    assert_int_equal(mbsr_total_rank(m, d), -1);
}

static mbsr_model *one_point(mbsr_data **d)
{
    mbsr_model *m;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "bead";
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(2.0);
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    assert_int_equal(mbsr_data_create(m, d, NULL), 0);
    return m;
}

static void data_of_another_model_are_refused_everywhere(void **state)
{
    (void)state;
    mbsr_data *d, *other_data;
    mbsr_model *m = one_point(&d), *other = one_point(&other_data);
    refused_by_all(other, d, MBSR_ERR_MISMATCH, "another model");
    refused_by_all(NULL, d, MBSR_ERR_NULL, "NULL");
    double x[4] = {0};
    assert_int_equal(mbsr_stage_positions(m, NULL, 0, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_dae_residual(m, NULL, MBSR_DAE_RECURSIVE, 0, x, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_total_rank(m, NULL), -1);
    assert_int_equal(mbsr_data_error(NULL)->status, MBSR_ERR_NULL);
    mbsr_data_destroy(d);
    mbsr_data_destroy(other_data);
    mbsr_model_destroy(m);
    mbsr_model_destroy(other);
}

static void required_pointers_are_checked(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = one_point(&d);
    const mbsr_error *e = mbsr_data_error(d);
    double x[4] = {0}, y[4] = {0}, z[4] = {0};
#define NULL_REFUSED(call) assert_refused((call), e, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "NULL")
    const mbsr_dae_form form = MBSR_DAE_RECURSIVE;
    assert_int_equal(mbsr_recursive_residual(m, d, 0, x, x, x, NULL, y), 0);
    NULL_REFUSED(mbsr_stage_positions(m, d, 0, NULL));
    assert_int_equal(mbsr_stage_positions(m, d, 0, x), 0);
    NULL_REFUSED(mbsr_stage_velocities(m, d, NULL));
    NULL_REFUSED(mbsr_recursive_residual(m, d, 0, NULL, x, x, x, y));
    NULL_REFUSED(mbsr_recursive_residual(m, d, 0, x, NULL, x, x, y));
    NULL_REFUSED(mbsr_recursive_residual(m, d, 0, x, x, NULL, x, y));
    NULL_REFUSED(mbsr_recursive_residual(m, d, 0, x, x, x, x, NULL));
    NULL_REFUSED(mbsr_inverse_dynamics(m, d, 0, x, x, x, NULL, NULL));
    NULL_REFUSED(mbsr_inverse_dynamics(m, d, 0, x, x, NULL, NULL, y));
    NULL_REFUSED(mbsr_inverse_dynamics(m, d, 0, x, NULL, x, NULL, y));
    NULL_REFUSED(mbsr_inverse_dynamics(m, d, 0, NULL, x, x, NULL, y));
    NULL_REFUSED(mbsr_forward_dynamics(m, d, 0, x, x, x, NULL));
    NULL_REFUSED(mbsr_forward_dynamics(m, d, 0, x, NULL, x, y));
    NULL_REFUSED(mbsr_forward_dynamics(m, d, 0, NULL, x, x, y));
    NULL_REFUSED(mbsr_dae_residual(m, d, form, 0, NULL, x, y));
    NULL_REFUSED(mbsr_dae_residual(m, d, form, 0, x, NULL, y));
    NULL_REFUSED(mbsr_dae_residual(m, d, form, 0, x, x, NULL));
    NULL_REFUSED(mbsr_dae_pack(m, d, form, 0, NULL, x, y));
    NULL_REFUSED(mbsr_dae_pack(m, d, form, 0, x, NULL, y));
    NULL_REFUSED(mbsr_dae_pack(m, d, form, 0, x, z, NULL));
    NULL_REFUSED(mbsr_dae_unpack(m, d, form, 0, NULL, z, y));
    NULL_REFUSED(mbsr_dae_unpack(m, d, form, 0, x, NULL, y));
    NULL_REFUSED(mbsr_dae_unpack(m, d, form, 0, x, z, NULL));
    NULL_REFUSED(mbsr_dae_consistent(m, d, form, 0, NULL, z, NULL, NULL));
    NULL_REFUSED(mbsr_dae_consistent(m, d, form, 0, z, NULL, NULL, NULL));
    assert_int_equal(mbsr_recursive_residual(m, d, 0, x, x, x, NULL, y), 0);
    NULL_REFUSED(mbsr_stage_forward(m, d, NULL, y));
    NULL_REFUSED(mbsr_stage_forward(m, d, x, NULL));
    NULL_REFUSED(mbsr_mass_matrix(m, d, NULL));
    NULL_REFUSED(mbsr_coordinate_rates(m, d, NULL));
    NULL_REFUSED(mbsr_body_pose(m, d, 0, NULL));
    NULL_REFUSED(mbsr_body_twist(m, d, 0, NULL));
    NULL_REFUSED(mbsr_body_rank(m, d, 0, NULL));
#undef NULL_REFUSED
    assert_int_equal(mbsr_energy(m, d, NULL, NULL), 0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Every stage in turn: what comes later is refused and names the missing call. */
static void stages_must_come_in_their_order(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = one_point(&d);
    double x[4] = {0};
    mbsr_rank_info info;
    const mbsr_error *e = mbsr_data_error(d);
#define MISSING(call, words)                                                                       \
    assert_refused((call), e, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, words)
    for (int stage = 0; stage < 5; ++stage) {
        for (int given = 0; given <= 4;
             ++given) { /* an earlier stage called again throws later ones away */
            if (stage < given) continue;
            if (stage >= 1) assert_int_equal(mbsr_stage_positions(m, d, 0, x), 0);
            if (stage >= 2) assert_int_equal(mbsr_stage_velocities(m, d, x), 0);
            if (stage >= 3) assert_int_equal(mbsr_stage_forces(m, d, NULL), 0);
            if (stage >= 4) assert_int_equal(mbsr_stage_backward(m, d), 0);
            if (given == 1) assert_int_equal(mbsr_stage_positions(m, d, 0, x), 0);
            if (given == 2) assert_int_equal(mbsr_stage_velocities(m, d, x), 0);
            if (given == 3) assert_int_equal(mbsr_stage_forces(m, d, NULL), 0);
            if (given == 4) assert_int_equal(mbsr_stage_backward(m, d), 0);
            const int at = given ? given : stage;
            if (at < 1) {
                MISSING(mbsr_stage_velocities(m, d, x),
                        "mbsr_stage_velocities: call mbsr_stage_positions first");
                MISSING(mbsr_mass_matrix(m, d, x), "mbsr_mass_matrix|mbsr_stage_positions");
                MISSING(mbsr_body_pose(m, d, 0, x), "mbsr_body_pose|mbsr_stage_positions");
                MISSING(mbsr_body_pose(m, d, MBSR_GROUND, x),
                        "mbsr_body_pose|mbsr_stage_positions");
            }
            if (at < 2) {
                MISSING(mbsr_stage_forces(m, d, x), "mbsr_stage_forces|mbsr_stage_velocities");
                MISSING(mbsr_energy(m, d, x, x), "mbsr_energy|mbsr_stage_velocities");
                MISSING(mbsr_coordinate_rates(m, d, x),
                        "mbsr_coordinate_rates|mbsr_stage_velocities");
                MISSING(mbsr_body_twist(m, d, 0, x), "mbsr_body_twist|mbsr_stage_velocities");
            }
            if (at < 3)
                MISSING(mbsr_stage_backward(m, d),
                        "mbsr_stage_backward: call mbsr_stage_forces first");
            if (at < 4) {
                MISSING(mbsr_stage_forward(m, d, x, x + 2),
                        "mbsr_stage_forward|mbsr_stage_backward");
                MISSING(mbsr_body_rank(m, d, 0, &info), "mbsr_body_rank|mbsr_stage_backward");
                assert_int_equal(mbsr_total_rank(m, d), -1);
            } else {
                assert_int_equal(mbsr_total_rank(m, d), 2);
            }
        }
    }
#undef MISSING
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void a_failed_stage_leaves_no_later_results(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = one_point(&d);
    double x[4] = {0}, bad[2] = {0.0, NAN};
    assert_int_equal(mbsr_recursive_residual(m, d, 0, x, x, x, NULL, x + 2), 0);
    assert_refused(mbsr_stage_velocities(m, d, bad), mbsr_data_error(d), MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, "mbsr_stage_velocities: u is not finite");
    assert_int_equal(mbsr_body_pose(m, d, 0, x), 0);
    assert_int_equal(mbsr_body_twist(m, d, 0, x), MBSR_ERR_SEQUENCE);
    assert_refused(mbsr_stage_positions(m, d, 0, bad), mbsr_data_error(d), MBSR_NOT_FINITE,
                   MBSR_NONE, MBSR_NONE, "mbsr_stage_positions: t or q is not finite");
    assert_int_equal(mbsr_body_pose(m, d, 0, x), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stage_positions(m, d, INFINITY, x), MBSR_NOT_FINITE);
    /* the mass matrix uses the memory of mbsr_stage_backward, which must then run again */
    double mass[4];
    assert_int_equal(mbsr_recursive_residual(m, d, 0, x, x, x, NULL, x + 2), 0);
    assert_int_equal(mbsr_mass_matrix(m, d, mass), 0);
    assert_int_equal(mbsr_stage_forward(m, d, x, x + 2), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stage_backward(m, d), 0);
    assert_int_equal(mbsr_stage_forward(m, d, x, x + 2), 0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static int sliding_root(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    p[0] = 2.0 * t, V[0] = 2.0, A[0] = 0.0, p[2] = 0.5, V[2] = 0.25;
    return 0;
}

static void poses_of_ground_and_of_unknown_bodies(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = one_point(&d);
    double q[2] = {3.0, 4.0}, x[3] = {7, 7, 7};
    mbsr_rank_info info;
    assert_int_equal(mbsr_recursive_residual(m, d, 0, q, q, q, NULL, x), 0);
    x[0] = x[1] = 7.0;
    assert_int_equal(mbsr_body_pose(m, d, MBSR_GROUND, x),
                     0); /* nothing to write: the root is at rest */
    assert_int_equal(mbsr_body_twist(m, d, MBSR_GROUND, x), 0);
    assert_close(x[0], 7.0, 0.0);
    static const int unknown[] = {1, MBSR_NONE, -77, 1 << 30};
    for (int k = 0; k < 4; ++k) {
        const mbsr_error *e = mbsr_data_error(d);
        assert_refused(mbsr_body_pose(m, d, unknown[k], x), e, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                       "mbsr_body_pose|no body");
        assert_refused(mbsr_body_twist(m, d, unknown[k], x), e, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                       "mbsr_body_twist");
        assert_refused(mbsr_body_rank(m, d, unknown[k], &info), e, MBSR_ERR_ID, MBSR_NONE,
                       MBSR_NONE, "mbsr_body_rank");
    }
    assert_refused(mbsr_body_rank(m, d, MBSR_GROUND, &info), mbsr_data_error(d), MBSR_ERR_ID,
                   MBSR_NONE, MBSR_NONE, "no body -1");
    assert_int_equal(mbsr_body_pose(m, d, 0, x), 0);
    assert_close(x[1], 4.0, 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);

    mbsr_model_def def = mbsr_default_model_def();
    def.root = mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, sliding_root, NULL);
    assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    assert_int_equal(mbsr_stage_positions(m, d, 1.5, q), 0);
    assert_int_equal(mbsr_stage_velocities(m, d, q), 0);
    assert_int_equal(mbsr_body_pose(m, d, MBSR_GROUND, x), 0);
    assert_true(x[0] == 3.0 && x[1] == 0.0 && x[2] == 0.5);
    assert_int_equal(mbsr_body_twist(m, d, MBSR_GROUND, x), 0);
    assert_true(x[0] == 2.0 && x[1] == 0.0 && x[2] == 0.25);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void a_new_data_object_has_no_error(void **state)
{
    (void)state;
    mbsr_data *d;
    mbsr_model *m = one_point(&d);
    const mbsr_error *e = mbsr_data_error(d);
    assert_int_equal(e->status, MBSR_OK);
    assert_int_equal(e->body, MBSR_NONE);
    assert_int_equal(e->force, MBSR_NONE);
    assert_string_equal(e->text, "");
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_do_not_depend_on_what_was_in_memory),
        cmocka_unit_test(two_threads_share_a_model),
        cmocka_unit_test(data_of_another_model_are_refused_everywhere),
        cmocka_unit_test(required_pointers_are_checked),
        cmocka_unit_test(stages_must_come_in_their_order),
        cmocka_unit_test(a_failed_stage_leaves_no_later_results),
        cmocka_unit_test(poses_of_ground_and_of_unknown_bodies),
        cmocka_unit_test(a_new_data_object_has_no_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
