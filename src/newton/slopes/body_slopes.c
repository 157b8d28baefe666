/* Derivatives of a body's own momentum and inertia forces: see body_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * M is linear in the constants of the body, h and M' V are quadratic in V, so that with B for the
 * symmetric bilinear form of a quadratic function, dh = 2 B_h(V, dV). Where M turns with the body,
 * all of it turns: along a small rotation x, with T the matrix that turns vectors of V's kind,
 *
 *   dM = T M - M T,   dh = T h - 2 B_h(V, T V)
 *
 * Flexible bodies have formulas of their own (flexible/slopes.h). An inertia by function is differenced,
 * with M' V from differences along the motion. */
#include "newton/slopes/body_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "flexible/slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/move.h"
#include "recursion/inertia.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"

#include <math.h>

/* Where in the scratch what is. */
typedef struct room {
    double *MV, *h, *MdotV, *MA; /* at the state or displaced */
    double *T, *TV, *TA;         /* turned vectors, and spare ones */
    double *V, *p, *M, *Mdot;    /* displaced */
    double *column;              /* 3 d */
    double *p_on, *dp;
} room;

size_t mbsri_body_slopes_size(const mbsr_model *m)
{
    size_t largest = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const size_t d = (size_t)m->body[i].d, np = (size_t)m->body[i].np;
        const size_t size = 11 * d + 2 * d * d + 4 * np,
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
    double **const vector[] = {&w->MV, &w->h, &w->MdotV, &w->MA,     &w->T, &w->TV,   &w->TA,
                               &w->V,  &w->M, &w->Mdot,  &w->column, &w->p, &w->p_on, &w->dp};
    const size_t length[] = {d, d, d, d, d, d, d, d, d * d, d * d, 3 * d, np, np, np};
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
static void store(const mbsri_body *b, bool accelerated, const double *dMV, const double *dh,
                  const double *dMdotV, const double *dMA, double *P)
{
    for (int k = 0; k < b->d; ++k) {
        P[k] -= dMV[k];
        P[b->d + k] += dh[k] - dMdotV[k];
        if (accelerated) P[2 * b->d + k] -= dh[k] + dMA[k];
    }
}

/* ---- inertias that are constant or turn with the body ---- */

/* h and M' V at velocity V. */
static void quadratic(const mbsri_body *b, const mbsr_data *d, const double *V, const room *w,
                      double *h, double *MdotV)
{
    const double *p = d->p + b->p;
    double *M = d->M + b->dd; /* constant inertias leave it */
    (void)mbsri_inertia_velocity(b, d->t, p, V, M, h);
    mbsri_inertia_mass_rate(b, p, V, M, w->Mdot);
    product(b->d, w->Mdot, V, MdotV);
}

/* dh = 2 B_h(V, dV) = h(V + dV) - h(V) - h(dV), and so for M' V; into w->T and w->column. With a
 * factor that brings dV to V's size. */
static void polarise(const mbsri_body *b, const mbsr_data *d, const double *V, const double *dV,
                     const room *w, double *dh, double *dMdotV)
{
    const double size = mbsri_largest(b->d, V), change = mbsri_largest(b->d, dV);
    const double s = size > 0.0 && change > 0.0 ? size / change : 1.0;
    double *h = w->column, *MdotV = h + b->d;
    mbsri_zero((size_t)b->d, dh);
    mbsri_zero((size_t)b->d, dMdotV);
    /* (f(V + s dV) - f(V - s dV)) / 2 s */
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int k = 0; k < b->d; ++k) w->V[k] = V[k] + sign * s * dV[k];
        quadratic(b, d, w->V, w, h, MdotV);
        for (int k = 0; k < b->d; ++k) {
            dh[k] += sign * h[k] / (2.0 * s);
            dMdotV[k] += sign * MdotV[k] / (2.0 * s);
        }
    }
}

/* y = T x for the rotation about axis k: 0 .. 2 in space, the only one in the plane. */
static void turned(const mbsri_body *b, int k, const double *x, double *y)
{
    mbsri_zero((size_t)b->d, y);
    if (b->joint.space == MBSR_SPACE_SPATIAL) {
        double axis[3] = {0.0, 0.0, 0.0};
        axis[k] = 1.0;
        mbsri_cross3(axis, x, y);
        mbsri_cross3(axis, x + 3, y + 3);
    } else {
        y[0] = -x[1];
        y[1] = x[0];
    }
}

/* The column of a rotation of the body. */
static void rotation_column(const mbsri_body *b, const mbsr_data *d, int k, bool accelerated,
                            const room *w, double *P)
{
    const int n = b->d;
    double dh[6], dMdotV[6], dMV[6], dMA[6] = {0.0}, spin[6] = {0.0};
    turned(b, k, d->V + b->v, w->TV);
    polarise(b, d, d->V + b->v, w->TV, w, dh, dMdotV);
    turned(b, k, w->h, w->T);
    for (int l = 0; l < n; ++l) dh[l] = w->T[l] - dh[l];
    turned(b, k, w->MdotV, w->T);
    for (int l = 0; l < n; ++l) dMdotV[l] = w->T[l] - dMdotV[l];
    /* dM is M' for a unit angular velocity */
    spin[n == 3 ? 2 : k] = 1.0;
    mbsri_inertia_mass_rate(b, d->p + b->p, spin, d->M + b->dd, w->Mdot);
    product(n, w->Mdot, d->V + b->v, dMV);
    if (accelerated) product(n, w->Mdot, d->A + b->v, dMA);
    store(b, accelerated, dMV, dh, dMdotV, dMA, P);
}

/* How many columns of the pose turn the body, and the first of them. */
static int rotations(const mbsri_body *b, int *first)
{
    *first = 0;
    if (b->joint.space == MBSR_SPACE_SPATIAL) return 3;
    *first = 2;
    return b->inertia.kind == MBSR_INERTIA_PLANAR;
}

static void stock_columns(const mbsri_body *b, const mbsr_data *d, bool accelerated, const room *w,
                          double *P)
{
    const int n = b->d, e = mbsri_pose_size(b), rows = accelerated ? 3 * n : 2 * n;
    const double *M = d->M + b->dd, *V = d->V + b->v;
    int first;
    const int turns = rotations(b, &first);
    quadratic(b, d, V, w, w->h, w->MdotV);
    for (int k = 0; k < turns; ++k)
        rotation_column(b, d, k, accelerated, w, P + (size_t)rows * (size_t)(first + k));
    double *dV = w->TV, *dh = w->T, *dMdotV = w->TA;
    mbsri_zero((size_t)n, w->MA);
    for (int k = 0; k < n; ++k) {
        mbsri_zero((size_t)n, dV);
        dV[k] = 1.0;
        mbsri_zero((size_t)n, dh);
        mbsri_zero((size_t)n, dMdotV);
        if (turns) polarise(b, d, V, dV, w, dh, dMdotV);
        store(b, accelerated, M + (size_t)n * (size_t)k, dh, dMdotV, w->MA,
              P + (size_t)rows * (size_t)(e + k));
    }
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
                            bool accelerated, const room *w, double *dp, double *P)
{
    const mbsri_spans s = mbsri_spans_of(m, &b->joint.table->scales);
    const double rate = fmax(mbsri_span_rate(&s), mbsri_twist_rate(&s, b, d->V + b->v));
    const int n = b->d, e = mbsri_pose_size(b), rows = accelerated ? 3 * n : 2 * n;
    const double *p = d->p + b->p, *V = d->V + b->v;
    int status = MBSR_OK;
    for (int k = 0; k < e + n && !status; ++k, P += rows) {
        mbsri_zero((size_t)b->np, dp);
        if (k < e) mbsri_pose_unit(b->joint.space, k, p, dp);
        const double span = mbsri_binary(k < e ? mbsri_pose_span(&s, b, k)
                                               : mbsri_pose_span(&s, b, k - e) * rate),
                     h = step * span;
        for (int l = 0; l < 4 && !status; ++l) {
            mbsri_pose_move(b->joint.space, b->np, p, dp, mbsri_difference_place(l) * h, w->p);
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
        status = function_columns(m, b, d, accelerated, &w, w.dp + b->np, P);
    else if (b->inertia.kind == MBSR_INERTIA_FLEXIBLE)
        flexible_columns(b, d, accelerated, P, work);
    else
        stock_columns(b, d, accelerated, &w, P);
    if (status) return mbsri_joint_failed(m, d, i, status, "the inertia's function");
    /* columns of A: -M in the rows of mu */
    for (int k = 0; k < n && accelerated; ++k) {
        double *column = P + (size_t)(3 * n) * (size_t)(e + n + k) + 2 * (size_t)n;
        for (int l = 0; l < n; ++l) column[l] -= d->M[b->dd + (size_t)(k * n + l)];
    }
    return MBSR_OK;
}
