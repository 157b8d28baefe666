/* Derivatives of a body's own momentum and inertia forces: see body_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In space all of M turns with the body. With (L, l) = M V, along a small rotation theta, T x =
 * (theta x x_1, theta x x_2) for both halves of a vector,
 *
 *   M' V = (omega x L, omega x l) - M (0, omega x v),   h = M' V + (v x l, 0),   dM = T M - M T
 *
 * In the plane the first moment c of a body turns, where M is not constant: with J c = (-c_y, c_x),
 * M V has omega J c and (J c) v, M' V = (-omega^2 c, -omega c v), and h = (-omega^2 c, 0).
 * Flexible bodies have formulas of their own (flexible/slopes.h). An inertia by function is
 * differenced, with M' V from differences along the motion. */
#include "newton/slopes/body_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "base/inlined.h"
#include "flexible/slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/move.h"
#include "recursion/inertia.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"

#include <math.h>

/* Where in the scratch of an inertia by function what is: displaced. */
typedef struct room {
    double *MV, *h, *MdotV, *MA;
    double *T, *V, *M;
    double *p, *p_on, *dp, *along;
} room;

size_t mbsri_body_slopes_size(const mbsr_model *m)
{
    size_t largest = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const size_t d = (size_t)m->body[i].d, np = (size_t)m->body[i].np;
        const size_t size = 6 * d + d * d + 4 * np,
                     flexible = m->body[i].inertia.kind == MBSR_INERTIA_FLEXIBLE
                                    ? mbsri_flex_slopes_size(m->body[i].inertia.flex)
                                    : 0;
        if (size > largest) largest = size;
        if (flexible > largest) largest = flexible;
    }
    return largest;
}

static void lay_out(const mbsri_body *b, double *work, room *w)
{
    const size_t d = (size_t)b->d, np = (size_t)b->np;
    double **const vector[] = {&w->MV, &w->h, &w->MdotV, &w->MA, &w->T,    &w->V,
                               &w->M,  &w->p, &w->p_on,  &w->dp, &w->along};
    const size_t length[] = {d, d, d, d, d, d, d * d, np, np, np, np};
    for (size_t k = 0; k < sizeof length / sizeof length[0]; ++k) {
        *vector[k] = work;
        work += length[k];
    }
}

bool mbsri_body_slopes_serve(const mbsri_body *b)
{
    return b->inertia.kind != MBSR_INERTIA_FUNCTION || b->joint.space != MBSR_SPACE_GENERAL ||
           b->np == b->d;
}

/* y = A x */
static void product(int d, const double *A, const double *x, double *y)
{
    mbsri_zero((size_t)d, y);
    mbsri_ax(d, d, 1.0, A, x, y);
}

/* The column (-d(M V), dh - d(M' V), -dh - d(M A)) goes to P. */
MBSRI_INLINE void store(const int d, const bool accelerated, const double *dMV, const double *dh,
                        const double *dMdotV, const double *dMA, double *P)
{
    for (int k = 0; k < d; ++k) {
        P[k] -= dMV[k];
        P[d + k] += dh[k] - dMdotV[k];
        if (accelerated) P[2 * d + k] -= dh[k] + dMA[k];
    }
}

/* ---- bodies in space ---- */

/* What a rotation does to both halves of x. */
MBSRI_INLINE void turn(const double axis[3], const double *x, double *y)
{
    mbsri_cross3(axis, x, y);
    mbsri_cross3(axis, x + 3, y + 3);
}

/* dM x along a rotation, with Mx = M x. */
MBSRI_INLINE void turn_mass(const double axis[3], const double *M, const double *x,
                            const double *Mx, double *y)
{
    double turned[6];
    turn(axis, Mx, y);
    turn(axis, x, turned);
    mbsri_ax_often(6, 6, -1.0, M, turned, y);
}

/* M V, M A and (0, omega x v), M times that. */
typedef struct spatial {
    const double *M, *V, *A;
    double MV[6], MA[6], sweep[6], M_sweep[6];
} spatial;

static void read_body(const mbsri_body *b, const mbsr_data *d, bool accelerated, spatial *s)
{
    *s = (spatial){.M = d->M + b->dd, .V = d->V + b->v, .A = d->A + b->v};
    mbsri_ax_often(6, 6, 1.0, s->M, s->V, s->MV);
    if (!accelerated) return;
    mbsri_ax_often(6, 6, 1.0, s->M, s->A, s->MA);
    mbsri_cross3(s->V, s->V + 3, s->sweep + 3);
    mbsri_ax_often(6, 6, 1.0, s->M, s->sweep, s->M_sweep);
}

/* The column along theta = axis, at V and A held. */
MBSRI_INLINE void rotation_column(const spatial *s, const double axis[3], const bool accelerated,
                                  double *P)
{
    double dMV[6], dMdotV[6] = {0.0}, dh[6] = {0.0}, dMA[6] = {0.0};
    turn_mass(axis, s->M, s->V, s->MV, dMV);
    if (accelerated) {
        double turned_sweep[6];
        turn_mass(axis, s->M, s->A, s->MA, dMA);
        turn_mass(axis, s->M, s->sweep, s->M_sweep, turned_sweep);
        turn(s->V, dMV, dMdotV);
        for (int k = 0; k < 6; ++k) dMdotV[k] -= turned_sweep[k];
    }
    mbsri_copy(6, dMdotV, dh);
    mbsri_add_cross3(s->V + 3, dMV + 3, dh);
    store(6, accelerated, dMV, dh, dMdotV, dMA, P);
}

/* The column along number k of V. */
MBSRI_INLINE void velocity_column(const spatial *s, int k, const bool accelerated, double *P)
{
    const double *dMV = s->M + 6 * k, none[6] = {0.0};
    double dV[6] = {0.0}, dMdotV[6] = {0.0}, dh[6];
    dV[k] = 1.0;
    if (accelerated) {
        double change[6] = {0.0}, sweep[6] = {0.0};
        turn(dV, s->MV, dMdotV);
        turn(s->V, dMV, change);
        for (int l = 0; l < 6; ++l) dMdotV[l] += change[l];
        mbsri_cross3(dV, s->V + 3, sweep + 3);
        mbsri_add_cross3(s->V, dV + 3, sweep + 3);
        mbsri_ax_often(6, 6, -1.0, s->M, sweep, dMdotV);
    }
    mbsri_copy(6, dMdotV, dh);
    mbsri_add_cross3(dV + 3, s->MV + 3, dh);
    mbsri_add_cross3(s->V + 3, dMV + 3, dh);
    store(6, accelerated, dMV, dh, dMdotV, none, P);
}

MBSRI_INLINE void spatial_columns(const mbsri_body *b, const mbsr_data *d, const bool accelerated,
                                  double *P)
{
    const size_t rows = accelerated ? 18 : 12;
    spatial s;
    read_body(b, d, accelerated, &s);
    for (int k = 0; k < 3; ++k) {
        double axis[3] = {0.0};
        axis[k] = 1.0;
        rotation_column(&s, axis, accelerated, P + rows * (size_t)k);
    }
    for (int k = 0; k < 6; ++k) velocity_column(&s, k, accelerated, P + rows * (size_t)(6 + k));
}

/* ---- bodies with a constant M, or in the plane ---- */

static void constant_columns(const mbsri_body *b, const mbsr_data *d, bool accelerated, double *P)
{
    const size_t n = (size_t)b->d, rows = accelerated ? 3 * n : 2 * n;
    P += rows * (size_t)mbsri_pose_size(b);
    for (size_t k = 0; k < n; ++k, P += rows) {
        for (size_t l = 0; l < n; ++l) P[l] -= d->M[b->dd + k * n + l];
    }
}

/* What the turning of the first moment adds; what was added to M stands still. */
static void planar_columns(const mbsri_body *b, const mbsr_data *d, bool accelerated, double *P)
{
    const double *M = d->M + b->dd, *V = d->V + b->v, *A = d->A + b->v, omega = V[2],
                 still[2] = {b->mass.added ? b->mass.added[5] : 0.0,
                             b->mass.added ? b->mass.added[2] : 0.0},
                 c[2] = {M[5] - still[0], still[1] - M[2]}, none[3] = {0.0};
    const size_t rows = accelerated ? 9 : 6;
    const double dMV[3] = {-omega * c[0], -omega * c[1], -c[0] * V[0] - c[1] * V[1]},
                 dMA[3] = {-A[2] * c[0], -A[2] * c[1], -c[0] * A[0] - c[1] * A[1]},
                 along = c[0] * V[1] - c[1] * V[0], square = omega * omega;
    store(3, accelerated, dMV, (double[]){square * c[1], -square * c[0], 0.0},
          (double[]){square * c[1], -square * c[0], -omega * along}, dMA, P + 2 * rows);
    for (size_t k = 0; k < 2; ++k)
        store(3, accelerated, none, none, (double[]){0.0, 0.0, -omega * c[k]}, none,
              P + (3 + k) * rows);
    store(3, accelerated, none, (double[]){-2.0 * omega * c[0], -2.0 * omega * c[1], 0.0},
          (double[]){-2.0 * omega * c[0], -2.0 * omega * c[1], -c[0] * V[0] - c[1] * V[1]}, none,
          P + 5 * rows);
}

static void plain_columns(const mbsri_body *b, const mbsr_data *d, bool accelerated, double *P)
{
    constant_columns(b, d, accelerated, P);
    if (b->inertia.kind == MBSR_INERTIA_PLANAR) planar_columns(b, d, accelerated, P);
}

/* ---- inertias by function ---- */

/* Of the spans (recursion/spans.h). */
static const double step = 1e-3;

/* M V, h, M' V and M A at a pose p and velocity V; h: the step in time, s. */
static int terms(const mbsri_body *b, const mbsr_data *d, const double *p, const double *V,
                 double h, const room *w)
{
    int status = mbsri_inertia_velocity(b, d->t, p, V, w->M, w->h);
    if (status) return status;
    product(b->d, w->M, V, w->MV);
    product(b->d, w->M, d->A + b->v, w->MA);
    mbsri_zero((size_t)b->d, w->MdotV);
    mbsri_pose_rate(b->joint.space, b->np, p, V, w->dp);
    for (int l = 0; l < 4 && !status; ++l) {
        const double to = mbsri_difference_place(l) * h;
        mbsri_pose_move(b->joint.space, b->np, p, w->dp, to, w->p_on);
        status = mbsri_inertia_velocity(b, d->t + to, w->p_on, V, w->M, w->T);
        if (!status)
            mbsri_ax(b->d, b->d, mbsri_difference_weight(l) / (12.0 * h), w->M, V, w->MdotV);
    }
    return status;
}

static int function_columns(const mbsr_model *m, const mbsri_body *b, const mbsr_data *d,
                            bool accelerated, const room *w, double *P)
{
    const mbsri_spans s = mbsri_spans_of(m, &b->joint.table->scales);
    const double rate = fmax(mbsri_span_rate(&s), mbsri_twist_rate(&s, b, d->V + b->v));
    const int n = b->d, e = mbsri_pose_size(b), rows = accelerated ? 3 * n : 2 * n;
    const double *p = d->p + b->p, *V = d->V + b->v;
    int status = MBSR_OK;
    for (int k = 0; k < e + n && !status; ++k, P += rows) {
        mbsri_zero((size_t)b->np, w->along);
        if (k < e) mbsri_pose_unit(b->joint.space, k, p, w->along);
        const double span = mbsri_binary(k < e ? mbsri_pose_span(&s, b, k)
                                               : mbsri_pose_span(&s, b, k - e) * rate),
                     h = step * span;
        for (int l = 0; l < 4 && !status; ++l) {
            mbsri_pose_move(b->joint.space, b->np, p, w->along, mbsri_difference_place(l) * h,
                            w->p);
            mbsri_copy((size_t)n, V, w->V);
            if (k >= e) w->V[k - e] += mbsri_difference_place(l) * h;
            status = terms(b, d, w->p, w->V, step / rate, w);
            const double factor = mbsri_difference_weight(l) / (12.0 * h);
            for (int j = 0; j < n && !status; ++j) {
                P[j] -= factor * w->MV[j];
                P[n + j] += factor * (w->h[j] - w->MdotV[j]);
                if (accelerated) P[2 * n + j] -= factor * (w->h[j] + w->MA[j]);
            }
        }
    }
    return status;
}

/* ---- flexible bodies ---- */

typedef struct sink {
    const mbsri_body *b;
    bool accelerated;
    double *P;
} sink;

static void take_column(void *to, int column, const double *momentum, const double *turning,
                        const double *load)
{
    const sink *s = to;
    const int d = s->b->d;
    double *P = s->P + (size_t)((s->accelerated ? 3 : 2) * d) * (size_t)column;
    for (int k = 0; k < d; ++k) {
        P[k] -= momentum[k];
        P[d + k] += turning[k];
        if (s->accelerated) P[2 * d + k] -= load[k];
    }
}

static void flexible_columns(const mbsri_body *b, const mbsr_data *d, bool accelerated, double *P,
                             double *work)
{
    const double *p = d->p + b->p;
    sink to = {b, accelerated, P};
    mbsri_flex_slopes_of(b->inertia.flex, p + MBSR_POSE_R, p + MBSR_POSE_SIZE, d->V + b->v,
                         d->A + b->v, work, take_column, &to);
}

int mbsri_body_slopes_add(const mbsr_model *m, mbsr_data *d, int i, bool accelerated, double *P,
                          double *work)
{
    const mbsri_body *b = m->body + i;
    const int n = b->d, e = mbsri_pose_size(b);
    room w;
    lay_out(b, work, &w);
    int status = MBSR_OK;
    if (b->inertia.kind == MBSR_INERTIA_FUNCTION)
        status = function_columns(m, b, d, accelerated, &w, P);
    else if (b->inertia.kind == MBSR_INERTIA_FLEXIBLE)
        flexible_columns(b, d, accelerated, P, work);
    else if (b->joint.space == MBSR_SPACE_SPATIAL && accelerated)
        spatial_columns(b, d, true, P);
    else if (b->joint.space == MBSR_SPACE_SPATIAL)
        spatial_columns(b, d, false, P);
    else
        plain_columns(b, d, accelerated, P);
    if (status) return mbsri_joint_failed(m, d, i, status, "the inertia's function");
    /* columns of A: -M in the rows of mu */
    for (int k = 0; k < n && accelerated; ++k) {
        double *column = P + (size_t)(3 * n) * (size_t)(e + n + k) + 2 * (size_t)n;
        for (int l = 0; l < n; ++l) column[l] -= d->M[b->dd + (size_t)(k * n + l)];
    }
    return MBSR_OK;
}
