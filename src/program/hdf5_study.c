/* Results of a study as HDF5: docs/study.md has the layout.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"
#include "program/hdf5_texts.h"
#include "program/study_results.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* A file that is being written. */
typedef struct study_file {
    const study_results *results;
    hid_t file, statistics;
    bool bad;
    char reason[HDF5_REASON]; /* of the first failure */
} study_file;

static void note_set(study_file *f, bool good)
{
    if (!good && !f->bad) hdf5_reason(f->reason);
    f->bad = f->bad || !good;
}

/* A set of its shape, without the time of its making: the same study gives the same bytes. To be
 * closed. */
static hid_t put_set(study_file *f, hid_t in, const char *name, int rank, const hsize_t *shape,
                     hid_t stored, hid_t given, const void *data)
{
    const hid_t space = H5Screate_simple(rank, shape, NULL), how = H5Pcreate(H5P_DATASET_CREATE);
    note_set(f, H5Pset_obj_track_times(how, false) >= 0);
    const hid_t set = H5Dcreate2(in, name, stored, space, H5P_DEFAULT, how, H5P_DEFAULT);
    note_set(f, set >= 0 && H5Dwrite(set, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
    H5Pclose(how);
    H5Sclose(space);
    return set;
}

/* What a set is, by attributes. */
static void describe_set(study_file *f, hid_t set, const char *kind, const char *name,
                         const char *unit)
{
    note_set(f, hdf5_put_text(set, "kind", kind));
    note_set(f, hdf5_put_text(set, "name", name));
    note_set(f, hdf5_put_text(set, "unit", unit));
}

static void put_parameters(study_file *f)
{
    const study_results *r = f->results;
    const hsize_t runs = (hsize_t)r->runs;
    for (int k = 0; k < r->work->study->parameters && !f->bad; ++k) {
        const char *name = r->work->study->parameter[k].name;
        mbsr_parameter known;
        char link[HDF5_LINK];
        mbsr_parameter_get(r->work->list, r->work->which[k], &known);
        hdf5_link(f->file, k, name, link);
        const hid_t set = put_set(f, f->file, link, 1, &runs, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                  r->parameter + k * r->runs);
        describe_set(f, set, "parameter", name, known.unit);
        note_set(f, hdf5_put(set, "column", H5T_STD_I32LE, H5T_NATIVE_INT, &k));
        H5Dclose(set);
    }
}

/* Statistics of an output, number by number. */
static void put_statistics(study_file *f, const mbsr_study_output *o, const char *link,
                           double *scratch)
{
    enum { COLUMNS = 8 };
    const hsize_t shape[2] = {(hsize_t)o->count, COLUMNS};
    double *all = calloc((size_t)o->count * COLUMNS, sizeof *all);
    if (!all) {
        note_set(f, false);
        return;
    }
    for (int l = 0; l < o->count; ++l) {
        const study_statistics s = results_statistics(f->results, o->first + l, scratch);
        const double row[COLUMNS] = {(double)s.count, s.mean,   s.deviation, s.least,
                                     s.low,           s.median, s.high,      s.most};
        memcpy(all + l * COLUMNS, row, sizeof row);
    }
    const hid_t set =
        put_set(f, f->statistics, link, 2, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, all);
    note_set(f, hdf5_put_text(set, "columns", "count mean deviation least 5% median 95% most"));
    H5Dclose(set);
    free(all);
}

/* runs, or runs x times. */
static void put_output(study_file *f, int k, double *transposed)
{
    const study_results *r = f->results;
    const mbsr_study_output *o = r->work->study->output + k;
    const hsize_t shape[2] = {(hsize_t)r->runs, (hsize_t)o->count}, times = (hsize_t)o->times;
    const int place = r->work->study->parameters + k;
    char name[OUTPUT_NAME], link[HDF5_LINK];
    for (int l = 0; l < o->count; ++l) {
        for (long run = 0; run < r->runs; ++run)
            transposed[run * o->count + l] = r->value[(o->first + l) * r->runs + run];
    }
    study_output_name(r->work, k, name);
    hdf5_link(f->file, place, name, link);
    const hid_t set = put_set(f, f->file, link, o->count > 1 ? 2 : 1, shape, H5T_IEEE_F64LE,
                              H5T_NATIVE_DOUBLE, transposed);
    describe_set(f, set, "output", name, study_output_unit(r->work, k));
    note_set(f, hdf5_put(set, "column", H5T_STD_I32LE, H5T_NATIVE_INT, &place));
    note_set(f, hdf5_put_text(set, "of", o->column));
    if (o->times > 0 && !f->bad) {
        char of_times[HDF5_LINK + 16];
        snprintf(of_times, sizeof of_times, "times of %.230s", link);
        H5Dclose(
            put_set(f, f->file, of_times, 1, &times, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, o->time));
    }
    H5Dclose(set);
    if (!f->bad) put_statistics(f, o, link, transposed);
}

static void put_outcomes(study_file *f)
{
    const study_results *r = f->results;
    const hsize_t runs = (hsize_t)r->runs, failures = (hsize_t)r->failures;
    H5Dclose(put_set(f, f->file, "outcome", 1, &runs, H5T_STD_I32LE, H5T_NATIVE_INT, r->outcome));
    H5Dclose(put_set(f, f->file, "status", 1, &runs, H5T_STD_I32LE, H5T_NATIVE_INT, r->status));
    H5Dclose(put_set(f, f->file, "steps", 1, &runs, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, r->steps));
    const hid_t type = hdf5_text_type(MBSR_TEXT_SIZE);
    if (failures > 0) {
        H5Dclose(
            put_set(f, f->file, "failed", 1, &failures, H5T_STD_I64LE, H5T_NATIVE_LONG, r->failed));
        H5Dclose(put_set(f, f->file, "failed_text", 1, &failures, type, type, r->text));
    }
    H5Tclose(type);
}

static void put_study(study_file *f)
{
    const study_work *w = f->results->work;
    char hash[MODEL_HASH], number[24];
    model_hash(&w->m, hash);
    note_set(f, hdf5_put_text(f->file, "format", HDF5_STUDY_FORMAT));
    note_set(f, hdf5_put_text(f->file, "version", mbsr_version()));
    note_set(f, hdf5_put_text(f->file, "study", w->study->name));
    note_set(f, hdf5_put_text(f->file, "model", w->path));
    note_set(f, hdf5_put_text(f->file, "model_hash", hash));
    snprintf(number, sizeof number, "%016" PRIx64, w->key);
    note_set(f, hdf5_put_text(f->file, "key", number));
    note_set(f, hdf5_put_text(f->file, "sampling", mbsr_sampling_name(w->study->sampling)));
    snprintf(number, sizeof number, "%" PRIu64, w->study->seed);
    note_set(f, hdf5_put_text(f->file, "seed", number));
    note_set(f, hdf5_put_text(f->file, "outcomes",
                              "0 done 1 failed 2 steps 3 time 4 crashed 5 missing"));
}

static void put_study_file(study_file *f)
{
    const mbsr_study *s = f->results->work->study;
    int widest = 1;
    for (int k = 0; k < s->outputs; ++k)
        widest = s->output[k].count > widest ? s->output[k].count : widest;
    double *transposed = calloc((size_t)widest * (size_t)f->results->runs, sizeof *transposed);
    f->statistics = H5Gcreate2(f->file, "statistics", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    note_set(f, transposed && f->statistics >= 0);
    if (!f->bad) put_study(f);
    if (!f->bad) put_outcomes(f);
    if (!f->bad) put_parameters(f);
    for (int k = 0; k < s->outputs && !f->bad; ++k) put_output(f, k, transposed);
    H5Gclose(f->statistics);
    free(transposed);
}

int hdf5_write_study(const study_results *r, const char *path)
{
    study_file f = {.results = r, .statistics = H5I_INVALID_HID};
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    f.file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    note_set(&f, f.file >= 0);
    if (!f.bad) put_study_file(&f);
    if (f.file >= 0) note_set(&f, H5Fflush(f.file, H5F_SCOPE_GLOBAL) >= 0);
    if (f.file >= 0) note_set(&f, H5Fclose(f.file) >= 0);
    return f.bad ? complain(FAILED, "%s cannot be written: %s", path, f.reason) : DONE;
}
