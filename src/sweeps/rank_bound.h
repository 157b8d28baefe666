/* The rank of D in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The decision (recursion/rank_rule.h) needs W, the first-order size of the rounding errors in
 * Mbar. Mostly a bound is enough, two numbers instead of a matrix (docs/performance.md derives it):
 *
 *   W <= kappa Mbar + spread Lambda,   Lambda = diag(L^2, L^2, L^2, 1, 1, 1)
 *
 * Where it is not, the sweep starts again with W itself, kept in blocks like Mbar; and where that
 * leaves D between nothing and nine digits, the stages decide, in twofold precision. Both sweeps
 * first leave out of S what the joint behind has taken (remains.h), in whose place S' stands in the
 * errors. */
#ifndef MBSRI_SWEEPS_RANK_BOUND_H
#define MBSRI_SWEEPS_RANK_BOUND_H

#include "sweeps/carry.h"
#include "sweeps/remains.h"

#include <math.h>

/* t of docs/performance.md. */
MBSRI_INLINE double trace_of(const mbsri_sweeps *tree, int flags, const blocks *c)
{
    const double *weight = tree->trace[(flags & MBSRI_LEVEL) != 0];
    return sum3(c->I[0] * load3(weight) + c->M[0] * load3(weight + 4));
}

/* A joint of one axis, or none: its flags, m per unit of its coordinate, and the axis. */
typedef struct screw {
    int flags;
    double pitch;
    v4 Z;
} screw;

/* A joint on the way: U = Mbar S, D = S^T U + armature, e = tau - S^T (p + Mbar c). */
typedef struct joint {
    screw S;
    v4 U_L, U_p;
    double D, e;
    double Dinv; /* 0 where the rank is 0 */
} joint;

/* S^T Diag(Mbar) S, which S^T W S is at least. */
MBSRI_INLINE double least_noise(const screw *S, const blocks *c)
{
    const v4 square = S->Z * S->Z;
    double least = 0.0;
    if (S->flags & MBSRI_TURNS) least = sum3(square * c->I[0]);
    if (S->flags & MBSRI_SLIDES) least += S->pitch * S->pitch * sum3(square * c->M[0]);
    return least;
}

/* The traces of the blocks of Mbar that S takes part in, out of which D comes; in the plane tensors
 * are not turned, and what is there about x and y, which no joint ever takes away, has no part in
 * it. */
MBSRI_INLINE double local_size(const screw *S, const blocks *c)
{
    double local = 0.0;
    if (S->flags & MBSRI_TURNS) {
        local = c->I[0][2];
        if (!(S->flags & MBSRI_FLAT)) local += c->I[0][0] + c->I[0][1];
    }
    if (S->flags & MBSRI_SLIDES) local += S->pitch * S->pitch * sum3(c->M[0]);
    return local;
}

/* (x_L, x_p) = A S for symmetric blocks A. */
MBSRI_INLINE void times_axis(const screw *S, const blocks *A, v4 *x_L, v4 *x_p)
{
    *x_L = *x_p = splat(0.0);
    if (S->flags & MBSRI_TURNS) {
        *x_L = symmetric_times(A->I, S->Z);
        *x_p = cyclic_times(A->G, S->Z);
    }
    if (S->flags & MBSRI_SLIDES) {
        const v4 h = splat(S->pitch);
        *x_L += h * cyclic_transposed_times(A->G, S->Z);
        *x_p += h * symmetric_times(A->M, S->Z);
    }
}

/* S^T x + more */
MBSRI_INLINE double along_axis(const screw *S, v4 x_L, v4 x_p, double more)
{
    const v4 turn = S->Z * x_L, slide = S->Z * x_p;
    double sum = more;
    if (S->flags & MBSRI_TURNS) sum = (turn[0] + turn[1]) + (turn[2] + more);
    if (S->flags & MBSRI_SLIDES) sum += S->pitch * sum3(slide);
    return sum;
}

/* p += Mbar c, too. */
MBSRI_INLINE void open_joint(const mbsri_sweep_run *run, int i, int flags, blocks *c, joint *j)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    v4 swing_L, swing_p;
    times_masses(c, load(s->A_w), load(s->A_v), &swing_L, &swing_p);
    c->L += swing_L;
    c->p += swing_p;
    j->S = (screw){flags, b->pitch, load(s->R + 8)};
    times_axis(&j->S, c, &j->U_L, &j->U_p);
    j->D = along_axis(&j->S, j->U_L, j->U_p, b->armature);
    const double tau = flags & (MBSRI_TURNS | MBSRI_SLIDES) ? run->tau[b->u] : 0.0;
    j->e = -along_axis(&j->S, c->L, c->p, -tau);
    j->Dinv = 0.0;
}

/* |1 - S g^T|^2 from |S|^2 |g|^2, as which it counts where this projects. Behind armature it does
 * not, and is at most (1 + |S| |g|)^2 <= 2 + 2 |S|^2 |g|^2; mixes: whether there is any, 0 or 1. */
MBSRI_INLINE double beside(double mixes, double square)
{
    return square + mixes * (2.0 + square);
}

/* Armature is given, not summed up: however small, it is for the stages to judge. */
MBSRI_INLINE bool is_zero(const mbsri_rank_rule *rule, const mbsri_sweep_body *b, double D,
                          double noise, double local)
{
    return !(b->armature > 0.0) && mbsri_is_nothing(rule, D, noise, local);
}

/* The sums that D comes from, with S' in the place of S, and the least errors they may have. */
MBSRI_INLINE double local_size_of_remains(const remains *r, const blocks *c)
{
    return sum3(r->w * r->w) * sum3(c->I[0]) + sum3(r->v * r->v) * sum3(c->M[0]) + r->own;
}

MBSRI_INLINE double least_of_remains(const remains *r, const blocks *c)
{
    return sum3(r->w * r->w * c->I[0] + r->v * r->v * c->M[0]) + r->own;
}

/* Nothing, where S' is nothing but the rounding of positions and the body is without inertia, or D
 * is rounding beside what the joint behind has taken. */
MBSRI_INLINE bool remains_are_zero(const mbsri_rank_rule *rule, const mbsri_sweep_body *b,
                                   const remains *r, double left)
{
    if (b->armature > 0.0) return false;
    if (r->massless && left <= 1e-28 * r->square) return true;
    return left <= 1e-6 * r->square && mbsri_is_nothing(rule, r->D, r->behind / 6.0, r->behind);
}

/* |x|^2 in the metric that is inverse to that of the bound. */
MBSRI_INLINE double square_of(v4 x_L, v4 x_p, double per_area)
{
    return sum3(x_L * x_L * splat(per_area) + x_p * x_p);
}

/* |1 - x y^T|^2 from |x|^2 |y|^2 and x^T y. */
MBSRI_INLINE double square_beside(double product, double inner)
{
    const double sum = product - 2.0 * inner, root = sum * sum + 4.0 * (product - inner * inner);
    return 1.0 + 0.5 * (sum + sqrt(fmax(root, 0.0)));
}

/* `certify` by what remains of the motion: U, D, D^-1, and in *spread the bound behind the joint.
 * Of kappa P'^T Mbar P' what is more than kappa Mbar^a goes there, too. */
MBSRI_OUTLINE bool certify_remains(const mbsri_sweep_run *run, int i, const blocks *c, joint *j,
                                   double *spread)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_rank_rule *rule = &run->tree->rule;
    const double area = run->tree->area, per_area = run->tree->per_area,
                 trace = trace_of(run->tree, 0, c);
    remains r;
    if (!(trace > 0.0) || !find_remains(run, i, c, &r)) return false;
    const double left = area * sum3(r.w * r.w) + sum3(r.v * r.v), D = r.D + b->armature,
                 size = (j->S.flags & MBSRI_TURNS ? area : 0.0) + b->pitch * b->pitch,
                 noise = c->kappa * D + *spread * left + r.own;
    const bool inertia = D > rule->tolerance * (c->kappa * D + *spread * size);
    j->U_L = r.U_L, j->U_p = r.U_p, j->D = D;
    if (!inertia || !mbsri_is_known_by_bound(rule, D, noise, local_size_of_remains(&r, c))) {
        *spread += 2.0 * trace;
        return remains_are_zero(rule, b, &r, left);
    }
    j->Dinv = 1.0 / D;
    const v4 g_L = j->U_L * splat(j->Dinv), g_p = j->U_p * splat(j->Dinv),
             along = splat(along_axis(&j->S, r.o_L, r.o_p, 0.0)), x_L = r.o_L - along * g_L,
             x_p = r.o_p - along * g_p;
    const double gain = square_of(g_L, g_p, per_area), moved = left * gain,
                 transport = square_beside(moved, sum3(r.w * g_L + r.v * g_p));
    *spread = *spread * transport + trace * (1.0 + moved) + r.own * gain +
              c->kappa * (2.0 * sqrt(square_of(x_L, x_p, per_area) * gain) + r.shared * gain);
    return true;
}

/* Rank by the bound; false: it does not tell. Then the bound behind the joint. */
MBSRI_INLINE bool certify(const mbsri_sweep_run *run, int i, blocks *c, joint *j)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweeps *tree = run->tree;
    const mbsri_rank_rule *rule = &tree->rule;
    const double trace = trace_of(tree, j->S.flags, c), slide = j->S.pitch * j->S.pitch,
                 size = (j->S.flags & MBSRI_TURNS ? tree->area : 0.0) + slide;
    double spread = c->spread + trace, transport = 1.0;
    if (b->soft > 0.0) {
        const double own = spread * b->soft;
        c->kappa = own > c->kappa ? own : c->kappa;
        spread = 0.0;
    }
    const double sure = j->D * (1.0 - rule->by_bound * c->kappa);
    /* at least the local size; mostly this tells, too */
    double local = trace * size;
    if (!(sure > MBSRI_NINE_DIGITS * local)) local = local_size(&j->S, c);
    if (mbsri_is_known_by_bound(rule, sure, spread * size, local)) {
        j->Dinv = 1.0 / j->D;
        transport = size * square_of(j->U_L, j->U_p, tree->per_area) * j->Dinv * j->Dinv;
        transport = beside(b->mixes, transport);
    } else if (b->n) {
        const double least = least_noise(&j->S, c);
        if (!is_zero(rule, b, j->D, least, least)) {
            if (!has_remains(run->tree, i, j->S.flags)) return false;
            const blocks copy = *c; /* the carry itself stays in registers */
            joint other = *j;
            if (!certify_remains(run, i, &copy, &other, &spread)) return false;
            *j = other;
            c->spread = spread;
            return true;
        }
    }
    c->spread = spread * transport + trace * (1.0 + transport);
    return true;
}

/* One column S of any direction: the same by the bound, which goes on in kappa and spread. */
typedef struct column {
    v4 S_L, S_p, U_L, U_p, g_L, g_p; /* U = Mbar S, g = U / D */
    double armature, D;
} column;

/* U, D, g; false: the bound does not tell that D is known. soft as that of a body. */
MBSRI_INLINE bool certify_column(const mbsri_sweeps *tree, double soft, const blocks *c, column *j,
                                 double *kappa, double *spread)
{
    const double area = tree->area, per_area = tree->per_area, trace = trace_of(tree, 0, c),
                 turn = sum3(j->S_L * j->S_L), slide = sum3(j->S_p * j->S_p),
                 size = area * turn + slide;
    double reach = *spread + trace;
    if (soft > 0.0) {
        *kappa = fmax(*kappa, reach * soft);
        reach = 0.0;
    }
    times_masses(c, j->S_L, j->S_p, &j->U_L, &j->U_p);
    j->D = sum3(j->S_L * j->U_L + j->S_p * j->U_p) + j->armature;
    const double local = sum3(c->I[0]) * turn + sum3(c->M[0]) * slide;
    if (!mbsri_is_known_by_bound(&tree->rule, j->D, *kappa * j->D + reach * size, local))
        return false;
    j->g_L = j->U_L * splat(1.0 / j->D);
    j->g_p = j->U_p * splat(1.0 / j->D);
    const double transport =
        beside(j->armature > 0.0, size * sum3(j->g_L * j->g_L * splat(per_area) + j->g_p * j->g_p));
    *spread = reach * transport + trace * (1.0 + transport);
    return true;
}

/* Errors W S and S^T W S, and the least that these may be; of S' in the place of S where it stands
 * in. */
typedef struct errors_along {
    v4 Q_L, Q_p;
    double noise, least;
} errors_along;

/* U, D and errors by what remains of the motion, D^-1 if D is known to nine digits. False: it is
 * neither that nor nothing. all: the errors along S. */
MBSRI_OUTLINE bool judge_remains(const mbsri_sweep_run *run, int i, const blocks *c,
                                 const blocks *W, double all, joint *j, errors_along *errors)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_rank_rule *rule = &run->tree->rule;
    remains r;
    if (!has_remains(run->tree, i, j->S.flags) || !find_remains(run, i, c, &r)) return false;
    const double turning = sum3(r.w * r.w), left = run->tree->area * turning + sum3(r.v * r.v),
                 D = r.D + b->armature;
    times_masses(W, r.w, r.v, &errors->Q_L, &errors->Q_p);
    errors->noise = sum3(r.w * errors->Q_L + r.v * errors->Q_p);
    errors->least = least_of_remains(&r, c) + b->armature;
    const double noise = errors->noise + r.own + turning * W->spread;
    if (D > rule->tolerance * all &&
        mbsri_is_known(rule, D, fmax(noise, local_size_of_remains(&r, c))))
        j->Dinv = 1.0 / D;
    else if (!remains_are_zero(rule, b, &r, left))
        return false;
    j->U_L = r.U_L, j->U_p = r.U_p, j->D = D;
    return true;
}

/* Rank by W, and by what turned tensors add to the errors (W->spread), and E = Diag(Mbar) +
 * Diag(G S^T Diag(Mbar) S G^T) + P^T W P, P = 1 - S G^T, in its place (recursion/backward.c).
 * False: D is neither nothing but rounding nor known to nine digits. */
MBSRI_INLINE bool judge(const mbsri_sweep_run *run, int i, const blocks *c, joint *j, blocks *W)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    errors_along e;
    W->I[0] += c->I[0];
    W->M[0] += c->M[0];
    times_axis(&j->S, W, &e.Q_L, &e.Q_p);
    e.noise = along_axis(&j->S, e.Q_L, e.Q_p, 0.0);
    e.least = least_noise(&j->S, c) + b->armature;
    const double all = e.noise + (b->flags & MBSRI_TURNS ? W->spread : 0.0);
    if (mbsri_is_known(&run->tree->rule, j->D, fmax(all, local_size(&j->S, c))))
        j->Dinv = 1.0 / j->D;
    else if (!is_zero(&run->tree->rule, b, j->D, e.noise, e.least) &&
             !judge_remains(run, i, c, W, all, j, &e))
        return false;
    const v4 g_L = j->U_L * splat(j->Dinv), g_p = j->U_p * splat(j->Dinv),
             Q_L = e.Q_L - splat(0.5 * e.noise) * g_L, Q_p = e.Q_p - splat(0.5 * e.noise) * g_p;
    subtract_dyad(Q_L, Q_p, g_L, g_p, W);
    subtract_dyad(g_L, g_p, Q_L, Q_p, W);
    W->I[0] += c->I[0] + splat(e.least) * g_L * g_L;
    W->M[0] += c->M[0] + splat(e.least) * g_p * g_p;
    return true;
}

#endif
