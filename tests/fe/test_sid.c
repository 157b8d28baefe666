/* SID files: written and read again; what is written against differences of M(s); data of no body,
 * refused or changed as little as the caller allows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "locale_comma.h"
#include "small_sid.h"
#include "sid_text.h"

#include <math.h>

static mbsr_flex *make_beam(void)
{
    static const int nodes[2] = {4, 2};
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_error error;
    def.length = 2.0, def.density = 3.0, def.elements = 4;
    def.EA = 5e4, def.EI_y = 40.0, def.EI_z = 70.0, def.GJ = 20.0;
    def.radius_y = 0.03, def.radius_z = 0.02, def.tip_mass = 0.5, def.damping = 0.01;
    def.modes = 4, def.loaded = 1, def.node = nodes;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    return flex;
}

static void assert_same(int n, const double *x, const double *y, double tolerance)
{
    const double scale = fmax(test_largest(n, x), 1e-300);
    for (int k = 0; k < n; ++k) assert_close(x[k], y[k], tolerance * scale);
}

static void assert_same_data(const mbsr_flex *one, const mbsr_flex *two, double tolerance)
{
    mbsr_flex_def a, b;
    assert_int_equal(mbsr_flex_definition(one, &a), MBSR_OK);
    assert_int_equal(mbsr_flex_definition(two, &b), MBSR_OK);
    const int n = a.modes;
    assert_int_equal(n, b.modes);
    assert_int_equal(a.markers, b.markers);
    assert_close(a.mass, b.mass, 0.0);
    assert_same(3, a.c0, b.c0, 0.0);
    assert_same(9, a.N0, b.N0, tolerance);
    assert_same(3 * n, a.Ct0, b.Ct0, tolerance);
    assert_same(9 * n, a.P0, b.P0, tolerance);
    assert_same(9 * n * n, a.P, b.P, tolerance);
    assert_same(n * n, a.Mf, b.Mf, 1e-15);
    assert_same(n * n, a.K, b.K, 0.0);
    assert_same(n * n, a.D, b.D, 0.0);
    for (int k = 0; k < a.markers; ++k) {
        assert_same(3, a.marker[k].frame.x, b.marker[k].frame.x, 0.0);
        assert_same(9, a.marker[k].frame.R, b.marker[k].frame.R, 0.0);
        assert_same(3 * n, a.marker[k].Phi, b.marker[k].Phi, 0.0);
        assert_same(3 * n, a.marker[k].Psi, b.marker[k].Psi, 0.0);
    }
}

static mbsr_sid_text *write(const mbsr_flex *flex)
{
    mbsr_sid_text *text;
    mbsr_error error;
    assert_ok(mbsr_sid_write(flex, "a beam\nof mine", NULL, &text, &error), &error);
    assert_int_equal(strlen(text->text), text->size);
    return text;
}

static void round_trip(void **state)
{
    (void)state;
    mbsr_flex *flex = make_beam(), *again;
    mbsr_sid_report *report;
    mbsr_error error;
    for (int comma = 0; comma < 2; ++comma) {
        if (comma && !test_locale_comma()) break;
        mbsr_sid_text *text = write(flex);
        assert_ok(mbsr_sid_read(text->text, text->size, NULL, NULL, &again, &report, &error),
                  &error);
        assert_same_data(flex, again, 1e-14);
        assert_int_equal(report->modes, 10);
        assert_int_equal(report->markers, 5);
        assert_int_equal(report->node[4], 5);
        assert_string_equal(report->name[0], "mode 1");
        assert_string_equal(report->name[9], "mode 10, massless");
        assert_close(report->keep_coupling, 1.0, 0.0);
        assert_close(report->keep_strain, 1.0, 0.0);
        assert_close(report->keep_rest, 1.0, 0.0);
        assert_less(report->changed_P, 1e-12);
        assert_less(report->asymmetry, 1e-12);
        assert_int_equal(report->stiffening, 0);
        assert_less(-1e-12, report->definite);
        assert_contains(report->text, "10 modes, 5 nodes");
        assert_null(strstr(report->text, "CHANGED"));
        mbsr_sid_report_destroy(report);
        mbsr_flex_destroy(again);
        mbsr_sid_text_destroy(text);
        test_locale_back();
    }
    mbsr_flex_destroy(flex);
}

/* d/ds_b and d^2/ds_a ds_b of an entry of M(s), which is of second degree: differences are exact.
 */
static double slope(const mbsr_flex *flex, int n, int i, int j, int a, int b)
{
    double s[16] = {0.0}, M[4][22 * 22];
    const int at = (6 + n) * j + i;
    for (int k = 0; k < 4; ++k) {
        for (int c = 0; c < n; ++c) s[c] = 0.0;
        if (a < 0) {
            s[b] = k % 2 ? -1.0 : 1.0;
        } else {
            s[a] += k & 1 ? -1.0 : 1.0;
            s[b] += k & 2 ? -1.0 : 1.0;
        }
        assert_int_equal(mbsr_flex_mass_matrix(flex, s, M[k]), MBSR_OK);
    }
    return a < 0 ? 0.5 * (M[0][at] - M[1][at]) : 0.25 * (M[0][at] - M[1][at] - M[2][at] + M[3][at]);
}

/* The tensor's order: xx yy zz xy xz yz; that of Oe: xx yy zz xy yz xz. */
static void written_matrices_are_those_of_the_mass_matrix(void **state)
{
    (void)state;
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2},
                     of_oe[6] = {0, 1, 2, 3, 5, 4};
    mbsr_flex *flex = make_beam();
    mbsr_sid_text *text = write(flex);
    const char *t = text->text;
    const int n = 10;
    for (int a = 0; a < n; ++a) {
        double J1[9], skew[9] = {0.0};
        for (int k = 0; k < 6; ++k) {
            const double J = slope(flex, n, row[k], column[k], -1, a);
            assert_close(test_sid_entry(t, "J", "m1", k + 1, a + 1, 1), J, 1e-12);
            J1[3 * row[k] + column[k]] = J1[3 * column[k] + row[k]] = J;
        }
        for (int k = 0; k < 6; ++k) { /* the centrifugal force is -1/2 w^T dJ/ds w */
            const int l = of_oe[k];
            assert_close(test_sid_entry(t, "Oe", "m0", a + 1, k + 1, 0),
                         -(l < 3 ? 0.5 : 1.0) * J1[3 * row[l] + column[l]], 1e-12);
        }
        for (int c = 0; c < 3; ++c) {
            const double Cr = test_sid_entry(t, "Cr", "m0", a + 1, c + 1, 0);
            double rest[16] = {0.0}, M[22 * 22];
            assert_int_equal(mbsr_flex_mass_matrix(flex, rest, M), MBSR_OK);
            assert_close(Cr, M[16 * (6 + a) + c], 1e-12);
            assert_close(test_sid_entry(t, "Ct", "m0", a + 1, c + 1, 0), M[16 * (6 + a) + 3 + c],
                         1e-12);
            skew[3 * ((c + 1) % 3) + (c + 2) % 3] = Cr; /* E - E^T, by rows */
            skew[3 * ((c + 2) % 3) + (c + 1) % 3] = -Cr;
            for (int b = 0; b < n; ++b) {
                const double Cr1 = slope(flex, n, c, 6 + a, -1, b);
                assert_close(test_sid_entry(t, "Cr", "m1", a + 1, b + 1, c + 1), Cr1, 1e-12);
                assert_close(test_sid_entry(t, "Ge", "m0", a + 1, 3 * b + c + 1, 0), 2.0 * Cr1,
                             1e-12);
            }
        }
        for (int k = 0; k < 9; ++k) /* 2 (tr E 1 - E^T) = dJ/ds + E - E^T */
            assert_close(test_sid_entry(t, "Gr", "m0", k / 3 + 1, 3 * a + k % 3 + 1, 0),
                         J1[k] + skew[k], 1e-12);
        for (int b = 0; b < n; ++b) {
            for (int k = 0; k < 6; ++k) {
                const int l = of_oe[k];
                const double J2 = slope(flex, n, row[l], column[l], a, b);
                assert_close(test_sid_entry(t, "Oe", "m1", a + 1, b + 1, k + 1),
                             -(l < 3 ? 0.5 : 1.0) * J2, 1e-12);
            }
        }
    }
    mbsr_sid_text_destroy(text);
    mbsr_flex_destroy(flex);
}

static void files_of_others(void **state)
{
    (void)state;
    mbsr_flex *flex;
    mbsr_sid_report *report;
    mbsr_error error;
    mbsr_flex_def d;
    assert_ok(mbsr_sid_read(test_small_sid, sizeof test_small_sid - 1, "small", NULL, &flex,
                            &report, &error),
              &error);
    assert_int_equal(mbsr_flex_definition(flex, &d), MBSR_OK);
    assert_close(d.mass, 2.0, 0.0);
    assert_close(d.N0[0], 1.0, 1e-15); /* a rod: J = diag(0, 1, 1) */
    assert_close(d.N0[4], 0.0, 1e-15);
    assert_close(d.Ct0[1], 0.5, 1e-15);
    assert_close(d.P0[3], 0.5, 1e-15); /* int x Phi_y */
    assert_close(d.P0[1], 0.0, 1e-15); /* int y Phi_x */
    assert_close(d.P[4], 1.0, 1e-15);
    assert_close(d.P[0], 0.0, 1e-15);
    assert_close(d.K[0], 30.0, 0.0);
    assert_close(d.Mf[0], 1.0, 0.0);
    assert_close(d.marker[1].Phi[1], 1.0, 0.0);
    assert_close(d.marker[1].frame.R[4], 1.0, 0.0);
    assert_int_equal(report->node[1], 9);
    assert_string_equal(report->name[0], "Eigen Mode    1 :        9.089 Hz");
    assert_close(report->trace[0], 1.0, 1e-15);
    assert_close(report->mdCM, 0.0, 1e-15);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(flex);
}

static void refuse_text(const char *text, const mbsr_sid_opt *opt, int status, const char *words)
{
    mbsr_flex *flex;
    mbsr_sid_report *report;
    mbsr_error error;
    assert_refused(mbsr_sid_read(text, strlen(text), "b.SID", opt, &flex, &report, &error), &error,
                   status, MBSR_NONE, MBSR_NONE, words);
    assert_true(strlen(error.text) < MBSR_TEXT_SIZE - 1);
    assert_null(flex);
    assert_null(report);
}

/* M(s) of data that were changed has no direction of negative mass: tried by its Cholesky factor
 * with a little on the diagonal. */
static void assert_positive(const mbsr_flex *flex, int n)
{
    test_rng rng = test_seed(5);
    for (int trial = 0; trial < 50; ++trial) {
        double s[16], M[22 * 22];
        const int size = 6 + n;
        for (int a = 0; a < n; ++a) s[a] = 0.3 * test_uniform(&rng);
        assert_int_equal(mbsr_flex_mass_matrix(flex, s, M), MBSR_OK);
        for (int j = 0; j < size; ++j) {
            const double d = M[j * (size + 1)] * (1.0 + 1e-8) + 1e-30;
            double pivot = d;
            for (int k = 0; k < j; ++k) pivot -= M[size * k + j] * M[size * k + j];
            assert_less(0.0, pivot);
            for (int i = j + 1; i < size; ++i) {
                double sum = M[size * j + i];
                for (int k = 0; k < j; ++k) sum -= M[size * k + i] * M[size * k + j];
                M[size * j + i] = sum / sqrt(pivot);
            }
            M[size * j + j] = sqrt(pivot);
        }
    }
}

static void data_of_no_body(void **state)
{
    (void)state;
    mbsr_flex *flex = make_beam(), *changed, *again;
    mbsr_sid_text *text = write(flex), *written;
    mbsr_sid_report *report;
    mbsr_error error;
    mbsr_sid_opt opt = mbsr_default_sid_opt();
    double rest[16] = {0.0}, M[22 * 22], expected[22 * 22];
    assert_int_equal(mbsr_flex_mass_matrix(flex, rest, expected), MBSR_OK);

    /* modes coupled too strongly: M(0) is indefinite */
    char *more = test_sid_scaled(text->text, "Ct", "m0", 1.7);
    refuse_text(more, NULL, MBSR_ERR_VALUE, "M(0)|eigenvalue -0.|MBSR_SID_COUPLING");
    opt.change = MBSR_SID_SECOND_ORDER;
    refuse_text(more, &opt, MBSR_ERR_VALUE, "eigenvalue -0.|MBSR_SID_COUPLING");
    opt.change = MBSR_SID_COUPLING;
    assert_ok(mbsr_sid_read(more, strlen(more), NULL, &opt, &changed, &report, &error), &error);
    assert_less(report->definite, -0.01);
    assert_less(report->keep_coupling, 0.99);
    assert_less(0.3, report->keep_coupling);
    assert_contains(report->text, "INDEFINITE|CHANGED");
    assert_positive(changed, 10);
    mbsr_flex_def a, b;
    assert_int_equal(mbsr_flex_definition(flex, &a), MBSR_OK);
    assert_int_equal(mbsr_flex_definition(changed, &b), MBSR_OK);
    assert_same(9, a.N0, b.N0, 1e-14);
    assert_same(100, a.Mf, b.Mf, 1e-15);
    written = write(changed); /* what has been changed is not changed again */
    assert_ok(mbsr_sid_read(written->text, written->size, NULL, NULL, &again, NULL, &error),
              &error);
    assert_same_data(changed, again, 1e-13);
    mbsr_flex_destroy(again);
    mbsr_sid_text_destroy(written);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(changed);
    free(more);

    /* terms of first and second order that do not fit: M(0) stays as it is */
    static const struct {
        const char *block, *order;
        double factor;
    } wrong[] = {{"Oe", "m1", 1.4}, {"Cr", "m1", 3.0}, {"J", "m1", 1.5}, {"Oe", "m1", -1.0}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        more = test_sid_scaled(text->text, wrong[k].block, wrong[k].order, wrong[k].factor);
        refuse_text(more, NULL, MBSR_ERR_VALUE, "do not fit|MBSR_SID_SECOND_ORDER");
        opt.change = MBSR_SID_SECOND_ORDER;
        assert_ok(mbsr_sid_read(more, strlen(more), NULL, &opt, &changed, &report, &error), &error);
        assert_close(report->keep_coupling, 1.0, 0.0);
        assert_less(1e-3, report->changed_P);
        assert_int_equal(mbsr_flex_mass_matrix(changed, rest, M), MBSR_OK);
        assert_same(16 * 16, expected, M, 1e-13);
        assert_positive(changed, 10);
        mbsr_sid_report_destroy(report);
        mbsr_flex_destroy(changed);
        free(more);
    }

    more = test_sid_scaled(text->text, "J", "m0", 0.5);
    opt.change = MBSR_SID_COUPLING;
    refuse_text(more, &opt, MBSR_ERR_VALUE, "mass, mdCM and J are those of no body|eigenvalue");
    free(more);
    more = test_sid_scaled(text->text, "Ke", "m0", -1.0);
    refuse_text(more, &opt, MBSR_ERR_VALUE, "K is indefinite");
    free(more);
    more = test_sid_scaled(text->text, "Me", "m0", -1.0);
    refuse_text(more, &opt, MBSR_ERR_VALUE, "modal mass Me(1,1) is -1");
    free(more);
    mbsr_sid_text_destroy(text);
    mbsr_flex_destroy(flex);
}

/* `small` with one piece in the place of another. */
static void refuse_instead(const char *piece, const char *other, const char *words)
{
    char text[sizeof test_small_sid + 200];
    const char *at = strstr(test_small_sid, piece);
    assert_non_null(at);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - test_small_sid), test_small_sid, other,
             at + strlen(piece));
    refuse_text(text, NULL, MBSR_ERR_FILE, words);
}

static void errors_have_lines(void **state)
{
    (void)state;
    refuse_text("", NULL, MBSR_ERR_FILE, "b.SID:0: the file is empty");
    refuse_text("2\n", NULL, MBSR_ERR_FILE, "b.SID:1: the line ends, the number of modes");
    refuse_text("2 999 :\n", NULL, MBSR_ERR_FILE, "at most 250");
    refuse_text("2 1 :\nport\n", NULL, MBSR_ERR_FILE, "b.SID:2: 'port' where 'part'");
    refuse_text("2 1 :\npart\nnew modal =\n", NULL, MBSR_ERR_FILE, "b.SID:3: the file ends");
    refuse_instead("    2   1 ", "    3   1 ", "says 3 nodes, but there are 2");
    refuse_instead("nelastq                         =     1", "nelastq = 2",
                   "b.SID:6: nelastq is 2");
    refuse_instead("mass  ", "moss  ", "b.SID:5: 'moss' where");
    refuse_instead("2.00000000000D+00", "2,D", "b.SID:5:");
    refuse_instead("ielastq (   1)", "ielastq (   2)", "'ielastq(2)' is no mode of the 1");
    refuse_instead("new node = 7", "new node = x", "b.SID:10: 'x' is no number");
    refuse_instead("rframe = body ref\n", "frame\n", "b.SID:11: 'frame' where 'rframe|origin");
    refuse_instead("nrow = 3", "nrow = 4", "origin is 4 x 1 with 1 modes, must be 3 x 1 with 1");
    refuse_instead("ncol = 1", "nrow = 1", "'nrow' where 'ncol' is wanted");
    refuse_instead("structure = 3", "structure = 5", "the structure of origin is 5");
    refuse_instead("m0( 1, 1) = 1.0D+00", "m0( 4, 1) = 1.0", "'m0(4,1)' is no entry of origin");
    refuse_instead("m1( 2, 1, 1) = 1.0D+00", "m1( 2, 2, 1) = 1", "'m1(2,2,1)' is no entry");
    refuse_instead("m0( 1, 1) = 1.0D+00", "m0( 1, 1)", "the line ends, a value");
    refuse_instead("m0( 1, 1) = 1.0D+00", "m0( 1, 1) = nan", "'nan' is no number");
    refuse_instead("phi\norder=0\nnrow=3\nncol=1\nnq=1\nnqn=0\nstructure=0\nend phi\n", "",
                   "node 7 has no phi");
    refuse_instead("mdCM\n", "mdCN\n", "'mdCN' is nothing that a SID file has");
    refuse_instead("Ct\norder=0\nnrow=1\nncol=3\nnq=1\nnqn=0\nstructure=3\nm0(1,2)=0.5\nend Ct\n",
                   "", "Ct is not in the file");
    refuse_instead("end Me\n", "end Me\nMe\n", "Me is there twice");
    refuse_instead("structure=0\nend ksigma", "structure=3\nm0(1,1)=5\nend ksigma",
                   "ksigma(1,1) is 5");
    refuse_instead("end modal\nend part\n", "end modal\n", "the file ends before 'end part'");
}

static void wrong_calls_and_no_memory(void **state)
{
    (void)state;
    mbsr_flex *flex = make_beam(), *again;
    mbsr_sid_text *text = write(flex), *other;
    mbsr_sid_report *report;
    mbsr_error error;
    mbsr_sid_opt opt = mbsr_default_sid_opt();
    const mbsr_allocator half = {.allocate = test_counting_allocate};
    assert_int_equal(mbsr_sid_read(NULL, 0, NULL, NULL, &again, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sid_read("", 0, NULL, NULL, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sid_write(NULL, NULL, NULL, &other, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sid_write(flex, NULL, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_sid_write(flex, NULL, &half, &other, NULL), MBSR_ERR_VALUE);
    opt.change = (mbsr_sid_change)3;
    refuse_text(test_small_sid, &opt, MBSR_ERR_VALUE, "opt.change is 3");
    opt.change = MBSR_SID_NOTHING, opt.allocator = half;
    refuse_text(test_small_sid, &opt, MBSR_ERR_VALUE, "opt.allocator");
    opt.cookie = 0;
    refuse_text(test_small_sid, &opt, MBSR_ERR_NO_DEFAULT, "mbsr_default_sid_opt");
    opt = mbsr_default_sid_opt();
    test_counting counting;
    int k = 1;
    for (; k < 500; ++k) {
        counting = (test_counting){.fail_at = k};
        opt.allocator = test_counting_allocator(&counting);
        const int status =
            mbsr_sid_read(text->text, text->size, NULL, &opt, &again, &report, &error);
        if (!counting.failed) {
            assert_ok(status, &error);
            break;
        }
        assert_refused(status, &error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "memory");
        assert_null(report);
        assert_int_equal(counting.live, 0);
    }
    assert_true(k > 4 && k < 500);
    mbsr_sid_report_destroy(report);
    mbsr_flex_destroy(again);
    for (k = 1; k < 10; ++k) {
        counting = (test_counting){.fail_at = k};
        const mbsr_allocator allocator = test_counting_allocator(&counting);
        const int status = mbsr_sid_write(flex, NULL, &allocator, &other, &error);
        if (!counting.failed) {
            assert_string_equal(other->text + other->size - 10, " end part\n");
            mbsr_sid_text_destroy(other);
            break;
        }
        assert_refused(status, &error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "memory");
        assert_int_equal(counting.live, 0);
    }
    mbsr_sid_report_destroy(NULL);
    mbsr_sid_text_destroy(NULL);
    mbsr_beam_def stiffened = mbsr_default_beam_def();
    stiffened.length = stiffened.density = stiffened.EI_z = 1.0, stiffened.stiffening = 1;
    assert_ok(mbsr_flex_beam(&stiffened, &again, &error), &error);
    assert_refused(mbsr_sid_write(again, NULL, NULL, &other, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "dependent shapes");
    mbsr_flex_destroy(again);
    mbsr_sid_text_destroy(text);
    mbsr_flex_destroy(flex);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(written_matrices_are_those_of_the_mass_matrix),
        cmocka_unit_test(files_of_others),
        cmocka_unit_test(data_of_no_body),
        cmocka_unit_test(errors_have_lines),
        cmocka_unit_test(wrong_calls_and_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
