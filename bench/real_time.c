/* Models of real time: see real_time.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "real_time.h"

#include "bench.h"

#include <math.h>
#include <stdlib.h>

static mbsr_model *new_model(void)
{
    mbsr_model *m;
    mbsr_error error;
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    bench_check(mbsr_model_create(NULL, &m, &error), "mbsr_model_create", error.text);
    bench_check(mbsr_model_add_force(m, &gravity, NULL), "gravity", mbsr_model_error(m)->text);
    return m;
}

static int add(mbsr_model *m, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    bench_check(mbsr_model_add_body(m, &body, &id), name, mbsr_model_error(m)->text);
    return id;
}

static void load(mbsr_model *m, mbsr_force_def force)
{
    bench_check(mbsr_model_add_force(m, &force, NULL), "a force", mbsr_model_error(m)->text);
}

/* A box of that mass (kg) and edges (m). */
static mbsr_inertia box(double mass, double x, double y, double z)
{
    const double edges[3] = {x, y, z};
    return mbsr_inertia_box(mass / (x * y * z), edges);
}

/* At rest where all coordinates are zero; quaternions 1. */
static real_time_scene open_scene(mbsr_model *m, int trunk)
{
    bench_check(mbsr_model_finish(m), "mbsr_model_finish", mbsr_model_error(m)->text);
    real_time_scene s = {
        .model = m, .nq = mbsr_model_nq(m), .nu = mbsr_model_nu(m), .trunk = trunk};
    s.q = bench_allocate((size_t)(s.nq + s.nu), sizeof *s.q);
    s.u = s.q + s.nq;
    for (int k = 0; k < mbsr_model_bodies(m); ++k) {
        int q, nq, nu;
        mbsr_body_coordinates(m, k, &q, &nq, NULL, &nu);
        if (nq > nu) s.q[q] = 1.0;
    }
    return s;
}

void real_time_free(real_time_scene *scene)
{
    mbsr_model_destroy(scene->model);
    free(scene->q);
    free(scene->steer);
    *scene = (real_time_scene){0};
}

/* ---- a ragdoll ---- */

static void add_contact(mbsr_model *m, int body, const double centre[3], double radius)
{
    const mbsr_contact contact = {.centre = {centre[0], centre[1], centre[2]},
                                  .radius = radius,
                                  .normal = {0.0, 0.0, 1.0},
                                  .stiffness = 2e4,
                                  .exponent = 1.5,
                                  .damping = 0.5,
                                  .friction = 0.8,
                                  .slip = 0.02};
    load(m, mbsr_force_contact(body, MBSR_GROUND, &contact));
}

/* A rod from the joint at `from` of its predecessor, `along` long, with a sphere at its end.
 * bends: 0 a ball joint with a weak spring, else a hinge that bends that way, from 0 to 2.4 rad. */
typedef struct limb {
    const char *name;
    double from[3], along[3], mass, radius;
    int bends;
} limb;

static int add_limb(mbsr_model *m, int parent, double side, const limb *l)
{
    static const double zero[3] = {0.0}, y[3] = {0.0, 1.0, 0.0};
    static const double spring[3] = {8.0, 8.0, 8.0}, damper[3] = {1.0, 1.0, 1.0};
    const double along[3] = {l->along[0], side * l->along[1], l->along[2]};
    const double end =
        1.0 - l->radius / sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    const double centre[3] = {end * along[0], end * along[1], end * along[2]};
    const double moment = 0.04 * l->mass * l->radius * l->radius;
    const double tensor[6] = {moment, moment, moment, 0.0, 0.0, 0.0};
    const mbsr_inertia inertia = mbsr_inertia_sum(mbsr_inertia_rod(0.9 * l->mass, zero, along),
                                                  mbsr_inertia_rigid(0.1 * l->mass, zero, tensor));
    const mbsr_frame at = mbsr_frame_at(l->from[0], side * l->from[1], l->from[2]);
    const int id = add(
        m, l->name, parent,
        l->bends ? mbsr_joint_revolute(&at, NULL, y) : mbsr_joint_spherical(&at, NULL), inertia);
    if (l->bends) {
        const double lower = l->bends > 0 ? 0.0 : -2.4;
        load(m, mbsr_force_joint_stop(id, 0, lower, lower + 2.4, 300.0, 3.0));
        load(m, mbsr_force_joint_spring(id, 0, 0.0, 0.5, 0.0));
    } else {
        load(m, mbsr_force_joint_rotation_spring(id, spring, damper, NULL));
    }
    add_contact(m, id, centre, l->radius);
    return id;
}

real_time_scene real_time_ragdoll(void)
{
    static const limb spine[3] = {{"lumbar", {0, 0, 0.08}, {0, 0, 0.15}, 8.0, 0.1, 0},
                                  {"thorax", {0, 0, 0.15}, {0, 0, 0.15}, 8.0, 0.1, 0},
                                  {"chest", {0, 0, 0.15}, {0, 0, 0.15}, 8.0, 0.1, 0}};
    static const limb neck = {"neck", {0, 0, 0.15}, {0, 0, 0.08}, 1.0, 0.05, 0};
    static const limb head = {"head", {0, 0, 0.08}, {0, 0, 0.2}, 4.0, 0.1, 0};
    static const limb arm[4] = {{"clavicle", {0, 0.05, 0.13}, {0, 0.13, 0}, 0.5, 0.04, 0},
                                {"upper arm", {0, 0.13, 0}, {0, 0.05, -0.28}, 2.0, 0.05, 0},
                                {"forearm", {0, 0.05, -0.28}, {0, 0, -0.25}, 1.2, 0.04, -1},
                                {"hand", {0, 0, -0.25}, {0, 0, -0.15}, 0.4, 0.04, 0}};
    static const limb leg[3] = {{"thigh", {0, 0.1, -0.05}, {0, 0, -0.42}, 8.0, 0.07, 0},
                                {"shin", {0, 0, -0.42}, {0, 0, -0.42}, 4.0, 0.05, 1},
                                {"foot", {0, 0, -0.42}, {0.2, 0, -0.05}, 1.0, 0.04, 0}};
    static const double middle[3] = {0.0};
    mbsr_model *m = new_model();
    const int pelvis =
        add(m, "pelvis", MBSR_GROUND, mbsr_joint_free(NULL, NULL), box(9.0, 0.2, 0.3, 0.15));
    add_contact(m, pelvis, middle, 0.1);
    int chest = pelvis;
    for (int k = 0; k < 3; ++k) chest = add_limb(m, chest, 1.0, spine + k);
    add_limb(m, add_limb(m, chest, 1.0, &neck), 1.0, &head);
    for (int left = 0; left < 2; ++left) {
        const double side = left ? 1.0 : -1.0;
        for (int k = 0, on = chest; k < 4; ++k) on = add_limb(m, on, side, arm + k);
        for (int k = 0, on = pelvis; k < 3; ++k) on = add_limb(m, on, side, leg + k);
    }
    real_time_scene s = open_scene(m, pelvis);
    s.q[6] = 1.6;
    s.u[0] = 1.0, s.u[1] = 3.0, s.u[3] = 2.0;
    return s;
}

/* ---- vehicles ---- */

static const double axle = 1.3, track = 0.75, wheel_radius = 0.3, speed = 10.0; /* m, m/s */

static void add_tyre(mbsr_model *m, int wheel)
{
    const mbsr_contact tyre = {.radius = wheel_radius,
                               .normal = {0.0, 0.0, 1.0},
                               .stiffness = 2e5,
                               .exponent = 1.0,
                               .damping = 0.02,
                               .friction = 1.0,
                               .slip = 0.05,
                               .creep = 0.08};
    load(m, mbsr_force_contact(wheel, MBSR_GROUND, &tyre));
}

/* Chassis, 0.5 m above the road where coordinates are zero. */
static int add_chassis(mbsr_model *m)
{
    const mbsr_frame at = mbsr_frame_at(0.0, 0.0, 0.5);
    return add(m, "chassis", MBSR_GROUND, mbsr_joint_free(&at, NULL), box(1200.0, 3.6, 1.5, 0.6));
}

/* At `speed`; wheels, which turn about their last coordinate, roll. */
static void roll(real_time_scene *s)
{
    s->u[3] = speed;
    for (int k = 0; k < mbsr_model_bodies(s->model); ++k) {
        int u;
        mbsr_body_coordinates(s->model, k, NULL, NULL, &u, NULL);
        if (mbsr_body_name(s->model, k)[0] == 'w') s->u[u] = speed / wheel_radius;
    }
}

/* Springs with dampers along or about the first `count` coordinates of a joint: its bushings. */
static void add_bushings(mbsr_model *m, int body, int count, const double *stiffness,
                         const double *damping)
{
    for (int k = 0; k < count; ++k)
        load(m, mbsr_force_joint_spring(body, k, stiffness[k], damping[k], 0.0));
}

/* A corner: arm, upright and wheel. */
static void add_corner(mbsr_model *m, int chassis, double x, double side, double *steer)
{
    static const double x_axis[3] = {1.0, 0.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};
    static const double mount[2] = {2e6, 4e6}, mount_damping[2] = {2e3, 4e3};
    static const double kingpin[2] = {5e4, 5e4}, kingpin_damping[2] = {50.0, 50.0};
    const double length = 0.4, rate = 22e3, turn = rate * length * length,
                 weight = 9.81 * 1200.0 / 4.0;
    const mbsr_frame inside = mbsr_frame_at(x, (track - length) * side, -0.2);
    const mbsr_frame outside = mbsr_frame_at(0.0, length * side, 0.0);
    const mbsr_axis axes[3] = {{.kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}},
                               {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 1.0, 0.0}},
                               {.kind = MBSR_AXIS_ROTATION, .direction = {1.0, 0.0, 0.0}}};
    const mbsr_axis bearing[2] = {{.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 1.0, 0.0}},
                                  {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 1.0, 0.0}}};
    const int arm = add(m, "arm", chassis, mbsr_joint_compound(&inside, NULL, 3, axes, NULL, NULL),
                        mbsr_inertia_zero());
    add_bushings(m, arm, 2, mount, mount_damping);
    /* the strut, as it turns the arm; it carries the chassis at zero */
    load(m, mbsr_force_joint_spring(arm, 2, turn, 0.08 * turn, -side * weight / (rate * length)));
    const int upright = add(m, "upright", arm, mbsr_joint_universal(&outside, NULL, z_axis, x_axis),
                            box(15.0, 0.1, 0.1, 0.3));
    add_bushings(m, upright, 2, kingpin, kingpin_damping);
    const int wheel =
        add(m, "wheel", upright, mbsr_joint_compound(NULL, NULL, 2, bearing, NULL, NULL),
            box(20.0, 0.4, 0.2, 0.4));
    load(m, mbsr_force_joint_spring(wheel, 1, 1e7, 5e3, 0.0));
    add_tyre(m, wheel);
    if (x > 0.0) load(m, mbsr_force_joint_applied(upright, mbsr_stored_force, steer));
}

real_time_scene real_time_vehicle(void)
{
    double *steer = bench_allocate(2, sizeof *steer);
    mbsr_model *m = new_model();
    const int chassis = add_chassis(m);
    for (int k = 0; k < 4; ++k)
        add_corner(m, chassis, k < 2 ? axle : -axle, k % 2 ? -1.0 : 1.0, steer);
    real_time_scene s = open_scene(m, chassis);
    s.steer = steer;
    roll(&s);
    return s;
}

/* Five links of a corner, from the chassis to the upright, both from the middle of the wheel; m. */
static const double inner[5][3] = {{0.15, -0.4, -0.1},
                                   {-0.15, -0.4, -0.1},
                                   {0.12, -0.35, 0.15},
                                   {-0.12, -0.35, 0.15},
                                   {0.2, -0.38, 0.0}};
static const double outer[5][3] = {{0.02, -0.02, -0.12},
                                   {-0.02, -0.02, -0.12},
                                   {0.02, -0.05, 0.15},
                                   {-0.02, -0.05, 0.15},
                                   {0.14, -0.03, 0.0}};

static void add_link(mbsr_model *m, int chassis, int upright, const double middle[3], int k,
                     double side)
{
    static const double x_axis[3] = {1.0, 0.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};
    const double from[3] = {inner[k][0], side * inner[k][1], inner[k][2]};
    const double to[3] = {outer[k][0], side * outer[k][1], outer[k][2]};
    const double along[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    const mbsr_frame at =
        mbsr_frame_at(middle[0] + from[0], middle[1] + from[1], middle[2] + from[2]);
    const int link = add(m, "link", chassis, mbsr_joint_universal(&at, NULL, x_axis, z_axis),
                         mbsr_inertia_zero());
    for (int axis = 0; axis < 2; ++axis)
        load(m, mbsr_force_joint_spring(link, axis, 50.0, 1.0, 0.0));
    const mbsr_closure_def ball = mbsr_closure_ball(link, along, upright, to);
    bench_check(mbsr_model_add_closure(m, &ball, NULL), "a ball", mbsr_model_error(m)->text);
}

real_time_scene real_time_multilink(void)
{
    static const double y_axis[3] = {0.0, 1.0, 0.0};
    const mbsr_spring strut = {.stiffness = 25e3, .damping = 2e3, .free_length = 0.62};
    mbsr_model *m = new_model();
    const int chassis = add_chassis(m);
    for (int k = 0; k < 4; ++k) {
        const double x = k < 2 ? axle : -axle, side = k % 2 ? -1.0 : 1.0;
        const double middle[3] = {x, track * side, -0.2}, top[3] = {x, 0.55 * side, 0.3},
                     foot[3] = {0.0, -0.1 * side, -0.1};
        const mbsr_frame at = mbsr_frame_at(middle[0], middle[1], middle[2]);
        const int upright =
            add(m, "upright", chassis, mbsr_joint_free(&at, NULL), box(15.0, 0.1, 0.1, 0.3));
        add_tyre(m, add(m, "wheel", upright, mbsr_joint_revolute(NULL, NULL, y_axis),
                        box(20.0, 0.4, 0.2, 0.4)));
        load(m, mbsr_force_spring(chassis, top, upright, foot, &strut));
        for (int l = 0; l < 5; ++l) add_link(m, chassis, upright, middle, l, side);
    }
    real_time_scene s = open_scene(m, chassis);
    roll(&s);
    return s;
}
