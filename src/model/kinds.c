/* What the joint coordinates measure, as far as the library knows: angles or lengths.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joints/chain.h"
#include "joints/planar.h"
#include "model/query.h"

#include <math.h>
#include <stdlib.h>

/* Of the chain's steps; a quaternion takes 4 places of q and 3 of u, what stands behind it in u is
 * one place further in q. */
static mbsr_coordinate_kind chain_kind(const mbsri_joint *joint, int velocity, int k)
{
    bool quaternion = false;
    for (int step = 0; step < joint->option[0]; ++step) {
        const int code = joint->option[1 + step];
        quaternion = quaternion || (code & MBSRI_STEP_KIND) == MBSRI_QUATERNION;
    }
    if (quaternion && k < (velocity ? 3 : 4)) return MBSR_COORDINATE_ROTATION;
    const int place = quaternion && !velocity ? k - 1 : k;
    for (int step = 0; step < joint->option[0]; ++step) {
        const int code = joint->option[1 + step], kind = code & MBSRI_STEP_KIND;
        if (code & MBSRI_DRIVEN || kind == MBSRI_QUATERNION || code >> MBSRI_PLACE_SHIFT != place) {
            continue;
        }
        return kind == MBSRI_TRANSLATION ? MBSR_COORDINATE_TRANSLATION : MBSR_COORDINATE_ROTATION;
    }
    return MBSR_COORDINATE_OTHER;
}

/* Of the free ones among x, y and the angle. */
static mbsr_coordinate_kind planar_kind(int free, int k)
{
    for (int c = 0; c < 3; ++c) {
        if (!(free & (1 << c))) continue;
        if (k-- == 0) return c == 2 ? MBSR_COORDINATE_ROTATION : MBSR_COORDINATE_TRANSLATION;
    }
    return MBSR_COORDINATE_OTHER;
}

mbsr_coordinate_kind mbsri_joint_kind(const mbsri_joint *joint, bool velocity, int k)
{
    int free = 0;
    if (joint->table->position == mbsri_chain_position) return chain_kind(joint, velocity, k);
    return mbsri_planar_coordinates(joint->table, joint->option, &free) ? planar_kind(free, k)
                                                                        : MBSR_COORDINATE_OTHER;
}

int mbsri_place_of_free(const mbsri_body *b, int k)
{
    int place = 0;
    if (!b->lock.at) return k;
    while (!isnan(b->lock.at[place]) || k-- > 0) ++place;
    return place;
}

mbsr_coordinate_kind mbsri_coordinate_kind(const mbsri_body *b, bool velocity, int k)
{
    return mbsri_joint_kind(&b->joint, velocity, mbsri_place_of_free(b, k));
}

int mbsr_body_coordinate_kinds(const mbsr_model *model, int body, mbsr_coordinate_kind *position,
                               mbsr_coordinate_kind *velocity)
{
    if (!model) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const int i = body == MBSR_GROUND ? -1 : mbsri_index(model, body);
    if (i < 0) return MBSR_ERR_ID;
    const mbsri_body *b = model->body + i;
    for (int k = 0; position && k < b->nq; ++k) position[k] = mbsri_coordinate_kind(b, false, k);
    for (int k = 0; velocity && k < b->n; ++k) velocity[k] = mbsri_coordinate_kind(b, true, k);
    return MBSR_OK;
}
