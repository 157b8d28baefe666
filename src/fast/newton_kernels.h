/* The Newton system of the momentum form over a tree of rigid bodies, eliminated leaves to root and
 * solved root to leaves; compiled with kernels.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body, at its point: dtheta and xi, its rotation and the displacement of the
 * point, nu the change of (omega, v) seen in the moving body (nu = dV - xi x V). Those of the
 * subtree's momentum (L, p), chi, are seen in the moving body, those of the wrench (N, F) of the
 * applied forces, phi, along the world's axes and about the moving point. Below, h is what moves
 * with the joint's near side, a with its far side. With the axis S = (S_w, S_v) at the body's
 * point, V_h = (omega_pi, v_pi + omega_pi x rho) and S' = V_h x S,
 *
 *   dtheta_a = dtheta_h + S_w dq     xi_a = xi_h + S_v dq     nu_a = nu_h + S du + S' dq
 *   chi_h = chi_a + dq (S_w x L + S_v x p, S_w x p)           phi_h = phi_a + dq (S_v x F, 0)
 *   d(Mu) = S^T chi_h
 *   dP    = S^T phi_h + (S_w x N + S_v x F) . dtheta_h
 *           + S'^T chi_h + (S_w x L + S_v x p, S_w x p) . nu_h + dtau
 *
 * From the predecessor's point to the body's, xi_h = xi + dtheta x rho, nu likewise; back, moments
 * + rho x forces, phi also + (dtheta x rho) x F. A body adds chi = M nu and, by its weight m g with
 * the first moment h, the moment (dtheta x h) x g. So no force depends on xi, and no change of the
 * force F on anything, unless elements act on bodies (`full`): what is left out then is zero.
 *
 * Equations of a joint, with w = L r_u (dae_momentum.c) and dq = (du + r_q) / c:
 *
 *   d(Mu) - dP / c = r_p / c + w,      delta p = d(Mu) - w
 *
 * Leaves to root, (chi, phi) = P (dtheta, nu, xi) + b, a row of P and of b a joint. */
#include "newton.h"

/* Groups of columns and of rows. */
enum { ROTATION, SPIN, DRIFT, DISPLACEMENT };
enum { CHI_L, CHI_P, MOMENT, FORCE };

MBSRI_INLINE int groups(bool full)
{
    return full ? 4 : 3;
}

/* The fourth group of a column stands apart from the others. */
enum { LAST_C, LAST_U, LAST_K, LAST_Q };

MBSRI_INLINE double *group_of(mbsri_newton_column *col, double *first, int last, int g)
{
    return g < 3 ? first + 3 * g : col->last + 3 * last;
}

/* P, Y (newton_reaction.h), and the flows of the subtree. */
typedef struct slab {
    v4 P[4][3][4], Y[4][3][2], L, p, N, F;
} slab;

MBSRI_INLINE void clear_slab(slab *y, bool full)
{
    const v4 none = splat(0.0);
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] = none;
        }
    }
    y->L = y->p = y->N = y->F = none;
}

MBSRI_INLINE void slab_to_memory(const slab *y, mbsri_newton_carry *m, bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) store(m->P[g][j][r], y->P[g][j][r]);
        }
    }
    store(m->L, y->L), store(m->p, y->p);
    store(m->N, y->N), store(m->F, y->F);
}

MBSRI_INLINE void add_slab(const mbsri_newton_carry *m, slab *y, bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] += load(m->P[g][j][r]);
        }
    }
    y->L += load(m->L), y->p += load(m->p);
    y->N += load(m->N), y->F += load(m->F);
}

/* The same of Y. */
MBSRI_INLINE void clear_reaction(slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) y->Y[g][j][0] = y->Y[g][j][1] = splat(0.0);
    }
}

MBSRI_INLINE void add_reaction(const mbsri_newton_carry *m, slab *y)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) y->Y[g][j][r] += load(m->Y[g][j][r]);
        }
    }
}

MBSRI_INLINE void reaction_to_memory(const slab *y, mbsri_newton_carry *m)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < 2; ++r) store(m->Y[g][j][r], y->Y[g][j][r]);
        }
    }
}

/* chi = M nu;  the moment (dtheta x h) x g of the weight;  the flows. */
MBSRI_INLINE void add_own_slab(const mbsri_fast_body *b, const mbsri_fast_state *s, v4 g, slab *y)
{
    blocks own;
    clear(&own);
    add_own(b, s, &own);
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)};
    const v4 omega = load(s->omega), v = load(s->v), h = times_stored(R, b->c),
             mass = splat(b->c[3]), hg = splat(sum3(h * g));
    for (int j = 0; j < 3; ++j) {
        y->P[SPIN][j][CHI_L] += own.I[j];
        y->P[SPIN][j][CHI_P] += own.G[j];
        y->P[DRIFT][j][CHI_L] -= own.G[j];
        y->P[DRIFT][j][CHI_P] += mass * e[j];
        y->P[ROTATION][j][MOMENT] += h * splat(g[j]) - hg * e[j];
    }
    y->L += times(own.I, omega) + cross(h, v);
    y->p += mass * v + cross(omega, h);
    y->N += cross(h, g);
    y->F += mass * g;
}

/* (a, b, c) -> sums over the components of each */
MBSRI_INLINE v4 sums(v4 a, v4 b, v4 c)
{
    const v4 product[3] = {a, b, c};
    v4 row[3];
    transpose(product, row);
    return row[0] + row[1] + row[2];
}

/* From body i's point to its predecessor's: P, and the flows. */
MBSRI_INLINE void translate_slab(v4 rho, slab *y, bool full)
{
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 x = xxx(rho), by_y = yyy(rho), z = zzz(rho), rho_F = splat(sum3(rho * y->F));
    /* nu_h = nu + nu_w x rho, xi likewise: columns */
    for (int g = 0; g < (full ? 2 : 1); ++g) {
        v4(*turn)[4] = y->P[g ? ROTATION : SPIN], (*shift)[4] = y->P[g ? DISPLACEMENT : DRIFT];
        for (int r = 0; r < groups(full); ++r) {
            turn[0][r] += by_y * shift[2][r] - z * shift[1][r];
            turn[1][r] += z * shift[0][r] - x * shift[2][r];
            turn[2][r] += x * shift[1][r] - by_y * shift[0][r];
        }
    }
    /* moments + rho x forces: rows; and (dtheta x rho) x F */
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) {
            y->P[g][j][CHI_L] += cross(rho, y->P[g][j][CHI_P]);
            if (full) y->P[g][j][MOMENT] += cross(rho, y->P[g][j][FORCE]);
        }
    }
    for (int j = 0; j < 3; ++j) y->P[ROTATION][j][MOMENT] += rho * splat(y->F[j]) - rho_F * e[j];
    y->L += cross(rho, y->p);
    y->N += cross(rho, y->F);
}

/* The same of Y. */
MBSRI_INLINE void translate_reaction(v4 rho, slab *y, bool full)
{
    const v4 x = xxx(rho), by_y = yyy(rho), z = zzz(rho);
    for (int g = 0; g < (full ? 2 : 1); ++g) {
        v4(*turn)[2] = y->Y[g ? ROTATION : SPIN], (*shift)[2] = y->Y[g ? DISPLACEMENT : DRIFT];
        for (int r = 0; r < 2; ++r) {
            turn[0][r] += by_y * shift[2][r] - z * shift[1][r];
            turn[1][r] += z * shift[0][r] - x * shift[2][r];
            turn[2][r] += x * shift[1][r] - by_y * shift[0][r];
        }
    }
    for (int g = 0; g < groups(full); ++g) {
        for (int j = 0; j < 3; ++j) y->Y[g][j][0] += cross(rho, y->Y[g][j][1]);
    }
}

/* A row over the body's motion to one over its predecessor's. */
MBSRI_INLINE void translate_row(v4 rho, v4 row[4], bool full)
{
    row[SPIN] += cross(rho, row[DRIFT]);
    if (full) row[ROTATION] += cross(rho, row[DISPLACEMENT]);
}

/* ---- force elements on bodies ---- */

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

MBSRI_INLINE void place_own(const mbsri_fast_run *run, int i, mbsri_newton_own *own)
{
    const mbsri_fast_state *s = run->state + i;
    const double *x = run->tree->own[i].x;
    const v4 omega = load(s->omega), arm = load(s->R) * splat(x[0]) + load(s->R + 4) * splat(x[1]) +
                                           load(s->R + 8) * splat(x[2]);
    store(own->arm, arm);
    store(own->omega, omega);
    store(own->v, load(s->v) + cross(omega, arm));
}

/* The forces of elements on body i, and their slopes over its own motion. */
MBSRI_OUTLINE void add_elements(const mbsri_fast_run *run, int i, const mbsri_fast_newton *newton,
                                slab *y, bool deep)
{
    const mbsri_fast_load *on = run->load + i;
    const mbsri_newton_own *own = newton->own + i;
    const v4 e[3] = {{1.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}};
    const v4 f = load(on->p), arm = load(own->arm), product = splat(sum3(arm * f));
    slopes by;
    place_slopes(newton->at + newton->number[i], own, own, &by);
    add_slopes(&by, y);
    /* the arm turns: (dtheta x arm) x f */
    for (int j = 0; j < 3; ++j) {
        const v4 turned = arm * splat(f[j]) - product * e[j];
        y->P[ROTATION][j][MOMENT] += turned;
        if (!deep) continue;
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
MBSRI_OUTLINE void place_by_predecessor(const mbsri_fast_run *run, int i,
                                        const mbsri_fast_newton *newton, slopes *by)
{
    const int pred = run->tree->body[i].parent;
    const v4 to_h = -load(run->state[i].rho);
    place_slopes(newton->by_pred + newton->pair[i], newton->own + pred, newton->own + i, by);
    add_turned(by->by[DISPLACEMENT], to_h, by->by[ROTATION]);
    add_turned(by->by[DRIFT], to_h, by->by[SPIN]);
}

/* Slopes of the forces on the predecessor over body i's motion, about body i's point. */
MBSRI_OUTLINE void place_on_predecessor(const mbsri_fast_run *run, int i,
                                        const mbsri_fast_newton *newton, slopes *by)
{
    const int pred = run->tree->body[i].parent;
    const v4 rho = load(run->state[i].rho);
    place_slopes(newton->on_pred + newton->pair[i], newton->own + i, newton->own + pred, by);
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
MBSRI_INLINE bool is_pair(const mbsri_fast_newton *newton, int i, bool full)
{
    return full && newton->pair[i] >= 0;
}

/* ---- joints ---- */

/* An axis at the body's point, and what goes with it. */
typedef struct axis {
    v4 S_w, S_v;       /* S */
    v4 rate_w, rate_v; /* S' */
    v4 row_w, row_v;   /* S - S' / c: the row of the joint over chi */
    v4 J[4];           /* what dq adds to the forces */
    v4 turned;         /* S_w x N + S_v x F */
} axis;

MBSRI_INLINE void finish_axis(const slab *y, double by_c, axis *a)
{
    const v4 s = splat(by_c);
    a->row_w = a->S_w - s * a->rate_w;
    a->row_v = a->S_v - s * a->rate_v;
    a->J[CHI_L] = cross(a->S_w, y->L) + cross(a->S_v, y->p);
    a->J[CHI_P] = cross(a->S_w, y->p);
    a->J[MOMENT] = cross(a->S_v, y->F);
    a->J[FORCE] = splat(0.0);
    a->turned = cross(a->S_w, y->N) + a->J[MOMENT];
}

/* out = P (rotation, nu_w, nu_v, displacement) */
MBSRI_INLINE void apply_slab(const slab *y, const v4 x[4], v4 out[4], bool full)
{
    for (int r = 0; r < groups(full); ++r) out[r] = splat(0.0);
    for (int g = 0; g < groups(full); ++g) {
        const v4 one = xxx(x[g]), two = yyy(x[g]), three = zzz(x[g]);
        for (int r = 0; r < groups(full); ++r)
            out[r] += y->P[g][0][r] * one + y->P[g][1][r] * two + y->P[g][2][r] * three;
    }
}

/* The products, not summed, of the row of a joint with a column of forces. */
MBSRI_INLINE v4 along_row(const axis *a, v4 by_c, const v4 column[4], bool full)
{
    v4 sum = a->row_w * column[CHI_L] + a->row_v * column[CHI_P] - by_c * a->S_w * column[MOMENT];
    if (full) sum -= by_c * a->S_v * column[FORCE];
    return sum;
}

MBSRI_INLINE v4 magnitude(v4 x)
{
    return (v4)((i4)x & (i4){0x7fffffffffffffff, 0x7fffffffffffffff, 0x7fffffffffffffff, 0});
}

/* The sum of the sizes of these products. */
MBSRI_INLINE double size_of_row(const axis *a, v4 by_c, const v4 column[4], bool full)
{
    v4 sum = magnitude(a->row_w * column[CHI_L]) + magnitude(a->row_v * column[CHI_P]) +
             magnitude(by_c * a->S_w * column[MOMENT]);
    if (full) sum += magnitude(by_c * a->S_v * column[FORCE]);
    return sum3(sum);
}

/* R, the row of the joint over x_h. */
MBSRI_INLINE void joint_row(const slab *y, const axis *a, v4 by_c, v4 R[4], bool full)
{
    for (int g = 0; g < groups(full); ++g)
        R[g] = sums(along_row(a, by_c, y->P[g][0], full), along_row(a, by_c, y->P[g][1], full),
                    along_row(a, by_c, y->P[g][2], full));
    R[ROTATION] -= by_c * a->turned;
    R[SPIN] -= by_c * a->J[CHI_L];
    R[DRIFT] -= by_c * a->J[CHI_P];
}

/* S^T chi over x_h */
MBSRI_INLINE void momentum_row(const slab *y, v4 S_w, v4 S_v, v4 Q[4], bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        v4 product[3];
        for (int j = 0; j < 3; ++j) product[j] = S_w * y->P[g][j][CHI_L] + S_v * y->P[g][j][CHI_P];
        Q[g] = sums(product[0], product[1], product[2]);
    }
}

/* P -= C K^T */
MBSRI_INLINE void subtract_column(slab *y, const v4 C[4], const v4 K[4], bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        const v4 k[3] = {xxx(K[g]), yyy(K[g]), zzz(K[g])};
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] -= C[r] * k[j];
        }
    }
}

/* The record of a coordinate, its groups in their order. */
MBSRI_INLINE void keep_column(mbsri_newton_column *col, const axis *a, const v4 K[4], const v4 Q[4],
                              const v4 C[4], const v4 U[4], const v4 G[2], bool full)
{
    for (int g = 0; g < 3; ++g) store3(col->C + 3 * g, C[g]);
    for (int g = 0; g < 3; ++g) store3(col->U + 3 * g, U[g]);
    store3(col->G, G[0]), store3(col->G + 3, G[1]);
    store3(col->S, a->S_w), store3(col->S + 3, a->S_v);
    store3(col->row, a->row_w), store3(col->row + 3, a->row_v);
    for (int g = 0; g < 3; ++g) store3(col->K + 3 * g, K[g]);
    for (int g = 0; g < 3; ++g) store3(col->Q + 3 * g, Q[g]);
    if (!full) return;
    store3(col->last + 3 * LAST_C, C[3]), store3(col->last + 3 * LAST_U, U[3]);
    store3(col->last + 3 * LAST_K, K[3]), store3(col->last + 3 * LAST_Q, Q[3]);
}

/* Pivots below this, relative to the size of what was summed, are zero but for rounding. */
#define MBSRI_LEAST_PIVOT 1e-14

#include "newton_many.h"

#include "newton_reaction.h"

/* A joint of one axis on the way: C, U, the row over x_h and what it becomes. */
typedef struct passage {
    axis a;
    v4 motion[4], by_r[4]; /* of the body by du and by r_q */
    v4 C[4], U[4], row[4], K[4], Q[4];
    double E, size, gain; /* what du and r_q add to the row; the size of what was summed */
    double tau_q, tau_u;  /* slopes of the joint force over c^2 and c */
    reaction t;
} passage;

/* C = P (S_w / c, S + S' / c, S_v / c) + J / c,  U = C - P (0, S, 0);
 * E du + R x_h = r_p / c + w - row . b - gain r_q */
MBSRI_INLINE void open_passage(const mbsri_fast_run *run, int i, const mbsri_fast_newton *newton,
                               const slab *y, passage *p, bool full)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *pred = run->state + b->parent, *s = run->state + i;
    const v4 Z = load(s->R + 8), rho = load(s->rho), omega = load(pred->omega);
    const v4 by_c = splat(newton->by_c);
    axis *a = &p->a;
    a->S_w = b->flags & MBSRI_TURNS ? Z : splat(0.0);
    a->S_v = splat(b->pitch) * Z;
    a->rate_w = cross(omega, a->S_w);
    a->rate_v = cross(omega, a->S_v) + cross(load(pred->v) + cross(omega, rho), a->S_w);
    finish_axis(y, newton->by_c, a);
    p->motion[ROTATION] = p->by_r[ROTATION] = by_c * a->S_w;
    p->by_r[SPIN] = by_c * a->rate_w;
    p->by_r[DRIFT] = by_c * a->rate_v;
    p->motion[SPIN] = a->S_w + p->by_r[SPIN];
    p->motion[DRIFT] = a->S_v + p->by_r[DRIFT];
    p->motion[DISPLACEMENT] = p->by_r[DISPLACEMENT] = by_c * a->S_v;
    apply_slab(y, p->motion, p->C, full);
    for (int r = 0; r < groups(full); ++r) {
        p->C[r] += by_c * a->J[r];
        v4 inertia = splat(0.0);
        for (int j = 0; j < 3; ++j)
            inertia += y->P[SPIN][j][r] * splat(a->S_w[j]) + y->P[DRIFT][j][r] * splat(a->S_v[j]);
        p->U[r] = p->C[r] - inertia;
    }
    p->tau_q = newton->tau_q ? newton->tau_q[b->u] * newton->by_c * newton->by_c : 0.0;
    p->tau_u = newton->tau_u ? newton->tau_u[b->u] * newton->by_c : 0.0;
    p->E = sum3(along_row(a, by_c, p->C, full)) - p->tau_q - p->tau_u;
    p->size = size_of_row(a, by_c, p->C, full) + fabs(p->tau_q) + fabs(p->tau_u);
    p->gain = sum3(along_row(a, by_c, p->U, full)) - p->tau_q;
}

/* The row of F_p determines du. */
MBSRI_INLINE bool by_momentum(passage *p, bool full)
{
    if (!(fabs(p->E) > MBSRI_LEAST_PIVOT * p->size)) return false;
    const v4 inverse = splat(1.0 / p->E),
             SC = splat(sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]));
    for (int g = 0; g < groups(full); ++g) {
        p->K[g] = p->row[g] * inverse;
        p->Q[g] -= SC * p->K[g];
    }
    return true;
}

/* The balance of forces does; delta p = d(Mu) + r_p / c - the row of F_p. */
MBSRI_INLINE bool by_reaction(passage *p, bool full)
{
    if (!(fabs(p->t.along_C) > MBSRI_LEAST_PIVOT * p->t.size)) return false;
    const v4 inverse = splat(1.0 / p->t.along_C), E = splat(p->E),
             SC = splat(sum3(p->a.S_w * p->C[CHI_L] + p->a.S_v * p->C[CHI_P]));
    for (int g = 0; g < groups(full); ++g) {
        p->K[g] = p->t.row[g] * inverse;
        p->Q[g] += (E - SC) * p->K[g] - p->row[g];
    }
    return true;
}

/* Elements between the body and its predecessor: what they exert on the latter. */
MBSRI_OUTLINE void close_pair(const mbsri_fast_run *run, int i, const mbsri_fast_newton *newton,
                              passage *p, slab *y, bool deep)
{
    slopes on;
    place_on_predecessor(run, i, newton, &on);
    apply_slopes(&on, p->motion, p->C);
    apply_slopes(&on, p->by_r, p->U);
    add_slopes(&on, y);
    if (!deep) return;
    v4 forces[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)}, by_r[4];
    memcpy(by_r, forces, sizeof by_r);
    apply_slopes(&on, p->motion, forces);
    apply_slopes(&on, p->by_r, by_r);
    for (int r = 0; r < 2; ++r) {
        p->t.C[r] -= forces[MOMENT + r];
        p->t.U[r] -= by_r[MOMENT + r];
    }
    subtract_slopes(&on, y);
}

/* Of a deep body: psi over x_h, and what u' takes up of it. */
MBSRI_OUTLINE void pass_reaction(const mbsri_fast_run *run, int i, const mbsri_fast_newton *newton,
                                 const v4 G[2], passage *p, slab *y, bool full)
{
    open_reaction(i, newton, &p->a, p->motion, p->by_r, p->tau_q, p->tau_u, y, &p->t, full);
    if (is_pair(newton, i, full)) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        subtract_slopes(&by, y);
    }
    reaction_row(y, &p->a, &p->t, full);
    if (!(newton->step[i].deep & MBSRI_NO_INERTIA)) take_up(G, &p->t, y, full);
}

MBSRI_INLINE void keep_deep(mbsri_fast_newton *newton, int i, int u, const passage *p)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    mbsri_newton_deep *below = newton->below + u;
    store3(below->C, p->t.C[0]), store3(below->C + 3, p->t.C[1]);
    store3(below->U, p->t.U[0]), store3(below->U + 3, p->t.U[1]);
    if (!(newton->step[i].deep & MBSRI_NO_INERTIA)) return;
    below->pivot = p->E;
    below->gain = p->gain;
    col->inverse = 1.0 / p->t.along_C;
    col->gain = p->t.along_U;
}

/* A joint of one axis; false: its row is singular. */
MBSRI_INLINE bool eliminate(const mbsri_fast_run *run, int i, mbsri_fast_newton *newton, slab *y,
                            bool full, bool deep)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *s = run->state + i;
    const v4 rho = load(s->rho), by_c = splat(newton->by_c);
    const v4 G[2] = {load(s->U_L) * splat(s->Dinv), load(s->U_p) * splat(s->Dinv)};
    mbsri_newton_column *col = mbsri_newton_column_at(newton, b->u);
    passage p;
    memset(&p.t, 0, sizeof p.t);
    open_passage(run, i, newton, y, &p, full);
    const bool pair = is_pair(newton, i, full);
    if (deep) pass_reaction(run, i, newton, G, &p, y, full);
    if (pair) {
        slopes by;
        place_by_predecessor(run, i, newton, &by);
        add_slopes(&by, y);
    }
    joint_row(y, &p.a, by_c, p.row, full);
    momentum_row(y, p.a.S_w, p.a.S_v, p.Q, full);
    const bool balance_of_forces = deep && newton->step[i].deep & MBSRI_NO_INERTIA;
    if (!(balance_of_forces ? by_reaction(&p, full) : by_momentum(&p, full))) return false;
    if (pair) close_pair(run, i, newton, &p, y, deep);
    if (b->parent > 0) subtract_column(y, p.C, p.K, full);
    if (deep) subtract_reaction(y, p.t.C, p.K, full);
    translate_row(rho, p.K, full);
    translate_row(rho, p.Q, full);
    keep_column(col, &p.a, p.K, p.Q, p.C, p.U, G, full);
    col->inverse = 1.0 / p.E;
    col->gain = p.gain;
    if (deep) keep_deep(newton, i, b->u, &p);
    return true;
}

/* ---- leaves to root: Mbar and P ---- */

/* Where the elimination stands. */
typedef struct elimination {
    slab y;
    mbsri_newton_carry *top;
} elimination;

/* The record of a coordinate, to be written soon. */
MBSRI_INLINE void expect_column(const mbsri_fast_newton *newton, int u)
{
    const char *record = (const char *)mbsri_newton_column_at(newton, u > 0 ? u : 0);
    for (size_t k = 0; k < newton->column_size; k += 64) __builtin_prefetch(record + k, 1);
}

/* A weld: only elements act through it. */
MBSRI_OUTLINE void pass_weld(const mbsri_fast_run *run, int i, const mbsri_fast_newton *newton,
                             slab *y, bool deep)
{
    slopes by, on;
    place_by_predecessor(run, i, newton, &by);
    place_on_predecessor(run, i, newton, &on);
    add_slopes(&by, y);
    add_slopes(&on, y);
    if (!deep) return;
    subtract_slopes(&by, y);
    subtract_slopes(&on, y);
}

/* From body i to its predecessor. */
MBSRI_INLINE void hand_over(const mbsri_fast_run *run, int i, elimination *at, bool full, bool deep)
{
    const int flags = run->tree->body[i].flags;
    const v4 rho = load(run->state[i].rho);
    slab *y = &at->y;
    translate_slab(rho, y, full);
    if (deep) translate_reaction(rho, y, full);
    if (flags & MBSRI_NEXT) return;
    if (!(flags & MBSRI_OPENS)) {
        add_slab(--at->top, y, full);
        if (deep) add_reaction(at->top, y);
    }
    slab_to_memory(y, at->top, full);
    if (deep) reaction_to_memory(y, at->top);
    ++at->top;
}

/* Past body i, which the backward sweep has passed, too; false: the rows of its joint are singular.
 * any: there are deep bodies. What reaches others of Y is not used. */
MBSRI_INLINE bool eliminate_body(const mbsri_fast_run *run, int i, mbsri_fast_newton *newton,
                                 elimination *at, bool full, bool any)
{
    const mbsri_fast *tree = run->tree;
    const mbsri_fast_body *b = tree->body + i;
    const mbsri_fast_state *s = run->state + i;
    const v4 g = {tree->gravity[0], tree->gravity[1], tree->gravity[2], 0.0};
    const int flags = b->flags;
    const bool deep = any && newton->step[i].deep & MBSRI_DEEP;
    slab *y = &at->y;
    expect_column(newton, b->u - 2);
    if (flags & MBSRI_LEAF) clear_slab(y, full);
    if (any && flags & MBSRI_LEAF) clear_reaction(y);
    if (flags & MBSRI_BRANCHES) {
        add_slab(--at->top, y, full);
        if (any) add_reaction(at->top, y);
    }
    if (!(flags & MBSRI_MASSLESS)) add_own_slab(b, s, g, y);
    if (full && flags & MBSRI_LOADED) add_elements(run, i, newton, y, deep);
    if (flags & MBSRI_MANY) {
        _Alignas(32) mbsri_newton_carry many;
        slab_to_memory(y, &many, full);
        if (!eliminate_many(run, i, newton, &many, full)) return false;
        clear_slab(y, full);
        add_slab(&many, y, full);
    } else if (b->n) {
        if (!eliminate(run, i, newton, y, full, deep)) return false;
    } else if (is_pair(newton, i, full)) {
        pass_weld(run, i, newton, y, deep);
    }
    store(newton->step[i].rho, load(s->rho));
    if (b->parent > 0) hand_over(run, i, at, full, any);
    return true;
}

MBSRI_INLINE void start_elimination(const mbsri_fast_run *run, mbsri_fast_newton *newton,
                                    elimination *at, bool full)
{
    clear_slab(&at->y, full);
    at->top = newton->carry;
    for (int i = 1; i <= run->tree->bodies && full; ++i) place_own(run, i, newton->own + i);
}

/* Both in one sweep, while the body is at hand. */
MBSRI_INLINE int factor_sweep(const mbsri_fast_run *run, mbsri_fast_newton *newton, bool full)
{
    back at;
    elimination of;
    start_back(run, &at);
    start_elimination(run, newton, &of, full);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!pass_body(run, i, false, &at)) return MBSRI_DEFICIENT;
        if (run->rank[i] != run->tree->body[i].n) return MBSRI_DEFICIENT;
        if (!eliminate_body(run, i, newton, &of, full, false)) return i;
    }
    return 0;
}

static int newton_factor(const mbsri_fast_run *run, mbsri_fast_newton *newton)
{
    return run->load ? factor_sweep(run, newton, true) : factor_sweep(run, newton, false);
}

/* After the backward sweep, where the bound does not tell or bodies are deep; their reactions are
 * known. */
MBSRI_INLINE int deep_sweep(const mbsri_fast_run *run, mbsri_fast_newton *newton, bool full)
{
    elimination of;
    start_elimination(run, newton, &of, full);
    clear_reaction(&of.y);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!eliminate_body(run, i, newton, &of, full, true)) return i;
    }
    return 0;
}

static int newton_factor_deep(const mbsri_fast_run *run, mbsri_fast_newton *newton)
{
    if (!backward(run) || !find_deep(run, newton)) return MBSRI_NOT_CLEAR;
    newton->unclear = true;
    if (newton->deep) forward(run);
    if (newton->deep) find_reactions(run, newton);
    return run->load ? deep_sweep(run, newton, true) : deep_sweep(run, newton, false);
}

/* ---- the solution: leaves to root b, root to leaves du ---- */

/* b, that of psi, and the recursion for w. */
typedef struct loads {
    v4 b[4], psi[2], L_bar, p_bar;
} loads;

MBSRI_INLINE void clear_loads(loads *f)
{
    f->b[0] = f->b[1] = f->b[2] = f->b[3] = f->L_bar = f->p_bar = splat(0.0);
    f->psi[0] = f->psi[1] = splat(0.0);
}

MBSRI_INLINE void add_loads(const mbsri_newton_flow *m, loads *f, bool full, bool deep)
{
    for (int r = 0; r < groups(full); ++r) f->b[r] += load(m->b + 4 * r);
    for (int r = 0; r < 2 && deep; ++r) f->psi[r] += load(m->psi + 4 * r);
    f->L_bar += load(m->L_bar), f->p_bar += load(m->p_bar);
}

MBSRI_INLINE void loads_to_memory(const loads *f, mbsri_newton_flow *m, bool full, bool deep)
{
    for (int r = 0; r < groups(full); ++r) store(m->b + 4 * r, f->b[r]);
    for (int r = 0; r < 2 && deep; ++r) store(m->psi + 4 * r, f->psi[r]);
    store(m->L_bar, f->L_bar), store(m->p_bar, f->p_bar);
}

/* Of one coordinate: r, and the change of its joint force. */
typedef struct given {
    double q, p, u, tau;
} given;

/* What b adds to the row of the joint in F_p. */
MBSRI_INLINE double row_of_loads(const mbsri_newton_column *col, v4 by_c, const loads *f, bool full)
{
    v4 row = load3(col->row) * f->b[CHI_L] + load3(col->row + 3) * f->b[CHI_P] -
             by_c * load3(col->S) * f->b[MOMENT];
    if (full) row -= by_c * load3(col->S + 3) * f->b[FORCE];
    return sum3(row);
}

/* b behind the joint. */
MBSRI_INLINE void pass_loads(mbsri_newton_column *col, double k, double r_q, loads *f, bool full)
{
    for (int r = 0; r < groups(full); ++r)
        f->b[r] += load3(group_of(col, col->C, LAST_C, r)) * splat(k) +
                   load3(group_of(col, col->U, LAST_U, r)) * splat(r_q);
}

/* k and p of a joint of one axis, by the row of F_p. */
MBSRI_INLINE double condense_loads(const mbsri_fast_newton *newton, int u, given r, loads *f,
                                   bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3), by_c = splat(newton->by_c);
    const double w = r.u + sum3(S_w * f->L_bar + S_v * f->p_bar);
    const double row = row_of_loads(col, by_c, f, full);
    const double k = (newton->by_c * (r.p + r.tau) + w - row - col->gain * r.q) * col->inverse;
    pass_loads(col, k, r.q, f, full);
    newton->k[u] = k;
    newton->p[u] = sum3(S_w * f->b[CHI_L] + S_v * f->b[CHI_P]) - w;
    f->L_bar += load3(col->G) * splat(r.u);
    f->p_bar += load3(col->G + 3) * splat(r.u);
    return k;
}

/* The same by the balance of forces (newton_reaction.h). */
MBSRI_INLINE double balance_loads(const mbsri_fast_newton *newton, int u, given r, loads *f,
                                  bool full)
{
    mbsri_newton_column *col = mbsri_newton_column_at(newton, u);
    const mbsri_newton_deep *below = newton->below + u;
    const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
    const double row = row_of_loads(col, splat(newton->by_c), f, full);
    const double psi = sum3(S_w * f->psi[PSI_L] + S_v * f->psi[PSI_P]);
    const double k = (r.u + r.tau - psi - col->gain * r.q) * col->inverse;
    pass_loads(col, k, r.q, f, full);
    newton->k[u] = k;
    newton->p[u] = newton->by_c * (r.p + r.tau) + sum3(S_w * f->b[CHI_L] + S_v * f->b[CHI_P]) -
                   row - below->pivot * k - below->gain * r.q;
    return k;
}

/* A joint of one axis in a solution with deep bodies. */
MBSRI_INLINE void condense_deep(const mbsri_fast_newton *newton, const mbsri_newton_step *s,
                                given r, loads *f, bool full)
{
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    if (!(s->deep & MBSRI_DEEP)) {
        condense_loads(newton, s->u, r, f, full);
        return;
    }
    const mbsri_newton_deep *below = newton->below + s->u;
    const bool balance_of_forces = (s->deep & MBSRI_NO_INERTIA) != 0;
    const double seen =
        sum3(load3(col->S) * f->psi[PSI_L] + load3(col->S + 3) * f->psi[PSI_P]) - r.tau;
    const v4 taken = splat(balance_of_forces ? 0.0 : seen),
             k = splat(balance_of_forces ? balance_loads(newton, s->u, r, f, full)
                                         : condense_loads(newton, s->u, r, f, full));
    for (int g = 0; g < 2; ++g)
        f->psi[g] += load3(below->C + 3 * g) * k + load3(below->U + 3 * g) * splat(r.q) -
                     load3(col->G + 3 * g) * taken;
}

/* load: wrench at the origin of body i's own frame. */
MBSRI_INLINE void add_load(const mbsri_fast_newton *newton, int i, const double *load_of_body,
                           loads *f, bool deep)
{
    const double *x = load_of_body + newton->model->body[i].v;
    const v4 force = {x[3], x[4], x[5], 0.0},
             moment = (v4){x[0], x[1], x[2], 0.0} + cross(load(newton->own[i].arm), force);
    f->b[MOMENT] += moment;
    f->b[FORCE] += force;
    if (!deep || !(newton->step[i].deep & MBSRI_DEEP)) return;
    f->psi[PSI_L] -= moment;
    f->psi[PSI_P] -= force;
}

/* From body i to its predecessor. */
MBSRI_INLINE void hand_loads_over(const mbsri_newton_step *s, loads *f, mbsri_newton_flow **top,
                                  bool full, bool deep)
{
    const v4 rho = load(s->rho);
    f->b[CHI_L] += cross(rho, f->b[CHI_P]);
    if (full) f->b[MOMENT] += cross(rho, f->b[FORCE]);
    f->L_bar += cross(rho, f->p_bar);
    if (deep) f->psi[PSI_L] += cross(rho, f->psi[PSI_P]);
    if (s->flags & MBSRI_NEXT) return;
    if (!(s->flags & MBSRI_OPENS)) add_loads(--*top, f, full, deep);
    loads_to_memory(f, (*top)++, full, deep);
}

MBSRI_INLINE void solve_back(mbsri_fast_newton *newton, const double *r, const double *load_of_body,
                             bool full, bool deep)
{
    const mbsr_model *m = newton->model;
    const double *r_p = r ? r + m->nq : NULL, *r_u = r ? r_p + m->nu : NULL;
    mbsri_newton_flow *top = newton->flow;
    loads f;
    clear_loads(&f);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_newton_step *s = newton->step + i;
        const int flags = s->flags;
        if (flags & MBSRI_LEAF) clear_loads(&f);
        if (flags & MBSRI_BRANCHES) add_loads(--top, &f, full, deep);
        if (full && load_of_body) add_load(newton, i, load_of_body, &f, deep);
        if (flags & MBSRI_MANY) {
            _Alignas(32) mbsri_newton_flow many;
            loads_to_memory(&f, &many, full, false);
            many_loads(newton, i, r, load_of_body, &many, full);
            clear_loads(&f);
            add_loads(&many, &f, full, false);
        } else if (s->n) {
            const int u = m->u_of[s->u];
            given g = {0.0, 0.0, 0.0, 0.0};
            if (r) g = (given){r[m->q_of[s->q]], r_p[u], r_u[u], 0.0};
            if (load_of_body) g.tau = load_of_body[m->size_v + (size_t)s->u];
            if (deep)
                condense_deep(newton, s, g, &f, full);
            else
                condense_loads(newton, s->u, g, &f, full);
        }
        hand_loads_over(s, &f, &top, full, deep);
    }
}

/* The motion of the origin of the body's own frame, and dV = nu + xi x V there. */
MBSRI_INLINE void report_motion(const mbsri_newton_own *own, const v4 x[4], double *motion)
{
    const v4 arm = load(own->arm), theta = x[ROTATION];
    const v4 out[4] = {theta, x[DISPLACEMENT] + cross(theta, arm),
                       x[SPIN] + cross(theta, load(own->omega)),
                       x[DRIFT] + cross(x[SPIN], arm) + cross(theta, load(own->v))};
    for (int g = 0; g < 4; ++g) {
        for (int k = 0; k < 3; ++k) motion[3 * g + k] = out[g][k];
    }
}

MBSRI_INLINE void solve_forward(mbsri_fast_newton *newton, const double *r, double *delta,
                                double *motion, bool full)
{
    const mbsr_model *m = newton->model;
    double *delta_p = delta + m->nq, *delta_u = delta_p + m->nu;
    v4 x[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_newton_step *s = newton->step + i;
        if (s->parent == 0) {
            for (int g = 0; g < groups(full); ++g) x[g] = splat(0.0);
        } else if (s->parent != i - 1) {
            for (int g = 0; g < groups(full); ++g)
                x[g] = load(newton->x[newton->step[s->parent].branch] + 4 * g);
        }
        const v4 rho = load(s->rho);
        if (s->flags & MBSRI_MANY) {
            _Alignas(32) double at[16];
            for (int g = 0; g < groups(full); ++g) store(at + 4 * g, x[g]);
            many_motion(newton, i, r, delta, at, full);
            for (int g = 0; g < groups(full); ++g) x[g] = load(at + 4 * g);
        } else if (s->n) {
            const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
            v4 K = load3(col->K) * x[0] + load3(col->K + 3) * x[1] + load3(col->K + 6) * x[2],
               Q = load3(col->Q) * x[0] + load3(col->Q + 3) * x[1] + load3(col->Q + 6) * x[2];
            if (full) K += load3(col->last + 3 * LAST_K) * x[3];
            if (full) Q += load3(col->last + 3 * LAST_Q) * x[3];
            const int u = m->u_of[s->u], q = m->q_of[s->q];
            const double du = newton->k[s->u] - sum3(K), both = du + (r ? r[q] : 0.0),
                         dq = both * newton->by_c;
            delta[q] = dq;
            delta_p[u] = newton->p[s->u] + sum3(Q);
            delta_u[u] = du;
            const v4 S_w = load3(col->S), S_v = load3(col->S + 3);
            x[DRIFT] +=
                cross(x[SPIN], rho) + S_v * splat(du) + (S_v - load3(col->row + 3)) * splat(both);
            if (full) x[DISPLACEMENT] += cross(x[ROTATION], rho) + S_v * splat(dq);
            x[SPIN] += S_w * splat(du) + (S_w - load3(col->row)) * splat(both);
            x[ROTATION] += S_w * splat(dq);
        } else {
            x[DRIFT] += cross(x[SPIN], rho);
            if (full) x[DISPLACEMENT] += cross(x[ROTATION], rho);
        }
        if (s->flags & MBSRI_BRANCHES) {
            for (int g = 0; g < groups(full); ++g) store(newton->x[s->branch] + 4 * g, x[g]);
        }
        if (full && motion) report_motion(newton->own + i, x, motion + 12 * i);
    }
}

MBSRI_INLINE void solve_system(mbsri_fast_newton *newton, const double *r,
                               const double *load_of_body, double *delta, double *motion, bool full)
{
    if (newton->deep)
        solve_back(newton, r, load_of_body, full, true);
    else
        solve_back(newton, r, load_of_body, full, false);
    solve_forward(newton, r, delta, motion, full);
}

static void newton_solve(mbsri_fast_newton *newton, const double *r, const double *load_of_body,
                         double *delta, double *motion)
{
    if (newton->own)
        solve_system(newton, r, load_of_body, delta, motion, true);
    else
        solve_system(newton, r, load_of_body, delta, NULL, false);
}
