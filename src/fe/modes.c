/* Normal modes: see modes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A = Q K^-1 Q^T M, with Q = 1 - T L^T, is symmetric in the inner product of M, and its largest
 * eigenvalues are theta = 1 / omega^2. Blocks V_1 = A (random), V_2, ... are made M-orthonormal
 * against all before,
 *
 *   A V_j = V_1 H_1j + ... + V_j H_jj + W,   W = V_j+1 B,   G = W^T M W
 *
 * and H = V^T M A V has the Ritz values theta, with residuals |A V y - theta V y| = |W y_j| in the
 * norm of M. All earlier vectors are kept and orthogonalised against twice, so that no eigenvalue
 * shows up a second time; a few solves for each mode are enough, where subspace iteration needs
 * several times as many. */
#include "fe/modes.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"

#include <math.h>

static const double rounding = 1e-13; /* of directions beside the largest Ritz value */

typedef struct lanczos {
    mbsri_fe_statics *s;
    const double *L;
    int n, wanted;
    mbsri_arena memory; /* memory of V */
    double *V;          /* n x room: M-orthonormal */
    int columns, room;
    double *H;            /* room x room, upper triangle */
    double *theta, *Y;    /* Ritz values and vectors, ascending */
    double *residual;     /* residual of each Ritz value */
    double *W, *MW;       /* n x block */
    double *small, *work; /* room x block; of the eigenproblems */
    int converged;
    bool too_slow; /* more vectors than normal modes need */
} lanczos;

int mbsri_fe_tell(const mbsri_fe_body *body, const char *stage, double done)
{
    const mbsr_fe_def *def = body->def;
    return def->progress ? def->progress(def->user, stage, done) : 0;
}

/* Room for more columns. */
static bool grow(lanczos *l)
{
    const size_t n = (size_t)l->n, room = 2 * (size_t)l->room, old = (size_t)l->room;
    lanczos more = *l;
    mbsri_arena_open(&more.memory, &l->memory.allocator);
    mbsri_arena *m = &more.memory;
    more.V = mbsri_arena_take(m, n * room * sizeof *l->V);
    more.H = mbsri_arena_take(m, room * room * sizeof *l->H);
    more.theta = mbsri_arena_take(m, room * sizeof *l->theta);
    more.Y = mbsri_arena_take(m, room * room * sizeof *l->Y);
    more.residual = mbsri_arena_take(m, room * sizeof *l->residual);
    more.small = mbsri_arena_take(m, room * MBSRI_FE_BLOCK * sizeof *l->small);
    more.work = mbsri_arena_take(m, mbsri_fe_eigen_work((int)room) * sizeof *l->work);
    if (!more.work) {
        mbsri_arena_close(&more.memory);
        return false;
    }
    mbsri_copy(n * (size_t)l->columns, l->V, more.V);
    for (size_t j = 0; j < (size_t)l->columns; ++j)
        mbsri_copy((size_t)l->columns, l->H + old * j, more.H + room * j);
    mbsri_arena_close(&l->memory);
    *l = more;
    l->room = (int)room;
    return true;
}

/* W (n x c) less what V has of it; H (NULL: not wanted): where the columns belong in it. */
static void project_out(lanczos *l, int c, double *H)
{
    const size_t columns = (size_t)l->columns;
    mbsri_sparse_multiply(&l->s->body->M, c, l->W, l->MW);
    mbsri_fe_atb(l->n, l->columns, c, l->V, l->MW, l->small);
    mbsri_fe_ab(l->n, l->columns, c, -1.0, l->V, l->small, 1.0, l->W);
    for (size_t j = 0; j < (size_t)c && H; ++j) {
        for (size_t k = 0; k < columns; ++k)
            H[(size_t)l->room * j + k] += l->small[columns * j + k];
    }
}

/* G (c x c) = W^T M W */
static void gram(lanczos *l, int c, double *G)
{
    mbsri_sparse_multiply(&l->s->body->M, c, l->W, l->MW);
    mbsri_fe_atb(l->n, c, c, l->W, l->MW, G);
}

/* Columns of W that are M-orthonormal and span what W (n x c) spans beyond `least` in length; how
 * many, -1: the eigenvalues did not converge. */
static int normalise_columns(lanczos *l, int c, double least)
{
    const size_t n = (size_t)l->n;
    double G[MBSRI_FE_BLOCK * MBSRI_FE_BLOCK], w[MBSRI_FE_BLOCK];
    for (int pass = 0; pass < 2; ++pass) {
        gram(l, c, G);
        if (mbsri_fe_eigen(c, G, w, l->work) != 0) return -1;
        int kept = 0;
        for (int k = 0; k < c; ++k) {
            if (!(w[k] > (pass ? 0.0 : least * least))) continue;
            for (int i = 0; i < c; ++i) G[c * kept + i] = G[c * k + i] / sqrt(w[k]);
            ++kept;
        }
        mbsri_fe_ab(l->n, c, kept, 1.0, l->W, G, 0.0, l->MW);
        mbsri_copy(n * (size_t)kept, l->MW, l->W);
        c = kept;
        if (pass == 0 && c > 0) project_out(l, c, NULL);
    }
    return c;
}

/* W = A W */
static bool apply(lanczos *l, int c)
{
    mbsri_sparse_multiply(&l->s->body->M, c, l->W, l->MW);
    mbsri_copy((size_t)l->n * (size_t)c, l->MW, l->W);
    return mbsri_fe_deflect(l->s, l->L, c, l->W);
}

/* Ritz values and their residuals; G (c x c): of what is left of the last block, c columns. */
static int find_ritz(lanczos *l, int c, const double *G)
{
    const int m = l->columns;
    const size_t room = (size_t)l->room;
    for (int j = 0; j < m; ++j) {
        for (int k = 0; k < m; ++k)
            l->Y[j * m + k] =
                k <= j ? l->H[room * (size_t)j + (size_t)k] : l->H[room * (size_t)k + (size_t)j];
    }
    if (mbsri_fe_eigen(m, l->Y, l->theta, l->work) != 0) return MBSR_ERR_NUMERICS;
    for (int k = 0; k < m; ++k) {
        const double *y = l->Y + (size_t)m * (size_t)k + (m - c);
        double square = 0.0;
        for (int i = 0; i < c; ++i) square += y[i] * mbsri_dot(c, G + c * i, y);
        l->residual[k] = sqrt(fmax(square, 0.0));
    }
    return MBSR_OK;
}

/* How many modes from the lowest on are there, and whether these are all that are wanted. */
static bool finished(lanczos *l)
{
    const mbsr_fe_def *def = l->s->body->def;
    for (l->converged = 0; l->converged < l->columns; ++l->converged) {
        const int k = l->columns - 1 - l->converged;
        if (l->converged == l->wanted) return true;
        if (!(l->residual[k] <= def->tolerance * l->theta[k])) return false;
        if (l->theta[k] * def->frequency * def->frequency < 1.0) return true;
    }
    return false;
}

/* The block W of c columns joins V; W becomes what A makes of it beyond V, with its Gram matrix in
 * G. */
static int take_block(lanczos *l, int c, double *G)
{
    const size_t n = (size_t)l->n, first = (size_t)l->columns;
    if (l->columns + c > l->room && !grow(l)) return MBSR_ERR_NO_MEMORY;
    mbsri_copy(n * (size_t)c, l->W, l->V + n * first);
    l->columns += c;
    if (!apply(l, c)) return MBSR_ERR_NO_MEMORY;
    double *H = l->H + (size_t)l->room * first;
    for (int pass = 0; pass < 2; ++pass) project_out(l, c, H);
    gram(l, c, G);
    return find_ritz(l, c, G);
}

static int lanczos_steps(lanczos *l)
{
    const mbsri_fe_body *body = l->s->body;
    const size_t n = (size_t)l->n;
    double G[MBSRI_FE_BLOCK * MBSRI_FE_BLOCK];
    unsigned int random = 1;
    int c = MBSRI_FE_BLOCK < l->n ? MBSRI_FE_BLOCK : l->n;
    for (size_t k = 0; k < n * (size_t)c; ++k) {
        random = 1664525u * random + 1013904223u;
        l->W[k] = (double)random / 4294967296.0 - 0.5;
    }
    if (!apply(l, c)) return MBSR_ERR_NO_MEMORY;
    gram(l, c, G);
    double largest = 0.0;
    for (int k = 0; k < c; ++k) largest = fmax(largest, sqrt(fabs(G[k * (c + 1)])));
    if (!(largest > 0.0)) return MBSR_OK; /* no mass */
    c = normalise_columns(l, c, rounding * largest);
    while (c > 0) {
        int status = take_block(l, c, G);
        if (status) return status;
        if (finished(l)) return MBSR_OK;
        status = mbsri_fe_tell(body, "normal modes", (double)l->converged / l->wanted);
        if (status) return status;
        l->too_slow = l->columns > 20 * l->wanted + 200;
        if (l->too_slow) return MBSR_ERR_NUMERICS;
        c = normalise_columns(l, c, rounding * l->theta[l->columns - 1]);
    }
    /* nothing is left: all that there are */
    l->converged = c < 0 ? 0 : l->columns < l->wanted ? l->columns : l->wanted;
    return c < 0 ? MBSR_ERR_NUMERICS : MBSR_OK;
}

/* Modes of the Ritz vectors that have converged, below the limit and with mass. */
static int hand_over(lanczos *l, mbsri_fe_modes *modes)
{
    const mbsri_fe_body *body = l->s->body;
    const double limit = body->def->frequency;
    const int m = l->columns;
    const size_t n = (size_t)l->n;
    int count = 0;
    while (count < l->converged) {
        const double theta = l->theta[m - 1 - count];
        if (!(theta > rounding * l->theta[m - 1]) || theta * limit * limit < 1.0) break;
        ++count;
    }
    modes->count = count;
    modes->U = mbsri_arena_take(body->arena, n * (size_t)count * sizeof *modes->U);
    modes->omega = mbsri_arena_take(body->arena, (size_t)count * sizeof *modes->omega);
    if (!modes->omega) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < count; ++k) {
        const int at = m - 1 - k;
        modes->omega[k] = 1.0 / sqrt(l->theta[at]);
        mbsri_fe_ab(l->n, m, 1, 1.0, l->V, l->Y + (size_t)m * (size_t)at, 0.0,
                    modes->U + n * (size_t)k);
    }
    return MBSR_OK;
}

int mbsri_fe_find_modes(mbsri_fe_statics *s, const double *L, mbsri_fe_modes *modes)
{
    const mbsri_fe_body *body = s->body;
    const mbsr_fe_def *def = body->def;
    lanczos l = {.s = s, .L = L, .n = body->n, .wanted = def->modes, .room = def->modes + 8};
    *modes = (mbsri_fe_modes){.count = 0};
    if (def->modes == 0) return MBSR_OK;
    mbsri_arena_open(&l.memory, &def->allocator);
    const size_t block = (size_t)body->n * MBSRI_FE_BLOCK;
    l.W = mbsri_arena_take(body->arena, block * sizeof *l.W);
    l.MW = mbsri_arena_take(body->arena, block * sizeof *l.MW);
    int status = l.MW && grow(&l) ? lanczos_steps(&l) : MBSR_ERR_NO_MEMORY;
    if (!status) status = hand_over(&l, modes);
    const int basis = l.columns;
    mbsri_arena_close(&l.memory);
    if (l.too_slow)
        return mbsri_fail_plain(
            body->error, status,
            "mbsr_fe_reduce: %d of %d normal modes have converged to %g with %d "
            "vectors; ask for fewer or for less",
            l.converged, l.wanted, def->tolerance, basis);
    if (status == MBSR_ERR_NO_MEMORY || status == MBSR_ERR_NUMERICS)
        return mbsri_fail_plain(body->error, status, "mbsr_fe_reduce: %s in finding normal modes",
                                status == MBSR_ERR_NO_MEMORY ? "no memory"
                                                             : "eigenvalues did not converge");
    return status;
}
