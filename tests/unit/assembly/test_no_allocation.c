/* After mbsr_data_init nothing on the path of a solver allocates: malloc and its relatives are
 * counted.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE /* posix_memalign */

#include "expect.h"

#include "loops.h"
#include "mixed.h"
#include "tree.h"

#include <mbsrank/driver.h>

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||                         \
    __has_feature(memory_sanitizer)
#define SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#endif

/* glibc keeps its own allocator reachable under these names; elsewhere the test is skipped. */
#if defined(__GLIBC__) && !defined(SANITIZED)
#define COUNTED 1
#else
#define COUNTED 0
#endif

/* volatile: compilers know that malloc changes no variable of the program */
static volatile long allocations, releases;

#if COUNTED

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *memory);

void *malloc(size_t size)
{
    ++allocations;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    ++allocations;
    return __libc_calloc(count, size);
}

void *realloc(void *memory, size_t size)
{
    ++allocations;
    return __libc_realloc(memory, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    ++allocations;
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size)
{
    ++allocations;
    *memory = __libc_memalign(alignment, size);
    return *memory ? 0 : ENOMEM;
}

void free(void *memory)
{
    if (memory) ++releases;
    __libc_free(memory);
}

#endif

/* ---- what runs between two counts ------------------------------------------------------------ */

typedef struct work {
    test_tree tree;
    mbsr_data *data; /* in the caller's memory */
    void *memory;
    mbsr_ode *ode;
    mbsr_newton *newton;
    double *y, *yp, *F, *x, *mass;
    int size, nq, nu;
} work;

/* Trees with blocks of several joint coordinates, rank-deficient ones among them, general K,
 * forces. */
static void prepare(work *w, uint64_t seed)
{
    test_tree_make(&w->tree, (test_tree_opt){.seed = seed,
                                             .bodies = 12,
                                             .max_d = 6,
                                             .welds = 1,
                                             .deficient = 0.5,
                                             .bend = 0.3,
                                             .forces = 1,
                                             .moving_root = 1,
                                             .shuffle = 1});
    const mbsr_model *m = w->tree.model;
    w->nq = mbsr_model_nq(m);
    w->nu = mbsr_model_nu(m);
    w->size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM); /* the longest */
    w->y = calloc((size_t)w->size, sizeof(double));
    w->yp = calloc((size_t)w->size, sizeof(double));
    w->F = calloc((size_t)w->size, sizeof(double));
    w->x = calloc((size_t)w->size, sizeof(double));
    w->mass = calloc((size_t)(w->nu * (w->nu + TEST_MAX_D)), sizeof(double));
    test_rng rng = test_seed(seed);
    test_fill(&rng, w->size, w->y);
    test_fill(&rng, w->size, w->yp);
    w->memory = aligned_alloc(MBSR_DATA_ALIGNMENT, mbsr_data_size(m));
    assert_int_equal(mbsr_data_init(m, w->memory, mbsr_data_size(m), &w->data, NULL), 0);
    assert_int_equal(mbsr_ode_create(m, w->data, 0.3, w->y, w->y + w->nq, &w->ode), 0);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.method = MBSR_NEWTON_CORRECTED;
    opt.products = 1;
    assert_int_equal(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &w->newton, NULL), 0);
}

static void release(work *w)
{
    free(w->y);
    free(w->yp);
    free(w->F);
    free(w->x);
    mbsr_ode_destroy(w->ode);
    mbsr_newton_destroy(w->newton);
    free(w->mass);
    free(w->memory);
    test_tree_free(&w->tree);
}

/* What can be asked of a state: results per body and of the whole tree. `matrix` has room for d and
 * for nu rows of nu. Returns a sum of absolute statuses. */
static int ask(const mbsr_model *m, mbsr_data *d, double t, double *q, const double *u,
               const double *udot, double *x, double *matrix)
{
    double vector[TEST_MAX_D], mass, momentum[6];
    int bad = 0;
    bad += abs(mbsr_normalise(m, d, q));
    bad += abs(mbsr_bias_forces(m, d, t, q, u, x));
    bad += abs(mbsr_stage_accelerations(m, d, udot));
    for (int id = MBSR_GROUND; id < mbsr_model_bodies(m); ++id) {
        bad += abs(mbsr_body_acceleration(m, d, id, vector));
        bad += abs(mbsr_joint_reaction(m, d, id, vector));
        bad += abs(mbsr_body_jacobian(m, d, id, matrix));
    }
    const int status = mbsr_tree_momentum(m, d, NULL, &mass, vector, momentum);
    bad += status == MBSR_ERR_SPACE ? 0 : abs(status); /* with its text */
    bad += abs(mbsr_momenta(m, d, x));
    bad += abs(mbsr_coordinate_rates(m, d, x));
    bad += abs(mbsr_mass_matrix(m, d, matrix));
    return bad;
}

/* Everything a solver calls; returns a sum of absolute statuses, 0 if all succeeded. */
static int evaluate(work *w)
{
    const mbsr_model *m = w->tree.model;
    mbsr_data *d = w->data;
    const double *q = w->y, *u = w->y + w->nq, *udot = w->yp + w->nq;
    double T, E, pose[TEST_MAX_D];
    int bad = 0;
    bad += abs(mbsr_dae_residual(m, d, MBSR_DAE_INVERSE_DYNAMICS, 0.3, w->y, w->yp, w->F));
    bad += abs(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.3, w->y, w->yp, w->F));
    bad += abs(mbsr_recursive_residual(m, d, 0.3, q, u, udot, udot, w->F));
    for (int id = 0; id < mbsr_model_bodies(m); ++id) {
        mbsr_rank_info info;
        bad += abs(mbsr_body_rank(m, d, id, &info));
        bad += abs(mbsr_body_pose(m, d, id, pose));
        bad += abs(mbsr_body_twist(m, d, id, pose));
    }
    bad += mbsr_total_rank(m, d) < 0;
    bad += abs(mbsr_energy(m, d, &T, &E));
    bad += abs(mbsr_mass_matrix(m, d, w->mass));
    bad += abs(mbsr_inverse_dynamics(m, d, 0.3, q, u, udot, NULL, w->F));
    const int status = mbsr_forward_dynamics(m, d, 0.3, q, u, NULL, w->F);
    bad += status == MBSR_UNDETERMINED ? 0 : abs(status);
    bad += abs(mbsr_dae_pack(m, d, MBSR_DAE_RECURSIVE, 0.3, q, u, w->F));
    bad += abs(mbsr_dae_unpack(m, d, MBSR_DAE_RECURSIVE, 0.3, w->y, w->F, w->F + w->nq));
    bad += abs(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.3, w->y, w->yp, w->F));
    bad += abs(mbsr_dae_pack(m, d, MBSR_DAE_INDEX1, 0.3, q, u, w->x));
    bad += abs(mbsr_dae_residual(m, d, MBSR_DAE_INDEX1, 0.3, w->x, w->yp, w->F));
    bad += abs(mbsr_index1_alignment(m, d, 0.3, w->x, &T));
    bad += abs(mbsr_index1_renew(m, d, 0.3, w->x, w->F, NULL));
    bad += abs(mbsr_ode_pack(w->ode, 0.3, q, u, w->x));
    bad += abs(mbsr_ode_rhs(w->ode, 0.3, w->x, w->F));
    bad += abs(mbsr_newton_factor(w->newton, d, 0.3, w->y, w->yp, 20.0));
    bad += abs(mbsr_newton_solve(w->newton, w->yp, w->F));
    bad += abs(mbsr_newton_linearise(w->newton, d, 0.3, w->y, w->yp, 20.0));
    bad += abs(mbsr_newton_multiply(w->newton, w->yp, w->F));
    return bad + ask(m, d, 0.3, w->y, u, udot, w->F, w->mass);
}

/* Calls that fail, with their texts. Returns how many did not. */
static int refuse(work *w)
{
    const mbsr_model *m = w->tree.model;
    mbsr_data *d = w->data;
    int good = 0;
    const double held = w->y[0], heldp = w->yp[0];
    w->y[0] = NAN;
    good += !mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.3, w->y, w->yp, w->F);
    w->y[0] = held;
    w->yp[0] = INFINITY;
    good += !mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.3, w->y, w->yp, w->F);
    w->yp[0] = heldp;
    good += !mbsr_dae_residual(m, d, (mbsr_dae_form)99, 0.3, w->y, w->yp, w->F);
    good += !mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.3, NULL, w->yp, w->F);
    good += !mbsr_stage_positions(NULL, d, 0.3, w->y);
    good += !mbsr_body_pose(m, d, 12345, w->F);
    good += !mbsr_stage_forward(m, d, w->yp, w->F);
    good += !mbsr_newton_factor(w->newton, d, 0.3, w->y, w->yp, 0.0);
    good += !mbsr_newton_solve(w->newton, w->yp, w->F);
    good += !mbsr_newton_linearise(w->newton, d, NAN, w->y, w->yp, 1.0);
    good += !mbsr_newton_multiply(w->newton, w->yp, w->F);
    w->yp[w->nq] = 1e308; /* overflows somewhere on the way */
    w->yp[w->nq + 1] = 1e308;
    (void)mbsr_inverse_dynamics(m, d, 0.3, w->y, w->y + w->nq, w->yp + w->nq, NULL, w->F);
    w->yp[w->nq] = w->yp[w->nq + 1] = 0.5;
    return good;
}

static void counting_sees_an_allocation(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    const long before = allocations, released = releases;
    void *volatile memory = malloc(10);
    free(memory);
    assert_true(allocations > before);
    assert_true(releases > released);
    memory = aligned_alloc(64, 64);
    free(memory);
    assert_true(allocations > before + 1);
}

static void no_evaluation_allocates_even_the_first(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    int deficient = 0;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        work w;
        prepare(&w, seed);
        const long before = allocations, released = releases;
        const int bad = evaluate(&w), good = refuse(&w), again = evaluate(&w);
        const long after = allocations, released_after = releases;
        assert_int_equal(after - before, 0);
        assert_int_equal(released_after - released, 0);
        assert_int_equal(bad, 0);
        assert_int_equal(good, 0);
        assert_int_equal(again, 0);
        /* the trees are what the test is about */
        assert_int_equal(
            mbsr_dae_residual(w.tree.model, w.data, MBSR_DAE_RECURSIVE, 0.3, w.y, w.yp, w.F), 0);
        for (int id = 0; id < w.tree.N; ++id) {
            mbsr_rank_info info;
            assert_int_equal(mbsr_body_rank(w.tree.model, w.data, id, &info), 0);
            deficient += info.n >= 2 && info.rank > 0 && info.rank < info.n;
        }
        release(&w);
    }
    assert_true(deficient > 3);
}

/* Bodies in space and in the plane, quaternions, driven and locked coordinates. Returns a sum of
 * absolute statuses. */
static int evaluate_mixed(mixed *s, mbsr_newton *newton, double *q, const double *u,
                          const double *udot)
{
    static const mbsr_dae_form forms[4] = {MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1, MBSR_DAE_RECURSIVE,
                                           MBSR_DAE_INVERSE_DYNAMICS};
    static double x[3 * MIXED_NQ], y[3 * MIXED_NQ], F[3 * MIXED_NQ];
    static double matrix[MIXED_NU * (MIXED_NU + TEST_MAX_D)];
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    double T, E;
    int bad = 0;
    for (int k = 0; k < 4; ++k) {
        bad += abs(mbsr_dae_pack(m, d, forms[k], 0.3, q, u, y));
        bad += abs(mbsr_dae_residual(m, d, forms[k], 0.3, y, x, F));
        bad += abs(mbsr_dae_unpack(m, d, forms[k], 0.3, y, q, F));
    }
    bad += abs(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.3, q, u, y));
    bad += abs(mbsr_newton_factor(newton, d, 0.3, y, x, 20.0));
    bad += abs(mbsr_newton_solve(newton, y, F));
    bad += abs(mbsr_newton_linearise(newton, d, 0.3, y, x, 20.0));
    bad += abs(mbsr_newton_multiply(newton, y, F));
    bad += abs(mbsr_forward_dynamics(m, d, 0.3, q, u, NULL, F));
    bad += abs(mbsr_energy(m, d, &T, &E));
    bad += abs(mbsr_inverse_dynamics(m, d, 0.3, q, u, udot, NULL, F));
    bad += ask(m, d, 0.3, q, u, udot, F, matrix);
    /* refusals, with their texts */
    bad += mbsr_body_acceleration(m, d, 99, F) != MBSR_ERR_ID;
    bad += abs(mbsr_stage_positions(m, d, 0.3, q));
    bad += mbsr_joint_reaction(m, d, 0, F) != MBSR_ERR_SEQUENCE;
    for (int k = 0; k < s->nq; ++k) x[k] = 0.0;
    bad += mbsr_normalise(m, d, x) != MBSR_ZERO_QUATERNION;
    return bad;
}

static void no_evaluation_in_space_allocates(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    for (int scene = 0; scene < MIXED_ALL; ++scene) {
        mixed s;
        double q[MIXED_NQ], u[MIXED_NU], udot[MIXED_NU];
        test_rng rng = test_seed(8);
        mixed_make(&s, (mixed_scene)scene);
        test_fill(&rng, s.nq, q);
        test_fill(&rng, s.nu, u);
        test_fill(&rng, s.nu, udot);
        mbsr_newton *newton;
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        opt.products = 1;
        assert_int_equal(mbsr_newton_create(s.model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), 0);
        const long before = allocations, released = releases;
        const int bad = evaluate_mixed(&s, newton, q, u, udot);
        const long after = allocations, released_after = releases;
        assert_int_equal(after - before, 0);
        assert_int_equal(released_after - released, 0);
        assert_int_equal(bad, 0);
        mbsr_newton_destroy(newton);
        mixed_free(&s);
    }
}

/* Newton systems of a four-bar with a massless coupler, and of one that is singular. */
static void no_newton_system_with_loops_allocates(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    static const double q[] = {1.2, -0.9, 1.3}, u[] = {3.0, 0.0, 1.0};
    loops s;
    double y[64], yp[64] = {0.0}, r[64];
    mbsr_newton *newton;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "coupler", a, 1.0, 0.0, 0.0, 2.5),
              c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_pin(&s, "pin again", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(&s);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    assert_ok(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    const int dropped[4] = {0, 0, 1, 1}, none[4] = {0};
    const long before = allocations, released = releases;
    const int singular = mbsr_newton_factor(newton, s.d, 0.0, y, yp, 20.0);
    int bad = abs(mbsr_closures_set_redundant(s.m, s.d, dropped));
    bad += abs(mbsr_newton_factor(newton, s.d, 0.0, y, yp, 20.0));
    bad += abs(mbsr_newton_solve(newton, y, r));
    bad += abs(mbsr_newton_linearise(newton, s.d, 0.0, y, yp, 20.0));
    bad += abs(mbsr_newton_multiply(newton, y, r));
    bad += abs(mbsr_closures_set_redundant(s.m, s.d, none));
    const long after = allocations, released_after = releases;
    assert_int_equal(after - before, 0);
    assert_int_equal(released_after - released, 0);
    assert_int_equal(bad, 0);
    assert_int_equal(singular, MBSR_LOOP_SINGULAR);
    mbsr_newton_destroy(newton);
    loops_free(&s);
}

/* Steps of a fixed size, refused ones among them: a four-bar with a motor, whose force fails for a
 * while. */
static int fails;

static int failing_torque(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 1.0;
    return fails;
}

static void no_step_of_the_stepper_allocates(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    loops s;
    mbsr_stepper *stepper;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "coupler", a, 1.0, 0.0, 0.0, 2.5),
              c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    const mbsr_force_def motor = mbsr_force_joint_applied(a, failing_torque, NULL);
    assert_ok(mbsr_model_add_force(s.m, &motor, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    s.q[0] = 1.2, s.q[1] = -0.9, s.q[2] = 1.3;
    assert_ok(mbsr_stepper_create(s.m, s.d, NULL, &stepper, NULL), NULL);
    assert_ok(mbsr_stepper_start(stepper, 0.0, s.q, s.u), mbsr_stepper_error(stepper));
    const long before = allocations, released = releases;
    int bad = 0;
    for (int k = 0; k < 50; ++k) bad += abs(mbsr_stepper_step(stepper));
    fails = 1;
    bad += mbsr_stepper_step(stepper) != 1;
    fails = 0;
    bad += abs(mbsr_stepper_jump(stepper));
    bad += abs(mbsr_stepper_to(stepper, 0.055));
    bad += mbsr_stepper_to(stepper, 0.0) != MBSR_ERR_VALUE;
    const long after = allocations, released_after = releases;
    assert_int_equal(after - before, 0);
    assert_int_equal(released_after - released, 0);
    assert_int_equal(bad, 0);
    mbsr_stepper_destroy(stepper);
    loops_free(&s);
}

/* Inverse dynamics with motors at some joints of a chain whose loops overlap; a call that is
 * refused leaves torques and loop forces as they were. */
static void no_motor_allocates(void **state)
{
    (void)state;
    if (!COUNTED) skip();
    enum { RODS = 12, MOTORS = RODS - 6 };
    static const int with[MOTORS] = {0, 2, 4, 6, 8, 11}, without[1] = {0};
    const mbsr_motors enough = {MOTORS, with}, few = {1, without};
    double tau[RODS], again[RODS], lambda[6], still[RODS] = {0.0};
    loops s;
    int bad = 0;
    loops_begin(&s, NULL);
    for (int k = 0; k < RODS; ++k)
        loops_rod(&s, "rod", k > 0 ? k - 1 : MBSR_GROUND, k > 0 ? 1.0 : 0.0, 0.0, 1.0, 1.0);
    for (int k = 0; k < 3; ++k)
        loops_pin(&s, "pin", 5 + 3 * k, 0.5, 0.2, k > 0 ? 3 * k - 2 : MBSR_GROUND, 0.3, 0.4);
    loops_finish(&s);
    for (int k = 0; k < RODS; ++k) s.q[k] = k % 2 ? 0.9 : -0.7 + 0.1 * k;
    const long before = allocations, released = releases;
    for (int k = 0; k < 3; ++k)
        bad += mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, still, &enough, tau);
    memcpy(again, tau, sizeof tau);
    const int refused = mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, still, &few, again);
    const long after = allocations, released_after = releases;
    assert_int_equal(after - before, 0);
    assert_int_equal(released_after - released, 0);
    assert_int_equal(bad, 0);
    assert_int_equal(refused, MBSR_UNDETERMINED);
    assert_memory_equal(again, tau, sizeof tau);
    /* what they bring about is what all joints would */
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, still, &enough, tau), NULL);
    assert_ok(mbsr_closures_lambda(s.m, s.d, lambda), mbsr_data_error(s.d));
    assert_ok(mbsr_closures_transpose(s.m, s.d, lambda, again), mbsr_data_error(s.d));
    for (int k = 0; k < RODS; ++k) tau[k] += again[k];
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, still, NULL, again), NULL);
    for (int k = 0; k < RODS; ++k)
        assert_true(fabs(tau[k] - again[k]) <= 1e-9 * (1.0 + fabs(again[k])));
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counting_sees_an_allocation),
        cmocka_unit_test(no_newton_system_with_loops_allocates),
        cmocka_unit_test(no_evaluation_allocates_even_the_first),
        cmocka_unit_test(no_evaluation_in_space_allocates),
        cmocka_unit_test(no_step_of_the_stepper_allocates),
        cmocka_unit_test(no_motor_allocates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
