/* Bodies of any kind among those of the vectorised sweeps: see block.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/block.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/errors.h"
#include "recursion/flexible_factors.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/momentum.h"
#include "recursion/rates.h"
#include "sweeps/show.h"

#include <math.h>
#include <string.h>

/* ---- six numbers and those of a body ---- */

/* Where number k of a body's V stands among six. */
static int index_among_six(int d, int k)
{
    if (d == 6) return k;
    return k == 2 ? 2 : 3 + k;
}

/* A (6 x 6) += B (d x d), and back. */
static void lift_matrix(int d, const double *B, double A[36])
{
    memset(A, 0, 36 * sizeof *A);
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k)
            A[6 * index_among_six(d, j) + index_among_six(d, k)] = B[j * d + k];
    }
}

static void add_lowered(int d, const double A[36], double *B)
{
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k)
            B[j * d + k] += A[6 * index_among_six(d, j) + index_among_six(d, k)];
    }
}

/* A <- X^T A X with X = [1 0; -[arm]x 1]: from a point to one from which it is `arm` away. */
static void translate_matrix(const double arm[3], double A[36])
{
    double B[36] = {0.0};
    if (arm[0] == 0.0 && arm[1] == 0.0 && arm[2] == 0.0) return;
    mbsri_translate_matrix(arm, A, B);
    memcpy(A, B, sizeof B);
}

/* x (wrench) <- X^T x */
static void translate_force(const double arm[3], double x[6])
{
    mbsri_add_cross3(arm, x + 3, x);
}

static bool is_block_body(const mbsri_sweeps *tree, int i)
{
    return (tree->body[i].flags & MBSRI_BLOCK) != 0;
}

/* y (6) = H^T x of body i, as its predecessor in the sweeps has it. */
static void through_H(const mbsri_body *b, const double *H, const double *x, double y[6])
{
    double own[6] = {0.0};
    mbsri_atx(b->d, b->pred.d, 1.0, H, x, own);
    mbsri_lift(b->pred.d, own, y);
}

/* ---- root to leaves ---- */

/* Whether its V are the numbers of a twist, or some of them; on others stand only blocks. */
static bool has_twist(const mbsri_body *b)
{
    return b->joint.space != MBSR_SPACE_GENERAL && b->joint.space != MBSR_SPACE_FLEXIBLE;
}

static void place_state(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *d = run->data;
    mbsri_sweep_state *s = run->state + i;
    const double *pred = run->load[b->parent].r;
    double R[9], r[3], V[6];
    if (!has_twist(b)) return;
    memset(s, 0, sizeof *s);
    mbsri_embedded_pose(b->joint.space, d->p + b->p, R, r);
    mbsri_lift(b->d, d->V + b->v, V);
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = R[k];
    for (int k = 0; k < 3; ++k) {
        run->load[i].r[k] = r[k];
        s->rho[k] = r[k] - pred[k];
        s->omega[k] = V[k];
        s->v[k] = V[3 + k];
    }
    memset(run->load[i].arm, 0, sizeof run->load[i].arm);
    run->load[i].r[3] = b->joint.space == MBSR_SPACE_PLANAR ? d->p[b->p + 2] : 0.0;
}

int mbsri_block_move(const mbsri_sweep_run *run, int i)
{
    const mbsr_model *m = run->model;
    const int parent = m->body[i].parent;
    if (parent > 0 && !is_block_body(run->tree, parent)) mbsri_sweeps_show(run, parent);
    int status = mbsri_position_of(m, run->data, i);
    if (!status) status = mbsri_velocity_of(m, run->data, i);
    if (!status) place_state(run, i);
    return status;
}

/* A += (0, omega x (omega x arm)): from the point of a body in the sweeps to its own origin. */
static void add_swing(const mbsri_sweep_run *run, int i, double A[6])
{
    const mbsri_sweep_state *s = run->state + i;
    double swing[3];
    mbsri_cross3(s->omega, run->load[i].arm, swing);
    mbsri_add_cross3(s->omega, swing, A + 3);
}

/* A of the predecessor about its own origin, gravity put back: + alpha x arm and the swing. */
static void show_acceleration(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    const mbsri_sweep_state *s = run->state + i;
    double A[6];
    for (int k = 0; k < 3; ++k) {
        A[k] = s->A_w[k];
        A[3 + k] = s->A_v[k] + run->tree->gravity[k];
    }
    mbsri_add_cross3(s->A_w, run->load[i].arm, A + 3);
    add_swing(run, i, A);
    mbsri_lower(b->d, A, run->data->A + b->v);
}

static void need_acceleration(const mbsri_sweep_run *run, int i)
{
    const int parent = run->model->body[i].parent;
    if (parent > 0 && !is_block_body(run->tree, parent)) show_acceleration(run, parent);
}

static void place_acceleration(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    mbsri_sweep_state *s = run->state + i;
    double A[6];
    if (!has_twist(b)) return;
    mbsri_lift(b->d, run->data->A + b->v, A);
    for (int k = 0; k < 3; ++k) {
        s->A_w[k] = A[k];
        s->A_v[k] = A[3 + k] - run->tree->gravity[k];
    }
}

void mbsri_block_open_forward(const mbsri_sweep_run *run, int i)
{
    need_acceleration(run, i);
}

void mbsri_block_close_forward(const mbsri_sweep_run *run, int i)
{
    place_acceleration(run, i);
}

void mbsri_block_accelerate(const mbsri_sweep_run *run, int i)
{
    need_acceleration(run, i);
    mbsri_accelerate(run->model, run->data, i, run->tau + run->tree->body[i].u);
    place_acceleration(run, i);
}

void mbsri_block_balance(const mbsri_sweep_run *run, int i)
{
    if (!mbsri_heads(run->model, run->data, i)) return;
    const mbsri_group g = mbsri_group_of(run->model, run->data, i);
    double balance[MBSR_MAX_D];
    mbsri_balance_of(run->model, run->data, &g, balance);
    mbsri_block_rates(run, &g, balance, run->balance);
}

void mbsri_block_rates(const mbsri_sweep_run *run, const mbsri_group *g, const double *x,
                       double *out)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = run->model->body + g->member[k];
        mbsri_copy((size_t)b->n, x + b->group.iu - g->ig, out + b->iu);
    }
}

/* ---- leaves to root ---- */

int mbsri_block_forces(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    int status = MBSR_OK;
    for (int k = 0; k < run->tree->blocks && !status; ++k) {
        const mbsri_body *b = m->body + run->tree->block_of[k];
        for (int l = 0; l < b->d; ++l) d->f[b->v + (size_t)l] = -d->h[b->v + (size_t)l];
        status = mbsri_weigh(m, d, run->tree->block_of[k]);
    }
    return status;
}

void mbsri_block_open(const mbsri_sweep_run *run)
{
    mbsr_data *d = run->data;
    for (int k = 0; k < run->tree->blocks; ++k) {
        const mbsri_body *b = run->model->body + run->tree->block_of[k];
        const size_t dd = (size_t)b->d * (size_t)b->d;
        if (!mbsri_factors_open(run->model, d, run->tree->block_of[k])) {
            mbsri_copy(dd, d->M + b->dd, d->Mbar + b->dd);
            mbsri_zero(dd, d->W + b->dd);
        }
        d->rotated[b->scalar_offset] = mbsri_own_rotated(b, d->M + b->dd);
        mbsri_copy((size_t)b->d, d->f + b->v, d->fbar + b->v);
        double *bound = run->load[run->tree->block_of[k]].bound;
        bound[0] = bound[1] = bound[2] = 0.0;
    }
}

int mbsri_block_open_momentum(const mbsri_sweep_run *run)
{
    mbsr_data *d = run->data;
    int status = MBSR_OK;
    for (int k = 0; k < run->tree->blocks && !status; ++k) {
        const mbsri_body *b = run->model->body + run->tree->block_of[k];
        mbsri_zero((size_t)b->d, d->imp + b->v);
        mbsri_zero((size_t)b->d, d->sigma + b->v);
        mbsri_zero((size_t)b->d, d->impbar + b->v);
        status = mbsri_rates_of(run->model, d, run->tree->block_of[k]);
    }
    return status;
}

/* (0, g) */
static void weight_of_unit(const mbsri_sweep_run *run, double g[6])
{
    for (int k = 0; k < 3; ++k) g[k] = 0.0, g[3 + k] = run->tree->gravity[k];
}

/* What body i handed to the arrays of its predecessor in the sweeps, about that one's point. */
static void collect(const mbsri_sweep_run *run, int i, mbsri_carry *c)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *d = run->data;
    const double *arm = run->load[b->parent].arm;
    double A[36], a[6], y[6];
    lift_matrix(b->pred.d, d->Mbar + b->pred.dd, A);
    /* p = H^T mu + Mbar (0, g + omega x (omega x arm)) */
    through_H(b, d->H + b->dp, d->mu + b->v, y);
    weight_of_unit(run, a);
    add_swing(run, b->parent, a);
    mbsri_ax(6, 6, 1.0, A, a, y);
    translate_force(arm, y);
    translate_matrix(arm, A);
    mbsri_carry_from(A, c);
    memcpy(c->L, y, 3 * sizeof *y);
    memcpy(c->p, y + 3, 3 * sizeof *y);
}

/* The same of W: in blocks where `exact`, else as a spread. */
static void collect_errors(const mbsri_sweep_run *run, int i, bool exact, mbsri_carry *c,
                           mbsri_carry *W)
{
    const mbsri_body *b = run->model->body + i;
    const double per_area = 1.0 / (run->tree->length * run->tree->length);
    double N[36];
    lift_matrix(b->pred.d, run->data->W + b->pred.dd, N);
    translate_matrix(run->load[b->parent].arm, N);
    for (int k = 0; k < 3; ++k) c->spread += N[7 * k] * per_area + N[7 * (3 + k)];
    if (exact) {
        mbsri_carry_from(N, W);
        W->spread = run->data->rotated[run->model->body[b->parent].scalar_offset];
    }
}

static bool is_below_rigid(const mbsri_sweep_run *run, int i)
{
    const int parent = run->model->body[i].parent;
    return parent > 0 && !is_block_body(run->tree, parent);
}

/* Room for what body i hands to a predecessor in the sweeps. */
static void clear_predecessor(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    const size_t dd = (size_t)b->pred.d * (size_t)b->pred.d;
    mbsri_zero(dd, run->data->Mbar + b->pred.dd);
    mbsri_zero(dd, run->data->W + b->pred.dd);
    run->data->rotated[run->model->body[b->parent].scalar_offset] = 0.0;
}

bool mbsri_block_backward(const mbsri_sweep_run *run, int i, bool exact, mbsri_carry *c,
                          mbsri_carry *W)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    const int status = mbsri_eliminate_joint(m, d, i, MBSRI_RANK_QUICKLY);
    const bool by_pivots = status == MBSRI_BY_PIVOTS;
    if (status && !by_pivots) return false;
    if (mbsri_heads(m, d, i)) {
        const mbsri_group g = mbsri_group_of(m, d, i);
        const bool lacks = mbsri_group_rank(d, &g) < g.n;
        /* without a scale of the model, projections depend on all of W: they are those of the
         * stages, for every caller alike */
        if (lacks && g.n > 1 && !m->typical.inertia) return false;
        if (lacks && !exact && !(run->tree->body[i].flags & MBSRI_SHARP)) return false;
    }
    if (is_below_rigid(run, i)) clear_predecessor(run, i);
    mbsri_load_joint(m, d, i);
    mbsri_pass_masses(m, d, i, by_pivots);
    if (!is_below_rigid(run, i)) return true;
    collect(run, i, c);
    collect_errors(run, i, exact, c, W);
    return true;
}

void mbsri_block_before_bound(const mbsri_sweep_run *run, int i)
{
    if (is_below_rigid(run, i)) clear_predecessor(run, i);
}

void mbsri_block_after_bound(const mbsri_sweep_run *run, int i, mbsri_carry *c)
{
    const int parent = run->model->body[i].parent;
    const double *bound = run->load[i].bound;
    if (!is_below_rigid(run, i)) {
        double *above = run->load[parent].bound;
        above[0] = fmax(above[0], bound[0]);
        above[1] += bound[1];
        return;
    }
    const double arm = mbsri_norm3(run->load[parent].arm) / run->tree->length;
    collect(run, i, c);
    c->kappa = bound[0];
    c->spread = bound[1] * (1.0 + arm) * (1.0 + arm);
}

void mbsri_block_receive(const mbsri_sweep_run *run, int block, const mbsri_carry *c,
                         const mbsri_carry *W)
{
    const mbsri_body *b = run->model->body + block;
    mbsr_data *d = run->data;
    double A[36] = {0.0}, N[36] = {0.0}, g[6], y[6] = {0.0}, lowered[6],
           *bound = run->load[block].bound;
    const double area = run->tree->length * run->tree->length;
    mbsri_carry_add_to(c, A);
    add_lowered(b->d, A, d->Mbar + b->dd);
    if (W) {
        mbsri_carry_add_to(W, N);
        add_lowered(b->d, N, d->W + b->dd);
        d->rotated[b->scalar_offset] += W->spread;
    } else if (run->tree->body[block].flags & MBSRI_BOUNDED) {
        bound[0] = fmax(bound[0], c->kappa);
        bound[1] += c->spread;
    } else {
        for (int k = 0; k < 36; ++k) N[k] = c->kappa * A[k];
        for (int k = 0; k < 6; ++k) N[7 * k] += c->spread * (k < 3 ? area : 1.0);
        add_lowered(b->d, N, d->W + b->dd);
    }
    /* fbar -= p - Mbar (0, g) */
    weight_of_unit(run, g);
    mbsri_ax(6, 6, 1.0, A, g, y);
    for (int k = 0; k < 3; ++k) y[k] -= c->L[k], y[3 + k] -= c->p[k];
    mbsri_lower(b->d, y, lowered);
    for (int k = 0; k < b->d; ++k) d->fbar[b->v + (size_t)k] += lowered[k];
}

/* ---- inverse dynamics ---- */

void mbsri_block_open_reaction(const mbsri_sweep_run *run)
{
    for (int k = 0; k < run->tree->blocks; ++k)
        mbsri_open_reaction(run->model, run->data, run->tree->block_of[k]);
}

void mbsri_block_react(const mbsri_sweep_run *run, int i, double L[4], double p[4])
{
    const mbsri_body *b = run->model->body + i;
    mbsr_data *d = run->data;
    double *out = run->out + run->tree->body[i].u, y[6];
    /* J^T mu; tau is subtracted from all joint forces in the end */
    mbsri_react(run->model, d, i, out);
    for (int k = 0; k < b->n; ++k)
        out[k] += d->tau[b->iu + k] + b->mass.armature[k] * run->tau[run->tree->body[i].u + k];
    memset(L, 0, 4 * sizeof *L);
    memset(p, 0, 4 * sizeof *p);
    if (b->parent == 0 || is_block_body(run->tree, b->parent)) return;
    through_H(b, d->H + b->dp, d->mu + b->v, y);
    translate_force(run->load[b->parent].arm, y);
    memcpy(L, y, 3 * sizeof *y);
    memcpy(p, y + 3, 3 * sizeof *y);
}

void mbsri_block_receive_force(const mbsri_sweep_run *run, int block, const double L[4],
                               const double p[4])
{
    const mbsri_body *b = run->model->body + block;
    const double y[6] = {L[0], L[1], L[2], p[0], p[1], p[2]};
    double lowered[6];
    mbsri_lower(b->d, y, lowered);
    for (int k = 0; k < b->d; ++k) run->data->mu[b->v + (size_t)k] -= lowered[k];
}

/* ---- momentum form ---- */

/* -(.) of what body i hands to its predecessor in the sweeps, about that one's own origin. */
static void hand_momenta(const mbsri_sweep_run *run, int i, mbsri_flow *flow)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *d = run->data;
    const double *arm = run->load[b->parent].arm, *H = d->H + b->dp;
    double momentum[6], rate[6], turning[6], bar[6], V[6];
    through_H(b, H, d->imp + b->v, momentum);
    through_H(b, H, d->sigma + b->v, rate);
    through_H(b, d->Hdot + b->dp, d->imp + b->v, turning);
    through_H(b, H, d->impbar + b->v, bar);
    mbsri_lift(b->pred.d, d->V + b->pred.v, V);
    for (int k = 0; k < 6; ++k) rate[k] += turning[k];
    /* N = (.) + v x p */
    mbsri_add_cross3(V + 3, momentum + 3, rate);
    translate_force(arm, momentum);
    translate_force(arm, rate);
    translate_force(arm, bar);
    memset(flow, 0, sizeof *flow);
    memcpy(flow->L, momentum, 3 * sizeof *momentum);
    memcpy(flow->p, momentum + 3, 3 * sizeof *momentum);
    memcpy(flow->N, rate, 3 * sizeof *rate);
    memcpy(flow->F, rate + 3, 3 * sizeof *rate);
    memcpy(flow->L_bar, bar, 3 * sizeof *bar);
    memcpy(flow->p_bar, bar + 3, 3 * sizeof *bar);
}

void mbsri_block_momentum(const mbsri_sweep_run *run, int i, mbsri_flow *flow)
{
    const mbsr_model *m = run->model;
    const mbsri_body *b = m->body + i;
    mbsr_data *d = run->data;
    const int u = run->tree->body[i].u;
    mbsri_momentum_of(m, d, i, run->out + u);
    mbsri_momentum_rate_of(m, d, i, run->out + u);
    if (run->p) mbsri_condense_of(m, d, i, run->p + u);
    if (b->parent > 0 && !is_block_body(run->tree, b->parent)) hand_momenta(run, i, flow);
}

void mbsri_block_receive_flow(const mbsri_sweep_run *run, int block, const mbsri_flow *flow)
{
    const mbsri_body *b = run->model->body + block;
    mbsr_data *d = run->data;
    double V[6], x[3][6], lowered[6];
    double *const to[3] = {d->imp + b->v, d->sigma + b->v, d->impbar + b->v};
    mbsri_lift(b->d, d->V + b->v, V);
    memcpy(x[0], flow->L, 3 * sizeof(double)), memcpy(x[0] + 3, flow->p, 3 * sizeof(double));
    memcpy(x[1], flow->N, 3 * sizeof(double)), memcpy(x[1] + 3, flow->F, 3 * sizeof(double));
    memcpy(x[2], flow->L_bar, 3 * sizeof(double));
    memcpy(x[2] + 3, flow->p_bar, 3 * sizeof(double));
    /* N - v x p */
    mbsri_add_cross3(x[0] + 3, V + 3, x[1]);
    for (int l = 0; l < 3; ++l) {
        mbsri_lower(b->d, x[l], lowered);
        for (int k = 0; k < b->d; ++k) to[l][k] -= lowered[k];
    }
}
