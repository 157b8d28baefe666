/* The data block: one layout that both computes the size and places the arrays.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/data.h"

#include "base/error.h"
#include "base/memory.h"
#include "fronts/fronts.h"
#include "recursion/exact.h"
#include "sweeps/loops.h"

#include <mbsrank/driver.h>
#include <mbsrank/parameters.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

static size_t scratch_size(const mbsr_model *m)
{
    const size_t d = (size_t)m->most.d;
    const size_t products = 15 * d * d + 16 * d + 8;
    const size_t lapack = (size_t)m->most.lapack_work;
    return products + (lapack > 6 * d ? lapack : 6 * d);
}

/* Whether the steps of recursion/ work in these data; in lean data only where bodies are in the
 * sweeps. */
static bool has_steps(const mbsr_model *m, bool lean)
{
    return !lean || m->in_sweeps.bodies > 1;
}

static size_t sincos_size(const mbsr_model *m)
{
    return m->tree.evaluated ? 2 * (size_t)m->nq : 0;
}

static size_t loop_store_size(const mbsr_model *m)
{
    return m->tree.evaluated && m->tree.evaluated->loops ? m->tree.evaluated->loops->doubles : 0;
}

/* ARRAY(name, length) of all arrays, with the lengths that they have in these data. */
#define MBSRI_ARRAYS(ARRAY) MBSRI_DATA_ARRAYS(ARRAY, ARRAY##_LEAN, ARRAY##_FULL)
#define MBSRI_PLACE_LEAN(name, unit) MBSRI_PLACE(name, lean ? m->in_sweeps.unit : m->size.unit)
#define MBSRI_PLACE_FULL(name, length) MBSRI_PLACE(name, lean ? 0 : (size_t)(length))
#define MBSRI_POISON_LEAN(name, unit) MBSRI_POISON(name, lean ? m->in_sweeps.unit : m->size.unit)
#define MBSRI_POISON_FULL(name, length) MBSRI_POISON(name, lean ? 0 : (size_t)(length))

/* Places the data object and its arrays in `base`, or with base == NULL only returns the size. */
static size_t lay_out_data(const mbsr_model *m, bool lean, unsigned char *base, mbsr_data **data)
{
    mbsr_data counted;
    size_t used = 0;
    const size_t bodies = (size_t)m->bodies + 1;
    mbsr_data *d = mbsri_take_bytes(base, &used, sizeof *d);
    if (!d) d = &counted;
    d->rank = mbsri_take_bytes(base, &used, bodies * sizeof *d->rank);
    d->watch.rank = mbsri_take_bytes(base, &used, bodies * sizeof *d->watch.rank);
    d->frame.rank = mbsri_take_bytes(base, &used, lean ? 0 : bodies * sizeof *d->frame.rank);
    d->element.off = mbsri_take_bytes(
        base, &used, (m->forces.count + m->elements.idle) * sizeof *d->element.off);
    d->carries = mbsri_take_bytes(base, &used, bodies * sizeof *d->carries);
    d->factors.rows = mbsri_take_bytes(base, &used, bodies * sizeof *d->factors.rows);
    d->apart = mbsri_take_bytes(base, &used, m->order.grouped ? bodies * sizeof *d->apart : 0);
    d->dropped = mbsri_take_bytes(base, &used, (size_t)m->rows * sizeof *d->dropped);
    d->fronts.memory = mbsri_take_bytes(base, &used, mbsri_fronts_bytes(m));
    const size_t exact = has_steps(m, lean) ? mbsri_exact_room(m) : 0;
    d->exact_work = mbsri_take_bytes(base, &used, exact * sizeof *d->exact_work);
    d->pivots = mbsri_take_bytes(base, &used, (size_t)m->most.d * sizeof *d->pivots);
    d->element.bodies =
        mbsri_take_bytes(base, &used, (size_t)m->most.element_bodies * sizeof *d->element.bodies);
    d->element.text = mbsri_take_bytes(base, &used, MBSR_TEXT_SIZE);
    d->element.memory = mbsri_take_bytes(base, &used, m->elements.memory);
    d->element.pairs =
        mbsri_take_bytes(base, &used, (size_t)m->most.pairs * sizeof *d->element.pairs);
    if (m->tree.evaluated) {
        d->sweep.state = mbsri_take_bytes(base, &used, bodies * sizeof *d->sweep.state);
        const mbsri_sweeps *const tree[] = {m->tree.plain, m->tree.newton, m->tree.evaluated};
        size_t depth = 0, multi = 0;
        for (int k = 0; k < 3; ++k) {
            if (!tree[k]) continue;
            if ((size_t)tree[k]->depth > depth) depth = (size_t)tree[k]->depth;
            if ((size_t)tree[k]->multi > multi) multi = (size_t)tree[k]->multi;
        }
        d->sweep.multi = mbsri_take_bytes(base, &used, multi * sizeof *d->sweep.multi);
        d->sweep.stack = mbsri_take_bytes(base, &used, depth * sizeof *d->sweep.stack);
        d->sweep.noise = mbsri_take_bytes(base, &used, depth * sizeof *d->sweep.noise);
        d->sweep.flows = mbsri_take_bytes(base, &used, depth * sizeof *d->sweep.flows);
        const size_t loads = m->tree.evaluated->body_forces ? bodies : 0;
        d->sweep.load = mbsri_take_bytes(base, &used, loads * sizeof *d->sweep.load);
    }
#define MBSRI_PLACE(name, length)                                                                  \
    d->name = mbsri_take_bytes(base, &used, (size_t)(length) * sizeof(double));
    MBSRI_ARRAYS(MBSRI_PLACE)
#undef MBSRI_PLACE
    if (data) *data = d;
    return used;
}

static const char *name_of_function(bool lean, const char *full, const char *thin)
{
    return lean ? thin : full;
}

/* Models that lean data cannot be made for. */
static int check_model(const mbsr_model *model, bool lean, const char *function, mbsr_error *error)
{
    if (!model->finished) {
        return mbsri_fail(error, MBSR_ERR_UNFINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is not finished", function);
    }
    if (lean && !model->tree.plain) {
        return mbsri_fail(error, MBSR_ERR_SPACE, MBSR_NONE, MBSR_NONE,
                          "%s: %s, which alone lean data serves", function,
                          model->rows > 0 ? "the model has closures, and no sweeps in vector code"
                                          : "this library is built without sweeps in vector code");
    }
    return MBSR_OK;
}

static size_t size_of_data(const mbsr_model *model, bool lean)
{
    if (!model || !model->finished || (lean && !model->tree.plain)) return 0;
    return lay_out_data(model, lean, NULL, NULL);
}

static int init(const mbsr_model *model, bool lean, void *memory, size_t size, mbsr_data **data,
                mbsr_error *error)
{
    const char *function = name_of_function(lean, "mbsr_data_init", "mbsr_data_init_lean");
    if (data) *data = NULL;
    if (!model || !memory || !data) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          !model    ? "model"
                          : !memory ? "memory"
                                    : "data");
    }
    const int status = check_model(model, lean, function, error);
    if (status) return status;
    const size_t needed = size_of_data(model, lean);
    if (size < needed) {
        return mbsri_fail(error, MBSR_ERR_MEMORY_SIZE, MBSR_NONE, MBSR_NONE,
                          "%s: size is %zu bytes, this model needs %zu", function, size, needed);
    }
    if ((uintptr_t)memory % MBSR_DATA_ALIGNMENT != 0) {
        return mbsri_fail(error, MBSR_ERR_MEMORY_ALIGNMENT, MBSR_NONE, MBSR_NONE,
                          "%s: memory is at %p, must be aligned to %d bytes", function, memory,
                          MBSR_DATA_ALIGNMENT);
    }
    mbsr_data *d;
    lay_out_data(model, lean, memory, &d);
    d->model = model;
    d->lean = lean;
    d->owned = false;
    d->own = NULL;
    d->error = (mbsr_error){MBSR_OK, MBSR_NONE, MBSR_NONE, ""};
    d->stage = MBSRI_STAGE_NONE;
    d->t = 0.0;
    d->total_rank = -1;
    d->pending = MBSRI_PENDING_NONE;
    d->split = NULL;
    d->watch.active = d->frame.known = d->frame.used = d->keep_scale = d->exactly = false;
    d->accelerated = d->single = d->lambda_known = d->factors.allowed = d->fronts.taken = false;
    d->armature = NULL;
    for (int k = 0; k < model->rows; ++k) d->dropped[k] = false;
    for (size_t k = 0; k < model->forces.count + model->elements.idle; ++k)
        d->element.off[k] = false;
    memset(d->element.memory, 0, model->elements.memory);
    d->frame.alignment = 1.0;
    for (int i = 0; i <= model->bodies; ++i) d->factors.rows[i] = -1;
    for (int i = model->live + 1; i <= model->bodies; ++i)
        d->rank[i] = 0; /* the sweeps pass them by */
    for (int i = 0; i <= model->bodies && model->order.grouped; ++i) d->apart[i] = false;
    *data = d;
    return MBSR_OK;
}

/* In memory of the caller's, who may use it for something else without a word. */
static int init_given(const mbsr_model *model, bool lean, void *memory, size_t size,
                      mbsr_data **data, mbsr_error *error)
{
    const int status = init(model, lean, memory, size, data, error);
    if (!status) mbsri_fence(memory, size, true);
    return status;
}

/* Owned data: the block as the allocator gave it, a pointer-sized place for its address in front of
 * the aligned part. */
static int create_data(const mbsr_model *model, bool lean, mbsr_data **data, mbsr_error *error)
{
    const char *function = name_of_function(lean, "mbsr_data_create", "mbsr_data_create_lean");
    if (data) *data = NULL;
    if (!model || !data) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: %s is NULL", function,
                          !model ? "model" : "data");
    }
    int status = check_model(model, lean, function, error);
    if (status) return status;
    const size_t size = size_of_data(model, lean);
    unsigned char *block =
        mbsri_allocate(&model->allocator, size + sizeof(void *) + MBSR_DATA_ALIGNMENT);
    if (!block) {
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %zu bytes", function, size);
    }
    const size_t above = ((uintptr_t)block + sizeof(void *)) % MBSR_DATA_ALIGNMENT;
    unsigned char *aligned = block + sizeof(void *) + (above ? MBSR_DATA_ALIGNMENT - above : 0);
    memcpy(aligned - sizeof(void *), &(void *){block}, sizeof(void *));
    status = init(model, lean, aligned, size, data, error);
    if (status) {
        mbsri_release(&model->allocator, block);
        return status;
    }
    (*data)->owned = true;
    (*data)->allocator = model->allocator;
    return MBSR_OK;
}

size_t mbsr_data_size(const mbsr_model *model)
{
    return size_of_data(model, false);
}

size_t mbsr_data_size_lean(const mbsr_model *model)
{
    return size_of_data(model, true);
}

int mbsr_data_init(const mbsr_model *model, void *memory, size_t size, mbsr_data **data,
                   mbsr_error *error)
{
    return init_given(model, false, memory, size, data, error);
}

int mbsr_data_init_lean(const mbsr_model *model, void *memory, size_t size, mbsr_data **data,
                        mbsr_error *error)
{
    return init_given(model, true, memory, size, data, error);
}

int mbsr_data_create(const mbsr_model *model, mbsr_data **data, mbsr_error *error)
{
    return create_data(model, false, data, error);
}

int mbsr_data_create_lean(const mbsr_model *model, mbsr_data **data, mbsr_error *error)
{
    return create_data(model, true, data, error);
}

void mbsr_data_destroy(mbsr_data *data)
{
    if (!data || !data->owned) return;
    const mbsr_allocator allocator = data->allocator;
    mbsr_model *own = data->own;
    void *block;
    memcpy(&block, (unsigned char *)data - sizeof(void *), sizeof(void *));
    mbsri_release(&allocator, block);
    mbsr_model_destroy(own);
}

const mbsr_model *mbsr_data_model(const mbsr_data *data)
{
    return data ? data->model : NULL;
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
    const bool lean = d->lean;
    MBSRI_ARRAYS(MBSRI_POISON)
#undef MBSRI_POISON
    for (int i = 0; i <= m->live; ++i) d->rank[i] = -1000;
    const size_t loads = m->tree.plain && m->tree.newton->body_forces ? (size_t)m->bodies + 1 : 0;
    for (size_t i = 0; i < loads; ++i)
        for (int k = 0; k < 4; ++k) d->sweep.load[i].r[k] = d->sweep.load[i].arm[k] = NAN;
    d->stage = MBSRI_STAGE_NONE;
    d->pending = MBSRI_PENDING_NONE;
    d->accelerated = d->frame.known = false;
    d->total_rank = -1;
}
