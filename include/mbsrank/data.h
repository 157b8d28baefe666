/* All mutable memory of one evaluation of a model, in one block.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_DATA_H
#define MBSRANK_DATA_H

#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_data mbsr_data;

/* Several data of one model may be used by several threads at once; one data by one thread at a
 * time. */

#define MBSR_DATA_ALIGNMENT 64

/* Bytes that mbsr_data_init needs for this model; 0 if the model is NULL or not finished. */
MBSR_API size_t mbsr_data_size(const mbsr_model *model);

/* Lays a data object out in the caller's memory, which must be aligned to MBSR_DATA_ALIGNMENT, at
 * least mbsr_data_size bytes large, and stay in place as long as the object is used. Nothing needs
 * to be freed. *error may be NULL. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_MEMORY_SIZE, MBSR_ERR_MEMORY_ALIGNMENT. */
MBSR_API int mbsr_data_init(const mbsr_model *model, void *memory, size_t size, mbsr_data **data,
                            mbsr_error *error);

/* Makes data in memory from the model's allocator. On failure *data is NULL.
 * Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_data_create(const mbsr_model *model, mbsr_data **data, mbsr_error *error);

/* Frees what mbsr_data_create made; does nothing for NULL or for a data in the caller's memory. */
MBSR_API void mbsr_data_destroy(mbsr_data *data);

/* The last failure of a function on this data; never NULL. */
MBSR_API const mbsr_error *mbsr_data_error(const mbsr_data *data);

#ifdef __cplusplus
}
#endif

#endif
