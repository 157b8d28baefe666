/* Modal data: what is refused and by which name, positive semi-definite mass matrices, markers and
 * mounts against differences, and adding to models.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "flexible.h"
#include "oracle.h"

#include "algebra/lapack.h"

#include <mbsrank/verify.h>

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { MODES = 3, D = 6 + MODES };

/* The data of a beam, to be spoilt. */
typedef struct spoilt {
    mbsr_flex *good;
    mbsr_flex_def def;
    double Ct0[3 * MODES], P0[9 * MODES], P[9 * MODES * MODES], Mf[MODES * MODES], K[MODES * MODES],
        damping[MODES * MODES];
    mbsr_flex_marker marker[3];
} spoilt;

static void open_data(spoilt *w)
{
    const test_ritz beam = test_ritz_first();
    w->good = test_ritz_make(&beam);
    assert_int_equal(mbsr_flex_definition(w->good, &w->def), MBSR_OK);
    memcpy(w->Ct0, w->def.Ct0, sizeof w->Ct0);
    memcpy(w->P0, w->def.P0, sizeof w->P0);
    memcpy(w->P, w->def.P, sizeof w->P);
    memcpy(w->Mf, w->def.Mf, sizeof w->Mf);
    memcpy(w->K, w->def.K, sizeof w->K);
    memcpy(w->damping, w->def.D, sizeof w->damping);
    memcpy(w->marker, w->def.marker, sizeof w->marker);
    w->def.Ct0 = w->Ct0, w->def.P0 = w->P0, w->def.P = w->P, w->def.Mf = w->Mf;
    w->def.K = w->K, w->def.D = w->damping, w->def.marker = w->marker;
}

static void refuse(const mbsr_flex_def *def, int status, const char *words)
{
    mbsr_flex *flex = (mbsr_flex *)&status;
    mbsr_error error = {0};
    assert_refused(mbsr_flex_create(def, &flex, &error), &error, status, MBSR_NONE, MBSR_NONE,
                   words);
    assert_null(flex);
    assert_int_equal(mbsr_flex_create(def, &flex, NULL), status);
}

static void what_is_no_body_is_refused(void **state)
{
    (void)state;
    spoilt w;
    open_data(&w);
    mbsr_flex *flex;
    mbsr_flex_def def = w.def;
#define SPOIL(place, value, status, words)                                                         \
    do {                                                                                           \
        const double kept = (place);                                                               \
        (place) = (value);                                                                         \
        refuse(&w.def, (status), (words));                                                         \
        (place) = kept;                                                                            \
    } while (0)
    SPOIL(w.K[1], 7.0, MBSR_ERR_VALUE, "K is not symmetric|(1,0) is 7");
    SPOIL(w.K[0], -40.0, MBSR_ERR_VALUE, "K is indefinite|eigenvalue|stable");
    SPOIL(w.damping[4], -1.0, MBSR_ERR_VALUE, "D is indefinite");
    SPOIL(w.P[1], 0.3, MBSR_ERR_VALUE, "P is not symmetric");
    SPOIL(w.P[10 * 3 * MODES / 9], NAN, MBSR_ERR_VALUE, "P(|nan");
    SPOIL(w.def.N0[0], 0.5, MBSR_ERR_VALUE, "Gram matrix|eigenvalue|one field");
    SPOIL(w.def.mass, -1.0, MBSR_ERR_VALUE, "mass is -1");
    SPOIL(w.def.mass, INFINITY, MBSR_ERR_VALUE, "mass(0,0) is inf");
    SPOIL(w.P0[1], 5.0, MBSR_ERR_VALUE, "Gram matrix|indefinite");
    SPOIL(w.Mf[0], 0.1, MBSR_ERR_VALUE, "Mf less the traces|kinetic energy");
    SPOIL(w.marker[1].frame.R[0], 2.0, MBSR_ERR_VALUE, "marker[1]|orthonormal");
    SPOIL(w.marker[2].frame.x[1], NAN, MBSR_ERR_VALUE, "marker[2]|not finite");
    def.modes = -1;
    refuse(&def, MBSR_ERR_VALUE, "modes is -1");
    def.modes = MBSR_MAX_MODES + 1;
    refuse(&def, MBSR_ERR_VALUE, "modes is 251|0 .. 250");
    def = w.def, def.cookie = 0;
    refuse(&def, MBSR_ERR_NO_DEFAULT, "mbsr_default_flex_def");
    def = w.def, def.K = NULL;
    refuse(&def, MBSR_ERR_NULL, "K is NULL");
    def = w.def, def.markers = 0;
    refuse(&def, MBSR_ERR_VALUE, "markers is 0");
    def = w.def, def.marker = NULL;
    refuse(&def, MBSR_ERR_NULL, "marker is NULL");
    refuse(NULL, MBSR_ERR_NULL, "def is NULL");
    assert_int_equal(mbsr_flex_create(&w.def, NULL, NULL), MBSR_ERR_NULL);
    assert_ok(mbsr_flex_create(&w.def, &flex, NULL), NULL);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(NULL);
    mbsr_flex_destroy(w.good);
}

static void memory_that_fails_is_reported_and_freed(void **state)
{
    (void)state;
    spoilt w;
    open_data(&w);
    for (int k = 0; k < 2; ++k) {
        test_counting counting = {.fail_at = k + 1};
        mbsr_flex *flex;
        mbsr_error error;
        w.def.allocator = test_counting_allocator(&counting);
        assert_refused(mbsr_flex_create(&w.def, &flex, &error), &error, MBSR_ERR_NO_MEMORY,
                       MBSR_NONE, MBSR_NONE, "no memory");
        assert_null(flex);
        assert_int_equal(counting.failed, 1);
        assert_int_equal(counting.live, 0);
    }
    mbsr_flex_destroy(w.good);
}

/* M(s) of random shapes up to 3 has no negative eigenvalue. */
static void masses_are_positive_semidefinite_in_every_shape(void **state)
{
    (void)state;
    test_ritz beams[3] = {test_ritz_first(), test_ritz_massless(), test_ritz_first()};
    beams[2].stiffening = 1;
    enum { WORK = 64 * D };
    double M[D * D], lambda[D], work[WORK], s[MODES];
    test_rng rng = test_seed(4);
    for (int b = 0; b < 3; ++b) {
        mbsr_flex *flex = test_ritz_make(beams + b);
        for (int k = 0; k < 200; ++k) {
            test_fill(&rng, MODES, s);
            for (int l = 0; l < MODES; ++l) s[l] *= 3.0;
            assert_int_equal(mbsr_flex_mass_matrix(flex, s, M), MBSR_OK);
            for (int l = 0; l < D && b == 1; ++l) assert_true(M[8 * D + l] == 0.0);
            assert_int_equal(mbsri_lapack_syev(D, M, lambda, work, WORK), 0);
            assert_less(-1e-13 * lambda[D - 1], lambda[0] + 1e-300);
        }
        s[0] = NAN;
        assert_int_equal(mbsr_flex_mass_matrix(flex, s, M), MBSR_NOT_FINITE);
        assert_int_equal(mbsr_flex_mass_matrix(flex, NULL, M), MBSR_ERR_NULL);
        mbsr_flex_destroy(flex);
    }
}

/* Masses move by 2, in the mean square, or a marker by 3, and turns by 0.5 rad. */
static void spans_are_what_modes_reach(void **state)
{
    (void)state;
    const double K = 1.0, Mf = 8.0, Phi[3] = {0.0, 3.0, 0.0}, Psi[3] = {0.0, 0.0, 0.5};
    mbsr_flex_marker marker = {.frame = mbsr_frame_identity()};
    mbsr_flex_def def = mbsr_default_flex_def();
    mbsr_error error;
    for (int moves = 0; moves < 2; ++moves) {
        mbsr_flex *flex;
        marker.Phi = moves ? Phi : NULL;
        marker.Psi = moves ? Psi : NULL;
        def.modes = 1, def.mass = 2.0, def.K = &K, def.Mf = &Mf, def.markers = 1;
        def.marker = &marker;
        assert_ok(mbsr_flex_create(&def, &flex, &error), &error);
        assert_close(mbsr_flex_span(flex, 0, 1.2), moves ? 0.4 : 0.6, 1e-15);
        assert_close(mbsr_flex_span(flex, 0, 30.0), moves ? 2.0 : 15.0, 1e-14);
        assert_true(mbsr_flex_span(flex, 1, 1.0) == 1.0 && mbsr_flex_span(flex, 0, 0.0) == 1.0);
        mbsr_flex_destroy(flex);
    }
}

/* The modes y^2, z^2, y^3 of a beam along x: the components of the field that are not zero are 1, x
 * and one of each mode. */
enum { FIELD = 2 + MODES };

/* Scaled to unit diagonal, the lowest eigenvalue of their Gram matrix. */
static double lowest_of_field(const spoilt *w)
{
    static const int component[MODES] = {1, 2, 1};
    enum { WORK = 64 * FIELD };
    double G[FIELD * FIELD] = {0.0}, S[FIELD * FIELD], lambda[FIELD], work[WORK];
    G[0] = w->def.mass, G[1] = w->def.c0[0], G[FIELD + 1] = w->def.N0[0];
    for (int a = 0; a < MODES; ++a) {
        const int column = 3 * a + component[a];
        G[2 + a] = w->Ct0[column];
        G[FIELD + 2 + a] = w->P0[3 * column];
        for (int b = 0; b <= a; ++b)
            G[FIELD * (2 + b) + 2 + a] = w->P[3 * MODES * column + 3 * b + component[b]];
    }
    for (int j = 0; j < FIELD; ++j) {
        for (int k = 0; k < FIELD; ++k)
            S[FIELD * j + k] = G[k > j ? FIELD * j + k : FIELD * k + j] /
                               sqrt(G[(FIELD + 1) * j] * G[(FIELD + 1) * k]);
    }
    assert_int_equal(mbsri_lapack_syev(FIELD, S, lambda, work, WORK), 0);
    return lambda[0];
}

/* Integrals of which what couples the modes is cut off belong to no field. */
static void data_cut_short_are_refused_with_the_number(void **state)
{
    (void)state;
    spoilt w;
    char words[MBSR_TEXT_SIZE];
    open_data(&w);
    assert_less(-1e-12, lowest_of_field(&w));
    for (int column = 0; column < 3 * MODES; ++column) {
        for (int row = 0; row < 3 * MODES; ++row) {
            if (row / 3 != column / 3) w.P[3 * MODES * column + row] = 0.0;
        }
    }
    const double lowest = lowest_of_field(&w);
    assert_less(lowest, -0.3);
    snprintf(words, sizeof words, "Gram matrix|lowest eigenvalue is %.3g;", lowest);
    refuse(&w.def, MBSR_ERR_VALUE, words);
    mbsr_flex_destroy(w.good);
}

/* Without the terms of second degree in s, sum s_a s_b (tr P_ab 1 - P_ab) of the tensor, M would be
 * indefinite. */
static void masses_of_first_order_would_be_indefinite(void **state)
{
    (void)state;
    spoilt w;
    enum { WORK = 64 * D };
    double M[D * D], lambda[D], work[WORK];
    const double s[MODES] = {0.3, -0.2, 0.1};
    open_data(&w);
    assert_int_equal(mbsr_flex_mass_matrix(w.good, s, M), MBSR_OK);
    assert_int_equal(mbsri_lapack_syev(D, M, lambda, work, WORK), 0);
    assert_less(-1e-14, lambda[0]);
    assert_int_equal(mbsr_flex_mass_matrix(w.good, s, M), MBSR_OK);
    for (int k = 0; k < 9 * MODES * MODES; ++k) {
        const int column = k / (3 * MODES), row = k % (3 * MODES), to = row % 3, from = column % 3;
        const double share = s[row / 3] * s[column / 3] * w.P[k];
        M[D * from + to] += share;
        for (int l = 0; l < 3 && to == from; ++l) M[(D + 1) * l] -= share;
    }
    assert_int_equal(mbsri_lapack_syev(D, M, lambda, work, WORK), 0);
    assert_less(lambda[0], -1e-3);
    mbsr_flex_destroy(w.good);
}

/* ---- joints ---- */

/* A beam in a general state: rotations of markers of size `bend`. */
static void verify(mbsr_joint joint, bool marker, double bend)
{
    mbsr_joint_test at = mbsr_default_joint_test();
    mbsr_joint_errors errors;
    mbsr_error error;
    double q[MODES], u[MODES], pose[12 + MODES], V[D], quaternion[4];
    test_rng rng = test_seed(7);
    test_fill(&rng, MODES, q);
    test_fill(&rng, MODES, u);
    test_fill(&rng, 12 + MODES, pose);
    test_fill(&rng, D, V);
    test_fill(&rng, 4, quaternion);
    mbsr_quaternion_rotation(quaternion, pose);
    for (int k = 0; k < MODES; ++k) {
        q[k] *= bend;
        pose[12 + k] *= bend;
    }
    at.pred_space = marker ? MBSR_SPACE_FLEXIBLE : MBSR_SPACE_SPATIAL;
    at.pred_d = D, at.pred_np = D + 6;
    at.q = q, at.u = u, at.p_pred = pose, at.V_pred = V;
    assert_ok(mbsr_joint_verify(&joint, &at, &errors, &error), &error);
    if (!(errors.largest < 2e-8)) print_error("%s\n", errors.text);
    assert_less(errors.largest, 2e-8);
    assert_true(errors.H >= 0.0 && errors.kII >= 0.0 && errors.Hdot >= 0.0);
    assert_true(errors.tangent >= 0.0 && errors.rate_tangent >= 0.0);
    if (marker) return;
    at.pred_space = MBSR_SPACE_FIXED;
    assert_ok(mbsr_joint_verify(&joint, &at, &errors, &error), &error);
    assert_less(errors.largest, 2e-8);
}

static void markers_and_mounts_agree_with_differences(void **state)
{
    (void)state;
    test_ritz beam = test_ritz_first();
    for (int k = 0; k < 6; ++k) {
        const double bend = (double[3]){0.05, 0.5, 1.2}[k % 3];
        beam.stiffening = k >= 3;
        mbsr_flex *flex = test_ritz_make(&beam);
        for (int marker = 0; marker < 3; ++marker) {
            verify(mbsr_joint_marker(flex, marker), true, bend);
            verify(mbsr_joint_mount(flex, marker), false, bend);
        }
        mbsr_flex_destroy(flex);
    }
}

/* ---- models ---- */

static void refusals_of_models_change_nothing(void **state)
{
    (void)state;
    const test_ritz beam = test_ritz_first(), other = test_ritz_second();
    static const double axis[3] = {0.0, 0.0, 1.0};
    mbsr_flex *flex = test_ritz_make(&beam), *two = test_ritz_make(&other);
    mbsr_model *m;
    int id = -7, rigid;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const mbsr_error *e = mbsr_model_error(m);
    mbsr_flexible_def def = mbsr_default_flexible_def();
    def.joint = mbsr_joint_revolute(NULL, NULL, axis);
    assert_refused(mbsr_model_add_flexible(m, &def, &id), e, MBSR_ERR_NULL, 1, MBSR_NONE,
                   "flex is NULL");
    def.flex = flex, def.marker = 3;
    assert_refused(mbsr_model_add_flexible(m, &def, &id), e, MBSR_ERR_ID, 1, MBSR_NONE,
                   "marker is 3|0 .. 2");
    def.marker = 0, def.cookie = 0;
    assert_refused(mbsr_model_add_flexible(m, &def, &id), e, MBSR_ERR_NO_DEFAULT, MBSR_NONE,
                   MBSR_NONE, "mbsr_default_flexible_def");
    assert_refused(mbsr_model_add_flexible(m, NULL, &id), e, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "NULL");
    assert_int_equal(mbsr_model_add_flexible(NULL, &def, &id), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_add_marker(NULL, 0, 0, NULL, &id), MBSR_ERR_NULL);
    assert_refused(mbsr_model_add_marker(m, 0, 0, NULL, &id), e, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                   "body is 0|0 bodies");
    assert_int_equal(id, -7);

    def = mbsr_default_flexible_def();
    def.flex = flex, def.joint = mbsr_joint_revolute(NULL, NULL, axis), def.name = "link";
    assert_ok(mbsr_model_add_flexible(m, &def, &id), e);
    assert_int_equal(id, 1);
    assert_refused(mbsr_model_add_marker(m, 0, 0, NULL, &rigid), e, MBSR_ERR_SPACE, 0, MBSR_NONE,
                   "body 0 is not flexible");

    /* no matrix is its mass, no point on it is for elements; and other data's marker is none of it
     */
    const double added[D * D] = {1.0};
    assert_int_equal(mbsr_model_regularise(m, id, D, added), MBSR_ERR_SPACE);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = id, body.joint = mbsr_joint_marker(two, 0);
    assert_ok(mbsr_model_add_body(m, &body, NULL), e);
    assert_refused(mbsr_model_finish(m), e, MBSR_ERR_SPACE, 2, MBSR_NONE, "2 modes");
    mbsr_model_destroy(m);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(two);
}

/* A model of one flexible body with a part that does not go on it. */
static void finish_refused(mbsr_joint *joint, mbsr_force_def *force, int body, int of_force,
                           const char *words)
{
    const test_ritz beam = test_ritz_first();
    mbsr_flex *flex = test_ritz_make(&beam), *same = test_ritz_make(&beam);
    mbsr_model *m;
    mbsr_flexible_def def = mbsr_default_flexible_def();
    mbsr_body_def on = mbsr_default_body_def();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const mbsr_error *e = mbsr_model_error(m);
    def.flex = flex;
    assert_ok(mbsr_model_add_flexible(m, &def, NULL), e);
    on.parent = 0;
    if (joint) {
        on.joint = joint->table ? *joint : mbsr_joint_marker(same, 0);
        assert_ok(mbsr_model_add_body(m, &on, NULL), e);
    }
    if (force) assert_ok(mbsr_model_add_force(m, force, NULL), e);
    const int status = mbsr_model_finish(m);
    assert_true(status == MBSR_ERR_SPACE || status == MBSR_ERR_VALUE);
    assert_refused(status, e, status, body, of_force, words);
    mbsr_model_destroy(m);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(same);
}

static void parts_of_rigid_bodies_go_on_markers(void **state)
{
    (void)state;
    static const double axis[3] = {0.0, 0.0, 1.0};
    mbsr_joint revolute = mbsr_joint_revolute(NULL, NULL, axis), other = {.table = NULL};
    mbsr_force_def spring = mbsr_force_point_spring(0, NULL, MBSR_GROUND, axis, 1.0, 0.0, 0.0),
                   axial = mbsr_force_axis_spring(0, MBSR_GROUND, 0, 1.0, 0.0, 0.0);
    finish_refused(&revolute, NULL, 1, MBSR_NONE, "FLEXIBLE|marker");
    finish_refused(&other, NULL, 1, MBSR_NONE, "other modal data");
    finish_refused(NULL, &spring, MBSR_NONE, 1, "FLEXIBLE|marker");
    finish_refused(NULL, &axial, MBSR_NONE, 1, "FLEXIBLE space");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_no_body_is_refused),
        cmocka_unit_test(memory_that_fails_is_reported_and_freed),
        cmocka_unit_test(masses_are_positive_semidefinite_in_every_shape),
        cmocka_unit_test(spans_are_what_modes_reach),
        cmocka_unit_test(data_cut_short_are_refused_with_the_number),
        cmocka_unit_test(masses_of_first_order_would_be_indefinite),
        cmocka_unit_test(markers_and_mounts_agree_with_differences),
        cmocka_unit_test(refusals_of_models_change_nothing),
        cmocka_unit_test(parts_of_rigid_bodies_go_on_markers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
