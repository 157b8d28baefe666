/* Nodes with rotations: a beam of elements with twelve dofs, against the built-in beam; mass lumped
 * at the nodes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/fe.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 40, DOFS = 6 * (MOST + 1), ENTRIES = 144 * MOST };

typedef struct frame {
    int entries, row[ENTRIES], column[ENTRIES], ends[2];
    double K[ENTRIES], M[ENTRIES], x[3 * (MOST + 1)];
    mbsr_fe_marker marker[2];
    mbsr_fe_def def;
} frame;

static const double length = 2.0, density = 3.0, EA = 5e4, EI_y = 40.0, EI_z = 70.0, GJ = 20.0;

/* Cubic bending in a plane: deflections at dofs 0 and 2, slopes at 1 and 3, of an element of length
 * h. */
static void bending(double h, double K[4][4], double M[4][4])
{
    const double k[4][4] = {{12, 6, -12, 6}, {6, 4, -6, 2}, {-12, -6, 12, -6}, {6, 2, -6, 4}},
                 m[4][4] = {
                     {156, 22, 54, -13}, {22, 4, 13, -3}, {54, 13, 156, -22}, {-13, -3, -22, 4}};
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            const double scale = pow(h, i % 2 + j % 2);
            K[i][j] = k[i][j] * scale / (h * h * h);
            M[i][j] = m[i][j] * scale * h / 420.0;
        }
    }
}

static void add(frame *f, int row, int column, double K, double M)
{
    f->row[f->entries] = row;
    f->column[f->entries] = column;
    f->K[f->entries] = K;
    f->M[f->entries++] = M;
}

static void add_element(frame *f, int e, double h)
{
    static const int along_y[4] = {1, 5, 7, 11}, along_z[4] = {2, 4, 8, 10};
    double K[4][4], M[4][4];
    bending(h, K, M);
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
            /* a slope along z is a rotation about -y */
            const double sign = (i + j) % 2 ? -1.0 : 1.0;
            add(f, 6 * e + along_y[i], 6 * e + along_y[j], EI_z * K[i][j], density * M[i][j]);
            add(f, 6 * e + along_z[i], 6 * e + along_z[j], sign * EI_y * K[i][j],
                sign * density * M[i][j]);
            if (i > 1 || j > 1) continue;
            const double unit = i == j ? 1.0 : -1.0;
            add(f, 6 * (e + i), 6 * (e + j), unit * EA / h,
                density * h * (i == j ? 2.0 : 1.0) / 6.0);
            add(f, 6 * (e + i) + 3, 6 * (e + j) + 3, unit * GJ / h, 0.0);
        }
    }
}

static frame *make(int elements)
{
    frame *f = calloc(1, sizeof *f);
    for (int e = 0; e < elements; ++e) add_element(f, e, length / elements);
    for (int k = 0; k <= elements; ++k) f->x[3 * k] = length * k / elements;
    f->ends[1] = elements;
    for (int end = 0; end < 2; ++end)
        f->marker[end] = (mbsr_fe_marker){.nodes = 1, .node = f->ends + end, .loaded = end};
    f->def = mbsr_default_fe_def();
    f->def.K = (mbsr_fe_matrix){.rows = 6 * (elements + 1),
                                .entries = (size_t)f->entries,
                                .row = f->row,
                                .column = f->column,
                                .value = f->K,
                                .whole = 1};
    f->def.M = f->def.K;
    f->def.M.value = f->M;
    f->def.nodes = elements + 1, f->def.x = f->x;
    f->def.markers = 2, f->def.marker = f->marker;
    f->def.modes = 6;
    return f;
}

/* Sum over modes of motion times motion by K at a marker, six by six. */
static void flexibility(const mbsr_flex_def *data, int marker, double F[36])
{
    memset(F, 0, 36 * sizeof *F);
    for (int a = 0; a < data->modes; ++a) {
        const double *Phi = data->marker[marker].Phi + 3 * a,
                     *Psi = data->marker[marker].Psi + 3 * a;
        const double motion[6] = {Psi[0], Psi[1], Psi[2], Phi[0], Phi[1], Phi[2]};
        for (int k = 0; k < 36; ++k)
            F[k] += motion[k / 6] * motion[k % 6] / data->K[a * (data->modes + 1)];
    }
}

static mbsr_flex *built_in(int elements, mbsr_flex_def *data)
{
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_error error;
    def.length = length, def.density = density, def.elements = elements;
    def.EA = EA, def.EI_y = EI_y, def.EI_z = EI_z, def.GJ = GJ;
    def.modes = 6, def.loaded = 1, def.node = &elements;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    assert_int_equal(mbsr_flex_definition(flex, data), MBSR_OK);
    return flex;
}

/* The differences of the integrals that mass lumped at the nodes makes. */
static double same_as_built_in(int elements)
{
    frame *f = make(elements);
    mbsr_flex *flex, *beam;
    mbsr_fe_report *report;
    mbsr_error error;
    mbsr_flex_def data, expected;
    double F[36], exact[36];
    assert_ok(mbsr_fe_reduce(&f->def, &flex, &report, &error), &error);
    assert_int_equal(mbsr_flex_definition(flex, &data), MBSR_OK);
    beam = built_in(elements, &expected);
    assert_int_equal(data.modes, expected.modes);
    assert_int_equal(report->normal, 6);
    for (int a = 0; a < 6; ++a) {
        const double omega = sqrt(expected.K[a * (expected.modes + 1)]);
        assert_close(report->omega[a], omega, 1e-8 * omega);
        assert_close(data.Mf[a * (data.modes + 1)], 1.0, 1e-9);
    }
    flexibility(&data, 1, F);
    flexibility(&expected, elements, exact);
    for (int k = 0; k < 36; ++k)
        assert_close(F[k], exact[k], 1e-9 * sqrt(exact[7 * (k / 6)] * exact[7 * (k % 6)]));
    /* torsion has no mass at all */
    assert_int_equal(report->mode[data.modes - 1].massless, 1);
    assert_close(report->mode[data.modes - 1].omega, 0.0, 0.0);
    assert_close(data.mass, 6.0, 1e-12);
    assert_close(data.c0[0], 6.0, 1e-12);
    const double worst = fabs(data.N0[0] / expected.N0[0] - 1.0) + report->difference;
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(beam);
    free(f);
    return worst;
}

static void frames_are_as_the_built_in_beam(void **state)
{
    (void)state;
    const double coarse = same_as_built_in(10), fine = same_as_built_in(20),
                 finest = same_as_built_in(40);
    assert_less(coarse, 0.06);
    assert_less(fine, 0.3 * coarse); /* with the square of the length of an element */
    assert_less(finest, 0.3 * fine);
}

/* No inertia about x: the free body cannot turn about it with a finite force. */
static void no_inertia_about_an_axis(void **state)
{
    (void)state;
    frame *f = make(4);
    mbsr_flex *flex;
    mbsr_error error;
    f->def.free = 1;
    assert_refused(mbsr_fe_reduce(&f->def, &flex, NULL, &error), &error, MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "no inertia about some axis");
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_as_the_built_in_beam),
        cmocka_unit_test(no_inertia_about_an_axis),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
