/* Mechanisms of everything at once: see medley.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "medley_parts.h"

#include "expect.h"
#include "space.h"

#include <stdlib.h>
#include <string.h>

/* ---- motions, all of which are at zero at this time ---- */

static const double time_here = 0.7;

int medley_follow(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    for (int k = 0; k < 3; ++k) {
        const double w = 1.3 + 0.4 * k, a = 0.2 + 0.1 * k;
        s[k] = a * sin(w * (t - time_here));
        sdot[k] = a * w * cos(w * (t - time_here));
        sddot[k] = -w * w * s[k];
    }
    return 0;
}

int medley_follow_one(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double length = user ? *(const double *)user : 0.0, w = 1.3, a = 0.2;
    s[0] = length + a * sin(w * (t - time_here));
    sdot[0] = a * w * cos(w * (t - time_here));
    sddot[0] = -w * w * a * sin(w * (t - time_here));
    return 0;
}

static int move_in_space(void *user, double t, double *p, double *V, double *A)
{
    const double axis[3] = {0.36, -0.48, 0.8};
    double s[3], sd[3], sdd[3];
    medley_follow(user, t + 0.4, s, sd, sdd);
    const mbsr_frame turned = mbsr_frame_rotated(NULL, axis, s[0]);
    memcpy(p + MBSR_POSE_R, turned.R, sizeof turned.R);
    for (int k = 0; k < 3; ++k) {
        p[MBSR_POSE_X + k] = s[k];
        V[k] = sd[0] * axis[k], V[3 + k] = sd[k];
        A[k] = sdd[0] * axis[k], A[3 + k] = sdd[k];
    }
    return 0;
}

static int move_in_plane(void *user, double t, double *p, double *V, double *A)
{
    return medley_follow(user, t + 0.4, p, V, A);
}

/* ---- bodies ---- */

static mbsr_joint random_joint(const medley_choice *c, mbsr_space space, test_rng *rng)
{
    double x[3], y[3];
    test_fill(rng, 3, x);
    test_fill(rng, 3, y);
    const mbsr_planar_frame A = {x[0], x[1], y[0]}, B = {y[1], y[2], x[2]};
    const double z[3] = {0.0, 0.0, 1.0}, flat[3] = {x[2], y[2], 0.0};
    const mbsr_frame on = mbsr_frame_at(x[0], x[1], 0.0), end = mbsr_frame_at(y[0], y[1], 0.0);
    const int kind = test_integer(rng, c->local, 9 - c->local); /* no welds in large trees */
    if (space == MBSR_SPACE_POINT)
        return kind < 5   ? mbsr_joint_point(A, MBSR_X | MBSR_Y, 0, NULL, NULL)
               : kind < 9 ? mbsr_joint_point(A, MBSR_X, 0, NULL, NULL)
                          : mbsr_joint_point(A, MBSR_Y, MBSR_X, medley_follow_one, NULL);
    if (space == MBSR_SPACE_PLANAR) {
        switch (kind) {
        case 0: return mbsr_joint_planar_weld(A, B);
        case 1:
        case 2: return mbsr_joint_planar_prismatic(A, B);
        case 3: return mbsr_joint_planar_pin_slot(A, B);
        case 4: return mbsr_joint_planar_free(A, B);
        case 5: return mbsr_joint_planar(A, B, MBSR_X, MBSR_ANGLE, medley_follow_one, NULL);
        default: return mbsr_joint_planar_revolute(A, B);
        }
    }
    if (c->family == MEDLEY_FLAT)
        return kind < 6   ? mbsr_joint_revolute(&on, &end, z)
               : kind < 8 ? mbsr_joint_prismatic(&on, &end, flat)
               : kind < 9 ? mbsr_joint_in_plane(&on, &end)
                          : mbsr_joint_weld(&on, &end);
    if (medley_share(rng) < 0.4) return test_joint_in_space(rng, TEST_REVOLUTE, 1.0);
    return test_joint_in_space(rng, test_integer(rng, c->local ? 1 : 0, TEST_KINDS - 1), 1.0);
}

static mbsr_inertia random_inertia(const medley_choice *c, mbsr_space space, test_rng *rng)
{
    const double kind = medley_share(rng), mass = 1.0 + 0.5 * test_uniform(rng),
                 edges[3] = {0.3, 0.5, 0.7};
    double a[3], b[3];
    const mbsr_frame frame = test_frame(rng, 0.4);
    test_fill(rng, 3, a);
    test_fill(rng, 3, b);
    if (kind < c->massless) return mbsr_inertia_zero();
    if (space == MBSR_SPACE_POINT) return mbsr_inertia_particle(mass);
    if (space == MBSR_SPACE_PLANAR)
        return kind < 1.3 * c->massless ? mbsr_inertia_particle(mass)
                                        : mbsr_inertia_planar(mass, a, 0.4 * mass);
    if (kind < 1.15 * c->massless) return mbsr_inertia_point_mass(mass, a);
    if (kind < 1.3 * c->massless) return mbsr_inertia_rod(mass, a, b);
    return mbsr_inertia_in_frame(&frame, mbsr_inertia_box(9.0, edges));
}

static const mbsr_joint_table *stock_in_space, *stock_in_plane;

static int position_in_space(const mbsr_joint_args *args, double *p)
{
    return stock_in_space->position(args, p);
}

static int position_in_plane(const mbsr_joint_args *args, double *p)
{
    return stock_in_plane->position(args, p);
}

/* The same joint as a user's, half of them without derivatives. */
static void make_own(mbsr_joint_table *table, mbsr_joint *joint, bool plane, bool stripped)
{
    *table = *joint->table;
    *(plane ? &stock_in_plane : &stock_in_space) = joint->table;
    table->position = plane ? position_in_plane : position_in_space;
    if (stripped) table->tangent = NULL, table->rate_tangent = NULL;
    joint->table = table;
}

/* A locked coordinate, an added mass, or armature. */
static void amend(mbsr_model *m, int id, const mbsr_joint *joint, int d, test_rng *rng)
{
    double M[36] = {0.0}, x[6];
    const double kind = medley_share(rng);
    if (joint->n > 1 && joint->nq == joint->n && kind < 0.4) {
        assert_ok(mbsr_model_lock(m, id, test_integer(rng, 0, joint->n - 1), test_uniform(rng)),
                  mbsr_model_error(m));
    } else if (joint->n > 0 && kind < 0.7) {
        for (int k = 0; k < 6; ++k) x[k] = 0.3;
        assert_ok(mbsr_model_armature(m, id, joint->n, x), mbsr_model_error(m));
    } else {
        test_fill(rng, 6, x);
        for (int k = 0; k < d * d; ++k) M[k] = 0.5 * x[k / d] * x[k % d];
        assert_ok(mbsr_model_regularise(m, id, d, M), mbsr_model_error(m));
    }
}

/* The space of body k, whose predecessor's it has to fit. */
static mbsr_space choose_space(const medley *s, int parent, test_rng *rng)
{
    const double kind = medley_share(rng);
    const mbsr_space before = parent >= 0 ? s->body[parent].space : MBSR_SPACE_FIXED;
    if (s->c.family == MEDLEY_PLANE) return MBSR_SPACE_PLANAR;
    if (s->c.family != MEDLEY_MIXED) return MBSR_SPACE_SPATIAL;
    if (before == MBSR_SPACE_SPATIAL) return MBSR_SPACE_SPATIAL;
    if (before == MBSR_SPACE_POINT) return MBSR_SPACE_POINT;
    if (kind < 0.3) return MBSR_SPACE_POINT;
    return before == MBSR_SPACE_FIXED && kind < 0.6 && !s->c.moving ? MBSR_SPACE_SPATIAL
                                                                    : MBSR_SPACE_PLANAR;
}

static void add_body(medley *s, int k, test_rng *rng)
{
    const medley_choice *c = &s->c;
    medley_body *b = s->body + k;
    mbsr_body_def body = mbsr_default_body_def();
    b->parent = medley_share(rng) < 0.6 && !c->local
                    ? k - 1
                    : test_integer(rng, k > 6 && !c->local ? k - 7 : -1, k - 1);
    b->cut = MBSR_NONE;
    b->space = choose_space(s, b->parent, rng);
    body.parent = b->parent < 0 ? MBSR_GROUND : b->parent;
    body.joint = random_joint(c, b->space, rng);
    body.inertia = random_inertia(c, b->space, rng);
    const bool own = medley_share(rng) < c->own, table = medley_share(rng) < 0.5,
               stripped = medley_share(rng) < 0.5;
    const bool cut = k > 1 && medley_share(rng) < 0.15 && !c->local;
    const mbsr_joint joint = body.joint;
    if (own && table && b->space != MBSR_SPACE_POINT)
        make_own(&b->table, &body.joint, b->space == MBSR_SPACE_PLANAR, stripped);
    if (cut) { /* of a loop joint */
        b->cut = test_integer(rng, c->local && k > 6 ? k - 6 : -1, k - 1);
        body.inertia = mbsr_inertia_zero();
    }
    assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    if (own && !table && !cut && b->space != MBSR_SPACE_POINT)
        amend(s->m, k, &joint, b->space == MBSR_SPACE_PLANAR ? 3 : 6, rng);
    const mbsr_force_def law = test_joint_law(k, 1.0 + medley_share(rng), 0.4 + medley_share(rng));
    if (medley_share(rng) < (c->local ? 1.0 : 0.7))
        assert_ok(mbsr_model_add_force(s->m, &law, NULL), mbsr_model_error(s->m));
}

static void begin(medley *s, const medley_choice *c, test_rng *rng)
{
    mbsr_model_def def = mbsr_default_model_def();
    const bool flat = c->family == MEDLEY_PLANE || c->family == MEDLEY_MIXED;
    if (c->moving)
        def.root = flat ? mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, move_in_plane, NULL)
                        : mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, 12, move_in_space, NULL);
    assert_ok(mbsr_model_create(&def, &s->m, NULL), NULL);
    const mbsr_force_def gravity = mbsr_force_gravity(0.7, -3.0, 0.0);
    assert_ok(mbsr_model_add_force(s->m, &gravity, NULL), mbsr_model_error(s->m));
    for (int k = 0; k < c->bodies; ++k) add_body(s, k, rng);
}

static bool finish(medley *s)
{
    const int status = mbsr_model_finish(s->m);
    if (status) {
        return false;
    }
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
    s->nq = mbsr_model_nq(s->m);
    s->nu = mbsr_model_nu(s->m);
    s->rows = mbsr_model_rows(s->m);
    s->position_rows = mbsr_model_position_rows(s->m);
    s->size = mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM);
    return true;
}

/* ---- where the bodies are ---- */

static void find_places(medley *s, test_rng *rng)
{
    double pose[MBSR_POSE_SIZE];
    assert_true(finish(s));
    s->q = calloc((size_t)(s->nq + s->nu) + 1, sizeof *s->q);
    s->u = s->q + s->nq;
    test_fill(rng, s->nq, s->q);
    test_fill(rng, s->nu, s->u);
    assert_ok(mbsr_stage_positions(s->m, s->d, s->t, s->q), mbsr_data_error(s->d));
    assert_ok(mbsr_normalise(s->m, s->d, s->q), mbsr_data_error(s->d));
    for (int k = 0; k < s->bodies; ++k) {
        medley_body *b = s->body + k;
        int nq;
        assert_ok(mbsr_body_pose(s->m, s->d, k, pose), NULL);
        assert_ok(mbsr_body_coordinates(s->m, k, &b->u, &nq, NULL, &b->n), NULL); /* place in q */
        b->plain = nq == b->n;
        b->at = mbsr_frame_at(pose[0], pose[1], 0.0);
        if (b->space == MBSR_SPACE_PLANAR)
            b->at = mbsr_frame_rotated(b->at.x, (double[3]){0.0, 0.0, 1.0}, pose[2]);
        if (b->space != MBSR_SPACE_SPATIAL) continue;
        memcpy(b->at.R, pose + MBSR_POSE_R, 9 * sizeof *pose);
        memcpy(b->at.x, pose + MBSR_POSE_X, 3 * sizeof *pose);
    }
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
    s->d = NULL;
}

static mbsr_frame root_frame(const medley *s)
{
    double p[MBSR_POSE_SIZE] = {0.0}, V[6], A[6];
    mbsr_frame frame = mbsr_frame_identity();
    if (!s->c.moving) return frame;
    if (s->c.family == MEDLEY_PLANE || s->c.family == MEDLEY_MIXED) {
        move_in_plane(NULL, s->t, p, V, A);
        return mbsr_frame_rotated((double[3]){p[0], p[1], 0.0}, (double[3]){0.0, 0.0, 1.0}, p[2]);
    }
    move_in_space(NULL, s->t, p, V, A);
    memcpy(frame.R, p + MBSR_POSE_R, sizeof frame.R);
    memcpy(frame.x, p + MBSR_POSE_X, sizeof frame.x);
    return frame;
}

mbsr_frame medley_frame(const medley *s, int body)
{
    return body < 0 ? root_frame(s) : s->body[body].at;
}

/* A frame of the world in the axes of a body. */
mbsr_frame medley_seen_from(const medley *s, int body, const mbsr_frame *world)
{
    const mbsr_frame frame = medley_frame(s, body), inverse = mbsr_frame_inverse(&frame);
    return mbsr_frame_product(&inverse, world);
}

/* ---- all of it ---- */

medley_choice medley_choose(uint64_t seed)
{
    static const double some[4] = {0.0, 0.0, 0.15, 0.4}, few[3] = {0.0, 0.1, 0.4};
    test_rng rng = test_seed(seed + 555);
    medley_choice c = {.seed = seed};
    c.family = (medley_family)test_integer(&rng, 0, MEDLEY_FAMILIES - 1);
    const double kind = medley_share(&rng);
    c.bodies = kind < 0.25   ? test_integer(&rng, 1, 3)
               : kind < 0.85 ? test_integer(&rng, 3, 10)
                             : test_integer(&rng, 10, 50);
    c.closures = test_integer(&rng, 1, 1 + (c.bodies < 8 ? 2 : c.bodies / 4));
    c.springs = medley_share(&rng) < 0.4 ? test_integer(&rng, 1, 1 + c.bodies / 3) : 0;
    c.own = some[test_integer(&rng, 0, 3)];
    c.massless = some[test_integer(&rng, 0, 3)];
    c.stiff = few[test_integer(&rng, 0, 2)];
    c.twice = few[test_integer(&rng, 0, 2)];
    c.moving = medley_share(&rng) < 0.25;
    return c;
}

bool medley_make(medley *s, const medley_choice *c)
{
    *s = (medley){.c = *c, .bodies = c->bodies, .t = time_here};
    s->body = calloc((size_t)c->bodies, sizeof *s->body);
    test_rng rng = test_seed(c->seed), again = rng, others = test_seed(c->seed + 104729);
    begin(s, c, &rng);
    find_places(s, &others);
    begin(s, c, &again);
    medley_add_cuts(s);
    medley_add_closures(s, &others);
    medley_add_springs(s, &others);
    return finish(s);
}

void medley_free(medley *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
    free(s->q);
    free(s->body);
}
