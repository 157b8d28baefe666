/* The sweeps over a tree of rigid bodies, root to leaves and back; compiled by kernels_*.c for
 * different processors.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i: R its axes, Z = R e_z the joint's axis, rho from the predecessor's origin to its own,
 * S = (alpha Z, h Z) with alpha = 1 where the joint turns and h = pitch where it slides. With
 * X = [1 0; -[rho]x 1],
 *
 *   V_i = X V_pi + S u,   A_i = X A_pi + c + S u'
 *   c   = (alpha omega_pi x Z u, omega_pi x (omega_pi x rho) + 2 h omega_pi x Z u)
 *
 * which are (8) and (9) with K = 1, H = -X, J = -S, kII = -c. */
#include "fast.h"
#include "lane.h"
#include "many.h"
#include "sine.h"

#include <math.h>
#include <string.h>

/* ---- sines and cosines of all coordinates ---- */

/* Of `count` of the four numbers x. */
MBSRI_INLINE void store_sine_cosine(v4 x, int count, double *sincos)
{
    v4 s, c;
    sine_cosine(x, &s, &c);
    for (int l = 0; l < count; ++l) {
        const bool far = !(fabs(x[l]) < (double)MBSRI_REDUCED);
        sincos[2 * l] = far ? cos(x[l]) : c[l];
        sincos[2 * l + 1] = far ? sin(x[l]) : s[l];
    }
}

static void trigonometry(int n, const double *q, double *sincos)
{
    int k = 0;
    for (; k + 4 <= n; k += 4)
        store_sine_cosine((v4){q[k], q[k + 1], q[k + 2], q[k + 3]}, 4, sincos + 2 * k);
    const int rest = n - k;
    if (rest == 0) return;
    const v4 x = {q[k], rest > 1 ? q[k + 1] : 0.0, rest > 2 ? q[k + 2] : 0.0, 0.0};
    store_sine_cosine(x, rest, sincos + 2 * k);
}

/* ---- root to leaves: R, rho, omega, c ---- */

MBSRI_INLINE void move_body(const mbsri_fast_run *run, const mbsri_fast_body *b,
                            const mbsri_fast_state *pred, mbsri_fast_state *s, bool velocity)
{
    const v4 P[3] = {load(pred->R), load(pred->R + 4), load(pred->R + 8)};
    const v4 omega_pred = load(pred->omega);
    v4 B[3];
    for (int j = 0; j < 3; ++j) B[j] = times_stored(P, b->A + 4 * j);
    const v4 Z = B[2];
    v4 rho = times_stored(P, b->x), omega = omega_pred, c_w = splat(0.0), c_v = splat(0.0);
    v4 slide = splat(0.0);
    if (b->flags & (MBSRI_TURNS | MBSRI_SLIDES)) {
        const v4 u = splat(run->u[b->u]), turning = cross(omega_pred, Z) * u;
        if (b->flags & MBSRI_SLIDES) {
            rho += Z * splat(b->pitch * run->q[b->q]);
            c_v = splat(2.0 * b->pitch) * turning;
            slide = Z * splat(b->pitch) * u;
        }
        if (b->flags & MBSRI_TURNS) {
            const v4 cosine = splat(run->sincos[2 * b->q]), sine = splat(run->sincos[2 * b->q + 1]);
            const v4 x = B[0] * cosine + B[1] * sine, y = B[1] * cosine - B[0] * sine;
            B[0] = x;
            B[1] = y;
            omega += Z * u;
            c_w = turning;
        }
    }
    const v4 swing = cross(omega_pred, rho);
    if (velocity) store(s->v, load(pred->v) + swing + slide);
    c_v += cross(omega_pred, swing);
    for (int j = 0; j < 3; ++j) store(s->R + 4 * j, B[j]);
    store(s->rho, rho);
    store(s->omega, omega);
    store(s->A_w, c_w);
    store(s->A_v, c_v);
}

MBSRI_INLINE int move(const mbsri_fast_run *run, bool velocity)
{
    mbsri_fast_state *s = run->state;
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_fast_body *b = run->tree->body + i;
        if (b->flags & MBSRI_MANY) {
            const int status = many_kinematics(run, i, velocity);
            if (status) return status;
        } else {
            move_body(run, b, s + b->parent, s + i, velocity);
        }
    }
    return 0;
}

static int kinematics(const mbsri_fast_run *run)
{
    return move(run, false);
}

static int velocities(const mbsri_fast_run *run)
{
    return move(run, true);
}

/* ---- leaves to root: Mbar, D, e ---- */

/* The carry in registers. */
typedef struct blocks {
    v4 I[3], G[3], M[3], L, p;
    double kappa, spread;
} blocks;

MBSRI_INLINE void to_memory(const blocks *c, mbsri_carry *m)
{
    for (int j = 0; j < 3; ++j) {
        store(m->I + 4 * j, c->I[j]);
        store(m->G + 4 * j, c->G[j]);
        store(m->M + 4 * j, c->M[j]);
    }
    store(m->L, c->L);
    store(m->p, c->p);
    m->kappa = c->kappa;
    m->spread = c->spread;
}

MBSRI_INLINE void from_memory(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 3; ++j) {
        c->I[j] = load(m->I + 4 * j);
        c->G[j] = load(m->G + 4 * j);
        c->M[j] = load(m->M + 4 * j);
    }
    c->L = load(m->L);
    c->p = load(m->p);
    c->kappa = m->kappa;
    c->spread = m->spread;
}

/* c += what other successors left. */
MBSRI_INLINE void add(const mbsri_carry *m, blocks *c)
{
    for (int j = 0; j < 3; ++j) {
        c->I[j] += load(m->I + 4 * j);
        c->G[j] += load(m->G + 4 * j);
        c->M[j] += load(m->M + 4 * j);
    }
    c->L += load(m->L);
    c->p += load(m->p);
    c->kappa = m->kappa > c->kappa ? m->kappa : c->kappa;
    c->spread += m->spread;
}

MBSRI_INLINE void clear(blocks *c)
{
    const v4 none = splat(0.0);
    for (int j = 0; j < 3; ++j) c->I[j] = c->G[j] = c->M[j] = none;
    c->L = c->p = none;
    c->kappa = c->spread = 0.0;
}

/* Own inertia, turned into the world, and its gyroscopic force. */
MBSRI_INLINE void add_own(const mbsri_fast_body *b, const mbsri_fast_state *s, blocks *c)
{
    const v4 ex = {1.0, 0.0, 0.0, 0.0}, ey = {0.0, 1.0, 0.0, 0.0}, ez = {0.0, 0.0, 1.0, 0.0};
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)}, omega = load(s->omega);
    v4 RI[3], I[3];
    for (int j = 0; j < 3; ++j) RI[j] = times_stored(R, b->I + 4 * j);
    for (int j = 0; j < 3; ++j)
        I[j] = RI[0] * splat(s->R[j]) + RI[1] * splat(s->R[4 + j]) + RI[2] * splat(s->R[8 + j]);
    const v4 h = times_stored(R, b->c), mass = splat(b->c[3]);
    c->L += cross(omega, times(I, omega));
    c->p += cross(omega, cross(omega, h));
    for (int j = 0; j < 3; ++j) c->I[j] += I[j];
    /* G = -[h]x */
    c->G[0] += yyy(h) * ez - zzz(h) * ey;
    c->G[1] += zzz(h) * ex - xxx(h) * ez;
    c->G[2] += xxx(h) * ey - yyy(h) * ex;
    c->M[0] += mass * ex;
    c->M[1] += mass * ey;
    c->M[2] += mass * ez;
}

/* From body i's origin to its predecessor's: Mbar <- X^T Mbar X, p <- X^T p. */
MBSRI_INLINE void translate(v4 rho, blocks *c)
{
    const v4 x = xxx(rho), y = yyy(rho), z = zzz(rho), half = splat(0.5);
    /* M [rho]x */
    const v4 Mr[3] = {c->M[1] * z - c->M[2] * y, c->M[2] * x - c->M[0] * z,
                      c->M[0] * y - c->M[1] * x};
    v4 Y[3], T[3];
    for (int j = 0; j < 3; ++j) {
        Y[j] = cross(rho, c->G[j] - half * Mr[j]);
        c->G[j] -= Mr[j];
    }
    transpose(Y, T);
    for (int j = 0; j < 3; ++j) c->I[j] += Y[j] + T[j];
    c->L += cross(rho, c->p);
}

/* ---- the rank of D ----
 * What rank.c decides with W, the first-order size of the rounding errors in Mbar. Mostly a bound
 * is enough, two numbers instead of a matrix: W <= kappa Mbar + spread Lambda with Lambda =
 * diag(L^2, L^2, L^2, 1, 1, 1); docs/performance.md derives it. Where it is not, the sweep starts
 * again with W itself, kept in blocks like Mbar. */

/* A joint of one axis, or none: U = Mbar S, D = S^T U, e = tau - S^T p, size = S^T Lambda S. */
typedef struct joint {
    v4 Z, U_L, U_p;
    double D, e, size;
    double Dinv; /* 0 where the rank is 0 */
} joint;

MBSRI_INLINE double trace_of(const blocks *c, double per_area)
{
    return (c->I[0][0] + c->I[1][1] + c->I[2][2]) * per_area +
           (c->M[0][0] + c->M[1][1] + c->M[2][2]);
}

MBSRI_INLINE v4 diagonal(const v4 A[3])
{
    return (v4){A[0][0], A[1][1], A[2][2], 0.0};
}

MBSRI_INLINE void add_diagonal(v4 x, v4 A[3])
{
    A[0] += x * (v4){1.0, 0.0, 0.0, 0.0};
    A[1] += x * (v4){0.0, 1.0, 0.0, 0.0};
    A[2] += x * (v4){0.0, 0.0, 1.0, 0.0};
}

/* S^T Diag(Mbar) S, which S^T W S is at least. */
MBSRI_INLINE double least_noise(const mbsri_fast_body *b, const blocks *c, v4 Z)
{
    double least = 0.0;
    if (b->flags & MBSRI_TURNS) least = sum3(Z * Z * diagonal(c->I));
    if (b->flags & MBSRI_SLIDES) least += b->pitch * b->pitch * sum3(Z * Z * diagonal(c->M));
    return least;
}

/* (x_L, x_p) = A S for symmetric blocks A. */
MBSRI_INLINE void times_axis(const mbsri_fast_body *b, const blocks *A, v4 Z, v4 *x_L, v4 *x_p)
{
    *x_L = *x_p = splat(0.0);
    if (b->flags & MBSRI_TURNS) {
        *x_L = times(A->I, Z);
        *x_p = times(A->G, Z);
    }
    if (b->flags & MBSRI_SLIDES) {
        const v4 h = splat(b->pitch);
        *x_L += h * transposed_times(A->G, Z);
        *x_p += h * times(A->M, Z);
    }
}

/* S^T x */
MBSRI_INLINE double along_axis(const mbsri_fast_body *b, v4 Z, v4 x_L, v4 x_p)
{
    double sum = 0.0;
    if (b->flags & MBSRI_TURNS) sum = sum3(Z * x_L);
    if (b->flags & MBSRI_SLIDES) sum += b->pitch * sum3(Z * x_p);
    return sum;
}

MBSRI_INLINE void open_joint(const mbsri_fast_run *run, int i, const blocks *c, joint *j)
{
    const mbsri_fast_body *b = run->tree->body + i;
    j->Z = load(run->state[i].R + 8);
    times_axis(b, c, j->Z, &j->U_L, &j->U_p);
    j->D = along_axis(b, j->Z, j->U_L, j->U_p);
    j->e = (b->n ? run->tau[b->u] : 0.0) - along_axis(b, j->Z, c->L, c->p);
    j->Dinv = 0.0;
}

/* Rank by the bound; false: it does not tell. Then the bound behind the joint. */
MBSRI_INLINE bool certify(const mbsri_fast_run *run, int i, blocks *c, joint *j)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const double area = run->tree->length * run->tree->length, per_area = 1.0 / area,
                 clear = run->tree->clear, trace = trace_of(c, per_area);
    const double size = (b->flags & MBSRI_TURNS ? area : 0.0) + b->pitch * b->pitch;
    double spread = c->spread + trace, transport = 1.0;
    if (b->soft > 0.0) {
        const double own = spread * b->soft;
        c->kappa = own > c->kappa ? own : c->kappa;
        spread = 0.0;
    }
    if (j->D > 0.0 && j->D * (1.0 - clear * c->kappa) > clear * spread * size) {
        j->Dinv = 1.0 / j->D;
        transport =
            size * sum3(j->U_L * j->U_L * splat(per_area) + j->U_p * j->U_p) * j->Dinv * j->Dinv;
    } else if (b->n && fabs(j->D) > run->model->rank_tolerance * least_noise(b, c, j->Z)) {
        return false;
    }
    c->spread = spread * transport + trace * (1.0 + transport);
    return true;
}

/* Rank by W, and E = Diag(Mbar) + Diag(G S^T Diag(Mbar) S G^T) + P^T W P, P = 1 - S G^T, in its
 * place (backward.c). False: Mbar is indefinite. */
MBSRI_INLINE bool judge(const mbsri_fast_run *run, int i, const blocks *c, joint *j, blocks *W)
{
    const mbsri_fast_body *b = run->tree->body + i;
    v4 Q_L, Q_p;
    add_diagonal(diagonal(c->I), W->I);
    add_diagonal(diagonal(c->M), W->M);
    times_axis(b, W, j->Z, &Q_L, &Q_p);
    const double noise = along_axis(b, j->Z, Q_L, Q_p), least = least_noise(b, c, j->Z),
                 tolerance = run->model->rank_tolerance * noise;
    if (j->D < -tolerance) return false;
    if (j->D > tolerance) j->Dinv = 1.0 / j->D;
    const v4 g_L = j->U_L * splat(j->Dinv), g_p = j->U_p * splat(j->Dinv);
    Q_L -= splat(0.5 * noise) * g_L;
    Q_p -= splat(0.5 * noise) * g_p;
    const v4 gL[3] = {xxx(g_L), yyy(g_L), zzz(g_L)}, gp[3] = {xxx(g_p), yyy(g_p), zzz(g_p)},
             QL[3] = {xxx(Q_L), yyy(Q_L), zzz(Q_L)}, Qp[3] = {xxx(Q_p), yyy(Q_p), zzz(Q_p)};
    for (int k = 0; k < 3; ++k) {
        W->I[k] -= Q_L * gL[k] + g_L * QL[k];
        W->G[k] -= Q_p * gL[k] + g_p * QL[k];
        W->M[k] -= Q_p * gp[k] + g_p * Qp[k];
    }
    add_diagonal(diagonal(c->I) + splat(least) * g_L * g_L, W->I);
    add_diagonal(diagonal(c->M) + splat(least) * g_p * g_p, W->M);
    return true;
}

/* Mbar^a = Mbar - U D^-1 U^T,  p += Mbar^a c + U D^-1 e, at body i's origin. */
MBSRI_INLINE void condense(const mbsri_fast_run *run, int i, const joint *j, blocks *c)
{
    mbsri_fast_state *s = run->state + i;
    const v4 c_w = load(s->A_w), c_v = load(s->A_v), U_L = j->U_L, U_p = j->U_p;
    run->rank[i] = j->Dinv > 0.0;
    store(s->U_L, U_L);
    store(s->U_p, U_p);
    s->D = j->D;
    s->Dinv = j->Dinv;
    s->e = j->e;
    const v4 g_L = U_L * splat(j->Dinv), g_p = U_p * splat(j->Dinv), e = splat(j->e);
    c->I[0] -= g_L * xxx(U_L), c->I[1] -= g_L * yyy(U_L), c->I[2] -= g_L * zzz(U_L);
    c->G[0] -= g_p * xxx(U_L), c->G[1] -= g_p * yyy(U_L), c->G[2] -= g_p * zzz(U_L);
    c->M[0] -= g_p * xxx(U_p), c->M[1] -= g_p * yyy(U_p), c->M[2] -= g_p * zzz(U_p);
    c->L += times(c->I, c_w) + transposed_times(c->G, c_v) + g_L * e;
    c->p += times(c->G, c_w) + times(c->M, c_v) + g_p * e;
}

/* ||X||^2 <= (1 + |rho| / L)^2, a constant unless the joint slides. */
MBSRI_INLINE double stretch(const mbsri_fast_run *run, int i)
{
    const mbsri_fast_body *b = run->tree->body + i;
    if (!(b->flags & (MBSRI_SLIDES | MBSRI_MANY))) return b->spread;
    const v4 rho = load(run->state[i].rho);
    const double ratio = 1.0 + sqrt(sum3(rho * rho)) / run->tree->length;
    return ratio * ratio;
}

/* Through the joint of body i, of whatever kind; W: NULL without it. */
MBSRI_INLINE bool pass_joint(const mbsri_fast_run *run, int i, blocks *c, blocks *W)
{
    if (run->tree->body[i].flags & MBSRI_MANY) {
        _Alignas(32) mbsri_carry m, noise;
        to_memory(c, &m);
        if (W) to_memory(W, &noise);
        if (!many_backward(run, i, &m, W ? &noise : NULL)) return false;
        from_memory(&m, c);
        if (W) from_memory(&noise, W);
        return true;
    }
    joint j;
    open_joint(run, i, c, &j);
    const bool clear = W ? judge(run, i, c, &j, W) : certify(run, i, c, &j);
    if (clear) condense(run, i, &j, c);
    return clear;
}

/* Where the sweep stands: the carry, W beside it, and the places where they wait at branches. */
typedef struct back {
    blocks c, W;
    mbsri_carry *top, *noise_top;
} back;

MBSRI_INLINE void start_back(const mbsri_fast_run *run, back *at)
{
    clear(&at->c);
    clear(&at->W);
    at->top = run->stack;
    at->noise_top = run->noise;
}

/* Past body i; false: its rank is not clear. */
MBSRI_INLINE bool pass_body(const mbsri_fast_run *run, int i, bool exact, back *at)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const int flags = b->flags;
    blocks *c = &at->c, *W = &at->W;
    if (flags & MBSRI_LEAF) clear(c);
    if (exact && flags & MBSRI_LEAF) clear(W);
    if (flags & MBSRI_BRANCHES) add(--at->top, c);
    if (exact && flags & MBSRI_BRANCHES) add(--at->noise_top, W);
    if (!(flags & MBSRI_MASSLESS)) add_own(b, run->state + i, c);
    if (flags & MBSRI_LOADED) {
        c->L -= load(run->load[i].L);
        c->p -= load(run->load[i].p);
    }
    if (!pass_joint(run, i, c, exact ? W : NULL)) return false;
    const v4 rho = load(run->state[i].rho);
    translate(rho, c);
    if (exact)
        translate(rho, W);
    else
        c->spread *= stretch(run, i);
    if (flags & MBSRI_NEXT) return true;
    const bool opens = (flags & MBSRI_OPENS) != 0;
    if (!opens) add(--at->top, c);
    to_memory(c, at->top++);
    if (!exact) return true;
    if (!opens) add(--at->noise_top, W);
    to_memory(W, at->noise_top++);
    return true;
}

MBSRI_INLINE bool sweep_back(const mbsri_fast_run *run, bool exact)
{
    back at;
    start_back(run, &at);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (!pass_body(run, i, exact, &at)) return false;
    }
    return true;
}

MBSRI_OUTLINE bool backward(const mbsri_fast_run *run)
{
    return sweep_back(run, false) || sweep_back(run, true);
}

/* ---- root to leaves: A, u' ---- */

/* What u' needs of A_pi comes first, so that the next body waits for little:
 * u' = D^-1 (e - U^T c) - D^-1 (X^T U)^T A_pi. */
static void forward(const mbsri_fast_run *run)
{
    v4 last_w = load(run->state->A_w), last_v = load(run->state->A_v);
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_fast_body *b = run->tree->body + i;
        const mbsri_fast_state *pred = run->state + b->parent;
        mbsri_fast_state *s = run->state + i;
        const bool next = b->parent == i - 1;
        const v4 w = next ? last_w : load(pred->A_w), v = next ? last_v : load(pred->A_v);
        const v4 rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v);
        last_w = w + c_w;
        last_v = v + cross(w, rho) + c_v;
        if (b->flags & MBSRI_MANY) {
            store(s->A_w, last_w);
            store(s->A_v, last_v);
            many_forward(run, i);
            last_w = load(s->A_w);
            last_v = load(s->A_v);
            continue;
        }
        const v4 Z = load(s->R + 8), U_L = load(s->U_L), U_p = load(s->U_p), Dinv = splat(s->Dinv);
        const double known = (s->e - sum3(U_L * c_w + U_p * c_v)) * s->Dinv;
        const v4 g_L = (U_L + cross(rho, U_p)) * Dinv, g_p = U_p * Dinv;
        const double udot = known - sum3(g_L * w + g_p * v);
        if (b->n) run->out[b->u] = udot;
        if (b->flags & MBSRI_TURNS) last_w += Z * splat(udot);
        if (b->flags & MBSRI_SLIDES) last_v += Z * splat(b->pitch * udot);
        store(s->A_w, last_w);
        store(s->A_v, last_v);
    }
}

/* ---- inverse dynamics: A root to leaves with the force that it takes, S^T of the sums back ----
 * */

/* (L, p) = M A + gyroscopic force. */
MBSRI_INLINE void own_load(const mbsri_fast_body *b, const mbsri_fast_state *s, v4 A_w, v4 A_v,
                           v4 *L, v4 *p)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)};
    const v4 omega = load(s->omega), h = times_stored(R, b->c);
    const v4 w = transposed_times(R, omega), a = transposed_times(R, A_w);
    const v4 in_body = times(I, a) + cross(w, times(I, w));
    *L = times(R, in_body) + cross(h, A_v);
    *p = splat(b->c[3]) * A_v + cross(A_w, h) + cross(omega, cross(omega, h));
}

MBSRI_INLINE void accelerate(const mbsri_fast_run *run, int i)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *pred = run->state + b->parent;
    mbsri_fast_state *s = run->state + i;
    const v4 w = load(pred->A_w);
    v4 A_w = w + load(s->A_w), A_v = load(pred->A_v) + cross(w, load(s->rho)) + load(s->A_v);
    if (b->flags & MBSRI_MANY) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->many[b->many].S[k];
            const v4 udot = splat(run->tau[b->u + k]);
            A_w += load(S) * udot;
            A_v += load(S + 4) * udot;
        }
    } else if (b->n) {
        const v4 Z = load(s->R + 8);
        const double udot = run->tau[b->u];
        if (b->flags & MBSRI_TURNS) A_w += Z * splat(udot);
        if (b->flags & MBSRI_SLIDES) A_v += Z * splat(b->pitch * udot);
    }
    store(s->A_w, A_w);
    store(s->A_v, A_v);
    /* in the place of U */
    v4 L = splat(0.0), p = splat(0.0);
    if (!(b->flags & MBSRI_MASSLESS)) own_load(b, s, A_w, A_v, &L, &p);
    if (b->flags & MBSRI_LOADED) {
        L -= load(run->load[i].L);
        p -= load(run->load[i].p);
    }
    store(s->U_L, L);
    store(s->U_p, p);
}

/* The sums to the leaves stay in registers or, at branches, on the stack of the momentum form. */
MBSRI_INLINE void sum_loads(const mbsri_fast_run *run)
{
    const mbsri_fast *tree = run->tree;
    mbsri_flow *top = run->flows;
    v4 L = splat(0.0), p = splat(0.0);
    for (int i = tree->bodies; i >= 1; --i) {
        const mbsri_fast_body *b = tree->body + i;
        const mbsri_fast_state *s = run->state + i;
        const int flags = b->flags;
        if (flags & MBSRI_LEAF) L = p = splat(0.0);
        if (flags & MBSRI_BRANCHES) --top, L += load(top->L), p += load(top->p);
        L += load(s->U_L);
        p += load(s->U_p);
        if (flags & MBSRI_MANY) {
            for (int k = 0; k < b->n; ++k) {
                const double *S = run->many[b->many].S[k];
                run->out[b->u + k] = sum3(load(S) * L + load(S + 4) * p);
            }
        } else if (b->n) {
            run->out[b->u] = along_axis(b, load(s->R + 8), L, p);
        }
        L += cross(load(s->rho), p);
        if (flags & MBSRI_NEXT) continue;
        if (!(flags & MBSRI_OPENS)) --top, L += load(top->L), p += load(top->p);
        store(top->L, L);
        store(top->p, p);
        ++top;
    }
}

static int inverse(const mbsri_fast_run *run)
{
    const mbsri_fast *tree = run->tree;
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsri_fast_body *b = tree->body + i;
        if (run->load) {
            accelerate(run, i); /* the kinematics came before the loads */
            continue;
        }
        if (b->flags & MBSRI_MANY) {
            const int status = many_kinematics(run, i, false);
            if (status) return status;
        } else {
            move_body(run, b, run->state + b->parent, run->state + i, false);
        }
        accelerate(run, i);
    }
    sum_loads(run);
    return 0;
}

/* ---- momentum form ----
 * With subtree sums (L, p) of momentum about body i's origin and (N, F) of the external wrench,
 *
 *   p_i' = S^T (N - v x p, F) + S'^T (L, p) + tau,   S' = (alpha omega_pi x Z, h omega_pi x Z)
 *   0    = D u - ep + U^T X V_pi,   ep = p_i - S^T (L_bar, p_bar)
 *
 * or, where D = 0, the balance of forces 0 = -e. (v x p comes from the motion of the origin.) */

typedef struct flow {
    v4 L, p, N, F, L_bar, p_bar;
} flow;

MBSRI_INLINE void flow_to_memory(const flow *f, mbsri_flow *m)
{
    store(m->L, f->L), store(m->p, f->p);
    store(m->N, f->N), store(m->F, f->F);
    store(m->L_bar, f->L_bar), store(m->p_bar, f->p_bar);
}

MBSRI_INLINE void add_flow(const mbsri_flow *m, flow *f)
{
    f->L += load(m->L), f->p += load(m->p);
    f->N += load(m->N), f->F += load(m->F);
    f->L_bar += load(m->L_bar), f->p_bar += load(m->p_bar);
}

MBSRI_INLINE void add_own_flow(const mbsri_fast_body *b, const mbsri_fast_state *s, v4 g, flow *f)
{
    const v4 R[3] = {load(s->R), load(s->R + 4), load(s->R + 8)},
             I[3] = {load(b->I), load(b->I + 4), load(b->I + 8)};
    const v4 omega = load(s->omega), v = load(s->v), h = times_stored(R, b->c),
             mass = splat(b->c[3]);
    f->L += times(R, times(I, transposed_times(R, omega))) + cross(h, v);
    f->p += mass * v + cross(omega, h);
    f->N += cross(h, g);
    f->F += mass * g;
}

/* p' and ep of a joint of one axis; (L_bar, p_bar) += U D^-1 ep. */
MBSRI_INLINE void flow_through(const mbsri_fast_run *run, int i, flow *f)
{
    const mbsri_fast_body *b = run->tree->body + i;
    const mbsri_fast_state *pred = run->state + b->parent;
    mbsri_fast_state *s = run->state + i;
    const v4 Z = load(s->R + 8), rate = cross(load(pred->omega), Z);
    if (!b->n) return;
    double pdot = run->tau[b->u], ep = run->p[b->u];
    if (b->flags & MBSRI_TURNS) {
        pdot += sum3(Z * (f->N - cross(load(s->v), f->p)) + rate * f->L);
        ep -= sum3(Z * f->L_bar);
    }
    if (b->flags & MBSRI_SLIDES) {
        pdot += b->pitch * sum3(Z * f->F + rate * f->p);
        ep -= b->pitch * sum3(Z * f->p_bar);
    }
    run->out[b->u] = pdot;
    s->ep = ep;
    const v4 share = splat(s->Dinv * ep);
    f->L_bar += load(s->U_L) * share;
    f->p_bar += load(s->U_p) * share;
}

static void balance(const mbsri_fast_run *run)
{
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_fast_body *b = run->tree->body + i;
        const mbsri_fast_state *s = run->state + i, *pred = run->state + b->parent;
        const v4 omega = load(pred->omega), v = load(pred->v) + cross(omega, load(s->rho));
        if (b->flags & MBSRI_MANY) {
            _Alignas(32) double V[8];
            store(V, omega);
            store(V + 4, v);
            many_balance(run, i, V);
        } else if (b->n) {
            const double r =
                s->D * run->u[b->u] - s->ep + sum3(load(s->U_L) * omega + load(s->U_p) * v);
            run->balance[b->u] = s->Dinv > 0.0 ? r : -s->e;
        }
    }
}

static void momentum(const mbsri_fast_run *run)
{
    const mbsri_fast *tree = run->tree;
    mbsri_flow *top = run->flows;
    const v4 none = splat(0.0), g = {tree->gravity[0], tree->gravity[1], tree->gravity[2], 0.0};
    flow f = {none, none, none, none, none, none};
    for (int i = tree->bodies; i >= 1; --i) {
        const mbsri_fast_body *b = tree->body + i;
        const mbsri_fast_state *s = run->state + i;
        const int flags = b->flags;
        if (flags & MBSRI_LEAF) f = (flow){none, none, none, none, none, none};
        if (flags & MBSRI_BRANCHES) add_flow(--top, &f);
        if (!(flags & MBSRI_MASSLESS)) add_own_flow(b, s, g, &f);
        if (flags & MBSRI_LOADED) {
            f.N += load(run->load[i].L);
            f.F += load(run->load[i].p);
        }
        if (flags & MBSRI_MANY) {
            _Alignas(32) mbsri_flow m;
            flow_to_memory(&f, &m);
            many_momentum(run, i, &m);
            f.L_bar = load(m.L_bar);
            f.p_bar = load(m.p_bar);
        } else {
            flow_through(run, i, &f);
        }
        const v4 rho = load(s->rho);
        f.L += cross(rho, f.p);
        f.N += cross(rho, f.F);
        f.L_bar += cross(rho, f.p_bar);
        if (flags & MBSRI_NEXT) continue;
        if (!(flags & MBSRI_OPENS)) add_flow(--top, &f);
        flow_to_memory(&f, top++);
    }
    balance(run);
}
