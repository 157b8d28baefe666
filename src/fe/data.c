/* Modal data of a basis: see data.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/data.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"

#include <math.h>

/* Modes with mass of all modes. */
typedef struct massive {
    int count, *mode;
    double *Z; /* n x count */
    double *G; /* (4 + 3 count) x (4 + 3 count): mbsri_fe_gram */
} massive;

static int no_memory_for_data(const mbsri_fe_body *body)
{
    return mbsri_fail_plain(body->error, MBSR_ERR_NO_MEMORY,
                            "mbsr_fe_reduce: no memory for the modal data of %d dofs", body->n);
}

/* B = [T Z]^T M [T Z]; Z of modes without mass as if they had it. */
static int congruence(const mbsri_fe_body *body, const mbsri_fe_basis *basis, double *B)
{
    const size_t n = (size_t)body->n, size = 6 + (size_t)basis->count;
    mbsri_arena scratch;
    mbsri_arena_open(&scratch, &body->arena->allocator);
    double *W = mbsri_arena_take(&scratch, n * size * sizeof *W),
           *MW = mbsri_arena_take(&scratch, n * size * sizeof *MW);
    if (MW) {
        mbsri_copy(6 * n, body->T, W);
        mbsri_copy(n * (size_t)basis->count, basis->Z, W + 6 * n);
        mbsri_sparse_multiply(&body->M, (int)size, W, MW);
        mbsri_fe_atb(body->n, (int)size, (int)size, W, MW, B);
    }
    mbsri_arena_close(&scratch);
    return MW ? MBSR_OK : no_memory_for_data(body);
}

static int pick(const mbsri_fe_body *body, const mbsri_fe_basis *basis, massive *m)
{
    const size_t n = (size_t)body->n;
    *m = (massive){.count = 0};
    m->mode = mbsri_arena_take(body->arena, (size_t)basis->count * sizeof *m->mode);
    if (!m->mode) return no_memory_for_data(body);
    for (int a = 0; a < basis->count; ++a) {
        if (!basis->massless[a]) m->mode[m->count++] = a;
    }
    const size_t count = (size_t)m->count, size = 4 + 3 * count;
    m->Z = mbsri_arena_take(body->arena, n * count * sizeof *m->Z);
    m->G = mbsri_arena_take(body->arena, size * size * sizeof *m->G);
    if (!m->G) return no_memory_for_data(body);
    for (size_t a = 0; a < count; ++a)
        mbsri_copy(n, basis->Z + n * (size_t)m->mode[a], m->Z + n * a);
    return MBSR_OK;
}

/* Lumped mass: fields Phi A with the traces of P one and zero, as M has them; A = (traces)^-1/2
 * changes them least. */
static int match_masses(const mbsri_fe_body *body, massive *m)
{
    const int c = m->count, size = 4 + 3 * c;
    const size_t squares = (size_t)c * (size_t)c, all = (size_t)size;
    double *U = mbsri_arena_take(body->arena, squares * sizeof *U),
           *A = mbsri_arena_take(body->arena, squares * sizeof *A),
           *w = mbsri_arena_take(body->arena, (size_t)c * sizeof *w),
           *work = mbsri_arena_take(body->arena, mbsri_fe_eigen_work(c) * sizeof *work),
           *row = mbsri_arena_take(body->arena, all * sizeof *row);
    if (!row) return no_memory_for_data(body);
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            const double *P = m->G + all * (size_t)(4 + 3 * b) + 4 + 3 * a;
            U[b * c + a] = P[0] + P[all + 1] + P[2 * all + 2];
        }
    }
    if (mbsri_fe_eigen(c, U, w, work) != 0 || (c > 0 && !(w[0] > 1e-6)))
        return MBSRI_FE_REFUSE(
            "lumped at the nodes, the mass of a mode is %.3g of what M says; give "
            "the nodes mass or rotary inertia, or a lower cutoff",
            c > 0 ? w[0] : 0.0);
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            for (int k = 0; k < c; ++k) A[b * c + a] += U[c * k + a] * U[c * k + b] / sqrt(w[k]);
        }
    }
    for (int side = 0; side < 2; ++side) { /* G <- G diag(1, A x 1), and transposed */
        for (size_t r = 0; r < all; ++r) {
            for (size_t k = 0; k < all; ++k) row[k] = m->G[all * k + r];
            for (int b = 0; b < 3 * c; ++b) {
                double sum = 0.0;
                for (int a = 0; a < c; ++a) sum += row[4 + 3 * a + b % 3] * A[b / 3 * c + a];
                m->G[all * (size_t)(4 + b) + r] = sum;
            }
        }
        for (size_t r = 0; r < all; ++r) {
            for (size_t k = 0; k < r; ++k) {
                const double held = m->G[all * k + r];
                m->G[all * k + r] = m->G[all * r + k];
                m->G[all * r + k] = held;
            }
        }
    }
    return MBSR_OK;
}

/* Ct0, P0 and P of modes with mass; Mf is the traces. */
static void spread_with_mass(const massive *m, mbsr_flex_def *def, double *Ct0, double *P0,
                             double *P)
{
    const size_t size = 4 + 3 * (size_t)m->count, rows = 3 * (size_t)def->modes;
    def->mass = m->G[0];
    for (size_t i = 0; i < 3; ++i) {
        def->c0[i] = m->G[1 + i];
        for (size_t j = 0; j < 3; ++j) def->N0[3 * i + j] = m->G[size * (1 + i) + 1 + j];
    }
    for (size_t b = 0; b < 3 * (size_t)m->count; ++b) {
        const double *column = m->G + size * (4 + b);
        const size_t to = 3 * (size_t)m->mode[b / 3] + b % 3;
        Ct0[to] = column[0];
        mbsri_copy(3, column + 1, P0 + 3 * to);
        for (size_t a = 0; a < 3 * (size_t)m->count; ++a)
            P[rows * to + 3 * (size_t)m->mode[a / 3] + a % 3] = column[4 + a];
    }
}

static int stiffness_and_damping(const mbsri_fe_body *body, const mbsri_fe_basis *basis, double *K,
                                 double *D)
{
    const int c = basis->count;
    const size_t n = (size_t)body->n;
    const double zeta = body->def->damping;
    double highest = isfinite(body->def->cutoff) ? body->def->cutoff : 0.0;
    if (body->D.n > 0) {
        double *DZ = mbsri_arena_take(body->arena, n * (size_t)c * sizeof *DZ);
        if (!DZ) return no_memory_for_data(body);
        mbsri_sparse_multiply(&body->D, c, basis->Z, DZ);
        mbsri_fe_atb(body->n, c, c, basis->Z, DZ, D);
    }
    for (int a = 0; a < c; ++a) {
        if (!basis->massless[a]) highest = fmax(highest, 1.0 / sqrt(basis->mu[a]));
    }
    for (int a = 0; a < c; ++a) {
        const int at = a * (c + 1);
        const double omega = basis->massless[a] ? 0.0 : 1.0 / sqrt(basis->mu[a]);
        K[at] = basis->massless[a] ? 1.0 : 1.0 / basis->mu[a];
        D[at] += 2.0 * zeta * (!basis->massless[a] ? omega : highest > 0.0 ? 1.0 / highest : 0.5);
    }
    return MBSR_OK;
}

static void fill_marker(const mbsri_fe_body *body, const mbsri_fe_basis *basis, int k, double *Phi,
                        double *Psi)
{
    for (int a = 0; a < basis->count; ++a) {
        double motion[6];
        mbsri_fe_motion(body, k, basis->Z + (size_t)body->n * (size_t)a, motion);
        mbsri_copy(3, motion + 3, Phi + 3 * a);
        mbsri_copy(3, motion, Psi + 3 * a);
        if (k == 0) { /* zero but for rounding: modes are seen from there */
            mbsri_zero(3, Phi + 3 * a);
            mbsri_zero(3, Psi + 3 * a);
        }
    }
}

int mbsri_fe_make_data(const mbsri_fe_body *body, const mbsri_fe_mass *mass,
                       const mbsri_fe_basis *basis, mbsr_flex **flex, double *B)
{
    const size_t c = (size_t)basis->count, markers = (size_t)body->markers;
    massive m;
    double *data =
        mbsri_arena_take(body->arena, (12 * c + 11 * c * c + 6 * c * markers) * sizeof *data);
    mbsr_flex_marker *marker = mbsri_arena_take(body->arena, markers * sizeof *marker);
    if (!data || !marker) return no_memory_for_data(body);
    double *Ct0 = data, *P0 = Ct0 + 3 * c, *P = P0 + 9 * c, *K = P + 9 * c * c, *D = K + c * c,
           *Phi = D + c * c;
    int status = congruence(body, basis, B);
    if (!status) status = pick(body, basis, &m);
    if (!status) status = mbsri_fe_gram(body, mass, m.count, m.Z, m.G);
    if (!status && !mass->solid) status = match_masses(body, &m);
    if (!status) status = stiffness_and_damping(body, basis, K, D);
    if (status) return status;
    mbsr_flex_def def = mbsr_default_flex_def();
    def.modes = basis->count;
    spread_with_mass(&m, &def, Ct0, P0, P);
    for (int k = 0; k < body->markers; ++k, Phi += 6 * c) {
        fill_marker(body, basis, k, Phi, Phi + 3 * c);
        marker[k] =
            (mbsr_flex_marker){.frame = mbsr_frame_at(body->marker[k].x[0], body->marker[k].x[1],
                                                      body->marker[k].x[2]),
                               .Phi = Phi,
                               .Psi = Phi + 3 * c};
    }
    def.Ct0 = Ct0, def.P0 = P0, def.P = P, def.K = K, def.D = D;
    def.markers = body->markers, def.marker = marker;
    def.allocator = body->def->allocator;
    return mbsr_flex_create(&def, flex, body->error);
}
