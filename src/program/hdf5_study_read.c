/* Results of studies from HDF5, as columns: docs/study.md has the layout.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"
#include "program/hdf5_texts.h"
#include "program/study_data.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* A data set of a parameter or an output. */
typedef struct study_set {
    hid_t set;
    int place;
    char *name, *unit;
    hsize_t runs, times; /* 1: one number a run */
    double *time;        /* NULL: one number */
} study_set;

typedef struct study_sets {
    study_set *list;
    int count;
    bool bad;
} study_sets;

bool hdf5_is_study(const char *path)
{
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    char *format = file >= 0 ? hdf5_get_text(file, "format") : NULL;
    const bool good = format && strcmp(format, HDF5_STUDY_FORMAT) == 0;
    free(format);
    if (file >= 0) H5Fclose(file);
    return good;
}

/* Runs and times of a set; false: it is none of numbers. */
static bool measure_set(study_set *s)
{
    const hid_t space = H5Dget_space(s->set), type = H5Dget_type(s->set);
    hsize_t shape[2] = {0, 1};
    const int rank = H5Sget_simple_extent_ndims(space);
    const bool good = (rank == 1 || rank == 2) && H5Tget_class(type) == H5T_FLOAT &&
                      H5Sget_simple_extent_dims(space, shape, NULL) == rank && shape[0] < INT_MAX &&
                      shape[1] < INT_MAX / 2 &&
                      shape[0] * shape[1] <= H5Dget_storage_size(s->set) / 8;
    H5Tclose(type);
    H5Sclose(space);
    s->runs = shape[0];
    s->times = shape[1];
    return good;
}

static bool read_times_of(hid_t file, const char *link, study_set *s)
{
    char name[HDF5_LINK + 16];
    study_set times = {.set = H5I_INVALID_HID};
    if (s->times == 1) return true;
    snprintf(name, sizeof name, "times of %.230s", link);
    times.set = H5Dopen2(file, name, H5P_DEFAULT);
    bool good = times.set >= 0 && measure_set(&times) && times.runs == s->times;
    if (good) s->time = calloc((size_t)s->times, sizeof *s->time);
    good = good && s->time &&
           H5Dread(times.set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, s->time) >= 0;
    H5Dclose(times.set);
    return good;
}

static void free_set(study_set *s)
{
    H5Dclose(s->set);
    free(s->name);
    free(s->unit);
    free(s->time);
}

static herr_t take_set(hid_t file, const char *link, const H5L_info_t *info, void *user)
{
    study_sets *all = user;
    study_set new = {.name = NULL};
    (void)info;
    new.set = hdf5_open_column(file, link, &new.place, &all->bad);
    if (new.set < 0) return all->bad ? -1 : 0;
    new.name = hdf5_get_text(new.set, "name");
    new.unit = hdf5_get_text(new.set, "unit");
    study_set *larger = realloc(all->list, ((size_t)all->count + 1) * sizeof *larger);
    if (larger) all->list = larger;
    all->bad =
        !larger || !new.name || !new.unit || !measure_set(&new) || !read_times_of(file, link, &new);
    if (all->bad)
        free_set(&new);
    else
        all->list[all->count++] = new;
    return all->bad ? -1 : 0;
}

static int by_place(const void *a, const void *b)
{
    const study_set *left = a, *right = b;
    return (left->place > right->place) - (left->place < right->place);
}

/* Names and units behind each other in t->text. */
static bool copy_study_names(const study_sets *all, study_data *d)
{
    size_t size = 8, width = 1;
    for (int k = 0; k < all->count; ++k) {
        const study_set *s = all->list + k;
        width += (size_t)s->times;
        size += (size_t)s->times * (strlen(s->name) + 40) + strlen(s->unit) + 1;
    }
    char *at = d->t.text = malloc(size);
    d->t.name = malloc(width * sizeof *d->t.name);
    d->unit = calloc(width, sizeof *d->unit);
    if (!at || !d->t.name || !d->unit) return false;
    d->t.name[d->t.columns++] = strcpy(at, "run");
    at += 4;
    for (int k = 0; k < all->count; ++k) {
        const study_set *s = all->list + k;
        char *unit = strcpy(at, s->unit);
        at += strlen(at) + 1;
        for (hsize_t l = 0; l < s->times; ++l) {
            d->unit[d->t.columns] = unit;
            d->t.name[d->t.columns++] = at;
            if (s->time)
                at += sprintf(at, "%s %g", s->name, s->time[l]) + 1;
            else
                at += sprintf(at, "%s", s->name) + 1;
        }
    }
    return true;
}

static int copy_study_values(const char *path, const study_sets *all, study_data *d)
{
    table *t = &d->t;
    const hsize_t runs = all->list[0].runs;
    const size_t width = (size_t)t->columns;
    size_t first = 1;
    t->lines = (int)runs;
    t->value = calloc((size_t)runs * width + 1, sizeof *t->value);
    if (!t->value) return complain(FAILED, "no memory");
    for (hsize_t run = 0; run < runs; ++run) t->value[run * width] = (double)run;
    for (int k = 0; k < all->count; ++k) {
        const study_set *s = all->list + k;
        double *numbers = calloc((size_t)(s->runs * s->times) + 1, sizeof *numbers);
        const bool good =
            numbers && s->runs == runs &&
            H5Dread(s->set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers) >= 0;
        for (hsize_t run = 0; run < runs && good; ++run)
            for (hsize_t l = 0; l < s->times; ++l)
                t->value[run * width + first + l] = numbers[run * s->times + l];
        free(numbers);
        if (!good) return complain(NOT_READ, "%s: '%s' cannot be read", path, s->name);
        first += (size_t)s->times;
    }
    return DONE;
}

int hdf5_read_study(const char *path, study_data *d)
{
    study_sets all = {.count = 0};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) return complain(NOT_READ, "%s cannot be read", path);
    if (H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, NULL, take_set, &all) < 0) all.bad = true;
    if (all.count > 1) qsort(all.list, (size_t)all.count, sizeof *all.list, by_place);
    int code =
        all.bad || all.count == 0 ? complain(NOT_READ, "%s has no results of a study", path) : DONE;
    if (!code && !copy_study_names(&all, d)) code = complain(FAILED, "no memory");
    if (!code) code = copy_study_values(path, &all, d);
    for (int k = 0; k < all.count; ++k) free_set(all.list + k);
    free(all.list);
    H5Fclose(file);
    return code;
}
