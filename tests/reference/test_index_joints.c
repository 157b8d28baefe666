/* The index report, forward dynamics and the start on random trees of joints of all kinds: ball, universal,
 * free and planar joints beside hinges, slides and screws, armature, masses down to 1e-10 of others, points,
 * rods and discs on, beside or far from axes, and of hinges, slides and free bodies in the plane, in four
 * systems of units. What they must say follows from ranks
 * of velocities, told by the Jacobians of the bodies: those of points with mass and of rates with armature,
 * then of what dampers see, then of what springs see.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "span.h"
#include "units.h"

#include <stdbool.h>

enum { BODIES = 7, RATES = TEST_SPAN_MOST /* 6 BODIES */, POINTS = 3, ELEMENTS = 10 };

typedef enum kind { HINGE, SLIDE, SCREW, CYLINDER, UNIVERSAL, IN_PLANE, BALL, FREE, JOINTS } kind;

/* Points that stand for the mass: one, the two ends of a rod, three of a disc. */
typedef struct body {
    kind joint;
    int parent, points;
    double axis[3], other[3], at[3], mass, point[POINTS][3], armature;
} body;

typedef enum law { ON_RATE, ON_ROTATION, BETWEEN, LAWS } law;

typedef struct element {
    law law;
    int a, b, coordinate;
    double spring, damper, point_a[3], point_b[3];
} element;

typedef struct scene {
    test_rng rng;
    int bodies, elements;
    body body[BODIES];
    element element[ELEMENTS];
    double q[7 * BODIES]; /* SI */
    bool flat;            /* joints, points and motions in the plane z = 0 */
} scene;

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

static int rates_of(kind joint)
{
    static const int rates[JOINTS] = {1, 1, 1, 2, 2, 3, 3, 6};
    return rates[joint];
}

static int coordinates_of(kind joint)
{
    return rates_of(joint) + (joint == BALL || joint == FREE);
}

static void draw_element(scene *s)
{
    element e = {.law = (law)test_integer(&s->rng, 0, LAWS - 1),
                 .a = test_integer(&s->rng, 0, s->bodies - 1),
                 .b = test_integer(&s->rng, -1, s->bodies - 1)};
    const kind joint = s->body[e.a].joint;
    const bool quaternion = joint == BALL || joint == FREE;
    e.coordinate = test_integer(&s->rng, 0, rates_of(joint) - 1);
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

static scene draw(int seed, bool flat)
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

/* ---- the library's model ---- */

typedef struct built {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    int body_of[RATES];
    double unit[RATES], q[7 * BODIES], u[RATES]; /* of the rates: length or 1 */
} built;

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

static void place(built *l, const scene *s, double length)
{
    int from = 0;
    l->nq = l->nu = 0;
    for (int i = 0; i < s->bodies; ++i) {
        const kind joint = s->body[i].joint;
        const int more = coordinates_of(joint) - rates_of(joint);
        for (int k = 0; k < coordinates_of(joint); ++k)
            l->q[l->nq++] = s->q[from++] * (slides(joint, k - more) ? length : 1.0);
        for (int k = 0; k < rates_of(joint); ++k, ++l->nu) {
            l->unit[l->nu] = slides(joint, k) ? length : 1.0;
            l->body_of[l->nu] = i;
        }
    }
}

static int first_rate(const built *l, int i)
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

static void find_point(const built *l, int i, const double in_body[3], double x[3])
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

static double distance(const built *l, const element *e, double length, double along[3])
{
    double a[3], b[3], in_a[3], in_b[3], square = 0.0;
    times(e->point_a, length, in_a);
    times(e->point_b, length, in_b);
    find_point(l, e->a, in_a, a);
    find_point(l, e->b, in_b, b);
    for (int k = 0; k < 3; ++k) along[k] = a[k] - b[k], square += along[k] * along[k];
    for (int k = 0; k < 3; ++k) along[k] /= sqrt(square);
    return sqrt(square);
}

/* Springs at rest where the model stands. */
static void add_force(built *l, const scene *s, const element *e, const units *in, double rest)
{
    const double force = in->mass * in->length / (in->time * in->time), work = force * in->length;
    double point_a[3], point_b[3], stiffness[3] = {0.0}, damping[3] = {0.0};
    times(e->point_a, in->length, point_a);
    times(e->point_b, in->length, point_b);
    mbsr_force_def def;
    const int at = first_rate(l, e->a) + e->coordinate;
    const double unit = e->law == BETWEEN ? in->length : l->unit[at],
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

/* rest: lengths of the springs between points, in metres; NULL: no elements yet. flat: of bodies in the
 * plane. */
static built build(const scene *s, const units *in, const double *rest, bool flat)
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
    place(&l, s, in->length);
    for (int i = 0; i < s->bodies; ++i) {
        double values[6];
        const int n = rates_of(s->body[i].joint), at = first_rate(&l, i);
        for (int k = 0; k < n; ++k) {
            const double length = in->length / l.unit[at + k];
            values[k] = s->body[i].armature * in->mass * length * length;
        }
        if (s->body[i].armature > 0.0)
            assert_ok(mbsr_model_armature(l.model, i, n, values), mbsr_model_error(l.model));
    }
    for (int k = 0; k < s->elements && rest; ++k)
        add_force(&l, s, s->element + k, in, rest[k] * in->length);
    assert_ok(mbsr_model_finish(l.model), mbsr_model_error(l.model));
    assert_int_equal(mbsr_data_create(l.model, &l.data, NULL), MBSR_OK);
    return l;
}

static void destroy(built *l)
{
    mbsr_data_destroy(l->data);
    mbsr_model_destroy(l->model);
}

/* ---- ranks of velocities ---- */

/* row (nu) += sign (along . velocity of a point of body i). */
static void add_velocity(const built *l, int i, const double in_body[3], const double along[3],
                         double sign, double *row)
{
    double J[6 * RATES], x[3], origin[3];
    const double zero[3] = {0.0};
    if (i < 0) return;
    assert_int_equal(mbsr_body_jacobian(l->model, l->data, i, J), MBSR_OK);
    find_point(l, i, in_body, x);
    find_point(l, i, zero, origin);
    for (int k = 0; k < 3; ++k) x[k] -= origin[k];
    for (int c = 0; c < l->nu; ++c) {
        const double *w = J + 6 * c;
        const double v[3] = {w[3] + w[1] * x[2] - w[2] * x[1], w[4] + w[2] * x[0] - w[0] * x[2],
                             w[5] + w[0] * x[1] - w[1] * x[0]};
        row[c] += sign * (along[0] * v[0] + along[1] * v[1] + along[2] * v[2]);
    }
}

/* What an element sees, for the model in SI. */
static void measure(const built *l, const element *e, double *row)
{
    double along[3];
    memset(row, 0, RATES * sizeof *row);
    if (e->law != BETWEEN) {
        row[first_rate(l, e->a) + e->coordinate] = 1.0;
        return;
    }
    (void)distance(l, e, 1.0, along);
    add_velocity(l, e->a, e->point_a, along, 1.0, row);
    add_velocity(l, e->b, e->point_b, along, -1.0, row);
}

/* Largest mass of a point, or armature. */
static double largest_mass(const scene *s)
{
    double largest = 0.0;
    for (int i = 0; i < s->bodies; ++i) {
        if (s->body[i].points > 0) largest = fmax(largest, s->body[i].mass);
        largest = fmax(largest, s->body[i].armature);
    }
    return largest;
}

/* Velocities of points and rates with armature, or with `weighed` these times the root of their share of
 * the largest mass. */
static test_span move(const built *l, const scene *s, bool weighed)
{
    static double rows[BODIES * (3 * POINTS + 6)][RATES];
    const double largest = largest_mass(s);
    test_span p = {.n = l->nu, .clear = 1e-6};
    int count = 0;
    memset(rows, 0, sizeof rows);
    for (int i = 0; i < s->bodies; ++i) {
        const body *b = s->body + i;
        for (int k = 0; k < 3 * b->points; ++k, ++count) {
            const double weight = weighed ? sqrt(b->mass / largest) : 1.0;
            const double along[3] = {weight * (k % 3 == 0), weight * (k % 3 == 1),
                                     weight * (k % 3 == 2)};
            add_velocity(l, i, b->point[k / 3], along, 1.0, rows[count]);
        }
        for (int k = 0; k < rates_of(b->joint) && b->armature > 0.0; ++k)
            rows[count++][first_rate(l, i) + k] = weighed ? sqrt(b->armature / largest) : 1.0;
    }
    test_span_widen(&p, count, rows);
    return p;
}

/* Directions in which a light mass stands next to its axis, with less than 1e-14 of the inertia of others,
 * are beyond what the library promises (docs/rank_and_index.md). */
static test_span masses(const built *l, const scene *s)
{
    test_span p = move(l, s, false);
    const test_span weighed = move(l, s, true);
    for (int k = 0; k < weighed.count; ++k) p.doubtful = p.doubtful || weighed.length[k] < 1e-7;
    p.doubtful = p.doubtful || weighed.count < p.count;
    return p;
}

typedef struct verdict {
    int dynamic, damped, elastic, undetermined;
    unsigned undetermined_in;
    bool settled;
    test_span massive;
    double seen[ELEMENTS][RATES], rest[ELEMENTS];
} verdict;

/* Whether there are as many dynamic directions nearby, none of them hardly. */
static bool same_beside(built *l, const scene *s, int dynamic)
{
    double q[7 * BODIES];
    for (int k = 0; k < l->nq; ++k) q[k] = l->q[k] + 1e-3 * sin(1.7 * k + 0.3);
    if (mbsr_positions(l->model, l->data, 0.0, q)) return false;
    const test_span p = move(l, s, false);
    return !p.doubtful && p.count == dynamic;
}

static verdict judge(const scene *s)
{
    verdict v = {.settled = true};
    built l = build(s, systems, NULL, false);
    double rows[1][RATES];
    if (mbsr_positions(l.model, l.data, 0.0, l.q)) { /* two axes of a universal joint in a line */
        destroy(&l);
        return (verdict){.settled = false};
    }
    v.massive = masses(&l, s);
    test_span p = v.massive;
    v.dynamic = p.count;
    for (int k = 0; k < s->elements; ++k) {
        double along[3];
        measure(&l, s->element + k, v.seen[k]);
        if (s->element[k].law == BETWEEN) v.rest[k] = distance(&l, s->element + k, 1.0, along);
        v.settled = v.settled && (s->element[k].law != BETWEEN || v.rest[k] > 0.05);
    }
    for (int springs = 0; springs < 2; ++springs) {
        for (int k = 0; k < s->elements; ++k) {
            memcpy(rows[0], v.seen[k], sizeof rows[0]);
            if ((springs ? s->element[k].spring : s->element[k].damper) > 0.0)
                test_span_widen(&p, 1, rows);
        }
        *(springs ? &v.elastic : &v.damped) = p.count - v.dynamic - (springs ? v.damped : 0);
    }
    v.undetermined = l.nu - p.count;
    v.settled = v.settled && !p.doubtful;
    for (int k = 0; k < l.nu; ++k) {
        double unit[RATES] = {0.0};
        unit[k] = 1.0;
        const double open = test_span_beside(&p, unit);
        if (open > 1e-6) v.undetermined_in |= 1u << l.body_of[k];
        v.settled = v.settled && (open < 1e-12 || open > 1e-4);
    }
    v.settled = v.settled && same_beside(&l, s, v.dynamic);
    destroy(&l);
    return v;
}

/* ---- what the library says ---- */

static bool lists(const mbsr_direction *d, int force)
{
    bool some = false;
    for (int k = 0; k < d->forces; ++k) some = some || d->force[k] == force;
    return some;
}

/* A direction moves no mass, and no damper unless it is damped; it lists what determines it. */
static bool right_direction(const scene *s, const verdict *v, const built *l,
                            const mbsr_direction *d)
{
    double a[RATES] = {0.0}, largest = 0.0;
    for (int k = 0; k < d->terms; ++k) {
        const int at = first_rate(l, d->term[k].body) + d->term[k].coordinate;
        a[at] = d->term[k].weight / l->unit[at];
        largest = fmax(largest, fabs(a[at]));
    }
    for (int r = 0; r < v->massive.count; ++r) {
        double moved = 0.0;
        for (int k = 0; k < l->nu; ++k) moved += v->massive.v[r][k] * a[k];
        if (fabs(moved) > 1e-5 * largest) return false;
    }
    for (int k = 0; k < s->elements; ++k) {
        const bool damps = s->element[k].damper > 0.0, springs = s->element[k].spring > 0.0,
                   damped = d->kind == MBSR_DIRECTION_DAMPED,
                   open = d->kind == MBSR_DIRECTION_UNDETERMINED,
                   counts = damped ? damps : springs && !open;
        double seen = 0.0;
        for (int c = 0; c < l->nu; ++c) seen += v->seen[k][c] * a[c] / largest;
        if (fabs(seen) < 1e-12 && lists(d, k)) return false;
        if (fabs(seen) < 1e-5) continue;
        if (lists(d, k) != counts || (damps && !damped) || (springs && open)) return false;
    }
    return (d->forces > 0) == (d->kind != MBSR_DIRECTION_UNDETERMINED);
}

static bool right_report(const scene *s, const verdict *v, const built *l)
{
    mbsr_index_report *r = NULL;
    unsigned bits = 0;
    if (mbsr_index_report_create(l->model, l->data, 0.0, l->q, l->u, &r)) return false;
    bool right = r->dynamic == v->dynamic && r->damped == v->damped && r->elastic == v->elastic &&
                 r->undetermined == v->undetermined;
    for (int k = 0; k < r->directions; ++k) {
        const mbsr_direction *d = r->direction + k;
        right = right && right_direction(s, v, l, d);
        for (int t = 0; t < d->terms; ++t)
            bits |= d->kind == MBSR_DIRECTION_UNDETERMINED ? 1u << d->term[t].body : 0u;
    }
    mbsr_index_report_destroy(l->model, r);
    return right && bits == v->undetermined_in;
}

/* All springs are at rest: a start moves nothing but what no damper sees; refused where something is
 * open. */
static bool right_start(const scene *s, const verdict *v, const built *l, const units *in)
{
    double y[7 * BODIES + 2 * RATES], yp[7 * BODIES + 2 * RATES];
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    assert_ok(mbsr_dae_pack(l->model, l->data, form, 0.0, l->q, l->u, y), mbsr_data_error(l->data));
    const int status = mbsr_dae_consistent(l->model, l->data, form, 0.0, y, yp, NULL, NULL);
    if (v->undetermined > 0) return status == MBSR_UNDETERMINED;
    bool still = status == MBSR_OK;
    for (int k = 0; k < l->nq && still; ++k)
        still = fabs(y[k] - l->q[k]) <= 1e-9 * fmax(in->length, 1.0);
    for (int k = 0; k < s->elements && still; ++k) {
        double speed = 0.0;
        for (int c = 0; c < l->nu; ++c)
            speed += v->seen[k][c] * y[l->nq + l->nu + c] / l->unit[c] * in->time;
        still = s->element[k].damper == 0.0 || fabs(speed) <= 1e-6;
    }
    return still;
}

static int wrong(int seed, const scene *s, const verdict *v, const units *in)
{
    built l = build(s, in, v->rest, s->flat);
    double udot[RATES];
    const bool reported = right_report(s, v, &l), started = right_start(s, v, &l, in);
    const int forward = mbsr_forward_dynamics(l.model, l.data, 0.0, l.q, l.u, NULL, udot),
              expected = v->dynamic < l.nu ? MBSR_UNDETERMINED : MBSR_OK;
    const bool right = reported && started && forward == expected;
    if (!right)
        print_error("seed %d (%s): report %d, start %d, forward dynamics %d; expected dynamic %d "
                    "damped %d elastic %d undetermined %d in %x\n%s\n",
                    seed, in->name, reported, started, forward, v->dynamic, v->damped, v->elastic,
                    v->undetermined, v->undetermined_in, mbsr_data_error(l.data)->text);
    destroy(&l);
    return !right;
}

static void try_scenes(int seeds, bool flat)
{
    int count = 0, judged = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        const scene s = draw(seed, flat);
        const verdict v = judge(&s);
        if (!v.settled) continue;
        ++judged;
        for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l)
            count += wrong(seed, &s, &v, systems + l);
    }
    assert_true(judged > seeds / 2);
    assert_int_equal(count, 0);
}

static void verdicts_are_those_of_the_velocities(void **state)
{
    (void)state;
    try_scenes(test_long() ? 7500 : test_seeds(60, 500), false);
}

static void also_of_bodies_in_the_plane(void **state)
{
    (void)state;
    try_scenes(test_long() ? 7500 : test_seeds(60, 500), true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verdicts_are_those_of_the_velocities),
        cmocka_unit_test(also_of_bodies_in_the_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
