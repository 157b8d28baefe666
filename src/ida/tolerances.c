/* Tolerances of the variables, the weights IDA makes of them, and the norms of the error test.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/tolerances.h"

#include "ida/shift.h"
#include "ida/error.h"
#include "ida/loops.h"
#include "ida/progress.h"

#include <mbsrank/driver.h>

#include <math.h>

/* ---- tolerances ---- */

/* Absolute tolerance of a coordinate, or of its rate, by what it measures. */
static double by_kind(const mbsr_ida_opt *opt, mbsr_coordinate_kind kind, bool rate)
{
    double atol = 0.0;
    if (kind == MBSR_COORDINATE_ROTATION) {
        atol = rate ? opt->atol_angular_velocity : opt->atol_angle;
    } else if (kind == MBSR_COORDINATE_TRANSLATION) {
        atol = rate ? opt->atol_velocity : opt->atol_length;
    }
    return atol > 0.0 ? atol : opt->atol;
}

/* Those of one body's q, and of its u at `velocity`, into atol. */
static void set_body(mbsr_ida *ida, int body, int velocity, double *atol)
{
    mbsr_coordinate_kind position_kind[4 * MBSR_MAX_D], velocity_kind[MBSR_MAX_D];
    int q, nq, u, n;
    mbsr_body_coordinates(ida->model, body, &q, &nq, &u, &n);
    mbsr_body_coordinate_kinds(ida->model, body, position_kind, velocity_kind);
    for (int k = 0; k < nq; ++k) atol[q + k] = by_kind(&ida->opt, position_kind[k], false);
    for (int k = 0; k < n; ++k) {
        atol[velocity + u + k] = by_kind(&ida->opt, velocity_kind[k], true);
    }
}

/* Those of what the joint rates move, nu. */
static void find_places(const mbsr_ida *ida, double *place)
{
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    for (int i = 0; i < mbsr_model_bodies(ida->model); ++i) {
        int u, n;
        mbsr_body_coordinates(ida->model, i, NULL, NULL, &u, &n);
        mbsr_body_coordinate_kinds(ida->model, i, NULL, kind);
        for (int k = 0; k < n; ++k) place[u + k] = by_kind(&ida->opt, kind[k], false);
    }
}

/* Multipliers are integrals, which grow with time: their tolerances are absolute. Only forces of
 * stiff rows have a relative one as well. */
static void set_loops(mbsr_ida *ida, double *atol)
{
    double *relative = N_VGetArrayPointer(ida->tol.mass);
    const int first = mbsri_ida_loops(ida);
    for (int k = first; k < ida->size; ++k) {
        if (!ida->opt.atol_each) atol[k] = ida->opt.atol;
        relative[k] = 0.0;
    }
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, rows;
        mbsr_closure_indices(ida->model, c, &row, &rows, NULL, NULL);
        for (int k = 0; k < rows; ++k)
            relative[first + row + k] = mbsr_closure_stiffness(ida->model, c, k) > 0.0 ? 1.0 : 0.0;
    }
}

/* The least tolerance of one body's coordinates of a kind over the largest of their velocities. */
static double time_of_body(const mbsr_ida *ida, int body, int velocity, mbsr_coordinate_kind kind)
{
    mbsr_coordinate_kind position_kind[4 * MBSR_MAX_D], velocity_kind[MBSR_MAX_D];
    const double *atol = N_VGetArrayPointer(ida->tol.atol);
    double place = INFINITY, speed = 0.0;
    int q, nq, u, n;
    mbsr_body_coordinates(ida->model, body, &q, &nq, &u, &n);
    mbsr_body_coordinate_kinds(ida->model, body, position_kind, velocity_kind);
    for (int k = 0; k < nq; ++k)
        if (position_kind[k] == kind) place = fmin(place, atol[q + k]);
    for (int k = 0; k < n; ++k)
        if (velocity_kind[k] == kind) speed = fmax(speed, atol[velocity + u + k]);
    return place > 0.0 && speed > 0.0 ? place / speed : INFINITY;
}

/* The unit of time that tolerances are in; 1 s where they do not tell. Those of each index-1
 * velocity have masses in them. */
static double find_time(const mbsr_ida *ida, int velocity)
{
    double time = INFINITY;
    if (ida->opt.form == MBSR_DAE_INDEX1 && ida->opt.atol_each) return 1.0;
    for (int i = 0; i < mbsr_model_bodies(ida->model); ++i) {
        for (int kind = MBSR_COORDINATE_OTHER; kind <= MBSR_COORDINATE_TRANSLATION; ++kind)
            time = fmin(time, time_of_body(ida, i, velocity, (mbsr_coordinate_kind)kind));
    }
    return isfinite(time) ? time : 1.0;
}

void mbsri_ida_set_tolerances(mbsr_ida *ida)
{
    const double *each = ida->opt.atol_each;
    const bool momentum = ida->opt.form == MBSR_DAE_MOMENTUM;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    double *atol = N_VGetArrayPointer(ida->tol.atol);
    for (int k = 0; each && k < ida->size; ++k) atol[k] = each[k];
    const int velocity = momentum ? nq + nu : nq;
    for (int i = 0; !each && i < mbsr_model_bodies(ida->model); ++i) {
        set_body(ida, i, velocity, atol);
    }
    ida->tol.time = find_time(ida, velocity);
    set_loops(ida, atol);
    ida->tol.scales = !each && (momentum || ida->opt.form == MBSR_DAE_INDEX1);
    ida->opt.atol_each = NULL;
}

/* What the data could not be asked is why the start fails. */
static int pass_on_error(mbsr_ida *ida, int status)
{
    return mbsri_ida_pass_on(&ida->error, status, mbsr_data_error(ida->data),
                             "mbsr_ida_start: masses for tolerances");
}

/* ---- joints that turn and move ---- */

/* Where the group of joints that are eliminated together, of which that of a body is one, has its
 * first rate. */
static int first_of_group(const mbsr_ida *ida, int body)
{
    int first, n, own;
    mbsr_body_coordinates(ida->model, mbsr_body_group(ida->model, body), NULL, NULL, &first, &n);
    mbsr_body_coordinates(ida->model, body, NULL, NULL, &own, NULL);
    return n > 0 ? first : own;
}

enum { NO_KIND = -1, SEVERAL = -2 };

/* For each group, at its first rate: the largest sqrt(mass) times tolerance of its rates u, whose
 * tolerances begin at `velocity`, into root (nu), where these turn and move, so that errors of the
 * one kind may have the energy that the other kind's may; else 0. kind (nu): scratch. */
static void find_energies(const mbsr_ida *ida, int velocity, double *root, double *kind)
{
    const int nu = mbsr_model_nu(ida->model);
    const double *mass = N_VGetArrayPointer(ida->tol.mass) + mbsr_model_nq(ida->model),
                 *atol = N_VGetArrayPointer(ida->tol.atol) + velocity;
    mbsr_coordinate_kind own[MBSR_MAX_D];
    for (int k = 0; k < nu; ++k) {
        root[k] = 0.0;
        kind[k] = NO_KIND;
    }
    for (int i = 0; i < mbsr_model_bodies(ida->model); ++i) {
        const int at = first_of_group(ida, i);
        int first, n;
        mbsr_body_coordinates(ida->model, i, NULL, NULL, &first, &n);
        mbsr_body_coordinate_kinds(ida->model, i, NULL, own);
        for (int k = 0; k < n; ++k) {
            root[at] = fmax(root[at], sqrt(mass[first + k]) * atol[first + k]);
            const double now = (double)own[k];
            kind[at] = kind[at] == NO_KIND || kind[at] == now ? now : (double)SEVERAL;
        }
    }
    for (int k = 0; k < nu; ++k) root[k] = kind[k] == SEVERAL ? root[k] : 0.0;
}

/* p: mass times the tolerance of its velocity, which stands nu further on, or sqrt(mass) times
 * `root`, unless that is 0. */
static void scale_momenta(mbsr_ida *ida, int body, double root)
{
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    double *atol = N_VGetArrayPointer(ida->tol.atol) + nq;
    const double *mass = N_VGetArrayPointer(ida->tol.mass) + nq;
    int first, n;
    mbsr_body_coordinates(ida->model, body, NULL, NULL, &first, &n);
    for (int k = first; k < first + n; ++k)
        atol[k] = root > 0.0 ? sqrt(mass[k]) * root : mass[k] * atol[nu + k];
}

/* v: the square root of the mass on its joint, without any of the smallest that momenta have there,
 * and of the joint's tolerances the smallest; or `root`, unless that is 0. */
static int scale_velocities(mbsr_ida *ida, int body, double root)
{
    const int nq = mbsr_model_nq(ida->model);
    double *atol = N_VGetArrayPointer(ida->tol.atol), smallest = INFINITY, least = INFINITY;
    const double *mass = N_VGetArrayPointer(ida->tol.mass);
    mbsr_rank_info info;
    int first, n;
    const int status = mbsr_body_rank(ida->model, ida->data, body, &info);
    if (status) return pass_on_error(ida, status);
    mbsr_body_coordinates(ida->model, body, NULL, NULL, &first, &n);
    for (int k = nq + first; k < nq + first + n; ++k) {
        smallest = fmin(smallest, atol[k]);
        least = fmin(least, mass[k]);
    }
    if (!(root > 0.0)) root = smallest * sqrt(info.scale > 0.0 ? info.scale : least);
    for (int k = nq + first; k < nq + first + n; ++k) atol[k] = root;
    return MBSR_OK;
}

/* Those of momenta or index-1 velocities, which are taken anew, by the masses in tol.mass. */
static int scale_all(mbsr_ida *ida)
{
    const bool momentum = ida->opt.form == MBSR_DAE_MOMENTUM;
    const int nq = mbsr_model_nq(ida->model), bodies = mbsr_model_bodies(ida->model);
    double *root = N_VGetArrayPointer(ida->work);
    int status = MBSR_OK;
    if (!momentum && ida->opt.form != MBSR_DAE_INDEX1) return status;
    for (int i = 0; i < bodies && !momentum; ++i)
        set_body(ida, i, nq, N_VGetArrayPointer(ida->tol.atol));
    find_energies(ida, momentum ? nq + mbsr_model_nu(ida->model) : nq, root,
                  N_VGetArrayPointer(ida->displaced));
    for (int i = 0; i < bodies && !status; ++i) {
        const int at = first_of_group(ida, i);
        int n;
        mbsr_body_coordinates(ida->model, i, NULL, NULL, NULL, &n);
        if (n > 0 && momentum) scale_momenta(ida, i, root[at]);
        if (n > 0 && !momentum) status = scale_velocities(ida, i, root[at]);
    }
    return status;
}

int mbsri_ida_scale_tolerances(mbsr_ida *ida)
{
    double *mass = N_VGetArrayPointer(ida->tol.mass);
    int status = mbsr_momentum_scales(ida->model, ida->data, mass + mbsr_model_nq(ida->model));
    if (status) return pass_on_error(ida, status);
    status = scale_all(ida);
    if (status) return status;
    double *place = N_VGetArrayPointer(ida->displaced) + mbsr_model_nu(ida->model);
    find_places(ida, place);
    status = mbsri_ida_scale_multipliers(ida, place);
    if (status) return pass_on_error(ida, status);
    mbsri_ida_allow_rounding(ida);
    return MBSR_OK;
}

/* What the tolerances of one vector y are made of. */
typedef struct rule {
    double rtol;
    const double *y, *atol, *mass;
    int first, last,
        nu;    /* momenta first .. last - 1 take the size of their velocity, nu further on */
    int loops; /* multipliers from there on */
} rule;

static rule rule_for(const mbsr_ida *ida, const double *y)
{
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const bool momentum = ida->tol.scales && ida->opt.form == MBSR_DAE_MOMENTUM;
    return (rule){.rtol = ida->opt.rtol,
                  .y = y,
                  .atol = N_VGetArrayPointer(ida->tol.atol),
                  .mass = N_VGetArrayPointer(ida->tol.mass),
                  .first = nq,
                  .last = momentum ? nq + nu : nq,
                  .nu = nu,
                  .loops = mbsri_ida_loops(ida)};
}

static inline double tolerance(const rule *r, int k)
{
    if (k >= r->loops) return r->rtol * r->mass[k] * fabs(r->y[k]) + r->atol[k];
    if (k < r->first || k >= r->last) return r->rtol * fabs(r->y[k]) + r->atol[k];
    return r->rtol * r->mass[k] * fabs(r->y[k + r->nu]) + r->atol[k];
}

double mbsri_ida_tolerance(const mbsr_ida *ida, const double *y, int k)
{
    const rule r = rule_for(ida, y);
    return tolerance(&r, k);
}

/* IDA asks for weights before each step, so this is also where a run can be stopped between two
 * steps. */
int mbsri_ida_weights(N_Vector y, N_Vector weight, void *user)
{
    mbsr_ida *ida = user;
    if (mbsri_ida_report(ida) || mbsri_ida_watch_steps(ida, y) || mbsri_ida_watch_loops(ida, y))
        return -1;
    mbsri_ida_note_step(ida);
    double t = 0.0;
    IDAGetCurrentTime(ida->memory, &t);
    mbsri_ida_shift_back(ida, t, &y, NULL);
    if (mbsri_ida_watch_dropped(ida, t, y)) return -1;
    const rule r = rule_for(ida, N_VGetArrayPointer(y));
    double *to = N_VGetArrayPointer(weight);
    for (int k = 0; k < ida->size; ++k) {
        const double allowed = tolerance(&r, k);
        if (!(allowed > 0.0)) {
            ida->failing.callback = MBSR_ERR_VALUE;
            return mbsri_ida_refuse(&ida->failing.failure, MBSR_ERR_VALUE,
                                    "y[%d] is %g: its tolerance, relative and absolute, is zero", k,
                                    r.y[k]);
        }
        to[k] = 1.0 / allowed;
    }
    return 0;
}

/* ---- norms ---- */

double mbsri_ida_norm(const mbsr_ida *ida, int n, const double *x)
{
    const rule r = rule_for(ida, N_VGetArrayPointer(ida->y));
    double sum = 0.0, largest = 0.0;
    for (int k = 0; k < n; ++k) {
        const double weighted = x[k] / tolerance(&r, k);
        sum += weighted * weighted;
        largest = fmax(largest, fabs(weighted));
    }
    return ida->opt.max_norm ? largest : sqrt(sum / ida->size);
}

/* max |x_k| w_k of the entries whose id is positive; id NULL: of all. A NaN comes out as one. */
static sunrealtype largest_entry(N_Vector x, N_Vector w, N_Vector id)
{
    const double *value = N_VGetArrayPointer(x), *weight = N_VGetArrayPointer(w);
    const double *counts = id ? N_VGetArrayPointer(id) : NULL;
    double largest = 0.0;
    for (sunindextype k = 0; k < N_VGetLength(x); ++k) {
        const double weighted = fabs(value[k] * weight[k]);
        if (counts && !(counts[k] > 0.0)) continue;
        if (!(weighted <= largest)) largest = weighted;
        if (isnan(largest)) break;
    }
    return largest;
}

static sunrealtype largest_of_all(N_Vector x, N_Vector w)
{
    return largest_entry(x, w, NULL);
}

void mbsri_ida_use_max_norm(N_Vector v)
{
    v->ops->nvwrmsnorm = largest_of_all;
    v->ops->nvwrmsnormmask = largest_entry;
}
