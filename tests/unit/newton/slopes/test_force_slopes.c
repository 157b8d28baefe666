/* Derivatives of force elements: the elements' own against differences, these against elements
 * whose derivatives are plain, and what surrounds both.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "samples.h"

#include "newton/slopes/force_slopes.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

/* ---- a model of all kinds of bodies ---------------------------------------------------------- */

enum { SPATIAL_1, SPATIAL_2, PLANAR_1, PLANAR_2, POINT_1, POINT_2, GENERAL_1, JOINTED, BODIES };
enum { MARGIN = 8 }; /* numbers behind the work memory, which stay as they are */

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    test_counting counting;
    mbsri_slopes slopes, differences;
    double *memory[2];
    int *integers[2];
    size_t doubles, ints;
} scene;

static const mbsr_space space_of[BODIES] = {
    MBSR_SPACE_SPATIAL, MBSR_SPACE_SPATIAL, MBSR_SPACE_PLANAR,  MBSR_SPACE_PLANAR,
    MBSR_SPACE_POINT,   MBSR_SPACE_POINT,   MBSR_SPACE_GENERAL, MBSR_SPACE_SPATIAL};

/* A joint whose coordinates are the pose, whatever the space. */
static int same_position(const mbsr_joint_args *args, double *p)
{
    memcpy(p, args->q, (size_t)args->np * sizeof *p);
    return 0;
}

static int same_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K, (void)H, (void)kI;
    for (int k = 0; k < args->d; ++k) J[(args->d + 1) * k] = -1.0;
    return 0;
}

static int same_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static const mbsr_joint_table same = {.version = MBSR_JOINT_TABLE_VERSION,
                                      .flags = MBSR_JOINT_UNIT_K,
                                      .name = "coordinates are the pose",
                                      .position = same_position,
                                      .jacobians = same_jacobians,
                                      .bias = same_bias};

static mbsr_joint same_joint(mbsr_space space, int d)
{
    mbsr_joint joint = mbsr_joint_custom(&same, d, d, NULL);
    joint.space = space;
    return joint;
}

static int move_in_plane(void *user, double t, double *p, double *V, double *A)
{
    const int d = *(const int *)user;
    for (int k = 0; k < d; ++k) {
        p[k] = sample_wave(k, t, 0);
        V[k] = sample_wave(k, t, 1);
        A[k] = sample_wave(k, t, 2);
    }
    return 0;
}

/* d columns of d numbers of a symmetric matrix, positive definite. */
static void some_matrix(test_rng *rng, int d, double *matrix)
{
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k <= j; ++k)
            matrix[d * j + k] = matrix[d * k + j] = 0.1 * test_uniform(rng) + (j == k ? 1.0 : 0.0);
    }
}

static mbsr_inertia inertia_of(int id, test_rng *rng, double matrix[36])
{
    static const double tensor[6] = {0.7, 0.9, 1.1, 0.1, -0.2, 0.15};
    double com[3];
    test_fill(rng, 3, com);
    switch (id) {
    case SPATIAL_1: return mbsr_inertia_rigid(1.3, com, tensor);
    case PLANAR_1: return mbsr_inertia_planar(2.1, com, 0.4);
    case POINT_1:
    case JOINTED: return mbsr_inertia_particle(0.7);
    default: break;
    }
    const int d = space_of[id] == MBSR_SPACE_SPATIAL ? 6 : space_of[id] == MBSR_SPACE_POINT ? 2 : 3;
    some_matrix(rng, d, matrix);
    return mbsr_inertia_matrix(d, matrix);
}

/* Bodies on the root; what adds forces and finishes follows. */
static void scene_begin(scene *s, mbsr_space root)
{
    static const int d_of_point = 2, d_of_planar = 3;
    static const double axis[3] = {0.3, 1.0, -0.6};
    test_rng rng = test_seed(5);
    memset(s, 0, sizeof *s);
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = test_counting_allocator(&s->counting);
    if (root == MBSR_SPACE_SPATIAL)
        def.root = mbsr_root_moving(root, 6, MBSR_POSE_SIZE, sample_root, NULL);
    else if (root == MBSR_SPACE_PLANAR)
        def.root = mbsr_root_moving(root, 3, 3, move_in_plane, (void *)(uintptr_t)&d_of_planar);
    else if (root == MBSR_SPACE_POINT)
        def.root = mbsr_root_moving(root, 2, 2, move_in_plane, (void *)(uintptr_t)&d_of_point);
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
    for (int id = 0; id < BODIES; ++id) {
        double matrix[36];
        mbsr_body_def body = mbsr_default_body_def();
        const mbsr_space space = space_of[id];
        body.inertia = inertia_of(id, &rng, matrix);
        const mbsr_frame A = test_frame(&rng, 0.5), B = test_frame(&rng, 0.5);
        if (id == JOINTED)
            body.joint = mbsr_joint_universal(&A, &B, axis, A.x);
        else if (space == MBSR_SPACE_SPATIAL)
            body.joint = mbsr_joint_free(&A, &B);
        else
            body.joint = same_joint(space, space == MBSR_SPACE_POINT ? 2 : 3);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    double matrix[36];
    some_matrix(&rng, 6, matrix);
    assert_ok(mbsr_model_regularise(s->model, SPATIAL_1, 6, matrix), mbsr_model_error(s->model));
    some_matrix(&rng, 3, matrix);
    assert_ok(mbsr_model_regularise(s->model, PLANAR_1, 3, matrix), mbsr_model_error(s->model));
}

static void scene_add(scene *s, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
}

/* Slopes get memory of exactly the size asked for, of NaN, with a margin behind. */
static void place(const scene *s, int k, mbsri_slopes *slopes)
{
    for (size_t l = 0; l < s->doubles; ++l) s->memory[k][l] = NAN;
    for (size_t l = 0; l < MARGIN; ++l) s->memory[k][s->doubles + l] = 7.0;
    for (size_t l = 0; l < s->ints + MARGIN; ++l) s->integers[k][l] = 7;
    mbsri_slopes_place(s->model, MBSRI_SLOPES_WHOLE, slopes, s->memory[k], s->integers[k]);
}

static void scene_finish(scene *s)
{
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    mbsri_slopes_size(s->model, MBSRI_SLOPES_WHOLE, &s->doubles, &s->ints);
    for (int k = 0; k < 2; ++k) {
        s->memory[k] = calloc(s->doubles + MARGIN, sizeof(double));
        s->integers[k] = calloc(s->ints + MARGIN, sizeof(int));
    }
    place(s, 0, &s->slopes);
    place(s, 1, &s->differences);
}

static void scene_free(scene *s)
{
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < MARGIN; ++l) {
            assert_close(s->memory[k][s->doubles + (size_t)l], 7.0, 0.0);
            assert_int_equal(s->integers[k][s->ints + (size_t)l], 7);
        }
        free(s->memory[k]);
        free(s->integers[k]);
    }
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    assert_int_equal(s->counting.live, 0);
}

/* The state q, u at t; f and tau of the data are there as well. */
static void set_state(scene *s, double t, const double *q, const double *u)
{
    assert_ok(mbsr_stage_positions(s->model, s->data, t, q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, u), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_forces(s->model, s->data, NULL), mbsr_data_error(s->data));
}

enum { MAX_NQ = 40 };

static void random_state(scene *s, test_rng *rng)
{
    double q[MAX_NQ], u[MAX_NQ];
    assert_true(mbsr_model_nq(s->model) <= MAX_NQ);
    test_fill(rng, MAX_NQ, q);
    test_fill(rng, MAX_NQ, u);
    set_state(s, 0.4, q, u);
}

static const mbsri_force *force_of(const scene *s, int id)
{
    const mbsri_force *force = s->model->forces.data;
    while (force->id != id) ++force;
    return force;
}

/* ---- the elements' own against differences --------------------------------------------------- */

/* Fails where the two differ by more than the tolerance, relative to the largest entry; returns
 * that entry. Both get the bodies' rows and columns, which count up. */
static double compare(scene *s, int id, int body, double tolerance)
{
    const mbsri_force *force = force_of(s, id);
    assert_non_null(force->def.table->derivatives);
    assert_ok(mbsri_force_slopes(s->model, s->data, force, body, &s->slopes),
              mbsr_data_error(s->data));
    assert_ok(mbsri_force_differences(s->model, s->data, force, body, &s->differences),
              mbsr_data_error(s->data));
    const mbsr_force_derivatives *a = &s->slopes.out, *b = &s->differences.out;
    assert_int_equal(a->rows, b->rows);
    assert_int_equal(a->columns, b->columns);
    const int size = a->rows * a->columns;
    const double largest = test_largest(size, b->matrix);
    for (int k = 0; k < size; ++k) {
        if (fabs(a->matrix[k] - b->matrix[k]) <= tolerance * fmax(largest, 1e-3)) continue;
        print_error("%s, force %d: entry (%d, %d) of %d x %d is %.12g, by differences %.12g\n",
                    force->def.table->name, id, k % a->rows, k / a->rows, a->rows, a->columns,
                    a->matrix[k], b->matrix[k]);
        fail();
    }
    return largest;
}

/* Stiffness 1 .. 3 and damping of the law 5 x^2 + 0.3 v + x v. */
static int quadratic(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    assert_null(energy);
    assert_null(power);
    assert_close(*force, 0.0, 0.0);
    *force = 5.0 * x * x + 0.3 * v + x * v;
    return 0;
}

enum { LINEAR, CUBIC, TAUT, SMOOTH, BY_FUNCTION, SPRINGS };

static mbsr_force_def spring(test_rng *rng, int kind, int a, int b, const int origin[2])
{
    double point[2][3];
    for (int k = 0; k < 2; ++k) test_fill(rng, 3, point[k]);
    const mbsr_spring law = {.stiffness = 3.0,
                             .cubic = kind == LINEAR ? 0.0 : 1.2,
                             .damping = kind == SMOOTH ? 0.0 : 1.5,
                             .free_length = kind == SMOOTH || kind == TAUT ? 0.0 : 0.8,
                             .one_sided = kind == TAUT,
                             .function = kind == BY_FUNCTION ? quadratic : NULL};
    return mbsr_force_spring(a, origin[0] ? NULL : point[0], b, origin[1] ? NULL : point[1], &law);
}

static mbsr_force_def bushing(test_rng *rng, int a, int b)
{
    double stiffness[6], damping[6];
    const mbsr_frame A = test_frame(rng, 1.0), B = test_frame(rng, 1.0);
    for (int k = 0; k < 6; ++k) {
        stiffness[k] = 3.0 + test_uniform(rng);
        damping[k] = 1.5 + test_uniform(rng);
    }
    return mbsr_force_bushing(a, &A, b, &B, stiffness, damping);
}

/* Pressed in wherever the bodies are, being so large, and pressing, with so little damping. Where
 * slip is small, with so long a lever, differences are rough. */
static mbsr_force_def contact(test_rng *rng, int a, int b, int rough, double slip,
                              const int origin[2])
{
    mbsr_contact c = {.radius = 8.0,
                      .exponent = 1.5,
                      .stiffness = 0.3,
                      .damping = 0.04,
                      .friction = rough ? 0.7 : 0.0,
                      .slip = rough ? slip : 0.0,
                      .creep = rough > 1 ? 0.8 : 0.0};
    if (!origin[0]) test_fill(rng, 3, c.centre);
    if (!origin[1]) test_fill(rng, 3, c.point);
    test_fill(rng, 3, c.normal);
    return mbsr_force_contact(a, b, &c);
}

static int is_point(int id, mbsr_space root)
{
    return (id == MBSR_GROUND ? root : space_of[id]) == MBSR_SPACE_POINT;
}

/* Every spring between every two kinds of bodies, every pair in both orders. */
static void add_springs(scene *s, mbsr_space root, test_rng *rng)
{
    static const int ends[] = {SPATIAL_1, SPATIAL_2, PLANAR_1,   PLANAR_2,
                               POINT_1,   POINT_2,   MBSR_GROUND};
    for (int a = 0; a < 7; ++a) {
        for (int b = 0; b < 7; ++b) {
            const int origin[2] = {is_point(ends[a], root), is_point(ends[b], root)};
            for (int kind = 0; kind < SPRINGS && a != b; ++kind)
                scene_add(s, spring(rng, kind, ends[a], ends[b], origin));
        }
    }
}

static int turning_load(void *user, double t, int n, double *value)
{
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = sample_wave(k, t, 0);
    return 0;
}

/* Contacts, frictions of points and of bearings between every two kinds of bodies that have them.
 */
static int add_frictions(scene *s, mbsr_space root, test_rng *rng)
{
    static const int ends[] = {SPATIAL_1, SPATIAL_2, PLANAR_1,   PLANAR_2,
                               POINT_1,   POINT_2,   MBSR_GROUND};
    int count = 0;
    for (int a = 0; a < 7; ++a) {
        for (int b = 0; b < 7; ++b) {
            if (a == b) continue;
            const int origin[2] = {is_point(ends[a], root), is_point(ends[b], root)};
            for (int rough = 0; rough < 3 && ends[a] != MBSR_GROUND; ++rough, ++count)
                scene_add(s, contact(rng, ends[a], ends[b], rough,
                                     a < 2 && (b < 2 || b == 6) ? 0.3 : 0.8, origin));
            for (int kind = 0; kind < 3; ++kind, ++count) {
                double point[3];
                mbsr_friction law = {.coefficient = 0.7,
                                     .viscous = kind ? 0.4 : 0.0,
                                     .slip = 0.3,
                                     .creep = kind == 2 ? 0.8 : 0.0,
                                     .load = 2.5};
                test_fill(rng, 3, point);
                if (kind) test_fill(rng, 3, kind == 1 ? law.normal : law.axle);
                scene_add(
                    s, mbsr_force_point_friction(ends[a], origin[0] ? NULL : point, ends[b], &law));
            }
            for (int kind = 0; kind < 2 && !origin[0] && !origin[1]; ++kind, ++count) {
                mbsr_bearing law = {.torque = 1.7, .viscous = 0.4, .slip = 0.3};
                if (kind) test_fill(rng, 2, law.axis);
                law.axis[2] = kind; /* in the plane, too, there is some turning about it */
                scene_add(s, mbsr_force_bearing_friction(ends[a], ends[b], &law));
            }
        }
    }
    return count;
}

static mbsr_force_def plane_bushing(test_rng *rng, int a, int b)
{
    double matrix[2][9];
    for (int m = 0; m < 2; ++m) some_matrix(rng, 3, matrix[m]);
    double place[3];
    test_fill(rng, 3, place);
    const mbsr_planar_frame A = {place[0], place[1], 0.4}, B = {place[2], 0.2, -2.0};
    return mbsr_force_planar_bushing(a, A, b, B, matrix[0], matrix[1]);
}

static int add_others(scene *s, mbsr_space root, test_rng *rng)
{
    static const int ends[] = {SPATIAL_1, SPATIAL_2, MBSR_GROUND},
                     flat[] = {PLANAR_1, PLANAR_2, MBSR_GROUND};
    static const double point[3] = {0.3, -0.5, 0.9};
    int count = 2;
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            if (a == b) continue;
            scene_add(s, bushing(rng, ends[a], ends[b]));
            ++count;
            const int grounded = flat[a] == MBSR_GROUND || flat[b] == MBSR_GROUND;
            if (grounded && root != MBSR_SPACE_FIXED && root != MBSR_SPACE_PLANAR) continue;
            scene_add(s, plane_bushing(rng, flat[a], flat[b]));
            ++count;
        }
    }
    for (int axes = 0; axes < 2; ++axes)
        scene_add(s, mbsr_force_wrench(SPATIAL_2, point, axes, turning_load, NULL));
    return count;
}

enum { MAX_FORCES = 42 * (SPRINGS + 8) + 6 + 6 + 2 };

static void forces_between_points_and_frames(void **state)
{
    (void)state;
    static const mbsr_space roots[] = {MBSR_SPACE_FIXED, MBSR_SPACE_SPATIAL, MBSR_SPACE_PLANAR,
                                       MBSR_SPACE_POINT};
    for (int r = 0; r < 4; ++r) {
        scene s;
        test_rng rng = test_seed((uint64_t)r + 1);
        scene_begin(&s, roots[r]);
        add_springs(&s, roots[r], &rng);
        const int others = add_frictions(&s, roots[r], &rng) + add_others(&s, roots[r], &rng);
        scene_finish(&s);
        const int forces = mbsr_model_forces(s.model);
        assert_int_equal(forces, 42 * SPRINGS + others);
        assert_true(forces <= MAX_FORCES);
        double largest[MAX_FORCES] = {0.0};
        for (int round = 0; round < 4; ++round) {
            random_state(&s, &rng);
            for (int id = 0; id < forces; ++id)
                largest[id] = fmax(largest[id], compare(&s, id, 0, 1e-9));
        }
        for (int id = 0; id < forces; ++id) assert_less(0.05, largest[id]);
        scene_free(&s);
    }
}

static void gravity_of_every_kind_of_mass(void **state)
{
    (void)state;
    scene s;
    test_rng rng = test_seed(3);
    scene_begin(&s, MBSR_SPACE_SPATIAL);
    scene_add(&s, mbsr_force_gravity(1.3, -0.7, 2.1));
    scene_finish(&s);
    for (int round = 0; round < 20; ++round) {
        random_state(&s, &rng);
        for (int id = 0; id < BODIES; ++id) {
            const double largest = compare(&s, 0, s.model->index[id], 1e-9);
            const int turns = id == SPATIAL_1 || id == SPATIAL_2 || id == PLANAR_1;
            if (turns)
                assert_less(0.01, largest);
            else
                assert_close(largest, 0.0, 1e-11);
        }
    }
    scene_free(&s);
}

static void elements_on_coordinates(void **state)
{
    (void)state;
    scene s;
    test_rng rng = test_seed(4);
    scene_begin(&s, MBSR_SPACE_FIXED);
    for (int k = 0; k < 2; ++k) {
        scene_add(&s, mbsr_force_axis_spring(PLANAR_1, POINT_2, k, 3.0, 0.7, 0.1));
        scene_add(&s, mbsr_force_axis_spring(MBSR_GROUND, GENERAL_1, 1 + k, 3.0, 0.7, 0.1));
        scene_add(&s, mbsr_force_axis_spring(GENERAL_1, PLANAR_2, 2 * k, 3.0, 0.7, 0.1));
        scene_add(&s, mbsr_force_axis_friction(PLANAR_1, POINT_2, k, 3.0, 0.7));
        scene_add(&s, mbsr_force_axis_friction(MBSR_GROUND, GENERAL_1, 1 + k, 3.0, 0.7));
        scene_add(&s, mbsr_force_axis_friction(GENERAL_1, PLANAR_2, 2 * k, 3.0, 0.7));
        scene_add(&s, mbsr_force_joint_spring(JOINTED, k, 2.0, 0.4, 0.3));
        scene_add(&s, mbsr_force_joint_friction(JOINTED, k, 2.0, 0.4));
        scene_add(&s, mbsr_force_joint_friction(SPATIAL_1, 2 + k, 2.0, 0.4));
    }
    const int forces = 18;
    scene_add(&s, mbsr_force_applied(SPATIAL_1, turning_load, NULL));
    scene_add(&s, mbsr_force_joint_applied(SPATIAL_1, turning_load, NULL));
    scene_finish(&s);
    for (int round = 0; round < 20; ++round) {
        random_state(&s, &rng);
        for (int id = 0; id < forces; ++id) assert_less(0.05, compare(&s, id, 0, 1e-9));
        for (int id = forces; id < forces + 2; ++id)
            assert_close(compare(&s, id, 0, 1e-9), 0.0, 1e-11);
    }
    scene_free(&s);
}

/* ---- both sides of switches ------------------------------------------------------------------ */

/* Where POINT_1 is, how fast it moves along x, and the entries df/dx, df/dV that are expected. */
typedef struct switching {
    double x, v, by_x, by_v;
} switching;

/* Numbers of a body stand in the caller's q and u from here on; the rest is zero, with quaternions
 * of no rotation. */
static void plain_state(const scene *s, double *q, double *u)
{
    memset(q, 0, MAX_NQ * sizeof *q);
    memset(u, 0, MAX_NQ * sizeof *u);
    for (int id = SPATIAL_1; id <= SPATIAL_2; ++id) {
        int at;
        assert_int_equal(mbsr_body_coordinates(s->model, id, &at, NULL, NULL, NULL), 0);
        q[at] = 1.0;
    }
}

static double entry(const mbsr_force_derivatives *out, int row, int column)
{
    return out->matrix[column * out->rows + row];
}

/* A cable of length 1, F = 4 s + 2 s^3: slack, in between, damping as large as F either way. */
static void cables_on_both_sides(void **state)
{
    (void)state;
    static const switching list[] = {{0.7, 0.2, 0.0, 0.0},
                                     {1.5, 0.3, -(4.0 + 6.0 * 0.25), -3.0},
                                     {1.5, -0.3, -(4.0 + 6.0 * 0.25), -3.0},
                                     {1.5, 5.0, -2.0 * (4.0 + 6.0 * 0.25), 0.0},
                                     {1.5, -5.0, 0.0, 0.0},
                                     {0.0, 1.0, 0.0, 0.0}};
    const mbsr_spring law = {
        .stiffness = 4.0, .cubic = 2.0, .damping = 3.0, .free_length = 1.0, .one_sided = 1};
    scene s;
    scene_begin(&s, MBSR_SPACE_FIXED);
    scene_add(&s, mbsr_force_spring(POINT_1, NULL, MBSR_GROUND, NULL, &law));
    scene_finish(&s);
    for (int k = 0; k < 6; ++k) {
        double q[MAX_NQ], u[MAX_NQ];
        int iq, iu;
        plain_state(&s, q, u);
        assert_int_equal(mbsr_body_coordinates(s.model, POINT_1, &iq, NULL, &iu, NULL), 0);
        q[iq] = list[k].x;
        u[iu] = list[k].v;
        set_state(&s, 0.0, q, u);
        compare(&s, 0, 0, 1e-9);
        assert_close(entry(&s.slopes.out, 0, 0), list[k].by_x, 1e-13);
        assert_close(entry(&s.slopes.out, 0, 2), list[k].by_v, 1e-13);
    }
    scene_free(&s);
}

static void stops_on_both_sides(void **state)
{
    (void)state;
    /* lower stop -1, upper 2; F = 4 x, damping 3 */
    static const switching list[] = {{0.5, 1.0, 0.0, 0.0},    {2.5, 0.2, -4.0, -3.0},
                                     {2.5, 5.0, -8.0, 0.0},   {2.5, -5.0, 0.0, 0.0},
                                     {-1.5, 0.2, -4.0, -3.0}, {-1.5, 5.0, 0.0, 0.0},
                                     {-1.5, -5.0, -8.0, 0.0}};
    scene s;
    scene_begin(&s, MBSR_SPACE_FIXED);
    scene_add(&s, mbsr_force_joint_stop(JOINTED, 1, -1.0, 2.0, 4.0, 3.0));
    scene_add(&s, mbsr_force_joint_stop(JOINTED, 1, -INFINITY, 2.0, 4.0, 3.0));
    scene_finish(&s);
    for (int k = 0; k < 7; ++k) {
        double q[MAX_NQ], u[MAX_NQ];
        int iq, iu;
        plain_state(&s, q, u);
        assert_int_equal(mbsr_body_coordinates(s.model, JOINTED, &iq, NULL, &iu, NULL), 0);
        q[iq + 1] = list[k].x;
        u[iu + 1] = list[k].v;
        set_state(&s, 0.0, q, u);
        for (int id = 0; id < 2; ++id) {
            const double there = id == 1 && list[k].x < 0.0 ? 0.0 : 1.0;
            compare(&s, id, 0, 1e-9);
            /* rows f (6), tau; columns pose (6), V (6), q (2), u (2) */
            assert_int_equal(s.slopes.out.columns, 16);
            assert_close(entry(&s.slopes.out, 7, 13), there * list[k].by_x, 1e-13);
            assert_close(entry(&s.slopes.out, 7, 15), there * list[k].by_v, 1e-13);
        }
    }
    scene_free(&s);
}

/* A ball above the plane z = 0: apart, pressed, and leaving so fast that nothing presses. */
static void contacts_on_both_sides(void **state)
{
    (void)state;
    static const struct {
        double z, v, by_z;
    } list[] = {{1.1, 0.0, 0.0}, {0.8, 0.1, -1.0}, {0.8, -0.4, -1.0}, {0.8, 6.0, 0.0}};
    const mbsr_contact law = {.radius = 1.0,
                              .normal = {0.0, 0.0, 2.0},
                              .stiffness = 5.0,
                              .exponent = 2.0,
                              .damping = 0.5,
                              .friction = 0.3,
                              .slip = 0.1};
    scene s;
    scene_begin(&s, MBSR_SPACE_FIXED);
    scene_add(&s, mbsr_force_contact(SPATIAL_1, MBSR_GROUND, &law));
    scene_finish(&s);
    for (int k = 0; k < 4; ++k) {
        double q[MAX_NQ], u[MAX_NQ];
        plain_state(&s, q, u);
        set_state(&s, 0.0, q, u);
        /* the pose itself, past the frames of the joint */
        const mbsri_body *b = s.model->body + s.model->index[SPATIAL_1];
        double *p = s.data->p + b->p, *V = s.data->V + b->v;
        p[MBSR_POSE_X + 2] = list[k].z;
        V[3] = 0.3;
        V[5] = list[k].v;
        compare(&s, 0, 0, 1e-9);
        /* N = 5 x^2 (1 - 0.5 v), x = 1 - z */
        const double by_z = list[k].by_z * 10.0 * (1.0 - list[k].z) * (1.0 - 0.5 * list[k].v);
        assert_close(entry(&s.slopes.out, 5, 5), by_z, 1e-12);
    }
    scene_free(&s);
}

/* ---- points that coincide -------------------------------------------------------------------- */

static void springs_of_no_length(void **state)
{
    (void)state;
    const mbsr_spring smooth = {.stiffness = 4.0, .cubic = 2.0},
                      directed = {.stiffness = 4.0, .free_length = 0.5},
                      by_function = {.function = quadratic};
    scene s;
    scene_begin(&s, MBSR_SPACE_FIXED);
    scene_add(&s, mbsr_force_spring(POINT_1, NULL, POINT_2, NULL, &smooth));
    scene_add(&s, mbsr_force_spring(POINT_1, NULL, MBSR_GROUND, NULL, &directed));
    scene_add(&s, mbsr_force_spring(POINT_1, NULL, MBSR_GROUND, NULL, &by_function));
    scene_finish(&s);
    double q[MAX_NQ], u[MAX_NQ];
    plain_state(&s, q, u);
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
    compare(&s, 0, 0, 1e-9);
    assert_close(entry(&s.slopes.out, 0, 0), -4.0, 1e-13);
    for (int id = 1; id < 3; ++id) {
        assert_refused(mbsri_force_slopes(s.model, s.data, force_of(&s, id), 0, &s.slopes),
                       mbsr_data_error(s.data), MBSR_DEGENERATE_FORCE, MBSR_NONE, id,
                       "point spring-damper|derivatives returned");
    }
    scene_free(&s);
}

/* ---- bushings at large and small angles ------------------------------------------------------ */

/* Frames that are turned against each other by a given angle; the axes of the stiffness differ. */
static void bushings_at_all_angles(void **state)
{
    (void)state;
    static const double angle[] = {0.0, 1e-9, 1e-3, 0.0999, 0.1001, 0.5, 2.0, 3.0, 3.1};
    static const double stiffness[6] = {5.0, 1.0, 3.0, 2.0, 4.0, 1.0},
                        damping[6] = {0.2, 0.3, 0.1, 0.4, 0.2, 0.3}, axis[3] = {0.36, -0.48, 0.8};
    for (int k = 0; k < 9; ++k) {
        scene s;
        const mbsr_frame A = mbsr_frame_rotated(NULL, axis, 0.0),
                         B = mbsr_frame_rotated(NULL, axis, angle[k]);
        scene_begin(&s, MBSR_SPACE_FIXED);
        scene_add(&s, mbsr_force_bushing(SPATIAL_1, &A, SPATIAL_2, &B, stiffness, damping));
        scene_finish(&s);
        double q[MAX_NQ], u[MAX_NQ];
        plain_state(&s, q, u);
        set_state(&s, 0.0, q, u);
        for (int id = SPATIAL_1; id <= SPATIAL_2; ++id) {
            const mbsri_body *b = s.model->body + s.model->index[id];
            const mbsr_frame pose = mbsr_frame_rotated(NULL, (double[3]){1.0, 0.4, -0.3}, 0.7);
            memcpy(s.data->p + b->p, pose.R, sizeof pose.R);
        }
        /* near pi, where theta jumps, higher derivatives are large */
        compare(&s, 0, 0, angle[k] < 1.0 ? 5e-12 : 1e-10);
        scene_free(&s);
    }
}

/* ---- elements of the caller ------------------------------------------------------------------ */

/* Forces that are linear in p (r of a SPATIAL body), V, q, u with coefficients that tell which is
 * which; R counts by its first column c, with coefficients of 1 .. 3. */
static double coefficient(int row, int kind, int k)
{
    return sin(1.0 + row + 10.0 * kind + 100.0 * k);
}

typedef struct probe {
    int calls, fail_at, derived;
    const scene *watched; /* whose data must not be what the element is given; NULL: none */
} probe;

static int inside(const double *x, const double *array, size_t count)
{
    return x && (uintptr_t)x >= (uintptr_t)array && (uintptr_t)x < (uintptr_t)(array + count);
}

static void check_copies(const scene *s, const mbsr_force_body *b)
{
    const mbsr_model *m = s->model;
    const mbsr_data *d = s->data;
    assert_false(inside(b->p, d->p, m->size.p) || inside(b->V, d->V, m->size.v) ||
                 inside(b->M, d->M, m->size.dd) || inside(b->q, d->q, (size_t)m->nq) ||
                 inside(b->u, d->u, (size_t)m->nu) || inside(b->f, d->f, m->size.v) ||
                 inside(b->tau, d->tau, (size_t)m->nu));
}

static double weigh(const mbsr_force_args *args, int row)
{
    double sum = 0.0;
    for (int l = 0; l < args->bodies; ++l) {
        const mbsr_force_body *b = args->body + l;
        if (b->id == MBSR_GROUND) continue;
        const int spatial = b->space == MBSR_SPACE_SPATIAL;
        for (int k = 0; k < (spatial ? 3 : b->np); ++k)
            sum += coefficient(row, 4 * l, k) * b->p[spatial ? MBSR_POSE_X + k : k];
        for (int k = 0; k < 3 && spatial; ++k) sum += (1.0 + k) * b->p[k];
        for (int k = 0; k < b->d; ++k) sum += coefficient(row, 4 * l + 1, k) * b->V[k];
        for (int k = 0; k < b->nq; ++k) sum += coefficient(row, 4 * l + 2, k) * b->q[k];
        for (int k = 0; k < b->n; ++k) sum += coefficient(row, 4 * l + 3, k) * b->u[k];
    }
    return sum;
}

static int probe_evaluate(const mbsr_force_args *args)
{
    probe *p = args->force->user;
    if (++p->calls == p->fail_at) return 17;
    int row = 0;
    for (int l = 0; l < args->bodies; ++l) {
        const mbsr_force_body *b = args->body + l;
        const int ground = b->id == MBSR_GROUND;
        if (p->watched) check_copies(p->watched, b);
        for (int k = 0; k < b->d; ++k) b->f[k] += ground ? 1e9 : weigh(args, row++);
        for (int k = 0; k < b->n && !ground; ++k) b->tau[k] += weigh(args, row++);
    }
    return 0;
}

static const mbsr_force_table probe_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                             .flags = MBSR_FORCE_NO_MASS,
                                             .name = "probe",
                                             .evaluate = probe_evaluate};

/* Entries of the columns of body l; those of other bodies follow. */
static int check_columns(const mbsr_force_derivatives *out, const mbsri_body *b, int l,
                         const double *R, int column)
{
    const int spatial = b->joint.space == MBSR_SPACE_SPATIAL;
    assert_int_equal(out->column[l], column);
    for (int row = 0; row < out->rows; ++row) {
        int at = column;
        /* (1, 2, 3) . (e_k x c) */
        for (int k = 0; k < 3 && spatial; ++k, ++at) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            assert_close(entry(out, row, at), (1.0 + j) * R[i] - (1.0 + i) * R[j], 1e-10);
        }
        const int counts[4] = {spatial ? 3 : b->np, b->d, b->nq, b->n};
        for (int kind = 0; kind < 4; ++kind) {
            for (int k = 0; k < counts[kind]; ++k, ++at)
                assert_close(entry(out, row, at), coefficient(row, 4 * l + kind, k), 1e-10);
        }
    }
    return column + (spatial ? 6 : b->np) + b->d + b->nq + b->n;
}

static void elements_of_many_bodies_by_differences(void **state)
{
    (void)state;
    static const int ids[] = {PLANAR_2, SPATIAL_1, MBSR_GROUND, GENERAL_1, JOINTED};
    scene s;
    probe p = {0, 0, 0, NULL};
    test_rng rng = test_seed(8);
    scene_begin(&s, MBSR_SPACE_SPATIAL);
    scene_add(&s, mbsr_force_custom(&probe_table, 5, ids, &p));
    scene_finish(&s);
    random_state(&s, &rng);
    p.watched = &s;
    assert_ok(mbsri_force_slopes(s.model, s.data, force_of(&s, 0), 0, &s.slopes),
              mbsr_data_error(s.data));
    const mbsr_force_derivatives *out = &s.slopes.out;
    int row = 0, column = 0;
    for (int l = 0; l < 5; ++l) {
        if (ids[l] == MBSR_GROUND) {
            assert_int_equal(out->row[l], -1);
            assert_int_equal(out->column[l], -1);
            continue;
        }
        const mbsri_body *b = s.model->body + s.model->index[ids[l]];
        assert_int_equal(out->row[l], row);
        column = check_columns(out, b, l, s.data->p + b->p, column);
        row += b->d + b->n;
    }
    assert_int_equal(out->rows, row);
    assert_int_equal(out->columns, column);
    scene_free(&s);
}

/* The element's own derivatives fail, or write a mark. */
static int probe_derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    probe *p = args->force->user;
    ++p->derived;
    assert_null(args->body->f);
    assert_null(args->body->tau);
    assert_non_null(args->body->V);
    assert_non_null(args->body->u);
    assert_close(args->t, 0.4, 0.0);
    assert_close(test_largest(out->rows * out->columns, out->matrix), 0.0, 0.0);
    out->matrix[1] = 3.0;
    return p->fail_at ? -18 : 0;
}

static void what_an_element_returns_is_passed_on(void **state)
{
    (void)state;
    static const int ids[] = {SPATIAL_1, PLANAR_1};
    mbsr_force_table own = probe_table;
    own.derivatives = probe_derivatives;
    scene s;
    probe p = {0, 0, 0, NULL};
    test_rng rng = test_seed(9);
    scene_begin(&s, MBSR_SPACE_FIXED);
    mbsr_force_def def = mbsr_force_custom(&probe_table, 2, ids, &p);
    def.name = "mine";
    scene_add(&s, def);
    scene_add(&s, mbsr_force_custom(&own, 2, ids, &p));
    scene_finish(&s);
    random_state(&s, &rng);
    const mbsri_force *differenced = force_of(&s, 0);
    p.calls = 0;
    assert_ok(mbsri_force_slopes(s.model, s.data, differenced, 0, &s.slopes), NULL);
    const int calls = p.calls;
    assert_int_equal(calls, 4 * s.slopes.out.columns);
    for (int k = 1; k <= calls; k += 7) {
        p.calls = 0;
        p.fail_at = k;
        assert_refused(mbsri_force_slopes(s.model, s.data, differenced, 0, &s.slopes),
                       mbsr_data_error(s.data), 17, MBSR_NONE, 0,
                       "'mine'|(probe)|evaluate returned 17 at t = 0.4");
        assert_int_equal(p.calls, k);
    }
    p.fail_at = 0;
    assert_ok(mbsri_force_slopes(s.model, s.data, force_of(&s, 1), 0, &s.slopes), NULL);
    assert_close(s.slopes.out.matrix[1], 3.0, 0.0);
    p.fail_at = 1;
    assert_refused(mbsri_force_slopes(s.model, s.data, force_of(&s, 1), 0, &s.slopes),
                   mbsr_data_error(s.data), -18, MBSR_NONE, 1, "(probe)|derivatives returned -18");
    assert_int_equal(p.derived, 2);
    scene_free(&s);
}

/* ---- masses by function ---------------------------------------------------------------------- */

/* The mass of a point at `at` of the body, as mbsr_inertia_point_mass. */
static int point_mass(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    static const double at[3] = {0.2, -0.4, 0.3}, mass = 1.7;
    (void)t, (void)V, (void)h;
    if (*(int *)user) return 19;
    double c[3] = {0.0};
    for (int k = 0; k < 9; ++k) c[k % 3] += mass * p[k] * at[k / 3];
    for (int j = 0; j < 3; ++j) {
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        for (int i = 0; i < 3; ++i)
            M[6 * j + i] =
                ((i == j) * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) - c[i] * c[j]) / mass;
        M[7 * (3 + j)] = mass;
        M[6 * (3 + j) + k] = M[6 * k + 3 + j] = c[l];
        M[6 * (3 + k) + j] = M[6 * j + 3 + k] = -c[l];
    }
    return 0;
}

/* f = M V */
static int momentum_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int j = 0; j < b->d; ++j) {
        for (int k = 0; k < b->d; ++k) b->f[k] += b->M[j * b->d + k] * b->V[j];
    }
    return 0;
}

static const mbsr_force_table momentum_table = {
    .version = MBSR_FORCE_TABLE_VERSION, .name = "momentum", .evaluate = momentum_evaluate};

enum { SMALL, BY_VALUE, BY_CALL };

/* A small body, and two larger ones in the same state whose masses are the same. */
static void begin_masses(scene *s, int *refuse)
{
    static const double at[3] = {0.2, -0.4, 0.3};
    double added[36];
    test_rng rng = test_seed(10);
    memset(s, 0, sizeof *s);
    mbsr_model_def model = mbsr_default_model_def();
    model.allocator = test_counting_allocator(&s->counting);
    assert_ok(mbsr_model_create(&model, &s->model, NULL), NULL);
    some_matrix(&rng, 6, added);
    for (int id = SMALL; id <= BY_CALL; ++id) {
        mbsr_body_def def = mbsr_default_body_def();
        def.joint = id == SMALL ? same_joint(MBSR_SPACE_PLANAR, 3) : mbsr_joint_free(NULL, NULL);
        def.inertia = id == SMALL      ? mbsr_inertia_planar(1.0, at, 0.5)
                      : id == BY_VALUE ? mbsr_inertia_point_mass(1.7, at)
                                       : mbsr_inertia_function(point_mass, refuse);
        assert_ok(mbsr_model_add_body(s->model, &def, NULL), mbsr_model_error(s->model));
        if (id == SMALL) continue;
        assert_ok(mbsr_model_regularise(s->model, id, 6, added), mbsr_model_error(s->model));
    }
}

static void masses_state(scene *s)
{
    double q[17] = {0.0}, u[15] = {0.0};
    test_rng rng = test_seed(12);
    test_fill(&rng, 10, q);
    test_fill(&rng, 9, u);
    memcpy(q + 10, q + 3, 7 * sizeof *q);
    memcpy(u + 9, u + 3, 6 * sizeof *u);
    set_state(s, 0.4, q, u);
}

static void gravity_on_masses_by_function(void **state)
{
    (void)state;
    scene s;
    int refuse = 0;
    begin_masses(&s, &refuse);
    scene_add(&s, mbsr_force_gravity(1.3, -0.7, 2.1));
    scene_finish(&s);
    masses_state(&s);
    const mbsri_force *gravity = force_of(&s, 0);
    const mbsr_error *error = mbsr_data_error(s.data);
    const int *index = s.model->index;
    assert_ok(mbsri_force_slopes(s.model, s.data, gravity, index[BY_VALUE], &s.slopes), error);
    assert_ok(mbsri_force_slopes(s.model, s.data, gravity, index[BY_CALL], &s.differences), error);
    const mbsr_force_derivatives *out = &s.slopes.out;
    for (int k = 0; k < out->rows * out->columns; ++k)
        assert_close(s.differences.out.matrix[k], out->matrix[k], 1e-10);
    assert_less(0.1, test_largest(out->rows * out->columns, out->matrix));
    refuse = 1;
    assert_refused(mbsri_force_slopes(s.model, s.data, gravity, index[BY_CALL], &s.slopes), error,
                   19, BY_CALL, MBSR_NONE, "the inertia's function returned 19");
    scene_free(&s);
}

/* d(M V) = M dV + phi x (M V) - M (phi x V), where M is that of the pose. */
static void check_momentum(const mbsr_force_derivatives *out, const mbsri_body *b, const double *M,
                           const double *V)
{
    const int d = b->d, spatial = d == 6;
    double MV[6] = {0.0};
    for (int k = 0; k < d * d; ++k) MV[k % d] += M[k] * V[k / d];
    for (int c = 0; c < d; ++c) {
        double turned[6] = {0.0}, turn[6] = {0.0};
        for (int half = 0; half < 6 && c < 3; half += 3) {
            const int i = (c + 1) % 3, j = (c + 2) % 3;
            turned[half + i] = -V[half + j], turned[half + j] = V[half + i];
            turn[half + i] = -MV[half + j], turn[half + j] = MV[half + i];
        }
        for (int k = 0; k < 36 && spatial; ++k) turn[k % 6] -= M[k] * turned[k / 6];
        for (int r = 0; r < d; ++r) {
            assert_close(entry(out, r, d + c), M[d * c + r], 1e-10);
            if (spatial) assert_close(entry(out, r, c), turn[r], 1e-10);
        }
    }
}

static void elements_that_read_masses(void **state)
{
    (void)state;
    for (int id = SMALL; id <= BY_CALL; ++id) {
        scene s;
        int refuse = 0;
        begin_masses(&s, &refuse);
        scene_add(&s, mbsr_force_custom(&momentum_table, 1, &id, NULL));
        scene_finish(&s);
        masses_state(&s);
        assert_ok(mbsri_force_slopes(s.model, s.data, force_of(&s, 0), 0, &s.slopes),
                  mbsr_data_error(s.data));
        const mbsri_body *b = s.model->body + s.model->index[id];
        check_momentum(&s.slopes.out, b, s.data->M + b->dd, s.data->V + b->v);
        scene_free(&s);
    }
}

static int mark(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    (void)args;
    out->matrix[0] = 5.0;
    return 0;
}

/* Nor do elements that do not read a mass ask for it; their own derivatives count then. */
static void elements_that_read_no_masses(void **state)
{
    (void)state;
    static const int id = BY_CALL;
    mbsr_force_table own[2] = {probe_table, probe_table};
    scene s;
    int refuse = 0;
    probe p = {0, 0, 0, NULL};
    begin_masses(&s, &refuse);
    scene_add(&s, mbsr_force_custom(&probe_table, 1, &id, &p));
    for (int k = 0; k < 2; ++k) {
        own[k].flags = k ? MBSR_FORCE_JOINT_ONLY : MBSR_FORCE_NO_MASS;
        own[k].derivatives = mark;
        scene_add(&s, mbsr_force_custom(own + k, 1, &id, &p));
    }
    scene_finish(&s);
    masses_state(&s);
    refuse = 1;
    for (int k = 0; k < 3; ++k) {
        assert_ok(mbsri_force_slopes(s.model, s.data, force_of(&s, k), 0, &s.slopes),
                  mbsr_data_error(s.data));
        if (k > 0) assert_close(s.slopes.out.matrix[0], 5.0, 0.0);
    }
    scene_free(&s);
}

/* What belongs to a second body is not there to be read. */
static void elements_on_one_body(void **state)
{
    (void)state;
    static const double point[3] = {0.3, -0.5, 0.9};
    scene s;
    test_rng rng = test_seed(13);
    scene_begin(&s, MBSR_SPACE_FIXED);
    scene_add(&s, mbsr_force_wrench(SPATIAL_2, point, 1, turning_load, NULL));
    scene_finish(&s);
    random_state(&s, &rng);
    assert_less(0.1, compare(&s, 0, 0, 1e-9));
    scene_free(&s);
}

/* ---- what stays as it is --------------------------------------------------------------------- */

/* All that a model's data holds of a state. */
typedef struct snapshot {
    double *number[7];
    size_t count[7];
} snapshot;

static snapshot take(const scene *s)
{
    const mbsr_model *m = s->model;
    const mbsr_data *d = s->data;
    const double *from[7] = {d->p, d->V, d->q, d->u, d->M, d->f, d->tau};
    snapshot x = {.count = {m->size.p, m->size.v, (size_t)m->nq, (size_t)m->nu, m->size.dd,
                            m->size.v, (size_t)m->nu}};
    for (int k = 0; k < 7; ++k) {
        x.number[k] = calloc(x.count[k], sizeof(double));
        memcpy(x.number[k], from[k], x.count[k] * sizeof(double));
    }
    return x;
}

static void data_and_allocations_stay(void **state)
{
    (void)state;
    static const int ids[] = {PLANAR_2, SPATIAL_1, MBSR_GROUND, GENERAL_1, JOINTED};
    scene s;
    probe p = {0, 0, 0, NULL};
    test_rng rng = test_seed(11);
    scene_begin(&s, MBSR_SPACE_SPATIAL);
    add_springs(&s, MBSR_SPACE_SPATIAL, &rng);
    add_others(&s, MBSR_SPACE_SPATIAL, &rng);
    scene_add(&s, mbsr_force_custom(&probe_table, 5, ids, &p));
    scene_add(&s, mbsr_force_gravity(1.0, 2.0, 3.0));
    scene_add(&s, mbsr_force_joint_spring(JOINTED, 1, 2.0, 0.4, 0.3));
    scene_finish(&s);
    random_state(&s, &rng);
    const snapshot before = take(&s);
    const long calls = s.counting.calls;
    for (int id = 0; id < mbsr_model_forces(s.model); ++id) {
        assert_ok(mbsri_force_slopes(s.model, s.data, force_of(&s, id), 1, &s.slopes), NULL);
        assert_ok(mbsri_force_differences(s.model, s.data, force_of(&s, id), 1, &s.slopes), NULL);
    }
    assert_int_equal(s.counting.calls, calls);
    const snapshot after = take(&s);
    for (int k = 0; k < 7; ++k) {
        assert_memory_equal(before.number[k], after.number[k], before.count[k] * sizeof(double));
        free(before.number[k]);
        free(after.number[k]);
    }
    scene_free(&s);
}

/* Elements on joints alone need q and u of the data and nothing else, which lean data has. */
static void joint_elements_on_lean_data(void **state)
{
    (void)state;
    static const double axis[3] = {0.0, 0.0, 1.0};
    mbsr_model *model;
    mbsr_data *data;
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int id = 0; id < 3; ++id) {
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = id - 1;
        if (id == 0) def.parent = MBSR_GROUND;
        def.joint = mbsr_joint_revolute(NULL, NULL, axis);
        def.inertia = mbsr_inertia_point_mass(1.0, (const double[3]){1.0, 0.5, 0.2});
        assert_ok(mbsr_model_add_body(model, &def, NULL), mbsr_model_error(model));
    }
    const mbsr_force_def friction = mbsr_force_joint_friction(1, 0, 2.0, 0.4);
    assert_ok(mbsr_model_add_force(model, &friction, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create_lean(model, &data, NULL), NULL);
    for (int k = 0; k < 3; ++k) data->q[k] = 0.1 * k, data->u[k] = 0.3 * k;
    size_t doubles, ints;
    mbsri_slopes_size(model, MBSRI_SLOPES_WHOLE, &doubles, &ints);
    double *memory = calloc(doubles, sizeof *memory);
    int *integers = calloc(ints, sizeof *integers);
    mbsri_slopes slopes;
    mbsri_slopes_place(model, MBSRI_SLOPES_WHOLE, &slopes, memory, integers);
    /* F slip^2 / (u^2 + slip^2)^(3/2) with u = 0.3, slip = 0.4 */
    const double expected = -2.0 * 0.16 / 0.125;
    assert_ok(mbsri_force_slopes(model, data, model->forces.data, 0, &slopes), NULL);
    assert_close(entry(&slopes.out, 6, 13), expected, 1e-12);
    assert_ok(mbsri_force_differences(model, data, model->forces.data, 0, &slopes), NULL);
    assert_close(entry(&slopes.out, 6, 13), expected, 1e-9);
    free(memory);
    free(integers);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_between_points_and_frames),
        cmocka_unit_test(gravity_of_every_kind_of_mass),
        cmocka_unit_test(elements_on_coordinates),
        cmocka_unit_test(cables_on_both_sides),
        cmocka_unit_test(stops_on_both_sides),
        cmocka_unit_test(contacts_on_both_sides),
        cmocka_unit_test(springs_of_no_length),
        cmocka_unit_test(bushings_at_all_angles),
        cmocka_unit_test(elements_of_many_bodies_by_differences),
        cmocka_unit_test(what_an_element_returns_is_passed_on),
        cmocka_unit_test(gravity_on_masses_by_function),
        cmocka_unit_test(elements_that_read_masses),
        cmocka_unit_test(elements_that_read_no_masses),
        cmocka_unit_test(elements_on_one_body),
        cmocka_unit_test(data_and_allocations_stay),
        cmocka_unit_test(joint_elements_on_lean_data),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
