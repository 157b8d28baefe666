/* The backward recursion for masses in twofold precision.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The equations are those of backward.c. A moment of inertia about an axis near which all points of
 * a body lie is a small difference of large numbers, as is what a heavy body behind a joint leaves
 * of its mass in the direction of the joint: nothing, up to rounding, to which a light one adds. In
 * double precision both drown; in twofold precision sums and products keep them. What is left is
 * that positions, axes and turned vectors are rounded. But M (exact.h of inertias) is then still
 * that of some distribution of mass, and D = F^T F for some F that has the errors eps |F|. In a
 * direction without inertia F x is eps |F|, and D there eps^2 of what was added up.
 *
 * So errors of sums, W, no longer count, but for a share of 3e-4: below 1e-16 of what cancelled
 * everything that goes on from here in double precision would drown. They run beside W as `unsure`,
 * to which bodies add what their mass matrices were given wrong by:
 *
 *   unsure_i = Diag(unsure of the body) + share (Diag(Mbar_i) + trace of its tensor) + sum of H^T E
 *       H
 *
 * Behind a joint with next to no inertia of its own errors of sums would arrive as many times as
 * large. Here there are none, so that E is confined to what it is made of, unless masses were given
 * with errors. What is left of lever arms along an axis, eps^2 m |r|^2 (`turned`), never counts. */
#include "recursion/exact.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "recursion/errors.h"
#include "recursion/exact_rank.h"
#include "recursion/inertia.h"
#include "recursion/pose.h"
#include "recursion/rank.h"

#include <math.h>

/* Places in exact_work. */
typedef struct room {
    mbsri_two *C, *T, *product, *U, *D, *L, *Y, *F, *next, *work;
} room;

enum { BLOCKS = 14 };

size_t mbsri_exact_room(const mbsr_model *m)
{
    return BLOCKS * (size_t)m->most.d * (size_t)m->most.d + 4 * (size_t)m->most.d;
}

static room place_room(const mbsr_model *m, const mbsr_data *d)
{
    const size_t dm = (size_t)m->most.d * (size_t)m->most.d;
    mbsri_two *at = d->exact_work;
    room r = {.C = at};
    mbsri_two **const place[] = {&r.T, &r.product, &r.U, &r.D, &r.L, &r.Y, &r.F, &r.next, &r.work};
    for (size_t k = 0; k < sizeof place / sizeof *place; ++k) *place[k] = at + (k + 1) * dm;
    return r;
}

/* What Mbar leaves off. */
static double *low(const mbsr_data *d)
{
    return d->Mbardot;
}

static void load_exact(const mbsr_data *d, const mbsri_body *b, mbsri_two *C)
{
    for (size_t k = 0; k < (size_t)(b->d * b->d); ++k)
        C[k] = (mbsri_two){d->Mbar[b->dd + k], low(d)[b->dd + k]};
}

/* Mbar of the predecessor += H^T A H;  A H is left in `product`. */
static void pass_to_predecessor(const mbsr_data *d, const mbsri_body *b, const mbsri_two *A,
                                mbsri_two *product)
{
    const int dim = b->d, dp = b->pred.d;
    const double *H = d->H + b->dp;
    mbsri_two_zero((size_t)(dim * dp), product);
    for (int c = 0; c < dp; ++c) mbsri_two_ax(dim, dim, 1.0, A, H + c * dim, product + c * dim);
    for (int c = 0; c < dp; ++c) {
        for (int r = 0; r <= c; ++r) {
            mbsri_two sum = {0.0, 0.0};
            mbsri_two_atx(dim, 1, 1.0, H + r * dim, product + c * dim, &sum);
            const size_t at = b->pred.dd + (size_t)(c * dp + r),
                         across = b->pred.dd + (size_t)(r * dp + c);
            sum = mbsri_two_add((mbsri_two){d->Mbar[at], low(d)[at]}, sum);
            d->Mbar[at] = d->Mbar[across] = sum.hi;
            low(d)[at] = low(d)[across] = sum.lo;
        }
    }
}

/* As place_blocks in group.c. */
static void place_exact_blocks(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int a,
                               int b, const mbsri_two *F, mbsri_two *D)
{
    const mbsri_body *row = m->body + a, *column = m->body + b;
    const int r = row->group.iu - g->ig, c = column->group.iu - g->ig;
    for (int j = 0; j < column->n; ++j) {
        for (int k = 0; k < row->n && (a != b || k <= j); ++k) {
            mbsri_two entry = {0.0, 0.0};
            mbsri_two_atx(row->d, 1, 1.0, d->J + row->dn + (size_t)(k * row->d), F + j * row->d,
                          &entry);
            D[(c + j) * g->n + r + k] = D[(r + k) * g->n + c + j] = entry;
        }
    }
}

/* U and D of a group (mbsri_group_products). */
static void products(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, const room *r)
{
    const mbsri_body *head = m->body + g->member[0];
    mbsri_two_zero((size_t)(g->n * g->n), r->D);
    for (int k = g->members - 1; k >= 0; --k) {
        const mbsri_body *b = m->body + g->member[k];
        mbsri_two *F = r->F, *next = r->next;
        load_exact(d, b, r->C);
        mbsri_two_zero((size_t)(b->d * b->n), F);
        for (int j = 0; j < b->n; ++j)
            mbsri_two_ax(b->d, b->d, 1.0, r->C, d->J + b->dn + (size_t)(j * b->d), F + j * b->d);
        for (int a = g->member[k];; a = m->body[a].parent) {
            const mbsri_body *at = m->body + a;
            place_exact_blocks(m, d, g, a, g->member[k], F, r->D);
            if (at == head) break;
            /* F <- -H^T F */
            mbsri_two_zero((size_t)(at->pred.d * b->n), next);
            for (int j = 0; j < b->n; ++j)
                mbsri_two_atx(at->d, at->pred.d, -1.0, d->H + at->dp, F + j * at->d,
                              next + j * at->pred.d);
            mbsri_two *swap = F;
            F = next, next = swap;
        }
        for (int l = 0; l < head->d * b->n; ++l) r->U[(b->group.iu - g->ig) * head->d + l] = F[l];
    }
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        for (int l = 0; l < b->n; ++l) {
            mbsri_two *own = r->D + (b->group.iu - g->ig + l) * (g->n + 1);
            *own = mbsri_two_add(*own, mbsri_two_of(b->mass.armature[l]));
        }
    }
    for (int l = 0; l < head->d * g->n; ++l) d->U[head->dg + (size_t)l] = r->U[l].hi;
    for (int l = 0; l < g->n * g->n; ++l) d->D[head->nn + (size_t)l] = r->D[l].hi;
}

/* Y (r x c) with Y L^T = B in the columns of the first c pivots;  then X with X L = Y, whose
 * columns are in the places of B's, into x. X: r x c of work. */
static void divide_exactly(int r, int n, int c, const mbsri_exact_factor *f, const mbsri_two *B,
                           mbsri_two *Y)
{
    for (int k = 0; k < c; ++k) {
        const mbsri_two pivot = f->L[k * n + f->order[k]];
        for (int i = 0; i < r; ++i) {
            mbsri_two sum = B[f->order[k] * r + i];
            for (int l = 0; l < k; ++l)
                sum = mbsri_two_subtract(sum,
                                         mbsri_two_times(Y[l * r + i], f->L[l * n + f->order[k]]));
            Y[k * r + i] = mbsri_two_divide(sum, pivot);
        }
    }
}

/* x (r x n) = Y L^-1 in the columns of the first c pivots, rounded, the others zero; X: r x c of
 * work. */
static void divide_again(int r, int n, int c, const mbsri_exact_factor *f, const mbsri_two *Y,
                         mbsri_two *X, double *x)
{
    mbsri_zero((size_t)(r * n), x);
    for (int k = c - 1; k >= 0; --k) {
        const mbsri_two pivot = f->L[k * n + f->order[k]];
        for (int i = 0; i < r; ++i) {
            mbsri_two sum = Y[k * r + i];
            for (int l = k + 1; l < c; ++l)
                sum = mbsri_two_subtract(sum,
                                         mbsri_two_times(X[l * r + i], f->L[k * n + f->order[l]]));
            X[k * r + i] = mbsri_two_divide(sum, pivot);
            x[f->order[k] * r + i] = X[k * r + i].hi;
        }
    }
}

/* N (n x (n - c)), D N = 0: for each rate without pivot the rates of the c pivots that undo it. z:
 * c of work. */
static void exact_null_vectors(int n, int c, const mbsri_exact_factor *f, mbsri_two *z, double *N)
{
    mbsri_zero((size_t)(n * (n - c)), N);
    for (int j = 0; j < n - c; ++j) {
        const int at = f->order[c + j];
        for (int k = c - 1; k >= 0; --k) {
            z[k] = f->L[k * n + at];
            for (int l = k + 1; l < c; ++l)
                z[k] = mbsri_two_subtract(z[k], mbsri_two_times(f->L[k * n + f->order[l]], z[l]));
            z[k] = mbsri_two_divide(z[k], f->L[k * n + f->order[k]]);
            N[j * n + f->order[k]] = -z[k].hi;
        }
        N[j * n + at] = 1.0;
    }
}

/* A (r x n) <- A (1 - S^-2 N (N^T S^-2 N)^-1 N^T), with L of N^T S^-2 N = L L^T; B: r x m of work.
 */
static void take_out_exactly(int r, int n, int m, const double *s, const double *N, const double *L,
                             double *A, double *B)
{
    mbsri_zero((size_t)(r * m), B);
    for (int j = 0; j < m; ++j) {
        for (int k = 0; k < n; ++k)
            mbsri_ax(r, 1, N[j * n + k] / (s[k] * s[k]), A + k * r, &(double){1.0}, B + j * r);
    }
    mbsri_divide_by_cholesky(r, m, L, B);
    for (int j = m - 1; j >= 0; --j) { /* B <- B L^-1 */
        for (int l = j + 1; l < m; ++l)
            mbsri_ax(r, 1, -L[j * m + l], B + l * r, &(double){1.0}, B + j * r);
        for (int i = 0; i < r; ++i) B[j * r + i] /= L[j * (m + 1)];
    }
    mbsri_abt(r, m, n, -1.0, B, N, A);
}

/* Dinv and G after the decision, Y of the pivots kept. With all pivots D^+ = D^-1; else that
 * inverse in the pivots' rows and columns is brought to the coordinates S^-1 u, so that small
 * pivots keep their digits. False: N^T S^-2 N is singular. */
static bool gains(const mbsri_body *head, mbsr_data *d, const mbsri_group *g, int rank,
                  const mbsri_exact_factor *f, const room *r)
{
    const int n = g->n, dim = head->d, m = n - rank;
    const size_t nn = (size_t)n * (size_t)n;
    double *Dinv = d->Dinv + head->nn, *G = d->G + head->dg, *N = d->scratch, *L = N + nn,
           *B = L + nn;
    const double *s = d->s + g->ig;
    /* D^-1 = 1 L^-T L^-1, from rows of the unit matrix */
    mbsri_two_zero(nn, r->F);
    for (int k = 0; k < n; ++k) r->F[k * (n + 1)].hi = 1.0;
    divide_exactly(n, n, rank, f, r->F, r->Y);
    divide_again(n, n, rank, f, r->Y, r->next, Dinv);
    divide_exactly(dim, n, rank, f, r->U, r->Y);
    divide_again(dim, n, rank, f, r->Y, r->next, G);
    if (m > 0 && rank > 0) {
        exact_null_vectors(n, rank, f, r->F, N);
        mbsri_null_columns(n, m, s, N, d->X + head->nn + (size_t)(rank * n));
        mbsri_zero((size_t)(m * m), L);
        for (int j = 0; j < m; ++j) {
            for (int l = 0; l < m; ++l) {
                for (int k = 0; k < n; ++k)
                    L[j * m + l] += N[j * n + k] * N[l * n + k] / (s[k] * s[k]);
            }
        }
        if (!mbsri_cholesky(m, L)) return false;
        take_out_exactly(dim, n, m, s, N, L, G, B);
        for (int side = 0; side < 2; ++side) {
            take_out_exactly(n, n, m, s, N, L, Dinv, B);
            for (int j = 0; j < n; ++j) {
                for (int k = 0; k < j; ++k) {
                    const double swap = Dinv[j * n + k];
                    Dinv[j * n + k] = Dinv[k * n + j];
                    Dinv[k * n + j] = swap;
                }
            }
        }
    }
    mbsri_symmetrise(n, Dinv);
    return true;
}

/* Scales rows and columns from `first` on, `count` of them, of E (n x n) so that their trace is no
 * larger than `terms` times that of A. */
static void confine_part(int n, int first, int count, double terms, const double *A, double *E)
{
    double size = 0.0, most = 0.0;
    for (int k = first; k < first + count; ++k) {
        size += E[k * (n + 1)];
        most += terms * A[k * (n + 1)];
    }
    if (!(size > most)) return;
    const double factor = sqrt(most / size);
    for (int k = first; k < first + count; ++k) {
        for (int l = 0; l < n; ++l) {
            E[k * n + l] *= factor;
            E[l * n + k] *= factor;
        }
    }
}

/* Rotations and translations, which have different units, apart. What was added up at the body
 * itself, least (d x d), remains: only one direction of a part may have become too large. E is made
 * of three terms of its size where no inertia is small, and of more by the root of the smallest one
 * of the joint, `inertia`, beside 1 [choice]. */
static void confine(const mbsri_body *b, const double *A, double share, const double *least,
                    double inertia, double *E)
{
    const double terms = 3.0 / sqrt(fmin(inertia, 1.0));
    const bool plane = b->joint.space == MBSR_SPACE_PLANAR;
    if (!plane && !mbsri_turns(b->joint.space)) return;
    confine_part(b->d, 0, plane ? 2 : 3, terms, A, E);
    confine_part(b->d, plane ? 2 : 3, plane ? 1 : 3, terms, A, E);
    for (int k = 0; k < b->d * b->d; k += b->d + 1) E[k] = fmax(E[k], share * least[k]);
}

/* Mbar^a = Mbar - Y Y^T and the errors to the predecessor; given: whether masses were given with
 * errors. */
static void pass_head(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, bool given,
                      const room *r)
{
    const mbsri_body *b = m->body + g->member[0];
    const int dim = b->d, rank = mbsri_group_rank(d, g);
    const size_t dm = (size_t)m->most.d * (size_t)m->most.d;
    double *E = d->scratch, *Q = E + dm, *JQ = Q + dm, *product = JQ + dm;
    double *const errors[2] = {d->W, d->unsure};
    const double inertia = rank > 0 ? d->judged[g->ig + rank - 1] : 1.0;
    if (b->pred.d == 0) return;
    load_exact(d, b, r->T);
    for (int j = 0; j < dim; ++j) {
        for (int k = 0; k <= j; ++k) {
            mbsri_two sum = r->T[j * dim + k];
            for (int l = 0; l < rank; ++l)
                sum =
                    mbsri_two_subtract(sum, mbsri_two_times(r->Y[l * dim + j], r->Y[l * dim + k]));
            r->T[j * dim + k] = r->T[k * dim + j] = sum;
        }
    }
    pass_to_predecessor(d, b, r->T, r->product);
    for (int l = 0; l < 2; ++l) {
        const double share = l == 0 ? 1.0 : MBSRI_EXACT_SHARE;
        mbsri_carry_errors(m, d, g, errors[l], share, dim, E, Q, JQ, product);
        if (!given) confine(b, errors[l] + b->dd, share, d->Mbar + b->dd, inertia, E);
        mbsri_congruence(dim, b->pred.d, d->H + b->dp, E, errors[l] + b->pred.dd, product);
    }
}

/* Of another member of a group what it has itself; Diag(Mbar) is in its errors already. */
static void pass_member(const mbsri_body *b, mbsr_data *d, const room *r)
{
    const size_t dp = (size_t)b->pred.d;
    double *product = d->scratch;
    if (dp == 0) return;
    load_exact(d, b, r->T);
    for (size_t k = 0; k < dp; ++k) {
        const double before = d->Mbar[b->pred.dd + k * (dp + 1)];
        d->W[b->pred.dd + k * (dp + 1)] += before;
        d->unsure[b->pred.dd + k * (dp + 1)] += MBSRI_EXACT_SHARE * before;
    }
    pass_to_predecessor(d, b, r->T, r->product);
    for (size_t k = 0; k < dp; ++k) {
        const double after = d->Mbar[b->pred.dd + k * (dp + 1)];
        d->W[b->pred.dd + k * (dp + 1)] -= after;
        d->unsure[b->pred.dd + k * (dp + 1)] -= MBSRI_EXACT_SHARE * after;
    }
    mbsri_congruence(b->d, b->pred.d, d->H + b->dp, d->W + b->dd, d->W + b->pred.dd, product);
    mbsri_congruence(b->d, b->pred.d, d->H + b->dp, d->unsure + b->dd, d->unsure + b->pred.dd,
                     product);
}

/* Mbar = M and what is unsure of it. */
static void open_body(const mbsr_model *m, mbsr_data *d, int i, const room *r)
{
    const mbsri_body *b = m->body + i;
    const int dim = b->d;
    double *unsure = d->scratch;
    mbsri_inertia_exact(b, d->p + b->p, d->M + b->dd, r->C, unsure);
    for (size_t k = 0; k < (size_t)(dim * dim); ++k) {
        d->Mbar[b->dd + k] = r->C[k].hi;
        low(d)[b->dd + k] = r->C[k].lo;
    }
    const double turned = MBSRI_EXACT_SHARE * mbsri_own_rotated(b, d->M + b->dd);
    for (int k = 0; k < dim; ++k)
        d->unsure[b->dd + (size_t)(k * (dim + 1))] = unsure[k] + (k < 3 ? turned : 0.0);
    d->rotated[b->scalar_offset] = turned / MBSRI_EXACT_SHARE;
}

static int eliminate_exactly(const mbsr_model *m, mbsr_data *d, int i, const room *r)
{
    const mbsri_group g = mbsri_group_of(m, d, i);
    const mbsri_body *head = m->body + i;
    mbsri_exact_factor factor = {.order = d->pivots, .L = r->L};
    products(m, d, &g, r);
    for (int k = 0; k < g.members; ++k) d->rank[g.member[k]] = 0;
    d->scale[m->body[i].scalar_offset] = 0.0;
    const int status = g.n > 0 ? mbsri_exact_decision(m, d, &g, r->D, &factor, r->work) : MBSR_OK;
    if (status) return status;
    if (!gains(head, d, &g, mbsri_group_rank(d, &g), &factor, r)) return MBSR_NOT_FINITE;
    return mbsri_rank_watched(m, d, i);
}

bool mbsri_given_with_errors(const mbsr_model *m, mbsr_data *d)
{
    const room r = place_room(m, d);
    double *unsure = d->scratch;
    bool given = false;
    for (int i = 1; i <= m->bodies && !given; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_inertia_exact(b, d->p + b->p, d->M + b->dd, r.C, unsure);
        for (int k = 0; k < b->d; ++k) given = given || unsure[k] > 0.0;
    }
    return given;
}

int mbsri_exact_masses(const mbsr_model *m, mbsr_data *d)
{
    const room r = place_room(m, d);
    mbsri_zero(m->size.dd, d->W);
    mbsri_zero(m->size.dd, d->unsure);
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->Mbar);
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, low(d));
    const bool given = mbsri_given_with_errors(m, d);
    for (int i = 1; i <= m->bodies; ++i) open_body(m, d, i, &r);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_add_diagonal(b->d, 1.0, d->Mbar + b->dd, d->W + b->dd);
        mbsri_add_diagonal(b->d, MBSRI_EXACT_SHARE, d->Mbar + b->dd, d->unsure + b->dd);
        if (b->pred.d > 0)
            d->rotated[m->body[b->parent].scalar_offset] +=
                d->rotated[b->scalar_offset] +
                mbsri_trace_of_arms(b, d->H + b->dp, d->Mbar + b->dd);
        if (!mbsri_heads(m, d, i)) {
            pass_member(b, d, &r);
            continue;
        }
        const int status = eliminate_exactly(m, d, i, &r);
        if (status) return status;
        const mbsri_group g = mbsri_group_of(m, d, i);
        pass_head(m, d, &g, given, &r);
    }
    return MBSR_OK;
}

/* The block of the mass matrix of the joints of bodies k and i, from F (d x n_i) at body k. */
static void place_mass(const mbsr_model *m, const mbsr_data *d, int k, int i, const mbsri_two *F,
                       double *matrix)
{
    const mbsri_body *row = m->body + k, *column = m->body + i;
    const size_t nu = (size_t)m->nu;
    for (int b = 0; b < column->n; ++b) {
        for (int a = 0; a < row->n; ++a) {
            mbsri_two entry = {0.0, 0.0};
            mbsri_two_atx(row->d, 1, 1.0, d->J + row->dn + (size_t)(a * row->d), F + b * row->d,
                          &entry);
            matrix[(size_t)(column->u + b) * nu + (size_t)(row->u + a)] = entry.hi;
            matrix[(size_t)(row->u + a) * nu + (size_t)(column->u + b)] = entry.hi;
        }
    }
}

void mbsri_exact_mass_matrix(const mbsr_model *m, mbsr_data *d, double *matrix)
{
    const room r = place_room(m, d);
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->Mbar);
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, low(d));
    for (int i = 1; i <= m->bodies; ++i) open_body(m, d, i, &r);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_two *F = r.F, *next = r.next;
        load_exact(d, b, r.C);
        mbsri_two_zero((size_t)(b->d * b->n), F);
        for (int j = 0; j < b->n; ++j)
            mbsri_two_ax(b->d, b->d, 1.0, r.C, d->J + b->dn + (size_t)(j * b->d), F + j * b->d);
        for (int k = i; k > 0; k = m->body[k].parent) {
            const mbsri_body *at = m->body + k;
            place_mass(m, d, k, i, F, matrix);
            mbsri_two_zero((size_t)(at->pred.d * b->n), next);
            for (int j = 0; j < b->n; ++j)
                mbsri_two_atx(at->d, at->pred.d, -1.0, d->H + at->dp, F + j * at->d,
                              next + j * at->pred.d);
            mbsri_two *swap = F;
            F = next, next = swap;
        }
        if (b->pred.d > 0) pass_to_predecessor(d, b, r.C, r.product);
    }
}
