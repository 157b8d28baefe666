/* Models that no body can have are refused with the number and the place.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "solid.h"

#include <stdio.h>

static void refuse(const mbsr_fe_def *def, int status, const char *words)
{
    mbsr_flex *flex;
    mbsr_fe_report *report;
    mbsr_error error;
    assert_refused(mbsr_fe_reduce(def, &flex, &report, &error), &error, status, MBSR_NONE,
                   MBSR_NONE, words);
    assert_true(strlen(error.text) < MBSR_TEXT_SIZE - 1); /* not cut short */
    assert_null(flex);
    assert_null(report);
    assert_int_equal(mbsr_fe_reduce(def, &flex, NULL, NULL), status);
}

/* By both solvers. */
static void refuse_all(const mbsr_fe_def *given, const char *words)
{
    mbsr_fe_def def = *given;
    for (int solver = MBSR_FE_DENSE; solver <= test_solvers; ++solver) {
        def.solver = (mbsr_fe_solver)solver;
        refuse(&def, MBSR_ERR_VALUE, words);
    }
}

/* The first entry at (row, column). */
static int entry(const test_solid *s, int row, int column)
{
    int k = 0;
    while (s->mesh.row[k] != row || s->mesh.column[k] != column) ++k;
    return k;
}

static void stiffness(void **state)
{
    (void)state;
    test_solid *s = test_bar(3, 1, 1);
    double *value = malloc((size_t)s->mesh.entries * sizeof *value);
    const size_t all = (size_t)s->mesh.entries * sizeof *value;
    memcpy(value, s->mesh.K, all);
    s->def.K.value = value;

    value[entry(s, 7, 7)] += 1e-3 * value[entry(s, 7, 7)]; /* a spring to ground */
    refuse_all(&s->def, "K is grounded|rotation about x|dof 7 (node 2, direction 1)|def.rigid");
    s->def.rigid = 1e-2;
    mbsr_flex *flex;
    mbsr_error error;
    assert_ok(mbsr_fe_reduce(&s->def, &flex, NULL, &error), &error);
    mbsr_flex_destroy(flex);
    s->def.rigid = 1e-8;

    for (int k = 0; k < s->mesh.entries; ++k) value[k] = -s->mesh.K[k];
    refuse_all(&s->def, "6|stiffness"); /* nothing positive to hold it at */
    memcpy(value, s->mesh.K, all);
    value[5] = NAN;
    refuse_all(&s->def, "K(|nan");
    value[5] = INFINITY;
    refuse_all(&s->def, "K(|inf");
    free(value);
    test_solid_destroy(s);
}

/* A particle that nothing holds; two bars that nothing joins. Large enough for CHOLMOD's
 * supernodes, and too small. */
static void mechanisms_of(int nx, int ny, int nz)
{
    test_solid *s = test_bar(nx, ny, nz);
    const int nodes = s->mesh.nodes, elements = nx * ny * nz, each = s->mesh.entries / elements;
    double *x = calloc(3 * (size_t)nodes + 3, sizeof *x),
           *value = malloc((size_t)s->mesh.entries * sizeof *value);
    char words[60];
    memcpy(x, s->mesh.x, 3 * (size_t)nodes * sizeof *x);
    x[3 * nodes] = 2.0;
    s->def.x = x;
    s->def.nodes = nodes + 1;
    s->def.K.rows = s->def.M.rows = s->mesh.dofs + 3;
    snprintf(words, sizeof words, "mechanism|node %d,|joined", nodes);
    refuse_all(&s->def, words);

    /* a layer of elements in the middle is left out */
    s->def.nodes = nodes;
    s->def.K.rows = s->def.M.rows = s->mesh.dofs;
    for (int k = 0; k < s->mesh.entries; ++k)
        value[k] = k / each / (ny * nz) == nx / 2 ? 0.0 : s->mesh.K[k];
    s->def.K.value = value;
    refuse_all(&s->def, "mechanism");

    /* a direction of negative stiffness, which costs rigid motions nothing */
    for (int k = 0; k < s->mesh.entries; ++k)
        value[k] = (k / each == elements / 2 ? -3.0 : 1.0) * s->mesh.K[k];
    refuse_all(&s->def, "indefinite");
    free(x);
    free(value);
    test_solid_destroy(s);
}

static void mechanisms(void **state)
{
    (void)state;
    mechanisms_of(3, 1, 1);
    mechanisms_of(20, 4, 3);
}

static void mass(void **state)
{
    (void)state;
    test_solid *s = test_bar(3, 1, 1);
    double *value = malloc((size_t)s->mesh.entries * sizeof *value);
    const size_t all = (size_t)s->mesh.entries * sizeof *value;
    s->def.M.value = value;

    memcpy(value, s->mesh.M, all);
    for (int c = 0; c < 3; ++c) value[entry(s, 6 + c, 6 + c)] -= 0.9;
    refuse_all(&s->def, "M is indefinite|node 2");
    memcpy(value, s->mesh.M, all);
    for (int c = 0; c < 3; ++c) { /* what stays positive on the diagonal */
        const int k = entry(s, 9 + c, 6 + c);
        value[k] += 3.0 * fabs(s->mesh.M[entry(s, 6 + c, 6 + c)]);
    }
    refuse_all(&s->def, "M is indefinite|elimination|direction");
    memcpy(value, s->mesh.M, all);
    value[entry(s, 6, 6)] += 0.1;
    refuse_all(&s->def, "along x, y, z it has 6.34, 6.24, 6.24");
    memset(value, 0, all); /* no mass: static modes, and none when free */
    mbsr_flex *flex;
    mbsr_error error;
    mbsr_flex_def data;
    assert_ok(mbsr_fe_reduce(&s->def, &flex, NULL, &error), &error);
    assert_int_equal(mbsr_flex_definition(flex, &data), MBSR_OK);
    assert_int_equal(data.modes, 6);
    mbsr_flex_destroy(flex);
    s->def.free = 1;
    refuse_all(&s->def, "no mass|def.free");
    s->def.free = 0;
    value[entry(s, 9, 6)] = 1e-3;
    refuse_all(&s->def, "M is indefinite|beside a zero");
    free(value);
    test_solid_destroy(s);
}

static void shapes(void **state)
{
    (void)state;
    test_solid *s = test_bar(2, 1, 1);
    const int row[3] = {0, 1, 0}, column[3] = {0, 0, 1};
    const double value[3] = {1.0, 2.0, 2.5};
    const mbsr_fe_def good = s->def;
    mbsr_fe_def def = good;
    def.K =
        (mbsr_fe_matrix){.rows = 36, .entries = 3, .row = row, .column = column, .value = value};
    refuse(&def, MBSR_ERR_VALUE, "K has entries on both sides of the diagonal|whole is 0");
    def.K.whole = 1;
    refuse(&def, MBSR_ERR_VALUE, "K is not symmetric: (1,0) is 2, (0,1) is 2.5");
    def.K.rows = 1;
    refuse(&def, MBSR_ERR_VALUE, "K has an entry at (1,0), but 1 rows");
    def.K.column = NULL;
    refuse(&def, MBSR_ERR_NULL, "K.start and column");
    const int start[3] = {0, 4, 3}, wrong[3] = {0, 2, 2}, below[3] = {0, -1, 3};
    def.K.start = start, def.K.rows = 2;
    refuse(&def, MBSR_ERR_VALUE, "K.start[2]");
    def.K.start = below;
    refuse(&def, MBSR_ERR_VALUE, "K.start[1] is -1");
    def.K.start = wrong;
    refuse(&def, MBSR_ERR_VALUE, "from 0 to 2");
    def.K.rows = 0;
    refuse(&def, MBSR_ERR_VALUE, "K.rows is 0");
    def = good;
    def.M.rows = 33;
    refuse(&def, MBSR_ERR_VALUE, "M has an entry at");
    def.M.rows = 39;
    refuse(&def, MBSR_ERR_VALUE, "K has 36 rows, M 39");
    def = good;
    def.M.value = NULL;
    refuse(&def, MBSR_ERR_NULL, "M.value");
    def = good;
    def.nodes = 11;
    refuse(&def, MBSR_ERR_VALUE, "36 rows for 11 nodes|dof_node");
    test_solid_destroy(s);
}

static void dofs_and_markers(void **state)
{
    (void)state;
    test_solid *s = test_bar(2, 1, 1);
    const int nodes = s->mesh.nodes, n = s->mesh.dofs;
    int *id = malloc((size_t)nodes * sizeof *id), *node = malloc((size_t)n * sizeof *node),
        *direction = malloc((size_t)n * sizeof *direction);
    for (int k = 0; k < nodes; ++k) id[k] = 100 + 7 * ((5 * k) % nodes);
    for (int k = 0; k < n; ++k) node[k] = id[k / 3], direction[k] = k % 3;
    for (int end = 0; end < 2; ++end) {
        for (int k = 0; k < 4; ++k) s->ends[end][k] = id[s->ends[end][k]];
    }
    s->def.id = id, s->def.dof_node = node, s->def.dof_direction = direction;
    mbsr_flex *flex;
    mbsr_error error;
    assert_ok(mbsr_fe_reduce(&s->def, &flex, NULL, &error), &error);
    mbsr_flex_destroy(flex);

    direction[4] = 2;
    refuse(&s->def, MBSR_ERR_VALUE, "dofs 4 and 5 are both direction 2 of node 135");
    direction[4] = 6;
    refuse(&s->def, MBSR_ERR_VALUE, "dof_direction[4] is 6");
    direction[4] = 4;
    refuse(&s->def, MBSR_ERR_VALUE, "node 135 has no dof of direction 1");
    direction[4] = 1;
    node[4] = 99;
    refuse(&s->def, MBSR_ERR_VALUE, "dof_node[4] is 99|no such node");
    node[4] = id[1];
    direction[3] = 1, direction[4] = 0; /* rows of x and y exchanged */
    refuse(&s->def, MBSR_ERR_VALUE, "K is grounded");
    direction[3] = 0, direction[4] = 1;
    const int kept = id[3];
    id[3] = id[2];
    refuse(&s->def, MBSR_ERR_VALUE, "is there twice|node[2] and node[3]");
    id[3] = kept;
    s->def.dof_direction = NULL;
    refuse(&s->def, MBSR_ERR_NULL, "dof_direction");
    s->def.dof_direction = direction;

    s->marker[1].nodes = 2;
    refuse(&s->def, MBSR_ERR_VALUE, "marker[1] 'tip' lie on a line");
    s->marker[1].nodes = 0;
    refuse(&s->def, MBSR_ERR_VALUE, "marker[1] 'tip' has 0 nodes");
    s->marker[1].nodes = 4;
    s->ends[1][2] = 5;
    refuse(&s->def, MBSR_ERR_VALUE, "marker[1] 'tip' names node 5, which is not there");
    s->ends[1][2] = s->ends[1][0];
    s->marker[0].nodes = 1;
    refuse(&s->def, MBSR_ERR_VALUE, "marker[0] 'root', the root|three or more");
    free(id);
    free(node);
    free(direction);
    test_solid_destroy(s);
}

static void options(void **state)
{
    (void)state;
    test_solid *s = test_bar(1, 1, 1);
    const mbsr_fe_def good = s->def;
    mbsr_fe_def def = good;
    def.modes = MBSR_MAX_MODES - 5;
    refuse(&def, MBSR_ERR_VALUE, "modes is 245, 1 markers are loaded|250");
    def = good, def.modes = -1;
    refuse(&def, MBSR_ERR_VALUE, "modes is -1");
    def = good, def.frequency = NAN;
    refuse(&def, MBSR_ERR_VALUE, "frequency is nan");
    def = good, def.cutoff = -1.0;
    refuse(&def, MBSR_ERR_VALUE, "cutoff -1");
    def = good, def.damping = INFINITY;
    refuse(&def, MBSR_ERR_VALUE, "damping is inf");
    def = good, def.rigid = 1.0;
    refuse(&def, MBSR_ERR_VALUE, "rigid is 1");
    def = good, def.tolerance = 0.0;
    refuse(&def, MBSR_ERR_VALUE, "tolerance is 0");
    def = good, def.solver = (mbsr_fe_solver)3;
    refuse(&def, MBSR_ERR_VALUE, "solver is 3");
    def = good, def.markers = 0;
    refuse(&def, MBSR_ERR_VALUE, "markers 0");
    def = good, def.x = NULL;
    refuse(&def, MBSR_ERR_NULL, "x is NULL");
    def = good, def.cookie = 0;
    refuse(&def, MBSR_ERR_NO_DEFAULT, "mbsr_default_fe_def");
    def = good, def.allocator.allocate = (void *(*)(void *, size_t))1;
    refuse(&def, MBSR_ERR_VALUE, "allocator");
    mbsr_flex *flex;
    mbsr_error error;
    assert_refused(mbsr_fe_reduce(NULL, &flex, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "def");
    assert_refused(mbsr_fe_reduce(&good, NULL, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "flex");
    test_solid_destroy(s);
}

/* Without CHOLMOD. */
static void large_models(void **state)
{
    (void)state;
    if (test_solvers > MBSR_FE_DENSE) skip();
    test_solid *s = test_bar(46, 5, 5);
    assert_true(s->mesh.dofs > 5000);
    refuse(&s->def, MBSR_ERR_UNAVAILABLE, "5076 dofs|CHOLMOD");
    test_solid_destroy(s);
    s = test_bar(1, 1, 1);
    s->def.solver = MBSR_FE_SPARSE;
    refuse(&s->def, MBSR_ERR_UNAVAILABLE, "24 dofs|CHOLMOD");
    test_solid_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stiffness),
        cmocka_unit_test(mechanisms),
        cmocka_unit_test(mass),
        cmocka_unit_test(shapes),
        cmocka_unit_test(dofs_and_markers),
        cmocka_unit_test(options),
        cmocka_unit_test(large_models),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
