/* Random trees of bodies in space: all stock joints, bodies of a few mass points, of which many
 * have no mass or rank 3 or 5.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * References know nothing of the recursions: the motion of the mass points, differences of it, and
 * singular values. */
#include "duration.h"
#include "expect.h"
#include "space.h"

#include "assembly/data.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

#define TREES test_seeds_short(60, 200)
enum { MOST = 96, MOST_ROWS = 160 };

static const double now = 0.3, gravity = 9.81;

static test_space_opt options(int seed)
{
    return (test_space_opt){.seed = (uint64_t)seed,
                            .bodies = 1 + seed % 10,
                            .deficient = 0.7,
                            .driven = seed % 2,
                            .gravity = gravity};
}

static void make(test_space_tree *tree, test_space_opt opt)
{
    test_space_make(tree, opt);
    assert_in_range(tree->nq, 0, MOST);
    assert_in_range(tree->rows, 0, MOST_ROWS);
}

static void reach_velocities(const test_space_tree *tree, double t, const double *q,
                             const double *u)
{
    assert_ok(mbsr_stage_positions(tree->model, tree->data, t, q), mbsr_data_error(tree->data));
    assert_ok(mbsr_stage_velocities(tree->model, tree->data, u), mbsr_data_error(tree->data));
}

/* ---- differences along a motion -------------------------------------------------------------- */

/* Writes `count` numbers at the state of mbsr_stage_velocities. */
typedef void (*observe_fn)(const test_space_tree *tree, double t, const double *q, const double *u,
                           double *value);

/* d/dt of what is observed, along q', u': differences over 2 h and 4 h without their error in
 * h^2. */
static void along_motion(const test_space_tree *tree, double t, const double *q, const double *u,
                         const double *qdot, const double *udot, double h, observe_fn observe,
                         int count, double *rate)
{
    double qh[MOST], uh[MOST];
    double *value = calloc((size_t)count + 1, sizeof(double));
    static const double step[] = {1.0, -1.0, 2.0, -2.0},
                        weight[] = {8.0 / 12.0, -8.0 / 12.0, -1.0 / 12.0, 1.0 / 12.0};
    memset(rate, 0, sizeof(double) * (size_t)count);
    for (int s = 0; s < 4; ++s) {
        for (int k = 0; k < tree->nq; ++k) qh[k] = q[k] + step[s] * h * qdot[k];
        for (int k = 0; k < tree->nu; ++k) uh[k] = u[k] + step[s] * h * udot[k];
        reach_velocities(tree, t + step[s] * h, qh, uh);
        observe(tree, t + step[s] * h, qh, uh, value);
        for (int k = 0; k < count; ++k) rate[k] += weight[s] * value[k] / h;
    }
    free(value);
}

static void positions(const test_space_tree *tree, double t, const double *q, const double *u,
                      double *value)
{
    (void)t, (void)q, (void)u;
    test_space_positions(tree, value);
}

static void velocities(const test_space_tree *tree, double t, const double *q, const double *u,
                       double *value)
{
    (void)t, (void)q, (void)u;
    test_space_velocities(tree, value);
}

static void momenta(const test_space_tree *tree, double t, const double *q, const double *u,
                    double *value)
{
    (void)t, (void)q, (void)u;
    assert_ok(mbsr_momenta(tree->model, tree->data, value), mbsr_data_error(tree->data));
}

static void energy(const test_space_tree *tree, double t, const double *q, const double *u,
                   double *value)
{
    (void)t, (void)q, (void)u;
    double kinetic, potential;
    assert_ok(mbsr_energy(tree->model, tree->data, &kinetic, &potential),
              mbsr_data_error(tree->data));
    value[0] = kinetic + potential;
}

static void packed_index1(const test_space_tree *tree, double t, const double *q, const double *u,
                          double *value)
{
    assert_ok(mbsr_dae_pack(tree->model, tree->data, MBSR_DAE_INDEX1, t, q, u, value),
              mbsr_data_error(tree->data));
}

/* ---- kinematics and dynamics against the mass points ----------------------------------------- */

static void points_move_as_twists_say(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        make(&tree, options(seed));
        double qdot[MOST], zero[MOST] = {0.0}, v[MOST_ROWS], rate[MOST_ROWS];
        reach_velocities(&tree, now, tree.q, tree.u);
        test_space_velocities(&tree, v);
        assert_ok(mbsr_coordinate_rates(tree.model, tree.data, qdot), mbsr_data_error(tree.data));
        along_motion(&tree, now, tree.q, tree.u, qdot, zero, 1e-3, positions, tree.rows, rate);
        for (int k = 0; k < tree.rows; ++k)
            assert_close(rate[k], v[k], 1e-9 * (1.0 + test_largest(tree.rows, v)));
        test_space_free(&tree);
    }
}

static void mass_matrix_and_momenta_are_those_of_the_points(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        make(&tree, options(seed));
        const int n = tree.nu, rows = tree.rows;
        double *M = calloc((size_t)(n * n) + 1, sizeof(double)),
               *P = calloc((size_t)(n * rows) + 1, sizeof(double)), p[MOST], v[MOST_ROWS];
        assert_ok(mbsr_stage_positions(tree.model, tree.data, now, tree.q),
                  mbsr_data_error(tree.data));
        test_space_jacobian(&tree, P);
        reach_velocities(&tree, now, tree.q, tree.u);
        test_space_velocities(&tree, v);
        assert_ok(mbsr_mass_matrix(tree.model, tree.data, M), mbsr_data_error(tree.data));
        assert_ok(mbsr_momenta(tree.model, tree.data, p), mbsr_data_error(tree.data));
        const double size = 1.0 + test_largest(n * n, M);
        double kinetic, twice = 0.0;
        for (int r = 0; r < rows; ++r) twice += v[r] * v[r];
        assert_ok(mbsr_energy(tree.model, tree.data, &kinetic, NULL), mbsr_data_error(tree.data));
        assert_close(kinetic, 0.5 * twice, 1e-13 * (1.0 + twice));
        for (int c = 0; c < n; ++c) {
            double momentum = 0.0;
            for (int r = 0; r < rows; ++r) momentum += P[c * rows + r] * v[r];
            assert_close(p[c], momentum, 1e-13 * size * (1.0 + test_largest(rows, v)));
            for (int b = 0; b < n; ++b) {
                double entry = 0.0;
                for (int r = 0; r < rows; ++r) entry += P[c * rows + r] * P[b * rows + r];
                assert_close(M[c * n + b], entry, 1e-13 * size);
            }
        }
        free(M);
        free(P);
        test_space_free(&tree);
    }
}

/* tau = P^T (acceleration of the points - gravity), the acceleration by differences. */
static void inverse_dynamics_moves_the_points(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        make(&tree, options(seed));
        const int n = tree.nu, rows = tree.rows;
        double *P = calloc((size_t)(n * rows) + 1, sizeof(double)), qdot[MOST], udot[MOST],
               tau[MOST], a[MOST_ROWS];
        test_rng rng = test_seed((uint64_t)seed + 100);
        test_fill(&rng, n, udot);
        reach_velocities(&tree, now, tree.q, tree.u);
        assert_ok(mbsr_coordinate_rates(tree.model, tree.data, qdot), mbsr_data_error(tree.data));
        along_motion(&tree, now, tree.q, tree.u, qdot, udot, 1e-3, velocities, rows, a);
        for (int id = 0, row = 0; id < tree.N; ++id) {
            for (int c = 0; c < tree.points[id].count; ++c) {
                for (int k = 0; k < 3; ++k) a[row++] -= sqrt(tree.points[id].mass[c]) * tree.g[k];
            }
        }
        assert_ok(mbsr_stage_positions(tree.model, tree.data, now, tree.q),
                  mbsr_data_error(tree.data));
        test_space_jacobian(&tree, P);
        mbsri_data_poison(tree.data);
        assert_ok(
            mbsr_inverse_dynamics(tree.model, tree.data, now, tree.q, tree.u, udot, NULL, tau),
            mbsr_data_error(tree.data));
        for (int c = 0; c < n; ++c) {
            double expected = 0.0;
            for (int r = 0; r < rows; ++r) expected += P[c * rows + r] * a[r];
            assert_close(tau[c], expected,
                         1e-9 * (1.0 + test_largest(n * rows, P)) * (1.0 + test_largest(rows, a)));
        }
        free(P);
        test_space_free(&tree);
    }
}

/* ---- ranks ----------------------------------------------------------------------------------- */

/* Smallest scaled eigenvalue that counted: rounding errors grow with its reciprocal. */
static double smallest_kept(const test_space_tree *tree)
{
    double value = 1.0;
    for (int id = 0; id < tree->N; ++id) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(tree->model, tree->data, id, &info), mbsr_data_error(tree->data));
        if (info.rank > 0) value = fmin(value, info.smallest_kept);
    }
    return value;
}

/* Coordinates of the joints below body i, without its own; returns how many. */
static int below(const test_space_tree *tree, int i, int *use)
{
    int count = 0;
    for (int j = i + 1; j < tree->N; ++j) {
        int k = j, first, n;
        while (k > i) k = tree->parent[k];
        assert_ok(mbsr_body_coordinates(tree->model, j, NULL, NULL, &first, &n), NULL);
        for (int c = 0; k == i && c < n; ++c) use[count++] = first + c;
    }
    return count;
}

/* rank D_i = rank of the points' motion by the joints from i on - the same without joint i. */
static void ranks_are_those_of_the_motion_of_the_points(void **unused)
{
    (void)unused;
    double kept = 1.0, dropped = 0.0, eigenvalue = 1.0, rounding = 0.0;
    int deficient = 0, joints = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        make(&tree, options(seed));
        double *P = calloc((size_t)(tree.nu * tree.rows) + 1, sizeof(double)), residual[MOST],
               udot[MOST] = {0.0};
        assert_ok(mbsr_stage_positions(tree.model, tree.data, now, tree.q),
                  mbsr_data_error(tree.data));
        test_space_jacobian(&tree, P);
        mbsri_data_poison(tree.data);
        assert_ok(mbsr_recursive_residual(tree.model, tree.data, now, tree.q, tree.u, udot, NULL,
                                          residual),
                  mbsr_data_error(tree.data));
        for (int i = 0; i < tree.N; ++i, ++joints) {
            int use[MOST], first, n, count = below(&tree, i, use);
            mbsr_rank_info info;
            const int without = test_column_rank(tree.rows, P, count, use, &kept, &dropped);
            assert_ok(mbsr_body_coordinates(tree.model, i, NULL, NULL, &first, &n), NULL);
            for (int c = 0; c < n; ++c) use[count++] = first + c;
            const int with = test_column_rank(tree.rows, P, count, use, &kept, &dropped);
            assert_ok(mbsr_body_rank(tree.model, tree.data, i, &info), mbsr_data_error(tree.data));
            assert_int_equal(info.n, n);
            assert_int_equal(info.rank, with - without);
            deficient += info.rank < n;
            rounding = fmax(rounding, info.largest_dropped);
        }
        eigenvalue = fmin(eigenvalue, smallest_kept(&tree));
        free(P);
        test_space_free(&tree);
    }
    print_message("%d of %d joints deficient; singular values above %.1e and below %.1e, "
                  "eigenvalues above %.1e and below %.1e\n",
                  deficient, joints, kept, dropped, eigenvalue, rounding);
    assert_less(1e-5, kept);
    assert_less(dropped, 1e-12);
    assert_less(1e-10, eigenvalue);
    assert_less(rounding, 5e-14);
    assert_true(5 * deficient > joints);
    assert_true(5 * deficient < 4 * joints);
}

/* m and kg to mm and t. */
static void ranks_do_not_depend_on_units(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree a, b;
        test_space_opt opt = options(seed);
        make(&a, opt);
        opt.length = 1e3;
        opt.mass = 1e-3;
        opt.gravity = 1e3 * gravity;
        make(&b, opt);
        double residual[MOST], udot[MOST] = {0.0};
        assert_ok(mbsr_recursive_residual(a.model, a.data, now, a.q, a.u, udot, NULL, residual),
                  mbsr_data_error(a.data));
        assert_ok(mbsr_recursive_residual(b.model, b.data, now, b.q, b.u, udot, NULL, residual),
                  mbsr_data_error(b.data));
        for (int id = 0; id < a.N; ++id) {
            mbsr_rank_info ia, ib;
            assert_ok(mbsr_body_rank(a.model, a.data, id, &ia), mbsr_data_error(a.data));
            assert_ok(mbsr_body_rank(b.model, b.data, id, &ib), mbsr_data_error(b.data));
            assert_int_equal(ia.rank, ib.rank);
            assert_close(ib.smallest_kept, ia.smallest_kept, 1e-10);
        }
        double ta, tb;
        reach_velocities(&a, now, a.q, a.u);
        reach_velocities(&b, now, b.q, b.u);
        assert_ok(mbsr_energy(a.model, a.data, &ta, NULL), mbsr_data_error(a.data));
        assert_ok(mbsr_energy(b.model, b.data, &tb, NULL), mbsr_data_error(b.data));
        assert_close(1e-3 * tb, ta, 1e-12 * (1.0 + ta));
        test_space_free(&a);
        test_space_free(&b);
    }
}

/* ---- forward and inverse dynamics ------------------------------------------------------------ */

static void forward_dynamics_is_inverse_to_inverse_dynamics(void **unused)
{
    (void)unused;
    int regular = 0, deficient = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        test_space_tree tree;
        make(&tree, options(seed));
        double udot[MOST], tau[MOST], again[MOST], residual[MOST];
        test_rng rng = test_seed((uint64_t)seed + 200);
        test_fill(&rng, tree.nu, udot);
        mbsri_data_poison(tree.data);
        assert_ok(
            mbsr_inverse_dynamics(tree.model, tree.data, now, tree.q, tree.u, udot, NULL, tau),
            mbsr_data_error(tree.data));
        mbsri_data_poison(tree.data);
        assert_ok(mbsr_recursive_residual(tree.model, tree.data, now, tree.q, tree.u, udot, tau,
                                          residual),
                  mbsr_data_error(tree.data));
        const double rounding = 1e-13 * (1.0 + test_largest(tree.nu, tau)) / smallest_kept(&tree);
        for (int k = 0; k < tree.nu; ++k) assert_close(residual[k], 0.0, rounding);
        const int status =
            mbsr_forward_dynamics(tree.model, tree.data, now, tree.q, tree.u, tau, again);
        if (mbsr_total_rank(tree.model, tree.data) < tree.nu) {
            assert_int_equal(status, MBSR_UNDETERMINED);
            ++deficient;
        } else {
            assert_ok(status, mbsr_data_error(tree.data));
            for (int k = 0; k < tree.nu; ++k) assert_close(again[k], udot[k], 10.0 * rounding);
            ++regular;
        }
        test_space_free(&tree);
    }
    print_message("%d regular trees, %d deficient ones\n", regular, deficient);
    assert_true(regular > TREES / 8);
    assert_true(deficient > TREES / 4);
}

/* ---- consistent motions ---------------------------------------------------------------------- */

/* A tree of which every joint is damped, with a state and accelerations from the library's
 * start. */
typedef struct motion {
    test_space_tree tree;
    mbsr_consistent_info info;
    double q[MOST], u[MOST], qdot[MOST], udot[MOST];
    double kept, size; /* smallest eigenvalue; 1 + the largest rate or acceleration */
} motion;

static void start(motion *s, int seed, int driven)
{
    test_space_opt opt = options(seed);
    opt.laws = 1;
    opt.driven = driven;
    make(&s->tree, opt);
    test_space_tree *tree = &s->tree;
    double y[2 * MOST], yp[2 * MOST];
    memcpy(y, tree->q, sizeof(double) * (size_t)tree->nq);
    memcpy(y + tree->nq, tree->u, sizeof(double) * (size_t)tree->nu);
    mbsri_data_poison(tree->data);
    assert_ok(mbsr_dae_consistent(tree->model, tree->data, MBSR_DAE_RECURSIVE, now, y, yp, NULL,
                                  &s->info),
              mbsr_data_error(tree->data));
    assert_int_equal(s->info.elastic, 0);
    memcpy(s->q, y, sizeof(double) * (size_t)tree->nq);
    memcpy(s->u, y + tree->nq, sizeof(double) * (size_t)tree->nu);
    memcpy(s->qdot, yp, sizeof(double) * (size_t)tree->nq);
    memcpy(s->udot, yp + tree->nq, sizeof(double) * (size_t)tree->nu);
    s->kept = smallest_kept(tree);
    s->size = 1.0 + test_largest(tree->nu, s->udot) + test_largest(tree->nu, s->u);
}

/* Poses stay, quaternions get length 1, momenta stay. */
static void check_start(const motion *s)
{
    const test_space_tree *tree = &s->tree;
    double x[MOST_ROWS], moved[MOST_ROWS], v[MOST_ROWS];
    double *P = calloc((size_t)(tree->nu * tree->rows) + 1, sizeof(double));
    reach_velocities(tree, now, tree->q, tree->u);
    test_space_positions(tree, x);
    test_space_velocities(tree, v);
    reach_velocities(tree, now, s->q, s->u);
    test_space_positions(tree, moved);
    for (int k = 0; k < tree->rows; ++k) assert_close(moved[k], x[k], 1e-13);
    test_space_velocities(tree, moved);
    for (int k = 0; k < tree->rows; ++k) assert_close(moved[k], v[k], 1e-11 * s->size / s->kept);
    for (int id = 0; id < tree->N; ++id) {
        int at, nq, n;
        assert_ok(mbsr_body_coordinates(tree->model, id, &at, &nq, NULL, &n), NULL);
        if (nq == n) continue;
        const double *q = s->q + at;
        assert_close(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1.0, 1e-14);
    }
    free(P);
}

/* Poisons what is workspace; the reference of the index-1 form is none. */
static void spoil(const test_space_tree *tree, mbsr_dae_form form)
{
    if (form != MBSR_DAE_INDEX1) mbsri_data_poison(tree->data);
}

static void check_form(motion *s, mbsr_dae_form form)
{
    const test_space_tree *tree = &s->tree;
    const int nq = tree->nq, nu = tree->nu, size = mbsr_dae_size(tree->model, form);
    mbsr_data *d = tree->data;
    double y[3 * MOST], yp[3 * MOST], F[3 * MOST], q[MOST], u[MOST], rate[2 * MOST];
    assert_ok(mbsr_index1_reset(tree->model, d), mbsr_data_error(d));
    mbsri_data_poison(d);
    assert_ok(mbsr_dae_pack(tree->model, d, form, now, s->q, s->u, y), mbsr_data_error(d));
    spoil(tree, form);
    assert_ok(mbsr_dae_consistent(tree->model, d, form, now, y, yp, NULL, NULL),
              mbsr_data_error(d));
    /* it is consistent already */
    spoil(tree, form);
    assert_ok(mbsr_dae_unpack(tree->model, d, form, now, y, q, u), mbsr_data_error(d));
    const double tolerance = 1e-12 * s->size / s->kept;
    for (int k = 0; k < nq; ++k) assert_close(q[k], s->q[k], 1e-14);
    for (int k = 0; k < nu; ++k) assert_close(u[k], s->u[k], tolerance);
    for (int k = 0; k < nq; ++k) assert_close(yp[k], s->qdot[k], tolerance);
    spoil(tree, form);
    assert_ok(mbsr_dae_residual(tree->model, d, form, now, y, yp, F), mbsr_data_error(d));
    for (int k = 0; k < size; ++k) assert_close(F[k], 0.0, 100.0 * tolerance * s->size);
    /* y' is the rate of y. u' without inertia stems from differences; those here are no judge of
     * badly conditioned trees */
    const double by_differences = 1e-8 * s->size * s->size / s->kept;
    if (form == MBSR_DAE_RECURSIVE || form == MBSR_DAE_INVERSE_DYNAMICS) {
        for (int k = 0; k < nu; ++k) assert_close(yp[nq + k], s->udot[k], by_differences);
        return;
    }
    if (s->kept < 1e-3) return;
    const double h = 2e-3 / s->size;
    const int momentum = form == MBSR_DAE_MOMENTUM, first = momentum ? 0 : nq;
    along_motion(tree, now, s->q, s->u, s->qdot, s->udot, h, momentum ? momenta : packed_index1,
                 momentum ? nu : nq + nu, rate);
    for (int k = 0; k < nu; ++k) assert_close(yp[nq + k], rate[first + k], by_differences);
}

static void every_form_starts_from_the_same_motion(void **unused)
{
    (void)unused;
    static const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1, MBSR_DAE_RECURSIVE,
                                          MBSR_DAE_INVERSE_DYNAMICS};
    int deficient = 0, well = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        motion s;
        start(&s, seed, seed % 2);
        check_start(&s);
        for (int f = 0; f < 4; ++f) check_form(&s, forms[f]);
        deficient += s.info.null_directions > 0;
        well += s.kept > 1e-3 && s.info.null_directions > 0;
        test_space_free(&s.tree);
    }
    print_message("%d with null directions, %d of them well conditioned\n", deficient, well);
    assert_true(deficient > TREES / 3);
    assert_true(well > TREES / 4);
}

/* dE/dt = -power, with massless joints moving as forces let them. */
static void energy_is_lost_to_damping_only(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        motion s;
        start(&s, seed, 0);
        double power, rate;
        reach_velocities(&s.tree, now, s.q, s.u);
        assert_ok(mbsr_dissipation(s.tree.model, s.tree.data, &power),
                  mbsr_data_error(s.tree.data));
        along_motion(&s.tree, now, s.q, s.u, s.qdot, s.udot, 1e-3 / s.size, energy, 1, &rate);
        assert_close(rate, -power, 1e-9 * s.size * (1.0 + power) / fmin(1.0, 10.0 * s.kept));
        test_space_free(&s.tree);
    }
}

/* Quaternions of any length give the same residual; pack and unpack bring them to length 1. */
static void the_length_of_quaternions_does_not_matter(void **unused)
{
    (void)unused;
    static const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_INDEX1, MBSR_DAE_RECURSIVE,
                                          MBSR_DAE_INVERSE_DYNAMICS};
    int quaternions = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        motion s;
        start(&s, seed, seed % 2);
        double long_q[MOST], y[3 * MOST], yp[3 * MOST], F[3 * MOST], Fl[3 * MOST], q[MOST], u[MOST];
        const int nq = s.tree.nq;
        mbsr_data *d = s.tree.data;
        memcpy(long_q, s.q, sizeof long_q);
        for (int id = 0; id < s.tree.N; ++id) {
            int at, many, n;
            assert_ok(mbsr_body_coordinates(s.tree.model, id, &at, &many, NULL, &n), NULL);
            for (int k = 0; k < 4 && many > n; ++k) long_q[at + k] *= id % 2 ? -3.0 : 1e-3;
            quaternions += many > n;
        }
        for (int f = 0; f < 4; ++f) {
            const int size = mbsr_dae_size(s.tree.model, forms[f]);
            assert_ok(mbsr_index1_reset(s.tree.model, d), mbsr_data_error(d));
            assert_ok(mbsr_dae_pack(s.tree.model, d, forms[f], now, s.q, s.u, y),
                      mbsr_data_error(d));
            test_rng rng = test_seed((uint64_t)seed);
            test_fill(&rng, size, yp);
            assert_ok(mbsr_dae_residual(s.tree.model, d, forms[f], now, y, yp, F),
                      mbsr_data_error(d));
            double packed[3 * MOST];
            assert_ok(mbsr_dae_pack(s.tree.model, d, forms[f], now, long_q, s.u, packed),
                      mbsr_data_error(d));
            for (int k = 0; k < nq; ++k) assert_close(fabs(packed[k]), fabs(y[k]), 1e-14);
            memcpy(y, long_q, sizeof(double) * (size_t)nq);
            assert_ok(mbsr_dae_residual(s.tree.model, d, forms[f], now, y, yp, Fl),
                      mbsr_data_error(d));
            const double tolerance = 1e-12 * s.size * s.size / s.kept;
            for (int k = nq; k < size; ++k) assert_close(Fl[k], F[k], tolerance);
            assert_ok(mbsr_dae_unpack(s.tree.model, d, forms[f], now, y, q, u), mbsr_data_error(d));
            for (int k = 0; k < nq; ++k) assert_close(fabs(q[k]), fabs(s.q[k]), 1e-14);
            for (int k = 0; k < s.tree.nu; ++k) assert_close(u[k], s.u[k], tolerance);
        }
        test_space_free(&s.tree);
    }
    assert_true(quaternions > TREES / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_move_as_twists_say),
        cmocka_unit_test(mass_matrix_and_momenta_are_those_of_the_points),
        cmocka_unit_test(inverse_dynamics_moves_the_points),
        cmocka_unit_test(ranks_are_those_of_the_motion_of_the_points),
        cmocka_unit_test(ranks_do_not_depend_on_units),
        cmocka_unit_test(forward_dynamics_is_inverse_to_inverse_dynamics),
        cmocka_unit_test(every_form_starts_from_the_same_motion),
        cmocka_unit_test(energy_is_lost_to_damping_only),
        cmocka_unit_test(the_length_of_quaternions_does_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
