/* What the parts share that make a model of a scene: see build_parts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/build_parts.h"

bool mbsri_scene_refused(mbsri_scene *s, const mbsri_element *e, const mbsr_model *model)
{
    const mbsr_error *error = mbsr_model_error(model);
    if (error->status == MBSR_ERR_NO_MEMORY) {
        s->arena->failed = true;
        return false;
    }
    return mbsri_file_refuse(s, e, "%.150s", error->text);
}

mbsr_frame *mbsri_scene_drawn(const mbsri_scene *s)
{
    mbsr_frame *frames = mbsri_arena_take(s->arena, (size_t)(s->bodies.count + 1) * sizeof *frames);
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    for (int k = 0; frames && k < s->bodies.count; ++k)
        frames[k] =
            b[k].parent < 0 ? b[k].frame : mbsr_frame_product(frames + b[k].parent, &b[k].frame);
    return frames;
}

bool mbsri_scene_force(mbsri_scene *s, mbsr_file *file, mbsr_force_def def, const mbsri_element *e,
                       int *id)
{
    return !mbsr_model_add_force(file->model, &def, id) || mbsri_scene_refused(s, e, file->model);
}

/* What a sum over joints acts on; its body and coordinate lists. */
static void place_sum(const mbsri_scene *s, const mbsri_scene_sum *sum, double gear, int *body,
                      int *coordinate, double *factor)
{
    for (int k = 0; k < sum->count; ++k) {
        const mbsri_scene_joint *j = mbsri_scene_joints(s) + sum->joint[k];
        body[k] = j->joint.body;
        coordinate[k] = j->joint.coordinate;
        factor[k] = gear * sum->factor[k];
    }
}

bool mbsri_scene_sum_force(mbsri_scene *s, mbsr_file *file, const mbsri_scene_sum *sum, double gear,
                           const mbsri_file_law *law, const mbsri_element *e, int *id)
{
    int body[MBSRI_TERMS], coordinate[MBSRI_TERMS];
    double factor[MBSRI_TERMS];
    place_sum(s, sum, gear, body, coordinate, factor);
    const mbsri_transmission t = {sum->count, body, coordinate, factor, *law};
    return mbsri_scene_force(s, file, mbsri_force_transmission(&t), e, id);
}
