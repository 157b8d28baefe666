/* Points of contact: known ones, random pairs against alternating projections, what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "shapes.h"

#include <stdlib.h>

static const double still[12] = {0};

static mbsr_shape ground(void)
{
    mbsr_shape s = mbsr_default_shape();
    s.kind = MBSR_SHAPE_PLANE;
    s.law.friction = 0.5;
    return s;
}

/* ---- known points ---- */

/* Shapes standing on a plane, pressed in by 1 mm. */
static void on_plane(void **unused)
{
    (void)unused;
    static const struct {
        mbsr_shape_kind kind;
        double height;
        int points; /* with a depth of 1 mm */
    } known[] = {{MBSR_SHAPE_SPHERE, 0.2, 1},
                 {MBSR_SHAPE_CAPSULE, 0.35, 1},
                 {MBSR_SHAPE_CYLINDER, 0.25, 8},
                 {MBSR_SHAPE_BOX, 0.15, 4},
                 {MBSR_SHAPE_ELLIPSOID, 0.15, 1}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; ++k) {
        mbsr_contact_point point[32];
        const mbsr_shape shapes[2] = {ground(), sample_shape(known[k].kind, 0)};
        scene s = scene_of(2, shapes);
        const double q[7] = {1, 0, 0, 0, 0.3, -0.2, known[k].height - 1e-3};
        const int count = points_at(&s, q, still, 32, point);
        assert_int_equal(count, known[k].points);
        for (int l = 0; l < count; ++l) {
            assert_close(point[l].depth, 1e-3, 1e-12);
            assert_close(point[l].point[2], -0.5e-3, 1e-12);
            assert_close(point[l].normal[2], -1.0, 1e-12); /* of the plane, which is first */
            assert_close(point[l].normal_force, 2e4 * pow(1e-3, 1.5), 1e-12);
        }
        end_scene(&s);
    }
}

/* A box on a larger box rests on its four corners, turned by any angle; crossed bars on one point.
 */
static void on_boxes(void **unused)
{
    (void)unused;
    mbsr_contact_point point[64];
    mbsr_shape shapes[2] = {sample_shape(MBSR_SHAPE_BOX, 0), sample_shape(MBSR_SHAPE_BOX, 0)};
    shapes[0].size[0] = shapes[0].size[1] = 1.0;
    scene s = scene_of(2, shapes);
    for (int k = 0; k < 7; ++k) {
        const double q[14] = {1, 0, 0, 0, 0, 0, 0, cos(0.1 * k), 0, 0, sin(0.1 * k), 0.1, 0, 0.299};
        assert_int_equal(points_at(&s, q, still, 64, point), 4);
        for (int l = 0; l < 4; ++l) assert_close(point[l].depth, 1e-3, 1e-12);
        for (int l = 0; l < 4; ++l) assert_close(point[l].normal[2], -1.0, 1e-12);
    }
    end_scene(&s);
    mbsr_shape bars[2] = {sample_shape(MBSR_SHAPE_CAPSULE, 0), sample_shape(MBSR_SHAPE_CAPSULE, 0)};
    s = scene_of(2, bars);
    const double half = sqrt(0.5);
    const double q[14] = {half, half, 0, 0, 0, 0, 0, half, 0, half, 0, 0, 0, 0.199};
    assert_int_equal(points_at(&s, q, still, 64, point), 1);
    assert_close(point[0].depth, 1e-3, 1e-12);
    assert_close(point[0].point[2], 0.0995, 1e-12);
    end_scene(&s);
}

/* ---- random pairs ---- */

/* The point of a shape's core nearest to x, both in the shape's frame: by projections of its own.
 */
static void nearest(const mbsr_shape *s, const double x[3], double y[3])
{
    memcpy(y, x, 3 * sizeof *y);
    if (s->kind == MBSR_SHAPE_SPHERE) {
        memset(y, 0, 3 * sizeof *y);
    } else if (s->kind == MBSR_SHAPE_CAPSULE) {
        y[0] = y[1] = 0.0;
        y[2] = fmax(-s->size[1], fmin(s->size[1], x[2]));
    } else if (s->kind == MBSR_SHAPE_BOX) {
        const double r = fmin(s->size[0], fmin(s->size[1], s->size[2])) / 20.0;
        for (int k = 0; k < 3; ++k) y[k] = fmax(r - s->size[k], fmin(s->size[k] - r, x[k]));
    } else { /* an octahedron: Dykstra's projections on its half spaces */
        double extra[8][3] = {{0}};
        for (int round = 0; round < 60; ++round) {
            for (int f = 0; f < 8; ++f) {
                const double n[3] = {(f & 1 ? 1 : -1) / 0.3, (f & 2 ? 1 : -1) / 0.2,
                                     (f & 4 ? 1 : -1) / 0.25};
                double z[3], over = -1.0, square = 0.0;
                for (int k = 0; k < 3; ++k) {
                    z[k] = y[k] + extra[f][k];
                    over += n[k] * z[k];
                    square += n[k] * n[k];
                }
                for (int k = 0; k < 3; ++k) {
                    y[k] = z[k] - (over > 0.0 ? over / square * n[k] : 0.0);
                    extra[f][k] = z[k] - y[k];
                }
            }
        }
    }
}

static double radius_of(const mbsr_shape *s)
{
    if (s->kind == MBSR_SHAPE_BOX) return fmin(s->size[0], fmin(s->size[1], s->size[2])) / 20.0;
    return s->kind == MBSR_SHAPE_MESH ? 0.3 / 50.0 : s->size[0];
}

static void turn(const double q[4], double sign, const double x[3], double y[3])
{
    const double w = q[0], v[3] = {sign * q[1], sign * q[2], sign * q[3]};
    double t[3];
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        t[k] = 2.0 * (v[i] * x[j] - v[j] * x[i]);
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        y[k] = x[k] + w * t[k] + v[i] * t[j] - v[j] * t[i];
    }
}

/* How far a core reaches along n, both in the shape's frame. */
static double reach_of(const mbsr_shape *s, const double n[3])
{
    double most = -INFINITY, sum = 0.0;
    if (s->kind == MBSR_SHAPE_SPHERE) return 0.0;
    if (s->kind == MBSR_SHAPE_CAPSULE) return s->size[1] * fabs(n[2]);
    for (int k = 0; k < 3; ++k) sum += (s->size[k] - radius_of(s)) * fabs(n[k]);
    if (s->kind == MBSR_SHAPE_BOX) return sum;
    for (int k = 0; k < 6; ++k) {
        const double *x = octahedron + 3 * k;
        most = fmax(most, n[0] * x[0] + n[1] * x[1] + n[2] * x[2]);
    }
    return most;
}

/* The distance of two cores by alternating projections, which comes from above; from below, what
 * separates them along the line of the points found. */
static double distance(const mbsr_shape *shapes, const double *q, double *below)
{
    double x[3] = {0, 0, 0}, last[3] = {0, 0, 0}, between = 0.0;
    int before = 0; /* whose point `last` is */
    for (int round = 0; round < 3000; ++round) {
        const double *p = q + 7 * (round % 2);
        double arm[3], local[3], on[3], change = 0.0;
        for (int k = 0; k < 3; ++k) arm[k] = x[k] - p[4 + k];
        turn(p, -1.0, arm, local);
        nearest(shapes + round % 2, local, on);
        turn(p, 1.0, on, arm);
        between = 0.0;
        for (int k = 0; k < 3; ++k) {
            const double now = arm[k] + p[4 + k];
            between += (now - x[k]) * (now - x[k]);
            change += fabs(now - last[k]);
            last[k] = x[k];
            x[k] = now;
        }
        before = 1 - round % 2;
        if (round > 4 && change < 1e-13) break;
    }
    *below = 0.0;
    for (int b = 0; b < 2; ++b) { /* x is the last point, `last` the one before */
        const int to = b == 0 ? 1 : -1;
        double n[3], local[3];
        for (int k = 0; k < 3; ++k) n[k] = to * (x[k] - last[k]) / sqrt(between);
        const int which = b == 0 ? before : 1 - before;
        turn(q + 7 * which, -1.0, n, local);
        for (int k = 0; k < 3; ++k) *below -= n[k] * q[7 * which + 4 + k];
        *below -= reach_of(shapes + which, local);
    }
    return sqrt(between);
}

static void random_pairs(void **unused)
{
    (void)unused;
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_SPHERE, MBSR_SHAPE_CAPSULE, MBSR_SHAPE_BOX,
                                            MBSR_SHAPE_MESH};
    uint64_t seed = 3;
    int touching = 0, apart = 0, unsure = 0;
    const char *more = getenv("MBSR_CONTACT_PAIRS");
    const int rounds = more ? atoi(more) : test_long() ? 6000 : 60; /* 62500: a million pairs */
    for (int pair = 0; pair < 16; ++pair) {
        const mbsr_shape shapes[2] = {sample_shape(kinds[pair / 4], 0),
                                      sample_shape(kinds[pair % 4], 0)};
        scene s = scene_of(2, shapes);
        for (int k = 0; k < rounds; ++k) {
            double q[14], deepest = -1.0;
            mbsr_contact_point point[64];
            for (int l = 0; l < 14; ++l) q[l] = draw(&seed) * (l % 7 < 4 ? 1.0 : 0.25);
            for (int b = 0; b < 2; ++b) {
                const double *p = q + 7 * b;
                const double size = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
                for (int l = 0; l < 4; ++l) q[7 * b + l] /= size;
            }
            const int count = points_at(&s, q, still, 64, point);
            const double reach = radius_of(shapes) + radius_of(shapes + 1), slack = 1e-9;
            double below;
            const double above = distance(shapes, q, &below);
            for (int l = 0; l < count && l < 64; ++l) deepest = fmax(deepest, point[l].depth);
            if (!(below >= 1e-3 * reach)) continue; /* cores that overlap, or nearly so */
            unsure += above - below > 1e-6;
            if (above < reach) {
                /* from edges, where they are nearly parallel or at their ends, comes less force,
                 * but that depth */
                assert_true(count > 0);
                if (deepest < reach - above - slack || deepest > reach - below + slack)
                    fail_msg("kinds %d %d, state %d: depth %.9g, not %.9g .. %.9g",
                             (int)shapes->kind, (int)shapes[1].kind, k, deepest, reach - above,
                             reach - below);
                ++touching;
            } else if (below > reach) {
                assert_int_equal(count, 0);
                ++apart;
            }
        }
        end_scene(&s);
    }
    print_message("%d touching, %d apart, %d known to less than 1e-6\n", touching, apart, unsure);
    assert_true(touching > 3 * rounds && apart > rounds && unsure < rounds);
}

/* ---- edges that have passed each other ---- */

/* The force on the first of two boxes, which lie flat on each other, crosswise, a fifth deeper than
 * both roundings; the upper one is tilted. */
static void force_of_tilt(scene *s, double tilt, double force[3])
{
    const double turn = 0.3, depth = 1.2 * 2.0 * 0.15 / 20.0;
    const double q[14] = {1.0,
                          0.0,
                          0.0,
                          0.0,
                          0.0,
                          0.0,
                          0.0,
                          cos(turn) * cos(0.5 * tilt),
                          cos(turn) * sin(0.5 * tilt),
                          sin(turn) * sin(0.5 * tilt),
                          sin(turn) * cos(0.5 * tilt),
                          0.05,
                          0.02,
                          2.0 * 0.15 - depth};
    mbsr_contact_point point[64];
    const int count = points_at(s, q, still, 64, point);
    assert_true(count > 4 && count <= 64);
    for (int k = 0; k < 3; ++k) force[k] = 0.0;
    for (int l = 0; l < count; ++l)
        for (int k = 0; k < 3; ++k) force[k] += point[l].normal_force * point[l].normal[k];
}

/* As the box tilts from one side to the other the force does not jump, and pushes apart. */
static void flat_on_flat(void **unused)
{
    (void)unused;
    const mbsr_shape shapes[2] = {sample_shape(MBSR_SHAPE_BOX, 0), sample_shape(MBSR_SHAPE_BOX, 0)};
    scene s = scene_of(2, shapes);
    double last[3], now[3];
    force_of_tilt(&s, -2e-3, last);
    for (int k = -199; k <= 200; ++k) {
        force_of_tilt(&s, 1e-5 * k, now);
        assert_true(now[2] < 0.0);
        for (int l = 0; l < 3; ++l) assert_close(now[l], last[l], 0.02 * fabs(now[2]));
        for (int l = 0; l < 3; ++l) last[l] = now[l];
    }
    end_scene(&s);
}

/* ---- refusals ---- */

static void refused(mbsr_contacts *c, mbsr_shape shape, int status, const char *text)
{
    mbsr_error error;
    int id;
    assert_int_equal(mbsr_contacts_add(c, &shape, &id, &error), status);
    assert_int_equal(id, MBSR_NONE);
    if (!strstr(error.text, text)) fail_msg("'%s' lacks '%s'", error.text, text);
}

static void refusals(void **unused)
{
    (void)unused;
    mbsr_contacts *c;
    mbsr_error error;
    mbsr_force_def force;
    assert_int_equal(mbsr_contacts_create(NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    mbsr_shape box = sample_shape(MBSR_SHAPE_BOX, 0), bad = {0};
    box.name = "foot";
    assert_int_equal(mbsr_contacts_add(c, NULL, NULL, &error), MBSR_ERR_NULL);
    refused(c, bad, MBSR_ERR_NO_DEFAULT, "mbsr_default_shape");
    bad = box, bad.size[1] = 0.0;
    refused(c, bad, MBSR_ERR_VALUE, "shape 'foot': size[1] is 0");
    bad = box, bad.size[2] = NAN;
    refused(c, bad, MBSR_ERR_VALUE, "size[2] is nan");
    bad = box, bad.rounding = 0.15;
    refused(c, bad, MBSR_ERR_VALUE, "rounding is 0.15");
    bad = box, bad.law.margin = -1.0;
    refused(c, bad, MBSR_ERR_VALUE, "law.margin is -1");
    bad = box, bad.law.friction = INFINITY;
    refused(c, bad, MBSR_ERR_VALUE, "law.friction is inf");
    bad = box, bad.law.slip = 0.0;
    refused(c, bad, MBSR_ERR_VALUE, "law.slip is 0");
    bad = box, bad.law.stiffness = 0.0;
    refused(c, bad, MBSR_ERR_VALUE, "law.stiffness is 0");
    bad = box, bad.frame.R[0] = -1.0;
    refused(c, bad, MBSR_ERR_VALUE, "right-handed");
    bad = box, bad.body = -3;
    refused(c, bad, MBSR_ERR_ID, "body is -3");
    bad = box, bad.kind = MBSR_SHAPE_PLANE;
    refused(c, bad, MBSR_ERR_VALUE, "planes are on the ground");
    bad = box, bad.kind = (mbsr_shape_kind)99;
    refused(c, bad, MBSR_ERR_VALUE, "kind is 99");
    mbsr_shape mesh = sample_shape(MBSR_SHAPE_MESH, 1);
    bad = mesh, bad.triangles = 7;
    refused(c, bad, MBSR_ERR_VALUE, "open");
    double flat[18];
    memcpy(flat, octahedron, sizeof flat);
    flat[14] = flat[17] = 0.0;
    bad = mesh, bad.vertex = flat;
    refused(c, bad, MBSR_ERR_VALUE, "flat or not convex");
    flat[14] = -0.2, flat[17] = -0.25;
    refused(c, bad, MBSR_ERR_VALUE, "convex");
    bad = mesh, bad.vertex = NULL;
    refused(c, bad, MBSR_ERR_NULL, "NULL");
    bad = mesh, bad.triangles = 3;
    refused(c, bad, MBSR_ERR_VALUE, "between 4 and 65536, not 3");
    bad = mesh, bad.vertices = 2;
    refused(c, bad, MBSR_ERR_VALUE, "between 4 and 65536, not 2");
    flat[14] = NAN;
    bad = mesh, bad.vertex = flat;
    refused(c, bad, MBSR_ERR_VALUE, "vertex has the number nan");
    bad = mesh, bad.vertices = 5; /* the triangles name a sixth */
    refused(c, bad, MBSR_ERR_VALUE, "triangle has the vertex 5");
    const double nowhere[18] = {0.0};
    bad = mesh, bad.vertex = nowhere;
    refused(c, bad, MBSR_ERR_VALUE, "the mesh has the size 0");
    bad = box, bad.rounding = -0.01;
    refused(c, bad, MBSR_ERR_VALUE, "rounding is -0.01");
    assert_int_equal(mbsr_contacts_add(c, &box, NULL, &error), MBSR_OK);
    mbsr_shape other = sample_shape(MBSR_SHAPE_CYLINDER, 1);
    assert_int_equal(mbsr_contacts_add(c, &other, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_exclude(c, 0, -2, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_contacts_pair(c, 0, 2, &box.law, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_contacts_join(c, 2, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_join(c, -1, (const int[2]){0, 1}, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_contacts_definition(c, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_definition(NULL, &(mbsr_contacts_def){0}), MBSR_ERR_NULL);
    mbsr_contact_law law = box.law;
    law.friction = -1.0;
    assert_int_equal(mbsr_contacts_pair(c, 0, 1, &law, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "law.friction is -1"));
    law = box.law, law.stiffness = INFINITY;
    assert_int_equal(mbsr_contacts_pair(c, 0, 1, &law, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "law.stiffness is inf"));
    assert_int_equal(mbsr_contacts_force(NULL, 0, &force, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_force(c, 0, NULL, &error), MBSR_ERR_NULL);
    assert_non_null(strstr(error.text, "force is NULL"));
    assert_int_equal(mbsr_contacts_exclude(c, 1, 0, &error), MBSR_OK);
    mbsr_shape soft = sample_shape(MBSR_SHAPE_SPHERE, 2);
    soft.law.stiffness = INFINITY;
    assert_int_equal(mbsr_contacts_add(c, &soft, NULL, &error), MBSR_OK);
    soft.body = 3;
    assert_int_equal(mbsr_contacts_add(c, &soft, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_force(c, 0, &force, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "shape 2 and shape 3"));
    assert_int_equal(mbsr_contacts_pair(c, 3, 2, &box.law, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_force(c, -1, &force, &error), MBSR_ERR_VALUE);
    mbsr_contacts *twice;
    assert_int_equal(mbsr_contacts_create(&twice, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(twice, &soft, NULL, &error), MBSR_OK);
    soft.body = 2;
    assert_int_equal(mbsr_contacts_add(twice, &soft, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_pair(twice, 0, 1, NULL, &error), MBSR_OK); /* never */
    assert_int_equal(mbsr_contacts_pair(twice, 1, 0, &box.law, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_force(twice, 0, &force, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "shape 0 and shape 1 have a law twice"));
    mbsr_contacts_destroy(twice);
    assert_int_equal(mbsr_contacts_force(c, 0, &force, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(c, &soft, NULL, &error), MBSR_ERR_FINISHED);
    assert_int_equal(mbsr_contacts_join(c, 0, NULL, &error), MBSR_ERR_FINISHED);
    mbsr_contacts_destroy(c);
    mbsr_contacts_destroy(NULL);
}

/* More pairs than there is memory for end the evaluation, and the text names the shapes. */
static void too_many(void **unused)
{
    (void)unused;
    mbsr_error error;
    mbsr_force_def force;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_contacts *c;
    const mbsr_model_def def = mbsr_default_model_def();
    assert_int_equal(mbsr_model_create(&def, &m, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        mbsr_shape shape = sample_shape(MBSR_SHAPE_SPHERE, k);
        body.joint = mbsr_joint_translational(NULL, NULL);
        body.inertia = mbsr_inertia_particle(1.0);
        assert_int_equal(mbsr_model_add_body(m, &body, NULL), MBSR_OK);
        assert_int_equal(mbsr_contacts_add(c, &shape, NULL, &error), MBSR_OK);
    }
    assert_int_equal(mbsr_contacts_force(c, 1, &force, &error), MBSR_OK);
    assert_int_equal(mbsr_model_add_force(m, &force, NULL), MBSR_OK);
    assert_int_equal(mbsr_model_finish(m), MBSR_OK);
    assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
    double q[9] = {0, 0, 0, 0.3, 0, 0, 5, 0, 0}, u[9] = {0}, a[9];
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, a), MBSR_OK);
    assert_close(a[0] + a[3], 0.0, 1e-12);
    assert_true(a[3] > 1.0 && fabs(a[6]) == 0.0);
    q[6] = 0.1, q[7] = 0.2;
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, a), MBSR_ERR_MEMORY_SIZE);
    assert_non_null(strstr(mbsr_data_error(d)->text, "more than 1 pairs"));
    assert_non_null(strstr(mbsr_data_error(d)->text, "shape "));
    assert_non_null(strstr(mbsr_data_error(d)->text, "among them"));
    q[6] = 5;
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, a), MBSR_OK);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(c);
}

/* Where no two shapes may touch, the element is there and does nothing, in Newton systems too. */
static void none_may_touch(void **unused)
{
    (void)unused;
    mbsr_shape shapes[3];
    for (int k = 0; k < 3; ++k) {
        shapes[k] = sample_shape(MBSR_SHAPE_SPHERE, 0);
        shapes[k].groups = 1, shapes[k].mask = 2;
    }
    scene s = scene_of(3, shapes);
    const double q[21] = {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0.1, 0, 0, 1, 0, 0, 0, 0, 0.1, 0};
    const double u[18] = {0};
    double y[64], yp[64] = {0}, F[64], delta[64];
    mbsr_newton *newton;
    mbsr_error error;
    assert_true(mbsr_dae_size(s.model, MBSR_DAE_MOMENTUM) <= 64);
    assert_int_equal(points_at(&s, q, u, 0, NULL), 0);
    assert_int_equal(mbsr_newton_create(s.model, MBSR_DAE_MOMENTUM, NULL, &newton, &error),
                     MBSR_OK);
    assert_int_equal(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, q, u, y), MBSR_OK);
    assert_int_equal(mbsr_dae_residual(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), MBSR_OK);
    assert_int_equal(mbsr_newton_factor(newton, s.data, 0.0, y, yp, 100.0), MBSR_OK);
    F[1] = 1.0;
    assert_int_equal(mbsr_newton_solve(newton, F, delta), MBSR_OK);
    for (int k = 0; k < mbsr_dae_size(s.model, MBSR_DAE_MOMENTUM); ++k)
        assert_true(isfinite(delta[k]));
    mbsr_newton_destroy(newton);
    end_scene(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(on_plane),      cmocka_unit_test(on_boxes), cmocka_unit_test(random_pairs),
        cmocka_unit_test(flat_on_flat),  cmocka_unit_test(refusals), cmocka_unit_test(too_many),
        cmocka_unit_test(none_may_touch)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
