/* Where the Newton sweeps meet bodies of another kind: see border.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/sweeps/border.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "newton/front/front.h"
#include "sweeps/block.h"

#include <string.h>

static bool is_block(const mbsri_newton_sweeps *newton, int i)
{
    return (newton->tree->body[i].flags & MBSRI_BLOCK) != 0;
}

/* Whether joint i has a predecessor in the sweeps. */
static bool hands_over(const mbsri_newton_sweeps *newton, int i)
{
    const int parent = newton->tree->body[i].parent;
    return parent > 0 && !is_block(newton, parent);
}

static bool is_below_massless(const mbsri_newton_sweeps *newton, int i)
{
    return newton->last.below_massless && newton->step[i].below_massless & MBSRI_BELOW_MASSLESS;
}

/* Where number k of V, or of forces, of a body with d numbers stands among three axes; *linear:
 * which of the two groups. */
static int axis_of(int d, int k, int *linear)
{
    *linear = d == 6 ? k >= 3 : k != 2;
    return d == 6 ? k % 3 : k;
}

/* e_j x a */
static void turned(int j, const double a[3], double y[3])
{
    double axis[3] = {0.0, 0.0, 0.0};
    axis[j] = 1.0;
    mbsri_cross3(axis, a, y);
}

/* The numbers of body `at` that the conversion takes, and the sums over what is handed on. */
typedef struct meeting {
    int d;
    const double *omega, *v;
    double L[3], p[3], W_L[3], W_p[3];
} meeting;

/* ---- the matrix ---- */

/* Columns of dtheta at nu = 0 from those at d(omega, v) = 0, or with factor -1 back. */
static void turn_columns(const meeting *at, double factor, mbsri_newton_carry *c)
{
    for (int j = 0; j < 3; ++j) {
        double by_omega[3], by_v[3];
        turned(j, at->omega, by_omega);
        turned(j, at->v, by_v);
        for (int k = 0; k < 3; ++k) {
            const double *spin = c->P[SPIN][k][0], *drift = c->P[DRIFT][k][0];
            const double *spin_Y = c->Y[SPIN][k][0], *drift_Y = c->Y[DRIFT][k][0];
            const double a = factor * by_omega[k], b = factor * by_v[k];
            double *P = c->P[ROTATION][j][0], *Y = c->Y[ROTATION][j][0];
            for (int l = 0; l < 16; ++l) P[l] += a * spin[l] + b * drift[l];
            for (int l = 0; l < 8; ++l) Y[l] += a * spin_Y[l] + b * drift_Y[l];
        }
    }
}

/* + factor times what turning the sums adds. */
static void turn_sums(const meeting *at, double factor, mbsri_newton_carry *c)
{
    const double *const sum[] = {at->L, at->p, at->W_L, at->W_p};
    for (int j = 0; j < 3; ++j) {
        double *const to[] = {c->P[ROTATION][j][CHI_L], c->P[ROTATION][j][CHI_P],
                              c->Y[ROTATION][j][0], c->Y[ROTATION][j][1]};
        for (int l = 0; l < 4; ++l) {
            double x[3];
            turned(j, sum[l], x);
            mbsri_add3(factor, x, to[l]);
        }
    }
}

/* Moments + factor d(v x p), where p is that of a fixed frame. */
static void add_drift(const meeting *at, double factor, mbsri_newton_carry *c)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            double x[3];
            mbsri_cross3(at->v, c->P[g][j][CHI_P], x);
            mbsri_add3(factor, x, c->P[g][j][MOMENT]);
            if (g != DRIFT) continue;
            turned(j, at->p, x);
            mbsri_add3(factor, x, c->P[g][j][MOMENT]);
        }
    }
}

/* The column of number k of a body's perturbation. */
static void column_of(int d, int k, int *group, int *axis)
{
    int linear;
    const bool pose = k < d;
    *axis = axis_of(d, pose ? k : k - d, &linear);
    *group = pose ? (linear ? DISPLACEMENT : ROTATION) : linear ? DRIFT : SPIN;
}

/* carry = -P, number by number. */
static void take_matrix(int d, bool below_massless, const double *P, mbsri_newton_carry *c)
{
    const int rows = below_massless ? 3 * d : 2 * d;
    memset(c, 0, sizeof *c);
    for (int k = 0; k < 2 * d; ++k) {
        const double *x = P + rows * k;
        int group, axis;
        column_of(d, k, &group, &axis);
        for (int l = 0; l < d; ++l) {
            int linear;
            const int r = axis_of(d, l, &linear);
            c->P[group][axis][CHI_L + linear][r] = -x[l];
            c->P[group][axis][MOMENT + linear][r] = -x[d + l];
            if (below_massless) c->Y[group][axis][linear][r] = -x[2 * d + l];
        }
    }
}

/* P = -carry, likewise. */
static void give_matrix(int d, bool below_massless, const mbsri_newton_carry *c, double *P)
{
    const int rows = below_massless ? 3 * d : 2 * d;
    for (int k = 0; k < 2 * d; ++k) {
        double *x = P + rows * k;
        int group, axis;
        column_of(d, k, &group, &axis);
        for (int l = 0; l < d; ++l) {
            int linear;
            const int r = axis_of(d, l, &linear);
            x[l] = -c->P[group][axis][CHI_L + linear][r];
            x[d + l] = -c->P[group][axis][MOMENT + linear][r];
            if (below_massless) x[2 * d + l] = -c->Y[group][axis][linear][r];
        }
    }
}

static meeting meet(const mbsri_newton_sweeps *newton, int i)
{
    const mbsri_newton_own *own = newton->acting.own + i;
    return (meeting){.d = newton->model->body[i].d, .omega = own->omega, .v = own->v};
}

void mbsri_border_open(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    mbsri_front *f = newton->mixed;
    f->c = f->linear->c = newton->c;
    (void)mbsri_linear_mark(f->linear, run->data, run->rank);
}

/* The sums over what block i hands on, about the origin of its predecessor's own frame. */
static void take_sums(const mbsri_sweep_run *run, int i, const mbsri_flow *flow, meeting *at,
                      mbsri_newton_carry *c)
{
    const mbsri_body *b = run->model->body + i;
    const double *arm = run->load[b->parent].arm;
    double mu[6] = {0.0}, lifted[6];
    memcpy(c->L, flow->L, sizeof c->L), memcpy(c->p, flow->p, sizeof c->p);
    memcpy(c->N, flow->N, sizeof c->N), memcpy(c->F, flow->F, sizeof c->F);
    double back[3] = {-arm[0], -arm[1], -arm[2]};
    mbsri_add_cross3(back, c->p, c->L);
    mbsri_add_cross3(back, c->F, c->N);
    memcpy(at->L, c->L, sizeof at->L), memcpy(at->p, c->p, sizeof at->p);
    mbsri_atx(b->d, b->pred.d, 1.0, run->data->H + b->dp, run->data->mu + b->v, mu);
    mbsri_lift(b->pred.d, mu, lifted);
    memcpy(at->W_L, lifted, sizeof at->W_L), memcpy(at->W_p, lifted + 3, sizeof at->W_p);
}

int mbsri_border_eliminate(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                           mbsri_newton_carry *carry)
{
    const int parent = newton->tree->body[i].parent;
    mbsri_flow flow = {0};
    mbsri_block_momentum(run, i, &flow);
    const int status = mbsri_front_pass_body(newton->mixed, run->data, i);
    if (status || !hands_over(newton, i)) return status;
    meeting at = meet(newton, parent);
    const bool below_massless = is_below_massless(newton, parent);
    take_matrix(at.d, below_massless, mbsri_front_matrix(newton->mixed, i), carry);
    take_sums(run, i, &flow, &at, carry);
    add_drift(&at, 1.0, carry);
    turn_columns(&at, 1.0, carry);
    turn_sums(&at, -1.0, carry);
    return MBSR_OK;
}

void mbsri_border_give(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                       mbsri_newton_carry *carry)
{
    const int parent = newton->tree->body[i].parent;
    const bool below_massless = is_below_massless(newton, parent);
    const double *rho = run->state[i].rho;
    meeting at = meet(newton, parent);
    memcpy(at.L, carry->L, sizeof at.L), memcpy(at.p, carry->p, sizeof at.p);
    if (below_massless) {
        const double *W = newton->reaction[i].W;
        memcpy(at.W_L, W, sizeof at.W_L), memcpy(at.W_p, W + 4, sizeof at.W_p);
        mbsri_add_cross3(rho, W + 4, at.W_L);
    } else {
        memset(carry->Y, 0, sizeof carry->Y);
    }
    turn_columns(&at, -1.0, carry);
    turn_sums(&at, 1.0, carry);
    add_drift(&at, -1.0, carry);
    double *P = mbsri_front_matrix(newton->mixed, i);
    if (below_massless) mbsri_zero((size_t)(9 * at.d * at.d), P); /* over A, too */
    give_matrix(at.d, below_massless, carry, P);
    mbsri_front_hand_on(newton->mixed, i);
    mbsri_flow flow = {0};
    memcpy(flow.L, carry->L, sizeof flow.L), memcpy(flow.p, carry->p, sizeof flow.p);
    memcpy(flow.N, carry->N, sizeof flow.N), memcpy(flow.F, carry->F, sizeof flow.F);
    mbsri_block_receive_flow(run, parent, &flow);
}

/* ---- solving ---- */

/* factor times x of six numbers from d. */
static void take_six(int d, double factor, const double *x, double angular[4], double linear[4])
{
    double lifted[6];
    mbsri_lift(d, x, lifted);
    for (int k = 0; k < 3; ++k) {
        angular[k] = factor * lifted[k];
        linear[k] = factor * lifted[3 + k];
    }
}

void mbsri_border_reduce(mbsri_newton_sweeps *newton, int i, const double *r, const double *load,
                         mbsri_newton_flow *flow)
{
    mbsri_front *f = newton->mixed;
    const mbsri_body *b = newton->model->body + i;
    const bool over = hands_over(newton, i);
    double *y = f->h + f->names[b->parent].y, *w = f->wbar + b->pred.v;
    if (over) mbsri_zero((size_t)(3 * b->pred.d), y), mbsri_zero((size_t)b->pred.d, w);
    for (int k = 0; k < b->n && load; ++k)
        f->h[f->names[i].tau + k] -= load[newton->model->size.v + (size_t)(b->iu + k)];
    mbsri_front_reduce(f, i, r);
    memset(flow, 0, sizeof *flow);
    if (!over) return;
    const meeting at = meet(newton, b->parent);
    take_six(at.d, 1.0, y, flow->b + 4 * CHI_L, flow->b + 4 * CHI_P);
    take_six(at.d, 1.0, y + at.d, flow->b + 4 * MOMENT, flow->b + 4 * FORCE);
    take_six(at.d, 1.0, y + 2 * at.d, flow->psi, flow->psi + 4);
    take_six(at.d, -1.0, w, flow->L_bar, flow->p_bar);
    mbsri_add_cross3(at.v, flow->b + 4 * CHI_P, flow->b + 4 * MOMENT);
}

/* y += factor (angular, linear) */
static void add_six(int d, double factor, const double angular[3], const double linear[3],
                    double *y)
{
    double x[6], lowered[6];
    memcpy(x, angular, 3 * sizeof *x), memcpy(x + 3, linear, 3 * sizeof *x);
    mbsri_lower(d, x, lowered);
    for (int k = 0; k < d; ++k) y[k] += factor * lowered[k];
}

void mbsri_border_give_flow(mbsri_newton_sweeps *newton, int i, const mbsri_newton_flow *flow)
{
    mbsri_front *f = newton->mixed;
    const mbsri_body *b = newton->model->body + i;
    const meeting at = meet(newton, b->parent);
    double *y = f->h + f->names[b->parent].y, moment[3];
    mbsri_cross3(at.v, flow->b + 4 * CHI_P, moment);
    for (int k = 0; k < 3; ++k) moment[k] = flow->b[4 * MOMENT + k] - moment[k];
    add_six(at.d, 1.0, flow->b + 4 * CHI_L, flow->b + 4 * CHI_P, y);
    add_six(at.d, 1.0, moment, flow->b + 4 * FORCE, y + at.d);
    if (is_below_massless(newton, b->parent))
        add_six(at.d, 1.0, flow->psi, flow->psi + 4, y + 2 * at.d);
    add_six(at.d, -1.0, flow->L_bar, flow->p_bar, f->wbar + b->pred.v);
}

double *mbsri_border_room(mbsri_newton_sweeps *newton, int i)
{
    return newton->mixed->value + newton->mixed->names[i].x;
}

void mbsri_border_substitute(mbsri_newton_sweeps *newton, int i)
{
    const int parent = newton->tree->body[i].parent;
    const size_t d = (size_t)newton->model->body[parent].d;
    if (hands_over(newton, i)) mbsri_zero(d, mbsri_border_room(newton, parent) + 2 * d); /* dA */
    mbsri_front_substitute(newton->mixed, i);
}

void mbsri_border_motion(const mbsri_newton_sweeps *newton, int block, double x[16])
{
    const meeting at = meet(newton, block);
    const double *own = newton->mixed->value + newton->mixed->names[block].x;
    double pose[6], V[6], turn[3];
    mbsri_lift(at.d, own, pose);
    mbsri_lift(at.d, own + at.d, V);
    mbsri_cross3(pose, at.omega, turn);
    mbsri_add3(-1.0, turn, V);
    mbsri_cross3(pose, at.v, turn);
    mbsri_add3(-1.0, turn, V + 3);
    memset(x, 0, 16 * sizeof *x);
    memcpy(x + 4 * ROTATION, pose, 3 * sizeof *x);
    memcpy(x + 4 * SPIN, V, 3 * sizeof *x);
    memcpy(x + 4 * DRIFT, V + 3, 3 * sizeof *x);
    memcpy(x + 4 * DISPLACEMENT, pose + 3, 3 * sizeof *x);
}
