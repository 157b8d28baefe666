/* Random trees with random loops in other units, with other numbers of the bodies, and turned as a
 * whole: ranks, accelerations, loop forces and starts are the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <mbsrank/driver.h>

#include <stdbool.h>
#include <string.h>

/* One mechanism told in some units, with bodies in another order, turned with its root. */
typedef struct teller {
    double length, mass; /* of one metre and one kilogram, in the units told */
    bool reversed;       /* of two branches the other one comes first */
    mbsr_frame turn;     /* of the whole */
} teller;

enum { LINKS = 3, BODIES = 2 * LINKS };

static void scaled(const teller *w, const double *x, double *out)
{
    for (int k = 0; k < 3; ++k) out[k] = w->length * x[k];
}

static mbsr_frame place(const teller *w, test_rng *rng, bool on_ground)
{
    double x[3], p[3];
    test_fill(rng, 3, x);
    test_fill(rng, 3, p);
    mbsr_frame frame = mbsr_frame_rotated(p, x, 1.0);
    if (on_ground) frame = mbsr_frame_product(&w->turn, &frame);
    scaled(w, frame.x, frame.x);
    return frame;
}

/* A point of a body, or of the ground. */
static void point(const teller *w, test_rng *rng, int body, double out[3])
{
    double x[3];
    test_fill(rng, 3, x);
    if (body == MBSR_GROUND) {
        const mbsr_frame at = mbsr_frame_at(x[0], x[1], x[2]),
                         turned = mbsr_frame_product(&w->turn, &at);
        memcpy(x, turned.x, sizeof x);
    }
    scaled(w, x, out);
}

static mbsr_joint joint(const teller *w, test_rng *rng, bool on_ground)
{
    double x[3], y[3];
    const mbsr_frame at = place(w, rng, on_ground);
    test_fill(rng, 3, x);
    test_fill(rng, 3, y);
    switch (test_integer(rng, 0, 3)) {
    case 0: return mbsr_joint_revolute(&at, NULL, x);
    case 1: return mbsr_joint_cylindrical(&at, NULL, x);
    case 2: return mbsr_joint_universal(&at, NULL, x, y);
    default: return mbsr_joint_prismatic(&at, NULL, x);
    }
}

/* Two branches of links, one of them without mass, and closures between and to the ground; `id` are
 * the bodies, branch after branch. */
static void tell(loops *s, const teller *w, uint64_t seed, int *id)
{
    test_rng rng = test_seed(seed);
    mbsr_body_def def[BODIES];
    mbsr_model_def model = mbsr_default_model_def();
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * w->length, 0.0);
    memset(s, 0, sizeof *s);
    assert_ok(mbsr_model_create(&model, &s->m, NULL), NULL);
    assert_ok(mbsr_model_add_force(s->m, &gravity, NULL), mbsr_model_error(s->m));
    const int massless = test_integer(&rng, 0, 2 * BODIES);
    for (int k = 0; k < BODIES; ++k) {
        double com[3];
        test_fill(&rng, 3, com);
        scaled(w, com, com);
        const double m = w->mass * (1.0 + 0.5 * test_uniform(&rng)),
                     I = w->mass * w->length * w->length;
        const double tensor[6] = {0.3 * I, 0.4 * I, 0.5 * I, 0.01 * I, 0.02 * I, -0.03 * I};
        def[k] = mbsr_default_body_def();
        def[k].joint = joint(w, &rng, k % LINKS == 0);
        if (k != massless) def[k].inertia = mbsr_inertia_rigid(m, com, tensor);
    }
    for (int n = 0; n < BODIES; ++n) {
        const int k = w->reversed ? (n + LINKS) % BODIES : n;
        def[k].parent = k % LINKS == 0 ? MBSR_GROUND : id[k - 1];
        assert_ok(mbsr_model_add_body(s->m, def + k, id + k), mbsr_model_error(s->m));
    }
    const int count = test_integer(&rng, 1, 2);
    for (int c = 0; c < count; ++c) {
        const int kind = test_integer(&rng, 0, 4), a = id[LINKS - 1 - c],
                  b = test_integer(&rng, 0, 2) ? id[BODIES - 1 - c] : MBSR_GROUND;
        double p[3], q[3], along[3];
        point(w, &rng, a, p);
        point(w, &rng, b, q);
        test_fill(&rng, 3, along);
        mbsr_closure_def closure = mbsr_closure_ball(a, p, b, q);
        if (kind == 1) closure = mbsr_closure_distance(a, p, b, q, 1.3 * w->length);
        if (kind == 2 && b != MBSR_GROUND) closure = mbsr_closure_body_rows(a, p, b, q, 1, along);
        if (kind == 3) {
            const mbsr_frame at = place(w, &rng, false);
            const mbsr_joint last = mbsr_joint_spherical(&at, NULL);
            assert_ok(mbsr_model_add_loop_joint(s->m, "last", a, &last, b,
                                                b == MBSR_GROUND ? &w->turn : NULL, NULL, NULL),
                      mbsr_model_error(s->m));
            continue;
        }
        assert_ok(mbsr_model_add_closure(s->m, &closure, NULL), mbsr_model_error(s->m));
        if (kind == 4) assert_ok(mbsr_model_add_closure(s->m, &closure, NULL), NULL); /* twice */
    }
    loops_finish(s);
}

/* Whether a joint rate is a velocity of translation: so the joint's table says. */
static double unit_of(const loops *s, const teller *w, int body, int k)
{
    mbsr_coordinate_kind kind[8];
    assert_ok(mbsr_body_coordinate_kinds(s->m, body, NULL, kind), NULL);
    return kind[k] == MBSR_COORDINATE_TRANSLATION ? w->length : 1.0;
}

/* What a telling says, per body of the common order and without units. */
typedef struct story {
    int forward, start; /* statuses */
    int independent, ranks[4];
    double acceleration[BODIES][6], udot[BODIES][6], q[BODIES][6], u[BODIES][6];
    double power; /* of loop forces at the velocities given */
} story;

static void gather(const loops *s, const teller *w, const int *id, const double *x, bool position,
                   double out[BODIES][6])
{
    for (int k = 0; k < BODIES; ++k) {
        int q, u, n;
        assert_ok(mbsr_body_coordinates(s->m, id[k], &q, NULL, &u, &n), NULL);
        for (int j = 0; j < n; ++j) out[k][j] = x[(position ? q : u) + j] / unit_of(s, w, id[k], j);
    }
}

static void random_state(loops *s, const teller *w, const int *id, uint64_t seed)
{
    test_rng rng = test_seed(seed + 1000);
    for (int k = 0; k < BODIES; ++k) {
        int q, n, u;
        assert_ok(mbsr_body_coordinates(s->m, id[k], &q, NULL, &u, &n), NULL);
        for (int j = 0; j < n; ++j) {
            s->q[q + j] = test_uniform(&rng) * unit_of(s, w, id[k], j);
            s->u[u + j] = test_uniform(&rng) * unit_of(s, w, id[k], j);
        }
    }
    for (int k = BODIES; k < mbsr_model_bodies(s->m); ++k) { /* cut bodies, on ball joints */
        int q;
        assert_ok(mbsr_body_coordinates(s->m, k, &q, NULL, NULL, NULL), NULL);
        s->q[q] = 1.0;
    }
}

/* At the state as it is, open. */
static void hear_forward(loops *s, const teller *w, const int *id, story *found)
{
    double udot[LOOPS_MOST], lambda[LOOPS_MOST], x[LOOPS_MOST];
    mbsr_closure_report report;
    assert_ok(mbsr_closures_report(s->m, s->d, 0.0, s->q, &report, NULL, NULL), NULL);
    found->independent = report.independent;
    found->forward = mbsr_forward_dynamics(s->m, s->d, 0.0, s->q, s->u, NULL, udot);
    if (found->forward) return;
    gather(s, w, id, udot, false, found->acceleration);
    assert_ok(mbsr_closures_lambda(s->m, s->d, lambda), NULL);
    assert_ok(mbsr_closures_transpose(s->m, s->d, lambda, x), NULL);
    for (int k = 0; k < s->nu; ++k)
        found->power += x[k] * s->u[k] / (w->mass * w->length * w->length);
}

static void hear_start(loops *s, const teller *w, const int *id, story *found)
{
    double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST];
    mbsr_closure_report r;
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y), NULL);
    found->start = mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (found->start) return;
    assert_ok(mbsr_closures_report(s->m, s->d, 0.0, y, &r, NULL, NULL), NULL);
    const int ranks[4] = {r.nearby, r.mobility, r.massless, r.undetermined};
    memcpy(found->ranks, ranks, sizeof ranks);
    gather(s, w, id, y, true, found->q);
    gather(s, w, id, y + s->nq + s->nu, false, found->u);
    gather(s, w, id, yp + s->nq + s->nu, false, found->udot);
}

static story hear(const teller *w, uint64_t seed)
{
    loops s;
    story found = {.power = 0.0};
    int id[BODIES];
    tell(&s, w, seed, id);
    random_state(&s, w, id, seed);
    hear_forward(&s, w, id, &found);
    hear_start(&s, w, id, &found);
    loops_free(&s);
    return found;
}

static void compare_rates(const double a[BODIES][6], const double b[BODIES][6], double tolerance)
{
    double size = 1.0;
    for (int k = 0; k < BODIES; ++k) size = fmax(size, test_largest(6, a[k]));
    for (int k = 0; k < BODIES; ++k) {
        for (int j = 0; j < 6; ++j) assert_close(b[k][j], a[k][j], tolerance * size);
    }
}

/* Where a telling has other units of length the guess is closed on another way: lengths and angles
 * are added up to what is smallest. */
static void compare(const story *a, const story *b, bool starts)
{
    assert_int_equal(a->forward, b->forward);
    assert_int_equal(a->independent, b->independent);
    compare_rates(a->acceleration, b->acceleration, 1e-7);
    assert_close(b->power, a->power, 1e-6 * (1.0 + fabs(a->power)));
    if (!starts) return;
    assert_int_equal(a->start, b->start);
    assert_memory_equal(a->ranks, b->ranks, sizeof a->ranks);
    compare_rates(a->q, b->q, 1e-7);
    compare_rates(a->u, b->u, 1e-6);
    compare_rates(a->udot, b->udot, 1e-5);
}

static void other_tellings(void **state)
{
    (void)state;
    int moved = 0, started = 0;
    const double axis[3] = {0.0, 1.0, 0.0}; /* gravity stays */
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        const mbsr_frame as_it_is = mbsr_frame_identity();
        const teller plain = {1.0, 1.0, false, as_it_is};
        const teller other[] = {{1e3, 1.0, false, as_it_is},
                                {1e3, 1e-3, false, as_it_is},
                                {1e-2, 1e4, false, as_it_is},
                                {1.0, 1.0, true, as_it_is},
                                {1.0, 1.0, false, mbsr_frame_rotated(NULL, axis, 0.8)}};
        const story first = hear(&plain, seed);
        for (int k = 0; k < 5; ++k) {
            const story next = hear(other + k, seed);
            compare(&first, &next, k > 2);
        }
        moved += first.forward == MBSR_OK;
        started += first.start == MBSR_OK;
    }
    assert_true(moved > 20);
    assert_true(started > 15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(other_tellings)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
