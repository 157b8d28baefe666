/* ADAMS's runs of one body on each kind of joint, from the joint tests of Project Chrono.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <math.h>
#include <stddef.h>

static const double pi = 3.14159265358979323846, x_axis[3] = {1.0, 0.0, 0.0},
                    y_axis[3] = {0.0, 1.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0},
                    place[3] = {1.0, 2.0, 3.0}, end[3] = {2.0, 0.0, 0.0},
                    long_x[6] = {0.04, 0.1, 0.1}, long_y[6] = {0.1, 0.04, 0.1},
                    long_z[6] = {0.1, 0.1, 0.04};

/* One motion by two kinds of joint ends 1.2e-5 apart in ADAMS's runs at 1 s: what the digits are
 * good for. Runs of other joints and of springs have more digits. */
static const double joint = 2e-5, tumbling = 1e-5;

enum { NUMBERS = 3 };

typedef struct number {
    const char *name; /* NULL: none */
    int axis;         /* of the centre of mass */
    double theirs, allowed;
} number;

typedef struct body {
    mbsr_joint joint;
    const double *com, *tensor; /* com NULL: the origin */
    int parent;                 /* 1: a link without mass, on which it hangs */
    mbsr_joint link;
    double t;
    number number[NUMBERS];
} body;

static void begin(sheet *out, const char *kind)
{
    sheet_problem(out, kind,
                  "Centre of mass, from rest; ADAMS's own runs, six or seven digits, from the "
                  "joint tests of Project Chrono (data/testing/joints).");
}

/* The model of a case; its elements and closures follow. */
static int build(mbsr_simulation *s, const body *b)
{
    static const double origin[3] = {0.0, 0.0, 0.0};
    int parent = MBSR_GROUND;
    *s = mbsr_simulation_begin(NULL);
    if (b->parent)
        parent = mbsr_simulation_add_body(s, "link", MBSR_GROUND, b->link, mbsr_inertia_zero());
    const int id = mbsr_simulation_add_body(
        s, "body", parent, b->joint, mbsr_inertia_rigid(1.0, b->com ? b->com : origin, b->tensor));
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, 0.0, -9.80665));
    return id;
}

/* Runs it and writes its rows. */
static void run(sheet *out, mbsr_simulation *s, int id, const body *b)
{
    double pose[MBSR_POSE_SIZE] = {0.0};
    sheet_start(s, 1e-10, NULL, NULL);
    sheet_run(s, b->t > 0.0 ? b->t : 1.0);
    sheet_check(mbsr_body_pose(s->model, s->data, id, pose), &s->error);
    for (int k = 0; k < NUMBERS && b->number[k].name; ++k) {
        const number *n = b->number + k;
        double x = pose[MBSR_POSE_X + n->axis];
        for (int l = 0; l < 3 && b->com; ++l) x += pose[MBSR_POSE_R + n->axis + 3 * l] * b->com[l];
        sheet_add(out, n->name, n->theirs, x, n->allowed);
    }
    mbsr_simulation_end(s);
}

static void all(sheet *out, const char *kind, int count, const body *b)
{
    begin(out, kind);
    for (int k = 0; k < count; ++k) {
        mbsr_simulation s;
        const int id = build(&s, b + k);
        run(out, &s, id, b + k);
    }
}

static void hinges_and_balls(sheet *out)
{
    const mbsr_frame down = mbsr_frame_rotated(NULL, x_axis, -0.5 * pi),
                     tilted = mbsr_frame_rotated(place, x_axis, -0.25 * pi);
    const body hinge[2] = {{.joint = mbsr_joint_revolute(&down, NULL, z_axis),
                            .com = end,
                            .tensor = long_x,
                            .number = {{"case 1, x at 1 s, m", 0, -0.892381, joint},
                                       {"case 1, z at 1 s, m", 2, -1.78988, joint}}},
                           {.joint = mbsr_joint_revolute(&tilted, NULL, z_axis),
                            .com = end,
                            .tensor = long_x,
                            .t = 5.0,
                            .number = {{"case 2, x at 5 s, m", 0, 1.20996, 1e-5},
                                       {"case 2, y at 5 s, m", 1, 3.40640, 1e-5},
                                       {"case 2, z at 5 s, m", 2, 1.59360, 1e-5}}}};
    const body ball[2] = {{.joint = mbsr_joint_spherical(NULL, NULL),
                           .com = end,
                           .tensor = long_x,
                           .number = {{"case 1, x at 1 s, m", 0, -0.892369, joint},
                                      {"case 1, z at 1 s, m", 2, -1.78988, joint}}},
                          {.joint = mbsr_joint_spherical(&tilted, NULL),
                           .com = end,
                           .tensor = long_x,
                           .number = {{"case 2, x at 1 s, m", 0, 0.107619, joint},
                                      {"case 2, z at 1 s, m", 2, 1.21012, joint}}}};
    all(out, "Revolute joint", 2, hinge);
    all(out, "Spherical joint", 2, ball);
}

static void universal_joints(sheet *out)
{
    static const double about[3] = {1.0, -1.0, 0.0}, below[3] = {0.0, 0.0, -2.0};
    const mbsr_frame x = mbsr_frame_rotated(NULL, x_axis, 0.5 * pi),
                     y = mbsr_frame_rotated(NULL, y_axis, 0.5 * pi),
                     both = mbsr_frame_rotated(NULL, about, 0.5 * pi);
    const body b[3] = {{.joint = mbsr_joint_universal(&x, NULL, x_axis, y_axis),
                        .com = below,
                        .tensor = long_z,
                        .number = {{"case 1, y at 1 s, m", 1, -0.892369, joint},
                                   {"case 1, z at 1 s, m", 2, -1.78988, joint}}},
                       {.joint = mbsr_joint_universal(&y, NULL, x_axis, y_axis),
                        .com = below,
                        .tensor = long_z,
                        .number = {{"case 2, x at 1 s, m", 0, 0.892369, joint},
                                   {"case 2, z at 1 s, m", 2, -1.78988, joint}}},
                       {.joint = mbsr_joint_universal(&both, NULL, x_axis, y_axis),
                        .com = below,
                        .tensor = long_z,
                        .number = {{"case 3, x at 1 s, m", 0, -0.636240, 1e-5},
                                   {"case 3, y at 1 s, m", 1, -0.614073, 1e-5},
                                   {"case 3, z at 1 s, m", 2, -1.79391, 1e-5}}}};
    all(out, "Universal joint", 3, b);
}

static void slides(sheet *out)
{
    const mbsr_frame down = mbsr_frame_rotated(NULL, x_axis, -0.5 * pi),
                     level = mbsr_frame_rotated(place, x_axis, -0.5 * pi),
                     tilted = mbsr_frame_rotated(place, x_axis, -0.25 * pi);
    const body slide[3] = {{.joint = mbsr_joint_prismatic(NULL, NULL, z_axis),
                            .com = end,
                            .tensor = long_x,
                            .number = {{"case 1, z at 1 s, m", 2, -4.90332, 1e-5}}},
                           {.joint = mbsr_joint_prismatic(&tilted, NULL, z_axis),
                            .com = end,
                            .tensor = long_x,
                            .number = {{"case 2, y at 1 s, m", 1, -0.451662, joint},
                                       {"case 2, z at 1 s, m", 2, 0.548338, joint}}},
                           {.joint = mbsr_joint_prismatic(&level, NULL, z_axis),
                            .com = end,
                            .tensor = long_x,
                            .number = {{"case 3, which rests: y at 1 s, m", 1, 2.0, 1e-5},
                                       {"case 3, z at 1 s, m", 2, 3.0, 1e-5}}}};
    const body tube[3] = {{.joint = mbsr_joint_cylindrical(NULL, NULL, z_axis),
                           .com = end,
                           .tensor = long_x,
                           .number = {{"case 1, z at 1 s, m", 2, -4.90332, 1e-5}}},
                          {.joint = mbsr_joint_cylindrical(&down, NULL, z_axis),
                           .com = end,
                           .tensor = long_x,
                           .number = {{"case 2, x at 1 s, m", 0, -0.892381, joint},
                                      {"case 2, z at 1 s, m", 2, -1.78988, joint}}},
                          {.joint = mbsr_joint_cylindrical(&tilted, NULL, z_axis),
                           .com = end,
                           .tensor = long_x,
                           .t = 2.5,
                           .number = {{"case 3, x at 2.5 s, m", 0, -0.846888, 1e-5},
                                      {"case 3, y at 2.5 s, m", 1, -12.7802, 1e-4},
                                      {"case 3, z at 2.5 s, m", 2, -12.8656, 1e-4}}}};
    all(out, "Prismatic joint", 3, slide);
    all(out, "Cylindrical joint", 3, tube);
}

static int speed(void *user, double t, double *s, double *v, double *a)
{
    const double rate = *(const double *)user;
    *s = rate * t;
    *v = rate;
    *a = 0.0;
    return MBSR_OK;
}

/* A slide, and a row that drives it. */
static void actuators(sheet *out)
{
    static const double tensor[6] = {1.0, 1.0, 1.0}, along[2][3] = {{0, 0, 1}, {1, 0, 1}};
    static double rate[2] = {1.0, 0.5};
    const mbsr_frame tilted = mbsr_frame_rotated(NULL, y_axis, 0.25 * pi);
    const body b[2] = {{.joint = mbsr_joint_prismatic(NULL, NULL, z_axis),
                        .tensor = tensor,
                        .number = {{"case 1, z at 1 s, m", 2, 1.0, 1e-5}}},
                       {.joint = mbsr_joint_prismatic(&tilted, NULL, z_axis),
                        .tensor = tensor,
                        .number = {{"case 2, x at 1 s, m", 0, 0.353553, 1e-6},
                                   {"case 2, z at 1 s, m", 2, 0.353553, 1e-6}}}};
    begin(out, "Driven prismatic joint");
    for (int k = 0; k < 2; ++k) {
        mbsr_simulation s;
        const int id = build(&s, b + k);
        mbsr_closure_def drive = mbsr_closure_rows(id, NULL, MBSR_GROUND, NULL, 1, along[k]);
        drive.motion = speed;
        drive.user = rate + k;
        mbsr_simulation_add_closure(&s, drive);
        run(out, &s, id, b + k);
    }
}

/* A link without mass: a hinge at one end, a ball at the other. */
static void links(sheet *out)
{
    static const double off[3] = {0.0, 2.0, 0.0};
    const mbsr_frame tilted = mbsr_frame_rotated(place, x_axis, -0.25 * pi),
                     tip = mbsr_frame_at(2.0, 0.0, 0.0),
                     back = mbsr_frame_rotated(end, x_axis, 0.25 * pi);
    const body b[2] = {{.parent = 1,
                        .link = mbsr_joint_revolute(NULL, NULL, z_axis),
                        .joint = mbsr_joint_spherical(&tip, NULL),
                        .com = off,
                        .tensor = long_y,
                        .number = {{"case 1, x at 1 s, m", 0, 0.775822, tumbling},
                                   {"case 1, y at 1 s, m", 1, 0.805022, tumbling},
                                   {"case 1, z at 1 s, m", 2, -1.08047, tumbling}}},
                       {.parent = 1,
                        .link = mbsr_joint_revolute(&tilted, NULL, z_axis),
                        .joint = mbsr_joint_spherical(&back, NULL),
                        .com = off,
                        .tensor = long_y,
                        .number = {{"case 2, x at 1 s, m", 0, 1.64652, tumbling},
                                   {"case 2, y at 1 s, m", 1, 2.95968, tumbling},
                                   {"case 2, z at 1 s, m", 2, 0.284272, tumbling}}}};
    all(out, "Link between a hinge and a ball, without mass", 2, b);
}

static int stiffening(void *user, double x, double v, double *force, double *energy, double *power)
{
    const double e = x - 2.0, a = fabs(e);
    (void)user;
    *force = 50.0 * e + 10.0 * a * e + 5.0 * v;
    if (energy) *energy = 25.0 * e * e + 10.0 / 3.0 * a * e * e;
    if (power) *power = 5.0 * v * v;
    return MBSR_OK;
}

/* What holds a point of a free body to a place. */
typedef struct hold {
    body body;
    double place[3];
    const double *point;
    double stiffness, damping; /* both zero: see below */
    int rigid;                 /* 1: at its distance of 2 m, 0: by the law of the springs above */
} hold;

static void held(sheet *out, const char *kind, int count, const hold *h)
{
    const mbsr_spring law = {.function = stiffening};
    begin(out, kind);
    for (int k = 0; k < count; ++k) {
        mbsr_simulation s;
        const int id = build(&s, &h[k].body);
        if (h[k].rigid)
            mbsr_simulation_add_closure(
                &s, mbsr_closure_distance(id, h[k].point, MBSR_GROUND, h[k].place, 2.0));
        else if (h[k].stiffness > 0.0)
            mbsr_simulation_add_force(&s, mbsr_force_point_spring(id, h[k].point, MBSR_GROUND,
                                                                  h[k].place, h[k].stiffness,
                                                                  h[k].damping, 2.0));
        else
            mbsr_simulation_add_force(
                &s, mbsr_force_spring(id, h[k].point, MBSR_GROUND, h[k].place, &law));
        run(out, &s, id, &h[k].body);
    }
}

static void distances_and_springs(sheet *out)
{
    static const double hanging[3] = {0.0, 4.0, 0.0};
    const mbsr_frame above = mbsr_frame_at(0.0, 2.0, 0.0), beside = mbsr_frame_at(-1.0, 4.0, 3.0),
                     turned = mbsr_frame_rotated(hanging, z_axis, -0.5 * pi);
    const hold rod[3] = {{.body = {.joint = mbsr_joint_free(&above, NULL),
                                   .tensor = long_x,
                                   .number = {{"case 1, y at 1 s, m", 1, -0.956545, joint},
                                              {"case 1, z at 1 s, m", 2, -1.756423, joint}}},
                          .rigid = 1},
                         {.body = {.joint = mbsr_joint_free(&beside, NULL),
                                   .tensor = long_x,
                                   .t = 5.0,
                                   .number = {{"case 2, x at 5 s, m", 0, 0.3652558, 1e-4},
                                              {"case 2, y at 5 s, m", 1, 2.664910, 1e-4},
                                              {"case 2, z at 5 s, m", 2, -0.7909707, 1e-4}}},
                          .place = {1.0, 2.0, 3.0},
                          .point = end,
                          .rigid = 1},
                         {.body = {.joint = mbsr_joint_free(&turned, NULL),
                                   .tensor = long_x,
                                   .number = {{"case 3, y at 1 s, m", 1, 1.588488, joint},
                                              {"case 3, z at 1 s, m", 2, -3.670108, joint}}},
                          .point = end,
                          .rigid = 1}};
    const hold spring[4] = {
        {.body = {.joint = mbsr_joint_free(&above, NULL),
                  .tensor = long_x,
                  .number = {{"spring, case 2, y at 1 s, m", 1, -0.5973274, joint},
                             {"spring, case 2, z at 1 s, m", 2, -2.189069, joint}}},
         .stiffness = 100.0,
         .damping = 5.0},
        {.body = {.joint = mbsr_joint_free(&beside, NULL),
                  .tensor = long_x,
                  .number = {{"law, case 3, x at 1 s, m", 0, -0.5266615, tumbling},
                             {"law, case 3, y at 1 s, m", 1, 3.486916, tumbling},
                             {"law, case 3, z at 1 s, m", 2, -1.046425, tumbling}}},
         .place = {1.0, 2.0, 3.0},
         .point = end},
        {.body = {.joint = mbsr_joint_free(&turned, NULL),
                  .tensor = long_x,
                  .number = {{"law, case 4, y at 1 s, m", 1, 2.100738, tumbling},
                             {"law, case 4, z at 1 s, m", 2, -3.874815, tumbling}}},
         .point = end}};
    held(out, "Distance constraint", 3, rod);
    held(out, "Springs with dampers", 3, spring);
}

/* A spring of our own on a hinge, whose stiffness grows with the angle. */
static int coil(const mbsr_force_args *args)
{
    const double q = args->body->q[0];
    args->body->tau[0] -= (50.0 + 10.0 * fabs(q)) * q + 10.0 * args->body->u[0];
    return MBSR_OK;
}

static const mbsr_force_table coil_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_JOINT_ONLY,
                                            .name = "coil",
                                            .evaluate = coil};

static void joint_springs(sheet *out)
{
    const mbsr_frame down = mbsr_frame_rotated(NULL, x_axis, -0.5 * pi);
    const body b[3] = {{.joint = mbsr_joint_revolute(&down, NULL, z_axis),
                        .com = end,
                        .tensor = long_x,
                        .number = {{"hinge, case 1, x at 1 s, m", 0, 1.994921, joint},
                                   {"hinge, case 1, z at 1 s, m", 2, -0.1424453, joint}}},
                       {.joint = mbsr_joint_revolute(&down, NULL, z_axis),
                        .com = end,
                        .tensor = long_x,
                        .number = {{"hinge, case 2, x at 1 s, m", 0, 1.804202, joint},
                                   {"hinge, case 2, z at 1 s, m", 2, -0.8630493, joint}}},
                       {.joint = mbsr_joint_prismatic(NULL, NULL, z_axis),
                        .tensor = long_x,
                        .number = {{"slide, case 1, z at 1 s, m", 2, -1.74502, joint}}}};
    begin(out, "Joints with springs and dampers");
    for (int k = 0; k < 3; ++k) {
        mbsr_simulation s;
        const int id = build(&s, b + k);
        mbsr_force_def own = mbsr_default_force_def();
        own.table = &coil_table;
        own.bodies = 1;
        own.body[0] = id;
        mbsr_simulation_add_force(&s, k == 0   ? mbsr_force_joint_spring(id, 0, 200.0, 10.0, 0.0)
                                      : k == 1 ? own
                                               : mbsr_force_joint_spring(id, 0, 10.0, 0.5, 0.0));
        run(out, &s, id, b + k);
    }
}

void sheet_adams(sheet *out)
{
    hinges_and_balls(out);
    universal_joints(out);
    slides(out);
    actuators(out);
    links(out);
    distances_and_springs(out);
    joint_springs(out);
}
