/* The index-1 form: bases that follow the state, their rates, eta' and zeta' against differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "tree.h"

#include "forms/bases.h"
#include "assembly/data.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

#define TREES (test_long() ? 150 : test_seeds_short(48, 72))
enum { MOST = 160 };

static const double start_time = 0.3;

/* A random tree with forces in a consistent state. */
typedef struct state {
    test_tree tree;
    int nq, nu;
    double q[MOST], u[MOST], qdot[MOST], udot[MOST];
    double v[2 * MOST], vdot[2 * MOST]; /* y, y' of the index-1 form */
    double kept;                        /* smallest scaled eigenvalue kept: amplifies errors */
} state;

static void setup(state *s, int seed)
{
    const test_tree_opt opt = {.seed = (uint64_t)seed,
                               .bodies = 2 + seed % 8,
                               .max_d = 5,
                               .welds = 1,
                               .deficient = 0.6,
                               .bend = 0.1,
                               .forces = 1,
                               .moving_root = seed % 3 == 0,
                               .shuffle = seed % 2};
    test_tree_make(&s->tree, opt);
    s->nq = s->nu = s->tree.nu;
    assert_true(s->nu <= MOST);
    test_rng rng = test_seed((uint64_t)seed + 4000);
    double y[2 * MOST], yp[2 * MOST];
    test_fill(&rng, 2 * s->nu, y);
    assert_int_equal(mbsr_dae_consistent(s->tree.model, s->tree.data, MBSR_DAE_RECURSIVE,
                                         start_time, y, yp, NULL, NULL),
                     MBSR_OK);
    memcpy(s->q, y, sizeof(double) * (size_t)s->nq);
    memcpy(s->u, y + s->nq, sizeof(double) * (size_t)s->nu);
    memcpy(s->qdot, yp, sizeof(double) * (size_t)s->nq);
    memcpy(s->udot, yp + s->nq, sizeof(double) * (size_t)s->nu);
    s->kept = 1.0;
    for (int i = 0; i < s->tree.N; ++i) {
        mbsr_rank_info info;
        assert_int_equal(mbsr_body_rank(s->tree.model, s->tree.data, i, &info), MBSR_OK);
        if (info.rank > 0) s->kept = fmin(s->kept, info.smallest_kept);
    }
}

/* q, u a little later along the motion, packed. */
static void pack_after(state *s, double h, double *y)
{
    double q[MOST], u[MOST];
    for (int k = 0; k < s->nq; ++k) q[k] = s->q[k] + h * s->qdot[k] + 0.5 * h * h * s->udot[k];
    for (int k = 0; k < s->nu; ++k) u[k] = s->u[k] + h * s->udot[k];
    assert_int_equal(
        mbsr_dae_pack(s->tree.model, s->tree.data, MBSR_DAE_INDEX1, start_time + h, q, u, y),
        MBSR_OK);
}

/* y' from the library's start, after the reference was taken a little away, so that bases are
 * turned. */
static void start(state *s)
{
    mbsr_data *d = s->tree.data;
    assert_int_equal(mbsr_index1_reset(s->tree.model, d), MBSR_OK);
    double away[2 * MOST];
    test_rng rng = test_seed(99);
    for (int k = 0; k < s->nq; ++k) away[k] = s->q[k] + 0.2 * test_uniform(&rng);
    assert_int_equal(mbsri_frame_renew(s->tree.model, d, start_time, away, s->u), MBSR_OK);
    pack_after(s, 0.0, s->v);
    assert_int_equal(mbsr_dae_consistent(s->tree.model, d, MBSR_DAE_INDEX1, start_time, s->v,
                                         s->vdot, NULL, NULL),
                     MBSR_OK);
}

static void eta_and_zeta_move_as_the_equations_say(void **unused)
{
    (void)unused;
    int deficient = 0, well = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, seed);
        if (s.kept > 1e-3) { /* differences are no judge of worse conditioned ones */
            start(&s);
            double ahead[2 * MOST], behind[2 * MOST];
            const double speed = 1.0 + test_largest(s.nq, s.qdot) + test_largest(s.nu, s.udot);
            const double h = 2e-5 / speed;
            pack_after(&s, h, ahead);
            pack_after(&s, -h, behind);
            const double size = 1.0 + test_largest(2 * s.nu, s.vdot) + speed;
            for (int k = 0; k < s.nq + s.nu; ++k) {
                assert_close(s.vdot[k], (ahead[k] - behind[k]) / (2.0 * h), 1e-8 * size / s.kept);
            }
            deficient += mbsr_total_rank(s.tree.model, s.tree.data) < s.nu;
            ++well;
        }
        test_tree_free(&s.tree);
    }
    assert_true(deficient > TREES / 3);
    assert_true(well > TREES / 2);
}

static void velocities_come_back(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, seed);
        start(&s);
        double q[MOST], u[MOST];
        mbsri_data_poison(s.tree.data);
        /* the reference is not workspace */
        assert_int_equal(mbsr_index1_reset(s.tree.model, s.tree.data), MBSR_OK);
        start(&s);
        assert_int_equal(
            mbsr_dae_unpack(s.tree.model, s.tree.data, MBSR_DAE_INDEX1, start_time, s.v, q, u),
            MBSR_OK);
        for (int k = 0; k < s.nq; ++k) assert_close(q[k], s.q[k], 0.0);
        for (int k = 0; k < s.nu; ++k) {
            assert_close(u[k], s.u[k], 1e-12 * (1.0 + test_largest(s.nu, s.u)) / s.kept);
        }
        test_tree_free(&s.tree);
    }
}

static void the_residual_vanishes_with_the_other_forms(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, seed);
        start(&s);
        double F[2 * MOST];
        assert_int_equal(mbsr_dae_residual(s.tree.model, s.tree.data, MBSR_DAE_INDEX1, start_time,
                                           s.v, s.vdot, F),
                         MBSR_OK);
        const double size = 1.0 + test_largest(2 * s.nu, s.vdot);
        for (int k = 0; k < s.nq + s.nu; ++k) assert_close(F[k], 0.0, 1e-9 * size);
        test_tree_free(&s.tree);
    }
}

enum { BASES, GAINS, MASSES, QUANTITIES };

/* X, G = Mbar J D^+ and Mbar of the data; with `rates` their derivatives. */
static const double *quantity(const mbsr_data *d, int which, bool rates)
{
    const double *const value[] = {d->X, d->G, d->Mbar};
    const double *const rate[] = {d->Xdot, d->Gdot, d->Mbardot};
    return rates ? rate[which] : value[which];
}

static const double unused_entry = 1e300;

/* Blocks stand at the heads of groups: what the other bodies have is not written. */
static void forget_members(const mbsr_model *m, double *Xdot, double *Gdot)
{
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n * b->n && b->group.head != i; ++k)
            Xdot[b->nn + (size_t)k] = unused_entry;
        for (int k = 0; k < b->d * b->n && b->group.head != i; ++k)
            Gdot[b->dg + (size_t)k] = unused_entry;
    }
}

/* X', G' and Mbar' of bases.c against differences of X, G and Mbar along the motion. */
static void rates_of_the_bases_are_those_of_differences(void **unused)
{
    (void)unused;
    int turning = 0;
    for (int seed = 1; seed <= TREES; ++seed) {
        state s;
        setup(&s, seed);
        mbsr_data *d = s.tree.data;
        const mbsr_model *m = s.tree.model;
        const size_t size[QUANTITIES] = {m->size.nn, m->size.dg, m->size.dd};
        double F[2 * MOST], y[2 * MOST], *rate[QUANTITIES], *ahead[QUANTITIES];
        start(&s);
        assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_INDEX1, start_time, s.v, s.vdot, F),
                         MBSR_OK);
        for (int k = 0; k < QUANTITIES; ++k) {
            rate[k] = malloc((size[k] + 1) * sizeof(double));
            ahead[k] = malloc((size[k] + 1) * sizeof(double));
            memcpy(rate[k], quantity(d, k, true), size[k] * sizeof(double));
        }
        forget_members(m, rate[0], rate[1]);
        const double speed = 1.0 + test_largest(s.nq, s.qdot), h = 6e-6 / speed;
        pack_after(&s, h, y);
        for (int k = 0; k < QUANTITIES; ++k) {
            memcpy(ahead[k], quantity(d, k, false), size[k] * sizeof(double));
        }
        pack_after(&s, -h, y);
        for (int k = 0; k < QUANTITIES; ++k) {
            const double *behind = quantity(d, k, false);
            for (size_t l = 0; l < size[k]; ++l) {
                if (rate[k][l] == unused_entry) ahead[k][l] = 0.0;
            }
            const double magnitude = 1.0 + test_largest((int)size[k], ahead[k]);
            for (size_t l = 0; l < size[k] && s.kept > 1e-3; ++l) {
                if (rate[k][l] == unused_entry) continue;
                turning += k == BASES && fabs(rate[k][l]) > 1e-3;
                assert_close(rate[k][l], (ahead[k][l] - behind[l]) / (2.0 * h),
                             1e-8 * magnitude * speed / s.kept);
            }
            free(rate[k]);
            free(ahead[k]);
        }
        test_tree_free(&s.tree);
    }
    assert_true(turning > TREES);
}

static void renewing_the_reference_keeps_the_state(void **unused)
{
    (void)unused;
    for (int seed = 1; seed <= TREES / 3; ++seed) {
        state s;
        setup(&s, seed);
        start(&s);
        double cosine, F[2 * MOST], q[MOST], u[MOST];
        const mbsr_model *m = s.tree.model;
        mbsr_data *d = s.tree.data;
        int restart;
        assert_int_equal(mbsr_index1_renew(m, d, start_time, s.v, s.vdot, &restart), MBSR_OK);
        assert_int_equal(mbsr_index1_alignment(m, d, start_time, s.v, &cosine), MBSR_OK);
        assert_close(cosine, 1.0, 1e-12);
        assert_int_equal(mbsr_dae_unpack(m, d, MBSR_DAE_INDEX1, start_time, s.v, q, u), MBSR_OK);
        for (int k = 0; k < s.nu; ++k) {
            assert_close(u[k], s.u[k], 1e-12 * (1.0 + test_largest(s.nu, s.u)) / s.kept);
        }
        assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_INDEX1, start_time, s.v, s.vdot, F),
                         MBSR_OK);
        const double size = 1.0 + test_largest(2 * s.nu, s.vdot);
        for (int k = 0; k < s.nq + s.nu; ++k) assert_close(F[k], 0.0, 1e-9 * size);
        test_tree_free(&s.tree);
    }
}

static void without_a_reference_the_form_is_refused(void **unused)
{
    (void)unused;
    state s;
    setup(&s, 5);
    double y[2 * MOST] = {0.0}, F[2 * MOST], cosine;
    const mbsr_model *m = s.tree.model;
    mbsr_data *d = s.tree.data;
    assert_int_equal(mbsr_index1_reset(m, d), MBSR_OK);
    assert_int_equal(mbsr_dae_residual(m, d, MBSR_DAE_INDEX1, 0.0, y, y, F), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_dae_unpack(m, d, MBSR_DAE_INDEX1, 0.0, y, F, F + MOST),
                     MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_dae_id(m, d, MBSR_DAE_INDEX1, F), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_index1_alignment(m, d, 0.0, y, &cosine), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_index1_renew(m, d, 0.0, y, F, NULL), MBSR_ERR_SEQUENCE);
    test_tree_free(&s.tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eta_and_zeta_move_as_the_equations_say),
        cmocka_unit_test(velocities_come_back),
        cmocka_unit_test(the_residual_vanishes_with_the_other_forms),
        cmocka_unit_test(rates_of_the_bases_are_those_of_differences),
        cmocka_unit_test(renewing_the_reference_keeps_the_state),
        cmocka_unit_test(without_a_reference_the_form_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
