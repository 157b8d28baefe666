/* Memory: every allocation made to fail in turn, and data in the caller's storage.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "counting.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

static int list_force(const mbsr_force_args *args)
{
    (void)args;
    return 0;
}

static const mbsr_force_table list_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "list", .evaluate = list_force};

enum { BODIES = 20, FORCES = 12 };

/* A chain of planar bodies with names and matrices, the last a massless point on spring and
 * damper. */
static int add_body(mbsr_model *m, int k)
{
    static const double matrix[9] = {2, 0, 0, 0, 2, 0, 0, 0, 1};
    char name[40] = "a body with a name of some length ";
    name[33] = (char)('a' + k);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = k - 1;
    body.joint =
        mbsr_joint_planar_revolute((mbsr_planar_frame){1, 0, 0}, (mbsr_planar_frame){0, 0, 0});
    body.inertia = mbsr_inertia_matrix(3, matrix);
    if (k == BODIES - 1) {
        body.joint = mbsr_joint_point_free();
        body.inertia = mbsr_inertia_zero();
    }
    return mbsr_model_add_body(m, &body, NULL);
}

static int add_force(mbsr_model *m, int k)
{
    static const int list[5] = {0, 1, 2, 3, 4};
    mbsr_force_def force = mbsr_force_custom(&list_table, 5, list, NULL);
    if (k < 2) force = mbsr_force_joint_spring(BODIES - 1, k, 100.0, 5.0, 0.0);
    force.name = "a force element with a name of some length";
    return mbsr_model_add_force(m, &force, NULL);
}

/* One step that may run out of memory: it says so, changes nothing, and succeeds when tried
 * again. */
#define retry(call, failure)                                                                       \
    do {                                                                                           \
        const int failed_before = counting->failed;                                                \
        int outcome = (call);                                                                      \
        if (counting->failed != failed_before) {                                                   \
            assert_int_equal(outcome, MBSR_ERR_NO_MEMORY);                                         \
            assert_int_equal((failure)->status, MBSR_ERR_NO_MEMORY);                               \
            assert_contains((failure)->text, "no memory");                                         \
            outcome = (call);                                                                      \
        }                                                                                          \
        assert_ok(outcome, (failure));                                                             \
    } while (0)

/* Builds, finishes, starts consistently and evaluates; allocation number fail_at fails. */
static void whole_life(test_counting *counting, double *result)
{
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m;
    mbsr_data *d;
    mbsr_error error = {0};
    def.allocator = test_counting_allocator(counting);
    retry(mbsr_model_create(&def, &m, &error), &error);
    for (int k = 0; k < BODIES; ++k) retry(add_body(m, k), mbsr_model_error(m));
    for (int k = 0; k < FORCES; ++k) retry(add_force(m, k), mbsr_model_error(m));
    retry(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_model_bodies(m), BODIES);
    assert_int_equal(mbsr_model_forces(m), FORCES);
    retry(mbsr_data_create(m, &d, &error), &error);

    const int size = mbsr_dae_size(m, MBSR_DAE_RECURSIVE);
    double *y = calloc((size_t)size, sizeof *y), *yp = calloc((size_t)size, sizeof *yp);
    for (int k = 0; k < size; ++k) y[k] = 0.1 * sin((double)k);
    retry(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL),
          mbsr_data_error(d));
    *result = 0.0;
    for (int k = 0; k < size; ++k) *result += (k + 1) * (y[k] + 2.0 * yp[k]);
    free(y);
    free(yp);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void every_allocation_may_fail_and_nothing_is_lost(void **state)
{
    (void)state;
    test_counting plain = {0};
    double expected, result;
    whole_life(&plain, &expected);
    assert_int_equal(plain.live, 0);
    assert_in_range(plain.calls, 20, 200);
    for (long k = 1; k <= plain.calls; ++k) {
        test_counting counting = {.fail_at = k};
        whole_life(&counting, &result);
        assert_int_equal(counting.failed, 1);
        assert_int_equal(counting.live, 0);
        assert_close(result, expected, 0.0);
    }
}

static void a_model_without_memory_from_the_start_is_null(void **state)
{
    (void)state;
    for (int k = 1; k <= 2; ++k) {
        test_counting counting = {.fail_at = k};
        mbsr_model_def def = mbsr_default_model_def();
        mbsr_model *m = (mbsr_model *)&def;
        mbsr_error error;
        def.allocator = test_counting_allocator(&counting);
        assert_refused(mbsr_model_create(&def, &m, &error), &error, MBSR_ERR_NO_MEMORY, MBSR_NONE,
                       MBSR_NONE, "mbsr_model_create");
        assert_null(m);
        assert_int_equal(counting.live, 0);
    }
}

/* Starts of which every call for memory fails in turn, `open`: nothing determines some direction.
 * They take memory for the state given, then for Newton systems and what they are solved with, and
 * to name what is open for the directions that masses leave free. */
static void fail_starts(bool open)
{
    enum { NEWTON = 62, REPORT = 3 };
    const int calls = NEWTON + (open ? REPORT : 0);
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m;
    mbsr_data *d;
    double y[80], yp[80];
    def.allocator = test_counting_allocator(&counting);
    assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
    for (int k = 0; k < BODIES; ++k) assert_int_equal(add_body(m, k), 0);
    for (int k = open ? 2 : 0; k < FORCES; ++k) assert_int_equal(add_force(m, k), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_RECURSIVE), 2, 80);
    for (int k = 0; k < 80; ++k) y[k] = 0.25, yp[k] = 0.5;
    const long live = counting.live;
    for (int k = 1; k <= calls; ++k) {
        counting.fail_at = counting.calls + k;
        assert_refused(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL),
                       mbsr_data_error(d), MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                       k == 1        ? "mbsr_dae_consistent|a state of"
                       : k <= NEWTON ? "mbsr_dae_consistent|Newton systems"
                                     : "mbsr_dae_consistent|null directions");
        assert_int_equal(counting.calls, counting.fail_at);
        for (int l = 0; l < 80; ++l) assert_true(y[l] == 0.25 && yp[l] == 0.5);
        assert_int_equal(counting.live, live);
    }
    const long before = counting.calls;
    counting.fail_at = 0;
    const int status = mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL);
    assert_int_equal(status, open ? MBSR_UNDETERMINED : MBSR_OK);
    assert_int_equal(counting.calls, before + calls);
    assert_int_equal(counting.live, live);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    assert_int_equal(counting.live, 0);
}

/* A consistent start that fails for want of memory leaves y and yp as they were. */
static void a_failed_start_leaves_the_state_alone(void **state)
{
    (void)state;
    fail_starts(false);
    fail_starts(true);
}

/* A finish that is refused for another reason gives back what it took; the next one starts anew. */
static void a_refused_finish_gives_its_memory_back(void **state)
{
    (void)state;
    test_counting counting = {0};
    size_t size[2];
    for (int refuse = 0; refuse < 2; ++refuse) {
        mbsr_model_def def = mbsr_default_model_def();
        mbsr_model *m;
        def.allocator = test_counting_allocator(&counting);
        assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
        for (int k = 0; k < BODIES - 1; ++k) assert_int_equal(add_body(m, k), 0);
        for (int k = 0; k < FORCES; ++k) assert_int_equal(add_force(m, k), 0);
        /* the springs on the last body come before it */
        for (int k = 0; refuse && k < 3; ++k) {
            const long live = counting.live;
            assert_int_equal(mbsr_model_finish(m), MBSR_ERR_ID);
            assert_int_equal(counting.live, live);
        }
        assert_int_equal(add_body(m, BODIES - 1), 0);
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        size[refuse] = mbsr_data_size(m);
        mbsr_model_destroy(m);
        assert_int_equal(counting.live, 0);
    }
    assert_int_equal(size[0], size[1]);
}

/* ---- the caller's storage -------------------------------------------------------------------- */

static mbsr_model *finished(void)
{
    mbsr_model *m;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < BODIES; ++k) assert_int_equal(add_body(m, k), 0);
    for (int k = 0; k < FORCES; ++k) assert_int_equal(add_force(m, k), 0);
    assert_int_equal(mbsr_model_finish(m), 0);
    return m;
}

/* The whole evaluation path on a data object. */
static void use(const mbsr_model *m, mbsr_data *d)
{
    const size_t nu = (size_t)mbsr_model_nu(m), nq = (size_t)mbsr_model_nq(m);
    double *y = calloc(nq + nu, sizeof *y), *F = calloc(nq + nu, sizeof *F),
           *M = calloc(nu * nu, sizeof *M);
    for (size_t k = 0; k < nq + nu; ++k) y[k] = 0.1 * cos((double)k);
    assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.0, y, y, F), 0);
    assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_INVERSE_DYNAMICS, 0.0, y, y, F), 0);
    assert_int_equal(mbsr_mass_matrix(m, d, M), 0);
    assert_int_equal(mbsr_energy(m, d, F, F + 1), 0);
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, y, y + nq, NULL, F), MBSR_UNDETERMINED);
    free(y);
    free(F);
    free(M);
}

enum { GUARD = 256 };

static void a_block_of_exactly_the_size_is_enough_and_not_overrun(void **state)
{
    (void)state;
    mbsr_model *m = finished();
    const size_t size = mbsr_data_size(m), whole = GUARD + size + GUARD;
    assert_true(size > 0);
    unsigned char *block = aligned_alloc(MBSR_DATA_ALIGNMENT, (whole + 63) / 64 * 64);
    memset(block, 0xa5, whole);
    mbsr_data *d;
    mbsr_error error;
    assert_ok(mbsr_data_init(m, block + GUARD, size, &d, &error), &error);
    use(m, d);
    for (size_t k = 0; k < GUARD; ++k) {
        assert_int_equal(block[k], 0xa5);
        assert_int_equal(block[GUARD + size + k], 0xa5);
    }
    /* destroying data in the caller's memory does nothing */
    mbsr_data_destroy(d);
    use(m, d);
    mbsr_data_destroy(NULL);
    free(block);

    /* a block without guards, so that a sanitizer sees an overrun */
    block = aligned_alloc(MBSR_DATA_ALIGNMENT, size);
    assert_ok(mbsr_data_init(m, block, size, &d, NULL), NULL);
    use(m, d);
    free(block);
    mbsr_model_destroy(m);
}

static void memory_too_small_or_misaligned_is_refused(void **state)
{
    (void)state;
    mbsr_model *m = finished();
    const size_t size = mbsr_data_size(m);
    unsigned char *block = aligned_alloc(MBSR_DATA_ALIGNMENT, size + MBSR_DATA_ALIGNMENT);
    memset(block, 0xa5, size + MBSR_DATA_ALIGNMENT);
    mbsr_data *d = (mbsr_data *)&d;
    mbsr_error error;
    assert_refused(mbsr_data_init(m, block, size - 1, &d, &error), &error, MBSR_ERR_MEMORY_SIZE,
                   MBSR_NONE, MBSR_NONE, "mbsr_data_init|bytes|needs");
    assert_null(d);
    assert_refused(mbsr_data_init(m, block, 0, &d, &error), &error, MBSR_ERR_MEMORY_SIZE, MBSR_NONE,
                   MBSR_NONE, "size is 0 bytes");
    for (size_t off = 1; off < MBSR_DATA_ALIGNMENT; off += off) {
        d = (mbsr_data *)&d;
        assert_refused(mbsr_data_init(m, block + off, size, &d, &error), &error,
                       MBSR_ERR_MEMORY_ALIGNMENT, MBSR_NONE, MBSR_NONE, "aligned to 64 bytes");
        assert_null(d);
    }
    assert_refused(mbsr_data_init(m, NULL, size, &d, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "memory is NULL");
    assert_refused(mbsr_data_init(m, block, size, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "data is NULL");
    assert_refused(mbsr_data_create(m, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "data is NULL");
    for (size_t k = 0; k < size + MBSR_DATA_ALIGNMENT; ++k) assert_int_equal(block[k], 0xa5);
    assert_int_equal(mbsr_data_init(m, block + MBSR_DATA_ALIGNMENT, size, &d, NULL), MBSR_OK);
    free(block);
    mbsr_model_destroy(m);
}

/* Memory at 16 + shift behind a multiple of 64, its block's address in front of it. */
static void *odd_allocate(void *user, size_t size)
{
    const size_t shift = *(size_t *)user;
    unsigned char *block = malloc(size + 256);
    assert_non_null(block);
    unsigned char *memory = block + 128 - (uintptr_t)block % 64 + shift;
    memcpy(memory - sizeof block, &block, sizeof block);
    return memory;
}

static void odd_release(void *user, void *memory)
{
    (void)user;
    void *block;
    memcpy(&block, (unsigned char *)memory - sizeof block, sizeof block);
    free(block);
}

static void created_data_are_aligned_for_any_allocator(void **state)
{
    (void)state;
    for (size_t shift = 0; shift < 64; shift += 16) {
        mbsr_model_def def = mbsr_default_model_def();
        mbsr_model *m;
        mbsr_data *d;
        def.allocator = (mbsr_allocator){odd_allocate, odd_release, &shift};
        assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
        assert_int_equal(add_body(m, 0), 0);
        assert_int_equal(mbsr_model_finish(m), 0);
        assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
        assert_int_equal((uintptr_t)d % MBSR_DATA_ALIGNMENT, 0);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail_and_nothing_is_lost),
        cmocka_unit_test(a_model_without_memory_from_the_start_is_null),
        cmocka_unit_test(a_failed_start_leaves_the_state_alone),
        cmocka_unit_test(a_refused_finish_gives_its_memory_back),
        cmocka_unit_test(a_block_of_exactly_the_size_is_enough_and_not_overrun),
        cmocka_unit_test(memory_too_small_or_misaligned_is_refused),
        cmocka_unit_test(created_data_are_aligned_for_any_allocator),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
