/* A random tree of rigid bodies at a state that its Newton systems belong to.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_NEWTON_SCENE_H
#define TEST_NEWTON_SCENE_H

#include "expect.h"
#include "newton_system.h"
#include "rigid_tree.h"

/* A right-hand side goes to x, which has room for `most` numbers. */
static inline void test_newton_scene(test_rigid_tree *tree, test_newton_state *s,
                                     test_rigid_choice choice, int most, double *x)
{
    choice.length = 0.5;
    choice.branching = 0.4;
    test_rigid_tree_make(tree, choice);
    assert_ok(test_newton_start(s, tree->model, tree->data, tree->t, tree->q, tree->u, NULL),
              mbsr_data_error(tree->data));
    assert_in_range(s->n, 8, most);
    test_rng rng = test_seed(5);
    test_fill(&rng, s->n, x);
}

static inline void test_newton_scene_free(test_rigid_tree *tree, test_newton_state *s)
{
    test_newton_free(s);
    test_rigid_tree_free(tree);
}

#endif
