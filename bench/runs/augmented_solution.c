/* The right side of a Newton system in sparse augmented form, and what its solution says of y: see
 * augmented.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "augmented.h"

#include <string.h>

/* The product of quaternions a b^-1, or a b. */
static void quaternions(const double a[4], const double b[4], int divide, double c[4])
{
    const double square = b[0] * b[0] + b[1] * b[1] + b[2] * b[2] + b[3] * b[3],
                 sign = divide ? -1.0 : 1.0;
    const double d[4] = {b[0], sign * b[1], sign * b[2], sign * b[3]};
    c[0] = a[0] * d[0] - a[1] * d[1] - a[2] * d[2] - a[3] * d[3];
    for (int k = 1; k < 4; ++k) {
        const int l = k % 3 + 1, m = l % 3 + 1;
        c[k] = a[0] * d[k] + a[k] * d[0] + a[l] * d[m] - a[m] * d[l];
    }
    for (int k = 0; k < 4 && divide; ++k) c[k] /= square;
}

/* What r_q adds to theta: r_q / c of an axis; of a quaternion, with r_q q^-1 = (a, b), that of 2 b
 * + u a / c. */
static void take_coordinates(const augmented *s, const linear_body *b, const double *r, double *to)
{
    const double *q = s->y + b->q, *u = s->u + b->u;
    double turned[4], right[3];
    if (!b->free) {
        for (int k = 0; k < b->axes; ++k) to[k] = r[k] / s->c;
        return;
    }
    quaternions(r, q, 1, turned);
    for (int k = 0; k < 3; ++k) right[k] = 2.0 * turned[1 + k] + u[k] * turned[0] / s->c;
    for (int k = 0; k < 3; ++k) {
        to[k] = 0.0;
        for (int l = 0; l < 3; ++l) to[k] += b->theta[6 * k + l] * right[l];
        to[3 + k] = r[4 + k] / s->c;
    }
}

/* w = L times the range part of r_u, leaves to root. */
static void take_momenta(augmented *s, const double *r_u)
{
    const int bodies = s->linear.stiff->bodies;
    memset(s->passed, 0, 6 * (size_t)bodies * sizeof *s->passed);
    for (int i = bodies - 1; i >= 0; --i) {
        const linear_body *b = s->linear.body + i;
        const double *from = s->passed + 6 * i;
        double *to = b->parent >= 0 ? s->passed + 6 * b->parent : NULL;
        for (int r = 0; r < 6 && to; ++r) to[r] += from[r];
        for (int k = 0; k < b->axes; ++k) {
            double kept = 0.0;
            for (int l = 0; l < b->axes; ++l) kept += b->kept[b->axes * k + l] * r_u[b->u + l];
            s->w[b->u + k] = kept + linear_dot(b->axis[k].S, from);
            for (int r = 0; r < 6 && to; ++r) to[r] += kept * b->gain[6 * k + r];
        }
    }
}

/* The rows of joint i. */
static void take_joint(const augmented *s, int i, const double *r_p, const double *r_u,
                       double *right)
{
    const linear_body *b = s->linear.body + i;
    double *to = right + augmented_place(s, i, AUGMENTED_RATES), row[LINEAR_RATES];
    for (int k = 0; k < b->axes; ++k) row[k] = r_p[b->u + k] + s->c * s->w[b->u + k];
    for (int j = 0; j < b->axes; ++j) {
        if (b->rank == b->axes) to[j] += row[j];
        for (int k = 0; k < b->axes && b->rank < b->axes; ++k)
            to[j] += j < b->rank ? b->range[6 * j + k] * row[k]
                                 : b->null[6 * (j - b->rank) + k] * r_u[b->u + k];
    }
}

static void six(const augmented *s, const double *from, int i, int kind, double x[6])
{
    memset(x, 0, 6 * sizeof *x);
    for (int k = 0; k < s->dim; ++k) x[s->part[k]] = from[augmented_place(s, i, kind) + k];
}

/* delta p of joint i: delta (M u) - w, and in the null space of D by the rows of p. */
static void give_momenta(const augmented *s, int i, const double *x, const double *r_p,
                         double *delta)
{
    const linear_body *b = s->linear.body + i;
    const double *du = x + augmented_place(s, i, AUGMENTED_RATES), *theta = s->theta + b->u;
    double momentum[LINEAR_RATES], by_rows[LINEAR_RATES], chi_i[6], phi_i[6], nu_i[6];
    six(s, x, i, AUGMENTED_CHI, chi_i), six(s, x, i, AUGMENTED_PHI, phi_i),
        six(s, x, i, AUGMENTED_NU, nu_i);
    for (int k = 0; k < b->axes; ++k) {
        const linear_axis *a = b->axis + k;
        double chi[6], phi[6], nu[6], turned[6];
        memcpy(chi, chi_i, sizeof chi), memcpy(phi, phi_i, sizeof phi), memcpy(nu, nu_i, sizeof nu);
        for (int l = 0; l < b->axes; ++l) {
            if (!(a->after & 1u << l)) continue;
            linear_cross_force(b->axis[l].S, b->h, turned);
            for (int r = 0; r < 6; ++r) chi[r] += theta[l] * turned[r];
            linear_cross_force(b->axis[l].S, b->F, turned);
            for (int r = 0; r < 6; ++r) phi[r] += theta[l] * turned[r];
            for (int r = 0; r < 6; ++r)
                nu[r] -= du[l] * b->axis[l].S[r] + theta[l] * b->axis[l].twist[r];
        }
        linear_cross_force(a->S, b->h, turned);
        const double psi = linear_dot(a->S, phi) + linear_dot(a->rate, chi) +
                           linear_dot(nu, turned) - a->stiffness * theta[k] - a->damping * du[k];
        momentum[k] = linear_dot(a->S, chi) - s->w[b->u + k];
        by_rows[k] = (psi + r_p[b->u + k]) / s->c;
    }
    for (int k = 0; k < b->axes; ++k) {
        delta[b->u + k] = by_rows[k];
        for (int l = 0; l < b->axes; ++l)
            delta[b->u + k] += b->kept[b->axes * k + l] * (momentum[l] - by_rows[l]);
    }
}

static void give_coordinates(const augmented *s, const linear_body *b, const double *r,
                             double *delta)
{
    const double *q = s->y + b->q, *u = s->u + b->u, *theta = s->theta + b->u;
    if (!b->free) {
        memcpy(delta, theta, (size_t)b->axes * sizeof *delta);
        return;
    }
    double turned[4], half[4] = {0.0, 0.5 * theta[0], 0.5 * theta[1], 0.5 * theta[2]};
    quaternions(r, q, 1, turned);
    half[0] = (turned[0] - 0.5 * (u[0] * half[1] + u[1] * half[2] + u[2] * half[3])) / s->c;
    quaternions(half, q, 0, delta);
    memcpy(delta + 4, theta + 3, 3 * sizeof *delta);
}

void augmented_right(augmented *s, const double *r, double *right)
{
    const int bodies = s->linear.stiff->bodies;
    const double *r_p = r + mbsr_model_nq(s->model), *r_u = r_p + mbsr_model_nu(s->model);
    memset(right, 0, (size_t)s->size * sizeof *right);
    for (int i = 0; i < bodies; ++i) {
        const linear_body *b = s->linear.body + i;
        take_coordinates(s, b, r + b->q, s->theta + b->u);
    }
    take_momenta(s, r_u);
    for (long k = 0; k < s->shares.count; ++k) {
        const augmented_entry *e = s->shares.at + k;
        right[e->row] -= e->value * s->theta[e->column];
    }
    for (int i = 0; i < bodies; ++i) take_joint(s, i, r_p, r_u, right);
}

void augmented_delta(augmented *s, const double *r, const double *x, double *delta)
{
    const int nq = mbsr_model_nq(s->model), nu = mbsr_model_nu(s->model);
    for (int i = 0; i < s->linear.stiff->bodies; ++i) {
        const linear_body *b = s->linear.body + i;
        const double *du = x + augmented_place(s, i, AUGMENTED_RATES);
        memcpy(delta + nq + nu + b->u, du, (size_t)b->axes * sizeof *du);
        for (int k = 0; k < b->axes; ++k) {
            for (int l = 0; l < b->axes; ++l) s->theta[b->u + k] += b->theta[6 * k + l] * du[l];
        }
        give_coordinates(s, b, r + b->q, delta + b->q);
        give_momenta(s, i, x, r + nq, delta + nq);
    }
}
