/* Where the mass is: see mass.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of solids M = Ms x 1, and int g h = g^T Ms h for all fields of the shape functions. Elsewhere
 * mass is lumped: the blocks on the diagonal of M as particles m_k and tensors Theta_k, all scaled
 * by one factor to the whole mass. A tensor is a cloud about its node with int d d^T = tr(Theta) /
 * 2 1 - Theta = sum n_l n_l^T, in which a field g(x) varies by its slope: x by d, a mode by psi x
 * d. Both are Gram matrices, so that M(s) is positive semi-definite for all s. */
#include "fe/mass.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/factor.h"
#include "fe/lapack.h"

#include <math.h>

static const double equal = 1e-9;      /* blocks of solids; mass along the axes */
static const double indefinite = 1e-9; /* of M scaled to unit diagonal */

static int no_memory_for_mass(const mbsri_fe_body *body)
{
    return mbsri_fail_plain(body->error, MBSR_ERR_NO_MEMORY,
                            "mbsr_fe_reduce: no memory for the mass of %d nodes", body->nodes);
}

static double at_diagonal(const mbsri_sparse *A, int k)
{
    return A->value[A->start[k]];
}

/* ---- solids ---- */

static bool couples_axes(const mbsri_fe_body *body)
{
    const mbsri_sparse *M = &body->M;
    for (int j = 0; j < M->n; ++j) {
        if (body->direction[j] > 2) return true;
        for (int k = M->start[j]; k < M->start[j + 1]; ++k) {
            const double size =
                sqrt(fabs(at_diagonal(M, j))) * sqrt(fabs(at_diagonal(M, M->row[k])));
            if (body->direction[M->row[k]] != body->direction[j] &&
                fabs(M->value[k]) > equal * size)
                return true;
        }
    }
    return false;
}

/* Whether A and B are the same. */
static bool same(const mbsri_sparse *A, const mbsri_sparse *B)
{
    for (int j = 0; j <= A->n; ++j) {
        if (A->start[j] != B->start[j]) return false;
    }
    for (int j = 0; j < A->n; ++j) {
        for (int k = A->start[j]; k < A->start[j + 1]; ++k) {
            const double size =
                sqrt(fabs(at_diagonal(A, j))) * sqrt(fabs(at_diagonal(A, A->row[k])));
            if (A->row[k] != B->row[k] || fabs(A->value[k] - B->value[k]) > equal * size)
                return false;
        }
    }
    return true;
}

static int see_solid(const mbsri_fe_body *body, mbsri_fe_mass *mass)
{
    mbsri_arena scratch;
    mbsri_sparse other;
    mass->solid = false;
    if (couples_axes(body)) return MBSR_OK;
    mbsri_arena_open(&scratch, &body->arena->allocator);
    int *place = mbsri_arena_take(&scratch, (size_t)body->n * sizeof *place);
    bool good = place != NULL, solid = true;
    for (int c = 0; c < 3 && good && solid; ++c) {
        for (int k = 0; k < body->n; ++k) place[k] = body->direction[k] == c ? body->node[k] : -1;
        good = mbsri_sparse_extract(c ? &scratch : body->arena, &body->M, place, body->nodes,
                                    c ? &other : &mass->Ms);
        if (good && c > 0) solid = same(&mass->Ms, &other);
    }
    mbsri_arena_close(&scratch);
    mass->solid = good && solid;
    return good ? MBSR_OK : no_memory_for_mass(body);
}

/* ---- definiteness ---- */

/* A, of which row k belongs to dof[k], positive semi-definite: with a little more on its diagonal
 * it has a factor. */
static int check_definite(const mbsri_fe_body *body, mbsr_fe_solver solver, const mbsri_sparse *A,
                          const int *dof)
{
    char label[MBSRI_FE_LABEL];
    double *shift = mbsri_arena_take(body->arena, (size_t)A->n * sizeof *shift);
    if (!shift) return no_memory_for_mass(body);
    for (int j = 0; j < A->n; ++j) {
        const double m = at_diagonal(A, j);
        if (m < 0.0)
            return MBSRI_FE_REFUSE("M is indefinite: %g on the diagonal at %s", m,
                                   mbsri_fe_label(body, dof[j], label));
        shift[j] = m > 0.0 ? indefinite * m : 1.0;
        for (int k = A->start[j] + 1; k < A->start[j + 1]; ++k) {
            if (A->value[k] != 0.0 && (m == 0.0 || at_diagonal(A, A->row[k]) == 0.0))
                return MBSRI_FE_REFUSE("M is indefinite: (%d,%d) is %g beside a zero on the "
                                       "diagonal",
                                       dof[A->row[k]], dof[j], A->value[k]);
        }
    }
    mbsri_factor *factor;
    int column;
    const int status = mbsri_factor_make(&body->def->allocator, solver, A, shift, &factor, &column);
    mbsri_factor_destroy(factor);
    if (status == MBSR_ERR_NO_MEMORY) return no_memory_for_mass(body);
    if (status)
        return MBSRI_FE_REFUSE("M is indefinite: its elimination comes to a mass below zero at %s, "
                               "where it is %g",
                               mbsri_fe_label(body, dof[column], label), at_diagonal(A, column));
    return MBSR_OK;
}

/* T^T M T of the translations is m 1. */
static int check_axes(const mbsri_fe_body *body)
{
    const size_t n = (size_t)body->n;
    const double *T = body->T + 3 * n;
    double m[9], *MT = mbsri_arena_take(body->arena, 3 * n * sizeof *MT);
    if (!MT) return no_memory_for_mass(body);
    mbsri_sparse_multiply(&body->M, 3, T, MT);
    mbsri_fe_atb(body->n, 3, 3, T, MT, m);
    for (int k = 0; k < 9; ++k) {
        if (fabs(m[k] - (k % 4 == 0 ? m[0] : 0.0)) > 1e-6 * fabs(m[0]))
            return MBSRI_FE_REFUSE("M is no mass of a body: along x, y, z it has %.7g, %.7g, %.7g, "
                                   "between them %.3g, %.3g, %.3g; do dofs and rows agree?",
                                   m[0], m[4], m[8], m[1], m[2], m[5]);
    }
    return MBSR_OK;
}

/* ---- lumped ---- */

/* Roots of tr(Theta) / 2 1 - Theta, as far as that is positive. */
static int lump_tensor(const mbsri_fe_body *body, const double Theta[9], double roots[9])
{
    double N[9], w[3], work[18];
    const double half = 0.5 * (Theta[0] + Theta[4] + Theta[8]);
    for (int k = 0; k < 9; ++k) N[k] = (k % 4 == 0 ? half : 0.0) - Theta[k];
    if (mbsri_fe_eigen(3, N, w, work) != 0)
        return mbsri_fail_plain(body->error, MBSR_ERR_NUMERICS,
                                "mbsr_fe_reduce: eigenvalues of a tensor did not converge");
    for (int k = 0; k < 9; ++k) roots[k] = sqrt(fmax(w[k / 3], 0.0)) * N[k];
    return MBSR_OK;
}

static int lump(const mbsri_fe_body *body, mbsri_fe_mass *mass)
{
    const mbsri_sparse *M = &body->M;
    const size_t n = (size_t)body->n, nodes = (size_t)body->nodes;
    double *Theta = mbsri_arena_take(body->arena, 9 * nodes * sizeof *Theta),
           *Mt = mbsri_arena_take(body->arena, n * sizeof *Mt);
    mass->lumped = mbsri_arena_take(body->arena, 10 * nodes * sizeof *Theta);
    if (!mass->lumped) return no_memory_for_mass(body);
    double sum = 0.0;
    for (int j = 0; j < M->n; ++j) {
        const int node = body->node[j], b = body->direction[j] - 3;
        if (b < 0) {
            mass->lumped[10 * (size_t)node] += at_diagonal(M, j) / 3.0;
            sum += at_diagonal(M, j) / 3.0;
        }
        for (int k = M->start[j]; k < M->start[j + 1] && b >= 0; ++k) {
            const int a = body->direction[M->row[k]] - 3;
            if (body->node[M->row[k]] != node || a < 0) continue;
            Theta[9 * (size_t)node + (size_t)(3 * a + b)] = M->value[k];
            Theta[9 * (size_t)node + (size_t)(3 * b + a)] = M->value[k];
        }
    }
    mbsri_sparse_multiply(M, 1, body->T + 5 * n, Mt);
    const double factor = sum > 0.0 ? mbsri_dot(body->n, body->T + 5 * n, Mt) / sum : 1.0;
    int status = MBSR_OK;
    for (size_t k = 0; k < nodes && !status; ++k) {
        double *to = mass->lumped + 10 * k;
        to[0] *= factor;
        for (int c = 0; c < 9; ++c) Theta[9 * k + (size_t)c] *= factor;
        status = lump_tensor(body, Theta + 9 * k, to + 1);
    }
    return status;
}

int mbsri_fe_mass_make(const mbsri_fe_body *body, mbsr_fe_solver solver, mbsri_fe_mass *mass)
{
    *mass = (mbsri_fe_mass){.solid = false};
    const size_t most = (size_t)(body->n > body->nodes ? body->n : body->nodes);
    int *dof = mbsri_arena_take(body->arena, most * sizeof *dof);
    if (!dof) return no_memory_for_mass(body);
    int status = see_solid(body, mass);
    if (status) return status;
    const int rows = mass->solid ? body->nodes : body->n;
    for (int k = 0; k < rows; ++k) {
        dof[k] = mass->solid ? body->dof[6 * (size_t)k] : k;
        if (dof[k] < 0) dof[k] = 0; /* a node without dofs, whose row is zero */
    }
    status = check_definite(body, solver, mass->solid ? &mass->Ms : &body->M, dof);
    if (!status) status = check_axes(body);
    return status || mass->solid ? status : lump(body, mass);
}

/* ---- integrals ---- */

/* Fields at nodes, F (nodes x (4 + 3 c)). */
static void fill_fields(const mbsri_fe_body *body, int c, const double *Z, double *F)
{
    const size_t nodes = (size_t)body->nodes, n = (size_t)body->n;
    for (size_t k = 0; k < nodes; ++k) {
        F[k] = 1.0;
        for (size_t i = 0; i < 3; ++i) F[nodes * (1 + i) + k] = body->x[3 * k + i];
        for (size_t i = 0; i < 3 * (size_t)c; ++i) {
            const int dof = body->dof[6 * k + i % 3];
            F[nodes * (4 + i) + k] = dof >= 0 ? Z[n * (i / 3) + (size_t)dof] : 0.0;
        }
    }
}

/* Rows of a lumped node: sqrt(m) g, and the slopes of g along its three roots; g: 4 x rows. */
static void fill_node(const mbsri_fe_body *body, const mbsri_fe_mass *mass, size_t node, int c,
                      const double *Z, const double *F, double *rows)
{
    const size_t nodes = (size_t)body->nodes, n = (size_t)body->n;
    const double *lumped = mass->lumped + 10 * node, root = sqrt(lumped[0]);
    const int *dof = body->dof + 6 * node;
    for (int i = 0; i < 4 + 3 * c; ++i) {
        rows[4 * i] = root * F[nodes * (size_t)i + node];
        for (int l = 0; l < 3; ++l) {
            const double *d = lumped + 1 + 3 * l;
            double slope = i >= 1 && i < 4 ? d[i - 1] : 0.0;
            if (i >= 4 && dof[3] >= 0) {
                const double *z = Z + n * (size_t)((i - 4) / 3);
                const int a = (i - 4) % 3, p = (a + 1) % 3, q = (a + 2) % 3;
                slope = z[dof[3 + p]] * d[q] - z[dof[3 + q]] * d[p];
            }
            rows[4 * i + 1 + l] = slope;
        }
    }
}

int mbsri_fe_gram(const mbsri_fe_body *body, const mbsri_fe_mass *mass, int c, const double *Z,
                  double *G)
{
    const size_t nodes = (size_t)body->nodes, size = 4 + 3 * (size_t)c;
    mbsri_arena scratch;
    mbsri_arena_open(&scratch, &body->arena->allocator);
    double *F = mbsri_arena_take(&scratch, nodes * size * sizeof *F),
           *MF = mbsri_arena_take(&scratch, (mass->solid ? nodes : 4) * size * sizeof *MF),
           *part = mbsri_arena_take(&scratch, size * size * sizeof *part);
    if (part) {
        fill_fields(body, c, Z, F);
        if (mass->solid) {
            mbsri_sparse_multiply(&mass->Ms, (int)size, F, MF);
            mbsri_fe_atb(body->nodes, (int)size, (int)size, F, MF, G);
        } else {
            mbsri_zero(size * size, G);
        }
        for (size_t k = 0; k < nodes && !mass->solid; ++k) {
            fill_node(body, mass, k, c, Z, F, MF);
            mbsri_fe_atb(4, (int)size, (int)size, MF, MF, part);
            for (size_t i = 0; i < size * size; ++i) G[i] += part[i];
        }
    }
    mbsri_arena_close(&scratch);
    return part ? MBSR_OK : no_memory_for_mass(body);
}
