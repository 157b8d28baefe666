/* HDF5: attributes, names, and why something went wrong.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_HDF5_TEXTS_H
#define MBSRANK_HDF5_TEXTS_H

#include <hdf5.h>
#include <stdbool.h>

enum { HDF5_REASON = 160 };

/* The type of texts of `size` bytes, H5T_VARIABLE: of any length, in UTF-8; to be closed.
 * Invalid where there is none: one of HDF5 itself is of one letter. */
static inline hid_t hdf5_text_type(size_t size)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    const bool good = H5Tset_size(type, size) >= 0 &&
                      (size != H5T_VARIABLE || H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
    if (good || type < 0) return type;
    H5Tclose(type);
    return H5I_INVALID_HID;
}

/* An attribute; false: it could not be written. */
bool hdf5_put(hid_t of, const char *name, hid_t stored, hid_t given, const void *value);
bool hdf5_put_text(hid_t of, const char *name, const char *text);

/* A text of an attribute, to be freed; NULL: there is none of that name. */
char *hdf5_get_text(hid_t of, const char *name);
bool hdf5_get_int(hid_t of, const char *name, int *value);

/* The data set of that name, to be closed, and its attribute "column". Invalid: it is somebody's
 * own, or, with *bad, there but not readable. */
hid_t hdf5_open_column(hid_t file, const char *name, int *number, bool *bad);

/* The name of set k in a file or group, where '/' would be a group and no name is there twice. */
enum { HDF5_LINK = 256 };
void hdf5_link(hid_t file, int k, const char *name, char to[HDF5_LINK]);

/* Why the last call has failed, in HDF5's own words. */
void hdf5_reason(char to[HDF5_REASON]);

#endif
