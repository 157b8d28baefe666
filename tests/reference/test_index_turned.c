/* What index report and start say of bodies on chains of carriers without mass, whose axes are
 * turned by exact right angles, by half of them or by any angle: what a mass matrix of less rank
 * than rates leaves out no force sees.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "duration.h"
#include "turned.h"

#include <math.h>

/* The rank of the mass matrix, scaled to unit diagonal; -1: not clear. */
static int rank_at(const turned *s, const double *q)
{
    double M[TURNED_MOST * TURNED_MOST], scale[TURNED_MOST], room[TURNED_MOST * TURNED_MOST];
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, q), mbsr_data_error(s->d));
    assert_ok(mbsr_mass_matrix(s->m, s->d, M), mbsr_data_error(s->d));
    for (int k = 0; k < s->nu; ++k)
        scale[k] = M[k * s->nu + k] > 0.0 ? 1.0 / sqrt(M[k * s->nu + k]) : 0.0;
    for (int k = 0; k < s->nu * s->nu; ++k) M[k] *= scale[k / s->nu] * scale[k % s->nu];
    const int null = turned_null(s->nu, M, room);
    return null < 0 ? -1 : s->nu - null;
}

/* Whether states around have another rank. */
static bool alone(turned *s, int rank)
{
    mbsr_coordinate_kind kind[7];
    double q[TURNED_MOST];
    for (int i = 0, at = 0, nq; i < s->bodies; ++i, at += nq) {
        assert_ok(mbsr_body_coordinate_kinds(s->m, i, kind, NULL), NULL);
        assert_ok(mbsr_body_coordinates(s->m, i, NULL, &nq, NULL, NULL), NULL);
        for (int k = 0; k < nq; ++k) {
            const double size = kind[k] == MBSR_COORDINATE_TRANSLATION ? s->of->length : 1.0;
            q[at + k] = s->q[at + k] + 0.02 * size * test_uniform(&s->rng);
        }
    }
    return rank_at(s, q) != rank;
}

/* Carriers, and a rigid body with all forces on it. */
static void build(turned *s, uint64_t seed, const units *of)
{
    turned_begin(s, seed, of);
    const int carriers = test_integer(&s->rng, 1, 3);
    for (int i = 0; i < carriers; ++i)
        turned_add(s, i - 1, test_integer(&s->rng, 0, TURNED_JOINTS - 1), mbsr_inertia_zero());
    const int last = test_integer(&s->rng, 0, 2 * TURNED_JOINTS - 1);
    turned_add(s, carriers - 1, last < TURNED_JOINTS ? last : TURNED_FREE, turned_rigid(s));
    const double L = of->length, k = of->mass / (of->time * of->time), d = of->mass / of->time,
                 x[3] = {0.3 * L, 0.0, 0.1 * L}, y[3] = {0.0, L, L},
                 stiffness[6] = {k * L * L, 2.0 * k * L * L, 0.0, 4.0 * k, 0.0, 6.0 * k},
                 damping[6] = {0.0, 3.0 * d * L * L, d * L * L, 2.0 * d, 0.0, d};
    turned_force(s,
                 mbsr_force_point_spring(carriers, x, MBSR_GROUND, y, 50.0 * k, 7.0 * d, 0.5 * L));
    turned_force(s, mbsr_force_bushing(carriers, NULL, MBSR_GROUND, NULL, stiffness, damping));
    turned_force(s, mbsr_force_gravity(0.0, 0.0, -9.81 * L / (of->time * of->time)));
    turned_finish(s);
}

/* The status of a start. */
static int start(const turned *s)
{
    double y[4 * TURNED_MOST], yp[4 * TURNED_MOST];
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y),
              mbsr_data_error(s->d));
    return mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
}

/* Starts that are refused take long, so that few are tried. */
static int judge(turned *s, int rank, uint64_t seed)
{
    enum { FEW = 64 };
    mbsr_index_report *report = NULL;
    const int status = mbsr_index_report_create(s->m, s->d, 0.0, s->q, s->u, &report),
              expected = rank < s->nu ? MBSR_UNDETERMINED : MBSR_OK,
              found = rank == s->nu || status || seed % FEW == 0 ? start(s) : expected;
    const bool right =
        status == MBSR_OK
            ? report->dynamic == rank && report->undetermined == s->nu - rank && found == expected
            : status == found && (status == MBSR_DEGENERATE_FORCE ||
                                  (status == MBSR_RANK_CHANGED && alone(s, rank)));
    if (!right)
        print_error("seed %d, %s: rank %d of %d, report %s %d %d %d %d, start %s\n", (int)seed,
                    s->of->name, rank, s->nu, mbsr_status_name(status),
                    report ? report->dynamic : -1, report ? report->damped : -1,
                    report ? report->elastic : -1, report ? report->undetermined : -1,
                    mbsr_status_name(found));
    mbsr_index_report_destroy(s->m, report);
    return right ? status == MBSR_OK ? 0 : -1 : 1;
}

/* 1: report or start are wrong, 0: right, -1: it cannot be told. */
static int try_carriers(uint64_t seed, const units *of)
{
    turned s;
    build(&s, seed, of);
    const int rank = rank_at(&s, s.q), wrong = rank < 0 ? -1 : judge(&s, rank, seed);
    turned_free(&s);
    return wrong;
}

static void what_carriers_hide_is_undetermined(void **state)
{
    (void)state;
    const int seeds = test_long() ? 20000 : test_seeds(60, 250);
    int wrong = 0, judged = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        const int verdict = try_carriers((uint64_t)seed, systems + seed % 4);
        judged += verdict >= 0;
        wrong += verdict > 0;
    }
    assert_true(judged > seeds / 2);
    assert_int_equal(wrong, 0);
}

/* A rod on a hinge along it, behind a body that is free: it spins by the one or the other, and the
 * dampers of both see that. */
static void a_rod_may_spin_by_either_joint(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        const units *of = systems + k;
        const double L = of->length, d = of->mass / of->time, along[3] = {0.0, 0.0, 1.0},
                     end[3] = {0.0, 0.0, L}, damping[6] = {0.0, 0.0, 4.0 * d * L * L, 5.0 * d},
                     q[8] = {1.0}, u[7] = {0.0}, right = 2.0 * atan(1.0);
        const mbsr_inertia none = mbsr_inertia_zero(), rod = mbsr_inertia_rod(of->mass, NULL, end);
        const mbsr_frame marker = mbsr_frame_at(0.25 * L, -0.75 * L, L);
        mbsr_frame first = mbsr_frame_at(0.0, L, 0.0), second = mbsr_frame_at(0.0, 0.0, L);
        turned_about(first.R, 0, right), turned_about(second.R, 0, right);
        turned s = {.of = of};
        mbsr_index_report *report;
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL);
        test_add_body(s.m, MBSR_GROUND, mbsr_joint_free(&first, NULL), none);
        test_add_body(s.m, 0, mbsr_joint_revolute(&second, NULL, along), rod);
        turned_force(&s, mbsr_force_joint_spring(1, 0, 0.0, d * L * L, 0.0));
        turned_force(&s, mbsr_force_bushing(1, &marker, MBSR_GROUND, &marker, NULL, damping));
        turned_finish(&s);
        assert_ok(mbsr_index_report_create(s.m, s.d, 0.0, q, u, &report), mbsr_data_error(s.d));
        assert_int_equal(report->dynamic, 5);
        assert_int_equal(report->damped, 2);
        mbsr_index_report_destroy(s.m, report);
        turned_free(&s);
    }
}

/* A rank that passes from one joint of a chain to another. */
static void ranks_pass_between_carriers(void **state)
{
    (void)state;
    static const uint64_t seeds[] = {741, 2685};
    int wrong = 0;
    for (size_t k = 0; k < sizeof seeds / sizeof seeds[0]; ++k)
        wrong += try_carriers(seeds[k], systems) != 0;
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_carriers_hide_is_undetermined),
                                       cmocka_unit_test(ranks_pass_between_carriers),
                                       cmocka_unit_test(a_rod_may_spin_by_either_joint)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
