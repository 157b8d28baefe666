/* Meshes of a block of elastic solid: bricks of eight nodes, all alike.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Shape functions (1 + s_x x)(1 + s_y y)(1 + s_z z) / 8, and with `incompatible` also 1 - x^2, 1 -
 * y^2, 1 - z^2, which are eliminated from the element; Gauss's 3 x 3 x 3 points. */
#ifndef HEX8_H
#define HEX8_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Matrices as coordinates of the lower triangle, entries of equal indices to be added. */
typedef struct hex8_mesh {
    int nodes, dofs, entries;
    double *x; /* 3 x nodes */
    int *row, *column;
    double *K, *M; /* entries */
} hex8_mesh;

typedef struct hex8_block {
    int elements[3];   /* along x, y, z */
    double size[3];    /* m; the block is 0 .. size along x, centred along y and z */
    double E, nu, rho; /* N/m^2, 1, kg/m^3 */
    int incompatible;  /* 1: with incompatible modes of Wilson, which bend as they should */
} hex8_block;

enum { HEX8_NODES = 8, HEX8_DOFS = 24, HEX8_ALL = HEX8_DOFS + 9 };

static const int hex8_corner[HEX8_NODES][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                               {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/* Number of the node i, j, k. */
static inline int hex8_node(const hex8_block *block, int i, int j, int k)
{
    return (i * (block->elements[1] + 1) + j) * (block->elements[2] + 1) + k;
}

/* Shape functions at z in -1 .. 1, and their slopes along the edges h; inner ones behind. */
static inline void hex8_shapes(const double z[3], const double h[3], double N[HEX8_NODES],
                               double dN[3][HEX8_NODES + 3])
{
    for (int a = 0; a < HEX8_NODES; ++a) {
        double f[3], s[3];
        for (int c = 0; c < 3; ++c) {
            s[c] = hex8_corner[a][c] ? 1.0 : -1.0;
            f[c] = 1.0 + s[c] * z[c];
        }
        N[a] = f[0] * f[1] * f[2] / 8.0;
        for (int c = 0; c < 3; ++c)
            dN[c][a] = s[c] * f[(c + 1) % 3] * f[(c + 2) % 3] / (4.0 * h[c]);
    }
    for (int a = 0; a < 3; ++a) {
        for (int c = 0; c < 3; ++c) dN[c][HEX8_NODES + a] = a == c ? -4.0 * z[c] / h[c] : 0.0;
    }
}

/* Stress of unit displacement slopes: C (6 x 6), order xx yy zz xy yz zx. */
static inline void hex8_elasticity(const hex8_block *block, double C[6][6])
{
    const double nu = block->nu, factor = block->E / ((1.0 + nu) * (1.0 - 2.0 * nu));
    memset(C, 0, 36 * sizeof(double));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) C[i][j] = factor * (i == j ? 1.0 - nu : nu);
        C[3 + i][3 + i] = factor * (0.5 - nu);
    }
}

/* Strain of the displacement of function a along c: a column of 6. */
static inline void hex8_strain(double dN[3][HEX8_NODES + 3], int a, int c, double B[6])
{
    const int next = (c + 1) % 3, last = (c + 2) % 3;
    for (int i = 0; i < 6; ++i) B[i] = 0.0;
    B[c] = dN[c][a];
    B[3 + c] = dN[next][a];    /* xy, yz, zx: c and the axis behind it */
    B[3 + last] = dN[last][a]; /* the axis before it, and c */
}

/* Eliminates rows and columns from HEX8_DOFS on. */
static inline void hex8_condense(double A[HEX8_ALL][HEX8_ALL])
{
    for (int p = HEX8_ALL - 1; p >= HEX8_DOFS; --p) {
        for (int i = 0; i < p; ++i) {
            for (int j = 0; j < p; ++j) A[i][j] -= A[i][p] * A[p][j] / A[p][p];
        }
    }
}

static inline void hex8_element(const hex8_block *block, const double h[3],
                                double K[HEX8_ALL][HEX8_ALL], double M[HEX8_NODES][HEX8_NODES])
{
    const double x[3] = {-sqrt(0.6), 0.0, sqrt(0.6)}, w[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0},
                 volume = h[0] * h[1] * h[2] / 8.0;
    double C[6][6], N[HEX8_NODES], dN[3][HEX8_NODES + 3];
    hex8_elasticity(block, C);
    memset(K, 0, HEX8_ALL * HEX8_ALL * sizeof(double));
    memset(M, 0, HEX8_NODES * HEX8_NODES * sizeof(double));
    for (int g = 0; g < 27; ++g) {
        const double z[3] = {x[g % 3], x[g / 3 % 3], x[g / 9]},
                     weight = volume * w[g % 3] * w[g / 3 % 3] * w[g / 9];
        double B[HEX8_ALL][6], S[HEX8_ALL][6];
        hex8_shapes(z, h, N, dN);
        for (int p = 0; p < HEX8_ALL; ++p) {
            hex8_strain(dN, p / 3, p % 3, B[p]);
            for (int i = 0; i < 6; ++i) {
                S[p][i] = 0.0;
                for (int j = 0; j < 6; ++j) S[p][i] += weight * C[i][j] * B[p][j];
            }
        }
        for (int p = 0; p < HEX8_ALL; ++p) {
            for (int q = 0; q < HEX8_ALL; ++q) {
                for (int i = 0; i < 6; ++i) K[p][q] += B[p][i] * S[q][i];
            }
        }
        for (int a = 0; a < HEX8_NODES; ++a) {
            for (int b = 0; b < HEX8_NODES; ++b) M[a][b] += weight * block->rho * N[a] * N[b];
        }
    }
    if (block->incompatible) hex8_condense(K);
}

static inline void hex8_place_nodes(const hex8_block *block, const double h[3], hex8_mesh *mesh)
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

static inline void hex8_add_element(const hex8_block *block, const int at[3],
                                    double K[HEX8_ALL][HEX8_ALL], double M[HEX8_NODES][HEX8_NODES],
                                    hex8_mesh *mesh)
{
    int node[HEX8_NODES];
    for (int a = 0; a < HEX8_NODES; ++a)
        node[a] = hex8_node(block, at[0] + hex8_corner[a][0], at[1] + hex8_corner[a][1],
                            at[2] + hex8_corner[a][2]);
    for (int p = 0; p < HEX8_DOFS; ++p) {
        for (int q = 0; q < HEX8_DOFS; ++q) {
            const int row = 3 * node[p / 3] + p % 3, column = 3 * node[q / 3] + q % 3;
            if (row < column) continue;
            mesh->row[mesh->entries] = row;
            mesh->column[mesh->entries] = column;
            mesh->K[mesh->entries] = K[p][q];
            mesh->M[mesh->entries++] = p % 3 == q % 3 ? M[p / 3][q / 3] : 0.0;
        }
    }
}

static inline void hex8_destroy(hex8_mesh *mesh)
{
    free(mesh->x);
    free(mesh->row);
    free(mesh->column);
    free(mesh->K);
    free(mesh->M);
    *mesh = (hex8_mesh){.nodes = 0};
}

/* Returns 0, 1: no memory. Released by hex8_destroy. */
static inline int hex8_make(const hex8_block *block, hex8_mesh *mesh)
{
    const int *n = block->elements;
    const double h[3] = {block->size[0] / n[0], block->size[1] / n[1], block->size[2] / n[2]};
    const size_t elements = (size_t)n[0] * (size_t)n[1] * (size_t)n[2],
                 most = elements * HEX8_DOFS * (HEX8_DOFS + 1) / 2;
    double K[HEX8_ALL][HEX8_ALL], M[HEX8_NODES][HEX8_NODES];
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
    hex8_place_nodes(block, h, mesh);
    hex8_element(block, h, K, M);
    for (int i = 0; i < n[0]; ++i) {
        for (int j = 0; j < n[1]; ++j) {
            for (int k = 0; k < n[2]; ++k) hex8_add_element(block, (int[3]){i, j, k}, K, M, mesh);
        }
    }
    return 0;
}

#endif
