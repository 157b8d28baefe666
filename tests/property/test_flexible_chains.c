/* Chains of beams with massless modes in each, some of them beams without any mass: the recursion
 * against dense matrices made of body Jacobians and of inverse dynamics, and Newton systems against
 * differences.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A hinge passes some of what the next link weighs on to the massless modes of the one before, and
 * leaves others; so deficient bodies are adjacent, and every block of a mount has a rank of its
 * own. */
#include "duration.h"
#include "expect.h"
#include "flexible.h"
#include "newton_system.h"

#include "algebra/lapack.h"

#include <stdlib.h>
#include <string.h>

enum { ELEMENTS = 6, MIDDLE = 3, MOST_LINKS = 10, MOST_NU = 7 * MOST_LINKS, MOST_D = 18 };

typedef struct chain {
    mbsr_flex *heavy, *light;
    mbsr_model *model;
    mbsr_data *data;
    int links, nu, link[MOST_LINKS]; /* ids of the flexible bodies */
    double q[MOST_NU], u[MOST_NU];
} chain;

static const mbsr_error *error_of(const chain *c)
{
    return mbsr_data_error(c->data);
}

/* Normal modes if there is mass, and the four static ones of the middle. */
static mbsr_flex *beam(double density, int modes, int stiffening)
{
    static const int middle = MIDDLE;
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_error error;
    def.length = 1.0, def.density = density, def.EI_y = 70.0, def.EI_z = 50.0;
    def.elements = ELEMENTS, def.modes = modes, def.loaded = 1, def.node = &middle;
    def.damping = 0.02, def.stiffening = stiffening;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    return flex;
}

/* A hinge, a link, a spring with damper from its middle to the ground; returns the marker at the
 * end. */
static int add_link(chain *c, int parent, int k, int light)
{
    static const double axes[2][3] = {{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};
    const double there[3] = {k + 0.5, -1.0, 0.3};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int middle, end;
    def.parent = parent;
    def.flex = light ? c->light : c->heavy;
    def.joint = mbsr_joint_revolute(NULL, NULL, axes[k % 2]);
    assert_ok(mbsr_model_add_flexible(c->model, &def, c->link + k), mbsr_model_error(c->model));
    assert_ok(mbsr_model_add_marker(c->model, c->link[k], MIDDLE, NULL, &middle),
              mbsr_model_error(c->model));
    mbsr_force_def spring =
        mbsr_force_point_spring(middle, NULL, MBSR_GROUND, there, 10.0, 0.5, 1.0);
    assert_ok(mbsr_model_add_force(c->model, &spring, NULL), mbsr_model_error(c->model));
    assert_ok(mbsr_model_add_marker(c->model, c->link[k], ELEMENTS, NULL, &end),
              mbsr_model_error(c->model));
    return end;
}

/* Every `every`-th link but the last has no mass; 0: none. */
static void open_chain(chain *c, int links, int modes, int every, int stiffening, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, -9.81, 1.0);
    memset(c, 0, sizeof *c);
    c->links = links;
    c->heavy = beam(1.3, modes, stiffening), c->light = beam(0.0, 2, 0);
    assert_ok(mbsr_model_create(NULL, &c->model, NULL), NULL);
    int end = MBSR_GROUND;
    for (int k = 0; k < links; ++k)
        end = add_link(c, end, k, every > 0 && k % every == every - 1 && k < links - 1);
    assert_ok(mbsr_model_add_force(c->model, &gravity, NULL), mbsr_model_error(c->model));
    assert_ok(mbsr_model_finish(c->model), mbsr_model_error(c->model));
    assert_ok(mbsr_data_create(c->model, &c->data, NULL), NULL);
    c->nu = mbsr_model_nu(c->model);
    assert_true(c->nu <= MOST_NU);
    test_fill(&rng, c->nu, c->q);
    test_fill(&rng, c->nu, c->u);
    for (int k = 0; k < c->links; ++k) { /* modes stay small beside hinges */
        int at, count;
        assert_ok(mbsr_body_coordinates(c->model, c->link[k], &at, &count, NULL, NULL), NULL);
        for (int l = 0; l < count; ++l) c->q[at + l] *= 0.1;
    }
}

static void close_chain(chain *c)
{
    mbsr_data_destroy(c->data);
    mbsr_model_destroy(c->model);
    mbsr_flex_destroy(c->heavy);
    mbsr_flex_destroy(c->light);
}

/* ---- dense ---- */

/* mass (nu x nu) += J^T M J of one link, along its axes. */
static void add_mass(const chain *c, int k, long double *mass)
{
    const mbsr_flex *flexes[2] = {c->heavy, c->light};
    double pose[MBSR_POSE_SIZE + MOST_D], M[MOST_D * MOST_D], J[MOST_D * MOST_NU];
    long double MJ[MOST_D * MOST_NU];
    const int id = c->link[k], d = mbsr_body_dimension(c->model, id);
    mbsr_body_def def;
    assert_ok(mbsr_body_definition(c->model, id, &def), NULL);
    const mbsr_flex *flex = def.inertia.flex;
    assert_true(flex == flexes[0] || flex == flexes[1]);
    assert_ok(mbsr_body_pose(c->model, c->data, id, pose), error_of(c));
    assert_int_equal(mbsr_flex_mass_matrix(flex, pose + MBSR_POSE_SIZE, M), MBSR_OK);
    assert_ok(mbsr_body_jacobian(c->model, c->data, id, J), error_of(c));
    for (int j = 0; j < c->nu; ++j) {
        for (int part = 0; part < 6; part += 3) { /* R^T */
            double x[3];
            memcpy(x, J + d * j + part, sizeof x);
            for (int r = 0; r < 3; ++r)
                J[d * j + part + r] =
                    pose[3 * r] * x[0] + pose[3 * r + 1] * x[1] + pose[3 * r + 2] * x[2];
        }
        for (int r = 0; r < d; ++r) {
            MJ[d * j + r] = 0.0L;
            for (int l = 0; l < d; ++l) MJ[d * j + r] += (long double)M[d * l + r] * J[d * j + l];
        }
    }
    for (int j = 0; j < c->nu; ++j) {
        for (int i = 0; i < c->nu; ++i) {
            for (int r = 0; r < d; ++r) mass[c->nu * j + i] += J[d * i + r] * MJ[d * j + r];
        }
    }
}

/* The first `zeros` eigenvectors without what they have of the others: of a matrix of rounded
 * entries they are right to rounding over the smallest eigenvalue that is not zero. */
static void sharpen(int n, int zeros, const long double *mass, const double *scale,
                    const double *lambda, double *X)
{
    for (int k = 0; k < zeros; ++k) {
        double *x = X + n * k;
        long double Ax[MOST_NU] = {0.0L};
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) Ax[i] += mass[n * j + i] * scale[i] * scale[j] * x[j];
        }
        for (int l = zeros; l < n; ++l) {
            long double part = 0.0L;
            for (int i = 0; i < n; ++i) part += X[n * l + i] * Ax[i];
            for (int i = 0; i < n; ++i) x[i] -= (double)(part / lambda[l]) * X[n * l + i];
        }
    }
}

/* The mass matrix scaled to unit diagonal as eigenvectors X, ascending; scale: 1 / roots of the
 * diagonal, 1 where that is zero. Returns the number of eigenvalues that are zero. */
static int decompose(const chain *c, const long double *mass, double *scale, double *X)
{
    const int n = c->nu;
    const size_t size = (size_t)n;
    double *lambda = malloc(size * sizeof *lambda), *work = malloc(64 * size * sizeof *work);
    int zeros = 0;
    for (int k = 0; k < n; ++k)
        scale[k] = mass[k * (n + 1)] > 1e-12L ? 1.0 / sqrt((double)mass[k * (n + 1)]) : 1.0;
    for (int k = 0; k < n * n; ++k) X[k] = scale[k / n] * (double)mass[k] * scale[k % n];
    assert_int_equal(mbsri_lapack_syev(n, X, lambda, work, 64 * n), 0);
    while (zeros < n && lambda[zeros] < 1e-11) ++zeros;
    assert_true(zeros == 0 || lambda[zeros - 1] < 1e-13);
    assert_true(zeros < n && lambda[zeros] > 1e-8);
    sharpen(n, zeros, mass, scale, lambda, X);
    free(lambda);
    free(work);
    return zeros;
}

/* Largest component of r along eigenvectors first .. last - 1, beside what b has along all. */
static double component(int n, const double *X, const double *scale, int first, int last,
                        const double *r, const double *b)
{
    double largest = 0.0, size = 0.0;
    for (int k = 0; k < n; ++k) {
        double sum = 0.0, of = 0.0;
        for (int l = 0; l < n; ++l) {
            sum += X[n * k + l] * scale[l] * r[l];
            of += fabs(X[n * k + l] * scale[l] * b[l]);
        }
        if (k >= first && k < last) largest = fmax(largest, fabs(sum));
        size = fmax(size, of);
    }
    return largest / size;
}

static int nullity_by_blocks(const chain *c)
{
    int sum = 0;
    for (int id = 0; id < mbsr_model_bodies(c->model); ++id) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(c->model, c->data, id, &info), error_of(c));
        sum += info.n - info.rank;
    }
    return sum;
}

/* At a consistent start the forces along the directions without mass balance, and accelerations
 * fulfil all equations. */
static void start_balances(const chain *c, int zeros, const long double *mass, const double *X,
                           const double *scale)
{
    const int n = c->nu;
    const double none[MOST_NU] = {0.0};
    double y[3 * MOST_NU], yp[3 * MOST_NU] = {0.0}, before[MOST_NU], after[MOST_NU];
    mbsr_consistent_info info;
    assert_ok(mbsr_inverse_dynamics(c->model, c->data, 0.0, c->q, c->u, none, NULL, before),
              error_of(c));
    assert_ok(mbsr_dae_pack(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->q, c->u, y), error_of(c));
    assert_ok(mbsr_dae_consistent(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info),
              error_of(c));
    assert_int_equal(info.null_directions, zeros);
    for (int k = 0; k < n; ++k) assert_true(y[k] == c->q[k]);
    assert_ok(mbsr_inverse_dynamics(c->model, c->data, 0.0, c->q, y + 2 * n, none, NULL, after),
              error_of(c));
    assert_true(component(n, X, scale, 0, zeros, before, before) > 1e-6);
    assert_less(component(n, X, scale, 0, zeros, after, before), 1e-11);
    double udot[MOST_NU], rest[MOST_NU];
    assert_int_equal(mbsr_forward_dynamics(c->model, c->data, 0.0, c->q, y + 2 * n, NULL, udot),
                     MBSR_UNDETERMINED);
    assert_int_equal(nullity_by_blocks(c), zeros);
    assert_ok(mbsr_inverse_dynamics(c->model, c->data, 0.0, c->q, y + 2 * n, udot, NULL, rest),
              error_of(c));
    for (int k = 0; k < n; ++k) { /* what is added up in each equation */
        before[k] = fabs(after[k]);
        for (int l = 0; l < n; ++l) before[k] += fabs((double)mass[n * l + k] * udot[l]);
    }
    assert_less(component(n, X, scale, 0, n, rest, before), 1e-12);
}

static void compare(int links, int modes, int every, int stiffening, uint64_t seed)
{
    chain c;
    open_chain(&c, links, modes, every, stiffening, seed);
    const int n = c.nu;
    const size_t size = (size_t)n * (size_t)n;
    long double *mass = calloc(size, sizeof *mass);
    double *found = malloc(size * sizeof *found), *X = malloc(size * sizeof *X), scale[MOST_NU];
    assert_ok(mbsr_stage_positions(c.model, c.data, 0.0, c.q), error_of(&c));
    assert_ok(mbsr_stage_velocities(c.model, c.data, c.u), error_of(&c));
    for (int k = 0; k < links; ++k) add_mass(&c, k, mass);
    assert_ok(mbsr_mass_matrix(c.model, c.data, found), error_of(&c));
    const int zeros = decompose(&c, mass, scale, X);
    for (int k = 0; k < n * n; ++k)
        assert_close(scale[k / n] * found[k] * scale[k % n],
                     scale[k / n] * (double)mass[k] * scale[k % n], 1e-12);

    assert_true(zeros >= links + 3);
    start_balances(&c, zeros, mass, X, scale);
    free(mass);
    free(found);
    free(X);
    close_chain(&c);
}

static void deficient_bodies_are_adjacent(void **state)
{
    (void)state;
    static const int links[6] = {1, 2, 5, 3, 4, MOST_LINKS}, every[6] = {0, 0, 2, 2, 3, 3};
    const int most = test_long() ? 24 : 4;
    for (int k = 0; k < most; ++k) compare(links[k % 6], 2, every[k % 6], k % 2, (uint64_t)k + 1);
}

/* Of so many modes that joint blocks are in factors. */
static void blocks_in_factors_are_those_of_the_matrices(void **state)
{
    (void)state;
    for (int links = 1; links <= 4; ++links)
        compare(links, 8, links == 3 ? 2 : 0, 0, (uint64_t)links);
}

/* ---- Newton systems ---- */

static void newton_systems_agree_with_differences(void **state)
{
    (void)state;
    for (int every = 0; every < 3; every += 2) {
        chain c;
        test_newton_state s;
        mbsr_newton *newton;
        mbsr_error error;
        open_chain(&c, test_seeds(2, 3), 2, every, every == 0, 7);
        double r[3 * MOST_NU], x[3 * MOST_NU];
        test_rng rng = test_seed(3);
        assert_ok(test_newton_start(&s, c.model, c.data, 0.0, c.q, c.u, NULL), error_of(&c));
        assert_ok(test_newton_matrices(&s, c.model, c.data), error_of(&c));
        assert_ok(mbsr_newton_create(c.model, MBSR_DAE_MOMENTUM, NULL, &newton, &error), &error);
        test_fill(&rng, s.n, r);
        for (int k = 0; k < 3; ++k) {
            const double step = (double[3]){1.0, 100.0, 1e4}[k];
            assert_ok(mbsr_newton_factor(newton, s.data, s.t, s.y, s.yp, step),
                      mbsr_newton_error(newton));
            assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
            const test_newton_errors e = test_newton_compare(&s, step, r, x);
            print_message("c = %g: row %.1e, solution %.1e\n", step, e.row, e.delta);
            assert_less(e.net_row, 1e-8);
            assert_less(e.net_delta, 1e-7);
        }
        mbsr_newton_destroy(newton);
        test_newton_free(&s);
        close_chain(&c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(deficient_bodies_are_adjacent),
        cmocka_unit_test(blocks_in_factors_are_those_of_the_matrices),
        cmocka_unit_test(newton_systems_agree_with_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
