/* Definitions with their defaults; creating a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "base/error.h"
#include "model/record.h"

#include <string.h>

mbsr_root mbsr_root_fixed(void)
{
    return (mbsr_root){.space = MBSR_SPACE_FIXED};
}

mbsr_root mbsr_root_moving(mbsr_space space, int d, int np, mbsr_root_fn motion, void *user)
{
    return (mbsr_root){.space = space, .d = d, .np = np, .motion = motion, .user = user};
}

mbsr_model_def mbsr_default_model_def(void)
{
    return (mbsr_model_def){
        .cookie = MBSRI_COOKIE, .root = mbsr_root_fixed(), .rank_tolerance = 1e-12};
}

mbsr_body_def mbsr_default_body_def(void)
{
    return (mbsr_body_def){.cookie = MBSRI_COOKIE, .parent = MBSR_GROUND};
}

static int check_root(const mbsr_root *root, mbsr_error *error)
{
    static const int space_d[] = {[MBSR_SPACE_FIXED] = 0,
                                  [MBSR_SPACE_POINT] = 2,
                                  [MBSR_SPACE_PLANAR] = 3,
                                  [MBSR_SPACE_SPATIAL] = 6};
    static const int space_np[] = {[MBSR_SPACE_FIXED] = 0,
                                   [MBSR_SPACE_POINT] = 2,
                                   [MBSR_SPACE_PLANAR] = 3,
                                   [MBSR_SPACE_SPATIAL] = MBSR_POSE_SIZE};
    const int space = (int)root->space;
    if (space < MBSR_SPACE_FIXED || space > MBSR_SPACE_SPATIAL) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_GROUND, MBSR_NONE,
                          "root: space is %d, no such space", space);
    }
    if (root->space == MBSR_SPACE_GENERAL) {
        if (root->d < 1 || root->d > MBSR_MAX_D || root->np < 0) {
            return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_GROUND, MBSR_NONE,
                              "root: d = %d, np = %d; d must be 1 .. %d and np not negative",
                              root->d, root->np, MBSR_MAX_D);
        }
    } else if (root->d != space_d[space] || root->np != space_np[space]) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_GROUND, MBSR_NONE,
                          "root: d = %d, np = %d; this space has d = %d, np = %d", root->d,
                          root->np, space_d[space], space_np[space]);
    }
    if (root->space == MBSR_SPACE_FIXED && root->motion) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_GROUND, MBSR_NONE,
                          "root: a FIXED root has no coordinates, so motion must be NULL");
    }
    return MBSR_OK;
}

static int check_model_def(const mbsr_model_def *def, mbsr_error *error)
{
    if (def->cookie != MBSRI_COOKIE) {
        return mbsri_fail(
            error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
            "mbsr_model_create: the definition was not made by mbsr_default_model_def");
    }
    if (!(def->rank_tolerance > 0.0 && def->rank_tolerance < 1.0)) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_create: rank_tolerance is %g, must lie between 0 and 1",
                          def->rank_tolerance);
    }
    if (!def->allocator.allocate != !def->allocator.release) {
        return mbsri_fail(
            error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
            "mbsr_model_create: allocator needs both allocate and release, or neither");
    }
    return check_root(&def->root, error);
}

int mbsr_model_create(const mbsr_model_def *def, mbsr_model **model, mbsr_error *error)
{
    const mbsr_model_def standard = mbsr_default_model_def();
    if (!model)
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_create: model is NULL");
    *model = NULL;
    if (!def) def = &standard;
    const int status = check_model_def(def, error);
    if (status) return status;

    mbsr_model *m = mbsri_allocate(&def->allocator, sizeof *m);
    if (!m)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_create: no memory");
    memset(m, 0, sizeof *m);
    m->allocator = def->allocator;
    m->root = def->root;
    m->rank_tolerance = def->rank_tolerance;
    m->error.body = m->error.force = MBSR_NONE;
    if (!mbsri_reserve(&m->allocator, &m->stored.names, 1, 1)) {
        mbsri_release(&m->allocator, m);
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_create: no memory");
    }
    ((char *)m->stored.names.data)[0] = '\0';
    m->stored.names.count = 1;
    *model = m;
    return MBSR_OK;
}

const mbsr_error *mbsr_model_error(const mbsr_model *model)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the model is NULL"};
    return model ? &model->error : &none;
}
