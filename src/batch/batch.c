/* Forward and inverse dynamics at many states: groups of states in lanes, the rest one by one.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/error.h"
#include "batch/record.h"
#include "joints/chain.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "sweeps/block.h"
#include "sweeps/dynamics.h"
#include "sweeps/loads.h"
#include "sweeps/show.h"

#include <math.h>

/* A call, or a share of it: states from .. end - 1. */
typedef struct request {
    const mbsr_model *m;
    mbsr_batch *b;
    double t;
    int from, end;
    const double *q, *u, *load; /* load: tau, which may be NULL, for inverse dynamics u' */
    double *out;
    int *status;
    bool inverse;
} request;

static const double *state_of(const double *x, int n, int k)
{
    return x ? x + (size_t)n * (size_t)k : NULL;
}

/* ---- states in lanes ---- */

/* The same to the lanes' own data. */
static bool move_lane_roots(const request *r)
{
    mbsri_batch_run *run = &r->b->run;
    for (int l = 0; l < r->b->kernels->lanes; ++l) {
        mbsri_sweep_run *lane = run->lane + l;
        lane->data->t = r->t;
        if (mbsri_sweeps_move_root(lane)) return false;
        mbsri_sweeps_place_root(lane);
    }
    run->r[3] = run->lane->load->r[3];
    return true;
}

/* The root's state, the same for all; gravity is an acceleration of the whole world the other
 * way. */
static bool move_root(const request *r)
{
    const mbsr_model *m = r->m;
    mbsr_data *d = r->b->data;
    mbsri_batch_run *run = &r->b->run;
    double place[3], V[6];
    d->t = r->t;
    if (!isfinite(r->t) || mbsri_embedded_root(m, d, run->R, place, V, run->A)) return false;
    for (int k = 0; k < 3; ++k) {
        run->r[k] = place[k];
        run->v[k] = V[3 + k];
        run->omega[k] = V[k];
        run->A[3 + k] -= m->tree.plain->gravity[k];
    }
    return !run->lane || move_lane_roots(r);
}

/* Prescribed coordinates, likewise. False: a motion failed. */
static bool move_joints(const request *r)
{
    double *drive = r->b->run.drive;
    const mbsri_sweeps *tree = r->m->tree.plain;
    for (int k = 0; k < tree->multi; ++k) {
        const mbsri_joint *joint = &tree->joint[k].chain;
        double s[3][MBSRI_MAX_STEPS] = {{0.0}};
        if (!joint->motion) continue;
        if (joint->motion(joint->user, r->t, s[0], s[1], s[2])) return false;
        for (int step = 0; step < joint->option[0]; ++step) {
            const int code = joint->option[1 + step];
            if (!(code & MBSRI_DRIVEN)) continue;
            for (int l = 0; l < 3; ++l) *drive++ = s[l][code >> MBSRI_PLACE_SHIFT];
        }
    }
    return true;
}

/* Adds `sign` times what the force elements of joints exert on the state in lane l to x (lanes x
 * nu). False: an element failed. */
static bool add_joint_forces(const request *r, int l, double sign, double *x)
{
    const mbsr_model *m = r->m;
    mbsr_data *d = r->b->data;
    const int lanes = r->b->kernels->lanes;
    for (int k = 0; k < m->nq; ++k) d->q[k] = r->b->q[k * lanes + l];
    for (int k = 0; k < m->nu; ++k) d->u[k] = r->b->u[k * lanes + l];
    mbsri_zero((size_t)m->nu, d->tau);
    if (mbsri_joint_elements(m, d, d->q, d->u)) return false;
    for (int k = 0; k < m->nu; ++k) x[k * lanes + l] += sign * d->tau[k];
    return true;
}

static unsigned all_joint_forces(const request *r, int count, unsigned served, double sign,
                                 double *x)
{
    if (!r->m->tree.plain->joint_forces) return served;
    for (int l = 0; l < count; ++l) {
        const unsigned bit = 1u << l;
        if ((served & bit) && !add_joint_forces(r, l, sign, x)) served &= ~bit;
    }
    return served;
}

/* ---- with bodies that are looked at one state after the other ---- */

/* n numbers of lane l. */
static void lay(int lanes, int l, int n, const double *from, double *to)
{
    for (int k = 0; k < n; ++k) to[k] = from[k * lanes + l];
}

/* What the elements exert on the state in lane l: on bodies to its run, on joints `sign` times to x
 * (lanes x nu). False: an element failed. */
static bool load_lane(const request *r, int l, double sign, double *x)
{
    const mbsr_model *m = r->m;
    const mbsri_sweep_run *lane = r->b->run.lane + l;
    mbsr_data *d = lane->data;
    const int lanes = r->b->kernels->lanes;
    if (sign > 0.0)
        lay(lanes, l, m->nu, x, d->tau);
    else
        mbsri_zero((size_t)m->nu, d->tau);
    if (m->tree.plain->joint_forces && mbsri_joint_elements(m, d, d->q, d->u)) return false;
    if (mbsri_sweeps_loads(lane)) return false;
    for (int k = 0; k < m->nu && sign > 0.0; ++k) x[k * lanes + l] = d->tau[k];
    return true;
}

/* The lanes in `served`, which begin with the states' q, u and loads; returns which of them are. */
static unsigned seen_lanes(const request *r, int count, unsigned served)
{
    const mbsr_model *m = r->m;
    mbsr_batch *b = r->b;
    mbsri_batch_run *run = &b->run;
    const int lanes = b->kernels->lanes;
    const double sign = r->inverse ? -1.0 : 1.0;
    for (int l = 0; l < count; ++l) {
        mbsr_data *d = run->lane[l].data;
        lay(lanes, l, m->nq, b->q, d->q);
        lay(lanes, l, m->nu, b->u, d->u);
        run->lane[l].tau = r->inverse ? d->udot : d->tau;
        if (r->inverse) lay(lanes, l, m->nu, b->load, d->udot);
    }
    run->count = count;
    run->served = served;
    served = b->kernels->move_seen(run);
    for (int l = 0; l < count; ++l) {
        const unsigned bit = 1u << l;
        if ((served & bit) && !load_lane(r, l, sign, b->load)) served &= ~bit;
        if (!r->inverse && (served & bit)) mbsri_block_open(run->lane + l);
    }
    run->served = served;
    if (!r->inverse) return b->kernels->forward_seen(run);
    served = b->kernels->inverse_seen(run);
    for (int l = 0; l < count; ++l) {
        for (int k = 0; k < m->nu; ++k) run->out[k * lanes + l] -= run->lane[l].data->tau[k];
    }
    return served;
}

/* States first .. first + count - 1; returns which were served. */
static unsigned in_lanes(const request *r, int first, int count)
{
    const mbsr_model *m = r->m;
    mbsr_batch *b = r->b;
    const mbsri_batch_kernels *kernels = b->kernels;
    const int *q_place = b->q_place, *u_place = b->u_place;
    unsigned served = kernels->gather(m->nq, q_place, count, state_of(r->q, m->nq, first), b->q);
    served &= kernels->gather(m->nu, u_place, count, state_of(r->u, m->nu, first), b->u);
    if (r->load)
        served &= kernels->gather(m->nu, u_place, count, state_of(r->load, m->nu, first), b->load);
    else
        mbsri_zero((size_t)m->nu * (size_t)kernels->lanes, b->load);
    if (b->run.lane) {
        served = seen_lanes(r, count, served);
    } else if (r->inverse) {
        served &= kernels->inverse(&b->run);
        served = all_joint_forces(r, count, served, -1.0, b->run.out);
    } else {
        served = all_joint_forces(r, count, served, 1.0, b->load);
        served &= kernels->forward(&b->run);
    }
    return served & kernels->scatter(m->nu, u_place, count, b->run.out,
                                     r->out + (size_t)m->nu * (size_t)first);
}

/* ---- states one by one ---- */

static int alone(const request *r, int k)
{
    const mbsr_model *m = r->m;
    mbsr_batch *b = r->b;
    const double *q = state_of(r->q, m->nq, k), *u = state_of(r->u, m->nu, k),
                 *load = state_of(r->load, m->nu, k);
    double *out = r->out + (size_t)m->nu * (size_t)k;
    ++b->single;
    const int status = r->inverse ? mbsr_inverse_dynamics(m, b->data, r->t, q, u, load, NULL, out)
                                  : mbsr_forward_dynamics(m, b->data, r->t, q, u, load, out);
    if (status == MBSR_OK) return status;
    for (int l = 0; l < m->nu && status != MBSR_UNDETERMINED; ++l) out[l] = NAN;
    if (b->failed >= 0) return status;
    b->failed = k;
    const mbsr_error *error = mbsr_data_error(b->data);
    return mbsri_fail(&b->error, status, error->body, error->force, "state %d: %.240s", k,
                      error->text);
}

/* One share; its result goes to the batch. */
static void evaluate_request(const request *r)
{
    mbsr_batch *b = r->b;
    int *result = &b->result;
    *result = MBSR_OK;
    b->failed = -1;
    b->single = 0;
    const bool lanes = b->kernels && move_root(r) && move_joints(r);
    const int group = lanes ? b->kernels->lanes : r->end - r->from;
    for (int first = r->from, count; first < r->end; first += count) {
        count = r->end - first < group ? r->end - first : group;
        const unsigned served = lanes ? in_lanes(r, first, count) : 0u;
        for (int l = 0; l < count; ++l) {
            const bool done = lanes && (served >> l & 1u) != 0;
            const int status = done ? MBSR_OK : alone(r, first + l);
            if (r->status) r->status[first + l] = status;
            if (*result == MBSR_OK) *result = status;
        }
    }
}

/* As many groups of states for each share, one more for the first ones; states may be fewer. */
static void evaluate_share(void *arg, int k)
{
    request r = *(const request *)arg;
    const mbsr_batch *b = r.b;
    const int lanes = mbsr_batch_lanes(b), groups = (r.end - 1) / lanes + 1,
              each = groups / b->shares, more = groups % b->shares;
    const int first = k * each + (k < more ? k : more), count = each + (k < more);
    r.b = b->share[k];
    r.from = lanes * first;
    if (r.end > lanes * (first + count)) r.end = lanes * (first + count);
    evaluate_request(&r);
}

static int evaluate_all(const request *r)
{
    mbsr_batch *b = r->b;
    if (b->shares == 1) {
        evaluate_request(r);
        return b->result;
    }
    b->parallel.run(b->parallel.user, b->shares, evaluate_share, (void *)r);
    for (int k = 1; k < b->shares; ++k) {
        const mbsr_batch *share = b->share[k];
        b->single += share->single;
        if (b->result == MBSR_OK) b->result = share->result;
        if (b->failed >= 0 || share->failed < 0) continue;
        b->failed = share->failed;
        b->error = share->error;
    }
    return b->result;
}

/* ---- the calls ---- */

static int check_batch(const mbsr_model *model, mbsr_batch *batch, bool arguments, int states,
                       const char *function)
{
    if (!batch) return MBSR_ERR_NULL;
    if (!model || !arguments) {
        return mbsri_fail(&batch->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    }
    if (batch->model != model) {
        return mbsri_fail(&batch->error, MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE,
                          "%s: the batch belongs to another model", function);
    }
    if (states >= 1) return MBSR_OK;
    return mbsri_fail(&batch->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "%s: states is %d, must be at least 1", function, states);
}

int mbsr_batch_forward_dynamics(const mbsr_model *model, mbsr_batch *batch, double t, int states,
                                const double *q, const double *u, const double *tau, double *udot,
                                int *status)
{
    const int refused =
        check_batch(model, batch, q && u && udot, states, "mbsr_batch_forward_dynamics");
    if (refused) return refused;
    return evaluate_all(&(request){model, batch, t, 0, states, q, u, tau, udot, status, false});
}

int mbsr_batch_inverse_dynamics(const mbsr_model *model, mbsr_batch *batch, double t, int states,
                                const double *q, const double *u, const double *udot, double *tau,
                                int *status)
{
    const int refused =
        check_batch(model, batch, q && u && udot && tau, states, "mbsr_batch_inverse_dynamics");
    if (refused) return refused;
    return evaluate_all(&(request){model, batch, t, 0, states, q, u, udot, tau, status, true});
}

int mbsr_batch_lanes(const mbsr_batch *batch)
{
    if (!batch) return 0;
    return batch->kernels ? batch->kernels->lanes : 1;
}

int mbsr_batch_failed(const mbsr_batch *batch)
{
    return batch ? batch->failed : -1;
}

int mbsr_batch_one_by_one(const mbsr_batch *batch)
{
    return batch ? batch->single : 0;
}

const mbsr_error *mbsr_batch_error(const mbsr_batch *batch)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the batch is NULL"};
    return batch ? &batch->error : &none;
}
