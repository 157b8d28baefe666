/* What a start and a report with many loops take in memory: so many bytes a body as with a few.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "expect.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double up = 1.5707963267948966;

typedef struct meter {
    size_t live, peak;
} meter;

static void *take(void *user, size_t size)
{
    meter *m = user;
    size_t *memory = malloc(size + 16);
    if (!memory) return NULL;
    memory[0] = size;
    m->live += size;
    m->peak = m->live > m->peak ? m->live : m->peak;
    return (char *)memory + 16;
}

static void give(void *user, void *memory)
{
    meter *m = user;
    if (!memory) return;
    size_t *begin = (size_t *)(void *)((char *)memory - 16);
    m->live -= begin[0];
    free(begin);
}

typedef struct scene {
    meter bytes;
    mbsr_model *m;
} scene;

/* A rod in the plane on a hinge at (x, y) of the parent, so much turned from its x. */
static int rod(scene *s, int parent, double x, double y, double turned, double length)
{
    const double c[3] = {0.5 * length, 0.0, 0.0};
    mbsr_body_def def = mbsr_default_body_def();
    int id;
    def.parent = parent;
    def.joint =
        mbsr_joint_planar_revolute((mbsr_planar_frame){x, y, turned}, (mbsr_planar_frame){0});
    def.inertia = mbsr_inertia_planar(1.0, c, 0.1);
    assert_ok(mbsr_model_add_body(s->m, &def, &id), mbsr_model_error(s->m));
    return id;
}

static void pin(scene *s, int a, double ax, int b, double bx, double by)
{
    const double p[3] = {ax, 0.0, 0.0}, r[3] = {bx, by, 0.0};
    const mbsr_closure_def def = mbsr_closure_ball(a, p, b, r);
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

/* Links side by side, neighbours of which have a coupler: each on the ground, */
static void add_row(scene *s, int count)
{
    int last = rod(s, MBSR_GROUND, 0.0, 0.0, 0.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int coupler = rod(s, last, 1.0, 0.0, up, 1.0),
                  next = rod(s, MBSR_GROUND, 0.0, (double)k, 0.0, 1.0);
        pin(s, coupler, 1.0, next, 1.0, 0.0);
        last = next;
    }
}

/* on a chain of couplers, cut at the ground, */
static void add_chain(scene *s, int count)
{
    int last = rod(s, MBSR_GROUND, 0.0, 0.0, 0.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int coupler = rod(s, last, 1.0, 0.0, k > 1 ? 0.0 : up, 1.0),
                  next = rod(s, coupler, 1.0, 0.0, up, 1.0);
        pin(s, next, 1.0, MBSR_GROUND, 0.0, (double)k);
        last = coupler;
    }
}

/* or in pairs on one carrier. */
static void add_carrier(scene *s, int count)
{
    const int carrier = rod(s, MBSR_GROUND, 0.0, 0.0, 0.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int first = rod(s, carrier, 0.0, (double)k, 0.0, 1.0),
                  coupler = rod(s, first, 1.0, 0.0, up, 0.5),
                  next = rod(s, carrier, 0.0, k + 0.5, 0.0, 1.0);
        pin(s, coupler, 0.5, next, 1.0, 0.0);
    }
}

/* Or anywhere on a tree of rods, between bodies near each other: loops overlap, a few of their rows
 * depend on others, and some nearly do. */
static void add_near(scene *s, int count)
{
    enum { NEAR = 20, MOST = 1000 };
    const int bodies = 2 * count;
    double x[MOST], y[MOST], angle[MOST];
    test_rng rng = test_seed(4);
    assert_true(bodies <= MOST);
    for (int i = 0; i < bodies; ++i) {
        const int parent =
            test_uniform(&rng) < 0.6 || i < 5 ? i - 1 : test_integer(&rng, i - 5, i - 1);
        const double at = test_uniform(&rng), side = test_uniform(&rng),
                     turned = test_uniform(&rng), c = i > 0 ? cos(angle[parent]) : 1.0,
                     n = i > 0 ? sin(angle[parent]) : 0.0;
        rod(s, i > 0 ? parent : MBSR_GROUND, at, side, turned, 1.0);
        x[i] = (i > 0 ? x[parent] : 0.0) + c * at - n * side;
        y[i] = (i > 0 ? y[parent] : 0.0) + n * at + c * side;
        angle[i] = (i > 0 ? angle[parent] : 0.0) + turned;
    }
    for (int k = 0; k < 3 * bodies / 10; ++k) {
        const int a = test_integer(&rng, NEAR, bodies - 1), b = test_integer(&rng, a - NEAR, a - 2);
        const double dx = x[a] + 0.5 * cos(angle[a]) - x[b], dy = y[a] + 0.5 * sin(angle[a]) - y[b],
                     c = cos(angle[b]), n = sin(angle[b]);
        pin(s, a, 0.5, b, c * dx + n * dy, c * dy - n * dx);
    }
}

/* Rods that hang on two stiff pins each, of whose four rows one depends on the others, as the
 * springs share it. */
static void add_arms(scene *s, int count)
{
    const mbsr_planar_frame none = {0};
    const double ends[2] = {0.2, 0.8}, K[9] = {1e7, 0, 0, 0, 1e7}, D[9] = {1e4, 0, 0, 0, 1e4},
                 c[3] = {0.5, 0.0, 0.0};
    const mbsr_force_def weight = mbsr_force_gravity(0.0, -9.81, 0.0);
    for (int k = 0; k < count; ++k) {
        mbsr_body_def def = mbsr_default_body_def();
        int id;
        def.joint = mbsr_joint_planar_free(none, none);
        def.inertia = mbsr_inertia_planar(1.0, c, 0.1);
        assert_ok(mbsr_model_add_body(s->m, &def, &id), mbsr_model_error(s->m));
        for (int l = 0; l < 2; ++l) {
            const mbsr_planar_frame there = {ends[l], (double)k, 0.0}, here = {ends[l], 0.0, 0.0};
            mbsr_force_def pin = mbsr_force_planar_bushing(MBSR_GROUND, there, id, here, K, D);
            pin.as_closure = MBSR_SPRING_SETTLED;
            assert_ok(mbsr_model_add_force(s->m, &pin, NULL), mbsr_model_error(s->m));
        }
    }
    assert_ok(mbsr_model_add_force(s->m, &weight, NULL), mbsr_model_error(s->m));
}

typedef enum call { START, REPORT, INDEX, CALLS } call;

/* Bytes a body beside model and data, of a start, or of a report of rows or of the index: all
 * bodies have mass, and what loops leave free are dynamic directions. */
static double measure(void (*add)(scene *, int), int count, call of)
{
    scene s = {.bytes = {0, 0}};
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_data *d;
    mbsr_closure_report found;
    mbsr_index_report *index = NULL;
    def.allocator = (mbsr_allocator){take, give, &s.bytes};
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    add(&s, count);
    assert_ok(mbsr_model_finish(s.m), mbsr_model_error(s.m));
    assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
    const size_t size = (size_t)mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM),
                 nq = (size_t)mbsr_model_nq(s.m);
    double *y = calloc(2 * size + 2 * nq, sizeof *y), *yp = y + size, *q = yp + size;
    for (size_t k = 0; k < nq; ++k) q[k] = 0.01 * (double)(k % 7);
    assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, q, q + nq, y), mbsr_data_error(d));
    const size_t before = s.bytes.peak = s.bytes.live;
    if (of == REPORT)
        assert_ok(mbsr_closures_report(s.m, d, 0.0, q, &found, NULL, NULL), mbsr_data_error(d));
    else if (of == INDEX)
        assert_ok(mbsr_index_report_create(s.m, d, 0.0, q, q + nq, &index), mbsr_data_error(d));
    else
        assert_ok(mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
    const double bytes = (double)(s.bytes.peak - before) / mbsr_model_bodies(s.m);
    if (of == INDEX) {
        assert_ok(mbsr_closures_report(s.m, d, 0.0, q, &found, NULL, NULL), mbsr_data_error(d));
        assert_int_equal(index->dynamic, mbsr_model_nu(s.m) - found.independent);
        assert_int_equal(index->directions, 0);
        mbsr_index_report_destroy(s.m, index);
    }
    free(y);
    mbsr_data_destroy(d);
    mbsr_model_destroy(s.m);
    assert_int_equal(s.bytes.live, 0);
    return bytes;
}

static void bytes_of_many_loops(void **state)
{
    (void)state;
    void (*const add[])(scene *, int) = {add_row, add_chain, add_carrier, add_near};
    for (int kind = 0; kind < 4; ++kind) {
        for (call of = START; of < CALLS; ++of) {
            const double few = measure(add[kind], 100, of), many = measure(add[kind], 400, of);
            /* what must wait for pivots is in memory that doubles */
            if (add[kind] != add_near) assert_true(many <= 1.05 * few);
            assert_true(many < 5000.0);
        }
    }
}

static void bytes_of_shared_springs(void **state)
{
    (void)state;
    for (call of = START; of < CALLS; ++of) {
        const double few = measure(add_arms, 50, of), many = measure(add_arms, 200, of);
        assert_true(many <= 1.05 * few);
        assert_less(many, 25000.0); /* with a copy of the model and its data */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bytes_of_many_loops),
                                       cmocka_unit_test(bytes_of_shared_springs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
