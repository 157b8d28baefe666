/* Momenta, rates of H, J and M, and the momentum form on random trees.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * References: the dense oracle for p = M u, difference quotients of fourth order for every rate,
 * and the recursive residual (25), which must leave the same as the momentum form where forces do
 * not balance. */
#include "duration.h"
#include "expect.h"

#include "assembly/data.h"
#include "oracle.h"
#include "recursion/rank.h"
#include "recursion/rates.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

#define TREES ((uint64_t)test_seeds(48, 120))

static const double now = 0.3; /* the oracle's */

/* ---- a tree with joints and inertias as asked for -------------------------------------------- */

typedef enum without { ALL_RATES, NO_RATES, EVERY_OTHER } without;

typedef struct mass {
    int d;
    const double *M;
} mass;

typedef struct scene {
    test_tree tree; /* what it is made of; its own model is not used */
    mbsr_model *model;
    mbsr_data *data;
    int n;
    double *q, *u, *udot; /* q = u', random; q, u, udot in one block */
    double *tau;          /* read by force elements: a joint force on every coordinate */
    mass *inertia;
} scene;

static double mass_factor(int d, const double *p)
{
    return 1.0 + 0.4 * sin(p[0] + 0.5 * p[d - 1]);
}

static int mass_function(void *user, double t, const double *p, const double *V, double *M,
                         double *h)
{
    const mass *me = user;
    (void)t;
    const double factor = mass_factor(me->d, p);
    for (int k = 0; k < me->d * me->d; ++k) M[k] = factor * me->M[k];
    for (int k = 0; k < me->d; ++k) h[k] = 0.3 * V[k] * V[(k + 1) % me->d];
    return 0;
}

static int body_force(void *user, double t, int n, double *value)
{
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = 0.5 * cos(t + k);
    return 0;
}

static int joint_force(void *user, double t, int n, double *value)
{
    (void)t;
    memcpy(value, user, (size_t)n * sizeof *value);
    return 0;
}

static mbsr_joint_table table_without_rates(void)
{
    mbsr_joint_table table = test_joint_table;
    table.rates = NULL;
    return table;
}

static mbsr_joint_table bare;

static void add(scene *s, int i, without rates, int function, int offset)
{
    const test_joint *j = s->tree.joint + i;
    const int analytic = rates == ALL_RATES || (rates == EVERY_OTHER && i % 2);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = s->tree.parent[i];
    body.joint =
        mbsr_joint_custom(analytic ? &test_joint_table : &bare, j->d, j->n, s->tree.joint + i);
    s->inertia[i] = (mass){j->d, s->tree.mass[i]};
    body.inertia = function && (rates != EVERY_OTHER || i % 3)
                       ? mbsr_inertia_function(mass_function, s->inertia + i)
                       : mbsr_inertia_matrix(j->d, s->tree.mass[i]);
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    const mbsr_force_def force[] = {mbsr_force_applied(i, body_force, NULL),
                                    mbsr_force_joint_applied(i, joint_force, s->tau + offset)};
    for (int k = 0; k < (j->n > 0 ? 2 : 1); ++k)
        assert_ok(mbsr_model_add_force(s->model, force + k, NULL), mbsr_model_error(s->model));
}

static void setup(scene *s, uint64_t seed, without rates, int function)
{
    const test_tree_opt opt = {.seed = seed,
                               .bodies = 1 + (int)(seed % 9),
                               .max_d = 6,
                               .welds = 1,
                               .deficient = 0.5,
                               .bend = 0.1,
                               .moving_root = seed % 3 == 0};
    *s = (scene){0};
    test_tree_make(&s->tree, opt);
    bare = table_without_rates();
    const int n = s->n = s->tree.nu, N = s->tree.N;
    s->u = calloc(3 * (size_t)n + 1, sizeof(double));
    s->q = s->u + n;
    s->udot = s->q + n;
    s->tau = calloc((size_t)n + 1, sizeof(double));
    s->inertia = calloc((size_t)N, sizeof(mass));
    mbsr_model_def def = mbsr_default_model_def();
    if (opt.moving_root) def.root = s->tree.model->root;
    assert_int_equal(mbsr_model_create(&def, &s->model, NULL), MBSR_OK);
    for (int i = 0, offset = 0; i < N; offset += s->tree.joint[i].n, ++i)
        add(s, i, rates, function, offset);
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_int_equal(mbsr_data_create(s->model, &s->data, NULL), MBSR_OK);
    assert_int_equal(mbsr_model_nu(s->model), n);
    test_rng rng = test_seed(seed + 1000);
    test_fill(&rng, 3 * n, s->u);
    mbsri_data_poison(s->data);
}

static void teardown(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    test_tree_free(&s->tree);
    free(s->u);
    free(s->tau);
    free(s->inertia);
}

/* The kinematics at time now + h on a curve through the state with the rates u and udot. */
static void move(scene *s, double h)
{
    double *q = calloc(2 * (size_t)s->n + 1, sizeof(double)), *u = q + s->n;
    for (int k = 0; k < s->n; ++k) {
        q[k] = s->q[k] + h * s->u[k];
        u[k] = s->u[k] + h * s->udot[k];
    }
    assert_ok(mbsr_stage_positions(s->model, s->data, now + h, q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, u), mbsr_data_error(s->data));
    free(q);
}

/* sum += weight * x for the four points of  f' = (f(-2h) - 8 f(-h) + 8 f(h) - f(2h)) / 12 h. */
static const double place[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0, -8.0, 8.0, -1.0};
static const double step = 2.5e-4;

static void accumulate(size_t n, int point, const double *x, double *sum)
{
    for (size_t k = 0; k < n; ++k) sum[k] += weight[point] / (12.0 * step) * x[k];
}

/* Joint forces with which udot is the acceleration of the state. */
static void balance_forces(scene *s)
{
    double *tau = calloc((size_t)s->n + 1, sizeof(double));
    assert_ok(mbsr_inverse_dynamics(s->model, s->data, now, s->q, s->u, s->udot, NULL, tau),
              mbsr_data_error(s->data));
    memcpy(s->tau, tau, (size_t)s->n * sizeof *tau);
    free(tau);
    mbsri_data_poison(s->data);
}

/* ---- p --------------------------------------------------------------------------------------- */

/* p = B^T M (B u + bI) by the oracle, whose body velocities are V = B u + bI. */
static void momenta_are_those_of_the_dense_equations(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        scene s;
        setup(&s, seed, ALL_RATES, 0);
        test_tree *tree = &s.tree; /* the oracle reads this one's data */
        double *p = calloc((size_t)s.n + 1, sizeof(double));
        mbsri_data_poison(tree->data);
        assert_int_equal(mbsr_momenta(tree->model, tree->data, p), MBSR_ERR_SEQUENCE);
        assert_int_equal(mbsr_stage_positions(tree->model, tree->data, now, s.q), MBSR_OK);
        assert_int_equal(mbsr_momenta(tree->model, tree->data, p), MBSR_ERR_SEQUENCE);
        assert_int_equal(mbsr_stage_velocities(tree->model, tree->data, s.u), MBSR_OK);
        assert_int_equal(mbsr_momenta(tree->model, tree->data, NULL), MBSR_ERR_NULL);
        assert_int_equal(mbsr_momenta(tree->model, tree->data, p), MBSR_OK);
        test_oracle o;
        test_oracle_make(&o, tree, s.u);
        double *V = calloc(2 * (size_t)o.v, sizeof(double)), *MV = V + o.v;
        for (int r = 0; r < o.v; ++r) {
            V[r] = o.bI[r];
            for (int c = 0; c < o.n; ++c) V[r] += o.B[c * o.v + r] * s.u[c];
        }
        for (int c = 0; c < o.v; ++c) {
            for (int r = 0; r < o.v; ++r) MV[r] += o.M[c * o.v + r] * V[c];
        }
        for (int c = 0; c < o.n; ++c) {
            double expected = 0.0;
            for (int r = 0; r < o.v; ++r) expected += o.B[c * o.v + r] * MV[r];
            assert_close(p[c], expected, 1e-11 * (1.0 + test_largest(o.n * o.n, o.mass)));
        }
        free(V);
        free(p);
        test_oracle_free(&o);
        teardown(&s);
    }
}

/* out = p - M u by the library; *size gets the size of what was subtracted. */
static void momenta_less_mass_times_rates(scene *s, const double *u, double *out, double *size)
{
    const size_t n = (size_t)s->n;
    double *matrix = calloc(n * n + 1, sizeof(double));
    assert_ok(mbsr_stage_positions(s->model, s->data, now, s->q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, u), mbsr_data_error(s->data));
    assert_ok(mbsr_mass_matrix(s->model, s->data, matrix), mbsr_data_error(s->data));
    assert_ok(mbsr_momenta(s->model, s->data, out), mbsr_data_error(s->data));
    for (size_t r = 0; r < n; ++r) {
        for (size_t c = 0; c < n; ++c) out[r] -= matrix[c * n + r] * u[c];
    }
    *size = 1.0 + test_largest(s->n * s->n, matrix);
    free(matrix);
}

static void momenta_are_mass_matrix_times_rates(void **state)
{
    (void)state;
    double moved = 0.0;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        scene s;
        setup(&s, seed, ALL_RATES, seed % 2 == 0);
        double *a = calloc(2 * (size_t)s.n + 1, sizeof(double)), *b = a + s.n, size;
        /* prescribed motion gives a part that does not depend on u */
        momenta_less_mass_times_rates(&s, s.u, a, &size);
        momenta_less_mass_times_rates(&s, s.udot, b, &size);
        for (int k = 0; k < s.n; ++k) assert_close(a[k], b[k], 1e-12 * size);
        moved = fmax(moved, test_largest(s.n, a));
        /* without it there is none */
        for (int i = 0; i < s.tree.N; ++i) memset(s.tree.joint[i].c, 0, sizeof s.tree.joint[i].c);
        momenta_less_mass_times_rates(&s, s.u, a, &size);
        for (int k = 0; k < s.n && !s.tree.root_d; ++k) assert_close(a[k], 0.0, 1e-12 * size);
        free(a);
        teardown(&s);
    }
    assert_less(0.1, moved);
}

/* ---- rates ----------------------------------------------------------------------------------- */

static void check_rates(scene *s)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    const size_t total = m->size.dp + m->size.dn + m->size.dd;
    double *sum = calloc(total + 1, sizeof(double));
    for (int point = 0; point < 4; ++point) {
        move(s, place[point] * step);
        accumulate(m->size.dp, point, d->H, sum);
        accumulate(m->size.dn, point, d->J, sum + m->size.dp);
        accumulate(m->size.dd, point, d->M, sum + m->size.dp + m->size.dn);
    }
    mbsri_data_poison(d);
    move(s, 0.0);
    assert_ok(mbsri_rates(m, d), mbsr_data_error(d));
    const double size = 1.0 + test_largest((int)total, sum);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t dH = (size_t)(b->d * b->pred.d), dJ = (size_t)(b->d * b->n),
                     dM = (size_t)(b->d * b->d);
        const double *H = sum + b->dp, *J = sum + m->size.dp + b->dn,
                     *M = sum + m->size.dp + m->size.dn + b->dd;
        for (size_t k = 0; k < dH; ++k) assert_close(d->Hdot[b->dp + k], H[k], 1e-8 * size);
        for (size_t k = 0; k < dJ; ++k) assert_close(d->Jdot[b->dn + k], J[k], 1e-8 * size);
        for (size_t k = 0; k < dM; ++k) assert_close(d->Mdot[b->dd + k], M[k], 1e-8 * size);
    }
    free(sum);
}

static void rates_are_difference_quotients(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        scene s;
        setup(&s, seed, (without)(seed % 3), seed % 2 == 0);
        check_rates(&s);
        teardown(&s);
    }
}

/* Prescribed angle (coordinate 2) of a planar joint. */
static int swing(void *user, double t, double *value, double *rate, double *acceleration)
{
    (void)user;
    value[0] = sin(3.0 * t);
    rate[0] = 3.0 * cos(3.0 * t);
    acceleration[0] = -9.0 * sin(3.0 * t);
    return 0;
}

static void rates_of_stock_joints_and_inertias(void **state)
{
    (void)state;
    const mbsr_planar_frame A = {0.3, -0.2, 0.7}, B = {-0.5, 0.1, 0.4};
    const mbsr_inertia rigid = mbsr_inertia_planar(2.0, (double[2]){0.3, -0.6}, 0.4);
    const struct {
        int parent;
        mbsr_joint joint;
        mbsr_inertia inertia;
    } part[] = {{MBSR_GROUND, mbsr_joint_planar_free(A, B), rigid},
                {0, mbsr_joint_planar_revolute(A, B), rigid},
                {1, mbsr_joint_planar_prismatic(A, B), mbsr_inertia_particle(1.5)},
                {0, mbsr_joint_planar(A, B, MBSR_X | MBSR_Y, MBSR_ANGLE, swing, NULL), rigid},
                {3, mbsr_joint_point(A, MBSR_Y, 0, NULL, NULL), mbsr_inertia_particle(0.5)},
                {4, mbsr_joint_planar_pin_slot(A, B), rigid}};
    scene s = {0};
    double values[3 * 16];
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), MBSR_OK);
    for (int k = 0; k < 6; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = part[k].parent;
        body.joint = part[k].joint;
        body.inertia = part[k].inertia;
        assert_ok(mbsr_model_add_body(s.model, &body, NULL), mbsr_model_error(s.model));
    }
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), MBSR_OK);
    s.n = mbsr_model_nu(s.model);
    assert_in_range(s.n, 9, 16);
    s.q = values;
    s.u = values + 16;
    s.udot = values + 32;
    test_rng rng = test_seed(11);
    for (int trial = 0; trial < 10; ++trial) {
        test_fill(&rng, 48, values);
        check_rates(&s);
    }
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

/* Differences displace the state; afterwards everything is as before. */
static void rates_leave_the_state_as_it_was(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        scene s;
        setup(&s, seed, NO_RATES, 1);
        const mbsr_model *m = s.model;
        mbsr_data *d = s.data;
        move(&s, 0.0);
        const double *const array[] = {d->p, d->V, d->kI, d->kII, d->h, d->H, d->J, d->M};
        const size_t length[] = {m->size.p, m->size.v,  m->size.v,  m->size.v,
                                 m->size.v, m->size.dp, m->size.dn, m->size.dd};
        double *kept[8];
        for (int k = 0; k < 8; ++k) {
            kept[k] = calloc(length[k] + 1, sizeof(double));
            memcpy(kept[k], array[k], length[k] * sizeof(double));
        }
        assert_ok(mbsri_rates(m, d), mbsr_data_error(d));
        assert_true(d->t == now);
        assert_int_equal(d->stage, MBSRI_STAGE_VELOCITIES);
        for (int k = 0; k < 8; ++k) {
            assert_memory_equal(kept[k], array[k], length[k] * sizeof(double));
            free(kept[k]);
        }
        teardown(&s);
    }
}

/* ---- p' -------------------------------------------------------------------------------------- */

/* With yp = 0 the first two blocks of F are -q' and -p'. */
static void check_momentum_rates(uint64_t seed, without rates, int function, double tolerance)
{
    scene s;
    setup(&s, seed, rates, function);
    const int n = s.n;
    balance_forces(&s);
    double *sum = calloc(11 * (size_t)n + 1, sizeof(double)), *p = sum + n, *y = sum + 2 * n,
           *yp = sum + 5 * n, *F = sum + 8 * n;
    for (int point = 0; point < 4; ++point) {
        move(&s, place[point] * step);
        assert_ok(mbsr_momenta(s.model, s.data, p), mbsr_data_error(s.data));
        accumulate((size_t)n, point, p, sum);
    }
    mbsri_data_poison(s.data);
    assert_ok(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, now, s.q, s.u, y), NULL);
    mbsri_data_poison(s.data);
    assert_ok(mbsr_dae_residual(s.model, s.data, MBSR_DAE_MOMENTUM, now, y, yp, F),
              mbsr_data_error(s.data));
    const double size = 1.0 + test_largest(n, s.tau) + test_largest(n, sum);
    for (int k = 0; k < n; ++k) {
        assert_close(F[k], -s.u[k], 0.0);
        assert_close(F[n + k], -sum[k], tolerance * size);
        /* the forces balance and p = M u: the algebraic equations hold whatever y' is */
        assert_close(F[2 * n + k], 0.0, 1e-10 * size);
    }
    free(sum);
    teardown(&s);
}

static void rates_of_momenta_are_difference_quotients(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        for (int function = 0; function < 2; ++function) {
            check_momentum_rates(seed, ALL_RATES, function, function ? 1e-7 : 1e-10);
            check_momentum_rates(seed, NO_RATES, function, 1e-7);
            check_momentum_rates(seed, EVERY_OTHER, function, 1e-7);
        }
    }
}

/* ---- the form -------------------------------------------------------------------------------- */

static test_tree_opt with_forces(uint64_t seed)
{
    return (test_tree_opt){.seed = seed,
                           .bodies = 1 + (int)(seed % 9),
                           .max_d = 6,
                           .welds = 1,
                           .deficient = 0.5,
                           .bend = 0.1,
                           .forces = 1,
                           .moving_root = seed % 3 == 0};
}

static void size_id_and_order_of_y(void **state)
{
    (void)state;
    test_tree tree;
    test_tree_make(&tree, with_forces(7));
    const int n = tree.nu;
    assert_in_range(n, 3, 60);
    assert_int_equal(mbsr_dae_size(tree.model, MBSR_DAE_MOMENTUM), 3 * n);
    double q[60], u[60], y[181], id[181], p[60], back_q[61], back_u[61];
    for (int k = 0; k < 181; ++k) y[k] = id[k] = 77.0;
    back_q[n] = back_u[n] = 77.0;
    test_rng rng = test_seed(3);
    test_fill(&rng, n, q);
    test_fill(&rng, n, u);
    assert_int_equal(mbsr_dae_id(tree.model, tree.data, MBSR_DAE_MOMENTUM, id), MBSR_OK);
    for (int k = 0; k < 3 * n; ++k) assert_true(id[k] == (k < 2 * n ? 1.0 : 0.0));
    assert_int_equal(mbsr_dae_pack(tree.model, tree.data, MBSR_DAE_MOMENTUM, now, q, u, y),
                     MBSR_OK);
    assert_int_equal(mbsr_stage_positions(tree.model, tree.data, now, q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(tree.model, tree.data, u), MBSR_OK);
    assert_int_equal(mbsr_momenta(tree.model, tree.data, p), MBSR_OK);
    const size_t bytes = (size_t)n * sizeof(double);
    assert_memory_equal(y, q, bytes);
    assert_memory_equal(y + n, p, bytes);
    assert_memory_equal(y + 2 * n, u, bytes);
    assert_true(y[3 * n] == 77.0 && id[3 * n] == 77.0);
    assert_int_equal(
        mbsr_dae_unpack(tree.model, tree.data, MBSR_DAE_MOMENTUM, now, y, back_q, back_u), MBSR_OK);
    assert_memory_equal(back_q, q, bytes);
    assert_memory_equal(back_u, u, bytes);
    assert_true(back_q[n] == 77.0 && back_u[n] == 77.0);
    test_tree_free(&tree);
}

/* Residual of the momentum form at (q, p, u) with y' = 0; F: 3 n. */
static void residual_at(const test_tree *tree, const double *q, const double *p, const double *u,
                        double *F)
{
    const size_t n = (size_t)tree->nu, bytes = n * sizeof(double);
    double *y = calloc(6 * n + 1, sizeof(double));
    memcpy(y, q, bytes);
    memcpy(y + n, p, bytes);
    memcpy(y + 2 * n, u, bytes);
    mbsri_data_poison(tree->data);
    assert_ok(mbsr_dae_residual(tree->model, tree->data, MBSR_DAE_MOMENTUM, now, y, y + 3 * n, F),
              mbsr_data_error(tree->data));
    free(y);
}

/* What the recursive residual (25) leaves at the accelerations that follow from the forces. */
static void recursive_remainder(const test_tree *tree, const double *q, const double *u,
                                double *remainder)
{
    double *udot = calloc((size_t)tree->nu + 1, sizeof(double));
    mbsri_data_poison(tree->data);
    const int status = mbsr_forward_dynamics(tree->model, tree->data, now, q, u, NULL, udot);
    assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
    mbsri_data_poison(tree->data);
    assert_ok(mbsr_recursive_residual(tree->model, tree->data, now, q, u, udot, NULL, remainder),
              mbsr_data_error(tree->data));
    free(udot);
}

/* Smallest scaled eigenvalue that counted: rounding errors grow with its reciprocal. */
static double smallest_kept(const test_tree *tree)
{
    double value = 1.0;
    for (int i = 0; i < tree->N; ++i) {
        mbsr_rank_info info;
        assert_int_equal(mbsr_body_rank(tree->model, tree->data, i, &info), MBSR_OK);
        if (info.rank > 0) value = fmin(value, info.smallest_kept);
    }
    return value;
}

/* A p that is no momentum of any u, as errors of an integration make it, must not change the
 * balance of forces in the algebraic equations: what of alg no inertia takes up stays `rest`. */
static void check_balance_for_any_momenta(const test_tree *tree, test_rng *rng, const double *q,
                                          const double *u, const double *rest)
{
    const mbsr_model *m = tree->model;
    double *p = calloc(4 * (size_t)m->nu + 1, sizeof(double)), *F = p + m->nu, part[TEST_MAX_D];
    test_fill(rng, m->nu, p);
    residual_at(tree, q, p, u, F);
    const double size = (1.0 + test_largest(m->nu, rest)) / smallest_kept(tree);
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, tree->data, i)) continue;
        const mbsri_group g = mbsri_group_of(m, tree->data, i);
        double given[TEST_MAX_D];
        mbsri_group_gather(m, &g, F + 2 * m->nu, given);
        mbsri_null_force(m, tree->data, &g, given, part);
        mbsri_group_gather(m, &g, rest, given);
        for (int k = 0; k < g.n && mbsri_group_rank(tree->data, &g) < g.n; ++k)
            assert_close(part[k], given[k], 1e-11 * size);
    }
    free(p);
}

/* Where p = M u, the algebraic equations leave exactly what (25) leaves, the forces that no
 * inertia takes up: both forms hold together or not at all. A change of u that moves no mass keeps
 * that; any other violates p = M u and must be seen. */
static void the_form_holds_where_the_recursive_one_does(void **state)
{
    (void)state;
    int deficient = 0;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        test_tree tree;
        test_tree_make(&tree, with_forces(seed));
        const int n = tree.nu;
        double *x = calloc(12 * (size_t)n + 1, sizeof(double)), *u = x, *q = x + n, *p = x + 2 * n,
               *F = x + 3 * n, *rest = x + 6 * n, *z = x + 7 * n, *other = x + 8 * n,
               *Mz = x + 9 * n;
        test_rng rng = test_seed(seed + 1000);
        test_fill(&rng, 2 * n, x);
        assert_int_equal(mbsr_stage_positions(tree.model, tree.data, now, q), MBSR_OK);
        assert_int_equal(mbsr_stage_velocities(tree.model, tree.data, u), MBSR_OK);
        assert_int_equal(mbsr_momenta(tree.model, tree.data, p), MBSR_OK);
        test_oracle o;
        test_oracle_make(&o, &tree, x);
        const double *alg = F + 2 * n;
        for (int trial = 0; trial < 3; ++trial) {
            /* u as it is; plus a null vector of the mass matrix; plus any vector */
            memset(z, 0, (size_t)n * sizeof *z);
            if (trial > 0) test_fill(&rng, n, z);
            recursive_remainder(&tree, q, u, rest);
            const int rank = mbsr_total_rank(tree.model, tree.data);
            const double rounding = 1e-11 / smallest_kept(&tree);
            if (trial == 0) deficient += rank < n;
            if (trial == 1 && n > 0) test_null_projection(n, o.mass, rank, z);
            for (int k = 0; k < n; ++k) other[k] = u[k] + z[k];
            for (int k = 0; k < n; ++k) {
                Mz[k] = 0.0;
                for (int c = 0; c < n; ++c) Mz[k] += o.mass[c * n + k] * z[c];
            }
            recursive_remainder(&tree, q, other, rest);
            residual_at(&tree, q, p, other, F);
            if (trial == 0) check_balance_for_any_momenta(&tree, &rng, q, other, rest);
            double off = 0.0;
            for (int k = 0; k < n; ++k) off = fmax(off, fabs(alg[k] - rest[k]));
            const double size = 1.0 + test_largest(n, rest) + test_largest(n, alg);
            if (trial < 2) {
                assert_close(off, 0.0, rounding * size);
            } else {
                assert_true(off >= 1e-3 * test_largest(n, Mz));
            }
        }
        test_oracle_free(&o);
        free(x);
        test_tree_free(&tree);
    }
    assert_true(deficient > (int)TREES / 4);
}

static void the_residual_vanishes_at_the_consistent_start(void **state)
{
    (void)state;
    int null = 0;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        test_tree tree;
        test_tree_make(&tree, with_forces(seed));
        const int n = tree.nu;
        double *y = calloc(11 * (size_t)n + 1, sizeof(double)), *yp = y + 3 * n, *F = y + 6 * n,
               *q = y + 9 * n, *u = y + 10 * n;
        test_rng rng = test_seed(seed + 1000);
        test_fill(&rng, n, q);
        test_fill(&rng, n, u);
        mbsr_consistent_info info;
        assert_int_equal(mbsr_dae_pack(tree.model, tree.data, MBSR_DAE_MOMENTUM, now, q, u, y),
                         MBSR_OK);
        mbsri_data_poison(tree.data);
        const int status =
            mbsr_dae_consistent(tree.model, tree.data, MBSR_DAE_MOMENTUM, now, y, yp, NULL, &info);
        assert_ok(status, mbsr_data_error(tree.data));
        null += info.null_directions > 0;
        assert_int_equal(mbsr_dae_residual(tree.model, tree.data, MBSR_DAE_MOMENTUM, now, y, yp, F),
                         MBSR_OK);
        const double size = 1.0 + test_largest(6 * n, y);
        for (int k = 0; k < 3 * n; ++k) assert_close(F[k], 0.0, 1e-9 * size);
        /* and the other forms vanish at the same (q, u, u') */
        memcpy(y + n, y + 2 * n, (size_t)n * sizeof *y);
        memcpy(yp + n, yp + 2 * n, (size_t)n * sizeof *y);
        const mbsr_dae_form forms[] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS};
        for (int f = 0; f < 2; ++f) {
            assert_int_equal(mbsr_dae_residual(tree.model, tree.data, forms[f], now, y, yp, F),
                             MBSR_OK);
            for (int k = 0; k < 2 * n; ++k) assert_close(F[k], 0.0, 1e-8 * size);
        }
        free(y);
        test_tree_free(&tree);
    }
    assert_true(null > (int)TREES / 4);
}

/* The same tree with ids in another order: the same numbers at other places. */
static void numbering_does_not_matter(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= TREES; ++seed) {
        test_tree a, b;
        test_tree_opt opt = with_forces(seed);
        test_tree_make(&a, opt);
        opt.shuffle = 1;
        test_tree_make(&b, opt);
        const int n = a.nu, size = 3 * n;
        double *ya = calloc(6 * (size_t)size + 1, sizeof(double)), *pa = ya + size, *Fa = pa + size,
               *yb = Fa + size, *pb = yb + size, *Fb = pb + size;
        test_rng rng = test_seed(seed + 1000);
        test_fill(&rng, 2 * size, ya);
        for (int id = 0; id < b.N; ++id) {
            int from, to, count;
            mbsr_body_coordinates(a.model, b.label[id], NULL, NULL, &from, &count);
            mbsr_body_coordinates(b.model, id, NULL, NULL, &to, NULL);
            for (int k = 0; k < 3 * count; ++k) {
                const int block = k / count * n, l = k % count;
                yb[block + to + l] = ya[block + from + l];
                pb[block + to + l] = pa[block + from + l];
            }
        }
        assert_int_equal(mbsr_dae_residual(a.model, a.data, MBSR_DAE_MOMENTUM, now, ya, pa, Fa), 0);
        assert_int_equal(mbsr_dae_residual(b.model, b.data, MBSR_DAE_MOMENTUM, now, yb, pb, Fb), 0);
        const double rounding = 1e-11 * (1.0 + test_largest(size, Fa)) / smallest_kept(&a);
        for (int id = 0; id < b.N; ++id) {
            int from, to, count;
            mbsr_body_coordinates(a.model, b.label[id], NULL, NULL, &from, &count);
            mbsr_body_coordinates(b.model, id, NULL, NULL, &to, NULL);
            for (int k = 0; k < 3 * count; ++k) {
                const int block = k / count * n, l = k % count;
                assert_close(Fb[block + to + l], Fa[block + from + l], rounding);
            }
        }
        free(ya);
        test_tree_free(&a);
        test_tree_free(&b);
    }
}

/* ---- more position than velocity coordinates ------------------------------------------------- */

/* An angle that is stored as q = (cos, sin): p = p_pred + atan2(q). */
static int circle_position(const mbsr_joint_args *args, double *p)
{
    p[0] = (args->pred_d > 0 ? args->p_pred[0] : 0.0) + atan2(args->q[1], args->q[0]);
    return 0;
}

static int circle_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                            double *kI)
{
    (void)K;
    (void)kI;
    if (args->pred_d > 0) H[0] = -1.0;
    J[0] = -1.0;
    return 0;
}

static int circle_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args;
    (void)kII;
    return 0;
}

static int circle_rates_of_q(const mbsr_joint_args *args, double *qdot)
{
    qdot[0] = -args->q[1] * args->u[0];
    qdot[1] = args->q[0] * args->u[0];
    return 0;
}

static int uneven_wheel(void *user, double t, const double *p, const double *V, double *M,
                        double *h)
{
    (void)user;
    (void)t;
    M[0] = 2.0 + cos(p[0]);
    h[0] = -0.5 * sin(p[0]) * V[0] * V[0];
    return 0;
}

/* Two wheels in a row of mass M = 2 + cos(angle), h = M' V^2 / 2 as Lagrange's equations have it:
 *   p_2 = M_2 V_2, p_1 = M_1 V_1 + p_2,   p_2' = M_2' V_2 - h_2 - c angle_2 ... */
static void more_positions_than_velocities(void **state)
{
    (void)state;
    static const mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                                           .flags = MBSR_JOINT_UNIT_K,
                                           .name = "circle",
                                           .position = circle_position,
                                           .jacobians = circle_jacobians,
                                           .bias = circle_bias,
                                           .coordinate_rates = circle_rates_of_q};
    mbsr_model *m;
    mbsr_data *d;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_custom(&table, 1, 1, NULL);
        body.joint.nq = 2;
        body.inertia = mbsr_inertia_function(uneven_wheel, NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def spring = mbsr_force_axis_spring(1, MBSR_GROUND, 0, 7.0, 0.5, 0.25);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 8);
    double id[8], y[8], yp[8] = {0.0}, F[8];
    assert_int_equal(mbsr_dae_id(m, d, MBSR_DAE_MOMENTUM, id), MBSR_OK);
    for (int k = 0; k < 8; ++k) assert_true(id[k] == (k < 6 ? 1.0 : 0.0));

    const double angle[2] = {0.4, 1.1}, V[2] = {1.5, 0.7};
    const double q[4] = {cos(0.4), sin(0.4), cos(0.7), sin(0.7)}, u[2] = {1.5, -0.8};
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    const double M[2] = {2.0 + cos(angle[0]), 2.0 + cos(angle[1])};
    assert_close(y[5], M[1] * V[1], 1e-14);
    assert_close(y[4], M[0] * V[0] + M[1] * V[1], 1e-14);
    assert_true(y[6] == u[0] && y[7] == u[1]);
    mbsri_data_poison(d);
    assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(d));
    for (int k = 0; k < 2; ++k) {
        assert_close(F[2 * k], q[2 * k + 1] * u[k], 1e-15);
        assert_close(F[2 * k + 1], -q[2 * k] * u[k], 1e-15);
    }
    /* M' V - h = -sin(angle) V^2 / 2 */
    const double spring_force = -7.0 * (angle[1] - 0.25) - 0.5 * V[1];
    const double rate[2] = {-0.5 * sin(angle[0]) * V[0] * V[0], -0.5 * sin(angle[1]) * V[1] * V[1]};
    assert_close(F[5], -(rate[1] + spring_force), 1e-8);
    assert_close(F[4], -(rate[0] + rate[1] + spring_force), 1e-8);
    assert_close(F[6], 0.0, 1e-13);
    assert_close(F[7], 0.0, 1e-13);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(momenta_are_those_of_the_dense_equations),
        cmocka_unit_test(momenta_are_mass_matrix_times_rates),
        cmocka_unit_test(rates_are_difference_quotients),
        cmocka_unit_test(rates_of_stock_joints_and_inertias),
        cmocka_unit_test(rates_leave_the_state_as_it_was),
        cmocka_unit_test(rates_of_momenta_are_difference_quotients),
        cmocka_unit_test(size_id_and_order_of_y),
        cmocka_unit_test(the_form_holds_where_the_recursive_one_does),
        cmocka_unit_test(the_residual_vanishes_at_the_consistent_start),
        cmocka_unit_test(numbering_does_not_matter),
        cmocka_unit_test(more_positions_than_velocities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
