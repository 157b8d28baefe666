/* Joint blocks of flexible bodies in factors (Woodbury's formula) against the same blocks in one
 * piece, against the mass matrix that body Jacobians make, and against inverse dynamics: bodies of
 * random particles and shapes, some massless, with light and heavy loads on none to three markers.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "flexible.h"

#include "algebra/lapack.h"
#include "model/record.h"
#include "recursion/data.h"

#include <stdlib.h>
#include <string.h>

enum { PARTICLES = 40, MARKERS = 4, MOST_MODES = 40, MOST_LINKS = 3, MOST_NU = 150 };

/* What is varied. */
typedef struct tree_kind {
    int links, modes, massless;
    int carrying;  /* markers with a load, the last of them with the next link */
    double load;   /* kg, beside 1 kg of a link */
    bool rotation; /* of markers with the modes */
    bool joint;    /* loads are on hinges */
    bool driven;   /* the first joint has a prescribed axis */
    bool diagonal; /* modal masses */
} tree_kind;

typedef struct tree {
    mbsr_flex *flex;
    mbsr_model *model;
    mbsr_data *data;
    int nu;
    double q[MOST_NU], u[MOST_NU];
} tree;

/* ---- a body ---- */

/* Displacements of a particle by all modes (3 x n); those of equal masses are orthonormal where
 * `diagonal`. */
static void fill_shapes(const tree_kind *k, test_rng *rng, double *Phi)
{
    const int n = k->modes, rows = 3 * PARTICLES;
    for (int a = 0; a < n; ++a) {
        double *x = Phi + rows * a;
        test_fill(rng, rows, x);
        for (int turn = 0; turn < 2 && k->diagonal; ++turn) {
            for (int b = 0; b < a; ++b) {
                double part = 0.0, square = 0.0;
                for (int l = 0; l < rows; ++l) {
                    part += x[l] * Phi[rows * b + l];
                    square += Phi[rows * b + l] * Phi[rows * b + l];
                }
                for (int l = 0; l < rows; ++l) x[l] -= part / square * Phi[rows * b + l];
            }
        }
    }
}

static mbsr_flex *random_body(const tree_kind *k, test_rng *rng)
{
    const int n = k->modes, rows = 3 * n;
    const size_t size = (size_t)n;
    double *Phi = calloc(3 * PARTICLES * size, sizeof *Phi),
           *P = calloc(9 * size * size, sizeof *P), *P0 = calloc(9 * size, sizeof *P0),
           *Ct0 = calloc(3 * size, sizeof *Ct0), *K = calloc(size * size, sizeof *K),
           *D = calloc(size * size, sizeof *D), *at = calloc(6 * size * MARKERS, sizeof *at),
           x[3 * PARTICLES];
    mbsr_flex_marker marker[MARKERS];
    mbsr_flex_def def = mbsr_default_flex_def();
    mbsr_flex *flex;
    mbsr_error error;
    fill_shapes(k, rng, Phi);
    test_fill(rng, 3 * PARTICLES, x);
    test_fill(rng, 6 * n * MARKERS, at);
    for (int p = 0; p < PARTICLES; ++p) {
        const double mass = 1.0 / PARTICLES, *y = x + 3 * p;
        def.mass += mass;
        for (int j = 0; j < 3; ++j) {
            def.c0[j] += mass * y[j];
            for (int i = 0; i < 3; ++i) def.N0[3 * j + i] += mass * y[i] * y[j];
        }
        for (int b = k->massless; b < n; ++b) {
            const double *shape = Phi + 3 * PARTICLES * b + 3 * p;
            for (int j = 0; j < 3; ++j) {
                Ct0[3 * b + j] += mass * shape[j];
                for (int i = 0; i < 3; ++i) P0[9 * b + 3 * j + i] += mass * y[i] * shape[j];
            }
            for (int a = k->massless; a < n; ++a) {
                const double *other = Phi + 3 * PARTICLES * a + 3 * p;
                for (int j = 0; j < 3; ++j) {
                    for (int i = 0; i < 3; ++i)
                        P[rows * (3 * b + j) + 3 * a + i] += mass * other[i] * shape[j];
                }
            }
        }
    }
    for (int a = 0; a < n; ++a) K[a * (n + 1)] = 100.0 + a, D[a * (n + 1)] = 0.1;
    for (int l = 0; l < MARKERS; ++l) {
        marker[l] = (mbsr_flex_marker){.frame = mbsr_frame_identity()};
        for (int j = 0; j < 3 && l > 0; ++j) marker[l].frame.x[j] = x[3 * l + j];
        if (l == 0) continue;
        marker[l].Phi = at + 6 * n * l;
        if (k->rotation) marker[l].Psi = at + 6 * n * l + 3 * n;
    }
    def.modes = n, def.Ct0 = Ct0, def.P0 = P0, def.P = P, def.K = K, def.D = D;
    def.markers = MARKERS, def.marker = marker;
    assert_ok(mbsr_flex_create(&def, &flex, &error), &error);
    free(Phi), free(P), free(P0), free(Ct0), free(K), free(D), free(at);
    return flex;
}

/* ---- a tree ---- */

static int turning(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    s[0] = 0.3 * sin(t), sdot[0] = 0.3 * cos(t), sddot[0] = -0.3 * sin(t);
    return MBSR_OK;
}

static mbsr_joint first_joint(const tree_kind *k)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    if (!k->driven) return mbsr_joint_revolute(NULL, NULL, z);
    const mbsr_axis axis[2] = {
        {.kind = MBSR_AXIS_ROTATION, .direction = {1.0, 0.0, 0.0}, .driven = 1},
        {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}}};
    return mbsr_joint_compound(NULL, NULL, 2, axis, turning, NULL);
}

/* A rigid body of k->load times the share on a marker. */
static void add_load(tree *w, const tree_kind *k, int marker, double share)
{
    static const double axis[3] = {0.0, 0.6, 0.8}, com[3] = {0.1, -0.2, 0.05},
                        tensor[6] = {0.02, 0.03, 0.04, 0.001, -0.002, 0.003};
    const double mass = k->load * share;
    double moments[6];
    mbsr_body_def def = mbsr_default_body_def();
    for (int l = 0; l < 6; ++l) moments[l] = mass * tensor[l];
    def.parent = marker;
    def.joint = k->joint ? mbsr_joint_revolute(NULL, NULL, axis) : mbsr_joint_weld(NULL, NULL);
    def.inertia = mbsr_inertia_rigid(mass, com, moments);
    assert_ok(mbsr_model_add_body(w->model, &def, NULL), mbsr_model_error(w->model));
}

static int add_link(tree *w, const tree_kind *k, int parent, int last)
{
    static const double y[3] = {0.0, 1.0, 0.0};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int body, marker = MBSR_GROUND;
    def.parent = parent, def.flex = w->flex;
    def.joint = parent == MBSR_GROUND ? first_joint(k) : mbsr_joint_revolute(NULL, NULL, y);
    assert_ok(mbsr_model_add_flexible(w->model, &def, &body), mbsr_model_error(w->model));
    for (int l = 1; l < MARKERS; ++l) {
        assert_ok(mbsr_model_add_marker(w->model, body, l, NULL, &marker),
                  mbsr_model_error(w->model));
        if (l <= k->carrying && (last || l < MARKERS - 1)) add_load(w, k, marker, 1.0 / l);
    }
    return marker;
}

static void open_tree(tree *w, const tree_kind *k, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, -9.81, 1.0);
    memset(w, 0, sizeof *w);
    w->flex = random_body(k, &rng);
    assert_ok(mbsr_model_create(NULL, &w->model, NULL), NULL);
    int end = MBSR_GROUND;
    for (int l = 0; l < k->links; ++l) end = add_link(w, k, end, l == k->links - 1);
    assert_ok(mbsr_model_add_force(w->model, &gravity, NULL), mbsr_model_error(w->model));
    assert_ok(mbsr_model_finish(w->model), mbsr_model_error(w->model));
    assert_ok(mbsr_data_create(w->model, &w->data, NULL), NULL);
    w->nu = mbsr_model_nu(w->model);
    assert_true(w->nu <= MOST_NU);
    test_fill(&rng, w->nu, w->q);
    test_fill(&rng, w->nu, w->u);
    for (int l = 0; l < w->nu; ++l) w->q[l] *= 0.05;
}

static void close_tree(tree *w)
{
    mbsr_data_destroy(w->data);
    mbsr_model_destroy(w->model);
    mbsr_flex_destroy(w->flex);
}

static const mbsr_error *error_of(const tree *w)
{
    return mbsr_data_error(w->data);
}

static void take_factors_away(tree *w)
{
    for (int i = 1; i <= w->model->bodies; ++i) w->model->body[i].flexible.factored = false;
}

/* Bodies that had their blocks in factors in the last evaluation, where the sweeps served it to its
 * end. */
static int in_factors(const tree *w)
{
    int count = 0;
    if (w->data->pending != MBSRI_PENDING_FORWARD) return 0;
    for (int i = 1; i <= w->model->bodies; ++i)
        count += w->model->body[i].flexible.factored && w->data->factors.rows[i] >= 0;
    return count;
}

/* ---- what is compared ---- */

static double largest(int n, const double *x)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k]));
    return most;
}

/* sqrt(dx^T M dx / x^T M x) of accelerations: the mass matrix (nu x nu) counts each as what it
 * moves. */
static double distance(const tree *w, const double *mass, const double *x, const double *y)
{
    double off = 0.0, size = 0.0;
    for (int j = 0; j < w->nu; ++j) {
        for (int k = 0; k < w->nu; ++k) {
            const double entry = mass[j * w->nu + k];
            off += (x[j] - y[j]) * entry * (x[k] - y[k]);
            size += x[j] * entry * x[k];
        }
    }
    return sqrt(fmax(off, 0.0) / size);
}

/* Largest joint force that accelerations leave, beside what is added up in its equation. */
static double imbalance(const tree *w, const double *mass, const double *udot)
{
    const double none[MOST_NU] = {0.0};
    double rest[MOST_NU], bias[MOST_NU], worst = 0.0;
    assert_ok(mbsr_inverse_dynamics(w->model, w->data, 0.7, w->q, w->u, udot, NULL, rest),
              error_of(w));
    assert_ok(mbsr_inverse_dynamics(w->model, w->data, 0.7, w->q, w->u, none, NULL, bias),
              error_of(w));
    for (int j = 0; j < w->nu; ++j) {
        double sum = fabs(bias[j]);
        for (int k = 0; k < w->nu; ++k) sum += fabs(mass[k * w->nu + j] * udot[k]);
        worst = fmax(worst, fabs(rest[j]) / sum);
    }
    return worst;
}

static int ranks(const tree *w, int *rank)
{
    int lacking = 0;
    for (int id = 0; id < mbsr_model_bodies(w->model); ++id) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(w->model, w->data, id, &info), error_of(w));
        rank[id] = info.rank;
        lacking += info.n - info.rank;
    }
    return lacking;
}

/* The number of bodies in factors. Accelerations, ranks and residuals are the same with and
 * without. */
static int compare(const tree_kind *kind, uint64_t seed)
{
    tree w;
    open_tree(&w, kind, seed);
    const int n = w.nu, bodies = mbsr_model_bodies(w.model);
    const size_t size = (size_t)n * (size_t)n;
    double udot[MOST_NU], whole[MOST_NU], y[3 * MOST_NU], yp[3 * MOST_NU], F[3 * MOST_NU],
        F_whole[3 * MOST_NU], *mass = calloc(size, sizeof *mass);
    double error;
    int rank[64], rank_whole[64];
    test_rng rng = test_seed(seed + 100);
    assert_true(bodies <= 64);
    const int status = mbsr_forward_dynamics(w.model, w.data, 0.7, w.q, w.u, NULL, udot);
    const int count = in_factors(&w), lacking = ranks(&w, rank);
    test_fill(&rng, 3 * n, yp);
    assert_ok(mbsr_dae_pack(w.model, w.data, MBSR_DAE_MOMENTUM, 0.7, w.q, w.u, y), error_of(&w));
    assert_ok(mbsr_dae_residual(w.model, w.data, MBSR_DAE_MOMENTUM, 0.7, y, yp, F), error_of(&w));
    take_factors_away(&w);
    assert_int_equal(mbsr_forward_dynamics(w.model, w.data, 0.7, w.q, w.u, NULL, whole), status);
    assert_int_equal(ranks(&w, rank_whole), lacking);
    assert_int_equal(status, lacking > 0 ? MBSR_UNDETERMINED : MBSR_OK);
    assert_memory_equal(rank, rank_whole, (size_t)bodies * sizeof *rank);
    assert_ok(mbsr_dae_residual(w.model, w.data, MBSR_DAE_MOMENTUM, 0.7, y, yp, F_whole),
              error_of(&w));
    assert_ok(mbsr_stage_positions(w.model, w.data, 0.7, w.q), error_of(&w));
    assert_ok(mbsr_mass_matrix(w.model, w.data, mass), error_of(&w));
    /* a block in one piece has fewer digits itself where loads are heavy */
    if (lacking == 0 && count > 0)
        assert_ok(mbsr_forward_dynamics_refined(w.model, w.data, 0.7, w.q, w.u, NULL, whole, NULL,
                                                &error),
                  error_of(&w));
    assert_less(distance(&w, mass, whole, udot), 1e-9);
    if (lacking == 0) assert_less(imbalance(&w, mass, udot), 1e-10);
    for (int k = 0; k < 3 * n; ++k)
        assert_less(fabs(F[k] - F_whole[k]), 1e-11 * largest(3 * n, F_whole));
    free(mass);
    close_tree(&w);
    return count;
}

/* ---- tests ---- */

static void factors_and_blocks_agree(void **state)
{
    (void)state;
    static const double load[] = {1.0, 1e-4, 30.0, 1e3, 1e4, 0.0};
    static const int modes[] = {12, 17, 40, 24}, massless[] = {0, 2, 0, 5, 1, 8};
    const int cases = test_long() ? 480 : 32;
    int count = 0, bodies = 0;
    for (int l = 0; l < cases; ++l) {
        const tree_kind kind = {.links = 1 + l % MOST_LINKS,
                                .modes = modes[l % 4],
                                .massless = massless[l / 2 % 6],
                                .carrying = l / 3 % MARKERS,
                                .load = load[l / 4 % 6],
                                .rotation = l % 5 > 1,
                                .joint = l % 7 > 2,
                                .driven = l % 8 == 7,
                                .diagonal = l % 3 == 0};
        count += compare(&kind, (uint64_t)l + 1);
        bodies += kind.links;
    }
    print_message("%d of %d blocks in factors\n", count, bodies);
    assert_true(2 * count > bodies);
}

/* Heavy loads: what Woodbury's formula loses when it subtracts from Mf^-1, and D by having both in
 * one sum. */
static void heavy_loads_lose_no_digits(void **state)
{
    (void)state;
    for (int l = 0; l < 8; ++l) {
        tree w;
        const tree_kind kind = {.links = 1,
                                .modes = 40,
                                .carrying = 1 + l % 3,
                                .rotation = true,
                                .load = (double[4]){10.0, 1e2, 1e3, 1e4}[l / 2]};
        double udot[MOST_NU], exact[MOST_NU], mass[64 * 64], error;
        open_tree(&w, &kind, (uint64_t)l + 7);
        assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.7, w.q, w.u, NULL, udot), error_of(&w));
        assert_int_equal(in_factors(&w), 1);
        assert_ok(mbsr_forward_dynamics_refined(w.model, w.data, 0.7, w.q, w.u, NULL, exact, NULL,
                                                &error),
                  error_of(&w));
        assert_true(w.nu <= 64);
        assert_ok(mbsr_stage_positions(w.model, w.data, 0.7, w.q), error_of(&w));
        assert_ok(mbsr_mass_matrix(w.model, w.data, mass), error_of(&w));
        const double off = distance(&w, mass, exact, udot);
        print_message("load %g: %.1e\n", kind.load, off);
        assert_less(off, 1e-12);
        close_tree(&w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factors_and_blocks_agree),
        cmocka_unit_test(heavy_loads_lose_no_digits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
