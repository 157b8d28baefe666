/* What a stock joint in space is made of.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joints/chain.h"

#include <string.h>

static mbsr_frame frame_at(const double param[12])
{
    mbsr_frame frame;
    memcpy(frame.x, param, sizeof frame.x);
    memcpy(frame.R, param + 3, sizeof frame.R);
    return frame;
}

int mbsr_joint_chain_of(const mbsr_joint *joint, mbsr_joint_chain *chain)
{
    char text[MBSR_TEXT_SIZE];
    if (!joint || !chain) return MBSR_ERR_NULL;
    if (!joint->table || joint->table->position != mbsri_chain_position) return MBSR_ERR_SPACE;
    const int status = joint->table->check_fields(joint, text);
    if (status) return status;
    *chain = (mbsr_joint_chain){.A = frame_at(joint->param + MBSRI_A),
                                .B = frame_at(joint->param + MBSRI_B)};
    for (int k = 0; k < joint->option[0]; ++k) {
        const double *numbers = joint->param + MBSRI_AXES + MBSRI_AXIS_SIZE * k;
        const int code = joint->option[1 + k], kind = code & MBSRI_STEP_KIND;
        if (kind == MBSRI_QUATERNION) {
            chain->quaternion = 1;
            continue;
        }
        mbsr_axis *axis = chain->axis + chain->axes++;
        axis->kind = (mbsr_axis_kind)kind;
        memcpy(axis->direction, numbers, sizeof axis->direction);
        axis->pitch = numbers[3];
        axis->driven = (code & MBSRI_DRIVEN) != 0;
    }
    return MBSR_OK;
}
