/* Models from texts: Matrix Market, nodes, dofs, markers, and what is refused, with the line.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "locale_comma.h"

#include <mbsrank/fe.h>

#include <math.h>
#include <string.h>

/* A beam of one cubic element, EI = EA = GJ = L = 1, 1 kg at each end. */
static const char K[] =
    "%%MatrixMarket matrix coordinate real symmetric\n% stretch, torsion, bending\n\n12 12 26\n"
    "1 1 1\n7 1 -1\n7 7 1\n4 4 1\n10 4 -1\n10 10 1\n"
    "2 2 12\n6 2 6\n8 2 -12\n12 2 6\n6 6 4\n8 6 -6\n12 6 2\n8 8 12\n12 8 -6\n12 12 4\n"
    "3 3 12\n5 3 -6\n9 3 -12\n11 3 -6\n5 5 4\n9 5 6\n11 5 2\n9 9 12\n11 9 6\n11 11 4\n";
static const char M[] = "%%MatrixMarket matrix coordinate real general\n12 12 6\n"
                        "1 1 1.0\n2 2 1.0\n3 3 1e0\n7 7 1\n8 8 1D0\n9 9 10.0e-1\n";
static const char nodes[] = "# id x y z\r\n\r\n10 0 0 0\r\n20, 1.0, 0.0, 0.0\r\n";
static const char dofs[] =
    "10 1\n10 2\n10 3\n10.4\n10.5\n10.6\n20 1\n20 2\n20 3\n20 4\n20 5\n20 6\n";
static const char markers[] = "root node 10\ntip node 20\n";

static mbsr_fe_text text(const char *t)
{
    return (mbsr_fe_text){.text = t, .size = strlen(t)};
}

static mbsr_fe_files files(void)
{
    return (mbsr_fe_files){.K = text(K),
                           .M = text(M),
                           .nodes = text(nodes),
                           .dofs = text(dofs),
                           .markers = text(markers)};
}

/* One mass at the end of a beam: omega^2 = 3 EI / L^3 both ways, EA / L along. */
static void assert_reduces(const mbsr_fe_files *f)
{
    mbsr_fe_input *input;
    mbsr_flex *flex;
    mbsr_fe_report *report;
    mbsr_error error;
    assert_ok(mbsr_fe_read(f, NULL, &input, &error), &error);
    assert_int_equal(input->marker[0].loaded, 0);
    assert_int_equal(input->marker[1].loaded, 1);
    assert_int_equal(input->def.nodes, 2);
    assert_ok(mbsr_fe_reduce(&input->def, &flex, &report, &error), &error);
    assert_int_equal(report->normal, 3);
    assert_close(report->omega[0], 1.0, 1e-12);
    assert_close(report->omega[1], sqrt(3.0), 1e-12);
    assert_close(report->omega[2], sqrt(3.0), 1e-12);
    assert_int_equal(report->modes, 6);
    assert_close(report->mass, 2.0, 1e-14);
    mbsr_fe_report_destroy(report);
    mbsr_flex_destroy(flex);
    mbsr_fe_input_destroy(input);
}

static void good_files(void **state)
{
    (void)state;
    mbsr_fe_files f = files();
    assert_reduces(&f);
    if (test_locale_comma()) assert_reduces(&f);
    test_locale_back();
    f.dofs.text = NULL; /* six a node, in their order */
    assert_reduces(&f);
    f.D = text("%%MatrixMarket matrix coordinate integer symmetric\n12 12 3\n1 1 1\n7 1 -1\n7 7 1");
    assert_reduces(&f);
    f.markers = text("root average 10 20 10\n");
    mbsr_fe_input *input;
    mbsr_error error;
    assert_ok(mbsr_fe_read(&f, NULL, &input, &error), &error);
    assert_int_equal(input->marker[0].nodes, 3);
    assert_int_equal(input->marker[0].node[2], 10);
    mbsr_fe_input_destroy(input);
}

static void refuse(const mbsr_fe_files *f, const char *words)
{
    mbsr_fe_input *input;
    mbsr_error error;
    assert_refused(mbsr_fe_read(f, NULL, &input, &error), &error, MBSR_ERR_FILE, MBSR_NONE,
                   MBSR_NONE, words);
    assert_null(input);
    assert_true(strlen(error.text) < MBSR_TEXT_SIZE - 1);
}

static void matrices_are_refused(void **state)
{
    (void)state;
#define HEAD "%%MatrixMarket matrix coordinate real symmetric\n"
    static const struct {
        const char *text, *words;
    } bad[] = {
        {"", "K.mtx:0: |empty"},
        {"MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 1\n",
         "K.mtx:1: 'MatrixMarket'"},
        {"%%MatrixMarket matrix array real general\n1 1\n1\n", "'array'|'coordinate' is wanted"},
        {"%%MatrixMarket matrix coordinate complex symmetric\n1 1 1\n", "'complex'|'real'"},
        {"%%MatrixMarket matrix coordinate real skew-symmetric\n1 1 1\n", "'skew-symmetric'"},
        {HEAD, "K.mtx:1: the file ends before its size"},
        {HEAD "3 3\n", "K.mtx:2: the line ends, the number of entries"},
        {HEAD "3 4 1\n1 1 1\n", "3 x 4|square"},
        {HEAD "3 3 1 1\n1 1 1\n", "'1' is one thing more"},
        {HEAD "3 3 1.5\n1 1 1\n", "1.5 is no whole number"},
        {HEAD "3 3 1000000\n1 1 1\n", "1000000 entries cannot stand in the 6 bytes|cut short"},
        {HEAD "1 1 2\n% here\n1 1 1.0000\n", "K.mtx:4: the file ends after 1 of 2 entries"},
        {HEAD "1 1 1\n1 1 1\n1 1 1\n", "K.mtx:4: more than 1 entries"},
        {HEAD "1 1 1\n1 2 1\n", "K.mtx:3: entry (1,2) of a matrix of 1 rows"},
        {HEAD "2 2 1\n1 2 1\n", "(1,2) above the diagonal"},
        {HEAD "1 1 1\n1 1 nan\n", "'nan' is no number; a value"},
        {HEAD "1 1 1\n1 1 1e999\n", "K.mtx:3: '1e999' is no number"},
        {HEAD "1 1 1\n1 1\n", "K.mtx:3: the line ends, a value"},
        {HEAD "900000000 900000000 1\n1 1 1\n", "K.mtx: K has 900000000 rows and 1 entries"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        mbsr_fe_files f = files();
        f.K = text(bad[k].text);
        f.K.name = "K.mtx";
        refuse(&f, bad[k].words);
    }
    mbsr_fe_files f = files();
    f.M = text(HEAD "11 11 1\n1 1 1\n");
    refuse(&f, "M: M has 11 rows|K 12 rows");
    f = files();
    f.K.size -= 40;
    refuse(&f, "K:|entries");
#undef HEAD
}

static void lists_are_refused(void **state)
{
    (void)state;
    static const struct {
        int which;
        const char *text, *words;
    } bad[] = {
        {0, "# none\n", "nodes:1: there are no nodes"},
        {0, "1 0 0\n", "nodes:1: the line ends, z"},
        {0, "1 0 0 0 0\n", "nodes:1: '0' is one thing more"},
        {0, "1 0 x 0\n", "'x' is no number; y"},
        {0, "99999999999 0 0 0\n", "no whole number"},
        {1, "10 1\n", "dofs:1: the file ends after 1 dofs, but K has 12 rows"},
        {1, "10 7\n", "direction 7, must be 1 .. 6"},
        {1, "10.0\n", "direction 0"},
        {1, "10.x\n", "dofs:1: 'x' is no number"},
        {1, "10\n", "the line ends, a direction"},
        {1, "10 1\n10 2\n10 3\n10 4\n10 5\n10 6\n20 1\n20 2\n20 3\n20 4\n20 5\n20 6\n20 6\n",
         "dofs:13: more dofs than the 12 rows"},
        {2, "", "there are no markers"},
        {2, "root\n", "'node' or 'average'"},
        {2, "root point 10\n", "markers:1: 'point'"},
        {2, "root node\n", "marker 'root' has 0 nodes; 'node' takes one"},
        {2, "root average 10 20\n", "has 2 nodes; 'average' takes three"},
        {2, "root node 1.5\n", "no whole number"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        mbsr_fe_files f = files();
        mbsr_fe_text *const to[3] = {&f.nodes, &f.dofs, &f.markers};
        *to[bad[k].which] = text(bad[k].text);
        refuse(&f, bad[k].words);
    }
}

static void wrong_calls(void **state)
{
    (void)state;
    mbsr_fe_files f = files();
    mbsr_fe_input *input;
    mbsr_error error;
    const mbsr_allocator half = {.allocate = test_counting_allocate};
    assert_int_equal(mbsr_fe_read(NULL, NULL, &input, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_fe_read(&f, NULL, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_fe_read(&f, &half, &input, &error), MBSR_ERR_VALUE);
    f.nodes.text = NULL;
    assert_refused(mbsr_fe_read(&f, NULL, &input, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "files.nodes.text");
    f = files();
    for (int k = 1; k < 100; ++k) {
        test_counting counting = {.fail_at = k};
        const mbsr_allocator allocator = test_counting_allocator(&counting);
        const int status = mbsr_fe_read(&f, &allocator, &input, &error);
        if (!counting.failed) {
            assert_ok(status, &error);
            mbsr_fe_input_destroy(input);
            break;
        }
        assert_int_equal(status, MBSR_ERR_NO_MEMORY);
        assert_int_equal(counting.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_files),
        cmocka_unit_test(matrices_are_refused),
        cmocka_unit_test(lists_are_refused),
        cmocka_unit_test(wrong_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
