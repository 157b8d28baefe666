/* What limits an expansion of xacro: see xacro.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/xacro.h"

#include <string.h>

bool mbsri_xacro_spend(mbsri_xacro *x, size_t work)
{
    if (work > (size_t)MBSRI_XACRO_WORK - x->work)
        return mbsri_xacro_refuse(x, "the expansion is too large");
    x->work += work;
    return true;
}

bool mbsri_xacro_enter(mbsri_xacro *x)
{
    if (x->depth == MBSRI_XACRO_DEPTH)
        return mbsri_xacro_refuse(x, "macros, properties or elements call each other too deeply");
    ++x->depth;
    return true;
}

void mbsri_xacro_leave(mbsri_xacro *x)
{
    --x->depth;
}

void *mbsri_xacro_take(mbsri_xacro *x, size_t size)
{
    return mbsri_xacro_spend(x, size + 16) ? mbsri_arena_take(x->s->arena, size) : NULL;
}

char *mbsri_xacro_copy(mbsri_xacro *x, const char *text, size_t length)
{
    return mbsri_xacro_spend(x, length + 16) ? mbsri_arena_text(x->s->arena, text, length) : NULL;
}

const char *mbsri_xacro_argument(const mbsri_xacro *x, const char *name)
{
    const mbsr_xacro_argument *a = x->arguments.items;
    for (int k = 0; k < x->arguments.count; ++k) {
        if (strcmp(a[k].name, name) == 0) return a[k].value;
    }
    return NULL;
}

const char *mbsri_xacro_beside(mbsri_xacro *x, const char *path)
{
    if (path[0] == '/') return path;
    const size_t folder = strlen(x->folder), length = strlen(path);
    char *whole = mbsri_xacro_take(x, folder + length + 1);
    if (!whole) return NULL;
    memcpy(whole, x->folder, folder);
    memcpy(whole + folder, path, length);
    return whole;
}
