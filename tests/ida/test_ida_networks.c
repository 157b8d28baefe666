/* Random networks of springs, dampers and masses in one line, with nodes without mass between, told
 * by places in the world or by places on each other, springs as forces or as closures, in four
 * systems of units: starts and runs against a Radau method of the matrices.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

void dgesv_(const int *n, const int *nrhs, double *a, const int *lda, int *ipiv, double *b,
            const int *ldb, int *info);

enum { NODES = 5, TIES = 8, STAGES = 3, UNKNOWNS = 2 * STAGES * NODES };

/* Nodes with masses m (kg); ties of stiffness k and damping d (N/m, N s/m) between nodes a and b
 * (-1: ground). */
typedef struct network {
    int nodes, ties, a[TIES], b[TIES], parent[NODES];
    double m[NODES], k[TIES], d[TIES], x[NODES], v[NODES], weight;
    bool loose[TIES];
} network;

static double some(test_rng *rng)
{
    static const double value[] = {0.5, 1.0, 2.0, 5.0, 10.0};
    return value[test_integer(rng, 0, 4)];
}

static void make(network *w, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    *w = (network){.nodes = test_integer(&rng, 2, NODES)};
    for (int i = 0; i < w->nodes; ++i) {
        w->m[i] = test_integer(&rng, 0, 2) && i < w->nodes - 1 ? 0.0 : some(&rng);
        w->parent[i] = test_integer(&rng, 0, 1) ? MBSR_GROUND : i - 1;
        w->x[i] = 0.2 * test_uniform(&rng), w->v[i] = test_uniform(&rng);
    }
    const int more = test_integer(&rng, 0, TIES - NODES);
    for (int i = 0; i < w->nodes + more; ++i) {
        const int e = w->ties, a = i < w->nodes ? i : test_integer(&rng, 0, w->nodes - 1);
        w->a[e] = a, w->b[e] = i < w->nodes ? i - 1 : test_integer(&rng, -1, w->nodes - 1);
        w->k[e] = test_integer(&rng, 0, 3) ? some(&rng) : 0.0;
        w->d[e] = test_integer(&rng, 0, 1) ? some(&rng) : 0.0;
        w->loose[e] = test_integer(&rng, 0, 3) == 0;
        if (w->k[e] + w->d[e] == 0.0) w->k[e] = 1.0;
        w->ties += a != w->b[e];
    }
    w->weight = test_integer(&rng, 0, 1) ? 9.81 : 0.0;
}

/* f - K x - D v at the nodes. */
static void forces(const network *w, const double *x, const double *v, double *f)
{
    for (int i = 0; i < w->nodes; ++i) f[i] = -w->weight * w->m[i];
    for (int e = 0; e < w->ties; ++e) {
        const int a = w->a[e], b = w->b[e];
        const double force =
            w->k[e] * (x[a] - (b < 0 ? 0.0 : x[b])) + w->d[e] * (v[a] - (b < 0 ? 0.0 : v[b]));
        f[a] -= force;
        if (b >= 0) f[b] += force;
    }
}

/* x, v a step later, by Radau IIA of order 5: x' = v, M v' = f. */
static void step(const network *w, double h, double *x, double *v)
{
    const double r = sqrt(6.0);
    const double A[STAGES][STAGES] = {
        {(88.0 - 7.0 * r) / 360.0, (296.0 - 169.0 * r) / 1800.0, (-2.0 + 3.0 * r) / 225.0},
        {(296.0 + 169.0 * r) / 1800.0, (88.0 + 7.0 * r) / 360.0, (-2.0 - 3.0 * r) / 225.0},
        {(16.0 - r) / 36.0, (16.0 + r) / 36.0, 1.0 / 9.0}};
    const int n = w->nodes, N = 2 * STAGES * n, one = 1;
    double J[UNKNOWNS * UNKNOWNS] = {0.0}, slope[UNKNOWNS] = {0.0}, f[NODES], still[NODES];
    const double none[NODES] = {0.0};
    int pivots[UNKNOWNS], info;
    forces(w, x, v, f);
    forces(w, none, none, still);
    for (int i = 0; i < STAGES; ++i) {
        for (int l = 0; l < n; ++l) slope[2 * n * i + l] = v[l], slope[2 * n * i + n + l] = f[l];
    }
    for (int c = 0; c < N; ++c) { /* of unknown c: a slope of x or of v in stage j */
        const int j = c / (2 * n), l = c % n;
        const bool of_v = c % (2 * n) >= n;
        double unit[NODES] = {0.0}, change[NODES];
        unit[l] = 1.0;
        forces(w, of_v ? none : unit, of_v ? unit : none, change);
        J[c * N + c] = of_v ? w->m[l] : 1.0;
        for (int i = 0; i < STAGES; ++i) {
            if (of_v) J[c * N + 2 * n * i + l] -= h * A[i][j];
            for (int k = 0; k < n; ++k)
                J[c * N + 2 * n * i + n + k] -= h * A[i][j] * (change[k] - still[k]);
        }
    }
    dgesv_(&N, &one, J, &N, pivots, slope, &N, &info);
    assert_int_equal(info, 0);
    for (int c = 0; c < N; ++c)
        *(c % (2 * n) < n ? x + c % n : v + c % n) += h * A[STAGES - 1][c / (2 * n)] * slope[c];
}

/* ---- told ---- */

typedef struct model {
    const network *of;
    const units *in;
    int parent[NODES];
    mbsr_model *m;
    mbsr_data *d;
    double y[4 * NODES + 4 * TIES], yp[4 * NODES + 4 * TIES];
} model;

static void add_tie(const model *t, int e, bool relative)
{
    const network *w = t->of;
    const double T = t->in->time, unit = t->in->mass / (T * T), k = w->k[e] * unit,
                 d = w->d[e] * unit * T, stiffness[6] = {[5] = k}, damping[6] = {[5] = d};
    mbsr_force_def force;
    if (t->parent[w->a[e]] == w->b[e]) {
        force = mbsr_force_joint_spring(w->a[e], 0, k, d, 0.0);
        if (relative && w->loose[e] && k > 0.0) force.as_closure = MBSR_SPRING_LOOSE;
    } else {
        force = mbsr_force_bushing(w->b[e], NULL, w->a[e], NULL, stiffness, damping);
    }
    assert_ok(mbsr_model_add_force(t->m, &force, NULL), mbsr_model_error(t->m));
}

static void tell(model *t, const network *w, const units *in, bool relative)
{
    static const double up[3] = {0.0, 0.0, 1.0};
    const double g = w->weight * in->length / (in->time * in->time);
    *t = (model){.of = w, .in = in};
    assert_ok(mbsr_model_create(NULL, &t->m, NULL), NULL);
    for (int i = 0; i < w->nodes; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = t->parent[i] = relative ? w->parent[i] : MBSR_GROUND;
        body.joint = mbsr_joint_prismatic(NULL, NULL, up);
        body.inertia =
            w->m[i] > 0.0 ? mbsr_inertia_particle(w->m[i] * in->mass) : mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(t->m, &body, NULL), mbsr_model_error(t->m));
    }
    for (int e = 0; e < w->ties; ++e) add_tie(t, e, relative);
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -g);
    assert_ok(mbsr_model_add_force(t->m, &gravity, NULL), mbsr_model_error(t->m));
    assert_ok(mbsr_model_finish(t->m), mbsr_model_error(t->m));
    assert_ok(mbsr_data_create(t->m, &t->d, NULL), NULL);
}

/* Places, velocities and accelerations of the nodes, SI. */
static void take(const model *t, double *x, double *v, double *a)
{
    const double L = t->in->length, T = t->in->time;
    const int n = t->of->nodes;
    for (int i = 0; i < n; ++i) {
        const int from = t->parent[i];
        x[i] = t->y[i] / L + (from < 0 ? 0.0 : x[from]);
        v[i] = t->y[2 * n + i] / L * T + (from < 0 ? 0.0 : v[from]);
        a[i] = t->yp[2 * n + i] / L * T * T + (from < 0 ? 0.0 : a[from]);
    }
}

/* M a - f where there is mass; where there is none f, and f' by a. */
static double imbalance(const network *w, const double *x, const double *v, const double *a)
{
    double f[NODES], rate[NODES], still[NODES], off = 0.0;
    const double none[NODES] = {0.0};
    forces(w, x, v, f);
    forces(w, v, a, rate);
    forces(w, none, none, still);
    for (int i = 0; i < w->nodes; ++i) {
        off = fmax(off, fabs(w->m[i] * a[i] - f[i]));
        if (w->m[i] == 0.0) off = fmax(off, 1e-2 * fabs(rate[i] - still[i]));
    }
    return off;
}

static void start(model *t)
{
    const network *w = t->of;
    const double L = t->in->length, T = t->in->time;
    double q[NODES], u[NODES], x[NODES], v[NODES], a[NODES];
    for (int i = 0; i < w->nodes; ++i) {
        const int from = t->parent[i];
        q[i] = (w->x[i] - (from < 0 ? 0.0 : w->x[from])) * L;
        u[i] = (w->v[i] - (from < 0 ? 0.0 : w->v[from])) * L / T;
    }
    assert_ok(mbsr_dae_pack(t->m, t->d, MBSR_DAE_MOMENTUM, 0.0, q, u, t->y), mbsr_data_error(t->d));
    assert_ok(mbsr_dae_consistent(t->m, t->d, MBSR_DAE_MOMENTUM, 0.0, t->y, t->yp, NULL, NULL),
              mbsr_data_error(t->d));
    take(t, x, v, a);
    for (int i = 0; i < w->nodes; ++i) {
        if (w->m[i] == 0.0) continue;
        assert_close(x[i], w->x[i], 1e-8);
        assert_close(v[i], w->v[i], 1e-8);
    }
    assert_true(imbalance(w, x, v, a) < 1e-5);
}

static void run(model *t)
{
    enum { STEPS = 100 };
    const double L = t->in->length, T = t->in->time, tolerance = 1e-8, half = 0.5;
    double x[NODES], v[NODES], a[NODES], found[NODES], rate[NODES];
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida *ida;
    opt.rtol = tolerance, opt.atol_length = tolerance * L, opt.atol_velocity = tolerance * L / T;
    assert_ok(mbsr_ida_create(t->m, t->d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, t->y, t->yp), mbsr_ida_error(ida));
    take(t, x, v, a);
    for (int part = 1; part <= 2; ++part) {
        assert_ok(mbsr_ida_advance(ida, part * half * T, NULL, t->y, t->yp), mbsr_ida_error(ida));
        for (int k = 0; k < STEPS; ++k) step(t->of, half / STEPS, x, v);
        take(t, found, rate, a);
        const double size = 1.0 + test_largest(t->of->nodes, v);
        for (int i = 0; i < t->of->nodes; ++i) {
            assert_close(found[i], x[i], 1e-5 * size);
            assert_close(rate[i], v[i], 1e-4 * size);
        }
        assert_true(imbalance(t->of, found, rate, a) < 1e-4 * size);
    }
    mbsr_ida_destroy(ida);
}

static void networks_move_as_their_matrices(void **state)
{
    (void)state;
    const int seeds = test_long() ? 50 : test_seeds(6, 50);
    for (int seed = 0; seed < seeds; ++seed) {
        network w;
        make(&w, (uint64_t)seed);
        for (int relative = 0; relative < 2; ++relative) {
            model t;
            tell(&t, &w, systems + (seed + relative) % 4, relative);
            start(&t);
            run(&t);
            mbsr_data_destroy(t.d), mbsr_model_destroy(t.m);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(networks_move_as_their_matrices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
