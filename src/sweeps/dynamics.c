/* Forward and inverse dynamics by the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/dynamics.h"

#include "base/expect.h"
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/group.h"
#include "recursion/kinematics.h"
#include "recursion/spans.h"
#include "sweeps/loads.h"
#include "sweeps/loops.h"
#include "sweeps/split.h"

#include <math.h>
#include <string.h>

/* The caller's vectors in the order of the sweeps; `kept`: in the data, where elements look. */
static const double *in_sweep_order(const mbsr_model *m, bool kept, int n, const int *place,
                                    const double *caller, double *own)
{
    if (m->order.as_given && !kept) return caller;
    if (m->order.as_given) return memmove(own, caller, (size_t)n * sizeof *own);
    for (int k = 0; k < n; ++k) own[k] = caller[place[k]];
    return own;
}

/* Gravity is an acceleration of the whole world the other way. */
int mbsri_sweeps_move_root(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    mbsri_sweep_state *s = run->state;
    memset(s, 0, sizeof *s);
    for (int k = 0; k < 3; ++k) {
        s->R[5 * k] = 1.0;
        s->A_v[k] = -run->tree->gravity[k];
    }
    if (m->root.space == MBSR_SPACE_FIXED) return MBSR_OK;
    double R[9], r[3], V[6], A[6];
    const int status = mbsri_embedded_root(m, d, R, r, V, A);
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = R[k];
    for (int k = 0; k < 3; ++k) {
        s->omega[k] = V[k];
        s->v[k] = V[3 + k];
        s->A_w[k] = A[k];
        s->A_v[k] += A[3 + k];
    }
    return status;
}

/* Kinematics, and what force elements exert; tau (by the caller's order, may be NULL) is added to
 * their joint forces in the data. */
static int forces(mbsri_sweep_run *run, const double *tau, bool velocity)
{
    const mbsr_model *m = run->model;
    const mbsri_sweeps *tree = run->tree;
    mbsr_data *d = run->data;
    run->tau = d->tau;
    const int status = run->split              ? mbsri_split_move(run, run->split, velocity)
                       : velocity || run->load ? tree->kernels->velocities(run)
                                               : tree->kernels->kinematics(run);
    if (status) return MBSRI_NOT_SERVED; /* the stages say of which joint */
    if (!tree->joint_forces && !run->load && tau) {
        run->tau = in_sweep_order(m, false, m->nu, m->order.u_of, tau, d->tau);
        return MBSR_OK;
    }
    if (tau)
        mbsri_gather(m, tau, d->tau);
    else
        mbsri_zero((size_t)m->nu, d->tau);
    const int refused = tree->joint_forces ? mbsri_joint_elements(m, d, run->q, run->u) : MBSR_OK;
    return refused || !run->load ? refused : mbsri_sweeps_loads(run);
}

/* Groups are eliminated joint by joint, but for those that are coupled. */
static void take_apart(const mbsr_model *m, const mbsri_sweeps *tree, mbsr_data *d)
{
    d->single = !m->order.grouped || !tree->whole;
    for (int i = 1; i <= m->bodies && !d->single; ++i) d->apart[i] = !m->body[i].group.coupled;
}

void mbsri_sweeps_attach(mbsri_sweep_run *run, const mbsr_model *m, const mbsri_sweeps *tree,
                         mbsr_data *d)
{
    *run = (mbsri_sweep_run){.model = m,
                             .data = d,
                             .tree = tree,
                             .state = d->sweep.state,
                             .multi = d->sweep.multi,
                             .stack = d->sweep.stack,
                             .noise = d->sweep.noise,
                             .flows = d->sweep.flows,
                             .load = tree->body_forces ? d->sweep.load : NULL,
                             .sincos = d->sincos,
                             .q = d->q,
                             .u = d->u,
                             .tau = d->tau,
                             .out = d->out,
                             .rank = d->rank};
    d->stage = MBSRI_STAGE_NONE;
    d->accelerated = false;
    take_apart(m, tree, d);
}

/* split: by several threads, where the data says so. */
static int prepare_run(mbsri_sweep_run *run, const mbsr_model *m, const mbsri_sweeps *tree,
                       mbsr_data *d, double t, const double *q, const double *u, double *out,
                       bool split)
{
    if (!tree || !isfinite(t)) return MBSRI_NOT_SERVED;
    if (!mbsri_finite((size_t)m->nq, q) || !mbsri_finite((size_t)m->nu, u)) return MBSRI_NOT_SERVED;
    mbsri_sweeps_attach(run, m, tree, d);
    run->q = in_sweep_order(m, tree->body_forces, m->nq, m->order.q_of, q, d->q);
    run->u = in_sweep_order(m, tree->body_forces, m->nu, m->order.u_of, u, d->u);
    if (m->order.as_given) run->out = out;
    d->t = t;
    const int from = run->tree->first_angle;
    if (split) run->split = mbsri_split_of(run);
    if (!run->split)
        run->tree->kernels->trigonometry(run->tree->angles, run->q + from, run->sincos + 2 * from);
    return mbsri_sweeps_move_root(run);
}

bool mbsri_sweeps_as_watched(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    const mbsr_data *d = run->data;
    for (int i = 1; i <= run->tree->bodies && d->watch.active; ++i) {
        if (m->body[i].group.head != i) continue;
        const mbsri_group g = mbsri_group_in_model(m, i);
        int change = 0;
        for (int k = 0; k < g.members; ++k)
            change += d->rank[g.member[k]] - d->watch.rank[g.member[k]];
        if (change != 0) return false;
    }
    return true;
}

bool mbsri_sweeps_coupled(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    for (int i = 1; i <= m->bodies && m->order.grouped; ++i) {
        const mbsri_group g = mbsri_group_in_model(m, i);
        if (g.members < 2) continue;
        if (mbsri_coupled(m, run->data, &g) && mbsri_apart(m, run->data, i)) return true;
    }
    return false;
}

/* What was found of the ranks. */
static bool as_expected(const mbsri_sweep_run *run)
{
    return mbsri_sweeps_as_watched(run) && !mbsri_sweeps_coupled(run);
}

static bool backward(const mbsri_sweep_run *run, bool velocity)
{
    const bool clear = run->split ? mbsri_split_backward(run, run->split, velocity) == 0
                                  : run->tree->kernels->backward(run);
    return clear && as_expected(run);
}

/* Results that are not finite are for the stages, which say where that begins. */
static int finite_or_not_served(int n, const double *x)
{
    return mbsri_finite((size_t)n, x) ? MBSR_OK : MBSRI_NOT_SERVED;
}

int mbsri_sweeps_forward_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                  const double *u, const double *tau, double *udot)
{
    mbsri_sweep_run run;
    int status = prepare_run(&run, m, m->tree.evaluated, d, t, q, u, udot, true);
    if (!status) status = forces(&run, tau, false);
    d->factors.allowed = true;
    if (!status && !backward(&run, false)) status = MBSRI_NOT_SERVED;
    if (!status && run.split)
        mbsri_split_forward(&run, run.split);
    else if (!status)
        run.tree->kernels->forward(&run);
    d->factors.allowed = false;
    if (status) return status;
    status = finite_or_not_served(m->nu, run.out);
    if (!status && !m->order.as_given) mbsri_scatter(m, run.out, udot);
    return status;
}

/* Whether all is finite, and of no row more is left than rounding of accelerations or, where these
 * are, of what is typical of the model: if so, loops/ says whether others contradict it. */
static bool loops_are_closed(const mbsri_loop_run *w)
{
    static const double rounding = 1e-9;
    const mbsr_model *m = w->run->model;
    const double own = m->typical.frequency * m->typical.frequency * fmin(1.0, m->typical.length),
                 size = own + w->size + mbsri_largest(m->nu, w->run->out);
    return mbsri_finite((size_t)m->nu, w->run->out) && mbsri_finite((size_t)m->rows, w->v) &&
           mbsri_largest(m->rows, w->rest) <= rounding * size;
}

int mbsri_sweeps_loops_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                const double *u, const double *tau, double *udot)
{
    mbsri_sweep_run run;
    mbsri_loop_run loops;
    if (!m->tree.evaluated || !m->tree.evaluated->loops) return MBSRI_NOT_SERVED;
    int status = prepare_run(&run, m, m->tree.evaluated, d, t, q, u, d->out, false);
    if (status) return status;
    mbsri_open_loops_place(&loops, &run);
    run.springs = true;
    run.bias = loops.rest;
    status = forces(&run, tau, false);
    if (status) return status;
    mbsri_open_loops_begin(&loops);
    if (!run.tree->kernels->loops_backward(&loops)) return MBSRI_NOT_SERVED;
    run.tree->kernels->loops_forward(&loops);
    if (!loops_are_closed(&loops)) return MBSRI_NOT_SERVED;
    for (int k = 0; k < m->rows; ++k) d->loop_lambda[k] += loops.v[k];
    mbsri_scatter(m, run.out, udot);
    mbsri_copy((size_t)m->nu, udot, d->udot_last);
    return MBSR_OK;
}

/* Joint forces that are missing, to `out` of the run. */
static int inverse(mbsri_sweep_run *run, const double *udot)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    const bool elements = run->tree->joint_forces || run->load;
    if (elements) mbsri_zero((size_t)m->nu, d->tau);
    const int status = run->load  ? forces(run, NULL, false)
                       : elements ? mbsri_joint_elements(m, d, run->q, run->u)
                                  : MBSR_OK;
    if (status) return status;
    run->tau = in_sweep_order(m, false, m->nu, m->order.u_of, udot, d->udot);
    if (run->split ? mbsri_split_inverse(run, run->split) : run->tree->kernels->inverse(run))
        return MBSRI_NOT_SERVED;
    for (int k = 0; k < m->nu && elements; ++k) run->out[k] -= d->tau[k];
    return finite_or_not_served(m->nu, run->out);
}

/* Nothing is eliminated here, so that no body need be whole. */
static const mbsri_sweeps *tree_of_inverse(const mbsr_model *m)
{
    if (m->rows > 0) return NULL;
    return m->tree.evaluated && m->tree.evaluated->whole ? m->tree.plain : m->tree.evaluated;
}

int mbsri_sweeps_inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                  const double *u, const double *udot, double *tau)
{
    mbsri_sweep_run run;
    int status = prepare_run(&run, m, tree_of_inverse(m), d, t, q, u, tau, true);
    if (!status) status = inverse(&run, udot);
    if (!status && !m->order.as_given) mbsri_scatter(m, run.out, tau);
    return status;
}

/* Whether so much of `out` less closure_w is left at joint rates without motors that they need
 * some. */
static bool some_missing(const mbsri_loop_run *w)
{
    static const double nothing = 1e-8; /* as in loops/forward.c */
    const mbsr_model *m = w->run->model;
    const double *need = w->run->out, *loops = w->run->data->closure_w;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double size = mbsri_largest(m->nu, need), most = 0.0;
    for (int k = 0; k < m->nu; ++k)
        most = w->motor[k] > 0.0 ? most : fmax(most, fabs(need[k] - loops[k]));
    if (!m->typical.span &&
        most * fmax(1.0, spans.length) <= nothing * size * fmin(1.0, spans.length))
        return false; /* whichever of them are forces */
    size = most = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        size = fmax(size, mbsri_joint_load(&spans, m, b, need + b->iu));
        for (int k = 0, rate = b->iu; k < b->n; ++k, ++rate) {
            if (w->motor[rate] > 0.0) continue;
            const double span = mbsri_coordinate_span(&spans, m, b, true, k);
            most = fmax(most, fabs(need[rate] - loops[rate]) * span);
        }
    }
    return most > nothing * size;
}

/* Of `out`, what loops with forces -v of their rows leave to motors, into out and tau; false: a
 * rate without one would need some. */
static bool take_torques(const mbsri_loop_run *w, double *tau)
{
    const mbsri_sweep_run *run = w->run;
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    for (int k = 0; k < m->rows; ++k) w->rest[k] = -w->v[k];
    mbsri_zero(m->size.v, d->closure_V);
    mbsri_zero((size_t)m->nu, d->closure_w);
    mbsri_closure_load(m, d, w->rest, d->closure_V, d->closure_w);
    mbsri_sweeps_push(run);
    if (some_missing(w)) return false;
    for (int k = 0; k < m->nu; ++k)
        run->out[k] = w->motor[k] > 0.0 ? run->out[k] - d->closure_w[k] : 0.0;
    if (!mbsri_finite((size_t)m->nu, run->out)) return false;
    mbsri_scatter(m, run->out, tau);
    return true;
}

int mbsri_sweeps_loops_inverse(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                               const double *u, const double *udot, const double *motor,
                               double *tau, double *lambda)
{
    mbsri_sweep_run run;
    mbsri_loop_run loops;
    if (!m->tree.evaluated || !m->tree.evaluated->loops) return MBSRI_NOT_SERVED;
    int status = prepare_run(&run, m, m->tree.evaluated, d, t, q, u, d->out, false);
    run.springs = true;
    run.out = d->out;
    if (!status) status = inverse(&run, udot);
    if (status) return status;
    mbsri_open_loops_place(&loops, &run);
    mbsri_zero((size_t)m->rows, loops.rest);
    mbsri_open_loops_begin(&loops);
    loops.motor = motor;
    if (!run.tree->kernels->loops_inverse(&loops)) return MBSRI_NOT_SERVED;
    if (!mbsri_finite((size_t)m->rows, loops.v) || !take_torques(&loops, tau))
        return MBSRI_NOT_SERVED;
    for (int k = 0; k < m->rows; ++k) lambda[k] = d->loop_lambda[k] - loops.v[k];
    return MBSR_OK;
}

/* G u of body i, where it is not u; with room for it in `rate`. */
static int coordinate_rate(const mbsri_sweep_run *run, int i, double *rate)
{
    const mbsri_body *b = run->model->body + i;
    const bool block = (run->tree->body[i].flags & MBSRI_BLOCK) != 0;
    mbsr_joint_args args = mbsri_joint_args(run->model, run->data, i, block);
    args.q = run->q + b->iq;
    args.u = run->u + b->iu;
    mbsri_zero((size_t)b->nq, rate);
    return b->joint.table->coordinate_rates(&args, rate);
}

/* q' - G u in the caller's order. */
static int rates_residual(const mbsri_sweep_run *run, const double *qdot, double *F)
{
    const mbsr_model *m = run->model;
    for (int k = 0; k < m->nq && m->order.plain_rates; ++k) F[k] = qdot[k] - run->u[k];
    for (int i = 1; i <= run->tree->bodies && !m->order.plain_rates; ++i) {
        const mbsri_body *b = m->body + i;
        double *own = F + b->q;
        if (b->joint.table->coordinate_rates) {
            const int status = coordinate_rate(run, i, own);
            if (status) return status;
            for (int k = 0; k < b->nq; ++k) own[k] = qdot[b->q + k] - own[k];
        } else {
            for (int k = 0; k < b->nq; ++k) own[k] = qdot[b->q + k] - run->u[b->iu + k];
        }
    }
    return MBSR_OK;
}

int mbsri_sweeps_inverse_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                  const double *yp, double *F)
{
    mbsri_sweep_run run;
    double *tau = F + m->nq;
    int status = prepare_run(&run, m, tree_of_inverse(m), d, t, y, y + m->nq, tau, true);
    if (!status) status = inverse(&run, yp + m->nq);
    if (status) return status;
    if (!m->order.as_given) mbsri_scatter(m, run.out, tau);
    return rates_residual(&run, yp, F) ? MBSRI_NOT_SERVED : finite_or_not_served(m->nq, F);
}

int mbsri_sweeps_open(mbsri_sweep_run *run, const mbsr_model *m, const mbsri_sweeps *tree,
                      mbsr_data *d, double t, const double *q, const double *u)
{
    const int status = prepare_run(run, m, tree, d, t, q, u, d->out, false);
    return status ? status : forces(run, NULL, true);
}

/* u + w C^T Eta' (forms/loops.c) where u is looked for from now on. */
static void correct_rates(mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    mbsri_sweeps_push(run);
    for (int k = 0; k < m->nu; ++k) d->w[k] = run->u[k] + m->typical.weight[k] * d->closure_w[k];
    run->u = d->w;
}

/* Whether a tree is one that does not fit into a cache, and may be taken in pieces. */
static bool is_large(const mbsri_sweep_run *run)
{
    const mbsri_sweeps *tree = run->tree;
    return tree->bodies > MBSRI_LARGE && tree->blocks == 0 && tree->users == 0 && !tree->whole &&
           !tree->modal && !run->split;
}

/* Rates of momenta and algebraic equations; or the sweeps do not serve. */
static int sweep_momenta(const mbsri_sweep_run *run)
{
    const mbsri_sweep_kernels *kernels = run->tree->kernels;
    if (is_large(run) && kernels->momenta(run))
        return as_expected(run) ? MBSR_OK : MBSRI_NOT_SERVED;
    if (!backward(run, true)) return MBSRI_NOT_SERVED;
    return !run->split && kernels->momentum(run) ? MBSRI_NOT_SERVED : MBSR_OK;
}

int mbsri_sweeps_momentum_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                   const double *yp, double *F)
{
    const double *p = y + m->nq, *u = p + m->nu;
    double *F_p = F + m->nq, *F_u = F_p + m->nu;
    mbsri_sweep_run run;
    const mbsri_sweeps *tree = m->tree.evaluated;
    if (!tree || !tree->rates) return MBSRI_NOT_SERVED;
    int status = prepare_run(&run, m, tree, d, t, y, u, d->out, true);
    if (m->rows > 0) run.eta = d->loop_eta;
    if (!status) status = forces(&run, NULL, true);
    if (status) return status;
    run.p = in_sweep_order(m, false, m->nu, m->order.u_of, p, d->w);
    run.balance = d->vec;
    d->factors.allowed = true;
    status = sweep_momenta(&run);
    d->factors.allowed = false;
    if (status) return status;
    for (int k = 0; k < m->nu; ++k) {
        F_p[m->order.u_of[k]] = yp[m->nq + m->order.u_of[k]] - run.out[k];
        F_u[m->order.u_of[k]] = run.balance[k];
    }
    if (m->rows > 0) correct_rates(&run);
    return rates_residual(&run, yp, F) ? MBSRI_NOT_SERVED
                                       : finite_or_not_served(m->nq + 2 * m->nu, F);
}
