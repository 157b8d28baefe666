/* Slopes of force elements on bodies, seen from the bodies' points.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_ELEMENT_SLOPES_H
#define MBSRI_NEWTON_ELEMENT_SLOPES_H

#include "newton/sweeps/perturbation.h"

/* Slopes over nu and the motion of a body's point, of forces about a point. */
typedef struct slopes {
    v4 by[4][3][2];
} slopes;

/* to_j += A (e_j x a) */
MBSRI_INLINE void add_turned(v4 (*A)[2], v4 a, v4 (*to)[2])
{
    const v4 x = xxx(a), y = yyy(a), z = zzz(a);
    for (int r = 0; r < 2; ++r) {
        to[0][r] += y * A[2][r] - z * A[1][r];
        to[1][r] += z * A[0][r] - x * A[2][r];
        to[2][r] += x * A[1][r] - y * A[0][r];
    }
}

/* From the body's own frame: displacement = xi + dtheta x arm, domega = nu_w + dtheta x omega,
 * dv = nu_v + nu_w x arm + dtheta x v; moments + arm x forces, with the arm of that body. */
MBSRI_OUTLINE void place_slopes(const mbsri_newton_slopes *from, const mbsri_newton_own *by,
                                const mbsri_newton_own *on, slopes *to)
{
    enum { OWN_ROTATION, OWN_DISPLACEMENT, OWN_OMEGA, OWN_V };
    static const int own[4] = {OWN_ROTATION, OWN_OMEGA, OWN_V, OWN_DISPLACEMENT};
    const v4 arm = load(by->arm), turned = load(on->arm);
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) to->by[g][j][r] = load(from->by[own[g]][j][r]);
        }
    }
    add_turned(to->by[DISPLACEMENT], arm, to->by[ROTATION]);
    add_turned(to->by[SPIN], load(by->omega), to->by[ROTATION]);
    add_turned(to->by[DRIFT], load(by->v), to->by[ROTATION]);
    add_turned(to->by[DRIFT], arm, to->by[SPIN]);
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) to->by[g][j][0] += cross(turned, to->by[g][j][1]);
    }
}

MBSRI_OUTLINE void add_slopes(const slopes *by, slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            y->P[g][j][MOMENT] += by->by[g][j][0];
            y->P[g][j][FORCE] += by->by[g][j][1];
        }
    }
}

MBSRI_INLINE void place_own(const mbsri_sweep_run *run, int i, mbsri_newton_own *own)
{
    const mbsri_sweep_state *s = run->state + i;
    const double *x = run->tree->own[i].x;
    const v4 omega = load(s->omega), arm = load(s->R) * splat(x[0]) + load(s->R + 4) * splat(x[1]) +
                                           load(s->R + 8) * splat(x[2]);
    store(own->arm, arm);
    store(own->omega, omega);
    store(own->v, load(s->v) + cross(omega, arm));
}

/* The forces of elements on body i, and their slopes over its own motion. */
MBSRI_OUTLINE void add_elements(const mbsri_sweep_run *run, int i,
                                const mbsri_newton_sweeps *newton, slab *y, bool below_massless)
{
    const mbsri_sweep_load *on = run->load + i;
    const mbsri_newton_own *own = newton->acting.own + i;
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 f = load(on->p), arm = load(own->arm), product = splat(sum3(arm * f));
    slopes by;
    if (newton->acting.number[i] < 0) { /* closures: see ends.h */
        memset(&by, 0, sizeof by);
    } else {
        place_slopes(newton->acting.at + newton->acting.number[i], own, own, &by);
        add_slopes(&by, y);
    }
    /* the arm turns: (dtheta x arm) x f */
    for (int j = 0; j < 3; ++j) {
        const v4 turned = arm * splat(f[j]) - product * e[j];
        y->P[ROTATION][j][MOMENT] += turned;
        if (!below_massless) continue;
        /* psi: seen in the moving body */
        y->Y[ROTATION][j][0] -= by.by[ROTATION][j][0] + turned - cross(e[j], load(on->L));
        y->Y[ROTATION][j][1] -= by.by[ROTATION][j][1] - cross(e[j], f);
        for (int g = SPIN; g <= DISPLACEMENT; ++g) {
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] -= by.by[g][j][r];
        }
    }
    y->N += load(on->L);
    y->F += f;
}

/* Slopes of the forces on body i over its predecessor's motion, over x_h. */
MBSRI_OUTLINE void place_by_predecessor(const mbsri_sweep_run *run, int i,
                                        const mbsri_newton_sweeps *newton, slopes *by)
{
    const int pred = run->tree->body[i].parent;
    const v4 to_h = -load(run->state[i].rho);
    place_slopes(newton->acting.by_pred + newton->acting.pair[i], newton->acting.own + pred,
                 newton->acting.own + i, by);
    add_turned(by->by[DISPLACEMENT], to_h, by->by[ROTATION]);
    add_turned(by->by[DRIFT], to_h, by->by[SPIN]);
}

/* Slopes of the forces on the predecessor over body i's motion, about body i's point. */
MBSRI_OUTLINE void place_on_predecessor(const mbsri_sweep_run *run, int i,
                                        const mbsri_newton_sweeps *newton, slopes *by)
{
    const int pred = run->tree->body[i].parent;
    const v4 rho = load(run->state[i].rho);
    place_slopes(newton->acting.on_pred + newton->acting.pair[i], newton->acting.own + i,
                 newton->acting.own + pred, by);
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) by->by[g][j][0] -= cross(rho, by->by[g][j][1]);
    }
}

/* forces += slopes times motion */
MBSRI_INLINE void apply_slopes(const slopes *by, const v4 x[4], v4 forces[4])
{
    for (int g = 0; g < 4; ++g) {
        const v4 k[3] = {xxx(x[g]), yyy(x[g]), zzz(x[g])};
        for (int j = 0; j < 3; ++j) {
            forces[MOMENT] += by->by[g][j][0] * k[j];
            forces[FORCE] += by->by[g][j][1] * k[j];
        }
    }
}

/* Whether elements act between body i and its predecessor. */
MBSRI_INLINE bool is_pair(const mbsri_newton_sweeps *newton, int i, bool full)
{
    return full && newton->acting.pair[i] >= 0;
}

#endif
