/* Parameters by name: models and data with other values against models that were built with them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "medley.h"
#include "rigid_tree.h"

#include <mbsrank/parameters.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 400 };

static mbsr_parameters *list_of(const mbsr_model *m)
{
    mbsr_parameters *list;
    mbsr_error error;
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    return list;
}

/* ---- a pendulum: a point mass m at l on a rod, torsion spring c, gravity g ---- */

static mbsr_model *make_pendulum(double mass, double length, double stiffness, mbsr_table *torque)
{
    mbsr_model *m;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, &error), &error);
    const double x[3] = {1.0, 0.0, 0.0}, below[3] = {0.0, 0.0, -length};
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "rod";
    body.joint = mbsr_joint_revolute(NULL, NULL, x);
    body.inertia = mbsr_inertia_point_mass(mass, below);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    mbsr_force_def force = mbsr_force_gravity(0.0, 0.0, -10.0);
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    force = mbsr_force_joint_spring(0, 0, stiffness, 0.0, 0.0);
    force.name = "my spring";
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    if (torque) {
        force = mbsr_force_joint_applied(0, mbsr_table_force, torque);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static double acceleration(const mbsr_model *m, mbsr_data *d, double q)
{
    const double u = 0.0;
    double udot = NAN;
    assert_ok(mbsr_forward_dynamics(m, d, 0.0, &q, &u, NULL, &udot), mbsr_data_error(d));
    return udot;
}

/* Data with the values of the parameters named. */
static mbsr_data *data_with(const mbsr_parameters *list, int count, const char *const *name,
                            const double *value)
{
    int which[MOST];
    mbsr_data *d;
    mbsr_error error;
    for (int k = 0; k < count; ++k) {
        which[k] = mbsr_parameters_find(list, name[k]);
        assert_true(which[k] >= 0);
    }
    assert_ok(mbsr_parameters_data(list, count, which, value, &d, &error), &error);
    return d;
}

static void names_and_values_of_a_pendulum(void **state)
{
    (void)state;
    mbsr_model *m = make_pendulum(2.0, 0.5, 3.0, NULL);
    mbsr_parameters *list = list_of(m);
    static const struct {
        const char *name, *unit;
        double value;
    } expected[] = {{"bodies.rod.mass", "kg", 2.0},
                    {"bodies.rod.com[3]", "m", -0.5},
                    {"bodies.rod.Ixy", "kg.m2", 0.0},
                    {"bodies.rod.armature", "kg.m2", 0.0},
                    {"bodies.rod.joint_position[2]", "m", 0.0},
                    {"forces.force0.gz", "m/s2", -10.0},
                    {"forces.'my spring'.stiffness", "N.m/rad", 3.0},
                    {"forces.'my spring'.rest", "rad", 0.0}};
    for (size_t k = 0; k < sizeof expected / sizeof *expected; ++k) {
        mbsr_parameter p;
        const int at = mbsr_parameters_find(list, expected[k].name);
        assert_int_equal(mbsr_parameter_get(list, at, &p), MBSR_OK);
        assert_string_equal(p.name, expected[k].name);
        assert_string_equal(p.unit, expected[k].unit);
        assert_true(p.value == expected[k].value);
    }
    assert_int_equal(mbsr_parameters_find(list, "bodies.rod.weight"), MBSR_NONE);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
}

/* u' = -(g/l sin q) - c q / (m l^2); the shared model and its data stay as they are, and the list
 * outlives the model. */
static void data_with_other_masses_lengths_and_springs(void **state)
{
    (void)state;
    const double q = 0.3;
    mbsr_model *m = make_pendulum(2.0, 0.5, 3.0, NULL);
    mbsr_data *shared;
    assert_ok(mbsr_data_create(m, &shared, NULL), NULL);
    mbsr_parameters *list = list_of(m);
    static const char *const names[] = {"bodies.rod.mass", "bodies.rod.com[3]",
                                        "forces.'my spring'.stiffness"};
    const double before = acceleration(m, shared, q), value[] = {5.0, -0.8, 7.0};
    mbsr_data *other = data_with(list, 3, names, value);
    assert_true(mbsr_data_model(shared) == m && mbsr_data_model(other) != m);
    assert_close(acceleration(mbsr_data_model(other), other, q),
                 -10.0 / 0.8 * sin(q) - 7.0 * q / (5.0 * 0.8 * 0.8), 1e-13);
    assert_close(before, -20.0 * sin(q) - 3.0 * q / 0.5, 1e-13);
    assert_true(acceleration(m, shared, q) == before);
    double udot;
    assert_int_equal(mbsr_forward_dynamics(m, other, 0.0, &q, &q, NULL, &udot), MBSR_ERR_MISMATCH);
    mbsr_data_destroy(shared);
    mbsr_model_destroy(m);
    mbsr_data *again = data_with(list, 3, names, value);
    assert_true(acceleration(mbsr_data_model(again), again, q) ==
                acceleration(mbsr_data_model(other), other, q));
    mbsr_data_destroy(again);
    mbsr_data_destroy(other);
    mbsr_parameters_destroy(list);
}

/* A mass of zero is no mass: the rank falls, and an armature brings it back. */
static void ranks_are_those_of_the_values(void **state)
{
    (void)state;
    mbsr_model *m = make_pendulum(2.0, 0.5, 3.0, NULL);
    mbsr_parameters *list = list_of(m);
    static const char *const names[] = {"bodies.rod.mass", "bodies.rod.armature"};
    mbsr_rank_info info;
    for (int with = 0; with < 2; ++with) {
        const double value[] = {0.0, 0.25};
        mbsr_data *d = data_with(list, 1 + with, names, value);
        const double q = 0.4, zero = 0.0;
        double udot = NAN;
        assert_int_equal(mbsr_forward_dynamics(mbsr_data_model(d), d, 0.0, &q, &zero, NULL, &udot),
                         with ? MBSR_OK : MBSR_UNDETERMINED);
        assert_ok(mbsr_body_rank(mbsr_data_model(d), d, 0, &info), mbsr_data_error(d));
        assert_int_equal(info.rank, with);
        if (with) assert_close(udot, -3.0 * 0.4 / 0.25, 1e-13);
        mbsr_data_destroy(d);
    }
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
}

/* Entries of a table; a model with its own table is listed and changed in turn. */
static void entries_of_tables(void **state)
{
    (void)state;
    const double x[] = {0.0, 1.0}, value[] = {4.0, 6.0};
    mbsr_table_def def = mbsr_default_table_def();
    def.points = 2, def.x = x, def.value = value;
    mbsr_table *torque;
    assert_ok(mbsr_table_create(&def, &torque, NULL), NULL);
    mbsr_model *m = make_pendulum(2.0, 0.5, 0.0, torque), *own, *last;
    mbsr_parameters *list = list_of(m), *second;
    const int entry = mbsr_parameters_find(list, "tables.table1.value[1]"),
              point = mbsr_parameters_find(list, "tables.table1.x[2]");
    mbsr_error error;
    double read;
    assert_true(entry >= 0 && point >= 0);
    assert_ok(mbsr_parameters_model(list, 1, &entry, &(double){-1.0}, &own, &error), &error);
    second = list_of(own);
    mbsr_model_destroy(own);
    assert_ok(mbsr_parameters_model(second, 1, &point, &(double){4.0}, &last, &error), &error);
    mbsr_parameters_destroy(second);
    mbsr_data *d;
    assert_ok(mbsr_data_create(last, &d, NULL), NULL);
    assert_close(acceleration(last, d, 0.0), -1.0 / 0.5, 1e-13);
    const double zero = 0.0;
    assert_ok(mbsr_forward_dynamics(last, d, 2.0, &zero, &zero, NULL, &read), NULL);
    assert_close(read, 2.5 / 0.5, 1e-13);
    mbsr_data_destroy(d);
    mbsr_model_destroy(last);
    const int both[] = {point, entry};
    assert_refused(mbsr_parameters_model(list, 2, both, (double[]){-1.0, 2.0}, &own, &error),
                   &error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "x[1]|-1");
    assert_null(own);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
    mbsr_table_destroy(torque);
}

static void what_is_refused_and_how(void **state)
{
    (void)state;
    mbsr_model *m = make_pendulum(2.0, 0.5, 3.0, NULL), *made;
    mbsr_parameters *list = list_of(m);
    mbsr_error error;
    const int mass = mbsr_parameters_find(list, "bodies.rod.mass"),
              arm = mbsr_parameters_find(list, "bodies.rod.armature"),
              tensor = mbsr_parameters_find(list, "bodies.rod.Ixx"),
              spring = mbsr_parameters_find(list, "forces.'my spring'.stiffness"), none = 10000;
    const double minus = -1.0, one = 1.0;
#define REFUSED(which, value, status, body, force, words)                                          \
    made = m;                                                                                      \
    assert_refused(mbsr_parameters_model(list, 1, which, value, &made, &error), &error, status,    \
                   body, force, words);                                                            \
    assert_null(made)
    REFUSED(&mass, &minus, MBSR_ERR_VALUE, 0, MBSR_NONE, "'rod'|mass|-1");
    REFUSED(&arm, &minus, MBSR_ERR_VALUE, 0, MBSR_NONE, "'rod'|armature|-1");
    REFUSED(&tensor, &one, MBSR_ERR_VALUE, 0, MBSR_NONE, "'rod'|principal");
    REFUSED(&spring, &minus, MBSR_ERR_VALUE, MBSR_NONE, 1, "'my spring'|stiffness|-1");
    REFUSED(&none, &one, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, "which[0]|10000");
    REFUSED(&spring, &(double){NAN}, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "stiffness|nan");
    REFUSED(NULL, &one, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "which");
    assert_int_equal(mbsr_parameters_model(NULL, 0, NULL, NULL, &made, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_parameters_data(list, 0, NULL, NULL, NULL, &error), MBSR_ERR_NULL);
    mbsr_parameters_destroy(list);
    assert_int_equal(mbsr_parameters_create(NULL, &list, &error), MBSR_ERR_NULL);
    assert_null(list);
    list = list_of(m);
    mbsr_parameter p;
    assert_int_equal(mbsr_parameter_get(list, -1, &p), MBSR_ERR_ID);
    assert_int_equal(mbsr_parameter_get(NULL, 0, &p), MBSR_ERR_NULL);
    assert_int_equal(mbsr_parameters_count(NULL), -1);
    assert_null(mbsr_data_model(NULL));
    mbsr_parameters_destroy(list);
    mbsr_parameters_destroy(NULL);
    mbsr_model_destroy(m);
}

/* ---- random models ---- */

/* All parameters, and others near them: what is zero stays. The rates of quaternions have the same
 * armature. */
static int others(const mbsr_parameters *list, int *which, double *own, double *other)
{
    const int count = mbsr_parameters_count(list);
    for (int k = 0; k < count; ++k) {
        mbsr_parameter p;
        assert_ok(mbsr_parameter_get(list, k, &p), NULL);
        which[k] = k;
        own[k] = p.value;
        other[k] = p.value * (1.0 + 0.02 * (p.part == MBSR_PARAMETER_ARMATURE ? 1 : (k % 5)) / 5.0);
        if (p.part == MBSR_PARAMETER_TENSOR) other[k] = p.value * 1.01;
        if (p.part == MBSR_PARAMETER_POINT) other[k] = p.value;
    }
    return count;
}

/* Same status, and same bits of u', from both models. */
static bool same_motion(const mbsr_model *a, const mbsr_model *b, double t, const double *q,
                        const double *u)
{
    const mbsr_model *const m[] = {a, b};
    const size_t nu = (size_t)mbsr_model_nu(a);
    double *udot = calloc(2 * nu + 1, sizeof *udot);
    int status[2];
    for (int k = 0; k < 2; ++k) {
        const size_t size = (mbsr_data_size(m[k]) + 63) / 64 * 64;
        mbsr_data *d;
        void *memory = aligned_alloc(MBSR_DATA_ALIGNMENT, size);
        memset(memory, 0, size);
        assert_ok(mbsr_data_init(m[k], memory, size, &d, NULL), NULL);
        status[k] = mbsr_forward_dynamics(m[k], d, t, q, u, NULL, udot + (size_t)k * nu);
        free(memory);
    }
    const bool same =
        status[0] == status[1] && (status[0] || memcmp(udot, udot + nu, nu * sizeof *udot) == 0);
    free(udot);
    return same;
}

/* There and back: with the values that it has a model is what it was, in models of everything. */
static void back_to_the_values_it_had(void **state)
{
    (void)state;
    int changed = 0, made = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        medley s;
        const medley_choice c = medley_choose(seed);
        if (!medley_make(&s, &c)) {
            medley_free(&s);
            continue;
        }
        mbsr_parameters *list = list_of(s.m);
        const size_t count = (size_t)mbsr_parameters_count(list);
        int *which = calloc(count + 1, sizeof *which);
        double *own = calloc(2 * count + 1, sizeof *own), *other = own + count;
        others(list, which, own, other);
        mbsr_model *same, *different, *back;
        mbsr_error error;
        assert_ok(mbsr_parameters_model(list, (int)count, which, own, &same, &error), &error);
        assert_true(same_motion(s.m, same, s.t, s.q, s.u));
        if (mbsr_parameters_model(list, (int)count, which, other, &different, &error) == MBSR_OK) {
            mbsr_parameters *second = list_of(different);
            assert_int_equal(mbsr_parameters_count(second), (int)count);
            assert_ok(mbsr_parameters_model(second, (int)count, which, own, &back, &error), &error);
            changed += !same_motion(s.m, different, s.t, s.q, s.u);
            assert_int_equal(mbsr_model_nu(back), s.nu);
            mbsr_parameters_destroy(second);
            mbsr_model_destroy(different);
            mbsr_model_destroy(back);
            ++made;
        }
        mbsr_model_destroy(same);
        free(which), free(own);
        mbsr_parameters_destroy(list);
        medley_free(&s);
    }
    assert_true(made > 20 && changed > 15);
}

/* The number of a definition that a parameter is. */
static void set_in_body(mbsr_body_def *def, double *armature, const mbsr_parameter *p, double value)
{
    mbsr_inertia *i = &def->inertia;
    const double was = p->value;
    const bool A = strstr(p->name, "joint_position") != NULL;
    switch (p->part) {
    case MBSR_PARAMETER_MASS: i->mass = value; break;
    case MBSR_PARAMETER_COM: i->com[p->index] = value; break;
    case MBSR_PARAMETER_TENSOR: i->tensor[p->index] = value; break;
    case MBSR_PARAMETER_ARMATURE: armature[p->index] = value; break;
    case MBSR_PARAMETER_JOINT: def->joint.param[(A ? 0 : 12) + p->index] = value; break;
    default: fail();
    }
    if ((p->part == MBSR_PARAMETER_COM || p->part == MBSR_PARAMETER_TENSOR) && value != was)
        i->exact = 0;
}

/* The same model built part by part, with the other values. */
static mbsr_model *rebuilt(const mbsr_model *m, const mbsr_parameters *list, const double *value)
{
    mbsr_model_def def;
    mbsr_model *made;
    int at = 0;
    const int count = mbsr_parameters_count(list);
    mbsr_parameter p;
    assert_ok(mbsr_model_definition(m, &def), NULL);
    assert_ok(mbsr_model_create(&def, &made, NULL), NULL);
    for (int k = 0; k < mbsr_model_bodies(m); ++k) {
        mbsr_body_def body;
        double armature[8] = {0.0};
        assert_ok(mbsr_body_definition(m, k, &body), NULL);
        for (; at < count; ++at) {
            assert_ok(mbsr_parameter_get(list, at, &p), NULL);
            if (p.owner != MBSR_PARAMETER_BODY || p.id != k) break;
            set_in_body(&body, armature, &p, value[at]);
        }
        assert_ok(mbsr_model_add_body(made, &body, NULL), mbsr_model_error(made));
        assert_ok(mbsr_model_armature(made, k, body.joint.n, armature), mbsr_model_error(made));
    }
    for (int k = 0; k < mbsr_model_forces(m); ++k) {
        mbsr_force_def force;
        assert_ok(mbsr_force_definition(m, k, &force), NULL);
        for (int l = at; l < count; ++l) {
            assert_ok(mbsr_parameter_get(list, l, &p), NULL);
            if (p.owner != MBSR_PARAMETER_FORCE || p.id != k) continue;
            for (int e = 0; e < MBSR_FORCE_PARAMS; ++e) {
                char name[64];
                const char *text = force.table->parameter(e);
                snprintf(name, sizeof name, " (%s)", strrchr(p.name, '.') + 1);
                char *digit = strchr(name, '[');
                if (digit) --digit[1]; /* from 1 there, from 0 here */
                if (text && strcmp(text, name) == 0) force.param[e] = value[l];
            }
        }
        assert_ok(mbsr_model_add_force(made, &force, NULL), mbsr_model_error(made));
    }
    assert_ok(mbsr_model_finish(made), mbsr_model_error(made));
    return made;
}

static void as_if_built_with_the_values(void **state)
{
    (void)state;
    int changed = 0;
    for (uint64_t seed = 1; seed <= 30; ++seed) {
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, (test_rigid_choice){.seed = seed,
                                                        .bodies = 2 + (int)(seed % 9),
                                                        .massless = seed % 2 ? 0.3 : 0.0,
                                                        .points = 0.3,
                                                        .many = 0.4,
                                                        .branching = 0.4,
                                                        .length = 1.0,
                                                        .forces = 2,
                                                        .armature = 0.3,
                                                        .shuffle = seed % 3 == 0});
        mbsr_parameters *list = list_of(tree.model);
        const size_t count = (size_t)mbsr_parameters_count(list);
        int *which = calloc(count + 1, sizeof *which);
        double *own = calloc(2 * count + 1, sizeof *own), *other = own + count;
        others(list, which, own, other);
        mbsr_model *made, *built = rebuilt(tree.model, list, other);
        mbsr_error error;
        assert_ok(mbsr_parameters_model(list, (int)count, which, other, &made, &error), &error);
        assert_true(same_motion(built, made, tree.t, tree.q, tree.u));
        changed += !same_motion(tree.model, made, tree.t, tree.q, tree.u);
        mbsr_model_destroy(built);
        mbsr_model_destroy(made);
        free(which), free(own);
        mbsr_parameters_destroy(list);
        test_rigid_tree_free(&tree);
    }
    assert_true(changed > 14);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_and_values_of_a_pendulum),
        cmocka_unit_test(data_with_other_masses_lengths_and_springs),
        cmocka_unit_test(ranks_are_those_of_the_values),
        cmocka_unit_test(entries_of_tables),
        cmocka_unit_test(what_is_refused_and_how),
        cmocka_unit_test(back_to_the_values_it_had),
        cmocka_unit_test(as_if_built_with_the_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
