/* Forward dynamics with loops by the vectorised sweeps: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_OPEN_LOOPS_H
#define MBSRI_SWEEPS_OPEN_LOOPS_H

#include "sweeps/backward.h"
#include "sweeps/forward.h"
#include "sweeps/loops.h"

/* ---- leaves to root ---- */

MBSRI_INLINE v4 size_of_each(v4 x)
{
    const long long most = 0x7fffffffffffffff;
    const i4 mask = {most, most, most, most};
    return (v4)((i4)x & mask);
}

/* |a| x |b| with sums only. */
MBSRI_INLINE v4 cross_sizes(v4 a, v4 b)
{
    return yzx(a) * zxy(b) + zxy(a) * yzx(b);
}

/* X^T of unknown k, about the predecessor's point. */
MBSRI_INLINE void move_unknown(const mbsri_open *open, int k, v4 rho, v4 Q_L, v4 Q_p, v4 size_L,
                               v4 size_p)
{
    store3(open->Q + 8 * k, Q_L + cross(rho, Q_p));
    store3(open->Q + 8 * k + 4, Q_p);
    store3(open->lengths + 8 * k, size_L + cross_sizes(size_of_each(rho), size_p));
    store3(open->lengths + 8 * k + 4, size_p);
}

/* X = S^T Q for all unknowns, and what was added up in it, `stride` apart. */
MBSRI_INLINE void project(const mbsri_open *open, v4 S_L, v4 S_p, int stride, double *X,
                          double *sizes)
{
    const v4 L = size_of_each(S_L), p = size_of_each(S_p);
    for (int k = 0; k < open->count; ++k) {
        const double *Q = open->Q + 8 * k, *lengths = open->lengths + 8 * k;
        X[k * stride] = sum3(S_L * load3(Q) + S_p * load3(Q + 4));
        sizes[k * stride] = sum3(L * load3(lengths) + p * load3(lengths + 4));
    }
}

/* What is rounding is none. */
MBSRI_INLINE void clear_rounding(int count, const double *sizes, double *X)
{
    for (int k = 0; k < count; ++k) {
        if (fabs(X[k]) <= MBSRI_PIVOTS_ROUNDING * sizes[k]) X[k] = 0.0;
    }
}

/* Whether one of the unknowns pushes along an axis: X of it, `stride` apart. */
MBSRI_INLINE bool is_held(int count, int stride, const double *X)
{
    bool held = false;
    for (int k = 0; k < count; ++k) held = held || X[stride * k] != 0.0;
    return held;
}

/* A rate (its place in u) without inertia: w, and X v = -e. False: more such motions are open than
 * rows. */
MBSRI_OUTLINE bool carry_motion(mbsri_loop_run *w, int rate, double e, int count, int stride,
                                const double *X)
{
    const int rows = w->run->model->rows, own = rows + rate;
    const mbsri_open open = mbsri_open_loops_append(w, own);
    const int last = open.count - 1;
    int motions = 0;
    for (int k = 0; k < count; ++k) {
        const double entry = X[stride * k];
        open.F[k * open.count + last] = open.F[last * open.count + k] = entry;
        open.sizes[k * open.count + last] = open.sizes[last * open.count + k] = fabs(entry);
    }
    for (int k = 0; k <= last; ++k) motions += open.id[k] >= rows;
    w->s[own] = -e;
    w->v[own] = 0.0;
    return 2 * motions <= open.count;
}

/* Unknowns past a joint of one axis or none. */
MBSRI_OUTLINE bool carry_axis(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const mbsri_open open = mbsri_open_at(w->part + w->parts - 1);
    const int count = open.count;
    const size_t n = (size_t)count;
    double *X = mbsri_open_loops_keep(w, i, n * sizeof *X + (n + 1) * sizeof(int)), *sizes = w->top;
    mbsri_open_record *kept = w->last;
    int *id = (int *)(void *)(X + n);
    const v4 Z = load(s->R + 8), rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v),
             U_L = load(s->U_L), U_p = load(s->U_p);
    const v4 none = splat(0.0);
    project(&open, b->flags & MBSRI_TURNS ? Z : none, splat(b->pitch) * Z, 1, X, sizes);
    if (w->loops->joints) mbsri_open_loops_read_joint(w, i, &open, X, sizes);
    clear_rounding(count, sizes, X);
    const double Dinv = s->Dinv;
    for (int k = 0; k < count; ++k) {
        const v4 z = splat(X[k] * Dinv), size = size_of_each(z);
        double *Q = open.Q + 8 * k, *lengths = open.lengths + 8 * k;
        const v4 Q_L = load3(Q), Q_p = load3(Q + 4);
        id[k] = open.id[k];
        w->s[id[k]] -= sum3(Q_L * c_w + Q_p * c_v) + z[0] * s->e;
        move_unknown(&open, k, rho, Q_L - U_L * z, Q_p - U_p * z,
                     load3(lengths) + size_of_each(U_L) * size,
                     load3(lengths + 4) + size_of_each(U_p) * size);
        for (int l = 0; l < count; ++l) {
            const double part = z[0] * X[l];
            open.F[k * count + l] += part;
            open.sizes[k * count + l] += fabs(part);
        }
    }
    kept->count = count;
    if (b->n == 0 || Dinv > 0.0) return true;
    kept->nulls = 1;
    id[count] = run->model->rows + b->u;
    return is_held(count, 1, X) && carry_motion(w, b->u, s->e, count, 1, X);
}

/* Past one of several without inertia: its rates are unknowns more, the others pass as they are. */
MBSRI_OUTLINE bool carry_empty(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const mbsri_sweep_multi *multi = run->multi + b->multi;
    mbsri_open open = mbsri_open_at(w->part + w->parts - 1);
    const int count = open.count, n = b->n;
    const v4 rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v);
    (void)mbsri_open_loops_keep(w, i, 0);
    w->last->nulls = n;
    double *X = w->store, *sizes = w->top; /* neither is kept */
    for (int j = 0; j < n; ++j)
        project(&open, load(multi->S[j]), load(multi->S[j] + 4), n, X + j, sizes + j);
    if (w->loops->joints) mbsri_open_loops_read_joint(w, i, &open, X, sizes);
    clear_rounding(n * count, sizes, X);
    for (int k = 0; k < count; ++k) {
        const double *Q = open.Q + 8 * k, *lengths = open.lengths + 8 * k;
        const v4 Q_L = load3(Q), Q_p = load3(Q + 4);
        w->s[open.id[k]] -= sum3(Q_L * c_w + Q_p * c_v);
        move_unknown(&open, k, rho, Q_L, Q_p, load3(lengths), load3(lengths + 4));
    }
    for (int j = 0; j < n; ++j) {
        if (!is_held(count, n, X + j)) return false;
        if (!carry_motion(w, b->u + j, multi->e[j], count, n, X + j)) return false;
    }
    return true;
}

/* Past one of several. */
MBSRI_OUTLINE bool carry_axes(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const mbsri_open open = mbsri_open_at(w->part + w->parts - 1);
    const int count = open.count, n = b->n;
    const bool on_root = b->parent == 0;
    const size_t numbers = (size_t)count * (size_t)n;
    double *kept =
               mbsri_open_loops_keep(w, i, numbers * sizeof *kept + (size_t)count * sizeof(int)),
           *X = w->top, *sizes = X + numbers, given[6];
    int *id = (int *)(void *)(kept + numbers);
    const v4 rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v);
    for (int j = 0; j < n; ++j)
        project(&open, load(multi->S[j]), load(multi->S[j] + 4), n, X + j, sizes + j);
    if (w->loops->joints) mbsri_open_loops_read_joint(w, i, &open, X, sizes);
    clear_rounding(n * count, sizes, X);
    /* D^-1 (e - U^T c) */
    for (int j = 0; j < n; ++j)
        given[j] = multi->x[j] - sum3(load(on_root ? multi->U[j] : multi->G[j]) * c_w +
                                      load((on_root ? multi->U[j] : multi->G[j]) + 4) * c_v);
    if (on_root) mbsri_solve_joint(n, multi->factor, given);
    for (int k = 0; k < count; ++k) {
        double z[6], *Q = open.Q + 8 * k, *lengths = open.lengths + 8 * k;
        v4 Q_L = load3(Q), Q_p = load3(Q + 4), size_L = load3(lengths), size_p = load3(lengths + 4);
        memcpy(z, X + n * k, (size_t)n * sizeof *z);
        mbsri_solve_joint(n, multi->factor, z);
        id[k] = open.id[k];
        double *right = w->s + id[k];
        *right -= sum3(Q_L * c_w + Q_p * c_v);
        for (int j = 0; j < n; ++j) {
            const v4 by = splat(z[j]), size = size_of_each(by), U_L = load(multi->U[j]),
                     U_p = load(multi->U[j] + 4);
            *right -= X[n * k + j] * given[j];
            Q_L -= U_L * by, Q_p -= U_p * by;
            size_L += size_of_each(U_L) * size, size_p += size_of_each(U_p) * size;
        }
        move_unknown(&open, k, rho, Q_L, Q_p, size_L, size_p);
        for (int l = 0; l < count; ++l) {
            for (int j = 0; j < n; ++j) {
                const double part = z[j] * X[n * l + j];
                open.F[k * count + l] += part;
                open.sizes[k * count + l] += fabs(part);
            }
        }
        memcpy(kept + n * k, on_root ? X + n * k : z, (size_t)n * sizeof *z);
    }
    w->last->count = count;
    return true;
}

/* What is open at body i past its joint, to its predecessor; false: more is than the plan has, or
 * nothing holds the joint. */
MBSRI_INLINE bool carry_on(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_body *b = w->run->tree->body + i;
    if (w->parts == 0 || w->part[w->parts - 1].body != i) return w->run->rank[i] == b->n;
    if (!(b->flags & MBSRI_FRONT)) return false;
    const bool empty = b->n > 0 && w->run->rank[i] == 0;
    const bool carried = !(b->flags & MBSRI_MULTI) ? carry_axis(w, i)
                         : empty                   ? carry_empty(w, i)
                                                   : carry_axes(w, i);
    if (!carried) return false;
    w->part[w->parts - 1].body = b->parent;
    return true;
}

/* What closing loops add to the body's inertia and force, and to the errors. */
MBSRI_OUTLINE void add_closed(const mbsri_loop_run *w, bool exact, back *at)
{
    _Alignas(32) mbsri_carry carry;
    const double *noise = w->noise, per_area = w->run->tree->per_area;
    blocks *c = &at->c;
    memset(&carry, 0, sizeof carry);
    mbsri_carry_from(w->Mbar, &carry);
    memcpy(carry.L, w->force, 3 * sizeof *carry.L);
    memcpy(carry.p, w->force + 3, 3 * sizeof *carry.p);
    for (int j = 0; j < 2; ++j) {
        c->I[j] += load(carry.I + 4 * j);
        c->M[j] += load(carry.M + 4 * j);
    }
    for (int j = 0; j < 3; ++j) c->G[j] += load(carry.G + 4 * j);
    c->L -= load(carry.L);
    c->p -= load(carry.p);
    c->spread += per_area * (noise[0] + noise[1] + noise[2]) + noise[3] + noise[4] + noise[5];
    if (!exact) return;
    at->W.I[0] += (v4){noise[0], noise[1], noise[2], 0.0};
    at->W.M[0] += (v4){noise[3], noise[4], noise[5], 0.0};
}

/* Past a body on which loops close: its joint sees more inertia than the body and what is behind it
 * have. */
MBSRI_OUTLINE bool pass_closing(mbsri_loop_run *w, int i, bool exact, back *at)
{
    const mbsri_sweep_run *run = w->run;
    const int flags = run->tree->body[i].flags;
    const v4 rho = load(run->state[i].rho);
    blocks *c = &at->c, *W = exact ? &at->W : NULL;
    bool closed;
    gather_masses(run, i, exact, at);
    if (!mbsri_open_loops_meet(w, i, &closed)) return false;
    if (closed) add_closed(w, exact, at);
    if (flags & MBSRI_MULTI) {
        if (!pass_axes(run, i, c, W)) return false;
        translate(rho, c);
    } else if (!pass_axis(run, i, flags | MBSRI_STIFFENED, c, W)) {
        return false;
    }
    if (exact)
        translate(rho, W);
    else
        c->spread *= stretch(run, i);
    hand_on(flags, exact, at);
    return carry_on(w, i);
}

MBSRI_INLINE bool back_with_loops(mbsri_loop_run *w, bool exact)
{
    const mbsri_sweep_run *run = w->run;
    back at;
    bool closed;
    mbsri_open_loops_start(w);
    start_back(run, &at);
    for (int i = run->tree->bodies; i >= 1; --i) {
        const int flags = run->tree->body[i].flags;
        if (flags & MBSRI_CLOSES) {
            if (!pass_closing(w, i, exact, &at)) return false;
            continue;
        }
        if (!pass_body(run, i, exact, false, &at)) return false;
        if (flags & MBSRI_FRONT) {
            if (!mbsri_open_loops_meet(w, i, &closed) || !carry_on(w, i)) return false;
        } else if (run->rank[i] < run->tree->body[i].n) {
            return false;
        }
    }
    return mbsri_open_loops_meet(w, 0, &closed) && w->parts == 0;
}

static bool loops_backward(mbsri_loop_run *w)
{
    return back_with_loops(w, false) || (!w->stuck && back_with_loops(w, true));
}

/* ---- root to leaves ---- */

/* The rates of a joint of several axes without inertia. */
MBSRI_INLINE void push_empty(mbsri_loop_run *w, const mbsri_sweep_body *b)
{
    mbsri_sweep_multi *multi = w->run->multi + b->multi;
    for (int j = 0; j < b->n; ++j) {
        multi->x[j] = w->v[w->run->model->rows + b->u + j];
        multi->factor[j][j] = 1.0;
    }
    w->last = w->last->before;
}

/* The unknowns push joint i: e, or without inertia its rate. */
MBSRI_INLINE void push_joint(mbsri_loop_run *w, int i)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_open_record *kept = w->last;
    if (b->flags & MBSRI_MULTI && kept->nulls > 0) {
        push_empty(w, b);
        return;
    }
    const double *X = (const double *)(const void *)(kept + 1);
    const int count = kept->count, n = b->flags & MBSRI_MULTI ? b->n : 1;
    const int *id = (const int *)(const void *)(X + n * count);
    double *e = b->flags & MBSRI_MULTI ? run->multi[b->multi].x : &run->state[i].e;
    for (int k = 0; k < count; ++k) {
        for (int j = 0; j < n; ++j) e[j] += X[n * k + j] * w->v[id[k]];
    }
    w->last = kept->before;
    if (kept->nulls == 0) return;
    mbsri_sweep_state *s = run->state + i;
    store(s->U_L, splat(0.0));
    store(s->U_p, splat(0.0));
    s->Dinv = 1.0;
    s->e = w->v[id[count]];
}

static void loops_forward(mbsri_loop_run *w)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_body *body = run->tree->body;
    const int bodies = run->tree->bodies, on_loops = MBSRI_FRONT | MBSRI_CLOSES;
    mbsri_open_loops_close(w, 0);
    for (int i = 1; i <= bodies; ++i) {
        int last = i;
        if (w->last && w->last->body == i && !w->last->closes) push_joint(w, i);
        while (!(body[i].flags & on_loops) && last < bodies && !(body[last + 1].flags & on_loops))
            ++last;
        forward_part(run, i, last);
        if (body[i].flags & on_loops) {
            mbsri_open_loops_read(w, i);
            mbsri_open_loops_close(w, i);
        }
        i = last;
    }
}

#endif
