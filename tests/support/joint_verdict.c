/* Ranks of velocities of random trees: see joint_scene.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joint_scene.h"

void scene_add_velocity(const built *l, int i, const double in_body[3], const double along[3],
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
    scene_add_velocity(l, e->a, e->point_a, along, 1.0, row);
    scene_add_velocity(l, e->b, e->point_b, along, -1.0, row);
}

/* Largest mass of a point, or armature. */
static double largest_mass(const scene *s)
{
    double largest = 0.0;
    for (int i = 0; i < s->bodies; ++i) {
        if (s->body[i].points > 0) largest = fmax(largest, s->body[i].mass);
        largest = fmax(largest, s->body[i].armature);
    }
    for (int b = 0; b < s->beams; ++b)
        largest = fmax(largest, fmax(s->beam[b].tip, s->beam[b].density * s->beam[b].length));
    return largest;
}

/* Rows of velocities. */
enum { SAMPLES = 4, ROWS = BODIES * (3 * POINTS + 6) + 3 * BEAMS * (SAMPLES + 1) };

typedef struct velocities {
    int count;
    double row[ROWS][RATES];
} velocities;

/* weight times the velocity of the material point x of a beam, in three rows: of shapes with mass.
 */
static void add_point_of_beam(const built *l, const scene *s, const double *q, int number, double x,
                              double weight, velocities *v)
{
    static const double axes[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const beam *b = s->beam + number;
    const double zero[3] = {0.0};
    double at[3] = {x, 0.0, 0.0}, origin[3], end[3];
    const double *shape = q + l->nq - l->nu + scene_first_rate(l, scene_beam_of(s, number));
    for (int a = 0; a < b->modes; ++a)
        at[b->dir[a]] += b->massless[a] ? 0.0 : shape[a] * pow(x / b->length, b->power[a]);
    scene_find_point(l, b->parent, zero, origin);
    for (int k = 0; k < 3; ++k, ++v->count) {
        const double along[3] = {weight * axes[k][0], weight * axes[k][1], weight * axes[k][2]};
        double *row = v->row[v->count] + scene_first_rate(l, scene_beam_of(s, number));
        scene_add_velocity(l, b->parent, at, along, 1.0, v->row[v->count]);
        for (int a = 0; a < b->modes; ++a) {
            scene_find_point(l, b->parent, axes[b->dir[a]], end);
            if (!b->massless[a])
                row[a] += weight * (end[k] - origin[k]) * pow(x / b->length, b->power[a]);
        }
    }
}

/* As many points as tell the shapes from each other and from motions of a rigid body. */
static void add_beams(const built *l, const scene *s, const double *q, double largest,
                      velocities *v)
{
    for (int k = 0; k < s->beams; ++k) {
        const beam *b = s->beam + k;
        const double share = largest > 0.0 ? sqrt(b->density * b->length / largest) : 1.0;
        for (int n = 0; n < SAMPLES && b->density > 0.0; ++n)
            add_point_of_beam(l, s, q, k, b->length * (n + 0.5) / SAMPLES, share, v);
        if (b->tip > 0.0)
            add_point_of_beam(l, s, q, k, b->length, largest > 0.0 ? sqrt(b->tip / largest) : 1.0,
                              v);
    }
}

static void add_bodies(const built *l, const scene *s, double largest, velocities *v)
{
    for (int i = 0; i < s->bodies; ++i) {
        const body *b = s->body + i;
        for (int k = 0; k < 3 * b->points; ++k, ++v->count) {
            const double weight = largest > 0.0 ? sqrt(b->mass / largest) : 1.0;
            const double along[3] = {weight * (k % 3 == 0), weight * (k % 3 == 1),
                                     weight * (k % 3 == 2)};
            scene_add_velocity(l, i, b->point[k / 3], along, 1.0, v->row[v->count]);
        }
        for (int k = 0; k < scene_rates_of(b->joint) && b->armature > 0.0; ++k)
            v->row[v->count++][scene_first_rate(l, i) + k] =
                largest > 0.0 ? sqrt(b->armature / largest) : 1.0;
    }
}

/* What closures see. */
static test_span close_loops(const built *l, const scene *s)
{
    test_span p = {.n = l->nu, .clear = 1e-6};
    double rows[3 * CLOSURES][RATES] = {{0.0}};
    int count = 0;
    for (int n = 0; n < s->closures; ++n) {
        const closing *c = s->closing + n;
        for (int k = 0; k < c->rows; ++k, ++count) {
            const double along[3] = {k == 0, k == 1, k == 2};
            scene_add_velocity(l, c->a, c->point_a, along, 1.0, rows[count]);
            scene_add_velocity(l, c->b, c->point_b, along, -1.0, rows[count]);
        }
    }
    test_span_widen(&p, count, rows);
    return p;
}

/* At positions q: p, and velocities of points and rates with armature, or with `weighed` these
 * times the root of their share of the largest mass. */
static test_span move(const built *l, const scene *s, const double *q, test_span p, bool weighed)
{
    static velocities v;
    const double largest = weighed ? largest_mass(s) : 0.0;
    memset(&v, 0, sizeof v);
    add_bodies(l, s, largest, &v);
    add_beams(l, s, q, largest, &v);
    test_span_widen(&p, v.count, v.row);
    return p;
}

/* Directions in which a light mass stands next to its axis, with less than 1e-14 of the inertia of
 * others, are beyond what the library promises (docs/rank_and_index.md). */
static test_span masses(const built *l, const scene *s, test_span held)
{
    test_span p = move(l, s, l->q, held, false);
    const test_span weighed = move(l, s, l->q, held, true);
    for (int k = 0; k < weighed.count; ++k) p.doubtful = p.doubtful || weighed.length[k] < 1e-7;
    p.doubtful = p.doubtful || weighed.count < p.count;
    return p;
}

/* Whether closures hold as much, and masses move in as many directions, nearby, none of them
 * hardly. */
static bool same_beside(built *l, const scene *s, int held, int massive)
{
    double q[COORDINATES];
    for (int k = 0; k < l->nq; ++k) q[k] = l->q[k] + 1e-3 * sin(1.7 * k + 0.3);
    if (mbsr_stage_positions(l->model, l->data, 0.0, q)) return false;
    const test_span closed = close_loops(l, s), p = move(l, s, q, closed, false);
    return !p.doubtful && closed.count == held && p.count == massive;
}

/* The shapes of beams, of which springs or dampers see one each. */
static void widen_by_beams(const built *l, const scene *s, bool springs, test_span *p)
{
    for (int k = 0; k < s->beams; ++k) {
        const beam *b = s->beam + k;
        for (int a = 0; a < b->modes; ++a) {
            double row[1][RATES] = {{0.0}};
            row[0][scene_first_rate(l, scene_beam_of(s, k)) + a] = 1.0;
            if ((springs ? b->spring[a] : b->damper[a]) > 0.0) test_span_widen(p, 1, row);
        }
    }
}

verdict scene_judge(const scene *s)
{
    verdict v = {.settled = true};
    built l = scene_build(s, systems, NULL, false);
    double rows[1][RATES];
    if (mbsr_stage_positions(l.model, l.data, 0.0,
                             l.q)) { /* two axes of a universal joint in a line */
        scene_destroy(&l);
        return (verdict){.settled = false};
    }
    const test_span nothing = {.n = l.nu, .clear = 1e-6}, closed = close_loops(&l, s),
                    tree = move(&l, s, l.q, nothing, false);
    v.massive = masses(&l, s, closed);
    test_span p = v.massive;
    v.dynamic = p.count - closed.count;
    v.held = p.count - tree.count;
    v.settled = !tree.doubtful;
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
        widen_by_beams(&l, s, springs, &p);
        *(springs ? &v.elastic : &v.damped) = p.count - v.massive.count - (springs ? v.damped : 0);
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
    v.settled = v.settled && same_beside(&l, s, closed.count, v.massive.count);
    scene_destroy(&l);
    return v;
}
