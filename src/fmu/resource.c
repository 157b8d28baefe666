/* The model from the folder of the resources: see resource.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/resource.h"

#include "base/error.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* No model is larger. */
enum { MOST_BYTES = 1 << 30 };

static unsigned char *read_all(FILE *from, size_t *size)
{
    size_t room = 1 << 16;
    unsigned char *data = malloc(room);
    *size = 0;
    while (data) {
        *size += fread(data + *size, 1, room - *size, from);
        if (*size < room) break;
        unsigned char *larger = room < MOST_BYTES ? realloc(data, 2 * room) : NULL;
        if (!larger) free(data);
        data = larger;
        room *= 2;
    }
    return data;
}

unsigned char *mbsri_read_resource(const char *folder, size_t *size)
{
    static const char name[] = "model.mbsrank";
    const size_t length = strlen(folder);
    const bool ends = length > 0 && (folder[length - 1] == '/' || folder[length - 1] == '\\');
    char *path = malloc(length + sizeof name + 1);
    if (!path) return NULL;
    mbsri_print(path, length + sizeof name + 1, "%s%s%s", folder, ends ? "" : "/", name);
    FILE *from = fopen(path, "rb");
    unsigned char *data = from ? read_all(from, size) : NULL;
    if (from) fclose(from);
    free(path);
    return data;
}
