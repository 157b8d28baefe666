/* What report, start, forward dynamics and Newton's matrix say of directions without mass, of trees
 * and closed models whose bodies stand on axes, in lines and in each other's planes, in four
 * systems of units: they never contradict each other, every damped direction has an element, and
 * none lies in the span of the others.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { BODIES = 8, MOST = 64 };

/* A model under way: its coordinates, and where its bodies are. */
typedef struct scene {
    mbsr_model *m;
    test_rng *rng;
    const units *of;
    int nq, nu, bodies;
    bool turns[MOST];             /* nu */
    int first[BODIES], n[BODIES]; /* of the rates of each body */
    bool plain[BODIES];           /* its q' is its u */
    double q[MOST];
    mbsr_frame at[BODIES];
} scene;

/* ---- models ---- */

static double choose(test_rng *rng, int count, const double *of)
{
    return of[test_integer(rng, 0, count - 1)];
}

static double share(test_rng *rng)
{
    return 0.5 * (1.0 + test_uniform(rng));
}

/* e^low .. e^high */
static double size(test_rng *rng, double low, double high)
{
    return exp(low + (high - low) * share(rng));
}

static double place(scene *s)
{
    static const double some[] = {0.0, 0.0, 0.0, 0.5, 1.0, -1.0, 0.75, -0.4, 0.7};
    return choose(s->rng, 9, some) * s->of->length;
}

static void point(scene *s, double x[3])
{
    for (int k = 0; k < 3; ++k) x[k] = place(s);
}

static mbsr_frame frame(scene *s)
{
    mbsr_frame f = mbsr_frame_identity();
    double quaternion[4] = {test_integer(s->rng, 1, 3)}; /* any length */
    for (int k = 1; k < 4; ++k) quaternion[k] = test_integer(s->rng, -2, 2);
    if (share(s->rng) < 0.5) assert_ok(mbsr_quaternion_rotation(quaternion, f.R), NULL);
    point(s, f.x);
    return f;
}

static void add_coordinate(scene *s, bool turns)
{
    static const double angle[] = {0.0, 0.0, 1.5707963267948966, 0.4, -0.2, 0.9272952180016123};
    s->turns[s->nu++] = turns;
    s->q[s->nq++] = turns ? choose(s->rng, 6, angle) : place(s);
}

static void add_rotation(scene *s)
{
    static const double any[4] = {0.4, -0.2, 0.8, 0.4}, none[4] = {1.0};
    memcpy(s->q + s->nq, share(s->rng) < 0.4 ? none : any, sizeof any);
    s->nq += 4;
    for (int k = 0; k < 3; ++k) s->turns[s->nu++] = true;
}

static mbsr_joint joint(scene *s)
{
    static const double axes[][3] = {{1.0, 0.0, 0.0},
                                     {0.0, 1.0, 0.0},
                                     {0.0, 0.0, 1.0},
                                     {0.6, 0.8, 0.0},
                                     {1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0}};
    const mbsr_frame f = frame(s);
    const double *axis = axes[test_integer(s->rng, 0, 4)];
    const int kind = test_integer(s->rng, 0, 9);
    if (kind < 3) return add_coordinate(s, true), mbsr_joint_revolute(&f, NULL, axis);
    if (kind < 5) return add_coordinate(s, false), mbsr_joint_prismatic(&f, NULL, axis);
    if (kind == 5) {
        add_coordinate(s, true), add_coordinate(s, false);
        return mbsr_joint_cylindrical(&f, NULL, axis);
    }
    if (kind == 6) {
        add_coordinate(s, true), add_coordinate(s, true);
        return mbsr_joint_universal(&f, NULL, axes[0], axes[1]);
    }
    if (kind == 7) {
        for (int k = 0; k < 3; ++k) add_coordinate(s, false);
        return mbsr_joint_translational(&f, NULL);
    }
    add_rotation(s);
    if (kind == 8) return mbsr_joint_spherical(&f, NULL);
    for (int k = 0; k < 3; ++k) add_coordinate(s, false);
    return mbsr_joint_free(&f, NULL);
}

static mbsr_inertia inertia(scene *s, double massless)
{
    const double mass = size(s->rng, -2.0, 4.0) * s->of->mass, kind = share(s->rng);
    double a[3], b[3];
    point(s, a), point(s, b);
    if (share(s->rng) < massless) return mbsr_inertia_zero();
    if (kind < 0.15) return mbsr_inertia_particle(mass);
    if (kind < 0.4) return mbsr_inertia_point_mass(mass, a);
    if (kind < 0.6)
        return mbsr_inertia_sum(mbsr_inertia_point_mass(mass, a),
                                mbsr_inertia_point_mass(size(s->rng, -2.0, 2.0) * mass, b));
    const double I = 0.1 * mass * s->of->length * s->of->length, tensor[6] = {I, 1.2 * I, 1.4 * I};
    return mbsr_inertia_rigid(mass, a, tensor);
}

static void add_force(scene *s, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(s->m, &force, NULL), mbsr_model_error(s->m));
}

/* Stiffness along a slide, or damping, or none. */
static double law(scene *s, double often, double unit)
{
    return share(s->rng) < often ? size(s->rng, -1.0, 5.0) * unit : 0.0;
}

static void add_forces(scene *s)
{
    const double L = s->of->length, k = s->of->mass / (s->of->time * s->of->time),
                 d = s->of->mass / s->of->time;
    const int count = test_integer(s->rng, 0, 3);
    for (int n = 0; n < count; ++n) {
        const int a = test_integer(s->rng, 0, s->bodies - 1),
                  b = test_integer(s->rng, MBSR_GROUND, s->bodies - 1);
        double x[3], y[3], stiffness[6], damping[6];
        const mbsr_frame f = frame(s), g = frame(s);
        point(s, x), point(s, y);
        for (int l = 0; l < 6; ++l) {
            stiffness[l] = law(s, 0.3, l < 3 ? k * L * L : k);
            damping[l] = law(s, 0.4, l < 3 ? d * L * L : d);
        }
        if (a == b) continue;
        if (share(s->rng) < 0.4)
            add_force(s, mbsr_force_bushing(a, &f, b, &g, stiffness, damping));
        else
            add_force(s, mbsr_force_point_spring(a, x, b, y, stiffness[3], damping[3], 0.7 * L));
    }
    for (int i = 0; i < s->bodies; ++i) {
        for (int c = 0; c < s->n[i]; ++c) {
            const double turn = s->turns[s->first[i] + c] ? L * L : 1.0,
                         stiffness = law(s, 0.2, k * turn), damping = law(s, 0.2, d * turn);
            if (s->plain[i] && share(s->rng) < 0.5)
                add_force(s, mbsr_force_joint_spring(i, c, stiffness, damping, 0.0));
        }
    }
    if (share(s->rng) < 0.5)
        add_force(s, mbsr_force_gravity(0.0, 0.0, -9.81 * L / (s->of->time * s->of->time)));
}

/* A point of the world in the axes of a body. */
static void seen_from(const scene *s, int body, const double w[3], double x[3])
{
    for (int k = 0; k < 3; ++k) {
        x[k] = body < 0 ? w[k] : 0.0;
        for (int l = 0; l < 3 && body >= 0; ++l)
            x[k] += s->at[body].R[3 * k + l] * (w[l] - s->at[body].x[l]);
    }
}

/* Closed at the positions that `at` is of. */
static bool add_closure(scene *s)
{
    static const double directions[] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    const int a = test_integer(s->rng, 0, s->bodies - 1),
              b = test_integer(s->rng, MBSR_GROUND, s->bodies - 1);
    const double kind = share(s->rng), length = 1.2 * s->of->length;
    double x[3], w[3], y[3];
    point(s, x);
    if (a == b) return true;
    for (int k = 0; k < 3; ++k) {
        w[k] = s->at[a].x[k] + (kind < 0.3 ? length * (k == 0 ? 0.6 : k == 1 ? 0.8 : 0.0) : 0.0);
        for (int l = 0; l < 3; ++l) w[k] += s->at[a].R[3 * l + k] * x[l];
    }
    seen_from(s, b, w, y);
    const mbsr_closure_def closure = kind < 0.3   ? mbsr_closure_distance(a, x, b, y, length)
                                     : kind < 0.7 ? mbsr_closure_ball(a, x, b, y)
                                                  : mbsr_closure_rows(a, x, b, y, 2, directions);
    return mbsr_model_add_closure(s->m, &closure, NULL) == MBSR_OK;
}

static void find_places(scene *s)
{
    mbsr_data *d;
    double pose[MBSR_POSE_SIZE];
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(s->m, d, 0.0, s->q), mbsr_data_error(d));
    for (int i = 0; i < s->bodies; ++i) {
        assert_ok(mbsr_body_pose(s->m, d, i, pose), NULL);
        memcpy(s->at[i].R, pose + MBSR_POSE_R, sizeof s->at[i].R);
        memcpy(s->at[i].x, pose + MBSR_POSE_X, sizeof s->at[i].x);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(s->m);
}

static void add_bodies(scene *s, double massless)
{
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
    s->nq = s->nu = 0;
    for (int i = 0; i < s->bodies; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        const int q = s->nq;
        s->first[i] = s->nu;
        body.parent = test_integer(s->rng, MBSR_GROUND, i - 1);
        body.joint = joint(s);
        body.inertia = inertia(s, massless);
        s->n[i] = s->nu - s->first[i];
        s->plain[i] = s->nq - q == s->n[i];
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    }
    add_forces(s);
}

/* False: a closure has no freedom to hold. */
static bool make(scene *s, uint64_t seed, const units *of)
{
    static const double few[] = {0.2, 0.4, 0.6};
    test_rng rng = test_seed(seed);
    *s = (scene){.rng = &rng, .of = of, .bodies = test_integer(&rng, 2, BODIES - 1)};
    const double massless = choose(&rng, 3, few);
    const int closures = seed % 2 ? test_integer(&rng, 1, 3) : 0;
    const test_rng again = rng;
    bool made = true;
    add_bodies(s, massless);
    if (closures > 0) {
        find_places(s);
        rng = again;
        add_bodies(s, massless);
    }
    for (int k = 0; k < closures; ++k) made = made && add_closure(s);
    made = made && mbsr_model_finish(s->m) == MBSR_OK;
    if (!made) mbsr_model_destroy(s->m);
    s->rng = NULL;
    return made;
}

/* ---- verdicts ---- */

typedef struct verdict {
    int report, forward, start, newton; /* statuses */
    int dynamic, damped, elastic, undetermined, held;
} verdict;

/* What a start finds, as in SI. */
typedef struct motion {
    double u[MOST], udot[MOST];
} motion;

/* The rank of rows (count x n), which get lost. */
static int rank_of(int count, int n, double *A)
{
    int rank = 0;
    for (; rank < count; ++rank) {
        int row = -1, column = 0;
        double largest = 1e-7;
        for (int k = rank * n; k < count * n; ++k) {
            if (fabs(A[k]) > largest) largest = fabs(A[k]), row = k / n, column = k % n;
        }
        if (row < 0) break;
        for (int j = 0; j < n; ++j) {
            const double entry = A[row * n + j];
            A[row * n + j] = A[rank * n + j];
            A[rank * n + j] = entry;
        }
        for (int i = rank + 1; i < count; ++i) {
            const double part = A[i * n + column] / A[rank * n + column];
            for (int j = 0; j < n; ++j) A[i * n + j] -= part * A[rank * n + j];
        }
    }
    return rank;
}

static void check_directions(const scene *s, const mbsr_index_report *report)
{
    double rates[MOST * MOST] = {0.0};
    for (int k = 0; k < report->directions; ++k) {
        const mbsr_direction *direction = report->direction + k;
        double *row = rates + k * s->nu;
        for (int l = 0; l < direction->terms; ++l) {
            const mbsr_direction_term *term = direction->term + l;
            const int at = s->first[term->body] + term->coordinate;
            row[at] = term->weight / (s->turns[at] ? 1.0 : s->of->length);
        }
        const double largest = test_largest(s->nu, row);
        for (int l = 0; l < s->nu; ++l) row[l] /= largest;
        if (direction->kind == MBSR_DIRECTION_DAMPED) assert_true(direction->forces > 0);
    }
    assert_int_equal(rank_of(report->directions, s->nu, rates), report->directions);
}

/* The largest difference of x and y beside the largest of these and `least`. */
static double apart(int n, const double *x, const double *y, double least)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k] - y[k]));
    return most / fmax(least, fmax(test_largest(n, x), test_largest(n, y)));
}

/* Accelerations from velocities alone are those of the start. */
static void check_dynamics(const scene *s, mbsr_data *d, const double *y, const double *yp)
{
    const double *u = y + s->nq + s->nu, *udot = yp + s->nq + s->nu,
                 second = s->of->time * s->of->time;
    mbsr_completion *completion;
    double found[MOST], apace[MOST];
    assert_ok(mbsr_completion_create(s->m, NULL, &completion, NULL), NULL);
    assert_ok(mbsr_completion_dynamics(completion, d, 0.0, y, u, NULL, found, NULL),
              mbsr_completion_error(completion));
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / second;
        found[k] /= unit, apace[k] = udot[k] / unit;
    }
    assert_less(apart(s->nu, found, apace, 1.0), 1e-6);
    mbsr_completion_destroy(completion);
}

/* A start from where one has led leads nowhere else. */
static void check_again(const scene *s, mbsr_data *d, const double *y)
{
    double again[4 * MOST], rate[4 * MOST], before[MOST], after[MOST];
    memcpy(again, y, sizeof again);
    assert_ok(mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, again, rate, NULL, NULL),
              mbsr_data_error(d));
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / s->of->time;
        before[k] = y[s->nq + s->nu + k] / unit, after[k] = again[s->nq + s->nu + k] / unit;
    }
    assert_less(apart(s->nu, before, after, 1.0), 1e-9);
}

static void note_motion(const scene *s, const double *y, const double *yp, motion *found)
{
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / s->of->time;
        found->u[k] = y[s->nq + s->nu + k] / unit;
        found->udot[k] = yp[s->nq + s->nu + k] * s->of->time / unit;
    }
}

static verdict judge(const scene *s, motion *found)
{
    mbsr_data *d;
    mbsr_index_report *report;
    mbsr_newton *newton;
    double u[MOST] = {0.0}, udot[MOST], y[4 * MOST] = {0.0}, yp[4 * MOST];
    verdict v = {0};
    assert_true(s->nq <= MOST && mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM) <= 4 * MOST);
    assert_ok(mbsr_data_create(s->m, &d, NULL), NULL);
    v.report = mbsr_index_report_create(s->m, d, 0.0, s->q, u, &report);
    if (!v.report) {
        check_directions(s, report);
        v.dynamic = report->dynamic, v.held = report->held;
        v.damped = report->damped, v.elastic = report->elastic;
        v.undetermined = report->undetermined;
        mbsr_index_report_destroy(s->m, report);
    }
    v.forward = mbsr_forward_dynamics(s->m, d, 0.0, s->q, u, NULL, udot);
    assert_ok(mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, u, y), mbsr_data_error(d));
    v.start = mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (!v.start) {
        assert_ok(mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), NULL);
        v.newton = mbsr_newton_factor(newton, d, 0.0, y, yp, 1e3 / s->of->time);
        mbsr_newton_destroy(newton);
        note_motion(s, y, yp, found);
        if (v.dynamic > 0 && v.elastic == 0 && v.newton == MBSR_OK) check_dynamics(s, d, y, yp);
        if (!v.report && v.elastic == 0) check_again(s, d, y);
    }
    mbsr_data_destroy(d);
    return v;
}

/* A start that moves to where springs are at rest may find there what their tension held. */
static void check(const verdict *v)
{
    const int directions = v->damped + v->elastic + v->undetermined;
    assert_int_not_equal(v->report, MBSR_INDEFINITE_MASS);
    assert_int_not_equal(v->forward, MBSR_INDEFINITE_MASS);
    assert_int_not_equal(v->start, MBSR_INDEFINITE_MASS);
    if (v->report) return;
    assert_int_equal(v->forward == MBSR_UNDETERMINED, directions > 0);
    if (v->undetermined > 0) assert_int_not_equal(v->start, MBSR_OK);
    if (v->undetermined + v->elastic == 0) assert_int_not_equal(v->start, MBSR_UNDETERMINED);
    if (v->undetermined == 0) assert_int_not_equal(v->newton, MBSR_SINGULAR_BLOCK);
}

/* The verdict in SI, once it is checked and found the same in all systems of units; false: there is
 * no such model. */
static bool find_verdict(uint64_t seed, verdict *first)
{
    bool made = false;
    motion one, other;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        scene s;
        if (!make(&s, seed, systems + k)) break;
        verdict v = judge(&s, k == 0 ? &one : &other);
        check(&v);
        v.start = v.start != MBSR_OK; /* what a refused one calls its reason may differ */
        if (k == 0) *first = v;
        assert_memory_equal(&v, first, sizeof v);
        if (k > 0 && v.start == 0 && v.elastic == 0 && v.dynamic > 0) {
            assert_less(apart(s.nu, one.u, other.u, 1.0), 1e-8);
            assert_less(apart(s.nu, one.udot, other.udot, 1.0), 1e-6);
        }
        mbsr_model_destroy(s.m);
        made = true;
    }
    return made;
}

static void verdicts_agree(void **state)
{
    (void)state;
    const int seeds = test_seeds(40, 150);
    int models = 0, singular = 0, open = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; ++seed) {
        verdict v;
        if (!find_verdict(seed, &v)) continue;
        ++models;
        singular += v.forward == MBSR_UNDETERMINED;
        open += v.undetermined > 0;
    }
    assert_true(models > seeds / 2 && singular > seeds / 4 && open > seeds / 10);
}

static void check_seeds(size_t count, const uint64_t *seed)
{
    for (size_t k = 0; k < count; ++k) {
        verdict v;
        assert_true(find_verdict(seed[k], &v));
    }
}

/* A row reads bodies along an axis, of whose other components rounding is left. */
static void rows_that_see_traces(void **state)
{
    (void)state;
    static const uint64_t seed[] = {193, 2761, 90971, 100701};
    check_seeds(4, seed);
}

/* Weights on bodies without mass have no part in directions that turn these about them. */
static void weights_that_do_not_move(void **state)
{
    (void)state;
    static const uint64_t seed[] = {222, 223};
    check_seeds(2, seed);
}

/* Particles at origins have no radius that the size of the model could be told from. */
static void masses_without_radius(void **state)
{
    (void)state;
    static const uint64_t seed[] = {315, 367, 3103};
    check_seeds(3, seed);
}

/* Rows hold all that there is, and the accelerations that are solved for are rounding of forces. */
static void nothing_left_to_move(void **state)
{
    (void)state;
    static const uint64_t seed[] = {1249, 9799};
    check_seeds(2, seed);
}

/* Forces of loops that are nothing but rounding; rows that hold turning and sliding. */
static void loops_without_load(void **state)
{
    (void)state;
    static const uint64_t seed[] = {1855, 19071, 53747, 91565};
    check_seeds(4, seed);
}

static void add_behind(scene *s, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = s->bodies++ - 1;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
}

/* One point mass, 1e-5 beside an axis and as close to what the joints before leave free: it moves
 * in three directions, of twelve, however rounding has grown on the way. */
static void a_mass_close_to_axes(void **state)
{
    (void)state;
    static const double slant[3] = {0.6, 0.8, 0.0}, upright[3] = {0.0, 0.0, 1.0};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        const double L = systems[k].length, point[3] = {1e-5 * L, 0.0, 0.7 * L},
                     q[13] = {L,
                              0.2,
                              0.4,
                              0.4,
                              0.8,
                              0.0,
                              -0.4 * L,
                              0.7 * L,
                              0.0,
                              -0.4 * L,
                              2.060753653048625,
                              0.0,
                              1.5707963267948966},
                     u[12] = {0.0};
        const mbsr_frame first = mbsr_frame_at(0.0, -L, 0.75 * L),
                         last = mbsr_frame_at(0.75 * L, -0.4 * L, 0.7 * L);
        mbsr_frame second = mbsr_frame_identity(), third = mbsr_frame_at(0.5 * L, -L, -L);
        assert_ok(mbsr_quaternion_rotation((double[4]){11.0, 1.0, 0.0, 0.0}, second.R), NULL);
        assert_ok(mbsr_quaternion_rotation((double[4]){5.0, 0.0, 1.0, 0.0}, third.R), NULL);
        scene s = {.of = systems + k};
        mbsr_data *d;
        mbsr_index_report *report;
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL);
        const mbsr_inertia none = mbsr_inertia_zero();
        add_behind(&s, mbsr_joint_prismatic(&first, NULL, slant), none);
        add_behind(&s, mbsr_joint_free(&second, NULL), none);
        add_behind(&s, mbsr_joint_in_plane(&third, NULL), none);
        add_behind(&s, mbsr_joint_universal(&last, NULL, slant, upright),
                   mbsr_inertia_point_mass(0.154 * systems[k].mass, point));
        assert_ok(mbsr_model_finish(s.m), mbsr_model_error(s.m));
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_ok(mbsr_index_report_create(s.m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->dynamic, 3);
        assert_int_equal(report->undetermined, 9);
        mbsr_index_report_destroy(s.m, report);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verdicts_agree),           cmocka_unit_test(rows_that_see_traces),
        cmocka_unit_test(weights_that_do_not_move), cmocka_unit_test(masses_without_radius),
        cmocka_unit_test(nothing_left_to_move),     cmocka_unit_test(loops_without_load),
        cmocka_unit_test(a_mass_close_to_axes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
