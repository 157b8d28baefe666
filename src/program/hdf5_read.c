/* Runs from HDF5 files: see hdf5.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"

#include "program/hdf5_texts.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* The innermost of HDF5's messages comes first. */
static herr_t first_message(unsigned number, const H5E_error2_t *error, void *to)
{
    if (number == 0) snprintf(to, HDF5_REASON, "%s", error->desc ? error->desc : "");
    return 0;
}

void hdf5_reason(char to[HDF5_REASON])
{
    to[0] = '\0';
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first_message, to);
}

/* ---- attributes ---- */

char *hdf5_get_text(hid_t of, const char *name)
{
    char *text = NULL, *copy = NULL;
    const hid_t attribute = H5Aopen(of, name, H5P_DEFAULT), type = hdf5_text_type(H5T_VARIABLE);
    const hid_t space = H5Aget_space(attribute), stored = H5Aget_type(attribute);
    const bool one = H5Sget_simple_extent_npoints(space) == 1 && H5Tis_variable_str(stored) > 0;
    if (one && H5Aread(attribute, type, &text) >= 0 && text) {
        copy = malloc(strlen(text) + 1);
        if (copy) strcpy(copy, text);
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, &text);
    }
    H5Tclose(stored);
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    return copy;
}

bool hdf5_get_int(hid_t of, const char *name, int *value)
{
    const hid_t attribute = H5Aopen(of, name, H5P_DEFAULT), space = H5Aget_space(attribute);
    const bool good =
        H5Sget_simple_extent_npoints(space) == 1 && H5Aread(attribute, H5T_NATIVE_INT, value) >= 0;
    H5Sclose(space);
    H5Aclose(attribute);
    return good;
}

/* ---- data sets ---- */

hid_t hdf5_open_column(hid_t file, const char *name, int *number, bool *bad)
{
    const hid_t set = H5Oopen(file, name, H5P_DEFAULT);
    *bad = set < 0 && H5Oexists_by_name(file, name, H5P_DEFAULT) != 0;
    if (set < 0) return H5I_INVALID_HID;
    const H5I_type_t type = H5Iget_type(set);
    const htri_t there = type == H5I_DATASET ? H5Aexists(set, "column") : 0;
    if (there > 0 && hdf5_get_int(set, "column", number)) return set;
    *bad = there != 0 || type == H5I_BADID;
    H5Oclose(set);
    return H5I_INVALID_HID;
}

typedef struct part {
    hid_t set;
    int column;
    char *name;
} part;

typedef struct parts {
    part *list;
    int count, room;
    bool bad, no_memory;
} parts;

/* Keeps what is a column. */
static herr_t take_column(hid_t file, const char *link, const H5L_info_t *info, void *user)
{
    parts *all = user;
    part new = {.name = NULL};
    (void)info;
    new.set = hdf5_open_column(file, link, &new.column, &all->bad);
    if (new.set < 0) return all->bad ? -1 : 0;
    new.name = hdf5_get_text(new.set, "name");
    if (!new.name) {
        all->bad = true;
        H5Dclose(new.set);
        return -1;
    }
    if (all->count == all->room) {
        const int room = all->room > 0 ? 2 * all->room : 64;
        part *larger = realloc(all->list, (size_t)room * sizeof *larger);
        if (!larger) {
            all->no_memory = true;
            H5Dclose(new.set);
            free(new.name);
            return -1;
        }
        all->list = larger;
        all->room = room;
    }
    all->list[all->count++] = new;
    return 0;
}

static int by_column(const void *a, const void *b)
{
    const part *left = a, *right = b;
    return (left->column > right->column) - (left->column < right->column);
}

/* Lines of a set of numbers in one dimension, -1: it is none. No file claims more than it can hold.
 */
static long count_lines(hid_t set)
{
    const hid_t space = H5Dget_space(set), type = H5Dget_type(set);
    hsize_t lines = 0;
    const hsize_t bytes = H5Dget_storage_size(set);
    const bool good = H5Sget_simple_extent_ndims(space) == 1 && H5Tget_class(type) == H5T_FLOAT &&
                      H5Sget_simple_extent_dims(space, &lines, NULL) == 1 && lines < INT_MAX &&
                      lines / 1024 <= bytes;
    H5Tclose(type);
    H5Sclose(space);
    return good ? (long)lines : -1;
}

static int check_parts(const char *path, const parts *all, table *t)
{
    if (all->no_memory) return complain(FAILED, "no memory");
    if (all->bad) return complain(NOT_READ, "%s: not all of its columns can be read", path);
    if (all->count == 0 || strcmp(all->list[0].name, "t") != 0)
        return complain(NOT_READ, "%s: the first column must be t", path);
    for (int k = 0; k < all->count; ++k) {
        const long lines = count_lines(all->list[k].set);
        if (all->list[k].column != k)
            return complain(NOT_READ, "%s: there is no column %d", path, k);
        if (k == 0) t->lines = (int)lines;
        if (lines < 0 || lines != t->lines)
            return complain(NOT_READ, "%s: column '%s' has not as many numbers as t", path,
                            all->list[k].name);
    }
    t->columns = all->count;
    return DONE;
}

static int copy_names(const parts *all, table *t)
{
    size_t size = 1;
    for (int k = 0; k < all->count; ++k) size += strlen(all->list[k].name) + 1;
    t->name = malloc((size_t)all->count * sizeof *t->name);
    char *at = t->text = malloc(size);
    if (!t->name || !t->text) return complain(FAILED, "no memory");
    for (int k = 0; k < all->count; ++k) {
        t->name[k] = strcpy(at, all->list[k].name);
        at += strlen(at) + 1;
    }
    return DONE;
}

static int copy_values(const char *path, const parts *all, table *t)
{
    const size_t lines = (size_t)t->lines, width = (size_t)t->columns;
    double *one = malloc(lines * sizeof *one + 1);
    int code = DONE;
    t->value = calloc(lines + 1, width * sizeof *t->value);
    if (!one || !t->value) code = complain(FAILED, "no memory");
    for (size_t k = 0; k < width && !code; ++k) {
        if (H5Dread(all->list[k].set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, one) < 0) {
            char reason[HDF5_REASON];
            hdf5_reason(reason);
            code = complain(NOT_READ, "%s: column '%s': %s", path, t->name[k], reason);
        }
        for (size_t l = 0; l < lines && !code; ++l) t->value[l * width + k] = one[l];
    }
    free(one);
    return code;
}

static int read_parts(const char *path, hid_t file, table *t)
{
    parts all = {.count = 0};
    if (H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, NULL, take_column, &all) < 0) all.bad = true;
    if (all.count > 1) qsort(all.list, (size_t)all.count, sizeof *all.list, by_column);
    int code = check_parts(path, &all, t);
    if (!code) code = copy_names(&all, t);
    if (!code) code = copy_values(path, &all, t);
    for (int k = 0; k < all.count; ++k) {
        H5Dclose(all.list[k].set);
        free(all.list[k].name);
    }
    free(all.list);
    return code;
}

int hdf5_read(const char *path, table *t)
{
    *t = (table){.text = NULL};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) {
        char reason[HDF5_REASON];
        hdf5_reason(reason);
        return complain(NOT_READ, "%s cannot be read: %s", path, reason);
    }
    char *format = hdf5_get_text(file, "format");
    const int code = format && strcmp(format, HDF5_FORMAT) == 0
                         ? read_parts(path, file, t)
                         : complain(NOT_READ, "%s is HDF5, but no run of mbsrank", path);
    char *hash = hdf5_get_text(file, "model_hash");
    if (hash) snprintf(t->hash, sizeof t->hash, "%s", hash);
    free(hash);
    free(format);
    H5Fclose(file);
    return code;
}
