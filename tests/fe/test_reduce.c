/* Reduction of solids: frequencies and deflections against dense matrices in full, integrals by
 * sums over all nodes, which modes have mass, what is reported, progress.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "duration.h"
#include "expect.h"
#include "solid.h"

static mbsr_flex *reduce(const mbsr_fe_def *def, mbsr_flex_def *data, mbsr_fe_report **report)
{
    mbsr_flex *flex;
    mbsr_error error;
    assert_ok(mbsr_fe_reduce(def, &flex, report, &error), &error);
    assert_int_equal(mbsr_flex_definition(flex, data), MBSR_OK);
    return flex;
}

static void modes_are_those_of_dense_matrices(void **state)
{
    (void)state;
    test_solid *s = test_bar(4, 2, 2);
    double *omega = malloc((size_t)s->mesh.dofs * sizeof *omega);
    for (int free_body = 0; free_body < 2; ++free_body) {
        const int count = test_solid_frequencies(s, free_body, omega);
        for (int solver = MBSR_FE_DENSE; solver <= test_solvers; ++solver) {
            mbsr_fe_def def = s->def;
            mbsr_fe_report *report;
            mbsr_flex_def data;
            def.free = free_body;
            def.modes = 20;
            def.solver = (mbsr_fe_solver)solver;
            mbsr_flex *flex = reduce(&def, &data, &report);
            assert_int_equal(report->normal, 20);
            assert_true(count > 20);
            for (int k = 0; k < 20; ++k) assert_close(report->omega[k], omega[k], 1e-9 * omega[k]);
            for (int k = 0; k < 20 && !free_body; ++k)
                assert_close(sqrt(data.K[k * (data.modes + 1)]), omega[k], 1e-9 * omega[k]);
            mbsr_fe_report_destroy(report);
            mbsr_flex_destroy(flex);
            /* those below a frequency */
            def.frequency = 0.5 * (omega[6] + omega[7]);
            flex = reduce(&def, &data, &report);
            assert_int_equal(report->normal, 7);
            mbsr_fe_report_destroy(report);
            mbsr_flex_destroy(flex);
        }
    }
    free(omega);
    test_solid_destroy(s);
}

/* All modes that there are: as many as dofs that the root leaves. */
static void all_modes(void **state)
{
    (void)state;
    test_solid *s = test_bar(1, 1, 1);
    mbsr_fe_report *report;
    mbsr_flex_def data;
    double omega[24];
    s->def.modes = 60;
    mbsr_flex *flex = reduce(&s->def, &data, &report);
    assert_int_equal(test_solid_frequencies(s, 0, omega), 18);
    assert_int_equal(report->normal, 18);
    assert_int_equal(report->dependent, 6);
    assert_int_equal(data.modes, 18);
    for (int k = 0; k < 18; ++k) {
        assert_close(report->omega[k], omega[k], 1e-9 * omega[k]);
        assert_int_equal(report->mode[k].massless, 0);
    }
    /* together they move all the mass that the root does not hold fast */
    for (int c = 0; c < 3; ++c) assert_less(report->lost[3 + c], 0.7);
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    test_solid_destroy(s);
}

static void deflections_are_exact(void **state)
{
    (void)state;
    test_solid *s = test_bar(4, 2, 2);
    double exact[36], F[36];
    test_solid_flexibility(s, exact);
    for (int trial = 0; trial < 12; ++trial) {
        static const int modes[3] = {0, 3, 12};
        mbsr_fe_def def = s->def;
        mbsr_flex_def data;
        def.modes = modes[trial % 3];
        def.free = trial / 3 % 2;
        def.cutoff = trial < 6 ? 0.0 : INFINITY;
        def.solver = trial % 2 ? MBSR_FE_DENSE : MBSR_FE_AUTO;
        mbsr_flex *flex = reduce(&def, &data, NULL);
        test_tip_flexibility(&data, 1, F);
        for (int k = 0; k < 36; ++k)
            assert_close(F[k], exact[k], 1e-9 * sqrt(exact[7 * (k / 6)] * exact[7 * (k % 6)]));
        int massless = 0;
        for (int a = 0; a < data.modes; ++a) {
            const double mass = data.Mf[a * (data.modes + 1)];
            massless += mass == 0.0;
            if (mass > 0.0) assert_close(mass, 1.0, 1e-9);
            if (mass == 0.0) assert_close(data.K[a * (data.modes + 1)], 1.0, 0.0);
            for (int k = 0; k < 3; ++k) {
                assert_close(data.marker[0].Phi[3 * a + k], 0.0, 0.0);
                if (mass == 0.0) assert_close(data.Ct0[3 * a + k], 0.0, 0.0);
            }
        }
        assert_int_equal(data.modes, def.modes + 6);
        if (!def.free) assert_int_equal(massless, trial < 6 ? 6 : 0);
        mbsr_flex_destroy(flex);
    }
    test_solid_destroy(s);
}

/* Every node a marker, so that the modes are known everywhere: integrals by the entries of M. */
static void integrals_are_those_of_the_matrices(void **state)
{
    (void)state;
    test_solid *s = test_bar(3, 2, 1);
    const int nodes = s->mesh.nodes;
    int *id = malloc((size_t)nodes * sizeof *id);
    mbsr_fe_marker *marker = calloc((size_t)nodes + 2, sizeof *marker);
    memcpy(marker, s->marker, sizeof s->marker);
    for (int k = 0; k < nodes; ++k) {
        id[k] = k;
        marker[2 + k] = (mbsr_fe_marker){.nodes = 1, .node = id + k};
    }
    s->def.markers = nodes + 2;
    s->def.marker = marker;
    s->def.modes = 5;
    mbsr_fe_report *report;
    mbsr_flex_def data;
    mbsr_flex *flex = reduce(&s->def, &data, &report);
    const double mass = 780.0 * 0.1 * 0.08;
    assert_close(data.mass, mass, 1e-12 * mass);
    assert_close(data.c0[0], 0.5 * mass, 1e-12 * mass);
    assert_close(data.c0[1], 0.0, 1e-12 * mass);
    const double square[3] = {1.0 / 3.0, 0.01 / 12.0, 0.0064 / 12.0};
    for (int k = 0; k < 9; ++k)
        assert_close(data.N0[k], k % 4 == 0 ? mass * square[k / 4] : 0.0, 1e-12 * mass);
    const int rows = 3 * data.modes;
    double *P = calloc((size_t)rows * (size_t)rows, sizeof *P),
           *P0 = calloc(3 * (size_t)rows, sizeof *P0);
    for (int e = 0; e < s->mesh.entries; ++e) {
        const int i = s->mesh.row[e], j = s->mesh.column[e];
        if (i % 3 != 0 || j % 3 != 0) continue; /* Ms stands along x */
        for (int turned = 0; turned < 1 + (i != j); ++turned) {
            const mbsr_flex_marker *a = data.marker + 2 + (turned ? j : i) / 3,
                                   *b = data.marker + 2 + (turned ? i : j) / 3;
            for (int r = 0; r < rows; ++r) {
                for (int c = 0; c < rows; ++c)
                    P[rows * c + r] += s->mesh.M[e] * a->Phi[r] * b->Phi[c];
                for (int c = 0; c < 3; ++c)
                    P0[3 * r + c] += s->mesh.M[e] * a->frame.x[c] * b->Phi[r];
            }
        }
    }
    for (int a = 0; a < data.modes; ++a) {
        const bool massive = data.Mf[a * (data.modes + 1)] > 0.0;
        assert_int_equal(massive, a < 5);
        for (int k = 0; k < 9; ++k)
            assert_close(data.P0[9 * a + k], massive ? P0[9 * a + k] : 0.0, 1e-11);
    }
    for (int r = 0; r < 15; ++r) {
        for (int c = 0; c < 15; ++c) assert_close(data.P[rows * c + r], P[rows * c + r], 1e-11);
    }
    assert_less(report->difference, 1e-12);
    assert_less(1e-6, report->definite);
    free(P);
    free(P0);
    free(id);
    free(marker);
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    test_solid_destroy(s);
}

/* About a thousand dofs, in long runs ten and a hundred thousand: against a tighter tolerance and
 * other modes, and the static solution alone; against the theory of slender beams. */
static void large_models(void **state)
{
    (void)state;
    static const int elements[3][3] = {{20, 4, 3}, {66, 7, 5}, {150, 16, 12}};
    for (int size = 0; size < (test_long() && test_solvers > MBSR_FE_DENSE ? 3 : 1); ++size) {
        test_solid *s = test_bar(elements[size][0], elements[size][1], elements[size][2]);
        mbsr_fe_report *report, *tight;
        mbsr_flex_def data;
        double F[36], exact[36];
        s->def.modes = 8;
        mbsr_flex *flex = reduce(&s->def, &data, &report);
        test_tip_flexibility(&data, 1, F);
        mbsr_flex_destroy(flex);
        s->def.modes = 12, s->def.tolerance = 1e-13;
        flex = reduce(&s->def, &data, &tight);
        for (int k = 0; k < 8; ++k)
            assert_close(report->omega[k], tight->omega[k], 1e-11 * tight->omega[k]);
        mbsr_flex_destroy(flex);
        s->def.modes = 0;
        flex = reduce(&s->def, &data, NULL);
        test_tip_flexibility(&data, 1, exact);
        for (int k = 0; k < 36; ++k)
            assert_close(F[k], exact[k], 1e-9 * sqrt(exact[7 * (k / 6)] * exact[7 * (k % 6)]));
        mbsr_flex_destroy(flex);
        /* shear deforms it, too, u / F = L^3 / (3 EI) + L / (kappa G A), and so do ends that are
         * held in the mean, by forces that every node has alike */
        const double EI[2] = {2.1e8 * 0.1 * 0.000512 / 12.0, 2.1e8 * 0.08 * 0.001 / 12.0},
                     shear = 2.6 / (5.0 / 6.0 * 2.1e8 * 0.008);
        assert_close(exact[35], 1.0 / (3.0 * EI[0]) + shear, 0.03 * exact[35]);
        assert_close(exact[28], 1.0 / (3.0 * EI[1]) + shear, 0.03 * exact[28]);
        const double beam = 3.516015268 * sqrt(EI[0] / (780.0 * 0.008));
        assert_close(report->omega[0], beam, 0.02 * beam);
        mbsr_fe_report_destroy(report);
        mbsr_fe_report_destroy(tight);
        test_solid_destroy(s);
    }
}

/* D = 0.003 K becomes 0.003 Phi^T K Phi; ratios are added to modes with mass. */
static void damping(void **state)
{
    (void)state;
    test_solid *s = test_bar(3, 1, 1);
    double *value = malloc((size_t)s->mesh.entries * sizeof *value);
    for (int k = 0; k < s->mesh.entries; ++k) value[k] = 0.003 * s->mesh.K[k];
    s->def.D = s->def.K;
    s->def.D.value = value;
    s->def.modes = 4;
    s->def.damping = 0.02;
    mbsr_fe_report *report;
    mbsr_flex_def data;
    mbsr_flex *flex = reduce(&s->def, &data, &report);
    for (int a = 0; a < data.modes; ++a) {
        for (int b = 0; b < data.modes; ++b) {
            const double K = data.K[a * data.modes + b], omega = report->mode[a].omega,
                         ratio = a < 4 ? 0.04 * omega : 0.04 / report->mode[3].omega,
                         least = a < 4 && b < 4 ? omega : 1.0;
            assert_close(data.D[a * data.modes + b], 0.003 * K + (a == b ? ratio : 0.0),
                         1e-9 * least);
        }
        if (a < 4)
            assert_close(report->mode[a].damping, 0.02 + 0.0015 * report->mode[a].omega, 1e-9);
    }
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    free(value);
    test_solid_destroy(s);
}

/* What the report says, mode by mode: of a uniform cantilever the first bending mode moves 0.6131
 * of the mass. */
static void reports(void **state)
{
    (void)state;
    test_solid *s = test_bar(16, 1, 1);
    mbsr_fe_report *report;
    mbsr_flex_def data;
    s->def.modes = 8;
    mbsr_flex *flex = reduce(&s->def, &data, &report);
    assert_int_equal(report->dofs, s->mesh.dofs);
    assert_int_equal(report->modes, 14);
    assert_close(report->mode[0].effective[5], 0.6131 * report->mass, 0.005 * report->mass);
    assert_close(report->mode[1].effective[4], 0.6131 * report->mass, 0.005 * report->mass);
    double sum[6] = {0.0};
    for (int a = 0; a < 8; ++a) {
        for (int c = 0; c < 6; ++c) sum[c] += report->mode[a].effective[c];
        for (int c = 0; c < 3; ++c) {
            const double share = data.Ct0[3 * a + c];
            assert_close(report->mode[a].effective[3 + c], share * share, 1e-10);
        }
    }
    for (int c = 0; c < 6; ++c) {
        const double whole = c < 3 ? report->J[4 * c] : report->mass;
        assert_close(report->lost[c], 1.0 - sum[c] / whole, 1e-10);
    }
    assert_contains(report->text, "massless|lost|mass 6.24 kg|204 dofs");
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    test_solid_destroy(s);
}

typedef struct watch {
    int calls, stop_at;
    char stages[200];
} watch;

static int look(void *user, const char *stage, double done)
{
    watch *w = user;
    assert_true(done >= 0.0 && done <= 1.0);
    if (!strstr(w->stages, stage)) strcat(w->stages, stage);
    return ++w->calls == w->stop_at ? 77 : 0;
}

static void progress_can_stop(void **state)
{
    (void)state;
    test_solid *s = test_bar(4, 2, 2);
    watch w = {.calls = 0};
    mbsr_flex_def data;
    s->def.progress = look, s->def.user = &w;
    mbsr_flex_destroy(reduce(&s->def, &data, NULL));
    assert_contains(w.stages, "checks|factorisation|normal modes|static modes|integrals");
    const int calls = w.calls;
    for (int k = 1; k <= calls; ++k) {
        test_counting counting = {.calls = 0};
        mbsr_flex *flex;
        mbsr_fe_report *report;
        mbsr_error error;
        w = (watch){.stop_at = k};
        s->def.allocator = test_counting_allocator(&counting);
        assert_int_equal(mbsr_fe_reduce(&s->def, &flex, &report, &error), 77);
        assert_int_equal(w.calls, k);
        assert_int_equal(error.status, 77);
        assert_contains(error.text, "progress");
        assert_null(flex);
        assert_null(report);
        assert_int_equal(counting.live, 0);
    }
    test_solid_destroy(s);
}

static void nothing_is_lost_without_memory(void **state)
{
    (void)state;
    test_solid *s = test_bar(2, 1, 1);
    test_counting counting = {.calls = 0};
    mbsr_flex *flex;
    mbsr_fe_report *report;
    mbsr_error error;
    s->def.modes = 3;
    int k = 1;
    for (; k < 500; ++k) {
        counting = (test_counting){.fail_at = k};
        s->def.allocator = test_counting_allocator(&counting);
        const int status = mbsr_fe_reduce(&s->def, &flex, &report, &error);
        if (!counting.failed) {
            assert_ok(status, &error);
            break;
        }
        assert_refused(status, &error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "mbsr_f");
        assert_null(flex);
        assert_null(report);
        assert_int_equal(counting.live, 0);
    }
    assert_true(k > 10 && k < 500);
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    assert_int_equal(counting.live, 0);
    test_solid_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modes_are_those_of_dense_matrices),
        cmocka_unit_test(all_modes),
        cmocka_unit_test(deflections_are_exact),
        cmocka_unit_test(integrals_are_those_of_the_matrices),
        cmocka_unit_test(large_models),
        cmocka_unit_test(damping),
        cmocka_unit_test(reports),
        cmocka_unit_test(progress_can_stop),
        cmocka_unit_test(nothing_is_lost_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
