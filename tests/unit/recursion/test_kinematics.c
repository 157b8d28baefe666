/* Joints with the caller's own table: general K and G, states in which they fail, values that are
 * not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

/* ---- a joint that misbehaves where it is told to --------------------------------------------- */

enum { NOWHERE, POSITION, JACOBIANS, BIAS, RATES };
enum { NOTHING, IN_K, IN_H, IN_J, IN_KI, IN_P, IN_KII, IN_QDOT };

typedef struct mood {
    int fails_in, code;
    int bad; /* where the value below is written */
    double value;
    double K[4], J[4], kI[2], kII[2]; /* as they are, by columns */
} mood;

static const mood calm = {.K = {1, 0, 0, 1}, .J = {-1, 0, 0, -1}};

static const mood *mood_of(const mbsr_joint_args *args)
{
    return args->user;
}

/* K p = -(H p_pred + J q) with H = -1, by Cramer's rule; d = n = 2. */
static int position(const mbsr_joint_args *args, double *p)
{
    const mood *w = mood_of(args);
    double right[2];
    for (int k = 0; k < 2; ++k) {
        right[k] = args->pred_space == MBSR_SPACE_FIXED ? 0.0 : args->p_pred[k];
        for (int c = 0; c < 2; ++c) right[k] -= w->J[c * 2 + k] * args->q[c];
    }
    const double det = w->K[0] * w->K[3] - w->K[2] * w->K[1];
    p[0] = det != 0.0 ? (right[0] * w->K[3] - w->K[2] * right[1]) / det : 0.0;
    p[1] = det != 0.0 ? (w->K[0] * right[1] - w->K[1] * right[0]) / det : 0.0;
    if (w->bad == IN_P) p[1] = w->value;
    return w->fails_in == POSITION ? w->code : 0;
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    const mood *w = mood_of(args);
    for (int k = 0; K && k < 4; ++k) K[k] = w->K[k];
    for (int k = 0; k < 4; ++k) J[k] = w->J[k];
    for (int k = 0; k < 2; ++k) kI[k] = w->kI[k];
    if (args->pred_d == 2) H[0] = H[3] = -1.0;
    if (K && w->bad == IN_K) K[3] = w->value;
    if (w->bad == IN_H && args->pred_d == 2) H[2] = w->value;
    if (w->bad == IN_J) J[3] = w->value;
    if (w->bad == IN_KI) kI[0] = w->value;
    return w->fails_in == JACOBIANS ? w->code : 0;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    const mood *w = mood_of(args);
    for (int k = 0; k < 2; ++k) kII[k] = w->kII[k];
    if (w->bad == IN_KII) kII[1] = w->value;
    return w->fails_in == BIAS ? w->code : 0;
}

static int coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    const mood *w = mood_of(args);
    for (int k = 0; k < 2; ++k) qdot[k] = args->u[k];
    if (w->bad == IN_QDOT) qdot[1] = w->value;
    return w->fails_in == RATES ? w->code : 0;
}

static const mbsr_joint_table moody = {.version = MBSR_JOINT_TABLE_VERSION,
                                       .name = "moody",
                                       .position = position,
                                       .jacobians = jacobians,
                                       .bias = bias,
                                       .coordinate_rates = coordinate_rates};
static const mbsr_joint_table moody_unit = {.version = MBSR_JOINT_TABLE_VERSION,
                                            .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
                                            .name = "moody",
                                            .position = position,
                                            .jacobians = jacobians,
                                            .bias = bias,
                                            .coordinate_rates = coordinate_rates};

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    mood mood;
    double y[8], yp[8], F[8];
} scene;

/* A calm free point 0 and the body 1 'arm' on it, d = n = 2, unit mass. */
static void make(scene *s, const mbsr_joint_table *table, mbsr_root_fn root, void *user)
{
    static const double unit[4] = {1, 0, 0, 1};
    mbsr_model_def def = mbsr_default_model_def();
    if (root) def.root = mbsr_root_moving(MBSR_SPACE_POINT, 2, 2, root, user);
    *s = (scene){.mood = calm};
    assert_int_equal(mbsr_model_create(&def, &s->model, NULL), 0);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(1.0);
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    body.name = "arm";
    body.parent = 0;
    body.joint = mbsr_joint_custom(table, 2, 2, &s->mood);
    body.inertia = mbsr_inertia_matrix(2, unit);
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_int_equal(mbsr_data_create(s->model, &s->data, NULL), 0);
    for (int k = 0; k < 8; ++k) s->y[k] = 0.1 * (k + 1), s->yp[k] = 0.2 * (k - 3);
}

static void drop(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static int residual(scene *s, int form)
{
    return mbsr_dae_residual(s->model, s->data, (mbsr_dae_form)form, 0.5, s->y, s->yp, s->F);
}

/* Both forms refuse with this, and work again when the joint is calm. */
static void residual_refused(scene *s, int status, int body, const char *words)
{
    const mood held = s->mood;
    for (int form = MBSR_DAE_RECURSIVE; form <= MBSR_DAE_INVERSE_DYNAMICS; ++form) {
        assert_refused(residual(s, form), mbsr_data_error(s->data), status, body, MBSR_NONE, words);
        s->mood = calm;
        assert_ok(residual(s, form), mbsr_data_error(s->data));
        s->mood = held;
    }
    s->mood = calm;
}

/* ---- K --------------------------------------------------------------------------------------- */

static void a_singular_K_is_recoverable_and_names_body_and_joint(void **state)
{
    (void)state;
    static const double singular[][4] = {
        {1, 2, 2, 4}, {0, 0, 0, 0}, {1, 0, 0, 0}, {1, 1, 1, 1 + 2.3e-16}};
    scene s;
    make(&s, &moody, NULL, NULL);
    assert_true(MBSR_SINGULAR_K > 0);
    for (int k = 0; k < 4; ++k) {
        memcpy(s.mood.K, singular[k], sizeof singular[k]);
        residual_refused(&s, MBSR_SINGULAR_K, 1, "body 1 'arm'|joint 'moody'|K|singular|t = 0.5");
    }
    drop(&s);
}

static void a_nearly_singular_K_is_accepted(void **state)
{
    (void)state;
    scene s;
    make(&s, &moody, NULL, NULL);
    const double K[4] = {1, 1, 1, 1 + 1e-9}; /* K^-1 = 1e9 [K22 -1; -1 1] */
    memcpy(s.mood.K, K, sizeof K);
    double V[2];
    assert_ok(residual(&s, MBSR_DAE_RECURSIVE), mbsr_data_error(s.data));
    assert_int_equal(mbsr_body_twist(s.model, s.data, 1, V), 0);
    /* K V = V_pred + u, to the accuracy that a condition of 4e9 leaves */
    for (int k = 0; k < 2; ++k) {
        const double sum = K[k] * V[0] + K[2 + k] * V[1];
        assert_close(sum, s.y[4 + k] + s.y[6 + k], 1e-6);
    }
    drop(&s);
}

static void the_units_of_the_rows_and_columns_of_K_do_not_matter(void **state)
{
    (void)state;
    static const double scales[] = {1e-20, 1e-8, 1e8, 1e20};
    scene s;
    make(&s, &moody, NULL, NULL);
    s.y[5] = 0.0; /* the predecessor's velocity does not come in these units */
    for (int k = 0; k < 4; ++k) {
        const double r = scales[k];
        double V[2];
        s.mood = calm;
        /* second row of K and J in other units; the second velocity in others again */
        s.mood.K[0] = 2.0, s.mood.K[1] = 0.5 * r, s.mood.K[2] = 0.25 * r, s.mood.K[3] = 3.0 * r * r;
        s.mood.J[3] = -r;
        assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.y), mbsr_data_error(s.data));
        assert_ok(mbsr_stage_velocities(s.model, s.data, s.y + 4), mbsr_data_error(s.data));
        assert_int_equal(mbsr_body_twist(s.model, s.data, 1, V), 0);
        /* K V = V_pred - J u */
        const double first = s.y[4] + s.y[6], second = r * s.y[7];
        assert_close((s.mood.K[0] * V[0] + s.mood.K[2] * V[1] - first) / first, 0.0, 1e-13);
        assert_close((s.mood.K[1] * V[0] + s.mood.K[3] * V[1] - second) / second, 0.0, 1e-13);
    }
    drop(&s);
}

/* K, H, J multiplied from the left by a matrix describe the same joint. */
static void a_general_K_gives_the_same_as_the_unit_matrix(void **state)
{
    (void)state;
    scene s, unit;
    make(&s, &moody, NULL, NULL);
    make(&unit, &moody_unit, NULL, NULL);
    static const double T[4] = {
        2, 0.5, -0.3, 1.5}; /* K = T; p = T^-1 (p_pred + q) is another pose than p_pred + q */
    memcpy(s.mood.K, T, sizeof T);
    s.mood.J[0] = -T[0], s.mood.J[1] = -T[1], s.mood.J[2] = -T[2], s.mood.J[3] = -T[3];
    s.y[0] = s.y[1] = s.y[4] = s.y[5] = unit.y[0] = unit.y[1] = unit.y[4] = unit.y[5] = 0.0;
    s.yp[4] = s.yp[5] = unit.yp[4] = unit.yp[5] =
        0.0; /* the predecessor rests, so that H does not count */
    unit.mood.kI[0] = 0.3;
    s.mood.kI[0] = 0.3 * T[0], s.mood.kI[1] = 0.3 * T[1];
    unit.mood.kII[1] = 0.7;
    s.mood.kII[0] = 0.7 * T[2], s.mood.kII[1] = 0.7 * T[3];
    double V[2], W[2];
    assert_ok(residual(&s, MBSR_DAE_INVERSE_DYNAMICS), mbsr_data_error(s.data));
    assert_ok(residual(&unit, MBSR_DAE_INVERSE_DYNAMICS), mbsr_data_error(unit.data));
    assert_int_equal(mbsr_body_twist(s.model, s.data, 1, V), 0);
    assert_int_equal(mbsr_body_twist(unit.model, unit.data, 1, W), 0);
    for (int k = 0; k < 2; ++k) {
        assert_close(V[k], W[k], 1e-15);
        assert_close(V[k], s.y[6 + k] - (k == 0 ? 0.3 : 0.0), 1e-15);
        assert_close(s.F[6 + k], unit.F[6 + k], 1e-14);
    }
    drop(&s);
    drop(&unit);
}

/* ---- J --------------------------------------------------------------------------------------- */

static void a_J_without_full_column_rank_is_recoverable(void **state)
{
    (void)state;
    static const double deficient[][4] = {
        {1, 2, -2, -4}, {0, 0, 1, 0}, {1, 0, 0, 0}, {1e-9, 1e-9, 1e9, 1e9}};
    static const char *const column[] = {"column 1", "column 0", "column 1", "column 1"};
    scene s;
    make(&s, &moody, NULL, NULL);
    assert_true(MBSR_RANK_DEFICIENT_J > 0);
    for (int k = 0; k < 4; ++k) {
        memcpy(s.mood.J, deficient[k], sizeof deficient[k]);
        residual_refused(&s, MBSR_RANK_DEFICIENT_J, 1, "body 1 'arm'|joint 'moody'|J|rank|t = 0.5");
        memcpy(s.mood.J, deficient[k], sizeof deficient[k]);
        assert_int_equal(residual(&s, MBSR_DAE_RECURSIVE), MBSR_RANK_DEFICIENT_J);
        assert_contains(mbsr_data_error(s.data)->text, column[k]);
        s.mood = calm;
    }
    drop(&s);
}

static void the_units_of_the_columns_of_J_do_not_matter(void **state)
{
    (void)state;
    scene s;
    make(&s, &moody, NULL, NULL);
    s.mood.J[0] = s.mood.J[1] = 1e-12;
    s.mood.J[2] = 1e12, s.mood.J[3] = -1e12;
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.y), mbsr_data_error(s.data));
    /* columns at an angle of 1e-5 */
    s.mood.J[0] = 1, s.mood.J[1] = 1, s.mood.J[2] = 1, s.mood.J[3] = 1 + 2e-5;
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.y), mbsr_data_error(s.data));
    drop(&s);
}

/* ---- values that are not finite -------------------------------------------------------------- */

static void a_value_that_is_not_finite_is_named(void **state)
{
    (void)state;
    static const struct {
        int bad;
        const char *words, *words_unit;
    } list[] = {
        {IN_K, "joint 'moody'|K is not finite", NULL},
        {IN_H, "H", "H is not finite"},
        {IN_J, "J", "J is not finite"},
        {IN_KI, "kI", "kI is not finite"},
        {IN_P, "pose", "the pose is not finite"},
        {IN_KII, "kII", "kII is not finite"},
        {IN_QDOT, "what coordinate_rates wrote", "what coordinate_rates wrote"},
    };
    static const double values[] = {NAN, INFINITY, -INFINITY};
    for (int unit = 0; unit < 2; ++unit) {
        scene s;
        make(&s, unit ? &moody_unit : &moody, NULL, NULL);
        for (size_t l = 0; l < sizeof list / sizeof list[0]; ++l) {
            const char *words = unit ? list[l].words_unit : list[l].words;
            for (int k = 0; words && k < 3; ++k) {
                s.mood.bad = list[l].bad;
                s.mood.value = values[k];
                residual_refused(&s, MBSR_NOT_FINITE, 1, words);
                s.mood.bad = list[l].bad;
                s.mood.value = values[k];
                (void)residual(&s, MBSR_DAE_RECURSIVE);
                assert_contains(mbsr_data_error(s.data)->text, "body 1 'arm'|t = 0.5");
                s.mood = calm;
            }
        }
        drop(&s);
    }
}

typedef struct shake {
    int bad, code;
} shake;

static int shaking(void *user, double t, double *p, double *V, double *A)
{
    const shake *w = user;
    for (int k = 0; k < 2; ++k) assert_true(p[k] == 0.0 && V[k] == 0.0 && A[k] == 0.0);
    p[0] = t;
    V[0] = 1.0;
    if (w->bad == 1) p[1] = NAN;
    if (w->bad == 2) V[1] = NAN;
    if (w->bad == 3) A[1] = NAN;
    return w->code;
}

static void a_root_that_is_not_finite_is_named(void **state)
{
    (void)state;
    static const char *const words[] = {"", "root: the pose", "root: the velocity",
                                        "root: the acceleration"};
    shake w = {0, 0};
    scene s;
    make(&s, &moody, shaking, &w);
    for (w.bad = 1; w.bad <= 3; ++w.bad) {
        for (int form = MBSR_DAE_RECURSIVE; form <= MBSR_DAE_INVERSE_DYNAMICS; ++form) {
            assert_refused(residual(&s, form), mbsr_data_error(s.data), MBSR_NOT_FINITE,
                           MBSR_GROUND, MBSR_NONE, words[w.bad]);
        }
    }
    w.bad = 0;
    assert_ok(residual(&s, MBSR_DAE_RECURSIVE), mbsr_data_error(s.data));
    drop(&s);
}

/* ---- codes of callbacks ---------------------------------------------------------------------- */

static void what_a_callback_returns_is_passed_on_unchanged(void **state)
{
    (void)state;
    static const int codes[] = {17, -7};
    static const char *const names[] = {"", "position", "jacobians", "bias", "coordinate_rates"};
    shake w = {0, 0};
    scene s;
    make(&s, &moody, shaking, &w);
    for (int k = 0; k < 2; ++k) {
        for (int place = POSITION; place <= RATES; ++place) {
            s.mood.fails_in = place;
            s.mood.code = codes[k];
            residual_refused(&s, codes[k], 1, names[place]);
            s.mood.fails_in = place;
            s.mood.code = codes[k];
            assert_int_equal(residual(&s, MBSR_DAE_RECURSIVE), codes[k]);
            assert_contains(mbsr_data_error(s.data)->text,
                            "body 1 'arm'|joint 'moody'|returned|t = 0.5");
            assert_contains(mbsr_data_error(s.data)->text, codes[k] > 0 ? "17" : "-7");
            s.mood = calm;
        }
        w.code = codes[k];
        assert_refused(residual(&s, MBSR_DAE_RECURSIVE), mbsr_data_error(s.data), codes[k],
                       MBSR_GROUND, MBSR_NONE, "root|motion|t = 0.5");
        w.code = 0;
    }
    drop(&s);
}

/* ---- q' = G u -------------------------------------------------------------------------------- */

/* A point on the unit circle: q = (c, s) has two numbers, u is the angular velocity. */
static int circle_position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0], p[1] = args->q[1];
    return 0;
}

static int circle_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                            double *kI)
{
    (void)K, (void)H, (void)kI;
    J[0] = args->q[1], J[1] = -args->q[0];
    return 0;
}

static int circle_bias(const mbsr_joint_args *args, double *kII)
{
    for (int k = 0; k < 2; ++k) kII[k] = args->q[k] * args->u[0] * args->u[0];
    return 0;
}

static int circle_rates(const mbsr_joint_args *args, double *qdot)
{
    assert_true(qdot[0] == 0.0 && qdot[1] == 0.0);
    qdot[0] = -args->q[1] * args->u[0];
    qdot[1] = args->q[0] * args->u[0];
    return 0;
}

static const mbsr_joint_table circle = {.version = MBSR_JOINT_TABLE_VERSION,
                                        .flags = MBSR_JOINT_UNIT_K,
                                        .name = "circle",
                                        .position = circle_position,
                                        .jacobians = circle_jacobians,
                                        .bias = circle_bias,
                                        .coordinate_rates = circle_rates};

static void coordinates_may_be_more_than_velocities(void **state)
{
    (void)state;
    static const double unit[4] = {1, 0, 0, 1};
    mbsr_model *m;
    mbsr_data *d;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    mbsr_body_def body = mbsr_default_body_def();
    for (int k = 0; k < 2; ++k) {
        body.joint = mbsr_joint_custom(&circle, 2, 1, NULL);
        body.joint.nq = 2;
        body.inertia = mbsr_inertia_matrix(2, unit);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
    int q_index, nq, u_index, n;
    assert_int_equal(mbsr_body_coordinates(m, 1, &q_index, &nq, &u_index, &n), 0);
    assert_true(q_index == 2 && nq == 2 && u_index == 1 && n == 1);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_RECURSIVE), 6);
    const double y[6] = {0.6, 0.8, -0.8, 0.6, 2.0, 3.0}, yp[6] = {1, 2, 3, 4, 0.5, 0.25};
    double qdot[4], F[6], V[2];
    for (int form = MBSR_DAE_RECURSIVE; form <= MBSR_DAE_INVERSE_DYNAMICS; ++form) {
        assert_ok(mbsr_dae_residual(m, d, (mbsr_dae_form)form, 0.0, y, yp, F), mbsr_data_error(d));
        assert_int_equal(mbsr_coordinate_rates(m, d, qdot), 0);
        const double expected[4] = {-1.6, 1.2, -1.8, -2.4};
        for (int k = 0; k < 4; ++k) {
            assert_close(qdot[k], expected[k], 1e-15);
            assert_close(F[k], yp[k] - expected[k], 1e-15);
        }
        /* unit mass on a unit circle: u' = 0 without forces */
        assert_close(fabs(F[4]), 0.5, 1e-15);
        assert_close(fabs(F[5]), 0.25, 1e-15);
        assert_int_equal(mbsr_body_twist(m, d, 1, V), 0);
        assert_close(V[0], -1.8, 1e-15);
        assert_close(V[1], -2.4, 1e-15);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_singular_K_is_recoverable_and_names_body_and_joint),
        cmocka_unit_test(a_nearly_singular_K_is_accepted),
        cmocka_unit_test(the_units_of_the_rows_and_columns_of_K_do_not_matter),
        cmocka_unit_test(a_general_K_gives_the_same_as_the_unit_matrix),
        cmocka_unit_test(a_J_without_full_column_rank_is_recoverable),
        cmocka_unit_test(the_units_of_the_columns_of_J_do_not_matter),
        cmocka_unit_test(a_value_that_is_not_finite_is_named),
        cmocka_unit_test(a_root_that_is_not_finite_is_named),
        cmocka_unit_test(what_a_callback_returns_is_passed_on_unchanged),
        cmocka_unit_test(coordinates_may_be_more_than_velocities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
