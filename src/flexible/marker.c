/* Markers of flexible bodies: see marker.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "flexible/marker.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "flexible/dependent.h"

#include <stdbool.h>

/* Rotation and displacement at the marker for changes of all shapes. */
static void marker_fields(const mbsri_flex_view *view, const double *all, double psi[3],
                          double rho[3])
{
    mbsri_zero(3, psi);
    mbsri_zero(3, rho);
    if (view->rests) return;
    for (int k = 0; k < view->flex->m; ++k) { /* changes are often of one mode */
        if (all[k] == 0.0) continue;
        mbsri_add3(all[k], view->marker->Psi + 3 * k, psi);
        mbsri_add3(all[k], view->marker->Phi + 3 * k, rho);
    }
}

/* The same for a change of the modes: Z dx. */
static void place_along(const mbsri_flex_view *view, const double *dx, double psi[3], double rho[3])
{
    double all[MBSR_MAX_MODES];
    if (!view->rests) mbsri_shapes_along(view->flex, view->s, dx, all);
    marker_fields(view, all, psi, rho);
}

/* psi, rho += factor chi x^T Y y */
static void add_second(const mbsri_flex_view *view, double factor, const double *x, const double *y,
                       double psi[3], double rho[3])
{
    const mbsr_flex *f = view->flex;
    for (int k = 0; k < f->r && !view->rests; ++k) {
        const double value = factor * mbsri_dependent(f, k, x, y);
        mbsri_add3(value, view->marker->Psi + 3 * (f->n + k), psi);
        mbsri_add3(value, view->marker->Phi + 3 * (f->n + k), rho);
    }
}

/* C (3 x 3) += [w]x A */
static void add_cross_matrix(const double w[3], const double A[9], double C[9])
{
    for (int k = 0; k < 9; k += 3) mbsri_add_cross3(w, A + k, C + k);
}

void mbsri_flex_see(const mbsr_flex *flex, int marker, const double R[9], const double *s,
                    mbsri_flex_view *view)
{
    const mbsr_flex_marker *m = flex->marker + marker;
    double T[9], all[MBSR_MAX_MODES];
    view->flex = flex;
    view->marker = m;
    view->s = s;
    mbsri_copy(9, R, view->R);
    view->rests = flex->rests[marker];
    if (!view->rests) mbsri_shapes(flex, s, all);
    marker_fields(view, all, view->psi, view->rho);
    mbsri_add3(1.0, m->frame.x, view->rho);
    view->rotation = mbsri_rotation_vector_of(view->psi);
    mbsri_tangent3(&view->rotation, T);
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
    if (view->rests)
        mbsri_zero(9, dT);
    else
        mbsri_tangent3_along(&view->rotation, dpsi, dT);
    mbsri_multiply3(view->R, dT, out->G);
    add_cross_matrix(w, view->at.G, out->G);
    mbsri_zero(9, out->L);
    add_cross_matrix(w, view->at.L, out->L);
}

/* B' V = (G' psi' + G psi_second,  omega x a' + L' u + L second) */
void mbsri_flex_see_rate(mbsri_flex_view *view, const double omega[3], const double *sdot)
{
    view->sdot = sdot;
    place_along(view, sdot, view->psid, view->u);
    mbsri_zero(3, view->psi_second);
    mbsri_zero(3, view->second);
    add_second(view, 1.0, sdot, sdot, view->psi_second, view->second);
    mbsri_copy(3, omega, view->omega);
    derive(view, omega, view->psid, view->u, &view->rate);
    mbsri_rotate3(view->rate.G, view->psid, view->bias);
    mbsri_rotate3(view->rate.L, view->u, view->bias + 3);
    mbsri_ax(3, 3, 1.0, view->at.G, view->psi_second, view->bias);
    mbsri_ax(3, 3, 1.0, view->at.L, view->second, view->bias + 3);
    mbsri_add_cross3(omega, view->rate.a, view->bias + 3);
}

void mbsri_flex_see_change(mbsri_flex_view *view, const double turn[3], const double *ds)
{
    view->ds = ds;
    place_along(view, ds, view->dpsi, view->drho);
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
    double dpsi_second[3] = {0.0}, dsecond[3] = {0.0};
    view->dsdot = dsdot;
    place_along(view, dsdot, dpsid, du);
    add_second(view, 1.0, view->ds, view->sdot, dpsid, du);
    add_second(view, 2.0, view->sdot, dsdot, dpsi_second, dsecond);

    mbsri_rotate3(change->L, view->u, out->a);
    mbsri_ax(3, 3, 1.0, at->L, du, out->a);
    mbsri_add_cross3(domega, at->a, out->a);
    mbsri_add_cross3(view->omega, change->a, out->a);

    mbsri_zero(9, out->G);
    if (!view->rests) {
        mbsri_tangent3_along(&view->rotation, view->psid, T_rate);
        mbsri_tangent3_twice(&view->rotation, view->psid, view->dpsi, twice);
        mbsri_tangent3_along(&view->rotation, dpsid, along);
        for (int k = 0; k < 9; ++k) twice[k] += along[k];
        mbsri_multiply3(view->R, T_rate, RT);
        mbsri_multiply3(view->R, twice, out->G);
        add_cross_matrix(view->turn, RT, out->G);
    }
    add_cross_matrix(domega, at->G, out->G);
    add_cross_matrix(view->omega, change->G, out->G);

    mbsri_zero(9, out->L);
    add_cross_matrix(domega, at->L, out->L);
    add_cross_matrix(view->omega, change->L, out->L);

    double *bias = view->bias_change;
    mbsri_rotate3(out->G, view->psid, bias);
    mbsri_ax(3, 3, 1.0, rate->G, dpsid, bias);
    mbsri_ax(3, 3, 1.0, change->G, view->psi_second, bias);
    mbsri_ax(3, 3, 1.0, at->G, dpsi_second, bias);
    mbsri_rotate3(out->L, view->u, bias + 3);
    mbsri_ax(3, 3, 1.0, rate->L, du, bias + 3);
    mbsri_ax(3, 3, 1.0, change->L, view->second, bias + 3);
    mbsri_ax(3, 3, 1.0, at->L, dsecond, bias + 3);
    mbsri_add_cross3(domega, rate->a, bias + 3);
    mbsri_add_cross3(view->omega, out->a, bias + 3);
}

void mbsri_flex_axes(const mbsri_flex_view *view, double E[9])
{
    double turn[9];
    mbsri_exp3(&view->rotation, turn);
    mbsri_multiply3(turn, view->marker->frame.R, E);
}

void mbsri_flex_turn(const mbsri_flex_view *view, const double *ds, double x[3])
{
    double dpsi[3], drho[3];
    place_along(view, ds, dpsi, drho);
    mbsri_rotate3(view->at.G, dpsi, x);
}

/* angular, linear += G psi, L rho, with psi and rho of mode k itself, or of what dependent shapes
 * follow it by: chi (Y x)_k. */
static void add_mode_column(const mbsri_flex_view *view, const mbsri_flex_arm *arm, bool itself,
                            int k, const double *x, double angular[3], double linear[3])
{
    const mbsr_flex *f = view->flex;
    double psi[3] = {0.0}, rho[3] = {0.0};
    if (itself) {
        mbsri_add3(1.0, view->marker->Psi + 3 * k, psi);
        mbsri_add3(1.0, view->marker->Phi + 3 * k, rho);
    }
    for (int l = 0; l < f->r; ++l) {
        const double value = mbsri_dot(f->n, f->Y + f->n * (f->n * l + k), x);
        mbsri_add3(value, view->marker->Psi + 3 * (f->n + l), psi);
        mbsri_add3(value, view->marker->Phi + 3 * (f->n + l), rho);
    }
    mbsri_ax(3, 3, 1.0, arm->G, psi, angular);
    mbsri_ax(3, 3, 1.0, arm->L, rho, linear);
}

/* Z is linear in s, so products of two derivatives end there. */
void mbsri_flex_column(const mbsri_flex_view *view, mbsri_flex_part part, int k, double angular[3],
                       double linear[3])
{
    const mbsri_flex_view *v = view;
    const mbsri_flex_arm *const arm[] = {&v->at, &v->rate, &v->change, &v->rate_change};
    if (v->flex->r == 0 && !v->rests) {
        mbsri_rotate3(arm[part]->G, v->marker->Psi + 3 * k, angular);
        mbsri_rotate3(arm[part]->L, v->marker->Phi + 3 * k, linear);
        return;
    }
    mbsri_zero(3, angular);
    mbsri_zero(3, linear);
    if (v->rests) return;
    add_mode_column(v, arm[part], true, k, v->s, angular, linear);
    switch (part) {
    case MBSRI_FLEX_AT: break;
    case MBSRI_FLEX_RATE: add_mode_column(v, &v->at, false, k, v->sdot, angular, linear); break;
    case MBSRI_FLEX_CHANGE: add_mode_column(v, &v->at, false, k, v->ds, angular, linear); break;
    case MBSRI_FLEX_RATE_CHANGE:
        add_mode_column(v, &v->rate, false, k, v->ds, angular, linear);
        add_mode_column(v, &v->change, false, k, v->sdot, angular, linear);
        add_mode_column(v, &v->at, false, k, v->dsdot, angular, linear);
        break;
    }
}
