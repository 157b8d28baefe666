/* Time per body of chains with bodies of other kinds than rigid bodies in space on stock joints.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_kinds [samples [chain]]     CSV on standard output; of one chain alone
 *
 * Chains of hinges, all with the same tasks: forward and inverse dynamics, the residual of the
 * momentum form, one factorisation with one solution of its Newton system, the derivatives for
 * products with its matrix, and one such product. In space some joints have a table of their own,
 * whose functions call those of the stock joint: to the library such a joint is a user's. Those
 * `by_hand` have shorter functions. Then joints that lack rank or are made of dummy bodies: two
 * sliders without mass before each rod with a mass at its end (`sliders`; `one_pair`: one such rod
 * on a chain of hinges), ball joints with a mass at a point behind each (`points`; `one_point`),
 * ball joints of three hinges with two bodies without mass between (`dummies`), and the same joints
 * in one piece (`balls`). In `general` trees every tenth body is of dimension 3 to 12 and hangs on
 * one of the chain, which goes on without it; there the joint's derivatives are given, or not.
 */
#include "bench.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 21, TASKS = 6 };

static const double sample_time = 5e-3;
static const char *const task_name[TASKS] = {"forward",      "inverse",   "residual",
                                             "factor_solve", "linearise", "product"};

static const struct bench_case {
    const char *name;
    int bodies, planar;
    int every;          /* of so many joints one is a user's; 0: none */
    int general, given; /* bodies of any dimension, and derivatives of their joints */
    int by_hand;        /* all hinges but the first are a user's, with short functions */
    enum { HINGES, ONE_PAIR, ONE_POINT, SLIDERS, POINTS, DUMMIES, BALLS } links;
} cases[] = {{"space", 100, 0, 0, 0, 0, 0, HINGES},
             {"one_own_joint", 100, 0, 100, 0, 0, 0, HINGES},
             {"ten_own_joints", 100, 0, 10, 0, 0, 0, HINGES},
             {"all_joints_own", 100, 0, 1, 0, 0, 0, HINGES},
             {"all_joints_by_hand", 100, 0, 0, 0, 0, 1, HINGES},
             {"general", 100, 0, 0, 1, 0, 0, HINGES},
             {"general_given", 100, 0, 0, 1, 1, 0, HINGES},
             {"plane", 100, 1, 0, 0, 0, 0, HINGES},
             {"plane", 1000, 1, 0, 0, 0, 0, HINGES},
             {"one_pair", 100, 0, 0, 0, 0, 0, ONE_PAIR},
             {"one_point", 100, 0, 0, 0, 0, 0, ONE_POINT},
             {"sliders", 99, 0, 0, 0, 0, 0, SLIDERS},
             {"points", 100, 0, 0, 0, 0, 0, POINTS},
             {"dummies", 99, 0, 0, 0, 0, 0, DUMMIES},
             {"balls", 33, 0, 0, 0, 0, 0, BALLS}};
enum { CASES = sizeof cases / sizeof cases[0] };

typedef struct chain {
    int bodies;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton, *products;
    double *q, *u, *udot, *y, *yp, *F, *x;
    int repeats[TASKS];
} chain;

/* ---- a user's hinge -------------------------------------------------------------------------- */

static const mbsr_joint_table *stock;

static int own_position(const mbsr_joint_args *args, double *p)
{
    return stock->position(args, p);
}

static int own_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    return stock->jacobians(args, K, H, J, kI);
}

static int own_bias(const mbsr_joint_args *args, double *kII)
{
    return stock->bias(args, kII);
}

static int own_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    return stock->rates(args, Kdot, Hdot, Jdot);
}

static mbsr_joint own_hinge(mbsr_joint joint)
{
    static mbsr_joint_table own;
    stock = joint.table;
    own = (mbsr_joint_table){.version = MBSR_JOINT_TABLE_VERSION,
                             .flags = stock->flags,
                             .name = "own",
                             .position = own_position,
                             .jacobians = own_jacobians,
                             .bias = own_bias,
                             .rates = own_rates};
    joint.table = &own;
    return joint;
}

/* ---- the same hinge by hand --------------------------------------------------------------------
 *
 * About axis number param[0] of the predecessor, through the point `seat` of it: V = X V_pred + S u
 * with X a translation by rho = R_pred seat and S = (z, 0). */

static const double seat[3] = {0.3, 0.0, 0.1};

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* rho; the axis in the world. */
static const double *hinge_at(const mbsr_joint_args *args, double rho[3])
{
    const double *R = args->p_pred + MBSR_POSE_R;
    for (int k = 0; k < 3; ++k) rho[k] = R[k] * seat[0] + R[3 + k] * seat[1] + R[6 + k] * seat[2];
    return R + 3 * (int)args->param[0];
}

static int hand_position(const mbsr_joint_args *args, double *p)
{
    const int z = (int)args->param[0], x = (z + 1) % 3, y = (z + 2) % 3;
    const double c = cos(args->q[0]), s = sin(args->q[0]), *from = args->p_pred + MBSR_POSE_R;
    double *R = p + MBSR_POSE_R, rho[3];
    hinge_at(args, rho);
    for (int k = 0; k < 3; ++k) {
        R[3 * x + k] = c * from[3 * x + k] + s * from[3 * y + k];
        R[3 * y + k] = c * from[3 * y + k] - s * from[3 * x + k];
        R[3 * z + k] = from[3 * z + k];
        p[MBSR_POSE_X + k] = args->p_pred[MBSR_POSE_X + k] + rho[k];
    }
    return 0;
}

static int hand_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    double r[3];
    const double *z = hinge_at(args, r);
    (void)K, (void)kI;
    for (int k = 0; k < 3; ++k) J[k] = -z[k];
    for (int k = 0; k < 6; ++k) H[7 * k] = -1.0;
    H[4] = r[2], H[5] = -r[1];
    H[9] = -r[2], H[11] = r[0];
    H[15] = r[1], H[16] = -r[0];
    return 0;
}

static int hand_bias(const mbsr_joint_args *args, double *kII)
{
    double rho[3], swing[3];
    const double *z = hinge_at(args, rho), *omega = args->V_pred;
    cross(omega, z, kII);
    for (int k = 0; k < 3; ++k) kII[k] *= -args->u[0];
    cross(omega, rho, swing);
    cross(swing, omega, kII + 3);
    return 0;
}

static int hand_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    double rho[3], r[3], turned[3];
    const double *z = hinge_at(args, rho);
    (void)Kdot;
    cross(args->V_pred, rho, r);
    cross(args->V_pred, z, turned);
    for (int k = 0; k < 3; ++k) Jdot[k] = -turned[k];
    Hdot[4] = r[2], Hdot[5] = -r[1];
    Hdot[9] = -r[2], Hdot[11] = r[0];
    Hdot[15] = r[1], Hdot[16] = -r[0];
    return 0;
}

static const mbsr_joint_table hand_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                            .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
                                            .name = "by hand",
                                            .position = hand_position,
                                            .jacobians = hand_jacobians,
                                            .bias = hand_bias,
                                            .rates = hand_rates};

static mbsr_joint hinge_by_hand(int axis)
{
    mbsr_joint joint = mbsr_joint_custom(&hand_table, 6, 1, NULL);
    joint.space = MBSR_SPACE_SPATIAL;
    joint.np = MBSR_POSE_SIZE;
    joint.param[0] = axis;
    return joint;
}

/* ---- a body of any dimension ------------------------------------------------------------------
 *
 * p = C (r + R b) + J0 (q + 0.3 sin q), entry by entry, with r and R of a predecessor in space. */

enum { MOST = 12, COORDINATES = 2 };
static const double at[3] = {0.2, -0.1, 0.3};

static double entry_C(int k, int l)
{
    return sin(1.0 + 3.0 * k + l);
}

static double entry_J(int k, int l)
{
    return cos(2.0 + 2.0 * k + 5.0 * l);
}

static double C[3][MOST], J0[COORDINATES][MOST]; /* by columns */

static void fill_entries(void)
{
    for (int k = 0; k < MOST; ++k) {
        for (int l = 0; l < 3; ++l) C[l][k] = entry_C(k, l);
        for (int l = 0; l < COORDINATES; ++l) J0[l][k] = entry_J(k, l);
    }
}

/* y = R b for the nine numbers of a pose or of its change */
static void arm(const double *pose, double y[3])
{
    const double *R = pose + MBSR_POSE_R;
    for (int k = 0; k < 3; ++k) y[k] = R[k] * at[0] + R[3 + k] * at[1] + R[6 + k] * at[2];
}

static void add_C(int d, double factor, const double x[3], double *y)
{
    for (int l = 0; l < 3; ++l) {
        for (int k = 0; k < d; ++k) y[k] += factor * C[l][k] * x[l];
    }
}

static void add_J(int d, double factor, int l, double *y)
{
    for (int k = 0; k < d; ++k) y[k] += factor * J0[l][k];
}

/* H = -C (e_j x a), the first three columns */
static void add_H(int d, const double a[3], double *H)
{
    for (int j = 0; j < 3; ++j) {
        const double axis[3] = {j == 0, j == 1, j == 2};
        double column[3];
        cross(axis, a, column);
        add_C(d, -1.0, column, H + d * j);
    }
}

static int general_position(const mbsr_joint_args *args, double *p)
{
    double x[3];
    arm(args->p_pred, x);
    for (int k = 0; k < 3; ++k) x[k] += args->p_pred[MBSR_POSE_X + k];
    for (int k = 0; k < args->d; ++k) p[k] = 0.0;
    add_C(args->d, 1.0, x, p);
    for (int l = 0; l < args->n; ++l) add_J(args->d, args->q[l] + 0.3 * sin(args->q[l]), l, p);
    return 0;
}

static int general_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                             double *kI)
{
    const int d = args->d;
    double x[3];
    (void)K, (void)kI;
    arm(args->p_pred, x);
    add_H(d, x, H);
    for (int l = 0; l < 3; ++l) {
        for (int k = 0; k < d; ++k) H[d * (3 + l) + k] -= C[l][k];
    }
    for (int l = 0; l < args->n; ++l) add_J(d, -(1.0 + 0.3 * cos(args->q[l])), l, J + d * l);
    return 0;
}

static int general_bias(const mbsr_joint_args *args, double *kII)
{
    double x[3], swing[3], second[3];
    arm(args->p_pred, x);
    cross(args->V_pred, x, swing);
    cross(args->V_pred, swing, second);
    add_C(args->d, -1.0, second, kII);
    for (int l = 0; l < args->n; ++l)
        add_J(args->d, 0.3 * sin(args->q[l]) * args->u[l] * args->u[l], l, kII);
    return 0;
}

static int general_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    double x[3], swing[3];
    (void)Kdot;
    arm(args->p_pred, x);
    cross(args->V_pred, x, swing);
    add_H(args->d, swing, Hdot);
    for (int l = 0; l < args->n; ++l)
        add_J(args->d, 0.3 * sin(args->q[l]) * args->u[l], l, Jdot + args->d * l);
    return 0;
}

static int general_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                           double *dK, double *dH, double *dJ, double *dkI)
{
    const int d = args->d;
    double x[3];
    (void)dK, (void)dkI;
    arm(by->p_pred, x);
    add_H(d, x, dH);
    for (int k = 0; k < 3; ++k) x[k] += by->p_pred[MBSR_POSE_X + k];
    add_C(d, 1.0, x, dp);
    for (int l = 0; l < args->n; ++l) {
        if (by->q[l] == 0.0) continue;
        add_J(d, by->q[l] * (1.0 + 0.3 * cos(args->q[l])), l, dp);
        add_J(d, by->q[l] * 0.3 * sin(args->q[l]), l, dJ + d * l);
    }
    return 0;
}

static int general_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                                double *dkII, double *dKdot, double *dHdot, double *dJdot,
                                double *dqdot)
{
    const int d = args->d;
    double x[3], dx[3], swing[3], turned[3], second[3], part[3];
    (void)dKdot, (void)dqdot;
    arm(args->p_pred, x);
    arm(by->p_pred, dx);
    cross(args->V_pred, x, swing);
    cross(by->V_pred, x, turned);
    cross(args->V_pred, dx, part);
    for (int k = 0; k < 3; ++k) turned[k] += part[k];
    add_H(d, turned, dHdot);
    cross(args->V_pred, turned, second);
    cross(by->V_pred, swing, part);
    for (int k = 0; k < 3; ++k) second[k] += part[k];
    add_C(d, -1.0, second, dkII);
    for (int l = 0; l < args->n; ++l) {
        const double q = args->q[l], u = args->u[l];
        if (by->q[l] == 0.0 && by->u[l] == 0.0) continue;
        const double slope = 0.3 * (cos(q) * by->q[l] * u + sin(q) * by->u[l]);
        add_J(d, slope, l, dJdot + d * l);
        add_J(d, slope * u + 0.3 * sin(q) * u * by->u[l], l, dkII);
    }
    return 0;
}

static const mbsr_joint_table general_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                               .flags = MBSR_JOINT_UNIT_K,
                                               .name = "general",
                                               .position = general_position,
                                               .jacobians = general_jacobians,
                                               .bias = general_bias,
                                               .rates = general_rates},
                              given_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                             .flags = MBSR_JOINT_UNIT_K,
                                             .name = "given",
                                             .position = general_position,
                                             .jacobians = general_jacobians,
                                             .bias = general_bias,
                                             .rates = general_rates,
                                             .tangent = general_tangent,
                                             .rate_tangent = general_rate_tangent};

static int is_general(const struct bench_case *c, int i)
{
    return c->general && i % 10 == 5;
}

/* Of dimension 3, 4, 6, 9 or 12 in turn. */
static mbsr_body_def general_body(const struct bench_case *c, int i)
{
    static const int sizes[] = {3, 4, 6, 9, 12};
    static double M[MOST * MOST];
    const int d = sizes[i / 10 % 5];
    for (int k = 0; k < d * d; ++k)
        M[k] = (k % (d + 1) == 0 ? 1.0 : 0.0) + 0.05 * cos(k / d - k % d);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = i - 1;
    body.joint = mbsr_joint_custom(c->given ? &given_table : &general_table, d, COORDINATES, NULL);
    body.inertia = mbsr_inertia_matrix(d, M);
    return body;
}

/* ---- models ---------------------------------------------------------------------------------- */

/* Bodies of the last three of a chain with one_pair and one_point, and of those that repeat them.
 */
static mbsr_body_def link_of(const struct bench_case *c, int i)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0};
    const double com[3] = {0.1, 0.2, 0.3}, tensor[6] = {0.1, 0.1, 0.1, 0.0, 0.0, 0.0};
    const mbsr_frame end = mbsr_frame_at(0.0, 0.6, 0.0), A = mbsr_frame_at(0.3, 0.0, 0.1);
    const mbsr_frame *before = i == 0 ? NULL : &end;
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = i - 1;
    const int place = (i + (c->links == ONE_PAIR ? 2 : 0)) % 3;
    switch (c->links) {
    case ONE_PAIR:
    case SLIDERS:
        body.joint = place == 0   ? mbsr_joint_prismatic(before, NULL, y)
                     : place == 1 ? mbsr_joint_prismatic(NULL, NULL, z)
                                  : mbsr_joint_revolute(NULL, NULL, x);
        if (place == 2) body.inertia = mbsr_inertia_point_mass(1.0, end.x);
        break;
    case ONE_POINT:
    case POINTS:
        body.joint = mbsr_joint_spherical(before, NULL);
        body.inertia = mbsr_inertia_point_mass(1.0, end.x);
        break;
    case DUMMIES:
        body.joint = i % 3 == 0   ? mbsr_joint_revolute(&A, NULL, z)
                     : i % 3 == 1 ? mbsr_joint_revolute(NULL, NULL, y)
                                  : mbsr_joint_revolute(NULL, NULL, x);
        if (i % 3 == 2) body.inertia = mbsr_inertia_rigid(1.0, com, tensor);
        break;
    default:
        body.joint = mbsr_joint_spherical(&A, NULL);
        body.inertia = mbsr_inertia_rigid(1.0, com, tensor);
    }
    return body;
}

/* Whether body i is one of these. */
static int is_link(const struct bench_case *c, int i)
{
    switch (c->links) {
    case HINGES: return 0;
    case ONE_PAIR: return i >= 97;
    case ONE_POINT: return i == 99;
    default: return 1;
    }
}

static mbsr_body_def body_of(const struct bench_case *c, int i)
{
    const double axis[3] = {i % 3 == 0, i % 3 == 1, i % 3 == 2}, com[3] = {0.1, 0.2, 0.3};
    const double tensor[6] = {0.1, 0.1, 0.1, 0.0, 0.0, 0.0};
    const mbsr_frame A = mbsr_frame_at(0.3, 0.0, 0.1);
    mbsr_body_def body = mbsr_default_body_def();
    if (is_link(c, i)) return link_of(c, i);
    if (is_general(c, i)) return general_body(c, i);
    body.parent = i > 0 && is_general(c, i - 1) ? i - 2 : i - 1;
    if (c->planar) {
        const mbsr_planar_frame end = {i ? 1.0 : 0.0, 0.0, 0.0}, origin = {0.0, 0.0, 0.0};
        const double middle[2] = {0.5, 0.0};
        body.joint = mbsr_joint_planar_revolute(end, origin);
        body.inertia = mbsr_inertia_planar(1.0, middle, 0.1);
        return body;
    }
    body.joint = mbsr_joint_revolute(&A, NULL, axis);
    body.inertia = mbsr_inertia_rigid(1.0, com, tensor);
    if (c->by_hand && i > 0)
        body.joint = hinge_by_hand(i % 3);
    else if (c->every && i % c->every == c->every / 2)
        body.joint = own_hinge(body.joint);
    return body;
}

static void make_chain(chain *s, const struct bench_case *c)
{
    static const double none[3] = {0.0, 0.0, 0.0}, ones[3] = {1.0, 1.0, 1.0};
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    s->bodies = c->bodies;
    bench_check(mbsr_model_create(NULL, &s->model, NULL), "model", NULL);
    const mbsr_error *error = mbsr_model_error(s->model);
    for (int i = 0; i < c->bodies; ++i) {
        const mbsr_body_def body = body_of(c, i);
        bench_check(mbsr_model_add_body(s->model, &body, NULL), "body", error->text);
    }
    bench_check(mbsr_model_add_force(s->model, &gravity, NULL), "gravity", error->text);
    for (int i = 0; i < c->bodies; ++i) {
        const int ball = c->links == POINTS || c->links == ONE_POINT;
        if (!is_link(c, i) || (!ball && c->links != SLIDERS && c->links != ONE_PAIR)) continue;
        const mbsr_force_def damper = ball ? mbsr_force_joint_rotation_spring(i, none, ones, NULL)
                                           : mbsr_force_joint_spring(i, 0, 0.0, 1.0, 0.0);
        bench_check(mbsr_model_add_force(s->model, &damper, NULL), "damper", error->text);
    }
    bench_check(mbsr_model_finish(s->model), "finish", error->text);
    bench_check(mbsr_data_create(s->model, &s->data, NULL), "data", NULL);
    bench_check(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, NULL, &s->newton, NULL), "newton",
                NULL);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = 1;
    bench_check(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &s->products, NULL),
                "products", NULL);
    const size_t n = (size_t)mbsr_model_nu(s->model), nq = (size_t)mbsr_model_nq(s->model),
                 size = nq + 2 * n;
    s->q = bench_allocate(nq + 2 * n + 4 * size, sizeof *s->q);
    s->u = s->q + nq;
    s->udot = s->u + n;
    s->y = s->udot + n;
    s->yp = s->y + size;
    s->F = s->yp + size;
    s->x = s->F + size;
    for (size_t i = 0; i < nq; ++i) s->q[i] = 0.1 * sin(1.0 + (double)i);
    for (size_t i = 0; i < n; ++i) s->u[i] = cos((double)i);
    bench_check(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, s->y), "pack",
                mbsr_data_error(s->data)->text);
    bench_check(mbsr_newton_linearise(s->products, s->data, 0.0, s->y, s->yp, 10.0), "linearise",
                mbsr_newton_error(s->products)->text);
    for (int task = 0; task < TASKS; ++task) s->repeats[task] = 1;
}

static void free_chain(chain *s)
{
    mbsr_newton_destroy(s->newton);
    mbsr_newton_destroy(s->products);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    free(s->q);
}

/* ---- measurement ----------------------------------------------------------------------------- */

static int run(chain *s, int task)
{
    const mbsr_model *m = s->model;
    mbsr_data *d = s->data;
    switch (task) {
    case 0: {
        const int status = mbsr_forward_dynamics(m, d, 0.0, s->q, s->u, NULL, s->udot);
        return status == MBSR_UNDETERMINED ? MBSR_OK : status;
    }
    case 1: return mbsr_inverse_dynamics(m, d, 0.0, s->q, s->u, s->udot, NULL, s->x);
    case 2: return mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, s->y, s->yp, s->F);
    case 4: return mbsr_newton_linearise(s->products, d, 0.0, s->y, s->yp, 10.0);
    case 5: return mbsr_newton_multiply(s->products, s->y, s->x);
    default: break;
    }
    const int status = mbsr_newton_factor(s->newton, d, 0.0, s->y, s->yp, 10.0);
    return status ? status : mbsr_newton_solve(s->newton, s->F, s->x);
}

/* Nanoseconds per body of a call, the mean over as many as last 5 ms. */
static double measure(void *context, int which)
{
    chain *s = (chain *)context + which / TASKS;
    const int task = which % TASKS;
    bench_check(run(s, task), task_name[task], mbsr_data_error(s->data)->text);
    for (;;) {
        const double start = bench_now();
        for (int k = 0; k < s->repeats[task]; ++k) run(s, task);
        const double time = bench_now() - start;
        if (time >= sample_time) return 1e9 * time / s->repeats[task] / s->bodies;
        s->repeats[task] = 2 * s->repeats[task];
    }
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES;
    const struct bench_case *wanted[CASES];
    chain chains[CASES] = {0};
    int count = 0;
    for (int c = 0; c < CASES; ++c) {
        if (argc < 3 || strcmp(argv[2], cases[c].name) == 0) wanted[count++] = cases + c;
    }
    if (samples < 1 || count == 0) {
        fprintf(stderr, "usage: bench_kinds [samples [chain]]\n");
        return EXIT_FAILURE;
    }
    fill_entries();
    for (int c = 0; c < count; ++c) make_chain(chains + c, wanted[c]);
    double *sample = bench_allocate((size_t)(count * TASKS * samples), sizeof *sample);
    bench_sample_all(count * TASKS, samples, measure, chains, sample);
    bench_header(stdout, "libmbsrank: time per body of chains with bodies of several kinds");
    printf("chain,bodies,task,ns_per_body,min,q1,q3,samples\n");
    for (int k = 0; k < count * TASKS; ++k) {
        const struct bench_case *c = wanted[k / TASKS];
        const bench_quartiles time = bench_statistics(samples, sample + k * samples);
        printf("%s,%d,%s,%.1f,%.1f,%.1f,%.1f,%d\n", c->name, c->bodies, task_name[k % TASKS],
               time.median, time.min, time.q1, time.q3, samples);
    }
    free(sample);
    for (int c = 0; c < count; ++c) free_chain(chains + c);
    return EXIT_SUCCESS;
}
