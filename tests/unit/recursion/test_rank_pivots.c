/* The rank of a joint block by pivots against its eigenvalues: of mounts in chains of beams with
 * massless modes, and of blocks made with eigenvalues where pivots must not tell.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "expect.h"

#include "algebra/dense.h"
#include "recursion/data.h"
#include "recursion/group.h"
#include "recursion/rank.h"
#include "recursion/rank_pivots.h"

#include <mbsrank/mbsrank.h>

#include <stdlib.h>

enum { ELEMENTS = 12, MIDDLE = 6, LINKS = 4, MOST = 40 };

typedef struct chain {
    mbsr_flex *beam;
    mbsr_model *model;
    mbsr_data *data;
    int mount[LINKS]; /* indices of the flexible bodies */
} chain;

static int add_link(chain *c, int parent, int k)
{
    static const double axes[2][3] = {{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int body, end;
    def.parent = parent, def.flex = c->beam;
    def.joint = mbsr_joint_revolute(NULL, NULL, axes[k % 2]);
    assert_ok(mbsr_model_add_flexible(c->model, &def, &body), mbsr_model_error(c->model));
    assert_ok(mbsr_model_add_marker(c->model, body, ELEMENTS, NULL, &end),
              mbsr_model_error(c->model));
    c->mount[k] = body;
    return end;
}

/* Stages as far as D and its rank. `loaded`: with the static modes of the middle. */
static void open_chain(chain *c, int modes, int loaded, uint64_t seed)
{
    static const int middle = MIDDLE;
    test_rng rng = test_seed(seed);
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_error error;
    double q[LINKS * MOST], u[LINKS * MOST];
    def.length = 1.0, def.density = 1.3, def.EI_y = 70.0, def.EI_z = 50.0;
    def.elements = ELEMENTS, def.modes = modes, def.loaded = loaded, def.node = &middle;
    assert_ok(mbsr_flex_beam(&def, &c->beam, &error), &error);
    assert_ok(mbsr_model_create(NULL, &c->model, NULL), NULL);
    int end = MBSR_GROUND;
    for (int k = 0; k < LINKS; ++k) end = add_link(c, end, k);
    assert_ok(mbsr_model_finish(c->model), mbsr_model_error(c->model));
    assert_ok(mbsr_data_create(c->model, &c->data, NULL), NULL);
    const int nu = mbsr_model_nu(c->model);
    assert_true(nu <= LINKS * MOST);
    test_fill(&rng, nu, q);
    test_fill(&rng, nu, u);
    for (int k = 0; k < nu; ++k) q[k] *= 0.1;
    const mbsr_error *e = mbsr_data_error(c->data);
    assert_ok(mbsr_stage_positions(c->model, c->data, 0.0, q), e);
    assert_ok(mbsr_stage_velocities(c->model, c->data, u), e);
    assert_ok(mbsr_stage_forces(c->model, c->data, NULL), e);
    assert_ok(mbsr_stage_backward(c->model, c->data), e);
    for (int k = 0; k < LINKS; ++k) {
        int i = 1;
        while (c->model->body[i].id != c->mount[k]) ++i;
        c->mount[k] = i;
    }
}

static void close_chain(chain *c)
{
    mbsr_data_destroy(c->data);
    mbsr_model_destroy(c->model);
    mbsr_flex_destroy(c->beam);
}

/* P (n x n) = S X_dropped X_dropped^T S^-1 */
static void projector(const chain *c, int i, int n, int rank, double *P)
{
    const double *s = c->data->s + c->model->body[i].group.iu,
                 *X = c->data->X + c->model->body[i].nn;
    mbsri_zero((size_t)(n * n), P);
    for (int l = rank; l < n; ++l) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) P[j * n + k] += s[k] * X[l * n + k] * X[l * n + j] / s[j];
        }
    }
}

/* Rank, D^+ and projector as by eigenvalues; X of the range makes D^-. Returns the rank; -1: it is
 * not clear, or not to pivots. */
static int same_by_pivots(chain *c, int i)
{
    const mbsri_body *b = c->model->body + i;
    mbsr_data *d = c->data;
    const mbsri_group g = mbsri_group_of(c->model, d, i);
    const int n = g.n, decision = mbsri_rank_decision(c->model, d, &g, false), rank = d->rank[i];
    static double Dinv[MOST * MOST], P[MOST * MOST], other[MOST * MOST], made[MOST * MOST];
    assert_true(n <= MOST && g.members == 1);
    if (decision == MBSRI_UNCLEAR) {
        assert_false(mbsri_rank_by_pivots(c->model, d, &g));
        return -1;
    }
    assert_int_equal(decision, MBSR_OK);
    mbsri_copy((size_t)(n * n), d->Dinv + b->nn, Dinv);
    projector(c, i, n, rank, P);
    if (!mbsri_rank_by_pivots(c->model, d, &g)) { /* their bound may be lower by n times */
        assert_less(d->judged[b->group.iu + rank - 1], n * MBSRI_NINE_DIGITS);
        return -1;
    }
    assert_int_equal(d->rank[i], rank);
    projector(c, i, n, rank, other);
    for (int k = 0; k < n * n; ++k) {
        const double size = sqrt(Dinv[k / n * (n + 1)] * Dinv[k % n * (n + 1)]);
        assert_close(d->Dinv[b->nn + (size_t)k], Dinv[k], 1e-8 * size + 1e-300);
        assert_close(other[k], P[k], 1e-8);
    }
    /* D (S X X^T S / lambda) D = D */
    const double *s = d->s + b->group.iu, *X = d->X + b->nn, *D = d->D + b->nn;
    mbsri_zero((size_t)(n * n), made);
    for (int l = 0; l < rank; ++l) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k)
                made[j * n + k] +=
                    s[j] * X[l * n + j] * X[l * n + k] * s[k] / d->lambda[b->group.iu + l];
        }
    }
    mbsri_zero((size_t)(n * n), other);
    mbsri_ab(n, n, n, 1.0, made, D, other);
    mbsri_zero((size_t)(n * n), made);
    mbsri_ab(n, n, n, 1.0, D, other, made);
    for (int k = 0; k < n * n; ++k)
        assert_close(made[k], D[k], 1e-9 * sqrt(D[k / n * (n + 1)] * D[k % n * (n + 1)]) + 1e-300);
    return rank;
}

static void pivots_say_what_eigenvalues_say(void **state)
{
    (void)state;
    static const int modes[5] = {2, 3, 4, 8, 24};
    int lacking = 0, full = 0;
    for (int k = 0; k < 10; ++k) {
        chain c;
        const int loaded = k % 2 == 1 && modes[k / 2] < 8;
        open_chain(&c, modes[k / 2], loaded, (uint64_t)k + 1);
        for (int l = LINKS - 1; l >= 0; --l) {
            const int n = c.model->body[c.mount[l]].n, rank = same_by_pivots(&c, c.mount[l]);
            lacking += rank < n && rank > 0;
            full += rank == n;
        }
        close_chain(&c);
    }
    assert_true(lacking >= 8 && full >= 20);
}

/* The block of the first mount gets eigenvalues 1, ..., 1, `small` beside its S, the last vector
 * (1, ..., 1). */
static int decide_with(chain *c, double small, int usual, int *rank)
{
    const int i = c->mount[0];
    mbsri_body *b = c->model->body + i;
    mbsr_data *d = c->data;
    const int n = b->n, kept = b->survey.rank;
    const mbsri_group g = mbsri_group_of(c->model, d, i);
    double noise;
    mbsri_equilibrate(c->model, d, &g, &noise);
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k)
            d->D[b->nn + (size_t)(j * n + k)] =
                ((j == k) - (1.0 - small) / n) / (d->s[b->group.iu + j] * d->s[b->group.iu + k]);
    }
    b->survey.rank = usual + 1;
    const bool told = mbsri_rank_by_pivots(c->model, d, &g);
    *rank = d->rank[i];
    if (told) { /* as eigenvalues say */
        assert_int_equal(mbsri_rank_decision(c->model, d, &g, false), MBSR_OK);
        assert_int_equal(d->rank[i], *rank);
    }
    b->survey.rank = kept;
    return told;
}

static void what_is_not_clear_is_left_to_eigenvalues(void **state)
{
    (void)state;
    chain c;
    int rank;
    open_chain(&c, 5, 0, 3);
    const int n = c.model->body[c.mount[0]].n;
    assert_true(decide_with(&c, 1e-3, n, &rank));
    assert_int_equal(rank, n);
    assert_true(decide_with(&c, 1e-5, n, &rank));
    assert_int_equal(rank, n);
    assert_false(decide_with(&c, 5e-7, n, &rank)); /* not known to nine digits */
    assert_false(decide_with(&c, 1e-9, n - 1, &rank));
    assert_false(decide_with(&c, 3e-12, n - 1, &rank)); /* inertia */
    assert_true(decide_with(&c, 1e-13, n - 1, &rank));  /* none, beside the usual rank */
    assert_int_equal(rank, n - 1);
    assert_false(decide_with(&c, 1e-13, n, &rank)); /* is it usual? */
    assert_false(decide_with(&c, -1e-9, n - 1, &rank));
    assert_false(decide_with(&c, -1.0, n - 1, &rank)); /* indefinite */
    assert_false(decide_with(&c, NAN, n, &rank));
    assert_false(decide_with(&c, INFINITY, n, &rank));
    close_chain(&c);
}

/* Two rings without mass about a rotor are eliminated as one: their ranks are shared out by
 * eigenvectors. */
static void groups_are_left_to_eigenvalues(void **state)
{
    static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const double q[3] = {0.3, 0.7, -0.4}, u[3] = {0.0};
    mbsr_model *m;
    mbsr_data *d;
    (void)state;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int outer = test_add_body(m, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                                    mbsr_inertia_zero()),
              inner =
                  test_add_body(m, outer, mbsr_joint_revolute(NULL, NULL, x), mbsr_inertia_zero());
    (void)test_add_body(m, inner, mbsr_joint_revolute(NULL, NULL, y),
                        mbsr_inertia_box(1.0, (double[3]){1.0, 2.0, 3.0}));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
    const mbsri_group g = mbsri_group_in_model(m, 1);
    assert_int_equal(g.members, 2);
    assert_int_equal(mbsri_group_rank(d, &g), 2);
    assert_false(mbsri_rank_by_pivots(m, d, &g));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pivots_say_what_eigenvalues_say),
        cmocka_unit_test(groups_are_left_to_eigenvalues),
        cmocka_unit_test(what_is_not_clear_is_left_to_eigenvalues),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
