/* Random trees of joints of all kinds, and models of them: see joint_scene.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joint_scene.h"

#include "ritz.h"

static void draw_vector(scene *s, double x[3])
{
    const int axis = test_integer(&s->rng, 0, 2);
    const bool along = test_chance(&s->rng, 0.5);
    for (int k = 0; k < 3; ++k) x[k] = along ? k == axis : test_uniform(&s->rng);
}

static void draw_mass(scene *s, body *b, bool light)
{
    double along[3], aside[3], across[3];
    const double off = test_chance(&s->rng, 0.4)            ? 0.0
                       : test_chance(&s->rng, 0.5) || light ? 1.0
                                                            : test_decades(&s->rng, -5.5, -1.0),
                 start = test_chance(&s->rng, 0.5) ? 0.0 : test_uniform(&s->rng);
    memcpy(along, b->axis, sizeof along);
    if (b->joint == BALL || b->joint == FREE) draw_vector(s, along);
    draw_vector(s, aside);
    draw_vector(s, across);
    b->mass = light ? test_decades(&s->rng, -10.0, 0.0) : test_decades(&s->rng, -2.0, 1.0);
    b->points = test_integer(&s->rng, 1, 3);
    for (int k = 0; k < 3; ++k) {
        b->point[0][k] = start * along[k] + off * aside[k];
        b->point[1][k] = (1.0 + start) * along[k] + off * aside[k];
        b->point[2][k] = (0.5 + start) * along[k] + across[k] + 0.3 * (k == 1);
    }
}

static void draw_body(scene *s, int i, bool light)
{
    body *b = s->body + i;
    *b = (body){.parent = test_chance(&s->rng, 0.7) ? i - 1 : test_integer(&s->rng, -1, i - 1)};
    b->joint = test_chance(&s->rng, 0.6) ? (kind)test_integer(&s->rng, HINGE, SLIDE)
                                         : (kind)test_integer(&s->rng, SCREW, FREE);
    draw_vector(s, b->axis);
    b->other[0] = b->axis[1], b->other[1] = b->axis[2], b->other[2] = b->axis[0] + 0.1;
    if (test_chance(&s->rng, 0.6)) draw_vector(s, b->at);
    if (test_chance(&s->rng, i + 1 < s->bodies ? 0.4 : 0.8)) draw_mass(s, b, light);
    const bool quaternion = b->joint == BALL || b->joint == FREE;
    if (test_chance(&s->rng, 0.15) && !quaternion) b->armature = test_decades(&s->rng, -3.0, 0.0);
}

static double apart(const double *a, const double *b)
{
    double square = 0.0;
    for (int k = 0; k < 3; ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
    return sqrt(square);
}

/* The body as one in the plane. */
static void flatten(body *b)
{
    static const kind in_plane[JOINTS] = {HINGE, SLIDE,    HINGE, SLIDE,
                                          HINGE, IN_PLANE, HINGE, IN_PLANE};
    b->joint = in_plane[b->joint];
    b->at[2] = 0.0;
    for (int k = 0; k < 3 && b->joint == HINGE; ++k) b->axis[k] = k == 2;
    if (b->joint == SLIDE && fabs(b->axis[0]) + fabs(b->axis[1]) == 0.0) b->axis[0] = 1.0;
    if (b->joint == SLIDE) b->axis[2] = 0.0;
    for (int k = 0; k < POINTS; ++k) b->point[k][2] = 0.0;
    if (b->points == 2 && apart(b->point[0], b->point[1]) == 0.0) b->points = 1;
}

int scene_rates_of(kind joint)
{
    static const int rates[JOINTS] = {1, 1, 1, 2, 2, 3, 3, 6};
    return rates[joint];
}

static int coordinates_of(kind joint)
{
    return scene_rates_of(joint) + (joint == BALL || joint == FREE);
}

static void draw_element(scene *s)
{
    element e = {.law = (law)test_integer(&s->rng, 0, LAWS - 1),
                 .a = test_integer(&s->rng, 0, s->bodies - 1),
                 .b = test_integer(&s->rng, -1, s->bodies - 1)};
    const kind joint = s->body[e.a].joint;
    const bool quaternion = joint == BALL || joint == FREE;
    e.coordinate = test_integer(&s->rng, 0, scene_rates_of(joint) - 1);
    if (quaternion && e.law == ON_RATE) e.law = ON_ROTATION;
    if (!quaternion && e.law == ON_ROTATION) e.law = ON_RATE;
    if (e.law == ON_ROTATION) e.coordinate %= 3;
    if (test_chance(&s->rng, 0.6)) e.spring = test_decades(&s->rng, -3.0, 3.0);
    if (test_chance(&s->rng, 0.5)) e.damper = test_decades(&s->rng, -3.0, 3.0);
    draw_vector(s, e.point_a);
    draw_vector(s, e.point_b);
    for (int k = 0; k < 3; ++k) e.point_b[k] += 0.17 * (k + 1) * test_uniform(&s->rng);
    if (s->flat) e.point_a[2] = e.point_b[2] = 0.0;
    if (e.law == BETWEEN && e.a == e.b) return;
    if (e.spring > 0.0 || e.damper > 0.0) s->element[s->elements++] = e;
}

static void draw_position(scene *s, kind joint, bool zero, double *q)
{
    const bool quaternion = joint == BALL || joint == FREE;
    for (int k = 0; k < coordinates_of(joint); ++k)
        q[k] = zero ? (double)(quaternion && k == 0) : test_uniform(&s->rng);
    const double length =
        quaternion ? sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) : 1.0;
    for (int k = 0; k < 4 && quaternion; ++k) q[k] /= length;
}

scene scene_draw(int seed, bool flat)
{
    scene s = {.rng = test_seed(7000000 + (uint64_t)seed), .flat = flat};
    s.bodies = test_integer(&s.rng, 1, BODIES);
    const bool light = test_chance(&s.rng, 0.3), straight = test_chance(&s.rng, 0.3);
    double *q = s.q;
    for (int i = 0; i < s.bodies; ++i) {
        draw_body(&s, i, light);
        if (flat) flatten(s.body + i);
        draw_position(&s, s.body[i].joint, straight, q);
        q += coordinates_of(s.body[i].joint);
    }
    for (int k = test_integer(&s.rng, 0, s.bodies + 2); k > 0; --k) draw_element(&s);
    return s;
}

static mbsr_joint joint_of(const body *b, double length)
{
    const mbsr_frame A = mbsr_frame_at(b->at[0] * length, b->at[1] * length, b->at[2] * length);
    switch (b->joint) {
    case HINGE: return mbsr_joint_revolute(&A, NULL, b->axis);
    case SLIDE: return mbsr_joint_prismatic(&A, NULL, b->axis);
    case SCREW: return mbsr_joint_screw(&A, NULL, b->axis, 0.2 * length);
    case CYLINDER: return mbsr_joint_cylindrical(&A, NULL, b->axis);
    case UNIVERSAL: return mbsr_joint_universal(&A, NULL, b->axis, b->other);
    case IN_PLANE: return mbsr_joint_in_plane(&A, NULL);
    case BALL: return mbsr_joint_spherical(&A, NULL);
    default: return mbsr_joint_free(&A, NULL);
    }
}

static mbsr_joint flat_joint_of(const body *b, double length)
{
    const double x = b->at[0] * length, y = b->at[1] * length;
    const double angle = b->joint == SLIDE ? atan2(b->axis[1], b->axis[0]) : 0.0;
    const mbsr_planar_frame A = {x, y, angle}, B = {0.0, 0.0, angle};
    switch (b->joint) {
    case HINGE: return mbsr_joint_planar_revolute(A, B);
    case SLIDE: return mbsr_joint_planar_prismatic(A, B);
    default: return mbsr_joint_planar_free(A, B);
    }
}

static void times(const double *x, double factor, double *y)
{
    for (int k = 0; k < 3; ++k) y[k] = factor * x[k];
}

/* One, two or three points; the three are points of a plate. */
static mbsr_inertia inertia_of(const body *b, const units *in)
{
    mbsr_inertia sum = mbsr_inertia_zero();
    double x[POINTS][3];
    for (int k = 0; k < b->points; ++k) times(b->point[k], in->length, x[k]);
    const double mass = b->mass * in->mass;
    if (b->points == 1) return mbsr_inertia_point_mass(mass, x[0]);
    if (b->points == 2) return mbsr_inertia_rod(mass, x[0], x[1]);
    for (int k = 0; k < b->points; ++k)
        sum = mbsr_inertia_sum(sum, mbsr_inertia_point_mass(mass, x[k]));
    return sum;
}

/* The same in the plane: about the centre of mass, a third of the moment of its ends for a rod. */
static mbsr_inertia flat_inertia_of(const body *b, const units *in)
{
    const int n = b->points;
    const double mass = b->mass * in->mass * (n == 3 ? 3.0 : 1.0);
    double com[3] = {0.0}, square = 0.0;
    for (int k = 0; k < n; ++k) {
        for (int c = 0; c < 3; ++c) com[c] += b->point[k][c] / n;
    }
    for (int k = 0; k < n; ++k) square += pow(apart(b->point[k], com), 2) / n;
    times(com, in->length, com);
    return mbsr_inertia_planar(mass, com,
                               mass * in->length * in->length * square / (n == 2 ? 3.0 : 1.0));
}

/* Whether rate k of a joint is a velocity. */
static bool slides(kind joint, int k)
{
    return joint == SLIDE || (joint == CYLINDER && k == 1) || (joint == IN_PLANE && k < 2) ||
           (joint == FREE && k >= 3);
}

/* Rates, and coordinates that are zero, of the beams. */
static void place_beams(built *l, const scene *s, double length)
{
    for (int b = 0; b < s->beams; ++b) {
        for (int a = 0; a < s->beam[b].modes; ++a, ++l->nu) {
            l->q[l->nq++] = 0.0;
            l->unit[l->nu] = length;
            l->body_of[l->nu] = scene_beam_of(s, b);
        }
    }
}

static void place(built *l, const scene *s, double length)
{
    int from = 0;
    l->nq = l->nu = 0;
    for (int i = 0; i < s->bodies; ++i) {
        const kind joint = s->body[i].joint;
        const int more = coordinates_of(joint) - scene_rates_of(joint);
        for (int k = 0; k < coordinates_of(joint); ++k)
            l->q[l->nq++] = s->q[from++] * (slides(joint, k - more) ? length : 1.0);
        for (int k = 0; k < scene_rates_of(joint); ++k, ++l->nu) {
            l->unit[l->nu] = slides(joint, k) ? length : 1.0;
            l->body_of[l->nu] = i;
        }
    }
    place_beams(l, s, length);
}

int scene_first_rate(const built *l, int i)
{
    int k = 0;
    while (l->body_of[k] != i) ++k;
    return k;
}

static int first_coordinate(const scene *s, int i)
{
    int at = 0;
    for (int k = 0; k < i; ++k) at += coordinates_of(s->body[k].joint);
    return at;
}

void scene_find_point(const built *l, int i, const double in_body[3], double x[3])
{
    double pose[MBSR_MAX_D + 12] = {0.0};
    memcpy(x, in_body, 3 * sizeof *x);
    if (i < 0) return;
    assert_int_equal(mbsr_body_pose(l->model, l->data, i, pose), MBSR_OK);
    for (int k = 0; k < 3; ++k) {
        const double *R = pose + MBSR_POSE_R + k;
        x[k] = pose[MBSR_POSE_X + k] + R[0] * in_body[0] + R[3] * in_body[1] + R[6] * in_body[2];
    }
}

double scene_distance(const built *l, const element *e, double length, double along[3])
{
    double a[3], b[3], in_a[3], in_b[3], square = 0.0;
    times(e->point_a, length, in_a);
    times(e->point_b, length, in_b);
    scene_find_point(l, e->a, in_a, a);
    scene_find_point(l, e->b, in_b, b);
    for (int k = 0; k < 3; ++k) along[k] = a[k] - b[k], square += along[k] * along[k];
    for (int k = 0; k < 3; ++k) along[k] /= sqrt(square);
    return sqrt(square);
}

static void add_beam(built *l, const scene *s, int number, const units *in)
{
    const beam *b = s->beam + number;
    test_ritz ritz = {.length = b->length * in->length,
                      .density = b->density * in->mass / in->length,
                      .tip = b->tip * in->mass,
                      .modes = b->modes,
                      .markers = 2};
    ritz.at[1] = ritz.length;
    for (int a = 0; a < b->modes; ++a) {
        ritz.dir[a] = b->dir[a], ritz.power[a] = b->power[a], ritz.massless[a] = b->massless[a];
        ritz.K[a * (b->modes + 1)] = b->spring[a] * in->mass / (in->time * in->time);
        ritz.D[a * (b->modes + 1)] = b->damper[a] * in->mass / in->time;
    }
    mbsr_body_def def = mbsr_default_body_def();
    const mbsr_flex *flex = l->flex[number] = test_ritz_make(&ritz);
    def.parent = b->parent;
    def.joint = mbsr_joint_mount(flex, 0);
    def.inertia = mbsr_inertia_flexible(flex);
    assert_ok(mbsr_model_add_body(l->model, &def, NULL), mbsr_model_error(l->model));
    def = mbsr_default_body_def();
    def.parent = scene_beam_of(s, number);
    def.joint = mbsr_joint_marker(flex, 1);
    assert_ok(mbsr_model_add_body(l->model, &def, NULL), mbsr_model_error(l->model));
}

static void add_closing(built *l, const closing *c, const units *in)
{
    static const double axes[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    double a[3], b[3];
    times(c->point_a, in->length, a);
    times(c->point_b, in->length, b);
    const mbsr_closure_def def =
        mbsr_closure_rows(c->a, a, c->b < 0 ? MBSR_GROUND : c->b, b, c->rows, axes);
    assert_ok(mbsr_model_add_closure(l->model, &def, NULL), mbsr_model_error(l->model));
}

/* Springs at rest where the model stands. */
static void add_force(built *l, const scene *s, const element *e, const units *in, double rest)
{
    const double force = in->mass * in->length / (in->time * in->time), work = force * in->length;
    double point_a[3], point_b[3], stiffness[3] = {0.0}, damping[3] = {0.0};
    times(e->point_a, in->length, point_a);
    times(e->point_b, in->length, point_b);
    mbsr_force_def def;
    const double unit = e->law == BETWEEN ? in->length
                                          : l->unit[scene_first_rate(l, e->a) + e->coordinate],
                 spring = e->spring * work / (unit * unit),
                 damper = e->damper * work * in->time / (unit * unit);
    stiffness[e->coordinate % 3] = spring;
    damping[e->coordinate % 3] = damper;
    if (e->law == ON_RATE)
        def = mbsr_force_joint_spring(e->a, e->coordinate, spring, damper,
                                      l->q[first_coordinate(s, e->a) + e->coordinate]);
    else if (e->law == ON_ROTATION)
        def = mbsr_force_joint_rotation_spring(e->a, stiffness, damping,
                                               l->q + first_coordinate(s, e->a));
    else
        def = mbsr_force_point_spring(e->a, point_a, e->b < 0 ? MBSR_GROUND : e->b, point_b, spring,
                                      damper, rest);
    assert_ok(mbsr_model_add_force(l->model, &def, NULL), mbsr_model_error(l->model));
}

built scene_build(const scene *s, const units *in, const double *rest, bool flat)
{
    built l = {0};
    assert_int_equal(mbsr_model_create(NULL, &l.model, NULL), MBSR_OK);
    for (int i = 0; i < s->bodies; ++i) {
        const body *b = s->body + i;
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = b->parent < 0 ? MBSR_GROUND : b->parent;
        def.joint = flat ? flat_joint_of(b, in->length) : joint_of(b, in->length);
        if (flat) def.inertia = mbsr_inertia_zero();
        if (b->points > 0) def.inertia = flat ? flat_inertia_of(b, in) : inertia_of(b, in);
        assert_ok(mbsr_model_add_body(l.model, &def, NULL), mbsr_model_error(l.model));
    }
    for (int b = 0; b < s->beams; ++b) add_beam(&l, s, b, in);
    place(&l, s, in->length);
    for (int i = 0; i < s->bodies; ++i) {
        double values[6];
        const int n = scene_rates_of(s->body[i].joint), at = scene_first_rate(&l, i);
        for (int k = 0; k < n; ++k) {
            const double length = in->length / l.unit[at + k];
            values[k] = s->body[i].armature * in->mass * length * length;
        }
        if (s->body[i].armature > 0.0)
            assert_ok(mbsr_model_armature(l.model, i, n, values), mbsr_model_error(l.model));
    }
    for (int k = 0; k < s->elements && rest; ++k)
        add_force(&l, s, s->element + k, in, rest[k] * in->length);
    for (int b = 0; b < s->beams; ++b) {
        const mbsr_force_def def = mbsr_force_elastic(scene_beam_of(s, b), l.flex[b]);
        assert_ok(mbsr_model_add_force(l.model, &def, NULL), mbsr_model_error(l.model));
    }
    for (int k = 0; k < s->closures; ++k) add_closing(&l, s->closing + k, in);
    assert_ok(mbsr_model_finish(l.model), mbsr_model_error(l.model));
    assert_int_equal(mbsr_data_create(l.model, &l.data, NULL), MBSR_OK);
    return l;
}

void scene_destroy(built *l)
{
    mbsr_data_destroy(l->data);
    mbsr_model_destroy(l->model);
    for (int b = 0; b < BEAMS; ++b) mbsr_flex_destroy(l->flex[b]);
}

/* ---- beams and closures ---- */

/* Shapes of one kind have different powers: no combination of them moves nothing. */
static void draw_modes(scene *s, beam *b)
{
    static const int dir[] = {1, 2, 1, 2, 0};
    static const double power[] = {2.0, 2.0, 3.0, 3.0, 1.0};
    int at = test_integer(&s->rng, 0, 4);
    b->modes = test_integer(&s->rng, 1, MODES);
    for (int a = 0; a < b->modes; ++a, at = (at + 1) % 5) {
        b->dir[a] = dir[at], b->power[a] = power[at];
        b->massless[a] = test_chance(&s->rng, 0.5);
        if (test_chance(&s->rng, 0.7)) b->spring[a] = test_decades(&s->rng, -2.0, 3.0);
        if (test_chance(&s->rng, 0.4)) b->damper[a] = test_decades(&s->rng, -2.0, 2.0);
    }
}

/* A spring or damper, or both, between the end of a beam and some point. */
static void draw_element_at(scene *s, int marker)
{
    element e = {.law = BETWEEN, .a = marker, .b = test_integer(&s->rng, -1, s->bodies - 1)};
    const int parts = test_integer(&s->rng, 1, 3);
    if (parts & 1) e.spring = test_decades(&s->rng, -3.0, 3.0);
    if (parts & 2) e.damper = test_decades(&s->rng, -3.0, 3.0);
    if (test_chance(&s->rng, 0.3)) draw_vector(s, e.point_a);
    for (int k = 0; k < 3; ++k) e.point_b[k] = 1.3 * test_uniform(&s->rng);
    if (s->elements < ELEMENTS) s->element[s->elements++] = e;
}

void scene_add_beams(scene *s)
{
    int rates = 0;
    for (int i = 0; i < s->bodies; ++i) rates += scene_rates_of(s->body[i].joint);
    for (int k = test_integer(&s->rng, 1, BEAMS); k > 0 && rates + MODES <= RATES; --k) {
        beam *b = s->beam + s->beams++;
        *b = (beam){.parent = test_integer(&s->rng, 0, s->bodies - 1)};
        b->length = 0.5 + 0.4 * test_uniform(&s->rng);
        draw_modes(s, b);
        if (test_chance(&s->rng, 0.6)) b->density = test_decades(&s->rng, -2.0, 0.5);
        if (test_chance(&s->rng, 0.3)) b->tip = test_decades(&s->rng, -2.0, 0.5);
        rates += b->modes;
    }
    for (int k = 0; k < s->beams; ++k) {
        if (test_chance(&s->rng, 0.6)) draw_element_at(s, scene_beam_of(s, k) + 1);
    }
}

/* The point of body i where x is in the world. */
static void find_in_body(const built *l, int i, const double x[3], double in_body[3])
{
    static const double axes[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const double zero[3] = {0.0};
    double origin[3], end[3];
    scene_find_point(l, i, zero, origin);
    for (int k = 0; k < 3; ++k) {
        scene_find_point(l, i, axes[k], end);
        in_body[k] = 0.0;
        for (int c = 0; c < 3; ++c) in_body[k] += (end[c] - origin[c]) * (x[c] - origin[c]);
    }
}

/* Some body or, with a chance, marker. */
static int draw_end(scene *s, int first)
{
    const bool marker = s->beams > 0 && test_chance(&s->rng, 0.4);
    return marker ? scene_beam_of(s, test_integer(&s->rng, 0, s->beams - 1)) + 1
                  : test_integer(&s->rng, first, s->bodies - 1);
}

void scene_add_closures(scene *s)
{
    built l = scene_build(s, systems, NULL, false);
    if (!mbsr_stage_positions(l.model, l.data, 0.0, l.q)) {
        for (int k = test_integer(&s->rng, 1, CLOSURES); k > 0; --k) {
            closing *c = s->closing + s->closures;
            double x[3];
            *c = (closing){.a = draw_end(s, 0), .b = draw_end(s, -1)};
            c->rows = test_integer(&s->rng, 1, 3);
            if (c->a == c->b) continue;
            if (test_chance(&s->rng, 0.7)) draw_vector(s, c->point_a);
            scene_find_point(&l, c->a, c->point_a, x);
            find_in_body(&l, c->b, x, c->point_b);
            ++s->closures;
        }
    }
    scene_destroy(&l);
}
