/* The data block: one layout that both computes the size and places the arrays.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include "dense.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

size_t mbsri_scratch_size(const mbsr_model *m)
{
    const size_t d = (size_t)m->max_d;
    const size_t products = 15 * d * d + 16 * d + 8;
    const size_t lapack = (size_t)m->lapack_work;
    return products + (lapack > 6 * d ? lapack : 6 * d);
}

/* Takes the next `size` bytes of a block, aligned to a cache line; with base == NULL only
 * counts. */
static void *take(unsigned char *base, size_t *used, size_t size)
{
    void *place = base ? base + *used : NULL;
    *used += (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    return place;
}

/* Places the data object and its arrays in `base`, or with base == NULL only returns the size. */
static size_t layout(const mbsr_model *m, unsigned char *base, mbsr_data **data)
{
    mbsr_data counted;
    size_t used = 0;
    const size_t bodies = (size_t)m->bodies + 1;
    mbsr_data *d = take(base, &used, sizeof *d);
    if (!d) d = &counted;
    d->rank = take(base, &used, bodies * sizeof *d->rank);
    d->watched = take(base, &used, bodies * sizeof *d->watched);
    d->frame_rank = take(base, &used, bodies * sizeof *d->frame_rank);
    d->carries = take(base, &used, bodies * sizeof *d->carries);
    d->pivots = take(base, &used, (size_t)m->max_d * sizeof *d->pivots);
    d->force_bodies = take(base, &used, (size_t)m->max_force_bodies * sizeof *d->force_bodies);
#define MBSRI_PLACE(name, length) d->name = take(base, &used, (size_t)(length) * sizeof(double));
    MBSRI_DATA_ARRAYS(MBSRI_PLACE)
#undef MBSRI_PLACE
    if (data) *data = d;
    return used;
}

size_t mbsr_data_size(const mbsr_model *model)
{
    return model && model->finished ? layout(model, NULL, NULL) : 0;
}

int mbsr_data_init(const mbsr_model *model, void *memory, size_t size, mbsr_data **data,
                   mbsr_error *error)
{
    if (data) *data = NULL;
    if (!model || !memory || !data) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_data_init: %s is NULL",
                          !model    ? "model"
                          : !memory ? "memory"
                                    : "data");
    }
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_init: the model is not finished");
    }
    const size_t needed = mbsr_data_size(model);
    if (size < needed) {
        return mbsri_fail(error, MBSR_ERR_MEMORY_SIZE, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_init: size is %zu bytes, this model needs %zu", size, needed);
    }
    if ((uintptr_t)memory % MBSR_DATA_ALIGNMENT != 0) {
        return mbsri_fail(error, MBSR_ERR_MEMORY_ALIGNMENT, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_init: memory is at %p, must be aligned to %d bytes", memory,
                          MBSR_DATA_ALIGNMENT);
    }
    mbsr_data *d;
    layout(model, memory, &d);
    d->model = model;
    d->owned = false;
    d->error = (mbsr_error){MBSR_OK, MBSR_NONE, MBSR_NONE, ""};
    d->stage = MBSRI_STAGE_NONE;
    d->t = 0.0;
    d->total_rank = -1;
    d->watching = d->framed = d->use_frame = false;
    d->alignment = 1.0;
    *data = d;
    return MBSR_OK;
}

/* Owned data: the block as the allocator gave it, a pointer-sized place for its address in front of
 * the aligned part. */
int mbsr_data_create(const mbsr_model *model, mbsr_data **data, mbsr_error *error)
{
    if (data) *data = NULL;
    if (!model || !data) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_create: %s is NULL", !model ? "model" : "data");
    }
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_create: the model is not finished");
    }
    const size_t size = mbsr_data_size(model);
    unsigned char *block =
        mbsri_allocate(&model->allocator, size + sizeof(void *) + MBSR_DATA_ALIGNMENT);
    if (!block) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_data_create: no memory for %zu bytes", size);
    }
    const size_t above = ((uintptr_t)block + sizeof(void *)) % MBSR_DATA_ALIGNMENT;
    unsigned char *aligned = block + sizeof(void *) + (above ? MBSR_DATA_ALIGNMENT - above : 0);
    memcpy(aligned - sizeof(void *), &(void *){block}, sizeof(void *));
    const int status = mbsr_data_init(model, aligned, size, data, error);
    if (status) {
        mbsri_release(&model->allocator, block);
        return status;
    }
    (*data)->owned = true;
    (*data)->allocator = model->allocator;
    return MBSR_OK;
}

void mbsr_data_destroy(mbsr_data *data)
{
    if (!data || !data->owned) return;
    const mbsr_allocator allocator = data->allocator;
    void *block;
    memcpy(&block, (unsigned char *)data - sizeof(void *), sizeof(void *));
    mbsri_release(&allocator, block);
}

const mbsr_error *mbsr_data_error(const mbsr_data *data)
{
    static const mbsr_error none = {MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "the data is NULL"};
    return data ? &data->error : &none;
}

void mbsri_data_poison(mbsr_data *d)
{
    const mbsr_model *m = d->model;
#define MBSRI_POISON(name, length)                                                                 \
    for (size_t k = 0; k < (size_t)(length); ++k) d->name[k] = NAN;
    MBSRI_DATA_ARRAYS(MBSRI_POISON)
#undef MBSRI_POISON
    for (int i = 0; i <= m->bodies; ++i) d->rank[i] = -1000;
    d->stage = MBSRI_STAGE_NONE;
    d->total_rank = -1;
}

int mbsri_enter(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage needed,
                const char *function)
{
    static const char *const stage[] = {"", "mbsr_positions", "mbsr_velocities", "mbsr_forces",
                                        "mbsr_backward"};
    if (!d) return MBSR_ERR_NULL;
    if (!m || !arguments) {
        return mbsri_fail(&d->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "%s: a required pointer is NULL", function);
    }
    if (d->model != m) {
        return mbsri_fail(&d->error, MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE,
                          "%s: the data belongs to another model", function);
    }
    if (d->stage < needed) {
        return mbsri_fail(&d->error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, "%s: call %s first",
                          function, stage[needed]);
    }
    return MBSR_OK;
}
