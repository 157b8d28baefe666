/* How points of contact move with the bodies: see touch.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With w = pa - pb = s n, material velocities va at pa and vb at pb, and angular velocities: the
 * distance changes by n . (va - vb) for all features, since w is normal to whatever the points
 * slide along. What the points slide follows from w staying normal to it, w . t = 0, for every
 * direction t that turns with its body. */
#include "contact/touch.h"

#include "algebra/space3.h"
#include "contact/round.h"

#include <string.h>

/* dn and dpa; then dpb follows. */
typedef struct change {
    double n[3], pa[3], s, weight;
} change;

static void difference_of(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k) c[k] = a[k] - b[k];
}

/* n follows from w: dn = (dw - n ds) / s */
static void turn_normal(const mbsri_touch *t, const double dw[3], change *c)
{
    if (!(t->s > 0.0)) return;
    for (int k = 0; k < 3; ++k) c->n[k] = (dw[k] - t->n[k] * c->s) / t->s;
}

static void point_line(const mbsri_touch *t, const mbsri_motion *by, const double between[3],
                       change *c)
{
    double turned[3], across[3], dw[3] = {0.0, 0.0, 0.0}, w[3];
    difference_of(t->pa, t->pb, w);
    mbsri_cross3(by->wb, t->tb, turned);
    mbsri_cross3(t->n, t->tb, across);
    mbsri_add3(c->s, t->n, dw);
    mbsri_add3(-mbsri_dot3(w, turned), t->tb, dw);
    mbsri_add3(mbsri_dot3(across, between), across, dw);
    memcpy(c->pa, by->va, sizeof c->pa);
    turn_normal(t, dw, c);
}

/* 6 x - 6 x^2 of the fade, by the place along the edge. */
static double fade_slope(double u, double length, double width, double *fade)
{
    const double end = fmin(u, 1.0 - u) * length / width;
    *fade = end >= 1.0 ? 1.0 : end * end * (3.0 - 2.0 * end);
    if (end >= 1.0) return 0.0;
    return 6.0 * end * (1.0 - end) * length / width * (u < 0.5 ? 1.0 : -1.0);
}

/* The change of the weight of edges as the normal turns by dn, and the faces with their bodies. */
static double turn_sides(const mbsri_touch *t, const mbsri_motion *by, const double dn[3],
                         const double slopes[4])
{
    double sum = 0.0;
    for (int k = 0; k < 2; ++k) {
        double into_a[3], into_b[3];
        mbsri_cross3(by->wa, t->into_a[k], into_a);
        mbsri_cross3(by->wb, t->into_b[k], into_b);
        sum -= slopes[k] * (mbsri_dot3(dn, t->into_a[k]) + mbsri_dot3(t->n, into_a));
        sum += slopes[2 + k] * (mbsri_dot3(dn, t->into_b[k]) + mbsri_dot3(t->n, into_b));
    }
    return sum;
}

/* The change of the height of one point over a face of the other core. */
static double rise(const mbsri_touch *t, const mbsri_motion *by, const change *c)
{
    double along[3], arm[3], carried[3];
    const double sign = t->out_of_a ? 1.0 : -1.0;
    for (int k = 0; k < 3; ++k) {
        along[k] = c->pa[k] - (t->out_of_a ? c->s * t->n[k] + t->s * c->n[k] : 0.0);
        arm[k] = -sign * t->s * t->n[k];
        carried[k] = t->out_of_a ? by->va[k] : by->vb[k];
    }
    mbsri_add_cross3(t->out_of_a ? by->wa : by->wb, arm, carried);
    return mbsri_dot3(t->out, along) - mbsri_dot3(t->out, carried);
}

static void line_line(const mbsri_touch *t, const mbsri_motion *by, const double between[3],
                      change *c)
{
    const double g = mbsri_dot3(t->ta, t->tb), sine = 1.0 - g * g, root = sqrt(sine);
    double ta[3], tb[3], product[3], cross[3], e[3], fa, fb;
    mbsri_cross3(by->wa, t->ta, ta);
    mbsri_cross3(by->wb, t->tb, tb);
    mbsri_cross3(ta, t->tb, product);
    mbsri_add_cross3(t->ta, tb, product);
    mbsri_cross3(t->ta, t->tb, cross);
    const double sign = mbsri_dot3(cross, t->n) < 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 3; ++k) c->n[k] = sign * product[k] / root;
    mbsri_add3(-mbsri_dot3(c->n, t->n), t->n, c->n);
    for (int k = 0; k < 3; ++k) e[k] = c->s * t->n[k] + t->s * c->n[k] - between[k];
    const double x = mbsri_dot3(e, t->ta), y = mbsri_dot3(e, t->tb), a = (x - g * y) / sine,
                 b = (g * x - y) / sine;
    memcpy(c->pa, by->va, sizeof c->pa);
    mbsri_add3(a, t->ta, c->pa);
    const double of_a = fade_slope(t->ua, t->la, t->window, &fa),
                 of_b = fade_slope(t->ub, t->lb, t->window, &fb),
                 dg = mbsri_dot3(ta, t->tb) + mbsri_dot3(t->ta, tb);
    double part[6];
    const double rest = mbsri_edges_weight(t, part),
                 ends = -2.0 * g * dg * fa * fb +
                        sine * (of_a * a / t->la * fb + fa * of_b * b / t->lb);
    c->weight = ends * rest +
                sine * fa * fb *
                    (turn_sides(t, by, c->n, part) + part[4] * c->s + part[5] * rise(t, by, c));
}

/* pb = middle + radius e, e along what of pa - middle is normal to the axis. */
static void point_circle(const mbsri_touch *t, const mbsri_motion *by, change *c)
{
    double d[3], middle[3], arm[3], axis[3], e[3], de[3], dw[3];
    difference_of(t->pa, t->tb, d);
    difference_of(t->tb, t->pb, arm);
    memcpy(middle, by->vb, sizeof middle);
    mbsri_add_cross3(by->wb, arm, middle);
    mbsri_cross3(by->wb, t->ta, axis);
    const double h = mbsri_dot3(t->ta, d);
    for (int k = 0; k < 3; ++k) e[k] = d[k] - h * t->ta[k];
    const double rho = mbsri_norm3(e);
    double dd[3];
    difference_of(by->va, middle, dd);
    const double dh = mbsri_dot3(axis, d) + mbsri_dot3(t->ta, dd);
    for (int k = 0; k < 3; ++k) {
        e[k] /= rho;
        de[k] = dd[k] - dh * t->ta[k] - h * axis[k];
    }
    const double along = mbsri_dot3(e, de);
    for (int k = 0; k < 3; ++k) {
        de[k] = (de[k] - along * e[k]) / rho;
        dw[k] = by->va[k] - middle[k] - t->half[0] * de[k];
    }
    memcpy(c->pa, by->va, sizeof c->pa);
    turn_normal(t, dw, c);
}

/* pa = middle + radius e, e along q = (n . axis) axis - n */
static void rim_plane(const mbsri_touch *t, const mbsri_motion *by, change *c)
{
    double axis[3], q[3], dq[3], arm[3], e[3];
    mbsri_cross3(by->wa, t->ta, axis);
    const double cosine = mbsri_dot3(t->n, t->ta),
                 slope = mbsri_dot3(c->n, t->ta) + mbsri_dot3(t->n, axis);
    for (int k = 0; k < 3; ++k) {
        q[k] = cosine * t->ta[k] - t->n[k];
        dq[k] = slope * t->ta[k] + cosine * axis[k] - c->n[k];
    }
    const double size = mbsri_norm3(q);
    for (int k = 0; k < 3; ++k) e[k] = q[k] / size;
    const double along = mbsri_dot3(e, dq);
    difference_of(t->tb, t->pa, arm);
    memcpy(c->pa, by->va, sizeof c->pa); /* of the middle: */
    mbsri_add_cross3(by->wa, arm, c->pa);
    for (int k = 0; k < 3; ++k) c->pa[k] += t->half[0] * (dq[k] - along * e[k]) / size;
}

/* In the axes of the ellipsoid p = S^2 m / root(m S^2 m), m = -n, which turns by wb - wa. */
static void ellipsoid_plane(const mbsri_touch *t, const mbsri_motion *by, change *c)
{
    double turn[3], dm[3], m[3], local[3], moved[3], out[3], size = 0.0, along = 0.0;
    difference_of(by->wb, by->wa, turn);
    mbsri_cross3(turn, t->n, dm);
    mbsri_unrotate3(t->Ra, dm, local);
    mbsri_unrotate3(t->Ra, t->n, m);
    for (int k = 0; k < 3; ++k) {
        m[k] = -m[k];
        local[k] = -local[k];
        size += t->half[k] * t->half[k] * m[k] * m[k];
        along += t->half[k] * t->half[k] * m[k] * local[k];
    }
    const double root = sqrt(size);
    for (int k = 0; k < 3; ++k)
        moved[k] = t->half[k] * t->half[k] * (local[k] - m[k] * along / size) / root;
    mbsri_rotate3(t->Ra, moved, out);
    for (int k = 0; k < 3; ++k) c->pa[k] = by->va[k] + out[k];
}

/* pa - pb = s n stays so, while pa moves by va - Ka (dn - wa x n), and pb by vb + Kb (dn - wb x n)
 * or along its line. */
static void ellipsoid_over(const mbsri_touch *t, const mbsri_motion *by, const double between[3],
                           change *c)
{
    double K[9], Kb[9] = {0.0}, at[3], turn[3], right[3], bent[3];
    mbsri_support_ellipsoid(t->half, t->Ra, t->n, at, K);
    mbsri_cross3(by->wa, t->n, turn);
    mbsri_rotate3(K, turn, right); /* symmetric */
    mbsri_add3(1.0, between, right);
    if (t->features == MBSRI_ELLIPSOID_LINE) {
        double line[3], across[3];
        mbsri_cross3(by->wb, t->tb, line);
        mbsri_cross3(t->n, t->tb, across);
        const double along = -mbsri_dot3(t->n, line);
        mbsri_rotate3(K, across, bent);
        const double stiff = mbsri_dot3(across, bent) + t->s,
                     x = (mbsri_dot3(across, right) - along * mbsri_dot3(bent, t->tb)) / stiff;
        mbsri_add3(along, t->tb, c->n);
        mbsri_add3(x, across, c->n);
    } else {
        double sum[9];
        if (t->features == MBSRI_ELLIPSOID_ELLIPSOID) {
            double other[3], more[3];
            mbsri_support_ellipsoid(t->half_b, t->Rb, t->n, at, Kb);
            mbsri_cross3(by->wb, t->n, other);
            mbsri_rotate3(Kb, other, more);
            mbsri_add3(1.0, more, right);
        }
        for (int k = 0; k < 9; ++k) sum[k] = K[k] + Kb[k];
        mbsri_solve_across(sum, t->s, t->n, right, c->n);
    }
    for (int k = 0; k < 3; ++k) turn[k] = c->n[k] - turn[k];
    mbsri_rotate3(K, turn, bent);
    memcpy(c->pa, by->va, sizeof c->pa);
    mbsri_add3(-1.0, bent, c->pa);
}

/* pb = what its body carries it along + q in the surface, and n turns by C q; pa moves by
 * va - Ka (dn - wa x n), which for a point is va. */
static void over_surface(const mbsri_touch *t, const mbsri_motion *by, const double between[3],
                         change *c)
{
    double K[9] = {0.0}, at[3], own[3], carried[3], turn[3], right[3], e[2][3], A[2][2], b[2];
    mbsri_cross3(by->wa, t->n, own);
    mbsri_cross3(by->wb, t->n, carried);
    if (t->features == MBSRI_ELLIPSOID_SURFACE)
        mbsri_support_ellipsoid(t->half, t->Ra, t->n, at, K);
    difference_of(carried, own, turn);
    mbsri_rotate3(K, turn, right);
    for (int k = 0; k < 3; ++k) right[k] = between[k] - right[k] - t->s * carried[k];
    const double axis[3] = {fabs(t->n[0]) < 0.6, fabs(t->n[0]) >= 0.6, 0.0};
    mbsri_cross3(t->n, axis, e[0]);
    (void)mbsri_direction3(e[0], e[0]);
    mbsri_cross3(t->n, e[0], e[1]);
    for (int j = 0; j < 2; ++j) {
        double bent[3], moved[3];
        mbsri_rotate3(t->Rb, e[j], bent);
        mbsri_rotate3(K, bent, moved);
        mbsri_add3(t->s, bent, moved);
        mbsri_add3(1.0, e[j], moved);
        for (int i = 0; i < 2; ++i) A[i][j] = mbsri_dot3(e[i], moved);
        b[j] = mbsri_dot3(e[j], right);
    }
    const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0],
                 x = (A[1][1] * b[0] - A[0][1] * b[1]) / det,
                 y = (A[0][0] * b[1] - A[1][0] * b[0]) / det;
    double q[3] = {0.0, 0.0, 0.0}, bent[3];
    mbsri_add3(x, e[0], q);
    mbsri_add3(y, e[1], q);
    mbsri_rotate3(t->Rb, q, bent);
    for (int k = 0; k < 3; ++k) {
        c->n[k] = carried[k] + bent[k];
        turn[k] = c->n[k] - own[k];
    }
    mbsri_rotate3(K, turn, bent);
    memcpy(c->pa, by->va, sizeof c->pa);
    mbsri_add3(-1.0, bent, c->pa);
    c->weight = t->by_distance * c->s + mbsri_dot3(t->by_place, q);
}

void mbsri_touch_moves(const mbsri_touch *t, const mbsri_motion *by, mbsri_touch_change *moved)
{
    change c = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.0, 0.0};
    double between[3];
    difference_of(by->va, by->vb, between);
    c.s = mbsri_dot3(t->n, between);
    switch (t->features) {
    case MBSRI_POINT_PLANE:
        mbsri_cross3(by->wb, t->n, c.n);
        memcpy(c.pa, by->va, sizeof c.pa);
        break;
    case MBSRI_POINT_POINT:
        memcpy(c.pa, by->va, sizeof c.pa);
        turn_normal(t, between, &c);
        break;
    case MBSRI_POINT_LINE: point_line(t, by, between, &c); break;
    case MBSRI_LINE_LINE: line_line(t, by, between, &c); break;
    case MBSRI_POINT_CIRCLE: point_circle(t, by, &c); break;
    case MBSRI_RIM_PLANE:
        mbsri_cross3(by->wb, t->n, c.n);
        rim_plane(t, by, &c);
        break;
    case MBSRI_ELLIPSOID_PLANE:
        mbsri_cross3(by->wb, t->n, c.n);
        ellipsoid_plane(t, by, &c);
        break;
    case MBSRI_ELLIPSOID_LINE:
    case MBSRI_ELLIPSOID_POINT:
    case MBSRI_ELLIPSOID_ELLIPSOID: ellipsoid_over(t, by, between, &c); break;
    case MBSRI_POINT_SURFACE:
    case MBSRI_ELLIPSOID_SURFACE: over_surface(t, by, between, &c); break;
    }
    /* p = pa - s n / 2 + (rb - ra) n / 2 */
    const double half = 0.5 * (t->rb - t->ra - t->s);
    for (int k = 0; k < 3; ++k) {
        moved->n[k] = c.n[k];
        moved->p[k] = c.pa[k] - 0.5 * c.s * t->n[k] + half * c.n[k];
    }
    mbsri_cross3(by->wa, t->ta, moved->axis);
    moved->cosine = mbsri_dot3(c.n, t->ta) + mbsri_dot3(t->n, moved->axis);
    moved->depth = -c.s;
    moved->weight = c.weight + t->by_cosine * moved->cosine;
}
