/* Building a model: what is refused and how, what is copied, and reading a finished one.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"

#include <mbsrank/driver.h>

#include <stdio.h>
#include <stdlib.h>

static const mbsr_planar_frame at_origin = {0.0, 0.0, 0.0};

/* ---- small parts ----------------------------------------------------------------------------- */

static int general_position(const mbsr_joint_args *args, double *p)
{
    for (int k = 0; k < args->d && k < args->n; ++k) p[k] = args->q[k];
    return 0;
}

static int general_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                             double *kI)
{
    (void)H, (void)kI, (void)K;
    for (int k = 0; k < args->n; ++k) J[k * args->d + k] = -1.0;
    return 0;
}

static int no_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static const mbsr_joint_table general = {.version = MBSR_JOINT_TABLE_VERSION,
                                         .flags = MBSR_JOINT_UNIT_K,
                                         .name = "general",
                                         .position = general_position,
                                         .jacobians = general_jacobians,
                                         .bias = no_bias};

static int no_force(const mbsr_force_args *args)
{
    (void)args;
    return 0;
}

static const mbsr_force_table nothing = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "nothing", .evaluate = no_force};

static mbsr_model *new_model(void)
{
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    return m;
}

/* A body that is right: a free point of unit mass. */
static mbsr_body_def right_body(const char *name)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(1.0);
    return body;
}

static mbsr_body_def planar_body(const char *name)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.joint = mbsr_joint_planar_free(at_origin, at_origin);
    return body;
}

static mbsr_body_def general_body(const char *name, int d, int n)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.joint = mbsr_joint_custom(&general, d, n, NULL);
    return body;
}

static int add(mbsr_model *m, mbsr_body_def body)
{
    int id = MBSR_NONE;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

/* Whatever was refused before, the model finishes and is evaluated; then it goes. */
static void still_usable(mbsr_model *m)
{
    mbsr_data *d = NULL;
    double *zero, *F;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    const int size = mbsr_dae_size(m, MBSR_DAE_RECURSIVE);
    assert_int_equal(size, mbsr_model_nq(m) + mbsr_model_nu(m));
    zero = calloc((size_t)size + 1, sizeof *zero);
    F = malloc(((size_t)size + 1) * sizeof *F);
    assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_RECURSIVE, 0.0, zero, zero, F), mbsr_data_error(d));
    for (int k = 0; k < size; ++k) assert_close(F[k], 0.0, 1e-14);
    free(zero);
    free(F);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Adding the body is refused with status and words, as body 1 behind a right one; a right one then
 * takes its place. */
#define body_refused(body, status, words)                                                          \
    body_refused_at((body), (status), (words), __FILE__, __LINE__)

static void body_refused_at(mbsr_body_def body, int status, const char *words, const char *file,
                            int line)
{
    mbsr_model *m = new_model();
    int id = 77;
    add(m, right_body("first"));
    const int result = mbsr_model_add_body(m, &body, &id);
    assert_refused_at(result, mbsr_model_error(m), status, 1, MBSR_NONE, words, file, line);
    assert_int_equal(id, 77);
    assert_int_equal(add(m, right_body("second")), 1);
    still_usable(m);
}

/* Adding the force element to two points is refused. */
#define force_refused(force, status, words)                                                        \
    force_refused_at((force), (status), (words), __FILE__, __LINE__)

static void force_refused_at(mbsr_force_def force, int status, const char *words, const char *file,
                             int line)
{
    mbsr_model *m = new_model();
    int id = 77;
    add(m, right_body("first"));
    const int result = mbsr_model_add_force(m, &force, &id);
    assert_refused_at(result, mbsr_model_error(m), status, MBSR_NONE, 0, words, file, line);
    assert_int_equal(id, 77);
    still_usable(m);
}

/* Finishing is refused; model freed. */
#define finish_refused(m, status, body, force, words)                                              \
    finish_refused_at((m), (status), (body), (force), (words), __FILE__, __LINE__)

static void finish_refused_at(mbsr_model *m, int status, int body, int force, const char *words,
                              const char *file, int line)
{
    for (int twice = 0; twice < 2; ++twice) {
        const int result = mbsr_model_finish(m);
        assert_refused_at(result, mbsr_model_error(m), status, body, force, words, file, line);
        assert_int_equal(mbsr_model_bodies(m), -1);
        assert_int_equal(mbsr_data_size(m), 0);
    }
    mbsr_model_destroy(m);
}

/* ---- definitions ----------------------------------------------------------------------------- */

static void definitions_without_their_default_call_are_refused(void **state)
{
    (void)state;
    mbsr_model_def model_def;
    memset(&model_def, 0, sizeof model_def);
    model_def.rank_tolerance = 1e-12;
    mbsr_model *m = (mbsr_model *)&model_def;
    mbsr_error error;
    assert_refused(mbsr_model_create(&model_def, &m, &error), &error, MBSR_ERR_NO_DEFAULT,
                   MBSR_NONE, MBSR_NONE, "mbsr_default_model_def");
    assert_null(m);

    mbsr_body_def body;
    memset(&body, 0, sizeof body);
    body.joint = mbsr_joint_point_free();
    body_refused(body, MBSR_ERR_NO_DEFAULT, "body 1|mbsr_default_body_def");

    mbsr_force_def force = mbsr_force_gravity(0.0, -9.81, 0.0);
    force.cookie = 0;
    force_refused(force, MBSR_ERR_NO_DEFAULT, "force 0|mbsr_default_force_def");
}

static void null_arguments_are_refused(void **state)
{
    (void)state;
    mbsr_error error;
    assert_refused(mbsr_model_create(NULL, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "model is NULL");
    assert_int_equal(mbsr_model_create(NULL, NULL, NULL), MBSR_ERR_NULL);
    const mbsr_body_def body = right_body("point");
    const mbsr_force_def force = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_int_equal(mbsr_model_add_body(NULL, &body, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_add_force(NULL, &force, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_finish(NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_error(NULL)->status, MBSR_ERR_NULL);
    mbsr_model_destroy(NULL);
    mbsr_model *m = new_model();
    assert_int_equal(mbsr_model_error(m)->status, MBSR_OK);
    assert_string_equal(mbsr_model_error(m)->text, "");
    assert_refused(mbsr_model_add_body(m, NULL, NULL), mbsr_model_error(m), MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "mbsr_model_add_body|definition is NULL");
    assert_refused(mbsr_model_add_force(m, NULL, NULL), mbsr_model_error(m), MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "mbsr_model_add_force|definition is NULL");
    assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
    assert_int_equal(mbsr_model_add_force(m, &force, NULL), MBSR_OK);
    mbsr_model_destroy(m);
}

static void model_options_out_of_range_are_refused(void **state)
{
    (void)state;
    static const double tolerance[] = {0.0, -1e-12, 1.0, 2.0, NAN, INFINITY};
    mbsr_error error;
    mbsr_model *m;
    for (size_t k = 0; k < sizeof tolerance / sizeof tolerance[0]; ++k) {
        mbsr_model_def def = mbsr_default_model_def();
        def.rank_tolerance = tolerance[k];
        char words[64];
        snprintf(words, sizeof words, "rank_tolerance is %g", tolerance[k]);
        assert_refused(mbsr_model_create(&def, &m, &error), &error, MBSR_ERR_VALUE, MBSR_NONE,
                       MBSR_NONE, words);
        assert_null(m);
    }
    mbsr_model_def half = mbsr_default_model_def();
    half.allocator.release = (void (*)(void *, void *))(void (*)(void))free;
    assert_refused(mbsr_model_create(&half, &m, &error), &error, MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "allocator");
    half = mbsr_default_model_def();
    half.allocator.allocate = (void *(*)(void *, size_t))(void (*)(void))malloc;
    assert_refused(mbsr_model_create(&half, &m, &error), &error, MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "allocator");
}

static int rest(void *user, double t, double *p, double *V, double *A)
{
    (void)user, (void)t, (void)p, (void)V, (void)A;
    return 0;
}

static void roots_with_wrong_sizes_are_refused(void **state)
{
    (void)state;
    const struct {
        mbsr_root root;
        const char *words;
    } wrong[] = {
        {mbsr_root_moving((mbsr_space)9, 3, 3, rest, NULL), "root|space is 9"},
        {mbsr_root_moving((mbsr_space)-1, 3, 3, rest, NULL), "root|space is -1"},
        {mbsr_root_moving(MBSR_SPACE_PLANAR, 2, 3, rest, NULL), "root|d = 2, np = 3"},
        {mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 4, rest, NULL), "root|d = 3, np = 4"},
        {mbsr_root_moving(MBSR_SPACE_POINT, 3, 3, rest, NULL), "root|d = 3, np = 3"},
        {mbsr_root_moving(MBSR_SPACE_FIXED, 3, 3, NULL, NULL), "root|d = 3, np = 3"},
        {mbsr_root_moving(MBSR_SPACE_FIXED, 0, 0, rest, NULL), "root|motion"},
        {mbsr_root_moving(MBSR_SPACE_GENERAL, 0, 1, rest, NULL), "root|d = 0, np = 1"},
        {mbsr_root_moving(MBSR_SPACE_GENERAL, 257, 1, rest, NULL), "root|d = 257"},
        {mbsr_root_moving(MBSR_SPACE_GENERAL, 2, -1, rest, NULL), "root|np = -1"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        mbsr_model_def def = mbsr_default_model_def();
        def.root = wrong[k].root;
        mbsr_error error;
        mbsr_model *m;
        assert_refused(mbsr_model_create(&def, &m, &error), &error, MBSR_ERR_VALUE, MBSR_GROUND,
                       MBSR_NONE, wrong[k].words);
        assert_null(m);
    }
}

/* ---- the tree -------------------------------------------------------------------------------- */

static void a_parent_below_ground_or_the_body_itself_is_refused(void **state)
{
    (void)state;
    mbsr_body_def body = right_body("rod");
    body.parent = MBSR_NONE;
    body_refused(body, MBSR_ERR_ID, "body 1 'rod'|parent is -2");
    body.parent = 1;
    body_refused(body, MBSR_ERR_CYCLE, "body 1 'rod'|parent is 1");
}

static void a_parent_that_never_comes_is_refused_at_the_end(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    mbsr_body_def body = right_body("rod");
    body.parent = 2;
    add(m, right_body("first"));
    add(m, body);
    const int result = mbsr_model_finish(m);
    assert_refused(result, mbsr_model_error(m), MBSR_ERR_ID, 1, MBSR_NONE,
                   "body 1 'rod'|parent is 2|2 bodies");
    /* now it comes */
    add(m, right_body("late"));
    still_usable(m);
}

/* Bodies with the given parents; finishing is refused as a cycle on one of `on` (NONE ends the
 * list). */
static void cycle_refused(int count, const int *parent, const int *on)
{
    mbsr_model *m = new_model();
    char name[16], words[64];
    for (int k = 0; k < count; ++k) {
        snprintf(name, sizeof name, "link%d", k);
        mbsr_body_def body = right_body(name);
        body.parent = parent[k];
        assert_int_equal(add(m, body), k);
    }
    assert_int_equal(mbsr_model_finish(m), MBSR_ERR_CYCLE);
    const int body = mbsr_model_error(m)->body;
    while (*on != MBSR_NONE && *on != body) ++on;
    assert_int_equal(*on, body);
    snprintf(words, sizeof words, "body %d 'link%d'|body %d 'link%d'|cycle", body, body,
             parent[body], parent[body]);
    finish_refused(m, MBSR_ERR_CYCLE, body, MBSR_NONE, words);
}

static void cycles_are_refused_and_name_a_body_on_them(void **state)
{
    (void)state;
    cycle_refused(2, (const int[]){1, 0}, (const int[]){0, 1, MBSR_NONE});
    cycle_refused(3, (const int[]){1, 2, 0}, (const int[]){0, 1, 2, MBSR_NONE});
    /* beside a sound tree, in front of it and behind it */
    cycle_refused(4, (const int[]){-1, 2, 1, 0}, (const int[]){1, 2, MBSR_NONE});
    /* tails that hang on the cycle 3, 4 and are not on it */
    cycle_refused(6, (const int[]){-1, 2, 3, 4, 3, 1}, (const int[]){3, 4, MBSR_NONE});
}

static void ids_stay_valid_under_any_order_of_adding(void **state)
{
    (void)state;
    /* a tree of seven bodies, parents later than children, d distinguishes the bodies */
    static const int parent[] = {4, 0, 6, 4, -1, -1, 5};
    mbsr_model *m = new_model();
    char name[16];
    for (int k = 0; k < 7; ++k) {
        snprintf(name, sizeof name, "body%d", k);
        mbsr_body_def body = general_body(name, 8, k % 3 + 1);
        body.parent = parent[k];
        assert_int_equal(add(m, body), k);
        memset(name, 'x', sizeof name - 1); /* the caller's buffer may go */
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_model_bodies(m), 7);
    for (int k = 0, at = 0; k < 7; ++k) {
        int q = -9, nq = -9, u = -9, n = -9;
        snprintf(name, sizeof name, "body%d", k);
        assert_string_equal(mbsr_body_name(m, k), name);
        assert_int_equal(mbsr_model_find_body(m, name), k);
        assert_int_equal(mbsr_body_parent(m, k), parent[k]);
        assert_int_equal(mbsr_body_dimension(m, k), 8);
        assert_int_equal(mbsr_body_pose_size(m, k), 8);
        assert_int_equal(mbsr_body_coordinates(m, k, &q, &nq, &u, &n), MBSR_OK);
        assert_int_equal(q, at);
        assert_int_equal(u, at);
        assert_int_equal(nq, k % 3 + 1);
        assert_int_equal(n, k % 3 + 1);
        at += n;
    }
    assert_int_equal(mbsr_model_nu(m), 13);
    assert_int_equal(mbsr_model_nq(m), 13);
    mbsr_model_destroy(m);
}

static void the_same_tree_in_another_order_moves_the_same(void **state)
{
    (void)state;
    /* a chain 0-1-2 added forwards and backwards: the last body is where the coordinates add up
     * to */
    for (int backwards = 0; backwards < 2; ++backwards) {
        mbsr_model *m = new_model();
        mbsr_data *d;
        double q[6], pose[2];
        for (int k = 0; k < 3; ++k) {
            const int link = backwards ? 2 - k : k;
            mbsr_body_def body = right_body(NULL);
            body.parent = link == 0 ? MBSR_GROUND : backwards ? k + 1 : k - 1;
            assert_int_equal(add(m, body), k);
            q[2 * k] = 1.0 + link;
            q[2 * k + 1] = 10.0 * (1.0 + link);
        }
        assert_int_equal(mbsr_model_finish(m), MBSR_OK);
        assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
        assert_int_equal(mbsr_stage_positions(m, d, 0.0, q), MBSR_OK);
        assert_int_equal(mbsr_body_pose(m, d, backwards ? 1 : 1, pose), MBSR_OK);
        assert_close(pose[0], 3.0, 0.0);
        assert_int_equal(mbsr_body_pose(m, d, backwards ? 0 : 2, pose), MBSR_OK);
        assert_close(pose[0], 6.0, 0.0);
        assert_close(pose[1], 60.0, 0.0);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* ---- inertias -------------------------------------------------------------------------------- */

static void matrix_refused(const double *matrix, const char *words)
{
    mbsr_body_def body = planar_body("rod");
    body.inertia = mbsr_inertia_matrix(3, matrix);
    char all[128];
    snprintf(all, sizeof all, "body 1 'rod'|inertia.matrix|%s", words);
    body_refused(body, MBSR_ERR_VALUE, all);
}

static void mass_matrices_that_are_none_are_refused(void **state)
{
    (void)state;
    matrix_refused((const double[]){1, 0, 0, 0.5, 1, 0, 0, 0, 1},
                   "not symmetric|(0,1) is 0.5|(1,0) is 0");
    matrix_refused((const double[]){1, 2, 0, 2, 1, 0, 0, 0, 1}, "indefinite|eigenvalue -1");
    matrix_refused((const double[]){1, 0, 0, 0, NAN, 0, 0, 0, 1}, "(1,1) is");
    matrix_refused((const double[]){1, 0, NAN, 0, 1, 0, 0, 0, 1}, "nan");
    matrix_refused((const double[]){1, 0, INFINITY, 0, 1, 0, INFINITY, 0, 1}, "inf");
    matrix_refused((const double[]){1, 0, 0, 0, 1, 0, 0, 0, -2}, "(2,2) is -2|negative");
    matrix_refused((const double[]){0, 0.25, 0, 0.25, 1, 0, 0, 0, 1},
                   "indefinite|0.25|zero diagonal");
    /* the same verdict in any units: entries of 1e-9 and 1e9 */
    matrix_refused((const double[]){1e-18, 2, 0, 2, 1e18, 0, 0, 0, 1}, "indefinite");
}

static void mass_matrices_at_the_border_are_accepted(void **state)
{
    (void)state;
    static const double border[][9] = {
        {0},                                   /* zero */
        {1, 1, 1, 1, 1, 1, 1, 1, 1},           /* rank 1 */
        {1e-18, 1, 0, 1, 1e18, 0, 0, 0, 0},    /* rank 1 in very different units */
        {1, -1, 0, -1, 1 - 1e-15, 0, 0, 0, 0}, /* indefinite by rounding */
        {1, 1e-17, 0, -1e-17, 1, 0, 0, 0, 1},  /* unsymmetric by rounding */
    };
    for (size_t k = 0; k < sizeof border / sizeof border[0]; ++k) {
        mbsr_model *m = new_model();
        mbsr_body_def body = planar_body("border");
        body.inertia = mbsr_inertia_matrix(3, border[k]);
        add(m, body);
        still_usable(m);
    }
}

static void a_matrix_of_the_wrong_size_or_missing_is_refused(void **state)
{
    (void)state;
    const double matrix[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    mbsr_body_def body = right_body("rod");
    body.inertia = mbsr_inertia_matrix(3, matrix);
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|inertia.matrix is 3 x 3|d = 2");
    body.inertia = mbsr_inertia_matrix(2, NULL);
    body_refused(body, MBSR_ERR_NULL, "body 1 'rod'|inertia.matrix is NULL");
    body.inertia = mbsr_inertia_function(NULL, NULL);
    body_refused(body, MBSR_ERR_NULL, "body 1 'rod'|inertia.function is NULL");
    body.inertia.kind = (mbsr_inertia_kind)42;
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|inertia.kind is 42");
}

static void masses_moments_and_centres_out_of_range_are_refused(void **state)
{
    (void)state;
    const struct {
        double mass, com[2], moment;
        const char *words;
    } wrong[] = {
        {-1.0, {0, 0}, 1.0, "inertia.mass is -1"},
        {NAN, {0, 0}, 1.0, "inertia.mass is"},
        {INFINITY, {0, 0}, 1.0, "inertia.mass is inf"},
        {1.0, {0, 0}, -3.0, "inertia.moment is -3"},
        {1.0, {0, 0}, NAN, "inertia.moment is"},
        {1.0, {0, 0}, INFINITY, "inertia.moment is inf"},
        {1.0, {NAN, 0.5}, 1.0, "inertia.com is|0.5"},
        {1.0, {0.5, INFINITY}, 1.0, "inertia.com is (0.5, inf)"},
    };
    mbsr_body_def body = planar_body("rod");
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        char words[128];
        snprintf(words, sizeof words, "body 1 'rod'|%s", wrong[k].words);
        body.inertia = mbsr_inertia_planar(wrong[k].mass, wrong[k].com, wrong[k].moment);
        body_refused(body, MBSR_ERR_VALUE, words);
    }
    body.inertia = mbsr_inertia_particle(-0.5);
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|inertia.mass is -0.5");
}

static void inertias_of_another_space_are_refused(void **state)
{
    (void)state;
    mbsr_body_def body = general_body("abstract", 2, 2);
    body.inertia = mbsr_inertia_particle(1.0);
    body_refused(body, MBSR_ERR_SPACE, "body 1 'abstract'|particle");
    body.inertia = mbsr_inertia_planar(1.0, (const double[2]){0, 0}, 1.0);
    body_refused(body, MBSR_ERR_SPACE, "body 1 'abstract'|planar");
    body = right_body("bead");
    body.inertia = mbsr_inertia_planar(1.0, (const double[2]){0, 0}, 1.0);
    body_refused(body, MBSR_ERR_SPACE, "body 1 'bead'|planar");
}

/* ---- joints ---------------------------------------------------------------------------------- */

static void joints_with_wrong_numbers_are_refused(void **state)
{
    (void)state;
    enum { SPACE, D, NP, N, NQ };
    const struct {
        int field, value;
        const char *words;
    } wrong[] = {
        {N, 3, "n is 3|d = 2"},
        {N, -1, "n is -1"},
        {D, 0, "d is 0"},
        {D, -4, "d is -4"},
        {D, 257, "d is 257"},
        {NQ, 1, "nq is 1"},
        {NQ, -1, "nq is -1"},
        {NP, -1, "np is -1"},
        {SPACE, 0, "space is 0"},
        {SPACE, 7, "space is 7"},
        {SPACE, MBSR_SPACE_PLANAR, "d = 2, np = 2|d = 3, np = 3"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        mbsr_body_def body = general_body("rod", 2, 2);
        int *const field[] = {NULL, &body.joint.d, &body.joint.np, &body.joint.n, &body.joint.nq};
        char words[128];
        snprintf(words, sizeof words, "body 1 'rod'|joint 'general'|%s", wrong[k].words);
        if (wrong[k].field == SPACE) {
            body.joint.space = (mbsr_space)wrong[k].value;
        } else {
            *field[wrong[k].field] = wrong[k].value;
        }
        body_refused(body, MBSR_ERR_VALUE, words);
    }
    mbsr_body_def body = right_body("rod");
    body.joint.param[4] = NAN;
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|joint 'planar'|param[4] is");
    body.joint.param[4] = -INFINITY;
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|joint 'planar'|param[4] is -inf");
}

static void joint_tables_that_lack_something_are_refused(void **state)
{
    (void)state;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "rod";
    body_refused(body, MBSR_ERR_VALUE, "body 1 'rod'|joint.table is NULL");
    for (int lack = 0; lack < 5; ++lack) {
        mbsr_joint_table table = general;
        if (lack == 0) table.version = 99;
        if (lack == 1) table.name = NULL;
        if (lack == 2) table.position = NULL;
        if (lack == 3) table.jacobians = NULL;
        if (lack == 4) table.bias = NULL;
        body.joint = mbsr_joint_custom(&table, 2, 2, NULL);
        body_refused(body, MBSR_ERR_VALUE,
                     lack == 0 ? "body 1 'rod'|version is 99|1"
                               : "body 1 'rod'|name, position, jacobians and bias");
    }
}

static int no_motion(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t, (void)s, (void)sdot, (void)sddot;
    return 0;
}

/* A body with this joint is refused. */
static void joint_refused(mbsr_joint joint, int status, const char *words)
{
    mbsr_body_def body = mbsr_default_body_def();
    char all[128];
    body.name = "rod";
    body.joint = joint;
    snprintf(all, sizeof all, "body 1 'rod'|joint 'planar'|%s", words);
    body_refused(body, status, all);
}

static void masks_of_planar_joints_are_checked(void **state)
{
    (void)state;
    const mbsr_planar_frame o = at_origin;
    joint_refused(mbsr_joint_planar(o, o, MBSR_X | 8, 0, NULL, NULL), MBSR_ERR_VALUE, "free is 9");
    joint_refused(mbsr_joint_planar(o, o, -1, 0, NULL, NULL), MBSR_ERR_VALUE, "free is -1");
    joint_refused(mbsr_joint_planar(o, o, 0, 16, no_motion, NULL), MBSR_ERR_VALUE, "driven is 16");
    joint_refused(mbsr_joint_planar(o, o, 0, -2, no_motion, NULL), MBSR_ERR_VALUE, "driven is -2");
    joint_refused(mbsr_joint_planar(o, o, MBSR_X | MBSR_Y, MBSR_Y, no_motion, NULL), MBSR_ERR_VALUE,
                  "free is 3|driven is 2");
    joint_refused(mbsr_joint_planar(o, o, MBSR_X, MBSR_Y, NULL, NULL), MBSR_ERR_VALUE,
                  "driven is 2|motion is NULL");
    joint_refused(mbsr_joint_point(o, MBSR_X | MBSR_ANGLE, 0, NULL, NULL), MBSR_ERR_VALUE,
                  "free is 5");
    joint_refused(mbsr_joint_point(o, 0, MBSR_ANGLE, no_motion, NULL), MBSR_ERR_VALUE,
                  "driven is 4");
    mbsr_joint changed = mbsr_joint_planar_revolute(o, o);
    changed.n = changed.nq = 2;
    joint_refused(changed, MBSR_ERR_VALUE, "free is 4|n = 2");
}

static void a_planar_joint_on_a_general_predecessor_is_refused(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    mbsr_body_def body = planar_body("rod");
    body.parent = add(m, general_body("abstract", 3, 3));
    add(m, body);
    finish_refused(m, MBSR_ERR_SPACE, 1, MBSR_NONE, "body 1 'rod'|joint 'planar'|GENERAL");
}

static int refuse_17(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                     char text[MBSR_TEXT_SIZE])
{
    assert_int_equal(pred_space, MBSR_SPACE_POINT);
    assert_int_equal(pred_d, 2);
    if (joint->user) snprintf(text, MBSR_TEXT_SIZE, "%s", (const char *)joint->user);
    return -17;
}

static void what_a_joint_check_returns_is_passed_on_with_its_text(void **state)
{
    (void)state;
    mbsr_joint_table table = general;
    char long_text[MBSR_TEXT_SIZE];
    table.check = refuse_17;
    memset(long_text, 'z', sizeof long_text);
    long_text[sizeof long_text - 1] = '\0';
    const char *texts[] = {"too hot", NULL, long_text};
    const char *words[] = {"too hot", "callback", "zzzz"};
    for (int k = 0; k < 3; ++k) {
        mbsr_model *m = new_model();
        mbsr_body_def body = general_body("rod", 2, 2);
        body.joint = mbsr_joint_custom(&table, 2, 2, (void *)(size_t)texts[k]);
        body.parent = add(m, right_body("base"));
        add(m, body);
        assert_int_equal(mbsr_model_finish(m), -17);
        assert_contains(mbsr_model_error(m)->text, words[k]);
        finish_refused(m, -17, 1, MBSR_NONE, "body 1 'rod'|joint 'general'");
    }
}

/* ---- force elements -------------------------------------------------------------------------- */

static int no_value(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n, (void)value;
    return 0;
}

static void force_tables_and_body_lists_are_checked(void **state)
{
    (void)state;
    const int three[] = {0, 0, 0};
    mbsr_force_def force = mbsr_force_custom(NULL, 1, three, NULL);
    force.name = "pull";
    force_refused(force, MBSR_ERR_VALUE, "force 0 'pull'|table is NULL");
    for (int lack = 0; lack < 3; ++lack) {
        mbsr_force_table table = nothing;
        if (lack == 0) table.version = MBSR_FORCE_TABLE_VERSION + 1;
        if (lack == 1) table.name = NULL;
        if (lack == 2) table.evaluate = NULL;
        force = mbsr_force_custom(&table, 1, three, NULL);
        force_refused(force, MBSR_ERR_VALUE, "force 0|version|name or evaluate");
    }
    force = mbsr_force_custom(&nothing, 3, NULL, NULL);
    force.name = "pull";
    force_refused(force, MBSR_ERR_VALUE, "force 0 'pull' (nothing)|bodies is 3|body_list is NULL");
    force_refused(mbsr_force_custom(&nothing, -1, three, NULL), MBSR_ERR_VALUE,
                  "force 0|nothing|bodies is -1");
    force_refused(mbsr_force_custom(&nothing, 2, (const int[]){0, -2}, NULL), MBSR_ERR_ID,
                  "force 0|nothing|body number 1 is -2");
    /* a list was promised and is missing */
    force_refused(mbsr_force_custom(&nothing, 2, NULL, NULL), MBSR_ERR_ID,
                  "force 0|nothing|body number 0");
    force = mbsr_force_gravity(0.0, -9.81, 0.0);
    force.bodies = 1;
    force_refused(force, MBSR_ERR_VALUE, "gravity|bodies is 1");
}

static void parameters_of_forces_must_be_finite(void **state)
{
    (void)state;
    mbsr_force_def force = mbsr_force_gravity(0.0, NAN, 0.0);
    force.name = "fall";
    force_refused(force, MBSR_ERR_VALUE, "force 0 'fall' (gravity)|param[1] (gy) is nan");
    force_refused(mbsr_force_axis_spring(0, MBSR_GROUND, 0, INFINITY, 0, 0), MBSR_ERR_VALUE,
                  "force 0|axis spring-damper|param[0] (stiffness) is inf");
    force_refused(mbsr_force_joint_spring(0, 0, 1, 1, NAN), MBSR_ERR_VALUE,
                  "joint spring-damper|param[2] (rest) is nan");
}

/* A model of a point 0, a planar body 1 and a general body 2 refuses the element when it is
 * finished. */
static void force_refused_at_the_end(mbsr_force_def force, int status, const char *words)
{
    mbsr_model *m = new_model();
    char all[128];
    force.name = "pull";
    add(m, right_body("bead"));
    add(m, planar_body("rod"));
    add(m, general_body("abstract", 2, 1));
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    snprintf(all, sizeof all, "force 0 'pull'|%s", words);
    finish_refused(m, status, MBSR_NONE, 0, all);
}

static void forces_refuse_bodies_they_cannot_act_on(void **state)
{
    (void)state;
    const double o[3] = {0}, off[3] = {0.5};
    const int ground = MBSR_GROUND;
    force_refused_at_the_end(mbsr_force_axis_spring(7, 0, 0, 1, 1, 0), MBSR_ERR_ID,
                             "body 7|3 bodies");
    force_refused_at_the_end(mbsr_force_axis_spring(0, 3, 0, 1, 1, 0), MBSR_ERR_ID,
                             "body 3|3 bodies");
    force_refused_at_the_end(mbsr_force_axis_spring(0, ground, 2, 1, 1, 0), MBSR_ERR_VALUE,
                             "axis is 2|body 0");
    force_refused_at_the_end(mbsr_force_axis_spring(1, 0, 2, 1, 1, 0), MBSR_ERR_VALUE,
                             "axis is 2|body 0");
    force_refused_at_the_end(mbsr_force_axis_spring(1, ground, -1, 1, 1, 0), MBSR_ERR_VALUE,
                             "axis is -1|body 1");
    force_refused_at_the_end(mbsr_force_axis_spring(1, 1, 0, 1, 1, 0), MBSR_ERR_ID,
                             "both ends|body 1");
    force_refused_at_the_end(mbsr_force_axis_spring(ground, ground, 0, 1, 1, 0), MBSR_ERR_ID,
                             "both ends|body -1");
    force_refused_at_the_end(mbsr_force_point_spring(1, o, 1, off, 1, 1, 1), MBSR_ERR_ID,
                             "both ends|body 1");
    force_refused_at_the_end(mbsr_force_point_spring(1, o, 0, off, 1, 1, 1), MBSR_ERR_VALUE,
                             "point_b is (0.5, 0, 0)|body 0|POINT");
    force_refused_at_the_end(mbsr_force_point_spring(0, off, 1, o, 1, 1, 1), MBSR_ERR_VALUE,
                             "point_a is (0.5, 0, 0)|body 0");
    force_refused_at_the_end(mbsr_force_point_spring(1, o, 2, o, 1, 1, 1), MBSR_ERR_SPACE,
                             "body 2|GENERAL");
    force_refused_at_the_end(mbsr_force_point_spring(1, o, ground, o, 1, 1, -0.25), MBSR_ERR_VALUE,
                             "param[2] (free_length) is -0.25, negative");
    force_refused_at_the_end(mbsr_force_joint_spring(2, 1, 1, 1, 0), MBSR_ERR_VALUE,
                             "coordinate is 1|body 2 has 1");
    force_refused_at_the_end(mbsr_force_joint_spring(0, -1, 1, 1, 0), MBSR_ERR_VALUE,
                             "coordinate is -1|body 0");
    force_refused_at_the_end(mbsr_force_joint_spring(ground, 0, 1, 1, 0), MBSR_ERR_VALUE,
                             "coordinate is 0");
    force_refused(mbsr_force_applied(0, NULL, NULL), MBSR_ERR_NULL, "function is NULL");
    force_refused_at_the_end(mbsr_force_applied(ground, no_value, NULL), MBSR_ERR_ID, "ground");
    force_refused_at_the_end(mbsr_force_joint_applied(ground, no_value, NULL), MBSR_ERR_ID,
                             "ground");
}

/* ---- copies ---------------------------------------------------------------------------------- */

static int count_bodies(const mbsr_force_args *args)
{
    for (int k = 0; k < args->bodies; ++k) ((int *)args->force->user)[k] = args->body[k].id;
    return 0;
}

static void everything_a_definition_points_to_is_copied(void **state)
{
    (void)state;
    const mbsr_force_table record = {
        .version = MBSR_FORCE_TABLE_VERSION, .name = "record", .evaluate = count_bodies};
    char name[] = "bead", force_name[] = "record";
    double matrix[4] = {2, 1, 1, 3}, mass[36];
    int list[3] = {2, MBSR_GROUND, 0}, seen[3] = {99, 99, 99};
    mbsr_model *m = new_model();
    mbsr_data *d;
    mbsr_body_def body = right_body(name);
    body.inertia = mbsr_inertia_matrix(2, matrix);
    mbsr_force_def force = mbsr_force_custom(&record, 3, list, seen);
    force.name = force_name;
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    for (int k = 0; k < 3; ++k) add(m, body);
    memset(name, 'x', sizeof name);
    memset(force_name, 'x', sizeof force_name);
    memset(matrix, 0, sizeof matrix);
    memset(list, 0, sizeof list);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_string_equal(mbsr_body_name(m, 0), "bead");
    assert_int_equal(mbsr_model_find_body(m, "bead"), 0); /* the first of that name */
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    const double zero[6] = {0};
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, zero), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, zero), MBSR_OK);
    assert_int_equal(mbsr_stage_forces(m, d, NULL), MBSR_OK);
    assert_int_equal(seen[0], 2);
    assert_int_equal(seen[1], MBSR_GROUND);
    assert_int_equal(seen[2], 0);
    for (int k = 0; k < 36; ++k) mass[k] = 7.0;
    assert_int_equal(mbsr_mass_matrix(m, d, mass), MBSR_OK);
    assert_close(mass[2], 0.0, 0.0); /* bodies side by side do not couple */
    assert_close(mass[0], 2.0, 0.0);
    assert_close(mass[1], 1.0, 0.0);
    assert_close(mass[4 * 6 + 5], 1.0, 0.0);
    assert_close(mass[5 * 6 + 5], 3.0, 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- finished and unfinished ----------------------------------------------------------------- */

static void a_finished_model_cannot_be_changed(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    const mbsr_body_def body = right_body("late");
    const mbsr_force_def force = mbsr_force_gravity(0, -1, 0.0);
    int id = 77;
    add(m, body);
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_refused(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m), MBSR_ERR_FINISHED,
                   MBSR_NONE, MBSR_NONE, "mbsr_model_add_body|finished");
    assert_refused(mbsr_model_add_force(m, &force, &id), mbsr_model_error(m), MBSR_ERR_FINISHED,
                   MBSR_NONE, MBSR_NONE, "mbsr_model_add_force|finished");
    assert_refused(mbsr_model_finish(m), mbsr_model_error(m), MBSR_ERR_FINISHED, MBSR_NONE,
                   MBSR_NONE, "mbsr_model_finish|finished");
    assert_int_equal(id, 77);
    assert_int_equal(mbsr_model_bodies(m), 1);
    assert_int_equal(mbsr_model_forces(m), 0);
    mbsr_model_destroy(m);
}

/* What a model that is NULL or not finished answers. */
static void unusable(mbsr_model *m)
{
    mbsr_data *d = (mbsr_data *)&d;
    mbsr_error error;
    double id[8];
    const int status = m ? MBSR_ERR_UNFINISHED : MBSR_ERR_NULL;
    assert_int_equal(mbsr_model_bodies(m), -1);
    assert_close(mbsr_model_length(m), -1.0, 0.0);
    assert_close(mbsr_model_rate(m), -1.0, 0.0);
    assert_int_equal(mbsr_model_forces(m), -1);
    assert_int_equal(mbsr_model_nq(m), -1);
    assert_int_equal(mbsr_model_nu(m), -1);
    assert_int_equal(mbsr_body_coordinates(m, 0, NULL, NULL, NULL, NULL), status);
    assert_int_equal(mbsr_body_parent(m, 0), MBSR_NONE);
    assert_int_equal(mbsr_body_dimension(m, 0), -1);
    assert_int_equal(mbsr_body_pose_size(m, 0), -1);
    assert_null(mbsr_body_name(m, 0));
    assert_int_equal(mbsr_model_find_body(m, "bead"), MBSR_NONE);
    assert_int_equal(mbsr_data_size(m), 0);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_RECURSIVE), -1);
    assert_int_equal(mbsr_dae_id(m, NULL, MBSR_DAE_RECURSIVE, id), MBSR_ERR_NULL);
    assert_int_equal(mbsr_data_create(m, &d, &error), status);
    assert_int_equal(error.status, status);
    assert_null(d);
    d = (mbsr_data *)&d;
    assert_int_equal(mbsr_data_init(m, id, sizeof id, &d, &error), status);
    assert_int_equal(error.status, status);
    assert_null(d);
}

static void an_unfinished_model_answers_nothing(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    unusable(NULL);
    unusable(m);
    add(m, right_body("bead"));
    unusable(m);
    still_usable(m);
}

static void ids_that_do_not_exist_are_answered_as_the_header_says(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    add(m, right_body(NULL));
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    static const int wrong[] = {MBSR_GROUND, MBSR_NONE, 1, 1000000};
    for (int k = 0; k < 4; ++k) {
        assert_int_equal(mbsr_body_coordinates(m, wrong[k], NULL, NULL, NULL, NULL), MBSR_ERR_ID);
        assert_int_equal(mbsr_body_parent(m, wrong[k]), MBSR_NONE);
        assert_int_equal(mbsr_body_dimension(m, wrong[k]), -1);
        assert_int_equal(mbsr_body_pose_size(m, wrong[k]), -1);
        assert_null(mbsr_body_name(m, wrong[k]));
    }
    assert_string_equal(mbsr_body_name(m, 0), "");
    assert_int_equal(mbsr_body_parent(m, 0), MBSR_GROUND);
    assert_int_equal(mbsr_model_find_body(m, "bead"), MBSR_NONE);
    assert_int_equal(mbsr_model_find_body(m, NULL), MBSR_NONE);
    mbsr_model_destroy(m);
}

/* ---- extreme sizes --------------------------------------------------------------------------- */

static void an_empty_model_finishes_and_is_evaluated(void **state)
{
    (void)state;
    mbsr_model *m = new_model();
    mbsr_data *d;
    double y = 7.0, T = 7.0, E = 7.0;
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_int_equal(mbsr_model_bodies(m), 0);
    assert_close(mbsr_model_length(m), 0.0, 0.0);
    assert_close(mbsr_model_rate(m), 0.0, 0.0);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_INVERSE_DYNAMICS), 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, &y, &y, NULL, &y), MBSR_OK);
    assert_int_equal(mbsr_total_rank(m, d), 0);
    assert_int_equal(mbsr_energy(m, d, &T, &E), MBSR_OK);
    assert_close(T, 0.0, 0.0);
    assert_close(E, 0.0, 0.0);
    assert_int_equal(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, &y, &y, NULL, NULL),
                     MBSR_OK);
    assert_close(y, 7.0, 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    still_usable(new_model());
}

static void a_chain_of_many_bodies_finishes_in_both_orders(void **state)
{
    (void)state;
    const int count = test_seeds_short(40000, 200000);
    for (int backwards = 0; backwards < 2; ++backwards) {
        mbsr_model *m = new_model();
        mbsr_body_def body = right_body(NULL);
        for (int k = 0; k < count; ++k) {
            body.parent = backwards ? (k + 1 < count ? k + 1 : MBSR_GROUND) : k - 1;
            if (mbsr_model_add_body(m, &body, NULL)) fail();
        }
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_int_equal(mbsr_model_nu(m), 2 * count);
        assert_int_equal(mbsr_body_parent(m, count / 2), backwards ? count / 2 + 1 : count / 2 - 1);
        mbsr_model_destroy(m);
    }
    /* and a cycle of that length is found */
    mbsr_model *m = new_model();
    mbsr_body_def body = right_body(NULL);
    for (int k = 0; k < count; ++k) {
        body.parent = (k + 1) % count;
        if (mbsr_model_add_body(m, &body, NULL)) fail();
    }
    assert_int_equal(mbsr_model_finish(m), MBSR_ERR_CYCLE);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(definitions_without_their_default_call_are_refused),
        cmocka_unit_test(null_arguments_are_refused),
        cmocka_unit_test(model_options_out_of_range_are_refused),
        cmocka_unit_test(roots_with_wrong_sizes_are_refused),
        cmocka_unit_test(a_parent_below_ground_or_the_body_itself_is_refused),
        cmocka_unit_test(a_parent_that_never_comes_is_refused_at_the_end),
        cmocka_unit_test(cycles_are_refused_and_name_a_body_on_them),
        cmocka_unit_test(ids_stay_valid_under_any_order_of_adding),
        cmocka_unit_test(the_same_tree_in_another_order_moves_the_same),
        cmocka_unit_test(mass_matrices_that_are_none_are_refused),
        cmocka_unit_test(mass_matrices_at_the_border_are_accepted),
        cmocka_unit_test(a_matrix_of_the_wrong_size_or_missing_is_refused),
        cmocka_unit_test(masses_moments_and_centres_out_of_range_are_refused),
        cmocka_unit_test(inertias_of_another_space_are_refused),
        cmocka_unit_test(joints_with_wrong_numbers_are_refused),
        cmocka_unit_test(joint_tables_that_lack_something_are_refused),
        cmocka_unit_test(masks_of_planar_joints_are_checked),
        cmocka_unit_test(a_planar_joint_on_a_general_predecessor_is_refused),
        cmocka_unit_test(what_a_joint_check_returns_is_passed_on_with_its_text),
        cmocka_unit_test(force_tables_and_body_lists_are_checked),
        cmocka_unit_test(parameters_of_forces_must_be_finite),
        cmocka_unit_test(forces_refuse_bodies_they_cannot_act_on),
        cmocka_unit_test(everything_a_definition_points_to_is_copied),
        cmocka_unit_test(a_finished_model_cannot_be_changed),
        cmocka_unit_test(an_unfinished_model_answers_nothing),
        cmocka_unit_test(ids_that_do_not_exist_are_answered_as_the_header_says),
        cmocka_unit_test(an_empty_model_finishes_and_is_evaluated),
        cmocka_unit_test(a_chain_of_many_bodies_finishes_in_both_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
