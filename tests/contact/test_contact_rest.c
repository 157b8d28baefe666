/* Where thrown shapes come to rest on a floor, by mbsr_equilibrium.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "shapes.h"
#include "units.h"

#include <mbsrank/linear.h>

#include <math.h>

enum { MOST = 4 };

static double between(uint64_t *random, double least, double most)
{
    return least + 0.5 * (most - least) * (1.0 + draw(random));
}

static mbsr_shape thrown(uint64_t *random, const units *s, int body)
{
    const double radius = between(random, 0.06, 0.1) * s->length;
    mbsr_shape shape = mbsr_default_shape();
    shape.body = body;
    shape.kind = (mbsr_shape_kind)(int)between(random, 0.0, 4.999);
    shape.size[0] = shape.kind == MBSR_SHAPE_CAPSULE ? 0.7 * radius : radius;
    shape.size[1] = 0.8 * radius;
    shape.size[2] = 0.6 * radius;
    return shape;
}

/* Over the floor, free to turn; nothing holds them there. */
static mbsr_model *make(uint64_t seed, const units *s, mbsr_contacts *contacts, double *q)
{
    uint64_t random = seed * 2654435761u;
    const double force = s->mass * s->length / (s->time * s->time), com[3] = {0.0};
    const mbsr_contact_law law = {.stiffness = 2e5 * force / pow(s->length, 1.5),
                                  .exponent = 1.5,
                                  .damping = 0.3 * s->time / s->length,
                                  .friction = 0.4,
                                  .slip = 5e-3 * s->length / s->time,
                                  .spin = 5e-2 / s->time};
    mbsr_shape floor = mbsr_default_shape();
    mbsr_model *m;
    mbsr_force_def element;
    mbsr_error error;
    assert_ok(mbsr_model_create(NULL, &m, &error), &error);
    floor.kind = MBSR_SHAPE_PLANE;
    floor.law = law;
    assert_ok(mbsr_contacts_add(contacts, &floor, NULL, &error), &error);
    const int bodies = (int)between(&random, 1.0, MOST + 0.999);
    for (int b = 0; b < bodies; ++b) {
        mbsr_body_def body = mbsr_default_body_def();
        mbsr_shape shape = thrown(&random, s, b);
        const double mass = between(&random, 0.5, 2.0) * s->mass,
                     moment = 4e-3 * mass * s->length * s->length,
                     tensor[6] = {moment, 1.2 * moment, 0.9 * moment, 0.0, 0.0, 0.0};
        shape.law = law;
        body.joint = mbsr_joint_free(NULL, NULL);
        body.inertia = mbsr_inertia_rigid(mass, com, tensor);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_contacts_add(contacts, &shape, NULL, &error), &error);
        q[7 * b] = 1.0;
        q[7 * b + 1] = 0.3 * draw(&random);
        q[7 * b + 2] = q[7 * b + 3] = 0.0;
        q[7 * b + 4] = 0.05 * draw(&random) * s->length;
        q[7 * b + 5] = 0.05 * draw(&random) * s->length;
        q[7 * b + 6] = (0.15 + 0.25 * b) * s->length;
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0, 0, -9.81 * force / s->mass);
    assert_ok(mbsr_contacts_force(contacts, 0, &element, &error), &error);
    assert_ok(mbsr_model_add_force(m, &element, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Weights are borne, in all units. */
static void thrown_shapes_come_to_rest(void **state)
{
    (void)state;
    const uint64_t seeds = test_long() ? 12 : 3;
    mbsr_equilibrium_opt opt = mbsr_default_equilibrium_opt();
    opt.max_iterations = 5000; /* some roll far */
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
        for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
            const units *s = systems + k;
            double q[7 * MOST], zero[6 * MOST] = {0.0}, out[6 * MOST];
            mbsr_contacts *contacts;
            mbsr_data *d;
            mbsr_error error;
            assert_ok(mbsr_contacts_create(&contacts, &error), &error);
            mbsr_model *m = make(seed, s, contacts, q);
            assert_ok(mbsr_data_create(m, &d, &error), &error);
            assert_ok(mbsr_equilibrium(m, d, 0.0, q, &opt, q, NULL, NULL, &error), &error);
            assert_ok(mbsr_bias_forces(m, d, 0.0, q, zero, out), mbsr_data_error(d));
            const double force = s->mass * s->length / (s->time * s->time);
            for (int j = 0; j < mbsr_model_nu(m); ++j)
                assert_less(fabs(out[j]), 1e-7 * force * (j % 6 < 3 ? s->length : 1.0));
            mbsr_data_destroy(d);
            mbsr_model_destroy(m);
            mbsr_contacts_destroy(contacts);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(thrown_shapes_come_to_rest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
