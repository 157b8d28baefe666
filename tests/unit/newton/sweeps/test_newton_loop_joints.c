/* Newton systems of mechanisms in space whose loops go through joints of several axes: in vector
 * code, beside the elimination by blocks and the dense matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REVOLUTE, UNIVERSAL, CYLINDRICAL, BALL, IN_PLANE, FREE, SLIDER, DRIVEN, WELD };

enum { MOST_BODIES = 20 };

/* A mechanism that is put together at q = 0, where its bodies have the world's axes. */
typedef struct mechanism {
    loops s;
    double origin[MOST_BODIES + 1][3]; /* of the bodies there; the ground's behind the last */
    double unit;                       /* how many units of length are a metre */
} mechanism;

static int swing(void *user, double t, double *s, double *rate, double *acceleration)
{
    (void)user;
    *s = 0.3 * t;
    *rate = 0.3;
    *acceleration = 0.0;
    return 0;
}

static mbsr_joint joint_of(int kind, const mbsr_frame *A, const double axis[3])
{
    const double other[3] = {axis[1], axis[2] + 0.3, axis[0] - 0.4};
    const mbsr_axis driven[2] = {{MBSR_AXIS_ROTATION, {axis[0], axis[1], axis[2]}, 0.0, 0},
                                 {MBSR_AXIS_ROTATION, {other[0], other[1], other[2]}, 0.0, 1}};
    switch (kind) {
    case REVOLUTE: return mbsr_joint_revolute(A, NULL, axis);
    case UNIVERSAL: return mbsr_joint_universal(A, NULL, axis, other);
    case CYLINDRICAL: return mbsr_joint_cylindrical(A, NULL, axis);
    case BALL: return mbsr_joint_spherical(A, NULL);
    case IN_PLANE: return mbsr_joint_in_plane(A, NULL);
    case FREE: return mbsr_joint_free(A, NULL);
    case SLIDER: return mbsr_joint_prismatic(A, NULL, axis);
    case DRIVEN: return mbsr_joint_compound(A, NULL, 2, driven, swing, NULL);
    default: return mbsr_joint_weld(A, NULL);
    }
}

static void begin(mechanism *m, double unit)
{
    loops_begin(&m->s, NULL);
    m->unit = unit;
    memset(m->origin, 0, sizeof m->origin);
}

static const double *origin_of(const mechanism *m, int body)
{
    return m->origin[body == MBSR_GROUND ? MOST_BODIES : body];
}

/* From a body's origin to a point of the world, in units of length. */
static void arm_to(const mechanism *m, int body, const double at[3], double arm[3])
{
    for (int k = 0; k < 3; ++k) arm[k] = m->unit * (at[k] - origin_of(m, body)[k]);
}

/* A body whose origin and joint are there. */
static int add_with(mechanism *m, int parent, int kind, const double at[3], const double axis[3],
                    mbsr_inertia inertia)
{
    int id;
    double arm[3];
    arm_to(m, parent, at, arm);
    const mbsr_frame A = mbsr_frame_at(arm[0], arm[1], arm[2]);
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint_of(kind, &A, axis);
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m->s.m, &body, &id), mbsr_model_error(m->s.m));
    memcpy(m->origin[id], at, 3 * sizeof *at);
    return id;
}

/* No inertia where the mass is zero. */
static int add(mechanism *m, int parent, int kind, const double at[3], const double axis[3],
               double mass)
{
    const double unit = m->unit, com[3] = {0.1 * unit, -0.05 * unit, 0.03 * unit};
    double tensor[6] = {0.03, 0.04, 0.05, 0.001, 0.002, -0.003};
    for (int k = 0; k < 6; ++k) tensor[k] *= mass * unit * unit;
    return add_with(m, parent, kind, at, axis,
                    mass > 0.0 ? mbsr_inertia_rigid(mass, com, tensor) : mbsr_inertia_zero());
}

/* A rod from its origin, whose moment about itself is that share of the one across. */
static mbsr_inertia rod(const double along[3], double mass, double share)
{
    const double square = along[0] * along[0] + along[1] * along[1] + along[2] * along[2],
                 across = mass * square / 12.0, less = (1.0 - share) * across / square;
    const double com[3] = {0.5 * along[0], 0.5 * along[1], 0.5 * along[2]};
    double tensor[6];
    tensor[MBSR_XX] = across - less * along[0] * along[0];
    tensor[MBSR_YY] = across - less * along[1] * along[1];
    tensor[MBSR_ZZ] = across - less * along[2] * along[2];
    tensor[MBSR_XY] = -less * along[0] * along[1];
    tensor[MBSR_XZ] = -less * along[0] * along[2];
    tensor[MBSR_YZ] = -less * along[1] * along[2];
    return mbsr_inertia_rigid(mass, com, tensor);
}

static void tie(mechanism *m, int a, int b, const double at[3])
{
    double on_a[3], on_b[3];
    arm_to(m, a, at, on_a);
    arm_to(m, b, at, on_b);
    const mbsr_closure_def ball = mbsr_closure_ball(a, on_a, b, on_b);
    assert_ok(mbsr_model_add_closure(m->s.m, &ball, NULL), mbsr_model_error(m->s.m));
}

static void damp(mechanism *m, int body, double damping)
{
    const mbsr_force_def law = mbsr_force_joint_spring(body, 0, 2.0, damping, 0.0);
    assert_ok(mbsr_model_add_force(m->s.m, &law, NULL), mbsr_model_error(m->s.m));
}

/* Of all coordinates of a joint, the length of a quaternion among them, and of its rates. */
static int coupled_law(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    for (int k = 0; k < b->n; ++k) {
        for (int l = 0; l < b->nq; ++l) b->tau[k] += (3.0 * k - l) * sin(b->q[l] + k);
        for (int l = 0; l < b->n; ++l) b->tau[k] -= (k == l ? 4.0 : 1.0) * b->u[l];
    }
    return 0;
}

static const mbsr_force_table coupled_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                               .flags = MBSR_FORCE_JOINT_ONLY,
                                               .name = "coupled law",
                                               .evaluate = coupled_law};

static void couple(mechanism *m, int body)
{
    const mbsr_force_def law = mbsr_force_custom(&coupled_table, 1, &body, NULL);
    assert_ok(mbsr_model_add_force(m->s.m, &law, NULL), mbsr_model_error(m->s.m));
}

static void bush(mechanism *m, int a, int b)
{
    const double springs[6] = {30.0, 40.0, 50.0, 200.0, 300.0, 400.0},
                 dampers[6] = {0.3, 0.4, 0.5, 2.0, 3.0, 4.0};
    const mbsr_frame at = mbsr_frame_at(0.1, 0.05, -0.1);
    const mbsr_force_def bushing = mbsr_force_bushing(a, &at, b, NULL, springs, dampers);
    assert_ok(mbsr_model_add_force(m->s.m, &bushing, NULL), mbsr_model_error(m->s.m));
}

/* At its place, with some velocity before the start makes it one that the loops allow. */
static void finish(mechanism *m)
{
    loops_finish(&m->s);
    memset(m->s.q, 0, sizeof m->s.q);
    for (int k = 0; k < mbsr_model_bodies(m->s.m); ++k) {
        int first, nq, u, n;
        assert_ok(mbsr_body_coordinates(m->s.m, k, &first, &nq, &u, &n), NULL);
        if (nq > n) m->s.q[first] = 1.0;
    }
    for (int k = 0; k < m->s.nu; ++k) m->s.u[k] = 0.7 * sin(1.0 + 2.0 * k);
}

static const double x_axis[3] = {1.0, 0.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};

/* Crank and rocker about axes that are not parallel, a coupler on a joint of that kind, a tail on
 * the coupler where that has mass. */
static void fourbar_with(mechanism *m, int kind, double crank_mass, double coupler, double unit)
{
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.1, 0.3, 0.05},
                        end[3] = {0.6, 0.5, 0.1}, rocker[3] = {0.7, 0.0, 0.0},
                        tail[3] = {0.4, 0.4, 0.1}, tilted[3] = {0.1, 0.3, 1.0};
    begin(m, unit);
    const int a = add(m, MBSR_GROUND, REVOLUTE, crank, z_axis, crank_mass),
              b = add(m, a, kind, tip, tilted, coupler),
              c = add(m, MBSR_GROUND, REVOLUTE, rocker, tilted, 2.0);
    if (coupler > 0.0) add(m, b, BALL, tail, x_axis, 0.5);
    tie(m, b, c, end);
}

static void fourbar(mechanism *m, int kind, double coupler, double unit)
{
    fourbar_with(m, kind, 1.0, coupler, unit);
}

/* Arms on a chassis, the upright on a ball joint of the lower one, a tie rod on a universal joint.
 * `mass`: of arms and rod. */
static void suspension(mechanism *m, int chassis, double mass)
{
    static const double place[3] = {0.0, 0.0, 0.3}, low[3] = {0.0, 0.3, 0.2},
                        up[3] = {0.0, 0.35, 0.5}, rod[3] = {0.15, 0.3, 0.3},
                        ball[3] = {0.02, 0.7, 0.2}, high[3] = {0.0, 0.65, 0.5},
                        steering[3] = {0.16, 0.68, 0.3}, hub[3] = {0.0, 0.75, 0.3},
                        y_axis[3] = {0.0, 1.0, 0.0};
    begin(m, 1.0);
    const int on = add(m, MBSR_GROUND, chassis, place, z_axis, 30.0),
              lower = add(m, on, REVOLUTE, low, x_axis, mass),
              upright = add(m, lower, BALL, ball, x_axis, 5.0),
              upper = add(m, on, REVOLUTE, up, x_axis, mass),
              link = add(m, on, UNIVERSAL, rod, z_axis, mass);
    add(m, upright, REVOLUTE, hub, y_axis, 8.0);
    tie(m, upright, upper, high);
    tie(m, upright, link, steering);
    damp(m, lower, 3.0);
}

/* Six legs, each a cylinder on a universal joint and a rod that slides in it; the platform on a
 * free joint, or on a ball joint of the first leg. */
static void platform(mechanism *m, int free, double leg_mass)
{
    double foot[6][3], head[6][3];
    static const double top[3] = {0.0, 0.0, 1.0};
    int rods[6], plate = -1;
    begin(m, 1.0);
    for (int k = 0; k < 6; ++k) {
        const double angle = 1.0471975511965976 * k, skew = k % 2 ? 0.3 : -0.3;
        for (int j = 0; j < 3; ++j) foot[k][j] = head[k][j] = j == 2 ? 0.0 : 1.0;
        foot[k][0] *= cos(angle), foot[k][1] *= sin(angle);
        head[k][0] *= 0.6 * cos(angle + skew), head[k][1] *= 0.6 * sin(angle + skew);
        head[k][2] = 1.0;
    }
    if (free) plate = add(m, MBSR_GROUND, FREE, top, z_axis, 4.0);
    for (int k = 0; k < 6; ++k) {
        double along[3], middle[3];
        for (int j = 0; j < 3; ++j) {
            along[j] = head[k][j] - foot[k][j];
            middle[j] = foot[k][j] + 0.5 * along[j];
        }
        const int leg = add(m, MBSR_GROUND, UNIVERSAL, foot[k], x_axis, leg_mass);
        rods[k] = add(m, leg, SLIDER, middle, along, 0.7 * leg_mass);
        damp(m, rods[k], 5.0);
        if (plate < 0) plate = add(m, rods[0], BALL, head[0], z_axis, 4.0);
        if (k > 0 || free) tie(m, plate, rods[k], head[k]);
    }
}

/* ---- solutions ---- */

static void compare_at(mechanism *m, newton_sweeps sweeps)
{
    newton_both_ways(m->s.m, m->s.d, m->s.q, m->s.u, sweeps, NULL, 0);
}

static void compare(mechanism *m)
{
    finish(m);
    compare_at(m, ONE_SWEEP);
    loops_free(&m->s);
}

static void couplers(void **state)
{
    (void)state;
    for (int kind = REVOLUTE; kind <= WELD; ++kind) {
        mechanism m;
        if (kind == REVOLUTE || kind == SLIDER || kind == DRIVEN || kind == WELD) continue;
        fourbar(&m, kind, 1.5, 1.0);
        compare(&m);
    }
}

/* A prescribed axis beside a free one, which the loop leaves its freedom by a rocker on a ball
 * joint. */
static void prescribed_axes(void **state)
{
    (void)state;
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.1, 0.3, 0.05},
                        end[3] = {0.6, 0.5, 0.1}, rocker[3] = {0.7, 0.0, 0.0},
                        tilted[3] = {0.1, 0.3, 1.0};
    mechanism m;
    begin(&m, 1.0);
    const int a = add(&m, MBSR_GROUND, UNIVERSAL, crank, z_axis, 1.0),
              b = add(&m, a, DRIVEN, tip, tilted, 1.5),
              c = add(&m, MBSR_GROUND, BALL, rocker, tilted, 2.0);
    tie(&m, b, c, end);
    compare(&m);
}

/* Thin rods between ball joints: their moments of inertia about themselves are next to nothing. */
static void thin_rods(void **state)
{
    (void)state;
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.1, 0.3, 0.05},
                        end[3] = {0.6, 0.5, 0.1}, along[3] = {0.5, 0.2, 0.05},
                        rocker[3] = {0.7, 0.0, 0.0}, tilted[3] = {0.1, 0.3, 1.0};
    static const double share[] = {1e-1, 1e-3, 1e-4, 2e-5};
    for (int k = 0; k < 4; ++k) {
        mechanism m;
        begin(&m, 1.0);
        const int a = add(&m, MBSR_GROUND, REVOLUTE, crank, z_axis, 1.0),
                  b = add_with(&m, a, BALL, tip, tilted, rod(along, 1.5, share[k])),
                  c = add(&m, MBSR_GROUND, REVOLUTE, rocker, tilted, 2.0);
        tie(&m, b, c, end);
        finish(&m);
        compare_at(&m, k == 0 ? ONE_SWEEP : BY_FRONT);
        loops_free(&m.s);
    }
}

/* Springs and dampers between neighbours on the loop, and across. */
static void bushings(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, BALL, CYLINDRICAL};
    for (int k = 0; k < 3; ++k) {
        mechanism m;
        fourbar(&m, kind[k], 1.5, 1.0);
        bush(&m, 1, 0);
        bush(&m, 2, MBSR_GROUND);
        compare(&m);
    }
}

/* Lengths in millimetres and masses in tonnes, as it were: all numbers of other sizes. */
static void units(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, BALL, CYLINDRICAL};
    for (int k = 0; k < 3; ++k) {
        mechanism m;
        fourbar(&m, kind[k], 1.5, 1000.0);
        compare(&m);
    }
}

static void suspensions(void **state)
{
    (void)state;
    static const int chassis[] = {WELD, SLIDER, FREE};
    for (int k = 0; k < 3; ++k) {
        mechanism m;
        suspension(&m, chassis[k], 2.0);
        compare(&m);
    }
}

static void platforms(void **state)
{
    (void)state;
    for (int free = 0; free < 2; ++free) {
        mechanism m;
        platform(&m, free, 1.0);
        compare(&m);
    }
}

/* ---- bodies without mass that loops hold ---- */

static void massless_couplers(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, CYLINDRICAL};
    for (int k = 0; k < 2; ++k) {
        for (int wide = 0; wide < 2; ++wide) {
            mechanism m;
            fourbar(&m, kind[k], 0.0, wide ? 1000.0 : 1.0);
            finish(&m);
            compare_at(&m, EITHER);
            loops_free(&m.s);
        }
    }
}

/* The rocker's inertia is that of all. */
static void massless_cranks(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, CYLINDRICAL};
    for (int k = 0; k < 2; ++k) {
        for (int wide = 0; wide < 2; ++wide) {
            mechanism m;
            fourbar_with(&m, kind[k], 0.0, 0.0, wide ? 1000.0 : 1.0);
            compare(&m);
        }
    }
}

/* Beside dampers, which determine what the loop does not: a rod between ball joints turns about
 * itself. */
static void massless_couplers_in_bushings(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, BALL, CYLINDRICAL, IN_PLANE};
    for (int k = 0; k < 4; ++k) {
        for (int on = 0; on < 3; ++on) {
            mechanism m;
            fourbar(&m, kind[k], 0.0, 1.0);
            if (on != 1) bush(&m, 1, 0);
            if (on != 0) bush(&m, 1, MBSR_GROUND);
            couple(&m, 1);
            compare(&m);
        }
    }
}

/* A coupler in pieces, each with a rocker: what is behind a joint of several axes has no mass
 * either.
 */
static void massless_couplers_in_pieces(void **state)
{
    (void)state;
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.1, 0.3, 0.05},
                        elbow[3] = {0.35, 0.6, 0.2}, end[3] = {0.6, 0.5, 0.1},
                        top[3] = {0.5, 0.2, 0.4}, rocker[3] = {0.7, 0.0, 0.0},
                        tilted[3] = {0.1, 0.3, 1.0};
    for (int kind = UNIVERSAL; kind <= BALL; ++kind) {
        mechanism m;
        begin(&m, 1.0);
        const int a = add(&m, MBSR_GROUND, REVOLUTE, crank, z_axis, 1.0),
                  b = add(&m, a, kind, tip, tilted, 0.0),
                  piece = add(&m, b, kind == BALL ? WELD : REVOLUTE, elbow, x_axis, 0.0),
                  other = add(&m, b, WELD, elbow, x_axis, 0.0),
                  c = add(&m, MBSR_GROUND, REVOLUTE, rocker, tilted, 2.0),
                  d = add(&m, MBSR_GROUND, BALL, rocker, tilted, 1.5);
        tie(&m, piece, c, end);
        tie(&m, other, d, top);
        bush(&m, b, MBSR_GROUND);
        bush(&m, piece, MBSR_GROUND);
        compare(&m);
    }
}

/* Welds on the way, in front of the coupler and behind it, with mass and without; the loops of two
 * couplers meet on the crank. */
static void welds(void **state)
{
    (void)state;
    static const int kind[] = {UNIVERSAL, BALL, CYLINDRICAL};
    static const double crank[3] = {0.0, 0.0, 0.0}, arm[3] = {0.02, 0.2, 0.0},
                        tip[3] = {0.1, 0.3, 0.05}, hand[3] = {0.4, 0.4, 0.1},
                        end[3] = {0.6, 0.5, 0.1}, top[3] = {0.5, 0.2, 0.4},
                        rocker[3] = {0.7, 0.0, 0.0}, tilted[3] = {0.1, 0.3, 1.0};
    for (int k = 0; k < 6; ++k) {
        const double mass = k < 3 ? 1.5 : 0.0;
        mechanism m;
        begin(&m, 1.0);
        const int a = add(&m, MBSR_GROUND, REVOLUTE, crank, z_axis, 1.0),
                  on = add(&m, a, WELD, arm, z_axis, mass),
                  b = add(&m, on, kind[k % 3], tip, tilted, mass),
                  behind = add(&m, b, WELD, hand, z_axis, mass),
                  c = add(&m, MBSR_GROUND, REVOLUTE, rocker, tilted, 2.0),
                  other = add(&m, a, BALL, hand, z_axis, 1.0);
        tie(&m, behind, c, end);
        tie(&m, other, c, top);
        bush(&m, on, MBSR_GROUND);
        bush(&m, b, MBSR_GROUND);
        compare(&m);
    }
}

/* A triangle without mass that a loop keeps stiff, on a body without mass in a bushing. */
static void massless_triangles(void **state)
{
    (void)state;
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.1, 0.3, 0.05},
                        left[3] = {0.2, 0.4, 0.1}, right[3] = {0.5, 0.3, 0.0},
                        top[3] = {0.4, 0.7, 0.3}, tilted[3] = {0.1, 0.3, 1.0};
    for (int kind = UNIVERSAL; kind <= CYLINDRICAL; ++kind) {
        mechanism m;
        begin(&m, 1.0);
        const int a = add(&m, MBSR_GROUND, REVOLUTE, crank, z_axis, 1.0),
                  on = add(&m, a, REVOLUTE, tip, tilted, 0.0),
                  b = add(&m, on, kind, left, tilted, 0.0),
                  c = add(&m, on, REVOLUTE, right, z_axis, 0.0);
        tie(&m, b, c, top);
        bush(&m, on, a);
        bush(&m, b, MBSR_GROUND);
        compare(&m);
    }
}

/* More rates than the loop has rows to hold them: bushings do. */
static void more_rates_than_rows(void **state)
{
    (void)state;
    mechanism m;
    fourbar(&m, FREE, 0.0, 1.0);
    bush(&m, 1, 0);
    bush(&m, 1, MBSR_GROUND);
    finish(&m);
    compare_at(&m, BY_FRONT);
    loops_free(&m.s);
}

/* What both solvers say of a state that is no start. */
static void compare_refusals(mechanism *m, int status, const char *words)
{
    double y[4 * LOOPS_MOST], yp[4 * LOOPS_MOST] = {0.0};
    assert_ok(mbsr_dae_pack(m->s.m, m->s.d, MBSR_DAE_MOMENTUM, 0.0, m->s.q, m->s.u, y), NULL);
    for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
        mbsr_newton *newton = newton_solver(m->s.m, by_blocks);
        assert_int_equal(mbsr_newton_factor(newton, m->s.d, 0.0, y, yp, 50.0), status);
        assert_contains(mbsr_newton_error(newton)->text, words);
        mbsr_newton_destroy(newton);
    }
}

/* A rod between ball joints turns about itself. */
static void nothing_holds(void **state)
{
    (void)state;
    mechanism m;
    fourbar(&m, BALL, 0.0, 1.0);
    finish(&m);
    compare_refusals(&m, MBSR_SINGULAR_BLOCK, "body 1|joint 'spherical'|holds|damper");
    loops_free(&m.s);
}

/* A parallelogram at an angle from where all its rods lie in one line, and the rows of its loop
 * depend on each other; couplers with mass and without. */
static void parallelogram(mechanism *m, double mass, double angle)
{
    static const double crank[3] = {0.0, 0.0, 0.0}, tip[3] = {0.3, 0.0, 0.0},
                        rocker[3] = {0.5, 0.0, 0.0}, end[3] = {0.8, 0.0, 0.0};
    begin(m, 1.0);
    const int a = add(m, MBSR_GROUND, REVOLUTE, crank, z_axis, 1.0),
              b = add(m, a, UNIVERSAL, tip, z_axis, mass),
              c = add(m, MBSR_GROUND, REVOLUTE, rocker, z_axis, 2.0);
    tie(m, b, c, end);
    finish(m);
    m->s.q[0] = m->s.q[3] = angle;
    m->s.q[1] = -angle;
    for (int k = 0; k < m->s.nu; ++k) m->s.u[k] *= fabs(angle);
}

static void near_a_toggle(void **state)
{
    (void)state;
    static const double angle[] = {1.0, 1e-1, 1e-2, -1e-3};
    for (int massless = 0; massless < 2; ++massless) {
        const double mass = massless ? 0.0 : 1.5;
        mechanism m;
        for (int k = 0; k < 4; ++k) {
            parallelogram(&m, mass, angle[k]);
            compare_at(&m, ONE_SWEEP);
            loops_free(&m.s);
        }
        parallelogram(&m, mass, 0.0);
        compare_refusals(&m, MBSR_LOOP_SINGULAR, "closure|row");
        loops_free(&m.s);
    }
}

static void massless_arms(void **state)
{
    (void)state;
    static const int chassis[] = {WELD, SLIDER, FREE};
    for (int k = 0; k < 3; ++k) {
        mechanism m;
        suspension(&m, chassis[k], 0.0);
        compare(&m);
    }
}

static void massless_legs(void **state)
{
    (void)state;
    mechanism m;
    platform(&m, 1, 0.0);
    compare(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(couplers),
                                       cmocka_unit_test(prescribed_axes),
                                       cmocka_unit_test(thin_rods),
                                       cmocka_unit_test(bushings),
                                       cmocka_unit_test(units),
                                       cmocka_unit_test(suspensions),
                                       cmocka_unit_test(platforms),
                                       cmocka_unit_test(massless_couplers),
                                       cmocka_unit_test(massless_cranks),
                                       cmocka_unit_test(massless_couplers_in_bushings),
                                       cmocka_unit_test(massless_couplers_in_pieces),
                                       cmocka_unit_test(welds),
                                       cmocka_unit_test(massless_triangles),
                                       cmocka_unit_test(more_rates_than_rows),
                                       cmocka_unit_test(nothing_holds),
                                       cmocka_unit_test(near_a_toggle),
                                       cmocka_unit_test(massless_arms),
                                       cmocka_unit_test(massless_legs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
