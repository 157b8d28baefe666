/* Models for the tests of this folder, piece by piece.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_LINEAR_BUILD_H
#define TEST_LINEAR_BUILD_H

#include "expect.h"

#include <mbsrank/mbsrank.h>

static inline mbsr_model *empty(void)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static inline void add_body(mbsr_model *m, int parent, const char *name, mbsr_joint joint,
                            mbsr_inertia inertia)
{
    mbsr_body_def b = mbsr_default_body_def();
    b.parent = parent;
    b.name = name;
    b.joint = joint;
    b.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
}

static inline void add_force(mbsr_model *m, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

static inline mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

static inline void free_both(mbsr_model *m, mbsr_data *d)
{
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

#endif
