/* Armature: inertia along joint rates, against the dense mass matrix of the same tree without it,
 * and against a rotor behind gears.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "oracle.h"
#include "rigid_tree.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of tree k two of a kind: with armature and without. */
static test_rigid_choice choice_of(int k)
{
    return (test_rigid_choice){.seed = 400 + (uint64_t)k,
                               .bodies = 1 + k % 14,
                               .massless = k % 3 == 2 ? 0.5 : 0.0,
                               .points = 0.3 * (k % 2),
                               .many = 0.25 * (k % 4),
                               .branching = 0.3 * (k % 4),
                               .length = 1.0,
                               .forces = k % 3,
                               .moving = k % 5 == 4,
                               .shuffle = k % 4 == 1,
                               .held = k % 6 == 5 ? 0.3 : 0.0,
                               .added = k % 7 == 6 ? 0.3 : 0.0,
                               .tables = k % 5 == 3};
}

typedef struct pair {
    test_rigid_tree with, without;
    int n;
    double *a;          /* n: armature by the order of u */
    double *M, *plain;  /* n x n: mass matrices of both */
    double *bias, *out; /* n */
} pair;

static void make_pair(pair *p, int k)
{
    test_rigid_choice choice = choice_of(k);
    test_rigid_tree_make(&p->without, choice);
    choice.armature = 0.6;
    test_rigid_tree_make(&p->with, choice);
    const int n = p->n = p->with.nu;
    const size_t nn = (size_t)(n * n) + 1;
    p->a = calloc(2 * nn + 3 * (size_t)n + 1, sizeof(double));
    p->M = p->a + n, p->plain = p->M + nn, p->bias = p->plain + nn, p->out = p->bias + n;
    for (int i = 0; i < choice.bodies; ++i) {
        int u, own;
        assert_ok(mbsr_body_coordinates(p->with.model, i, NULL, NULL, &u, &own), NULL);
        memcpy(p->a + u, mbsr_body_armature(p->with.model, i), (size_t)own * sizeof(double));
        for (int l = 0; l < own; ++l)
            assert_true(mbsr_body_armature(p->without.model, i)[l] == 0.0);
    }
}

static void drop_pair(pair *p)
{
    test_rigid_tree_free(&p->with);
    test_rigid_tree_free(&p->without);
    free(p->a);
}

static void mass_matrix(const test_rigid_tree *s, double *M)
{
    assert_ok(mbsr_stage_positions(s->model, s->data, s->t, s->q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->u), mbsr_data_error(s->data));
    assert_ok(mbsr_mass_matrix(s->model, s->data, M), mbsr_data_error(s->data));
}

static void masses_momenta_and_energies_grow_by_it(void **state)
{
    (void)state;
    for (int k = 0; k < 60; ++k) {
        pair p;
        double T, plain_T;
        make_pair(&p, k);
        const test_rigid_tree *s = &p.with, *o = &p.without;
        mass_matrix(s, p.M);
        mass_matrix(o, p.plain);
        const double size = 1.0 + test_largest(p.n * p.n, p.M);
        for (int l = 0; l < p.n; ++l) p.plain[l * (p.n + 1)] += p.a[l];
        for (int l = 0; l < p.n * p.n; ++l) assert_close(p.M[l], p.plain[l], 1e-15 * size);
        assert_ok(mbsr_momenta(s->model, s->data, p.bias), mbsr_data_error(s->data));
        assert_ok(mbsr_momenta(o->model, o->data, p.out), mbsr_data_error(o->data));
        assert_ok(mbsr_energy(s->model, s->data, &T, NULL), mbsr_data_error(s->data));
        assert_ok(mbsr_energy(o->model, o->data, &plain_T, NULL), mbsr_data_error(o->data));
        for (int l = 0; l < p.n; ++l) {
            assert_close(p.bias[l], p.out[l] + p.a[l] * s->u[l], 1e-13 * size);
            plain_T += 0.5 * p.a[l] * s->u[l] * s->u[l];
        }
        assert_close(T, plain_T, 1e-13 * (1.0 + T));
        drop_pair(&p);
    }
}

/* By the dense mass matrix, where it is regular. */
static void accelerations_are_those_of_the_dense_equations(void **state)
{
    (void)state;
    int regular = 0, more = 0;
    for (int k = 0; k < 120; ++k) {
        pair p;
        make_pair(&p, k);
        const test_rigid_tree *s = &p.with, *o = &p.without;
        assert_ok(mbsr_bias_forces(o->model, o->data, o->t, o->q, o->u, p.bias),
                  mbsr_data_error(o->data));
        mass_matrix(o, p.plain);
        const int plain =
            mbsr_forward_dynamics(o->model, o->data, o->t, o->q, o->u, o->tau, o->udot);
        const int status =
            mbsr_forward_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, s->udot);
        assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
        assert_true(status == MBSR_OK || plain == MBSR_UNDETERMINED);
        more += status == MBSR_OK && plain == MBSR_UNDETERMINED;
        if (status == MBSR_OK) {
            ++regular;
            for (int l = 0; l < p.n; ++l) {
                p.plain[l * (p.n + 1)] += p.a[l];
                p.out[l] = s->tau[l] - p.bias[l];
            }
            test_solve(p.n, p.plain, p.out);
            const double size = 1.0 + test_largest(p.n, p.out);
            for (int l = 0; l < p.n; ++l) assert_close(s->udot[l], p.out[l], 1e-7 * size);
            assert_ok(
                mbsr_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, s->udot, NULL, p.out),
                mbsr_data_error(s->data));
            for (int l = 0; l < p.n; ++l)
                assert_close(p.out[l], s->tau[l], 1e-9 * (1.0 + test_largest(p.n, p.bias) + size));
        }
        drop_pair(&p);
    }
    print_message("%d of 120 trees regular, %d by their armature alone\n", regular, more);
    assert_true(regular > 80 && more > 2);
}

/* The same accelerations satisfy every form: y' by them, F = 0. */
static void every_form_has_them(void **state)
{
    static const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1, MBSR_DAE_RECURSIVE,
                                          MBSR_DAE_INVERSE_DYNAMICS};
    (void)state;
    int checked = 0;
    for (int k = 0; k < 120; ++k) {
        pair p;
        make_pair(&p, k);
        const test_rigid_tree *s = &p.with;
        if (mbsr_forward_dynamics(s->model, s->data, s->t, s->q, s->u, NULL, s->udot) ||
            k % 5 == 3) { /* rates by differences have fewer digits */
            drop_pair(&p);
            continue;
        }
        ++checked;
        for (size_t f = 0; f < 4; ++f) {
            const int size = mbsr_dae_size(s->model, forms[f]), N = size + 1;
            double *y = calloc(4 * (size_t)N, sizeof *y), *yp = y + N, *F = yp + N, *back = F + N;
            assert_ok(mbsr_dae_pack(s->model, s->data, forms[f], s->t, s->q, s->u, y),
                      mbsr_data_error(s->data));
            /* with y' = 0 F_q = -q', F_p = -p' */
            assert_ok(mbsr_dae_residual(s->model, s->data, forms[f], s->t, y, yp, F),
                      mbsr_data_error(s->data));
            const double scale = 1.0 + test_largest(size, F) + test_largest(s->nu, s->udot);
            for (int l = 0; l < s->nq; ++l) yp[l] = -F[l];
            if (f == 0) {
                for (int l = 0; l < s->nu; ++l) {
                    yp[s->nq + l] = -F[s->nq + l];
                    yp[s->nq + s->nu + l] = s->udot[l];
                    assert_close(F[s->nq + s->nu + l], 0.0, 1e-9 * scale);
                }
            } else if (f == 1) { /* all rates have inertia: v' is -F there */
                for (int l = 0; l < s->nu; ++l) yp[s->nq + l] = -F[s->nq + l];
                assert_ok(mbsr_dae_unpack(s->model, s->data, forms[f], s->t, y, back, back + s->nq),
                          mbsr_data_error(s->data));
                for (int l = 0; l < s->nu; ++l)
                    assert_close(back[s->nq + l], s->u[l], 1e-9 * scale);
            } else {
                memcpy(yp + s->nq, s->udot, (size_t)s->nu * sizeof *yp);
            }
            assert_ok(mbsr_dae_residual(s->model, s->data, forms[f], s->t, y, yp, F),
                      mbsr_data_error(s->data));
            for (int l = 0; l < size; ++l) assert_close(F[l], 0.0, 1e-8 * scale);
            free(y);
        }
        drop_pair(&p);
    }
    print_message("%d trees\n", checked);
    assert_true(checked > 50);
}

/* ---- what small models show ---- */

static const double z_axis[3] = {0.0, 0.0, 1.0};

static mbsr_model *empty(void)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static int add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.name = "link";
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

static void release(mbsr_model *m, mbsr_data *d)
{
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* A rotor with moment J on the same axis that turns `ratio` times as fast: armature J ratio^2,
 * where the wheel's own tilt does not matter. */
static void a_rotor_behind_gears_is_armature(void **state)
{
    (void)state;
    const double J = 3e-4, ratio = 50.0, armature = J * ratio * ratio, tau[2] = {1.3, 0.0},
                 com[3] = {0.4, 0.1, 0.0}, I[6] = {0.1, 0.2, 0.25, 0.0, 0.0, 0.0},
                 wheel[6] = {J, J, J, 0.0, 0.0, 0.0}, coefficient[2] = {ratio, -1.0};
    const int bodies[2] = {0, 1}, coordinates[2] = {0, 0};
    double q[2] = {0.7, 0.7 * ratio}, u[2] = {0.3, 0.3 * ratio}, one, both[2];
    mbsr_model *m = empty(), *geared = empty();
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), NULL);
    assert_ok(mbsr_model_add_force(geared, &gravity, NULL), NULL);
    add(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis), mbsr_inertia_rigid(2.0, com, I));
    assert_ok(mbsr_model_armature(m, 0, 1, &armature), mbsr_model_error(m));
    add(geared, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis),
        mbsr_inertia_rigid(2.0, com, I));
    add(geared, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis),
        mbsr_inertia_rigid(0.1, NULL, wheel));
    const mbsr_closure_def gear = mbsr_closure_coupling(2, bodies, coordinates, coefficient, 0.0);
    assert_ok(mbsr_model_add_closure(geared, &gear, NULL), mbsr_model_error(geared));
    mbsr_data *d = finish(m), *dg = finish(geared);
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, tau, &one), mbsr_data_error(d));
    assert_ok(mbsr_forward_dynamics(geared, dg, 0.0, q, u, tau, both), mbsr_data_error(dg));
    assert_close(one, both[0], 1e-12);
    assert_close(one * ratio, both[1], 1e-10);
    release(m, d);
    release(geared, dg);
}

/* A massless link between two others: nothing but its armature moves with it alone. */
static void it_makes_massless_links_determined(void **state)
{
    (void)state;
    const double tiny[] = {0.0, 1e-30, 1e-12, 1.0};
    const mbsr_frame tip = mbsr_frame_at(1.0, 0.0, 0.0);
    for (int k = 0; k < 4; ++k) {
        const double q[2] = {0.2, 0.1}, u[2] = {0.0, 0.0}, tau[2] = {0.0, tiny[k]};
        double udot[2];
        int rank;
        mbsr_model *m = empty();
        mbsr_index_report *report;
        add(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z_axis),
            mbsr_inertia_point_mass(1.0, tip.x));
        add(m, 0, mbsr_joint_revolute(&tip, NULL, z_axis), mbsr_inertia_zero());
        assert_ok(mbsr_model_armature(m, 1, 1, tiny + k), mbsr_model_error(m));
        mbsr_data *d = finish(m);
        const int status = mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot);
        assert_int_equal(status, k == 0 ? MBSR_UNDETERMINED : MBSR_OK);
        if (k > 0) assert_close(udot[1], 1.0, 1e-12);
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
        assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
        assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
        rank = mbsr_total_rank(m, d);
        assert_int_equal(rank, k == 0 ? 1 : 2);
        assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->directions, k == 0 ? 1 : 0);
        mbsr_index_report_destroy(m, report);
        release(m, d);
    }
}

static void locked_coordinates_leave_theirs_out(void **state)
{
    (void)state;
    const double three[3] = {1.0, 2.0, 3.0};
    mbsr_model *m = empty();
    add(m, MBSR_GROUND, mbsr_joint_translational(NULL, NULL), mbsr_inertia_particle(1.0));
    assert_ok(mbsr_model_lock(m, 0, 1, 0.0), mbsr_model_error(m));
    assert_ok(mbsr_model_armature(m, 0, 3, three), mbsr_model_error(m));
    mbsr_data *d = finish(m);
    const double *a = mbsr_body_armature(m, 0);
    assert_true(a[0] == 1.0 && a[1] == 3.0);
    release(m, d);
}

static void wrong_values_are_refused_by_name(void **state)
{
    (void)state;
    const double wrong[2] = {1.0, -2.0}, infinite[2] = {INFINITY, 0.0}, three[3] = {1.0, 1.0, 2.0},
                 good[2] = {0.1, 0.2}, better[2] = {0.3, 0.0};
    mbsr_model *m = empty();
    const mbsr_error *e = mbsr_model_error(m);
    add(m, MBSR_GROUND, mbsr_joint_cylindrical(NULL, NULL, z_axis), mbsr_inertia_particle(1.0));
    add(m, 0, mbsr_joint_spherical(NULL, NULL), mbsr_inertia_particle(1.0));
    assert_int_equal(mbsr_model_armature(NULL, 0, 2, good), MBSR_ERR_NULL);
    assert_null(mbsr_body_armature(m, 0));
    assert_refused(mbsr_model_armature(m, 2, 2, good), e, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                   "no body 2");
    assert_refused(mbsr_model_armature(m, 0, 2, NULL), e, MBSR_ERR_NULL, 0, MBSR_NONE,
                   "link|values");
    assert_refused(mbsr_model_armature(m, 0, 1, good), e, MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "link|n is 1|cylindrical|2 rates");
    assert_refused(mbsr_model_armature(m, 0, 2, wrong), e, MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "link|values[1] is -2");
    assert_refused(mbsr_model_armature(m, 0, 2, infinite), e, MBSR_ERR_VALUE, 0, MBSR_NONE,
                   "values[0] is inf");
    assert_refused(mbsr_model_armature(m, 1, 3, three), e, MBSR_ERR_VALUE, 1, MBSR_NONE,
                   "values[2] is 2|quaternion|spherical");
    assert_ok(mbsr_model_armature(m, 0, 2, good), e);
    assert_ok(mbsr_model_armature(m, 0, 2, better), e);
    mbsr_data *d = finish(m);
    assert_true(mbsr_body_armature(m, 0)[0] == 0.3 && mbsr_body_armature(m, 0)[1] == 0.0);
    assert_true(mbsr_body_armature(m, 1)[2] == 0.0);
    assert_null(mbsr_body_armature(m, 2));
    assert_int_equal(mbsr_model_armature(m, 0, 2, good), MBSR_ERR_FINISHED);
    release(m, d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masses_momenta_and_energies_grow_by_it),
        cmocka_unit_test(accelerations_are_those_of_the_dense_equations),
        cmocka_unit_test(every_form_has_them),
        cmocka_unit_test(a_rotor_behind_gears_is_armature),
        cmocka_unit_test(it_makes_massless_links_determined),
        cmocka_unit_test(locked_coordinates_leave_theirs_out),
        cmocka_unit_test(wrong_values_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
