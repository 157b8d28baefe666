/* Triangles of meshes, for callers that draw: see files.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/mesh.h"

#include <math.h>
#include <stdio.h>

typedef struct checked {
    mbsr_triangle_fn take;
    void *user;
    bool some, infinite;
} checked;

static void check(void *user, const double corner[9])
{
    checked *c = user;
    c->some = true;
    for (int k = 0; k < 9; ++k) c->infinite = c->infinite || !isfinite(corner[k]);
    if (!c->infinite) c->take(c->user, corner);
}

static int fail(mbsr_error *error, int status, const char *name, const char *why)
{
    if (!error) return status;
    *error = (mbsr_error){.status = status, .body = MBSR_NONE, .force = MBSR_NONE};
    snprintf(error->text, sizeof error->text, "mesh '%.150s': %s", name ? name : "", why);
    return status;
}

int mbsr_mesh_triangles(const char *text, size_t size, const char *name, mbsr_triangle_fn take,
                        void *user, mbsr_error *error)
{
    checked c = {.take = take, .user = user};
    const mbsr_allocator memory = {0};
    mbsri_arena arena;
    if (!text || !take)
        return fail(error, MBSR_ERR_NULL, name, text ? "take is NULL" : "text is NULL");
    mbsri_arena_open(&arena, &memory);
    const char *wrong = mbsri_mesh_read(&arena, text, size, check, &c);
    const bool failed = arena.failed;
    mbsri_arena_close(&arena);
    if (failed) return fail(error, MBSR_ERR_NO_MEMORY, name, "there is no memory");
    if (!wrong && !c.some) wrong = "it has no triangles";
    if (!wrong && c.infinite) wrong = "a coordinate is not finite";
    return wrong ? fail(error, MBSR_ERR_FILE, name, wrong) : MBSR_OK;
}
