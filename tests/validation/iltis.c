/* The Bombardier Iltis, benchmark vehicle of the IAVSD: at rest, and its modes on the road.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sheet.h"

#include <mbsrank/linear.h>

#include <math.h>
#include <string.h>

/* x ahead, y across, z up, origin in the centre of mass of the cabin, which stands 0.57 m above the
 * road where the benchmark's data are given. */
enum { LEAF, CARRIER, ARM, HUB, WHEEL, STOP, CORNER_BODIES };
enum { SPRING, SHOCK, ROAD, CORNER_FORCES };

typedef struct corner {
    int side, front; /* sign of y; 1: of the front axle */
    int body[CORNER_BODIES], force[CORNER_FORCES];
    double rate; /* of the wheel, rad/s */
} corner;

typedef struct car {
    mbsr_simulation s;
    int cabin, nq, at_z; /* at_z: the cabin's x and y that are left out, 0 or 2 */
    double speed;        /* m/s ahead; 0: x, y and yaw of the cabin do not move */
    corner at[4];        /* front -y, front +y, rear -y, rear +y */
    double q[64];        /* as the data are given */
} car;

static const double height = 0.57, leaf_axis[2] = {0.1585, 0.03}, arm_axis[2] = {0.259, -0.268},
                    leaf_stiffness = 35906.0, leaf_free = 0.252, wheel_radius = 0.356,
                    tyre_stiffness = 460000.0, absorber_damping = 9945.627,
                    tyre_radius[2] = {0.363812, 0.364325};
/* Aligning moment over slip, moment over camber, trail, lateral force over rate: rear and front. */
static const double slip_law[2][4] = {{40162.0, 6600.0, 0.06142, 2008.1},
                                      {41641.0, 6925.0, 0.06553, 2082.05}};
static const double none[3] = {0.0, 0.0, 0.0}, x_axis[3] = {1.0, 0.0, 0.0},
                    y_axis[3] = {0.0, 1.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};

/* Shock absorber with its rubber: a cubic in the length, N, and damping at small rates, N s/m. */
static int absorber(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user, (void)energy, (void)power;
    *force = -4.0092e6 + x * (2.8397e7 + x * (-6.7061e7 + x * 5.2796e7)) + absorber_damping * v;
    return MBSR_OK;
}

/* The law by which Robotran's modes were computed. */
static int linear_absorber(void *user, double x, double v, double *force, double *energy,
                           double *power)
{
    (void)energy, (void)power;
    *force = *(const double *)user * x + absorber_damping * v;
    return MBSR_OK;
}

/* The wheel stands on its tyre. In motion, with coefficients for small slip and camber: a lateral
 * force and moments in the point of contact, behind which the force acts. */
static int tyre(const mbsr_force_args *args)
{
    const double *param = args->force->param, *R = args->body->p, *v = args->body->V + 3;
    double *f = args->body->f;
    const double load = tyre_stiffness * (param[0] - R[MBSR_POSE_X + 2]);
    f[5] += load;
    if (param[1] == 0.0) return MBSR_OK;
    const double *y = R + 3, size = hypot(y[0], y[1]), ahead[3] = {y[1] / size, -y[0] / size, 0.0},
                 side[2] = {y[0] / size, y[1] / size},
                 down[3] = {y[2] * side[0], y[2] * side[1], -size},
                 lateral = v[0] * side[0] + v[1] * side[1],
                 slip = atan(lateral / (v[0] * ahead[0] + v[1] * ahead[1])),
                 camber = atan(y[2] / size), way = R[MBSR_POSE_X + 2] / size;
    const double force[3] = {-param[4] * lateral * side[0], -param[4] * lateral * side[1], load},
                 r[3] = {way * down[0] - param[3] * ahead[0], way * down[1] - param[3] * ahead[1],
                         way * down[2]};
    f[0] += r[1] * force[2] - r[2] * force[1] + param[2] * camber * ahead[0];
    f[1] += r[2] * force[0] - r[0] * force[2] + param[2] * camber * ahead[1];
    f[2] += r[0] * force[1] - r[1] * force[0] + param[1] * slip;
    f[3] += force[0];
    f[4] += force[1];
    return MBSR_OK;
}

static const mbsr_force_table tyre_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_NO_MASS,
                                            .name = "tyre",
                                            .evaluate = tyre};

static int add(car *c, int parent, mbsr_joint joint, mbsr_inertia inertia, double q)
{
    if (joint.n > 0) c->q[c->nq++] = q;
    return mbsr_simulation_add_body(&c->s, NULL, parent, joint, inertia);
}

static int turned(car *c, int parent, const mbsr_frame *A, const double axis[3],
                  mbsr_inertia inertia, double q)
{
    return add(c, parent, mbsr_joint_revolute(A, NULL, axis), inertia, q);
}

/* A wheel that rolls. */
static int spin(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double rate = *(const double *)user;
    *s = rate * t;
    *sdot = rate;
    *sddot = 0.0;
    return MBSR_OK;
}

/* Leaf, carrier and arm turn about x, one on the other's end; the hub steers on the carrier. */
static void add_corner(car *c, corner *k)
{
    const double s = k->side, e = k->front ? 1.0 : -1.0, x = k->front ? 0.97 : -1.047,
                 leaf = hypot(0.488 - 0.1585, 0.6 - 0.531), across = 0.572 - 0.488,
                 carrier = hypot(across, 0.531 - 0.229), arm = hypot(0.313, 0.073),
                 lower = carrier * (wheel_radius - 0.229) / (0.531 - 0.229),
                 leaf_angle = -s * atan((0.6 - 0.531) / (0.488 - 0.1585)),
                 tilt = s * atan(across / (0.531 - 0.229)), arm_angle = -s * atan(0.073 / 0.313);
    const double arm_com[3] = {0.0, -0.5 * s * 0.32146, 0.0},
                 arm_tensor[6] = {0.052099, 0.023235, 0.068864},
                 wheel_tensor[6] = {1.2402, 1.908, 1.2402}, inner[3] = {0.0, -s * arm, 0.0},
                 eye[3] = {x, s * arm_axis[0], arm_axis[1]}, tip[3] = {0.0, s * leaf, 0.0},
                 rack[3] = {k->front ? 0.83 : -0.907, s * 0.07, 0.03},
                 lever[3] = {-e * 0.14, -s * 0.038537057, 0.19236225},
                 above[3] = {k->front ? 1.045 : -1.122, s * 0.297, 0.062},
                 seat[3] = {e * 0.075, -s * 0.0728438, -0.0046671};
    const double plane[6] = {0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    const mbsr_frame on_cabin = mbsr_frame_at(x, s * leaf_axis[0], leaf_axis[1]),
                     at_tip = mbsr_frame_at(0.0, tip[1], 0.0),
                     below = mbsr_frame_at(0.0, 0.0, -carrier),
                     pivot = mbsr_frame_at(0.0, 0.0, lower - carrier),
                     upright = mbsr_frame_rotated(NULL, x_axis, -tilt);
    int *b = k->body;
    b[LEAF] = turned(c, c->cabin, &on_cabin, x_axis, mbsr_inertia_zero(), leaf_angle);
    b[CARRIER] = turned(c, b[LEAF], &at_tip, x_axis, mbsr_inertia_zero(), tilt - leaf_angle);
    b[ARM] = turned(c, b[CARRIER], &below, x_axis, mbsr_inertia_rigid(6.0, arm_com, arm_tensor),
                    arm_angle - tilt);
    b[HUB] = turned(c, b[CARRIER], &pivot, z_axis, mbsr_inertia_zero(), 0.0);
    mbsr_frame axle = upright;
    axle.x[1] = s * 0.043 * cos(tilt) + 0.127 * sin(tilt);
    axle.x[2] = -lower - s * 0.043 * sin(tilt) + 0.127 * cos(tilt);
    static const mbsr_axis wheel_axis = {MBSR_AXIS_ROTATION, {0, 1, 0}, 0, 1};
    k->rate = c->speed / tyre_radius[k->front];
    b[WHEEL] = add(c, b[HUB], mbsr_joint_compound(&axle, NULL, 1, &wheel_axis, spin, &k->rate),
                   mbsr_inertia_rigid(57.35, none, wheel_tensor), 0.0);
    /* The end of the leaf presses on a stop that follows it across the cabin. */
    const mbsr_frame seat_of_leaf = mbsr_frame_at(x, 0.0, 0.137);
    b[STOP] = add(c, c->cabin, mbsr_joint_prismatic(&seat_of_leaf, NULL, y_axis),
                  mbsr_inertia_zero(), s * 0.488);
    mbsr_simulation_add_closure(&c->s,
                                mbsr_closure_body_rows(b[ARM], inner, c->cabin, eye, 2, plane));
    mbsr_simulation_add_closure(&c->s,
                                mbsr_closure_distance(b[HUB], lever, c->cabin, rack, 0.38424601));
    mbsr_simulation_add_closure(&c->s,
                                mbsr_closure_body_rows(b[LEAF], tip, b[STOP], none, 1, y_axis));
    k->force[SPRING] =
        mbsr_simulation_add_force(&c->s, mbsr_force_point_spring(b[LEAF], tip, b[STOP], none,
                                                                 leaf_stiffness, 0.0, leaf_free));
    static double slope[2] = {36975.0, 24529.0};
    const mbsr_spring shock = {.function = c->speed != 0.0 ? linear_absorber : absorber,
                               .user = slope + k->front};
    k->force[SHOCK] =
        mbsr_simulation_add_force(&c->s, mbsr_force_spring(b[ARM], seat, c->cabin, above, &shock));
    mbsr_force_def road = mbsr_force_custom(&tyre_table, 1, &b[WHEEL], NULL);
    road.param[0] = tyre_radius[k->front];
    if (c->speed != 0.0) memcpy(road.param + 1, slip_law[k->front], sizeof slip_law[0]);
    k->force[ROAD] = mbsr_simulation_add_force(&c->s, road);
}

static void build(car *c, double speed)
{
    static const mbsr_axis axes[6] = {
        {MBSR_AXIS_TRANSLATION, {1, 0, 0}, 0, 0}, {MBSR_AXIS_TRANSLATION, {0, 1, 0}, 0, 0},
        {MBSR_AXIS_TRANSLATION, {0, 0, 1}, 0, 0}, {MBSR_AXIS_ROTATION, {0, 1, 0}, 0, 0},
        {MBSR_AXIS_ROTATION, {1, 0, 0}, 0, 0},    {MBSR_AXIS_ROTATION, {0, 0, 1}, 0, 0}};
    const double tensor[6] = {130.0, 1620.0, 1670.0};
    *c = (car){.s = mbsr_simulation_begin(NULL), .speed = speed, .at_z = speed != 0.0 ? 0 : 2};
    const int count = c->at_z ? 3 : 6;
    c->q[2 - c->at_z] = height;
    c->nq = count;
    c->cabin =
        mbsr_simulation_add_body(&c->s, "cabin", MBSR_GROUND,
                                 mbsr_joint_compound(NULL, NULL, count, axes + c->at_z, NULL, NULL),
                                 mbsr_inertia_rigid(1260.0, none, tensor));
    mbsr_simulation_add_force(&c->s, mbsr_force_gravity(0.0, 0.0, -9.81));
    for (int k = 0; k < 4; ++k) {
        c->at[k] = (corner){.side = k % 2 ? 1 : -1, .front = k < 2};
        add_corner(c, c->at + k);
    }
}

/* Force of a spring on a corner, N, positive pulls together: the cabin is above its lower end. */
static double pull(const car *c, int force)
{
    double f[6], tau[6];
    sheet_check(mbsr_force_load(c->s.model, c->s.data, force, 0, f, tau), &c->s.error);
    return copysign(sqrt(f[3] * f[3] + f[4] * f[4] + f[5] * f[5]), f[5]);
}

/* What the hinge of the leaf holds along the leaf, N; positive: it is stretched. */
static double rod(const car *c, const corner *k)
{
    double pose[MBSR_POSE_SIZE], f[6];
    sheet_check(mbsr_body_pose(c->s.model, c->s.data, k->body[LEAF], pose), &c->s.error);
    sheet_check(mbsr_joint_reaction(c->s.model, c->s.data, k->body[LEAF], f), &c->s.error);
    return -k->side * (pose[3] * f[3] + pose[4] * f[4] + pose[5] * f[5]);
}

static double tyre_load(const car *c, const corner *k)
{
    double f[6], tau[6];
    sheet_check(mbsr_force_load(c->s.model, c->s.data, k->force[ROAD], 0, f, tau), &c->s.error);
    return f[5];
}

static int held(void *user, double t, int n, double *value)
{
    (void)t;
    memcpy(value, user, (size_t)n * sizeof *value);
    return MBSR_OK;
}

/* Robotran's linear law has no preload and its modes are about a state that is held all the same:
 * by constant forces along its independent coordinates. These are a moment on the cabin's pitch and
 * on the leaves of each axle; here they are found so that nothing accelerates. */
static void hold(car *c, const double *q, const double *u, double on_cabin[6], double on_leaf[4])
{
    enum { PITCH = 3, FRONT_LEAF = 6, REAR_LEAF = 16 };
    const int rate[3] = {PITCH, FRONT_LEAF, REAR_LEAF};
    double A[3][4];
    for (int k = 3; k >= 0; --k) { /* 3: without any */
        on_cabin[PITCH] = k == 0;
        for (int l = 0; l < 4; ++l) on_leaf[l] = k == 1 + l / 2 ? (l % 2 ? -1.0 : 1.0) : 0.0;
        sheet_start(&c->s, 1e-8, q, u);
        for (int r = 0; r < 3; ++r)
            A[r][k] = k == 3 ? -c->s.udot[rate[r]] : c->s.udot[rate[r]] + A[r][3];
    }
    for (int k = 0; k < 3; ++k) {
        for (int r = 0; r < 3; ++r) {
            const double factor = A[r][k] / A[k][k];
            for (int l = k; l < 4 && r != k; ++l) A[r][l] -= factor * A[k][l];
        }
    }
    on_cabin[PITCH] = A[0][3] / A[0][0];
    for (int l = 0; l < 4; ++l)
        on_leaf[l] = (l % 2 ? -1.0 : 1.0) * A[1 + l / 2][3] / A[1 + l / 2][1 + l / 2];
}

/* Modes at 20 m/s about the rest of another car, with tyres that hold sideways. */
static void modes(sheet *out, const car *rest)
{
    static const struct {
        const char *name;
        double real, imaginary; /* published */
    } theirs[9] = {{"roll, 1/s", -6.682, 0.0},
                   {"pitch, 1/s", -3.990, 8.064},
                   {"sway and roll, 1/s", -3.688, 9.096},
                   {"bounce, 1/s", -5.382, 9.258},
                   {"sideways, 1/s", -44.03, 0.0},
                   {"wheels, cabin rolling, 1/s", -26.56, 71.35},
                   {"wheels, cabin bouncing, 1/s", -29.68, 80.67},
                   {"wheels, cabin pitching, 1/s", -29.38, 81.65},
                   {"wheels, cabin yawing, 1/s", -29.37, 84.77}};
    static car c;
    double q[64] = {0.0}, u[64] = {20.0}, on_cabin[6] = {0.0}, on_leaf[4] = {0.0};
    mbsr_mode mode[128];
    mbsr_linear *l;
    mbsr_error error;
    int count;
    build(&c, 20.0);
    mbsr_simulation_add_force(&c.s, mbsr_force_joint_applied(c.cabin, held, on_cabin));
    for (int k = 0; k < 4; ++k)
        mbsr_simulation_add_force(&c.s,
                                  mbsr_force_joint_applied(c.at[k].body[LEAF], held, on_leaf + k));
    mbsr_data *d = mbsr_simulation_add_data(&c.s);
    sheet_check(c.s.status, &c.s.error);
    memcpy(q + 2, rest->s.q, 3 * sizeof *q);
    memcpy(q + 6, rest->s.q + 3, (size_t)(rest->nq - 3) * sizeof *q);
    hold(&c, q, u, on_cabin, on_leaf);
    sheet_check(mbsr_linear_create(c.s.model, d, 0.0, q, u, NULL, &l, &error), &error);
    sheet_check(mbsr_linear_modes(l, mode, &count), NULL);
    sheet_problem(out, "Bombardier Iltis at 20 m/s",
                  "Modal analysis of Robotran in ovankerm/IAVSD_ILTIS, four digits: absorbers by "
                  "a linear law without preload, tyres by coefficients for small slip.");
    for (int k = 0; k < 9; ++k) {
        const mbsr_mode *ours = mode + count - 9 + k;
        sheet_add(out, theirs[k].name, theirs[k].real, ours->real, 5e-3);
        if (theirs[k].imaginary != 0.0)
            sheet_add(out, "its frequency, rad/s", theirs[k].imaginary, ours->imaginary, 5e-3);
    }
    mbsr_linear_destroy(l);
    mbsr_simulation_end(&c.s);
}

void sheet_iltis(sheet *out)
{
    static car c;
    build(&c, 0.0);
    mbsr_data *d = mbsr_simulation_add_data(&c.s);
    mbsr_error error;
    sheet_check(c.s.status, &c.s.error);
    sheet_problem(out, "Bombardier Iltis where its data are given",
                  "Benchmark of the IAVSD: forces that its authors print to check the data, as in "
                  "the Robotran model of ovankerm/IAVSD_ILTIS.");
    sheet_start(&c.s, 1e-8, c.q, NULL);
    sheet_add(out, "leaf spring, N", -2728.9, pull(&c, c.at[0].force[SPRING]), 0.1);
    sheet_add(out, "shock absorber, N", -128.0, pull(&c, c.at[0].force[SHOCK]), 0.1);
    sheet_add(out, "front tyre, N", 3829.6, tyre_load(&c, c.at), 0.2);
    sheet_add(out, "rear tyre, N", 3593.6, tyre_load(&c, c.at + 2), 0.2);
    sheet_check(mbsr_equilibrium(c.s.model, d, 0.0, c.q, NULL, c.q, NULL, NULL, &error), &error);
    sheet_start(&c.s, 1e-8, c.q, NULL);
    const corner *front = c.at + 1, *rear = c.at + 3;
    sheet_problem(out, "Bombardier Iltis at rest",
                  "Equilibrium report of Robotran in ovankerm/IAVSD_ILTIS.");
    sheet_add(out, "vertical displacement of the cabin, mm", -7.083, 1e3 * (c.s.q[0] - height),
              1e-3);
    sheet_add(out, "pitch of the cabin, °", 0.1465, c.s.q[1] * 45.0 / atan(1.0), 1e-4);
    sheet_add(out, "front tyre, N", 3831.31, tyre_load(&c, front), 1e-2);
    sheet_add(out, "rear tyre, N", 3591.91, tyre_load(&c, rear), 1e-2);
    sheet_add(out, "front shock absorber, N", -335.29, pull(&c, front->force[SHOCK]), 1e-2);
    sheet_add(out, "rear shock absorber, N", -241.64, pull(&c, rear->force[SHOCK]), 1e-2);
    sheet_add(out, "front leaf spring, N", -3068.62, pull(&c, front->force[SPRING]), 1e-2);
    sheet_add(out, "front rod of the leaf, N", -1408.51, rod(&c, front), 1e-2);
    sheet_add(out, "rear leaf spring, N", -2885.51, pull(&c, rear->force[SPRING]), 1e-2);
    sheet_add(out, "rear rod of the leaf, N", -1335.52, rod(&c, rear), 1e-2);
    modes(out, &c);
    mbsr_simulation_end(&c.s);
}
