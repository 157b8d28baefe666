/* Meshes of a block of elastic solid: bricks of eight nodes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef HEX8_H
#define HEX8_H

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

/* Returns 0, 1: no memory. Released by hex8_destroy. */
int hex8_make(const hex8_block *block, hex8_mesh *mesh);
void hex8_destroy(hex8_mesh *mesh);

/* Number of the node i, j, k. */
int hex8_node(const hex8_block *block, int i, int j, int k);

#endif
