/* Random trees of general bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "tree.h"

#include <stdlib.h>
#include <string.h>

static double dot(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum;
}

/* Gaussian elimination without pivoting: K0 is diagonally dominant. */
static void solve(int n, double *A, double *x)
{
    for (int k = 0; k < n; ++k) {
        for (int i = k + 1; i < n; ++i) {
            const double factor = A[k * n + i] / A[k * n + k];
            for (int j = k; j < n; ++j) A[j * n + i] -= factor * A[j * n + k];
            x[i] -= factor * x[k];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int j = k + 1; j < n; ++j) x[k] -= A[j * n + k] * x[j];
        x[k] /= A[k * n + k];
    }
}

static int position(const mbsr_joint_args *args, double *p)
{
    const test_joint *j = args->user;
    const int d = j->d;
    double known[TEST_MAX_D], K[TEST_MAX_D * TEST_MAX_D], step[TEST_MAX_D];
    const double bend_pred = j->a * sin(dot(j->d_pred, j->w, args->p_pred)),
                 bend_q = j->a * sin(dot(j->n, j->v, args->q));
    for (int r = 0; r < d; ++r) {
        known[r] = j->c[r] * sin(args->t) + j->h[r] * bend_pred + j->g[r] * bend_q;
        for (int s = 0; s < j->d_pred; ++s) known[r] += j->H0[s * d + r] * args->p_pred[s];
        for (int s = 0; s < j->n; ++s) known[r] += j->J0[s * d + r] * args->q[s];
        p[r] = 0.0;
    }
    for (int iteration = 0; iteration < 100; ++iteration) {
        memcpy(K, j->K0, sizeof(double) * (size_t)(d * d));
        for (int r = 0; r < d; ++r) {
            step[r] = known[r] + j->a * sin(p[r]);
            for (int s = 0; s < d; ++s) step[r] += j->K0[s * d + r] * p[s];
            K[r * d + r] += j->a * cos(p[r]);
        }
        solve(d, K, step);
        for (int r = 0; r < d; ++r) p[r] -= step[r];
        if (test_largest(d, step) < 1e-15 * (1.0 + test_largest(d, p))) break;
    }
    return 0;
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    const test_joint *j = args->user;
    const int d = j->d;
    const double bend_pred = j->a * cos(dot(j->d_pred, j->w, args->p_pred)),
                 bend_q = j->a * cos(dot(j->n, j->v, args->q));
    for (int r = 0; r < d; ++r) {
        for (int s = 0; s < d; ++s) K[s * d + r] = j->K0[s * d + r];
        K[r * d + r] += j->a * cos(args->p[r]);
        for (int s = 0; s < j->d_pred; ++s)
            H[s * d + r] = j->H0[s * d + r] + bend_pred * j->h[r] * j->w[s];
        for (int s = 0; s < j->n; ++s) J[s * d + r] = j->J0[s * d + r] + bend_q * j->g[r] * j->v[s];
        kI[r] = j->c[r] * cos(args->t);
    }
    return 0;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    const test_joint *j = args->user;
    const double w = dot(j->d_pred, j->w, args->V_pred), v = dot(j->n, j->v, args->u);
    const double pred = -j->a * sin(dot(j->d_pred, j->w, args->p_pred)) * w * w;
    const double own = -j->a * sin(dot(j->n, j->v, args->q)) * v * v;
    for (int r = 0; r < j->d; ++r) {
        kII[r] = -j->a * sin(args->p[r]) * args->V[r] * args->V[r] + j->h[r] * pred +
                 j->g[r] * own - j->c[r] * sin(args->t);
    }
    return 0;
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    const test_joint *j = args->user;
    const int d = j->d;
    const double pred =
        -j->a * sin(dot(j->d_pred, j->w, args->p_pred)) * dot(j->d_pred, j->w, args->V_pred);
    const double own = -j->a * sin(dot(j->n, j->v, args->q)) * dot(j->n, j->v, args->u);
    for (int r = 0; r < d; ++r) {
        Kdot[r * d + r] = -j->a * sin(args->p[r]) * args->V[r];
        for (int s = 0; s < j->d_pred; ++s) Hdot[s * d + r] = pred * j->h[r] * j->w[s];
        for (int s = 0; s < j->n; ++s) Jdot[s * d + r] = own * j->g[r] * j->v[s];
    }
    return 0;
}

/* K dp = -(H dp_pi + J dq) */
static int tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp, double *dK,
                   double *dH, double *dJ, double *dkI)
{
    const test_joint *j = args->user;
    const int d = j->d;
    double K[TEST_MAX_D * TEST_MAX_D] = {0.0}, H[TEST_MAX_D * TEST_MAX_D],
                          J[TEST_MAX_D * TEST_MAX_D], kI[TEST_MAX_D];
    const double pred = -j->a * sin(dot(j->d_pred, j->w, args->p_pred)) *
                        dot(j->d_pred, j->w, by->p_pred),
                 own = -j->a * sin(dot(j->n, j->v, args->q)) * dot(j->n, j->v, by->q);
    (void)dkI;
    (void)jacobians(args, K, H, J, kI);
    for (int r = 0; r < d; ++r) {
        for (int s = 0; s < j->d_pred; ++s) {
            dp[r] -= H[s * d + r] * by->p_pred[s];
            dH[s * d + r] = pred * j->h[r] * j->w[s];
        }
        for (int s = 0; s < j->n; ++s) {
            dp[r] -= J[s * d + r] * by->q[s];
            dJ[s * d + r] = own * j->g[r] * j->v[s];
        }
    }
    solve(d, K, dp);
    for (int r = 0; r < d; ++r) dK[r * d + r] = -j->a * sin(args->p[r]) * dp[r];
    return 0;
}

static int rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                        double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    const test_joint *j = args->user;
    const int d = j->d;
    /* -a sin(x) v^2 and -a sin(x) v of x = w . p_pi and x = v . q, and their derivatives */
    const double x[2] = {dot(j->d_pred, j->w, args->p_pred), dot(j->n, j->v, args->q)},
                 v[2] = {dot(j->d_pred, j->w, args->V_pred), dot(j->n, j->v, args->u)},
                 dx[2] = {dot(j->d_pred, j->w, by->p_pred), dot(j->n, j->v, by->q)},
                 dv[2] = {dot(j->d_pred, j->w, by->V_pred), dot(j->n, j->v, by->u)};
    double rate[2], second[2];
    (void)dqdot;
    for (int k = 0; k < 2; ++k) {
        rate[k] = -j->a * (cos(x[k]) * dx[k] * v[k] + sin(x[k]) * dv[k]);
        second[k] = -j->a * (cos(x[k]) * dx[k] * v[k] * v[k] + 2.0 * sin(x[k]) * v[k] * dv[k]);
    }
    for (int r = 0; r < d; ++r) {
        const double p = args->p[r], V = args->V[r];
        dKdot[r * d + r] = -j->a * (cos(p) * by->p[r] * V + sin(p) * by->V[r]);
        dkII[r] = -j->a * (cos(p) * by->p[r] * V * V + 2.0 * sin(p) * V * by->V[r]) +
                  j->h[r] * second[0] + j->g[r] * second[1];
        for (int s = 0; s < j->d_pred; ++s) dHdot[s * d + r] = rate[0] * j->h[r] * j->w[s];
        for (int s = 0; s < j->n; ++s) dJdot[s * d + r] = rate[1] * j->g[r] * j->v[s];
    }
    return 0;
}

const mbsr_joint_table test_joint_table = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .name = "test",
    .position = position,
    .jacobians = jacobians,
    .bias = bias,
    .rates = rates,
};

const mbsr_joint_table test_joint_tangents = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .name = "test with derivatives",
    .position = position,
    .jacobians = jacobians,
    .bias = bias,
    .rates = rates,
    .tangent = tangent,
    .rate_tangent = rate_tangent,
};

const mbsr_joint_table test_joint_bare = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .name = "test without rates",
    .position = position,
    .jacobians = jacobians,
    .bias = bias,
};

static int root_motion(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    p[0] = sin(t), V[0] = cos(t), A[0] = -sin(t);
    p[1] = 0.5 * t * t, V[1] = t, A[1] = 1.0;
    return 0;
}

/* A spring-damper between two bodies of any dimension: e = a . p_a - b . p_b with a = b = (1, ...,
 * 1). */
static int link_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    double e = 0.0, rate = 0.0;
    for (int b = 0; b < 2; ++b) {
        for (int k = 0; k < body[b].d; ++k) {
            e += (b ? -1.0 : 1.0) * body[b].p[k];
            rate += (b ? -1.0 : 1.0) * body[b].V[k];
        }
    }
    const double force = -args->force->param[0] * e - args->force->param[1] * rate;
    for (int b = 0; b < 2; ++b) {
        for (int k = 0; k < body[b].d; ++k) body[b].f[k] += (b ? -1.0 : 1.0) * force;
    }
    return 0;
}

static const mbsr_force_table link_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "test link", .evaluate = link_evaluate};

static void make_joint(test_joint *j, test_rng *rng, const test_tree_opt *opt, int d, int n,
                       int d_pred)
{
    j->d = d;
    j->n = n;
    j->d_pred = d_pred;
    j->a = opt->bend;
    test_fill(rng, d * d, j->K0);
    for (int k = 0; k < d * d; ++k) j->K0[k] *= 0.5 / d;
    for (int k = 0; k < d; ++k) j->K0[k * d + k] += 1.0 + 0.2 * test_uniform(rng);
    test_fill(rng, d * d_pred, j->H0);
    test_fill(rng, d * n, j->J0);
    test_rng other = *rng; /* all else stays as it is */
    for (int c = 0; c < n && opt->units; ++c) {
        const double unit = pow(10.0, 6.0 * test_uniform(&other));
        for (int r = 0; r < d; ++r) j->J0[c * d + r] *= unit;
    }
    test_fill(rng, TEST_MAX_D, j->h);
    test_fill(rng, TEST_MAX_D, j->w);
    test_fill(rng, TEST_MAX_D, j->g);
    test_fill(rng, TEST_MAX_D, j->v);
    test_fill(rng, TEST_MAX_D, j->c);
}

/* M = B B^T with B d x rank. */
static void make_mass(double *M, test_rng *rng, int d, int rank)
{
    double B[TEST_MAX_D * TEST_MAX_D];
    test_fill(rng, d * rank, B);
    memset(M, 0, sizeof(double) * (size_t)(d * d));
    for (int l = 0; l < rank; ++l) {
        for (int r = 0; r < d; ++r) {
            for (int s = 0; s < d; ++s) M[s * d + r] += B[l * d + r] * B[l * d + s];
        }
    }
}

static void add_forces(test_tree *tree, test_rng *rng, const int *id)
{
    for (int k = 0; k < tree->N; ++k) {
        int ends[2] = {id[test_integer(rng, 0, tree->N - 1)], id[k]};
        mbsr_force_def link = mbsr_force_custom(&link_table, 2, ends, NULL);
        link.param[0] = 1.0 + test_uniform(rng);
        link.param[1] = 1.0 + test_uniform(rng);
        if (ends[0] != ends[1]) assert_int_equal(mbsr_model_add_force(tree->model, &link, NULL), 0);
        for (int c = 0; c < tree->joint[id[k]].n; ++c) {
            const mbsr_force_def spring = mbsr_force_joint_spring(
                id[k], c, 2.0 + test_uniform(rng), 2.0 + test_uniform(rng), test_uniform(rng));
            assert_int_equal(mbsr_model_add_force(tree->model, &spring, NULL), 0);
        }
    }
}

void test_tree_make(test_tree *tree, test_tree_opt opt)
{
    test_rng rng = test_seed(opt.seed), order = test_seed(opt.seed + 77);
    const int N = opt.bodies;
    *tree = (test_tree){.opt = opt, .N = N, .root_d = opt.moving_root ? 2 : 0};
    mbsr_model_def def = mbsr_default_model_def();
    if (opt.moving_root) def.root = mbsr_root_moving(MBSR_SPACE_GENERAL, 2, 2, root_motion, NULL);
    assert_int_equal(mbsr_model_create(&def, &tree->model, NULL), 0);
    tree->parent = calloc((size_t)N, sizeof(int));
    tree->label = calloc((size_t)N, sizeof(int));
    tree->joint = calloc((size_t)N, sizeof(test_joint));
    tree->mass = calloc((size_t)N, sizeof(double *));

    /* id[k]: the id of the k-th body of the original order */
    int *id = calloc((size_t)N, sizeof(int));
    for (int k = 0; k < N; ++k) id[k] = k;
    for (int k = N - 1; opt.shuffle && k > 0; --k) {
        const int other = test_integer(&order, 0, k), held = id[k];
        id[k] = id[other];
        id[other] = held;
    }
    for (int k = 0; k < N; ++k) {
        const int me = id[k], at = test_integer(&rng, -1, k - 1);
        const int d = test_integer(&rng, 1, opt.max_d),
                  n = test_integer(&rng, opt.welds ? 0 : 1, d);
        const int rank =
            test_uniform(&rng) < 2.0 * opt.deficient - 1.0 ? test_integer(&rng, 0, d - 1) : d;
        tree->label[me] = k;
        tree->parent[me] = at < 0 ? MBSR_GROUND : id[at];
        make_joint(tree->joint + me, &rng, &opt, d, n,
                   at < 0 ? tree->root_d : tree->joint[id[at]].d);
        tree->mass[me] = calloc((size_t)(d * d), sizeof(double));
        make_mass(tree->mass[me], &rng, d, rank);
        tree->nu += n;
    }
    static const mbsr_joint_table *const tables[] = {&test_joint_table, &test_joint_tangents,
                                                     &test_joint_bare};
    for (int me = 0; me < N; ++me) {
        mbsr_body_def body = mbsr_default_body_def();
        const mbsr_joint_table *table = tables[opt.tables ? (opt.seed + (uint64_t)me) % 3 : 0];
        body.parent = tree->parent[me];
        body.joint =
            mbsr_joint_custom(table, tree->joint[me].d, tree->joint[me].n, tree->joint + me);
        body.inertia = mbsr_inertia_matrix(tree->joint[me].d, tree->mass[me]);
        assert_int_equal(mbsr_model_add_body(tree->model, &body, NULL), 0);
    }
    if (opt.forces) add_forces(tree, &rng, id);
    free(id);
    assert_int_equal(mbsr_model_finish(tree->model), 0);
    assert_int_equal(mbsr_data_create(tree->model, &tree->data, NULL), 0);
    assert_int_equal(mbsr_model_nu(tree->model), tree->nu);
}

void test_tree_free(test_tree *tree)
{
    mbsr_data_destroy(tree->data);
    mbsr_model_destroy(tree->model);
    for (int k = 0; k < tree->N; ++k) free(tree->mass[k]);
    free(tree->mass);
    free(tree->joint);
    free(tree->label);
    free(tree->parent);
}
