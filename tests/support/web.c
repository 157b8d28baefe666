/* Force elements that read all they may: see web.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   s_j = sum over all that is read of c_jk x_k,   f_l = size (b_0l sin s_0 + b_1l cos s_1) */
#include "web.h"

#include <math.h>
#include <string.h>

enum { SUMS = 2 };

/* What is read or written of a body. */
enum { POSE, RATE, COORDINATE, SPEED, FORCE, TORQUE };

static double weight(int sum, int body, int part, int k)
{
    return 0.5 * cos(1.0 + 2.3 * sum + 1.7 * body + 3.1 * part + 0.9 * k);
}

static int has(const mbsr_force_args *args, int part)
{
    const unsigned flags = args->force->table->flags;
    const int joint = part == COORDINATE || part == SPEED || part == TORQUE;
    return joint ? !(flags & MBSR_FORCE_NO_JOINT) : !(flags & MBSR_FORCE_JOINT_ONLY);
}

static double dot(int sum, int body, int part, int count, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < count; ++k) value += weight(sum, body, part, k) * x[k];
    return value;
}

static void sums(const mbsr_force_args *args, double s[SUMS])
{
    for (int j = 0; j < SUMS; ++j) {
        s[j] = 0.0;
        for (int k = 0; k < args->bodies; ++k) {
            const mbsr_force_body *b = args->body + k;
            const int still = b->space == MBSR_SPACE_FIXED;
            if (has(args, POSE) && !still) {
                s[j] += dot(j, k, POSE, b->np, b->p);
                s[j] += dot(j, k, RATE, b->d, b->V);
            }
            if (has(args, SPEED) && b->id != MBSR_GROUND) {
                s[j] += dot(j, k, COORDINATE, b->nq, b->q);
                s[j] += dot(j, k, SPEED, b->n, b->u);
            }
        }
    }
}

/* Adds value[j] times the direction of sum j to the forces on body k. */
static void act(const mbsr_force_args *args, int k, const double value[SUMS], double *f,
                double *tau)
{
    const mbsr_force_body *b = args->body + k;
    for (int j = 0; j < SUMS; ++j) {
        const double size = args->force->param[0] * value[j];
        for (int l = 0; l < b->d && has(args, FORCE); ++l) f[l] += size * weight(j, k, FORCE, l);
        for (int l = 0; l < b->n && has(args, TORQUE); ++l)
            tau[l] += size * weight(j, k, TORQUE, l);
    }
}

static int evaluate(const mbsr_force_args *args)
{
    double s[SUMS];
    sums(args, s);
    const double value[SUMS] = {sin(s[0]), cos(s[1])};
    for (int k = 0; k < args->bodies; ++k) {
        if (args->body[k].id != MBSR_GROUND)
            act(args, k, value, args->body[k].f, args->body[k].tau);
    }
    return 0;
}

/* ds_j along number c of the pose of body k. */
static double pose_weight(const mbsr_force_args *args, int j, int k, int c)
{
    const mbsr_force_body *b = args->body + k;
    if (b->space != MBSR_SPACE_SPATIAL) return weight(j, k, POSE, c);
    if (c >= 3) return weight(j, k, POSE, MBSR_POSE_X + c - 3);
    /* the columns of R turn by e_c */
    const int x = (c + 1) % 3, y = (c + 2) % 3;
    double value = 0.0;
    for (int l = 0; l < 9; l += 3) {
        value += weight(j, k, POSE, l + y) * b->p[l + x];
        value -= weight(j, k, POSE, l + x) * b->p[l + y];
    }
    return value;
}

static void add_column(const mbsr_force_args *args, const mbsr_force_derivatives *out,
                       const double s[SUMS], int column, const double ds[SUMS])
{
    const double value[SUMS] = {cos(s[0]) * ds[0], -sin(s[1]) * ds[1]};
    double *at = out->matrix + column * out->rows;
    for (int k = 0; k < args->bodies; ++k) {
        if (out->row[k] >= 0)
            act(args, k, value, at + out->row[k], at + out->row[k] + args->body[k].d);
    }
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    double s[SUMS];
    sums(args, s);
    for (int k = 0; k < args->bodies; ++k) {
        const mbsr_force_body *b = args->body + k;
        const int pose = b->space == MBSR_SPACE_SPATIAL ? 6 : b->np;
        const int count[] = {pose, b->d, b->nq, b->n};
        int column = out->column[k];
        if (column < 0) continue;
        for (int part = POSE; part <= SPEED; ++part) {
            for (int c = 0; c < count[part]; ++c, ++column) {
                double ds[SUMS];
                if (!has(args, part)) continue;
                for (int j = 0; j < SUMS; ++j)
                    ds[j] = part == POSE ? pose_weight(args, j, k, c) : weight(j, k, part, c);
                add_column(args, out, s, column, ds);
            }
        }
    }
    return 0;
}

#define TABLE(kind, own)                                                                           \
    {                                                                                              \
        .version = MBSR_FORCE_TABLE_VERSION, .flags = MBSR_FORCE_NO_MASS | (kind), .name = "web",  \
        .evaluate = evaluate, .derivatives = (own)                                                 \
    }

static const mbsr_force_table tables[TEST_WEB_KINDS][2] = {
    {TABLE(0, NULL), TABLE(0, derivatives)},
    {TABLE(MBSR_FORCE_JOINT_ONLY, NULL), TABLE(MBSR_FORCE_JOINT_ONLY, derivatives)},
    {TABLE(MBSR_FORCE_NO_JOINT, NULL), TABLE(MBSR_FORCE_NO_JOINT, derivatives)}};

static const mbsr_force_table everywhere[2] = {TABLE(MBSR_FORCE_EVERY_BODY, NULL),
                                               TABLE(MBSR_FORCE_EVERY_BODY, derivatives)};

mbsr_force_def test_web(test_web_kind kind, int bodies, const int *body, double size,
                        int with_derivatives)
{
    mbsr_force_def def =
        mbsr_force_custom(&tables[kind][with_derivatives != 0], bodies, body, NULL);
    def.param[0] = size;
    return def;
}

mbsr_force_def test_web_everywhere(double size, int with_derivatives)
{
    mbsr_force_def def = mbsr_force_custom(&everywhere[with_derivatives != 0], 0, NULL, NULL);
    def.param[0] = size;
    return def;
}
