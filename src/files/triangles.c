/* Triangles of meshes, for callers that draw: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mesh.h"

#include <stdio.h>

typedef struct counted {
    mbsr_triangle_fn take;
    void *user;
    bool some;
} counted;

static void count(void *user, const double corner[9])
{
    counted *c = user;
    c->some = true;
    c->take(c->user, corner);
}

static int fail(mbsr_error *error, int status, const char *why)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    snprintf(error->text, sizeof error->text, "mbsr_mesh_triangles: %s", why);
    return status;
}

int mbsr_mesh_triangles(const char *text, size_t size, mbsr_triangle_fn take, void *user,
                        mbsr_error *error)
{
    counted c = {take, user, false};
    const mbsr_allocator memory = {0};
    mbsri_arena arena;
    if (!text || !take) return fail(error, MBSR_ERR_NULL, text ? "take is NULL" : "text is NULL");
    mbsri_arena_open(&arena, &memory);
    const char *wrong = mbsri_mesh_read(&arena, text, size, count, &c);
    const bool failed = arena.failed;
    mbsri_arena_close(&arena);
    if (failed) return fail(error, MBSR_ERR_NO_MEMORY, "there is no memory");
    if (!wrong && !c.some) wrong = "the mesh has no triangles";
    return wrong ? fail(error, MBSR_ERR_FILE, wrong) : MBSR_OK;
}
