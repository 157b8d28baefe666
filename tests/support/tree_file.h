/* Trees of rigid bodies read from files, with reference accelerations; see
 * tests/reference/trees/README.md.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_TREE_FILE_H
#define TEST_TREE_FILE_H

#include <mbsrank/mbsrank.h>

typedef struct test_tree_line {
    int parent;                      /* line of the predecessor, or -1 */
    char type;                       /* 'R' revolute, 'F' free */
    double axis[3];                  /* in the joint frame */
    double place[3], turn[4];        /* joint frame in the predecessor: origin, quaternion */
    double mass, com[3], inertia[6]; /* as for mbsr_inertia_rigid */
} test_tree_line;

/* The numbers of q .. qdd stand in the file's order: free root position, quaternion; linear, then
 * angular velocity. */
typedef struct test_tree_file {
    int bodies, nq, nv;
    test_tree_line *line;
    double *q, *v, *tau, *qdd;
} test_tree_file;

/* Reads NAME.txt and NAME.ref of the folder of the tests; a file that is not as it should be fails
 * the test. */
void test_tree_file_read(test_tree_file *file, const char *name);
void test_tree_file_free(test_tree_file *file);

/* The same tree told in another way. */
typedef struct test_tree_telling {
    mbsr_frame world;    /* the file's world in the model's */
    double length, mass; /* how many of the model's units make 1 m and 1 kg */
    const int *line;     /* body id -> line of the file; NULL: the same */
    int loads;           /* the joint forces tau of the file as force elements */
} test_tree_telling;

test_tree_telling test_tree_told(void); /* as in the file */

/* What the telling makes of a file. */
typedef struct test_told_tree {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    double *q, *u, *tau, *udot; /* in the model's order and units */
    struct test_tree_load *load;
} test_told_tree;

void test_told_tree_make(test_told_tree *tree, const test_tree_file *file,
                         const test_tree_telling *telling);
void test_told_tree_free(test_told_tree *tree);

#endif
