/* A ragdoll of 20 bodies and 40 spheres, thrown on the floor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <mbsrank/simulation.h>

enum { MOST_SPHERES = 40 };

typedef struct ragdoll {
    mbsr_simulation s;
    mbsr_contacts *contacts;
    int force, spheres;
    double mass;
} ragdoll;

static void touch_floor(ragdoll *r, int body, const double at[3], double radius)
{
    mbsr_error error;
    mbsr_shape shape = mbsr_default_shape();
    shape.kind = MBSR_SHAPE_SPHERE;
    shape.body = body;
    shape.size[0] = radius;
    shape.groups = 1, shape.mask = 2;
    memcpy(shape.frame.x, at, sizeof shape.frame.x);
    shape.law = (mbsr_contact_law){
        .stiffness = 2e4, .exponent = 1.5, .damping = 0.5, .friction = 0.8, .slip = 0.02};
    if (mbsr_contacts_add(r->contacts, &shape, NULL, &error)) fail_msg("%s", error.text);
    ++r->spheres;
}

/* A rod from a joint at `at` to `to`, with a sphere at its end and one on it; bends: +1 and -1
 * hinges that bend one way, 0 a ball joint. */
static int limb(ragdoll *r, int parent, const double at[3], const double to[3], double mass,
                double radius, int bends)
{
    const double zero[3] = {0, 0, 0}, y[3] = {0, 1, 0}, I = 0.4 * mass * radius * radius,
                 tensor[6] = {I, I, I, 0, 0, 0}, k[3] = {8, 8, 8}, d[3] = {1, 1, 1};
    const mbsr_frame frame = mbsr_frame_at(at[0], at[1], at[2]);
    const mbsr_inertia inertia = mbsr_inertia_sum(mbsr_inertia_rod(0.9 * mass, zero, to),
                                                  mbsr_inertia_rigid(0.1 * mass, zero, tensor));
    const int id = mbsr_simulation_add_body(
        &r->s, "limb", parent,
        bends ? mbsr_joint_revolute(&frame, NULL, y) : mbsr_joint_spherical(&frame, NULL), inertia);
    if (bends) {
        const double low = bends > 0 ? 0.0 : -2.4, high = bends > 0 ? 2.4 : 0.0;
        mbsr_simulation_add_force(&r->s, mbsr_force_joint_stop(id, 0, low, high, 300, 3));
        mbsr_simulation_add_force(&r->s, mbsr_force_joint_spring(id, 0, 0, 0.5, 0));
    } else {
        mbsr_simulation_add_force(&r->s, mbsr_force_joint_rotation_spring(id, k, d, NULL));
    }
    const double length = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]),
                 part = 1.0 - radius / length;
    touch_floor(r, id, (const double[3]){part * to[0], part * to[1], part * to[2]}, radius);
    touch_floor(r, id, (const double[3]){0.3 * to[0], 0.3 * to[1], 0.3 * to[2]}, radius);
    r->mass += mass;
    return id;
}

#define AT(x, y, z) ((const double[3]){x, y, z})

static void build_limbs(ragdoll *r, int pelvis)
{
    int b = pelvis;
    for (int k = 0; k < 3; ++k)
        b = limb(r, b, AT(0, 0, k ? 0.15 : 0.08), AT(0, 0, 0.15), 8, 0.1, 0);
    const int chest = b;
    b = limb(r, chest, AT(0, 0, 0.15), AT(0, 0, 0.08), 1, 0.05, 0);
    limb(r, b, AT(0, 0, 0.08), AT(0, 0, 0.2), 4, 0.1, 0);
    for (int k = 0; k < 2; ++k) {
        const double y = k ? -1 : 1;
        b = limb(r, chest, AT(0, 0.05 * y, 0.13), AT(0, 0.13 * y, 0), 0.5, 0.04, 0);
        b = limb(r, b, AT(0, 0.13 * y, 0), AT(0, 0.05 * y, -0.28), 2, 0.05, 0);
        b = limb(r, b, AT(0, 0.05 * y, -0.28), AT(0, 0, -0.25), 1.2, 0.04, -1);
        limb(r, b, AT(0, 0, -0.25), AT(0, 0, -0.15), 0.4, 0.04, 0);
        b = limb(r, pelvis, AT(0, 0.1 * y, -0.05), AT(0, 0, -0.42), 8, 0.07, 0);
        b = limb(r, b, AT(0, 0, -0.42), AT(0, 0, -0.42), 4, 0.05, 1);
        limb(r, b, AT(0, 0, -0.42), AT(0.2, 0, -0.05), 1, 0.04, 0);
    }
}

static void begin_ragdoll(ragdoll *r)
{
    mbsr_error error;
    mbsr_force_def force;
    *r = (ragdoll){.s = mbsr_simulation_begin(NULL), .mass = 9.0};
    assert_int_equal(mbsr_contacts_create(&r->contacts, &error), MBSR_OK);
    mbsr_simulation_add_force(&r->s, mbsr_force_gravity(0, 0, -9.81));
    mbsr_shape floor_ = mbsr_default_shape();
    floor_.kind = MBSR_SHAPE_PLANE;
    floor_.groups = 2, floor_.mask = 1;
    assert_int_equal(mbsr_contacts_add(r->contacts, &floor_, NULL, &error), MBSR_OK);
    const double edges[3] = {0.2, 0.3, 0.15};
    const int pelvis = mbsr_simulation_add_body(
        &r->s, "pelvis", MBSR_GROUND, mbsr_joint_free(NULL, NULL), mbsr_inertia_box(1000, edges));
    for (int k = 0; k < 2; ++k) touch_floor(r, pelvis, AT(0, k ? -0.06 : 0.06, 0), 0.1);
    build_limbs(r, pelvis);
    if (mbsr_contacts_force(r->contacts, 0, &force, &error)) fail_msg("%s", error.text);
    r->force = mbsr_simulation_add_force(&r->s, force);
}

static void thrown(void **unused)
{
    (void)unused;
    ragdoll r;
    begin_ragdoll(&r);
    double q[128] = {0}, u[128] = {0}, kinetic, potential, most = 0.0, before = INFINITY;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-4;
    assert_int_equal(mbsr_model_finish(r.s.model), MBSR_OK);
    assert_int_equal(mbsr_model_bodies(r.s.model), 20);
    assert_int_equal(r.spheres, MOST_SPHERES);
    for (int k = 0; k < 20; ++k) {
        int at, n;
        assert_int_equal(mbsr_body_coordinates(r.s.model, k, &at, &n, NULL, NULL), MBSR_OK);
        if (n >= 4) q[at] = 1.0;
    }
    q[6] = 1.6, u[3] = 2.0, u[1] = 3.0, u[0] = 1.0;
    if (mbsr_simulation_start(&r.s, &opt, 0, q, u)) fail_msg("%s", r.s.error.text);
    for (int n = 1; n <= 120; ++n) {
        if (mbsr_simulation_to(&r.s, n / 20.0)) fail_msg("t %g: %s", r.s.t, r.s.error.text);
        memcpy(q, mbsr_simulation_q(&r.s), (size_t)mbsr_model_nq(r.s.model) * sizeof *q);
        memcpy(u, mbsr_simulation_u(&r.s), (size_t)mbsr_model_nu(r.s.model) * sizeof *u);
        assert_int_equal(mbsr_stage_positions(r.s.model, r.s.data, 0.0, q), MBSR_OK);
        assert_int_equal(mbsr_stage_velocities(r.s.model, r.s.data, u), MBSR_OK);
        assert_int_equal(mbsr_energy(r.s.model, r.s.data, &kinetic, &potential), MBSR_OK);
        const double energy = kinetic + potential;
        most = fmax(most, fabs(energy));
        assert_true(energy < before + 100.0 * opt.rtol * most);
        before = fmin(before, energy);
    }
    /* it lies on the floor, which carries it */
    mbsr_contact_point point[MOST_SPHERES];
    const int count = points_at(&(scene){.model = r.s.model, .data = r.s.data, .force = r.force}, q,
                                u, MOST_SPHERES, point);
    double carried = 0.0;
    for (int k = 0; k < count; ++k) carried += point[k].normal_force;
    assert_true(count > 10);
    assert_close(carried / (r.mass * 9.81), 1.0, 0.02);
    const double sunk = pow(r.mass * 9.81 / 2e4, 2.0 / 3.0); /* under all of the weight */
    assert_true(q[6] > 0.1 - sunk && q[6] < 0.2 && kinetic < 1e-2);
    /* nothing chatters, and steps grow */
    mbsr_ida_stats thrown_down, resting;
    mbsr_simulation_get_stats(&r.s, &thrown_down);
    if (mbsr_simulation_to(&r.s, 20.0)) fail_msg("t %g: %s", r.s.t, r.s.error.text);
    mbsr_simulation_get_stats(&r.s, &resting);
    print_message("%ld steps, then %ld; %d points\n", thrown_down.steps,
                  resting.steps - thrown_down.steps, count);
    assert_true(resting.steps - thrown_down.steps < 100);
    mbsr_simulation_end(&r.s);
    mbsr_contacts_destroy(r.contacts);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(thrown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
