/* One more body of a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_BODY_H
#define TEST_BODY_H

#include "expect.h"

/* Its id. */
static inline int test_add_body(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = MBSR_NONE;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

#endif
