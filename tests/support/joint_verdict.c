/* Ranks of velocities of random trees: see joint_scene.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joint_scene.h"

/* row (nu) += sign (along . velocity of a point of body i). */
static void add_velocity(const built *l, int i, const double in_body[3], const double along[3],
                         double sign, double *row)
{
    double J[6 * RATES], x[3], origin[3];
    const double zero[3] = {0.0};
    if (i < 0) return;
    assert_int_equal(mbsr_body_jacobian(l->model, l->data, i, J), MBSR_OK);
    scene_find_point(l, i, in_body, x);
    scene_find_point(l, i, zero, origin);
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
        row[scene_first_rate(l, e->a) + e->coordinate] = 1.0;
        return;
    }
    (void)scene_distance(l, e, 1.0, along);
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
        for (int k = 0; k < scene_rates_of(b->joint) && b->armature > 0.0; ++k)
            rows[count++][scene_first_rate(l, i) + k] = weighed ? sqrt(b->armature / largest) : 1.0;
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

/* Whether there are as many dynamic directions nearby, none of them hardly. */
static bool same_beside(built *l, const scene *s, int dynamic)
{
    double q[7 * BODIES];
    for (int k = 0; k < l->nq; ++k) q[k] = l->q[k] + 1e-3 * sin(1.7 * k + 0.3);
    if (mbsr_positions(l->model, l->data, 0.0, q)) return false;
    const test_span p = move(l, s, false);
    return !p.doubtful && p.count == dynamic;
}

verdict scene_judge(const scene *s)
{
    verdict v = {.settled = true};
    built l = scene_build(s, systems, NULL, false);
    double rows[1][RATES];
    if (mbsr_positions(l.model, l.data, 0.0, l.q)) { /* two axes of a universal joint in a line */
        scene_destroy(&l);
        return (verdict){.settled = false};
    }
    v.massive = masses(&l, s);
    test_span p = v.massive;
    v.dynamic = p.count;
    for (int k = 0; k < s->elements; ++k) {
        double along[3];
        measure(&l, s->element + k, v.seen[k]);
        if (s->element[k].law == BETWEEN)
            v.rest[k] = scene_distance(&l, s->element + k, 1.0, along);
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
    scene_destroy(&l);
    return v;
}
