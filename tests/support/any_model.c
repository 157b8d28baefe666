/* Random models of everything: see any_model.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"

#include <math.h>
#include <string.h>

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

static double place(any_model *s)
{
    static const double some[] = {0.0, 0.0, 0.0, 0.5, 1.0, -1.0, 0.75, -0.4, 0.7};
    return (s->generic ? test_uniform(s->rng) : choose(s->rng, 9, some)) * s->of->length;
}

static void point(any_model *s, double x[3])
{
    for (int k = 0; k < 3; ++k) x[k] = place(s);
}

static mbsr_frame frame(any_model *s)
{
    mbsr_frame f = mbsr_frame_identity();
    double quaternion[4] = {test_integer(s->rng, 1, 3)}; /* any length */
    for (int k = 1; k < 4; ++k) quaternion[k] = test_integer(s->rng, -2, 2);
    if (share(s->rng) < 0.5) assert_ok(mbsr_quaternion_rotation(quaternion, f.R), NULL);
    point(s, f.x);
    return f;
}

static void add_coordinate(any_model *s, bool turns)
{
    static const double angle[] = {0.0, 0.0, 1.5707963267948966, 0.4, -0.2, 0.9272952180016123};
    s->turns[s->nu++] = s->turn[s->nq] = turns;
    s->q[s->nq++] = !turns       ? place(s)
                    : s->generic ? test_uniform(s->rng)
                                 : choose(s->rng, 6, angle);
}

static void add_rotation(any_model *s)
{
    static const double any[4] = {0.4, -0.2, 0.8, 0.4}, none[4] = {1.0};
    memcpy(s->q + s->nq, share(s->rng) < 0.4 ? none : any, sizeof any);
    for (int k = 0; k < 4; ++k) s->turn[s->nq++] = true;
    for (int k = 0; k < 3; ++k) s->turns[s->nu++] = true;
}

static mbsr_joint compound(any_model *s, const mbsr_frame *f)
{
    static const double edge[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const int count = test_integer(s->rng, 2, 3), from = test_integer(s->rng, 0, 2);
    mbsr_axis axis[3] = {{0}};
    for (int k = 0; k < count; ++k) {
        const bool turns = share(s->rng) < 0.5;
        axis[k].kind = turns ? MBSR_AXIS_ROTATION : MBSR_AXIS_TRANSLATION;
        memcpy(axis[k].direction, edge[(from + k) % 3], sizeof edge[0]);
        add_coordinate(s, turns);
        if (turns) s->q[s->nq - 1] = 0.4 - 0.3 * k; /* no gimbal lock */
    }
    return mbsr_joint_compound(f, NULL, count, axis, NULL, NULL);
}

static mbsr_joint joint(any_model *s)
{
    static const double axes[][3] = {{1.0, 0.0, 0.0},
                                     {0.0, 1.0, 0.0},
                                     {0.0, 0.0, 1.0},
                                     {0.6, 0.8, 0.0},
                                     {1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0}};
    const mbsr_frame f = frame(s);
    const double *axis = axes[test_integer(s->rng, 0, 4)];
    const int kind = test_integer(s->rng, 0, s->rich ? 11 : 9);
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
    if (kind == 10) {
        for (int k = 0; k < 3; ++k) add_coordinate(s, k == 2);
        return mbsr_joint_in_plane(&f, NULL);
    }
    if (kind == 11) return compound(s, &f);
    add_rotation(s);
    if (kind == 8) return mbsr_joint_spherical(&f, NULL);
    for (int k = 0; k < 3; ++k) add_coordinate(s, false);
    return mbsr_joint_free(&f, NULL);
}

static mbsr_inertia inertia(any_model *s, int i, double massless)
{
    const double mass = size(s->rng, -2.0, 4.0) * s->of->mass, kind = share(s->rng);
    double a[3], b[3];
    point(s, a), point(s, b);
    s->points[i] = 0;
    if (share(s->rng) < massless) return mbsr_inertia_zero();
    s->points[i] = kind < 0.4 || kind >= 0.6 ? 1 : 2;
    memset(s->place[i], 0, sizeof s->place[i]);
    memcpy(s->place[i], a, kind < 0.15 ? 0 : sizeof a);
    memcpy(s->place[i] + 3, b, sizeof b);
    if (kind < 0.15) return mbsr_inertia_particle(mass);
    if (kind < 0.4) return mbsr_inertia_point_mass(mass, a);
    if (kind < 0.6)
        return mbsr_inertia_sum(mbsr_inertia_point_mass(mass, a),
                                mbsr_inertia_point_mass(size(s->rng, -2.0, 2.0) * mass, b));
    const double I = 0.1 * mass * s->of->length * s->of->length, tensor[6] = {I, 1.2 * I, 1.4 * I};
    return mbsr_inertia_rigid(mass, a, tensor);
}

static void add_force(any_model *s, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(s->m, &force, NULL), mbsr_model_error(s->m));
}

/* Stiffness along a slide, or damping, or none. */
static double law(any_model *s, double often, double unit)
{
    return share(s->rng) < often ? size(s->rng, -1.0, 5.0) * unit : 0.0;
}

static void add_forces(any_model *s)
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

/* A cable between two points, or friction of a bearing. */
static void add_link(any_model *s, double k, double d)
{
    const double L = s->of->length, stiffness = size(s->rng, -1.0, 5.0) * k,
                 damping = law(s, 0.4, d), which = share(s->rng);
    const int a = test_integer(s->rng, 0, s->bodies - 1),
              b = test_integer(s->rng, MBSR_GROUND, s->bodies - 1);
    double x[3], y[3];
    point(s, x), point(s, y);
    if (a == b) return;
    const mbsr_spring cable = {
        .stiffness = stiffness, .damping = damping, .free_length = 0.3 * L, .one_sided = 1};
    const mbsr_bearing bearing = {
        .viscous = (damping + d) * L * L, .slip = 1.0 / s->of->time, .axis = {0.0, 0.0, 1.0}};
    add_force(s, which < 0.5 ? mbsr_force_spring(a, x, b, y, &cable)
                             : mbsr_force_bearing_friction(a, b, &bearing));
}

/* Springs and dampers off their rest, friction and stops in joint coordinate c of body i. */
static void add_laws(any_model *s, int i, int c, double k, double d)
{
    const bool turns = s->turns[s->first[i] + c];
    const double L = s->of->length, unit = turns ? L * L : 1.0, span = turns ? 1.0 : L,
                 stiffness = law(s, 0.5, k * unit), damping = law(s, 0.5, d * unit),
                 rest = 0.3 * test_uniform(s->rng) * span, kind = share(s->rng),
                 other = size(s->rng, -1.0, 4.0);
    if (s->plain[i] && kind < 0.6)
        add_force(s, mbsr_force_joint_spring(i, c, stiffness, damping, rest));
    if (kind > 0.9)
        add_force(
            s, mbsr_force_joint_friction(i, c, other * k * unit * span, 0.05 * span / s->of->time));
    if (s->plain[i] && kind < 0.05)
        add_force(s, mbsr_force_joint_stop(i, c, -0.1 * span, 0.1 * span, other * k * unit,
                                           0.02 * other * d * unit));
}

static void add_gear(any_model *s, double k)
{
    const int a = test_integer(s->rng, 0, s->bodies - 1),
              b = test_integer(s->rng, 0, s->bodies - 1), x = test_integer(s->rng, 0, s->n[a] - 1),
              y = test_integer(s->rng, 0, s->n[b] - 1);
    const double L = s->of->length, stiffness = size(s->rng, 0.0, 4.0) * k;
    if (a == b || !s->plain[a] || !s->plain[b]) return;
    const bool p = s->turns[s->first[a] + x], q = s->turns[s->first[b] + y];
    const mbsr_gear gear = {.ratio = 1.5 * (p ? 1.0 : L) / (q ? 1.0 : L),
                            .stiffness = stiffness * (p ? L * L : 1.0)};
    add_force(s, mbsr_force_gear(a, x, b, y, &gear));
}

/* What more there is in models that are rich. */
static void add_more(any_model *s)
{
    const double L = s->of->length, k = s->of->mass / (s->of->time * s->of->time),
                 d = s->of->mass / s->of->time;
    if (share(s->rng) < 0.3) add_link(s, k, d);
    for (int i = 0; i < s->bodies; ++i) {
        const double other = size(s->rng, -1.0, 4.0), kind = share(s->rng),
                     K[3] = {other * k * L * L, other * k * L * L, other * k * L * L},
                     D[3] = {other * d * L * L, other * d * L * L, other * d * L * L};
        if (!s->plain[i])
            add_force(s, mbsr_force_joint_rotation_spring(i, kind < 0.6 ? K : NULL,
                                                          kind > 0.4 ? D : NULL, NULL));
        for (int c = 0; c < s->n[i]; ++c) add_laws(s, i, c, k, d);
    }
    if (share(s->rng) < 0.15) add_gear(s, k);
}

static void stiffen(any_model *s, int rows, mbsr_closure_def *closure)
{
    const double stiff = share(s->rng), k = size(s->rng, 4.0, 22.0), damped = share(s->rng);
    for (int l = 0; l < rows && stiff < 0.15; ++l) {
        closure->stiffness[l] = k * s->of->mass / (s->of->time * s->of->time);
        closure->damping[l] = damped < 0.6 ? 1e-3 * k * s->of->mass / s->of->time : 0.0;
    }
}

/* A point of the world in the axes of a body. */
static void seen_from(const any_model *s, int body, const double w[3], double x[3])
{
    for (int k = 0; k < 3; ++k) {
        x[k] = body < 0 ? w[k] : 0.0;
        for (int l = 0; l < 3 && body >= 0; ++l)
            x[k] += s->at[body].R[3 * k + l] * (w[l] - s->at[body].x[l]);
    }
}

/* Closed at the positions that `at` is of. */
static bool add_closure(any_model *s)
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
    mbsr_closure_def closure = kind < 0.3   ? mbsr_closure_distance(a, x, b, y, length)
                               : kind < 0.7 ? mbsr_closure_ball(a, x, b, y)
                                            : mbsr_closure_rows(a, x, b, y, 2, directions);
    if (s->rich) stiffen(s, kind < 0.3 ? 1 : kind < 0.7 ? 3 : 2, &closure);
    return mbsr_model_add_closure(s->m, &closure, NULL) == MBSR_OK;
}

static void find_places(any_model *s)
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

static void add_armature(any_model *s, int i)
{
    double inertia[6];
    for (int k = 0; k < s->n[i]; ++k) {
        const double lever = s->turns[s->first[i] + k] ? s->of->length : 1.0;
        inertia[k] = 0.3 * lever * lever * s->of->mass;
    }
    assert_ok(mbsr_model_armature(s->m, i, s->n[i], inertia), mbsr_model_error(s->m));
}

static void add_bodies(any_model *s, double massless)
{
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
    s->nq = s->nu = 0;
    for (int i = 0; i < s->bodies; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        const int q = s->nq;
        s->first[i] = s->nu;
        body.parent = test_integer(s->rng, MBSR_GROUND, i - 1);
        body.joint = joint(s);
        body.inertia = inertia(s, i, massless);
        s->n[i] = s->nu - s->first[i];
        s->plain[i] = s->nq - q == s->n[i];
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
        if (s->rich && share(s->rng) < 0.05) add_armature(s, i);
    }
    add_forces(s);
    if (s->rich) add_more(s);
}

bool any_model_make(any_model *s, uint64_t seed, const units *of, bool rich)
{
    static const double few[] = {0.2, 0.4, 0.6};
    test_rng rng = test_seed(seed);
    *s = (any_model){.rng = &rng,
                     .of = of,
                     .rich = rich,
                     .generic = rich && seed % 3 == 0,
                     .bodies = test_integer(&rng, 2, ANY_BODIES - 1)};
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
    const bool moves = rich && share(&rng) < 0.6;
    for (int k = 0; k < s->nu && moves; ++k)
        s->u[k] = test_uniform(&rng) * (s->turns[k] ? 1.0 : of->length) / of->time;
    s->rng = NULL;
    return made;
}
