/* Triangles of meshes, for callers that draw: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mesh.h"

#include <mbsrank/files.h>

#include <stdio.h>
#include <string.h>

static int refuse_triangles(mbsr_error *error, int status, const char *name, const char *why)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    snprintf(error->text, sizeof error->text, "mesh '%.150s': %s", name, why);
    return status;
}

int mbsr_mesh_triangles(const char *text, size_t size, const char *name, mbsr_triangle_fn take,
                        void *user, mbsr_error *error)
{
    const mbsr_allocator memory = {0};
    mbsri_arena arena;
    mbsri_list list = {.count = 0};
    if (!name) name = "";
    if (!text || !take)
        return refuse_triangles(error, MBSR_ERR_NULL, name, text ? "take is NULL" : "text is NULL");
    mbsri_arena_open(&arena, &memory);
    const char *wrong = mbsri_mesh_read(&arena, text, size, name, &list);
    if (!wrong && list.count == 0) wrong = "it has no triangles";
    const int status = arena.failed ? MBSR_ERR_NO_MEMORY : wrong ? MBSR_ERR_FILE : MBSR_OK;
    const mbsri_triangle *triangle = list.items;
    for (int k = 0; k < list.count && !status; ++k) {
        double corner[9];
        memcpy(corner, triangle[k].corner, sizeof corner);
        take(user, corner);
    }
    mbsri_arena_close(&arena);
    return status ? refuse_triangles(error, status, name, wrong) : MBSR_OK;
}
