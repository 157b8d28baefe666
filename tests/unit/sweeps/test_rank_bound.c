/* The bound of rounding errors that the vectorised sweeps carry, two numbers, against the matrix W
 * that it bounds: W <= kappa Mbar + spread Lambda behind every joint and at every predecessor, and
 * the same ranks (docs/performance.md). The steps are those of the sweeps, which are compiled here.
 * SPDX-License-Identifier: BSD-3-Clause */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wpsabi" /* vectors are arguments of inlined functions only */
#endif
#include "sweeps/backward.h"
#include "sweeps/forward.h"
#include "sweeps/inverse.h"
#include "sweeps/momentum.h"
#include "sweeps/motion.h"
#include "sweeps/trigonometry.h"

#include "duration.h"
#include "expect.h"
#include "space.h"
#include "algebra/dense.h"

#include <stdlib.h>

/* All sweeps are used, as far as the compiler can tell. */
static const mbsri_sweep_kernels here = {
    "here",         trigonometry,  kinematics, backward, forward, inverse, velocities, momentum,
    block_backward, forward_block, NULL,       NULL,     NULL,    NULL,    NULL};

enum { MOST = 8 }; /* bodies */

typedef struct counts {
    int bodies, skipped, zero; /* bounds compared, joints that it does not tell, of rank 0 */
    int stricter;              /* that W does not tell, of which more is wanted than of its bound */
    int unlike; /* where only one of the two left out what the joint behind has taken */
} counts;

/* The symmetric matrix in units of Lambda: [L^-1 1; 1]^T A [L^-1 1; 1]. */
static void scaled(const mbsri_carry *c, double length, double A[36])
{
    for (int k = 0; k < 36; ++k) A[k] = 0.0;
    mbsri_carry_add_to(c, A);
    for (int j = 0; j < 6; ++j) {
        for (int k = 0; k < 6; ++k) A[6 * j + k] /= (j < 3 ? length : 1.0) * (k < 3 ? length : 1.0);
    }
}

/* The smallest eigenvalue of kappa Mbar + spread Lambda - W is not negative. */
static void assert_bounded(const blocks *c, const blocks *W, double length)
{
    _Alignas(32) mbsri_carry Mbar, noise;
    double A[36], B[36], lambda[6], size = 0.0;
    to_memory(c, &Mbar);
    to_memory(W, &noise);
    scaled(&Mbar, length, A);
    scaled(&noise, length, B);
    for (int k = 0; k < 36; ++k) {
        const double bound = c->kappa * A[k] + (k % 7 == 0 ? c->spread : 0.0);
        size = fmax(size, fabs(bound));
        B[k] = bound - B[k];
    }
    assert_int_equal(mbsri_jacobi(6, B, lambda), 0);
    if (!(lambda[5] >= -1e-12 * size)) fail_msg("bound below W by %g of %g", -lambda[5], size);
}

/* S^T W S and what D is added up of, in units of the machine precision. */
static double errors_of(const mbsri_sweep_run *run, int i, const blocks *c, const blocks *W)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const screw S = {b->flags, b->pitch, load(run->state[i].R + 8)};
    v4 x_L, x_p;
    times_axis(&S, W, &x_L, &x_p);
    return along_axis(&S, x_L, x_p, 0.0) + local_size(&S, c);
}

/* sweep_back of backward.h with both at once. */
static void compare(const mbsri_sweep_run *run, counts *n)
{
    const mbsri_sweeps *tree = run->tree;
    mbsri_carry *top = run->stack, *noise_top = run->noise;
    blocks c, W;
    clear(&c);
    clear(&W);
    for (int i = tree->bodies; i >= 1; --i) {
        const mbsri_sweep_body *b = tree->body + i;
        if (b->flags & MBSRI_LEAF) clear(&c), clear(&W);
        if (b->flags & MBSRI_BRANCHES) add(--top, &c), add(--noise_top, &W);
        if (!(b->flags & MBSRI_MASSLESS)) add_own(b, run->state + i, &c);
        blocks judged = c;
        const double errors = b->flags & MBSRI_MULTI ? 0.0 : errors_of(run, i, &c, &W);
        const bool told = pass_joint(run, i, &c, NULL);
        const int rank = run->rank[i];
        if (!told) {
            ++n->skipped;
            return;
        }
        const mbsri_sweep_state left = run->state[i];
        if (!pass_joint(run, i, &judged, &W)) {
            ++n->stricter;
            return;
        }
        assert_int_equal(rank, run->rank[i]);
        n->zero += b->n > rank;
        if (!(b->flags & MBSRI_MULTI) && left.D != run->state[i].D) {
            assert_close(left.D, run->state[i].D, 1e-15 * errors);
            ++n->unlike; /* W is that of other sums from here on */
            return;
        }
        if (b->parent == 0) continue;
        ++n->bodies;
        assert_bounded(&c, &W, tree->length);
        /* and at the body's own point */
        const v4 rho = load(run->state[i].rho);
        blocks own = c, own_W = W;
        translate(-rho, &own);
        translate(-rho, &own_W);
        own.spread /= stretch(run, i);
        assert_bounded(&own, &own_W, tree->length);
        if (b->flags & MBSRI_NEXT) continue;
        if (!(b->flags & MBSRI_OPENS)) add(--top, &c), add(--noise_top, &W);
        to_memory(&c, top++);
        to_memory(&W, noise_top++);
    }
}

/* ---- trees with masses, sizes and distances of several orders of magnitude ---- */

static double power(test_rng *rng, double low, double high)
{
    return pow(10.0, low + 0.5 * (high - low) * (1.0 + test_uniform(rng)));
}

/* No mass, a particle, a rod, or six particles; along z, where oblique ones would be blocks. */
static mbsr_inertia random_inertia(test_rng *rng, bool along_z)
{
    static const int points[] = {0, 0, 0, 1, 1, 2, 6, 6, 6, 6};
    const int count = points[test_integer(rng, 0, 9)];
    const double mass = power(rng, -3.0, 2.0), size = power(rng, -2.0, 1.0),
                 off = test_integer(rng, 0, 1) ? power(rng, -1.0, 0.5) : 0.0;
    double com[3], at[3];
    mbsr_inertia sum = mbsr_inertia_zero();
    test_fill(rng, 3, com);
    for (int l = 0; l < count; ++l) {
        test_fill(rng, 3, at);
        for (int k = 0; k < 3; ++k) at[k] = off * com[k] + size * at[k];
        if (along_z && count < 3) at[0] = at[1] = 0.0;
        const mbsr_inertia point = mbsr_inertia_point_mass(mass, at);
        sum = l == 0 ? point : mbsr_inertia_sum(sum, point);
    }
    return sum;
}

static int random_kind(test_rng *rng)
{
    static const int kinds[] = {TEST_REVOLUTE,  TEST_REVOLUTE,  TEST_REVOLUTE, TEST_REVOLUTE,
                                TEST_PRISMATIC, TEST_PRISMATIC, TEST_SCREW,    TEST_WELD,
                                TEST_UNIVERSAL, TEST_SPHERICAL};
    return kinds[test_integer(rng, 0, 9)];
}

/* About the axis of the joint before, or one that is nearly parallel to it, at a distance. */
static mbsr_joint aligned_joint(test_rng *rng, const double axis[3], double own[3])
{
    const double tilt = test_integer(rng, 0, 1) ? power(rng, -9.0, -2.0) : 0.0,
                 distance = test_integer(rng, 0, 1) ? power(rng, -6.0, 1.0) : 0.0;
    double x[3], turn[3];
    test_fill(rng, 3, x);
    test_fill(rng, 3, turn);
    for (int k = 0; k < 3; ++k) x[k] *= distance, own[k] = axis[k] + tilt * turn[k];
    const mbsr_frame A = {{x[0], x[1], x[2]}, {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    return test_integer(rng, 0, 4) ? mbsr_joint_revolute(&A, NULL, own)
                                   : mbsr_joint_prismatic(&A, NULL, own);
}

static mbsr_model *random_model(test_rng *rng, int bodies)
{
    double axis[MOST][3];
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int i = 0; i < bodies; ++i) {
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = i == 0 || test_integer(rng, 0, 3) ? i - 1 : test_integer(rng, 0, i - 1);
        if (i == 0) def.parent = MBSR_GROUND;
        const bool aligned = i > 0 && test_integer(rng, 0, 2) == 0;
        const int kind = aligned ? TEST_REVOLUTE : random_kind(rng);
        test_fill(rng, 3, axis[i]);
        def.joint = aligned                 ? aligned_joint(rng, axis[def.parent], axis[i])
                    : kind == TEST_REVOLUTE ? mbsr_joint_revolute(NULL, NULL, axis[i])
                                            : test_joint_in_space(rng, kind, power(rng, -1.5, 1.5));
        def.inertia = random_inertia(rng, kind == TEST_WELD || kind == TEST_UNIVERSAL ||
                                              kind == TEST_SPHERICAL);
        assert_ok(mbsr_model_add_body(m, &def, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_non_null(m->tree.plain);
    assert_int_equal(m->tree.plain->blocks, 0);
    return m;
}

static void check_tree(uint64_t seed, counts *n)
{
    test_rng rng = test_seed(seed);
    mbsr_model *m = random_model(&rng, 1 + test_integer(&rng, 0, MOST - 1));
    mbsr_data *d = NULL;
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    test_fill(&rng, m->nq, d->q);
    test_fill(&rng, m->nu, d->u);
    mbsri_zero((size_t)m->nu, d->tau);
    const mbsri_sweep_run run = {.model = m,
                                 .data = d,
                                 .tree = m->tree.plain,
                                 .state = d->sweep.state,
                                 .multi = d->sweep.multi,
                                 .stack = d->sweep.stack,
                                 .noise = d->sweep.noise,
                                 .sincos = d->sincos,
                                 .q = d->q,
                                 .u = d->u,
                                 .tau = d->tau,
                                 .rank = d->rank};
    memset(run.state, 0, sizeof *run.state);
    for (int k = 0; k < 3; ++k) run.state->R[5 * k] = 1.0;
    here.trigonometry(m->nq, run.q, run.sincos);
    assert_int_equal(here.kinematics(&run), 0);
    compare(&run, n);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void random_trees(void **unused)
{
    (void)unused;
    counts n = {0};
    const int trees = test_seeds(1000, 5000);
    for (int seed = 1; seed <= trees; ++seed) check_tree((uint64_t)seed, &n);
    print_message("%d bounds, %d joints of lower rank, %d trees left at a joint, %d by W alone, %d "
                  "with other sums\n",
                  n.bodies, n.zero, n.skipped, n.stricter, n.unlike);
    assert_true(n.stricter <= trees / 100);
    assert_true(n.bodies > trees / 5 && n.zero > trees / 250);
}

/* Behind a joint of n coordinates errors are multiplied by ||J G^T||^2 at most; of one, by that. */
static void blocks_bound_what_they_transport(void **unused)
{
    (void)unused;
    const mbsri_sweeps tree = {.length = 0.7};
    test_rng rng = test_seed(12);
    for (int k = 0; k < 12; ++k) {
        const int d = k % 2 ? 3 : 6, n = 1 + k / 2 % 3;
        double J[18], G[18], armature[3] = {0.0}, A[36] = {0.0}, lambda[6];
        mbsri_body body[2] = {{.d = 0}};
        body[1].mass.armature = armature;
        const mbsr_model model = {.body = body};
        mbsr_data data = {.J = J, .G = G};
        const mbsri_sweep_run run = {.model = &model, .data = &data, .tree = &tree};
        test_fill(&rng, 18, J);
        test_fill(&rng, 18, G);
        double scale[6], T[36] = {0.0};
        for (int r = 0; r < d; ++r) scale[r] = (d == 6 ? r < 3 : r == 2) ? tree.length : 1.0;
        for (int r = 0; r < d; ++r) {
            for (int c = 0; c < d; ++c) {
                for (int l = 0; l < n; ++l)
                    T[d * c + r] += scale[r] * J[d * l + r] * G[d * l + c] / scale[c];
            }
        }
        mbsri_atb(d, d, d, 1.0, T, T, A);
        assert_int_equal(mbsri_jacobi(d, A, lambda), 0);
        const double bound = transport_of(&run, 1, d, n);
        assert_true(bound >= lambda[0] * (1.0 - 1e-12));
        if (n == 1) assert_close(bound, lambda[0], 1e-12 * bound);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_trees),
        cmocka_unit_test(blocks_bound_what_they_transport),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
