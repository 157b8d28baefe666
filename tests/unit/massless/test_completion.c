/* Completing a state: against answers by reasoning, and against consistent starts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "medley.h"
#include "space.h"
#include "tree.h"
#include "units.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

/* ---- a mass on a spring on a dashpot or a spring, by hand ---- */

/* Two slides in a row along an axis: the first without mass, on `first` to the ground; then the
 * mass on a spring. */
typedef struct row {
    mbsr_model *m;
    mbsr_data *d;
    double mass, k, stiffness, damping;
} row;

static double no_motion[3];

/* The ground shakes: s = 0.02 sin 7 t, in units of length and time. */
static int shake(void *user, double t, double *s, double *sdot, double *sddot)
{
    const units *in = user;
    const double w = 7.0 / in->time, a = 0.02 * in->length;
    *s = a * sin(w * t);
    *sdot = a * w * cos(w * t);
    *sddot = -a * w * w * sin(w * t);
    return MBSR_OK;
}

static int add(row *r, int parent, mbsr_joint joint, double mass)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(r->m, &body, &id), mbsr_model_error(r->m));
    return id;
}

static void spring(row *r, int body, double stiffness, double damping)
{
    const mbsr_force_def law = mbsr_force_joint_spring(body, 0, stiffness, damping, 0.0);
    assert_ok(mbsr_model_add_force(r->m, &law, NULL), mbsr_model_error(r->m));
}

/* k: of the spring between the slides; stiffness, damping: of the first element; N/m and N s/m. */
static void make_row(row *r, const units *in, double k, double stiffness, double damping)
{
    const double x[3] = {1.0, 0.0, 0.0}, newton = in->mass * in->length / (in->time * in->time),
                 per_length = newton / in->length;
    const mbsr_axis along = {MBSR_AXIS_TRANSLATION, {1, 0, 0}, 0, 1};
    *r = (row){.mass = 3.0 * in->mass,
               .k = k * per_length,
               .stiffness = stiffness * per_length,
               .damping = damping * per_length * in->time};
    assert_ok(mbsr_model_create(NULL, &r->m, NULL), NULL);
    int at =
        add(r, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &along, shake, (void *)in), 0.0);
    at = add(r, at, mbsr_joint_prismatic(NULL, NULL, x), 0.0);
    spring(r, at, r->stiffness, r->damping);
    at = add(r, at, mbsr_joint_prismatic(NULL, NULL, x), r->mass);
    spring(r, at, r->k, 0.0);
    assert_ok(mbsr_model_finish(r->m), mbsr_model_error(r->m));
    assert_ok(mbsr_data_create(r->m, &r->d, NULL), NULL);
}

static void free_row(row *r)
{
    mbsr_data_destroy(r->d);
    mbsr_model_destroy(r->m);
}

/* The state at t, and what is right there: u and u' of the first joint and of the mass on it. */
typedef struct answer {
    double y[6], yp[6], u[2], udot[2], precision;
} answer;

/* Dashpot: the spring's force k q1 moves it, d u0 = k q1. */
static answer on_a_dashpot(const row *r, const units *in, double t)
{
    answer a;
    double s, sdot, sddot;
    shake((void *)in, t, &s, &sdot, &sddot);
    const double q[2] = {0.01 * in->length, -0.03 * in->length},
                 speed = 0.4 * in->length / in->time, pull = r->k * q[1];
    a.precision = 1e-11;
    a.u[0] = pull / r->damping;
    a.u[1] = speed - sdot - a.u[0];
    a.udot[0] = r->k * a.u[1] / r->damping;
    a.udot[1] = -pull / r->mass - sddot - a.udot[0];
    const double y[6] = {q[0], q[1], r->mass * speed, r->mass * speed, 0.0, 0.0};
    for (int k = 0; k < 6; ++k) a.y[k] = y[k], a.yp[k] = 0.0;
    return a;
}

/* Two springs: stiffness q0 = k q1 at all times, but for what the positions are off by. */
static answer on_a_spring(const row *r, const units *in, double t, double off)
{
    answer a;
    double s, sdot, sddot;
    shake((void *)in, t, &s, &sdot, &sddot);
    const double q1 = -0.03 * in->length, share = r->k / r->stiffness,
                 speed = 0.4 * in->length / in->time;
    a.precision = 1e-9; /* by quotients */
    a.u[1] = (speed - sdot) / (1.0 + share);
    a.u[0] = share * a.u[1];
    a.udot[1] = (-r->k * q1 / r->mass - sddot) / (1.0 + share);
    a.udot[0] = share * a.udot[1];
    const double y[6] = {share * q1 * (1.0 + off), q1, r->mass * speed, r->mass * speed, 0.0, 0.0};
    for (int k = 0; k < 6; ++k) a.y[k] = y[k], a.yp[k] = 0.0;
    return a;
}

static mbsr_completion *make_completion(const row *r, const units *in)
{
    mbsr_completion *c = NULL;
    mbsr_error error;
    const mbsr_completion_times times = {0.01 * in->time, -INFINITY, INFINITY, 1};
    assert_ok(mbsr_completion_create(r->m, NULL, &c, &error), &error);
    assert_ok(mbsr_completion_set_times(c, &times), mbsr_completion_error(c));
    return c;
}

static void expect(const row *r, const units *in, const answer *a)
{
    const double speed = in->length / in->time, acceleration = speed / in->time;
    double q[2], u[2], udot[2], at[3], moves[3];
    mbsr_completion *c = make_completion(r, in);
    answer found = *a;
    found.y[4] = 5.0 * speed; /* no guess that is near */
    found.y[5] = -2.0 * speed;
    assert_ok(mbsr_completion_solve(c, r->d, MBSR_DAE_MOMENTUM, 0.3 * in->time, found.y, found.yp),
              mbsr_completion_error(c));
    for (int k = 0; k < 4; ++k) assert_true(found.y[k] == a->y[k]);
    for (int k = 0; k < 2; ++k) {
        assert_close(found.y[4 + k], a->u[k], a->precision * speed);
        assert_close(found.yp[k], a->u[k], a->precision * speed);
        assert_close(found.yp[4 + k], a->udot[k], 5e-6 * acceleration);
    }
    /* everything of the state at once */
    assert_ok(mbsr_completion_motion(c, r->d, q, u, udot, NULL), mbsr_completion_error(c));
    assert_memory_equal(q, found.y, sizeof q);
    assert_memory_equal(u, found.y + 4, sizeof u);
    assert_memory_equal(udot, found.yp + 4, sizeof udot);
    assert_ok(mbsr_body_point(r->m, r->d, 2, no_motion, NULL, at, moves), mbsr_data_error(r->d));
    assert_close(at[0], 0.4 * speed, a->precision * speed);
    assert_close(moves[0], -r->k * q[1] / r->mass, 1e-6 * acceleration);
    mbsr_completion_destroy(c);
}

static void a_mass_on_a_spring_and_a_dashpot(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        row r;
        make_row(&r, systems + k, 40.0, 0.0, 5.0);
        const answer a = on_a_dashpot(&r, systems + k, 0.3 * systems[k].time);
        expect(&r, systems + k, &a);
        free_row(&r);
    }
}

static void a_mass_on_two_springs(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        for (int off = 0; off < 2; ++off) {
            row r;
            make_row(&r, systems + k, 40.0, 90.0, 0.0);
            const answer a = on_a_spring(&r, systems + k, 0.3 * systems[k].time, 1e-3 * off);
            expect(&r, systems + k, &a);
            free_row(&r);
        }
    }
}

/* Forward dynamics at given q, u: a joint force of 2 N on the dashpot, which is held. */
static void joint_forces_accelerate(void **state)
{
    (void)state;
    const units *in = systems;
    row r;
    make_row(&r, in, 40.0, 0.0, 5.0);
    mbsr_completion *c = make_completion(&r, in);
    answer a = on_a_dashpot(&r, in, 0.3);
    const double tau[2] = {2.0, 2.0};
    double udot[2], plain[2];
    a.u[0] += 2.0 / r.damping;
    a.udot[1] += 2.0 / r.mass;
    /* the same motion with both joint forces: on the mass and, through it, on the dashpot */
    assert_ok(mbsr_completion_dynamics(c, r.d, 0.3, a.y, a.u, tau, udot, NULL),
              mbsr_completion_error(c));
    assert_close(udot[0], r.k * a.u[1] / r.damping, 1e-6);
    double s, sdot, sddot;
    shake((void *)in, 0.3, &s, &sdot, &sddot);
    assert_close(udot[0] + udot[1] + sddot, (2.0 - r.k * a.y[1]) / r.mass, 1e-6);
    /* what has mass is right in forward dynamics, too */
    assert_int_equal(mbsr_forward_dynamics(r.m, r.d, 0.3, a.y, a.u, tau, plain), MBSR_UNDETERMINED);
    assert_close(plain[0] + plain[1], udot[0] + udot[1], 1e-6);
    mbsr_completion_destroy(c);
    free_row(&r);
}

/* Neither spring nor dashpot: refused, and nothing changes. */
static void what_nothing_determines_is_named(void **state)
{
    (void)state;
    row r;
    make_row(&r, systems, 0.0, 0.0, 0.0);
    mbsr_completion *c = make_completion(&r, systems);
    answer a;
    for (int k = 0; k < 6; ++k) a.y[k] = 0.1 * k, a.yp[k] = 7.0;
    answer before = a;
    assert_int_equal(mbsr_completion_solve(c, r.d, MBSR_DAE_MOMENTUM, 0.3, a.y, a.yp),
                     MBSR_UNDETERMINED);
    assert_int_equal(mbsr_completion_error(c)->status, MBSR_UNDETERMINED);
    assert_true(mbsr_completion_error(c)->body >= 1);
    assert_memory_equal(&a, &before, sizeof a.y + sizeof a.yp);
    assert_int_equal(mbsr_completion_motion(c, r.d, NULL, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
    mbsr_completion_destroy(c);
    free_row(&r);
}

/* ---- random models, against consistent starts ---- */

typedef struct comparison {
    const mbsr_model *m;
    mbsr_data *d;
    double t, tolerance;
    double *y, *yp, *z, *zp; /* size */
    int compared;
} comparison;

/* A completion from wrong u and loop forces finds what the start has found. */
static void compare(comparison *c, mbsr_dae_form form)
{
    const int size = mbsr_dae_size(c->m, form), nq = mbsr_model_nq(c->m), nu = mbsr_model_nu(c->m),
              u = form == MBSR_DAE_MOMENTUM ? nq + nu : nq;
    mbsr_completion *completion = NULL;
    mbsr_error error;
    test_rng rng = test_seed(7);
    assert_ok(mbsr_completion_create(c->m, NULL, &completion, &error), &error);
    memcpy(c->z, c->y, (size_t)size * sizeof *c->z);
    for (int k = 0; k < size; ++k) c->zp[k] = 0.0;
    for (int k = u; form == MBSR_DAE_MOMENTUM && k < u + nu; ++k)
        c->z[k] += 0.01 * test_uniform(&rng);
    const int status = mbsr_completion_solve(completion, c->d, form, c->t, c->z, c->zp);
    assert_ok(status, mbsr_completion_error(completion));
    const double size_u = 1.0 + test_largest(nu, c->y + u),
                 size_dot = 1.0 + test_largest(nu, c->yp + u);
    for (int k = 0; k < nu && form != MBSR_DAE_INDEX1; ++k) {
        assert_close(c->z[u + k], c->y[u + k], c->tolerance * size_u);
        assert_close(c->zp[u + k], c->yp[u + k], 100.0 * c->tolerance * size_dot);
    }
    for (int k = 0; k < size && form == MBSR_DAE_INDEX1; ++k) {
        assert_close(c->z[k], c->y[k], c->tolerance * (1.0 + test_largest(size, c->y)));
        assert_close(c->zp[k], c->yp[k], 100.0 * c->tolerance * (1.0 + test_largest(size, c->yp)));
    }
    mbsr_completion_destroy(completion);
    ++c->compared;
}

/* A start from (q, u), and its completion. False where there is no start. */
static bool start(comparison *c, mbsr_dae_form form, const double *q, const double *u)
{
    const int size = mbsr_dae_size(c->m, form);
    double *memory = calloc(4 * (size_t)size, sizeof *memory);
    c->y = memory, c->yp = memory + size, c->z = c->yp + size, c->zp = c->z + size;
    int status = mbsr_dae_pack(c->m, c->d, form, c->t, q, u, c->y);
    if (!status) status = mbsr_dae_consistent(c->m, c->d, form, c->t, c->y, c->yp, NULL, NULL);
    if (!status) compare(c, form);
    free(memory);
    return status == MBSR_OK;
}

static void trees_in_space(void **state)
{
    (void)state;
    comparison c = {.t = 0.3, .tolerance = 1e-8};
    for (int seed = 1; seed <= 60; ++seed) {
        test_space_tree tree;
        test_space_make(&tree, (test_space_opt){.seed = (uint64_t)seed,
                                                .bodies = 4 + seed % 4,
                                                .deficient = 0.7 * (seed % 3 > 0),
                                                .driven = seed % 2,
                                                .laws = 1,
                                                .gravity = 9.81});
        c.m = tree.model;
        c.d = tree.data;
        const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                       MBSR_DAE_INVERSE_DYNAMICS, MBSR_DAE_INDEX1};
        start(&c, forms[seed / 2 % 4], tree.q, tree.u);
        test_space_free(&tree);
    }
    assert_true(c.compared > 50);
}

/* States near each other: two evaluations for u and four for the time that motions depend on,
 * the matrix of the last state and then one of this one. */
static void the_matrix_of_one_state_serves_the_next(void **state)
{
    (void)state;
    enum { STATES = 100 };
    const units *in = &systems[0];
    row r;
    make_row(&r, in, 40.0, 0.0, 5.0);
    mbsr_completion *c = make_completion(&r, in);
    mbsr_completion_info first, all;
    for (int k = 0; k < STATES; ++k) {
        answer found = on_a_dashpot(&r, in, 1e-3 * k);
        const answer right = found;
        for (int j = 4; j < 6; ++j) found.y[j] += 1e-3;
        assert_ok(mbsr_completion_solve(c, r.d, MBSR_DAE_MOMENTUM, 1e-3 * k, found.y, found.yp),
                  mbsr_completion_error(c));
        for (int j = 0; j < 2; ++j) assert_close(found.y[4 + j], right.u[j], 1e-9);
        if (k == 0) assert_int_equal(mbsr_completion_get_info(c, &first), MBSR_OK);
    }
    assert_int_equal(mbsr_completion_get_info(c, &all), MBSR_OK);
    assert_true(all.residuals - first.residuals <= 7 * (STATES - 1));
    assert_int_equal(all.factorisations - first.factorisations, STATES - 1);
    assert_true(all.solves - first.solves <= 5 * (STATES - 1));
    mbsr_completion_destroy(c);
    free_row(&r);
}

static void trees_of_general_bodies(void **state)
{
    (void)state;
    comparison c = {.t = 0.3, .tolerance = 1e-7};
    for (int seed = 1; seed <= 60; ++seed) {
        test_tree tree;
        double q[64], u[64];
        test_tree_make(&tree, (test_tree_opt){.seed = (uint64_t)seed,
                                              .bodies = 5,
                                              .max_d = 3,
                                              .deficient = 0.7,
                                              .bend = 0.1,
                                              .forces = 1,
                                              .moving_root = seed % 2});
        test_rng rng = test_seed((uint64_t)seed);
        test_fill(&rng, mbsr_model_nq(tree.model), q);
        test_fill(&rng, mbsr_model_nu(tree.model), u);
        c.m = tree.model;
        c.d = tree.data;
        start(&c, MBSR_DAE_MOMENTUM, q, u);
        test_tree_free(&tree);
    }
    assert_true(c.compared > 30);
}

static void mechanisms(void **state)
{
    (void)state;
    comparison c = {.tolerance = 1e-6};
    /* the last ones have loops past points and within groups without mass, and rows that depend on
     * others but for rounding */
    static const uint64_t others[] = {336, 354, 1258, 1834, 2218, 2861, 5768};
    enum { FIRST = 60, ALL = FIRST + sizeof others / sizeof others[0] };
    for (int k = 0; k < ALL; ++k) {
        const uint64_t seed = k < FIRST ? (uint64_t)k + 1 : others[k - FIRST];
        medley s;
        medley_choice choice = medley_choose(seed);
        choice.bodies = 4 + (int)(seed % 5);
        choice.stiff = 0.0;
        const bool made = medley_make(&s, &choice);
        c.m = s.m;
        c.d = s.d;
        c.t = s.t;
        if (made) start(&c, MBSR_DAE_MOMENTUM, s.q, s.u);
        medley_free(&s);
    }
    assert_true(c.compared > 40);
}

/* ---- refusals ---- */

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    row r;
    mbsr_error error;
    mbsr_completion *c = NULL;
    mbsr_completion_info info;
    double y[6] = {0.0}, yp[6] = {0.0};
    make_row(&r, systems, 40.0, 0.0, 5.0);
    assert_refused(mbsr_completion_create(NULL, NULL, &c, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "model is NULL");
    assert_refused(mbsr_completion_create(r.m, NULL, NULL, &error), &error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "completion is NULL");
    mbsr_model *open = NULL;
    assert_ok(mbsr_model_create(NULL, &open, NULL), NULL);
    assert_refused(mbsr_completion_create(open, NULL, &c, &error), &error, MBSR_ERR_UNFINISHED,
                   MBSR_NONE, MBSR_NONE, "not finished");
    mbsr_model_destroy(open);
    assert_int_equal(mbsr_completion_solve(NULL, r.d, MBSR_DAE_MOMENTUM, 0.0, y, yp),
                     MBSR_ERR_NULL);
    c = make_completion(&r, systems);
    assert_int_equal(mbsr_completion_solve(c, NULL, MBSR_DAE_MOMENTUM, 0.0, y, yp), MBSR_ERR_NULL);
    assert_int_equal(mbsr_completion_solve(c, r.d, MBSR_DAE_MOMENTUM, 0.0, NULL, yp),
                     MBSR_ERR_NULL);
    assert_refused(mbsr_completion_solve(c, r.d, (mbsr_dae_form)9, 0.0, y, yp),
                   mbsr_completion_error(c), MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "form is 9");
    assert_int_equal(mbsr_completion_solve(c, r.d, MBSR_DAE_MOMENTUM, NAN, y, yp), MBSR_NOT_FINITE);
    const mbsr_completion_times backwards = {0.0, 1.0, 0.0, 0};
    assert_refused(mbsr_completion_set_times(c, &backwards), mbsr_completion_error(c),
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "from 1 to 0");
    assert_refused(mbsr_completion_relax(c, r.d, 0.0, 0.0, y, yp), mbsr_completion_error(c),
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "rate is 0");
    row other;
    make_row(&other, systems, 40.0, 0.0, 5.0);
    assert_int_equal(mbsr_completion_solve(c, other.d, MBSR_DAE_MOMENTUM, 0.0, y, yp),
                     MBSR_ERR_MISMATCH);
    assert_int_equal(mbsr_completion_motion(c, r.d, NULL, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_completion_solve(c, r.d, MBSR_DAE_MOMENTUM, 0.0, y, yp),
              mbsr_completion_error(c));
    assert_ok(mbsr_completion_get_info(c, &info), NULL);
    assert_true(info.residuals > 0 && info.bytes > 0);
    free_row(&other);
    mbsr_completion_destroy(c);
    mbsr_completion_destroy(NULL);
    free_row(&r);
}

/* A wheel on a spring and damper that are a closure: the loop force of that row is all of it, as
 * forward dynamics has it. */
static void a_stiff_row_has_the_force_of_its_damper(void **state)
{
    static const double z[3] = {0.0, 0.0, 1.0}, tensor[6] = {1.0, 1.0, 2.0};
    const double q = 0.4, u = -1.5, k = 3.0, damping = 0.5;
    double udot, lambda, again;
    mbsr_completion *completion;
    mbsr_body_def body = mbsr_default_body_def();
    mbsr_force_def spring = mbsr_force_joint_spring(0, 0, k, damping, 0.1);
    mbsr_model *m;
    mbsr_data *d;
    (void)state;
    body.joint = mbsr_joint_revolute(NULL, NULL, z);
    body.inertia = mbsr_inertia_rigid(1.0, NULL, tensor);
    spring.as_closure = MBSR_SPRING_LOOSE;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_completion_create(m, NULL, &completion, NULL), NULL);
    assert_ok(mbsr_completion_dynamics(completion, d, 0.0, &q, &u, NULL, &udot, &lambda),
              mbsr_completion_error(completion));
    assert_ok(mbsr_completion_motion(completion, d, NULL, NULL, NULL, &again), mbsr_data_error(d));
    assert_close(lambda, -(k * (q - 0.1) + damping * u), 1e-14);
    assert_close(udot, 0.5 * lambda, 1e-14);
    assert_close(again, lambda, 0.0);
    mbsr_completion_destroy(completion);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mass_on_a_spring_and_a_dashpot),
        cmocka_unit_test(a_mass_on_two_springs),
        cmocka_unit_test(a_stiff_row_has_the_force_of_its_damper),
        cmocka_unit_test(joint_forces_accelerate),
        cmocka_unit_test(what_nothing_determines_is_named),
        cmocka_unit_test(trees_in_space),
        cmocka_unit_test(the_matrix_of_one_state_serves_the_next),
        cmocka_unit_test(trees_of_general_bodies),
        cmocka_unit_test(mechanisms),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
