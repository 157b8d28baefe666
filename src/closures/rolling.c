/* A ball or a disc rolls on a plane without slip.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * n is the normal of the plane on b, Q a point of it, c the centre, a the axis of the disc. The
 * point of contact is
 *
 *   k = c + rho,    ball: rho = -R n,    disc: rho = -R m / |m|,  m = n - (n . a) a
 *
 * Position row: n . (k - Q) = 0. Since n . rho has its smallest value there, its rate is n .
 * (v_a(k)
 * - v_b(k)) with the velocities of the points of both bodies at k. All velocity rows are e .
 * (v_a(k)
 * - v_b(k)) with e = n, and e = x, y of the frame. Where all accelerations are zero their
 * derivative is
 *
 *   (w_b x e) . (v_a(k) - v_b(k)) + e . (w_a x (k' - v_a) - w_b x (k' - v_b))
 *
 * with v_a, v_b the velocities of the bodies' origins and k' = v_a(c) + rho' that of the point of
 * contact. */
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/space3.h"

enum { BALL, DISC };                             /* option[0] */
enum { FRAME_A = 0, FRAME_B = 12, RADIUS = 24 }; /* places in param */

typedef struct contact {
    mbsri_end a, b;
    double axis[9];     /* x, y, z = n of frame_b in the world */
    double k[3];        /* the point of contact */
    double rate[3];     /* its velocity */
    double height;      /* n . (k - Q) */
    const double *e[3]; /* directions of the rows */
    int rows;
} contact;

/* In the plane the frame's z axis lies in it, and one of x and y is normal to it. */
static int slip_axis(const mbsr_closure_args *args)
{
    const double *R = args->closure->param + FRAME_B + 3;
    return fabs(R[2]) > 0.5 ? 1 : 0;
}

static int count(const mbsr_closure_args *args, int *rows, int *position_rows)
{
    *position_rows = 1;
    *rows = mbsri_flat(args) ? 2 : 3;
    return MBSR_OK;
}

/* rho and its rate from the axis a of the disc. */
static int lowest(const double n[3], const double a[3], const double ndot[3], const double adot[3],
                  double radius, double rho[3], double rate[3])
{
    const double along = mbsri_dot3(n, a), change = mbsri_dot3(ndot, a) + mbsri_dot3(n, adot);
    double m[3], mdot[3], unit[3];
    for (int k = 0; k < 3; ++k) {
        m[k] = n[k] - along * a[k];
        mdot[k] = ndot[k] - change * a[k] - along * adot[k];
    }
    const double size = mbsri_norm3(m);
    if (!(size > 1e-8)) return MBSR_DEGENERATE_FORCE;
    for (int k = 0; k < 3; ++k) unit[k] = m[k] / size;
    const double inward = mbsri_dot3(unit, mdot);
    for (int k = 0; k < 3; ++k) {
        rho[k] = -radius * unit[k];
        rate[k] = -radius * (mdot[k] - unit[k] * inward) / size;
    }
    return MBSR_OK;
}

static int prepare_contact(const mbsr_closure_args *args, contact *w)
{
    const double *param = args->closure->param, radius = param[RADIUS];
    double arm[3], foot[3], rho[3], rho_dot[3], n_dot[3];
    w->a = mbsri_end_of(args->body);
    w->b = mbsri_end_of(args->body + 1);
    mbsri_multiply3(w->b.R, param + FRAME_B + 3, w->axis);
    const double *n = w->axis + 6;
    mbsri_cross3(w->b.w, n, n_dot);
    for (int k = 0; k < 3; ++k) {
        rho[k] = -radius * n[k];
        rho_dot[k] = -radius * n_dot[k];
    }
    if (args->closure->option[0] == DISC) {
        double a[3], a_dot[3];
        mbsri_rotate3(w->a.R, param + FRAME_A + 9, a);
        mbsri_cross3(w->a.w, a, a_dot);
        const int status = lowest(n, a, n_dot, a_dot, radius, rho, rho_dot);
        if (status) return status;
    }
    mbsri_rotate3(w->a.R, param + FRAME_A, arm);
    mbsri_rotate3(w->b.R, param + FRAME_B, foot);
    mbsri_end_velocity(&w->a, arm, w->rate);
    for (int k = 0; k < 3; ++k) {
        w->k[k] = w->a.r[k] + arm[k] + rho[k];
        w->rate[k] += rho_dot[k];
        foot[k] = w->k[k] - w->b.r[k] - foot[k];
    }
    w->height = mbsri_dot3(n, foot);
    w->rows = mbsri_flat(args) ? 2 : 3;
    w->e[0] = n;
    w->e[1] = w->axis + (w->rows == 2 ? 3 * slip_axis(args) : 0);
    w->e[2] = w->axis + 3;
    return MBSR_OK;
}

static int position(const mbsr_closure_args *args, double *g)
{
    contact w;
    const int status = prepare_contact(args, &w);
    if (!status) g[0] = w.height;
    return status;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    contact w;
    const int status = prepare_contact(args, &w);
    for (int k = 0; k < w.rows && !status; ++k) {
        double arm[3], moment[3], back[3];
        for (int j = 0; j < 3; ++j) arm[j] = w.k[j] - w.a.r[j];
        mbsri_cross3(arm, w.e[k], moment);
        mbsri_end_add(args, 0, moment, w.e[k], k, out);
        for (int j = 0; j < 3; ++j) {
            arm[j] = w.k[j] - w.b.r[j];
            back[j] = -w.e[k][j];
        }
        mbsri_cross3(arm, back, moment);
        mbsri_end_add(args, 1, moment, back, k, out);
    }
    return status;
}

static int drift(const mbsr_closure_args *args, double *gt)
{
    (void)args, (void)gt;
    return MBSR_OK;
}

static int bias(const mbsr_closure_args *args, double *out)
{
    contact w;
    const int status = prepare_contact(args, &w);
    if (status) return status;
    double arm[3], v_a[3], v_b[3], relative[3], turned[3], away[3], by_a[3], by_b[3];
    for (int j = 0; j < 3; ++j) arm[j] = w.k[j] - w.a.r[j];
    mbsri_end_velocity(&w.a, arm, v_a);
    for (int j = 0; j < 3; ++j) arm[j] = w.k[j] - w.b.r[j];
    mbsri_end_velocity(&w.b, arm, v_b);
    for (int j = 0; j < 3; ++j) relative[j] = v_a[j] - v_b[j];
    for (int j = 0; j < 3; ++j) away[j] = w.rate[j] - w.a.v[j];
    mbsri_cross3(w.a.w, away, by_a);
    for (int j = 0; j < 3; ++j) away[j] = w.rate[j] - w.b.v[j];
    mbsri_cross3(w.b.w, away, by_b);
    for (int k = 0; k < w.rows; ++k) {
        mbsri_cross3(w.b.w, w.e[k], turned);
        out[k] = mbsri_dot3(turned, relative) + mbsri_dot3(w.e[k], by_a) - mbsri_dot3(w.e[k], by_b);
    }
    return MBSR_OK;
}

static const char *row(const mbsr_closure_args *args, int k)
{
    static const char *const names[] = {"contact", "slip along x", "slip along y"};
    return names[k == 1 && mbsri_flat(args) ? 1 + slip_axis(args) : k];
}

static int check_fields(const mbsr_closure_def *def, char text[MBSR_TEXT_SIZE])
{
    if (!(def->param[RADIUS] > 0.0))
        return mbsri_refuse(text, MBSR_ERR_VALUE, "radius is %g, must be positive",
                            def->param[RADIUS]);
    if (def->motion) return mbsri_refuse(text, MBSR_ERR_VALUE, "it cannot follow a motion");
    const int status = mbsri_check_frame(def, FRAME_A, "frame_a", text);
    return status ? status : mbsri_check_frame(def, FRAME_B, "frame_b", text);
}

static int check(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_pair(args, text);
    if (status) return status;
    if (!mbsri_flat(args)) return MBSR_OK;
    if (args->closure->option[0] == DISC)
        return mbsri_refuse(text, MBSR_ERR_SPACE,
                            "a disc rolls in space; use "
                            "mbsr_closure_rolling_ball in the plane");
    const double *R = args->closure->param + FRAME_B + 3;
    if (fabs(R[8]) < 1e-9 && fabs(R[3 * slip_axis(args) + 2]) < 1e-9) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE,
                        "for bodies in the plane z of frame_b, and x or y, must lie in it");
}

static int touching(const mbsr_closure_args *args, double x[3])
{
    contact w;
    const int status = prepare_contact(args, &w);
    if (!status) mbsri_copy(3, w.k, x);
    return status;
}

enum { FLAGS = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED };

/* clang-format off */
#define TABLE(kind) {                                                                              \
    .version = MBSR_CLOSURE_TABLE_VERSION, .flags = FLAGS, .name = (kind),                         \
    .position = position, .jacobian = jacobian, .drift = drift, .bias = bias,                      \
    .count = count, .check = check, .check_fields = check_fields, .row = row, .point = touching}
/* clang-format on */
static const mbsr_closure_table tables[] = {TABLE("rolling ball"), TABLE("rolling disc")};

static mbsr_closure_def rolling(int kind, int a, double radius, int b, const mbsr_frame *frame_b)
{
    mbsr_closure_def def = mbsri_stock_closure(tables + kind, a, b);
    def.option[0] = kind;
    mbsri_store_frame(NULL, def.param + FRAME_A);
    mbsri_store_frame(frame_b, def.param + FRAME_B);
    def.param[RADIUS] = radius;
    return def;
}

mbsr_closure_def mbsr_closure_rolling_ball(int a, const double centre[3], double radius, int b,
                                           const mbsr_frame *frame_b)
{
    mbsr_closure_def def = rolling(BALL, a, radius, b, frame_b);
    if (centre) mbsri_copy(3, centre, def.param + FRAME_A);
    return def;
}

mbsr_closure_def mbsr_closure_rolling_disc(int a, const mbsr_frame *frame_a, double radius, int b,
                                           const mbsr_frame *frame_b)
{
    mbsr_closure_def def = rolling(DISC, a, radius, b, frame_b);
    mbsri_store_frame(frame_a, def.param + FRAME_A);
    return def;
}
