/* Analytic derivatives of an instance: see products.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With A = F_y and A_c = A + c (1 on q' and p'), du is corrected by delta of
 *
 *   A_c (xi, delta) = (0, -b_u - (A (dx, du))_u),      b = F_w dw
 *
 * which leaves some |A| / c of the error each time. The transpose likewise: z with z_x = w and
 * (A^T z)_u = w_u makes
 *
 *   w . x' + w_u . du = -(A^T z)_x . dx - z . b. */
#include "fmu/products.h"

#include "fmu/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double C = 1e8; /* 1/s */
enum { MOST_CORRECTIONS = 8 };

/* ---- preparation ---- */

static bool take_products(mbsri_products *p)
{
    const size_t size = (size_t)p->size, nu = (size_t)p->nu, nx = (size_t)(p->nq + p->nu),
                 rows = (size_t)p->in->rows, inputs = (size_t)p->in->plan.inputs;
    p->y = calloc(6 * size + 3 * nu + rows + 2 * inputs + 2 * nx + 1, sizeof *p->y);
    if (!p->y) return false;
    p->yp = p->y + size;
    p->F = p->yp + size;
    p->z = p->F + size;
    p->r = p->z + size;
    p->b = p->r + size;
    p->x = p->b + size;
    p->tau = p->x + nu;
    p->udot = p->tau + nu;
    p->lambda = p->udot + nu;
    p->input = p->lambda + rows;
    p->dw = p->input + inputs;
    p->dx = p->dw + inputs;
    memcpy(p->input, p->in->input, inputs * sizeof *p->input);
    return true;
}

/* The Newton matrix at the state: its products, and its factors for C. */
static int linearise_states(mbsri_products *p)
{
    mbsri_instance *in = p->in;
    const size_t nx = (size_t)(p->nq + p->nu);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.products = opt.transposes = 1;
    int status = mbsr_ode_rhs(in->solver.ode, in->t, in->x, p->yp);
    if (!status && !in->solver.newton)
        status =
            mbsr_newton_create(in->built.model, MBSR_DAE_MOMENTUM, &opt, &in->solver.newton, NULL);
    if (status) return status;
    memcpy(p->y, in->x, nx * sizeof *p->y);
    memcpy(in->q, in->x, (size_t)p->nq * sizeof *in->q);
    status = mbsr_ode_velocities(in->solver.ode, in->t, in->x, in->u);
    memcpy(p->y + nx, in->u, (size_t)p->nu * sizeof *p->y);
    if (!status)
        status =
            mbsr_newton_factor(in->solver.newton, in->solver.event_data, in->t, p->y, p->yp, C);
    if (status) return status;
    return mbsr_newton_linearise(in->solver.newton, in->solver.event_data, in->t, p->y, p->yp, 0.0);
}

static int linearise_accelerations(mbsri_products *p)
{
    mbsri_instance *in = p->in;
    int status = MBSR_OK;
    if (!in->solver.forward)
        status = mbsr_derivatives_create(in->built.model, &in->solver.forward, NULL);
    if (!status && !in->exchange)
        status = mbsr_dae_pack(in->built.model, in->solver.event_data, MBSR_DAE_MOMENTUM, in->t,
                               in->q, in->u, p->y);
    return status ? status
                  : mbsr_derivatives_forward(in->solver.forward, in->t, in->q, in->u, NULL, NULL,
                                             NULL);
}

bool mbsri_products_begin(mbsri_products *p, mbsri_instance *in, bool accelerations, bool motions)
{
    *p = (mbsri_products){
        .in = in, .motions = motions, .nq = in->plan.nq, .nu = in->plan.nu, .size = in->size};
    if (!take_products(p)) return false;
    p->states = in->exchange && !linearise_states(p);
    p->accelerations =
        accelerations && !motions && (p->states || !in->exchange) && !linearise_accelerations(p);
    return true;
}

void mbsri_products_end(mbsri_products *p)
{
    free(p->y);
    p->y = NULL;
}

bool mbsri_products_serve(const mbsri_products *p, const mbsri_variable *v)
{
    switch (v->kind) {
    case MBSRI_Q:
    case MBSRI_U:
    case MBSRI_P:
    case MBSRI_QDOT:
    case MBSRI_PDOT: return p->states;
    case MBSRI_UDOT:
    case MBSRI_LOOP: return p->accelerations;
    default: return false;
    }
}

/* ---- inputs ---- */

/* b = F_w dw. Motions enter by squares and products, forces as they are. */
static int change_inputs(mbsri_products *p)
{
    mbsri_instance *in = p->in;
    double most = 0.0;
    int status = MBSR_OK;
    memset(p->b, 0, (size_t)p->size * sizeof *p->b);
    for (int k = 0; k < in->plan.inputs; ++k)
        most = fmax(most, fabs(p->dw[k]) / (1.0 + fabs(p->input[k])));
    if (!(most > 0.0)) return MBSR_OK;
    const double h = (p->motions ? 1e-5 : 1e-3) / most;
    for (int side = -1; side <= 1 && !status; side += 2) {
        for (int k = 0; k < in->plan.inputs; ++k) in->input[k] = p->input[k] + side * h * p->dw[k];
        status = mbsr_dae_residual(in->built.model, in->solver.event_data, MBSR_DAE_MOMENTUM, in->t,
                                   p->y, p->yp, p->F);
        for (int k = 0; k < p->size; ++k) p->b[k] += side * p->F[k] / (2.0 * h);
    }
    memcpy(in->input, p->input, (size_t)in->plan.inputs * sizeof *in->input);
    return status;
}

/* ---- joint rates for coordinates ---- */

/* G x is -(A (0, 0, x))_q, and its transpose alike. */
static int times_G(mbsri_products *p, const double *x, double *to)
{
    memset(p->r, 0, (size_t)p->size * sizeof *p->r);
    for (int k = 0; k < p->nu; ++k) p->r[p->nq + p->nu + k] = -x[k];
    const int status = mbsr_newton_multiply(p->in->solver.newton, p->r, p->r);
    memcpy(to, p->r, (size_t)p->nq * sizeof *to);
    return status;
}

static int times_G_transposed(mbsri_products *p, const double *dq, double *to)
{
    memset(p->r, 0, (size_t)p->size * sizeof *p->r);
    for (int k = 0; k < p->nq; ++k) p->r[k] = -dq[k];
    const int status = mbsr_newton_multiply_transposed(p->in->solver.newton, p->r, p->r);
    memcpy(to, p->r + p->nq + p->nu, (size_t)p->nu * sizeof *to);
    return status;
}

/* x becomes (G^T G)^-1 x; that is diagonal, as columns of G are at right angles to each other.
 * room: nq + nu numbers. */
static int over_G_squared(mbsri_products *p, double *x, double *room)
{
    double *again = room + p->nq;
    int status = times_G(p, x, room);
    if (!status) status = times_G_transposed(p, room, again);
    for (int k = 0; k < p->nu && !status; ++k)
        if (again[k] != 0.0) x[k] *= x[k] / again[k];
    return status;
}

/* ---- along changes ---- */

static double largest(const double *a, int n)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(a[k]));
    return most;
}

/* One correction of z, and the largest change of its part of u. */
static int correct(mbsri_products *p, bool transposed, const double *given, double *change)
{
    mbsr_newton *newton = p->in->solver.newton;
    const int nx = p->nq + p->nu;
    int status = transposed ? mbsr_newton_multiply_transposed(newton, p->z, p->r)
                            : mbsr_newton_multiply(newton, p->z, p->r);
    for (int k = 0; k < p->size; ++k) p->r[k] = k < nx ? 0.0 : given[k] - p->r[k];
    if (!status)
        status = transposed ? mbsr_newton_solve_transposed(newton, p->r, p->r)
                            : mbsr_newton_solve(newton, p->r, p->r);
    *change = 0.0;
    for (int k = nx; k < p->size && !status; ++k) {
        *change = fmax(*change, fabs(p->r[k]));
        p->z[k] += p->r[k];
    }
    return status;
}

/* z from its part of x and the right-hand sides of u, both in `given`. */
static bool converge(mbsri_products *p, bool transposed, const double *given)
{
    const int nx = p->nq + p->nu;
    double change = INFINITY, size = 0.0;
    memcpy(p->z, given, (size_t)nx * sizeof *p->z);
    memset(p->z + nx, 0, (size_t)p->nu * sizeof *p->z);
    for (int k = 0; k < MOST_CORRECTIONS && change > 1e-14 * size; ++k) {
        if (correct(p, transposed, given, &change)) return false;
        size = fmax(largest(p->z + nx, p->nu), 1e-300);
    }
    return change <= 1e-10 * size;
}

/* u' and loop forces. */
static int along_accelerations(mbsri_products *p)
{
    const double *du = p->in->exchange ? p->z + p->nq + p->nu : NULL;
    int status = MBSR_OK;
    memset(p->x, 0, (size_t)p->nu * sizeof *p->x);
    if (p->in->exchange) status = times_G_transposed(p, p->dx, p->x);
    if (!status && p->in->exchange) status = over_G_squared(p, p->x, p->F);
    for (int k = 0; k < p->nu; ++k) p->tau[k] = -p->b[p->nq + k];
    if (status) return status;
    return mbsr_derivatives_tangent(p->in->solver.forward, p->x, du, p->tau, p->udot,
                                    p->in->rows > 0 ? p->lambda : NULL);
}

bool mbsri_products_along(mbsri_products *p)
{
    const int nx = p->nq + p->nu;
    double *xdot = p->dx + nx;
    if (change_inputs(p)) return false;
    if (p->states) {
        memcpy(p->F, p->dx, (size_t)nx * sizeof *p->F);
        for (int k = nx; k < p->size; ++k) p->F[k] = -p->b[k];
        if (!converge(p, false, p->F)) return false;
        if (mbsr_newton_multiply(p->in->solver.newton, p->z, p->r)) return false;
        for (int k = 0; k < nx; ++k) xdot[k] = -p->r[k] - p->b[k];
    }
    return !p->accelerations || !along_accelerations(p);
}

double mbsri_products_of(const mbsri_products *p, const mbsri_variable *v)
{
    const int nx = p->nq + p->nu;
    switch (v->kind) {
    case MBSRI_Q: return p->dx[v->of];
    case MBSRI_P: return p->dx[p->nq + v->of];
    case MBSRI_U: return p->z[nx + v->of];
    case MBSRI_QDOT: return p->dx[nx + v->of];
    case MBSRI_PDOT: return p->dx[nx + p->nq + v->of];
    case MBSRI_UDOT: return p->udot[v->of];
    default: return p->lambda[v->of];
    }
}

/* ---- against weights ---- */

void mbsri_products_weigh(mbsri_products *p, const mbsri_variable *v, double weight)
{
    const int nx = p->nq + p->nu;
    switch (v->kind) {
    case MBSRI_Q: p->dx[v->of] += weight; break;
    case MBSRI_P: p->dx[p->nq + v->of] += weight; break;
    case MBSRI_U: p->z[nx + v->of] += weight; break;
    case MBSRI_QDOT: p->dx[nx + v->of] += weight; break;
    case MBSRI_PDOT: p->dx[nx + p->nq + v->of] += weight; break;
    case MBSRI_UDOT: p->udot[v->of] += weight; break;
    default: p->lambda[v->of] += weight; break;
    }
}

/* Adds what u' and loop forces weigh: to dx by q, to weights of u (nu), and to tau. */
static int against_accelerations(mbsri_products *p, double *by_u)
{
    double *of_u = p->F, *room = p->F + p->nu;
    int status = mbsr_derivatives_adjoint(p->in->solver.forward, p->udot,
                                          p->in->rows > 0 ? p->lambda : NULL, p->x, of_u, p->tau);
    if (status || !p->in->exchange) return status;
    for (int k = 0; k < p->nu; ++k) by_u[k] += of_u[k];
    status = over_G_squared(p, p->x, room);
    if (!status) status = times_G(p, p->x, room);
    for (int k = 0; k < p->nq && !status; ++k) p->dx[k] += room[k];
    return status;
}

bool mbsri_products_against(mbsri_products *p)
{
    const int nx = p->nq + p->nu;
    memset(p->tau, 0, (size_t)p->nu * sizeof *p->tau);
    if (p->accelerations && against_accelerations(p, p->z + nx)) return false;
    if (!p->states) return true;
    memcpy(p->F, p->dx + nx, (size_t)nx * sizeof *p->F);
    memcpy(p->F + nx, p->z + nx, (size_t)p->nu * sizeof *p->F);
    if (!converge(p, true, p->F)) return false;
    if (mbsr_newton_multiply_transposed(p->in->solver.newton, p->z, p->r)) return false;
    for (int k = 0; k < nx; ++k) p->dx[k] -= p->r[k];
    return true;
}

bool mbsri_products_gradient(mbsri_products *p, const mbsri_variable *v, double *gradient)
{
    if (v->kind != MBSRI_INPUT) {
        *gradient = p->dx[v->kind == MBSRI_Q ? v->of : p->nq + v->of];
        return true;
    }
    p->dw[v->of] = 1.0;
    const int status = change_inputs(p);
    p->dw[v->of] = 0.0;
    *gradient = 0.0;
    for (int k = 0; k < p->size && p->states; ++k) *gradient -= p->z[k] * p->b[k];
    for (int k = 0; k < p->nu; ++k) *gradient -= p->tau[k] * p->b[p->nq + k];
    return !status;
}
