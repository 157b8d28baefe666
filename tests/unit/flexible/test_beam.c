/* Beams: frequencies and deflections in closed form, what static modes make exact, which modes have
 * mass, and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "counting.h"

#include <string.h>

/* Of a cantilever with L = EI = density = 1 that bends in a plane. */
static const double frequency[4] = {3.516015268500, 22.034491564667, 61.697214413549,
                                    120.901916052306};

static mbsr_beam_def unit_beam(int modes)
{
    mbsr_beam_def def = mbsr_default_beam_def();
    def.length = def.density = def.EI_z = 1.0;
    def.modes = modes;
    return def;
}

static mbsr_flex *make(const mbsr_beam_def *def, mbsr_flex_def *data)
{
    mbsr_flex *flex;
    mbsr_error error;
    assert_ok(mbsr_flex_beam(def, &flex, &error), &error);
    assert_int_equal(mbsr_flex_definition(flex, data), MBSR_OK);
    return flex;
}

/* Deflection of a marker along `axis` under a unit load there: sum of Phi^2 / K. */
static double flexibility(const mbsr_flex_def *data, int marker, int axis)
{
    double sum = 0.0;
    for (int a = 0; a < data->modes; ++a) {
        const double Phi = data->marker[marker].Phi[3 * a + axis];
        sum += Phi * Phi / data->K[a * (data->modes + 1)];
    }
    return sum;
}

static void frequencies_are_those_of_a_cantilever(void **state)
{
    (void)state;
    static const double fe[3] = {3.51601586, 22.03463712, 61.70038314};
    mbsr_beam_def def = unit_beam(4);
    mbsr_flex_def data;
    mbsr_flex *flex = make(&def, &data);
    assert_int_equal(data.modes, 4);
    assert_int_equal(data.markers, 16);
    for (int j = 0; j < 4; ++j) {
        const double omega = sqrt(data.K[5 * j]), tip = data.marker[15].Phi[3 * j + 1];
        if (j < 3) assert_close(omega, fe[j], 6e-9);
        assert_close(omega, frequency[j], 2e-4 * frequency[j]);
        assert_close(tip * tip, 4.0, 1e-3 * (j < 3 ? 1.0 : 4.0));
        assert_close(data.Mf[5 * j], 1.0, 1e-9);
    }
    assert_close(data.mass, 1.0, 1e-14);
    assert_close(data.c0[0], 0.5, 1e-14);
    assert_close(data.N0[0], 1.0 / 3.0, 1e-14);
    mbsr_flex_destroy(flex);

    /* errors fall with the fourth power of the length of an element */
    def.elements = 40;
    flex = make(&def, &data);
    const double finer = pow(15.0 / 40.0, 4.0);
    for (int j = 0; j < 4; ++j) {
        const double tip = data.marker[40].Phi[3 * j + 1];
        assert_close(sqrt(data.K[5 * j]), frequency[j], 2e-4 * finer * frequency[j]);
        assert_close(tip * tip, 4.0, 4e-3 * finer);
    }
    mbsr_flex_destroy(flex);
}

/* Of a rod that stretches: (k + 1/2) pi, too high as (h omega)^2 / 24, h the length of an element.
 */
static void frequencies_of_stretching_converge_slowly(void **state)
{
    (void)state;
    for (int elements = 15; elements <= 40; elements += 25) {
        mbsr_beam_def def = unit_beam(4);
        mbsr_flex_def data;
        def.EI_z = 0.0, def.EA = 1.0, def.elements = elements;
        mbsr_flex *flex = make(&def, &data);
        for (int k = 0; k < 4; ++k) {
            const double exact = (k + 0.5) * acos(-1.0), angle = exact / elements,
                         error = sqrt(data.K[5 * k]) / exact - 1.0;
            assert_close(error, angle * angle / 24.0, 0.03 * error);
        }
        mbsr_flex_destroy(flex);
    }
}

/* Its mass is on its axis: nothing turns with it about that, and the texts say what would. */
static void a_beam_in_flight_lacks_inertia_about_its_axis(void **state)
{
    (void)state;
    for (int given = 0; given < 2; ++given) {
        mbsr_beam_def def = unit_beam(2);
        mbsr_flexible_def on = mbsr_default_flexible_def();
        mbsr_flex_def data;
        mbsr_index_report *report;
        mbsr_model *m;
        mbsr_data *d;
        double y[64], yp[64];
        const double q[9] = {1.0}, u[8] = {0.0, 0.0, 1.0};
        def.radius_y = given ? 0.01 : 0.0;
        on.flex = make(&def, &data);
        on.joint = mbsr_joint_free(NULL, NULL);
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        assert_ok(mbsr_model_add_flexible(m, &on, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        const int status = mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
        assert_int_equal(status, given ? MBSR_OK : MBSR_UNDETERMINED);
        if (!given) assert_contains(mbsr_data_error(d)->text, "radius_y|radius_z");
        assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->undetermined, !given);
        if (!given) assert_contains(report->text, "radius_y|radius_z");
        mbsr_index_report_destroy(m, report);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
        mbsr_flex_destroy((mbsr_flex *)on.flex);
    }
}

/* k normal modes miss 1 - sum 12 / lambda^4 of the deflection under a tip load F L^3 / 3 EI. */
static void static_modes_make_deflections_exact(void **state)
{
    (void)state;
    static const double missed[3] = {0.0293118199, 0.0045959911, 0.0014435271};
    const int tip = 15;
    mbsr_flex_def data;
    for (int k = 1; k <= 3; ++k) {
        mbsr_beam_def def = unit_beam(k);
        mbsr_flex *flex = make(&def, &data);
        assert_close(1.0 - 3.0 * flexibility(&data, tip, 1), missed[k - 1], 1e-6);
        mbsr_flex_destroy(flex);
        def.loaded = 1, def.node = &tip;
        for (int massive = 0; massive < 2; ++massive) {
            def.cutoff = massive ? INFINITY : 0.0;
            flex = make(&def, &data);
            assert_int_equal(data.modes, k + 2); /* a force and a moment */
            assert_close(1.0 - 3.0 * flexibility(&data, tip, 1), 0.0, 1e-9);
            for (int a = k; a < k + 2; ++a)
                assert_close(data.Mf[a * (k + 3)], massive ? 1.0 : 0.0, massive ? 1e-9 : 0.0);
            mbsr_flex_destroy(flex);
        }
    }
}

/* Tension, bending both ways and torsion; a tip mass; what is stiff does not deform. */
static void beams_in_space(void **state)
{
    (void)state;
    const int nodes[2] = {8, 4};
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex_def data;
    def.length = 2.0, def.density = 3.0, def.elements = 8;
    def.EA = 5e4, def.EI_y = 40.0, def.EI_z = 70.0, def.GJ = 20.0;
    def.radius_y = 0.03, def.radius_z = 0.02;
    def.tip_mass = 0.5, def.damping = 0.01;
    def.modes = 6, def.loaded = 2, def.node = nodes;
    mbsr_flex *flex = make(&def, &data);
    assert_close(data.mass, 6.5, 1e-13);
    assert_close(data.N0[4], 6.0 * 0.03 * 0.03, 1e-15);
    assert_close(data.N0[8], 6.0 * 0.02 * 0.02, 1e-15);
    assert_close(data.N0[0], 6.0 * 4.0 / 3.0 + 0.5 * 4.0, 1e-13);
    for (int k = 0; k < 2; ++k) {
        const double x = nodes[k] * 0.25;
        assert_close(flexibility(&data, nodes[k], 0), x / 5e4, 1e-9 * x / 5e4);
        assert_close(flexibility(&data, nodes[k], 1), x * x * x / (3.0 * 70.0), 1e-10);
        assert_close(flexibility(&data, nodes[k], 2), x * x * x / (3.0 * 40.0), 1e-10);
    }
    int massless = 0;
    for (int a = 0; a < data.modes; ++a) {
        const double K = data.K[a * (data.modes + 1)], D = data.D[a * (data.modes + 1)];
        const int without = data.Mf[a * (data.modes + 1)] == 0.0;
        massless += without;
        if (!without) assert_close(D, 0.02 * sqrt(K), 1e-12 * sqrt(K));
        assert_true(D > 0.0);
    }
    assert_int_equal(massless, data.modes - 6);
    mbsr_flex_destroy(flex);

    def = unit_beam(10);
    def.frequency = 100.0;
    flex = make(&def, &data);
    assert_int_equal(data.modes, 3);
    mbsr_flex_destroy(flex);
    def.EI_z = 0.0;
    flex = make(&def, &data);
    assert_int_equal(data.modes, 0);
    mbsr_flex_destroy(flex);
}

/* Torsion of mass on the axis has none: its static mode is massless at any cutoff. */
static void torsion_without_radii_is_massless(void **state)
{
    (void)state;
    const int tip = 15;
    mbsr_beam_def def = unit_beam(4);
    mbsr_flex_def data;
    def.EI_z = 0.0, def.GJ = 2.0;
    def.loaded = 1, def.node = &tip, def.cutoff = INFINITY;
    mbsr_flex *flex = make(&def, &data);
    assert_int_equal(data.modes, 1);
    assert_true(data.Mf[0] == 0.0);
    const double Psi = data.marker[tip].Psi[0];
    assert_close(Psi * Psi / data.K[0], 0.5, 1e-12);
    mbsr_flex_destroy(flex);
}

static void refuse(const mbsr_beam_def *def, int status, const char *words)
{
    mbsr_flex *flex = (mbsr_flex *)&status;
    mbsr_error error = {0};
    assert_refused(mbsr_flex_beam(def, &flex, &error), &error, status, MBSR_NONE, MBSR_NONE, words);
    assert_null(flex);
}

/* Slopes v', w' of mode a at the ends and in the middle of the element before marker k: quadratic,
 * of the cubic through its markers. */
static void slopes(const mbsr_flex_def *data, int k, int a, double h, double x[2][3])
{
    for (int axis = 1; axis < 3; ++axis) {
        const double sign = axis == 1 ? 1.0 : -1.0;
        const mbsr_flex_marker *left = data->marker + k - 1, *right = data->marker + k;
        double *to = x[axis - 1];
        to[0] = sign * left->Psi[3 * a + 3 - axis];
        to[2] = sign * right->Psi[3 * a + 3 - axis];
        to[1] =
            1.5 * (right->Phi[3 * a + axis] - left->Phi[3 * a + axis]) / h - 0.25 * (to[0] + to[2]);
    }
}

/* int v_a' v_b' + w_a' w_b' over that element, exactly. */
static double shortening(const mbsr_flex_def *data, int k, int a, int b, double h)
{
    static const double product[3][3] = {{4.0, 2.0, -1.0}, {2.0, 16.0, 2.0}, {-1.0, 2.0, 4.0}};
    double x[2][3], y[2][3], sum = 0.0;
    slopes(data, k, a, h, x);
    slopes(data, k, b, h, y);
    for (int r = 0; r < 9; ++r) {
        for (int axis = 0; axis < 2; ++axis)
            sum += h / 30.0 * product[r / 3][r % 3] * x[axis][r / 3] * y[axis][r % 3];
    }
    return sum;
}

/* What the dependent shapes move the markers by, against the slopes between these. */
static void assert_shortened(const mbsr_flex_def *data, double h)
{
    const int n = data->modes, next = n + data->dependent + 1;
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < n; ++b) {
            const int massive = data->Mf[a * next] > 0.0 && data->Mf[b * next] > 0.0;
            double sum = 0.0, size = 0.0;
            for (int k = 1; k < data->markers; ++k) {
                double found = 0.0;
                for (int l = 0; l < data->dependent; ++l)
                    found += data->marker[k].Phi[3 * (n + l)] * data->Y[n * (n * l + a) + b];
                sum += massive ? shortening(data, k, a, b, h) : 0.0;
                size += sqrt(shortening(data, k, a, a, h) * shortening(data, k, b, b, h));
                assert_close(found, -sum, 1e-5 * size);
            }
        }
    }
}

static void beams_get_shorter_when_they_bend(void **state)
{
    (void)state;
    const int tip = 40;
    mbsr_beam_def def = unit_beam(3);
    mbsr_flex_def data, linear;
    def.elements = 40, def.stiffening = 1;
    mbsr_flex *flex = make(&def, &data);
    assert_int_equal(data.dependent, 6);
    /* of the first mode of a cantilever int phi'^2 is 4.6478 (Blevins) */
    double first = 0.0;
    for (int l = 0; l < data.dependent; ++l)
        first += data.marker[tip].Phi[3 * (3 + l)] * data.Y[9 * l];
    assert_close(first, -4.6478, 1e-4);
    assert_shortened(&data, 1.0 / 40);
    mbsr_flex_destroy(flex);

    def.elements = 40, def.modes = 5, def.EI_y = 2.0, def.EA = 1e3, def.GJ = 1.0;
    def.radius_y = def.radius_z = 0.02, def.tip_mass = 0.3;
    def.loaded = 1, def.node = &tip;
    flex = make(&def, &data);
    assert_shortened(&data, 1.0 / 40);
    def.stiffening = 0;
    mbsr_flex *without = make(&def, &linear);
    assert_int_equal(linear.dependent, 0);
    assert_null(linear.Y);
    assert_int_equal(linear.modes, data.modes);
    for (int a = 0; a < 3 * data.modes; ++a) assert_close(linear.Ct0[a], data.Ct0[a], 1e-15);
    mbsr_flex_destroy(without);
    mbsr_flex_destroy(flex);

    def = unit_beam(70);
    def.elements = 40, def.stiffening = 1;
    refuse(&def, MBSR_ERR_VALUE, "dependent shapes for 70 modes|4096|fewer modes");
}

static void what_is_no_beam_is_refused(void **state)
{
    (void)state;
    const int wrong = 16;
    mbsr_beam_def good = unit_beam(2), def;
#define WITH(change, status, words) (def = good, change, refuse(&def, status, words))
    WITH(def.length = 0.0, MBSR_ERR_VALUE, "length is 0|positive");
    WITH(def.length = NAN, MBSR_ERR_VALUE, "length is nan");
    WITH(def.density = -1.0, MBSR_ERR_VALUE, "density is -1");
    WITH(def.EI_y = INFINITY, MBSR_ERR_VALUE, "EI_y is inf");
    WITH(def.damping = -0.1, MBSR_ERR_VALUE, "damping is -0.1");
    WITH(def.frequency = -1.0, MBSR_ERR_VALUE, "frequency is -1");
    WITH(def.cutoff = NAN, MBSR_ERR_VALUE, "cutoff nan");
    WITH(def.stiffening = 2, MBSR_ERR_VALUE, "stiffening is 2|0 or 1");
    WITH(def.elements = 41, MBSR_ERR_VALUE, "elements is 41|1 .. 40");
    WITH(def.modes = -1, MBSR_ERR_VALUE, "modes is -1");
    WITH(def.loaded = 1, MBSR_ERR_NULL, "node is NULL");
    WITH((def.loaded = 1, def.node = &wrong), MBSR_ERR_VALUE, "node[0] is 16|1 .. 15");
    WITH(def.cookie = 0, MBSR_ERR_NO_DEFAULT, "mbsr_default_beam_def");
    refuse(NULL, MBSR_ERR_NULL, "def is NULL");
    assert_int_equal(mbsr_flex_beam(&good, NULL, NULL), MBSR_ERR_NULL);
    for (int k = 0; k < 9; ++k) {
        test_counting counting = {.fail_at = k < 4 ? k + 1 : k - 3};
        def = good;
        def.stiffening = k >= 4;
        def.allocator = test_counting_allocator(&counting);
        refuse(&def, MBSR_ERR_NO_MEMORY, "no memory");
        assert_int_equal(counting.live, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frequencies_are_those_of_a_cantilever),
        cmocka_unit_test(frequencies_of_stretching_converge_slowly),
        cmocka_unit_test(a_beam_in_flight_lacks_inertia_about_its_axis),
        cmocka_unit_test(static_modes_make_deflections_exact),
        cmocka_unit_test(beams_in_space),
        cmocka_unit_test(torsion_without_radii_is_massless),
        cmocka_unit_test(beams_get_shorter_when_they_bend),
        cmocka_unit_test(what_is_no_beam_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
