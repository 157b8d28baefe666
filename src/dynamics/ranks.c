/* Ranks as results, and watching them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/group.h"

#include <mbsrank/dynamics.h>
#include <mbsrank/driver.h>

#include <math.h>

int mbsr_body_rank(const mbsr_model *model, mbsr_data *data, int body, mbsr_rank_info *info)
{
    const int status =
        mbsri_enter(model, data, info != NULL, MBSRI_STAGE_BACKWARD, "mbsr_body_rank");
    if (status) return status;
    const int i = mbsri_index(model, body);
    if (i <= 0) {
        return mbsri_fail(&data->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                          "mbsr_body_rank: there is no body %d", body);
    }
    const mbsri_body *b = model->body + i;
    const mbsri_group g = mbsri_group_of(model, data, data->single ? i : b->group.head);
    const double *lambda = data->judged + g.ig;
    const int rank = mbsri_group_rank(data, &g);
    *info = (mbsr_rank_info){.n = b->n,
                             .rank = data->rank[i],
                             .tolerance = model->rank_tolerance,
                             .scale = data->scale[model->body[g.member[0]].scalar_offset]};
    if (rank > 0) info->smallest_kept = lambda[rank - 1];
    for (int k = rank; k < g.n; ++k)
        info->largest_dropped = fmax(info->largest_dropped, fabs(lambda[k]));
    return MBSR_OK;
}

int mbsr_total_rank(const mbsr_model *model, const mbsr_data *data)
{
    const bool known =
        data && data->model == model &&
        (data->stage >= MBSRI_STAGE_BACKWARD || data->pending == MBSRI_PENDING_FORWARD ||
         data->pending == MBSRI_PENDING_MOTION);
    int sum = 0;
    for (int i = 1; known && i <= model->bodies; ++i) sum += data->rank[i];
    return known ? sum : -1;
}

int mbsr_rank_watch_exchange(const mbsr_model *model, mbsr_data *data, int *on, int *rank)
{
    const int status = mbsri_enter(model, data, on && (rank || (model && model->bodies == 0)),
                                   MBSRI_STAGE_NONE, "mbsr_rank_watch_exchange");
    if (status) return status;
    for (int i = 1; i <= model->bodies && *on; ++i) {
        const mbsri_body *b = model->body + i;
        if (rank[b->id] < 0 || rank[b->id] > b->n) {
            return mbsri_fail(&data->error, MBSR_ERR_VALUE, b->id, MBSR_NONE,
                              "mbsr_rank_watch_exchange: rank[%d] is %d, must be 0 .. %d", b->id,
                              rank[b->id], b->n);
        }
    }
    const int was_on = data->watch.active;
    data->watch.active = *on != 0;
    *on = was_on;
    for (int i = 1; i <= model->bodies; ++i) {
        int *given = rank + model->body[i].id;
        const int watched = was_on ? data->watch.rank[i] : 0;
        data->watch.rank[i] = *given;
        *given = watched;
    }
    return MBSR_OK;
}

int mbsr_rank_watch(const mbsr_model *model, mbsr_data *data, int on)
{
    const mbsri_stage needed = on ? MBSRI_STAGE_BACKWARD : MBSRI_STAGE_NONE;
    const int status = mbsri_enter(model, data, true, needed, "mbsr_rank_watch");
    if (status) return status;
    data->watch.active = on != 0;
    for (int i = 1; i <= model->bodies && on; ++i) data->watch.rank[i] = data->rank[i];
    return MBSR_OK;
}
