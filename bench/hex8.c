/* Meshes of a block of elastic solid: see hex8.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * All elements are alike, with edges h. Shape functions (1 + s_x x)(1 + s_y y)(1 + s_z z) / 8, and with `incompatible` also
 * 1 - x^2, 1 - y^2, 1 - z^2, eliminated from the element; Gauss's 2 x 2 x 2 points, and 3 for the mass, are exact. */
#include "hex8.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NODES = 8, DOFS = 24, INNER = 9, ALL = DOFS + INNER };

static const int corner[NODES][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

int hex8_node(const hex8_block *block, int i, int j, int k)
{
    return (i * (block->elements[1] + 1) + j) * (block->elements[2] + 1) + k;
}

/* Shape functions at z in -1 .. 1, and their slopes along the edges h; inner ones behind. */
static void shapes(const double z[3], const double h[3], double N[NODES], double dN[3][NODES + 3])
{
    for (int a = 0; a < NODES; ++a) {
        double f[3], s[3];
        for (int c = 0; c < 3; ++c) {
            s[c] = corner[a][c] ? 1.0 : -1.0;
            f[c] = 1.0 + s[c] * z[c];
        }
        N[a] = f[0] * f[1] * f[2] / 8.0;
        for (int c = 0; c < 3; ++c)
            dN[c][a] = s[c] * f[(c + 1) % 3] * f[(c + 2) % 3] / (4.0 * h[c]);
    }
    for (int a = 0; a < 3; ++a) {
        for (int c = 0; c < 3; ++c) dN[c][NODES + a] = a == c ? -4.0 * z[c] / h[c] : 0.0;
    }
}

/* Stress of unit displacement slopes: C (6 x 6), order xx yy zz xy yz zx. */
static void elasticity(const hex8_block *block, double C[6][6])
{
    const double nu = block->nu, factor = block->E / ((1.0 + nu) * (1.0 - 2.0 * nu));
    memset(C, 0, 36 * sizeof(double));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) C[i][j] = factor * (i == j ? 1.0 - nu : nu);
        C[3 + i][3 + i] = factor * (0.5 - nu);
    }
}

/* Strain of the displacement of function a along c: a column of 6. */
static void strain(double dN[3][NODES + 3], int a, int c, double B[6])
{
    const int next = (c + 1) % 3, last = (c + 2) % 3;
    for (int i = 0; i < 6; ++i) B[i] = 0.0;
    B[c] = dN[c][a];
    B[3 + c] = dN[next][a];    /* xy, yz, zx: c and the axis behind it */
    B[3 + last] = dN[last][a]; /* the axis before it, and c */
}

/* Eliminates rows and columns from DOFS on. */
static void condense(double A[ALL][ALL])
{
    for (int p = ALL - 1; p >= DOFS; --p) {
        for (int i = 0; i < p; ++i) {
            for (int j = 0; j < p; ++j) A[i][j] -= A[i][p] * A[p][j] / A[p][p];
        }
    }
}

static void element(const hex8_block *block, const double h[3], double K[ALL][ALL],
                    double M[NODES][NODES])
{
    const double x[3] = {-sqrt(0.6), 0.0, sqrt(0.6)}, w[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0},
                 volume = h[0] * h[1] * h[2] / 8.0;
    double C[6][6], N[NODES], dN[3][NODES + 3];
    elasticity(block, C);
    memset(K, 0, ALL * ALL * sizeof(double));
    memset(M, 0, NODES * NODES * sizeof(double));
    for (int g = 0; g < 27; ++g) {
        const double z[3] = {x[g % 3], x[g / 3 % 3], x[g / 9]},
                     weight = volume * w[g % 3] * w[g / 3 % 3] * w[g / 9];
        double B[ALL][6], S[ALL][6];
        shapes(z, h, N, dN);
        for (int p = 0; p < ALL; ++p) {
            strain(dN, p / 3, p % 3, B[p]);
            for (int i = 0; i < 6; ++i) {
                S[p][i] = 0.0;
                for (int j = 0; j < 6; ++j) S[p][i] += weight * C[i][j] * B[p][j];
            }
        }
        for (int p = 0; p < ALL; ++p) {
            for (int q = 0; q < ALL; ++q) {
                for (int i = 0; i < 6; ++i) K[p][q] += B[p][i] * S[q][i];
            }
        }
        for (int a = 0; a < NODES; ++a) {
            for (int b = 0; b < NODES; ++b) M[a][b] += weight * block->rho * N[a] * N[b];
        }
    }
    if (block->incompatible) condense(K);
}

static void place_nodes(const hex8_block *block, const double h[3], hex8_mesh *mesh)
{
    const int *n = block->elements;
    for (int i = 0; i <= n[0]; ++i) {
        for (int j = 0; j <= n[1]; ++j) {
            for (int k = 0; k <= n[2]; ++k) {
                double *x = mesh->x + 3 * (size_t)hex8_node(block, i, j, k);
                x[0] = i * h[0];
                x[1] = j * h[1] - 0.5 * block->size[1];
                x[2] = k * h[2] - 0.5 * block->size[2];
            }
        }
    }
}

static void add_element(const hex8_block *block, const int at[3], double K[ALL][ALL],
                        double M[NODES][NODES], hex8_mesh *mesh)
{
    int node[NODES];
    for (int a = 0; a < NODES; ++a)
        node[a] =
            hex8_node(block, at[0] + corner[a][0], at[1] + corner[a][1], at[2] + corner[a][2]);
    for (int p = 0; p < DOFS; ++p) {
        for (int q = 0; q < DOFS; ++q) {
            const int row = 3 * node[p / 3] + p % 3, column = 3 * node[q / 3] + q % 3;
            if (row < column) continue;
            mesh->row[mesh->entries] = row;
            mesh->column[mesh->entries] = column;
            mesh->K[mesh->entries] = K[p][q];
            mesh->M[mesh->entries++] = p % 3 == q % 3 ? M[p / 3][q / 3] : 0.0;
        }
    }
}

int hex8_make(const hex8_block *block, hex8_mesh *mesh)
{
    const int *n = block->elements;
    const double h[3] = {block->size[0] / n[0], block->size[1] / n[1], block->size[2] / n[2]};
    const size_t elements = (size_t)n[0] * (size_t)n[1] * (size_t)n[2],
                 most = elements * DOFS * (DOFS + 1) / 2;
    double K[ALL][ALL], M[NODES][NODES];
    *mesh = (hex8_mesh){.nodes = (n[0] + 1) * (n[1] + 1) * (n[2] + 1)};
    mesh->dofs = 3 * mesh->nodes;
    mesh->x = malloc(3 * (size_t)mesh->nodes * sizeof *mesh->x);
    mesh->row = malloc(most * sizeof *mesh->row);
    mesh->column = malloc(most * sizeof *mesh->column);
    mesh->K = malloc(most * sizeof *mesh->K);
    mesh->M = malloc(most * sizeof *mesh->M);
    if (!mesh->x || !mesh->row || !mesh->column || !mesh->K || !mesh->M) {
        hex8_destroy(mesh);
        return 1;
    }
    place_nodes(block, h, mesh);
    element(block, h, K, M);
    for (int i = 0; i < n[0]; ++i) {
        for (int j = 0; j < n[1]; ++j) {
            for (int k = 0; k < n[2]; ++k) add_element(block, (int[3]){i, j, k}, K, M, mesh);
        }
    }
    return 0;
}

void hex8_destroy(hex8_mesh *mesh)
{
    free(mesh->x);
    free(mesh->row);
    free(mesh->column);
    free(mesh->K);
    free(mesh->M);
    *mesh = (hex8_mesh){.nodes = 0};
}
