/* A stiff tree linearised at a state: see linear.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "linear.h"

#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void dsyev_(const char *job, const char *half, const int *n, double *A, const int *lda,
            double *lambda, double *work, const int *lwork, int *info, size_t, size_t);

/* ---- vectors ---- */

static void cross(const double a[3], const double b[3], double c[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
                 z = a[0] * b[1] - a[1] * b[0];
    c[0] = x, c[1] = y, c[2] = z;
}

static void add(double s, const double *x, int n, double *y)
{
    for (int k = 0; k < n; ++k) y[k] += s * x[k];
}

static void times(const double A[9], const double x[3], double y[3]) /* rows */
{
    for (int i = 0; i < 3; ++i) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

static void times6(const double A[36], const double x[6], double y[6])
{
    for (int i = 0; i < 6; ++i) {
        y[i] = 0.0;
        for (int k = 0; k < 6; ++k) y[i] += A[6 * i + k] * x[k];
    }
}

void linear_cross(const double X[6], const double Y[6], double Z[6])
{
    double other[3];
    cross(X, Y, Z);
    cross(X, Y + 3, Z + 3);
    cross(X + 3, Y, other);
    add(1.0, other, 3, Z + 3);
}

void linear_cross_force(const double X[6], const double f[6], double g[6])
{
    double other[3];
    cross(X, f, g);
    cross(X + 3, f + 3, other);
    add(1.0, other, 3, g);
    cross(X, f + 3, g + 3);
}

double linear_dot(const double X[6], const double f[6])
{
    double sum = 0.0;
    for (int k = 0; k < 6; ++k) sum += X[k] * f[k];
    return sum;
}

/* R <- rotation by `angle` about the unit vector a, times R. */
static void turn(const double a[3], double angle, double R[9])
{
    const double s = sin(angle), c = 1.0 - cos(angle);
    for (int k = 0; k < 3; ++k) {
        const double column[3] = {R[k], R[3 + k], R[6 + k]};
        double once[3], twice[3];
        cross(a, column, once);
        cross(a, once, twice);
        for (int i = 0; i < 3; ++i) R[3 * i + k] = column[i] + s * once[i] + c * twice[i];
    }
}

/* ---- motion ---- */

static void move_free(const stiff_body *of, const double *q, const double *u, linear_body *b)
{
    const double *x = b->x, *v = u + 3;
    double column[9];
    mbsr_quaternion_rotation(q, column);
    for (int k = 0; k < 9; ++k) b->R[3 * (k % 3) + k / 3] = column[k];
    memcpy(b->x, of->place, sizeof b->x);
    add(1.0, q + 4, 3, b->x);
    memcpy(b->V, u, 3 * sizeof *u);
    cross(x, u, b->V + 3);
    add(1.0, v, 3, b->V + 3);
    for (int k = 0; k < 3; ++k) {
        linear_axis *w = b->axis + k, *s = b->axis + 3 + k;
        memset(w, 0, sizeof *w);
        memset(s, 0, sizeof *s);
        w->S[k] = 1.0, s->S[3 + k] = 1.0;
        cross(x, w->S, w->S + 3);
        cross(v, w->S, w->rate + 3);
        linear_cross(b->V, w->S, w->twist);
        w->after = 7, s->after = 63;
    }
}

static void move_axes(const stiff_body *of, const double *q, const double *u, linear_body *b)
{
    for (int k = 0; k < of->axes; ++k) {
        const stiff_axis *a = of->axis + k;
        linear_axis *to = b->axis + k;
        double n[3];
        times(b->R, a->direction, n);
        memset(to, 0, sizeof *to);
        memcpy(a->turns ? to->S : to->S + 3, n, sizeof n);
        if (a->turns) cross(b->x, n, to->S + 3);
        linear_cross(b->V, to->S, to->rate);
        memcpy(to->twist, to->rate, sizeof to->rate);
        to->after = 63u & ~((2u << k) - 1u);
        to->stiffness = a->stiffness, to->damping = a->damping;
        add(u[k], to->S, 6, b->V);
        if (a->turns)
            turn(n, q[k], b->R);
        else
            add(q[k], n, 3, b->x);
    }
}

static void move(linear_model *m, int i, const double *q, const double *u)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    const stiff_body *of = m->stiff->body + i;
    linear_body *b = m->body + i;
    memcpy(b->R, b->parent < 0 ? unit : m->body[b->parent].R, sizeof b->R);
    times(b->R, of->place, b->x);
    memset(b->V, 0, sizeof b->V);
    if (b->parent >= 0) {
        add(1.0, m->body[b->parent].x, 3, b->x);
        memcpy(b->V, m->body[b->parent].V, sizeof b->V);
    }
    if (of->free)
        move_free(of, q + b->q, u + b->u, b);
    else
        move_axes(of, q + b->q, u + b->u, b);
}

static void centre(const stiff_body *of, const linear_body *b, double c[3])
{
    times(b->R, of->com, c);
    add(1.0, b->x, 3, c);
}

/* M about the world's origin. */
static void masses(const stiff_body *of, linear_body *b)
{
    const double *J = of->tensor, own[9] = {J[0], J[3], J[4], J[3], J[1], J[5], J[4], J[5], J[2]};
    double c[3], half[9];
    memset(b->M, 0, sizeof b->M);
    if (of->mass == 0.0) return;
    centre(of, b, c);
    for (int i = 0; i < 3; ++i) times(own, b->R + 3 * i, half + 3 * i); /* rows of (J R^T)^T */
    for (int i = 0; i < 3; ++i) {
        double e[3] = {0.0}, column[3], square[3];
        e[i] = 1.0;
        times(b->R, half + 3 * i, column);
        cross(c, e, square);
        cross(c, square, square);
        for (int k = 0; k < 3; ++k) b->M[6 * k + i] = column[k] - of->mass * square[k];
        cross(c, e, column);
        for (int k = 0; k < 3; ++k) {
            b->M[6 * k + 3 + i] = of->mass * column[k];
            b->M[6 * (3 + i) + k] = of->mass * column[k];
        }
        b->M[7 * (3 + i)] = of->mass;
    }
}

/* ---- forces ---- */

/* Velocity of a point p of a body. */
static void velocity(const double V[6], const double p[3], double v[3])
{
    cross(V, p, v);
    add(1.0, V + 3, 3, v);
}

/* Changes of a point's place and velocity, of the body's displacement xi and the change nu of its
 * V, seen in the body. */
static void point_changes(const linear_body *b, const double p[3], const double xi[6],
                          const double nu[6], double dp[3], double dv[3])
{
    double dV[6], other[3];
    velocity(xi, p, dp);
    linear_cross(xi, b->V, dV);
    add(1.0, nu, 6, dV);
    velocity(dV, p, dv);
    cross(b->V, dp, other);
    add(1.0, other, 3, dv);
}

/* Change, seen in the moving body, of the wrench of f at p. */
static void wrench_change(const double p[3], const double f[3], const double xi[6],
                          const double dp[3], const double df[3], double g[6])
{
    double at[6], turned[6], other[3];
    cross(p, f, at);
    memcpy(at + 3, f, 3 * sizeof *f);
    cross(dp, f, g);
    cross(p, df, other);
    add(1.0, other, 3, g);
    memcpy(g + 3, df, 3 * sizeof *df);
    linear_cross_force(xi, at, turned);
    add(-1.0, turned, 6, g);
}

static void add_wrench(const double p[3], double s, const double f[3], double F[6])
{
    double moment[3];
    cross(p, f, moment);
    add(s, moment, 3, F);
    add(s, f, 3, F + 3);
}

/* A force at p that changes by K dp + C dv (rows; NULL: nothing). */
static void add_force(linear_body *b, const double p[3], const double f[3], const double *K,
                      const double *C)
{
    b->loaded = 1;
    add_wrench(p, 1.0, f, b->F);
    for (int k = 0; k < 12; ++k) {
        double unit[12] = {0.0}, dp[3], dv[3], df[3] = {0.0}, part[3], g[6];
        if (k >= 6 && !C) break;
        unit[k] = 1.0;
        point_changes(b, p, unit, unit + 6, dp, dv);
        if (K) times(K, dp, part), add(1.0, part, 3, df);
        if (C) times(C, dv, part), add(1.0, part, 3, df);
        wrench_change(p, f, unit, dp, df, g);
        for (int i = 0; i < 6; ++i) (k < 6 ? b->by_xi : b->by_nu)[6 * i + k % 6] += g[i];
    }
}

/* The load on a body, with its derivatives by central differences. */
static void push(linear_model *m, int k, double t)
{
    const stiff_model *s = m->stiff;
    linear_body *b = m->body + s->load[k];
    double p[3], v[3], f[3], K[9], C[9];
    times(b->R, s->load_at, p);
    add(1.0, b->x, 3, p);
    velocity(b->V, p, v);
    s->force(k, t, p, v, f);
    for (int j = 0; j < 6; ++j) {
        double *x = j < 3 ? p + j : v + j - 3, *slope = j < 3 ? K : C, at = *x, up[3], down[3];
        const double step = 1e-5;
        *x = at + step;
        s->force(k, t, p, v, up);
        *x = at - step;
        s->force(k, t, p, v, down);
        *x = at;
        for (int i = 0; i < 3; ++i) slope[3 * i + j % 3] = (up[i] - down[i]) / (2.0 * step);
    }
    add_force(b, p, f, K, C);
}

/* One spring-damper of a tie from point p of a to point r of b: f = (k (l - l0) + d l') n on a. */
static void stretch(const stiff_ball *s, linear_model *m, const double p[3], const double r[3],
                    linear_tie *tie)
{
    linear_body *a = m->body + s->a, *b = m->body + s->b;
    double v[3], w[3], n[3], f[3], length = 0.0, rate = 0.0;
    velocity(a->V, p, v);
    velocity(b->V, r, w);
    for (int i = 0; i < 3; ++i) n[i] = r[i] - p[i], length += n[i] * n[i];
    length = sqrt(length);
    for (int i = 0; i < 3; ++i) n[i] /= length, rate += n[i] * (w[i] - v[i]);
    const double force = s->stiffness * (length - s->length) + s->damping * rate;
    for (int i = 0; i < 3; ++i) f[i] = force * n[i];
    add_wrench(p, 1.0, f, a->F);
    add_wrench(r, -1.0, f, b->F);
    for (int k = 0; k < 24; ++k) {
        double unit[24] = {0.0}, dp[3], dv[3], dr[3], dw[3], dn[3], df[3], g[6], along = 0.0,
               drate = 0.0;
        unit[k] = 1.0;
        point_changes(a, p, unit, unit + 6, dp, dv);
        point_changes(b, r, unit + 12, unit + 18, dr, dw);
        for (int i = 0; i < 3; ++i) along += n[i] * (dr[i] - dp[i]);
        for (int i = 0; i < 3; ++i) {
            dn[i] = (dr[i] - dp[i] - along * n[i]) / length;
            drate += dn[i] * (w[i] - v[i]) + n[i] * (dw[i] - dv[i]);
        }
        const double change = s->stiffness * along + s->damping * drate;
        for (int i = 0; i < 3; ++i) df[i] = change * n[i] + force * dn[i];
        wrench_change(p, f, unit, dp, df, g);
        for (int i = 0; i < 6; ++i) tie->by[24 * i + k] += g[i];
        wrench_change(r, f, unit + 12, dr, df, g);
        for (int i = 0; i < 6; ++i) tie->by[24 * (6 + i) + k] -= g[i];
    }
}

static void pull(linear_model *m, int k)
{
    const stiff_ball *s = m->stiff->ball + k;
    linear_tie *tie = m->tie + k;
    double r[3];
    memset(tie->by, 0, sizeof tie->by);
    times(m->body[s->b].R, s->at_b, r);
    add(1.0, m->body[s->b].x, 3, r);
    for (int j = 0; j < 3; ++j) {
        double at[3] = {s->at_a[0], s->at_a[1], s->at_a[2]}, p[3];
        at[j] -= s->length;
        times(m->body[s->a].R, at, p);
        add(1.0, m->body[s->a].x, 3, p);
        stretch(s, m, p, r, tie);
    }
}

static void forces(linear_model *m, double t)
{
    const stiff_model *s = m->stiff;
    for (int i = 0; i < s->bodies; ++i) {
        linear_body *b = m->body + i;
        double c[3], weight[3];
        memset(b->F, 0, sizeof b->F);
        memset(b->by_xi, 0, sizeof b->by_xi);
        memset(b->by_nu, 0, sizeof b->by_nu);
        centre(s->body + i, b, c);
        for (int k = 0; k < 3; ++k) weight[k] = s->body[i].mass * s->gravity[k];
        b->loaded = 0;
        if (weight[0] != 0.0 || weight[1] != 0.0 || weight[2] != 0.0)
            add_force(b, c, weight, NULL, NULL);
    }
    for (int k = 0; k < s->loads; ++k) push(m, k, t);
    for (int k = 0; k < s->balls; ++k) pull(m, k);
}

/* ---- sums, and the articulated-body inertia for ranks and gains ---- */

/* A; then h, F and B from body to leaves. */
static void sums(linear_model *m, const double *u)
{
    const int n = m->stiff->bodies;
    for (int i = 0; i < n; ++i) {
        linear_body *b = m->body + i;
        double inertial[6], turned[6];
        memset(b->A, 0, sizeof b->A);
        if (b->parent >= 0) memcpy(b->A, m->body[b->parent].A, sizeof b->A);
        for (int k = 0; k < b->axes; ++k) {
            add(m->udot[b->u + k], b->axis[k].S, 6, b->A);
            add(u[b->u + k], b->axis[k].rate, 6, b->A);
        }
        times6(b->M, b->V, b->h);
        times6(b->M, b->A, inertial);
        linear_cross_force(b->V, b->h, turned);
        for (int k = 0; k < 6; ++k) b->B[k] = inertial[k] + turned[k] - b->F[k];
    }
    for (int i = n - 1; i >= 0; --i) {
        const linear_body *b = m->body + i;
        linear_body *p = m->body + b->parent;
        if (b->parent < 0) continue;
        add(1.0, b->h, 6, p->h);
        add(1.0, b->F, 6, p->F);
        add(1.0, b->B, 6, p->B);
    }
}

/* D^-1, rows, by Cholesky's factors of D scaled to entries of about 1; 0: a pivot is small. */
static int invert_regular(linear_body *b, const double *D, const double *scale, double *inverse)
{
    const int n = b->axes;
    double L[36] = {0.0}, Y[36] = {0.0};
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = D[n * i + j] * scale[i] * scale[j];
            for (int k = 0; k < j; ++k) sum -= L[6 * i + k] * L[6 * j + k];
            if (i == j && !(sum > 1e-12)) return 0;
            L[6 * i + j] = i == j ? sqrt(sum) : sum / L[7 * j];
        }
    }
    for (int j = 0; j < n; ++j) { /* Y = L^-1 */
        for (int i = j; i < n; ++i) {
            double sum = i == j ? 1.0 : 0.0;
            for (int k = j; k < i; ++k) sum -= L[6 * i + k] * Y[6 * k + j];
            Y[6 * i + j] = sum / L[7 * i];
        }
    }
    for (int i = 0; i < n * n; ++i) {
        inverse[i] = 0.0;
        for (int k = 0; k < n; ++k) inverse[i] += Y[6 * k + i / n] * Y[6 * k + i % n];
        inverse[i] *= scale[i / n] * scale[i % n];
        b->kept[i] = i / n == i % n;
    }
    b->rank = n;
    return 1;
}

/* D^+ of D, rows, scaled to entries of about 1; range, null, kept. */
static void invert(linear_body *b, const double *D, const double *scale, double *inverse)
{
    const int n = b->axes, lwork = 64;
    double V[36], lambda[6], work[64];
    int info;
    if (invert_regular(b, D, scale, inverse)) return;
    for (int i = 0; i < n * n; ++i) V[i] = D[i] * scale[i / n] * scale[i % n];
    dsyev_("V", "U", &n, V, &n, lambda, work, &lwork, &info, 1, 1);
    b->rank = 0;
    memset(inverse, 0, 36 * sizeof *inverse);
    memset(b->kept, 0, sizeof b->kept);
    for (int k = n - 1, lost = 0; k >= 0; --k) {
        const double *v = V + n * k;
        const int keeps = lambda[k] > 1e-13; /* a link of 1 mm, 10 m from the origin: 1e-8 */
        for (int i = 0; i < n; ++i)
            *(keeps ? &b->range[6 * b->rank + i] : &b->null[6 * lost + i]) = scale[i] * v[i];
        for (int i = 0; i < n * n && keeps; ++i) {
            inverse[i] += scale[i / n] * v[i / n] * v[i % n] * scale[i % n] / lambda[k];
            b->kept[i] += v[i / n] * v[i % n] * scale[i % n] / scale[i / n];
        }
        keeps ? ++b->rank : ++lost;
    }
}

static void condense(linear_model *m, int i, double *Mbar)
{
    linear_body *b = m->body + i;
    const int n = b->axes;
    double U[36], D[36], inverse[36], scale[6];
    for (int k = 0; k < n; ++k) {
        double size = 0.0;
        times6(Mbar + 36 * i, b->axis[k].S, U + 6 * k);
        for (int r = 0; r < 6; ++r)
            size += b->axis[k].S[r] * b->axis[k].S[r] * Mbar[36 * i + 7 * r];
        scale[k] = size > 0.0 ? 1.0 / sqrt(size) : 1.0;
    }
    for (int k = 0; k < n * n; ++k) D[k] = linear_dot(b->axis[k / n].S, U + 6 * (k % n));
    invert(b, D, scale, inverse);
    memset(b->gain, 0, sizeof b->gain);
    for (int k = 0; k < n * n; ++k) add(inverse[k], U + 6 * (k % n), 6, b->gain + 6 * (k / n));
    if (b->parent < 0) return;
    double *to = Mbar + 36 * b->parent;
    add(1.0, Mbar + 36 * i, 36, to);
    for (int k = 0; k < n; ++k) {
        for (int r = 0; r < 36; ++r) to[r] -= b->gain[6 * k + r / 6] * U[6 * k + r % 6];
    }
}

static void ranks(linear_model *m)
{
    const int n = m->stiff->bodies;
    double *Mbar = bench_allocate(36 * (size_t)n, sizeof *Mbar);
    for (int i = 0; i < n; ++i) memcpy(Mbar + 36 * i, m->body[i].M, sizeof m->body[i].M);
    for (int i = n - 1; i >= 0; --i) condense(m, i, Mbar);
    free(Mbar);
}

/* ---- coordinates ---- */

/* Displacements by delta u: of axes 1 / c; of a quaternion, q' = 1/2 (0, u) q, with theta its small
 * rotation c theta - 1/2 u x theta + u (u^T theta) / (4 c) = delta u + ... */
static void displacements(linear_body *b, const double *u, double c)
{
    const int n = b->axes;
    memset(b->theta, 0, sizeof b->theta);
    for (int k = 0; k < n; ++k) b->theta[7 * k] = 1.0 / c;
    if (!b->free) return;
    double A[9], cofactor[9];
    for (int i = 0; i < 9; ++i) A[i] = u[i / 3] * u[i % 3] / (4.0 * c) + (i % 4 == 0 ? c : 0.0);
    A[1] += 0.5 * u[2], A[3] -= 0.5 * u[2];
    A[2] -= 0.5 * u[1], A[6] += 0.5 * u[1];
    A[5] += 0.5 * u[0], A[7] -= 0.5 * u[0];
    for (int i = 0; i < 3; ++i)
        cross(A + 3 * ((i + 1) % 3), A + 3 * ((i + 2) % 3), cofactor + 3 * i);
    const double determinant = A[0] * cofactor[0] + A[1] * cofactor[1] + A[2] * cofactor[2];
    for (int i = 0; i < 9; ++i) b->theta[6 * (i % 3) + i / 3] = cofactor[i] / determinant;
}

void linear_open(linear_model *m, const stiff_model *stiff, const mbsr_model *model)
{
    m->stiff = stiff;
    m->body = bench_allocate((size_t)stiff->bodies, sizeof *m->body);
    m->tie = bench_allocate((size_t)stiff->balls + 1, sizeof *m->tie);
    m->udot = bench_allocate((size_t)mbsr_model_nu(model) + 1, sizeof *m->udot);
    for (int i = 0; i < stiff->bodies; ++i) {
        linear_body *b = m->body + i;
        b->parent = stiff->body[i].parent;
        b->free = stiff->body[i].free;
        b->axes = b->free ? 6 : stiff->body[i].axes;
        bench_check(mbsr_body_coordinates(model, i, &b->q, NULL, &b->u, NULL), "coordinates", NULL);
    }
    for (int k = 0; k < stiff->balls; ++k)
        m->tie[k].a = stiff->ball[k].a, m->tie[k].b = stiff->ball[k].b;
}

void linear_close(linear_model *m)
{
    free(m->body);
    free(m->tie);
    free(m->udot);
}

int linear_at(linear_model *m, const mbsr_model *model, mbsr_data *data, double t, const double *y,
              double c)
{
    const double *q = y, *u = y + mbsr_model_nq(model) + mbsr_model_nu(model);
    const int status = mbsr_forward_dynamics(model, data, t, q, u, NULL, m->udot);
    if (status && status != MBSR_UNDETERMINED) return status;
    for (int i = 0; i < m->stiff->bodies; ++i) {
        move(m, i, q, u);
        masses(m->stiff->body + i, m->body + i);
        displacements(m->body + i, u + m->body[i].u, c);
    }
    forces(m, t);
    sums(m, u);
    ranks(m);
    return MBSR_OK;
}
