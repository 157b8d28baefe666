/* Runs become HDF5 files: see hdf5.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"

#include "program/hdf5_texts.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

struct hdf5_run {
    const char *path;
    hid_t file;
    hid_t *set; /* data set of t and of each column */
    int sets;
    double *block; /* lines that are not in the file yet: room of each set, one after the other */
    int waiting, room;
    hsize_t lines; /* in the file */
    time_t flushed;
    bool bad;
    char reason[HDF5_REASON]; /* text of the first failure */
};

enum { MOST_ROOM = 1024, LEAST_ROOM = 16, BLOCK = 1 << 21, SECONDS = 2 };

static void note_failure(hdf5_run *run, bool good)
{
    if (!good && !run->bad) hdf5_reason(run->reason);
    run->bad = run->bad || !good;
}

/* ---- attributes ---- */

bool hdf5_put(hid_t of, const char *name, hid_t stored, hid_t given, const void *value)
{
    const hid_t space = H5Screate(H5S_SCALAR),
                made = H5Acreate2(of, name, stored, space, H5P_DEFAULT, H5P_DEFAULT);
    const bool good = made >= 0 && H5Awrite(made, given, value) >= 0;
    H5Aclose(made);
    H5Sclose(space);
    return good;
}

bool hdf5_put_text(hid_t of, const char *name, const char *text)
{
    const hid_t type = hdf5_text_type(H5T_VARIABLE);
    const bool good = hdf5_put(of, name, type, type, &text);
    H5Tclose(type);
    return good;
}

void hdf5_text(hdf5_run *run, const char *name, const char *text)
{
    note_failure(run, hdf5_put_text(run->file, name, text));
}

void hdf5_number(hdf5_run *run, const char *name, double number)
{
    note_failure(run, hdf5_put(run->file, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &number));
}

/* ---- data sets ---- */

void hdf5_link(hid_t file, int k, const char *name, char to[HDF5_LINK])
{
    const size_t room = HDF5_LINK, left = room - 32;
    size_t length = strlen(name) < left ? strlen(name) : left;
    memcpy(to, name, length);
    to[length] = '\0';
    for (char *s = to; *s; ++s)
        if (*s == '/') *s = ':';
    if (strcmp(to, ".") == 0) *to = ':';
    if (H5Lexists(file, to, H5P_DEFAULT) > 0)
        length += (size_t)snprintf(to + length, room - length, "#%d", k);
    while (length + 1 < room && H5Lexists(file, to, H5P_DEFAULT) > 0)
        to[length++] = '#', to[length] = '\0';
}

static void add_set(hdf5_run *run, int k, const char *name, const char *unit)
{
    const hsize_t none = 0, endless = H5S_UNLIMITED, chunk = (hsize_t)run->room;
    char link[HDF5_LINK];
    const hid_t space = H5Screate_simple(1, &none, &endless), how = H5Pcreate(H5P_DATASET_CREATE);
    hdf5_link(run->file, k, name, link);
    H5Pset_chunk(how, 1, &chunk);
    run->set[k] = H5Dcreate2(run->file, link, H5T_IEEE_F64LE, space, H5P_DEFAULT, how, H5P_DEFAULT);
    note_failure(run, run->set[k] >= 0);
    H5Pclose(how);
    H5Sclose(space);
    run->sets = k + 1;
    if (run->bad) return;
    note_failure(run, hdf5_put(run->set[k], "column", H5T_STD_I32LE, H5T_NATIVE_INT, &k));
    note_failure(run, hdf5_put_text(run->set[k], "name", name));
    note_failure(run, hdf5_put_text(run->set[k], "unit", unit));
}

/* How many lines are collected: a good chunk of a file, and not too much memory. */
static int room_for(int sets, double lines)
{
    const int share = BLOCK / sets, most = lines < MOST_ROOM ? (int)lines : MOST_ROOM;
    return share > most ? most : share < LEAST_ROOM ? LEAST_ROOM : share;
}

int hdf5_create(const char *path, const columns *c, double lines, hdf5_run **to)
{
    const int sets = c->count + 1;
    hdf5_run *run = *to = calloc(1, sizeof *run);
    if (!run) return complain(FAILED, "no memory");
    *run = (hdf5_run){.path = path, .file = H5I_INVALID_HID, .room = room_for(sets, lines)};
    run->set = calloc((size_t)sets, sizeof *run->set);
    run->block = calloc((size_t)sets * (size_t)run->room, sizeof *run->block);
    if (!run->set || !run->block) return complain(FAILED, "no memory");
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    run->file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    note_failure(run, run->file >= 0);
    if (run->bad) return FAILED;
    hdf5_text(run, "format", HDF5_FORMAT);
    hdf5_text(run, "version", mbsr_version());
    add_set(run, 0, "t", "s");
    for (int k = 1; k < sets && !run->bad; ++k)
        add_set(run, k, c->list[k - 1].name, c->list[k - 1].unit);
    run->flushed = time(NULL);
    return run->bad ? FAILED : DONE;
}

/* ---- lines ---- */

static bool append(hid_t set, hsize_t at, hsize_t count, const double *values)
{
    const hsize_t end = at + count;
    if (H5Dset_extent(set, &end) < 0) return false;
    const hid_t there = H5Dget_space(set), here = H5Screate_simple(1, &count, NULL);
    const bool good = H5Sselect_hyperslab(there, H5S_SELECT_SET, &at, NULL, &count, NULL) >= 0 &&
                      H5Dwrite(set, H5T_NATIVE_DOUBLE, here, there, H5P_DEFAULT, values) >= 0;
    H5Sclose(here);
    H5Sclose(there);
    return good;
}

static void write_block(hdf5_run *run)
{
    for (int k = 0; k < run->sets && run->waiting > 0 && !run->bad; ++k) {
        const double *values = run->block + (size_t)k * (size_t)run->room;
        note_failure(run, append(run->set[k], run->lines, (hsize_t)run->waiting, values));
    }
    note_failure(run, H5Fflush(run->file, H5F_SCOPE_GLOBAL) >= 0);
    run->lines += (hsize_t)run->waiting;
    run->waiting = 0;
    run->flushed = time(NULL);
}

int hdf5_line(hdf5_run *run, const double *row)
{
    for (int k = 0; k < run->sets; ++k)
        run->block[(size_t)k * (size_t)run->room + (size_t)run->waiting] = row[k];
    ++run->waiting;
    if (run->waiting == run->room || time(NULL) - run->flushed >= SECONDS) write_block(run);
    return run->bad ? FAILED : DONE;
}

int hdf5_close(hdf5_run *run)
{
    if (run->file >= 0 && !run->bad) write_block(run);
    for (int k = 0; k < run->sets; ++k) H5Dclose(run->set[k]);
    if (run->file >= 0) note_failure(run, H5Fclose(run->file) >= 0);
    const int code =
        run->bad ? complain(FAILED, "%s cannot be written: %s", run->path, run->reason) : DONE;
    free(run->set);
    free(run->block);
    free(run);
    return code;
}

/* ---- matrices ---- */

static bool put_matrix(hid_t file, const hdf5_matrix *m)
{
    const size_t rows = (size_t)m->rows, width = (size_t)m->columns;
    const hsize_t size[2] = {rows, width};
    double *by_rows = calloc(rows * width + 1, sizeof *by_rows);
    if (!by_rows) return false;
    for (size_t i = 0; i < rows; ++i)
        for (size_t j = 0; j < width; ++j) by_rows[i * width + j] = m->x[j * rows + i];
    const hid_t space = H5Screate_simple(2, size, NULL),
                set = H5Dcreate2(file, m->name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT,
                                 H5P_DEFAULT);
    const bool good =
        set >= 0 && H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, by_rows) >= 0;
    if (set >= 0) H5Dclose(set);
    H5Sclose(space);
    free(by_rows);
    return good;
}

int hdf5_matrices(const char *path, int count, const hdf5_matrix *list)
{
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    bool good = file >= 0 && hdf5_put_text(file, "version", mbsr_version());
    for (int k = 0; k < count && good; ++k) good = put_matrix(file, list + k);
    char reason[HDF5_REASON] = "";
    if (!good) hdf5_reason(reason);
    if (file >= 0) good = H5Fclose(file) >= 0 && good;
    return good ? DONE : complain(FAILED, "%s cannot be written: %s", path, reason);
}
