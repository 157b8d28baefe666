/* Contacts do not depend on the number of threads, nor beyond rounding on the order of bodies; and
 * Newton systems of bodies in a pile, and apart on the ground, are solved, transposed too.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <stdbool.h>
#include <stdlib.h>

enum { BODIES = 14, STATES = 6, THREADS = 3 };

/* Of each body in the order in which it is added: bodies of all shapes, and the ground. */
typedef struct pile {
    mbsr_contacts *contacts;
    mbsr_model *model;
    mbsr_data *data[THREADS];
    double q[STATES][7 * BODIES], u[STATES][6 * BODIES], a[THREADS][STATES][6 * BODIES];
} pile;

static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_BOX,      MBSR_SHAPE_SPHERE,
                                        MBSR_SHAPE_CYLINDER, MBSR_SHAPE_CAPSULE,
                                        MBSR_SHAPE_MESH,     MBSR_SHAPE_ELLIPSOID};

static void add_piece(pile *p, int number)
{
    mbsr_error error;
    const double tensor[6] = {0.02, 0.03, 0.04, 0, 0, 0}, way[3] = {0.3, -0.5, 0.8};
    const double at[3] = {number % 2 ? 0.02 : 0.0, 0.0, number % 2 ? -0.03 : 0.0}, o[3] = {0, 0, 0};
    mbsr_body_def body = mbsr_default_body_def();
    mbsr_shape shape = sample_shape(kinds[number % 6], MBSR_GROUND);
    const mbsr_frame turned = mbsr_frame_along(o, way);
    body.joint = number % 3 == 1 ? mbsr_joint_free(&turned, &turned) : mbsr_joint_free(NULL, NULL);
    body.inertia = mbsr_inertia_rigid(1.0, at, tensor);
    assert_int_equal(mbsr_model_add_body(p->model, &body, &shape.body), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(p->contacts, &shape, NULL, &error), MBSR_OK);
    const double armature[6] = {0.01, 0.01, 0.01, 0.0, 0.5, 0.0};
    if (number % 5 == 2)
        assert_int_equal(mbsr_model_armature(p->model, shape.body, 6, armature), MBSR_OK);
}

/* The same states whatever the order; place: of each piece. */
static void draw_states(pile *p, const int place[BODIES])
{
    uint64_t seed = 17;
    for (int s = 0; s < STATES; ++s) {
        for (int k = 0; k < BODIES; ++k) {
            double *q = p->q[s] + 7 * place[k], *u = p->u[s] + 6 * place[k], length = 0.0;
            for (int l = 0; l < 4; ++l) q[l] = draw(&seed), length += q[l] * q[l];
            for (int l = 0; l < 4; ++l) q[l] *= (1.0 + 0.3 * (k % 4)) / sqrt(length);
            q[4] = 0.35 * (k % 3) + 0.02 * draw(&seed);
            q[5] = 0.35 * (k / 3 % 2) + 0.02 * draw(&seed);
            q[6] = 0.2 + 0.3 * (k / 6) + 0.02 * draw(&seed);
            for (int l = 0; l < 6; ++l) u[l] = draw(&seed);
        }
    }
}

/* A spring between the first two, one from another to the ground, and a spring in a joint: bodies
 * that do not float, among others that do. */
static void add_springs(pile *p)
{
    const double at[3] = {0.05, 0.0, 0.02}, stiffness[3] = {3.0, 4.0, 5.0},
                 damping[3] = {0.1, 0.2, 0.3}, rest[4] = {1.0, 0.0, 0.0, 0.0};
    const mbsr_force_def forces[] = {
        mbsr_force_point_spring(0, at, 1, at, 50.0, 2.0, 0.1),
        mbsr_force_point_spring(3, at, MBSR_GROUND, at, 50.0, 2.0, 0.1),
        mbsr_force_joint_rotation_spring(5, stiffness, damping, rest)};
    for (int k = 0; k < 3; ++k)
        assert_int_equal(mbsr_model_add_force(p->model, forces + k, NULL), MBSR_OK);
}

static bool springs; /* of piles that are opened */

static void open_pile(pile *p, const int place[BODIES])
{
    mbsr_error error;
    mbsr_force_def force;
    const mbsr_model_def def = mbsr_default_model_def();
    const mbsr_shape ground = sample_shape(MBSR_SHAPE_PLANE, MBSR_GROUND);
    memset(p, 0, sizeof *p);
    assert_int_equal(mbsr_model_create(&def, &p->model, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_create(&p->contacts, &error), MBSR_OK);
    for (int at = 0; at < BODIES; ++at) {
        for (int k = 0; k < BODIES; ++k)
            if (place[k] == at) add_piece(p, k);
    }
    assert_int_equal(mbsr_contacts_add(p->contacts, &ground, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_force(p->contacts, 0, &force, &error), MBSR_OK);
    assert_int_equal(mbsr_model_add_force(p->model, &force, NULL), MBSR_OK);
    force = mbsr_force_gravity(0.0, 1.0, -9.81);
    assert_int_equal(mbsr_model_add_force(p->model, &force, NULL), MBSR_OK);
    if (springs) add_springs(p);
    assert_int_equal(mbsr_model_finish(p->model), MBSR_OK);
    for (int k = 0; k < THREADS; ++k)
        assert_int_equal(mbsr_data_create(p->model, p->data + k, &error), MBSR_OK);
    draw_states(p, place);
}

static void close_pile(pile *p)
{
    for (int k = 0; k < THREADS; ++k) mbsr_data_destroy(p->data[k]);
    mbsr_model_destroy(p->model);
    mbsr_contacts_destroy(p->contacts);
}

/* All states with data k; NaN where it fails. */
static void evaluate(void *user, int k)
{
    pile *p = user;
    for (int s = 0; s < STATES; ++s) {
        if (mbsr_forward_dynamics(p->model, p->data[k], 0.0, p->q[s], p->u[s], NULL, p->a[k][s]))
            p->a[k][s][0] = NAN;
    }
}

static void find_places(int place[BODIES], int step)
{
    for (int k = 0; k < BODIES; ++k) place[k] = (k * step + 3 * (step > 1)) % BODIES;
}

static void check_close(double x[STATES][6 * BODIES], double y[STATES][6 * BODIES])
{
    for (int s = 0; s < STATES; ++s) {
        double size = 1.0;
        for (int k = 0; k < 6 * BODIES; ++k) size = fmax(size, fabs(y[s][k]));
        for (int k = 0; k < 6 * BODIES; ++k) assert_close(x[s][k], y[s][k], 1e-12 * size);
    }
}

/* Several data of one model side by side, one that has its tree split, and batches. */
static void threads(void **unused)
{
    (void)unused;
    int place[BODIES];
    pile *p = malloc(sizeof *p);
    assert_non_null(p);
    find_places(place, 1);
    open_pile(p, place);
    evaluate(p, 0);
    double alone[STATES][6 * BODIES], in_batch[STATES][6 * BODIES];
    memcpy(alone, p->a[0], sizeof alone);
    for (int k = 0; k < 6 * BODIES; ++k) assert_true(isfinite(alone[0][k]));
    for (int count = 1; count <= THREADS; ++count) {
        mbsr_threads *workers = NULL;
        mbsr_split *split = NULL;
        mbsr_batch *batch = NULL;
        mbsr_error error;
        if (mbsr_threads_create(count, &workers, &error) == MBSR_ERR_UNAVAILABLE) break;
        const mbsr_parallel parallel = mbsr_threads_parallel(workers);
        memset(p->a, 0, sizeof p->a);
        parallel.run(parallel.user, THREADS, evaluate, p);
        for (int k = 0; k < THREADS; ++k) assert_memory_equal(p->a[k], alone, sizeof alone);
        assert_int_equal(mbsr_split_create(p->model, &parallel, &split, &error), MBSR_OK);
        assert_int_equal(mbsr_data_use_split(p->data[0], split), MBSR_OK);
        evaluate(p, 0);
        assert_memory_equal(p->a[0], alone, sizeof alone);
        assert_int_equal(mbsr_data_use_split(p->data[0], NULL), MBSR_OK);
        mbsr_split_destroy(split);
        if (mbsr_batch_create_parallel(p->model, &parallel, &batch, &error))
            fail_msg("%s", error.text);
        if (mbsr_batch_forward_dynamics(p->model, batch, 0.0, STATES, p->q[0], p->u[0], NULL,
                                        p->a[1][0], NULL))
            fail_msg("%s", mbsr_batch_error(batch)->text);
        if (count == 1) memcpy(in_batch, p->a[1], sizeof in_batch);
        assert_memory_equal(p->a[1], in_batch, sizeof in_batch);
        check_close(p->a[1], alone);
        mbsr_batch_destroy(batch);
        mbsr_threads_destroy(workers);
    }
    close_pile(p);
    free(p);
}

static void orders(void **unused)
{
    (void)unused;
    static const int steps[] = {1, 3, 5, 9, 13};
    pile *p = malloc(sizeof *p);
    double first[STATES][6 * BODIES], worst = 0.0;
    assert_non_null(p);
    for (int order = 0; order < 5; ++order) {
        int place[BODIES];
        find_places(place, steps[order]);
        open_pile(p, place);
        evaluate(p, 0);
        for (int s = 0; s < STATES; ++s) {
            double size = 1.0;
            for (int k = 0; k < 6 * BODIES; ++k) {
                double *of = first[s] + k, now = p->a[0][s][6 * place[k / 6] + k % 6];
                if (order == 0) *of = now;
                size = fmax(size, fabs(*of));
            }
            for (int k = 0; k < 6 * BODIES; ++k)
                worst =
                    fmax(worst, fabs(first[s][k] - p->a[0][s][6 * place[k / 6] + k % 6]) / size);
        }
        close_pile(p);
    }
    print_message("orders: off by %g\n", worst);
    assert_true(worst < 1e-12);
    free(p);
}

static int iterated; /* systems whose solutions were no elimination's alone */

/* A solve(r) = r to `error`, in a state where bodies touch each other or, `apart`, the ground
 * alone.
 */
static void check_solution(pile *p, mbsr_newton *newton, int state, bool apart, double c,
                           double error)
{
    enum { SIZE = 19 * BODIES };
    uint64_t seed = 5;
    double y[SIZE], yp[SIZE], r[SIZE], delta[SIZE], back[SIZE], largest = 1.0;
    mbsr_newton_info info;
    for (int k = 0; k < BODIES && apart; ++k) {
        p->q[state][7 * k + 4] = k;
        p->q[state][7 * k + 6] = 0.05;
    }
    assert_int_equal(mbsr_dae_size(p->model, MBSR_DAE_MOMENTUM), SIZE);
    assert_int_equal(
        mbsr_dae_pack(p->model, p->data[0], MBSR_DAE_MOMENTUM, 0.0, p->q[state], p->u[state], y),
        MBSR_OK);
    for (int k = 0; k < SIZE; ++k) yp[k] = 0.0, r[k] = draw(&seed);
    assert_int_equal(mbsr_newton_factor(newton, p->data[0], 0.0, y, yp, c), MBSR_OK);
    assert_int_equal(mbsr_newton_get_info(newton, &info), MBSR_OK);
    if (apart || error < 1e-8) assert_int_equal(info.exact, 1);
    iterated += !info.exact;
    assert_int_equal(mbsr_newton_solve(newton, r, delta), MBSR_OK);
    assert_int_equal(mbsr_newton_linearise(newton, p->data[0], 0.0, y, yp, c), MBSR_OK);
    assert_int_equal(mbsr_newton_multiply(newton, delta, back), MBSR_OK);
    for (int k = 0; k < SIZE; ++k) largest = fmax(largest, c * fabs(delta[k]));
    for (int k = 0; k < SIZE; ++k) assert_close(back[k], r[k], error * largest);
}

/* Of a pile that it opens; together, error (pairs_error): of mbsr_newton_opt. */
static mbsr_newton *newton_of(pile *p, int together, double error)
{
    int place[BODIES];
    mbsr_newton *newton = NULL;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    find_places(place, 1);
    open_pile(p, place);
    opt.products = 1;
    opt.together = together;
    opt.pairs_error = error;
    assert_int_equal(mbsr_newton_create(p->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), MBSR_OK);
    return newton;
}

static void check_newton(int together, double error, double off)
{
    pile *p = malloc(sizeof *p);
    assert_non_null(p);
    mbsr_newton *newton = newton_of(p, together, error);
    for (int s = 0; s < STATES; ++s) {
        check_solution(p, newton, s, false, 300.0, off);
        check_solution(p, newton, s, true, s % 2 ? 300.0 : 20.0, 1e-9);
    }
    mbsr_newton_destroy(newton);
    close_pile(p);
    free(p);
}

static void newton_systems(void **unused)
{
    (void)unused;
    check_newton(0, 1e-5, 1e-9);
    springs = true;
    check_newton(0, 1e-5, 1e-9);
    springs = false;
}

/* v.A^-1 r = r.A^-T v, and A^-1 r as a solver without transposes has it. */
static void transposed_systems(void **unused)
{
    (void)unused;
    enum { SIZE = 19 * BODIES };
    uint64_t seed = 9;
    double y[SIZE], yp[SIZE], r[SIZE], v[SIZE], delta[SIZE], same[SIZE], x[SIZE];
    pile *p = malloc(sizeof *p);
    assert_non_null(p);
    mbsr_newton *newton = newton_of(p, 0, 1e-5), *both = NULL;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.transposes = 1;
    assert_int_equal(mbsr_newton_create(p->model, MBSR_DAE_MOMENTUM, &opt, &both, NULL), MBSR_OK);
    for (int s = 0; s < STATES; ++s) {
        double forward = 0.0, backward = 0.0, sum = 0.0, largest = 0.0;
        assert_int_equal(
            mbsr_dae_pack(p->model, p->data[0], MBSR_DAE_MOMENTUM, 0.0, p->q[s], p->u[s], y),
            MBSR_OK);
        for (int k = 0; k < SIZE; ++k) yp[k] = 0.0, r[k] = draw(&seed), v[k] = draw(&seed);
        assert_int_equal(mbsr_newton_factor(newton, p->data[0], 0.0, y, yp, 300.0), MBSR_OK);
        assert_int_equal(mbsr_newton_factor(both, p->data[1], 0.0, y, yp, 300.0), MBSR_OK);
        assert_int_equal(mbsr_newton_solve(newton, r, delta), MBSR_OK);
        assert_int_equal(mbsr_newton_solve(both, r, same), MBSR_OK);
        assert_int_equal(mbsr_newton_solve_transposed(both, v, x), MBSR_OK);
        for (int k = 0; k < SIZE; ++k) {
            forward += v[k] * delta[k];
            backward += x[k] * r[k];
            sum += fabs(v[k] * delta[k]) + fabs(x[k] * r[k]);
            largest = fmax(largest, fabs(delta[k]));
        }
        assert_close(forward, backward, 1e-9 * sum);
        for (int k = 0; k < SIZE; ++k) assert_close(delta[k], same[k], 1e-9 * largest);
    }
    mbsr_newton_destroy(newton);
    mbsr_newton_destroy(both);
    close_pile(p);
    free(p);
}

/* Pairs that the elimination leaves out. */
static void crowds(void **unused)
{
    (void)unused;
    static const int together[] = {1, 2, 5, BODIES - 1};
    iterated = 0;
    for (int k = 0; k < 4; ++k) check_newton(together[k], 1e-5, 1e-5);
    springs = true;
    for (int k = 0; k < 3; ++k) check_newton(together[k], 1e-5, 1e-5);
    springs = false;
    assert_true(iterated > 2 * STATES);
}

/* As exactly as is asked for. */
static void crowds_as_asked(void **unused)
{
    (void)unused;
    static const int together[] = {1, 5};
    iterated = 0;
    for (int k = 0; k < 2; ++k) check_newton(together[k], 1e-9, 1e-8);
    assert_true(iterated > STATES);
}

enum { BALLS = 6 };

/* A row of balls that touch, on sliders without mass, or each second one without mass itself and in
 * a bushing; q: where they are. */
static mbsr_model *make_row(bool bare, mbsr_contacts *contacts, double q[7 * BALLS])
{
    const double up[3] = {0, 0, 1}, com[3] = {0.01, 0.02, 0}, tensor[6] = {0.02, 0.02, 0.02},
                 stiffness[6] = {3, 4, 5, 200, 300, 400}, damping[6] = {0.3, 0.4, 0.5, 2, 3, 4};
    mbsr_error error;
    mbsr_model *m;
    mbsr_force_def touch;
    assert_int_equal(mbsr_model_create(NULL, &m, &error), MBSR_OK);
    for (int k = 0; k < BALLS; ++k) {
        const mbsr_frame at = mbsr_frame_at(0.19 * k, 0.01 * k, 0.0);
        mbsr_shape ball = sample_shape(MBSR_SHAPE_SPHERE, MBSR_GROUND);
        mbsr_body_def body = mbsr_default_body_def();
        ball.size[0] = 0.1;
        body.joint = bare ? mbsr_joint_free(&at, NULL) : mbsr_joint_prismatic(&at, NULL, up);
        body.inertia = mbsr_inertia_zero();
        if (!bare) {
            assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
            body.joint = mbsr_joint_spherical(NULL, NULL);
        }
        if (!bare || k % 2 == 0) body.inertia = mbsr_inertia_rigid(1.0 + 0.1 * k, com, tensor);
        assert_ok(mbsr_model_add_body(m, &body, &ball.body), mbsr_model_error(m));
        const mbsr_force_def hold =
            bare ? mbsr_force_bushing(MBSR_GROUND, &at, ball.body, NULL, stiffness, damping)
                 : mbsr_force_joint_spring(body.parent, 0, 30.0, 2.0, 0.0);
        assert_ok(mbsr_model_add_force(m, &hold, NULL), mbsr_model_error(m));
        assert_int_equal(mbsr_contacts_add(contacts, &ball, NULL, &error), MBSR_OK);
        q[bare ? 7 * k : 5 * k + 1] = 1.0;
    }
    assert_int_equal(mbsr_contacts_force(contacts, 0, &touch, &error), MBSR_OK);
    assert_ok(mbsr_model_add_force(m, &touch, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Forces of pairs found by GMRES are those of the elimination. */
static void crowds_without_mass(void **unused)
{
    (void)unused;
    enum { MOST = 19 * BALLS };
    for (int bare = 0; bare < 2; ++bare) {
        mbsr_error error;
        mbsr_data *d;
        mbsr_contacts *contacts;
        double q[7 * BALLS] = {0.0}, u[6 * BALLS], y[MOST], yp[MOST], r[MOST], x[2][MOST];
        uint64_t seed = 3;
        assert_int_equal(mbsr_contacts_create(&contacts, &error), MBSR_OK);
        mbsr_model *m = make_row(bare, contacts, q);
        assert_ok(mbsr_data_create(m, &d, &error), &error);
        const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
        for (int k = 0; k < mbsr_model_nu(m); ++k) u[k] = 0.3 * draw(&seed);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        for (int k = 0; k < size; ++k) yp[k] = draw(&seed), r[k] = draw(&seed);
        for (double c = 3.0; c < 1e4; c *= 30.0) {
            double largest = 0.0;
            for (int together = 0; together < 2; ++together) {
                mbsr_newton_opt opt = mbsr_default_newton_opt();
                mbsr_newton *newton;
                opt.together = together;
                opt.pairs_error = 1e-10;
                assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
                assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, c), mbsr_newton_error(newton));
                assert_ok(mbsr_newton_solve(newton, r, x[together]), mbsr_newton_error(newton));
                mbsr_newton_destroy(newton);
            }
            for (int k = 0; k < size; ++k) largest = fmax(largest, fabs(x[0][k]));
            for (int k = 0; k < size; ++k) assert_close(x[1][k], x[0][k], 1e-8 * largest);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
        mbsr_contacts_destroy(contacts);
    }
}

/* Steps far longer than the periods of contacts: no convergence; the next matrix eliminates all. */
static void too_stiff(void **unused)
{
    (void)unused;
    enum { SIZE = 19 * BODIES };
    uint64_t seed = 5;
    int failed = 0;
    pile *p = malloc(sizeof *p);
    assert_non_null(p);
    mbsr_newton *newton = newton_of(p, 1, 1e-5);
    for (int s = 0; s < STATES; ++s) {
        double y[SIZE], yp[SIZE] = {0.0}, r[SIZE], delta[SIZE], zero[6 * BODIES] = {0.0};
        for (int k = 0; k < SIZE; ++k) r[k] = draw(&seed), delta[k] = 7.0;
        assert_int_equal(
            mbsr_dae_pack(p->model, p->data[0], MBSR_DAE_MOMENTUM, 0.0, p->q[s], p->u[s], y),
            MBSR_OK);
        assert_int_equal(mbsr_newton_factor(newton, p->data[0], 0.0, y, yp, 1e-4), MBSR_OK);
        const int status = mbsr_newton_solve(newton, r, delta);
        if (status == MBSR_OK) continue;
        ++failed;
        assert_int_equal(status, MBSR_NO_CONVERGENCE);
        assert_non_null(strstr(mbsr_newton_error(newton)->text, "do not converge"));
        assert_int_equal(mbsr_newton_solve_sensitivity(newton, zero, r, delta),
                         MBSR_NO_CONVERGENCE);
        for (int k = 0; k < SIZE; ++k) assert_true(delta[k] == 7.0);
        assert_int_equal(mbsr_newton_factor(newton, p->data[0], 0.0, y, yp, 1e-4), MBSR_OK);
        assert_int_equal(mbsr_newton_solve(newton, r, delta), MBSR_OK);
    }
    print_message("%d of %d solutions did not converge\n", failed, STATES);
    assert_true(failed > 0);
    mbsr_newton_destroy(newton);
    close_pile(p);
    free(p);
}

static void refused(void **unused)
{
    (void)unused;
    int place[BODIES];
    pile *p = malloc(sizeof *p);
    mbsr_newton *newton = NULL;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_error error;
    assert_non_null(p);
    find_places(place, 1);
    open_pile(p, place);
    opt.together = -1;
    assert_int_equal(mbsr_newton_create(p->model, MBSR_DAE_MOMENTUM, &opt, &newton, &error),
                     MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "together is -1"));
    opt.together = 1;
    for (int k = 0; k < 3; ++k) {
        opt.pairs_error = k == 0 ? 0.0 : k == 1 ? 1.0 : NAN;
        assert_int_equal(mbsr_newton_create(p->model, MBSR_DAE_MOMENTUM, &opt, &newton, &error),
                         MBSR_ERR_VALUE);
        assert_non_null(strstr(error.text, "pairs_error"));
    }
    close_pile(p);
    free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(threads),
                                       cmocka_unit_test(orders),
                                       cmocka_unit_test(newton_systems),
                                       cmocka_unit_test(transposed_systems),
                                       cmocka_unit_test(crowds),
                                       cmocka_unit_test(crowds_as_asked),
                                       cmocka_unit_test(crowds_without_mass),
                                       cmocka_unit_test(too_stiff),
                                       cmocka_unit_test(refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
