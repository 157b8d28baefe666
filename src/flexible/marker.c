/* Markers of flexible bodies: see marker.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "flexible/marker.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "flexible/rotation_vector.h"

/* y = A x, A 3 x n */
static void apply(int n, const double *A, const double *x, double y[3])
{
    y[0] = y[1] = y[2] = 0.0;
    mbsri_ax(3, n, 1.0, A, x, y);
}

/* C (3 x 3) += [w]x A */
static void add_turned(const double w[3], const double A[9], double C[9])
{
    for (int k = 0; k < 9; k += 3) mbsri_add_cross3(w, A + k, C + k);
}

void mbsri_flex_see(const mbsr_flex *flex, int marker, const double R[9], const double *s,
                    mbsri_flex_view *view)
{
    const mbsr_flex_marker *m = flex->marker + marker;
    double T[9];
    view->flex = flex;
    view->marker = m;
    mbsri_copy(9, R, view->R);
    apply(flex->n, m->Phi, s, view->rho);
    mbsri_add3(1.0, m->frame.x, view->rho);
    apply(flex->n, m->Psi, s, view->psi);
    mbsri_tangent3(view->psi, T);
    mbsri_rotate3(R, view->rho, view->at.a);
    mbsri_multiply3(R, T, view->at.G);
    mbsri_copy(9, R, view->at.L);
}

/* Derivatives of (a, G, L) where the body turns by w and Psi s, Phi s change by dpsi, drho:
 * a' = w x a + L drho,   G' = [w]x G + R T',   L' = [w]x L */
static void derive(const mbsri_flex_view *view, const double w[3], const double dpsi[3],
                   const double drho[3], mbsri_flex_arm *out)
{
    double dT[9];
    mbsri_rotate3(view->R, drho, out->a);
    mbsri_add_cross3(w, view->at.a, out->a);
    mbsri_tangent3_along(view->psi, dpsi, dT);
    mbsri_multiply3(view->R, dT, out->G);
    add_turned(w, view->at.G, out->G);
    mbsri_zero(9, out->L);
    add_turned(w, view->at.L, out->L);
}

/* B' V = (G' psi',  omega x a' + L' u) */
void mbsri_flex_see_rate(mbsri_flex_view *view, const double omega[3], const double *sdot)
{
    apply(view->flex->n, view->marker->Psi, sdot, view->psid);
    apply(view->flex->n, view->marker->Phi, sdot, view->u);
    mbsri_copy(3, omega, view->omega);
    derive(view, omega, view->psid, view->u, &view->rate);
    mbsri_rotate3(view->rate.G, view->psid, view->bias);
    mbsri_rotate3(view->rate.L, view->u, view->bias + 3);
    mbsri_add_cross3(omega, view->rate.a, view->bias + 3);
}

void mbsri_flex_see_change(mbsri_flex_view *view, const double turn[3], const double *ds)
{
    apply(view->flex->n, view->marker->Psi, ds, view->dpsi);
    apply(view->flex->n, view->marker->Phi, ds, view->drho);
    mbsri_copy(3, turn, view->turn);
    derive(view, turn, view->dpsi, view->drho, &view->change);
}

/* With x the turn, d of the formulas of derive():
 * da' = domega x a + omega x da + dL u + L du
 * dG' = [domega]x G + [omega]x dG + [x]x R T' + R dT',   dL' = [domega]x L + [omega]x dL */
void mbsri_flex_see_rate_change(mbsri_flex_view *view, const double domega[3], const double *dsdot)
{
    mbsri_flex_arm *out = &view->rate_change;
    const mbsri_flex_arm *at = &view->at, *change = &view->change, *rate = &view->rate;
    double dpsid[3], du[3], T_rate[9], twice[9], along[9], RT[9];
    apply(view->flex->n, view->marker->Psi, dsdot, dpsid);
    apply(view->flex->n, view->marker->Phi, dsdot, du);

    mbsri_rotate3(change->L, view->u, out->a);
    mbsri_ax(3, 3, 1.0, at->L, du, out->a);
    mbsri_add_cross3(domega, at->a, out->a);
    mbsri_add_cross3(view->omega, change->a, out->a);

    mbsri_tangent3_along(view->psi, view->psid, T_rate);
    mbsri_tangent3_twice(view->psi, view->psid, view->dpsi, twice);
    mbsri_tangent3_along(view->psi, dpsid, along);
    for (int k = 0; k < 9; ++k) twice[k] += along[k];
    mbsri_multiply3(view->R, T_rate, RT);
    mbsri_multiply3(view->R, twice, out->G);
    add_turned(view->turn, RT, out->G);
    add_turned(domega, at->G, out->G);
    add_turned(view->omega, change->G, out->G);

    mbsri_zero(9, out->L);
    add_turned(domega, at->L, out->L);
    add_turned(view->omega, change->L, out->L);

    double *bias = view->bias_change;
    mbsri_rotate3(out->G, view->psid, bias);
    mbsri_ax(3, 3, 1.0, rate->G, dpsid, bias);
    mbsri_rotate3(out->L, view->u, bias + 3);
    mbsri_ax(3, 3, 1.0, rate->L, du, bias + 3);
    mbsri_add_cross3(domega, rate->a, bias + 3);
    mbsri_add_cross3(view->omega, out->a, bias + 3);
}

void mbsri_flex_axes(const mbsri_flex_view *view, double E[9])
{
    double turn[9];
    mbsri_exp3(view->psi, turn);
    mbsri_multiply3(turn, view->marker->frame.R, E);
}

void mbsri_flex_column(const mbsri_flex_view *view, const mbsri_flex_arm *arm, int k,
                       double angular[3], double linear[3])
{
    mbsri_rotate3(arm->G, view->marker->Psi + 3 * k, angular);
    mbsri_rotate3(arm->L, view->marker->Phi + 3 * k, linear);
}
