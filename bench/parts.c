/* What mechanisms are made of.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

#include "bench.h"

mbsr_planar_frame part_along(double x)
{
    return (mbsr_planar_frame){x, 0.0, 0.0};
}

int part_body(mbsr_model *m, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    int id = MBSR_NONE;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    bench_check(mbsr_model_add_body(m, &body, &id), name, mbsr_model_error(m)->text);
    return id;
}

void part_force(mbsr_model *m, mbsr_force_def def)
{
    bench_check(mbsr_model_add_force(m, &def, NULL), "force", mbsr_model_error(m)->text);
}

void part_fall(mbsr_model *m)
{
    part_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
}

mbsr_inertia part_rod(double mass, double length)
{
    const double com[2] = {0.5 * length, 0.0};
    return mbsr_inertia_planar(mass, com, mass * length * length / 12.0);
}

mbsr_inertia part_bar(double mass, double length)
{
    const double com[3] = {0.5 * length, 0.0, 0.0}, across = mass * length * length / 12.0,
                 tensor[6] = {2e-4 * mass, across, across, 0.0, 0.0, 0.0};
    return mbsr_inertia_rigid(mass, com, tensor);
}

void part_close(mbsr_model *m, const mechanism_ties *ties, mbsr_closure_def def, int rows)
{
    for (int k = 0; k < rows; ++k) {
        def.stiffness[k] = ties->stiffness;
        def.damping[k] = ties->damping;
    }
    def.settled = 0;
    bench_check(mbsr_model_add_closure(m, &def, NULL), "closure", mbsr_model_error(m)->text);
}

void part_tie(mbsr_model *m, const mechanism_ties *ties, mbsr_force_def def)
{
    if (ties->stiffness == 0.0) return;
    if (ties->closures) def.as_closure = MBSR_SPRING_LOOSE;
    part_force(m, def);
}

/* A point of a body in the plane for the springs to hold. */
static int mark(mbsr_model *m, int body, mbsr_planar_frame at)
{
    return body == MBSR_GROUND && at.x == 0.0 && at.y == 0.0
               ? MBSR_GROUND
               : part_body(m, "point", body, mbsr_joint_point(at, 0, 0, NULL, NULL),
                           mbsr_inertia_zero());
}

void part_pin(mbsr_model *m, const mechanism_ties *ties, int a, double at_a, int b, double at_b)
{
    const double point_a[3] = {at_a, 0.0, 0.0}, point_b[3] = {at_b, 0.0, 0.0};
    if (ties->closures) {
        part_close(m, ties, mbsr_closure_ball(a, point_a, b, point_b), 2);
        return;
    }
    const int one = mark(m, a, part_along(at_a)), two = mark(m, b, part_along(at_b));
    for (int i = 0; i < 2; ++i)
        part_force(m, mbsr_force_axis_spring(one, two, i, ties->stiffness, ties->damping, 0.0));
}
