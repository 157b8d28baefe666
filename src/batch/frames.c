/* Frames of the bodies of a batch: two rotations by constants and one by the coordinate from each
 * to the next.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "batch/frames.h"

#include <math.h>
#include <string.h>

/* ---- rotations by an angle: cosine and sine ---- */

static void set_angle(double c, double s, double a[2])
{
    const double length = hypot(c, s);
    a[0] = length > 0.0 ? c / length : 1.0;
    a[1] = length > 0.0 ? s / length : 0.0;
}

/* c = a + sign b, as angles; c may be a or b. */
static void add_angles(const double a[2], double sign, const double b[2], double c[2])
{
    set_angle(a[0] * b[0] - sign * a[1] * b[1], a[1] * b[0] + sign * a[0] * b[1], c);
}

static bool is_turn(const double a[2])
{
    return !(a[0] == 1.0 && a[1] == 0.0);
}

/* With the products of record.h. */
static void set_turn(const double a[2], double turn[5])
{
    const double c = a[0], s = a[1];
    turn[0] = c, turn[1] = s, turn[2] = c * c, turn[3] = s * s, turn[4] = s * c;
}

/* x <- Rz(-a) x */
static void turn_back(const double a[2], double *x, double *y)
{
    const double c = a[0], s = a[1], from = *x;
    *x = c * from + s * *y;
    *y = c * *y - s * from;
}

/* ---- one body ---- */

/* A = Rz(beta) Rx(alpha) Rz(gamma), columns of four numbers; alpha in 0 .. pi. */
static void take_angles(const double A[12], double beta[2], double alpha[2], double gamma[2])
{
    const double *x = A, *y = A + 4, *z = A + 8;
    set_angle(-z[1], z[0], beta); /* 0 where there is no tilt */
    set_angle(z[2], hypot(z[0], z[1]), alpha);
    set_angle(beta[0] * x[0] + beta[1] * x[1], -(beta[0] * y[0] + beta[1] * y[1]), gamma);
}

void mbsri_batch_take(const mbsri_sweep_body *from, int parent, mbsri_batch_body *b)
{
    const double *I = from->I;
    const int own = MBSRI_TURNS | MBSRI_SLIDES | MBSRI_MASSLESS | MBSRI_LEAF | MBSRI_BRANCHES |
                    MBSRI_NEXT | MBSRI_OPENS | MBSRI_LOADED | MBSRI_PLANE | MBSRI_FLAT |
                    MBSRI_LEVEL | MBSRI_BLOCK | MBSRI_TO_BLOCK | MBSRI_BALL | MBSRI_HERE |
                    MBSRI_MOVED | MBSRI_SEEN;
    double alpha[2];
    *b = (mbsri_batch_body){.base = {1.0, 0.0},
                            .own = {1.0, 0.0},
                            .x = {from->x[0], from->x[1], from->x[2]},
                            .I = {I[0], I[5], I[10], I[4], I[8], I[9]},
                            .c = {from->c[0], from->c[1], from->c[2]},
                            .mass = from->c[3],
                            .pitch = from->pitch,
                            .soft = from->soft,
                            .spread = from->spread,
                            .armature = from->armature,
                            .parent = parent,
                            .flags = from->flags & own,
                            .q = from->q,
                            .u = from->u,
                            .n = from->n};
    if (b->flags & MBSRI_BLOCK) return;
    take_angles(from->A, b->twist, alpha, b->base);
    set_turn(alpha, b->tilt);
    if (is_turn(alpha)) b->flags |= MBSRI_TILTED;
    const int kind = b->flags & (MBSRI_TURNS | MBSRI_SLIDES | MBSRI_MOVED);
    if (kind == MBSRI_TURNS && !(b->armature > 0.0)) b->flags |= MBSRI_HINGE;
    if (b->flags & MBSRI_BALL) b->flags &= ~(MBSRI_FLAT | MBSRI_LEVEL);
}

/* ---- all of them ---- */

/* By how much the frame of body i turns, about z. */
static void choose_turn(int bodies, const mbsri_batch_body *body, int i, double own[2])
{
    const mbsri_batch_body *b = body + i;
    const bool followed = i < bodies && body[i + 1].parent == i;
    own[0] = 1.0, own[1] = 0.0;
    if (i == 0 || b->flags & (MBSRI_BLOCK | MBSRI_BALL)) return;
    if (!(b->flags & MBSRI_TURNS))
        own[0] = b->base[0], own[1] = -b->base[1];
    else if (followed && !(body[i + 1].flags & MBSRI_BLOCK))
        own[0] = body[i + 1].twist[0], own[1] = body[i + 1].twist[1];
}

/* The constants in the turned frame. */
static void turn_own(mbsri_batch_body *b)
{
    double *I = b->I;
    const double c = b->own[0], s = b->own[1], xx = I[0], yy = I[1], xy = I[3];
    I[0] = c * c * xx + 2.0 * s * c * xy + s * s * yy;
    I[1] = s * s * xx - 2.0 * s * c * xy + c * c * yy;
    I[3] = s * c * (yy - xx) + (c * c - s * s) * xy;
    turn_back(b->own, I + 4, I + 5);
    turn_back(b->own, b->c, b->c + 1);
}

/* How it stands on the predecessor, whose frame has been turned. */
static void turn_joint(const mbsri_batch_body *pred, mbsri_batch_body *b)
{
    double twist[2];
    add_angles(b->twist, -1.0, pred->own, twist);
    if (memcmp(b->twist, pred->own, sizeof twist) == 0) twist[0] = 1.0, twist[1] = 0.0;
    set_turn(twist, b->twist);
    if (is_turn(twist)) b->flags |= MBSRI_TWISTED;
    turn_back(pred->own, b->x, b->x + 1);
    if (b->flags & MBSRI_BALL) return;
    add_angles(b->base, 1.0, b->own, b->base);
    b->offset = b->flags & MBSRI_TURNS ? atan2(b->base[1], b->base[0]) : 0.0;
}

/* In the plane: which axis is the normal, as frames of slides have it; else the body counts as one
 * in space, whose bound is larger. */
static void find_normal(const mbsri_batch_body *pred, mbsri_batch_body *b)
{
    double n[3] = {pred->normal[0], pred->normal[1], pred->normal[2]};
    memset(b->normal, 0, sizeof b->normal);
    b->normal[2] = 1.0;
    if (!(b->flags & MBSRI_LEVEL) || b->flags & MBSRI_BLOCK) return;
    turn_back(b->twist, n, n + 1);
    turn_back(b->tilt, n + 1, n + 2);
    bool level = pred->flags & MBSRI_LEVEL || b->parent == 0, along = false;
    for (int k = 0; k < 3; ++k) {
        b->normal[k] = fabs(n[k]) > 1.0 - 1e-12;
        along = along || b->normal[k] > 0.0;
    }
    level = level && along && !(b->flags & MBSRI_TURNS && b->normal[2] == 0.0);
    if (!level) b->flags &= ~MBSRI_LEVEL;
}

void mbsri_batch_align(int bodies, mbsri_batch_body *body)
{
    body->normal[2] = 1.0;
    for (int i = 1; i <= bodies; ++i) {
        mbsri_batch_body *b = body + i;
        const mbsri_batch_body *pred = body + b->parent;
        choose_turn(bodies, body, i, b->own);
        if (!(b->flags & MBSRI_BLOCK)) {
            turn_own(b);
            turn_joint(pred, b);
        }
        find_normal(pred, b);
    }
}
