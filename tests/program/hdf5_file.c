/* HDF5 files of runs, by the HDF5 library alone: what mbsrank has written becomes CSV, and files
 * are made that it must refuse.
 * SPDX-License-Identifier: BSD-3-Clause
 * Usage: hdf5_file csv FILE all
 * data sets by their attribute `column` hdf5_file attribute FILE NAME         of the file, or of
 * data set SET as SET/NAME hdf5_file shorten FILE SET            by one number hdf5_file put FILE
 * SET INDEX NUMBER hdf5_file foreign FILE                makes one that is no run hdf5_file drop
 * FILE SET               without that set; hdf5_file matrix FILE NAME    as CSV behind a head line
 */
#include <hdf5.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 100 };

static void require(int good, const char *what)
{
    if (good) return;
    fprintf(stderr, "hdf5_file: %s\n", what);
    exit(1);
}

static hsize_t size_of(hid_t set)
{
    hsize_t size = 0;
    const hid_t space = H5Dget_space(set);
    require(H5Sget_simple_extent_dims(space, &size, NULL) == 1, "no vector");
    H5Sclose(space);
    return size;
}

/* A text, or a number. */
static void print_attribute(hid_t of, const char *name)
{
    const hid_t attribute = H5Aopen(of, name, H5P_DEFAULT), type = H5Aget_type(attribute);
    require(attribute >= 0, name);
    if (H5Tget_class(type) == H5T_STRING) {
        char *text = NULL;
        require(H5Aread(attribute, type, &text) >= 0, name);
        puts(text);
        H5free_memory(text);
    } else {
        double number;
        require(H5Aread(attribute, H5T_NATIVE_DOUBLE, &number) >= 0, name);
        printf("%.17g\n", number);
    }
    H5Tclose(type);
    H5Aclose(attribute);
}

typedef struct sets {
    double *values[MOST];
    char name[MOST][64];
    hsize_t lines;
    int count;
} sets;

static herr_t collect(hid_t file, const char *link, const H5L_info_t *info, void *user)
{
    sets *all = user;
    int column = -1;
    char *name = NULL;
    const hid_t set = H5Dopen2(file, link, H5P_DEFAULT), at = H5Aopen(set, "column", H5P_DEFAULT),
                named = H5Aopen(set, "name", H5P_DEFAULT), type = H5Aget_type(named);
    (void)info;
    require(H5Aread(at, H5T_NATIVE_INT, &column) >= 0 && column >= 0 && column < MOST, "column");
    require(H5Aread(named, type, &name) >= 0, "name");
    snprintf(all->name[column], sizeof all->name[column], "%s", name);
    H5free_memory(name);
    all->lines = size_of(set);
    all->values[column] = malloc((size_t)all->lines * sizeof(double) + 1);
    require(all->values[column] && H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                           all->values[column]) >= 0,
            link);
    ++all->count;
    H5Tclose(type);
    H5Aclose(named);
    H5Aclose(at);
    H5Dclose(set);
    return 0;
}

static void print_csv(hid_t file)
{
    static sets all;
    require(H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, NULL, collect, &all) >= 0, "data sets");
    for (int k = 0; k < all.count; ++k) printf(k > 0 ? ",%s" : "%s", all.name[k]);
    putchar('\n');
    for (hsize_t l = 0; l < all.lines; ++l) {
        for (int k = 0; k < all.count; ++k) printf(k > 0 ? ",%.17g" : "%.17g", all.values[k][l]);
        putchar('\n');
    }
    for (int k = 0; k < all.count; ++k) free(all.values[k]);
}

static void put(hid_t set, hsize_t at, double number)
{
    const hsize_t one = 1;
    const hid_t there = H5Dget_space(set), here = H5Screate_simple(1, &one, NULL);
    H5Sselect_hyperslab(there, H5S_SELECT_SET, &at, NULL, &one, NULL);
    require(H5Dwrite(set, H5T_NATIVE_DOUBLE, here, there, H5P_DEFAULT, &number) >= 0, "put");
    H5Sclose(here);
    H5Sclose(there);
}

static void print_matrix(hid_t file, const char *name)
{
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);
    hsize_t size[2];
    require(H5Sget_simple_extent_ndims(space) == 2 &&
                H5Sget_simple_extent_dims(space, size, NULL) == 2,
            "no matrix");
    double *x = calloc((size_t)(size[0] * size[1]) + 1, sizeof *x);
    require(x && H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, x) >= 0, name);
    printf("# %s %d %d\n", name, (int)size[0], (int)size[1]);
    for (hsize_t i = 0; i < size[0]; ++i) {
        for (hsize_t j = 0; j < size[1]; ++j)
            printf(j > 0 ? ",%.17g" : "%.17g", x[i * size[1] + j]);
        putchar('\n');
    }
    free(x);
    H5Sclose(space);
    H5Dclose(set);
}

int main(int argc, char **argv)
{
    require(argc > 2, "usage: see the source");
    const char *what = argv[1], *name = argc > 3 ? argv[3] : "";
    const int foreign = strcmp(what, "foreign") == 0;
    const hid_t file = foreign ? H5Fcreate(argv[2], H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)
                               : H5Fopen(argv[2], H5F_ACC_RDWR, H5P_DEFAULT);
    require(file >= 0, argv[2]);
    if (strcmp(what, "csv") == 0) {
        print_csv(file);
    } else if (strcmp(what, "attribute") == 0) {
        const char *own = strrchr(name, '/');
        char set[100];
        snprintf(set, sizeof set, "%.*s", own ? (int)(own - name) : 0, name);
        const hid_t of = own ? H5Dopen2(file, set, H5P_DEFAULT) : file;
        print_attribute(of, own ? own + 1 : name);
        if (own) H5Dclose(of);
    } else if (strcmp(what, "matrix") == 0) {
        print_matrix(file, name);
    } else if (strcmp(what, "drop") == 0) {
        require(H5Ldelete(file, name, H5P_DEFAULT) >= 0, name);
    } else if (!foreign) {
        const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
        require(set >= 0, name);
        const hsize_t size = size_of(set) - 1;
        if (argc > 5)
            put(set, (hsize_t)atoi(argv[4]), strtod(argv[5], NULL));
        else
            require(H5Dset_extent(set, &size) >= 0, name);
        H5Dclose(set);
    }
    return H5Fclose(file) < 0;
}
