/* Trees of up to 1023 rigid bodies against accelerations on which several independent programs
 * agree; the same trees far from the origin, in another world, renumbered, in other units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "tree_file.h"

#include "expect.h"
#include "space.h"

#include "assembly/data.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

/* Relative errors of accelerations that are allowed: those of the chains are the agreement of the
 * references. */
static const struct {
    const char *name;
    double bound;
} tree_file[] = {{"chain7", 3e-14},      {"chain30", 3e-14},   {"chain100", 5e-13},
                 {"chain1000", 1e-11},   {"btree1023", 3e-14}, {"humanoid36", 3e-14},
                 {"massless_iii", 3e-14}};
static const double inverse_bound = 1e-13;
enum { FILES = 7 };

/* Largest difference between a and b, vectors over the joint rates, relative to the largest entry
 * of b or c: rotations apart from translations, whose units differ. */
static double difference(const test_told_tree *tree, const double *a, const double *b,
                         const double *c)
{
    double off[2] = {0.0}, size[2] = {0.0};
    for (int id = 0; id < mbsr_model_bodies(tree->model); ++id) {
        int at, n;
        assert_ok(mbsr_body_coordinates(tree->model, id, NULL, NULL, &at, &n), NULL);
        for (int k = 0; k < n; ++k) {
            const int kind = k >= 3;
            assert_true(isfinite(a[at + k]));
            off[kind] = fmax(off[kind], fabs(a[at + k] - b[at + k]));
            size[kind] = fmax(size[kind], fmax(fabs(b[at + k]), fabs(c[at + k])));
        }
    }
    return fmax(off[0] / size[0], size[1] > 0.0 ? off[1] / size[1] : off[1]);
}

/* Errors of forward and inverse dynamics of one telling. Joint forces are small differences of
 * M u' and the bias forces, whose size counts. */
static void errors(const test_tree_file *file, const test_tree_telling *telling, double *forward,
                   double *inverse)
{
    test_told_tree tree;
    test_told_tree_make(&tree, file, telling);
    double *x = calloc(2 * (size_t)tree.nu, sizeof(double)), *bias = x + tree.nu;
    mbsri_data_poison(tree.data);
    assert_ok(mbsr_bias_forces(tree.model, tree.data, 0.0, tree.q, tree.u, bias),
              mbsr_data_error(tree.data));
    mbsri_data_poison(tree.data);
    assert_ok(mbsr_forward_dynamics(tree.model, tree.data, 0.0, tree.q, tree.u, tree.tau, x),
              mbsr_data_error(tree.data));
    *forward = difference(&tree, x, tree.udot, tree.udot);
    mbsri_data_poison(tree.data);
    assert_ok(mbsr_inverse_dynamics(tree.model, tree.data, 0.0, tree.q, tree.u, tree.udot, NULL, x),
              mbsr_data_error(tree.data));
    *inverse = difference(&tree, x, tree.tau, bias);
    free(x);
    test_told_tree_free(&tree);
}

/* Every tree in this telling; bound: of both errors, 0: those of the file. */
static void check_told(const char *what, const test_tree_telling *telling, double bound)
{
    for (int k = 0; k < FILES; ++k) {
        test_tree_file file;
        double forward, inverse;
        test_tree_file_read(&file, tree_file[k].name);
        errors(&file, telling, &forward, &inverse);
        print_message("%s, %s: accelerations to %.1e, joint forces to %.1e\n", tree_file[k].name,
                      what, forward, inverse);
        assert_less(forward, bound > 0.0 ? bound : tree_file[k].bound);
        assert_less(inverse, bound > 0.0 ? bound : inverse_bound);
        test_tree_file_free(&file);
    }
}

static void accelerations_and_joint_forces_are_those_of_the_reference(void **unused)
{
    (void)unused;
    const test_tree_telling telling = test_tree_told();
    check_told("as in the file", &telling, 0.0);
}

static void ten_kilometres_from_the_origin_nothing_changes(void **unused)
{
    (void)unused;
    test_tree_telling telling = test_tree_told();
    telling.world = mbsr_frame_at(6e3, -8e3, 2e3);
    check_told("10 km away", &telling, 1e-10);
}

/* tau -> u' -> tau: back to 1e-10 of the largest joint force, which is small beside the bias
 * forces. */
static void forward_then_inverse_dynamics_returns_the_joint_forces(void **unused)
{
    (void)unused;
    for (int k = 0; k < 2 * FILES; ++k) {
        test_tree_file file;
        test_told_tree tree;
        test_tree_telling telling = test_tree_told();
        if (k >= FILES) telling.world = mbsr_frame_at(6e3, -8e3, 2e3);
        test_tree_file_read(&file, tree_file[k % FILES].name);
        test_told_tree_make(&tree, &file, &telling);
        double *x = calloc(2 * (size_t)tree.nu, sizeof(double)), *tau = x + tree.nu;
        assert_ok(mbsr_forward_dynamics(tree.model, tree.data, 0.0, tree.q, tree.u, tree.tau, x),
                  mbsr_data_error(tree.data));
        assert_ok(mbsr_inverse_dynamics(tree.model, tree.data, 0.0, tree.q, tree.u, x, NULL, tau),
                  mbsr_data_error(tree.data));
        double off = 0.0, size = 0.0;
        for (int l = 0; l < tree.nu; ++l) {
            off = fmax(off, fabs(tau[l] - tree.tau[l]));
            size = fmax(size, fabs(tree.tau[l]));
        }
        print_message("%s%s: %.1e\n", tree_file[k % FILES].name, k < FILES ? "" : " far away",
                      size > 0.0 ? off / size : off);
        assert_true(off <= 1e-10 * size || size == 0.0);
        free(x);
        test_told_tree_free(&tree);
        test_tree_file_free(&file);
    }
}

static void in_a_turned_world_nothing_changes(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(11);
    test_tree_telling telling = test_tree_told();
    telling.world = test_frame(&rng, 3.0);
    check_told("turned world", &telling, 0.0);
}

static void units_do_not_matter(void **unused)
{
    (void)unused;
    test_tree_telling telling = test_tree_told();
    telling.length = 1e3;
    telling.mass = 1e-3;
    check_told("mm, t", &telling, 0.0);
}

static void numbering_does_not_matter(void **unused)
{
    (void)unused;
    test_rng rng = test_seed(5);
    for (int k = 0; k < FILES; ++k) {
        test_tree_file file;
        test_tree_file_read(&file, tree_file[k].name);
        int *line = calloc((size_t)file.bodies, sizeof(int)), late = 0;
        for (int id = 0; id < file.bodies; ++id) {
            const int other = test_integer(&rng, 0, id);
            line[id] = line[other];
            line[other] = id;
        }
        for (int id = 0; id < file.bodies; ++id) late += line[id] != id;
        assert_true(late > 0);
        test_tree_telling telling = test_tree_told();
        telling.line = line;
        double forward, inverse;
        errors(&file, &telling, &forward, &inverse);
        assert_less(forward, tree_file[k].bound);
        assert_less(inverse, inverse_bound);
        free(line);
        test_tree_file_free(&file);
    }
}

/* The residual (25), like joint forces relative to the bias forces. */
static void the_recursive_residual_vanishes(void **unused)
{
    (void)unused;
    for (int k = 0; k < FILES; ++k) {
        test_tree_file file;
        test_told_tree tree;
        test_tree_telling telling = test_tree_told();
        test_tree_file_read(&file, tree_file[k].name);
        test_told_tree_make(&tree, &file, &telling);
        double *x = calloc(3 * (size_t)tree.nu, sizeof(double)), *bias = x + tree.nu;
        assert_ok(mbsr_bias_forces(tree.model, tree.data, 0.0, tree.q, tree.u, bias),
                  mbsr_data_error(tree.data));
        mbsri_data_poison(tree.data);
        assert_ok(mbsr_recursive_residual(tree.model, tree.data, 0.0, tree.q, tree.u, tree.udot,
                                          tree.tau, x),
                  mbsr_data_error(tree.data));
        assert_int_equal(mbsr_total_rank(tree.model, tree.data), tree.nu);
        const double residual = difference(&tree, x, bias + tree.nu, bias);
        print_message("%s: residual %.1e\n", tree_file[k].name, residual);
        assert_less(residual, inverse_bound);
        free(x);
        test_told_tree_free(&tree);
        test_tree_file_free(&file);
    }
}

/* p at q + h q', u + h u': differs from p(t + h) by terms in h^2 and h^3, of which those in h^2
 * drop out of central differences. */
static void moved_momenta(const test_told_tree *tree, const double *qdot, double h, double *p)
{
    double *q = calloc((size_t)tree->nq + (size_t)tree->nu, sizeof(double)), *u = q + tree->nq;
    for (int k = 0; k < tree->nq; ++k) q[k] = tree->q[k] + h * qdot[k];
    for (int k = 0; k < tree->nu; ++k) u[k] = tree->u[k] + h * tree->udot[k];
    assert_ok(mbsr_stage_positions(tree->model, tree->data, 0.0, q), mbsr_data_error(tree->data));
    assert_ok(mbsr_stage_velocities(tree->model, tree->data, u), mbsr_data_error(tree->data));
    assert_ok(mbsr_momenta(tree->model, tree->data, p), mbsr_data_error(tree->data));
    free(q);
}

/* With p' = 0 the momentum form's residual is -p'. Of the differences at h and h / 2 the errors in
 * h^2 are extrapolated away. */
static void check_momentum_rate(const test_told_tree *tree, const char *name)
{
    const int nq = tree->nq, nu = tree->nu, size = nq + 2 * nu;
    assert_int_equal(mbsr_dae_size(tree->model, MBSR_DAE_MOMENTUM), size);
    double *y = calloc(3 * (size_t)size, sizeof(double)), *yp = y + size, *F = yp + size;
    double *rate = calloc(3 * (size_t)nu, sizeof(double)), *after = rate + nu, *before = after + nu;
    mbsr_data *d = tree->data;
    assert_ok(mbsr_dae_pack(tree->model, d, MBSR_DAE_MOMENTUM, 0.0, tree->q, tree->u, y),
              mbsr_data_error(d));
    assert_ok(mbsr_coordinate_rates(tree->model, d, yp), mbsr_data_error(d));
    mbsri_data_poison(d);
    assert_ok(mbsr_dae_residual(tree->model, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F),
              mbsr_data_error(d));
    const double steps[] = {1e-5, 5e-6}, weights[] = {-1.0 / 3.0, 4.0 / 3.0};
    for (int s = 0; s < 2; ++s) {
        moved_momenta(tree, yp, steps[s], after);
        moved_momenta(tree, yp, -steps[s], before);
        for (int k = 0; k < nu; ++k)
            rate[k] += weights[s] * (after[k] - before[k]) / (2.0 * steps[s]);
    }
    for (int k = 0; k < nq; ++k) assert_close(F[k], 0.0, 0.0);
    const double scale = test_largest(nu, rate), error_u = test_largest(nu, F + nq + nu);
    double error = 0.0;
    for (int k = 0; k < nu; ++k) error = fmax(error, fabs(F[nq + k] + rate[k]));
    print_message("%s: p' to %.1e of %.1e, momenta to %.1e of %.1e\n", name, error / scale, scale,
                  error_u, test_largest(nu, y + nq));
    assert_less(error, 3e-9 * scale);
    assert_less(error_u, 1e-12 * test_largest(nu, y + nq));
    free(y);
    free(rate);
}

static void momenta_change_as_the_momentum_form_says(void **unused)
{
    (void)unused;
    for (int k = 0; k < FILES; ++k) {
        test_tree_file file;
        test_told_tree tree;
        test_tree_telling telling = test_tree_told();
        telling.loads = 1;
        test_tree_file_read(&file, tree_file[k].name);
        test_told_tree_make(&tree, &file, &telling);
        check_momentum_rate(&tree, tree_file[k].name);
        test_told_tree_free(&tree);
        test_tree_file_free(&file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accelerations_and_joint_forces_are_those_of_the_reference),
        cmocka_unit_test(ten_kilometres_from_the_origin_nothing_changes),
        cmocka_unit_test(forward_then_inverse_dynamics_returns_the_joint_forces),
        cmocka_unit_test(in_a_turned_world_nothing_changes),
        cmocka_unit_test(units_do_not_matter),
        cmocka_unit_test(numbering_does_not_matter),
        cmocka_unit_test(the_recursive_residual_vanishes),
        cmocka_unit_test(momenta_change_as_the_momentum_form_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
